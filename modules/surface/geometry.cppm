module;
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
export module camber.surface:geometry;
import camber.core;
import camber.bezier;

export namespace camber {

/// A plane (2D: a line). The normal may have any length.
template <int D>
struct Plane {
    Vec<D> point, normal;
    friend bool operator==(const Plane&, const Plane&) = default;
};

/// Closest point of a surface and its unit normal (outwards on closed surfaces). Coordinates along an axis-aligned
/// normal of a plane are exact. If the closest point is not unique (centre, axis), one is chosen.
template <int D>
struct SurfaceFoot {
    Vec<D> point, normal;
};

}  // namespace camber

namespace camber {

/// v / |v|; `otherwise` for the zero vector.
template <int D>
[[nodiscard]] Vec<D> unit_or(const Vec<D>& v, const Vec<D>& otherwise) {
    const double length = norm(v);
    return length > 0 ? v / length : otherwise;
}

template <int D>
[[nodiscard]] Vec<D> some_direction() {
    Vec<D> d;
    d[0] = 1;
    return d;
}

[[nodiscard]] inline Vec<3> some_perpendicular(const Vec<3>& axis) {
    const Vec<3> x{{1, 0, 0}}, y{{0, 1, 0}};
    return normalised(cross(axis, std::fabs(axis[0]) < 0.7 * norm(axis) ? x : y));
}

/// Axis of an exactly axis-aligned unit normal, or −1.
template <int D>
[[nodiscard]] int axis_of(const Vec<D>& normal) {
    for (int i = 0; i < D; ++i)
        if (std::fabs(normal[i]) == 1) return i;
    return -1;
}

template <int D>
[[nodiscard]] SurfaceFoot<D> foot(const Plane<D>& plane, const Vec<D>& p) {
    const Vec<D> n = unit_or(plane.normal, some_direction<D>());
    Vec<D> point = p - dot(p - plane.point, n) * n;
    if (const int k = axis_of(n); k >= 0) {
        point = p;
        point[k] = plane.point[k];
    }
    return {point, n};
}

/// On an axis-aligned plane, sets the constant coordinate of x exactly; on other planes returns x.
template <int D>
[[nodiscard]] Vec<D> snapped(const Plane<D>& plane, Vec<D> x) {
    if (const int k = axis_of(normalised(plane.normal)); k >= 0) x[k] = plane.point[k];
    return x;
}

[[nodiscard]] inline Plane<2> plane_through(const std::array<Vec<2>, 2>& p) {
    return {p[0], {{p[1][1] - p[0][1], p[0][0] - p[1][0]}}};
}
[[nodiscard]] inline Plane<3> plane_through(const std::array<Vec<3>, 3>& p) {
    return {p[0], cross(p[1] - p[0], p[2] - p[0])};
}

/// Closest point to p on the line where the tangent planes at the surface points a and b intersect; empty if these
/// planes are nearly parallel.
[[nodiscard]] inline std::optional<Vec<3>> closest_on_both_planes(const SurfaceFoot<3>& a, const SurfaceFoot<3>& b,
                                                                  const Vec<3>& p) {
    constexpr double min_sine_squared = 0.003;
    const double c = dot(a.normal, b.normal);
    const double determinant = 1 - c * c;
    if (determinant < min_sine_squared) return std::nullopt;
    const double to_a = dot(a.point - p, a.normal), to_b = dot(b.point - p, b.normal);
    const double alpha = (to_a - c * to_b) / determinant, beta = (to_b - c * to_a) / determinant;
    return p + alpha * a.normal + beta * b.normal;
}

/// Closest point to p on the intersection curve of two surfaces; `foot_a` and `foot_b` return a SurfaceFoot. Iterates
/// projections of p onto the intersection of the tangent planes. The last steps only move the point back onto both
/// surfaces. Empty if the surfaces are nearly tangent (below about 3°) or do not meet near p.
template <class FootA, class FootB>
[[nodiscard]] std::optional<Vec<3>> closest_on_intersection(FootA&& foot_a, FootB&& foot_b, const Vec<3>& p) {
    constexpr int max_steps = 60;
    constexpr int restoring_steps = 3;
    Vec<3> x = p;
    double first_step = 0;
    for (int step = 0; step < max_steps; ++step) {
        const auto next = closest_on_both_planes(foot_a(x), foot_b(x), p);
        if (!next || !is_finite(*next)) return std::nullopt;
        const double moved_by = distance(*next, x);
        if (step == 0) first_step = moved_by;
        x = *next;
        if (moved_by <= 1e-15 * (first_step + norm(x))) break;
    }
    for (int step = 0; step < restoring_steps; ++step) {
        const auto next = closest_on_both_planes(foot_a(x), foot_b(x), x);
        if (!next) return std::nullopt;
        x = *next;
    }
    const double off = distance(foot_a(x).point, x) + distance(foot_b(x).point, x);
    if (!(off <= 1e-9 * (first_step + norm(x)))) return std::nullopt;
    return x;
}

}  // namespace camber

