module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>
module camber.cavity;
import camber.core;

namespace camber {

namespace {

template <class Id>
void rise(std::vector<Id>& ids) {
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

/// The facets on faces that hold these local vertices.
template <int D>
void add_facets(const DynamicMesh<D>& mesh, ElementId e, const std::array<bool, D + 1>& held,
                std::vector<FacetId>& found) {
    for (int face = 0; face <= D; ++face)
        if (!held[face] && mesh.face_neighbours[e][face].is_facet())
            found.push_back(mesh.face_neighbours[e][face].facet());
}

/// Without a branch at each, so that several are compared at once.
bool is_among(const std::vector<ElementId>& ids, ElementId id) {
    bool found = false;
    for (const ElementId i : ids) found |= i == id;
    return found;
}

/// What is looked at soon: elements around a vertex are scattered in memory.
template <int D>
void fetch_ahead(const DynamicMesh<D>& mesh, ElementId e) {
    __builtin_prefetch(&mesh.elements.vertices[e]);
    __builtin_prefetch(&mesh.face_neighbours[e]);
}

}  // namespace

template <int D>
void ball(const DynamicMesh<D>& mesh, VertexId v, std::vector<ElementId>& found) {
    found.clear();
    if (!mesh.element_of[v].valid()) return;
    constexpr std::size_t usual = D == 3 ? 32 : 8;
    found.reserve(usual);
    found.push_back(mesh.element_of[v]);
    for (std::size_t k = 0; k < found.size(); ++k) {
        const ElementId e = found[k];
        const auto& vertices = mesh.elements.vertices[e];
        for (int face = 0; face <= D; ++face) {
            if (vertices[face] == v) continue;
            const ElementId next = element_across(mesh, e, face);
            if (!next.valid() || is_among(found, next)) continue;
            fetch_ahead(mesh, next);
            found.push_back(next);
        }
    }
}

template <int D>
void shell(const DynamicMesh<D>& mesh, ElementId e, int local_edge, std::vector<ElementId>& found) {
    found.assign(1, e);
    const auto [i, j] = local_edges<D>[local_edge];
    const VertexId a = mesh.elements.vertices[e][i];
    const VertexId b = mesh.elements.vertices[e][j];
    // In 2D the edge is a face: one element across. In 3D each element has two faces at the edge.
    if constexpr (D == 2) {
        const ElementId next = element_across(mesh, e, 3 - i - j);
        if (next.valid()) found.push_back(next);
    } else {
        const auto walk = [&](VertexId across) {
            // From e through the face opposite `across`, on and on.
            ElementId at = e;
            for (;;) {
                const ElementId next = element_across(mesh, at, local_vertex(mesh.elements.vertices[at], across));
                if (!next.valid()) return false;
                if (next == e) return true;
                // What the two share with a and b is what the next face is opposite of.
                const auto& from = mesh.elements.vertices[at];
                for (const VertexId v : from)
                    if (v != a && v != b && v != across) {
                        across = v;
                        break;
                    }
                found.push_back(next);
                at = next;
            }
        };
        std::array<VertexId, 2> others{};
        int n = 0;
        for (const VertexId v : mesh.elements.vertices[e])
            if (v != a && v != b) others[n++] = v;
        if (!walk(others[0])) walk(others[1]);
    }
}

template <int D>
void facets_with(const DynamicMesh<D>& mesh, const std::vector<ElementId>& elements, VertexId v,
                 std::vector<FacetId>& found) {
    found.clear();
    for (const ElementId e : elements) {
        std::array<bool, D + 1> held{};
        const int local = local_vertex(mesh.elements.vertices[e], v);
        if (local < 0) continue;
        held[local] = true;
        add_facets<D>(mesh, e, held, found);
    }
    rise(found);
}

template <int D>
void facets_with(const DynamicMesh<D>& mesh, const std::vector<ElementId>& elements, EdgeId edge,
                 std::vector<FacetId>& found) {
    found.clear();
    for (const ElementId e : elements)
        for (int k = 0; k < edges_per_simplex<D>; ++k) {
            if (mesh.edges_of[e][k] != edge) continue;
            std::array<bool, D + 1> held{};
            for (const int i : local_edges<D>[k]) held[i] = true;
            add_facets<D>(mesh, e, held, found);
        }
    rise(found);
}

template <int D>
void lines_with(const DynamicMesh<D>& mesh, const std::vector<ElementId>& elements, VertexId v,
                std::vector<LineId>& found) {
    found.clear();
    if (mesh.line_of.empty()) return;
    for (const ElementId e : elements) {
        const int local = local_vertex(mesh.elements.vertices[e], v);
        for (int other = 0; local >= 0 && other <= D; ++other) {
            if (other == local) continue;
            const LineId line = mesh.line_of[mesh.edges_of[e][edge_between<D>[local][other]]];
            if (line.valid()) found.push_back(line);
        }
    }
    rise(found);
}

EdgeId facet_edge(const DynamicMesh<3>& mesh, FacetId f, int k) {
    const ElementId e = mesh.sides[f][0];
    const auto& vertices = mesh.elements.vertices[e];
    const auto& facet = mesh.facets.vertices[f];
    const int a = local_vertex(vertices, facet[(k + 1) % 3]);
    const int b = local_vertex(vertices, facet[(k + 2) % 3]);
    return mesh.edges_of[e][edge_between<3>[a][b]];
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template void ball<D>(const DynamicMesh<D>&, VertexId, std::vector<ElementId>&);                                   \
    template void shell<D>(const DynamicMesh<D>&, ElementId, int, std::vector<ElementId>&);                            \
    template void facets_with<D>(const DynamicMesh<D>&, const std::vector<ElementId>&, VertexId,                       \
                                 std::vector<FacetId>&);                                                               \
    template void facets_with<D>(const DynamicMesh<D>&, const std::vector<ElementId>&, EdgeId, std::vector<FacetId>&); \
    template void lines_with<D>(const DynamicMesh<D>&, const std::vector<ElementId>&, VertexId, std::vector<LineId>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
