// Layers that end at curved walls: the displacement of boundary curves is extended over the faces, then into the
// volume.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.extension;
import camber.surface;
import camber.validity;
import camber.curving;

using namespace camber;
using namespace camber::testing;

namespace {

constexpr Reference wall = 1, outer = 2, bottom = 3, end_wall = 4, side_y = 5, side_x = 6, second_end = 7;

/// Layers on a quarter of the cylinder of radius 1 about the z axis, from the plane z = 0 to an end wall.
struct Layers {
    double first = 1e-3, growth = 1.8;  ///< height of the first layer
    int count = 8;                      ///< number of layers
    std::array<int, 2> cells{8, 3};     ///< around and along the cylinder
    Sphere<3> end{{{0, 0, 3.5}}, 3};    ///< its lower half is the end wall
    bool is_end_split = false;          ///< the end wall has another reference beyond the second layer
    bool has_outer_surface = true;
    bool is_from_mesh = false;  ///< the geometry is a surrogate of the mesh
    double noise = 0;           ///< largest shift of a vertex coordinate, relative to `first`

    [[nodiscard]] double radius(double layer) const { return 1 + first * (std::pow(growth, layer) - 1) / (growth - 1); }
    [[nodiscard]] Vec<3> place(const Vec<3>& p) const {
        const double angle = 0.5 * std::acos(-1.0) * p[0] / cells[0], r = radius(p[2]);
        const double x = r * std::cos(angle), y = r * std::sin(angle);
        const double height = end.centre[2] - std::sqrt(end.radius * end.radius - std::pow(x - end.centre[0], 2) -
                                                        std::pow(y - end.centre[1], 2));
        return {{x, y, height * p[1] / cells[1]}};
    }
    [[nodiscard]] Geometry<3> geometry() const {
        const Vec<3> origin{}, x{{1, 0, 0}}, y{{0, 1, 0}}, z{{0, 0, 1}};
        AnalyticGeometry<3> surfaces{{{wall, Cylinder{origin, z, 1}},
                                      {bottom, Plane<3>{origin, z}},
                                      {end_wall, end},
                                      {second_end, end},
                                      {side_y, Plane<3>{origin, y}},
                                      {side_x, Plane<3>{origin, x}}}};
        if (has_outer_surface) surfaces.surfaces.emplace_back(outer, Cylinder{origin, z, radius(count)});
        return surfaces;
    }
};

struct Junction {
    QuadraticMesh<3> mesh;
    Features<3> features;
    Geometry<3> geometry;
    Column<LagrangeNode<3>> projected;  ///< boundary nodes before extension over the faces
    Incidence<ElementId> shells;

