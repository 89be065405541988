module;
#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
module camber.io:msh_types;

/// Gmsh's types of elements.
namespace camber::msh {

struct ElementType {
    std::int32_t number;
    int dimension;
    std::uint32_t nodes;
    std::string_view plural;
    int degree;
};

inline constexpr std::string_view lines = "edges", triangles = "triangles", quadrangles = "quadrangles",
                                  tetrahedra = "tetrahedra", hexahedra = "hexahedra", prisms = "prisms",
                                  pyramids = "pyramids";

/// Those that Camber holds, and those that it can name and step over.
inline constexpr auto element_types = std::to_array<ElementType>({
    {15, 0, 1, "points", 0},    {1, 1, 2, lines, 1},         {8, 1, 3, lines, 2},         {26, 1, 4, lines, 3},
    {27, 1, 5, lines, 4},       {28, 1, 6, lines, 5},        {2, 2, 3, triangles, 1},     {9, 2, 6, triangles, 2},
    {20, 2, 9, triangles, 3},   {21, 2, 10, triangles, 3},   {22, 2, 12, triangles, 4},   {23, 2, 15, triangles, 4},
    {24, 2, 15, triangles, 5},  {25, 2, 21, triangles, 5},   {3, 2, 4, quadrangles, 1},   {16, 2, 8, quadrangles, 2},
    {10, 2, 9, quadrangles, 2}, {36, 2, 16, quadrangles, 3}, {37, 2, 25, quadrangles, 4}, {38, 2, 36, quadrangles, 5},
    {4, 3, 4, tetrahedra, 1},   {11, 3, 10, tetrahedra, 2},  {29, 3, 20, tetrahedra, 3},  {30, 3, 35, tetrahedra, 4},
    {31, 3, 56, tetrahedra, 5}, {5, 3, 8, hexahedra, 1},     {17, 3, 20, hexahedra, 2},   {12, 3, 27, hexahedra, 2},
    {92, 3, 64, hexahedra, 3},  {93, 3, 125, hexahedra, 4},  {6, 3, 6, prisms, 1},        {18, 3, 15, prisms, 2},
    {13, 3, 18, prisms, 2},     {90, 3, 40, prisms, 3},      {91, 3, 75, prisms, 4},      {7, 3, 5, pyramids, 1},
    {19, 3, 13, pyramids, 2},   {14, 3, 14, pyramids, 2},    {118, 3, 30, pyramids, 3},   {119, 3, 55, pyramids, 4},
});

[[nodiscard]] constexpr const ElementType* find_type(std::int64_t number) {
    const auto* const found = std::find_if(element_types.begin(), element_types.end(),
                                           [&](const ElementType& type) { return type.number == number; });
    return found == element_types.end() ? nullptr : found;
}

[[nodiscard]] constexpr bool is_held(const ElementType& type) {
    return type.degree <= 2 &&
           (type.plural == lines || type.plural == triangles || type.plural == tetrahedra || type.dimension == 0);
}

[[nodiscard]] inline std::string name_of(const ElementType& type) {
    return std::string(type.plural) + (type.degree > 1 ? " of degree " + std::to_string(type.degree) : "");
}

/// The type of K-simplices with so many nodes that Camber holds.
template <int K, int Nodes>
inline constexpr std::int32_t simplex_type = [] {
    constexpr std::array<std::int32_t, 3> straight{1, 2, 4}, curved{8, 9, 11};
    return Nodes == K + 1 ? straight[K - 1] : curved[K - 1];
}();

/// Where our node i stands in Gmsh's row: the last two of tetrahedra of degree 2 change places.
template <int Nodes>
[[nodiscard]] constexpr int place_in_row(int i) {
    return Nodes == 10 && i >= 8 ? 17 - i : i;
}

}  // namespace camber::msh
