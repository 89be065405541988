// Single cavity requests: each is accepted, or rejected with a reason and no change of the mesh.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <type_traits>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "dice.hpp"
#include "domains.hpp"
#include "goals.hpp"
#include "meshes.hpp"

import camber.core;
import camber.metric;
import camber.shapes;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;

using namespace camber;
using namespace camber::testing;

namespace {

/// Two by two by two cells in a metric of constant size.
struct Fixture {
    LinearMesh<3> mesh = [] {
        LatticeOptions<3> options;
        options.cells = {2, 2, 2};
        return with_references<3>(lattice_mesh(options), options.cells, false);
    }();
    Dice dice{1};
    AdaptationGoal<3> goal = goal_over(mesh, 1, dice);
    Adaptation<3> r = start_adaptation(mesh, goal);
    OperationWorkspace<3> workspace;
    JudgedPatch<3> patch;

    VertexId at(const Vec<3>& p) const {
        for (std::size_t v = 0; v < mesh.points.size(); ++v)
            if (mesh.points[v] == p) return VertexId(v);
        return {};
    }
    CavityRequest<3> collapse_of(VertexId v, VertexId into) const {
        CavityRequest<3> request;
        cavity_of_vertex(r.mesh, v, request.cavity);
        request.join_to(r, into);
        return request;
    }
    OperationResult planned(const CavityRequest<3>& request, const PatchLimits& limits = {}) {
        return operate(r, goal, request, limits, workspace, patch);
    }
};

/// Facets of the first state that the second one does not have, compared by their vertices.
std::vector<FacetId> facets_of_one(const Adaptation<3>& one, const Adaptation<3>& other) {
    const auto facets = [](const Adaptation<3>& r) {
        std::map<std::array<VertexId, 3>, FacetId> all;
        for (std::size_t f = 0; f < r.mesh.facets.size(); ++f) {
            if (r.mesh.is_free(FacetId(f))) continue;
            std::array<VertexId, 3> vertices{r.mesh.facets.vertices[f][0], r.mesh.facets.vertices[f][1],
                                             r.mesh.facets.vertices[f][2]};
            std::ranges::sort(vertices);
            all.emplace(vertices, FacetId(f));
        }
        return all;
    };
    std::vector<FacetId> out;
    const auto others = facets(other);
    for (const auto& [vertices, f] : facets(one))
        if (!others.contains(vertices)) out.push_back(f);
    return out;
}

}  // namespace

TEST_CASE_FIXTURE(Fixture, "collapse along a line is accepted, and collapse of a corner is rejected") {
    const auto along = planned(collapse_of(at({{1, 0, 0}}), at({{0, 0, 0}})));
    // The interface ends on this line, so the vertex is a corner.
    CHECK(along.rejected == RejectionReason::required);
    CHECK(planned(collapse_of(at({{0, 1, 0}}), at({{0, 0, 0}}))).rejected == RejectionReason::none);
    CHECK(planned(collapse_of(at({{0, 0, 0}}), at({{0, 1, 0}}))).rejected == RejectionReason::required);
}

TEST_CASE_FIXTURE(Fixture, "the operator reports the reason of each rejection") {
    const CavityRequest<3> good = collapse_of(at({{0, 1, 0}}), at({{0, 0, 0}}));
    CHECK(planned(good, {.longest = 0.1}).rejected == RejectionReason::length);
    CHECK(planned(good, {.shortest = 100}).rejected == RejectionReason::length);
    CHECK(planned(good, {.min_shape = 0.999, .corrections = 0}).rejected == RejectionReason::quality);
    // Moving a vertex off its flat side would turn the facets.
    CavityRequest<3> move = collapse_of(at({{0, 1, 1}}), at({{0, 1, 1}}));
    move.place = {{0.9, 1, 1}};
    CHECK(planned(move).rejected == RejectionReason::geometry);
    // An inner vertex moved out of its ball.
    CavityRequest<3> out = collapse_of(at({{1, 1, 1}}), at({{1, 1, 1}}));
    out.place = {{3, 1, 1}};
    CHECK(planned(out, {.facet_cosine = -1, .corrections = 0}).rejected == RejectionReason::volume);
    CavityRequest<3> nothing;
    CHECK(planned(nothing).rejected == RejectionReason::empty);
    CHECK(check_consistency(r.mesh, one_thread).has_value());
}

