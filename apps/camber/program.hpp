#pragma once
// The program's verbs: their arguments as values, from the words of a command line.
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

/// Values of the arguments of each verb.
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

/// Work of a verb with its arguments.
struct Work {
    std::function<Outcome<int>(const Host&)> run;  ///< returns the exit code
    /// The pipeline that the verb runs; empty: the verb runs none.
    std::function<Outcome<config::Pipeline>()> pipeline = {};
};

enum class VerbGroup {
    by_blocks,    ///< the work goes by blocks of the mesh, which several ranks share
    on_one_rank,  ///< all others that write files or reports
    data,         ///< prints data alone, on one rank: has no --quiet and --verbose
};

struct Verb {
    std::string_view name;
    VerbGroup group;
    std::string_view summary;  ///< the first sentence of its help
    /// Adds the arguments to the parser; `arguments` stores their values.
    Work (*declare)(CLI::App* verb, Arguments& arguments);
};

/// The table of verbs, in the order of the help.
[[nodiscard]] std::span<const Verb> verbs();

/// A parsed command line.
struct Call {
    const Verb* verb = nullptr;
    Arguments arguments = {};
    Work work = {};  ///< refers to the arguments and to the parser
    std::shared_ptr<const CLI::App> parser = {};
};

/// Parses words as on the command line: {"curve", "wing.meshb", "--metric", "0.1", "-o", …}. Errors: usage, with the
/// messages of the program.
[[nodiscard]] Outcome<std::unique_ptr<Call>> call_of(std::vector<std::string> words);

/// Arguments of the verbs as JSON: {"curve": {"about": …, "arguments": [{"name", "help", "positional", "required",
/// "type", "default", "flag", "many"} …]} …}. Names are the long ones, without dashes.
[[nodiscard]] std::string arguments_json();

/// Runs the command line on this rank. All ranks have the same line; the first of them prints, and all return the same
/// exit code. `partition` partitions the graphs that they share; empty: nothing does.
[[nodiscard]] int run_program(std::span<char*> arguments, const std::shared_ptr<Ranks>& ranks,
                              const GraphPartitioner& partition = {});

}  // namespace camber::app
