module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
module camber.run;
import camber.config;
import camber.core;
import camber.surface;
import :distances_report;
import :rows;

namespace camber::run {

namespace {

using Json = nlohmann::ordered_json;

template <int D>
OneWayReport told(const OneWay<D>& way) {
    if (way.samples == 0) return {};
    return {way.samples,
            way.largest,
            way.mean,
            {way.from.c.begin(), way.from.c.end()},
            {way.to.c.begin(), way.to.c.end()},
            way.facet.valid() ? way.facet.index() + 1 : 0};
}

std::string name_of(const EntityReport& entity) {
    if (entity.kind == "none") return "facets without a surface";
    if (entity.number > 0) return fmt::format("{} {}", entity.kind, entity.number);
    if (!entity.beside.empty()) return fmt::format("{} between {}", entity.kind, fmt::join(entity.beside, " and "));
    return fmt::format("{} between {}", entity.kind, fmt::join(entity.sides, " and "));
}

/// The surfaces beside a curve.
template <int D>
void tell_sides(const Geometry<D>& geometry, const GeometryEntity& entity, EntityReport& report) {
    std::vector<std::string_view> kinds;
    for (const std::int64_t side : entity.sides) {
        if (side < 0) continue;
        const EntityName name = geometry->called(GeometryEntity::surface(side));
        report.sides.push_back(name.number);
        report.beside.push_back(fmt::format("{} {}", name.kind, name.number));
        kinds.push_back(name.kind);
    }
    if (kinds.size() < 2 || kinds[0] == kinds[1]) report.beside.clear();
}

/// "CAD model wing.step", with what else the entities are of.
std::string name_of(const config::Geometry& geometry, const std::vector<EntityReport>& entities) {
    if (std::holds_alternative<config::Straight>(geometry)) return "straight facets";
    if (std::holds_alternative<config::Analytic>(geometry)) return "analytic surfaces";
    if (const auto* other = std::get_if<config::FilePath>(&geometry)) return "boundary of " + other->path;
    const auto* const cad = std::get_if<config::Cad>(&geometry);
    if (!cad) return "surrogate of the mesh's own vertices";
    const auto has = [&](std::string_view kind) {
        return std::ranges::any_of(entities, [&](const EntityReport& e) { return e.kind == kind; });
    };
    return "CAD model " + cad->file.path + (has("surface") ? ", analytic surfaces" : "") +
           (has("patch") ? ", surrogate" : "");
}

Json json(const OneWayReport& way) {
    if (way.samples == 0) return {{"samples", 0}};
    return {{"samples", way.samples}, {"largest", way.largest}, {"mean", way.mean},
            {"from", way.from},       {"to", way.to},           {"facet", way.facet}};
}

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

template <int D>
DistancesReport distances_report(const GeometryDistances<D>& distances, const Geometry<D>& geometry,
                                 const config::Geometry& config) {
    DistancesReport report{{}, told(distances.to_geometry), told(distances.to_boundary), {}};
    report.entities.reserve(distances.entities.size());
    for (const EntityDistances<D>& of : distances.entities) {
        EntityReport entity;
        const EntityName name = geometry->called(of.entity);
        entity.kind = name.kind;
        entity.number = name.number;
        tell_sides(geometry, of.entity, entity);
        entity.name = name_of(entity);
        entity.is_flat = of.is_flat;
        entity.references = of.references;
        entity.pieces = of.pieces;
        entity.measure = of.measure;
        entity.to_geometry = told(of.to_geometry);
        entity.to_boundary = told(of.to_boundary);
        report.entities.push_back(std::move(entity));
    }
    report.geometry = name_of(config, report.entities);
    return report;
}

std::string distances_json(const DistancesReport& report) {
    Json j{{"to_geometry", json(report.to_geometry)}, {"to_boundary", json(report.to_boundary)}};
    Json entities = Json::array();
    for (const EntityReport& e : report.entities) {
        Json entity{{"kind", e.kind}, {"number", e.number}};
        if (!e.sides.empty()) entity["sides"] = e.sides;
        if (!e.beside.empty()) entity["beside"] = e.beside;
        entity["flat"] = e.is_flat;
        entity["references"] = e.references;
        entity["pieces"] = e.pieces;
        entity["measure"] = e.measure;
        entity["to_geometry"] = json(e.to_geometry);
        entity["to_boundary"] = json(e.to_boundary);
        entities.push_back(std::move(entity));
    }
    j["entities"] = std::move(entities);
    return j.dump();
}

std::string distance_rows(const DistancesReport& report) {
    return table_row("from the boundary to it",
                     one_way(report.to_geometry, worst_of(report, &EntityReport::to_geometry))) +
           table_row("from it to the boundary",
                     one_way(report.to_boundary, worst_of(report, &EntityReport::to_boundary)));
}

std::string entity_rows(const DistancesReport& report, std::size_t most) {
    std::vector<const EntityReport*> order;
    order.reserve(report.entities.size());
    for (const EntityReport& entity : report.entities) order.push_back(&entity);
    const auto larger = [](const EntityReport* e) { return std::max(e->to_geometry.largest, e->to_boundary.largest); };
    std::stable_sort(order.begin(), order.end(),
                     [&](const EntityReport* a, const EntityReport* b) { return larger(a) > larger(b); });
    std::string text =
        fmt::format("  {:<24}{:>10}{:>22}{:>22}\n  {:<24}{:>10}{:>11}{:>11}{:>11}{:>11}\n", "", "", "to the geometry",
                    "to the boundary", "the farthest first", "pieces", "largest", "mean", "largest", "mean");
    for (std::size_t i = 0; i < order.size() && i < most; ++i)
        text += fmt::format("  {:<24}{:>10}{}{}\n", order[i]->name, order[i]->pieces, cell(order[i]->to_geometry),
                            cell(order[i]->to_boundary));
    if (order.size() > most) text += fmt::format("  and {} more: --worst, or --json for all\n", order.size() - most);
    return text;
}

#define CAMBER_INSTANTIATE(D)                                                                     \
    template DistancesReport distances_report<D>(const GeometryDistances<D>&, const Geometry<D>&, \
                                                 const config::Geometry&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
