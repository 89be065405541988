// Optimal metrics: exponents, complexity, the one-dimensional case, and invariance under units, frames and threads.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dice.hpp"
#include "layers.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;
import camber.solution_metric;

using namespace camber;
using namespace camber::testing;

namespace {

NormOptions random_norm(Dice& dice) {
    return {.degree = 1 + static_cast<int>(dice.below(2)),
            .p = std::array{0.0, 1.0, 2.0, 4.0, 7.5}[dice.below(5)],
            .error_of = dice.below(2) == 0 ? ErrorQuantity::values : ErrorQuantity::gradients};
}

template <int D>
void check_optimal_metric() {
    property("without bounds M = c det(Q)^{−1/(P+n)} Q has the requested complexity",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto mesh = box_with_facets<D>(2, seed + 1, 0.2);
                 const auto models = models_on(mesh, [&](const Vec<D>&) { return random_model<D>(dice, 2); });
                 const NormOptions aim = random_norm(dice);
                 const double n = std::pow(10.0, dice.uniform(0, 6)), huge = 1e30;
                 const auto out = must(optimal_metric(mesh, models, {aim, n, huge}, one_thread));
                 RC_ASSERT(std::abs(must(complexity(mesh, out.log_metrics, one_thread)) / n - 1) < 2e-6);
                 RC_ASSERT(std::abs(out.complexity / n - 1) < 2e-6);
                 const double exponent =
                     aim.p == 0 ? 0 : 1 / (aim.p * (aim.degree + (aim.error_of == ErrorQuantity::values ? 1 : 0)) + D);
                 double constant = 0;
                 for (std::size_t v = 0; v < models.size(); ++v) {
                     const Sym<D> q = composed(models[v].logs);
                     const Sym<D> rest = out.log_metrics[v].l - q + exponent * trace(q) * Sym<D>::identity();
                     if (v == 0) constant = rest(0, 0);
                     RC_ASSERT(norm(rest - constant * Sym<D>::identity()) < 1e-9);
                 }
                 const double factor = dice.uniform(-400, 400);
                 Buffer<LocalModel<D>> scaled(models.begin(), models.end());
                 for (auto& m : scaled)
                     for (double& x : m.logs.values.c) x += factor;
                 const auto same =
                     must(optimal_metric(mesh, Column<LocalModel<D>>(std::move(scaled)), {aim, n, huge}, one_thread));
                 for (std::size_t v = 0; v < models.size(); ++v)
                     RC_ASSERT(norm(out.log_metrics[v].l - same.log_metrics[v].l) < 1e-4);
             },
             {.count = 40});
    property("sizes are at most the maximum, as if smaller eigenvalues were raised to it",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const double power = std::array{1.0, 4.0, 12.0}[dice.below(3)], largest = 1;
                 const double scale = dice.uniform(-3, 3);
                 const auto model = random_model<D>(dice, 3);
                 const auto sizes = optimal_sizes<D>(model.logs.values, scale, power, largest);
                 double raised = 0;
                 for (int i = 0; i < D; ++i) {
                     RC_ASSERT(sizes.metric_logs[i] >= 0);
                     raised += std::max(model.logs.values[i], sizes.log_epsilon);
                     if (sizes.metric_logs[i] > 1e-9)
                         RC_ASSERT(std::abs(sizes.metric_logs[i] - (model.logs.values[i] - sizes.log_epsilon)) < 1e-9);
                 }
                 RC_ASSERT(std::abs(sizes.log_epsilon - scale - raised / (power + D)) < 1e-9);
                 const auto finer = optimal_sizes<D>(model.logs.values, scale - 0.1, power, largest);
                 for (int i = 0; i < D; ++i) RC_ASSERT(finer.metric_logs[i] >= sizes.metric_logs[i]);
             },
             {.count = 200});
}

