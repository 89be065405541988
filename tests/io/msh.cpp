// Gmsh files: round trips of every version, encoding and byte order, foreign files, and errors.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "any_mesh.hpp"
#include "generated.hpp"
#include "msh_swapped.hpp"
#include "property.hpp"
#include "sanitized.hpp"

import camber.core;
import camber.bezier;
import camber.io;

using namespace camber;

namespace {

constexpr std::array kinds{
    MshOptions{MshVersion::v4, MshEncoding::binary}, MshOptions{MshVersion::v4, MshEncoding::ascii},
    MshOptions{MshVersion::v2, MshEncoding::binary}, MshOptions{MshVersion::v2, MshEncoding::ascii}};

/// References 1 to 5, with entities that each have one reference.
template <int K>
Simplices<K> with_groups(generated::Random& random, Simplices<K> simplices) {
    Buffer<Reference> references, entities;
    for (std::size_t i = 0; i < simplices.size(); ++i) {
        references.push_back(static_cast<Reference>(1 + random.below(5)));
        entities.push_back(static_cast<Reference>(10 * references.back() + static_cast<Reference>(random.below(3))));
    }
    return {simplices.vertices, std::move(references), {}, std::move(entities)};
}

/// Associates each vertex with one entity. Version 2 stores only points, all with a reference.
template <int D>
InputGeometry<D> classified(generated::Random& random, std::size_t vertices, MshVersion version,
                            Buffer<Reference>& references) {
    Buffer<Association<0>> on_points;
    Buffer<Association<1>> on_curves;
    Buffer<Association<2>> on_surfaces;
    for (std::size_t v = 0; v < vertices; ++v) {
        const VertexId id(v);
        const std::size_t kind = random.below(version == MshVersion::v4 ? 6 : 2);
        if (kind == 0) {
            references[v] = static_cast<Reference>(1 + random.below(4));
            on_points.push_back({id, 4 * static_cast<Reference>(random.below(5)) + references[v]});
        }
        if (version == MshVersion::v2) continue;
        const auto entity = static_cast<Reference>(1 + random.below(3));
        if (kind == 1) on_points.push_back({id, 100 + entity});
        if (kind == 2) on_curves.push_back({id, entity});
        if (kind == 3) on_curves.push_back({id, entity, {{random.real()}}});
        if (kind == 4) on_surfaces.push_back({id, entity});
        if (kind == 5) on_surfaces.push_back({id, entity, {{random.real(), random.real()}}});
    }
    return {{}, {}, std::move(on_points), std::move(on_curves), std::move(on_surfaces)};
}

/// A mesh that a file of this version stores without loss.
template <int D>
LinearMesh<D> storable(LinearMesh<D> mesh, std::uint64_t seed, MshVersion version) {
    generated::Random random(seed + 2);
    Buffer<Reference> references(mesh.points.size(), 0);
    mesh.corners = {};
    mesh.required_vertices = {};
    mesh.ridges = {};
    mesh.elements = with_groups(random, std::move(mesh.elements));
    mesh.facets = with_groups(random, std::move(mesh.facets));
    mesh.edges = with_groups(random, std::move(mesh.edges));
    mesh.geometry = classified<D>(random, mesh.points.size(), version, references);
    mesh.point_references = std::move(references);
    mesh.groups = Buffer<Group>{{D, 2, "steel & air"}, {D - 1, 2, "wall"}, {D - 1, 77, "nobody has it"}, {0, 3, ""}};
    return mesh;
}
template <int D>
QuadraticMesh<D> storable(QuadraticMesh<D> mesh, std::uint64_t seed, MshVersion version) {
    mesh.linear = storable(std::move(mesh.linear), seed, version);
    return mesh;
}

/// The mesh in space, as the file stores it.
AnyMesh in_space(const AnyMesh& mesh) { return *raised(mesh, Lift{}, {}); }

template <int D>
void check_round_trips() {
    testing::property("MSH files restore meshes of dimension " + std::to_string(D), [](std::uint64_t seed) {
        for (const MshOptions kind : kinds) {
            const std::size_t cells = 1 + seed % 20;
            const auto straight = storable(generated::mesh<D>(seed, cells), seed, kind.version);
            const auto curved = storable(generated::quadratic<D>(seed, cells), seed, kind.version);
            RC_ASSERT(not_in_msh(as_mesh(straight), kind.version).empty());
            RC_PRE(generated::holds_simplices(straight));
            const auto first = generated::joined(*encode_msh(as_mesh(straight), {}, kind, {}));
            const auto second = generated::joined(*encode_msh(as_mesh(curved), {}, kind, {}));
            for (const auto& [bytes, mesh] :
                 {std::pair(first, AnyMesh(as_mesh(straight))), std::pair(second, AnyMesh(as_mesh(curved)))}) {
                const auto back = decode_msh(bytes, "file", {});
                if (!back) RC_FAIL(describe(back.error()));
                RC_ASSERT(back->mesh == in_space(mesh));
                RC_ASSERT(back->notices.empty());
                if (kind.encoding == MshEncoding::ascii) continue;
                const auto swapped = decode_msh(msh_swapped::swapped(bytes), "file", {});
                if (!swapped) RC_FAIL(describe(swapped.error()));
                RC_ASSERT(swapped->mesh == back->mesh);
            }
        }
    });
}

std::string message(std::string_view text) {
    const auto decoded = decode_msh(generated::bytes_of(text), "file", {.threads = 1});
    return decoded ? "no error" : describe(decoded.error());
}
DecodedMesh decoded(std::string_view text) {
    auto result = decode_msh(generated::bytes_of(text), "file", {.threads = 1});
    INFO((result ? std::string() : describe(result.error())));
    REQUIRE(result.has_value());
    return std::move(*result);
}
bool has_notice(const DecodedMesh& mesh, std::string_view what) {
    return std::any_of(mesh.notices.begin(), mesh.notices.end(), [&](const Notice& n) { return n.what == what; });
}

std::string of_version(std::string_view version) {
    return "$MeshFormat\n" + std::string(version) + " 0 8\n$EndMeshFormat\n";
}
/// Three nodes with distant tags out of order, followed by the rest of the file.
std::string triangle_2(std::string_view elements) {
    return of_version("2.2") + "$Nodes\n3\n9000000000000000000 0 1 0\n7 0 0 0\n100000 1 0 0\n$EndNodes\n" +
           std::string(elements);
}
const std::string entities_4 =
    "$Entities\n1 2 1 0\n"
    "5 0 0 0 1 8\n"
    "6 0 0 0 1 0 0 2 -3 4 0\n7 0 0 0 0 1 0 0 0\n"
    "8 0 0 0 1 1 0 1 2 2 6 -7\n"
    "$EndEntities\n";
const std::string nodes_4 =
    "$Nodes\n3 3 3 40\n0 5 0 1\n7\n0 0 0\n1 6 1 1\n40\n1 0 0 0.25\n2 8 1 1\n3\n0 1 0 0.5 0.75\n$EndNodes\n";
const std::string elements_4 =
    "$Elements\n4 5 1 9\n0 5 15 1\n9 7\n1 6 1 1\n4 7 40\n1 7 1 1\n5 3 7\n2 8 2 1\n1 7 40 3\n$EndElements\n";

}  // namespace

