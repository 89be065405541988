// Drawn faces enclose the selected elements, with or without a cut; each edge is drawn once.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <utility>

import camber.core;
import camber.bezier;
import camber.drawing;

#include "meshes.hpp"
#include "property.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
QuadraticMesh<D> block(std::uint64_t seed, std::array<int, D> cells) {
    LatticeOptions<D> options;
    options.cells = cells;
    options.jitter = 0.1;
    options.seed = seed;
    auto mesh = elevate(lattice_mesh<D>(options), Execution{});
    REQUIRE(mesh);
    return std::move(*mesh);
}

Buffer<std::uint8_t> random_selection(std::size_t elements, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    Buffer<std::uint8_t> selected(elements);
    for (auto& k : selected) k = static_cast<std::uint8_t>(random() % 2);
    return selected;
}

double volume(const QuadraticMesh<3>& mesh, std::span<const std::uint8_t> selected) {
    double sum = 0;
    for (std::size_t e = 0; e < selected.size(); ++e)
        if (selected[e] != 0) sum += orientation(corners(mesh.linear, e)) / 6;
    return sum;
}

/// The enclosed volume by the divergence theorem.
double enclosed(const QuadraticMesh<3>& mesh, std::span<const Face> faces) {
    double sum = 0;
    for (const Face& f : faces)
        sum += det(node_point(as_mesh(mesh), f.nodes[0]), node_point(as_mesh(mesh), f.nodes[1]),
                   node_point(as_mesh(mesh), f.nodes[2])) /
               6;
    return sum;
}

}  // namespace

TEST_CASE("drawn faces enclose the selected elements") {
    property("in 3D", [](std::uint64_t seed) {
        const auto mesh = block<3>(seed, {3, 2, 2});
        const auto selected = random_selection(mesh.linear.elements.size(), seed);
        const auto faces = faces_to_draw(as_mesh(mesh), std::span<const std::uint8_t>(selected), Execution{});
        RC_ASSERT(faces.has_value());
        RC_ASSERT(std::abs(enclosed(mesh, faces->view()) - volume(mesh, selected)) < 1e-12);
        for (const Face& f : *faces) {
            RC_ASSERT(selected[f.element] == 1);
            for (std::size_t i = 0; i < 3; ++i)
                RC_ASSERT(distance(node_point(as_mesh(mesh), f.nodes[3 + i]),
                                   midpoint(node_point(as_mesh(mesh), f.nodes[i]),
                                            node_point(as_mesh(mesh), f.nodes[(i + 1) % 3]))) < 1e-14);
        }
        for (const FaceEdge& edge : edges_to_draw(as_mesh(mesh), faces->view())) RC_ASSERT(edge.faces % 2 == 0U);
    });
    property("the drawn faces of a 2D mesh are the selected elements", [](std::uint64_t seed) {
        const auto mesh = block<2>(seed, {4, 3});
        const auto selected = random_selection(mesh.linear.elements.size(), seed);
        const auto faces = faces_to_draw(as_mesh(mesh), std::span<const std::uint8_t>(selected), Execution{});
        RC_ASSERT(faces.has_value());
        std::size_t sum = 0;
        for (const FaceEdge& edge : edges_to_draw(as_mesh(mesh), faces->view())) sum += edge.faces;
        RC_ASSERT(sum == 3 * faces->size());
        RC_ASSERT(faces->size() == static_cast<std::size_t>(std::count(selected.begin(), selected.end(), 1)));
    });
}

TEST_CASE("a cut keeps whole elements on one side") {
    const auto mesh = block<3>(7, {4, 3, 3});
    const Cut<3> cut{normalised(Vec<3>{{1, 0.5, 0.2}}), 2};
    const auto selected = elements_inside_cut(cut, as_mesh(mesh), Execution{});
    REQUIRE(selected);
    const auto faces = faces_to_draw(as_mesh(mesh), selected->view(), Execution{});
    REQUIRE(faces);
    std::size_t uncovered = 0;
    for (const Face& f : *faces) {
        const auto c = corners(mesh.linear, f.element);
        CHECK(dot(cut.normal, 0.25 * (c[0] + c[1] + c[2] + c[3])) <= cut.offset);
        uncovered += f.kind == FaceKind::uncovered ? 1 : 0;
        if (f.kind == FaceKind::uncovered) CHECK(f.reference == mesh.linear.elements.references[f.element]);
    }
    CHECK(uncovered > 0);
    CHECK(std::abs(enclosed(mesh, faces->view()) - volume(mesh, selected->view())) < 1e-12);
}

