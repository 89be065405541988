// Legacy VTK files as VTK writes them, with every kind of array, and damaged. Round trips are in formats.cpp.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>

#include "any_mesh.hpp"
#include "generated.hpp"
#include "property.hpp"

import camber.core;
import camber.io;

using namespace camber;

namespace {

Outcome<DecodedMesh> read(const std::string& text) {
    return decode_vtk(generated::bytes_of(text), "in.vtk", {}, {.threads = 1});
}
std::string message(const std::string& text) {
    const auto decoded = read(text);
    return decoded ? "no error" : describe(decoded.error());
}
std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    REQUIRE(at < text.size());
    return text.replace(at, what.size(), by);
}

const std::string head = "DATASET UNSTRUCTURED_GRID\n";
const std::string points = "POINTS 5 double\n0 0 0 1 0 0 0 1 0 \n0 0 1 1 1 1 \n";
const std::string types = "CELL_TYPES 3\n10\n10\n5\n\n";
const std::string data =
    "CELL_DATA 3\nFIELD FieldData 1\nMaterial 1 3 int\n3 4 7 \nPOINT_DATA 5\nSCALARS T double\n"
    "LOOKUP_TABLE default\n0.5 1 1.5 2 2.5 \n";
const std::string old = "# vtk DataFile Version 3.0\nvtk output\nASCII\n" + head + points +
                        "CELLS 3 14\n4 0 1 2 3 \n4 1 2 3 4 \n3 0 2 1 \n\n" + types + data;
const std::string modern = "# vtk DataFile Version 5.1\nvtk output\nASCII\n" + head + points +
                           "CELLS 4 11\nOFFSETS vtktypeint64\n0 4 8 11 \nCONNECTIVITY vtktypeint64\n"
                           "0 1 2 3 1 2 3 4 0 \n2 1 \n" +
                           types + data;

}  // namespace

TEST_CASE("legacy VTK files of versions 3.0 and 5.1 give the same mesh") {
    const auto first = read(old), second = read(modern);
    REQUIRE_MESSAGE(first.has_value(), message(old));
    REQUIRE_MESSAGE(second.has_value(), message(modern));
    CHECK(first->mesh == second->mesh);
    CHECK(first->fields == second->fields);
    const auto& mesh = testing::mesh_in<LinearMesh<3>>(first->mesh);
    CHECK(mesh.elements.references == Column<Reference>(Buffer<Reference>{3, 4}));
    CHECK(mesh.facets.vertices[0] == SimplexVertices<2>{VertexId(0), VertexId(2), VertexId(1)});
    REQUIRE(first->fields.find("T", Centring::node) != nullptr);
    CHECK(is_vtk(generated::bytes_of(old), VtkEncoding::ascii));
    CHECK(!is_vtk(generated::bytes_of(old), VtkEncoding::binary));
    CHECK(is_vtk(generated::bytes_of(replaced(old, "ASCII", "BINARY")), VtkEncoding::binary));
}

TEST_CASE("legacy VTK files are read with every kind of data array") {
    const std::string arrays =
        "POINT_DATA 5\nMETADATA\nINFORMATION 0\n\nVECTORS the%20flow float\n1 2 3 4 5 6 7 8 9 10 11 12 13 14 15\n"
        "NORMALS n double\n0 0 1 0 0 1 0 0 1 0 0 1 0 0 1\nTENSORS t float\n" +
        [] {
            std::string text;
            for (int i = 0; i < 45; ++i) text += std::to_string(i) + " ";
            return text;
        }() +
        "\nCOLOR_SCALARS c 2\n0 0 0 0 0 0 0 0 0 0\nLOOKUP_TABLE table 1\n0 0 0 1\nTEXTURE_COORDINATES tc 2 float\n"
        "0 0 0 0 0 0 0 0 0 0\nGLOBAL_IDS ids vtkIdType\n0 1 2 3 4\nFIELD FieldData 3\nb 1 5 bit\n0 1 0 1 1\n"
        "w 1 5 vtktypeint32\n-1 0 1 2 3\n"
        "METADATA\nCOMPONENT_NAMES\nnone\n\nk 1 5 unsigned_char\n1 2 3 4 255\n";
    const auto decoded = read(replaced(old, data, arrays));
    REQUIRE_MESSAGE(decoded.has_value(), message(replaced(old, data, arrays)));
    for (const std::string name : {"the flow", "n", "t", "ids", "b", "w", "k"})
        CHECK_MESSAGE(decoded->fields.find(name, Centring::node) != nullptr, name);
    CHECK(decoded->fields.size() == 7);
    REQUIRE(decoded->notices.size() == 1);
    CHECK(decoded->notices[0].what.starts_with("2 arrays were left out, since they have neither 1, 3, 6 nor 9"));
}

