module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
#include <fmt/ranges.h>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.soundness;
import camber.io;
import camber.surface;
import camber.cad;
import camber.stages;

namespace camber::run {

namespace {

std::string_view text_of(GeometryWarning what) {
    switch (what) {
        case GeometryWarning::near_ridge: return "angles slightly below the ridge angle";
        case GeometryWarning::mild_ridge: return "ridges whose angle is only slightly above the ridge angle";
        case GeometryWarning::knife_edge: return "knife edges: facets that nearly lie on each other";
        case GeometryWarning::tip: return "tips: all facets of a vertex are steep to its normal";
        case GeometryWarning::spread_normals: return "vertices whose facets have very different normals";
        case GeometryWarning::turned_facet: return "facets whose normal differs much from those of their vertices";
    }
    return {};
}

/// The boundary is determined if the file lists none.
template <int D>
struct QuadraticInput {
    QuadraticMesh<D> mesh;
    int degree = 2;
    bool is_listed = true;
};
template <int D>
Outcome<QuadraticInput<D>> quadratic_input(Mesh<D> mesh, const Execution& execution) {
    const int degree = mesh.degree;
    if (degree == 1) {
        auto elevated = elevate(std::move(mesh), 2, part_of(execution, 0, 0.5));
        if (!elevated) return fail(elevated.error());
        mesh = std::move(*elevated);
    }
    const bool is_listed = mesh.facets.template of<simplex<D - 1>>().size() > 0 || count_elements(mesh) == 0;
    if (!is_listed) {
        auto prepared = prepare(std::move(mesh), part_of(execution, 0.5, 1));
        if (!prepared) return fail(prepared.error());
        mesh = std::move(prepared->mesh);
    }
    return as_quadratic(std::move(mesh)).map([&](QuadraticMesh<D> quadratic) {
        return QuadraticInput<D>{std::move(quadratic), degree, is_listed};
    });
}

template <int D>
class Inspector {
  public:
    Inspector(QuadraticInput<D> input, FileNumbers numbers, const ComparedGeometry& compared,
              const InspectOptions& options, const StepWrapper& around)
        : mesh_(std::move(input.mesh)),
          numbers_(std::move(numbers)),
          compared_(compared),
          options_(options),
          around_(around) {
        report_.mesh = mesh_report(mesh_.linear, input.degree,
                                   mesh_.linear.points.size() + (input.degree == 2 ? mesh_.edges.size() : 0));
        report_.is_listed = input.is_listed;
        report_.ridge_angle = options.ridge_angle;
        report_.worst = options.worst;
    }

    Outcome<Inspected> inspect() {
        const auto step = [&](const char* name, Outcome<Done> (Inspector::*work)(const Execution&)) {
            return run_step(around_, name, [&](const Execution& e) { return (this->*work)(e); });
        };
        auto done = step("features", &Inspector::find)
                        .and_then([&](Done) { return step("surface", &Inspector::make); })
                        .and_then([&](Done) { return step("measure", &Inspector::measure); });
        if (!done) return fail(done.error());
        return Inspected{std::move(report_), AnyMesh(as_mesh(mesh_)), fields(), std::move(surface_)};
    }

  private:
    Outcome<Done> find(const Execution& execution) {
        auto features =
            find_features(mesh_.linear, mesh_.edges, FeatureOptions<D>{.ridge_angle_degrees = options_.ridge_angle},
                          part_of(execution, 0, 0.4));
        if (!features) return fail(features.error());
        features_ = std::move(*features);
        const InspectionLimits limits{.ridge_angle = options_.ridge_angle};
        const auto found = inspect_boundary(mesh_.linear, mesh_.edges, features_, limits, part_of(execution, 0.4, 1));
        if (!found) return fail(found.error());
        report_features(*found);
        return Done{};
    }

