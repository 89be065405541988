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
module camber.io:listing;
import camber.core;
import camber.bezier;
import :meshes;

/// Content of a file before a mesh is built: mid nodes are among the points, and simplices of both degrees may occur.
/// Decoders produce a listing::Mesh for `assembled`.
namespace camber::listing {

struct Origin {
    std::string noun = {};
    std::function<std::uint64_t(std::size_t row)> number = {};  ///< number of a row in the file; null: row + 1
    std::function<std::string(std::size_t row)> place = {};     ///< position of a row for messages; null: the file name

    [[nodiscard]] std::uint64_t number_of(std::size_t row) const { return number ? number(row) : row + 1; }
};

template <int Nodes>
struct Rows {
    Buffer<std::array<VertexId, Nodes>> nodes = {};
    Buffer<Reference> references = {};
    Buffer<Reference> entities = {};  ///< entity of each row (0: unknown), or empty
    Origin origin = {};

    [[nodiscard]] std::size_t size() const { return nodes.size(); }
};

/// Simplices of degree 1 (`straight`) and 2 (`curved`, with nodes in the order of `local_edges`).
template <int K>
struct Simplices {
    Rows<K + 1> straight;
    Rows<quadratic_nodes<K>> curved;
    Buffer<std::uint32_t> required = {};

    /// Number of simplices that can be referred to by ridges and by `required`. If there are quadratic simplices, only
    /// these can.
    [[nodiscard]] std::size_t indexed() const { return curved.size() == 0 ? straight.size() : curved.size(); }
};

template <int D>
struct Mesh {
    std::string name;
    Buffer<Vec<D>> points;
    Buffer<Reference> point_references;
    Simplices<D> elements;
    Simplices<D - 1> facets;
    Simplices<1> edges;
    Buffer<VertexId> corners = {}, required_vertices = {};
    Buffer<std::uint32_t> ridges = {};
    InputGeometry<D> geometry = {};
    Buffer<Group> groups = {};
    /// Node fields have a row for each point. Cell fields have rows for elements, then facets, then edges. In each
    /// dimension the simplices of degree 2 come first.
    MeshFields fields = {};
    std::function<std::uint64_t(std::size_t point)> number = {};  ///< number of a point in the file; null: point + 1

    [[nodiscard]] std::uint64_t number_of(VertexId point) const {
        return number ? number(point.index()) : point.index() + 1;
    }
    [[nodiscard]] bool quadratic() const {
        return elements.curved.size() + facets.curved.size() + edges.curved.size() > 0;
    }
};

enum class MidNodeKind : std::uint8_t { on_curve, control_point };

/// Builds the mesh from the content of a file, as described at `decode_gmf_mesh`. Precondition: `check` accepts the
/// content. Errors: input (simplices disagree on a mid node).
template <int D>
[[nodiscard]] Outcome<DecodedMesh> assembled(Mesh<D> mesh, MidNodeKind kind, std::vector<Notice> notices,
                                             const Execution& execution);

/// Checks that coordinates are finite, and that the nodes of each simplex exist and are different.
template <int D>
[[nodiscard]] Outcome<Done> check(const Mesh<D>& mesh, const Execution& execution);

/// Entry n says where node n of a simplex in the file belongs in the order of `local_edges`.
template <int K>
using NodeOrder = std::array<int, quadratic_nodes<K>>;

/// Brings the nodes of each simplex into the order of `local_edges`. `order`: order in the file.
template <int K>
[[nodiscard]] Outcome<Done> reorder(Buffer<std::array<VertexId, quadratic_nodes<K>>>& simplices,
                                    const NodeOrder<K>& order, const Execution& execution);

using camber::mid_node_reference;

template <int D, class F>
[[nodiscard]] Outcome<Done> for_each_dimension(const Mesh<D>& mesh, F&& f) {
    auto done = f(mesh.elements);
    if (done) done = f(mesh.facets);
    if constexpr (D == 3)
        if (done) done = f(mesh.edges);
    return done;
}

/// Merges points of different parts that have exactly the same position. `ends`: number of points up to the end of each
/// part. The first point remains, with its reference and field values. Points of one part stay separate, for example on
/// the two sides of a slit. Returns the number of removed points.
template <int D>
std::size_t join_coincident(Mesh<D>& mesh, std::span<const std::size_t> ends);

/// Merges points with equal `numbers`; the first of them remains. Sorts the points by number, and returns how many were
/// removed.
template <int D>
std::size_t join_numbered(Mesh<D>& mesh, std::span<const double> numbers);

// Steps of `assembled` for a mesh of degree 2.

inline constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
inline constexpr std::size_t row_grain = 4096;

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

/// Numbers of vertices in a mesh without mid nodes; their order is that of the file.
struct Renumbering {
    Buffer<std::uint32_t> to_mesh;  ///< for each point of the file its vertex in the mesh; `none` for a mid node
    Buffer<std::uint32_t> to_file;
};

template <int D>
[[nodiscard]] Outcome<Renumbering> without_mid_nodes(const Mesh<D>& raw, const Execution& execution);

/// Builds the mesh of degree 1. Quadratic simplices come first, because `required` and `ridges` index them in this
/// order. Moves data out of `raw`; data at mid nodes is dropped with a notice.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> corner_mesh(Mesh<D>& raw, const Renumbering& numbers, const Execution& execution,
                                                 std::vector<Notice>& notices);

/// Mid node of each edge, and edge of each mid node. If simplices disagree, the lowest number is stored.
struct MidNodes {
    Buffer<std::uint32_t> of_edge;  ///< for each edge: a point of the file, or `none`
    Buffer<std::uint32_t> edge_of;  ///< for each point of the file: an edge, or `none`
};

template <int D>
[[nodiscard]] Outcome<MidNodes> mid_nodes_of(const Mesh<D>& raw, const EdgeSet<D>& edges, const Renumbering& numbers,
                                             const Execution& execution);

}  // namespace camber::listing

namespace camber {

/// Numbers nodes and cells as most formats do. Nodes: vertices, edge nodes. Cells: elements, facets, feature edges;
/// their nodes are in the order of `local_edges`.
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

template <int D, class F>
auto at_cell(const LinearMesh<D>& m, std::size_t c, F&& f) {
    if (c < m.elements.size()) return f(m.elements, c);
    c -= m.elements.size();
    if constexpr (D == 3)
        if (c >= m.facets.size()) return f(m.edges, c - m.facets.size());
    return f(m.facets, c);
}

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

    void find(const SimplexVertices<K>& face, auto&& f) const {
        const std::size_t v = lowest(face).index();
        if (v >= vertices_ || starts_[v] == starts_[v + 1]) return;
        const SimplexVertices<K> key = sorted(face);
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
    Buffer<std::uint32_t> starts_, rows_;
};

}  // namespace camber
