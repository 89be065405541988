// Inputs and fields of curving, and proposed curves.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <ranges>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.stages;
import camber.core;
import camber.bezier;
import camber.extension;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.surface;
import camber.curving;
import camber.repair;

namespace camber {

namespace {

template <int D>
Outcome<Buffer<LagrangeNode<D>>> on_geometry(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary,
                                             const EmbeddedCurves<D>& curves, const Execution& execution) {
    const QuadraticMesh<D> free = boundary.required == RequiredBoundary::keep ? mesh : without_required(mesh);
    auto nodes = boundary_nodes(free, boundary.features, boundary.geometry, part_of(execution, 0, 0.9));
    if (!nodes) return nodes;
    return nodes_on_curves(free, std::move(*nodes), curves, boundary.geometry, part_of(execution, 0.9, 1));
}

template <int D>
Outcome<CurveInput<D>> input_of(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary,
                                const EmbeddedCurves<D>& curves, Buffer<LagrangeNode<D>> nodes, std::size_t preserved,
                                const Execution& execution) {
    auto around = elements_of_edges(mesh, execution);
    if (!around) return fail(around.error());
    return CurveInput<D>{
        kinds_with_required_fixed(mesh, kinds_with_curves(boundary.features.edge_kinds, curves), boundary.required),
        Column<LagrangeNode<D>>(std::move(nodes)), std::move(*around), preserved};
}

template <int D>
Outcome<CurveInput<D>> input_of_elevated(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary,
                                         const EmbeddedCurves<D>& curves, const Execution& execution) {
    auto nodes = on_geometry(mesh, boundary, curves, part_of(execution, 0, 0.33));
    if (!nodes) return fail(nodes.error());
    return input_of(mesh, boundary, curves, std::move(*nodes), 0, part_of(execution, 0.33, 1));
}

template <int D>
bool is_prescribed(const LinearMesh<D>& mesh, const Boundary<D>& boundary, std::span<const FacetId> facets) {
    return std::ranges::any_of(facets,
                               [&](FacetId f) { return boundary.geometry->prescribes(mesh.facets.references[f]); });
}

template <int D>
bool is_on_geometry(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary, std::span<const FacetId> facets,
                    std::size_t e) {
    constexpr double near = 1e-6;  // distance that counts as none, as share of the chord
    const auto& [a, b] = mesh.edges.vertices[e];
    const double chord = distance(mesh.linear.points[a], mesh.linear.points[b]);
    const auto sites = facet_sites<D>(mesh.linear, facets);
    return boundary.geometry->distance_at_facets(sites, mesh.mid_nodes[e].point) <= near * chord;
}

/// Preserves the boundary nodes of the mesh, except those off their prescribed surfaces.
template <int D>
Outcome<CurveInput<D>> input_of_read(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary,
                                     const EmbeddedCurves<D>& curves, const Execution& execution) {
    auto nodes = on_geometry(mesh, boundary, curves, part_of(execution, 0, 0.33));
    if (!nodes) return fail(nodes.error());
    const auto around = facet_shells(mesh.edges, without_progress(execution));
    if (!around) return fail(around.error());
    std::size_t preserved = 0;
    for (std::size_t e = 0; e < nodes->size(); ++e) {
        if (boundary.features.edge_kinds[e] == EdgeKind::volume) continue;
        const auto facets = (*around)[e];
        const bool is_on_prescribed = is_prescribed<D>(mesh.linear, boundary, facets);
        if (is_on_prescribed && !is_on_geometry(mesh, boundary, facets, e)) continue;
        (*nodes)[e] = mesh.mid_nodes[e];
        preserved += is_on_prescribed ? 0 : 1;
    }
    return input_of(mesh, boundary, curves, std::move(*nodes), preserved, part_of(execution, 0.33, 1));
}

}  // namespace

template <int D>
Outcome<CurveInput<D>> curve_input(const CurvedFrom<D>& from, const Execution& execution) {
    const bool is_read = from.nodes == NodesOf::input;
    const auto curves = find_embedded_curves<D>(
        from.mesh.linear, from.mesh.edges, from.boundary.features, from.boundary.geometry,
        is_read ? from.mesh.mid_nodes.view() : std::span<const LagrangeNode<D>>{}, without_progress(execution));
    if (!curves) return fail(curves.error());
    return is_read ? input_of_read(from.mesh, from.boundary, *curves, execution)
                   : input_of_elevated(from.mesh, from.boundary, *curves, execution);
}

namespace {

template <int D>
Outcome<CurveInput<D>> slid_input(const CurvedFrom<D>& from, CurveInput<D> input, const BackMesh<D>& field,
                                  const CurveOptions& options, const Execution& execution) {
    if (options.aim != CurvingAim::accuracy || from.nodes == NodesOf::input) return input;
    auto shifts = accurate_offsets({from.mesh, input.kinds, input.shells}, EdgeKind::surface, field, options,
                                   part_of(execution, 0, 0.05));
    if (!shifts) return fail(shifts.error());
    const QuadraticMesh<D> mesh =
        from.boundary.required == RequiredBoundary::keep ? from.mesh : without_required(from.mesh);
    const Column<LagrangeNode<D>>& present = input.base;
    auto nodes = slid_nodes<D>(mesh, present, *shifts, from.boundary.features, from.boundary.geometry,
                               part_of(execution, 0.05, 0.78));
    if (!nodes) return fail(nodes.error());
    Buffer<Vec<D>>& slides = *shifts;
    for (std::size_t e = 0; e < slides.size(); ++e) slides[e] = (*nodes)[e].point - present[e].point;
    if (options.metric_kind == MetricKind::natural) {
        const auto limited_by_loss =
            limit_smooth_loss<D>(from.mesh, input.shells, options.smooth_loss, slides, part_of(execution, 0.78, 0.82));
        if (!limited_by_loss) return fail(limited_by_loss.error());
        input.loss_limited += *limited_by_loss;
    }
    // Shifts of boundary nodes must not degrade elements, although volume nodes will follow them later.
    auto limited_count = limit_by_jacobian<D>(from.mesh, present.view(), input.shells, slide_bound(options), slides,
                                              part_of(execution, 0.82, 1));
    if (!limited_count) return fail(limited_count.error());
    input.relaxed += *limited_count;
    for (std::size_t e = 0; e < slides.size(); ++e) (*nodes)[e].point = present[e].point + slides[e];
    input.base = std::move(*nodes);
    return input;
}

template <int D>
Outcome<Column<EdgeKind>> may_move(const CurvedFrom<D>& from, const Column<EdgeKind>& kinds,
                                   const Execution& execution) {
    if (from.nodes != NodesOf::input) return kinds;
    const auto around = facet_shells(from.mesh.edges, without_progress(execution));
    if (!around) return fail(around.error());
    Buffer<EdgeKind> updated(kinds.begin(), kinds.end());
    for (std::size_t e = 0; e < updated.size(); ++e)
        if (!is_prescribed<D>(from.mesh.linear, from.boundary, (*around)[e])) updated[e] = EdgeKind::fixed;
    return Column<EdgeKind>(std::move(updated));
}

/// Places boundary nodes in the field; for curved input, only those that `curve_input` puts onto prescribed surfaces.
template <int D>
Outcome<CurveInput<D>> placed_input(const CurvedFrom<D>& from, CurveInput<D> input, const BackMesh<D>& field,
                                    const CurveOptions& edges, const PlacementOptions& options,
                                    const Execution& execution) {
    if (options.boundary_nodes == BoundaryNodeAim::projection) return input;
    return guarded([&]() -> Outcome<CurveInput<D>> {
        auto kinds = may_move(from, input.kinds, execution);
        if (!kinds) return fail(kinds.error());
        const auto placed =
            placed_nodes({from.mesh, *kinds, input.shells}, input.base,
                         {from.boundary.features, from.boundary.geometry}, field, {edges, options}, execution);
        if (!placed) return fail(placed.error());
        Buffer<LagrangeNode<D>> nodes(placed->size());
        for (std::size_t e = 0; e < nodes.size(); ++e) nodes[e] = (*placed)[e].node;
        input.base = std::move(nodes);
        input.placed = placement_statistics<D>(*placed);
        return std::move(input);
    });
}

template <int D>
bool is_straight(const QuadraticMesh<D>& mesh, const CurveInput<D>& input) {
    const auto stays = [&](std::size_t e) {
        if (input.kinds[e] == EdgeKind::volume) return true;
        const auto& [a, b] = mesh.edges.vertices[e];
        return input.base[e].point == midpoint(mesh.linear.points[a], mesh.linear.points[b]);
    };
    return std::ranges::all_of(std::views::iota(std::size_t{0}, input.base.size()), stays);
}

template <int D>
Column<EdgeKind> kinds_with_preserved(const QuadraticMesh<D>& mesh, const CurveInput<D>& input) {
    Buffer<EdgeKind> kinds(input.kinds.begin(), input.kinds.end());
    for (std::size_t e = 0; e < kinds.size(); ++e)
        if (kinds[e] != EdgeKind::volume && input.base[e] == mesh.mid_nodes[e]) kinds[e] = EdgeKind::fixed;
    return Column<EdgeKind>(std::move(kinds));
}

/// Extends boundary displacements over faces (extend_over_faces). Nodes without geometry are treated like volume nodes
/// (kinds_with_following).
template <int D>
Outcome<CurveInput<D>> extended_over_faces(const CurvedFrom<D>& from, CurveInput<D> input, const Execution& execution) {
    if (is_straight(from.mesh, input)) return input;
    const bool is_read = from.nodes == NodesOf::input;
    const auto& [features, required, geometry] = from.boundary;
    auto nodes = extend_over_faces(from.mesh, is_read ? kinds_with_preserved(from.mesh, input) : input.kinds,
                                   input.base, features, geometry, part_of(execution, 0, 0.5));
    if (!nodes) return fail(nodes.error());
    input.base = std::move(*nodes);
    if (is_read || is_standalone_surface(from.mesh.linear)) return input;
    const auto kinds = kinds_with_following(from.mesh, input.kinds, features, geometry, without_progress(execution));
    if (!kinds) return fail(kinds.error());
    if (*kinds == input.kinds) return input;
    const auto extended = extend_boundary(from.mesh, *kinds, input.base, input.shells, {}, part_of(execution, 0.5, 1));
    if (!extended) return fail(extended.error());
    Buffer<LagrangeNode<D>> following = take(std::move(input.base));
    for (std::size_t e = 0; e < following.size(); ++e)
        if ((*kinds)[e] != input.kinds[e]) following[e] = extended->nodes[e];
    input.base = std::move(following);
    return input;
}

template <int D>
Outcome<CurveInput<D>> extended_input(const CurvedFrom<D>& from, CurveInput<D> input, const Execution& execution) {
    if (is_straight(from.mesh, input)) return input;
    auto extended = extend_boundary(from.mesh, input.kinds, input.base, input.shells, {}, execution);
    if (!extended) return fail(extended.error());
    input.extended = std::move(extended->nodes);
    return input;
}

}  // namespace

template <int D>
Outcome<BackMesh<D>> make_field(const LinearMesh<D>& mesh, const MetricSource<D>& metric, const Execution& execution) {
    if (const auto* field = std::get_if<MetricField<D>>(&metric)) return field->make(execution);
    const auto& source = std::get<MetricAtVertices<D>>(metric);
    const auto around = balls(mesh, part_of(execution, 0, 0.1));
    if (!around) return fail(around.error());
    Column<LogMetric<D>> natural;
    if (source.of_natural) {
        auto result = natural_log_metrics(mesh, *around, part_of(execution, 0.1, 0.5));
        if (!result) return fail(result.error());
        natural = std::move(*result);
    }
    auto logs = source.make(natural, part_of(execution, 0.5, 0.65));
    if (!logs) return fail(logs.error());
    return make_back_mesh(mesh, *around, std::move(*logs), part_of(execution, 0.65, 1));
}

template <int D>
Outcome<BackMesh<D>> make_field(const QuadraticMesh<D>& mesh, const MetricSource<D>& metric,
                                const Execution& execution) {
    if (const auto* field = std::get_if<MetricField<D>>(&metric)) return field->make(execution);
    const auto& source = std::get<MetricAtVertices<D>>(metric);
    const auto around = balls(mesh.linear, part_of(execution, 0, 0.1));
    if (!around) return fail(around.error());
    Column<LogMetric<D>> natural;
    if (source.of_natural) {
        auto result = curved_natural_log_metrics(mesh, *around, part_of(execution, 0.1, 0.5));
        if (!result) return fail(result.error());
        natural = std::move(result->curved);
    }
    auto logs = source.make(natural, part_of(execution, 0.5, 0.65));
    if (!logs) return fail(logs.error());
    auto nodal = framed_logs(mesh.edges, std::move(*logs), part_of(execution, 0.65, 0.7));
    if (!nodal) return fail(nodal.error());
    return make_nodal_back_mesh(mesh, *around, std::move(*nodal), part_of(execution, 0.7, 1));
}

namespace {

template <int D>
struct BothMetrics {
    Column<LogMetric<D>> curved, straight;
};
template <int D>
Outcome<BothMetrics<D>> both_metrics(const MetricAtVertices<D>& source, const QuadraticMesh<D>& bent,
                                     const Incidence<ElementId>& around, const Execution& execution) {
    Column<LogMetric<D>> of_curved, of_straight;
    if (source.of_natural) {
        auto result = curved_natural_log_metrics(bent, around, part_of(execution, 0, 0.85));
        if (!result) return fail(result.error());
        of_curved = std::move(result->curved);
        of_straight = std::move(result->straight);
    }
    auto curved = source.make(of_curved, part_of(execution, source.of_natural ? 0.85 : 0, 1));
    if (!curved) return fail(curved.error());
    if (!source.of_natural) return BothMetrics<D>{*curved, *curved};
    auto straight = source.make(of_straight, without_progress(execution));
    if (!straight) return fail(straight.error());
    return BothMetrics<D>{std::move(*curved), std::move(*straight)};
}

template <int D>
struct CurvingField {
    BackMesh<D> back;
    std::optional<Column<LogMetric<D>>> straight;
    Column<LagrangeNode<D>> nodes;  ///< empty: chords
};

template <int D>
Outcome<CurvingField<D>> curved_field(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                      const MetricAtVertices<D>& source, CurvingAim aim, const Execution& execution) {
    // Shares of time were measured with the natural metric, on shells with layers of 1 and 5 million elements.
    const auto around = balls(mesh.linear, part_of(execution, 0, 0.05));
    if (!around) return fail(around.error());
    QuadraticMesh<D> bent = mesh;
    bent.mid_nodes = input.extended;
    auto metrics = both_metrics<D>(source, bent, *around, part_of(execution, 0.05, 0.37));
    if (!metrics) return fail(metrics.error());
    auto starts = noticeable_nodes(mesh, input.extended.view(), metrics->curved, part_of(execution, 0.37, 0.44));
    if (!starts) return fail(starts.error());
    Column<LagrangeNode<D>> nodes(std::move(*starts));
    auto of_back_mesh = back_mesh_nodes(mesh, nodes.view(), input.shells, part_of(execution, 0.44, 0.64));
    if (!of_back_mesh) return fail(of_back_mesh.error());
    bent.mid_nodes = std::move(*of_back_mesh);
    auto back =
        make_curved_back_mesh(std::move(bent), *around, std::move(metrics->curved), part_of(execution, 0.64, 1),
                              aim == CurvingAim::accuracy ? StoredGradients::sampled : StoredGradients::recovered);
    if (!back) return fail(back.error());
    // With the aim `accuracy`, computed offsets are added to the extended nodes and not to those of the back mesh. The
    // extended nodes also follow boundaries with small sagitta, which matters for smooth functions.
    if (aim == CurvingAim::accuracy) nodes = input.extended;
    return CurvingField<D>{std::move(*back), std::move(metrics->straight), std::move(nodes)};
}

/// Builds the metric field. It uses the straight mesh if the input has no extension.
template <int D>
Outcome<CurvingField<D>> make_curving_field(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                            const MetricSource<D>& metric, CurvingAim aim, const Execution& execution) {
    const auto* const at_vertices = std::get_if<MetricAtVertices<D>>(&metric);
    if (at_vertices != nullptr && !input.extended.empty())
        return curved_field(mesh, input, *at_vertices, aim, execution);
    auto back = make_field(mesh.linear, metric, execution);
    if (!back) return fail(back.error());
    return CurvingField<D>{std::move(*back), {}, {}};
}

}  // namespace

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
    // The field of a standalone surface mesh is constant along its normals, so its back mesh need not curve.
    const bool curves = options.back_mesh == BackMeshKind::curved && has_field(options.objective) &&
                        !is_standalone_surface(from.mesh.linear);
    const double of_nodes = curves ? 0.3 : 0.8, of_faces = curves ? 0.4 : 1;
    auto input = curve_input(from, part_of(execution, 0, of_nodes));
    if (!input) return input;
    input = extended_over_faces(from, std::move(*input), part_of(execution, of_nodes, of_faces));
    if (!input || !curves) return input;
    return extended_input(from, std::move(*input), part_of(execution, of_faces, 1));
}

