// Conversion of plane meshes to 2D and back to 3D with all their data.
#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "generated.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.io;

using namespace camber;

namespace {

/// A generated surface in the plane of this z; unused vertices stay off the plane.
LinearMesh<3> flat_surface(std::uint64_t seed, std::size_t cells, double z) {
    LinearMesh<3> mesh = generated::mesh<3>(seed, cells);
    mesh.elements = {};
    std::vector<bool> used(mesh.points.size());
    const auto mark = [&](const auto& simplices) {
        for (const auto& simplex : simplices.vertices)
            for (const VertexId v : simplex) used[v.index()] = true;
    };
    mark(mesh.facets);
    mark(mesh.edges);
    auto points = take(std::move(mesh.points));
    for (std::size_t v = 0; v < points.size(); ++v)
        if (used[v]) points[v][2] = z;
    mesh.points = std::move(points);
    return mesh;
}

/// Projects its tables of normals, tangents, both or none onto the plane.
LinearMesh<3> with_directions_in_plane(LinearMesh<3> mesh, bool normals, bool tangents) {
    const auto flatten = [](Column<Vec<3>>& directions) {
        auto flat = take(std::move(directions));
        for (Vec<3>& d : flat) d[2] = 0;
        directions = std::move(flat);
    };
    if (normals) flatten(mesh.geometry.normals.table);
    if (tangents) flatten(mesh.geometry.tangents.table);
    return mesh;
}

QuadraticMesh<3> curved(LinearMesh<3> linear, std::uint64_t seed, double z) {
    auto mesh = *elevate(std::move(linear), {});
    generated::Random random(seed);
    Buffer<LagrangeNode<3>> nodes;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) nodes.push_back({{{random.real(), random.real(), z}}});
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

Flattened flattened_or_fail(const Mesh<3>& mesh) {
    auto flat = flattened(mesh, {});
    RC_ASSERT(flat.has_value());
    RC_ASSERT(flat->has_value());
    return std::move(**flat);
}

template <class Simplices>
bool is_flat(const Simplices& mesh) {
    return flattened(as_mesh(mesh), {})->has_value();
}

Vec<3> moved_off(Vec<3> p) {
    p[2] = p[2] == 0 ? 5e-324 : 2 * p[2];
    return p;
}

}  // namespace

TEST_CASE("raising a flattened mesh restores it") {
    testing::property("raising a flattened surface restores it, straight and curved", [](std::uint64_t seed) {
        const bool normals = *rc::gen::arbitrary<bool>(), tangents = *rc::gen::arbitrary<bool>();
        const double z = generated::Random(seed).real();
        const LinearMesh<3> mesh = with_directions_in_plane(flat_surface(seed, 1 + seed % 9, z), normals, tangents);
        RC_PRE(mesh.facets.size() > 0);
        const auto flat = flattened_or_fail(as_mesh(mesh));
        RC_ASSERT(flat.lift.z == z);
        RC_ASSERT(*raised(flat.mesh, flat.lift, {}) == as_mesh(mesh));
        const QuadraticMesh<3> quadratic = curved(mesh, seed, z);
        const auto flat_too = flattened_or_fail(as_mesh(quadratic));
        RC_ASSERT(as_mesh(straight_simplices(flat_too.mesh)) == flat.mesh);
        RC_ASSERT(flat_too.lift == flat.lift);
        RC_ASSERT(*raised(flat_too.mesh, flat_too.lift, {}) == as_mesh(quadratic));
    });
    testing::property("flattening a raised mesh restores it", [](std::uint64_t seed) {
        const bool high = *rc::gen::arbitrary<bool>();
        const auto mesh = generated::quadratic<2>(seed, 1 + seed % 9);
        RC_PRE(mesh.linear.elements.size() > 0);
        const Lift lift{.z = high ? 7.5 : 0.0};
        const auto back = flattened_or_fail(*raised(as_mesh(mesh), lift, {}));
        RC_ASSERT(back.mesh == as_mesh(mesh));
        RC_ASSERT(back.lift == lift);
    });
}