TEST_CASE("MSH files restore meshes in either byte order") {
    check_round_trips<2>();
    check_round_trips<3>();
}

TEST_CASE("MSH 4 preserves the membership of simplices in several groups") {
    testing::property("MSH 4 restores the group names of each simplex", [](std::uint64_t seed) {
        generated::Random random(seed);
        auto mesh = storable(generated::mesh<3>(seed, 1 + seed % 20), seed, MshVersion::v4);
        RC_PRE(generated::holds_simplices(mesh));
        Buffer<Group> groups;
        const auto name = [](std::size_t tag) { return "group " + std::to_string(tag); };
        for (const int dimension : {3, 2, 1})
            for (std::size_t reference = 1; reference <= 5; ++reference) {
                const auto tag = static_cast<Reference>(reference);
                groups.push_back({dimension, tag, name(reference)});
                for (std::size_t other = 1; other <= 7; ++other)  // groups 6 and 7 are not the main group of a
                                                                  // reference
                    if (other != reference && random.below(4) == 0) groups.push_back({dimension, tag, name(other)});
            }
        mesh.groups = groups;
        const auto names_of = [](const LinearMesh<3>& m, int dimension, Reference reference) {
            std::set<std::string> names;
            for (const Group& group : m.groups)
                if (group.dimension == dimension && group.reference == reference) names.insert(group.name);
            return names;
        };
        const auto read = [](const LinearMesh<3>& m, MshEncoding encoding) {
            const auto bytes = generated::joined(*encode_msh(as_mesh(m), {}, {MshVersion::v4, encoding}, {}));
            auto back = decode_msh(bytes, "file", {});
            if (!back) RC_FAIL(describe(back.error()));
            return testing::mesh_in<LinearMesh<3>>(back->mesh);
        };
        for (const MshEncoding encoding : {MshEncoding::binary, MshEncoding::ascii}) {
            const LinearMesh<3> back = read(mesh, encoding);
            const auto same = [&](int dimension, const auto& a, const auto& b) {
                RC_ASSERT(a.vertices == b.vertices);
                for (std::size_t i = 0; i < a.size(); ++i)
                    RC_ASSERT(names_of(mesh, dimension, a.references[i]) == names_of(back, dimension, b.references[i]));
            };
            same(3, mesh.elements, back.elements);
            same(2, mesh.facets, back.facets);
            same(1, mesh.edges, back.edges);
            RC_ASSERT(read(back, encoding) == back);
        }
    });
}

