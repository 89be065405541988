// Improves elements above the bound to the target of the repair.
module;
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import camber.core;
import camber.bezier;
import camber.validity;
import :options;
import :method;
import :moved_mesh;

namespace camber {

namespace {

/// Tolerated relative loss of the scaled Jacobian, since certified values are only this accurate.
constexpr double tolerated_loss = 1e-3;

constexpr double share_of_effort = 0.25;

template <int D>
Outcome<Done> put_back_losses(MovedMesh<D>& raised, const JudgedProposal<D>& before, const Validation<D>& at_bound,
                              const Incidence<ElementId>& shells, const Execution& execution) {
    const auto& nodes = before.proposal().mid_nodes;
    const Validation<D>& was = before.validation();
    const auto has_lost = [&](ElementId e) {
        double lowest = std::min(was.bound, (1 - tolerated_loss) * static_cast<double>(was.min_scaled_jacobian[e]));
        if (at_bound.verdicts[e] == Verdict::valid) lowest = std::max(lowest, at_bound.bound);
        return lowest > min_bound && decide(raised.element(e), lowest) != Verdict::valid;
    };
    std::vector<EdgeId> moved = raised.nodes.set_rows();
    while (!moved.empty()) {
        std::vector<ElementId> touched;
        for (const EdgeId edge : moved) touched.insert(touched.end(), shells[edge].begin(), shells[edge].end());
        touched |= ranges::actions::sort | ranges::actions::unique;
        const auto lost =
            map_each(execution, touched.size(), [&](std::size_t i) -> char { return has_lost(touched[i]) ? 1 : 0; });
        if (!lost) return fail(lost.error());
        moved.clear();
        for (std::size_t i = 0; i < touched.size(); ++i) {
            if ((*lost)[i] == 0) continue;
            for (const EdgeId edge : before.mesh().edges.of_elements[touched[i]]) {
                if (raised.nodes[edge] == nodes[edge]) continue;
                raised.nodes.set(edge, nodes[edge]);
                moved.push_back(edge);
            }
        }
    }
    return Done{};
}

template <int D>
Outcome<std::size_t> count_raised(const MovedMesh<D>& raised, const Validation<D>& at_target,
                                  const Validation<D>& at_bound, const Execution& execution) {
    return reduce_each(
        execution, at_target.verdicts.size(), std::size_t{0},
        [&](std::size_t& count, std::size_t e) {
            if (at_target.verdicts[e] == Verdict::valid || at_bound.verdicts[e] != Verdict::valid) return;
            if (decide(raised.element(ElementId(e)), at_target.bound) == Verdict::valid) ++count;
        },
        [](std::size_t a, std::size_t b) { return a + b; });
}

}  // namespace

bool raises(const RepairOptions& options) {
    return options.method == RepairMethod::extension && options.target > default_bound &&
           options.target > options.min_scaled_jacobian;
}

template <int D>
Outcome<Repaired<D>> raise(const JudgedProposal<D>& input, Repaired<D> repaired, const RepairGuide<D>& guide,
                           const RepairOptions& options, const Execution& execution) {
    const QuadraticMesh<D>& mesh = input.mesh();
    if (is_standalone_surface(mesh.linear) || repaired.judged.validation().smallest >= options.target) return repaired;
    return guarded([&]() -> Outcome<Repaired<D>> {
        const Execution quiet = without_progress(execution);
        const auto before = validate(mesh, repaired.judged.proposal(), options.target, quiet);
        if (!before) return fail(before.error());
        if (before->validation().all_valid()) return repaired;
        RepairOptions to_target = options;
        to_target.min_scaled_jacobian = JacobianBound::recommended(options.target);
        to_target.effort *= share_of_effort;
        to_target.max_work -= repaired.statistics.work;
        const auto higher = repair(*before, guide, to_target, execution);
        if (!higher) return higher;
        MovedMesh<D> raised(*before);
        const auto& nodes = higher->judged.proposal().mid_nodes;
        for (std::size_t e = 0; e < nodes.size(); ++e)
            if (nodes[e] != before->proposal().mid_nodes[e]) raised.nodes.set(EdgeId(e), nodes[e]);
        if (auto done = put_back_losses(raised, *before, repaired.judged.validation(), guide.shells, quiet); !done)
            return fail(done.error());
        const auto count = count_raised(raised, before->validation(), repaired.judged.validation(), quiet);
        if (!count) return fail(count.error());
        auto judged = validate(mesh, raised.proposal(before->proposal()), options.min_scaled_jacobian, quiet);
        if (!judged) return fail(judged.error());
        if (judged->validation().not_valid() > repaired.judged.validation().not_valid()) return repaired;
        repaired.judged = std::move(*judged);
        repaired.statistics.raised_elements = *count;
        repaired.statistics.work += higher->statistics.work;
        return with_all_changes(input, std::move(repaired));
    });
}

#define CAMBER_INSTANTIATE(D)                                                                            \
    template Outcome<Repaired<D>> raise<D>(const JudgedProposal<D>&, Repaired<D>, const RepairGuide<D>&, \
                                           const RepairOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
