module;
#include <compare>
#include <cstddef>
#include <cstdint>
#include <vector>
module camber.distributed:curve_runs;
import camber.core;
import :ranks;

namespace camber {

/// Where an element is along a curve: by its first vertex there, then by its own number.
struct OnCurve {
    std::uint64_t key = 0;  ///< of the vertex
    std::uint64_t vertex = 0, element = 0;
    friend auto operator<=>(const OnCurve&, const OnCurve&) = default;
};
struct WeightOnCurve {
    OnCurve at;
    std::uint64_t weight = 0;
};

/// Where runs of about the same weight begin, of `in_a_run` elements each (ElementWeights): none of them is empty. Each
/// rank gives its own elements, rising; which it has does not matter to what comes out. Errors: of any rank.
[[nodiscard]] Outcome<std::vector<OnCurve>> starts_of_runs(Ranks& ranks, std::vector<WeightOnCurve> own,
                                                           std::size_t in_a_run);

}  // namespace camber
