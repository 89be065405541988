// Explanations of configs, options and words of the tables.
#include "explanations.hpp"

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <CLI/CLI.hpp>

#include "foreign_options.hpp"
#include "terms.hpp"
import camber.app_shell;
import camber.commands;
import camber.config;
import camber.core;
import camber.run;

namespace camber::app {

namespace {

constexpr std::size_t most_suggestions = 3;

std::string in_small_letters(std::string_view word) {
    std::string small(word);
    for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return small;
}

std::string type_of(const CLI::Option& option) {
    if (option.get_items_expected_max() == 0) return "a flag";
    return option.get_option_text().empty() ? option.get_type_name() : option.get_option_text();
}

/// The commands that have the option with one and the same text.
struct OptionUse {
    std::string text, type, default_value;
    std::vector<std::string> verbs;
};

std::vector<OptionUse> uses_of(const CLI::App& app, const std::string& name) {
    std::vector<OptionUse> uses;
    for (const CLI::App* const verb : app.get_subcommands({})) {
        const CLI::Option* const option = verb->get_option_no_throw("--" + name);
        if (option == nullptr || option->get_positional()) continue;
        const OptionUse use{option->get_description(), type_of(*option), option->get_default_str(), {}};
        const auto same = std::ranges::find_if(uses, [&](const OptionUse& other) {
            return other.text == use.text && other.type == use.type && other.default_value == use.default_value;
        });
        auto& found = same == uses.end() ? uses.emplace_back(use) : *same;
        found.verbs.push_back(verb->get_name());
    }
    return uses;
}

std::string joined(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
    return text;
}

/// An indented paragraph.
std::string paragraph(const std::string& text) {
    constexpr std::size_t indent = 2;
    return std::string(indent, ' ') + wrapped(text, text_width() - indent, indent) + "\n";
}

std::string option_text(const CLI::App& app, const std::string& name) {
    std::string text;
    for (const OptionUse& use : uses_of(app, name)) {
        text += (text.empty() ? "" : "\n") + ("--" + name + ", an option of camber " + joined(use.verbs) + "\n\n");
        text += paragraph(use.text) + "\n" + paragraph("Value: " + use.type);
        if (!use.default_value.empty()) text += paragraph("Default: " + use.default_value);
    }
    return text;
}

/// Long names of all options, without dashes.
std::vector<std::string> option_names(const CLI::App& app) {
    std::set<std::string> names;
    for (const CLI::App* const verb : app.get_subcommands({}))
        for (const CLI::Option* const option : verb->get_options())
            for (const std::string& name : option->get_lnames())
                if (!name.starts_with("help")) names.insert(name);
    return {names.begin(), names.end()};
}

std::string term_text(const Term& term) {
    return std::string(term.names.substr(0, term.names.find('|'))) + "\n\n" + paragraph(std::string(term.text));
}

/// Fields of report.json, by their key, the path to it or the words of the table: "min_scaled_jacobian".
std::string report_key_text(std::string name) {
    std::ranges::replace(name, ' ', '_');
    std::map<std::string_view, std::vector<run::ReportKey>> by_meaning;
    for (const run::ReportKey& key : run::report_keys())
        if (key.path == name || key.path.ends_with("." + name)) by_meaning[key.meaning].push_back(key);
    std::string text;
    for (const auto& [meaning, keys] : by_meaning) {
        std::vector<std::string> paths;
        for (const run::ReportKey& key : keys) paths.push_back(key.path);
        text += (text.empty() ? "" : "\n") + (joined(paths) + " of report.json\n\n") + paragraph(std::string(meaning));
        if (!keys.front().unit.empty()) text += paragraph("Unit: " + std::string(keys.front().unit));
    }
    return text;
}

std::vector<std::string> all_words(const CLI::App& app) {
    std::vector<std::string> words = config::topics();
    const auto options = option_names(app);
    words.insert(words.end(), options.begin(), options.end());
    for (const Term& term : all_terms()) words.emplace_back(term.names.substr(0, term.names.find('|')));
    for (const CLI::App* const verb : app.get_subcommands({})) words.push_back(verb->get_name());
    std::ranges::sort(words);
    words.erase(std::ranges::unique(words).begin(), words.end());
    return words;
}

std::string list_of(const std::string& title, const std::vector<std::string>& words) {
    return title + ":\n" + paragraph(joined(words)) + "\n";
}

/// Successors of a name of earlier versions, each once; of an option those of the command line alone.
std::vector<std::string> new_names(std::string_view name, bool is_option) {
    std::vector<std::string> names;
    for (const config::Rename& r : config::renames)
        if (r.old_name == name && (r.kind == config::NameKind::argument || !is_option))
            names.push_back((r.kind == config::NameKind::argument ? "--" : "") + std::string(r.new_name));
    std::ranges::sort(names);
    names.erase(std::ranges::unique(names).begin(), names.end());
    return names;
}

}  // namespace

camber::Outcome<std::string> explanation_of(const CLI::App& app, std::string_view word) {
    const bool is_option = word.starts_with('-');
    std::string name(word.substr(std::min(word.find_first_not_of('-'), word.size())));
    name.erase(std::min(name.find('='), name.size()));
    if (is_option && name == "o") name = "output";
    std::string text;
    const auto add = [&](const std::string& part) {
        if (!part.empty()) text += (text.empty() ? "" : "\n") + part;
    };
    if (!is_option)
        if (const auto topic = config::explain(name)) add(*topic);
    add(option_text(app, name));
    if (!is_option)
        if (const Term* const term = find_term(in_small_letters(name))) add(term_text(*term));
    if (!is_option) add(report_key_text(in_small_letters(name)));
    if (!text.empty()) return text;
    if (const auto now = new_names(name, is_option); !now.empty())
        return camber::fail(camber::ErrorKind::usage, "was renamed to " + config::alternatives_text(now),
                            camber::shortened(word), {}, "see: camber explain " + now.front());
    const auto foreign = is_option ? find_foreign_option(name) : std::nullopt;
    if (foreign)
        return camber::fail(camber::ErrorKind::usage, "is not an option of Camber", camber::shortened(word), {},
                            foreign->remedy);
    const auto near = config::nearest_words(name, all_words(app), most_suggestions);
    return camber::fail(camber::ErrorKind::usage, "unknown topic", camber::shortened(word), {},
                        near.empty() ? "camber explain without a word lists all"
                                     : "did you mean " + config::alternatives_text(near) + "?");
}

std::string list_explained_words(const CLI::App& app) {
    std::string text = "camber explain WORD explains a word of these groups.\n\n";
    for (const config::TopicGroup& group : config::topic_groups()) text += list_of(group.title, group.topics);
    std::map<std::string, std::set<std::string>> options;
    for (const CLI::App* const verb : app.get_subcommands({}))
        for (const CLI::Option* const option : verb->get_options())
            for (const std::string& name : option->get_lnames())
                if (!name.starts_with("help")) options[option->get_group()].insert("--" + name);
    for (const auto& [group, names] : options) text += list_of(group + " options", {names.begin(), names.end()});
    std::vector<std::string> terms;
    for (const Term& term : all_terms()) terms.emplace_back(term.names.substr(0, term.names.find('|')));
    text += list_of("Words of the tables", terms);
    text.pop_back();
    return text;
}

camber::Outcome<std::string> help_text_of(const CLI::App& app, const std::string& name) {
    const auto formatter = app.get_formatter();
    if (name.empty()) return formatter->make_help(&app, app.get_name(), CLI::AppFormatMode::Normal);
    for (const CLI::App* const verb : app.get_subcommands({}))
        if (verb->get_name() == name)
            return formatter->make_help(verb, app.get_name() + " " + name, CLI::AppFormatMode::Normal);
    if (auto text = explanation_of(app, name)) return text;
    std::vector<std::string> verbs;
    for (const CLI::App* const verb : app.get_subcommands({})) verbs.push_back(verb->get_name());
    if (const auto foreign = find_foreign_command(name))
        return camber::fail(camber::ErrorKind::usage, "is not a command", camber::shortened(name), {}, foreign->remedy);
    return camber::fail(camber::ErrorKind::usage, "is not a command", camber::shortened(name), {},
                        suggestion(name, verbs));
}

}  // namespace camber::app
