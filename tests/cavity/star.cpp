// Cavities that `star` rejects or accepts.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "domains.hpp"
#include "meshes.hpp"

import camber.core;
import camber.cavity;

using namespace camber;
using namespace camber::testing;

TEST_CASE("star rejects required entities and cavities that are no ball") {
    LinearMesh<3> mesh = random_domain<3>(3);
    mesh.required_vertices = Buffer<VertexId>{VertexId(0)};
    mesh.elements.required = Buffer<std::uint32_t>{2};
    const DynamicMesh<3> dynamic = dynamic_of(mesh);
    StarWorkspace<3> workspace;
    Star<3> result;
    Cavity<3> cavity;
    cavity_of_vertex(dynamic, VertexId(0), cavity);
    CHECK(star(dynamic, cavity, mesh.elements.vertices[cavity.elements[0]][1], workspace, result) != StarFailure::none);
    cavity = {{ElementId(2)}, {}, {}};
    CHECK(star(dynamic, cavity, VertexId{}, workspace, result) == StarFailure::required);
    // A cavity that is no ball: two elements that share at most an edge.
    cavity = {{ElementId(0)}, {}, {}};
    for (std::size_t e = 3; e < mesh.elements.size(); ++e) {
        cavity.elements = {ElementId(0), ElementId(e)};
        if (std::ranges::find(dynamic.face_neighbours[0], FaceNeighbour(ElementId(e))) ==
            dynamic.face_neighbours[0].end())
            break;
    }
    CHECK(star(dynamic, cavity, VertexId{}, workspace, result) == StarFailure::ball);
}

TEST_CASE("star rejects the cavity of a line where the mesh touches itself") {
    // Two cubes with a common edge: a walk around the edge from one cube does not reach the other.
    LatticeOptions<3> options;
    options.cells = {2, 2, 1};
    options.keep = [](const Cell<3>& c) { return c[0] == c[1]; };
    const auto dynamic = dynamic_of(with_references<3>(lattice_mesh(options), options.cells, false));
    StarWorkspace<3> workspace;
    Star<3> result;
    Cavity<3> cavity;
    std::size_t tried = 0;
    for (std::size_t e = 0; e < dynamic.elements.size(); ++e)
        for (int k = 0; k < 6; ++k) {
            cavity_of_edge(dynamic, ElementId(e), k, cavity);
            const auto& ends = dynamic.edges[dynamic.edges_of[e][k]];
            if (!std::ranges::all_of(ends, [&](VertexId v) { return dynamic.states[v].marks.has(Mark::frozen); }))
                continue;
            ++tried;
            REQUIRE(cavity.lines.size() == 1);
            CHECK(star(dynamic, cavity, VertexId{}, workspace, result) == StarFailure::required);
        }
    CHECK(tried > 0);
}

TEST_CASE("star rejects cavities that would remove a surface") {
    for (const bool is_hole : {true, false}) {
        LatticeOptions<2> options;
        options.cells = {3, 3};
        if (is_hole) options.keep = [](const Cell<2>& c) { return c != Cell<2>{1, 1}; };
        LinearMesh<2> mesh = lattice_mesh(options);
        Buffer<Reference> materials(mesh.elements.size(), 1);
        for (std::size_t e = 0; e < materials.size(); ++e) {
            const Vec<2> m = middle_of(mesh, mesh.elements.vertices[e]);
            if (m[0] > 1 && m[0] < 2 && m[1] > 1 && m[1] < 2) materials[e] = 2;
        }
        mesh.elements.references = materials;
        Buffer<SimplexVertices<1>> facets;
        Buffer<Reference> references;
        const auto edges = must(unique_edges(mesh, one_thread));
        const auto around = must(shells(edges, one_thread));
        for (std::size_t e = 0; e < edges.size(); ++e) {
            const bool between =
                around[e].size() == 2 && materials[around[e][0].index()] != materials[around[e][1].index()];
            if (around[e].size() == 2 && !between) continue;
            facets.push_back({edges.vertices[e][0], edges.vertices[e][1]});
            const Vec<2> m = midpoint(mesh.points[facets.back()[0]], mesh.points[facets.back()[1]]);
            references.push_back(m[0] > 0.5 && m[0] < 2.5 && m[1] > 0.5 && m[1] < 2.5 ? 7 : 1);
        }
        mesh.facets = {std::move(facets), std::move(references), {}};
        const auto dynamic = dynamic_of(mesh);
        Cavity<2> cavity;
        for (std::size_t e = 0; e < mesh.elements.size(); ++e) cavity.elements.emplace_back(e);
        for (std::size_t f = 0; f < mesh.facets.size(); ++f)
            if (mesh.facets.references[f] == 7) cavity.facets.emplace_back(f);
        StarWorkspace<2> workspace;
        Star<2> result;
        CHECK(star(dynamic, cavity, VertexId{}, workspace, result) == StarFailure::surface);
    }
}

TEST_CASE("vertices collapse along a curve inside the volume") {
    LatticeOptions<3> options;
    options.cells = {4, 2, 2};
    LinearMesh<3> mesh = with_references<3>(lattice_mesh(options), options.cells, false);
    mesh.elements.references = Buffer<Reference>(mesh.elements.size(), 1);
    Buffer<SimplexVertices<2>> outer;
    Buffer<Reference> references;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if (mesh.facets.references[f] < 20) {
            outer.push_back(mesh.facets.vertices[f]);
            references.push_back(mesh.facets.references[f]);
        }
    mesh.facets = {std::move(outer), std::move(references), {}};
    const auto at = [&](double x, double y, double z) {
        std::size_t v = 0;
        while (mesh.points[v] != Vec<3>{{x, y, z}}) ++v;
        return VertexId(v);
    };
    mesh.edges = {Buffer<SimplexVertices<1>>{{at(1, 1, 1), at(2, 1, 1)}, {at(2, 1, 1), at(3, 1, 1)}},
                  Buffer<Reference>(2, 5),
                  {}};
    const auto dynamic = dynamic_of(mesh);
    CHECK(dynamic.states[at(2, 1, 1)].place == VertexPlace::line);
    CHECK(dynamic.states[at(1, 1, 1)].place == VertexPlace::corner);
    StarWorkspace<3> workspace;
    Patch<3> patch{dynamic.stamp, {at(1, 1, 1)}, {}, {}};
    cavity_of_vertex(dynamic, at(2, 1, 1), patch.removed);
    CHECK(may_collapse(dynamic, patch.removed, at(2, 1, 1), at(1, 1, 1)));
    REQUIRE(star(dynamic, patch.removed, at(1, 1, 1), workspace, patch.star) == StarFailure::none);
    const auto along = must(replace_cavities<3>(dynamic, {&patch, 1})).mesh;
    CHECK(check_consistency(along, one_thread).has_value());
    CHECK(along.line_count() == dynamic.line_count() - 1);
    // Reinserts the vertex of the line.
    patch.point.vertex = at(2, 1, 1);
    CHECK(star(dynamic, patch.removed, at(2, 1, 1), workspace, patch.star) == StarFailure::none);
}
