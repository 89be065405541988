module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <tuple>
export module camber.curving:edges;
import camber.core;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.optimisation;
import camber.surface;

export namespace camber {

enum class CurvingAim : std::uint8_t {
    accuracy,  ///< minimum interpolation error of functions for which the metric is optimal; closed form
               ///< (`accurate_offsets`)
    energy,    ///< minimum energy ∫ l'ᵀ M l' dt of the edge l(t) in the metric M
    length,
};

/// Edges whose lengths are reported; measuring costs more than curving.
enum class MeasuredEdges : std::uint8_t {
    none,
    some,  ///< all edges or, in a larger mesh, about 131 072, chosen by a hash
    all,
};

[[nodiscard]] constexpr bool is_measured(MeasuredEdges measured, std::size_t edge, std::size_t edges) {
    if (measured == MeasuredEdges::none) return false;
    constexpr std::size_t enough = std::size_t{1} << 17;
    if (measured == MeasuredEdges::all || edges <= enough) return true;
    // Edge numbers have patterns. The high bits of their products with 2^64/golden ratio have none.
    const std::uint64_t hash = (std::uint64_t{edge} * 0x9e3779b97f4a7c15) >> 32;
    return hash * edges < (std::uint64_t{enough} << 32);
}

struct CurveOptions : EdgeMinimiserOptions, EdgeAccuracyOptions {
  private:
    using EdgeMinimiserOptions::objective;  // set by the option `aim`

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
                              "accuracy only: limit of the scaled Jacobian. Nodes of volume edges move only a part of "
                              "the way to their targets if an element would otherwise fall below it")
                           .at_least(0)
                           .below(1),
                       option("max_smooth_error_increase", &S::smooth_loss,
                              "accuracy with the mesh's own metric only: largest relative increase of the "
                              "interpolation error of smooth functions. A model estimates it for functions to which "
                              "the mesh is not adapted. Nodes that contribute most move only a part of their way. 0: "
                              "inner edges follow only the boundary")
                           .at_least(0)),
            EdgeMinimiserOptions::options());
    }
    friend bool operator==(const CurveOptions&, const CurveOptions&) = default;
};

[[nodiscard]] EdgeMinimiserOptions search_options(const CurveOptions& options);

struct SearchFlags {
    std::uint8_t volume = 0, curved = 0, polished = 0, exhausted = 0, shortened = 0, outside = 0, lost = 0;
    std::uint8_t by_walls = 0, by_metric = 0;  ///< for the aim `accuracy`: 1 if boundaries (`by_walls`) or the metric
                                               ///< moved the node by more than 1/1000 of the chord
};

template <int D>
struct EdgeTarget {
    LagrangeNode<D> node;
    EdgeChange change = EdgeChange::straight;
    SearchFlags flags;
    /// Lengths of the chord and of the edge with `node`, with `report_points` quadrature points; 0 on boundary and
    /// unmeasured edges.
    double straight_length = 0, length = 0;
};

template <int D>
[[nodiscard]] EdgeTarget<D> boundary_target(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& node);

/// `shells` lists the elements around each edge.
template <int D>
struct MeshEdges {
    const QuadraticMesh<D>& mesh;
    const Column<EdgeKind>& kinds;
    const Incidence<ElementId>& shells;
};

/// Edges whose nodes are searched; each has an element. `base` has the starting nodes of all edges of the mesh.
template <int D>
struct SearchedEdges {
    const MeshEdges<D>& all;
    std::span<const EdgeId> edges;
    const Column<LagrangeNode<D>>& base;
};

inline constexpr std::size_t searched_together = 1024;

/// Computes `targets[i]`, without lengths, of the i-th searched edge for the aims `energy` and `length`. The mesh of
/// `back` is straight or has the nodes of `base`. Searches start from the chord's middle and from `base`, and never
/// return a longer edge. Each target is independent of other edges.
template <int D>
EdgeSearchWork searched_targets(const SearchedEdges<D>& searched, const BackMesh<D>& back, const EdgeRules& rules,
                                const CurveOptions& options, std::span<EdgeTarget<D>> targets);

struct EdgeOfElement {
    EdgeId edge;
    ElementId element_at;
};

/// Computes offsets F d from the back mesh's nodes for the aim accuracy. d is the offset of the straight edge in the
/// reference mesh, and F = ∂x/∂X is the Jacobian of the curved back mesh. The field is sampled for all edges at once.
template <int D>
void accurate_offsets(const QuadraticMesh<D>& mesh, std::span<const BackEdge> edges, const BackMesh<D>& back,
                      const EdgeAccuracyOptions& options, std::span<Vec<D>> offsets);

