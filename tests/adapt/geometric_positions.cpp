// Boundary vertices store their geometric entity and parameters. Evaluating the geometry there returns the vertex.
#include <cstddef>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "dice.hpp"
#include "goals.hpp"
#include "meshes.hpp"
#include "named_domains.hpp"

import camber.core;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
Features<D> features_of(const NamedDomain<D>& domain, const EdgeSet<D>& edges) {
    const FeatureOptions<D> options{.ridge_angle_degrees = domain.ridge_angle_degrees};
    return must(find_features(domain.mesh, edges, options, one_thread));
}

template <int D>
Adaptation<D> remeshed(const NamedDomain<D>& domain, const AdaptationGoal<D>& goal) {
    const auto edges = must(unique_edges(domain.mesh, one_thread));
    const auto features = features_of(domain, edges);
    std::vector<VertexId> corners;
    for (std::size_t v = 0; v < domain.mesh.points.size(); ++v)
        if (features.vertex_kinds[v] == VertexKind::corner) corners.emplace_back(v);
    auto initial = must(begin_adaptation(domain.mesh, edges, {features.edge_kinds.view(), corners}, goal, one_thread));
    return must(remesh_to_metric<D>(std::move(initial), goal, {.rounds = 2}, one_thread)).state;
}

template <int D>
FacetSite<D> site(const DynamicMesh<D>& mesh, FacetId f) {
    FacetSite<D> out{{}, mesh.facets.references[f], {}};
    for (int i = 0; i < D; ++i) out.corners[i] = mesh.points[mesh.facets.vertices[f][i]];
    return out;
}

struct Counts {
    std::size_t on_surfaces = 0, on_curves = 0, with_parameters = 0;
};

/// Each vertex lies on the entity of its facets, at its stored parameters.
template <int D>
Counts expect_places(const Adaptation<D>& r, const Geometry<D>& geometry) {
    Counts counts;
    CHECK(r.vertices.places.size() == r.mesh.points.size());
    for (std::size_t v = 0; v < r.vertices.places.size(); ++v)
        if (r.mesh.states[v].place == VertexPlace::inside && !r.mesh.is_free(VertexId(v)))
            CHECK(r.vertices.places[v] == GeometryPosition{});
    for (std::size_t f = 0; f < r.mesh.facets.size(); ++f) {
        if (r.mesh.is_free(FacetId(f))) continue;
        const GeometryEntity surface = geometry->surface_at(site(r.mesh, FacetId(f)));
        for (const VertexId v : r.mesh.facets.vertices[f]) {
            const auto& [entity, parameters] = r.vertices.places[v];
            const VertexPlace place = r.mesh.states[v].place;
            if (place == VertexPlace::corner || surface.kind == GeometryKind::none) continue;
            if (place == VertexPlace::surface) CHECK(entity == surface);
            if (place == VertexPlace::line) CHECK(entity.kind != GeometryKind::none);
            counts.on_surfaces += place == VertexPlace::surface ? 1 : 0;
            counts.on_curves += place == VertexPlace::line ? 1 : 0;
            if (!parameters) continue;
            ++counts.with_parameters;
            const auto evaluated = geometry->evaluate(entity, *parameters);
            REQUIRE(evaluated);
            CHECK(distance(evaluated->point, r.mesh.points[v]) < 1e-9);
        }
    }
    return counts;
}

template <int D>
AdaptationGoal<D> goal_on(const NamedDomain<D>& domain, double size, const Geometry<D>& geometry) {
    Dice dice(5);
    AdaptationGoal<D> goal = goal_over(domain.mesh, size, dice);
    goal.geometry = geometry;
    return goal;
}

template <int D>
void expect_on_analytic_ball(int cells, double size) {
    const NamedDomain<D> domain = ball_in_box<D>(cells);
    const Geometry<D> geometry(domain.surfaces);
    const Adaptation<D> r = remeshed(domain, goal_on(domain, size, geometry));
    const Counts counts = expect_places(r, geometry);
    CHECK(counts.on_surfaces > 50);
    CHECK(counts.with_parameters == counts.on_surfaces);
}

}  // namespace

TEST_CASE("vertices on analytic surfaces store their entity and parameters") {
    expect_on_analytic_ball<2>(8, 0.12);
    expect_on_analytic_ball<3>(4, 0.6);
}

TEST_CASE("vertices of a ridge store both of its faces") {
    const NamedDomain<3> domain = quarter_shell<3>(4);
    const Geometry<3> geometry(domain.surfaces);
    const Adaptation<3> r = remeshed(domain, goal_on(domain, 0.6 * domain.cell, geometry));
    CHECK(expect_places(r, geometry).on_curves > 10);
    for (std::size_t l = 0; l < r.mesh.lines.size(); ++l) {
        if (r.mesh.is_free(LineId(l))) continue;
        for (const VertexId v : r.mesh.edges[r.mesh.lines[l]])
            if (const GeometryEntity& entity = r.vertices.places[v].entity; entity.kind == GeometryKind::curve)
                CHECK(entity.sides[0] != entity.sides[1]);
    }
}

TEST_CASE("vertices on a surrogate store parameters on its patches and curves") {
    const NamedDomain<3> domain = quarter_shell<3>(4);
    const auto edges = must(unique_edges(domain.mesh, one_thread));
    const Geometry<3> geometry(
        must(build_surrogate(domain.mesh, edges, features_of(domain, edges), SurrogateOptions{}, one_thread)));
    const Adaptation<3> r = remeshed(domain, goal_on(domain, 0.6 * domain.cell, geometry));
    const Counts counts = expect_places(r, geometry);
    CHECK(counts.on_surfaces > 50);
    CHECK(counts.on_curves > 10);
    CHECK(counts.with_parameters > 0.9 * static_cast<double>(counts.on_surfaces + counts.on_curves));
}
