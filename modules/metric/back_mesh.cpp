module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
module camber.metric;
import :location_start;
import :surface_back;
import camber.core;
import camber.box_tree;

namespace camber {

namespace {

/// Beyond the boundary the field is constant along the line to the nearest point: only the part of its gradient along
/// the face (or edge, or vertex) on which that point lies remains.
template <int D>
LogGradient<D> along_support(const LogGradient<D>& g, const StraightBack<D>& back, const Location<D>& location) {
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
    return Frame<D>(mesh, e).gradient;
}

template <int D>
LogGradient<D> StraightBack<D>::gradient_in(ElementId e) const {
    const auto& v = mesh.elements.vertices[e];
    const auto gradients = barycentric_gradients(mesh, e);
    LogGradient<D> g{};
    for (int a = 1; a <= D; ++a) {
        const Sym<D> difference = log_metrics[v[a]].l - log_metrics[v[0]].l;
        for (int i = 0; i < D; ++i) g[i] += gradients[a][i] * difference;
    }
    return g;
}

template <int D>
LogMetric<D> StraightBack<D>::value_at(const Location<D>& location) const {
    const auto& v = mesh.elements.vertices[location.element];
    LogMetric<D> value{location.xi[0] * log_metrics[v[0]].l};
    for (int i = 1; i <= D; ++i) value.l += location.xi[i] * log_metrics[v[i]].l;
    return value;
}

template <int D>
LogGradient<D> StraightBack<D>::gradient_at(const Location<D>& location) const {
    const LogGradient<D> gradient = gradient_in(location.element);
    return location.placement == Placement::inside ? gradient : along_support<D>(gradient, *this, location);
}

template <int D>
LogGradient<D> StraightBack<D>::recovered_gradient_at(const Location<D>& location) const {
    if (nodal_gradients.empty()) return gradient_at(location);
    const auto& v = mesh.elements.vertices[location.element];
    LogGradient<D> gradient{};
    for (int a = 0; a <= D; ++a)
        for (int i = 0; i < D; ++i) gradient[i] += location.xi[a] * nodal_gradients[v[a]][i];
    return gradient;
}

namespace {

template <int D>
Outcome<Done> check_rows(const LinearMesh<D>& mesh, const Column<LogMetric<D>>& log_metrics) {
    if (log_metrics.size() == mesh.points.size()) return Done{};
    return fail(ErrorKind::input,
                "the metric has " + std::to_string(log_metrics.size()) + " rows, the mesh " +
                    std::to_string(mesh.points.size()) + " vertices",
                {}, {}, "give the metric of this mesh");
}

}  // namespace

// det J ∇ξ_a are cofactors, and nothing is divided by. Slim elements are measured with care (see Frame).
template <int D>
WeightedGradient<D> weighted_gradient(const StraightBack<D>& back, ElementId e) {
    const auto& v = back.mesh.elements.vertices[e];
    Mat<D> sides;
    double lengths_squared = 1;
    for (int a = 0; a < D; ++a) {
        sides.column[a] = back.mesh.points[v[a + 1]] - back.mesh.points[v[0]];
        lengths_squared *= norm_squared(sides.column[a]);
    }
    auto cofactor = cofactors(sides);
    double determinant = dot(cofactor[0], sides.column[0]);
    if (!(lengths_squared < 1e8 * determinant * determinant)) {
        const Frame<D> frame(back.mesh, e);
        determinant = frame.determinant;
        if (!(std::abs(determinant) > 0)) return {};
        for (int a = 0; a < D; ++a) cofactor[a] = determinant * frame.gradient[a + 1];
    }
    WeightedGradient<D> weighted{{}, std::abs(determinant)};
    const double sign = determinant < 0 ? -1 : 1;
    for (int a = 0; a < D; ++a) {
        const Sym<D> difference = back.log_metrics[v[a + 1]].l - back.log_metrics[v[0]].l;
        for (int i = 0; i < D; ++i) weighted.gradient[i] += (sign * cofactor[a][i]) * difference;
    }
    return weighted;
}

template <int D>
Outcome<Buffer<LogGradient<D>>> mean_gradients(const StraightBack<D>& back, const Incidence<ElementId>& balls,
                                               const Execution& execution) {
    return map_each(execution, back.mesh.points.size(), [&](std::size_t v) {
        LogGradient<D> sum{};
        double weight = 0;
        for (const ElementId e : balls[v]) {
            const WeightedGradient<D> of_element = weighted_gradient(back, e);
            if (!(of_element.volume > 0)) continue;
            for (int i = 0; i < D; ++i) sum[i] += of_element.gradient[i];
            weight += of_element.volume;
        }
        if (weight > 0)
            for (Sym<D>& g : sum) g *= 1 / weight;
        return sum;
    });
}

template <int D>
Outcome<StraightBack<D>> make_straight_back(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                            Column<LogMetric<D>> log_metrics, const Execution& execution) {
    if (auto fits = check_rows(mesh, log_metrics); !fits) return fail(fits.error());
    StraightBack<D> back;
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
    return back;
}

template <int D>
Outcome<BackMesh<D>> straight_back_mesh(const BackMesh<D>& back, Column<LogMetric<D>> log_metrics) {
    const StraightBack<D>* const straight = back->packed().straight;
    if (!straight) return fail(ErrorKind::internal, "there is no straight mesh behind this back mesh");
    if (auto fits = check_rows(straight->mesh, log_metrics); !fits) return fail(fits.error());
    StraightBack<D> other = *straight;
    other.log_metrics = std::move(log_metrics);
    other.nodal_gradients = {};
    return BackMesh<D>(std::move(other));
}

template <int D>
Outcome<BackMesh<D>> make_back_mesh(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                    Column<LogMetric<D>> log_metrics, const Execution& execution) {
    if constexpr (D == 3)
        if (is_surface_alone(mesh))
            return make_surface_back(mesh, std::move(log_metrics), execution).map([](SurfaceBack surface) {
                return BackMesh<D>(std::move(surface));
            });
    auto back = make_straight_back(mesh, balls, std::move(log_metrics), part_of(execution, 0, 0.6));
    if (!back) return fail(back.error());
    auto gradients = mean_gradients(*back, balls, part_of(execution, 0.6, 1));
    if (!gradients) return fail(gradients.error());
    back->nodal_gradients = std::move(*gradients);
    return BackMesh<D>(std::move(*back));
}

template <int D>
void StraightBack<D>::sample_values(std::span<const Vec<D>> points, ElementId hint,
                                    std::span<FieldSample<D>> out) const {
    // Most points are in the element of the one before: its frame is made once.
    std::optional<Frame<D>> frame;
    ElementId framed;
    const auto find = [&](const Vec<D>& p) {
        if (const auto there = at_vertex_of(mesh, hint, p)) return *there;
        const Barycentrics<D> xi = frame->barycentrics(p);
        const bool is_inside = *std::min_element(xi.begin(), xi.end()) >= -frame->tolerance();
        return is_inside ? Location<D>{hint, xi, Placement::inside} : locate(p, hint);
    };
    for (std::size_t n = 0; n < points.size(); ++n) {
        if (n > 0 && framed != hint) {
            frame.emplace(mesh, hint);
            framed = hint;
        }
        out[n].location = n > 0 ? find(points[n]) : locate(points[n], hint);
        hint = out[n].location.element;
        out[n].log_metric = value_at(out[n].location);
    }
}

template <int D>
void StraightBack<D>::sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                                            std::span<FieldSample<D>> out) const {
    sample_values(points, hint, out);
    for (FieldSample<D>& s : out) s.gradient = gradient_at(s.location);
}

template <int D>
void StraightBack<D>::sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                                      std::span<FieldSample<D>> out) const {
    sample_values(points, hint, out);
    for (FieldSample<D>& s : out) s.gradient = recovered_gradient_at(s.location);
}

