module;
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.curving;
import camber.metric;
import camber.validity;
import :boundary;
import :curve_input;
import :field;
import :known_solution;
import :metric_source;
import :propose;

namespace camber {

CurveOptions edge_options(const ProposeOptions& options) {
    auto edge = static_cast<const CurveOptions&>(options);
    edge.aim = options.objective == Objective::energy   ? CurvingAim::energy
               : options.objective == Objective::length ? CurvingAim::length
                                                        : CurvingAim::accuracy;
    return edge;
}

namespace {

template <int D>
Outcome<CurveInput<D>> input_for(const CurvedFrom<D>& from, const ProposeOptions& options, const Execution& execution) {
    // The field of a surface alone is constant along its normals: its back mesh need not curve.
    const bool curves = options.back_mesh == BackMeshKind::curved && has_field(options.objective) &&
                        !is_surface_alone(from.mesh.linear);
    const double of_nodes = curves ? 0.18 : 0.5, of_planes = curves ? 0.5 : 1;
    auto input = curve_input(from, part_of(execution, 0, of_nodes));
    if (!input) return input;
    input = extended_in_planes(from, std::move(*input), part_of(execution, of_nodes, of_planes));
    if (!input || !curves) return input;
    return extended_input(from, std::move(*input), part_of(execution, 0.5, 1));
}

/// Volume edges start where the field has them.
template <int D>
Column<LagrangeNode<D>> starting_at(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                    Column<LagrangeNode<D>> nodes) {
    const bool starts_there = !nodes.empty();
    Buffer<LagrangeNode<D>> base = take(starts_there ? std::move(nodes) : input.base);
    for (std::size_t e = 0; e < base.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        if (input.kinds[e] != EdgeKind::volume)
            base[e] = input.base[e];
        else if (!starts_there)
            base[e] = {midpoint(mesh.linear.points[a], mesh.linear.points[b])};
    }
    return base;
}

}  // namespace

template <int D>
Outcome<CurvingStart<D>> begin_curving(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                       const ProposeOptions& options, const Around& around) {
    auto input = run_step(around, "extension", [&](const Execution& e) { return input_for(from, options, e); });
    if (!input) return fail(input.error());
    CurveOptions edges = edge_options(options);
    if (!has_field(options.objective)) return CurvingStart<D>{std::move(*input), {}, {}, edges};
    static_cast<EdgeAccuracyOptions&>(edges) = accuracy_for(origin_of(metric), edges);
    auto field = run_step(around, "metric", [&](const Execution& e) {
        return make_curving_field(from.mesh, *input, metric, edges.aim, e);
    });
    if (!field) return fail(field.error());
    // Searches begin at the nodes that a mesh was read with; what is found without one is found anew.
    if (from.nodes != NodesOf::input || edges.aim == CurvingAim::accuracy)
        input->base = starting_at(from.mesh, *input, std::move(field->nodes));
    return CurvingStart<D>{std::move(*input), std::move(field->back), std::move(field->straight), edges};
}

template <int D>
Outcome<CurveInput<D>> moved_input(const CurvedFrom<D>& from, CurveInput<D> input, const BackMesh<D>& field,
                                   const CurveOptions& edges, const PlacementOptions& options,
                                   const Execution& execution) {
    const bool is_placed = options.boundary_nodes != BoundaryNodeAim::projection;
    auto moved = placed_input(from, std::move(input), field, edges, options,
                              is_placed ? part_of(execution, 0, 0.8) : without_progress(execution));
    // Nodes in planes are where their edges are shortest already.
    if (!moved || options.boundary_nodes == BoundaryNodeAim::length) return moved;
    return slid_input(from, std::move(*moved), field, edges, is_placed ? part_of(execution, 0.8, 1) : execution);
}

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

/// Nodes by the boundary alone.
template <int D>
Outcome<Curved<D>> by_shape(const CurvedFrom<D>& from, CurvingStart<D>& start, const ProposeOptions& options,
                            const Execution& execution) {
    auto placed =
        placed_input(from, std::move(start.input), BackMesh<D>{}, start.edges, options, without_progress(execution));
    if (!placed) return fail(placed.error());
    start.input = std::move(*placed);
    const CurveInput<D>& input = start.input;
    auto done = shape(from.mesh, input.kinds, input.base, input.shells, ShapeOptions{}, execution);
    if (!done) return fail(done.error());
    return without_lengths(from.mesh, input.kinds, std::move(done->proposal));
}

/// These nodes, or a part of the way to them from the base where elements would be too flat: a search from nodes that
/// bend an element through itself ends there.
template <int D>
Outcome<Column<LagrangeNode<D>>> held_by_elements(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                                  const Column<LagrangeNode<D>>& nodes, const ProposeOptions& options,
                                                  const Execution& execution) {
    auto moves = map_each(without_progress(execution), nodes.size(),
                          [&](std::size_t e) { return nodes[e].point - input.base[e].point; });
    if (!moves) return fail(moves.error());
    const auto limited =
        limit_by_jacobian<D>(mesh, input.base.view(), input.shells, options.min_jacobian, *moves, execution);
    if (!limited) return fail(limited.error());
    Buffer<LagrangeNode<D>> held(input.base.begin(), input.base.end());
    for (std::size_t e = 0; e < held.size(); ++e) held[e].point += (*moves)[e];
    return Column<LagrangeNode<D>>(std::move(held));
}

/// The largest number of frames. A function is known exactly in each. Polynomials of fields are no better in the second
/// (docs/algorithms/solution-nodes.md), where only a mesh with curves of its own may have nodes that were blocked.
template <int D>
int frames_for(const CurvedFrom<D>& from, const GivenSolution<D>& given) {
    if (given.function) return SolutionNodesOptions{}.frames;
    return from.nodes == NodesOf::input ? 2 : 1;
}

/// Those of the volume by a solution: from the nodes of `shape`, or from where a mesh with curves of its own has them
/// if the error is less there. In rows of thin elements that follow a solution chords tell nothing of it.
template <int D>
Outcome<Curved<D>> by_solution(const CurvedFrom<D>& from, CurvingStart<D>& start, const GivenSolution<D>& given,
                               const ProposeOptions& options, ExpectedErrors& expected, const Execution& execution) {
    auto shaped = by_shape(from, start, options, part_of(execution, 0, 0.3));
    if (!shaped) return shaped;
    const CurveInput<D>& input = start.input;
    Proposal<D> proposal = std::move(shaped->proposal);
    auto begun = held_by_elements(from.mesh, input, proposal.mid_nodes, options, part_of(execution, 0.3, 0.35));
    if (!begun) return fail(begun.error());
    std::vector<Column<LagrangeNode<D>>> starts{std::move(*begun)};
    if (from.nodes == NodesOf::input) starts.push_back(input.base);
    const SolutionInElements<D> solution = [&](const QuadraticMesh<D>& curved, const Execution& e) {
        return known_solution(from.mesh, given, curved, e);
    };
    auto found = solution_nodes<D>(from.mesh, input.kinds, starts, input.shells, solution,
                                   {.frames = frames_for(from, given), .min_jacobian = options.min_jacobian},
                                   part_of(execution, 0.35, 1));
    if (!found) return fail(found.error());
    expected = {found->before, found->after, found->frames};
    Buffer<EdgeChange> changes = take(std::move(proposal.changes));
    for (std::size_t e = 0; e < changes.size(); ++e) {
        if (input.kinds[e] != EdgeKind::volume) continue;
        const auto& [a, b] = from.mesh.edges.vertices[e];
        changes[e] = found->nodes[e].point == midpoint(from.mesh.linear.points[a], from.mesh.linear.points[b])
                         ? EdgeChange::straight
                         : EdgeChange::optimised;
    }
    proposal.mid_nodes = std::move(found->nodes);
    proposal.changes = std::move(changes);
    Curved<D> curved = without_lengths(from.mesh, input.kinds, std::move(proposal));
    curved.statistics.drawn_back = found->drawn_back;
    return curved;
}

/// Those of the volume by the field.
template <int D>
Outcome<Curved<D>> by_field(const CurvedFrom<D>& from, CurvingStart<D>& start, const ProposeOptions& options,
                            const Execution& execution) {
    const CurveOptions& edges = start.edges;
    const double of_slides = options.boundary_nodes != BoundaryNodeAim::projection ? 0.5
                             : edges.aim != CurvingAim::accuracy                   ? 0
                             : edges.measured == MeasuredEdges::all                ? 0.05
                                                                                   : 0.26;
    auto moved =
        moved_input(from, std::move(start.input), *start.field, edges, options, part_of(execution, 0, of_slides));
    if (!moved) return fail(moved.error());
    start.input = std::move(*moved);
    const CurveInput<D>& input = start.input;
    auto curved =
        curve(from.mesh, input.kinds, input.base, input.shells, *start.field, edges, part_of(execution, of_slides, 1));
    if (!curved) return fail(curved.error());
    curved->statistics.drawn_back += input.drawn_back;
    curved->statistics.held_back += input.held_back;
    return curved;
}

}  // namespace

