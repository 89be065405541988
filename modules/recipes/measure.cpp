module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.crossing;
import camber.surface;
import camber.curving;
import camber.stages;

namespace camber::run {

namespace {

template <int D>
Outcome<Buffer<LagrangeNode<D>>> chord_middles(const QuadraticMesh<D>& mesh, const Execution& execution) {
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        return LagrangeNode<D>{midpoint(mesh.linear.points[a], mesh.linear.points[b])};
    });
}

/// The mesh at its input positions; nodes of straight edges are at their middles.
template <int D>
Outcome<QuadraticMesh<D>> as_in_input(QuadraticMesh<D> proposed_mesh, const State<D>& state,
                                      const Execution& execution) {
    if (state.input_points.size() == proposed_mesh.linear.points.size())
        proposed_mesh.linear.points = state.input_points;
    if (state.input_nodes.size() == proposed_mesh.mid_nodes.size()) {
        proposed_mesh.mid_nodes = state.input_nodes;
        return proposed_mesh;
    }
    auto chords = chord_middles(proposed_mesh, execution);
    if (!chords) return fail(chords.error());
    proposed_mesh.mid_nodes = std::move(*chords);
    return proposed_mesh;
}

template <int D>
Outcome<Done> measure_distances(const QuadraticMesh<D>& proposed_mesh, const State<D>& state,
                                const Boundary<D>& boundary, BoundaryReport& report, const Execution& execution) {
    const auto specified = as_in_input(proposed_mesh, state, without_progress(execution));
    if (!specified) return fail(specified.error());
    const auto after = largest_boundary_distance(proposed_mesh, proposed_mesh.mid_nodes.view(), boundary.features,
                                                 boundary.geometry, part_of(execution, 0.05, 0.7));
    if (!after) return fail(after.error());
    const NearBoundary<D> near{proposed_mesh, proposed_mesh.mid_nodes.view(), after->largest};
    const auto before = largest_boundary_distance(*specified, specified->mid_nodes.view(), boundary.features,
                                                  boundary.geometry, near, part_of(execution, 0.7, 1));
    if (!before) return fail(before.error());
    report.straight_distance = before->largest;
    report.curved_distance = after->largest;
    if (after->facet.valid()) {
        Vec<D> centre{};
        for (const VertexId v : proposed_mesh.linear.facets.vertices[after->facet])
            centre += proposed_mesh.linear.points[v] / D;
        report.curved_distance_near.assign(centre.c.begin(), centre.c.end());
    }
    return Done{};
}

template <int D>
Outcome<Done> measure_both_ways(const Quadratic<D>& end, const Runner<D>& run, BoundaryReport& report,
                                const Execution& execution) {
    const Plan<D>* const plan = end.planned();
    if (!plan || !plan->target()) return Done{};
    const Boundary<D>& boundary = plan->target()->boundary;
    const auto proposed_mesh = apply_proposal(end.mesh, plan->proposal());
    const auto samples = samples_of_geometry(proposed_mesh, boundary.features, boundary.geometry, execution);
    if (!samples) return fail(samples.error());
    const auto found = two_sided_distances<D>(proposed_mesh, proposed_mesh.mid_nodes.view(), boundary.features,
                                              boundary.geometry, *samples, execution);
    if (!found) return fail(found.error());
    report.distances = distances_report(*found, boundary.geometry, run.config.geometry);
    return Done{};
}

/// Passes count them before they change the mesh.
template <int D>
Outcome<std::size_t> crossings_of_input(const QuadraticMesh<D>& proposed_mesh, const State<D>& state,
                                        const Execution& execution) {
    if (state.crossings_of_input) return *state.crossings_of_input;
    const auto specified = as_in_input(proposed_mesh, state, execution);
    if (!specified) return fail(specified.error());
    return find_crossings(*specified, execution).map([](const Crossings& found) { return found.crossing; });
}

template <int D>
Outcome<WallsReport> measure_walls(const QuadraticMesh<D>& proposed_mesh, const Crossings& found, const State<D>& state,
                                   const Execution& execution) {
    WallsReport report = walls_report<D>(found, [&](FacetId f) {
        Box<D> box;
        for (const Vec<D>& node : nodal_facet(proposed_mesh, f).nodes) box.include(node);
        return box;
    });
    report.relaxed = state.relaxed_walls;
    if (report.crossing == 0) return report;
    const auto before = crossings_of_input(proposed_mesh, state, execution);
    if (!before) return fail(before.error());
    report.crossing_before = *before;
    return report;
}

