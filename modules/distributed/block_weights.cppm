module;
#include <cstddef>
#include <cstdint>
export module camber.distributed:block_weights;
import camber.core;
import :adaptation_rows;

export namespace camber {

/// How many elements each is to become, in parts of 256 that add up in any order to the same.
struct ElementWeights {
    static constexpr std::uint64_t one = 256;
    Buffer<std::uint64_t> weights;  ///< one an element, at least `one`
    std::uint64_t sum = 0;

    [[nodiscard]] double elements() const { return static_cast<double>(sum) / static_cast<double>(one); }
};

/// By the volume of each element in the metric over that of a unit simplex, with all sizes `coarser` times as large;
/// elements that are to become fewer count as they are. Errors: stopped, memory.
template <int D>
[[nodiscard]] Outcome<ElementWeights> expected_elements(const AdaptationRows<D>& rows, double coarser,
                                                        const Execution& execution);

}  // namespace camber
