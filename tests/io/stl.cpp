// Round trips, foreign text and damage of STL files.
#include "any_mesh.hpp"
#include "generated.hpp"
#include "property.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <variant>
#include <vector>

using namespace camber;

namespace {

Outcome<DecodedMesh> read(const generated::Bytes& bytes) { return decode_stl(bytes, "in.stl", {}, {}); }
Outcome<DecodedMesh> read(const std::string& text) { return read(generated::bytes_of(text)); }

template <class Input>
std::string message(const Input& input) {
    const auto decoded = read(input);
    return decoded ? "no error" : describe(decoded.error());
}

generated::Bytes written(const LinearMesh<3>& mesh, StlEncoding encoding) {
    return generated::joined(*encode_stl(as_mesh(mesh), encoding, {}));
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    REQUIRE(at < text.size());
    return text.replace(at, what.size(), by);
}

/// A surface with vertices in random order, some unused, with 32-bit coordinates and zeros of both signs.
LinearMesh<3> surface(std::uint64_t seed, std::size_t references) {
    generated::Random random(seed);
    LinearMesh<3> mesh;
    Buffer<Vec<3>> points;
    const std::size_t n = 4 + random.below(12);
    for (std::size_t v = 0; v < n; ++v) {
        const auto x = static_cast<float>(random.below(1000)) * 0.1F;
        points.push_back({{x, v % 3 == 0 ? -0.0 : 0.0, static_cast<double>(v)}});
    }
    Buffer<SimplexVertices<2>> triangles;
    Buffer<Reference> of;
    for (std::size_t t = 0; t < 1 + seed % 20; ++t) {
        const std::size_t a = random.below(n), b = (a + 1 + random.below(n - 2)) % n;
        std::size_t c = random.below(n);
        while (c == a || c == b) c = (c + 1) % n;
        triangles.push_back({VertexId(a), VertexId(b), VertexId(c)});
        of.push_back(static_cast<Reference>(1 + random.below(references)));
    }
    mesh.point_references = Buffer<Reference>(n, 0);
    mesh.points = std::move(points);
    mesh.facets.vertices = std::move(triangles);
    mesh.facets.references = std::move(of);
    return mesh;
}

using Corners = std::vector<std::array<double, 9>>;
Corners corners_of(const LinearMesh<3>& mesh) {
    Corners all;
    for (const auto& triangle : mesh.facets.vertices) {
        std::array<double, 9> corners{};
        for (std::size_t i = 0; i < 9; ++i) corners[i] = mesh.points[triangle[i / 3]][static_cast<int>(i % 3)];
        all.push_back(corners);
    }
    return all;
}
Corners sorted(Corners corners) {
    std::sort(corners.begin(), corners.end());
    return corners;
}

const std::string facet =
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
const std::string other =
    "  FACET NORMAL nan nan nan\n\tOUTER LOOP\r\n VERTEX 1 -0 -0.\n VERTEX +1 1 0\n VERTEX 0 1D0 0\n ENDLOOP\n "
    "ENDFACET\n";
const std::string solid = "solid one\n" + facet + "endsolid one\n";

}  // namespace

TEST_CASE("STL files restore surfaces with their orientation") {
    for (const StlEncoding encoding : {StlEncoding::ascii, StlEncoding::binary})
        testing::property(
            encoding == StlEncoding::ascii ? "text STL files restore surfaces" : "binary STL files restore surfaces",
            [&](std::uint64_t seed) {
                const LinearMesh<3> mesh = surface(seed, 1 + seed % 4);
                const auto bytes = written(mesh, encoding);
                const auto first = read(bytes);
                if (!first) RC_FAIL(describe(first.error()));
                RC_ASSERT(first->notices.empty());
                const auto& back = testing::mesh_in<LinearMesh<3>>(first->mesh);
                RC_ASSERT(sorted(corners_of(back)) == sorted(corners_of(mesh)));
                if (encoding == StlEncoding::binary) RC_ASSERT(corners_of(back) == corners_of(mesh));
                RC_ASSERT(not_in_stl(as_mesh(back), encoding).empty());
                const auto second = read(written(back, encoding));
                RC_ASSERT((second.has_value() && testing::mesh_in<LinearMesh<3>>(second->mesh) == back));
                const auto third = read(written(back, StlEncoding::ascii));
                RC_ASSERT((third.has_value() &&
                           corners_of(testing::mesh_in<LinearMesh<3>>(third->mesh)) == corners_of(back)));
            });
}

