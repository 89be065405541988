// Shapes after swaps, Delaunay cavities, and helper functions of passes.
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

/// The elements and vertices around an inner edge (3D), found in one walk. For straight meshes, computes shapes after a
/// swap like `ConeShapes`, but much faster.
class EdgeRing {
  public:
    enum class Walk {
        closed,
        open,   ///< the walk ended at a facet, or after `most` elements
        worse,  ///< an element has a worse shape than the first one
    };
    /// `shapes`: shapes of all elements by `shape_of`.
    [[nodiscard]] Walk walk(const DynamicMesh<3>& mesh, std::span<const double> shapes, ElementId e, int local_edge);
    /// The ring vertex with the best swap in a straight mesh, and the worst shape after the swap. The vertex is invalid
    /// if that shape is at most `least`.
    struct Best {
        VertexId point;
        double worst = 0;
    };
    [[nodiscard]] Best best(const Adaptation<3>& r, double least) const;
    [[nodiscard]] std::span<const ElementId> elements() const { return std::span(elements_).first(count_); }
    [[nodiscard]] std::span<const VertexId> around() const { return std::span(around_).first(count_); }
    [[nodiscard]] std::array<VertexId, 2> ends() const { return {a_, b_}; }

    static constexpr std::size_t most = 12;  ///< maximum number of elements

  private:
    struct Measured;
    std::array<ElementId, most> elements_;  ///< element i contains ring vertices i and i + 1
    std::array<VertexId, most> around_;
    std::size_t count_ = 0;
    VertexId a_, b_;  ///< ends of the edge; tetrahedra (a, b, ring vertex i, ring vertex i + 1) are positive
};

/// Worst shape of the three elements that replace the two at a face, if it exceeds `least`. Otherwise a value that does
/// not exceed `least`. `other`: element across the face.
[[nodiscard]] double worst_without_face(const Adaptation<3>& r, ElementId e, int face, ElementId other, double least);

/// A swap in degree 2.
struct BentSwap {
    VertexId point;
    ElementId beside;  ///< face swap: element across the face
    double before = 0, after = 0;
};

/// Curved edges between a few vertices, each computed once: existing edges, and new edges by `bent_edges`.
class BentEdges {
  public:
    BentEdges(const Adaptation<3>& r, const AdaptationGoal<3>& goal) : r_(r), goal_(goal) {}

    /// Returns the index of the vertex. At most `most` vertices can be added.
    std::size_t add(VertexId v);
    [[nodiscard]] VertexId vertex(std::size_t i) const { return vertices_[i].id; }
    void take_edges(ElementId e);
    void take_edge(ElementId e, std::size_t i, std::size_t j);
    /// Requests a new edge, which `bend` computes. At most `max_requested` edges.
    void add_request(std::size_t i, std::size_t j);
    void bend();
    /// Tangent at vertex i of the edge to j. If the edge is straight, this is the chord.
    [[nodiscard]] Vec<3> tangent(std::size_t i, std::size_t j) const;
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
        double squares = 0;  ///< twice the squared length
    };
    void put(std::size_t i, std::size_t j, const Edge& edge) { edges_[i][j] = edges_[j][i] = edge; }

    const Adaptation<3>& r_;
    const AdaptationGoal<3>& goal_;
    std::size_t count_ = 0, requested_ = 0;
    std::array<Vertex, most> vertices_;
    std::array<std::array<Edge, most>, most> edges_;
    static constexpr std::size_t max_requested = EdgeRing::most * (EdgeRing::most - 3) / 2;
    std::array<std::array<std::size_t, 2>, max_requested> pairs_{};
    std::array<Vec<3>, max_requested> chords_, offsets_;
    std::array<EndSamples<3>, max_requested> ends_;
    std::array<double, max_requested> lengths_{};
};

/// Returns the best swap of an inner edge. Its point is invalid if no swap raises the worst shape to more than `gain`
/// times the present worst shape.
[[nodiscard]] BentSwap best_around_edge(const Adaptation<3>& r, const AdaptationGoal<3>& goal, const EdgeRing& ring,
                                        double gain);

