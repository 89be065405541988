// Boundary facets, ridges and corners of a generated mesh, and random moves of points.
module;
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>
module camber.shapes;
import camber.core;

namespace camber {

namespace {

template <int D>
Outcome<Done> check_volumes(const LinearMesh<D>& mesh, const Execution& execution) {
    const std::size_t n = mesh.elements.size();
    const auto first = reduce_each(
        execution, n, n,
        [&](std::size_t& found, std::size_t e) {
            if (found == n && !(determinant(mesh.points, mesh.elements.vertices[e]) > 0)) found = e;
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (!first) return fail(first.error());
    if (*first == n) return Done{};
    return no_positive_volume<D>(*first);
}

template <int D>
Outcome<std::vector<std::size_t>> elements_near_facets(const LinearMesh<D>& mesh, const Buffer<std::uint8_t>& marked,
                                                       const Execution& execution) {
    return reduce_each(
        execution, mesh.elements.size(), std::vector<std::size_t>{},
        [&](std::vector<std::size_t>& near, std::size_t e) {
            int count = 0;
            for (const VertexId v : mesh.elements.vertices[e]) count += marked[v.index()];
            if (count >= D) near.push_back(e);
        },
        [](std::vector<std::size_t> a, const std::vector<std::size_t>& b) {
            a.insert(a.end(), b.begin(), b.end());
            return a;
        });
}

template <int D>
struct NearFacets {
    LinearMesh<D> mesh;
    Buffer<std::uint8_t> marked;  ///< for each vertex 1 if it may be on a facet
};

template <int D>
Outcome<NearFacets<D>> near_facets(const LinearMesh<D>& mesh, const MayHaveFacets& may_have_facets,
                                   const Execution& execution) {
    auto marked = map_each(execution, mesh.points.size(), [&](std::size_t v) -> std::uint8_t {
        return !may_have_facets || may_have_facets(VertexId(v)) ? 1 : 0;
    });
    if (!marked) return fail(marked.error());
    if (!may_have_facets) return NearFacets<D>{mesh, std::move(*marked)};
    const auto near = elements_near_facets(mesh, *marked, execution);
    if (!near) return fail(near.error());
    Buffer<SimplexVertices<D>> vertices(near->size());
    Buffer<Reference> materials(near->size());
    for (std::size_t k = 0; k < near->size(); ++k) {
        vertices[k] = mesh.elements.vertices[(*near)[k]];
        materials[k] = mesh.elements.references[(*near)[k]];
    }
    NearFacets<D> part{{}, std::move(*marked)};
    part.mesh.points = mesh.points;
    part.mesh.elements = {std::move(vertices), std::move(materials), {}};
    return part;
}

template <int D>
Outcome<Simplices<D - 1>> boundary_facets(const LinearMesh<D>& whole, const FacetReference<D>& facet_reference,
                                          const MayHaveFacets& may_have_facets, const Execution& execution) {
    const auto part = near_facets(whole, may_have_facets, execution);
    if (!part) return fail(part.error());
    const LinearMesh<D>& mesh = part->mesh;
    const auto around = balls(mesh, execution);
    if (!around) return fail(around.error());
    const auto adjacent = neighbours(mesh, *around, execution);
    if (!adjacent) return fail(adjacent.error());
    Buffer<SimplexVertices<D - 1>> vertices;
    Buffer<Reference> references;
    const auto& material = mesh.elements.references;
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
        for (int opposite = 0; opposite <= D; ++opposite) {
            const ElementId other = (*adjacent)[e][opposite];
            if (other.valid() && material[other] <= material[e])
                continue;  // not a facet between materials, or a facet that is added for the element `other`
            SimplexVertices<D - 1> facet;
            const auto local = face_opposite<D>(opposite);
            for (int i = 0; i < D; ++i) facet[i] = mesh.elements.vertices[e][local[i]];
            // A face with an unmarked vertex is no facet. It has no neighbour here only because this mesh is a part of
            // a larger one.
            if (std::any_of(facet.begin(), facet.end(), [&](VertexId v) { return part->marked[v.index()] == 0; }))
                continue;
            vertices.push_back(facet);
            references.push_back(facet_reference(facet));
        }
    return Simplices<D - 1>{std::move(vertices), std::move(references), {}};
}

template <class Key>
using ReferencesAt = std::vector<std::pair<Key, Reference>>;

template <class Key>
void order(ReferencesAt<Key>& at) {
    std::sort(at.begin(), at.end());
    at.erase(std::unique(at.begin(), at.end()), at.end());
}

template <class Key, class F>
void each_key(const ReferencesAt<Key>& at, F&& f) {
    std::vector<Reference> found;
    for (std::size_t i = 0; i < at.size();) {
        found.clear();
        const std::size_t first = i;
        for (; i < at.size() && at[i].first == at[first].first; ++i) found.push_back(at[i].second);
        f(at[first].first, found);
    }
}

template <int D>
ReferencesAt<VertexId> references_at_vertices(const LinearMesh<D>& mesh) {
    ReferencesAt<VertexId> at;
    at.reserve(D * mesh.facets.size());
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (const VertexId v : mesh.facets.vertices[f]) at.emplace_back(v, mesh.facets.references[f]);
    order(at);
    return at;
}

/// Adds an edge where facets of different references meet. Edges get references 1, 2 …, one for each set of facet
/// references.
void add_ridges(LinearMesh<3>& mesh) {
    using Edge = std::array<VertexId, 2>;
    ReferencesAt<Edge> at;
    at.reserve(3 * mesh.facets.size());
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (int i = 0; i < 3; ++i) {
            const auto& facet = mesh.facets.vertices[f];
            const auto [low, high] = std::minmax(facet[i], facet[(i + 1) % 3]);
            at.emplace_back(Edge{low, high}, mesh.facets.references[f]);
        }
    order(at);
    std::map<std::vector<Reference>, Reference> numbers;
    Buffer<Edge> edges;
    each_key(at, [&](const Edge& edge, const std::vector<Reference>& found) {
        if (found.size() < 2) return;
        edges.push_back(edge);
        numbers.try_emplace(found, 0);
    });
    Reference next = 0;
    for (auto& [meeting, number] : numbers) number = ++next;
    Buffer<Reference> references;
    Buffer<std::uint32_t> ridges;
    each_key(at, [&](const Edge&, const std::vector<Reference>& found) {
        if (found.size() < 2) return;
        ridges.push_back(static_cast<std::uint32_t>(references.size()));
        references.push_back(numbers.at(found));
    });
    mesh.edges = {std::move(edges), std::move(references), {}};
    mesh.ridges = std::move(ridges);
}

}  // namespace

template <int D>
Outcome<LinearMesh<D>> bounded_mesh(Buffer<Vec<D>> points, Buffer<SimplexVertices<D>> elements,
                                    Buffer<Reference> materials, const FacetReference<D>& facet_reference,
                                    const MayHaveFacets& may_have_facets, const Execution& execution) {
    LinearMesh<D> mesh;
    const std::size_t count = points.size();
    mesh.points = std::move(points);
    mesh.elements = {std::move(elements), std::move(materials), {}};
    if (auto checked = check_volumes(mesh, execution); !checked) return fail(checked.error());
    auto facets = boundary_facets<D>(mesh, facet_reference, may_have_facets, execution);
    if (!facets) return fail(facets.error());
    mesh.facets = std::move(*facets);
    Buffer<Reference> point_references(count, Reference{0});
    Buffer<VertexId> corners;
    each_key(references_at_vertices(mesh), [&](VertexId v, const std::vector<Reference>& found) {
        point_references[v.index()] = found.front();
        if (found.size() >= std::size_t{D}) corners.push_back(v);
    });
    mesh.point_references = std::move(point_references);
    mesh.corners = std::move(corners);
    if constexpr (D == 3) add_ridges(mesh);
    return mesh;
}

namespace {

double volume(const Buffer<Vec<2>>& p, const SimplexVertices<2>& s) {
    return det(p[s[1].index()] - p[s[0].index()], p[s[2].index()] - p[s[0].index()]);
}
double volume(const Buffer<Vec<3>>& p, const SimplexVertices<3>& s) {
    return det(p[s[1].index()] - p[s[0].index()], p[s[2].index()] - p[s[0].index()], p[s[3].index()] - p[s[0].index()]);
}

/// Marks of vertices. Threads that write a mark at the same time write the same value.
using Marks = std::vector<std::uint8_t>;

template <int D>
struct Move {
    const Buffer<Vec<D>>& from;
    const Buffer<Vec<D>>& to;
    double least = 0;
};

/// Marks in `halve` the vertices of elements whose volume falls below the minimum ratio. Examines only elements with a
/// vertex in `just_moved`. Returns true if there is such an element.
template <int D>
Outcome<bool> mark_shrunk_elements(const Move<D>& move, std::span<const SimplexVertices<D>> elements,
                                   const Marks& just_moved, Marks& halve, const Execution& execution) {
    std::atomic<bool> any = false;
    auto done = each(execution, elements.size(), [&](std::size_t e) {
        const auto& element = elements[e];
        if (std::none_of(element.begin(), element.end(), [&](VertexId v) { return just_moved[v.index()] != 0; }))
            return;
        if (volume(move.to, element) >= move.least * volume(move.from, element)) return;
        any.store(true, std::memory_order_relaxed);
        for (const VertexId v : element) std::atomic_ref(halve[v.index()]).store(1, std::memory_order_relaxed);
    });
    if (!done) return fail(done.error());
    return any.load();
}

}  // namespace

template <int D>
Outcome<Done> move_points(Buffer<Vec<D>>& points, const Moved<D>& moved, const ElementRuns<D>& runs, double least,
                          const Execution& execution) {
    constexpr int halvings = 12;
    static_assert(halvings == rings_of_move);
    auto result = map_each(execution, points.size(), [&](std::size_t v) { return moved(v); });
    if (!result) return fail(result.error());
    Buffer<Vec<D>> at = std::move(*result);
    Marks halved(points.size(), 0);  // for each vertex, how often its move was halved
    Marks just_moved(points.size(), 1);
    for (int round = 0; round < halvings; ++round) {
        Marks halve(points.size(), 0);
        bool any = false;
        auto looked = runs(just_moved, [&](std::span<const SimplexVertices<D>> elements) -> Outcome<Done> {
            const auto some = mark_shrunk_elements<D>({points, at, least}, elements, just_moved, halve, execution);
            if (!some) return fail(some.error());
            any |= *some;
            return Done{};
        });
        if (!looked) return looked;
        if (!any) break;
        auto done = each(execution, points.size(), [&](std::size_t v) {
            if (halve[v] == 0) return;
            const double part = round + 1 == halvings ? 0.0 : std::ldexp(1.0, -++halved[v]);
            at[v] = points[v] + part * (moved(v) - points[v]);
        });
        if (!done) return done;
        just_moved = std::move(halve);
    }
    points = std::move(at);
    return Done{};
}

template <int D>
Outcome<Done> move_points(Buffer<Vec<D>>& points, std::span<const Vec<D>> moved,
                          std::span<const SimplexVertices<D>> elements, double least, const Execution& execution) {
    return move_points<D>(
        points, [&](std::size_t v) { return moved[v]; },
        [&](std::span<const std::uint8_t>, const auto& look) { return look(elements); }, least, execution);
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<LinearMesh<D>> bounded_mesh<D>(Buffer<Vec<D>>, Buffer<SimplexVertices<D>>, Buffer<Reference>,     \
                                                    const FacetReference<D>&, const MayHaveFacets&, const Execution&); \
    template Outcome<Done> move_points<D>(Buffer<Vec<D>>&, const Moved<D>&, const ElementRuns<D>&, double,             \
                                          const Execution&);                                                           \
    template Outcome<Done> move_points<D>(Buffer<Vec<D>>&, std::span<const Vec<D>>,                                    \
                                          std::span<const SimplexVertices<D>>, double, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