TEST_CASE("STL solids become references with their names") {
    LinearMesh<3> mesh = surface(19, 1);
    Buffer<Reference> references;
    for (std::size_t t = 0; t < mesh.facets.size(); ++t) references.push_back(t % 2 == 0 ? 9 : -4);
    mesh.facets.references = std::move(references);
    mesh.groups = Buffer<Group>{{2, 9, " the\nwall "}, {1, -4, "a line"}};
    const auto decoded = read(written(mesh, StlEncoding::ascii));
    REQUIRE(decoded);
    const auto& back = testing::mesh_in<LinearMesh<3>>(decoded->mesh);
    CHECK(back.groups == Column<Group>(Buffer<Group>{{2, 1, "reference_-4"}, {2, 2, "the wall"}}));
    CHECK(back.facets.references[0] == 1);
    CHECK(back.facets.references[back.facets.size() - 1] == 2);
    const auto losses = not_in_stl(as_mesh(mesh), StlEncoding::ascii);
    REQUIRE(losses.size() == 3);
    CHECK(losses[0].what.starts_with("STL lists only triangles, solid by solid"));
    CHECK(losses[1].what == "STL cannot hold 1 names of references: \" the?wall \" becomes \"the wall\"");
    CHECK(losses[2].what ==
          "STL stores references as solids: they become 1, 2 and so on, with the names of the solids");
    CHECK(not_in_stl(as_mesh(mesh), StlEncoding::binary)[1].what == "STL in binary has no place for references");
}

TEST_CASE("STL text in the layouts of other programs is read") {
    const auto decoded = read("\n" + solid + "SOLID\n" + other + "ENDSOLID\nsolid one\n" + other + "endsolid\nsolid\n" +
                              facet + "endsolid\nsolid none\nendsolid none");
    REQUIRE(decoded);
    const auto& mesh = testing::mesh_in<LinearMesh<3>>(decoded->mesh);
    CHECK(mesh.points.size() == 4);
    CHECK(mesh.facets.references == Column<Reference>(Buffer<Reference>{1, 2, 1, 3}));
    CHECK(mesh.groups == Column<Group>(Buffer<Group>{{2, 1, "one"}}));
    CHECK(mesh.facets.vertices[1] == SimplexVertices<2>{VertexId(1), VertexId(3), VertexId(2)});
    CHECK(is_stl(generated::bytes_of("\r\n Solid"), StlEncoding::ascii));
    CHECK(!is_stl(generated::bytes_of("solidity"), StlEncoding::ascii));
}

