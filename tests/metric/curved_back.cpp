// The degree-2 back mesh: location, interpolation and its reference.
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

/// x = X + q(X) with q small and quadratic, which P2 meshes represent exactly.
template <int D>
struct QuadraticMap {
    std::array<Sym<D>, D> second;  ///< for each component

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
void check_location() {
    property("points are located in their curved element from any hint, with its field", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto mesh = bent_mesh<D>(seed + 1, dice, 0.03);
        const auto around = must(balls(mesh.linear, one_thread));
        const auto logs = rough_logs<D>(mesh.linear.points.size(), dice);
        const auto back = must(make_curved_back_mesh(mesh, around, logs, one_thread));
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
    property("gradients in curved elements equal the differences of the values", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto mesh = bent_mesh<D>(seed + 1, dice, 0.03);
        const auto back = must(make_curved_back_mesh(mesh, must(balls(mesh.linear, one_thread)),
                                                     rough_logs<D>(mesh.linear.points.size(), dice), one_thread));
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
    property("midpoint nodes give the straight back mesh, to the last bit", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto mesh = must(elevate(unit_box<D>(2, seed + 1), one_thread));
        const auto around = must(balls(mesh.linear, one_thread));
        const auto logs = rough_logs<D>(mesh.linear.points.size(), dice);
        const auto curved = must(make_curved_back_mesh(mesh, around, logs, one_thread));
        const auto straight = must(make_back_mesh(mesh.linear, around, logs, one_thread));
        const Vec<D> x = dice.vector<D>(-0.2, 1.2);
        const ElementId hint(dice.below(mesh.linear.elements.size()));
        RC_ASSERT(sample_value(curved, x, hint).log_metric == sample_value(straight, x, hint).log_metric);
    });
}

template <int D>
void check_gradients() {
    property("edges away from bends have the gradients of the straight mesh, to the last bit", [](std::uint64_t seed) {
        Dice dice(seed);
        auto mesh = must(elevate(unit_box<D>(3, seed + 1), one_thread));
        const std::size_t moved = dice.below(mesh.edges.size());
        auto nodes = take(std::move(mesh.mid_nodes));
        nodes[moved].point += dice.vector<D>(-1e-3, 1e-3);
        mesh.mid_nodes = std::move(nodes);
        const auto around = must(balls(mesh.linear, one_thread));
        const auto shell = must(shells(mesh.edges, one_thread));
        const auto logs = rough_logs<D>(mesh.linear.points.size(), dice);
        const auto curved = must(make_curved_back_mesh(mesh, around, logs, one_thread, StoredGradients::sampled));
        const auto straight = must(make_back_mesh(mesh.linear, around, logs, one_thread));
        const auto is_near = [&](VertexId v) {
            return std::ranges::any_of(around[v], [&](ElementId e) {
                return std::ranges::find(mesh.edges.of_elements[e], EdgeId(moved)) != mesh.edges.of_elements[e].end();
            });
        };
        for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
            const auto& [a, b] = mesh.edges.vertices[e];
            if (is_near(a) || is_near(b)) continue;
            const BackEdge edge{a, b, shell[EdgeId(e)]};
            EdgeEnds<D> sampled, expected;
            curved->sample_edges({&edge, 1}, {&sampled, 1});
            straight->sample_edges({&edge, 1}, {&expected, 1});
            RC_ASSERT(sampled.a.gradient == expected.a.gradient);
            RC_ASSERT(sampled.b.gradient == expected.b.gradient);
        }
    });
    property("stored gradients do not depend on other stored data or the number of threads", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto mesh = bent_mesh<D>(seed + 1, dice, 0.03);
        const auto around = must(balls(mesh.linear, one_thread));
        const auto logs = rough_logs<D>(mesh.linear.points.size(), dice);
        const auto all = must(make_curved_back_mesh(mesh, around, logs, one_thread));
        const Execution threads{.threads = 3};
        const auto for_edges = must(make_curved_back_mesh(mesh, around, logs, threads, StoredGradients::sampled));
        const auto for_points = must(make_curved_back_mesh(mesh, around, logs, threads, StoredGradients::recovered));
        const std::size_t e = dice.below(mesh.edges.size());
        const auto shell = must(shells(mesh.edges, one_thread));
        const BackEdge edge{mesh.edges.vertices[e][0], mesh.edges.vertices[e][1], shell[e]};
        EdgeEnds<D> sampled, expected;
        for_edges->sample_edges({&edge, 1}, {&sampled, 1});
        all->sample_edges({&edge, 1}, {&expected, 1});
        RC_ASSERT(sampled.a.gradient == expected.a.gradient);
        RC_ASSERT(sampled.b.gradient == expected.b.gradient);
        const Vec<D> x = dice.vector<D>(0, 1);
        RC_ASSERT(sample_with_recovered_gradient(for_points, x, {}).gradient ==
                  sample_with_recovered_gradient(all, x, {}).gradient);
    });
    property("straight_back_mesh of a curved back mesh has the values of the straight one", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto mesh = bent_mesh<D>(seed + 1, dice, 0.03);
        const auto around = must(balls(mesh.linear, one_thread));
        const auto logs = rough_logs<D>(mesh.linear.points.size(), dice);
        const auto others = rough_logs<D>(mesh.linear.points.size(), dice);
        const auto beside =
            must(straight_back_mesh(must(make_curved_back_mesh(mesh, around, logs, one_thread)), others));
        const auto straight = must(make_back_mesh(mesh.linear, around, others, one_thread));
        const Vec<D> x = dice.vector<D>(-0.2, 1.2);
        const ElementId hint(dice.below(mesh.linear.elements.size()));
        RC_ASSERT(sample_value(beside, x, hint).log_metric == sample_value(straight, x, hint).log_metric);
        RC_ASSERT(sample_with_recovered_gradient(beside, x, hint).gradient ==
                  sample_with_gradient(straight, x, hint).gradient);
    });
    property("vertices without bent elements have the gradients of the straight mesh", [](std::uint64_t seed) {
        Dice dice(seed);
        auto mesh = must(elevate(unit_box<D>(3, seed + 1), one_thread));
        const auto around = must(balls(mesh.linear, one_thread));
        const auto logs = rough_logs<D>(mesh.linear.points.size(), dice);
        const auto straight = must(make_back_mesh(mesh.linear, around, logs, one_thread));
        const std::size_t moved = dice.below(mesh.edges.size());
        auto nodes = take(std::move(mesh.mid_nodes));
        nodes[moved].point += dice.vector<D>(0.01, 0.02);
        mesh.mid_nodes = std::move(nodes);
        const auto curved = must(make_curved_back_mesh(mesh, around, logs, one_thread));
        const auto shell = must(shells(mesh.edges, one_thread));
        const auto touches = [&](VertexId v) {
            return std::ranges::any_of(
                around[v], [&](ElementId e) { return std::ranges::find(shell[moved], e) != shell[moved].end(); });
        };
        for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
            const auto& [a, b] = mesh.edges.vertices[e];
            if (touches(a) || touches(b)) continue;
            const BackEdge edge{a, b, shell[e]};
            EdgeEnds<D> sampled, expected;
            curved->sample_edges({&edge, 1}, {&sampled, 1});
            straight->sample_edges({&edge, 1}, {&expected, 1});
            for (int i = 0; i < D; ++i)
                RC_ASSERT(norm(sampled.a.gradient[i] - expected.a.gradient[i]) <
                          1e-9 * (1 + norm(sampled.a.gradient[i])));
        }
    });
}

