// Opens GMF files and reads ranges of their rows.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
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

Outcome<File> checked(File file) {
    for (std::size_t i = 0; i < file.blocks.size(); ++i) {
        const Block& block = file.blocks[i];
        for (std::size_t j = 0; j < i; ++j)
            if (file.blocks[j].info == block.info)
                return fail_at(file, block.start, "a second block " + std::string(block.info->name),
                               "join the two, or remove one");
    }
    if (!file.dimension)
        return fail_at(file, 0, "the file has no Dimension",
                       "the file is damaged, or is not a GMF "
                       "file");
    if (*file.dimension != 2 && *file.dimension != 3)
        return fail_at(file, 0, "Dimension is " + std::to_string(*file.dimension) + ", not 2 or 3",
                       "Camber reads meshes in 2D and 3D");
    if (file.bezier_basis != 0 && file.bezier_basis != 1)
        return fail_at(file, 0, "BezierBasis is " + std::to_string(file.bezier_basis) + ", not 0 or 1");
    return file;
}

std::optional<ByteOrder> binary_order(std::span<const std::byte> bytes) {
    std::int32_t mark = 0;
    if (bytes.size() >= sizeof mark) std::memcpy(&mark, bytes.data(), sizeof mark);
    if (mark == 1) return ByteOrder::native;
    if (mark == 16777216) return ByteOrder::swapped;
    return std::nullopt;
}

std::string row_error_text(const RowError& row_error) {
    const std::string value = std::to_string(row_error.value);
    switch (row_error.kind) {
        case RowErrorKind::none: break;
        case RowErrorKind::syntax: return "a number is malformed, or too large for its kind";
        case RowErrorKind::index:
            if (row_error.limit == 0) return "the index " + value + " refers to an entity that the file does not have";
            return "the index " + value + " is not between 1 and " + std::to_string(row_error.limit);
        case RowErrorKind::repeated: return "vertex " + value + " occurs twice";
        case RowErrorKind::not_finite: return "a value is infinite or not a number";
        case RowErrorKind::too_large: return "the reference " + value + " does not fit 32 bits";
    }
    return {};
}

const char* row_error_remedy(RowErrorKind kind) {
    switch (kind) {
        case RowErrorKind::none: break;
        case RowErrorKind::syntax: return "the file is damaged, or a row before has too few or too many numbers";
        case RowErrorKind::index: return "GMF counts from 1; the file is damaged, or belongs to another mesh";
        case RowErrorKind::repeated: return "remove it: it has no volume";
        case RowErrorKind::not_finite: return "the program that wrote the file failed there. Write it again";
        case RowErrorKind::too_large: return "use smaller references";
    }
    return "";
}

}  // namespace

const Block* File::find(Keyword keyword) const {
    for (const Block& block : blocks)
        if (block.info->keyword == keyword) return &block;
    return nullptr;
}

Outcome<File> open_file(std::span<const std::byte> bytes, std::string_view name, const Execution& execution) {
    File file{.bytes = bytes, .name = std::string(name)};
    if (bytes.empty()) return fail_at(file, 0, "the file is empty", "write it again");
    if (const auto order = binary_order(bytes)) {
        file.order = *order;
        return index_binary(std::move(file)).and_then(checked);
    }
    file.encoding = GmfEncoding::ascii;
    return index_ascii(std::move(file), execution).and_then(checked);
}

void set_value(File& file, Keyword keyword, std::int64_t value) {
    if (keyword == Keyword::dimension) file.dimension = value;
    if (keyword == Keyword::bezier_basis) file.bezier_basis = value;
}

void skip_block(File& file, std::string_view word) {
    // Unprintable characters are replaced, so that damaged files cannot send control characters to a terminal.
    std::string name(word.substr(0, 80));
    for (char& c : name)
        if (c < ' ' || c > '~') c = '?';
    for (Skipped& skipped : file.skipped)
        if (skipped.name == name) {
            ++skipped.blocks;
            return;
        }
    // A damaged file may contain any number of different keywords, so the length of the list is limited.
    constexpr std::size_t max_names = 100;
    if (file.skipped.size() < max_names) file.skipped.push_back({name, 1});
}

std::vector<Notice> notices_of(const File& file) {
    std::vector<Notice> notices = file.notices;
    for (const Skipped& skipped : file.skipped)
        notices.push_back({skipped.blocks == 1 ? "the block of keyword " + skipped.name + " was skipped"
                                               : std::to_string(skipped.blocks) + " blocks of keyword " + skipped.name +
                                                     " were skipped"});
    return notices;
}

std::string place(const File& file, std::size_t at) {
    if (file.encoding == GmfEncoding::binary) return file.name + ": byte " + std::to_string(at);
    const auto text = file.bytes.first(std::min(at, file.bytes.size()));
    const auto lines = std::count(text.begin(), text.end(), std::byte{'\n'});
    return file.name + ": line " + std::to_string(lines + 1);
}

