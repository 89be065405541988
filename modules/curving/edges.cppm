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
                       option("max_smooth_error_increase", &S::smooth_loss,
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

/// A mesh, the kind of each of its edges, and the elements around each.
template <int D>
struct MeshEdges {
    const QuadraticMesh<D>& mesh;
    const Column<EdgeKind>& kinds;
    const Incidence<ElementId>& shells;
};

/// Edges whose nodes are searched: mesh edges that an element holds, with the nodes of all edges of the mesh from which
/// searches start.
template <int D>
struct SearchedEdges {
    const MeshEdges<D>& all;
    std::span<const EdgeId> edges;
    const Column<LagrangeNode<D>>& base;
};

/// How many edges `curve` gives to searched_targets at a time: the last few of them do not fill a pack.
inline constexpr std::size_t searched_together = 1024;

/// Computes the nodes of volume edges for `energy` or `length`, in packs, without lengths: targets[i] of edges[i].
/// `back`: the metric field; its mesh has straight edges or the nodes of `base`. The search starts from `base` too,
/// unless that is the middle of the chord, and never returns a longer edge. The target of an edge does not depend on
/// the other edges.
template <int D>
EdgeSearchWork searched_targets(const SearchedEdges<D>& searched, const BackMesh<D>& back, const EdgeRules& rules,
                                const CurveOptions& options, std::span<EdgeTarget<D>> targets);

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

/// What the model of an edge agrees with: the error of interpolation; or the length that is lost at a small offset,
/// since the field's kinks tell more than the curvature of an energy.
enum class ModelFit : std::uint8_t { accuracy, length };

/// What it costs an edge to have its node elsewhere than `wanted`, quadratic, in the field `back`, whose mesh is the
/// straight form of `mesh`. Length: as a share of the edge's length; slides along the edge are cheap, as
/// they change no length. Accuracy: the offset's metric length squared by the chord's, in all directions alike (the
/// third derivatives that an offset o leaves in an element are Σ (cᵀ H o)² over its edges c, and these are one unit
/// long in the metric). `shell`: the elements around the edge.
template <int D>
[[nodiscard]] QuadraticModel<D> edge_model(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& wanted,
                                           std::span<const ElementId> shell, const BackMesh<D>& back, ModelFit fit);

/// What it costs an edge to have its node off its wanted place: a pure function, asked from several threads.
template <int D>
using EdgeModels = std::function<QuadraticModel<D>(EdgeId)>;

/// Those of nodes that were found by this aim; of energy and length they are fitted to lengths.
template <int D>
[[nodiscard]] EdgeModels<D> edge_models(CurvingAim aim, const QuadraticMesh<D>& mesh,
                                        const Column<LagrangeNode<D>>& wanted, const Incidence<ElementId>& shells,
                                        const BackMesh<D>& back);

/// The same of one edge without a field: in the mean natural metric of the edge's elements.
template <int D>
[[nodiscard]] QuadraticModel<D> implied_edge_model(const QuadraticMesh<D>& mesh, EdgeId edge,
                                                   const LagrangeNode<D>& wanted, std::span<const ElementId> shell);

/// Those of all edges.
template <int D>
[[nodiscard]] EdgeModels<D> implied_edge_models(const QuadraticMesh<D>& mesh, const Column<LagrangeNode<D>>& wanted,
                                                const Incidence<ElementId>& shells);

}  // namespace camber

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

/// A boundary edge whose node is to be placed.
template <int D>
struct EdgeToPlace {
    const EdgeSite<D>& site;
    LagrangeNode<D> present;       ///< on the geometry
    std::span<const Vec<D>> thin;  ///< corners opposite to the edge that lie on ridges: nodes must not go beyond them
    ElementId holder;              ///< an element that holds the edge
};

/// Parameters of the placement of boundary nodes.
struct PlacementSearch {
    const CurveOptions& search;
    const PlacementOptions& placement;
    EdgeRules rules = edge_rules(search);
};

/// Moves the node of one edge on the geometry.
template <int D>
[[nodiscard]] PlacedNode<D> placed_node(const Geometry<D>& geometry, const EdgeToPlace<D>& edge,
                                        const BackMesh<D>& back, const PlacementSearch& parameters);

