// The surrogate beside prescribed surfaces where the boundary is smooth.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "meshes.hpp"
#include "sanitized.hpp"

using namespace surface_tests;

namespace {

const Execution one_thread{.threads = 1};
constexpr Reference prescribed_reference = 1;
constexpr Reference fitted_reference = 2;

/// Reference `prescribed_reference` if the centre of the facet is in `part`, else `fitted_reference`. The cut follows
/// edges in zigzags.
template <int D>
Soup<D> cut(Soup<D> soup, const std::function<bool(const Vec<D>&)>& part) {
    soup.references.clear();
    for (const auto& facet : soup.facets) {
        Vec<D> middle;
        for (const std::size_t v : facet) middle += soup.points[v] / double{D};
        soup.references.push_back(part(middle) ? prescribed_reference : fitted_reference);
    }
    return soup;
}

/// Facets of `prescribed_reference` lie on the surface, the others on a surrogate built with it.
template <int D>
Built<D> built_beside(const LinearMesh<D>& mesh, const AnalyticSurface<D>& surface) {
    Built<D> b = build(mesh);
    const auto make = [&](const GeometryModel<D>& prescribed) {
        auto result = build_surrogate(mesh, b.mesh.edges, b.features, prescribed, SurrogateOptions{}, one_thread);
        if (result) b.surrogate = *result;
        return result;
    };
    const auto geometry = with_surrogate<D>(AnalyticGeometry<D>{{{prescribed_reference, surface}}}, mesh, make).value();
    b.nodes = boundary_nodes(b.mesh, b.features, geometry, one_thread).value();
    return b;
}

/// The largest distances of nodes and cubic facets of reference `fitted_reference`.
Errors fitted_errors(const Built<3>& b, const Off& off) {
    Errors e;
    for (std::size_t f = 0; f < b.mesh.linear.facets.size(); ++f) {
        if (b.mesh.linear.facets.references[f] != fitted_reference) continue;
        for (const EdgeId id : b.mesh.edges.of_facets[f]) e.edges = std::fmax(e.edges, off(b.nodes[id.index()].point));
        for (const auto& alpha : multi_indices<9, 2>)
            e.surrogate = std::fmax(
                e.surrogate,
                off(point_at(b.surrogate.facets[f], Barycentric<2>{alpha[0] / 9.0, alpha[1] / 9.0, alpha[2] / 9.0})));
    }
    return e;
}

const Torus ring{{}, {{0, 0, 1}}, 1, 0.4};

/// A tube of radius 1 up to z = 1/2 that continues as a cone with this opening angle.
Soup<3> flared(std::size_t n, double degrees) {
    const std::size_t rows = 12, first = rows / 2 * n;
    const double middle = 0.575;  // z of that row without jitter
    auto soup = tube(n, rows, 1);
    for (std::size_t p = 0; p < soup.points.size(); ++p) {
        Vec<3>& at = soup.points[p];
        const double rest = p < first + n ? 0 : (at[2] - middle) / (1 - middle) / 2;
        at[2] = p < first ? at[2] / middle / 2 : 0.5 + rest;
        const double r = 1 + rest * std::tan(degrees * pi / 180);
        at[0] *= r;
        at[1] *= r;
    }
    return soup;
}

/// n uneven points on a closed curve.
Soup<2> around(std::size_t n, const std::function<Vec<2>(double)>& curve) {
    Random random(3);
    std::vector<Vec<2>> points;
    points.reserve(n);
    for (std::size_t i = 0; i < n; ++i)
        points.push_back(curve(2 * pi * (static_cast<double>(i) + random(-0.2, 0.2)) / static_cast<double>(n)));
    return polygon(std::move(points));
}

/// Adds the edges between both references to the ridges of the mesh.
LinearMesh<3> listed_cut(LinearMesh<3> mesh) {
    const auto edges = elevate<3>(mesh, one_thread).value().edges;
    const auto shells = facet_shells(edges, one_thread).value();
    Buffer<SimplexVertices<1>> vertices;
    Buffer<std::uint32_t> ridges;
    for (std::size_t e = 0; e < edges.size(); ++e)
        if (shells[e].size() == 2 && mesh.facets.references[shells[e][0]] != mesh.facets.references[shells[e][1]]) {
            ridges.push_back(static_cast<std::uint32_t>(vertices.size()));
            vertices.push_back({edges.vertices[e][0], edges.vertices[e][1]});
        }
    mesh.edges.references = Buffer<Reference>(vertices.size(), Reference{0});
    mesh.edges.vertices = std::move(vertices);
    mesh.ridges = std::move(ridges);
    return mesh;
}

template <int D>
double largest_shift(const Built<D>& a, const Built<D>& b) {
    double largest = 0;
    for (std::size_t f = 0; f < a.mesh.linear.facets.size(); ++f)
        if (a.mesh.linear.facets.references[f] == fitted_reference)
            for (std::size_t i = 0; i < a.surrogate.facets[f].control.size(); ++i)
                largest =
                    std::fmax(largest, distance(a.surrogate.facets[f].control[i], b.surrogate.facets[f].control[i]));
    return largest;
}

}  // namespace

