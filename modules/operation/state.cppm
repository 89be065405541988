// State and goal of an adaptation, requests, cache of rejections, lengths and qualities.
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

/// The metric at a vertex: its logarithm, and a form for fast length computations. `back`: element of the back mesh
/// that contains the vertex.
template <int D>
struct VertexMetric {
    LogMetric<D> log_metric;
    MeasuringMetric<D> measure;
    ElementId back;

    VertexMetric() = default;
    VertexMetric(const LogMetric<D>& input, ElementId at) : log_metric(input), measure(input), back(at) {}
    friend bool operator==(const VertexMetric&, const VertexMetric&) = default;
};

template <int D>
struct VertexRow {
    VertexMetric<D> metric;
    GeometryPosition place;
    LogGradient<D> gradient{};
};

/// Data of all vertices. New kinds of vertex data belong here, because commits update all columns of this class.
template <int D>
struct VertexData {
    Column<VertexMetric<D>> metrics;
    /// Geometric entity of each boundary vertex. Includes parameters if the vertex lies on the entity.
    Column<GeometryPosition> places = {};
    Column<LogGradient<D>> gradients = {};  ///< degree 2: recovered gradients of the field

    [[nodiscard]] GeometryPosition place(VertexId v) const { return places.empty() ? GeometryPosition{} : places[v]; }
    [[nodiscard]] VertexRow<D> row(VertexId v) const {
        return {metrics[v], place(v), gradients.empty() ? LogGradient<D>{} : gradients[v]};
    }
    /// Stores `rows[i]` at `ids[i]`. `vertices`: new number of vertices.
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

enum class CachedPass : std::uint8_t { collapse, swap, smooth, remove };
inline constexpr std::size_t cached_passes = 4;

/// Cache of rejected requests at entities. A request depends only on the elements at the vertices of its entity, except
/// for crossings with other facets. So it stays rejected until one of these elements changes. Time is counted in
/// commits.
class RejectionCache {
  public:
    void begin(CachedPass pass, std::vector<double> limits) {
        OfPass& of = of_[static_cast<std::size_t>(pass)];
        if (of.limits != limits) of = {std::move(limits), {}};
    }
    template <class Tag>
    void refuse(CachedPass pass, std::span<const Id<Tag>> ids, std::size_t entities) {
        if (ids.empty()) return;
        OfPass& of = of_[static_cast<std::size_t>(pass)];
        auto requested = take(std::move(of.requested));
        requested.resize(entities, never);
        for (const Id<Tag> id : ids) requested[id.index()] = now_ + 1;
        of.requested = std::move(requested);
    }
    template <class Tag>
    [[nodiscard]] bool is_rejected(CachedPass pass, Id<Tag> id, std::span<const VertexId> vertices) const {
        const auto& requested = of_[static_cast<std::size_t>(pass)].requested;
        if (id.index() >= requested.size() || requested[id] == never) return false;
        for (const VertexId v : vertices)
            if (v.index() < changed_.size() && changed_[v] >= requested[id]) return false;
        return true;
    }
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
        Column<std::uint32_t> requested;  ///< per entity: 1 + number of commits before its last rejection
    };
    std::array<OfPass, cached_passes> of_;
    Column<std::uint32_t> changed_;  ///< per vertex: number of the last commit that created an element at it
    std::uint32_t now_ = 0;
};

/// A mesh during adaptation, immutable between commits.
template <int D>
struct Adaptation {
    DynamicMesh<D> mesh;
    VertexData<D> vertices;
    FacetGrid<D> walls = {};  ///< bounding boxes of all facets
    /// Boundary vertices off the geometry, including new vertices that moved only a part of the way. Some ids may have
    /// been reused since.
    Column<VertexId> off_geometry = {};
    RejectionCache rejection_cache = {};
    Column<double> shapes = {};  ///< quality (`shape_of`) of each element; negative: unknown
    /// Length (`length_of`) of each edge. Empty in degree 1, where computing a length costs no more than a look-up.
    Column<double> lengths = {};
};

/// Parameters of the search for inner node positions of minimum energy or length.
struct NodeSearch {
    EdgeMinimiserOptions options;
    EdgeRules rules;

    explicit NodeSearch(const EdgeMinimiserOptions& input) : options(input), rules(edge_rules(input)) {}
};

