// Shapes of the straight and curved elements of a star. The shape of a simplex is a measure of its quality.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory_resource>
#include <span>
#include <utility>
export module camber.adapt:cone_shapes;
import camber.core;
import camber.cavity;
import camber.metric;
import camber.edge_optimisation;
import camber.operation;

export namespace camber {

/// The point of a star: position, metric and, in degree 2, gradient of the field.
template <int D>
struct ConePoint {
    Vec<D> place;
    const VertexMetric<D>* metric = nullptr;
    const LogGradient<D>* gradient = nullptr;  ///< null in degree 1
    VertexPlace lies = VertexPlace::inside;
};
template <int D>
[[nodiscard]] ConePoint<D> cone_point(const Adaptation<D>& r, VertexId v) {
    return {r.mesh.points[v], &r.vertices.metrics[v], r.vertices.gradients.empty() ? nullptr : &r.vertices.gradients[v],
            r.mesh.states[v].place};
}
/// Measure of an edge for `shape_of`. Degree 1: sum of its squared lengths in the metrics of both ends. Degree 2: twice
/// the squared length of the curve.
template <int D>
[[nodiscard]] double squares_between(const Adaptation<D>& r, const VertexMetric<D>& a, const VertexMetric<D>& b,
                                     const Vec<D>& chord, const Vec<D>& offset) {
    if (!r.mesh.is_curved()) return a.measure.length_squared(chord) + b.measure.length_squared(chord);
    const double length = quadratic_edge_length<D>(end_of(a), end_of(b), chord, offset);
    return 2 * length * length;
}
template <int D>
[[nodiscard]] double squares_of(const Adaptation<D>& r, EdgeId edge) {
    const double length = length_of(r, edge);
    return 2 * length * length;
}

template <int D>
void fetch_edges_ahead(const Adaptation<D>& r, std::span<const ElementId> elements) {
    if (!r.mesh.is_curved()) return;
    for (const ElementId e : elements) __builtin_prefetch(&r.mesh.edges_of[e]);
    for (const ElementId e : elements)
        for (const EdgeId edge : r.mesh.edges_of[e]) {
            __builtin_prefetch(&r.mesh.nodes[edge]);
            __builtin_prefetch(&r.lengths[edge]);
        }
}

template <std::size_t Bytes>
struct StackMemory {
    alignas(std::max_align_t) std::array<std::byte, Bytes> bytes;
    std::pmr::monotonic_buffer_resource memory{bytes.data(), bytes.size()};
};

/// Edges from a point to vertices. Degree 1: straight edges. Degree 2: curved edges by `bent_edges`, as in a star. If
/// the point and the vertex are on the boundary, the edge may be a boundary edge; it is then straight.
template <int D>
class BentSpokes {
  public:
    BentSpokes(const Adaptation<D>& r, const AdaptationGoal<D>& goal) : r_(r), goal_(goal) {
        to_.reserve(usual_vertices);
        chords_.reserve(usual_vertices);
        squares_.reserve(usual_vertices);
        if (!r.mesh.is_curved()) return;
        offsets_.reserve(usual_vertices);
        ends_.reserve(usual_vertices);
    }

    void begin(const ConePoint<D>& point) {
        point_ = point;
        has_stored_ = false;
        offsets_.clear();
        chords_.clear();
        squares_.clear();
        to_.clear();
    }
    void add(VertexId v, const Vec<D>& place, const VertexMetric<D>& metric) {
        to_.push_back({v, &metric});
        chords_.push_back(place - point_.place);
    }
    void bend() {
        const std::size_t first = squares_.size(), added = to_.size() - first;
        squares_.resize(to_.size(), unknown);
        if (!r_.mesh.is_curved()) return;
        offsets_.resize(to_.size());
        ends_.clear();
        for (std::size_t i = first; i < to_.size(); ++i)
            ends_.push_back({end_sample_of(*point_.metric, *point_.gradient),
                             end_sample_of(*to_[i].metric, r_.vertices.gradients[to_[i].vertex])});
        bent_edges<D>(std::span(chords_).last(added), ends_, goal_.accuracy, std::span(offsets_).last(added),
                      std::span(squares_).last(added));
        for (double& length : std::span(squares_).last(added)) length *= 2 * length;
        straighten_boundary(first);
    }
    /// Takes existing edges of the mesh, one for each vertex. Degree 2: edges that may be on the boundary are replaced
    /// by their chords, as in `bend`.
    void take_edges(std::span<const EdgeId> edges) {
        squares_.assign(to_.size(), unknown);
        if (!r_.mesh.is_curved()) return;
        offsets_.resize(to_.size());
        for (std::size_t i = 0; i < to_.size(); ++i) {
            offsets_[i] = offset_of(r_.mesh, edges[i]);
            squares_[i] = squares_of(r_, edges[i]);
        }
        straighten_boundary(0);
    }

