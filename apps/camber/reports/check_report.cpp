// Tables of checks
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <iterator>
#include <limits>
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
import camber.soundness;

namespace camber::run {

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
        text += table_row(
            "quality at a point",
            fmt::format("{:.4g} in element {}, {}", r.lowest.least, r.lowest.number,
                        r.bound > 0 ? fmt::format("above {:.4g} everywhere", r.bound) : "no bound above 0 everywhere"));
    if (r.worst.empty()) return text;
    text += fmt::format("\n  The worst {} by their quality along the curves\n  {:>10}{:>12}{:>18}{:>14}\n",
                        r.worst.size(), "element", "quality", "at a point", "above");
    for (const CurvedUnitMeshReport::Element& e : r.worst)
        text += fmt::format("  {:>10}{:>12.4g}{:>18.4g}{:>14}\n", e.number, e.quality, e.least,
                            e.bound > 0 ? fmt::format("{:.4g}", e.bound) : "-");
    return text;
}

namespace {

constexpr std::size_t crossings_shown = 10;
constexpr std::array<std::string_view, 4> simplices{"", "edges", "triangles", "tetrahedra"};
std::string_view elements_of(const MeshReport& m) { return simplices[static_cast<std::size_t>(m.dimension)]; }
std::string_view facets_of(const MeshReport& m) { return simplices[static_cast<std::size_t>(m.dimension) - 1]; }

/// "1: 20 000, 2: 48 and 3 more"; empty where there is one reference alone, 0.
std::string list_counts(const std::vector<ReferenceCount>& counts, const Groups& groups, int dimension) {
    constexpr std::size_t shown = 8;
    if (counts.size() == 1 && counts[0].reference == 0) return {};
    std::string text;
    for (std::size_t i = 0; i < std::min(shown, counts.size()); ++i)
        text += fmt::format("{}{}: {}", i > 0 ? ", " : "", called(groups, dimension, counts[i].reference),
                            grouped(counts[i].count));
    if (counts.size() > shown) text += fmt::format(" and {} more", counts.size() - shown);
    return text;
}

std::string count_rows(std::string_view name, std::size_t count, const std::vector<ReferenceCount>& by_reference,
                       const Groups& groups, int dimension) {
    std::string text = table_row(name, count);
    const std::string references = count > 0 ? list_counts(by_reference, groups, dimension) : std::string();
    return references.empty() ? text : text + table_row("  by reference", references);
}

bool has_tags(const CheckReport& report) {
    return !report.numbers.tags.simplices[report.mesh.is_surface_alone() ? 2 : report.mesh.dimension].empty();
}

/// Which numbers elements and vertices are called by.
std::string numbering_of(const CheckReport& report) {
    const std::string elements = fmt::format("{} from 1, in the file's order",
                                             report.mesh.is_surface_alone() ? "triangles" : elements_of(report.mesh));
    const bool of_tags = !report.numbers.tags.vertices.empty();
    return elements + (has_tags(report) ? ", with the file's tags beside them; " : "; ") +
           (of_tags ? "vertices by the file's tags" : "vertices as the file numbers them");
}

std::string mesh_rows(const CheckReport& report) {
    const MeshReport& m = report.mesh;
    std::string text =
        table_row("dimension, degree", fmt::format("{}D, P{}", m.dimension, m.degree)) +
        table_row("vertices", m.vertices) + table_row("nodes", m.nodes) +
        (m.is_surface_alone()
             ? count_rows("triangles, a surface alone", m.facets, report.facets_by_reference, report.groups, 2)
             : count_rows(elements_of(m), m.elements, report.elements_by_reference, report.groups, m.dimension) +
                   count_rows(fmt::format("boundary {}", facets_of(m)), m.facets, report.facets_by_reference,
                              report.groups, m.dimension - 1));
    if (m.feature_edges > 0)
        text += count_rows("feature edges", m.feature_edges, report.feature_edges_by_reference, report.groups, 1);
    return text + table_row("numbers below", numbering_of(report));
}

std::string called_element(const CheckReport& report, std::size_t place) {
    return called(place, report.numbers.tag(report.mesh.is_surface_alone() ? 2 : report.mesh.dimension, place));
}

std::string validity_rows(const CheckReport& report) {
    const ValidityReport& v = report.validity;
    const std::size_t elements = report.mesh.judged();
    if (elements == 0) return table_row("valid elements", "none to judge");
    const bool is_alone = report.mesh.is_surface_alone();
    const std::string_view judged = is_alone ? "triangles" : "elements";
    std::string text =
        table_row(fmt::format("valid {}", judged), elements - v.invalid - v.undecided) +
        table_row(fmt::format("invalid {}", judged), v.invalid) +
        table_row(fmt::format("undecided {}", judged), v.undecided) +
        table_row(is_alone ? "flat when straight" : "inverted or flat when straight", v.straight_inverted);
    if (report.mesh.degree == 2) {
        text +=
            table_row("smallest scaled Jacobian",
                      v.worst > 0 ? fmt::format("{} (1: as straight), of {} {}",
                                                scaled_jacobian_text(v.smallest, v.invalid == 0 && v.undecided == 0),
                                                is_alone ? "triangle" : "element", called_element(report, v.worst))
                                  : "none: all flat");
    } else if (!report.worst.empty()) {
        text += table_row("smallest quality", fmt::format("{:.4g}, of {} {} (det J says nothing of a straight mesh)",
                                                          report.worst[0].quality, is_alone ? "triangle" : "element",
                                                          called_element(report, report.worst[0].number)));
    }
    return text;
}

std::string soundness_rows(const SoundnessReport& s) {
    if (s.empty) return table_row("sound", "no: the mesh is empty");
    std::string text = table_row("sound", s.sound ? "yes" : "no");
    for (std::size_t c = 0; c < concern_count; ++c) {
        const ConcernText concern = text_of(static_cast<Concern>(c));
        bool good = true;
        for (const SoundnessReport::Entry& found : s.findings) {
            if (found.count == 0 || found.concern != static_cast<Concern>(c)) continue;
            text += fmt::format("  {} {:<14}{}\n", found.harms ? "!" : "-", good ? concern.name : "", found.sentence);
            good = false;
        }
        if (good) text += fmt::format("    {:<14}good: {}\n", concern.name, concern.good);
    }
    return text;
}

std::string name_of(const FacetReport& f, const CheckReport& report) {
    const MeshReport& m = report.mesh;
    std::string name = f.number > 0 ? called(f.number, f.tag) : std::string("of vertices");
    if (f.number == 0)
        for (const std::size_t v : f.vertices) name += fmt::format(" {}", v);
    return fmt::format("{} {}, reference {},", m.dimension == 2 ? "edge" : "triangle", name,
                       called(report.groups, m.dimension - 1, f.reference));
}

std::string_view words_of(Crossing verdict) {
    switch (verdict) {
        case Crossing::crossing: return "pass through each other";
        case Crossing::touching: return "touch";
        default: return "touch, or are too near to each other to tell";
    }
}

std::string sentence_of(const CrossingReport& c, const CheckReport& report) {
    const MeshReport& m = report.mesh;
    const bool itself = c.facets[0].vertices == c.facets[1].vertices;
    const std::string what = itself
                                 ? fmt::format("{} {}", name_of(c.facets[0], report),
                                               c.verdict == Crossing::crossing ? "crosses itself" : "may cross itself")
                                 : fmt::format("{} and {} {}", name_of(c.facets[0], report),
                                               name_of(c.facets[1], report), words_of(c.verdict));
    if (c.verdict == Crossing::touching) return what + ": contact; to be joined they want common vertices";
    if (m.degree == 1 || c.straight_too) return what + ": mend the straight mesh";
    return what + (itself ? ": mend the nodes of its edges" : ": only curved; smaller facets bow less");
}

/// As many pairs as of the worst elements.
std::string crossing_rows(const CheckReport& report, std::size_t most) {
    const CrossingsReport& c = report.crossings;
    if (!c.looked_at || c.facets == 0) return {};
    if (c.found.empty())
        return fmt::format("    {:<14}good: no two {} of the boundary pass through each other\n", "crossings",
                           facets_of(report.mesh));
    std::string text = fmt::format(
        "  {} {:<14}{} pairs of {} pass through each other, {} touch, {} undecided{}\n", c.crossing > 0 ? "!" : "-",
        "crossings", grouped(c.crossing), facets_of(report.mesh), grouped(c.touching), grouped(c.undecided),
        c.cut_short > 0 ? fmt::format(" ({} of them for want of work)", grouped(c.cut_short)) : std::string());
    // What passes through comes first, then what may.
    std::size_t shown = 0;
    for (const Crossing verdict : {Crossing::crossing, Crossing::undecided, Crossing::touching})
        for (const CrossingReport& pair : c.found)
            if (pair.verdict == verdict && shown < most) {
                text += fmt::format("{:18}{}\n", "", sentence_of(pair, report));
                ++shown;
            }
    if (c.found.size() > most) text += fmt::format("{:18}and {} more (--json)\n", "", grouped(c.found.size() - most));
    return text;
}

/// As many pairs of elements that overlap as there are lines for crossings.
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
    if (o.found.size() > most) text += fmt::format("{:18}and {} more (--json)\n", "", grouped(o.found.size() - most));
    return text;
}

