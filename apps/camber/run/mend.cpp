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

/// The proposal with the boundary edges that are marked not to be moved.
template <int D>
Proposal<D> with_held(Proposal<D> proposal, const std::vector<std::uint8_t>& held) {
    Buffer<EdgeKind> kinds(proposal.kinds.begin(), proposal.kinds.end());
    for (std::size_t e = 0; e < kinds.size(); ++e)
        if (kinds[e] != EdgeKind::volume && held[e] != 0) kinds[e] = EdgeKind::fixed;
    proposal.kinds = std::move(kinds);
    return proposal;
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
Mended<D> counted(const QuadraticMesh<D>& mesh, const Proposal<D>& before, const Validation<D>& validation,
                  Mended<D> after) {
    after.proposal.kinds = before.kinds;
    after.corrected_elements = after.moved_volume_nodes = after.moved_surface_nodes = after.moved_vertices = 0;
    for (std::size_t e = 0; e < validation.verdicts.size(); ++e)
        after.corrected_elements +=
            validation.verdicts[e] != Verdict::valid && after.validation.verdicts[e] == Verdict::valid;
    for (std::size_t e = 0; e < before.mid_nodes.size(); ++e)
        if (after.proposal.mid_nodes[e] != before.mid_nodes[e])
            ++(before.kinds[e] == EdgeKind::volume ? after.moved_volume_nodes : after.moved_surface_nodes);
    for (std::size_t v = 0; v < mesh.linear.points.size(); ++v)
        after.moved_vertices += after.linear.points[v] != mesh.linear.points[v];
    return after;
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
Outcome<Mended<D>> mend(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const Validation<D>& validation,
                        const Column<QuadraticModel<D>>& models, const config::Relax& options,
                        const Execution& execution) {
    if (!needs_models(options.repair)) {
        auto done = relax(mesh, proposal, validation, relax_options(options), execution);
        if (!done) return fail(done.error());
        return Mended<D>{mesh.linear,
                         std::move(done->proposal),
                         std::move(done->validation),
                         done->corrected_elements,
                         done->relaxed_volume_edges,
                         done->relaxed_surface_edges,
                         0};
    }
    const RepairOptions repair_options{
        .min_scaled_jacobian = options.min_scaled_jacobian,
        .target = options.target,
        .scope = options.repair == config::Repair::edge ? RepairScope::edges : RepairScope::cavities,
        .surface_tolerance = options.boundary_tolerance,
        .vertices = options.vertices == config::Vertices::move ? VertexMoves::allowed : VertexMoves::never};
    auto done = repair(mesh, proposal, validation, models, repair_options, execution);
    if (!done) return fail(done.error());
    const RepairStatistics& s = done->statistics;
    return Mended<D>{std::move(done->linear), std::move(done->proposal), std::move(done->validation),
                     s.corrected_elements,    s.moved_volume_nodes,      s.relaxed_surface_nodes,
                     s.moved_vertices};
}

namespace {

/// The same mesh, with the points of a later state.
template <int D>
QuadraticMesh<D> with_points(QuadraticMesh<D> mesh, const LinearMesh<D>& linear) {
    mesh.linear = linear;
    return mesh;
}

template <int D>
std::size_t left(const Validation<D>& validation) {
    return validation.invalid + validation.undecided;
}

}  // namespace

template <int D>
Outcome<Mended<D>> mend_or_straighten(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal,
                                      const Validation<D>& validation, const Column<QuadraticModel<D>>& models,
                                      const config::Relax& options, const Execution& execution) {
    auto kept = mend(mesh, proposal, validation, models, options, execution);
    if (!kept || kept->validation.all_valid() || options.repair != config::Repair::cavity) return kept;
    auto done =
        relax(with_points(mesh, kept->linear), kept->proposal, kept->validation, relax_options(options), execution);
    if (!done) return fail(done.error());
    if (left(done->validation) >= left(kept->validation)) return kept;
    return counted(
        mesh, proposal, validation,
        Mended<D>{std::move(kept->linear), std::move(done->proposal), std::move(done->validation), 0, 0, 0, 0});
}

namespace {

/// What mending gives from nodes that slid in planes, or `kept` if that is no better.
Outcome<Mended<3>> mend_after_slide(const QuadraticMesh<3>& mesh, const Mended<3>& kept,
                                    const Column<QuadraticModel<3>>& models, const config::Relax& options,
                                    const Proposal<3>& given, const std::vector<std::uint8_t>& held,
                                    const Execution& execution) {
    // The kinds of the boundary, not those that hold it.
    Proposal<3> proposal = kept.proposal;
    proposal.kinds = given.kinds;
    auto slid = slid_in_planes(mesh, proposal, kept.validation, options.boundary_tolerance, execution);
    if (!slid) return fail(slid.error());
    const Proposal<3> start = with_held(std::move(*slid), held);
    auto validation = validate(mesh, start, kept.validation.bound, execution);
    if (!validation) return fail(validation.error());
    auto mended = mend(mesh, start, *validation, models, options, execution);
    if (!mended) return mended;
    if (left(mended->validation) < left(kept.validation)) return mended;
    return kept;
}

template <int D>
Outcome<Mended<D>> mend_to_bound(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal,
                                 const Validation<D>& validation, const Column<QuadraticModel<D>>& models,
                                 const config::Relax& options, const Execution& execution) {
    std::vector<std::uint8_t> held(mesh.edges.size(), 1);
    auto kept = mend(mesh, with_held(proposal, held), validation, models, options, execution);
    if (!kept) return kept;
    if (kept->validation.all_valid() || options.boundary_tolerance == 0)
        return counted(mesh, proposal, validation, std::move(*kept));
    QuadraticMesh<D> start = mesh;
    start.linear = kept->linear;
    if constexpr (D == 3) {
        auto better = mend_after_slide(start, *kept, models, options, proposal, held, execution);
        if (!better) return better;
        kept = std::move(better);
        if (kept->validation.all_valid()) return counted(mesh, proposal, validation, std::move(*kept));
        start.linear = kept->linear;
    }
    std::ranges::fill(held, std::uint8_t{0});
    Proposal<D> free = kept->proposal;
    free.kinds = proposal.kinds;
    for (int round = 0; round < most_rounds; ++round) {
        auto freed = mend(start, with_held(free, held), kept->validation, models, options, execution);
        if (!freed) return freed;
        if (!hold_beyond(proposal, freed->proposal, options.boundary_tolerance, held))
            return counted(mesh, proposal, validation, std::move(*freed));
    }
    return counted(mesh, proposal, validation, std::move(*kept));
}

}  // namespace

template <int D>
Outcome<Mended<D>> mend_within(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal,
                               const Validation<D>& validation, const Column<QuadraticModel<D>>& models,
                               const config::Relax& options, const Execution& execution) {
    config::Relax lower = options;
    lower.min_scaled_jacobian = config::Relax{}.min_scaled_jacobian;
    auto asked = mend_to_bound(mesh, proposal, validation, models, options, execution);
    if (!asked || asked->validation.all_valid() || options.min_scaled_jacobian <= lower.min_scaled_jacobian)
        return asked;
    // To the passes elements below the bound are alike: what cannot reach it may have become invalid.
    auto now = validate(with_points(mesh, asked->linear), asked->proposal, lower.min_scaled_jacobian, execution);
    if (!now) return fail(now.error());
    if (now->all_valid()) return asked;
    auto before = validate(mesh, proposal, lower.min_scaled_jacobian, execution);
    if (!before) return fail(before.error());
    auto plain = mend_to_bound(mesh, proposal, *before, models, lower, execution);
    if (!plain) return plain;
    if (left(*now) <= left(plain->validation)) return asked;
    auto judged = validate(with_points(mesh, plain->linear), plain->proposal, options.min_scaled_jacobian, execution);
    if (!judged) return fail(judged.error());
    plain->validation = std::move(*judged);
    return counted(mesh, proposal, validation, std::move(*plain));
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

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<Mended<D>> mend<D>(const QuadraticMesh<D>&, const Proposal<D>&, const Validation<D>&,         \
                                        const Column<QuadraticModel<D>>&, const config::Relax&, const Execution&); \
    template Outcome<Mended<D>> mend_or_straighten<D>(const QuadraticMesh<D>&, const Proposal<D>&,                 \
                                                      const Validation<D>&, const Column<QuadraticModel<D>>&,      \
                                                      const config::Relax&, const Execution&);                     \
    template Outcome<Mended<D>> mend_within<D>(const QuadraticMesh<D>&, const Proposal<D>&, const Validation<D>&,  \
                                               const Column<QuadraticModel<D>>&, const config::Relax&,             \
                                               const Execution&);                                                  \
    template KeptBoundaryReport kept_boundary<D>(const QuadraticMesh<D>&, const Proposal<D>&, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
