module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cmath>
#include <string>
#include <utility>
module camber.metric;
import camber.core;

namespace camber {

namespace {

template <int D>
using Barycentrics = std::array<double, D + 1>;

/// The corners of an element, its barycentric coordinates' gradients times its determinant, and that determinant.
template <int D>
struct Frame {
    std::array<Vec<D>, D + 1> p;
    std::array<Vec<D>, D> cofactor;  ///< det · ∇ξ_{i+1}
    double determinant = 0;

    Frame(const LinearMesh<D>& mesh, ElementId e) {
        const auto& v = mesh.elements.vertices[e];
        for (int i = 0; i <= D; ++i) p[i] = mesh.points[v[i]];
        Mat<D> j;
        for (int i = 0; i < D; ++i) j.column[i] = p[i + 1] - p[0];
        cofactor = cofactors(j);
        determinant = dot(cofactor[0], j.column[0]);
    }

    /// u_i(x) with Σ u_i = 1 and u_i(vertex j) = δ_ij.
    [[nodiscard]] Barycentrics<D> barycentrics(const Vec<D>& x) const {
        Barycentrics<D> xi{};
        const Vec<D> r = x - p[0];
        const double scale = 1 / determinant;
        xi[0] = 1;
        for (int i = 0; i < D; ++i) {
            xi[i + 1] = dot(cofactor[i], r) * scale;
            xi[0] -= xi[i + 1];
        }
        return xi;
    }
    /// ∇u_i; the D + 1 of them sum to zero.
    [[nodiscard]] std::array<Vec<D>, D + 1> gradients() const {
        std::array<Vec<D>, D + 1> g{};
        const double scale = 1 / determinant;
        for (int i = 0; i < D; ++i) {
            g[i + 1] = scale * cofactor[i];
            g[0] -= g[i + 1];
        }
        return g;
    }
};

/// Points this near outside of an element (barycentric) count as in it.
constexpr double inside_tolerance = 1e-12;

template <int D>
int lowest(const Barycentrics<D>& xi) {
    return static_cast<int>(std::min_element(xi.begin(), xi.end()) - xi.begin());
}

/// Walks across the face that p lies farthest behind (in barycentric coordinates) until no face hides p. When the walk
/// leaves the mesh or takes too many steps, the best element seen is returned as lost.
template <int D>
Location<D> walk(const BackMesh<D>& back, const Vec<D>& x, ElementId start, int steps) {
    Location<D> best{.element = start, .xi = {}, .placement = Placement::lost};
    double best_lowest = -1e300;
    ElementId at = start;
    for (int step = 0; step < steps; ++step) {
        const Barycentrics<D> xi = Frame<D>(back.mesh, at).barycentrics(x);
        const int worst = lowest<D>(xi);
        if (xi[worst] >= -inside_tolerance) return {at, xi, Placement::inside};
        if (xi[worst] > best_lowest) {
            best_lowest = xi[worst];
            best.element = at;
            best.xi = xi;
        }
        // Behind a boundary face, try the other faces that hide p: the mesh need not be convex.
        ElementId next = back.neighbours[at][worst];
        for (int i = 0; i <= D && !next.valid(); ++i)
            if (xi[i] < -inside_tolerance) next = back.neighbours[at][i];
        if (!next.valid()) break;
        at = next;
    }
    return best;
}

/// The nearest point of a segment (D = 2) or triangle (D = 3), in its barycentric coordinates.
inline std::array<double, 2> nearest_in_face(const std::array<Vec<2>, 2>& p, const Vec<2>& x) {
    const Vec<2> e = p[1] - p[0];
    const double t = std::clamp(dot(x - p[0], e) / norm_squared(e), 0.0, 1.0);
    return {1 - t, t};
}

inline std::array<double, 3> nearest_in_face(const std::array<Vec<3>, 3>& p, const Vec<3>& x) {
    const Vec<3> u = p[1] - p[0];
    const Vec<3> v = p[2] - p[0];
    const Vec<3> r = x - p[0];
    const double uu = dot(u, u);
    const double uv = dot(u, v);
    const double vv = dot(v, v);
    const double det = uu * vv - uv * uv;
    const double b = (vv * dot(u, r) - uv * dot(v, r)) / det;
    const double c = (uu * dot(v, r) - uv * dot(u, r)) / det;
    if (b >= 0 && c >= 0 && b + c <= 1) return {1 - b - c, b, c};
    std::array<double, 3> best{};
    double best_distance = 1e300;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        const Vec<3> e = p[j] - p[i];
        const double t = std::clamp(dot(x - p[i], e) / norm_squared(e), 0.0, 1.0);
        const double d = norm_squared(x - p[i] - t * e);
        if (d >= best_distance) continue;
        best_distance = d;
        best = {};
        best[i] = 1 - t;
        best[j] = t;
    }
    return best;
}

template <int D>
std::array<Vec<D>, D> face_points(const LinearMesh<D>& mesh, const ElementFace& face) {
    std::array<Vec<D>, D> p;
    const auto local = face_opposite<D>(static_cast<int>(face.opposite));
    for (int i = 0; i < D; ++i) p[i] = mesh.points[mesh.elements.vertices[face.element][local[i]]];
    return p;
}

template <int D>
struct NearestOnBoundary {
    ElementFace face;
    std::array<double, D> xi{};
};

template <int D>
NearestOnBoundary<D> nearest_on_boundary(const BackMesh<D>& back, const Vec<D>& x) {
    const auto nearest = back.boundary_tree.nearest(x, [&](std::size_t f) {
        const auto p = face_points<D>(back.mesh, back.boundary[f]);
        const auto xi = nearest_in_face(p, x);
        Vec<D> q;
        for (int i = 0; i < D; ++i) q += xi[i] * p[i];
        return norm_squared(x - q);
    });
    const ElementFace face = back.boundary[nearest.item];
    return {face, nearest_in_face(face_points<D>(back.mesh, face), x)};
}

template <int D>
Location<D> on_face(const NearestOnBoundary<D>& nearest) {
    Location<D> location{.element = nearest.face.element, .xi = {}, .placement = Placement::outside};
    const auto local = face_opposite<D>(static_cast<int>(nearest.face.opposite));
    for (int i = 0; i < D; ++i) location.xi[local[i]] = nearest.xi[i];
    return location;
}

constexpr int short_walk = 64;
constexpr int long_walk = 100000;

template <int D>
Location<D> clamped(Location<D> location) {
    double sum = 0;
    for (double& u : location.xi) sum += u = std::max(u, 0.0);
    for (double& u : location.xi) u /= sum;
    return location;
}

/// log M(ξ) = Σ ξ_i log M_i (paper §1.2).
template <int D>
LogMetric<D> interpolated(const Column<LogMetric<D>>& column, const SimplexVertices<D>& v, const Barycentrics<D>& xi) {
    LogMetric<D> value{xi[0] * column[v[0]].l};
    for (int i = 1; i <= D; ++i) value.l += xi[i] * column[v[i]].l;
    return value;
}

/// Beyond the boundary the field is constant along the line to the nearest point: only the part of its gradient along
/// the face (or edge, or vertex) on which that point lies remains.
template <int D>
LogGradient<D> along_support(const LogGradient<D>& g, const BackMesh<D>& back, const Location<D>& location) {
    const auto& v = back.mesh.elements.vertices[location.element];
    std::array<Vec<D>, D + 1> support{};
    int n = 0;
    for (int i = 0; i <= D; ++i)
        if (location.xi[i] > 0) support[n++] = back.mesh.points[v[i]];
    // Orthonormal directions of the support by Gram–Schmidt.
    std::array<Vec<D>, D> basis{};
    int rank = 0;
    for (int i = 1; i < n && rank < D; ++i) {
        Vec<D> d = support[i] - support[0];
        for (int k = 0; k < rank; ++k) d -= dot(d, basis[k]) * basis[k];
        if (norm(d) > 0) basis[rank++] = normalised(d);
    }
    LogGradient<D> out{};
    for (int k = 0; k < rank; ++k) {
        Sym<D> along;
        for (int j = 0; j < D; ++j) along += basis[k][j] * g[j];
        for (int i = 0; i < D; ++i) out[i] += basis[k][i] * along;
    }
    return out;
}

}  // namespace

