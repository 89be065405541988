module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
export module camber.curving:placed_nodes;
import camber.core;
import camber.metric;
import camber.surface;
import :edge_target;

/// Nodes of boundary edges that are moved on the geometry: to where their edges are shortest in a metric, or nearest to
/// the geometry. docs/algorithms/surface.md.
export namespace camber {

/// Where the node of a boundary edge goes.
enum class BoundaryNodeAim : std::uint8_t {
    projection,  ///< the middle projected, see boundary_nodes
    length,      ///< on the geometry, where the P2 edge is shortest in the metric
    accuracy,    ///< on the geometry, where ∫ (distance of the P2 edge from the geometry)² dt is least
};
[[nodiscard]] constexpr auto words(BoundaryNodeAim) {
    return words_of(Word{BoundaryNodeAim::projection, "projection"}, Word{BoundaryNodeAim::length, "length"},
                    Word{BoundaryNodeAim::accuracy, "accuracy"});
}

struct PlacementOptions {
    BoundaryNodeAim boundary_nodes = BoundaryNodeAim::projection;
    /// By length: the edge's largest distance from the geometry may grow to this share of its sagitta (or to twice that
    /// with the projected middle, whatever is more).
    double distance_share = 0.02;

    [[nodiscard]] static constexpr auto options() {
        using S = PlacementOptions;
        return std::tuple(
            option(
                "boundary_nodes", &S::boundary_nodes,
                "where nodes of boundary edges go: projection, the middle projected onto the geometry; length, on the "
                "geometry where the edge is shortest in the metric; accuracy, on the geometry where the edge is "
                "nearest to it. Where no better place is found it is the projection"),
            option("distance_share", &S::distance_share,
                   "boundary_nodes length only: how far from the geometry edges may be for it, as a share of how far "
                   "they are straight; twice what they are with the middle projected is always allowed")
                .at_least(0)
                .at_most(1));
    }
    friend bool operator==(const PlacementOptions&, const PlacementOptions&) = default;
};

/// What became of the node of a boundary edge.
enum class NodeFate : std::uint8_t {
    held,      ///< not asked: of the volume, required, on a line
    placed,    ///< moved, and the edge is better for it
    best,      ///< no better place was found: by the finer rule none is shorter, or nearer
    off,       ///< fell back: the node is not on what the edge lies on, or no step on it holds
    far,       ///< fell back: what is shorter leaves the geometry
    elements,  ///< fell back: the elements around bear no part of the way
};

/// The node of one edge, and what the aim measures with the projected middle and with it: the length by report_points,
/// or the root mean square of the distance.
template <int D>
struct PlacedNode {
    LagrangeNode<D> node;
    NodeFate fate = NodeFate::held;
    bool has_walked = false;  ///< to a facet of the surrogate that is not at the edge
    bool is_limited = false;  ///< it went a part of its way only
    double before = 0, after = 0;
};

struct PlacementStatistics {
    std::size_t edges = 0;  ///< that were asked
    std::size_t placed = 0, best = 0;
    std::size_t off = 0, far = 0, elements = 0;
    std::size_t walked = 0, limited = 0;               ///< of those that were placed
    double mean_reduction = 0, largest_reduction = 0;  ///< of the sums over all that were asked; of one
};
template <int D>
[[nodiscard]] PlacementStatistics placement_statistics(std::span<const PlacedNode<D>> nodes);

/// One edge: from the node `present`, which is on the geometry. `holder`: an element that holds it. `thin`: corners
/// opposite to it that lie on ridges, beyond which nodes must not go.
template <int D>
[[nodiscard]] PlacedNode<D> placed_node(const Geometry<D>& geometry, const EdgeSite<D>& site,
                                        const LagrangeNode<D>& present, std::span<const Vec<D>> thin,
                                        const BackMesh<D>& back, ElementId holder, const EdgeRules& rules,
                                        const CurveOptions& search, const PlacementOptions& options);

/// The boundary edges of a mesh: those move whose kind in `kinds` is that of the features; `nodes`: where they are, one
/// row an edge. Where elements would suffer (`search.min_jacobian`, see limit_by_jacobian) nodes go a part of their
/// way. Errors: rows that do not fit the mesh (ErrorKind::internal); stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<PlacedNode<D>>> placed_nodes(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                          const Column<LagrangeNode<D>>& nodes,
                                                          const Incidence<ElementId>& shells,
                                                          const Features<D>& features, const Geometry<D>& geometry,
                                                          const BackMesh<D>& back, const CurveOptions& search,
                                                          const PlacementOptions& options, const Execution& execution);

}  // namespace camber
