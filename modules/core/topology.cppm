module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
export module camber.core:topology;
import :column;
import :each;
import :execution;
import :ids;
import :mesh;
import :outcome;

export namespace camber {

/// For each key (a vertex, an edge …) the items that touch it, in rising order; compressed rows.
template <class Item>
struct Incidence {
    Column<std::uint32_t> offsets;  ///< keys + 1
    Column<Item> items;

    [[nodiscard]] std::size_t size() const { return offsets.empty() ? 0 : offsets.size() - 1; }
    [[nodiscard]] std::span<const Item> operator[](std::size_t key) const {
        return {items.data() + offsets[key], items.data() + offsets[key + 1]};
    }
    template <class Tag>
    [[nodiscard]] std::span<const Item> operator[](Id<Tag> key) const {
        return (*this)[key.index()];
    }
};

/// The element across the face opposite each local vertex; an invalid id where there is none.
template <int D>
using Neighbours = Column<std::array<ElementId, D + 1>>;

/// A face of an element: that opposite local vertex `opposite`.
struct ElementFace {
    ElementId element;
    std::uint32_t opposite = 0;
    friend bool operator==(const ElementFace&, const ElementFace&) = default;
};

/// Derived data of the functions below, for meshes whose vertex ids are in range. Errors: more than two elements on a
/// face (`neighbours`), a simplex that names a vertex twice (`unique_edges`), more incidences than 32 bits count;
/// stopped.

/// Elements around each vertex.
template <int D>
[[nodiscard]] Outcome<Incidence<ElementId>> balls(const LinearMesh<D>& mesh, const Execution& execution);

/// Facets around each vertex.
template <int D>
[[nodiscard]] Outcome<Incidence<FacetId>> facet_balls(const LinearMesh<D>& mesh, const Execution& execution);

/// Feature edges around each vertex, by their index in LinearMesh::edges.
template <int D>
[[nodiscard]] Outcome<Incidence<EdgeId>> feature_edge_balls(const LinearMesh<D>& mesh, const Execution& execution);

/// A face of an element, named by its lowest vertex and the others, which rise.
template <int D>
struct FaceAround {
    std::array<VertexId, D - 1> others;
    ElementFace face;
};

/// The faces of which v is the lowest vertex, of all elements of its ball: equal ones side by side, by rising element.
/// Faces that name a vertex twice are left out.
template <int D>
void faces_around(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls, VertexId v,
                  std::vector<FaceAround<D>>& faces);

/// visit(faces) with all elements on a face, for each face, in parallel; needs the balls of the same mesh.
template <int D, class Visit>
[[nodiscard]] Outcome<Done> each_face(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                      const Execution& execution, Visit&& visit) {
    return each_chunk(execution, balls.size(), [&](std::size_t begin, std::size_t end) {
        std::vector<FaceAround<D>> faces;
        for (std::size_t v = begin; v < end; ++v) {
            faces_around<D>(mesh, balls, VertexId(v), faces);
            for (std::size_t first = 0, last = 0; first < faces.size(); first = last) {
                while (last < faces.size() && faces[last].others == faces[first].others) ++last;
                visit(std::span<const FaceAround<D>>(faces).subspan(first, last - first));
            }
        }
    });
}

/// The element across each face; needs the balls of the same mesh.
template <int D>
[[nodiscard]] Outcome<Neighbours<D>> neighbours(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                const Execution& execution);

/// Faces of elements without a neighbour, by rising element.
template <int D>
[[nodiscard]] Buffer<ElementFace> boundary_faces(const Neighbours<D>& neighbours);

/// Unique edges of elements, facets and feature edges (those of a surface-only mesh included).
template <int D>
[[nodiscard]] Outcome<EdgeSet<D>> unique_edges(const LinearMesh<D>& mesh, const Execution& execution);

/// The shell of each edge: its elements.
template <int D>
[[nodiscard]] Outcome<Incidence<ElementId>> shells(const EdgeSet<D>& edges, const Execution& execution);

/// Facets around each edge.
template <int D>
[[nodiscard]] Outcome<Incidence<FacetId>> facet_shells(const EdgeSet<D>& edges, const Execution& execution);

/// The edge between two vertices, or an invalid id: binary search in the sorted set.
template <int D>
[[nodiscard]] EdgeId find_edge(const EdgeSet<D>& edges, VertexId a, VertexId b);

}  // namespace camber
