module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.interpolation;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// A facet is flat when its nodes are as near to the plane of its corners, by its longest side: below what moves a
/// layer of anisotropy 10^6, and above rounding and the digits that text files leave out.
constexpr double flat = 1e-9;

/// A face of a bent element, by its rising vertices.
template <int D>
struct BentFace {
    std::array<VertexId, D> vertices;
    ElementFace face;
};

template <int D>
using FaceEdges = std::array<EdgeId, edges_per_simplex<D - 1>>;

/// The edges of the face.
template <int D>
FaceEdges<D> edges_of(const QuadraticMesh<D>& mesh, const ElementFace& face) {
    FaceEdges<D> edges{};
    std::size_t next = 0;
    for (std::size_t k = 0; k < edges_per_simplex<D>; ++k) {
        const auto [i, j] = local_edges<D>[k];
        if (i != static_cast<int>(face.opposite) && j != static_cast<int>(face.opposite))
            edges[next++] = mesh.edges.of_elements[face.element][k];
    }
    return edges;
}

Vec<2> normal(const std::array<Vec<2>, 2>& p) { return {{p[1][1] - p[0][1], p[0][0] - p[1][0]}}; }
Vec<3> normal(const std::array<Vec<3>, 3>& p) { return cross(p[1] - p[0], p[2] - p[0]); }

template <int D>
bool is_flat(const QuadraticMesh<D>& mesh, const BentFace<D>& bent) {
    std::array<Vec<D>, D> corners;
    double longest = 0, largest = 0, highest = 0;
    for (std::size_t i = 0; i < D; ++i) {
        corners[i] = mesh.linear.points[bent.vertices[i]];
        for (int c = 0; c < D; ++c) largest = std::max(largest, std::abs(corners[i][c]));
    }
    const Vec<D> n = normal(corners);
    for (const EdgeId e : edges_of(mesh, bent.face)) {
        const QuadraticEdge<D> edge = edge_of(mesh, e);
        longest = std::max(longest, norm(edge.chord()));
        highest = std::max(highest, std::abs(dot(edge.offset(), n)));
    }
    // Not where corners are in line: they have no plane.
    return norm(n) > 0 && highest <= (flat * longest + 8 * std::numeric_limits<double>::epsilon() * largest) * norm(n);
}

template <int D>
std::vector<BentFace<D>> faces_of(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& bent) {
    std::vector<BentFace<D>> faces;
    for (const std::uint32_t e : bent)
        for (std::uint32_t opposite = 0; opposite <= D; ++opposite) {
            BentFace<D> face{{}, {ElementId(std::size_t{e}), opposite}};
            const auto local = face_opposite<D>(static_cast<int>(opposite));
            for (std::size_t i = 0; i < D; ++i)
                face.vertices[i] = mesh.linear.elements.vertices[e][static_cast<std::size_t>(local[i])];
            std::sort(face.vertices.begin(), face.vertices.end());
            if (!is_flat(mesh, face)) faces.push_back(face);
        }
    std::sort(faces.begin(), faces.end(), [](const auto& a, const auto& b) { return a.vertices < b.vertices; });
    return faces;
}

/// Of one element alone, or between two of different references.
template <int D>
bool bounds(const LinearMesh<D>& mesh, std::span<const BentFace<D>> same) {
    const auto reference = [&](const BentFace<D>& f) { return mesh.elements.references[f.face.element]; };
    return same.size() == 1 || (same.size() == 2 && reference(same[0]) != reference(same[1]));
}

}  // namespace

template <int D>
bool is_straight(const QuadraticMesh<D>& mesh, std::size_t e) {
    const auto& edges = mesh.edges.of_elements[e];
    return std::all_of(edges.begin(), edges.end(), [&](EdgeId edge) {
        const auto& [a, b] = mesh.edges.vertices[edge];
        return mesh.mid_nodes[edge].point == midpoint(mesh.linear.points[a], mesh.linear.points[b]);
    });
}

template <int D>
std::vector<std::uint32_t> bent_elements(const QuadraticMesh<D>& mesh) {
    std::vector<std::uint32_t> bent;
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e)
        if (!is_straight(mesh, e)) bent.push_back(static_cast<std::uint32_t>(e));
    return bent;
}

template <int D>
std::optional<QuadraticMesh<D>> straight_inside(const QuadraticMesh<D>& mesh, const std::vector<std::uint32_t>& bent) {
    // The element across a face that is not flat is bent, too: the bent ones alone know what bounds the mesh.
    const std::vector<BentFace<D>> faces = faces_of(mesh, bent);
    std::vector<EdgeId> kept;
    for (std::size_t first = 0, last = 0; first < faces.size(); first = last) {
        while (last < faces.size() && faces[last].vertices == faces[first].vertices) ++last;
        if (!bounds<D>(mesh.linear, std::span(faces).subspan(first, last - first))) continue;
        const auto edges = edges_of(mesh, faces[first].face);
        kept.insert(kept.end(), edges.begin(), edges.end());
    }
    if (kept.empty()) return {};
    Buffer<LagrangeNode<D>> nodes(mesh.mid_nodes.size());
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        nodes[e].point = midpoint(mesh.linear.points[a], mesh.linear.points[b]);
    }
    for (const EdgeId e : kept) nodes[e.index()] = mesh.mid_nodes[e];
    QuadraticMesh<D> inside = mesh;
    inside.mid_nodes = std::move(nodes);
    return inside;
}

#define CAMBER_INSTANTIATE(D)                                                            \
    template bool is_straight<D>(const QuadraticMesh<D>&, std::size_t);                  \
    template std::vector<std::uint32_t> bent_elements<D>(const QuadraticMesh<D>&);       \
    template std::optional<QuadraticMesh<D>> straight_inside<D>(const QuadraticMesh<D>&, \
                                                                const std::vector<std::uint32_t>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