std::string list_numbers(const std::vector<double>& values, std::string_view format) {
    std::string text;
    for (const double x : values) text += (text.empty() ? "" : ", ") + fmt::format(fmt::runtime(format), x);
    return "(" + text + ")";
}

/// Where an invalid element fails as it is proved: all digits, or fractions.
std::string barycentric_text(const ElementReport& e) {
    const std::vector<double>& weights = e.witness->barycentric;
    if (e.verdict != Verdict::invalid) return list_numbers(weights, "{:.3g}");
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    return list_numbers(weights, sum == 1 ? "{:.60g}" : fmt::format("{{:.60g}}/{:.60g}", sum));
}

/// What a semicolon divides, on lines of their own.
std::string break_lines(std::string text, std::size_t indent) {
    for (std::size_t at = text.find("; "); at != std::string::npos; at = text.find("; ", at))
        text.replace(at, 2, ",\n" + std::string(indent, ' '));
    return text;
}

/// Other programs give this name to Knupp's measure, by the lengths of edges.
constexpr std::string_view scaled_jacobian_words =
    "\n  (scaled J, the scaled Jacobian: det J as a share of the straight element's, at its lowest)";

constexpr std::string_view scaled_normal_words =
    "\n  (scaled J, the scaled Jacobian: det J in the plane of the straight triangle, as a share of that one's, at its "
    "lowest)";

