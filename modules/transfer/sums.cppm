module;
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
module camber.transfer:sums;
import camber.core;

namespace camber {

/// A sum that keeps what rounding takes from it (Neumaier 1974), and the sum of the terms' sizes.
struct Sum {
    double total = 0, rest = 0, size = 0;

    void add(double x) {
        const double next = total + x;
        rest += std::abs(total) >= std::abs(x) ? (total - next) + x : (x - next) + total;
        total = next;
        size += std::abs(x);
    }
    [[nodiscard]] double value() const { return total + rest; }
};

/// Sums by group of what `terms(slot, out)` writes for the slots below n, `columns` numbers each: group after group.
/// Terms are made in parallel and added in the order of the slots. A group of `no_group` is left out.
inline constexpr std::uint32_t no_group = 0xffffffffU;
template <class Terms>
[[nodiscard]] Outcome<std::vector<Sum>> sums_by_group(std::span<const std::uint32_t> group_of, std::size_t groups,
                                                      std::size_t columns, const Terms& terms,
                                                      const Execution& execution) {
    constexpr std::size_t block = 65536;
    std::vector<Sum> sums(groups * columns);
    Buffer<double> buffer(block * columns);
    for (std::size_t begin = 0; begin < group_of.size(); begin += block) {
        const std::size_t n = begin + block < group_of.size() ? block : group_of.size() - begin;
        auto done = each(execution, n,
                         [&](std::size_t i) { terms(begin + i, std::span(buffer).subspan(i * columns, columns)); });
        if (!done) return fail(done.error());
        for (std::size_t i = 0; i < n; ++i) {
            if (group_of[begin + i] == no_group) continue;
            Sum* const here = sums.data() + group_of[begin + i] * columns;
            for (std::size_t c = 0; c < columns; ++c) here[c].add(buffer[i * columns + c]);
        }
    }
    return sums;
}

}  // namespace camber