template <int D>
[[nodiscard]] EdgeTarget<D> node_target(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& node);
template <int D>
void measure(const QuadraticMesh<D>& mesh, const EdgeOfElement& source, const BackMesh<D>& back,
             const Quadrature& report, EdgeTarget<D>& target);

/// Quantity that an edge's model approximates: the interpolation error, or the increase of the length at a small
/// offset. Unlike the second derivative of the energy, this increase includes kinks of the field.
enum class ModelFit : std::uint8_t { accuracy, length };

/// Returns the quadratic cost of a node's offset from its target, in a field on the straight mesh
/// (docs/algorithms/edge-accuracy.md). The cost depends on `fit`:
/// - `length`: increase of the length, relative to the length; motions along the edge are cheap.
/// - `accuracy`: squared metric length of the offset, relative to that of the chord; equal in all directions.
template <int D>
[[nodiscard]] QuadraticModel<D> edge_model(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& target,
                                           std::span<const ElementId> shell, const BackMesh<D>& back, ModelFit fit);

/// Several threads call this function, so it must not have side effects.
template <int D>
using EdgeModels = std::function<QuadraticModel<D>(EdgeId)>;

template <int D>
[[nodiscard]] EdgeModels<D> edge_models(CurvingAim aim, const QuadraticMesh<D>& mesh,
                                        const Column<LagrangeNode<D>>& target, const Incidence<ElementId>& shells,
                                        const BackMesh<D>& back);

template <int D>
[[nodiscard]] QuadraticModel<D> implied_edge_model(const QuadraticMesh<D>& mesh, EdgeId edge,
                                                   const LagrangeNode<D>& target, std::span<const ElementId> shell);

template <int D>
[[nodiscard]] EdgeModels<D> implied_edge_models(const QuadraticMesh<D>& mesh, const Column<LagrangeNode<D>>& target,
                                                const Incidence<ElementId>& shells);

}  // namespace camber

/// Motion of boundary nodes on the geometry, to the shortest edges or to the edges closest to the geometry
/// (docs/algorithms/surface.md).
export namespace camber {

enum class BoundaryNodeAim : std::uint8_t {
    projection,  ///< projection of the chord's middle, see `boundary_nodes`
    length,      ///< node with the shortest P2 edge in the metric
    accuracy,    ///< node with the minimum of ∫ (distance of the P2 edge from the geometry)² dt
};
[[nodiscard]] constexpr auto words(BoundaryNodeAim) {
    return words_of(Word{BoundaryNodeAim::projection, "projection"}, Word{BoundaryNodeAim::length, "length"},
                    Word{BoundaryNodeAim::accuracy, "accuracy"});
}

struct PlacementOptions {
    BoundaryNodeAim boundary_nodes = BoundaryNodeAim::projection;
    /// For the aim `length`: maximum distance of the edge from the geometry, divided by the sagitta. The maximum is at
    /// least twice the distance of the edge whose node is the projected chord middle.
    double distance_share = 0.02;

