module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.extension;
import camber.validity;
import camber.optimisation;

namespace camber {

template <int D>
Outcome<Shaped<D>> shape(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                         const Column<LagrangeNode<D>>& boundary_nodes, const Incidence<ElementId>& shells,
                         const ShapeOptions& options, const Execution& execution) {
    auto extension = extend_boundary(mesh, kinds, boundary_nodes, shells, options.extension, execution);
    if (!extension) return fail(extension.error());
    auto polished = polish(mesh, kinds, std::move(extension->nodes), shells, options, execution);
    if (!polished) return fail(polished.error());
    auto& nodes = polished->nodes;
    Shaped<D> shaped;
    shaped.iterations = extension->iterations;
    shaped.solved = extension->solved;
    shaped.after_extension = polished->before;
    shaped.steps = polished->steps;
    shaped.smallest = polished->smallest;
    Buffer<EdgeChange> changes(mesh.edges.size());
    for (std::size_t e = 0; e < changes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const LagrangeNode<D> middle{midpoint(mesh.linear.points[a], mesh.linear.points[b])};
        changes[e] = nodes[e] == middle             ? EdgeChange::straight
                     : kinds[e] == EdgeKind::volume ? EdgeChange::optimised
                                                    : EdgeChange::projected;
    }
    shaped.proposal = {mesh.linear.points, std::move(nodes), kinds, std::move(changes)};
    return shaped;
}

namespace {

constexpr std::size_t programme_grain = 16;

/// Best node position of an edge, and the increase of the smallest scaled Jacobian by it; 0 if it is too small.
template <int D>
struct Raise {
    LagrangeNode<D> node;
    double gain = 0;
};

/// `stuck`: no edge improves the element until elements around it change.
enum class Turn : std::uint8_t { none, waiting, stuck };

template <int D>
struct Polish {
    const QuadraticMesh<D>& mesh;
    const Column<EdgeKind>& kinds;
    const Incidence<ElementId>& shells;
    const ShapeOptions& options;
    Execution execution;
    Buffer<LagrangeNode<D>> nodes;
    Buffer<double> values;
    Buffer<double> requested;
    Buffer<Turn> turns;
    Buffer<std::uint8_t> is_known;  ///< for each edge: 1 if the elements around it are unchanged since its linear
                                    ///< program was solved
    Buffer<Raise<D>> raises;
    Buffer<std::uint32_t> changed_in;
    std::uint32_t round = 0;

