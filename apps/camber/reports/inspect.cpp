// Descriptions of meshes, and tables of distances
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
#include <nlohmann/json.hpp>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.bezier;
import camber.soundness;
import camber.io;
import camber.surface;
import camber.cad;
import camber.config;

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
        return Inspected{std::move(report_), AnyMesh(as_mesh(mesh_)), fields(), std::move(surface_)};
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
        auto made = make_geometry<D>(compared_.geometry, source_, {mesh_.linear, mesh_.edges, features_, {}},
                                     {.ridge_angle_degrees = options_.ridge_angle}, part_of(execution, 0, 0.8));
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
        PlacesReport doubtful{"ambiguous_facet",
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
Outcome<Begun<D>> begun(Mesh<D> mesh, const Execution& execution) {
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
        return Begun<D>{std::move(quadratic), degree, is_listed};
    });
}

template <int D>
Outcome<Inspected> inspect(const Mesh<D>& mesh, const FileNumbers& numbers, const ComparedGeometry& geometry,
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
    auto found = std::visit([&](const auto& m) { return inspect(m, numbers, geometry, options, around); }, mesh.mesh);
    if (!found) return found;
    for (Notice& notice : mesh.notices) found->report.notices.push_back(std::move(notice.what));
    if (!found->report.is_listed)
        found->report.notices.emplace_back("the file lists no boundary: it was found, and its facets have no numbers");
    return found;
}

namespace {

std::string listed(const auto& items) {
    constexpr std::size_t shown = 6;
    std::string text;
    for (std::size_t i = 0; i < items.size() && i < shown; ++i)
        text += (i > 0 ? "," : "") + fmt::format("{}", items[i]);
    return items.size() > shown ? text + ",…" : text;
}

std::string place_of(const HingeReport& at) {
    std::string text = fmt::format("at ({:.6g})", fmt::join(at.point, ", "));
    if (!at.facets.empty()) text += fmt::format(", facets {}", listed(at.facets));
    return text;
}

std::string mesh_rows(const GeometryReport& r) {
    const bool flat = r.mesh.dimension == 2;
    std::string text = table_row("dimension, degree", fmt::format("{}D, P{}", r.mesh.dimension, r.mesh.degree)) +
                       table_row(flat ? "boundary edges" : "boundary triangles", r.mesh.facets);
    if (r.interface_facets > 0) text += table_row("  with elements on both sides", r.interface_facets);
    if (r.lone_facets > 0) text += table_row("! with elements on neither", r.lone_facets);
    text += table_row(flat ? "smooth curves" : "patches", r.patches.size());
    if (!flat) text += table_row("ridges", r.ridges.size());
    text += table_row("corners", r.corners.size());
    if (r.smooth_listed_edges > 0) text += table_row("listed edges that are no ridges", r.smooth_listed_edges);
    return text;
}

std::string hinge_rows(const HingesReport& hinges, const std::string& name, std::size_t dimension) {
    if (hinges.count == 0) return {};
    std::string text = table_row(name, hinges.count);
    for (const HingeReport& at : hinges.first)
        text += fmt::format("    {} {} {}\n", dimension == 2 ? "vertex" : "edge", fmt::join(at.vertices, "-"),
                            place_of(at));
    return text;
}

/// The numbers of the n largest.
template <class Size>
std::vector<std::size_t> largest(std::size_t count, std::size_t n, Size&& size) {
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size(a) > size(b); });
    order.resize(std::min(n, count));
    return order;
}

std::string more(std::size_t all, std::size_t shown) {
    return all > shown ? fmt::format("  and {} more: --worst, or --json for all\n", all - shown) : std::string();
}

std::string patch_rows(const GeometryReport& r) {
    if (r.patches.empty() || r.worst == 0) return {};
    const bool flat = r.mesh.dimension == 2;
    std::string text = fmt::format("\n  {:<8}{:<16}{:>10}{:>13}{:>13}  {}\n", flat ? "curve" : "patch", "references",
                                   flat ? "edges" : "triangles", flat ? "length" : "area", "size",
                                   !r.cad ? "what"
                                   : flat ? "what, CAD edges"
                                          : "what, CAD faces");
    for (const std::size_t i :
         largest(r.patches.size(), r.worst, [&](std::size_t p) { return r.patches[p].facts.area; })) {
        const auto& [facts, faces] = r.patches[i];
        std::string what = facts.is_flat ? (flat ? "straight" : "flat") : "curved";
        if (facts.interface_facets == facts.facets) what += ", interface";
        if (!faces.empty()) what += ", " + listed(faces);
        text += fmt::format("  {:<8}{:<16}{:>10}{:>13.6g}{:>13.6g}  {}\n", i + 1, listed(facts.references),
                            grouped(facts.facets), facts.area, facts.size, what);
    }
    return text + more(r.patches.size(), r.worst);
}

std::string ridge_rows(const GeometryReport& r) {
    if (r.ridges.empty() || r.worst == 0) return {};
    std::string text = fmt::format("\n  {:<8}{:<16}{:>10}{:>13}  {}\n", "ridge", "references", "edges", "length",
                                   "turns by (degrees)");
    for (const std::size_t i : largest(r.ridges.size(), r.worst, [&](std::size_t c) { return r.ridges[c].length; })) {
        const CurveFacts& ridge = r.ridges[i];
        text += fmt::format("  {:<8}{:<16}{:>10}{:>13.6g}  {:.4g} to {:.4g}\n", i + 1, listed(ridge.references),
                            grouped(ridge.edges), ridge.length, ridge.min_turn, ridge.largest_turn);
    }
    return text + more(r.ridges.size(), r.worst);
}

