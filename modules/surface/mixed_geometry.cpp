// Geometry model of a surrogate beside prescribed surfaces.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// The last bit of an entity number selects the part.
enum class Part : std::uint8_t { first, rest };

std::int64_t number_in(Part part, std::int64_t number) {
    return number == GeometryEntity::unnumbered ? number : 2 * number + (part == Part::rest);
}
std::int64_t number_of(std::int64_t number) { return number == GeometryEntity::unnumbered ? number : number / 2; }

GeometryEntity entity_in(Part part, GeometryEntity entity) {
    entity.id = number_in(part, entity.id);
    for (std::int64_t& side : entity.sides) side = number_in(part, side);
    return entity;
}
GeometryEntity own_entity(GeometryEntity entity) {
    entity.id = number_of(entity.id);
    for (std::int64_t& side : entity.sides) side = number_of(side);
    return entity;
}

Part part_of(const GeometryEntity& entity) {
    const std::int64_t number = entity.id == GeometryEntity::unnumbered ? entity.sides[1] : entity.id;
    return number % 2 == 0 ? Part::first : Part::rest;
}

template <int D>
class MixedModel final : public GeometryModel<D> {
  public:
    explicit MixedModel(MixedGeometry<D> parts) : parts_(std::move(parts)) {
        std::sort(parts_.references.begin(), parts_.references.end());
    }

    [[nodiscard]] SurfacePoint<D> project(const SurfaceHint& hint, const Vec<D>& p) const override {
        if (hint.entity.kind != GeometryKind::none) {
            const Part part = part_of(hint.entity);
            return named(part, model(part).project({hint.facet, hint.reference, own_entity(hint.entity)}, p));
        }
        if (hint.reference) return of_reference(hint, p);
        const SurfacePoint<D> near = parts_.rest->project(hint, p);
        if (!near.reference) return nearest_of_all(named(Part::rest, near), p);
        if (owner(*near.reference) == Part::first)
            return of_reference({.facet = hint.facet, .reference = near.reference}, p);
        return named(Part::rest, near);
    }

    [[nodiscard]] GeometryEntity surface_at(const FacetSite<D>& facet) const override {
        const Part part = owner(facet.reference);
        return entity_in(part, model(part).surface_at(facet));
    }

    [[nodiscard]] bool has_surface_at(const FacetSite<D>& facet) const override {
        return model(owner(facet.reference)).has_surface_at(facet);
    }

    [[nodiscard]] bool are_within(const FacetSite<D>& facet, std::span<const Vec<D>> points,
                                  std::span<const double> bounds) const override {
        return model(owner(facet.reference)).are_within(facet, points, bounds);
    }

    [[nodiscard]] bool is_one_surface(Reference reference) const override {
        return model(owner(reference)).is_one_surface(reference);
    }

    [[nodiscard]] std::optional<EntityPoint<D>> evaluate(const GeometryEntity& entity,
                                                         const GeometryParameters& parameters) const override {
        return model(part_of(entity)).evaluate(own_entity(entity), parameters);
    }

    [[nodiscard]] GeometryEntity entity_at_edge(const EdgeSite<D>& edge) const override {
        if (const auto part = only_part(edge.facets)) return entity_in(*part, model(*part).entity_at_edge(edge));
        GeometryEntity entity = GeometryModel<D>::entity_at_edge(edge);
        if (entity.kind != GeometryKind::curve || meets_prescribed(edge)) return entity;
        if (const auto rim = rim_of(Part::first, edge, edge.middle()))
            entity.id = number_in(Part::first, rim->entity.id);
        return entity;
    }

    [[nodiscard]] GeometryEntity entity_at_vertex(std::span<const FacetSite<D>> around) const override {
        const auto part = only_part(around);
        return part ? entity_in(*part, model(*part).entity_at_vertex(around))
                    : GeometryModel<D>::entity_at_vertex(around);
    }

    [[nodiscard]] std::optional<Plane<D>> plane_at(const FacetSite<D>& facet) const override {
        return model(owner(facet.reference)).plane_at(facet);
    }

