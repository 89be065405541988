#pragma once
// Kinds of arguments: of described options, of words, of files.
#include <cctype>
#include <map>
#include <string>
#include <CLI/CLI.hpp>

import camber.core;
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

/// Numbers within the limits of an option. Closed ones are told as CLI11 tells them.
template <class T>
CLI::Validator within(const camber::Limits& limits) {
    if (!limits.low_open && !limits.high_open)
        return CLI::Range(static_cast<T>(limits.low), static_cast<T>(limits.high));
    return CLI::Validator(
        [limits](const std::string& text) {
            double x = 0;
            const bool holds = CLI::detail::lexical_cast(text, x) && limits.hold(x);
            return holds ? std::string() : camber::out_of_limits(limits, text);
        },
        limits.interval());
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
    std::string text;
    for (const auto& w : words(E{})) {
        values.emplace(w.word, w.value);
        text += (text.empty() ? "" : "|") + std::string(w.word);
    }
    verb->add_option(name, value, sentence)->transform(CLI::CheckedTransformer(values))->option_text(text);
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
