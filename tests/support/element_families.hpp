// Families of elements that are hard to certify, in doubles and on integer lattices. The includer imports camber.core,
// camber.bezier and camber.validity first.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>

namespace families {

using namespace camber;
using Random = std::mt19937_64;

inline double uniform(Random& random, double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}

enum class Family { plain, needle, sliver, anisotropic, far, tuned };
inline constexpr int count = 6;
inline constexpr std::array<const char*, count> names{"plain",       "needle", "sliver",
                                                      "anisotropic", "far",    "tuned to 1 ulp"};

/// A random simplex around the unit simplex; edge nodes are up to `amplitude` off the middles per coordinate.
template <int D>
NodalSimplex<D> plain(Random& random, double amplitude) {
    NodalSimplex<D> s;
    for (int i = 0; i <= D; ++i)
        for (int c = 0; c < D; ++c) s.nodes[i][c] = (i == c + 1) + uniform(random, -0.2, 0.2);
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        s.nodes[D + 1 + e] = midpoint(s.nodes[local_edges<D>[e][0]], s.nodes[local_edges<D>[e][1]]);
        for (int c = 0; c < D; ++c) s.nodes[D + 1 + e][c] += uniform(random, -amplitude, amplitude);
    }
    return s;
}

/// Rotates by random angles in all coordinate planes.
template <int D>
void rotate(Random& random, NodalSimplex<D>& s) {
    for (int a = 0; a < D; ++a)
        for (int b = 0; b < a; ++b) {
            const double angle = uniform(random, -3.2, 3.2);
            const double c = std::cos(angle), d = std::sin(angle);
            for (auto& p : s.nodes) {
                const double x = p[a], y = p[b];
                p[a] = c * x - d * y;
                p[b] = d * x + c * y;
            }
        }
}

/// Multiplies the coordinates c ≥ first by `factor`.
template <int D>
void squeeze(NodalSimplex<D>& s, int first, double factor) {
    for (auto& p : s.nodes)
        for (int c = first; c < D; ++c) p[c] *= factor;
}

/// Returns a random element of a family. `tuned` needs the function below and gives a plain one here.
template <int D>
NodalSimplex<D> element(Random& random, Family family) {
    NodalSimplex<D> s = plain<D>(random, uniform(random, 0, D == 2 ? 0.3 : 0.2));
    switch (family) {
        case Family::plain:
        case Family::tuned: break;
        case Family::needle:
            squeeze(s, 1, std::pow(10, uniform(random, -6, 0)));
            rotate(random, s);
            break;
        case Family::sliver: {
            // Two opposite edges cross in one plane at a small distance (2D: a vertex close above the middle of an
            // edge).
            const double apart = std::pow(10, uniform(random, -8, 0));
            for (auto& p : s.nodes) {
                // Maps the vertices 0, x and y, z of the unit simplex to (−1, 0), (1, 0) and (0, 1), (0, −1), and lifts
                // the latter two.
                if constexpr (D == 3)
                    p = {{2 * p[0] + p[1] + p[2] - 1, p[1] - p[2], apart * (p[1] + p[2])}};
                else
                    p = {{p[0] + 0.5 * p[1], apart * p[1]}};
            }
            rotate(random, s);
            break;
        }
        case Family::anisotropic:
            for (int c = 1; c < D; ++c) squeeze(s, c, std::pow(10, uniform(random, -8, 0) / (D - 1)));
            rotate(random, s);
            break;
        case Family::far: {
            squeeze(s, 0, std::pow(10, uniform(random, -3, 1)));
            Vec<D> shift;
            for (int c = 0; c < D; ++c) shift[c] = uniform(random, -1e6, 1e6);
            for (auto& p : s.nodes) p += shift;
            break;
        }
    }
    return s;
}

/// Moves one coordinate of one node to the limit of validity by bisection down to adjacent doubles: the last valid
/// value, the first invalid one, or the next double on either side. Returns s unchanged if no limit is found.
template <int D, class IsValid>
NodalSimplex<D> tuned(Random& random, NodalSimplex<D> s, IsValid&& is_valid) {
    const auto i = static_cast<std::size_t>(random() % quadratic_nodes<D>);
    const auto c = static_cast<std::size_t>(random() % D);
    double size = 0;
    for (const auto& p : s.nodes) size = std::max(size, distance(p, s.nodes[0]));
    double inside = s.nodes[i][c];
    double outside = inside + (random() % 2 == 0 ? -4 : 4) * size;
    const auto valid_with = [&](double x) {
        s.nodes[i][c] = x;
        return is_valid(s);
    };
    if (!valid_with(inside) || valid_with(outside)) {
        s.nodes[i][c] = inside;
        return s;
    }
    for (;;) {
        const double middle = inside + 0.5 * (outside - inside);
        if (middle == inside || middle == outside) break;
        (valid_with(middle) ? inside : outside) = middle;
    }
    const double infinity = std::numeric_limits<double>::infinity();
    const double direction = outside > inside ? infinity : -infinity;
    const std::array<double, 4> places{std::nextafter(inside, -direction), inside, outside,
                                       std::nextafter(outside, direction)};
    s.nodes[i][c] = places[random() % 4];
    return s;
}

/// Integer coordinates from 0 to 8: the simplex of size 4 at (2, …, 2), with one in `sparsity` of all coordinates
/// shifted by up to `most`, which is at most 2.
template <int D>
std::array<std::array<std::int64_t, D>, quadratic_nodes<D>> lattice_element(Random& random, int most,
                                                                            std::uint64_t sparsity) {
    std::array<std::array<std::int64_t, D>, quadratic_nodes<D>> n{};
    for (auto& p : n) p.fill(2);
    for (int a = 1; a <= D; ++a) n[a][a - 1] += 4;
    for (int e = 0; e < edges_per_simplex<D>; ++e)
        for (int c = 0; c < D; ++c) n[D + 1 + e][c] = (n[local_edges<D>[e][0]][c] + n[local_edges<D>[e][1]][c]) / 2;
    const std::uint64_t span = 2 * static_cast<std::uint64_t>(most) + 1;
    for (auto& p : n)
        for (auto& x : p)
            if (random() % sparsity == 0) x += static_cast<std::int64_t>(random() % span) - most;
    return n;
}

template <int D>
NodalSimplex<D> in_doubles(const std::array<std::array<std::int64_t, D>, quadratic_nodes<D>>& n) {
    NodalSimplex<D> s;
    for (std::size_t i = 0; i < n.size(); ++i)
        for (int c = 0; c < D; ++c) s.nodes[i][c] = static_cast<double>(n[i][c]);
    return s;
}

}  // namespace families
