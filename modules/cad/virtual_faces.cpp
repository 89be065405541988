module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import :in_plane;
import :parts;
import :virtual_faces;

namespace camber {

namespace {

constexpr double smooth_angle = smooth_angle_degrees * std::numbers::pi / 180;

VirtualFaces grouped(std::vector<std::vector<std::size_t>> beside) {
    VirtualFaces out;
    out.groups.resize(beside.size());
    std::vector<std::uint8_t> is_grouped(beside.size(), 0);
    for (std::size_t first = 0; first < beside.size(); ++first) {
        std::vector<std::size_t> open{first};
        while (!open.empty()) {
            const std::size_t face = open.back();
            open.pop_back();
            if (is_grouped[face] != 0) continue;
            is_grouped[face] = 1;
            out.groups[face] = static_cast<std::uint32_t>(first);
            open.insert(open.end(), beside[face].begin(), beside[face].end());
        }
    }
    for (auto& list : beside) {
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    out.beside = std::move(beside);
    return out;
}

/// The direction in which an edge leaves one of its ends.
Vec<3> leaving(const occ::Kernel& kernel, std::size_t edge, bool is_first) {
    const occ::EdgeFacts& facts = kernel.edges[edge];
    const Vec<3> tangent = vec(kernel.on_curve(edge, is_first ? facts.first : facts.last).first);
    return normalised(is_first ? tangent : -tangent);
}

/// The ends of edges at each vertex of the model.
std::vector<std::vector<std::pair<std::size_t, bool>>> ends_at_vertices(const occ::Kernel& kernel) {
    std::vector<std::vector<std::pair<std::size_t, bool>>> ends(kernel.vertices.size());
    for (std::size_t e = 0; e < kernel.edges.size(); ++e)
        for (const bool is_first : {true, false}) {
            const occ::EdgeFacts& facts = kernel.edges[e];
            const Vec<3> end = vec(kernel.on_curve(e, is_first ? facts.first : facts.last).point);
            const auto nearest =
                std::min_element(facts.vertices.begin(), facts.vertices.end(), [&](std::size_t a, std::size_t b) {
                    return distance(vec(kernel.vertices[a]), end) < distance(vec(kernel.vertices[b]), end);
                });
            if (nearest != facts.vertices.end()) ends[*nearest].emplace_back(e, is_first);
        }
    return ends;
}

/// Points whose foot is nearer than this share of the model's size lie on the face.
double negligible(const CadModel& model) { return 1e-9 * model.parts().size; }

/// Whether the nearest point is one of a face's rim, beyond which the face would be nearer if it went on.
template <int D>
bool is_on_rim(const CadModel& model, const Vec<D>& foot, const Vec<D>& normal, const Vec<D>& p) {
    constexpr double parallel = 1e-3;
    const Vec<D> away = p - foot;
    const double length = norm(away);
    return length > negligible(model) && norm(away - dot(away, normal) * normal) > parallel * length;
}

/// The walk from face to face, in space and in a plane.
template <class Found, int D>
Found walked(const CadModel& model, Found best, const VirtualFaces& faces, const Vec<D>& p, const MayTake& may_take,
             auto&& foot_on) {
    std::vector<std::size_t> seen{best.face};
    while (is_on_rim(model, best.foot.point, best.foot.normal, p)) {
        std::optional<Found> nearer;
        for (const std::size_t other : faces.beside[best.face]) {
            if (std::find(seen.begin(), seen.end(), other) != seen.end()) continue;
            if (may_take && !may_take(other)) continue;
            seen.push_back(other);
            Found there{other, foot_on(other)};
            if (there.foot.distance < (nearer ? *nearer : best).foot.distance) nearer = std::move(there);
        }
        if (!nearer) return best;
        nearer->through = std::move(best.through);
        nearer->through.push_back(best.face);
        best = std::move(*nearer);
    }
    return best;
}

double farthest_from(const CadModel& model, std::size_t edge, std::span<const Vec<3>> points) {
    double farthest = 0;
    for (const Vec<3>& p : points) farthest = std::max(farthest, closest_on_edge(model, edge, p).distance);
    return farthest;
}

/// The virtual faces of these, by the numbers of their lowest faces, rising.
std::vector<std::uint32_t> groups_of(const CadModel& model, std::span<const std::size_t> faces) {
    std::vector<std::uint32_t> groups;
    groups.reserve(faces.size());
    for (const std::size_t face : faces) groups.push_back(model.parts().virtual_faces.groups[face]);
    std::sort(groups.begin(), groups.end());
    groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
    return groups;
}

/// The faces, and those that are at most two smooth edges away, rising.
std::vector<std::size_t> with_neighbours(const CadModel& model, std::span<const std::size_t> faces) {
    std::vector<std::size_t> all(faces.begin(), faces.end());
    for (int ring = 0; ring < 2; ++ring) {
        const std::vector<std::size_t> inner = all;
        for (const std::size_t face : inner) {
            const auto& beside = model.parts().virtual_faces.beside[face];
            all.insert(all.end(), beside.begin(), beside.end());
        }
        std::sort(all.begin(), all.end());
        all.erase(std::unique(all.begin(), all.end()), all.end());
    }
    return all;
}

/// The chain of edges between the two virtual faces of these faces, where all points are within reach of it.
std::optional<Junction> chain_at(const CadModel& model, std::span<const std::size_t> faces,
                                 std::span<const Vec<3>> points, double reach) {
    Junction junction{.on = Junction::On::edge, .is_chain = true};
    Vec<3> middle;
    for (const Vec<3>& p : points) {
        const auto edge = chain_edge(model, faces, p);
        if (!edge) return std::nullopt;
        junction.distance = std::max(junction.distance, closest_on_edge(model, *edge, p).distance);
        middle += p / static_cast<double>(points.size());
    }
    if (junction.distance > reach) return std::nullopt;
    junction.number = *chain_edge(model, faces, middle);
    return junction;
}

/// Of these faces the nearest to the middle of the points.
Junction nearest_of(const CadModel& model, std::span<const std::size_t> faces, std::span<const Vec<3>> points) {
    Vec<3> middle;
    for (const Vec<3>& p : points) middle += p / static_cast<double>(points.size());
    const std::size_t face = *nearest_face(model, faces, middle);
    double away = 0;
    for (const Vec<3>& p : points) away = std::max(away, closest_on_virtual_face(model, face, p).foot.distance);
    return {.on = Junction::On::face, .number = face, .distance = away, .is_within_group = true};
}

}  // namespace

VirtualFaces virtual_faces(const occ::Kernel& kernel) {
    std::vector<std::vector<std::size_t>> beside(kernel.faces.size());
    for (const occ::EdgeFacts& edge : kernel.edges) {
        if (edge.faces.size() != 2 || !(edge.turn <= smooth_angle)) continue;
        beside[edge.faces[0]].push_back(edge.faces[1]);
        beside[edge.faces[1]].push_back(edge.faces[0]);
    }
    return grouped(std::move(beside));
}

VirtualFaces virtual_curves(const occ::Kernel& kernel) {
    std::vector<std::vector<std::size_t>> beside(kernel.edges.size());
    for (const auto& ends : ends_at_vertices(kernel))
        for (std::size_t i = 0; i < ends.size(); ++i)
            for (std::size_t j = i + 1; j < ends.size(); ++j) {
                const auto& [a, a_first] = ends[i];
                const auto& [b, b_first] = ends[j];
                if (a == b || !(dot(leaving(kernel, a, a_first), leaving(kernel, b, b_first)) <= -cos(smooth_angle)))
                    continue;
                beside[a].push_back(b);
                beside[b].push_back(a);
            }
    return grouped(std::move(beside));
}

VirtualFoot closest_on_virtual_face(const CadModel& model, std::size_t face, const Vec<3>& p, const MayTake& may_take) {
    return walked(model, VirtualFoot{face, closest_on_face(model, face, p)}, model.parts().virtual_faces, p, may_take,
                  [&](std::size_t other) { return closest_on_face(model, other, p); });
}

VirtualCurveFoot closest_on_virtual_face(const CadModel& model, std::size_t curve, const Vec<2>& p,
                                         const MayTake& may_take) {
    return walked(model, VirtualCurveFoot{curve, closest_on_curve(model, curve, p)}, model.parts().virtual_curves, p,
                  may_take, [&](std::size_t other) { return closest_on_curve(model, other, p); });
}

std::optional<std::size_t> chain_edge(const CadModel& model, std::span<const std::size_t> faces, const Vec<3>& p) {
    const CadParts& parts = model.parts();
    const auto groups = groups_of(model, faces);
    std::optional<std::size_t> best;
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t face : with_neighbours(model, faces))
        for (const std::size_t edge : parts.kernel->faces[face].edges) {
            if (parts.edges[edge].reach.distance_squared(p) >= least * least) continue;
            if (groups_of(model, parts.kernel->edges[edge].faces) != groups) continue;
            const double away = closest_on_edge(model, edge, p).distance;
            if (away >= least) continue;
            least = away;
            best = edge;
        }
    return best;
}

Junction junction_at(const CadModel& model, std::span<const std::size_t> faces, std::span<const Vec<3>> points,
                     const Reach& reach) {
    const std::size_t groups = groups_of(model, faces).size();
    const auto edge = edge_between(model, faces, points);
    Junction junction;
    if (edge) junction = {.on = Junction::On::edge, .number = *edge, .distance = farthest_from(model, *edge, points)};
    const auto& beside = edge ? model.parts().kernel->edges[*edge].faces : std::vector<std::size_t>{};
    const bool is_smooth = groups == 1 || (beside.size() == 2 && groups_of(model, beside).size() == 1);
    if (edge && junction.distance <= reach.smooth) return junction;
    if (groups == 1) return nearest_of(model, faces, points);
    const bool is_near = edge && !is_smooth && junction.distance <= reach.ridge;
    // The edge between these two faces may have ended, and another one of the chain goes on.
    if (groups == 2)
        if (const auto chain = chain_at(model, faces, points, reach.ridge))
            if (!is_near || chain->distance < junction.distance) return *chain;
    return junction;
}

Junction junction_at_vertex(const CadModel& model, std::span<const std::size_t> faces, const Vec<3>& p,
                            const Reach& reach) {
    if (faces.size() == 2) return junction_at(model, faces, std::span(&p, 1), reach);
    const auto vertex = vertex_between(model, faces, p);
    const bool is_smooth = groups_of(model, faces).size() <= 2;
    Junction junction;
    if (vertex)
        junction = {.on = Junction::On::vertex, .number = *vertex, .distance = distance(model.vertex(*vertex), p)};
    if (vertex && junction.distance <= (is_smooth ? reach.smooth : reach.ridge)) return junction;
    if (!is_smooth) return junction;
    const Junction other = junction_at(model, faces, std::span(&p, 1), reach);
    return other.on != Junction::On::edge || other.distance <= reach.ridge ? other : junction;
}

}  // namespace camber
