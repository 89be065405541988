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

/// A plane (2D: a line). The normal need not be a unit vector.
template <int D>
struct Plane {
    Vec<D> point, normal;
    friend bool operator==(const Plane&, const Plane&) = default;
};

/// The closest point of a surface and the unit normal there (outwards where the surface is closed). On a plane whose
/// normal is along an axis that coordinate of the point is the plane's to the last bit. Where the closest point is not
/// unique (a centre, an axis) one is chosen.
template <int D>
struct SurfaceFoot {
    Vec<D> point, normal;
};

}  // namespace camber

namespace camber {

/// v / |v|, or `otherwise` for the zero vector.
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

/// The axis that a unit normal lies along exactly, or −1.
template <int D>
[[nodiscard]] int axis_of(const Vec<D>& normal) {
    for (int i = 0; i < D; ++i)
        if (std::fabs(normal[i]) == 1) return i;
    return -1;
}

/// The closest point of a plane.
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

/// x with the coordinate that a plane along an axis holds exactly; x itself for other planes.
template <int D>
[[nodiscard]] Vec<D> snapped(const Plane<D>& plane, Vec<D> x) {
    if (const int k = axis_of(normalised(plane.normal)); k >= 0) x[k] = plane.point[k];
    return x;
}

/// The plane through a facet's vertices.
[[nodiscard]] inline Plane<2> plane_through(const std::array<Vec<2>, 2>& p) {
    return {p[0], {{p[1][1] - p[0][1], p[0][0] - p[1][0]}}};
}
[[nodiscard]] inline Plane<3> plane_through(const std::array<Vec<3>, 3>& p) {
    return {p[0], cross(p[1] - p[0], p[2] - p[0])};
}

/// The point of both tangent planes that is nearest to p: p + α n_a + β n_b. Nothing where the planes are nearly
/// parallel.
[[nodiscard]] inline std::optional<Vec<3>> nearest_on_both(const SurfaceFoot<3>& a, const SurfaceFoot<3>& b,
                                                           const Vec<3>& p) {
    constexpr double min_sine_squared = 0.003;
    const double c = dot(a.normal, b.normal);
    const double determinant = 1 - c * c;
    if (determinant < min_sine_squared) return std::nullopt;
    const double to_a = dot(a.point - p, a.normal), to_b = dot(b.point - p, b.normal);
    const double alpha = (to_a - c * to_b) / determinant, beta = (to_b - c * to_a) / determinant;
    return p + alpha * a.normal + beta * b.normal;
}

/// The point nearest to p on the curve where two surfaces meet, each known by its closest points alone: `foot_a(x)` and
/// `foot_b(x)` give a SurfaceFoot. p is projected onto the meet of the tangent planes, again and again, and the last
/// steps restore the surfaces alone. Nothing where they are nearly tangent (below about 3°) or do not meet near p.
template <class FootA, class FootB>
[[nodiscard]] std::optional<Vec<3>> nearest_where_they_meet(FootA&& foot_a, FootB&& foot_b, const Vec<3>& p) {
    constexpr int max_steps = 60;
    constexpr int restoring_steps = 3;
    Vec<3> x = p;
    double first_step = 0;
    for (int step = 0; step < max_steps; ++step) {
        const auto next = nearest_on_both(foot_a(x), foot_b(x), p);
        if (!next || !is_finite(*next)) return std::nullopt;
        const double moved_by = distance(*next, x);
        if (step == 0) first_step = moved_by;
        x = *next;
        if (moved_by <= 1e-15 * (first_step + norm(x))) break;
    }
    for (int step = 0; step < restoring_steps; ++step) {
        const auto next = nearest_on_both(foot_a(x), foot_b(x), x);
        if (!next) return std::nullopt;
        x = *next;
    }
    const double off = distance(foot_a(x).point, x) + distance(foot_b(x).point, x);
    if (!(off <= 1e-9 * (first_step + norm(x)))) return std::nullopt;
    return x;
}

}  // namespace camber

export namespace camber {

/// In 2D the boundary's curves take the part of surfaces, and two of them meet in corners.
enum class GeometryKind : std::uint8_t { none, corner, curve, surface };

/// A piece of a geometry. Numbers are the maker's own: a Surrogate's surfaces and curves are its patches and ridge
/// curves, an AnalyticGeometry's surfaces the rows of its table (the first of equal ones), a MixedGeometry doubles
/// them (GeometryModel::called tells the maker's own).
struct GeometryEntity {
    static constexpr std::int64_t unnumbered = -1;