/// None unless passes made the mesh.
template <int D>
std::optional<WallsReport> measure_walls(const LinearMesh<D>& mesh, const Crossings& found, const State<D>& state) {
    if (!state.crossings_of_input || state.rows) return std::nullopt;
    WallsReport report = walls_report<D>(found, [&](FacetId f) {
        Box<D> box;
        for (const VertexId v : mesh.facets.vertices[f]) box.include(mesh.points[v]);
        return box;
    });
    report.crossing_before = *state.crossings_of_input;
    return report;
}

/// Shares of time until the end of each loop.
struct Shares {
    double distances = 0, lengths = 0, all = 0;
};

template <int D>
Outcome<EdgeLengths> surface_lengths(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal,
                                     const CurvingTarget<D>& target, const BackMesh<D>& field,
                                     MeasuredEdges measured_edges, const Execution& execution) {
    Proposal<D> all = proposal;
    all.kinds = Buffer<EdgeKind>(proposal.kinds.size(), EdgeKind::volume);
    return edge_lengths({mesh.edges, target.shells}, all, field, measured_edges, execution);
}

/// `lengths`, for output fields: after correction, relative to the corrected chords.
template <int D>
struct Measured {
    std::optional<EdgeLengths> lengths = {};
    std::optional<EdgeReport> edges = {};                    ///< after correction
    std::optional<EdgeReport> edges_in_straight_field = {};  ///< the same in the field of the straight mesh, if the
                                                             ///< back mesh is curved
    BoundaryReport boundary = {};
    std::vector<Histogram> histograms = {};
    std::optional<Crossings> crossings = {};  ///< if they were searched for
};
/// Metric of the straight mesh, if the field is another one.
template <int D>
using StraightMetric = std::optional<Column<LogMetric<D>>>;

template <int D>
Outcome<Measured<D>> measure_end(const Quadratic<D>& end, const Runner<D>& run, MeasuredEdges measured_edges,
                                 const Execution& execution) {
    const State<D>& state = run.state;
    const BackMesh<D>* const field = run.field();
    const StraightMetric<D>& straight = state.straight_log_metrics;
    const Shares of = measured_edges == MeasuredEdges::all ? Shares{0.05, 0.09, 0.87} : Shares{0.39, 0.44, 0.73};
    Measured<D> measured;
    measured.boundary = run.report.boundary.value_or(BoundaryReport{});
    const Plan<D>* const plan = end.planned();
    if (const Boundary<D>* boundary = plan ? plan->boundary() : nullptr) {
        const auto proposed_mesh = apply_proposal(end.mesh, plan->proposal());
        if (auto done = measure_distances(proposed_mesh, state, *boundary, measured.boundary,
                                          part_of(execution, 0, of.distances));
            !done)
            return fail(done.error());
    }
    if (plan || state.crossings_of_input) {
        const auto proposed_mesh = plan ? apply_proposal(end.mesh, plan->proposal()) : end.mesh;
        auto found = state.crossings && state.crossings->is_of(proposed_mesh)
                         ? Outcome<Crossings>(state.crossings->crossings)
                         : find_crossings(proposed_mesh, without_progress(execution));
        if (!found) return fail(found.error());
        auto walls = measure_walls(proposed_mesh, *found, state, without_progress(execution));
        if (!walls) return fail(walls.error());
        measured.crossings = std::move(*found);
        measured.boundary.walls = std::move(*walls);
    }
    if (const CurvingTarget<D>* target = plan ? plan->target() : nullptr) {
        const Proposal<D>& proposal = plan->proposal();
        const auto proposed_mesh = apply_proposal(end.mesh, proposal);
        if (field && is_standalone_surface(end.mesh.linear)) {
            auto lengths = surface_lengths(end.mesh, proposal, *target, *field, measured_edges,
                                           part_of(execution, of.distances, of.lengths));
            if (!lengths) return fail(lengths.error());
            measured.edges = edge_report(proposed_mesh, proposal, lengths->straight, lengths->curved);
            measured.lengths = std::move(*lengths);
        } else if (field) {
            auto lengths = updated_lengths({end.mesh.edges, target->shells}, target->curved, proposal, *field,
                                           measured_edges, part_of(execution, of.distances, of.lengths));
            if (!lengths) return fail(lengths.error());
            measured.edges = edge_report(proposed_mesh, proposal, lengths->straight, lengths->curved);
            measured.lengths = std::move(*lengths);
            if (straight) {
                const auto beside = straight_back_mesh(*field, *straight);
                if (!beside) return fail(beside.error());
                const auto other = edge_lengths({end.mesh.edges, target->shells}, proposal, *beside, measured_edges,
                                                part_of(execution, of.lengths, of.all));
                if (!other) return fail(other.error());
                measured.edges_in_straight_field = edge_report(proposed_mesh, proposal, other->straight, other->curved);
            }
        }
    }
    auto histograms = run_histograms(end, measured.lengths, state.history, without_progress(execution));
    if (!histograms) return fail(histograms.error());
    measured.histograms = std::move(*histograms);
    return measured;
}