template <int D>
void check_reference() {
    property("a field that bends with the mesh is constant in the reference", [](std::uint64_t seed) {
        Dice dice(seed);
        const QuadraticMap<D> map(dice, 0.05);
        const auto reference = unit_box<D>(2, seed + 1);
        const double anisotropy = std::pow(10.0, dice.uniform(0, 4));
        Vec<D> sizes;
        for (int i = 0; i < D; ++i) sizes[i] = i == 0 ? 1 / anisotropy : 1;
        // The map is applied to vertices and nodes.
        const auto mesh = must(elevate(LinearMesh<D>(reference), one_thread));
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
        const auto back = must(make_curved_back_mesh(bent, must(balls(bent.linear, one_thread)),
                                                     Column<LogMetric<D>>(std::move(logs)), one_thread));
        const auto around = must(shells(bent.edges, one_thread));
        // In an element with the affine map A of its corners the metric is Aᵀ M̂ A at all points. So the metric along
        // an edge is constant in each element.
        for (int n = 0; n < 4; ++n) {
            const std::size_t e = dice.below(bent.edges.size());
            const auto& [a, b] = bent.edges.vertices[e];
            const Vec<D> chord = bent.linear.points[b] - bent.linear.points[a];
            const BackEdge edge{a, b, around[e]};
            EdgeEnds<D> sampled;
            back->sample_edges({&edge, 1}, {&sampled, 1});
            Vec<D> offset;
            accurate_offsets<D>({&chord, 1}, {&sampled, 1}, {}, {&offset, 1});
            RC_ASSERT(norm(offset) < 1e-7 * norm(chord));
        }
    });
}

}  // namespace

TEST_CASE("a curved back mesh locates points and interpolates its field in 2D") { check_location<2>(); }
TEST_CASE("a curved back mesh locates points and interpolates its field in 3D") { check_location<3>(); }
TEST_CASE("gradients of a curved back mesh equal the straight ones away from bends in 2D") { check_gradients<2>(); }
TEST_CASE("gradients of a curved back mesh equal the straight ones away from bends in 3D") { check_gradients<3>(); }
TEST_CASE("a field that bends with the mesh is constant in its reference in 2D") { check_reference<2>(); }
TEST_CASE("a field that bends with the mesh is constant in its reference in 3D") { check_reference<3>(); }