export namespace camber {

/// In 2D, surfaces are the boundary's curves; they meet in corners.
enum class GeometryKind : std::uint8_t { none, corner, curve, surface };

/// An entity of a geometry. Its number depends on the implementation: a patch or ridge curve of a Surrogate, or a row
/// of AnalyticGeometry's table (the first of equal rows). MixedGeometry uses other numbers;
/// `GeometryModel::name_of_entity` returns the original ones.
struct GeometryEntity {
    static constexpr std::int64_t unnumbered = -1;

    GeometryKind kind = GeometryKind::none;
    std::int64_t id = unnumbered;
    /// The two surfaces at a curve, the lower first; `unnumbered`: none or unknown.
    std::array<std::int64_t, 2> sides{unnumbered, unnumbered};

    [[nodiscard]] static constexpr GeometryEntity surface(std::int64_t number) {
        return {GeometryKind::surface, number, {unnumbered, unnumbered}};
    }
    /// True if the entity is this surface or a curve on it.
    [[nodiscard]] constexpr bool lies_on(const GeometryEntity& surface) const {
        if (surface.kind != GeometryKind::surface || surface.id == unnumbered) return false;
        return kind == GeometryKind::curve ? sides[0] == surface.id || sides[1] == surface.id : *this == surface;
    }
    friend constexpr bool operator==(const GeometryEntity&, const GeometryEntity&) = default;
};

/// Local coordinates: two on a surface, one on a curve (2D: one on a surface). `piece`: facet or edge of a surrogate.
struct GeometryParameters {
    std::array<double, 2> u{};
    std::uint32_t piece = 0;
    friend bool operator==(const GeometryParameters&, const GeometryParameters&) = default;
};

/// Start of a closest-point search.
///
/// - Surrogate: starts at `facet` (local, fast). Without `facet`, searches the facets of `entity`, else of `reference`,
///   else all facets.
/// - Analytic: uses the surface of `entity`, else of `reference`.
/// - Mixed: uses the part that owns `entity` or `reference`. Without both, the surrogate's facet (`facet`, or the
///   nearest) selects the part.
///
/// Only surfaces count as `entity`; `GeometryModel::on_edge` projects onto curves.
struct SurfaceHint {
    FacetId facet = {};
    std::optional<Reference> reference = {};
    GeometryEntity entity = {};
};

/// A point of the geometry, its unit normal (zero on a curve), and its distance from the projected point. `facet`:
/// facet of a surrogate, else invalid. Without a surface: the unchanged point, a zero normal, no entity.
template <int D>
struct SurfacePoint {
    Vec<D> point, normal;
    double distance = 0;
    FacetId facet = {};
    GeometryEntity entity = {};
    std::optional<Reference> reference = {};
    std::optional<GeometryParameters> parameters = {};  ///< for `evaluate`, if available
};

struct GeometryPosition {
    GeometryEntity entity;
    std::optional<GeometryParameters> parameters = {};
    friend bool operator==(const GeometryPosition&, const GeometryPosition&) = default;
};
template <int D>
[[nodiscard]] GeometryPosition place_of(const SurfacePoint<D>& point) {
    return {point.entity, point.parameters};
}

/// Point of an entity with its derivatives by the parameters (a curve has one) and unit normal (zero on a curve).
template <int D>
struct EntityPoint {
    Vec<D> point;
    std::array<Vec<D>, 2> tangents{};
    Vec<D> normal;
};

/// Name of an entity and its number from 1; 0: none.
struct EntityName {
    std::string_view kind = "none";
    std::size_t number = 0;
    friend constexpr bool operator==(const EntityName&, const EntityName&) = default;
};

/// Sample points of a geometry; points of an entity are consecutive. Each weight is the area or length that its point
/// represents. `near`: a nearby facet, or invalid.
template <int D>
struct GeometrySamples {
    struct Entity {
        GeometryEntity entity;
        std::size_t begin = 0, end = 0;
    };
    std::vector<Entity> entities;
    Buffer<Vec<D>> points;
    Buffer<double> weights;
    Buffer<FacetId> near;

