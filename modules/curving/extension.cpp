module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.validity;
import :edge_energy;

namespace camber {

namespace {

/// Rows take part once their correction is this share of the tolerance.
constexpr double joining = 0.1;
/// Corrections of this share of the first are rounding.
constexpr double rounding = 1e-14;

/// `beside`: its residual is kept, but it has not been moved. `joined`: it moves from the next step on.
enum class Row : std::uint8_t { none, beside, joined, moving };

/// The unknowns, by edge: those of other edges than `rows` are 0 or given.
template <int D>
struct Unknowns {
    const QuadraticMesh<D>& mesh;
    const Column<EdgeKind>& kinds;
    const Incidence<ElementId>& shells;
    Buffer<ElementEnergy<D>> elements;
    Buffer<Row> state;
    std::vector<EdgeId> rows;  ///< rising
    Buffer<Vec<D>> u, residual, direction, product;
    Buffer<double> inverse_diagonal, height;

    [[nodiscard]] Vec<D> row_times(EdgeId edge, std::span<const Vec<D>> x) const {
        Vec<D> sum;
        for (const ElementId e : shells[edge]) {
            const auto& edges = mesh.edges.of_elements[e];
            sum += row_part<D>(elements[e.index()].gradients, local_edge<D>(edges, edge), edges, x);
        }
        return sum;
    }
    [[nodiscard]] Vec<D> correction(EdgeId edge) const {
        return inverse_diagonal[edge.index()] * residual[edge.index()];
    }
    /// Of the correction, as a share of the height.
    [[nodiscard]] double size(EdgeId edge) const { return norm(correction(edge)) / height[edge.index()]; }

