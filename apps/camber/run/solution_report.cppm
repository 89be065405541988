module;
#include <cstddef>
#include <optional>
#include <string>
#include <vector>
export module camber.run:solution_report;
import camber.core;
import camber.transfer;

/// What is told of a solution: of the metric that was made for it, and of its way to another mesh.
export namespace camber::run {

struct SolutionMetricReport {
    int degree = 1;                    ///< of the elements that are to interpolate
    double asked = 0, complexity = 0;  ///< that was asked for, and what came out
    double elements = 0;               ///< of a mesh of that complexity, about
    double of_fixed = 0;               ///< complexity of sizes, geometry and bounds alone
    bool is_fixed_alone = false;       ///< these have all of it: the solution has no say
    bool is_reached = true;            ///< within the tolerance
    bool is_graded = true;             ///< false: a gradation ended before its time
    int evaluations = 0, gradations = 0;
    double largest_anisotropy = 1;
    double at_min = 0, at_max = 0;                                ///< shares of the vertices with a size at the bounds
    std::size_t rows = 0, from_inner_fits = 0, lower_degree = 0;  ///< of recovered derivatives
    std::size_t zero_models = 0, floored_models = 0;
    double models_max_anisotropy = 0;
    std::vector<std::string> fields_in_doubt = {};  ///< fields whose values are as unrelated as in a random order
};

struct TransferReport {
    TransferMethod method = TransferMethod::interpolate;
    std::vector<std::string> fields;
    TransferStatistics statistics;
};

/// The rows of the verbs `metric` and `transfer`.
[[nodiscard]] std::string solution_metric_rows(const SolutionMetricReport& report);
[[nodiscard]] std::string transfer_rows(const TransferReport& report);
/// What is short of what was asked for.
[[nodiscard]] std::vector<std::string> solution_metric_notices(const SolutionMetricReport& report);

}  // namespace camber::run

namespace camber::run {

/// A row of a run's table, and those of its end.
[[nodiscard]] std::string solution_metric_row(const SolutionMetricReport& report);
[[nodiscard]] std::string carried_rows(const TransferReport& report);
/// One object each.
[[nodiscard]] std::string solution_metric_json(const SolutionMetricReport& report);
[[nodiscard]] std::string transfer_json(const TransferReport& report);

}  // namespace camber::run
