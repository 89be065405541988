// Shapes that swaps make, Delaunay cavities, candidates of passes.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>
export module camber.adapt:swaps;
import camber.core;
import camber.cavity;
import camber.metric;
import camber.edge_optimisation;
import camber.operation;
import :cone_shapes;
import :passes;

export namespace camber {

/// What swaps inside of a straight mesh of tetrahedra make: shapes (metric_shape) as ConeShapes has them, in a fraction
/// of its time, since all that is around an edge is found in one walk. Here: the elements around an edge inside, of
/// either degree, and the vertices around it.
class EdgeRing {
  public:
    enum class Walk {
        closed,
        open,   ///< it ends at a facet, or is longer than there is room for
        worse,  ///< an element on it has a worse shape than the one where it began
    };
    /// `shapes`: of all elements.
    [[nodiscard]] Walk walk(const DynamicMesh<3>& mesh, std::span<const double> shapes, ElementId e, int local_edge);
    /// Of a straight mesh: the vertex around the edge to which the elements, joined to it in place of the edge, have
    /// the best worst shape, if that is above `least`.
    struct Best {
        VertexId point;
        double worst = 0;
    };
    [[nodiscard]] Best best(const Adaptation<3>& r, double least) const;
    [[nodiscard]] std::span<const ElementId> elements() const { return std::span(elements_).first(count_); }
    [[nodiscard]] std::span<const VertexId> around() const { return std::span(around_).first(count_); }
    [[nodiscard]] std::array<VertexId, 2> ends() const { return {a_, b_}; }

    static constexpr std::size_t most = 12;  ///< elements

  private:
    struct Measured;
    std::array<ElementId, most> elements_;  ///< the i-th between the i-th vertex and the next
    std::array<VertexId, most> around_;
    std::size_t count_ = 0;
    VertexId a_, b_;  ///< of the edge: (a, b, i-th vertex, next) is the right way round
};

/// The worst shape of the three elements that two without their face, joined by an edge between the vertices opposite
/// it, make, if that is above `least`; otherwise something that is not. `other`: across `face` of e.
[[nodiscard]] double worst_without_face(const Adaptation<3>& r, ElementId e, int face, ElementId other, double least);

/// A swap inside of a mesh of degree 2: the worst shape (bent_shape) of its elements before and after.
struct BentSwap {
    VertexId point;    ///< invalid: none
    ElementId beside;  ///< of a face: the element across
    double before = 0, after = 0;
};

/// A few vertices and the curves between them, each measured once: the edges that there are as they are, new ones as
/// the closed form of accuracy bends them, which is what the star takes for their nodes (bent_edges).
class BentEdges {
  public:
    BentEdges(const Adaptation<3>& r, const AdaptationGoal<3>& goal) : r_(r), goal_(goal) {}

    /// At most `most` in all; numbered from 0.
    std::size_t add(VertexId v);
    [[nodiscard]] VertexId vertex(std::size_t i) const { return vertices_[i].id; }
    /// The edges of an element among them.
    void take_edges(ElementId e);
    /// One of them.
    void take_edge(ElementId e, std::size_t i, std::size_t j);
    /// Asks for a new edge, which is known after `bend`: at most as many as a ring may have between its vertices.
    void ask(std::size_t i, std::size_t j);
    void bend();
    /// Of the edge from one towards the other, as long as its chord.
    [[nodiscard]] Vec<3> tangent(std::size_t i, std::size_t j) const;
    /// Of a tetrahedron of them, in the order of one that is the right way round.
    [[nodiscard]] double shape(const std::array<std::size_t, 4>& corners) const;

    static constexpr std::size_t most = EdgeRing::most + 2;

  private:
    struct Vertex {
        VertexId id;
        Vec<3> place;
        const VertexMetric<3>* metric = nullptr;
    };
    struct Edge {
        Vec<3> offset;
        double squares = 0;  ///< twice its squared length
    };
    void put(std::size_t i, std::size_t j, const Edge& edge) { edges_[i][j] = edges_[j][i] = edge; }

