// VTU files read: what was written comes back; files of others in every encoding; what is damaged or cannot be held.
// Files that VTK itself writes are read by tests/pipelines/test_readers.py.
#include "generated.hpp"
#include "property.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

using namespace camber;

namespace {

Outcome<DecodedMesh> read(const std::string& text) { return decode_vtu(generated::bytes_of(text), "in.vtu", {}); }

std::string message(const std::string& text) {
    const auto decoded = read(text);
    return decoded ? "no error" : describe(decoded.error());
}

/// What VTU holds of a mesh.
template <class Mesh>
Mesh held(Mesh mesh, std::uint64_t seed) {
    auto& linear = [&]() -> auto& {
        if constexpr (requires { mesh.linear; })
            return mesh.linear;
        else
            return mesh;
    }();
    linear.corners = {};
    linear.required_vertices = {};
    linear.ridges = {};
    linear.geometry = {};
    generated::Random random(seed);
    const auto entities = [&](auto& simplices) {
        simplices.required = {};
        if (simplices.size() == 0 || random.below(2) == 0) return;
        Buffer<Reference> made;
        for (std::size_t i = 0; i < simplices.size(); ++i) made.push_back(random.reference());
        made[0] = 1;
        simplices.entities = std::move(made);
    };
    entities(linear.elements);
    entities(linear.facets);
    entities(linear.edges);
    return mesh;
}

template <class Mesh>
MeshFields some_fields(const Mesh& mesh, std::uint64_t seed) {
    generated::Random random(seed);
    constexpr int D = Mesh::dimension;
    std::size_t nodes = 0, cells = 0;
    const auto count = [&](const auto& linear) {
        nodes += linear.points.size();
        cells = linear.elements.size() + linear.facets.size() + linear.edges.size();
    };
    if constexpr (requires { mesh.linear; }) {
        count(mesh.linear);
        nodes += mesh.mid_nodes.size();
    } else {
        count(mesh);
    }
    MeshFields fields;
    for (const auto centring : {Centring::node, Centring::cell})
        for (const auto kind :
             {FieldKind::scalar, FieldKind::vector, FieldKind::symmetric_tensor, FieldKind::full_tensor}) {
            const std::size_t size =
                (centring == Centring::node ? nodes : cells) * static_cast<std::size_t>(values_per_vertex(kind, D));
            Buffer<double> reals;
            Buffer<std::int32_t> integers;
            for (std::size_t i = 0; i < size; ++i) {
                reals.push_back(random.real());
                integers.push_back(random.reference());
            }
            const std::string name = "kind " + std::to_string(static_cast<int>(kind));
            fields = std::move(fields).with({name, centring, kind, Column<double>(std::move(reals))});
            fields = std::move(fields).with({name + " <&>", centring, kind, Column<std::int32_t>(std::move(integers))});
        }
    return fields;
}

template <class Mesh>
void what_is_written_comes_back() {
    testing::property("mesh, entities and fields", [](std::uint64_t seed) {
        const Mesh mesh = held(
            [&] {
                if constexpr (std::is_same_v<Mesh, LinearMesh<Mesh::dimension>>)
                    return generated::mesh<Mesh::dimension>(seed, 1 + seed % 9);
                else
                    return generated::quadratic<Mesh::dimension>(seed, 1 + seed % 9);
            }(),
            seed);
        const auto& linear = [&]() -> const auto& {
            if constexpr (requires { mesh.linear; })
                return mesh.linear;
            else
                return mesh;
        }();
        RC_PRE(linear.elements.size() > 0);
        const MeshFields fields = some_fields(mesh, seed);
        const VtuOptions options{*rc::gen::element(VtuCells::quadratic, VtuCells::lagrange)};
        const auto bytes = generated::joined(*encode_vtu(mesh, fields, options, {}));
        auto back = decode_mesh(bytes, "in.vtu", {});
        if (!back) RC_FAIL(describe(back.error()));
        if (Mesh::dimension == 2) back = with_flat_in_2d(std::move(*back), {});
        RC_ASSERT(std::holds_alternative<Mesh>(back->mesh));
        RC_ASSERT(std::get<Mesh>(back->mesh) == mesh);
        RC_ASSERT(back->fields == fields);
        RC_ASSERT(back->notices.empty());
        RC_ASSERT(back->node_numbers.empty());
        RC_ASSERT(generated::joined(*encode_vtu(mesh, back->fields, options, {})) == bytes);
    });
}

// ---------------------------------------------------------------- files of others

enum class Form { ascii, binary, split_binary, appended_raw, appended_base64 };

std::string base64(const std::string& bytes) {
    constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k)
            bits = bits << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : letters[bits >> (18 - 6 * k) & 63U];
    }
    return text;
}

