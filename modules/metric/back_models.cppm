module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
export module camber.metric:back_models;
import camber.core;
import camber.box_tree;
import :back_mesh;
import :spd;

namespace camber {

template <int D>
using Barycentrics = std::array<double, D + 1>;

/// Barycentric coordinates u_i of an element, as linear functions of the position x.
export template <int D>
struct ElementFrame {
    std::array<Vec<D>, D + 1> p;
    std::array<Vec<D>, D + 1> gradient;
    int base = 0;
    double determinant = 0;        ///< D! times the signed volume
    double condition_squared = 0;  ///< square of the factor by which rounding errors of coordinates grow in u_i

    ElementFrame(const LinearMesh<D>& mesh, ElementId e) {
        const auto& v = mesh.elements.vertices[e];
        for (int i = 0; i <= D; ++i) p[i] = mesh.points[v[i]];
        Mat<D> sides;
        double lengths_squared = 1;
        for (int i = 0; i < D; ++i) {
            sides.column[i] = p[i + 1] - p[0];
            lengths_squared *= norm_squared(sides.column[i]);
        }
        const auto cofactor = cofactors(sides);
        determinant = dot(cofactor[0], sides.column[0]);
        condition_squared = lengths_squared / (determinant * determinant);
        if (!(condition_squared < 1e8)) {
            measure_slim();
            return;
        }
        const double scale = 1 / determinant;
        gradient[0] = {};
        for (int i = 0; i < D; ++i) {
            gradient[i + 1] = scale * cofactor[i];
            gradient[0] -= gradient[i + 1];
        }
    }

    [[nodiscard]] Barycentrics<D> barycentrics(const Vec<D>& x) const {
        Barycentrics<D> u{};
        const Vec<D> r = x - p[base];
        double rest = 1;
        for (int i = 0; i <= D; ++i) {
            if (i == base) continue;
            u[i] = dot(gradient[i], r);
            rest -= u[i];
        }
        u[base] = rest;
        return u;
    }
    /// A point counts as inside if u_i ≥ −tolerance() for all i. With zero tolerance, rounding could place a point of a
    /// face outside both elements of the face.
    [[nodiscard]] double tolerance() const {
        return condition_squared < 1e4 ? 1e-12 : std::min(1e-14 * std::sqrt(condition_squared), 1e-4);
    }

  private:
    /// Computes the gradients of the barycentric coordinates of a needle-shaped element. Its sides are almost parallel,
    /// so their cross products would consist of rounding errors. Therefore the component along the longest side is
    /// first subtracted from each other side. This preserves the determinant, and the remaining vectors are as exact as
    /// the coordinates.
    void measure_slim() {
        const auto [from, to] = longest_side();
        base = from;
        std::array<int, D> order{to};
        for (int i = 0, n = 1; i <= D && n < D; ++i)
            if (i != from && i != to) order[n++] = i;
        const Vec<D> along = p[to] - p[from];
        Mat<D> sides;
        sides.column[0] = along;
        std::array<double, D> part{};
        for (int k = 1; k < D; ++k) {
            const Vec<D> side = p[order[k]] - p[from];
            part[k] = dot(side, along) / norm_squared(along);
            sides.column[k] = side - part[k] * along;
        }
        const auto cofactor = cofactors(sides);
        determinant = dot(cofactor[0], along);
        const double scale = 1 / determinant;
        for (int k = 0; k < D; ++k) gradient[order[k]] = scale * cofactor[k];
        for (int k = 1; k < D; ++k) gradient[to] -= part[k] * gradient[order[k]];
        gradient[from] = {};
        double steepest = 0;
        for (int k = 0; k < D; ++k) {
            gradient[from] -= gradient[order[k]];
            steepest = std::max(steepest, norm_squared(gradient[order[k]]));
        }
        condition_squared = steepest * norm_squared(along);
    }
    [[nodiscard]] std::array<int, 2> longest_side() const {
        std::array<int, 2> best{0, 1};
        double longest = 0;
        for (int i = 0; i <= D; ++i)
            for (int j = i + 1; j <= D; ++j)
                if (const double l = norm_squared(p[j] - p[i]); l > longest) {
                    longest = l;
                    best = {i, j};
                }
        return best;
    }
};

template <int D>
std::array<Vec<D>, D> face_points(const LinearMesh<D>& mesh, const ElementFace& face) {
    std::array<Vec<D>, D> p;
    const auto local = face_opposite<D>(static_cast<int>(face.opposite));
    for (int i = 0; i < D; ++i) p[i] = mesh.points[mesh.elements.vertices[face.element][local[i]]];
    return p;
}

template <int D>
class StraightBack final : public BackModel<D> {
  public:
    LinearMesh<D> mesh;
    Column<LogMetric<D>> log_metrics;
    Column<LogGradient<D>> nodal_gradients;  ///< volume-weighted means over the elements around each vertex; may be
                                             ///< empty
    Neighbours<D> neighbours;
    Column<ElementFace> boundary;
    BoxTree<D> boundary_tree;

    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const override;
    void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const override;
    void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                               std::span<FieldSample<D>> out) const override;
    void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                         std::span<FieldSample<D>> out) const override;
    void sample_edges(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const override;
    [[nodiscard]] PackedField<D> packed() const override { return {this, nullptr}; }
    [[nodiscard]] std::size_t vertex_count() const override { return mesh.points.size(); }
    [[nodiscard]] BackVertex<D> vertex(VertexId v) const override { return {mesh.points[v], log_metrics[v]}; }
    [[nodiscard]] BackSector<D> sector(ElementId e, VertexId a, VertexId b) const override;

    [[nodiscard]] LogGradient<D> gradient_in(ElementId e) const;
    [[nodiscard]] LogMetric<D> value_at(const Location<D>& location) const;
    [[nodiscard]] LogGradient<D> gradient_at(const Location<D>& location) const;
    [[nodiscard]] LogGradient<D> recovered_gradient_at(const Location<D>& location) const;
};