/// Limit of the distance of a facet or one of its edges from the geometry: min(`largest`, `share` × length). The length
/// is that of the edge or, for the facet, of its longest edge. `share` limits the angle by which the surface turns
/// along the edge.
struct DistanceLimit {
    double largest = std::numeric_limits<double>::infinity();  ///< in model units
    double share = std::numeric_limits<double>::infinity();

    [[nodiscard]] double at(double length) const { return std::min(largest, share * length); }
    [[nodiscard]] bool is_finite() const { return at(1) < std::numeric_limits<double>::infinity(); }
    void tighten(const DistanceLimit& other) {
        largest = std::min(largest, other.largest);
        share = std::min(share, other.share);
    }
};
struct DistanceBound {
    double largest = std::numeric_limits<double>::infinity();
    std::vector<Reference> references = {};  ///< empty: all facets
    double share = std::numeric_limits<double>::infinity();
};
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
    [[nodiscard]] const DistanceLimit& of(Reference reference) const {
        const auto at = by_reference_.find(reference);
        return at == by_reference_.end() ? of_all_ : at->second;
    }
    [[nodiscard]] bool empty() const { return by_reference_.empty() && !of_all_.is_finite(); }

  private:
    DistanceLimit of_all_;
    std::unordered_map<Reference, DistanceLimit> by_reference_;
};

/// Goal of an adaptation: the metric field, sampled at new vertices, and the geometry of the boundary. Without a
/// geometry, the facets define the boundary.
template <int D>
struct AdaptationGoal {
    BackMesh<D> field;
    std::optional<Geometry<D>> geometry;
    // Degree 2: if `search` has a value, it determines the targets of inner nodes. Otherwise, the targets are the
    // positions of maximum accuracy, in closed form.
    EdgeAccuracyOptions accuracy = {};
    std::optional<NodeSearch> search = {};
    /// Degree 2 with fixed topology: target of each edge's node, also on the boundary. If not empty, the targets
    /// replace field and geometry.
    Column<LagrangeNode<D>> target_nodes = {};
    /// Bounds of the distances of facets from the geometry. New facets meet them, or exceed them by no more than
    /// removed facets do.
    DistanceBounds distance_bounds = {};
    EmbeddedCurves<D> curves = {};
    /// Maximum number of elements; more are an error (memory).
    std::size_t max_elements = max_entities;
};

/// Creates the state and samples the field at all vertices. Standalone surfaces: see `make_dynamic_surface`. Errors:
/// input (no elements or triangles), those of `make_dynamic`.
template <int D>
[[nodiscard]] Outcome<Adaptation<D>> begin_adaptation(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                      const BreaksOfMesh& breaks, const AdaptationGoal<D>& goal,
                                                      const Execution& execution);

/// Errors: those of the linear overload, and unsupported (standalone surface).
template <int D>
[[nodiscard]] Outcome<Adaptation<D>> begin_adaptation(const QuadraticMesh<D>& mesh, const BreaksOfMesh& breaks,
                                                      const AdaptationGoal<D>& goal, const Execution& execution);

template <int D>
[[nodiscard]] FacetGrid<D> facet_grid_of(const DynamicMesh<D>& mesh);

/// Recomputes `lengths`. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<Done> measure_lengths(Adaptation<D>& r, const Execution& execution);

/// A curved edge from a point to `vertex`, computed by `bent_edges`. `offset`: vector from the chord middle to the
/// edge's node.
template <int D>
struct BentSpoke {
    VertexId vertex;
    Vec<D> offset;
    double length = 0;
};

template <int D>
struct CavityRequest {
    Cavity<D> cavity;
    VertexId point;  ///< invalid for a new vertex
    Vec<D> place;    ///< position of a new or moved point
    VertexMetric<D> metric;
    /// The first `fixed_element_count` elements of the cavity contain the point; the others may leave the cavity.
    std::size_t fixed_element_count = 0;
    Reference reference = 0;
    GeometryPosition geometry_position = {};

    // The members below are for degree 2.
    LogGradient<D> gradient{};            ///< gradient of the metric field at `place`
    std::optional<Vec<D>> origin = {};    ///< position in the straight cavity that the removed elements map to `place`;
                                          ///< empty: `place` itself
    double share = 1;                     ///< share of its way to the geometry by which a boundary point moves
    std::array<VertexId, 2> halves = {};  ///< ends of the split edge whose curve the new edges preserve, if any
    std::vector<BentSpoke<D>> bent = {};  ///< inner edges from the point whose nodes are known

