// Inspection beyond verdicts: elements with two faces on one wall (compared with faces matched by sorting), coincident
// nodes, open boundaries, and minima of det J.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

import camber.core;
import camber.bezier;
import camber.validity;
import camber.optimisation;
import camber.soundness;

#include "generators.hpp"

using namespace camber;
using namespace generators;
using camber::testing::property;

namespace {

const Execution one_thread{.threads = 1};

/// A lattice with displaced points, including those of the boundary.
template <int D>
LinearMesh<D> displaced_lattice(std::mt19937_64& random, int n, double amplitude) {
    LinearMesh<D> mesh = lattice_mesh<D>(n);
    auto points = take(std::move(mesh.points));
    for (auto& p : points)
        for (int c = 0; c < D; ++c) p[c] += uniform(random, -amplitude, amplitude);
    mesh.points = std::move(points);
    return mesh;
}

template <std::size_t N>
std::array<VertexId, N> sorted(std::array<VertexId, N> v) {
    std::sort(v.begin(), v.end());
    return v;
}

/// The unit normal of the face opposite vertex i, away from that vertex.
Vec<2> outward(const std::array<Vec<2>, 3>& p, int i) {
    const Vec<2> a = p[(i + 1) % 3], along = p[(i + 2) % 3] - a;
    Vec<2> n{{along[1], -along[0]}};
    if (dot(n, p[i] - a) > 0) n *= -1;
    return normalised(n);
}
Vec<3> outward(const std::array<Vec<3>, 4>& p, int i) {
    const Vec<3> a = p[(i + 1) % 4];
    Vec<3> n = cross(p[(i + 2) % 4] - a, p[(i + 3) % 4] - a);
    if (dot(n, p[i] - a) > 0) n *= -1;
    return normalised(n);
}

/// The same by definition: elements with two boundary faces whose normals differ by less than the angle.
template <int D>
std::vector<std::size_t> walls_by_definition(const LinearMesh<D>& mesh, double degrees) {
    std::map<std::array<VertexId, D>, int> owners;
    const auto face = [&](std::size_t e, int i) {
        std::array<VertexId, D> f;
        for (int k = 0, n = 0; k <= D; ++k)
            if (k != i) f[n++] = mesh.elements.vertices[e][k];
        return sorted(f);
    };
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        for (int i = 0; i <= D; ++i) ++owners[face(e, i)];
    std::vector<std::size_t> found;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        std::array<Vec<D>, D + 1> p;
        for (int i = 0; i <= D; ++i) p[i] = mesh.points[mesh.elements.vertices[e][i]];
        bool on_wall = false;
        for (int i = 0; i <= D; ++i)
            for (int j = 0; j < i; ++j)
                if (owners[face(e, i)] == 1 && owners[face(e, j)] == 1)
                    on_wall =
                        on_wall || std::acos(dot(outward(p, i), outward(p, j))) * 180 / std::numbers::pi < degrees;
        if (on_wall) found.push_back(e);
    }
    return found;
}

template <int D>
void test_walls() {
    property("examine lists exactly the elements with two faces on one wall, " + std::to_string(D) + "D",
             [] {
                 auto random = random_source();
                 auto mesh = displaced_lattice<D>(random, 2, 0.1);
                 const double degrees = uniform(random, 60, 120);
                 const auto found = *examine(as_mesh(mesh), ExamineOptions{degrees}, one_thread);
                 const auto again = walls_by_definition(mesh, degrees);
                 std::vector<std::size_t> listed;
                 listed.reserve(found.wall_elements.size());
                 for (const WallElement& wall : found.wall_elements) listed.push_back(wall.element.index());
                 RC_ASSERT(listed == again);
                 RC_ASSERT(found[Defect::wall_element].count == again.size());
                 RC_ASSERT(found.sound() == examine(as_mesh(mesh), one_thread)->sound());  // wall elements do not
                                                                                           // affect soundness
                 // With different references no two facets form one wall.
                 Buffer<Reference> references(mesh.facets.size());
                 for (std::size_t f = 0; f < references.size(); ++f) references[f] = static_cast<Reference>(f);
                 mesh.facets.references = std::move(references);
                 RC_ASSERT(examine(as_mesh(mesh), ExamineOptions{degrees}, one_thread)->wall_elements.empty());
             },
             {.count = 20});
}

