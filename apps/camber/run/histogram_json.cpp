module;
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

Histogram histogram_of(Quantity quantity, const Json& json) {
    Histogram h{quantity, json.at("edges").get<std::vector<double>>(), {}};
    for (const auto& [name, value] : json.items()) {
        if (name == "edges" || name == "mean") continue;
        h.series.push_back(
            {name, value.get<std::vector<std::size_t>>(), json.at("mean").at(name).template get<double>()});
    }
    return h;
}

bool is_sound(const Histogram& h) {
    if (h.limits.empty() || h.series.empty()) return false;
    for (std::size_t i = 1; i < h.limits.size(); ++i)
        if (!(h.limits[i - 1] < h.limits[i])) return false;
    for (const Series& s : h.series)
        if (s.counts.size() != h.limits.size() + 1) return false;
    return true;
}

}  // namespace

std::string histograms_json(const std::vector<Histogram>& histograms) {
    Json all = Json::object();
    for (const Histogram& h : histograms) {
        Json one{{"edges", h.limits}};
        Json means = Json::object();
        for (const Series& s : h.series) {
            one[s.name] = s.counts;
            means[s.name] = s.mean;
        }
        one["mean"] = std::move(means);
        all[std::string(info(h.quantity).key)] = std::move(one);
    }
    return all.dump();
}

std::optional<std::vector<Histogram>> histograms_of_report(std::string_view text) {
    try {
        const Json json = Json::parse(text.begin(), text.end());
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
