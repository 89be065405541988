module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

/// How much an element counts, by |det| of its edges. Bounded, so that the slightest elements do not drown the others.
struct Weighting {
    double mean = 1, stiffening = 0;

    [[nodiscard]] double of(double volume) const { return std::min(std::pow(mean / volume, stiffening), 1e12); }
};

template <int D>
Outcome<Weighting> weighting_of(const LinearMesh<D>& mesh, double stiffening, const Execution& execution) {
    const auto sum = reduce_each(
        execution, mesh.elements.size(), 0.0,
        [&](double& total, std::size_t e) {
            const auto& v = mesh.elements.vertices[e];
            Mat<D> edges;
            for (int a = 0; a < D; ++a) edges.column[a] = mesh.points[v[a + 1]] - mesh.points[v[0]];
            total += std::abs(det(edges));
        },
        [](double a, double b) { return a + b; });
    if (!sum) return fail(sum.error());
    return Weighting{*sum / static_cast<double>(std::max<std::size_t>(1, mesh.elements.size())), stiffening};
}

/// The stiffness of one straight element: K_ef = ∫ ∇φ_e · ∇φ_f, φ_e = 4 ξ_i ξ_j, but for a constant factor.
template <int D>
using Stiffness = std::array<std::array<double, edges_per_simplex<D>>, edges_per_simplex<D>>;

template <int D>
Stiffness<D> stiffness(const std::array<Vec<D>, D + 1>& p, const Weighting& weighting) {
    Mat<D> edges;
    for (int a = 0; a < D; ++a) edges.column[a] = p[a + 1] - p[0];
    const double volume = std::abs(det(edges));
    const auto rows = cofactors(edges);
    // ∇ξ_i times det: its factor 1/det² joins the volume's.
    std::array<Vec<D>, D + 1> gradient{};
    for (int a = 0; a < D; ++a) gradient[a + 1] = rows[a], gradient[0] -= rows[a];
    const double factor = weighting.of(volume) / volume;
    Stiffness<D> k{};
    // Flat elements have no say.
    if (!std::isfinite(factor)) return k;
    // ∫ ξ_a ξ_b = (1 + δ_ab) · constant.
    const auto mass = [](int a, int b) { return a == b ? 2.0 : 1.0; };
    for (int e = 0; e < edges_per_simplex<D>; ++e)
        for (int f = 0; f <= e; ++f) {
            const auto [i, j] = local_edges<D>[e];
            const auto [m, n] = local_edges<D>[f];
            k[e][f] = k[f][e] =
                factor * (mass(i, m) * dot(gradient[j], gradient[n]) + mass(i, n) * dot(gradient[j], gradient[m]) +
                          mass(j, m) * dot(gradient[i], gradient[n]) + mass(j, n) * dot(gradient[i], gradient[m]));
        }
    return k;
}

/// A symmetric sparse matrix by rows, over the free edges; `given` is what the displacements given add to the right
/// side.
template <int D>
struct System {
    Buffer<EdgeId> free;
    std::vector<std::uint32_t> offsets;
    Buffer<std::uint32_t> columns;
    Buffer<double> values;
    Buffer<double> inverse_diagonal;
    Buffer<Vec<D>> right;
};

/// A part of a row while it is assembled: what an element adds in the column of an edge.
struct Entry {
    EdgeId edge;
    ElementId element;
    double value = 0;
};

