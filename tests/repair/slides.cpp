// Nodes of boundary edges slide on a geometry: they stay on it to rounding, spoil nothing, and mend what nodes of the
// volume cannot.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "block.hpp"
#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.validity;
import camber.curving;
import camber.repair;

using namespace camber;
using namespace camber::testing;

namespace {

/// The radius of the sphere on which an edge of the block is; 0: on none.
double sphere_of(const Block<3>& b, EdgeId edge) {
    const auto& [p, q] = b.mesh.edges.vertices[edge];
    const double rp = norm(b.mesh.linear.points[p]), rq = norm(b.mesh.linear.points[q]);
    const bool is_there = std::abs(rp - rq) < 1e-12 && (std::abs(rp - 1) < 1e-12 || std::abs(rp - 2) < 1e-12);
    return b.kinds[edge] == EdgeKind::surface && is_there ? rp : 0;
}

GeometryFoot<3> foot_on(const Block<3>& b, EdgeId edge, const Vec<3>& p) {
    const double radius = sphere_of(b, edge);
    if (radius == 0) return {p, Sym<3>::identity()};
    const Vec<3> n = normalised(p);
    Sym<3> across;
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) across(i, j) = n[i] * n[j];
    return {radius * n, across};
}

/// The block with some nodes of its spheres thrown along them.
Proposal<3> thrown_along(const Block<3>& b, Dice& dice) {
    Buffer<LagrangeNode<3>> nodes(b.boundary_nodes.begin(), b.boundary_nodes.end());
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const double radius = sphere_of(b, EdgeId(e));
        if (radius == 0 || dice.below(8) != 0) continue;
        const auto& [p, q] = b.mesh.edges.vertices[e];
        const double chord = distance(b.mesh.linear.points[p], b.mesh.linear.points[q]);
        nodes[e].point = radius * normalised(nodes[e].point + 0.35 * chord * dice.vector<3>(-1, 1));
    }
    return {b.mesh.linear.points, std::move(nodes), b.kinds, Buffer<EdgeChange>(b.kinds.size(), EdgeChange::straight)};
}

TEST_CASE("slides stay on the geometry, spoil nothing, and mend more") {
    std::size_t slid = 0, left_without = 0, left_with = 0;
    property(
        "slides",
        [&](std::uint64_t seed) {
            Dice dice(seed);
            const auto b = shell_block<3>({4, 4, 2}, seed + 1);
            const Proposal<3> before = thrown_along(b, dice);
            RepairOptions options;
            options.min_scaled_jacobian = 1e-9;
            options.vertices = VertexMoves::never;
            const auto judged = must(validate(b.mesh, before, options.min_scaled_jacobian, alone));
            RepairGuide<3> guide{b.shells, [nodes = b.boundary_nodes](EdgeId e) { return nodes[e]; },
                                 implied_edge_models(b.mesh, b.boundary_nodes, b.shells)};
            guide.surface = SurfaceMoves::on_geometry;
            const auto without = must(repair(judged, guide, options, alone));
            guide.onto = [&](EdgeId edge, const Vec<3>& p) { return foot_on(b, edge, p); };
            const auto with = must(repair(judged, guide, options, alone));
            RC_ASSERT(must(repair(judged, guide, options, Execution{3})).judged.proposal() == with.judged.proposal());
            left_without += without.judged.validation().not_valid();
            left_with += with.judged.validation().not_valid();
            for (std::size_t e = 0; e < b.kinds.size(); ++e) {
                const Vec<3>& node = with.judged.proposal().mid_nodes[e].point;
                if (b.kinds[e] == EdgeKind::volume || node == before.mid_nodes[e].point) continue;
                ++slid;
                RC_ASSERT(std::abs(norm(node) - sphere_of(b, EdgeId(e))) <= 1e-14);
            }
            for (std::size_t e = 0; e < judged.validation().verdicts.size(); ++e)
                if (judged.validation().verdicts[e] == Verdict::valid)
                    RC_ASSERT(with.judged.validation().verdicts[e] == Verdict::valid);
        },
        {6});
    CHECK(slid > 0);
    CHECK(left_with < left_without);
}

}  // namespace