template <int D>
void StraightBack<D>::see(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const {
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const auto& [a, b, shell] = edges[i];
        out[i] = {{log_metrics[a]}, {log_metrics[b]}, false};
        if (nodal_gradients.empty()) continue;
        out[i].a.gradient = nodal_gradients[a];
        out[i].b.gradient = nodal_gradients[b];
    }
}

template <int D>
BackSector<D> StraightBack<D>::sector(ElementId e, VertexId a, VertexId b) const {
    const auto gradients = barycentric_gradients(mesh, e);
    BackSector<D> sector{gradient_in(e), {}};
    // The coordinates of the vertices that are not on the edge rise from its walls inwards.
    int n = 0;
    for (int i = 0; i <= D; ++i)
        if (const VertexId v = mesh.elements.vertices[e][i]; v != a && v != b && n < D - 1)
            sector.walls[n++] = gradients[i];
    return sector;
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template class StraightBack<D>;                                                                                 \
    template Outcome<StraightBack<D>> make_straight_back<D>(const LinearMesh<D>&, const Incidence<ElementId>&,      \
                                                            Column<LogMetric<D>>, const Execution&);                \
    template Outcome<BackMesh<D>> make_back_mesh<D>(const LinearMesh<D>&, const Incidence<ElementId>&,              \
                                                    Column<LogMetric<D>>, const Execution&);                        \
    template WeightedGradient<D> weighted_gradient<D>(const StraightBack<D>&, ElementId);                           \
    template Outcome<Buffer<LogGradient<D>>> mean_gradients<D>(const StraightBack<D>&, const Incidence<ElementId>&, \
                                                               const Execution&);                                   \
    template Outcome<BackMesh<D>> straight_back_mesh<D>(const BackMesh<D>&, Column<LogMetric<D>>);                  \
    template std::array<Vec<D>, D + 1> barycentric_gradients<D>(const LinearMesh<D>&, ElementId);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
