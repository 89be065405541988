// Properties that every row of the format tables has.
#include "any_mesh.hpp"
#include "generated.hpp"
#include "property.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

using namespace camber;

namespace {

AnyMesh some_mesh(std::uint64_t seed) {
    const std::size_t cells = 1 + seed % 20;
    switch (*rc::gen::inRange(0, 4)) {
        case 0: return as_mesh(generated::mesh<2>(seed, cells));
        case 1: return as_mesh(generated::mesh<3>(seed, cells));
        case 2: return as_mesh(generated::quadratic<2>(seed, cells));
        default: return as_mesh(generated::quadratic<3>(seed, cells));
    }
}

bool holds_simplices(const AnyMesh& mesh) {
    return std::visit([](const auto& m) { return generated::holds_simplices(straight_simplices(m)); }, mesh);
}

/// Formats without 2D store a 2D mesh in space.
AnyMesh as_in_file(const MeshFormat& format, const AnyMesh& mesh) {
    return format.is_always_3d ? *raised(mesh, {}, {}) : mesh;
}

Solution some_solution(std::uint64_t seed) {
    generated::Random random(seed);
    Solution result{.dimension = 2 + static_cast<int>(random.below(2)),
                    .fields = {FieldKind::symmetric_tensor, FieldKind::scalar},
                    .rows = random.below(20)};
    Buffer<double> values(result.rows * row_width(result));
    for (double& x : values) x = random.real();
    result.values = std::move(values);
    return result;
}

template <class Format>
void check_unique_names_and_endings(std::span<const Format> formats) {
    std::set<std::string_view> names;
    std::vector<std::string_view> endings;
    for (const Format& format : formats) {
        CHECK(names.insert(format.name).second);
        CHECK(!format.what.empty());
        CHECK((format.decode || format.encode));
        CHECK(format_with_name(formats, format.name) == &format);
        for (const std::string_view ending : format.endings) {
            CHECK(ending.starts_with('.'));
            CHECK(format_with_extension(formats, "a/file" + std::string(ending)) == &format);
            endings.push_back(ending);
        }
    }
    // No ending is a suffix of another, so the result does not depend on the order of rows.
    for (const std::string_view a : endings)
        CHECK(std::count_if(endings.begin(), endings.end(), [&](auto b) { return b.ends_with(a); }) == 1);
}

template <class Format>
std::size_t count_recognising(std::span<const Format> formats, const generated::Bytes& bytes) {
    return static_cast<std::size_t>(
        std::count_if(formats.begin(), formats.end(), [&](const Format& format) { return format.sniff(bytes); }));
}

}  // namespace

TEST_CASE("format names and endings are unique") {
    check_unique_names_and_endings(mesh_formats());
    check_unique_names_and_endings(solution_formats());
}

TEST_CASE("each mesh format recognises only its own files and reads what it has written") {
    for (const MeshFormat& format : mesh_formats())
        if (format.encode && (format.name != "cgns" || has_cgns_support()))
            testing::property(std::string(format.name), [&](std::uint64_t seed) {
                const AnyMesh mesh = some_mesh(seed);
                RC_PRE(holds_simplices(mesh));
                const auto chunks = format.encode(mesh, {}, {}, {});
                if (!chunks) {  // a format may support one degree or dimension only
                    RC_ASSERT(chunks.error().kind == ErrorKind::unsupported);
                    return;
                }
                const auto bytes = generated::joined(*chunks);
                RC_ASSERT(format_with_content(mesh_formats(), bytes) == &format);
                RC_ASSERT(count_recognising(mesh_formats(), bytes) == 1U);
                if (!format.decode) return;
                const auto back = decode_mesh(bytes, "file.of-no-format", {});
                if (!back) RC_FAIL(describe(back.error()));
                // If data is lost, the remaining mesh is unchanged by further round trips.
                if (format.losses(mesh).empty()) RC_ASSERT(as_in_file(format, back->mesh) == as_in_file(format, mesh));
                RC_ASSERT(format.losses(back->mesh).empty());
                const auto again = generated::joined(*format.encode(back->mesh, {}, {}, {}));
                if (format.name == "cgns") {  // HDF5 stores the creation time of objects
                    const auto third = decode_mesh(again, "file.of-no-format", {});
                    RC_ASSERT((third.has_value() && third->mesh == back->mesh));
                    return;
                }
                const bool same = again == bytes;  // not printed, because files are long
                RC_ASSERT(same);
            });
}

