module;
#include <cstddef>
#include <utility>
module camber.repair:min_invalid;
import camber.core;
import camber.validity;
import :options;
import :repaired;

namespace camber {

/// A repair judged for the least bound and for the one that is asked for.
template <int D>
struct TwiceJudged {
    Repaired<D> repaired;  ///< judged for the latter
    std::size_t invalid = 0;

    /// Fewer invalid ones first, then fewer below the bound.
    [[nodiscard]] std::pair<std::size_t, std::size_t> left() const {
        return {invalid, repaired.judged.validation().not_valid()};
    }
};

template <int D>
[[nodiscard]] Outcome<TwiceJudged<D>> judge_twice(Repaired<D> repaired, double bound, const Execution& execution) {
    const QuadraticMesh<D> mesh = repaired.judged.mesh();
    const Proposal<D> proposal = repaired.judged.proposal();
    const auto least = validate(mesh, proposal, min_bound, execution);
    if (!least) return fail(least.error());
    auto asked = validate(mesh, proposal, bound, execution);
    if (!asked) return fail(asked.error());
    repaired.judged = std::move(*asked);
    return TwiceJudged<D>{std::move(repaired), least->validation().not_valid()};
}

/// To the passes elements below a bound are alike: where it cannot be had, some may have been left invalid that need
/// not be. `asked`: what came of the bound of the options. If that has invalid elements, `repair(start, options)` is
/// asked for the least bound, from there and from what was `wanted`; what leaves fewest invalid is taken; if that is
/// none, the bound is tried once more from there. Errors: those of `repair`, stopped.
template <int D, class Repair>
[[nodiscard]] Outcome<Repaired<D>> min_invalid(const JudgedProposal<D>& wanted, Outcome<Repaired<D>> asked,
                                               const RepairOptions& options, const Execution& execution,
                                               Repair&& repair) {
    const double bound = options.min_scaled_jacobian;
    if (!asked || asked->judged.validation().all_valid() || bound <= min_bound) return asked;
    auto best = judge_twice(std::move(*asked), bound, execution);
    if (!best) return fail(best.error());
    RepairOptions from_wanted = options;
    from_wanted.min_scaled_jacobian = min_bound;
    RepairOptions from_there = from_wanted;
    from_there.boundary_tolerance = 0;  // what it allows was taken
    const JudgedProposal<D> there = best->repaired.judged;
    for (const auto& [start, by] : {std::pair(&there, &from_there), std::pair(&wanted, &from_wanted)}) {
        if (best->invalid == 0) break;
        auto lower = repair(*start, *by);
        if (!lower) return lower;
        auto tried = judge_twice(std::move(*lower), bound, execution);
        if (!tried) return fail(tried.error());
        if (tried->left() < best->left()) best = std::move(tried);
    }
    if (best->invalid == 0 && !best->repaired.judged.validation().all_valid()) {
        RepairOptions onwards = options;
        onwards.boundary_tolerance = 0;
        auto higher = repair(best->repaired.judged, onwards);
        if (!higher) return higher;
        auto tried = judge_twice(std::move(*higher), bound, execution);
        if (!tried) return fail(tried.error());
        if (tried->left() < best->left()) best = std::move(tried);
    }
    return with_all_changes(wanted, std::move(best->repaired));
}

}  // namespace camber
