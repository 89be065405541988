module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.soundness;
import camber.core;
import camber.validity;
import :examination;

namespace camber {

namespace {

/// The boundary's faces; those of a mesh without elements are its facets.
template <int D>
Column<SimplexVertices<D - 1>> boundary_of(const LinearMesh<D>& mesh, const Examination<D>& x) {
    Buffer<SimplexVertices<D - 1>> faces;
    faces.reserve(mesh.facets.size());
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        if (!x.element_counts(e)) continue;
        for (int i = 0; i <= D; ++i)
            if (x.neighbours[e][i] == nobody) faces.push_back(face_of<D>(mesh.elements.vertices[e], i));
    }
    if (mesh.elements.vertices.empty())
        for (std::size_t f = 0; f < mesh.facets.size(); ++f)
            if (x.facet_counts(f)) faces.push_back(mesh.facets.vertices[f]);
    return faces;
}

/// Edges to blame at a vertex, of those that lead to higher vertices, and the first one's end.
struct Blamed {
    std::uint32_t count = 0;
    VertexId first_end;

    void add(VertexId end) {
        if (count++ == 0) first_end = end;
    }
};

/// What the faces around a vertex look like: edges of more than two of them, edges of one alone, and whether the faces
/// are more than one fan though no edge is to blame.
struct Link {
    Blamed crowded, open;
    bool pinched = false;
};

/// In 2D the faces around a vertex are edges, and two are right.
Link link_of(const Column<SimplexVertices<1>>&, std::span<const FacetId> around, VertexId v) {
    Link link;
    link.pinched = around.size() > 2;
    if (around.size() == 1) link.open.add(v);
    return link;
}

/// In 3D each triangle at v has a side opposite v; these sides must be one path or one ring.
Link link_of(const Column<SimplexVertices<2>>& faces, std::span<const FacetId> around, VertexId v) {
    std::vector<std::array<VertexId, 2>> sides;
    std::vector<VertexId> ends;
    sides.reserve(around.size());
    ends.reserve(2 * around.size());
    for (const FacetId f : around) {
        std::array<VertexId, 2> side;
        int n = 0;
        for (const VertexId w : faces[f])
            if (w != v && n < 2) ends.push_back(side[static_cast<std::size_t>(n++)] = w);
        sides.push_back(side);
    }
    std::sort(ends.begin(), ends.end());
    Link link;
    bool any_crowded = false;
    for (auto run = ends.begin(); run != ends.end();) {
        const auto next = std::upper_bound(run, ends.end(), *run);
        if (next - run > 2) {
            any_crowded = true;
            if (*run > v) link.crowded.add(*run);
        }
        if (next - run == 1 && *run > v) link.open.add(*run);
        run = next;
    }
    if (any_crowded || around.empty()) return link;
    // Each end has at most two sides: walk from the first side in both directions.
    std::vector<std::size_t> reached{0};
    std::vector<bool> seen(sides.size(), false);
    seen[0] = true;
    for (std::size_t at = 0; at < reached.size(); ++at)
        for (std::size_t s = 0; s < sides.size(); ++s)
            if (!seen[s] && (has(sides[reached[at]], sides[s][0]) || has(sides[reached[at]], sides[s][1]))) {
                seen[s] = true;
                reached.push_back(s);
            }
    link.pinched = reached.size() < sides.size();
    return link;
}

Finding edges_to_blame(const Buffer<Link>& links, Blamed Link::* which) {
    Finding found;
    for (std::size_t v = 0; v < links.size(); ++v) {
        const Blamed& blamed = links[v].*which;
        if (blamed.count == 0) continue;
        if (found.count == 0) found = {0, v + 1, blamed.first_end.index() + 1};
        found.count += blamed.count;
    }
    return found;
}

}  // namespace

template <int D>
Outcome<Done> examine_boundary(const LinearMesh<D>& mesh, Examination<D>& x, const Execution& execution) {
    LinearMesh<D> surface;
    surface.points = mesh.points;
    surface.facets.vertices = boundary_of(mesh, x);
    auto around = facet_balls(surface, execution);
    if (!around) return fail(around.error());
    auto links = map_each(execution, mesh.points.size(),
                          [&](std::size_t v) { return link_of(surface.facets.vertices, (*around)[v], VertexId(v)); });
    if (!links) return fail(links.error());
    auto pinched = count(execution, links->size(), [&](std::size_t v) { return (*links)[v].pinched; });
    if (!pinched) return fail(pinched.error());
    x[Defect::pinched_vertex] = *pinched;
    x[Defect::crowded_edge] = edges_to_blame(*links, &Link::crowded);
    x[Defect::open_edge] = edges_to_blame(*links, &Link::open);
    return Done{};
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Done> examine_boundary<D>(const LinearMesh<D>&, Examination<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
