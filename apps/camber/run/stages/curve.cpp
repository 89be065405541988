module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
module camber.run;
import camber.core;
import camber.config;
import camber.curving;
import camber.metric;
import camber.validity;
import :measures;
import :parts;
import :report;
import :runner;
import :stages;
import :state;
import :steps;

namespace camber::run {

namespace {

/// Where nodes are wanted.
template <int D>
struct Found {
    Curved<D> curved;
    CurveReport report;
};
template <int D>
Found<D> with_report(const QuadraticMesh<D>& mesh, Curved<D> curved) {
    const CurveReport report = curve_report(mesh, curved);
    return {std::move(curved), report};
}

/// The proposal of `shape` as one of `curve`, without lengths: there is no field to measure them in.
template <int D>
Curved<D> without_lengths(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds, Proposal<D> proposal) {
    const std::size_t n = mesh.edges.size();
    Curved<D> curved{std::move(proposal), Buffer<double>(n, 0.0), Buffer<double>(n, 0.0), {}};
    for (std::size_t e = 0; e < n; ++e) {
        if (kinds[e] != EdgeKind::volume) continue;
        ++curved.statistics.volume_edges;
        curved.statistics.curved_edges += curved.proposal.mid_nodes[e] != mesh.mid_nodes[e];
    }
    return curved;
}

}  // namespace

CurveOptions edge_options(const config::Curve& options) {
    auto edge = static_cast<const CurveOptions&>(options);
    edge.aim = options.objective == config::Objective::energy   ? CurvingAim::energy
               : options.objective == config::Objective::length ? CurvingAim::length
                                                                : CurvingAim::accuracy;
    return edge;
}

template <int D>
CurveReport curve_report(const QuadraticMesh<D>& mesh, const Curved<D>& curved) {
    const CurveStatistics& s = curved.statistics;
    return {mesh.edges.size(),
            s.volume_edges,
            is_surface_alone(mesh.linear) ? bent_edges(mesh, curved.proposal) : s.curved_edges,
            s.polished,
            s.exhausted,
            s.shortened,
            s.outside,
            s.lost,
            s.drawn_back,
            edge_report(mesh, curved.proposal, curved.straight_lengths, curved.lengths),
            {},
            {},
            0};
}

template <int D>
void report_curve(Runner<D>& run, CurveReport part, double seconds) {
    part.edges_per_second = static_cast<double>(part.volume_edges) / std::max(seconds, 1e-9);
    run.report(part);
}

namespace {

/// Those of the volume by the field.
template <int D>
Outcome<Found<D>> by_field(const QuadraticMesh<D>& mesh, const CurveInput<D>& input, const BackMesh<D>& field,
                           const CurveOptions& options, const Execution& execution) {
    auto curved = curve(mesh, input.kinds, input.base, input.shells, field, options, execution);
    if (!curved) return fail(curved.error());
    return with_report(mesh, std::move(*curved));
}

/// By the boundary alone.
template <int D>
Outcome<Found<D>> by_shape(const QuadraticMesh<D>& mesh, const CurveInput<D>& input, const Execution& execution) {
    auto done = shape(mesh, input.kinds, input.base, input.shells, ShapeOptions{}, execution);
    if (!done) return fail(done.error());
    return with_report(mesh, without_lengths(mesh, input.kinds, std::move(done->proposal)));
}

/// What became of the nodes that volume edges were read with.
constexpr const char* of_file(CurvingAim aim) {
    return aim == CurvingAim::accuracy
               ? "volume edges: their nodes are found anew; those that the mesh was read with do not count"
               : "volume edges: the search begins at the node that the mesh was read with, where that is the better "
                 "start";
}

/// The stage, however it finds where nodes are wanted: `find(execution)`.
template <int D>
Outcome<Done> curve_within(Runner<D>& run, Boundary<D> boundary, CurveInput<D>& input, CurvingAim aim, const auto& find,
                           const Execution& execution) {
    run.report(input.notices);
    auto found = run.timed([&] { return find(execution); });
    if (!found.value) return fail(found.value.error());
    found.value->report.drawn_back += input.drawn_back;
    report_curve(run, std::move(found.value->report), found.seconds);
    Proposal<D> proposal = found.value->curved.proposal;
    run.quadratic().plan = Plan<D>{Wanted<D>{std::move(boundary), std::move(input.shells),
                                             std::move(found.value->curved), aim, std::move(input.extended)},
                                   std::move(proposal)};
    return Done{};
}

}  // namespace

template <int D>
Outcome<CurveInput<D>> begin_curving(Runner<D>& run, const Boundary<D>& boundary, const config::Curve& options) {
    return run.step("extension", [&](const Execution& e) -> Outcome<CurveInput<D>> {
        // The field of a surface alone is constant along its normals: there is nothing to carry.
        const bool carried = options.back_mesh == config::BackMeshKind::carried &&
                             options.objective != config::Objective::shape &&
                             !is_surface_alone(run.quadratic().mesh.linear);
        const double of_nodes = carried ? 0.18 : 0.5, of_planes = carried ? 0.5 : 1;
        auto input = curve_input(run.quadratic(), boundary, part_of(e, 0, of_nodes));
        if (!input) return input;
        input = carried_in_planes(run.quadratic(), boundary, std::move(*input), part_of(e, of_nodes, of_planes));
        if (!input || !carried) return input;
        return extended_input(run.quadratic(), std::move(*input), part_of(e, 0.5, 1));
    });
}

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Curve& options) {
    auto boundary = describe_boundary(run, run.quadratic().mesh.linear, run.quadratic().mesh.edges);
    if (!boundary) return fail(boundary.error());
    auto input = begin_curving(run, *boundary, options);
    if (!input) return fail(input.error());
    const QuadraticMesh<D>& mesh = run.quadratic().mesh;
    if (options.objective == config::Objective::shape && options.boundary_nodes == BoundaryNodeAim::length)
        return fail(ErrorKind::usage, "curve: the objective shape has no metric in which edges could be short", {}, {},
                    "take another objective, or boundary_nodes accuracy");
    if (options.objective == config::Objective::shape)
        return run.step_of(options, [&](const Execution& execution) {
            const Boundary<D> around = *boundary;
            const auto find = [&](const Execution& e) -> Outcome<Found<D>> {
                auto placed = placed_input(run.quadratic(), around, std::move(*input), BackMesh<D>{}, options,
                                           without_progress(e));
                if (!placed) return fail(placed.error());
                *input = std::move(*placed);
                if (input->placed) run.report(*input->placed);
                return by_shape(mesh, *input, e);
            };
            return curve_within(run, std::move(*boundary), *input, CurvingAim::energy, find, execution);
        });
    CurveOptions edges = edge_options(options);
    run.state.curving = edges;
    edges.measured = reported_lengths(run.config.output);
    input = make_field(run, *boundary, std::move(*input), edges.aim);
    if (!input) return fail(input.error());
    return run.step_of(options, [&](const Execution& execution) {
        const Boundary<D> around = *boundary;
        const auto find = [&](const Execution& e) -> Outcome<Found<D>> {
            const double of_slides = options.boundary_nodes != BoundaryNodeAim::projection ? 0.5
                                     : edges.aim != CurvingAim::accuracy                   ? 0
                                     : edges.measured == MeasuredEdges::all                ? 0.05
                                                                                           : 0.26;
            auto moved = moved_input(run, around, std::move(*input), *run.field(), options, part_of(e, 0, of_slides));
            if (!moved) return fail(moved.error());
            *input = std::move(*moved);
            return by_field(mesh, *input, *run.field(), edges, part_of(e, of_slides, 1));
        };
        auto done = curve_within(run, std::move(*boundary), *input, edges.aim, find, execution);
        if (done && run.quadratic().nodes == NodesOf::file) run.report(Notices{of_file(edges.aim)});
        return done;
    });
}

