module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

std::size_t without_zeros(const Column<Reference>& column) {
    return column.size() - static_cast<std::size_t>(std::count(column.begin(), column.end(), 0));
}

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
    bool supported = false;
    std::size_t count = 0;
    const char* what = "";
    bool is_detail = true;
};

}  // namespace

template <int D>
std::vector<Notice> unsupported_data(const LinearMesh<D>& mesh, FormatCapabilities capabilities,
                                     std::string_view format) {
    const InputGeometry<D>& input = mesh.geometry;
    const std::array losses{
        Loss{capabilities.corners, mesh.corners.size(), "corners"},
        Loss{capabilities.ridges, mesh.ridges.size(), "ridges"},
        Loss{capabilities.required,
             mesh.required_vertices.size() + mesh.elements.required.size() + mesh.facets.required.size() +
                 mesh.edges.required.size(),
             "required entities"},
        Loss{capabilities.directions, input.normals.at.size(), "normals at vertices"},
        Loss{capabilities.directions, input.tangents.at.size(), "tangents at vertices"},
        Loss{capabilities.associations, input.on_points.size() + input.on_curves.size() + input.on_surfaces.size(),
             "associations with CAD entities"},
        Loss{capabilities.entities,
             without_zeros(mesh.elements.entities) + without_zeros(mesh.facets.entities) +
                 without_zeros(mesh.edges.entities),
             "CAD entities of simplices"},
        Loss{capabilities.groups, mesh.groups.size(), "names of references", false},
        Loss{capabilities.feature_edges, D == 3 ? mesh.edges.size() : 0, "edges"},
        Loss{capabilities.point_references, without_zeros(mesh.point_references), "references of vertices"}};
    std::vector<Notice> notices;
    for (const Loss& loss : losses)
        if (!loss.supported && loss.count > 0)
            notices.push_back(
                {std::string(format) + " has no place for " + std::to_string(loss.count) + " " + loss.what,
                 loss.is_detail});
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

namespace msh {

namespace {

constexpr std::string_view plural_of(int dimension) {
    constexpr std::string_view names[]{"points", "edges", "triangles", "tetrahedra"};
    return names[dimension];
}

std::string listed_changes(const std::map<Reference, Reference>& changes) {
    constexpr std::size_t shown = 4;
    std::string text;
    std::size_t n = 0;
    for (auto change = changes.rbegin(); change != changes.rend() && n < shown; ++change, ++n)
        text += (n > 0 ? ", " : "") + std::to_string(change->first) + " becomes " + std::to_string(change->second);
    return text + (changes.size() > shown ? " and " + std::to_string(changes.size() - shown) + " more" : "");
}

void note_numbers(int dimension, const Classes& classes, std::vector<Notice>& notices) {
    std::size_t references = 0, entities = 0;
    for (const Class& one : classes.list) {
        if (one.reference != one.physical) references += one.count;
        if (one.entity != 0 && one.entity != one.tag) entities += one.count;
    }
    const std::string of(plural_of(dimension));
    std::map<Reference, Reference> changed = classes.physical_of;
    std::erase_if(changed, [](const auto& change) { return change.first == change.second; });
    if (!changed.empty())
        notices.push_back({"physical tags must be positive: of " + std::to_string(references) + " " + of +
                           " the reference " + listed_changes(changed)});
    if (entities > 0)
        notices.push_back({std::to_string(entities) + " " + of +
                               " get another entity: in the file, each entity has one reference and a positive number",
                           true});
}

template <int D>
void note_places(const LinearMesh<D>& mesh, MshVersion version, const Numbers& numbers, std::vector<Notice>& notices) {
    const InputGeometry<D>& input = mesh.geometry;
    std::size_t preserved = 0, distances = 0, renumbered = 0;
    for (std::size_t v = 0; v < numbers.places.size(); ++v) {
        const Place place = numbers.places[v];
        const bool is_preserved =
            version == MshVersion::v4 ? place.dimension < 3 : place.dimension == 0 && mesh.point_references[v] > 0;
        if (!is_preserved) continue;
        ++preserved;
        if (place.dimension == 1 && input.on_curves[place.row].distance) ++distances;
        if (place.dimension == 2 && input.on_surfaces[place.row].distance) ++distances;
        if (entity_at(mesh, place) <= 0) ++renumbered;
    }
    const std::size_t all = input.on_points.size() + input.on_curves.size() + input.on_surfaces.size();
    const std::string name = version == MshVersion::v4 ? "MSH" : "MSH 2.2";
    if (preserved < all)
        notices.push_back({name + " has no place for " + std::to_string(all - preserved) +
                               " associations with CAD entities" +
                               (version == MshVersion::v4 ? ": each vertex has one in the file, that of the lowest "
                                                            "dimension"
                                                          : ""),
                           true});
    if (distances > 0)
        notices.push_back(
            {name + " has no place for the distances of " + std::to_string(distances) + " vertices from CAD entities",
             true});
    if (renumbered > 0)
        notices.push_back(
            {std::to_string(renumbered) + " vertices are on entities that get a new, positive number", true});
}

template <int D>
void note_points(const LinearMesh<D>& mesh, const Numbers& numbers, std::vector<Notice>& notices) {
    const auto& references = mesh.point_references;
    const auto input =
        references.size() - static_cast<std::size_t>(std::count(references.begin(), references.end(), 0));
    if (input > numbers.points.size())
        notices.push_back({"MSH has no place for " + std::to_string(input - numbers.points.size()) +
                               " references of vertices: only positive references of vertices on CAD points are "
                               "written",
                           true});
}

}  // namespace

}  // namespace msh

template <int D>
std::vector<Notice> not_in_msh(const Mesh<D>& all, MshVersion version) {
    const LinearMesh<D> mesh = straight_simplices(all);
    std::vector<Notice> notices =
        unsupported_data(mesh, {.groups = true, .entities = true, .associations = true, .feature_edges = true}, "MSH");
    const msh::Numbers numbers = msh::numbers_of(mesh);
    msh::with_each_dimension(mesh, [&](auto dimension, const auto&) {
        msh::note_numbers(dimension(), numbers.of_dimension[static_cast<std::size_t>(dimension())], notices);
    });
    msh::note_places(mesh, version, numbers, notices);
    msh::note_points(mesh, numbers, notices);
    if (version == MshVersion::v2)
        for (Notice& notice : not_in_further_groups(mesh, "MSH 2.2")) notices.push_back(std::move(notice));
    for (Notice& notice : renamed_groups(mesh.groups, with_legal_names(mesh.groups, msh::name_rule()), "MSH"))
        notices.push_back(std::move(notice));
    return notices;
}

namespace stl {

namespace {

template <int D>
const Simplices<2>& triangles_of(const LinearMesh<D>& mesh) {
    if constexpr (D == 2)
        return mesh.elements;
    else
        return mesh.facets;
}

bool is_in_order(const Simplices<2>& triangles, std::size_t points, const Written& all) {
    const auto read = welded(all.triangles);
    return read.points.size() == points && read.facets.straight.size() == triangles.size() &&
           std::equal(triangles.vertices.begin(), triangles.vertices.end(), read.facets.straight.nodes.begin());
}

template <int D>
std::vector<Notice> losses(const LinearMesh<D>& mesh, bool is_curved, const Written& all, StlEncoding encoding) {
    std::vector<Notice> notices;
    const auto note = [&](std::string what) { notices.push_back({"STL " + std::move(what)}); };
    const std::size_t tetrahedra = D == 3 ? mesh.elements.size() : 0;
    const Simplices<2>& triangles = triangles_of(mesh);
    if (tetrahedra > 0) note("has no place for " + std::to_string(tetrahedra) + " tetrahedra: the boundary is written");
    if (is_curved) note("has only flat triangles: each curved triangle becomes four, with its nodes as corners");
    if (D == 2 && mesh.facets.size() > 0) note("has no place for " + std::to_string(mesh.facets.size()) + " edges");
    if (all.left_out > 0)
        note("cannot store triangles without area: " + std::to_string(all.left_out) + " are left out");
    if (all.rounded > 0) note("in binary has coordinates of 32 bits: " + std::to_string(all.rounded) + " are rounded");
    if (tetrahedra == 0 && !is_curved && !is_in_order(triangles, mesh.points.size(), all))
        note(
            "lists only triangles, solid by solid: triangles and vertices are renumbered, with one vertex at each "
            "position");
    const bool same_references =
        std::equal(triangles.references.begin(), triangles.references.end(), all.triangles.begin(), all.triangles.end(),
                   [](Reference reference, const Triangle& t) { return reference == t.reference; });
    const bool same_names = mesh.groups.size() == all.groups.size() &&
                            std::equal(mesh.groups.begin(), mesh.groups.end(), all.groups.begin());
    for (Notice& notice : note_renamed("STL", "references", all.renamed)) notices.push_back(std::move(notice));
    if (tetrahedra == 0 && !is_curved && same_references && same_names) return notices;
    if (encoding == StlEncoding::binary)
        note("in binary has no place for references");
    else
        note("stores references as solids: they become 1, 2 and so on, with the names of the solids");
    return notices;
}

template <class Mesh>
std::vector<Notice> all_losses(const Mesh& mesh, StlEncoding encoding) {
    const Grid<Mesh> grid{mesh};
    const auto& linear = grid.linear();
    const bool is_curved = grid.degree == 2;
    auto notices = losses(linear, is_curved, written(mesh, linear.groups, encoding), encoding);
    if (encoding == StlEncoding::ascii)
        for (Notice& more : not_in_further_groups(linear, "STL")) notices.push_back(std::move(more));
    for (Notice& more :
         unsupported_data(linear, {.groups = true, .feature_edges = false, .point_references = false}, "STL"))
        notices.push_back(std::move(more));
    return notices;
}

}  // namespace

}  // namespace stl

template <int D>
std::vector<Notice> not_in_stl(const Mesh<D>& mesh, StlEncoding encoding) {
    const auto losses = on_simplices(mesh, [&](const auto& simplices) -> Outcome<std::vector<Notice>> {
        return stl::all_losses(simplices, encoding);
    });
    return losses ? *losses : std::vector<Notice>{};
}

template <int D>
std::vector<Notice> not_in_vtu(const Mesh<D>& mesh) {
    return unsupported_data(straight_simplices(mesh), {.entities = true}, "VTU");
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template std::vector<Notice> unsupported_data<D>(const LinearMesh<D>&, FormatCapabilities, std::string_view); \
    template std::vector<Notice> not_in_further_groups<D>(const LinearMesh<D>&, std::string_view);                \
    template std::vector<Notice> not_in_msh<D>(const Mesh<D>&, MshVersion);                                       \
    template std::vector<Notice> not_in_vtu<D>(const Mesh<D>&);                                                   \
    template std::vector<Notice> not_in_stl<D>(const Mesh<D>&, StlEncoding);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
