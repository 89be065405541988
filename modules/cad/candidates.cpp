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

double longest_side(const std::array<Vec<3>, 3>& c) {
    return std::max({distance(c[0], c[1]), distance(c[1], c[2]), distance(c[2], c[0])});
}

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
    CadFit best{faces.front(), infinite, infinite};
    for (const auto& [beyond, face] : by_distance) {
        // What is worse than twice the best is told from it: how much worse is no matter.
        const double enough = std::min(best.second, doubt * best.misfit);
        if (beyond > enough) break;
        const double here = misfit(model, face, corners, enough);
        if (here < best.misfit || (here == best.misfit && face < best.face)) {
            best.second = best.misfit;
            best.misfit = here;
            best.face = face;
        } else {
            best.second = std::min(best.second, here);
        }
    }
    return best;
}

std::optional<std::size_t> edge_between(const CadModel& model, std::span<const std::size_t> faces,
                                        std::span<const Vec<3>> points) {
    std::optional<std::size_t> best;
    double least = infinite;
    const auto& edges = model.parts().kernel->edges;
    for (const std::size_t edge : model.parts().kernel->faces[faces.front()].edges) {
        // Of one face any edge of it.
        if (faces.size() > 1 && !bounds(edges[edge], faces[1])) continue;
        double farthest = 0;
        for (const Vec<3>& p : points) farthest = std::max(farthest, closest_on_edge(model, edge, p).distance);
        if (farthest >= least) continue;
        least = farthest;
        best = edge;
    }
    return best;
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
