// Each error gives the cause, the position and the entity.
#include "any_mesh.hpp"
#include "binary_file.hpp"
#include "generated.hpp"
#include "property.hpp"

#include <stop_token>
#include <string>
#include <variant>

using namespace camber;

namespace {

std::string message(const std::string& text) {
    const auto decoded = decode_gmf_mesh(generated::bytes_of(text), "in.mesh", {});
    return decoded ? "no error" : describe(decoded.error());
}

ErrorKind kind(const std::string& text) {
    const auto decoded = decode_gmf_mesh(generated::bytes_of(text), "in.mesh", {});
    return decoded ? ErrorKind::internal : decoded.error().kind;
}

const std::string head = "MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n";

}  // namespace

TEST_CASE("invalid GMF headers are rejected with line and reason") {
    CHECK(message("") == "in.mesh: byte 0: the file is empty (write it again)");
    CHECK(message("solid cube").starts_with("in.mesh: line 1: this is not a GMF file"));
    CHECK(message("MeshVersionFormatted 5 Dimension 3 End")
              .starts_with("in.mesh: line 1: the GMF version is not 1 to 4"));
    CHECK(message("MeshVersionFormatted 2\nVertices 0\nEnd") ==
          "in.mesh: line 1: the file has no Dimension (the file is damaged, or is not a GMF file)");
    CHECK(message("MeshVersionFormatted 2\nDimension 4\nEnd") ==
          "in.mesh: line 1: Dimension is 4, not 2 or 3 (Camber reads meshes in 2D and 3D)");
    CHECK(message("MeshVersionFormatted 2\nDimension 3\nEnd") ==
          "in.mesh: line 1: the file has no Vertices (give a mesh)");
    CHECK(message("MeshVersionFormatted 2 Dimension 3 SolAtVertices 1 1 1 0.5 End") ==
          "in.mesh: line 1: the file contains a solution, not a mesh (give a mesh)");
    CHECK(message("MeshVersionFormatted 2 Dimension x End") ==
          "in.mesh: line 1: Dimension is not followed by a valid number");
    CHECK(message(head.substr(0, head.size() - 1)) ==
          "in.mesh: line 7: the file ends before the keyword End (it seems to be cut off)");
    CHECK(message("MeshVersionFormatted 2 Dimension 3 Vertices 0 BezierBasis 2 End")
              .ends_with("BezierBasis is 2, not 0 or 1"));
}

TEST_CASE("invalid GMF rows are rejected with line and entity") {
    CHECK(message("MeshVersionFormatted 2 Dimension 2 Vertices 2\n0 0 0\n0 nan 0\nEnd") ==
          "in.mesh: line 3: vertex 2: a value is infinite or not a number (the program that wrote the file failed "
          "there. Write it again)");
    CHECK(message("MeshVersionFormatted 2 Dimension 2 Vertices 2\n0 0 0\n0 1e999 0\nEnd") ==
          "in.mesh: line 3: vertex 2: a value is infinite or not a number (the program that wrote the file failed "
          "there. Write it again)");
    CHECK(message("MeshVersionFormatted 2 Dimension 2 Vertices 2\n0 0 0\n0 -Infinity 0\nEnd") ==
          "in.mesh: line 3: vertex 2: a value is infinite or not a number (the program that wrote the file failed "
          "there. Write it again)");
    CHECK(message("MeshVersionFormatted 2 Dimension 2 Vertices 2\n0 0 0\n0 1.2.3 0\nEnd") ==
          "in.mesh: line 3: vertex 2: a number is malformed, or too large for its kind (the file is damaged, or a row "
          "before has too few or too many numbers)");
    CHECK(message("MeshVersionFormatted 2 Dimension 2 Vertices 1\n0 0 3000000000\nEnd") ==
          "in.mesh: line 2: vertex 1: the reference 3000000000 does not fit 32 bits (use smaller references)");
    CHECK(message("MeshVersionFormatted 2 Dimension 2 Vertices 2\n0 0 0\nEnd") ==
          "in.mesh: line 1: Vertices announces 2 rows of 3 numbers, but 3 follow (the file is cut off or its count is "
          "wrong)");
    CHECK(message(head + "Tetrahedra 2\n1 2 3 4 0\n1 2 3 5 0\nEnd") ==
          "in.mesh: line 10: tetrahedron 2: the index 5 is not between 1 and 4 (GMF counts from 1; the file is "
          "damaged, or belongs to another mesh)");
    CHECK(message(head + "Triangles 1\n0 2 3 0\nEnd") ==
          "in.mesh: line 9: triangle 1: the index 0 is not between 1 and 4 (GMF counts from 1; the file is damaged, "
          "or belongs to another mesh)");
    CHECK(message(head + "Triangles 1 2 1 2 0\nEnd") ==
          "in.mesh: line 8: triangle 1: vertex 2 occurs twice (remove it: it has no volume)");
    CHECK(message(head + "Ridges 1 1\nEnd") ==
          "in.mesh: line 8: ridge 1: the index 1 refers to an entity that the file does not have (GMF counts from 1; "
          "the file is damaged, or belongs to another mesh)");
    CHECK(message(head + "Edges 1 1 2 0 RequiredEdges 1 2 End") ==
          "in.mesh: line 8: required edge 1: the index 2 is not between 1 and 1 (GMF counts from 1; the file is "
          "damaged, or belongs to another mesh)");
    CHECK(message(head + "Triangles 2 1 2 3 0 1 2 4 0 5 End").ends_with("(the rows are longer than GMF allows)"));
    CHECK(message(head + "Edges 1 1 2 0\nEdges 1 1 2 0\nEnd") ==
          "in.mesh: line 9: a second block Edges (join the two, or remove one)");
    CHECK(message("MeshVersionFormatted 2 Dimension 2 Vertices 1 0 0 0\nTetrahedra 1 1 2 3 4 0 End") ==
          "in.mesh: line 2: the file has tetrahedra, but its Dimension is 2 (set Dimension 3, and give three "
          "coordinates per vertex)");
}

