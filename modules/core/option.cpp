module;
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
module camber.core;
import :option;
import :outcome;

namespace camber {

namespace {

/// The shortest digits that give the same number back.
std::string number(double x) {
    if (x == std::round(x) && std::abs(x) < 1e15) return std::to_string(static_cast<long>(x));
    std::array<char, 32> digits{};
    return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr};
}

}  // namespace

std::string Limits::text() const {
    std::string text;
    if (std::isfinite(low)) text = (low_open ? "above " : "at least ") + number(low);
    if (std::isfinite(high))
        text += (text.empty() ? "" : " and ") + std::string(high_open ? "below " : "at most ") + number(high);
    return text;
}

std::string Limits::interval() const {
    const bool below_all = !std::isfinite(low);
    const bool above_all = !std::isfinite(high);
    return (low_open || below_all ? "(" : "[") + (below_all ? "-inf" : number(low)) + ", " +
           (above_all ? "inf" : number(high)) + (high_open || above_all ? ")" : "]");
}

std::string out_of_limits(const Limits& limits, std::string_view got) {
    return "must be " + limits.text() + ", got " + shortened(got);
}

Outcome<Done> check_limits(std::string_view name, double value, const Limits& limits) {
    if (!std::isfinite(value)) return fail(ErrorKind::usage, std::string(name) + " must be a finite number");
    if (limits.hold(value)) return Done{};
    return fail(ErrorKind::usage, std::string(name) + " " + out_of_limits(limits, number(value)));
}

}  // namespace camber