TEST_CASE("flattening makes triangles elements, edges facets and all unique edges curved") {
    testing::property("each kind of entity becomes its 2D kind", [](std::uint64_t seed) {
        const QuadraticMesh<3> mesh = curved(flat_surface(seed, 1 + seed % 9, 0), seed, 0);
        RC_PRE(mesh.linear.facets.size() > 0);
        const QuadraticMesh<2> flat = *as_quadratic(flattened_or_fail(as_mesh(mesh)).mesh);
        RC_ASSERT(flat.linear.elements == mesh.linear.facets);
        RC_ASSERT(flat.linear.facets == mesh.linear.edges);
        RC_ASSERT(flat.linear.ridges == mesh.linear.ridges);
        RC_ASSERT(flat.linear.edges.size() == 0);
        RC_ASSERT(flat.linear.geometry.on_surfaces == mesh.linear.geometry.on_surfaces);
        RC_ASSERT(flat.edges == *unique_edges(flat.linear, {}));
    });
}

TEST_CASE("meshes with vertices off the plane, tetrahedra or no triangles are not flat") {
    testing::property("a mesh with a used vertex or node off the plane is not flat", [](std::uint64_t seed) {
        const QuadraticMesh<3> mesh = curved(flat_surface(seed, 1 + seed % 9, 3), seed, 3);
        RC_PRE(mesh.linear.facets.size() > 0);
        generated::Random random(seed);
        LinearMesh<3> linear = mesh.linear;
        auto points = take(linear.points);
        const VertexId v = linear.facets.vertices[random.below(linear.facets.size())][random.below(3)];
        points[v.index()] = moved_off(points[v.index()]);
        linear.points = std::move(points);
        RC_ASSERT(!is_flat(linear));
        QuadraticMesh<3> quadratic = mesh;
        auto nodes = take(quadratic.mid_nodes);
        LagrangeNode<3>& node = nodes[random.below(nodes.size())];
        node.point = moved_off(node.point);
        quadratic.mid_nodes = std::move(nodes);
        RC_ASSERT(!is_flat(quadratic));
    });
    testing::property("a mesh with tetrahedra or without triangles is not flat", [](std::uint64_t seed) {
        LinearMesh<3> mesh = flat_surface(seed, 1 + seed % 9, 0);
        RC_PRE(mesh.facets.size() > 0);
        RC_ASSERT(is_flat(mesh));
        LinearMesh<3> with_volume = mesh;
        with_volume.elements = generated::mesh<3>(seed, 1).elements;
        RC_ASSERT(with_volume.elements.size() == 0 || !is_flat(with_volume));
        mesh.facets = {};
        RC_ASSERT(!is_flat(mesh));
    });
    CHECK_FALSE(is_flat(LinearMesh<3>{}));
}

TEST_CASE("a flat mesh is converted to 2D with its lift, another mesh is unchanged") {
    testing::property("conversion preserves node numbers and notices in degrees 1 and 2", [](std::uint64_t seed) {
        const bool flat = *rc::gen::arbitrary<bool>();
        QuadraticMesh<3> mesh = curved(flat_surface(seed, 1 + seed % 9, 0), seed, 0);
        if (!flat) mesh = generated::quadratic<3>(seed, 1 + seed % 9);
        RC_PRE(mesh.linear.facets.size() > 0);
        const auto check = [](const auto& input) {
            const DecodedMesh read{as_mesh(input), {{"a notice"}}, Buffer<std::uint32_t>{3, 1, 2}};
            const auto converted = with_flat_in_2d(read, {});
            RC_ASSERT(converted.has_value());
            RC_ASSERT(converted->notices.at(0) == read.notices.at(0));
            RC_ASSERT(!is_flat(input) || converted->notices.size() == 1);
            RC_ASSERT(converted->node_numbers == read.node_numbers);
            RC_ASSERT(converted->lift.has_value() == is_flat(input));
            RC_ASSERT((converted->lift ? *raised(converted->mesh, *converted->lift, {}) : converted->mesh) ==
                      read.mesh);
        };
        check(mesh);
        check(mesh.linear);
    });
    const AnyMesh in_2d = as_mesh(generated::mesh<2>(1, 4));
    CHECK_FALSE(with_flat_in_2d({in_2d, {}}, {})->lift.has_value());
    CHECK(*raised(AnyMesh(as_mesh(generated::mesh<3>(1, 4))), {}, {}) == AnyMesh(as_mesh(generated::mesh<3>(1, 4))));
}

