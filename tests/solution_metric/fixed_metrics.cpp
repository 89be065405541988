// Fixed metrics: sizes by reference, and chord sizes on geometries of known curvature.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

#include "dice.hpp"
#include "layers.hpp"
#include "property.hpp"
#include "restarts.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.solution_metric;

using namespace camber;
using namespace camber::testing;

namespace {

/// A part of a ring (in 3D of a pipe along z) around the origin, as a map of the unit box. The first coordinate is the
/// radius minus 1.
template <int D>
Vec<D> pipe(const Vec<D>& t) {
    const double r = 1 + t[0], a = 1.2 * t[1];
    Vec<D> p = t;
    p[0] = r * std::cos(a);
    p[1] = r * std::sin(a);
    return p;
}
Vec<3> ball(const Vec<3>& t) {
    return (1 + t[0]) * normalised(Vec<3>{{1, std::tan(1.2 * (t[1] - 0.5)), std::tan(1.2 * (t[2] - 0.5))}});
}

/// Checks sizes[i] at vertices inside the side with coordinate x, with the relative tolerance `within`.
template <int D, class Expected>
void expect_sizes(const MetricsAtVertices<D>& metrics, const LinearMesh<D>& parameters, double x,
                  const Expected& expected, double within) {
    std::size_t checked = 0;
    for (std::size_t i = 0; i < metrics.vertices.size(); ++i) {
        const Vec<D>& t = parameters.points[metrics.vertices[i]];
        bool inside = t[0] == x;
        for (int k = 1; k < D; ++k) inside = inside && t[k] > 0 && t[k] < 1;
        if (!inside) continue;
        ++checked;
        const auto sizes = sorted_sizes<D>(metrics.log_metrics[i]);
        for (int k = 0; k < D; ++k) CHECK(sizes[k] == doctest::Approx(expected[k]).epsilon(within));
    }
    CHECK(checked > 3);
}

template <int D>
void check_pipes() {
    const auto parameters = box_with_facets<D>(D == 2 ? 24 : 10, 0, 0);
    const auto curved = mapped(parameters, pipe<D>);
    auto straight = curved.linear;
    const auto patches = patches_of(parameters);
    const double delta = 1e-3, largest = 0.5;
    const ChordOptions options{.chord_error = delta, .normal_ratio = 3};
    for (const double r : {1.0, 2.0}) {
        const double size = std::sqrt(8 * delta * r);  // a chord h has the sagitta h²/(8 r)
        std::array<double, D> expected{};
        expected.fill(largest);
        expected[0] = size;
        expected[1] = std::min(largest, 3 * size);  // along the normal
        const auto of_nodes = must(chord_metrics(curved, patches, options, largest, one_thread));
        const auto of_chords = must(chord_metrics(straight, patches, options, largest, one_thread));
        expect_sizes(of_nodes, parameters, r - 1, expected, 0.02);
        expect_sizes(of_chords, parameters, r - 1, expected, 0.02);
        CHECK(must(chord_metrics(straight, patches, options, largest, Execution{.threads = 3})).log_metrics ==
              of_chords.log_metrics);
        // Curvature is one-sided: the ends of the arc have the same size, and the flat sides add nothing.
        std::size_t corners = 0;
        for (std::size_t i = 0; i < of_chords.vertices.size(); ++i) {
            const Vec<D>& t = parameters.points[of_chords.vertices[i]];
            if (t[0] != r - 1 || (t[1] != 0 && t[1] != 1)) continue;
            ++corners;
            CHECK(sorted_sizes<D>(of_chords.log_metrics[i])[0] == doctest::Approx(size).epsilon(0.05));
            CHECK(sorted_sizes<D>(of_nodes.log_metrics[i])[0] == doctest::Approx(size).epsilon(0.05));
        }
        CHECK(corners >= 2);
    }
}

void check_balls() {
    const auto parameters = box_with_facets<3>(10, 0, 0);
    const auto curved = mapped(parameters, ball);
    const auto patches = patches_of(parameters);
    const ChordOptions options{.chord_error = 1e-3, .normal_ratio = 2};
    for (const double r : {1.0, 2.0}) {
        const double size = std::sqrt(8e-3 * r);
        const std::array expected{size, size, 2 * size};
        expect_sizes(must(chord_metrics(curved, patches, options, 1, one_thread)), parameters, r - 1, expected, 0.03);
        expect_sizes(must(chord_metrics(curved.linear, patches, options, 1, one_thread)), parameters, r - 1, expected,
                     0.03);
    }
}

template <int D>
void check_reference_sizes() {
    const auto mesh = box_with_facets<D>(4, 0, 0);
    const std::array requested{ReferenceSize{{1}, 0.1}, ReferenceSize{{1}, 0.5, ReferencedEntity::elements},
                               ReferenceSize{{2}, 0.2}};
    const auto metrics = must(sizes_by_reference<D>(mesh, requested));
    CHECK(metrics.vertices.size() == mesh.points.size());
    for (std::size_t i = 0; i < metrics.vertices.size(); ++i) {
        const Vec<D>& p = mesh.points[metrics.vertices[i]];
        const double size = p[0] == 0 || p[0] == 1 ? 0.1 : p[1] == 0 || p[1] == 1 ? 0.2 : 0.5;
        for (const double h : sorted_sizes<D>(metrics.log_metrics[i])) CHECK(h == doctest::Approx(size));
    }
    const std::array nothing{ReferenceSize{{1, 77}, 0.1}};
    const auto typo = sizes_by_reference<D>(mesh, nothing);
    REQUIRE(!typo);
    CHECK(typo.error().what.find("77") != std::string::npos);
    CHECK(!sizes_by_reference<D>(mesh, std::array{ReferenceSize{{1}, 0}}));
    CHECK(must(sizes_by_reference<D>(mesh, {})).vertices.empty());
}

template <int D>
void check_joined() {
    property("the fixed metric is at least as fine as each of its parts",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto mesh = box_with_facets<D>(2, 0, 0);
                 const auto random = [&] {
                     Buffer<LogMetric<D>> rows;
                     for (std::size_t v = 0; v < mesh.points.size(); ++v) rows.push_back({dice.symmetric<D>(2)});
                     return Column<LogMetric<D>>(std::move(rows));
                 };
                 const auto a = random(), b = random();
                 Buffer<VertexId> all;
                 for (std::size_t v = 0; v < mesh.points.size(); ++v) all.push_back(VertexId(v));
                 const std::array some{MetricsAtVertices<D>{all, a}};
                 const auto one = must(fixed_metric<D>(mesh, some, std::array{b}, 3, one_thread));
                 for (std::size_t v = 0; v < one.size(); ++v) {
                     RC_ASSERT(size_excess(one[v], a[v]) < 1e-9);
                     RC_ASSERT(size_excess(one[v], b[v]) < 1e-9);
                     for (const double x : eigen_system(one[v].l).values.c)
                         RC_ASSERT(std::exp(-x / 2) < 3 * (1 + 1e-9));
                 }
             },
             {.count = 20});
    const auto mesh = box_with_facets<D>(2, 0, 0);
    CHECK(!fixed_metric<D>(mesh, {}, std::array{Column<LogMetric<D>>{Buffer<LogMetric<D>>(1, LogMetric<D>{})}}, 1,
                           one_thread));
    CHECK(!fixed_metric<D>(mesh, {}, {}, 0, one_thread));
    CHECK(!chord_metrics<D>(mesh, {}, {.chord_error = 1}, 1, one_thread));
    CHECK(!chord_metrics<D>(mesh, patches_of(mesh), {}, 1, one_thread));
}

}  // namespace

TEST_CASE("chord sizes of circles and pipes match their curvature") {
    check_pipes<2>();
    check_pipes<3>();
}
TEST_CASE("chord sizes of balls match their curvature") { check_balls(); }
TEST_CASE("sizes by reference apply the smallest size of each vertex") {
    check_reference_sizes<2>();
    check_reference_sizes<3>();
}
TEST_CASE("the fixed metric satisfies all of its parts") {
    check_joined<2>();
    check_joined<3>();
}
