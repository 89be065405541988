// State of an adaptation, goals, requests, rejection cache, lengths and qualities.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>
export module camber.operation:state;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.crossing;
import camber.surface;

export namespace camber {

/// The metric at a vertex, as it is given and ready to measure with, and where in the back mesh that is.
template <int D>
struct VertexMetric {
    LogMetric<D> log_metric;
    MeasuringMetric<D> measure;
    ElementId back;

    VertexMetric() = default;
    VertexMetric(const LogMetric<D>& given, ElementId at) : log_metric(given), measure(given), back(at) {}
    friend bool operator==(const VertexMetric&, const VertexMetric&) = default;
};

/// All that is known of one vertex beside its point, its reference and where it lies in the mesh.
template <int D>
struct VertexRow {
    VertexMetric<D> metric;
    GeometryPlace place;
    LogGradient<D> gradient{};
};

/// The same of all vertices: a row each in every column that has any. A new kind of data is a new column here, and goes
/// along with every commit.
template <int D>
struct VertexData {
    Column<VertexMetric<D>> metrics;
    /// What the vertex lies on, and where in that if it is at a place of the geometry's; of nothing inside. No rows
    /// without a geometry.
    Column<GeometryPlace> places = {};
    Column<LogGradient<D>> gradients = {};  ///< of degree 2: of the field, recovered

    /// What is known to lie there; of nothing, where nothing is known.
    [[nodiscard]] GeometryPlace place(VertexId v) const { return places.empty() ? GeometryPlace{} : places[v]; }
    [[nodiscard]] VertexRow<D> row(VertexId v) const {
        return {metrics[v], place(v), gradients.empty() ? LogGradient<D>{} : gradients[v]};
    }
    /// rows[i] of ids[i], of so many vertices now.
    void put(std::span<const VertexId> ids, std::span<const VertexRow<D>> rows, std::size_t vertices) {
        put_column(metrics, ids, vertices, [&](std::size_t i) { return rows[i].metric; });
        if (!places.empty()) put_column(places, ids, vertices, [&](std::size_t i) { return rows[i].place; });
        if (!gradients.empty()) put_column(gradients, ids, vertices, [&](std::size_t i) { return rows[i].gradient; });
    }

  private:
    template <class T, class Of>
    static void put_column(Column<T>& column, std::span<const VertexId> ids, std::size_t vertices, Of&& of) {
        auto values = take(std::move(column));
        values.resize(vertices);
        for (std::size_t i = 0; i < ids.size(); ++i) values[ids[i].index()] = of(i);
        column = std::move(values);
    }
};

/// The passes that ask again and again for the same.
enum class AskingPass : std::uint8_t { collapse, swap, smooth, remove };
inline constexpr std::size_t asking_passes = 4;

/// What each of them asked for in vain, by the entity that it asked at. Such a request depends on the elements at the
/// entity's vertices alone (but for facets of other walls): as long as none of these has changed it stands refused, and
/// need not be made again. Time is counted in commits.
class Refusals {
  public:
    /// A pass begins. What was refused for other limits is forgotten.
    void begin(AskingPass pass, std::vector<double> limits) {
        OfPass& of = of_[static_cast<std::size_t>(pass)];
        if (of.limits != limits) of = {std::move(limits), {}};
    }
    /// Of a mesh that has not changed since the requests were planned.
    template <class Tag>
    void refuse(AskingPass pass, std::span<const Id<Tag>> ids, std::size_t entities) {
        if (ids.empty()) return;
        OfPass& of = of_[static_cast<std::size_t>(pass)];
        auto asked = take(std::move(of.asked));
        asked.resize(entities, never);
        for (const Id<Tag> id : ids) asked[id.index()] = now_ + 1;
        of.asked = std::move(asked);
    }
    /// Whether the request at an entity with these vertices was refused and nothing has changed there since.
    template <class Tag>
    [[nodiscard]] bool stands(AskingPass pass, Id<Tag> id, std::span<const VertexId> vertices) const {
        const auto& asked = of_[static_cast<std::size_t>(pass)].asked;
        if (id.index() >= asked.size() || asked[id] == never) return false;
        for (const VertexId v : vertices)
            if (v.index() < changed_.size() && changed_[v] >= asked[id]) return false;
        return true;
    }
    /// A commit made these elements.
    template <int D>
    void follow(const DynamicMesh<D>& mesh, std::span<const ElementId> created) {
        ++now_;
        auto changed = take(std::move(changed_));
        changed.resize(mesh.points.size(), never);
        for (const ElementId e : created)
            if (!mesh.is_free(e))
                for (const VertexId v : mesh.elements.vertices[e])
                    if (!mesh.is_at_infinity(v)) changed[v.index()] = now_;
        changed_ = std::move(changed);
    }
    void forget() { of_ = {}; }

