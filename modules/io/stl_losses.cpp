module;
#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;
import :legal_names;
import :stl_file;

namespace camber {

namespace stl {

namespace {

/// The triangles that are written, where the mesh is nothing else.
template <int D>
const Simplices<2>& triangles_of(const LinearMesh<D>& mesh) {
    if constexpr (D == 2)
        return mesh.elements;
    else
        return mesh.facets;
}

/// Whether triangles and vertices come back in the order that they have, and none is gone.
bool is_in_order(const Simplices<2>& triangles, std::size_t points, const Written& all) {
    const auto read = welded(all.triangles);
    return read.points.size() == points && read.facets.straight.size() == triangles.size() &&
           std::equal(triangles.vertices.begin(), triangles.vertices.end(), read.facets.straight.nodes.begin());
}

template <int D>
std::vector<Notice> losses(const LinearMesh<D>& mesh, bool is_curved, const Written& all, StlEncoding encoding) {
    std::vector<Notice> notices;
    const auto tell = [&](std::string what) { notices.push_back({"STL " + std::move(what)}); };
    const std::size_t tetrahedra = D == 3 ? mesh.elements.size() : 0;
    const Simplices<2>& triangles = triangles_of(mesh);
    if (tetrahedra > 0) tell("has no place for " + std::to_string(tetrahedra) + " tetrahedra: the boundary is written");
    if (is_curved) tell("is flat: each curved triangle becomes four between its nodes");
    if (D == 2 && mesh.facets.size() > 0) tell("has no place for " + std::to_string(mesh.facets.size()) + " edges");
    if (all.left_out > 0)
        tell("would make triangles without area of " + std::to_string(all.left_out) + ": these are left out");
    if (all.rounded > 0) tell("in binary has coordinates of 32 bits: " + std::to_string(all.rounded) + " are rounded");
    if (tetrahedra == 0 && !is_curved && !is_in_order(triangles, mesh.points.size(), all))
        tell("lists triangles alone, solid by solid: these and the vertices are numbered anew, of each place one");
    const bool same_references =
        std::equal(triangles.references.begin(), triangles.references.end(), all.triangles.begin(), all.triangles.end(),
                   [](Reference reference, const Triangle& t) { return reference == t.reference; });
    const bool same_names = mesh.groups.size() == all.groups.size() &&
                            std::equal(mesh.groups.begin(), mesh.groups.end(), all.groups.begin());
    for (Notice& notice : note_renamed("STL", "references", all.renamed)) notices.push_back(std::move(notice));
    if (tetrahedra == 0 && !is_curved && same_references && same_names) return notices;
    if (encoding == StlEncoding::binary)
        tell("in binary has no place for references");
    else
        tell("has solids for references: they become 1, 2 and so on, with the solids' names");
    return notices;
}

template <class Mesh, int D>
std::vector<Notice> all_losses(const Mesh& mesh, const LinearMesh<D>& linear, StlEncoding encoding) {
    const bool is_curved = Grid<Mesh>::degree == 2;
    auto notices = losses(linear, is_curved, written(mesh, linear.groups, encoding), encoding);
    if (encoding == StlEncoding::ascii)
        for (Notice& more : not_in_further_groups(linear, "STL")) notices.push_back(std::move(more));
    for (Notice& more : not_held(linear, {.groups = true, .feature_edges = false, .point_references = false}, "STL"))
        notices.push_back(std::move(more));
    return notices;
}

}  // namespace

}  // namespace stl

template <int D>
std::vector<Notice> not_in_stl(const LinearMesh<D>& mesh, StlEncoding encoding) {
    return stl::all_losses(mesh, mesh, encoding);
}
template <int D>
std::vector<Notice> not_in_stl(const QuadraticMesh<D>& mesh, StlEncoding encoding) {
    return stl::all_losses(mesh, mesh.linear, encoding);
}

#define CAMBER_INSTANTIATE(D)                                                      \
    template std::vector<Notice> not_in_stl<D>(const LinearMesh<D>&, StlEncoding); \
    template std::vector<Notice> not_in_stl<D>(const QuadraticMesh<D>&, StlEncoding);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
