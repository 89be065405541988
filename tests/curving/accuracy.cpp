// Curving with the objective accuracy: boundary nodes are copied, and the Jacobian bound limits volume nodes.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "block.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.optimisation;
import camber.curving;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
Outcome<Curved<D>> curved(const Block<D>& b, double min_jacobian, const Execution& execution) {
    CurveOptions options;
    options.min_jacobian = min_jacobian;
    return curve({b.mesh, b.kinds, b.shells}, b.boundary_nodes, b.back, options, execution);
}

/// The smallest coefficient of det J of each element, relative to the straight element.
template <int D>
std::vector<double> jacobians(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> nodes) {
    std::vector<double> all(mesh.linear.elements.size());
    for (std::size_t e = 0; e < all.size(); ++e) {
        const auto j = bounded_jacobian(
            nodal_form<D>(mesh.linear.points, nodes, mesh.linear.elements.vertices[e], mesh.edges.of_elements[e]));
        all[e] = *std::min_element(j.coefficients.begin(), j.coefficients.end()) / j.straight;
    }
    return all;
}

/// A metric field whose sizes and axes change much faster than the mesh: its nodes make elements invalid.
template <int D>
Block<D> with_rough_field(Block<D> b, std::uint64_t seed) {
    Dice dice(seed);
    const std::size_t n = b.mesh.linear.points.size();
    Buffer<LogMetric<D>> logs(n);
    for (std::size_t v = 0; v < n; ++v) logs[v] = {b.back->vertex(VertexId(v)).log_metric.l + dice.symmetric<D>(2)};
    const auto around = must(balls(b.mesh.linear, one_thread));
    b.back = must(make_back_mesh(b.mesh.linear, around, Column<LogMetric<D>>(std::move(logs)), one_thread));
    return b;
}

template <int D>
void check_accuracy(const std::array<int, D>& cells) {
    property("curving for accuracy takes boundary nodes over and reports true lengths",
             [&](std::uint64_t seed) {
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto c = must(curved(b, 0.1, one_thread));
                 const auto rule = gauss_legendre(report_points);
                 for (std::size_t e = 0; e < b.mesh.edges.size(); ++e) {
                     const auto& node = c.proposal.mid_nodes[e];
                     if (b.kinds[e] != EdgeKind::volume) {
                         RC_ASSERT(node == b.boundary_nodes[e]);
                         continue;
                     }
                     const auto [p, q] = b.mesh.edges.vertices[e];
                     const QuadraticEdge<D> edge{b.mesh.linear.points[p], node, b.mesh.linear.points[q]};
                     RC_ASSERT(c.lengths[e] == riemannian_length(b.back, edge, rule, b.shells[e].front()).length);
                 }
                 RC_ASSERT(c.statistics.polished + c.statistics.exhausted + c.statistics.shortened == 0U);
                 RC_ASSERT(c.statistics.curved_edges > 0U);
             },
             {.count = 3});
    // Guards against nodes that are relaxed for `min_jacobian` without a report.
    property("curving for accuracy meets the Jacobian bound where walls allow it",
             [&](std::uint64_t seed) {
                 const auto b = with_rough_field(shell_block<D>(cells, seed + 1), seed);
                 const double least = 0.85;
                 const auto unbounded = must(curved(b, 0, one_thread)), bounded = must(curved(b, least, one_thread));
                 const auto below = [&](const Curved<D>& c) {
                     const auto all = jacobians<D>(b.mesh, c.proposal.mid_nodes.view());
                     return std::count_if(all.begin(), all.end(), [&](double j) { return j < least; });
                 };
                 const auto walls = jacobians<D>(b.mesh, b.boundary_nodes.view());  // volume edges are straight
                 const auto all = jacobians<D>(b.mesh, bounded.proposal.mid_nodes.view());
                 RC_ASSERT(below(unbounded) > 0);
                 RC_ASSERT(below(bounded) < below(unbounded));
                 for (std::size_t e = 0; e < all.size(); ++e) RC_ASSERT(all[e] >= std::min(least, walls[e]) - 0.05);
                 for (std::size_t e = 0; e < b.mesh.edges.size(); ++e) {
                     if (b.kinds[e] != EdgeKind::volume) continue;
                     const Vec<D>& middle = b.mesh.mid_nodes[e].point;
                     RC_ASSERT(norm(bounded.proposal.mid_nodes[e].point - middle) <=
                               norm(unbounded.proposal.mid_nodes[e].point - middle) + 1e-15);
                 }
                 const auto targets = must(accurate_offsets({b.mesh, b.kinds, b.shells}, EdgeKind::volume, b.back,
                                                            EdgeAccuracyOptions{}, one_thread));
                 std::size_t relaxed = 0;
                 for (std::size_t e = 0; e < b.mesh.edges.size(); ++e)
                     relaxed += b.kinds[e] == EdgeKind::volume &&
                                bounded.proposal.mid_nodes[e].point != b.boundary_nodes[e].point + targets[e];
                 RC_ASSERT(relaxed > 0U);
                 RC_ASSERT(bounded.statistics.relaxed == relaxed);
             },
             {.count = 5});
    property("curving for accuracy does not depend on the number of threads",
             [&](std::uint64_t seed) {
                 const auto b = with_rough_field(shell_block<D>(cells, seed + 1), seed);
                 const auto first = must(curved(b, 0.2, one_thread));
                 for (const int threads : {2, 7}) {
                     const auto other = must(curved(b, 0.2, Execution{.threads = threads}));
                     RC_ASSERT(other.proposal == first.proposal);
                     RC_ASSERT(other.lengths == first.lengths);
                 }
             },
             {.count = 2});
}

}  // namespace

TEST_CASE("curving for accuracy keeps boundary nodes and the Jacobian bound, 2D") { check_accuracy<2>({8, 5}); }
TEST_CASE("curving for accuracy keeps boundary nodes and the Jacobian bound, 3D") { check_accuracy<3>({4, 4, 3}); }

TEST_CASE("curving for accuracy stops on request") {
    const auto b = shell_block<2>({3, 2}, 1);
    std::stop_source source;
    source.request_stop();
    const auto stopped_early = curved(b, 0.1, Execution{.threads = 1, .stop = source.get_token()});
    REQUIRE(!stopped_early.has_value());
    CHECK(stopped_early.error().kind == ErrorKind::stopped);
}

TEST_CASE("curving for accuracy rejects a Jacobian bound out of range") {
    const auto b = shell_block<2>({3, 2}, 1);
    const auto refused = curved(b, 1, one_thread);
    REQUIRE(!refused.has_value());
    CHECK(refused.error().kind == ErrorKind::usage);
}