TEST_CASE("MSH 2.2, CGNS and STL report the groups that they leave out") {
    LinearMesh<3> mesh;
    mesh.points = Buffer<Vec<3>>{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}};
    mesh.point_references = Buffer<Reference>(3, 0);
    mesh.facets.vertices = Buffer<SimplexVertices<2>>{{VertexId(0), VertexId(1), VertexId(2)}};
    mesh.facets.references = Buffer<Reference>{3};
    mesh.groups = Buffer<Group>{{2, 3, "wall"}, {2, 4, "heated"}, {2, 3, "heated"}};
    const std::string what = " has one group for a simplex: 1 triangles of \"wall\" are left out of \"heated\"";
    const auto reports = [&](const std::vector<Notice>& losses, const std::string& format) {
        return std::ranges::find(losses, format + what, &Notice::what) != losses.end();
    };
    CHECK(not_in_msh(as_mesh(mesh), MshVersion::v4).empty());
    CHECK(reports(not_in_msh(as_mesh(mesh), MshVersion::v2), "MSH 2.2"));
    CHECK(reports(not_in_cgns(as_mesh(mesh)), "CGNS"));
    CHECK(reports(not_in_stl(as_mesh(mesh), StlEncoding::ascii), "STL"));
}

TEST_CASE("MSH 4.1 gives entities in several groups a reference of their own") {
    const auto with = [](const std::string& first, const std::string& second) {
        return of_version("4.1") + "$PhysicalNames\n2\n1 6 \"in\"\n1 7 \"hot\"\n$EndPhysicalNames\n" +
               "$Entities\n0 2 0 0\n1 0 0 0 1 0 0 " + first + " 0\n2 0 0 0 1 0 0 " + second + " 0\n$EndEntities\n" +
               "$Nodes\n1 3 1 3\n1 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n2 0 0\n$EndNodes\n" +
               "$Elements\n2 2 1 2\n1 1 1 1\n1 1 2\n1 2 1 1\n2 2 3\n$EndElements\n";
    };
    const auto single = decoded(with("2 6 7", "0"));
    const auto& one = testing::mesh_in<LinearMesh<3>>(single.mesh);
    CHECK(single.notices.empty());
    CHECK(one.edges.references == Column<Reference>(Buffer<Reference>{6, 0}));
    CHECK(one.groups == Column<Group>(Buffer<Group>{{1, 6, "in"}, {1, 7, "hot"}, {1, 6, "hot"}}));
    const auto beside = decoded(with("2 6 7", "1 6"));
    const auto& two = testing::mesh_in<LinearMesh<3>>(beside.mesh);
    CHECK(two.edges.references == Column<Reference>(Buffer<Reference>{8, 6}));
    CHECK(two.groups == Column<Group>(Buffer<Group>{{1, 6, "in"}, {1, 7, "hot"}, {1, 8, "in"}, {1, 8, "hot"}}));
    CHECK(has_notice(beside, "1 edges in the physical groups 6 and 7 have the reference 8"));
    const auto text =
        generated::text_of(generated::joined(*encode_msh(as_mesh(two), {}, {MshVersion::v4, MshEncoding::ascii}, {})));
    CHECK(text.find("\n1 0 0 0 2 0 0 2 6 7 0\n2 1 0 0 2 0 0 1 6 0\n") < text.size());
}

