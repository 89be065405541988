// Sizes across gaps: slabs, shells, wedges and interfaces.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>

#include "dice.hpp"
#include "layers.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;
import camber.solution_metric;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D, class Place>
LinearMesh<D> placed(LinearMesh<D> mesh, const Place& place) {
    auto points = take(std::move(mesh.points));
    for (Vec<D>& p : points) p = place(p);
    mesh.points = std::move(points);
    return mesh;
}

/// The size of a metric along a direction.
template <int D>
double size_along(const LogMetric<D>& log_metric, const Vec<D>& direction) {
    const Vec<D> u = normalised(direction);
    return 1 / std::sqrt(dot(u, exp(log_metric).m * u));
}

/// A box of thickness `thin` along its last axis and width `side`, rotated and shifted by `far`.
template <int D>
struct Slab {
    double thin = 0.1, side = 1, far = 0;
    std::uint64_t seed = 1;
};
template <int D>
void expect_slab(const Slab<D>& slab) {
    constexpr double elements = 4;
    Dice dice(slab.seed);
    const Mat<D> turn = dice.rotation<D>();
    const auto parameters = box_with_facets<D>(4, slab.seed, 0);
    const auto mesh = placed(parameters, [&](Vec<D> p) {
        p *= slab.side;
        p[D - 1] *= slab.thin / slab.side;
        Vec<D> x = turn * p;
        for (double& c : x.c) c += slab.far;
        return x;
    });
    const double largest = 0.2 * slab.side, blur = 1e-10 + 1e-14 * slab.far / slab.thin;
    const auto metrics = must(gap_metrics(mesh, patches_of(parameters), {elements}, largest, one_thread));
    std::size_t of_walls = 0;
    for (const Vec<D>& p : parameters.points) of_walls += p[D - 1] == 0 || p[D - 1] == 1 ? 1 : 0;
    CHECK(metrics.vertices.size() == of_walls);
    for (std::size_t i = 0; i < metrics.vertices.size(); ++i) {
        const double height = parameters.points[metrics.vertices[i]][D - 1];
        CHECK((height == 0 || height == 1));
        const auto sizes = sorted_sizes<D>(metrics.log_metrics[i]);
        CHECK(sizes[0] == doctest::Approx(slab.thin / elements).epsilon(blur));
        for (int k = 1; k < D; ++k) CHECK(sizes[k] == doctest::Approx(largest));
        CHECK(size_along(metrics.log_metrics[i], turn.column[D - 1]) == doctest::Approx(sizes[0]).epsilon(1e-6));
    }
}
template <int D>
void check_slabs() {
    expect_slab<D>({});
    expect_slab<D>({.thin = 1e-5, .seed = 2});
    expect_slab<D>({.thin = 1e-3, .side = 1e-2, .far = 1e6, .seed = 3});
    expect_slab<D>({.thin = 1e-40, .side = 1e-38, .seed = 4});
}

template <int D>
void check_scaling() {
    property("gap sizes scale with the mesh and do not depend on the number of threads",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto parameters = box_with_facets<D>(D == 2 ? 12 : 6, seed + 1, 0.1);
                 const auto patches = patches_of(box_with_facets<D>(D == 2 ? 12 : 6, seed + 1, 0));
                 const Sym<D> bend = dice.symmetric<D>(0.1);
                 const auto mesh = placed(parameters, [&](Vec<D> p) {
                     p[D - 1] *= 0.1;
                     p[D - 1] += dot(p, bend * p);
                     return p;
                 });
                 const double scale = std::pow(10.0, dice.uniform(-20, 20));
                 const auto one = must(gap_metrics(mesh, patches, {3}, 1, one_thread));
                 RC_ASSERT(one.vertices.size() > 10U);
                 const auto scaled = placed(mesh, [&](const Vec<D>& p) { return scale * p; });
                 const auto other = must(gap_metrics(scaled, patches, {3}, scale, Execution{.threads = 3}));
                 RC_ASSERT(one.vertices == other.vertices);
                 for (std::size_t i = 0; i < one.vertices.size(); ++i) {
                     const auto a = sorted_sizes<D>(one.log_metrics[i]), b = sorted_sizes<D>(other.log_metrics[i]);
                     for (int k = 0; k < D; ++k) RC_ASSERT(std::abs(b[k] / (scale * a[k]) - 1) < 1e-9);
                 }
                 const auto again = must(gap_metrics(mesh, patches, {3}, 1, Execution{.threads = 3}));
                 RC_ASSERT(again.vertices == one.vertices);
                 RC_ASSERT(again.log_metrics == one.log_metrics);
             },
             {.count = 10});
}

