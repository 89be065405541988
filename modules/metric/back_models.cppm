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

/// The barycentric coordinates of an element as functions: u_i(x) with Σ u_i = 1 and u_i(vertex j) = δ_ij.
export template <int D>
struct ElementFrame {
    std::array<Vec<D>, D + 1> p;         ///< the corners
    std::array<Vec<D>, D + 1> gradient;  ///< ∇u_i; they sum to zero
    int base = 0;                        ///< the vertex that points are measured from
    double determinant = 0;              ///< ± D! times the volume
    double condition_squared = 0;        ///< of what multiplies rounding errors in u

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
    /// Points this near outside of the element (barycentric) count as in it: what rounding may do to the coordinates of
    /// a point of the element, so that a point on a face is in one of its two elements at least.
    [[nodiscard]] double tolerance() const {
        return condition_squared < 1e4 ? 1e-12 : std::min(1e-14 * std::sqrt(condition_squared), 1e-4);
    }

  private:
    /// The sides of a needle are all but parallel, and their cross products rounding errors. So the longest side's part
    /// is taken off the others first (a shear, which keeps the determinant): what is left is the needle's thickness, to
    /// the digits that the coordinates have.
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

/// The corners of a face of an element.
template <int D>
std::array<Vec<D>, D> face_points(const LinearMesh<D>& mesh, const ElementFace& face) {
    std::array<Vec<D>, D> p;
    const auto local = face_opposite<D>(static_cast<int>(face.opposite));
    for (int i = 0; i < D; ++i) p[i] = mesh.points[mesh.elements.vertices[face.element][local[i]]];
    return p;
}

/// The back mesh that is straight, with all that location needs.
template <int D>
class StraightBack final : public BackModel<D> {
  public:
    LinearMesh<D> mesh;
    Column<LogMetric<D>> log_metrics;        ///< at the vertices
    Column<LogGradient<D>> nodal_gradients;  ///< volume-weighted means over the balls: they do not jump; or none
    Neighbours<D> neighbours;
    Column<ElementFace> boundary;
    BoxTree<D> boundary_tree;  ///< boxes of `boundary`

    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const override;
    void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const override;
    void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                               std::span<FieldSample<D>> out) const override;
    void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                         std::span<FieldSample<D>> out) const override;
    void see(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const override;
    [[nodiscard]] PackedField<D> packed() const override { return {this, nullptr}; }
    [[nodiscard]] std::size_t vertex_count() const override { return mesh.points.size(); }
    [[nodiscard]] BackVertex<D> vertex(VertexId v) const override { return {mesh.points[v], log_metrics[v]}; }
    [[nodiscard]] BackSector<D> sector(ElementId e, VertexId a, VertexId b) const override;

    /// ∂ log M in one element, where it is constant: ∂_i log M = Σ_j ∂_i u_j log M_j.
    [[nodiscard]] LogGradient<D> gradient_in(ElementId e) const;
    /// log M = Σ ξ_i log M_i (paper §1.2), and its gradients, as they are sampled at points with that location.
    [[nodiscard]] LogMetric<D> value_at(const Location<D>& location) const;
    [[nodiscard]] LogGradient<D> gradient_at(const Location<D>& location) const;
    [[nodiscard]] LogGradient<D> recovered_gradient_at(const Location<D>& location) const;
};

/// With what location needs, but no gradients at the vertices. Errors: those of make_back_mesh.
template <int D>
[[nodiscard]] Outcome<StraightBack<D>> make_straight_back(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                          Column<LogMetric<D>> log_metrics, const Execution& execution);

/// The gradient in an element times its volume, and the volume (both D! times).
template <int D>
struct WeightedGradient {
    LogGradient<D> gradient{};
    double volume = 0;
};
template <int D>
[[nodiscard]] WeightedGradient<D> weighted_gradient(const StraightBack<D>& back, ElementId e);

/// The gradients of a straight back mesh, of each vertex the mean over its ball, weighted by volume. Errors: memory,
/// stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LogGradient<D>>> mean_gradients(const StraightBack<D>& back,
                                                             const Incidence<ElementId>& balls,
                                                             const Execution& execution);

/// A triangle's unit tangents (the first along its first edge) and normal, and the gradients of its barycentric
/// coordinates; all 0 where it has no area.
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

