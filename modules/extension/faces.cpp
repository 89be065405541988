// Extends displacements of curves over the faces that they bound.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
module camber.extension;
import camber.core;

namespace camber {

namespace {

/// Triangles of one face and their edges. An edge on a curve is listed once per triangle, because its displacement
/// depends on the face.
struct FaceTriangles {
    Buffer<SimplexVertices<2>> triangles;
    Buffer<std::array<EdgeId, 3>> of_triangles;
    Buffer<std::array<VertexId, 2>> ends;
    Buffer<EdgeKind> kinds;      ///< `volume`: the edge's node is an unknown
    std::vector<EdgeId> inside;  ///< mesh edges of the unknowns, numbered before the edges on curves
    struct OnCurve {
        EdgeId edge;
        FacetId facet;
    };
    std::vector<OnCurve> on_curves;
};

std::vector<std::vector<FacetId>> connected_faces(const EdgeSet<3>& edges, const Faces& faces) {
    std::vector<std::size_t> root(faces.facets.size());
    std::iota(root.begin(), root.end(), std::size_t{0});
    const auto find = [&](std::size_t f) {
        while (root[f] != f) f = root[f] = root[root[f]];
        return f;
    };
    std::vector<FacetId> first(edges.size());
    for (std::size_t f = 0; f < root.size(); ++f) {
        if (faces.facets[f] == 0) continue;
        for (const EdgeId e : edges.of_facets[f]) {
            if (faces.inside[e.index()] == 0) continue;
            FacetId& other = first[e.index()];
            if (!other.valid()) other = FacetId(f);
            const std::size_t one = find(f), another = find(other.index());
            root[std::max(one, another)] = std::min(one, another);
        }
    }
    std::vector<std::vector<FacetId>> connected;
    std::vector<std::size_t> number(root.size(), root.size());
    for (std::size_t f = 0; f < root.size(); ++f) {
        if (faces.facets[f] == 0) continue;
        std::size_t& of_face = number[find(f)];
        if (of_face == root.size()) {
            of_face = connected.size();
            connected.emplace_back();
        }
        connected[of_face].emplace_back(f);
    }
    return connected;
}

/// `own`: buffer with the number of each mesh edge in this face; reused for the next face.
FaceTriangles triangles_of(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Faces& faces,
                           std::span<const FacetId> facets, std::vector<EdgeId>& own) {
    FaceTriangles out;
    for (const FacetId f : facets)
        for (const EdgeId e : edges.of_facets[f])
            if (faces.inside[e.index()] != 0) out.inside.push_back(e);
    std::ranges::sort(out.inside);
    const auto repeated = std::ranges::unique(out.inside);
    out.inside.erase(repeated.begin(), repeated.end());
    const auto add = [&](EdgeId e, EdgeKind kind) {
        out.ends.push_back(edges.vertices[e]);
        out.kinds.push_back(kind);
        return EdgeId(out.ends.size() - 1);
    };
    for (const EdgeId e : out.inside) own[e.index()] = add(e, EdgeKind::volume);
    for (const FacetId f : facets) {
        std::array<EdgeId, 3> of_triangle;
        for (std::size_t k = 0; k < 3; ++k) {
            const EdgeId e = edges.of_facets[f][k];
            if (faces.inside[e.index()] != 0) {
                of_triangle[k] = own[e.index()];
            } else {
                of_triangle[k] = add(e, EdgeKind::fixed);
                out.on_curves.push_back({e, f});
            }
        }
        out.triangles.push_back(mesh.facets.vertices[f]);
        out.of_triangles.push_back(of_triangle);
    }
    return out;
}

Outcome<Done> extend_over_face(const LinearMesh<3>& mesh, FaceTriangles face,
                               const std::function<Vec<3>(FacetId, EdgeId)>& input, FaceShifts& shifts,
                               const Execution& execution) {
    const std::size_t unknowns = face.inside.size();
    if (unknowns == 0 || face.on_curves.empty()) return Done{};
    const Execution quiet = without_progress(execution);
    const auto middle = [&](std::size_t i) {
        return midpoint(mesh.points[face.ends[i][0]], mesh.points[face.ends[i][1]]);
    };
    auto nodes = map_each(quiet, face.ends.size(), [&](std::size_t i) {
        if (i < unknowns) return LagrangeNode<3>{middle(i)};
        const auto& [edge, facet] = face.on_curves[i - unknowns];
        return LagrangeNode<3>{middle(i) + input(facet, edge)};
    });
    if (!nodes) return fail(nodes.error());
    const EdgeSet<2> own{face.ends, std::move(face.of_triangles), {}, {}};
    const Column<SimplexVertices<2>> simplices(std::move(face.triangles));
    const Column<EdgeKind> kinds(std::move(face.kinds));
    const auto around = shells(own, quiet);
    if (!around) return fail(around.error());
    auto extended = extend_displacement(ExtensionDomain<2, 3>{mesh.points, simplices, own}, kinds,
                                        Column<LagrangeNode<3>>(std::move(*nodes)), *around,
                                        ExtensionOptions{.stiffening = 1}, quiet);
    if (!extended) return fail(extended.error());
    for (std::size_t i = 0; i < unknowns; ++i) {
        const Vec<3> shift = extended->nodes[i].point - middle(i);
        if (shift == Vec<3>{}) continue;
        shifts.edges.push_back(face.inside[i]);
        shifts.shifts.push_back(shift);
    }
    return Done{};
}

}  // namespace

Outcome<FaceShifts> extend_over_triangles(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Faces& faces,
                                          const std::function<Vec<3>(FacetId, EdgeId)>& input,
                                          const Execution& execution) {
    return guarded([&]() -> Outcome<FaceShifts> {
        FaceShifts shifts;
        std::vector<EdgeId> own(edges.size());
        for (const std::vector<FacetId>& facets : connected_faces(edges, faces)) {
            auto done = extend_over_face(mesh, triangles_of(mesh, edges, faces, facets, own), input, shifts, execution);
            if (!done) return fail(done.error());
        }
        return shifts;
    });
}

}  // namespace camber