    /// The volume edges of elements around these that had no row yet, in a row each. Returns them.
    std::vector<EdgeId> reach_out(std::span<const EdgeId> from) {
        std::vector<EdgeId> reached;
        for (const EdgeId edge : from)
            for (const ElementId e : shells[edge])
                for (const EdgeId other : mesh.edges.of_elements[e]) {
                    if (kinds[other] != EdgeKind::volume || state[other.index()] != Row::none) continue;
                    state[other.index()] = Row::beside;
                    reached.push_back(other);
                }
        std::sort(reached.begin(), reached.end());
        const auto middle = static_cast<std::ptrdiff_t>(rows.size());
        rows.insert(rows.end(), reached.begin(), reached.end());
        std::inplace_merge(rows.begin(), rows.begin() + middle, rows.end());
        return reached;
    }
    void begin_row(EdgeId edge) {
        double diagonal = 0;
        double least = std::numeric_limits<double>::infinity();
        for (const ElementId e : shells[edge]) {
            const auto& [gradients, smallest] = elements[e.index()];
            diagonal += diagonal_part<D>(gradients, local_edge<D>(mesh.edges.of_elements[e], edge));
            least = std::min(least, smallest);
        }
        inverse_diagonal[edge.index()] = diagonal > 0 ? 1 / diagonal : 0;
        height[edge.index()] = least;
        residual[edge.index()] = {};
    }
};

/// Before the first step: what is given is moved, and all beside it has a row.
template <int D>
Outcome<Unknowns<D>> unknowns_of(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds, Buffer<Vec<D>> given,
                                 const Incidence<ElementId>& shells, double stiffening, const Execution& execution) {
    const auto weighting = weighting_of(mesh.linear, stiffening, execution);
    if (!weighting) return fail(weighting.error());
    auto elements = map_each(execution, mesh.linear.elements.size(),
                             [&](std::size_t e) { return element_energy<D>(mesh.linear, ElementId(e), *weighting); });
    if (!elements) return fail(elements.error());
    const std::size_t n = mesh.edges.size();
    Unknowns<D> x{mesh,
                  kinds,
                  shells,
                  std::move(*elements),
                  Buffer<Row>(n, Row::none),
                  {},
                  std::move(given),
                  Buffer<Vec<D>>(n),
                  Buffer<Vec<D>>(n, Vec<D>{}),
                  Buffer<Vec<D>>(n),
                  Buffer<double>(n),
                  Buffer<double>(n)};
    std::vector<EdgeId> moved;
    for (std::size_t e = 0; e < n; ++e)
        if (x.u[e] != Vec<D>{}) moved.emplace_back(e);
    const auto reached = x.reach_out(moved);
    auto done = each(execution, reached.size(), [&](std::size_t i) {
        x.begin_row(reached[i]);
        x.residual[reached[i].index()] -= x.row_times(reached[i], x.u);
    });
    if (!done) return fail(std::move(done.error()));
    return x;
}

/// What the rows say after a step.
struct Sums {
    double by_product = 0;  ///< correction · product
    double by_residual = 0;
    double largest = 0;  ///< correction, as a share of the height
    std::size_t joined = 0;
};
[[nodiscard]] Sums operator+(const Sums& a, const Sums& b) {
    return {a.by_product + b.by_product, a.by_residual + b.by_residual, std::max(a.largest, b.largest),
            a.joined + b.joined};
}

/// Moves along the direction, and looks at what is left.
template <int D>
Outcome<Sums> step(Unknowns<D>& x, double length, double tolerance, const Execution& execution) {
    return reduce_each(
        execution, x.rows.size(), Sums{},
        [&](Sums& sums, std::size_t i) {
            const EdgeId edge = x.rows[i];
            const std::size_t e = edge.index();
            if (x.state[e] == Row::moving) x.u[e] += length * x.direction[e];
            if (length != 0) x.residual[e] -= length * x.product[e];
            const double size = x.size(edge);
            sums.largest = std::max(sums.largest, size);
            if (x.state[e] == Row::beside) {
                if (!(size > joining * tolerance)) return;
                x.state[e] = Row::joined;
                ++sums.joined;
            }
            if (length != 0) sums.by_product += dot(x.correction(edge), x.product[e]);
            sums.by_residual += dot(x.correction(edge), x.residual[e]);
        },
        [](const Sums& a, const Sums& b) { return a + b; });
}

/// What has joined moves, and all beside it has a row.
template <int D>
Outcome<Done> join(Unknowns<D>& x, const Execution& execution) {
    std::vector<EdgeId> joined;
    for (const EdgeId edge : x.rows)
        if (x.state[edge.index()] == Row::joined) joined.push_back(edge), x.state[edge.index()] = Row::moving;
    const auto reached = x.reach_out(joined);
    return each(execution, reached.size(), [&](std::size_t i) { x.begin_row(reached[i]); });
}

/// The direction's product with the matrix, and its own with that and with the residual.
struct Along {
    double curvature = 0, slope = 0;
};
template <int D>
Outcome<Along> multiply(Unknowns<D>& x, const Execution& execution) {
    return reduce_each(
        execution, x.rows.size(), Along{},
        [&](Along& along, std::size_t i) {
            const std::size_t e = x.rows[i].index();
            x.product[e] = x.row_times(x.rows[i], x.direction);
            along.curvature += dot(x.direction[e], x.product[e]);
            along.slope += dot(x.direction[e], x.residual[e]);
        },
        [](const Along& a, const Along& b) { return Along{a.curvature + b.curvature, a.slope + b.slope}; }, 1024);
}

struct Solved {
    int iterations = 0;
    double correction = 0;
};

/// Conjugate gradients with the diagonal as preconditioner; the D components share their steps. Rows join as the
/// residual reaches them, so each new direction is made conjugate to the last by the product itself (Polak, Ribière).
template <int D>
Outcome<Solved> solve(Unknowns<D>& x, const ExtensionOptions& options, const Execution& execution) {
    Solved solved;
    auto sums = step(x, 0, options.tolerance, execution);
    if (!sums) return fail(sums.error());
    const double first = sums->by_residual;
    double turn = 0;
    for (; solved.iterations < options.max_iterations && sums->largest > options.tolerance &&
           sums->by_residual > rounding * rounding * first;
         ++solved.iterations) {
        if (sums->joined > 0)
            if (auto joined = join(x, execution); !joined) return fail(joined.error());
        auto turned = each(execution, x.rows.size(), [&](std::size_t i) {
            const std::size_t e = x.rows[i].index();
            if (x.state[e] == Row::moving) x.direction[e] = x.correction(x.rows[i]) + turn * x.direction[e];
        });
        if (!turned) return fail(turned.error());
        const auto along = multiply(x, execution);
        if (!along) return fail(along.error());
        if (!(along->curvature > 0)) break;
        sums = step(x, along->slope / along->curvature, options.tolerance, execution);
        if (!sums) return fail(sums.error());
        turn = -sums->by_product / along->curvature;
    }
    solved.correction = sums->largest;
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
    auto nodes = map_each(execution, n, [&](std::size_t e) {
        return kinds[e] == EdgeKind::volume ? LagrangeNode<D>{middle(e)} : boundary_nodes[e];
    });
    if (!nodes) return fail(nodes.error());
    Extension<D> extension{std::move(*nodes)};
    auto given = map_each(execution, n, [&](std::size_t e) { return extension.nodes[e].point - middle(e); });
    if (!given) return fail(given.error());
    if (std::all_of(given->begin(), given->end(), [](const Vec<D>& v) { return v == Vec<D>{}; })) return extension;
    return guarded([&]() -> Outcome<Extension<D>> {
        auto x = unknowns_of<D>(mesh, kinds, std::move(*given), shells, options.stiffening, execution);
        if (!x) return fail(x.error());
        const auto solved = solve(*x, options, execution);
        if (!solved) return fail(solved.error());
        extension.iterations = solved->iterations;
        extension.correction = solved->correction;
        for (const EdgeId edge : x->rows) {
            extension.solved += x->state[edge.index()] == Row::moving ? 1 : 0;
            extension.nodes[edge.index()].point += x->u[edge.index()];
        }
        return std::move(extension);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<Extension<D>> extend_boundary<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&,            \
                                                      const Column<LagrangeNode<D>>&, const Incidence<ElementId>&, \
                                                      const ExtensionOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
