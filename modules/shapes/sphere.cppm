module;
#include <array>
#include <cstddef>
#include <cstdint>
export module camber.shapes:sphere;
import camber.core;
import :random;

export namespace camber {

/// n points spread evenly over the unit sphere along a golden-angle spiral (over the unit circle in 2D: equal angles),
/// turned at random.
template <int D>
[[nodiscard]] Buffer<Vec<D>> spread_points(std::size_t n, const Noise& noise);

/// Triangles (edges of a circle in 2D) with vertices on the unit sphere, counter-clockwise seen from outside.
template <int D>
struct UnitSphere {
    Buffer<Vec<D>> points;
    Buffer<SimplexVertices<D - 1>> facets;
};

/// An icosahedron whose edges are cut into n, put on the unit sphere: 10 n² + 2 vertices (2D: 5 n edges).
template <int D>
[[nodiscard]] UnitSphere<D> icosphere(int n);

}  // namespace camber
