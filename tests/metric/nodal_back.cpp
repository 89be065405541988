// The back mesh of form (4): certified location in curved elements, and interpolation.
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

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
struct KnownNodal : BackMesh<D> {
    QuadraticMesh<D> mesh;
    NodalLogs<D> logs;
};

template <int D>
KnownNodal<D> nodal_back(const QuadraticMesh<D>& mesh, const NodalLogs<D>& logs, int threads = 1) {
    const Execution execution{.threads = threads};
    return {must(make_nodal_back_mesh(mesh, must(balls(mesh.linear, one_thread)), logs, execution)), mesh, logs};
}
template <int D>
KnownNodal<D> rough_nodal_back(const QuadraticMesh<D>& mesh, Dice& dice) {
    const auto vertices = rough_logs<D>(mesh.linear.points.size(), dice);
    return nodal_back<D>(mesh, {vertices, rough_logs<D>(mesh.edges.size(), dice)});
}

/// Form (3) by its Lagrange functions.
template <int D>
Sym<D> interpolant(const KnownNodal<D>& back, ElementId e, const std::array<double, D + 1>& xi) {
    Sym<D> l;
    for (int i = 0; i <= D; ++i)
        l += (xi[i] * (2 * xi[i] - 1)) * back.logs.vertices[back.mesh.linear.elements.vertices[e][i]].l;
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        l += (4 * xi[i] * xi[j]) * back.logs.mid_nodes[back.mesh.edges.of_elements[e][k]].l;
    }
    return l;
}

template <int D>
bool near(const Sym<D>& a, const Sym<D>& b, double tolerance) {
    return norm(a - b) <= tolerance;
}

template <int D>
double largest_bow(const QuadraticMesh<D>& mesh) {
    double most = 0;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) most = std::max(most, curvature(edge_of(mesh, EdgeId(e))));
    return most;
}

template <int D>
ElementId any_element(const QuadraticMesh<D>& mesh, Dice& dice) {
    return ElementId(dice.below(mesh.linear.elements.size()));
}

template <int D>
void check_location() {
    property("points are located from any hint with a proven radius, and the field is form (4)",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto back = rough_nodal_back(wavy_mesh<D>(4, seed + 1, dice), dice);
                 RC_ASSERT(largest_bow(back.mesh) > 0.05);
                 for (int n = 0; n < 10; ++n) {
                     const ElementId e = any_element(back.mesh, dice);
                     const auto xi = inner_place<D>(dice);
                     const Vec<D> x = point_in(back.mesh, e, xi);
                     const auto sample = sample_value(back, x, any_element(back.mesh, dice));
                     RC_ASSERT(sample.location.placement == Placement::inside);
                     RC_ASSERT(sample.location.element == e);
                     const auto radius = root_radius(back.mesh, sample.location, x);
                     RC_ASSERT(radius.has_value());
                     RC_ASSERT(*radius < 1e-12);
                     for (int i = 0; i <= D; ++i) RC_ASSERT(std::abs(sample.location.xi[i] - xi[i]) < 1e-12);
                     RC_ASSERT(near(sample.log_metric.l, interpolant(back, e, xi), 1e-10));
                 }
             });
    property("points of faces, edges and vertices are inside, with one value from any hint", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto back = rough_nodal_back(wavy_mesh<D>(3, seed + 1, dice), dice);
        for (int n = 0; n < 10; ++n) {
            const ElementId e = any_element(back.mesh, dice);
            auto xi = inner_place<D>(dice);
            for (std::size_t zeros = 1 + dice.below(D); zeros > 0; --zeros) {
                const std::size_t i = dice.below(D + 1);
                const std::size_t to = (i + 1) % (D + 1);
                if (xi[i] < 1) xi[to] += std::exchange(xi[i], 0);
            }
            const Vec<D> x = point_in(back.mesh, e, xi);
            const auto sample = sample_value(back, x, any_element(back.mesh, dice));
            RC_ASSERT(near(sample.log_metric.l, interpolant(back, e, xi), 1e-9));
        }
    });
    property("root_radius bounds the error of a wrong root", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto mesh = wavy_mesh<D>(4, seed + 1, dice);
        const ElementId e = any_element(mesh, dice);
        const auto xi = inner_place<D>(dice);
        Location<D> off{.element = e, .xi = xi};
        const double by = std::pow(10.0, dice.uniform(-12, -2));
        off.xi[1] += by;
        off.xi[0] -= by;
        const auto radius = root_radius(mesh, off, point_in(mesh, e, xi));
        RC_ASSERT(radius.has_value());
        RC_ASSERT(*radius > (1 - 1e-3) * by);
        RC_ASSERT(*radius < 20 * by + 1e-12);
        off.xi = xi;
        off.xi[1] += 1e3;  // far from any root
        RC_ASSERT(!root_radius(mesh, off, point_in(mesh, e, xi)) || *root_radius(mesh, off, point_in(mesh, e, xi)) > 1);
    });
    property("a nodal pack equals its points sampled in turn, for any number of threads", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto back = rough_nodal_back(wavy_mesh<D>(3, seed + 1, dice), dice);
        const auto by_threads = nodal_back<D>(back.mesh, back.logs, 3);
        std::vector<Vec<D>> points(8);
        for (Vec<D>& p : points) p = dice.vector<D>(-0.2, 1.2);
        std::vector<FieldSample<D>> samples(points.size()), others(points.size());
        const ElementId first = any_element(back.mesh, dice);
        back->sample_with_recovered_gradients(points, first, samples);
        by_threads->sample_with_recovered_gradients(points, first, others);
        ElementId hint = first;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto one = sample_with_recovered_gradient(back, points[i], hint);
            RC_ASSERT(one.log_metric == samples[i].log_metric);
            RC_ASSERT(one.gradient == samples[i].gradient);
            RC_ASSERT(others[i].gradient == samples[i].gradient);
            hint = one.location.element;
        }
    });
}

