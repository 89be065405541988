// Damaged VTU files and unsupported cells: errors with positions, and no memory for false counts.
#include "generated.hpp"
#include "property.hpp"
#include "vtu_files.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <variant>
#include <vector>

using namespace camber;
using namespace vtu_files;

namespace {

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    REQUIRE(at < text.size());
    return text.replace(at, what.size(), by);
}

/// A triangle among `points` points with a field of random numbers; arrays follow the XML.
std::string with_field(std::size_t points, bool compressed) {
    generated::Random random(points);
    std::vector<double> values, places(3 * points, 0.0);
    for (std::size_t i = 0; i < points; ++i) values.push_back(random.real());
    places[3] = places[7] = 1;
    if (compressed) {
        LinearMesh<3> mesh;
        mesh.points = Buffer<Vec<3>>(points, Vec<3>{});
        mesh.point_references = Buffer<Reference>(points, 0);
        const auto fields = MeshFields{}.with(
            {"u", Centring::node, FieldKind::scalar, Column<double>(Buffer<double>(values.begin(), values.end()))});
        return generated::text_of(generated::joined(*encode_vtu(as_mesh(mesh), fields, {}, {})));
    }
    File file(Form::appended_raw, false, true);
    std::string piece = "<Piece NumberOfPoints=\"" + std::to_string(points) + "\" NumberOfCells=\"1\">\n<PointData>\n";
    piece += file.array<double>("Float64", "u", values) + "</PointData>\n<Points>\n";
    piece += file.array<double>("Float64", "Points", places, 3) + "</Points>\n<Cells>\n";
    piece += file.array<std::int64_t>("Int64", "connectivity", {0, 1, 2});
    piece += file.array<std::int64_t>("Int64", "offsets", {3});
    piece += file.array<std::uint8_t>("UInt8", "types", {5}) + "</Cells>\n</Piece>\n";
    return file.whole(piece);
}

}  // namespace

TEST_CASE("truncated VTU files are rejected unless only final blanks are missing") {
    std::vector<std::string> files{
        generated::text_of(generated::joined(*encode_vtu(as_mesh(generated::quadratic<3>(3, 1)), {}, {}, {})))};
    for (const Form form : {Form::ascii, Form::binary, Form::appended_raw, Form::appended_base64})
        files.push_back(four_cells<std::int32_t, float>(File(form, true, true), "Int32", "Float32"));
    for (const std::string& text : files) {
        const auto whole = read(text);
        REQUIRE(whole.has_value());
        for (std::size_t n = 0; n < text.size(); ++n) {
            CAPTURE(n);
            const auto decoded = read(text.substr(0, n));
            if (decoded) {
                REQUIRE(text.size() - n < 3);  // blanks at the end
                REQUIRE(decoded->mesh == whole->mesh);
            } else {
                REQUIRE(!decoded.error().what.empty());
                REQUIRE(decoded.error().where.starts_with("in.vtu"));
            }
        }
    }
}

TEST_CASE("a VTU file with noise gives an error or a consistent mesh") {
    testing::property(
        "random bytes of a VTU file are replaced",
        [](std::uint64_t seed) {
            generated::Random random(seed);
            const std::array forms{Form::ascii, Form::binary, Form::appended_raw, Form::appended_base64};
            auto text = four_cells<std::int32_t, float>(File(forms[seed % 4], false, true), "Int32", "Float32");
            if (random.below(3) == 0)
                text = generated::text_of(
                    generated::joined(*encode_vtu(as_mesh(generated::quadratic<3>(seed, 2)), {}, {}, {})));
            for (std::size_t i = 0, n = 1 + random.below(6); i < n; ++i)
                text[random.below(text.size())] = static_cast<char>(random.below(4) == 0 ? 0xff : random.below(256));
            const auto decoded = read(text);
            if (!decoded) return;
            std::visit(
                []<int D>(const Mesh<D>& mesh) {
                    for (const auto& element : mesh.elements.template of<simplex<D>>().vertices)
                        for (const VertexId v : element) RC_ASSERT(v.index() < mesh.points.size());
                },
                decoded->mesh);
        },
        {.count = 2000});
}

