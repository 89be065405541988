module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
module camber.solution_metric:sides;
import camber.core;
import :fixed_metrics;

namespace camber {

/// The facets of one patch around a vertex: one smooth side of the boundary.
using Side = std::span<const FacetId>;

/// n times the measure of a facet whose edges at a corner are `columns`.
[[nodiscard]] inline Vec<2> area_normal(const std::array<Vec<2>, 1>& columns) {
    return {{columns[0][1], -columns[0][0]}};
}
[[nodiscard]] inline Vec<3> area_normal(const std::array<Vec<3>, 2>& columns) { return cross(columns[0], columns[1]); }

/// Unit vectors, orthonormal with n.
[[nodiscard]] inline std::array<Vec<2>, 1> tangents_of(const Vec<2>& n) { return {Vec<2>{{-n[1], n[0]}}}; }
[[nodiscard]] inline std::array<Vec<3>, 2> tangents_of(const Vec<3>& n) {
    int least = 0;
    for (int i = 1; i < 3; ++i)
        if (std::abs(n[i]) < std::abs(n[least])) least = i;
    Vec<3> axis;
    axis[least] = 1;
    const Vec<3> a = normalised(cross(n, axis));
    return {a, cross(n, a)};
}

/// Of a straight facet.
template <int D>
[[nodiscard]] Vec<D> area_normal(const LinearMesh<D>& mesh, FacetId f) {
    const auto& v = mesh.facets.vertices[f];
    std::array<Vec<D>, D - 1> columns;
    for (int i = 0; i < D - 1; ++i) columns[i] = mesh.points[v[i + 1]] - mesh.points[v[0]];
    return area_normal(columns);
}

/// A vector turned to the side of another.
template <int D>
[[nodiscard]] Vec<D> to_side_of(const Vec<D>& n, const Vec<D>& side) {
    return dot(n, side) < 0 ? -n : n;
}

/// visit(side) for each side at a vertex with the facets `ball`, by rising patch; they are put into `facets`.
template <class Visit>
void each_side(std::span<const FacetId> ball, const Column<std::uint32_t>& patches, std::vector<FacetId>& facets,
               Visit&& visit) {
    facets.assign(ball.begin(), ball.end());
    std::erase_if(facets, [&](FacetId f) { return patches[f] == no_patch; });
    std::stable_sort(facets.begin(), facets.end(), [&](FacetId a, FacetId b) { return patches[a] < patches[b]; });
    for (std::size_t first = 0, last = 0; first < facets.size(); first = last) {
        while (last < facets.size() && patches[facets[last]] == patches[facets[first]]) ++last;
        visit(Side(facets.data() + first, last - first));
    }
}

/// Errors (usage): a largest size that is no length, patches that are not one a facet.
template <int D>
[[nodiscard]] Outcome<Done> check_sides(const LinearMesh<D>& mesh, const Column<std::uint32_t>& patches,
                                        double largest) {
    if (!(largest >= min_length) || !(largest <= max_length))
        return fail(ErrorKind::usage, "the largest size must be positive and finite");
    if (patches.size() != mesh.facets.size())
        return fail(ErrorKind::usage, "the patches are of another mesh: there must be one a facet");
    return Done{};
}

}  // namespace camber
