// Curving in a field that follows curved walls, on blocks whose walls have a sagitta above the height of the first
// layer.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <rapidcheck.h>

#include "block.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.extension;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.curving;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
std::array<int, D> thin_layers() {
    if constexpr (D == 2)
        return {3, 24};
    else
        return {3, 3, 24};
}

/// The nodes of a block with all boundary edges on spheres, including those of its sides.
template <int D>
Column<LagrangeNode<D>> on_spheres(const Block<D>& b) {
    Buffer<LagrangeNode<D>> nodes(b.boundary_nodes.begin(), b.boundary_nodes.end());
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        if (b.kinds[e] == EdgeKind::volume) continue;
        const auto& [i, j] = b.mesh.edges.vertices[e];
        const Vec<D>& p = b.mesh.linear.points[i];
        const Vec<D>& q = b.mesh.linear.points[j];
        nodes[e].point = 0.5 * (norm(p) + norm(q)) * normalised(normalised(p) + normalised(q));
    }
    return nodes;
}

/// A block with a field on its curved elements.
template <int D>
struct OnCurvedBack {
    Block<D> block;
    Column<LagrangeNode<D>> extended, base;
    BackMesh<D> back;

    explicit OnCurvedBack(std::uint64_t seed) : block(shell_block<D>(thin_layers<D>(), seed)) {
        const QuadraticMesh<D>& mesh = block.mesh;
        block.boundary_nodes = on_spheres(block);
        extended = must(extend_boundary(mesh, block.kinds, block.boundary_nodes, block.shells, {}, one_thread)).nodes;
        QuadraticMesh<D> bent = mesh;
        bent.mid_nodes = extended;
        const auto around = must(balls(mesh.linear, one_thread));
        const Column<LogMetric<D>> logs(must(curved_natural_log_metrics(bent, around, one_thread)).curved);
        const Column<LagrangeNode<D>> nodes(must(noticeable_nodes(mesh, extended.view(), logs, one_thread)));
        bent.mid_nodes = must(back_mesh_nodes(mesh, nodes.view(), block.shells, one_thread));
        Buffer<LagrangeNode<D>> starts(block.boundary_nodes.begin(), block.boundary_nodes.end());
        for (std::size_t e = 0; e < starts.size(); ++e)
            if (block.kinds[e] == EdgeKind::volume) starts[e] = nodes[e];
        base = std::move(starts);
        back = must(make_curved_back_mesh(bent, around, logs, one_thread));
    }
    [[nodiscard]] Curved<D> curved(CurvingAim aim, const Execution& execution = one_thread) const {
        CurveOptions options;
        options.aim = aim;
        return must(curve({block.mesh, block.kinds, block.shells}, base, back, options, execution));
    }
};

template <int D>
double smallest(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal) {
    return must(validate(mesh, proposal, min_bound, one_thread)).validation().smallest;
}

template <int D>
void check_curving() {
    property("curving keeps elements valid at a sagging wall and keeps boundary nodes",
             [](std::uint64_t seed) {
                 const OnCurvedBack<D> c(seed);
                 const auto curved = c.curved(CurvingAim::accuracy);
                 RC_ASSERT(smallest(c.block.mesh, curved.proposal) > 0.09);
                 for (std::size_t e = 0; e < c.base.size(); ++e)
                     if (c.block.kinds[e] != EdgeKind::volume)
                         RC_ASSERT(curved.proposal.mid_nodes[e] == c.block.boundary_nodes[e]);
             },
             {3});
    property("curving by energy makes no edge longer than its chord or its start",
             [](std::uint64_t seed) {
                 const OnCurvedBack<D> c(seed);
                 const auto curved = c.curved(CurvingAim::energy);
                 const Quadrature rule = gauss_legendre(report_points);
                 for (std::size_t e = 0; e < c.base.size(); ++e) {
                     if (c.block.kinds[e] != EdgeKind::volume) continue;
                     const auto& [a, b] = c.block.mesh.edges.vertices[e];
                     const QuadraticEdge<D> start{c.block.mesh.linear.points[a], c.base[e],
                                                  c.block.mesh.linear.points[b]};
                     const double length = riemannian_length(c.back, start, rule, c.block.shells[e].front()).length;
                     RC_ASSERT(curved.lengths[e] <= curved.straight_lengths[e]);
                     RC_ASSERT(curved.lengths[e] <= length * (1 + 1e-6));
                 }
             },
             {2});
}

}  // namespace

TEST_CASE("curving on a curved back mesh keeps elements valid and edges no longer than chords, 2D") {
    check_curving<2>();
}
TEST_CASE("curving on a curved back mesh keeps elements valid and edges no longer than chords, 3D") {
    check_curving<3>();
}

TEST_CASE("curving on a curved back mesh does not depend on the number of threads") {
    const OnCurvedBack<3> c(1);
    CHECK(c.curved(CurvingAim::accuracy).proposal.mid_nodes ==
          c.curved(CurvingAim::accuracy, Execution{.threads = 3}).proposal.mid_nodes);
}

TEST_CASE("a curved back mesh gives a larger minimum Jacobian than a straight one") {
    const OnCurvedBack<2> c(1);
    const auto straight = must(curve({c.block.mesh, c.block.kinds, c.block.shells}, c.block.boundary_nodes,
                                     c.block.back, CurveOptions{}, one_thread));
    CHECK(smallest(c.block.mesh, straight.proposal) < smallest(c.block.mesh, c.curved(CurvingAim::accuracy).proposal));
}