Outcome<Done> check_size(const File& file, const Block& block, int integers, int reals) {
    const bool ascii = file.encoding == GmfEncoding::ascii;
    const std::size_t room = ascii ? block.words : block.end - block.body;
    const std::size_t row =
        ascii ? static_cast<std::size_t>(integers + reals) : row_bytes(file.version, integers, reals);
    const bool fits = block.count <= room / row;
    if (fits && (!ascii || block.count * row == room)) {
        if (block.count <= max_entities) return Done{};
        return fail(ErrorKind::unsupported, std::string(block.info->name) + " has more rows than 32 bits can number",
                    place(file, block.start));
    }
    return fail_at(file, block.start,
                   std::string(block.info->name) + " announces " + std::to_string(block.count) + " rows of " +
                       std::to_string(row) + (ascii ? " numbers" : " bytes") + ", but " + std::to_string(room) +
                       " follow",
                   fits ? "the rows are longer than GMF allows" : "the file is cut off or its count is wrong");
}

std::size_t words_per_row(const File& file, const Block& block) {
    const std::size_t words =
        file.encoding == GmfEncoding::ascii ? block.words : (block.end - block.body) / row_bytes(file.version, 1, 0);
    return block.count == 0 || words % block.count != 0 ? 0 : words / block.count;
}

std::size_t row_begin(const File& file, const Block& block, std::size_t row, int integers, int reals) {
    if (file.encoding == GmfEncoding::binary) return block.body + row * row_bytes(file.version, integers, reals);
    const std::size_t word = row * static_cast<std::size_t>(integers + reals);
    auto piece = std::upper_bound(block.pieces.begin(), block.pieces.end(), word,
                                  [](std::size_t w, const Piece& p) { return w < p.first_word; });
    if (piece == block.pieces.begin()) return block.body;
    --piece;
    Words words = words_between(file, piece->begin, block.end);
    words.skip(word - piece->first_word);
    if (!words.find()) return block.body;
    return static_cast<std::size_t>(words.at - reinterpret_cast<const char*>(file.bytes.data()));
}

Error row_error_message(const File& file, const Block& block, std::size_t row, std::size_t at,
                        const RowError& row_error) {
    return Error{ErrorKind::input, row_error_text(row_error), place(file, at),
                 Entity{std::string(block.info->noun), row / block.rows_per_entity + 1},
                 row_error_remedy(row_error.kind)};
}

}  // namespace camber::gmf

namespace camber {

bool is_gmf_binary(std::span<const std::byte> bytes) { return gmf::binary_order(bytes).has_value(); }

namespace gmf {

namespace {

constexpr const char* straighten =
    "read it as a whole, or convert it: camber convert IN.mesh -o OUT.meshb --straighten";
constexpr const char* rewrite = "read it as a whole, or convert it: camber convert IN.mesh -o OUT.meshb";

std::size_t count_of(const File& file, Keyword keyword) {
    const Block* const block = file.find(keyword);
    return block ? block->count : 0;
}

template <int K, int Degree>
Outcome<Done> check_simplices(const File& file) {
    if (const Block* const others = file.find(simplex_keyword<K, 3 - Degree>); others && others->count > 0)
        return fail(ErrorKind::unsupported,
                    Degree == 1 ? "elements of degree 2 cannot be read in parts here"
                                : std::string(others->info->name) + " beside those of degree 2 cannot be read in parts",
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
        return fail(ErrorKind::unsupported, "text cannot be read in parts", file.name, {}, rewrite);
    if (*file.dimension != D)
        return fail(ErrorKind::unsupported, "the mesh does not have dimension " + std::to_string(D), file.name);
    for (const Block& block : file.blocks)
        if (block.info->content == Content::foreign_elements)
            return fail(ErrorKind::unsupported, std::string(block.info->name) + " are no simplices",
                        place(file, block.start), {}, "convert it to simplices in the program that made it");
    const Block* const points = file.find(Keyword::vertices);
    if (!points) return fail_at(file, 0, "the file has no Vertices", "give a mesh");
    if (Degree == 2 && file.bezier_basis == 1)
        return fail(ErrorKind::unsupported, "nodes that are control points cannot be read in parts", file.name, {},
                    rewrite);
    return check_size(file, *points, 1, D)
        .and_then([&](Done) { return check_simplices<D, Degree>(file); })
        .and_then([&](Done) { return check_simplices<D - 1, Degree>(file); })
        .and_then([&](Done) { return D == 3 ? check_simplices<1, Degree>(file) : Outcome<Done>(Done{}); });
}

/// Reads `size` rows of the block, beginning with row `begin`, and calls store(i, row) for each; i counts from 0.
/// `store` returns a RowError. Uses only the calling thread.
template <class RowType, class Store>
Outcome<Done> read_run(const File& file, Keyword keyword, std::size_t begin, std::size_t size, Store&& store) {
    const Block* const block = file.find(keyword);
    if (size == 0) return Done{};
    if (!block || begin + size > block->count)
        return fail(ErrorKind::internal, "a range of rows ends after the rows of " + std::string(name_of(keyword)));
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
    const auto store = [&](std::size_t i, const gmf::SimplexRow<count>& row) -> gmf::RowError {
        // The decoder of whole files drops edges from a vertex to itself. Here this is an error, because dropping a row
        // would change the numbers of later rows.
        if (K == 1 && row.integer[0] == row.integer[1]) return {gmf::RowErrorKind::repeated, row.integer[0]};
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
