// The cavity operator of degree 2 on curved meshes: elements stay valid, curves are preserved, and the number of
// threads has no effect.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "bowed.hpp"
#include "dice.hpp"
#include "goals.hpp"
#include "meshes.hpp"
#include "named_domains.hpp"
#include "sanitized.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.shapes;
import camber.validity;
import camber.crossing;
import camber.operation;
import camber.adapt;

#include "exact_oracle.hpp"

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
bool is_valid(const QuadraticMesh<D>& mesh) {
    return must(validate(mesh, 0, one_thread)).all_valid();
}

/// Nodes of the ball are on it. Inner nodes are displaced by up to `bow` chords, as far as elements stay valid.
template <int D>
QuadraticMesh<D> bowed(const NamedDomain<D>& domain, double bow, std::uint64_t seed) {
    Dice dice(seed);
    QuadraticMesh<D> mesh = must(elevate(domain.mesh, one_thread));
    const auto features =
        must(find_features(domain.mesh, mesh.edges, FeatureOptions<D>{.ridge_angle_degrees = 75}, one_thread));
    Buffer<LagrangeNode<D>> nodes(mesh.mid_nodes.begin(), mesh.mid_nodes.end());
    const Geometry<D> geometry(domain.surfaces);
    const auto boundary = must(boundary_nodes(mesh, features, geometry, one_thread));
    const auto shells_of = must(shells(mesh.edges, one_thread));
    for (std::size_t e = 0; e < nodes.size(); ++e)
        if (features.edge_kinds[e] != EdgeKind::volume) nodes[e] = boundary[e];
    mesh.mid_nodes = Buffer<LagrangeNode<D>>(nodes.begin(), nodes.end());
    REQUIRE(is_valid(mesh));
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        if (features.edge_kinds[e] != EdgeKind::volume) continue;
        const auto& [a, b] = mesh.edges.vertices[e];
        const double length = distance(mesh.linear.points[a], mesh.linear.points[b]);
        const LagrangeNode<D> straight = nodes[e];
        Vec<D> direction;
        for (double& x : direction.c) x = dice.uniform(-1, 1);
        for (double share = bow; share > 0.01; share /= 2) {
            nodes[e].point = straight.point + share * length / norm(direction) * direction;
            const bool fits = std::ranges::all_of(shells_of[EdgeId(e)], [&](ElementId s) {
                return decide(nodal_element<D>(mesh, nodes, s), 0.2) == Verdict::valid;
            });
            if (fits) break;
            nodes[e] = straight;
        }
    }
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

template <int D>
Adaptation<D> curved_state(const QuadraticMesh<D>& mesh, const AdaptationGoal<D>& goal, double ridge_angle) {
    const auto features =
        must(find_features(mesh.linear, mesh.edges, FeatureOptions<D>{.ridge_angle_degrees = ridge_angle}, one_thread));
    std::vector<VertexId> corners;
    for (std::size_t v = 0; v < mesh.linear.points.size(); ++v)
        if (features.vertex_kinds[v] == VertexKind::corner) corners.emplace_back(v);
    return must(begin_adaptation(mesh, {features.edge_kinds.view(), corners}, goal, one_thread));
}

template <int D>
QuadraticMesh<D> mesh_of_state(const Adaptation<D>& r) {
    auto compact = must(finished(r, one_thread)).compact;
    return {std::move(compact.mesh), std::move(compact.edges), std::move(compact.nodes)};
}

/// The number of invalid elements by exact arithmetic that shares no code with the certificate. Undecided elements
/// count as valid.
template <int D>
std::size_t exactly_invalid(const QuadraticMesh<D>& mesh, std::size_t step) {
    std::size_t count = 0;
    for (std::size_t e = 0; e < mesh.linear.elements.size(); e += step) {
        const auto found = oracle::answer<D>(nodal_element<D>(mesh, mesh.mid_nodes.view(), ElementId(e)), 0);
        count += found == oracle::Answer::invalid ? 1 : 0;
    }
    return count;
}

template <int D>
AdaptationGoal<D> curved_goal(const NamedDomain<D>& domain, double size, double anisotropy) {
    Buffer<LogMetric<D>> logs(domain.mesh.points.size());
    Vec<D> sizes;
    for (int i = 0; i < D; ++i) sizes[i] = size * domain.cell;
    sizes[0] /= anisotropy;
    for (auto& log : logs) log = log_metric_of_sizes<D>(sizes);
    AdaptationGoal<D> goal{must(make_back_mesh(domain.mesh, must(balls(domain.mesh, one_thread)),
                                               Column<LogMetric<D>>(std::move(logs)), one_thread)),
                           {}};
    goal.geometry = Geometry<D>(domain.surfaces);
    return goal;
}