    const Adaptation<3>& r_;
    const AdaptationGoal<3>& goal_;
    std::size_t count_ = 0, asked_ = 0;
    std::array<Vertex, most> vertices_;
    std::array<std::array<Edge, most>, most> edges_;
    static constexpr std::size_t most_asked = EdgeRing::most * (EdgeRing::most - 3) / 2;  ///< new ones of a ring
    std::array<std::array<std::size_t, 2>, most_asked> pairs_{};
    std::array<Vec<3>, most_asked> chords_, offsets_;
    std::array<EndSights<3>, most_asked> ends_;
    std::array<double, most_asked> lengths_{};
};

/// The vertex around an edge inside to which the elements of its ring, joined to it in place of the edge, have the best
/// worst shape, where that is above `gain` times what it was.
[[nodiscard]] BentSwap best_around_edge(const Adaptation<3>& r, const AdaptationGoal<3>& goal, const EdgeRing& ring,
                                        double gain);

/// The best of these faces of an element to be taken away, where its two elements become three around an edge between
/// the vertices opposite it; likewise.
[[nodiscard]] BentSwap best_without_face(const Adaptation<3>& r, const AdaptationGoal<3>& goal, ElementId e,
                                         std::span<const int> faces, double gain);

/// The Delaunay cavity of a point in its own metric (paper §1.3): to the elements that are in it already, which hold
/// the point, those that faces without facets connect and in whose spheres (2D: circles) the point lies, unless their
/// vertex opposite that face is nearer to the point than `shortest` (in the metric). Of degree 2 vertices are where the
/// tangents of the point's edges to them lead. At most `most` elements. `spokes`: begun at the point; in the end
/// they lead to all vertices that were looked at.
template <int D>
void grow_delaunay(const Adaptation<D>& r, BentSpokes<D>& spokes, std::size_t most, double shortest, Cavity<D>& cavity);

}  // namespace camber