std::string suspicious_rows(const GeometryReport& r) {
    std::string text;
    for (const PlacesReport& places : r.suspicious) {
        if (places.count == 0) continue;
        text += table_row("! " + places.kind, fmt::format("{}: {}", grouped(places.count), places.text));
        for (const PlaceReport& place : places.worst)
            text += fmt::format("    {} {}\n", place.text, place_of(place.at));
    }
    return "\n" + (text.empty() ? table_row("suspicious places", std::string("none")) : text);
}

std::string distance_part(const GeometryReport& r) {
    if (!r.distances) return {};
    std::string text = fmt::format("\n  {} and the boundary as it is ({})\n", r.distances->geometry,
                                   r.mesh.degree == 2 ? "curved" : "straight") +
                       distance_rows(*r.distances);
    return r.worst == 0 ? text : text + entity_rows(*r.distances, r.worst);
}

}  // namespace

std::string inspect_table(const GeometryReport& r) {
    const auto dimension = static_cast<std::size_t>(r.mesh.dimension);
    const std::string hinge = r.mesh.dimension == 2 ? "vertices" : "edges";
    return mesh_rows(r) + hinge_rows(r.open, hinge + " of one facet (open)", dimension) +
           hinge_rows(r.crowded, hinge + " of more than two facets", dimension) +
           hinge_rows(r.turned, "! facets turned to other sides", dimension) + (r.cad ? cad_rows(*r.cad) : "") +
           patch_rows(r) + ridge_rows(r) + suspicious_rows(r) + distance_part(r);
}

namespace {

using Json = nlohmann::ordered_json;

/// Of the worst entity this way; none of one that was not measured.
const EntityReport* worst_of(const DistancesReport& report, OneWayReport EntityReport::* way) {
    const EntityReport* worst = nullptr;
    for (const EntityReport& entity : report.entities)
        if ((entity.*way).samples > 0 && (!worst || (entity.*way).largest > (worst->*way).largest)) worst = &entity;
    return worst;
}

std::string one_way(const OneWayReport& way, const EntityReport* worst) {
    if (way.samples == 0) return "not measured: it has no surface";
    std::string text = fmt::format("largest {:.4g}, mean {:.4g}", way.largest, way.mean);
    if (worst) text += fmt::format(" (worst: {})", worst->name);
    return text;
}

std::string cell(const OneWayReport& way) {
    return way.samples == 0 ? fmt::format("{:>11}{:>11}", "-", "-")
                            : fmt::format("{:>11.4g}{:>11.4g}", way.largest, way.mean);
}

}  // namespace

namespace {

OneWayReport one_way_of(const Json& j) {
    OneWayReport way;
    way.samples = j.value("samples", std::size_t{0});
    way.largest = j.value("largest", 0.0);
    way.mean = j.value("mean", 0.0);
    way.from = j.value("from", std::vector<double>{});
    way.to = j.value("to", std::vector<double>{});
    way.facet = j.value("facet", std::size_t{0});
    return way;
}

EntityReport entity_of(const Json& j) {
    EntityReport entity;
    entity.kind = j.value("kind", std::string());
    entity.number = j.value("number", std::size_t{0});
    entity.sides = j.value("sides", std::vector<std::size_t>{});
    entity.beside = j.value("side_geometries", std::vector<std::string>{});
    entity.is_flat = j.value("flat", false);
    entity.references = j.value("references", std::vector<Reference>{});
    entity.pieces = j.value("pieces", std::size_t{0});
    entity.measure = j.value("measure", 0.0);
    entity.to_geometry = one_way_of(j.at("to_geometry"));
    entity.to_boundary = one_way_of(j.at("to_boundary"));
    entity.name = name_of(entity);
    return entity;
}

}  // namespace

std::optional<DistancesReport> distances_of_json(std::string_view json) {
    try {
        const Json j = Json::parse(json);
        DistancesReport report{{}, one_way_of(j.at("to_geometry")), one_way_of(j.at("to_boundary")), {}};
        for (const Json& entity : j.at("entities")) report.entities.push_back(entity_of(entity));
        return report;
    } catch (const Json::exception&) {
        return {};
    }
}

std::vector<const EntityReport*> farthest_first(const DistancesReport& report) {
    std::vector<const EntityReport*> order;
    order.reserve(report.entities.size());
    for (const EntityReport& entity : report.entities) order.push_back(&entity);
    const auto larger = [](const EntityReport* e) { return std::max(e->to_geometry.largest, e->to_boundary.largest); };
    std::stable_sort(order.begin(), order.end(),
                     [&](const EntityReport* a, const EntityReport* b) { return larger(a) > larger(b); });
    return order;
}

std::string distance_rows(const DistancesReport& report) {
    return table_row("from the boundary to it",
                     one_way(report.to_geometry, worst_of(report, &EntityReport::to_geometry))) +
           table_row("from it to the boundary",
                     one_way(report.to_boundary, worst_of(report, &EntityReport::to_boundary)));
}

std::string entity_rows(const DistancesReport& report, std::size_t most) {
    const std::vector<const EntityReport*> order = farthest_first(report);
    std::string text =
        fmt::format("  {:<24}{:>10}{:>22}{:>22}\n  {:<24}{:>10}{:>11}{:>11}{:>11}{:>11}\n", "", "", "to the geometry",
                    "to the boundary", "the farthest first", "pieces", "largest", "mean", "largest", "mean");
    for (std::size_t i = 0; i < order.size() && i < most; ++i)
        text += fmt::format("  {:<24}{:>10}{}{}\n", order[i]->name, order[i]->pieces, cell(order[i]->to_geometry),
                            cell(order[i]->to_boundary));
    if (order.size() > most) text += fmt::format("  and {} more: --worst, or --json for all\n", order.size() - most);
    return text;
}

}  // namespace camber::run