/// The features of a boundary, and its geometry.
template <int D>
struct GeometricBoundary {
    const Features<D>& features;
    const Geometry<D>& geometry;
};

/// Moves the nodes of boundary edges whose kind is that of the features. `nodes`: where they are, one row an edge.
/// Where elements would suffer (`min_jacobian` of the search, see limit_by_jacobian) nodes go a part of their way.
/// Errors: rows that do not fit the mesh (ErrorKind::internal); stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<PlacedNode<D>>> placed_nodes(const MeshEdges<D>& edges,
                                                          const Column<LagrangeNode<D>>& nodes,
                                                          const GeometricBoundary<D>& boundary, const BackMesh<D>& back,
                                                          const PlacementSearch& parameters,
                                                          const Execution& execution);

/// What `curve` found beside the nodes.
struct CurveStatistics {
    std::size_t volume_edges = 0;
    std::size_t curved_edges = 0;  ///< volume edges whose node left the middle of the chord
    std::size_t polished = 0;      ///< searches that a kink of the field stopped and a pattern search ended
    std::size_t exhausted = 0;     ///< searches that ran out of iterations
    std::size_t shortened = 0;     ///< minimisers that the finer rule found longer than the chord, and pulled back
    std::size_t outside = 0;       ///< edges with samples beyond the back mesh, of those that were measured or searched
    std::size_t lost = 0;          ///< edges with samples that were not found in it, likewise
    std::size_t drawn_back = 0;    ///< nodes for accuracy that go a part of their way, for their elements
    std::size_t by_walls = 0;      ///< nodes for accuracy that walls move, by more than 1/1000 of the chord
    std::size_t by_metric = 0;     ///< that the metric moves, likewise
    std::size_t held_back = 0;     ///< that go less than half of it, for smooth functions: see limit_smooth_loss

    CurveStatistics& operator+=(const CurveStatistics& other);
};

/// A proposal for every edge, and the lengths of the volume edges on the true field.
template <int D>
struct Curved {
    Proposal<D> proposal;
    Column<double> straight_lengths;  ///< by report_points; 0 on boundary edges and on those that are not measured
    Column<double> lengths;           ///< of the proposal's edges, likewise
    CurveStatistics statistics;
};

/// The targets of all edges as a proposal. They are one a edge.
template <int D>
[[nodiscard]] Curved<D> in_columns(const LinearMesh<D>& mesh, std::span<const EdgeTarget<D>> targets,
                                   const Column<EdgeKind>& kinds);

/// The second verb on a whole mesh: volume edges take the nodes that the options' aim asks for in the field `back`,
/// whose mesh must be that of `edges` with straight edges or with those of `base`; boundary edges take `base`, which
/// has one row an edge: for edges of the boundary their nodes on the geometry (see camber.surface), for those of the
/// volume where the back mesh has them, the middles of their chords in a straight one. From there searches begin, and
/// offsets for accuracy count. Edges do not see one another, so the cost is linear and the order does not matter.
/// Errors: columns that do not fit the mesh; options out of range (usage); stopped.
template <int D>
[[nodiscard]] Outcome<Curved<D>> curve(const MeshEdges<D>& edges, const Column<LagrangeNode<D>>& base,
                                       const BackMesh<D>& back, const CurveOptions& options,
                                       const Execution& execution);

/// Offsets for accuracy of the edges of one kind, from where the back mesh has their nodes; 0 of all others, and of
/// those that no element holds. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<Vec<D>>> accurate_offsets(const MeshEdges<D>& edges, EdgeKind kind,
                                                       const BackMesh<D>& back, const EdgeAccuracyOptions& options,
                                                       const Execution& execution);

/// `curve` without a field: volume edges stay straight.
template <int D>
[[nodiscard]] Outcome<Curved<D>> curve_boundary(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                                const Column<LagrangeNode<D>>& boundary_nodes,
                                                const Execution& execution);

/// Lengths on the true field of the volume edges, by report_points; 0 on boundary edges and on those that are not
/// measured.
struct EdgeLengths {
    Column<double> straight;  ///< of the chords
    Column<double> curved;
};

