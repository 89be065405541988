// Histograms as bars for a terminal and as JSON
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <span>
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

namespace {

using Json = nlohmann::ordered_json;

/// What is no series: the limits, and numbers by the series' names.
constexpr std::array<std::string_view, 5> reserved{"edges", "mean", "min", "max", "not_a_number"};

/// The number of a series, if the object of that key is there and has one.
template <class T>
std::optional<T> number_of(const Json& json, const char* key, const std::string& series) {
    if (!json.contains(key) || !json.at(key).contains(series)) return {};
    return json.at(key).at(series).get<T>();
}

/// A count; anything else than a whole number that is not negative is an error, and not converted.
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

/// Parses one key of a report and skips the others: objects are lists, in which each key is looked for.
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
        Json means = Json::object(), least = Json::object(), greatest = Json::object(), not_numbers = Json::object();
        for (const Series& s : h.series) {
            one[s.name] = s.counts;
            means[s.name] = s.mean;
            not_numbers[s.name] = s.not_numbers;
            if (!s.extremes) continue;
            least[s.name] = s.extremes->least;
            greatest[s.name] = s.extremes->greatest;
        }
        one["mean"] = std::move(means);
        one["min"] = std::move(least);
        one["max"] = std::move(greatest);
        one["not_a_number"] = std::move(not_numbers);
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

}  // namespace camber::run
