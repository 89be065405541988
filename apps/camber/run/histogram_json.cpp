module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
module camber.run;
import :histogram;

namespace camber::run {

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

/// Whether the parser keeps a key of a report. Its objects are lists, in which each key is looked for.
bool keep_histograms(int depth, nlohmann::detail::parse_event_t event, const Json& parsed) {
    return depth != 1 || event != nlohmann::detail::parse_event_t::key || parsed == "histograms";
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

std::string histograms_json(const std::vector<Histogram>& histograms) {
    Json all = Json::object();
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
    return all.dump();
}

std::optional<std::vector<Histogram>> histograms_of_report(std::string_view text) {
    try {
        const Json json = Json::parse(text.begin(), text.end(), keep_histograms);
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
