module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

template <int D>
std::size_t local(const LinearMesh<D>& mesh, FacetId f, VertexId v) {
    const auto& vertices = mesh.facets.vertices[f];
    return static_cast<std::size_t>(std::find(vertices.begin(), vertices.end(), v) - vertices.begin());
}

template <int D>
double angle_between(const Vec<D>& a, const Vec<D>& b) {
    return atan2(norm(a - b), norm(a + b)) * 2;
}

/// Facets whose sides agree go along their edge in opposite directions (2D: one ends where the other begins).
template <int D>
bool sides_agree(const LinearMesh<D>& mesh, const std::array<FacetId, 2>& facets, VertexId a, VertexId b) {
    const auto goes = [&](FacetId f) {
        return D == 2 ? local(mesh, f, a) == 0 : (local(mesh, f, a) + 1) % D == local(mesh, f, b);
    };
    return goes(facets[0]) != goes(facets[1]);
}

/// Two facets that a patch goes on between, at an edge from a to b; in 2D at the vertex a.
struct Passage {
    std::array<FacetId, 2> facets;
    VertexId a, b;
};

Outcome<std::vector<Passage>> passages_of(const LinearMesh<3>&, const EdgeSet<3>& edges, const Features<3>& features,
                                          const Execution& execution) {
    const auto shells = facet_shells(edges, execution);
    if (!shells) return fail(shells.error());
    std::vector<Passage> out;
    for (std::size_t e = 0; e < edges.size(); ++e)
        if (features.edge_kinds[e] == EdgeKind::surface && (*shells)[EdgeId(e)].size() == 2) {
            const auto shell = (*shells)[EdgeId(e)];
            out.push_back({{shell[0], shell[1]}, edges.vertices[e][0], edges.vertices[e][1]});
        }
    return out;
}
Outcome<std::vector<Passage>> passages_of(const LinearMesh<2>& mesh, const EdgeSet<2>&, const Features<2>& features,
                                          const Execution&) {
    std::vector<Passage> out;
    std::vector<FacetId> first(mesh.points.size());
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (const VertexId v : mesh.facets.vertices[f]) {
            if (features.vertex_kinds[v] == VertexKind::corner) continue;
            FacetId& other = first[v.index()];
            if (other.valid())
                out.push_back({{other, FacetId(f)}, v, v});
            else
                other = FacetId(f);
        }
    return out;
}

}  // namespace

template <int D>
Outcome<std::vector<Kinks>> kinks_of(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Features<D>& features,
                                     const NormalOfFacet<D>& normal, const Execution& execution) {
    const auto passages = passages_of(mesh, edges, features, without_progress(execution));
    if (!passages) return fail(passages.error());
    const auto at = map_each(execution, passages->size(), [&](std::size_t i) {
        const auto& [facets, a, b] = (*passages)[i];
        const double side = sides_agree(mesh, facets, a, b) ? 1 : -1;
        Kinks here;
        for (const double t : {0.0, 0.5, 1.0}) {
            if (D == 2 && t != 0) continue;
            const auto seen = [&, from = a, to = b](FacetId f) {
                Barycentric<D - 1> xi{};
                xi[local(mesh, f, from)] = 1 - t;
                if (D == 3) xi[local(mesh, f, to)] = t;
                return normal(f, xi);
            };
            here.add(angle_between(seen(facets[0]), side * seen(facets[1])));
        }
        return here;
    });
    if (!at) return fail(at.error());
    std::vector<Kinks> of_patches(features.patch_count);
    for (std::size_t i = 0; i < passages->size(); ++i)
        of_patches[features.patches[(*passages)[i].facets[0]]].add((*at)[i]);
    return of_patches;
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template Outcome<std::vector<Kinks>> kinks_of(const LinearMesh<D>&, const EdgeSet<D>&, const Features<D>&, \
                                                  const NormalOfFacet<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
