module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.adapt:candidates;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;
import :bent_spokes;
import :kept_shapes;
import :passes;

/// What passes look at before they request.
namespace camber {

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
