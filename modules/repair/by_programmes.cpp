module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import :held_vertices;
import :by_programmes;
import :moved_mesh;
import :rounds;
import :state;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.programmes;
import camber.curving;

namespace camber {

namespace {

/// Turns over what may return, while any of it does.
constexpr int most_edge_turns = 4;
constexpr int most_joint_turns = 12;
/// What one pass may take of the work that is left.
constexpr double most_of_work = 0.5;
/// Passes in a repair that needs all of them.
constexpr std::size_t most_passes = 14;
/// Elements with an edge that costs less of its length return by single edges only.
constexpr double costly = 1e-3;

/// The passes of a repair over the elements that are not good enough yet, the queue.
template <int D>
struct Passes {
    RepairState<D> state;
    std::vector<ElementId> queue;
    Execution execution;
    std::size_t begun = 0;   ///< passes so far
    bool cut_short = false;  ///< some pass spent the work that it had and left elements

    [[nodiscard]] Outcome<Done> by_edges() {
        return over_queue([&](ElementId e) { return repair_cavity(state, e, Reach{}).elements; },
                          [&](ElementId e, double) { return plan_edge_repair(state, e); });
    }
    [[nodiscard]] Outcome<Done> by_cavities(Reach reach, double asked) {
        return over_queue([&](ElementId e) { return repair_cavity(state, e, reach).elements; },
                          [&](ElementId e, double most_work) {
                              return plan_cavity_repair(state, repair_cavity(state, e, reach), e, asked, most_work);
                          });
    }
    /// Around what is left, and outwards until all is above `bound`, the nodes extend the boundary's displacement; what
    /// this spoils is repaired as before, or stays as it was.
    [[nodiscard]] Outcome<Done> by_extension(double bound) {
        const Execution quiet = without_progress(execution);
        auto extended = extend_boundary(state.mesh(), state.kinds, state.moved.nodes.column(), state.shells, {}, quiet);
        if (!extended) return fail(extended.error());
        // It is of the mesh's own vertices, some of which may have moved.
        for (std::size_t e = 0; e < extended->nodes.size(); ++e)
            extended->nodes[e].point += state.moved.shift(EdgeId(e));
        Passes trial{state, {}, quiet};
        const auto moves = plan_extension(state, queue, Column<LagrangeNode<D>>(std::move(extended->nodes)), bound);
        trial.state.moved.apply(moves);
        trial.queue = queue;
        for (const auto& [element, verdict] : moves.verdicts) trial.queue.push_back(element);
        trial.queue |= ranges::actions::sort | ranges::actions::unique;
        std::erase_if(trial.queue, [&](ElementId e) { return trial.state.good(e); });
        auto done = trial.by_cavities({Reach::Moves::volume_nodes, 0}, state.options.target);
        if (done) done = trial.by_edges();
        if (!done) return done;
        state.work_left = trial.state.work_left;
        state.work = trial.state.work;
        cut_short = cut_short || trial.cut_short;
        const auto plan = plan_towards(state, trial.state.moved.nodes);
        const auto repaired = [&](const auto& v) { return v.second == Verdict::valid && !state.good(v.first); };
        if (std::ranges::any_of(plan.verdicts, repaired)) state.moved.apply(plan);
        return finish(Done{});
    }
    /// Nodes that are off their places come as near as they may, one at a time.
    [[nodiscard]] Outcome<Done> returns() {
        std::vector<EdgeId> edges;
        for (std::size_t e = 0; e < state.kinds.size(); ++e)
            if (state.kinds[e] == EdgeKind::volume && state.moved.nodes[EdgeId(e)].point != state.models[e].centre)
                edges.push_back(EdgeId(e));
        const auto claim = [&](EdgeId e) {
            return std::vector<ElementId>(state.shells[e].begin(), state.shells[e].end());
        };
        return while_moving(std::move(edges), most_edge_turns, claim,
                            [&](EdgeId e, double) { return plan_return(state, e); });
    }
    /// And those of an element together, where one of them costs much.
    [[nodiscard]] Outcome<Done> joint_returns() {
        std::vector<ElementId> elements;
        for (std::size_t e = 0; e < state.mesh().linear.elements.size(); ++e)
            if (std::ranges::any_of(state.mesh().edges.of_elements[e], [&](EdgeId edge) { return is_costly(edge); }))
                elements.push_back(ElementId(e));
        const auto claim = [&](ElementId e) { return repair_cavity(state, e, Reach{}).elements; };
        return while_moving(std::move(elements), most_joint_turns, claim, [&](ElementId e, double most_work) {
            return plan_joint_return(state, repair_cavity(state, e, Reach{}), most_work);
        });
    }