TEST_CASE("MSH restores fields, with 2D vectors and tensors extended to 3D") {
    for (const MshOptions kind : kinds) {
        const auto mesh = generated::quadratic<2>(3, 5);
        const std::size_t nodes = mesh.linear.points.size() + mesh.edges.size();
        const std::size_t cells = mesh.linear.elements.size() + mesh.linear.facets.size();
        REQUIRE(mesh.linear.elements.size() > 0);
        REQUIRE(mesh.linear.facets.size() > 0);
        Buffer<double> tensor, cell;
        for (std::size_t i = 0; i < nodes * 3; ++i) tensor.push_back(static_cast<double>(i));
        Buffer<std::int32_t> whole;
        for (std::size_t i = 0; i < cells; ++i) whole.push_back(static_cast<std::int32_t>(i));
        for (std::size_t i = 0; i < 2 * cells; ++i) cell.push_back(0.5 * static_cast<double>(i));
        const auto fields = MeshFields{}
                                .with({"a metric", Centring::node, FieldKind::symmetric_tensor, Column<double>(tensor)})
                                .with({"number", Centring::cell, FieldKind::scalar, Column<std::int32_t>(whole)})
                                .with({"way", Centring::cell, FieldKind::vector, Column<double>(cell)});
        auto bytes = generated::joined(*encode_msh(as_mesh(mesh), fields, kind, {}));
        if (kind.encoding == MshEncoding::binary) bytes = msh_swapped::swapped(bytes);
        const auto back = decode_msh(bytes, "file", {});
        REQUIRE(back.has_value());
        REQUIRE(back->fields.size() == 3);
        const MeshField* const metric = back->fields.find("a metric", Centring::node);
        REQUIRE(metric != nullptr);
        REQUIRE(metric->kind == FieldKind::full_tensor);
        const auto& rows = std::get<Column<double>>(metric->values);
        REQUIRE(rows.size() == 9 * nodes);
        for (std::size_t n = 0; n < nodes; ++n) {
            const std::array expected{
                tensor[3 * n], tensor[3 * n + 1], 0.0, tensor[3 * n + 1], tensor[3 * n + 2], 0.0, 0.0, 0.0, 0.0};
            REQUIRE(std::equal(expected.begin(), expected.end(), rows.begin() + 9 * n));
        }
        const MeshField* const number = back->fields.find("number", Centring::cell);
        REQUIRE(number != nullptr);
        const auto& numbers = std::get<Column<double>>(number->values);
        REQUIRE(std::equal(numbers.begin(), numbers.end(), whole.begin(), whole.end()));
        REQUIRE(back->fields.find("way", Centring::cell)->size() == 3 * cells);
    }
}

TEST_CASE("MSH reports unsupported fields and takes the last time step") {
    const std::string head = of_version("4.1") + entities_4 + nodes_4 + elements_4;
    const auto data = [](const std::string& section, const std::string& name, int components, const std::string& rows) {
        return "$" + section + "\n1\n\"" + name + "\"\n1\n0.5\n3\n0\n" + std::to_string(components) + "\n" +
               std::to_string(std::count(rows.begin(), rows.end(), '\n')) + "\n" + rows + "$End" + section + "\n";
    };
    const auto mesh =
        decoded(head + data("NodeData", "u", 1, "7 1\n40 2\n3 3\n") + data("NodeData", "u", 1, "7 4\n40 5\n3 6\n") +
                data("NodeData", "some", 1, "7 1\n") + data("NodeData", "two", 2, "7 1 1\n40 2 2\n3 3 3\n") +
                data("ElementData", "c", 1, "1 10\n5 20\n4 30\n9 7\n") + "$ElementNodeData\n1\n$EndElementNodeData\n");
    REQUIRE(mesh.fields.size() == 2);
    CHECK(std::get<Column<double>>(mesh.fields.find("u", Centring::node)->values) ==
          Column<double>(Buffer<double>{6, 4, 5}));
    CHECK(std::get<Column<double>>(mesh.fields.find("c", Centring::cell)->values) ==
          Column<double>(Buffer<double>{10, 30, 20}));
    CHECK(has_notice(mesh, "the field \"some\" does not have a value for each node: left out"));
    CHECK(has_notice(mesh, "the field \"two\" has 2 components: left out"));
    CHECK(has_notice(mesh, "fields have several time steps: the last one of each was used, 1 were left out"));
    CHECK(has_notice(mesh, "the section $ElementNodeData was skipped"));
}