    [[nodiscard]] Column<LagrangeNode<3>> over_faces(const Execution& execution) const {
        return must(extend_over_faces(mesh, features.edge_kinds, projected, features, geometry, execution));
    }
    /// The minimum coefficient of the scaled Jacobian after these boundary nodes are extended into the volume.
    [[nodiscard]] double smallest(const Column<LagrangeNode<3>>& nodes) const {
        Proposal<3> proposal = must(curve_boundary(mesh, features.edge_kinds, nodes, one_thread)).proposal;
        proposal.mid_nodes = must(extend_boundary(mesh, features.edge_kinds, nodes, shells, {}, one_thread)).nodes;
        return must(validate(mesh, proposal, 0, one_thread)).validation().smallest;
    }
    /// The largest distance of a boundary node from the surface of its facets.
    [[nodiscard]] double off(const Column<LagrangeNode<3>>& nodes) const {
        double largest = 0;
        for (std::size_t f = 0; f < mesh.linear.facets.size(); ++f) {
            const FacetSite<3> site = facet_site(mesh.linear, FacetId(f));
            if (!geometry->has_surface_at(site)) continue;
            for (const EdgeId e : mesh.edges.of_facets[f])
                largest = std::max(largest, project(geometry, {.reference = site.reference}, nodes[e].point).distance);
        }
        return largest;
    }
};

/// The reference of a boundary facet, from its vertices before any noise.
Reference reference_of(const Layers& layers, const std::array<Vec<3>, 3>& p) {
    const auto all = [&](const auto& is_on) { return std::ranges::all_of(p, is_on); };
    const auto radius = [](const Vec<3>& v) { return std::hypot(v[0], v[1]); };
    if (all([&](const Vec<3>& v) { return std::abs(radius(v) - 1) < 1e-12; })) return wall;
    if (all([&](const Vec<3>& v) { return std::abs(radius(v) - layers.radius(layers.count)) < 1e-12; })) return outer;
    if (all([](const Vec<3>& v) { return v[2] == 0; })) return bottom;
    if (all([](const Vec<3>& v) { return std::abs(v[1]) < 1e-12; })) return side_y;
    if (all([](const Vec<3>& v) { return std::abs(v[0]) < 1e-12; })) return side_x;
    const bool is_second = all([&](const Vec<3>& v) { return radius(v) > layers.radius(1.5); });
    return layers.is_end_split && is_second ? second_end : end_wall;
}

Junction junction(const Layers& layers, std::uint64_t seed = 1) {
    LatticeOptions<3> options;
    options.cells = {layers.cells[0], layers.cells[1], layers.count};
    options.seed = seed;
    options.place = [&](const Vec<3>& p) { return layers.place(p); };
    LinearMesh<3> linear = lattice_mesh(options);
    Buffer<SimplexVertices<2>> facets;
    Buffer<Reference> references;
    for (const ElementFace& face :
         boundary_faces<3>(must(neighbours(linear, must(balls(linear, one_thread)), one_thread)))) {
        const auto v = face_of(linear, face);
        facets.push_back(v);
        references.push_back(reference_of(layers, {linear.points[v[0]], linear.points[v[1]], linear.points[v[2]]}));
    }
    linear.facets.vertices = std::move(facets);
    linear.facets.references = std::move(references);
    if (layers.noise > 0) {
        Dice dice(seed);
        Buffer<Vec<3>> points(linear.points.begin(), linear.points.end());
        for (Vec<3>& p : points) p += dice.vector<3>(-layers.noise * layers.first, layers.noise * layers.first);
        linear.points = std::move(points);
    }
    auto mesh = must(elevate(std::move(linear), one_thread));
    auto features = must(find_features(mesh.linear, mesh.edges, {}, one_thread));
    const Geometry<3> geometry =
        layers.is_from_mesh ? Geometry<3>(must(build_surrogate(mesh.linear, mesh.edges, features, {}, one_thread)))
                            : layers.geometry();
    auto projected = must(boundary_nodes(mesh, features, geometry, one_thread));
    auto around = must(shells(mesh.edges, one_thread));
    return {std::move(mesh), std::move(features), geometry, std::move(projected), std::move(around)};
}

}  // namespace

TEST_CASE("layers that end at a curved wall are valid with all nodes on the geometry") {
    property("extend_over_faces yields valid layers on a cylinder that ends at a sphere",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 Layers layers;
                 layers.growth = dice.uniform(1.4, 2.4);
                 layers.first = 0.1 * (layers.growth - 1) / std::pow(layers.growth, layers.count);
                 layers.end.radius = dice.uniform(2, 4);
                 layers.end.centre = {{dice.uniform(-0.3, 0.3), dice.uniform(-0.3, 0.3), layers.end.radius + 0.5}};
                 const Junction j = junction(layers, seed + 1);
                 const auto nodes = j.over_faces(one_thread);
                 RC_ASSERT(j.off(nodes) < 1e-12);
                 RC_ASSERT(j.smallest(j.projected) < 0);
                 RC_ASSERT(j.smallest(nodes) > 0.6);
                 for (std::size_t e = 0; e < nodes.size(); ++e)
                     if (j.features.edge_kinds[e] == EdgeKind::ridge) RC_ASSERT(nodes[e] == j.projected[e]);
                 RC_ASSERT(nodes == j.over_faces(Execution{.threads = 3}));
             },
             {10});
}

TEST_CASE("layers that end at a curved wall are valid on the surrogate of their mesh") {
    property("extend_over_faces yields valid layers on the surrogate of the mesh",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 Layers layers{.growth = dice.uniform(1.4, 2.0), .is_from_mesh = true};
                 layers.first = 0.1 * (layers.growth - 1) / std::pow(layers.growth, layers.count);
                 layers.end.radius = dice.uniform(2, 4);
                 layers.end.centre[2] = layers.end.radius + 0.5;
                 const Junction j = junction(layers, seed + 1);
                 RC_ASSERT(j.smallest(j.over_faces(one_thread)) > 0.5);
             },
             {5});
}

TEST_CASE("nodes of a wall without a geometry follow the volume") {
    Layers layers{.first = 5e-5, .growth = 1.7, .count = 6};
    layers.has_outer_surface = false;
    const Junction j = junction(layers);
    const auto base = j.over_faces(one_thread);
    CHECK(j.smallest(base) < 0);
    const auto kinds = must(kinds_with_following(j.mesh, j.features.edge_kinds, j.features, j.geometry, one_thread));
    Proposal<3> proposal = must(curve_boundary(j.mesh, j.features.edge_kinds, base, one_thread)).proposal;
    proposal.mid_nodes = must(extend_boundary(j.mesh, kinds, base, j.shells, {}, one_thread)).nodes;
    CHECK(must(validate(j.mesh, proposal, 0, one_thread)).validation().smallest > 0.6);
    const Junction with_all = junction({});
    CHECK(must(kinds_with_following(with_all.mesh, with_all.features.edge_kinds, with_all.features, with_all.geometry,
                                    one_thread)) == with_all.features.edge_kinds);
}