/// A shell between two spheres. In a lattice ball some elements have two facets on the sphere and cannot be curved.
NamedDomain<3> sphere_shell() {
    ShellOptions<3> options;
    options.inner_radius = 1;
    options.outer_radius = 2;
    options.inner_size = options.outer_size = 0.5;
    return {"shell", must(generate(options)), {{{1, Sphere<3>{{}, 2}}, {2, Sphere<3>{{}, 1}}}}, {}, 0.5, 75};
}

/// The largest distance of a boundary vertex or node from its surface.
template <int D>
double off_surfaces(const QuadraticMesh<D>& mesh, const Geometry<D>& geometry) {
    double most = 0;
    const auto look = [&](Reference reference, const Vec<D>& p) {
        SurfaceHint hint;
        hint.reference = reference;
        const auto found = geometry->project(hint, p);
        if (found.entity.kind != GeometryKind::none) most = std::max(most, found.distance);
    };
    for (std::size_t f = 0; f < mesh.linear.facets.size(); ++f) {
        const Reference reference = mesh.linear.facets.references[f];
        for (const EdgeId e : mesh.edges.of_facets[f]) look(reference, mesh.mid_nodes[e].point);
        for (const VertexId v : mesh.linear.facets.vertices[f]) look(reference, mesh.linear.points[v]);
    }
    return most;
}

/// Coarsens and refines in turn. After each pass all elements are valid and the mesh is consistent.
template <int D>
void expect_valid_passes(const NamedDomain<D>& domain, double bow, double anisotropy,
                         std::array<std::size_t, 4> minimum) {
    const QuadraticMesh<D> mesh = bowed(domain, bow, 5);
    std::array<std::size_t, 4> accepted{};
    std::optional<Adaptation<D>> r;
    for (const double size : {1.5, 0.8, 1.2}) {
        const AdaptationGoal<D> goal = curved_goal<D>(domain, size, anisotropy);
        r = r ? curved_state(mesh_of_state(*r), goal, 180) : curved_state(mesh, goal, domain.ridge_angle_degrees);
        const auto pass = [&](std::size_t kind, Outcome<Adapted<D>> result) {
            auto remeshed = must(std::move(result));
            r = std::move(remeshed.state);
            accepted[kind] += remeshed.statistics.accepted;
            must(check_consistency(r->mesh, one_thread));
            CHECK(is_valid(mesh_of_state(*r)));
        };
        pass(0, collapse<D>(std::move(*r), goal, {}, one_thread));
        pass(1, split<D>(std::move(*r), goal, {}, one_thread));
        pass(2, swap<D>(std::move(*r), goal, {}, one_thread));
        pass(3, smooth<D>(std::move(*r), goal, {}, one_thread));
        CHECK(exactly_invalid(mesh_of_state(*r), D == 2 ? 1 : 37) == 0);
    }
    for (std::size_t kind = 0; kind < 4; ++kind) CHECK(accepted[kind] >= minimum[kind]);
    CHECK(off_surfaces(mesh_of_state(*r), Geometry<D>(domain.surfaces)) < 1e-12);
}

}  // namespace

TEST_CASE("each pass keeps a curved mesh valid and its boundary on the geometry, 2D") {
    if (!is_sanitized) expect_valid_passes<2>(ball_in_box<2>(8), 0.08, 1, {20, 20, 3, 20});
    expect_valid_passes<2>(ball_in_box<2>(8), 0.08, 20, {5, 100, 10, 20});
}

TEST_CASE("each pass keeps a curved mesh valid and its boundary on the geometry, 3D" * doctest::skip(is_sanitized)) {
    expect_valid_passes<3>(sphere_shell(), 0.06, 1, {50, 50, 50, 50});
    expect_valid_passes<3>(sphere_shell(), 0.06, 4, {50, 50, 50, 50});
}

