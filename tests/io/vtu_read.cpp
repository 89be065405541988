// VTU round trips, foreign files in every encoding, and notices. Damage is in vtu_damage.cpp;
// tests/pipelines/test_readers.py reads files written by VTK.
#include "any_mesh.hpp"
#include "generated.hpp"
#include "property.hpp"
#include "vtu_files.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

using namespace camber;
using namespace vtu_files;

namespace {

/// Returns the data of a mesh that VTU stores.
template <class Mesh>
Mesh storable(Mesh mesh, std::uint64_t seed) {
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
        Buffer<Reference> result;
        for (std::size_t i = 0; i < simplices.size(); ++i) result.push_back(random.reference());
        result[0] = 1;
        simplices.entities = std::move(result);
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
void check_round_trip() {
    testing::property("a VTU file restores the mesh, its entities and its fields", [](std::uint64_t seed) {
        const Mesh mesh = storable(
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
        const auto bytes = generated::joined(*encode_vtu(as_mesh(mesh), fields, options, {}));
        auto back = decode_mesh(bytes, "in.vtu", {});
        if (!back) RC_FAIL(describe(back.error()));
        if (Mesh::dimension == 2) back = with_flat_in_2d(std::move(*back), {});
        RC_ASSERT(testing::holds<Mesh>(back->mesh));
        RC_ASSERT(testing::mesh_in<Mesh>(back->mesh) == mesh);
        RC_ASSERT(back->fields == fields);
        RC_ASSERT(back->notices.empty());
        RC_ASSERT(back->node_numbers.empty());
        RC_ASSERT(generated::joined(*encode_vtu(as_mesh(mesh), back->fields, options, {})) == bytes);
    });
}

void check_four_cells(const std::string& text) {
    const auto decoded = read(text);
    REQUIRE_MESSAGE(decoded.has_value(), (decoded ? "" : describe(decoded.error())));
    const auto& mesh = testing::mesh_in<LinearMesh<3>>(decoded->mesh);
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
    // In Camber's order: the tetrahedron, the triangles, the edge.
    CHECK(std::get<Column<double>>(level->values) == Column<double>(Buffer<double>{3.5, 2.5, 4.5, 1.5}));
    CHECK(std::get<Column<double>>(decoded->fields.find("speed", Centring::node)->values)[11] == 12);
    REQUIRE(decoded->notices.size() == 1);
    CHECK(decoded->notices[0].what == "1 cells that are vertices were left out");
}

}  // namespace

TEST_CASE("VTU files restore meshes and fields") {
    check_round_trip<LinearMesh<2>>();
    check_round_trip<LinearMesh<3>>();
    check_round_trip<QuadraticMesh<2>>();
    check_round_trip<QuadraticMesh<3>>();
}

TEST_CASE("VTU files of meshes without entities have no entity array") {
    auto mesh = storable(generated::mesh<3>(1, 4), 1);
    mesh.elements.entities = mesh.facets.entities = mesh.edges.entities = {};
    const auto text = [&] { return generated::text_of(generated::joined(*encode_vtu(as_mesh(mesh), {}, {}, {}))); };
    CHECK(text().find("\"entity\"") == std::string::npos);
    mesh.facets.entities = Buffer<Reference>(mesh.facets.size() + 1, 1);
    CHECK(encode_vtu(as_mesh(mesh), {}, {}, {}).error().kind == ErrorKind::internal);
    mesh.facets.entities = Buffer<Reference>(mesh.facets.size(), 1);
    CHECK((text().find("\"entity\"") < text().size()) == (mesh.facets.size() > 0));
}

TEST_CASE("VTU reads every encoding, word size, byte order and number type") {
    for (const Form form : {Form::ascii, Form::binary, Form::split_binary, Form::appended_raw, Form::appended_base64})
        for (const bool big : {false, true})
            for (const bool wide : {false, true}) {
                CAPTURE(static_cast<int>(form));
                CAPTURE(big);
                CAPTURE(wide);
                const File file(form, big, wide);
                check_four_cells(four_cells<std::int64_t, double>(file, "Int64", "Float64"));
                check_four_cells(four_cells<std::int32_t, float>(file, "Int32", "Float32"));
                check_four_cells(four_cells<std::uint16_t, double>(file, "UInt16", "Float64"));
                check_four_cells(four_cells<std::int8_t, float>(file, "Int8", "Float32"));
                check_four_cells(four_cells<std::uint64_t, double>(file, "UInt64", "Float64"));
            }
}

TEST_CASE("VTU references come from the whole-number array of highest priority") {
    const auto references = [](const std::string& cell_data) {
        const auto decoded = read(plain("5 5", "0 1 2 0 1 3", "3 6", cell_data));
        REQUIRE(decoded.has_value());
        const auto& mesh = testing::mesh_in<LinearMesh<3>>(decoded->mesh);
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

TEST_CASE("VTU reports arrays that it leaves out") {
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
          "1 arrays were left out, since they are not numeric: words");
    CHECK(notices(cell_array("Float64", "reference", "1.5")) ==
          "1 arrays were left out, since their values differ from those that Camber writes under these names: "
          "reference");
    CHECK(notices(cell_array("UInt8", "dimension", "3")).ends_with("under these names: dimension"));
    CHECK(notices("", cell_array("Int32", "", "1 2 3 4 5"))
              .starts_with("1 arrays were left out, since they have no name"));
    CHECK(message(plain("5", "0 1 2", "3", cell_array("Float64", "short", "1 2"))) ==
          "in.vtu: line 5: the array short has 2 numbers, not 1 for each of 1 rows (the file is damaged, or was "
          "joined from two files)");
}

TEST_CASE("VTU keeps the last array of a name and reports the others") {
    const auto decoded =
        read(plain("5", "0 1 2", "3",
                   cell_array("Int32", "x", "1") + cell_array("Int32", "reference", "4") +
                       cell_array("Int32", "x", "2") + cell_array("Int32", "reference", "5"),
                   cell_array("Int32", "reference", "1 1 1 1 1") + cell_array("Int32", "reference", "2 2 2 2 2")));
    REQUIRE(decoded.has_value());
    REQUIRE(decoded->fields.size() == 1);
    CHECK(decoded->fields.find("x", Centring::cell)->values ==
          FieldValues(Column<std::int32_t>(Buffer<std::int32_t>{2})));
    const auto& mesh = testing::mesh_in<LinearMesh<3>>(decoded->mesh);
    CHECK(mesh.facets.references[0] == 5);
    CHECK(mesh.point_references[0] == 2);
    REQUIRE(decoded->notices.size() == 1);
    CHECK(decoded->notices[0].what ==
          "3 arrays were left out, since a later array has the same name: reference, x, reference");
}

TEST_CASE("VTU integers keep their type if they fit 32 bits") {
    const auto decoded = read(plain("5", "0 1 2", "3",
                                    cell_array("UInt32", "small", "7") + cell_array("UInt64", "large", "3000000000") +
                                        cell_array("Float32", "real", "0.5")));
    REQUIRE(decoded.has_value());
    const auto values = [&](const char* name) { return decoded->fields.find(name, Centring::cell)->values; };
    CHECK(values("small") == FieldValues(Column<std::int32_t>(Buffer<std::int32_t>{7})));
    CHECK(values("large") == FieldValues(Column<double>(Buffer<double>{3e9})));
    CHECK(values("real") == FieldValues(Column<double>(Buffer<double>{0.5})));
}