TEST_CASE("each solution format recognises only its own files and reads what it has written") {
    for (const SolutionFormat& format : solution_formats())
        if (format.encode)
            testing::property(std::string(format.name), [&](std::uint64_t seed) {
                const Solution solution = some_solution(seed);
                const auto bytes = generated::joined(*format.encode(solution, {}));
                RC_ASSERT(format_with_content(solution_formats(), bytes) == &format);
                RC_ASSERT(count_recognising(solution_formats(), bytes) == 1U);
                if (!format.decode) return;
                const auto back = decode_solution(bytes, "file.of-no-format", {});
                if (!back) RC_FAIL(describe(back.error()));
                RC_ASSERT(back->solution == solution);
            });
}

TEST_CASE("at most one format recognises any bytes") {
    testing::property("random bytes follow the beginning of a file", [](std::uint64_t seed) {
        generated::Random random(seed);
        const auto& format = mesh_formats()[random.below(mesh_formats().size())];
        const bool is_written = format.encode != nullptr;
        RC_PRE(is_written);
        const auto chunks = format.encode(as_mesh(generated::mesh<3>(seed, 3)), {}, {}, {});
        RC_PRE(chunks.has_value());  // some meshes are edges only
        auto bytes = generated::joined(*chunks);
        bytes.resize(random.below(bytes.size()));
        for (std::size_t i = random.below(40); i < bytes.size(); ++i)
            bytes[i] = static_cast<std::byte>(random.below(256));
        RC_ASSERT(count_recognising(mesh_formats(), bytes) <= 1U);
    });
    CHECK(count_recognising(mesh_formats(), {}) == 0);
    CHECK(count_recognising(mesh_formats(),
                            generated::bytes_of("<?xml version=\"1.0\"?><VTKFile type=\"PolyData\">")) == 0);
    CHECK(count_recognising(mesh_formats(), generated::bytes_of("MFEM mesh v1.0\n\ndimension\n2\n")) == 1);
    CHECK(count_recognising(mesh_formats(), generated::bytes_of("% made by hand\n\nNDIME= 2\n")) == 1);
    CHECK(count_recognising(mesh_formats(), generated::bytes_of("MFEM finite element space\n")) == 0);
}

TEST_CASE("a file is read by its content, or by its ending if the content is unknown") {
    const auto text = generated::bytes_of("MeshVersionFormatted 2\nDimension 2\nVertices 0\nEnd\n");
    CHECK(decode_mesh(text, "a.vtu", {}).has_value());
    CHECK(decode_mesh(text, "/dev/stdin", {}).has_value());
    const auto message = [](std::string_view bytes, std::string_view path) {
        const auto decoded = decode_mesh(generated::bytes_of(bytes), path, {});
        return decoded ? "no error" : describe(decoded.error());
    };
    const std::string remedy = " (give a " + listed(readable_extensions(mesh_formats())) + " file)";
    CHECK(remedy.find(".meshb") < remedy.size());
    CHECK(message("of a cube", "in.mesh").starts_with("in.mesh: line 1: this is not a GMF file"));
    CHECK(message("of a cube", "in.xyz") ==
          "in.xyz: neither its first bytes nor its extension belongs to a known format" + remedy);
    CHECK(message("of a cube", "a b/in.PLY") ==
          "a b/in.PLY: neither its first bytes nor its extension belongs to a known format (convert it: meshio "
          "convert 'a b/in.PLY' 'a b/in.vtu')");
    const std::string_view xdmf = "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n";
    CHECK(message(xdmf, "in.xyz") == "in.xyz: XDMF 3 as text can be written, but not read" + remedy);
    CHECK(message(xdmf, "a.xmf") ==
          "a.xmf: XDMF 3 as text can be written, but not read (convert it: meshio convert a.xmf a.vtu)");
    CHECK(conversion_command("it's.step") == "gmsh 'it'\\''s.step' -3 -format msh41 -o 'it'\\''s.msh'");
    CHECK(conversion_command("in.mesh").empty());
    CHECK(message("", "/dev/stdin") == "/dev/stdin: the file is empty" + remedy);
    std::vector<MeshFormat> formats(mesh_formats().begin(), mesh_formats().end());
    for (MeshFormat& format : formats)
        if (format.name == "vtu") format.decode = nullptr;
    const auto only_written = format_to_read(std::span<const MeshFormat>(formats),
                                             generated::bytes_of("<VTKFile type=\"UnstructuredGrid\">"), "in.mesh");
    REQUIRE(!only_written);
    CHECK(describe(only_written.error()).starts_with("in.mesh: VTU (ParaView) can be written, but not read (give a "));
}

