module;
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
module camber.io;
import camber.core;
import camber.bezier;
import :gmf_order;
import :gmf_parts;
import :gmf_runs;

namespace camber {

namespace gmf {

namespace {

constexpr const char* straighten = "read it as a whole, or convert it: camber convert IN.mesh OUT.meshb --straighten";
constexpr const char* rewrite = "read it as a whole, or convert it: camber convert IN.mesh -o OUT.meshb";

std::size_t count_of(const File& file, Keyword keyword) {
    const Block* const block = file.find(keyword);
    return block ? block->count : 0;
}

/// Counts fit their blocks, so that any run of rows is there, and no others are of the other degree. Errors: see
/// check_size; unsupported.
template <int K, int Degree>
Outcome<Done> check_simplices(const File& file) {
    if (const Block* const others = file.find(simplex_keyword<K, 3 - Degree>); others && others->count > 0)
        return fail(ErrorKind::unsupported,
                    Degree == 1 ? "elements of degree 2 are not read by runs"
                                : std::string(others->info->name) + " beside those of degree 2 are not read by runs",
                    place(file, others->start), {}, Degree == 1 ? straighten : rewrite);
    const Block* const block = file.find(simplex_keyword<K, Degree>);
    if (!block) return Done{};
    if (auto fits = check_size(file, *block, nodes_of_degree<K, Degree> + 1, 0); !fits) return fits;
    if constexpr (Degree == 2)
        if (auto order = read_order<K>(file); !order) return fail(order.error());
    return Done{};
}

template <int D, int Degree>
Outcome<Done> check_blocks(const File& file) {
    if (file.encoding == GmfEncoding::ascii)
        return fail(ErrorKind::unsupported, "text is not read by runs", file.name, {}, rewrite);
    if (*file.dimension != D)
        return fail(ErrorKind::unsupported, "the mesh is not one of dimension " + std::to_string(D), file.name);
    for (const Block& block : file.blocks)
        if (block.info->content == Content::foreign_elements)
            return fail(ErrorKind::unsupported, std::string(block.info->name) + " are no simplices",
                        place(file, block.start), {}, "convert it: camber convert");
    const Block* const points = file.find(Keyword::vertices);
    if (!points) return fail_at(file, 0, "the file has no Vertices", "give a mesh");
    if (Degree == 2 && file.bezier_basis == 1)
        return fail(ErrorKind::unsupported, "nodes that are control points are not read by runs", file.name, {},
                    rewrite);
    return check_size(file, *points, 1, D)
        .and_then([&](Done) { return check_simplices<D, Degree>(file); })
        .and_then([&](Done) { return check_simplices<D - 1, Degree>(file); })
        .and_then([&](Done) { return D == 3 ? check_simplices<1, Degree>(file) : Outcome<Done>(Done{}); });
}

/// store(row of the run, row) → Fault for each of `size` rows from `begin` on, by one thread: others read other runs.
template <class RowType, class Store>
Outcome<Done> read_run(const File& file, Keyword keyword, std::size_t begin, std::size_t size, Store&& store) {
    const Block* const block = file.find(keyword);
    if (size == 0) return Done{};
    if (!block || begin + size > block->count)
        return fail(ErrorKind::internal, "a run of rows ends behind the rows of " + std::string(name_of(keyword)));
    Block run = *block;
    run.body = row_begin(file, *block, begin, RowType::integers, RowType::reals);
    run.count = size;
    auto read = read_binary_rows<RowType>(file, run, {.threads = 1}, store);
    if (!read && read.error().entity) {
        Error error = std::move(read.error());
        error.entity->number += begin;
        return fail(std::move(error));
    }
    return read;
}

}  // namespace

}  // namespace gmf

template <int D, int Degree>
GmfCounts GmfRuns<D, Degree>::counts() const {
    using gmf::count_of, gmf::simplex_keyword;
    return {count_of(*file_, gmf::Keyword::vertices), count_of(*file_, simplex_keyword<D, Degree>),
            count_of(*file_, simplex_keyword<D - 1, Degree>),
            D == 3 ? count_of(*file_, simplex_keyword<1, Degree>) : 0};
}

template <int D, int Degree>
Outcome<Done> GmfRuns<D, Degree>::points(std::size_t begin, std::span<Vec<D>> points,
                                         std::span<Reference> references) const {
    return gmf::read_run<gmf::VertexRow<D>>(*file_, gmf::Keyword::vertices, begin, points.size(),
                                            [&](std::size_t i, const gmf::VertexRow<D>& row) {
                                                return gmf::store_point<D>(row, points[i], references[i]);
                                            });
}

template <int D, int Degree>
template <int K>
Outcome<Done> GmfRuns<D, Degree>::simplices(std::size_t begin, std::span<Nodes<K>> nodes,
                                            std::span<Reference> references) const {
    constexpr int count = nodes_of_degree<K, Degree>;
    const std::size_t points = counts().points;
    const auto store = [&](std::size_t i, const gmf::SimplexRow<count>& row) -> gmf::Fault {
        // Of the whole file such edges are left out, which changes the numbers of those behind.
        if (K == 1 && row.integer[0] == row.integer[1]) return {gmf::FaultKind::repeated, row.integer[0]};
        return gmf::store_simplex<count>(row, points, nodes[i], references[i]);
    };
    auto read =
        gmf::read_run<gmf::SimplexRow<count>>(*file_, gmf::simplex_keyword<K, Degree>, begin, nodes.size(), store);
    if constexpr (Degree == 2) {
        if (!read) return read;
        const auto order = gmf::read_order<K>(*file_);
        if (!order) return fail(order.error());
        if (!*order) return read;
        for (Nodes<K>& simplex : nodes) {
            const Nodes<K> in_file = simplex;
            for (std::size_t n = 0; n < in_file.size(); ++n) simplex[(**order)[n]] = in_file[n];
        }
    }
    return read;
}

template <int D, int Degree>
Outcome<LinearMesh<D>> GmfRuns<D, Degree>::lists() const {
    return guarded([&] { return gmf::read_lists<D, Degree>(*file_); });
}

Outcome<GmfShape> gmf_shape(std::span<const std::byte> bytes, std::string_view name) {
    return guarded([&]() -> Outcome<GmfShape> {
        const auto file = gmf::open_file(bytes, name, {});
        if (!file) return fail(file.error());
        const std::size_t curved = gmf::count_of(*file, gmf::curved_keyword<1>) +
                                   gmf::count_of(*file, gmf::curved_keyword<2>) +
                                   gmf::count_of(*file, gmf::curved_keyword<3>);
        return GmfShape{static_cast<int>(*file->dimension), curved > 0 ? 2 : 1};
    });
}

template <int D, int Degree>
Outcome<GmfRuns<D, Degree>> gmf_runs(std::span<const std::byte> bytes, std::string_view name) {
    return guarded([&]() -> Outcome<GmfRuns<D, Degree>> {
        auto file = gmf::open_file(bytes, name, {});
        if (!file) return fail(std::move(file.error()));
        if (auto fits = gmf::check_blocks<D, Degree>(*file); !fits) return fail(std::move(fits.error()));
        return GmfRuns<D, Degree>(std::make_shared<const gmf::File>(std::move(*file)));
    });
}

#define CAMBER_INSTANTIATE_SIMPLICES(D, DEGREE, K)                                                                \
    template Outcome<Done> GmfRuns<D, DEGREE>::simplices<K>(std::size_t, std::span<GmfRuns<D, DEGREE>::Nodes<K>>, \
                                                            std::span<Reference>) const;
#define CAMBER_INSTANTIATE(D, DEGREE)                \
    template class GmfRuns<D, DEGREE>;               \
    CAMBER_INSTANTIATE_SIMPLICES(D, DEGREE, D)       \
    CAMBER_INSTANTIATE_SIMPLICES(D, DEGREE, (D - 1)) \
    template Outcome<GmfRuns<D, DEGREE>> gmf_runs<D, DEGREE>(std::span<const std::byte>, std::string_view);

CAMBER_INSTANTIATE(2, 1)
CAMBER_INSTANTIATE(3, 1)
CAMBER_INSTANTIATE(2, 2)
CAMBER_INSTANTIATE(3, 2)
CAMBER_INSTANTIATE_SIMPLICES(3, 1, 1)
CAMBER_INSTANTIATE_SIMPLICES(3, 2, 1)
#undef CAMBER_INSTANTIATE
#undef CAMBER_INSTANTIATE_SIMPLICES

}  // namespace camber
