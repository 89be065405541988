// Crossing checks of new facets, and elements with two facets on one smooth surface.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>
module camber.operation;
import camber.core;
import camber.cavity;
import camber.crossing;
import camber.surface;

namespace camber {

namespace {

template <int D>
Box<D> box_of_wall(const DynamicMesh<D>& mesh, const NodalFacet<D>& facet) {
    if (mesh.is_curved()) return box_of(facet);
    Box<D> box;
    for (int i = 0; i < D; ++i) box.include(facet.nodes[i]);
    return box;
}

template <int D>
bool are_clear(const DynamicMesh<D>& mesh, const NodalFacet<D>& first, const NodalFacet<D>& second) {
    if (mesh.is_curved()) return crossing_of(first, second) == Crossing::disjoint;
    return are_surely_disjoint(first, second) || crossing_of(first, second) != Crossing::crossing;
}

}  // namespace

template <int D>
FacetGrid<D> facet_grid_of(const DynamicMesh<D>& mesh) {
    FacetGrid<D> walls;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (!mesh.is_free(FacetId(f)) && !mesh.is_at_infinity(FacetId(f)))
            walls.insert(FacetId(f), box_of_wall(mesh, nodal_facet(mesh, FacetId(f))));
    return walls;
}

template <int D>
void update_facet_grid(FacetGrid<D>& walls, const DynamicMesh<D>& mesh, const IdChanges<FacetId>& facets) {
    for (const FacetId f : facets.removed) walls.remove(f);
    for (const FacetId f : facets.created)
        if (!mesh.is_free(f) && !mesh.is_at_infinity(f)) walls.insert(f, box_of_wall(mesh, nodal_facet(mesh, f)));
}

template <int D>
std::vector<NodalFacet<D>> new_facets(const DynamicMesh<D>& mesh, const Patch<D>& patch) {
    std::vector<NodalFacet<D>> added_facets;
    added_facets.reserve(patch.star.facets.size());
    const Vec<D> place = place_of_point(mesh, patch);
    for (const JoinedFacet& joined : patch.star.facets)
        if (!mesh.is_at_infinity(joined.facet)) added_facets.push_back(nodal_facet(mesh, patch, joined, place));
    return added_facets;
}

namespace {

template <int D>
int shared_coordinates(const Vec<D>& place, std::span<const Vec<D>> points) {
    int count = 0;
    for (int c = 0; c < D; ++c) {
        const auto is_shared = [&](const Vec<D>& point) { return point[c] == place[c]; };
        count += std::ranges::all_of(points, is_shared) ? 1 : 0;
    }
    return count;
}

template <int D>
bool preserves_axes(const DynamicMesh<D>& mesh, const Patch<D>& patch, const Vec<D>& place) {
    const auto lies_on_axis = [&](std::span<const Vec<D>> points) {
        return shared_coordinates<D>(place, points) >= D - 1;
    };
    const auto stays = [&](LineId l) {
        const auto& [a, b] = mesh.edges[mesh.lines[l]];
        const Vec<D> node =
            mesh.is_curved() ? mesh.nodes[mesh.lines[l]].point : midpoint(mesh.points[a], mesh.points[b]);
        return lies_on_axis(std::array{mesh.points[a], node, mesh.points[b]});
    };
    const auto is_created = [&](const JoinedLine& joined) {
        const VertexId end = mesh.edges[mesh.lines[joined.line]][1 - joined.opposite];
        if (!mesh.is_curved()) return lies_on_axis(std::array{mesh.points[end]});
        const auto at = std::ranges::find(patch.star.boundary, end) - patch.star.boundary.begin();
        return lies_on_axis(std::array{mesh.points[end], patch.nodes[static_cast<std::size_t>(at)].point});
    };
    return std::ranges::all_of(patch.removed.lines, stays) && std::ranges::all_of(patch.star.lines, is_created);
}

}  // namespace

template <int D>
bool preserves_planes(const DynamicMesh<D>& mesh, const Patch<D>& patch, std::span<const NodalFacet<D>> added_facets) {
    const Vec<D> place = place_of_point(mesh, patch);
    const auto lies_in_plane = [&](const NodalFacet<D>& facet) {
        return shared_coordinates<D>(place, facet.nodes) > 0;
    };
    const auto stays = [&](FacetId f) { return mesh.is_at_infinity(f) || lies_in_plane(nodal_facet(mesh, f)); };
    return preserves_axes(mesh, patch, place) && std::ranges::all_of(added_facets, lies_in_plane) &&
           std::ranges::all_of(patch.removed.facets, stays);
}

namespace {

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
bool are_facets_clear(const Adaptation<D>& r, const Patch<D>& patch, std::span<const NodalFacet<D>> added_facets) {
    std::vector<Box<D>> boxes;
    boxes.reserve(added_facets.size());
    for (const NodalFacet<D>& facet : added_facets) boxes.push_back(box_of_wall(r.mesh, facet));
    std::vector<NearFacet<D>> near;
    for (const FacetId f : facets_beside<D>(r.walls, patch, boxes))
        near.push_back({r.walls.box(f), nodal_facet(r.mesh, f)});
    for (std::size_t i = 0; i < added_facets.size(); ++i) {
        if (r.mesh.is_curved() && crossing_of_itself(added_facets[i]) != Crossing::disjoint) return false;
        for (std::size_t j = 0; j < i; ++j)
            if (!are_clear(r.mesh, added_facets[i], added_facets[j])) return false;
        for (const auto& [box, facet] : near)
            if (box.meets(boxes[i]) && !are_clear(r.mesh, added_facets[i], facet)) return false;
    }
    return true;
}

template <int D>
void NewFacets<D>::clear() {
    if (facets_.empty()) return;
    grid_ = {};
    facets_.clear();
}

template <int D>
bool NewFacets<D>::take(const DynamicMesh<D>& mesh, const Patch<D>& patch) {
    if (patch.star.facets.empty()) return true;
    const auto added_facets = new_facets(mesh, patch);
    if (added_facets.empty() || preserves_planes<D>(mesh, patch, added_facets))
        return true;  // new facets cover the same area as the removed ones, and other patches do not cross this area
    for (const NodalFacet<D>& facet : added_facets) {
        grid_.meeting(box_of_wall(mesh, facet), near_);
        for (const FacetId f : near_)
            if (!are_clear(mesh, facet, facets_[f.index()])) return false;
    }
    for (const NodalFacet<D>& facet : added_facets) {
        grid_.insert(FacetId(facets_.size()), box_of_wall(mesh, facet));
        facets_.push_back(facet);
    }
    return true;
}

namespace {

template <int D>
bool breaks_between(const DynamicMesh<D>& mesh, ElementId e, int i, int j) {
    if constexpr (D == 2) {
        const VertexId between = mesh.elements.vertices[e][3 - i - j];
        return mesh.states[between].place == VertexPlace::corner;
    } else {
        for (int k = 0; k < edges_per_simplex<3>; ++k) {
            const auto& [a, b] = local_edges<3>[k];
            if (a != i && a != j && b != i && b != j) return mesh.breaks_at(mesh.edges_of[e][k]);
        }
        return true;
    }
}

/// A facet at the point after the operation. `like`: existing facet of the same surface; `others`: the vertices except
/// the point.
template <int D>
struct FacetAtPoint {
    FacetId like;
    Reference reference = 0;
    std::array<VertexId, D - 1> others{};
};

template <int D>
std::vector<FacetAtPoint<D>> facets_at_point(const DynamicMesh<D>& mesh, const Patch<D>& patch) {
    std::vector<FacetAtPoint<D>> found;
    const auto add = [&](FacetId f, auto&& is_point) {
        FacetAtPoint<D> facet{f, mesh.facets.references[f], {}};
        int n = 0;
        for (int k = 0; k < D; ++k)
            if (!is_point(k) && n < D - 1) facet.others[n++] = mesh.facets.vertices[f][k];
        found.push_back(facet);
    };
    for (const auto& [facet, opposite] : patch.star.facets)
        add(facet, [at = static_cast<int>(opposite)](int k) { return k == at; });
    for (const auto& [element, opposite] : patch.star.preserved)
        if (const FaceNeighbour across = mesh.face_neighbours[element][opposite]; across.valid() && across.is_facet())
            add(across.facet(), [&](int k) { return mesh.facets.vertices[across.facet()][k] == patch.point.vertex; });
    return found;
}

template <int D>
bool breaks_at(const DynamicMesh<D>& mesh, const Patch<D>& patch, VertexId v) {
    if constexpr (D == 2)
        return patch.point.vertex.valid() && mesh.states[patch.point.vertex].place == VertexPlace::corner;
    for (const auto& [line, opposite] : patch.star.lines)
        if (mesh.edges[mesh.lines[line]][1 - opposite] == v) return !mesh.is_embedded(line);
    for (const auto& [element, opposite] : patch.star.preserved) {
        const auto& vertices = mesh.elements.vertices[element];
        const int p = local_vertex(vertices, patch.point.vertex);
        const int q = local_vertex(vertices, v);
        if (p >= 0 && q >= 0 && p != q && mesh.breaks_at(mesh.edges_of[element][edge_between<D>[p][q]])) return true;
    }
    return false;
}

template <int D>
bool becomes_two_facet_element(const DynamicMesh<D>& mesh, const Patch<D>& patch, const ElementFace& open,
                               std::span<const FacetAtPoint<D>> at_point) {
    const auto& vertices = mesh.elements.vertices[open.element];
    const int point = static_cast<int>(open.opposite);
    std::array<const FacetAtPoint<D>*, D + 1> found{};  // facet opposite each local vertex
    for (const FacetAtPoint<D>& facet : at_point) {
        std::array<bool, D + 1> has{};
        has[point] = true;
        const bool is_side = std::ranges::all_of(facet.others, [&](VertexId v) {
            const int local = local_vertex(vertices, v);
            if (local >= 0) has[local] = true;
            return local >= 0 && local != point;
        });
        if (is_side) found[std::ranges::find(has, false) - has.begin()] = &facet;
    }
    const FaceNeighbour across = mesh.face_neighbours[open.element][point];
    const bool has_outer = across.valid() && across.is_facet();
    for (int i = 0; i <= D; ++i) {
        if (!found[i]) continue;
        if (has_outer && mesh.facets.references[across.facet()] == found[i]->reference &&
            !breaks_between(mesh, open.element, i, point))
            return true;
        for (int j = 0; j < i; ++j) {
            if (!found[j] || found[i]->reference != found[j]->reference) continue;
            int rest = 0;  // 3D: local index of the second vertex that both facets share, besides the point
            while (rest == i || rest == j || rest == point) ++rest;
            if (!breaks_at(mesh, patch, rest <= D ? vertices[rest] : VertexId{})) return true;
        }
    }
    return false;
}

template <int D>
bool is_plane(const AdaptationGoal<D>& goal, const DynamicMesh<D>& mesh, FacetId f) {
    return (*goal.geometry)->plane_at(site_of(mesh, f)).has_value();
}

}  // namespace

template <int D>
bool is_two_facet_element(const DynamicMesh<D>& mesh, ElementId e) {
    for (int i = 0; i <= D; ++i) {
        const FaceNeighbour a = mesh.face_neighbours[e][i];
        if (!a.valid() || !a.is_facet()) continue;
        for (int j = 0; j < i; ++j) {
            const FaceNeighbour b = mesh.face_neighbours[e][j];
            if (!b.valid() || !b.is_facet()) continue;
            if (mesh.facets.references[a.facet()] != mesh.facets.references[b.facet()]) continue;
            if (!breaks_between(mesh, e, i, j)) return true;
        }
    }
    return false;
}

template <int D>
bool adds_two_facet_elements(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const Patch<D>& patch) {
    if (!goal.geometry || r.mesh.is_surface()) return false;
    const auto at_point = facets_at_point(r.mesh, patch);
    if (at_point.empty()) return false;
    std::size_t before = 0, after = 0;
    for (const ElementFace& open : patch.star.joined)
        after += becomes_two_facet_element<D>(r.mesh, patch, open, at_point) ? 1 : 0;
    if (after == 0) return false;
    for (const ElementId e : patch.removed.elements) before += is_two_facet_element(r.mesh, e) ? 1 : 0;
    if (after <= before) return false;
    return std::ranges::any_of(at_point, [&](const FacetAtPoint<D>& f) { return !is_plane(goal, r.mesh, f.like); });
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template bool preserves_planes<D>(const DynamicMesh<D>&, const Patch<D>&, std::span<const NodalFacet<D>>); \
    template FacetGrid<D> facet_grid_of<D>(const DynamicMesh<D>&);                                             \
    template void update_facet_grid<D>(FacetGrid<D>&, const DynamicMesh<D>&, const IdChanges<FacetId>&);       \
    template std::vector<NodalFacet<D>> new_facets<D>(const DynamicMesh<D>&, const Patch<D>&);                 \
    template bool are_facets_clear<D>(const Adaptation<D>&, const Patch<D>&, std::span<const NodalFacet<D>>);  \
    template class NewFacets<D>;                                                                               \
    template bool is_two_facet_element<D>(const DynamicMesh<D>&, ElementId);                                   \
    template bool adds_two_facet_elements<D>(const Adaptation<D>&, const AdaptationGoal<D>&, const Patch<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