/// Returns the best swap of one of these faces. Its point is invalid as for `best_around_edge`.
[[nodiscard]] BentSwap best_without_face(const Adaptation<3>& r, const AdaptationGoal<3>& goal, ElementId e,
                                         std::span<const int> faces, double gain);

/// Grows a Delaunay cavity of a point in the point's metric (paper §1.3). Starts from the elements that contain the
/// point. Adds the element across a face without a facet if the point is inside the element's circumsphere (2D:
/// circumcircle), up to `most` elements. Excludes an element if the metric length from the point to its vertex opposite
/// the face is less than `shortest`. Degree 2: a vertex is replaced by the end of the tangent of its edge from the
/// point. `spokes`: edges from the point, extended to all visited vertices.
template <int D>
void grow_delaunay(const Adaptation<D>& r, BentSpokes<D>& spokes, std::size_t most, double shortest, Cavity<D>& cavity);

}  // namespace camber

namespace camber {

template <int D>
[[nodiscard]] Outcome<Done> compute_shapes(Adaptation<D>& r, const Execution& execution) {
    auto shapes = take(std::move(r.shapes));
    shapes.resize(r.mesh.elements.size(), -1.0);
    auto measured = each(execution, shapes.size(), [&](std::size_t e) {
        if (!r.mesh.is_free(ElementId(e)) && shapes[e] < 0) shapes[e] = shape_of(r, ElementId(e));
    });
    r.shapes = std::move(shapes);
    return measured;
}
template <int D>
void compute_shapes(Adaptation<D>& r, std::span<const ElementId> created) {
    if (!r.mesh.is_curved()) return;  // `operate` has computed all shapes
    auto shapes = take(std::move(r.shapes));
    for (const ElementId e : created)
        if (!r.mesh.is_free(e) && shapes[e.index()] < 0) shapes[e.index()] = shape_of(r, e);
    r.shapes = std::move(shapes);
}

/// Precondition: `r.shapes` contains the shapes of these elements.
template <int D>
[[nodiscard]] double worst_cached_shape_of(const Adaptation<D>& r, std::span<const ElementId> elements) {
    double worst = std::numeric_limits<double>::infinity();
    for (const ElementId e : elements) worst = std::min(worst, r.shapes[e.index()]);
    return worst;
}

// Helper functions with which passes create requests.

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

/// Returns the face at vertex `from` beyond which position `b` lies, or −1 if there is none.
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
        Mat<D> replaced = sides;
        replaced.column[n] = b - a;
        const double part = volume > 0 ? det(replaced) : -det(replaced);
        if (part < least) best = others[n], least = part;
    }
    return best;
}

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

/// The same as `cavity_of_vertex`, but faster for inner vertices.
template <int D>
void cavity_around(const DynamicMesh<D>& mesh, VertexId v, Cavity<D>& out) {
    if (mesh.states[v].place != VertexPlace::inside) return cavity_of_vertex(mesh, v, out);
    out.clear();
    ball(mesh, v, out.elements);
}

template <int D>
[[nodiscard]] VertexId opposite_vertex(const DynamicMesh<D>& mesh, ElementId e, ElementId from) {
    const auto& faces = mesh.face_neighbours[e];
    for (int i = 0; i <= D; ++i)
        if (faces[i] == FaceNeighbour(from)) return mesh.elements.vertices[e][i];
    return {};
}

template <class Id>
[[nodiscard]] bool is_among(const std::vector<Id>& ids, Id id) {
    bool found = false;
    for (const Id i : ids) found |= i == id;
    return found;
}

