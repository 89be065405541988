module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <vector>
module camber.shapes:box_places;
import camber.core;
import :box;
import :jitter;
import :random;

namespace camber {

/// Errors: usage, of options that `generate` does not take.
template <int D>
[[nodiscard]] Outcome<Done> check_box(const BoxOptions<D>& options);

/// Simplices of the lattice, dimension by dimension: each is the extrusion of the one below. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<SimplexVertices<D>>> lattice_simplices(std::span<const int, D> cells, const Noise& noise,
                                                                    const Execution& execution);

/// Where the lattice's planes are along one axis, from 0 to 1. Even ones are exact quotients.
[[nodiscard]] inline std::vector<double> lattice_planes(int cells, double grading) {
    std::vector<double> at(static_cast<std::size_t>(cells) + 1);
    if (grading == 1 || cells == 1) {
        for (int k = 0; k <= cells; ++k) at[k] = static_cast<double>(k) / cells;
        return at;
    }
    const double log_ratio = log(grading) / (cells - 1);
    for (int k = 0; k <= cells; ++k) at[k] = expm1(k * log_ratio) / expm1(cells * log_ratio);
    at.back() = 1;
    return at;
}

/// No element is bent to less than this part of its volume.
inline constexpr double least_bent = 0.05;

/// The vertices of a box's lattice by number: where they lie, and where its options would have them.
template <int D>
class BoxPlaces {
  public:
    explicit BoxPlaces(const BoxOptions<D>& options)
        : options_(options), noise_(Noise{options.seed}.stream(100)), lattice_{options.cells, {}, {}} {
        for (int i = 0; i < D; ++i) axes_[i] = lattice_planes(options.cells[i], options.grading[i]);
    }

    [[nodiscard]] const Lattice<D>& lattice() const { return lattice_; }
    [[nodiscard]] bool bends() const { return options_.warp != 0; }
    [[nodiscard]] Vec<D> regular(std::size_t v) const {
        const auto place = lattice_.place(v);
        Vec<D> p;
        // std::lerp is exact at both ends: sides are planes to the last bit.
        for (int i = 0; i < D; ++i) p[i] = std::lerp(options_.low[i], options_.high[i], axes_[i][place[i]]);
        return p;
    }
    /// A vertex at p moved by warp, where it is inside.
    [[nodiscard]] Vec<D> bent(std::size_t v, const Vec<D>& p) const {
        if (lattice_.on_boundary(v)) return p;
        const auto place = lattice_.place(v);
        double move = options_.warp;
        for (int i = 0; i < D; ++i) move *= sin(2 * std::numbers::pi * axes_[i][place[i]]);
        return p + move * (options_.high - options_.low);
    }
    /// A vertex at p moved at random, on a side along it.
    [[nodiscard]] Vec<D> jittered(std::size_t v, Vec<D> p) const {
        const auto place = lattice_.place(v);
        const Vec<D> shift = options_.jitter * noise_.template vector<D>(v);
        for (int i = 0; i < D; ++i) {
            const bool free = place[i] > 0 && place[i] < options_.cells[i];
            p[i] += free ? shift[i] * cell_length(i, place[i]) : 0.0;
        }
        return p;
    }

  private:
    /// The shorter of the two cells at an inner plane of an axis.
    [[nodiscard]] double cell_length(int axis, int k) const {
        const std::vector<double>& planes = axes_[axis];
        const double length = options_.high[axis] - options_.low[axis];
        if (options_.grading[axis] == 1) return length / static_cast<double>(planes.size() - 1);
        return length * std::min(planes[k + 1] - planes[k], planes[k] - planes[k - 1]);
    }

    BoxOptions<D> options_;
    Noise noise_;
    Lattice<D> lattice_;
    std::array<std::vector<double>, D> axes_;  ///< the planes along each, in the unit box
};

}  // namespace camber