/// `crossings`: of the mesh; if empty, those of a quadratic mesh are computed.
template <int D>
Outcome<OverlappingReport> measure_overlaps(const State<D>& state, const std::optional<Crossings>& crossings,
                                            const Execution& execution) {
    const auto find = [&]() -> Outcome<Overlaps<D>> {
        const auto* const linear = std::get_if<LinearMesh<D>>(&state.mesh);
        if (linear && crossings) return find_overlaps(*linear, *crossings, execution);
        const auto* const quadratic = std::get_if<Quadratic<D>>(&state.mesh);
        if (!quadratic) return Overlaps<D>{};
        const Plan<D>* const plan = quadratic->planned();
        const auto proposed_mesh = plan ? apply_proposal(quadratic->mesh, plan->proposal()) : quadratic->mesh;
        return crossings ? find_overlaps(proposed_mesh, *crossings, execution)
                         : find_overlaps(proposed_mesh, execution);
    };
    const auto found = find();
    if (!found) return fail(found.error());
    OverlappingReport report;
    report.overlapping = found->overlapping;
    if (!found->found.empty()) {
        const auto& point = found->found.front().point.c;
        report.point.assign(point.begin(), point.end());
    }
    return report;
}

template <int D>
struct EndBoundary {
    QuadraticMesh<D> mesh;
    Column<EdgeKind> kinds;  ///< kinds in the plan, which define fixed nodes
    Features<D> features;
    Geometry<D> geometry;
    bool is_planned = false;                 ///< true: a stage after the passes placed nodes, or there were no passes
    Column<LagrangeNode<D>> own_nodes = {};  ///< nodes of a curved input
};
template <int D>
Outcome<std::optional<EndBoundary<D>>> end_boundary(const State<D>& state, const Execution& execution) {
    const auto* const curved = std::get_if<Quadratic<D>>(&state.mesh);
    if (curved && curved->planned()) {
        const Plan<D>& plan = *curved->planned();
        if (!plan.boundary()) return std::nullopt;
        EndBoundary<D> end{apply_proposal(curved->mesh, plan.proposal()), plan.proposal().kinds,
                           plan.boundary()->features, plan.boundary()->geometry, true};
        if (curved->nodes == NodesOf::input && state.input_nodes.size() == end.mesh.mid_nodes.size())
            end.own_nodes = state.input_nodes;
        return std::optional(std::move(end));
    }
    if (!state.inherited || state.rows) return std::nullopt;
    auto mesh = curved ? Outcome<QuadraticMesh<D>>(curved->mesh)
                       : elevate(std::get<LinearMesh<D>>(state.mesh), part_of(execution, 0, 0.6));
    if (!mesh) return fail(mesh.error());
    auto features = find_features(mesh->linear, mesh->edges, listed_breaks<D>, part_of(execution, 0.6, 1));
    if (!features) return fail(features.error());
    // Nodes of a straight mesh are no part of the result.
    Column<EdgeKind> kinds = curved ? kinds_with_required_fixed(*mesh, features->edge_kinds, RequiredBoundary::keep)
                                    : Column<EdgeKind>(Buffer<EdgeKind>(mesh->edges.size(), EdgeKind::fixed));
    return std::optional(
        EndBoundary<D>{std::move(*mesh), std::move(kinds), std::move(*features), state.inherited->geometry});
}

