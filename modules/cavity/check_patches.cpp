module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.cavity;
import camber.core;
import :check_patches;
import :draft;

namespace camber {

namespace {

auto refused(std::string what) { return fail(ErrorKind::internal, std::move(what)); }

/// Whether edges at the point that elements or facets outside of the cavity have keep their nodes.
template <int D>
bool keeps_outer_nodes(const DynamicMesh<D>& mesh, const Patch<D>& patch) {
    const auto& boundary = patch.star.boundary;
    for (const ElementFace& face : patch.star.kept) {
        const auto& vertices = mesh.elements.vertices[face.element];
        const int held = local_vertex(vertices, patch.point.vertex);
        for (int i = 0; i <= D; ++i) {
            if (i == held || i == static_cast<int>(face.opposite)) continue;
            const auto at = std::find(boundary.begin(), boundary.end(), vertices[i]) - boundary.begin();
            if (at == std::ssize(boundary)) continue;  // no new element has the edge
            if (mesh.nodes[mesh.edges_of[face.element][edge_between<D>[i][held]]] != patch.nodes[at]) return false;
        }
    }
    return true;
}

/// Whether the elements of each node that follows are of the patch, and of no other: those that it reshapes are marked.
template <int D>
Outcome<Done> check_following(const DynamicMesh<D>& mesh, const Patch<D>& patch, std::vector<bool>& is_taken) {
    for (const ElementId e : patch.reshaped) {
        if (is_taken[e.index()])
            return fail(ErrorKind::internal, "two patches change one element", {},
                        Entity{simplex_name<D>, e.index() + 1});
        is_taken[e.index()] = true;
    }
    const auto is_of_patch = [&](ElementId e) {
        return std::ranges::find(patch.reshaped, e) != patch.reshaped.end() ||
               std::ranges::find(patch.removed.elements, e) != patch.removed.elements.end();
    };
    std::vector<ElementId> around;
    for (const auto& following : patch.following) {
        const auto has_edge = [&](ElementId e) {
            return std::ranges::find(mesh.edges_of[e], following.edge) != mesh.edges_of[e].end();
        };
        const auto first = std::ranges::find_if(patch.reshaped, has_edge);
        if (first == patch.reshaped.end()) return refused("a node follows a patch that does not reshape its elements");
        const auto& edges = mesh.edges_of[*first];
        shell(mesh, *first, static_cast<int>(std::ranges::find(edges, following.edge) - edges.begin()), around);
        if (!std::ranges::all_of(around, is_of_patch))
            return refused("a patch moves a node that elements have which it neither removes nor reshapes");
    }
    return Done{};
}

}  // namespace

template <int D>
Outcome<Done> check_patches(const DynamicMesh<D>& mesh, std::span<const Patch<D>> patches) {
    std::vector<bool> is_removed(mesh.elements.size(), false);
    std::vector<VertexId> vanishing;
    std::vector<std::array<VertexId, 2>> edges;
    std::size_t made = 0;
    constexpr std::size_t max_places = 0x7fffffffU;  // see FaceNeighbour
    for (const Patch<D>& patch : patches) {
        if (patch.planned_for != mesh.stamp) return refused("a patch was planned for another mesh");
        for (const ElementId e : patch.removed.elements) {
            if (is_removed[e.index()])
                return fail(ErrorKind::internal, "two patches remove one element", {},
                            Entity{simplex_name<D>, e.index() + 1});
            is_removed[e.index()] = true;
        }
        if (auto checked = check_following(mesh, patch, is_removed); !checked) return checked;
        append(vanishing, patch.star.vanishing);
        made += patch.star.joined.size();
        if (patch.point.vertex.valid() && patch.point.place && !patch.star.kept.empty() &&
            *patch.point.place != mesh.points[patch.point.vertex])
            return refused("a patch moves a vertex that elements outside of its cavity have");
        if (patch.nodes.size() != (mesh.is_curved() ? patch.star.boundary.size() : 0))
            return refused("a patch has not one node for each edge at its point");
        if (mesh.is_curved() && !keeps_outer_nodes(mesh, patch))
            return refused("a patch moves a node that elements or facets outside of its cavity have");
        if (const VertexId p = patch.point.vertex;
            p.valid() && !keeps_topology<D>(mesh.elements.vertices.view(), patch))
            for (const VertexId v : patch.star.boundary) edges.push_back({std::min(p, v), std::max(p, v)});
    }
    if (mesh.elements.size() + made >= max_places || mesh.facets.size() + made >= max_places ||
        mesh.edges.size() + 3 * made >= max_entities)
        return fail(ErrorKind::unsupported, "the mesh would have more entities than 32 bits count");
    std::sort(edges.begin(), edges.end());
    if (std::adjacent_find(edges.begin(), edges.end()) != edges.end()) return refused("two patches make one edge");
    std::sort(vanishing.begin(), vanishing.end());
    for (const Patch<D>& patch : patches)
        if (std::binary_search(vanishing.begin(), vanishing.end(), patch.point.vertex))
            return refused("a patch removes the point of another one");
    return Done{};
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> check_patches<D>(const DynamicMesh<D>&, std::span<const Patch<D>>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
