module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io:listing;
import camber.core;
import camber.bezier;
import :any_mesh;
import :mesh_fields;
import :notice;

/// A mesh as files list it: mid nodes among the points, simplices of both degrees beside each other. Decoders of all
/// formats make one of these, and `assembled` makes the mesh of it.
namespace camber::listing {

/// What a list of simplices is called in its file, and where it stands there, for messages.
struct Origin {
    std::string noun = {};                                      ///< "tetrahedron"
    std::function<std::uint64_t(std::size_t row)> number = {};  ///< of a simplex; none: row + 1
    std::function<std::string(std::size_t row)> place = {};     ///< `name: line N`, `name: byte N`; none: the file

    [[nodiscard]] std::uint64_t number_of(std::size_t row) const { return number ? number(row) : row + 1; }
};

/// Simplices of one dimension and one degree, by so many nodes each.
template <int Nodes>
struct Rows {
    Buffer<std::array<VertexId, Nodes>> nodes = {};
    Buffer<Reference> references = {};  ///< one a row
    Buffer<Reference> entities = {};    ///< one a row (0: not known), or none at all
    Origin origin = {};

    [[nodiscard]] std::size_t size() const { return nodes.size(); }
};

/// K-simplices. Those of degree 2 have their nodes in the order of `local_edges`.
template <int K>
struct Simplices {
    Rows<K + 1> straight;
    Rows<quadratic_nodes<K>> curved;
    Buffer<std::uint32_t> required = {};

    /// What indices of ridges and required simplices count: those of degree 2 when there are any.
    [[nodiscard]] std::size_t indexed() const { return curved.size() == 0 ? straight.size() : curved.size(); }
};

template <int D>
struct Mesh {
    std::string name;  ///< the file's, for messages
    Buffer<Vec<D>> points;
    Buffer<Reference> point_references;  ///< one a point
    Simplices<D> elements;
    Simplices<D - 1> facets;
    Simplices<1> edges;  ///< empty in 2D
    Buffer<VertexId> corners = {}, required_vertices = {};
    Buffer<std::uint32_t> ridges = {};
    GivenGeometry<D> geometry = {};
    Buffer<Group> groups = {};
    /// Rows of points, in their order; of cells, in the order elements, facets, edges, of each those of degree 2 first.
    MeshFields fields = {};
    std::function<std::uint64_t(std::size_t point)> number = {};  ///< the file's, of a point; none: point + 1

    [[nodiscard]] std::uint64_t number_of(VertexId point) const {
        return number ? number(point.index()) : point.index() + 1;
    }
    [[nodiscard]] bool quadratic() const {
        return elements.curved.size() + facets.curved.size() + edges.curved.size() > 0;
    }
};

/// What mid nodes of a file are.
enum class MidNodeKind : std::uint8_t { on_curve, control_point };

/// The mesh of degree 1 or 2: vertices in the file's order without the mid nodes, which move to the edges; simplices of
/// degree 2 first; edges that have no node in the file get the middle of the chord. Every index must exist, and no
/// simplex may have a vertex twice. Errors: input (mid nodes that contradict each other), memory, stopped.
template <int D>
[[nodiscard]] Outcome<DecodedMesh> assembled(Mesh<D> mesh, MidNodeKind kind, std::vector<Notice> notices,
                                             const Execution& execution);

/// Whether coordinates are finite, all nodes of simplices are points (an invalid id is none), and none occurs twice in
/// a simplex. Errors: input, the first that is not so.
template <int D>
[[nodiscard]] Outcome<Done> check(const Mesh<D>& mesh, const Execution& execution);

/// The local node, in the order of `local_edges`, that each node of a row in the file is.
template <int K>
using NodeOrder = std::array<int, quadratic_nodes<K>>;

/// Brings the nodes of simplices that have this order into that of `local_edges`.
template <int K>
[[nodiscard]] Outcome<Done> reorder(Buffer<std::array<VertexId, quadratic_nodes<K>>>& simplices,
                                    const NodeOrder<K>& order, const Execution& execution);

using camber::mid_node_reference;

/// f(simplices of one dimension) → Outcome<Done>, for each dimension that the mesh has, until one fails.
template <int D, class F>
[[nodiscard]] Outcome<Done> for_each_dimension(const Mesh<D>& mesh, F&& f) {
    auto done = f(mesh.elements);
    if (done) done = f(mesh.facets);
    if constexpr (D == 3)
        if (done) done = f(mesh.edges);
    return done;
}

}  // namespace camber::listing