template <int D>
Outcome<Done> measure_deviation(const EndBoundary<D>& end, const BoundaryTolerance& tolerance, BoundaryReport& report,
                                const Execution& execution) {
    const QuadraticMesh<D>& mesh = end.mesh;
    const auto found =
        boundary_deviation<D>(mesh, end.kinds.view(), end.geometry, end.own_nodes.view(), tolerance, execution);
    if (!found) return fail(found.error());
    const auto& [nodes, vertices] = *found;
    if (nodes.measured > 0) {
        const auto [low, high] = nodes.worst.valid() ? mesh.edges.vertices[nodes.worst] : std::array<VertexId, 2>{};
        const Vec<D> at = nodes.worst.valid() ? mesh.mid_nodes[nodes.worst].point : Vec<D>{};
        report.node_deviation = deviation_report(nodes, tolerance.nodes, {low.index() + 1, high.index() + 1}, at);
    }
    const Vec<D> at = vertices.worst.valid() ? mesh.linear.points[vertices.worst] : Vec<D>{};
    report.vertex_deviation = deviation_report(vertices, tolerance.vertices, {vertices.worst.index() + 1, 0}, at);
    return Done{};
}

template <int D>
Outcome<Done> measure_boundary(const Runner<D>& run, BoundaryReport& report, const Execution& execution) {
    const auto [bounds, are_required] = bounded_distances(run);
    const State<D>& state = run.state;
    const auto end = end_boundary(state, part_of(execution, 0, 0.2));
    if (!end) return fail(end.error());
    if (!*end) return Done{};
    if (auto done = measure_deviation(**end, run.config.geometry_tolerance, report, part_of(execution, 0.2, 0.4));
        !done)
        return done;
    if (report.cad && state.inherited && report.vertex_deviation)
        report.cad->largest_vertex_distance = report.vertex_deviation->largest;
    if (bounds.empty()) return Done{};
    const bool is_known = state.reached && !(*end)->is_planned;
    const auto reached = is_known ? Outcome<ReachedDistance<D>>(*state.reached)
                                  : reached_distance((*end)->mesh, (*end)->features, (*end)->geometry, bounds,
                                                     part_of(execution, 0.4, 1));
    if (!reached) return fail(reached.error());
    report.geometry_error = GeometryErrorReport{reached->required,
                                                reached->reached,
                                                reached->far_facets,
                                                reached->facet.valid() ? reached->facet.index() + 1 : 0,
                                                {reached->at.c.begin(), reached->at.c.end()},
                                                are_required};
    return Done{};
}

template <int D>
Outcome<Measured<D>> measured_result(Runner<D>& run, const Execution& e) {
    const auto* const end = std::get_if<Quadratic<D>>(&run.state.mesh);
    auto measured = end ? measure_end(*end, run, reported_lengths(run.config.output), e)
                        : Outcome<Measured<D>>(Measured<D>{.boundary = run.report.boundary.value_or(BoundaryReport{})});
    if (!measured) return measured;
    if (!end) {
        const auto& mesh = std::get<LinearMesh<D>>(run.state.mesh);
        auto found = find_crossings(mesh, without_progress(e));
        if (!found) return fail(found.error());
        measured->boundary.walls = measure_walls(mesh, *found, run.state);
        measured->crossings = std::move(*found);
    }
    auto overlapping = measure_overlaps(run.state, measured->crossings, without_progress(e));
    if (!overlapping) return fail(overlapping.error());
    run.report.overlaps = std::move(*overlapping);
    if (auto boundary = measure_boundary(run, measured->boundary, without_progress(e)); !boundary)
        return fail(boundary.error());
    if (end && run.config.output.distances == DistanceDirections::both)
        if (auto both = measure_both_ways(*end, run, measured->boundary, without_progress(e)); !both)
            return fail(both.error());
    return measured;
}

}  // namespace

template <int D>
Outcome<std::optional<EdgeLengths>> measure(Runner<D>& run) {
    Report& report = run.report;
    const auto* const end = std::get_if<Quadratic<D>>(&run.state.mesh);
    if (end && end->planned() && (!report.committed || end->has_uncommitted()))
        run.note("planned nodes were not committed: no stage \"commit\" follows");
    auto result = run.step("measure", [&](const Execution& e) { return measured_result(run, e); });
    if (!result) return fail(result.error());
    if (report.curve) {
        report.curve->after = result->edges;
        report.curve->in_straight_field = result->edges_in_straight_field;
    }
    if (report.boundary) report.boundary = std::move(result->boundary);
    if (report.boundary && report.boundary->cad)
        if (const auto& nodes = report.boundary->node_deviation)
            report.boundary->cad->largest_node_distance = nodes->largest;
    add(report.histograms, std::move(result->histograms));
    return std::move(result->lengths);
}