    /// True if 4 times the offset of each edge is at most 0.3 times the edge's length, in the point's metric.
    [[nodiscard]] bool are_nearly_straight() {
        if (!r_.mesh.is_curved()) return true;
        constexpr double little = 0.3;
        for (std::size_t i = 0; i < to_.size(); ++i)
            if (point_.metric->measure.length_squared(4.0 * offsets_[i]) > little * little * squares(i) / 2)
                return false;
        return true;
    }
    /// Moves the point and leaves the offsets unchanged. This is nearly exact for small moves, and much cheaper. The
    /// caller must then call `put_chord` for each edge.
    void move(const ConePoint<D>& point) {
        point_ = point;
        has_stored_ = true;
        squares_.assign(to_.size(), unknown);
    }
    void put_chord(std::size_t i, const Vec<D>& place) { chords_[i] = place - point_.place; }

    /// Degree 2: stores the edges in a request, except those that may be on the boundary.
    void set_edges(CavityRequest<D>& request) const {
        if (!r_.mesh.is_curved()) return;
        request.bent.reserve(to_.size());
        for (std::size_t i = 0; i < to_.size(); ++i)
            if (!is_boundary_likely(i))
                request.bent.push_back({to_[i].vertex, offsets_[i], std::sqrt(squares_[i] / 2)});
    }
    [[nodiscard]] std::size_t size() const { return to_.size(); }
    [[nodiscard]] VertexId vertex(std::size_t i) const { return to_[i].vertex; }

    [[nodiscard]] const ConePoint<D>& point() const { return point_; }
    [[nodiscard]] double density_root() const { return point_.metric->measure.density_root; }
    /// Tangent of edge i at the point (`tangent`) or at the vertex (`tangent_back`). Its length is that of the chord if
    /// the edge is straight.
    [[nodiscard]] Vec<D> tangent(std::size_t i) const {
        return r_.mesh.is_curved() ? chords_[i] + 4.0 * offsets_[i] : chords_[i];
    }
    [[nodiscard]] Vec<D> tangent_back(std::size_t i) const { return 4.0 * offsets_[i] - chords_[i]; }
    [[nodiscard]] double squares(std::size_t i) {
        if (squares_[i] != unknown) return squares_[i];
        const VertexMetric<D>& there = *to_[i].metric;
        if (r_.mesh.is_curved() && has_stored_)
            squares_[i] =
                point_.metric->measure.length_squared(tangent(i)) + there.measure.length_squared(tangent_back(i));
        else
            squares_[i] =
                squares_between(r_, *point_.metric, there, chords_[i], r_.mesh.is_curved() ? offsets_[i] : Vec<D>{});
        return squares_[i];
    }
    [[nodiscard]] double length(std::size_t i) {
        if (r_.mesh.is_at_infinity(to_[i].vertex)) return length_to_infinity;
        if (r_.mesh.is_curved()) return std::sqrt(squares(i) / 2);
        return edge_length(point_.metric->measure, to_[i].metric->measure, chords_[i]);
    }

  private:
    void straighten_boundary(std::size_t first) {
        if (point_.lies == VertexPlace::inside) return;
        for (std::size_t i = first; i < to_.size(); ++i) {
            if (!is_boundary_likely(i)) continue;
            offsets_[i] = {};
            squares_[i] = unknown;
        }
    }
    [[nodiscard]] bool is_boundary_likely(std::size_t i) const {
        return point_.lies != VertexPlace::inside && r_.mesh.states[to_[i].vertex].place != VertexPlace::inside;
    }

    static constexpr double unknown = -1;
    struct To {
        VertexId vertex;
        const VertexMetric<D>* metric;
    };

    static constexpr std::size_t usual_vertices = D == 3 ? 24 : 12;

