module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.config;
import camber.validity;
import camber.programmes;
import camber.soundness;
import camber.repair;
import :mend;
import :report;

namespace camber::run {

namespace {

/// Rounds in which nodes that went beyond the tolerance are held.
constexpr int most_rounds = 12;

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

/// A later state of the same mesh, with the kinds of `before` and all that changed since counted.
template <int D>
Mended<D> counted(const JudgedProposal<D>& before, const Mended<D>& mended) {
    const JudgedProposal<D>& after = mended.judged;
    Mended<D> sum{.judged = after.with_kinds(before.proposal().kinds), .given_up = {}};
    sum.work = mended.work;
    sum.given_up = mended.given_up;
    const Proposal<D>& was = before.proposal();
    const Proposal<D>& is = after.proposal();
    const auto valid = [](const JudgedProposal<D>& judged, std::size_t e) {
        return judged.validation().verdicts[e] == Verdict::valid;
    };
    for (std::size_t e = 0; e < before.validation().verdicts.size(); ++e)
        sum.corrected_elements += !valid(before, e) && valid(after, e);
    for (std::size_t e = 0; e < was.mid_nodes.size(); ++e)
        if (is.mid_nodes[e] != was.mid_nodes[e])
            ++(was.kinds[e] == EdgeKind::volume ? sum.moved_volume_nodes : sum.moved_surface_nodes);
    for (std::size_t v = 0; v < was.points.size(); ++v) sum.moved_vertices += is.points[v] != was.points[v];
    return sum;
}

}  // namespace

RelaxOptions relax_options(const config::Relax& options) {
    RelaxOptions relax = options;
    relax.strategy = options.repair == config::Repair::relax ? RelaxStrategy::paper : RelaxStrategy::shell;
    return relax;
}

template <int D>
Outcome<Mended<D>> mend(const JudgedProposal<D>& wanted, const Column<QuadraticModel<D>>& models,
                        const config::Relax& options, double most_work, const Execution& execution) {
    if (!needs_models(options.repair)) {
        auto done = relax(wanted, relax_options(options), execution);
        if (!done) return fail(done.error());
        return Mended<D>{.judged = std::move(done->judged),
                         .corrected_elements = done->corrected_elements,
                         .moved_volume_nodes = done->relaxed_volume_edges,
                         .moved_surface_nodes = done->relaxed_surface_edges,
                         .given_up = {}};
    }
    const RepairOptions repair_options{
        .min_scaled_jacobian = options.min_scaled_jacobian,
        .target = options.target,
        .scope = options.repair == config::Repair::edge ? RepairScope::edges : RepairScope::cavities,
        .surface_tolerance = options.boundary_tolerance,
        .vertices = options.vertices,
        .effort = options.effort,
        .most_work = most_work};
    auto done = repair(wanted, models, repair_options, execution);
    if (!done) return fail(done.error());
    const RepairStatistics& s = done->statistics;
    return Mended<D>{std::move(done->judged),  s.corrected_elements, s.moved_volume_nodes,
                     s.relaxed_surface_nodes,  s.moved_vertices,     s.work,
                     std::move(done->given_up)};
}

template <int D>
Outcome<Mended<D>> mend_or_straighten(const JudgedProposal<D>& wanted, const Column<QuadraticModel<D>>& models,
                                      const config::Relax& options, const Execution& execution) {
    auto kept = mend(wanted, models, options, allowed_work(wanted.validation().not_valid(), options.effort), execution);
    if (!kept || kept->judged.validation().all_valid() || options.repair != config::Repair::cavity) return kept;
    auto done = relax(kept->judged, relax_options(options), execution);
    if (!done) return fail(done.error());
    if (done->judged.validation().not_valid() >= kept->judged.validation().not_valid()) return kept;
    kept->judged = std::move(done->judged);
    std::erase_if(kept->given_up, [&](ElementId e) { return kept->judged.validation().verdicts[e] == Verdict::valid; });
    return counted(wanted, *kept);
}

namespace {

/// Mending with the boundary given, over several tries that share the work.
template <int D>
struct Within {
    const JudgedProposal<D>& wanted;
    const Column<QuadraticModel<D>>& models;
    config::Relax options;
    double work_left = 0;
    const Execution& execution;

