// The back mesh of degree 2: where points lie in it, what it says there, and what its reference sees.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
#include <rapidcheck.h>

#include "back.hpp"
#include "bent.hpp"
#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;

using namespace camber;
using namespace camber::testing;

namespace {

/// x = X + q(X) with q of degree 2, small: P2 meshes hold it exactly.
template <int D>
struct QuadraticMap {
    std::array<Sym<D>, D> second;  ///< of each component

    explicit QuadraticMap(Dice& dice, double size) {
        for (Sym<D>& s : second) s = dice.symmetric<D>(size);
    }
    [[nodiscard]] Vec<D> operator()(const Vec<D>& p) const {
        Vec<D> x = p;
        for (int i = 0; i < D; ++i) x[i] += dot(p, second[i] * p);
        return x;
    }
    [[nodiscard]] Mat<D> jacobian(const Vec<D>& p) const {
        Mat<D> f = Mat<D>::identity();
        for (int i = 0; i < D; ++i) {
            const Vec<D> row = 2 * (second[i] * p);
            for (int j = 0; j < D; ++j) f(i, j) += row[j];
        }
        return f;
    }
};

template <int D>
void location_laws() {
    property("points of curved elements are found in them, from any hint, and the field is theirs",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto mesh = bent_mesh<D>(seed + 1, dice, 0.03);
                 const auto around = must(balls(mesh.linear, alone));
                 const auto logs = rough_logs<D>(mesh.linear.points.size(), dice);
                 const auto back = must(make_curved_back_mesh(mesh, around, logs, alone));
                 for (int n = 0; n < 10; ++n) {
                     const ElementId e(dice.below(mesh.linear.elements.size()));
                     const auto xi = inner_place<D>(dice);
                     const auto sample =
                         sample_value(back, point_in(mesh, e, xi), ElementId(dice.below(mesh.linear.elements.size())));
                     RC_ASSERT(sample.location.placement == Placement::inside);
                     RC_ASSERT(sample.location.element == e);
                     LogMetric<D> expected;
                     for (int i = 0; i <= D; ++i) {
                         RC_ASSERT(std::abs(sample.location.xi[i] - xi[i]) < 1e-8);
                         expected.l += xi[i] * logs[mesh.linear.elements.vertices[e][i]].l;
                     }
                     for (std::size_t k = 0; k < expected.l.c.size(); ++k)
                         RC_ASSERT(std::abs(sample.log_metric.l.c[k] - expected.l.c[k]) < 1e-7);
                 }
             });
    property("gradients are those of the values", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto mesh = bent_mesh<D>(seed + 1, dice, 0.03);
        const auto back = must(make_curved_back_mesh(mesh, must(balls(mesh.linear, alone)),
                                                     rough_logs<D>(mesh.linear.points.size(), dice), alone));
        const ElementId e(dice.below(mesh.linear.elements.size()));
        const Vec<D> x = point_in(mesh, e, inner_place<D>(dice));
        const auto sample = sample_with_gradient(back, x, e);
        const double step = 1e-4;
        for (int i = 0; i < D; ++i) {
            Vec<D> ahead = x, behind = x;
            ahead[i] += step;
            behind[i] -= step;
            const Sym<D> difference =
                sample_value(back, ahead, e).log_metric.l - sample_value(back, behind, e).log_metric.l;
            for (std::size_t k = 0; k < difference.c.size(); ++k)
                RC_ASSERT(std::abs(difference.c[k] / (2 * step) - sample.gradient[i].c[k]) < 1e-3);
        }
    });
    property("nodes in the middles: the straight back mesh, to the last bit", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto mesh = must(elevate(unit_box<D>(2, seed + 1), alone));
        const auto around = must(balls(mesh.linear, alone));
        const auto logs = rough_logs<D>(mesh.linear.points.size(), dice);
        const auto curved = must(make_curved_back_mesh(mesh, around, logs, alone));
        const auto straight = must(make_back_mesh(mesh.linear, around, logs, alone));
        const Vec<D> x = dice.vector<D>(-0.2, 1.2);
        const ElementId hint(dice.below(mesh.linear.elements.size()));
        RC_ASSERT(sample_value(curved, x, hint).log_metric == sample_value(straight, x, hint).log_metric);
    });
}

