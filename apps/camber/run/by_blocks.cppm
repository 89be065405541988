module;
#include <cstddef>
#include <span>
#include <string>
#include <vector>
export module camber.run:by_blocks;
import camber.core;
import camber.config;
import camber.distributed;
import camber.recipes;
import camber.surface;
import :geometry_source;
import :report;
import :stages;

/// Options of a pipeline that curves by blocks, and the report of such a run.
export namespace camber::run {

/// Default number of elements in a block on several ranks.
inline constexpr std::size_t elements_of_block = default_block_elements;

/// Returns whether a pipeline requests blocks.
[[nodiscard]] bool asks_for_blocks(const config::Pipeline& pipeline);

/// Returns the limit of memory that a pipeline requests (bytes); 0: none.
[[nodiscard]] double memory_by_blocks(const config::Pipeline& pipeline);

/// Converts the stages of `curve` to options of curve_blocks. Errors: other stages, or options that curving by blocks
/// does not support (unsupported).
[[nodiscard]] Outcome<CurveBlocksOptions> options_by_blocks(const config::Pipeline& pipeline);

/// Makes the functions of geometry and metric for the blocks; the arguments must outlive the result. `files`: metric
/// files with one row per vertex of the whole mesh. The functions return errors when they are called, and add notices
/// of this rank to `notices`.
template <int D>
[[nodiscard]] BlocksGoal<D> goal_by_blocks(const config::Pipeline& pipeline, const GeometrySource& geometry,
                                           std::span<const MetricFile> files, Notices& notices);

/// Report of a run by blocks.
struct ByBlocksReport {
    std::size_t dimension = 3, ranks = 1, blocks = 0, elements_of_block = 0;
    std::size_t vertices = 0, elements = 0, facets = 0, edges = 0, volume_edges = 0, curved_edges = 0;
    std::size_t extension_iterations = 0;
    BlocksValidation before, after;
    RepairStatistics repair;
    WallsReport walls;
    DeviationReport nodes, boundary_vertices;  ///< of the boundary, from its geometry
    double bound = 0;
    bool is_asked = false;
    std::vector<std::size_t> peak_bytes;    ///< of each rank
    std::vector<double> processor_seconds;  ///< likewise
    std::vector<std::size_t> sent_bytes;    ///< likewise
    std::size_t rounds = 0;                 ///< exchanges
    std::vector<StageTime> times;

    [[nodiscard]] bool has_valid_elements() const {
        return after.not_positive == 0 && (!is_asked || after.all_valid());
    }
    [[nodiscard]] bool holds_what_was_asked() const {
        return has_valid_elements() && walls.crossing == 0 && nodes.off == 0 && boundary_vertices.off == 0;
    }
};
/// One sentence for each cause for which the result is not the requested one; empty if it is.
[[nodiscard]] std::vector<std::string> misses(const ByBlocksReport& report);
template <int D>
[[nodiscard]] WallsReport walls_report(const WallsOfBlocks<D>& walls);
template <int D>
void add(ByBlocksReport& report, const DeviationOfBlocks<D>& deviation, const BoundaryTolerance& tolerance);
/// Table for a terminal; JSON object of report.json.
[[nodiscard]] std::string table(const ByBlocksReport& report);
[[nodiscard]] std::string to_json(const ByBlocksReport& report);

}  // namespace camber::run