/// A function of x alone: the other sizes are the maximum size. Each unit interval has the same P-th power of the
/// error, as in one dimension: M_xx ∝ q^{P/(P+1)}.
template <int D>
void check_one_dimension() {
    const auto mesh = box_with_facets<D>(12, 0, 0);
    const auto q_at = [](const Vec<D>& p) { return std::exp(-4 * p[0]) + 1e-3; };
    const auto models = models_on(mesh, [&](const Vec<D>& p) {
        auto m = zero_model<D>();
        m.kind = ModelKind::regular;
        m.logs.values[0] = std::log(q_at(p));
        return m;
    });
    const NormOptions aim{.degree = 2, .p = 2};
    const double largest = 0.5;
    const auto out = must(optimal_metric(mesh, models, {aim, 400, largest}, one_thread));
    const auto constant_at = [&](std::size_t v) {
        return out.log_metrics[v].l(0, 0) - 6.0 / 7 * std::log(q_at(mesh.points[v]));
    };
    for (std::size_t v = 0; v < models.size(); ++v) {
        CHECK(constant_at(v) == doctest::Approx(constant_at(0)).epsilon(1e-9));
        for (int i = 1; i < D; ++i) CHECK(out.log_metrics[v].l(i, i) == doctest::Approx(-2 * std::log(largest)));
    }
}

template <int D>
void check_frames() {
    property("the metric rotates and scales with space",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto mesh = box_with_facets<D>(2, seed + 1, 0.2);
                 const Mat<D> r = dice.rotation<D>();
                 const double length = std::pow(10.0, dice.uniform(-6, 6));
                 const auto models = models_on(mesh, [&](const Vec<D>&) { return random_model<D>(dice, 2); });
                 auto other = mesh;
                 auto points = take(std::move(other.points));
                 for (Vec<D>& p : points) p = length * (r * p);
                 other.points = std::move(points);
                 Buffer<LocalModel<D>> turned(models.begin(), models.end());
                 for (auto& m : turned) m.logs.vectors = r * m.logs.vectors;
                 const auto a = must(optimal_metric(mesh, models, {{}, 200, 0.8}, one_thread));
                 const auto b = must(optimal_metric(other, Column<LocalModel<D>>(std::move(turned)),
                                                    {{}, 200, 0.8 * length}, one_thread));
                 for (std::size_t v = 0; v < models.size(); ++v) {
                     const Sym<D> expected =
                         congruence(r, a.log_metrics[v].l) - 2 * std::log(length) * Sym<D>::identity();
                     RC_ASSERT(norm(b.log_metrics[v].l - expected) < 1e-4);
                 }
             },
             {.count = 20});
}

/// Element models with an anisotropy of 1000 and axes that rotate around a circle: models at vertices.
void check_rotating_models() {
    const auto mesh = box_with_facets<2>(10, 3, 0.2);
    const auto ball = must(balls(mesh, one_thread));
    Buffer<LocalModel<2>> rows;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        const auto p = corners(mesh, e);
        const Vec<2> n = normalised((p[0] + p[1] + p[2]) / 3 + Vec<2>{{0.5, 0.5}});
        rows.push_back(model_of<2>({{1e6, 1}}, Mat<2>{{n, Vec<2>{{-n[1], n[0]}}}}));
    }
    const auto out = must(models_at_vertices(mesh, ball, Column<LocalModel<2>>(rows), {{}, 1e4, 10}, one_thread));
    for (std::size_t v = 0; v < out.size(); ++v) {
        const auto& x = out[v].logs.values;
        CHECK(std::abs(x[0] - x[1]) > 0.99 * std::log(1e6));
        const Vec<2> n = normalised(mesh.points[v] + Vec<2>{{0.5, 0.5}});
        CHECK(std::abs(dot(out[v].logs.vectors.column[x[0] > x[1] ? 0 : 1], n)) > 0.995);
    }
}

template <int D>
void check_constant_models() {
    const auto mesh = box_with_facets<D>(3, 2, 0.2);
    const auto ball = must(balls(mesh, one_thread));
    Dice dice(4);
    const auto model = random_model<D>(dice, 1);
    Buffer<LocalModel<D>> rows(mesh.elements.size(), model);
    const auto same = must(models_at_vertices(mesh, ball, Column<LocalModel<D>>(rows), {{}, 1e3, 1e9}, one_thread));
    for (const auto& m : same) CHECK(norm(composed(m.logs) - composed(model.logs)) < 1e-9);
    // A single non-zero model in a mesh of zero models is preserved and finite.
    Buffer<LocalModel<D>> one(mesh.elements.size(), zero_model<D>());
    one[5] = model;
    const auto out = must(models_at_vertices(mesh, ball, Column<LocalModel<D>>(one), {{}, 1e3, 1}, one_thread));
    for (const auto& m : out)
        for (const double x : m.logs.values.c) CHECK(std::isfinite(x));
    CHECK(must(optimal_metric(mesh, out, {{}, 1e3, 1}, one_thread)).complexity == doctest::Approx(1e3));
}