    [[nodiscard]] SurfacePoint<D> on_edge(const EdgeSite<D>& edge, const Vec<D>& p) const override {
        if (const auto part = only_part(edge.facets)) return named(*part, model(*part).on_edge(edge, p));
        if (!meets_prescribed(edge))
            if (auto rim = rim_of(Part::first, edge, p)) {
                rim->entity = entity_at_edge(edge);
                return *rim;
            }
        const SurfaceFoot<D> foot = foot_between(edge, p, [&] { return parts_.rest->on_edge(edge, p).point; });
        return point_on_edge<D>(*this, edge, foot, p);
    }

    [[nodiscard]] Vec<D> middle_of(const EdgeSite<D>& edge) const override {
        if (const auto part = only_part(edge.facets)) return model(*part).middle_of(edge);
        if (!meets_prescribed(edge))
            if (const auto rim = rim_of(Part::first, edge, edge.middle())) return rim->point;
        return foot_between(edge, edge.middle(), [&] { return parts_.rest->middle_of(edge); }).point;
    }

    [[nodiscard]] bool distances(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>> at,
                                 std::span<const Vec<D>> points, std::span<double> out) const override {
        return model(owner(facet.reference)).distances(facet, at, points, out);
    }

    [[nodiscard]] std::optional<LargestDistance> largest_distance(const FacetSite<D>& facet,
                                                                  std::span<const Barycentric<D - 1>> at,
                                                                  std::span<const Vec<D>> points,
                                                                  double bound) const override {
        return model(owner(facet.reference)).largest_distance(facet, at, points, bound);
    }

    [[nodiscard]] bool surface_points(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>> at,
                                      std::span<Vec<D>> out) const override {
        return model(owner(facet.reference)).surface_points(facet, at, out);
    }

    [[nodiscard]] bool is_built_from(const FacetSite<D>& facet) const override {
        return model(owner(facet.reference)).is_built_from(facet);
    }

    [[nodiscard]] double distance_at_facets(std::span<const FacetSite<D>> meet, const Vec<D>& p) const override {
        double largest = 0;
        for (const Part part : {Part::first, Part::rest})
            if (const auto own = facets_of(part, meet); !own.empty())
                largest = std::max(largest, model(part).distance_at_facets(own, p));
        return largest;
    }

    [[nodiscard]] std::optional<std::array<Vec<D>, D>> normals_at(const FacetSite<D>& facet) const override {
        return model(owner(facet.reference)).normals_at(facet);
    }

    [[nodiscard]] EntityName name_of_entity(const GeometryEntity& entity) const override {
        if (entity.kind == GeometryKind::none || entity.id == GeometryEntity::unnumbered)
            return GeometryModel<D>::name_of_entity(entity);
        return model(part_of(entity)).name_of_entity(own_entity(entity));
    }

    [[nodiscard]] Outcome<GeometrySamples<D>> sample_all(std::size_t target_count,
                                                         const Execution& execution) const override {
        GeometrySamples<D> all;
        for (const Part part : {Part::first, Part::rest}) {
            const auto own = model(part).sample_all(target_count, execution);
            if (!own) return fail(own.error());
            for (const auto& [entity, begin, end] : own->entities) {
                all.begin(entity_in(part, entity));
                for (std::size_t i = begin; i < end; ++i) all.add(own->points[i], own->weights[i], own->near[i]);
            }
        }
        return all;
    }

    [[nodiscard]] bool prescribes(Reference reference) const override {
        return model(owner(reference)).prescribes(reference);
    }
    [[nodiscard]] bool prescribes_any() const override {
        return parts_.first->prescribes_any() || parts_.rest->prescribes_any();
    }

  private:
    [[nodiscard]] const GeometryModel<D>& model(Part part) const {
        return part == Part::first ? *parts_.first : *parts_.rest;
    }
    [[nodiscard]] Part owner(Reference reference) const {
        const auto& references = parts_.references;
        return std::binary_search(references.begin(), references.end(), reference) ? Part::first : Part::rest;
    }
    [[nodiscard]] auto owns() const {
        return [this](const FacetSite<D>& facet) { return owner(facet.reference) == Part::first; };
    }

