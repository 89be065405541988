module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>
export module camber.io:gmf_raw;
import camber.core;
import camber.bezier;
import :any_mesh;
import :gmf_file;

namespace camber::gmf {

/// K-simplices as a file lists them, checked: every vertex exists and none occurs twice in a simplex.
template <int K>
struct RawSimplices {
    using Nodes = std::array<VertexId, quadratic_nodes<K>>;

    const Block* straight_block = nullptr;
    Buffer<SimplexVertices<K>> straight;  ///< degree 1
    Buffer<Reference> straight_references;
    const Block* curved_block = nullptr;
    Buffer<Nodes> curved;  ///< degree 2, nodes in the order of `local_edges`
    Buffer<Reference> curved_references;
    Buffer<std::uint32_t> required;

    /// What indices of ridges and required simplices count: those of degree 2 when there are any.
    [[nodiscard]] std::size_t indexed() const { return curved.empty() ? straight.size() : curved.size(); }
};

/// What a file holds, mid nodes among the points.
template <int D>
struct RawMesh {
    Buffer<Vec<D>> points;
    Buffer<Reference> point_references;
    RawSimplices<D> elements;
    RawSimplices<D - 1> facets;
    RawSimplices<1> edges;  ///< empty in 2D
    Buffer<VertexId> corners, required_vertices;
    Buffer<std::uint32_t> ridges;
    GivenGeometry<D> geometry;

    [[nodiscard]] bool quadratic() const {
        return !elements.curved.empty() || !facets.curved.empty() || !edges.curved.empty();
    }
};

template <int D>
[[nodiscard]] Outcome<RawMesh<D>> read_raw(const File& file, const Execution& execution);

/// Normals, tangents, and places on CAD entities, of a file with so many vertices.
template <int D>
[[nodiscard]] Outcome<GivenGeometry<D>> read_geometry(const File& file, std::size_t vertices,
                                                      const Execution& execution);

/// The mesh of degree 1, its columns moved in.
template <int D>
[[nodiscard]] LinearMesh<D> straight_mesh(RawMesh<D> raw);

/// The mesh of degree 2 as a DecodedMesh; its notices are added to those given.
template <int D>
[[nodiscard]] Outcome<DecodedMesh> quadratic_mesh(RawMesh<D> raw, const File& file, const Execution& execution,
                                                  std::vector<Notice> notices);

/// The reference that a mid node is written with: that of the edge's ends where both agree, else 0.
[[nodiscard]] constexpr Reference mid_node_reference(Reference a, Reference b) { return a == b ? a : 0; }

}  // namespace camber::gmf