    void add(const Vec<D>& point, double weight, FacetId facet = {}) {
        points.push_back(point);
        weights.push_back(weight);
        near.push_back(facet);
        entities.back().end = points.size();
    }
    void begin(const GeometryEntity& entity) { entities.push_back({entity, points.size(), points.size()}); }
};

/// A boundary facet. `id` is invalid outside of a mesh.
template <int D>
struct FacetSite {
    FacetId id;
    Reference reference = 0;
    std::array<Vec<D>, D> corners{};
};

template <int D>
[[nodiscard]] FacetSite<D> facet_site(const LinearMesh<D>& mesh, FacetId f) {
    FacetSite<D> site{f, mesh.facets.references[f], {}};
    for (std::size_t i = 0; i < D; ++i) site.corners[i] = mesh.points[mesh.facets.vertices[f][i]];
    return site;
}

template <int D>
[[nodiscard]] std::vector<FacetSite<D>> facet_sites(const LinearMesh<D>& mesh, std::span<const FacetId> facets) {
    std::vector<FacetSite<D>> sites;
    sites.reserve(facets.size());
    for (const FacetId f : facets) sites.push_back(facet_site(mesh, f));
    return sites;
}

/// A boundary edge with its facets, which determine the geometry there. `id` is invalid outside of a mesh.
template <int D>
struct EdgeSite {
    EdgeId id;
    EdgeKind kind = EdgeKind::surface;
    std::array<Vec<D>, 2> ends{};  ///< lower vertex first
    std::vector<FacetSite<D>> facets;

    [[nodiscard]] Vec<D> middle() const { return midpoint(ends[0], ends[1]); }
};

/// Largest distance of some points, and the number of points that were projected; the other points are known to be
/// nearer.
struct LargestDistance {
    double largest = 0;
    std::size_t projected = 0;
    FacetId facet = {};  ///< facet of that distance, if several facets are searched
};

/// Abstract interface of a geometry, the boundary of the domain. Implementations define `project` and `surface_at`; the
/// other functions have defaults based on these ("Default: …"). Models are immutable and thread-safe; results depend
/// only on the arguments.
template <int D>
class GeometryModel {
  public:
    virtual ~GeometryModel() = default;

    /// Returns the closest point to p of the surface that the hint selects; without a surface, p with a zero normal.
    /// Idempotent up to rounding.
    [[nodiscard]] virtual SurfacePoint<D> project(const SurfaceHint& hint, const Vec<D>& p) const = 0;
    /// Surface of a facet, if any. Equal surfaces are one entity.
    [[nodiscard]] virtual GeometryEntity surface_at(const FacetSite<D>& facet) const = 0;
    [[nodiscard]] virtual bool has_surface_at(const FacetSite<D>& facet) const {
        return surface_at(facet).kind != GeometryKind::none;
    }

    /// Returns the point of an entity at parameters that `project` returned. Default: empty.
    [[nodiscard]] virtual std::optional<EntityPoint<D>> evaluate(const GeometryEntity& entity,
                                                                 const GeometryParameters& parameters) const;
    /// Entity of an edge. Default: the surface of its facets, or the curve of two surfaces.
    [[nodiscard]] virtual GeometryEntity entity_at_edge(const EdgeSite<D>& edge) const;
    /// Entity of a vertex with these facets. Default: their surface, the curve of two surfaces, or the corner of more
    /// surfaces.
    [[nodiscard]] virtual GeometryEntity entity_at_vertex(std::span<const FacetSite<D>> around) const;

