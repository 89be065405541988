// Virtual faces, junctions, and facets that span several faces.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import :parts;

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

Vec<3> leaving(const occ::Kernel& kernel, std::size_t edge, bool is_first) {
    const occ::EdgeFacts& facts = kernel.edges[edge];
    const Vec<3> tangent = vec(kernel.on_curve(edge, is_first ? facts.first : facts.last).first);
    return normalised(is_first ? tangent : -tangent);
}

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

double negligible(const CadModel& model) { return 1e-9 * model.parts().size; }

/// True if `foot`, the closest point of a face to p, is on the rim: p − foot is not parallel to the normal.
template <int D>
bool is_on_rim(const CadModel& model, const Vec<D>& foot, const Vec<D>& normal, const Vec<D>& p) {
    constexpr double parallel = 1e-3;
    const Vec<D> away = p - foot;
    const double length = norm(away);
    return length > negligible(model) && norm(away - dot(away, normal) * normal) > parallel * length;
}

template <class Found, int D>
Found walked(const CadModel& model, Found best, const VirtualFaces& faces, const Vec<D>& p, const MayTake& may_take,
             auto&& foot_on) {
    std::vector<std::size_t> visited{best.face};
    while (is_on_rim(model, best.foot.point, best.foot.normal, p)) {
        std::optional<Found> nearer;
        for (const std::size_t other : faces.beside[best.face]) {
            if (std::find(visited.begin(), visited.end(), other) != visited.end()) continue;
            if (may_take && !may_take(other)) continue;
            visited.push_back(other);
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

std::vector<std::uint32_t> groups_of(const CadModel& model, std::span<const std::size_t> faces) {
    std::vector<std::uint32_t> groups;
    groups.reserve(faces.size());
    for (const std::size_t face : faces) groups.push_back(model.parts().virtual_faces.groups[face]);
    std::sort(groups.begin(), groups.end());
    groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
    return groups;
}

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
    // The edge between these two faces may end before it reaches the points. Another edge then continues the chain.
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

namespace {

class JoinedFaces {
  public:
    explicit JoinedFaces(std::size_t faces) : lowest_(faces) {
        std::iota(lowest_.begin(), lowest_.end(), std::size_t{0});
    }
    void join(std::size_t a, std::size_t b) {
        a = find(a);
        b = find(b);
        lowest_[std::max(a, b)] = std::min(a, b);
    }
    [[nodiscard]] std::vector<std::vector<std::size_t>> lists() {
        std::map<std::size_t, std::vector<std::size_t>> sets;
        for (std::size_t face = 0; face < lowest_.size(); ++face) sets[find(face)].push_back(face);
        std::vector<std::vector<std::size_t>> out;
        for (auto& [lowest, faces] : sets)
            if (faces.size() > 1) out.push_back(std::move(faces));
        return out;
    }

  private:
    [[nodiscard]] std::size_t find(std::size_t face) {
        while (lowest_[face] != face) face = lowest_[face] = lowest_[lowest_[face]];
        return face;
    }
    std::vector<std::size_t> lowest_;
};

std::optional<std::size_t> nearest_of_all(const CadModel& model, std::span<const std::size_t> faces, const Vec<3>& p) {
    return nearest_face(model, faces, p);
}
std::optional<std::size_t> nearest_of_all(const CadModel& model, std::span<const std::size_t> curves, const Vec<2>& p) {
    return nearest_curve(model, curves, p);
}

Vec<3> in_space(const Vec<2>& p) { return {{p[0], p[1], 0}}; }
Vec<3> in_space(const Vec<3>& p) { return p; }

/// Faces that a facet reaches beyond the rim of its associated face.
struct Span {
    std::vector<std::array<std::size_t, 2>> pairs;  ///< pairs of faces that the facet covers together
    std::optional<Vec<3>> ridge;                    ///< point where the facet crosses a ridge
};

template <int D>
Span span_of(const CadModel& model, std::span<const std::size_t> all, std::size_t face,
             const std::array<Vec<D>, D>& corners) {
    Span out;
    const double limit = off_limit * longest_side(corners);
    const VirtualFaces& groups = virtual_faces_of<D>(model.parts());
    for (const Vec<D>& p : corners) {
        const auto own = closest_on_virtual_face(model, face, p, [](std::size_t) { return false; });
        if (own.foot.distance <= limit) continue;
        const auto found = closest_on_virtual_face(model, face, p);
        for (const std::size_t other : found.through) out.pairs.push_back({other, found.face});
        if (out.ridge || found.foot.distance <= limit) continue;
        const auto other = nearest_of_all(model, all, p);
        if (!other || groups.are_joined(*other, face)) continue;
        const auto there = closest_on_virtual_face(model, *other, p, [](std::size_t) { return false; });
        if (there.foot.distance <= limit) out.ridge = in_space(found.foot.point);
    }
    return out;
}

}  // namespace

template <int D>
Outcome<Done> find_spans(const LinearMesh<D>& mesh, const CadModel& model, std::span<const CadFit> fits,
                         std::span<const std::array<std::size_t, 2>> pairs, const Execution& execution,
                         CadAssociation& association) {
    const std::vector<std::size_t> all = candidates<D>(model);
    const auto spans = map_each(
        execution, mesh.facets.size(),
        [&](std::size_t f) -> Span {
            const auto corners = facet_site(mesh, FacetId(f)).corners;
            if (association.faces[f] == no_face || fits[f].fit_error <= off_limit * longest_side(corners)) return {};
            return span_of<D>(model, all, association.faces[f], corners);
        },
        16);
    if (!spans) return fail(spans.error());
    const VirtualFaces& groups = virtual_faces_of<D>(model.parts());
    JoinedFaces joined(groups.groups.size());
    for (const auto& [a, b] : pairs) {
        joined.join(a, b);
        // If the faces a and b of a mesh edge are no neighbours in the model, a sliver between them may have no facets
        // at this edge.
        const auto& [near_a, near_b] = std::tie(groups.beside[a], groups.beside[b]);
        if (std::binary_search(near_a.begin(), near_a.end(), b)) continue;
        for (const std::size_t face : near_a)
            if (std::binary_search(near_b.begin(), near_b.end(), face)) joined.join(a, face);
    }
    std::vector<std::uint8_t> is_met(groups.groups.size(), 0);
    for (std::size_t f = 0; f < spans->size(); ++f) {
        const Span& span = (*spans)[f];
        if (association.faces[f] != no_face) is_met[association.faces[f]] = 1;
        for (const auto& [a, b] : span.pairs) joined.join(a, b);
        if (!span.ridge) continue;
        if (association.across.count++ > 0) continue;
        association.across.first = FacetId(f);
        association.across.place = *span.ridge;
    }
    // In a mesh of the whole boundary, a face without facets is covered by facets of its neighbours.
    if (association.facets == mesh.facets.size())
        for (const std::size_t face : all)
            for (const std::size_t other : groups.beside[face])
                if (is_met[face] == 0 && is_met[other] != 0) joined.join(face, other);
    association.joined = joined.lists();
    return Done{};
}

std::vector<std::uint32_t> joined_lists(const CadAssociation& association, std::size_t faces) {
    std::vector<std::uint32_t> lists(faces, no_face);
    for (std::size_t i = 0; i < association.joined.size(); ++i)
        for (const std::size_t face : association.joined[i]) lists[face] = static_cast<std::uint32_t>(i);
    return lists;
}

#define CAMBER_INSTANTIATE(D)                                                                            \
    template Outcome<Done> find_spans<D>(const LinearMesh<D>&, const CadModel&, std::span<const CadFit>, \
                                         std::span<const std::array<std::size_t, 2>>, const Execution&,  \
                                         CadAssociation&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