template <int D>
void check_gradients() {
    property("gradients inside and outside equal the differences of the values", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto back = rough_nodal_back(wavy_mesh<D>(3, seed + 1, dice), dice);
        const double step = 1e-5;
        const auto check = [&](const Vec<D>& x, ElementId hint) {
            const auto sample = sample_with_gradient(back, x, hint);
            for (int i = 0; i < D; ++i) {
                Vec<D> ahead = x, behind = x;
                ahead[i] += step;
                behind[i] -= step;
                const auto a = sample_value(back, ahead, hint), b = sample_value(back, behind, hint);
                // Across a face of another element or an edge of the boundary the gradient jumps.
                if (a.location.element != b.location.element) return;
                for (int k = 0; k <= D; ++k)
                    if ((a.location.xi[k] == 0) != (b.location.xi[k] == 0)) return;
                const Sym<D> slope = (1 / (2 * step)) * (a.log_metric.l - b.log_metric.l);
                RC_ASSERT(near(slope, sample.gradient[i], 1e-4 * (1 + norm(sample.gradient[i]))));
            }
        };
        const ElementId e = any_element(back.mesh, dice);
        check(point_in(back.mesh, e, inner_place<D>(dice)), e);
        Vec<D> outside = dice.vector<D>(0.1, 0.9);
        outside[dice.below(D)] = 1.15;
        check(outside, e);
    });
    property("sectors have the gradient of their element and walls that point inwards", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto back = rough_nodal_back(wavy_mesh<D>(3, seed + 1, dice), dice);
        const ElementId e = any_element(back.mesh, dice);
        const auto [i, j] = local_edges<D>[dice.below(edges_per_simplex<D>)];
        const auto& v = back.mesh.linear.elements.vertices[e];
        const auto sector = back->sector(e, v[i], v[j]);
        std::array<double, D + 1> middle{}, within{};
        middle[i] = middle[j] = 0.5;
        for (int k = 0; k <= D; ++k) within[k] = (1 - 1e-4) * middle[k] + 1e-4 / (D + 1);
        const Vec<D> inwards = point_in(back.mesh, e, within) - point_in(back.mesh, e, middle);
        for (const Vec<D>& wall : sector.walls) RC_ASSERT(dot(wall, inwards) > 0);
        const auto inside = sample_with_gradient(back, point_in(back.mesh, e, within), e);
        for (int c = 0; c < D; ++c)
            RC_ASSERT(near(inside.gradient[c], sector.gradient[c], 1e-2 * (1 + norm(sector.gradient[c]))));
    });
}

/// The distance to the nearest of many boundary points.
template <int D>
double sampled_distance(const QuadraticMesh<D>& mesh, const Vec<D>& x) {
    double best = 1e300;
    const auto across = must(neighbours(mesh.linear, must(balls(mesh.linear, one_thread)), one_thread));
    for (const ElementFace& face : boundary_faces<D>(across)) {
        const auto local = face_opposite<D>(static_cast<int>(face.opposite));
        constexpr int n = 24;
        for (int a = 0; a <= n; ++a)
            for (int b = 0; a + b <= n; ++b) {
                if (D == 2 && b > 0) break;
                std::array<double, D + 1> xi{};
                xi[local[0]] = static_cast<double>(n - a - b) / n;
                xi[local[1]] = static_cast<double>(a) / n;
                if constexpr (D == 3) xi[local[2]] = static_cast<double>(b) / n;
                best = std::min(best, distance(point_in(mesh, face.element, xi), x));
            }
    }
    return best;
}

