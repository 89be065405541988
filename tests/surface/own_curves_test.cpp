// The surrogate of a curved mesh whose curves are no smooth surface's: its own facets and edges, exactly.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "meshes.hpp"

using namespace surface_tests;

namespace {

/// The mesh with boundary nodes bowed by up to a fifth of their chords; `within`: what that leaves of a shift.
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
Outcome<Surrogate<D>> with_own(const QuadraticMesh<D>& mesh, const Built<D>& built) {
    return with_curves<D>(built.surrogate, {mesh.linear, mesh.edges, built.features, mesh.mid_nodes.view()},
                          StraightGeometry<D>{}, SurrogateOptions{}, Execution{.threads = 1})
        .map([](CurvedSurrogate<D> curved) { return std::move(curved.surrogate); });
}

/// Of a facet of degree 2, cut at its nodes.
template <int D>
constexpr std::size_t pieces = D == 3 ? 4 : 2;

/// Every facet of the surrogate is a part of the mesh's own curved facet, or in its plane.
template <int D>
void check_own(const QuadraticMesh<D>& mesh, const Features<D>& features, const Surrogate<D>& surrogate) {
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

TEST_CASE("a curved mesh's own boundary as a geometry, in 3D") {
    const Built<3> built = build(torus(6, 3, 1).mesh());
    const auto mesh = bowed(built.mesh, built.features, [](const Vec<3>& shift) { return shift; });
    const Surrogate<3> surrogate = with_own(mesh, built).value();
    check_own(mesh, built.features, surrogate);
}

TEST_CASE("a curved mesh's own boundary as a geometry, in 2D") {
    const Built<2> built = build(polygon({{{0, 0}}, {{2, 0}}, {{3, 1}}, {{2, 2}}, {{0, 2}}, {{-1, 1}}}).mesh());
    const auto mesh = bowed(built.mesh, built.features, [](const Vec<2>& shift) { return shift; });
    check_own(mesh, built.features, with_own(mesh, built).value());
}

TEST_CASE("a mesh whose nodes lie on its smooth surface, or on its chords, has that as its geometry") {
    const Built<3> built = build(torus(6, 3, 1).mesh());
    QuadraticMesh<3> mesh = built.mesh;
    CHECK(with_own(mesh, built).value().facets == built.surrogate.facets);
    mesh.mid_nodes = Column<LagrangeNode<3>>(Buffer<LagrangeNode<3>>(built.nodes.begin(), built.nodes.end()));
    const Surrogate<3> same = with_own(mesh, built).value();
    CHECK(same.facets == built.surrogate.facets);
    CHECK(same.edge_curves == built.surrogate.edge_curves);
}

TEST_CASE("of planes only those stay flat whose nodes are in them; straight edges stay straight to the last bit") {
    const Built<3> built = build(cube(3).mesh());
    const auto flat = with_own(built.mesh, built).value();
    CHECK(flat.flats == built.surrogate.flats);
    for (std::size_t row = 0; row < flat.edges.size(); ++row)
        CHECK(flat.edge_curves[row] == built.surrogate.edge_curves[row]);
    const auto mesh = bowed(built.mesh, built.features, [](const Vec<3>& shift) { return Vec<3>{{0, 0, shift[2]}}; });
    const auto bent = with_own(mesh, built).value();
    std::size_t left = 0;
    for (std::size_t patch = 0; patch < bent.flats.size(); ++patch) {
        if (!bent.flats[patch].is_flat()) continue;
        ++left;
        CHECK(bent.flats[patch].normal[2] == 0);
    }
    CHECK(left == 4);
    check_own(mesh, built.features, bent);
}