    GeometryKind kind = GeometryKind::none;
    std::int64_t id = unnumbered;
    /// The two surfaces that meet at a curve, the lower first; `unnumbered` where that is no surface or not known.
    std::array<std::int64_t, 2> sides{unnumbered, unnumbered};

    [[nodiscard]] static constexpr GeometryEntity surface(std::int64_t number) {
        return {GeometryKind::surface, number, {unnumbered, unnumbered}};
    }
    /// Whether it is this surface, or a curve that lies on it.
    [[nodiscard]] constexpr bool lies_on(const GeometryEntity& surface) const {
        if (surface.kind != GeometryKind::surface || surface.id == unnumbered) return false;
        return kind == GeometryKind::curve ? sides[0] == surface.id || sides[1] == surface.id : *this == surface;
    }
    friend constexpr bool operator==(const GeometryEntity&, const GeometryEntity&) = default;
};

/// A place in an entity's own coordinates: two on a surface, the first alone on a curve (2D: on a surface too).
/// `piece`: which piece of an entity that is made of pieces, as a surrogate's are of facets and edges.
struct GeometryParameters {
    std::array<double, 2> u{};
    std::uint32_t piece = 0;
    friend bool operator==(const GeometryParameters&, const GeometryParameters&) = default;
};

/// Where to look for the closest point. A surrogate starts at its facet `facet` and walks (local, fast), or without one
/// searches all its facets, those of `entity` or else of `reference` alone if that is given. Analytic surfaces take
/// that of `entity`, else that of `reference`. A mixed geometry asks whom the entity or the reference belongs to;
/// without either that of the surrogate's facet counts, the given one or the nearest. An entity that is no surface
/// tells nothing here: points go onto curves by GeometryModel::on_edge.
struct SurfaceHint {
    FacetId facet = {};
    std::optional<Reference> reference = {};
    GeometryEntity entity = {};
};

/// A point of the geometry, the unit normal there (zero on a curve), and how far it is from the point that was
/// projected. `facet` is the surrogate's, invalid on other surfaces. Where there is no surface the point stays, with a
/// zero normal and no entity.
template <int D>
struct SurfacePoint {
    Vec<D> point, normal;
    double distance = 0;
    FacetId facet = {};
    GeometryEntity entity = {};
    std::optional<Reference> reference = {};            ///< of the surface, where it has one
    std::optional<GeometryParameters> parameters = {};  ///< where the maker has them: evaluate gives the point back
};

/// What a point lies on and, where that is known, where in it.
struct GeometryPlace {
    GeometryEntity entity;
    std::optional<GeometryParameters> parameters = {};
    friend bool operator==(const GeometryPlace&, const GeometryPlace&) = default;
};
template <int D>
[[nodiscard]] GeometryPlace place_of(const SurfacePoint<D>& point) {
    return {point.entity, point.parameters};
}

/// A point of an entity by its parameters: derivatives by u in `tangents` (a curve has the first alone), the unit
/// normal of a surface, zero on a curve.
template <int D>
struct EntityPoint {
    Vec<D> point;
    std::array<Vec<D>, 2> tangents{};
    Vec<D> normal;
};

/// What a maker calls an entity, and by which number, from 1; 0: it has none.
struct EntityName {
    std::string_view kind = "none";
    std::size_t number = 0;
    friend constexpr bool operator==(const EntityName&, const EntityName&) = default;
};

/// Points of a geometry by its entities: those of one are in a row. Weights are areas (of curves lengths) that the
/// points stand for; `near`: a facet of the mesh that is not far, or none.
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

    /// A point of the entity that was begun last.
    void add(const Vec<D>& point, double weight, FacetId facet = {}) {
        points.push_back(point);
        weights.push_back(weight);
        near.push_back(facet);
        entities.back().end = points.size();
    }
    void begin(const GeometryEntity& entity) { entities.push_back({entity, points.size(), points.size()}); }
};

/// A facet of a mesh, as a geometry is asked for it. `id` may be invalid: of no mesh yet.
template <int D>
struct FacetSite {
    FacetId id;
    Reference reference = 0;
    std::array<Vec<D>, D> corners{};
};

/// A facet with its number, reference and vertices.
template <int D>
[[nodiscard]] FacetSite<D> facet_site(const LinearMesh<D>& mesh, FacetId f) {
    FacetSite<D> site{f, mesh.facets.references[f], {}};
    for (std::size_t i = 0; i < D; ++i) site.corners[i] = mesh.points[mesh.facets.vertices[f][i]];
    return site;
}