TEST_CASE_FIXTURE(Fixture, "an element that is flat to rounding is rejected by its height") {
    // The middle vertex is moved almost into the plane of an opposite face.
    const VertexId middle = at({{1, 1, 1}});
    CavityRequest<3> move = collapse_of(middle, middle);
    move.place = {{1e-3, 1, 1}};
    // Much worse than the removed elements, which no limits allow.
    CHECK(planned(move, {.facet_cosine = -1, .corrections = 0}).rejected == RejectionReason::quality);
    move.place = {{1e-15, 1, 1}};
    CHECK(planned(move, {.facet_cosine = -1, .corrections = 0}).rejected == RejectionReason::height);
    move.place = {{0, 1, 1}};
    CHECK(planned(move, {.facet_cosine = -1, .corrections = 0}).rejected == RejectionReason::volume);
}

TEST_CASE("distance_from_geometry tells whether a patch is within the distance bound") {
    // Repeated collapses on the spheres of a shell exceed the distance bound in the end.
    ShellOptions<3> options;
    options.outer_radius = 2;
    options.inner_size = options.outer_size = 0.5;
    const LinearMesh<3> mesh = must(generate(options));
    AdaptationGoal<3> goal{
        must(make_back_mesh(mesh, must(balls(mesh, one_thread)),
                            Column<LogMetric<3>>(Buffer<LogMetric<3>>(mesh.points.size(), LogMetric<3>{})),
                            one_thread)),
        Geometry<3>(AnalyticGeometry<3>{{{1, Sphere<3>{{}, 2}}, {2, Sphere<3>{{}, 1}}}})};
    const Adaptation<3> r = start_adaptation(mesh, goal);
    OperationWorkspace<3> workspace;
    JudgedPatch<3> patch;
    std::size_t near = 0, far = 0;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        CavityRequest<3> request;
        cavity_of_vertex(r.mesh, VertexId(v), request.cavity);
        for (const FacetId f : request.cavity.facets)
            for (const VertexId w : r.mesh.facets.vertices[f]) {
                if (w == VertexId(v)) continue;
                request.join_to(r, w);
                if (operate(r, goal, request, {.facet_cosine = 0}, workspace, patch).rejected != RejectionReason::none)
                    continue;
                const FacetDistance facets = distance_from_geometry(r, goal, patch.patch(), 0.12);
                CHECK(facets.largest < 1);
                CHECK((facets.is_near || facets.largest > 0.12));
                (facets.is_near ? near : far) += 1;
                CHECK(distance_from_geometry(r, {goal.field, {}}, patch.patch(), 1e-9).is_near);
            }
    }
    CHECK(near > 10);
    CHECK(far > 10);
}

TEST_CASE("keeps_distance_bounds accepts patches that are no farther from the geometry than before") {
    // By definition, with the committed patch: no new facet exceeds its bound by more than a removed one.
    ShellOptions<3> options;
    options.outer_radius = 2;
    options.inner_size = options.outer_size = 0.5;
    const LinearMesh<3> straight = must(generate(options));
    const EdgeSet<3> edges = must(unique_edges(straight, one_thread));
    const auto surrogate =
        must(build_surrogate(straight, edges, must(find_features(straight, edges, {}, one_thread)), {}, one_thread));
    const AnalyticGeometry<3> spheres{{{1, Sphere<3>{{}, 2}}, {2, Sphere<3>{{}, 1}}}};
    LinearMesh<3> mesh = straight;  // every fifth vertex of the spheres is off them
    Buffer<Vec<3>> points(mesh.points.begin(), mesh.points.end());
    for (std::size_t f = 0; f < mesh.facets.size(); f += 5) {
        Vec<3>& p = points[mesh.facets.vertices[FacetId(f)][0].index()];
        if (std::abs(norm(p) - std::round(norm(p))) < 1e-9) p = 1.1 * p;
    }
    mesh.points = std::move(points);
    std::size_t within_bound = 0, farther = 0, no_farther = 0;
    for (const Geometry<3>& geometry : {Geometry<3>(spheres), Geometry<3>(surrogate)}) {
        AdaptationGoal<3> goal{
            must(make_back_mesh(straight, must(balls(straight, one_thread)),
                                Column<LogMetric<3>>(Buffer<LogMetric<3>>(straight.points.size(), LogMetric<3>{})),
                                one_thread)),
            geometry};
        const Adaptation<3> r = start_adaptation(mesh, goal);
        OperationWorkspace<3> workspace;
        JudgedPatch<3> patch;
        for (const double share : {0.02, 0.06, 0.09}) {
            const std::array bounds{DistanceBound{.references = {1}, .share = share},
                                    DistanceBound{.largest = 0.7 * share, .references = {2}}};
            AdaptationGoal<3> bounded = goal;
            bounded.distance_bounds = DistanceBounds(bounds);
            for (std::size_t v = 0; v < mesh.points.size(); ++v) {
                CavityRequest<3> request;
                cavity_of_vertex(r.mesh, VertexId(v), request.cavity);
                if (request.cavity.facets.empty()) continue;
                const FacetId f = request.cavity.facets.front();
                for (const VertexId w : r.mesh.facets.vertices[f]) {
                    if (w == VertexId(v)) continue;
                    request.join_to(r, w);
                    if (operate(r, goal, request, {.facet_cosine = 0}, workspace, patch).rejected !=
                        RejectionReason::none)
                        continue;
                    double before = 1;
                    for (const FacetId removed : patch.patch().removed.facets)
                        before = std::max(before, bound_shares(r, bounded, removed).largest());
                    double now = 1;
                    const Adaptation<3> after = must(commit(r, std::vector{patch})).state;
                    for (const FacetId created : facets_of_one(after, r))
                        now = std::max(now, bound_shares(after, bounded, created).largest());
                    if (now > 1 && std::abs(now - before) < 1e-9) continue;  // rounding decides
                    CHECK(meets_distance_bounds(r, bounded, patch.patch()) == (now <= before));
                    (now > before ? farther : now > 1 ? no_farther : within_bound) += 1;
                }
            }
        }
    }
    CHECK(within_bound > 10);
    CHECK(no_farther > 10);
    CHECK(farther > 10);
}

