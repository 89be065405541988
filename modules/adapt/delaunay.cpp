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

template <int D>
bool is_in_metric_sphere(const Adaptation<D>& r, ElementId e, const Vec<D>& point, const MeasuringMetric<D>& metric) {
    // Seen from the point, where the metric is the identity: the vertices' differences y_i to it. The origin lies in
    // the sphere through them where their lifted determinant |y_i, |y_i|²| has the sign of the element's volume.
    std::array<Vec<D>, D + 1> y;
    std::array<double, D + 1> squares{};
    for (int i = 0; i <= D; ++i) {
        const Vec<D> x = r.mesh.points[r.mesh.elements.vertices[e][i]] - point;
        for (int k = 0; k < D; ++k) y[i][k] = dot(metric.rows[k], x);
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

}  // namespace

template <int D>
void grow_delaunay(const Adaptation<D>& r, const Vec<D>& point, const MeasuringMetric<D>& metric, std::size_t most,
                   double shortest, Cavity<D>& cavity) {
    auto& elements = cavity.elements;
    for (std::size_t i = 0; i < elements.size() && elements.size() < most; ++i)
        for (int face = 0; face <= D && elements.size() < most; ++face) {
            const FaceNeighbour across = r.mesh.face_neighbours[elements[i]][face];
            if (!across.valid() || !across.is_element()) continue;
            const ElementId next = across.element();
            if (is_among(elements, next) || !is_in_metric_sphere(r, next, point, metric)) continue;
            const VertexId v = vertex_beyond(r.mesh, elements[i], next);
            if (edge_length(metric, r.vertices.metrics[v].measure, r.mesh.points[v] - point) < shortest) continue;
            elements.push_back(next);
        }
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template bool is_in_metric_sphere<D>(const Adaptation<D>&, ElementId, const Vec<D>&, const MeasuringMetric<D>&); \
    template void grow_delaunay<D>(const Adaptation<D>&, const Vec<D>&, const MeasuringMetric<D>&, std::size_t,      \
                                   double, Cavity<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
