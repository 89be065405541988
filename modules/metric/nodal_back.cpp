// Metric fields defined by log-metrics at all nodes of a quadratic mesh.
module;
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
module camber.metric;
import camber.core;

namespace camber {

namespace {

template <int D>
std::array<Sym<D>, D> reference_gradient(const NodalBack<D>& back, ElementId e, const Barycentrics<D>& xi) {
    const auto& v = back.places.mesh.linear.elements.vertices[e];
    std::array<Sym<D>, D + 1> partial{};
    for (int i = 0; i <= D; ++i) partial[i] = back.logs.vertices[v[i]].l;
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        const Sym<D> bow = back.logs.mid_nodes[back.places.mesh.edges.of_elements[e][k]].l -
                           0.5 * (back.logs.vertices[v[i]].l + back.logs.vertices[v[j]].l);
        add_edge_derivatives<D>(xi, k, bow, partial);
    }
    std::array<Sym<D>, D> out{};
    for (int a = 0; a < D; ++a) out[a] = partial[a + 1] - partial[0];
    return out;
}

template <int D>
LogGradient<D> in_space(const std::array<Sym<D>, D>& gradient, const std::array<Vec<D>, D>& rows) {
    LogGradient<D> out{};
    for (int i = 0; i < D; ++i)
        for (int a = 0; a < D; ++a) out[i] += rows[a][i] * gradient[a];
    return out;
}

template <int D>
std::array<Vec<D>, D> inverse_rows(const NodalBack<D>& back, ElementId e, const Barycentrics<D>& xi) {
    const Mat<D> a = inverse(jacobian_at(curved_element(back.places.mesh, e), xi));
    std::array<Vec<D>, D> rows{};
    for (int i = 0; i < D; ++i)
        for (int c = 0; c < D; ++c) rows[i][c] = a(i, c);
    return rows;
}

template <int D>
Outcome<Buffer<LogGradient<D>>> recovered_gradients(const NodalBack<D>& back, const Incidence<ElementId>& balls,
                                                    const Execution& execution) {
    Barycentrics<D> centre{};
    centre.fill(1.0 / (D + 1));
    return map_each(execution, back.places.mesh.linear.points.size(), [&](std::size_t v) {
        LogGradient<D> sum{};
        double weight = 0;
        for (const ElementId e : balls[v]) {
            Barycentrics<D> corner{};
            for (int i = 0; i <= D; ++i)
                if (back.places.mesh.linear.elements.vertices[e][i].index() == v) corner[i] = 1;
            const double volume = std::abs(det(jacobian_at(curved_element(back.places.mesh, e), centre)));
            const LogGradient<D> gradient = back.gradient_at(e, corner);
            bool is_number = volume > 0;
            for (const Sym<D>& g : gradient) is_number = is_number && std::isfinite(norm(g));
            if (!is_number) continue;  // the tangents at this corner are linearly dependent
            for (int i = 0; i < D; ++i) sum[i] += volume * gradient[i];
            weight += volume;
        }
        if (weight > 0)
            for (Sym<D>& g : sum) g *= 1 / weight;
        return sum;
    });
}

template <int D>
Outcome<Done> check_nodes(const QuadraticMesh<D>& mesh, const NodalLogs<D>& logs) {
    const auto refuse = [](std::size_t rows, std::size_t expected, const char* what) {
        return fail(ErrorKind::usage,
                    "the metric has " + std::to_string(rows) + " rows for " + std::to_string(expected) + " " + what);
    };
    if (logs.vertices.size() != mesh.linear.points.size())
        return refuse(logs.vertices.size(), mesh.linear.points.size(), "vertices");
    if (logs.mid_nodes.size() != mesh.edges.size())
        return refuse(logs.mid_nodes.size(), mesh.edges.size(), "edges' nodes");
    return Done{};
}

}  // namespace

