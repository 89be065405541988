// Curving, mesh checks and reinsertion, with boundary and repair guide.
module;
#include <optional>
#include <span>
#include <string>
#include <utility>
module camber.stages;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.validity;
import camber.crossing;
import camber.soundness;
import camber.surface;
import camber.operation;
import camber.adapt;
import camber.curving;
import camber.repair;

namespace camber {

namespace {

template <int D>
Outcome<Geometry<D>> surrogate_of(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Features<D>& features,
                                  std::span<const LagrangeNode<D>> nodes, const Execution& execution) {
    auto straight =
        build_surrogate(mesh, edges, features, SurrogateOptions{}, part_of(execution, 0, nodes.empty() ? 1 : 0.3));
    if (!straight) return fail(straight.error());
    if (nodes.empty()) return Geometry<D>(std::move(*straight));
    auto curved = build_curved_surrogate<D>(std::move(*straight), {mesh, edges, features, nodes}, StraightGeometry<D>{},
                                            SurrogateOptions{}, part_of(execution, 0.3, 1));
    if (!curved) return fail(curved.error());
    return Geometry<D>(std::move(curved->surrogate));
}

}  // namespace

template <int D>
Outcome<Boundary<D>> find_boundary(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                   const std::optional<Geometry<D>>& specified, const BoundaryOptions<D>& options,
                                   const Execution& execution, std::span<const LagrangeNode<D>> nodes) {
    auto features = find_features(mesh, edges, options.features, part_of(execution, 0, specified ? 1 : 0.3));
    if (!features) return fail(features.error());
    if (specified) return Boundary<D>{std::move(*features), options.required, *specified};
    auto result = surrogate_of(mesh, edges, *features, nodes, part_of(execution, 0.3, 1));
    if (!result) return fail(result.error());
    return Boundary<D>{std::move(*features), options.required, std::move(*result)};
}

namespace {

template <int D>
Outcome<RepairGuide<D>> by_models(const JudgedProposal<D>& judged, const std::optional<TargetNodes<D>>& target,
                                  const RepairOptions& options, const Execution& execution) {
    if (!needs_models(options.method)) return RepairGuide<D>{};
    if (judged.validation().all_valid() && !raises(options)) return RepairGuide<D>{};
    // Standalone surfaces are repaired with the geometry, not with models.
    if (is_standalone_surface(judged.mesh().linear)) return RepairGuide<D>{};
    if (target) {
        const Column<LagrangeNode<D>> nodes = target->curved.proposal.mid_nodes;
        return RepairGuide<D>{target->shells, [nodes](EdgeId e) { return nodes[e]; },
                              target->field
                                  ? edge_models(target->aim, judged.mesh(), nodes, target->shells, *target->field)
                                  : implied_edge_models(judged.mesh(), nodes, target->shells),
                              target->extended};
    }
    const auto around = shells(judged.mesh().edges, execution);
    if (!around) return fail(around.error());
    return guide_from_mesh(judged, *around, execution);
}

}  // namespace

template <int D>
Outcome<RepairGuide<D>> make_guide(const JudgedProposal<D>& judged, const std::optional<TargetNodes<D>>& target,
                                   const Boundary<D>* boundary, const RepairOptions& options,
                                   const Execution& execution) {
    auto guide = by_models(judged, target, options, execution);
    if (!guide || boundary == nullptr || judged.validation().all_valid()) return guide;
    const bool is_alone = is_standalone_surface(judged.mesh().linear);
    if (!is_alone && !boundary->geometry->prescribes_any()) return guide;
    const auto feet_of = is_alone ? feet_on_any<D> : feet_on<D>;
    auto feet = feet_of(boundary->geometry, boundary->features.edge_kinds, judged.mesh(), without_progress(execution));
    if (!feet) return fail(feet.error());
    guide->onto = std::move(*feet);
    if (is_alone) return guide;
    auto vertices = vertex_feet_on(boundary->geometry, boundary->features, judged.mesh(), without_progress(execution));
    if (!vertices) return fail(vertices.error());
    guide->vertices_onto = std::move(*vertices);
    return guide;
}

namespace {

template <int D>
Outcome<QuadraticMesh<D>> of_degree_2(const Mesh<D>& mesh, const Execution& execution) {
    if (mesh.degree == 1) return as_linear(mesh).and_then([&](const auto& m) { return elevate(m, execution); });
    return as_quadratic(mesh);
}

/// Finds overlaps in a mesh with known crossings. `prepare` may have to reverse elements or add facets. The prepared
/// mesh is then examined; its element numbers are the same.
template <int D>
Outcome<Overlaps<D>> checked_overlaps(const CheckedWalls<D>& walls, bool is_listed, const Soundness& soundness,
                                      const Execution& execution) {
    if (soundness[Defect::repeated_element].count > 0) return Overlaps<D>{};
    const bool is_prepared =
        !is_listed || (soundness[Defect::reversed_element].count == 0 && soundness[Defect::repeated_facet].count == 0 &&
                       soundness[Defect::missing_facet].count == 0);
    if (is_prepared) return find_overlaps(walls.mesh, walls.crossings, execution);
    const Execution quiet = without_progress(execution);
    const auto prepared = prepare(as_mesh(walls.mesh), quiet);
    if (!prepared) return Overlaps<D>{};
    const auto mesh = as_quadratic(prepared->mesh);
    if (!mesh) return fail(mesh.error());
    const auto crossings = find_crossings(*mesh, quiet);
    if (!crossings) return fail(crossings.error());
    return find_overlaps(*mesh, *crossings, quiet);
}

/// Returns nothing if the mesh has fatal defects, for example all facets at one position.
template <int D>
Outcome<std::optional<CheckedWalls<D>>> checked_walls(const QuadraticMesh<D>& mesh, const Soundness& soundness,
                                                      const Execution& execution) {
    if (refusal(soundness)) return std::nullopt;
    const bool is_listed = mesh.linear.facets.size() > 0 || mesh.linear.elements.size() == 0;
    const double of_listing = is_listed ? 0 : 0.7;
    CheckedWalls<D> walls{mesh, {}};
    if (!is_listed) {
        auto listed = prepare(as_mesh(mesh), part_of(execution, 0, of_listing));
        if (!listed) return std::nullopt;
        auto with_boundary = as_quadratic(std::move(listed->mesh));
        if (!with_boundary) return fail(with_boundary.error());
        walls.mesh = std::move(*with_boundary);
    }
    auto crossings = find_crossings(walls.mesh, part_of(execution, of_listing, 0.9));
    if (!crossings) return fail(crossings.error());
    walls.crossings = std::move(*crossings);
    auto overlaps = checked_overlaps(walls, is_listed, soundness, part_of(execution, 0.9, 1));
    if (!overlaps) return fail(overlaps.error());
    walls.overlaps = std::move(*overlaps);
    return walls;
}

}  // namespace

template <int D>
Outcome<MeshCheck<D>> check_mesh(const Mesh<D>& mesh, const MeshCheckOptions& options, const StepWrapper& around) {
    const double of_elevation = mesh.degree == 1 ? 0.7 : 0;
    MeshCheck<D> check;
    auto soundness = run_step(around, "examine", [&](const Execution& e) { return examine(mesh, options.examine, e); });
    if (!soundness) return fail(soundness.error());
    check.soundness = std::move(*soundness);
    auto validation = run_step(around, "validate", [&](const Execution& e) -> Outcome<Validation<D>> {
        auto quadratic = of_degree_2(mesh, part_of(e, 0, of_elevation));
        if (!quadratic) return fail(quadratic.error());
        check.mesh = std::move(*quadratic);
        return validate(check.mesh, options.min_scaled_jacobian, part_of(e, of_elevation, 1));
    });
    if (!validation) return fail(validation.error());
    check.validation = std::move(*validation);
    auto walls =
        run_step(around, "cross", [&](const Execution& e) { return checked_walls(check.mesh, check.soundness, e); });
    if (!walls) return fail(walls.error());
    check.walls = std::move(*walls);
    return check;
}

template <int D>
Outcome<ReinsertedNodes<D>> reinsert_nodes(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                           const ReinsertNodesOptions& options, const StepWrapper& around) {
    if (!has_field(options.curve.objective))
        return fail(ErrorKind::usage,
                    "reinsert: the objective " + std::string(word_of(options.curve.objective)) +
                        " applies to whole meshes, not to cavities",
                    {}, {}, "use the stage curve, or another objective");
    auto start = begin_curving(from, metric, options.curve, around);
    if (!start) return fail(start.error());
    return run_step(around, "reinsert", [&](const Execution& e) -> Outcome<ReinsertedNodes<D>> {
        const BackMesh<D>& field = *start->field;
        auto moved =
            moved_input(from, std::move(start->input), field, start->edges, options.curve, without_progress(e));
        if (!moved) return fail(moved.error());
        auto target =
            curve({from.mesh, moved->kinds, moved->shells}, moved->base, field, start->edges, part_of(e, 0, 0.2));
        if (!target) return fail(target.error());
        const Features<D>& features = from.boundary.features;
        const auto corners = corners_of(features);
        auto result = reinsert(from.mesh, target->proposal, {features.edge_kinds.view(), corners}, field,
                               options.cavities, part_of(e, 0.2, 1));
        if (!result) return fail(result.error());
        return ReinsertedNodes<D>{ProposedCurves<D>{std::move(*target), std::move(*moved), std::move(start->field),
                                                    std::move(start->straight_log_metrics), start->edges},
                                  std::move(*result)};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<Boundary<D>> find_boundary<D>(const LinearMesh<D>&, const EdgeSet<D>&,                        \
                                                   const std::optional<Geometry<D>>&, const BoundaryOptions<D>&,   \
                                                   const Execution&, std::span<const LagrangeNode<D>>);            \
    template Outcome<RepairGuide<D>> make_guide<D>(const JudgedProposal<D>&, const std::optional<TargetNodes<D>>&, \
                                                   const Boundary<D>*, const RepairOptions&, const Execution&);    \
    template Outcome<MeshCheck<D>> check_mesh<D>(const Mesh<D>&, const MeshCheckOptions&, const StepWrapper&);     \
    template Outcome<ReinsertedNodes<D>> reinsert_nodes<D>(const CurvedFrom<D>&, const MetricSource<D>&,           \
                                                           const ReinsertNodesOptions&, const StepWrapper&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
