module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
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

/// In 2D surfaces are curves.
std::string kind_of(GeometryKind kind, GeometryMaker maker, int dimension) {
    const bool is_surface = kind == GeometryKind::surface;
    if (!is_surface && kind != GeometryKind::curve) return "none";
    if (dimension == 2) return "curve";
    switch (maker) {
        case GeometryMaker::cad: return is_surface ? "face" : "edge";
        case GeometryMaker::surrogate: return is_surface ? "patch" : "ridge";
        default: return is_surface ? "surface" : "curve";
    }
}

std::size_t number_of(std::int64_t id) { return id < 0 ? 0 : static_cast<std::size_t>(id) + 1; }

std::string name_of(const EntityReport& entity) {
    if (entity.kind == "none") return "facets without a surface";
    if (entity.number > 0) return fmt::format("{} {}", entity.kind, entity.number);
    return fmt::format("{} between {}", entity.kind, fmt::join(entity.sides, " and "));
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

GeometryMaker maker_of(const config::Geometry& geometry) {
    if (std::holds_alternative<config::Straight>(geometry)) return GeometryMaker::straight;
    if (std::holds_alternative<config::Analytic>(geometry)) return GeometryMaker::analytic;
    if (std::holds_alternative<config::Cad>(geometry)) return GeometryMaker::cad;
    return GeometryMaker::surrogate;
}

std::string name_of(const config::Geometry& geometry) {
    if (const auto* cad = std::get_if<config::Cad>(&geometry)) return "CAD model " + cad->file.path;
    switch (maker_of(geometry)) {
        case GeometryMaker::straight: return "straight facets";
        case GeometryMaker::analytic: return "analytic surfaces";
        default: return "surrogate of the mesh's own vertices";
    }
}

std::size_t samples_for(std::size_t facets) {
    constexpr std::size_t a_facet = 16, least = 4096, most = 4000000;
    return std::clamp(a_facet * facets, least, most);
}

template <int D>
DistancesReport distances_report(const GeometryDistances<D>& distances, GeometryMaker maker, std::string geometry) {
    DistancesReport report{std::move(geometry), told(distances.to_geometry), told(distances.to_boundary), {}};
    report.entities.reserve(distances.entities.size());
    for (const EntityDistances<D>& of : distances.entities) {
        EntityReport entity;
        entity.kind = kind_of(of.entity.kind, maker, D);
        entity.number = number_of(of.entity.id);
        for (const std::int64_t side : of.entity.sides)
            if (side >= 0) entity.sides.push_back(number_of(side));
        entity.name = name_of(entity);
        entity.is_flat = of.is_flat;
        entity.references = of.references;
        entity.pieces = of.pieces;
        entity.measure = of.measure;
        entity.to_geometry = told(of.to_geometry);
        entity.to_boundary = told(of.to_boundary);
        report.entities.push_back(std::move(entity));
    }
    return report;
}

std::string distances_json(const DistancesReport& report) {
    Json j{{"to_geometry", json(report.to_geometry)}, {"to_boundary", json(report.to_boundary)}};
    Json entities = Json::array();
    for (const EntityReport& e : report.entities) {
        Json entity{{"kind", e.kind}, {"number", e.number}};
        if (!e.sides.empty()) entity["sides"] = e.sides;
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

template DistancesReport distances_report<2>(const GeometryDistances<2>&, GeometryMaker, std::string);
template DistancesReport distances_report<3>(const GeometryDistances<3>&, GeometryMaker, std::string);

}  // namespace camber::run
