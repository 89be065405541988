module;
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
module camber.io;
import camber.core;
import :gmf_runs;

namespace camber {

namespace gmf {

namespace {

constexpr const char* read_whole = "read it as a whole, or convert it: camber convert IN.mesh OUT.meshb --straighten";

std::size_t count_of(const File& file, Keyword keyword) {
    const Block* const block = file.find(keyword);
    return block ? block->count : 0;
}

/// Counts fit their blocks, so that any run of rows is there. Errors: see check_size.
template <int K>
Outcome<Done> check_simplices(const File& file) {
    if (const Block* const curved = file.find(curved_keyword<K>); curved && curved->count > 0)
        return fail(ErrorKind::unsupported, "elements of degree 2 are not read by runs", place(file, curved->start), {},
                    read_whole);
    const Block* const block = file.find(straight_keyword<K>);
    return block ? check_size(file, *block, K + 2, 0) : Outcome<Done>(Done{});
}

template <int D>
Outcome<Done> check_blocks(const File& file) {
    if (file.encoding == GmfEncoding::ascii)
        return fail(ErrorKind::unsupported, "text is not read by runs", file.name, {}, read_whole);
    if (*file.dimension != D)
        return fail(ErrorKind::unsupported, "the mesh is not one of dimension " + std::to_string(D), file.name);
    for (const Block& block : file.blocks)
        if (block.info->content == Content::foreign_elements)
            return fail(ErrorKind::unsupported, std::string(block.info->name) + " are no simplices",
                        place(file, block.start), {}, "convert it: camber convert");
    const Block* const points = file.find(Keyword::vertices);
    if (!points) return fail_at(file, 0, "the file has no Vertices", "give a mesh");
    return check_size(file, *points, 1, D)
        .and_then([&](Done) { return check_simplices<D>(file); })
        .and_then([&](Done) { return check_simplices<D - 1>(file); })
        .and_then([&](Done) { return D == 3 ? check_simplices<1>(file) : Outcome<Done>(Done{}); });
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

template <int D>
GmfCounts GmfRuns<D>::counts() const {
    using gmf::count_of, gmf::straight_keyword;
    return {count_of(*file_, gmf::Keyword::vertices), count_of(*file_, straight_keyword<D>),
            count_of(*file_, straight_keyword<D - 1>), D == 3 ? count_of(*file_, straight_keyword<1>) : 0};
}

template <int D>
Outcome<Done> GmfRuns<D>::points(std::size_t begin, std::span<Vec<D>> points, std::span<Reference> references) const {
    return gmf::read_run<gmf::VertexRow<D>>(*file_, gmf::Keyword::vertices, begin, points.size(),
                                            [&](std::size_t i, const gmf::VertexRow<D>& row) {
                                                return gmf::store_point<D>(row, points[i], references[i]);
                                            });
}

template <int D>
template <int K>
Outcome<Done> GmfRuns<D>::simplices(std::size_t begin, std::span<SimplexVertices<K>> vertices,
                                    std::span<Reference> references) const {
    const std::size_t points = counts().points;
    return gmf::read_run<gmf::SimplexRow<K + 1>>(*file_, gmf::straight_keyword<K>, begin, vertices.size(),
                                                 [&](std::size_t i, const gmf::SimplexRow<K + 1>& row) -> gmf::Fault {
                                                     // Of the whole file such edges are left out, which changes the
                                                     // numbers of those behind.
                                                     if (K == 1 && row.integer[0] == row.integer[1])
                                                         return {gmf::FaultKind::repeated, row.integer[0]};
                                                     return gmf::store_simplex<K + 1>(row, points, vertices[i],
                                                                                      references[i]);
                                                 });
}

template <int D>
Outcome<LinearMesh<D>> GmfRuns<D>::lists() const {
    return guarded([&] { return gmf::read_lists<D>(*file_); });
}

template <int D>
Outcome<GmfRuns<D>> gmf_runs(std::span<const std::byte> bytes, std::string_view name) {
    return guarded([&]() -> Outcome<GmfRuns<D>> {
        auto file = gmf::open_file(bytes, name, {});
        if (!file) return fail(std::move(file.error()));
        if (auto fits = gmf::check_blocks<D>(*file); !fits) return fail(std::move(fits.error()));
        return GmfRuns<D>(std::make_shared<const gmf::File>(std::move(*file)));
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template class GmfRuns<D>;                                                                                        \
    template Outcome<Done> GmfRuns<D>::simplices<D>(std::size_t, std::span<SimplexVertices<D>>, std::span<Reference>) \
        const;                                                                                                        \
    template Outcome<Done> GmfRuns<D>::simplices<D - 1>(std::size_t, std::span<SimplexVertices<D - 1>>,               \
                                                        std::span<Reference>) const;                                  \
    template Outcome<GmfRuns<D>> gmf_runs<D>(std::span<const std::byte>, std::string_view);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
template Outcome<Done> GmfRuns<3>::simplices<1>(std::size_t, std::span<SimplexVertices<1>>, std::span<Reference>) const;
#undef CAMBER_INSTANTIATE

}  // namespace camber
