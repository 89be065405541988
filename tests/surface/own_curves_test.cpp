// The surrogate of a curved mesh whose edges lie on no smooth surface consists of its own facets and edges.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "meshes.hpp"

using namespace surface_tests;

namespace {

/// Bows the boundary nodes by up to a fifth of their chords; `within` projects the shift.
template <int D, class Within>
QuadraticMesh<D> bowed(QuadraticMesh<D> mesh, const Features<D>& features, Within&& within) {
    Random random(7);
    auto nodes = take(std::move(mesh.mid_nodes));
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        if (features.edge_kinds[e] == EdgeKind::volume) continue;
        const auto& [a, b] = mesh.edges.vertices[EdgeId(e)];
        Vec<D> shift;
        for (int i = 0; i < D; ++i) shift[i] = random(-0.1, 0.1);
        nodes[e].point += distance(mesh.linear.points[a], mesh.linear.points[b]) * within(shift);
    }
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

template <int D>
Outcome<Surrogate<D>> surrogate_of_mesh(const QuadraticMesh<D>& mesh, const Built<D>& built) {
    return build_curved_surrogate<D>(built.surrogate, {mesh.linear, mesh.edges, built.features, mesh.mid_nodes.view()},
                                     StraightGeometry<D>{}, SurrogateOptions{}, Execution{.threads = 1})
        .map([](CurvedSurrogate<D> curved) { return std::move(curved.surrogate); });
}

/// Number of pieces of a degree-2 facet that is cut at its nodes.
template <int D>
constexpr std::size_t pieces = D == 3 ? 4 : 2;

/// Checks that each facet of the surrogate is part of the curved facet of the mesh, or in its plane.
template <int D>
void check_surrogate(const QuadraticMesh<D>& mesh, const Features<D>& features, const Surrogate<D>& surrogate) {
    Random random(8);
    REQUIRE(surrogate.facets.size() == pieces<D> * mesh.linear.facets.size());
    const Geometry<D> geometry(surrogate);
    double farthest = 0;
    for (std::size_t f = 0; f < mesh.linear.facets.size(); ++f) {
        Barycentric<D - 1> xi{};
        double sum = 0;
        for (double& x : xi) sum += x = random(0.01, 1);
        for (double& x : xi) x /= sum;
        const Vec<D> own = facet_of(mesh, FacetId(f)).point(xi);
        const auto& flat = surrogate.flats[features.patches[f]];
        double nearest = flat.is_flat() ? std::fabs(flat.height(own)) : 1;
        for (std::size_t i = pieces<D> * f; i < pieces<D> * (f + 1) && !flat.is_flat(); ++i)
            nearest = std::fmin(nearest, std::sqrt(closest_on(surrogate.facets[i], own).distance_squared));
        farthest = std::fmax(farthest, nearest);
    }
    CHECK(farthest < 1e-10);
    double off_nodes = 0;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        if (features.edge_kinds[e] == EdgeKind::volume) continue;
        off_nodes = std::fmax(off_nodes, project(geometry, {}, mesh.mid_nodes[e].point).distance);
    }
    CHECK(off_nodes < 1e-12);
}

}  // namespace

TEST_CASE("with_curves reproduces the boundary of a curved mesh in 3D") {
    const Built<3> built = build(torus(6, 3, 1).mesh());
    const auto mesh = bowed(built.mesh, built.features, [](const Vec<3>& shift) { return shift; });
    const Surrogate<3> surrogate = surrogate_of_mesh(mesh, built).value();
    check_surrogate(mesh, built.features, surrogate);
}

TEST_CASE("with_curves reproduces the boundary of a curved mesh in 2D") {
    const Built<2> built = build(polygon({{{0, 0}}, {{2, 0}}, {{3, 1}}, {{2, 2}}, {{0, 2}}, {{-1, 1}}}).mesh());
    const auto mesh = bowed(built.mesh, built.features, [](const Vec<2>& shift) { return shift; });
    check_surrogate(mesh, built.features, surrogate_of_mesh(mesh, built).value());
}

TEST_CASE("with_curves keeps the surrogate if nodes lie on it or on the chords") {
    const Built<3> built = build(torus(6, 3, 1).mesh());
    QuadraticMesh<3> mesh = built.mesh;
    CHECK(surrogate_of_mesh(mesh, built).value().facets == built.surrogate.facets);
    mesh.mid_nodes = Column<LagrangeNode<3>>(Buffer<LagrangeNode<3>>(built.nodes.begin(), built.nodes.end()));
    const Surrogate<3> same = surrogate_of_mesh(mesh, built).value();
    CHECK(same.facets == built.surrogate.facets);
    CHECK(same.edge_curves == built.surrogate.edge_curves);
}

TEST_CASE("with_curves keeps only the planes that contain all their nodes") {
    const Built<3> built = build(cube(3).mesh());
    const auto flat = surrogate_of_mesh(built.mesh, built).value();
    CHECK(flat.flats == built.surrogate.flats);
    for (std::size_t row = 0; row < flat.edges.size(); ++row)
        CHECK(flat.edge_curves[row] == built.surrogate.edge_curves[row]);
    const auto mesh = bowed(built.mesh, built.features, [](const Vec<3>& shift) { return Vec<3>{{0, 0, shift[2]}}; });
    const auto bent = surrogate_of_mesh(mesh, built).value();
    std::size_t flat_patches = 0;
    for (std::size_t patch = 0; patch < bent.flats.size(); ++patch) {
        if (!bent.flats[patch].is_flat()) continue;
        ++flat_patches;
        CHECK(bent.flats[patch].normal[2] == 0);
    }
    CHECK(flat_patches == 4);
    check_surrogate(mesh, built.features, bent);
}