TEST_CASE("the surrogate beside a prescribed half torus is as accurate as on the whole torus") {
    const auto off = off_surface(ring);
    for (const std::size_t n : {std::size_t{20}, std::size_t{32}}) {
        if (camber::testing::is_sanitized && n > 20) break;
        const auto soup = torus(n, 1, 0.4);
        const auto mesh = cut<3>(soup, [](const Vec<3>& p) { return p[0] + 0.3 * p[1] < 0.1; }).mesh();
        const auto whole = errors(build(soup.mesh()), off);
        const auto single = fitted_errors(build(mesh), off), beside = fitted_errors(built_beside<3>(mesh, ring), off);
        CAPTURE(n);
        CHECK(beside.edges < 1.5 * whole.edges);
        CHECK(beside.surrogate < 1.5 * whole.surrogate);
        CHECK(single.edges > 10 * beside.edges);
        CHECK(single.surrogate > 8 * beside.surrogate);
    }
}

TEST_CASE("the surrogate continues a prescribed circle smoothly") {
    const auto radius = [](double t) { return 1 + (t > 0 ? 0.5 * std::pow(std::sin(t), 4) : 0); };
    const auto curve = [&](double t) { return radius(t) * Vec<2>{{std::cos(t), std::sin(t)}}; };
    for (const std::size_t n : {std::size_t{24}, std::size_t{48}}) {
        auto soup = around(n, [&](double t) { return curve(t > pi ? t - 2 * pi : t); });
        soup.points[0] = curve(0);
        soup.points[n / 2] = curve(pi);
        const auto mesh = cut<2>(std::move(soup), [](const Vec<2>& p) { return p[1] < 0; }).mesh();
        const auto off = [&](const Built<2>& b) {
            double largest = 0;
            for (std::size_t f = 0; f < mesh.facets.size(); ++f)
                if (mesh.facets.references[f] == fitted_reference)
                    for (int k = 0; k <= 10; ++k) {
                        const Vec<2> p = point_at(b.surrogate.facets[f], Barycentric<1>{1 - k / 10.0, k / 10.0});
                        largest = std::fmax(largest, std::fabs(norm(p) - radius(std::atan2(p[1], p[0]))));
                    }
            return largest;
        };
        const auto single = build(mesh), beside = built_beside<2>(mesh, Sphere<2>{{}, 1});
        CAPTURE(n);
        CHECK(off(beside) < 0.7 * off(single));
    }
}

TEST_CASE("creases between prescribed and fitted surfaces are preserved") {
    const auto below = [](const Vec<3>& p) { return p[2] < 0.5; };
    const Cylinder wall{{}, {{0, 0, 1}}, 1};
    for (const double degrees : {15.0, 25.0}) {
        const auto mesh = cut<3>(flared(24, degrees), below).mesh();  // facets turn by 15 degrees and more
        CAPTURE(degrees);
        CHECK(largest_shift(build(mesh), built_beside<3>(mesh, wall)) == 0);
    }
}

TEST_CASE("listed creases and corners of a smooth boundary are preserved") {
    const auto soup = cut<3>(torus(16, 1, 0.4), [](const Vec<3>& p) { return p[0] < 0; });
    auto mesh = soup.mesh();
    const auto listed = listed_cut(mesh);
    CHECK(largest_shift(build(mesh), built_beside<3>(mesh, ring)) > 0);
    CHECK(largest_shift(build(listed), built_beside<3>(listed, ring)) == 0);

    auto circle = cut<2>(around(18, [](double t) { return Vec<2>{{std::cos(t), std::sin(t)}}; }), [](const Vec<2>& p) {
                      return p[0] < 0.2;
                  }).mesh();
    CHECK(largest_shift(build(circle), built_beside<2>(circle, Sphere<2>{{}, 1})) > 0);
    Buffer<VertexId> all;
    for (std::size_t v = 0; v < circle.points.size(); ++v) all.push_back(VertexId(v));
    circle.corners = std::move(all);
    CHECK(largest_shift(build(circle), built_beside<2>(circle, Sphere<2>{{}, 1})) == 0);
}
