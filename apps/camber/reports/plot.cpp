module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <fmt/format.h>
module camber.reports;
import camber.core;
import camber.recipes;

namespace camber::run {

// Why not a library: PLplot and MathGL bring 36 and 40 packages (82 and 165 MB installed) and keep their plots in
// global state, gnuplot is a program to start and to find; what is wanted is rectangles, lines and words.

namespace {

constexpr double width = 880, height = 372, top = 90, bottom = 62, left = 74, gap = 36, right = 24;
constexpr std::string_view ink = "#222", faint = "#e4e4e4", grey = "#777";

struct Panel {
    const Series* series;
    std::string_view title, colour;
};

std::vector<Panel> panels_of(const Histogram& h) {
    std::vector<Panel> panels;
    if (const Series* before = find_series(h, "before")) panels.push_back({before, "before correction", "#4c78a8"});
    if (const Series* after = find_series(h, "after")) panels.push_back({after, "after correction", "#e1812c"});
    if (const Series* input = find_series(h, "input")) panels.push_back({input, "input", "#4c78a8"});
    if (const Series* made = find_series(h, "remeshed")) panels.push_back({made, "remeshed", "#e1812c"});
    if (const Series* alone = find_series(h, "count")) panels.push_back({alone, "", "#4c78a8"});
    return panels;
}

/// Bins and counts on paper. Bin b spans [b, b + 1] of the panel; bins 0 and `limits.size()` are the open ones.
struct Axes {
    const Histogram& h;
    double panel_width, origin_y;
    std::size_t first, last;  ///< bins shown: [first, last)
    double most;              ///< top of the counts