    /// Plane (2D: line) of a facet's surface, if planar. Ridges beside a plane are planar, ridges between two planes
    /// are straight. Default: the facet's own plane if it has no surface.
    [[nodiscard]] virtual std::optional<Plane<D>> plane_at(const FacetSite<D>& facet) const;
    /// Closest point of the surface at an edge, or of the curve where two surfaces meet. Beside a surface, facets
    /// without a surface count as planes. Between two planes, p is unchanged. Default: uses `project`, and for curves
    /// also the tangent planes of both surfaces.
    [[nodiscard]] virtual SurfacePoint<D> on_edge(const EdgeSite<D>& edge, const Vec<D>& p) const;
    /// Middle of the edge on the geometry. Default: `on_edge` of the chord's middle.
    [[nodiscard]] virtual Vec<D> middle_of(const EdgeSite<D>& edge) const;

    /// Distances of points[i] from a facet's surface; at[i] are the coordinates of points[i] in the curved facet.
    /// Returns false, and writes nothing, without a surface. Default: by `project`. A single call per facet avoids
    /// repeated lookups.
    [[nodiscard]] virtual bool distances(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>> at,
                                         std::span<const Vec<D>> points, std::span<double> out) const;
    /// Returns the larger of `bound` and the largest of `distances`, up to rounding; empty without a surface.
    /// Implementations that can cheaply prove points within the bound override this function.
    [[nodiscard]] virtual std::optional<LargestDistance> largest_distance(const FacetSite<D>& facet,
                                                                          std::span<const Barycentric<D - 1>> at,
                                                                          std::span<const Vec<D>> points,
                                                                          double bound) const;
    /// True if each points[i] is within bounds[i] of a facet's surface, or the facet has no surface. Implementations
    /// with cheap upper bounds override this function.
    [[nodiscard]] virtual bool are_within(const FacetSite<D>& facet, std::span<const Vec<D>> points,
                                          std::span<const double> bounds) const;
    /// True if all facets with this reference and an invalid `id` have the same surface, so that one `are_within` call
    /// can serve several facets. Default: false.
    [[nodiscard]] virtual bool is_one_surface(Reference reference) const;
    /// Computes points of the geometry that correspond to coordinates of a facet. They are on the facet's own piece, if
    /// the surface has pieces, else closest to the straight facet. Returns false, and writes nothing, without a
    /// surface. Default: by `project`.
    [[nodiscard]] virtual bool surface_points(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>> at,
                                              std::span<Vec<D>> out) const;
    /// True if the surface is a curved piece made from this facet; `surface_points` and `middle_of` then give points of
    /// that piece. Default: false.
    [[nodiscard]] virtual bool is_built_from(const FacetSite<D>& facet) const;
    /// Search start for a facet's surface. Includes the facet only if the surface was made from it: facet numbers of
    /// another mesh are unrelated.
    [[nodiscard]] SurfaceHint hint_at(const FacetSite<D>& facet, const GeometryEntity& entity = {}) const {
        return {is_built_from(facet) ? facet.id : FacetId{}, facet.reference, entity};
    }
    /// Distance from the geometry of a point p where these facets (at least one) meet. Default: the largest distance
    /// from their surfaces.
    [[nodiscard]] virtual double distance_at_facets(std::span<const FacetSite<D>> meet, const Vec<D>& p) const;
    /// Unit normals of the surface at a facet's vertices, if any. Default: by `project`.
    [[nodiscard]] virtual std::optional<std::array<Vec<D>, D>> normals_at(const FacetSite<D>& facet) const;

    /// Default: the name is "surface" or "curve".
    [[nodiscard]] virtual EntityName name_of_entity(const GeometryEntity& entity) const;
    /// Samples the whole geometry; the number of points on surfaces is approximate. Default: no samples, because
    /// surfaces may be unbounded or may end with the mesh (see `sample_over_mesh`). Errors: stopped.
    [[nodiscard]] virtual Outcome<GeometrySamples<D>> sample_all(std::size_t target_count,
                                                                 const Execution& execution) const;

