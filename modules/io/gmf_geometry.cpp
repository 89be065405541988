module;
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber::gmf {

namespace {

template <int D>
Outcome<Done> read_directions(const File& file, Keyword keyword, const Execution& execution, Column<Vec<D>>& directions,
                              std::atomic<bool>& wrong) {
    const Block* const block = file.find(keyword);
    if (!block) return Done{};
    if (auto fits = check_size(file, *block, 0, D); !fits) return fits;
    Buffer<Vec<D>> buffer(block->count);
    auto read = read_rows<VectorRow<D>>(file, *block, execution, [&](std::size_t i, const VectorRow<D>& row) {
        buffer[i] = Vec<D>{row.real};
        if (!is_finite(buffer[i])) wrong = true;
        return Fault{};
    });
    if (read) directions = std::move(buffer);
    return read;
}

Outcome<Done> read_pairs(const File& file, Keyword keyword, std::size_t vertices, std::size_t directions,
                         const Execution& execution, Column<DirectionRow>& pairs, std::atomic<bool>& wrong) {
    const Block* const block = file.find(keyword);
    if (!block) return Done{};
    if (auto fits = check_size(file, *block, 2, 0); !fits) return fits;
    Buffer<DirectionRow> buffer(block->count);
    auto read = read_rows<PairRow>(file, *block, execution, [&](std::size_t i, const PairRow& row) -> Fault {
        const std::array limits{vertices, directions};
        for (int c = 0; c < 2; ++c)
            if (from_file(row.integer[c]) >= limits[c]) wrong = true;
        buffer[i] = {VertexId(from_file(row.integer[0])), static_cast<std::uint32_t>(from_file(row.integer[1]))};
        return {};
    });
    if (read) pairs = std::move(buffer);
    return read;
}

/// Directions and who has them: two blocks. Mmg writes indices of normals in place of those of tangents: one index
/// without its direction spoils all.
template <int D>
Outcome<Done> read_at_vertices(const File& file, Keyword directions, Keyword pairs, std::size_t vertices,
                               const Execution& execution, DirectionsAtVertices<D>& given,
                               std::vector<Notice>& notices) {
    std::atomic<bool> wrong = false;
    return read_directions<D>(file, directions, execution, given.table, wrong)
        .and_then(
            [&](Done) { return read_pairs(file, pairs, vertices, given.table.size(), execution, given.at, wrong); })
        .map([&](Done done) {
            if (!wrong) return done;
            notices.push_back({std::to_string(given.at.size()) + " rows of " + std::string(name_of(pairs)) +
                               " were left out: not all of them have a vertex and a direction of the file"});
            given = {};
            return done;
        });
}

/// Vertices on entities of dimension G: vertex, entity, and but for points the G parameters and the distance.
template <int G>
Outcome<Done> read_associations(const File& file, std::size_t vertices, const Execution& execution,
                                Column<Association<G>>& items) {
    const Block* const block = file.find(association_keyword<G>);
    if (!block) return Done{};
    if (auto fits = check_size(file, *block, 2, AssociationRow<G>::reals); !fits) return fits;
    Buffer<Association<G>> buffer(block->count);
    auto read = read_rows<AssociationRow<G>>(
        file, *block, execution, [&](std::size_t i, const AssociationRow<G>& row) -> Fault {
            if (from_file(row.integer[0]) >= vertices) return {FaultKind::index, row.integer[0], vertices};
            if (!is_reference(row.integer[1])) return {FaultKind::too_large, row.integer[1]};
            for (const double value : row.real)
                if (!std::isfinite(value)) return {FaultKind::not_finite};
            buffer[i] = {VertexId(from_file(row.integer[0])), static_cast<Reference>(row.integer[1])};
            if constexpr (G > 0) {
                std::copy_n(row.real.begin(), G, buffer[i].parameters.emplace().begin());
                buffer[i].distance = row.real[G];
            }
            return {};
        });
    if (read) items = std::move(buffer);
    return read;
}

}  // namespace

template <int D>
Outcome<GivenGeometry<D>> read_geometry(const File& file, std::size_t vertices, std::vector<Notice>& notices,
                                        const Execution& execution) {
    GivenGeometry<D> given;
    auto read = read_at_vertices<D>(file, Keyword::normals, Keyword::normal_at_vertices, vertices, execution,
                                    given.normals, notices)
                    .and_then([&](Done) {
                        return read_at_vertices<D>(file, Keyword::tangents, Keyword::tangent_at_vertices, vertices,
                                                   execution, given.tangents, notices);
                    })
                    .and_then([&](Done) { return read_associations<0>(file, vertices, execution, given.on_points); })
                    .and_then([&](Done) { return read_associations<1>(file, vertices, execution, given.on_curves); })
                    .and_then([&](Done) { return read_associations<2>(file, vertices, execution, given.on_surfaces); });
    if (!read) return fail(std::move(read.error()));
    return given;
}

#define CAMBER_INSTANTIATE(D)                                                                           \
    template Outcome<GivenGeometry<D>> read_geometry<D>(const File&, std::size_t, std::vector<Notice>&, \
                                                        const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::gmf
