module;
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>
#include <fmt/format.h>
#include <fmt/ranges.h>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.metric;
import camber.edge_optimisation;
import camber.transfer;
import :json;

namespace camber::run {

std::string table_row(std::string_view name, const std::string& value) {
    return fmt::format("  {:<34}{}\n", name, value);
}
std::string table_row(std::string_view name, std::size_t n) { return table_row(name, grouped(n)); }
std::string short_row(std::string_view name, std::string_view value) {
    return fmt::format("  {:<26}{}\n", name, value);
}

namespace {

std::string text_of_unit(const CadReport& c) {
    if (c.is_in_file_unit) return c.mesh_unit + ", as the CAD file";
    return fmt::format("{}{}; the CAD file is in {}", c.mesh_unit,
                       c.is_unit_found ? ", detected from the boundary" : "", c.file_unit.empty() ? "mm" : c.file_unit);
}

/// Formats lists as "3 + 4 + 5, 8 + 9", shortened.
std::string joined_text(const std::vector<std::vector<std::size_t>>& lists) {
    constexpr std::size_t most_lists = 6, most_faces = 8;
    std::string text;
    for (std::size_t i = 0; i < lists.size() && i < most_lists; ++i) {
        const std::size_t shown = lists[i].size() < most_faces ? lists[i].size() : most_faces;
        text += (i > 0 ? ", " : "") + fmt::format("{}", fmt::join(std::span(lists[i]).first(shown), " + "));
        if (shown < lists[i].size()) text += fmt::format(" + {} more", lists[i].size() - shown);
    }
    if (lists.size() > most_lists) text += fmt::format(" and {} more groups", lists.size() - most_lists);
    return text;
}

std::string damage_row(const CadReport& c) {
    if (c.lost_faces + c.failed_entities + c.open_shells == 0) return {};
    return table_row("CAD faces failed",
                     fmt::format("{}, failed entities {}, open shells {}: the file may be damaged",
                                 grouped(c.lost_faces), grouped(c.failed_entities), grouped(c.open_shells)));
}

std::string across_row(const CadReport& c) {
    if (c.across.count == 0) return {};
    return table_row("facets across CAD ridges",
                     fmt::format("{}, the first is facet {} at ({:.4g})", grouped(c.across.count), c.across.first,
                                 fmt::join(c.across.place, ", ")));
}

std::string moves_row(const CadMovesReport& moves) {
    return table_row("vertices moved onto the CAD model",
                     fmt::format("{} (partly {}), by up to {:.4g}", grouped(moves.moved), grouped(moves.constrained),
                                 moves.largest));
}

std::string cad_warning_rows(const CadReport& c) {
    return (c.is_in_file_unit ? std::string() : table_row("unit of the mesh", text_of_unit(c))) + damage_row(c) +
           across_row(c) + (c.moves && c.moves->constrained > 0 ? moves_row(*c.moves) : std::string());
}

}  // namespace

std::string cad_rows(const CadReport& c) {
    std::string text =
        table_row("unit of the mesh", text_of_unit(c)) +
        table_row("CAD faces, edges, vertices met",
                  fmt::format("{} of {}, {} of {}, {} of {}", grouped(c.faces_met), grouped(c.faces),
                              grouped(c.edges_met), grouped(c.edges), grouped(c.vertices_met), grouped(c.vertices)));
    text += damage_row(c);
    if (c.analytic_facets + c.surrogate_facets > 0)
        text += table_row(
            "facets: CAD, analytic, surrogate",
            fmt::format("{}, {}, {}", grouped(c.facets), grouped(c.analytic_facets), grouped(c.surrogate_facets)));
    if (c.coincident_facets > 0) text += table_row("facets on coincident CAD faces", c.coincident_facets);
    text += table_row("ambiguous facets", fmt::format("{} (resolved {}), edges {}, vertices {}",
                                                      grouped(c.ambiguous_facets), grouped(c.settled_facets),
                                                      grouped(c.ambiguous_edges), grouped(c.ambiguous_vertices)));
    if (!c.joined.lists.empty())
        text += table_row(c.joined.are_edges ? "CAD edges joined smoothly" : "CAD faces joined smoothly",
                          joined_text(c.joined.lists));
    text += across_row(c);
    if (c.moves) text += moves_row(*c.moves);
    text += table_row("vertices off the CAD model by", fmt::format("{:.4g}", c.largest_vertex_distance));
    if (c.largest_node_distance)
        text += table_row("nodes off the CAD model by", fmt::format("{:.4g}", *c.largest_node_distance));
    return text;
}

namespace {

std::string name_distance(const Report& report) {
    const std::string_view geometry = report.boundary->geometry;
    const auto& cad = report.boundary->cad;
    if (cad && cad->analytic_facets + cad->surrogate_facets > 0) return "distance from the geometry";
    if (geometry == "surrogate") return "distance from the surrogate";
    if (geometry == "straight") return "distance from the facets";
    if (geometry == "cad") return "distance from the CAD model";
    if (geometry == "mesh") return "distance from the other mesh";
    if (geometry == "analytic") return "distance from the surfaces";
    return "distance from the geometry";
}

std::string count_of_judged(const MeshReport& m) {
    const bool is_one = m.judged() == 1;
    const std::string_view name = m.dimension == 2 || m.is_standalone_surface() ? (is_one ? "triangle" : "triangles")
                                  : is_one                                      ? "tetrahedron"
                                                                                : "tetrahedra";
    return fmt::format("{} {}", grouped(m.judged()), name);
}

std::string validity_row(const Report& report) {
    const ValidityReport& v = *report.validity;
    if (report.has_valid_elements())
        return table_row(
            "valid", fmt::format("yes: {}{}{}", report.mesh.judged() == 1 ? "" : "all ", count_of_judged(report.mesh),
                                 v.is_explicit && v.bound > 0 ? fmt::format(", above {:g}", v.bound) : ""));
    std::string text = "NO:";
    const auto add = [&](std::size_t count, std::string_view what) {
        if (count > 0) text += fmt::format("{} {} {}", text.size() > 3 ? "," : "", grouped(count), what);
    };
    add(v.invalid, "invalid");
    add(v.undecided, "undecided");
    if (v.is_explicit) add(v.below_bound, fmt::format("below {:g}", v.bound));
    return table_row("valid", text + " of " + count_of_judged(report.mesh));
}

std::string jacobian_row(const Report& report) {
    const ValidityReport& v = *report.validity;
    if (v.worst == 0) return {};
    const auto text_of = [](const ValidityReport& of) {
        const bool is_valid = of.invalid == 0 && of.undecided == 0;
        // `smallest` is a lower bound with an error of up to 1e-3. If all elements are certified to be above `bound`,
        // then `bound` may be the better lower bound.
        const double least = is_valid && of.below_bound == 0 ? std::max(of.smallest, of.bound) : of.smallest;
        return scaled_jacobian_text(least, is_valid);
    };
    const auto& before = report.validity_before;
    const bool changed = report.relax && before && before->smallest != v.smallest;
    return table_row("smallest scaled Jacobian",
                     (changed ? text_of(*before) + " -> " : std::string()) +
                         fmt::format("{} (1: as straight), of element {}", text_of(v), called(v.worst, v.worst_tag)));
}

std::string distance_row(const Report& report) {
    const BoundaryReport& b = *report.boundary;
    if (!b.straight_distance || !b.curved_distance) return {};
    std::string text = fmt::format("{:.4g}", *b.straight_distance);
    if (*b.curved_distance != *b.straight_distance) text += fmt::format(" -> {:.4g}", *b.curved_distance);
    if (*b.curved_distance > 0 && !b.curved_distance_near.empty())
        text += ", near " + place_text(b.curved_distance_near);
    return table_row(name_distance(report), text);
}

std::string deviation_row(const char* name, const DeviationReport& d) {
    if (d.off == 0) return {};
    return table_row(name, fmt::format("{} of {}, by up to {:.4g} ({:.2g} of the edge)", grouped(d.off),
                                       grouped(d.measured), d.largest, d.share));
}

std::string walls_rows(const WallsReport& walls) {
    std::string text;
    if (walls.crossing + walls.touching + walls.undecided > 0)
        text += table_row("pairs of facets that cross",
                          fmt::format("{}, touching {}, undecided {}", grouped(walls.crossing), grouped(walls.touching),
                                      grouped(walls.undecided)));
    if (walls.relaxed)
        text += table_row(
            "boundary nodes moved back",
            fmt::format("{}, by up to {:.4g} near {}: boundary facets would cross", grouped(walls.relaxed->nodes),
                        walls.relaxed->largest, place_text(walls.relaxed->largest_at)));
    return text;
}

std::string boundary_rows(const Report& report) {
    const BoundaryReport& b = *report.boundary;
    std::string text = distance_row(report);
    if (b.cad) text += cad_warning_rows(*b.cad);
    if (b.distances) text += table_row("geometry, both ways", b.distances->geometry) + distance_rows(*b.distances);
    if (const auto& g = b.geometry_error)
        text += table_row("distance bound", fmt::format("{:.4g} required, {:.4g} reached", g->required, g->reached));
    if (b.node_deviation) text += deviation_row("nodes off the geometry", *b.node_deviation);
    if (b.vertex_deviation) text += deviation_row("vertices off the geometry", *b.vertex_deviation);
    if (b.off_surfaces && b.off_surfaces->vertices > 0)
        text +=
            table_row("vertices off analytic surfaces",
                      fmt::format("{}, by up to {:.4g}", grouped(b.off_surfaces->vertices), b.off_surfaces->largest));
    return b.walls ? text + walls_rows(*b.walls) : text;
}

std::string overlaps_row(const OverlappingReport& o) {
    if (o.overlapping == 0) return {};
    return table_row("elements that overlap",
                     fmt::format("in {} {}, one at {}", grouped(o.overlapping), o.overlapping == 1 ? "place" : "places",
                                 place_text(o.point)));
}

std::string input_boundary_row(const InputBoundaryReport& k) {
    if (k.moved_nodes == 0) return {};
    return table_row("boundary nodes moved by repair",
                     fmt::format("{}, by up to {:.4g} ({:.2g} of the edge)", grouped(k.moved_nodes), k.largest_shift,
                                 k.largest_relative_shift));
}

std::string remesh_rows(const RemeshReport& r) {
    const auto share = [](const UnitMeshReport& u) {
        return u.edges == 0 ? 0.0 : 100 * static_cast<double>(u.unit_edges) / static_cast<double>(u.edges);
    };
    const std::size_t far = r.bounded_facets ? r.bounded_facets->far : 0;
    return table_row("edges of unit length", fmt::format("{:.1f} % -> {:.1f} %", share(r.before), share(r.after))) +
           table_row("smallest quality in the metric",
                     fmt::format("{:.3g} -> {:.3g}, of element {}", r.before.worst_quality, r.after.worst_quality,
                                 r.after.worst_element)) +
           (far > 0 ? table_row("facets beyond the default bound",
                                fmt::format("{}, as far from the geometry as the original facets", grouped(far)))
                    : std::string());
}

std::string mesh_row(const MeshReport& m) {
    std::string text = fmt::format("degree {}, {} vertices, {}", m.degree, grouped(m.vertices), count_of_judged(m));
    if (!m.is_standalone_surface())
        text += fmt::format(", {} boundary {}", grouped(m.facets), m.dimension == 2 ? "edges" : "triangles");
    return table_row("mesh", text);
}

std::string cost_row(const Report& report) {
    double seconds = 0;
    std::size_t peak = 0;
    for (const StageTime& t : report.times) {
        seconds += t.seconds;
        peak = std::max(peak, t.peak_bytes);
    }
    return table_row(
        "time, memory",
        fmt::format("{} s, {:.1f} MiB, {} {}",
                    seconds < 100 ? fmt::format("{:.3g}", seconds) : fmt::format("{:.0f}", seconds),
                    static_cast<double>(peak) / 1048576, report.threads, report.threads == 1 ? "thread" : "threads"));
}

std::string remaining_rows(const Report& report) {
    std::string text;
    constexpr std::size_t shown = 3;
    for (std::size_t i = 0; i < report.remaining.size() && i < shown; ++i)
        text +=
            fmt::format("  ! {} {}: {}\n",
                        report.mesh.dimension == 2 || report.mesh.is_standalone_surface() ? "triangle" : "tetrahedron",
                        called(report.remaining[i].element, report.remaining[i].tag), report.remaining[i].reason);
    if (report.remaining.size() > shown)
        text += fmt::format("  ! and {} more, all of them in the report (--report FILE)\n",
                            report.remaining.size() - shown);
    return text;
}

// ---------------------------------------------------------------- all fields

constexpr std::size_t shown_items = 10;

std::string title_of(std::string_view key) {
    std::string title(key);
    std::ranges::replace(title, '_', ' ');
    return title;
}

template <class T>
concept Scalar = std::is_arithmetic_v<T> || std::is_enum_v<T> || std::convertible_to<T, std::string_view>;

template <Scalar T>
std::string text_of(const T& value) {
    if constexpr (std::same_as<T, bool>)
        return value ? "yes" : "no";
    else if constexpr (std::is_enum_v<T>)
        return std::string(word_of(value));
    else if constexpr (std::is_floating_point_v<T>)
        return fmt::format("{:.6g}", value);
    else if constexpr (std::unsigned_integral<T>)
        return grouped(value);
    else
        return fmt::format("{}", value);
}

std::string row_at(std::size_t depth, std::string_view name, const std::string& value) {
    const std::string title = std::string(2 * depth + 2, ' ') + std::string(name);
    return value.empty() ? title + "\n" : fmt::format("{:<38}{}\n", title, value);
}

template <class S>
std::string rows_of_fields(const S& report, Reported of, std::size_t depth);

/// Rows of one field. Lists of numbers show their first items, lists of structs one block per item.
template <class T>
std::string rows_of(std::string_view key, std::string_view unit, const T& value, Reported of, std::size_t depth) {
    const bool is_plain = unit.empty() || unit == "1" || unit == "length";  // no unit is printed for these: lengths
                                                                            // have the unit of the mesh
    const std::string suffix = is_plain ? "" : " " + std::string(unit);
    if constexpr (Scalar<T>) {
        return row_at(depth, title_of(key), text_of(value) + suffix);
    } else if constexpr (is_optional<T>) {
        return value ? rows_of(key, unit, *value, of, depth) : std::string();
    } else if constexpr (HasFields<T>) {
        return row_at(depth, title_of(key), {}) + rows_of_fields(value, of, depth + 1);
    } else if constexpr (is_map<T>) {
        std::string text = value.empty() ? std::string() : row_at(depth, title_of(key), {});
        for (const auto& [name, item] : value) text += rows_of(name, unit, item, of, depth + 1);
        return text;
    } else if constexpr (requires { requires HasFields<typename T::value_type>; }) {
        std::string text;
        for (std::size_t i = 0; i < value.size() && i < shown_items; ++i)
            text +=
                row_at(depth, fmt::format("{} {}", title_of(key), i + 1), {}) + rows_of_fields(value[i], of, depth + 1);
        if (value.size() > shown_items)
            text += row_at(depth, title_of(key), fmt::format("{} more: --report FILE", value.size() - shown_items));
        return text;
    } else if constexpr (requires { requires Scalar<typename T::value_type>; }) {
        std::string items;
        for (std::size_t i = 0; i < value.size() && i < shown_items; ++i)
            items += (i > 0 ? ", " : "") + text_of(value[i]);
        if (value.size() > shown_items) items += fmt::format(" and {} more", value.size() - shown_items);
        return row_at(depth, title_of(key), (items.empty() ? "none" : items) + (items.empty() ? "" : suffix));
    } else if constexpr (std::same_as<T, std::vector<std::vector<std::size_t>>>) {
        return row_at(depth, title_of(key), value.empty() ? "none" : joined_text(value));
    } else {
        static_assert(std::same_as<T, std::vector<Histogram>>, "no row for a field of this type");
        return {};  // printed as bars with --histogram
    }
}

template <class S>
std::string rows_of_fields(const S& report, Reported of, std::size_t depth) {
    std::string text;
    each_shown_field(report, of, [&](const auto& field, const auto& value) {
        text += rows_of(field.key, field.unit_name, value, of, depth);
    });
    return text;
}

std::string time_rows(const Report& report) {
    std::string text = fmt::format("\n  {:<12}{:>12}{:>14}\n", "stage", "seconds", "peak MiB");
    double total = 0;
    std::size_t peak = 0;
    for (const StageTime& t : report.times) {
        text += fmt::format("  {:<12}{:>12.3f}{:>14.1f}\n", t.stage, t.seconds,
                            static_cast<double>(t.peak_bytes) / 1048576);
        total += t.seconds;
        peak = t.peak_bytes > peak ? t.peak_bytes : peak;
    }
    return text + fmt::format("  {:<12}{:>12.3f}{:>14.1f}\n", "all", total, static_cast<double>(peak) / 1048576);
}

}  // namespace

std::string scaled_jacobian_text(double least, bool is_positive) {
    return is_positive && !(least > 0) ? "> 0" : lower_bound_text(least);
}

std::string summary(const Report& report) {
    std::string text;
    if (report.validity) text += validity_row(report) + jacobian_row(report);
    text += overlaps_row(report.overlaps);
    if (report.boundary) text += boundary_rows(report);
    if (report.input_boundary) text += input_boundary_row(*report.input_boundary);
    if (report.remesh) text += remesh_rows(*report.remesh);
    text += remaining_rows(report);
    if (report.transfer) text += carried_rows(*report.transfer);
    return text + mesh_row(report.mesh) + cost_row(report);
}

std::string full_table(const Report& report) {
    const Reported of = report.mesh.is_standalone_surface() ? Reported::surface : Reported::volume;
    const std::array<std::string_view, 3> beside{"notices", "misses", "stages"};  // other functions print these fields
    std::string text;
    each_shown_field(report, of, [&](const auto& field, const auto& value) {
        if (std::ranges::find(beside, field.key) == beside.end())
            text += rows_of(field.key, field.unit_name, value, of, 0);
    });
    return text + (report.times.empty() ? std::string() : time_rows(report));
}

}  // namespace camber::run
