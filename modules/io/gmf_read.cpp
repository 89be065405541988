// Reads meshes from GMF files.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
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
Outcome<Done> read_points(const File& file, const Execution& execution, listing::Mesh<D>& raw) {
    const Block* const block = file.find(Keyword::vertices);
    if (!block) {
        const bool solution = file.find(Keyword::sol_at_vertices) != nullptr;
        return fail_at(file, 0, solution ? "the file contains a solution, not a mesh" : "the file has no Vertices",
                       "give a mesh");
    }
    if (auto fits = check_size(file, *block, 1, D); !fits) return fits;
    raw.points.resize(block->count);
    raw.point_references.resize(block->count);
    return read_rows<VertexRow<D>>(file, *block, execution, [&](std::size_t i, const VertexRow<D>& row) -> RowError {
        return store_point<D>(row, raw.points[i], raw.point_references[i]);
    });
}

template <int N>
Outcome<Done> read_simplices(const File& file, const Block& block, std::size_t vertices, const Execution& execution,
                             listing::Rows<N>& rows) {
    if (auto fits = check_size(file, block, N + 1, 0); !fits) return fits;
    rows.origin = {std::string(block.info->noun), {}, [&file, &block](std::size_t row) {
                       return place(file, row_begin(file, block, row, N + 1, 0));
                   }};
    rows.nodes.resize(block.count);
    rows.references.resize(block.count);
    return read_rows<SimplexRow<N>>(file, block, execution, [&](std::size_t i, const SimplexRow<N>& row) -> RowError {
        return store_simplex<N>(row, vertices, rows.nodes[i], rows.references[i]);
    });
}

/// Reads indices of vertices or simplices. An index 0 is dropped with a notice.
template <class Item>
Outcome<Done> read_indices(const File& file, Keyword keyword, std::size_t limit, const Execution& execution,
                           Buffer<Item>& items, std::vector<Notice>& notices) {
    const Block* const block = file.find(keyword);
    if (!block) return Done{};
    if (auto fits = check_size(file, *block, 1, 0); !fits) return fits;
    Buffer<std::uint32_t> indices(block->count);
    auto read = read_rows<IndexRow>(file, *block, execution, [&](std::size_t i, const IndexRow& row) -> RowError {
        if (row.integer[0] != 0 && from_file(row.integer[0]) >= limit)
            return {RowErrorKind::index, row.integer[0], limit};
        indices[i] = static_cast<std::uint32_t>(row.integer[0]);
        return {};
    });
    if (!read) return read;
    items.reserve(indices.size());
    for (const std::uint32_t index : indices)
        if (index != 0) items.push_back(static_cast<Item>(from_file(index)));
    if (const std::size_t none = indices.size() - items.size(); none > 0)
        notices.push_back({std::to_string(none) + " rows of " + std::string(block->info->name) +
                           " have the index 0 and were left out"});
    return read;
}

template <int K, int D>
Outcome<Done> read_curved(const File& file, const Block& block, const Execution& execution, const listing::Mesh<D>& raw,
                          listing::Simplices<K>& kind) {
    auto read = read_simplices(file, block, raw.points.size(), execution, kind.curved);
    if (!read) return read;
    auto order = read_order<K>(file);
    if (!order) return fail(std::move(order.error()));
    const Execution quiet = without_progress(execution);
    if (*order) return listing::reorder<K>(kind.curved.nodes, **order, quiet);
    if constexpr (K == 3)
        if (block.info->keyword == straight_keyword<3>) {
            const auto likely = likely_order<D>(raw.points, kind.curved.nodes, quiet);
            if (!likely) return fail(likely.error());
            return listing::reorder<3>(kind.curved.nodes, *likely, quiet);
        }
    return Done{};
}

template <int K, int D>
Outcome<Done> read_kind(const File& file, const Execution& execution, const listing::Mesh<D>& raw,
                        listing::Simplices<K>& kind, std::vector<Notice>& notices) {
    const Execution quiet = without_progress(execution);
    const Block* straight = file.find(straight_keyword<K>);
    const Block* curved = file.find(curved_keyword<K>);
    if (straight && words_per_row(file, *straight) == quadratic_nodes<K> + 1) {
        if (curved && curved->count > 0)
            return fail_at(file, straight->start,
                           std::string(straight->info->name) + " has rows of degree 2 beside a block " +
                               std::string(curved->info->name));
        curved = std::exchange(straight, nullptr);
    }
    if (curved)
        if (auto read = read_curved<K, D>(file, *curved, execution, raw, kind); !read) return read;
    if (straight)
        if (auto read = read_simplices(file, *straight, raw.points.size(), curved ? quiet : execution, kind.straight);
            !read)
            return read;
    return read_indices(file, required_keyword<K>, kind.indexed(), quiet, kind.required, notices);
}

