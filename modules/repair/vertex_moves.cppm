module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>
module camber.repair:vertex_moves;
import :held_vertices;
import :state;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;
import camber.soundness;

namespace camber {

/// The mean ratio that the straight form of an element must keep when its vertices move, unless it has less already.
inline constexpr double enough_mean_ratio = 0.05;
/// Below it a straight element counts as flat.
inline constexpr double flat_mean_ratio = 1e-10;

/// What vertices that move must leave of a straight element.
template <int D>
struct ShapeFloor {
    double determinant = 0;  ///< of the mesh's straight element: det J is to be above bound · this
    double mean_ratio = 0;
};

template <int D>
[[nodiscard]] inline std::array<Vec<D>, D + 1> corners_of(const RepairState<D>& state, ElementId e) {
    std::array<Vec<D>, D + 1> corners;
    for (int i = 0; i <= D; ++i) corners[i] = state.mesh().linear.points[state.mesh().linear.elements.vertices[e][i]];
    return corners;
}
template <int D>
[[nodiscard]] inline std::array<Vec<D>, D + 1> corners_of(const NodalSimplex<D>& element) {
    std::array<Vec<D>, D + 1> corners;
    for (int i = 0; i <= D; ++i) corners[i] = element.nodes[i];
    return corners;
}
template <int D>
[[nodiscard]] inline double determinant_of(const std::array<Vec<D>, D + 1>& corners) {
    return (D == 2 ? 2 : 6) * signed_measure<D>(corners);
}

/// The mesh's own element; where that is flat or inverted, the mean over the sound elements around its free vertices.
template <int D>
[[nodiscard]] inline ShapeFloor<D> shape_floor(const RepairState<D>& state, ElementId e) {
    const auto own = corners_of(state, e);
    const double ratio = mean_ratio<D>(own);
    if (ratio > flat_mean_ratio) return {determinant_of<D>(own), std::min(ratio, enough_mean_ratio)};
    double determinants = 0, ratios = 0;
    std::size_t n = 0;
    for (const VertexId v : state.mesh().linear.elements.vertices[e]) {
        if (state.around_vertices.freedom[v] == VertexFreedom::held) continue;
        for (const ElementId near : state.around_vertices.balls[v]) {
            const auto corners = corners_of(state, near);
            const double of_near = mean_ratio<D>(corners);
            if (!(of_near > flat_mean_ratio)) continue;
            determinants += determinant_of<D>(corners);
            ratios += of_near;
            ++n;
        }
    }
    if (n == 0) return {};
    const auto count = static_cast<double>(n);
    return {determinants / count, std::min(ratios / count, enough_mean_ratio)};
}

/// The verdict on an element that becomes `next`: det J ≥ bound · |det| of its own straight form, and, where its
/// vertices are not where the mesh has them, of the mesh's too (`shape_floor`).
template <int D>
[[nodiscard]] inline Verdict verdict_of(const RepairState<D>& state, ElementId e, const NodalSimplex<D>& next) {
    const double bound = state.options.min_scaled_jacobian;
    const auto corners = corners_of(next);
    const Verdict own = decide(next, bound);
    if (own != Verdict::valid || bound == 0 || corners == corners_of(state, e)) return own;
    const double was = shape_floor(state, e).determinant;
    const double is = std::abs(determinant_of<D>(corners));
    return is < was ? decide(next, bound * was / is) : own;
}

/// Whether vertices that move leave the straight element shaped well enough: a mean ratio of at least min(the mesh's
/// element's, 0.05). An element that stays invalid may only become better.
template <int D>
[[nodiscard]] inline bool keeps_shape(const RepairState<D>& state, ElementId e, const NodalSimplex<D>& next,
                                      Verdict verdict) {
    const auto now = corners_of(state.element(e));
    const auto corners = corners_of(next);
    if (corners == now) return true;
    const double ratio = mean_ratio<D>(corners);
    if (verdict != Verdict::valid) return ratio >= mean_ratio<D>(now);
    return ratio >= shape_floor(state, e).mean_ratio;
}

/// Where something is in a rising list; -1: it is not there.
template <class T>
[[nodiscard]] inline int position_in(const std::vector<T>& sorted, const T& wanted) {
    const auto it = std::lower_bound(sorted.begin(), sorted.end(), wanted);
    return it != sorted.end() && *it == wanted ? static_cast<int>(it - sorted.begin()) : -1;
}

/// What the coefficients of an element with a free vertex are to be above.
template <int D>
[[nodiscard]] inline double min_of(const RepairState<D>& state, const RepairCavity<D>& cavity, ElementId e,
                                   double share) {
    constexpr double nothing = -std::numeric_limits<double>::infinity();
    if (share == 0) return nothing;
    for (const VertexId v : state.mesh().linear.elements.vertices[e])
        if (position_in(cavity.vertices, v) >= 0) return share * shape_floor(state, e).determinant;
    return nothing;
}

/// What a vertex weighs more than an edge's node.
inline constexpr double vertex_weight = 4;

/// The mean of the models of the vertex's edges, heavier, about where the vertex was.
template <int D>
[[nodiscard]] inline OffsetModel<D> model_of(const RepairState<D>& state, VertexId vertex) {
    OffsetModel<D> model{-state.moved.shift(vertex), {}};
    std::size_t n = 0;
    for (const ElementId e : state.around_vertices.balls[vertex])
        for (const EdgeId edge : state.mesh().edges.of_elements[e]) {
            const auto& ends = state.mesh().edges.vertices[edge];
            if (ends[0] != vertex && ends[1] != vertex) continue;
            model.hessian += state.models[edge].hessian;
            ++n;
        }
    model.hessian *= vertex_weight / static_cast<double>(std::max<std::size_t>(n, 1));
    return model;
}

}  // namespace camber
