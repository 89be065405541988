#pragma once
#include <memory>
#include <string>
#include <vector>

#include "arguments.hpp"
import camber.core;

namespace camber::app {

/// A verb's arguments out of words, as on the command line: {"curve", "wing.meshb", "--metric", "0.1", "-o", …}.
/// Errors: usage, as the program tells them.
[[nodiscard]] camber::Outcome<std::unique_ptr<Verb>> verb_of(std::vector<std::string> words);

/// What the verbs take, as JSON: {"curve": {"about": …, "arguments": [{"name", "help", "type", "default", "words",
/// "interval", "many", "flag", "required"} …]} …}. Of each the long name, without dashes.
[[nodiscard]] std::string arguments_json();

}  // namespace camber::app