  private:
    static constexpr std::uint32_t never = 0;
    struct OfPass {
        std::vector<double> limits;
        Column<std::uint32_t> asked;  ///< of each entity: after how many commits it was last refused, and one
    };
    std::array<OfPass, asking_passes> of_;
    Column<std::uint32_t> changed_;  ///< of each vertex: the last commit that made an element of it
    std::uint32_t now_ = 0;          ///< commits
};

/// A mesh that is brought to a metric: an immutable value between two commits.
template <int D>
struct Adaptation {
    DynamicMesh<D> mesh;
    VertexData<D> vertices;
    FacetGrid<D> walls = {};  ///< boxes of its facets, see walls_of
    /// Vertices of the boundary that are off the geometry, new ones among them that could go a part of their way only.
    /// Ids may have come to name others since.
    Column<VertexId> off_geometry = {};
    Refusals refusals = {};
    Column<double> shapes = {};  ///< of elements, shape_of, as far as they are known: others are below 0
    /// Of edges of degree 2, length_of; of degree 1, where measuring costs no more than looking up, no rows.
    Column<double> lengths = {};
};

/// A search for the nodes of inner edges, by the energy or the length.
struct NodeSearch {
    EdgeMinimiserOptions options;
    EdgeRules rules;

    explicit NodeSearch(const EdgeMinimiserOptions& given) : options(given), rules(edge_rules(given)) {}
};

/// Largest distance of a facet from the geometry: the smaller one of a length and of a share of the length of an edge.
/// The share limits the turn of the surface along an edge.
struct DistanceLimit {
    double largest = std::numeric_limits<double>::infinity();  ///< model units
    double share = std::numeric_limits<double>::infinity();

    /// The largest distance at an edge of such a length.
    [[nodiscard]] double at(double length) const { return std::min(largest, share * length); }
    [[nodiscard]] bool is_finite() const { return at(1) < std::numeric_limits<double>::infinity(); }
    void tighten(const DistanceLimit& other) {
        largest = std::min(largest, other.largest);
        share = std::min(share, other.share);
    }
};
/// A limit of some facets.
struct DistanceBound {
    double largest = std::numeric_limits<double>::infinity();  ///< see DistanceLimit
    std::vector<Reference> references = {};                    ///< of these facets; empty: of all
    double share = std::numeric_limits<double>::infinity();
};
/// Bounds as a table by reference.
class DistanceBounds {
  public:
    DistanceBounds() = default;
    explicit DistanceBounds(std::span<const DistanceBound> bounds) {
        for (const DistanceBound& bound : bounds)
            for (const Reference reference : bound.references) by_reference_[reference];
        for (const DistanceBound& bound : bounds) {
            const DistanceLimit limit{bound.largest, bound.share};
            for (const Reference reference : bound.references) by_reference_[reference].tighten(limit);
            if (bound.references.empty()) of_all_.tighten(limit);
        }
        for (auto& [reference, limit] : by_reference_) limit.tighten(of_all_);
    }
    /// The limit of facets of a reference: the smaller values of all bounds that hold for it.
    [[nodiscard]] const DistanceLimit& of(Reference reference) const {
        const auto at = by_reference_.find(reference);
        return at == by_reference_.end() ? of_all_ : at->second;
    }
    [[nodiscard]] bool empty() const { return by_reference_.empty() && !of_all_.is_finite(); }