    [[nodiscard]] std::optional<Part> only_part(std::span<const FacetSite<D>> facets) const {
        if (std::none_of(facets.begin(), facets.end(), owns())) return Part::rest;
        return std::all_of(facets.begin(), facets.end(), owns()) ? std::optional(Part::first) : std::nullopt;
    }
    [[nodiscard]] std::vector<FacetSite<D>> facets_of(Part part, std::span<const FacetSite<D>> facets) const {
        std::vector<FacetSite<D>> own;
        own.reserve(facets.size());
        for (const FacetSite<D>& facet : facets)
            if (owner(facet.reference) == part) own.push_back(facet);
        return own;
    }
    [[nodiscard]] bool meets_prescribed(const EdgeSite<D>& edge) const {
        return std::any_of(edge.facets.begin(), edge.facets.end(), [&](const FacetSite<D>& facet) {
            return owner(facet.reference) == Part::rest && parts_.rest->prescribes(facet.reference);
        });
    }

    /// Closest point of the curve at which a part's prescribed surfaces end; empty if the part has no such curve.
    [[nodiscard]] std::optional<SurfacePoint<D>> rim_of(Part part, const EdgeSite<D>& edge, const Vec<D>& p) const {
        EdgeSite<D> own = edge;
        own.facets = facets_of(part, edge.facets);
        const auto prescribed = [&](const FacetSite<D>& facet) { return model(part).prescribes(facet.reference); };
        if (own.facets.empty() || !std::all_of(own.facets.begin(), own.facets.end(), prescribed)) return std::nullopt;
        SurfacePoint<D> found = model(part).on_edge(own, p);
        const bool is_known = found.entity.kind == GeometryKind::curve && found.entity.id != GeometryEntity::unnumbered;
        return is_known ? std::optional(std::move(found)) : std::nullopt;
    }
    template <class RestAt>
    [[nodiscard]] SurfaceFoot<D> foot_between(const EdgeSite<D>& edge, const Vec<D>& p, RestAt&& rest_at) const {
        const auto on_a_rim = [&]() -> std::optional<Vec<D>> {
            for (const Part part : {Part::first, Part::rest})
                if (const auto rim = rim_of(part, edge, p)) return rim->point;
            return std::nullopt;
        };
        return foot_on_edge(sheets_around(*parts_.first, owns(), *parts_.rest, edge), p, rest_at, on_a_rim);
    }

    [[nodiscard]] SurfacePoint<D> nearest_of_all(SurfacePoint<D> nearest, const Vec<D>& p) const {
        for (const Reference reference : parts_.references) {
            const SurfacePoint<D> here = of_reference({.facet = {}, .reference = reference}, p);
            if (here.entity.kind == GeometryKind::none) continue;
            if (nearest.entity.kind == GeometryKind::none || here.distance < nearest.distance) nearest = here;
        }
        return nearest;
    }

    [[nodiscard]] SurfacePoint<D> of_reference(const SurfaceHint& hint, const Vec<D>& p) const {
        const Part part = owner(*hint.reference);
        return named(part, model(part).project(hint, p));
    }

    [[nodiscard]] static SurfacePoint<D> named(Part part, SurfacePoint<D> point) {
        point.entity = entity_in(part, point.entity);
        return point;
    }

    MixedGeometry<D> parts_;
};

}  // namespace

template <int D>
std::shared_ptr<const GeometryModel<D>> model_of(MixedGeometry<D> mixed) {
    return std::make_shared<const MixedModel<D>>(std::move(mixed));
}

template <int D>
Outcome<Geometry<D>> with_surrogate(AnalyticGeometry<D> analytic, const LinearMesh<D>& mesh,
                                    const SurrogateFactory<D>& surrogate) {
    const auto& references = mesh.facets.references;
    const bool is_whole = std::all_of(references.begin(), references.end(),
                                      [&](Reference reference) { return surface_of(analytic, reference) != nullptr; });
    std::vector<Reference> specified;
    specified.reserve(analytic.surfaces.size());
    for (const auto& [reference, surface] : analytic.surfaces) specified.push_back(reference);
    Geometry<D> prescribed(std::move(analytic));
    if (is_whole) return prescribed;
    auto rest = surrogate(*prescribed);
    if (!rest) return fail(rest.error());
    return Geometry<D>(MixedGeometry<D>{std::move(specified), std::move(prescribed), std::move(*rest)});
}

#define CAMBER_INSTANTIATE(D)                                                    \
    template std::shared_ptr<const GeometryModel<D>> model_of(MixedGeometry<D>); \
    template Outcome<Geometry<D>> with_surrogate(AnalyticGeometry<D>, const LinearMesh<D>&, const SurrogateFactory<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
