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

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import :in_plane;
import :parts;
import :virtual_faces;

namespace camber {

namespace {

/// The model's edges as the curves of a 2D mesh, which take the part of surfaces there.
class CurvesModel final : public GeometryModel<2> {
  public:
    explicit CurvesModel(CadGeometry<2> cad)
        : cad_(std::move(cad)),
          joined_(joined_lists(cad_.association, cad_.model.edges())),
          all_(cad_.is_whole() ? curves_of(cad_.model) : cad_.met()) {}

    [[nodiscard]] SurfacePoint<2> project(const SurfaceHint& hint, const Vec<2>& p) const override {
        const auto curve = curve_of(hint, p);
        if (!curve) return {.point = p, .normal = {}};
        const auto& [there, foot, through] = closest_from(*curve, p);
        return {.point = foot.point,
                .normal = foot.normal,
                .distance = foot.distance,
                .entity = entity(there),
                .reference = hint.reference,
                .parameters = GeometryParameters{{foot.t, 0}}};
    }

    [[nodiscard]] GeometryEntity surface_at(const FacetSite<2>& facet) const override {
        return entity(curve_of(facet));
    }

    [[nodiscard]] std::optional<EntityPoint<2>> evaluate(const GeometryEntity& entity,
                                                         const GeometryParameters& parameters) const override {
        const auto curve = curve_of(entity);
        if (!curve) return std::nullopt;
        return point_on_curve(cad_.model, *curve, parameters.u[0]);
    }

    [[nodiscard]] std::array<double, 2> periods(const GeometryEntity& entity) const override {
        const auto curve = curve_of(entity);
        return {curve ? facts(*curve).period : 0, 0};
    }

    [[nodiscard]] GeometryEntity entity_at_vertex(std::span<const FacetSite<2>> around) const override {
        std::vector<std::size_t> curves;
        curves.reserve(around.size());
        for (const FacetSite<2>& facet : around) curves.push_back(curve_of(facet));
        std::sort(curves.begin(), curves.end());
        curves.erase(std::unique(curves.begin(), curves.end()), curves.end());
        if (curves.empty()) return {};
        if (curves.size() == 1) return entity(curves[0]);
        const auto& [a, b] = around.front().corners;
        const auto is_end_of = [&](const FacetSite<2>& f) { return f.corners[0] == a || f.corners[1] == a; };
        const Vec<2>& p = std::all_of(around.begin(), around.end(), is_end_of) ? a : b;
        const auto vertex = end_between(cad_.model, curves, p);
        if (!vertex) return {};
        const double reach = smooth_reach * distance(a, b);
        const bool is_joined = std::all_of(curves.begin(), curves.end(), [&](std::size_t curve) {
            return joined_[curve] != no_face && joined_[curve] == joined_[curves[0]];
        });
        if (is_joined && distance(vertex_in_plane(cad_.model, *vertex), p) > reach)
            return entity(*nearest_curve(cad_.model, curves, p));
        return {GeometryKind::corner,
                static_cast<std::int64_t>(*vertex),
                {static_cast<std::int64_t>(curves[0]), static_cast<std::int64_t>(curves[1])}};
    }

    [[nodiscard]] std::optional<Plane<2>> plane_at(const FacetSite<2>& facet) const override {
        const std::size_t curve = curve_of(facet);
        if (!facts(curve).is_line) return std::nullopt;
        const auto is_off = [&](const Vec<2>& p) {
            return closest_on_curve(cad_.model, curve, p).distance > at_one_place(cad_.model.parts());
        };
        if (joined_[curve] != no_face && std::any_of(facet.corners.begin(), facet.corners.end(), is_off))
            return std::nullopt;
        const EntityPoint<2> begin = point_on_curve(cad_.model, curve, facts(curve).first);
        return Plane<2>{begin.point, begin.normal};
    }

    [[nodiscard]] SurfacePoint<2> on_edge(const EdgeSite<2>& edge, const Vec<2>& p) const override {
        if (edge.facets.empty()) return {.point = p, .normal = {}};
        const FacetSite<2>& facet = edge.facets.front();
        return project({.facet = {}, .reference = facet.reference, .entity = surface_at(facet)}, p);
    }

    [[nodiscard]] double distance_where(std::span<const FacetSite<2>> meet, const Vec<2>& p) const override {
        double largest = 0;
        for (const FacetSite<2>& facet : meet)
            largest = std::max(largest, closest_from(curve_of(facet), p).foot.distance);
        return largest;
    }

    [[nodiscard]] EntityName called(const GeometryEntity& entity) const override {
        EntityName name = GeometryModel<2>::called(entity);
        if (entity.kind == GeometryKind::surface) name.kind = "edge";
        return name;
    }

    /// Of a part of the boundary those of the edges that it met.
    [[nodiscard]] Outcome<GeometrySamples<2>> own_samples(std::size_t wanted,
                                                          const Execution& execution) const override {
        auto whole = samples_of<2>(cad_.model, wanted, execution);
        if (!whole || cad_.is_whole()) return whole;
        return part_of_samples(*whole, [&](const GeometryEntity& entity) {
            return std::binary_search(all_.begin(), all_.end(), static_cast<std::size_t>(entity.id));
        });
    }

    [[nodiscard]] bool prescribes(Reference reference) const override { return !cad_.of_reference(reference).empty(); }
    [[nodiscard]] bool prescribes_any() const override { return true; }

  private:
    [[nodiscard]] static GeometryEntity entity(std::size_t curve) {
        return GeometryEntity::surface(static_cast<std::int64_t>(curve));
    }
    [[nodiscard]] const occ::EdgeFacts& facts(std::size_t curve) const {
        return cad_.model.parts().kernel->edges[curve];
    }

    /// The point near p of a curve, or of the curves joined to it where facets span several.
    [[nodiscard]] VirtualCurveFoot closest_from(std::size_t curve, const Vec<2>& p) const {
        if (joined_[curve] == no_face) return {curve, closest_on_curve(cad_.model, curve, p)};
        return closest_on_virtual_face(cad_.model, curve, p,
                                       [&](std::size_t other) { return joined_[other] == joined_[curve]; });
    }

    [[nodiscard]] std::optional<std::size_t> curve_of(const GeometryEntity& entity) const {
        const auto number = static_cast<std::size_t>(entity.id);
        if (entity.kind != GeometryKind::surface || entity.id < 0 || number >= cad_.model.edges()) return std::nullopt;
        return number;
    }

    [[nodiscard]] std::size_t curve_of(const FacetSite<2>& facet) const {
        if (cad_.has(facet)) return cad_.association.faces[facet.id];
        const auto candidates = cad_.of_reference(facet.reference);
        if (candidates.size() == 1) return candidates.front();
        return best_curve(cad_.model, candidates.empty() ? std::span<const std::size_t>(all_) : candidates,
                          facet.corners)
            .face;
    }

    [[nodiscard]] std::optional<std::size_t> curve_of(const SurfaceHint& hint, const Vec<2>& p) const {
        if (hint.entity.kind == GeometryKind::surface) return curve_of(hint.entity);
        return nearest_curve(cad_.model, hint.reference ? cad_.of_reference(*hint.reference) : all_, p);
    }

    CadGeometry<2> cad_;
    std::vector<std::uint32_t> joined_;
    std::vector<std::size_t> all_;
};

}  // namespace

std::shared_ptr<const GeometryModel<2>> model_of(CadGeometry<2> cad) {
    return std::make_shared<const CurvesModel>(std::move(cad));
}

}  // namespace camber
