module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <vector>
module camber.operation;
import camber.core;
import camber.cavity;
import camber.surface;

namespace camber {

namespace {

/// Whether the surface breaks between the facets opposite two local vertices of an element.
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

/// A facet of the mesh that will be: its reference, and its vertices but for the point.
template <int D>
struct FacetAtPoint {
    FacetId like;  ///< one of the mesh, on the same surface
    Reference reference = 0;
    std::array<VertexId, D - 1> others{};
};

/// The facets at the point: those that the patch makes, and those on faces that it keeps.
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
    for (const auto& [element, opposite] : patch.star.kept)
        if (const FaceNeighbour across = mesh.face_neighbours[element][opposite]; across.valid() && across.is_facet())
            add(across.facet(), [&](int k) { return mesh.facets.vertices[across.facet()][k] == patch.point.vertex; });
    return found;
}

/// Whether the surface breaks along the edge from the point to a vertex; 2D: at the point.
template <int D>
bool breaks_at(const DynamicMesh<D>& mesh, const Patch<D>& patch, VertexId v) {
    if constexpr (D == 2)
        return patch.point.vertex.valid() && mesh.states[patch.point.vertex].place == VertexPlace::corner;
    for (const auto& [line, opposite] : patch.star.lines)
        if (mesh.edges[mesh.lines[line]][1 - opposite] == v) return !mesh.is_embedded(line);
    for (const auto& [element, opposite] : patch.star.kept) {
        const auto& vertices = mesh.elements.vertices[element];
        const int p = local_vertex(vertices, patch.point.vertex);
        const int q = local_vertex(vertices, v);
        if (p >= 0 && q >= 0 && p != q && mesh.breaks_at(mesh.edges_of[element][edge_between<D>[p][q]])) return true;
    }
    return false;
}

/// Whether the new element at a joined face has two facets on one smooth surface.
template <int D>
bool becomes_wall_element(const DynamicMesh<D>& mesh, const Patch<D>& patch, const ElementFace& open,
                          std::span<const FacetAtPoint<D>> at_point) {
    const auto& vertices = mesh.elements.vertices[open.element];
    const int point = static_cast<int>(open.opposite);
    std::array<const FacetAtPoint<D>*, D + 1> found{};  // by the local vertex that the facet leaves out
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
            int rest = 0;  // the vertex that both have beside the point; in 2D there is none
            while (rest == i || rest == j || rest == point) ++rest;
            if (!breaks_at(mesh, patch, rest <= D ? vertices[rest] : VertexId{})) return true;
        }
    }
    return false;
}

/// Whether the surface of a facet is a plane as far as the geometry knows.
template <int D>
bool is_plane(const AdaptationGoal<D>& goal, const DynamicMesh<D>& mesh, FacetId f) {
    return (*goal.geometry)->plane_at(site_of(mesh, f)).has_value();
}

}  // namespace

template <int D>
bool is_wall_element(const DynamicMesh<D>& mesh, ElementId e) {
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
bool adds_wall_elements(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const Patch<D>& patch) {
    if (!goal.geometry || r.mesh.is_surface()) return false;
    const auto at_point = facets_at_point(r.mesh, patch);
    if (at_point.empty()) return false;
    std::size_t before = 0, after = 0;
    for (const ElementFace& open : patch.star.joined)
        after += becomes_wall_element<D>(r.mesh, patch, open, at_point) ? 1 : 0;
    if (after == 0) return false;
    for (const ElementId e : patch.removed.elements) before += is_wall_element(r.mesh, e) ? 1 : 0;
    if (after <= before) return false;
    return std::ranges::any_of(at_point, [&](const FacetAtPoint<D>& f) { return !is_plane(goal, r.mesh, f.like); });
}

#define CAMBER_INSTANTIATE(D)                                           \
    template bool is_wall_element<D>(const DynamicMesh<D>&, ElementId); \
    template bool adds_wall_elements<D>(const Adaptation<D>&, const AdaptationGoal<D>&, const Patch<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
