module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
module camber.shapes;
import camber.core;

namespace camber {

namespace {

/// Points that cover the sphere of this radius with triangles of this edge length (the circle with edges).
template <int D>
double cover(double radius, double size) {
    return D == 2 ? 2 * std::numbers::pi * radius / size
                  : 8 * std::numbers::pi * radius * radius / (std::numbers::sqrt3 * size * size);
}

/// Facets of a sphere (edges of a circle) with so many points.
template <int D>
double facets_of(double points) {
    return D == 2 ? points : 2 * points - 4;
}

template <int D>
double prisms(const ShellOptions<D>& o) {
    const PrismCounts counts = prism_counts<D>(core_sizes(o));
    const double facets = D == 2 ? 5 * counts.cuts : 20 * counts.cuts * counts.cuts;
    return D * facets * (counts.rows + o.inner_layer.count + o.outer_layer.count);
}

/// By spheres of points a simplex's height apart. By Euler there are two triangles an inner point and one a point of
/// the boundary in 2D; the tetrahedra of each were counted on shells of 10^3 to 1.5·10^5.
template <int D>
double unstructured(const ShellOptions<D>& o) {
    constexpr double an_inner_point = D == 2 ? 2 : 6.2, a_wall_point = D == 2 ? 1 : 3.1;
    constexpr int samples = 1024;
    const double height = D == 2 ? std::numbers::sqrt3 / 2 : std::numbers::sqrt2 / std::numbers::sqrt3;
    const ShellSizes sizes = core_sizes(o);
    const double inner = cover<D>(sizes.inner_radius, sizes.inner_size);
    const double outer = cover<D>(sizes.outer_radius, sizes.outer_size);
    const double step = (sizes.outer_radius - sizes.inner_radius) / samples;
    double points = (inner + outer) / 2;
    for (int k = 0; k < samples; ++k) {
        const double radius = sizes.inner_radius + (k + 0.5) * step;
        points += cover<D>(radius, sizes.at(radius)) * step / (height * sizes.at(radius));
    }
    const double layers = o.inner_layer.count * facets_of<D>(inner) + o.outer_layer.count * facets_of<D>(outer);
    return an_inner_point * std::max(0.0, points - inner - outer) + a_wall_point * (inner + outer) + D * layers;
}

/// How far a number of elements is from the one that is wanted, as a factor.
double off(double elements, double wanted) { return std::abs(log(elements / wanted)); }

/// Cells along each axis about `ideal`, rounded up or down so that elements({cells}) is next to `wanted`.
template <std::size_t N, class Elements>
std::array<int, N> rounded(const std::array<double, N>& ideal, const std::array<int, N>& least, double wanted,
                           Elements&& elements) {
    constexpr double most = 1e9;
    std::array<int, N> best{};
    double best_off = std::numeric_limits<double>::infinity();
    for (unsigned up = 0; up < 1U << N; ++up) {
        std::array<int, N> cells{};
        for (std::size_t i = 0; i < N; ++i)
            cells[i] = std::max(least[i], static_cast<int>(std::min(ideal[i], most)) + static_cast<int>(up >> i & 1U));
        if (const double o = off(elements(cells), wanted); o < best_off) {
            best = cells;
            best_off = o;
        }
    }
    return best;
}

template <int D>
double of_lattice(const std::array<int, D>& cells) {
    double elements = D == 2 ? 2 : 6;
    for (const int n : cells) elements *= n;
    return elements;
}

double of_channel(const std::array<int, 2>& cells, int layers) {
    return 2.0 * cells[0] * (static_cast<double>(cells[1]) + layers);
}

}  // namespace

template <int D>
double expected_elements(const ShellOptions<D>& options) {
    return options.structure == ShellStructure::prisms ? prisms(options) : unstructured(options);
}

template <int D>
double expected_elements(const BoxOptions<D>& options) {
    return of_lattice<D>(options.cells);
}

double expected_elements(const BumpOptions& options) { return of_channel(options.cells, options.floor_layer.count); }

template <int D>
ShellOptions<D> with_elements(ShellOptions<D> options, double count) {
    const auto scaled = [&](double log_factor) {
        ShellOptions<D> o = options;
        o.inner_size *= exp(log_factor);
        o.outer_size *= exp(log_factor);
        return o;
    };
    double fine = -40, coarse = 40;  // the logarithms of factors
    for (int step = 0; step < 60; ++step) {
        const double middle = (fine + coarse) / 2;
        (expected_elements(scaled(middle)) > count ? fine : coarse) = middle;
    }
    const ShellOptions<D> finer = scaled(fine), coarser = scaled(coarse);
    return off(expected_elements(finer), count) < off(expected_elements(coarser), count) ? finer : coarser;
}

template <int D>
BoxOptions<D> with_elements(BoxOptions<D> options, double count) {
    const double factor = pow(count / expected_elements(options), 1.0 / D);
    std::array<double, D> ideal{};
    std::array<int, D> least{};
    for (int i = 0; i < D; ++i) {
        ideal[i] = factor * options.cells[i];
        least[i] = 1;
    }
    options.cells = rounded(ideal, least, count, of_lattice<D>);
    return options;
}

BumpOptions with_elements(BumpOptions options, double count) {
    // 2 a f (b f + layers) = count for the factor f of a × b cells.
    const double a = options.cells[0], b = options.cells[1], layers = options.floor_layer.count;
    const double factor = (std::sqrt(a * a * layers * layers + 2 * a * b * count) - a * layers) / (2 * a * b);
    options.cells = rounded(std::array{factor * a, factor * b}, {2, 1}, count, [&](const std::array<int, 2>& cells) {
        return of_channel(cells, options.floor_layer.count);
    });
    return options;
}

#define CAMBER_INSTANTIATE(D)                                           \
    template double expected_elements<D>(const ShellOptions<D>&);       \
    template double expected_elements<D>(const BoxOptions<D>&);         \
    template ShellOptions<D> with_elements<D>(ShellOptions<D>, double); \
    template BoxOptions<D> with_elements<D>(BoxOptions<D>, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
