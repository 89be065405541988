#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "mesh_checks.hpp"
#include "property.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

/// Points with whole coordinates below `size`: the grid of `delaunay` represents small ones exactly, and many lie on a
/// common plane or sphere.
template <int D>
std::vector<Vec<D>> whole_points(int size, std::size_t most) {
    std::vector<Vec<D>> points;
    const auto count = *rc::gen::inRange<std::size_t>(D + 1, most);
    for (std::size_t k = 0; k < count; ++k) {
        Vec<D> p;
        for (int i = 0; i < D; ++i) p[i] = *rc::gen::inRange(0, size);
        if (std::find(points.begin(), points.end(), p) == points.end()) points.push_back(p);
    }
    return points;
}

/// Squared distance of q from the sphere's centre less its squared radius, times the determinant, by solving for the
/// centre. For small whole numbers long double is exact.
long double power(const std::vector<Vec<3>>& p, const SimplexVertices<3>& s, const Vec<3>& q) {
    long double m[3][3], r[3];
    const auto at = [&](const Vec<3>& v, int i) { return static_cast<long double>(v[i] - p[s[0].index()][i]); };
    for (int k = 0; k < 3; ++k) {
        r[k] = 0;
        for (int i = 0; i < 3; ++i) {
            m[k][i] = at(p[s[k + 1].index()], i);
            r[k] += m[k][i] * m[k][i];
        }
    }
    const auto determinant3 = [](const long double(&a)[3][3]) {
        return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) - a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
               a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
    };
    const long double d = determinant3(m);
    long double sum = 0;
    for (int i = 0; i < 3; ++i) {
        long double column[3][3];
        for (int k = 0; k < 3; ++k)
            for (int j = 0; j < 3; ++j) column[k][j] = j == i ? r[k] : m[k][j];
        sum += at(q, i) * at(q, i) * d - at(q, i) * determinant3(column);  // 2 centre_i d = det with column i replaced
    }
    return sum / (d > 0 ? 1.0L : -1.0L);
}

template <int D>
LinearMesh<D> as_mesh(const std::vector<Vec<D>>& points, Buffer<SimplexVertices<D>> elements) {
    LinearMesh<D> mesh;
    mesh.points = Buffer<Vec<D>>(points.begin(), points.end());
    mesh.elements.vertices = std::move(elements);
    return mesh;
}

}  // namespace

TEST_CASE("no point is inside the circumsphere of a tetrahedron") {
    property("circumspheres of tetrahedra are empty", [] {
        const auto points = whole_points<3>(*rc::gen::element(4, 1000), 40);
        const auto elements = delaunay<3>(points, Noise{3});
        if (!elements) return;  // flat
        const auto mesh = as_mesh(points, *elements);
        for (const auto& s : *elements) {
            RC_ASSERT(determinant(mesh.points, s) > 0);
            for (const auto& q : points) RC_ASSERT(power(points, s, q) >= 0);
        }
        RC_ASSERT(euler_characteristic(mesh) == 1);
    });
}

TEST_CASE("triangles of points in the plane are positive and form a disc") {
    property("2D", [] {
        const auto points = whole_points<2>(*rc::gen::element(4, 1000), 40);
        const auto elements = delaunay<2>(points, Noise{3});
        if (!elements) return;
        const auto mesh = as_mesh(points, *elements);
        for (const auto& s : *elements) RC_ASSERT(determinant(mesh.points, s) > 0);
        RC_ASSERT(euler_characteristic(mesh) == 1);
    });
}

TEST_CASE("the triangulation of a regular lattice fills its cube") {
    std::vector<Vec<3>> points;
    for (int k = 0; k < 216; ++k) points.push_back({{k % 6 + 0.0, k / 6 % 6 + 0.0, k / 36 + 0.0}});
    for (const std::uint64_t seed : {1, 2, 3}) {
        const auto elements = delaunay<3>(points, Noise{seed});
        REQUIRE(elements.has_value());
        const auto mesh = as_mesh(points, *elements);
        for (const auto& s : *elements) CHECK(determinant(mesh.points, s) > 0);
        CHECK(total_volume(mesh) == doctest::Approx(125));
        CHECK(euler_characteristic(mesh) == 1);
    }
}

TEST_CASE("flat and repeated points are rejected") {
    const std::vector<Vec<3>> flat{{{0, 0, 1}}, {{1, 0, 1}}, {{0, 1, 1}}, {{1, 1, 1}}, {{2, 1, 1}}};
    CHECK(delaunay<3>(flat, Noise{}).error().kind == ErrorKind::usage);
    const std::vector<Vec<3>> twice{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}, {{1, 0, 0}}};
    CHECK(delaunay<3>(twice, Noise{}).error().entity->number == 5);
    CHECK_FALSE(delaunay<2>(std::vector<Vec<2>>{}, Noise{}).has_value());
}
