module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
/// Meshes as files list them, and their assembly.
module camber.io:listing;
import camber.core;
import camber.bezier;
import :meshes;

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

/// Makes points of several parts one that are at the very same place: the parts' points stand behind one another, and
/// `ends` says where each ends. The first of them stays, with its reference and its values. Points of one part, as on
/// both sides of a slit, stay apart. Returns how many are gone.
template <int D>
std::size_t join_coincident(Mesh<D>& mesh, std::span<const std::size_t> ends);

/// Makes points with the same number one, and sorts them by their numbers, one of each point. Of several the first
/// stays. Returns how many are gone.
template <int D>
std::size_t join_numbered(Mesh<D>& mesh, std::span<const double> numbers);

// The parts of which `assembled` makes a mesh of degree 2 from what a file lists.

inline constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
inline constexpr std::size_t row_grain = 4096;

/// A simplex of the file, for messages.
struct Simplex {
    const Origin* origin = nullptr;
    std::size_t row = 0;
    [[nodiscard]] std::string text() const {
        return origin ? origin->noun + " " + std::to_string(origin->number_of(row)) : "another simplex";
    }
    [[nodiscard]] std::string where(const std::string& name) const {
        return origin && origin->place ? origin->place(row) : name;
    }
};

/// The first simplex for which `accepts(simplex's vertices, its nodes or fewer)` holds.
template <int D, class Accepts>
Simplex find_simplex(const Mesh<D>& raw, Accepts&& accepts) {
    Simplex found;
    const auto look = [&]<int K>(const Simplices<K>& kind) -> Outcome<Done> {
        for (std::size_t i = 0; i < kind.curved.size() && !found.origin; ++i)
            if (accepts.template operator()<K>(kind.curved.nodes[i])) found = {&kind.curved.origin, i};
        for (std::size_t i = 0; i < kind.straight.size() && !found.origin; ++i)
            if (accepts.template operator()<K>(kind.straight.nodes[i])) found = {&kind.straight.origin, i};
        return Done{};
    };
    static_cast<void>(for_each_dimension(raw, look));
    return found;
}

/// Vertices in the file's order without the mid nodes.
struct Renumbering {
    Buffer<std::uint32_t> to_mesh;  ///< of each vertex of the file; none: a mid node
    Buffer<std::uint32_t> to_file;  ///< of each vertex of the mesh
};

/// Which points of the file are mid nodes. Errors: input (a mid node that is a corner too), stopped.
template <int D>
[[nodiscard]] Outcome<Renumbering> without_mid_nodes(const Mesh<D>& raw, const Execution& execution);

/// The straight mesh on the corners: simplices of degree 2 first, as indices of required simplices and ridges have it.
/// Takes what it needs of `raw`; what is listed of mid nodes falls out and is told of. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> corner_mesh(Mesh<D>& raw, const Renumbering& numbers, const Execution& execution,
                                                 std::vector<Notice>& notices);

/// The mid node of each edge and the edge of each mid node: the lowest candidate, or none.
struct MidNodes {
    Buffer<std::uint32_t> of_edge;  ///< vertices of the file
    Buffer<std::uint32_t> edge_of;  ///< by vertices of the file
};

/// The mid nodes that all simplices agree on. Errors: input (they do not agree), stopped.
template <int D>
[[nodiscard]] Outcome<MidNodes> mid_nodes_of(const Mesh<D>& raw, const EdgeSet<D>& edges, const Renumbering& numbers,
                                             const Execution& execution);

}  // namespace camber::listing

namespace camber {

/// A mesh of either degree as most formats see it: nodes (the vertices, then the node of each edge), and cells of
/// three kinds behind one another (elements, facets, feature edges), nodes in the order of `local_edges`.
template <class Mesh>
struct Grid;

template <int D>
struct Grid<LinearMesh<D>> {
    static constexpr int dimension = D, degree = 1;
    const LinearMesh<D>& mesh;

    [[nodiscard]] const LinearMesh<D>& linear() const { return mesh; }
    [[nodiscard]] std::size_t nodes() const { return mesh.points.size(); }
    [[nodiscard]] const Vec<D>& point(std::size_t v) const { return mesh.points[v]; }
    [[nodiscard]] Reference reference(std::size_t v) const { return mesh.point_references[v]; }
    [[nodiscard]] bool is_sound() const { return true; }

    template <int K>
    static constexpr std::size_t width = K + 1;
    template <int K>
    [[nodiscard]] std::size_t node(const Simplices<K>& simplices, std::size_t s, std::size_t i) const {
        return simplices.vertices[s][i].index();
    }
};

template <int D>
struct Grid<QuadraticMesh<D>> {
    static constexpr int dimension = D, degree = 2;
    const QuadraticMesh<D>& mesh;