/// The facets with their numbers, references and vertices.
template <int D>
[[nodiscard]] std::vector<FacetSite<D>> facet_sites(const LinearMesh<D>& mesh, std::span<const FacetId> facets) {
    std::vector<FacetSite<D>> sites;
    sites.reserve(facets.size());
    for (const FacetId f : facets) sites.push_back(facet_site(mesh, f));
    return sites;
}

/// An edge on the boundary of a mesh, with the facets around it, which tell what stands there. `id` may be invalid: of
/// no mesh yet.
template <int D>
struct EdgeSite {
    EdgeId id;
    EdgeKind kind = EdgeKind::surface;
    std::array<Vec<D>, 2> ends{};  ///< the vertex of the lower number first
    std::vector<FacetSite<D>> facets;

    [[nodiscard]] Vec<D> middle() const { return midpoint(ends[0], ends[1]); }
};

/// The largest distance of some points, and the number of them that were projected to find it: the others are known to
/// be nearer.
struct LargestDistance {
    double largest = 0;
    std::size_t projected = 0;
    FacetId facet = {};  ///< with that distance, where several facets are searched; invalid: none
};

/// The face that every maker of a geometry has: what the boundary of the domain is, as boundary_nodes,
/// boundary_distance and the operators ask for it. A maker answers the first two questions, project and surface_at; the
/// others have answers that follow from these, and a maker that knows better overrides them (a surrogate knows the
/// curve of each of its edges, a CAD model its own ridges). Models are immutable, and asked by many threads at once;
/// the answers depend on the question alone.
template <int D>
class GeometryModel {
  public:
    virtual ~GeometryModel() = default;

    /// The nearest point to p of the surface that the hint tells of. Where there is none p itself, with a zero normal.
    /// Idempotent up to rounding.
    [[nodiscard]] virtual SurfacePoint<D> project(const SurfaceHint& hint, const Vec<D>& p) const = 0;
    /// The surface that a facet of a mesh lies on; no entity where the geometry has none there. Equal surfaces are one
    /// entity.
    [[nodiscard]] virtual GeometryEntity surface_at(const FacetSite<D>& facet) const = 0;
    /// Whether surface_at is one: cheaper where that is searched for.
    [[nodiscard]] virtual bool has_surface_at(const FacetSite<D>& facet) const {
        return surface_at(facet).kind != GeometryKind::none;
    }

    /// The point of an entity with these parameters, as project gives them. Here: nothing, a maker without parameters.
    [[nodiscard]] virtual std::optional<EntityPoint<D>> evaluate(const GeometryEntity& entity,
                                                                 const GeometryParameters& parameters) const;
    /// What an edge of a mesh lies on. Here: the surface of its facets, or the curve where two are.
    [[nodiscard]] virtual GeometryEntity entity_at_edge(const EdgeSite<D>& edge) const;
    /// What a vertex with these facets around it lies on. Here: their surface, the curve where two are, the corner
    /// where more are.
    [[nodiscard]] virtual GeometryEntity entity_at_vertex(std::span<const FacetSite<D>> around) const;

    /// The plane (2D: the line) that the surface of a facet is, where it is one: beside it a ridge is plane, and
    /// between two of them straight. Here: the facet's own plane where there is no surface, else nothing.
    [[nodiscard]] virtual std::optional<Plane<D>> plane_at(const FacetSite<D>& facet) const;
    /// What stands at an edge of a mesh: the point near p of the surface of its facets or, where two surfaces meet
    /// there, of their curve. A facet without a surface counts as a part of its own plane beside one that has one;
    /// between planes p stays as it is. Here: by project alone, the curve by the tangent planes of both surfaces.
    [[nodiscard]] virtual SurfacePoint<D> on_edge(const EdgeSite<D>& edge, const Vec<D>& p) const;
    /// Where the middle of an edge belongs. Here: on_edge of the chord's middle.
    [[nodiscard]] virtual Vec<D> middle_of(const EdgeSite<D>& edge) const;

