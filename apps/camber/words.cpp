// A verb's arguments out of words, and what they are: for programs in other languages.
#include "words.hpp"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "usage.hpp"
import camber.core;

namespace camber::app {

namespace {

using Json = nlohmann::ordered_json;

std::string name_of(const CLI::Option& option) {
    return option.get_lnames().empty() ? option.get_name() : option.get_lnames().front();
}

Json described(const CLI::Option& option) {
    Json json{{"name", name_of(option)}, {"help", option.get_description()}};
    json["positional"] = option.get_positional();
    json["required"] = option.get_required();
    json["type"] = option.get_option_text().empty() ? option.get_type_name() : option.get_option_text();
    json["default"] = option.get_default_str();
    json["flag"] = option.get_items_expected_max() == 0;
    json["many"] = option.get_items_expected_max() > 1;
    return json;
}

}  // namespace

camber::Outcome<std::unique_ptr<Verb>> verb_of(std::vector<std::string> words) {
    auto verb = std::make_unique<Verb>();
    const auto app = program_of(*verb);
    if (const auto unknown = check_words(*app, words)) return camber::fail(*unknown);
    try {
        std::ranges::reverse(words);  // the parser takes them from the end
        app->parse(std::move(words));
    } catch (const CLI::Success&) {
        return camber::fail(camber::ErrorKind::usage, "is a question, and no argument", "--help");
    } catch (const CLI::ParseError& error) {
        return camber::fail(usage_error(*app, error));
    }
    return verb;
}

std::string arguments_json() {
    Verb verb;
    const auto app = program_of(verb);
    Json json = Json::object();
    for (const CLI::App* sub : app->get_subcommands({})) {
        Json arguments = Json::array();
        for (const CLI::Option* option : sub->get_options())
            if (!option->get_single_name().starts_with("help")) arguments.push_back(described(*option));
        json[sub->get_name()] = {{"about", sub->get_description()}, {"arguments", std::move(arguments)}};
    }
    return json.dump(1);
}

}  // namespace camber::app
