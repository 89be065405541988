module;
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include <fmt/format.h>
module camber.run;
import camber.core;
import :rows;

namespace camber::run {

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

std::string scaled_jacobian_text(double least, bool is_positive) {
    return is_positive && !(least > 0) ? "> 0" : lower_bound_text(least);
}

}  // namespace camber::run
