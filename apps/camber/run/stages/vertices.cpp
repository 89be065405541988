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
import :runner;
import :stages;
import :state;
import :steps;

namespace camber::run {

namespace {

/// The nodes of edges, each moved by half of what its ends are, so that edges keep their shapes; of a chord its middle.
template <int D>
Outcome<Column<LagrangeNode<D>>> nodes_along(const QuadraticMesh<D>& mesh, const Column<Vec<D>>& points,
                                             const Execution& execution) {
    auto nodes = map_each(execution, mesh.edges.size(), [&](std::size_t e) -> LagrangeNode<D> {
        const auto& [a, b] = mesh.edges.vertices[e];
        const Column<Vec<D>>& before = mesh.linear.points;
        const LagrangeNode<D>& node = mesh.mid_nodes[e];
        if (points[a] == before[a] && points[b] == before[b]) return node;
        const Vec<D> middle = midpoint(points[a], points[b]), was = midpoint(before[a], before[b]);
        return node.point == was ? LagrangeNode<D>{middle} : LagrangeNode<D>{middle + (node.point - was)};
    });
    if (!nodes) return fail(nodes.error());
    return Column<LagrangeNode<D>>(std::move(*nodes));
}

template <int D>
Outcome<CadMovesReport> move(LinearMesh<D>& mesh, const config::Cad& cad, const CadModel& model,
                             const Execution& execution) {
    const auto edges = unique_edges(mesh, without_progress(execution));
    if (!edges) return fail(edges.error());
    auto moved = moved_vertices(cad, model, mesh, *edges, execution);
    if (!moved) return fail(moved.error());
    mesh.points = std::move(moved->points);
    return moved->report;
}
template <int D>
Outcome<CadMovesReport> move(Quadratic<D>& at, const config::Cad& cad, const CadModel& model,
                             const Execution& execution) {
    QuadraticMesh<D>& mesh = at.mesh;
    auto moved = moved_vertices(cad, model, mesh.linear, mesh.edges, execution);
    if (!moved) return fail(moved.error());
    auto nodes = nodes_along(mesh, moved->points, without_progress(execution));
    if (!nodes) return fail(nodes.error());
    mesh.linear.points = std::move(moved->points);
    mesh.mid_nodes = std::move(*nodes);
    return moved->report;
}
template <int D>
Outcome<CadMovesReport> move(Changing<D>&, const config::Cad&, const CadModel&, const Execution&) {
    return fail(ErrorKind::internal, "a run begins with no pass");
}

}  // namespace

template <int D>
Outcome<Done> move_vertices(Runner<D>& run) {
    const auto* const cad = std::get_if<config::Cad>(&run.config.geometry);
    if (!cad || !run.geometry.cad || cad->vertices == CadVertices::keep) return Done{};
    auto report = run.step("vertices", [&](const Execution& e) {
        return std::visit([&](auto& mesh) { return move<D>(mesh, *cad, *run.geometry.cad, e); }, run.state.mesh);
    });
    if (!report) return fail(report.error());
    run.state.cad_moves = *report;
    return Done{};
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> move_vertices<D>(Runner<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
