// Embedded curves: listed edges in smooth faces or in the volume. Remeshing preserves their corners, lengths, positions
// and references.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "domains.hpp"
#include "meshes.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;

using namespace camber;
using namespace camber::testing;

namespace {

constexpr Reference square = 9, circle = 10, path = 8;

template <int D>
double square_radius(const Vec<D>& p) {
    return std::max(std::abs(p[0] - 4), std::abs(p[1] - 4));
}
/// Maps squares around the middle towards circles. Share 0 is the identity; share 1 makes a circle of radius 2.
template <int D>
Vec<D> rounded(Vec<D> p, double share) {
    const double m = square_radius(p);
    const double radius = std::hypot(p[0] - 4, p[1] - 4);
    if (!(radius > 0)) return p;
    const double by = 1 + share * std::min(m / 2, 2 - m / 2) * (m / radius - 1);
    p[0] = 4 + by * (p[0] - 4);
    p[1] = 4 + by * (p[1] - 4);
    return p;
}

/// Lists lattice edges of one cell length whose ends are both on a curve.
void list_edges(LinearMesh<3>& mesh, const std::function<Reference(const Vec<3>&, const Vec<3>&)>& reference_of) {
    const auto edges = must(unique_edges(mesh, one_thread));
    Buffer<SimplexVertices<1>> listed;
    Buffer<Reference> references;
    for (const auto& [a, b] : edges.vertices) {
        const Vec<3>& p = mesh.points[a];
        const Vec<3>& q = mesh.points[b];
        if (distance(p, q) != 1) continue;
        if (const Reference reference = reference_of(p, q); reference != 0) {
            listed.push_back({a, b});
            references.push_back(reference);
        }
    }
    mesh.edges = {std::move(listed), std::move(references), {}};
}
template <int D, class Place>
void move_points(LinearMesh<D>& mesh, Place&& place) {
    Buffer<Vec<D>> points(mesh.points.begin(), mesh.points.end());
    for (Vec<D>& p : points) p = place(p);
    mesh.points = std::move(points);
}
/// A lattice of one material whose boundary has one reference.
LinearMesh<3> block(const std::array<int, 3>& cells) {
    LatticeOptions<3> options;
    options.cells = cells;
    return with_facets<3>(
        lattice_mesh(options), [](const auto&) { return 1; },
        [](const auto&, const auto&, FaceKind kind) { return kind == FaceKind::boundary ? 1 : 0; });
}

/// A slab with a square on its top, a circle on its bottom, and an inner path with a corner and bends.
LinearMesh<3> slab() {
    LinearMesh<3> mesh = block({8, 8, 2});
    list_edges(mesh, [](const Vec<3>& p, const Vec<3>& q) -> Reference {
        const bool around = square_radius(p) == 2 && square_radius(q) == 2;
        if (around && p[2] == q[2] && p[2] != 1) return p[2] == 2 ? square : circle;
        const auto is_on_path = [](const Vec<3>& x) {
            return x[2] == 1 && ((x[1] == 4 && x[0] >= 2 && x[0] <= 6) || (x[0] == 6 && x[1] >= 4 && x[1] <= 6));
        };
        return is_on_path(p) && is_on_path(q) ? path : 0;
    });
    move_points(mesh, [](const Vec<3>& p) { return rounded(p, 1 - p[2] / 2); });
    return mesh;
}
/// A ball of radius 2 with a curve of four arcs of great circles, in the planes where z is half of |x| or |y|.
LinearMesh<3> ball() {
    LinearMesh<3> mesh = block({4, 4, 4});
    list_edges(mesh, [](const Vec<3>& p, const Vec<3>& q) -> Reference {
        const auto is_on = [](const Vec<3>& x) {
            return x[2] == 3 && std::max(std::abs(x[0] - 2), std::abs(x[1] - 2)) == 2;
        };
        return is_on(p) && is_on(q) ? square : 0;
    });
    move_points(mesh, [](const Vec<3>& p) {
        const Vec<3> x = p - Vec<3>{{2, 2, 2}};
        const double m = std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])});
        return m > 0 ? (m / norm(x)) * x : x;
    });
    return mesh;
}
/// A square of one material with a smaller square of facets inside, rounded by a share.
LinearMesh<2> sheet(double share) {
    LatticeOptions<2> options;
    options.cells = {8, 8};
    LinearMesh<2> mesh = with_facets<2>(
        lattice_mesh(options), [](const auto&) { return 1; },
        [](const auto& p, const auto&, FaceKind kind) -> Reference {
            if (kind == FaceKind::boundary) return 1;
            return square_radius(p[0]) == 2 && square_radius(p[1]) == 2 && distance(p[0], p[1]) == 1 ? square : 0;
        });
    move_points(mesh, [share](const Vec<2>& p) { return rounded(p, share); });
    return mesh;
}

