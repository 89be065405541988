module;
#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
module camber.run;
import camber.core;
import camber.config;
import camber.curving;
import camber.metric;
import camber.recipes;
import camber.validity;
import :measures;
import :parts;
import :report;
import :runner;
import :solution_source;
import :stages;
import :state;
import :steps;

namespace camber::run {

namespace {

/// What became of the nodes that a mesh was read with.
Notices kept_nodes(std::size_t edges) {
    return {fmt::format("{} edges of the boundary keep the nodes that the mesh was read with", edges)};
}
constexpr const char* of_volume(CurvingAim aim) {
    return aim == CurvingAim::accuracy
               ? "volume edges: their nodes are found anew; those that the mesh was read with do not count"
               : "volume edges: the search begins at the node that the mesh was read with, where that is the better "
                 "start";
}

BoundaryNodesReport nodes_report(BoundaryNodeAim aim, const PlacementStatistics& s) {
    return {std::string(word_of(aim)),
            s.edges,
            s.placed,
            s.best,
            s.off,
            s.far,
            s.elements,
            s.walked,
            s.limited,
            s.mean_reduction,
            s.largest_reduction};
}

}  // namespace

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
            {},
            {},
            0,
            {}};
}

template <int D>
void report_curves(Runner<D>& run, const ProposedCurves<D>& made, const ProposeOptions& options, double seconds) {
    const Quadratic<D>& at = run.quadratic();
    if (made.input.placed) run.report(nodes_report(options.boundary_nodes, *made.input.placed));
    CurveReport part = curve_report(at.mesh, made.curved);
    if (made.field && made.edges.aim == CurvingAim::accuracy && !is_surface_alone(at.mesh.linear)) {
        const CurveStatistics& s = made.curved.statistics;
        part.by = NodesByReport{std::string(word_of(made.edges.metric_kind)), share_of_sizes(made.edges, D), s.by_walls,
                                s.by_metric, s.held_back};
    }
    part.expected = made.expected;
    part.objective = word_of(options.objective);
    part.edges_per_second = static_cast<double>(part.volume_edges) / std::max(seconds, 1e-9);
    run.report(part);
    if (at.nodes != NodesOf::input) return;
    if (made.input.kept > 0) run.report(kept_nodes(made.input.kept));
    if (made.field) run.report(Notices{of_volume(edge_options(options).aim)});
}

template <int D>
Wanted<D> keep_field(Runner<D>& run, Boundary<D> boundary, ProposedCurves<D> made, CurvingAim aim) {
    run.state.field = std::move(made.field);
    run.state.straight_log_metrics = std::move(made.straight_log_metrics);
    return {std::move(boundary), std::move(made.input.shells), std::move(made.curved), aim,
            std::move(made.input.extended)};
}

namespace {

/// What nodes are placed by, on the mesh that is curved; none where no stage asks for it.
template <int D>
Outcome<GivenSolution<D>> solution_for(Runner<D>& run, const QuadraticMesh<D>& mesh, Clocks& clocks) {
    if (run.solution == nullptr) return GivenSolution<D>{};
    return solution_on(*run.solution, mesh, run.around(clocks));
}

}  // namespace

template <int D>
Outcome<Done> apply(Runner<D>& run, const config::Curve& given) {
    auto options = static_cast<const ProposeOptions&>(given);
    options.measured = reported_lengths(run.config.output);
    Quadratic<D>& at = run.quadratic();
    auto boundary = describe_boundary(run, at.mesh.linear, at.mesh.edges);
    if (!boundary) return fail(boundary.error());
    const CurvingAim aim = has_field(options.objective) ? edge_options(options).aim : CurvingAim::energy;
    if (has_field(options.objective)) run.state.curving = edge_options(given);
    MetricTold told;
    const auto metric = metric_for_curving(run, at.mesh, *boundary, told);
    Clocks clocks;
    auto solution = solution_for(run, at.mesh, clocks);
    if (!solution) return fail(solution.error());
    auto made = propose_curves<D>({at.mesh, at.nodes, *boundary}, metric, *solution, options, run.around(clocks));
    if (!made) return fail(made.error());
    report_metric(run, std::move(told));
    report_curves(run, *made, options, clocks.seconds["curve"]);
    Proposal<D> proposal = made->curved.proposal;
    at.plan = Plan<D>{keep_field(run, std::move(*boundary), std::move(*made), aim), std::move(proposal)};
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                            \
    template CurveReport curve_report<D>(const QuadraticMesh<D>&, const Curved<D>&);                     \
    template void report_curves<D>(Runner<D>&, const ProposedCurves<D>&, const ProposeOptions&, double); \
    template Wanted<D> keep_field<D>(Runner<D>&, Boundary<D>, ProposedCurves<D>, CurvingAim);            \
    template Outcome<Done> apply<D>(Runner<D>&, const config::Curve&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
