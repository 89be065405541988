module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.cad;
import camber.config;
import camber.surface;
import :report;
import :stages;
import :state;

namespace camber::run {

namespace {

CadReport cad_report(const CadModel& model, const CadAssociation& a) {
    return {.faces = model.faces(),
            .edges = model.edges(),
            .vertices = model.vertices(),
            .faces_met = a.faces_met,
            .edges_met = a.edges_met,
            .vertices_met = a.vertices_met,
            .facets = a.facets,
            .coincident_facets = a.coincident_facets,
            .doubtful_facets = a.doubtful_facets,
            .settled_facets = a.settled_facets,
            .doubtful_edges = a.doubtful_edges,
            .doubtful_vertices = a.doubtful_vertices,
            .largest_vertex_distance = a.largest_vertex_distance,
            .largest_node_distance = {},
            .lost_faces = model.losses().faces,
            .failed_entities = model.losses().entities,
            .open_shells = model.losses().open_shells};
}

}  // namespace

template <int D>
Outcome<MadeGeometry<D>> make_cad_geometry(const CadModel& model, const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                           std::span<const Reference> elsewhere, const Execution& execution) {
    auto association = associate(mesh, edges, model, elsewhere, execution);
    if (!association) return fail(association.error());
    const CadReport report = cad_report(model, *association);
    auto ridges = association->ridges;
    auto corners = association->corners;
    return MadeGeometry<D>{Geometry<D>(CadGeometry<D>{model, std::move(*association), mesh}), report, std::move(ridges),
                           std::move(corners)};
}

template <int D>
Outcome<double> largest_node_distance(const QuadraticMesh<D>& mesh, const Boundary<D>& boundary, const config::Cad& cad,
                                      const Execution& execution) {
    const auto shells = facet_shells(mesh.edges, without_progress(execution));
    if (!shells) return fail(shells.error());
    const auto add = [&](double& largest, std::size_t e) {
        if (boundary.features.edge_kinds[e] == EdgeKind::volume) return;
        const auto is_on_model = [&](FacetId f) { return lies_on_model(cad, mesh.linear.facets.references[f]); };
        if (std::ranges::none_of((*shells)[e], is_on_model)) return;
        const auto& [low, high] = mesh.edges.vertices[e];
        const EdgeSite<D> site{EdgeId(e),
                               boundary.features.edge_kinds[e],
                               {mesh.linear.points[low], mesh.linear.points[high]},
                               facet_sites<D>(mesh.linear, (*shells)[e])};
        const Vec<D>& node = mesh.mid_nodes[e].point;
        largest = std::max(largest, distance(boundary.geometry->on_edge(site, node).point, node));
    };
    return reduce_each(execution, mesh.edges.size(), 0.0, add, [](double a, double b) { return std::max(a, b); });
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<MadeGeometry<D>> make_cad_geometry<D>(const CadModel&, const LinearMesh<D>&, const EdgeSet<D>&,   \
                                                           std::span<const Reference>, const Execution&);              \
    template Outcome<double> largest_node_distance<D>(const QuadraticMesh<D>&, const Boundary<D>&, const config::Cad&, \
                                                      const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
