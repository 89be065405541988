// Optimises the node of one edge, or all nodes of a cavity.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>
#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;

namespace camber {

namespace {

/// Minimum cost reduction, as a share of the edge length, that justifies a move towards the target.
constexpr double min_return = 1e-7;
/// Minimum move towards the target, as a share of the distance to it.
constexpr double min_step = 0.02;

/// Returns the elements around an edge as constraints. Valid elements, and those for which `is_preserved(e)` is true,
/// must keep min(`requested`, their scaled Jacobian).
template <int D, class IsPreserved>
EdgeShell<D> shell_of(const RepairState<D>& state, EdgeId edge, double requested, IsPreserved&& is_preserved) {
    EdgeShell<D> shell{state.moved.nodes[edge], {}};
    shell.elements.reserve(state.shells[edge].size());
    for (const ElementId e : state.shells[edge]) {
        const auto& edges = state.mesh().edges.of_elements[e];
        const auto local = static_cast<int>(std::find(edges.begin(), edges.end(), edge) - edges.begin());
        ShellElement<D> element{state.element(e), local, {}};
        if (state.good(e) || is_preserved(e)) {
            const double preserved = preserved_jacobian(state, e, requested);
            // The coefficients of a valid element may prove a lower bound than its verdict does.
            const double least =
                state.good(e) ? std::max(preserved, state.options.min_scaled_jacobian.value) : preserved;
            if (least < requested) element.required_jacobian = least;
        }
        shell.elements.push_back(element);
    }
    return shell;
}

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
    const auto try_all = [&](double requested, auto&& is_preserved) {
        for (const EdgeId edge : state.mesh().edges.of_elements[seed]) {
            if (state.kinds[edge] != EdgeKind::volume) continue;
            const QuadraticModel<D> model = state.model(edge);
            const auto nearest = nearest_node(shell_of(state, edge, requested, is_preserved), model, requested);
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
    const double target = state.options.effective_target();
    if (try_all(target, none) || try_all(target, no_other)) return best;
    // Only the method `edge` accepts a position that reaches only the bound: the other methods optimise cavities next,
    // which may still reach the target.
    if (target > bound && state.options.method == RepairMethod::edge && !try_all(bound, none)) try_all(bound, no_other);
    return best;
}

template <int D>
Planned<D> plan_return_on_segment(const RepairState<D>& state, EdgeId edge) {
    const LagrangeNode<D> from = state.moved.nodes[edge];
    const LagrangeNode<D> to{state.target_position(edge)};
    if (from == to) return {};
    const double target = state.options.effective_target();
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
    const double target = state.options.effective_target();
    const auto nearest = nearest_node(shell_of(state, edge, target, [](ElementId) { return true; }), model, target);
    if (!nearest || !(nearest->cost < now - worth)) return {{}, edge_work};
    return {plan_of(state, edge, nearest->node), edge_work};
}

namespace {

constexpr std::size_t max_edges = 240;
constexpr double surface_weight = 1e4;
/// Like `min_return`, for joint moves.
constexpr double min_joint_return = 1e-5;
/// Shares of the original straight determinant that det J must keep where vertices move, tried in this order.
constexpr std::array determinant_shares{0.2, 0.02, 0.0};

bool may_move(EdgeKind kind, CavityExtent extent) {
    const bool also_surface =
        extent.moves == CavityExtent::Moves::surface_nodes || extent.moves == CavityExtent::Moves::slides;
    return kind == EdgeKind::volume || (kind != EdgeKind::fixed && also_surface);
}

template <int D>
void add_edges(const RepairState<D>& state, ElementId e, CavityExtent extent, std::vector<EdgeId>& edges) {
    for (const EdgeId edge : state.mesh().edges.of_elements[e])
        if (may_move(state.kinds[edge], extent)) edges.push_back(edge);
}

template <int D>
std::vector<ElementId> around(const RepairState<D>& state, const std::vector<EdgeId>& edges) {
    std::vector<ElementId> elements;
    for (const EdgeId edge : edges)
        elements.insert(elements.end(), state.shells[edge].begin(), state.shells[edge].end());
    elements |= ranges::actions::sort | ranges::actions::unique;
    return elements;
}

template <int D>
bool moves_vertex(const RepairState<D>& state, VertexId v, CavityExtent extent) {
    const VertexFreedom freedom = state.around_vertices.freedom[v];
    if (freedom != VertexFreedom::sliding) return freedom == VertexFreedom::free;
    return extent.moves == CavityExtent::Moves::slides && state.vertices_onto != nullptr &&
           (*state.vertices_onto)(v, state.moved.points[v]).normal_projector != Sym<D>::identity();
}

template <int D>
void add_edges_at(const RepairState<D>& state, const std::vector<VertexId>& vertices, std::vector<EdgeId>& edges) {
    for (const VertexId v : vertices)
        for (const ElementId e : state.around_vertices.balls[v])
            for (const EdgeId edge : state.mesh().edges.of_elements[e])
                if (std::ranges::find(state.mesh().edges.vertices[edge], v) != state.mesh().edges.vertices[edge].end())
                    edges.push_back(edge);
    edges |= ranges::actions::sort | ranges::actions::unique;
}

template <int D>
double preserved_valid_jacobian(const RepairState<D>& state, ElementId e, double requested) {
    return std::max(preserved_jacobian(state, e, requested), state.options.min_scaled_jacobian + floor_slack);
}

template <int D>
double floor_of(const RepairState<D>& state, const RepairCavity<D>& cavity, ElementId e, ElementId seed,
                double requested) {
    if (e == seed) return requested;
    if (state.good(e)) return preserved_valid_jacobian(state, e, requested);
    for (const EdgeId edge : state.mesh().edges.of_elements[e])
        if (state.kinds[edge] == EdgeKind::volume && index_in(cavity.edges, edge) < 0)
            return preserved_jacobian(state, e, requested);
    return requested;
}

template <int D>
OffsetModel<D> model_of(const RepairState<D>& state, EdgeId edge) {
    const QuadraticModel<D> model = state.model(edge);
    const double weight = state.kinds[edge] == EdgeKind::volume ? 1 : surface_weight;
    return {model.centre - state.moved.nodes[edge].point, weight * model.hessian};
}

template <int D, class FloorOf>
JointProblem<D> joint_problem_of(const RepairState<D>& state, const RepairCavity<D>& cavity, FloorOf&& floor_of) {
    JointProblem<D> problem;
    problem.unknowns.reserve(cavity.edges.size() + cavity.vertices.size());
    for (const EdgeId edge : cavity.edges) problem.unknowns.push_back(model_of(state, edge));
    for (const VertexId vertex : cavity.vertices) problem.unknowns.push_back(model_of(state, vertex));
    problem.elements.reserve(cavity.elements.size());
    const int edges = static_cast<int>(cavity.edges.size());
    for (const ElementId e : cavity.elements) {
        typename JointProblem<D>::Element element{
            .bezier = bezier_form(state.element(e)), .unknowns = {}, .floor = floor_of(e)};
        for (int i = 0; i <= D; ++i) {
            const int at = index_in(cavity.vertices, state.mesh().linear.elements.vertices[e][i]);
            element.unknowns[i] = at < 0 ? JointProblem<D>::fixed : edges + at;
        }
        for (int i = 0; i < edges_per_simplex<D>; ++i) {
            const int at = index_in(cavity.edges, state.mesh().edges.of_elements[e][i]);
            element.unknowns[D + 1 + i] = at < 0 ? JointProblem<D>::fixed : at;
        }
        problem.elements.push_back(element);
    }
    return problem;
}

template <int D>
Moves<D> changes_of(const RepairState<D>& state, const RepairCavity<D>& cavity, const std::vector<Vec<D>>& offsets) {
    Moves<D> plan;
    const auto shift = [&](VertexId v) {
        const int at = index_in(cavity.vertices, v);
        return at < 0 ? Vec<D>{} : offsets[cavity.edges.size() + static_cast<std::size_t>(at)];
    };
    for (const VertexId v : cavity.vertices) plan.points.emplace_back(v, state.moved.points[v] + shift(v));
    std::vector<EdgeId> moved = cavity.edges;
    for (const ElementId e : cavity.elements)
        for (const EdgeId edge : state.mesh().edges.of_elements[e])
            for (const VertexId v : state.mesh().edges.vertices[edge])
                if (index_in(cavity.vertices, v) >= 0) moved.push_back(edge);
    moved |= ranges::actions::sort | ranges::actions::unique;
    for (const EdgeId edge : moved) {
        const auto& [a, b] = state.mesh().edges.vertices[edge];
        Vec<D> node = state.moved.nodes[edge].point + 0.5 * (shift(a) + shift(b));
        if (const int at = index_in(cavity.edges, edge); at >= 0) node += offsets[static_cast<std::size_t>(at)];
        plan.nodes.push_back({edge, {node}});
    }
    return plan;
}

template <int D>
NodalSimplex<D> changed_element(const RepairState<D>& state, const Moves<D>& plan, ElementId e) {
    NodalSimplex<D> s = state.element(e);
    const auto at = [](const auto& list, const auto& key) {
        const auto it = std::ranges::lower_bound(list, key, {}, [](const auto& entry) { return entry.first; });
        return it != list.end() && it->first == key ? &it->second : nullptr;
    };
    for (int i = 0; i <= D; ++i)
        if (const auto* point = at(plan.points, state.mesh().linear.elements.vertices[e][i])) s.nodes[i] = *point;
    for (int i = 0; i < edges_per_simplex<D>; ++i)
        if (const auto* node = at(plan.nodes, state.mesh().edges.of_elements[e][i])) s.nodes[D + 1 + i] = node->point;
    return s;
}

template <int D>
bool within_reach(const RepairState<D>& state, EdgeId edge, const LagrangeNode<D>& node) {
    const auto& [a, b] = state.mesh().edges.vertices[edge];
    const Vec<D>& p = state.moved.points[a];
    const Vec<D>& q = state.moved.points[b];
    const Vec<D> target_point = state.model(edge).centre;
    const double rounding = 1e-12 * distance(p, q);
    return distance(node.point, target_point) <=
           std::max(distance(midpoint(p, q), target_point) + rounding, state.options.boundary_tolerance);
}

template <int D>
bool judge(const RepairState<D>& state, const RepairCavity<D>& cavity, Moves<D>& plan) {
    for (const auto& [edge, node] : plan.nodes)
        if (state.kinds[edge] != EdgeKind::volume && !within_reach(state, edge, node)) return false;
    for (const ElementId e : cavity.elements) {
        const NodalSimplex<D> next = changed_element(state, plan, e);
        const Verdict now = verdict_of(state, e, next);
        if (is_degraded(state, e, next, now) || !preserves_shape(state, e, next, now)) return false;
        plan.verdicts.emplace_back(e, now);
    }
    return true;
}

template <int D>
bool repairs(const Moves<D>& plan, ElementId seed) {
    return std::ranges::find(plan.verdicts, std::pair{seed, Verdict::valid}) != plan.verdicts.end();
}

template <int D>
double cost_of(const JointProblem<D>& problem, const std::vector<Vec<D>>& offsets) {
    double sum = 0;
    for (std::size_t u = 0; u < offsets.size(); ++u) sum += problem.unknowns[u](offsets[u]);
    return sum;
}

}  // namespace

template <int D>
RepairCavity<D> repair_cavity(const RepairState<D>& state, ElementId seed, CavityExtent extent) {
    RepairCavity<D> cavity;
    add_edges(state, seed, extent, cavity.edges);
    cavity.edges |= ranges::actions::sort | ranges::actions::unique;
    for (int closure = 0; closure < extent.closures; ++closure) {
        std::vector<EdgeId> wider = cavity.edges;
        for (const ElementId e : around(state, cavity.edges)) add_edges(state, e, extent, wider);
        wider |= ranges::actions::sort | ranges::actions::unique;
        if (wider.size() > max_edges) break;
        cavity.edges = std::move(wider);
    }
    cavity.elements = around(state, cavity.edges);
    if (extent.moves == CavityExtent::Moves::volume_nodes || state.around_vertices.freedom.empty()) return cavity;
    for (const VertexId v : state.mesh().linear.elements.vertices[seed])
        if (moves_vertex(state, v, extent)) cavity.vertices.push_back(v);
    cavity.vertices |= ranges::actions::sort | ranges::actions::unique;
    if (extent.moves == CavityExtent::Moves::slides) {
        add_edges_at(state, cavity.vertices, cavity.edges);
        cavity.elements = around(state, cavity.edges);
    }
    for (const VertexId v : cavity.vertices)
        cavity.elements.insert(cavity.elements.end(), state.around_vertices.balls[v].begin(),
                               state.around_vertices.balls[v].end());
    cavity.elements |= ranges::actions::sort | ranges::actions::unique;
    return cavity;
}

template <int D>
Planned<D> plan_cavity_repair(const RepairState<D>& state, const RepairCavity<D>& cavity, ElementId seed,
                              double requested, double max_work) {
    if (cavity.edges.empty() && cavity.vertices.empty()) return {};
    const double floor = std::max(state.options.min_scaled_jacobian + floor_slack, requested);
    auto problem =
        joint_problem_of(state, cavity, [&](ElementId e) { return floor_of(state, cavity, e, seed, floor); });
    if (requested == 0) problem.first_penalty = JointProblem<D>::strong;
    Planned<D> planned;
    const auto succeeds = [&] {
        problem.max_work = max_work - planned.work;
        const auto solution = solve(problem, std::vector<Vec<D>>(problem.unknowns.size()));
        planned.work += solution.work;
        Moves<D> plan = changes_of(state, cavity, solution.offsets);
        if (!judge(state, cavity, plan) || !repairs(plan, seed)) return false;
        planned.plan = std::move(plan);
        return true;
    };
    if (cavity.vertices.empty()) {
        succeeds();
        return planned;
    }
    for (const double share : determinant_shares) {
        for (std::size_t i = 0; i < cavity.elements.size(); ++i)
            problem.elements[i].least = min_of(state, cavity, cavity.elements[i], share);
        if (succeeds()) break;
    }
    return planned;
}

template <int D>
Planned<D> plan_joint_return(const RepairState<D>& state, const RepairCavity<D>& cavity, double max_work) {
    const double target = state.options.effective_target() + floor_slack;
    auto problem = joint_problem_of(state, cavity, [&](ElementId e) {
        return state.good(e) ? preserved_valid_jacobian(state, e, target) : preserved_jacobian(state, e, target);
    });
    std::vector<Vec<D>> as_it_is(problem.unknowns.size());
    const double now = cost_of(problem, as_it_is);
    double least = now - std::max(min_joint_return, min_returned_share * now);
    if (!(least > 0)) return {};
    std::vector<Vec<D>> at_targets;
    at_targets.reserve(problem.unknowns.size());
    for (const auto& unknown : problem.unknowns) at_targets.push_back(unknown.centre);
    Planned<D> best;
    for (auto* start : {&as_it_is, &at_targets}) {
        problem.max_work = max_work - best.work;
        const auto solution = solve(problem, std::move(*start));
        best.work += solution.work;
        const double cost = cost_of(problem, solution.offsets);
        if (!(cost < least) || !(solution.shortfall < largest_shortfall)) continue;
        Moves<D> plan = changes_of(state, cavity, solution.offsets);
        if (!judge(state, cavity, plan)) continue;
        best.plan = std::move(plan);
        least = cost;
    }
    return best;
}

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template Planned<D> plan_edge_repair<D>(const RepairState<D>&, ElementId);                                  \
    template Planned<D> plan_return_on_segment<D>(const RepairState<D>&, EdgeId);                               \
    template Planned<D> plan_return<D>(const RepairState<D>&, EdgeId);                                          \
    template RepairCavity<D> repair_cavity<D>(const RepairState<D>&, ElementId, CavityExtent);                  \
    template Planned<D> plan_cavity_repair<D>(const RepairState<D>&, const RepairCavity<D>&, ElementId, double, \
                                              double);                                                          \
    template Planned<D> plan_joint_return<D>(const RepairState<D>&, const RepairCavity<D>&, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