TEST_CASE("MSH 4.1 reads node tags, physical tags, entities, parameters and points") {
    const auto mesh = decoded("$Comments\nanything $MeshFormat\n$EndComments\n" + of_version("4.1") +
                              "$PhysicalNames\n2\n1 3 \"a name\"\n2 2 \"face\"\n$EndPhysicalNames\n" + entities_4 +
                              nodes_4 + elements_4 + "$Periodic\n0\n$EndPeriodic\n");
    const auto& m = testing::mesh_in<LinearMesh<3>>(mesh.mesh);
    REQUIRE(m.points.size() == 3);
    CHECK(m.points[VertexId(0)] == Vec<3>{{0, 1, 0}});
    CHECK(m.points[VertexId(2)] == Vec<3>{{1, 0, 0}});
    CHECK(m.facets.references == Column<Reference>(Buffer<Reference>{2}));
    CHECK(m.facets.entities == Column<Reference>(Buffer<Reference>{8}));
    CHECK(m.edges.references == Column<Reference>(Buffer<Reference>{3, 0}));
    CHECK(m.edges.entities == Column<Reference>(Buffer<Reference>{6, 7}));
    CHECK(m.point_references == Column<Reference>(Buffer<Reference>{0, 8, 0}));
    const VertexId zero(0), one(1), two(2);
    CHECK(m.geometry.on_points == Column<Association<0>>(Buffer<Association<0>>{{one, 5}}));
    CHECK(m.geometry.on_curves == Column<Association<1>>(Buffer<Association<1>>{{two, 6, {{0.25}}}}));
    CHECK(m.geometry.on_surfaces == Column<Association<2>>(Buffer<Association<2>>{{zero, 8, {{0.5, 0.75}}}}));
    CHECK(m.groups ==
          Column<Group>(Buffer<Group>{{1, 3, "a name"}, {2, 2, "face"}, {1, 4, "group_4"}, {1, 3, "group_4"}}));
    CHECK(mesh.tags.vertices == Column<std::uint64_t>(Buffer<std::uint64_t>{3, 7, 40}));
    CHECK(mesh.tags.simplices[1] == Column<std::uint64_t>(Buffer<std::uint64_t>{4, 5}));
    CHECK(mesh.tags.simplices[2].empty());  // the tag of the triangle is its number
    CHECK(has_notice(mesh,
                     "the physical group 4 shares edges with others and has no name. It gets the name "
                     "\"group_4\""));
    CHECK(has_notice(mesh, "the section $Periodic was skipped"));
    CHECK(mesh.notices.size() == 2);
}

TEST_CASE("MSH 2.2 reads tags up to 2^63 and simplices listed once per group") {
    const auto mesh =
        decoded(triangle_2("$Elements\n4\n"
                           "9 2 2 5 1 7 100000 9000000000000000000\n"
                           "3 2 2 -4 1 7 100000 9000000000000000000\n"
                           "2 1 2 0 2 7 100000\n"
                           "1 15 3 6 3 1 7\n$EndElements\n"));
    const auto& m = testing::mesh_in<LinearMesh<3>>(mesh.mesh);
    CHECK(m.points[VertexId(2)] == Vec<3>{{0, 1, 0}});
    CHECK(m.facets.vertices[0] == SimplexVertices<2>{VertexId(0), VertexId(1), VertexId(2)});
    CHECK(m.facets.references == Column<Reference>(Buffer<Reference>{4}));
    CHECK(m.edges.references == Column<Reference>(Buffer<Reference>{0}));
    CHECK(m.edges.entities == Column<Reference>(Buffer<Reference>{2}));
    CHECK(m.point_references == Column<Reference>(Buffer<Reference>{6, 0, 0}));
    CHECK(m.geometry.on_points == Column<Association<0>>(Buffer<Association<0>>{{VertexId(0), 3}}));
    CHECK(m.groups == Column<Group>(Buffer<Group>{{2, 4, "group_4"}, {2, 5, "group_5"}, {2, 4, "group_5"}}));
    CHECK(has_notice(
        mesh, "the physical group 5 shares triangles with others and has no name. It gets the name \"group_5\""));
    CHECK(has_notice(mesh, "the mesh is partitioned: the partitions were joined"));
}

TEST_CASE("MSH versions are read with any number of digits") {
    const std::string text = triangle_2("$Elements\n1\n3 2 2 5 1 7 100000 9000000000000000000\n$EndElements\n");
    const auto mesh = decoded(text).mesh;
    for (const std::string_view version : {"2.200000", "2.20", "2.1000", "2.000000"})
        CHECK(decoded(of_version(version) + text.substr(of_version("2.2").size())).mesh == mesh);
}

TEST_CASE("MSH 2.2 reads parametric nodes as associations") {
    const auto mesh =
        decoded(of_version("2.2") +
                "$ParametricNodes\n4\n1 0 0 0 0 11\n2 1 0 0 1 12 0.5\n3 0 1 0 2 13 0.25 0.75\n4 0 0 1 3 14\n"
                "$EndParametricNodes\n$Elements\n1\n1 4 2 1 1 1 2 3 4\n$EndElements\n");
    const auto& geometry = testing::mesh_in<LinearMesh<3>>(mesh.mesh).geometry;
    CHECK(geometry.on_points == Column<Association<0>>(Buffer<Association<0>>{{VertexId(0), 11}}));
    CHECK(geometry.on_curves == Column<Association<1>>(Buffer<Association<1>>{{VertexId(1), 12, {{0.5}}}}));
    CHECK(geometry.on_surfaces == Column<Association<2>>(Buffer<Association<2>>{{VertexId(2), 13, {{0.25, 0.75}}}}));
}

