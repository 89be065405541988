module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
module camber.metric:along_edge;
import camber.core;
import camber.bezier;
import :back_mesh;
import :quadrature;

namespace camber {

/// A rule's points along an edge are sampled in packs of this many.
inline constexpr std::size_t edge_pack = 12;

/// sampled(points, hint, samples), a pack at a time, then use(q, sample) for each point of the rule in turn.
template <int D, class Sampled, class Use>
void each_along(const QuadraticEdge<D>& edge, const Quadrature& rule, ElementId hint, Sampled&& sampled, Use&& use) {
    std::array<Vec<D>, edge_pack> points;
    std::array<FieldSample<D>, edge_pack> samples;
    for (std::size_t begin = 0; begin < rule.size(); begin += edge_pack) {
        const std::size_t n = std::min(edge_pack, rule.size() - begin);
        for (std::size_t i = 0; i < n; ++i) points[i] = edge.point(rule.t[begin + i]);
        sampled(std::span<const Vec<D>>(points.data(), n), hint, std::span<FieldSample<D>>(samples.data(), n));
        hint = samples[n - 1].location.element;
        for (std::size_t i = 0; i < n; ++i) use(begin + i, samples[i]);
    }
}

/// use(q, sample) with log M at each point of the rule.
template <int D, class Use>
void each_value_along(const BackMesh<D>& back, const QuadraticEdge<D>& edge, const Quadrature& rule, ElementId hint,
                      Use&& use) {
    each_along(
        edge, rule, hint, [&](auto points, ElementId from, auto out) { back->sample_values(points, from, out); }, use);
}

/// The same with gradients.
template <int D, class Use>
void each_gradient_along(const BackMesh<D>& back, const QuadraticEdge<D>& edge, const Quadrature& rule, ElementId hint,
                         Use&& use) {
    each_along(
        edge, rule, hint,
        [&](auto points, ElementId from, auto out) { back->sample_with_gradients(points, from, out); }, use);
}

}  // namespace camber