/// The mesh after remeshing to a size, with nodes in degree 2.
template <int D>
CompactMesh<D> remeshed(const LinearMesh<D>& mesh, const std::optional<AnalyticGeometry<D>>& analytic, double size,
                        int degree, double min_quality = 0.1) {
    const auto edges = must(unique_edges(mesh, one_thread));
    const auto features = must(find_features(mesh, edges, FeatureOptions<D>{}, one_thread));
    const Geometry<D> geometry =
        analytic ? Geometry<D>(*analytic) : Geometry<D>(must(build_surrogate(mesh, edges, features, {}, one_thread)));
    const auto curves = must(find_embedded_curves(mesh, edges, features, geometry, {}, one_thread));
    std::vector<VertexId> corners(curves.corners.begin(), curves.corners.end());
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        if (features.vertex_kinds[v] == VertexKind::corner) corners.emplace_back(v);
    Vec<D> sizes;
    sizes.c.fill(size);
    Buffer<LogMetric<D>> logs(mesh.points.size(), log_metric_of_sizes<D>(sizes));
    // The tree over the curves agrees with a search through all of them.
    for (const auto& piece : curves.pieces) {
        const Vec<D> p = 0.5 * (piece.curve.control.front() + piece.curve.control.back());
        double nearest = std::numeric_limits<double>::infinity();
        for (const auto& other : curves.pieces)
            if (other.reference == piece.reference)
                nearest = std::min(nearest, closest_on(other.curve, p).distance_squared);
        const Vec<D> found = closest_on_curves(curves, piece.reference, p).value();
        CHECK(norm_squared(found - p) <= (1 + 1e-9) * nearest + 1e-24);
    }
    AdaptationGoal<D> goal{
        must(make_back_mesh(mesh, must(balls(mesh, one_thread)), Column<LogMetric<D>>(std::move(logs)), one_thread)),
        geometry};
    goal.curves = curves;
    const BreaksOfMesh breaks{features.edge_kinds.view(), corners};
    Adaptation<D> r;
    if (degree == 1) {
        r = must(begin_adaptation(mesh, edges, breaks, goal, one_thread));
    } else {
        QuadraticMesh<D> curved = must(elevate(mesh, one_thread));
        curved.mid_nodes = must(nodes_on_curves(curved, must(boundary_nodes(curved, features, geometry, one_thread)),
                                                curves, geometry, one_thread));
        goal.curves = must(find_embedded_curves(mesh, edges, features, geometry, curved.mid_nodes.view(), one_thread));
        r = must(begin_adaptation(curved, breaks, goal, one_thread));
    }
    const auto result = must(remesh_to_metric<D>(std::move(r), goal, {.rounds = 2}, one_thread));
    CHECK(result.statistics.after.worst_quality > min_quality);
    return must(finished(result.state, one_thread)).compact;
}

const Simplices<1>& curves_of(const LinearMesh<3>& mesh) { return mesh.edges; }
const Simplices<1>& curves_of(const LinearMesh<2>& mesh) { return mesh.facets; }
EdgeId edge_of(const EdgeSet<3>& edges, std::size_t row) { return edges.of_edges[row]; }
EdgeId edge_of(const EdgeSet<2>& edges, std::size_t row) { return edges.of_facets[row][0]; }

