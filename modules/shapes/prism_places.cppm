module;
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>
module camber.shapes:prism_places;
import camber.core;
import :layers;
import :random;
import :shell;
import :shell_core;

namespace camber {

/// Errors: usage, of options that `generate` does not take.
template <int D>
[[nodiscard]] Outcome<Done> check_shell(const ShellOptions<D>& options);

/// The radii of layers from the core to the wall; the core's own is not among them.
[[nodiscard]] inline std::vector<double> layer_radii(std::vector<double> from_wall, double wall) {
    if (from_wall.empty()) return from_wall;
    from_wall.pop_back();
    std::ranges::reverse(from_wall);
    from_wall.push_back(wall);
    return from_wall;
}
template <int D>
[[nodiscard]] std::vector<double> inner_layer_radii(const ShellOptions<D>& o) {
    std::vector<double> radii = layer_distances(o.inner_layer);
    for (double& r : radii) r = o.inner_radius + r;
    return layer_radii(std::move(radii), o.inner_radius);
}
template <int D>
[[nodiscard]] std::vector<double> outer_layer_radii(const ShellOptions<D>& o) {
    std::vector<double> radii = layer_distances(o.outer_layer);
    for (double& r : radii) r = o.outer_radius - r;
    return layer_radii(std::move(radii), o.outer_radius);
}

/// The radii of the spheres that the vertices of rows of prisms lie on.
[[nodiscard]] inline std::vector<double> row_radii(const ShellSizes& sizes, std::size_t rows) {
    const double step = pow(sizes.outer_radius / sizes.inner_radius, 1.0 / static_cast<double>(rows));
    std::vector<double> radii{sizes.inner_radius};
    while (radii.size() <= rows) radii.push_back(radii.back() * step);
    radii.back() = sizes.outer_radius;
    return radii;
}

/// The vertices of rows of prisms by number: those of a sphere, in the order of `directions`, after those of the sphere
/// within it.
template <int D>
struct PrismPlaces {
    ShellSizes sizes{};
    std::vector<double> radii;
    Buffer<Vec<D>> directions;
    Noise noise;

    [[nodiscard]] std::size_t size() const { return radii.size() * directions.size(); }
    [[nodiscard]] ShellSide side(std::size_t v) const {
        const std::size_t k = v / directions.size();
        return k == 0 ? ShellSide::inner : k + 1 == radii.size() ? ShellSide::outer : ShellSide::between;
    }
    [[nodiscard]] Vec<D> regular(std::size_t v) const {
        return radii[v / directions.size()] * directions[v % directions.size()];
    }
    /// Where jitter would have it.
    [[nodiscard]] Vec<D> moved(std::size_t v) const {
        const double radius = radii[v / directions.size()];
        const double shift = sizes.jitter * sizes.inner_size * radius / sizes.inner_radius;
        const Vec<D> away = regular(v) + shift * noise.template vector<D>(v);
        return side(v) == ShellSide::between ? away : radius * normalised(away);
    }
    /// Its last place, from where jitter left it: that of a wall on its sphere.
    [[nodiscard]] Vec<D> settled(std::size_t v, const Vec<D>& p) const {
        switch (side(v)) {
            case ShellSide::inner: return sizes.inner_radius * normalised(p);
            case ShellSide::outer: return sizes.outer_radius * normalised(p);
            default: return p;
        }
    }
};

}  // namespace camber