/// Two materials with different models: vertices of one material have its model, and interface vertices have no larger
/// size than either.
template <int D>
void check_interface_models() {
    property("sizes at an interface are at most those of either material",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 auto mesh = box_with_facets<D>(4, seed + 1, 0.2);
                 const auto ball = must(balls(mesh, one_thread));
                 const std::array<LocalModel<D>, 2> of{random_model<D>(dice, 3), random_model<D>(dice, 3)};
                 Buffer<LocalModel<D>> rows;
                 Buffer<Reference> references;
                 for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
                     const auto p = corners(mesh, e);
                     Vec<D> middle;
                     for (const auto& corner : p) middle += corner / (D + 1.0);
                     references.push_back(middle[0] < 0.5 ? 1 : 2);
                     rows.push_back(of[references.back() - 1]);
                 }
                 mesh.elements.references = Column<Reference>(Buffer<Reference>(references));
                 const auto out =
                     must(models_at_vertices(mesh, ball, Column<LocalModel<D>>(rows), {{}, 1e3, 1e9}, one_thread));
                 for (std::size_t v = 0; v < out.size(); ++v)
                     for (int m = 0; m < 2; ++m) {
                         const bool touches =
                             std::ranges::any_of(ball[v], [&](ElementId e) { return references[e.index()] == m + 1; });
                         const bool is_only =
                             std::ranges::all_of(ball[v], [&](ElementId e) { return references[e.index()] == m + 1; });
                         if (touches) RC_ASSERT(size_excess(out[v].logs, of[m].logs) < 1e-6);
                         if (is_only) RC_ASSERT(norm(composed(out[v].logs) - composed(of[m].logs)) < 1e-6);
                     }
             },
             {.count = 20});
}

}  // namespace

TEST_CASE("models at an interface have sizes no larger than those of either material") {
    check_interface_models<2>();
    check_interface_models<3>();
}
TEST_CASE("optimal metrics have the optimal exponents, complexity and size limit") {
    check_optimal_metric<2>();
    check_optimal_metric<3>();
}
TEST_CASE("the optimal metric of a function of one variable is that of one dimension") {
    check_one_dimension<2>();
    check_one_dimension<3>();
}
TEST_CASE("optimal metrics rotate and scale with space") {
    check_frames<2>();
    check_frames<3>();
}
TEST_CASE("models at vertices keep the anisotropy of element models with rotating axes") { check_rotating_models(); }

TEST_CASE("models at vertices preserve constant and single element models") {
    check_constant_models<2>();
    check_constant_models<3>();
}
TEST_CASE("optimal_metric rejects a constant field") {
    const auto mesh = box_with_facets<2>(2, 0, 0);
    const auto nothing = models_on(mesh, [](const Vec<2>&) { return zero_model<2>(); });
    const auto constant = optimal_metric(mesh, nothing, {{}, 100, 1}, one_thread);
    REQUIRE(!constant);
    CHECK(constant.error().what.starts_with("the field is constant"));
}

TEST_CASE("optimal_metric accepts a field that is constant in a part of the mesh") {
    const auto mesh = box_with_facets<2>(2, 0, 0);
    const auto some =
        models_on(mesh, [](const Vec<2>& p) { return p[0] > 0.6 ? model_of<2>({{1, 1}}) : zero_model<2>(); });
    CHECK(must(optimal_metric(mesh, some, {{}, 100, 1}, one_thread)).complexity == doctest::Approx(100));
}

TEST_CASE("optimal_metric rejects options out of range and models of another mesh") {
    const auto mesh = box_with_facets<2>(2, 0, 0);
    const auto some =
        models_on(mesh, [](const Vec<2>& p) { return p[0] > 0.6 ? model_of<2>({{1, 1}}) : zero_model<2>(); });
    CHECK(!optimal_metric(mesh, some, {{}, 0.5, 1}, one_thread));
    CHECK(!optimal_metric(mesh, some, {{.p = 0.5}, 100, 1}, one_thread));
    CHECK(!optimal_metric(mesh, some, {{.degree = 3}, 100, 1}, one_thread));
    CHECK(!optimal_metric<2>(mesh, {}, {{}, 100, 1}, one_thread));
}
