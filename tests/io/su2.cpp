// SU2 meshes: order of blocks, markers, skipped data and errors.
#include "any_mesh.hpp"
#include "generated.hpp"
#include "property.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <variant>
#include <vector>

using namespace camber;

namespace {

Outcome<DecodedMesh> read(const std::string& text) { return decode_su2(generated::bytes_of(text), "in.su2", {}); }

std::string message(const std::string& text) {
    const auto decoded = read(text);
    return decoded ? "no error" : describe(decoded.error());
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    REQUIRE(at < text.size());
    return text.replace(at, what.size(), by);
}

const std::string elements = "NELEM= 2\n5 0 1 2 0\n5\t0 2 3 1 % the last\n";
const std::string points = "% places\nNPOIN= 4 4\n0 0 0\n1 0 1\n1 1 2\n0 1 3\n";
const std::string markers =
    "NMARK= 2\nMARKER_TAG= lower\nMARKER_ELEMS= 1\n3 0 1\n\nMARKER_TAG= upper\nMARKER_ELEMS= 2\n"
    "3 2 3\n3 3 0 7\n";
const std::string square = "% a square\nNDIME= 2\n" + elements + points + markers;

/// An independent SU2 writer; groups become markers.
template <int D>
std::string su2_of(const LinearMesh<D>& mesh) {
    std::string text = "NDIME= " + std::to_string(D) + "\nNELEM= " + std::to_string(mesh.elements.size()) + "\n";
    const auto row = [](const auto& simplex) {
        std::string words;
        for (const VertexId v : simplex) words += " " + std::to_string(v.index());
        return words;
    };
    for (std::size_t i = 0; i < mesh.elements.size(); ++i)
        text += (D == 2 ? "5" : "10") + row(mesh.elements.vertices[i]) + " " + std::to_string(i) + "\n";
    text += "NPOIN= " + std::to_string(mesh.points.size()) + "\n";
    std::array<char, 40> word{};
    for (const auto& p : mesh.points) {
        for (int c = 0; c < D; ++c) {
            std::snprintf(word.data(), word.size(), "%.17g ", p[c]);
            text += word.data();
        }
        text += "\n";
    }
    text += "NMARK= " + std::to_string(mesh.groups.size()) + "\n";
    for (const Group& group : mesh.groups) {
        const auto n = std::count(mesh.facets.references.begin(), mesh.facets.references.end(), group.reference);
        text += "MARKER_TAG= " + group.name + "\nMARKER_ELEMS= " + std::to_string(n) + "\n";
        for (std::size_t i = 0; i < mesh.facets.size(); ++i)
            if (mesh.facets.references[i] == group.reference)
                text += (D == 2 ? "3" : "5") + row(mesh.facets.vertices[i]) + "\n";
    }
    return text;
}

template <int D>
void check_round_trip() {
    testing::property("a mesh is read with its markers as groups", [](std::uint64_t seed) {
        const auto source = generated::mesh<D>(seed, 1 + seed % 9);
        LinearMesh<D> mesh;
        mesh.points = source.points;
        mesh.point_references = Buffer<Reference>(source.points.size(), 0);
        mesh.elements.vertices = source.elements.vertices;
        mesh.elements.references = Buffer<Reference>(source.elements.size(), 0);
        mesh.facets.vertices = source.facets.vertices;
        Buffer<Reference> references;
        const std::size_t half = source.facets.size() / 2;
        for (std::size_t i = 0; i < source.facets.size(); ++i) references.push_back(i < half ? 1 : 2);
        mesh.facets.references = std::move(references);
        mesh.groups = Buffer<Group>{{D - 1, 1, "wall"}, {D - 1, 2, "far"}};
        const auto back = read(su2_of(mesh));
        if (!back) RC_FAIL(describe(back.error()));
        RC_ASSERT(testing::mesh_in<LinearMesh<D>>(back->mesh) == mesh);
        RC_ASSERT(back->notices.empty());
    });
}

}  // namespace

TEST_CASE("SU2 files give 2D meshes") { check_round_trip<2>(); }
TEST_CASE("SU2 files give 3D meshes") { check_round_trip<3>(); }

