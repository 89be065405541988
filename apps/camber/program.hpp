#pragma once
// Verbs of the program: parses a command line into arguments and runs it.
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace CLI {
class App;
}

import camber.core;
import camber.commands;
import camber.config;
import camber.recipes;
import camber.distributed;

namespace camber::app {

struct Arguments {
    RunArguments run;
    CurveArguments curve;
    RemeshArguments remesh;
    AdaptArguments adapt;
    RepairArguments repair;
    ConvertArguments convert;
    GenerateArguments generate;
    PlotArguments plot;
    PictureArguments picture;
    CheckArguments check;
    ReportArguments report;
    GeometryCommandArguments geometry;
    MetricArguments metric;
    TransferArguments transfer;
    InfoArguments info;
    std::string topic, help_of, schema;
};

struct Work {
    std::function<Outcome<int>(const Host&)> run;  ///< returns the exit code
    /// Empty: the verb runs no pipeline.
    std::function<Outcome<config::Pipeline>()> pipeline = {};
};

enum class VerbGroup {
    by_blocks,    ///< processes blocks, also on several ranks
    on_one_rank,  ///< other verbs that write files or reports
    data,         ///< only prints data: no --quiet or --verbose
};

struct Verb {
    std::string_view name;
    VerbGroup group;
    std::string_view summary;  ///< first sentence of its help
    /// Adds arguments to the parser, with their values in `arguments`.
    Work (*declare)(CLI::App* verb, Arguments& arguments);
};

[[nodiscard]] std::span<const Verb> verbs();

/// A parsed command line.
struct Call {
    const Verb* verb = nullptr;
    Arguments arguments = {};
    Work work = {};  ///< refers to the arguments and to the parser
    std::shared_ptr<const CLI::App> parser = {};
};

/// Parses a command line: {"curve", "wing.meshb", "--metric", "0.1", "-o", …}. Errors: usage.
[[nodiscard]] Outcome<std::unique_ptr<Call>> call_of(std::vector<std::string> words);

/// Describes the arguments of all verbs as JSON: {"curve": {"about": …, "arguments": [{"name", "help", "positional",
/// "required", "type", "default", "flag", "many"} …]} …}. Names are long names without dashes.
[[nodiscard]] std::string arguments_json();

/// Runs the command line, which all ranks share, and returns the common exit code. The first rank prints. `partition`
/// partitions shared graphs; it may be empty.
[[nodiscard]] int run_program(std::span<char*> arguments, const std::shared_ptr<Ranks>& ranks,
                              const GraphPartitioner& partition = {});

}  // namespace camber::app