template <int D>
void assemble_row(const QuadraticMesh<D>& mesh, EdgeId edge, std::span<const ElementId> shell,
                  const Weighting& weighting, std::vector<Entry>& row) {
    row.clear();
    for (const ElementId element : shell) {
        std::array<Vec<D>, D + 1> p;
        for (int i = 0; i <= D; ++i) p[i] = mesh.linear.points[mesh.linear.elements.vertices[element][i]];
        const auto& edges = mesh.edges.of_elements[element];
        const auto own = std::find(edges.begin(), edges.end(), edge) - edges.begin();
        const auto k = stiffness<D>(p, weighting);
        for (int f = 0; f < edges_per_simplex<D>; ++f) row.push_back({edges[f], element, k[own][f]});
    }
    std::sort(row.begin(), row.end(), [](const Entry& a, const Entry& b) {
        return std::tuple(a.edge, a.element) < std::tuple(b.edge, b.element);
    });
    std::size_t n = 0;
    for (std::size_t i = 0; i < row.size(); ++i) {
        if (n > 0 && row[n - 1].edge == row[i].edge)
            row[n - 1].value += row[i].value;
        else
            row[n++] = row[i];
    }
    row.resize(n);
}

constexpr std::uint32_t not_free = 0xffffffffU;

/// How many free edges the elements around an edge have, itself too.
template <int D>
std::uint32_t row_size(const QuadraticMesh<D>& mesh, std::span<const ElementId> shell,
                       std::span<const std::uint32_t> row_of, std::vector<EdgeId>& edges) {
    edges.clear();
    for (const ElementId element : shell)
        for (const EdgeId edge : mesh.edges.of_elements[element])
            if (row_of[edge.index()] != not_free) edges.push_back(edge);
    std::sort(edges.begin(), edges.end());
    return static_cast<std::uint32_t>(std::unique(edges.begin(), edges.end()) - edges.begin());
}

template <int D>
Outcome<System<D>> assemble(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds, std::span<const Vec<D>> given,
                            const Incidence<ElementId>& shells, const Weighting& weighting,
                            const Execution& execution) {
    System<D> s;
    Buffer<std::uint32_t> row_of(mesh.edges.size());
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        const bool is_free = kinds[e] == EdgeKind::volume && !shells[e].empty();
        row_of[e] = is_free ? static_cast<std::uint32_t>(s.free.size()) : not_free;
        if (is_free) s.free.push_back(EdgeId(e));
    }
    const std::size_t n = s.free.size();
    s.offsets.assign(n + 1, 0);
    auto counted = each_chunk(execution, n, [&](std::size_t begin, std::size_t end) {
        std::vector<EdgeId> edges;
        for (std::size_t r = begin; r < end; ++r) s.offsets[r + 1] = row_size(mesh, shells[s.free[r]], row_of, edges);
    });
    if (!counted) return fail(std::move(counted.error()));
    std::inclusive_scan(s.offsets.begin(), s.offsets.end(), s.offsets.begin());
    s.columns = Buffer<std::uint32_t>(s.offsets[n]);
    s.values = Buffer<double>(s.offsets[n]);
    s.inverse_diagonal = Buffer<double>(n);
    s.right = Buffer<Vec<D>>(n);
    auto done = each_chunk(execution, n, [&](std::size_t begin, std::size_t end) {
        std::vector<Entry> row;
        for (std::size_t r = begin; r < end; ++r) {
            assemble_row(mesh, s.free[r], shells[s.free[r]], weighting, row);
            std::uint32_t at = s.offsets[r];
            s.right[r] = Vec<D>{};
            double diagonal = 0;
            for (const auto& [edge, element, value] : row) {
                const std::uint32_t column = row_of[edge.index()];
                if (column == r) diagonal = value;
                if (column == not_free)
                    s.right[r] -= value * given[edge.index()];
                else
                    s.columns[at] = column, s.values[at] = value, ++at;
            }
            s.inverse_diagonal[r] = diagonal > 0 ? 1 / diagonal : 0;
        }
    });
    if (!done) return fail(std::move(done.error()));
    return s;
}

template <int D>
Outcome<double> product(const Buffer<Vec<D>>& a, const Buffer<Vec<D>>& b, const Execution& execution) {
    return reduce_each(
        execution, a.size(), 0.0, [&](double& sum, std::size_t i) { sum += dot(a[i], b[i]); },
        [](double x, double y) { return x + y; });
}

struct Solved {
    int iterations = 0;
    double residual = 0;
};