template <int D>
void test_nodes() {
    property("examine finds a node at the position of another one, " + std::to_string(D) + "D",
             [] {
                 auto random = random_source();
                 auto mesh = *elevate(displaced_lattice<D>(random, 2, 0.1), one_thread);
                 RC_ASSERT((*examine(as_mesh(mesh), one_thread))[Defect::coincident_node] == Finding{});
                 const std::size_t vertices = mesh.linear.points.size();
                 const std::size_t edge = random() % mesh.edges.size();
                 std::size_t other = random() % (vertices + mesh.edges.size());
                 if (other == vertices + edge) other = 0;
                 auto nodes = take(std::move(mesh.mid_nodes));
                 nodes[edge].point = other < vertices ? mesh.linear.points[other] : nodes[other - vertices].point;
                 mesh.mid_nodes = std::move(nodes);
                 const auto found = *examine(as_mesh(mesh), one_thread);
                 const std::size_t high = std::max(vertices + edge, other) + 1,
                                   low = std::min(vertices + edge, other) + 1;
                 RC_ASSERT((found[Defect::coincident_node] == Finding{1, high, low}));
                 RC_ASSERT(!found.sound());
             },
             {.count = 30});
}

template <int D>
void test_lowest() {
    property("no sample of det J is below lowest_point, " + std::to_string(D) + "D",
             [] {
                 auto random = random_source();
                 const BoundedJacobian<D> jacobian = bounded_jacobian(element<D>(random, uniform(random, 0, 0.5)));
                 const auto at = [&](const Barycentric<D>& xi) {
                     double value = 0;
                     for (int p = 0; p < jacobian_coefficients<D>; ++p)
                         value += jacobian.coefficients[p] * bernstein<D>(jacobian_indices<D>[p], xi);
                     return value;
                 };
                 const MinJacobianPoint<D> lowest = min_jacobian_point(jacobian);
                 double sum = 0;
                 for (const double x : lowest.at) {
                     RC_ASSERT(x >= 0);
                     sum += x;
                 }
                 RC_ASSERT(std::abs(sum - 1) < 1e-12);
                 RC_ASSERT(std::abs(at(lowest.at) - lowest.jacobian) < 1e-12);
                 // min_jacobian_point has a tolerance of 1e-3
                 const double slack = 1.001e-3 * std::max(std::abs(jacobian.straight), std::abs(lowest.jacobian));
                 for (int i = 0; i < 200; ++i) RC_ASSERT(at(point_inside<D>(random)) > lowest.jacobian - slack);
             },
             {.count = 100});
}

}  // namespace

TEST_CASE("examine lists elements with two faces on one wall") {
    test_walls<2>();
    test_walls<3>();
}

namespace {

/// A tetrahedron with two nearly coplanar faces at the edge of its vertices 0 and 1.
LinearMesh<3> shallow_tetrahedron() {
    LinearMesh<3> mesh;
    const auto v = [](std::size_t i) { return VertexId(i); };
    mesh.points = Buffer<Vec<3>>{{{0, 0, 0}}, {{1, 0, 0}}, {{0.5, 1, -0.05}}, {{0.5, -1, -0.3}}};
    mesh.point_references = Buffer<Reference>(4, 0);
    mesh.elements.vertices = Buffer<SimplexVertices<3>>{{v(0), v(2), v(1), v(3)}};
    mesh.elements.references = Buffer<Reference>{1};
    mesh.facets.vertices =
        Buffer<SimplexVertices<2>>{{v(0), v(1), v(2)}, {v(1), v(0), v(3)}, {v(0), v(2), v(3)}, {v(1), v(3), v(2)}};
    mesh.facets.references = Buffer<Reference>{1, 1, 1, 1};
    return mesh;
}

}  // namespace

