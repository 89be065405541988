module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
module camber.cavity;
import camber.core;

namespace camber {

namespace {

/// The local vertices with this flag, in order; at most two are asked for.
template <int D>
std::array<int, 2> first_two(const PointSite<D>& site, bool spans) {
    std::array<int, 2> found{};
    std::size_t n = 0;
    for (int i = 0; i <= D && n < 2; ++i)
        if (site.spans[i] == spans) found[n++] = i;
    return found;
}

}  // namespace

template <int D>
Insertion<D> insertion_at(const DynamicMesh<D>& mesh, const PointSite<D>& site) {
    Insertion<D> out;
    out.site = site;
    const int dimension = site.dimension();
    const auto [i, j] = first_two(site, true);
    if (dimension == 0) {
        out.vertex = mesh.elements.vertices[site.element][i];
        out.place = mesh.states[out.vertex].place;
        cavity_of_vertex(mesh, out.vertex, out.cavity);
        return out;
    }
    if (dimension == 1)
        cavity_of_edge(mesh, site.element, edge_between<D>[i][j], out.cavity);
    else if (dimension == D - 1)
        cavity_of_face(mesh, site.element, first_two(site, false)[0], out.cavity);
    else
        out.cavity.elements.push_back(site.element);
    if (!out.cavity.facets.empty()) out.place = VertexPlace::surface;
    if (!out.cavity.lines.empty()) out.place = VertexPlace::line;
    return out;
}

template <int D>
Outcome<Insertion<D>> insertion(const DynamicMesh<D>& mesh, const Vec<D>& point, ElementId hint, double near) {
    const auto site = locate(mesh, point, hint, near);
    if (!site) return fail(site.error());
    return insertion_at(mesh, *site);
}

#define CAMBER_INSTANTIATE(D)                                                          \
    template Insertion<D> insertion_at<D>(const DynamicMesh<D>&, const PointSite<D>&); \
    template Outcome<Insertion<D>> insertion<D>(const DynamicMesh<D>&, const Vec<D>&, ElementId, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
