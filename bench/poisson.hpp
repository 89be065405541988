#pragma once
// Poisson's equation by isoparametric P2 elements, and the error of its solution where that is known: for poisson.cpp.
// Imports come before it.
//
// ∫ ∇u_h·∇v = ∫ ∇u·∇v for all v that are 0 on the boundary (that is ∫ f v, f = −Δu). Sought is what the solution has
// beyond the interpolant, w = u_h − Iu:  ∫ ∇w·∇v = ∫ ∇e·∇v,  e = u − Iu.  So all that is small is computed as such, and
// ∇u must be exact beside the error alone.
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

/// Elements with the quadrature's last change of them, as a share of the whole square of the error, L2's and H1's.
struct Changed {
    std::uint32_t element = 0;
    double share = 0;
};

/// Those that matter: without the others, which together change two thousandths. An error below 1e-9 of u is rounding.
template <int D>
void drop_settled(std::vector<Changed>& active, const std::vector<Lacking<D>>& now,
                  const std::vector<Lacking<D>>& before) {
    Lacking<D> sum;
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
    std::ranges::sort(active, {}, &Changed::share);
    double settled = 0;
    const auto matters =
        std::ranges::find_if(active, [&](const Changed& one) { return !((settled += one.share) <= 2e-3); });
    active.erase(active.begin(), matters);
}

/// Of all elements, by rules that rise where the squares still change: layers cross few of them.
template <int D>
Outcome<std::vector<Lacking<D>>> integrate(const Domain<D>& domain, const ScalarExpression<D>& expression,
                                           const Vector& nodal, const Execution& execution) {
    const std::size_t n = domain.mesh.linear.elements.size();
    std::vector<Lacking<D>> all(n);
    std::vector<Changed> active(n);
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
                all[e] = lacking(element_of(domain.mesh, ElementId(e)), local, sampler, rule);
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
    double interpolated_l2 = 0, interpolated_h1 = 0;  ///< of the interpolant, which has the same boundary values
    std::size_t turned = 0;
    std::string method;
    double seconds = 0;
    Vector nodal;  ///< the solution at the nodes
};

/// The interpolant: u at the nodes, on the boundary what is given there.
template <int D>
Vector nodal_values(const Domain<D>& domain, const ScalarExpression<D>& expression,
                    const ScalarExpression<D>& on_boundary) {
    const Sampler<D> inside(expression), at_boundary(on_boundary);
    const QuadraticMesh<D>& mesh = domain.mesh;
    const std::size_t vertices = mesh.linear.points.size();
    Vector values(static_cast<Eigen::Index>(vertices + mesh.edges.size()));
    for (std::size_t node = 0; node < vertices + mesh.edges.size(); ++node) {
        const Vec<D>& place = node < vertices ? mesh.linear.points[node] : mesh.mid_nodes[node - vertices].point;
        const bool is_given = domain.numbering.unknown_of[node] == given;
        values[static_cast<Eigen::Index>(node)] = (is_given ? at_boundary : inside).value(place);
    }
    return values;
}

template <int D>
Outcome<Row> solve_on(const Domain<D>& domain, const ScalarExpression<D>& expression,
                      const ScalarExpression<D>& on_boundary, const Execution& execution) {
    const auto begin = std::chrono::steady_clock::now();
    Row row;
    row.unknowns = domain.numbering.unknowns;
    row.turned = domain.turned;
    row.nodal = nodal_values(domain, expression, on_boundary);
    const auto lacks = integrate(domain, expression, row.nodal, execution);
    if (!lacks) return fail(lacks.error());
    Vector load = Vector::Zero(row.unknowns), moments = load;
    double l2 = 0, h1 = 0;
    for (std::size_t e = 0; e < lacks->size(); ++e) {
        const Lacking<D>& lacks_here = (*lacks)[e];
        l2 += lacks_here.l2;
        h1 += lacks_here.h1;
        const auto nodes = nodes_of(domain.mesh, e);
        for (int i = 0; i < quadratic_nodes<D>; ++i)
            if (const int unknown = domain.numbering.unknown_of[nodes[i]]; unknown >= 0) {
                load[unknown] += lacks_here.load[i];
                moments[unknown] += lacks_here.moments[i];
            }
    }
    if (!std::isfinite(l2) || !std::isfinite(h1))
        return fail(ErrorKind::input, "the field is not finite everywhere on the mesh, or beside it", {}, {},
                    "a layer needs a mesh away from the origin, or a greater thickness");
    constexpr double tolerance = 1e-8;  // of what is beyond the interpolant
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