/// Conjugate gradients with the diagonal as preconditioner, from 0; the D components share their steps.
template <int D>
Outcome<Solved> solve(const System<D>& s, Buffer<Vec<D>>& x, const ExtensionOptions& options,
                      const Execution& execution) {
    const std::size_t n = s.free.size();
    Solved solved;
    Buffer<Vec<D>> r = s.right;
    Buffer<Vec<D>> z(n), p(n), q(n);
    for (std::size_t i = 0; i < n; ++i) {
        x[i] = {};
        z[i] = s.inverse_diagonal[i] * r[i];
        p[i] = z[i];
    }
    auto rho = product(r, z, execution);
    if (!rho) return fail(rho.error());
    const double first = *rho;
    for (; solved.iterations < options.max_iterations && *rho > options.tolerance * options.tolerance * first;
         ++solved.iterations) {
        auto multiplied = each(execution, n, [&](std::size_t i) {
            Vec<D> sum;
            for (std::uint32_t k = s.offsets[i]; k < s.offsets[i + 1]; ++k) sum += s.values[k] * p[s.columns[k]];
            q[i] = sum;
        });
        if (!multiplied) return fail(multiplied.error());
        const auto curvature = product(p, q, execution);
        if (!curvature) return fail(curvature.error());
        if (!(*curvature > 0)) break;
        const double step = *rho / *curvature;
        auto stepped = each(execution, n, [&](std::size_t i) {
            x[i] += step * p[i];
            r[i] -= step * q[i];
            z[i] = s.inverse_diagonal[i] * r[i];
        });
        if (!stepped) return fail(stepped.error());
        const auto next = product(r, z, execution);
        if (!next) return fail(next.error());
        const double ratio = *next / *rho;
        auto turned = each(execution, n, [&](std::size_t i) { p[i] = z[i] + ratio * p[i]; });
        if (!turned) return fail(turned.error());
        rho = next;
    }
    solved.residual = first > 0 ? std::sqrt(*rho / first) : 0;
    return solved;
}

}  // namespace

template <int D>
Outcome<Extension<D>> extend_boundary(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                                      const Column<LagrangeNode<D>>& boundary_nodes, const Incidence<ElementId>& shells,
                                      const ExtensionOptions& options, const Execution& execution) {
    const std::size_t n = mesh.edges.size();
    if (kinds.size() != n || boundary_nodes.size() != n || shells.size() != n)
        return fail(ErrorKind::internal, "an extension needs a kind, a node and a shell for each edge");
    const auto middle = [&](std::size_t e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        return midpoint(mesh.linear.points[a], mesh.linear.points[b]);
    };
    auto given = map_each(execution, n, [&](std::size_t e) {
        return kinds[e] == EdgeKind::volume ? Vec<D>{} : boundary_nodes[e].point - middle(e);
    });
    if (!given) return fail(given.error());
    const auto weighting = weighting_of(mesh.linear, options.stiffening, execution);
    if (!weighting) return fail(weighting.error());
    auto system = assemble<D>(mesh, kinds, *given, shells, *weighting, execution);
    if (!system) return fail(system.error());
    Buffer<Vec<D>> u(system->free.size());
    const auto solved = solve(*system, u, options, execution);
    if (!solved) return fail(solved.error());
    Extension<D> extension{boundary_nodes.empty() ? Buffer<LagrangeNode<D>>{} : Buffer<LagrangeNode<D>>(n),
                           solved->iterations, solved->residual};
    for (std::size_t e = 0; e < n; ++e)
        extension.nodes[e] = kinds[e] == EdgeKind::volume ? LagrangeNode<D>{middle(e)} : boundary_nodes[e];
    for (std::size_t r = 0; r < u.size(); ++r) extension.nodes[system->free[r].index()].point += u[r];
    return extension;
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<Extension<D>> extend_boundary<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&,            \
                                                      const Column<LagrangeNode<D>>&, const Incidence<ElementId>&, \
                                                      const ExtensionOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
