module;
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>
#include <fmt/format.h>
#include <fmt/ranges.h>
module camber.run;
import camber.core;
import camber.metric;
import camber.edge_optimisation;

namespace camber::run {

std::string grouped(std::size_t n) {
    std::string digits = fmt::format("{}", n);
    for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, " ");
    return digits;
}

std::string table_row(std::string_view name, const std::string& value) {
    return fmt::format("  {:<34}{}\n", name, value);
}
std::string table_row(std::string_view name, std::size_t n) { return table_row(name, grouped(n)); }

namespace {

std::string text_of_unit(const CadReport& c) {
    if (c.is_in_file_unit) return c.unit + ", as the CAD file";
    return fmt::format("{}{}; the CAD file is in {}", c.unit, c.is_unit_found ? ", found by the boundary" : "",
                       c.file_unit.empty() ? "mm" : c.file_unit);
}

/// "3 + 4 + 5, 8 + 9", the first few of each.
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

}  // namespace

std::string cad_rows(const CadReport& c) {
    std::string text =
        table_row("unit of the mesh", text_of_unit(c)) +
        table_row("CAD faces, edges, vertices met",
                  fmt::format("{} of {}, {} of {}, {} of {}", grouped(c.faces_met), grouped(c.faces),
                              grouped(c.edges_met), grouped(c.edges), grouped(c.vertices_met), grouped(c.vertices)));
    if (c.lost_faces + c.failed_entities + c.open_shells > 0)
        text += table_row("CAD faces lost, failures, open shells",
                          fmt::format("{}, {}, {}: the file may be damaged", grouped(c.lost_faces),
                                      grouped(c.failed_entities), grouped(c.open_shells)));
    if (c.analytic_facets + c.surrogate_facets > 0)
        text += table_row(
            "facets: CAD, analytic, surrogate",
            fmt::format("{}, {}, {}", grouped(c.facets), grouped(c.analytic_facets), grouped(c.surrogate_facets)));
    if (c.coincident_facets > 0) text += table_row("facets on coincident CAD faces", c.coincident_facets);
    text += table_row("doubtful facets, edges, vertices",
                      fmt::format("{} (settled {}), {}, {}", grouped(c.doubtful_facets), grouped(c.settled_facets),
                                  grouped(c.doubtful_edges), grouped(c.doubtful_vertices)));
    if (!c.joined.lists.empty())
        text += table_row(c.joined.are_edges ? "CAD edges joined smoothly" : "CAD faces joined smoothly",
                          joined_text(c.joined.lists));
    if (c.across.count > 0)
        text += table_row("facets across CAD ridges",
                          fmt::format("{}, the first is facet {} at ({:.4g})", grouped(c.across.count), c.across.first,
                                      fmt::join(c.across.place, ", ")));
    if (c.moves)
        text += table_row("vertices moved onto the CAD model",
                          fmt::format("{} (held back {}), by up to {:.4g}", grouped(c.moves->moved),
                                      grouped(c.moves->held), c.moves->largest));
    text += table_row("vertices off the CAD model by", fmt::format("{:.4g}", c.largest_vertex_distance));
    if (c.largest_node_distance)
        text += table_row("nodes off the CAD model by", fmt::format("{:.4g}", *c.largest_node_distance));
    return text;
}