TEST_CASE("files of other programs with a shared ending are rejected by program name") {
    const auto message = [](std::string_view bytes) {
        const auto decoded = decode_mesh(generated::bytes_of(bytes), "in.msh", {});
        return decoded ? "no error" : describe(decoded.error());
    };
    CHECK(message("3 1 3\n0 0 1\n1 0 1\n0 1 2\n1 2 3 0\n1 2 1\n2 3 1\n3 1 2\n") ==
          "in.msh: is a mesh of FreeFEM, which Camber cannot read (in FreeFEM: savemesh(Th, \"FILE.mesh\"))");
    CHECK(message("(0 \"made by hand\")\n(2 3)\n")
              .starts_with("in.msh: is a mesh of Fluent, which Camber cannot read "
                           "(meshio"));
    CHECK(message("/COM,ANSYS RELEASE 19\n/PREP7\n").starts_with("in.msh: is a mesh of ANSYS (a .cdb archive), which"));
    CHECK(message("*NODE\n1,0,0,0\n") ==
          "in.msh: is a mesh of Abaqus (.inp), which Camber cannot read (meshio convert --input-format abaqus FILE "
          "NEW.vtu)");
    CHECK(message(std::string("\x89HDF\r\n\x1a\n", 8) + std::string(700, '\0') + "INFOS_GENERALES") ==
          "in.msh: is a mesh of Salome (.med), which Camber cannot read (meshio convert --input-format med FILE "
          "NEW.vtu)");
    CHECK(message("MESH dimension 3 ElemType Tetrahedra Nnode 4\n").starts_with("in.msh: is a mesh of GiD, which"));
    CHECK(message("\n3 1\n") ==
          "in.msh: line 1: this is not an MSH file: it does not begin with $MeshFormat (give a .msh file)");
}

TEST_CASE("the ending or an explicit name selects the output format") {
    const auto written = [](std::string_view path, std::string_view name) {
        const auto format = format_to_write(mesh_formats(), path, name);
        return format ? std::string((*format)->name) : describe(format.error());
    };
    CHECK(written("a.mesh", "") == "gmf-ascii");
    CHECK(written("a.meshb", "") == "gmf-binary");
    CHECK(written("/dev/stdout", "gmf-binary") == "gmf-binary");
    CHECK(written("a.mesh", "vtu") == "vtu");
    CHECK(written("a.vtk", "") == "vtk");
    CHECK(written("a.ply", "") ==
          "a.ply: no format known for this ending (use " + listed(writable_extensions(mesh_formats())) + ")");
    CHECK(written("a.mesh", "ply") ==
          "ply: is not an output format (use " + listed(writable_formats(mesh_formats())) + ")");
    const auto of_solutions = format_to_write(solution_formats(), "a.mesh");
    REQUIRE(!of_solutions);
    CHECK(of_solutions.error().kind == ErrorKind::usage);
    CHECK(of_solutions.error().remedy == "use .sol or .solb");
}

TEST_CASE("a format table accepts additional formats") {
    std::vector<MeshFormat> formats(mesh_formats().begin(), mesh_formats().begin() + 2);
    MeshFormat only_read;
    only_read.name = "toy";
    only_read.what = "a toy";
    only_read.endings = {".toy"};
    only_read.sniff = [](std::span<const std::byte> bytes) { return !bytes.empty() && bytes[0] == std::byte{'T'}; };
    only_read.decode = [](std::span<const std::byte>, std::string_view, const DecodeOptions&,
                          const Execution&) -> Outcome<DecodedMesh> { return DecodedMesh{Mesh<2>{}, {}}; };
    formats.push_back(only_read);
    const std::span<const MeshFormat> all(formats);
    const auto found = format_to_read(all, generated::bytes_of("Toy"), "a.mesh");
    REQUIRE(found);
    CHECK((*found)->name == "toy");
    CHECK(listed(readable_extensions(all)) == ".mesh, .meshb or .toy");
    CHECK(listed(writable_extensions(all)) == ".mesh or .meshb");
    CHECK(!format_to_write(all, "a.toy"));
}

