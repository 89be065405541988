module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <utility>
module camber.run;
import camber.core;
import camber.bezier;
import camber.curving;
import camber.metric;
import camber.recipes;
import camber.surface;
import :report;
import :steps;

namespace camber::run {

namespace {

/// Nodes of inner edges: how far apart those of the mesh and the others are, by the chord.
template <int D>
RemeshedNodesReport compared(const QuadraticMesh<D>& mesh, const Curved<D>& curved) {
    constexpr double noticeable = 0.01;
    RemeshedNodesReport report{.objective = std::string(word_of(Objective::accuracy))};
    double sum = 0;
    for (EdgeId e(0); e.index() < mesh.edges.size(); e = EdgeId(e.index() + 1)) {
        if (curved.proposal.kinds[e] != EdgeKind::volume) continue;
        const auto& [a, b] = mesh.edges.vertices[e];
        const double chord = distance(mesh.linear.points[a], mesh.linear.points[b]);
        const double apart = distance(mesh.mid_nodes[e].point, curved.proposal.mid_nodes[e].point) / chord;
        ++report.edges;
        report.apart += apart > noticeable;
        report.largest_apart = std::max(report.largest_apart, apart);
        sum += apart;
    }
    if (report.edges > 0) report.mean_apart = sum / static_cast<double>(report.edges);
    return report;
}

}  // namespace

template <int D>
Outcome<RemeshedNodesReport> nodes_beside_curve(const QuadraticMesh<D>& mesh, const Geometry<D>& geometry,
                                                const MetricSource<D>& metric, const CurveOptions& curving,
                                                const Execution& execution) {
    auto features = find_features(mesh.linear, mesh.edges, listed_breaks<D>, part_of(execution, 0, 0.1));
    if (!features) return fail(features.error());
    const Boundary<D> boundary{std::move(*features), RequiredBoundary::keep, geometry};
    ProposeOptions options;
    static_cast<CurveOptions&>(options) = curving;
    options.measured = MeasuredEdges::none;
    const Execution quiet = without_progress(execution);
    const auto proposed =
        propose_curves<D>({mesh, NodesOf::input, boundary}, metric, GivenSolution<D>{}, options, plainly(quiet));
    if (!proposed) return fail(proposed.error());
    return compared(mesh, proposed->curved);
}

#define CAMBER_INSTANTIATE(D)                                    \
    template Outcome<RemeshedNodesReport> nodes_beside_curve<D>( \
        const QuadraticMesh<D>&, const Geometry<D>&, const MetricSource<D>&, const CurveOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
