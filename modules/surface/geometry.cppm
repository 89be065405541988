module;
#include <array>
#include <concepts>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>
export module camber.surface:geometry;
import camber.core;
import camber.bezier;
import :geometry_places;
import :plane;

export namespace camber {

/// The largest distance of some points, and the number of them that were projected to find it: the others are known to
/// be nearer.
struct LargestDistance {
    double largest = 0;
    std::size_t projected = 0;
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
    /// After how much each coordinate of an entity is at the same point again; 0: never. Here: never.
    [[nodiscard]] virtual std::array<double, 2> periods(const GeometryEntity& entity) const;
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
    /// The points of the geometry that stand over places of a facet: of a surface made of pieces those of the facet's
    /// own piece, else those next to the straight facet's. False, and nothing written, where the facet has no surface.
    /// Here: by project.
    [[nodiscard]] virtual bool points_over(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>> at,
                                           std::span<Vec<D>> out) const;
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