template <int D>
void kept_laws() {
    property("edges away from all bends see what they see in the straight mesh, to the last bit",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 auto mesh = must(elevate(unit_box<D>(3, seed + 1), alone));
                 const std::size_t moved = dice.below(mesh.edges.size());
                 auto nodes = take(std::move(mesh.mid_nodes));
                 nodes[moved].point += dice.vector<D>(-1e-3, 1e-3);
                 mesh.mid_nodes = std::move(nodes);
                 const auto around = must(balls(mesh.linear, alone));
                 const auto shell = must(shells(mesh.edges, alone));
                 const auto logs = rough_logs<D>(mesh.linear.points.size(), dice);
                 const auto curved = must(make_curved_back_mesh(mesh, around, logs, alone, KeptGradients::seen));
                 const auto straight = must(make_back_mesh(mesh.linear, around, logs, alone));
                 const auto is_near = [&](VertexId v) {
                     return std::ranges::any_of(around[v], [&](ElementId e) {
                         return std::ranges::find(mesh.edges.of_elements[e], EdgeId(moved)) !=
                                mesh.edges.of_elements[e].end();
                     });
                 };
                 for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
                     const auto& [a, b] = mesh.edges.vertices[e];
                     if (is_near(a) || is_near(b)) continue;
                     const BackEdge edge{a, b, shell[EdgeId(e)]};
                     EdgeEnds<D> seen, expected;
                     curved->see({&edge, 1}, {&seen, 1});
                     straight->see({&edge, 1}, {&expected, 1});
                     RC_ASSERT(seen.a.gradient == expected.a.gradient);
                     RC_ASSERT(seen.b.gradient == expected.b.gradient);
                 }
             });
    property(
        "gradients that are kept are the same whatever else is, and for any number of threads", [](std::uint64_t seed) {
            Dice dice(seed);
            const auto mesh = bent_mesh<D>(seed + 1, dice, 0.03);
            const auto around = must(balls(mesh.linear, alone));
            const auto logs = rough_logs<D>(mesh.linear.points.size(), dice);
            const auto all = must(make_curved_back_mesh(mesh, around, logs, alone));
            const Execution threads{.threads = 3};
            const auto for_edges = must(make_curved_back_mesh(mesh, around, logs, threads, KeptGradients::seen));
            const auto for_points = must(make_curved_back_mesh(mesh, around, logs, threads, KeptGradients::recovered));
            const std::size_t e = dice.below(mesh.edges.size());
            const auto shell = must(shells(mesh.edges, alone));
            const BackEdge edge{mesh.edges.vertices[e][0], mesh.edges.vertices[e][1], shell[e]};
            EdgeEnds<D> seen, expected;
            for_edges->see({&edge, 1}, {&seen, 1});
            all->see({&edge, 1}, {&expected, 1});
            RC_ASSERT(seen.a.gradient == expected.a.gradient);
            RC_ASSERT(seen.b.gradient == expected.b.gradient);
            const Vec<D> x = dice.vector<D>(0, 1);
            RC_ASSERT(sample_with_recovered_gradient(for_points, x, {}).gradient ==
                      sample_with_recovered_gradient(all, x, {}).gradient);
        });
    property("other logs beside a curved back mesh: the values of the straight one", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto mesh = bent_mesh<D>(seed + 1, dice, 0.03);
        const auto around = must(balls(mesh.linear, alone));
        const auto logs = rough_logs<D>(mesh.linear.points.size(), dice);
        const auto others = rough_logs<D>(mesh.linear.points.size(), dice);
        const auto beside = must(straight_back_mesh(must(make_curved_back_mesh(mesh, around, logs, alone)), others));
        const auto straight = must(make_back_mesh(mesh.linear, around, others, alone));
        const Vec<D> x = dice.vector<D>(-0.2, 1.2);
        const ElementId hint(dice.below(mesh.linear.elements.size()));
        RC_ASSERT(sample_value(beside, x, hint).log_metric == sample_value(straight, x, hint).log_metric);
        RC_ASSERT(sample_with_recovered_gradient(beside, x, hint).gradient ==
                  sample_with_gradient(straight, x, hint).gradient);
    });
    property("vertices that no bent element touches see what they see in the straight mesh", [](std::uint64_t seed) {
        Dice dice(seed);
        auto mesh = must(elevate(unit_box<D>(3, seed + 1), alone));
        const auto around = must(balls(mesh.linear, alone));
        const auto logs = rough_logs<D>(mesh.linear.points.size(), dice);
        const auto straight = must(make_back_mesh(mesh.linear, around, logs, alone));
        const std::size_t moved = dice.below(mesh.edges.size());
        auto nodes = take(std::move(mesh.mid_nodes));
        nodes[moved].point += dice.vector<D>(0.01, 0.02);
        mesh.mid_nodes = std::move(nodes);
        const auto curved = must(make_curved_back_mesh(mesh, around, logs, alone));
        const auto shell = must(shells(mesh.edges, alone));
        const auto touches = [&](VertexId v) {
            return std::ranges::any_of(
                around[v], [&](ElementId e) { return std::ranges::find(shell[moved], e) != shell[moved].end(); });
        };
        for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
            const auto& [a, b] = mesh.edges.vertices[e];
            if (touches(a) || touches(b)) continue;
            const BackEdge edge{a, b, shell[e]};
            EdgeEnds<D> seen, expected;
            curved->see({&edge, 1}, {&seen, 1});
            straight->see({&edge, 1}, {&expected, 1});
            for (int i = 0; i < D; ++i)
                RC_ASSERT(norm(seen.a.gradient[i] - expected.a.gradient[i]) < 1e-9 * (1 + norm(seen.a.gradient[i])));
        }
    });
}

