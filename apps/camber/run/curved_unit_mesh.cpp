module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
module camber.run;
import camber.core;
import camber.metric;
import :curved_unit_mesh;
import :histogram;
import :report;
import :rows;
import :unit_mesh;

namespace camber::run {

namespace {

using Element = CurvedUnitMeshReport::Element;

/// Of each element whose bound might be the lowest.
constexpr int bisections_of_all = 64;

std::vector<std::uint32_t> find_worst(const std::vector<double>& qualities, std::size_t n) {
    std::vector<std::uint32_t> order(qualities.size());
    std::iota(order.begin(), order.end(), 0U);
    const auto end = order.begin() + static_cast<std::ptrdiff_t>(std::min(n, order.size()));
    std::partial_sort(order.begin(), end, order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tuple(qualities[a], a) < std::tuple(qualities[b], b);
    });
    order.erase(end, order.end());
    return order;
}

Element element_at(std::size_t e, const std::vector<double>& qualities, const LeastQuality& least) {
    return {e + 1, qualities[e], least.attained, least.bound};
}

}  // namespace

template <int D>
Outcome<CurvedUnitMesh> measure_curved_unit_mesh(const QuadraticMesh<D>& mesh, const Column<LogMetric<D>>& log_metrics,
                                                 std::string metric, std::size_t worst, const Execution& execution) {
    const auto measured = measure_curved(mesh, log_metrics.view(), bisections_of_all, part_of(execution, 0, 0.95));
    if (!measured) return fail(measured.error());
    CurvedUnitMesh out{{},
                       {measured->lengths.begin(), measured->lengths.end()},
                       {measured->qualities.begin(), measured->qualities.end()}};
    out.report.unit_mesh = unit_mesh_report(std::move(metric), out.lengths, out.qualities);
    const auto& least = measured->least;
    const auto lowest = std::min_element(least.begin(), least.end(), [](const LeastQuality& a, const LeastQuality& b) {
        return a.attained < b.attained;
    });
    if (lowest != least.end()) {
        out.report.lowest = element_at(static_cast<std::size_t>(lowest - least.begin()), out.qualities, *lowest);
        out.report.bound = lowest->bound;
        for (const LeastQuality& found : least) out.report.bound = std::min(out.report.bound, found.bound);
    }
    const auto chosen = find_worst(out.qualities, worst);
    const auto described = map_each(
        part_of(execution, 0.95, 1), chosen.size(),
        [&](std::size_t i) {
            const ElementInMetric<D> element = element_in_metric<D>(mesh, log_metrics.view(), ElementId(chosen[i]));
            LeastQuality found = least[chosen[i]];
            const auto closer =
                bound_quality<D>(element.nodes, element.metrics, {.enough = 1, .bisections = max_bisections});
            found.attained = std::min(found.attained, closer.attained);
            found.bound = std::min(found.attained, std::max(found.bound, closer.bound));
            return element_at(chosen[i], out.qualities, found);
        },
        16);
    if (!described) return fail(described.error());
    out.report.worst.assign(described->begin(), described->end());
    return out;
}

std::vector<Histogram> histograms_of(const CurvedUnitMesh& measured, const std::string& series) {
    const auto histogram = [&](Quantity quantity, const std::vector<double>& values) {
        auto limits = limits_of(quantity);
        Series counts = counted(series, limits, values);
        return Histogram{quantity, std::move(limits), {std::move(counts)}};
    };
    return {histogram(Quantity::curved_edge_length, measured.lengths),
            histogram(Quantity::curved_metric_quality, measured.qualities)};
}

std::string curved_unit_mesh_rows(const CurvedUnitMeshReport& r) {
    std::string text =
        "\n  In the metric of " + r.unit_mesh.metric + ", along the curves\n" + unit_mesh_rows(r.unit_mesh);
    if (r.lowest.number > 0)
        text += table_row(
            "quality at a point",
            fmt::format("{:.4g} in element {}, {}", r.lowest.least, r.lowest.number,
                        r.bound > 0 ? fmt::format("above {:.4g} everywhere", r.bound) : "no bound above 0 everywhere"));
    if (r.worst.empty()) return text;
    text += fmt::format("\n  The worst {} by their quality along the curves\n  {:>10}{:>12}{:>18}{:>14}\n",
                        r.worst.size(), "element", "quality", "at a point", "above");
    for (const Element& e : r.worst)
        text += fmt::format("  {:>10}{:>12.4g}{:>18.4g}{:>14}\n", e.number, e.quality, e.least,
                            e.bound > 0 ? fmt::format("{:.4g}", e.bound) : "-");
    return text;
}

std::string curved_unit_mesh_json(const CurvedUnitMeshReport& r) {
    auto j = nlohmann::ordered_json::parse(unit_mesh_json(r.unit_mesh));
    const auto json = [](const Element& e) {
        return nlohmann::ordered_json{
            {"element", e.number}, {"quality", e.quality}, {"least", e.least}, {"bound", e.bound}};
    };
    if (r.lowest.number > 0) {
        j["bound"] = r.bound;
        j["lowest"] = json(r.lowest);
    }
    j["worst"] = nlohmann::ordered_json::array();
    for (const Element& e : r.worst) j["worst"].push_back(json(e));
    return j.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<CurvedUnitMesh> measure_curved_unit_mesh<D>(const QuadraticMesh<D>&, const Column<LogMetric<D>>&, \
                                                                 std::string, std::size_t, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
