module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.programmes;

namespace camber {

namespace {

/// Nodes on their way, and the scaled Jacobian of each element.
template <int D>
struct Polish {
    const QuadraticMesh<D>& mesh;
    const Column<EdgeKind>& kinds;
    const Incidence<ElementId>& shells;
    const ShapeOptions& options;
    Buffer<LagrangeNode<D>> nodes;
    Buffer<double> values;

    [[nodiscard]] double value(ElementId e) const {
        const auto element = nodal_element<D>(mesh, nodes, e);
        const double by_coefficients = smallest_scaled_coefficient(bounded_jacobian(element));
        if (options.programme.most_cuts == 0 || by_coefficients >= options.enough) return by_coefficients;
        return check_element(element, 0).min_scaled_jacobian;
    }
    [[nodiscard]] double smallest_around(EdgeId edge) const {
        double low = values[shells[edge].front().index()];
        for (const ElementId e : shells[edge]) low = std::min(low, values[e.index()]);
        return low;
    }
};

/// Elements to be looked at, worst first, ties by number.
using Queue = std::set<std::pair<double, ElementId>>;

template <int D>
struct Move {
    EdgeId edge;
    LagrangeNode<D> node;
    double gain = 0;
};

/// The step that raises the smallest value around one of the element's edges most.
template <int D>
std::optional<Move<D>> best_move(const Polish<D>& polish, ElementId element) {
    std::optional<Move<D>> best;
    for (const EdgeId edge : polish.mesh.edges.of_elements[element]) {
        if (polish.kinds[edge] != EdgeKind::volume) continue;
        const double now = polish.smallest_around(edge);
        auto programme = polish.options.programme;
        programme.enough = polish.options.enough;
        const auto highest =
            highest_node(edge_shell<D>(polish.mesh, polish.nodes, polish.shells[edge], edge), programme);
        if (!highest) continue;
        const double gain = highest->lower - now;
        if (gain > polish.options.least_gain && (!best || gain > best->gain)) best = {edge, highest->node, gain};
    }
    return best;
}

template <int D>
double smallest_of(const Polish<D>& polish) {
    double low = polish.options.enough;
    for (const double v : polish.values) low = std::min(low, v);
    return low;
}

/// Steps for the elements below a limit, until each is above it or cannot be raised; returns their number.
template <int D>
std::size_t raise_above(Polish<D>& polish, double limit) {
    Queue queue;
    for (std::size_t e = 0; e < polish.values.size(); ++e)
        if (polish.values[e] < limit) queue.emplace(polish.values[e], ElementId(e));
    const std::size_t most = polish.options.most_steps * queue.size();
    std::size_t steps = 0;
    while (!queue.empty() && steps < most) {
        const ElementId element = queue.begin()->second;
        queue.erase(queue.begin());
        const auto move = best_move(polish, element);
        if (!move) continue;
        polish.nodes[move->edge.index()] = move->node;
        ++steps;
        for (const ElementId e : polish.shells[move->edge]) {
            double& value = polish.values[e.index()];
            queue.erase({value, e});
            value = polish.value(e);
            if (value < limit) queue.emplace(value, e);
        }
    }
    return steps;
}

/// Band after band of the worst elements, as long as the smallest value rises.
template <int D>
std::size_t polish_worst(Polish<D>& polish) {
    std::size_t steps = 0;
    double before = smallest_of(polish);
    for (int turn = 0; turn < polish.options.most_bands && before < polish.options.enough; ++turn) {
        const double band = polish.options.band * std::max(1.0, std::abs(before));
        steps += raise_above(polish, std::min(polish.options.enough, before + band));
        const double now = smallest_of(polish);
        if (now < before + polish.options.least_gain) break;
        before = now;
    }
    return steps;
}

}  // namespace

template <int D>
Outcome<Shaped<D>> shape(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                         const Column<LagrangeNode<D>>& boundary_nodes, const Incidence<ElementId>& shells,
                         const ShapeOptions& options, const Execution& execution) {
    auto extension = extend_boundary(mesh, kinds, boundary_nodes, shells, options.extension, execution);
    if (!extension) return fail(extension.error());
    Polish<D> polish{mesh, kinds, shells, options, std::move(extension->nodes), {}};
    auto values =
        map_each(execution, mesh.linear.elements.size(), [&](std::size_t e) { return polish.value(ElementId(e)); });
    if (!values) return fail(values.error());
    polish.values = std::move(*values);
    Shaped<D> shaped;
    shaped.iterations = extension->iterations;
    shaped.after_extension = smallest_of(polish);
    shaped.steps = polish_worst(polish);
    shaped.smallest = smallest_of(polish);
    Buffer<EdgeChange> changes(mesh.edges.size());
    for (std::size_t e = 0; e < changes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const LagrangeNode<D> middle{midpoint(mesh.linear.points[a], mesh.linear.points[b])};
        changes[e] = polish.nodes[e] == middle      ? EdgeChange::straight
                     : kinds[e] == EdgeKind::volume ? EdgeChange::optimised
                                                    : EdgeChange::projected;
    }
    shaped.proposal = {mesh.linear.points, std::move(polish.nodes), kinds, std::move(changes)};
    return shaped;
}

#define CAMBER_INSTANTIATE(D)                                                                         \
    template Outcome<Shaped<D>> shape<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&,            \
                                         const Column<LagrangeNode<D>>&, const Incidence<ElementId>&, \
                                         const ShapeOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
