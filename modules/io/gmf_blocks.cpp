// Reads and writes GMF blocks other than points and simplices: geometry, node orders, solutions.
module;
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

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
        return RowError{};
    });
    if (read) directions = std::move(buffer);
    return read;
}

template <int D>
Outcome<Done> read_pairs(const File& file, Keyword keyword, std::size_t vertices, const Execution& execution,
                         DirectionsAtVertices<D>& input, std::atomic<bool>& wrong) {
    const Block* const block = file.find(keyword);
    if (!block) return Done{};
    if (auto fits = check_size(file, *block, 2, 0); !fits) return fits;
    Buffer<DirectionRow> buffer(block->count);
    auto read = read_rows<PairRow>(file, *block, execution, [&](std::size_t i, const PairRow& row) -> RowError {
        const std::array limits{vertices, input.table.size()};
        for (int c = 0; c < 2; ++c)
            if (from_file(row.integer[c]) >= limits[c]) wrong = true;
        buffer[i] = {VertexId(from_file(row.integer[0])), static_cast<std::uint32_t>(from_file(row.integer[1]))};
        return {};
    });
    if (read) input.at = std::move(buffer);
    return read;
}

struct DirectionBlocks {
    Keyword directions, at_vertices;
};

/// Reads directions at vertices. If one is faulty, all are dropped: Mmg writes indices of normals in place of indices
/// of tangents.
template <int D>
Outcome<Done> read_at_vertices(const File& file, const DirectionBlocks& blocks, std::size_t vertices,
                               const Execution& execution, DirectionsAtVertices<D>& input,
                               std::vector<Notice>& notices) {
    std::atomic<bool> wrong = false;
    return read_directions<D>(file, blocks.directions, execution, input.table, wrong)
        .and_then([&](Done) { return read_pairs(file, blocks.at_vertices, vertices, execution, input, wrong); })
        .map([&](Done done) {
            if (!wrong) return done;
            notices.push_back({std::to_string(input.at.size()) + " rows of " +
                               std::string(name_of(blocks.at_vertices)) +
                               " were left out: not all of them refer to a vertex and a direction of the file"});
            input = {};
            return done;
        });
}

