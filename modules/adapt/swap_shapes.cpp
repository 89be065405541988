// Shapes of the straight and curved tetrahedra that swaps inside the mesh create.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
module camber.adapt;
import camber.core;
import camber.cavity;
import camber.metric;
import camber.edge_optimisation;
import camber.operation;

namespace camber {

namespace {

/// For each edge: an order of the local vertices with the edge's ends first and positive orientation.
constexpr auto edge_first = [] {
    std::array<std::array<int, 4>, edges_per_simplex<3>> table{};
    for (int k = 0; k < edges_per_simplex<3>; ++k) {
        auto& row = table[k];
        row[0] = local_edges<3>[k][0];
        row[1] = local_edges<3>[k][1];
        int n = 2;
        for (int i = 0; i < 4; ++i)
            if (i != row[0] && i != row[1]) row[n++] = i;
        int inversions = 0;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < i; ++j) inversions += row[j] > row[i] ? 1 : 0;
        if (inversions % 2 == 1) std::swap(row[2], row[3]);
    }
    return table;
}();

struct ShapedVertex {
    VertexId id;
    Vec<3> place;
    const MeasuringMetric<3>* measure = nullptr;
};
ShapedVertex shaped_vertex(const Adaptation<3>& r, VertexId v) {
    return {v, r.mesh.points[v], &r.vertices.metrics[v].measure};
}
double squares_between(const ShapedVertex& a, const ShapedVertex& b) {
    const Vec<3> edge = b.place - a.place;
    return a.measure->length_squared(edge) + b.measure->length_squared(edge);
}
double shape_by(double volume, double density, double squares) {
    const double sum = squares / 2;
    return sum > 0 ? 6 * std::sqrt(12.0) * volume * density / (sum * std::sqrt(sum)) : 0;
}

void fetch_ahead(const Adaptation<3>& r, VertexId v) {
    __builtin_prefetch(&r.mesh.points[v]);
    const MeasuringMetric<3>& measure = r.vertices.metrics[v].measure;
    __builtin_prefetch(&measure.rows[0]);
    __builtin_prefetch(&measure.density_root);
}

}  // namespace

EdgeRing::Walk EdgeRing::walk(const DynamicMesh<3>& mesh, std::span<const double> shapes, ElementId e, int local_edge) {
    const auto& first = mesh.elements.vertices[e];
    const auto& order = edge_first[local_edge];
    a_ = first[order[0]], b_ = first[order[1]];
    around_[0] = first[order[2]], around_[1] = first[order[3]];
    elements_[0] = e;
    count_ = 1;
    for (ElementId at = e;;) {
        const int face = local_vertex(mesh.elements.vertices[at], around_[count_ - 1]);
        const FaceNeighbour across = mesh.face_neighbours[at][face];
        if (!across.is_element() || count_ == most) return Walk::open;
        at = across.element();
        if (shapes[at.index()] < shapes[e.index()]) return Walk::worse;
        elements_[count_] = at;
        // The next ring vertex is neither an end of the edge nor the current ring vertex.
        const auto& v = mesh.elements.vertices[at];
        const std::uint32_t next =
            v[0].value ^ v[1].value ^ v[2].value ^ v[3].value ^ a_.value ^ b_.value ^ around_[count_].value;
        ++count_;
        if (next == around_[0].value) return Walk::closed;
        if (count_ == most) return Walk::open;
        around_[count_] = VertexId(std::size_t{next});
    }
}

struct EdgeRing::Measured {
    std::size_t count;
    ShapedVertex a, b;
    std::array<ShapedVertex, most> around;
    std::array<Vec<3>, most> normals_from_a, normals_from_b;  ///< area vectors, times 2, of the triangles (end, i,
                                                              ///< next(i))
    std::array<double, most> to_a{}, to_b{}, to_next{};