namespace camber {

/// The state comes to know the shape of each element, measured where it does not yet.
template <int D>
[[nodiscard]] Outcome<Done> know_shapes(Adaptation<D>& r, const Execution& execution) {
    auto shapes = take(std::move(r.shapes));
    shapes.resize(r.mesh.elements.size(), -1.0);
    auto measured = each(execution, shapes.size(), [&](std::size_t e) {
        if (!r.mesh.is_free(ElementId(e)) && shapes[e] < 0) shapes[e] = shape_of(r, ElementId(e));
    });
    r.shapes = std::move(shapes);
    return measured;
}
/// The same of elements that a commit made: of those that the judge has not measured.
template <int D>
void know_shapes(Adaptation<D>& r, std::span<const ElementId> created) {
    if (!r.mesh.is_curved()) return;  // all are the judge's
    auto shapes = take(std::move(r.shapes));
    for (const ElementId e : created)
        if (!r.mesh.is_free(e) && shapes[e.index()] < 0) shapes[e.index()] = shape_of(r, e);
    r.shapes = std::move(shapes);
}

/// Of elements whose shapes are known: the worst.
template <int D>
[[nodiscard]] double worst_known_shape_of(const Adaptation<D>& r, std::span<const ElementId> elements) {
    double worst = std::numeric_limits<double>::infinity();
    for (const ElementId e : elements) worst = std::min(worst, r.shapes[e.index()]);
    return worst;
}

// What passes look at before they request.

/// An element that has the edge, and which of its edges that is.
struct ElementEdge {
    ElementId element;
    int local = 0;
};
template <int D>
[[nodiscard]] ElementEdge edge_in(const DynamicMesh<D>& mesh, ElementId e, EdgeId edge) {
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        if (mesh.edges_of[e][k] == edge) return {e, k};
    return {};
}

/// The face at its local vertex `from` through which the way to b leaves an element; −1: none.
template <int D>
[[nodiscard]] int face_towards(const DynamicMesh<D>& mesh, ElementId e, int from, const Vec<D>& b) {
    const auto& vertices = mesh.elements.vertices[e];
    const Vec<D>& a = mesh.points[vertices[from]];
    Mat<D> sides;
    std::array<int, D> others{};
    for (int i = 0, n = 0; i <= D; ++i)
        if (i != from) {
            sides.column[n] = mesh.points[vertices[i]] - a;
            others[n++] = i;
        }
    const double volume = det(sides);
    int best = -1;
    double least = 0;
    for (int n = 0; n < D; ++n) {
        Mat<D> seen = sides;
        seen.column[n] = b - a;
        const double part = volume > 0 ? det(seen) : -det(seen);
        if (part < least) best = others[n], least = part;
    }
    return best;
}

/// From element to element around its first vertex towards its second; where that way ends, among all of them.
template <int D>
[[nodiscard]] ElementEdge element_with_edge(const DynamicMesh<D>& mesh, EdgeId edge) {
    const auto& [a, b] = mesh.edges[edge];
    const int max_steps = mesh.is_surface() ? 0 : 16;
    ElementId e = mesh.element_of[a];
    for (int step = 0; step < max_steps && e.valid(); ++step) {
        if (const ElementEdge found = edge_in(mesh, e, edge); found.element.valid()) return found;
        const int face = face_towards(mesh, e, local_vertex(mesh.elements.vertices[e], a), mesh.points[b]);
        e = face >= 0 ? element_across(mesh, e, face) : ElementId{};
    }
    std::vector<ElementId> around;
    ball(mesh, a, around);
    for (const ElementId s : around)
        if (const ElementEdge found = edge_in(mesh, s, edge); found.element.valid()) return found;
    return {};
}

/// cavity_of_vertex, without looking for what vertices inside do not have.
template <int D>
void cavity_around(const DynamicMesh<D>& mesh, VertexId v, Cavity<D>& out) {
    if (mesh.states[v].place != VertexPlace::inside) return cavity_of_vertex(mesh, v, out);
    out.clear();
    ball(mesh, v, out.elements);
}

/// The vertex of an element opposite the face that it shares with another.
template <int D>
[[nodiscard]] VertexId vertex_apart(const DynamicMesh<D>& mesh, ElementId e, ElementId from) {
    const auto& faces = mesh.face_neighbours[e];
    for (int i = 0; i <= D; ++i)
        if (faces[i] == FaceNeighbour(from)) return mesh.elements.vertices[e][i];
    return {};
}

/// Whether an id is among a few; without a branch at each, so that several are compared at once.
template <class Id>
[[nodiscard]] bool is_among(const std::vector<Id>& ids, Id id) {
    bool found = false;
    for (const Id i : ids) found |= i == id;
    return found;
}

/// The length from a request's place to the nearest vertex of the elements that hold it.
template <int D>
[[nodiscard]] double nearest_of_holders(const Adaptation<D>& r, const CavityRequest<D>& request,
                                        const ConePoint<D>& point, BentSpokes<D>& spokes) {
    spokes.begin(point);
    std::size_t count = 0;
    for (std::size_t i = 0; i < request.holders; ++i) {
        const auto& vertices = r.mesh.elements.vertices[request.cavity.elements[i]];
        for (const VertexId v : vertices)
            if (i == 0 || local_vertex(r.mesh.elements.vertices[request.cavity.elements[i - 1]], v) < 0) {
                spokes.add(v, r.mesh.points[v], r.vertices.metrics[v]);
                ++count;
            }
    }
    spokes.bend();
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < count; ++i) nearest = std::min(nearest, spokes.length(i));
    return nearest;
}

/// The shape of what is left alone. A surface's triangles are held to a quarter of the distance from 1: where
/// tetrahedra are good at 0.8, triangles are at 0.95.
template <int D>
[[nodiscard]] double wanted_shape(const Adaptation<D>& r, double quality) {
    return shape_of_quality(r.mesh.is_surface() ? 1 - (1 - quality) / 4 : quality, D);
}

