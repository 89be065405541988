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
enum class Quantity : std::uint8_t { length_gain, length, curvature, normalised_jacobian, quality };
inline constexpr std::size_t quantity_count = 5;
inline constexpr std::size_t run_quantity_count =
    4;  ///< those of runs; `quality` is of straight meshes that are checked

/// How the limits of the bins grow.
enum class Scale : std::uint8_t { linear, log2 };

struct QuantityInfo {
    Quantity quantity;
    std::string_view key;     ///< in report.json
    std::string_view title;   ///< of a plot
    std::string_view axis;    ///< what the numbers are, with their unit
    std::string_view things;  ///< what is counted
    Scale scale;
};
[[nodiscard]] const QuantityInfo& info(Quantity quantity);

/// The limits of a quantity's bins, rising: gain 0, 0.02 … 0.5; length in the metric 2^-3, 2^-2.75 … 2^3; curvature 0,
/// 0.02 … 0.5; normalised Jacobian and quality 0, 0.05 … 1.
[[nodiscard]] std::vector<double> limits_of(Quantity quantity);

/// The counts of one state of the mesh. There is one more than there are limits: below the first limit, from each
/// limit (included) to the next, and from the last up. `mean` is that of the finite values; 0 without any.
struct Series {
    std::string name;  ///< "straight", "before", "after" (correction), "count"
    std::vector<std::size_t> counts;
    double mean = 0;
    friend bool operator==(const Series&, const Series&) = default;
};

struct Histogram {
    Quantity quantity = Quantity::length_gain;
    std::vector<double> limits;
    std::vector<Series> series;
    friend bool operator==(const Histogram&, const Histogram&) = default;
};

/// NaN counts in no bin.
[[nodiscard]] Series counted(std::string name, std::span<const double> limits, std::span<const double> values);

[[nodiscard]] const Series* find_series(const Histogram& histogram, std::string_view name);

/// Bars for a terminal, the series side by side, without colours: about 100 columns at most. Bins that are empty in all
/// series at either end are left out.
[[nodiscard]] std::string bars(const Histogram& histogram);

/// The histograms as an object of JSON, by their keys.
[[nodiscard]] std::string histograms_json(const std::vector<Histogram>& histograms);

/// The histograms of a report.json. Nothing when the text is no JSON object with histograms as Camber writes them.
[[nodiscard]] std::optional<std::vector<Histogram>> histograms_of_report(std::string_view json);

}  // namespace camber::run