TEST_CASE("without a geometry a split preserves the curved facets of the boundary") {
    const NamedDomain<3> domain = sphere_shell();
    const QuadraticMesh<3> mesh = bowed(domain, 0.06, 3);
    AdaptationGoal<3> goal = curved_goal<3>(domain, 1, 1);
    goal.geometry.reset();
    const Adaptation<3> r = curved_state(mesh, goal, domain.ridge_angle_degrees);
    OperationWorkspace<3> workspace;
    JudgedPatch<3> patch;
    std::size_t planned = 0;
    for (std::size_t f = 0; f < mesh.linear.facets.size(); f += 3) {
        const EdgeId edge = mesh.edges.of_facets[f][0];
        const auto& [a, b] = r.mesh.edges[edge];
        CavityRequest<3> request;
        ElementId element = r.mesh.sides[f][0];
        int local = 0;
        for (int k = 0; k < 6; ++k)
            if (r.mesh.edges_of[element][k] == edge) local = k;
        cavity_of_edge(r.mesh, element, local, request.cavity);
        const double t = 0.4;
        request.origin = (1 - t) * r.mesh.points[a] + t * r.mesh.points[b];
        request.place = QuadraticEdge<3>{r.mesh.points[a], r.mesh.nodes[edge], r.mesh.points[b]}.point(t);
        request.halves = {a, b};
        request.metric = r.vertices.metrics[a];
        if (operate(r, goal, request, {.corrections = 0}, workspace, patch).rejected != RejectionReason::none) continue;
        ++planned;
        const auto changed = must(replace_cavities<3>(r.mesh, {&patch.patch(), 1}));
        const VertexId point = changed.changes.points[0];
        const auto compact = must(compacted(changed.mesh, one_thread));
        // Each new facet is a part of an old one. Both are quadratic: it suffices that the middles of edges and the
        // centre agree.
        for (const FacetId g : changed.changes.facets.created) {
            const auto& corners = changed.mesh.facets.vertices[g];
            if (local_vertex(corners, point) < 0) continue;
            const FacetId to = compact.maps.facets[g];
            const auto new_facet = facet_of(QuadraticMesh<3>{compact.mesh, compact.edges, compact.nodes}, to);
            double nearest = 1e9;
            for (const FacetId old : request.cavity.facets) {
                const auto old_facet = facet_of(mesh, old);
                const auto& vertices = mesh.linear.facets.vertices[old];
                std::array<Barycentric<2>, 3> at{};
                bool is_part = true;
                for (int i = 0; i < 3; ++i) {
                    if (corners[i] == point) {
                        at[i][local_vertex(vertices, a)] = 1 - t;
                        at[i][local_vertex(vertices, b)] = t;
                    } else if (const int k = local_vertex(vertices, corners[i]); k >= 0) {
                        at[i][k] = 1;
                    } else {
                        is_part = false;
                    }
                }
                if (!is_part) continue;
                double most = 0;
                for (const Barycentric<2>& xi : {Barycentric<2>{0.5, 0.5, 0}, Barycentric<2>{0, 0.5, 0.5},
                                                 Barycentric<2>{0.5, 0, 0.5}, Barycentric<2>{0.2, 0.3, 0.5}}) {
                    Barycentric<2> in_old{};
                    for (int i = 0; i < 3; ++i)
                        for (int k = 0; k < 3; ++k) in_old[k] += xi[i] * at[i][k];
                    most = std::max(most, distance(new_facet.point(xi), old_facet.point(in_old)));
                }
                nearest = std::min(nearest, most);
            }
            CHECK(nearest < 1e-13);
        }
    }
    CHECK(planned > 20);
}

