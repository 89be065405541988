module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import :in_plane;
import :parts;

namespace camber {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

Vec<3> raised(const CadParts& parts, const Vec<2>& p) { return {{p[0], p[1], parts.of_edges.low[2]}}; }

/// To the right of a tangent: out of the domain where the curve runs around it counterclockwise.
Vec<2> normal_to(const Vec<2>& tangent) {
    return norm(tangent) > 0 ? normalised(Vec<2>{{tangent[1], -tangent[0]}}) : Vec<2>{};
}

/// Whether two edges have the same points, but for 1e-5 of their size.
bool coincide(const CadModel& model, std::size_t a, std::size_t b) {
    constexpr double same = 1e-5;
    constexpr int samples = 8;
    const CadParts& parts = model.parts();
    const double within = same * parts.edges[a].bounds.diagonal();
    if (distance(parts.edges[a].bounds.low, parts.edges[b].bounds.low) > within ||
        distance(parts.edges[a].bounds.high, parts.edges[b].bounds.high) > within)
        return false;
    const occ::EdgeFacts& facts = parts.kernel->edges[b];
    for (int i = 0; i <= samples; ++i) {
        const double t = facts.first + (facts.last - facts.first) * i / samples;
        if (closest_on_edge(model, a, vec(parts.kernel->on_curve(b, t).point)).distance > within) return false;
    }
    return true;
}

/// The largest distance of the ends, that of the middle, and the sine of the angle between the tangents by the length.
double misfit(const CadModel& model, std::size_t edge, const std::array<Vec<2>, 2>& ends) {
    const Vec<2> chord = ends[1] - ends[0];
    const CadCurveFoot foot = closest_on_curve(model, edge, midpoint(ends[0], ends[1]));
    return foot.distance + std::abs(dot(chord, foot.normal)) +
           std::max(closest_on_curve(model, edge, ends[0]).distance, closest_on_curve(model, edge, ends[1]).distance);
}

/// Whether an edge begins where it ends, in another direction.
bool has_kink(const occ::Kernel& kernel, std::size_t edge) {
    constexpr double min_sine = 1e-3;
    const occ::EdgeFacts& facts = kernel.edges[edge];
    if (facts.vertices.size() != 1) return false;
    const Vec<3> first = vec(kernel.on_curve(edge, facts.first).first);
    const Vec<3> last = vec(kernel.on_curve(edge, facts.last).first);
    return dot(first, last) < 0 || norm(cross(first, last)) > min_sine * norm(first) * norm(last);
}

}  // namespace

Outcome<Done> check_flatness(const CadModel& model) {
    constexpr double flat = 1e-7;  // of the size, as OpenCASCADE's own tolerance
    const CadParts& parts = model.parts();
    if (parts.edges.empty())
        return fail(ErrorKind::input, "the model has no edges to put a mesh in 2D onto", {}, {},
                    "export its curves, or the plane faces that they bound");
    Box<3> box = parts.bounds;
    box.include(parts.of_edges);
    if (box.high[2] - box.low[2] <= flat * box.diagonal()) return Done{};
    std::array<char, 128> heights{};
    std::snprintf(heights.data(), heights.size(), "from z = %.5g to %.5g", box.low[2], box.high[2]);
    return fail(ErrorKind::input,
                "the CAD model reaches " + std::string(heights.data()) +
                    ", the mesh is in 2D: its curves must be in one plane z = constant",
                {}, {}, "export the plane faces or the curves of the section that was meshed, in the plane x, y");
}

std::vector<std::size_t> curves_of(const CadModel& model) {
    std::vector<std::size_t> curves;
    curves.reserve(model.edges());
    for (std::size_t e = 0; e < model.edges(); ++e)
        if (std::none_of(curves.begin(), curves.end(), [&](std::size_t known) { return coincide(model, known, e); }))
            curves.push_back(e);
    return curves;
}

CadCurveFoot closest_on_curve(const CadModel& model, std::size_t edge, const Vec<2>& p) {
    const CadParts& parts = model.parts();
    const Vec<3> at = raised(parts, p);
    const CadFoot foot = closest_on_edge(model, edge, at);
    const double t = foot.parameters[0];
    const Vec<2> point = in_plane(foot.point), normal = point_on_curve(model, edge, t).normal;
    // Heights within the tolerance of the plane are none.
    const double away = distance(point, p);
    if (away <= 4 * rounding(parts, at)) return {p, normal, t, 0};
    return {point, normal, t, away};
}

EntityPoint<2> point_on_curve(const CadModel& model, std::size_t edge, double t) {
    const occ::CurveJet jet = model.parts().kernel->on_curve(edge, t);
    const Vec<2> tangent = in_plane(vec(jet.first));
    return {in_plane(vec(jet.point)), {tangent, {}}, normal_to(tangent)};
}

std::optional<std::size_t> nearest_curve(const CadModel& model, std::span<const std::size_t> edges, const Vec<2>& p) {
    std::optional<std::size_t> best;
    double least = infinite;
    const Vec<3> at = raised(model.parts(), p);
    for (const std::size_t edge : edges) {
        if (model.parts().edges[edge].reach.distance_squared(at) >= least * least) continue;
        const double here = closest_on_curve(model, edge, p).distance;
        if (here >= least) continue;
        least = here;
        best = edge;
    }
    return best;
}

CadFit best_curve(const CadModel& model, std::span<const std::size_t> edges, const std::array<Vec<2>, 2>& ends) {
    const Vec<3> middle = raised(model.parts(), midpoint(ends[0], ends[1]));
    CadFit best{edges.front(), infinite, infinite, infinite};
    const VirtualFaces& joined = model.parts().virtual_curves;
    for (const std::size_t edge : edges) {
        // What is worse than twice the best is told from it: how much worse is no matter.
        const double enough = doubt * best.misfit;
        if (model.parts().edges[edge].reach.distance_squared(middle) > enough * enough) continue;
        const double here = misfit(model, edge, ends);
        if (here < best.misfit) {
            best.second = best.misfit;
            if (!joined.are_joined(best.face, edge)) best.other = best.misfit;
            best.misfit = here;
            best.face = edge;
        } else {
            best.second = std::min(best.second, here);
            if (!joined.are_joined(best.face, edge)) best.other = std::min(best.other, here);
        }
    }
    return best;
}

std::optional<std::size_t> end_between(const CadModel& model, std::span<const std::size_t> edges, const Vec<2>& p) {
    std::optional<std::size_t> best;
    double least = infinite;
    const occ::Kernel& kernel = *model.parts().kernel;
    if (edges.size() == 1 && !has_kink(kernel, edges[0])) return best;
    for (const std::size_t edge : edges)
        for (const std::size_t vertex : kernel.edges[edge].vertices)
            if (const double d = distance(vertex_in_plane(model, vertex), p); d < least) {
                least = d;
                best = vertex;
            }
    return best;
}

Vec<2> vertex_in_plane(const CadModel& model, std::size_t vertex) { return in_plane(model.vertex(vertex)); }

}  // namespace camber