TEST_CASE_FIXTURE(Fixture, "an element that would be inverted is added to the cavity") {
    // A point outside an element, near one of its faces: the face is inverted as seen from the point.
    const ElementId e(3);
    CavityRequest<3> request;
    request.cavity.elements = {e};
    const auto corner = corners(mesh, e.index());
    bool corrected = false;
    for (int face = 0; face < 4 && !corrected; ++face) {
        const FaceNeighbour across = r.mesh.face_neighbours[e][face];
        if (!across.is_element()) continue;
        Vec<3> middle{};
        for (int i = 0; i < 4; ++i)
            if (i != face) middle += corner[i] / 3;
        request.place = middle + 0.05 * (middle - corner[face]);
        request.metric = r.vertices.metrics[0];
        CHECK(planned(request, {.corrections = 0}).rejected == RejectionReason::volume);
        const auto result = planned(request);
        CHECK(result.rejected == RejectionReason::none);
        CHECK(result.corrections == 1);
        CHECK(patch.patch().removed.elements == std::vector{e, across.element()});
        const auto changed = must(replace_cavities<3>(r.mesh, {&patch.patch(), 1})).mesh;
        CHECK(check_consistency(changed, one_thread).has_value());
        CHECK(changed.element_count() == mesh.elements.size() + 4);
        corrected = true;
    }
    CHECK(corrected);
}

TEST_CASE_FIXTURE(Fixture, "commit accepts only patches that the operator checked for the same state") {
    static_assert(!std::is_constructible_v<JudgedPatch<3>, Patch<3>>);
    static_assert(!std::is_assignable_v<JudgedPatch<3>, Patch<3>>);
    static_assert(!std::is_constructible_v<JudgedNode<3>, EdgeId, LagrangeNode<3>>);
    CavityRequest<3> request;
    request.cavity.elements = {ElementId(3)};
    for (const Vec<3>& p : corners(mesh, 3)) request.place += p / 4;
    request.metric = VertexMetric<3>(log_metric_of_sizes<3>({{0.5, 0.25, 0.125}}), ElementId(3));
    REQUIRE(planned(request).rejected == RejectionReason::none);
    auto [state, changes] = must(commit<3>(r, {patch}));
    CHECK(state.vertices.metrics.size() == state.mesh.points.size());
    CHECK(state.vertices.metrics[changes.points.front()] == request.metric);
    CHECK(state.mesh.element_count() == mesh.elements.size() + 3);
    CHECK(!commit<3>(state, {patch}).has_value());
}

