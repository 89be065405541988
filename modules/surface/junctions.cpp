module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;

namespace camber {

namespace {

/// Whom the facets around a vertex belong to.
enum Owner : std::uint8_t { none = 0, surrogate = 1, prescription = 2, both = 3 };

template <int D>
Buffer<std::uint8_t> owners_of_vertices(const LinearMesh<D>& mesh, std::span<const std::uint8_t> prescribed) {
    Buffer<std::uint8_t> owners(mesh.points.size());
    std::fill(owners.begin(), owners.end(), std::uint8_t{none});
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (const VertexId v : mesh.facets.vertices[f])
            owners[v.index()] =
                static_cast<std::uint8_t>(owners[v.index()] | (prescribed[f] != 0 ? prescription : surrogate));
    return owners;
}

/// Where the file says that the boundary breaks nothing goes on.
void forget_breaks(const LinearMesh<2>& mesh, const EdgeSet<2>&, const Incidence<FacetId>&,
                   std::span<const std::uint8_t>, Buffer<std::uint8_t>& owners) {
    for (const VertexId v : mesh.corners) owners[v.index()] = none;
    for (const std::uint32_t f : mesh.ridges)
        for (const VertexId v : mesh.facets.vertices[f]) owners[v.index()] = none;
}
void forget_breaks(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Incidence<FacetId>& shells,
                   std::span<const std::uint8_t> prescribed, Buffer<std::uint8_t>& owners) {
    for (const std::uint32_t ridge : mesh.ridges) {
        const auto shell = shells[edges.of_edges[ridge]];
        const auto count = std::ranges::count_if(shell, [&](FacetId f) { return prescribed[f.index()] != 0; });
        if (count == 0 || count == std::ssize(shell)) continue;
        for (const VertexId v : mesh.edges.vertices[ridge]) owners[v.index()] = none;
    }
}

/// Which way a facet goes from the line of its edge: a unit vector.
Vec<3> away_from(const LinearMesh<3>& mesh, FacetId f, const std::array<VertexId, 2>& edge) {
    const Vec<3> along = normalised(mesh.points[edge[1]] - mesh.points[edge[0]]);
    for (const VertexId v : mesh.facets.vertices[f]) {
        if (v == edge[0] || v == edge[1]) continue;
        const Vec<3> to = normalised(mesh.points[v] - mesh.points[edge[0]]);
        return normalised(cross(along, cross(to, along)));
    }
    return {};
}
/// By how much the boundary turns from one facet to another across their edge, in radians.
double turn_across(const LinearMesh<3>& mesh, const std::array<VertexId, 2>& edge, FacetId f, FacetId g) {
    const Vec<3> from = away_from(mesh, f, edge), to = -away_from(mesh, g, edge);
    return atan2(norm(cross(from, to)), dot(from, to));
}

/// The largest turn from a facet of the fan to one beside it.
double largest_turn(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Features<3>& features,
                    const Incidence<FacetId>& shells, std::span<const FacetId> fan) {
    double largest = 0;
    for (const FacetId f : fan)
        for (const EdgeId e : edges.of_facets[f])
            if (features.edge_kinds[e] == EdgeKind::surface)
                largest = std::max(largest, turn_across(mesh, edges.vertices[e], shells[e][0], shells[e][1]));
    return largest;
}

}  // namespace

template <int D>
Vec<D> Junctions<D>::normal(const LinearMesh<D>& mesh, FacetId f, VertexId v) const {
    const auto found = std::lower_bound(facets.begin(), facets.end(), f);
    if (found == facets.end() || *found != f) return {};
    const auto& vertices = mesh.facets.vertices[f];
    const auto corner = std::find(vertices.begin(), vertices.end(), v) - vertices.begin();
    return normals[static_cast<std::size_t>(found - facets.begin())][static_cast<std::size_t>(corner)];
}

template <int D>
Outcome<Junctions<D>> find_junctions(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                     const Incidence<FacetId>& shells, const GeometryModel<D>& geometry,
                                     const Execution& execution) {
    auto prescribed = map_each(part_of(execution, 0, 0.2), mesh.facets.size(), [&](std::size_t f) -> std::uint8_t {
        return geometry.prescribes(mesh.facets.references[f]) ? 1 : 0;
    });
    if (!prescribed) return fail(prescribed.error());
    auto owners = owners_of_vertices(mesh, std::span<const std::uint8_t>(*prescribed));
    forget_breaks(mesh, edges, shells, *prescribed, owners);
    const auto is_shared = [&](VertexId v) { return owners[v.index()] == both; };
    Buffer<FacetId> facets;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        if ((*prescribed)[f] != 0 && std::ranges::any_of(mesh.facets.vertices[f], is_shared))
            facets.push_back(FacetId(f));
    auto normals = map_each(part_of(execution, 0.2, 1), facets.size(), [&](std::size_t row) {
        auto at = geometry.normals_at(facet_site(mesh, facets[row])).value_or(std::array<Vec<D>, D>{});
        for (std::size_t i = 0; i < D; ++i)
            if (!is_shared(mesh.facets.vertices[facets[row]][i]) || !is_finite(at[i])) at[i] = {};
        return at;
    });
    if (!normals) return fail(normals.error());
    return Junctions<D>{std::move(*prescribed), std::move(facets), std::move(*normals)};
}

Beyond beyond_fan(const Junctions<3>& junctions, const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                  const Features<3>& features, const Incidence<FacetId>& shells, const Fans& fans, std::uint32_t fan,
                  const Vec<3>& fitted) {
    const VertexId v = fans.vertices[fan];
    const auto facets = fans.facets[fan];
    Beyond beyond;
    if (junctions.facets.empty() || junctions.is_prescribed(facets[0])) return beyond;
    double max_agreement = 0;
    for (const FacetId f : facets)
        for (const EdgeId e : edges.of_facets[f]) {
            if (edges.vertices[e][0] != v && edges.vertices[e][1] != v) continue;
            for (const FacetId g : shells[e]) {
                const Vec<3> normal = junctions.normal(mesh, g, v);
                const double agreement = dot(normal, fitted);
                if (!(std::fabs(agreement) > max_agreement)) continue;
                max_agreement = std::fabs(agreement);
                beyond = {g, agreement < 0 ? -normal : normal};
            }
        }
    if (!beyond.facet.valid()) return beyond;
    const std::uint32_t other = fans.of_facets[beyond.facet][corner_of(mesh.facets.vertices[beyond.facet], v)];
    beyond.tolerance = junction_share * std::max(largest_turn(mesh, edges, features, shells, facets),
                                                 largest_turn(mesh, edges, features, shells, fans.facets[other]));
    return beyond;
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template struct Junctions<D>;                                                                                     \
    template Outcome<Junctions<D>> find_junctions(const LinearMesh<D>&, const EdgeSet<D>&, const Incidence<FacetId>&, \
                                                  const GeometryModel<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
