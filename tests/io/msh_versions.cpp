// Older versions of MSH that are only read, and harmless deviations.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "any_mesh.hpp"
#include "generated.hpp"
#include "property.hpp"

import camber.core;
import camber.io;

using namespace camber;

namespace {

Outcome<DecodedMesh> read(const std::string& text) {
    return decode_msh(generated::bytes_of(text), "in.msh", {.threads = 1});
}
DecodedMesh decoded(const std::string& text) {
    auto result = read(text);
    INFO((result ? std::string() : describe(result.error())));
    REQUIRE(result.has_value());
    return std::move(*result);
}
std::string message(const std::string& text) {
    const auto result = read(text);
    return result ? "no error" : describe(result.error());
}

const std::string head_22 = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const std::string nodes_22 = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n";

/// A tetrahedron with one face and one edge, in groups 4, 5 and 6, on entities 1, 2 and 3.
const std::string tetrahedron_22 =
    head_22 + nodes_22 + "$Elements\n3\n1 1 2 6 3 1 2\n2 2 2 5 2 1 3 2\n3 4 2 4 1 1 2 3 4\n$EndElements\n";
const std::string tetrahedron_1 =
    "$NOD\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$ENDNOD\n$ELM\n3\n1 1 6 3 2 1 2\n2 2 5 2 3 1 3 2\n"
    "3 4 4 1 4 1 2 3 4\n$ENDELM\n";

/// Numbers of version 4.0, as text or in binary.
class Writer {
  public:
    explicit Writer(bool binary)
        : binary_(binary), text_("$MeshFormat\n4.0 " + std::string(binary ? "1" : "0") + " 8\n") {
        if (binary) integer(1);
        put("\n$EndMeshFormat\n");
    }
    Writer& put(std::string_view words) {
        text_ += words;
        return *this;
    }
    Writer& integer(std::int32_t value) { return number(value); }
    Writer& count(std::uint64_t value) { return number(value); }
    Writer& real(double value) { return number(value); }
    [[nodiscard]] const std::string& text() const { return text_; }

  private:
    template <class T>
    Writer& number(T value) {
        if (!binary_) {
            text_ += std::to_string(value) + " ";
            return *this;
        }
        std::string bytes(sizeof value, '\0');
        std::memcpy(bytes.data(), &value, sizeof value);
        text_ += bytes;
        return *this;
    }

    bool binary_;
    std::string text_;
};

/// The same tetrahedron in version 4.0.
std::string tetrahedron_40(bool binary) {
    Writer file(binary);
    file.put("$Entities\n").count(0).count(1).count(1).count(1);
    for (const auto& [entity, group] : {std::pair(3, 6), std::pair(2, 5), std::pair(1, 4)}) {
        file.integer(entity);
        for (int i = 0; i < 6; ++i) file.real(0);
        file.count(1).integer(group).count(0);
    }
    file.put("\n$EndEntities\n$Nodes\n").count(1).count(4);
    file.integer(1).integer(3).integer(0).count(4);
    const double places[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int v = 0; v < 4; ++v) {
        file.integer(v + 1);
        for (const double x : places[v]) file.real(x);
    }
    file.put("\n$EndNodes\n$Elements\n").count(3).count(3);
    file.integer(3).integer(1).integer(1).count(1).integer(1).integer(1).integer(2);
    file.integer(2).integer(2).integer(2).count(1).integer(2).integer(1).integer(3).integer(2);
    file.integer(1).integer(3).integer(4).count(1).integer(3).integer(1).integer(2).integer(3).integer(4);
    return file.put("\n$EndElements\n").text();
}

}  // namespace

TEST_CASE("MSH files of versions 1, 2.2 and 4.0 give the same mesh") {
    const DecodedMesh mesh = decoded(tetrahedron_22);
    CHECK(testing::mesh_in<LinearMesh<3>>(mesh.mesh).facets.references == Column<Reference>(Buffer<Reference>{5}));
    CHECK(decoded(tetrahedron_1).mesh == mesh.mesh);
    for (const bool binary : {false, true}) CHECK(decoded(tetrahedron_40(binary)).mesh == mesh.mesh);
    for (const std::string& text : {tetrahedron_1, tetrahedron_40(false), tetrahedron_40(true)}) {
        const auto bytes = generated::bytes_of(text);
        CHECK(std::ranges::count_if(mesh_formats(), [&](const MeshFormat& f) { return f.sniff(bytes); }) == 1);
    }
}

TEST_CASE("truncated MSH files of versions 1 and 4.0 are rejected") {
    for (const std::string& text : {tetrahedron_1, tetrahedron_40(false), tetrahedron_40(true)})
        for (std::size_t n = 0; n + 2 < text.size(); ++n) {
            CAPTURE(n);
            const auto cut = read(text.substr(0, n));
            REQUIRE(!cut.has_value());
            REQUIRE(cut.error().where.starts_with("in.msh"));
        }
}

