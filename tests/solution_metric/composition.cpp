// Composition reaches the target complexity with fixed metrics and gradation, and each step keeps its limits.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
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

/// A layer of width 0.05 across an axis, with a model that is 1e-4 along the others.
template <int D>
Column<LocalModel<D>> layer(const LinearMesh<D>& mesh, int axis, double at) {
    return models_on(mesh, [=](const Vec<D>& p) {
        Vec<D> q;
        for (double& x : q.c) x = 1e-4;
        q[axis] = std::exp(-std::abs(p[axis] - at) / 0.05) + 1e-4;
        return model_of(q);
    });
}

template <int D>
struct Case {
    LinearMesh<D> mesh = box_with_facets<D>(D == 2 ? 12 : 6, 3, 0.2);
    EdgeSet<D> edges = must(unique_edges(mesh, one_thread));

    [[nodiscard]] SolutionMetric<D> metric(std::span<const SolutionField<D>> fields, const Column<LogMetric<D>>& fixed,
                                           const SolutionMetricOptions& options, int threads = 1) const {
        return must(make_solution_metric<D>(mesh, edges, fields, fixed, options, Execution{.threads = threads}));
    }
};

template <int D>
void check_complexity() {
    const Case<D> c;
    const std::array fields{SolutionField<D>{layer(c.mesh, 0, 0.3)},
                            SolutionField<D>{layer(c.mesh, 1, 0.6), {.degree = 1, .p = 0}, 0.5}};
    const std::array small{ReferenceSize{.references = {2}, .size = 0.05}};
    const std::array some{must(sizes_by_reference<D>(c.mesh, small))};
    const auto fixed = must(fixed_metric<D>(c.mesh, some, {}, 2, one_thread));
    const std::array cases{
        SolutionMetricOptions{},
        SolutionMetricOptions{.min_size = 0.004, .max_size = 0.3, .max_anisotropy = 20},
        SolutionMetricOptions{.max_size = 0.3, .gradation = GradationOptions{.ratio = 1.8}},
    };
    for (SolutionMetricOptions o : cases)
        for (const std::size_t count : {1, 2}) {
            o.amount = 2e4;
            const auto out = c.metric(std::span(fields).first(count), fixed, o);
            CHECK(out.is_reached);
            CHECK(out.reached == doctest::Approx(o.amount).epsilon(1e-3));
            CHECK(out.reached == doctest::Approx(must(complexity(c.mesh, out.log_metrics, one_thread))));
            CHECK(out.fixed_complexity < out.reached);
            CHECK(out.gradations <= (o.gradation ? 7 : 0));
            for (std::size_t v = 0; v < fixed.size(); ++v) {
                // Fixed metrics are preserved unless a bound is larger.
                if (o.min_size == 0) CHECK(size_excess(out.log_metrics[v], fixed[v]) < 1e-6);
                const auto values = eigen_system(out.log_metrics[v].l).values.c;
                const auto [low, high] = std::minmax_element(values.begin(), values.end());
                if (o.min_size > 0) CHECK(std::exp(-*high / 2) > o.min_size * (1 - 1e-9));
                if (o.max_size > 0) CHECK(std::exp(-*low / 2) < o.max_size * (1 + 1e-9));
                if (o.max_anisotropy > 0) CHECK(std::exp((*high - *low) / 2) < o.max_anisotropy * (1 + 1e-9));
            }
            if (o.gradation)
                CHECK(must(gradation_excess(c.mesh, c.edges, out.log_metrics, *o.gradation, one_thread)) < 1e-5);
            const auto threaded = c.metric(std::span(fields).first(count), fixed, o, 3);
            CHECK(threaded.log_metrics == out.log_metrics);
        }
}

template <int D>
void check_single_field() {
    // Without other conditions the result is the optimal metric. A larger complexity gives smaller sizes everywhere.
    const Case<D> c;
    const std::array field{SolutionField<D>{layer(c.mesh, 0, 0.3), {.degree = 2, .p = 3}}};
    SolutionMetricOptions o{.amount = 5e3, .max_size = 0.5, .tolerance = 1e-5};
    const auto out = c.metric(field, {}, o);
    const auto optimal = must(optimal_metric(c.mesh, field[0].models, {field[0].norm, 5e3, 0.5}, one_thread));
    for (std::size_t v = 0; v < out.log_metrics.size(); ++v)
        CHECK(norm(out.log_metrics[v].l - optimal.log_metrics[v].l) < 1e-9);
    o.amount = 8e3;
    const auto finer = c.metric(field, {}, o);
    for (std::size_t v = 0; v < out.log_metrics.size(); ++v)
        CHECK(size_excess(finer.log_metrics[v], out.log_metrics[v]) < 1e-9);
    CHECK(out.at_min == 0);
    CHECK(finer.at_max <= out.at_max);
}

