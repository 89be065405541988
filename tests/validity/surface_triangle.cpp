#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include <boost/multiprecision/cpp_int.hpp>

import camber.core;
import camber.bezier;
import camber.validity;

#include "generators.hpp"

using namespace camber;
using namespace generators;
using camber::testing::property;

namespace {

using Big = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<>, boost::multiprecision::et_off>;
using BigVec = std::array<Big, 3>;

BigVec cross_of(const BigVec& u, const BigVec& v) {
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
Big dot_of(const BigVec& u, const BigVec& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; }

constexpr int fraction = 1200;
/// x as a multiple of 2⁻¹²⁰⁰.
Big whole(double x) {
    int exponent = 0;
    const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
    return mantissa == 0 ? Big(0) : Big(mantissa) << (exponent - 53 + fraction);
}

/// True if N · n ≥ bound |N_straight| and > 0 at the point with these weights, in integer arithmetic. From the shape
/// functions of the six nodes: q ∂_a x = (4 w_a − q) p_a + 4 Σ_j w_j n_aj with q = Σw.
bool holds_at(const SurfaceTriangle& t, const std::array<Big, 3>& w, double bound) {
    std::array<BigVec, 6> n;
    for (int i = 0; i < 6; ++i)
        for (int c = 0; c < 3; ++c) n[i][c] = whole(t.nodes[i][c]);
    constexpr int node[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
    const Big q = w[0] + w[1] + w[2];
    const auto slope = [&](int a) {
        BigVec s;
        for (int c = 0; c < 3; ++c) {
            s[c] = (4 * w[a] - q) * n[a][c];
            for (int j = 0; j < 3; ++j)
                if (j != a) s[c] += 4 * w[j] * n[node[a][j]][c];
        }
        return s;
    };
    BigVec u, v, e, f;
    const BigVec s0 = slope(0), s1 = slope(1), s2 = slope(2);
    for (int c = 0; c < 3; ++c) {
        u[c] = s1[c] - s0[c];
        v[c] = s2[c] - s0[c];
        e[c] = n[1][c] - n[0][c];
        f[c] = n[2][c] - n[0][c];
    }
    const BigVec straight = cross_of(e, f);
    const Big value = dot_of(cross_of(u, v), straight);
    if (value <= 0) return false;
    return (value << fraction) >= whole(bound) * dot_of(straight, straight) * q * q;
}

std::array<Big, 3> weights(const Barycentric<2>& xi) { return {whole(xi[0]), whole(xi[1]), whole(xi[2])}; }

/// A triangle in space with randomly displaced nodes.
SurfaceTriangle random_triangle(std::mt19937_64& random, double amplitude) {
    SurfaceTriangle t;
    for (int i = 0; i < 3; ++i)
        for (int c = 0; c < 3; ++c) t.nodes[i][c] = uniform(random, -1, 1);
    for (int e = 0; e < 3; ++e) {
        const auto [i, j] = local_edges<2>[e];
        t.nodes[3 + e] = midpoint(t.nodes[i], t.nodes[j]);
        for (int c = 0; c < 3; ++c) t.nodes[3 + e][c] += uniform(random, -amplitude, amplitude);
    }
    return t;
}
SurfaceTriangle lattice_triangle(std::mt19937_64& random, int most) {
    SurfaceTriangle t;
    for (auto& p : t.nodes)
        for (int c = 0; c < 3; ++c) p[c] = static_cast<double>(integer(random, most));
    return t;
}

NodalSimplex<2> flat_triangle(std::mt19937_64& random, double amplitude) {
    NodalSimplex<2> s;
    do {
        for (int i = 0; i < 3; ++i)
            for (int c = 0; c < 2; ++c) s.nodes[i][c] = uniform(random, -1, 1);
    } while (!(det(s.nodes[1] - s.nodes[0], s.nodes[2] - s.nodes[0]) > 1e-3));
    for (int e = 0; e < 3; ++e) {
        const auto [i, j] = local_edges<2>[e];
        s.nodes[3 + e] = midpoint(s.nodes[i], s.nodes[j]);
        for (int c = 0; c < 2; ++c) s.nodes[3 + e][c] += uniform(random, -amplitude, amplitude);
    }
    return s;
}

void check_verdict(const SurfaceTriangle& t, double bound) {
    const auto certificate = certify(t, bound);
    RC_ASSERT(certificate.verdict != Verdict::undecided);
    RC_ASSERT(certificate.verdict == decide(t, bound));
    RC_ASSERT(certificate.verdict == certify_exactly(t, bound).verdict);
    RC_ASSERT(certificate.verdict == check_element(t, bound).verdict);
    if (certificate.verdict == Verdict::invalid) {
        if (certificate.witness) RC_ASSERT(!holds_at(t, weights(*certificate.witness), bound));
        return;
    }
    constexpr int n = 12;
    for (int a = 0; a <= n; ++a)
        for (int b = 0; a + b <= n; ++b) RC_ASSERT(holds_at(t, {a, b, n - a - b}, bound));
}

}  // namespace

TEST_CASE("verdicts of surface triangles agree with integer arithmetic") {
    property("triangles in general position have the verdict of integer arithmetic",
             [] {
                 auto random = random_source();
                 check_verdict(random_triangle(random, uniform(random, 0, 0.6)), uniform(random, 0, 0.5));
             },
             {300});
    property("triangles on a lattice have the verdict of integer arithmetic",
             [] {
                 auto random = random_source();
                 check_verdict(lattice_triangle(random, 4), uniform(random, 0, 1) < 0.5 ? 0 : 0.25);
             },
             {1500});
    property("distant triangles of any size have the verdict of integer arithmetic",
             [] {
                 auto random = random_source();
                 SurfaceTriangle t = random_triangle(random, 0.4);
                 const double size = std::ldexp(1.0, static_cast<int>(integer(random, 30)));
                 const double far = uniform(random, 0, 1) < 0.5 ? 0 : 1e4;
                 for (auto& p : t.nodes)
                     for (int c = 0; c < 3; ++c) p[c] = size * (p[c] + far);
                 check_verdict(t, uniform(random, 0, 0.5));
             },
             {200});
    property("a corner at the limit of validity is decided to the last bit",
             [] {
                 auto random = random_source();
                 // The tangents at vertex 0 are parallel: 4 n − 3 p0 − p1 of both edges.
                 SurfaceTriangle t = lattice_triangle(random, 8);
                 const Vec<3> along = 4.0 * t.nodes[3] - 3.0 * t.nodes[0] - t.nodes[1];
                 t.nodes[5] = 0.25 * (2.0 * along + 3.0 * t.nodes[0] + t.nodes[2]);
                 const int c = static_cast<int>(random() % 3);
                 if (const auto step = random() % 3; step != 0)
                     t.nodes[5][c] = std::nextafter(t.nodes[5][c], step == 1 ? 1e9 : -1e9);
                 check_verdict(t, 0);
             },
             {500});
}

TEST_CASE("the minimum scaled Jacobian of a surface triangle is a close lower bound") {
    property("the minimum scaled Jacobian is a close lower bound of the samples",
             [] {
                 auto random = random_source();
                 const SurfaceTriangle t = random_triangle(random, uniform(random, 0, 0.4));
                 QuadraticSimplex<2, 3> curved;
                 for (int i = 0; i < 3; ++i) curved.control[i] = t.nodes[i];
                 for (int e = 0; e < 3; ++e) {
                     const auto [i, j] = local_edges<2>[e];
                     curved.control[3 + e] =
                         control_point(t.nodes[i], LagrangeNode<3>{t.nodes[3 + e]}, t.nodes[j]).point;
                 }
                 const Vec<3> straight = cross(t.nodes[1] - t.nodes[0], t.nodes[2] - t.nodes[0]);
                 RC_PRE(norm(straight) > 0.05);
                 constexpr int n = 200;
                 double low = std::numeric_limits<double>::infinity();
                 for (int a = 0; a <= n; ++a)
                     for (int b = 0; a + b <= n; ++b) {
                         const auto d = curved.derivatives({a / (n * 1.0), b / (n * 1.0), (n - a - b) / (n * 1.0)});
                         low = std::min(low, dot(cross(d[0], d[1]), straight) / norm_squared(straight));
                     }
                 const double found = check_element(t, 0).min_scaled_jacobian;
                 const auto j = bounded_jacobian(t);
                 double most = 1;
                 for (const double c : j.coefficients) most = std::max(most, std::abs(c / j.straight));
                 RC_ASSERT(found <= low + 1e-10 * most);
                 RC_ASSERT(found >= low - 1.1e-3 * std::max(1.0, std::abs(low)) - 8 * most / (n * n));
             },
             {60});
}

TEST_CASE("plain and sharp Jacobians of surface triangles agree within their errors") {
    property("plain and sharp coefficients agree within their errors",
             [] {
                 auto random = random_source();
                 const SurfaceTriangle t = random_triangle(random, 0.5);
                 const auto plain = bounded_jacobian(t), sharp = double_double_jacobian(t);
                 RC_ASSERT(sharp.error < plain.error);
                 RC_ASSERT(std::abs(plain.straight - sharp.straight) <= plain.error + sharp.error);
                 for (int i = 0; i < 6; ++i)
                     RC_ASSERT(std::abs(plain.coefficients[i] - sharp.coefficients[i]) <= plain.error + sharp.error);
             },
             {300});
}

TEST_CASE("a surface triangle in a plane has the verdict of the 2D triangle") {
    property("a triangle in a coordinate plane has the 2D verdict with either side up",
             [] {
                 auto random = random_source();
                 const NodalSimplex<2> flat = flat_triangle(random, uniform(random, 0, 0.5));
                 const double bound = uniform(random, 0, 0.5);
                 const ElementValidity expected = check_element(flat, bound);
                 const int axis = static_cast<int>(random() % 3);
                 const double height = uniform(random, -10, 10);
                 for (const bool turned : {false, true}) {
                     SurfaceTriangle t;
                     for (int i = 0; i < 6; ++i) {
                         t.nodes[i][axis] = height;
                         t.nodes[i][(axis + 1) % 3] = flat.nodes[i][turned ? 1 : 0];
                         t.nodes[i][(axis + 2) % 3] = flat.nodes[i][turned ? 0 : 1];
                     }
                     const ElementValidity found = check_element(t, bound);
                     RC_ASSERT(found.verdict == expected.verdict);
                     RC_ASSERT(found.min_scaled_jacobian == expected.min_scaled_jacobian);
                     RC_ASSERT(!found.straight_inverted);
                     RC_ASSERT(certify(t, bound).verdict == certify(flat, bound).verdict);
                 }
             },
             {300});
    property("a triangle rotated in space has the 2D minimum up to rounding",
             [] {
                 auto random = random_source();
                 const NodalSimplex<2> flat = flat_triangle(random, uniform(random, 0, 0.3));
                 const Vec<3> a = normalised(Vec<3>{{uniform(random, -1, 1), uniform(random, -1, 1), 1}});
                 const Vec<3> b = normalised(cross(a, Vec<3>{{1, 2, 0.3}}));
                 SurfaceTriangle t;
                 for (int i = 0; i < 6; ++i) t.nodes[i] = flat.nodes[i][0] * a + flat.nodes[i][1] * b;
                 const double expected = check_element(flat, 0).min_scaled_jacobian;
                 const double found = check_element(t, 0).min_scaled_jacobian;
                 RC_ASSERT(std::abs(found - expected) <= 1.1e-3 * std::max(1.0, std::abs(expected)));
             },
             {200});
}

TEST_CASE("surface triangles without a normal or with non-finite nodes are invalid") {
    SurfaceTriangle t;
    t.nodes = {Vec<3>{{0, 0, 0}}, Vec<3>{{1, 1, 1}},       Vec<3>{{2, 2, 2}},
               Vec<3>{{1, 0, 0}}, Vec<3>{{1.5, 1.6, 1.4}}, Vec<3>{{1, 1, 1}}};
    CHECK(certify(t, 0).verdict == Verdict::invalid);
    CHECK(check_element(t, 0).straight_inverted);
    CHECK(check_element(t, 0).min_scaled_jacobian == -std::numeric_limits<double>::infinity());
    for (auto& p : t.nodes) p = {{3, 3, 3}};
    CHECK(certify(t, 0).verdict == Verdict::invalid);
    t.nodes = {Vec<3>{{0, 0, 0}},   Vec<3>{{1, 0, 0.1}},   Vec<3>{{0, 1, 0}},
               Vec<3>{{0.5, 0, 0}}, Vec<3>{{0.5, 0.5, 0}}, Vec<3>{{0, 0.5, 0}}};
    CHECK(certify(t, 0).verdict == Verdict::valid);
    t.nodes[4][2] = std::numeric_limits<double>::quiet_NaN();
    CHECK(certify(t, 0).verdict == Verdict::invalid);
    t.nodes[4][2] = std::numeric_limits<double>::infinity();
    CHECK(check_element(t, 0).verdict == Verdict::invalid);
    // Squares of these coordinates overflow or underflow, so integer arithmetic decides.
    for (const double size : {1e200, 1e-200}) {
        t.nodes = {Vec<3>{{0, 0, 0}}, Vec<3>{{1, 0, 0.5}}, Vec<3>{{0, 1, 0.2}}, {}, {}, {}};
        for (int e = 0; e < 3; ++e)
            t.nodes[3 + e] = midpoint(t.nodes[local_edges<2>[e][0]], t.nodes[local_edges<2>[e][1]]);
        for (auto& p : t.nodes) p *= size;
        CHECK(certify(t, 0).verdict == Verdict::valid);
    }
}

namespace {

/// A bumpy square of triangles in space with randomly displaced nodes.
QuadraticMesh<3> sheet(std::mt19937_64& random, int n, double amplitude) {
    LinearMesh<3> mesh;
    Buffer<Vec<3>> points;
    Buffer<SimplexVertices<2>> triangles;
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= n; ++j) points.push_back({{double(i), double(j), std::sin(0.7 * i) + 0.2 * j}});
    const auto at = [&](int i, int j) { return VertexId(static_cast<std::size_t>(i * (n + 1) + j)); };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    mesh.point_references = Buffer<Reference>(points.size(), 0);
    mesh.facets.references = Buffer<Reference>(triangles.size(), 1);
    mesh.points = std::move(points);
    mesh.facets.vertices = std::move(triangles);
    auto curved = elevate(mesh, Execution{1}).value();
    Buffer<LagrangeNode<3>> nodes(curved.mid_nodes.begin(), curved.mid_nodes.end());
    for (auto& node : nodes)
        for (int c = 0; c < 3; ++c) node.point[c] += uniform(random, -amplitude, amplitude);
    curved.mid_nodes = std::move(nodes);
    return curved;
}

}  // namespace

TEST_CASE("validate of a standalone surface returns the verdicts of its triangles") {
    property(
        "validate returns verdicts, counts and the minimum of the triangles",
        [] {
            auto random = random_source();
            const auto mesh = sheet(random, 7, uniform(random, 0, 0.3));
            const double bound = uniform(random, 0, 1) < 0.5 ? 0 : 0.4;
            const auto v = validate(mesh, bound, Execution{1}).value();
            RC_ASSERT(v.verdicts.size() == mesh.linear.facets.size());
            std::size_t invalid = 0;
            double smallest = 1e300;
            for (std::size_t t = 0; t < v.verdicts.size(); ++t) {
                const auto single = check_element(surface_triangle(mesh, mesh.mid_nodes.view(), t), bound);
                RC_ASSERT(v.verdicts[t] == single.verdict);
                invalid += single.verdict == Verdict::invalid;
                smallest = std::min(smallest, single.min_scaled_jacobian);
            }
            RC_ASSERT(v.invalid == invalid);
            RC_ASSERT(v.undecided == 0);
            RC_ASSERT(std::abs(v.smallest - smallest) <= scaled_jacobian_tolerance * std::max(1.0, std::abs(smallest)));
            RC_ASSERT(validate(mesh, bound, Execution{4}).value() == v);
        },
        {25});
}

TEST_CASE("commit rejects a standalone surface with invalid triangles") {
    std::mt19937_64 random(3);
    const auto mesh = sheet(random, 6, 0.45);
    const std::size_t edges = mesh.edges.size();
    const Proposal<3> proposal{mesh.linear.points, mesh.mid_nodes, Buffer<EdgeKind>(edges, EdgeKind::surface),
                               Buffer<EdgeChange>(edges, EdgeChange::projected)};
    const auto judged = validate(mesh, proposal, 0, Execution{1}).value();
    REQUIRE(!judged.validation().certified());
    const auto refused = commit(judged);
    REQUIRE(!refused);
    CHECK(refused.error().entity->kind == "triangle");
}