TEST_CASE("an MSH file of version 1 or 4.0 with noise gives an error or a mesh") {
    testing::property("random bytes of an old MSH file are replaced",
                      [](std::uint64_t seed) {
                          generated::Random random(seed);
                          std::string text = seed % 3 == 0 ? tetrahedron_1 : tetrahedron_40(seed % 3 == 1);
                          for (std::size_t i = 0, n = 1 + random.below(4); i < n; ++i)
                              text[random.below(text.size())] = static_cast<char>(random.below(256));
                          const auto result = read(text);
                          RC_ASSERT(result.has_value() || !result.error().what.empty());
                      },
                      {.count = 2000});
}

TEST_CASE("MSH group names without dimension take the dimension of their elements") {
    const std::string text =
        "$MeshFormat\n2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n5 \"the wall\"\n4 \"air\"\n9 \"none\"\n"
        "$EndPhysicalNames\n" +
        tetrahedron_22.substr(head_22.size());
    CHECK(testing::mesh_in<LinearMesh<3>>(decoded(text).mesh).groups ==
          Column<Group>(Buffer<Group>{{2, 5, "the wall"}, {3, 4, "air"}}));
}

TEST_CASE("MSH lines from a node to itself are left out with a notice") {
    const DecodedMesh mesh =
        decoded(head_22 + nodes_22 + "$Elements\n3\n1 1 2 6 3 2 2\n2 1 2 6 3 1 2\n3 4 2 4 1 1 2 3 4\n$EndElements\n");
    CHECK(testing::mesh_in<LinearMesh<3>>(mesh.mesh).edges.size() == 1);
    REQUIRE(mesh.notices.size() == 1);
    CHECK(mesh.notices[0].what == "1 lines from a node to itself were left out: they have no length");
    CHECK(message(head_22 + nodes_22 + "$Elements\n1\n1 2 2 6 3 2 2 1\n$EndElements\n").find("a node occurs twice") <
          50);
}

TEST_CASE("MSH surfaces keep named groups and three triangles on an edge") {
    const auto read = decoded(head_22 + "$PhysicalNames\n2\n2 1 \"left\"\n2 9 \"fin\"\n$EndPhysicalNames\n" +
                              "$Nodes\n5\n1 0 0 0\n2 0 1 0\n3 -1 0 0\n4 1 0 0\n5 0 0 1\n$EndNodes\n" +
                              "$Elements\n3\n1 2 2 1 11 1 2 3\n2 2 2 1 12 2 1 4\n3 2 2 9 13 1 2 5\n$EndElements\n");
    const auto& mesh = testing::mesh_in<LinearMesh<3>>(read.mesh);
    CHECK(mesh.elements.size() == 0);
    CHECK(mesh.facets.references == Column<Reference>(Buffer<Reference>{1, 1, 9}));
    CHECK(mesh.facets.entities == Column<Reference>(Buffer<Reference>{11, 12, 13}));
    CHECK(mesh.facets.vertices[2] == SimplexVertices<2>{VertexId(0), VertexId(1), VertexId(4)});
    CHECK(mesh.groups == Column<Group>(Buffer<Group>{{2, 1, "left"}, {2, 9, "fin"}}));
    CHECK(read.notices.empty());
}

TEST_CASE("content after the last MSH section is ignored with a notice") {
    const DecodedMesh mesh = decoded(tetrahedron_22 + "made by hand\n");
    CHECK(mesh.mesh == decoded(tetrahedron_22).mesh);
    REQUIRE(mesh.notices.size() == 1);
    CHECK(mesh.notices[0].what == "all data after the last section was not read (13 bytes)");
    CHECK(message(head_22 + nodes_22 + "a remark\n" + tetrahedron_22.substr(head_22.size() + nodes_22.size()))
              .find("a section ($…) is missing here") < 40);
}

TEST_CASE("unsupported MSH cells are counted on request") {
    const std::string text =
        head_22 + nodes_22 + "$Elements\n3\n1 3 2 6 3 1 2 3 4\n2 4 2 4 1 1 2 3 4\n3 3 2 6 3 1 2 3 4\n$EndElements\n";
    const auto counted =
        decode_msh(generated::bytes_of(text), "in.msh", {.unsupported_cells = UnsupportedCells::count}, {});
    REQUIRE(counted.has_value());
    CHECK(counted->unsupported_cells == std::vector<CellCount>{{"quadrangles", 2}});
    CHECK(testing::mesh_in<LinearMesh<3>>(counted->mesh).elements.size() == 1);
}
