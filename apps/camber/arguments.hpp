#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>
#include <CLI/CLI.hpp>

#include "program.hpp"
import camber.core;
import camber.commands;
import camber.config;
import camber.recipes;
import camber.io;

namespace camber::app {

// ---------------------------------------------------------------- types of arguments
// Functions of the parser are inline. A unit that calls only the functions below does not compile the parser again.

void add_details(CLI::App* verb, const std::string& text);
/// Instantiated for the types in arguments.cpp.
template <class T>
CLI::Option* add_option(CLI::App* verb, const std::string& name, T& value, const std::string& text);
/// Passes the values to `take`.
CLI::Option* add_option(CLI::App* verb, const std::string& name, const CLI::callback_t& take, const std::string& text);
CLI::Option* add_flag(CLI::App* verb, const std::string& name, bool& value, const std::string& text);

/// Name without dashes; also of positional arguments.
[[nodiscard]] std::string long_name(const CLI::Option& option);

[[nodiscard]] std::string joined(const std::vector<std::string>& words, std::string_view separator = ", ");

std::string endings_of_input();
std::string endings_of_output();
std::string endings_of_solutions();
std::string mesh_or_solution();
std::vector<std::string> mesh_format_names();
std::vector<std::string> field_format_names();

CLI::Validator within(const Limits& limits, bool is_whole);
CLI::Validator zero_or(const Limits& limits);
template <class T>
CLI::Validator within(const Limits& limits) {
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

/// Replaces the value `none` by the text.
CLI::Validator none_as(const std::string& text);

/// The error suggests the nearest name.
CLI::Validator one_of(const std::vector<std::string>& names);

/// Capitalises an option's description.
std::string help_of(std::string_view sentence);
std::string help_of(const auto& option) { return help_of(option.sentence); }

template <class T, class S, class V>
void add_described(CLI::App* verb, S& options, const Option<S, V>& option) {
    std::string name(option.name);
    for (char& c : name) c = c == '_' ? '-' : c;
    add_option(verb, "--" + name, options.*option.member, help_of(option))
        ->check(within<T>(option.limits))
        ->capture_default_str();
}

/// Calls `set` with the index of the word.
void add_words(CLI::App* verb, const std::string& name, const std::string& sentence,
               const std::vector<std::string>& words, const std::function<void(std::size_t)>& set);
/// Accepts the words of an enumeration; `value` may be optional.
template <class T>
void add_words(CLI::App* verb, const std::string& name, T& value, const std::string& sentence) {
    using E = typename CLI::detail::wrapped_type<T, T>::type;
    add_words(verb, name, sentence, all_words<E>(), [&value](std::size_t i) { value = words(E{})[i].value; });
}

/// T is int or std::optional<int>.
template <class T>
void add_threads(CLI::App* verb, T& threads) {
    add_option(verb, "--threads", threads, "Number of threads; 0: all. The result does not depend on it")
        ->check(at_least<double>(0));
}

void add_mesh(CLI::App* verb, std::string& input);
void add_format(CLI::App* verb, std::string& format, const std::vector<std::string>& names);
void add_flat(CLI::App* verb, config::Flat& flat);
void add_read(CLI::App* verb, DecodeOptions& options);
void add_sizes(CLI::App* verb, std::vector<std::string>& sizes);
void add_metric(CLI::App* verb, MetricChoice& choice);
void add_gradation(CLI::App* verb, std::optional<double>& gradation);
void add_geometry(CLI::App* verb, GeometryArguments& arguments);
void add_geometry_tolerance(CLI::App* verb, GeometryArguments& arguments);
/// Adds --min-scaled-jacobian.
void add_bound(CLI::App* verb, PipelineArguments& arguments);
void add_fields(CLI::App* verb, SolutionChoice& solution);
void add_partition(CLI::App* verb, PipelineArguments& arguments);
void add_force(CLI::App* verb, bool& force);
void add_histogram(CLI::App* verb, bool& histogram);
void add_settings(CLI::App* verb, std::vector<std::string>& settings, std::optional<int>& threads, bool& print_config,
                  bool& dry_run);
/// Adds the options of all pipeline verbs, except those for fields.
void add_pipeline(CLI::App* verb, PipelineArguments& arguments);

Work declare_run(CLI::App* verb, Arguments& all);
Work declare_curve(CLI::App* verb, Arguments& all);
Work declare_repair(CLI::App* verb, Arguments& all);
Work declare_remesh(CLI::App* verb, Arguments& all);
Work declare_adapt(CLI::App* verb, Arguments& all);

Work declare_metric(CLI::App* verb, Arguments& all);
Work declare_transfer(CLI::App* verb, Arguments& all);
Work declare_convert(CLI::App* verb, Arguments& all);
Work declare_generate(CLI::App* verb, Arguments& all);

Work declare_check(CLI::App* verb, Arguments& all);
Work declare_report(CLI::App* verb, Arguments& all);
Work declare_geometry(CLI::App* verb, Arguments& all);
Work declare_plot(CLI::App* verb, Arguments& all);
Work declare_picture(CLI::App* verb, Arguments& all);
Work declare_info(CLI::App* verb, Arguments& all);
Work declare_explain(CLI::App* verb, Arguments& all);
Work declare_help(CLI::App* verb, Arguments& all);
Work declare_schema(CLI::App* verb, Arguments& all);

}  // namespace camber::app
