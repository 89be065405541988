// Builds meshes of degree 1 or 2 from the contents of files (listing::Mesh).
module;
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber::listing {

namespace {

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
                "the file is damaged, or was joined from two files");
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

template <class Item, class VertexOf>
Column<Item> renumbered(const Buffer<Item>& items, const Renumbering& numbers, std::size_t& dropped,
                        VertexOf&& vertex_of) {
    Buffer<Item> selected;
    for (Item item : items) {
        VertexId& vertex = vertex_of(item);
        vertex = VertexId(std::size_t{numbers.to_mesh[vertex.index()]});
        if (vertex.valid())
            selected.push_back(item);
        else
            ++dropped;
    }
    return selected;
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
                           " entries of corners, required vertices, normals, tangents or geometry associations refer "
                           "to mid nodes and were left out"});
    return mesh;
}

#define CAMBER_INSTANTIATE(D)                                                                      \
    template Outcome<Renumbering> without_mid_nodes<D>(const Mesh<D>&, const Execution&);          \
    template Outcome<LinearMesh<D>> corner_mesh<D>(Mesh<D>&, const Renumbering&, const Execution&, \
                                                   std::vector<Notice>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

namespace {

template <int D>
Outcome<Buffer<LagrangeNode<D>>> nodes_on_edges(const Mesh<D>& raw, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                const MidNodes& mid, MidNodeKind kind, const Execution& execution) {
    return map_each(
        execution, edges.size(),
        [&](std::size_t e) -> LagrangeNode<D> {
            const auto& [a, b] = edges.vertices[e];
            const Vec<D>&p = mesh.points[a], &q = mesh.points[b];
            if (mid.of_edge[e] == none) return {midpoint(p, q)};
            const Vec<D>& node = raw.points[mid.of_edge[e]];
            return kind == MidNodeKind::control_point ? lagrange_node(p, ControlPoint<D>{node}, q)
                                                      : LagrangeNode<D>{node};
        },
        row_grain);
}

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
        notices.push_back({std::to_string(straight) + " edges have no mid node in the file and are straight"});
    if (references > 0) notices.push_back({"references of " + std::to_string(references) + " mid nodes were left out"});
}

template <int D>
Column<std::uint32_t> node_numbers(const Mesh<D>& raw, const Renumbering& numbers, const MidNodes& mid) {
    const std::size_t vertices = numbers.to_file.size();
    Buffer<std::uint32_t> of(vertices + mid.of_edge.size());
    bool plain = true;
    for (std::size_t i = 0; i < of.size(); ++i) {
        const std::uint32_t at = i < vertices ? numbers.to_file[i] : mid.of_edge[i - vertices];
        const std::uint64_t number = at == none ? 0 : raw.number_of(VertexId(std::size_t{at}));
        of[i] = number < none ? static_cast<std::uint32_t>(number) : none;
        plain = plain && of[i] == i + 1;
    }
    return plain ? Column<std::uint32_t>() : Column<std::uint32_t>(std::move(of));
}

/// Reorders a point field to the mesh's nodes. If the file has no node on an edge, the edge node gets the mean of the
/// values at the edge's ends. In an integer field it gets the value at the first end.
template <class T>
Column<T> at_nodes(const Column<T>& rows, std::size_t width, const Renumbering& numbers, const MidNodes& mid,
                   const Column<std::array<VertexId, 2>>& edges) {
    const std::size_t vertices = numbers.to_file.size();
    Buffer<T> out((vertices + edges.size()) * width);
    for (std::size_t n = 0; n < vertices + edges.size(); ++n) {
        const std::uint32_t at = n < vertices ? numbers.to_file[n] : mid.of_edge[n - vertices];
        for (std::size_t c = 0; c < width; ++c) {
            if (at != none) {
                out[n * width + c] = rows[at * width + c];
                continue;
            }
            const auto end = [&](int i) { return rows[numbers.to_file[edges[n - vertices][i].index()] * width + c]; };
            if constexpr (std::is_floating_point_v<T>)
                out[n * width + c] = 0.5 * (end(0) + end(1));
            else
                out[n * width + c] = end(0);
        }
    }
    return out;
}

template <int D>
MeshFields fields_at_nodes(const Mesh<D>& raw, const Renumbering& numbers, const MidNodes& mid,
                           const EdgeSet<D>& edges) {
    std::vector<MeshField> fields;
    for (const MeshField& field : raw.fields) {
        MeshField moved = field;
        const auto width = static_cast<std::size_t>(values_per_vertex(field.kind, D));
        if (field.centring == Centring::node)
            moved.values = std::visit(
                [&](const auto& rows) -> FieldValues { return at_nodes(rows, width, numbers, mid, edges.vertices); },
                field.values);
        fields.push_back(std::move(moved));
    }
    return MeshFields(std::move(fields));
}

template <int D>
LinearMesh<D> straight_mesh(Mesh<D> raw) {
    const auto simplices = []<int K>(Simplices<K>& kind) -> camber::Simplices<K> {
        return {std::move(kind.straight.nodes), std::move(kind.straight.references), std::move(kind.required),
                std::move(kind.straight.entities)};
    };
    return {std::move(raw.points),   std::move(raw.point_references),
            std::move(raw.corners),  std::move(raw.required_vertices),
            simplices(raw.elements), simplices(raw.facets),
            simplices(raw.edges),    std::move(raw.ridges),
            std::move(raw.geometry), std::move(raw.groups)};
}

template <int D>
Outcome<DecodedMesh> quadratic_mesh(Mesh<D> raw, MidNodeKind kind, std::vector<Notice> notices,
                                    const Execution& execution) {
    const Execution quiet = without_progress(execution);
    const auto numbers = without_mid_nodes(raw, quiet);
    if (!numbers) return fail(numbers.error());
    auto mesh = corner_mesh(raw, *numbers, quiet, notices);
    if (!mesh) return fail(std::move(mesh.error()));
    auto edges = unique_edges(*mesh, part_of(execution, 0.2, 0.6));
    if (!edges) return fail(std::move(edges.error()));
    const auto mid = mid_nodes_of(raw, *edges, *numbers, quiet);
    if (!mid) return fail(mid.error());
    auto nodes = nodes_on_edges(raw, *mesh, *edges, *mid, kind, part_of(execution, 0.8, 1));
    if (!nodes) return fail(std::move(nodes.error()));
    note_mid_nodes(raw.point_references, *mesh, *edges, *mid, notices);
    MeshFields fields = fields_at_nodes(raw, *numbers, *mid, *edges);
    Column<std::uint32_t> file_numbers = node_numbers(raw, *numbers, *mid);
    return DecodedMesh{.mesh = as_mesh(QuadraticMesh<D>{std::move(*mesh), std::move(*edges), std::move(*nodes)}),
                       .notices = std::move(notices),
                       .node_numbers = std::move(file_numbers),
                       .fields = std::move(fields)};
}

}  // namespace

template <int D>
Outcome<DecodedMesh> assembled(Mesh<D> mesh, MidNodeKind kind, std::vector<Notice> notices,
                               const Execution& execution) {
    if (mesh.quadratic()) return quadratic_mesh(std::move(mesh), kind, std::move(notices), execution);
    MeshFields fields = std::move(mesh.fields);
    return DecodedMesh{
        .mesh = as_mesh(straight_mesh(std::move(mesh))), .notices = std::move(notices), .fields = std::move(fields)};
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<DecodedMesh> assembled<D>(Mesh<D>, MidNodeKind, std::vector<Notice>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::listing
