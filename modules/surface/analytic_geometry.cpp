module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
module camber.surface;
import camber.core;

namespace camber {

namespace {

template <int D>
class AnalyticModel final : public GeometryModel<D> {
  public:
    explicit AnalyticModel(AnalyticGeometry<D> geometry) : geometry_(std::move(geometry)) {}

    [[nodiscard]] SurfacePoint<D> project(const SurfaceHint& hint, const Vec<D>& p) const override {
        const std::int64_t row = row_of(hint);
        if (row < 0) return {.point = p, .normal = {}};
        const auto& [reference, surface] = geometry_.surfaces[static_cast<std::size_t>(row)];
        const auto foot = closest_point<D>(surface, p);
        return {.point = foot.point,
                .normal = foot.normal,
                .distance = camber::distance(foot.point, p),
                .entity = GeometryEntity::surface(row),
                .reference = hint.reference ? hint.reference : reference,
                .parameters = parameters_of<D>(surface, foot.point)};
    }

    [[nodiscard]] GeometryEntity surface_at(const FacetSite<D>& facet) const override {
        const std::int64_t row = row_of({.facet = {}, .reference = facet.reference, .entity = {}});
        return row < 0 ? GeometryEntity{} : GeometryEntity::surface(row);
    }

    [[nodiscard]] std::optional<EntityPoint<D>> evaluate(const GeometryEntity& entity,
                                                         const GeometryParameters& parameters) const override {
        const std::int64_t row = row_of({.facet = {}, .reference = {}, .entity = entity});
        if (row < 0) return std::nullopt;
        return point_of_parameters<D>(geometry_.surfaces[static_cast<std::size_t>(row)].second, parameters);
    }

    [[nodiscard]] std::array<double, 2> periods(const GeometryEntity& entity) const override {
        const std::int64_t row = row_of({.facet = {}, .reference = {}, .entity = entity});
        if (row < 0) return {0, 0};
        return periods_of<D>(geometry_.surfaces[static_cast<std::size_t>(row)].second);
    }

    [[nodiscard]] std::optional<Plane<D>> plane_at(const FacetSite<D>& facet) const override {
        const auto* surface = surface_of(geometry_, facet.reference);
        if (!surface) return plane_through(facet.corners);
        const auto* plane = std::get_if<Plane<D>>(surface);
        return plane ? std::optional(*plane) : std::nullopt;
    }

    [[nodiscard]] bool prescribes(Reference reference) const override {
        return surface_of(geometry_, reference) != nullptr;
    }
    [[nodiscard]] bool prescribes_any() const override { return true; }

  private:
    /// The row of the hint's entity, else of its reference's surface: the first of equal ones. −1 where there is none.
    [[nodiscard]] std::int64_t row_of(const SurfaceHint& hint) const {
        const auto& surfaces = geometry_.surfaces;
        if (hint.entity.kind == GeometryKind::surface)
            return hint.entity.id < static_cast<std::int64_t>(surfaces.size()) ? hint.entity.id : -1;
        const auto* surface = hint.reference ? surface_of(geometry_, *hint.reference) : nullptr;
        if (!surface) return -1;
        const auto first =
            std::find_if(surfaces.begin(), surfaces.end(), [&](const auto& row) { return row.second == *surface; });
        // A surface with a coordinate that is no number equals none.
        return first == surfaces.end() ? -1 : first - surfaces.begin();
    }

    AnalyticGeometry<D> geometry_;
};

}  // namespace

template <int D>
std::shared_ptr<const GeometryModel<D>> model_of(AnalyticGeometry<D> analytic) {
    return std::make_shared<const AnalyticModel<D>>(std::move(analytic));
}

#define CAMBER_INSTANTIATE(D) template std::shared_ptr<const GeometryModel<D>> model_of(AnalyticGeometry<D>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