    Measured(const Adaptation<3>& r, const EdgeRing& ring)
        : count(ring.count_), a(shaped_vertex(r, ring.a_)), b(shaped_vertex(r, ring.b_)) {
        for (std::size_t i = 0; i < count; ++i) around[i] = shaped_vertex(r, ring.around_[i]);
        for (std::size_t i = 0; i < count; ++i) {
            const Vec<3>& p = around[i].place;
            const Vec<3>& q = around[next(i)].place;
            normals_from_a[i] = cross(p - a.place, q - a.place);
            normals_from_b[i] = cross(q - b.place, p - b.place);
        }
    }
    [[nodiscard]] std::size_t next(std::size_t i) const { return i + 1 < count ? i + 1 : 0; }
    void measure_edges() {
        for (std::size_t i = 0; i < count; ++i) {
            to_a[i] = squares_between(a, around[i]);
            to_b[i] = squares_between(b, around[i]);
            to_next[i] = squares_between(around[i], around[next(i)]);
        }
    }
    /// Six times the volume of the tetrahedron of a, i, next(i) and p.
    [[nodiscard]] double volume_at_a(std::size_t i, std::size_t p) const {
        return dot(normals_from_a[i], around[p].place - a.place);
    }
    [[nodiscard]] double volume_at_b(std::size_t i, std::size_t p) const {
        return dot(normals_from_b[i], around[p].place - b.place);
    }
    [[nodiscard]] bool are_volumes_positive(std::size_t p) const {
        for (std::size_t i = next(p); next(i) != p; i = next(i))
            if (!(volume_at_a(i, p) > 0 && volume_at_b(i, p) > 0)) return false;
        return true;
    }
    [[nodiscard]] double worst(std::size_t p, double least) const {
        double worst = std::numeric_limits<double>::infinity();
        double to_p = to_next[p];  // `squares_between` of p and i
        for (std::size_t i = next(p); next(i) != p; i = next(i)) {
            const std::size_t j = next(i);
            const double to_p_next = next(j) == p ? to_next[j] : squares_between(around[p], around[j]);
            const double face = to_p + to_p_next + to_next[i];
            const double density =
                around[p].measure->density_root * around[i].measure->density_root * around[j].measure->density_root;
            worst = std::min(worst, shape_by(volume_at_a(i, p), density * a.measure->density_root,
                                             face + to_a[p] + to_a[i] + to_a[j]));
            worst = std::min(worst, shape_by(volume_at_b(i, p), density * b.measure->density_root,
                                             face + to_b[p] + to_b[i] + to_b[j]));
            if (!(worst > least)) return worst;
            to_p = to_p_next;
        }
        return worst;
    }
};

EdgeRing::Best EdgeRing::best(const Adaptation<3>& r, double least) const {
    for (std::size_t i = 0; i < count_; ++i) fetch_ahead(r, around_[i]);
    Measured measured(r, *this);
    Best best{{}, least};
    bool has_measured = false;
    // With three ring vertices, all give the same swap. With four, opposite vertices give the same swap.
    const std::size_t different = count_ == 3 ? 1 : count_ == 4 ? 2 : count_;
    for (std::size_t p = 0; p < different; ++p) {
        if (!measured.are_volumes_positive(p)) continue;
        if (!has_measured) measured.measure_edges();
        has_measured = true;
        const double worst = measured.worst(p, best.worst);
        if (worst > best.worst) best = {around_[p], worst};
    }
    return best;
}

double worst_without_face(const Adaptation<3>& r, ElementId e, int face, ElementId other, double least) {
    const auto& vertices = r.mesh.elements.vertices[e];
    const auto outward = face_opposite<3>(face);
    std::uint32_t opposite = 0;
    for (const VertexId v : r.mesh.elements.vertices[other]) opposite ^= v.value;
    std::array<ShapedVertex, 3> shared;
    for (int i = 0; i < 3; ++i) {
        shared[i] = shaped_vertex(r, vertices[outward[i]]);
        opposite ^= shared[i].id.value;
    }
    const ShapedVertex p = shaped_vertex(r, vertices[face]);
    const ShapedVertex q = shaped_vertex(r, VertexId(std::size_t{opposite}));
    std::array<double, 3> volumes{};
    for (int i = 0; i < 3; ++i) {
        volumes[i] = det(shared[i].place - p.place, shared[(i + 1) % 3].place - p.place, q.place - p.place);
        if (!(volumes[i] > 0)) return 0;
    }
    std::array<double, 3> to_p{}, to_q{};
    for (int i = 0; i < 3; ++i) {
        to_p[i] = squares_between(p, shared[i]);
        to_q[i] = squares_between(q, shared[i]);
    }
    const double between = squares_between(p, q);
    double worst = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        const double squares = between + to_p[i] + to_p[j] + to_q[i] + to_q[j] + squares_between(shared[i], shared[j]);
        const double density = p.measure->density_root * q.measure->density_root * shared[i].measure->density_root *
                               shared[j].measure->density_root;
        worst = std::min(worst, shape_by(volumes[i], density, squares));
        if (!(worst > least)) return worst;
    }
    return worst;
}

std::size_t BentEdges::add(VertexId v) {
    vertices_[count_] = {v, r_.mesh.points[v], &r_.vertices.metrics[v]};
    return count_++;
}

void BentEdges::take_edges(ElementId e) {
    const auto known = std::span(vertices_).first(count_);
    std::array<std::size_t, 4> at{};
    for (int i = 0; i < 4; ++i)
        at[i] = static_cast<std::size_t>(std::ranges::find(known, r_.mesh.elements.vertices[e][i], &Vertex::id) -
                                         known.begin());
    for (int k = 0; k < edges_per_simplex<3>; ++k)
        put(at[local_edges<3>[k][0]], at[local_edges<3>[k][1]],
            {offset_of(r_.mesh, r_.mesh.edges_of[e][k]), squares_of(r_, r_.mesh.edges_of[e][k])});
}