/// A writer of its own: every array in the form, word and byte order that is asked for.
class File {
  public:
    File(Form form, bool big, bool wide) : form_(form), big_(big), wide_(wide) {}

    template <class T>
    std::string array(const std::string& type, const std::string& name, const std::vector<T>& values,
                      int components = 1) {
        const std::string tag = "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
                                std::to_string(components) + "\" format=\"";
        if (form_ == Form::ascii) {
            std::string text;
            for (const T value : values)
                text +=
                    (std::is_integral_v<T> ? std::to_string(static_cast<long long>(value)) : std::to_string(value)) +
                    " ";
            return tag + "ascii\">\n" + text + "\n</DataArray>\n";
        }
        std::string data;
        for (const T value : values) data += bytes(value);
        const std::string header =
            wide_ ? bytes(std::uint64_t{data.size()}) : bytes(static_cast<std::uint32_t>(data.size()));
        if (form_ == Form::binary) return tag + "binary\">\n  " + base64(header + data) + "\n</DataArray>\n";
        if (form_ == Form::split_binary)
            return tag + "binary\">" + base64(header) + "\n" + base64(data) + "</DataArray>\n";
        const std::string offset = std::to_string(appended_.size());
        appended_ += form_ == Form::appended_raw ? header + data : base64(header + data);
        return tag + "appended\" offset=\"" + offset + "\"/>\n";
    }

    [[nodiscard]] std::string whole(const std::string& piece) const {
        const std::string header = wide_ ? " header_type=\"UInt64\"" : "";
        std::string text = "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"" +
                           std::string(big_ ? "BigEndian" : "LittleEndian") + "\"" + header +
                           ">\n<UnstructuredGrid>\n" + piece + "</UnstructuredGrid>\n";
        if (form_ == Form::appended_raw || form_ == Form::appended_base64)
            text += "<AppendedData encoding=\"" + std::string(form_ == Form::appended_raw ? "raw" : "base64") +
                    "\">\n   _" + appended_ + "\n</AppendedData>\n";
        return text + "</VTKFile>\n";
    }

  private:
    template <class T>
    [[nodiscard]] std::string bytes(T value) const {
        std::string out(sizeof value, '\0');
        std::memcpy(out.data(), &value, sizeof value);
        if (big_ != (std::endian::native == std::endian::big)) std::reverse(out.begin(), out.end());
        return out;
    }

    Form form_;
    bool big_, wide_;
    std::string appended_;
};

