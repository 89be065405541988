module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import :nodewise;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.soundness;

namespace camber {

namespace {

/// Turns over all elements that are not valid, and over all moved edges.
constexpr int most_rounds = 20;
constexpr int put_back_rounds = 2;

template <int D>
Outcome<Done> sound(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const RelaxOptions& options) {
    const std::size_t edges = mesh.edges.size();
    if (proposal.mid_nodes.size() != edges || proposal.kinds.size() != edges || proposal.changes.size() != edges)
        return fail(ErrorKind::internal, "the proposal has another number of edges than the mesh");
    return check_limits(options);
}

template <int D>
std::vector<ElementId> elements_not_valid(const Repair<D>& repair) {
    std::vector<ElementId> queue;
    for (std::size_t e = 0; e < repair.verdicts.size(); ++e)
        if (repair.verdicts[e] != Verdict::valid) queue.push_back(ElementId(e));
    return queue;
}

/// Repair is in order, one element after the other: what is done to one decides what the next one needs.
[[nodiscard]] Execution in_order(const Execution& execution) { return {1, execution.stop, execution.progress}; }

/// f(element) for those of the queue that are not valid when their turn comes; keeps these in the queue. True if any f
/// did something.
template <int D, class F>
Outcome<bool> turn(Repair<D>& repair, std::vector<ElementId>& queue, const Execution& execution, F&& f) {
    bool any = false;
    auto done = each(in_order(execution), queue.size(), [&](std::size_t i) {
        if (!repair.valid(queue[i]) && f(queue[i])) any = true;
    });
    if (!done) return fail(done.error());
    std::erase_if(queue, [&](ElementId e) { return repair.valid(e); });
    return any;
}

template <int D>
Outcome<Done> mend_in_rounds(Repair<D>& repair, std::vector<ElementId>& queue, EdgeGroup group, Steps steps,
                             const Execution& execution) {
    for (int round = 0; round < most_rounds && !queue.empty(); ++round) {
        const auto any = turn(repair, queue, execution, [&](ElementId e) { return mend(repair, e, group, steps); });
        if (!any) return fail(any.error());
        if (!*any) break;
    }
    return Done{};
}

/// The paper's correction (§3.2) over a queue: all volume edges of an element that is not valid by θ, surface edges
/// once its volume edges are straight; what breaks joins the next round. Ends: every edge is straight after
/// max_corrections + 1 steps.
template <int D>
Outcome<Done> relax_plainly(Repair<D>& repair, std::vector<ElementId> queue, const Execution& execution) {
    std::map<EdgeId, int> corrections;
    while (!queue.empty()) {
        std::vector<ElementId> next;
        auto done = each(in_order(execution), queue.size(), [&](std::size_t i) {
            const ElementId e = queue[i];
            if (repair.valid(e)) return;
            std::vector<EdgeId> loose = loose_edges(repair, e, EdgeGroup::volume);
            if (loose.empty()) loose = loose_edges(repair, e, EdgeGroup::surface);
            if (loose.empty()) return;  // straight, and still not valid
            Changes<D> changes;
            for (const EdgeId edge : loose) {
                const bool last = ++corrections[edge] > repair.options.max_corrections;
                move_node(repair, edge, repair.towards_middle(edge, last ? 0 : repair.options.theta), changes);
            }
            check_shells(repair, loose, changes);
            next.insert(next.end(), changes.broken.begin(), changes.broken.end());
            if (!repair.valid(e)) next.push_back(e);
        });
        if (!done) return fail(done.error());
        next |= ranges::actions::sort | ranges::actions::unique;
        queue = std::move(next);
    }
    return Done{};
}

/// Surface and ridge nodes first: they make the geometry.
template <int D>
Outcome<Done> put_all_back(Repair<D>& repair, const Execution& execution) {
    std::vector<EdgeId> moved;
    moved.reserve(repair.originals.size());
    for (const auto& [edge, node] : repair.originals) moved.push_back(edge);
    std::ranges::sort(moved, {}, [&](EdgeId e) { return std::pair(repair.kinds[e] == EdgeKind::volume, e); });
    for (int round = 0; round < put_back_rounds; ++round) {
        auto done = each(in_order(execution), moved.size(), [&](std::size_t i) { put_back(repair, moved[i]); });
        if (!done) return fail(done.error());
    }
    return Done{};
}

template <int D>
Outcome<Done> relax_by_shells(Repair<D>& repair, const Execution& execution) {
    std::vector<ElementId> queue = elements_not_valid(repair);
    const auto in_rounds = [&](EdgeGroup group, Steps steps) {
        return mend_in_rounds(repair, queue, group, steps, execution);
    };
    const auto with_neighbours = [&](EdgeGroup group, double scaled_jacobian) -> Outcome<Done> {
        return turn(repair, queue, execution,
                    [&](ElementId e) { return mend_with_neighbours(repair, e, group, scaled_jacobian); })
            .map([](bool) { return Done{}; });
    };
    const double bound = repair.options.min_scaled_jacobian;
    const double target = std::max(bound, repair.options.target);
    for (const EdgeGroup group : {EdgeGroup::volume, EdgeGroup::surface, EdgeGroup::all}) {
        auto done = in_rounds(group, Steps::to_target);
        if (done) done = with_neighbours(group, target);
        if (done) done = in_rounds(group, group == EdgeGroup::surface ? Steps::to_bound : Steps::helping);
        if (done) done = with_neighbours(group, bound);
        if (!done) return fail(done.error());
    }
    if (auto done = relax_plainly(repair, queue, execution); !done) return fail(done.error());
    return put_all_back(repair, execution);
}

/// The repaired nodes as a proposal, with the counts.
template <int D>
Outcome<Relaxation<D>> summed_up(Repair<D> repair, const JudgedProposal<D>& wanted, const Execution& execution) {
    std::size_t volume = 0, surface = 0, corrected = 0;
    std::vector<ElementId> touched;
    Proposal<D> proposal = wanted.proposal();
    Buffer<EdgeChange> changes = take(std::move(proposal.changes));
    for (const auto& [edge, original] : repair.originals) {
        if (repair.nodes[edge.index()] == original) continue;
        ++(repair.kinds[edge] == EdgeKind::volume ? volume : surface);
        changes[edge.index()] = repair.straight(edge) ? EdgeChange::straightened : EdgeChange::relaxed;
        touched.insert(touched.end(), repair.shells[edge].begin(), repair.shells[edge].end());
    }
    touched |= ranges::actions::sort | ranges::actions::unique;
    proposal.mid_nodes = std::move(repair.nodes);
    proposal.changes = std::move(changes);
    auto judged = wanted.rejudged(std::move(proposal), touched, execution);
    if (!judged) return fail(judged.error());
    const auto& before = wanted.validation().verdicts;
    const auto& after = judged->validation().verdicts;
    for (std::size_t e = 0; e < before.size(); ++e)
        corrected += before[e] != Verdict::valid && after[e] == Verdict::valid;
    return Relaxation<D>{std::move(*judged), corrected, volume, surface};
}

}  // namespace

template <int D>
Outcome<Relaxation<D>> relax(const JudgedProposal<D>& wanted, RelaxOptions options, const Execution& execution) {
    const Proposal<D>& proposal = wanted.proposal();
    if (auto checked = sound(wanted.mesh(), proposal, options); !checked) return fail(checked.error());
    if (wanted.validation().bound != options.min_scaled_jacobian) {
        const auto again = validate(wanted.mesh(), proposal, options.min_scaled_jacobian, execution);
        if (!again) return fail(again.error());
        return relax(*again, options, execution);
    }
    if (wanted.validation().all_valid()) return Relaxation<D>{wanted};
    return guarded([&]() -> Outcome<Relaxation<D>> {
        const QuadraticMesh<D> mesh = proposed(wanted.mesh(), proposal);
        const auto around = shells(mesh.edges, execution);
        if (!around) return fail(around.error());
        Repair<D> repair{
            mesh, *around, proposal.kinds, options, take(proposal.mid_nodes), take(wanted.validation().verdicts), {}};
        auto done = options.strategy == RelaxStrategy::paper
                        ? relax_plainly(repair, elements_not_valid(repair), execution)
                        : relax_by_shells(repair, execution);
        if (!done) return fail(done.error());
        return summed_up(std::move(repair), wanted, execution);
    });
}

template Outcome<Relaxation<2>> relax<2>(const JudgedProposal<2>&, RelaxOptions, const Execution&);
template Outcome<Relaxation<3>> relax<3>(const JudgedProposal<3>&, RelaxOptions, const Execution&);

}  // namespace camber
