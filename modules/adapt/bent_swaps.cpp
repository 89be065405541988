module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>
module camber.adapt;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;

namespace camber {

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

void BentEdges::ask(std::size_t i, std::size_t j) {
    const Vertex& a = vertices_[i];
    const Vertex& b = vertices_[j];
    pairs_[asked_] = {i, j};
    chords_[asked_] = b.place - a.place;
    ends_[asked_] = {sight_of(*a.metric, r_.vertices.gradients[a.id]),
                     sight_of(*b.metric, r_.vertices.gradients[b.id])};
    ++asked_;
}

void BentEdges::bend() {
    bent_edges<3>(std::span(chords_).first(asked_), std::span(ends_).first(asked_), goal_.accuracy,
                  std::span(offsets_).first(asked_), std::span(lengths_).first(asked_));
    for (std::size_t k = 0; k < asked_; ++k)
        put(pairs_[k][0], pairs_[k][1], {offsets_[k], 2 * lengths_[k] * lengths_[k]});
    asked_ = 0;
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

/// Whether an element turns the right way round at a corner, from which it has these tangents: where it does not,
/// bent_shape is 0.
bool is_positive(const Vec<3>& a, const Vec<3>& b, const Vec<3>& c) { return dot(cross(a, b), c) > 0; }

/// The vertices around an edge are 0 … n − 1, its ends n and n + 1.
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
    /// Edges that there are, each once: element i has the vertices i and i + 1 of those around.
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
    /// Those to which the elements may be joined, rising, in `room`.
    [[nodiscard]] std::span<const std::size_t> possible_points(std::span<std::size_t> room) const {
        // Of three all give the same two elements, of four those opposite each other the same four.
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
    /// Whether the elements joined to p turn the right way round at the ends of the edge, from which no edge is new.
    [[nodiscard]] bool is_positive_at_ends(std::size_t p) const {
        const Vec<3> from_a = edges_.tangent(a_, p), from_b = edges_.tangent(b_, p);
        for (std::size_t i = next(p); next(i) != p; i = next(i))
            if (!is_positive(edges_.tangent(a_, i), edges_.tangent(a_, next(i)), from_a) ||
                !is_positive(edges_.tangent(b_, next(i)), edges_.tangent(b_, i), from_b))
                return false;
        return true;
    }
    /// Those that one of these vertices has, each once.
    void bend_diagonals(std::span<const std::size_t> possible) {
        const auto comes_before = [&](std::size_t j, std::size_t p) {
            return j < p && std::ranges::binary_search(possible, j);
        };
        for (const std::size_t p : possible)
            for (std::size_t j = 0; j < count_; ++j)
                if (j != p && next(j) != p && next(p) != j && !comes_before(j, p)) edges_.ask(p, j);
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

/// The corners of a face of the first four vertices, outward.
std::array<std::size_t, 3> corners_of_face(int face) {
    const auto outward = face_opposite<3>(face);
    return {static_cast<std::size_t>(outward[0]), static_cast<std::size_t>(outward[1]),
            static_cast<std::size_t>(outward[2])};
}

/// Whether the three elements around the edge from a face's opposite vertex to q turn the right way round at the
/// corners of the face, from which no edge is new.
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
        const std::size_t q = edges.add(vertex_apart(r.mesh, across.element(), e));
        edges.take_edges(across.element());
        if (!is_positive_at_face(edges, face, q)) continue;
        edges.ask(static_cast<std::size_t>(face), q);
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