/// Makes a back mesh without vertex gradients.
template <int D>
[[nodiscard]] Outcome<StraightBack<D>> make_straight_back(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                          Column<LogMetric<D>> log_metrics, const Execution& execution);

template <int D>
struct WeightedGradient {
    LogGradient<D> gradient{};
    double volume = 0;
};
template <int D>
[[nodiscard]] WeightedGradient<D> weighted_gradient(const StraightBack<D>& back, ElementId e);

template <int D>
[[nodiscard]] Outcome<Buffer<LogGradient<D>>> mean_gradients(const StraightBack<D>& back,
                                                             const Incidence<ElementId>& balls,
                                                             const Execution& execution);

/// Unit tangents of a triangle (the first along its first edge), its unit normal, and the gradients of its barycentric
/// coordinates. All are 0 if the area is 0.
struct TriangleFrame {
    std::array<Vec<3>, 2> tangents{};
    Vec<3> normal{};
    std::array<Vec<3>, 3> gradients{};
    double area = 0;
};
[[nodiscard]] TriangleFrame triangle_frame(const std::array<Vec<3>, 3>& p);

[[nodiscard]] inline std::array<Vec<3>, 3> triangle_corners(const LinearMesh<3>& mesh, std::size_t f) {
    const auto& v = mesh.facets.vertices[f];
    return {mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]]};
}

class SurfaceBack final : public BackModel<3> {
  public:
    LinearMesh<3> mesh;
    Column<LogMetric<3>> log_metrics;
    Column<LogGradient<3>> nodal_gradients;  ///< area-weighted means over the triangles around each vertex; may be
                                             ///< empty
    BoxTree<3> tree;

    [[nodiscard]] Location<3> locate(const Vec<3>& p, ElementId hint) const override;
    void sample_values(std::span<const Vec<3>> points, ElementId hint, std::span<FieldSample<3>> out) const override;
    void sample_with_gradients(std::span<const Vec<3>> points, ElementId hint,
                               std::span<FieldSample<3>> out) const override;
    void sample_with_recovered_gradients(std::span<const Vec<3>> points, ElementId hint,
                                         std::span<FieldSample<3>> out) const override;
    void sample_edges(std::span<const BackEdge> edges, std::span<EdgeEnds<3>> out) const override;
    [[nodiscard]] std::size_t vertex_count() const override { return mesh.points.size(); }
    [[nodiscard]] BackVertex<3> vertex(VertexId v) const override { return {mesh.points[v], log_metrics[v]}; }
    [[nodiscard]] BackSector<3> sector(ElementId e, VertexId a, VertexId b) const override;

