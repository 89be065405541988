module;
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
module camber.run;
import camber.core;
import camber.surface;
import :distances_report;
import :inspect;
import :report;
import :rows;

namespace camber::run {

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

}  // namespace camber::run