namespace {

std::vector<double> of_volume(std::span<const double> values, const Column<EdgeKind>& kinds) {
    std::vector<double> selected;
    selected.reserve(values.size());
    for (std::size_t e = 0; e < values.size(); ++e)
        if (kinds[e] == EdgeKind::volume) selected.push_back(values[e]);
    return selected;
}
std::vector<double> of_measured(std::span<const double> values, const Column<double>& lengths) {
    std::vector<double> selected;
    for (std::size_t e = 0; e < values.size(); ++e)
        if (lengths[e] > 0) selected.push_back(values[e]);
    return selected;
}

/// Series to count. Each is an independent loop, and all of them run in parallel.
class Counting {
  public:
    void add(Quantity quantity, std::string name, std::function<std::vector<double>()> values) {
        jobs_.push_back({quantity, std::move(name), std::move(values)});
    }
    [[nodiscard]] Outcome<std::vector<Histogram>> run(const Execution& execution) const {
        auto series = map_each(
            execution, jobs_.size(),
            [&](std::size_t i) {
                const auto& [quantity, name, values] = jobs_[i];
                return counted(name, limits_of(quantity), values());
            },
            1);
        if (!series) return fail(series.error());
        std::vector<Histogram> histograms;
        for (std::size_t i = 0; i < jobs_.size(); ++i) {
            if (histograms.empty() || histograms.back().quantity != jobs_[i].quantity)
                histograms.push_back({jobs_[i].quantity, limits_of(jobs_[i].quantity), {}});
            histograms.back().series.push_back(std::move((*series)[i]));
        }
        return histograms;
    }

  private:
    struct Job {
        Quantity quantity;
        std::string name;
        std::function<std::vector<double>()> values;
    };
    std::vector<Job> jobs_;
};

template <int D>
std::vector<double> jacobians(const Validation<D>& v) {
    return {v.min_scaled_jacobian.begin(), v.min_scaled_jacobian.end()};
}

}  // namespace

std::vector<double> length_reductions(const Column<double>& straight, const Column<double>& lengths) {
    std::vector<double> reductions(lengths.size());
    for (std::size_t e = 0; e < reductions.size(); ++e)
        reductions[e] = lengths[e] > 0 ? straight[e] / lengths[e] - 1 : 0;
    return reductions;
}

template <int D>
std::vector<double> curvatures(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes) {
    std::vector<double> values(mid_nodes.size());
    for (std::size_t e = 0; e < values.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const QuadraticEdge<D> edge{mesh.linear.points[a], mid_nodes[e], mesh.linear.points[b]};
        values[e] = norm_squared(edge.chord()) > 0 ? curvature(edge) : 0;
    }
    return values;
}

MeasuredEdges reported_lengths(const config::Output& output) {
    return shows_fields(output) ? MeasuredEdges::all : MeasuredEdges::some;
}

template <int D>
std::size_t bent_edges(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal) {
    std::size_t n = 0;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        n += proposal.mid_nodes[e].point != midpoint(proposal.points[a], proposal.points[b]);
    }
    return n;
}

template <int D>
EdgeReport edge_report(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const Column<double>& straight,
                       const Column<double>& lengths) {
    const auto reductions = length_reductions(straight, lengths);
    const auto curved = curvatures<D>(mesh, proposal.mid_nodes.view());
    const bool is_alone = is_standalone_surface(mesh.linear);
    EdgeReport r;
    std::size_t n = 0;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        if (proposal.kinds[e] != EdgeKind::volume && !is_alone) continue;
        r.mean_curvature += curved[e];
        r.largest_curvature = std::max(r.largest_curvature, curved[e]);
        ++n;
        if (!(straight[e] > 0)) continue;
        r.mean_length_reduction += reductions[e];
        r.largest_length_reduction = std::max(r.largest_length_reduction, reductions[e]);
        r.longer += reductions[e] < 0;
        ++r.measured;
    }
    if (r.measured > 0) r.mean_length_reduction /= static_cast<double>(r.measured);
    if (n > 0) r.mean_curvature /= static_cast<double>(n);
    return r;
}