    [[nodiscard]] LogGradient<3> gradient_in(ElementId triangle) const;
};

[[nodiscard]] Outcome<SurfaceBack> make_surface_back(const LinearMesh<3>& mesh, Column<LogMetric<3>> log_metrics,
                                                     const Execution& execution);

/// Returns at each vertex the area-weighted log-Euclidean mean of the natural metrics of the triangles around it. Along
/// its normal, a triangle's metric has the geometric mean of the in-plane sizes.
[[nodiscard]] Outcome<Buffer<LogMetric<3>>> natural_surface_log_metrics(const LinearMesh<3>& mesh,
                                                                        const Execution& execution);

template <int D>
struct MappedPoint {
    Vec<D> point;
    Mat<D> jacobian;
};

template <int D>
class CurvedBack final : public BackModel<D> {
  public:
    StraightBack<D> reference;
    EdgeSet<D> edges;
    Column<Vec<D>> displacements;  ///< vector from the middle of each edge's chord to the edge node
    /// Gradients of log(Fᵀ M F) for `sample_edges`, one per vertex; may be empty. Each is the volume-weighted mean of
    /// the gradients in the elements around the vertex, transformed to physical space. In an element, log(Fᵀ M F) is
    /// interpolated linearly from the corners.
    Column<LogGradient<D>> relative_gradients;

    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const override;
    void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const override;
    void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                               std::span<FieldSample<D>> out) const override;
    void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                         std::span<FieldSample<D>> out) const override;
    void sample_edges(std::span<const BackEdge> pack, std::span<EdgeEnds<D>> out) const override;
    [[nodiscard]] PackedField<D> packed() const override { return {&reference, this}; }
    [[nodiscard]] std::size_t vertex_count() const override { return reference.vertex_count(); }
    [[nodiscard]] BackVertex<D> vertex(VertexId v) const override { return reference.vertex(v); }
    [[nodiscard]] BackSector<D> sector(ElementId e, VertexId a, VertexId b) const override;

    [[nodiscard]] bool is_curved(ElementId e) const;
    [[nodiscard]] MappedPoint<D> at(const Location<D>& location) const;
};

/// Quadratic K-simplex in D dimensions with the map F, stored relative to its vertex P_0:
///     F(ξ) − P_0 = Σ_i ξ_i d_i + Σ_e 4 ξ_i ξ_j u_e, d_i = P_i − P_0,
/// where u_e is the vector from the middle of the chord of edge e = i–j to the edge node. Since only differences are
/// stored, rounding errors are relative to the size of the element.
template <int K, int D>
struct CurvedSimplex {
    Vec<D> origin;
    std::array<Vec<D>, K + 1> d{};
    std::array<Vec<D>, edges_per_simplex<K>> u{};  ///< u_e in the order of `local_edges`