    void report_features(const BoundaryInspection<D>& found) {
        for (const PatchFacts& patch : found.patches)
            report_.patches.push_back({patch, report_.patches.size() + 1, {}, {}});
        for (const CurveFacts& curve : found.curves) report_.ridges.push_back({curve, report_.ridges.size() + 1});
        for (const VertexId v : found.corners) {
            const Vec<D>& p = mesh_.linear.points[v];
            report_.corners.push_back({numbers_(v.index()), {p.c.begin(), p.c.end()}});
        }
        report_.smooth_listed_edges = found.smooth_listed_edges;
        report_.interface_facets = found.interface_facets;
        report_.isolated_facets = found.isolated_facets;
        const auto ends = [&](const std::array<VertexId, 2>& edge) { return hinge(edge, {}); };
        report_.open = first_of(found.open, ends);
        report_.crowded = first_of(found.crowded, ends);
        report_.turned = first_of(found.turned, [&](const auto& t) { return hinge(t.edge, t.facets); });
        for (std::size_t kind = 0; kind < geometry_warning_count; ++kind) {
            const auto what = static_cast<GeometryWarning>(kind);
            PlacesReport places{std::string(text_of(what)), 0, {}};
            for (const LocatedWarning<D>& warning : found.located_warnings) {
                if (warning.what != what) continue;
                if (places.count++ < options_.worst) places.worst.push_back(place(warning));
            }
            report_.warnings.emplace_back(word_of(what), std::move(places));
        }
    }

    template <class Items, class Make>
    HingesReport first_of(const Items& items, Make&& make) const {
        HingesReport report{items.size(), {}};
        for (std::size_t i = 0; i < items.size() && i < options_.worst; ++i) report.first.push_back(make(items[i]));
        return report;
    }

    [[nodiscard]] HingeReport at(std::span<const VertexId> vertices, const Vec<D>& point,
                                 std::span<const FacetId> facets) const {
        HingeReport report{{}, {point.c.begin(), point.c.end()}, {}};
        for (const VertexId v : vertices) report.vertices.push_back(numbers_(v.index()));
        if (report_.is_listed)
            for (const FacetId f : facets) report.facets.push_back(f.index() + 1);
        return report;
    }

    [[nodiscard]] HingeReport hinge(const std::array<VertexId, 2>& edge, std::span<const FacetId> facets) const {
        const Vec<D> middle = midpoint(mesh_.linear.points[edge[0]], mesh_.linear.points[edge[1]]);
        return at(std::span(edge).first(D == 3 ? 2 : 1), middle, facets);
    }

    [[nodiscard]] PlaceReport place(const LocatedWarning<D>& warning) const {
        constexpr std::array<std::string_view, 4> names{"", "vertex", "edge", "triangle"};
        PlaceReport report{at(warning.vertices, warning.point, warning.facets), warning.degrees, {}};
        report.text = fmt::format("{} {}: {:.4g} degrees", names[warning.vertices.size()],
                                  fmt::join(report.at.vertices, "-"), warning.degrees);
        return report;
    }

    Outcome<Done> make(const Execution& execution) {
        auto source = in_unit_of_mesh(compared_.geometry, compared_.source, mesh_.linear, without_progress(execution));
        if (!source) return fail(source.error());
        source_ = std::move(*source);
        auto result = make_geometry<D>(compared_.geometry, source_, {mesh_.linear, mesh_.edges, features_, {}},
                                       {.ridge_angle_degrees = options_.ridge_angle}, part_of(execution, 0, 0.8));
        if (!result) return fail(result.error());
        geometry_.emplace(std::move(result->geometry));
        report_.cad = result->cad;
        if (result->fit_error)
            report_.notices.push_back("the mesh does not fit the CAD model: " + describe(*result->fit_error));
        if (compared_.surface == InspectedSurface::lattice) {
            auto shown = surface_mesh(mesh_, features_, *geometry_, without_progress(execution));
            if (!shown) return fail(shown.error());
            surface_ = std::move(*shown);
        }
        return source_.cad ? compare_with_cad(part_of(execution, 0.8, 1)) : Done{};
    }

