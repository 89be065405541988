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

/// Sum of the largest distance of the vertices, the distance of the middle, and the sine of the angle between the
/// normals times the facet's size; above `enough` perhaps less than that. `foot`: of the middle.
double misfit(const CadModel& model, std::size_t face, const std::array<Vec<3>, 3>& corners, const CadFoot& foot,
              double enough) {
    const Vec<3> normal = normalised(cross(corners[1] - corners[0], corners[2] - corners[0]));
    double sum = foot.distance + longest_side(corners) * norm(cross(normal, foot.normal));
    double farthest = 0;
    for (const Vec<3>& corner : corners) {
        if (sum + farthest > enough) return sum + farthest;
        farthest = std::max(farthest, closest_on_face(model, face, corner, foot.parameters).distance);
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

/// Calls visit(face) for the candidates (rising) whose boxes are not farther from p than `most()`, which may fall with
/// each visit; the nearest first, as a rule.
template <class Most, class Visit>
void visit_near(const CadModel& model, std::span<const std::size_t> candidates, const Vec<3>& p, Most&& most,
                Visit&& visit) {
    const CadParts& parts = model.parts();
    const bool is_all = candidates.size() == model.faces();
    (void)parts.tree_of_faces.nearest(p, [&](std::size_t face) {
        const bool is_candidate = is_all || std::binary_search(candidates.begin(), candidates.end(), face);
        if (is_candidate && !(std::sqrt(parts.faces[face].reach.distance_squared(p)) > most())) visit(face);
        return most() * most();
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
    // Faces that fit worse than twice the best are as good as any others. Twins differ by rounding.
    const double rounding = 1e-6 * longest_side(corners);
    struct Fit {
        double misfit = 0;
        std::size_t face = 0;
        std::array<double, 2> middle{};
    };
    std::vector<Fit> fits;
    double enough = infinite;
    visit_near(
        model, faces, middle, [&] { return enough; },
        [&](std::size_t face) {
            const CadFoot foot = closest_on_face(model, face, middle);
            const double here = misfit(model, face, corners, foot, enough);
            if (!(here <= enough)) return;
            fits.push_back({here, face, foot.parameters});
            enough = std::min(enough, std::max(doubt * here, here + rounding));
        });
    // None where no distance is a number.
    if (fits.empty()) return {.face = faces.front(), .misfit = infinite, .second = infinite, .other = infinite};
    std::sort(fits.begin(), fits.end(),
              [](const Fit& a, const Fit& b) { return std::pair(a.misfit, a.face) < std::pair(b.misfit, b.face); });
    const Fit& first = fits.front();
    CadFit best{
        .face = first.face, .misfit = first.misfit, .second = infinite, .other = infinite, .middle = first.middle};
    const VirtualFaces& joined = model.parts().virtual_faces;
    for (const Fit& fit : std::span(fits).subspan(1)) {
        if (fit.misfit > enough) break;
        if (coincide(model, first.face, fit.face, corners)) {
            best.has_twin = true;
            if (fit.face > best.face) continue;
            best.face = fit.face;
            best.middle = fit.middle;
        } else {
            best.second = std::min(best.second, fit.misfit);
            if (!joined.are_joined(first.face, fit.face)) best.other = std::min(best.other, fit.misfit);
        }
    }
    return best;
}

std::optional<std::size_t> nearest_face(const CadModel& model, std::span<const std::size_t> faces, const Vec<3>& p) {
    std::optional<std::size_t> best;
    double least = infinite;
    visit_near(
        model, faces, p, [&] { return least; },
        [&](std::size_t face) {
            const double distance = closest_on_face(model, face, p).distance;
            if (!(distance < least) && !(distance == least && best && face < *best)) return;
            least = distance;
            best = face;
        });
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