/// Limits of one split.
struct SplitLimits {
    double shortest = 0;                             ///< no edge at the new point is shorter (lengths in the metric)
    double min_quality = 0;                          ///< of new elements, unless what they replace is worse
    double bad_quality = PatchLimits{}.bad_quality;  ///< see PatchLimits
};
/// A request to split an edge at the middle by length, its point on the geometry, or with `share` below 1 that share of
/// the way to it. Empty: no element has the edge, or `share` makes no difference.
template <int D>
[[nodiscard]] std::optional<Candidate<D>> split_candidate(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                                          EdgeId edge, double share, const SplitLimits& limits);

/// The order of what is not to be done.
inline constexpr double infinite_order = std::numeric_limits<double>::infinity();

/// See Refusals.
template <class Tag, int D>
void refuse(Adaptation<D>& r, AskingPass pass, std::span<const Task> tasks, std::size_t entities) {
    std::vector<Id<Tag>> ids;
    ids.reserve(tasks.size());
    for (const Task& task : tasks) ids.emplace_back(std::size_t{task.id});
    r.refusals.template refuse<Tag>(pass, ids, entities);
}

/// Tasks for all edges whose length asks for one: `order_of(length)`, infinite where it does not; but for those whose
/// refusal stands.
template <int D, class OrderOf, class HasStood>
[[nodiscard]] Outcome<std::vector<Task>> edge_tasks(const Adaptation<D>& r, OrderOf&& order_of, HasStood&& has_stood,
                                                    const Execution& execution) {
    return reduce_each(
        execution, r.mesh.edges.size(), std::vector<Task>{},
        [&](std::vector<Task>& tasks, std::size_t e) {
            if (r.mesh.is_free(EdgeId(e)) || has_stood(EdgeId(e))) return;
            if (const double order = order_of(length_of(r, EdgeId(e))); order < infinite_order)
                tasks.push_back(task(order, EdgeId(e)));
        },
        [](std::vector<Task> a, std::vector<Task> b) {
            a.insert(a.end(), b.begin(), b.end());
            return a;
        });
}

/// A pass over edges whose lengths ask for it, `pass.order_of(length)`.
template <int D, class EdgePass>
[[nodiscard]] Outcome<Adapted<D>> run_on_edges(Adaptation<D> state, const AdaptationGoal<D>& goal, EdgePass pass,
                                               const Execution& execution) {
    auto tasks = edge_tasks(
        state, [&](double length) { return pass.order_of(length); }, [&](EdgeId e) { return pass.has_stood(state, e); },
        without_progress(execution));
    if (!tasks) return fail(tasks.error());
    auto statistics = run_pass<D>(state, goal, pass, std::move(*tasks), execution);
    if (!statistics) return fail(statistics.error());
    return Adapted<D>{std::move(state), *statistics};
}

/// Tasks for edges that a commit made.
template <int D, class OrderOf>
void add_edge_tasks(const Adaptation<D>& r, const TopologyChanges& changes, OrderOf&& order_of,
                    std::vector<Task>& tasks) {
    for (const EdgeId e : changes.edges.created)
        if (!r.mesh.is_free(e))
            if (const double order = order_of(length_of(r, e)); order < infinite_order) tasks.push_back(task(order, e));
}

/// The same for elements by their shape, which is known, of a pass.
template <int D, class OrderOf>
[[nodiscard]] Outcome<std::vector<Task>> element_tasks(const Adaptation<D>& r, AskingPass pass, OrderOf&& order_of,
                                                       const Execution& execution) {
    return reduce_each(
        execution, r.mesh.elements.size(), std::vector<Task>{},
        [&](std::vector<Task>& tasks, std::size_t e) {
            const ElementId id(e);
            if (r.mesh.is_free(id)) return;
            const double order = order_of(r.shapes[e]);
            if (order < infinite_order && !r.refusals.stands(pass, id, std::span(r.mesh.elements.vertices[id])))
                tasks.push_back(task(order, id));
        },
        [](std::vector<Task> a, std::vector<Task> b) {
            a.insert(a.end(), b.begin(), b.end());
            return a;
        });
}

}  // namespace camber