TEST_CASE("a surface mesh is drawn by its facets with their references") {
    auto solid = block<3>(3, {2, 2, 2});
    const auto outside = faces_to_draw(as_mesh(solid), {}, Execution{});
    REQUIRE(outside);
    LinearMesh<3> surface;
    surface.points = solid.linear.points;
    surface.point_references = solid.linear.point_references;
    Buffer<SimplexVertices<2>> facets;
    for (const Face& f : *outside) facets.push_back({VertexId(f.nodes[0]), VertexId(f.nodes[1]), VertexId(f.nodes[2])});
    surface.facets.references = Buffer<Reference>(facets.size(), 5);
    surface.facets.vertices = std::move(facets);
    const auto shell = elevate(surface, Execution{});
    REQUIRE(shell);
    const auto faces = faces_to_draw(as_mesh(*shell), {}, Execution{});
    REQUIRE(faces);
    CHECK(faces->size() == outside->size());
    CHECK(std::abs(enclosed(*shell, faces->view()) - 8) < 2);
    CHECK(std::all_of(faces->begin(), faces->end(), [](const Face& f) { return f.reference == 5; }));
    // Boundary faces of a solid take the reference of the facet that lists them.
    solid.linear.facets = surface.facets;
    const auto named = faces_to_draw(as_mesh(solid), {}, Execution{});
    REQUIRE(named);
    CHECK(std::all_of(named->begin(), named->end(), [](const Face& f) { return f.reference == 5; }));
}

namespace {

/// A block with random references of its elements and facets. Facets are all outer triangles and some inner ones.
QuadraticMesh<3> block_with_groups(std::uint64_t seed) {
    auto mesh = block<3>(seed, {3, 2, 2});
    std::mt19937_64 random(seed);
    Buffer<Reference> of_elements(mesh.linear.elements.size());
    for (Reference& r : of_elements) r = static_cast<Reference>(1 + random() % 2);
    Buffer<SimplexVertices<2>> facets;
    Buffer<Reference> of_facets;
    const auto selected = random_selection(mesh.linear.elements.size(), seed);
    for (const bool is_inner : {false, true}) {
        const auto faces = must(faces_to_draw(
            as_mesh(mesh), is_inner ? std::span<const std::uint8_t>(selected) : std::span<const std::uint8_t>(),
            Execution{}));
        for (const Face& f : faces) {
            if (is_inner && f.kind != FaceKind::uncovered) continue;
            facets.push_back({VertexId(f.nodes[0]), VertexId(f.nodes[1]), VertexId(f.nodes[2])});
            of_facets.push_back(static_cast<Reference>(is_inner ? 6 : 3 + random() % 2));
        }
    }
    mesh.linear.elements.references = std::move(of_elements);
    mesh.linear.facets.vertices = std::move(facets);
    mesh.linear.facets.references = std::move(of_facets);
    return must(elevate(mesh.linear, Execution{}));
}

std::size_t count_of(const Column<Reference>& references, Reference reference) {
    return static_cast<std::size_t>(std::count(references.begin(), references.end(), reference));
}

}  // namespace

TEST_CASE("drawn faces are limited to the selected groups") {
    property("hidden facets are not drawn, and all other faces are", [](std::uint64_t seed) {
        const auto mesh = block_with_groups(seed);
        const auto selected = random_selection(mesh.linear.elements.size(), seed + 1);
        const std::span<const std::uint8_t> mask(selected);
        const auto all = must(faces_to_draw(as_mesh(mesh), mask, Execution{}));
        const auto some = must(faces_to_draw(as_mesh(mesh), mask, DrawnGroups{{}, {}, {3}}, Execution{}));
        std::size_t at = 0;
        for (const Face& f : all) {
            if (f.kind == FaceKind::boundary && f.reference == 3) continue;
            RC_ASSERT(at < some.size());
            RC_ASSERT(some[at++] == f);
        }
        RC_ASSERT(at == some.size());
    });
    property("the drawn faces of bodies enclose their volume", [](std::uint64_t seed) {
        const auto mesh = block_with_groups(seed);
        const auto bodies = random_selection(mesh.linear.elements.size(), seed + 1);
        const auto faces = must(
            faces_to_draw(as_mesh(mesh), {}, DrawnGroups{std::span<const std::uint8_t>(bodies), {}, {}}, Execution{}));
        RC_ASSERT(std::abs(enclosed(mesh, faces.view()) - volume(mesh, bodies)) < 1e-12);
    });
    property("only the facets of the selected groups are drawn, also inside the mesh", [](std::uint64_t seed) {
        const auto mesh = block_with_groups(seed);
        const Buffer<std::uint8_t> none(mesh.linear.elements.size(), 0);
        const auto faces = must(faces_to_draw(
            as_mesh(mesh), {}, DrawnGroups{std::span<const std::uint8_t>(none), {4, 6}, {}}, Execution{}));
        std::array<std::size_t, 2> counts{};
        for (const Face& f : faces) {
            RC_ASSERT(f.reference == 4 || f.reference == 6);
            RC_ASSERT(f.kind == FaceKind::facet);
            ++counts[f.reference == 4 ? 0 : 1];
        }
        RC_ASSERT(counts[0] == count_of(mesh.linear.facets.references, 4));
        RC_ASSERT(counts[1] == count_of(mesh.linear.facets.references, 6));
    });
}