TEST_CASE("MSH references are entity tags if there is no physical group") {
    const auto mesh = decoded(triangle_2("$Elements\n1\n3 2 2 0 17 7 100000 9000000000000000000\n$EndElements\n"));
    CHECK(testing::mesh_in<LinearMesh<3>>(mesh.mesh).facets.references == Column<Reference>(Buffer<Reference>{17}));
    CHECK(has_notice(mesh, "no simplex is in a physical group: references are the tags of entities"));
}

TEST_CASE("MSH swaps the last two nodes of degree-2 tetrahedra") {
    std::string nodes = "$Nodes\n10\n";
    for (int i = 1; i <= 10; ++i) nodes += std::to_string(i) + " " + std::to_string(i) + " 0 0\n";
    const auto mesh =
        decoded(of_version("2.2") + nodes + "$EndNodes\n$Elements\n1\n1 11 2 1 1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n");
    const auto& m = testing::mesh_in<QuadraticMesh<3>>(mesh.mesh);
    const auto x = [&](int edge) {
        return m.mid_nodes[m.edges.of_elements[0][static_cast<std::size_t>(edge)]].point[0];
    };
    CHECK(x(3) == 8);   // e03
    CHECK(x(4) == 10);  // e13
    CHECK(x(5) == 9);   // e23
}

TEST_CASE("MSH maps partitioned entities to their parents and leaves out interfaces") {
    const auto mesh =
        decoded(of_version("4.1") +
                "$Entities\n0 0 1 0\n8 0 0 0 1 1 0 1 2 0\n$EndEntities\n"
                "$PartitionedEntities\n2\n0\n0 1 2 0\n"
                "9 2 8 2 1 2 0 0 0 1 1 0 1 2 0\n"
                "9 2 8 1 1 0 0 0 1 1 0 1 2 0\n10 2 8 1 2 0 0 0 1 1 0 0 0\n$EndPartitionedEntities\n"
                "$Nodes\n3 4 1 4\n2 9 1 1\n1\n0 0 0 0.5 0.5\n2 10 0 1\n2\n1 0 0\n1 9 1 2\n3\n4\n0 1 0 0.1\n1 1 0 "
                "0.2\n$EndNodes\n"
                "$Elements\n3 3 1 3\n2 9 2 1\n1 1 2 3\n2 10 2 1\n2 2 4 3\n1 9 1 1\n3 2 3\n$EndElements\n");
    const auto& m = testing::mesh_in<LinearMesh<3>>(mesh.mesh);
    CHECK(m.facets.references == Column<Reference>(Buffer<Reference>{2, 2}));
    CHECK(m.facets.entities == Column<Reference>(Buffer<Reference>{8, 8}));
    CHECK(m.edges.size() == 0);
    REQUIRE(m.geometry.on_surfaces.size() == 4);
    CHECK(m.geometry.on_surfaces[0] == Association<2>{VertexId(0), 8, {{0.5, 0.5}}});
    CHECK(m.geometry.on_surfaces[3] == Association<2>{VertexId(3), 8});
    CHECK(m.geometry.on_curves.empty());
    CHECK(
        has_notice(mesh, "the mesh is partitioned: the partitions were joined, and 1 elements between them left out"));
}

TEST_CASE("MSH rejects unsupported elements with counts and versions with a remedy") {
    CHECK(
        message(triangle_2(
            "$Elements\n3\n1 2 2 1 1 7 100000 9000000000000000000\n2 3 2 1 1 7 7 7 7\n3 21 2 1 1 7 7 7 7 7 7 7 7 7 7\n"
            "$EndElements\n")) ==
        "file: holds 1 quadrangles, 1 triangles of degree 3, which Camber does not support (give a mesh of edges, "
        "triangles and tetrahedra of degree 1 or 2; \"camber info FILE\" counts its cells and names a program that "
        "splits them)");
    CHECK(message(of_version("4.1") + entities_4 + nodes_4 +
                  "$Elements\n1 2 1 2\n2 8 3 2\n1 3 3 3 3\n2 7 7 7 7\n$EndElements\n") ==
          "file: holds 2 quadrangles, which Camber does not support (give a mesh of edges, triangles and tetrahedra "
          "of degree 1 or 2; \"camber info FILE\" counts its cells and names a program that splits them)");
    CHECK(message(triangle_2("$Elements\n1\n1 999 2 1 1 7\n$EndElements\n"))
              .find("holds elements of type 999, which is unknown") < 40);
    for (const std::string_view version : {"3", "4.2", "5"})
        CHECK(message(of_version(version)) == "file: line 1: MSH version " + std::string(version) +
                                                  " is not 1, 2 or 4 (gmsh FILE -save -format msh41 -o NEW.msh)");
    CHECK(message("$NOD\n0\n$ENDNOD\n") == "file: line 4: the file has no $Elements (it seems to be cut off)");
}