template <int D>
Column<LagrangeNode<D>> starting_at(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                    Column<LagrangeNode<D>> nodes) {
    const bool starts_at_nodes = !nodes.empty();
    Buffer<LagrangeNode<D>> base = take(starts_at_nodes ? std::move(nodes) : input.base);
    for (std::size_t e = 0; e < base.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        if (input.kinds[e] != EdgeKind::volume)
            base[e] = input.base[e];
        else if (!starts_at_nodes)
            base[e] = {midpoint(mesh.linear.points[a], mesh.linear.points[b])};
    }
    return base;
}

}  // namespace

template <int D>
Outcome<CurvingStart<D>> begin_curving(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                       const ProposeOptions& options, const StepWrapper& around) {
    auto input = run_step(around, "extension", [&](const Execution& e) { return input_for(from, options, e); });
    if (!input) return fail(input.error());
    CurveOptions edges = edge_options(options);
    if (!has_field(options.objective)) return CurvingStart<D>{std::move(*input), {}, {}, edges};
    static_cast<EdgeAccuracyOptions&>(edges) = accuracy_for(origin_of(metric), edges);
    auto field = run_step(around, "metric", [&](const Execution& e) {
        return make_curving_field(from.mesh, *input, metric, edges.aim, e);
    });
    if (!field) return fail(field.error());
    // For curved input, searches start at its nodes; accuracy needs no start.
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
    // With the aim `length`, edges in planes already have minimum length.
    if (!moved || options.boundary_nodes == BoundaryNodeAim::length) return moved;
    return slid_input(from, std::move(*moved), field, edges, is_placed ? part_of(execution, 0.8, 1) : execution);
}