namespace {

/// Standalone surface mesh: counts all edges. They follow the surface, so there are no length reductions.
template <int D>
void count_surface_edges(Counting& counting, const QuadraticMesh<D>& mesh, const Curved<D>& curved,
                         const Proposal<D>& in_the_end, const EdgeLengths& lengths) {
    const auto known = [&counting, &lengths](const char* name, const Column<double>& values) {
        counting.add(Quantity::length, name, [&] { return of_measured(values.view(), lengths.straight); });
    };
    const auto bent = [&counting, &mesh](const char* name, const Proposal<D>& proposed) {
        counting.add(Quantity::curvature, name,
                     [&] { return curvatures<D>(apply_proposal(mesh, proposed), proposed.mid_nodes.view()); });
    };
    known("straight", lengths.straight);
    known("after", lengths.curved);
    bent("before", curved.proposal);
    bent("after", in_the_end);
}

/// The arguments must outlive `counting`.
template <int D>
void count_edges(Counting& counting, const QuadraticMesh<D>& mesh, const Curved<D>& curved,
                 const Proposal<D>& in_the_end, const EdgeLengths& lengths) {
    const auto reductions = [&counting, &curved](const char* name, const Column<double>& chords,
                                                 const Column<double>& now) {
        counting.add(Quantity::length_reduction, name,
                     [&] { return of_measured(length_reductions(chords, now), curved.straight_lengths); });
    };
    const auto known = [&counting, &curved](const char* name, const Column<double>& values) {
        counting.add(Quantity::length, name, [&] { return of_measured(values.view(), curved.straight_lengths); });
    };
    const auto bent = [&counting, &mesh, &in_the_end](const char* name, const Proposal<D>& proposed) {
        counting.add(Quantity::curvature, name, [&] {
            return of_volume(curvatures<D>(apply_proposal(mesh, proposed), proposed.mid_nodes.view()),
                             in_the_end.kinds);
        });
    };
    reductions("before", curved.straight_lengths, curved.lengths);
    reductions("after", lengths.straight, lengths.curved);
    known("straight", curved.straight_lengths);
    known("before", curved.lengths);
    known("after", lengths.curved);
    bent("before", curved.proposal);
    bent("after", in_the_end);
}

/// Verdicts before any correction; null: not validated.
template <int D>
const Validation<D>* first_of(const History<D>& history) {
    if (const auto* corrected = std::get_if<Corrected<D>>(&history)) return &corrected->before;
    const auto& last = std::get<Uncorrected<D>>(history).last;
    return last ? &*last : nullptr;
}

}  // namespace

template <int D>
Outcome<std::vector<Histogram>> run_histograms(const Quadratic<D>& end, const std::optional<EdgeLengths>& lengths,
                                               const History<D>& history, const Execution& execution) {
    Counting counting;
    const Plan<D>* const plan = end.planned();
    if (plan && plan->target() && lengths && is_standalone_surface(end.mesh.linear))
        count_surface_edges(counting, end.mesh, plan->target()->curved, plan->proposal(), *lengths);
    else if (plan && plan->target() && lengths)
        count_edges(counting, end.mesh, plan->target()->curved, plan->proposal(), *lengths);
    if (const Validation<D>* validation = end.validation()) {
        const Validation<D>* const first = first_of(history);
        if (plan && first) counting.add(Quantity::scaled_jacobian, "before", [first] { return jacobians(*first); });
        counting.add(Quantity::scaled_jacobian, plan ? "after" : "count",
                     [validation] { return jacobians(*validation); });
    }
    return counting.run(execution);
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<std::optional<EdgeLengths>> measure<D>(Runner<D>&);                                               \
    template std::vector<double> curvatures<D>(const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>);             \
    template std::size_t bent_edges<D>(const QuadraticMesh<D>&, const Proposal<D>&);                                   \
    template EdgeReport edge_report<D>(const QuadraticMesh<D>&, const Proposal<D>&, const Column<double>&,             \
                                       const Column<double>&);                                                         \
    template Outcome<std::vector<Histogram>> run_histograms<D>(const Quadratic<D>&, const std::optional<EdgeLengths>&, \
                                                               const History<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