template <int D>
void drop_degenerate_edges(listing::Mesh<D>& raw, std::vector<Notice>& notices) {
    listing::Simplices<1>& edges = [&]() -> listing::Simplices<1>& {
        if constexpr (D == 2)
            return raw.facets;
        else
            return raw.edges;
    }();
    auto& rows = edges.straight;
    constexpr std::uint32_t removed = VertexId().value;
    Buffer<std::uint32_t> numbers(rows.size());
    std::uint32_t preserved = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        numbers[i] = rows.nodes[i][0] == rows.nodes[i][1] ? removed : preserved;
        if (numbers[i] == removed) continue;
        rows.nodes[preserved] = rows.nodes[i];
        rows.references[preserved++] = rows.references[i];
    }
    if (preserved == rows.size()) return;
    notices.push_back({std::to_string(rows.size() - preserved) +
                       " edges from a vertex to itself were left out: they have no length"});
    rows.nodes.resize(preserved);
    rows.references.resize(preserved);
    if (edges.curved.size() > 0)
        return;  // `required` and `ridges` then contain row numbers of quadratic edges, which
                 // are not renumbered here
    for (Buffer<std::uint32_t>* const indices : {&edges.required, &raw.ridges}) {
        for (std::uint32_t& index : *indices) index = numbers[index];
        std::erase(*indices, removed);
    }
}

Outcome<Done> refuse_tetrahedra(const File& file) {
    for (const Keyword keyword : {Keyword::tetrahedra, Keyword::tetrahedra_p2})
        if (const Block* const block = file.find(keyword); block && block->count > 0)
            return fail_at(file, block->start, "the file has tetrahedra, but its Dimension is 2",
                           "set Dimension 3, and give three coordinates per vertex");
    return Done{};
}

double share_of(const File& file, std::initializer_list<Keyword> keywords) {
    std::size_t all = 0, chosen = 0;
    for (const Block& block : file.blocks) {
        all += block.end - block.body;
        if (std::ranges::find(keywords, block.info->keyword) != keywords.end()) chosen += block.end - block.body;
    }
    return all > 0 ? static_cast<double>(chosen) / static_cast<double>(all) : 0.0;
}

}  // namespace

template <int D>
Outcome<listing::Mesh<D>> read_raw(const File& file, std::vector<Notice>& notices, const Execution& execution) {
    listing::Mesh<D> raw;
    raw.name = file.name;
    const double points = share_of(file, {Keyword::vertices});
    const double elements = points + share_of(file, {straight_keyword<D>, curved_keyword<D>});
    const double facets = elements + share_of(file, {straight_keyword<D - 1>, curved_keyword<D - 1>});
    const Execution quiet = without_progress(execution);
    auto read =
        read_points(file, part_of(execution, 0, points), raw)
            .and_then([&](Done) {
                return read_kind<D, D>(file, part_of(execution, points, elements), raw, raw.elements, notices);
            })
            .and_then([&](Done) {
                return read_kind<D - 1, D>(file, part_of(execution, elements, facets), raw, raw.facets, notices);
            })
            .and_then([&](Done) -> Outcome<Done> {
                if constexpr (D == 2)
                    return refuse_tetrahedra(file);
                else
                    return read_kind<1, D>(file, quiet, raw, raw.edges, notices);
            })
            .and_then([&](Done) {
                const std::size_t edges = D == 2 ? raw.facets.indexed() : raw.edges.indexed();
                return read_indices(file, Keyword::ridges, edges, quiet, raw.ridges, notices);
            })
            .and_then([&](Done) {
                return read_indices(file, Keyword::corners, raw.points.size(), quiet, raw.corners, notices);
            })
            .and_then([&](Done) {
                return read_indices(file, Keyword::required_vertices, raw.points.size(), quiet, raw.required_vertices,
                                    notices);
            })
            .and_then([&](Done) {
                return read_geometry<D>(file, raw.points.size(), notices, quiet).map([&](InputGeometry<D> geometry) {
                    raw.geometry = std::move(geometry);
                    return Done{};
                });
            });
    if (!read) return fail(std::move(read.error()));
    drop_degenerate_edges(raw, notices);
    return raw;
}