template <int D>
LogMetric<D> NodalBack<D>::value_at(const Location<D>& location) const {
    const auto& xi = location.xi;
    const auto& mesh = places.mesh;
    const auto& v = mesh.linear.elements.vertices[location.element];
    LogMetric<D> value;
    for (int i = 0; i <= D; ++i) value.l += xi[i] * logs.vertices[v[i]].l;
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        const Sym<D> bow = logs.mid_nodes[mesh.edges.of_elements[location.element][k]].l -
                           0.5 * (logs.vertices[v[i]].l + logs.vertices[v[j]].l);
        value.l += edge_shape<D>(xi, k) * bow;
    }
    return value;
}

template <int D>
LogGradient<D> NodalBack<D>::gradient_at(ElementId e, const std::array<double, D + 1>& xi) const {
    return in_space<D>(reference_gradient(*this, e, xi), inverse_rows(*this, e, xi));
}

template <int D>
void NodalBack<D>::sample_values(std::span<const Vec<D>> points, ElementId hint, std::span<FieldSample<D>> out) const {
    for (std::size_t n = 0; n < points.size(); ++n) {
        out[n].location = locate(points[n], hint);
        hint = out[n].location.element;
        out[n].log_metric = value_at(out[n].location);
    }
}

template <int D>
void NodalBack<D>::sample_with_gradients(std::span<const Vec<D>> points, ElementId hint,
                                         std::span<FieldSample<D>> out) const {
    sample_values(points, hint, out);
    for (std::size_t n = 0; n < points.size(); ++n) {
        const Location<D>& at = out[n].location;
        out[n].gradient = at.placement == Placement::inside
                              ? gradient_at(at.element, at.xi)
                              : in_space<D>(reference_gradient(*this, at.element, at.xi),
                                            nearest_point_derivative(places, at, points[n]));
    }
}

template <int D>
void NodalBack<D>::sample_with_recovered_gradients(std::span<const Vec<D>> points, ElementId hint,
                                                   std::span<FieldSample<D>> out) const {
    sample_values(points, hint, out);
    for (std::size_t n = 0; n < points.size(); ++n) {
        const Location<D>& at = out[n].location;
        const auto& v = places.mesh.linear.elements.vertices[at.element];
        LogGradient<D> mean{};
        for (int i = 0; i <= D; ++i)
            for (int c = 0; c < D; ++c) mean[c] += at.xi[i] * recovered[v[i]][c];
        out[n].gradient = mean;
    }
}

template <int D>
void NodalBack<D>::sample_edges(std::span<const BackEdge> edges, std::span<EdgeEnds<D>> out) const {
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const auto& [a, b, shell] = edges[i];
        out[i] = {{logs.vertices[a]}, {logs.vertices[b]}, false};
        out[i].a.gradient = recovered[a];
        out[i].b.gradient = recovered[b];
    }
}

template <int D>
BackSector<D> NodalBack<D>::sector(ElementId e, VertexId a, VertexId b) const {
    Barycentrics<D> middle{};
    for (int i = 0; i <= D; ++i)
        if (const VertexId v = places.mesh.linear.elements.vertices[e][i]; v == a || v == b) middle[i] = 0.5;
    const auto rows = inverse_rows(*this, e, middle);
    BackSector<D> sector{in_space<D>(reference_gradient(*this, e, middle), rows), {}};
    int n = 0;
    for (int i = 0; i <= D; ++i) {
        if (middle[i] > 0 || n == D - 1) continue;
        if (i > 0)
            sector.walls[n] = rows[i - 1];
        else
            for (const Vec<D>& row : rows) sector.walls[n] -= row;
        ++n;
    }
    return sector;
}

template <int D>
Outcome<NodalLogs<D>> nodal_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices, const Execution& execution) {
    auto means = map_each(execution, edges.size(), [&](std::size_t e) {
        const auto& [a, b] = edges.vertices[e];
        return LogMetric<D>{0.5 * (vertices[a].l + vertices[b].l)};
    });
    if (!means) return fail(means.error());
    return NodalLogs<D>{std::move(vertices), Column<LogMetric<D>>(std::move(*means))};
}