TEST_CASE("STL leaves out and counts triangles with coincident corners") {
    const std::string flat = replaced(facet, "vertex 1 0 0", "vertex 0 -0 0");
    const auto decoded = read("solid a\n" + flat + "endsolid\nsolid b\n" + flat + facet + "endsolid\n");
    REQUIRE(decoded);
    const auto& mesh = testing::mesh_in<LinearMesh<3>>(decoded->mesh);
    CHECK(mesh.facets.size() == 1);
    CHECK(mesh.groups == Column<Group>(Buffer<Group>{{2, 1, "b"}}));
    REQUIRE(decoded->notices.size() == 1);
    CHECK(decoded->notices[0].what == "2 triangles with two corners at the same position were left out");
    LinearMesh<3> fine = mesh;
    fine.points = Buffer<Vec<3>>{{{1, 0, 0}}, {{1 + 1e-12, 0, 0}}, {{0, 1, 0}}};
    CHECK(written(fine, StlEncoding::binary).size() == 84);
    CHECK(not_in_stl(as_mesh(fine), StlEncoding::binary)[0].what ==
          "STL cannot store triangles without area: 1 are left out");
    CHECK(not_in_stl(as_mesh(fine), StlEncoding::ascii).empty());
    fine.points = Buffer<Vec<3>>{{{1e39, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}};
    const auto large = encode_stl(as_mesh(fine), StlEncoding::binary, {});
    REQUIRE(!large);
    CHECK(large.error().kind == ErrorKind::unsupported);
}

TEST_CASE("the file size distinguishes binary STL from text") {
    auto bytes = written(surface(7, 1), StlEncoding::binary);
    const auto plain = read(bytes);
    REQUIRE(plain);
    for (const std::string header : {"solid of another program", ""}) {
        std::fill_n(bytes.begin(), 80, std::byte{0});
        std::memcpy(bytes.data(), header.data(), header.size());
        CHECK(is_stl(bytes, StlEncoding::binary));
        CHECK(!is_stl(bytes, StlEncoding::ascii));
        const auto decoded = read(bytes);
        REQUIRE(decoded);
        CHECK(decoded->mesh == plain->mesh);
    }
    std::memcpy(bytes.data(), "solid", 5);
    bytes[84 + 48] = std::byte{7};  // the attribute bytes, which some programs use for colours
    CHECK(read(bytes)->mesh == plain->mesh);
    auto longer = bytes;
    longer.push_back(std::byte{0});
    CHECK(message(longer) ==
          "in.stl: byte 80: announces 8 triangles of 50 bytes, but 401 bytes follow (the file is "
          "cut off, or its count is wrong)");
    std::fill_n(longer.begin() + 80, 4, std::byte{0xff});
    CHECK(message(longer).starts_with("in.stl: byte 80: announces 4294967295 triangles of 50 bytes, but 401 bytes"));
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(bytes.data() + 84 + 50 * 2, &nan, 4);  // part of a normal, which is not read
    CHECK(read(bytes)->mesh == plain->mesh);
    std::memcpy(bytes.data() + 84 + 50 * 2 + 12 + 8, &nan, 4);
    CHECK(message(bytes) ==
          "in.stl: byte 184: triangle 3: a coordinate is infinite or not a number (the program that wrote the file "
          "failed there. Write it again)");
}

TEST_CASE("errors in STL text give the line") {
    CHECK(message(solid) == "no error");
    CHECK(message(replaced(solid, "1 0 0", "1 x 0")) ==
          "in.stl: line 5: triangle 1: a number is malformed (the file is cut off or damaged)");
    CHECK(message(replaced(solid, "1 0 0", "1 inf 0")) ==
          "in.stl: line 5: triangle 1: a coordinate is infinite or not a number (the program that wrote the file "
          "failed there. Write it again)");
    CHECK(message(replaced(solid, "0 1 0", "0 1")) ==
          "in.stl: line 7: triangle 1: a number is malformed (the file is cut off or damaged)");
    CHECK(message(replaced(solid, "endloop", "vertex 1 1 0\nendloop")) ==
          "in.stl: line 7: triangle 1: has more corners than three (write it again with triangles only)");
    CHECK(message(replaced(solid, "endsolid one", "")) ==
          "in.stl: line 10: the file ends where facet or endsolid is expected (it seems to be cut off)");
    CHECK(message(solid + "and more") ==
          "in.stl: line 10: has no solid where it is expected (the file is cut off or damaged)");
    CHECK(message(std::string()) == "in.stl: byte 0: the file is empty (write it again)");
    CHECK(message(std::string("of a cube")) ==
          "in.stl: byte 9: the file ends within the 84 bytes of a binary STL header, and is not text (it seems to be "
          "cut off)");
}

TEST_CASE("truncated and damaged STL files give an error with its position or a mesh") {
    for (const StlEncoding encoding : {StlEncoding::ascii, StlEncoding::binary}) {
        const auto whole = written(surface(3, 2), encoding);
        const auto end = encoding == StlEncoding::ascii ? whole.size() - std::strlen(" reference_2\n") : whole.size();
        for (std::size_t n = 0; n < end; ++n) {
            const auto decoded = read(generated::Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n)));
            CAPTURE(n);
            // A text file cut between two solids is complete.
            const std::string text = generated::text_of(whole).substr(0, n);
            if (encoding == StlEncoding::ascii && text.find("endsolid") < n) continue;
            REQUIRE(!decoded);
            REQUIRE(decoded.error().where.starts_with("in.stl: "));
        }
        testing::property("random bytes of an STL file are replaced", [&](std::uint64_t seed) {
            generated::Random random(seed);
            auto bytes = whole;
            for (std::size_t i = 0; i < 1 + random.below(4); ++i)
                bytes[random.below(bytes.size())] = static_cast<std::byte>(random.below(256));
            const auto decoded = read(bytes);
            if (!decoded) {
                RC_ASSERT(decoded.error().where.starts_with("in.stl: "));
                return;
            }
            const auto& mesh = testing::mesh_in<LinearMesh<3>>(decoded->mesh);
            for (const auto& triangle : mesh.facets.vertices)
                for (const VertexId v : triangle) RC_ASSERT(v.index() < mesh.points.size());
        });
    }
}
