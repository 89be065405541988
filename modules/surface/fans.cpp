module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;

namespace camber {

namespace {

/// The corner opposite local edge k of a triangle, in the order of local_edges: e01 e12 e20.
constexpr std::array<std::size_t, 3> opposite_of_edge{2, 0, 1};

FacetId other_facet(std::span<const FacetId> shell, FacetId f) { return shell[0] == f ? shell[1] : shell[0]; }

Outcome<Buffer<std::array<FacetId, 3>>> smooth_neighbours(const EdgeSet<3>& edges, const Features<3>& features,
                                                          const Incidence<FacetId>& shells,
                                                          const Execution& execution) {
    return map_each(execution, edges.of_facets.size(), [&](std::size_t f) {
        std::array<FacetId, 3> across;
        for (std::size_t k = 0; k < 3; ++k) {
            const EdgeId e = edges.of_facets[f][k];
            if (features.edge_kinds[e] == EdgeKind::surface)
                across[opposite_of_edge[k]] = other_facet(shells[e], FacetId(f));
        }
        return across;
    });
}

/// Whether the facet runs along the edge from a to b in that direction.
bool runs_along(const SimplexVertices<2>& facet, VertexId a, VertexId b) {
    return facet[(corner_of(facet, a) + 1) % 3] == b;
}

/// Spreads the sign of each patch's first facet over the patch. On a one-sided patch some seam is left.
Buffer<std::int8_t> patch_signs(const LinearMesh<3>& mesh, const Buffer<std::array<FacetId, 3>>& neighbours) {
    Buffer<std::int8_t> signs(neighbours.size());
    std::fill(signs.begin(), signs.end(), std::int8_t{0});
    std::vector<FacetId> front;
    for (std::size_t first = 0; first < signs.size(); ++first) {
        if (signs[first] != 0) continue;
        signs[first] = 1;
        front.assign(1, FacetId(first));
        while (!front.empty()) {
            const FacetId f = front.back();
            front.pop_back();
            const auto& facet = mesh.facets.vertices[f];
            for (std::size_t i = 0; i < 3; ++i) {
                const FacetId g = neighbours[f.index()][i];
                if (!g.valid() || signs[g.index()] != 0) continue;
                const bool same_way = runs_along(mesh.facets.vertices[g], facet[(i + 1) % 3], facet[(i + 2) % 3]);
                signs[g.index()] = static_cast<std::int8_t>(same_way ? -signs[f.index()] : signs[f.index()]);
                front.push_back(g);
            }
        }
    }
    return signs;
}

/// The angle between vectors.
double angle_between(const Vec<3>& a, const Vec<3>& b) { return atan2(norm(cross(a, b)), dot(a, b)); }

/// True if a facet of the fan turns from the mean normal by more than 20°, or between two ridges by more than 40°.
/// Around the end of a ridge, and around a vertex in which another surface ends (`is_shared`), facets turn anyway.
bool is_pointed(const LinearMesh<3>& mesh, const Fans& fans, std::uint32_t fan, bool is_shared) {
    constexpr double max_turn = 20 * std::numbers::pi / 180;
    Vec<3> mean;
    std::vector<VertexId> ridges;  // their other ends
    for (const FacetId f : fans.facets[fan]) {
        const auto& v = mesh.facets.vertices[f];
        const std::size_t i = corner_of(v, fans.vertices[fan]), next = (i + 1) % 3, last = (i + 2) % 3;
        mean += angle_between(mesh.points[v[next]] - mesh.points[v[i]], mesh.points[v[last]] - mesh.points[v[i]]) *
                normalised(area_vector(mesh, fans, f));
        if (!fans.neighbours[f][next].valid()) ridges.push_back(v[last]);
        if (!fans.neighbours[f][last].valid()) ridges.push_back(v[next]);
    }
    if (ridges.size() == 2 && ridges[0] == ridges[1]) return false;
    if (ridges.empty() && is_shared) return false;
    return std::ranges::any_of(fans.facets[fan], [&](FacetId f) {
        return angle_between(area_vector(mesh, fans, f), mean) > (ridges.empty() ? 1 : 2) * max_turn;
    });
}

/// A corner of a facet, as 3 f + i.
using Corner = std::uint32_t;

/// The facets of the fan that holds the corner, by a walk across the two edges at its vertex.
void walk_fan(const LinearMesh<3>& mesh, const Buffer<std::array<FacetId, 3>>& neighbours, Corner corner,
              std::vector<Corner>& fan) {
    const VertexId v = mesh.facets.vertices[corner / 3][corner % 3];
    fan.assign(1, corner);
    for (std::size_t next = 0; next < fan.size(); ++next) {
        const std::size_t f = fan[next] / 3, at = fan[next] % 3;
        for (const std::size_t side : {(at + 1) % 3, (at + 2) % 3}) {
            const FacetId g = neighbours[f][side];
            if (!g.valid()) continue;
            const Corner there = static_cast<Corner>(3 * g.index() + corner_of(mesh.facets.vertices[g], v));
            if (std::find(fan.begin(), fan.end(), there) == fan.end()) fan.push_back(there);
        }
    }
    std::sort(fan.begin(), fan.end());
}

}  // namespace

std::size_t corner_of(const SimplexVertices<2>& facet, VertexId v) {
    for (std::size_t i = 0; i < 3; ++i)
        if (facet[i] == v) return i;
    return 0;
}

Outcome<Fans> find_fans(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Features<3>& features,
                        const Incidence<FacetId>& shells, const Execution& execution) {
    auto neighbours = smooth_neighbours(edges, features, shells, execution);
    if (!neighbours) return fail(neighbours.error());
    constexpr std::uint32_t unseen = 0xffffffffU;
    Buffer<std::array<std::uint32_t, 3>> of_facets(mesh.facets.size());
    std::fill(of_facets.begin(), of_facets.end(), std::array{unseen, unseen, unseen});
    Buffer<std::uint32_t> offsets;
    Buffer<FacetId> items;
    Buffer<VertexId> vertices;
    offsets.push_back(0);
    items.reserve(3 * mesh.facets.size());
    std::vector<Corner> fan;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (std::size_t i = 0; i < 3; ++i) {
            if (of_facets[f][i] != unseen) continue;
            walk_fan(mesh, *neighbours, static_cast<Corner>(3 * f + i), fan);
            for (const Corner c : fan) {
                of_facets[c / 3][c % 3] = static_cast<std::uint32_t>(vertices.size());
                items.push_back(FacetId(std::size_t{c / 3}));
            }
            vertices.push_back(mesh.facets.vertices[f][i]);
            offsets.push_back(static_cast<std::uint32_t>(items.size()));
        }
    auto signs = patch_signs(mesh, *neighbours);
    Fans fans{std::move(of_facets), {std::move(offsets), std::move(items)},
              std::move(vertices),  std::move(*neighbours),
              std::move(signs),     {}};
    std::vector<std::uint8_t> fans_at(mesh.points.size(), 0);
    for (const VertexId v : fans.vertices) fans_at[v.index()] = fans_at[v.index()] == 0 ? 1 : 2;
    auto pointed = map_each(execution, fans.size(), [&](std::size_t i) -> std::uint8_t {
        const VertexId v = fans.vertices[i];
        if (features.vertex_kinds[v] != VertexKind::corner) return 0;
        return is_pointed(mesh, fans, static_cast<std::uint32_t>(i), fans_at[v.index()] > 1) ? 1 : 0;
    });
    if (!pointed) return fail(pointed.error());
    fans.pointed = std::move(*pointed);
    return fans;
}

Vec<3> area_vector(const LinearMesh<3>& mesh, const Fans& fans, FacetId f) {
    const auto& [a, b, c] = mesh.facets.vertices[f];
    return static_cast<double>(fans.signs[f]) * cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]);
}