  private:
    DistanceLimit of_all_;
    std::unordered_map<Reference, DistanceLimit> by_reference_;
};

/// What the mesh is brought to: the field, which new vertices ask for theirs, and the geometry on which those of the
/// boundary lie (none: the mesh's own straight facets).
template <int D>
struct AdaptationGoal {
    BackMesh<D> field;
    std::optional<Geometry<D>> geometry;
    // Of degree 2, where inner nodes are wanted: by a search, or without one by the closed form of accuracy.
    EdgeAccuracyOptions accuracy = {};
    std::optional<NodeSearch> search = {};
    /// Of degree 2, where the topology stays: where the node of each edge is wanted, the boundary's too. Then neither
    /// the field nor the geometry is asked.
    Column<LagrangeNode<D>> wanted = {};
    /// Every patch keeps these bounds, or its facets exceed them by no more than the facets that it removes.
    DistanceBounds distance_bounds = {};
    EmbeddedCurves<D> curves = {};  ///< on which the mesh's embedded lines lie
    /// A pass that comes beyond it ends with an error (memory): no field that asks for more than anybody expected takes
    /// the machine along.
    std::size_t max_elements = max_entities;
};

/// The mesh with its metric at each vertex, which is asked of the field; of a surface alone see make_dynamic_surface.
/// Errors: a mesh without elements or triangles (input), those of make_dynamic.
template <int D>
[[nodiscard]] Outcome<Adaptation<D>> begin_adaptation(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                      const BreaksOfMesh& breaks, const AdaptationGoal<D>& goal,
                                                      const Execution& execution);

/// The same of a mesh of degree 2. Errors: also a surface alone (unsupported).
template <int D>
[[nodiscard]] Outcome<Adaptation<D>> begin_adaptation(const QuadraticMesh<D>& mesh, const BreaksOfMesh& breaks,
                                                      const AdaptationGoal<D>& goal, const Execution& execution);

/// The boxes of all facets; of a surface alone of its triangles.
template <int D>
[[nodiscard]] FacetGrid<D> walls_of(const DynamicMesh<D>& mesh);

/// `lengths` anew, of a mesh whose nodes were not changed by commits. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Done> measure_lengths(Adaptation<D>& r, const Execution& execution);

/// An edge to a point of a mesh of degree 2 as the closed form of accuracy bends it (bent_edges): its node from the
/// middle of the chord, its length.
template <int D>
struct BentSpoke {
    VertexId vertex;
    Vec<D> offset;
    double length = 0;
};

/// An operation as it is candidate for.
template <int D>
struct CavityRequest {
    Cavity<D> cavity;
    VertexId point;          ///< of the mesh; invalid: a new one
    Vec<D> place;            ///< of a new one, or where it moves
    VertexMetric<D> metric;  ///< there
    /// The first so many of the cavity's elements hold the point; the others may leave it again to make it fit.
    std::size_t holders = 0;
    Reference reference = 0;
    GeometryPlace lies = {};  ///< where `place` is on the geometry

    // In a mesh of degree 2:
    LogGradient<D> gradient{};  ///< of the field at `place`
    std::optional<Vec<D>> origin =
        {};            ///< of what straight place of the cavity `place` is the curved one; none: itself
    double share = 1;  ///< how far points of the boundary go to the geometry
    std::array<VertexId, 2> halves = {};  ///< of an edge that is split: the edges to its ends keep its curve
    std::vector<BentSpoke<D>> bent = {};  ///< edges inside to `place` that have been bent already, by what is here