    void join_to(const Adaptation<D>& r, VertexId v) {
        point = v;
        place = r.mesh.points[v];
        const VertexRow<D> known = r.vertices.row(v);
        metric = known.metric;
        geometry_position = known.place;
        gradient = known.gradient;
    }
};

enum class BelowMinimum : std::uint8_t { refused, accepted_if_no_worse };

/// Policy for new invalid elements, each of which replaces an invalid element with the same vertices.
enum class InvalidReplacement : std::uint8_t { refused, may_stay };

/// Policy for patches that add two-facet elements (`adds_two_facet_elements`).
enum class TwoFacetElements : std::uint8_t { accepted, refused };

/// Policy for patches that move no node noticeably (`moves_noticeably`).
enum class NodeGain : std::uint8_t { not_requested, requested };

/// Default minimum cosine between normals of new and replaced facets.
inline constexpr double min_facet_cosine = 0.8;

struct PatchLimits {
    double min_shape = 0;
    BelowMinimum below_minimum = BelowMinimum::refused;  ///< see `QualityCriterion`
    double bad_quality = 0.05;  ///< no element may be worse than both this and the worst removed element
    double shortest = 0, longest = std::numeric_limits<double>::infinity();  ///< limits of the metric lengths of edges
                                                                             ///< at the point
    /// Degree 2: minimum scaled Jacobian of new elements.
    double min_jacobian = default_bound;
    /// Used instead of `min_jacobian` if a removed element violates `min_jacobian`.
    double lowest_jacobian = 0;
    InvalidReplacement invalid_replacement = InvalidReplacement::refused;
    /// Maximum number of linear programs. If relaxation to the old curves does not make the elements valid, each
    /// program moves one inner node.
    int optimisation_problems = 8;
    /// Maximum number of nodes on outer faces that the second joint problem may move (step 4 of `CurvedNodes`). 0: no
    /// joint problem.
    int bend_around = 0;
    /// Maximum number of relaxed inner nodes that move together towards their targets.
    int approaching = 0;
    double facet_cosine = min_facet_cosine;
    /// Maximum distance of new facets from the geometry, relative to their longest edges (`distance_from_geometry`).
    double facet_distance = std::numeric_limits<double>::infinity();
    TwoFacetElements two_facet_elements = TwoFacetElements::accepted;
    NodeGain node_gain = NodeGain::not_requested;
    /// Maximum number of changes of the cavity.
    int corrections = 8;
};