    const Adaptation<D>& r_;
    const AdaptationGoal<D>& goal_;
    ConePoint<D> point_;
    StackMemory<usual_vertices * (sizeof(To) + 2 * sizeof(Vec<D>) + sizeof(EndSamples<D>) + sizeof(double))>
        stack_memory_;
    std::pmr::vector<To> to_{&stack_memory_.memory};
    std::pmr::vector<Vec<D>> chords_{&stack_memory_.memory}, offsets_{&stack_memory_.memory};
    std::pmr::vector<EndSamples<D>> ends_{&stack_memory_.memory};
    std::pmr::vector<double> squares_{&stack_memory_.memory};
    bool has_stored_ = false;  ///< the offsets were computed for another position of the point
};

/// Shape of a quadratic simplex, computed as in `ConeShapes`. `tangents[i][j]`: tangent at vertex i of the edge to
/// vertex j. `density`: product of `density_root` over the vertices. `squares`: sum of `squares_between` over the
/// edges.
template <int D>
[[nodiscard]] double bent_shape(const std::array<std::array<Vec<D>, D + 1>, D + 1>& tangents, double density,
                                double squares) {
    double measure = 0;
    for (int i = 0; i <= D; ++i) {
        Mat<D> sides;
        for (int j = 1; j <= D; ++j) sides.column[j - 1] = tangents[i][i == j ? 0 : j];
        const double at_corner = i == 0 ? det(sides) : -det(sides);
        if (!(at_corner > 0)) return 0;
        measure += at_corner / (D + 1);
    }
    squares /= 2;
    if (!(squares > 0)) return 0;
    if constexpr (D == 2) return 2 * std::sqrt(3.0) * measure * density / squares;
    return 6 * std::sqrt(12.0) * measure * density / (squares * std::sqrt(squares));
}

/// Shapes of the simplices that join faces to one point, which replaces the opposite vertex in the element at each
/// face. The shape is `metric_shape` or, in degree 2, its analogue for curved edges (`bent_shape`). On a standalone
/// surface, edges of triangles are joined to the point. A triangle that turns too far from the existing one has shape
/// 0.
template <int D>
class ConeShapes {
  public:
    ConeShapes(const Adaptation<D>& r, const AdaptationGoal<D>& goal) : r_(r), spokes_(r, goal) {
        // The capacities suffice for most vertices. Growing vectors would cost as much as the computation.
        faces_.reserve(usual_faces);
        vertices_.reserve(usual_vertices);
        vertex_ids_.reserve(usual_vertices);
        if (r.mesh.is_curved()) edges_.reserve(usual_vertices);
    }

    void clear() {
        placed_ = 0;
        faces_.clear();
        vertices_.clear();
        vertex_ids_.clear();
        edges_.clear();
    }
    void add(ElementId e, int opposite) {
        Face face;
        if constexpr (D == 3)
            if (r_.mesh.is_surface()) return add_edge(triangle_of(r_.mesh.elements.vertices[e]), opposite);
        const auto outward = face_opposite<D>(opposite);
        for (int i = 0; i < D; ++i) face.corners[i] = index_of(r_.mesh.elements.vertices[e][outward[i]]);
        if (r_.mesh.is_curved()) take_edges(face, r_.mesh.edges_of[e], opposite);
        faces_.push_back(face);
    }

    /// A vertex of the faces. `faces`: number of faces that contain it.
    struct Corner {
        VertexId vertex;
        std::uint32_t faces = 0;
        Vec<D> place;
        const VertexMetric<D>* metric = nullptr;
    };
    [[nodiscard]] std::span<const Corner> vertices() const { return vertices_; }

    /// Sets the point. Its metric and gradient must exist as long as this object uses them.
    void place(const ConePoint<D>& point) {
        begin_at(point);
        spokes_.bend();
    }
    /// Sets the point to `v`, the vertex opposite all faces, with the edges of the mesh.
    void place_at(VertexId v) {
        begin_at(cone_point(r_, v));
        spokes_.take_edges(edges_);
        is_nearly_straight_ = spokes_.are_nearly_straight();
    }
    [[nodiscard]] double worst_shape(VertexId v) {
        if (is_nearly_straight_) place_near(cone_point(r_, v));
        return worst(0);
    }
    /// Moves the point to a position near the vertex of `place_at`, which must have been called. If the edges bend
    /// little, their offsets do not change, which is cheap.
    void place_near(const ConePoint<D>& point) {
        if (!is_nearly_straight_) return place(point);
        spokes_.move(point);
        for (std::size_t i = 0; i < vertices_.size(); ++i) spokes_.put_chord(i, vertices_[i].place);
    }
    [[nodiscard]] double length_to(std::size_t i) { return spokes_.length(i); }
    [[nodiscard]] Vec<D> tangent_to(std::size_t i) const { return spokes_.tangent(i); }