void BentEdges::take_edge(ElementId e, std::size_t i, std::size_t j) {
    const auto& corners = r_.mesh.elements.vertices[e];
    const int k = edge_between<3>[local_vertex(corners, vertices_[i].id)][local_vertex(corners, vertices_[j].id)];
    const EdgeId edge = r_.mesh.edges_of[e][k];
    put(i, j, {offset_of(r_.mesh, edge), squares_of(r_, edge)});
}

void BentEdges::add_request(std::size_t i, std::size_t j) {
    const Vertex& a = vertices_[i];
    const Vertex& b = vertices_[j];
    pairs_[requested_] = {i, j};
    chords_[requested_] = b.place - a.place;
    ends_[requested_] = {end_sample_of(*a.metric, r_.vertices.gradients[a.id]),
                         end_sample_of(*b.metric, r_.vertices.gradients[b.id])};
    ++requested_;
}

void BentEdges::bend() {
    bent_edges<3>(std::span(chords_).first(requested_), std::span(ends_).first(requested_), goal_.accuracy,
                  std::span(offsets_).first(requested_), std::span(lengths_).first(requested_));
    for (std::size_t k = 0; k < requested_; ++k)
        put(pairs_[k][0], pairs_[k][1], {offsets_[k], 2 * lengths_[k] * lengths_[k]});
    requested_ = 0;
}

Vec<3> BentEdges::tangent(std::size_t i, std::size_t j) const {
    return vertices_[j].place - vertices_[i].place + 4.0 * edges_[i][j].offset;
}

double BentEdges::shape(const std::array<std::size_t, 4>& corners) const {
    std::array<std::array<Vec<3>, 4>, 4> tangents;
    double squares = 0, density = 1;
    for (const auto& [i, j] : local_edges<3>) {
        const Edge& edge = edges_[corners[i]][corners[j]];
        const Vec<3> chord = vertices_[corners[j]].place - vertices_[corners[i]].place;
        tangents[i][j] = chord + 4.0 * edge.offset;
        tangents[j][i] = 4.0 * edge.offset - chord;
        squares += edge.squares;
    }
    for (const std::size_t c : corners) density *= vertices_[c].metric->measure.density_root;
    return bent_shape<3>(tangents, density, squares);
}

namespace {

/// True if det J is positive at a corner with these three tangents. Otherwise `bent_shape` is 0.
bool is_positive(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) { return dot(cross(a, b), c) > 0; }

/// Computes swaps of a curved edge. In `edges_`, vertices 0 … n − 1 are around the edge, and vertices n and n + 1 are
/// its ends.
class BentRing {
  public:
    BentRing(const Adaptation<3>& r, const AdaptationGoal<3>& goal, const EdgeRing& ring)
        : edges_(r, goal), elements_(ring.elements()), count_(ring.around().size()), a_(count_), b_(count_ + 1) {
        fetch_edges_ahead(r, elements_);
        for (const VertexId v : ring.around()) edges_.add(v);
        for (const VertexId v : ring.ends()) edges_.add(v);
    }
    [[nodiscard]] BentSwap best(double gain) {
        take_spokes();
        std::array<std::size_t, EdgeRing::most> room{};
        const std::span<const std::size_t> possible = possible_points(room);
        if (possible.empty()) return {};
        take_rim();
        bend_diagonals(possible);
        BentSwap best;
        best.before = worst_before();
        best.after = gain * best.before;
        for (const std::size_t p : possible)
            if (const double after = worst(p, best.after); after > best.after) {
                best.after = after;
                best.point = edges_.vertex(p);
            }
        return best;
    }

