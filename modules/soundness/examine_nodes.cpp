module;
#include <array>
#include <cstddef>
#include <cstdint>
module camber.soundness;
import camber.core;
import camber.validity;
import :examination;

namespace camber {

namespace {

/// Edges whose ends are at the same places lie on the two sides of a slit, or have duplicate vertices: those are told
/// of already.
template <int D>
bool same_ends(const QuadraticMesh<D>& mesh, std::size_t e, std::size_t f) {
    const auto& points = mesh.linear.points;
    const auto& [a, b] = mesh.edges.vertices[e];
    const auto& [c, d] = mesh.edges.vertices[f];
    return (points[a] == points[c] && points[b] == points[d]) || (points[a] == points[d] && points[b] == points[c]);
}

}  // namespace

template <int D>
Outcome<Done> examine_nodes(const QuadraticMesh<D>& mesh, Examination<D>& x, const Execution& execution) {
    const std::size_t vertices = mesh.linear.points.size(), n = vertices + mesh.mid_nodes.size();
    const auto point = [&](std::size_t i) -> const Vec<D>& {
        return i < vertices ? mesh.linear.points[i] : mesh.mid_nodes[i - vertices].point;
    };
    const auto used = [&](std::size_t i) {
        return i >= vertices || !x.elements_of[i].empty() || !x.facets_of[i].empty();
    };
    const auto meets = [&](std::size_t i, std::size_t earlier) {
        return i >= vertices && (earlier < vertices || !same_ends(mesh, i - vertices, earlier - vertices));
    };
    auto twin = coincident(n, point, used, meets, execution);
    if (!twin) return fail(twin.error());
    auto found = count(without_progress(execution), n, [&](std::size_t i) { return (*twin)[i] != nobody; });
    if (!found) return fail(found.error());
    if (found->count > 0) found->other = (*twin)[found->first - 1] + std::size_t{1};
    x[Defect::coincident_node] = *found;
    return Done{};
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Done> examine_nodes<D>(const QuadraticMesh<D>&, Examination<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
