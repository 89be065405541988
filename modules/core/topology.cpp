module;
#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.core;

namespace camber {

namespace {

template <class Item, class Key, std::size_t N>
Outcome<Incidence<Item>> inverted(const Column<std::array<Key, N>>& rows, std::size_t keys,
                                  const Execution& execution) {
    if (rows.size() > max_entities / N)
        return fail(ErrorKind::unsupported, "a mesh of " + std::to_string(rows.size()) + " simplices is too large");
    Buffer<std::uint32_t> offsets(keys + 1);
    std::fill(offsets.begin(), offsets.end(), 0U);
    auto counted = each(part_of(execution, 0, 0.3), rows.size(), [&](std::size_t i) {
        for (const Key key : rows[i]) std::atomic_ref(offsets[key.index() + 1]).fetch_add(1, std::memory_order_relaxed);
    });
    if (!counted) return fail(counted.error());
    for (std::size_t k = 0; k < keys; ++k) offsets[k + 1] += offsets[k];
    Buffer<std::uint32_t> cursor(offsets.begin(), offsets.end());
    Buffer<Item> items(rows.size() * N);
    auto filled = each(part_of(execution, 0.3, 0.85), rows.size(), [&](std::size_t i) {
        for (const Key key : rows[i])
            items[std::atomic_ref(cursor[key.index()]).fetch_add(1, std::memory_order_relaxed)] = Item(i);
    });
    if (!filled) return fail(filled.error());
    auto sorted = each(part_of(execution, 0.85, 1), keys,
                       [&](std::size_t k) { std::sort(items.begin() + offsets[k], items.begin() + offsets[k + 1]); });
    if (!sorted) return fail(sorted.error());
    return Incidence<Item>{std::move(offsets), std::move(items)};
}

template <std::size_t N>
std::array<VertexId, N> sorted_vertices(std::array<VertexId, N> v) {
    std::sort(v.begin(), v.end());
    return v;
}

template <int D>
struct Around {
    Incidence<ElementId> elements;
    Incidence<FacetId> facets;
    Incidence<EdgeId> edges;
};

template <std::size_t N>
VertexId named_twice(const std::array<VertexId, N>& v) {
    for (std::size_t a = 0; a < N; ++a)
        for (std::size_t b = 0; b < a; ++b)
            if (v[a] == v[b]) return v[a];
    return {};
}

template <int K>
Outcome<Done> check_distinct(const Simplices<K>& simplices, const Execution& execution) {
    const std::size_t n = simplices.size();
    const auto first = reduce_each(
        execution, n, n,
        [&](std::size_t& found, std::size_t i) {
            if (found == n && named_twice(simplices.vertices[i]).valid()) found = i;
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (!first) return fail(first.error());
    if (*first == n) return Done{};
    return fail(ErrorKind::input,
                "names vertex " + std::to_string(named_twice(simplices.vertices[*first]).index() + 1) + " twice", {},
                Entity{simplex_name<K>, *first + 1}, "remove it");
}

/// Number of neighbours up to which linear duplicate search is fastest.
constexpr std::size_t few = 64;

template <std::size_t N>
void append_higher(const std::array<VertexId, N>& simplex, VertexId v, std::vector<VertexId>& higher) {
    for (const VertexId w : simplex)
        if (w > v && (higher.size() > few || std::find(higher.begin(), higher.end(), w) == higher.end()))
            higher.push_back(w);
}

template <int D>
void higher_neighbours(const LinearMesh<D>& mesh, const Around<D>& around, VertexId v, std::vector<VertexId>& higher) {
    higher.clear();
    for (const ElementId e : around.elements[v]) append_higher(mesh.elements.vertices[e], v, higher);
    for (const FacetId f : around.facets[v]) append_higher(mesh.facets.vertices[f], v, higher);
    for (const EdgeId f : around.edges[v]) append_higher(mesh.edges.vertices[f], v, higher);
    std::sort(higher.begin(), higher.end());
    higher.erase(std::unique(higher.begin(), higher.end()), higher.end());
}

template <int D>
using ElementEdges = Buffer<std::array<EdgeId, edges_per_simplex<D>>>;

template <int D>
void rank_edges(const LinearMesh<D>& mesh, const Around<D>& around, VertexId v, const std::vector<VertexId>& higher,
                ElementEdges<D>& ranks) {
    for (const ElementId e : around.elements[v]) {
        const auto& vertices = mesh.elements.vertices[e];
        for (int k = 0; k < edges_per_simplex<D>; ++k) {
            const auto [a, b] = local_edges<D>[k];
            const auto [low, high] = std::minmax(vertices[a], vertices[b]);
            if (low != v) continue;
            const auto it = std::lower_bound(higher.begin(), higher.end(), high);
            ranks[e.index()][k] = EdgeId(static_cast<std::size_t>(it - higher.begin()));
        }
    }
}

EdgeId find_in(const Buffer<std::uint32_t>& first, const Buffer<std::array<VertexId, 2>>& edges, VertexId a,
               VertexId b) {
    const auto [low, high] = std::minmax(a, b);
    const auto begin = edges.begin() + first[low.index()];
    const auto end = edges.begin() + first[low.index() + 1];
    const auto it = std::lower_bound(begin, end, high, [](const auto& e, VertexId v) { return e[1] < v; });
    return EdgeId(static_cast<std::size_t>(it - edges.begin()));
}

template <int K>
Outcome<Buffer<std::array<EdgeId, edges_per_simplex<K>>>> edges_of(const Simplices<K>& simplices,
                                                                   const Buffer<std::uint32_t>& first,
                                                                   const Buffer<std::array<VertexId, 2>>& edges,
                                                                   const Execution& execution) {
    return map_each(execution, simplices.size(), [&](std::size_t i) {
        std::array<EdgeId, edges_per_simplex<K>> of;
        for (int k = 0; k < edges_per_simplex<K>; ++k) {
            const auto [a, b] = local_edges<K>[k];
            of[k] = find_in(first, edges, simplices.vertices[i][a], simplices.vertices[i][b]);
        }
        return of;
    });
}

}  // namespace

template <int D>
Outcome<Incidence<ElementId>> balls(const LinearMesh<D>& mesh, const Execution& execution) {
    return guarded([&] { return inverted<ElementId>(mesh.elements.vertices, mesh.points.size(), execution); });
}

template <int D>
Outcome<Incidence<FacetId>> facet_balls(const LinearMesh<D>& mesh, const Execution& execution) {
    return guarded([&] { return inverted<FacetId>(mesh.facets.vertices, mesh.points.size(), execution); });
}

template <int D>
Outcome<Incidence<EdgeId>> feature_edge_balls(const LinearMesh<D>& mesh, const Execution& execution) {
    return inverted<EdgeId>(mesh.edges.vertices, mesh.points.size(), execution);
}

template <int D>
void faces_around(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls, VertexId v,
                  std::vector<FaceAround<D>>& faces) {
    faces.clear();
    for (const ElementId e : balls[v]) {
        const auto& corners = mesh.elements.vertices[e];
        // The face opposite a corner is collected for v if v occurs once among its vertices and all its other vertices
        // are higher than v.
        int own = 0, higher = 0;
        for (const VertexId corner : corners) {
            own += corner == v;
            higher += corner > v;
        }
        if (higher < D - 1) continue;
        for (int opposite = 0; opposite <= D; ++opposite) {
            const VertexId left_out = corners[opposite];
            if (own - (left_out == v) != 1 || higher - (left_out > v) != D - 1) continue;
            FaceAround<D> face{{}, {e, static_cast<std::uint32_t>(opposite)}};
            int n = 0;
            for (int i = 0; i <= D; ++i)
                if (i != opposite && corners[i] > v) face.others[n++] = corners[i];
            if constexpr (D == 3)
                if (face.others[1] < face.others[0]) std::swap(face.others[0], face.others[1]);
            faces.push_back(face);
        }
    }
    // The two other vertices are combined into one number, because comparing arrays would double the total time.
    const auto key = [](const FaceAround<D>& face) {
        if constexpr (D == 2)
            return face.others[0].value;
        else
            return std::uint64_t{face.others[0].value} << 32U | face.others[1].value;
    };
    std::sort(faces.begin(), faces.end(), [&](const FaceAround<D>& a, const FaceAround<D>& b) {
        const auto key_a = key(a), key_b = key(b);
        return key_a != key_b ? key_a < key_b : a.face.element < b.face.element;
    });
}

template <int D>
Outcome<Neighbours<D>> neighbours(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                  const Execution& execution) {
    return guarded([&]() -> Outcome<Neighbours<D>> {
        Buffer<std::array<ElementId, D + 1>> links(mesh.elements.size());
        auto done = each(without_progress(execution), links.size(), [&](std::size_t e) { links[e].fill(ElementId{}); });
        if (!done) return fail(done.error());
        std::atomic<std::uint32_t> crowded{std::numeric_limits<std::uint32_t>::max()};  // lowest element at a face with
                                                                                        // more than two elements
        done = each_face(mesh, balls, execution, [&](std::span<const FaceAround<D>> on) {
            if (on.size() == 1) return;
            const auto& [a, b] = std::pair(on[0].face, on[1].face);
            links[a.element.index()][a.opposite] = b.element;
            links[b.element.index()][b.opposite] = a.element;
            if (on.size() == 2) return;
            std::uint32_t lowest = crowded;
            while (a.element.value < lowest && !crowded.compare_exchange_weak(lowest, a.element.value)) {
            }
        });
        if (!done) return fail(done.error());
        if (crowded != std::numeric_limits<std::uint32_t>::max())
            return fail(ErrorKind::input, "shares a face with more than one other element", {},
                        Entity{simplex_name<D>, crowded + std::size_t{1}},
                        "elements must not overlap or be listed twice");
        return Neighbours<D>(std::move(links));
    });
}

template <int D>
Buffer<ElementFace> boundary_faces(const Neighbours<D>& neighbours) {
    Buffer<ElementFace> faces;
    for (std::size_t e = 0; e < neighbours.size(); ++e)
        for (int i = 0; i <= D; ++i)
            if (!neighbours[e][i].valid()) faces.push_back({ElementId(e), static_cast<std::uint32_t>(i)});
    return faces;
}

namespace {

template <int D>
Outcome<EdgeSet<D>> collect_edges(const LinearMesh<D>& mesh, const Execution& execution) {
    const Execution quiet = without_progress(execution);
    if (auto sound = check_distinct(mesh.elements, quiet); !sound) return fail(sound.error());
    if (auto sound = check_distinct(mesh.facets, quiet); !sound) return fail(sound.error());
    if (auto sound = check_distinct(mesh.edges, quiet); !sound) return fail(sound.error());
    auto elements = balls(mesh, part_of(execution, 0, 0.31));
    if (!elements) return fail(elements.error());
    auto facets = facet_balls(mesh, quiet);
    if (!facets) return fail(facets.error());
    auto features = feature_edge_balls(mesh, quiet);
    if (!features) return fail(features.error());
    const Around<D> around{std::move(*elements), std::move(*facets), std::move(*features)};

    // A single pass finds the higher neighbours of each vertex, by chunks, and numbers the edges of elements among
    // them.
    constexpr std::size_t grain = 4096;
    const std::size_t n = mesh.points.size();
    Buffer<std::uint32_t> first(n + 1);
    first[0] = 0;
    std::vector<std::vector<VertexId>> chunks((n + grain - 1) / grain);
    ElementEdges<D> of_elements(mesh.elements.size());
    auto found = each_chunk(
        part_of(execution, 0.31, 0.94), n,
        [&](std::size_t begin, std::size_t end) {
            std::vector<VertexId> higher;
            auto& all = chunks[begin / grain];
            for (std::size_t v = begin; v < end; ++v) {
                higher_neighbours(mesh, around, VertexId(v), higher);
                rank_edges(mesh, around, VertexId(v), higher, of_elements);
                first[v + 1] = static_cast<std::uint32_t>(higher.size());
                all.insert(all.end(), higher.begin(), higher.end());
            }
        },
        grain);
    if (!found) return fail(found.error());
    std::size_t total = 0;  // 64 bits, because elements without common edges have six edges each
    for (std::size_t v = 0; v < n; ++v) {
        total += first[v + 1];
        first[v + 1] += first[v];
    }
    if (total > max_entities)
        return fail(ErrorKind::unsupported, "a mesh of " + std::to_string(total) + " edges is too large");

    Buffer<std::array<VertexId, 2>> edges(first[n]);
    auto listed = each_chunk(
        part_of(execution, 0.94, 0.97), n,
        [&](std::size_t begin, std::size_t end) {
            auto other = chunks[begin / grain].begin();
            for (std::size_t v = begin; v < end; ++v)
                for (std::uint32_t i = first[v]; i < first[v + 1]; ++i) edges[i] = {VertexId(v), *other++};
        },
        grain);
    if (!listed) return fail(listed.error());
    chunks.clear();

    auto numbered = each(part_of(execution, 0.97, 1), mesh.elements.size(), [&](std::size_t e) {
        const auto& vertices = mesh.elements.vertices[e];
        for (int k = 0; k < edges_per_simplex<D>; ++k) {
            const auto [a, b] = local_edges<D>[k];
            of_elements[e][k].value += first[std::min(vertices[a], vertices[b]).index()];
        }
    });
    if (!numbered) return fail(numbered.error());
    auto of_facets = edges_of<D - 1>(mesh.facets, first, edges, quiet);
    if (!of_facets) return fail(of_facets.error());
    auto of_edges = map_each(quiet, mesh.edges.size(), [&](std::size_t i) {
        return find_in(first, edges, mesh.edges.vertices[i][0], mesh.edges.vertices[i][1]);
    });
    if (!of_edges) return fail(of_edges.error());
    return EdgeSet<D>{std::move(edges), std::move(of_elements), std::move(*of_facets), std::move(*of_edges)};
}

}  // namespace

template <int D>
Outcome<EdgeSet<D>> unique_edges(const LinearMesh<D>& mesh, const Execution& execution) {
    return guarded([&] { return collect_edges(mesh, execution); });
}

template <int D>
Outcome<Incidence<ElementId>> shells(const EdgeSet<D>& edges, const Execution& execution) {
    return guarded([&] { return inverted<ElementId>(edges.of_elements, edges.size(), execution); });
}

template <int D>
Outcome<Incidence<FacetId>> facet_shells(const EdgeSet<D>& edges, const Execution& execution) {
    return guarded([&] { return inverted<FacetId>(edges.of_facets, edges.size(), execution); });
}

template <int D>
EdgeId find_edge(const EdgeSet<D>& edges, VertexId a, VertexId b) {
    const std::array<VertexId, 2> key = sorted_vertices(std::array{a, b});
    const auto it = std::lower_bound(edges.vertices.begin(), edges.vertices.end(), key);
    if (it == edges.vertices.end() || *it != key) return {};
    return EdgeId(static_cast<std::size_t>(it - edges.vertices.begin()));
}

#define CAMBER_INSTANTIATE(D)                                                                          \
    template Outcome<Incidence<ElementId>> balls<D>(const LinearMesh<D>&, const Execution&);           \
    template Outcome<Incidence<FacetId>> facet_balls<D>(const LinearMesh<D>&, const Execution&);       \
    template Outcome<Incidence<EdgeId>> feature_edge_balls<D>(const LinearMesh<D>&, const Execution&); \
    template Outcome<Neighbours<D>> neighbours<D>(const LinearMesh<D>&, const Incidence<ElementId>&,   \
                                                  const Execution&);                                   \
    template void faces_around<D>(const LinearMesh<D>&, const Incidence<ElementId>&, VertexId,         \
                                  std::vector<FaceAround<D>>&);                                        \
    template Buffer<ElementFace> boundary_faces<D>(const Neighbours<D>&);                              \
    template Outcome<EdgeSet<D>> unique_edges<D>(const LinearMesh<D>&, const Execution&);              \
    template Outcome<Incidence<ElementId>> shells<D>(const EdgeSet<D>&, const Execution&);             \
    template Outcome<Incidence<FacetId>> facet_shells<D>(const EdgeSet<D>&, const Execution&);         \
    template EdgeId find_edge<D>(const EdgeSet<D>&, VertexId, VertexId);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
