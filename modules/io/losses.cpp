module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

namespace {

std::size_t without_zeros(const Column<Reference>& column) {
    return column.size() - static_cast<std::size_t>(std::count(column.begin(), column.end(), 0));
}

/// The simplices of that dimension and reference.
template <int D>
std::size_t simplices_of(const LinearMesh<D>& mesh, int dimension, Reference reference) {
    const auto count = [&](const Column<Reference>& column) {
        return static_cast<std::size_t>(std::count(column.begin(), column.end(), reference));
    };
    if (dimension == D) return count(mesh.elements.references);
    if (dimension == D - 1) return count(mesh.facets.references);
    return dimension == 1 ? count(mesh.edges.references) : 0;
}

struct Loss {
    bool held;
    std::size_t count;
    const char* what;
};

}  // namespace

template <int D>
std::vector<Notice> not_held(const LinearMesh<D>& mesh, Holds holds, std::string_view format) {
    const GivenGeometry<D>& given = mesh.geometry;
    const std::array losses{
        Loss{holds.corners, mesh.corners.size(), "corners"},
        Loss{holds.ridges, mesh.ridges.size(), "ridges"},
        Loss{holds.required,
             mesh.required_vertices.size() + mesh.elements.required.size() + mesh.facets.required.size() +
                 mesh.edges.required.size(),
             "required entities"},
        Loss{holds.directions, given.normals.at.size(), "normals at vertices"},
        Loss{holds.directions, given.tangents.at.size(), "tangents at vertices"},
        Loss{holds.associations, given.on_points.size() + given.on_curves.size() + given.on_surfaces.size(),
             "places on CAD entities"},
        Loss{holds.entities,
             without_zeros(mesh.elements.entities) + without_zeros(mesh.facets.entities) +
                 without_zeros(mesh.edges.entities),
             "entities that simplices lie on"},
        Loss{holds.groups, mesh.groups.size(), "names of references"},
        Loss{holds.feature_edges, D == 3 ? mesh.edges.size() : 0, "edges"},
        Loss{holds.point_references, without_zeros(mesh.point_references), "references of vertices"}};
    std::vector<Notice> notices;
    for (const Loss& loss : losses)
        if (!loss.held && loss.count > 0)
            notices.push_back(
                {std::string(format) + " has no place for " + std::to_string(loss.count) + " " + loss.what});
    return notices;
}

template <int D>
std::vector<Notice> not_in_further_groups(const LinearMesh<D>& mesh, std::string_view format) {
    constexpr std::array<std::string_view, 4> plurals{"points", "edges", "triangles", "tetrahedra"};
    std::map<std::pair<int, Reference>, std::vector<std::string>> names;
    for (const Group& group : mesh.groups) names[{group.dimension, group.reference}].push_back(group.name);
    std::vector<Notice> notices;
    for (const auto& [key, all] : names) {
        const std::size_t count = all.size() > 1 ? simplices_of(mesh, key.first, key.second) : 0;
        if (count == 0) continue;
        std::string others;
        for (std::size_t i = 1; i < all.size(); ++i) others += (i > 1 ? ", \"" : "\"") + all[i] + "\"";
        notices.push_back({std::string(format) + " has one group for a simplex: " + std::to_string(count) + " " +
                           std::string(plurals[static_cast<std::size_t>(key.first)]) + " of \"" + all.front() +
                           "\" are left out of " + others});
    }
    return notices;
}

#define CAMBER_INSTANTIATE(D)                                                                \
    template std::vector<Notice> not_held<D>(const LinearMesh<D>&, Holds, std::string_view); \
    template std::vector<Notice> not_in_further_groups<D>(const LinearMesh<D>&, std::string_view);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
