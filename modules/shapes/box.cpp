module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <vector>
module camber.shapes;
import camber.core;

namespace camber {

namespace {

/// Simplices of the lattice, dimension by dimension: each is the extrusion of the one below.
template <int D>
Outcome<Buffer<SimplexVertices<D>>> lattice_simplices(std::span<const int, D> cells, const Noise& noise,
                                                      const Execution& execution) {
    if constexpr (D == 1) {
        return map_each(execution, static_cast<std::size_t>(cells[0]),
                        [](std::size_t i) { return SimplexVertices<1>{VertexId(i), VertexId(i + 1)}; });
    } else {
        const auto base = lattice_simplices<D - 1>(cells.template first<D - 1>(), noise, execution);
        if (!base) return fail(base.error());
        std::size_t row = 1;
        for (int i = 0; i + 1 < D; ++i) row *= static_cast<std::size_t>(cells[i]) + 1;
        const auto rows = static_cast<std::size_t>(cells[D - 1]);
        Buffer<SimplexVertices<D>> simplices(D * base->size() * rows);
        auto done = extrude_rows<D>(*base, row, rows, noise.stream(D), 0, simplices, execution);
        if (!done) return fail(done.error());
        return simplices;
    }
}

template <int D>
Outcome<Done> check(const BoxOptions<D>& options) {
    double vertices = 1;
    for (int i = 0; i < D; ++i) {
        if (options.cells[i] < 1) return fail(ErrorKind::usage, "a box needs at least one cell along each axis");
        if (!(options.high[i] > options.low[i])) return fail(ErrorKind::usage, "a box needs high above low");
        vertices *= options.cells[i] + 1.0;
    }
    if (vertices * 6 > static_cast<double>(max_entities)) return fail(ErrorKind::usage, "a box of too many cells");
    return Done{};
}

/// Where the lattice's planes are along one axis, from 0 to 1. Even ones are exact quotients.
std::vector<double> planes(int cells, double grading) {
    std::vector<double> at(static_cast<std::size_t>(cells) + 1);
    if (grading == 1 || cells == 1) {
        for (int k = 0; k <= cells; ++k) at[k] = static_cast<double>(k) / cells;
        return at;
    }
    const double log_ratio = std::log(grading) / (cells - 1);
    for (int k = 0; k <= cells; ++k) at[k] = std::expm1(k * log_ratio) / std::expm1(cells * log_ratio);
    at.back() = 1;
    return at;
}

/// The shorter of the two cells at an inner plane of an axis of that length.
double cell_length(const std::vector<double>& planes, bool even, int k, double length) {
    if (even) return length / static_cast<double>(planes.size() - 1);
    return length * std::min(planes[k + 1] - planes[k], planes[k] - planes[k - 1]);
}

/// The planes of a lattice along each axis, in the unit box.
template <int D>
using Planes = std::array<std::vector<double>, D>;

/// Puts the lattice's points into the box.
template <int D>
Outcome<Done> place_points(Lattice<D>& lattice, const BoxOptions<D>& options, const Planes<D>& axes,
                           const Execution& execution) {
    return each(execution, lattice.points.size(), [&](std::size_t v) {
        const auto place = lattice.place(v);
        // std::lerp is exact at both ends: sides are planes to the last bit.
        for (int i = 0; i < D; ++i)
            lattice.points[v][i] = std::lerp(options.low[i], options.high[i], axes[i][place[i]]);
    });
}

/// Moves what is inside by warp, but no element to less than a twentieth of its volume.
template <int D>
Outcome<Done> bend(Lattice<D>& lattice, const BoxOptions<D>& options, const Planes<D>& axes,
                   const Execution& execution) {
    if (options.warp == 0) return Done{};
    auto bent = map_each(execution, lattice.points.size(), [&](std::size_t v) {
        const auto place = lattice.place(v);
        Vec<D> p = lattice.points[v];
        if (lattice.on_boundary(v)) return p;
        double move = options.warp;
        for (int i = 0; i < D; ++i) move *= std::sin(2 * std::numbers::pi * axes[i][place[i]]);
        return p + move * (options.high - options.low);
    });
    if (!bent) return fail(bent.error());
    return move_points<D>(lattice.points, *bent, lattice.elements, 0.05, execution);
}

/// Moves points at random.
template <int D>
Outcome<Done> jitter(Lattice<D>& lattice, const BoxOptions<D>& options, const Planes<D>& axes,
                     const Execution& execution) {
    const Noise noise = Noise{options.seed}.stream(100);
    auto moved = map_each(execution, lattice.points.size(), [&](std::size_t v) {
        const auto place = lattice.place(v);
        const Vec<D> shift = options.jitter * noise.vector<D>(v);
        Vec<D> p = lattice.points[v];
        for (int i = 0; i < D; ++i) {
            const bool free = place[i] > 0 && place[i] < options.cells[i];
            const double length = options.high[i] - options.low[i];
            p[i] += free ? shift[i] * cell_length(axes[i], options.grading[i] == 1, place[i], length) : 0.0;
        }
        return p;
    });
    if (!moved) return fail(moved.error());
    return move_points<D>(lattice.points, *moved, lattice.elements, 0.2, execution);
}

template <int D>
Outcome<LinearMesh<D>> generate_box(const BoxOptions<D>& options, const Execution& execution) {
    if (auto checked = check(options); !checked) return fail(checked.error());
    auto lattice = lattice_of<D>(options.cells, options.seed, execution);
    if (!lattice) return fail(lattice.error());
    Planes<D> axes;
    for (int i = 0; i < D; ++i) axes[i] = planes(options.cells[i], options.grading[i]);
    auto done = place_points<D>(*lattice, options, axes, execution);
    if (done) done = bend<D>(*lattice, options, axes, execution);
    if (done) done = jitter<D>(*lattice, options, axes, execution);
    if (!done) return fail(done.error());
    auto points = std::move(lattice->points);
    auto elements = std::move(lattice->elements);
    return bounded_mesh<D>(
        std::move(points), std::move(elements),
        [&](const SimplexVertices<D - 1>& facet) { return lattice->side(facet); },
        [&](VertexId v) { return lattice->on_boundary(v.index()); }, execution);
}

}  // namespace

template <int D>
Outcome<Lattice<D>> lattice_of(const std::array<int, D>& cells, std::uint64_t seed, const Execution& execution) {
    auto elements = lattice_simplices<D>(std::span<const int, D>(cells), Noise{seed}, execution);
    if (!elements) return fail(elements.error());
    Lattice<D> lattice{cells, {}, std::move(*elements)};
    std::size_t count = 1;
    for (const int n : cells) count *= static_cast<std::size_t>(n) + 1;
    auto points = map_each(execution, count, [&](std::size_t v) {
        const auto place = lattice.place(v);
        Vec<D> p;
        for (int i = 0; i < D; ++i) p[i] = static_cast<double>(place[i]) / cells[i];
        return p;
    });
    if (!points) return fail(points.error());
    lattice.points = std::move(*points);
    return lattice;
}

template <int D>
Outcome<LinearMesh<D>> generate(const BoxOptions<D>& options, const Execution& execution) {
    return guarded([&] { return generate_box(options, execution); });
}

template Outcome<Lattice<2>> lattice_of<2>(const std::array<int, 2>&, std::uint64_t, const Execution&);
template Outcome<Lattice<3>> lattice_of<3>(const std::array<int, 3>&, std::uint64_t, const Execution&);
template Outcome<LinearMesh<2>> generate<2>(const BoxOptions<2>&, const Execution&);
template Outcome<LinearMesh<3>> generate<3>(const BoxOptions<3>&, const Execution&);

}  // namespace camber
