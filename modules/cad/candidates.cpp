module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import :parts;

namespace camber {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// The largest distance of the vertices, that of the middle, and the sine of the angle between the normals by the
/// facet's size; `enough`: where it is no matter how much more it is.
double misfit(const CadModel& model, std::size_t face, const std::array<Vec<3>, 3>& corners, double enough) {
    const Vec<3> middle = (corners[0] + corners[1] + corners[2]) / 3;
    const CadFoot foot = closest_on_face(model, face, middle);
    const Vec<3> normal = normalised(cross(corners[1] - corners[0], corners[2] - corners[0]));
    double sum = foot.distance + longest_side(corners) * norm(cross(normal, foot.normal));
    double farthest = 0;
    for (const Vec<3>& corner : corners) {
        if (sum + farthest > enough) return sum + farthest;
        farthest = std::max(farthest, closest_on_face(model, face, corner).distance);
    }
    return sum + farthest;
}

/// Whether two faces are one and the same where a facet is.
bool coincide(const CadModel& model, std::size_t a, std::size_t b, const std::array<Vec<3>, 3>& corners) {
    constexpr double same = 1e-6, parallel = 1e-3;
    const double most = same * longest_side(corners);
    const Vec<3> middle = (corners[0] + corners[1] + corners[2]) / 3;
    const CadFoot on_a = closest_on_face(model, a, middle), on_b = closest_on_face(model, b, middle);
    if (distance(on_a.point, on_b.point) > most || norm(cross(on_a.normal, on_b.normal)) > parallel) return false;
    return std::all_of(corners.begin(), corners.end(), [&](const Vec<3>& p) {
        return distance(closest_on_face(model, a, p).point, closest_on_face(model, b, p).point) <= most;
    });
}

double farthest_from(const CadModel& model, std::size_t edge, std::span<const Vec<3>> points) {
    double farthest = 0;
    for (const Vec<3>& p : points) farthest = std::max(farthest, closest_on_edge(model, edge, p).distance);
    return farthest;
}

bool bounds(const occ::EdgeFacts& edge, std::size_t face) {
    return std::find(edge.faces.begin(), edge.faces.end(), face) != edge.faces.end();
}

}  // namespace

CadFit best_face(const CadModel& model, std::span<const std::size_t> faces, const std::array<Vec<3>, 3>& corners) {
    const Vec<3> middle = (corners[0] + corners[1] + corners[2]) / 3;
    std::vector<std::pair<double, std::size_t>> by_distance;
    by_distance.reserve(faces.size());
    for (const std::size_t f : faces)
        by_distance.emplace_back(std::sqrt(model.parts().faces[f].reach.distance_squared(middle)), f);
    std::sort(by_distance.begin(), by_distance.end());
    // What is worse than twice the best is told from it: how much worse is no matter. Twins differ by rounding.
    const double rounding = 1e-6 * longest_side(corners);
    const auto enough_after = [&](double best) { return std::max(doubt * best, best + rounding); };
    std::vector<std::pair<double, std::size_t>> fits;
    double enough = infinite;
    for (const auto& [beyond, face] : by_distance) {
        if (beyond > enough) break;
        const double here = misfit(model, face, corners, enough);
        if (here > enough) continue;
        fits.emplace_back(here, face);
        enough = std::min(enough, enough_after(here));
    }
    // None where no distance is a number.
    if (fits.empty()) return {faces.front(), infinite, infinite, false};
    std::sort(fits.begin(), fits.end());
    CadFit best{fits.front().second, fits.front().first, infinite, false};
    for (const auto& [here, face] : std::span(fits).subspan(1)) {
        if (here > enough) break;
        if (coincide(model, fits.front().second, face, corners)) {
            best.has_twin = true;
            best.face = std::min(best.face, face);
        } else {
            best.second = std::min(best.second, here);
        }
    }
    return best;
}

namespace {

/// The edge between two faces, or the rim of one, that is nearest to these points.
std::optional<std::size_t> edge_of_pair(const CadModel& model, std::size_t face, std::optional<std::size_t> other,
                                        std::span<const Vec<3>> points) {
    std::optional<std::size_t> best;
    double least = infinite;
    for (const std::size_t edge : model.parts().kernel->faces[face].edges) {
        if (other && !bounds(model.parts().kernel->edges[edge], *other)) continue;
        const double farthest = farthest_from(model, edge, points);
        if (farthest >= least) continue;
        least = farthest;
        best = edge;
    }
    return best;
}

/// An edge of any of the faces that has these points.
std::optional<std::size_t> edge_through(const CadModel& model, std::span<const std::size_t> faces,
                                        std::span<const Vec<3>> points) {
    for (const std::size_t face : faces)
        if (const auto edge = edge_of_pair(model, face, std::nullopt, points))
            if (farthest_from(model, *edge, points) <= at_one_place(model.parts())) return edge;
    return std::nullopt;
}

}  // namespace

std::optional<std::size_t> edge_between(const CadModel& model, std::span<const std::size_t> faces,
                                        std::span<const Vec<3>> points) {
    if (faces.size() == 1) return edge_of_pair(model, faces.front(), std::nullopt, points);
    for (std::size_t i = 0; i < faces.size(); ++i)
        for (std::size_t j = i + 1; j < faces.size(); ++j)
            if (const auto edge = edge_of_pair(model, faces[i], faces[j], points)) return edge;
    return edge_through(model, faces, points);
}

std::optional<std::size_t> vertex_between(const CadModel& model, std::span<const std::size_t> faces, const Vec<3>& p) {
    std::optional<std::size_t> best;
    double least = infinite;
    for (const std::size_t face : faces)
        for (const std::size_t edge : model.parts().kernel->faces[face].edges)
            for (const std::size_t vertex : model.parts().kernel->edges[edge].vertices)
                if (const double d = distance(model.vertex(vertex), p); d < least) {
                    least = d;
                    best = vertex;
                }
    return best;
}

}  // namespace camber
