#pragma once
// Kinds of arguments: of described options, of words, of files.
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>
#include <CLI/CLI.hpp>

import camber.core;
import camber.commands;
import camber.config;
import camber.recipes;
import camber.io;

namespace camber::app {

// The parser's own functions are inline: a unit that calls these alone does not compile the parser again.

CLI::App* add_verb(CLI::App& app, const std::string& name, const std::string& text);
/// For the types that argument_kinds.cpp lists.
template <class T>
CLI::Option* add_option(CLI::App* verb, const std::string& name, T& value, const std::string& text);
/// An argument whose values are passed to a function.
CLI::Option* add_option(CLI::App* verb, const std::string& name, const CLI::callback_t& take, const std::string& text);
CLI::Option* add_flag(CLI::App* verb, const std::string& name, bool& value, const std::string& text);

std::string endings_of_input();
std::string endings_of_output();
std::string endings_of_solutions();
std::string mesh_or_solution();

/// Numbers within limits.
CLI::Validator within(const camber::Limits& limits, bool is_whole);
/// Zero, or a number within limits.
CLI::Validator zero_or(const camber::Limits& limits);
/// Numbers within limits; whole ones where T is.
template <class T>
CLI::Validator within(const camber::Limits& limits) {
    return within(limits, std::is_integral_v<T>);
}
template <class T>
CLI::Validator at_least(double low) {
    return within<T>({.low = low});
}
template <class T>
CLI::Validator above(double low) {
    return within<T>({.low = low, .low_open = true});
}
template <class T>
CLI::Validator between(double low, double high) {
    return within<T>({.low = low, .high = high});
}

/// Reads the word none as another text.
CLI::Validator none_as(const std::string& text);

/// One of some words; else the word that may have been meant.
CLI::Validator one_of(const std::vector<std::string>& names);

std::vector<std::string> mesh_format_names();
/// Of formats that hold fields at nodes.
std::vector<std::string> field_format_names();

void add_format(CLI::App* verb, std::string& format, const std::vector<std::string>& names);

/// An option's sentence as a help text has it.
std::string help_of(std::string_view sentence);
std::string help_of(const auto& option) { return help_of(option.sentence); }

/// A described option of a struct as an argument of the same name, with its sentence, limits and default.
template <class T, class S, class V>
void add_described(CLI::App* verb, S& options, const camber::Option<S, V>& option) {
    std::string name(option.name);
    for (char& c : name) c = c == '_' ? '-' : c;
    add_option(verb, "--" + name, options.*option.member, help_of(option))
        ->check(within<T>(option.limits))
        ->capture_default_str();
}

/// An argument that takes one of these words, and calls set(its position).
void add_words(CLI::App* verb, const std::string& name, const std::string& sentence,
               const std::vector<std::string>& words, const std::function<void(std::size_t)>& set);
/// An argument that takes the words of an enumeration; `value` may be optional.
template <class T>
void add_words(CLI::App* verb, const std::string& name, T& value, const std::string& sentence) {
    using E = typename CLI::detail::wrapped_type<T, T>::type;
    add_words(verb, name, sentence, camber::all_words<E>(), [&value](std::size_t i) { value = words(E{})[i].value; });
}

/// An int, or an optional one.
template <class T>
void add_threads(CLI::App* verb, T& threads) {
    add_option(verb, "--threads", threads, "Threads to use; 0: all. The result does not depend on it")
        ->check(at_least<double>(0));
}

void add_flat(CLI::App* verb, camber::config::Flat& flat);
void add_read(CLI::App* verb, camber::DecodeOptions& options);

}  // namespace camber::app
