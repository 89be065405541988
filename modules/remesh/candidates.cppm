module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>
export module camber.remesh:candidates;
import camber.core;
import camber.metric;
import camber.dynamic;
import :measures;
import :rounds;
import :state;

/// What passes look at before they wish.
namespace camber {

/// An element that has the edge, and which of its edges that is.
struct ElementEdge {
    ElementId element;
    int local = 0;
};
template <int D>
[[nodiscard]] ElementEdge element_with_edge(const DynamicMesh<D>& mesh, EdgeId edge) {
    std::vector<ElementId> around;
    ball(mesh, mesh.edges[edge][0], around);
    for (const ElementId e : around)
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            if (mesh.edges_of[e][k] == edge) return {e, k};
    return {};
}

template <int D>
[[nodiscard]] double worst_shape(const Remeshing<D>& r, const std::vector<ElementId>& elements) {
    double worst = std::numeric_limits<double>::infinity();
    for (const ElementId e : elements) worst = std::min(worst, shape_of(r, e));
    return worst;
}

/// The order of what is not to be done.
inline constexpr double infinite_order = std::numeric_limits<double>::infinity();

/// Tasks for all edges whose length asks for one: `order_of(length)`, infinite where it does not.
template <int D, class OrderOf>
[[nodiscard]] Outcome<std::vector<Task>> edge_tasks(const Remeshing<D>& r, OrderOf&& order_of,
                                                    const Execution& execution) {
    return reduce_each(
        execution, r.mesh.edges.size(), std::vector<Task>{},
        [&](std::vector<Task>& tasks, std::size_t e) {
            if (r.mesh.is_free(EdgeId(e))) return;
            if (const double order = order_of(length_of(r, EdgeId(e))); order < infinite_order)
                tasks.push_back(task(order, EdgeId(e)));
        },
        [](std::vector<Task> a, std::vector<Task> b) {
            a.insert(a.end(), b.begin(), b.end());
            return a;
        });
}

/// The same for edges that a commit made.
template <int D, class OrderOf>
void add_edge_tasks(const Remeshing<D>& r, const TopologyChanges& changes, OrderOf&& order_of,
                    std::vector<Task>& tasks) {
    for (const EdgeId e : changes.edges.created)
        if (!r.mesh.is_free(e))
            if (const double order = order_of(length_of(r, e)); order < infinite_order) tasks.push_back(task(order, e));
}

/// The same for elements by their shape.
template <int D, class OrderOf>
[[nodiscard]] Outcome<std::vector<Task>> element_tasks(const Remeshing<D>& r, OrderOf&& order_of,
                                                       const Execution& execution) {
    return reduce_each(
        execution, r.mesh.elements.size(), std::vector<Task>{},
        [&](std::vector<Task>& tasks, std::size_t e) {
            if (r.mesh.is_free(ElementId(e))) return;
            if (const double order = order_of(shape_of(r, ElementId(e))); order < infinite_order)
                tasks.push_back(task(order, ElementId(e)));
        },
        [](std::vector<Task> a, std::vector<Task> b) {
            a.insert(a.end(), b.begin(), b.end());
            return a;
        });
}

}  // namespace camber
