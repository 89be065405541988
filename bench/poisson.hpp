#pragma once
// Poisson's equation by isoparametric P2 elements and the error of its solution for a known u, used by poisson.cpp. The
// includer imports the modules before it.
//
// ∫ ∇u_h·∇v = ∫ ∇u·∇v for all v that are 0 on the boundary (that is ∫ f v, f = −Δu). The unknown is the difference of
// the solution and the interpolant, w = u_h − Iu: ∫ ∇w·∇v = ∫ ∇e·∇v, e = u − Iu. So small quantities are computed
// directly, and ∇u must be exact only relative to the error.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "poisson_domain.hpp"
#include "poisson_field.hpp"
#include "poisson_solve.hpp"

namespace poisson {

/// Elements with the last change of their quadrature, as a share of the total squared L2 and H1 errors.
struct ElementChange {
    std::uint32_t element = 0;
    double share = 0;
};

/// Keeps the elements with relevant changes. The others together change the error by at most two thousandths. Errors
/// below 1e-9 of u are rounding.
template <int D>
void drop_settled(std::vector<ElementChange>& active, const std::vector<ElementErrors<D>>& now,
                  const std::vector<ElementErrors<D>>& before) {
    ElementErrors<D> sum;
    for (const auto& one : now) {
        sum.l2 += one.l2;
        sum.h1 += one.h1;
        sum.u_l2 += one.u_l2;
        sum.u_h1 += one.u_h1;
    }
    const double l2 = std::max(sum.l2, 1e-18 * sum.u_l2), h1 = std::max(sum.h1, 1e-18 * sum.u_h1);
    for (auto& [element, share] : active) {
        const auto &a = now[element], &b = before[element];
        share = std::abs(a.l2 - b.l2) / (l2 > 0 ? l2 : 1) + std::abs(a.h1 - b.h1) / (h1 > 0 ? h1 : 1);
    }
    std::ranges::sort(active, {}, &ElementChange::share);
    double settled = 0;
    const auto matters =
        std::ranges::find_if(active, [&](const ElementChange& one) { return !((settled += one.share) <= 2e-3); });
    active.erase(active.begin(), matters);
}

/// Integrates over all elements. The order of the rule rises where the squared errors still change, since layers cross
/// few elements.
template <int D>
Outcome<std::vector<ElementErrors<D>>> integrate(const Domain<D>& domain, const ScalarExpression<D>& expression,
                                                 const Vector& nodal, const Execution& execution) {
    const std::size_t n = domain.mesh.linear.elements.size();
    std::vector<ElementErrors<D>> all(n);
    std::vector<ElementChange> active(n);
    for (std::size_t e = 0; e < n; ++e) active[e].element = static_cast<std::uint32_t>(e);
    for (const int points : {4, 6, 8, 11}) {
        const Rule<D> rule = basis_rule<D>(points);
        const auto before = all;
        const auto chunk = [&](std::size_t begin, std::size_t end) {
            const Sampler<D> sampler(expression);
            for (std::size_t i = begin; i < end; ++i) {
                const std::size_t e = active[i].element;
                Local<D> local;
                const auto nodes = nodes_of(domain.mesh, e);
                for (int k = 0; k < local.size(); ++k) local[k] = nodal[static_cast<Eigen::Index>(nodes[k])];
                all[e] = element_errors(element_of(domain.mesh, ElementId(e)), local, sampler, rule);
            }
        };
        if (const auto done = each_chunk(execution, active.size(), chunk, 16); !done) return fail(done.error());
        drop_settled(active, all, before);
    }
    return all;
}

/// Errors (∫ (u − u_h)²)^½ and (∫ |∇(u − u_h)|²)^½.
struct Row {
    int unknowns = 0;
    double l2 = 0, h1 = 0;                            ///< of the solution
    double interpolated_l2 = 0, interpolated_h1 = 0;  ///< of the interpolant with the same boundary values
    std::size_t inverted = 0;
    std::string method;
    double seconds = 0;
    Vector nodal;  ///< values of the solution at the nodes
};

/// Returns the nodal values of the interpolant: u at inner nodes and the boundary data at boundary nodes.
template <int D>
Vector nodal_values(const Domain<D>& domain, const ScalarExpression<D>& expression,
                    const ScalarExpression<D>& on_boundary) {
    const Sampler<D> inside(expression), at_boundary(on_boundary);
    const QuadraticMesh<D>& mesh = domain.mesh;
    const std::size_t vertices = mesh.linear.points.size();
    Vector values(static_cast<Eigen::Index>(vertices + mesh.edges.size()));
    for (std::size_t node = 0; node < vertices + mesh.edges.size(); ++node) {
        const Vec<D>& place = node < vertices ? mesh.linear.points[node] : mesh.mid_nodes[node - vertices].point;
        const bool is_prescribed = domain.numbering.unknown_of[node] == prescribed;
        values[static_cast<Eigen::Index>(node)] = (is_prescribed ? at_boundary : inside).value(place);
    }
    return values;
}

template <int D>
Outcome<Row> solve_on(const Domain<D>& domain, const ScalarExpression<D>& expression,
                      const ScalarExpression<D>& on_boundary, const Execution& execution) {
    const auto begin = std::chrono::steady_clock::now();
    Row row;
    row.unknowns = domain.numbering.unknowns;
    row.inverted = domain.inverted;
    row.nodal = nodal_values(domain, expression, on_boundary);
    const auto errors = integrate(domain, expression, row.nodal, execution);
    if (!errors) return fail(errors.error());
    Vector load = Vector::Zero(row.unknowns), moments = load;
    double l2 = 0, h1 = 0;
    for (std::size_t e = 0; e < errors->size(); ++e) {
        const ElementErrors<D>& element = (*errors)[e];
        l2 += element.l2;
        h1 += element.h1;
        const auto nodes = nodes_of(domain.mesh, e);
        for (int i = 0; i < quadratic_nodes<D>; ++i)
            if (const int unknown = domain.numbering.unknown_of[nodes[i]]; unknown >= 0) {
                load[unknown] += element.load[i];
                moments[unknown] += element.moments[i];
            }
    }
    if (!std::isfinite(l2) || !std::isfinite(h1))
        return fail(ErrorKind::input, "the field is not finite on the mesh or near it", {}, {},
                    "a layer needs a mesh away from the origin, or a greater thickness");
    constexpr double tolerance = 1e-8;  // of the difference to the interpolant
    const auto solved = solve(domain.stiffness, load, tolerance);
    if (!solved) return fail(solved.error());
    const Vector& w = solved->values;
    row.method = solved->method;
    row.interpolated_l2 = std::sqrt(l2);
    row.interpolated_h1 = std::sqrt(h1);
    row.l2 = std::sqrt(std::max(0.0, l2 - w.dot(2 * moments - domain.mass * w)));
    row.h1 = std::sqrt(std::max(0.0, h1 - w.dot(2 * load - domain.stiffness * w)));
    for (std::size_t node = 0; node < domain.numbering.unknown_of.size(); ++node)
        if (const int unknown = domain.numbering.unknown_of[node]; unknown >= 0)
            row.nodal[static_cast<Eigen::Index>(node)] += w[unknown];
    row.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return row;
}

}  // namespace poisson