/// Length of the edges with a reference and their largest distance from their curve.
struct CurveDeviation {
    double length = 0, farthest = 0;
    std::size_t edges = 0;
};
template <int D>
CurveDeviation curve_deviation(const CompactMesh<D>& out, Reference reference,
                               const std::function<double(const Vec<D>&)>& distance_of) {
    CurveDeviation found;
    const auto& curves = curves_of(out.mesh);
    for (std::size_t i = 0; i < curves.size(); ++i) {
        if (curves.references[i] != reference) continue;
        const auto& [a, b] = curves.vertices[i];
        QuadraticEdge<D> edge = QuadraticEdge<D>::straight(out.mesh.points[a], out.mesh.points[b]);
        if (!out.nodes.empty()) edge.mid = out.nodes[edge_of(out.edges, i)];
        constexpr int parts = 16;
        for (int k = 0; k < parts; ++k) found.length += distance(edge.point(k / 16.0), edge.point((k + 1) / 16.0));
        for (const Vec<D>& p : {edge.p20, edge.p02}) found.farthest = std::max(found.farthest, distance_of(p));
        if (!out.nodes.empty()) found.farthest = std::max(found.farthest, 0.05 * distance_of(edge.mid.point));
        ++found.edges;
    }
    return found;
}
template <int D>
bool has_vertex(const LinearMesh<D>& mesh, const Vec<D>& p) {
    return std::ranges::any_of(mesh.points, [&](const Vec<D>& q) { return distance(p, q) < 1e-12; });
}

/// The vertex at the bottom of a block where baffles and lines end.
template <int D>
Vec<D> end_on_wall() {
    Vec<D> p;
    for (int i = 0; i + 1 < D; ++i) p[i] = 2;
    return p;
}
/// Lowers the first layer of a block of four cells and shifts its vertices: lattice edges leave the end vertex nearly
/// along the wall on both sides. A bow makes the bottom a part of a cylinder.
template <int D>
Vec<D> lowered(Vec<D> p, double bow) {
    if (p[D - 1] > 0) {
        p[D - 1] -= 0.85;
        if (p[0] > 0 && p[0] < 4) p[0] -= 0.5;
    }
    p[D - 1] += bow * (1 - p[D - 1] / 3.15) * (p[0] - 2) * (p[0] - 2);
    return p;
}

/// A baffle and lines that meet a wall or each other in one vertex, given by lattice positions.
template <int D>
struct Ending {
    const char* name;
    std::function<bool(const std::array<Vec<D>, D>&)> is_baffle = {};
    std::vector<std::vector<Vec<D>>> lines = {};  ///< polylines of lattice edges
    Vec<D> vertex = end_on_wall<D>();
};

/// A block whose sides have references, with a baffle of reference 30 and listed edges of reference 8.
template <int D>
LinearMesh<D> block_with(const Ending<D>& ending, double bow) {
    LatticeOptions<D> options;
    options.cells.fill(4);
    LinearMesh<D> mesh = with_facets<D>(
        lattice_mesh(options), [](const auto&) { return 1; },
        [&](const auto& face, const Vec<D>& within, FaceKind kind) -> Reference {
            if (kind == FaceKind::boundary) return side_of_box<D>(face, within);
            return ending.is_baffle && ending.is_baffle(face) ? 30 : 0;
        });
    if constexpr (D == 3) {
        Buffer<SimplexVertices<1>> listed;
        const auto vertex_at = [&](const Vec<3>& p) {
            return VertexId(std::ranges::find(mesh.points, p) - mesh.points.begin());
        };
        for (const auto& line : ending.lines)
            for (std::size_t i = 0; i + 1 < line.size(); ++i)
                listed.push_back({vertex_at(line[i]), vertex_at(line[i + 1])});
        Buffer<Reference> references(listed.size(), path);
        mesh.edges = {std::move(listed), std::move(references), {}};
    }
    move_points(mesh, [bow](const Vec<D>& p) { return lowered(p, bow); });
    return mesh;
}