    /// Returns the worst shape if it exceeds `least`, otherwise a value that does not exceed `least`. Ignores faces
    /// that contain `without`; returns 0 if no face remains.
    [[nodiscard]] double worst(double least, VertexId without = {}) {
        if (const double first = first_shape(without); least >= 0 && !(first > least)) return first;
        // Volumes are cheap to compute and exclude most bad positions.
        for (Face& face : faces_) {
            face.counts = !contains(face, without);
            if (!face.counts) continue;
            face.measure = measure(face);
            if (!(face.measure > 0) && least >= 0) return move_to_front(face), 0;
        }
        double worst = std::numeric_limits<double>::infinity();
        for (Face& face : faces_) {
            if (!face.counts) continue;
            worst = std::min(worst, shape(face));
            if (!(worst > least)) return move_to_front(face), worst;
        }
        return worst < std::numeric_limits<double>::infinity() ? worst : 0;  // infinite: no face remains
    }
    [[nodiscard]] double worst_at(const ConePoint<D>& point, double least, VertexId without = {}) {
        place(point);
        return worst(least, without);
    }

    void begin_with(std::size_t i) { std::swap(faces_[i], faces_.front()); }
    /// Shape of the simplex at the first face, with the point near the vertex of `place_at`; not for standalone
    /// surfaces. Infinite if the edges are too strongly curved for an estimate. The caller must set the point again.
    [[nodiscard]] double first_shape_near(const ConePoint<D>& point) {
        Face& face = faces_.front();
        if (r_.mesh.is_curved()) {
            if (!is_nearly_straight_) return std::numeric_limits<double>::infinity();
            place_near(point);
            return first_shape({});
        }
        Mat<D> sides;
        double squares = squares_around(face);
        double density = point.metric->measure.density_root;
        for (int i = 0; i < D; ++i) {
            const Corner& corner = vertices_[face.corners[i]];
            sides.column[i] = corner.place - point.place;
            density *= corner.metric->measure.density_root;
            squares += squares_between(r_, *point.metric, *corner.metric, sides.column[i], {});
        }
        return shape_by(det(sides), density, squares);
    }

  private:
    static constexpr double unknown = -1;
    static constexpr int face_edges = edges_per_simplex<D - 1>;
    struct Face {
        std::array<std::uint32_t, D> corners{};  ///< indices in `vertices_` in outward order; standalone surface: the
                                                 ///< two ends of an edge
        std::array<Vec<D>, face_edges> offsets{};
        double measure = 0;
        double squares = unknown;  ///< sum of `squares_between` over the face's edges
        bool counts = true;
        Vec<D> normal{};  ///< standalone surface: normal of the existing triangle
    };

