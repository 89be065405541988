// Location in back meshes, compared with a search over all elements and boundary faces.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "back.hpp"
#include "property.hpp"

import camber.core;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
KnownBack<D> plain_back(const LinearMesh<D>& mesh) {
    return back_of(mesh, [](const Vec<D>&) { return LogMetric<D>{}; });
}

/// The maximum over the elements of the smallest barycentric coordinate of x; positive exactly inside the mesh.
template <int D>
double depth(const LinearMesh<D>& mesh, const Vec<D>& x) {
    double best = -1e300;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        const auto p = corners(mesh, e);
        double lowest = 1e300;
        for (int i = 0; i <= D; ++i) {
            auto moved = p;
            moved[i] = x;
            lowest = std::min(lowest, orientation(moved) / orientation(p));
        }
        best = std::max(best, lowest);
    }
    return best;
}

Vec<2> nearest_on(const std::array<Vec<2>, 2>& p, const Vec<2>& x) {
    const Vec<2> e = p[1] - p[0];
    return p[0] + std::clamp(dot(x - p[0], e) / norm_squared(e), 0.0, 1.0) * e;
}
Vec<3> nearest_on(const std::array<Vec<3>, 3>& p, const Vec<3>& x) {
    const Vec<3> n = normalised(cross(p[1] - p[0], p[2] - p[0]));
    const Vec<3> foot = x - dot(x - p[0], n) * n;
    bool inside = true;
    Vec<3> best = p[0];
    for (int i = 0; i < 3; ++i) {
        const Vec<3> a = p[i], e = p[(i + 1) % 3] - a;
        inside = inside && dot(cross(e, foot - a), n) >= 0;
        const Vec<3> q = a + std::clamp(dot(x - a, e) / norm_squared(e), 0.0, 1.0) * e;
        if (distance(q, x) < distance(best, x)) best = q;
    }
    return inside ? foot : best;
}

template <int D>
double distance_to_boundary(const KnownBack<D>& back, const Vec<D>& x) {
    double best = std::numeric_limits<double>::infinity();
    for (const ElementFace& face :
         boundary_faces<D>(must(neighbours(back.mesh, must(balls(back.mesh, one_thread)), one_thread)))) {
        std::array<Vec<D>, D> p;
        const auto local = face_opposite<D>(static_cast<int>(face.opposite));
        for (int i = 0; i < D; ++i) p[i] = back.mesh.points[back.mesh.elements.vertices[face.element][local[i]]];
        best = std::min(best, distance(x, nearest_on(p, x)));
    }
    return best;
}

/// Checks the result of `locate` for x from each hint.
template <int D>
void check_location(const KnownBack<D>& back, const Vec<D>& x, const std::vector<ElementId>& hints) {
    const double inside = depth(back.mesh, x);
    if (std::abs(inside) < 1e-9) return;
    Box<D> bounds;
    for (const Vec<D>& p : back.mesh.points) bounds.include(p);
    const double scale = bounds.diagonal();
    for (const ElementId hint : hints) {
        const auto location = locate(back, x, hint);
        double sum = 0;
        for (const double u : location.xi) {
            RC_ASSERT(u >= -1e-9);
            sum += u;
        }
        RC_ASSERT(std::abs(sum - 1) < 1e-12);
        RC_ASSERT(location.placement == (inside > 0 ? Placement::inside : Placement::outside));
        const double off = distance(place_of(back, location), x);
        RC_ASSERT(std::abs(off - (inside > 0 ? 0.0 : distance_to_boundary(back, x))) < 1e-12 * scale);
    }
}

/// Checks that each vertex, also on the boundary, is located exactly in its element. An invalid hint is ignored.
template <int D>
void check_vertices(const KnownBack<D>& back) {
    for (std::size_t e = 0; e < back.mesh.elements.size(); ++e)
        for (int i = 0; i <= D; ++i) {
            const auto location = locate(back, back.mesh.points[back.mesh.elements.vertices[e][i]], ElementId(e));
            RC_ASSERT(location.element == ElementId(e));
            RC_ASSERT(location.xi[i] == 1);
            RC_ASSERT(location.placement == Placement::inside);
        }
    const auto& corners = back.mesh.elements.vertices[0];
    Vec<D> centre{};
    for (const VertexId v : corners) centre += back.mesh.points[v] / (D + 1);
    RC_ASSERT(locate(back, centre, ElementId(back.mesh.elements.size() + 7)).placement == Placement::inside);
}

template <int D>
std::vector<ElementId> some_hints(const LinearMesh<D>& mesh, Dice& dice, int n) {
    std::vector<ElementId> hints;
    for (int k = 0; k < n; ++k) hints.emplace_back(dice.below(mesh.elements.size()));
    return hints;
}

