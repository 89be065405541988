module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.repair;
import :state;
import :vertex_moves;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;

namespace camber {

namespace {

/// A return that wins less of an edge's length is not made.
constexpr double min_return = 1e-7;
/// Nor one on a segment that goes less of the way.
constexpr double min_step = 0.02;

/// The elements around an edge with what they are to keep where `asked` is wanted: all that are good, and all that
/// `keeps` says of the others.
template <int D, class Keeps>
EdgeShell<D> shell_of(const RepairState<D>& state, EdgeId edge, double asked, Keeps&& keeps) {
    EdgeShell<D> shell{state.moved.nodes[edge], {}};
    shell.elements.reserve(state.shells[edge].size());
    for (const ElementId e : state.shells[edge]) {
        const auto& edges = state.mesh().edges.of_elements[e];
        const auto local = static_cast<int>(std::find(edges.begin(), edges.end(), edge) - edges.begin());
        ShellElement<D> element{state.element(e), local, {}};
        if (state.good(e) || keeps(e)) {
            const double kept = jacobian_to_keep(state, e, asked);
            // A good element whose coefficients are too weak a test still holds the bound.
            const double least = state.good(e) ? std::max(kept, state.options.min_scaled_jacobian.value) : kept;
            if (least < asked) element.keep = least;
        }
        shell.elements.push_back(element);
    }
    return shell;
}

/// The plan that moves one node, with the verdicts around it.
template <int D>
std::optional<Moves<D>> plan_of(const RepairState<D>& state, EdgeId edge, const LagrangeNode<D>& node) {
    Moves<D> plan;
    plan.nodes.emplace_back(edge, node);
    for (const ElementId e : state.shells[edge]) {
        const NodalSimplex<D> element = state.moved.element_with(e, edge, node);
        const Verdict now = verdict_of(state, e, element);
        if (is_degraded(state, e, element, now)) return {};
        plan.verdicts.emplace_back(e, now);
    }
    return plan;
}

}  // namespace

template <int D>
Planned<D> plan_edge_repair(const RepairState<D>& state, ElementId seed) {
    const double bound = state.options.min_scaled_jacobian;
    const auto no_other = [&](ElementId e) { return e != seed; };
    const auto none = [](ElementId) { return false; };
    Planned<D> best;
    double least = 0;
    const auto try_all = [&](double asked, auto&& keeps) {
        for (const EdgeId edge : state.mesh().edges.of_elements[seed]) {
            if (state.kinds[edge] != EdgeKind::volume) continue;
            const QuadraticModel<D> model = state.model(edge);
            const auto nearest = nearest_node(shell_of(state, edge, asked, keeps), model, asked);
            best.work += edge_work;
            if (!nearest) continue;
            const double cost = nearest->cost - model(state.moved.nodes[edge].point);
            if (best.plan && !(cost < least)) continue;
            auto plan = plan_of(state, edge, nearest->node);
            const bool repaired = plan && std::ranges::any_of(plan->verdicts, [&](const auto& v) {
                                      return v.first == seed && v.second == Verdict::valid;
                                  });
            if (!repaired) continue;
            best.plan = std::move(plan);
            least = cost;
        }
        return best.plan.has_value();
    };
    const double target = state.options.aim();
    if (try_all(target, none) || try_all(target, no_other)) return best;
    // Cavities may still reach the target.
    if (target > bound && state.options.method == RepairMethod::edge && !try_all(bound, none)) try_all(bound, no_other);
    return best;
}

template <int D>
Planned<D> plan_return_on_segment(const RepairState<D>& state, EdgeId edge) {
    const LagrangeNode<D> from = state.moved.nodes[edge];
    const LagrangeNode<D> to{state.wanted(edge)};
    if (from == to) return {};
    const double target = state.options.aim();
    std::vector<AffineConstraint> constraints;
    for (const ElementId e : state.shells[edge]) {
        const auto here = bounded_jacobian(state.element(e));
        const auto there = bounded_jacobian(state.moved.element_with(e, edge, to));
        const double scale = std::abs(here.straight) > 0 ? std::abs(here.straight) : 1;
        const double now = *std::ranges::min_element(here.coefficients) / scale;
        const double floor = std::min(now, target + 4 * std::max(here.error, there.error) / scale);
        for (int i = 0; i < jacobian_coefficients<D>; ++i)
            if (here.coefficients[i] != there.coefficients[i])
                constraints.push_back({here.coefficients[i] / scale, there.coefficients[i] / scale, floor});
    }
    const auto interval = feasible(constraints);
    if (!interval || interval->high < min_step) return {};
    const LagrangeNode<D> node =
        interval->high < 1 ? LagrangeNode<D>{from.point + interval->high * (to.point - from.point)} : to;
    return {plan_of(state, edge, node)};
}

template <int D>
Planned<D> plan_return(const RepairState<D>& state, EdgeId edge) {
    const QuadraticModel<D> model = state.model(edge);
    const double now = model(state.moved.nodes[edge].point);
    const double worth = std::max(min_return, min_returned_share * now);
    if (!(now > worth)) return {};
    const double target = state.options.aim();
    const auto nearest = nearest_node(shell_of(state, edge, target, [](ElementId) { return true; }), model, target);
    if (!nearest || !(nearest->cost < now - worth)) return {{}, edge_work};
    return {plan_of(state, edge, nearest->node), edge_work};
}

#define CAMBER_INSTANTIATE(D)                                                     \
    template Planned<D> plan_edge_repair<D>(const RepairState<D>&, ElementId);    \
    template Planned<D> plan_return_on_segment<D>(const RepairState<D>&, EdgeId); \
    template Planned<D> plan_return<D>(const RepairState<D>&, EdgeId);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
