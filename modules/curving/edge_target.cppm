module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
export module camber.curving:edge_target;
import camber.core;
import camber.metric;
import camber.validity;
import camber.optimisation;

export namespace camber {

/// What the node of a volume edge is for.
enum class CurvingAim : std::uint8_t {
    accuracy,  ///< that functions which the metric belongs to are interpolated well: accurate_offsets, a closed form
    energy,    ///< ∫ l'ᵀ M l' dt least
    length,    ///< the Riemannian length least (paper §2.2)
};

/// Of which volume edges lengths are told: they are figures to look at, and cost more than the nodes do.
enum class MeasuredEdges : std::uint8_t {
    none,
    some,  ///< of a mesh of more than 131 072 edges, about as many, chosen by a hash of their numbers
    all,
};

/// Whether the lengths of this edge, of so many, are told.
[[nodiscard]] constexpr bool is_measured(MeasuredEdges measured, std::size_t edge, std::size_t edges) {
    if (measured == MeasuredEdges::none) return false;
    constexpr std::size_t enough = std::size_t{1} << 17;
    if (measured == MeasuredEdges::all || edges <= enough) return true;
    // Numbers in a mesh have patterns, the high bits of their products with 2^64/golden ratio have none.
    const std::uint64_t hash = (std::uint64_t{edge} * 0x9e3779b97f4a7c15) >> 32;
    return hash * edges < (std::uint64_t{enough} << 32);
}

/// How nodes of volume edges are found. `objective` of the minimiser is that of the aim.
struct CurveOptions : EdgeMinimiserOptions, EdgeAccuracyOptions {
  private:
    using EdgeMinimiserOptions::objective;  // the aim says it

  public:
    CurvingAim aim = CurvingAim::accuracy;
    MeasuredEdges measured = MeasuredEdges::all;
    double min_jacobian = default_bound;
    double smooth_loss = 0.01;

    [[nodiscard]] static constexpr auto options() {
        using S = CurveOptions;
        return std::tuple_cat(
            EdgeAccuracyOptions::options(),
            std::tuple(option("min_jacobian", &S::min_jacobian,
                              "accuracy only: where nodes would bring an element's scaled Jacobian below this, those "
                              "of its volume edges go only a part of their way")
                           .at_least(0)
                           .below(1),
                       option("smooth_loss", &S::smooth_loss,
                              "accuracy by the mesh's own metric only: share by which the error of smooth functions, "
                              "which the mesh says nothing of, may rise by a model; nodes that cost them more go a "
                              "part of their way. 0: inner edges follow walls alone")
                           .at_least(0)),
            EdgeMinimiserOptions::options());
    }
    friend bool operator==(const CurveOptions&, const CurveOptions&) = default;
};

/// Those of the search, for an aim that has one: energy or length.
[[nodiscard]] EdgeMinimiserOptions search_options(const CurveOptions& options);

/// What the search for one edge's node met.
struct SearchFlags {
    std::uint8_t volume = 0, curved = 0, polished = 0, exhausted = 0, shortened = 0, outside = 0, lost = 0;
    std::uint8_t by_walls = 0, by_metric = 0;  ///< for accuracy: what moved the node, by more than 1/1000 of the chord
};

/// Where an edge's node ought to be before validity is asked for, and what that makes of its length.
template <int D>
struct EdgeTarget {
    LagrangeNode<D> node;
    EdgeChange change = EdgeChange::straight;
    SearchFlags flags;
    /// Riemannian lengths on the true field by report_points, with the middle of the chord and with `node`; 0 on
    /// boundary edges and on those that are not measured.
    double straight_length = 0, length = 0;
};

/// Of an edge of the boundary: its place on the geometry.
template <int D>
[[nodiscard]] EdgeTarget<D> boundary_target(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& node);

/// How many edges `curve` gives to searched_targets at a time: the last few of them do not fill a pack.
inline constexpr std::size_t searched_together = 1024;

/// Computes the nodes of volume edges for `energy` or `length`, in packs, without lengths: targets[i] of edges[i], each
/// held by an element. `back`: the metric field; its mesh has straight edges or `base` here. The search starts from
/// `base` too, unless that is the middle of the chord, and never returns a longer edge. The target of an edge does not
/// depend on the other edges.
template <int D>
EdgeSearchWork searched_targets(const QuadraticMesh<D>& mesh, std::span<const EdgeId> edges,
                                const Column<LagrangeNode<D>>& base, const Incidence<ElementId>& shells,
                                const BackMesh<D>& back, const EdgeRules& rules, const CurveOptions& options,
                                std::span<EdgeTarget<D>> targets);

/// An edge, and an element that holds it.
struct HeldEdge {
    EdgeId edge;
    ElementId holder;
};

/// Offsets for accuracy, of volume edges or of others: offsets[i] is that of edges[i], from where the back mesh has its
/// node: F D, where D is the offset of the straight edge in the reference. The field is asked for all at once.
template <int D>
void accurate_offsets(const QuadraticMesh<D>& mesh, std::span<const BackEdge> edges, const BackMesh<D>& back,
                      const EdgeAccuracyOptions& options, std::span<Vec<D>> offsets);

/// A volume edge with this node, without lengths.
template <int D>
[[nodiscard]] EdgeTarget<D> node_target(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& node);
/// A target's lengths by the rule `report`.
template <int D>
void measure(const QuadraticMesh<D>& mesh, const HeldEdge& held, const BackMesh<D>& back, const Quadrature& report,
             EdgeTarget<D>& target);

}  // namespace camber
