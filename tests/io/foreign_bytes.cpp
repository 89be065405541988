// Binary GMF files that the encoder does not write: every version in both byte orders.
#include "any_mesh.hpp"
#include "binary_file.hpp"
#include "generated.hpp"
#include "property.hpp"

#include <cstdint>
#include <variant>

using namespace camber;

namespace {

/// Two tetrahedra, a triangle, an edge, and a few features, with coordinates that fit 4 bytes.
BinaryFile sample(int version, bool swapped) {
    BinaryFile file(version, swapped);
    file.dimension(3);
    file.block(6, 1);  // before the vertices
    for (const int i : {1, 2, 3, -4}) file.integer(i);
    file.close();
    file.block(99, 2);  // elements of degree 4, none of them
    file.bytes.resize(file.bytes.size() - (version == 4 ? 8 : 4));
    file.integer(0);
    file.close();
    file.block(1234, 2);  // unknown
    for (const int i : {1, 2}) file.integer(i);
    file.close();
    file.block(4, 5);
    for (int v = 0; v < 5; ++v) {
        for (int c = 0; c < 3; ++c) file.real(v * 0.5 + c);
        file.integer(v);
    }
    file.close();
    file.block(8, 2);
    for (const int i : {1, 2, 3, 4, 10, 2, 3, 4, 5, 11}) file.integer(i);
    file.close();
    file.block(5, 1);
    for (const int i : {4, 5, 3}) file.integer(i);
    file.close();
    file.block(14, 1);
    file.integer(1);
    file.close();
    file.block(41, 1);
    for (const int i : {4, 9}) file.integer(i);
    for (const double x : {0.25, 0.0}) file.real(x);
    file.close();
    file.end();
    return file;
}

}  // namespace

TEST_CASE("GMF meshes of every version are read in either byte order") {
    for (const int version : {1, 2, 3, 4})
        for (const bool swapped : {false, true}) {
            CAPTURE(version);
            CAPTURE(swapped);
            const auto file = sample(version, swapped);
            const auto decoded = decode_gmf_mesh(file.bytes, "file", {});
            if (!decoded) FAIL(describe(decoded.error()));
            const auto& mesh = testing::mesh_in<LinearMesh<3>>(decoded->mesh);
            REQUIRE(mesh.points.size() == 5);
            CHECK(mesh.points[4] == Vec<3>{{2.0, 3.0, 4.0}});
            CHECK(mesh.point_references[4] == 4);
            REQUIRE(mesh.elements.size() == 2);
            CHECK(mesh.elements.vertices[1][3] == VertexId(std::size_t{4}));
            CHECK(mesh.elements.references[1] == 11);
            CHECK(mesh.facets.references[0] == -4);
            CHECK(mesh.edges.references[0] == 3);
            CHECK(mesh.ridges[0] == 0);
            CHECK(mesh.geometry.on_curves[0] == Association<1>{VertexId(std::size_t{3}), 9, {{0.25}}, 0.0});
            REQUIRE(decoded->notices.size() == 1);
            CHECK(decoded->notices[0].what == "the block of keyword 1234 was skipped");
        }
}

TEST_CASE("GMF solutions of every version are read in either byte order") {
    for (const int version : {1, 2, 3, 4})
        for (const bool swapped : {false, true}) {
            BinaryFile file(version, swapped);
            file.dimension(2);
            file.block(62, 2);
            for (const std::int32_t word : {2, 1, 3}) file.word(word);
            for (int i = 0; i < 8; ++i) file.real(i * 0.5);
            file.close();
            file.end();
            const auto decoded = decode_gmf_solution(file.bytes, "file", {});
            if (!decoded) FAIL(describe(decoded.error()));
            const Solution& solution = decoded->solution;
            CHECK(solution.single_precision == (version == 1));
            CHECK(solution.rows == 2);
            CHECK(solution.fields == std::vector{FieldKind::scalar, FieldKind::symmetric_tensor});
            REQUIRE(solution.values.size() == 8);
            for (int i = 0; i < 8; ++i) CHECK(solution.values[static_cast<std::size_t>(i)] == i * 0.5);
        }
}
