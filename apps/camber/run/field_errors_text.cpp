module;
#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
module camber.run;
import camber.interpolation;
import :field_errors;
import :rows;

namespace camber::run {

namespace {

using Json = nlohmann::ordered_json;

std::string norm_text(const ErrorNorm& norm) {
    // Within rounding there is nothing to be told but that.
    return norm.value <= 4 * norm.rounding ? "0 to rounding" : fmt::format("{:.4g}", norm.value);
}

std::string norms_row(std::string_view name, const InterpolantError& error) {
    return fmt::format("  {:<28}{:>16}{:>16}\n", name, norm_text(error.l2), norm_text(error.h1));
}

bool comparable(const ErrorNorm& straight, const ErrorNorm& curved) {
    return curved.value > 4 * curved.rounding && straight.value > 4 * straight.rounding;
}

std::string ratio_text(const ErrorNorm& straight, const ErrorNorm& curved) {
    return comparable(straight, curved) ? fmt::format("{:.4g}", straight.value / curved.value) : "-";
}

std::string place_rows(const ErrorPlace& place) {
    std::string text = fmt::format("    {}\n", place.title);
    for (const ErrorBin& bin : place.bins)
        if (bin.elements > 0)
            text += fmt::format("      {:<20}{:>14}{:>12.1f} %{:>10.1f} %\n", bin.range, grouped(bin.elements),
                                100 * bin.straight, 100 * bin.curved);
    return text;
}

double largest_uncertainty(const InterpolationError& e, ErrorNorm InterpolantError::* norm) {
    double largest = 0;
    for (const InterpolantError* error : {&e.linear, &e.straight, &e.curved}) {
        const ErrorNorm& n = error->*norm;
        if (n.value > 4 * n.rounding) largest = std::max(largest, n.uncertainty);
    }
    return largest;
}

std::string remarks(const InterpolationError& e) {
    std::string text =
        fmt::format("    quadrature: certain to {:.1g} (L2) and {:.1g} (H1) of each number\n",
                    largest_uncertainty(e, &InterpolantError::l2), largest_uncertainty(e, &InterpolantError::h1));
    if (e.unresolved > 0)
        text += fmt::format("    ! {} elements in which the quadrature found no end\n", grouped(e.unresolved));
    if (e.curved_turned > 0)
        text += fmt::format(
            "    ! {} elements where det J <= 0 at a point of the quadrature ({} straight): |det J| is taken, and "
            "the H1\n      error has no digits there\n",
            grouped(e.curved_turned), grouped(e.straight_turned));
    return text;
}

Json json(const ErrorNorm& norm) {
    return {{"value", norm.value}, {"uncertainty", norm.uncertainty}, {"rounding", norm.rounding}};
}
Json json(const InterpolantError& error) { return {{"l2", json(error.l2)}, {"h1", json(error.h1)}}; }
Json ratio(const ErrorNorm& straight, const ErrorNorm& curved) {
    return comparable(straight, curved) ? Json(straight.value / curved.value) : Json(nullptr);
}

}  // namespace

std::string field_table(const FieldErrors& field, int degree) {
    const InterpolationError& e = field.errors;
    std::string text = fmt::format("\n  Error of the interpolant of {}\n  {:<28}{:>16}{:>16}\n", field.expression, "",
                                   "L2", "H1, seminorm");
    text += norms_row("degree 1", e.linear) + norms_row("degree 2, straight edges", e.straight);
    if (degree == 2)
        text += norms_row("degree 2, as it is", e.curved) +
                fmt::format("  {:<28}{:>16}{:>16}   (above 1: curvature pays)\n", "straight / as it is",
                            ratio_text(e.straight.l2, e.curved.l2), ratio_text(e.straight.h1, e.curved.h1));
    text += remarks(e);
    if (e.straight.l2.value <= 4 * e.straight.l2.rounding) return text;
    text += fmt::format("    {:<22}{:>14}{:>14}{:>12}\n", "where the L2 error^2 sits", "elements", "straight",
                        degree == 2 ? "as it is" : "");
    for (const ErrorPlace& place : field.places)
        if (degree == 2 || place.key == "boundary") text += place_rows(place);
    return text;
}

std::string field_json(const FieldErrors& field) {
    const InterpolationError& e = field.errors;
    Json j{{"field", field.expression},
           {"linear", json(e.linear)},
           {"straight", json(e.straight)},
           {"curved", json(e.curved)},
           {"ratio", {{"l2", ratio(e.straight.l2, e.curved.l2)}, {"h1", ratio(e.straight.h1, e.curved.h1)}}},
           {"straight_turned", e.straight_turned},
           {"curved_turned", e.curved_turned},
           {"unresolved", e.unresolved},
           {"evaluations", e.evaluations}};
    for (const ErrorPlace& place : field.places) {
        Json bins = Json::array();
        for (const ErrorBin& bin : place.bins)
            bins.push_back(
                {{"range", bin.range}, {"elements", bin.elements}, {"straight", bin.straight}, {"curved", bin.curved}});
        j["by_" + std::string(place.key)] = std::move(bins);
    }
    return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace camber::run
