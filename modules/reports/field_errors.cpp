// Errors of fields, and reports of solutions
module;
#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>
#include <fmt/format.h>
#include <fmt/ranges.h>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.interpolation;
import camber.transfer;

namespace camber::run {

namespace {

std::string norm_text(const ErrorNorm& norm) {
    return norm.value <= 4 * norm.rounding ? "0 to rounding" : fmt::format("{:.4g}", norm.value);
}

int name_width(const InterpolationError& e) { return e.compared_with == Comparison::straight ? 28 : 46; }

std::string row(const InterpolationError& e, std::string_view name, std::string_view l2, std::string_view h1) {
    return fmt::format("  {:<{}}{:>16}{:>16}", name, name_width(e), l2, h1);
}
std::string norms_row(const InterpolationError& e, std::string_view name, const InterpolantError& error) {
    return row(e, name, norm_text(error.l2), norm_text(error.h1)) + "\n";
}

std::string ratio_text(const std::optional<double>& ratio) { return ratio ? fmt::format("{:.4g}", *ratio) : "-"; }

std::string bin_rows(std::string_view title, const std::vector<ErrorBin>& bins, double ErrorBin::* compared) {
    std::string text = fmt::format("    {}\n", title);
    for (const ErrorBin& bin : bins)
        if (bin.elements > 0)
            text += fmt::format("      {:<20}{:>14}{:>12.1f} %{:>10.1f} %\n", bin.range, grouped(bin.elements),
                                100 * bin.*compared, 100 * bin.curved);
    return text;
}

double largest_uncertainty(const InterpolationError& e, ErrorNorm InterpolantError::* norm) {
    double largest = 0;
    for (const InterpolantError* error : {&e.linear, &e.straight, &e.same_boundary, &e.curved}) {
        const ErrorNorm& n = error->*norm;
        if (n.value > 4 * n.rounding) largest = std::max(largest, n.uncertainty);
    }
    return largest;
}

std::string rows_of_meshes(const InterpolationError& e, int degree) {
    const bool walls_are_curved = e.compared_with == Comparison::same_boundary;
    std::string text = norms_row(e, "degree 1", e.linear) + norms_row(e, "degree 2, straight edges", e.straight);
    if (degree != 2) return text;
    if (walls_are_curved) text += norms_row(e, "degree 2, same boundary, straight inner edges", e.same_boundary);
    const auto [l2, h1] = ratios_of(e);
    text += norms_row(e, "degree 2, curved edges", e.curved) +
            row(e, walls_are_curved ? "straight inner edges / curved" : "straight / curved", ratio_text(l2),
                ratio_text(h1));
    if (!walls_are_curved) return text + "   (above 1: curvature reduces the error)\n";
    const bool same = e.compared().l2.squares == e.curved.l2.squares && e.compared().h1.squares == e.curved.h1.squares;
    return text + (same ? "   (no inner edge is curved)\n" : "   (above 1: curved inner edges reduce the error)\n");
}

std::string remarks_on_comparison(const InterpolationError& e, int dimension) {
    if (e.compared_with == Comparison::straight) return {};
    std::string text = fmt::format(
        "    The boundary is curved: a mesh with only straight edges covers another domain ({} {:.6g} instead of "
        "{:.6g}, {:+.2g} %).\n      The first two errors are on that domain. They are not comparable with the others, "
        "and do not\n      include a solver's error due to the wrong boundary.\n",
        dimension == 2 ? "area" : "volume", e.volume.straight, e.volume.curved,
        100 * (e.volume.straight / e.volume.curved - 1));
    if (e.same_boundary_inverted > 0)
        text += fmt::format(
            "    ! {} elements are inverted (det J <= 0 at a point) if inner edges are straight: no solver could "
            "use\n      this mesh. The ratio is too favourable to it: |det J| is used there, and its H1 error has no "
            "correct digits.\n",
            grouped(e.same_boundary_inverted));
    return text;
}

std::string remarks(const InterpolationError& e) {
    std::string text =
        fmt::format("    quadrature: relative error of each number at most {:.1g} (L2) and {:.1g} (H1)\n",
                    largest_uncertainty(e, &InterpolantError::l2), largest_uncertainty(e, &InterpolantError::h1));
    if (e.unresolved > 0)
        text += fmt::format("    ! {} elements in which the quadrature did not converge\n", grouped(e.unresolved));
    if (e.curved_inverted > 0)
        text += fmt::format(
            "    ! {} elements with det J <= 0 at a quadrature point ({} straight): |det J| is used, and the H1\n      "
            "error has no correct digits there\n",
            grouped(e.curved_inverted), grouped(e.straight_inverted));
    return text;
}

}  // namespace

std::string field_table(const FieldErrors& field, const MeshReport& mesh) {
    const InterpolationError& e = field.errors;
    std::string text =
        fmt::format("\n  Error of the interpolant of {}\n{}\n", field.expression, row(e, "", "L2", "H1, seminorm"));
    text += rows_of_meshes(e, mesh.degree) + remarks_on_comparison(e, mesh.dimension) + remarks(e);
    if (e.compared().l2.value <= 4 * e.compared().l2.rounding) return text;
    const bool of_straight = e.compared_with == Comparison::straight;
    text += fmt::format("    {:<22}{:>14}{:>14}{:>12}\n", "location of L2 error^2", "elements",
                        of_straight ? "straight" : "same boundary", mesh.degree == 2 ? "curved" : "");
    const auto compared = of_straight ? &ErrorBin::straight : &ErrorBin::same_boundary;
    if (mesh.degree == 2)
        text += bin_rows("curvature, |node - middle|/|chord| of the most curved edge", field.by_curvature, compared) +
                bin_rows("smallest scaled Jacobian", field.by_scaled_jacobian, compared);
    return text + bin_rows("edges between the element and the boundary", field.by_boundary, compared);
}

namespace {

std::string integral_rows(const TransferReport& r) {
    std::string text;
    for (const auto& [name, integral] : r.integrals())
        text += table_row("integral of " + name,
                          fmt::format("changed by {:.2g}, of {:.6g}", integral.largest_change, integral.largest));
    return text;
}

}  // namespace

std::string carried_rows(const TransferReport& r) {
    const TransferStatistics& s = r.statistics;
    std::string text = fmt::format("{}", fmt::join(r.names, ", "));
    if (s.outside > 0)
        text += fmt::format("; {} {} outside the old mesh, by up to {:.3g}", grouped(s.outside),
                            s.outside == 1 ? "node" : "nodes", s.largest_distance);
    if (s.unconserved_materials > 0)
        text += fmt::format("; integrals of {} {} not preserved", grouped(s.unconserved_materials),
                            s.unconserved_materials == 1 ? "material" : "materials");
    return table_row("fields transferred", text);
}

std::string solution_metric_rows(const SolutionMetricReport& r) {
    std::string text = table_row("complexity requested", fmt::format("{:.6g}", r.requested));
    text += table_row("complexity",
                      fmt::format("{:.6g} ({} evaluations, {} gradations)", r.complexity, r.evaluations, r.gradations));
    text += table_row("elements expected", fmt::format("{:.0f}", r.elements));
    if (r.fixed_complexity > 0) text += table_row("of fixed metrics", fmt::format("{:.6g}", r.fixed_complexity));
    text += table_row("largest anisotropy", fmt::format("{:.4g}", r.largest_anisotropy));
    text += table_row("vertices at bounds", fmt::format("{:.1f} % at the smallest size, {:.1f} % at the largest",
                                                        100 * r.at_min, 100 * r.at_max));
    text += table_row("derivatives", fmt::format("{} rows: {} on the boundary from inner ones, {} of a lower degree",
                                                 r.rows, r.from_inner_fits, r.lower_degree));
    text += table_row("models", fmt::format("degree {}; {} without derivatives, {} limited to an anisotropy of {:.3g}",
                                            r.degree, r.zero_models, r.floored_models, r.models_max_anisotropy));
    return text;
}

std::string transfer_rows(const TransferReport& r) {
    const TransferStatistics& s = r.statistics;
    std::string text = table_row("nodes unchanged", fmt::format("{}, bit for bit", s.preserved));
    text += table_row("nodes interpolated", s.interpolated);
    if (s.outside > 0)
        text += table_row("nodes outside", fmt::format("{}, by up to {:.3g}: the nearest point of the boundary",
                                                       s.outside, s.largest_distance));
    if (r.method == TransferMethod::interpolate) return text;
    text += table_row("projected",
                      fmt::format("{} nodes of {} elements in {} patches", s.projected, s.changed_elements, s.patches));
    if (s.unconserved_materials > 0)
        text += table_row("materials without a free node",
                          fmt::format("{}: their integrals are not preserved", s.unconserved_materials));
    return text + integral_rows(r);
}

}  // namespace camber::run
