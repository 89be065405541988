module;
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

namespace {

template <int D>
Outcome<DecodedMesh> decode(const gmf::File& file, std::vector<Notice> notices, const Execution& execution) {
    const bool curved = file.find(gmf::curved_keyword<D>) != nullptr;
    const double of_rows = curved ? 0.3 : 1;
    auto raw = gmf::read_raw<D>(file, notices, part_of(execution, 0, of_rows));
    if (!raw) return fail(std::move(raw.error()));
    if (file.find(gmf::Keyword::sol_at_vertices))
        notices.push_back({"the block of keyword SolAtVertices was skipped: a solution is read on its own"});
    using enum listing::MidNodeKind;
    return listing::assembled(std::move(*raw), file.bezier_basis == 1 ? control_point : on_curve, std::move(notices),
                              part_of(execution, of_rows, 1));
}

Refused foreign_elements(const gmf::File& file) {
    Refused refused;
    for (const gmf::Block& block : file.blocks)
        if (block.info->content == gmf::Content::foreign_elements)
            refused.count(std::string(block.info->name), block.count);
    return refused;
}

/// Of the first of them.
std::string place_of_foreign(const gmf::File& file) {
    for (const gmf::Block& block : file.blocks)
        if (block.info->content == gmf::Content::foreign_elements) return gmf::place(file, block.start);
    return file.name;
}

}  // namespace

Outcome<DecodedMesh> decode_gmf_mesh(std::span<const std::byte> bytes, std::string_view name,
                                     const DecodeOptions& options, const Execution& execution) {
    return guarded([&]() -> Outcome<DecodedMesh> {
        // A text is gone through twice.
        const double of_index = is_gmf_ascii(bytes) ? 0.3 : 0;
        auto file = gmf::open_file(bytes, name, part_of(execution, 0, of_index));
        if (!file) return fail(std::move(file.error()));
        const Refused refused = foreign_elements(*file);
        if (auto held = refused.verdict(place_of_foreign(*file), options.unheld); !held)
            return fail(std::move(held.error()));
        const Execution rest = part_of(execution, of_index, 1);
        auto decoded = *file->dimension == 2 ? decode<2>(*file, gmf::notices_of(*file), rest)
                                             : decode<3>(*file, gmf::notices_of(*file), rest);
        if (decoded) decoded->unheld = refused.counts();
        return decoded;
    });
}

}  // namespace camber