/// Checks that the vertex still belongs to the baffle and the lines, that plane walls are exact, and that the bottom
/// and the volume are unchanged.
template <int D>
void expect_end_stays(const Ending<D>& ending, double bow, int degree, double size) {
    CAPTURE(ending.name);
    CAPTURE(bow);
    CAPTURE(degree);
    CAPTURE(size);
    const LinearMesh<D> mesh = block_with(ending, bow);
    const auto out = remeshed<D>(mesh, {}, size, degree, 0.01);
    const auto has_vertex_there = [&, at = lowered(ending.vertex, bow)](const auto& simplices, Reference reference) {
        for (std::size_t i = 0; i < simplices.size(); ++i)
            for (const VertexId v : simplices.vertices[i])
                if (simplices.references[i] == reference && out.mesh.points[v] == at) return true;
        return false;
    };
    if (ending.is_baffle) CHECK(has_vertex_there(out.mesh.facets, 30));
    if constexpr (D == 3)
        if (!ending.lines.empty()) CHECK(has_vertex_there(out.mesh.edges, path));
    double farthest = 0, off_bottom = 0;
    constexpr Reference bottom = 1 + 2 * (D - 1), top = bottom + 1;
    for (std::size_t f = 0; f < out.mesh.facets.size(); ++f) {
        const Reference r = out.mesh.facets.references[f];
        if (r == 30) continue;
        for (const VertexId v : out.mesh.facets.vertices[f]) {
            const Vec<D>& p = out.mesh.points[v];
            if (r == bottom)
                off_bottom = std::max(off_bottom, std::abs(p[D - 1] - bow * (p[0] - 2) * (p[0] - 2)));
            else
                // The top is at 4 less the 0.85 of `lowered`.
                farthest = std::max(farthest, std::abs(p[(r - 1) / 2] - (r == top ? 3.15 : r % 2 == 0 ? 4 : 0)));
        }
    }
    CHECK(farthest < 1e-12);
    CHECK(off_bottom < (bow == 0 ? 1e-12 : 0.02));
    double volume = 0, before = 0;
    for (std::size_t e = 0; e < out.mesh.elements.size(); ++e) volume += orientation(corners(out.mesh, e));
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) before += orientation(corners(mesh, e));
    if (bow == 0) CHECK(std::abs(volume - before) < 1e-11 * before);
}

}  // namespace

TEST_CASE("remeshing keeps vertices where baffles and lines meet walls or each other") {
    const auto all = [](const auto& places, auto&& is) { return std::ranges::all_of(places, is); };
    const auto is_tip = [](const std::array<Vec<3>, 3>& p) {
        return std::ranges::count(p, end_on_wall<3>()) == 1 &&
               std::ranges::count_if(p, [](const Vec<3>& q) { return q[2] == 0; }) == 1 &&
               std::ranges::all_of(p, [](const Vec<3>& q) { return q[1] == 2; });
    };
    const auto within = [](double low, double high) {
        return [=](const Vec<3>& q) { return q[1] == 2 && q[2] >= low && q[2] <= 3 && q[0] <= high && q[0] >= 1; };
    };
    const Vec<3> end = end_on_wall<3>();
    const std::vector<Vec<3>> up{end, {{2, 2, 1}}, {{2, 2, 2}}}, aside{end, {{3, 2, 1}}, {{3, 2, 2}}};
    const std::vector<Ending<3>> endings{
        {"the tip of a baffle", [=](const auto& p) { return is_tip(p) || all(p, within(1, 3)); }},
        {"a rim that leaves the wall",
         [=](const auto& p) { return is_tip(p) || all(p, within(0, 2)) || all(p, within(1, 3)); }},
        {.name = "the end of a line", .lines = {up}},
        {.name = "the middle of a line", .lines = {up, aside}},
        {.name = "a line that leaves the wall", .lines = {{{{1, 2, 0}}, end}, aside}},
        {"a line through a baffle",
         [=](const auto& p) {
             return all(p,
                        [](const Vec<3>& q) { return q[2] == 2 && std::abs(q[0] - 2) < 2 && std::abs(q[1] - 2) < 2; });
         },
         {{{{2, 2, 1}}, {{2, 2, 2}}, {{2, 2, 3}}}},
         {{2, 2, 2}}},
    };
    for (const auto& ending : endings)
        for (const double bow : {0.0, 0.1})
            for (const int degree : {1, 2}) expect_end_stays<3>(ending, bow, degree, degree == 1 ? 0.5 : 0.9);
    const Vec<2> end_2{{2, 0}};
    const auto is_side = [=](const std::array<Vec<2>, 2>& p, const Vec<2>& a, const Vec<2>& b) {
        return (p[0] == a && p[1] == b) || (p[0] == b && p[1] == a);
    };
    const std::vector<Ending<2>> in_plane{
        {"the end of a baffle", [=](const auto& p) { return is_side(p, end_2, {{2, 1}}); }},
        {"the middle of a baffle",
         [=](const auto& p) { return is_side(p, end_2, {{2, 1}}) || is_side(p, end_2, {{3, 1}}); }},
        {"a baffle that leaves the wall", [=](const auto& p) { return is_side(p, end_2, {{3, 1}}); }},
    };
    for (const auto& ending : in_plane)
        for (const double bow : {0.0, 0.1})
            for (const int degree : {1, 2})
                for (const double size : {0.4, 1.2}) expect_end_stays<2>(ending, bow, degree, size);
}