    /// From `start`, with the boundary edges held that are marked.
    Outcome<Mended<D>> tried(const JudgedProposal<D>& start, const std::vector<std::uint8_t>& held) {
        auto mended =
            mend(start.with_kinds(with_held(wanted.proposal().kinds, held)), models, options, work_left, execution);
        if (mended) work_left -= mended->work;
        return mended;
    }
};

/// What mending gives from nodes that slid in planes, or `kept` if that is no better.
Outcome<Mended<3>> mend_after_slide(Within<3>& within, Mended<3> kept, const std::vector<std::uint8_t>& held) {
    // The kinds of the boundary, not those that hold it.
    auto slid = slid_in_planes(kept.judged.with_kinds(within.wanted.proposal().kinds),
                               within.options.boundary_tolerance, within.execution);
    if (!slid) return fail(slid.error());
    const auto start = validate(kept.judged.mesh(), std::move(*slid), kept.judged.validation().bound, within.execution);
    if (!start) return fail(start.error());
    auto mended = within.tried(*start, held);
    if (!mended || mended->judged.validation().not_valid() < kept.judged.validation().not_valid()) return mended;
    return kept;
}

template <int D>
Outcome<Mended<D>> mend_to_bound(Within<D>& within) {
    const Proposal<D>& proposal = within.wanted.proposal();
    const double tolerance = within.options.boundary_tolerance;
    std::vector<std::uint8_t> held(proposal.kinds.size(), 1);
    auto kept = within.tried(within.wanted, held);
    if (!kept) return kept;
    const auto done = [&] { return kept->judged.validation().all_valid() || tolerance == 0; };
    if (done()) return counted(within.wanted, *kept);
    if constexpr (D == 3) {
        auto better = mend_after_slide(within, std::move(*kept), held);
        if (!better) return better;
        kept = std::move(better);
        if (done()) return counted(within.wanted, *kept);
    }
    std::ranges::fill(held, std::uint8_t{0});
    for (int round = 0; round < most_rounds; ++round) {
        auto freed = within.tried(kept->judged, held);
        if (!freed) return freed;
        if (!hold_beyond(proposal, freed->judged.proposal(), tolerance, held)) return counted(within.wanted, *freed);
    }
    return counted(within.wanted, *kept);
}

}  // namespace

template <int D>
Outcome<Mended<D>> mend_within(const JudgedProposal<D>& wanted, const Column<QuadraticModel<D>>& models,
                               const config::Relax& options, const Execution& execution) {
    config::Relax lower = options;
    lower.min_scaled_jacobian = default_bound;
    const auto to = [&](const JudgedProposal<D>& judged, const config::Relax& relax) {
        Within<D> within{judged, models, relax, allowed_work(judged.validation().not_valid(), relax.effort), execution};
        return mend_to_bound(within);
    };
    auto asked = to(wanted, options);
    if (!asked || asked->judged.validation().all_valid() || options.min_scaled_jacobian <= lower.min_scaled_jacobian)
        return asked;
    // To the passes elements below the bound are alike: what cannot reach it may have become invalid.
    const auto judged_for = [&](const JudgedProposal<D>& judged, double bound) {
        return validate(judged.mesh(), judged.proposal(), bound, execution);
    };
    const auto now = judged_for(asked->judged, lower.min_scaled_jacobian);
    if (!now) return fail(now.error());
    if (now->validation().all_valid()) return asked;
    const auto before = judged_for(wanted, lower.min_scaled_jacobian);
    if (!before) return fail(before.error());
    auto plain = to(*before, lower);
    if (!plain) return plain;
    if (now->validation().not_valid() <= plain->judged.validation().not_valid()) return asked;
    auto judged = judged_for(plain->judged, options.min_scaled_jacobian);
    if (!judged) return fail(judged.error());
    plain->judged = std::move(*judged);
    return counted(wanted, *plain);
}

template <int D>
KeptBoundaryReport kept_boundary(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, double tolerance) {
    KeptBoundaryReport report{.tolerance = tolerance};
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        if (proposal.kinds[e] == EdgeKind::volume || proposal.mid_nodes[e] == mesh.mid_nodes[e]) continue;
        const auto& [a, b] = mesh.edges.vertices[e];
        const double shift = norm(proposal.mid_nodes[e].point - mesh.mid_nodes[e].point);
        const double chord = norm(mesh.linear.points[b] - mesh.linear.points[a]);
        ++report.moved_nodes;
        report.largest_shift = std::max(report.largest_shift, shift);
        if (chord > 0) report.largest_relative_shift = std::max(report.largest_relative_shift, shift / chord);
    }
    return report;
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template Outcome<Mended<D>> mend<D>(const JudgedProposal<D>&, const Column<QuadraticModel<D>>&,               \
                                        const config::Relax&, double, const Execution&);                          \
    template Outcome<Mended<D>> mend_or_straighten<D>(const JudgedProposal<D>&, const Column<QuadraticModel<D>>&, \
                                                      const config::Relax&, const Execution&);                    \
    template Outcome<Mended<D>> mend_within<D>(const JudgedProposal<D>&, const Column<QuadraticModel<D>>&,        \
                                               const config::Relax&, const Execution&);                           \
    template KeptBoundaryReport kept_boundary<D>(const QuadraticMesh<D>&, const Proposal<D>&, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
