module;
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <variant>
module camber.run;
import camber.core;
import camber.bezier;
import camber.cad;
import camber.config;
import camber.crossing;
import camber.curving;
import camber.metric;
import camber.surface;
import camber.validity;
import :distances_report;
import :measures;
import :parts;
import :runner;
import :stages;
import :state;
import :steps;

namespace camber::run {

namespace {

/// The mid nodes of the straight mesh.
template <int D>
Outcome<Buffer<LagrangeNode<D>>> chord_middles(const QuadraticMesh<D>& mesh, const Execution& execution) {
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        return LagrangeNode<D>{midpoint(mesh.linear.points[a], mesh.linear.points[b])};
    });
}

/// The mesh with the places that it was given with: straight edges have their middles.
template <int D>
Outcome<QuadraticMesh<D>> as_given(QuadraticMesh<D> seen, const State<D>& state, const Execution& execution) {
    if (state.given_points.size() == seen.linear.points.size()) seen.linear.points = state.given_points;
    if (state.given_nodes.size() == seen.mid_nodes.size()) {
        seen.mid_nodes = state.given_nodes;
        return seen;
    }
    auto chords = chord_middles(seen, execution);
    if (!chords) return fail(chords.error());
    seen.mid_nodes = std::move(*chords);
    return seen;
}

/// How far the boundary is from its geometry, as it was given and in the end.
template <int D>
Outcome<Done> measure_distances(const QuadraticMesh<D>& seen, const State<D>& state, const Boundary<D>& boundary,
                                MeasuresReport& report, const Execution& execution) {
    const auto given = as_given(seen, state, without_progress(execution));
    if (!given) return fail(given.error());
    const auto before = boundary_distance(*given, given->mid_nodes.view(), boundary.features, boundary.geometry,
                                          part_of(execution, 0.05, 0.5));
    if (!before) return fail(before.error());
    const auto after = boundary_distance(seen, seen.mid_nodes.view(), boundary.features, boundary.geometry,
                                         part_of(execution, 0.5, 1));
    if (!after) return fail(after.error());
    report.straight_distance = before->largest;
    report.curved_distance = after->largest;
    return Done{};
}

/// Both ways and by entity, as it is in the end.
template <int D>
Outcome<Done> measure_both_ways(const Quadratic<D>& end, const Runner<D>& run, MeasuresReport& report,
                                const Execution& execution) {
    const Plan<D>* const plan = end.planned();
    if (!plan || !plan->wanted()) return Done{};
    const Boundary<D>& boundary = plan->wanted()->boundary;
    const auto seen = apply_proposal(end.mesh, plan->proposal());
    const auto samples = samples_of_geometry(seen, boundary.features, boundary.geometry, execution);
    if (!samples) return fail(samples.error());
    const auto found =
        distances_both_ways<D>(seen, seen.mid_nodes.view(), boundary.features, boundary.geometry, *samples, execution);
    if (!found) return fail(found.error());
    report.distances = distances_report(*found, boundary.geometry, run.config.geometry);
    return Done{};
}

/// Whether walls pass through each other, as they are in the end.
template <int D>
Outcome<WallsReport> measure_walls(const QuadraticMesh<D>& seen, const Execution& execution) {
    const auto found = find_crossings(seen, execution);
    if (!found) return fail(found.error());
    WallsReport report{.crossing = found->crossing, .touching = found->touching, .undecided = found->undecided};
    if (!found->all_disjoint()) {
        report.first = found->found.front().first.index() + 1;
        report.other = found->found.front().second.index() + 1;
    }
    return report;
}

/// How far `measure_end` is after each of its loops, as a share of its time; what is left are sums for the report.
struct Shares {
    double distances = 0, lengths = 0, all = 0;
};

/// Of all edges of a surface alone, as they are in the end.
template <int D>
Outcome<EdgeLengths> surface_lengths(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const Wanted<D>& wanted,
                                     const BackMesh<D>& field, MeasuredEdges which, const Execution& execution) {
    Proposal<D> all = proposal;
    all.kinds = Buffer<EdgeKind>(proposal.kinds.size(), EdgeKind::volume);
    return edge_lengths(mesh.edges, all, wanted.shells, field, which, execution);
}

/// Lengths after correction, against the chords as they are then, for the fields; the rest for the report.
template <int D>
struct Measured {
    std::optional<EdgeLengths> lengths;
    MeasuresReport report;
};
/// The metric of the straight mesh, where the field is another.
template <int D>
using StraightMetric = std::optional<Column<LogMetric<D>>>;

