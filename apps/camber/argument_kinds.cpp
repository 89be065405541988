// Kinds of arguments: their checks and texts.
#include "argument_kinds.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>
#include <CLI/CLI.hpp>

import camber.core;
import camber.config;
import camber.io;

namespace camber::app {

CLI::App* add_verb(CLI::App& app, const std::string& name, const std::string& text) {
    CLI::App* const verb = app.add_subcommand(name, text);
    verb->set_help_all_flag("--help-all", "Print the help with all options and exit");
    return verb;
}

template <class T>
CLI::Option* add_option(CLI::App* verb, const std::string& name, T& value, const std::string& text) {
    return verb->add_option(name, value, text);
}
#define CAMBER_ARGUMENT(...) \
    template CLI::Option* add_option(CLI::App*, const std::string&, __VA_ARGS__&, const std::string&);
CAMBER_ARGUMENT(int)
CAMBER_ARGUMENT(std::size_t)
CAMBER_ARGUMENT(double)
CAMBER_ARGUMENT(std::string)
CAMBER_ARGUMENT(std::optional<int>)
CAMBER_ARGUMENT(std::optional<std::size_t>)
CAMBER_ARGUMENT(std::optional<double>)
CAMBER_ARGUMENT(std::optional<std::string>)
CAMBER_ARGUMENT(std::vector<std::string>)
CAMBER_ARGUMENT(std::vector<double>)
#undef CAMBER_ARGUMENT

CLI::Option* add_option(CLI::App* verb, const std::string& name, const CLI::callback_t& take, const std::string& text) {
    return verb->add_option(name, take, text);
}

CLI::Option* add_flag(CLI::App* verb, const std::string& name, bool& value, const std::string& text) {
    return verb->add_flag(name, value, text);
}

std::string endings_of_input() { return camber::listed(camber::endings_read(camber::mesh_formats()), ", "); }
std::string endings_of_output() { return camber::listed(camber::endings_written(camber::mesh_formats()), ", "); }
std::string endings_of_solutions() { return camber::listed(camber::endings_read(camber::solution_formats()), ", "); }

std::string mesh_or_solution() {
    return "A mesh of degree 1 or 2 (" + endings_of_input() + ") or a solution (" + endings_of_solutions() + ")";
}

namespace {

/// The error of an option's value and its remedy as one text for the parser; `error_of` separates them again.
std::string with_remedy(const std::string& what, const std::string& remedy) { return what + "\n" + remedy; }

}  // namespace

CLI::Validator within(const camber::Limits& limits, bool is_whole) {
    const auto check = [limits, is_whole](const std::string& text) -> std::string {
        double x = 0;
        if (!CLI::detail::lexical_cast(text, x)) {
            std::string with_point = text;
            std::ranges::replace(with_point, ',', '.');
            const bool has_comma = with_point != text && CLI::detail::lexical_cast(with_point, x);
            return with_remedy(in_quotes(text) + " is no number", has_comma
                                                                      ? "write it with a point: " + with_point
                                                                      : "give one in digits, such as 0.5 or 1e-3");
        }
        if (is_whole && x != std::floor(x)) return "must be a whole number, got " + shortened(text);
        return limits.hold(x) ? std::string() : camber::out_of_limits(limits, text);
    };
    return CLI::Validator(check, limits.interval());
}

CLI::Validator zero_or(const camber::Limits& limits) {
    const auto check = [inner = within(limits, false)](const std::string& text) -> std::string {
        double x = 1;
        return CLI::detail::lexical_cast(text, x) && x == 0 ? std::string() : inner(text);
    };
    return CLI::Validator(check, "0 or " + limits.interval());
}
CLI::Validator none_as(const std::string& text) {
    return {[text](std::string& given) {
                if (given == "none") given = text;
                return std::string();
            },
            ""};
}

CLI::Validator one_of(const std::vector<std::string>& names) {
    return CLI::Validator(
        [names](const std::string& text) -> std::string {
            if (std::ranges::find(names, text) != names.end()) return {};
            if (const std::string now = config::new_name(config::NameKind::value, text, names); !now.empty())
                return with_remedy(in_quotes(text) + " was renamed to " + in_quotes(now), "write " + now);
            return with_remedy(in_quotes(text) + " is none of its words", suggestion(text, names));
        },
        "");
}

std::vector<std::string> mesh_format_names() {
    const auto names = camber::names_written(camber::mesh_formats());
    return {names.begin(), names.end()};
}

std::vector<std::string> field_format_names() {
    const auto of_solutions = camber::names_written(camber::solution_formats());
    std::vector<std::string> names(of_solutions.begin(), of_solutions.end());
    for (const camber::MeshFormat& format : camber::mesh_formats())
        if (format.encode && format.holds_fields) names.emplace_back(format.name);
    return names;
}

void add_format(CLI::App* verb, std::string& format, const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    add_option(verb, "--format", format,
               "The output's format by its name, whatever its ending (" + text +
                   "); - as the output, standard output, needs it")
        ->check(one_of(names))
        ->option_text("NAME");
}

std::string help_of(std::string_view text) {
    std::string sentence(text);
    sentence.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence.front())));
    return sentence;
}

void add_words(CLI::App* verb, const std::string& name, const std::string& sentence,
               const std::vector<std::string>& words, const std::function<void(std::size_t)>& set) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : "|") + word;
    const auto set_word = [words, set](const std::vector<std::string>& given) {
        set(static_cast<std::size_t>(std::ranges::find(words, given.front()) - words.begin()));
        return true;
    };
    add_option(verb, name, set_word, sentence)->transform(one_of(words))->option_text(text);
}

void add_flat(CLI::App* verb, camber::config::Flat& flat) {
    add_words(verb, "--flat", flat,
              "What triangles without tetrahedra and of one z are: plane (the default), a 2D mesh, written with its z "
              "again; or surface, one in space");
}

void add_read(CLI::App* verb, camber::DecodeOptions& options) {
    add_option(verb, "--reference-array", options.reference_array,
               "The array of cells that has their references (.vtu, .vtk). Default: reference, or one that other "
               "programs have for that (material, region …)");
    add_option(verb, "--zone", options.zone,
               "The zone to read, by its number or name (.su2, .cgns). Default: all, joined into one mesh");
}

}  // namespace camber::app
