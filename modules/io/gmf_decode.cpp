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
    auto raw = gmf::read_raw<D>(file, execution);
    if (!raw) return fail(std::move(raw.error()));
    std::vector<Notice> notices = gmf::notices_of(file);
    if (file.find(gmf::Keyword::sol_at_vertices))
        notices.push_back({"the block of keyword SolAtVertices was skipped: a solution is read on its own"});
    using enum listing::MidNodeKind;
    return listing::assembled(std::move(*raw), file.bezier_basis == 1 ? control_point : on_curve, std::move(notices),
                              execution);
}

}  // namespace

Outcome<DecodedMesh> decode_gmf_mesh(std::span<const std::byte> bytes, std::string_view name,
                                     const Execution& execution) {
    return guarded([&]() -> Outcome<DecodedMesh> {
        auto file = gmf::open_file(bytes, name, execution);
        if (!file) return fail(std::move(file.error()));
        return *file->dimension == 2 ? decode<2>(*file, execution) : decode<3>(*file, execution);
    });
}

}  // namespace camber
