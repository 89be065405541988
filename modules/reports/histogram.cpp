// Histograms as terminal bars, JSON and SVG
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
module camber.reports;
import camber.core;
import camber.recipes;

namespace camber::run {

namespace {

/// Width of a bar in characters. Three series fit into 100 columns.
std::size_t bar_width(const Histogram& h) { return h.series.size() > 2 ? 16 : 24; }

/// Draws a fraction of `width` in eighths of a character. Positive fractions are always visible.
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

std::string range(const Histogram& h, std::size_t first, std::size_t last) {
    const auto limit = [&](std::size_t i) { return fmt::format("{:.4g}", h.limits[i]); };
    if (first == 0) return "below " + limit(last - 1);
    if (last == h.limits.size() + 1) return "from " + limit(first - 1);
    return limit(first - 1) + " to " + limit(last - 1);
}

bool is_empty(const Histogram& h, std::size_t bin) {
    return std::all_of(h.series.begin(), h.series.end(), [&](const Series& s) { return s.counts[bin] == 0; });
}

/// Returns the end of the range of bins that share the row of this bin. Consecutive empty bins on one side of zero
/// share a row.
std::size_t row_end(const Histogram& h, std::size_t bin, std::size_t last) {
    if (!is_empty(h, bin)) return bin + 1;
    do ++bin;
    while (bin < last && is_empty(h, bin) && h.limits[bin - 1] != 0);
    return bin;
}

/// Row below the bars with one number per series; empty if no series has one.
template <class NumberOf>
std::string numbers(const Histogram& h, std::string_view name, std::size_t width, NumberOf&& number_of) {
    std::string row = fmt::format("\n  {:>18}", name);
    for (const Series& s : h.series) row += fmt::format("  {:<{}}", fmt::format("{:>9}", number_of(s)), width + 10);
    return row;
}

std::string statistics(const Histogram& h, std::size_t width) {
    const auto extreme = [&](const Series& s, double Extremes::* range_member) {
        if (!s.extremes) return std::string();
        const double x = (*s.extremes).*range_member;
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
        rows += numbers(h, "not a number", width, [](const Series& s) { return fmt::format("{}", s.not_numbers); });
    return rows;
}

/// Range [first, last) of bins outside of which all series are empty.
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
    text += "\n";
    for (std::size_t at = 0; (at = text.find(" \n", at)) != std::string::npos; at -= at > 0 ? 1 : 0) text.erase(at, 1);
    return text;
}

namespace {

using Json = nlohmann::ordered_json;

/// Keys of a histogram that are not the name of a series: "edges" has the limits of the bins, and the others have a
/// number for each series.
constexpr std::array<std::string_view, 5> reserved{"edges", "mean", "min", "max", "not_a_number"};

template <class T>
std::optional<T> number_of(const Json& json, const char* key, const std::string& series) {
    if (!json.contains(key) || !json.at(key).contains(series)) return {};
    return json.at(key).at(series).get<T>();
}

/// Throws unless the value is a nonnegative integer; nothing is converted.
std::size_t count_of(const Json& json) { return json.get_ref<const Json::number_unsigned_t&>(); }

std::vector<std::size_t> counts_of(const Json& json) {
    std::vector<std::size_t> counts;
    counts.reserve(json.size());
    for (const Json& one : json) counts.push_back(count_of(one));
    return counts;
}

std::size_t not_numbers_of(const Json& json, const std::string& series) {
    if (!json.contains("not_a_number") || !json.at("not_a_number").contains(series)) return 0;
    return count_of(json.at("not_a_number").at(series));
}

Series series_of(const Json& json, const std::string& name) {
    Series s{.name = name,
             .counts = counts_of(json.at(name)),
             .mean = json.at("mean").at(name).get<double>(),
             .extremes = {},
             .not_numbers = not_numbers_of(json, name)};
    const auto least = number_of<double>(json, "min", name), greatest = number_of<double>(json, "max", name);
    if (least && greatest) s.extremes = Extremes{*least, *greatest};
    return s;
}

Histogram histogram_of(Quantity quantity, const Json& json) {
    Histogram h{quantity, json.at("edges").get<std::vector<double>>(), {}};
    for (const auto& [name, value] : json.items())
        if (std::find(reserved.begin(), reserved.end(), name) == reserved.end())
            h.series.push_back(series_of(json, name));
    return h;
}

/// Parses only one key of a report. Objects are lists, so each lookup of a key is linear.
Json parse_key(std::string_view text, std::string_view key) {
    return Json::parse(text.begin(), text.end(),
                       [key](int depth, nlohmann::detail::parse_event_t event, const Json& parsed) {
                           return depth != 1 || event != nlohmann::detail::parse_event_t::key || parsed == key;
                       });
}

bool is_sound(const Histogram& h) {
    if (h.limits.empty() || h.series.empty()) return false;
    for (std::size_t i = 1; i < h.limits.size(); ++i)
        if (!(h.limits[i - 1] < h.limits[i])) return false;
    for (const Series& s : h.series)
        if (s.counts.size() != h.limits.size() + 1 || (s.extremes && s.extremes->least > s.extremes->greatest))
            return false;
    return true;
}

}  // namespace

nlohmann::ordered_json json_of_histograms(const std::vector<Histogram>& histograms) {
    nlohmann::ordered_json all = Json::object();
    for (const Histogram& h : histograms) {
        Json one{{"edges", h.limits}};
        for (const Series& s : h.series) one[s.name] = s.counts;
        for (const char* const key : {"mean", "min", "max", "not_a_number"}) one[key] = Json::object();
        for (const Series& s : h.series) {
            one["mean"][s.name] = s.mean;
            one["not_a_number"][s.name] = s.not_numbers;
            if (!s.extremes) continue;
            one["min"][s.name] = s.extremes->least;
            one["max"][s.name] = s.extremes->greatest;
        }
        all[std::string(info(h.quantity).key)] = std::move(one);
    }
    return all;
}

std::optional<int> format_of_report(std::string_view text) {
    try {
        return parse_key(text, "format").at("format").get<int>();
    } catch (const nlohmann::json::exception&) {
        return {};
    }
}

std::optional<std::vector<Histogram>> histograms_of_report(std::string_view text) {
    try {
        const Json json = parse_key(text, "histograms");
        const Json& all = json.at("histograms");
        std::vector<Histogram> histograms;
        for (std::size_t q = 0; q < quantity_count; ++q) {
            const auto quantity = static_cast<Quantity>(q);
            const std::string key(info(quantity).key);
            if (!all.contains(key)) continue;
            histograms.push_back(histogram_of(quantity, all.at(key)));
            if (!is_sound(histograms.back())) return {};
        }
        if (histograms.empty()) return {};
        return histograms;
    } catch (const nlohmann::json::exception&) {
        return {};
    }
}

// SVG is written here without a library. PLplot and MathGL install 36 and 40 packages (82 and 165 MB) and have global
// state; gnuplot is a separate program. Only rectangles, lines and text are needed.

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
    if (const Series* result = find_series(h, "remeshed")) panels.push_back({result, "remeshed", "#e1812c"});
    if (const Series* alone = find_series(h, "count")) panels.push_back({alone, "", "#4c78a8"});
    return panels;
}

/// Coordinates of a panel. Bin b spans [b, b + 1]; bins 0 and `limits.size()` are unbounded.
struct Axes {
    const Histogram& h;
    double panel_width, origin_y;
    std::size_t first, last;  ///< bins shown: [first, last)
    double most;              ///< count at the top of the vertical axis

