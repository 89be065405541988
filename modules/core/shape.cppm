module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
/// Element shapes: constant tables, and numbers of nodes by degree.
export module camber.core:shape;

export namespace camber {

enum class Shape : std::uint8_t { line, triangle, quadrilateral, tetrahedron, prism, pyramid, hexahedron };

/// A face of a shape. Its corners are counter-clockwise seen from outside.
struct ShapeFace {
    Shape shape = Shape::triangle;
    std::array<int, 4> corners{};
};

/// Array entries beyond the counts are not used. Only shapes of dimension 3 have faces.
struct ShapeTable {
    int dimension = 0, corner_count = 0, edge_count = 0, face_count = 0;
    std::array<std::array<int, 3>, 8> coordinates{};  ///< corner coordinates, each 0 or 1
    std::array<std::array<int, 2>, 12> edges{};
    std::array<ShapeFace, 6> faces{};
};

}  // namespace camber

namespace camber {

/// Makes a table from texts of digits: the coordinates of each corner, and the corners of each edge and face.
constexpr ShapeTable table_from(int dimension, std::string_view corners, std::string_view edges,
                                std::string_view faces) {
    const auto each_word = [](std::string_view words, auto read) {
        int count = 0;
        while (!words.empty()) {
            const std::size_t length = words.find(' ') == words.npos ? words.size() : words.find(' ');
            read(count++, words.substr(0, length));
            words.remove_prefix(length == words.size() ? length : length + 1);
        }
        return count;
    };
    ShapeTable table{.dimension = dimension};
    table.corner_count = each_word(corners, [&](int i, std::string_view word) {
        for (std::size_t k = 0; k < word.size(); ++k) table.coordinates[i][k] = word[k] - '0';
    });
    table.edge_count =
        each_word(edges, [&](int i, std::string_view word) { table.edges[i] = {word[0] - '0', word[1] - '0'}; });
    table.face_count = each_word(faces, [&](int i, std::string_view word) {
        table.faces[i].shape = word.size() == 3 ? Shape::triangle : Shape::quadrilateral;
        for (std::size_t k = 0; k < word.size(); ++k) table.faces[i].corners[k] = word[k] - '0';
    });
    return table;
}

}  // namespace camber

