module;
#include <cstddef>
#include <span>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.cad;
import camber.surface;
import :report;
import :stages;

namespace camber::run {

namespace {

/// From 1.
std::vector<std::vector<std::size_t>> numbers_of(const std::vector<std::vector<std::size_t>>& lists) {
    auto numbers = lists;
    for (auto& list : numbers)
        for (std::size_t& number : list) ++number;
    return numbers;
}

template <int D>
CadReport cad_report(const CadModel& model, const CadAssociation& a) {
    CadReport report{.unit = model.unit(),
                     .file_unit = model.file_unit(),
                     .is_in_file_unit = model.is_in_file_unit(),
                     .faces = model.faces(),
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
    report.joined = {D == 2, numbers_of(a.joined)};
    if (a.across.count > 0)
        report.across = {
            a.across.count, a.across.first.index() + 1, {a.across.place.c.begin(), a.across.place.c.begin() + D}};
    return report;
}

}  // namespace

template <int D>
Outcome<MadeGeometry<D>> make_cad_geometry(const config::Cad& config, const CadModel& model, const LinearMesh<D>& mesh,
                                           const EdgeSet<D>& edges, std::span<const Reference> elsewhere,
                                           const Execution& execution) {
    auto association = associate(mesh, edges, model, elsewhere, execution);
    if (!association) return fail(association.error());
    const auto fits = check_vertices<D>(*association, config.vertices);
    CadReport report = cad_report<D>(model, *association);
    auto ridges = association->ridges;
    auto corners = association->corners;
    MadeGeometry<D> made{Geometry<D>(CadGeometry<D>{model, std::move(*association), mesh}), std::move(report),
                         std::move(ridges), std::move(corners)};
    if (!fits) made.misfit = fits.error();
    return made;
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<MadeGeometry<D>> make_cad_geometry<D>(const config::Cad&, const CadModel&, const LinearMesh<D>&, \
                                                           const EdgeSet<D>&, std::span<const Reference>,             \
                                                           const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
