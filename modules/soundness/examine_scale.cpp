module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
module camber.soundness;
import camber.core;
import camber.validity;
import :examination;

namespace camber {

namespace {

template <int D>
bool is_distant(const Vec<D>& p) {
    return std::any_of(p.c.begin(), p.c.end(), [](double x) { return std::abs(x) > max_length; });
}

/// Whether the simplex has an extent, and one that is too small in every coordinate. Without any its vertices are at
/// one place, which is told of as such.
template <int D, std::size_t N>
bool is_tiny(const Column<Vec<D>>& points, const std::array<VertexId, N>& simplex) {
    double extent = 0;
    for (int c = 0; c < D; ++c) {
        const auto [low, high] = std::minmax_element(
            simplex.begin(), simplex.end(), [&](VertexId a, VertexId b) { return points[a][c] < points[b][c]; });
        extent = std::max(extent, points[*high][c] - points[*low][c]);
    }
    return extent > 0 && extent < min_length;
}

}  // namespace

template <int D>
Outcome<Done> examine_scale(const LinearMesh<D>& mesh, Examination<D>& x, const Execution& execution) {
    const Execution quiet = without_progress(execution);
    auto distant = count(quiet, mesh.points.size(), [&](std::size_t v) { return is_distant(mesh.points[v]); });
    if (!distant) return fail(distant.error());
    auto elements = count(execution, mesh.elements.size(), [&](std::size_t e) {
        return x.element_counts(e) && is_tiny(mesh.points, mesh.elements.vertices[e]);
    });
    if (!elements) return fail(elements.error());
    auto facets = count(quiet, mesh.facets.size(), [&](std::size_t f) {
        return x.facet_counts(f) && is_tiny(mesh.points, mesh.facets.vertices[f]);
    });
    if (!facets) return fail(facets.error());
    x[Defect::distant_vertex] = *distant;
    x[Defect::tiny_element] = *elements;
    x[Defect::tiny_facet] = *facets;
    return Done{};
}

template <int D>
Outcome<Done> examine_scale(const QuadraticMesh<D>& mesh, Examination<D>& x, const Execution& execution) {
    auto distant =
        count(execution, mesh.mid_nodes.size(), [&](std::size_t i) { return is_distant(mesh.mid_nodes[i].point); });
    if (!distant) return fail(distant.error());
    if (distant->count > 0) distant->first += mesh.linear.points.size();
    x[Defect::distant_node] = *distant;
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                         \
    template Outcome<Done> examine_scale<D>(const LinearMesh<D>&, Examination<D>&, const Execution&); \
    template Outcome<Done> examine_scale<D>(const QuadraticMesh<D>&, Examination<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
