module;
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber::gmf {

namespace {

constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t row_grain = 4096;

/// What elements make of a vertex of the file.
constexpr std::uint8_t is_corner = 1, is_mid_node = 2;

template <class T>
void atomic_min(T& target, T value) {
    const std::atomic_ref<T> shared(target);
    T seen = shared.load(std::memory_order_relaxed);
    while (value < seen && !shared.compare_exchange_weak(seen, value, std::memory_order_relaxed)) {
    }
}

/// f(simplices of one dimension) for each dimension that the mesh has, until one fails.
template <int D, class F>
Outcome<Done> for_each_kind(const RawMesh<D>& raw, F&& f) {
    auto done = f(raw.elements);
    if (done) done = f(raw.facets);
    if constexpr (D == 3)
        if (done) done = f(raw.edges);
    return done;
}

template <int D>
Outcome<Buffer<std::uint8_t>> roles(const RawMesh<D>& raw, const Execution& execution) {
    Buffer<std::uint8_t> role(raw.points.size());
    for (std::uint8_t& r : role) r = 0;
    const auto mark = [&](VertexId v, std::uint8_t bit) {
        const std::atomic_ref shared(role[v.index()]);
        if ((shared.load(std::memory_order_relaxed) & bit) == 0) shared.fetch_or(bit, std::memory_order_relaxed);
    };
    auto marked = for_each_kind(raw, [&]<int K>(const RawSimplices<K>& kind) {
        return each(
                   execution, kind.straight.size(),
                   [&](std::size_t i) {
                       for (const VertexId v : kind.straight[i]) mark(v, is_corner);
                   },
                   row_grain)
            .and_then([&](Done) {
                return each(
                    execution, kind.curved.size(),
                    [&](std::size_t i) {
                        for (int n = 0; n < quadratic_nodes<K>; ++n)
                            mark(kind.curved[i][n], n <= K ? is_corner : is_mid_node);
                    },
                    row_grain);
            });
    });
    if (!marked) return fail(std::move(marked.error()));
    return role;
}

/// A simplex of the file, for messages.
struct Simplex {
    const Block* block = nullptr;
    std::size_t row = 0;
    int integers = 0;
    [[nodiscard]] std::string text() const {
        return block ? std::string(block->info->noun) + " " + std::to_string(row + 1) : "another simplex";
    }
    [[nodiscard]] std::string where(const File& file) const {
        return place(file, block ? row_begin(file, *block, row, integers, 0) : 0);
    }
};

/// The first simplex, but for `skip`, for which `accepts(simplex's vertices, its nodes or fewer)` holds.
template <int D, class Accepts>
Simplex find_simplex(const RawMesh<D>& raw, Accepts&& accepts) {
    Simplex found;
    const auto look = [&]<int K>(const RawSimplices<K>& kind) -> Outcome<Done> {
        for (std::size_t i = 0; i < kind.curved.size() && !found.block; ++i)
            if (accepts.template operator()<K>(kind.curved[i])) found = {kind.curved_block, i, quadratic_nodes<K> + 1};
        for (std::size_t i = 0; i < kind.straight.size() && !found.block; ++i)
            if (accepts.template operator()<K>(kind.straight[i])) found = {kind.straight_block, i, K + 2};
        return Done{};
    };
    static_cast<void>(for_each_kind(raw, look));
    return found;
}

template <int D>
auto both_roles(const RawMesh<D>& raw, const File& file, VertexId vertex) {
    const Simplex as_mid = find_simplex(raw, [&]<int K>(const auto& nodes) {
        for (std::size_t n = K + 1; n < nodes.size(); ++n)
            if (nodes[n] == vertex) return true;
        return false;
    });
    const Simplex as_corner = find_simplex(raw, [&]<int K>(const auto& nodes) {
        for (std::size_t n = 0; n <= K; ++n)
            if (nodes[n] == vertex) return true;
        return false;
    });
    return fail(ErrorKind::input, "is a mid node of " + as_mid.text() + " and a corner of " + as_corner.text(),
                as_mid.where(file), Entity{"vertex", vertex.index() + 1});
}

/// Vertices in the file's order without the mid nodes.
struct Renumbering {
    Buffer<std::uint32_t> to_mesh;  ///< of each vertex of the file; none: a mid node
    Buffer<std::uint32_t> to_file;  ///< of each vertex of the mesh
};

Renumbering renumber(const Buffer<std::uint8_t>& role) {
    Renumbering numbers{Buffer<std::uint32_t>(role.size()), {}};
    std::uint32_t next = 0;
    for (std::size_t v = 0; v < role.size(); ++v) numbers.to_mesh[v] = (role[v] & is_mid_node) != 0 ? none : next++;
    numbers.to_file.resize(next);
    for (std::size_t v = 0; v < role.size(); ++v)
        if (numbers.to_mesh[v] != none) numbers.to_file[numbers.to_mesh[v]] = static_cast<std::uint32_t>(v);
    return numbers;
}

/// Those of degree 2 first, as indices of required simplices and ridges have it.
template <int K>
Outcome<Simplices<K>> corners_of(const RawSimplices<K>& kind, const Renumbering& numbers, const Execution& execution) {
    const std::size_t curved = kind.curved.size();
    Buffer<Reference> references(curved + kind.straight.size());
    auto vertices = map_each(
        execution, references.size(),
        [&](std::size_t i) {
            references[i] = i < curved ? kind.curved_references[i] : kind.straight_references[i - curved];
            SimplexVertices<K> simplex;
            for (int n = 0; n <= K; ++n) {
                const VertexId v = i < curved ? kind.curved[i][n] : kind.straight[i - curved][n];
                simplex[n] = VertexId(std::size_t{numbers.to_mesh[v.index()]});
            }
            return simplex;
        },
        row_grain);
    if (!vertices) return fail(std::move(vertices.error()));
    return Simplices<K>{std::move(*vertices), std::move(references), kind.required};
}

/// Renumbers the vertices of a list; mid nodes fall out and are counted.
template <class Item, class VertexOf>
Column<Item> renumbered(const Buffer<Item>& items, const Renumbering& numbers, std::size_t& dropped,
                        VertexOf&& vertex_of) {
    Buffer<Item> kept;
    for (Item item : items) {
        VertexId& vertex = vertex_of(item);
        vertex = VertexId(std::size_t{numbers.to_mesh[vertex.index()]});
        if (vertex.valid())
            kept.push_back(item);
        else
            ++dropped;
    }
    return kept;
}

template <int D>
Outcome<LinearMesh<D>> corner_mesh(RawMesh<D>& raw, const Renumbering& numbers, const Execution& execution,
                                   std::vector<Notice>& notices) {
    const std::size_t n = numbers.to_file.size();
    Buffer<Reference> references(n);
    auto points = map_each(
        execution, n,
        [&](std::size_t v) {
            references[v] = raw.point_references[numbers.to_file[v]];
            return raw.points[numbers.to_file[v]];
        },
        row_grain);
    if (!points) return fail(std::move(points.error()));
    auto elements = corners_of(raw.elements, numbers, execution);
    if (!elements) return fail(std::move(elements.error()));
    auto facets = corners_of(raw.facets, numbers, execution);
    if (!facets) return fail(std::move(facets.error()));
    auto edges = corners_of(raw.edges, numbers, execution);
    if (!edges) return fail(std::move(edges.error()));

    std::size_t dropped = 0;
    const auto own = [](VertexId& v) -> VertexId& { return v; };
    const auto vertex = [](DirectionRow& at) -> VertexId& { return at.vertex; };
    const auto item = [](auto& on) -> VertexId& { return on.item; };
    const auto renumber_column = [&](auto& column, const auto& vertex_of) {
        column = renumbered(take(std::move(column)), numbers, dropped, vertex_of);
    };
    LinearMesh<D> mesh{std::move(*points),
                       std::move(references),
                       renumbered(raw.corners, numbers, dropped, own),
                       renumbered(raw.required_vertices, numbers, dropped, own),
                       std::move(*elements),
                       std::move(*facets),
                       std::move(*edges),
                       std::move(raw.ridges),
                       std::move(raw.geometry)};
    renumber_column(mesh.geometry.normals.at, vertex);
    renumber_column(mesh.geometry.tangents.at, vertex);
    renumber_column(mesh.geometry.on_points, item);
    renumber_column(mesh.geometry.on_curves, item);
    renumber_column(mesh.geometry.on_surfaces, item);
    if (dropped > 0)
        notices.push_back({std::to_string(dropped) +
                           " entries of corners, required vertices, normals, tangents or places on geometry are of mid "
                           "nodes and were left out"});
    return mesh;
}

/// The edge of the set on local edge k of simplex i.
template <int K, int D>
EdgeId edge_at(const EdgeSet<D>& edges, std::size_t i, int k) {
    if constexpr (K == D)
        return edges.of_elements[i][k];
    else if constexpr (K == D - 1)
        return edges.of_facets[i][k];
    else
        return edges.of_edges[i];
}

/// The mid node of each edge and the edge of each mid node: the lowest candidate, or none.
struct MidNodes {
    Buffer<std::uint32_t> of_edge;  ///< vertices of the file
    Buffer<std::uint32_t> edge_of;  ///< by vertices of the file
};

/// f(edge, mid node, simplex number) → Done for each local edge of each simplex of degree 2.
template <int K, int D, class F>
Outcome<Done> for_each_mid_node(const RawSimplices<K>& kind, const EdgeSet<D>& edges, const Execution& execution,
                                F&& f) {
    return each(
        execution, kind.curved.size(),
        [&](std::size_t i) {
            for (int k = 0; k < edges_per_simplex<K>; ++k) f(edge_at<K, D>(edges, i, k), kind.curved[i][K + 1 + k], i);
        },
        row_grain);
}

template <int D>
Outcome<MidNodes> lowest_mid_nodes(const RawMesh<D>& raw, const EdgeSet<D>& edges, const Execution& execution) {
    MidNodes mid{Buffer<std::uint32_t>(edges.size()), Buffer<std::uint32_t>(raw.points.size())};
    for (std::uint32_t& v : mid.of_edge) v = none;
    for (std::uint32_t& e : mid.edge_of) e = none;
    auto listed = for_each_kind(raw, [&]<int K>(const RawSimplices<K>& kind) {
        return for_each_mid_node<K, D>(kind, edges, execution, [&](EdgeId e, VertexId v, std::size_t) {
            atomic_min(mid.of_edge[e.index()], v.value);
            atomic_min(mid.edge_of[v.index()], e.value);
        });
    });
    if (!listed) return fail(std::move(listed.error()));
    return mid;
}

/// The error of the first simplex that disagrees with the lowest candidates.
template <int K, int D>
auto disagreement(const RawMesh<D>& raw, const RawSimplices<K>& kind, const EdgeSet<D>& edges, const MidNodes& mid,
                  const Renumbering& numbers, const File& file, std::size_t i) {
    const Simplex here{kind.curved_block, i, quadratic_nodes<K> + 1};
    const Entity entity{simplex_name<K>, i + 1};
    const auto number = [](std::size_t index) { return std::to_string(index + 1); };
    std::string text;
    for (int k = 0; k < edges_per_simplex<K> && text.empty(); ++k) {
        const EdgeId e = edge_at<K, D>(edges, i, k);
        const VertexId v = kind.curved[i][K + 1 + k];
        const VertexId first(std::size_t{mid.of_edge[e.index()]});
        const bool two_nodes = first != v;
        if (!two_nodes && mid.edge_of[v.index()] == e.value) continue;
        const EdgeId shown = two_nodes ? e : EdgeId(std::size_t{mid.edge_of[v.index()]});
        const VertexId other_node = two_nodes ? first : v;
        const Simplex other = find_simplex(raw, [&]<int L>(const auto& nodes) {
            for (std::size_t n = L + 1; n < nodes.size(); ++n) {
                const auto& [a, b] = local_edges<L>[n - L - 1];
                if (nodes[n] != other_node) continue;
                const std::uint32_t p = numbers.to_mesh[nodes[a].index()], q = numbers.to_mesh[nodes[b].index()];
                const auto& [low, high] = edges.vertices[shown];
                if ((p == low.value && q == high.value) || (q == low.value && p == high.value)) return true;
            }
            return false;
        });
        const auto& [low, high] = edges.vertices[e];
        const std::string edge = "the edge between vertices " + number(numbers.to_file[low.index()]) + " and " +
                                 number(numbers.to_file[high.index()]);
        text = two_nodes
                   ? edge + " has mid node " + number(v.index()) + " here and " + number(first.index()) + " in " +
                         other.text()
                   : "mid node " + number(v.index()) + " of " + edge + " is that of another edge in " + other.text();
    }
    return fail(ErrorKind::input, text, here.where(file), entity);
}

template <int D>
Outcome<Done> check_agreement(const RawMesh<D>& raw, const EdgeSet<D>& edges, const MidNodes& mid,
                              const Renumbering& numbers, const File& file, const Execution& execution) {
    return for_each_kind(raw, [&]<int K>(const RawSimplices<K>& kind) -> Outcome<Done> {
        FirstFault first;
        auto seen = for_each_mid_node<K, D>(kind, edges, execution, [&](EdgeId e, VertexId v, std::size_t i) {
            if (mid.of_edge[e.index()] != v.value || mid.edge_of[v.index()] != e.value) first.note(i);
        });
        if (!seen || !first.any()) return seen;
        return disagreement<K, D>(raw, kind, edges, mid, numbers, file, first.row());
    });
}

template <int D>
Outcome<Buffer<LagrangeNode<D>>> nodes_on_edges(const RawMesh<D>& raw, const LinearMesh<D>& mesh,
                                                const EdgeSet<D>& edges, const MidNodes& mid, bool bezier,
                                                const Execution& execution) {
    return map_each(
        execution, edges.size(),
        [&](std::size_t e) -> LagrangeNode<D> {
            const auto& [a, b] = edges.vertices[e];
            const Vec<D>&p = mesh.points[a], &q = mesh.points[b];
            if (mid.of_edge[e] == none) return {midpoint(p, q)};
            const Vec<D>& node = raw.points[mid.of_edge[e]];
            return bezier ? lagrange_node(p, ControlPoint<D>{node}, q) : LagrangeNode<D>{node};
        },
        row_grain);
}

/// What the mesh of degree 2 does not hold of the file, or had to add.
template <int D>
void note_mid_nodes(const Buffer<Reference>& point_references, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                    const MidNodes& mid, std::vector<Notice>& notices) {
    std::size_t straight = 0, references = 0;
    for (std::size_t e = 0; e < edges.size(); ++e) {
        const auto& [a, b] = edges.vertices[e];
        if (mid.of_edge[e] == none)
            ++straight;
        else if (point_references[mid.of_edge[e]] !=
                 mid_node_reference(mesh.point_references[a], mesh.point_references[b]))
            ++references;
    }
    if (straight > 0)
        notices.push_back({std::to_string(straight) + " edges have no mid node in the file and were made straight"});
    if (references > 0) notices.push_back({"references of " + std::to_string(references) + " mid nodes were not kept"});
}

/// See DecodedMesh::node_numbers.
Column<std::uint32_t> node_numbers(const Renumbering& numbers, const MidNodes& mid) {
    const std::size_t vertices = numbers.to_file.size();
    Buffer<std::uint32_t> of(vertices + mid.of_edge.size());
    bool plain = true;
    for (std::size_t i = 0; i < of.size(); ++i) {
        const std::uint32_t at = i < vertices ? numbers.to_file[i] : mid.of_edge[i - vertices];
        of[i] = at == none ? 0 : at + 1;
        plain = plain && of[i] == i + 1;
    }
    return plain ? Column<std::uint32_t>() : Column<std::uint32_t>(std::move(of));
}

}  // namespace

template <int D>
Outcome<DecodedMesh> quadratic_mesh(RawMesh<D> raw, const File& file, const Execution& execution,
                                    std::vector<Notice> notices) {
    const auto role = roles(raw, execution);
    if (!role) return fail(role.error());
    for (std::size_t v = 0; v < role->size(); ++v)
        if ((*role)[v] == (is_corner | is_mid_node)) return both_roles(raw, file, VertexId(v));
    const Renumbering numbers = renumber(*role);
    auto mesh = corner_mesh(raw, numbers, execution, notices);
    if (!mesh) return fail(std::move(mesh.error()));
    auto edges = unique_edges(*mesh, execution);
    if (!edges) return fail(std::move(edges.error()));
    const auto mid = lowest_mid_nodes(raw, *edges, execution);
    if (!mid) return fail(mid.error());
    auto agreed = check_agreement(raw, *edges, *mid, numbers, file, execution);
    if (!agreed) return fail(std::move(agreed.error()));
    auto nodes = nodes_on_edges(raw, *mesh, *edges, *mid, file.bezier_basis == 1, execution);
    if (!nodes) return fail(std::move(nodes.error()));
    note_mid_nodes(raw.point_references, *mesh, *edges, *mid, notices);
    return DecodedMesh{QuadraticMesh<D>{std::move(*mesh), std::move(*edges), std::move(*nodes)}, std::move(notices),
                       node_numbers(numbers, *mid)};
}

template Outcome<DecodedMesh> quadratic_mesh<2>(RawMesh<2>, const File&, const Execution&, std::vector<Notice>);
template Outcome<DecodedMesh> quadratic_mesh<3>(RawMesh<3>, const File&, const Execution&, std::vector<Notice>);

}  // namespace camber::gmf