/// A part of a shell between two circles or spheres, whose vertices do not face each other.
void check_shells() {
    constexpr double thin = 0.1, elements = 5;
    const auto of = [&](const auto& parameters, const auto& mesh, auto dimension) {
        constexpr int D = decltype(dimension)::value;
        const auto metrics = must(gap_metrics<D>(mesh, patches_of<D>(parameters), {elements}, 0.1, one_thread));
        std::size_t checked = 0;
        for (std::size_t i = 0; i < metrics.vertices.size(); ++i) {
            const Vec<D>& t = parameters.points[metrics.vertices[i]];
            bool is_inner = t[0] == 0 || t[0] == 1;
            for (int k = 1; k < D; ++k) is_inner = is_inner && t[k] > 0.15 && t[k] < 0.85;
            if (!is_inner) continue;
            ++checked;
            const double size = size_along(metrics.log_metrics[i], mesh.points[metrics.vertices[i]]);
            CHECK(size == doctest::Approx(thin / elements).epsilon(0.03));
        }
        CHECK(checked > 10);
    };
    const auto square = box_with_facets<2>(24, 0, 0);
    of(square,
       placed(square,
              [](const Vec<2>& t) {
                  const double angle = 1.2 * t[1] + 0.03 * t[0];
                  return (1 + thin * t[0]) * Vec<2>{{std::cos(angle), std::sin(angle)}};
              }),
       std::integral_constant<int, 2>{});
    const auto cube = box_with_facets<3>(12, 0, 0);
    of(cube,
       placed(cube,
              [](const Vec<3>& t) {
                  const double a = 1.2 * (t[1] - 0.5) + 0.05 * t[0], b = 1.2 * (t[2] - 0.5) + 0.03 * t[0];
                  return (1 + thin * t[0]) * normalised(Vec<3>{{1, std::tan(a), std::tan(b)}});
              }),
       std::integral_constant<int, 3>{});
}

/// A triangle of n cells with angle α at the origin, between the axis and an upper wall. The first n + 1 vertices are
/// on the axis. Patches: axis, upper wall, end. Another body lies above the tip.
struct Wedge {
    LinearMesh<2> mesh;
    Column<std::uint32_t> patches;
};
Wedge wedge(double degrees, std::size_t n) {
    const double slope = std::tan(degrees * std::numbers::pi / 180);
    Buffer<Vec<2>> points;
    for (std::size_t i = 0; i <= n; ++i) points.push_back({{static_cast<double>(i) / static_cast<double>(n), 0}});
    for (std::size_t i = 1; i <= n; ++i) points.push_back({{points[i][0], slope * points[i][0]}});
    for (const Vec<2>& p : {Vec<2>{{-1, 0.2}}, Vec<2>{{0.1, 0.2}}, Vec<2>{{0, 2}}}) points.push_back(p);
    const auto below = [](std::size_t i) { return VertexId(i); };
    const auto above = [n](std::size_t i) { return VertexId(i == 0 ? 0 : n + i); };
    Buffer<SimplexVertices<2>> elements{{below(0), below(1), above(1)}, {above(n + 1), above(n + 2), above(n + 3)}};
    Buffer<SimplexVertices<1>> facets{
        {below(n), above(n)}, {above(n + 1), above(n + 2)}, {above(n + 2), above(n + 3)}, {above(n + 3), above(n + 1)}};
    Buffer<std::uint32_t> patches{2, 3, 4, 5};
    for (std::size_t i = 0; i < n; ++i) {
        facets.push_back({below(i), below(i + 1)});
        patches.push_back(0);
        facets.push_back({above(i), above(i + 1)});
        patches.push_back(1);
        if (i == 0) continue;
        elements.push_back({below(i), below(i + 1), above(i + 1)});
        elements.push_back({below(i), above(i + 1), above(i)});
    }
    Wedge out{mesh_of<2>(std::move(points), std::move(elements)), std::move(patches)};
    out.mesh.facets.references = Buffer<Reference>(facets.size(), 1);
    out.mesh.facets.vertices = std::move(facets);
    return out;
}

