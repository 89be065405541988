module;
#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <utility>
export module camber.io:gmf_runs;
import camber.core;
import :gmf_file;

export namespace camber {

/// So many rows of each kind.
struct GmfCounts {
    std::size_t points = 0, elements = 0, facets = 0, edges = 0;
};

/// A binary GMF mesh of degree 1 that is read by runs of its rows, any run at a time and several at once: of its bytes
/// only those are touched. Runs are checked as the whole file is (finite coordinates, vertices that exist, none twice
/// in a simplex), and begin + the size of what is to be filled is at most the count. Errors: input, of the first row at
/// fault.
template <int D>
class GmfRuns {
  public:
    explicit GmfRuns(std::shared_ptr<const gmf::File> file) : file_(std::move(file)) {}

    [[nodiscard]] GmfCounts counts() const;
    [[nodiscard]] Outcome<Done> points(std::size_t begin, std::span<Vec<D>> points,
                                       std::span<Reference> references) const;
    /// K is D, D − 1 or, of feature edges in 3D, 1.
    template <int K>
    [[nodiscard]] Outcome<Done> simplices(std::size_t begin, std::span<SimplexVertices<K>> vertices,
                                          std::span<Reference> references) const;
    /// What is said beside the rows: corners, ridges, required entities, given geometry; without rows.
    [[nodiscard]] Outcome<LinearMesh<D>> lists() const;

  private:
    std::shared_ptr<const gmf::File> file_;
};

/// Finds where the rows are; the bytes must outlive what is given. Errors: input (no GMF, cut off, counts that do not
/// fit), unsupported (text, degree 2, another dimension, elements that are no simplices), memory.
template <int D>
[[nodiscard]] Outcome<GmfRuns<D>> gmf_runs(std::span<const std::byte> bytes, std::string_view name);

}  // namespace camber