    [[nodiscard]] double plot_height() const { return height - top - bottom; }
    [[nodiscard]] double bin_width() const { return panel_width / static_cast<double>(last - first); }
    [[nodiscard]] double x_of_bin(double b) const { return (b - static_cast<double>(first)) * bin_width(); }
    [[nodiscard]] double y_of(double count) const { return origin_y + plot_height() * (1 - count / most); }
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
/// `attributes`: more attributes of the element, each preceded by a space.
std::string text(double x, double y, const TextStyle& style, std::string_view words, std::string_view attributes = "") {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" font-size=\"{}\" fill=\"{}\"{}>{}</text>\n",
                       x, y, style.anchor, style.size, style.colour, attributes, words);
}

std::string line(double x1, double y1, double x2, double y2, std::string_view style) {
    return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n", x1, y1, x2, y2, style);
}

/// Returns 1, 2 or 5 times a power of ten, such that about four steps of this size cover the range from 0 to `most`.
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

/// Priority of a limit's label if space is short: zero, integer powers of the base, others.
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
    for (const int required_rank : {0, 1, 2})
        for (std::size_t i = 0; i < a.h.limits.size(); ++i) {
            if (i + 1 < a.first || i + 1 > a.last || rank(a.h.limits[i], info(a.h.quantity).base) != required_rank)
                continue;
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

/// Bars with low counts have a minimum height and their count above, so that the tail is visible.
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
    if (p.series->not_numbers > 0) numbers += fmt::format(", {} not a number", p.series->not_numbers);
    out += text(a.panel_width / 2, a.origin_y - 26, {"middle", 14}, p.title);
    out += text(a.panel_width / 2, a.origin_y - 9, {"middle"}, numbers);
    return out;
}

/// Range of bins outside of which all series are empty, with one more bin on each side.
std::pair<std::size_t, std::size_t> shown(const Histogram& h) {
    const auto [first, last] = used(h);
    if (first == last) return {1, h.limits.size()};
    return {std::min(first, h.limits.size()), std::min(last + 1, h.limits.size() + (last > h.limits.size() ? 1 : 0))};
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