    [[nodiscard]] const LinearMesh<D>& linear() const { return mesh.linear; }
    [[nodiscard]] std::size_t vertices() const { return mesh.linear.points.size(); }
    [[nodiscard]] std::size_t nodes() const { return vertices() + mesh.mid_nodes.size(); }
    [[nodiscard]] const Vec<D>& point(std::size_t n) const {
        return n < vertices() ? mesh.linear.points[n] : mesh.mid_nodes[n - vertices()].point;
    }
    [[nodiscard]] Reference reference(std::size_t n) const {
        const auto& of_points = mesh.linear.point_references;
        if (n < vertices()) return of_points[n];
        const auto& [a, b] = mesh.edges.vertices[n - vertices()];
        return listing::mid_node_reference(of_points[a], of_points[b]);
    }
    [[nodiscard]] bool is_sound() const {
        return mesh.mid_nodes.size() == mesh.edges.size() &&
               mesh.edges.of_elements.size() == mesh.linear.elements.size() &&
               mesh.edges.of_facets.size() == mesh.linear.facets.size() &&
               mesh.edges.of_edges.size() == mesh.linear.edges.size();
    }

    template <int K>
    static constexpr std::size_t width = quadratic_nodes<K>;
    template <int K>
    [[nodiscard]] std::size_t node(const Simplices<K>& simplices, std::size_t s, std::size_t i) const {
        if (i <= K) return simplices.vertices[s][i].index();
        const std::size_t edge = i - K - 1;
        if constexpr (K == D)
            return vertices() + mesh.edges.of_elements[s][edge].index();
        else if constexpr (K == D - 1)
            return vertices() + mesh.edges.of_facets[s][edge].index();
        else
            return vertices() + mesh.edges.of_edges[s].index();
    }
};

template <int K>
[[nodiscard]] bool entities_fit(const Simplices<K>& simplices) {
    return simplices.entities.empty() || simplices.entities.size() == simplices.size();
}

template <int D>
[[nodiscard]] bool columns_fit(const LinearMesh<D>& m) {
    return m.point_references.size() == m.points.size() && m.elements.references.size() == m.elements.size() &&
           m.facets.references.size() == m.facets.size() && m.edges.references.size() == m.edges.size() &&
           entities_fit(m.elements) && entities_fit(m.facets) && entities_fit(m.edges) &&
           (D == 3 || m.edges.size() == 0);
}

template <int D>
[[nodiscard]] std::size_t cells_of(const LinearMesh<D>& m) {
    return m.elements.size() + m.facets.size() + m.edges.size();
}

/// f(simplices, number in its kind) of cell c: elements first, then facets, then feature edges.
template <int D, class F>
auto at_cell(const LinearMesh<D>& m, std::size_t c, F&& f) {
    if (c < m.elements.size()) return f(m.elements, c);
    c -= m.elements.size();
    if constexpr (D == 3)
        if (c >= m.facets.size()) return f(m.edges, c - m.facets.size());
    return f(m.facets, c);
}

/// The rows of simplices, found by their vertices in whichever order.
template <int K>
class RowsByVertices {
  public:
    explicit RowsByVertices(const Column<SimplexVertices<K>>& simplices) : simplices_(simplices) {
        for (const auto& simplex : simplices) vertices_ = std::max(vertices_, lowest(simplex).index() + 1);
        starts_ = Buffer<std::uint32_t>(vertices_ + 1, 0U);
        for (const auto& simplex : simplices) ++starts_[lowest(simplex).index() + 1];
        for (std::size_t v = 0; v < vertices_; ++v) starts_[v + 1] += starts_[v];
        rows_.resize(simplices.size());
        Buffer<std::uint32_t> next = starts_;
        for (std::size_t i = 0; i < simplices.size(); ++i)
            rows_[next[lowest(simplices[i]).index()]++] = static_cast<std::uint32_t>(i);
    }

    /// f(row) for each with these vertices.
    void find(const SimplexVertices<K>& wanted, auto&& f) const {
        const std::size_t v = lowest(wanted).index();
        if (v >= vertices_ || starts_[v] == starts_[v + 1]) return;
        const SimplexVertices<K> key = sorted(wanted);
        for (std::size_t k = starts_[v]; k < starts_[v + 1]; ++k)
            if (sorted(simplices_[rows_[k]]) == key) f(rows_[k]);
    }

  private:
    static SimplexVertices<K> sorted(SimplexVertices<K> vertices) {
        std::sort(vertices.begin(), vertices.end());
        return vertices;
    }
    static VertexId lowest(const SimplexVertices<K>& simplex) {
        return *std::min_element(simplex.begin(), simplex.end());
    }

    const Column<SimplexVertices<K>>& simplices_;
    std::size_t vertices_ = 0;
    Buffer<std::uint32_t> starts_, rows_;  ///< rows by their lowest vertex
};

}  // namespace camber