    /// Finds the model faces (2D: edges) of each patch, and facets that two faces fit almost equally well.
    Outcome<Done> compare_with_cad(const Execution& execution) {
        constexpr std::string_view entity = D == 2 ? "edge" : "face", facet = D == 2 ? "edge" : "triangle";
        const CadModel& model = *source_.cad;
        const std::vector<std::size_t> all = candidates<D>(model);
        const auto& cad = std::get<config::Cad>(compared_.geometry);
        const auto is_on_model = [&](std::size_t f) {
            const Reference reference = mesh_.linear.facets.references[f];
            return lies_on_model(cad, reference) &&
                   !std::ranges::binary_search(report_.cad->within_materials, reference);
        };
        const auto fits = map_each(
            execution, mesh_.linear.facets.size(),
            [&](std::size_t f) {
                return is_on_model(f) ? best_fit<D>(model, all, facet_site(mesh_.linear, FacetId(f)).corners)
                                      : CadFit{};
            },
            64);
        if (!fits) return fail(fits.error());
        PlacesReport ambiguous{
            fmt::format("facets that another {} of the CAD model fits almost equally well", entity), 0, {}};
        constexpr auto cad_entities = D == 2 ? &PatchReport::cad_edges : &PatchReport::cad_faces;
        for (PatchReport& patch : report_.patches) (patch.*cad_entities).emplace();
        for (std::size_t f = 0; f < fits->size(); ++f) {
            if (!is_on_model(f)) continue;
            const FacetSite<D> site = facet_site(mesh_.linear, FacetId(f));
            const std::size_t face = (*geometry_)->name_of_entity((*geometry_)->surface_at(site)).number;
            auto& faces = *(report_.patches[features_.patches[f]].*cad_entities);
            const auto position = std::ranges::lower_bound(faces, face);
            if (position == faces.end() || *position != face) faces.insert(position, face);
            constexpr double nearly = 2;
            if ((*fits)[f].other > nearly * (*fits)[f].fit_error) continue;
            if (ambiguous.count++ >= options_.worst) continue;
            const std::array facets{FacetId(f)};
            Vec<D> middle;
            for (const Vec<D>& corner : site.corners) middle += corner;
            PlaceReport place{at(mesh_.linear.facets.vertices[f], middle / D, facets), (*fits)[f].fit_error, {}};
            place.text =
                fmt::format("{} {}: on {} {} with misfit {:.4g}; the next best has {:.4g}", facet,
                            fmt::join(place.at.vertices, "-"), entity, face, (*fits)[f].fit_error, (*fits)[f].other);
            ambiguous.worst.push_back(std::move(place));
        }
        report_.warnings.emplace_back("ambiguous_facet", std::move(ambiguous));
        return Done{};
    }

    Outcome<Done> measure(const Execution& execution) {
        const auto points = samples_of_geometry(mesh_, features_, *geometry_, part_of(execution, 0, 0.2));
        if (!points) return fail(points.error());
        auto found = two_sided_distances<D>(mesh_, mesh_.mid_nodes.view(), features_, *geometry_, *points,
                                            part_of(execution, 0.2, 1));
        if (!found) return fail(found.error());
        report_.distances = distances_report(*found, *geometry_, compared_.geometry);
        distances_ = std::move(*found);
        return Done{};
    }

    [[nodiscard]] MeshFields fields() const {
        constexpr double nan = std::numeric_limits<double>::quiet_NaN();
        const LinearMesh<D>& mesh = mesh_.linear;
        const std::size_t first = mesh.elements.size();
        return MeshFields({cell_field(mesh, "patch", first, features_.patches, std::int32_t{-1}),
                           cell_field(mesh, "distance_to_geometry", first, distances_.of_facets, nan),
                           cell_field(mesh, "distance_to_boundary", first, distances_.to_facets, nan),
                           node_kinds(mesh_, features_)});
    }