/// The back mesh of a surface alone: log-metrics at its vertices, linear in each triangle; a point of space has the
/// values of the nearest point of the triangles, so that the field is constant along their normals, and its gradient
/// has no part there.
class SurfaceBack final : public BackModel<3> {
  public:
    LinearMesh<3> mesh;
    Column<LogMetric<3>> log_metrics;
    Column<LogGradient<3>> nodal_gradients;  ///< area-weighted means over the balls; or none
    BoxTree<3> tree;                         ///< of the triangles

    [[nodiscard]] Location<3> locate(const Vec<3>& p, ElementId hint) const override;
    void sample_values(std::span<const Vec<3>> points, ElementId hint, std::span<FieldSample<3>> out) const override;
    void sample_with_gradients(std::span<const Vec<3>> points, ElementId hint,
                               std::span<FieldSample<3>> out) const override;
    void sample_with_recovered_gradients(std::span<const Vec<3>> points, ElementId hint,
                                         std::span<FieldSample<3>> out) const override;
    void see(std::span<const BackEdge> edges, std::span<EdgeEnds<3>> out) const override;
    [[nodiscard]] std::size_t vertex_count() const override { return mesh.points.size(); }
    [[nodiscard]] BackVertex<3> vertex(VertexId v) const override { return {mesh.points[v], log_metrics[v]}; }
    [[nodiscard]] BackSector<3> sector(ElementId e, VertexId a, VertexId b) const override;

    [[nodiscard]] LogGradient<3> gradient_in(ElementId triangle) const;
};

/// Without gradients at the vertices where they are not asked for. Errors: a column of another size; stopped.
[[nodiscard]] Outcome<SurfaceBack> make_surface_back(const LinearMesh<3>& mesh, Column<LogMetric<3>> log_metrics,
                                                     const Execution& execution);

/// The natural metric of a surface alone at its vertices, the log-Euclidean mean over the triangles around, weighted by
/// area: in a triangle's plane the metric for which its edges have length 1; along its normal the geometric mean of the
/// two sizes there, for nothing of the mesh tells another. Vertices without triangles get the identity metric.
[[nodiscard]] Outcome<Buffer<LogMetric<3>>> natural_surface_log_metrics(const LinearMesh<3>& mesh,
                                                                        const Execution& execution);

/// A place in the reference mesh, and the map there.
template <int D>
struct Bent {
    Vec<D> point;     ///< x
    Mat<D> jacobian;  ///< F = ∂x/∂X
};

/// The back mesh of degree 2: a straight one, its reference, and the displacement of the nodes.
template <int D>
class CurvedBack final : public BackModel<D> {
  public:
    StraightBack<D> reference;
    EdgeSet<D> edges;
    Column<Vec<D>> displacements;  ///< u_e
    /// At the vertices, means over the balls of what the elements see: the gradient of log(Fᵀ M F), linear in each,
    /// brought into space by the map there; or none.
    Column<LogGradient<D>> relative_gradients;

    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const override;
    void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const override;
    void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                               std::span<FieldSample<D>> out) const override;
    void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                         std::span<FieldSample<D>> out) const override;
    void see(std::span<const BackEdge> pack, std::span<EdgeEnds<D>> out) const override;
    [[nodiscard]] PackedField<D> packed() const override { return {&reference, this}; }
    [[nodiscard]] std::size_t vertex_count() const override { return reference.vertex_count(); }
    [[nodiscard]] BackVertex<D> vertex(VertexId v) const override { return reference.vertex(v); }
    [[nodiscard]] BackSector<D> sector(ElementId e, VertexId a, VertexId b) const override;

    [[nodiscard]] bool is_bent(ElementId e) const;
    [[nodiscard]] Bent<D> at(const Location<D>& location) const;
};

/// A K-simplex of degree 2 in D dimensions, from its vertex 0:
///   F(ξ) − P_0 = Σ_i ξ_i d_i + Σ_e 4 ξ_i ξ_j u_e,  d_i = P_i − P_0,  u_e = how far e's node is off its chord's middle.
/// Only differences of stored numbers occur, so errors are relative to the element and not to its place.
template <int K, int D>
struct CurvedSimplex {
    Vec<D> origin;
    std::array<Vec<D>, K + 1> d{};                 ///< d_0 = 0
    std::array<Vec<D>, edges_per_simplex<K>> u{};  ///< in the order of `local_edges`

