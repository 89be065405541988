// Interpolation of log-metrics on back meshes and along P2 edges.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "back.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void check_interpolation() {
    property("an affine field is reproduced with its gradients",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto field = AffineField<D>::random(dice);
                 const auto back = back_of(unit_box<D>(4, seed + 1), field);
                 for (int k = 0; k < 10; ++k) {
                     const Vec<D> x = random_point(back.mesh, dice);
                     const ElementId hint(dice.below(back.mesh.elements.size()));
                     const auto sample = sample_with_gradient(back, x, hint);
                     const auto recovered = sample_with_recovered_gradient(back, x, hint);
                     RC_ASSERT(norm(sample_value(back, x, hint).log_metric.l - field(x).l) < 1e-12);
                     RC_ASSERT(norm(sample.log_metric.l - field(x).l) < 1e-12);
                     for (int i = 0; i < D; ++i) {
                         RC_ASSERT(norm(sample.gradient[i] - field.slope[i]) < 1e-10);
                         RC_ASSERT(norm(recovered.gradient[i] - field.slope[i]) < 1e-10);
                     }
                 }
             },
             {.count = 30});
    property("fields and recovered gradients are continuous across faces",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto back = rough_back(unit_box<D>(3, seed + 1), dice);
                 const auto across = must(neighbours(back.mesh, must(balls(back.mesh, one_thread)), one_thread));
                 for (std::size_t e = 0; e < back.mesh.elements.size(); ++e)
                     for (int i = 0; i <= D; ++i) {
                         const ElementId other = across[e][i];
                         if (!other.valid()) continue;
                         auto xi = dice.barycentric<D>();
                         xi[i] = 0;
                         double sum = 0;
                         for (const double u : xi) sum += u;
                         Vec<D> x;
                         const auto p = corners(back.mesh, e);
                         for (int k = 0; k <= D; ++k) x += xi[k] / sum * p[k];
                         const auto here = sample_with_recovered_gradient(back, x, ElementId(e));
                         const auto there = sample_with_recovered_gradient(back, x, other);
                         RC_ASSERT(norm(here.log_metric.l - there.log_metric.l) < 1e-11);
                         for (int k = 0; k < D; ++k) RC_ASSERT(norm(here.gradient[k] - there.gradient[k]) < 1e-9);
                     }
             },
             {.count = 5});
    property("gradients of barycentric coordinates are dual to the edges and sum to zero",
             [](std::uint64_t seed) {
                 const auto mesh = unit_box<D>(2, seed + 1);
                 for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
                     const auto g = barycentric_gradients(mesh, ElementId(e));
                     const auto p = corners(mesh, e);
                     Vec<D> sum;
                     for (int i = 0; i <= D; ++i) {
                         sum += g[i];
                         for (int j = 0; j <= D; ++j)
                             RC_ASSERT(std::abs(dot(g[i], p[j] - p[i]) - (i == j ? 0.0 : -1.0)) < 1e-12);
                     }
                     RC_ASSERT(norm(sum) < 1e-12);
                 }
             },
             {.count = 10});
    property("the gradient of a sample is that of the field, also beyond the boundary",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto back = rough_back(unit_box<D>(3, seed + 1, 0.1), dice);
                 const double h = 1e-6;
                 int checked = 0;
                 for (int k = 0; k < 20; ++k) {
                     const Vec<D> x = dice.vector<D>(-0.4, 1.4);
                     const auto sample = sample_with_gradient(back, x, ElementId(std::size_t{0}));
                     for (int i = 0; i < D; ++i) {
                         Vec<D> step;
                         step[i] = h;
                         const auto ahead = sample_with_gradient(back, x + step, sample.location.element);
                         const auto behind = sample_with_gradient(back, x - step, sample.location.element);
                         if (ahead.location.element != behind.location.element) continue;  // a kink lies between them
                         // Beyond the boundary, kinks also occur where the nearest point passes from a face to an edge.
                         const Sym<D> bend = ahead.log_metric.l + behind.log_metric.l - 2.0 * sample.log_metric.l;
                         if (norm(bend) > 1e-9) continue;
                         ++checked;
                         const Sym<D> difference = (ahead.log_metric.l - behind.log_metric.l) * (1 / (2 * h));
                         RC_ASSERT(norm(difference - sample.gradient[i]) < 1e-5 * (1 + norm(difference)));
                     }
                 }
                 RC_ASSERT(checked > 10);
             },
             {.count = 20});
    property("the field rotates with mesh and metrics and scales with the metrics",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto mesh = unit_box<D>(3, seed + 1);
                 const auto back = rough_back(mesh, dice);
                 const auto r = dice.rotation<D>();
                 const double c = std::log(dice.uniform(0.1, 10));
                 Buffer<Vec<D>> points(mesh.points.size());
                 Buffer<LogMetric<D>> logs(points.size());
                 for (std::size_t v = 0; v < points.size(); ++v) {
                     points[v] = r * mesh.points[v];
                     logs[v].l = congruence(r, back.log_metrics[v].l) + c * Sym<D>::identity();
                 }
                 auto turned_mesh = mesh;
                 turned_mesh.points = std::move(points);
                 const auto turned = *make_back_mesh(turned_mesh, *balls(turned_mesh, one_thread),
                                                     Column<LogMetric<D>>(std::move(logs)), one_thread);
                 for (int k = 0; k < 10; ++k) {
                     const Vec<D> x = random_point(mesh, dice);
                     const auto plain = sample_value(back, x, ElementId(std::size_t{0})).log_metric;
                     const auto other = sample_value(turned, r * x, ElementId(std::size_t{0})).log_metric;
                     RC_ASSERT(norm(other.l - congruence(r, plain.l) - c * Sym<D>::identity()) < 1e-11);
                 }
             },
             {.count = 10});
    property("the determinant satisfies det M(ξ) = ∏ det(M_i)^{ξ_i} (paper, eq. 5, linear)", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto back = rough_back(unit_box<D>(2, seed + 1), dice, 3);
        const Vec<D> x = random_point(back.mesh, dice);
        const auto s = sample_value(back, x, ElementId(std::size_t{0}));
        double log_det = 0;
        for (int i = 0; i <= D; ++i)
            log_det += s.location.xi[i] * trace(back.log_metrics[back.mesh.elements.vertices[s.location.element][i]].l);
        const SpectralMetric<D> m(s.log_metric);
        double found = 0;
        for (int i = 0; i < D; ++i) {
            RC_ASSERT(m.values[i] > 0);
            found += std::log(m.values[i]);
        }
        RC_ASSERT(std::abs(found - log_det) < 1e-12);
    });
    property("the field of an edge interpolates its nodes, equals (3) and (4), and may be linear",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const EdgeField<D> field{{dice.symmetric<D>()}, {dice.symmetric<D>()}, {dice.symmetric<D>()}};
                 RC_ASSERT(norm(field.at(0).l - field.l20.l) < 1e-15);
                 RC_ASSERT(norm(field.at(0.5).l - field.mid.l) < 1e-15);
                 RC_ASSERT(norm(field.at(1).l - field.l02.l) < 1e-15);
                 const double t = dice.uniform(0, 1), s = 1 - t;
                 const Sym<D> bezier = s * s * field.l20.l + 2 * s * t * field.virtual_mid().l + t * t * field.l02.l;
                 RC_ASSERT(norm(field.at(t).l - bezier) < 1e-14);
                 const EdgeField<D> linear{field.l20, {0.5 * (field.l20.l + field.l02.l)}, field.l02};
                 RC_ASSERT(norm(linear.at(t).l - (s * field.l20.l + t * field.l02.l)) < 1e-14);
             });
}

}  // namespace

TEST_CASE("fields on triangles reproduce affine data and are continuous") { check_interpolation<2>(); }
TEST_CASE("fields on tetrahedra reproduce affine data and are continuous") { check_interpolation<3>(); }

TEST_CASE("a back mesh rejects a metric of another mesh") {
    const auto mesh = unit_box<2>(2, 1);
    const auto back =
        make_back_mesh(mesh, must(balls(mesh, one_thread)), Column<LogMetric<2>>(Buffer<LogMetric<2>>(3)), one_thread);
    REQUIRE(!back.has_value());
    CHECK(back.error().kind == ErrorKind::input);
}