std::vector<std::uint32_t> rings(const LinearMesh<3>& mesh, const Fans& fans, std::uint32_t fan, const Vec<3>& normal,
                                 const RingOptions& options) {
    constexpr double min_cosine = 0.3;
    std::vector<std::uint32_t> found;
    std::vector<FacetId> facets;
    const auto enter = [&](std::uint32_t other) {
        for (const FacetId f : fans.facets[other]) {
            const Vec<3> area = area_vector(mesh, fans, f);
            if (dot(area, normal) < min_cosine * norm(area)) continue;
            if (std::find(facets.begin(), facets.end(), f) == facets.end()) facets.push_back(f);
        }
    };
    enter(fan);
    std::size_t seen = 0, entered = 0;
    for (int ring = 1;; ++ring) {
        for (; seen < facets.size(); ++seen)
            for (const std::uint32_t other : fans.of_facets[facets[seen]])
                if (other != fan && std::find(found.begin(), found.end(), other) == found.end()) found.push_back(other);
        if (ring >= options.max_rings || found.size() >= options.most) break;
        if (ring >= options.min_rings && found.size() >= options.enough) break;
        for (const std::size_t end = found.size(); entered < end; ++entered)
            if (fans.pointed[found[entered]] == 0) enter(found[entered]);
        if (facets.size() == seen) break;
    }
    return found;
}

}  // namespace camber