TEST_CASE("GMF reports associations with unknown parameters or distances") {
    auto mesh = generated::mesh<3>(1, 5);
    const VertexId v(std::size_t{1});
    mesh.geometry.on_points = Buffer<Association<0>>{{v, 4}};
    mesh.geometry.on_curves = Buffer<Association<1>>{{v, 7}, {v, 8, {{0.5}}, 0.25}, {v, 9, {{0.75}}}};
    mesh.geometry.on_surfaces = {};
    const auto losses = not_in_gmf(as_mesh(mesh));
    REQUIRE(losses.size() == 2);
    CHECK(losses[0].what ==
          "GMF has no place for 1 associations with curves and surfaces whose parameters are not known");
    CHECK(losses[1].what == "GMF cannot mark distances from curves and surfaces as unknown: 1 are written as 0");
    for (const GmfEncoding encoding : {GmfEncoding::ascii, GmfEncoding::binary}) {
        const auto back =
            decode_gmf_mesh(generated::joined(*encode_gmf_mesh(as_mesh(mesh), {encoding}, {})), "file", {});
        REQUIRE(back);
        const auto& restored = testing::mesh_in<LinearMesh<3>>(back->mesh).geometry;
        CHECK(restored.on_points == mesh.geometry.on_points);
        REQUIRE(restored.on_curves.size() == 2);
        CHECK(restored.on_curves[0] == mesh.geometry.on_curves[1]);
        CHECK(restored.on_curves[1] == Association<1>{v, 9, {{0.75}}, 0.0});
        CHECK(not_in_gmf(as_mesh(testing::mesh_in<LinearMesh<3>>(back->mesh))).empty());
    }
}

namespace {

Buffer<VertexId> numbered(std::size_t count) {
    Buffer<VertexId> vertices;
    for (std::size_t v = 0; v < count; ++v) vertices.emplace_back(v);
    return vertices;
}

/// A unit cube of one hexahedron.
Mesh<3> hexahedron() {
    Mesh<3> mesh;
    mesh.points = Buffer<Vec<3>>{{{0, 0, 0}}, {{1, 0, 0}}, {{1, 1, 0}}, {{0, 1, 0}},
                                 {{0, 0, 1}}, {{1, 0, 1}}, {{1, 1, 1}}, {{0, 1, 1}}};
    mesh.point_references = Buffer<Reference>(8, 0);
    ShapeVertices<Shape::hexahedron> corners;
    std::ranges::copy(numbered(8), corners.begin());
    mesh.elements.of<Shape::hexahedron>().vertices = Buffer<ShapeVertices<Shape::hexahedron>>{corners};
    mesh.elements.of<Shape::hexahedron>().references = Buffer<Reference>{1};
    return mesh;
}

/// A square in space, of one quadrilateral at z = 2.
Mesh<3> square_in_space() {
    Mesh<3> mesh;
    mesh.points = Buffer<Vec<3>>{{{0, 0, 2}}, {{1, 0, 2}}, {{1, 1, 2}}, {{0, 1, 2}}};
    mesh.point_references = Buffer<Reference>(4, 0);
    ShapeVertices<Shape::quadrilateral> corners;
    std::ranges::copy(numbered(4), corners.begin());
    mesh.facets.of<Shape::quadrilateral>().vertices = Buffer<ShapeVertices<Shape::quadrilateral>>{corners};
    mesh.facets.of<Shape::quadrilateral>().references = Buffer<Reference>{3};
    return mesh;
}

}  // namespace

TEST_CASE("formats reject unsupported shapes and degrees by name") {
    const Mesh<3> cubic = *elevate(as_mesh(generated::mesh<3>(3, 5)), 3, {});
    for (const MeshFormat& format : mesh_formats()) {
        if (format.encode == nullptr || (format.name == "cgns" && !has_cgns_support())) continue;
        CAPTURE(format.name);
        const auto shapes = format.encode(hexahedron(), {}, {}, {});
        REQUIRE_FALSE(shapes);
        CHECK(shapes.error().kind == ErrorKind::unsupported);
        CHECK(shapes.error().what.find("1 hexahedron") != std::string::npos);
        const auto degree = format.encode(cubic, {}, {}, {});
        REQUIRE_FALSE(degree);
        CHECK(degree.error().what.find("degree 3") != std::string::npos);
    }
}

TEST_CASE("a flat square of quadrilaterals is converted to 2D and returns to its plane") {
    const auto flat = with_flat_in_2d({square_in_space(), {}}, {});
    REQUIRE((flat.has_value() && flat->lift.has_value()));
    CHECK(flat->lift->z == 2);
    CHECK(std::get<Mesh<2>>(flat->mesh).elements.of<Shape::quadrilateral>().size() == 1);
    CHECK(*raised(flat->mesh, *flat->lift, {}) == AnyMesh(square_in_space()));
    const auto curved = elevate(square_in_space(), 2, {});
    REQUIRE(curved);
    CHECK(with_flat_in_2d({*curved, {}}, {}).error().kind == ErrorKind::unsupported);
}