template <int D>
Outcome<ProposedCurves<D>> propose_curves(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                          const GivenSolution<D>& solution, const ProposeOptions& options,
                                          const Around& around) {
    const bool is_of_solution = options.objective == Objective::solution;
    if (!has_field(options.objective) && options.boundary_nodes == BoundaryNodeAim::length)
        return fail(ErrorKind::usage,
                    std::string("curve: the objective ") + std::string(word_of(options.objective)) +
                        " has no metric in which edges could be short",
                    {}, {}, "take another objective, or boundary_nodes accuracy");
    if (is_of_solution && solution.empty())
        return fail(ErrorKind::usage, "curve: the objective solution needs a solution, and there is none", {}, {},
                    "give --solution FILE or --solution EXPRESSION (\"solution\": {\"file\": …} in a config), or take "
                    "another objective");
    auto start = begin_curving(from, metric, options, around);
    if (!start) return fail(start.error());
    ExpectedErrors expected;
    auto curved = run_step(around, "curve", [&](const Execution& e) {
        return is_of_solution                 ? by_solution(from, *start, solution, options, expected, e)
               : has_field(options.objective) ? by_field(from, *start, options, e)
                                              : by_shape(from, *start, options, e);
    });
    if (!curved) return fail(curved.error());
    return ProposedCurves<D>{std::move(*curved),
                             std::move(start->input),
                             std::move(start->field),
                             std::move(start->straight_log_metrics),
                             start->edges,
                             is_of_solution ? std::optional(expected) : std::nullopt};
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template Outcome<CurvingStart<D>> begin_curving<D>(const CurvedFrom<D>&, const MetricSource<D>&,                \
                                                       const ProposeOptions&, const Around&);                       \
    template Outcome<CurveInput<D>> moved_input<D>(const CurvedFrom<D>&, CurveInput<D>, const BackMesh<D>&,         \
                                                   const CurveOptions&, const PlacementOptions&, const Execution&); \
    template Outcome<ProposedCurves<D>> propose_curves<D>(                                                          \
        const CurvedFrom<D>&, const MetricSource<D>&, const GivenSolution<D>&, const ProposeOptions&, const Around&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
