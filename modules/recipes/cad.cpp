module;
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.recipes;
import camber.core;
import camber.surface;
import camber.cad;

namespace camber::run {

namespace {

std::vector<std::vector<std::size_t>> numbers_of(const std::vector<std::vector<std::size_t>>& lists) {
    auto numbers = lists;
    for (auto& list : numbers)
        for (std::size_t& number : list) ++number;
    return numbers;
}

template <int D>
CadReport cad_report(const CadModel& model, const CadAssociation& a) {
    CadReport report{.mesh_unit = model.unit(),
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
                     .ambiguous_facets = a.ambiguous_facets,
                     .settled_facets = a.settled_facets,
                     .ambiguous_edges = a.ambiguous_edges,
                     .ambiguous_vertices = a.ambiguous_vertices,
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
Outcome<BuiltGeometry<D>> make_cad_geometry(const config::Cad& config, const CadModel& model, const LinearMesh<D>& mesh,
                                            const EdgeSet<D>& edges, std::span<const Reference> excluded,
                                            const Execution& execution) {
    auto association = associate(mesh, edges, model, excluded, execution);
    if (!association) return fail(association.error());
    const auto fits = check_vertices<D>(*association, config.vertices);
    CadReport report = cad_report<D>(model, *association);
    auto ridges = association->ridges;
    auto corners = association->corners;
    BuiltGeometry<D> result{Geometry<D>(CadGeometry<D>{model, std::move(*association), mesh}), std::move(report),
                            std::move(ridges), std::move(corners)};
    if (!fits) result.fit_error = fits.error();
    return result;
}

namespace {

bool is_among(const std::vector<Reference>& sorted, Reference reference) {
    return std::ranges::binary_search(sorted, reference);
}

bool is_analytic(const config::Cad& cad, Reference reference) {
    return std::ranges::any_of(cad.analytic, [&](const config::AnalyticSurface& surface) {
        return std::ranges::find(surface.references, reference) != surface.references.end();
    });
}

template <int D>
std::vector<Reference> references_of(const LinearMesh<D>& mesh) {
    std::vector<Reference> all(mesh.facets.references.begin(), mesh.facets.references.end());
    std::ranges::sort(all);
    all.erase(std::ranges::unique(all).begin(), all.end());
    return all;
}

std::string listed(const std::vector<Reference>& references) {
    constexpr std::size_t most = 12;
    std::string list;
    for (std::size_t i = 0; i < std::min(most, references.size()); ++i)
        list += (i > 0 ? ", " : "") + std::to_string(references[i]);
    return list + (references.size() > most ? ", …" : "");
}

Outcome<Done> check_references(const config::Cad& cad, const std::vector<Reference>& of_mesh) {
    for (std::size_t i = 0; i < cad.references.size(); ++i) {
        const Reference reference = cad.references[i];
        const std::string where = "/geometry/cad/references/" + std::to_string(i);
        const std::string name = "reference " + std::to_string(reference);
        const auto before = cad.references.begin() + static_cast<std::ptrdiff_t>(i);
        if (std::find(cad.references.begin(), before, reference) != before)
            return fail(ErrorKind::usage, name + " is named twice", where, {}, "name each reference once");
        if (is_analytic(cad, reference))
            return fail(ErrorKind::usage, name + " also has an analytic surface", where, {},
                        "name it either here or in \"analytic\"");
        if (!is_among(of_mesh, reference))
            return fail(ErrorKind::usage, "no boundary triangle of the mesh has " + name, where, {},
                        of_mesh.empty() ? "the mesh has no boundary triangles" : "it has " + listed(of_mesh));
    }
    return Done{};
}

/// References by the geometry of their facets; each list is ascending.
struct Shares {
    std::vector<Reference> on_model, on_analytic, on_rest;
    std::vector<Reference> within_materials = {};  ///< part of `on_rest`: within one material and not on the model

    [[nodiscard]] std::vector<Reference> excluded() const {
        std::vector<Reference> all;
        std::ranges::merge(on_analytic, on_rest, std::back_inserter(all));
        return all;
    }
};
template <int D>
Outcome<Shares> with_sheets_on_rest(Shares shares, const CadModel& model, const LinearMesh<D>& mesh,
                                    const Execution& execution) {
    auto within = references_within_materials(mesh, model, shares.excluded(), execution);
    if (!within) return fail(within.error());
    if (within->size() == shares.on_model.size()) return shares;
    std::erase_if(shares.on_model, [&](Reference r) { return is_among(*within, r); });
    shares.on_rest = *within;
    shares.within_materials = std::move(*within);
    return shares;
}

template <int D>
Outcome<Shares> shares_of(const config::Cad& cad, const CadModel& model, const LinearMesh<D>& mesh,
                          const Execution& execution) {
    const auto all = references_of(mesh);
    if (auto checked = check_references(cad, all); !checked) return fail(checked.error());
    Shares shares;
    for (const Reference reference : all)
        (lies_on_model(cad, reference) ? shares.on_model
         : is_analytic(cad, reference) ? shares.on_analytic
                                       : shares.on_rest)
            .push_back(reference);
    if (shares.on_model.empty() && !all.empty())
        return fail(ErrorKind::usage,
                    "all references of the mesh have analytic surfaces: no facets are left for the "
                    "CAD model",
                    "/geometry/cad/analytic", {}, "use the geometry \"analytic\", or remove analytic surfaces");
    if (!cad.references.empty()) return shares;
    return with_sheets_on_rest(std::move(shares), model, mesh, without_progress(execution));
}

template <int D>
std::size_t facets_of(const LinearMesh<D>& mesh, const std::vector<Reference>& references) {
    return static_cast<std::size_t>(
        std::ranges::count_if(mesh.facets.references, [&](Reference r) { return is_among(references, r); }));
}

}  // namespace

bool lies_on_model(const config::Cad& cad, Reference reference) {
    if (!cad.references.empty()) return std::ranges::find(cad.references, reference) != cad.references.end();
    return !is_analytic(cad, reference);
}

template <int D>
Outcome<GeometrySource> in_unit_of_mesh(const config::Geometry& geometry, GeometrySource source,
                                        const LinearMesh<D>& mesh, const Execution& execution) {
    const auto* const cad = std::get_if<config::Cad>(&geometry);
    if (!cad || !source.cad || cad->unit != CadUnit::automatic) return source;
    const auto shares = shares_of(*cad, *source.cad, mesh, execution);
    if (!shares) return source;  // `make_cad_mixture` reports the error
    auto model = in_unit_of(mesh, *source.cad, shares->excluded(), execution);
    if (!model) return fail(model.error());
    source.cad = std::move(*model);
    return source;
}

template <int D>
Outcome<BuiltGeometry<D>> make_cad_mixture(const config::Cad& config, const CadModel& model, const LinearMesh<D>& mesh,
                                           const EdgeSet<D>& edges, const SurrogateFactory<D>& surrogate,
                                           const Execution& execution) {
    auto analytic = make_analytic<D>(config.analytic, "/geometry/cad/analytic", mesh, without_progress(execution));
    if (!analytic) return fail(analytic.error());
    const auto shares = shares_of(config, model, mesh, execution);
    if (!shares) return fail(shares.error());
    const auto excluded = shares->excluded();
    auto result = make_cad_geometry(config, model, mesh, edges, excluded, execution);
    if (!result) return result;
    if (!shares->on_analytic.empty()) result->off_surfaces = off_surfaces<D>(mesh, *analytic);
    const Geometry<D> surfaces(std::move(*analytic));
    const auto with_analytic = [&](const Geometry<D>& rest) {
        return shares->on_analytic.empty() ? rest : Geometry<D>(MixedGeometry<D>{shares->on_analytic, surfaces, rest});
    };
    if (!shares->on_rest.empty()) {
        auto rest = surrogate(*with_analytic(result->geometry));
        if (!rest) return fail(rest.error());
        result->geometry = MixedGeometry<D>{shares->on_model, result->geometry, std::move(*rest)};
    }
    result->geometry = with_analytic(result->geometry);
    result->cad->is_unit_found = config.unit == CadUnit::automatic && !model.is_in_file_unit();
    result->cad->within_materials = shares->within_materials;
    result->cad->analytic_facets = facets_of(mesh, shares->on_analytic);
    result->cad->surrogate_facets = facets_of(mesh, shares->on_rest);
    return result;
}

template <int D>
Outcome<MovedVertices<D>> moved_vertices(const config::Cad& config, const CadModel& model, const LinearMesh<D>& mesh,
                                         const EdgeSet<D>& edges, const Execution& execution) {
    auto analytic = make_analytic<D>(config.analytic, "/geometry/cad/analytic", mesh, without_progress(execution));
    if (!analytic) return fail(analytic.error());
    const auto shares = shares_of(config, model, mesh, execution);
    if (!shares) return fail(shares.error());
    auto association = associate(mesh, edges, model, shares->excluded(), part_of(execution, 0, 0.6));
    if (!association) return fail(association.error());
    Geometry<D> geometry(CadGeometry<D>{model, *association, mesh});
    if (!shares->on_analytic.empty())
        geometry = MixedGeometry<D>{shares->on_analytic, std::move(*analytic), std::move(geometry)};
    auto moved = vertices_onto(model, *association, mesh, geometry, part_of(execution, 0.6, 1));
    if (!moved) return fail(moved.error());
    return MovedVertices<D>{std::move(moved->points), {moved->moved, moved->constrained, moved->largest}};
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<BuiltGeometry<D>> make_cad_geometry<D>(const config::Cad&, const CadModel&, const LinearMesh<D>&, \
                                                            const EdgeSet<D>&, std::span<const Reference>,             \
                                                            const Execution&);                                         \
    template Outcome<GeometrySource> in_unit_of_mesh<D>(const config::Geometry&, GeometrySource, const LinearMesh<D>&, \
                                                        const Execution&);                                             \
    template Outcome<MovedVertices<D>> moved_vertices<D>(const config::Cad&, const CadModel&, const LinearMesh<D>&,    \
                                                         const EdgeSet<D>&, const Execution&);                         \
    template Outcome<BuiltGeometry<D>> make_cad_mixture<D>(const config::Cad&, const CadModel&, const LinearMesh<D>&,  \
                                                           const EdgeSet<D>&, const SurrogateFactory<D>&,              \
                                                           const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