std::string worst_rows(const CheckReport& report) {
    if (report.worst.empty()) return {};
    const bool curved = report.mesh.degree == 2;
    const bool is_alone = report.mesh.is_surface_alone();
    const int dimension = is_alone ? 2 : report.mesh.dimension;
    const bool tagged = has_tags(report);
    std::size_t width = 11;
    for (const ElementReport& e : report.worst)
        width = std::max(width, 2 + called(report.groups, dimension, e.reference).size());
    const std::size_t indent = 36 + width + (tagged ? 10 : 0);
    std::string text =
        fmt::format("\n  The worst {} of {} {}{}\n  {:>10}{}{:>{}}  {:<10}{:>12}  {}\n", report.worst.size(),
                    grouped(report.mesh.judged()), is_alone ? "triangles" : elements_of(report.mesh),
                    !curved    ? ""
                    : is_alone ? scaled_normal_words
                               : scaled_jacobian_words,
                    is_alone ? "triangle" : "element", tagged ? "       tag" : "", "reference", width, "verdict",
                    curved ? "scaled J" : "quality", curved ? "lowest at: barycentric; point" : "reason");
    for (const ElementReport& e : report.worst) {
        const std::string value = curved ? scaled_jacobian_text(e.min_scaled_jacobian, e.verdict == Verdict::valid)
                                         : fmt::format("{:.4g}", e.quality);
        text += fmt::format("  {:>10}{}{:>{}}  {:<10}{:>12}  ", e.number, tagged ? fmt::format("{:>10}", e.tag) : "",
                            called(report.groups, dimension, e.reference), width, word(e.verdict), value);
        if (curved && e.witness)
            text += fmt::format("{}; {}\n{:{}}", barycentric_text(e), list_numbers(e.witness->point, "{:.6g}"), "",
                                indent + 2);
        text += break_lines(e.reason, indent + 2) + "\n";
    }
    return text;
}