void check_wedges() {
    constexpr std::size_t n = 8;
    constexpr double elements = 3, largest = 0.3;
    for (const double degrees : {10.0, 30.0, 60.0}) {
        const auto [mesh, patches] = wedge(degrees, n);
        const auto metrics = must(gap_metrics(mesh, patches, {elements}, largest, one_thread));
        const double slope = std::tan(degrees * std::numbers::pi / 180), cosine = 1 / std::hypot(1, slope);
        // The thickness to the other wall or, from the upper wall, to the end. Walls face each other up to 45 degrees.
        Buffer<double> thickness(2 * n, 0);
        for (std::size_t v = 1; v < 2 * n; ++v) {
            const double x = mesh.points[VertexId(v)][0];
            const bool is_to_end = v > n && x > cosine * cosine;
            if (is_to_end ? degrees > 45 : degrees < 45)
                thickness[v] = is_to_end ? (1 - x) / (slope * cosine) : v < n ? slope * x : slope * x / cosine;
        }
        thickness[n] = 0;
        std::size_t checked = 0;
        for (std::size_t i = 0; i < metrics.vertices.size(); ++i) {
            const std::size_t v = metrics.vertices[i].index();
            // Rays from the tip leave the domain. Corners and the other body have no gap.
            CHECK(v > 0);
            if (v == n || v >= 2 * n) continue;
            ++checked;
            const Vec<2> normal = v < n ? Vec<2>{{0, 1}} : Vec<2>{{-slope, 1}};
            CHECK(size_along(metrics.log_metrics[i], normal) == doctest::Approx(thickness[v] / elements));
        }
        const auto is_thin = [&](double t) { return t > 0 && t < elements * largest; };
        CHECK(checked == static_cast<std::size_t>(std::ranges::count_if(thickness, is_thin)));
    }
}

/// Two layers with a wall between them, of the same material or not.
template <int D>
void check_layers(Reference upper) {
    constexpr double wall = 0.25, thin = 0.1, elements = 2;
    auto parameters = box_with_facets<D>(4, 0, 0);
    const auto outer = patches_of(parameters);
    Buffer<std::uint32_t> patches(outer.begin(), outer.end());
    auto facets = take(std::move(parameters.facets.vertices));
    auto references = take(std::move(parameters.elements.references));
    for (std::size_t e = 0; e < parameters.elements.size(); ++e) {
        const auto& corners = parameters.elements.vertices[e];
        const bool is_above =
            std::ranges::any_of(corners, [&](VertexId v) { return parameters.points[v][D - 1] > wall; });
        references[e] = is_above ? upper : 1;
        if (is_above) continue;
        for (int k = 0; k <= D; ++k) {
            const auto face = face_of(parameters, {ElementId(e), static_cast<std::uint32_t>(k)});
            if (!std::ranges::all_of(face, [&](VertexId v) { return parameters.points[v][D - 1] == wall; })) continue;
            facets.push_back(face);
            patches.push_back(2 * D);
        }
    }
    parameters.elements.references = std::move(references);
    parameters.facets.references = Buffer<Reference>(facets.size(), 1);
    parameters.facets.vertices = std::move(facets);
    const auto mesh = placed(parameters, [&](Vec<D> p) {
        p[D - 1] *= thin;
        return p;
    });
    const auto metrics = must(gap_metrics<D>(mesh, std::move(patches), {elements}, 0.2, one_thread));
    std::size_t checked = 0;
    Vec<D> up;
    up[D - 1] = 1;
    for (std::size_t i = 0; i < metrics.vertices.size(); ++i) {
        const double height = parameters.points[metrics.vertices[i]][D - 1];
        const double thickness = height == 1 ? (1 - wall) * thin : wall * thin;
        CHECK((height == 0 || height == wall || height == 1));
        CHECK(size_along(metrics.log_metrics[i], up) == doctest::Approx(thickness / elements));
        ++checked;
    }
    CHECK(checked == 3 * (D == 2 ? 5 : 25));  // the vertices of three walls
}