    void add_edge(const std::array<VertexId, 3>& triangle, int opposite)
        requires(D == 3)
    {
        const VertexId from = triangle[opposite];
        const VertexId a = triangle[(opposite + 1) % 3];
        const VertexId b = triangle[(opposite + 2) % 3];
        const Vec<3>& here = r_.mesh.points[from];
        const std::uint32_t first = index_of(a);
        const std::uint32_t second = index_of(b);
        faces_.push_back(
            {.corners = {first, second, second}, .normal = cross(r_.mesh.points[a] - here, r_.mesh.points[b] - here)});
    }
    static void fetch_ahead(const VertexMetric<D>& metric, const Vec<D>& place) {
        __builtin_prefetch(&place);
        for (const Vec<D>& row : metric.measure.rows) __builtin_prefetch(&row);
        __builtin_prefetch(&metric.measure.density_root);
    }
    void fetch_gradient_ahead(VertexId v) const {
        if (r_.mesh.is_curved())
            for (const Sym<D>& along : r_.vertices.gradients[v]) __builtin_prefetch(&along);
    }
    std::uint32_t index_of(VertexId v) {
        const std::uint32_t at = place_among(vertex_ids_, v);
        if (at == vertices_.size()) {
            const VertexMetric<D>& metric = r_.vertices.metrics[v];
            fetch_ahead(metric, r_.mesh.points[v]);
            fetch_gradient_ahead(v);
            vertices_.push_back({v, 0, {}, &metric});
        }
        ++vertices_[at].faces;
        return at;
    }
    void begin_at(const ConePoint<D>& point) {
        for (; placed_ < vertices_.size(); ++placed_)
            vertices_[placed_].place = r_.mesh.points[vertices_[placed_].vertex];
        spokes_.begin(point);
        for (const Corner& corner : vertices_) spokes_.add(corner.vertex, corner.place, *corner.metric);
    }
    void take_edges(Face& face, const std::array<EdgeId, edges_per_simplex<D>>& edges, int opposite) {
        const auto outward = face_opposite<D>(opposite);
        face.squares = 0;
        for (int k = 0; k < face_edges; ++k) {
            const auto& [i, j] = local_edges<D - 1>[k];
            const EdgeId edge = edges[edge_between<D>[outward[i]][outward[j]]];
            face.offsets[k] = r_.mesh.nodes[edge].point - midpoint(r_.mesh.points[vertices_[face.corners[i]].vertex],
                                                                   r_.mesh.points[vertices_[face.corners[j]].vertex]);
            face.squares += squares_of(r_, edge);
        }
        edges_.resize(vertices_.size());
        for (int i = 0; i < D; ++i) edges_[face.corners[i]] = edges[edge_between<D>[outward[i]][opposite]];
    }
    template <class Key>
    [[nodiscard]] static std::uint32_t place_among(std::pmr::vector<Key>& keys, Key key) {
        const auto at = static_cast<std::uint32_t>(std::ranges::find(keys, key) - keys.begin());
        if (at == keys.size()) keys.push_back(key);
        return at;
    }
    [[nodiscard]] const Vec<D>& offset(const Face& face, int i, int j) const {
        return face.offsets[edge_between<D - 1>[i][j]];
    }
    [[nodiscard]] bool contains(const Face& face, VertexId v) const {
        if (!v.valid()) return false;
        bool found = false;
        for (const std::uint32_t c : face.corners) found |= vertices_[c].vertex == v;
        return found;
    }
    /// Volume measure of the simplex. Degree 1: D! times the volume. Degree 2: mean of det J at the corners; 0 if det J
    /// is not positive at a corner.
    [[nodiscard]] double measure(const Face& face) const {
        if constexpr (D == 3)
            if (r_.mesh.is_surface()) return area(face);
        Mat<D> sides;
        for (int i = 0; i < D; ++i) sides.column[i] = spokes_.tangent(face.corners[i]);
        const double at_point = det(sides);
        if (!r_.mesh.is_curved() || !(at_point > 0)) return at_point;
        double sum = at_point;
        for (int i = 0; i < D; ++i) {
            const Vec<D>& from = vertices_[face.corners[i]].place;
            // Column i is the tangent at the corner towards the point. It replaces a tangent from the point, which
            // changes the sign.
            for (int j = 0; j < D; ++j)
                sides.column[j] = i == j ? spokes_.tangent_back(face.corners[i])
                                         : vertices_[face.corners[j]].place - from + 4.0 * offset(face, i, j);
            const double at_corner = -det(sides);
            if (!(at_corner > 0)) return 0;
            sum += at_corner;
        }
        return sum / (D + 1);
    }
    /// Standalone surface: twice the area of the triangle; 0 if it turns too far from the existing triangle.
    [[nodiscard]] double area(const Face& face) const
        requires(D == 3)
    {
        const Vec<3> normal = cross(spokes_.tangent(face.corners[0]), spokes_.tangent(face.corners[1]));
        const double size = norm(normal);
        return dot(normal, face.normal) > min_facet_cosine * size * norm(face.normal) ? size : 0;
    }
    [[nodiscard]] double triangle_shape_of(const Face& face) const
        requires(D == 3)
    {
        const Corner& a = vertices_[face.corners[0]];
        const Corner& b = vertices_[face.corners[1]];
        return triangle_shape({spokes_.point().place, a.place, b.place},
                              {&spokes_.point().metric->measure, &a.metric->measure, &b.metric->measure});
    }
    [[nodiscard]] double first_shape(VertexId without) {
        if (faces_.empty() || contains(faces_.front(), without)) return std::numeric_limits<double>::infinity();
        Face& face = faces_.front();
        face.measure = measure(face);
        return face.measure > 0 ? shape(face) : 0;
    }
    void move_to_front(Face& face) { std::swap(face, faces_.front()); }
    [[nodiscard]] double squares_around(Face& face) {
        if (face.squares != unknown) return face.squares;
        face.squares = 0;
        for (const auto& [i, j] : local_edges<D - 1>) {
            const Corner& p = vertices_[face.corners[i]];
            const Corner& q = vertices_[face.corners[j]];
            face.squares += squares_between(r_, *p.metric, *q.metric, q.place - p.place, {});
        }
        return face.squares;
    }
    [[nodiscard]] double shape(Face& face) {
        if constexpr (D == 3)
            if (r_.mesh.is_surface()) return triangle_shape_of(face);
        double squares = squares_around(face);
        double density = spokes_.density_root();
        for (const std::uint32_t c : face.corners) {
            density *= vertices_[c].metric->measure.density_root;
            squares += spokes_.squares(c);
        }
        return shape_by(face.measure, density, squares);
    }
    [[nodiscard]] static double shape_by(double measure, double density, double squares) {
        squares /= 2;
        if (!(squares > 0)) return 0;
        if constexpr (D == 2) return 2 * std::sqrt(3.0) * measure * density / squares;
        return 6 * std::sqrt(12.0) * measure * density / (squares * std::sqrt(squares));
    }