    /// True if the reference's surface comes from outside of the mesh (analytic, CAD) and so overrides curves of the
    /// mesh. Default: false.
    [[nodiscard]] virtual bool prescribes(Reference reference) const;
    [[nodiscard]] virtual bool prescribes_any() const;

  protected:
    GeometryModel() = default;
    GeometryModel(const GeometryModel&) = default;
    GeometryModel(GeometryModel&&) = default;
    GeometryModel& operator=(const GeometryModel&) = default;
    GeometryModel& operator=(GeometryModel&&) = default;
};

/// A value that `model_of` (found by argument-dependent lookup) converts to a model.
template <class Maker, int D>
concept ConvertibleToGeometry = requires(Maker maker) {
    { model_of(std::move(maker)) } -> std::convertible_to<std::shared_ptr<const GeometryModel<D>>>;
};

/// The boundary of the domain: an immutable value of any implementation, cheap to copy and thread-safe. Use `->` for
/// queries.
template <int D>
class Geometry {
  public:
    template <std::derived_from<GeometryModel<D>> Model>
    Geometry(Model model) : model_(std::make_shared<const Model>(std::move(model))) {}
    template <class Maker>
        requires(!std::derived_from<Maker, GeometryModel<D>> && ConvertibleToGeometry<Maker, D>)
    Geometry(Maker maker) : model_(model_of(std::move(maker))) {}

    [[nodiscard]] const GeometryModel<D>* operator->() const { return model_.get(); }
    [[nodiscard]] const GeometryModel<D>& operator*() const { return *model_; }

  private:
    std::shared_ptr<const GeometryModel<D>> model_;
};

template <int D>
[[nodiscard]] SurfacePoint<D> project(const Geometry<D>& geometry, const SurfaceHint& hint, const Vec<D>& p) {
    return geometry->project(hint, p);
}

}  // namespace camber

namespace camber {

/// A surface of a model at an edge, or the plane of a facet without a surface.
template <int D>
struct Sheet {
    const GeometryModel<D>* of = nullptr;
    SurfaceHint hint;
    GeometryEntity entity;
    std::optional<Plane<D>> plane;

    [[nodiscard]] SurfaceFoot<D> foot(const Vec<D>& p) const {
        if (plane) return camber::foot(*plane, p);
        const SurfacePoint<D> found = of->project(hint, p);
        return {found.point, found.normal};
    }
    [[nodiscard]] Vec<D> snapped_to_plane(const Vec<D>& p) const { return plane ? snapped(*plane, p) : p; }
    [[nodiscard]] bool is_same(const Sheet& other) const {
        if (plane && other.plane) return *plane == *other.plane;
        return of == other.of && entity == other.entity && plane.has_value() == other.plane.has_value();
    }
};

/// The distinct sheets of the facets at an edge; at least one sheet is a surface.
template <int D>
struct Sheets {
    std::vector<Sheet<D>> distinct;
    bool all = true;  ///< each facet has a surface or plane