    QuadraticMesh<D> mesh_;
    FileNumbers numbers_;
    const ComparedGeometry& compared_;
    GeometrySource source_;  ///< in the unit of the mesh
    InspectOptions options_;
    const StepWrapper& around_;
    Features<D> features_;
    std::optional<Geometry<D>> geometry_;
    GeometryDistances<D> distances_;
    GeometryReport report_;
    std::optional<SurfaceMesh> surface_;
};

template <int D>
Outcome<Inspected> inspect(const Mesh<D>& mesh, const FileNumbers& numbers, const ComparedGeometry& geometry,
                           const InspectOptions& options, const StepWrapper& around) {
    auto input = run_step(around, "prepare", [&](const Execution& e) { return quadratic_input(mesh, e); });
    if (!input) return fail(input.error());
    return Inspector<D>(std::move(*input), numbers, geometry, options, around).inspect();
}

}  // namespace

Outcome<Inspected> inspect_geometry(DecodedMesh mesh, const ComparedGeometry& geometry, const InspectOptions& options,
                                    const StepWrapper& around) {
    const FileNumbers numbers = numbers_of(mesh);
    auto found = std::visit([&](const auto& m) { return inspect(m, numbers, geometry, options, around); }, mesh.mesh);
    if (!found) return found;
    for (Notice& notice : mesh.notices) found->report.notices.push_back(std::move(notice.what));
    if (!found->report.is_listed)
        found->report.notices.emplace_back(
            "the file lists no boundary: it was computed, and its facets have no numbers");
    return found;
}

namespace {

std::string_view name_of(FieldKind kind) {
    switch (kind) {
        case FieldKind::scalar: return "scalar";
        case FieldKind::vector: return "vector";
        case FieldKind::symmetric_tensor: return "symmetric tensor";
        case FieldKind::full_tensor: return "full tensor";
    }
    return {};
}

std::vector<std::string> texts_of(const std::vector<Notice>& notices) {
    std::vector<std::string> texts;
    texts.reserve(notices.size());
    for (const Notice& notice : notices) texts.push_back(notice.what);
    return texts;
}

template <int D>
MeshInfo described(const Mesh<D>& original) {
    const LinearMesh<D> mesh = straight_simplices(original);
    MeshInfo info;
    info.dimension = D;
    info.degree = original.degree;
    info.vertices = mesh.points.size();
    Box<D> box;
    for (const Vec<D>& p : mesh.points) box.include(p);
    if (!mesh.points.empty())
        info.box = {{{box.low.c.begin(), box.low.c.end()}, {box.high.c.begin(), box.high.c.end()}}};
    const auto count = [](const auto& simplices, std::size_t& number, ReferenceCounts& by_reference) {
        number = simplices.size();
        by_reference = counted_by_reference(simplices.references);
    };
    if constexpr (D == 3) {
        count(mesh.elements, info.tetrahedra, info.tetrahedra_by_reference);
        count(mesh.facets, info.triangles, info.triangles_by_reference);
        count(mesh.edges, info.edges, info.edges_by_reference);
        info.required_triangles = mesh.facets.required.size();
        info.required_edges = mesh.edges.required.size();
    } else {
        count(mesh.elements, info.triangles, info.triangles_by_reference);
        count(mesh.facets, info.edges, info.edges_by_reference);
        info.required_edges = mesh.facets.required.size();
    }
    info.ridges = mesh.ridges.size();
    info.corners = mesh.corners.size();
    info.required_vertices = mesh.required_vertices.size();
    info.groups = {mesh.groups.begin(), mesh.groups.end()};
    info.normals = mesh.geometry.normals.at.size();
    info.tangents = mesh.geometry.tangents.at.size();
    info.is_empty = mesh.elements.vertices.empty() && mesh.facets.vertices.empty();
    info.mid_nodes = original.edge_nodes.size();
    return info;
}

}  // namespace

MeshInfo mesh_info(const DecodedMesh& decoded) {
    MeshInfo info = std::visit([](const auto& mesh) { return described(mesh); }, decoded.mesh);
    for (const CellCount& cells : decoded.unsupported_cells)
        info.unsupported_cells.emplace_back(cells.kind, cells.count);
    if (!decoded.unsupported_cells.empty()) info.is_empty = false;
    for (const MeshField& field : decoded.fields)
        info.mesh_fields.push_back(
            {field.name, field.centring == Centring::node ? "nodes" : "cells", name_of(field.kind)});
    if (decoded.lift) {
        info.written_in_dimension = 3;
        info.z = decoded.lift->z;
    }
    info.notices = texts_of(decoded.notices);
    return info;
}

SolutionInfo solution_info(const DecodedSolution& decoded) {
    SolutionInfo info{decoded.solution.dimension, decoded.solution.rows, {}, texts_of(decoded.notices)};
    for (const FieldKind kind : decoded.solution.fields) info.kinds.push_back(name_of(kind));
    return info;
}

}  // namespace camber::run