    [[nodiscard]] Vec<D> point(const std::array<double, K + 1>& xi) const {
        Vec<D> p;
        for (int i = 1; i <= K; ++i) p += xi[i] * d[i];
        for (int e = 0; e < edges_per_simplex<K>; ++e) p += edge_shape<K>(xi, e) * u[e];
        return p;
    }
    /// Returns ∂F/∂ξ_a for a = 1 … K, with ξ_0 = 1 − Σ ξ_a.
    [[nodiscard]] std::array<Vec<D>, K> derivatives(const std::array<double, K + 1>& xi) const {
        std::array<Vec<D>, K + 1> partial = d;
        for (int e = 0; e < edges_per_simplex<K>; ++e) add_edge_derivatives<K>(xi, e, u[e], partial);
        std::array<Vec<D>, K> columns;
        for (int a = 0; a < K; ++a) columns[a] = partial[a + 1] - partial[0];
        return columns;
    }
    /// Returns the second derivatives ∂²F/∂ξ_a ∂ξ_b, which are constant, for a, b = 1 … K.
    [[nodiscard]] std::array<std::array<Vec<D>, K>, K> second() const {
        std::array<std::array<Vec<D>, K + 1>, K + 1> h{};
        for (int e = 0; e < edges_per_simplex<K>; ++e) {
            const auto [i, j] = local_edges<K>[e];
            h[i][j] = h[j][i] = 4 * u[e];
        }
        std::array<std::array<Vec<D>, K>, K> out;
        for (int a = 0; a < K; ++a)
            for (int b = 0; b < K; ++b) out[a][b] = h[a + 1][b + 1] - h[a + 1][0] - h[0][b + 1];
        return out;
    }
    /// Returns the blossom of F − P_0: the symmetric biaffine form with blossom(ξ, ξ) = F(ξ) − P_0. Applied to the
    /// corners of a subsimplex, the blossom yields the Bézier points of the subsimplex, relative to P_0.
    [[nodiscard]] Vec<D> blossom(const std::array<double, K + 1>& a, const std::array<double, K + 1>& b) const {
        Vec<D> p;
        for (int i = 1; i <= K; ++i) p += (0.5 * (a[i] + b[i])) * d[i];
        for (int e = 0; e < edges_per_simplex<K>; ++e) {
            const auto [i, j] = local_edges<K>[e];
            p += (2 * (a[i] * b[j] + a[j] * b[i])) * u[e];
        }
        return p;
    }
    [[nodiscard]] Box<D> box() const {
        Box<D> box;
        for (int i = 0; i <= K; ++i) box.include(origin + d[i]);
        for (int e = 0; e < edges_per_simplex<K>; ++e) {
            const auto [i, j] = local_edges<K>[e];
            box.include(origin + 0.5 * (d[i] + d[j]) + 2 * u[e]);
        }
        for (int c = 0; c < D; ++c) {
            const double blur = 4e-15 * std::max(std::abs(box.low[c]), std::abs(box.high[c]));
            box.low[c] -= blur;
            box.high[c] += blur;
        }
        return box;
    }
};

template <int K, int D>
[[nodiscard]] CurvedSimplex<K, D> curved_simplex(const std::array<Vec<D>, K + 1>& corners,
                                                 const std::array<Vec<D>, edges_per_simplex<K>>& nodes) {
    CurvedSimplex<K, D> s;
    s.origin = corners[0];
    for (int i = 1; i <= K; ++i) s.d[i] = corners[i] - corners[0];
    for (int e = 0; e < edges_per_simplex<K>; ++e) {
        const auto [i, j] = local_edges<K>[e];
        s.u[e] = (nodes[e] - corners[0]) - 0.5 * (s.d[i] + s.d[j]);
    }
    return s;
}

template <int D>
[[nodiscard]] CurvedSimplex<D, D> curved_element(const QuadraticMesh<D>& mesh, ElementId e) {
    std::array<Vec<D>, D + 1> corners;
    std::array<Vec<D>, edges_per_simplex<D>> nodes;
    for (int i = 0; i <= D; ++i) corners[i] = mesh.linear.points[mesh.linear.elements.vertices[e][i]];
    for (int k = 0; k < edges_per_simplex<D>; ++k) nodes[k] = mesh.mid_nodes[mesh.edges.of_elements[e][k]].point;
    return curved_simplex<D, D>(corners, nodes);
}

template <int D>
[[nodiscard]] CurvedSimplex<D - 1, D> curved_face(const QuadraticMesh<D>& mesh, const ElementFace& face) {
    const auto local = face_opposite<D>(static_cast<int>(face.opposite));
    std::array<Vec<D>, D> corners;
    std::array<Vec<D>, edges_per_simplex<D - 1>> nodes;
    for (int i = 0; i < D; ++i) corners[i] = mesh.linear.points[mesh.linear.elements.vertices[face.element][local[i]]];
    for (int k = 0; k < edges_per_simplex<D - 1>; ++k) {
        const auto [i, j] = local_edges<D - 1>[k];
        for (int m = 0; m < edges_per_simplex<D>; ++m) {
            const auto [a, b] = local_edges<D>[m];
            if ((a == local[i] && b == local[j]) || (a == local[j] && b == local[i]))
                nodes[k] = mesh.mid_nodes[mesh.edges.of_elements[face.element][m]].point;
        }
    }
    return curved_simplex<D - 1, D>(corners, nodes);
}

template <int D>
[[nodiscard]] Mat<D> jacobian_at(const CurvedSimplex<D, D>& element, const Barycentrics<D>& xi) {
    return {element.derivatives(xi)};
}

template <int K>
[[nodiscard]] std::array<double, K + 1> moved(const std::array<double, K + 1>& xi, const Vec<K>& step) {
    std::array<double, K + 1> out{};
    double rest = 1;
    for (int i = 1; i <= K; ++i) rest -= out[i] = xi[i] + step[i - 1];
    out[0] = rest;
    return out;
}

