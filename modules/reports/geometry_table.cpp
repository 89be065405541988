// Tables of a boundary, of its geometry, and of file contents
module;
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
module camber.reports;
import camber.core;
import camber.recipes;
import :json;

namespace camber::run {

namespace {

std::string listed(const auto& items) {
    constexpr std::size_t shown = 6;
    if (items.size() <= shown) return fmt::format("{}", fmt::join(items, ","));
    return fmt::format("{},…", fmt::join(items.begin(), items.begin() + shown, ","));
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
    if (r.isolated_facets > 0) text += table_row("! without elements", r.isolated_facets);
    text += table_row(flat ? "smooth curves" : "patches", r.patches.size());
    if (!flat) text += table_row("ridges", r.ridges.size());
    text += table_row("corners", r.corners.size());
    if (r.smooth_listed_edges > 0) text += table_row("listed edges, not ridges", r.smooth_listed_edges);
    return text;
}

/// `hinge`: the word for an item, "edge" or "vertex".
std::string hinge_rows(const HingesReport& hinges, const std::string& name, std::string_view hinge) {
    if (hinges.count == 0) return {};
    std::string text = table_row(name, hinges.count);
    for (const HingeReport& at : hinges.first)
        text += fmt::format("    {} {} {}\n", hinge, fmt::join(at.vertices, "-"), place_of(at));
    return text;
}

template <class Item>
std::vector<const Item*> by_size(const std::vector<Item>& items, auto&& size) {
    std::vector<const Item*> order;
    order.reserve(items.size());
    for (const Item& item : items) order.push_back(&item);
    std::ranges::stable_sort(order, std::greater(), [&](const Item* item) { return std::invoke(size, *item); });
    return order;
}

std::string rows_of_first(const auto& items, std::size_t most, auto&& row) {
    std::string text;
    for (std::size_t i = 0; i < std::min(most, items.size()); ++i) text += row(*items[i]);
    if (items.size() > most) text += fmt::format("  and {} more: --worst, or --json for all\n", items.size() - most);
    return text;
}

std::string patch_rows(const GeometryReport& r) {
    if (r.patches.empty() || r.worst == 0) return {};
    const bool flat = r.mesh.dimension == 2;
    return fmt::format("\n  {:<8}{:<16}{:>10}{:>13}{:>13}  {}{}\n", flat ? "curve" : "patch", "references",
                       flat ? "edges" : "triangles", flat ? "length" : "area", "size", "what",
                       !r.cad ? ""
                       : flat ? ", CAD edges"
                              : ", CAD faces") +
           rows_of_first(by_size(r.patches, &PatchReport::area), r.worst, [&](const PatchReport& patch) {
               std::string what = patch.is_flat ? (flat ? "straight" : "flat") : "curved";
               if (patch.interface_facets == patch.facets) what += ", interface";
               if (const auto& on = flat ? patch.cad_edges : patch.cad_faces; on && !on->empty())
                   what += ", " + listed(*on);
               return fmt::format("  {:<8}{:<16}{:>10}{:>13.6g}{:>13.6g}  {}\n", patch.number, listed(patch.references),
                                  grouped(patch.facets), patch.area, patch.size, what);
           });
}

std::string ridge_rows(const GeometryReport& r) {
    if (r.ridges.empty() || r.worst == 0) return {};
    return fmt::format("\n  {:<8}{:<16}{:>10}{:>13}  {}\n", "ridge", "references", "edges", "length",
                       "turns by (degrees)") +
           rows_of_first(by_size(r.ridges, &RidgeReport::length), r.worst, [](const RidgeReport& ridge) {
               return fmt::format("  {:<8}{:<16}{:>10}{:>13.6g}  {:.4g} to {:.4g}\n", ridge.number,
                                  listed(ridge.references), grouped(ridge.edges), ridge.length, ridge.min_turn,
                                  ridge.largest_turn);
           });
}

std::string warning_rows(const GeometryReport& r) {
    std::string text;
    for (const auto& [kind, places] : r.warnings) {
        if (places.count == 0) continue;
        text += table_row("! " + kind, fmt::format("{}: {}", grouped(places.count), places.text));
        for (const PlaceReport& place : places.worst)
            text += fmt::format("    {} {}\n", place.text, place_of(place.at));
    }
    return "\n" + (text.empty() ? table_row("suspicious places", std::string("none")) : text);
}

std::string distance_part(const GeometryReport& r) {
    if (!r.distances) return {};
    return fmt::format("\n  {} and the {} boundary\n", r.distances->geometry,
                       r.mesh.degree == 2 ? "curved" : "straight") +
           distance_rows(*r.distances) + (r.worst == 0 ? std::string() : entity_rows(*r.distances, r.worst));
}

/// Largest and mean distance, and the entity with the largest one, either from the mesh to the geometry or from the
/// geometry to the mesh. `way`: the member for this direction.
std::string one_way_text(const DistancesReport& report, const OneWayReport& all, OneWayReport EntityReport::* way) {
    if (all.samples == 0) return "not measured: it has no surface";
    std::string text = fmt::format("largest {:.4g}, mean {:.4g}", all.largest, all.mean);
    const EntityReport* worst = nullptr;
    for (const EntityReport& entity : report.entities)
        if ((entity.*way).samples > 0 && (!worst || (entity.*way).largest > (worst->*way).largest)) worst = &entity;
    return worst ? text + fmt::format(" (worst: {})", worst->name) : text;
}

std::string cells(const OneWayReport& way) {
    return way.samples == 0 ? fmt::format("{:>11}{:>11}", "-", "-")
                            : fmt::format("{:>11.4g}{:>11.4g}", way.largest, way.mean);
}

}  // namespace

std::string inspect_table(const GeometryReport& r) {
    const bool flat = r.mesh.dimension == 2;
    const std::string hinge = flat ? "vertex" : "edge", hinges = flat ? "vertices" : "edges";
    return mesh_rows(r) + hinge_rows(r.open, hinges + " of one facet (open)", hinge) +
           hinge_rows(r.crowded, hinges + " of more than two facets", hinge) +
           hinge_rows(r.turned, "! misoriented facets", hinge) + (r.cad ? cad_rows(*r.cad) : "") + patch_rows(r) +
           ridge_rows(r) + warning_rows(r) + distance_part(r);
}

std::vector<const EntityReport*> farthest_first(const DistancesReport& report) {
    return by_size(report.entities,
                   [](const EntityReport& e) { return std::max(e.to_geometry.largest, e.to_boundary.largest); });
}

std::string distance_rows(const DistancesReport& report) {
    return table_row("boundary to geometry", one_way_text(report, report.to_geometry, &EntityReport::to_geometry)) +
           table_row("geometry to boundary", one_way_text(report, report.to_boundary, &EntityReport::to_boundary));
}

std::string entity_rows(const DistancesReport& report, std::size_t most) {
    return fmt::format("  {:<24}{:>10}{:>22}{:>22}\n  {:<24}{:>10}{:>11}{:>11}{:>11}{:>11}\n", "", "",
                       "to the geometry", "to the boundary", "farthest first", "pieces", "largest", "mean", "largest",
                       "mean") +
           rows_of_first(farthest_first(report), most, [](const EntityReport& entity) {
               return fmt::format("  {:<24}{:>10}{}{}\n", entity.name, entity.pieces, cells(entity.to_geometry),
                                  cells(entity.to_boundary));
           });
}

namespace {

/// "1 inlet: 170, 2 wall: 734".
std::string counts_text(std::string_view key, const ReferenceCounts& counts, const Groups& groups) {
    const int dimension = key.starts_with("edges") ? 1 : key.starts_with("triangles") ? 2 : 3;
    std::string text;
    for (const auto& [reference, count] : counts)
        text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", called(groups, dimension, reference), count);
    return text;
}

/// Writes one row for each item. Only the first row shows the key.
std::string rows_of_list(std::string_view key, const auto& items, auto&& text_of_item) {
    std::string text;
    for (const auto& item : items) text += short_row(text.empty() ? key : "", text_of_item(item));
    return text;
}

std::string row_of(std::string_view key, const Json& value) {
    if ((value.is_number() && value == 0) || (value.is_structured() && value.empty()) || value == false) return {};
    return short_row(
        key, value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, Json::error_handler_t::replace));
}

template <class Info>
std::string rows_of(const Info& info, const Groups& groups) {
    std::string text;
    each_shown_field(info, Reported::volume, [&](const auto& field, const auto& value) {
        using T = std::remove_cvref_t<decltype(value)>;
        if constexpr (std::same_as<T, ReferenceCounts>)
            text += value.empty() ? std::string() : short_row(field.key, counts_text(field.key, value, groups));
        else if constexpr (std::same_as<T, Groups>)
            text += rows_of_list(field.key, value, [](const Group& group) {
                return fmt::format("{}D {} {}", group.dimension, group.reference, group.name);
            });
        else if constexpr (std::same_as<T, std::vector<std::string>>)
            text += rows_of_list(field.key, value, [](const std::string& notice) { return notice; });
        else
            text += row_of(field.key, json_of(value));
    });
    return text;
}

}  // namespace

std::string info_json(const FileInfo& info) {
    const Json json = std::visit([](const auto& i) { return json_of(i); }, info);
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string info_table(const FileInfo& info) {
    const auto* const mesh = std::get_if<MeshInfo>(&info);
    return std::visit([&](const auto& i) { return rows_of(i, mesh ? mesh->groups : Groups()); }, info);
}

}  // namespace camber::run
