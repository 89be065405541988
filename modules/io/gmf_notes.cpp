module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
module camber.io;
import camber.core;

namespace camber::gmf {

namespace {

template <int D>
Outcome<Done> read_directions(const File& file, Keyword keyword, const Execution& execution,
                              Column<Vec<D>>& directions) {
    const Block* const block = file.find(keyword);
    if (!block) return Done{};
    if (auto fits = check_size(file, *block, 0, D); !fits) return fits;
    Buffer<Vec<D>> buffer(block->count);
    auto read = read_rows<DirectionRow<D>>(file, *block, execution, [&](std::size_t i, const DirectionRow<D>& row) {
        buffer[i] = Vec<D>{row.real};
        return Fault{is_finite(buffer[i]) ? FaultKind::none : FaultKind::not_finite};
    });
    if (read) directions = std::move(buffer);
    return read;
}

Outcome<Done> read_pairs(const File& file, Keyword keyword, std::size_t vertices, std::size_t directions,
                         const Execution& execution, Column<DirectionAtVertex>& pairs) {
    const Block* const block = file.find(keyword);
    if (!block) return Done{};
    if (auto fits = check_size(file, *block, 2, 0); !fits) return fits;
    Buffer<DirectionAtVertex> buffer(block->count);
    auto read = read_rows<PairRow>(file, *block, execution, [&](std::size_t i, const PairRow& row) -> Fault {
        const std::array limits{vertices, directions};
        for (int c = 0; c < 2; ++c)
            if (from_file(row.integer[c]) >= limits[c]) return {FaultKind::index, row.integer[c], limits[c]};
        buffer[i] = {VertexId(from_file(row.integer[0])), static_cast<std::uint32_t>(from_file(row.integer[1]))};
        return {};
    });
    if (read) pairs = std::move(buffer);
    return read;
}

/// Vertices on CAD entities, with their parameters there.
template <class Item, int Reals>
Outcome<Done> read_on_geometry(const File& file, Keyword keyword, std::size_t vertices, const Execution& execution,
                               Column<Item>& items) {
    using GeometryRow = Row<2, Reals>;
    const Block* const block = file.find(keyword);
    if (!block) return Done{};
    if (auto fits = check_size(file, *block, 2, Reals); !fits) return fits;
    Buffer<Item> buffer(block->count);
    auto read = read_rows<GeometryRow>(file, *block, execution, [&](std::size_t i, const GeometryRow& row) -> Fault {
        if (from_file(row.integer[0]) >= vertices) return {FaultKind::index, row.integer[0], vertices};
        if (!is_reference(row.integer[1])) return {FaultKind::too_large, row.integer[1]};
        for (const double value : row.real)
            if (!std::isfinite(value)) return {FaultKind::not_finite};
        const VertexId vertex(from_file(row.integer[0]));
        const auto entity = static_cast<Reference>(row.integer[1]);
        if constexpr (Reals == 0)
            buffer[i] = {vertex, entity};
        else if constexpr (Reals == 2)
            buffer[i] = {vertex, entity, row.real[0], row.real[1]};
        else
            buffer[i] = {vertex, entity, row.real[0], row.real[1], row.real[2]};
        return {};
    });
    if (read) items = std::move(buffer);
    return read;
}

}  // namespace

template <int D>
Outcome<Done> read_notes(const File& file, std::size_t vertices, const Execution& execution, GeometryNotes<D>& notes) {
    const std::size_t n = vertices;
    return read_directions<D>(file, Keyword::normals, execution, notes.normals)
        .and_then([&](Done) { return read_directions<D>(file, Keyword::tangents, execution, notes.tangents); })
        .and_then([&](Done) {
            return read_pairs(file, Keyword::normal_at_vertices, n, notes.normals.size(), execution,
                              notes.normal_at_vertices);
        })
        .and_then([&](Done) {
            return read_pairs(file, Keyword::tangent_at_vertices, n, notes.tangents.size(), execution,
                              notes.tangent_at_vertices);
        })
        .and_then([&](Done) {
            return read_on_geometry<OnGeometricVertex, 0>(file, Keyword::vertices_on_geometric_vertices, n, execution,
                                                          notes.on_vertices);
        })
        .and_then([&](Done) {
            return read_on_geometry<OnGeometricEdge, 2>(file, Keyword::vertices_on_geometric_edges, n, execution,
                                                        notes.on_edges);
        })
        .and_then([&](Done) {
            return read_on_geometry<OnGeometricTriangle, 3>(file, Keyword::vertices_on_geometric_triangles, n,
                                                            execution, notes.on_triangles);
        });
}

template Outcome<Done> read_notes<2>(const File&, std::size_t, const Execution&, GeometryNotes<2>&);
template Outcome<Done> read_notes<3>(const File&, std::size_t, const Execution&, GeometryNotes<3>&);

}  // namespace camber::gmf