    /// To a vertex as it is.
    void join_to(const Adaptation<D>& r, VertexId v) {
        point = v;
        place = r.mesh.points[v];
        const VertexRow<D> known = r.vertices.row(v);
        metric = known.metric;
        lies = known.place;
        gradient = known.gradient;
    }
};

/// What becomes of a new element below the least shape: refused, or not where it is no worse than the worst element
/// that is replaced.
enum class BelowLeast : std::uint8_t { refused, accepted_if_no_worse };

/// What becomes of a new element that is not valid, as the one with its vertices was not before.
enum class InvalidBefore : std::uint8_t { refused, may_stay };

/// What becomes of a patch with more elements that have two facets on one smooth, curved surface.
enum class WallElements : std::uint8_t { accepted, refused };

/// What becomes of a patch that brings no node noticeably nearer to where it is wanted (see gains).
enum class NodeGain : std::uint8_t { not_asked, asked };

/// The least cosine between a new facet's normal and those of the facets that it replaces, if nothing else is asked.
inline constexpr double least_facet_cosine = 0.8;

/// What is asked of the new simplices.
struct PatchLimits {
    double min_shape = 0;                          ///< shape_of each new element: above this
    BelowLeast below_least = BelowLeast::refused;  ///< see QualityBar, which asks for more
    double bad_quality = 0.05;  ///< whatever min_shape is, no new element is below this and below the worst replaced
    double shortest = 0, longest = std::numeric_limits<double>::infinity();  ///< edges at the point, in the metric
    /// Of degree 2: of new elements the scaled Jacobian, unless one that is replaced is worse.
    double min_jacobian = default_bound;
    /// And this, if one that is replaced is worse.
    double lowest_jacobian = 0;
    /// Where every new element has the vertices of one that it replaces: what was not valid may stay so.
    InvalidBefore invalid_before = InvalidBefore::refused;
    /// Linear programmes, each for one inner edge, that may be spent where the old curves do not make a star valid.
    int programmes = 8;
    /// Where that is not enough, all inner nodes of the star may go together, and with them those of so many inner
    /// edges of its outer faces; 0: neither.
    int bend_around = 0;
    /// Inner nodes that were drawn back and then come nearer together to where they are wanted, at most.
    int approaching = 0;
    double facet_cosine = least_facet_cosine;
    /// New facets from the geometry, as a share of their longest edges (see distance_from_geometry).
    double facet_distance = std::numeric_limits<double>::infinity();
    WallElements wall_elements = WallElements::accepted;
    NodeGain node_gain = NodeGain::not_asked;
    /// How often elements may join the cavity, or leave it, to make it fit.
    int corrections = 8;
};

/// Why a request was not granted. The first are those of StarFailure.
enum class RejectionReason : std::uint8_t {
    none,
    empty,
    required,  ///< also: a corner, or a vertex without all of its elements, would move
    surface,
    line,
    ball,
    exists,
    volume,    ///< an element would be inverted, or have no volume; of degree 2: not be valid to the bound
    quality,   ///< an element below min_shape
    length,    ///< an edge at the point out of bounds
    geometry,  ///< facets would turn too far, or be too far from the geometry
    waits,     ///< another patch was in the way: in a later round
    wall,      ///< an element would have two facets on one smooth, curved surface
    crossing,  ///< facets that cross; of degree 2: that are not proved to be disjoint
    gain,      ///< nothing noticeable would change
    height,    ///< an element so flat that the rounding of coordinates could invert it
};
[[nodiscard]] constexpr auto words(RejectionReason) {
    using R = RejectionReason;
    return words_of(
        Word{R::none, "none"}, Word{R::empty, "empty"}, Word{R::required, "required"}, Word{R::surface, "surface"},
        Word{R::line, "line"}, Word{R::ball, "ball"}, Word{R::exists, "exists"}, Word{R::volume, "volume"},
        Word{R::quality, "quality"}, Word{R::length, "length"}, Word{R::wall, "wall"}, Word{R::crossing, "crossing"},
        Word{R::height, "height"}, Word{R::gain, "gain"}, Word{R::geometry, "geometry"}, Word{R::waits, "deferred"});
}
inline constexpr std::size_t rejection_reasons = words(RejectionReason{}).size();

/// A request and what is asked of it.
template <int D>
struct Candidate {
    CavityRequest<D> request;
    PatchLimits limits;
    RejectionReason rejected = RejectionReason::none;  ///< known already: nothing is planned
};

/// Asks the field at a request's place; the search begins at an element of the back mesh.
template <int D>
void ask_field(const Adaptation<D>& r, const AdaptationGoal<D>& goal, ElementId hint, CavityRequest<D>& request) {
    const FieldSample<D> sample = r.mesh.is_curved() ? sample_with_recovered_gradient(goal.field, request.place, hint)
                                                     : sample_value(goal.field, request.place, hint);
    request.metric = VertexMetric<D>(sample.log_metric, sample.location.element);
    if (r.mesh.is_curved()) request.gradient = sample.gradient;
}

/// The nodes of an element of degree 2.
template <int D>
[[nodiscard]] inline QuadraticNodes<D> nodes_of(const DynamicMesh<D>& mesh, ElementId e) {
    QuadraticNodes<D> nodes;
    for (int i = 0; i <= D; ++i) nodes[i] = mesh.points[mesh.elements.vertices[e][i]];
    for (int k = 0; k < edges_per_simplex<D>; ++k) nodes[D + 1 + k] = mesh.nodes[mesh.edges_of[e][k]].point;
    return nodes;
}
/// Of a curved element, as metric_shape of a straight one: the power D/2 of its quality by the mean of its distortion.
template <int D>
[[nodiscard]] inline double curved_shape(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& metrics) {
    return shape_of_quality(curved_quality<D>(nodes, element_metric<D>(metrics)).mean, D);
}

/// How far the node of an edge of degree 2 is from the middle of its chord.
template <int D>
[[nodiscard]] inline Vec<D> offset_of(const DynamicMesh<D>& mesh, EdgeId edge) {
    const auto& [a, b] = mesh.edges[edge];
    return mesh.nodes[edge].point - midpoint(mesh.points[a], mesh.points[b]);
}
template <int D>
[[nodiscard]] inline BentEnd<D> end_of(const VertexMetric<D>& metric) {
    return {metric.log_metric, metric.measure};
}

template <int D>
[[nodiscard]] inline EndSight<D> sight_of(const VertexMetric<D>& metric,
                                          const std::type_identity_t<LogGradient<D>>& gradient) {
    return {&metric.log_metric, &gradient, &metric.measure};
}

/// Of an edge of a surface alone to infinity: what nobody wants to change.
inline constexpr double length_to_infinity = 1;

/// The length of an edge in the metric, along its curve.
template <int D>
[[nodiscard]] inline double measured_length(const Adaptation<D>& r, EdgeId edge) {
    if (r.mesh.is_at_infinity(edge)) return length_to_infinity;
    const auto& [a, b] = r.mesh.edges[edge];
    if (r.mesh.is_curved())
        return bent_length<D>(end_of(r.vertices.metrics[a]), end_of(r.vertices.metrics[b]),
                              r.mesh.points[b] - r.mesh.points[a], offset_of(r.mesh, edge));
    return edge_length(r.vertices.metrics[a].measure, r.vertices.metrics[b].measure,
                       r.mesh.points[b] - r.mesh.points[a]);
}
/// The same, as it is known.
template <int D>
[[nodiscard]] inline double length_of(const Adaptation<D>& r, EdgeId edge) {
    return r.lengths.empty() ? measured_length(r, edge) : r.lengths[edge];
}
/// The shape of an element: metric_shape of a straight one, of a surface alone triangle_shape.
/// `point_at(i)`, `metric_at(i)` of the local vertices of an element.
template <int D>
[[nodiscard]] double straight_shape(const DynamicMesh<D>& mesh, auto&& point_at, auto&& metric_at) {
    if constexpr (D == 3)
        if (mesh.is_surface())
            return triangle_shape({point_at(0), point_at(1), point_at(2)}, {metric_at(0), metric_at(1), metric_at(2)});
    std::array<Vec<D>, D + 1> corners;
    std::array<const MeasuringMetric<D>*, D + 1> metrics;
    for (int i = 0; i <= D; ++i) {
        corners[i] = point_at(i);
        metrics[i] = metric_at(i);
    }
    return metric_shape<D>(corners, metrics);
}
template <int D>
[[nodiscard]] inline double straight_shape_of(const Adaptation<D>& r, ElementId e) {
    const auto& vertices = r.mesh.elements.vertices[e];
    return straight_shape(
        r.mesh, [&](int i) -> const Vec<D>& { return r.mesh.points[vertices[i]]; },
        [&](int i) { return &r.vertices.metrics[vertices[i]].measure; });
}
template <int D>
[[nodiscard]] inline double shape_of(const Adaptation<D>& r, ElementId e) {
    if (!r.mesh.is_curved()) return straight_shape_of(r, e);
    VertexLogMetrics<D> logs;
    for (int i = 0; i <= D; ++i) logs[i] = r.vertices.metrics[r.mesh.elements.vertices[e][i]].log_metric;
    return curved_shape<D>(nodes_of(r.mesh, e), logs);
}
/// The same, not measured again where it is known.
template <int D>
[[nodiscard]] inline double known_shape_of(const Adaptation<D>& r, ElementId e) {
    const double known = e.index() < r.shapes.size() ? r.shapes[e.index()] : -1.0;
    return known >= 0 ? known : shape_of(r, e);
}
/// Of a straight one, with a point in the place of a local vertex.
template <int D>
[[nodiscard]] inline double shape_with(const Adaptation<D>& r, ElementId e, int local, const Vec<D>& place,
                                       const MeasuringMetric<D>& metric) {
    const auto& vertices = r.mesh.elements.vertices[e];
    return straight_shape(
        r.mesh, [&](int i) -> const Vec<D>& { return i == local ? place : r.mesh.points[vertices[i]]; },
        [&](int i) { return i == local ? &metric : &r.vertices.metrics[vertices[i]].measure; });
}

/// How near to unit a mesh is.
struct UnitMeshStatistics {
    std::size_t edges = 0, unit_edges = 0, elements = 0;
    double shortest = 0, longest = 0, mean_length = 0;
    double worst_quality = 1, mean_quality = 0;
    [[nodiscard]] double unit_share() const {
        return edges == 0 ? 1 : static_cast<double>(unit_edges) / static_cast<double>(edges);
    }
};
template <int D>
[[nodiscard]] Outcome<UnitMeshStatistics> unit_mesh_statistics(const Adaptation<D>& r, const Execution& execution);

/// Of elements that are to be removed: the shape of the worst.
template <int D>
[[nodiscard]] double worst_shape_of(const Adaptation<D>& r, const std::vector<ElementId>& elements) {
    double worst = std::numeric_limits<double>::infinity();
    for (const ElementId e : elements) worst = std::min(worst, known_shape_of(r, e));
    return worst;
}

/// What the shape of each new element of a patch must be: the one place where that is judged, for every pass and either
/// degree. What its limits ask for, and whatever `min_shape` is: no new element is below `bad_quality` and below
/// the worst that is replaced. Where the limits allow it, that worst one is enough.
template <int D>
class QualityBar {
  public:
    QualityBar(const Adaptation<D>& r, const PatchLimits& limits, const std::vector<ElementId>& replaced)
        : r_(r), limits_(limits), replaced_(replaced) {}

    [[nodiscard]] bool is_met(double shape) {
        const double asked = limits_.min_shape;
        if (shape > asked && shape >= shape_of_quality(limits_.bad_quality, D)) return true;
        if (!(shape > asked) && limits_.below_least == BelowLeast::refused) return false;
        return shape >= worst_replaced();
    }

  private:
    /// But for the rounding of an element that is measured with its vertices in another order.
    [[nodiscard]] double worst_replaced() {
        constexpr double rounding = 1e-9;
        if (!worst_) worst_ = worst_shape_of(r_, replaced_);
        return (1 - rounding) * *worst_;
    }

    const Adaptation<D>& r_;
    const PatchLimits& limits_;
    const std::vector<ElementId>& replaced_;
    std::optional<double> worst_;
};

}  // namespace camber