TEST_CASE("SU2 reads blocks in any order and markers as groups") {
    const auto decoded = read(square);
    REQUIRE_MESSAGE(decoded.has_value(), message(square));
    const auto& mesh = testing::mesh_in<LinearMesh<2>>(decoded->mesh);
    CHECK(mesh.points[2] == Vec<2>{{1, 1}});
    CHECK(mesh.elements.vertices[1] == SimplexVertices<2>{VertexId(0), VertexId(2), VertexId(3)});
    CHECK(mesh.facets.references == Column<Reference>(Buffer<Reference>{1, 2, 2}));
    CHECK(mesh.groups == Column<Group>(Buffer<Group>{{1, 1, "lower"}, {1, 2, "upper"}}));
    std::array<std::string, 4> blocks{"NDIME=2\n", elements, markers, points};
    std::sort(blocks.begin(), blocks.end());
    do {
        const std::string text = blocks[0] + blocks[1] + blocks[2] + blocks[3];
        CHECK(is_su2(generated::bytes_of(text)));
        REQUIRE_MESSAGE(read(text).has_value(), message(text));
        CHECK(read(text)->mesh == decoded->mesh);
    } while (std::next_permutation(blocks.begin(), blocks.end()));
    // Markers of one name have one reference.
    const auto same = read(replaced(square, "upper", "lower"));
    CHECK(testing::mesh_in<LinearMesh<2>>(same->mesh).facets.references ==
          Column<Reference>(Buffer<Reference>{1, 1, 1}));
    CHECK(testing::mesh_in<LinearMesh<2>>(same->mesh).groups.size() == 1);
    std::string carriage;
    for (const char c : square) carriage += c == '\n' ? std::string("\r\n") : std::string(1, c);
    CHECK(read(carriage)->mesh == decoded->mesh);
}

TEST_CASE("SU2 reports skipped markers and keywords") {
    const auto decoded =
        read(replaced(square, "NMARK= 2\n",
                      "NMARK= 3\nMARKER_TAG= SEND_RECEIVE\nMARKER_ELEMS= 2\nSEND_TO= 1\n1 0 0\n1 1 0\n") +
             "FFD_NBOX= 1\nFFD_NLEVEL= 1\n0 0 0\n");
    REQUIRE(decoded.has_value());
    REQUIRE(decoded->notices.size() == 2);
    CHECK(decoded->notices[0].what == "1 markers SEND_RECEIVE were left out");
    CHECK(decoded->notices[1].what == "2 other keywords were left out, the first of them FFD_NBOX");
    CHECK(testing::mesh_in<LinearMesh<2>>(decoded->mesh).facets.size() == 3);
}

TEST_CASE("unsupported SU2 elements are rejected or counted") {
    const std::string text = replaced(replaced(square, "5 0 1 2 0", "9 0 1 2 3 0"), "3 2 3\n", "5 0 1 2\n");
    CHECK(message(text) ==
          "in.su2: holds 1 quadrilaterals, 1 triangles, which Camber does not support (give a mesh of edges, "
          "triangles and tetrahedra of degree 1 or 2; \"camber info FILE\" counts its cells and names a program that "
          "splits them)");
    CHECK(read(text).error().kind == ErrorKind::unsupported);
    const auto counted =
        decode_su2(generated::bytes_of(text), "in.su2", {.unsupported_cells = UnsupportedCells::count}, {});
    REQUIRE(counted.has_value());
    CHECK(counted->unsupported_cells == std::vector<CellCount>{{"quadrilaterals", 1}, {"triangles", 1}});
    CHECK(testing::mesh_in<LinearMesh<2>>(counted->mesh).elements.size() == 1);
    CHECK(message("NZONE= 2\n" + square) ==
          "in.su2: line 22: NZONE announces 2 zones, but 1 follow (the file is cut off or damaged)");
    CHECK(message("NZONE= 1\n" + square) == "no error");
    CHECK(message(replaced(square, "NDIME= 2", "NDIME= 4")) ==
          "in.su2: NDIME is 4, not 2 or 3 (the file is cut off or damaged)");
}

TEST_CASE("errors in SU2 files give the line") {
    CHECK(message(replaced(square, "5 0 1 2 0", "5 0 1 9 0")) ==
          "in.su2: line 4: triangle 1: a node is not one of those that the file lists (the file is damaged, or was "
          "joined from two files)");
    CHECK(message(replaced(square, "3 3 0 7", "3 3 3 7")).starts_with("in.su2: line 20: edge 3: a node occurs twice"));
    CHECK(message(replaced(square, "5 0 1 2 0", "5 0 1"))
              .starts_with("in.su2: line 4: triangle 1: its row does not have"));
    CHECK(message(replaced(square, "1 0 1\n", "1 x 1\n"))
              .starts_with("in.su2: line 9: vertex 2: its row does not "
                           "have 2"));
    CHECK(message(replaced(square, "1 0 1\n", "1 nan 1\n")).find("a coordinate is infinite") < 40);
    CHECK(message(square + "1 2 3\n").find("is neither a keyword with =") < 40);
    CHECK(message(square + elements).find("occurs a second time") < 40);
    CHECK(message(replaced(square, "NMARK= 2", "NMARK= 3")).find("NMARK announces 3 markers, but 2 follow") < 40);
    CHECK(message(replaced(square, "MARKER_ELEMS= 1", "MARKER_LINES= 1")).find("is not followed by MARKER_ELEMS") < 50);
}

TEST_CASE("truncated SU2 files are rejected or reported") {
    for (std::size_t n = 0; n < square.size(); ++n) {
        CAPTURE(n);
        const auto decoded = read(square.substr(0, n));
        if (decoded && square.substr(n).starts_with("NMARK")) {
            REQUIRE(decoded->notices.size() == 1);
            CHECK(decoded->notices[0].what == "the file has no NMARK, so it has no markers of the boundary");
            continue;
        }
        if (decoded) {  // cut in the last row of a block, which may be complete
            REQUIRE(!decoded->notices.empty());
            CHECK(decoded->notices[0].what == "the last line has no line end, so it may be incomplete");
            continue;
        }
        REQUIRE(!decoded.has_value());
        REQUIRE(!decoded.error().what.empty());
        REQUIRE(decoded.error().where.starts_with("in.su2"));
    }
}