    void add(Sheet<D> sheet) {
        const auto same = [&](const Sheet<D>& other) { return sheet.is_same(other); };
        if (std::any_of(distinct.begin(), distinct.end(), same)) return;
        // Curved surfaces precede planes, because `foot_on_intersection` uses only the first two sheets.
        distinct.insert(sheet.plane ? distinct.end() : distinct.begin(), std::move(sheet));
    }
};

/// Returns the sheets at an edge. The sheet of a facet is its surface of `first` if owns(facet) is true, else its
/// surface of `rest` if that is prescribed, else its plane.
template <int D, class Owns>
[[nodiscard]] Sheets<D> sheets_around(const GeometryModel<D>& first, Owns&& owns, const GeometryModel<D>& rest,
                                      const EdgeSite<D>& edge) {
    Sheets<D> around;
    for (const FacetSite<D>& facet : edge.facets) {
        if (owns(facet) || rest.prescribes(facet.reference)) {
            const GeometryModel<D>& of = owns(facet) ? first : rest;
            const GeometryEntity surface = of.surface_at(facet);
            const SurfaceHint hint{.facet = {}, .reference = facet.reference, .entity = surface};
            around.add({&of, hint, surface, of.plane_at(facet)});
        } else if (auto plane = rest.plane_at(facet)) {
            around.add({&rest, {}, {}, std::move(plane)});
        } else {
            around.all = false;
        }
    }
    return around;
}

/// Returns the closest point to p of the only surface at an edge, with normal. For several surfaces, returns the
/// closest point on the curve where the first two meet, without normal. At least one sheet is a surface. For tangent
/// surfaces, touching() returns the point on the curve, if known; otherwise the closest point of the first surface is
/// used.
template <class Touching>
[[nodiscard]] SurfaceFoot<3> foot_on_intersection(const std::vector<Sheet<3>>& sheets, const Vec<3>& p,
                                                  Touching&& touching) {
    const Sheet<3>& a = sheets[0];
    if (sheets.size() == 1) return a.foot(p);
    const Sheet<3>& b = sheets[1];
    if (a.plane && b.plane) return {p, {}};
    const auto met = closest_on_intersection([&](const Vec<3>& x) { return a.foot(x); },
                                             [&](const Vec<3>& x) { return b.foot(x); }, p);
    if (met) return {b.snapped_to_plane(a.snapped_to_plane(*met)), {}};
    const std::optional<Vec<3>> known = touching();
    return {known ? *known : a.foot(p).point, {}};
}

/// In 2D an edge is a facet and lies on its surface.
template <class Touching>
[[nodiscard]] SurfaceFoot<2> foot_on_intersection(const std::vector<Sheet<2>>& sheets, const Vec<2>& p, Touching&&) {
    return sheets[0].foot(p);
}

/// Returns the closest point to p at an edge between two geometries. If a facet has neither surface nor plane, the
/// function projects rest_at() instead of p. touching(): see `foot_on_intersection`.
template <int D, class RestAt, class Touching>
[[nodiscard]] SurfaceFoot<D> foot_on_edge(const Sheets<D>& around, const Vec<D>& p, RestAt&& rest_at,
                                          Touching&& touching) {
    return foot_on_intersection(around.distinct, around.all ? p : rest_at(), touching);
}

template <int D>
[[nodiscard]] SurfacePoint<D> point_on_edge(const GeometryModel<D>& model, const EdgeSite<D>& edge,
                                            const SurfaceFoot<D>& foot, const Vec<D>& p) {
    SurfacePoint<D> out{.point = foot.point,
                        .normal = foot.normal,
                        .distance = camber::distance(foot.point, p),
                        .entity = model.entity_at_edge(edge)};
    if (out.entity.kind != GeometryKind::surface) return out;
    const auto in_surface = model.project({.facet = {}, .reference = {}, .entity = out.entity}, foot.point);
    out.reference = edge.facets.front().reference;
    out.parameters = in_surface.parameters;
    return out;
}

}  // namespace camber

/// Surfaces and curves on which boundary nodes move. The unknowns are displacements in the tangent plane. A displaced
/// node is projected, also onto other facets of a surrogate.
export namespace camber {

/// Common plane of all facets at an edge, if any, with unit normal.
template <int D>
[[nodiscard]] std::optional<Plane<D>> common_plane(const GeometryModel<D>& geometry, const EdgeSite<D>& edge);

/// Moves p by the in-plane part of `shift`. The plane's normal is a unit vector; along an axis-aligned normal, p is
/// exactly unchanged.
template <int D>
[[nodiscard]] Vec<D> slid_within(const Plane<D>& plane, const Vec<D>& p, const Vec<D>& shift);

/// Point of a sheet, with orthonormal tangents (the first along the edge; a curve has one), unit normal (zero on a
/// curve), and the surrogate's facet.
template <int D>
struct SheetPosition {
    Vec<D> point;
    std::array<Vec<D>, static_cast<std::size_t>(D - 1)> tangents{};
    Vec<D> normal;
    FacetId facet = {};
};

/// The surface, plane or curve on which an edge's node moves. Kind `straight`: there is no surface, or the edge is on a
/// line, where moving a node does not change the curve. The geometry and the edge must outlive this object. A position
/// is rejected if it is beyond the rim, on another entity, or on a part of the surface with a very different normal.
template <int D>
class EdgeSheet {
  public:
    enum class Kind : std::uint8_t { straight, plane, surface, curve };

