module;
#include <cstdint>
export module camber.shapes:shell;
import camber.core;
import :layers;

export namespace camber {

/// How the volume between the spheres is filled.
enum class ShellStructure : std::uint8_t {
    unstructured,  ///< Delaunay of points spread to the sizes, flat elements moved away
    prisms,        ///< rows of prisms over a divided icosahedron, cut along random diagonals: fast at any size
};

/// The volume between two concentric spheres (the annulus between two circles in 2D), with boundary layers on
/// either. With layers, the volume between them has inner_size at the inner layers' top and outer_size at the outer's.
template <int D>
struct ShellOptions {
    Vec<D> centre{};
    double inner_radius = 1, outer_radius = 5;  ///< (model units)
    double inner_size = 0.6, outer_size = 1.8;  ///< edge lengths at the spheres (model units), linear in between
    BoundaryLayer inner_layer{}, outer_layer{};
    ShellStructure structure = ShellStructure::unstructured;
    double jitter = 0.15;  ///< largest move of a point off its regular place, in edge lengths
    Reference inner_reference = 2, outer_reference = 1;
    std::uint64_t seed = 1;

    friend bool operator==(const ShellOptions&, const ShellOptions&) = default;
};

/// Vertices of the two boundaries lie on the spheres to rounding. Errors: usage (radii, sizes and layers that do not
/// fit together).
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> generate(const ShellOptions<D>& options);

}  // namespace camber