template <int D>
void check_outside() {
    property("an outside point has the nearest boundary point as its location, from any hint",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto back = rough_nodal_back(wavy_mesh<D>(3, seed + 1, dice), dice);
                 const ElementId own = any_element(back.mesh, dice);
                 for (const VertexId v : back.mesh.linear.elements.vertices[own]) {
                     const auto location = locate(back, back.mesh.linear.points[v], own);
                     RC_ASSERT(location.element == own);
                     RC_ASSERT(*std::ranges::max_element(location.xi) == 1);
                 }
                 for (int n = 0; n < 6; ++n) {
                     Vec<D> x = dice.vector<D>(-0.3, 1.3);
                     if (n < 3) x[dice.below(D)] = dice.uniform(0, 1) < 0.5 ? -0.1 : 1.1;
                     const auto location = locate(back, x, any_element(back.mesh, dice));
                     RC_ASSERT(location.placement != Placement::lost);
                     const Vec<D> place = point_in(back.mesh, location.element, location.xi);
                     if (location.placement == Placement::inside) {
                         RC_ASSERT(distance(place, x) < 1e-13);
                         continue;
                     }
                     RC_ASSERT(*std::ranges::min_element(location.xi) == 0);
                     RC_ASSERT(distance(place, x) <= sampled_distance(back.mesh, x) * (1 + 1e-12));
                 }
             },
             {.count = 30});
    property("points beside a curved wall are inside on one side and outside on the other", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto back = rough_nodal_back(wavy_mesh<D>(3, seed + 1, dice), dice);
        const auto across = must(neighbours(back.mesh.linear, must(balls(back.mesh.linear, one_thread)), one_thread));
        const auto faces = boundary_faces<D>(across);
        const ElementFace face = faces[dice.below(faces.size())];
        auto xi = inner_place<D>(dice), ahead = xi;
        xi[face.opposite] = 0;
        double sum = 0;
        for (const double u : xi) sum += u;
        for (double& u : xi) u /= sum;
        for (int i = 0; i <= D; ++i) ahead[i] = (1 - 1e-3) * xi[i] + 1e-3 / (D + 1);
        const Vec<D> wall = point_in(back.mesh, face.element, xi);
        const Vec<D> inwards = point_in(back.mesh, face.element, ahead) - wall;
        for (const double share : {1.0, 1e-3, 1e-6}) {
            const ElementId hint = any_element(back.mesh, dice);
            RC_ASSERT(locate(back, wall + share * inwards, hint).placement == Placement::inside);
            const auto outside = locate(back, wall - share * inwards, hint);
            RC_ASSERT(outside.placement == Placement::outside);
            const Vec<D> place = point_in(back.mesh, outside.element, outside.xi);
            RC_ASSERT(distance(place, wall - share * inwards) <= share * norm(inwards) * (1 + 1e-6) + 1e-15);
        }
    });
}

template <int D>
void check_straight() {
    property("midpoint nodes with mean logs give the straight back mesh", [](std::uint64_t seed) {
        Dice dice(seed);
        const auto mesh = must(elevate(unit_box<D>(3, seed + 1, 0.15), one_thread));
        const auto around = must(balls(mesh.linear, one_thread));
        const auto logs = rough_logs<D>(mesh.linear.points.size(), dice);
        const auto straight = must(make_back_mesh(mesh.linear, around, logs, one_thread));
        const auto nodal = nodal_back<D>(mesh, must(nodal_logs(mesh.edges, logs, one_thread)));
        for (int n = 0; n < 8; ++n) {
            const Vec<D> x = dice.vector<D>(-0.3, 1.3);
            const ElementId hint = any_element(mesh, dice);
            const auto a = sample_with_gradient(nodal, x, hint), b = sample_with_gradient(straight, x, hint);
            RC_ASSERT(a.location.placement == b.location.placement);
            RC_ASSERT(near(a.log_metric.l, b.log_metric.l, 1e-9));
            const auto c = sample_with_recovered_gradient(nodal, x, hint);
            const auto d = sample_with_recovered_gradient(straight, x, hint);
            for (int i = 0; i < D; ++i) {
                if (a.location.element == b.location.element) RC_ASSERT(near(a.gradient[i], b.gradient[i], 1e-7));
                if (a.location.element == b.location.element) RC_ASSERT(near(c.gradient[i], d.gradient[i], 1e-7));
            }
        }
        const double exact = must(complexity(mesh.linear, logs, one_thread));
        RC_ASSERT(std::abs(must(complexity(mesh, nodal.logs, one_thread)) / exact - 1) < 1e-6);
    });
}

