module;
#include <array>
#include <cstddef>
#include <span>
module camber.curving;
import :by_element;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;

namespace camber {

namespace {

/// Displacements below this, in the metric, count as none: they turn axes by less than is known of them.
constexpr double negligible = 0.01;
/// Scaled Jacobian below which an element of the back mesh counts as folded.
constexpr double least_back_jacobian = 0.1;

}  // namespace

template <int D>
Outcome<Buffer<LagrangeNode<D>>> carried_nodes(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> extended,
                                               const Column<LogMetric<D>>& log_metrics,
                                               const Incidence<ElementId>& shells, const Execution& execution) {
    auto middles = map_each(execution, mesh.edges.size(), [&](std::size_t e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        return LagrangeNode<D>{midpoint(mesh.linear.points[a], mesh.linear.points[b])};
    });
    if (!middles) return middles;
    auto displacements = map_each(execution, mesh.edges.size(), [&](std::size_t e) -> Vec<D> {
        const Vec<D> u = extended[e].point - (*middles)[e].point;
        if (u == Vec<D>{}) return u;
        for (const VertexId v : mesh.edges.vertices[e])
            if (!(SpectralMetric<D>(log_metrics[v]).length_squared(u) < negligible * negligible)) return u;
        return {};
    });
    if (!displacements) return fail(displacements.error());
    const auto lessened = lessen_by_element<D>(mesh, *middles, shells, least_back_jacobian, *displacements, execution);
    if (!lessened) return fail(lessened.error());
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) {
        const Vec<D>& u = (*displacements)[e];
        const bool whole = u == extended[e].point - (*middles)[e].point;
        return whole ? extended[e] : LagrangeNode<D>{(*middles)[e].point + u};
    });
}

template Outcome<Buffer<LagrangeNode<2>>> carried_nodes<2>(const QuadraticMesh<2>&, std::span<const LagrangeNode<2>>,
                                                           const Column<LogMetric<2>>&, const Incidence<ElementId>&,
                                                           const Execution&);
template Outcome<Buffer<LagrangeNode<3>>> carried_nodes<3>(const QuadraticMesh<3>&, std::span<const LagrangeNode<3>>,
                                                           const Column<LogMetric<3>>&, const Incidence<ElementId>&,
                                                           const Execution&);

}  // namespace camber