    /// How far points near a facet are from its surface: points[i] is that of the curved facet at at[i]. False, and
    /// nothing written, where the facet has no surface. Here: by project. A whole facet at a time, since what is known
    /// of it is then asked once.
    [[nodiscard]] virtual bool distances(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>> at,
                                         std::span<const Vec<D>> points, std::span<double> out) const;
    /// The largest of `distances` where that is above `bound`, up to rounding, else `bound`; nothing where the facet
    /// has no surface. Here: by `distances`. A model that proves cheaply that points are within the bound overrides it.
    [[nodiscard]] virtual std::optional<LargestDistance> largest_distance(const FacetSite<D>& facet,
                                                                          std::span<const Barycentric<D - 1>> at,
                                                                          std::span<const Vec<D>> points,
                                                                          double bound) const;
    /// Whether each points[i] is at most bounds[i] away from a facet's surface; true if the facet has none. Here: by
    /// `distances`. A model that has cheap upper bounds of distances overrides it.
    [[nodiscard]] virtual bool are_within(const FacetSite<D>& facet, std::span<const Vec<D>> points,
                                          std::span<const double> bounds) const;
    /// Whether facets of a reference that are not of the mesh (without a number) all have the same surface: then one
    /// call of `are_within` can take the points of several facets. Here: no.
    [[nodiscard]] virtual bool is_one_surface(Reference reference) const;
    /// The points of the geometry that stand over places of a facet: of a surface made of pieces those of the facet's
    /// own piece, else those next to the straight facet's. False, and nothing written, where the facet has no surface.
    /// Here: by project.
    [[nodiscard]] virtual bool points_over(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>> at,
                                           std::span<Vec<D>> out) const;
    /// True if the surface at a facet is a curved piece that was made from this facet: then points_over gives the
    /// points of that piece, and middle_of the middles of its edges. Here: no.
    [[nodiscard]] virtual bool is_made_from(const FacetSite<D>& facet) const;
    /// Where to look for points of a facet's surface. The search begins at the facet itself only where the surface was
    /// made from it: a geometry of another mesh has other facets of these numbers.
    [[nodiscard]] SurfaceHint hint_at(const FacetSite<D>& facet, const GeometryEntity& entity = {}) const {
        return {is_made_from(facet) ? facet.id : FacetId{}, facet.reference, entity};
    }
    /// How far a point where these facets (at least one) meet is from the geometry. Here: the largest distance from
    /// their surfaces.
    [[nodiscard]] virtual double distance_where(std::span<const FacetSite<D>> meet, const Vec<D>& p) const;
    /// The unit normals of a facet's surface at the facet's vertices; nothing where it has none. Here: by project.
    [[nodiscard]] virtual std::optional<std::array<Vec<D>, D>> normals_at(const FacetSite<D>& facet) const;

    /// What its maker calls an entity. Here: a surface or a curve, by its number.
    [[nodiscard]] virtual EntityName called(const GeometryEntity& entity) const;
    /// Points of what the geometry has whether a mesh has something there or not, about `wanted` of them on surfaces.
    /// Here: none, a maker whose surfaces have no end, or end where the mesh does (see samples_over). Errors: stopped.
    [[nodiscard]] virtual Outcome<GeometrySamples<D>> own_samples(std::size_t wanted, const Execution& execution) const;

    /// Whether the surface of this reference is prescribed from outside of the mesh (an analytic surface, a CAD model),
    /// so that curves which the mesh brings give way to it. Not so what is made from the mesh itself. Here: no.
    [[nodiscard]] virtual bool prescribes(Reference reference) const;
    /// Whether the geometry is one that prescribes surfaces. Here: no.
    [[nodiscard]] virtual bool prescribes_any() const;

  protected:
    GeometryModel() = default;
    GeometryModel(const GeometryModel&) = default;
    GeometryModel(GeometryModel&&) = default;
    GeometryModel& operator=(const GeometryModel&) = default;
    GeometryModel& operator=(GeometryModel&&) = default;
};

/// A value of which a function model_of, found beside its type, makes a model: a Surrogate, an AnalyticGeometry.
template <class Maker, int D>
concept MakesGeometry = requires(Maker maker) {
    { model_of(std::move(maker)) } -> std::convertible_to<std::shared_ptr<const GeometryModel<D>>>;
};

/// What the boundary of the domain is: an immutable value of any maker, cheap to copy, that any number of threads may
/// ask. Questions go through `->`.
template <int D>
class Geometry {
  public:
    /// Of a maker's model, which is kept as it is.
    template <std::derived_from<GeometryModel<D>> Model>
    Geometry(Model model) : model_(std::make_shared<const Model>(std::move(model))) {}
    /// Of a maker's value.
    template <class Maker>
        requires(!std::derived_from<Maker, GeometryModel<D>> && MakesGeometry<Maker, D>)
    Geometry(Maker maker) : model_(model_of(std::move(maker))) {}

    [[nodiscard]] const GeometryModel<D>* operator->() const { return model_.get(); }
    [[nodiscard]] const GeometryModel<D>& operator*() const { return *model_; }