TEST_CASE("VTU files with excessive counts are rejected") {
    const std::string whole = plain("10", "0 1 2 3", "4");
    CHECK(message(whole) == "no error");
    for (const std::string count : {"4000000000", "18446744073709551615", "99999999999999999999999", "-1", "x", "2"}) {
        CHECK(message(replaced(whole, "NumberOfPoints=\"5\"", "NumberOfPoints=\"" + count + "\"")) != "no error");
        CHECK(message(replaced(whole, "NumberOfCells=\"1\"", "NumberOfCells=\"" + count + "\"")) != "no error");
    }
    CHECK(message(replaced(whole, "NumberOfComponents=\"3\"", "NumberOfComponents=\"6148914691236517205\"")) !=
          "no error");
    // Header words: bytes of an array, number of blocks, bytes of a block.
    for (const bool compressed : {false, true})
        for (const std::uint64_t word : {std::uint64_t{1} << 40U, ~std::uint64_t{0}, std::uint64_t{1} << 63U})
            for (int at = 0; at < 4; ++at) {
                std::array<std::uint64_t, 4> header{1, 8, 0, 8};
                header[static_cast<std::size_t>(compressed ? at : 0)] = word;
                std::string bytes(sizeof header, '\0');
                std::memcpy(bytes.data(), header.data(), sizeof header);
                std::string text = replaced(whole, "format=\"ascii\">0 0 0  1 0 0  0 1 0  0 0 1  1 1 1",
                                            "format=\"binary\">" + base64(bytes + "12345678"));
                text = replaced(text, "type=\"UnstructuredGrid\"", "type=\"UnstructuredGrid\" header_type=\"UInt64\"");
                if (compressed)
                    text = replaced(text, "type=\"UnstructuredGrid\"",
                                    "type=\"UnstructuredGrid\" compressor=\"vtkZLibDataCompressor\"");
                CHECK(message(text).find("the array ") < 40);
            }
}

// Guards against gigabytes of uncompressed data for a file of 4 points.
TEST_CASE("VTU decompresses no more bytes than the counts declare") {
    const std::string attributes =
        "type=\"UnstructuredGrid\" header_type=\"UInt64\" "
        "compressor=\"vtkZLibDataCompressor\"";
    const std::string whole = replaced(
        plain("10", "0 1 2 3", "4", cell_array("Float64", "level", "1"), cell_array("Float64", "speed", "1 2 3 4 5")),
        "type=\"UnstructuredGrid\"", attributes);
    CHECK(message(whole) == "no error");
    // The block has the compressed size of a block of zeros, but its content is not zlib data.
    const auto announcing = [](std::uint64_t bytes) {
        const std::uint64_t packed = bytes / 1000 + 1;
        const std::array<std::uint64_t, 4> header{1, bytes, 0, packed};
        std::string text(sizeof header, '\0');
        std::memcpy(text.data(), header.data(), sizeof header);
        return base64(text + std::string(packed, 'x'));
    };
    const std::array<std::array<std::string, 2>, 6> arrays{{{"0 0 0  1 0 0  0 1 0  0 0 1  1 1 1", "120"},
                                                            {"0 1 2 3", "32"},
                                                            {"4", "8"},
                                                            {"10", "1"},
                                                            {"1", "8"},
                                                            {"1 2 3 4 5", "40"}}};
    for (const auto& [text, bytes] : arrays) {
        const auto with = [&](std::uint64_t announced) {
            return replaced(whole, "format=\"ascii\">" + text + "</DataArray>",
                            "format=\"binary\">" + announcing(announced) + "</DataArray>");
        };
        CAPTURE(text);
        CHECK(message(with(1'000'000)).find("announce 1000000 bytes, but the counts of the file make " + bytes + " (") <
              100);
        // No mesh of a file of this size has so many bytes.
        CHECK(message(with(std::uint64_t{600} << 20U))
                  .find("uncompressed, it and those before it would have more than ") < 100);
    }
}