namespace {

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

/// Relaxes nodes towards `base` in elements that are too flat, because searches that start at folded elements end
/// there.
template <int D>
Outcome<Column<LagrangeNode<D>>> limited_by_elements(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                                     const Column<LagrangeNode<D>>& nodes,
                                                     const ProposeOptions& options, const Execution& execution) {
    auto moves = map_each(without_progress(execution), nodes.size(),
                          [&](std::size_t e) { return nodes[e].point - input.base[e].point; });
    if (!moves) return fail(moves.error());
    const auto limited =
        limit_by_jacobian<D>(mesh, input.base.view(), input.shells, options.min_jacobian, *moves, execution);
    if (!limited) return fail(limited.error());
    Buffer<LagrangeNode<D>> updated(input.base.begin(), input.base.end());
    for (std::size_t e = 0; e < updated.size(); ++e) updated[e].point += (*moves)[e];
    return Column<LagrangeNode<D>>(std::move(updated));
}

/// Number of evaluations of the solution in moved elements. Functions are always exact. Polynomials of fields improve
/// in a second evaluation only for curved input, whose nodes may have been blocked (docs/algorithms/solution-nodes.md).
template <int D>
int frames_for(const CurvedFrom<D>& from, const SolutionInput<D>& specified) {
    if (specified.function) return SolutionNodesOptions{}.frames;
    return from.nodes == NodesOf::input ? 2 : 1;
}

/// Places volume nodes by a solution. The search starts from the nodes of `shape`, or of curved input if their error is
/// smaller. It does not start from chords, which ignore the solution in rows of thin elements.
template <int D>
Outcome<Curved<D>> by_solution(const CurvedFrom<D>& from, CurvingStart<D>& start, const SolutionInput<D>& specified,
                               const ProposeOptions& options, ExpectedErrors& expected, const Execution& execution) {
    auto shaped = by_shape(from, start, options, part_of(execution, 0, 0.3));
    if (!shaped) return shaped;
    const CurveInput<D>& input = start.input;
    Proposal<D> proposal = std::move(shaped->proposal);
    auto limited_nodes =
        limited_by_elements(from.mesh, input, proposal.mid_nodes, options, part_of(execution, 0.3, 0.35));
    if (!limited_nodes) return fail(limited_nodes.error());
    std::vector<Column<LagrangeNode<D>>> starts{std::move(*limited_nodes)};
    if (from.nodes == NodesOf::input) starts.push_back(input.base);
    const SolutionInElements<D> solution = [&](const QuadraticMesh<D>& curved, const Execution& e) {
        return known_solution(from.mesh, specified, curved, e);
    };
    auto found = solution_nodes<D>({from.mesh, input.kinds, input.shells}, starts, solution,
                                   {.frames = frames_for(from, specified), .min_jacobian = options.min_jacobian},
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
    curved.statistics.relaxed = found->relaxed;
    return curved;
}

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
    auto curved = curve({from.mesh, input.kinds, input.shells}, input.base, *start.field, edges,
                        part_of(execution, of_slides, 1));
    if (!curved) return fail(curved.error());
    curved->statistics.relaxed += input.relaxed;
    curved->statistics.loss_limited += input.loss_limited;
    return curved;
}

}  // namespace