  private:
    std::shared_ptr<const GeometryModel<D>> model_;
};

/// The geometry's point nearest to p.
template <int D>
[[nodiscard]] SurfacePoint<D> project(const Geometry<D>& geometry, const SurfaceHint& hint, const Vec<D>& p) {
    return geometry->project(hint, p);
}

}  // namespace camber

namespace camber {

/// One of the surfaces around an edge: a model's, or the plane of a facet that has none.
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
    [[nodiscard]] Vec<D> held(const Vec<D>& p) const { return plane ? snapped(*plane, p) : p; }
    [[nodiscard]] bool is_same(const Sheet& other) const {
        if (plane && other.plane) return *plane == *other.plane;
        return of == other.of && entity == other.entity && plane.has_value() == other.plane.has_value();
    }
};

/// What is known of the surfaces around an edge, on one side of which at least there is one.
template <int D>
struct Sheets {
    std::vector<Sheet<D>> distinct;  ///< of facets with a surface, and planes of those without
    bool all = true;                 ///< whether each facet has one or a plane

    void add(Sheet<D> sheet) {
        const auto same = [&](const Sheet<D>& other) { return sheet.is_same(other); };
        if (std::any_of(distinct.begin(), distinct.end(), same)) return;
        // Curved ones first: among three or more the first two decide.
        distinct.insert(sheet.plane ? distinct.end() : distinct.begin(), std::move(sheet));
    }
};

/// The surfaces of `first` on the facets that it `owns`; else what `rest` prescribes, or the planes that it has there.
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

/// The point near p of the one surface around an edge, or of the curve where the first two meet; a normal only of the
/// one surface. There is a surface among them. `touching()`: where two that touch rather than cross have their curve,
/// if that is known; else it is wherever the edge is, on the first of them.
template <class Touching>
[[nodiscard]] SurfaceFoot<3> foot_where_they_meet(const std::vector<Sheet<3>>& sheets, const Vec<3>& p,
                                                  Touching&& touching) {
    const Sheet<3>& a = sheets[0];
    if (sheets.size() == 1) return a.foot(p);
    const Sheet<3>& b = sheets[1];
    if (a.plane && b.plane) return {p, {}};
    const auto met = nearest_where_they_meet([&](const Vec<3>& x) { return a.foot(x); },
                                             [&](const Vec<3>& x) { return b.foot(x); }, p);
    if (met) return {b.held(a.held(*met)), {}};
    const std::optional<Vec<3>> known = touching();
    return {known ? *known : a.foot(p).point, {}};
}

/// The same in 2D, where an edge is a facet and lies on its surface.
template <class Touching>
[[nodiscard]] SurfaceFoot<2> foot_where_they_meet(const std::vector<Sheet<2>>& sheets, const Vec<2>& p, Touching&&) {
    return sheets[0].foot(p);
}

/// The point near p of an edge by the sheets around it, some of which are those of the first of two geometries.
/// `rest_at()`: what the other one takes for that point, which beside a curved surface knows the ridge along the edge,
/// and the first where it is across. `touching()`: as above.
template <int D, class RestAt, class Touching>
[[nodiscard]] SurfaceFoot<D> foot_on_edge(const Sheets<D>& around, const Vec<D>& p, RestAt&& rest_at,
                                          Touching&& touching) {
    return foot_where_they_meet(around.distinct, around.all ? p : rest_at(), touching);
}

/// What stands at an edge, by its foot there: on a surface with the place in that.
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

/// What the node of a boundary edge may move on, by what every geometry answers: unknowns are displacements in the
/// tangent plane of a place, followed by projection, which walks across a surrogate's facets.
export namespace camber {

/// The plane on which all facets at an edge lie, where they lie on one. Its normal is a unit vector.
template <int D>
[[nodiscard]] std::optional<Plane<D>> common_plane(const GeometryModel<D>& geometry, const EdgeSite<D>& edge);

/// p moved by the part of `shift` that lies in the plane, whose normal is a unit vector. A coordinate in which the
/// plane is constant stays as it is.
template <int D>
[[nodiscard]] Vec<D> slid_within(const Plane<D>& plane, const Vec<D>& p, const Vec<D>& shift);

/// A place on a sheet: orthonormal tangents, the first along the edge (a curve has that alone), and the unit normal,
/// zero on a curve. `facet` is a surrogate's.
template <int D>
struct SheetPlace {
    Vec<D> point;
    std::array<Vec<D>, static_cast<std::size_t>(D - 1)> tangents{};
    Vec<D> normal;
    FacetId facet = {};
};

/// The one surface, plane or curve of a geometry that an edge lies on. `straight`: there is none, or a line, on which a
/// node that moves makes the same curve. It refers to the geometry and to the edge, which must outlive it. A node
/// stays on it: places beyond its rim, on another entity or on another leaf of it are no answer.
template <int D>
class EdgeSheet {
  public:
    enum class Kind : std::uint8_t { straight, plane, surface, curve };