    [[nodiscard]] double value(ElementId e) const {
        const auto element = nodal_element<D>(mesh, nodes, e);
        const double by_coefficients = smallest_scaled_coefficient(bounded_jacobian(element));
        if (options.program.max_cuts == 0 || by_coefficients >= options.enough) return by_coefficients;
        return check_element(element, 0).min_scaled_jacobian;
    }
    [[nodiscard]] double smallest() const {
        double low = options.enough;
        for (const double v : values) low = std::min(low, v);
        return low;
    }
    [[nodiscard]] bool is_low(ElementId e) const { return values[e.index()] < requested[e.index()]; }
    [[nodiscard]] Raise<D> raise(EdgeId edge) const {
        double now = values[shells[edge].front().index()];
        for (const ElementId e : shells[edge]) now = std::min(now, values[e.index()]);
        auto program = options.program;
        program.enough = options.enough;
        program.least = now + options.min_gain;
        const auto highest = max_min_node(edge_shell<D>(mesh, nodes, shells[edge], edge), program);
        if (!highest || !(highest->lower - now > options.min_gain)) return {};
        return {highest->node, highest->lower - now};
    }
    [[nodiscard]] bool has_changed(EdgeId edge) const {
        return std::ranges::any_of(shells[edge], [&](ElementId e) { return changed_in[e.index()] == round; });
    }
};

template <int D>
Outcome<Done> solve_programmes(Polish<D>& polish, std::span<const ElementId> elements) {
    std::vector<EdgeId> edges;
    for (const ElementId e : elements)
        for (const EdgeId edge : polish.mesh.edges.of_elements[e]) {
            if (polish.kinds[edge] != EdgeKind::volume || polish.is_known[edge.index()] != 0) continue;
            polish.is_known[edge.index()] = 1;
            edges.push_back(edge);
        }
    return each(
        polish.execution, edges.size(),
        [&](std::size_t i) { polish.raises[edges[i].index()] = polish.raise(edges[i]); }, programme_grain);
}

template <int D>
EdgeId best_edge(const Polish<D>& polish, ElementId element) {
    EdgeId best;
    double most = 0;
    for (const EdgeId edge : polish.mesh.edges.of_elements[element]) {
        if (polish.kinds[edge] != EdgeKind::volume) continue;
        if (const double gain = polish.raises[edge.index()].gain; gain > most) most = gain, best = edge;
    }
    return best;
}

template <int D>
Outcome<Done> look_again(Polish<D>& polish, std::span<const ElementId> changed) {
    for (const ElementId element : changed)
        for (const EdgeId edge : polish.mesh.edges.of_elements[element]) {
            if (polish.is_known[edge.index()] == 0) continue;
            polish.is_known[edge.index()] = 0;
            for (const ElementId e : polish.shells[edge])
                if (polish.turns[e.index()] == Turn::stuck) polish.turns[e.index()] = Turn::none;
        }
    return each(polish.execution, changed.size(),
                [&](std::size_t i) { polish.values[changed[i].index()] = polish.value(changed[i]); });
}

template <int D>
Outcome<std::size_t> take_turns(Polish<D>& polish, std::vector<ElementId>& waiting) {
    if (auto solved = solve_programmes<D>(polish, waiting); !solved) return fail(solved.error());
    std::sort(waiting.begin(), waiting.end(), [&](ElementId a, ElementId b) {
        return std::tuple(polish.values[a.index()], a) < std::tuple(polish.values[b.index()], b);
    });
    ++polish.round;
    std::size_t steps = 0;
    std::vector<ElementId> changed, next;
    for (const ElementId element : waiting) {
        const EdgeId edge = best_edge(polish, element);
        if (!edge.valid()) {
            polish.turns[element.index()] = Turn::stuck;
        } else if (polish.has_changed(edge)) {
            next.push_back(element);
        } else {
            polish.nodes[edge.index()] = polish.raises[edge.index()].node;
            ++steps;
            for (const ElementId e : polish.shells[edge]) {
                polish.changed_in[e.index()] = polish.round;
                changed.push_back(e);
            }
        }
    }
    if (auto done = look_again<D>(polish, changed); !done) return fail(done.error());
    for (const ElementId e : next) polish.turns[e.index()] = Turn::none;
    for (const ElementId e : changed) polish.turns[e.index()] = Turn::none;
    waiting.clear();
    for (const auto& some : {next, changed})
        for (const ElementId e : some) {
            if (!polish.is_low(e) || polish.turns[e.index()] == Turn::waiting) continue;
            polish.turns[e.index()] = Turn::waiting;
            waiting.push_back(e);
        }
    return steps;
}

template <int D>
Outcome<std::size_t> raise_low(Polish<D>& polish) {
    std::vector<ElementId> waiting;
    for (std::size_t e = 0; e < polish.values.size(); ++e)
        if (polish.is_low(ElementId(e)) && polish.turns[e] == Turn::none) {
            polish.turns[e] = Turn::waiting;
            waiting.emplace_back(e);
        }
    const std::size_t most = polish.options.max_steps * waiting.size();
    std::size_t steps = 0;
    while (!waiting.empty() && steps < most) {
        const auto taken = take_turns(polish, waiting);
        if (!taken) return fail(taken.error());
        steps += *taken;
    }
    for (const ElementId e : waiting) polish.turns[e.index()] = Turn::none;
    return steps;
}

template <int D>
void request_around(Polish<D>& polish, double limit) {
    const double enough = polish.options.enough;
    std::vector<ElementId> ring;
    for (std::size_t e = 0; e < polish.values.size(); ++e)
        if (polish.values[e] < limit) ring.emplace_back(e), polish.requested[e] = enough;
    for (int k = 0; k < polish.options.rings; ++k) {
        std::vector<ElementId> next;
        for (const ElementId element : ring)
            for (const EdgeId edge : polish.mesh.edges.of_elements[element])
                for (const ElementId e : polish.shells[edge])
                    if (polish.requested[e.index()] < enough) polish.requested[e.index()] = enough, next.push_back(e);
        ring = std::move(next);
    }
}

template <int D>
Outcome<Polished<D>> in_bands(Polish<D>& at) {
    auto valued = each(at.execution, at.values.size(), [&](std::size_t e) { at.values[e] = at.value(ElementId(e)); });
    if (!valued) return fail(valued.error());
    const double enough = at.options.enough;
    double now = at.smallest();
    Polished<D> polished{{}, 0, now, now};
    bool rises = true;
    for (int turn = 0; turn < at.options.max_bands && now < enough; ++turn) {
        const double band = at.options.band * std::max(1.0, std::abs(now));
        at.requested.assign(at.requested.size(), std::min(enough, now + band));
        // If the worst elements do not improve, changes of the elements around them may help.
        const bool last = !rises;
        if (last) request_around(at, now + at.options.min_gain);
        const auto steps = raise_low(at);
        if (!steps) return fail(steps.error());
        polished.steps += *steps;
        polished.smallest = at.smallest();
        rises = polished.smallest >= now + at.options.min_gain;
        if (last && !rises) break;
        now = polished.smallest;
    }
    polished.nodes = std::move(at.nodes);
    return polished;
}

}  // namespace

template <int D>
Outcome<Polished<D>> polish(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds, Buffer<LagrangeNode<D>> nodes,
                            const Incidence<ElementId>& shells, const ShapeOptions& options,
                            const Execution& execution) {
    const std::size_t elements = mesh.linear.elements.size();
    const std::size_t edges = mesh.edges.size();
    return guarded([&] {
        Polish<D> at{mesh,
                     kinds,
                     shells,
                     options,
                     without_progress(execution),
                     std::move(nodes),
                     Buffer<double>(elements),
                     Buffer<double>(elements),
                     Buffer<Turn>(elements, Turn::none),
                     Buffer<std::uint8_t>(edges, std::uint8_t{0}),
                     Buffer<Raise<D>>(edges),
                     Buffer<std::uint32_t>(elements, 0U)};
        return in_bands(at);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<Shaped<D>> shape<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&,                             \
                                         const Column<LagrangeNode<D>>&, const Incidence<ElementId>&,                  \
                                         const ShapeOptions&, const Execution&);                                       \
    template Outcome<Polished<D>> polish<D>(const QuadraticMesh<D>&, const Column<EdgeKind>&, Buffer<LagrangeNode<D>>, \
                                            const Incidence<ElementId>&, const ShapeOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