/// Edges, and the elements that hold each of them.
template <int D>
struct HeldEdges {
    const EdgeSet<D>& edges;
    const Incidence<ElementId>& shells;
};

/// Lengths of a proposal in any field. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<EdgeLengths> edge_lengths(const HeldEdges<D>& held, const Proposal<D>& proposal,
                                                const BackMesh<D>& back, MeasuredEdges measured,
                                                const Execution& execution);

/// Lengths of a later proposal, whose vertices may have moved since `curved` was made: against the chords as they are
/// then. What did not change is not measured again. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<EdgeLengths> updated_lengths(const HeldEdges<D>& held, const Curved<D>& curved,
                                                   const Proposal<D>& after, const BackMesh<D>& back,
                                                   MeasuredEdges measured, const Execution& execution);

}  // namespace camber

/// Minimising on a sheet: BFGS in the one or two tangential coordinates, each step followed by projection. The frame
/// goes along with the place, so that at each the projection's derivative is that of the tangent plane.
namespace camber {

/// How far a node may go, from where it began.
template <int D>
struct NodeReach {
    static constexpr double most = 0.3;          ///< of the chord
    static constexpr double to_the_ridge = 0.4;  ///< of the way to the corner that is on one, across the edge

    Vec<D> origin, middle, chord;
    double max_shift = 0;          ///< along the chord, of the chord
    std::span<const Vec<D>> thin;  ///< corners on ridges

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

/// A place, its objective, and what that looks like from there.
template <int D>
struct SheetIterate {
    SheetPlace<D> place;
    double value = 0;
    Vec<2> gradient;
    Sym<2> hessian;
};

template <int D>
class SheetSearch {
  public:
    SheetSearch(const EdgeSheet<D>& sheet, const NodeReach<D>& reach) : sheet_(sheet), reach_(reach) {}

    /// The place a step away in coordinates; nothing where there is none within reach.
    [[nodiscard]] std::optional<SheetPlace<D>> at(const SheetPlace<D>& from, const Vec<2>& y) const {
        Vec<D> step;
        for (int i = 0; i < sheet_.unknowns(); ++i) step += y[i] * from.tangents[static_cast<std::size_t>(i)];
        auto place = sheet_.moved(from, step);
        if (place && !reach_.has(place->point)) return std::nullopt;
        return place;
    }
    [[nodiscard]] Vec<2> coordinates(const SheetPlace<D>& place, const Vec<D>& v) const {
        Vec<2> y;
        for (int i = 0; i < sheet_.unknowns(); ++i) y[i] = dot(place.tangents[static_cast<std::size_t>(i)], v);
        return y;
    }

    template <class Objective>
    [[nodiscard]] SheetIterate<D> evaluated(const Objective& objective, const SheetPlace<D>& place) const {
        const ObjectiveSample<D> sample = objective.evaluate(place.point);
        SheetIterate<D> out{place, sample.value, coordinates(place, sample.gradient), Sym<2>::identity()};
        for (int i = 0; i < sheet_.unknowns(); ++i)
            for (int j = 0; j <= i; ++j)
                out.hessian(i, j) = dot(place.tangents[static_cast<std::size_t>(i)],
                                        sample.hessian * place.tangents[static_cast<std::size_t>(j)]);
        return out;
    }

    /// How a descent ended: where the model promises no more, or where no step lowered the objective (a kink), or the
    /// steps were spent.
    enum class End : std::uint8_t { converged, stopped };

    /// The least that BFGS finds from there.
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

    /// Where kinks of the field stop a descent: along the axes of the Hessian with falling radius.
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
    /// A step that lowers the objective enough, halved until it does; `s` becomes what it was.
    template <class Objective>
    std::optional<SheetIterate<D>> along(const Objective& objective, const SheetIterate<D>& from, Vec<2>& s) const {
        constexpr double longest = 0.15;  // of the chord
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

    /// The inverse with a share of the trace on the diagonal, where the objective may leave a direction undecided.
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

    /// Columns of a square root of a symmetric matrix.
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