TEST_CASE("curved walls do not cross when boundary nodes are projected towards each other") {
    // Two squares side by side. The facing side of the first is projected onto an arc that reaches into the second.
    LatticeOptions<2> options;
    options.cells = {3, 3};
    const auto one = with_facets<2>(
        lattice_mesh(options), [](const auto&) { return 1; },
        [](const std::array<Vec<2>, 2>& face, const Vec<2>& within, FaceKind kind) {
            return kind == FaceKind::boundary ? side_of_box<2>(face, within) : 0;
        });
    const std::size_t n = one.points.size();
    Buffer<Vec<2>> points(one.points.begin(), one.points.end());
    Buffer<SimplexVertices<2>> elements(one.elements.vertices.begin(), one.elements.vertices.end());
    Buffer<SimplexVertices<1>> facets(one.facets.vertices.begin(), one.facets.vertices.end());
    Buffer<Reference> references(one.facets.references.begin(), one.facets.references.end());
    for (const Vec<2>& p : one.points) points.push_back(p + Vec<2>{{3.1, 0}});
    for (const auto& [a, b, c] : one.elements.vertices)
        elements.push_back({VertexId(a.index() + n), VertexId(b.index() + n), VertexId(c.index() + n)});
    for (std::size_t f = 0; f < one.facets.size(); ++f) {
        const auto& [a, b] = one.facets.vertices[f];
        facets.push_back({VertexId(a.index() + n), VertexId(b.index() + n)});
        references.push_back(one.facets.references[f] + 10);
    }
    const std::size_t m = elements.size();
    LinearMesh<2> both = mesh_of<2>(std::move(points), std::move(elements));
    both.facets = {std::move(facets), std::move(references), {}};
    both.elements.references = Buffer<Reference>(m, 1);
    both.point_references = Buffer<Reference>(2 * n, 0);
    const double radius = 3.0125;  // the arc bulges by 0.4
    const NamedDomain<2> domain{"two squares", both, {{{2, Sphere<2>{{{3.4 - radius, 1.5}}, radius}}}}, {}, 1, 75};
    const AdaptationGoal<2> goal = curved_goal<2>(domain, 0.6, 1);
    Adaptation<2> r = curved_state(must(elevate(both, one_thread)), goal, domain.ridge_angle_degrees);
    auto split_up = must(split<2>(std::move(r), goal, {}, one_thread));
    auto result = must(smooth<2>(std::move(split_up.state), goal, {}, one_thread));
    CHECK(split_up.statistics.of(RejectionReason::crossing) + result.statistics.of(RejectionReason::crossing) +
              split_up.statistics.shortened + result.statistics.shortened >
          0);
    const QuadraticMesh<2> mesh = mesh_of_state(result.state);
    CHECK(is_valid(mesh));
    CHECK(must(find_crossings(mesh, one_thread)).all_disjoint());
    CHECK(mesh.linear.points.size() > 2 * n);
}

TEST_CASE("edges bent by a candidate are the same as those bent by the operator") {
    const NamedDomain<3> domain = ball_in_box<3>(4);
    AdaptationGoal<3> goal = curved_goal<3>(domain, 1, 4);
    Buffer<LogMetric<3>> logs(domain.mesh.points.size());
    for (std::size_t v = 0; v < logs.size(); ++v) {
        const Vec<3>& p = domain.mesh.points[v];
        logs[v] = log_metric_of_sizes<3>((0.4 + 0.1 * p[1]) * domain.cell * Vec<3>{{0.2 + 0.05 * p[0], 1, 0.5}});
    }
    goal.field = must(make_back_mesh(domain.mesh, must(balls(domain.mesh, one_thread)),
                                     Column<LogMetric<3>>(std::move(logs)), one_thread));
    const Adaptation<3> r = curved_state(must(elevate(domain.mesh, one_thread)), goal, domain.ridge_angle_degrees);
    OperationWorkspace<3> workspace;
    JudgedPatch<3> first_patch, second_patch;
    std::size_t planned = 0, corrections = 0;
    for (std::size_t e = 0; e < r.mesh.elements.size(); e += 5) {
        CavityRequest<3> request;
        cavity_of_edge(r.mesh, ElementId(e), static_cast<int>(e % 6), request.cavity);
        if (!request.cavity.facets.empty()) continue;
        const auto& [a, b] = r.mesh.edges[r.mesh.edges_of[ElementId(e)][e % 6]];
        request.place = midpoint(r.mesh.points[a], r.mesh.points[b]);
        request.halves = {a, b};
        request.fixed_element_count = request.cavity.elements.size();
        sample_field(r, goal, {}, request);
        BentSpokes<3> spokes(r, goal);
        spokes.begin({request.place, &request.metric, &request.gradient});
        for (const VertexId v : r.mesh.elements.vertices[ElementId(e)])
            spokes.add(v, r.mesh.points[v], r.vertices.metrics[v]);
        spokes.bend();
        grow_delaunay(r, spokes, 64, 0.1, request.cavity);
        const PatchLimits limits{.min_shape = 0.1, .shortest = 0.2, .corrections = 16};
        const OperationResult first = operate(r, goal, request, limits, workspace, first_patch);
        spokes.set_edges(request);
        REQUIRE(!request.bent.empty());
        const OperationResult second = operate(r, goal, request, limits, workspace, second_patch);
        REQUIRE(first.rejected == second.rejected);
        REQUIRE(first.corrections == second.corrections);
        corrections += static_cast<std::size_t>(first.corrections);
        if (first.rejected != RejectionReason::none) continue;
        ++planned;
        CHECK(first_patch.patch().removed.elements == second_patch.patch().removed.elements);
        CHECK(first_patch.patch().nodes == second_patch.patch().nodes);
        CHECK(std::ranges::equal(first_patch.lengths(), second_patch.lengths()));
        CHECK(std::ranges::equal(first_patch.shapes(), second_patch.shapes()));
    }
    CHECK(planned > 20);
    CHECK(corrections > 0);
}