  private:
    [[nodiscard]] bool is_costly(EdgeId edge) const {
        return state.kinds[edge] == EdgeKind::volume && state.model(edge)(state.moved.nodes[edge].point) > costly;
    }
    Outcome<Done> finish(Outcome<Done> done) {
        std::erase_if(queue, [&](ElementId e) { return state.good(e); });
        return done;
    }
    /// The next pass's share of the progress of them all.
    [[nodiscard]] Execution next_pass(std::size_t turn = 0, std::size_t turns = 1) {
        if (turn == 0) ++begun;
        if (!execution.progress) return execution;
        constexpr std::size_t fine = 1000;
        const std::size_t from = (begun - 1) * fine + turn * fine / turns;
        return {execution.threads, execution.stop, [this, from, turns](std::size_t done, std::size_t total) {
                    execution.progress(from + fine / turns * done / total, most_passes * fine);
                }};
    }
    template <class ClaimOf, class Plan>
    Outcome<Done> over_queue(ClaimOf&& claim, Plan&& plan) {
        // A pass that repairs nothing leaves something to those that come after it.
        const double kept = state.work_left * (1 - most_of_work);
        state.work_left -= kept;
        auto done = finish(plan_in_rounds(
            state, queue, next_pass(), [&](ElementId e) { return state.good(e); }, claim, plan,
            [](ElementId, const Planned<D>&) {}));
        cut_short = cut_short || (state.exhausted() && !queue.empty());
        state.work_left += kept;
        return done;
    }
    /// Turns over the items, each next one over those with an element that the last one claimed and moved: there may be
    /// room now.
    template <class Item, class ClaimOf, class Plan>
    Outcome<Done> while_moving(std::vector<Item> items, int most_turns, ClaimOf&& claim, Plan&& plan) {
        for (int turn = 0; turn < most_turns && !items.empty(); ++turn) {
            SparseSet<ElementId> near;
            const auto mark = [&](const Item& item, const Planned<D>& planned) {
                if (!planned.plan) return;
                for (const ElementId e : claim(item)) near.insert(e);
            };
            const Execution share = next_pass(static_cast<std::size_t>(turn), static_cast<std::size_t>(most_turns));
            auto done = plan_in_rounds(state, items, share, [](const Item&) { return false; }, claim, plan, mark);
            if (!done) return done;
            std::erase_if(items, [&](const Item& item) {
                return std::ranges::none_of(claim(item), [&](ElementId e) { return near.contains(e); });
            });
        }
        return Done{};
    }
};

template <int D>
Outcome<Done> run(Passes<D>& passes, RepairStatistics& s) {
    using Moves = Reach::Moves;
    const RepairOptions& options = passes.state.options;
    const bool with_cavities = options.method == RepairMethod::cavity;
    Outcome<Done> done = Done{};
    const auto counted = [&](std::size_t& counter, auto&& pass) {
        if (!done || passes.queue.empty()) return;
        const std::size_t before = passes.queue.size();
        done = pass();
        counter += before - passes.queue.size();
    };
    const auto cavities = [&](std::size_t& counter, Reach reach, double asked) {
        if (with_cavities) counted(counter, [&] { return passes.by_cavities(reach, asked); });
    };
    const auto extension = [&](double bound) {
        if (with_cavities) counted(s.by_extension, [&] { return passes.by_extension(bound); });
    };
    const auto by_volume_nodes = [&] {
        cavities(s.by_cavities, {Moves::volume_nodes, 0}, options.target);
        counted(s.by_edges, [&] { return passes.by_edges(); });
        extension(0);
        extension(options.min_scaled_jacobian);
        cavities(s.by_cavities, {Moves::volume_nodes, 1}, options.target);
        cavities(s.by_cavities, {Moves::volume_nodes, 1}, 0);
        cavities(s.by_cavities, {Moves::volume_nodes, 2}, 0);
    };
    by_volume_nodes();
    cavities(s.by_vertices, {Moves::vertices, 1}, 0);
    if (s.by_vertices > 0) by_volume_nodes();
    cavities(s.by_surface, {Moves::surface_nodes, 1}, 0);
    if (done) done = passes.returns();
    if (done && with_cavities) done = passes.joint_returns();
    return done;
}

/// The state as a proposal, judged as a whole.
template <int D>
Outcome<Repaired<D>> judge_all(const RepairState<D>& state, bool cut_short, const JudgedProposal<D>& wanted,
                               const RepairStatistics& passes, const Execution& execution) {
    auto judged =
        validate(wanted.mesh(), state.moved.proposal(wanted.proposal()), wanted.validation().bound, execution);
    if (!judged) return fail(judged.error());
    RepairStatistics statistics = changes_between(wanted, *judged);
    statistics.work = state.work;
    statistics.by_edges = passes.by_edges;
    statistics.by_cavities = passes.by_cavities;
    statistics.by_extension = passes.by_extension;
    statistics.by_vertices = passes.by_vertices;
    statistics.by_surface = passes.by_surface;
    std::vector<ElementId> given_up;
    if (cut_short) given_up = elements_not_valid(judged->validation());
    return Repaired<D>{std::move(*judged), statistics, std::move(given_up)};
}

}  // namespace

template <int D>
Outcome<Repaired<D>> repair_by_programmes(const JudgedProposal<D>& wanted, const Column<QuadraticModel<D>>& models,
                                          const RepairOptions& options, const Execution& execution) {
    const QuadraticMesh<D>& mesh = wanted.mesh();
    const Proposal<D>& proposal = wanted.proposal();
    const auto around = shells(mesh.edges, execution);
    if (!around) return fail(around.error());
    const auto vertex_balls = balls(mesh.linear, execution);
    if (!vertex_balls) return fail(vertex_balls.error());
    const double most_work = std::min(allowed_work(wanted.validation().not_valid(), options.effort), options.most_work);
    Schedule schedule(mesh.linear.elements.size());
    Passes<D> passes{{MovedMesh<D>(wanted), *around, *vertex_balls, models, options, proposal.kinds,
                      held_vertices(mesh, proposal.kinds, options.vertices), schedule, most_work, 0},
                     elements_not_valid(wanted.validation()),
                     execution};
    RepairStatistics statistics;
    if (auto done = run(passes, statistics); !done) return fail(done.error());
    return judge_all(passes.state, passes.cut_short, wanted, statistics, execution);
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<Repaired<D>> repair_by_programmes<D>(const JudgedProposal<D>&, const Column<QuadraticModel<D>>&, \
                                                          const RepairOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
