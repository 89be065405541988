// Boundary nodes and vertices slide on a geometry: they stay on it to rounding, keep valid elements valid, and correct
// elements that volume nodes cannot.
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

/// The radius of the sphere of an edge; 0 if there is none.
double sphere_of(const Block<3>& b, EdgeId edge) {
    const auto& [p, q] = b.mesh.edges.vertices[edge];
    const double rp = norm(b.mesh.linear.points[p]), rq = norm(b.mesh.linear.points[q]);
    const bool is_present = std::abs(rp - rq) < 1e-12 && (std::abs(rp - 1) < 1e-12 || std::abs(rp - 2) < 1e-12);
    return b.kinds[edge] == EdgeKind::surface && is_present ? rp : 0;
}

GeometryFoot<3> on_sphere(double radius, const Vec<3>& p) {
    const Vec<3> n = normalised(p);
    Sym<3> across;
    for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) across(i, j) = n[i] * n[j];
    return {radius * n, across};
}

GeometryFoot<3> foot_on(const Block<3>& b, EdgeId edge, const Vec<3>& p) {
    const double radius = sphere_of(b, edge);
    return radius == 0 ? GeometryFoot<3>{p, Sym<3>::identity()} : on_sphere(radius, p);
}

/// The block with some nodes of its spheres displaced along them.
Proposal<3> displaced_along(const Block<3>& b, Dice& dice) {
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

/// Targets are the nodes on the spheres. Without projections nodes may not slide.
RepairGuide<3> without_projection(const Block<3>& b) {
    RepairGuide<3> guide{b.shells, [nodes = b.boundary_nodes](EdgeId e) { return nodes[e]; },
                         implied_edge_models(b.mesh, b.boundary_nodes, b.shells)};
    guide.surface = SurfaceMoves::on_geometry;
    return guide;
}

TEST_CASE("sliding nodes stay on the geometry and repair more elements") {
    std::size_t slid = 0, invalid_without = 0, invalid_with = 0;
    property(
        "nodes slide along the geometry and valid elements stay valid",
        [&](std::uint64_t seed) {
            Dice dice(seed);
            const auto b = shell_block<3>({4, 4, 2}, seed + 1);
            const Proposal<3> before = displaced_along(b, dice);
            RepairOptions options;
            options.min_scaled_jacobian = 1e-9;
            options.vertices = VertexMoves::never;
            const auto judged = must(validate(b.mesh, before, options.min_scaled_jacobian, one_thread));
            RepairGuide<3> guide = without_projection(b);
            const auto without = must(repair(judged, guide, options, one_thread));
            guide.onto = [&](EdgeId edge, const Vec<3>& p) { return foot_on(b, edge, p); };
            const auto with = must(repair(judged, guide, options, one_thread));
            RC_ASSERT(must(repair(judged, guide, options, Execution{3})).judged.proposal() == with.judged.proposal());
            invalid_without += without.judged.validation().not_valid();
            invalid_with += with.judged.validation().not_valid();
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
    CHECK(invalid_with < invalid_without);
}

/// The radius of the sphere patch that contains a vertex; 0 if there is none.
double sphere_of(const Block<3>& b, VertexId v, const Buffer<std::uint8_t>& on_other_faces) {
    const double r = norm(b.mesh.linear.points[v]);
    return on_other_faces[v.index()] == 0 && (std::abs(r - 1) < 1e-12 || std::abs(r - 2) < 1e-12) ? r : 0;
}

/// 1 for vertices of boundary edges that are on no sphere.
Buffer<std::uint8_t> on_other_faces(const Block<3>& b) {
    Buffer<std::uint8_t> marks(b.mesh.linear.points.size(), 0);
    for (std::size_t e = 0; e < b.kinds.size(); ++e)
        if (b.kinds[e] != EdgeKind::volume && sphere_of(b, EdgeId(e)) == 0)
            for (const VertexId v : b.mesh.edges.vertices[e]) marks[v.index()] = 1;
    return marks;
}

TEST_CASE("boundary vertices slide on the geometry where nodes do not suffice") {
    std::size_t slid = 0, invalid_by_nodes = 0, invalid_count = 0;
    property(
        "boundary vertices slide along the geometry and valid elements stay valid",
        [&](std::uint64_t seed) {
            Dice dice(seed);
            const auto b = shell_block<3>({4, 4, 2}, seed + 1);
            const Proposal<3> before = displaced_along(b, dice);
            RepairOptions options;
            options.min_scaled_jacobian = 0.3;  // nodes alone rarely reach it
            options.effort = 100;
            const auto judged = must(validate(b.mesh, before, options.min_scaled_jacobian, one_thread));
            RepairGuide<3> guide = without_projection(b);
            guide.onto = [&](EdgeId edge, const Vec<3>& p) { return foot_on(b, edge, p); };
            const auto by_nodes = must(repair(judged, guide, options, one_thread));
            guide.vertices_onto = [&b, others = on_other_faces(b)](VertexId v, const Vec<3>& p) {
                const double radius = sphere_of(b, v, others);
                return radius == 0 ? GeometryFoot<3>{p, Sym<3>::identity()} : on_sphere(radius, p);
            };
            const auto with = must(repair(judged, guide, options, one_thread));
            RC_ASSERT(must(repair(judged, guide, options, Execution{3})).judged.proposal() == with.judged.proposal());
            invalid_by_nodes += by_nodes.judged.validation().not_valid();
            invalid_count += with.judged.validation().not_valid();
            const Proposal<3>& after = with.judged.proposal();
            const auto on_boundary = boundary_vertices(b.mesh, b.kinds);
            const auto others = on_other_faces(b);
            for (std::size_t v = 0; v < on_boundary.size(); ++v) {
                if (on_boundary[v] == 0 || after.points[v] == b.mesh.linear.points[v]) continue;
                ++slid;
                const double radius = sphere_of(b, VertexId(v), others);
                RC_ASSERT(radius > 0);
                RC_ASSERT(std::abs(norm(after.points[v]) - radius) <= 1e-14);
            }
            for (std::size_t e = 0; e < b.kinds.size(); ++e) {
                const Vec<3>& node = after.mid_nodes[e].point;
                if (b.kinds[e] == EdgeKind::volume || node == before.mid_nodes[e].point) continue;
                RC_ASSERT(sphere_of(b, EdgeId(e)) > 0);
                RC_ASSERT(std::abs(norm(node) - sphere_of(b, EdgeId(e))) <= 1e-14);
            }
            for (std::size_t e = 0; e < judged.validation().verdicts.size(); ++e)
                if (judged.validation().verdicts[e] == Verdict::valid)
                    RC_ASSERT(with.judged.validation().verdicts[e] == Verdict::valid);
            options.vertices = VertexMoves::never;
            RC_ASSERT(must(repair(judged, guide, options, one_thread)).judged.proposal().points ==
                      b.mesh.linear.points);
        },
        {4});
    CHECK(slid > 0);
    CHECK(invalid_count <= invalid_by_nodes);
}

}  // namespace