/// How far nodes of the boundary are from the CAD model that they were put onto.
template <int D>
Outcome<Done> measure_nodes(const Quadratic<D>& end, const config::Geometry& geometry, MeasuresReport& report,
                            const Execution& execution) {
    const Plan<D>* const plan = end.planned();
    if (!plan || !plan->boundary()) return Done{};
    const auto farthest = largest_node_distance(apply_proposal(end.mesh, plan->proposal()), *plan->boundary(),
                                                std::get<config::Cad>(geometry), execution);
    if (!farthest) return fail(farthest.error());
    report.node_distance = *farthest;
    return Done{};
}

template <int D>
Outcome<Measured<D>> measure_end(const Quadratic<D>& end, const BackMesh<D>* field, const State<D>& state,
                                 MeasuredEdges which, const Execution& execution) {
    const StraightMetric<D>& straight = state.straight_log_metrics;
    const Shares of = which == MeasuredEdges::all ? Shares{0.05, 0.09, 0.87} : Shares{0.39, 0.44, 0.73};
    Measured<D> measured;
    const Plan<D>* const plan = end.planned();
    if (const Boundary<D>* boundary = plan ? plan->boundary() : nullptr)
        if (auto done = measure_distances(apply_proposal(end.mesh, plan->proposal()), state, *boundary, measured.report,
                                          part_of(execution, 0, of.distances));
            !done)
            return fail(done.error());
    if (const Wanted<D>* wanted = plan ? plan->wanted() : nullptr) {
        const Proposal<D>& proposal = plan->proposal();
        const auto seen = apply_proposal(end.mesh, proposal);
        auto walls = measure_walls(seen, without_progress(execution));
        if (!walls) return fail(walls.error());
        measured.report.walls = *walls;
        if (field && is_surface_alone(end.mesh.linear)) {
            auto lengths = surface_lengths(end.mesh, proposal, *wanted, *field, which,
                                           part_of(execution, of.distances, of.lengths));
            if (!lengths) return fail(lengths.error());
            measured.report.edges = edge_report(seen, proposal, lengths->straight, lengths->curved);
            measured.lengths = std::move(*lengths);
        } else if (field) {
            auto lengths = updated_lengths(end.mesh.edges, wanted->curved, proposal, wanted->shells, *field, which,
                                           part_of(execution, of.distances, of.lengths));
            if (!lengths) return fail(lengths.error());
            measured.report.edges = edge_report(seen, proposal, lengths->straight, lengths->curved);
            measured.lengths = std::move(*lengths);
            if (straight) {
                const auto beside = straight_back_mesh(*field, *straight);
                if (!beside) return fail(beside.error());
                const auto other = edge_lengths(end.mesh.edges, proposal, wanted->shells, *beside, which,
                                                part_of(execution, of.lengths, of.all));
                if (!other) return fail(other.error());
                measured.report.edges_in_straight_field = edge_report(seen, proposal, other->straight, other->curved);
            }
        }
    }
    auto histograms = run_histograms(end, measured.lengths, state.history, without_progress(execution));
    if (!histograms) return fail(histograms.error());
    measured.report.histograms = std::move(*histograms);
    return measured;
}

}  // namespace

template <int D>
Outcome<std::optional<EdgeLengths>> measure(Runner<D>& run) {
    const auto* const end = std::get_if<Quadratic<D>>(&run.state.mesh);
    if (end && end->planned()) run.report(PlanReport{.is_mesh = !end->has_uncommitted()});
    auto made = run.step("measure", [&](const Execution& e) -> Outcome<Measured<D>> {
        if (!end) return Measured<D>{};
        auto measured = measure_end(*end, run.field(), run.state, reported_lengths(run.config.output), e);
        if (measured && run.config.output.distances == DistanceWays::both)
            if (auto both = measure_both_ways(*end, run, measured->report, without_progress(e)); !both)
                return fail(both.error());
        if (!measured || !run.geometry.cad) return measured;
        if (auto nodes = measure_nodes(*end, run.config.geometry, measured->report, without_progress(e)); !nodes)
            return fail(nodes.error());
        return measured;
    });
    if (!made) return fail(made.error());
    run.report(made->report);
    return std::move(made->lengths);
}

#define CAMBER_INSTANTIATE(D) template Outcome<std::optional<EdgeLengths>> measure<D>(Runner<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