template <int D>
struct Root {
    Barycentrics<D> xi{};
    bool is_proven = false;
    double radius = 0;  ///< the equation has exactly one solution within this distance of ξ (maximum norm of ξ_1 … ξ_D)
    double uniqueness = 0;  ///< the equation has no second solution within this larger distance

    /// Bound of the error of ξ.
    [[nodiscard]] double tolerance() const {
        constexpr double least = 1e-12;
        return D * radius > least ? D * radius : least;
    }
    [[nodiscard]] bool is_inside() const {
        if (!is_proven) return false;
        for (const double u : xi)
            if (!(u >= -tolerance())) return false;
        return true;
    }
};

/// Proves by Kantorovich's theorem that F(ξ) = P_0 + r has a solution near `xi`. `inverse` is an approximate inverse
/// Jacobian.
template <int D>
[[nodiscard]] Root<D> proven_root(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& xi,
                                  const Mat<D>& inverse);

/// Result of Newton's method: the last iterate, or the first one if the method did not converge.
template <int D>
struct RootIterate {
    Barycentrics<D> xi{};
    Mat<D> inverse;
    bool has_converged = false;
};
template <int D>
[[nodiscard]] RootIterate<D> newton(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& from);
template <int D>
[[nodiscard]] Root<D> newton_root(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& from);

/// Fast test whether the element may contain the point P_0 + r. Returns false if a plane through this point has all
/// Bézier points of the element on one side.
template <int D>
[[nodiscard]] bool may_contain(const CurvedSimplex<D, D>& element, const Vec<D>& r);

enum class Membership { inside, not_inside, undecided };
template <int D>
struct Found {
    Membership membership = Membership::undecided;
    Root<D> root;
};

/// Searches the element for the point P_0 + r by bisection. Newton's method starts from the centres of the parts. A
/// part is discarded in two cases:
/// - All its Bézier points lie on one side of a plane through the point.
/// - It lies within the uniqueness radius of a proven solution, and this solution is outside the element.
template <int D>
[[nodiscard]] Found<D> find_in_element(const CurvedSimplex<D, D>& element, const Vec<D>& r);

template <int D>
class NodalBack final : public BackModel<D> {
  public:
    CurvedLocator<D> places;
    NodalLogs<D> logs;
    Column<LogGradient<D>> recovered;

    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const override { return places.locate(p, hint); }
    void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const override;
    void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                               std::span<FieldSample<D>> out) const override;
    void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                         std::span<FieldSample<D>> out) const override;
    void sample_edges(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const override;
    [[nodiscard]] std::size_t vertex_count() const override { return places.mesh.linear.points.size(); }
    [[nodiscard]] BackVertex<D> vertex(VertexId v) const override {
        return {places.mesh.linear.points[v], logs.vertices[v]};
    }
    [[nodiscard]] BackSector<D> sector(ElementId e, VertexId a, VertexId b) const override;

    [[nodiscard]] LogMetric<D> value_at(const Location<D>& location) const;
    [[nodiscard]] LogGradient<D> gradient_at(ElementId e, const std::array<double, D + 1>& xi) const;
};

/// Nearest boundary point of a point p. `is_beyond` is true if the nearest point lies in the interior of its face and p
/// lies on the outer side of the face.
template <int D>
struct NearestOnCurved {
    ElementFace face;
    std::array<double, D> xi{};
    bool is_beyond = false;
};
template <int D>
[[nodiscard]] NearestOnCurved<D> nearest_on_boundary(const CurvedLocator<D>& back, const Vec<D>& p);

/// Returns the derivative ∂ξ/∂p of the boundary point nearest to p, one row for each of its coordinates ξ_1 … ξ_D. A
/// nearest point on an edge of a face moves only along this edge; one at a vertex does not move.
template <int D>
[[nodiscard]] std::array<Vec<D>, D> nearest_point_derivative(const CurvedLocator<D>& back, const Location<D>& location,
                                                             const Vec<D>& p);

}  // namespace camber

