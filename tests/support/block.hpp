// A block of a shell with all inputs of curving. Its geometry: spheres (circles in 2D) on the inner and outer side.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "meshes.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.curving;

namespace camber::testing {

template <int D>
struct Block {
    QuadraticMesh<D> mesh;
    Column<EdgeKind> kinds;
    Column<LagrangeNode<D>> boundary_nodes;  ///< on the sphere if both ends are on it
    Incidence<ElementId> shells;
    BackMesh<D> back;
};

/// Maps the share 0 to 1 of the cells to radii from 1 to 2, with thinner layers inside.
inline double mildly_thinner(double s) { return 1 + 0.3 * s + 0.7 * s * s; }

/// Returns `surface` for edges of the boundary and `volume` for others.
template <int D>
Column<EdgeKind> boundary_kinds(const LinearMesh<D>& mesh, const EdgeSet<D>& edges) {
    Buffer<EdgeKind> kinds(edges.size(), EdgeKind::volume);
    for (const ElementFace& face :
         boundary_faces<D>(must(neighbours(mesh, must(balls(mesh, one_thread)), one_thread)))) {
        const auto v = face_of(mesh, face);
        for (int i = 0; i < D; ++i)
            for (int j = 0; j < i; ++j) kinds[find_edge(edges, v[i], v[j]).index()] = EdgeKind::surface;
    }
    return kinds;
}

/// Shell block with cells along latitude, longitude (3D) and radius; the metric is the natural one of the mesh.
template <int D>
Block<D> shell_block(const std::array<int, D>& cells, std::uint64_t seed,
                     const std::function<double(double)>& radius = mildly_thinner) {
    LatticeOptions<D> options;
    options.cells = cells;
    options.seed = seed;
    options.place = [cells, radius](const Vec<D>& p) {
        const double r = radius(p[D - 1] / cells[D - 1]);
        const double a = 1.2 * (p[0] / cells[0] - 0.5);
        if constexpr (D == 2)
            return Vec<2>{{r * std::sin(a), r * std::cos(a)}};
        else
            return r * normalised(Vec<3>{{std::tan(a), std::tan(1.2 * (p[1] / cells[1] - 0.5)), 1}});
    };
    auto linear = lattice_mesh(options);
    const auto around = must(balls(linear, one_thread));
    Block<D> block;
    block.back = must(make_back_mesh(
        linear, around, Column<LogMetric<D>>(must(natural_log_metrics(linear, around, one_thread))), one_thread));
    block.mesh = must(elevate(std::move(linear), one_thread));
    const auto& edges = block.mesh.edges;
    block.shells = must(shells(edges, one_thread));

    Column<EdgeKind> kinds = boundary_kinds(block.mesh.linear, edges);
    Buffer<LagrangeNode<D>> nodes(edges.size());
    for (std::size_t e = 0; e < edges.size(); ++e) {
        const auto [a, b] = edges.vertices[e];
        const double ra = norm(block.mesh.linear.points[a]), rb = norm(block.mesh.linear.points[b]);
        nodes[e] = block.mesh.mid_nodes[e];
        const bool on_sphere = std::abs(ra - rb) < 1e-12 && (std::abs(ra - 1) < 1e-12 || std::abs(ra - 2) < 1e-12);
        if (on_sphere && kinds[e] == EdgeKind::surface) nodes[e].point = ra * normalised(nodes[e].point);
    }
    block.kinds = std::move(kinds);
    block.boundary_nodes = std::move(nodes);
    return block;
}

/// Returns 1 for vertices on the boundary and 0 for others.
template <int D>
std::vector<int> boundary_marks(const Block<D>& b) {
    std::vector<int> marks(b.mesh.linear.points.size(), 0);
    for (std::size_t e = 0; e < b.kinds.size(); ++e)
        if (b.kinds[e] != EdgeKind::volume)
            for (const VertexId v : b.mesh.edges.vertices[e]) marks[v.index()] = 1;
    return marks;
}

}  // namespace camber::testing
