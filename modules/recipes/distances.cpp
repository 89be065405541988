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
module camber.recipes;
import camber.core;
import camber.surface;
import camber.cad;
import camber.stages;

namespace camber::run {

namespace {

template <int D>
OneWayReport directed_report(const DirectedDistance<D>& way) {
    if (way.samples == 0) return {};
    return {way.samples,
            way.largest,
            way.mean,
            {way.from.c.begin(), way.from.c.end()},
            {way.to.c.begin(), way.to.c.end()},
            way.facet.valid() ? way.facet.index() + 1 : 0};
}

template <int D>
void add_sides(const Geometry<D>& geometry, const GeometryEntity& entity, EntityReport& report) {
    std::vector<std::string_view> kinds;
    for (const std::int64_t side : entity.sides) {
        if (side < 0) continue;
        const EntityName name = geometry->name_of_entity(GeometryEntity::surface(side));
        report.sides.push_back(name.number);
        report.beside.push_back(fmt::format("{} {}", name.kind, name.number));
        kinds.push_back(name.kind);
    }
    if (kinds.size() < 2 || kinds[0] == kinds[1]) report.beside.clear();
}

std::string name_of(const config::Geometry& geometry, const std::vector<EntityReport>& entities) {
    if (std::holds_alternative<config::Straight>(geometry)) return "straight facets";
    if (std::holds_alternative<config::Analytic>(geometry)) return "analytic surfaces";
    if (const auto* other = std::get_if<config::FilePath>(&geometry)) return "boundary of " + other->path;
    const auto* const cad = std::get_if<config::Cad>(&geometry);
    if (!cad) return "surrogate through the mesh's vertices";
    const auto has = [&](std::string_view kind) {
        return std::ranges::any_of(entities, [&](const EntityReport& e) { return e.kind == kind; });
    };
    return "CAD model " + cad->file.path + (has("surface") ? ", analytic surfaces" : "") +
           (has("patch") ? ", surrogate" : "");
}

}  // namespace

std::string name_of(const EntityReport& entity) {
    if (entity.kind == "none") return "facets without a surface";
    if (entity.number > 0) return fmt::format("{} {}", entity.kind, entity.number);
    if (!entity.beside.empty()) return fmt::format("{} between {}", entity.kind, fmt::join(entity.beside, " and "));
    return fmt::format("{} between {}", entity.kind, fmt::join(entity.sides, " and "));
}

template <int D>
DistancesReport distances_report(const GeometryDistances<D>& distances, const Geometry<D>& geometry,
                                 const config::Geometry& config) {
    DistancesReport report{{}, directed_report(distances.to_geometry), directed_report(distances.to_boundary), {}};
    report.entities.reserve(distances.entities.size());
    for (const EntityDistances<D>& of : distances.entities) {
        EntityReport entity;
        const EntityName name = geometry->name_of_entity(of.entity);
        entity.kind = name.kind;
        entity.number = name.number;
        add_sides(geometry, of.entity, entity);
        entity.name = name_of(entity);
        entity.is_flat = of.is_flat;
        entity.references = of.references;
        entity.pieces = of.pieces;
        entity.measure = of.measure;
        entity.to_geometry = directed_report(of.to_geometry);
        entity.to_boundary = directed_report(of.to_boundary);
        report.entities.push_back(std::move(entity));
    }
    report.geometry = name_of(config, report.entities);
    return report;
}

#define CAMBER_INSTANTIATE(D)                                                                     \
    template DistancesReport distances_report<D>(const GeometryDistances<D>&, const Geometry<D>&, \
                                                 const config::Geometry&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