TEST_CASE("GMF numbers in Fortran notation are read") {
    const auto decoded = decode_gmf_mesh(
        generated::bytes_of("MeshVersionFormatted 2 Dimension 2 Vertices 2  +1.5D+2 1d-1 +7  1e-999 .5 0 End"),
        "in.mesh", {});
    REQUIRE(decoded);
    const auto& mesh = testing::mesh_in<LinearMesh<2>>(decoded->mesh);
    CHECK(mesh.points[0] == Vec<2>{{150, 0.1}});
    CHECK(mesh.points[1] == Vec<2>{{0, 0.5}});
    CHECK(mesh.point_references[0] == 7);
}

TEST_CASE("unsupported GMF elements are rejected with their counts") {
    CHECK(message(head + "Hexahedra 12 1 2 3\nEnd") ==
          "in.mesh: line 8: holds 12 Hexahedra, which Camber does not support (give a mesh of edges, triangles and "
          "tetrahedra of degree 1 or 2; \"camber info FILE\" counts its cells and names a program that splits them)");
    CHECK(message(head + "Hexahedra 12 1 2 3\nPrisms 1 1 2\nEnd").find("holds 12 Hexahedra, 1 Prisms, which") < 40);
    for (const std::string keyword : {"Quadrilaterals", "Prisms", "Pyramids", "Hexahedra", "TetrahedraP3"}) {
        CHECK(kind(head + keyword + " 3 End") == ErrorKind::unsupported);
        CHECK(message(head + keyword + " 0 End") == "no error");
    }
}

TEST_CASE("skipped GMF blocks are reported") {
    const auto decoded = decode_gmf_mesh(
        generated::bytes_of(head + "Foo 1 2 nan 3 Bar Foo 7 RequiredQuadrilaterals 1 1 End"), "in.mesh", {});
    REQUIRE(decoded);
    REQUIRE(decoded->notices.size() == 3);
    CHECK(decoded->notices[0].what == "2 blocks of keyword Foo were skipped");
    CHECK(decoded->notices[1].what == "the block of keyword Bar was skipped");
}

TEST_CASE("contradictory mid nodes are rejected") {
    const std::string points =
        "MeshVersionFormatted 2\nDimension 2\nVertices 8  0 0 0  1 0 0  0 1 0  1 1 0  .5 0 0  .5 .5 0  0 .5 0  .6 .6 "
        "0\n";
    const std::string damaged = " (the file is damaged, or was joined from two files)";
    CHECK(message(points + "TrianglesP2 1 1 2 3 5 6 7 0\nEdgesP2 1\n3 2 8 0\nEnd") ==
          "in.mesh: line 6: edge 1: the edge between vertices 2 and 3 has mid node 8 here and 6 in triangle 1" +
              damaged);
    CHECK(message(points + "TrianglesP2 1 1 2 3 5 6 7 0\nEdgesP2 1\n4 2 6 0\nEnd") ==
          "in.mesh: line 6: edge 1: mid node 6 of the edge between vertices 2 and 4 belongs to another edge in "
          "triangle 1" +
              damaged);
    CHECK(message(points + "TrianglesP2 1 1 2 3 5 6 7 0\nEdgesP2 1\n4 5 8 0\nEnd") ==
          "in.mesh: line 4: vertex 5: is a mid node of triangle 1 and a corner of edge 1" + damaged);
    CHECK(
        message(points + "TrianglesP2Ordering 6 2 0 0 0 2 0 0 0 2 1 1 0 1 1 0 1 0 1 TrianglesP2 1 1 2 3 5 6 7 0 End") ==
        "in.mesh: line 4: TrianglesP2Ordering does not list each of the 6 nodes of its simplex once");
}

TEST_CASE("errors in binary GMF files give the byte") {
    BinaryFile file(2, false);
    file.dimension(2);
    file.block(4, 1);
    for (const double x : {0.0, 1.0}) file.real(x);
    file.integer(0);
    file.close();
    file.block(5, 1);
    const std::size_t row = file.bytes.size();
    for (const int i : {1, 9, 0}) file.integer(i);
    file.close();
    file.end();
    const auto decoded = decode_gmf_mesh(file.bytes, "in.meshb", {});
    REQUIRE(!decoded);
    CHECK(describe(decoded.error()) == "in.meshb: byte " + std::to_string(row) +
                                           ": edge 1: the index 9 is not between 1 and 1 (GMF counts from 1; the file "
                                           "is damaged, or belongs to another mesh)");

    auto cut = file.bytes;
    cut.resize(30);
    CHECK(describe(decode_gmf_mesh(cut, "in.meshb", {}).error()) ==
          "in.meshb: byte 20: the block after keyword 4 has the position 52, which is not between here and the end of "
          "the file (the file is cut off or damaged)");
}

TEST_CASE("GMF reading and writing stop on request") {
    std::stop_source source;
    source.request_stop();
    const auto decoded = decode_gmf_mesh(generated::bytes_of(head + "End"), "in.mesh", {.stop = source.get_token()});
    REQUIRE(!decoded);
    CHECK(decoded.error().kind == ErrorKind::stopped);
    const auto encoded = encode_gmf_mesh(as_mesh(generated::mesh<2>(1, 3)), {}, {.stop = source.get_token()});
    REQUIRE(!encoded);
    CHECK(encoded.error().kind == ErrorKind::stopped);
}
