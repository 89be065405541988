module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
module camber.run;
import :histogram;

namespace camber::run {

namespace {

constexpr std::array<QuantityInfo, quantity_count> infos{{
    {Quantity::length_gain, "length_gain", "Length gain", "length of the chord / length of the edge - 1",
     "volume edges", Scale::linear},
    {Quantity::length, "riemannian_length", "Riemannian length", "length in the metric", "volume edges", Scale::log2},
    {Quantity::curvature, "curvature", "Curvature", "offset of the node / length of the chord", "volume edges",
     Scale::linear},
    {Quantity::normalised_jacobian, "normalised_jacobian", "Normalised Jacobian",
     "smallest det J / det J of the straight element", "elements", Scale::linear},
    {Quantity::quality, "quality", "Quality", "mean ratio: 1 equilateral, 0 flat, negative inverted", "elements",
     Scale::linear},
}};

/// first, first + step … n limits; as quotients, so that the limits are the numbers that one reads.
std::vector<double> regular(int n, double parts) {
    std::vector<double> limits;
    limits.reserve(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) limits.push_back(i / parts);
    return limits;
}

/// Letters of a bar: so that three series fit 100 columns too.
std::size_t bar_width(const Histogram& h) { return h.series.size() > 2 ? 16 : 24; }

/// `filled` (0 … 1) of the width in eighths of a letter; anything above nothing is seen.
std::string bar(double filled, std::size_t width) {
    constexpr std::array<std::string_view, 8> eighths{"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
    auto units = static_cast<std::size_t>(std::lround(filled * static_cast<double>(8 * width)));
    if (filled > 0 && units == 0) units = 1;
    std::string text;
    for (std::size_t i = 0; i < units / 8; ++i) text += "█";
    text += eighths[units % 8];
    const std::size_t letters = (units + 7) / 8;
    return text + std::string(width - letters, ' ');
}

std::string range(const Histogram& h, std::size_t bin) {
    const auto limit = [&](std::size_t i) {
        return info(h.quantity).scale == Scale::log2 ? fmt::format("{:.3g}", h.limits[i])
                                                     : fmt::format("{:.2f}", h.limits[i]);
    };
    if (bin == 0) return "below " + limit(0);
    if (bin == h.limits.size()) return "from " + limit(bin - 1);
    return limit(bin - 1) + " to " + limit(bin);
}

/// The first bin that is not empty in all series, and the one after the last; equal when all are.
std::pair<std::size_t, std::size_t> used(const Histogram& h) {
    std::size_t first = h.limits.size() + 1, last = 0;
    for (const Series& s : h.series)
        for (std::size_t bin = 0; bin < s.counts.size(); ++bin) {
            if (s.counts[bin] == 0) continue;
            first = std::min(first, bin);
            last = std::max(last, bin + 1);
        }
    return first < last ? std::pair(first, last) : std::pair<std::size_t, std::size_t>(0, 0);
}

}  // namespace

const QuantityInfo& info(Quantity quantity) { return infos[static_cast<std::size_t>(quantity)]; }

std::vector<double> limits_of(Quantity quantity) {
    switch (quantity) {
        case Quantity::length_gain:
        case Quantity::curvature: return regular(26, 50);
        case Quantity::length: {
            std::vector<double> limits = regular(25, 4);
            for (double& x : limits) x = std::exp2(x - 3);
            return limits;
        }
        case Quantity::normalised_jacobian:
        case Quantity::quality: return regular(21, 20);
    }
    return {};
}

Series counted(std::string name, std::span<const double> limits, std::span<const double> values) {
    Series series{std::move(name), std::vector<std::size_t>(limits.size() + 1), 0};
    double sum = 0;
    std::size_t finite = 0;
    for (const double x : values) {
        if (std::isnan(x)) continue;
        const auto bin = std::upper_bound(limits.begin(), limits.end(), x) - limits.begin();
        ++series.counts[static_cast<std::size_t>(bin)];
        if (!std::isfinite(x)) continue;
        sum += x;
        ++finite;
    }
    if (finite > 0) series.mean = sum / static_cast<double>(finite);
    return series;
}

const Series* find_series(const Histogram& histogram, std::string_view name) {
    for (const Series& s : histogram.series)
        if (s.name == name) return &s;
    return nullptr;
}

std::string bars(const Histogram& histogram) {
    const QuantityInfo& what = info(histogram.quantity);
    std::string text = fmt::format("\n  {}: {}, by {}\n", what.title, what.axis, what.things);
    const auto [first, last] = used(histogram);
    if (first == last) return text + "    nothing to count\n";
    const std::size_t width = bar_width(histogram);
    std::size_t most = 1;
    for (const Series& s : histogram.series) most = std::max(most, *std::max_element(s.counts.begin(), s.counts.end()));
    text += fmt::format("  {:>18}", "");
    for (const Series& s : histogram.series) {
        const std::string name = s.name == "before" || s.name == "after" ? s.name + " correction" : s.name;
        text += fmt::format("  {:<{}}", fmt::format("{:>9} {}", "", name), width + 10);
    }
    for (std::size_t bin = first; bin < last; ++bin) {
        text += fmt::format("\n  {:>18}", range(histogram, bin));
        for (const Series& s : histogram.series)
            text += fmt::format("  {:>9} {}", s.counts[bin],
                                bar(static_cast<double>(s.counts[bin]) / static_cast<double>(most), width));
    }
    text += fmt::format("\n  {:>18}", "mean");
    for (const Series& s : histogram.series)
        text += fmt::format("  {:<{}}", fmt::format("{:>9.4g}", s.mean), width + 10);
    // No line ends with blanks.
    std::string out;
    std::size_t blanks = 0;
    for (const char letter : text + "\n") {
        if (letter == ' ') {
            ++blanks;
            continue;
        }
        if (letter != '\n') out.append(blanks, ' ');
        blanks = 0;
        out += letter;
    }
    return out;
}

}  // namespace camber::run
