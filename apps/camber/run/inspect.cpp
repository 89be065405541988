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
module camber.run;
import camber.core;
import camber.bezier;
import camber.cad;
import camber.config;
import camber.io;
import camber.soundness;
import camber.recipes;
import camber.surface;
import :check_parts;
import :file_numbers;
import :geometry_source;
import :distances_report;
import :inspect;
import :report;
import :stages;
import :surface_mesh;

namespace camber::run {

namespace {

/// What is wrong with a kind of places, as one says it.
std::string_view text_of(Suspicion what) {
    switch (what) {
        case Suspicion::near_ridge: return "turns that are nearly ridges";
        case Suspicion::mild_ridge: return "ridges by their angle alone, hardly more than asked for";
        case Suspicion::knife_edge: return "knife edges: facets that nearly lie on each other";
        case Suspicion::tip: return "tips: all facets of a vertex are steep to its normal";
        case Suspicion::spread_normals: return "vertices whose facets' normals spread";
        case Suspicion::turned_facet: return "facets whose own normal is far from those of their vertices";
    }
    return {};
}

/// One look in D dimensions, step by step.
template <int D>
class Inspector {
  public:
    Inspector(QuadraticMesh<D> mesh, int degree, bool is_listed, FileNumbers numbers, const ComparedGeometry& compared,
              const InspectOptions& options, const Around& around)
        : mesh_(std::move(mesh)),
          numbers_(std::move(numbers)),
          compared_(compared),
          options_(options),
          around_(around) {
        const LinearMesh<D>& linear = mesh_.linear;
        report_.mesh = {D,
                        degree,
                        linear.points.size(),
                        linear.points.size() + (degree == 2 ? mesh_.edges.size() : 0),
                        linear.elements.size(),
                        linear.facets.size(),
                        linear.edges.size()};
        report_.is_listed = is_listed;
        report_.ridge_angle = options.ridge_angle;
        report_.worst = options.worst;
    }

    Outcome<Inspected> inspect() {
        auto done =
            step("features", [&](const Execution& e) {
                return find(e);
            }).and_then([&](Done) {
                  return step("surface", [&](const Execution& e) { return make(e); });
              }).and_then([&](Done) { return step("measure", [&](const Execution& e) { return measure(e); }); });
        if (!done) return fail(done.error());
        return Inspected{std::move(report_), AnyMesh(mesh_), fields(), std::move(surface_)};
    }

  private:
    template <class F>
    Outcome<Done> step(const char* name, F&& f) {
        return around_(name, [&](const Execution& execution) { return guarded([&] { return f(execution); }); });
    }

    Outcome<Done> find(const Execution& execution) {
        auto features =
            find_features(mesh_.linear, mesh_.edges, FeatureOptions<D>{.ridge_angle_degrees = options_.ridge_angle},
                          part_of(execution, 0, 0.4));
        if (!features) return fail(features.error());
        features_ = std::move(*features);
        const InspectionLimits limits{.ridge_angle = options_.ridge_angle};
        const auto found = inspect_boundary(mesh_.linear, mesh_.edges, features_, limits, part_of(execution, 0.4, 1));
        if (!found) return fail(found.error());
        tell(*found);
        return Done{};
    }

    void tell(const BoundaryInspection<D>& found) {
        for (const PatchFacts& patch : found.patches) report_.patches.push_back({patch, {}});
        report_.ridges = found.curves;
        for (const VertexId v : found.corners) {
            const Vec<D>& p = mesh_.linear.points[v];
            report_.corners.push_back({numbers_(v.index()), {p.c.begin(), p.c.end()}});
        }
        report_.smooth_listed_edges = found.smooth_listed_edges;
        report_.interface_facets = found.interface_facets;
        report_.lone_facets = found.lone_facets;
        const auto ends = [&](const std::array<VertexId, 2>& edge) { return hinge(edge, {}); };
        report_.open = first_of(found.open, ends);
        report_.crowded = first_of(found.crowded, ends);
        report_.turned = first_of(found.turned, [&](const auto& t) { return hinge(t.edge, t.facets); });
        for (std::size_t kind = 0; kind < suspicion_count; ++kind) {
            const auto what = static_cast<Suspicion>(kind);
            PlacesReport places{std::string(word_of(what)), std::string(text_of(what)), 0, {}};
            for (const Suspect<D>& suspect : found.suspects) {
                if (suspect.what != what) continue;
                if (places.count++ < options_.worst) places.worst.push_back(place(suspect));
            }
            report_.suspicious.push_back(std::move(places));
        }
    }

