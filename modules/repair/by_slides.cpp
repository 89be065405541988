module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>
module camber.repair;
import :guide;
import :state;
import :vertex_moves;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.programmes;

namespace camber {

namespace {

/// Steps from one tangent plane to the next.
constexpr int most_steps = 6;
/// What a slide weighs more than a move in the volume: it takes the surface's best approximation along.
constexpr double slide_weight = 10;
/// Beside it the geometry is left at no price.
constexpr double off_weight = 1e6;
/// A node slides at most this share of its chord: at a quarter the curve's speed vanishes at an end.
constexpr double farthest = 0.24;

/// Where the nodes of a cavity are after some steps, in the order of its edges.
template <int D>
struct Sliding {
    const RepairState<D>& state;
    const RepairCavity<D>& cavity;
    std::vector<Vec<D>> nodes;
    std::vector<Sym<D>> across;  ///< of the volume: 0

    [[nodiscard]] int position_of(EdgeId edge) const {
        const auto it = std::ranges::lower_bound(cavity.edges, edge);
        return it != cavity.edges.end() && *it == edge ? static_cast<int>(it - cavity.edges.begin())
                                                       : JointProgramme<D>::fixed;
    }
    [[nodiscard]] NodalSimplex<D> element(ElementId e) const {
        NodalSimplex<D> s = state.element(e);
        for (int i = 0; i < edges_per_simplex<D>; ++i)
            if (const int at = position_of(state.mesh().edges.of_elements[e][i]); at >= 0)
                s.nodes[D + 1 + i] = nodes[static_cast<std::size_t>(at)];
        return s;
    }
    [[nodiscard]] bool slides(std::size_t i) const { return state.kinds[cavity.edges[i]] != EdgeKind::volume; }
    /// x without its part off the geometry.
    [[nodiscard]] Vec<D> along(std::size_t i, const Vec<D>& x) const { return x - across[i] * x; }
    void bring_back(std::size_t i) {
        if (!slides(i)) return;
        const GeometryFoot<D> foot = (*state.onto)(cavity.edges[i], nodes[i]);
        nodes[i] = foot.point;
        across[i] = foot.across;
    }
};

template <int D>
Sliding<D> beginning(const RepairState<D>& state, const RepairCavity<D>& cavity) {
    Sliding<D> at{state, cavity, {}, std::vector<Sym<D>>(cavity.edges.size())};
    at.nodes.reserve(cavity.edges.size());
    for (const EdgeId edge : cavity.edges) at.nodes.push_back(state.moved.nodes[edge].point);
    for (std::size_t i = 0; i < cavity.edges.size(); ++i) at.bring_back(i);
    return at;
}

/// What it costs node i to go on from where it is.
template <int D>
OffsetModel<D> model_at(const Sliding<D>& at, std::size_t i) {
    const QuadraticModel<D> model = at.state.model(at.cavity.edges[i]);
    const Vec<D> back = model.centre - at.nodes[i];
    if (!at.slides(i)) return {back, model.hessian};
    double trace = 0;
    for (int k = 0; k < D; ++k) trace += model.hessian(k, k);
    return {at.along(i, back), slide_weight * model.hessian + off_weight * trace * at.across[i]};
}

/// `wish`: what the seed is to have.
template <int D>
JointProgramme<D> programme_at(const Sliding<D>& at, ElementId seed, double wish) {
    const RepairState<D>& state = at.state;
    JointProgramme<D> programme;
    programme.unknowns.reserve(at.nodes.size());
    for (std::size_t i = 0; i < at.nodes.size(); ++i) programme.unknowns.push_back(model_at(at, i));
    programme.elements.reserve(at.cavity.elements.size());
    const double bound = state.options.min_scaled_jacobian + floor_slack;
    for (const ElementId e : at.cavity.elements) {
        const double kept = jacobian_to_keep(state, e, wish);
        typename JointProgramme<D>::Element element{.bezier = bezier_form(at.element(e)),
                                                    .unknowns = {},
                                                    .floor = e == seed       ? wish
                                                             : state.good(e) ? std::max(kept, bound)
                                                                             : kept};
        element.unknowns.fill(JointProgramme<D>::fixed);
        for (int i = 0; i < edges_per_simplex<D>; ++i)
            element.unknowns[D + 1 + i] = at.position_of(state.mesh().edges.of_elements[e][i]);
        programme.elements.push_back(element);
    }
    return programme;
}

/// The places as a plan with its verdicts; nothing where they spoil an element or do not repair the seed.
template <int D>
std::optional<Moves<D>> plan_of(const Sliding<D>& at, ElementId seed) {
    const RepairState<D>& state = at.state;
    Moves<D> plan;
    for (std::size_t i = 0; i < at.nodes.size(); ++i) {
        const EdgeId edge = at.cavity.edges[i];
        const auto& [a, b] = state.mesh().edges.vertices[edge];
        const double chord = distance(state.moved.points[a], state.moved.points[b]);
        if (at.slides(i) && distance(at.nodes[i], state.wanted(edge)) > farthest * chord) return std::nullopt;
        plan.nodes.push_back({edge, {at.nodes[i]}});
    }
    for (const ElementId e : at.cavity.elements) {
        const NodalSimplex<D> next = at.element(e);
        const Verdict now = verdict_of(state, e, next);
        if (spoilt(state, e, next, now) || (e == seed && now != Verdict::valid)) return std::nullopt;
        plan.verdicts.emplace_back(e, now);
    }
    return plan;
}

}  // namespace

template <int D>
Planned<D> plan_slide_repair(const RepairState<D>& state, const RepairCavity<D>& cavity, ElementId seed, double asked,
                             double most_work) {
    const auto is_volume = [&](EdgeId e) { return state.kinds[e] == EdgeKind::volume; };
    if (std::ranges::all_of(cavity.edges, is_volume)) return {};
    const double wish = std::max(state.options.min_scaled_jacobian + floor_slack, asked);
    Planned<D> planned;
    Sliding<D> at = beginning(state, cavity);
    for (int step = 0; step < most_steps && planned.work < most_work; ++step) {
        auto programme = programme_at(at, seed, wish);
        programme.first_penalty = JointProgramme<D>::strong;
        programme.most_work = most_work - planned.work;
        const auto solution = solve(programme, std::vector<Vec<D>>(programme.unknowns.size()));
        planned.work += solution.work;
        for (std::size_t i = 0; i < at.nodes.size(); ++i) {
            at.nodes[i] += at.along(i, solution.offsets[i]);
            at.bring_back(i);
        }
        planned.plan = plan_of(at, seed);
        if (planned.plan) break;
    }
    return planned;
}

#define CAMBER_INSTANTIATE(D) \
    template Planned<D> plan_slide_repair<D>(const RepairState<D>&, const RepairCavity<D>&, ElementId, double, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
