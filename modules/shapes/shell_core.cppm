module;
#include <cstdint>
export module camber.shapes:shell_core;
import camber.core;
import :layers;
import :random;
import :shell;

export namespace camber {

/// Which boundary of the shell, or which top of layers, a vertex lies on.
enum class ShellSide : std::uint8_t { between, inner, outer, above_inner_layer, above_outer_layer };

/// The shell without its layers, about the origin.
template <int D>
struct ShellCore {
    Buffer<Vec<D>> points;
    Buffer<ShellSide> sides;  ///< one a point
    Buffer<SimplexVertices<D>> elements;
    Buffer<SimplexVertices<D - 1>> inner, outer;  ///< facets; (their edges, the way outwards) are positive frames
};

/// Between spheres of `inner_radius` and `outer_radius` with edge lengths linear in the radius.
struct ShellSizes {
    double inner_radius, outer_radius, inner_size, outer_size, jitter;

    [[nodiscard]] double at(double radius) const {
        return inner_size + (outer_size - inner_size) * (radius - inner_radius) / (outer_radius - inner_radius);
    }
};

/// Of the shell without its layers.
template <int D>
[[nodiscard]] ShellSizes core_sizes(const ShellOptions<D>& o) {
    return {o.inner_radius + thickness(o.inner_layer), o.outer_radius - thickness(o.outer_layer), o.inner_size,
            o.outer_size, o.jitter};
}

/// Delaunay, after spreading and after moving the vertices of flat elements. The boundary of the hole is the star of a
/// vertex at the centre, which is taken out. Errors: usage (a point so near to a sphere that it pierces it); stopped.
template <int D>
[[nodiscard]] Outcome<ShellCore<D>> unstructured_core(const ShellSizes& sizes, const Noise& noise,
                                                      const Execution& execution);

/// How often the icosphere's edges are cut (the circle's fifths in 2D) for edges of inner_size, and the rows of prisms
/// that then have regular heights.
struct PrismCounts {
    double cuts, rows;
};
template <int D>
[[nodiscard]] PrismCounts prism_counts(const ShellSizes& sizes);

/// Rows of prisms over an icosphere. Has room for the prisms of `layers` more rows. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<ShellCore<D>> prism_core(const ShellSizes& sizes, int layers, const Noise& noise,
                                               const Execution& execution);

/// 1 for the regular simplex, 0 for a flat one, negative when inverted.
[[nodiscard]] double quality(const Vec<2>& a, const Vec<2>& b, const Vec<2>& c);
[[nodiscard]] double quality(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c, const Vec<3>& d);

}  // namespace camber
