module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>
module camber.cavity;
import :attempt;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.curving;
import camber.repair;

namespace camber {

namespace {

template <int D>
Verdict verdict_of(const Operation<D>& op, std::span<const LagrangeNode<D>> nodes, std::size_t e, double bound) {
    return decide(nodal_element<D>(op.small, nodes, ElementId(e)), bound);
}

/// Of the star's elements with these nodes.
template <int D>
std::vector<Verdict> verdicts(const Operation<D>& op, const Proposal<D>& proposal, double bound) {
    std::vector<Verdict> all(op.small.linear.elements.size());
    for (std::size_t e = 0; e < all.size(); ++e) all[e] = verdict_of<D>(op, proposal.mid_nodes.view(), e, bound);
    return all;
}

std::size_t count_not_valid(const std::vector<Verdict>& verdicts) {
    return static_cast<std::size_t>(std::ranges::count_if(verdicts, [](Verdict v) { return v != Verdict::valid; }));
}

/// The first element that holds the bound with the nodes `present` and does not with those `planned`; invalid when
/// there is none.
template <int D>
ElementId first_broken(const Operation<D>& op, const Proposal<D>& present, const Proposal<D>& planned, double bound) {
    const auto now = verdicts(op, present, bound);
    const auto then = verdicts(op, planned, bound);
    for (std::size_t e = 0; e < now.size(); ++e)
        if (then[e] != Verdict::valid && now[e] == Verdict::valid) return op.star.replaces[e];
    return {};
}

/// Puts the edge's node there unless that breaks an element around it; brings `verdicts` up to date. True if it moved.
template <int D>
bool try_node(const Operation<D>& op, EdgeId edge, const LagrangeNode<D>& node, double bound,
              Buffer<LagrangeNode<D>>& nodes, std::vector<Verdict>& verdicts) {
    const LagrangeNode<D> before = std::exchange(nodes[edge.index()], node);
    std::vector<std::pair<std::size_t, Verdict>> changed;
    for (std::size_t e = 0; e < verdicts.size(); ++e) {
        const auto& of = op.small.edges.of_elements[e];
        if (std::ranges::find(of, edge) == of.end()) continue;
        const Verdict now = verdict_of<D>(op, nodes, e, bound);
        if (verdicts[e] == Verdict::valid && now != Verdict::valid) {
            nodes[edge.index()] = before;
            return false;
        }
        changed.emplace_back(e, now);
    }
    for (const auto& [e, now] : changed) verdicts[e] = now;
    return true;
}

}  // namespace

template <int D>
Outcome<Attempt<D>> repaired_from_targets(const Operation<D>& op, const Proposal<D>& wanted, const Proposal<D>& present,
                                          const EdgeModels<D>& models, double asked, RepairOptions options) {
    const Execution alone{.threads = 1};
    const double bound = std::exchange(options.min_scaled_jacobian, asked);
    const auto judged = validate(op.small, wanted, asked, alone);
    if (!judged) return fail(judged.error());
    if (judged->validation().all_valid())
        return Attempt<D>{judged->proposal(), {}, op.misfits(judged->proposal(), wanted)};
    options.vertices = VertexMoves::never;  // a patch has no place for them
    auto around = shells(op.small.edges, alone);
    if (!around) return fail(around.error());
    const auto repaired = repair_or_straighten(
        *judged, RepairGuide<D>{std::move(*around), [&](EdgeId e) { return wanted.mid_nodes[e]; }, models}, options,
        alone);
    if (!repaired) return fail(repaired.error());
    const JudgedProposal<D>& after = repaired->judged;
    Attempt<D> attempt{{}, {}, op.misfits(after.proposal(), wanted)};
    if (!after.validation().all_valid())
        for (const double limit : {asked, bound}) {
            attempt.broken = first_broken(op, present, after.proposal(), limit);
            if (attempt.broken.valid()) return attempt;
        }
    attempt.planned = after.proposal();
    return attempt;
}

template <int D>
Attempt<D> stepped_from_present(const Operation<D>& op, const Proposal<D>& wanted, const Proposal<D>& present,
                                double bound) {
    std::vector<EdgeId> order = op.edges.inner;
    std::ranges::sort(order, {}, [&](EdgeId e) { return std::pair(present.kinds[e] != EdgeKind::volume, e); });
    Buffer<LagrangeNode<D>> nodes(present.mid_nodes.begin(), present.mid_nodes.end());
    Buffer<EdgeChange> changes(present.changes.begin(), present.changes.end());
    std::vector<Verdict> now = verdicts(op, present, bound);
    for (const EdgeId e : order) {
        const Vec<D> from = nodes[e.index()].point;
        const LagrangeNode<D> goal = wanted.mid_nodes[e];
        if (goal.point == from) continue;
        if (try_node(op, e, goal, bound, nodes, now)) {
            changes[e.index()] = wanted.changes[e];
            continue;
        }
        for (const double share : {0.5, 0.25})
            if (try_node(op, e, LagrangeNode<D>{from + share * (goal.point - from)}, bound, nodes, now)) {
                changes[e.index()] = EdgeChange::relaxed;
                break;
            }
    }
    Proposal<D> planned{present.points, std::move(nodes), present.kinds, std::move(changes)};
    const Misfits misfits = op.misfits(planned, wanted);
    return {std::move(planned), {}, misfits};
}

template <int D>
bool is_worth_a_commit(const Operation<D>& op, const Attempt<D>& attempt, const Proposal<D>& wanted,
                       const Proposal<D>& present, double bound) {
    if (attempt.misfits.better_than(op.misfits(present, wanted))) return true;
    const std::size_t now = count_not_valid(verdicts(op, present, bound));
    return now > 0 && count_not_valid(verdicts(op, *attempt.planned, bound)) < now;
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<Attempt<D>> repaired_from_targets<D>(const Operation<D>&, const Proposal<D>&, const Proposal<D>&, \
                                                          const EdgeModels<D>&, double, RepairOptions);                \
    template Attempt<D> stepped_from_present<D>(const Operation<D>&, const Proposal<D>&, const Proposal<D>&, double);  \
    template bool is_worth_a_commit<D>(const Operation<D>&, const Attempt<D>&, const Proposal<D>&, const Proposal<D>&, \
                                       double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
