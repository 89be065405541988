module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>
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

/// The vertices that are looked at from a point, each once. Where the edges to the first are little bent, chords to the
/// others: whether a sphere holds the point they tell as well, and the curves are bent for those that the star has.
template <int D>
class SeenVertices {
  public:
    SeenVertices(const Adaptation<D>& r, BentSpokes<D>& spokes)
        : r_(r), spokes_(spokes), is_bent_(!spokes.are_little_bent()) {
        for (std::size_t i = 0; i < spokes.size(); ++i) push(spokes.vertex(i), spokes.tangent(i));
    }
    void add(VertexId v) {
        if (is_among(vertices_, v)) return;
        push(v, r_.mesh.points[v] - spokes_.point().place);
        if (is_bent_) spokes_.add(v, r_.mesh.points[v], r_.vertices.metrics[v]);
    }
    /// An edge costs less where many are bent together.
    void bend() {
        if (!is_bent_) return;
        spokes_.bend();
        for (std::size_t i = 0; i < tangents_.size(); ++i) tangents_[i] = spokes_.tangent(i);
    }
    [[nodiscard]] const Vec<D>& tangent(VertexId v) const { return tangents_[index_of(v)]; }
    [[nodiscard]] double length(VertexId v) const {
        const std::size_t i = index_of(v);
        if (i < spokes_.size()) return spokes_.length(i);
        if (r_.mesh.is_at_infinity(v)) return length_to_infinity;
        return edge_length(spokes_.point().metric->measure, r_.vertices.metrics[v].measure, tangents_[i]);
    }

  private:
    void push(VertexId v, const Vec<D>& tangent) {
        vertices_.push_back(v);
        tangents_.push_back(tangent);
    }
    [[nodiscard]] std::size_t index_of(VertexId v) const {
        return static_cast<std::size_t>(std::ranges::find(vertices_, v) - vertices_.begin());
    }
    const Adaptation<D>& r_;
    BentSpokes<D>& spokes_;
    bool is_bent_;
    std::vector<VertexId> vertices_;
    std::vector<Vec<D>> tangents_;
};

/// Whether a point lies in the sphere (2D: circle) through an element's vertices, in the point's own metric.
template <int D>
bool is_in_metric_sphere(const Adaptation<D>& r, ElementId e, const ConePoint<D>& point, const SeenVertices<D>& seen) {
    const auto& vertices = r.mesh.elements.vertices[e];
    if constexpr (D == 3)
        if (r.mesh.is_surface()) {
            std::array<Vec<3>, 3> y;
            for (int i = 0; i < 3; ++i)
                for (int k = 0; k < 3; ++k) y[i][k] = dot(point.metric->measure.rows[k], seen.tangent(vertices[i]));
            return is_origin_in_sphere(y);
        }
    // Seen from the point, where the metric is the identity: the vertices' differences y_i to it. The origin lies in
    // the sphere through them where their lifted determinant |y_i, |y_i|²| has the sign of the element's volume.
    std::array<Vec<D>, D + 1> y;
    std::array<double, D + 1> squares{};
    for (int i = 0; i <= D; ++i) {
        const Vec<D> x = seen.tangent(vertices[i]);
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

/// Of a surface alone: whether it breaks at the edge through which a face leads to the next triangle.
template <int D>
bool breaks_across(const DynamicMesh<D>& mesh, ElementId e, int face) {
    if (!mesh.is_surface() || face == D) return false;
    return mesh.line_at(mesh.edges_of[e][edge_between<D>[(face + 1) % 3][(face + 2) % 3]]).valid();
}

/// The element that a cavity may grow into across a face; invalid: none.
template <int D>
ElementId beyond(const DynamicMesh<D>& mesh, ElementId e, int face) {
    const FaceNeighbour across = mesh.face_neighbours[e][face];
    const bool is_open = across.valid() && across.is_element() && !breaks_across(mesh, e, face);
    return is_open ? across.element() : ElementId{};
}

/// Its vertices, and those of its neighbours.
template <int D>
void see_around(const DynamicMesh<D>& mesh, ElementId e, SeenVertices<D>& seen) {
    for (const VertexId v : mesh.elements.vertices[e]) seen.add(v);
    for (int face = 0; face <= D; ++face)
        if (const ElementId next = beyond(mesh, e, face); next.valid()) seen.add(vertex_apart(mesh, next, e));
}

}  // namespace

template <int D>
void grow_delaunay(const Adaptation<D>& r, BentSpokes<D>& spokes, std::size_t most, double shortest,
                   Cavity<D>& cavity) {
    auto& elements = cavity.elements;
    const ConePoint<D>& point = spokes.point();
    SeenVertices<D> seen(r, spokes);
    std::size_t seen_around = 0;  // so many of them
    for (std::size_t i = 0; i < elements.size() && elements.size() < most; ++i) {
        if (i == seen_around) {
            for (; seen_around < elements.size(); ++seen_around) see_around(r.mesh, elements[seen_around], seen);
            seen.bend();
        }
        for (int face = 0; face <= D && elements.size() < most; ++face) {
            const ElementId next = beyond(r.mesh, elements[i], face);
            if (!next.valid() || is_among(elements, next) || !is_in_metric_sphere(r, next, point, seen)) continue;
            if (!(seen.length(vertex_apart(r.mesh, next, elements[i])) < shortest)) join(r.mesh, cavity, next);
        }
    }
}

#define CAMBER_INSTANTIATE(D) \
    template void grow_delaunay<D>(const Adaptation<D>&, BentSpokes<D>&, std::size_t, double, Cavity<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