template <int D>
std::array<Vec<D>, D + 1> barycentric_gradients(const LinearMesh<D>& mesh, ElementId e) {
    return Frame<D>(mesh, e).gradients();
}

template <int D>
LogGradient<D> field_gradient(const BackMesh<D>& back, ElementId e) {
    const auto& v = back.mesh.elements.vertices[e];
    const auto gradients = barycentric_gradients(back.mesh, e);
    LogGradient<D> g{};
    for (int a = 1; a <= D; ++a) {
        const Sym<D> difference = back.log_metrics[v[a]].l - back.log_metrics[v[0]].l;
        for (int i = 0; i < D; ++i) g[i] += gradients[a][i] * difference;
    }
    return g;
}

template <int D>
Outcome<BackMesh<D>> make_back_mesh(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                    Column<LogMetric<D>> log_metrics, const Execution& execution) {
    if (log_metrics.size() != mesh.points.size())
        return fail(ErrorKind::input,
                    "the metric has " + std::to_string(log_metrics.size()) + " rows, the mesh " +
                        std::to_string(mesh.points.size()) + " vertices",
                    {}, {}, "give the metric of this mesh");
    BackMesh<D> back;
    back.mesh = mesh;
    back.log_metrics = std::move(log_metrics);
    auto across = neighbours(mesh, balls, execution);
    if (!across) return fail(across.error());
    back.neighbours = std::move(*across);
    back.boundary = boundary_faces<D>(back.neighbours);
    Buffer<Box<D>> boxes(back.boundary.size());
    for (std::size_t f = 0; f < boxes.size(); ++f) {
        boxes[f] = {};
        for (const Vec<D>& p : face_points<D>(mesh, back.boundary[f])) boxes[f].include(p);
    }
    back.boundary_tree = BoxTree<D>(boxes);
    auto gradients = map_each(execution, mesh.points.size(), [&](std::size_t v) {
        LogGradient<D> sum{};
        double weight = 0;
        for (const ElementId e : balls[v]) {
            const double volume = std::abs(Frame<D>(mesh, e).determinant);
            if (!(volume > 0)) continue;
            const LogGradient<D> g = field_gradient(back, e);
            for (int i = 0; i < D; ++i) sum[i] += volume * g[i];
            weight += volume;
        }
        if (weight > 0)
            for (Sym<D>& g : sum) g *= 1 / weight;
        return sum;
    });
    if (!gradients) return fail(gradients.error());
    back.nodal_gradients = std::move(*gradients);
    return back;
}

