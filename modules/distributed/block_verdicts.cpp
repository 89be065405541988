module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.bezier;
import camber.curving;
import camber.metric;
import camber.recipes;
import camber.repair;
import camber.surface;
import camber.validity;
import :block_run;
import :part_state;
import :ringed_parts;
import :curve_blocks;
import :halo;
import :ranks;
import :repair_blocks;
import :rows;
import :whole_surface;

namespace camber {

namespace {

template <int D>
Outcome<Done> judge_part(BlockRun<D>& run, PartState<D>& state, const RingedPart<D>& part, BlocksValidation& own,
                         const Execution& execution) {
    QuadraticMesh<D> mesh = state.mesh;
    mesh.mid_nodes = std::move(state.nodes);
    const auto validation = validate(mesh, run.options.curving.repair.min_scaled_jacobian, execution);
    state.nodes = take(std::move(mesh.mid_nodes));
    if (!validation) return fail(validation.error());
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e) {
        if (!part.owns(mesh.linear.elements.vertices[e])) continue;
        const Verdict verdict = validation->verdicts[e];
        own.invalid += verdict == Verdict::invalid ? 1 : 0;
        own.undecided += verdict == Verdict::undecided ? 1 : 0;
        if (verdict != Verdict::valid) run.not_valid.push_back(part.elements[e]);
        const auto smallest = static_cast<double>(validation->min_scaled_jacobian[e]);
        if (smallest < own.smallest) own.smallest = smallest, own.worst = part.elements[e];
    }
    for (const auto& [e, verdict] : validation->not_positive)
        own.not_positive += part.owns(mesh.linear.elements.vertices[e]) ? 1 : 0;
    return Done{};
}

/// Verdicts of all elements, of all ranks; those that are not valid are kept.
template <int D>
Outcome<BlocksValidation> judged_blocks(BlockRun<D>& run, const Execution& execution) {
    BlocksValidation own;
    run.not_valid.clear();
    auto done = run.each_part(execution, [&](PartState<D>& state, RingedPart<D>& part) -> Outcome<Done> {
        return judge_part(run, state, part, own, without_progress(execution));
    });
    if (!done) return fail(done.error());
    std::ranges::sort(run.not_valid);
    const auto all = gather_all(run.ranks, Outcome<std::vector<BlocksValidation>>({own}));
    if (!all) return fail(all.error());
    BlocksValidation sum;
    for (const BlocksValidation& v : *all) {
        sum.invalid += v.invalid;
        sum.undecided += v.undecided;
        sum.not_positive += v.not_positive;
        if (v.smallest < sum.smallest) sum.smallest = v.smallest, sum.worst = v.worst;
    }
    return sum;
}

}  // namespace

template <int D>
Outcome<Done> judge_blocks(BlockRun<D>& run, const Execution& execution) {
    auto validation = judged_blocks(run, execution);
    if (!validation) return fail(validation.error());
    run.out.before = run.out.after = std::move(*validation);
    return Done{};
}

template <int D>
Outcome<Done> relax_blocks(BlockRun<D>& run, const Execution& execution) {
    if (run.out.before.all_valid()) return Done{};
    const RepairedBlocks<D> of{run.out.parts, run.states, run.by->surface, run.by->edges.aim};
    const auto repaired =
        repair_blocks(of, run.not_valid, run.options.curving.repair, run.ranks, part_of(execution, 0, 0.9));
    if (!repaired) return fail(repaired.error());
    const auto all = gather_all(run.ranks, Outcome<std::vector<RepairStatistics>>({*repaired}));
    if (!all) return fail(all.error());
    for (const RepairStatistics& s : *all) add_up(run.out.repair, s);
    auto validation = judged_blocks(run, part_of(execution, 0.9, 1));
    if (!validation) return fail(validation.error());
    run.out.after = std::move(*validation);
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                               \
    template Outcome<Done> judge_blocks<D>(BlockRun<D>&, const Execution&); \
    template Outcome<Done> relax_blocks<D>(BlockRun<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