template <int G>
Outcome<Done> read_associations(const File& file, std::size_t vertices, const Execution& execution,
                                Column<Association<G>>& items) {
    const Block* const block = file.find(association_keyword<G>);
    if (!block) return Done{};
    if (auto fits = check_size(file, *block, 2, AssociationRow<G>::reals); !fits) return fits;
    Buffer<Association<G>> buffer(block->count);
    auto read = read_rows<AssociationRow<G>>(
        file, *block, execution, [&](std::size_t i, const AssociationRow<G>& row) -> RowError {
            if (from_file(row.integer[0]) >= vertices) return {RowErrorKind::index, row.integer[0], vertices};
            if (!is_reference(row.integer[1])) return {RowErrorKind::too_large, row.integer[1]};
            for (const double value : row.real)
                if (!std::isfinite(value)) return {RowErrorKind::not_finite};
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
Outcome<InputGeometry<D>> read_geometry(const File& file, std::size_t vertices, std::vector<Notice>& notices,
                                        const Execution& execution) {
    InputGeometry<D> input;
    auto read = read_at_vertices<D>(file, {Keyword::normals, Keyword::normal_at_vertices}, vertices, execution,
                                    input.normals, notices)
                    .and_then([&](Done) {
                        return read_at_vertices<D>(file, {Keyword::tangents, Keyword::tangent_at_vertices}, vertices,
                                                   execution, input.tangents, notices);
                    })
                    .and_then([&](Done) { return read_associations<0>(file, vertices, execution, input.on_points); })
                    .and_then([&](Done) { return read_associations<1>(file, vertices, execution, input.on_curves); })
                    .and_then([&](Done) { return read_associations<2>(file, vertices, execution, input.on_surfaces); });
    if (!read) return fail(std::move(read.error()));
    return input;
}

namespace {

/// Local number of the node with these exponents of barycentric coordinates; −1: no such node.
template <int K>
int node_of(const std::array<std::int64_t, K + 1>& exponents) {
    for (int v = 0; v <= K; ++v) {
        std::array<std::int64_t, K + 1> vertex{};
        vertex[v] = 2;
        if (exponents == vertex) return v;
    }
    for (int e = 0; e < edges_per_simplex<K>; ++e) {
        std::array<std::int64_t, K + 1> edge{};
        edge[local_edges<K>[e][0]] = edge[local_edges<K>[e][1]] = 1;
        if (exponents == edge) return K + 1 + e;
    }
    return -1;
}

template <int D>
Outcome<double> offsets(const Buffer<Vec<D>>& points, const Buffer<std::array<VertexId, 10>>& tetrahedra,
                        const listing::NodeOrder<3>& order, const Execution& execution) {
    return reduce_each(
        execution, tetrahedra.size(), 0.0,
        [&](double& sum, std::size_t i) {
            const auto point = [&](int n) { return points[tetrahedra[i][n].index()]; };
            for (int n = 4; n < 10; ++n) {
                const auto& [a, b] = local_edges<3>[order[n] - 4];
                sum += norm_squared(point(n) - midpoint(point(a), point(b)));
            }
        },
        [](double a, double b) { return a + b; });
}

}  // namespace

template <int K>
Outcome<std::optional<listing::NodeOrder<K>>> read_order(const File& file) {
    const Block* const block = file.find(ordering_keyword<K>);
    if (!block || block->count == 0) return std::optional<listing::NodeOrder<K>>{};
    // A row of EdgesP2Ordering has only one number, the exponent of vertex 0.
    constexpr int integers = K == 1 ? 1 : K + 1;
    listing::NodeOrder<K> order;
    order.fill(-1);
    std::array<bool, quadratic_nodes<K>> taken{};
    bool sound = block->count == order.size();
    if (sound) {
        const auto store = [&](std::size_t i, const Row<integers, 0>& row) -> RowError {
            std::array<std::int64_t, K + 1> exponents{};
            for (int v = 0; v < integers; ++v) exponents[v] = row.integer[v];
            if constexpr (K == 1) exponents[1] = std::int64_t{2} - (exponents[0] & 3);
            order[i] = node_of<K>(exponents);
            return {};
        };
        if (auto read = read_rows<Row<integers, 0>>(file, *block, Execution{.threads = 1}, store); !read)
            return fail(std::move(read.error()));
        for (const int node : order) {
            sound = sound && node >= 0 && !taken[node < 0 ? 0 : node];
            if (node >= 0) taken[node] = true;
        }
    }
    if (!sound)
        return fail_at(file, block->start,
                       std::string(block->info->name) + " does not list each of the " + std::to_string(order.size()) +
                           " nodes of its simplex once");
    return std::optional(order);
}

template <int D>
Outcome<listing::NodeOrder<3>> likely_order(const Buffer<Vec<D>>& points,
                                            const Buffer<std::array<VertexId, 10>>& tetrahedra,
                                            const Execution& execution) {
    constexpr listing::NodeOrder<3> plain{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}, gmsh{0, 1, 2, 3, 4, 5, 6, 7, 9, 8};
    const auto as_plain = offsets<D>(points, tetrahedra, plain, execution);
    const auto as_gmsh = offsets<D>(points, tetrahedra, gmsh, execution);
    if (!as_plain) return fail(as_plain.error());
    if (!as_gmsh) return fail(as_gmsh.error());
    return *as_gmsh < *as_plain ? gmsh : plain;
}

template Outcome<std::optional<listing::NodeOrder<1>>> read_order<1>(const File&);
template Outcome<std::optional<listing::NodeOrder<2>>> read_order<2>(const File&);
template Outcome<std::optional<listing::NodeOrder<3>>> read_order<3>(const File&);
template Outcome<listing::NodeOrder<3>> likely_order<2>(const Buffer<Vec<2>>&, const Buffer<std::array<VertexId, 10>>&,
                                                        const Execution&);
template Outcome<listing::NodeOrder<3>> likely_order<3>(const Buffer<Vec<3>>&, const Buffer<std::array<VertexId, 10>>&,
                                                        const Execution&);

}  // namespace camber::gmf

namespace camber {

namespace gmf {

namespace {

Outcome<Solution> read_solution(const File& file, const Block& block, const Execution& execution) {
    Solution solution{.dimension = static_cast<int>(*file.dimension), .single_precision = file.version == 1};
    for (const std::int32_t type : block.fields) {
        if (type < 1 || type > 4)
            return fail_at(file, block.start,
                           "a field of SolAtVertices has type " + std::to_string(type) + ", not 1 to 4");
        solution.fields.push_back(FieldKind{type});
    }
    const std::size_t width = row_width(solution);
    if (auto fits = check_size(file, block, 0, static_cast<int>(width)); !fits) return fail(std::move(fits.error()));
    // Rows of a solution may have any width, so each value is read as a row.
    Block single = block;
    single.count = block.count * width;
    single.rows_per_entity = width;
    Buffer<double> values(single.count);
    auto read = read_rows<ValueRow>(file, single, execution, [&](std::size_t i, const ValueRow& row) {
        values[i] = row.real[0];
        return RowError{std::isfinite(row.real[0]) ? RowErrorKind::none : RowErrorKind::not_finite};
    });
    if (!read) return fail(std::move(read.error()));
    solution.rows = block.count;
    solution.values = std::move(values);
    return solution;
}

template <class Sink>
Outcome<Chunks> written(Sink sink, const Solution& solution) {
    std::vector<std::int32_t> header{static_cast<std::int32_t>(solution.fields.size())};
    for (const FieldKind kind : solution.fields) header.push_back(static_cast<std::int32_t>(kind));
    auto done = sink.value(Keyword::dimension, solution.dimension).and_then([&](Done) {
        return sink.solution(solution.rows, header, solution.values.view());
    });
    if (!done) return fail(std::move(done.error()));
    return std::move(sink).finish();
}

Outcome<Chunks> encode(const Solution& solution, GmfOptions options, const Execution& execution) {
    BinarySizer sizer;
    sizer.more(24 + 4 * (solution.fields.size() + 1) + 8 * solution.values.size());
    const bool ascii = options.encoding == GmfEncoding::ascii;
    const auto version = chosen_version(options, ascii ? 2 : sizer.min_version());
    if (!version) return fail(version.error());
    const std::size_t words = solution.values.size();
    if (ascii) return written(AsciiWriter(*version, words, execution), solution);
    if (*version == 4)
        return written(BinaryWriter<Layout<double, std::int64_t, ByteOrder::native>>(4, words, execution), solution);
    return written(BinaryWriter<Layout<double, std::int32_t, ByteOrder::native>>(*version, words, execution), solution);
}

}  // namespace

}  // namespace gmf

Outcome<DecodedSolution> decode_gmf_solution(std::span<const std::byte> bytes, std::string_view name,
                                             const Execution& execution) {
    return guarded([&]() -> Outcome<DecodedSolution> {
        const double of_index = is_gmf_ascii(bytes) ? 0.3 : 0;
        const auto file = gmf::open_file(bytes, name, part_of(execution, 0, of_index));
        if (!file) return fail(file.error());
        const gmf::Block* const block = file->find(gmf::Keyword::sol_at_vertices);
        if (!block) return gmf::fail_at(*file, 0, "the file has no SolAtVertices", "give a solution (.sol, .solb)");
        auto solution = gmf::read_solution(*file, *block, part_of(execution, of_index, 1));
        if (!solution) return fail(std::move(solution.error()));
        return DecodedSolution{std::move(*solution), gmf::notices_of(*file)};
    });
}

Outcome<Chunks> encode_gmf_solution(const Solution& solution, GmfOptions options, const Execution& execution) {
    if (solution.dimension != 2 && solution.dimension != 3)
        return fail(ErrorKind::usage,
                    "the solution's dimension is " + std::to_string(solution.dimension) + ", not 2 or 3");
    if (solution.fields.empty()) return fail(ErrorKind::usage, "the solution has no fields");
    if (solution.values.size() != solution.rows * row_width(solution))
        return fail(ErrorKind::usage, "the number of values of the solution does not match its fields and rows");
    return guarded([&] { return gmf::encode(solution, options, execution); });
}

}  // namespace camber

namespace camber::gmf {

#define CAMBER_INSTANTIATE(D)                                                                           \
    template Outcome<InputGeometry<D>> read_geometry<D>(const File&, std::size_t, std::vector<Notice>&, \
                                                        const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::gmf