TEST_CASE("plane walls of a box and of a baffle do not cross after remeshing of a curved mesh") {
    const NamedDomain<3> domain = baffle_in_box<3>(4);
    const AdaptationGoal<3> goal = curved_goal<3>(domain, 0.7, 2);
    const auto expect_disjoint = [&](const QuadraticMesh<3>& from) {
        auto r = curved_state(from, goal, domain.ridge_angle_degrees);
        const auto result = must(remesh_to_metric(std::move(r), goal, ToMetricOptions{}, one_thread));
        const QuadraticMesh<3> mesh = mesh_of_state(result.state);
        CHECK(is_valid(mesh));
        CHECK(must(find_crossings(mesh, one_thread)).all_disjoint());
        CHECK(mesh.linear.facets.size() > domain.mesh.facets.size());
    };
    const QuadraticMesh<3> straight = must(elevate(domain.mesh, one_thread));
    expect_disjoint(straight);
    auto r = curved_state(straight, goal, domain.ridge_angle_degrees);
    Dice dice(5);
    bow<3>(r, Vec<3>{{1, 1, 1}}, dice);  // in the planes of the walls
    expect_disjoint(mesh_of_state(r));
}

TEST_CASE("facets on both sides of a straight ridge are not rejected as crossing") {
    // Thin facets, oblique to the ridges.
    const NamedDomain<3> domain = baffle_in_box<3>(4);
    AdaptationGoal<3> goal = curved_goal<3>(domain, 1, 2);
    Mat<3> axes;
    axes.column = {Vec<3>{{0.6, 0.8, 0}}, Vec<3>{{-0.8, 0.6, 0}}, Vec<3>{{0, 0, 1}}};
    Buffer<LogMetric<3>> logs(domain.mesh.points.size(),
                              log_metric_of_sizes<3>(domain.cell * Vec<3>{{0.02, 2, 2}}, axes));
    goal.field = must(make_back_mesh(domain.mesh, must(balls(domain.mesh, one_thread)),
                                     Column<LogMetric<3>>(std::move(logs)), one_thread));
    auto r = curved_state(must(elevate(domain.mesh, one_thread)), goal, domain.ridge_angle_degrees);
    Dice dice(5);
    bow<3>(r, Vec<3>{{1, 1, 1}}, dice);  // in the planes of the walls
    auto divided = must(split<3>(std::move(r), goal, {}, one_thread));
    const auto moved = must(smooth<3>(std::move(divided.state), goal, {}, one_thread));
    CHECK(divided.statistics.accepted > 100);
    CHECK(divided.statistics.of(RejectionReason::crossing) + moved.statistics.of(RejectionReason::crossing) == 0);
    CHECK(is_valid(mesh_of_state(moved.state)));
    CHECK(must(find_crossings(mesh_of_state(moved.state), one_thread)).crossing == 0);
}

TEST_CASE("remeshing of a curved mesh does not depend on the number of threads" * doctest::skip(is_sanitized)) {
    const auto expect_same = []<int D>(const NamedDomain<D>& domain, double bow, double size, double anisotropy) {
        const QuadraticMesh<D> mesh = bowed(domain, bow, 9);
        const AdaptationGoal<D> goal = curved_goal<D>(domain, size, anisotropy);
        const auto by = [&](int threads) {
            auto r = curved_state(mesh, goal, domain.ridge_angle_degrees);
            return mesh_of_state(
                must(remesh_to_metric<D>(std::move(r), goal, {.rounds = 2}, Execution{.threads = threads})).state);
        };
        CHECK(by(1) == by(3));
    };
    expect_same(ball_in_box<2>(16), 0.08, 0.7, 3);
    expect_same(sphere_shell(), 0.06, 0.9, 2);
}