namespace camber {

template <int D>
[[nodiscard]] ElementId element_or_none(const LinearMesh<D>& mesh, ElementId hint) {
    return hint.valid() && hint.index() < mesh.elements.size() ? hint : ElementId{};
}

/// Returns the location of p if p is bitwise equal to a vertex of `e`. Without this test, rounding would place half of
/// the boundary vertices outside.
template <int D>
[[nodiscard]] std::optional<Location<D>> at_vertex_of(const LinearMesh<D>& mesh, ElementId e, const Vec<D>& p) {
    if (!e.valid()) return {};
    const auto& vertices = mesh.elements.vertices[e];
    for (int i = 0; i <= D; ++i) {
        if (mesh.points[vertices[i]] != p) continue;
        Location<D> there{.element = e, .xi = {}, .placement = Placement::inside};
        there.xi[i] = 1;
        return there;
    }
    return {};
}

/// Returns the Jacobian F = I + 4 Σ_j u_vj ⊗ ∇ξ_j at the corner v of `e`. u_vj is the vector from the middle of the
/// chord v–j to the edge node, and `gradients` are the ∇ξ_j.
template <int D>
[[nodiscard]] Mat<D> jacobian_at_corner(const CurvedBack<D>& back, ElementId e, VertexId v,
                                        const std::array<Vec<D>, D + 1>& gradients);

template <int D>
[[nodiscard]] Outcome<Buffer<LogGradient<D>>> relative_gradients(const CurvedBack<D>& back,
                                                                 const Incidence<ElementId>& balls,
                                                                 const Execution& execution);

inline constexpr std::size_t ball_block = 8192;

/// Considers only elements with a number in [first, last). Calls `visit(v, elements)` for each corner v of `e`, with
/// all these elements around v in ascending order. Corners v for which `e` is not the first of them are skipped.
template <int D>
void visit_balls_of(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls, ElementId e, std::size_t first,
                    std::size_t last, const auto& visit) {
    const auto& corners = mesh.elements.vertices[e];
    for (int k = 0; k <= D; ++k) {
        const VertexId v = corners[k];
        const auto ball = balls[v];
        auto begin = ball.begin();
        if (begin->index() < first) begin = std::lower_bound(begin, ball.end(), ElementId(first));
        if (*begin != e || std::find(corners.begin(), corners.begin() + k, v) != corners.begin() + k) continue;
        auto end = begin;
        while (end != ball.end() && end->index() < last) ++end;
        visit(v, std::span(begin, end));
    }
}

template <std::size_t N>
[[nodiscard]] std::size_t corner_of(const std::array<VertexId, N>& corners, VertexId v) {
    return static_cast<std::size_t>(std::find(corners.begin(), corners.end(), v) - corners.begin());
}

/// Computes a contribution of each element to each of its corners, and adds the contributions at each vertex.
/// - `make(begin, end, parts)` computes the contributions of the elements [begin, end).
/// - `add(v, each_part)` adds contributions to vertex v. `each_part(f)` calls `f(part)` for each contribution, by
///   ascending element.
///
/// Only one thread at a time works on a vertex.
template <class Part, int D>
[[nodiscard]] Outcome<Done> sum_over_balls(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                           const Execution& execution, const auto& make, const auto& add) {
    using Parts = std::array<Part, D + 1>;
    constexpr std::size_t grain = 128;
    const Execution silent = without_progress(execution);
    const std::size_t n = mesh.elements.size();
    return guarded([&]() -> Outcome<Done> {
        Buffer<Parts> parts(std::min(n, ball_block));
        for (std::size_t first = 0; first < n; first += ball_block) {
            const std::size_t last = std::min(n, first + ball_block);
            auto result = each_chunk(
                silent, last - first,
                [&](std::size_t begin, std::size_t end) {
                    make(first + begin, first + end, std::span<Parts>(parts).subspan(begin, end - begin));
                },
                grain);
            if (!result) return result;
            auto added = each(
                silent, last - first,
                [&](std::size_t i) {
                    const auto visit = [&](VertexId v, std::span<const ElementId> elements) {
                        add(v, [&](const auto& take) {
                            for (const ElementId e : elements)
                                take(parts[e.index() - first][corner_of(mesh.elements.vertices[e], v)]);
                        });
                    };
                    visit_balls_of(mesh, balls, ElementId(first + i), first, last, visit);
                },
                grain);
            if (!added) return added;
            report_progress(execution, last, n);
        }
        return Done{};
    });
}

}  // namespace camber
