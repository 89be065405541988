module;
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
export module camber.io:gmf_runs;
import camber.core;
import camber.bezier;
import :gmf_file;
import :gmf_parts;

export namespace camber {

/// So many rows of each kind.
struct GmfCounts {
    std::size_t points = 0, elements = 0, facets = 0, edges = 0;
};

/// A binary GMF mesh that is read by runs of its rows, any run at a time and several at once: of its bytes only those
/// are touched. Runs are checked as the whole file is (finite coordinates, points that exist, none twice in a simplex),
/// and begin + the size of what is to be filled is at most the count. Points are those of the file: of degree 2 also
/// the nodes of edges. Errors: input, of the first row at fault.
template <int D, int Degree = 1>
class GmfRuns {
  public:
    template <int K>
    using Nodes = std::array<VertexId, nodes_of_degree<K, Degree>>;

    explicit GmfRuns(std::shared_ptr<const gmf::File> file) : file_(std::move(file)) {}

    [[nodiscard]] GmfCounts counts() const;
    [[nodiscard]] Outcome<Done> points(std::size_t begin, std::span<Vec<D>> points,
                                       std::span<Reference> references) const;
    /// K is D, D − 1 or, of feature edges in 3D, 1. Nodes of edges are in the order of `local_edges`, whatever the
    /// file's.
    template <int K>
    [[nodiscard]] Outcome<Done> simplices(std::size_t begin, std::span<Nodes<K>> nodes,
                                          std::span<Reference> references) const;
    /// What is said beside the rows: corners, ridges, required entities, given geometry; without rows.
    [[nodiscard]] Outcome<LinearMesh<D>> lists() const;

  private:
    std::shared_ptr<const gmf::File> file_;
};

/// What a file's simplices are, as its headers say. Errors: input.
struct GmfShape {
    int dimension = 0, degree = 1;
};
[[nodiscard]] Outcome<GmfShape> gmf_shape(std::span<const std::byte> bytes, std::string_view name);

/// Finds where the rows are; the bytes must outlive what is given. Errors: input (no GMF, cut off, counts that do not
/// fit), unsupported (text, another degree or dimension, elements that are no simplices, nodes that are control
/// points), memory.
template <int D, int Degree = 1>
[[nodiscard]] Outcome<GmfRuns<D, Degree>> gmf_runs(std::span<const std::byte> bytes, std::string_view name);

}  // namespace camber
