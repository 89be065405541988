module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>
export module camber.run:histogram;

export namespace camber::run {

/// What is counted, each with bins of its own that never change, so that runs can be compared.
enum class Quantity : std::uint8_t {
    length_reduction,
    length,
    curvature,
    scaled_jacobian,
    quality,
    edge_length,
    metric_quality,
    curved_edge_length,
    curved_metric_quality
};
inline constexpr std::size_t quantity_count = 9;
inline constexpr std::size_t run_quantity_count =
    4;  ///< those of runs, the first; the others are of meshes that are checked

struct QuantityInfo {
    Quantity quantity;
    std::string_view key;     ///< in report.json
    std::string_view title;   ///< of a plot
    std::string_view axis;    ///< what the numbers are, with their unit
    std::string_view things;  ///< what is counted
    int base;                 ///< limits at its whole powers are numbered first on an axis
};
[[nodiscard]] const QuantityInfo& info(Quantity quantity);

/// The limits of a quantity's bins, rising and finer towards the tails, by decades where values span them:
/// - length_reduction: −0.1, −0.01, −0.001, 0, 1e-5, 1e-4, then 1, 1.5, 2, 3, 5, 7 a decade from 0.001 to 100;
/// - length in the metric: 2^-10 … 2^10 by octaves, by quarters of them from 2^-3 to 2^3;
/// - curvature: 0, then 1, 1.5, 2, 3, 5, 7 a decade from 0.001 to 10;
/// - scaled Jacobian and quality: −10, −1, −0.1, −0.01, −0.001, −1e-6, −1e-9, 0, then 1e-9 … 0.001 by decades,
///   0.005, 0.02, and 0.05, 0.1 … 1.
[[nodiscard]] std::vector<double> limits_of(Quantity quantity);

/// What the open bins at the ends hold at most.
struct Extremes {
    double least = 0, greatest = 0;
    friend bool operator==(const Extremes&, const Extremes&) = default;
};

/// The counts of one state of the mesh. There is one more than there are limits: below the first limit, from each
/// limit (included) to the next, and from the last up; so −∞ counts in the first and ∞ in the last. NaN counts in none
/// of them: with `not_numbers` the counts sum to the number of values.
struct Series {
    std::string name;  ///< "straight", "before", "after" (correction), "count"
    std::vector<std::size_t> counts;
    double mean = 0;                   ///< of the finite values; 0 without any
    std::optional<Extremes> extremes;  ///< of the finite values, if there are any
    std::size_t not_numbers = 0;
    friend bool operator==(const Series&, const Series&) = default;
};

struct Histogram {
    Quantity quantity = Quantity::length_reduction;
    std::vector<double> limits;
    std::vector<Series> series;
    friend bool operator==(const Histogram&, const Histogram&) = default;
};

[[nodiscard]] Series counted(std::string name, std::span<const double> limits, std::span<const double> values);

[[nodiscard]] const Series* find_series(const Histogram& histogram, std::string_view name);

/// Bars for a terminal, the series side by side, without colours: about 100 columns at most. Bins that are empty in all
/// series are left out at either end, and are one row where several follow each other on one side of zero.
[[nodiscard]] std::string bars(const Histogram& histogram);

/// The histograms as an object of JSON, by their keys.
[[nodiscard]] std::string histograms_json(const std::vector<Histogram>& histograms);

/// The histograms of a report.json, also of one without extremes (written before there were). Nothing when the text is
/// no JSON object with histograms as Camber writes them.
[[nodiscard]] std::optional<std::vector<Histogram>> histograms_of_report(std::string_view json);

}  // namespace camber::run