    template <class Items, class Tell>
    HingesReport first_of(const Items& items, Tell&& tell) const {
        HingesReport report{items.size(), {}};
        for (std::size_t i = 0; i < items.size() && i < options_.worst; ++i) report.first.push_back(tell(items[i]));
        return report;
    }

    [[nodiscard]] std::size_t facet_number(FacetId f) const { return report_.is_listed ? f.index() + 1 : 0; }

    [[nodiscard]] HingeReport at(std::span<const VertexId> vertices, const Vec<D>& point,
                                 std::span<const FacetId> facets) const {
        HingeReport report{{}, {point.c.begin(), point.c.end()}, {}};
        for (const VertexId v : vertices) report.vertices.push_back(numbers_(v.index()));
        if (report_.is_listed)
            for (const FacetId f : facets) report.facets.push_back(facet_number(f));
        return report;
    }

    [[nodiscard]] HingeReport hinge(const std::array<VertexId, 2>& edge, std::span<const FacetId> facets) const {
        const Vec<D> middle = midpoint(mesh_.linear.points[edge[0]], mesh_.linear.points[edge[1]]);
        return at(std::span(edge).first(D == 3 ? 2 : 1), middle, facets);
    }

    [[nodiscard]] PlaceReport place(const Suspect<D>& suspect) const {
        constexpr std::array<std::string_view, 4> names{"", "vertex", "edge", "triangle"};
        PlaceReport report{at(suspect.vertices, suspect.point, suspect.facets), suspect.degrees, {}};
        report.text = fmt::format("{} {}: {:.4g} degrees", names[suspect.vertices.size()],
                                  fmt::join(report.at.vertices, "-"), suspect.degrees);
        return report;
    }

    Outcome<Done> make(const Execution& execution) {
        auto source = in_unit_of_mesh(compared_.geometry, compared_.source, mesh_.linear, without_progress(execution));
        if (!source) return fail(source.error());
        source_ = std::move(*source);
        auto made = make_geometry(compared_.geometry, source_, mesh_.linear, mesh_.edges, features_,
                                  {.ridge_angle_degrees = options_.ridge_angle}, {}, part_of(execution, 0, 0.8));
        if (!made) return fail(made.error());
        geometry_.emplace(std::move(made->geometry));
        report_.cad = made->cad;
        if (made->misfit)
            report_.notices.push_back("the mesh does not belong to the CAD model: " + describe(*made->misfit));
        if (compared_.surface == InspectedSurface::lattice) {
            auto shown = surface_mesh(mesh_, features_, *geometry_, without_progress(execution));
            if (!shown) return fail(shown.error());
            surface_ = std::move(*shown);
        }
        return source_.cad ? look_at_cad(part_of(execution, 0.8, 1)) : Done{};
    }

    /// Which faces (in 2D edges) of the model patches are on, and facets that another one fits nearly as well.
    Outcome<Done> look_at_cad(const Execution& execution) {
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
        PlacesReport doubtful{"doubtful_facet",
                              fmt::format("facets that another {} of the CAD model fits nearly as well", entity),
                              0,
                              {}};
        for (std::size_t f = 0; f < fits->size(); ++f) {
            if (!is_on_model(f)) continue;
            const FacetSite<D> site = facet_site(mesh_.linear, FacetId(f));
            const std::size_t face = (*geometry_)->called((*geometry_)->surface_at(site)).number;
            auto& faces = report_.patches[features_.patches[f]].cad_faces;
            const auto place = std::lower_bound(faces.begin(), faces.end(), face);
            if (place == faces.end() || *place != face) faces.insert(place, face);
            constexpr double nearly = 2;
            if ((*fits)[f].other > nearly * (*fits)[f].misfit) continue;
            if (doubtful.count++ >= options_.worst) continue;
            const std::array facets{FacetId(f)};
            Vec<D> middle;
            for (const Vec<D>& corner : site.corners) middle += corner;
            PlaceReport told{at(mesh_.linear.facets.vertices[f], middle / D, facets), (*fits)[f].misfit, {}};
            told.text =
                fmt::format("{} {}: on {} {}, which misses it by {:.4g}, the next by {:.4g}", facet,
                            fmt::join(told.at.vertices, "-"), entity, face, (*fits)[f].misfit, (*fits)[f].other);
            doubtful.worst.push_back(std::move(told));
        }
        report_.suspicious.push_back(std::move(doubtful));
        return Done{};
    }

    Outcome<Done> measure(const Execution& execution) {
        const auto points = samples_of_geometry(mesh_, features_, *geometry_, part_of(execution, 0, 0.2));
        if (!points) return fail(points.error());
        auto found = distances_both_ways<D>(mesh_, mesh_.mid_nodes.view(), features_, *geometry_, *points,
                                            part_of(execution, 0.2, 1));
        if (!found) return fail(found.error());
        report_.distances = distances_report(*found, *geometry_, compared_.geometry);
        distances_ = std::move(*found);
        return Done{};
    }