    [[nodiscard]] static constexpr auto options() {
        using S = PlacementOptions;
        return std::tuple(
            option("boundary_nodes", &S::boundary_nodes,
                   "nodes of boundary edges. projection: the middle of the edge, projected onto the geometry; length: "
                   "the point of the geometry for which the edge is shortest in the metric; accuracy: the point of the "
                   "geometry for which the edge is nearest to it. If no better point is found, length and accuracy use "
                   "the projection"),
            option("distance_share", &S::distance_share,
                   "boundary_nodes length only: largest distance of an edge from the geometry, as a share of the "
                   "distance between its projected middle and its chord. Twice the distance of the edge with the "
                   "projected middle is always allowed")
                .at_least(0)
                .at_most(1));
    }
    friend bool operator==(const PlacementOptions&, const PlacementOptions&) = default;
};

enum class PlacementStatus : std::uint8_t {
    fixed,  ///< not moved: a volume node, a required node, or an edge on a straight line of the geometry
    placed,
    best,      ///< not moved: no better position was found
    off,       ///< not moved: the node is not on the geometry, or no step from it stays there
    far,       ///< not moved: better edges are too far from the geometry
    elements,  ///< not moved: the elements allow no motion
};

/// Result for one node. `before` and `after` are values of the aim: length by `report_points`, or root mean square
/// distance.
template <int D>
struct PlacedNode {
    LagrangeNode<D> node;
    PlacementStatus status = PlacementStatus::fixed;
    bool has_left_facets = false;  ///< the node is on a facet of the surrogate surface that does not contain the edge
    bool is_limited = false;
    double before = 0, after = 0;
};

struct PlacementStatistics {
    std::size_t edges = 0;
    std::size_t placed = 0, best = 0;
    std::size_t off = 0, far = 0, elements = 0;
    std::size_t walked = 0, limited = 0;  ///< placed nodes that left their facets (`walked`) or moved a part of the way
    double mean_reduction = 0, largest_reduction = 0;  ///< before/after − 1, for the sum of the aim over `edges`, and
                                                       ///< the maximum over single edges
};
template <int D>
[[nodiscard]] PlacementStatistics placement_statistics(std::span<const PlacedNode<D>> nodes);

template <int D>
struct EdgeToPlace {
    const EdgeSite<D>& site;
    LagrangeNode<D> present;       ///< current node, on the geometry
    std::span<const Vec<D>> thin;  ///< corners opposite the edge that lie on ridges; the node must not pass them
    ElementId element_at;
};

struct PlacementSearch {
    const CurveOptions& search;
    const PlacementOptions& placement;
    EdgeRules rules = edge_rules(search);
};

template <int D>
[[nodiscard]] PlacedNode<D> placed_node(const Geometry<D>& geometry, const EdgeToPlace<D>& edge,
                                        const BackMesh<D>& back, const PlacementSearch& parameters);

template <int D>
struct GeometricBoundary {
    const Features<D>& features;
    const Geometry<D>& geometry;
};

/// Places the nodes of boundary edges that have the same kind in `edges` and in the features. `nodes` are the current
/// nodes, one row per edge. Elements limit the motion (see `limit_by_jacobian`). Errors: rows that do not fit the mesh
/// (internal); stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<PlacedNode<D>>> placed_nodes(const MeshEdges<D>& edges,
                                                          const Column<LagrangeNode<D>>& nodes,
                                                          const GeometricBoundary<D>& boundary, const BackMesh<D>& back,
                                                          const PlacementSearch& parameters,
                                                          const Execution& execution);

struct CurveStatistics {
    std::size_t volume_edges = 0;
    std::size_t curved_edges = 0;  ///< volume edges with a node off the chord middle
    std::size_t polished = 0;      ///< searches stopped by a kink and completed by pattern search
    std::size_t exhausted = 0;     ///< searches that ran out of iterations
    std::size_t shortened = 0;     ///< nodes moved towards the chord, because the finer quadrature rule found the chord
                                   ///< shorter
    std::size_t outside = 0;       ///< edges with sample points beyond the back mesh
    std::size_t lost = 0;          ///< edges with sample points not found in the back mesh
    std::size_t relaxed = 0;       ///< aim accuracy: nodes limited by elements
    std::size_t by_walls = 0;      ///< aim accuracy: nodes moved by boundaries, see `EdgeTarget`
    std::size_t by_metric = 0;     ///< aim accuracy: nodes moved by the metric, see `EdgeTarget`
    std::size_t loss_limited = 0;  ///< nodes moved by less than half of their requested offset, see `limit_smooth_loss`

    CurveStatistics& operator+=(const CurveStatistics& other);
};

template <int D>
struct Curved {
    Proposal<D> proposal;
    Column<double> straight_lengths;  ///< lengths of chords by `report_points`; 0 on boundary and unmeasured edges
    Column<double> lengths;           ///< lengths of the edges in `proposal`; 0 as in `straight_lengths`
    CurveStatistics statistics;
};

template <int D>
[[nodiscard]] Curved<D> in_columns(const LinearMesh<D>& mesh, std::span<const EdgeTarget<D>> targets,
                                   const Column<EdgeKind>& kinds);

/// Curves a whole mesh. The nodes of volume edges are optimal for the aim in the field `back`. The field is defined on
/// the same mesh, straight or with the nodes of `base`. `base` has one row per edge:
/// - boundary edges: their final nodes;
/// - volume edges: nodes of the back mesh (if straight: chord middles), from which searches start and offsets for
///   accuracy are measured.
///
/// The cost is linear. Errors: columns that do not fit the mesh; options out of range (usage); stopped.
template <int D>
[[nodiscard]] Outcome<Curved<D>> curve(const MeshEdges<D>& edges, const Column<LagrangeNode<D>>& base,
                                       const BackMesh<D>& back, const CurveOptions& options,
                                       const Execution& execution);

