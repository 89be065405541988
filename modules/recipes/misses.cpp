module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <optional>
#include <ranges>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <fmt/format.h>
#include <fmt/ranges.h>
module camber.recipes;
import camber.core;
import camber.crossing;
import camber.repair;

namespace camber::run {

std::string grouped(std::size_t n) {
    std::string digits = fmt::format("{}", n);
    for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, " ");
    return digits;
}

std::string place_text(const ReportedPlace& place) { return fmt::format("({:.4g})", fmt::join(place, ", ")); }

std::string lower_bound_text(double x) {
    std::string text = fmt::format("{:.4g}", x);
    if (!std::isfinite(x) || x == 0) return text;
    const double digit = pow(10, std::floor(log10(std::abs(x))) - 3);
    const double step = std::max(digit / 2, std::numeric_limits<double>::denorm_min());
    for (double below = x; std::strtod(text.c_str(), nullptr) > x; text = fmt::format("{:.4g}", below)) below -= step;
    return text;
}

std::string upper_bound_text(double x) {
    std::string text = lower_bound_text(-x);
    if (text.front() == '-') return text.substr(1);
    return x == 0 || std::isnan(x) ? fmt::format("{:.4g}", x) : "-" + text;
}

std::string crossing_message(const WallsReport& walls, int dimension) {
    if (walls.crossing == 0) return {};
    const bool is_one = walls.crossing == 1;
    std::string text = fmt::format("{} {} of boundary {} {} through each other (the first: {} and {}, near {})",
                                   walls.crossing, is_one ? "pair" : "pairs", dimension == 2 ? "edges" : "triangles",
                                   is_one ? "passes" : "pass", walls.first, walls.other, place_text(walls.first_at));
    if (walls.crossing_before > 0)
        text += fmt::format("; {} crossed already in the input: correct the input there", walls.crossing_before);
    return text;
}

std::string overlap_message(const Report& report) {
    const OverlappingReport& o = report.overlaps;
    if (o.overlapping == 0) return {};
    return fmt::format(
        "elements overlap in {} {}, one at ({:.6g}): cut one body out of the other, or remove a copy "
        "(camber check lists them)",
        grouped(o.overlapping), o.overlapping == 1 ? "place" : "places", fmt::join(o.point, ", "));
}

