// Tables of shapes: topology, orientation and numbers of nodes.
#include <doctest/doctest.h>

#include <array>
#include <cstddef>
#include <map>
#include <utility>

import camber.core;

using namespace camber;

namespace {

template <class F>
void each_solid(const F& f) {
    f.template operator()<Shape::tetrahedron>();
    f.template operator()<Shape::prism>();
    f.template operator()<Shape::pyramid>();
    f.template operator()<Shape::hexahedron>();
}

int corners_of(const ShapeFace& face) { return face.shape == Shape::triangle ? 3 : 4; }

Vec<3> corner(const ShapeTable& table, int c) {
    const auto& x = table.coordinates[c];
    return {{double(x[0]), double(x[1]), double(x[2])}};
}

}  // namespace

TEST_CASE("the faces of a solid meet in its edges, once in each direction") {
    each_solid([]<Shape shape>() {
        constexpr ShapeTable table = shape_table<shape>;
        CHECK(table.corner_count - table.edge_count + table.face_count == 2);
        std::map<std::pair<int, int>, int> uses;
        for (int f = 0; f < table.face_count; ++f) {
            const ShapeFace& face = table.faces[f];
            for (int i = 0; i < corners_of(face); ++i)
                ++uses[{face.corners[i], face.corners[(i + 1) % corners_of(face)]}];
        }
        CHECK(uses.size() == static_cast<std::size_t>(2 * table.edge_count));
        for (int e = 0; e < table.edge_count; ++e) {
            const auto [a, b] = table.edges[e];
            CHECK(uses[{a, b}] == 1);
            CHECK(uses[{b, a}] == 1);
        }
    });
}

TEST_CASE("the normals of the faces of a solid point outwards") {
    each_solid([]<Shape shape>() {
        constexpr ShapeTable table = shape_table<shape>;
        Vec<3> centre;
        for (int c = 0; c < table.corner_count; ++c) centre += corner(table, c) / table.corner_count;
        for (int f = 0; f < table.face_count; ++f) {
            const auto& corners = table.faces[f].corners;
            const Vec<3> a = corner(table, corners[0]), b = corner(table, corners[1]), c = corner(table, corners[2]);
            CHECK(dot(cross(b - a, c - a), a - centre) > 0);
        }
    });
}

TEST_CASE("tables of simplices agree with those of meshes") {
    const auto check = []<int K>() {
        constexpr ShapeTable table = shape_table<simplex<K>>;
        CHECK(table.edge_count == edges_per_simplex<K>);
        for (int e = 0; e < edges_per_simplex<K>; ++e) CHECK(table.edges[e] == local_edges<K>[e]);
        if constexpr (K == 3)
            for (int i = 0; i <= K; ++i)
                for (std::size_t k = 0; k < 3; ++k) CHECK(table.faces[i].corners[k] == face_opposite<3>(i)[k]);
    };
    check.template operator()<1>();
    check.template operator()<2>();
    check.template operator()<3>();
}

TEST_CASE("complete elements have the numbers of nodes of their polynomial spaces") {
    const auto check = []<int k>() {
        CHECK(element_nodes<Shape::line, k> == k + 1);
        CHECK(element_nodes<Shape::triangle, k> == (k + 1) * (k + 2) / 2);
        CHECK(element_nodes<Shape::quadrilateral, k> == (k + 1) * (k + 1));
        CHECK(element_nodes<Shape::tetrahedron, k> == (k + 1) * (k + 2) * (k + 3) / 6);
        CHECK(element_nodes<Shape::prism, k> == (k + 1) * (k + 1) * (k + 2) / 2);
        CHECK(element_nodes<Shape::pyramid, k> == (k + 1) * (k + 2) * (2 * k + 3) / 6);
        CHECK(element_nodes<Shape::hexahedron, k> == (k + 1) * (k + 1) * (k + 1));
    };
    check.template operator()<1>();
    check.template operator()<2>();
    check.template operator()<3>();
    check.template operator()<4>();
    check.template operator()<5>();
}