    EdgeSheet(const GeometryModel<D>& geometry, const EdgeSite<D>& edge);

    [[nodiscard]] Kind kind() const { return kind_; }
    [[nodiscard]] int unknowns() const { return kind_ == Kind::curve ? 1 : D - 1; }

    /// Returns the position of the edge's node. Empty if the node is farther than 1e-4 of the chord from the sheet, or
    /// if the sheet is transverse to the edge.
    [[nodiscard]] std::optional<SheetPosition<D>> place_of(const Vec<D>& node) const;
    /// Returns the closest position to from.point + step, with minimal rotation of the tangents. Empty if the step is
    /// too long: the closest point is on another entity, farther than half of the step, or beyond the rim, or the
    /// normal turns by more than 60°.
    [[nodiscard]] std::optional<SheetPosition<D>> moved(const SheetPosition<D>& from, const Vec<D>& step) const;
    [[nodiscard]] SurfaceFoot<D> foot(const SheetPosition<D>& near, const Vec<D>& p) const;
    [[nodiscard]] bool has_left_facets(const SheetPosition<D>& from, const SheetPosition<D>& to) const;

  private:
    struct Found;
    [[nodiscard]] Found nearest(const FacetId& facet, const Vec<D>& p) const;
    [[nodiscard]] Vec<D> direction_at(const Found& found) const;
    [[nodiscard]] std::optional<SheetPosition<D>> framed(
        const Found& found, const std::array<Vec<D>, static_cast<std::size_t>(D - 1)>& near) const;

    const GeometryModel<D>* geometry_;
    const EdgeSite<D>* edge_;
    Kind kind_ = Kind::straight;
    GeometryEntity entity_;
    std::optional<Plane<D>> plane_;
};

/// A sphere (2D: circle). Directions of surfaces need not be unit vectors; radii are positive.
template <int D>
struct Sphere {
    Vec<D> centre;
    double radius = 1;
    friend bool operator==(const Sphere&, const Sphere&) = default;
};
struct Cylinder {
    Vec<3> point, axis;
    double radius = 1;
    friend bool operator==(const Cylinder&, const Cylinder&) = default;
};
/// `major_radius`: radius of the circle about the axis; `minor_radius`: radius of the tube.
struct Torus {
    Vec<3> centre, axis;
    double major_radius = 1, minor_radius = 0.25;
    friend bool operator==(const Torus&, const Torus&) = default;
};

template <int D>
using AnalyticSurface =
    std::conditional_t<D == 2, std::variant<Plane<2>, Sphere<2>>, std::variant<Plane<D>, Sphere<D>, Cylinder, Torus>>;

/// Surfaces by facet reference; the first surface of a reference counts.
template <int D>
struct AnalyticGeometry {
    std::vector<std::pair<Reference, AnalyticSurface<D>>> surfaces;
    friend bool operator==(const AnalyticGeometry&, const AnalyticGeometry&) = default;
};

template <int D>
[[nodiscard]] const AnalyticSurface<D>* surface_of(const AnalyticGeometry<D>& geometry, Reference reference);

template <int D>
[[nodiscard]] SurfaceFoot<D> closest_point(const AnalyticSurface<D>& surface, const Vec<D>& p);

/// Checks that the surfaces fit the mesh. Errors (usage): a reference with two surfaces or without facets; a radius
/// that is NaN, negative, or above 1e8 times the boundary's size. Errors (input): too many vertices of a surface are
/// off (`VertexFit`), or one vertex is off by more than half of its longest edge. The error names the farthest vertex.
/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Done> check_fit(const LinearMesh<D>& mesh, const AnalyticGeometry<D>& geometry,
                                      const Execution& execution);

}  // namespace camber
