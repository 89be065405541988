// The natural metric of simplices and meshes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <rapidcheck.h>

#include "back.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
std::array<Vec<D>, D + 1> stretched_simplex(Dice& dice, const Vec<D>& stretch) {
    const auto r = dice.rotation<D>();
    std::array<Vec<D>, D + 1> p{};
    const auto regular = regular_simplex<D>();
    const auto turn = dice.rotation<D>();
    const auto origin = dice.vector<D>();
    for (int i = 0; i <= D; ++i) {
        Vec<D> x = turn * ((i == 0 ? Vec<D>{} : regular.column[i - 1]) + 0.1 * dice.vector<D>());
        for (int k = 0; k < D; ++k) x[k] *= stretch[k];
        p[i] = r * x + origin;
    }
    return p;
}

template <int D>
double largest_edge_error(const LogMetric<D>& l, const std::array<Vec<D>, D + 1>& p) {
    const SpectralMetric<D> m(l);
    double worst = 0;
    for (int i = 0; i <= D; ++i)
        for (int j = 0; j < i; ++j) worst = std::max(worst, std::abs(m.length_squared(p[i] - p[j]) - 1));
    return worst;
}

/// The error bound is that of a rounded short side relative to a long one.
template <int D>
void check_unit_edges(const Vec<D>& stretch, double aspect) {
    property("natural edges have length 1 for any order of the vertices", [&](std::uint64_t seed) {
        Dice dice(seed);
        auto p = stretched_simplex<D>(dice, stretch);
        const auto l = natural_log_metric<D>(p);
        RC_ASSERT(largest_edge_error(l, p) < 1e-13 + 3e-14 * aspect);
        const std::size_t i = dice.below(D + 1), j = dice.below(D + 1);
        std::swap(p[i], p[j]);
        RC_ASSERT(norm(natural_log_metric<D>(p).l - l.l) < 1e-12 + 3e-14 * aspect);
    });
}

}  // namespace

TEST_CASE("the regular simplex has edges of length 1") {
    const auto r = regular_simplex<3>();
    for (int i = 0; i < 3; ++i) {
        CHECK(norm(r.column[i]) == doctest::Approx(1).epsilon(1e-15));
        for (int j = 0; j < i; ++j) CHECK(norm(r.column[i] - r.column[j]) == doctest::Approx(1).epsilon(1e-15));
    }
}

TEST_CASE("natural metrics give simplices edges of length 1 up to anisotropy 10^6") {
    check_unit_edges<2>(Vec<2>{{1, 1}}, 1);
    check_unit_edges<2>(Vec<2>{{1, 1e-6}}, 1e6);
    check_unit_edges<3>(Vec<3>{{1, 1, 1}}, 1);
    check_unit_edges<3>(Vec<3>{{1, 1, 1e-6}}, 1e6);
    check_unit_edges<3>(Vec<3>{{1, 1e-6, 1e-6}}, 1e6);
    check_unit_edges<3>(Vec<3>{{1, 1e-3, 1e-6}}, 1e6);
}

TEST_CASE("natural metrics at vertices are the volume-weighted log-Euclidean mean") {
    property("vertex metrics equal those of a plain loop",
             [](std::uint64_t seed) {
                 const auto mesh = unit_box<3>(3, seed + 1);
                 const auto around = *balls(mesh, one_thread);
                 const auto logs = *natural_log_metrics(mesh, around, one_thread);
                 for (std::size_t v = 0; v < mesh.points.size(); ++v) {
                     Sym<3> sum;
                     double weight = 0;
                     for (const ElementId e : around[v]) {
                         const auto p = corners(mesh, e.index());
                         sum += orientation(p) * natural_log_metric<3>(p).l;
                         weight += orientation(p);
                     }
                     RC_ASSERT(norm(logs[v].l - (1 / weight) * sum) < 1e-12);
                 }
                 for (const int threads : {2, 7})
                     RC_ASSERT(*natural_log_metrics(mesh, around, Execution{.threads = threads}) == logs);
             },
             {.count = 10});
    property("vertex metrics of a mesh of several batches equal those of a plain loop",
             [](std::uint64_t seed) {
                 const auto mesh = unit_box<2>(80, seed + 1);
                 const auto around = *balls(mesh, one_thread);
                 const auto logs = *natural_log_metrics(mesh, around, one_thread);
                 for (std::size_t v = 0; v < mesh.points.size(); ++v) {
                     Sym<2> sum;
                     double weight = 0;
                     for (const ElementId e : around[v]) {
                         const auto p = corners(mesh, e.index());
                         sum += orientation(p) * natural_log_metric<2>(p).l;
                         weight += orientation(p);
                     }
                     RC_ASSERT(norm(logs[v].l - (1 / weight) * sum) < 1e-12);
                 }
                 RC_ASSERT(*natural_log_metrics(mesh, around, Execution{.threads = 3}) == logs);
             },
             {.count = 2});
    property("the metric of an affine image of equilateral triangles is constant", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto shape = dice.matrix<2>();
        RC_PRE(std::abs(det(shape)) > 0.01);
        LatticeOptions<2> options{.cells = {5, 5}};
        // Kuhn's triangles have their diagonal along (1, 1): the frame (1, 0), (−1/2, √3/2) makes it as long as the
        // sides.
        options.place = [&](const Vec<2>& x) { return shape * Vec<2>{{x[0] - 0.5 * x[1], std::sqrt(0.75) * x[1]}}; };
        const auto mesh = lattice_mesh(options);
        const auto logs = *natural_log_metrics(mesh, *balls(mesh, one_thread), one_thread);
        for (const auto& l : logs) RC_ASSERT(norm(l.l - logs[0].l) < 1e-11);
        RC_ASSERT(std::abs(SpectralMetric<2>(logs[0]).length_squared(shape.column[0]) - 1) < 1e-11);
    });
}

