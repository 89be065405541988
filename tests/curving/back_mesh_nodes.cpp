// Curving in a field that goes along with its walls, on blocks whose walls sag by more than their first layers are
// high.
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

/// The nodes of a block with all edges of its boundary on spheres, those of its sides included.
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

/// The block with a field on its curved elements.
template <int D>
struct OnCurvedBack {
    Block<D> block;
    Column<LagrangeNode<D>> extended, base;
    BackMesh<D> back;

    explicit OnCurvedBack(std::uint64_t seed) : block(shell_block<D>(thin_layers<D>(), seed)) {
        const QuadraticMesh<D>& mesh = block.mesh;
        block.boundary_nodes = on_spheres(block);
        extended = must(extend_boundary(mesh, block.kinds, block.boundary_nodes, block.shells, {}, alone)).nodes;
        QuadraticMesh<D> bent = mesh;
        bent.mid_nodes = extended;
        const auto around = must(balls(mesh.linear, alone));
        const Column<LogMetric<D>> logs(must(curved_natural_log_metrics(bent, around, alone)).curved);
        const Column<LagrangeNode<D>> nodes(must(noticeable_nodes(mesh, extended.view(), logs, alone)));
        bent.mid_nodes = must(back_mesh_nodes(mesh, nodes.view(), block.shells, alone));
        Buffer<LagrangeNode<D>> starts(block.boundary_nodes.begin(), block.boundary_nodes.end());
        for (std::size_t e = 0; e < starts.size(); ++e)
            if (block.kinds[e] == EdgeKind::volume) starts[e] = nodes[e];
        base = std::move(starts);
        back = must(make_curved_back_mesh(bent, around, logs, alone));
    }
    [[nodiscard]] Curved<D> curved(CurvingAim aim, const Execution& execution = alone) const {
        CurveOptions options;
        options.aim = aim;
        return must(curve({block.mesh, block.kinds, block.shells}, base, back, options, execution));
    }
};

template <int D>
double smallest(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal) {
    return must(validate(mesh, proposal, min_bound, alone)).validation().smallest;
}

template <int D>
void laws() {
    property("nothing breaks where the wall sags by more than a layer, and boundary nodes stay",
             [](std::uint64_t seed) {
                 const OnCurvedBack<D> c(seed);
                 const auto curved = c.curved(CurvingAim::accuracy);
                 RC_ASSERT(smallest(c.block.mesh, curved.proposal) > 0.09);
                 for (std::size_t e = 0; e < c.base.size(); ++e)
                     if (c.block.kinds[e] != EdgeKind::volume)
                         RC_ASSERT(curved.proposal.mid_nodes[e] == c.block.boundary_nodes[e]);
             },
             {3});
    property("of least energy: no edge is longer than its chord, nor than where it began",
             [](std::uint64_t seed) {
                 const OnCurvedBack<D> c(seed);
                 const auto curved = c.curved(CurvingAim::energy);
                 const Quadrature rule = gauss_legendre(report_points);
                 for (std::size_t e = 0; e < c.base.size(); ++e) {
                     if (c.block.kinds[e] != EdgeKind::volume) continue;
                     const auto& [a, b] = c.block.mesh.edges.vertices[e];
                     const QuadraticEdge<D> began{c.block.mesh.linear.points[a], c.base[e],
                                                  c.block.mesh.linear.points[b]};
                     const double length = riemannian_length(c.back, began, rule, c.block.shells[e].front()).length;
                     RC_ASSERT(curved.lengths[e] <= curved.straight_lengths[e]);
                     RC_ASSERT(curved.lengths[e] <= length * (1 + 1e-6));
                 }
             },
             {2});
}

}  // namespace

TEST_CASE("2D: curving on a curved back mesh") { laws<2>(); }
TEST_CASE("3D: curving on a curved back mesh") { laws<3>(); }

TEST_CASE("the same bytes for any number of threads on a curved back mesh") {
    const OnCurvedBack<3> c(1);
    CHECK(c.curved(CurvingAim::accuracy).proposal.mid_nodes ==
          c.curved(CurvingAim::accuracy, Execution{.threads = 3}).proposal.mid_nodes);
}

TEST_CASE("a straight back mesh breaks what the curved one does not") {
    const OnCurvedBack<2> c(1);
    const auto straight = must(curve({c.block.mesh, c.block.kinds, c.block.shells}, c.block.boundary_nodes,
                                     c.block.back, CurveOptions{}, alone));
    CHECK(smallest(c.block.mesh, straight.proposal) < smallest(c.block.mesh, c.curved(CurvingAim::accuracy).proposal));
}
