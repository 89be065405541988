// Back meshes on straight meshes and standalone surface meshes.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
module camber.metric;
import camber.core;
import camber.box_tree;

namespace camber {

namespace {

/// Returns the part of the gradient `g` that is tangential to the boundary face, edge or vertex on which `location`
/// lies.
template <int D>
LogGradient<D> along_support(const LogGradient<D>& g, const StraightBack<D>& back, const Location<D>& location) {
    const auto& v = back.mesh.elements.vertices[location.element];
    std::array<Vec<D>, D + 1> support{};
    int n = 0;
    for (int i = 0; i <= D; ++i)
        if (location.xi[i] > 0) support[n++] = back.mesh.points[v[i]];
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
    return ElementFrame<D>(mesh, e).gradient;
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

// For the Jacobian J of the element, det J ∇ξ_a is a vector of cofactors, so no division is needed.
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
        const ElementFrame<D> frame(back.mesh, e);
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
    if (!straight) return fail(ErrorKind::internal, "this background mesh has no straight mesh");
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
        if (is_standalone_surface(mesh))
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
    // Most points lie in the element of the previous point, so its barycentric coordinates are tried first.
    std::optional<ElementFrame<D>> frame;
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
void StraightBack<D>::sample_edges(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const {
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
    int n = 0;
    for (int i = 0; i <= D; ++i)
        if (const VertexId v = mesh.elements.vertices[e][i]; v != a && v != b && n < D - 1)
            sector.walls[n++] = gradients[i];
    return sector;
}

TriangleFrame triangle_frame(const std::array<Vec<3>, 3>& p) {
    const Vec<3> u = p[1] - p[0];
    const Vec<3> v = p[2] - p[0];
    const Vec<3> n = cross(u, v);
    const double twice = norm(n);
    TriangleFrame frame;
    if (!(twice > 0)) return frame;
    frame.area = twice / 2;
    frame.normal = n / twice;
    frame.tangents = {normalised(u), cross(frame.normal, normalised(u))};
    frame.gradients[1] = cross(v, frame.normal) / twice;
    frame.gradients[2] = cross(frame.normal, u) / twice;
    frame.gradients[0] = -(frame.gradients[1] + frame.gradients[2]);
    return frame;
}

namespace {

std::array<double, 3> nearest_in(const std::array<Vec<3>, 3>& p, const Vec<3>& x) {
    const Vec<3> u = p[1] - p[0];
    const Vec<3> v = p[2] - p[0];
    const Vec<3> r = x - p[0];
    const Vec<3> n = cross(u, v);
    const double b = dot(cross(r, v), n) / norm_squared(n);
    const double c = dot(cross(u, r), n) / norm_squared(n);
    if (b >= 0 && c >= 0 && b + c <= 1) return {1 - b - c, b, c};
    std::array<double, 3> best{1, 0, 0};
    double best_distance = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        const Vec<3> e = p[j] - p[i];
        const double t = norm_squared(e) > 0 ? std::clamp(dot(x - p[i], e) / norm_squared(e), 0.0, 1.0) : 0;
        const double d = norm_squared(x - p[i] - t * e);
        if (!(d < best_distance)) continue;
        best_distance = d;
        best = {};
        best[i] = 1 - t;
        best[j] = t;
    }
    return best;
}

double distance_squared(const std::array<Vec<3>, 3>& p, const Vec<3>& x) {
    const auto xi = nearest_in(p, x);
    return norm_squared(x - p[0] - xi[1] * (p[1] - p[0]) - xi[2] * (p[2] - p[0]));
}

}  // namespace

Location<3> SurfaceBack::locate(const Vec<3>& p, ElementId hint) const {
    const auto to = [&](std::size_t f) { return distance_squared(triangle_corners(mesh, f), p); };
    // The search only considers triangles that are at most as far from p as the hint's triangle. The factor 1 + 1e-9
    // includes triangles at the same distance, so the result does not depend on the hint.
    const double within = hint.valid() && hint.index() < mesh.facets.size()
                              ? to(hint.index()) * (1 + 1e-9) + std::numeric_limits<double>::min()
                              : std::numeric_limits<double>::infinity();
    const auto nearest = tree.nearest(p, to, within);
    const std::size_t f = nearest.item < mesh.facets.size() ? nearest.item : 0;
    const auto xi = nearest_in(triangle_corners(mesh, f), p);
    return {.element = ElementId(f), .xi = {xi[0], xi[1], xi[2], 0}, .placement = Placement::inside};
}

LogGradient<3> SurfaceBack::gradient_in(ElementId triangle) const {
    const auto& v = mesh.facets.vertices[triangle.index()];
    const TriangleFrame frame = triangle_frame(triangle_corners(mesh, triangle.index()));
    LogGradient<3> g{};
    for (int a = 1; a < 3; ++a) {
        const Sym<3> difference = log_metrics[v[a]].l - log_metrics[v[0]].l;
        for (int i = 0; i < 3; ++i) g[i] += frame.gradients[a][i] * difference;
    }
    return g;
}

void SurfaceBack::sample_values(std::span<const Vec<3>> points, ElementId hint, std::span<FieldSample<3>> out) const {
    for (std::size_t n = 0; n < points.size(); ++n) {
        out[n].location = locate(points[n], hint);
        hint = out[n].location.element;
        const auto& v = mesh.facets.vertices[hint.index()];
        const auto& xi = out[n].location.xi;
        out[n].log_metric.l = xi[0] * log_metrics[v[0]].l + xi[1] * log_metrics[v[1]].l + xi[2] * log_metrics[v[2]].l;
    }
}

void SurfaceBack::sample_with_gradients(std::span<const Vec<3>> points, ElementId hint,
                                        std::span<FieldSample<3>> out) const {
    sample_values(points, hint, out);
    for (FieldSample<3>& s : out) s.gradient = gradient_in(s.location.element);
}

void SurfaceBack::sample_with_recovered_gradients(std::span<const Vec<3>> points, ElementId hint,
                                                  std::span<FieldSample<3>> out) const {
    if (nodal_gradients.empty()) return sample_with_gradients(points, hint, out);
    sample_values(points, hint, out);
    for (FieldSample<3>& s : out) {
        const auto& v = mesh.facets.vertices[s.location.element.index()];
        s.gradient = {};
        for (int a = 0; a < 3; ++a)
            for (int i = 0; i < 3; ++i) s.gradient[i] += s.location.xi[a] * nodal_gradients[v[a]][i];
    }
}

void SurfaceBack::sample_edges(std::span<const BackEdge> edges, std::span<EdgeEnds<3>> out) const {
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const auto& [a, b, shell] = edges[i];
        out[i] = {{log_metrics[a]}, {log_metrics[b]}, false};
        if (nodal_gradients.empty()) continue;
        out[i].a.gradient = nodal_gradients[a];
        out[i].b.gradient = nodal_gradients[b];
    }
}

/// At an edge of a triangle, the first wall is the plane through the edge, normal to the triangle. The second wall is
/// the plane of the triangle.
BackSector<3> SurfaceBack::sector(ElementId e, VertexId a, VertexId b) const {
    const auto& v = mesh.facets.vertices[e.index()];
    const TriangleFrame frame = triangle_frame(triangle_corners(mesh, e.index()));
    BackSector<3> sector{gradient_in(e), {}};
    for (int i = 0; i < 3; ++i)
        if (v[i] != a && v[i] != b) sector.walls[0] = frame.gradients[i];
    sector.walls[1] = frame.normal;
    return sector;
}

Outcome<SurfaceBack> make_surface_back(const LinearMesh<3>& mesh, Column<LogMetric<3>> log_metrics,
                                       const Execution& execution) {
    if (log_metrics.size() != mesh.points.size())
        return fail(ErrorKind::input,
                    "the metric has " + std::to_string(log_metrics.size()) + " rows, the mesh " +
                        std::to_string(mesh.points.size()) + " vertices",
                    {}, {}, "give the metric of this mesh");
    return guarded([&]() -> Outcome<SurfaceBack> {
        SurfaceBack back;
        back.mesh = mesh;
        back.log_metrics = std::move(log_metrics);
        Buffer<Box<3>> boxes(mesh.facets.size());
        for (std::size_t f = 0; f < boxes.size(); ++f) {
            boxes[f] = {};
            for (const Vec<3>& p : triangle_corners(mesh, f)) boxes[f].include(p);
        }
        back.tree = BoxTree<3>(boxes);
        const auto around = facet_balls(mesh, part_of(execution, 0, 0.3));
        if (!around) return fail(around.error());
        auto gradients = map_each(part_of(execution, 0.3, 1), mesh.points.size(), [&](std::size_t v) {
            LogGradient<3> sum{};
            double weight = 0;
            for (const FacetId f : (*around)[v]) {
                const double area = triangle_frame(triangle_corners(mesh, f.index())).area;
                const LogGradient<3> g = back.gradient_in(ElementId(f.index()));
                for (int i = 0; i < 3; ++i) sum[i] += area * g[i];
                weight += area;
            }
            if (weight > 0)
                for (Sym<3>& g : sum) g *= 1 / weight;
            return sum;
        });
        if (!gradients) return fail(gradients.error());
        back.nodal_gradients = std::move(*gradients);
        return back;
    });
}

namespace {

Sym<3> natural_log(const std::array<Vec<3>, 3>& p, const TriangleFrame& frame) {
    const auto flat = [&](const Vec<3>& x) { return Vec<2>{{dot(x, frame.tangents[0]), dot(x, frame.tangents[1])}}; };
    const Sym<2> in_plane = natural_log_metric<2>({Vec<2>{}, flat(p[1] - p[0]), flat(p[2] - p[0])}).l;
    Sym<3> log_metric;
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) {
            double sum = trace(in_plane) / 2 * frame.normal[i] * frame.normal[j];
            for (int k = 0; k < 2; ++k)
                for (int l = 0; l < 2; ++l) sum += in_plane(k, l) * frame.tangents[k][i] * frame.tangents[l][j];
            log_metric(i, j) = sum;
        }
    return log_metric;
}

}  // namespace

Outcome<Buffer<LogMetric<3>>> natural_surface_log_metrics(const LinearMesh<3>& mesh, const Execution& execution) {
    const auto around = facet_balls(mesh, part_of(execution, 0, 0.3));
    if (!around) return fail(around.error());
    return map_each(part_of(execution, 0.3, 1), mesh.points.size(), [&](std::size_t v) {
        LogMetric<3> mean;
        double weight = 0;
        for (const FacetId f : (*around)[v]) {
            const auto p = triangle_corners(mesh, f.index());
            const TriangleFrame frame = triangle_frame(p);
            if (!(frame.area > 0)) continue;
            const Sym<3> log_metric = natural_log(p, frame);
            if (!std::isfinite(trace(log_metric))) continue;
            mean.l += frame.area * log_metric;
            weight += frame.area;
        }
        if (weight > 0) mean.l *= 1 / weight;
        return mean;
    });
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
