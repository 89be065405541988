module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>
module camber.repair;
import :guide;
import :min_invalid;
import :slides;
import :surface_alone;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;

namespace camber {

namespace {

/// Rounds in which nodes that went beyond the tolerance are held.
constexpr int max_rounds = 12;

/// The kinds with the boundary edges that are marked not to be moved.
Column<EdgeKind> with_held(const Column<EdgeKind>& kinds, const std::vector<std::uint8_t>& held) {
    Buffer<EdgeKind> all(kinds.begin(), kinds.end());
    for (std::size_t e = 0; e < all.size(); ++e)
        if (all[e] != EdgeKind::volume && held[e] != 0) all[e] = EdgeKind::fixed;
    return all;
}

/// Marks the boundary nodes that are further than the tolerance from where they were; false when there are none.
template <int D>
bool hold_beyond(const Proposal<D>& before, const Proposal<D>& after, double tolerance,
                 std::vector<std::uint8_t>& held) {
    bool any = false;
    for (std::size_t e = 0; e < held.size(); ++e) {
        if (before.kinds[e] == EdgeKind::volume) continue;
        if (!(norm(after.mid_nodes[e].point - before.mid_nodes[e].point) > tolerance)) continue;
        held[e] = 1;
        any = true;
    }
    return any;
}

/// Repair with the boundary given, over several tries that share the work.
template <int D>
struct Within {
    const JudgedProposal<D>& wanted;
    const RepairGuide<D>& guide;
    RepairOptions options;
    double work_left = 0;
    const Execution& execution;

    /// From `start`, with the boundary edges held that are marked.
    Outcome<Repaired<D>> tried(const JudgedProposal<D>& start, const std::vector<std::uint8_t>& held,
                               SurfaceMoves surface = SurfaceMoves::off_geometry) {
        options.max_work = work_left;
        RepairGuide<D> by = guide;
        by.surface = surface;
        auto repaired = repair(start.with_kinds(with_held(wanted.proposal().kinds, held)), by, options, execution);
        if (repaired) work_left -= repaired->statistics.work;
        return repaired;
    }
};

/// What repair gives from nodes that slid in planes, or `kept` if that is no better.
Outcome<Repaired<3>> repair_after_slide(Within<3>& within, Repaired<3> kept, const std::vector<std::uint8_t>& held,
                                        double tolerance, SurfaceMoves surface) {
    // The kinds of the boundary, not those that hold it.
    auto slid = slid_in_planes(kept.judged.with_kinds(within.wanted.proposal().kinds), tolerance, within.execution);
    if (!slid) return fail(slid.error());
    const auto start = validate(kept.judged.mesh(), std::move(*slid), kept.judged.validation().bound, within.execution);
    if (!start) return fail(start.error());
    auto repaired = within.tried(*start, held, surface);
    if (!repaired || repaired->judged.validation().not_valid() < kept.judged.validation().not_valid()) return repaired;
    return kept;
}

/// The boundary slides on the geometry: first in its planes, where that alone may do, else from where it is.
template <int D>
Outcome<Repaired<D>> repair_on_geometry(Within<D>& within, Repaired<D> kept) {
    const std::vector<std::uint8_t> none(within.wanted.proposal().kinds.size(), 0);
    if constexpr (D == 3) {
        constexpr double anywhere = std::numeric_limits<double>::infinity();
        auto slid = repair_after_slide(within, kept, none, anywhere, SurfaceMoves::on_geometry);
        if (!slid || slid->judged.validation().all_valid()) return slid;
        auto direct = within.tried(kept.judged, none, SurfaceMoves::on_geometry);
        if (!direct || direct->judged.validation().not_valid() <= slid->judged.validation().not_valid()) return direct;
        return slid;
    } else {
        return within.tried(kept.judged, none, SurfaceMoves::on_geometry);
    }
}

template <int D>
Outcome<Repaired<D>> repair_to_bound(Within<D>& within) {
    const Proposal<D>& proposal = within.wanted.proposal();
    const double tolerance = within.options.boundary_tolerance;
    std::vector<std::uint8_t> held(proposal.kinds.size(), 1);
    auto kept = within.tried(within.wanted, held);
    if (!kept) return kept;
    const auto done = [&] { return kept->judged.validation().all_valid() || tolerance == 0; };
    if (within.guide.onto && !kept->judged.validation().all_valid()) {
        kept = repair_on_geometry(within, std::move(*kept));
        if (!kept) return kept;
    }
    if (done()) return with_all_changes(within.wanted, std::move(*kept));
    if constexpr (D == 3) {
        auto better = repair_after_slide(within, std::move(*kept), held, tolerance, SurfaceMoves::off_geometry);
        if (!better) return better;
        kept = std::move(better);
        if (done()) return with_all_changes(within.wanted, std::move(*kept));
    }
    std::ranges::fill(held, std::uint8_t{0});
    for (int round = 0; round < max_rounds; ++round) {
        auto freed = within.tried(kept->judged, held);
        if (!freed) return freed;
        if (!hold_beyond(proposal, freed->judged.proposal(), tolerance, held))
            return with_all_changes(within.wanted, std::move(*freed));
    }
    return with_all_changes(within.wanted, std::move(*kept));
}

}  // namespace

template <int D>
Outcome<Repaired<D>> repair_within(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide,
                                   const RepairOptions& options, const Execution& execution) {
    if constexpr (D == 3)
        if (is_surface_alone(wanted.mesh().linear)) {
            const double most = options.boundary_tolerance;
            if (guide.onto || most > 0) return repair_surface(wanted, guide, options, {most > 0, most}, execution);
            return Repaired<D>{wanted};
        }
    const auto to = [&](const JudgedProposal<D>& judged, const RepairOptions& by) -> Outcome<Repaired<D>> {
        const auto start = validate(judged.mesh(), judged.proposal(), by.min_scaled_jacobian, execution);
        if (!start) return fail(start.error());
        Within<D> within{*start, guide, by, allowed_work(start->validation().not_valid(), by.effort), execution};
        return repair_to_bound(within);
    };
    auto kept = min_invalid(wanted, to(wanted, options), options, execution, to);
    if (!kept) return kept;
    RepairOptions demanded = options;
    // Boundary nodes slide on the geometry for no higher bound.
    if (guide.onto && options.min_scaled_jacobian > min_bound) demanded.min_scaled_jacobian = min_bound;
    return restore_input(wanted, std::move(*kept), demanded, without_progress(execution));
}

#define CAMBER_INSTANTIATE(D)                                                                       \
    template Outcome<Repaired<D>> repair_within<D>(const JudgedProposal<D>&, const RepairGuide<D>&, \
                                                   const RepairOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