// Guards against curves in smooth faces that lose their corners and positions.
TEST_CASE("embedded curves on plane faces and in the volume keep corners, lengths and positions") {
    const LinearMesh<3> mesh = slab();
    const auto length_of_path = [&](const LinearMesh<3>& of) {
        double length = 0;
        for (std::size_t i = 0; i < of.edges.size(); ++i)
            if (of.edges.references[i] == path)
                length += distance(of.points[of.edges.vertices[i][0]], of.points[of.edges.vertices[i][1]]);
        return length;
    };
    for (const int degree : {1, 2}) {
        CAPTURE(degree);
        const auto out = remeshed<3>(mesh, {}, 0.7, degree);
        const CurveDeviation square_curve = curve_deviation<3>(
            out, square, [](const Vec<3>& p) { return std::max(std::abs(square_radius(p) - 2), std::abs(p[2] - 2)); });
        CHECK(square_curve.length == doctest::Approx(16).epsilon(1e-9));
        CHECK(square_curve.farthest < 1e-9);
        CHECK(square_curve.edges > 20);
        const CurveDeviation circle_curve = curve_deviation<3>(out, circle, [](const Vec<3>& p) {
            return std::max(std::abs(std::hypot(p[0] - 4, p[1] - 4) - 2), std::abs(p[2]));
        });
        CHECK(circle_curve.length == doctest::Approx(4 * std::numbers::pi).epsilon(degree == 1 ? 1e-2 : 1e-3));
        CHECK(circle_curve.farthest < 2e-3);
        CHECK(circle_curve.edges > 14);
        CHECK(length_of_path(out.mesh) == doctest::Approx(length_of_path(mesh)).epsilon(1e-9));
        for (std::size_t i = 0; i < mesh.edges.size(); ++i)
            if (mesh.edges.references[i] == path && mesh.points[mesh.edges.vertices[i][0]][0] > 5.5)
                CHECK(has_vertex(out.mesh, mesh.points[mesh.edges.vertices[i][0]]));
        for (const double x : {2, 6})
            for (const double y : {2, 6}) CHECK(has_vertex(out.mesh, Vec<3>{{x, y, 2}}));
    }
}

TEST_CASE("an embedded curve on a sphere stays on the sphere and keeps its corners") {
    const LinearMesh<3> mesh = ball();
    const double length = 4 * 2 * std::acos(1.0 / 9);  // four arcs of radius 2 between the corners 2/3 (±2, ±2, 1)
    for (const int degree : {1, 2}) {
        const auto out = remeshed<3>(mesh, AnalyticGeometry<3>{{{1, Sphere<3>{{}, 2}}}}, 0.7, degree);
        const CurveDeviation now = curve_deviation<3>(out, square, [](const Vec<3>& p) {
            const double across = p[2] - std::max(std::abs(p[0]), std::abs(p[1])) / 2;
            return std::max(std::abs(norm(p) - 2), std::abs(across));
        });
        CHECK(now.length == doctest::Approx(length).epsilon(degree == 1 ? 1e-2 : 2e-3));
        CHECK(now.farthest < 5e-3);
        CHECK(now.edges > 14);
        for (const double x : {-2, 2})
            for (const double y : {-2, 2}) CHECK(has_vertex(out.mesh, (2.0 / 3) * Vec<3>{{x, y, 1}}));
    }
}

TEST_CASE("embedded curves in a 2D mesh keep corners, lengths and positions") {
    for (const int degree : {1, 2}) {
        const auto straight = remeshed<2>(sheet(0), {}, 0.7, degree);
        const CurveDeviation square_curve =
            curve_deviation<2>(straight, square, [](const Vec<2>& p) { return std::abs(square_radius(p) - 2); });
        CHECK(square_curve.length == doctest::Approx(16).epsilon(1e-9));
        CHECK(square_curve.farthest < 1e-9);
        for (const double x : {2, 6})
            for (const double y : {2, 6}) CHECK(has_vertex(straight.mesh, Vec<2>{{x, y}}));
        const auto round = remeshed<2>(sheet(1), {}, 0.7, degree);
        const CurveDeviation circle_curve = curve_deviation<2>(
            round, square, [](const Vec<2>& p) { return std::abs(std::hypot(p[0] - 4, p[1] - 4) - 2); });
        CHECK(circle_curve.length == doctest::Approx(4 * std::numbers::pi).epsilon(degree == 1 ? 1e-2 : 1e-3));
        CHECK(circle_curve.farthest < 2e-3);
    }
}