TEST_CASE("a mesh whose z coordinates differ by rounding stays in 3D with a notice") {
    const auto notices = [](double z) {
        LinearMesh<3> mesh = flat_surface(3, 5, 0);
        REQUIRE(mesh.facets.size() > 0);
        auto points = take(std::move(mesh.points));
        for (std::size_t v = 0; v < points.size(); ++v) points[v] = {{static_cast<double>(v), 0, 0}};
        points[mesh.facets.vertices[0][1].index()][2] = z;
        mesh.points = std::move(points);
        const auto converted = with_flat_in_2d({as_mesh(mesh), {}}, {});
        REQUIRE(converted.has_value());
        CHECK(converted->lift.has_value() == (z == 0));
        return converted->notices.size();
    };
    CHECK(notices(0) == 0);
    CHECK(notices(1e-17) == 1);
    CHECK(notices(-1e-17) == 1);
    CHECK(notices(1e-3) == 0);
    CHECK(with_flat_in_2d({Mesh<3>{}, {}}, {})->notices.empty());
}

TEST_CASE("raising rejects the lift of another mesh") {
    const Mesh<2> mesh = as_mesh(generated::mesh<2>(1, 4));
    const Lift other{.heights = Buffer<double>{0, 1}};
    CHECK(raised(mesh, other, {}).error().kind == ErrorKind::internal);
}

TEST_CASE("raising and flattening stop on request") {
    const Mesh<2> mesh = as_mesh(generated::mesh<2>(1, 4));
    std::stop_source stop;
    stop.request_stop();
    const Execution stopped{.stop = stop.get_token()};
    CHECK(raised(mesh, {}, stopped).error().kind == ErrorKind::stopped);
    CHECK(flattened(*raised(mesh, {}, {}), stopped).error().kind == ErrorKind::stopped);
}

TEST_CASE("VTU files of raised fields equal those of the 2D mesh") {
    testing::property("VTU files of raised fields have the bytes of the 2D mesh", [](std::uint64_t seed) {
        const auto mesh = generated::quadratic<2>(seed, 1 + seed % 9);
        generated::Random random(seed);
        const std::size_t nodes = mesh.linear.points.size() + mesh.edges.size();
        const std::size_t cells = mesh.linear.elements.size() + mesh.linear.facets.size();
        MeshFields fields = MeshFields{}.with(
            {"number", Centring::cell, FieldKind::scalar, Column<std::int32_t>(Buffer<std::int32_t>(cells, 3))});
        for (const FieldKind kind :
             {FieldKind::scalar, FieldKind::vector, FieldKind::symmetric_tensor, FieldKind::full_tensor}) {
            Buffer<double> values(nodes * static_cast<std::size_t>(values_per_vertex(kind, 2)));
            for (double& value : values) value = random.real();
            fields = std::move(fields).with({"kind " + std::to_string(static_cast<int>(kind)), Centring::node, kind,
                                             Column<double>(std::move(values))});
        }
        const auto of_plane = encode_vtu(as_mesh(mesh), fields, {}, {});
        const auto of_space = encode_vtu(*raised(as_mesh(mesh), {}, {}), *raised(fields, {}), {}, {});
        RC_ASSERT(generated::joined(*of_plane) == generated::joined(*of_space));
    });
}

TEST_CASE("flattened solutions keep their in-plane components") {
    testing::property("a flattened tensor has the entries of x and y", [](std::uint64_t seed) {
        generated::Random random(seed);
        Sym<3> space;
        for (double& value : space.c) value = random.real();
        const Buffer<double> values(space.c.begin(), space.c.end());
        const Solution plane = *flattened(Solution{3, {FieldKind::symmetric_tensor}, 1, values}, {});
        RC_ASSERT(plane.values.size() == std::size_t{sym_size<2>});
        for (int i = 0; i < 2; ++i)
            for (int j = 0; j <= i; ++j)
                RC_ASSERT(plane.values[static_cast<std::size_t>(Sym<2>::index(i, j))] == space(i, j));
    });
    const std::vector<FieldKind> kinds{FieldKind::vector, FieldKind::full_tensor, FieldKind::scalar};
    const Solution space{3, kinds, 2, Buffer<double>{1, 2, 3, 11, 12, 13, 21, 22, 23, 31, 32, 33, 4,
                                                     5, 6, 7, 51, 52, 53, 61, 62, 63, 71, 72, 73, 8}};
    const Solution plane{2, kinds, 2, Buffer<double>{1, 2, 11, 12, 21, 22, 4, 5, 6, 51, 52, 61, 62, 8}};
    CHECK(*flattened(space, {}) == plane);
    CHECK(*flattened(plane, {}) == plane);
    CHECK(flattened(Solution{3, {}, 2, {}}, {})->dimension == 2);
}
