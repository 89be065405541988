module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <utility>
#include <vector>
module camber.io:gmf_write;
import camber.core;
import camber.bezier;
import :gmf;
import :gmf_file;
import :listing;
import :meshes;
import :writers;

namespace camber::gmf {

/// Returns the requested version, or `least` if none is requested. Errors: usage (the version is invalid, or lower than
/// `least`).
[[nodiscard]] Outcome<int> chosen_version(GmfOptions options, int least);

class BinarySizer {
  public:
    Outcome<Done> value(Keyword, std::int64_t) {
        narrow_ += 12;
        return Done{};
    }
    template <class RowType>
    Outcome<Done> rows(Keyword keyword, std::size_t n, const auto&) {
        if (n > 0 || keyword == Keyword::vertices) narrow_ += 12 + n * row_bytes(2, RowType::integers, RowType::reals);
        largest_ = std::max(largest_, n);
        words_ += n * RowType::words;
        return Done{};
    }
    void more(std::size_t bytes) { narrow_ += bytes; }
    [[nodiscard]] std::size_t words() const { return words_; }

    /// Lowest version that can hold the mesh, see GmfOptions::version. No index exceeds the largest count, so only
    /// counts are compared.
    [[nodiscard]] int min_version() const {
        constexpr std::size_t most = std::numeric_limits<std::int32_t>::max();
        if (largest_ > most) return 4;
        return narrow_ > most ? 3 : 2;
    }

  private:
    std::size_t narrow_ = 8 + 8;  // file size in version 2; it begins with 8 bytes for the header and 8 for the block
                                  // End
    std::size_t words_ = 0;
    std::size_t largest_ = 0;
};

template <class LayoutType, class RowType>
inline void store_row(const RowType& row, std::byte* to) {
    using Integer = typename LayoutType::Integer;
    constexpr bool reals_first = RowType::order == RowOrder::reals_first;
    std::byte* const integers = reals_first ? to + RowType::reals * sizeof(double) : to;
    std::byte* const reals = reals_first ? to : to + RowType::integers * sizeof(Integer);
    for (int i = 0; i < RowType::integers; ++i) {
        const Integer integer = static_cast<Integer>(row.integer[i]);
        std::memcpy(integers + i * sizeof(Integer), &integer, sizeof integer);
    }
    for (int i = 0; i < RowType::reals; ++i) std::memcpy(reals + i * sizeof(double), &row.real[i], sizeof(double));
}

template <class F>
auto with_written_layout(int version, F&& f) {
    if (version == 4) return f(Layout<double, std::int64_t, ByteOrder::native>{});
    return f(Layout<double, std::int32_t, ByteOrder::native>{});
}

template <class LayoutType>
class BinaryWriter {
  public:
    using Integer = typename LayoutType::Integer;

    BinaryWriter(int version, std::size_t words, const Execution& execution)
        : version_(version), words_(words), execution_(execution) {
        put_header({1, version});
    }

    Outcome<Done> value(Keyword keyword, std::int64_t value) {
        // Dimension has 4 bytes in every version.
        begin(keyword, 4);
        put(static_cast<std::int32_t>(value));
        return Done{};
    }

    template <class RowType>
    Outcome<Done> rows(Keyword keyword, std::size_t n, const auto& row) {
        if (n == 0 && keyword != Keyword::vertices) return Done{};
        constexpr std::size_t step = stride<RowType, LayoutType>;
        begin_rows(keyword, n, n * step);
        Buffer<std::byte> bytes(n * step);
        auto done = each_chunk(
            next_part(execution_, n * RowType::words, written_, words_), n,
            [&](std::size_t first, std::size_t last) {
                for (std::size_t i = first; i < last; ++i) store_row<LayoutType>(row(i), bytes.data() + i * step);
            },
            8192);
        position_ += bytes.size();
        chunks_.push_back(std::move(bytes));
        return done;
    }

    Outcome<Done> solution(std::size_t rows, std::span<const std::int32_t> header, std::span<const double> values) {
        begin(Keyword::sol_at_vertices, sizeof(Integer) + header.size_bytes() + values.size_bytes());
        put(static_cast<Integer>(rows));
        for (const std::int32_t word : header) put(word);
        Buffer<std::byte> bytes(values.size_bytes());
        auto done = each_chunk(
            execution_, values.size(),
            [&](std::size_t first, std::size_t last) {
                std::memcpy(bytes.data() + first * sizeof(double), values.data() + first,
                            (last - first) * sizeof(double));
            },
            65536);
        position_ += bytes.size();
        chunks_.push_back(std::move(bytes));
        return done;
    }

    [[nodiscard]] Chunks finish() && {
        end();
        return std::move(chunks_);
    }

  protected:
    void begin_rows(Keyword keyword, std::size_t n, std::size_t bytes) {
        begin(keyword, sizeof(Integer) + bytes);
        put(static_cast<Integer>(n));
    }
    void end() {
        put(static_cast<std::int32_t>(Keyword::end));
        put_position(0);
    }
    [[nodiscard]] std::size_t position() const { return position_; }
    void skip(std::size_t bytes) { position_ += bytes; }
    [[nodiscard]] Chunks take_chunks() { return std::exchange(chunks_, {}); }

  private:
    /// Writes a keyword and the position of the next block. `body`: number of bytes between them and the next block.
    void begin(Keyword keyword, std::size_t body) {
        put(static_cast<std::int32_t>(keyword));
        put_position(position_ + (version_ >= 3 ? 8 : 4) + body);
    }
    void put_position(std::size_t position) {
        if (version_ >= 3)
            put(static_cast<std::int64_t>(position));
        else
            put(static_cast<std::int32_t>(position));
    }
    void put_header(std::array<std::int32_t, 2> words) {
        for (const std::int32_t word : words) put(word);
    }
    template <class T>
    void put(T value) {
        Buffer<std::byte> bytes(sizeof value);
        std::memcpy(bytes.data(), &value, sizeof value);
        position_ += bytes.size();
        chunks_.push_back(std::move(bytes));
    }

    int version_;
    std::size_t words_, written_ = 0;
    const Execution& execution_;
    std::size_t position_ = 0;
    Chunks chunks_;
};

using camber::guarded;

[[nodiscard]] constexpr std::int64_t to_file(std::size_t index) { return static_cast<std::int64_t>(index) + 1; }

/// These functions write the blocks in order, up to the first failure. A sink has two functions that return
/// Outcome<Done>: value(keyword, integer) and rows<RowType>(keyword, n, row). row(i): row i of the block.
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
                                           const DirectionsAtVertices<D>& input) {
    const auto& [table, at] = input;
    return sink
        .template rows<VectorRow<D>>(vectors_keyword, table.size(),
                                     [&](std::size_t i) { return VectorRow<D>{{}, table[i].c}; })
        .and_then([&](Done) {
            return sink.template rows<PairRow>(pairs_keyword, at.size(), [&](std::size_t i) {
                return PairRow{{to_file(at[i].vertex.value), to_file(at[i].row)}, {}};
            });
        });
}

/// False for associations without parameters, which are not written.
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
