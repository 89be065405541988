module;
#include <array>
#include <cstddef>
#include <memory>
#include <vector>
export module camber.distributed:rows;
import camber.core;

export namespace camber {

/// So many rows a mesh has in a file or in memory.
struct RowCounts {
    std::size_t points = 0, elements = 0, facets = 0, edges = 0;
};

/// K-simplices in the order of their file, without what LinearMesh says of them beside.
template <int K>
struct SimplexRows {
    Buffer<SimplexVertices<K>> vertices;
    Buffer<Reference> references;
};
template <int D>
struct PointRows {
    Buffer<Vec<D>> points;
    Buffer<Reference> references;
};

/// A mesh that is read by rows, any run of them at a time and several at once: from a file by offsets, or from memory.
/// Vertex ids are in range (`input` otherwise). Errors: input, memory.
template <int D>
class MeshRows {
  public:
    virtual ~MeshRows() = default;
    [[nodiscard]] virtual RowCounts counts() const = 0;
    [[nodiscard]] virtual Outcome<PointRows<D>> points(std::size_t begin, std::size_t end) const = 0;
    [[nodiscard]] virtual Outcome<SimplexRows<D>> elements(std::size_t begin, std::size_t end) const = 0;
    [[nodiscard]] virtual Outcome<SimplexRows<D - 1>> facets(std::size_t begin, std::size_t end) const = 0;
    /// Feature edges of a mesh in 3D.
    [[nodiscard]] virtual Outcome<SimplexRows<1>> edges(std::size_t begin, std::size_t end) const = 0;
    /// What is said beside the rows, which is little: corners, required entities and ridges, which rise, the given
    /// geometry, names of references.
    [[nodiscard]] virtual Outcome<LinearMesh<D>> lists() const = 0;

  protected:
    MeshRows() = default;
    MeshRows(const MeshRows&) = default;
    MeshRows(MeshRows&&) = default;
    MeshRows& operator=(const MeshRows&) = default;
    MeshRows& operator=(MeshRows&&) = default;
};

}  // namespace camber