template <int D>
void reference_laws() {
    property("a field that the mesh's own curves bend is constant in the reference", [](std::uint64_t seed) {
        Dice dice(seed);
        const QuadraticMap<D> map(dice, 0.05);
        const auto reference = unit_box<D>(2, seed + 1);
        const double anisotropy = std::pow(10.0, dice.uniform(0, 4));
        Vec<D> sizes;
        for (int i = 0; i < D; ++i) sizes[i] = i == 0 ? 1 / anisotropy : 1;
        // The map is the mesh's: its vertices are moved too, and nodes put where it has them.
        const auto mesh = must(elevate(LinearMesh<D>(reference), alone));
        Buffer<LagrangeNode<D>> nodes(mesh.edges.size());
        Buffer<LogMetric<D>> logs(reference.points.size());
        QuadraticMesh<D> bent = mesh;
        for (std::size_t e = 0; e < nodes.size(); ++e) nodes[e].point = map(mesh.mid_nodes[e].point);
        auto points = take(std::move(bent.linear.points));
        for (std::size_t v = 0; v < points.size(); ++v) points[v] = map(points[v]);
        bent.linear.points = std::move(points);
        bent.mid_nodes = std::move(nodes);
        // M = G⁻ᵀ M̂ G⁻¹, G the map's Jacobian: its square root by the singular values of G⁻ᵀ M̂^{1/2}.
        for (std::size_t v = 0; v < logs.size(); ++v) {
            Mat<D> factor = transposed(inverse(map.jacobian(reference.points[v])));
            for (int i = 0; i < D; ++i) factor.column[i] *= 1 / sizes[i];
            auto s = left_singular(factor);
            for (int i = 0; i < D; ++i) s.values[i] = 2 * std::log(s.values[i]);
            logs[v] = {composed(s)};
        }
        const auto back = must(
            make_curved_back_mesh(bent, must(balls(bent.linear, alone)), Column<LogMetric<D>>(std::move(logs)), alone));
        const auto around = must(shells(bent.edges, alone));
        // An element sees M̂ through the affine map A of its corners: Aᵀ M̂ A, the same at all of them. So what an edge
        // sees is constant along it, in whichever element.
        for (int n = 0; n < 4; ++n) {
            const std::size_t e = dice.below(bent.edges.size());
            const auto& [a, b] = bent.edges.vertices[e];
            const Vec<D> chord = bent.linear.points[b] - bent.linear.points[a];
            const BackEdge edge{a, b, around[e]};
            EdgeEnds<D> seen;
            back->see({&edge, 1}, {&seen, 1});
            Vec<D> offset;
            accurate_offsets<D>({&chord, 1}, {&seen, 1}, {}, {&offset, 1});
            RC_ASSERT(norm(offset) < 1e-7 * norm(chord));
        }
    });
}

}  // namespace

TEST_CASE("2D: points in a curved back mesh") { location_laws<2>(); }
TEST_CASE("3D: points in a curved back mesh") { location_laws<3>(); }
TEST_CASE("2D: gradients of a curved back mesh") { kept_laws<2>(); }
TEST_CASE("3D: gradients of a curved back mesh") { kept_laws<3>(); }
TEST_CASE("2D: the reference of a curved back mesh") { reference_laws<2>(); }
TEST_CASE("3D: the reference of a curved back mesh") { reference_laws<3>(); }
