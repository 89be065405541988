module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
module camber.metric;
import :surface_back;
import :seen_gradients;
import camber.core;

namespace camber {

namespace {

/// Newton's method ends with a step that is less than this of the element (barycentric): what is left is its square.
constexpr double small_step = 1e-5;
constexpr int max_steps = 10;

/// a + b ⊗ c.
template <int D>
void add_outer(Mat<D>& a, const Vec<D>& b, const Vec<D>& c) {
    for (int i = 0; i < D; ++i) a.column[i] += c[i] * b;
}

template <int D>
void add(Mat<D>& sum, const Mat<D>& a) {
    for (int i = 0; i < D; ++i) sum.column[i] += a.column[i];
}

/// A gradient in the reference as one in space: ∂_i = Σ_j (F⁻¹)_ji ∂_Xj.
template <int D>
LogGradient<D> in_space(const LogGradient<D>& gradient, const Mat<D>& jacobian) {
    const Mat<D> back = inverse(jacobian);
    LogGradient<D> out{};
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) out[i] += back(j, i) * gradient[j];
    return out;
}

/// The point of the reference mesh that has this location.
template <int D>
Vec<D> reference_point(const CurvedBack<D>& back, const Location<D>& location) {
    const auto& v = back.reference.mesh.elements.vertices[location.element];
    // From a corner and not from the origin, which may be far away.
    const Vec<D>& from = back.reference.mesh.points[v[0]];
    Vec<D> p = from;
    for (int i = 1; i <= D; ++i) p += location.xi[i] * (back.reference.mesh.points[v[i]] - from);
    return p;
}

/// The step's largest part in the barycentric coordinates of an element.
template <int D>
double share_of_element(const std::array<Vec<D>, D + 1>& gradients, const Vec<D>& step) {
    double most = 0;
    for (const Vec<D>& gradient : gradients) most = std::max(most, std::abs(dot(gradient, step)));
    return most;
}

/// Σ 4 ξ_i ξ_j u_e in the middle of an element: where stacks of thin ones move together, nearly that of its neighbours.
template <int D>
Vec<D> displacement_at_centre(const CurvedBack<D>& back, ElementId e) {
    Vec<D> sum;
    for (const EdgeId edge : back.edges.of_elements[e]) sum += back.displacements[edge];
    return (4.0 / ((D + 1) * (D + 1))) * sum;
}

}  // namespace

template <int D>
bool CurvedBack<D>::is_bent(ElementId e) const {
    return std::ranges::any_of(edges.of_elements[e], [&](EdgeId edge) { return displacements[edge] != Vec<D>{}; });
}

template <int D>
Bent<D> CurvedBack<D>::at(const Location<D>& location) const {
    Bent<D> bent{reference_point(*this, location), Mat<D>::identity()};
    const auto gradients = barycentric_gradients(reference.mesh, location.element);
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const Vec<D>& u = displacements[edges.of_elements[location.element][k]];
        if (u == Vec<D>{}) continue;
        const auto [i, j] = local_edges<D>[k];
        bent.point += (4 * location.xi[i] * location.xi[j]) * u;
        add_outer(bent.jacobian, 4 * u, location.xi[i] * gradients[j] + location.xi[j] * gradients[i]);
    }
    return bent;
}

template <int D>
Location<D> CurvedBack<D>::locate(const Vec<D>& p, ElementId hint) const {
    if (!is_finite(p)) return reference.locate(p, hint);
    Vec<D> seen = hint.valid() ? p - displacement_at_centre(*this, hint) : p;
    Location<D> found = reference.locate(seen, hint);
    if (found.placement != Placement::inside) seen = reference_point(*this, found);
    for (int step = 0; step < max_steps; ++step) {
        const Bent<D> bent = at(found);
        const Vec<D> move = inverse(bent.jacobian) * (p - bent.point);
        if (!is_finite(move)) break;
        const auto gradients = barycentric_gradients(reference.mesh, found.element);
        if (found.placement == Placement::inside && share_of_element<D>(gradients, move) < small_step) {
            for (int i = 0; i <= D; ++i) found.xi[i] += dot(gradients[i], move);
            break;
        }
        found = reference.locate(seen + move, found.element);
        const Vec<D> before = seen;
        seen = found.placement == Placement::inside ? seen + move : reference_point(*this, found);
        if (found.placement != Placement::inside && share_of_element<D>(gradients, seen - before) < small_step) break;
    }
    return found;
}

template <int D>
void CurvedBack<D>::sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const {
    for (std::size_t n = 0; n < points.size(); ++n) {
        out[n].location = locate(points[n], hint);
        hint = out[n].location.element;
        out[n].log_metric = reference.value_at(out[n].location);
    }
}