// Guards against smooth listed edges that end a wall.
TEST_CASE("ridges and changes of reference end a wall, smooth listed edges do not") {
    const ExamineOptions options{.ridge_angle_degrees = 30};
    const std::vector<WallElement> whole{{ElementId(0), {VertexId(0), VertexId(1)}}};
    auto mesh = shallow_tetrahedron();
    CHECK(examine(as_mesh(mesh), options, one_thread)->wall_elements == whole);
    mesh.edges.vertices = Buffer<SimplexVertices<1>>{{VertexId(0), VertexId(2)}, {VertexId(1), VertexId(0)}};
    mesh.edges.references = Buffer<Reference>{1, 1};
    CHECK(examine(as_mesh(mesh), options, one_thread)->wall_elements == whole);  // listed, but no ridge
    mesh.corners = Buffer<VertexId>{VertexId(0), VertexId(1)};
    CHECK(examine(as_mesh(mesh), options, one_thread)->wall_elements == whole);
    mesh.ridges = Buffer<std::uint32_t>{0};
    CHECK(examine(as_mesh(mesh), options, one_thread)->wall_elements == whole);  // another ridge
    mesh.ridges = Buffer<std::uint32_t>{1};
    CHECK(examine(as_mesh(mesh), options, one_thread)->wall_elements.empty());
    mesh.ridges = {};
    mesh.facets.references = Buffer<Reference>{1, 2, 1, 1};
    CHECK(examine(as_mesh(mesh), options, one_thread)->wall_elements.empty());
}

TEST_CASE("corners and the ends of ridges end a wall in 2D") {
    const auto v = [](std::size_t i) { return VertexId(i); };
    LinearMesh<2> flat;
    flat.points = Buffer<Vec<2>>{{{0, 0}}, {{1, 0}}, {{0.5, 0.1}}};
    flat.point_references = Buffer<Reference>(3, 0);
    flat.elements.vertices = Buffer<SimplexVertices<2>>{{v(0), v(1), v(2)}};
    flat.elements.references = Buffer<Reference>{1};
    flat.facets.vertices = Buffer<SimplexVertices<1>>{{v(0), v(1)}, {v(1), v(2)}, {v(2), v(0)}};
    flat.facets.references = Buffer<Reference>{1, 1, 1};
    REQUIRE(examine(as_mesh(flat), one_thread)->wall_elements.size() == 1);
    auto other = flat;
    other.corners = Buffer<VertexId>{v(2)};
    CHECK(examine(as_mesh(other), one_thread)->wall_elements.empty());
    other = flat;
    other.ridges = Buffer<std::uint32_t>{0};
    CHECK(examine(as_mesh(other), one_thread)->wall_elements.size() == 1);
    other.ridges = Buffer<std::uint32_t>{1};
    CHECK(examine(as_mesh(other), one_thread)->wall_elements.empty());
}

TEST_CASE("examine finds coincident nodes") {
    test_nodes<2>();
    test_nodes<3>();
}

TEST_CASE("examine counts all nodes and vertices at one position") {
    auto mesh = *elevate(lattice_mesh<3>(12), one_thread);
    Buffer<LagrangeNode<3>> nodes(mesh.edges.size());
    std::fill(nodes.begin(), nodes.end(), LagrangeNode<3>{{{0.5, 0.25, 0.125}}});
    mesh.mid_nodes = std::move(nodes);
    CHECK((*examine(as_mesh(mesh), one_thread))[Defect::coincident_node].count == mesh.edges.size() - 1);
    Buffer<Vec<3>> points(mesh.linear.points.size());
    std::fill(points.begin(), points.end(), Vec<3>{});
    mesh.linear.points = std::move(points);
    const auto found = *examine(as_mesh(mesh), one_thread);
    CHECK(found[Defect::duplicate_vertex].count + found[Defect::slit_vertex].count == mesh.linear.points.size() - 1);
}

TEST_CASE("examine counts the open edges of a surface") {
    for (const int left_out : {0, 1, 2}) {
        LinearMesh<3> mesh = lattice_mesh<3>(2);
        mesh.elements = {};
        Buffer<SimplexVertices<2>> facets(mesh.facets.vertices.begin(), mesh.facets.vertices.end() - left_out);
        mesh.facets.references =
            Buffer<Reference>(mesh.facets.references.begin(), mesh.facets.references.end() - left_out);
        // By definition: edges with one facet.
        std::map<std::array<VertexId, 2>, int> owners;
        for (const auto& f : facets)
            for (const auto& [a, b] : local_edges<2>) ++owners[sorted(std::array{f[a], f[b]})];
        const auto open = std::count_if(owners.begin(), owners.end(), [](const auto& e) { return e.second == 1; });
        CHECK((open > 0) == (left_out > 0));
        mesh.facets.vertices = std::move(facets);
        const auto found = *examine(as_mesh(mesh), one_thread);
        CHECK(found[Defect::open_edge].count == static_cast<std::size_t>(open));
        CHECK(found.sound());
    }
}

TEST_CASE("lowest_point returns the minimum of the Jacobian") {
    test_lowest<2>();
    test_lowest<3>();
}
