module;
#include <array>
#include <bit>
#include <cstddef>
module camber.validity;
import camber.core;
import camber.bezier;
import :coefficients;
import :jacobian;
import :packs;

namespace camber {

template <int D>
std::array<LowJacobian, pack_size> low_jacobians(const NodalPack<D>& elements, Instructions set) {
    std::array<LowJacobian, pack_size> out;
    with_instructions(set, [&]() __attribute__((always_inline)) {
        const auto jacobian = jacobian_of_nodes<D, Pack>([&](int node, int c) __attribute__((always_inline)) {
            return std::bit_cast<Pack>(elements.nodes[node][c]);
        });
        Pack lowest = jacobian.coefficients[0];
        Pack sum = packed(0);
        for (const Pack& c : jacobian.coefficients) {
            lowest = min(c, lowest);
            sum += abs(c);
        }
        for (std::size_t lane = 0; lane < pack_size; ++lane)
            out[lane] = {lowest[lane], jacobian.straight[lane], jacobian.error[lane], sum[lane]};
    });
    return out;
}

#define CAMBER_INSTANTIATE(D) \
    template std::array<LowJacobian, pack_size> low_jacobians(const NodalPack<D>&, Instructions);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