    EdgeSheet(const GeometryModel<D>& geometry, const EdgeSite<D>& edge);

    [[nodiscard]] Kind kind() const { return kind_; }
    [[nodiscard]] int unknowns() const { return kind_ == Kind::curve ? 1 : D - 1; }

    /// Where the edge's node is; nothing where that is not on the sheet (to 1e-4 of the chord), or the sheet stands
    /// across the edge.
    [[nodiscard]] std::optional<SheetPlace<D>> place_of(const Vec<D>& node) const;
    /// The place near from.point + step, whose tangents are those of `from`, turned as little as may be. Nothing where
    /// the step is too long for the sheet: the foot is on another entity, farther away than half of the step or beyond
    /// the rim, the normal turns by more than 60°.
    [[nodiscard]] std::optional<SheetPlace<D>> moved(const SheetPlace<D>& from, const Vec<D>& step) const;
    /// The sheet's point nearest to p, searched from a place near it.
    [[nodiscard]] SurfaceFoot<D> foot(const SheetPlace<D>& near, const Vec<D>& p) const;
    /// Whether a node that began at `from` has left the facets of the surrogate that were at its edge.
    [[nodiscard]] bool has_walked(const SheetPlace<D>& from, const SheetPlace<D>& to) const;

  private:
    struct Found;
    [[nodiscard]] Found nearest(const FacetId& facet, const Vec<D>& p) const;
    [[nodiscard]] Vec<D> direction_at(const Found& found) const;
    [[nodiscard]] std::optional<SheetPlace<D>> framed(
        const Found& found, const std::array<Vec<D>, static_cast<std::size_t>(D - 1)>& near) const;

    const GeometryModel<D>* geometry_;
    const EdgeSite<D>* edge_;
    Kind kind_ = Kind::straight;
    GeometryEntity entity_;
    std::optional<Plane<D>> plane_;
};

/// A circle in 2D. Here and below directions need not be unit vectors, and radii are positive.
template <int D>
struct Sphere {
    Vec<D> centre;
    double radius = 1;
    friend bool operator==(const Sphere&, const Sphere&) = default;
};
/// An infinite circular cylinder.
struct Cylinder {
    Vec<3> point, axis;
    double radius = 1;
    friend bool operator==(const Cylinder&, const Cylinder&) = default;
};
/// The tube of the minor radius around the circle of the major radius about the axis.
struct Torus {
    Vec<3> centre, axis;
    double major_radius = 1, minor_radius = 0.25;
    friend bool operator==(const Torus&, const Torus&) = default;
};

/// Any of the surfaces above that the dimension has.
template <int D>
using AnalyticSurface =
    std::conditional_t<D == 2, std::variant<Plane<2>, Sphere<2>>, std::variant<Plane<D>, Sphere<D>, Cylinder, Torus>>;

/// The surface of each facet reference; the first pair of a reference counts.
template <int D>
struct AnalyticGeometry {
    std::vector<std::pair<Reference, AnalyticSurface<D>>> surfaces;
    friend bool operator==(const AnalyticGeometry&, const AnalyticGeometry&) = default;
};

/// The surface of a reference; null where it has none.
template <int D>
[[nodiscard]] const AnalyticSurface<D>* surface_of(const AnalyticGeometry<D>& geometry, Reference reference);

/// The point of the surface that is nearest to p.
template <int D>
[[nodiscard]] SurfaceFoot<D> closest_point(const AnalyticSurface<D>& surface, const Vec<D>& p);

/// Checks that the surfaces are those of the mesh. Errors (usage): a reference with two surfaces, or of no facet; a
/// radius that is no number, negative, or beyond 1e8 times the size of the boundary. Errors (input): too many vertices
/// of a surface are off (VertexFit), or one by more than half of its longest edge; the farthest is named. Stopped.
template <int D>
[[nodiscard]] Outcome<Done> check_fit(const LinearMesh<D>& mesh, const AnalyticGeometry<D>& geometry,
                                      const Execution& execution);

}  // namespace camber