    /// A value a facet; of elements and of listed edges none.
    template <class T>
    [[nodiscard]] MeshField facet_field(std::string name, const Column<T>& values, auto rest) const {
        using Value = decltype(rest);
        const std::size_t elements = mesh_.linear.elements.size();
        Buffer<Value> column(elements + mesh_.linear.facets.size() + mesh_.linear.edges.size());
        std::fill(column.begin(), column.end(), rest);
        for (std::size_t f = 0; f < values.size(); ++f) column[elements + f] = static_cast<Value>(values[f]);
        return {std::move(name), Centring::cell, FieldKind::scalar, Column<Value>(std::move(column))};
    }

    [[nodiscard]] MeshFields fields() const {
        constexpr double nan = std::numeric_limits<double>::quiet_NaN();
        const std::size_t vertices = mesh_.linear.points.size();
        Buffer<std::int32_t> kinds(vertices + mesh_.edges.size());
        for (std::size_t n = 0; n < kinds.size(); ++n)
            kinds[n] = n < vertices ? static_cast<std::int32_t>(features_.vertex_kinds[n])
                                    : static_cast<std::int32_t>(features_.edge_kinds[n - vertices]);
        return MeshFields({facet_field("patch", features_.patches, std::int32_t{-1}),
                           facet_field("distance_to_geometry", distances_.of_facets, nan),
                           facet_field("distance_to_boundary", distances_.to_facets, nan),
                           {"node_kind", Centring::node, FieldKind::scalar, Column<std::int32_t>(std::move(kinds))}});
    }

    QuadraticMesh<D> mesh_;
    FileNumbers numbers_;
    const ComparedGeometry& compared_;
    GeometrySource source_;  ///< in the unit of the mesh
    InspectOptions options_;
    const Around& around_;
    Features<D> features_;
    std::optional<Geometry<D>> geometry_;
    GeometryDistances<D> distances_;
    GeometryReport report_;
    std::optional<SurfaceMesh> surface_;
};

/// A mesh of degree 2, its boundary listed where the file has none and it can be found.
template <int D>
struct Begun {
    QuadraticMesh<D> mesh;
    int degree = 2;
    bool is_listed = true;
};
template <int D>
Outcome<Begun<D>> begun(QuadraticMesh<D> mesh, int degree, const Execution& execution) {
    if (mesh.linear.facets.size() > 0 || mesh.linear.elements.size() == 0) return Begun<D>{std::move(mesh), degree};
    auto prepared = prepare(mesh, execution);
    if (!prepared) return fail(prepared.error());
    return Begun<D>{std::move(prepared->mesh), degree, false};
}
template <int D>
Outcome<Begun<D>> begun(const LinearMesh<D>& mesh, const Execution& execution) {
    auto elevated = elevate(mesh, part_of(execution, 0, 0.5));
    if (!elevated) return fail(elevated.error());
    return begun(std::move(*elevated), 1, part_of(execution, 0.5, 1));
}
template <int D>
Outcome<Begun<D>> begun(const QuadraticMesh<D>& mesh, const Execution& execution) {
    return begun(mesh, 2, execution);
}

template <int D>
Outcome<Inspected> inspect(const auto& mesh, const FileNumbers& numbers, const ComparedGeometry& geometry,
                           const InspectOptions& options, const Around& around) {
    std::optional<Begun<D>> begin;
    auto done = around("prepare", [&](const Execution& execution) {
        return guarded([&]() -> Outcome<Done> {
            auto made = begun(mesh, execution);
            if (!made) return fail(made.error());
            begin = std::move(*made);
            return Done{};
        });
    });
    if (!done) return fail(done.error());
    return Inspector<D>(std::move(begin->mesh), begin->degree, begin->is_listed, numbers, geometry, options, around)
        .inspect();
}

}  // namespace

Outcome<Inspected> inspect_geometry(DecodedMesh mesh, const ComparedGeometry& geometry, const InspectOptions& options,
                                    const Around& around) {
    const FileNumbers numbers = numbers_of(mesh);
    auto found = std::visit(
        [&](const auto& m) {
            constexpr int d = std::decay_t<decltype(m)>::dimension;
            return inspect<d>(m, numbers, geometry, options, around);
        },
        mesh.mesh);
    if (!found) return found;
    for (Notice& notice : mesh.notices) found->report.notices.push_back(std::move(notice.what));
    if (!found->report.is_listed)
        found->report.notices.emplace_back("the file lists no boundary: it was found, and its facets have no numbers");
    return found;
}

}  // namespace camber::run