template <int D>
void random_domains(const char* name, std::function<bool(const Cell<D>&)> keep, int cells, double jitter) {
    property(name,
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 LatticeOptions<D> options;
                 options.cells.fill(cells);
                 options.keep = keep;
                 options.jitter = jitter;
                 options.seed = seed + 1;
                 const auto shape = dice.matrix<D>();
                 RC_PRE(std::abs(det(shape)) > 0.01);
                 options.place = [&](const Vec<D>& p) { return shape * p; };
                 const auto back = plain_back(lattice_mesh(options));
                 for (int k = 0; k < 15; ++k)
                     check_location(back, shape * dice.vector<D>(-0.5 * cells, 1.5 * cells),
                                    some_hints(back.mesh, dice, 4));
                 check_vertices(back);
                 for (int k = 0; k < 15; ++k)
                     check_location(back, random_point(back.mesh, dice), some_hints(back.mesh, dice, 4));
             },
             {.count = 20});
}

template <int D>
bool in_l(const Cell<D>& c) {
    return c[0] < 2 || c[1] < 2;
}
/// A slit of one cell's thickness that splits the domain except for one layer of cells.
template <int D>
bool around_wall(const Cell<D>& c) {
    return c[0] != 2 || c[1] == 0;
}
template <int D>
bool around_hole(const Cell<D>& c) {
    bool hole = true;
    for (const int i : c) hole = hole && i >= 1 && i <= 3;
    return !hole;
}

}  // namespace

TEST_CASE("locate finds points inside and outside boxes") {
    random_domains<2>("2D", [](const Cell<2>&) { return true; }, 4, 0.2);
    random_domains<3>("3D", [](const Cell<3>&) { return true; }, 3, 0.1);
}
TEST_CASE("locate finds points inside and outside L-shaped domains") {
    random_domains<2>("2D", in_l<2>, 4, 0.2);
    random_domains<3>("3D", in_l<3>, 4, 0.1);
}
TEST_CASE("locate finds points inside and outside domains with a hole") {
    random_domains<2>("2D", around_hole<2>, 5, 0.2);
    random_domains<3>("3D", around_hole<3>, 5, 0.1);
}
TEST_CASE("locate finds points inside and outside domains with a slit") {
    random_domains<2>("2D", around_wall<2>, 5, 0.2);
    random_domains<3>("3D", around_wall<3>, 5, 0.1);
}

TEST_CASE("locate finds points near the tip of a sharp notch") {
    property("points around a trailing edge are located in a fan of triangles",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const double half = std::pow(10.0, dice.uniform(-4, -0.3));  // half the angle of the notch
                 const std::size_t rays = 9;
                 Buffer<Vec<2>> points{{{0, 0}}};
                 for (const double radius : {1.0, 2.0})
                     for (std::size_t k = 0; k < rays; ++k) {
                         const double angle =
                             half + (2 * std::numbers::pi - 2 * half) * static_cast<double>(k) / (rays - 1);
                         points.push_back(radius * Vec<2>{{std::cos(angle), std::sin(angle)}});
                     }
                 Buffer<SimplexVertices<2>> elements;
                 const auto id = [](std::size_t i) { return VertexId(i); };
                 for (std::size_t k = 1; k < rays; ++k) {
                     elements.push_back({id(0), id(k), id(k + 1)});
                     elements.push_back({id(k), id(k + rays), id(k + 1)});
                     elements.push_back({id(k + 1), id(k + rays), id(k + rays + 1)});
                 }
                 std::shuffle(elements.begin(), elements.end(), dice.engine());
                 const auto r = dice.rotation<2>();
                 for (auto& p : points) p = r * p;
                 const auto back = plain_back(mesh_of<2>(points, elements));
                 std::vector<ElementId> hints;
                 for (std::size_t e = 0; e < back.mesh.elements.size(); ++e) hints.emplace_back(e);
                 for (int k = 0; k < 20; ++k) check_location(back, dice.vector<2>(-1, 1), hints);
                 for (int k = 0; k < 20; ++k)
                     check_location(back, r * Vec<2>{{dice.uniform(-0.2, 0.5), dice.uniform(-0.1, 0.1)}}, hints);
             },
             {.count = 30});
}