TEST_CASE("moving an inner vertex preserves all numbers of elements and edges") {
    LatticeOptions<3> options;
    options.cells = {2, 2, 2};
    LinearMesh<3> mesh = with_references<3>(lattice_mesh(options), {0, 2, 2}, false);  // one material
    Dice dice(1);
    const AdaptationGoal<3> goal = goal_over(mesh, 1, dice);
    const Adaptation<3> r = start_adaptation(mesh, goal);
    CavityRequest<3> request;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        if (mesh.points[v] == Vec<3>{{1, 1, 1}}) request.join_to(r, VertexId(v));
    cavity_of_vertex(r.mesh, request.point, request.cavity);
    request.place += Vec<3>{{0.1, 0.05, 0}};
    OperationWorkspace<3> workspace;
    JudgedPatch<3> patch;
    REQUIRE(operate(r, goal, request, {}, workspace, patch).rejected == RejectionReason::none);
    CHECK(preserves_topology<3>(r.mesh.elements.vertices.view(), patch.patch()));
    const auto changed = must(replace_cavities<3>(r.mesh, {&patch.patch(), 1}));
    CHECK(check_consistency(changed.mesh, one_thread).has_value());
    CHECK(changed.mesh.elements.vertices == r.mesh.elements.vertices);
    CHECK(changed.mesh.face_neighbours == r.mesh.face_neighbours);
    CHECK(changed.mesh.edges == r.mesh.edges);
    CHECK(changed.mesh.points[request.point] == request.place);
    CHECK(changed.changes.elements.created == request.cavity.elements);
    CHECK(changed.changes.points == std::vector{request.point});
    // Joining the vertex to another one is a collapse.
    request.join_to(r, r.mesh.elements.vertices[request.cavity.elements[0]][0] == request.point
                           ? r.mesh.elements.vertices[request.cavity.elements[0]][1]
                           : r.mesh.elements.vertices[request.cavity.elements[0]][0]);
    if (operate(r, goal, request, {}, workspace, patch).rejected == RejectionReason::none)
        CHECK(!preserves_topology<3>(r.mesh.elements.vertices.view(), patch.patch()));
}

TEST_CASE_FIXTURE(Fixture, "moving a vertex requires the cavity of all its elements") {
    const VertexId middle = at({{1, 1, 1}});
    CavityRequest<3> part = collapse_of(middle, middle);
    part.place += Vec<3>{{0.1, 0.1, 0.1}};
    CHECK(planned(part).rejected == RejectionReason::none);
    part.cavity.elements.resize(part.cavity.elements.size() / 2);
    const auto rejected = planned(part).rejected;
    CHECK(rejected != RejectionReason::none);
}

TEST_CASE_FIXTURE(Fixture, "moving a corner is rejected") {
    CavityRequest<3> corner = collapse_of(at({{0, 0, 0}}), at({{0, 0, 0}}));
    corner.place += Vec<3>{{1e-3, 1e-3, 1e-3}};
    CHECK(planned(corner, {.facet_cosine = -1}).rejected == RejectionReason::required);
}

TEST_CASE("collapse is rejected at a corner of a curve that is not listed as a corner") {
    LatticeOptions<2> options;
    options.cells = {2, 2};
    LinearMesh<2> mesh = with_references<2>(lattice_mesh(options), options.cells, false);
    mesh.facets.references = Buffer<Reference>(mesh.facets.size(), 1);  // the corners are bends of one curve
    mesh.elements.references = Buffer<Reference>(mesh.elements.size(), 1);
    Buffer<SimplexVertices<1>> rim;
    for (const auto& f : mesh.facets.vertices) {
        const Vec<2> m = midpoint(mesh.points[f[0]], mesh.points[f[1]]);
        if (m[0] == 0 || m[0] == 2 || m[1] == 0 || m[1] == 2) rim.push_back(f);
    }
    const std::size_t n = rim.size();
    mesh.facets = {std::move(rim), Buffer<Reference>(n, 1), {}};
    Dice dice(1);
    const AdaptationGoal<2> goal = goal_over(mesh, 1, dice);
    const Adaptation<2> r = start_adaptation(mesh, goal);
    OperationWorkspace<2> workspace;
    JudgedPatch<2> patch;
    std::size_t tried = 0;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        const Vec<2>& p = mesh.points[v];
        if ((p[0] != 0 && p[0] != 2) || (p[1] != 0 && p[1] != 2)) continue;
        CavityRequest<2> request;
        cavity_of_vertex(r.mesh, VertexId(v), request.cavity);
        for (const FacetId f : request.cavity.facets)
            for (const VertexId w : r.mesh.facets.vertices[f]) {
                if (w == VertexId(v)) continue;
                request.join_to(r, w);
                ++tried;
                CHECK(operate(r, goal, request, {}, workspace, patch).rejected != RejectionReason::none);
            }
    }
    CHECK(tried == 8);  // two neighbours of each of the four corners
}
