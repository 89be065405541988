// Interfaces between materials are surfaces like the boundary, with ridges at sharp folds and at the boundary.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include <doctest/doctest.h>

#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.shapes;
import camber.surface;

using namespace camber;

namespace {

const Execution one_thread{.threads = 1};

template <int D>
struct Curved {
    QuadraticMesh<D> mesh;
    Features<D> features;
    Buffer<LagrangeNode<D>> nodes;
};

template <class T>
T value_of(Outcome<T> outcome) {
    REQUIRE_MESSAGE(outcome.has_value(), describe(outcome.has_value() ? Error{} : outcome.error()));
    return std::move(*outcome);
}

template <int D>
Curved<D> on_surrogate(LinearMesh<D> linear) {
    Curved<D> c;
    c.mesh = value_of(elevate(std::move(linear), one_thread));
    c.features = value_of(find_features(c.mesh.linear, c.mesh.edges, FeatureOptions<D>{}, one_thread));
    const Geometry<D> geometry =
        value_of(build_surrogate(c.mesh.linear, c.mesh.edges, c.features, SurrogateOptions{}, one_thread));
    c.nodes = value_of(boundary_nodes(c.mesh, c.features, geometry, one_thread));
    return c;
}

template <int D>
Vec<D> chord_middle(const Curved<D>& c, std::size_t e) {
    const auto& [a, b] = c.mesh.edges.vertices[e];
    return midpoint(c.mesh.linear.points[a], c.mesh.linear.points[b]);
}

/// A lattice whose materials are 1 + the number that `material` returns for the lowest corner of a cell.
template <int D, class Material>
LinearMesh<D> lattice(const std::array<int, D>& cells, Material&& material) {
    Lattice<D> l = value_of(lattice_of<D>(cells, 5, one_thread));
    Buffer<Reference> materials(l.elements.size());
    for (std::size_t e = 0; e < l.elements.size(); ++e) {
        std::array<int, D> low = cells;
        for (const VertexId v : l.elements[e])
            for (int i = 0; i < D; ++i) low[i] = std::min(low[i], l.place(v.index())[i]);
        materials[e] = 1 + material(low);
    }
    const auto side = [&](const SimplexVertices<D - 1>& facet) { return l.side(facet) == 0 ? 9 : l.side(facet); };
    auto points = l.points;
    auto elements = l.elements;
    return value_of(bounded_mesh<D>(std::move(points), std::move(elements), std::move(materials), side));
}

template <int D>
std::size_t count(const Features<D>& features, EdgeKind kind) {
    return static_cast<std::size_t>(std::count(features.edge_kinds.begin(), features.edge_kinds.end(), kind));
}

}  // namespace

TEST_CASE("the interface of a coated sphere is smooth and curved onto its sphere") {
    ShellOptions<3> options{.inner_size = 0.5, .outer_size = 1.2};
    options.outer_radius = 3;
    options.inner_layer = {.count = 2, .first_height = 0.1, .growth = 1.2, .material = 2, .interface = 9};
    const double radius = 1 + thickness(options.inner_layer);
    const auto c = on_surrogate(value_of(generate(options)));
    CHECK(c.features.patch_count == 3);
    CHECK(count(c.features, EdgeKind::ridge) == 0);
    double straight = 0, curved = 0;
    std::size_t edges = 0;
    for (std::size_t f = 0; f < c.mesh.linear.facets.size(); ++f) {
        if (c.mesh.linear.facets.references[f] != 9) continue;
        for (const EdgeId e : c.mesh.edges.of_facets[f]) {
            CHECK(c.features.edge_kinds[e] == EdgeKind::surface);
            straight = std::max(straight, std::abs(norm(chord_middle(c, e.index())) - radius));
            curved = std::max(curved, std::abs(norm(c.nodes[e.index()].point) - radius));
            ++edges;
        }
    }
    CHECK(edges > 100);
    CHECK(curved < straight / 50);
}

TEST_CASE("interface nodes do not depend on the orientation of the facets") {
    ShellOptions<2> options{.inner_size = 0.4, .outer_size = 1};
    options.inner_layer = {.count = 2, .first_height = 0.1, .growth = 1.2, .material = 2, .interface = 9};
    const auto mesh = value_of(generate(options));
    auto turned = mesh;
    auto facets = take(turned.facets.vertices);
    for (std::size_t f = 0; f < facets.size(); f += 2) std::swap(facets[f][0], facets[f][1]);
    turned.facets.vertices = std::move(facets);
    const auto a = on_surrogate(mesh), b = on_surrogate(turned);
    CHECK(a.features.patch_count == b.features.patch_count);
    for (std::size_t e = 0; e < a.nodes.size(); ++e) CHECK(distance(a.nodes[e].point, b.nodes[e].point) < 1e-12);
}

TEST_CASE("a cube within a cube has interface ridges and corners and keeps its planes") {
    const auto c = on_surrogate(lattice<3>({6, 6, 6}, [](const std::array<int, 3>& cell) {
        return static_cast<Reference>(std::ranges::all_of(cell, [](int i) { return i >= 2 && i < 4; }));
    }));
    CHECK(c.features.patch_count == 12);
    CHECK(c.features.corners == 16);
    CHECK(count(c.features, EdgeKind::ridge) == 12 * 6 + 12 * 2);
    for (std::size_t e = 0; e < c.nodes.size(); ++e) CHECK(c.nodes[e].point == chord_middle(c, e));
}

TEST_CASE("an interface meets the boundary in a ridge that lies on both surfaces") {
    // A part of a spherical shell with two materials on either side of the plane x = 0.
    auto mesh = lattice<3>({6, 6, 2}, [](const std::array<int, 3>& cell) { return cell[0] < 3 ? 0 : 1; });
    auto points = take(mesh.points);
    for (Vec<3>& p : points)
        p = (1 + p[2]) * normalised(Vec<3>{{std::tan(0.8 * (p[0] - 0.5)), std::tan(0.8 * (p[1] - 0.5)), 1}});
    mesh.points = std::move(points);
    const auto c = on_surrogate(std::move(mesh));
    std::size_t rim_edges = 0;
    double straight = 0, curved = 0;
    for (std::size_t e = 0; e < c.nodes.size(); ++e) {
        const auto& [a, b] = c.mesh.edges.vertices[e];
        const Vec<3> p = c.mesh.linear.points[a], q = c.mesh.linear.points[b];
        if (std::abs(p[0]) > 1e-12 || std::abs(q[0]) > 1e-12) continue;
        CHECK(std::abs(c.nodes[e].point[0]) < 1e-12);  // the interface is a plane
        if (std::abs(norm(p) - 1) > 1e-12 || std::abs(norm(q) - 1) > 1e-12) continue;
        ++rim_edges;
        CHECK(c.features.edge_kinds[e] == EdgeKind::ridge);
        straight = std::max(straight, std::abs(norm(midpoint(p, q)) - 1));
        curved = std::max(curved, std::abs(norm(c.nodes[e].point) - 1));
    }
    CHECK(rim_edges == 6);
    CHECK(curved < straight / 50);
}