namespace {

std::string listed(const std::vector<std::size_t>& elements) {
    constexpr std::size_t shown = 10;
    std::string text = fmt::format("{}", fmt::join(elements | std::views::take(shown), ", "));
    if (elements.size() > shown) text += fmt::format(" and {} more", elements.size() - shown);
    return text;
}

std::string remedies_of_elements(const Report& r) {
    if (!r.input_boundary || r.remaining.empty()) return {};
    std::vector<std::string> ways;
    if (const auto& tolerance = r.input_boundary->sufficient_tolerance)
        ways.push_back(fmt::format("--boundary-tolerance {:g} (tried: it makes every element valid)", *tolerance));
    if (r.validity && r.validity->straight_inverted > 0)
        ways.emplace_back("`camber remesh`, which replaces elements that are inverted when straight");
    else if (r.origin && (r.origin->geometry == "surrogate" || r.origin->geometry == "straight"))
        ways.emplace_back("--cad MODEL, or --geometry, so that the boundary's nodes may slide on it");
    return fmt::format("{}", fmt::join(ways, ", or "));
}

std::string geometry_error_missed(const Report& r) {
    const GeometryErrorReport& g = *r.boundary->geometry_error;
    const std::string_view remedy = r.remesh ? "a smaller size there (--metric, --size) may reduce it"
                                             : "camber remesh --geometry-error refines the boundary there";
    return fmt::format(
        "the boundary is {:.4g} from its geometry, and {:.4g} is required: {} facets are farther, the farthest is "
        "facet "
        "{} at ({:.6g}); {}",
        g.reached, g.required, grouped(g.far_facets), g.facet, fmt::join(g.at, ", "), remedy);
}

std::string elements_missed(const Report& r) {
    const std::size_t straight = r.validity->straight_inverted;
    const std::size_t below = r.validity->is_explicit ? r.validity->below_bound : 0;
    std::string line = fmt::format("{} elements are not certified valid", r.not_valid());
    if (below > 0) line += fmt::format(" above {:g}", r.validity->bound);
    if (!r.invalid_elements.empty()) line += "; invalid: " + listed(r.invalid_elements);
    if (!r.undecided_elements.empty()) line += "; undecided: " + listed(r.undecided_elements);
    if (below > 0 && !r.elements_below_bound.empty())
        line += fmt::format("; below {:g}: ", r.validity->bound) + listed(r.elements_below_bound);
    if (const std::string help = remedies_of_elements(r); !help.empty()) line += "; remedy: " + help;
    if (straight > 0 && !r.remesh)  // passes may leave elements inverted when straight
        line += fmt::format(" ({} flat or inverted before curving: repair the straight mesh)", straight);
    return line;
}

std::string place_of(const DeviationReport& d) {
    const std::string entity = d.vertices[1] == 0 ? fmt::format("vertex {} at", d.vertices[0])
                                                  : fmt::format("edge {} to {} near", d.vertices[0], d.vertices[1]);
    return fmt::format("{} ({:.6g})", entity, fmt::join(d.at, ", "));
}

std::string deviation_missed(const DeviationReport& d, std::string_view entities) {
    return fmt::format(
        "{} of {} boundary {} {} off the geometry by more than {:g} of the local edge length (largest distance {:.4g}; "
        "worst: {}, by {:.3g} of it)",
        d.off, d.measured, entities, d.off == 1 ? "is" : "are", d.tolerance, d.largest, place_of(d), d.share);
}

struct NodeCauses {
    std::size_t relaxed = 0;     ///< boundary edges whose nodes repair moved
    bool is_uncrossed = false;   ///< nodes were moved back until no boundary facets crossed
    std::size_t unresolved = 0;  ///< elements on which the budget of work was spent
};

std::string nodes_missed(const DeviationReport& d, const NodeCauses& causes) {
    std::string line = deviation_missed(d, "nodes");
    if (causes.relaxed > 0) line += "; cause: validity, nodes were relaxed until elements are valid";
    if (causes.is_uncrossed) line += "; cause: crossing, nodes were moved back until no boundary facets cross";
    if (causes.unresolved > 0)
        line += fmt::format("; cause: limit of work, reached for {} elements (the option effort of relax)",
                            causes.unresolved);
    return line + fmt::format("; remedy: smaller elements there, or accept it with --geometry-tolerance {:.2g}",
                              1.1 * d.share);
}

NodeCauses causes_of(const Report& r) {
    NodeCauses causes;
    if (r.relax) causes.relaxed = r.relax->relaxed_surface_edges, causes.unresolved = r.relax->unresolved;
    if (const auto& walls = r.boundary->walls; walls && walls->relaxed) {
        causes.is_uncrossed = true;
        causes.relaxed -= std::min(causes.relaxed, walls->relaxed->nodes);  // they are counted as relaxed, too
    }
    return causes;
}

bool slides_on_geometry(const Report& r) {
    return r.origin && (r.origin->geometry == "cad" || r.origin->geometry == "analytic");
}

}  // namespace

std::vector<std::string> misses(const Report& report) {
    std::vector<std::string> all;
    if (!report.has_valid_elements()) all.push_back(elements_missed(report));
    if (std::string overlaps = overlap_message(report); !overlaps.empty()) all.push_back(std::move(overlaps));
    if (!report.boundary) return all;
    const BoundaryReport& boundary = *report.boundary;
    if (!report.meets_geometry_error()) all.push_back(geometry_error_missed(report));
    const auto is_off = [](const std::optional<DeviationReport>& d) { return d && d->off > 0; };
    if (is_off(boundary.node_deviation)) all.push_back(nodes_missed(*boundary.node_deviation, causes_of(report)));
    if (is_off(boundary.vertex_deviation))
        all.push_back(deviation_missed(*boundary.vertex_deviation, "vertices") +
                      "; remedy: " + (boundary.cad && !boundary.cad->moves ? "--cad-vertices move, or " : "") +
                      "a mesh of this geometry");
    if (!report.are_facets_disjoint()) all.push_back(crossing_message(*boundary.walls, report.mesh.dimension));
    return all;
}

