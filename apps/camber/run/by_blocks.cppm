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

/// What a config says of a mesh that is curved by blocks, and what is told of it.
export namespace camber::run {

/// Elements in a block where a run on several ranks does not say.
inline constexpr std::size_t elements_of_block = default_block_elements;

/// Whether a pipeline asks for blocks.
[[nodiscard]] bool asks_for_blocks(const config::Pipeline& pipeline);

/// The memory that it is to keep to (bytes); 0: it does not say.
[[nodiscard]] double memory_by_blocks(const config::Pipeline& pipeline);

/// The stages of `curve` as options of curve_blocks. Errors: other stages, or what cannot be had by blocks
/// (unsupported).
[[nodiscard]] Outcome<CurveBlocksOptions> options_by_blocks(const config::Pipeline& pipeline);

/// What the blocks are curved by; all must outlive it. `files`: those of metrics, a row a vertex of the whole mesh.
/// Errors come when it is asked; notices go to `notices`, which are of this rank.
template <int D>
[[nodiscard]] BlocksGoal<D> goal_by_blocks(const config::Pipeline& pipeline, const GeometrySource& geometry,
                                           std::span<const MetricFile> files, Notices& notices);

/// What is told of such a run.
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
/// As `misses` of a Report.
[[nodiscard]] std::vector<std::string> misses(const ByBlocksReport& report);
template <int D>
[[nodiscard]] WallsReport walls_report(const WallsOfBlocks<D>& walls);
template <int D>
void add(ByBlocksReport& report, const DeviationOfBlocks<D>& deviation, const BoundaryTolerance& tolerance);
/// Lines for a terminal; the object of the report.
[[nodiscard]] std::string table(const ByBlocksReport& report);
[[nodiscard]] std::string to_json(const ByBlocksReport& report);

}  // namespace camber::run
