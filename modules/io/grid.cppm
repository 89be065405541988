module;
#include <array>
#include <cstddef>
module camber.io:grid;
import camber.core;
import camber.bezier;
import :listing;

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

}  // namespace camber
