module;
#include <cstdint>
#include <tuple>
export module camber.shapes:shell;
import camber.core;
import :layers;

export namespace camber {

/// How the volume between the spheres is filled.
enum class ShellStructure : std::uint8_t {
    unstructured,  ///< Delaunay of points spread to the sizes, flat elements moved away
    prisms,        ///< rows of prisms over a divided icosahedron, cut along random diagonals: fast at any size
};
[[nodiscard]] constexpr auto words(ShellStructure) {
    return words_of(Word{ShellStructure::unstructured, "unstructured"}, Word{ShellStructure::prisms, "prisms"});
}

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

    [[nodiscard]] static constexpr auto options() {
        using S = ShellOptions;
        return std::tuple(
            option("centre", &S::centre, (D == 3 ? "of both spheres" : "of both circles")).unit("model units"),
            option("inner_radius", &S::inner_radius,
                   (D == 3 ? "radius of the inner sphere" : "radius of the inner circle"))
                .unit("model units")
                .above(0),
            option("outer_radius", &S::outer_radius,
                   (D == 3 ? "radius of the outer sphere" : "radius of the outer circle"))
                .unit("model units")
                .above(0),
            option("inner_size", &S::inner_size,
                   (D == 3 ? "edge length at the inner sphere (above its layers)"
                           : "edge length at the inner circle (above its layers)"))
                .unit("model units")
                .above(0),
            option("outer_size", &S::outer_size,
                   (D == 3 ? "edge length at the outer sphere (below its layers); prisms ignore it"
                           : "edge length at the outer circle (below its layers); prisms ignore it"))
                .unit("model units")
                .above(0),
            option("inner_layer", &S::inner_layer,
                   (D == 3 ? "layers on the inner sphere" : "layers on the inner circle")),
            option("outer_layer", &S::outer_layer,
                   (D == 3 ? "layers on the outer sphere" : "layers on the outer circle")),
            option("structure", &S::structure,
                   "unstructured: Delaunay of spread points; prisms: rows of prisms along random diagonals, fast at "
                   "any size"),
            option("jitter", &S::jitter, "largest random move of a point")
                .unit("edge lengths")
                .at_least(0)
                .at_most(0.3),
            option("inner_reference", &S::inner_reference,
                   (D == 3 ? "reference of the inner sphere" : "reference of the inner circle")),
            option("outer_reference", &S::outer_reference,
                   (D == 3 ? "reference of the outer sphere" : "reference of the outer circle")),
            option("seed", &S::seed, "another seed, another mesh of the same kind; the same seed, the same bytes"));
    }
    friend bool operator==(const ShellOptions&, const ShellOptions&) = default;
};

/// Vertices of the two boundaries lie on the spheres to rounding. Errors: usage (radii, sizes and layers that do not
/// fit together); stopped.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> generate(const ShellOptions<D>& options, const Execution& execution = {});

}  // namespace camber