    static constexpr std::size_t usual_vertices = D == 3 ? 24 : 12, usual_faces = D == 3 ? 40 : 12;

    const Adaptation<D>& r_;
    StackMemory<usual_faces * sizeof(Face) + usual_vertices * (sizeof(Corner) + sizeof(VertexId) + sizeof(EdgeId))>
        stack_memory_;
    std::pmr::vector<Face> faces_{&stack_memory_.memory};
    std::pmr::vector<Corner> vertices_{&stack_memory_.memory};
    std::size_t placed_ = 0;
    bool is_nearly_straight_ = false;
    std::pmr::vector<VertexId> vertex_ids_{&stack_memory_.memory};
    /// Degree 2: for each vertex, an existing edge from it to the vertex that the point replaces.
    std::pmr::vector<EdgeId> edges_{&stack_memory_.memory};
    BentSpokes<D> spokes_;
};

/// Minimum value of the old shape in a ratio of new to old shape. It prevents huge ratios for almost inverted old
/// elements.
inline constexpr double least_bent_shape = 1e-3;

template <int D>
[[nodiscard]] double bent_shape_of(const Adaptation<D>& r, ElementId e) {
    const auto& vertices = r.mesh.elements.vertices[e];
    std::array<std::array<Vec<D>, D + 1>, D + 1> tangents;
    double squares = 0, density = 1;
    for (int k = 0; k < edges_per_simplex<D>; ++k) {
        const auto& [i, j] = local_edges<D>[k];
        const EdgeId edge = r.mesh.edges_of[e][k];
        const Vec<D> chord = r.mesh.points[vertices[j]] - r.mesh.points[vertices[i]];
        const Vec<D> offset = offset_of(r.mesh, edge);
        tangents[i][j] = chord + 4.0 * offset;
        tangents[j][i] = 4.0 * offset - chord;
        squares += squares_of(r, edge);
    }
    for (const VertexId v : vertices) density *= r.vertices.metrics[v].measure.density_root;
    return bent_shape<D>(tangents, density, squares);
}

/// Returns the vertex into which `v` may collapse (`may_collapse`) and for which the worst new shape is largest.
/// Invalid if no worst new shape exceeds `least`. `around`: cavity of `v`.
template <int D>
[[nodiscard]] VertexId best_neighbour(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const Cavity<D>& around,
                                      VertexId v, double least) {
    ConeShapes<D> cones(r, goal);
    for (const ElementId e : around.elements) cones.add(e, local_vertex(r.mesh.elements.vertices[e], v));
    VertexId best;
    double best_shape = least;
    for (const auto& corner : cones.vertices()) {
        if (!may_collapse(r.mesh, around, v, corner.vertex)) continue;
        const double shape = cones.worst_at(cone_point(r, corner.vertex), best_shape, corner.vertex);
        if (!(shape > best_shape)) continue;
        best = corner.vertex;
        best_shape = shape;
    }
    return best;
}

}  // namespace camber
