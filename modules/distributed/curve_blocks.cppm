module;
#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <tuple>
#include <vector>
export module camber.distributed:curve_blocks;
import camber.core;
import camber.crossing;
import camber.curving;
import camber.metric;
import camber.recipes;
import camber.repair;
import camber.surface;
import camber.validity;
import :ringed_parts;
import :ranks;
import :rows;

export namespace camber {

/// What blocks are curved by.
template <int D>
struct BlocksGoal {
    /// The features and the shape of the boundary, which is given as a mesh without elements. Null: smooth surfaces
    /// through its vertices.
    std::function<Outcome<Boundary<D>>(const LinearMesh<D>&, const EdgeSet<D>&, const Execution&)> boundary = {};
    /// The metric at the vertices of a part, of which the numbers in the whole mesh are given too. Null: the mesh's
    /// own.
    std::function<Outcome<Column<LogMetric<D>>>(const LinearMesh<D>&, std::span<const GlobalNumber>, const Execution&)>
        metric = {};
};

/// By blocks of how many elements a mesh is curved, as a stage's options say it.
struct CurveByBlocks {
    int blocks = 0;
    double memory = 0;

    [[nodiscard]] static constexpr auto options() {
        using S = CurveByBlocks;
        return std::tuple(
            option(
                "blocks", &S::blocks,
                "elements in a block: the mesh is curved by blocks and written by parts; 0: as a whole, but on several "
                "ranks, and within a memory, by blocks of 262144")
                .at_least(0)
                .unit("elements"),
            option("memory", &S::memory,
                   "about as much memory may be taken: what blocks have lies in files without names beside the output, "
                   "and leaves memory when they have been gone through; 0: it stays there")
                .at_least(0)
                .unit("bytes"));
    }
    friend bool operator==(const CurveByBlocks&, const CurveByBlocks&) = default;
};

struct CurveBlocksOptions {
    BlockOptions blocks = {};
    CurveMeshOptions curving = {};
    BoundaryTolerance tolerance = {};  ///< of the boundary's deviation from its geometry
};

/// Verdicts of a mesh in blocks, of all ranks.
struct BlocksValidation {
    std::size_t invalid = 0, undecided = 0;  ///< to the bound
    std::size_t not_positive = 0;            ///< of which det J > 0 everywhere is not certified
    double smallest = 1;                     ///< of the scaled Jacobians
    GlobalNumber worst = 0;                  ///< the element that has it, where there is one

    [[nodiscard]] bool all_valid() const { return invalid + undecided == 0; }
};

/// A part that was curved: nodes of its unique edges, those in its rings as their owners have them.
template <int D>
struct CurvedPart {
    QuadraticMesh<D> mesh;
    EdgeId first_edge, last_edge;  ///< its own are [first_edge, last_edge)
};

/// Walls of a mesh in blocks that cross in the end; facets as the whole mesh numbers them.
template <int D>
struct WallsOfBlocks {
    Crossings crossings;
    std::size_t crossing_before = 0;       ///< pairs of the straight mesh that cross, where any cross in the end
    std::array<Box<D>, 2> first_crossing;  ///< boxes of the first pair that crosses, where there is one
    MovedBack<D> moved;                    ///< nodes that were moved back until no walls crossed
};

/// Deviation of the whole boundary from its geometry in the end, and its worst entities as the whole mesh has them.
template <int D>
struct DeviationOfBlocks {
    BoundaryDeviation found;             ///< the ids are those of a mesh of the boundary alone
    std::array<GlobalNumber, 2> edge{};  ///< ends of the edge with the worst node, where there is one
    Vec<D> node{};                       ///< that node
    GlobalNumber vertex = 0;             ///< the worst vertex, where there is one
    Vec<D> point{};                      ///< its position
};

/// What a rank has of a curved mesh in blocks, and what all have found.
template <int D>
struct CurvedBlocks {
    RingedParts<D> parts;
    std::vector<CurvedPart<D>> curved;      ///< one a part of this rank
    std::vector<GlobalNumber> first_edges;  ///< of each part of all; then the number of edges
    RowCounts counts;                       ///< of the mesh
    CurveStatistics statistics;             ///< of all ranks
    BlocksValidation before, after;
    RepairStatistics repair;
    WallsOfBlocks<D> walls;
    DeviationOfBlocks<D> deviation;
    std::size_t iterations = 0;  ///< of the extension
};

/// `curve_mesh` by blocks, each rank its own: the same nodes but for rounding of sums over the mesh. All of a part's
/// work is done on it and its two rings; what is known of others is brought after each step. The mesh must be sound
/// (see `check_part`). Steps: split, elevate, surface, extension, metric, curve, validate, relax, uncross, measure.
/// Errors: as of curve_mesh; objectives without a field, nodes of the boundary elsewhere than projected, metrics made
/// of the mesh's own (unsupported); of any rank.
template <int D>
[[nodiscard]] Outcome<CurvedBlocks<D>> curve_blocks(const MeshRows<D>& rows, const BlocksGoal<D>& goal,
                                                    const CurveBlocksOptions& options, Ranks& ranks,
                                                    const Around& around);

}  // namespace camber