  private:
    [[nodiscard]] std::size_t next(std::size_t i) const { return i + 1 < count_ ? i + 1 : 0; }
    void take_spokes() {
        for (std::size_t i = 0; i < count_; ++i) {
            edges_.take_edge(elements_[i], a_, i);
            edges_.take_edge(elements_[i], b_, i);
        }
    }
    void take_rim() {
        edges_.take_edge(elements_[0], a_, b_);
        for (std::size_t i = 0; i < count_; ++i) edges_.take_edge(elements_[i], i, next(i));
    }
    /// Stores in `room`, in ascending order, the ring vertices for which all new elements have positive det J at the
    /// edge's ends.
    [[nodiscard]] std::span<const std::size_t> possible_points(std::span<std::size_t> room) const {
        // With three ring vertices, all give the same swap. With four, opposite ones do.
        const std::size_t different = count_ == 3 ? 1 : count_ == 4 ? 2 : count_;
        std::size_t count = 0;
        for (std::size_t p = 0; p < different; ++p)
            if (is_positive_at_ends(p)) room[count++] = p;
        return room.first(count);
    }
    [[nodiscard]] double worst_before() const {
        double worst = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < count_; ++i) worst = std::min(worst, edges_.shape({a_, b_, i, next(i)}));
        return std::max(worst, least_bent_shape);
    }
    [[nodiscard]] bool is_positive_at_ends(std::size_t p) const {
        const Vec<3> from_a = edges_.tangent(a_, p), from_b = edges_.tangent(b_, p);
        for (std::size_t i = next(p); next(i) != p; i = next(i))
            if (!is_positive(edges_.tangent(a_, i), edges_.tangent(a_, next(i)), from_a) ||
                !is_positive(edges_.tangent(b_, next(i)), edges_.tangent(b_, i), from_b))
                return false;
        return true;
    }
    void bend_diagonals(std::span<const std::size_t> possible) {
        const auto comes_before = [&](std::size_t j, std::size_t p) {
            return j < p && std::ranges::binary_search(possible, j);
        };
        for (const std::size_t p : possible)
            for (std::size_t j = 0; j < count_; ++j)
                if (j != p && next(j) != p && next(p) != j && !comes_before(j, p)) edges_.add_request(p, j);
        edges_.bend();
    }
    [[nodiscard]] double worst(std::size_t p, double least) const {
        double worst = std::numeric_limits<double>::infinity();
        for (std::size_t i = next(p); next(i) != p && worst > least; i = next(i)) {
            worst = std::min(worst, edges_.shape({a_, i, next(i), p}));
            if (worst > least) worst = std::min(worst, edges_.shape({b_, next(i), i, p}));
        }
        return worst;
    }

    BentEdges edges_;
    std::span<const ElementId> elements_;
    std::size_t count_, a_, b_;
};

}  // namespace

BentSwap best_around_edge(const Adaptation<3>& r, const AdaptationGoal<3>& goal, const EdgeRing& ring, double gain) {
    return BentRing(r, goal, ring).best(gain);
}

namespace {

std::array<std::size_t, 3> corners_of_face(int face) {
    const auto outward = face_opposite<3>(face);
    return {static_cast<std::size_t>(outward[0]), static_cast<std::size_t>(outward[1]),
            static_cast<std::size_t>(outward[2])};
}

bool is_positive_at_face(const BentEdges& edges, int face, std::size_t q) {
    const auto p = static_cast<std::size_t>(face);
    const auto s = corners_of_face(face);
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = s[(i + 1) % 3], k = s[(i + 2) % 3];
        const Vec<3> to_p = edges.tangent(s[i], p), to_q = edges.tangent(s[i], q);
        if (!is_positive(edges.tangent(s[i], j), to_p, to_q) || !is_positive(to_p, edges.tangent(s[i], k), to_q))
            return false;
    }
    return true;
}

}  // namespace

BentSwap best_without_face(const Adaptation<3>& r, const AdaptationGoal<3>& goal, ElementId e,
                           std::span<const int> faces, double gain) {
    BentEdges edges(r, goal);
    for (const VertexId v : r.mesh.elements.vertices[e]) edges.add(v);
    edges.take_edges(e);
    struct Beyond {
        int face = 0;
        ElementId element;
        std::size_t vertex = 0;
    };
    std::array<Beyond, 4> beyond;
    std::size_t count = 0;
    for (const int face : faces) {
        const FaceNeighbour across = r.mesh.face_neighbours[e][face];
        if (!across.is_element()) continue;
        const std::size_t q = edges.add(opposite_vertex(r.mesh, across.element(), e));
        edges.take_edges(across.element());
        if (!is_positive_at_face(edges, face, q)) continue;
        edges.add_request(static_cast<std::size_t>(face), q);
        beyond[count++] = {face, across.element(), q};
    }
    if (count == 0) return {};
    const double own = edges.shape({0, 1, 2, 3});
    edges.bend();
    BentSwap best;
    double best_gain = gain;
    for (const auto& [face, element, q] : std::span(beyond).first(count)) {
        const auto s = corners_of_face(face);
        const auto p = static_cast<std::size_t>(face);
        const double before = std::max(std::min(own, bent_shape_of(r, element)), least_bent_shape);
        double after = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < 3 && after > best_gain * before; ++i)
            after = std::min(after, edges.shape({p, s[i], s[(i + 1) % 3], q}));
        if (!(after > best_gain * before)) continue;
        best_gain = after / before;
        best = {edges.vertex(p), element, before, after};
    }
    return best;
}

}  // namespace camber
