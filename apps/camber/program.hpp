#pragma once
#include <memory>
#include <optional>
#include <span>
import camber.distributed;

namespace camber::app {

/// Where the program was started to be something else, a reader of CAD files for itself: that, and its exit code.
[[nodiscard]] std::optional<int> other_task(std::span<char*> arguments);

/// What the command line says, on this rank. All ranks are given the same line; the first of them speaks, and all end
/// with the same exit code. `partition`: what partitions the graphs that they hold, if anything does.
[[nodiscard]] int run_program(std::span<char*> arguments, const std::shared_ptr<Ranks>& ranks,
                              const GraphPartitioner& partition = {});

}  // namespace camber::app