TEST_CASE("MSH errors give the position in the file") {
    CHECK(message(triangle_2("$Elements\n1\n1 2 2 1 1 7 8 100000\n$EndElements\n")) ==
          "file: triangle 1: a node is not one of those that the file lists (the file is damaged, or was joined from "
          "two files)");
    CHECK(message(triangle_2("$Elements\n1\n5 15 2 1 1 8\n$EndElements\n")) ==
          "file: point 5: a node is not one of those that the file lists (the file is damaged, or was joined from two "
          "files)");
    CHECK(message(triangle_2("$Elements\n1\n1 2 2 1 1 7 7 100000\n$EndElements\n")) ==
          "file: triangle 1: a node occurs twice (remove it: it has no volume)");
    CHECK(message(triangle_2("$Elements\n2\n1 2 2 1 1 7 100000 9000000000000000000\n$EndElements\n")) ==
          "file: line 13: $Elements: a valid number is missing here (the file is cut off or damaged)");
    CHECK(message(of_version("2.2") + "$Nodes\n2\n1 0 0 0\n1 1 1 1\n$EndNodes\n") ==
          "file: line 7: node 1: is listed twice (the file is damaged, or was joined from two files)");
    for (const std::string_view tag : {"0", "-7"}) {
        CHECK(message(of_version("2.2") + "$Nodes\n2\n1 0 0 0\n" + std::string(tag) + " 1 1 1\n$EndNodes\n") ==
              "file: line 7: $Nodes: " + std::string(tag) +
                  " is the tag of a node, but must be positive (number the nodes from 1)");
        CHECK(message(of_version("4.1") + "$Nodes\n1 2 1 2\n0 5 0 2\n1\n" + std::string(tag) +
                      "\n0 0 0\n1 1 1\n$EndNodes\n") ==
              "file: line 8: $Nodes: " + std::string(tag) +
                  " is the tag of a node, but must be positive (number the nodes from 1)");
        CHECK(message(of_version("2.2") + "$ParametricNodes\n1\n" + std::string(tag) +
                      " 0 0 0 0 1\n$EndParametricNodes\n")
                  .find("$ParametricNodes: a valid number is missing here") < 40);
    }
    CHECK(message(of_version("2.2") + "$Nodes\n1\n1 0 nan 0\n$EndNodes\n$Elements\n0\n$EndElements\n") ==
          "file: vertex 1: a coordinate is infinite or not a number (the program that wrote the file failed there. "
          "Write it again)");
    CHECK(message(triangle_2("")) == "file: line 10: the file has no $Elements (it seems to be cut off)");
}

TEST_CASE("a non-positive node tag in a binary MSH file is reported with its byte") {
    auto mesh = storable(generated::mesh<3>(3, 4), 3, MshVersion::v2);
    auto bytes = generated::joined(*encode_msh(as_mesh(mesh), {}, {MshVersion::v2, MshEncoding::binary}, {}));
    const std::string head = "$Nodes\n" + std::to_string(mesh.points.size()) + "\n";
    const std::size_t row = generated::text_of(bytes).find(head) + head.size() + 2 * (4 + 3 * 8);  // the third
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(row), 4, std::byte{0xff});
    const auto decoded = decode_msh(bytes, "file", {});
    REQUIRE(!decoded.has_value());
    CHECK(describe(decoded.error()) == "file: byte " + std::to_string(row) +
                                           ": $Nodes: -1 is the tag of a node, but must be positive (number the nodes "
                                           "from 1)");
}

