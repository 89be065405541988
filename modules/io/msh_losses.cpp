module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import :legal_names;
import :msh_groups;

namespace camber {

namespace msh {

namespace {

constexpr std::string_view plural_of(int dimension) {
    constexpr std::string_view names[]{"points", "edges", "triangles", "tetrahedra"};
    return names[dimension];
}

/// "0 becomes 4, -1 becomes 5 and 3 more": the first few.
std::string listed_changes(const std::map<Reference, Reference>& changes) {
    constexpr std::size_t shown = 4;
    std::string text;
    std::size_t n = 0;
    for (auto change = changes.rbegin(); change != changes.rend() && n < shown; ++change, ++n)
        text += (n > 0 ? ", " : "") + std::to_string(change->first) + " becomes " + std::to_string(change->second);
    return text + (changes.size() > shown ? " and " + std::to_string(changes.size() - shown) + " more" : "");
}

/// References and entities of simplices of one dimension that get other numbers.
void tell_numbers(int dimension, const Classes& classes, std::vector<Notice>& notices) {
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
                           " get another entity: one has one reference in the file, and a positive number"});
}

/// What of the places of vertices is not written.
template <int D>
void tell_places(const LinearMesh<D>& mesh, MshVersion version, const Numbers& numbers, std::vector<Notice>& notices) {
    const GivenGeometry<D>& given = mesh.geometry;
    std::size_t kept = 0, distances = 0, renumbered = 0;
    for (std::size_t v = 0; v < numbers.places.size(); ++v) {
        const Place place = numbers.places[v];
        const bool is_kept =
            version == MshVersion::v4 ? place.dimension < 3 : place.dimension == 0 && mesh.point_references[v] > 0;
        if (!is_kept) continue;
        ++kept;
        if (place.dimension == 1 && given.on_curves[place.row].distance) ++distances;
        if (place.dimension == 2 && given.on_surfaces[place.row].distance) ++distances;
        if (entity_at(mesh, place) <= 0) ++renumbered;
    }
    const std::size_t all = given.on_points.size() + given.on_curves.size() + given.on_surfaces.size();
    const std::string name = version == MshVersion::v4 ? "MSH" : "MSH 2.2";
    if (kept < all)
        notices.push_back({name + " has no place for " + std::to_string(all - kept) + " places on CAD entities" +
                           (version == MshVersion::v4 ? ": one a vertex, the lowest, is kept" : "")});
    if (distances > 0)
        notices.push_back(
            {name + " has no place for the distances of " + std::to_string(distances) + " vertices from CAD entities"});
    if (renumbered > 0)
        notices.push_back({std::to_string(renumbered) + " vertices are on entities that get a positive number"});
}

/// References of vertices that are no point elements.
template <int D>
void tell_points(const LinearMesh<D>& mesh, const Numbers& numbers, std::vector<Notice>& notices) {
    const auto& references = mesh.point_references;
    const auto given =
        references.size() - static_cast<std::size_t>(std::count(references.begin(), references.end(), 0));
    if (given > numbers.points.size())
        notices.push_back({"MSH has no place for " + std::to_string(given - numbers.points.size()) +
                           " references of vertices: those of vertices on CAD points are kept if they are positive"});
}

}  // namespace

}  // namespace msh

template <int D>
std::vector<Notice> not_in_msh(const LinearMesh<D>& mesh, MshVersion version) {
    std::vector<Notice> notices =
        not_held(mesh, {.groups = true, .entities = true, .associations = true, .feature_edges = true}, "MSH");
    const msh::Numbers numbers = msh::numbers_of(mesh);
    msh::with_each_dimension(mesh, [&](auto dimension, const auto&) {
        msh::tell_numbers(dimension(), numbers.of_dimension[static_cast<std::size_t>(dimension())], notices);
    });
    msh::tell_places(mesh, version, numbers, notices);
    msh::tell_points(mesh, numbers, notices);
    if (version == MshVersion::v2)
        for (Notice& notice : not_in_further_groups(mesh, "MSH 2.2")) notices.push_back(std::move(notice));
    for (Notice& notice : renamed_groups(mesh.groups, with_legal_names(mesh.groups, msh::name_rule()), "MSH"))
        notices.push_back(std::move(notice));
    return notices;
}

#define CAMBER_INSTANTIATE(D) template std::vector<Notice> not_in_msh<D>(const LinearMesh<D>&, MshVersion);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
