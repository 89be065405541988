module;
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
import :report;
import :stages;
import :state;

namespace camber::run {

namespace {

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

template <int D>
CurveOutput<D> with_report(const QuadraticMesh<D>& mesh, Curved<D> curved) {
    const CurveReport report = curve_report(mesh, curved);
    return {std::move(curved), report};
}

}  // namespace

EdgeMinimiserOptions edge_options(const config::Curve& options) {
    EdgeMinimiserOptions edge = options;
    edge.objective =
        options.objective == config::Objective::energy ? EdgeObjectiveKind::energy : EdgeObjectiveKind::length;
    return edge;
}

template <int D>
CurveReport curve_report(const QuadraticMesh<D>& mesh, const Curved<D>& curved) {
    const CurveStatistics& s = curved.statistics;
    return {mesh.edges.size(),
            s.volume_edges,
            s.curved_edges,
            s.polished,
            s.exhausted,
            s.shortened,
            s.outside,
            s.lost,
            edge_report(mesh, curved.proposal, curved.straight_lengths, curved.lengths),
            {},
            0};
}

template <int D>
Outcome<CurveOutput<D>> curve_stage(const QuadraticMesh<D>& mesh, const CurveInput<D>& input, const BackMesh<D>& field,
                                    const config::Curve& options, const Execution& execution) {
    auto curved = curve(mesh, input.kinds, input.boundary_nodes, input.shells, field, edge_options(options), execution);
    if (!curved) return fail(curved.error());
    return with_report(mesh, std::move(*curved));
}

template <int D>
Outcome<CurveOutput<D>> shape_stage(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                    const Execution& execution) {
    auto done = shape(mesh, input.kinds, input.boundary_nodes, input.shells, ShapeOptions{}, execution);
    if (!done) return fail(done.error());
    return with_report(mesh, without_lengths(mesh, input.kinds, std::move(done->proposal)));
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template CurveReport curve_report<D>(const QuadraticMesh<D>&, const Curved<D>&);                                   \
    template Outcome<CurveOutput<D>> curve_stage<D>(const QuadraticMesh<D>&, const CurveInput<D>&, const BackMesh<D>&, \
                                                    const config::Curve&, const Execution&);                           \
    template Outcome<CurveOutput<D>> shape_stage<D>(const QuadraticMesh<D>&, const CurveInput<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
