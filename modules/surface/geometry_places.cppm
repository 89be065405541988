module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>
export module camber.surface:geometry_places;
import camber.core;

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

}  // namespace camber
