module;
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;
import :assembly;

/// Corners and mid nodes told apart, and the straight mesh on the corners.
namespace camber::listing {

namespace {

/// What elements make of a vertex of the file.
constexpr std::uint8_t is_corner = 1, is_mid_node = 2;

template <int D>
Outcome<Buffer<std::uint8_t>> roles(const Mesh<D>& raw, const Execution& execution) {
    Buffer<std::uint8_t> role(raw.points.size());
    for (std::uint8_t& r : role) r = 0;
    const auto mark = [&](VertexId v, std::uint8_t bit) {
        const std::atomic_ref shared(role[v.index()]);
        if ((shared.load(std::memory_order_relaxed) & bit) == 0) shared.fetch_or(bit, std::memory_order_relaxed);
    };
    auto marked = for_each_dimension(raw, [&]<int K>(const Simplices<K>& kind) {
        return each(
                   execution, kind.straight.size(),
                   [&](std::size_t i) {
                       for (const VertexId v : kind.straight.nodes[i]) mark(v, is_corner);
                   },
                   row_grain)
            .and_then([&](Done) {
                return each(
                    execution, kind.curved.size(),
                    [&](std::size_t i) {
                        for (int n = 0; n < quadratic_nodes<K>; ++n)
                            mark(kind.curved.nodes[i][n], n <= K ? is_corner : is_mid_node);
                    },
                    row_grain);
            });
    });
    if (!marked) return fail(std::move(marked.error()));
    return role;
}

template <int D>
auto both_roles(const Mesh<D>& raw, VertexId vertex) {
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
                as_mid.where(raw.name), Entity{"vertex", raw.number_of(vertex)},
                "the file is damaged, or joined of two");
}

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
Outcome<camber::Simplices<K>> corners_of(const Simplices<K>& kind, const Renumbering& numbers,
                                         const Execution& execution) {
    const std::size_t curved = kind.curved.size(), all = curved + kind.straight.size();
    const bool known = kind.curved.entities.size() + kind.straight.entities.size() > 0;
    Buffer<Reference> references(all), entities(known ? all : 0);
    const auto from = [&](std::size_t i, const Buffer<Reference>& of_curved, const Buffer<Reference>& of_straight) {
        const Buffer<Reference>& column = i < curved ? of_curved : of_straight;
        return column.empty() ? 0 : column[i < curved ? i : i - curved];
    };
    auto vertices = map_each(
        execution, all,
        [&](std::size_t i) {
            references[i] = from(i, kind.curved.references, kind.straight.references);
            if (known) entities[i] = from(i, kind.curved.entities, kind.straight.entities);
            SimplexVertices<K> simplex;
            for (int n = 0; n <= K; ++n) {
                const VertexId v = i < curved ? kind.curved.nodes[i][n] : kind.straight.nodes[i - curved][n];
                simplex[n] = VertexId(std::size_t{numbers.to_mesh[v.index()]});
            }
            return simplex;
        },
        row_grain);
    if (!vertices) return fail(std::move(vertices.error()));
    return camber::Simplices<K>{std::move(*vertices), std::move(references), kind.required, std::move(entities)};
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

}  // namespace

template <int D>
Outcome<Renumbering> without_mid_nodes(const Mesh<D>& raw, const Execution& execution) {
    const auto role = roles(raw, execution);
    if (!role) return fail(role.error());
    for (std::size_t v = 0; v < role->size(); ++v)
        if ((*role)[v] == (is_corner | is_mid_node)) return both_roles(raw, VertexId(v));
    return renumber(*role);
}

template <int D>
Outcome<LinearMesh<D>> corner_mesh(Mesh<D>& raw, const Renumbering& numbers, const Execution& execution,
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
                       std::move(raw.geometry),
                       std::move(raw.groups)};
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

#define CAMBER_INSTANTIATE(D)                                                                      \
    template Outcome<Renumbering> without_mid_nodes<D>(const Mesh<D>&, const Execution&);          \
    template Outcome<LinearMesh<D>> corner_mesh<D>(Mesh<D>&, const Renumbering&, const Execution&, \
                                                   std::vector<Notice>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::listing
