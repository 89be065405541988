module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>
export module camber.io:gmf_parts;
import camber.core;
import camber.bezier;
import :gmf;

export namespace camber {

/// Nodes of a K-simplex of a degree.
template <int K, int Degree>
inline constexpr int nodes_of_degree = Degree == 1 ? K + 1 : quadratic_nodes<K>;

/// Points that follow each other in a file, `first` being the number of the first of them.
template <int D>
struct PointRun {
    std::uint64_t first = 0;
    Buffer<Vec<D>> points = {};
    Buffer<Reference> references = {};
};
/// K-simplices that follow each other in a file. Their nodes are the numbers of points there, from 0: of degree 2 those
/// of edges, in the order of `local_edges`, after all vertices.
template <int K, int Degree>
struct SimplexRun {
    std::uint64_t first = 0;
    Buffer<std::array<std::uint64_t, nodes_of_degree<K, Degree>>> nodes = {};
    Buffer<Reference> references = {};
};

/// What one of several holders has of a mesh: runs of its rows.
template <int D, int Degree>
struct FilePart {
    PointRun<D> vertices = {};
    PointRun<D> mid_nodes = {};  ///< of edges; `first` counts these alone. Of degree 1 none.
    SimplexRun<D, Degree> elements = {};
    SimplexRun<D - 1, Degree> facets = {};
    SimplexRun<1, Degree> edges = {};  ///< feature edges in 3D
};

/// The rows of all parts.
struct PartTotals {
    std::uint64_t vertices = 0, mid_nodes = 0, elements = 0, facets = 0, edges = 0;
};

/// Where a file's rows are to be: a plain value, the same for all who write to it.
struct GmfFrame {
    int version = 0;
    std::uint64_t bytes = 0;                                        ///< of the whole file
    std::uint64_t points = 0, elements = 0, facets = 0, edges = 0;  ///< where the rows of each begin
    PartTotals totals = {};
};

/// Bytes for a place in a file.
struct FilePiece {
    std::uint64_t offset = 0;
    Buffer<std::byte> bytes;
};

/// The frame of a binary file, and all of it that is no part's: headers, and what `lists` says beside the rows. Put in
/// place, they and the pieces of all parts are the file of `encode_gmf_mesh` of the whole. Errors: usage (the version).
template <int D, int Degree>
[[nodiscard]] Outcome<GmfFrame> gmf_frame(const PartTotals& totals, const LinearMesh<D>& lists, int version = 0);
template <int D, int Degree>
[[nodiscard]] Outcome<std::vector<FilePiece>> encode_gmf_frame(const GmfFrame& frame, const LinearMesh<D>& lists,
                                                               const Execution& execution);
template <int D, int Degree>
[[nodiscard]] Outcome<std::vector<FilePiece>> encode_gmf_part(const GmfFrame& frame, const FilePart<D, Degree>& part,
                                                              const Execution& execution);

}  // namespace camber
