module;
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>
export module camber.io:gmf;
import camber.core;
import :any_mesh;
import :decode_options;
import :solution;

export namespace camber {

/// A GMF mesh (.mesh, .meshb; ASCII or binary by content, versions 1 to 4, either byte order).
/// - Dimension 2 gives a 2D mesh, dimension 3 a 3D one (a surface alone: without elements).
/// - Elements of degree 2 give a QuadraticMesh: vertices keep the file's order without the mid nodes, which move to the
///   edges. Node orders (…P2Ordering) and BezierBasis are honoured. Where simplices of degrees 1 and 2 meet, those of
///   degree 2 come first and the others take the edges' nodes; edges without a node in the file get the middle of the
///   chord.
/// - Plain element keywords with the rows of degree 2 (Gmsh writes them) are read as degree 2. Gmsh's versions differ
/// in
///   the order of the last two nodes of a tetrahedron: the order whose nodes lie nearer the middles of the chords is
///   taken.
/// - A mid node's own reference is not kept (notice when it says more than those of the edge's ends).
/// `name` is the file's, for messages; `where` in errors is `name: line N` (from 1) or `name: byte N` (from 0).
/// Errors: input (malformed, truncated, not finite, indices out of range, mid nodes that contradict each other),
/// unsupported (elements that are no simplices or of higher degree), memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> decode_gmf_mesh(std::span<const std::byte> bytes, std::string_view name,
                                                   const DecodeOptions& options, const Execution& execution);
/// With the default options.
[[nodiscard]] inline Outcome<DecodedMesh> decode_gmf_mesh(std::span<const std::byte> bytes, std::string_view name,
                                                          const Execution& execution) {
    return decode_gmf_mesh(bytes, name, {}, execution);
}

/// Whether the bytes begin as a GMF file does, as text or binary in either byte order, of a mesh or of a solution.
[[nodiscard]] bool is_gmf_ascii(std::span<const std::byte> bytes);
[[nodiscard]] bool is_gmf_binary(std::span<const std::byte> bytes);

/// Text (.mesh, .sol) or binary, little-endian (.meshb, .solb).
enum class GmfEncoding { ascii, binary };

/// How a GMF file is written.
struct GmfOptions {
    GmfEncoding encoding = GmfEncoding::binary;
    /// GMF version, 2 to 4; 0 is the least that fits: 2 below 2 GiB, 3 beyond, 4 when a count or an index needs 64
    /// bits.
    int version = 0;
};

/// The mesh as a GMF file; decoding it gives the same value back, to the bit. Empty blocks but Vertices are left out.
/// Errors: usage (a version that is none or too low), memory, stopped.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_gmf_mesh(const LinearMesh<D>& mesh, GmfOptions options,
                                              const Execution& execution);

/// As above, with elements of degree 2 in the order of `local_edges` (Vizir's default: no Ordering blocks). Mid nodes
/// follow the vertices in the order of the edges; their reference is that of the edge's ends where both agree, else 0.
template <int D>
[[nodiscard]] Outcome<Chunks> encode_gmf_mesh(const QuadraticMesh<D>& mesh, GmfOptions options,
                                              const Execution& execution);

/// What of the mesh a GMF file has no place for: names of references, entities of simplices, associations without
/// parameters, which are left out, and distances that are not known, which are written as 0.
template <int D>
[[nodiscard]] std::vector<Notice> not_in_gmf(const LinearMesh<D>& mesh);
template <int D>
[[nodiscard]] std::vector<Notice> not_in_gmf(const QuadraticMesh<D>& mesh) {
    return not_in_gmf(mesh.linear);
}

/// The fields of SolAtVertices in a GMF file (.sol, .solb). Errors as above; values that are not finite are errors.
[[nodiscard]] Outcome<DecodedSolution> decode_gmf_solution(std::span<const std::byte> bytes, std::string_view name,
                                                           const Execution& execution);

/// The solution as a GMF file. Errors: usage (also: no fields, or not rows × width values), memory, stopped.
[[nodiscard]] Outcome<Chunks> encode_gmf_solution(const Solution& solution, GmfOptions options,
                                                  const Execution& execution);

}  // namespace camber
