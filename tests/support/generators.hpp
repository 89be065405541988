// Random elements and meshes for the properties. The includer imports camber.core, camber.bezier and camber.validity
// first.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "elements.hpp"
#include "property.hpp"

namespace generators {

using namespace camber;

/// RapidCheck draws the seed; the values come from it, so that sizes do not depend on RapidCheck's growing size.
inline std::mt19937_64 random_source() {
    return std::mt19937_64(*rc::gen::noShrink(rc::gen::arbitrary<std::uint64_t>()));
}
inline double uniform(std::mt19937_64& random, double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
}
inline std::int64_t integer(std::mt19937_64& random, std::int64_t most) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(2 * most + 1)) - most;
}

/// The unit simplex times 2 `size` with edge nodes at the middles; then every node is shifted by up to `most`.
template <int D>
elements::IntegerNodes<D> integer_element(std::mt19937_64& random, std::int64_t size, std::int64_t most) {
    elements::IntegerNodes<D> n{};
    for (int a = 1; a <= D; ++a) n[a][a - 1] = 2 * size;
    for (int e = 0; e < edges_per_simplex<D>; ++e)
        for (int c = 0; c < D; ++c) n[D + 1 + e][c] = (n[local_edges<D>[e][0]][c] + n[local_edges<D>[e][1]][c]) / 2;
    for (auto& node : n)
        for (auto& x : node) x += integer(random, most);
    return n;
}

/// A random element around the unit simplex; `amplitude` bounds the offsets of edge nodes.
template <int D>
QuadraticSimplex<D, D> element(std::mt19937_64& random, double amplitude) {
    NodalSimplex<D> s;
    for (int i = 0; i <= D; ++i)
        for (int c = 0; c < D; ++c) s.nodes[i][c] = (i == c + 1) + uniform(random, -0.2, 0.2);
    for (int e = 0; e < edges_per_simplex<D>; ++e) {
        const auto [i, j] = local_edges<D>[e];
        s.nodes[D + 1 + e] = midpoint(s.nodes[i], s.nodes[j]);
        for (int c = 0; c < D; ++c) s.nodes[D + 1 + e][c] += uniform(random, -amplitude, amplitude);
    }
    return bezier_form(s);
}

template <int D>
Barycentric<D> point_inside(std::mt19937_64& random) {
    Barycentric<D> xi{};
    double sum = 0;
    for (double& x : xi) sum += x = uniform(random, 1e-3, 1);
    for (double& x : xi) x /= sum;
    return xi;
}

/// [0, n]^D cut into simplices (Kuhn: one for each order of the axes), with the boundary's facets.
template <int D>
LinearMesh<D> lattice_mesh(int n) {
    const auto vertex = [&](std::array<int, D> at) {
        std::size_t v = 0;
        for (int c = 0; c < D; ++c) v = v * static_cast<std::size_t>(n + 1) + static_cast<std::size_t>(at[c]);
        return VertexId(v);
    };
    const auto cells = [&](int count, auto&& visit) {
        std::array<int, D> at{};
        for (;;) {
            visit(at);
            int c = D - 1;
            while (c >= 0 && ++at[c] == count) at[c--] = 0;
            if (c < 0) return;
        }
    };
    Buffer<Vec<D>> points;
    cells(n + 1, [&](const std::array<int, D>& at) {
        Vec<D> p;
        for (int c = 0; c < D; ++c) p[c] = at[c];
        points.push_back(p);
    });
    Buffer<SimplexVertices<D>> simplices;
    cells(n, [&](const std::array<int, D>& at) {
        std::array<int, D> order{};
        for (int c = 0; c < D; ++c) order[c] = c;
        bool even = true;
        const auto add = [&] {
            SimplexVertices<D> s;
            auto corner = at;
            s[0] = vertex(corner);
            for (int i = 0; i < D; ++i) {
                ++corner[order[i]];
                s[i + 1] = vertex(corner);
            }
            if (!even) std::swap(s[0], s[1]);
            simplices.push_back(s);
        };
        if constexpr (D == 2) {
            add();
            std::swap(order[0], order[1]), even = false;
            add();
        } else {
            for (int first = 0; first < 3; ++first)
                for (int swap = 0; swap < 2; ++swap) {
                    order = {first, (first + 1 + swap) % 3, (first + 2 - swap) % 3};
                    even = swap == 0;
                    add();
                }
        }
    });
    LinearMesh<D> mesh;
    mesh.points = points;
    mesh.elements.vertices = std::move(simplices);
    const Execution execution{1};
    const auto around = balls(mesh, execution).value();
    const auto next = neighbours(mesh, around, execution).value();
    Buffer<SimplexVertices<D - 1>> facets;
    for (const ElementFace face : boundary_faces<D>(next)) {
        SimplexVertices<D - 1> f;
        for (int i = 0; i < D; ++i)
            f[i] = mesh.elements.vertices[face.element][face_opposite<D>(static_cast<int>(face.opposite))[i]];
        facets.push_back(f);
    }
    mesh.facets.references = Buffer<Reference>(facets.size(), 1);
    mesh.facets.vertices = std::move(facets);
    mesh.elements.references = Buffer<Reference>(mesh.elements.size(), 1);
    mesh.point_references = Buffer<Reference>(mesh.points.size(), 0);
    return mesh;
}

template <int D>
struct Planned {
    QuadraticMesh<D> mesh;
    Proposal<D> proposal;
};

/// Moves nodes off the middles by up to `volume`, or `surface` for boundary edges, times the edge length.
template <int D>
Planned<D> planned(std::mt19937_64& random, int n, double volume, double surface) {
    Planned<D> p;
    p.mesh = elevate(lattice_mesh<D>(n), Execution{1}).value();
    const std::size_t edges = p.mesh.edges.size();
    Buffer<LagrangeNode<D>> nodes(p.mesh.mid_nodes.begin(), p.mesh.mid_nodes.end());
    Buffer<EdgeKind> kinds(edges, EdgeKind::volume);
    for (std::size_t f = 0; f < p.mesh.linear.facets.size(); ++f)
        for (const EdgeId e : p.mesh.edges.of_facets[f]) kinds[e.index()] = EdgeKind::surface;
    Buffer<EdgeChange> changes(edges, EdgeChange::straight);
    for (std::size_t e = 0; e < edges; ++e) {
        const bool inner = kinds[e] == EdgeKind::volume;
        const double most = (inner ? volume : surface) * norm(edge_of(p.mesh, EdgeId(e)).chord());
        if (most == 0) continue;
        for (int c = 0; c < D; ++c) nodes[e].point[c] += uniform(random, -most, most);
        changes[e] = inner ? EdgeChange::optimised : EdgeChange::projected;
    }
    p.proposal = {p.mesh.linear.points, std::move(nodes), std::move(kinds), std::move(changes)};
    return p;
}

}  // namespace generators
