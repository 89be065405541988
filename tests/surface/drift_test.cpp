// A degree-2 mesh is remeshed repeatedly, each time on the smooth surface through the previous one. The boundary does
// not drift.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "meshes.hpp"
#include "sanitized.hpp"

using namespace surface_tests;

namespace {

template <int D>
using Distance = std::function<double(const Vec<D>&)>;

/// A degree-2 boundary and the surface through it.
template <int D>
struct Remeshing {
    QuadraticMesh<D> mesh;
    CurvedSurrogate<D> curved;
};

/// Projects vertices and nodes onto the geometry. Without one, vertices stay and nodes lie on their own surrogate.
template <int D>
Remeshing<D> remeshed(LinearMesh<D> layout, const Geometry<D>* geometry) {
    if (geometry != nullptr) {
        Buffer<Vec<D>> points(layout.points.begin(), layout.points.end());
        for (Vec<D>& p : points) p = project(*geometry, {}, p).point;
        layout.points = std::move(points);
    }
    const Built<D> built = build(layout);
    Remeshing<D> out{built.mesh, {}};
    Buffer<LagrangeNode<D>> nodes(built.nodes.begin(), built.nodes.end());
    if (geometry != nullptr)
        for (std::size_t e = 0; e < nodes.size(); ++e)
            nodes[e].point = project(*geometry, {}, built.mesh.mid_nodes[e].point).point;
    out.mesh.mid_nodes = std::move(nodes);
    out.curved = build_curved_surrogate<D>(built.surrogate,
                                           {out.mesh.linear, out.mesh.edges, built.features, out.mesh.mid_nodes.view()},
                                           StraightGeometry<D>{}, SurrogateOptions{}, {.threads = 1})
                     .value();
    return out;
}

/// The root mean square distance of vertices and nodes.
template <int D>
double error_of(const QuadraticMesh<D>& mesh, const Distance<D>& off) {
    double squares = 0;
    for (const Vec<D>& p : mesh.linear.points) squares += off(p) * off(p);
    for (const LagrangeNode<D>& node : mesh.mid_nodes) squares += off(node.point) * off(node.point);
    return std::sqrt(squares / static_cast<double>(mesh.linear.points.size() + mesh.mid_nodes.size()));
}

struct Drift {
    double first = 0, last = 0;  ///< errors after the first and the last remeshing
    std::size_t smooth = 0;      ///< smooth patches of the last mesh
};

template <int D>
Drift drift(std::size_t rounds, const std::function<LinearMesh<D>(std::size_t)>& layout, const Distance<D>& off) {
    Remeshing<D> at = remeshed<D>(layout(0), nullptr);
    Drift out;
    for (std::size_t round = 1; round <= rounds; ++round) {
        const Geometry<D> geometry(at.curved.surrogate);
        at = remeshed<D>(layout(round), &geometry);
        (round == 1 ? out.first : out.last) = error_of<D>(at.mesh, off);
    }
    out.smooth = at.curved.patches.smooth;
    CHECK(at.curved.patches.as_read == 0);
    return out;
}

/// The distance of the degree-2 facets from the unit sphere and the enclosed volume.
struct Ball {
    double off = 0, volume = 0;
};
Ball ball_of(const QuadraticMesh<3>& mesh) {
    constexpr int n = 8;
    double squares = 0;
    std::size_t count = 0;
    Ball out;
    for (std::size_t f = 0; f < mesh.linear.facets.size(); ++f) {
        const auto own = facet_of(mesh, FacetId(f));
        const auto at = [&](int i, int j) {
            const double x = i / double{n}, y = j / double{n};
            return own.point(Barycentric<2>{1 - x - y, x, y});
        };
        const auto cone = [](const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) {
            return std::fabs(dot(a, cross(b, c))) / 6;
        };
        for (int i = 0; i <= n; ++i)
            for (int j = 0; i + j <= n; ++j) {
                const double off = norm(at(i, j)) - 1;
                squares += off * off;
                ++count;
                if (i + j < n) out.volume += cone(at(i, j), at(i + 1, j), at(i, j + 1));
                if (i + j + 1 < n) out.volume += cone(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            }
    }
    out.off = std::sqrt(squares / static_cast<double>(count));
    return out;
}

/// The mesh with its nodes on the unit sphere.
QuadraticMesh<3> exact(const LinearMesh<3>& layout) {
    QuadraticMesh<3> mesh = build(layout).mesh;
    auto nodes = take(std::move(mesh.mid_nodes));
    for (LagrangeNode<3>& node : nodes) node.point = normalised(node.point);
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

/// A polygon on an ellipse of half axes 2 and 1, at uneven angles.
LinearMesh<2> ellipse(std::size_t n, unsigned seed) {
    Random random(seed);
    std::vector<Vec<2>> points;
    for (std::size_t i = 0; i < n; ++i) {
        const double t = 2 * pi * (static_cast<double>(i) + random(-0.25, 0.25)) / static_cast<double>(n);
        points.push_back({{2 * std::cos(t), std::sin(t)}});
    }
    return polygon(std::move(points)).mesh();
}
double off_ellipse(const Vec<2>& p) {
    const double f = p[0] * p[0] / 4 + p[1] * p[1] - 1;
    return std::fabs(f) / norm(Vec<2>{{p[0] / 2, 2 * p[1]}});
}

}  // namespace

TEST_CASE("a boundary remeshed repeatedly does not drift in 3D") {
    const auto off = off_surface(Torus{{}, {{0, 0, 1}}, 3, 1});
    const auto layout = [](std::size_t round) {
        return torus(round % 2 == 0 ? 16 : 12, 3, 1, static_cast<unsigned>(round + 1)).mesh();
    };
    const Drift found = drift<3>(4, layout, off);
    MESSAGE("torus: ", found.first, " → ", found.last);
    CHECK(found.last < 1.3 * found.first);
    CHECK(found.smooth == 1);
}

// Guards against a remeshed boundary that drifts.
TEST_CASE("a sphere remeshed repeatedly stays as accurate as a mesh of the exact sphere") {
    constexpr std::size_t rounds = camber::testing::less_if_sanitized<std::size_t>(20, 4);
    const auto layout = [](std::size_t round) {
        return sphere(round % 2 == 0 ? 5 : 7, 1, static_cast<unsigned>(round + 1)).mesh();
    };
    Remeshing<3> at = remeshed<3>(layout(0), nullptr);
    Ball middle;
    for (std::size_t round = 1; round <= rounds; ++round) {
        const Geometry<3> geometry(at.curved.surrogate);
        at = remeshed<3>(layout(round), &geometry);
        if (round == rounds / 2) middle = ball_of(at.mesh);
    }
    const Ball last = ball_of(at.mesh), best = ball_of(exact(layout(rounds))),
               half = ball_of(exact(layout(rounds / 2)));
    MESSAGE("sphere: ", last.off, " beside ", best.off, "; volume less by ", best.volume - last.volume, ", before by ",
            half.volume - middle.volume);
    CHECK(last.off < 1.5 * best.off);
    CHECK(best.volume - last.volume < 2e-4);
    if (!camber::testing::is_sanitized)  // the error is not yet constant after few remeshings
        CHECK(std::fabs((best.volume - last.volume) - (half.volume - middle.volume)) < 2e-5);
}

TEST_CASE("a boundary remeshed repeatedly does not drift in 2D") {
    const auto layout = [](std::size_t round) {
        return ellipse(round % 2 == 0 ? 24 : 18, static_cast<unsigned>(round + 1));
    };
    const Drift found = drift<2>(12, layout, off_ellipse);
    MESSAGE("ellipse: ", found.first, " → ", found.last);
    CHECK(found.last < 2 * found.first);
    CHECK(found.smooth == 1);
}
