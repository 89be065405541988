module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
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

/// Numbers of the two parts' entities are told apart by their last bit.
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
/// The part's own entity again; of curves between both parts nobody's.
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
        if (near.reference && owner(*near.reference) == Part::first)
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

    [[nodiscard]] std::optional<EntityPoint<D>> evaluate(const GeometryEntity& entity,
                                                         const GeometryParameters& parameters) const override {
        return model(part_of(entity)).evaluate(own_entity(entity), parameters);
    }

    [[nodiscard]] std::array<double, 2> periods(const GeometryEntity& entity) const override {
        return model(part_of(entity)).periods(own_entity(entity));
    }

    [[nodiscard]] GeometryEntity entity_at_edge(const EdgeSite<D>& edge) const override {
        const auto [some, all] = owned_by_first(edge);
        if (some != all) return GeometryModel<D>::entity_at_edge(edge);
        const Part part = all ? Part::first : Part::rest;
        return entity_in(part, model(part).entity_at_edge(edge));
    }

    [[nodiscard]] std::optional<Plane<D>> plane_at(const FacetSite<D>& facet) const override {
        return model(owner(facet.reference)).plane_at(facet);
    }

    [[nodiscard]] SurfacePoint<D> on_edge(const EdgeSite<D>& edge, const Vec<D>& p) const override {
        if (!owned_by_first(edge).some) return named(Part::rest, parts_.rest->on_edge(edge, p));
        const SurfaceFoot<D> foot = foot_on_edge(*parts_.first, owns(), *parts_.rest, edge, p,
                                                 [&] { return parts_.rest->on_edge(edge, p).point; });
        return point_on_edge<D>(*this, edge, foot, p);
    }

    [[nodiscard]] Vec<D> middle_of(const EdgeSite<D>& edge) const override {
        if (!owned_by_first(edge).some) return parts_.rest->middle_of(edge);
        return foot_on_edge(*parts_.first, owns(), *parts_.rest, edge, edge.middle(),
                            [&] { return parts_.rest->middle_of(edge); })
            .point;
    }

    [[nodiscard]] bool distances(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>> at,
                                 std::span<const Vec<D>> points, std::span<double> out) const override {
        return model(owner(facet.reference)).distances(facet, at, points, out);
    }

    [[nodiscard]] bool points_over(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>> at,
                                   std::span<Vec<D>> out) const override {
        return model(owner(facet.reference)).points_over(facet, at, out);
    }

    [[nodiscard]] std::optional<std::array<Vec<D>, D>> normals_at(const FacetSite<D>& facet) const override {
        return model(owner(facet.reference)).normals_at(facet);
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

    struct Owned {
        bool some = false, all = false;
    };
    [[nodiscard]] Owned owned_by_first(const EdgeSite<D>& edge) const {
        const auto& facets = edge.facets;
        const bool some = std::any_of(facets.begin(), facets.end(), owns());
        return {some, some && std::all_of(facets.begin(), facets.end(), owns())};
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
                                    const std::function<Outcome<Surrogate<D>>()>& surrogate) {
    const auto& references = mesh.facets.references;
    const bool is_whole = std::all_of(references.begin(), references.end(),
                                      [&](Reference reference) { return surface_of(analytic, reference) != nullptr; });
    if (is_whole) return Geometry<D>(std::move(analytic));
    auto rest = surrogate();
    if (!rest) return fail(rest.error());
    std::vector<Reference> given;
    given.reserve(analytic.surfaces.size());
    for (const auto& [reference, surface] : analytic.surfaces) given.push_back(reference);
    return Geometry<D>(MixedGeometry<D>{std::move(given), std::move(analytic), std::move(*rest)});
}

#define CAMBER_INSTANTIATE(D)                                                               \
    template std::shared_ptr<const GeometryModel<D>> model_of(MixedGeometry<D>);            \
    template Outcome<Geometry<D>> with_surrogate(AnalyticGeometry<D>, const LinearMesh<D>&, \
                                                 const std::function<Outcome<Surrogate<D>>()>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