/// Returns the offsets for the aim accuracy from the back mesh's nodes, for edges of one kind; 0 for other edges and
/// edges without elements. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<Vec<D>>> accurate_offsets(const MeshEdges<D>& edges, EdgeKind kind,
                                                       const BackMesh<D>& back, const EdgeAccuracyOptions& options,
                                                       const Execution& execution);

/// Curves boundary edges without a field; volume edges remain straight.
template <int D>
[[nodiscard]] Outcome<Curved<D>> curve_boundary(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                const Column<LagrangeNode<D>>& boundary_nodes,
                                                const Execution& execution);

/// Lengths of volume edges by `report_points`; 0 on other and unmeasured edges.
struct EdgeLengths {
    Column<double> straight;
    Column<double> curved;
};

template <int D>
struct EdgesOfElements {
    const EdgeSet<D>& edges;
    const Incidence<ElementId>& shells;
};

template <int D>
[[nodiscard]] Outcome<EdgeLengths> edge_lengths(const EdgesOfElements<D>& source, const Proposal<D>& proposal,
                                                const BackMesh<D>& back, MeasuredEdges measured,
                                                const Execution& execution);

/// Updates the lengths in `curved` for the later proposal `after`; measures only changed edges. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<EdgeLengths> updated_lengths(const EdgesOfElements<D>& source, const Curved<D>& curved,
                                                   const Proposal<D>& after, const BackMesh<D>& back,
                                                   MeasuredEdges measured, const Execution& execution);

}  // namespace camber

/// Minimisation over positions of a node on a smooth surface (sheet): BFGS in one or two tangential coordinates. Each
/// step is projected onto the surface, and the node gets new tangents there.
namespace camber {

template <int D>
struct NodeReach {
    static constexpr double most = 0.3;          ///< largest motion, relative to the chord
    static constexpr double to_the_ridge = 0.4;  ///< largest motion towards a corner on a ridge, as a fraction of the
                                                 ///< distance to this corner

    Vec<D> origin, middle, chord;
    double max_shift = 0;  ///< largest motion along the chord, relative to the chord
    std::span<const Vec<D>> thin;

    [[nodiscard]] bool has(const Vec<D>& p) const {
        const double squared = norm_squared(chord);
        const Vec<D> offset = p - origin;
        if (!(norm_squared(offset) <= most * most * squared)) return false;
        if (!(std::abs(dot(p - middle, chord)) <= max_shift * squared)) return false;
        return std::ranges::all_of(thin, [&](const Vec<D>& corner) {
            const Vec<D> to = corner - origin;
            const Vec<D> height = to - dot(to, chord) / squared * chord;
            return dot(offset, height) <= to_the_ridge * norm_squared(height);
        });
    }
};

template <int D>
struct SheetIterate {
    SheetPosition<D> place;
    double value = 0;
    Vec<2> gradient;
    Sym<2> hessian;
};

template <int D>
class SheetSearch {
  public:
    SheetSearch(const EdgeSheet<D>& sheet, const NodeReach<D>& reach) : sheet_(sheet), reach_(reach) {}

    /// Moves `from` by tangential coordinates y on the surface; no value if `reach_` excludes the result.
    [[nodiscard]] std::optional<SheetPosition<D>> at(const SheetPosition<D>& from, const Vec<2>& y) const {
        Vec<D> step;
        for (int i = 0; i < sheet_.unknowns(); ++i) step += y[i] * from.tangents[static_cast<std::size_t>(i)];
        auto place = sheet_.moved(from, step);
        if (place && !reach_.has(place->point)) return std::nullopt;
        return place;
    }
    [[nodiscard]] Vec<2> coordinates(const SheetPosition<D>& place, const Vec<D>& v) const {
        Vec<2> y;
        for (int i = 0; i < sheet_.unknowns(); ++i) y[i] = dot(place.tangents[static_cast<std::size_t>(i)], v);
        return y;
    }

    template <class Objective>
    [[nodiscard]] SheetIterate<D> evaluated(const Objective& objective, const SheetPosition<D>& place) const {
        const ObjectiveSample<D> sample = objective.evaluate(place.point);
        SheetIterate<D> out{place, sample.value, coordinates(place, sample.gradient), Sym<2>::identity()};
        for (int i = 0; i < sheet_.unknowns(); ++i)
            for (int j = 0; j <= i; ++j)
                out.hessian(i, j) = dot(place.tangents[static_cast<std::size_t>(i)],
                                        sample.hessian * place.tangents[static_cast<std::size_t>(j)]);
        return out;
    }