export namespace camber {

/// The tables of simplices have the order of `SimplexVertices` and `local_edges`. Other solids have a bottom face,
/// whose corners are counter-clockwise seen from above, and a top. The apex of the reference pyramid is above corner 0.
/// A shear moves the apex to any position.
template <Shape shape>
inline constexpr ShapeTable shape_table = [] {
    switch (shape) {
        case Shape::line: return table_from(1, "0 1", "01", "");
        case Shape::triangle: return table_from(2, "00 10 01", "01 12 20", "");
        case Shape::quadrilateral: return table_from(2, "00 10 11 01", "01 12 23 30", "");
        case Shape::tetrahedron: return table_from(3, "000 100 010 001", "01 12 20 03 13 23", "123 032 013 021");
        case Shape::prism:
            return table_from(3, "000 100 010 001 101 011", "01 12 20 34 45 53 03 14 25", "021 345 0143 1254 2035");
        case Shape::pyramid:
            return table_from(3, "000 100 110 010 001", "01 12 23 30 04 14 24 34", "0321 014 124 234 304");
        case Shape::hexahedron:
            return table_from(3, "000 100 110 010 001 101 111 011", "01 12 23 30 45 56 67 74 04 15 26 37",
                              "0321 4567 0154 1265 2376 3047");
    }
}();

template <int K>
inline constexpr Shape simplex = K == 1   ? Shape::line
                                 : K == 2 ? Shape::triangle
                                          : Shape::tetrahedron;

[[nodiscard]] constexpr const char* name_of(Shape shape) {
    constexpr std::array names{"edge", "triangle", "quadrilateral", "tetrahedron", "prism", "pyramid", "hexahedron"};
    return names[static_cast<std::size_t>(shape)];
}
[[nodiscard]] constexpr const char* plural_of(Shape shape) {
    constexpr std::array names{"edges", "triangles", "quadrilaterals", "tetrahedra", "prisms", "pyramids", "hexahedra"};
    return names[static_cast<std::size_t>(shape)];
}

[[nodiscard]] constexpr bool is_simplex(Shape shape) {
    return shape == Shape::line || shape == Shape::triangle || shape == Shape::tetrahedron;
}

/// Number of equispaced nodes in the interior of a shape, for degree k ≥ 1.
[[nodiscard]] constexpr int inner_node_count(Shape shape, int k) {
    const int n = k - 1;
    switch (shape) {
        case Shape::line: return n;
        case Shape::triangle: return n * (n - 1) / 2;
        case Shape::quadrilateral: return n * n;
        case Shape::tetrahedron: return n * (n - 1) * (n - 2) / 6;
        case Shape::prism: return n * n * (n - 1) / 2;
        case Shape::pyramid: return n * (n - 1) * (2 * n - 1) / 6;
        case Shape::hexahedron: return n * n * n;
    }
    return 0;
}

/// Number of nodes of the complete element, for degree k ≥ 1.
template <Shape shape, int k>
inline constexpr int element_nodes = [] {
    constexpr ShapeTable table = shape_table<shape>;
    int count = table.corner_count + inner_node_count(shape, k);
    if (table.dimension > 1) count += table.edge_count * inner_node_count(Shape::line, k);
    for (int f = 0; f < table.face_count; ++f) count += inner_node_count(table.faces[f].shape, k);
    return count;
}();

/// Nodes of the complete Lagrange element, as reference coordinates times the degree. Order: corners; edges, from their
/// first to their second corner; faces, along their first edge, then along their last; interior, with the first
/// coordinate fastest.
template <Shape shape, int degree>
inline constexpr auto lagrange_nodes = [] {
    using Node = std::array<int, 3>;
    constexpr ShapeTable table = shape_table<shape>;
    std::array<Node, element_nodes<shape, degree>> nodes{};
    int count = 0;
    const auto add = [&](const Node& node) { nodes[count++] = node; };
    const auto along = [&](const Node& from, int corner, int towards, int steps) {
        Node node = from;
        for (int d = 0; d < 3; ++d) node[d] += steps * (table.coordinates[towards][d] - table.coordinates[corner][d]);
        return node;
    };
    for (int c = 0; c < table.corner_count; ++c) add(along({}, 0, c, degree));
    if constexpr (table.dimension > 1)
        for (int e = 0; e < table.edge_count; ++e)
            for (int i = 1; i < degree; ++i)
                add(along(nodes[table.edges[e][0]], table.edges[e][0], table.edges[e][1], i));
    for (int f = 0; f < table.face_count; ++f) {
        const auto& [face, corners] = table.faces[f];
        const bool is_triangle = face == Shape::triangle;
        for (int j = 1; j < degree; ++j)
            for (int i = 1; i < (is_triangle ? degree - j : degree); ++i)
                add(along(along(nodes[corners[0]], corners[0], corners[1], i), corners[0],
                          is_triangle ? corners[2] : corners[3], j));
    }
    const auto is_inside = [](const Node& node) {
        const int x = node[0], y = node[1], z = node[2];
        switch (shape) {
            case Shape::line:
            case Shape::quadrilateral:
            case Shape::hexahedron: return true;
            case Shape::triangle:
            case Shape::prism: return x + y < degree;
            case Shape::tetrahedron: return x + y + z < degree;
            case Shape::pyramid: return std::max(x, y) + z < degree;
        }
        return false;
    };
    constexpr int rows = table.dimension > 1 ? degree : 2, layers = table.dimension > 2 ? degree : 2;
    for (int z = 1; z < layers; ++z)
        for (int y = 1; y < rows; ++y)
            for (int x = 1; x < degree; ++x) {
                const Node node{x, table.dimension > 1 ? y : 0, table.dimension > 2 ? z : 0};
                if (is_inside(node)) add(node);
            }
    return nodes;
}();

}  // namespace camber
