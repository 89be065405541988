module;
#include <array>
#include <cmath>
#include <cstddef>
module camber.metric;
import :curved_simplex;
import :element_frame;
import camber.core;

namespace camber {

namespace {

constexpr int points_a_direction = 5;

/// A point of the reference simplex and its weight: Gauss's rule of the cube, folded (Duffy).
template <int D>
struct Weighted {
    Barycentrics<D> xi{};
    double weight = 0;
};
template <int D>
auto folded_rule() {
    constexpr int n = points_a_direction;
    const Quadrature line = gauss_legendre(n);
    std::array<Weighted<D>, D == 2 ? n * n : n * n * n> rule{};
    for (std::size_t m = 0; m < rule.size(); ++m) {
        Weighted<D>& point = rule[m];
        point.weight = 1;
        double left = 1;  // what the coordinates before leave
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

#define CAMBER_INSTANTIATE(D) \
    template Outcome<double> complexity<D>(const QuadraticMesh<D>&, const NodalLogs<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
