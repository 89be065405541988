module;
#include <array>
#include <cstddef>
#include <cstdint>
export module camber.drawing:drawn_face;
import camber.core;

/// A face on paper: a triangle of degree 2 again, since the projection is affine.
export namespace camber {

/// How an edge of a face is drawn.
enum class LineKind : std::uint8_t { none, shared, rim };

struct DrawnFace {
    std::array<Vec<3>, 6> nodes;      ///< on paper (pixels), as `Face` has them
    std::array<float, 6> values{};    ///< at the nodes
    std::array<LineKind, 3> lines{};  ///< of the edges 01, 12, 20
    bool is_marked = false;
    std::uint32_t face = 0;
};

using FacePoint = std::array<double, 3>;  ///< barycentric coordinates on a patch

/// Σ of the Lagrange functions of degree 2 times what is at the nodes.
[[nodiscard]] constexpr Vec<3> point_at(const std::array<Vec<3>, 6>& nodes, const FacePoint& xi) {
    Vec<3> sum{};
    for (std::size_t i = 0; i < 3; ++i) {
        sum += vertex_shape(xi[i]) * nodes[i];
        sum += edge_shape<2>(xi, static_cast<int>(i)) * nodes[3 + i];
    }
    return sum;
}
[[nodiscard]] constexpr double value_at(const std::array<float, 6>& values, const FacePoint& xi) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        sum += static_cast<double>(values[i]) * vertex_shape(xi[i]);
        sum += static_cast<double>(values[3 + i]) * edge_shape<2>(xi, static_cast<int>(i));
    }
    return sum;
}

/// The normal on paper, of no unit length, towards the side from which the corners turn counter-clockwise.
[[nodiscard]] constexpr Vec<3> normal_at(const std::array<Vec<3>, 6>& n, const FacePoint& xi) {
    std::array<Vec<3>, 3> partial{};
    for (std::size_t i = 0; i < 3; ++i) {
        partial[i] += (4 * xi[i] - 1) * n[i];
        add_edge_derivatives<2>(xi, static_cast<int>(i), n[3 + i], partial);
    }
    // y is downwards on paper: what is counter-clockwise to the viewer has a positive z so.
    return cross(partial[2] - partial[0], partial[1] - partial[0]);
}

/// How bright a place is whose normal is turned to the viewer: a lamp above the viewer's left shoulder, and the room.
[[nodiscard]] inline double brightness(const std::array<Vec<3>, 6>& nodes, const FacePoint& xi) {
    Vec<3> n = normalised(normal_at(nodes, xi));
    if (n[2] < 0) n = -n;
    constexpr Vec<3> lamp{{-0.41, -0.51, 0.756}};  // y is downwards
    const double direct = dot(n, lamp), above = 0.5 - 0.5 * n[1];
    return 0.52 + 0.08 * above + 0.45 * (direct > 0 ? direct : 0);
}

/// The control point of an edge's Bézier form, from its ends and the node on it.
[[nodiscard]] constexpr Vec<3> control_point(const Vec<3>& a, const Vec<3>& b, const Vec<3>& middle) {
    return 2.0 * middle - 0.5 * (a + b);
}
[[nodiscard]] constexpr Vec<3> control_point(const DrawnFace& patch, std::size_t edge) {
    return control_point(patch.nodes[edge], patch.nodes[(edge + 1) % 3], patch.nodes[3 + edge]);
}

/// The box of the control points, in which the patch lies.
[[nodiscard]] constexpr Box<3> box_of(const DrawnFace& patch) {
    Box<3> box;
    for (std::size_t i = 0; i < 3; ++i) {
        box.include(patch.nodes[i]);
        box.include(control_point(patch, i));
    }
    return box;
}

}  // namespace camber
