module;
#include <array>
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
import :assembly;

namespace camber::listing {

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

/// The rows of a field of the file's points by the mesh's nodes; an edge without a node in the file has the mean of its
/// ends (of whole numbers: that of its lower vertex).
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
    return DecodedMesh{.mesh = QuadraticMesh<D>{std::move(*mesh), std::move(*edges), std::move(*nodes)},
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
        .mesh = straight_mesh(std::move(mesh)), .notices = std::move(notices), .fields = std::move(fields)};
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<DecodedMesh> assembled<D>(Mesh<D>, MidNodeKind, std::vector<Notice>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::listing