TEST_CASE("MSH replaces references and entities that it cannot store with a notice") {
    LinearMesh<2> mesh;
    mesh.points = Buffer<Vec<2>>{{{0, 0}}, {{1, 0}}, {{0, 1}}, {{1, 1}}};
    mesh.point_references = Buffer<Reference>{0, 0, 5, 0};
    const auto triangle = [](std::size_t a, std::size_t b, std::size_t c) {
        return SimplexVertices<2>{VertexId(a), VertexId(b), VertexId(c)};
    };
    mesh.elements.vertices = Buffer<SimplexVertices<2>>{triangle(0, 1, 2), triangle(1, 3, 2)};
    mesh.elements.references = Buffer<Reference>{0, 1};
    mesh.elements.entities = Buffer<Reference>{4, 4};
    mesh.groups = Buffer<Group>{{2, 0, "zero"}};
    const auto losses = not_in_msh(as_mesh(mesh), MshVersion::v4);
    REQUIRE(losses.size() == 3);
    CHECK(losses[0].what == "physical tags must be positive: of 1 triangles the reference 0 becomes 2");
    CHECK(losses[1].what ==
          "1 triangles get another entity: in the file, each entity has one reference and a "
          "positive number");
    CHECK(losses[2].what ==
          "MSH has no place for 1 references of vertices: only positive references of vertices on CAD points are "
          "written");
    for (const MshOptions kind : kinds) {
        const auto back = decode_msh(generated::joined(*encode_msh(as_mesh(mesh), {}, kind, {})), "file", {});
        REQUIRE(back.has_value());
        const auto& m = testing::mesh_in<LinearMesh<3>>(back->mesh);
        CHECK(m.facets.references == Column<Reference>(Buffer<Reference>{2, 1}));
        CHECK(m.facets.entities == Column<Reference>(Buffer<Reference>{1, 4}));
        CHECK(m.groups == Column<Group>(Buffer<Group>{{2, 2, "zero"}}));
    }
}

TEST_CASE("MSH keeps curves without reference beside tetrahedra out of groups") {
    LinearMesh<3> mesh;
    mesh.points = Buffer<Vec<3>>{{{0, 0, 0}}, {{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
    mesh.point_references = Buffer<Reference>{0, 0, 0, 0};
    mesh.elements.vertices = Buffer<SimplexVertices<3>>{{VertexId(0), VertexId(1), VertexId(2), VertexId(3)}};
    mesh.elements.references = Buffer<Reference>{7};
    mesh.edges.vertices = Buffer<SimplexVertices<1>>{{VertexId(0), VertexId(1)}, {VertexId(1), VertexId(2)}};
    mesh.edges.references = Buffer<Reference>{0, 3};
    CHECK(not_in_msh(as_mesh(mesh), MshVersion::v4).empty());
    LinearMesh<3> named = mesh;
    named.groups = Buffer<Group>{{1, 0, "seam"}};
    CHECK(not_in_msh(as_mesh(named), MshVersion::v4).size() == 1);
    for (const MshOptions kind : kinds) {
        const auto edges_of = [&](const LinearMesh<3>& m) {
            const auto back = decode_msh(generated::joined(*encode_msh(as_mesh(m), {}, kind, {})), "file", {});
            REQUIRE(back.has_value());
            return testing::mesh_in<LinearMesh<3>>(back->mesh).edges.references;
        };
        CHECK(edges_of(mesh) == Column<Reference>(Buffer<Reference>{0, 3}));
        CHECK(edges_of(named) == Column<Reference>(Buffer<Reference>{1, 3}));  // a name requires a group
    }
}

TEST_CASE("MSH files and meshes do not depend on the number of threads") {
    for (const MshOptions kind : kinds) {
        const bool is_of_fewer = (kind.version == MshVersion::v4) == (kind.encoding == MshEncoding::binary);
        if (testing::is_sanitized && !is_of_fewer) continue;  // each version and each encoding once
        const auto mesh = generated::quadratic<3>(11, 4000);
        const auto one = generated::joined(*encode_msh(as_mesh(mesh), {}, kind, {.threads = 1}));
        CHECK(one == generated::joined(*encode_msh(as_mesh(mesh), {}, kind, {.threads = 3})));
        const auto first = decode_msh(one, "file", {.threads = 1});
        const auto second = decode_msh(one, "file", {.threads = 3});
        REQUIRE(first.has_value());
        REQUIRE(second.has_value());
        CHECK(first->mesh == second->mesh);
    }
}

TEST_CASE("MSH rejects columns of the wrong length") {
    auto mesh = generated::mesh<3>(5, 4);
    mesh.elements.entities = Buffer<Reference>{1};
    const auto broken = encode_msh(as_mesh(mesh), {}, {}, {});
    REQUIRE(!broken);
    CHECK(broken.error().kind == ErrorKind::internal);
}

TEST_CASE("MSH rejects fields of another mesh") {
    const auto other = MeshFields{}.with({"x", Centring::node, FieldKind::scalar, Column<double>(Buffer<double>{1})});
    const auto refused = encode_msh(as_mesh(generated::mesh<3>(5, 4)), other, {}, {});
    REQUIRE(!refused);
    CHECK(describe(refused.error()).find("the field \"x\" does not have one row for each of the") == 0);
}
