module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory_resource>
#include <span>
#include <vector>
export module camber.adapt:bent_spokes;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;

export namespace camber {

/// Where edges are to be joined: a place, the metric there, and of degree 2 the field's gradient.
template <int D>
struct ConePoint {
    Vec<D> place;
    const VertexMetric<D>* metric = nullptr;
    const LogGradient<D>* gradient = nullptr;  ///< null in degree 1
    VertexPlace lies = VertexPlace::inside;
};
/// A vertex as it is.
template <int D>
[[nodiscard]] ConePoint<D> cone_point(const Adaptation<D>& r, VertexId v) {
    return {r.mesh.points[v], &r.vertices.metrics[v], r.vertices.gradients.empty() ? nullptr : &r.vertices.gradients[v],
            r.mesh.states[v].place};
}
/// Of an edge the squared lengths in the metrics of both ends, added; of degree 2 twice that of its curve.
template <int D>
[[nodiscard]] double squares_between(const Adaptation<D>& r, const VertexMetric<D>& a, const VertexMetric<D>& b,
                                     const Vec<D>& chord, const Vec<D>& offset) {
    if (!r.mesh.is_curved()) return a.measure.length_squared(chord) + b.measure.length_squared(chord);
    const double length = bent_length<D>(end_of(a), end_of(b), chord, offset);
    return 2 * length * length;
}
/// The same of an edge of degree 2 as it is.
template <int D>
[[nodiscard]] double squares_of(const Adaptation<D>& r, EdgeId edge) {
    const double length = length_of(r, edge);
    return 2 * length * length;
}

/// What edges of these elements are measured with, of degree 2: they are scattered in memory.
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

/// Memory on the stack for what one candidate looks at: most are made of so few vertices that nothing is allocated.
template <std::size_t Bytes>
struct Room {
    alignas(std::max_align_t) std::array<std::byte, Bytes> bytes;
    std::pmr::monotonic_buffer_resource memory{bytes.data(), bytes.size()};
};

/// The edges that a point would get to vertices: straight ones, or in degree 2 the curves that the closed form of
/// accuracy gives them (edge_accuracy), which is what the star takes for the nodes of new edges; chords where an edge
/// of the boundary is likely.
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
        has_kept_ = false;
        offsets_.clear();
        chords_.clear();
        squares_.clear();
        to_.clear();
    }
    void add(VertexId v, const Vec<D>& place, const VertexMetric<D>& metric) {
        to_.push_back({v, &metric});
        chords_.push_back(place - point_.place);
    }
    /// Behind the last `add`; those that are bent already stay so.
    void bend() {
        const std::size_t first = squares_.size(), added = to_.size() - first;
        squares_.resize(to_.size(), unknown);
        if (!r_.mesh.is_curved()) return;
        offsets_.resize(to_.size());
        ends_.clear();
        for (std::size_t i = first; i < to_.size(); ++i)
            ends_.push_back({sight_of(*point_.metric, *point_.gradient),
                             sight_of(*to_[i].metric, r_.vertices.gradients[to_[i].vertex])});
        bent_edges<D>(std::span(chords_).last(added), ends_, goal_.accuracy, std::span(offsets_).last(added),
                      std::span(squares_).last(added));
        for (double& length : std::span(squares_).last(added)) length *= 2 * length;
        straighten_boundary(first);
    }
    /// Instead: of degree 2 the mesh's own edges to them, one each; chords where `bend` has these, so that places are
    /// compared alike.
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

    /// Whether no tangent at the point is off its chord by more than 0.3 of its edge's length, as the point sees it.
    [[nodiscard]] bool are_little_bent() {
        if (!r_.mesh.is_curved()) return true;
        constexpr double little = 0.3;
        for (std::size_t i = 0; i < to_.size(); ++i)
            if (point_.metric->measure.length_squared(4.0 * offsets_[i]) > little * little * squares(i) / 2)
                return false;
        return true;
    }
    /// The point elsewhere, with the offsets that it had: near to what it would get, and much cheaper. Chords are to be
    /// put anew, lengths are by the metrics at the ends.
    void move(const ConePoint<D>& point) {
        point_ = point;
        has_kept_ = true;
        squares_.assign(to_.size(), unknown);
    }
    void put_chord(std::size_t i, const Vec<D>& place) { chords_[i] = place - point_.place; }

    /// Of degree 2: to a request of an operation at the point, which would ask for them again. Not where an edge of the
    /// boundary is likely.
    void give(CavityRequest<D>& request) const {
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
    /// Of the edge at the point, and at the vertex.
    [[nodiscard]] Vec<D> tangent(std::size_t i) const {
        return r_.mesh.is_curved() ? chords_[i] + 4.0 * offsets_[i] : chords_[i];
    }
    [[nodiscard]] Vec<D> tangent_back(std::size_t i) const { return 4.0 * offsets_[i] - chords_[i]; }
    /// See squares_between.
    [[nodiscard]] double squares(std::size_t i) {
        if (squares_[i] != unknown) return squares_[i];
        const VertexMetric<D>& there = *to_[i].metric;
        if (r_.mesh.is_curved() && has_kept_)
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
    /// Chords where an edge of the boundary is likely, from the first that is asked.
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
    Room<usual_vertices * (sizeof(To) + 2 * sizeof(Vec<D>) + sizeof(EndSights<D>) + sizeof(double))> room_;
    std::pmr::vector<To> to_{&room_.memory};
    std::pmr::vector<Vec<D>> chords_{&room_.memory}, offsets_{&room_.memory};  ///< offsets of degree 2
    std::pmr::vector<EndSights<D>> ends_{&room_.memory};
    std::pmr::vector<double> squares_{&room_.memory};
    bool has_kept_ = false;  ///< the offsets, from another place
};

}  // namespace camber
