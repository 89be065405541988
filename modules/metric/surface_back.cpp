module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <utility>
module camber.metric;
import :surface_back;
import camber.core;
import camber.box_tree;

namespace camber {

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

/// The nearest point of a triangle, in its barycentric coordinates.
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
    // The hint bounds the search, with room for triangles as near as it: which is found does not depend on it.
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

void SurfaceBack::see(std::span<const BackEdge> edges, std::span<EdgeEnds<3>> out) const {
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const auto& [a, b, shell] = edges[i];
        out[i] = {{log_metrics[a]}, {log_metrics[b]}, false};
        if (nodal_gradients.empty()) continue;
        out[i].a.gradient = nodal_gradients[a];
        out[i].b.gradient = nodal_gradients[b];
    }
}

/// The wall is the plane through the edge across the triangle; there is none the other way.
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

/// log M of a triangle; of one without area nothing.
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

}  // namespace camber