namespace {

/// Points on edges lie on faces: rounding decides on which side, and the search must still find them.
template <int D>
void thin_domains(const Vec<D>& stretch, double origin) {
    CAPTURE(stretch[D - 2]);
    CAPTURE(stretch[D - 1]);
    CAPTURE(origin);
    property("edge midpoints and random points are located in thin rotated elements",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto r = dice.rotation<D>();
                 const Vec<D> far = origin * dice.vector<D>();
                 LatticeOptions<D> options;
                 options.cells.fill(4);
                 options.jitter = 0.1;
                 options.seed = seed + 1;
                 options.place = [&](Vec<D> p) {
                     for (int i = 0; i < D; ++i) p[i] *= stretch[i];
                     return far + r * p;
                 };
                 const auto mesh = lattice_mesh(options);
                 // A field that varies by 1 over an element in each direction.
                 const auto to_cells = [&](const Vec<D>& x) {
                     Vec<D> p = transposed_times(r, x - far);
                     for (int i = 0; i < D; ++i) p[i] /= stretch[i];
                     return p;
                 };
                 Vec<D> slope;
                 for (double& s : slope.c) s = 1;
                 const auto back = back_of(
                     mesh, [&](const Vec<D>& x) { return LogMetric<D>{dot(slope, to_cells(x)) * Sym<D>::identity()}; });
                 const auto edges = *unique_edges(mesh, one_thread);
                 const auto around = *shells(edges, one_thread);
                 // Coordinates are rounded by ε times their size; relative to the thinnest direction this is the noise.
                 const double smallest = *std::min_element(stretch.c.begin(), stretch.c.end());
                 const double noise = 1e-15 * (origin + 4) / smallest;
                 for (std::size_t e = 0; e < edges.size(); ++e) {
                     const auto [a, b] = edges.vertices[e];
                     const double t = dice.uniform(0, 1);
                     const Vec<D> x = (1 - t) * mesh.points[a] + t * mesh.points[b];
                     const auto sample = sample_value(back, x, around[e][dice.below(around[e].size())]);
                     RC_ASSERT(sample.location.placement != Placement::lost);
                     const double expected = (1 - t) * back.log_metrics[a].l(0, 0) + t * back.log_metrics[b].l(0, 0);
                     RC_ASSERT(std::abs(sample.log_metric.l(0, 0) - expected) < 1e-11 + 100 * noise);
                 }
                 for (int k = 0; k < 50; ++k) {
                     const std::size_t e = dice.below(mesh.elements.size());
                     const auto p = corners(mesh, e);
                     const auto xi = dice.barycentric<D>();
                     Vec<D> x;
                     double expected = 0;
                     for (int i = 0; i <= D; ++i) {
                         x += xi[i] * p[i];
                         expected += xi[i] * back.log_metrics[mesh.elements.vertices[e][i]].l(0, 0);
                     }
                     const auto sample = sample_value(back, x, ElementId(dice.below(mesh.elements.size())));
                     RC_ASSERT(sample.location.placement != Placement::lost);
                     RC_ASSERT(std::abs(sample.log_metric.l(0, 0) - expected) < 1e-11 + 100 * noise);
                 }
             },
             {.count = 10});
}

}  // namespace

TEST_CASE("locate finds points in thin elements") {
    for (const double origin : {0.0, 100.0}) {
        thin_domains<2>(Vec<2>{{1, 1}}, origin);
        thin_domains<2>(Vec<2>{{1, 1e-6}}, origin);
        thin_domains<3>(Vec<3>{{1, 1, 1}}, origin);
        thin_domains<3>(Vec<3>{{1, 1, 1e-6}}, origin);
        thin_domains<3>(Vec<3>{{1, 1e-3, 1e-6}}, origin);
        thin_domains<3>(Vec<3>{{1, 1e-6, 1e-6}}, origin);
    }
}
TEST_CASE("locate resolves details of 10^-6 at coordinates of 10^6") {
    thin_domains<2>(Vec<2>{{1e-3, 1e-6}}, 1e6);
    thin_domains<3>(Vec<3>{{1e-4, 1e-4, 1e-6}}, 1e6);
}

TEST_CASE("locate reports a NaN point as lost and works without a hint") {
    const auto back = plain_back(unit_box<2>(3, 1));
    const Vec<2> nowhere{{std::numeric_limits<double>::quiet_NaN(), 0.5}};
    CHECK(locate(back, nowhere, ElementId(std::size_t{0})).placement == Placement::lost);
    const Vec<2> x{{0.5, 0.5}};
    CHECK(locate(back, x, ElementId{}).placement == Placement::inside);
    CHECK(distance(place_of(back, locate(back, x, ElementId{})), x) < 1e-15);
}

TEST_CASE("locate finds points inside and outside one tetrahedron") {
    Buffer<Vec<3>> points{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    const auto id = [](std::size_t i) { return VertexId(i); };
    const auto back = plain_back(mesh_of<3>(points, Buffer<SimplexVertices<3>>{{id(0), id(1), id(2), id(3)}}));
    property(
        "points inside and outside one tetrahedron are located",
        [&](std::uint64_t seed) { check_location(back, Dice(seed).vector<3>(-1, 2), {ElementId(std::size_t{0})}); },
        {.count = 200});
}
