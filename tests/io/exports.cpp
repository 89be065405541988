// Tests of the export formats: STL of the boundary, and XDMF.
#include <doctest/doctest.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>
#include <vector>

#include "generated.hpp"

import camber.core;
import camber.bezier;
import camber.io;

using namespace camber;

namespace {

/// Two tetrahedra with a common face, one of them inverted; one face is listed.
LinearMesh<3> two_tetrahedra() {
    LinearMesh<3> mesh;
    mesh.points = Buffer<Vec<3>>{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}, {{1, 1, 1}}};
    mesh.point_references = Buffer<Reference>(5, 0);
    const auto v = [](std::size_t i) { return VertexId(i); };
    mesh.elements.vertices = Buffer<SimplexVertices<3>>{{v(0), v(1), v(2), v(3)}, {v(2), v(1), v(3), v(4)}};
    mesh.elements.references = Buffer<Reference>{1, 2};
    mesh.facets.vertices = Buffer<SimplexVertices<2>>{{v(0), v(1), v(2)}};
    mesh.facets.references = Buffer<Reference>{7};
    mesh.groups = Buffer<Group>{{2, 7, "the floor"}};
    return mesh;
}

struct Triangle {
    double normal[3], corners[3][3];
};

/// An independent reader of text STL.
std::vector<Triangle> triangles_of(const std::string& text) {
    std::istringstream words(text);
    std::vector<Triangle> triangles;
    std::string word;
    while (words >> word) {
        if (word != "normal") continue;
        Triangle t{};
        for (double& x : t.normal) words >> x;
        for (auto& corner : t.corners) {
            while (words >> word && word != "vertex") {
            }
            for (double& x : corner) words >> x;
        }
        triangles.push_back(t);
    }
    return triangles;
}
/// Volume by the divergence theorem; correct only if all triangles face outwards.
double volume_of(const std::vector<Triangle>& triangles) {
    double sum = 0;
    for (const Triangle& t : triangles) {
        const auto& [a, b, c] = t.corners;
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum / 6;
}

std::size_t count(const std::string& text, const std::string& what) {
    std::size_t n = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
    return n;
}

}  // namespace

TEST_CASE("STL of a volume mesh is its closed outward boundary with one solid per reference") {
    const auto mesh = two_tetrahedra();
    const std::string text = generated::text_of(generated::joined(*encode_stl(as_mesh(mesh), StlEncoding::ascii, {})));
    const auto triangles = triangles_of(text);
    CHECK(triangles.size() == 6);
    CHECK(volume_of(triangles) == doctest::Approx(1.0 / 6 + 1.0 / 3));
    CHECK(text.starts_with("solid reference_0\n"));
    CHECK(count(text, "solid the floor\n") == 2);  // with endsolid
    const auto curved = *elevate(mesh, {});
    const auto four =
        triangles_of(generated::text_of(generated::joined(*encode_stl(as_mesh(curved), StlEncoding::ascii, {}))));
    CHECK(four.size() == 24);
    CHECK(volume_of(four) == doctest::Approx(1.0 / 6 + 1.0 / 3));
    const auto binary = generated::joined(*encode_stl(as_mesh(mesh), StlEncoding::binary, {}));
    CHECK(binary.size() == 84 + 50 * 6);
    CHECK(is_stl(binary, StlEncoding::binary));
    float normal[3]{};
    std::memcpy(normal, binary.data() + 84, sizeof normal);
    CHECK(std::hypot(normal[0], normal[1], normal[2]) == doctest::Approx(1));
    const auto losses = not_in_stl(as_mesh(mesh), StlEncoding::binary);
    REQUIRE(losses.size() == 2);
    CHECK(losses[0].what == "STL has no place for 2 tetrahedra: the boundary is written");
    CHECK(losses[1].what == "STL in binary has no place for references");
}

TEST_CASE("STL of a surface or 2D mesh lists all triangles") {
    LinearMesh<3> surface = two_tetrahedra();
    surface.elements = {};
    CHECK(triangles_of(generated::text_of(generated::joined(*encode_stl(as_mesh(surface), StlEncoding::ascii, {}))))
              .size() == 1);
    LinearMesh<2> flat;
    flat.points = Buffer<Vec<2>>{{{0, 0}}, {{1, 0}}, {{0, 1}}};
    flat.point_references = Buffer<Reference>(3, 0);
    flat.elements.vertices = Buffer<SimplexVertices<2>>{{VertexId(0), VertexId(1), VertexId(2)}};
    flat.elements.references = Buffer<Reference>{1};
    const auto triangles =
        triangles_of(generated::text_of(generated::joined(*encode_stl(as_mesh(flat), StlEncoding::ascii, {}))));
    REQUIRE(triangles.size() == 1);
    CHECK(triangles[0].normal[2] == 1);
    CHECK(generated::joined(*encode_stl(as_mesh(LinearMesh<3>{}), StlEncoding::ascii, {})).size() > 0);
    CHECK(generated::joined(*encode_stl(as_mesh(LinearMesh<3>{}), StlEncoding::binary, {})).size() == 84);
}

TEST_CASE("XDMF items declare the dimensions of their data") {
    const auto mesh = two_tetrahedra();
    const auto fields =
        MeshFields{}
            .with({"T & co", Centring::node, FieldKind::scalar, Column<double>(Buffer<double>{0.5, 1, 1.5, 2, 2.5})})
            .with({"M", Centring::cell, FieldKind::symmetric_tensor, Column<double>(Buffer<double>(18, 0.25))});
    const std::string text = generated::text_of(generated::joined(*encode_xdmf(as_mesh(mesh), fields, {})));
    CHECK(is_xdmf(generated::bytes_of(text)));
    CHECK(text.find("<Topology TopologyType=\"Mixed\" NumberOfElements=\"3\">\n<DataItem DataType=\"Int\" "
                    "Dimensions=\"14\" Format=\"XML\" Precision=\"8\">\n6 0 1 2 3\n6 2 1 3 4\n4 0 1 2\n") <
          text.size());
    CHECK(text.find("Name=\"T &amp; co\" AttributeType=\"Scalar\" Center=\"Node\">\n<DataItem DataType=\"Float\" "
                    "Dimensions=\"5\" Format=\"XML\" Precision=\"8\">\n0.5\n1\n1.5\n2\n2.5\n") < text.size());
    CHECK(text.find("Name=\"M\" AttributeType=\"Tensor\" Center=\"Cell\">\n<DataItem DataType=\"Float\" "
                    "Dimensions=\"3 9\"") < text.size());
    const auto curved = *elevate(mesh, {});
    const std::string second = generated::text_of(generated::joined(*encode_xdmf(as_mesh(curved), {}, {})));
    CHECK(second.find("TopologyType=\"Tetrahedron_10\" NumberOfElements=\"2\"") < second.size());
    REQUIRE(not_in_xdmf(as_mesh(curved)).size() == 2);
    CHECK(not_in_xdmf(as_mesh(curved))[1].what ==
          "XDMF allows only one kind of cells of degree 2 in a grid: 1 facets are left out");
}
