module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.io:gmf_blocks;
import camber.core;
import camber.bezier;
import :gmf_keywords;
import :listing;
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
[[nodiscard]] Outcome<Done> put_directions(Sink& sink, Keyword vectors_keyword, Keyword pairs_keyword,
                                           const DirectionsAtVertices<D>& given) {
    const auto& [table, at] = given;
    return sink
        .template rows<VectorRow<D>>(vectors_keyword, table.size(),
                                     [&](std::size_t i) { return VectorRow<D>{{}, table[i].c}; })
        .and_then([&](Done) {
            return sink.template rows<PairRow>(pairs_keyword, at.size(), [&](std::size_t i) {
                return PairRow{{to_file(at[i].vertex.value), to_file(at[i].row)}, {}};
            });
        });
}

/// GMF has no word for parameters that are not known: those associations are left out (`not_in_gmf` counts them).
template <int G>
[[nodiscard]] bool is_in_gmf(const Association<G>& on) {
    return G == 0 || on.parameters.has_value();
}

template <int G, class Sink>
[[nodiscard]] Outcome<Done> put_associations(Sink& sink, const Column<Association<G>>& all) {
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (is_in_gmf(all[i])) chosen.push_back(i);
    return sink.template rows<AssociationRow<G>>(association_keyword<G>, chosen.size(), [&](std::size_t i) {
        const Association<G>& on = all[chosen[i]];
        AssociationRow<G> row{{to_file(on.item.value), on.entity}, {}};
        if constexpr (G > 0) {
            std::copy_n(on.parameters->begin(), G, row.real.begin());
            row.real[G] = on.distance.value_or(0);
        }
        return row;
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
            return put_directions(sink, Keyword::normals, Keyword::normal_at_vertices, mesh.geometry.normals);
        })
        .and_then([&](Done) {
            return put_directions(sink, Keyword::tangents, Keyword::tangent_at_vertices, mesh.geometry.tangents);
        })
        .and_then([&](Done) { return put_associations(sink, mesh.geometry.on_points); })
        .and_then([&](Done) { return put_associations(sink, mesh.geometry.on_curves); })
        .and_then([&](Done) { return put_associations(sink, mesh.geometry.on_surfaces); });
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
        return VertexRow<D>{{listing::mid_node_reference(references[a], references[b])},
                            mesh.mid_nodes[i - vertices].point.c};
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
