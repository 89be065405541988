#pragma once
#include <CLI/CLI.hpp>

namespace camber::app {

/// Puts each option of the verbs into its group of the help: Input, Geometry, Metric, Quality, Output, Run.
void set_groups(CLI::App& app);

/// True if `--help` shows the option; `--help-all` shows all of them.
[[nodiscard]] bool is_common(const CLI::Option& option);

}  // namespace camber::app