/// Metric length from the point to the nearest vertex of the fixed elements of the request.
template <int D>
[[nodiscard]] double nearest_fixed_vertex(const Adaptation<D>& r, const CavityRequest<D>& request,
                                          const ConePoint<D>& point, BentSpokes<D>& spokes) {
    spokes.begin(point);
    std::size_t count = 0;
    for (std::size_t i = 0; i < request.fixed_element_count; ++i) {
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

/// Shape that corresponds to a target quality. For standalone surfaces, a quarter of the distance from 1 is used: 0.8
/// for tetrahedra becomes 0.95 for triangles.
template <int D>
[[nodiscard]] double target_shape(const Adaptation<D>& r, double quality) {
    return shape_of_quality(r.mesh.is_surface() ? 1 - (1 - quality) / 4 : quality, D);
}

struct SplitLimits {
    double shortest = 0;
    double min_quality = 0;                          ///< see `SplitOptions`
    double bad_quality = PatchLimits{}.bad_quality;  ///< see `PatchLimits`
};
/// Request to split the edge in halves of equal metric length. The new point moves by `share` of its way to the
/// geometry. Empty if no element has the edge, or if `share` is below 1 but the point is on the geometry already.
template <int D>
[[nodiscard]] std::optional<Candidate<D>> split_candidate(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                                          EdgeId edge, double share, const SplitLimits& limits);

inline constexpr double infinite_order = std::numeric_limits<double>::infinity();

template <class Tag, int D>
void refuse(Adaptation<D>& r, CachedPass pass, std::span<const Task> tasks, std::size_t entities) {
    std::vector<Id<Tag>> ids;
    ids.reserve(tasks.size());
    for (const Task& task : tasks) ids.emplace_back(std::size_t{task.id});
    r.rejection_cache.template refuse<Tag>(pass, ids, entities);
}

template <int D, class OrderOf, class IsRejected>
[[nodiscard]] Outcome<std::vector<Task>> edge_tasks(const Adaptation<D>& r, OrderOf&& order_of,
                                                    IsRejected&& is_cached_rejection, const Execution& execution) {
    return reduce_each(
        execution, r.mesh.edges.size(), std::vector<Task>{},
        [&](std::vector<Task>& tasks, std::size_t e) {
            if (r.mesh.is_free(EdgeId(e)) || is_cached_rejection(EdgeId(e))) return;
            if (const double order = order_of(length_of(r, EdgeId(e))); order < infinite_order)
                tasks.push_back(task(order, EdgeId(e)));
        },
        [](std::vector<Task> a, std::vector<Task> b) {
            a.insert(a.end(), b.begin(), b.end());
            return a;
        });
}

template <int D, class EdgePass>
[[nodiscard]] Outcome<Adapted<D>> run_on_edges(Adaptation<D> state, const AdaptationGoal<D>& goal, EdgePass pass,
                                               const Execution& execution) {
    auto tasks = edge_tasks(
        state, [&](double length) { return pass.order_of(length); },
        [&](EdgeId e) { return pass.is_cached_rejection(state, e); }, without_progress(execution));
    if (!tasks) return fail(tasks.error());
    auto statistics = run_pass<D>(state, goal, pass, std::move(*tasks), execution);
    if (!statistics) return fail(statistics.error());
    return Adapted<D>{std::move(state), *statistics};
}

template <int D, class OrderOf>
void add_edge_tasks(const Adaptation<D>& r, const TopologyChanges& changes, OrderOf&& order_of,
                    std::vector<Task>& tasks) {
    for (const EdgeId e : changes.edges.created)
        if (!r.mesh.is_free(e))
            if (const double order = order_of(length_of(r, e)); order < infinite_order) tasks.push_back(task(order, e));
}

/// Precondition: the qualities of all elements (`Adaptation::shapes`) are known.
template <int D, class OrderOf>
[[nodiscard]] Outcome<std::vector<Task>> element_tasks(const Adaptation<D>& r, CachedPass pass, OrderOf&& order_of,
                                                       const Execution& execution) {
    return reduce_each(
        execution, r.mesh.elements.size(), std::vector<Task>{},
        [&](std::vector<Task>& tasks, std::size_t e) {
            const ElementId id(e);
            if (r.mesh.is_free(id)) return;
            const double order = order_of(r.shapes[e]);
            if (order < infinite_order &&
                !r.rejection_cache.is_rejected(pass, id, std::span(r.mesh.elements.vertices[id])))
                tasks.push_back(task(order, id));
        },
        [](std::vector<Task> a, std::vector<Task> b) {
            a.insert(a.end(), b.begin(), b.end());
            return a;
        });
}

}  // namespace camber
