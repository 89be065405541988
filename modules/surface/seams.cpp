module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
module camber.surface;
import camber.core;

namespace camber {

namespace {

/// The longest side of a facet.
template <int D>
double size_of(const FacetSite<D>& facet) {
    double largest = 0;
    for (const Vec<D>& p : facet.corners)
        for (const Vec<D>& q : facet.corners) largest = std::max(largest, distance(p, q));
    return largest;
}

/// Whether a turn of a coordinate moves a point by nothing that could be seen beside the facet.
template <int D>
bool is_at_pole(const GeometryModel<D>& geometry, const GeometryEntity& surface, const GeometryParameters& at,
                std::size_t coordinate, double period, double size) {
    constexpr double unseen = 1e-9;
    const auto point = geometry.evaluate(surface, at);
    return point && norm(point->tangents[coordinate]) * period <= unseen * size;
}

}  // namespace

template <int D>
std::optional<std::array<GeometryParameters, D>> parameters_at_corners(const Geometry<D>& geometry,
                                                                       const FacetSite<D>& facet) {
    const GeometryEntity surface = geometry->surface_at(facet);
    if (surface.kind != GeometryKind::surface) return std::nullopt;
    std::array<GeometryParameters, D> out;
    for (std::size_t i = 0; i < D; ++i) {
        const SurfaceHint hint{.facet = facet.id, .reference = facet.reference, .entity = surface};
        const auto at = geometry->project(hint, facet.corners[i]).parameters;
        if (!at) return std::nullopt;
        out[i] = *at;
    }
    const std::array<double, 2> periods = geometry->periods(surface);
    const double size = size_of(facet);
    for (std::size_t k = 0; k < 2; ++k) {
        const double period = periods[k];
        if (!(period > 0)) continue;
        std::array<bool, D> poles{};
        for (std::size_t i = 0; i < D; ++i) poles[i] = is_at_pole(*geometry, surface, out[i], k, period, size);
        const auto first = static_cast<std::size_t>(std::find(poles.begin(), poles.end(), false) - poles.begin());
        if (first == D) continue;
        double sum = 0, count = 0;
        for (std::size_t i = 0; i < D; ++i) {
            if (poles[i]) continue;
            out[i].u[k] += period * std::round((out[first].u[k] - out[i].u[k]) / period);
            sum += out[i].u[k];
            ++count;
        }
        for (std::size_t i = 0; i < D; ++i)
            if (poles[i]) out[i].u[k] = sum / count;
    }
    return out;
}

template std::optional<std::array<GeometryParameters, 2>> parameters_at_corners<2>(const Geometry<2>&,
                                                                                   const FacetSite<2>&);
template std::optional<std::array<GeometryParameters, 3>> parameters_at_corners<3>(const Geometry<3>&,
                                                                                   const FacetSite<3>&);

}  // namespace camber
