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
import camber.metric;
import camber.cavity;
import camber.operation;

namespace camber {

namespace {

/// The local vertices of a tetrahedron, those of an edge first, the right way round.
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
/// Of an edge the squared lengths in the metrics of both ends, added.
double squares_between(const ShapedVertex& a, const ShapedVertex& b) {
    const Vec<3> edge = b.place - a.place;
    return a.measure->length_squared(edge) + b.measure->length_squared(edge);
}
/// metric_shape by the six-fold volume, the product of the densities and the sum of squares_between of the edges.
double shape_by(double volume, double density, double squares) {
    const double sum = squares / 2;
    return sum > 0 ? 6 * std::sqrt(12.0) * volume * density / (sum * std::sqrt(sum)) : 0;
}

/// What is looked at when the vertices around an edge are known: they are scattered in memory.
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
        // The vertex that is neither of the edge nor the one before.
        const auto& v = mesh.elements.vertices[at];
        const std::uint32_t next =
            v[0].value ^ v[1].value ^ v[2].value ^ v[3].value ^ a_.value ^ b_.value ^ around_[count_].value;
        ++count_;
        if (next == around_[0].value) return Walk::closed;
        if (count_ == most) return Walk::open;
        around_[count_] = VertexId(std::size_t{next});
    }
}

/// The vertices of a ring, and what is measured once for all of them.
struct EdgeRing::Measured {
    std::size_t count;
    ShapedVertex a, b;
    std::array<ShapedVertex, most> around;
    std::array<Vec<3>, most> seen_from_a, seen_from_b;   ///< twice the area of (i, next) and an end, as a vector
    std::array<double, most> to_a{}, to_b{}, to_next{};  ///< squares_between

    Measured(const Adaptation<3>& r, const EdgeRing& ring)
        : count(ring.count_), a(shaped_vertex(r, ring.a_)), b(shaped_vertex(r, ring.b_)) {
        for (std::size_t i = 0; i < count; ++i) around[i] = shaped_vertex(r, ring.around_[i]);
        for (std::size_t i = 0; i < count; ++i) {
            const Vec<3>& p = around[i].place;
            const Vec<3>& q = around[next(i)].place;
            seen_from_a[i] = cross(p - a.place, q - a.place);
            seen_from_b[i] = cross(q - b.place, p - b.place);
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
    /// Six-fold volumes of (i, next) with an end and the vertex p.
    [[nodiscard]] double volume_at_a(std::size_t i, std::size_t p) const {
        return dot(seen_from_a[i], around[p].place - a.place);
    }
    [[nodiscard]] double volume_at_b(std::size_t i, std::size_t p) const {
        return dot(seen_from_b[i], around[p].place - b.place);
    }
    [[nodiscard]] bool are_volumes_positive(std::size_t p) const {
        for (std::size_t i = next(p); next(i) != p; i = next(i))
            if (!(volume_at_a(i, p) > 0 && volume_at_b(i, p) > 0)) return false;
        return true;
    }
    [[nodiscard]] double worst(std::size_t p, double least) const {
        double worst = std::numeric_limits<double>::infinity();
        double to_p = to_next[p];  // from i, from next
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
    // Of three all give the same two elements, of four those opposite each other the same four.
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

}  // namespace camber