std::string field_rows(const CheckReport& report) {
    std::string text;
    for (const FieldErrors& field : report.fields) text += field_table(field, report.mesh);
    return text;
}

std::string metric_rows(const UnitMeshReport& r) {
    return "\n  In the metric of " + r.metric + ", edges and elements straight\n" + unit_mesh_rows(r);
}

}  // namespace

std::string check_table(const CheckReport& report) {
    return mesh_rows(report) + validity_rows(report) + soundness_rows(report.soundness) +
           crossing_rows(report, crossings_shown) + overlap_rows(report, crossings_shown) + worst_rows(report) +
           (report.unit_mesh ? metric_rows(*report.unit_mesh) : std::string()) +
           (report.curved_unit_mesh ? curved_unit_mesh_rows(*report.curved_unit_mesh) : std::string()) +
           field_rows(report);
}

namespace {

using Out = std::back_insert_iterator<std::string>;

/// One value of one element: of text as it is, or in quotes where `quoted`; numbers that are not finite as `missing`.
struct Style {
    std::string_view quote;
    bool infinite_is_null = false;
};
constexpr Style json_style{.quote = "\"", .infinite_is_null = true};
constexpr Style csv_style{.quote = "", .infinite_is_null = false};

/// A lower bound in few digits: read back in doubles too it is not above the float.
std::string digits_below(float x) {
    std::string text = fmt::format("{}", x);
    if (std::isfinite(x) && std::strtod(text.c_str(), nullptr) > static_cast<double>(x))
        text = fmt::format("{}", std::nextafter(x, -std::numeric_limits<float>::infinity()));
    return text;
}

template <class Real>
void put_real(Out out, Real x, const Style& style) {
    if (!std::isfinite(x) && style.infinite_is_null)
        fmt::format_to(out, "null");
    else
        fmt::format_to(out, "{}", x);
}

void put_bound(Out out, float x, const Style& style) {
    if (!std::isfinite(x))
        put_real(out, x, style);
    else
        fmt::format_to(out, "{}", digits_below(x));
}

void put(Out out, const ElementColumns& columns, std::string_view column, std::size_t e, const Style& style) {
    if (column == "reference")
        fmt::format_to(out, "{}", columns.references[e]);
    else if (column == "verdict")
        fmt::format_to(out, "{0}{1}{0}", style.quote, word(columns.verdicts[e]));
    else if (column == "straight_inverted")
        fmt::format_to(out, "{}", columns.straight_inverted[e] == 1);
    else if (column == "min_scaled_jacobian")
        put_bound(out, columns.min_scaled_jacobian[e], style);
    else if (column == "quality")
        put_real(out, columns.quality[e], style);
    else
        put_real(out, columns.volume[e], style);
}

}  // namespace

std::vector<std::string> column_names(const CheckReport& report) {
    if (report.mesh.degree == 2) return {"reference", "verdict", "min_scaled_jacobian", "straight_inverted"};
    return {"reference", "verdict", "quality", "volume"};
}

std::string column_items(const CheckReport& report, std::string_view column, std::size_t begin, std::size_t end) {
    std::string text;
    for (std::size_t e = begin; e < end; ++e) {
        if (e > 0) text += ", ";
        put(std::back_inserter(text), report.elements, column, e, json_style);
    }
    return text;
}

std::string csv_titles(const CheckReport& report) {
    return fmt::format("element,{}\n", fmt::join(column_names(report), ","));
}