template <int D>
Location<D> locate(const BackMesh<D>& back, const Vec<D>& p, ElementId hint) {
    const Location<D> near = walk(back, p, hint, short_walk);
    if (near.placement == Placement::inside) return near;
    const NearestOnBoundary<D> nearest = nearest_on_boundary(back, p);
    // A ball around p that reaches to its nearest boundary point holds no boundary: seen from there nothing hides p.
    const Barycentrics<D> xi = Frame<D>(back.mesh, nearest.face.element).barycentrics(p);
    if (xi[nearest.face.opposite] < 0) return on_face<D>(nearest);
    const Location<D> far = walk(back, p, nearest.face.element, long_walk);
    if (far.placement == Placement::inside) return far;
    // At a sharp concave vertex or edge several faces are equally near, and the one found may not face p.
    const Location<D> best = lowest<D>(far.xi) >= 0 || far.xi[lowest<D>(far.xi)] > near.xi[lowest<D>(near.xi)] ? far : near;
    return best.xi[lowest<D>(best.xi)] > -1e-6 ? clamped<D>(best) : on_face<D>(nearest);
}

template <int D>
FieldSample<D> sample_value(const BackMesh<D>& back, const Vec<D>& p, ElementId hint) {
    FieldSample<D> s;
    s.location = locate(back, p, hint);
    s.log_metric = interpolated<D>(back.log_metrics, back.mesh.elements.vertices[s.location.element], s.location.xi);
    return s;
}

template <int D>
FieldSample<D> sample_with_gradient(const BackMesh<D>& back, const Vec<D>& p, ElementId hint) {
    FieldSample<D> s = sample_value(back, p, hint);
    s.gradient = field_gradient(back, s.location.element);
    if (s.location.placement != Placement::inside) s.gradient = along_support<D>(s.gradient, back, s.location);
    return s;
}

template <int D>
FieldSample<D> sample_with_recovered_gradient(const BackMesh<D>& back, const Vec<D>& p, ElementId hint) {
    FieldSample<D> s = sample_value(back, p, hint);
    const auto& v = back.mesh.elements.vertices[s.location.element];
    for (int a = 0; a <= D; ++a)
        for (int i = 0; i < D; ++i) s.gradient[i] += s.location.xi[a] * back.nodal_gradients[v[a]][i];
    return s;
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<BackMesh<D>> make_back_mesh<D>(const LinearMesh<D>&, const Incidence<ElementId>&,                \
                                                    Column<LogMetric<D>>, const Execution&);                          \
    template std::array<Vec<D>, D + 1> barycentric_gradients<D>(const LinearMesh<D>&, ElementId);                     \
    template LogGradient<D> field_gradient<D>(const BackMesh<D>&, ElementId);                                         \
    template Location<D> locate<D>(const BackMesh<D>&, const Vec<D>&, ElementId);                                     \
    template FieldSample<D> sample_value<D>(const BackMesh<D>&, const Vec<D>&, ElementId);                            \
    template FieldSample<D> sample_with_gradient<D>(const BackMesh<D>&, const Vec<D>&, ElementId);                    \
    template FieldSample<D> sample_with_recovered_gradient<D>(const BackMesh<D>&, const Vec<D>&, ElementId);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