TEST_CASE("SU2 point rows may have an index and a third coordinate") {
    const auto plain = read(square);
    REQUIRE(plain.has_value());
    for (const std::string rows :
         {"0 0 0 0\n1 0 1 1\n1 1 2 2\n0 1 3 3\n", "0 0\n1 0\n1 1\n0 1\n", "0 0 0. 0\n1 0 0. 1\n1 1 0. 2\n0 1 0. 3\n"}) {
        const auto decoded = read(replaced(square, "0 0 0\n1 0 1\n1 1 2\n0 1 3\n", rows));
        REQUIRE(decoded.has_value());
        CHECK(decoded->mesh == plain->mesh);
        CHECK(decoded->notices.empty());
    }
    const auto raised = read(replaced(square, "0 0 0\n1 0 1\n", "0 0 0.5 0\n1 0 -2 1\n"));
    REQUIRE(raised.has_value());
    CHECK(raised->mesh == plain->mesh);
    REQUIRE(raised->notices.size() == 1);
    CHECK(raised->notices[0].what == "2 third coordinates were left out: NDIME is 2");
    CHECK(message(replaced(square, "0 0 0\n", "0 0 0 0 0 0\n"))
              .starts_with("in.su2: line 8: vertex 1: its row does not have 2 coordinates"));
}

TEST_CASE("SU2 zones are joined or read one by one") {
    const std::string second =
        "IZONE= 2\nNDIME= 2\nNELEM= 1\n5 0 1 2\nNPOIN= 3\n5 5\n6 5\n5 6\nNMARK= 1\n"
        "MARKER_TAG= upper\nMARKER_ELEMS= 1\n3 0 1\n";
    const std::string text = "NZONE= 2\nIZONE= 1\n" + square + second;
    const auto joined = read(text);
    REQUIRE_MESSAGE(joined.has_value(), message(text));
    const auto& mesh = testing::mesh_in<LinearMesh<2>>(joined->mesh);
    CHECK(mesh.points.size() == 7);
    CHECK(mesh.elements.vertices[2] == SimplexVertices<2>{VertexId(4), VertexId(5), VertexId(6)});
    CHECK(mesh.elements.references == Column<Reference>(Buffer<Reference>{1, 1, 2}));
    CHECK(mesh.facets.references == Column<Reference>(Buffer<Reference>{1, 2, 2, 2}));
    CHECK(mesh.groups.size() == 2);
    REQUIRE(joined->notices.size() == 1);
    CHECK(joined->notices[0].what.starts_with("2 zones were joined into one mesh"));
    const auto zone = [&](const std::string& number) {
        return decode_su2(generated::bytes_of(text), "in.su2", {.zone = number}, {});
    };
    REQUIRE(zone("1").has_value());
    CHECK(zone("1")->mesh == read(square)->mesh);
    CHECK(testing::mesh_in<LinearMesh<2>>(zone("2")->mesh).elements.size() == 1);
    CHECK(describe(zone("3").error()) == "in.su2: has no zone \"3\" (its zones are 1, 2)");
    CHECK(message(replaced(text, "5 0 1 2\nNPOIN= 3", "5 0 1 3\nNPOIN= 3"))
              .find("triangle 3: a node is not one of those that the file lists") < 40);
    CHECK(message(replaced(text, "NPOIN= 3\n5 5\n6 5\n5 6\n", "")).find("zone 2 lacks one of NDIME") < 40);
}

TEST_CASE("SU2 files with invalid counts are rejected") {
    for (const std::string count : {"4000000000", "9000000000000000000", "99999999999999999999", "-1", "x", "3"}) {
        CHECK(message(replaced(square, "NELEM= 2", "NELEM= " + count)) != "no error");
        CHECK(message(replaced(square, "NPOIN= 4", "NPOIN= " + count)) != "no error");
        CHECK(message(replaced(square, "NMARK= 2", "NMARK= " + count)) != "no error");
        CHECK(message(replaced(square, "MARKER_ELEMS= 1", "MARKER_ELEMS= " + count)) != "no error");
    }
}

TEST_CASE("an SU2 file with noise gives an error or a mesh") {
    testing::property("random characters of an SU2 file are replaced",
                      [](std::uint64_t seed) {
                          generated::Random random(seed);
                          std::string text = square;
                          for (std::size_t i = 0, n = 1 + random.below(4); i < n; ++i)
                              text[random.below(text.size())] = "0123456789 \n-.x%="[random.below(17)];
                          const auto decoded = read(text);
                          RC_ASSERT(decoded.has_value() || !decoded.error().what.empty());
                      },
                      {.count = 2000});
}