std::string recommended_bound_note(const Report& r) {
    if (!r.validity || r.validity->is_explicit || r.elements_below_bound.empty()) return {};
    std::string_view raise;
    if (r.input_boundary && slides_on_geometry(r))
        raise = "; to raise them, set --boundary-tolerance";
    else if (r.input_boundary)
        raise = "; to raise them, set --boundary-tolerance or --cad";
    else if (r.curve && r.curve->objective == "shape")
        raise = "; to raise them, use smaller elements there";
    else if (r.curve)
        raise = "; to raise them, set --objective shape or use smaller elements there";
    return fmt::format(
        "{} {} valid, but below the recommended scaled Jacobian {:g}: {} (this is no error; --min-scaled-jacobian {:g} "
        "makes it one{})",
        r.elements_below_bound.size(), r.elements_below_bound.size() == 1 ? "element is" : "elements are",
        r.validity->bound, listed(r.elements_below_bound), r.validity->bound, raise);
}

namespace {

std::string_view judged_name(const MeshReport& m) { return m.is_standalone_surface() ? "triangles" : "elements"; }

std::string share(const CheckReport& report, std::size_t count, std::string_view what) {
    return fmt::format("{} of {} {} {} {}", grouped(count), grouped(report.mesh.judged()), judged_name(report.mesh),
                       count == 1 ? "is" : "are", what);
}

std::string invalid_text(const CheckReport& r) {
    if (r.is_only_reversed)
        return share(r, r.invalid,
                     "oriented the wrong way round, and valid otherwise: commands that curve or change a mesh turn "
                     "such elements, and `camber repair` writes the mesh with them turned");
    if (r.mesh.degree == 1) return share(r, r.invalid, "inverted or flat: repair the straight mesh");
    std::string text = share(
        r, r.invalid, r.bound > 0 ? fmt::format("below the scaled Jacobian {:g}", r.bound) : "inverted somewhere");
    if (r.straight_inverted >= r.invalid) return text + ", when straight too: repair the straight mesh";
    if (r.mesh.is_standalone_surface()) return text + ": smaller triangles are less curved";
    return text + "; `camber repair` repairs them; use `--cad MODEL` if only the boundary makes them invalid";
}

std::vector<std::string> failed_checks(const CheckReport& r) {
    std::vector<std::string> all;
    if (r.soundness.empty) return {"the mesh is empty"};
    if (r.invalid > 0) all.push_back(invalid_text(r));
    if (r.undecided > 0) all.push_back(share(r, r.undecided, "too near to the bound to be certified"));
    for (const auto& [key, found] : r.soundness.findings)
        if (found.is_harmful && !(r.is_only_reversed && key == "reversed_elements")) all.push_back(found.sentence);
    if (const std::size_t crossing = r.crossings.counts.crossing; crossing > 0)
        all.push_back(fmt::format("{} pairs of {} of the boundary pass through each other", grouped(crossing),
                                  r.mesh.dimension == 2 ? "edges" : "triangles"));
    if (r.overlaps.overlapping > 0)
        all.push_back("elements overlap: " + overlap_text(r.overlaps.found.front(), r.mesh));
    return all;
}

}  // namespace

std::string overlap_text(const OverlapReport& overlap, const MeshReport& mesh) {
    return fmt::format("{} {} and {} overlap at ({:.6g})", mesh.dimension == 2 ? "triangles" : "tetrahedra",
                       called(overlap.elements[0], overlap.tags[0]), called(overlap.elements[1], overlap.tags[1]),
                       fmt::join(overlap.point, ", "));
}

std::string CheckReport::answer() const {
    const std::vector<std::string> bad = failed_checks(*this);
    if (bad.size() > 1) return fmt::format("NO: {} (and {} more defects, below)", bad.front(), bad.size() - 1);
    if (!bad.empty()) return "NO: " + bad.front();
    const std::size_t n = mesh.judged(), near = crossings.counts.touching + crossings.counts.undecided;
    return (n == 0 ? std::string("yes: the mesh is sound")
                   : fmt::format("yes: all {} {} are certified valid, and the mesh is sound", grouped(n),
                                 judged_name(mesh))) +
           (near == 0 ? std::string()
                      : fmt::format("; {} pairs of boundary facets touch or are too close for a certified answer",
                                    grouped(near)));
}

}  // namespace camber::run