template <int D>
void CurvedBack<D>::sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                                          std::span<FieldSample<D>> out) const {
    sample_values(points, hint, out);
    for (FieldSample<D>& s : out) s.gradient = in_space<D>(reference.gradient_at(s.location), at(s.location).jacobian);
}

template <int D>
void CurvedBack<D>::sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                                    std::span<FieldSample<D>> out) const {
    sample_values(points, hint, out);
    for (FieldSample<D>& s : out)
        s.gradient = in_space<D>(reference.recovered_gradient_at(s.location), at(s.location).jacobian);
}

template <int D>
void CurvedBack<D>::see(std::span<const BackEdge> pack, std::span<EdgeEnds<D>> out) const {
    for (std::size_t i = 0; i < pack.size(); ++i) {
        const auto& [a, b, shell] = pack[i];
        out[i] = {{reference.log_metrics[a]}, {reference.log_metrics[b]}, std::ranges::any_of(shell, [&](ElementId e) {
                      return is_bent(e);
                  })};
        if (!relative_gradients.empty()) {
            out[i].a.gradient = relative_gradients[a];
            out[i].b.gradient = relative_gradients[b];
        }
        if (!out[i].is_bent) continue;
        out[i].a.jacobian = out[i].b.jacobian = {};
        for (const ElementId e : shell) {
            const auto gradients = barycentric_gradients(reference.mesh, e);
            add(out[i].a.jacobian, jacobian_at_corner<D>(*this, e, a, gradients));
            add(out[i].b.jacobian, jacobian_at_corner<D>(*this, e, b, gradients));
        }
        for (EdgeEnd<D>* end : {&out[i].a, &out[i].b})
            for (Vec<D>& column : end->jacobian.column) column *= 1.0 / static_cast<double>(shell.size());
    }
}

template <int D>
BackSector<D> CurvedBack<D>::sector(ElementId e, VertexId a, VertexId b) const {
    BackSector<D> sector = reference.sector(e, a, b);
    if (!is_bent(e)) return sector;
    Location<D> middle{.element = e, .xi = {}};
    for (int i = 0; i <= D; ++i)
        if (const VertexId v = reference.mesh.elements.vertices[e][i]; v == a || v == b) middle.xi[i] = 0.5;
    const Mat<D> jacobian = at(middle).jacobian;
    sector.gradient = in_space<D>(sector.gradient, jacobian);
    const Mat<D> back = transposed(inverse(jacobian));
    for (Vec<D>& wall : sector.walls) wall = back * wall;
    return sector;
}

template <int D>
Outcome<BackMesh<D>> make_curved_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                           Column<LogMetric<D>> log_metrics, const Execution& execution,
                                           KeptGradients kept) {
    // A surface is near its triangles, and its field does not change along their normals.
    if (is_surface_alone(mesh.linear)) return make_back_mesh(mesh.linear, balls, std::move(log_metrics), execution);
    auto displacements = map_each(part_of(execution, 0, 0.03), mesh.edges.size(), [&](std::size_t e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        return mesh.mid_nodes[e].point - midpoint(mesh.linear.points[a], mesh.linear.points[b]);
    });
    if (!displacements) return fail(displacements.error());
    mesh.mid_nodes = {};
    if (std::ranges::all_of(*displacements, [](const Vec<D>& u) { return u == Vec<D>{}; }))
        return make_back_mesh(mesh.linear, balls, std::move(log_metrics), part_of(execution, 0.03, 1));
    auto straight = make_straight_back(mesh.linear, balls, std::move(log_metrics), part_of(execution, 0.03, 0.35));
    if (!straight) return fail(straight.error());
    if (kept != KeptGradients::seen) {
        auto recovered = mean_gradients(*straight, balls, part_of(execution, 0.35, 0.6));
        if (!recovered) return fail(recovered.error());
        straight->nodal_gradients = std::move(*recovered);
    }
    CurvedBack<D> back;
    back.reference = std::move(*straight);
    back.edges = mesh.edges;
    back.displacements = std::move(*displacements);
    if (kept == KeptGradients::recovered) return BackMesh<D>(std::move(back));
    auto seen = relative_gradients(back, balls, part_of(execution, kept == KeptGradients::seen ? 0.35 : 0.6, 1));
    if (!seen) return fail(seen.error());
    back.relative_gradients = std::move(*seen);
    return BackMesh<D>(std::move(back));
}

#define CAMBER_INSTANTIATE(D)                                                                             \
    template class CurvedBack<D>;                                                                         \
    template Outcome<BackMesh<D>> make_curved_back_mesh<D>(QuadraticMesh<D>, const Incidence<ElementId>&, \
                                                           Column<LogMetric<D>>, const Execution&, KeptGradients);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
