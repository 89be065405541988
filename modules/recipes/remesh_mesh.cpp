module;
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.recipes;
import camber.core;
import camber.adapt;
import camber.bezier;
import camber.cavity;
import camber.curving;
import camber.metric;
import camber.operation;
import camber.soundness;
import camber.surface;
import :boundary;
import :field;
import :goal;
import :remesh_mesh;

namespace camber {

namespace {

template <int D>
std::vector<VertexId> corners_with(const Features<D>& features, const Column<VertexId>& of_curves) {
    std::vector<VertexId> corners(of_curves.begin(), of_curves.end());
    const auto of_features = corners_of(features);
    corners.insert(corners.end(), of_features.begin(), of_features.end());
    return corners;
}

/// But for the curves.
template <int D>
AdaptationGoal<D> goal_of(const Boundary<D>& boundary, RemeshingBy<D> by) {
    AdaptationGoal<D> goal{std::move(by.field), boundary.geometry};
    goal.max_elements = by.max_elements;
    goal.accuracy = static_cast<const EdgeAccuracyOptions&>(by.curving);
    if (by.curving.aim != CurvingAim::accuracy) goal.search.emplace(search_options(by.curving));
    return goal;
}

/// `begin(breaks, goal)` → Outcome<Adaptation>, with the curves that were found in the mesh, or those of the one
/// before.
template <int D>
Outcome<Remeshing<D>> begin(const Boundary<D>& boundary, RemeshingBy<D> by, Outcome<EmbeddedCurves<D>> found,
                            const auto& begin) {
    if (!found) return fail(found.error());
    const auto corners = corners_with(boundary.features, found->corners);
    const auto* const before = by.curves;
    AdaptationGoal<D> goal = goal_of(boundary, std::move(by));
    goal.curves = before != nullptr ? *before : std::move(*found);
    auto made = begin(BreaksOfMesh{boundary.features.edge_kinds.view(), corners}, goal);
    if (!made) return fail(made.error());
    return Remeshing<D>{std::move(*made), std::move(goal)};
}

}  // namespace

template <int D>
Outcome<Remeshing<D>> begin_remeshing(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Boundary<D>& boundary,
                                      RemeshingBy<D> by, const Execution& execution) {
    auto curves =
        find_embedded_curves(mesh, edges, boundary.features, boundary.geometry, {}, without_progress(execution));
    return begin(boundary, std::move(by), std::move(curves), [&](const BreaksOfMesh& breaks, const auto& goal) {
        return begin_adaptation(mesh, edges, breaks, goal, execution);
    });
}
template <int D>
Outcome<Remeshing<D>> begin_remeshing(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> nodes,
                                      const Boundary<D>& boundary, RemeshingBy<D> by, const Execution& execution) {
    auto curves = find_embedded_curves(mesh.linear, mesh.edges, boundary.features, boundary.geometry, nodes,
                                       without_progress(execution));
    return begin(boundary, std::move(by), std::move(curves), [&](const BreaksOfMesh& breaks, const auto& goal) {
        return begin_adaptation(mesh, breaks, goal, execution);
    });
}

namespace {

/// A mesh of either degree.
template <int D>
struct Given {
    const LinearMesh<D>& linear;
    const EdgeSet<D>& edges;
    std::span<const LagrangeNode<D>> nodes;  ///< by which the boundary's own curves are told
};
template <int D>
struct Made {
    FinishedMesh<D> mesh;
    Boundary<D> boundary;
    EmbeddedCurves<D> curves;
    ToMetricStatistics statistics;
};

/// The steps behind `prepare`; `field(execution)` and `begin(boundary, by, execution)` are those of the degree.
template <int D>
Outcome<Made<D>> remeshed(const Given<D>& given, const MeshGoal<D>& goal, const RemeshMeshOptions& options,
                          const Around& around, const auto& field, const auto& begin) {
    const auto boundary = run_step(around, "surface", [&](const Execution& e) {
        return find_boundary(given.linear, given.edges, goal.geometry, goal.boundary, e, given.nodes);
    });
    if (!boundary) return fail(boundary.error());
    auto made_field = run_step(around, "metric", field);
    if (!made_field) return fail(made_field.error());
    auto begun = run_step(around, "topology", [&](const Execution& e) {
        RemeshingBy<D> by{std::move(*made_field), options.curving};
        static_cast<EdgeAccuracyOptions&>(by.curving) = accuracy_for(origin_of(goal.metric), by.curving);
        return begin(*boundary, std::move(by), e);
    });
    if (!begun) return fail(begun.error());
    auto brought = bring_to_metric(std::move(begun->mesh), begun->goal, options.passes, around);
    if (!brought) return fail(brought.error());
    auto end = run_step(around, "finish", [&](const Execution& e) { return finished(brought->state, e); });
    if (!end) return fail(end.error());
    brought->state = {};
    auto now = run_step(around, "features", [&](const Execution& e) {
        return find_boundary<D>(end->compact.mesh, end->compact.edges, boundary->geometry,
                                {listed_breaks<D>, boundary->required}, e);
    });
    if (!now) return fail(now.error());
    return Made<D>{std::move(*end), std::move(*now), std::move(begun->goal.curves), std::move(brought->statistics)};
}

/// The boundary's own curves count where nothing else is prescribed.
template <int D>
std::span<const LagrangeNode<D>> telling_nodes(const QuadraticMesh<D>& mesh, const MeshGoal<D>& goal) {
    const bool prescribes = goal.geometry && (*goal.geometry)->prescribes_any();
    return prescribes ? std::span<const LagrangeNode<D>>() : mesh.mid_nodes.view();
}

template <class Mesh, int D>
RemeshedMesh<Mesh> named(Mesh mesh, Made<D> made, std::vector<std::string> notices) {
    return {std::move(mesh),        std::move(made.mesh.log_metrics), std::move(made.boundary),
            std::move(made.curves), std::move(made.statistics),       std::move(notices)};
}

}  // namespace

template <int D>
Outcome<RemeshedMesh<LinearMesh<D>>> remesh_mesh(LinearMesh<D> given, const MeshGoal<D>& goal,
                                                 const RemeshMeshOptions& options, const Around& around) {
    auto sound = run_step(around, "prepare", [&](const Execution& e) { return prepare(std::move(given), e); });
    if (!sound) return fail(sound.error());
    const LinearMesh<D>& mesh = sound->mesh;
    const auto edges = run_step(around, "edges", [&](const Execution& e) { return unique_edges(mesh, e); });
    if (!edges) return fail(edges.error());
    auto made = remeshed<D>(
        {mesh, *edges, {}}, goal, options, around, [&](const Execution& e) { return make_field(mesh, goal.metric, e); },
        [&](const auto& boundary, auto by, const auto& e) {
            return begin_remeshing<D>(mesh, *edges, boundary, std::move(by), e);
        });
    if (!made) return fail(made.error());
    LinearMesh<D> end = std::move(made->mesh.compact.mesh);
    return named(std::move(end), std::move(*made), std::move(sound->notices));
}

template <int D>
Outcome<RemeshedMesh<QuadraticMesh<D>>> remesh_mesh(QuadraticMesh<D> given, const MeshGoal<D>& goal,
                                                    const RemeshMeshOptions& options, const Around& around) {
    auto sound = run_step(around, "prepare", [&](const Execution& e) { return prepare(std::move(given), e); });
    if (!sound) return fail(sound.error());
    const QuadraticMesh<D>& mesh = sound->mesh;
    const auto nodes = telling_nodes(mesh, goal);
    auto made = remeshed<D>(
        {mesh.linear, mesh.edges, nodes}, goal, options, around,
        [&](const Execution& e) { return make_field(mesh, goal.metric, e); },
        [&](const auto& boundary, auto by, const auto& e) {
            return begin_remeshing<D>(mesh, nodes, boundary, std::move(by), e);
        });
    if (!made) return fail(made.error());
    auto& compact = made->mesh.compact;
    QuadraticMesh<D> end{std::move(compact.mesh), std::move(compact.edges), std::move(compact.nodes)};
    return named(std::move(end), std::move(*made), std::move(sound->notices));
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<Remeshing<D>> begin_remeshing<D>(const LinearMesh<D>&, const EdgeSet<D>&, const Boundary<D>&, \
                                                      RemeshingBy<D>, const Execution&);                           \
    template Outcome<Remeshing<D>> begin_remeshing<D>(const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>,   \
                                                      const Boundary<D>&, RemeshingBy<D>, const Execution&);       \
    template Outcome<RemeshedMesh<LinearMesh<D>>> remesh_mesh<D>(LinearMesh<D>, const MeshGoal<D>&,                \
                                                                 const RemeshMeshOptions&, const Around&);         \
    template Outcome<RemeshedMesh<QuadraticMesh<D>>> remesh_mesh<D>(QuadraticMesh<D>, const MeshGoal<D>&,          \
                                                                    const RemeshMeshOptions&, const Around&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