    [[nodiscard]] Vec<D> point(const std::array<double, K + 1>& xi) const {
        Vec<D> p;
        for (int i = 1; i <= K; ++i) p += xi[i] * d[i];
        for (int e = 0; e < edges_per_simplex<K>; ++e) p += edge_shape<K>(xi, e) * u[e];
        return p;
    }
    /// ∂F/∂ξ_a for a = 1 … K, with ξ_0 = 1 − Σ ξ_a.
    [[nodiscard]] std::array<Vec<D>, K> derivatives(const std::array<double, K + 1>& xi) const {
        std::array<Vec<D>, K + 1> partial = d;
        for (int e = 0; e < edges_per_simplex<K>; ++e) add_edge_derivatives<K>(xi, e, u[e], partial);
        std::array<Vec<D>, K> columns;
        for (int a = 0; a < K; ++a) columns[a] = partial[a + 1] - partial[0];
        return columns;
    }
    /// ∂²F/∂ξ_a ∂ξ_b, a, b = 1 … K, which is constant.
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
    /// The blossom: F(ξ) − P_0 = blossom(ξ, ξ), linear in each. At the corners of a part of the simplex it has the
    /// part's Bézier points.
    [[nodiscard]] Vec<D> blossom(const std::array<double, K + 1>& a, const std::array<double, K + 1>& b) const {
        Vec<D> p;
        for (int i = 1; i <= K; ++i) p += (0.5 * (a[i] + b[i])) * d[i];
        for (int e = 0; e < edges_per_simplex<K>; ++e) {
            const auto [i, j] = local_edges<K>[e];
            p += (2 * (a[i] * b[j] + a[j] * b[i])) * u[e];
        }
        return p;
    }
    /// A box of the Bézier points, and of what rounding may have done to them.
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

/// The simplex of these corners and nodes.
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

/// Element e of the mesh.
template <int D>
[[nodiscard]] CurvedSimplex<D, D> curved_element(const QuadraticMesh<D>& mesh, ElementId e) {
    std::array<Vec<D>, D + 1> corners;
    std::array<Vec<D>, edges_per_simplex<D>> nodes;
    for (int i = 0; i <= D; ++i) corners[i] = mesh.linear.points[mesh.linear.elements.vertices[e][i]];
    for (int k = 0; k < edges_per_simplex<D>; ++k) nodes[k] = mesh.mid_nodes[mesh.edges.of_elements[e][k]].point;
    return curved_simplex<D, D>(corners, nodes);
}

/// The curved face of an element, with the corners of `face_opposite`.
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

/// ξ with ξ_0 made of the others.
template <int K>
[[nodiscard]] std::array<double, K + 1> moved(const std::array<double, K + 1>& xi, const Vec<K>& step) {
    std::array<double, K + 1> out{};
    double rest = 1;
    for (int i = 1; i <= K; ++i) rest -= out[i] = xi[i] + step[i - 1];
    out[0] = rest;
    return out;
}

/// A solution of F(ξ) = P_0 + r, near which it is known to be.
template <int D>
struct Root {
    Barycentrics<D> xi{};
    bool is_proven = false;
    double radius = 0;      ///< exactly one solution lies within it of ξ, by the largest of ξ_1 … ξ_D
    double uniqueness = 0;  ///< and there is no other within this