/// A tetrahedron, two of its faces and an edge, with a vertex before them; Id, Real: the types of its numbers.
template <class Id, class Real>
std::string four_cells(File file, const std::string& ids, const std::string& reals) {
    std::string piece = "<Piece NumberOfPoints=\"4\" NumberOfCells=\"5\">\n<PointData>\n";
    piece += file.array<Real>(reals, "speed", {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, 3);
    piece += file.array<Id>(ids, "reference", {5, 6, 7, 8});
    piece += "</PointData>\n<CellData>\n" + file.array<Id>(ids, "medit:ref", {9, 1, 2, 3, 4});
    piece += file.array<Real>(reals, "level", {0.5, 1.5, 2.5, 3.5, 4.5});
    piece += "</CellData>\n<Points>\n" + file.array<Real>(reals, "Points", {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, 3);
    piece += "</Points>\n<Cells>\n" + file.array<Id>(ids, "connectivity", {0, 0, 1, 0, 1, 2, 0, 1, 2, 3, 3, 2, 1});
    piece += file.array<Id>(ids, "offsets", {1, 3, 6, 10, 13});
    piece += file.array<std::uint8_t>("UInt8", "types", {1, 3, 5, 10, 5}) + "</Cells>\n</Piece>\n";
    return file.whole(piece);
}

void is_four_cells(const std::string& text) {
    const auto decoded = read(text);
    REQUIRE_MESSAGE(decoded.has_value(), (decoded ? "" : describe(decoded.error())));
    const auto& mesh = std::get<LinearMesh<3>>(decoded->mesh);
    const auto v = [](std::size_t i) { return VertexId(i); };
    CHECK(mesh.points[3] == Vec<3>{{0, 0, 1}});
    CHECK(mesh.point_references == Column<Reference>(Buffer<Reference>{5, 6, 7, 8}));
    REQUIRE(mesh.elements.size() == 1);
    CHECK(mesh.elements.vertices[0] == SimplexVertices<3>{v(0), v(1), v(2), v(3)});
    CHECK(mesh.elements.references[0] == 3);
    REQUIRE(mesh.facets.size() == 2);
    CHECK(mesh.facets.vertices[1] == SimplexVertices<2>{v(3), v(2), v(1)});
    CHECK(mesh.facets.references == Column<Reference>(Buffer<Reference>{2, 4}));
    CHECK(mesh.edges.references == Column<Reference>(Buffer<Reference>{1}));
    REQUIRE(decoded->fields.size() == 2);
    const MeshField* const level = decoded->fields.find("level", Centring::cell);
    REQUIRE(level != nullptr);
    // In our order: the tetrahedron, the triangles, the edge.
    CHECK(std::get<Column<double>>(level->values) == Column<double>(Buffer<double>{3.5, 2.5, 4.5, 1.5}));
    CHECK(std::get<Column<double>>(decoded->fields.find("speed", Centring::node)->values)[11] == 12);
    REQUIRE(decoded->notices.size() == 1);
    CHECK(decoded->notices[0].what == "1 cells that are vertices were left out");
}

/// A file of text with these points, types, connectivity, and data of cells and points.
std::string plain(const std::string& types, const std::string& connectivity, const std::string& offsets,
                  const std::string& cell_data = "", const std::string& point_data = "") {
    const auto count = [](const std::string& text) {
        std::size_t words = 0;
        for (std::size_t i = 0; i < text.size(); ++i)
            words += text[i] != ' ' && (i == 0 || text[i - 1] == ' ') ? 1U : 0U;
        return std::to_string(words);
    };
    const auto array = [](const std::string& type, const std::string& name, const std::string& text) {
        return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" format=\"ascii\">" + text + "</DataArray>\n";
    };
    return "<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"5\" NumberOfCells=\"" +
           count(types) + "\">\n<PointData>" + point_data + "</PointData>\n<CellData>" + cell_data +
           "</CellData>\n<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0  1 0 0  "
           "0 1 0  0 0 1  1 1 1</DataArray></Points>\n<Cells>\n" +
           array("Int64", "connectivity", connectivity) + array("Int64", "offsets", offsets) +
           array("UInt8", "types", types) + "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

std::string cell_array(const std::string& type, const std::string& name, const std::string& text,
                       const std::string& components = "1") {
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" + components +
           "\" format=\"ascii\">" + text + "</DataArray>";
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    REQUIRE(at < text.size());
    return text.replace(at, what.size(), by);
}

}  // namespace

TEST_CASE("what is written as VTU comes back") {
    what_is_written_comes_back<LinearMesh<2>>();
    what_is_written_comes_back<LinearMesh<3>>();
    what_is_written_comes_back<QuadraticMesh<2>>();
    what_is_written_comes_back<QuadraticMesh<3>>();
}

TEST_CASE("files without entities have no array of them") {
    auto mesh = held(generated::mesh<3>(1, 4), 1);
    mesh.elements.entities = mesh.facets.entities = mesh.edges.entities = {};
    const auto text = [&] { return generated::text_of(generated::joined(*encode_vtu(mesh, {}, {}, {}))); };
    CHECK(text().find("\"entity\"") == std::string::npos);
    mesh.facets.entities = Buffer<Reference>(mesh.facets.size() + 1, 1);
    CHECK(encode_vtu(mesh, {}, {}, {}).error().kind == ErrorKind::internal);
    mesh.facets.entities = Buffer<Reference>(mesh.facets.size(), 1);
    CHECK((text().find("\"entity\"") < text().size()) == (mesh.facets.size() > 0));
}

TEST_CASE("every form, word, byte order and type of numbers") {
    for (const Form form : {Form::ascii, Form::binary, Form::split_binary, Form::appended_raw, Form::appended_base64})
        for (const bool big : {false, true})
            for (const bool wide : {false, true}) {
                CAPTURE(static_cast<int>(form));
                CAPTURE(big);
                CAPTURE(wide);
                const File file(form, big, wide);
                is_four_cells(four_cells<std::int64_t, double>(file, "Int64", "Float64"));
                is_four_cells(four_cells<std::int32_t, float>(file, "Int32", "Float32"));
                is_four_cells(four_cells<std::uint16_t, double>(file, "UInt16", "Float64"));
                is_four_cells(four_cells<std::int8_t, float>(file, "Int8", "Float32"));
                is_four_cells(four_cells<std::uint64_t, double>(file, "UInt64", "Float64"));
            }
}

TEST_CASE("every prefix of a file is an error, or the whole") {
    std::vector<std::string> files{
        generated::text_of(generated::joined(*encode_vtu(held(generated::quadratic<3>(3, 1), 3), {}, {}, {})))};
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

TEST_CASE("noise in a VTU file") {
    testing::property(
        "some bytes changed",
        [](std::uint64_t seed) {
            generated::Random random(seed);
            const std::array forms{Form::ascii, Form::binary, Form::appended_raw, Form::appended_base64};
            auto text = four_cells<std::int32_t, float>(File(forms[seed % 4], false, true), "Int32", "Float32");
            if (random.below(3) == 0)
                text = generated::text_of(generated::joined(*encode_vtu(generated::quadratic<3>(seed, 2), {}, {}, {})));
            for (std::size_t i = 0, n = 1 + random.below(6); i < n; ++i)
                text[random.below(text.size())] = static_cast<char>(random.below(4) == 0 ? 0xff : random.below(256));
            const auto decoded = read(text);
            if (!decoded) return;
            std::visit(
                [](const auto& mesh) {
                    if constexpr (!requires { mesh.linear; })
                        for (const auto& simplex : mesh.elements.vertices)
                            for (const VertexId v : simplex) RC_ASSERT(v.index() < mesh.points.size());
                },
                decoded->mesh);
        },
        {.count = 2000});
}

TEST_CASE("absurd counts are refused before anything is allocated") {
    const std::string whole = plain("10", "0 1 2 3", "4");
    CHECK(message(whole) == "no error");
    for (const std::string count : {"4000000000", "18446744073709551615", "99999999999999999999999", "-1", "x", "2"}) {
        CHECK(message(replaced(whole, "NumberOfPoints=\"5\"", "NumberOfPoints=\"" + count + "\"")) != "no error");
        CHECK(message(replaced(whole, "NumberOfCells=\"1\"", "NumberOfCells=\"" + count + "\"")) != "no error");
    }
    CHECK(message(replaced(whole, "NumberOfComponents=\"3\"", "NumberOfComponents=\"6148914691236517205\"")) !=
          "no error");
    // Headers: bytes of an array, its blocks, the bytes of a block.
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

TEST_CASE("cells that cannot be held are refused by name and count") {
    CHECK(message(plain("9 9 5 12", "0 1 2 3 0 1 2 4 0 1 2 0 1 2 3 4 0 1 2", "4 8 11 19")) ==
          "in.vtu: line 8: holds 2 quadrilaterals, 1 hexahedra, which Camber cannot hold (give a mesh of edges, "
          "triangles and tetrahedra of degree 1 or 2)");
    CHECK(message(plain("69", "0 1 2 3 4 0 1 2 3 4", "10")).find("1 Lagrange cells of degree 3 and higher") < 40);
    CHECK(message(plain("200", "0", "1")).find("1 cells of VTK's type 200") < 40);
    CHECK(message(plain("5", "0 1 2 3", "4")) ==
          "in.vtu: line 8: cell 1 is of VTK's type 5, but has 4 nodes (the file is damaged, or joined of two)");
    const auto piece = plain("5", "0 1 2", "3");
    const auto kind = [](const std::string& text) {
        const auto decoded = read(text);
        return decoded ? ErrorKind::internal : decoded.error().kind;
    };
    CHECK(kind(replaced(piece, "</Piece>", "</Piece><Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"/>")) ==
          ErrorKind::unsupported);
    CHECK(kind(replaced(piece, "type=\"UnstructuredGrid\"", "type=\"PUnstructuredGrid\"")) == ErrorKind::unsupported);
    CHECK(kind(replaced(piece, "type=\"UnstructuredGrid\"",
                        "type=\"UnstructuredGrid\" compressor=\"vtkLZ4DataCompressor\"")) == ErrorKind::unsupported);
    CHECK(message(replaced(piece, "type=\"UnstructuredGrid\"",
                           "type=\"UnstructuredGrid\" compressor=\"vtkLZ4DataCompressor\""))
              .ends_with("(write it with that one or with none: ParaView asks for the Compressor Type)"));
}

TEST_CASE("indices and offsets") {
    CHECK(message(plain("10 10", "0 1 2 3 0 1 2 5", "4 8")) ==
          "in.vtu: line 8: tetrahedron 2: a node is not one of those that the file lists (the file is damaged, or "
          "joined of two)");
    CHECK(message(plain("5", "0 1 1", "3")) ==
          "in.vtu: line 8: triangle 1: a node occurs twice (remove it: it has no volume)");
    CHECK(message(plain("5 5", "0 1 2 0 1 3", "6 3")).find("the offset of cell 2 is wrong") < 30);
    CHECK(message(plain("5", "0 1 2 3", "3")).find("connectivity has 4 entries, but the offsets end at 3") < 30);
    CHECK(message(plain("5", "0 -1 2", "3")).find("a node is not one of those") < 60);
    CHECK(message(plain("5 5", "0 1 2", "3")).find("2 types and 1 offsets") < 80);
    CHECK(message(replaced(plain("5", "0 1 2", "3"), "0 0 0  1", "nan 0 0  1")).find("not a number") < 60);
}

TEST_CASE("names of references") {
    const auto references = [](const std::string& cell_data) {
        const auto decoded = read(plain("5 5", "0 1 2 0 1 3", "3 6", cell_data));
        REQUIRE(decoded.has_value());
        const auto& mesh = std::get<LinearMesh<3>>(decoded->mesh);
        return std::pair(mesh.facets.references[1], decoded->fields.size());
    };
    CHECK(references("") == std::pair(0, std::size_t{0}));
    CHECK(references(cell_array("Int64", "MaterialID", "3 4")) == std::pair(4, std::size_t{0}));
    CHECK(references(cell_array("Float64", "CellEntityIds", "3 4")) == std::pair(4, std::size_t{0}));
    CHECK(references(cell_array("Float64", "MaterialID", "3 4.5")) == std::pair(0, std::size_t{1}));
    CHECK(references(cell_array("Int64", "MaterialID", "3 4") + cell_array("Int32", "gmsh:physical", "7 8")) ==
          std::pair(8, std::size_t{1}));
    CHECK(references(cell_array("Int64", "gmsh:physical", "3 4 3 4 3 4", "3")) == std::pair(0, std::size_t{1}));
    CHECK(references(cell_array("Int64", "reference", "3 4") + cell_array("Int32", "gmsh:physical", "7 8")) ==
          std::pair(4, std::size_t{1}));
    CHECK(references(cell_array("UInt8", "dimension", "2 2")) == std::pair(0, std::size_t{0}));
}

TEST_CASE("what becomes no field is told") {
    const auto notices = [](const std::string& cell_data, const std::string& point_data = "") {
        const auto decoded = read(plain("5", "0 1 2", "3", cell_data, point_data));
        REQUIRE(decoded.has_value());
        CHECK(decoded->fields.empty());
        REQUIRE(decoded->notices.size() == 1);
        return decoded->notices[0].what;
    };
    CHECK(notices(cell_array("Float64", "four", "1 2 3 4", "4") + cell_array("Int8", "two", "1 2", "2")) ==
          "2 arrays were left out, since they have neither 1, 3, 6 nor 9 components: four, two");
    CHECK(notices(cell_array("String", "words", "65 66 0")) ==
          "1 arrays were left out, since they are of no type of numbers: words");
    CHECK(notices(cell_array("Float64", "reference", "1.5")) ==
          "1 arrays were left out, since their values are not what Camber has under these names: reference");
    CHECK(notices(cell_array("UInt8", "dimension", "3")).ends_with("under these names: dimension"));
    CHECK(notices("", cell_array("Int32", "", "1 2 3 4 5"))
              .starts_with("1 arrays were left out, since they have no name"));
    CHECK(message(plain("5", "0 1 2", "3", cell_array("Float64", "short", "1 2"))) ==
          "in.vtu: line 5: the array short has 2 numbers, not 1 for each of 1 rows (the file is damaged, or joined of "
          "two)");
}

TEST_CASE("values keep their kind where it fits") {
    const auto decoded = read(plain("5", "0 1 2", "3",
                                    cell_array("UInt32", "small", "7") + cell_array("UInt64", "large", "3000000000") +
                                        cell_array("Float32", "real", "0.5")));
    REQUIRE(decoded.has_value());
    const auto values = [&](const char* name) { return decoded->fields.find(name, Centring::cell)->values; };
    CHECK(values("small") == FieldValues(Column<std::int32_t>(Buffer<std::int32_t>{7})));
    CHECK(values("large") == FieldValues(Column<double>(Buffer<double>{3e9})));
    CHECK(values("real") == FieldValues(Column<double>(Buffer<double>{0.5})));
}
