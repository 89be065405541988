module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
module camber.run;
import :histogram;
import :rows;

namespace camber::run {

namespace {

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

/// What the bins [first, last) hold.
std::string range(const Histogram& h, std::size_t first, std::size_t last) {
    const auto limit = [&](std::size_t i) { return fmt::format("{:.4g}", h.limits[i]); };
    if (first == 0) return "below " + limit(last - 1);
    if (last == h.limits.size() + 1) return "from " + limit(first - 1);
    return limit(first - 1) + " to " + limit(last - 1);
}

bool is_empty(const Histogram& h, std::size_t bin) {
    return std::all_of(h.series.begin(), h.series.end(), [&](const Series& s) { return s.counts[bin] == 0; });
}

/// The end of the row that begins at this bin: a bin of its own, or all the empty ones that follow each other up to
/// zero.
std::size_t row_end(const Histogram& h, std::size_t bin, std::size_t last) {
    if (!is_empty(h, bin)) return bin + 1;
    do ++bin;
    while (bin < last && is_empty(h, bin) && h.limits[bin - 1] != 0);
    return bin;
}

/// A row of numbers, one a series, under the bars; nothing where a series has none.
template <class NumberOf>
std::string numbers(const Histogram& h, std::string_view name, std::size_t width, NumberOf&& number_of) {
    std::string row = fmt::format("\n  {:>18}", name);
    for (const Series& s : h.series) row += fmt::format("  {:<{}}", fmt::format("{:>9}", number_of(s)), width + 10);
    return row;
}

std::string statistics(const Histogram& h, std::size_t width) {
    const auto extreme = [&](const Series& s, double Extremes::* which) {
        if (!s.extremes) return std::string();
        const double x = (*s.extremes).*which;
        return h.quantity == Quantity::scaled_jacobian ? lower_bound_text(x) : fmt::format("{:.4g}", x);
    };
    const auto some = [&](auto&& has) { return std::any_of(h.series.begin(), h.series.end(), has); };
    const bool extremes = some([](const Series& s) { return s.extremes.has_value(); });
    std::string rows;
    if (extremes) rows += numbers(h, "smallest", width, [&](const Series& s) { return extreme(s, &Extremes::least); });
    rows += numbers(h, "mean", width, [](const Series& s) { return fmt::format("{:.4g}", s.mean); });
    if (extremes)
        rows += numbers(h, "largest", width, [&](const Series& s) { return extreme(s, &Extremes::greatest); });
    if (some([](const Series& s) { return s.not_numbers > 0; }))
        rows += numbers(h, "no number", width, [](const Series& s) { return fmt::format("{}", s.not_numbers); });
    return rows;
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

Series counted(std::string name, std::span<const double> limits, std::span<const double> values) {
    Series series{.name = std::move(name), .counts = std::vector<std::size_t>(limits.size() + 1), .extremes = {}};
    double sum = 0;
    std::size_t finite = 0;
    for (const double x : values) {
        if (std::isnan(x)) {
            ++series.not_numbers;
            continue;
        }
        const auto bin = std::upper_bound(limits.begin(), limits.end(), x) - limits.begin();
        ++series.counts[static_cast<std::size_t>(bin)];
        if (!std::isfinite(x)) continue;
        sum += x;
        ++finite;
        const Extremes so_far = series.extremes.value_or(Extremes{x, x});
        series.extremes = Extremes{std::fmin(so_far.least, x), std::fmax(so_far.greatest, x)};
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
    for (std::size_t bin = first, end = first; bin < last; bin = end) {
        end = row_end(histogram, bin, last);
        text += fmt::format("\n  {:>18}", range(histogram, bin, end));
        for (const Series& s : histogram.series)
            text += fmt::format("  {:>9} {}", s.counts[bin],
                                bar(static_cast<double>(s.counts[bin]) / static_cast<double>(most), width));
    }
    text += statistics(histogram, width);
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