template <int D>
Outcome<NodalLogs<D>> framed_logs(const EdgeSet<D>& edges, Column<LogMetric<D>> vertices, const Execution& execution) {
    const auto sizes = map_each(part_of(execution, 0, 0.5), vertices.size(),
                                [&](std::size_t v) { return MeasuringMetric<D>(vertices[v]).log_sizes; });
    if (!sizes) return fail(sizes.error());
    auto means = map_each(part_of(execution, 0.5, 1), edges.size(), [&](std::size_t e) {
        const auto& [a, b] = edges.vertices[e];
        const auto mean = frame_mean(vertices[a], (*sizes)[a.index()], vertices[b], (*sizes)[b.index()]);
        return LogMetric<D>{composed(mean)};
    });
    if (!means) return fail(means.error());
    return NodalLogs<D>{std::move(vertices), Column<LogMetric<D>>(std::move(*means))};
}

template <int D>
Outcome<BackMesh<D>> make_nodal_back_mesh(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls, NodalLogs<D> logs,
                                          const Execution& execution) {
    if (auto fits = check_nodes(mesh, logs); !fits) return fail(fits.error());
    NodalBack<D> back;
    auto places = make_curved_locator(std::move(mesh), balls, part_of(execution, 0, 0.6));
    if (!places) return fail(places.error());
    back.places = std::move(*places);
    back.logs = std::move(logs);
    auto gradients = recovered_gradients(back, balls, part_of(execution, 0.6, 1));
    if (!gradients) return fail(gradients.error());
    back.recovered = std::move(*gradients);
    return BackMesh<D>(std::move(back));
}

namespace {

constexpr int points_per_direction = 5;

template <int D>
struct Weighted {
    Barycentrics<D> xi{};
    double weight = 0;
};
template <int D>
auto folded_rule() {
    constexpr int n = points_per_direction;
    const Quadrature line = gauss_legendre(n);
    std::array<Weighted<D>, D == 2 ? n * n : n * n * n> rule{};
    for (std::size_t m = 0; m < rule.size(); ++m) {
        Weighted<D>& point = rule[m];
        point.weight = 1;
        double left = 1;  // 1 minus the sum of the coordinates set so far
        std::size_t digits = m;
        for (int a = 1; a <= D; ++a, digits /= n) {
            const double t = line.t[digits % n];
            point.xi[a] = left * t;
            point.weight *= line.w[digits % n] * left;
            left *= 1 - t;
        }
        point.xi[0] = left;
    }
    return rule;
}

}  // namespace

template <int D>
Outcome<double> complexity(const QuadraticMesh<D>& mesh, const NodalLogs<D>& logs, const Execution& execution) {
    const auto rule = folded_rule<D>();
    auto parts = map_each(execution, mesh.linear.elements.size(), [&](std::size_t e) {
        const auto element = curved_element(mesh, ElementId(e));
        const auto& v = mesh.linear.elements.vertices[e];
        double sum = 0;
        for (const auto& [xi, weight] : rule) {
            double half_trace = 0;
            for (int i = 0; i <= D; ++i) half_trace += vertex_shape(xi[i]) * 0.5 * trace(logs.vertices[v[i]].l);
            for (int k = 0; k < edges_per_simplex<D>; ++k)
                half_trace += edge_shape<D>(xi, k) * 0.5 * trace(logs.mid_nodes[mesh.edges.of_elements[e][k]].l);
            sum += weight * exp(half_trace) * std::abs(det(jacobian_at(element, xi)));
        }
        return sum;
    });
    if (!parts) return fail(parts.error());
    double sum = 0;
    for (const double part : *parts) sum += part;
    return sum;
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template class NodalBack<D>;                                                                                       \
    template Outcome<NodalLogs<D>> nodal_logs<D>(const EdgeSet<D>&, Column<LogMetric<D>>, const Execution&);           \
    template Outcome<NodalLogs<D>> framed_logs<D>(const EdgeSet<D>&, Column<LogMetric<D>>, const Execution&);          \
    template Outcome<BackMesh<D>> make_nodal_back_mesh<D>(QuadraticMesh<D>, const Incidence<ElementId>&, NodalLogs<D>, \
                                                          const Execution&);                                           \
    template Outcome<double> complexity<D>(const QuadraticMesh<D>&, const NodalLogs<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