namespace {

std::string join_before_after(double before, const double* after, std::string_view format) {
    std::string text = fmt::format(fmt::runtime(format), before);
    if (after != nullptr && *after != before) text += " -> " + fmt::format(fmt::runtime(format), *after);
    return text;
}

/// The option's word for a metric, with the field's beside it.
std::string name_metric(const std::string& source) { return source == "natural" ? "natural (mesh-implied)" : source; }

std::string mesh_rows(const Report& report) {
    const MeshReport& m = report.mesh;
    std::string text = table_row("dimension, degree", fmt::format("{}D, P{}", m.dimension, m.degree)) +
                       table_row("vertices", m.vertices);
    if (m.is_surface_alone())
        text += table_row("triangles, a surface alone", m.facets);
    else
        text += table_row(m.dimension == 2 ? "triangles" : "tetrahedra", m.elements) +
                table_row(m.dimension == 2 ? "boundary edges" : "boundary triangles", m.facets);
    if (report.reordered)
        text += table_row("order of vertices and elements",
                          fmt::format("scattered ({:.2g}): another while working", report.reordered->scatter));
    if (report.solution_metric) text += solution_metric_row(*report.solution_metric);
    if (report.metric) {
        text += table_row("metric", name_metric(report.metric->source)) +
                table_row("largest anisotropy", fmt::format("{:.4g}", report.metric->largest_anisotropy)) +
                table_row("complexity", fmt::format("{:.6g}", report.metric->complexity));
        for (const GradationReport& g : report.metric->gradations)
            text += table_row("gradation: sweeps, vertices", fmt::format("{}, {}", g.sweeps, grouped(g.changed)));
        if (report.metric->floored > 0) text += table_row("metrics raised from rounding", report.metric->floored);
    }
    return text;
}

std::string remesh_rows(const RemeshReport& r) {
    const auto changed = [](std::size_t before, std::size_t after) {
        return grouped(before) + " -> " + grouped(after);
    };
    const auto share = [](const UnitMeshReport& u) {
        return u.edges == 0 ? 100.0 : 100 * static_cast<double>(u.unit_edges) / static_cast<double>(u.edges);
    };
    std::string text =
        table_row("edges of the mesh", changed(r.before.edges, r.after.edges)) +
        table_row("edges of unit length", fmt::format("{:.2f} % -> {:.2f} %", share(r.before), share(r.after))) +
        table_row("edge lengths", fmt::format("{:.4g} to {:.4g}, mean {:.4g}", r.after.shortest, r.after.longest,
                                              r.after.mean_length)) +
        table_row("mean quality in the metric",
                  fmt::format("{:.4g} -> {:.4g}", r.before.mean_quality, r.after.mean_quality)) +
        table_row("smallest quality in the metric",
                  fmt::format("{:.4g} -> {:.4g}", r.before.worst_quality, r.after.worst_quality));
    if (r.nodes) text += table_row("inner nodes", "for " + r.nodes->objective);
    if (const auto& b = r.bounded_facets)
        text += table_row("facets at the geometry's bound",
                          fmt::format("{} finer than the metric requests, {} farther as before", grouped(b->limited),
                                      grouped(b->far)));
    for (const PassReport& p : r.passes)
        text += table_row(p.pass + ": accepted, of planned",
                          fmt::format("{}, {} ({} a second)", grouped(p.accepted), grouped(p.planned),
                                      grouped(static_cast<std::size_t>(static_cast<double>(p.accepted) /
                                                                       (p.seconds > 1e-9 ? p.seconds : 1e-9)))));
    return text;
}

/// Of how many, where lengths are not those of all.
std::string longer_edges(const EdgeReport& edges, std::size_t volume_edges) {
    if (edges.measured == volume_edges) return grouped(edges.longer);
    return fmt::format("{} of {} measured", grouped(edges.longer), grouped(edges.measured));
}

/// Of a surface alone: there is nothing inside of which edges could be short.
std::string surface_curve_rows(const CurveReport& c) {
    const EdgeReport* after = c.after ? &*c.after : nullptr;
    const auto pick = [&](double EdgeReport::* field) { return after == nullptr ? nullptr : &(after->*field); };
    return table_row("edges (curved)", fmt::format("{} ({})", grouped(c.edges), grouped(c.curved_edges))) +
           table_row("mean curvature",
                     join_before_after(c.before.mean_curvature, pick(&EdgeReport::mean_curvature), "{:.4f}")) +
           table_row("largest curvature",
                     join_before_after(c.before.largest_curvature, pick(&EdgeReport::largest_curvature), "{:.4f}"));
}

std::string nodes_by_row(const NodesByReport& by) {
    const bool is_natural = by.metric_kind == word_of(MetricKind::natural);
    std::string text = fmt::format(
        "{} by walls, {} by the metric ({})", grouped(by.walls), grouped(by.metric),
        is_natural ? "the mesh's own" : fmt::format("{}, size_share {:.3g}", by.metric_kind, by.size_share));
    if (is_natural) text += fmt::format(", {} held back for smooth functions", grouped(by.held_back));
    return table_row("inner nodes moved", text);
}

std::string curve_rows(const CurveReport& c) {
    const EdgeReport* after = c.after ? &*c.after : nullptr;
    const auto pick = [&](double EdgeReport::* field) { return after == nullptr ? nullptr : &(after->*field); };
    std::string text =
        table_row("edges", c.edges) +
        table_row("volume edges (curved)", fmt::format("{} ({})", grouped(c.volume_edges), grouped(c.curved_edges))) +
        table_row("mean length reduction", join_before_after(c.before.mean_length_reduction,
                                                             pick(&EdgeReport::mean_length_reduction), "{:.5f}")) +
        (c.in_straight_field
             ? table_row("  in the straight field", fmt::format("{:.5f}", c.in_straight_field->mean_length_reduction))
             : std::string()) +
        table_row("largest length reduction",
                  join_before_after(c.before.largest_length_reduction, pick(&EdgeReport::largest_length_reduction),
                                    "{:.4f}")) +
        table_row("mean curvature",
                  join_before_after(c.before.mean_curvature, pick(&EdgeReport::mean_curvature), "{:.4f}")) +
        table_row("largest curvature",
                  join_before_after(c.before.largest_curvature, pick(&EdgeReport::largest_curvature), "{:.4f}")) +
        table_row("edges longer than straight", longer_edges(after == nullptr ? c.before : *after, c.volume_edges)) +
        table_row("edges per second", grouped(static_cast<std::size_t>(c.edges_per_second)));
    if (c.by) text += nodes_by_row(*c.by);
    if (c.expected)
        text += table_row("expected error of the solution",
                          fmt::format("{:.3g} by shape, {:.3g} in {} rounds", c.expected->before, c.expected->after,
                                      c.expected->rounds));
    if (c.drawn_back > 0) text += table_row("nodes drawn back", c.drawn_back);
    if (c.outside > 0) text += table_row("edges that leave the back mesh", c.outside);
    if (c.lost > 0) text += table_row("edges with samples not located", c.lost);
    return text;
}

std::string validity_rows(const Report& report) {
    std::string text;
    if (!report.validity) return text;
    const ValidityReport& before = report.validity_before ? *report.validity_before : *report.validity;
    const ValidityReport& v = *report.validity;
    const bool changed = report.relax.has_value();
    const auto counts = [&](std::size_t was, std::size_t is) {
        return changed && was != is ? grouped(was) + " -> " + grouped(is) : grouped(is);
    };
    const auto smallest = [](const ValidityReport& of) {
        return scaled_jacobian_text(of.smallest, of.invalid == 0 && of.undecided == 0);
    };
    const std::string_view judged = report.mesh.is_surface_alone() ? "triangles" : "elements";
    text +=
        table_row(fmt::format("invalid {}", judged), counts(before.invalid, v.invalid)) +
        table_row(fmt::format("undecided {}", judged), counts(before.undecided, v.undecided)) +
        (v.bound > 0 ? table_row(fmt::format("{} below {:g}{}", judged, v.bound, v.is_asked ? "" : " (recommended)"),
                                 counts(before.below_bound, v.below_bound))
                     : std::string()) +
        table_row("smallest scaled Jacobian",
                  v.worst == 0 && report.mesh.is_surface_alone()
                      ? std::string("none: all flat")
                      : smallest(before) + (changed && v.smallest != before.smallest ? " -> " + smallest(v) : "") +
                            " (1: as straight)");
    if (v.straight_inverted > 0) text += table_row("inverted or flat when straight", v.straight_inverted);
    if (const auto& r = report.relax)
        text +=
            table_row(fmt::format("corrected {}", judged), r->corrected_elements) +
            (r->raised_elements > 0 ? table_row(fmt::format("raised {}", judged), r->raised_elements) : std::string()) +
            (report.mesh.is_surface_alone() ? std::string()
                                            : table_row("relaxed volume edges", r->relaxed_volume_edges)) +
            table_row("relaxed surface edges", r->relaxed_surface_edges) +
            (r->slid_surface_edges > 0 ? table_row("surface edges slid on geometry", r->slid_surface_edges)
                                       : std::string()) +
            (r->moved_vertices > 0 ? table_row("moved vertices", r->moved_vertices) : std::string()) +
            (r->slid_vertices > 0 ? table_row("of these slid on geometry", r->slid_vertices) : std::string()) +
            (r->given_up > 0 ? table_row("given up (work is spent)", r->given_up) : std::string());
    if (const auto& r = report.reinsert)
        text += table_row("cavities committed (sweeps)", fmt::format("{} ({})", grouped(r->patches), r->sweeps));
    return text;
}

std::string kept_boundary_rows(const Report& report) {
    const KeptBoundaryReport& k = *report.kept_boundary;
    std::string moved = fmt::format("{} (tolerance {:g})", grouped(k.moved_nodes), k.tolerance);
    if (k.moved_nodes > 0)
        moved += fmt::format(", by at most {:.4g}, {:.4g} of the edge", k.largest_shift, k.largest_relative_shift);
    return table_row("moved boundary nodes", moved);
}

std::string remaining_rows(const Report& report) {
    std::string text;
    constexpr std::size_t shown = 10;
    for (std::size_t i = 0; i < report.remaining.size() && i < shown; ++i)
        text += fmt::format("  ! {} {}: {}\n",
                            report.mesh.dimension == 2 || report.mesh.is_surface_alone() ? "triangle" : "tetrahedron",
                            called(report.remaining[i].element, report.remaining[i].tag), report.remaining[i].reason);
    if (report.remaining.size() > shown)
        text += fmt::format("  ! and {} more, all of them in the report\n", report.remaining.size() - shown);
    return text;
}

/// The surfaces that the distance is from: those that the nodes were put on, and not what a CAD model may have been.
std::string_view name_distance(const Report& report) {
    const std::string_view geometry = report.origin ? report.origin->geometry : std::string_view();
    if (geometry == "surrogate") return "largest distance to surrogate";
    if (geometry == "straight") return "largest distance to facets";
    const auto& cad = report.boundary->cad;
    if (cad && cad->analytic_facets + cad->surrogate_facets > 0) return "largest distance to geometry";
    if (geometry == "cad") return "largest distance to CAD model";
    if (geometry == "mesh") return "largest distance to its mesh";
    if (geometry == "analytic") return "largest distance to surfaces";
    return "largest distance to geometry";
}

/// "(0.5, 0.25, 1)".
std::string place_text(const ReportedPlace& place) {
    std::string text;
    for (const double x : place) text += (text.empty() ? "" : ", ") + fmt::format("{:.4g}", x);
    return "(" + text + ")";
}

std::string boundary_rows(const Report& report) {
    const BoundaryReport& b = *report.boundary;
    std::string text =
        table_row("surface edges, ridges, corners",
                  fmt::format("{}, {}, {}", grouped(b.surface_edges), grouped(b.ridge_edges), grouped(b.corners)));
    if (b.cad) text += cad_rows(*b.cad);
    if (const auto& of = b.curved_patches)
        text += table_row("patches through the nodes, as read",
                          fmt::format("{}, {}; angles of {:.2g} degrees at most", grouped(of->smooth),
                                      grouped(of->as_read), of->largest_angle));
    if (b.off_surfaces && b.off_surfaces->vertices > 0)
        text +=
            table_row("vertices off analytic surfaces",
                      fmt::format("{}, by up to {:.4g}", grouped(b.off_surfaces->vertices), b.off_surfaces->largest));
    if (b.nodes)
        text += table_row("boundary nodes by " + b.nodes->by,
                          fmt::format("{} of {}, fell back {}, mean reduction {:.4g}", grouped(b.nodes->placed),
                                      grouped(b.nodes->edges), grouped(b.nodes->off + b.nodes->far + b.nodes->elements),
                                      b.nodes->mean_reduction));
    if (b.straight_distance && b.curved_distance)
        text +=
            table_row(name_distance(report), join_before_after(*b.straight_distance, &*b.curved_distance, "{:.4g}"));
    if (b.geometry_error)
        text += table_row("geometry error", fmt::format("{:.4g} reached, {:.4g} required", b.geometry_error->reached,
                                                        b.geometry_error->required));
    if (b.distances) text += table_row("geometry, both ways", b.distances->geometry) + distance_rows(*b.distances);
    if (b.node_deviation) text += deviation_row("nodes off the geometry", *b.node_deviation);
    if (b.vertex_deviation) text += deviation_row("vertices off the geometry", *b.vertex_deviation);
    if (b.walls) text += walls_rows(*b.walls);
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

std::string crossing_message(const WallsReport& walls, int dimension) {
    if (walls.crossing == 0) return {};
    const bool is_one = walls.crossing == 1;
    std::string text = fmt::format("{} {} of boundary {} {} through each other (the first: {} and {}, near {})",
                                   walls.crossing, is_one ? "pair" : "pairs", dimension == 2 ? "edges" : "triangles",
                                   is_one ? "passes" : "pass", walls.first, walls.other, place_text(walls.first_at));
    if (walls.crossing_before > 0)
        text += fmt::format("; {} crossed in the input already: correct the input there", walls.crossing_before);
    return text;
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

std::string overlap_message(const Report& report) {
    const OverlappingReport& o = report.overlaps;
    if (o.overlapping == 0) return {};
    std::string at;
    for (const double x : o.point) at += (at.empty() ? "" : ", ") + fmt::format("{:.6g}", x);
    return fmt::format(
        "elements overlap in {} {}, one at ({}): cut one body out of the other, or remove a copy "
        "(camber check lists them)",
        grouped(o.overlapping), o.overlapping == 1 ? "place" : "places", at);
}

std::string sentence_of(const GeometryErrorReport& g) {
    return fmt::format(
        "the boundary is {:.4g} from its geometry, and {:.4g} is required: {} facets are farther, the "
        "farthest is facet {} at ({:.6g}); a smaller size there (--metric, --size) may reach it",
        g.reached, g.required, grouped(g.far_facets), g.facet, fmt::join(g.at, ", "));
}

std::string table(const Report& report) {
    std::string text = mesh_rows(report);
    if (report.remesh) text += remesh_rows(*report.remesh);
    if (report.boundary) text += boundary_rows(report);
    if (report.curve)
        text += report.mesh.is_surface_alone() ? surface_curve_rows(*report.curve) : curve_rows(*report.curve);
    text += validity_rows(report);
    if (report.kept_boundary) text += kept_boundary_rows(report);
    text += remaining_rows(report);
    if (report.transfer) text += carried_rows(*report.transfer);
    if (!report.times.empty()) text += time_rows(report);
    return text;
}

}  // namespace camber::run
