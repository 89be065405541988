module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>
module camber.operation;
import camber.core;
import camber.crossing;
import camber.cavity;

namespace camber {

namespace {

/// A box that holds the whole facet.
template <int D>
Box<D> box_of_wall(const DynamicMesh<D>& mesh, const NodalFacet<D>& facet) {
    if (mesh.is_curved()) return box_of(facet);
    Box<D> box;
    for (int i = 0; i < D; ++i) box.include(facet.nodes[i]);
    return box;
}

/// True if the facets are clear of each other: proved to be disjoint, or straight and not crossing.
template <int D>
bool are_clear(const DynamicMesh<D>& mesh, const NodalFacet<D>& first, const NodalFacet<D>& second) {
    if (mesh.is_curved()) return crossing_of(first, second) == Crossing::disjoint;
    return are_surely_disjoint(first, second) || crossing_of(first, second) != Crossing::crossing;
}

}  // namespace

template <int D>
FacetGrid<D> walls_of(const DynamicMesh<D>& mesh) {
    FacetGrid<D> walls;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (!mesh.is_free(FacetId(f)) && !mesh.is_at_infinity(FacetId(f)))
            walls.insert(FacetId(f), box_of_wall(mesh, nodal_facet(mesh, FacetId(f))));
    return walls;
}

template <int D>
void follow_walls(FacetGrid<D>& walls, const DynamicMesh<D>& mesh, const IdChanges<FacetId>& facets) {
    for (const FacetId f : facets.removed) walls.remove(f);
    for (const FacetId f : facets.created)
        if (!mesh.is_free(f) && !mesh.is_at_infinity(f)) walls.insert(f, box_of_wall(mesh, nodal_facet(mesh, f)));
}

template <int D>
std::vector<NodalFacet<D>> new_facets(const DynamicMesh<D>& mesh, const Patch<D>& patch) {
    std::vector<NodalFacet<D>> made;
    made.reserve(patch.star.facets.size());
    const Vec<D> place = place_of_point(mesh, patch);
    for (const JoinedFacet& joined : patch.star.facets)
        if (!mesh.is_at_infinity(joined.facet)) made.push_back(nodal_facet(mesh, patch, joined, place));
    return made;
}

namespace {

/// Number of coordinates that all of these points share with `place`.
template <int D>
int shared_coordinates(const Vec<D>& place, std::span<const Vec<D>> points) {
    int count = 0;
    for (int c = 0; c < D; ++c) {
        const auto is_shared = [&](const Vec<D>& point) { return point[c] == place[c]; };
        count += std::ranges::all_of(points, is_shared) ? 1 : 0;
    }
    return count;
}

/// True if the lines that a patch removes, and those that it makes, lie on axes of coordinates through its point.
template <int D>
bool keeps_its_axes(const DynamicMesh<D>& mesh, const Patch<D>& patch, const Vec<D>& place) {
    const auto lies_on_axis = [&](std::span<const Vec<D>> points) {
        return shared_coordinates<D>(place, points) >= D - 1;
    };
    const auto stays = [&](LineId l) {
        const auto& [a, b] = mesh.edges[mesh.lines[l]];
        const Vec<D> node =
            mesh.is_curved() ? mesh.nodes[mesh.lines[l]].point : midpoint(mesh.points[a], mesh.points[b]);
        return lies_on_axis(std::array{mesh.points[a], node, mesh.points[b]});
    };
    const auto is_made_there = [&](const JoinedLine& joined) {
        const VertexId end = mesh.edges[mesh.lines[joined.line]][1 - joined.opposite];
        if (!mesh.is_curved()) return lies_on_axis(std::array{mesh.points[end]});
        const auto at = std::ranges::find(patch.star.boundary, end) - patch.star.boundary.begin();
        return lies_on_axis(std::array{mesh.points[end], patch.nodes[static_cast<std::size_t>(at)].point});
    };
    return std::ranges::all_of(patch.removed.lines, stays) && std::ranges::all_of(patch.star.lines, is_made_there);
}

}  // namespace

template <int D>
bool keeps_its_planes(const DynamicMesh<D>& mesh, const Patch<D>& patch, std::span<const NodalFacet<D>> made) {
    const Vec<D> place = place_of_point(mesh, patch);
    const auto lies_in_plane = [&](const NodalFacet<D>& facet) {
        return shared_coordinates<D>(place, facet.nodes) > 0;
    };
    const auto stays = [&](FacetId f) { return mesh.is_at_infinity(f) || lies_in_plane(nodal_facet(mesh, f)); };
    return keeps_its_axes(mesh, patch, place) && std::ranges::all_of(made, lies_in_plane) &&
           std::ranges::all_of(patch.removed.facets, stays);
}

namespace {

/// The facets that stay and whose boxes meet the one around all of these: they are looked up once.
template <int D>
std::vector<FacetId> facets_beside(const FacetGrid<D>& walls, const Patch<D>& patch, std::span<const Box<D>> boxes) {
    Box<D> all = boxes.front();
    for (const Box<D>& box : boxes) all.include(box);
    std::vector<FacetId> near;
    walls.meeting(all, near);
    const auto& removed = patch.removed.facets;
    std::erase_if(near, [&](FacetId f) { return std::ranges::find(removed, f) != removed.end(); });
    return near;
}

template <int D>
struct NearFacet {
    Box<D> box;
    NodalFacet<D> facet;
};

}  // namespace

template <int D>
bool are_walls_clear(const Adaptation<D>& r, const Patch<D>& patch, std::span<const NodalFacet<D>> made) {
    std::vector<Box<D>> boxes;
    boxes.reserve(made.size());
    for (const NodalFacet<D>& facet : made) boxes.push_back(box_of_wall(r.mesh, facet));
    std::vector<NearFacet<D>> near;
    for (const FacetId f : facets_beside<D>(r.walls, patch, boxes))
        near.push_back({r.walls.box(f), nodal_facet(r.mesh, f)});
    for (std::size_t i = 0; i < made.size(); ++i) {
        if (r.mesh.is_curved() && crossing_of_itself(made[i]) != Crossing::disjoint) return false;
        for (std::size_t j = 0; j < i; ++j)
            if (!are_clear(r.mesh, made[i], made[j])) return false;
        for (const auto& [box, facet] : near)
            if (box.meets(boxes[i]) && !are_clear(r.mesh, made[i], facet)) return false;
    }
    return true;
}

template <int D>
void NewWalls<D>::clear() {
    if (facets_.empty()) return;
    grid_ = {};
    facets_.clear();
}

template <int D>
bool NewWalls<D>::take(const DynamicMesh<D>& mesh, const Patch<D>& patch) {
    if (patch.star.facets.empty()) return true;
    const auto made = new_facets(mesh, patch);
    if (made.empty() || keeps_its_planes<D>(mesh, patch, made))
        return true;  // the facets that cover the plane are in the round's walls already
    for (const NodalFacet<D>& facet : made) {
        grid_.meeting(box_of_wall(mesh, facet), near_);
        for (const FacetId f : near_)
            if (!are_clear(mesh, facet, facets_[f.index()])) return false;
    }
    for (const NodalFacet<D>& facet : made) {
        grid_.insert(FacetId(facets_.size()), box_of_wall(mesh, facet));
        facets_.push_back(facet);
    }
    return true;
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template bool keeps_its_planes<D>(const DynamicMesh<D>&, const Patch<D>&, std::span<const NodalFacet<D>>); \
    template FacetGrid<D> walls_of<D>(const DynamicMesh<D>&);                                                  \
    template void follow_walls<D>(FacetGrid<D>&, const DynamicMesh<D>&, const IdChanges<FacetId>&);            \
    template std::vector<NodalFacet<D>> new_facets<D>(const DynamicMesh<D>&, const Patch<D>&);                 \
    template bool are_walls_clear<D>(const Adaptation<D>&, const Patch<D>&, std::span<const NodalFacet<D>>);   \
    template class NewWalls<D>;

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