std::string csv_lines(const CheckReport& report, std::size_t begin, std::size_t end) {
    const auto names = column_names(report);
    std::string text;
    for (std::size_t e = begin; e < end; ++e) {
        fmt::format_to(std::back_inserter(text), "{}", e + 1);
        for (const std::string& name : names) {
            text += ',';
            put(std::back_inserter(text), report.elements, name, e, csv_style);
        }
        text += '\n';
    }
    return text;
}

namespace {

std::string_view judged_name(const MeshReport& m) { return m.is_surface_alone() ? "triangles" : "elements"; }

/// "42 of 252 elements are …".
std::string share(const CheckReport& report, std::size_t count, std::string_view what) {
    return fmt::format("{} of {} {} {} {}", grouped(count), grouped(report.mesh.judged()), judged_name(report.mesh),
                       count == 1 ? "is" : "are", what);
}

constexpr std::string_view reversed_elements = "reversed_elements";

std::string invalid_text(const CheckReport& report) {
    const ValidityReport& v = report.validity;
    if (report.is_only_reversed)
        return share(report, v.invalid,
                     "numbered the wrong way round, and valid otherwise: commands that curve or change a mesh turn "
                     "such elements, and `camber repair` writes the mesh with them turned");
    if (report.mesh.degree == 1) return share(report, v.invalid, "inverted or flat: mend the straight mesh");
    const bool is_below = v.bound > 0;
    std::string text = share(report, v.invalid,
                             is_below ? fmt::format("below the scaled Jacobian {:g}", v.bound) : "inverted somewhere");
    if (v.straight_inverted >= v.invalid) return text + ", when straight too: mend the straight mesh";
    if (report.mesh.is_surface_alone()) return text + ": smaller triangles bow less";
    return text + "; `camber repair` mends such, with `--cad MODEL` where the boundary alone makes them so";
}

/// What makes the mesh no good one, the gravest first.
std::vector<std::string> faults(const CheckReport& report) {
    std::vector<std::string> all;
    if (report.soundness.empty) return {"the mesh is empty"};
    if (report.validity.invalid > 0) all.push_back(invalid_text(report));
    if (report.validity.undecided > 0)
        all.push_back(share(report, report.validity.undecided, "too near to the bound to be certified"));
    for (const SoundnessReport::Entry& found : report.soundness.findings)
        if (found.count > 0 && found.harms && !(report.is_only_reversed && found.key == reversed_elements))
            all.push_back(found.sentence);
    if (report.crossings.crossing > 0)
        all.push_back(fmt::format("{} pairs of {} of the boundary pass through each other",
                                  grouped(report.crossings.crossing),
                                  report.mesh.dimension == 2 ? "edges" : "triangles"));
    if (report.overlaps.overlapping > 0)
        all.push_back("elements overlap: " + overlap_text(report.overlaps.found.front(), report.mesh));
    return all;
}

}  // namespace

std::string overlap_text(const OverlapReport& overlap, const MeshReport& mesh) {
    const std::string_view elements = mesh.dimension == 2 ? "triangles" : "tetrahedra";
    return fmt::format("{} {} and {} overlap at ({:.6g})", elements, called(overlap.elements[0], overlap.tags[0]),
                       called(overlap.elements[1], overlap.tags[1]), fmt::join(overlap.point, ", "));
}

std::string check_answer(const CheckReport& report) {
    const std::vector<std::string> bad = faults(report);
    if (!bad.empty()) {
        const std::string more =
            bad.size() == 1 ? std::string() : fmt::format(" (and {} more faults, below)", bad.size() - 1);
        return "NO: " + bad.front() + more;
    }
    const std::size_t n = report.mesh.judged();
    std::string text = n == 0 ? std::string("yes: the mesh is sound")
                              : fmt::format("yes: all {} {} are certified valid, and the mesh is sound", grouped(n),
                                            judged_name(report.mesh));
    const CrossingsReport& c = report.crossings;
    if (c.touching + c.undecided > 0)
        text +=
            fmt::format("; {} pairs of its boundary touch, or are too near to tell", grouped(c.touching + c.undecided));
    return text;
}

}  // namespace camber::run