/// A plate in a box, cut open along the plate: each side has its own vertices at the same positions.
void check_crack() {
    constexpr double thin = 0.1, elements = 2;
    LatticeOptions<2> options;
    options.cells = {4, 2};
    auto mesh = lattice_mesh(options);
    auto points = take(std::move(mesh.points));
    for (Vec<2>& p : points) p = {{p[0] / 4, thin * p[1] / 2}};
    const auto is_middle = [&](VertexId v) { return points[v.index()][1] == thin / 2; };
    const std::size_t before = points.size();
    Buffer<SimplexVertices<1>> facets;
    Buffer<std::uint32_t> patches;
    std::vector<VertexId> copies(before);
    for (std::size_t v = 0; v < before; ++v) {
        if (!is_middle(VertexId(v))) continue;
        copies[v] = VertexId(points.size());
        const Vec<2> p = points[v];
        points.push_back(p);
    }
    auto elements_of = take(std::move(mesh.elements.vertices));
    for (auto& element : elements_of) {
        const bool is_above =
            std::ranges::any_of(element, [&](VertexId v) { return points[v.index()][1] > 0.75 * thin; });
        if (is_above)
            for (VertexId& v : element)
                if (is_middle(v)) v = copies[v.index()];
        for (int k = 0; k < 3; ++k) {
            const VertexId a = element[k], b = element[(k + 1) % 3];
            if (points[a.index()][1] != points[b.index()][1]) continue;
            facets.push_back({a, b});
            patches.push_back(points[a.index()][1] == thin / 2 && is_above
                                  ? 9
                                  : static_cast<std::uint32_t>(2 * points[a.index()][1] / thin));
        }
    }
    mesh.points = std::move(points);
    mesh.elements.vertices = std::move(elements_of);
    mesh.facets.references = Buffer<Reference>(facets.size(), 1);
    mesh.facets.vertices = std::move(facets);
    const auto metrics = must(gap_metrics<2>(mesh, std::move(patches), {elements}, 0.2, one_thread));
    CHECK(metrics.vertices.size() == 20);  // five vertices on each of four sides
    for (const auto& m : metrics.log_metrics)
        CHECK(size_along(m, Vec<2>{{0, 1}}) == doctest::Approx(thin / 2 / elements));
}

template <int D>
void check_errors() {
    const auto mesh = box_with_facets<D>(2, 0, 0);
    const auto patches = patches_of(mesh);
    for (const double elements : {0.0, -1.0, std::nan("")}) {
        const auto bad = gap_metrics(mesh, patches, {elements}, 1, one_thread);
        REQUIRE(!bad);
        CHECK(bad.error().kind == ErrorKind::usage);
    }
    CHECK(!gap_metrics(mesh, patches, {2}, 0, one_thread));
    CHECK(!gap_metrics(mesh, patches, {2}, std::nan(""), one_thread));
    CHECK(!gap_metrics<D>(mesh, {}, {2}, 1, one_thread));
    CHECK(gap_metrics(mesh, patches, {2}, 1, one_thread).has_value());
    // Without facets there are no gaps.
    auto bare = mesh;
    bare.facets = {};
    CHECK(must(gap_metrics<D>(bare, {}, {2}, 1, one_thread)).vertices.empty());
}

}  // namespace

TEST_CASE("gap sizes of slabs divide the thickness by the number of elements") {
    check_slabs<2>();
    check_slabs<3>();
}
TEST_CASE("gap sizes scale with the mesh for any number of threads") {
    check_scaling<2>();
    check_scaling<3>();
}
TEST_CASE("gap sizes of shells divide the thickness by the number of elements") { check_shells(); }
TEST_CASE("gap sizes of wedges follow the local thickness") { check_wedges(); }
TEST_CASE("gap sizes at an interface are those of the thinner side") {
    for (const Reference upper : {1, 2}) {
        check_layers<2>(upper);
        check_layers<3>(upper);
    }
}
TEST_CASE("gap sizes beside a crack are those of each side") { check_crack(); }
TEST_CASE("gap_metrics rejects invalid options and accepts a mesh without facets") {
    check_errors<2>();
    check_errors<3>();
}