TEST_CASE("errors in legacy VTK files give the line") {
    CHECK(message(replaced(old, "UNSTRUCTURED_GRID", "POLYDATA")) ==
          "in.vtk: line 4: is a data set of the kind polydata, not UNSTRUCTURED_GRID (convert it in ParaView: filter "
          "Append Datasets, then Save Data)");
    CHECK(message(replaced(old, "4 1 2 3 4", "4 1 2 3 9")).find("a node is not one of those that the file lists") < 60);
    CHECK(message(replaced(old, "3 0 2 1", "9 0 2 1")).find("line 8: CELLS: the number of points of cell 3 is wrong") <
          40);
    CHECK(message(replaced(old, "CELLS 3 14", "CELLS 3 13")).find("CELLS") < 40);
    CHECK(message(replaced(old, "0.5 1 1.5", "0.5 x 1.5"))
              .find("number 2 of 5 is missing, malformed or too large for its kind") < 40);
    CHECK(message(replaced(old, "CELL_DATA 3", "CELL_DATA 4"))
              .find("the number of rows differs from the number of points or") < 40);
    CHECK(message(replaced(old, "1 3 int", "1 3 string")).find("has an array of the type \"string\"") < 40);
    CHECK(message(replaced(old, "CELL_TYPES 3\n10\n10\n5", "CELL_TYPES 3\n10\n9\n5")) ==
          "in.vtk: line 8: holds 1 quadrilaterals, which Camber does not support (give a mesh of edges, triangles and "
          "tetrahedra of degree 1 or 2; \"camber info FILE\" counts its cells and names a program that splits them)");
    CHECK(message("# vtk DataFile Version 3.0\nx\nASCII\n").find("the file has no DATASET") < 40);
    CHECK(message(old + "NONSENSE a b\n").find("\"nonsense\" is not a keyword of VTK") < 40);
}

TEST_CASE("truncated and damaged legacy VTK files give an error or a mesh") {
    const auto mesh = generated::quadratic<3>(2, 2);
    const std::string binary =
        generated::text_of(generated::joined(*encode_vtk(as_mesh(mesh), {}, VtkEncoding::binary, {})));
    for (const std::string& text : {old, modern, binary})
        for (std::size_t n = 0; n < text.size(); ++n) {
            CAPTURE(n);
            const auto cut = read(text.substr(0, n));
            if (cut) continue;  // cut between arrays or in the last number
            REQUIRE(!cut.error().what.empty());
            REQUIRE(cut.error().where.starts_with("in.vtk"));
        }
    testing::property("random bytes of a VTK file are replaced",
                      [&](std::uint64_t seed) {
                          generated::Random random(seed);
                          std::string text = seed % 3 == 0 ? binary : seed % 3 == 1 ? old : modern;
                          for (std::size_t i = 0, n = 1 + random.below(4); i < n; ++i)
                              text[random.below(text.size())] = static_cast<char>(random.below(256));
                          const auto decoded = read(text);
                          RC_ASSERT(decoded.has_value() || !decoded.error().what.empty());
                      },
                      {.count = 2000});
}

TEST_CASE("legacy VTK files with invalid counts are rejected") {
    for (const std::string count : {"4000000000", "9000000000000000000", "99999999999999999999", "-1", "x"}) {
        CHECK(message(replaced(old, "POINTS 5", "POINTS " + count)) != "no error");
        CHECK(message(replaced(old, "CELLS 3", "CELLS " + count)) != "no error");
        CHECK(message(replaced(modern, "CELLS 4", "CELLS " + count)) != "no error");
        CHECK(message(replaced(old, "FieldData 1", "FieldData " + count)) != "no error");
    }
}
