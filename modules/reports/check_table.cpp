// Tables of checks
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>
#include <fmt/format.h>
#include <fmt/ranges.h>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.validity;
import camber.crossing;

namespace camber::run {

namespace {

std::string unit_mesh_rows(const UnitMeshReport& r) {
    const auto share = [&](std::size_t n) {
        return r.edges == 0 ? 0.0 : 100 * static_cast<double>(n) / static_cast<double>(r.edges);
    };
    std::string text =
        table_row("edges of unit length",
                  fmt::format("{:.2f} % of {} (1/sqrt(2) to sqrt(2)); {:.2f} % shorter, {:.2f} % longer",
                              share(r.unit_edges), grouped(r.edges), share(r.short_edges), share(r.long_edges)));
    text +=
        table_row("edge lengths", fmt::format("{:.4g} to {:.4g}, mean {:.4g}", r.shortest, r.longest, r.mean_length));
    if (r.worst_element > 0)
        text += table_row("quality in the metric", fmt::format("mean {:.4g}, smallest {:.4g}, of element {}",
                                                               r.mean_quality, r.worst_quality, r.worst_element));
    return text;
}

std::string curved_unit_mesh_rows(const CurvedUnitMeshReport& r) {
    std::string text =
        "\n  In the metric of " + r.unit_mesh.metric + ", along the curves\n" + unit_mesh_rows(r.unit_mesh);
    if (r.lowest.number > 0)
        text +=
            table_row("quality at a point", fmt::format("{:.4g} in element {}, {}", r.lowest.least, r.lowest.number,
                                                        r.bound > 0 ? fmt::format("above {:.4g} everywhere", r.bound)
                                                                    : "no positive bound everywhere"));
    if (r.worst.empty()) return text;
    text += fmt::format("\n  The worst {} by their quality along the curves\n  {:>10}{:>12}{:>18}{:>14}\n",
                        r.worst.size(), "element", "quality", "at a point", "above");
    for (const CurvedUnitMeshReport::Element& e : r.worst)
        text += fmt::format("  {:>10}{:>12.4g}{:>18.4g}{:>14}\n", e.number, e.quality, e.least,
                            e.bound > 0 ? fmt::format("{:.4g}", e.bound) : "-");
    return text;
}

constexpr std::size_t crossings_shown = 10;
constexpr std::array<std::string_view, 4> simplices{"", "edges", "triangles", "tetrahedra"};
std::string_view elements_of(const MeshReport& m) { return simplices[static_cast<std::size_t>(m.dimension)]; }
std::string_view judged_of(const MeshReport& m) { return simplices[static_cast<std::size_t>(m.judged_dimension())]; }
std::string_view facets_of(const MeshReport& m) { return simplices[static_cast<std::size_t>(m.dimension) - 1]; }

/// Returns "1: 20 000, 2: 48 and 3 more"; empty if 0 is the only reference.
std::string list_counts(const ReferenceCounts& counts, const Groups& groups, int dimension) {
    constexpr std::size_t shown = 8;
    if (counts.size() == 1 && counts.contains(0)) return {};
    std::string text;
    std::size_t i = 0;
    for (const auto& [reference, count] : counts)
        if (i++ < shown)
            text += fmt::format("{}{}: {}", i > 1 ? ", " : "", called(groups, dimension, reference), grouped(count));
    if (counts.size() > shown) text += fmt::format(" and {} more", counts.size() - shown);
    return text;
}

std::string count_rows(std::string_view name, std::size_t count, const ReferenceCounts& by_reference,
                       const Groups& groups, int dimension) {
    const std::string references = count > 0 ? list_counts(by_reference, groups, dimension) : std::string();
    return table_row(name, count) + (references.empty() ? references : table_row("  by reference", references));
}

bool has_tags(const CheckReport& report) {
    return !report.numbers.tags.simplices[report.mesh.judged_dimension()].empty();
}

std::string numbering_of(const CheckReport& report) {
    const std::string elements = fmt::format("{} from 1, in the file's order", judged_of(report.mesh));
    const bool of_tags = !report.numbers.tags.vertices.empty();
    return elements + (has_tags(report) ? ", with the file's tags beside them; " : "; ") +
           (of_tags ? "vertices by the file's tags" : "vertices in the file's order");
}

std::string mesh_rows(const CheckReport& report) {
    const MeshReport& m = report.mesh;
    std::string text =
        table_row("dimension, degree", fmt::format("{}D, P{}", m.dimension, m.degree)) +
        table_row("vertices", m.vertices) + table_row("nodes", m.nodes) +
        (m.is_standalone_surface()
             ? count_rows("triangles, no volume", m.facets, report.facets_by_reference, report.groups, 2)
             : count_rows(elements_of(m), m.elements, report.elements_by_reference, report.groups, m.dimension) +
                   count_rows(fmt::format("boundary {}", facets_of(m)), m.facets, report.facets_by_reference,
                              report.groups, m.dimension - 1));
    if (m.feature_edges > 0)
        text += count_rows("feature edges", m.feature_edges, report.feature_edges_by_reference, report.groups, 1);
    return text + table_row("numbers below", numbering_of(report));
}

std::string validity_rows(const CheckReport& r) {
    if (r.mesh.judged() == 0) return table_row("valid elements", "none to check");
    const bool is_alone = r.mesh.is_standalone_surface();
    const std::string judged = is_alone ? "triangle" : "element";
    const auto called_element = [&](std::size_t e) { return judged + " " + called(e, r.tag_of(e)); };
    std::string text =
        table_row("valid " + judged + "s", r.valid()) + table_row("invalid " + judged + "s", r.invalid) +
        table_row("undecided " + judged + "s", r.undecided) +
        table_row(is_alone ? "flat when straight" : "inverted or flat when straight", r.straight_inverted);
    if (r.mesh.degree == 2)
        return text + table_row("smallest scaled Jacobian",
                                r.worst_element == 0
                                    ? "none: all flat"
                                    : fmt::format("{} (1: as straight), of {}",
                                                  scaled_jacobian_text(r.smallest, r.invalid == 0 && r.undecided == 0),
                                                  called_element(r.worst_element)));
    if (r.worst.empty()) return text;
    return text + table_row("smallest quality", fmt::format("{:.4g}, of {} (det J is constant in straight elements)",
                                                            *r.worst[0].quality, called_element(r.worst[0].number)));
}

/// A kind of mesh defect, and the sentence that is printed if the mesh has no such defect.
struct ConcernText {
    std::string_view name, good;
};
constexpr std::array<ConcernText, 6> concerns{{
    {"conformity", "no duplicate element, no face of more than two elements, no vertex inside a face"},
    {"orientation", "no element reversed, inverted or flat"},
    {"nodes", "none unused, no two at the same position"},
    {"boundary", "complete, without duplicate or additional facets"},
    {"closure", "the boundary is closed and does not touch itself at a vertex or edge"},
    {"walls", "no element has two faces on one smooth part of the boundary"},
}};

std::string soundness_rows(const SoundnessReport& s) {
    if (s.empty) return table_row("sound", "no: the mesh is empty");
    std::string text = table_row("sound", s.sound ? "yes" : "no");
    for (const ConcernText& concern : concerns) {
        std::string bad;
        for (const auto& [key, found] : s.findings)
            if (found.concern == concern.name)
                bad += fmt::format("  {} {:<14}{}\n", found.is_harmful ? "!" : "-", bad.empty() ? concern.name : "",
                                   found.sentence);
        text += bad.empty() ? fmt::format("    {:<14}good: {}\n", concern.name, concern.good) : bad;
    }
    return text;
}

std::string name_of_facet(const CrossingReport& c, std::size_t i, const CheckReport& report) {
    const int dimension = report.mesh.dimension - 1;
    return fmt::format(
        "{} {}, reference {},", dimension == 1 ? "edge" : "triangle",
        c.facets[i] > 0 ? called(c.facets[i], c.tags[i]) : fmt::format("of vertices {}", fmt::join(c.vertices[i], " ")),
        called(report.groups, dimension, c.references[i]));
}

std::string_view words_of(Crossing verdict) {
    switch (verdict) {
        case Crossing::crossing: return "pass through each other";
        case Crossing::touching: return "touch";
        default: return "touch, or are too close to each other to decide";
    }
}

std::string sentence_of(const CrossingReport& c, const CheckReport& report) {
    const MeshReport& m = report.mesh;
    const bool itself = c.vertices[0] == c.vertices[1];
    const std::string first = name_of_facet(c, 0, report);
    const std::string what = itself
                                 ? first + (c.verdict == Crossing::crossing ? " crosses itself" : " may cross itself")
                                 : fmt::format("{} and {} {}", first, name_of_facet(c, 1, report), words_of(c.verdict));
    if (c.verdict == Crossing::touching) return what + ": contact; connected parts must share vertices";
    if (m.degree == 1 || c.straight_too) return what + ": repair the straight mesh";
    return what + (itself ? ": repair the nodes of its edges" : ": only when curved; use smaller facets");
}

std::string number_of_others(std::size_t all, std::size_t shown) {
    return all > shown ? fmt::format("{:18}and {} more (--json)\n", "", grouped(all - shown)) : std::string();
}

/// Lists pairs of facets: first those that cross, then undecided ones, then those that touch.
std::string crossing_rows(const CheckReport& report, std::size_t most) {
    const CrossingsReport& c = report.crossings;
    if (!c.looked_at || c.facets == 0) return {};
    if (c.found.empty())
        return fmt::format("    {:<14}good: no two {} of the boundary pass through each other\n", "crossings",
                           facets_of(report.mesh));
    const Crossings& n = c.counts;
    std::string text = fmt::format(
        "  {} {:<14}{} pairs of {} pass through each other, {} touch, {} undecided{}\n", n.crossing > 0 ? "!" : "-",
        "crossings", grouped(n.crossing), facets_of(report.mesh), grouped(n.touching), grouped(n.undecided),
        n.cut_short > 0 ? fmt::format(" ({} of them due to the limit of work)", grouped(n.cut_short)) : std::string());
    std::size_t shown = 0;
    for (const Crossing verdict : {Crossing::crossing, Crossing::undecided, Crossing::touching})
        for (const CrossingReport& pair : c.found)
            if (pair.verdict == verdict && shown++ < most)
                text += fmt::format("{:18}{}\n", "", sentence_of(pair, report));
    return text + number_of_others(c.found.size(), most);
}

std::string overlap_rows(const CheckReport& report, std::size_t most) {
    const OverlapsReport& o = report.overlaps;
    if (!o.looked_at) return {};
    const std::string open = o.undecided > 0 ? fmt::format("{} of {} parts of the boundary undecided",
                                                           grouped(o.undecided), grouped(o.walls))
                                             : std::string();
    if (o.overlapping == 0)
        return open.empty() ? fmt::format("    {:<14}good: no two elements overlap\n", "overlaps")
                            : fmt::format("  - {:<14}{}\n", "overlaps", open);
    std::string text = fmt::format("  ! {:<14}{} pairs of elements overlap{}{}\n", "overlaps", grouped(o.found.size()),
                                   open.empty() ? "" : "; ", open);
    for (std::size_t i = 0; i < std::min(most, o.found.size()); ++i)
        text += fmt::format("{:18}{}{}\n", "", overlap_text(o.found[i], report.mesh),
                            i == 0 ? ": cut one body out of the other, or remove a copy" : "");
    return text + number_of_others(o.found.size(), most);
}

/// Barycentric coordinates of the point where the element is proven invalid, with all digits or as fractions. Other
/// elements get three digits.
std::string barycentric_text(const ElementReport& e) {
    const std::vector<double>& weights = e.witness->barycentric;
    if (e.verdict != Verdict::invalid) return fmt::format("({:.3g})", fmt::join(weights, ", "));
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    if (sum == 1) return fmt::format("({:.60g})", fmt::join(weights, ", "));
    const std::string divisor = fmt::format("/{:.60g}", sum);
    return fmt::format("({:.60g}{})", fmt::join(weights, divisor + ", "), divisor);
}

std::string break_lines(std::string text, std::size_t indent) {
    for (std::size_t at = text.find("; "); at != std::string::npos; at = text.find("; ", at))
        text.replace(at, 2, ",\n" + std::string(indent, ' '));
    return text;
}

/// The table explains the name, because other programs use it for Knupp's measure by edge lengths.
constexpr std::string_view scaled_jacobian_words =
    "\n  (scaled J, the scaled Jacobian: minimum of det J, relative to the straight element)";

constexpr std::string_view scaled_normal_words =
    "\n  (scaled J, the scaled Jacobian: minimum of det J in the plane of the straight triangle, relative to that "
    "triangle)";

std::string worst_rows(const CheckReport& report) {
    if (report.worst.empty()) return {};
    const bool curved = report.mesh.degree == 2, is_alone = report.mesh.is_standalone_surface(),
               tagged = has_tags(report);
    const auto reference_of = [&](const ElementReport& e) {
        return called(report.groups, report.mesh.judged_dimension(), e.reference);
    };
    std::size_t width = 11;
    for (const ElementReport& e : report.worst) width = std::max(width, 2 + reference_of(e).size());
    const std::size_t indent = 38 + width + (tagged ? 10 : 0);
    std::string text =
        fmt::format("\n  The worst {} of {} {}{}\n  {:>10}{}{:>{}}  {:<10}{:>12}  {}\n", report.worst.size(),
                    grouped(report.mesh.judged()), judged_of(report.mesh),
                    !curved    ? ""
                    : is_alone ? scaled_normal_words
                               : scaled_jacobian_words,
                    is_alone ? "triangle" : "element", tagged ? "       tag" : "", "reference", width, "verdict",
                    curved ? "scaled J" : "quality", curved ? "minimum at: barycentric; point" : "reason");
    for (const ElementReport& e : report.worst) {
        text += fmt::format("  {:>10}{}{:>{}}  {:<10}{:>12}  ", e.number, tagged ? fmt::format("{:>10}", e.tag) : "",
                            reference_of(e), width, word(e.verdict),
                            curved ? scaled_jacobian_text(*e.min_scaled_jacobian, e.verdict == Verdict::valid)
                                   : fmt::format("{:.4g}", *e.quality));
        if (e.witness)
            text +=
                fmt::format("{}; ({:.6g})\n{:{}}", barycentric_text(e), fmt::join(e.witness->point, ", "), "", indent);
        text += break_lines(e.reason, indent) + "\n";
    }
    return text;
}

}  // namespace

std::string check_table(const CheckReport& report) {
    std::string text = mesh_rows(report) + validity_rows(report) + soundness_rows(report.soundness) +
                       crossing_rows(report, crossings_shown) + overlap_rows(report, crossings_shown) +
                       worst_rows(report);
    if (const auto& unit = report.unit_mesh)
        text += "\n  In the metric of " + unit->metric + ", edges and elements straight\n" + unit_mesh_rows(*unit);
    if (report.curved_unit_mesh) text += curved_unit_mesh_rows(*report.curved_unit_mesh);
    for (const FieldErrors& field : report.interpolation) text += field_table(field, report.mesh);
    return text;
}

}  // namespace camber::run
