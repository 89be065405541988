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
Mended<D> counted(const JudgedProposal<D>& before, const JudgedProposal<D>& after) {
    Mended<D> sum{after.with_kinds(before.proposal().kinds)};
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
    RelaxOptions relax;
    relax.strategy = options.repair == config::Repair::relax ? RelaxStrategy::paper : RelaxStrategy::shell;
    relax.target = options.target;
    relax.theta = options.theta;
    relax.max_corrections = options.max_corrections;
    relax.min_scaled_jacobian = options.min_scaled_jacobian;
    return relax;
}

template <int D>
Outcome<Mended<D>> mend(const JudgedProposal<D>& wanted, const Column<QuadraticModel<D>>& models,
                        const config::Relax& options, const Execution& execution) {
    if (!needs_models(options.repair)) {
        auto done = relax(wanted, relax_options(options), execution);
        if (!done) return fail(done.error());
        return Mended<D>{std::move(done->judged), done->corrected_elements, done->relaxed_volume_edges,
                         done->relaxed_surface_edges, 0};
    }
    const RepairOptions repair_options{
        .min_scaled_jacobian = options.min_scaled_jacobian,
        .target = options.target,
        .scope = options.repair == config::Repair::edge ? RepairScope::edges : RepairScope::cavities,
        .surface_tolerance = options.boundary_tolerance,
        .vertices = options.vertices == config::Vertices::move ? VertexMoves::allowed : VertexMoves::never};
    auto done = repair(wanted, models, repair_options, execution);
    if (!done) return fail(done.error());
    const RepairStatistics& s = done->statistics;
    return Mended<D>{std::move(done->judged), s.corrected_elements, s.moved_volume_nodes, s.relaxed_surface_nodes,
                     s.moved_vertices};
}

namespace {

template <int D>
std::size_t left(const JudgedProposal<D>& judged) {
    return judged.validation().invalid + judged.validation().undecided;
}

}  // namespace

template <int D>
Outcome<Mended<D>> mend_or_straighten(const JudgedProposal<D>& wanted, const Column<QuadraticModel<D>>& models,
                                      const config::Relax& options, const Execution& execution) {
    auto kept = mend(wanted, models, options, execution);
    if (!kept || kept->judged.validation().all_valid() || options.repair != config::Repair::cavity) return kept;
    const auto done = relax(kept->judged, relax_options(options), execution);
    if (!done) return fail(done.error());
    if (left(done->judged) >= left(kept->judged)) return kept;
    return counted(wanted, done->judged);
}

namespace {

/// What mending gives from nodes that slid in planes, or `kept` if that is no better.
Outcome<Mended<3>> mend_after_slide(const JudgedProposal<3>& kept, const Column<QuadraticModel<3>>& models,
                                    const config::Relax& options, const Column<EdgeKind>& kinds,
                                    const std::vector<std::uint8_t>& held, const Execution& execution) {
    // The kinds of the boundary, not those that hold it.
    auto slid = slid_in_planes(kept.with_kinds(kinds), options.boundary_tolerance, execution);
    if (!slid) return fail(slid.error());
    slid->kinds = with_held(kinds, held);
    const auto start = validate(kept.mesh(), std::move(*slid), kept.validation().bound, execution);
    if (!start) return fail(start.error());
    auto mended = mend(*start, models, options, execution);
    if (!mended) return mended;
    if (left(mended->judged) < left(kept)) return mended;
    return Mended<3>{kept};
}

template <int D>
Outcome<Mended<D>> mend_to_bound(const JudgedProposal<D>& wanted, const Column<QuadraticModel<D>>& models,
                                 const config::Relax& options, const Execution& execution) {
    const Proposal<D>& proposal = wanted.proposal();
    std::vector<std::uint8_t> held(proposal.kinds.size(), 1);
    auto kept = mend(wanted.with_kinds(with_held(proposal.kinds, held)), models, options, execution);
    if (!kept) return kept;
    const auto done = [&] { return kept->judged.validation().all_valid() || options.boundary_tolerance == 0; };
    if (done()) return counted(wanted, kept->judged);
    if constexpr (D == 3) {
        auto better = mend_after_slide(kept->judged, models, options, proposal.kinds, held, execution);
        if (!better) return better;
        kept = std::move(better);
        if (done()) return counted(wanted, kept->judged);
    }
    std::ranges::fill(held, std::uint8_t{0});
    for (int round = 0; round < most_rounds; ++round) {
        auto freed = mend(kept->judged.with_kinds(with_held(proposal.kinds, held)), models, options, execution);
        if (!freed) return freed;
        if (!hold_beyond(proposal, freed->judged.proposal(), options.boundary_tolerance, held))
            return counted(wanted, freed->judged);
    }
    return counted(wanted, kept->judged);
}

}  // namespace

template <int D>
Outcome<Mended<D>> mend_within(const JudgedProposal<D>& wanted, const Column<QuadraticModel<D>>& models,
                               const config::Relax& options, const Execution& execution) {
    config::Relax lower = options;
    lower.min_scaled_jacobian = config::Relax{}.min_scaled_jacobian;
    auto asked = mend_to_bound(wanted, models, options, execution);
    if (!asked || asked->judged.validation().all_valid() || options.min_scaled_jacobian <= lower.min_scaled_jacobian)
        return asked;
    // To the passes elements below the bound are alike: what cannot reach it may have become invalid.
    const auto to = [&](const JudgedProposal<D>& judged, double bound) {
        return validate(judged.mesh(), judged.proposal(), bound, execution);
    };
    const auto now = to(asked->judged, lower.min_scaled_jacobian);
    if (!now) return fail(now.error());
    if (now->validation().all_valid()) return asked;
    const auto before = to(wanted, lower.min_scaled_jacobian);
    if (!before) return fail(before.error());
    const auto plain = mend_to_bound(*before, models, lower, execution);
    if (!plain) return plain;
    if (left(*now) <= left(plain->judged)) return asked;
    const auto judged = to(plain->judged, options.min_scaled_jacobian);
    if (!judged) return fail(judged.error());
    return counted(wanted, *judged);
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
                                        const config::Relax&, const Execution&);                                  \
    template Outcome<Mended<D>> mend_or_straighten<D>(const JudgedProposal<D>&, const Column<QuadraticModel<D>>&, \
                                                      const config::Relax&, const Execution&);                    \
    template Outcome<Mended<D>> mend_within<D>(const JudgedProposal<D>&, const Column<QuadraticModel<D>>&,        \
                                               const config::Relax&, const Execution&);                           \
    template KeptBoundaryReport kept_boundary<D>(const QuadraticMesh<D>&, const Proposal<D>&, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
