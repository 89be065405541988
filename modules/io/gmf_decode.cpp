module;
#include <cstddef>
#include <span>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

namespace {

template <int D>
Outcome<DecodedMesh> decode(const gmf::File& file, const Execution& execution) {
    const bool curved = file.find(gmf::curved_keyword<D>) != nullptr;
    const double of_rows = curved ? 0.3 : 1;
    auto raw = gmf::read_raw<D>(file, part_of(execution, 0, of_rows));
    if (!raw) return fail(std::move(raw.error()));
    std::vector<Notice> notices = gmf::notices_of(file);
    if (file.find(gmf::Keyword::sol_at_vertices))
        notices.push_back({"the block of keyword SolAtVertices was skipped: a solution is read on its own"});
    using enum listing::MidNodeKind;
    return listing::assembled(std::move(*raw), file.bezier_basis == 1 ? control_point : on_curve, std::move(notices),
                              part_of(execution, of_rows, 1));
}

}  // namespace

Outcome<DecodedMesh> decode_gmf_mesh(std::span<const std::byte> bytes, std::string_view name,
                                     const Execution& execution) {
    return guarded([&]() -> Outcome<DecodedMesh> {
        // A text is gone through twice.
        const double of_index = is_gmf_ascii(bytes) ? 0.3 : 0;
        auto file = gmf::open_file(bytes, name, part_of(execution, 0, of_index));
        if (!file) return fail(std::move(file.error()));
        const Execution rest = part_of(execution, of_index, 1);
        return *file->dimension == 2 ? decode<2>(*file, rest) : decode<3>(*file, rest);
    });
}

}  // namespace camber