template <int D>
void check_field_order() {
    const Case<D> c;
    const SolutionField<D> a{layer(c.mesh, 0, 0.3)}, b{layer(c.mesh, 1, 0.6)};
    const SolutionMetricOptions o{.amount = 1e4, .max_size = 0.5, .tolerance = 1e-7, .max_evaluations = 40};
    const auto ab = c.metric(std::array{a, b}, {}, o), ba = c.metric(std::array{b, a}, {}, o);
    for (std::size_t v = 0; v < ab.log_metrics.size(); ++v)
        CHECK(norm(ab.log_metrics[v].l - ba.log_metrics[v].l) < 1e-5);
    // The unit of one field has no effect.
    Buffer<LocalModel<D>> large(a.models.begin(), a.models.end());
    for (auto& m : large)
        for (double& x : m.logs.values.c) x += 300;
    const auto other = c.metric(std::array{SolutionField<D>{std::move(large)}, b}, {}, o);
    for (std::size_t v = 0; v < ab.log_metrics.size(); ++v)
        CHECK(norm(ab.log_metrics[v].l - other.log_metrics[v].l) < 1e-4);
}

template <int D>
void check_dominant_fixed_metric() {
    const Case<D> c;
    const std::array field{SolutionField<D>{layer(c.mesh, 0, 0.3)}};
    const std::array small{ReferenceSize{.references = {1}, .size = 0.02, .of = ReferencedEntity::elements}};
    const std::array some{must(sizes_by_reference<D>(c.mesh, small))};
    const auto fixed = must(fixed_metric<D>(c.mesh, some, {}, 2, one_thread));
    const auto out = c.metric(field, fixed, {.amount = 1000, .max_size = 1});
    CHECK(out.is_fixed_sufficient);
    CHECK(!out.is_reached);
    CHECK(out.reached == out.fixed_complexity);
    CHECK(out.reached > 1000);
    for (std::size_t v = 0; v < fixed.size(); ++v) CHECK(norm(out.log_metrics[v].l - fixed[v].l) < 1e-9);
}

template <int D>
void check_errors() {
    const Case<D> c;
    const std::array good{SolutionField<D>{layer(c.mesh, 0, 0.3)}};
    const auto error_of = [&](std::span<const SolutionField<D>> fields, const SolutionMetricOptions& o) {
        const auto out = make_solution_metric<D>(c.mesh, c.edges, fields, {}, o, one_thread);
        REQUIRE(!out);
        return describe(out.error());
    };
    CHECK(error_of({}, {.amount = 100}).find("no field") != std::string::npos);
    CHECK(error_of(good, {}).find("amount") != std::string::npos);
    CHECK(error_of(good, {.amount = 100, .min_size = 2, .max_size = 1}).find("max_size") != std::string::npos);
    const std::array constant{good[0],
                              SolutionField<D>{models_on(c.mesh, [](const Vec<D>&) { return zero_model<D>(); })}};
    CHECK(error_of(constant, {.amount = 1e4}).starts_with("field 2: the field is constant"));
    const std::array no_share{SolutionField<D>{good[0].models, {}, 0}};
    CHECK(error_of(no_share, {.amount = 1e4}).find("share") != std::string::npos);
    const std::array other_mesh{SolutionField<D>{}};
    CHECK(error_of(other_mesh, {.amount = 1e4}).find("another mesh") != std::string::npos);
    CHECK(!make_solution_metric<D>(LinearMesh<D>{}, {}, good, {}, {.amount = 10}, one_thread));
}

}  // namespace

TEST_CASE("the composed metric reaches the target complexity with fixed metrics, bounds and gradation") {
    check_complexity<2>();
    check_complexity<3>();
}
TEST_CASE("a single field gets its optimal metric") {
    check_single_field<2>();
    check_single_field<3>();
}
TEST_CASE("the composition does not depend on the order or units of the fields") {
    check_field_order<2>();
    check_field_order<3>();
}
TEST_CASE("a fixed metric above the target complexity is returned alone") {
    check_dominant_fixed_metric<2>();
    check_dominant_fixed_metric<3>();
}
TEST_CASE("complexity_of converts numbers of vertices and elements") {
    CHECK(complexity_of<2>(100, TargetQuantity::complexity) == 100);
    CHECK(complexity_of<2>(2600, TargetQuantity::elements) ==
          doctest::Approx(1000));  // 2.6 triangles per unit of complexity
    CHECK(complexity_of<2>(1300, TargetQuantity::vertices) == doctest::Approx(1000));   // 1.3 vertices
    CHECK(complexity_of<3>(12500, TargetQuantity::elements) == doctest::Approx(1000));  // 12.5 tetrahedra
}
TEST_CASE("composition rejects invalid fields and options") {
    check_errors<2>();
    check_errors<3>();
}