TEST_CASE("two references on one surface are treated as one face") {
    Layers layers;
    const Junction one = junction(layers);
    layers.is_end_split = true;
    const Junction two = junction(layers);
    REQUIRE(two.features.ridge_edges > one.features.ridge_edges);
    const auto nodes = one.over_faces(one_thread), of_two = two.over_faces(one_thread);
    for (std::size_t e = 0; e < nodes.size(); ++e) CHECK(distance(nodes[e].point, of_two[e].point) < 1e-12);
}

TEST_CASE("a curve between a face and a wall without a geometry follows the face") {
    Layers layers{.first = 5e-5, .growth = 1.7, .count = 6};
    layers.has_outer_surface = false;
    const Junction j = junction(layers);
    const auto nodes = j.over_faces(one_thread);
    CHECK(j.off(nodes) < 1e-12);
    std::size_t moved = 0;
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = j.mesh.edges.vertices[e];
        const auto is_outer = [&](VertexId v) {
            return std::abs(std::hypot(j.mesh.linear.points[v][0], j.mesh.linear.points[v][1]) - layers.radius(6)) <
                   1e-12;
        };
        if (j.features.edge_kinds[e] == EdgeKind::ridge && is_outer(a) && is_outer(b) && nodes[e] != j.projected[e])
            ++moved;
    }
    CHECK(moved >= 8);  // edges of the outer circle in the end wall
}

TEST_CASE("layers stay valid with vertices off their surfaces by a fifth of the first height") {
    for (const std::uint64_t seed : {1, 2, 3}) {
        const Junction j = junction({.first = 1e-3, .noise = 0.2}, seed);
        CHECK(j.smallest(j.over_faces(one_thread)) > 0.2);
    }
}

TEST_CASE("faces without displaced curves keep their nodes") {
    Layers layers;
    layers.end = {{{0, 0, 1e6}}, 1e6 - 1};
    const Junction j = junction(layers);
    Column<LagrangeNode<3>> straight = j.mesh.mid_nodes;
    const auto nodes = must(extend_over_faces(j.mesh, j.features.edge_kinds, straight, j.features,
                                              Geometry<3>(StraightGeometry<3>{}), one_thread));
    CHECK(nodes == straight);
}

TEST_CASE("a plane face in space gets the same nodes as the face in 2D") {
    const Layers layers;
    const Junction j = junction(layers);
    const auto nodes = j.over_faces(one_thread);
    // The bottom as a 2D mesh with the same displacement of its curves.
    const LinearMesh<3>& linear = j.mesh.linear;
    LinearMesh<2> plane;
    Buffer<Vec<2>> points;
    for (const Vec<3>& p : linear.points) points.push_back({{p[0], p[1]}});
    Buffer<SimplexVertices<2>> triangles;
    for (std::size_t f = 0; f < linear.facets.size(); ++f)
        if (linear.facets.references[f] == bottom) triangles.push_back(linear.facets.vertices[f]);
    const QuadraticMesh<2> flat = must(elevate(mesh_of<2>(std::move(points), std::move(triangles)), one_thread));
    Buffer<EdgeKind> kinds;
    Buffer<LagrangeNode<2>> boundary;
    const auto in_space = [&](std::size_t e) {
        return find_edge(j.mesh.edges, flat.edges.vertices[e][0], flat.edges.vertices[e][1]);
    };
    for (std::size_t e = 0; e < flat.edges.size(); ++e) {
        const Vec<3>& p = j.projected[in_space(e)].point;
        const bool is_curve = j.features.edge_kinds[in_space(e)] == EdgeKind::ridge;
        kinds.push_back(is_curve ? EdgeKind::fixed : EdgeKind::volume);
        boundary.push_back({{{p[0], p[1]}}});
    }
    const auto expected =
        must(extend_boundary(flat, Column<EdgeKind>(std::move(kinds)), Column<LagrangeNode<2>>(std::move(boundary)),
                             must(shells(flat.edges, one_thread)), {.tolerance = 1e-9, .stiffening = 1}, one_thread));
    for (std::size_t e = 0; e < flat.edges.size(); ++e) {
        const Vec<3>& p = nodes[in_space(e)].point;
        CHECK(p[2] == 0);
        CHECK(distance(Vec<2>{{p[0], p[1]}}, expected.nodes[e].point) < 1e-4);  // of a bow of 5e-3
    }
}
