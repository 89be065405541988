// Facets for tests: drawn at random, and moved as a whole.
#pragma once

#include <array>
#include <cmath>
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

/// A facet of vertices within the cube of ±1, its nodes off the chords' middles by up to `bow` in each coordinate.
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

/// Its vertices and nodes in another order: (0 1 2) to (1 2 0), or mirrored.
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

/// A place on the facet, anywhere.
template <int D>
Barycentric<D - 1> random_place(Engine& engine) {
    Barycentric<D - 1> xi{};
    double sum = 0;
    for (double& x : xi) sum += x = -std::log(uniform(engine, 1e-12, 1));
    for (double& x : xi) x /= sum;
    return xi;
}

}  // namespace camber::testing