namespace {

/// The corners of an element by the edge tangents at corner v; the straight corners if that would flatten it.
template <int D>
std::array<Vec<D>, D + 1> by_tangents(const QuadraticMesh<D>& mesh, std::size_t e, int v) {
    const auto p = corners(mesh.linear, e);
    auto bent = p;
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        if (i != v && j != v) continue;
        const auto& node = mesh.mid_nodes[mesh.edges.of_elements[ElementId(e)][k]];
        bent[i == v ? j : i] += 4 * (node.point - midpoint(p[i], p[j]));
    }
    return orientation(bent) / orientation(p) > 0.05 ? bent : p;
}

template <int D>
void check_curved() {
    property("vertex metrics of curved elements are the mean over their tangent simplices",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 auto box = unit_box<D>(3, seed + 1);
                 auto points = take(std::move(box.points));
                 for (Vec<D>& p : points) p[0] *= 1e-3;
                 box.points = std::move(points);
                 auto mesh = must(elevate(std::move(box), one_thread));
                 auto nodes = take(std::move(mesh.mid_nodes));
                 for (std::size_t e = 0; e < nodes.size(); ++e) {
                     if (e % 3 == 0) continue;
                     Vec<D> u = dice.vector<D>(-0.05, 0.05);
                     u[0] *= 1e-3;
                     nodes[e].point += u;
                 }
                 mesh.mid_nodes = std::move(nodes);
                 const auto around = must(balls(mesh.linear, one_thread));
                 const auto logs = must(curved_natural_log_metrics(mesh, around, one_thread));
                 const auto straight = must(natural_log_metrics(mesh.linear, around, one_thread));
                 for (std::size_t v = 0; v < straight.size(); ++v) {
                     Sym<D> sum;
                     double weight = 0;
                     for (const ElementId e : around[v]) {
                         const auto& of = mesh.linear.elements.vertices[e];
                         const auto corner = std::find(of.begin(), of.end(), VertexId(v)) - of.begin();
                         const double volume = orientation(corners(mesh.linear, e.index()));
                         sum +=
                             volume * natural_log_metric<D>(by_tangents(mesh, e.index(), static_cast<int>(corner))).l;
                         weight += volume;
                     }
                     RC_ASSERT(norm(logs.curved[v].l - (1 / weight) * sum) < 1e-9);
                     RC_ASSERT(norm(logs.straight[v].l - straight[v].l) < 1e-12);
                 }
                 const auto threaded = must(curved_natural_log_metrics(mesh, around, Execution{.threads = 3}));
                 RC_ASSERT(threaded.curved == logs.curved);
                 RC_ASSERT(threaded.straight == logs.straight);
             },
             {.count = 20});
}

}  // namespace

TEST_CASE("natural metrics of curved elements use the edge tangents in 2D") { check_curved<2>(); }
TEST_CASE("natural metrics of curved elements use the edge tangents in 3D") { check_curved<3>(); }

TEST_CASE("natural metrics are the identity at unused vertices and skip flat elements") {
    auto mesh = unit_box<2>(2, 1);
    auto points = take(mesh.points);
    points.push_back({{5, 5}});
    mesh.points = points;
    CHECK(must(natural_log_metrics(mesh, must(balls(mesh, one_thread)), one_thread)).back().l == Sym<2>{});

    const auto rest = mesh;
    auto elements = take(mesh.elements.vertices);
    elements.push_back({elements[0][0], elements[0][1], elements[0][0]});
    mesh.elements.vertices = elements;
    const auto logs = must(natural_log_metrics(mesh, must(balls(mesh, one_thread)), one_thread));
    CHECK(logs == must(natural_log_metrics(rest, must(balls(rest, one_thread)), one_thread)));
}
