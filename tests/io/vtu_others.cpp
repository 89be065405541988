// VTU files as VTK writes them in parallel: compressors, pieces, ghost cells and reference arrays.
#include <doctest/doctest.h>

#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "any_mesh.hpp"
#include "generated.hpp"
#include "vtu_files.hpp"

import camber.core;
import camber.io;

using namespace camber;
using namespace vtu_files;

namespace {

using Arrays = std::map<std::string, std::string>;

/// Two tetrahedra and a triangle in blocks written by VTK.
std::string of_vtk(const std::string& compressor, Arrays data) {
    const auto array = [&](const std::string& type, const std::string& name, int components) {
        return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
               std::to_string(components) + "\" format=\"binary\">" + data[name] + "</DataArray>\n";
    };
    return "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\" header_type=\"UInt32\" compressor=\"" +
           compressor + "\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"5\" NumberOfCells=\"3\">\n<PointData>" +
           array("Float64", "T", 1) + "</PointData>\n<CellData>" + array("Int32", "Material", 1) +
           "</CellData>\n<Points>" + array("Float64", "Points", 3) + "</Points>\n<Cells>" +
           array("Int64", "connectivity", 1) + array("Int64", "offsets", 1) + array("UInt8", "types", 1) +
           "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

const Arrays by_lz4{{"T", "AQAAAACAAAAoAAAAHQAAAA==EQABACHgPwcAIwDwCAAT+AgAoABAAAAAAAAABEA="},
                    {"Material", "AQAAAACAAAAMAAAADQAAAA==wAMAAAAEAAAABwAAAA=="},
                    {"Points", "AQAAAACAAAB4AAAAHQAAAA==HwABAAov8D8fAAoPIAAWBCgAoPA/AAAAAAAA8D8="},
                    {"connectivity", "AQAAAACAAABYAAAAJwAAAA==EwABABMBCAATAggAEwMIAA8YAAUTBCAABAIABDgAgAEAAAAAAAAA"},
                    {"offsets", "AQAAAACAAAAYAAAAEwAAAA==IgQAAQASCAcAkAALAAAAAAAAAA=="},
                    {"types", "AQAAAACAAAADAAAABAAAAA==MAoKBQ=="}};
const Arrays by_lzma{{"T",
                      "AQAAAACAAAAoAAAATAAAAA==/Td6WFoAAAFpIt42AsAbKCEBFgC5xm524AAnABNdAABptmER67A89EgsmvDj+N5vAA"
                      "AAAPFTd2UAASsouOBDY5BCmQ0BAAAAAAFZWg=="},
                     {"Material",
                      "AQAAAACAAAAMAAAAQAAAAA==/Td6WFoAAAFpIt42AsAQDCEBFgC+v+goAQALAwAAAAQAAAAHAAAAANwi1hUAASAMot"
                      "20vJBCmQ0BAAAAAAFZWg=="},
                     {"Points",
                      "AQAAAACAAAB4AAAASAAAAA==/Td6WFoAAAFpIt42AsAVeCEBFgACaHd04AB3AA1dAABuFTfEGSHYL7ioTAAAAAAAUn"
                      "RlzAABJXjCnKuWkEKZDQEAAAAAAVla"},
                     {"connectivity",
                      "AQAAAACAAABYAAAATAAAAA==/Td6WFoAAAFpIt42AsAcWCEBFgDOFrmS4ABXABRdAABqfrsUbxtBDgFyURL87Q9rCj"
                      "cAAP9U5lwAASxYQwcHfJBCmQ0BAAAAAAFZWg=="},
                     {"offsets",
                      "AQAAAACAAAAYAAAARAAAAA==/Td6WFoAAAFpIt42AsAUGCEBFgDqzBkm4AAXAAxdAAIAN+HOKwD3OFwAAABm177kAA"
                      "EkGNvMAsKQQpkNAQAAAAABWVo="},
                     {"types",
                      "AQAAAACAAAADAAAAOAAAAA==/Td6WFoAAAFpIt42AsAHAyEBFgBMGmu0AQACCgoFAADBQFN4AAEXAwdgDLyQQpkNAQ"
                      "AAAAABWVo="}};

std::string text_array(const std::string& type, const std::string& name, const std::string& numbers) {
    return cell_array(type, name, numbers);
}

/// One tetrahedron above the diagonal of a square; two pieces share the face at x = y.
std::string piece(const std::string& corner, const std::string& more, const std::string& temperature) {
    return "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">\n<PointData>" + text_array("Float64", "T", temperature) +
           "</PointData>\n<CellData>" + more +
           "</CellData>\n<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0  1 1 0  "
           "0 0 1  " +
           corner + "</DataArray></Points>\n<Cells>" + text_array("Int64", "connectivity", "0 1 2 3") +
           text_array("Int64", "offsets", "4") + text_array("UInt8", "types", "10") + "</Cells>\n</Piece>\n";
}
std::string grid(const std::string& pieces) {
    return "<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n" + pieces + "</UnstructuredGrid>\n</VTKFile>\n";
}
const std::string reference_1 = text_array("Int32", "reference", "1"),
                  reference_2 = text_array("Int32", "reference", "2");

}  // namespace

TEST_CASE("VTU reads blocks compressed with LZ4 and LZMA") {
    for (const auto& [name, data] :
         {std::pair("vtkLZ4DataCompressor", by_lz4), std::pair("vtkLZMADataCompressor", by_lzma)}) {
        const auto decoded = read(of_vtk(name, data));
        REQUIRE_MESSAGE(decoded.has_value(), message(of_vtk(name, data)));
        const auto& mesh = testing::mesh_in<LinearMesh<3>>(decoded->mesh);
        CHECK(mesh.points[4] == Vec<3>{{1, 1, 1}});
        CHECK(mesh.elements.references == Column<Reference>(Buffer<Reference>{3, 4}));
        CHECK(mesh.facets.references == Column<Reference>(Buffer<Reference>{7}));
        CHECK(decoded->fields.find("T", Centring::node) != nullptr);
        REQUIRE(decoded->notices.size() == 1);
        CHECK(decoded->notices[0].what == "the references of the cells are the array Material");
        // A wrong compressor and damaged data are errors.
        Arrays broken = data;
        broken["Points"][30] = broken["Points"][30] == 'A' ? 'B' : 'A';
        CHECK(message(of_vtk(name, broken)) != "no error");
    }
    CHECK(message(of_vtk("vtkLZMADataCompressor", by_lz4)).find("LZMA cannot uncompress it") < 60);
    CHECK(message(of_vtk("vtkLZ4DataCompressor", by_lzma)).find("LZ4 cannot uncompress it") < 60);
}

TEST_CASE("VTU pieces are joined at coincident points") {
    const auto decoded = read(grid(piece("0 1 0", reference_1, "1 2 3 4") + piece("1 0 0", reference_2, "1 2 3 9")));
    REQUIRE(decoded.has_value());
    const auto& mesh = testing::mesh_in<LinearMesh<3>>(decoded->mesh);
    CHECK(mesh.points.size() == 5);
    CHECK(mesh.elements.vertices[1] == SimplexVertices<3>{VertexId(0), VertexId(1), VertexId(2), VertexId(4)});
    CHECK(mesh.elements.references == Column<Reference>(Buffer<Reference>{1, 2}));
    const MeshField* const temperature = decoded->fields.find("T", Centring::node);
    REQUIRE(temperature != nullptr);
    CHECK(std::get<Column<double>>(temperature->values) == Column<double>(Buffer<double>{1, 2, 3, 4, 9}));
    REQUIRE(decoded->notices.size() == 1);
    CHECK(decoded->notices[0].what == "2 pieces were joined into one mesh, at 3 points");
    // Empty pieces are ignored, and so is an array that one piece lacks.
    const std::string empty = "<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"/>\n";
    CHECK(read(grid(empty + piece("0 1 0", reference_1, "1 2 3 4") + empty))->notices.empty());
    const auto without = read(grid(piece("0 1 0", reference_1, "1 2 3 4") + piece("1 0 0", "", "1 2 3 9")));
    REQUIRE(without.has_value());
    CHECK(testing::mesh_in<LinearMesh<3>>(without->mesh).elements.references ==
          Column<Reference>(Buffer<Reference>{0, 0}));
    // Connectivity counts the points of its own piece.
    std::string wrong = piece("1 0 0", reference_2, "1 2 3 9");
    wrong.replace(wrong.find("0 1 2 3<"), 7, "0 1 2 4");
    CHECK(message(grid(piece("0 1 0", reference_1, "1 2 3 4") + wrong))
              .find("tetrahedron 2: a node is not one of those that the file lists") < 60);
}

TEST_CASE("VTU ghost cells are left out with a notice") {
    const auto decoded = read(plain("10 10", "0 1 2 3 1 2 3 4", "4 8", cell_array("UInt8", "vtkGhostType", "0 1")));
    REQUIRE(decoded.has_value());
    CHECK(testing::mesh_in<LinearMesh<3>>(decoded->mesh).elements.size() == 1);
    CHECK(decoded->fields.empty());
    REQUIRE(decoded->notices.size() == 1);
    CHECK(decoded->notices[0].what == "1 ghost cells (vtkGhostType) were left out");
}

TEST_CASE("VTU references come from common array names or the given name") {
    const auto references = [](const std::string& arrays, DecodeOptions options) {
        const auto decoded =
            decode_vtu(generated::bytes_of(plain("10 10", "0 1 2 3 1 2 3 4", "4 8", arrays)), "in.vtu", options, {});
        return decoded ? testing::mesh_in<LinearMesh<3>>(decoded->mesh).elements.references
                       : Column<Reference>(Buffer<Reference>{-1});
    };
    const Column<Reference> expected(Buffer<Reference>{3, 5});
    for (const std::string name :
         {"attribute", "material", "Material", "MaterialIds", "region", "RegionId", "cell_tags"})
        CHECK(references(cell_array("Int32", name, "3 5"), {}) == expected);
    CHECK(references(cell_array("Float64", "material", "3 5"), {}) == expected);
    const Column<Reference> none(Buffer<Reference>{0, 0});
    CHECK(references(cell_array("Float64", "material", "3.5 5"), {}) == none);
    CHECK(references(cell_array("Int32", "colour", "3 5"), {}) == none);
    CHECK(references(cell_array("Int32", "colour", "3 5"), {.reference_array = "colour"}) == expected);
    const std::string both = cell_array("Int32", "reference", "1 2") + cell_array("Int32", "colour", "3 5");
    CHECK(references(both, {}) == Column<Reference>(Buffer<Reference>{1, 2}));
    CHECK(references(both, {.reference_array = "colour"}) == expected);
    const auto missing = decode_vtu(generated::bytes_of(plain("10 10", "0 1 2 3 1 2 3 4", "4 8", both)), "in.vtu",
                                    {.reference_array = "shade"}, {});
    REQUIRE(!missing.has_value());
    CHECK(describe(missing.error()) ==
          "in.vtu: no array of cells \"shade\" has a 32-bit integer for each cell (its arrays of cells are reference, "
          "colour)");
}

TEST_CASE("unsupported VTU cells are counted on request") {
    const auto counted = decode_vtu(generated::bytes_of(plain("10 9", "0 1 2 3 1 2 3 4", "4 8")), "in.vtu",
                                    {.unsupported_cells = UnsupportedCells::count}, {});
    REQUIRE(counted.has_value());
    CHECK(counted->unsupported_cells == std::vector<CellCount>{{"quadrilaterals", 1}});
    CHECK(testing::mesh_in<LinearMesh<3>>(counted->mesh).elements.size() == 1);
}
