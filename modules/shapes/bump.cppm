module;
#include <array>
#include <cstdint>
#include <tuple>
export module camber.shapes:bump;
import camber.core;
import :layers;

export namespace camber {

/// A 2D channel [0, length] × [0, height] whose floor rises as a smooth bump b(x) = bump_height (1 − s²)³,
/// s = 2 (x − length/2)/bump_width, |s| < 1 (twice continuously differentiable at its feet).
/// Facet references: 1 inlet (x = 0), 2 outlet, 3 floor, 4 ceiling; four corners.
struct BumpOptions {
    double length = 3, height = 1;             ///< of the channel (model units)
    double bump_height = 0.2, bump_width = 1;  ///< of the bump at the middle of the floor (model units)
    std::array<int, 2> cells{36, 8};           ///< along the channel, and across it above the layers
    BoundaryLayer floor_layer{.count = 0, .first_height = 0.01, .growth = 1.3};
    double jitter = 0.2;  ///< largest move of an inner vertex along each axis, in cell sizes
    std::uint64_t seed = 1;

    [[nodiscard]] static constexpr auto options() {
        using S = BumpOptions;
        return std::tuple(
            option("length", &S::length, "length of the channel").unit("model units").above(0),
            option("height", &S::height, "height of the channel").unit("model units").above(0),
            option("bump_height", &S::bump_height, "height of the bump in the middle; negative: a dent")
                .unit("model units"),
            option("bump_width", &S::bump_width, "from foot to foot").unit("model units").above(0),
            option("cells", &S::cells, "cells along the channel, and across it above the layers").at_least(1),
            option("floor_layer", &S::floor_layer, "layers on the floor"),
            option("jitter", &S::jitter, "largest random move of a vertex along each axis")
                .unit("cell sizes")
                .at_least(0)
                .at_most(0.5),
            option("seed", &S::seed, "another seed, another mesh of the same kind; the same seed, the same bytes"));
    }
    friend bool operator==(const BumpOptions&, const BumpOptions&) = default;
};

/// b(x).
[[nodiscard]] double floor_height(const BumpOptions& options, double x);

/// Errors: usage (sizes that do not fit together); stopped.
[[nodiscard]] Outcome<LinearMesh<2>> generate(const BumpOptions& options, const Execution& execution = {});

}  // namespace camber
