#pragma once
// Kinds of arguments: of described options, of words, of files.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <string>
#include <type_traits>
#include <vector>
#include <CLI/CLI.hpp>

import camber.core;
import camber.commands;
import camber.config;
import camber.io;

namespace camber::app {

inline std::string endings_of_input() { return camber::listed(camber::endings_read(camber::mesh_formats()), ", "); }
inline std::string endings_of_output() { return camber::listed(camber::endings_written(camber::mesh_formats()), ", "); }
inline std::string endings_of_solutions() {
    return camber::listed(camber::endings_read(camber::solution_formats()), ", ");
}

inline std::string mesh_or_solution() {
    return "A mesh of degree 1 or 2 (" + endings_of_input() + ") or a solution (" + endings_of_solutions() + ")";
}

/// What is wrong with an option's value, and a remedy, as one text of the parser's error: `error_of` parts them again.
inline std::string with_remedy(const std::string& what, const std::string& remedy) { return what + "\n" + remedy; }

/// Numbers within limits; whole ones where T is.
template <class T>
CLI::Validator within(const camber::Limits& limits) {
    const auto check = [limits](const std::string& text) -> std::string {
        double x = 0;
        if (!CLI::detail::lexical_cast(text, x)) {
            std::string with_point = text;
            std::ranges::replace(with_point, ',', '.');
            const bool has_comma = with_point != text && CLI::detail::lexical_cast(with_point, x);
            return with_remedy(in_quotes(text) + " is no number", has_comma
                                                                      ? "write it with a point: " + with_point
                                                                      : "give one in digits, such as 0.5 or 1e-3");
        }
        if (std::is_integral_v<T> && x != std::floor(x)) return "must be a whole number, got " + shortened(text);
        return limits.hold(x) ? std::string() : camber::out_of_limits(limits, text);
    };
    return CLI::Validator(check, limits.interval());
}

template <class T>
CLI::Validator at_least(double low) {
    return within<T>({.low = low});
}
template <class T>
CLI::Validator above(double low) {
    return within<T>({.low = low, .low_open = true});
}
/// Zero, or a number within limits.
template <class T>
CLI::Validator zero_or(const camber::Limits& limits) {
    const auto check = [inner = within<T>(limits)](const std::string& text) -> std::string {
        double x = 1;
        return CLI::detail::lexical_cast(text, x) && x == 0 ? std::string() : inner(text);
    };
    return CLI::Validator(check, "0 or " + limits.interval());
}
template <class T>
CLI::Validator between(double low, double high) {
    return within<T>({.low = low, .high = high});
}

/// One of some words; else the word that may have been meant.
inline CLI::Validator one_of(const std::vector<std::string>& names) {
    return CLI::Validator(
        [names](const std::string& text) -> std::string {
            if (std::ranges::find(names, text) != names.end()) return {};
            return with_remedy(in_quotes(text) + " is none of its words", suggestion(text, names));
        },
        "");
}

inline std::vector<std::string> mesh_format_names() {
    const auto names = camber::names_written(camber::mesh_formats());
    return {names.begin(), names.end()};
}
/// Of formats that hold fields at nodes.
inline std::vector<std::string> field_format_names() {
    const auto of_solutions = camber::names_written(camber::solution_formats());
    std::vector<std::string> names(of_solutions.begin(), of_solutions.end());
    for (const camber::MeshFormat& format : camber::mesh_formats())
        if (format.encode && format.holds_fields) names.emplace_back(format.name);
    return names;
}

inline void add_format(CLI::App* verb, std::string& format, const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    verb->add_option("--format", format,
                     "The output's format by its name, whatever its ending (" + text +
                         "); - as the output, standard output, needs it")
        ->check(one_of(names))
        ->option_text("NAME");
}

/// An option's sentence as a help text has it.
inline std::string help_of(const auto& option) {
    std::string sentence(option.sentence);
    sentence.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(sentence.front())));
    return sentence;
}

/// A described option of a struct as an argument of the same name, with its sentence, limits and default.
template <class T, class S, class V>
void add_described(CLI::App* verb, S& options, const camber::Option<S, V>& option) {
    std::string name(option.name);
    for (char& c : name) c = c == '_' ? '-' : c;
    verb->add_option("--" + name, options.*option.member, help_of(option))
        ->check(within<T>(option.limits))
        ->capture_default_str();
}

/// An argument that takes the words of an enumeration.
template <class T>
void add_words(CLI::App* verb, const std::string& name, T& value, const std::string& sentence) {
    using E = typename CLI::detail::wrapped_type<T, T>::type;
    std::map<std::string, E> values;
    std::vector<std::string> names;
    std::string text;
    for (const auto& w : words(E{})) {
        values.emplace(w.word, w.value);
        names.emplace_back(w.word);
        text += (text.empty() ? "" : "|") + std::string(w.word);
    }
    // What is added last is asked first.
    verb->add_option(name, value, sentence)
        ->transform(CLI::Transformer(values))
        ->transform(one_of(names))
        ->option_text(text);
}

/// An int, or an optional one.
template <class T>
void add_threads(CLI::App* verb, T& threads) {
    verb->add_option("--threads", threads, "Threads to use; 0: all. The result does not depend on it")
        ->check(at_least<double>(0));
}

inline void add_flat(CLI::App* verb, camber::config::Flat& flat) {
    add_words(verb, "--flat", flat,
              "What triangles without tetrahedra and of one z are: plane (the default), a 2D mesh, written with its z "
              "again; or surface, one in space");
}

inline void add_read(CLI::App* verb, camber::DecodeOptions& options) {
    verb->add_option("--reference-array", options.reference_array,
                     "The array of cells that has their references (.vtu, .vtk). Default: reference, or one that other "
                     "programs have for that (material, region …)");
    verb->add_option("--zone", options.zone,
                     "The zone to read, by its number or name (.su2, .cgns). Default: all, joined into one mesh");
}

}  // namespace camber::app
