// Random facets and their transformations for the tests.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <utility>

import camber.core;
import camber.bezier;
import camber.crossing;

namespace camber::testing {

using Engine = std::mt19937_64;

inline double uniform(Engine& engine, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
}

template <int D>
Vec<D> random_vector(Engine& engine, double size = 1) {
    Vec<D> v;
    for (double& x : v.c) x = uniform(engine, -size, size);
    return v;
}

/// A facet with vertices in the cube of ±1 and nodes displaced from the middles of the chords by up to `bow` in each
/// coordinate.
template <int D>
NodalFacet<D> random_facet(Engine& engine, double bow) {
    std::array<Vec<D>, D> vertices;
    for (Vec<D>& v : vertices) v = random_vector<D>(engine);
    NodalFacet<D> facet = straight_facet<D>(vertices);
    for (std::size_t i = D; i < facet.nodes.size(); ++i) facet.nodes[i] += random_vector<D>(engine, bow);
    return facet;
}

template <int D, class Map>
NodalFacet<D> mapped(NodalFacet<D> facet, Map&& map) {
    for (Vec<D>& node : facet.nodes) node = map(node);
    return facet;
}

template <int D>
QuadraticSimplex<D - 1, D> bezier_of(const NodalFacet<D>& facet) {
    QuadraticSimplex<D - 1, D> s;
    for (int i = 0; i < D; ++i) s.control[i] = facet.nodes[i];
    for (int e = 0; e < edges_per_simplex<D - 1>; ++e) {
        const auto [i, j] = local_edges<D - 1>[e];
        s.control[D + e] = control_point(facet.nodes[i], {facet.nodes[D + e]}, facet.nodes[j]).point;
    }
    return s;
}

/// Vertices and nodes in another order: (0 1 2) to (1 2 0), or mirrored.
inline NodalFacet<3> renumbered(const NodalFacet<3>& f, int turn, bool mirrored) {
    NodalFacet<3> out;
    std::array<int, 3> p{turn % 3, (turn + 1) % 3, (turn + 2) % 3};
    if (mirrored) std::swap(p[0], p[1]);
    const auto node = [&](int i, int j) { return f.nodes[i + j == 1 ? 3 : i + j == 3 ? 4 : 5]; };
    for (int i = 0; i < 3; ++i) {
        out.nodes[i] = f.nodes[p[i]];
        out.nodes[3 + i] = node(p[i], p[(i + 1) % 3]);
    }
    return out;
}
inline NodalFacet<2> renumbered(const NodalFacet<2>& f, int turn, bool mirrored) {
    return (turn % 2 == 1) != mirrored ? NodalFacet<2>{{f.nodes[1], f.nodes[0], f.nodes[2]}} : f;
}

/// A random position on the facet.
template <int D>
Barycentric<D - 1> random_place(Engine& engine) {
    Barycentric<D - 1> xi{};
    double sum = 0;
    for (double& x : xi) sum += x = -std::log(uniform(engine, 1e-12, 1));
    for (double& x : xi) x /= sum;
    return xi;
}

/// Searches a common point of two facets by Newton's method from random starts: the minimum-norm step solves F(ξ) −
/// G(η) = 0 to first order. Independent of the subdivision search. The point must be inside both by more than `inset`,
/// in barycentric coordinates.
template <int D>
bool newton_meets(const NodalFacet<D>& first, const NodalFacet<D>& second, double inset, Engine& engine,
                  int starts = 60) {
    constexpr int K = D - 1;
    const auto f = bezier_of(first), g = bezier_of(second);
    for (int start = 0; start < starts; ++start) {
        auto xi = random_place<D>(engine), eta = random_place<D>(engine);
        for (int i = 0; i < 30; ++i) {
            const Vec<D> gap = f.point(xi) - g.point(eta);
            if (norm(gap) < 1e-12) {
                bool inside = true;
                for (int k = 0; k <= K; ++k) inside = inside && xi[k] > inset && eta[k] > inset;
                if (inside) return true;
                break;
            }
            const auto a = f.derivatives(xi), b = g.derivatives(eta);
            std::array<Vec<D>, D> normal{};  // J Jᵀ, by columns
            for (int c = 0; c < D; ++c)
                for (int k = 0; k < K; ++k) normal[c] += a[k] * a[k][c] + b[k] * b[k][c];
            Vec<D> y;
            const auto with = [&](int c) {
                auto n = normal;
                n[c] = gap;
                return n;
            };
            for (int c = 0; c < D; ++c) {
                const auto n = with(c);
                if constexpr (D == 2)
                    y[c] = det(n[0], n[1]) / det(normal[0], normal[1]);
                else
                    y[c] = det(n[0], n[1], n[2]) / det(normal[0], normal[1], normal[2]);
            }
            for (int k = 0; k < K; ++k) {
                const double move_xi = dot(a[k], y), move_eta = dot(b[k], y);
                xi[k + 1] -= move_xi;
                xi[0] += move_xi;
                eta[k + 1] += move_eta;
                eta[0] -= move_eta;
            }
        }
    }
    return false;
}

}  // namespace camber::testing