// Guards against 730 MB of memory for 10 million XML tags.
TEST_CASE("VTU rejects files with too many XML tags") {
    std::string tags;
    for (int i = 0; i < 200'001; ++i) tags += "<a/>";
    const std::string text = "<VTKFile type=\"UnstructuredGrid\">" + tags + "</VTKFile>";
    CHECK(message(text).find("has more than 200000 XML tags") < 20);
}

TEST_CASE("VTU rejects arrays that share data and exceed the file size together") {
    for (const bool compressed : {false, true}) {
        CAPTURE(compressed);
        const std::string text = with_field(1000, compressed);
        CHECK(message(text) == "no error");
        const std::size_t name = text.find("Name=\"u\""), begin = text.rfind("<DataArray", name),
                          end = text.find("/>", name) + 2;
        const std::string element = text.substr(begin, end - begin);
        std::string many = text.substr(0, begin);
        for (int i = 0; i < 100; ++i) many += replaced(element, "Name=\"u\"", "Name=\"u" + std::to_string(i) + "\"");
        many += text.substr(end);
        CHECK(message(many).find("it and those before it have more bytes than the file") < 60);
    }
}

TEST_CASE("unsupported VTU cells are rejected by name and count") {
    CHECK(message(plain("9 9 5 12", "0 1 2 3 0 1 2 4 0 1 2 0 1 2 3 4 0 1 2", "4 8 11 19")) ==
          "in.vtu: line 8: holds 2 quadrilaterals, 1 hexahedra, which Camber does not support (give a mesh of edges, "
          "triangles and tetrahedra of degree 1 or 2; \"camber info FILE\" counts its cells and names a program that "
          "splits them)");
    CHECK(message(plain("69", "0 1 2 3 4 0 1 2 3 4", "10")).find("1 Lagrange cells of degree 3 and higher") < 40);
    CHECK(message(plain("200", "0", "1")).find("1 cells of VTK's type 200") < 40);
    CHECK(message(plain("5", "0 1 2 3", "4")) ==
          "in.vtu: line 8: cell 1 is of VTK's type 5, but has 4 nodes (the file is damaged, or was joined from two "
          "files)");
    const auto piece = plain("5", "0 1 2", "3");
    const auto kind = [](const std::string& text) {
        const auto decoded = read(text);
        return decoded ? ErrorKind::internal : decoded.error().kind;
    };
    CHECK(kind(replaced(piece, "type=\"UnstructuredGrid\"", "type=\"PUnstructuredGrid\"")) == ErrorKind::unsupported);
    CHECK(kind(replaced(piece, "type=\"UnstructuredGrid\"",
                        "type=\"UnstructuredGrid\" compressor=\"vtkOtherDataCompressor\"")) == ErrorKind::unsupported);
    CHECK(message(replaced(piece, "type=\"UnstructuredGrid\"",
                           "type=\"UnstructuredGrid\" compressor=\"vtkOtherDataCompressor\""))
              .ends_with("(write it with one of these compressors or without (Compressor Type in ParaView))"));
}

TEST_CASE("invalid VTU indices and offsets are rejected") {
    CHECK(message(plain("10 10", "0 1 2 3 0 1 2 5", "4 8")) ==
          "in.vtu: line 8: tetrahedron 2: a node is not one of those that the file lists (the file is damaged, or was "
          "joined from two files)");
    CHECK(message(plain("5", "0 1 1", "3")) ==
          "in.vtu: line 8: triangle 1: a node occurs twice (remove it: it has no volume)");
    CHECK(message(plain("5 5", "0 1 2 0 1 3", "6 3")).find("the offset of cell 2 is wrong") < 30);
    CHECK(message(plain("5", "0 1 2 3", "3")).find("connectivity has 4 entries, but the offsets end at 3") < 30);
    CHECK(message(plain("5", "0 -1 2", "3")).find("a node is not one of those") < 60);
    CHECK(message(plain("5 5", "0 1 2", "3")).find("2 types and 1 offsets") < 80);
    CHECK(message(replaced(plain("5", "0 1 2", "3"), "0 0 0  1", "nan 0 0  1")).find("not a number") < 60);
}