/// Reasons for rejection. `empty` to `exists` are those of `StarFailure`.
enum class RejectionReason : std::uint8_t {
    none,
    empty,
    required,  ///< as in `StarFailure`; or the point would move, but is a corner, is required, or has elements outside
               ///< the cavity
    surface,
    line,
    ball,
    exists,
    volume,    ///< an element is inverted or has no volume; degree 2: violates the Jacobian bound
    quality,   ///< an element has a quality below `min_shape`
    length,    ///< an edge at the point is too short or too long
    geometry,  ///< new facets turn too far from the removed ones, or are too far from the geometry
    waits,     ///< conflicts with another patch; retried later
    wall,      ///< an element has two facets on one smooth, curved surface
    crossing,  ///< facets cross; degree 2: not proved disjoint
    gain,      ///< no node moves noticeably
    height,    ///< an element is so flat that rounding of coordinates could invert it
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

template <int D>
struct Candidate {
    CavityRequest<D> request;
    PatchLimits limits;
    RejectionReason rejected = RejectionReason::none;
};

/// Samples the field at `request.place` and stores the metric in the request. `hint`: element of the back mesh at which
/// the search starts.
template <int D>
void sample_field(const Adaptation<D>& r, const AdaptationGoal<D>& goal, ElementId hint, CavityRequest<D>& request) {
    const FieldSample<D> sample = r.mesh.is_curved() ? sample_with_recovered_gradient(goal.field, request.place, hint)
                                                     : sample_value(goal.field, request.place, hint);
    request.metric = VertexMetric<D>(sample.log_metric, sample.location.element);
    if (r.mesh.is_curved()) request.gradient = sample.gradient;
}

template <int D>
[[nodiscard]] inline QuadraticNodes<D> nodes_of(const DynamicMesh<D>& mesh, ElementId e) {
    QuadraticNodes<D> nodes;
    for (int i = 0; i <= D; ++i) nodes[i] = mesh.points[mesh.elements.vertices[e][i]];
    for (int k = 0; k < edges_per_simplex<D>; ++k) nodes[D + 1 + k] = mesh.nodes[mesh.edges_of[e][k]].point;
    return nodes;
}
/// Quality of a curved element on the scale of `metric_shape`: the quality by mean distortion, to the power D/2.
template <int D>
[[nodiscard]] inline double curved_shape(const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& metrics) {
    return shape_of_quality(curved_quality<D>(nodes, element_metric<D>(metrics)).mean, D);
}

template <int D>
[[nodiscard]] inline Vec<D> offset_of(const DynamicMesh<D>& mesh, EdgeId edge) {
    const auto& [a, b] = mesh.edges[edge];
    return mesh.nodes[edge].point - midpoint(mesh.points[a], mesh.points[b]);
}
template <int D>
[[nodiscard]] inline EdgeEndMetric<D> end_of(const VertexMetric<D>& metric) {
    return {metric.log_metric, metric.measure};
}

template <int D>
[[nodiscard]] inline EndSample<D> end_sample_of(const VertexMetric<D>& metric,
                                                const std::type_identity_t<LogGradient<D>>& gradient) {
    return {&metric.log_metric, &gradient, &metric.measure};
}

/// Length of edges to infinity in standalone surface meshes. No operation changes an edge of length 1.
inline constexpr double length_to_infinity = 1;

template <int D>
[[nodiscard]] inline double measured_length(const Adaptation<D>& r, EdgeId edge) {
    if (r.mesh.is_at_infinity(edge)) return length_to_infinity;
    const auto& [a, b] = r.mesh.edges[edge];
    if (r.mesh.is_curved())
        return quadratic_edge_length<D>(end_of(r.vertices.metrics[a]), end_of(r.vertices.metrics[b]),
                                        r.mesh.points[b] - r.mesh.points[a], offset_of(r.mesh, edge));
    return edge_length(r.vertices.metrics[a].measure, r.vertices.metrics[b].measure,
                       r.mesh.points[b] - r.mesh.points[a]);
}
template <int D>
[[nodiscard]] inline double length_of(const Adaptation<D>& r, EdgeId edge) {
    return r.lengths.empty() ? measured_length(r, edge) : r.lengths[edge];
}
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
template <int D>
[[nodiscard]] inline double cached_shape_of(const Adaptation<D>& r, ElementId e) {
    const double known = e.index() < r.shapes.size() ? r.shapes[e.index()] : -1.0;
    return known >= 0 ? known : shape_of(r, e);
}
template <int D>
[[nodiscard]] inline double shape_with(const Adaptation<D>& r, ElementId e, int local, const Vec<D>& place,
                                       const MeasuringMetric<D>& metric) {
    const auto& vertices = r.mesh.elements.vertices[e];
    return straight_shape(
        r.mesh, [&](int i) -> const Vec<D>& { return i == local ? place : r.mesh.points[vertices[i]]; },
        [&](int i) { return i == local ? &metric : &r.vertices.metrics[vertices[i]].measure; });
}

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

template <int D>
[[nodiscard]] double worst_shape_of(const Adaptation<D>& r, const std::vector<ElementId>& elements) {
    double worst = std::numeric_limits<double>::infinity();
    for (const ElementId e : elements) worst = std::min(worst, cached_shape_of(r, e));
    return worst;
}

/// Minimum quality of new elements. An element must exceed `min_shape` or, if `below_minimum` allows that, be no worse
/// than the worst removed element. It must not be worse than both `bad_quality` and the worst removed element.
template <int D>
class QualityCriterion {
  public:
    QualityCriterion(const Adaptation<D>& r, const PatchLimits& limits, const std::vector<ElementId>& replaced)
        : r_(r), limits_(limits), replaced_(replaced) {}

    [[nodiscard]] bool is_met(double shape) {
        const double requested = limits_.min_shape;
        if (shape > requested && shape >= shape_of_quality(limits_.bad_quality, D)) return true;
        if (!(shape > requested) && limits_.below_minimum == BelowMinimum::refused) return false;
        return shape >= worst_replaced();
    }

  private:
    /// Lowest quality of the removed elements, minus 10⁻⁹ of it: rounding of a quality depends on the order of
    /// vertices.
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
