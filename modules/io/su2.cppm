module;
#include <cstddef>
#include <span>
#include <string_view>
export module camber.io:su2;
import camber.core;
import :any_mesh;
import :decode_options;

export namespace camber {

/// The mesh of an SU2 file (degree 1, NDIME 2 or 3; NELEM, NPOIN and NMARK in any order). Several zones are joined, and
/// the references of elements are their numbers; or the one that is asked for is read. Each MARKER_TAG is
/// a group of facets with a reference of its own, 1, 2 … in the file's order; elements of one zone and vertices have
/// reference 0. Indices at the ends of rows are not read, as SU2 does not; SEND_RECEIVE markers and blocks that Camber
/// does not know are left out, with a notice. `where` in errors is `name: line N`; elements and points are counted
/// from 1. Errors: input (malformed, truncated, not finite, indices out of range), unsupported (zones of different
/// dimensions, elements that are no simplices), memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> decode_su2(std::span<const std::byte> bytes, std::string_view name,
                                              const DecodeOptions& options, const Execution& execution);
/// With the default options.
[[nodiscard]] inline Outcome<DecodedMesh> decode_su2(std::span<const std::byte> bytes, std::string_view name,
                                                     const Execution& execution) {
    return decode_su2(bytes, name, {}, execution);
}

/// Whether the bytes begin as an SU2 file does: with NDIME=, NZONE=, NELEM=, NPOIN= or NMARK=, after comments.
[[nodiscard]] bool is_su2(std::span<const std::byte> bytes);

}  // namespace camber