/// Layers along an arc with heights `thin` of their length. They bow by a tenth of their chords, which is 10^5 of their
/// heights.
template <int D>
QuadraticMesh<D> layers_at_arc(double thin, std::uint64_t seed) {
    LatticeOptions<D> options;
    options.cells.fill(3);
    options.cells[D - 1] = 6;
    options.seed = seed;
    return mapped(lattice_mesh(options), [&](const Vec<D>& p) {
        const double r = 1 + 0.8 * thin * p[D - 1], a = 0.8 * p[0];
        if constexpr (D == 2)
            return Vec<2>{{r * std::sin(a), r * std::cos(a)}};
        else
            return Vec<3>{{r * std::sin(a), r * std::cos(a), 0.8 * p[1]}};
    });
}

template <int D>
void check_thin_layers() {
    for (const double thin : {1e-3, 1e-6})
        property("points in curved layers of anisotropy 1e6 are located from any hint", [&](std::uint64_t seed) {
            Dice dice(seed);
            const auto back = rough_nodal_back(layers_at_arc<D>(thin, seed + 1), dice);
            RC_ASSERT(largest_bow(back.mesh) > 0.09);
            for (int n = 0; n < 10; ++n) {
                const ElementId e = any_element(back.mesh, dice);
                const auto xi = inner_place<D>(dice);
                const Vec<D> x = point_in(back.mesh, e, xi);
                const auto sample = sample_value(back, x, any_element(back.mesh, dice));
                const int placement = static_cast<int>(sample.location.placement);
                RC_ASSERT(placement == 0);
                RC_ASSERT(sample.location.element == e);
                const auto radius = root_radius(back.mesh, sample.location, x);
                RC_ASSERT(radius.has_value());
                RC_ASSERT(*radius < 1e-12 / thin);
                for (int i = 0; i <= D; ++i) RC_ASSERT(std::abs(sample.location.xi[i] - xi[i]) < 2e-15 / thin);
            }
        });
}

}  // namespace

TEST_CASE("a nodal back mesh locates points with a proven radius in 2D") { check_location<2>(); }
TEST_CASE("a nodal back mesh locates points with a proven radius in 3D") { check_location<3>(); }
TEST_CASE("gradients in a nodal back mesh match differences in 2D") { check_gradients<2>(); }
TEST_CASE("gradients in a nodal back mesh match differences in 3D") { check_gradients<3>(); }
TEST_CASE("a nodal back mesh maps outside points to the nearest boundary point in 2D") { check_outside<2>(); }
TEST_CASE("a nodal back mesh maps outside points to the nearest boundary point in 3D") { check_outside<3>(); }
TEST_CASE("a nodal back mesh with straight elements equals the straight back mesh in 2D") { check_straight<2>(); }
TEST_CASE("a nodal back mesh with straight elements equals the straight back mesh in 3D") { check_straight<3>(); }
TEST_CASE("a nodal back mesh locates points in thin curved layers in 2D") { check_thin_layers<2>(); }
TEST_CASE("a nodal back mesh locates points in thin curved layers in 3D") { check_thin_layers<3>(); }
TEST_CASE("a nodal back mesh rejects columns of the wrong size") {
    const auto mesh = must(elevate(unit_box<2>(2, 1), one_thread));
    const auto around = must(balls(mesh.linear, one_thread));
    const auto logs = must(nodal_logs(mesh.edges, Column<LogMetric<2>>(Buffer<LogMetric<2>>(9)), one_thread));
    CHECK(make_nodal_back_mesh(mesh, around, logs, one_thread).has_value());
    CHECK(make_nodal_back_mesh<2>(mesh, around, {logs.mid_nodes, logs.mid_nodes}, one_thread).error().kind ==
          ErrorKind::usage);
    CHECK(make_nodal_back_mesh<2>(mesh, around, {logs.vertices, logs.vertices}, one_thread).error().kind ==
          ErrorKind::usage);
}