template <int D>
Outcome<CurveInput<D>> moved_input(Runner<D>& run, const Boundary<D>& boundary, CurveInput<D> input,
                                   const BackMesh<D>& field, const config::Curve& options, const Execution& execution) {
    const bool is_placed = options.boundary_nodes != BoundaryNodeAim::projection;
    auto moved = placed_input(run.quadratic(), boundary, std::move(input), field, options,
                              is_placed ? part_of(execution, 0, 0.8) : without_progress(execution));
    if (!moved) return moved;
    if (moved->placed) run.report(*moved->placed);
    // Nodes in planes are where their edges are shortest already.
    if (options.boundary_nodes == BoundaryNodeAim::length) return moved;
    return slid_input(run.quadratic(), boundary, std::move(*moved), field, edge_options(options),
                      is_placed ? part_of(execution, 0.8, 1) : execution);
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template CurveReport curve_report<D>(const QuadraticMesh<D>&, const Curved<D>&);                                  \
    template void report_curve<D>(Runner<D>&, CurveReport, double);                                                   \
    template Outcome<CurveInput<D>> begin_curving<D>(Runner<D>&, const Boundary<D>&, const config::Curve&);           \
    template Outcome<CurveInput<D>> moved_input<D>(Runner<D>&, const Boundary<D>&, CurveInput<D>, const BackMesh<D>&, \
                                                   const config::Curve&, const Execution&);                           \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Curve&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