    /// How far below zero a coordinate may be of a point of the element: what rounding may have done to it.
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

/// What is known of ξ as a solution, with an approximate inverse of the Jacobian: Kantorovich's theorem, in coordinates
/// in which a thin element that bends away by many thicknesses looks round.
template <int D>
[[nodiscard]] Root<D> proven_root(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& xi,
                                  const Mat<D>& inverse);

/// Where Newton's method from ξ ends; where it does not, its first iterate: the element's linear map there.
template <int D>
struct RootIterate {
    Barycentrics<D> xi{};
    Mat<D> inverse;  ///< of the Jacobian a step before
    bool has_converged = false;
};
template <int D>
[[nodiscard]] RootIterate<D> newton(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& from);
/// The same with its proof.
template <int D>
[[nodiscard]] Root<D> newton_root(const CurvedSimplex<D, D>& element, const Vec<D>& r, const Barycentrics<D>& from);

/// False where all Bézier points of the element lie on one side of the point: a quick look.
template <int D>
[[nodiscard]] bool may_hold(const CurvedSimplex<D, D>& element, const Vec<D>& r);

/// Whether a point lies in an element.
enum class Membership { inside, not_inside, undecided };
template <int D>
struct Found {
    Membership membership = Membership::undecided;
    Root<D> root;
};

/// By bisection of the element: of each part either all Bézier points lie on one side of the point in some direction,
/// or Newton's method finds a solution from its centre; one outside whose ball of uniqueness holds the part leaves none
/// in it.
template <int D>
[[nodiscard]] Found<D> find_in_element(const CurvedSimplex<D, D>& element, const Vec<D>& r);

/// The back mesh of make_nodal_back_mesh.
template <int D>
class NodalBack final : public BackModel<D> {
  public:
    CurvedLocator<D> places;
    NodalLogs<D> logs;
    Column<LogGradient<D>> recovered;  ///< at the vertices: means over the balls, by volume

    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const override { return places.locate(p, hint); }
    void sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const override;
    void sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                               std::span<FieldSample<D>> out) const override;
    void sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                         std::span<FieldSample<D>> out) const override;
    void see(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const override;
    [[nodiscard]] std::size_t vertex_count() const override { return places.mesh.linear.points.size(); }
    [[nodiscard]] BackVertex<D> vertex(VertexId v) const override {
        return {places.mesh.linear.points[v], logs.vertices[v]};
    }
    [[nodiscard]] BackSector<D> sector(ElementId e, VertexId a, VertexId b) const override;

    [[nodiscard]] LogMetric<D> value_at(const Location<D>& location) const;
    /// ∂ log M in space, as the element has it at ξ.
    [[nodiscard]] LogGradient<D> gradient_at(ElementId e, const std::array<double, D + 1>& xi) const;
};

/// The boundary point that is nearest to p: its face, its coordinates there, and whether p is seen to lie beyond it
/// (where it is within the face, and p on the outer side).
template <int D>
struct NearestOnCurved {
    ElementFace face;
    std::array<double, D> xi{};
    bool is_beyond = false;
};
template <int D>
[[nodiscard]] NearestOnCurved<D> nearest_on_boundary(const CurvedLocator<D>& back, const Vec<D>& p);

/// How the nearest point of a face moves with p, in its ξ_1 … ξ_{D−1}: ∂ξ/∂p, a row each, zero for what does not move
/// since the point is on the face's boundary.
template <int D>
[[nodiscard]] std::array<Vec<D>, D> slide_along_face(const CurvedLocator<D>& back, const Location<D>& location,
                                                     const Vec<D>& p);

}  // namespace camber

/// What is known of a point before it is looked for.
namespace camber {

/// A hint comes of whatever mesh: one that is no element of this is none.
template <int D>
[[nodiscard]] ElementId element_or_none(const LinearMesh<D>& mesh, ElementId hint) {
    return hint.valid() && hint.index() < mesh.elements.size() ? hint : ElementId{};
}

/// A point that is a vertex of the element to the last bit is there. Vertices of a mesh are asked for in the field that
/// lives on it; at walls rounding would put half of them beyond.
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

/// F = I + 4 Σ_j u_vj ⊗ ∇ξ_j at the corner v of an element; `gradients`: barycentric_gradients.
template <int D>
[[nodiscard]] Mat<D> jacobian_at_corner(const CurvedBack<D>& back, ElementId e, VertexId v,
                                        const std::array<Vec<D>, D + 1>& gradients);

/// Relative gradients of a curved back mesh (see CurvedBack): of each vertex the mean over its ball, weighted by
/// volume, of the gradients of log(Fᵀ M F), linear in the elements, each brought into space by the map at its corner.
/// Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LogGradient<D>>> relative_gradients(const CurvedBack<D>& back,
                                                                 const Incidence<ElementId>& balls,
                                                                 const Execution& execution);

/// Elements whose parts are in memory at a time: enough for many threads, few enough for a processor's own cache.
inline constexpr std::size_t ball_block = 8192;

/// Of the balls that touch the elements [first, last), those whose first one there is `e`: visit(v, others) with their
/// elements there, by rising number.
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

/// Which corner of an element v is.
template <std::size_t N>
[[nodiscard]] std::size_t corner_of(const std::array<VertexId, N>& corners, VertexId v) {
    return static_cast<std::size_t>(std::find(corners.begin(), corners.end(), v) - corners.begin());
}

/// Sums over the balls of vertices: make(begin, end, parts) says what the elements [begin, end) have to add at each of
/// their corners; add(v, each_part) adds some of them to the sum of vertex v: each_part(f) calls f(part) by rising
/// element, and a vertex is one thread's at a time. Block by block, so that what all elements have to add is never in
/// memory.
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
            auto made = each_chunk(
                silent, last - first,
                [&](std::size_t begin, std::size_t end) {
                    make(first + begin, first + end, std::span<Parts>(parts).subspan(begin, end - begin));
                },
                grain);
            if (!made) return made;
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
