module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
export module camber.io:gmf_blocks;
import camber.core;
import camber.bezier;
import :gmf_keywords;
import :gmf_raw;
import :gmf_row;

namespace camber::gmf {

using camber::guarded;

[[nodiscard]] constexpr std::int64_t to_file(std::size_t index) { return static_cast<std::int64_t>(index) + 1; }

/// The blocks of a mesh's file in their order: a sink has value(keyword, integer) and
/// rows<RowType>(keyword, number, row number → RowType), each an Outcome<Done>. Ends at the first failure.
template <class Sink>
[[nodiscard]] Outcome<Done> put_indices(Sink& sink, Keyword keyword, const auto& items) {
    return sink.template rows<IndexRow>(keyword, items.size(), [&](std::size_t i) -> IndexRow {
        if constexpr (requires { items[i].value; })
            return {{to_file(items[i].value)}, {}};
        else
            return {{to_file(items[i])}, {}};
    });
}

template <int D, class Sink>
[[nodiscard]] Outcome<Done> put_directions(Sink& sink, Keyword vectors_keyword, const Column<Vec<D>>& vectors,
                                           Keyword pairs_keyword, const Column<DirectionAtVertex>& pairs) {
    return sink
        .template rows<DirectionRow<D>>(vectors_keyword, vectors.size(),
                                        [&](std::size_t i) { return DirectionRow<D>{{}, vectors[i].c}; })
        .and_then([&](Done) {
            return sink.template rows<PairRow>(pairs_keyword, pairs.size(), [&](std::size_t i) {
                return PairRow{{to_file(pairs[i].vertex.value), to_file(pairs[i].direction)}, {}};
            });
        });
}

template <int D, class Sink>
[[nodiscard]] Outcome<Done> put_places(Sink& sink, const GeometryNotes<D>& notes) {
    return sink
        .template rows<Row<2, 0>>(Keyword::vertices_on_geometric_vertices, notes.on_vertices.size(),
                                  [&](std::size_t i) {
                                      const OnGeometricVertex& on = notes.on_vertices[i];
                                      return Row<2, 0>{{to_file(on.vertex.value), on.entity}, {}};
                                  })
        .and_then([&](Done) {
            return sink.template rows<Row<2, 2>>(
                Keyword::vertices_on_geometric_edges, notes.on_edges.size(), [&](std::size_t i) {
                    const OnGeometricEdge& on = notes.on_edges[i];
                    return Row<2, 2>{{to_file(on.vertex.value), on.entity}, {on.t, on.distance}};
                });
        })
        .and_then([&](Done) {
            return sink.template rows<Row<2, 3>>(
                Keyword::vertices_on_geometric_triangles, notes.on_triangles.size(), [&](std::size_t i) {
                    const OnGeometricTriangle& on = notes.on_triangles[i];
                    return Row<2, 3>{{to_file(on.vertex.value), on.entity}, {on.u, on.v, on.distance}};
                });
        });
}

/// What both degrees have after the simplices.
template <int D, class Sink>
[[nodiscard]] Outcome<Done> put_features(Sink& sink, const LinearMesh<D>& mesh) {
    return put_indices(sink, Keyword::corners, mesh.corners)
        .and_then([&](Done) { return put_indices(sink, Keyword::required_vertices, mesh.required_vertices); })
        .and_then([&](Done) { return put_indices(sink, Keyword::ridges, mesh.ridges); })
        .and_then([&](Done) { return put_indices(sink, required_keyword<D>, mesh.elements.required); })
        .and_then([&](Done) { return put_indices(sink, required_keyword<D - 1>, mesh.facets.required); })
        .and_then([&](Done) -> Outcome<Done> {
            if constexpr (D == 3) return put_indices(sink, required_keyword<1>, mesh.edges.required);
            return Done{};
        })
        .and_then([&](Done) {
            return put_directions<D>(sink, Keyword::normals, mesh.notes.normals, Keyword::normal_at_vertices,
                                     mesh.notes.normal_at_vertices);
        })
        .and_then([&](Done) {
            return put_directions<D>(sink, Keyword::tangents, mesh.notes.tangents, Keyword::tangent_at_vertices,
                                     mesh.notes.tangent_at_vertices);
        })
        .and_then([&](Done) { return put_places<D>(sink, mesh.notes); });
}

template <int D, class Sink>
[[nodiscard]] Outcome<Done> put_mesh(Sink& sink, const LinearMesh<D>& mesh) {
    const auto simplices = [&]<int K>(const Simplices<K>& kind) {
        return sink.template rows<SimplexRow<K + 1>>(straight_keyword<K>, kind.size(), [&](std::size_t i) {
            SimplexRow<K + 1> row;
            for (int n = 0; n <= K; ++n) row.integer[n] = to_file(kind.vertices[i][n].value);
            row.integer[K + 1] = kind.references[i];
            return row;
        });
    };
    return sink.value(Keyword::dimension, D)
        .and_then([&](Done) {
            return sink.template rows<VertexRow<D>>(Keyword::vertices, mesh.points.size(), [&](std::size_t i) {
                return VertexRow<D>{{mesh.point_references[i]}, mesh.points[i].c};
            });
        })
        .and_then([&](Done) { return simplices(mesh.elements); })
        .and_then([&](Done) { return simplices(mesh.facets); })
        .and_then([&](Done) -> Outcome<Done> {
            if constexpr (D == 3) return simplices(mesh.edges);
            return Done{};
        })
        .and_then([&](Done) { return put_features(sink, mesh); });
}

template <int D, class Sink>
[[nodiscard]] Outcome<Done> put_mesh(Sink& sink, const QuadraticMesh<D>& mesh) {
    const std::size_t vertices = mesh.linear.points.size();
    const auto node = [&](std::size_t i) {
        if (i < vertices) return VertexRow<D>{{mesh.linear.point_references[i]}, mesh.linear.points[i].c};
        const auto& [a, b] = mesh.edges.vertices[i - vertices];
        const auto& references = mesh.linear.point_references;
        return VertexRow<D>{{mid_node_reference(references[a], references[b])}, mesh.mid_nodes[i - vertices].point.c};
    };
    const auto simplices = [&]<int K>(const Simplices<K>& kind, const auto& edges_of) {
        constexpr int nodes = quadratic_nodes<K>;
        return sink.template rows<SimplexRow<nodes>>(curved_keyword<K>, kind.size(), [&](std::size_t i) {
            SimplexRow<nodes> row;
            for (int n = 0; n <= K; ++n) row.integer[n] = to_file(kind.vertices[i][n].value);
            for (int e = 0; e < edges_per_simplex<K>; ++e) {
                if constexpr (requires { edges_of[i].value; })
                    row.integer[K + 1 + e] = to_file(vertices + edges_of[i].value);
                else
                    row.integer[K + 1 + e] = to_file(vertices + edges_of[i][e].value);
            }
            row.integer[nodes] = kind.references[i];
            return row;
        });
    };
    return sink.value(Keyword::dimension, D)
        .and_then([&](Done) {
            return sink.template rows<VertexRow<D>>(Keyword::vertices, vertices + mesh.mid_nodes.size(), node);
        })
        .and_then([&](Done) { return simplices(mesh.linear.elements, mesh.edges.of_elements); })
        .and_then([&](Done) { return simplices(mesh.linear.facets, mesh.edges.of_facets); })
        .and_then([&](Done) -> Outcome<Done> {
            if constexpr (D == 3) return simplices(mesh.linear.edges, mesh.edges.of_edges);
            return Done{};
        })
        .and_then([&](Done) { return put_features(sink, mesh.linear); });
}

}  // namespace camber::gmf