    [[nodiscard]] double plot_height() const { return height - top - bottom; }
    [[nodiscard]] double bin_width() const { return panel_width / static_cast<double>(last - first); }
    [[nodiscard]] double x_of_bin(double b) const { return (b - static_cast<double>(first)) * bin_width(); }
    [[nodiscard]] double y_of(double count) const { return origin_y + plot_height() * (1 - count / most); }
    /// Where a value lies; none beyond the limits.
    [[nodiscard]] std::optional<double> x_of(double value) const {
        const auto above = std::upper_bound(h.limits.begin(), h.limits.end(), value) - h.limits.begin();
        if (above <= 0 || static_cast<std::size_t>(above) >= h.limits.size()) return {};
        const auto bin = static_cast<std::size_t>(above);
        const double low = h.limits[bin - 1], high = h.limits[bin];
        const double part = low * high > 0 ? log(value / low) / log(high / low) : (value - low) / (high - low);
        const double b = static_cast<double>(bin) + (part >= 0 && part <= 1 ? part : 0.5);
        if (b < static_cast<double>(first) || b > static_cast<double>(last)) return {};
        return x_of_bin(b);
    }
};

struct TextStyle {
    std::string_view anchor;
    int size = 12;
    std::string_view colour = ink;
};
/// `attributes`: more attributes of the element, each after a blank.
std::string text(double x, double y, const TextStyle& style, std::string_view words, std::string_view attributes = "") {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" font-size=\"{}\" fill=\"{}\"{}>{}</text>\n",
                       x, y, style.anchor, style.size, style.colour, attributes, words);
}

std::string line(double x1, double y1, double x2, double y2, std::string_view style) {
    return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n", x1, y1, x2, y2, style);
}

/// 1, 2 or 5 times a power of ten, so that about four fit below `most`.
double nice_step(double most) {
    const double raw = std::max(most / 4, 1.0), power = pow(10, std::floor(log10(raw)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (factor * power >= raw) return factor * power;
    return 10 * power;
}

std::string count_axis(const Axes& a, bool labelled) {
    std::string out;
    const double step = nice_step(a.most);
    for (double count = 0; count <= a.most * (1 + 1e-9); count += step) {
        const double y = a.y_of(count);
        out += line(0, y, a.panel_width, y, fmt::format("stroke=\"{}\"", faint));
        if (labelled) out += text(-8, y + 4, {"end"}, fmt::format("{:.0f}", count));
    }
    return out;
}

/// Which limits are numbered first where there is no room for all: zero, whole powers of the base, the others.
int rank(double limit, int base) {
    if (limit == 0) return 0;
    const double power = log(std::fabs(limit)) / log(base);
    return std::fabs(power - std::round(power)) < 1e-9 ? 1 : 2;
}

std::string value_axis(const Axes& a) {
    const double y = a.origin_y + a.plot_height();
    std::string out = line(0, y, a.panel_width, y, fmt::format("stroke=\"{}\" stroke-width=\"1.2\"", ink));
    constexpr double room = 42;
    std::vector<double> numbered;
    for (const int wanted : {0, 1, 2})
        for (std::size_t i = 0; i < a.h.limits.size(); ++i) {
            if (i + 1 < a.first || i + 1 > a.last || rank(a.h.limits[i], info(a.h.quantity).base) != wanted) continue;
            const double x = a.x_of_bin(static_cast<double>(i + 1));
            const bool fits = std::none_of(numbered.begin(), numbered.end(),
                                           [&](double other) { return std::fabs(other - x) < room; });
            out += line(x, y, x, y + (fits ? 5 : 3), fmt::format("stroke=\"{}\"", ink));
            if (!fits) continue;
            numbered.push_back(x);
            out += text(x, y + 19, {"middle"}, fmt::format("{:.4g}", a.h.limits[i]));
        }
    return out;
}

std::string outline(const Axes& a, const Series& series) {
    std::string path;
    for (std::size_t b = a.first; b < a.last; ++b) {
        const double y = a.y_of(static_cast<double>(series.counts[b]));
        path += fmt::format("{:.1f},{:.1f} {:.1f},{:.1f} ", a.x_of_bin(static_cast<double>(b)), y,
                            a.x_of_bin(static_cast<double>(b + 1)), y);
    }
    return fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-dasharray=\"2 2\"/>\n", path, grey);
}

std::string mean_mark(const Axes& a, double mean) {
    const auto x = a.x_of(mean);
    if (!x) return {};
    return line(*x, a.origin_y, *x, a.origin_y + a.plot_height(),
                fmt::format("stroke=\"{}\" stroke-width=\"1.5\" stroke-dasharray=\"6 4\"", ink));
}

/// However few they are, a bar is seen, and a low one has its count written above it: of the tail each one matters.
std::string bar(const Axes& a, std::size_t b, std::size_t count, std::string_view colour) {
    constexpr double min_height = 1.5, low = 12;
    const double bottom_y = a.origin_y + a.plot_height();
    const double filled = std::max(bottom_y - a.y_of(static_cast<double>(count)), min_height);
    const double x = a.x_of_bin(static_cast<double>(b)), y = bottom_y - filled;
    const bool open = b == 0 || b == a.h.limits.size();
    std::string out =
        fmt::format("<rect x=\"{:.1f}\" y=\"{:.2f}\" width=\"{:.1f}\" height=\"{:.2f}\" fill=\"{}\"{}/>\n", x + 0.5, y,
                    std::max(a.bin_width() - 1, 0.5), filled, colour, open ? " fill-opacity=\"0.45\"" : "");
    if (filled >= low) return out;
    const double middle = x + a.bin_width() / 2 + 3;
    return out + text(middle, y - 3, {"start", 9, grey}, fmt::format("{}", count),
                      fmt::format(" transform=\"rotate(-90 {:.1f} {:.1f})\"", middle, y - 3));
}

std::string panel(const Axes& a, const Panel& p, bool labelled) {
    std::string out = count_axis(a, labelled);
    for (std::size_t b = a.first; b < a.last; ++b)
        if (p.series->counts[b] > 0) out += bar(a, b, p.series->counts[b], p.colour);
    if (const Series* straight = find_series(a.h, "straight")) out += outline(a, *straight);
    out += value_axis(a) + mean_mark(a, p.series->mean);
    std::string numbers = fmt::format("mean {:.4g} (dashed)", p.series->mean);
    if (const auto& extremes = p.series->extremes)
        numbers = fmt::format("min {:.4g}, {}, max {:.4g}", extremes->least, numbers, extremes->greatest);
    if (p.series->not_numbers > 0) numbers += fmt::format(", {} no number", p.series->not_numbers);
    out += text(a.panel_width / 2, a.origin_y - 26, {"middle", 14}, p.title);
    out += text(a.panel_width / 2, a.origin_y - 9, {"middle"}, numbers);
    return out;
}

/// The bins that are not empty in all series, with one to spare on either side.
std::pair<std::size_t, std::size_t> shown(const Histogram& h) {
    std::size_t first = h.limits.size(), last = 1;
    for (const Series& s : h.series)
        for (std::size_t b = 0; b < s.counts.size(); ++b)
            if (s.counts[b] > 0) {
                first = std::min(first, b);
                last = std::max(last, b + 1);
            }
    if (first >= last) return {1, h.limits.size()};
    return {first, std::min(last + 1, h.limits.size() + (last > h.limits.size() ? 1 : 0))};
}

std::string figure(const Histogram& h, double y) {
    const QuantityInfo& what = info(h.quantity);
    const auto panels = panels_of(h);
    const auto count = static_cast<double>(std::max<std::size_t>(panels.size(), 1));
    const double panel_width = (width - left - right - (count - 1) * gap) / count;
    double most = 1;
    for (const Series& s : h.series)
        for (const std::size_t n : s.counts) most = std::max(most, static_cast<double>(n));
    const auto [first, last] = shown(h);
    const Axes axes{h, panel_width, y + top, first, std::max(last, first + 1), 1.06 * most};
    std::string out = text(left, y + 30, {"start", 18}, what.title, " font-weight=\"bold\"");
    if (const Series* straight = find_series(h, "straight"))
        out += text(width - right, y + 30, {"end", 12, grey},
                    fmt::format("straight: dotted, mean {:.4g}", straight->mean));
    double x = left;
    for (const Panel& p : panels) {
        out += fmt::format("<g transform=\"translate({:.1f} 0)\">\n{}</g>\n", x, panel(axes, p, x == left));
        x += panel_width + gap;
    }
    out += text((left + width - right) / 2, y + height - 16, {"middle", 13}, what.axis);
    const double middle = y + top + axes.plot_height() / 2;
    out += text(18, middle, {"middle", 13}, what.things, fmt::format(" transform=\"rotate(-90 18 {:.1f})\"", middle));
    return out;
}

}  // namespace

std::string svg(const std::vector<Histogram>& histograms) {
    const double whole = height * static_cast<double>(histograms.size());
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
        "font-family=\"Helvetica, Arial, sans-serif\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"white\"/>\n",
        width, whole);
    for (std::size_t i = 0; i < histograms.size(); ++i) out += figure(histograms[i], height * static_cast<double>(i));
    return out + "</svg>\n";
}

std::string svg(const Histogram& histogram) { return svg(std::vector{histogram}); }

}  // namespace camber::run
