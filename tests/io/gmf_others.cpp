// GMF files as Mmg, Bamg and Metris write them: harmless deviations are read, other rows are left out and reported.
#include <doctest/doctest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <variant>

#include "any_mesh.hpp"
#include "generated.hpp"

import camber.core;
import camber.io;

using namespace camber;

namespace {

Outcome<DecodedMesh> read(const std::string& text) {
    return decode_gmf_mesh(generated::bytes_of(text), "in.mesh", {.threads = 1});
}
DecodedMesh decoded(const std::string& text) {
    auto result = read(text);
    INFO((result ? std::string() : describe(result.error())));
    REQUIRE(result.has_value());
    return std::move(*result);
}

const std::string body =
    "Dimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\nTetrahedra\n1\n1 2 3 4 1\nNormals\n2\n0 0 -1\n"
    "0 0 -1\nNormalAtVertices\n2\n1 1\n2 2\n";
const std::string head = "MeshVersionFormatted 2\n";

}  // namespace

TEST_CASE("tangents with an invalid vertex or direction are left out as a whole") {
    const DecodedMesh mesh = decoded(head + body + "Tangents\n1\n1 0 0\nTangentAtVertices\n2\n1 1\n2 2\nEnd\n");
    const auto& geometry = testing::mesh_in<LinearMesh<3>>(mesh.mesh).geometry;
    CHECK(geometry.normals.at.size() == 2);
    CHECK(geometry.tangents == DirectionsAtVertices<3>{});
    REQUIRE(mesh.notices.size() == 1);
    CHECK(mesh.notices[0].what ==
          "2 rows of TangentAtVertices were left out: not all of them refer to a vertex and a direction of the file");
    // A missing table, a missing vertex and an invalid direction.
    for (const std::string rows : {"TangentAtVertices\n1\n1 1\n", "Tangents\n1\n1 0 0\nTangentAtVertices\n1\n5 1\n",
                                   "Tangents\n2\n1 0 0\nnan 0 0\nTangentAtVertices\n1\n1 1\n"})
        CHECK(testing::mesh_in<LinearMesh<3>>(decoded(head + body + rows + "End\n").mesh).geometry.tangents ==
              DirectionsAtVertices<3>{});
    const DecodedMesh right = decoded(head + body + "Tangents\n1\n1 0 0\nTangentAtVertices\n1\n1 1\nEnd\n");
    CHECK(testing::mesh_in<LinearMesh<3>>(right.mesh).geometry.tangents.at.size() == 1);
    CHECK(right.notices.empty());
}

TEST_CASE("the index 0 of corners and required entities is ignored with a notice") {
    const DecodedMesh mesh = decoded(head + body + "Corners\n3\n0\n2\n0\nRequiredVertices\n1\n0\nEnd\n");
    CHECK(testing::mesh_in<LinearMesh<3>>(mesh.mesh).corners == Column<VertexId>(Buffer<VertexId>{VertexId(1)}));
    REQUIRE(mesh.notices.size() == 2);
    CHECK(mesh.notices[0].what == "2 rows of Corners have the index 0 and were left out");
    CHECK(describe(read(head + body + "Corners\n1\n5\nEnd\n").error()).find("the index 5 is not between 1 and 4") < 60);
    CHECK(!read(head + body + "Corners\n1\n-1\nEnd\n"));
}

TEST_CASE("GMF files without version, with version 0 or without End are read") {
    const auto mesh = decoded(head + body + "End\n").mesh;
    const DecodedMesh of_bamg = decoded("MeshVersionFormatted 0\n" + body + "End\n");
    CHECK(of_bamg.mesh == mesh);
    CHECK(of_bamg.notices.empty());
    const DecodedMesh without = decoded(body + "End\n");
    CHECK(without.mesh == mesh);
    REQUIRE(without.notices.size() == 1);
    CHECK(without.notices[0].what == "the file does not begin with MeshVersionFormatted, but was read as GMF");
    CHECK(is_gmf_ascii(generated::bytes_of(body)));
    const DecodedMesh endless = decoded(head + body);
    CHECK(endless.mesh == mesh);
    REQUIRE(endless.notices.size() == 1);
    CHECK(endless.notices[0].what == "the file has no keyword End, so it may be incomplete");
    CHECK(!read(head + body.substr(0, body.size() - 1)));
    CHECK(!read(head + body.substr(0, body.size() - 4)));
    CHECK(!read("MeshVersionFormatted 5\n" + body + "End\n"));
}

TEST_CASE("quoted texts are not read as keywords") {
    const DecodedMesh mesh = decoded(head + "Identifier\n\"G=a.mesh; Date: 21/04/02 Vertices 1s\"\n" + body + "End\n");
    REQUIRE(mesh.notices.size() == 1);
    CHECK(mesh.notices[0].what == "the block of keyword Identifier was skipped");
    CHECK(testing::mesh_in<LinearMesh<3>>(mesh.mesh).points.size() == 4);
}

TEST_CASE("edges from a vertex to itself are left out with their ridge and required entries") {
    const DecodedMesh mesh = decoded(
        head + body + "Edges\n4\n1 1 5\n1 2 6\n3 3 7\n2 3 8\nRidges\n3\n1\n2\n4\nRequiredEdges\n2\n3\n4\nEnd\n");
    const auto& read = testing::mesh_in<LinearMesh<3>>(mesh.mesh);
    CHECK(read.edges.references == Column<Reference>(Buffer<Reference>{6, 8}));
    CHECK(read.ridges == Column<std::uint32_t>(Buffer<std::uint32_t>{0, 1}));
    CHECK(read.edges.required == Column<std::uint32_t>(Buffer<std::uint32_t>{1}));
    REQUIRE(mesh.notices.size() == 1);
    CHECK(mesh.notices[0].what == "2 edges from a vertex to itself were left out: they have no length");
}

TEST_CASE("unsupported GMF cells are counted on request") {
    const std::string text = head + body + "Hexahedra 12 1 2 3\nPrisms 1 1\nEnd\n";
    const auto counted =
        decode_gmf_mesh(generated::bytes_of(text), "in.mesh", {.unsupported_cells = UnsupportedCells::count}, {});
    REQUIRE(counted.has_value());
    CHECK(counted->unsupported_cells == std::vector<CellCount>{{"Hexahedra", 12}, {"Prisms", 1}});
    CHECK(testing::mesh_in<LinearMesh<3>>(counted->mesh).elements.size() == 1);
}
