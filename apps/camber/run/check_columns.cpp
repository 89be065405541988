module;
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
module camber.run;
import camber.core;
import camber.validity;
import :check;
import :check_parts;

namespace camber::run {

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

}  // namespace camber::run
