module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
module camber.distributed;
import camber.core;
import camber.metric;
import camber.operation;
import :adaptation_rows;
import :block_weights;

namespace camber {

namespace {

/// D! times the volume of a simplex.
double scaled_volume(const std::array<Vec<2>, 3>& p) {
    const Vec<2> a = p[1] - p[0], b = p[2] - p[0];
    return a[0] * b[1] - a[1] * b[0];
}
double scaled_volume(const std::array<Vec<3>, 4>& p) { return dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]); }

/// That of the simplex whose edges are of length 1.
template <int D>
constexpr double scaled_unit_volume = D == 2 ? 0.8660254037844386 : 0.7071067811865476;

template <int D>
std::uint64_t weight_of(const AdaptationRows<D>& rows, const AdaptedSimplex<D>& element, double coarser) {
    std::array<Vec<D>, D + 1> points;
    double density = 1;
    for (int i = 0; i <= D; ++i) {
        const AdaptedVertex<D>& v = rows.vertices[element.vertices[i].index()];
        points[i] = v.point;
        density *= v.metric.measure.density_root;
    }
    const double elements = std::abs(scaled_volume(points)) * density / (scaled_unit_volume<D> * pow(coarser, D));
    constexpr double most = 1ULL << 32U;
    constexpr auto one = static_cast<double>(ElementWeights::one);
    // What is no number counts as one element.
    return elements > 1 ? static_cast<std::uint64_t>(one * std::min(elements, most)) : ElementWeights::one;
}

}  // namespace

template <int D>
Outcome<ElementWeights> expected_elements(const AdaptationRows<D>& rows, double coarser, const Execution& execution) {
    auto weights = map_each(execution, rows.elements.size(),
                            [&](std::size_t e) { return weight_of(rows, rows.elements[e], coarser); });
    if (!weights) return fail(weights.error());
    ElementWeights made{std::move(*weights), 0};
    for (const std::uint64_t w : made.weights) made.sum += w;
    return made;
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<ElementWeights> expected_elements<D>(const AdaptationRows<D>&, double, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