template <int D>
Outcome<ProposedCurves<D>> propose_curves(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                          const SolutionInput<D>& solution, const ProposeOptions& options,
                                          const StepWrapper& around) {
    const bool is_of_solution = options.objective == Objective::solution;
    if (!has_field(options.objective) && options.boundary_nodes == BoundaryNodeAim::length)
        return fail(ErrorKind::usage,
                    std::string("curve: the objective ") + std::string(word_of(options.objective)) +
                        " has no metric, which boundary_nodes length needs",
                    {}, {}, "use another objective, or boundary_nodes accuracy");
    if (is_of_solution && solution.empty())
        return fail(ErrorKind::usage, "curve: the objective solution needs a solution", {}, {},
                    "give --solution FILE or --solution EXPRESSION (\"solution\": {\"file\": …} in a config), or use "
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
    template Outcome<CurveInput<D>> curve_input<D>(const CurvedFrom<D>&, const Execution&);                         \
    template Outcome<BackMesh<D>> make_field<D>(const LinearMesh<D>&, const MetricSource<D>&, const Execution&);    \
    template Outcome<BackMesh<D>> make_field<D>(const QuadraticMesh<D>&, const MetricSource<D>&, const Execution&); \
    template Outcome<CurvingStart<D>> begin_curving<D>(const CurvedFrom<D>&, const MetricSource<D>&,                \
                                                       const ProposeOptions&, const StepWrapper&);                  \
    template Outcome<CurveInput<D>> moved_input<D>(const CurvedFrom<D>&, CurveInput<D>, const BackMesh<D>&,         \
                                                   const CurveOptions&, const PlacementOptions&, const Execution&); \
    template Outcome<ProposedCurves<D>> propose_curves<D>(const CurvedFrom<D>&, const MetricSource<D>&,             \
                                                          const SolutionInput<D>&, const ProposeOptions&,           \
                                                          const StepWrapper&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
