// Neighbourhoods of entities, cavities of operations, and the consistency check.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
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

template <int D>
void add_facets(const DynamicMesh<D>& mesh, ElementId e, const std::array<bool, D + 1>& contains_vertex,
                std::vector<FacetId>& found) {
    for (int face = 0; face <= D; ++face)
        if (!contains_vertex[face] && mesh.face_neighbours[e][face].is_facet())
            found.push_back(mesh.face_neighbours[e][face].facet());
}

bool is_among(const std::vector<ElementId>& ids, ElementId id) {
    bool found = false;
    for (const ElementId i : ids) found |= i == id;
    return found;
}

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
    // In 2D the edge is a face of the element, with one element across it. In 3D each element has two faces that
    // contain the edge.
    if constexpr (D == 2) {
        const ElementId next = element_across(mesh, e, 3 - i - j);
        if (next.valid()) found.push_back(next);
    } else {
        const auto walk = [&](VertexId across) {
            ElementId at = e;
            for (;;) {
                const ElementId next = element_across(mesh, at, local_vertex(mesh.elements.vertices[at], across));
                if (!next.valid()) return false;
                if (next == e) return true;
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
        std::array<bool, D + 1> contains_vertex{};
        const int local = local_vertex(mesh.elements.vertices[e], v);
        if (local < 0) continue;
        contains_vertex[local] = true;
        add_facets<D>(mesh, e, contains_vertex, found);
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
            std::array<bool, D + 1> contains_vertex{};
            for (const int i : local_edges<D>[k]) contains_vertex[i] = true;
            add_facets<D>(mesh, e, contains_vertex, found);
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

template <int D>
void cavity_of_edge(const DynamicMesh<D>& mesh, ElementId e, int k, Cavity<D>& out) {
    const EdgeId edge = mesh.edges_of[e][k];
    shell(mesh, e, k, out.elements);
    out.facets.clear();
    const auto is_inside = [&](VertexId v) { return mesh.states[v].place == VertexPlace::inside; };
    if (std::ranges::none_of(mesh.edges[edge], is_inside))  // an edge with an inner vertex has no facets
        facets_with(mesh, out.elements, edge, out.facets);
    out.lines.clear();
    if (const LineId line = mesh.line_at(edge); line.valid()) out.lines.push_back(line);
}

template <int D>
void cavity_of_vertex(const DynamicMesh<D>& mesh, VertexId v, Cavity<D>& out) {
    ball(mesh, v, out.elements);
    facets_with(mesh, out.elements, v, out.facets);
    lines_with(mesh, out.elements, v, out.lines);
}

template <int D>
void join(const DynamicMesh<D>& mesh, Cavity<D>& cavity, ElementId e) {
    cavity.elements.push_back(e);
    if constexpr (D == 3)
        if (mesh.is_surface()) cavity.facets.push_back(facet_of(mesh, e));
}

template <int D>
bool may_collapse(const DynamicMesh<D>& mesh, const Cavity<D>& around, VertexId v, VertexId w) {
    const VertexState& state = mesh.states[v];
    if (state.marks.has(Mark::required) || state.marks.has(Mark::frozen)) return false;
    switch (state.place) {
        case VertexPlace::inside: return true;
        case VertexPlace::surface:
            return std::ranges::any_of(around.facets,
                                       [&](FacetId f) { return local_vertex(mesh.facets.vertices[f], w) >= 0; });
        case VertexPlace::line:
            return std::ranges::any_of(around.lines, [&](LineId l) {
                const auto& ends = mesh.edges[mesh.lines[l]];
                return ends[0] == w || ends[1] == w;
            });
        case VertexPlace::corner:
        case VertexPlace::infinity: return false;
    }
    return false;
}

namespace {

auto wrong(std::string what, const char* kind, std::size_t number) {
    return fail(ErrorKind::internal, std::move(what), {}, Entity{kind, number + 1});
}

template <class Look>
Outcome<Done> none_wrong(std::size_t n, const char* kind, const Execution& execution, Look&& look) {
    const auto first = reduce_each(
        execution, n, n, [&](std::size_t& least, std::size_t i) { least = look(i) ? std::min(least, i) : least; },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (!first) return fail(first.error());
    if (*first == n) return Done{};
    return wrong(look(*first), kind, *first);
}

template <int D>
SimplexVertices<D - 1> sorted_face(const SimplexVertices<D>& v, int opposite) {
    SimplexVertices<D - 1> face;
    int n = 0;
    for (int i = 0; i <= D; ++i)
        if (i != opposite) face[n++] = v[i];
    std::sort(face.begin(), face.end());
    return face;
}

template <int D>
const char* wrong_across(const DynamicMesh<D>& mesh, ElementId e, int face) {
    const auto own = sorted_face<D>(mesh.elements.vertices[e], face);
    const FaceNeighbour across = mesh.face_neighbours[e][face];
    if (!across.valid()) return "a face has neither a neighbour nor a facet";
    if (across.is_facet()) {
        const FacetId f = across.facet();
        if (f.index() >= mesh.facets.size() || mesh.is_free(f)) return "the facet of a face does not exist";
        auto facet = mesh.facets.vertices[f];
        std::sort(facet.begin(), facet.end());
        if (facet != own) return "the facet of a face has other vertices";
        return mesh.sides[f][0] == e || mesh.sides[f][1] == e ? nullptr
                                                              : "the facet of a face does not refer to the "
                                                                "element";
    }
    const ElementId other = across.element();
    if (other.index() >= mesh.elements.size() || mesh.is_free(other)) return "the element across a face does not exist";
    for (int back = 0; back <= D; ++back)
        if (mesh.face_neighbours[other][back] == FaceNeighbour(e) &&
            sorted_face<D>(mesh.elements.vertices[other], back) == own)
            return mesh.elements.references[other] == mesh.elements.references[e]
                       ? nullptr
                       : "a face between two materials has no facet";
    return "the element across a face does not refer back to the element";
}

template <int D>
const char* wrong_element(const DynamicMesh<D>& mesh, ElementId e) {
    if (mesh.is_free(e)) return nullptr;
    const auto& v = mesh.elements.vertices[e];
    for (int i = 0; i <= D; ++i) {
        if (v[i].index() >= mesh.points.size() || mesh.is_free(v[i])) return "a vertex does not exist";
        if (local_vertex(v, v[i]) != i) return "a vertex occurs twice";
        if (const char* what = wrong_across(mesh, e, i)) return what;
    }
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        const EdgeId edge = mesh.edges_of[e][k];
        if (edge.index() >= mesh.edges.size() ||
            mesh.edges[edge] != std::array{std::min(v[i], v[j]), std::max(v[i], v[j])})
            return "an edge does not join its vertices";
    }
    return nullptr;
}

template <int D>
const char* wrong_facet(const DynamicMesh<D>& mesh, FacetId f) {
    if (mesh.is_free(f)) return nullptr;
    const auto& [first, second] = mesh.sides[f];
    if (!first.valid())
        return std::ranges::all_of(mesh.facets.vertices[f],
                                   [&](VertexId v) { return mesh.states[v].marks.has(Mark::frozen); })
                   ? nullptr
                   : "a facet without elements is not frozen";
    for (const ElementId side : {first, second}) {
        if (!side.valid()) continue;
        if (mesh.is_free(side) ||
            std::ranges::find(mesh.face_neighbours[side], FaceNeighbour(f)) == mesh.face_neighbours[side].end())
            return "an element of a facet does not refer to it";
    }
    return nullptr;
}

template <int D>
const char* wrong_vertex(const DynamicMesh<D>& mesh, VertexId v) {
    const ElementId e = mesh.element_of[v];
    if (!e.valid()) return nullptr;
    if (e.index() >= mesh.elements.size() || local_vertex(mesh.elements.vertices[e], v) < 0)
        return "the element of a vertex does not contain it";
    return nullptr;
}

template <int D>
const char* wrong_line(const DynamicMesh<D>& mesh, LineId l) {
    if (mesh.is_free(l)) return nullptr;
    const EdgeId edge = mesh.lines[l];
    return edge.index() < mesh.edges.size() && !mesh.is_free(edge) && mesh.line_of[edge] == l
               ? nullptr
               : "the edge of a line does not refer to it";
}

template <int D>
Outcome<Done> check_edges(const DynamicMesh<D>& mesh) {
    std::vector<std::uint8_t> used(mesh.edges.size(), 0);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        if (!mesh.is_free(ElementId(e)))
            for (const EdgeId edge : mesh.edges_of[e]) used[edge.index()] = 1;
    std::vector<std::array<VertexId, 2>> ends;
    ends.reserve(mesh.edges.size());
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        if (mesh.is_free(EdgeId(e))) {
            if (used[e] != 0) return wrong("a free edge is in use", "edge", e);
            continue;
        }
        const auto& [a, b] = mesh.edges[e];
        const bool contains_vertex = mesh.states[a].marks.has(Mark::frozen) && mesh.states[b].marks.has(Mark::frozen);
        if (used[e] == 0 && !contains_vertex) return wrong("an edge belongs to no element", "edge", e);
        if (const LineId l = mesh.line_at(EdgeId(e)); l.valid() && mesh.lines[l] != EdgeId(e))
            return wrong("the line of an edge belongs to another edge", "edge", e);
        ends.push_back({a, b});
    }
    std::sort(ends.begin(), ends.end());
    if (std::adjacent_find(ends.begin(), ends.end()) != ends.end())
        return fail(ErrorKind::internal, "two edges have the same ends");
    return Done{};
}

template <class Id, class IsFree>
Outcome<Done> check_free(const Column<std::uint32_t>& free, std::size_t places, const char* kind, IsFree&& is_free) {
    std::vector<std::uint8_t> listed(places, 0);
    for (const std::uint32_t i : free) {
        if (i >= places || listed[i] != 0 || !is_free(Id(std::size_t{i})))
            return wrong("its index is listed as free, but is in use", kind, i);
        listed[i] = 1;
    }
    for (std::size_t i = 0; i < places; ++i)
        if (listed[i] == 0 && is_free(Id(i))) return wrong("its index is free, but is not listed as free", kind, i);
    return Done{};
}

template <class Id, int D>
Outcome<Done> check_free(const DynamicMesh<D>& mesh, const Column<std::uint32_t>& free, std::size_t places,
                         const char* kind) {
    return check_free<Id>(free, places, kind, [&](Id id) { return mesh.is_free(id); });
}

}  // namespace

template <int D>
Outcome<Done> check_consistency(const DynamicMesh<D>& mesh, const Execution& execution) {
    return guarded([&]() -> Outcome<Done> {
        if (mesh.is_curved() && mesh.nodes.size() != mesh.edges.size())
            return fail(ErrorKind::internal, "there must be one node for each edge");
        return none_wrong(mesh.elements.size(), simplex_name<D>, execution,
                          [&](std::size_t e) { return wrong_element(mesh, ElementId(e)); })
            .and_then([&](Done) {
                return none_wrong(mesh.facets.size(), "facet", execution,
                                  [&](std::size_t f) { return wrong_facet(mesh, FacetId(f)); });
            })
            .and_then([&](Done) {
                return none_wrong(mesh.points.size(), "vertex", execution,
                                  [&](std::size_t v) { return wrong_vertex(mesh, VertexId(v)); });
            })
            .and_then([&](Done) {
                return none_wrong(mesh.lines.size(), "line", execution,
                                  [&](std::size_t l) { return wrong_line(mesh, LineId(l)); });
            })
            .and_then([&](Done) { return check_edges(mesh); })
            .and_then(
                [&](Done) { return check_free<VertexId>(mesh, mesh.free.vertices, mesh.points.size(), "vertex"); })
            .and_then([&](Done) { return check_free<EdgeId>(mesh, mesh.free.edges, mesh.edges.size(), "edge"); })
            .and_then([&](Done) { return check_free<LineId>(mesh, mesh.free.lines, mesh.lines.size(), "line"); })
            .and_then([&](Done) { return check_free<FacetId>(mesh, mesh.free.facets, mesh.facets.size(), "facet"); })
            .and_then([&](Done) {
                return check_free<ElementId>(mesh, mesh.free.elements, mesh.elements.size(), simplex_name<D>);
            });
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template void ball<D>(const DynamicMesh<D>&, VertexId, std::vector<ElementId>&);                                   \
    template void shell<D>(const DynamicMesh<D>&, ElementId, int, std::vector<ElementId>&);                            \
    template void facets_with<D>(const DynamicMesh<D>&, const std::vector<ElementId>&, VertexId,                       \
                                 std::vector<FacetId>&);                                                               \
    template void facets_with<D>(const DynamicMesh<D>&, const std::vector<ElementId>&, EdgeId, std::vector<FacetId>&); \
    template void lines_with<D>(const DynamicMesh<D>&, const std::vector<ElementId>&, VertexId, std::vector<LineId>&); \
    template void cavity_of_edge<D>(const DynamicMesh<D>&, ElementId, int, Cavity<D>&);                                \
    template void cavity_of_vertex<D>(const DynamicMesh<D>&, VertexId, Cavity<D>&);                                    \
    template void join<D>(const DynamicMesh<D>&, Cavity<D>&, ElementId);                                               \
    template bool may_collapse<D>(const DynamicMesh<D>&, const Cavity<D>&, VertexId, VertexId);                        \
    template Outcome<Done> check_consistency<D>(const DynamicMesh<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
