module;
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

template <int D>
Vec<D> node_without_cusp(const GeometryModel<D>& geometry, const EdgeSite<D>& edge) {
    constexpr double right_angle = 0.25;  // largest bow of a quadratic edge that turns by 90 degrees, by its chord
    constexpr double forwards = 0.2;      // largest slide along the chord, so that no end's tangent vanishes
    const Vec<D> node = geometry.middle_of(edge), middle = edge.middle();
    const Vec<D> chord = edge.ends[1] - edge.ends[0];
    const double length = norm(chord), limit = off_limit * length;
    if (!(distance(node, middle) > limit)) return node;
    Vec<D> off;
    for (const Vec<D>& end : edge.ends) off += 0.5 * (end - geometry.on_edge(edge, end).point);
    Vec<D> bow = node - middle;
    if (norm(off) > limit) {
        bow += (1 - limit / norm(off)) * off;
        if (norm(bow) > right_angle * length) bow = (right_angle * length / norm(bow)) * bow;
    }
    const auto slide = [&](const Vec<D>& from_middle) { return dot(from_middle, chord) / length; };
    if (const double along = slide(bow); std::abs(along) > right_angle * length) {
        bow -= ((along - std::copysign(forwards * length, along)) / length) * chord;
        const Vec<D> foot = geometry.on_edge(edge, middle + bow).point - middle;
        if (norm(off) <= limit && std::abs(slide(foot)) <= right_angle * length) bow = foot;
    }
    return bow == node - middle ? node : middle + bow;
}

template <int D>
Outcome<Buffer<LagrangeNode<D>>> boundary_nodes(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                const Geometry<D>& geometry, const Execution& execution) {
    if (features.edge_kinds.size() != mesh.edges.size() || mesh.mid_nodes.size() != mesh.edges.size())
        return fail(ErrorKind::internal, "the features are not of this mesh");
    const auto shells = facet_shells(mesh.edges, without_progress(execution));
    if (!shells) return fail(shells.error());
    const auto required = required_edges(mesh);
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) -> LagrangeNode<D> {
        if (features.edge_kinds[e] == EdgeKind::volume) return mesh.mid_nodes[e];
        if (required[e] != 0) return mesh.mid_nodes[e];
        const auto& [low, high] = mesh.edges.vertices[e];
        return {node_without_cusp<D>(*geometry, {EdgeId(e),
                                                 features.edge_kinds[e],
                                                 {mesh.linear.points[low], mesh.linear.points[high]},
                                                 facet_sites<D>(mesh.linear, (*shells)[e])})};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                             \
    template Vec<D> node_without_cusp<D>(const GeometryModel<D>&, const EdgeSite<D>&);                    \
    template Outcome<Buffer<LagrangeNode<D>>> boundary_nodes(const QuadraticMesh<D>&, const Features<D>&, \
                                                             const Geometry<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