    /// `stopped`: no step lowers the objective (at a kink), or the maximum number of steps is reached.
    enum class End : std::uint8_t { converged, stopped };

    template <class Objective>
    End descend(const Objective& objective, int max_steps, double tolerance, SheetIterate<D>& at) const {
        Sym<2> h = inverse_of(at.hessian, Objective::damping);
        for (int step = 0; step < max_steps; ++step) {
            Vec<2> s = -(h * at.gradient);
            const double promised = -0.5 * dot(s, at.gradient);
            if (!(promised > tolerance * std::abs(at.value))) return End::converged;
            const auto next = along(objective, at, s);
            if (!next) return End::stopped;
            const Vec<2> change = next->gradient - at.gradient;
            at = *next;
            update(h, s, change);
        }
        return End::stopped;
    }

    /// Pattern search along the Hessian's axes, used at kinks.
    template <class Objective>
    void polish(const Objective& objective, SheetIterate<D>& at) const {
        const std::array<Vec<2>, 2> axes = unit_axes(inverse_of(at.hessian, Objective::damping));
        const double scale = std::sqrt(std::max(at.value, 0.0));
        double radius = 0.05 * scale;
        for (int round = 0; round < 10 && radius > 1e-3 * scale; ++round) {
            bool is_better = false;
            for (int k = 0; k < sheet_.unknowns(); ++k)
                for (const double side : {-radius, radius}) {
                    const auto place = this->at(at.place, side * axes[static_cast<std::size_t>(k)]);
                    if (!place) continue;
                    const double value = objective.value(place->point);
                    if (!(value < at.value)) continue;
                    at.place = *place;
                    at.value = value;
                    is_better = true;
                }
            if (!is_better) radius *= 0.3;
        }
    }

  private:
    template <class Objective>
    std::optional<SheetIterate<D>> along(const Objective& objective, const SheetIterate<D>& from, Vec<2>& s) const {
        constexpr double longest = 0.15;  // longest step, relative to the chord
        constexpr double armijo = 1e-4;
        const double limit = longest * norm(reach_.chord), length = norm(s);
        if (length > limit) s *= limit / length;
        for (int halving = 0; halving < 10; ++halving, s *= 0.5) {
            const auto place = at(from.place, s);
            if (!place) continue;
            if (!(objective.value(place->point) <= from.value + armijo * dot(s, from.gradient))) continue;
            return evaluated(objective, *place);
        }
        return std::nullopt;
    }

    /// Adds a multiple of the trace to the diagonal before inverting, since h may be singular.
    [[nodiscard]] Sym<2> inverse_of(const Sym<2>& h, double damping) const {
        const bool is_one = sheet_.unknowns() == 1;
        const double added = damping * (h(0, 0) + (is_one ? 0 : h(1, 1)));
        const double a = h(0, 0) + added, b = is_one ? 0 : h(1, 0), c = is_one ? 1 : h(1, 1) + added;
        const double determinant = a * c - b * b;
        Sym<2> out;
        if (determinant > 0 && a > 0) {
            out(0, 0) = c / determinant;
            out(1, 0) = -b / determinant;
            out(1, 1) = a / determinant;
        }
        return out;
    }

    [[nodiscard]] static std::array<Vec<2>, 2> unit_axes(const Sym<2>& h) {
        const double a = std::sqrt(std::max(h(0, 0), 0.0));
        if (!(a > 0)) return {};
        const double b = h(1, 0) / a;
        return {Vec<2>{{a, b}}, Vec<2>{{0, std::sqrt(std::max(h(1, 1) - b * b, 0.0))}}};
    }

    static void update(Sym<2>& h, const Vec<2>& s, const Vec<2>& d) {
        const double sd = dot(s, d);
        if (!(sd > 1e-10 * norm(s) * norm(d))) return;
        const Vec<2> hd = h * d;
        const double factor = (1 + dot(d, hd) / sd) / sd;
        for (int i = 0; i < 2; ++i)
            for (int j = 0; j <= i; ++j) h(i, j) += factor * s[i] * s[j] - (hd[i] * s[j] + s[i] * hd[j]) / sd;
    }

    const EdgeSheet<D>& sheet_;
    const NodeReach<D>& reach_;
};

}  // namespace camber
