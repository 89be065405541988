module;
#include <algorithm>
#include <array>
#include <cstddef>
module camber.adapt;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;

namespace camber {

namespace {

/// Whether the origin lies in the sphere whose equator goes through the corners of a triangle.
bool is_origin_in_sphere(const std::array<Vec<3>, 3>& y) {
    const Vec<3> u = y[1] - y[0];
    const Vec<3> v = y[2] - y[0];
    const Vec<3> n = cross(u, v);
    const double area = norm_squared(n);
    if (!(area > 0)) return false;
    const Vec<3> to_centre = (norm_squared(u) * cross(v, n) + norm_squared(v) * cross(n, u)) / (2 * area);
    return norm_squared(y[0] + to_centre) < norm_squared(to_centre);
}

}  // namespace

template <int D>
bool is_in_metric_sphere(const Adaptation<D>& r, ElementId e, const ConePoint<D>& point, BentSpokes<D>& spokes) {
    spokes.begin(point);
    for (const VertexId v : r.mesh.elements.vertices[e]) spokes.add(v, r.mesh.points[v], r.vertices.metrics[v]);
    spokes.bend();
    if constexpr (D == 3)
        if (r.mesh.is_surface()) {
            std::array<Vec<3>, 3> y;
            for (int i = 0; i < 3; ++i)
                for (int k = 0; k < 3; ++k)
                    y[i][k] = dot(point.metric->measure.rows[k], spokes.tangent(static_cast<std::size_t>(i)));
            return is_origin_in_sphere(y);
        }
    // Seen from the point, where the metric is the identity: the vertices' differences y_i to it. The origin lies in
    // the sphere through them where their lifted determinant |y_i, |y_i|²| has the sign of the element's volume.
    std::array<Vec<D>, D + 1> y;
    std::array<double, D + 1> squares{};
    for (int i = 0; i <= D; ++i) {
        const Vec<D> x = spokes.tangent(static_cast<std::size_t>(i));
        for (int k = 0; k < D; ++k) y[i][k] = dot(point.metric->measure.rows[k], x);
        squares[i] = norm_squared(y[i]);
    }
    // Expanded along the last column; volumes of the simplices of the point and a face, outward faces.
    double lifted = 0;
    double volume = 0;
    for (int i = 0; i <= D; ++i) {
        const auto face = face_opposite<D>(i);
        Mat<D> sides;
        for (int k = 0; k < D; ++k) sides.column[k] = y[face[k]];
        const double part = det(sides);
        lifted += part * squares[i];
        volume += part;
    }
    return volume > 0 ? lifted > 0 : lifted < 0;
}

namespace {

/// The vertex of `next` that `from` does not have, where they share a face.
template <int D>
VertexId vertex_beyond(const DynamicMesh<D>& mesh, ElementId from, ElementId next) {
    const auto& faces = mesh.face_neighbours[next];
    for (int i = 0; i <= D; ++i)
        if (faces[i] == FaceNeighbour(from)) return mesh.elements.vertices[next][i];
    return {};
}

/// Of a surface alone: whether it breaks at the edge through which a face leads to the next triangle.
template <int D>
bool breaks_across(const DynamicMesh<D>& mesh, ElementId e, int face) {
    if (!mesh.is_surface() || face == D) return false;
    return mesh.line_at(mesh.edges_of[e][edge_between<D>[(face + 1) % 3][(face + 2) % 3]]).valid();
}

}  // namespace

template <int D>
void grow_delaunay(const Adaptation<D>& r, const ConePoint<D>& point, BentSpokes<D>& spokes, std::size_t most,
                   double shortest, Cavity<D>& cavity) {
    auto& elements = cavity.elements;
    for (std::size_t i = 0; i < elements.size() && elements.size() < most; ++i)
        for (int face = 0; face <= D && elements.size() < most; ++face) {
            const FaceNeighbour across = r.mesh.face_neighbours[elements[i]][face];
            if (!across.valid() || !across.is_element() || breaks_across(r.mesh, elements[i], face)) continue;
            const ElementId next = across.element();
            if (is_among(elements, next) || !is_in_metric_sphere(r, next, point, spokes)) continue;
            const VertexId v = vertex_beyond(r.mesh, elements[i], next);
            const int at = local_vertex(r.mesh.elements.vertices[next], v);
            if (spokes.length(static_cast<std::size_t>(at)) < shortest) continue;
            join(r.mesh, cavity, next);
        }
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template bool is_in_metric_sphere<D>(const Adaptation<D>&, ElementId, const ConePoint<D>&, BentSpokes<D>&);    \
    template void grow_delaunay<D>(const Adaptation<D>&, const ConePoint<D>&, BentSpokes<D>&, std::size_t, double, \
                                   Cavity<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
