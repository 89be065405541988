module;
#include <array>
#include <string_view>
module camber.io:mfem_order;
import camber.core;

namespace camber::mfem {

/// What files begin with: without and with names of attributes.
inline constexpr std::string_view first_line = "MFEM mesh v1.0", first_line_of_names = "MFEM mesh v1.3";

/// MFEM's number of the geometry of a K-simplex.
template <int K>
inline constexpr int geometry = K == 3 ? 4 : K;

/// The edges of a K-simplex in MFEM's order, as they count in `local_edges`: 01 02 03 12 13 23 of a tetrahedron, 01 12
/// 20 of a triangle.
template <int K>
inline constexpr auto edge_order = [] {
    if constexpr (K == 3)
        return std::array{0, 2, 3, 1, 4, 5};
    else if constexpr (K == 2)
        return std::array{0, 1, 2};
    else
        return std::array{0};
}();

}  // namespace camber::mfem