template <int D, int Degree>
Outcome<LinearMesh<D>> read_lists(const File& file) {
    LinearMesh<D> lists;
    std::vector<Notice> notices;
    const auto limit = [&](Keyword keyword) {
        const Block* const block = file.find(keyword);
        return block ? static_cast<std::size_t>(block->count) : std::size_t{0};
    };
    const auto read = [&]<class Item>(Keyword keyword, std::size_t below, Column<Item>& column) {
        Buffer<Item> items;
        return read_indices(file, keyword, below, {}, items, notices).map([&](Done done) {
            column = std::move(items);
            return done;
        });
    };
    const std::size_t points = limit(Keyword::vertices);
    const std::size_t elements = limit(simplex_keyword<D, Degree>);
    const std::size_t facets = limit(simplex_keyword<D - 1, Degree>);
    const std::size_t edges = D == 3 ? limit(simplex_keyword<1, Degree>) : 0;
    auto done = read(Keyword::corners, points, lists.corners)
                    .and_then([&](Done) { return read(Keyword::required_vertices, points, lists.required_vertices); })
                    .and_then([&](Done) { return read(Keyword::ridges, D == 3 ? edges : facets, lists.ridges); })
                    .and_then([&](Done) { return read(required_keyword<D>, elements, lists.elements.required); })
                    .and_then([&](Done) { return read(required_keyword<D - 1>, facets, lists.facets.required); })
                    .and_then([&](Done) -> Outcome<Done> {
                        if constexpr (D == 3) return read(required_keyword<1>, edges, lists.edges.required);
                        return Done{};
                    });
    if (!done) return fail(std::move(done.error()));
    auto geometry = read_geometry<D>(file, points, notices, {});
    if (!geometry) return fail(std::move(geometry.error()));
    lists.geometry = std::move(*geometry);
    return lists;
}

}  // namespace camber::gmf

namespace camber {

namespace {

template <int D>
Outcome<DecodedMesh> decode(const gmf::File& file, std::vector<Notice> notices, const Execution& execution) {
    const bool curved = file.find(gmf::curved_keyword<D>) != nullptr;
    const double of_rows = curved ? 0.3 : 1;
    auto raw = gmf::read_raw<D>(file, notices, part_of(execution, 0, of_rows));
    if (!raw) return fail(std::move(raw.error()));
    if (file.find(gmf::Keyword::sol_at_vertices))
        notices.push_back({"the block of keyword SolAtVertices was skipped: solutions are read separately"});
    using enum listing::MidNodeKind;
    return listing::assembled(std::move(*raw), file.bezier_basis == 1 ? control_point : on_curve, std::move(notices),
                              part_of(execution, of_rows, 1));
}

UnsupportedItems foreign_elements(const gmf::File& file) {
    UnsupportedItems refused;
    for (const gmf::Block& block : file.blocks)
        if (block.info->content == gmf::Content::foreign_elements)
            refused.count(std::string(block.info->name), block.count);
    return refused;
}

std::string place_of_foreign(const gmf::File& file) {
    for (const gmf::Block& block : file.blocks)
        if (block.info->content == gmf::Content::foreign_elements) return gmf::place(file, block.start);
    return file.name;
}

}  // namespace

Outcome<DecodedMesh> decode_gmf_mesh(std::span<const std::byte> bytes, std::string_view name,
                                     const DecodeOptions& options, const Execution& execution) {
    return guarded([&]() -> Outcome<DecodedMesh> {
        // The first 30 % of the progress is for locating the blocks of a text file, the rest for its rows.
        const double of_index = is_gmf_ascii(bytes) ? 0.3 : 0;
        auto file = gmf::open_file(bytes, name, part_of(execution, 0, of_index));
        if (!file) return fail(std::move(file.error()));
        const UnsupportedItems refused = foreign_elements(*file);
        if (auto supported = refused.verdict(place_of_foreign(*file), options.unsupported_cells); !supported)
            return fail(std::move(supported.error()));
        const Execution rest = part_of(execution, of_index, 1);
        auto decoded = *file->dimension == 2 ? decode<2>(*file, gmf::notices_of(*file), rest)
                                             : decode<3>(*file, gmf::notices_of(*file), rest);
        if (decoded) decoded->unsupported_cells = refused.counts();
        return decoded;
    });
}

}  // namespace camber

namespace camber::gmf {

#define CAMBER_INSTANTIATE(D)                                                                            \
    template Outcome<listing::Mesh<D>> read_raw<D>(const File&, std::vector<Notice>&, const Execution&); \
    template Outcome<LinearMesh<D>> read_lists<D, 1>(const File&);                                       \
    template Outcome<LinearMesh<D>> read_lists<D, 2>(const File&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::gmf
