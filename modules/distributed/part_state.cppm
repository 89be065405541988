module;
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.distributed:part_state;
import camber.core;
import camber.curving;
import camber.metric;
import :moved_nodes;
import :ringed_parts;

namespace camber {

/// What is known of a part between two steps: rows of its vertices and unique edges, those in its rings as their
/// owners have them.
template <int D>
struct PartState {
    QuadraticMesh<D> mesh;  ///< straight, without nodes
    Incidence<ElementId> shells;
    OwnVertices owned;
    EdgeId first_edge, last_edge;
    Column<EdgeKind> kinds;
    Column<EdgeKind> kinds_outside_planes;  ///< with edges within planes as of the volume
    Column<EdgeId> on_surface;              ///< the edge of the whole surface that each is; invalid: of the volume
    Buffer<LagrangeNode<D>> base;           ///< where nodes start, while that is of use
    MovedNodes<D> extended;                 ///< not known: nothing is displaced
    Buffer<LogMetric<D>> log_metrics;       ///< none: a field with a mesh of its own
    MovedNodes<D> back_nodes;               ///< of the field's mesh; not known: straight
    Buffer<Vec<D>> slides, offsets;         ///< none: nothing moves
    Buffer<LagrangeNode<D>> nodes;

    [[nodiscard]] bool owns(EdgeId e) const { return e >= first_edge && e < last_edge; }
    /// Kinds by which only its own edges of the volume are looked for.
    [[nodiscard]] Column<EdgeKind> own_kinds() const {
        Buffer<EdgeKind> own(kinds.begin(), kinds.end());
        for (std::size_t e = 0; e < own.size(); ++e)
            if (!owns(EdgeId(e))) own[e] = EdgeKind::fixed;
        return own;
    }
};

/// visit(array) of all that grow with the part.
template <int D>
void each_array(PartState<D>& state, const auto& visit) {
    visit(state.mesh.edges.vertices);
    visit(state.mesh.edges.of_elements);
    visit(state.mesh.edges.of_facets);
    visit(state.mesh.edges.of_edges);
    visit(state.shells.offsets);
    visit(state.shells.items);
    visit(state.kinds);
    visit(state.kinds_outside_planes);
    visit(state.on_surface);
    visit(state.base);
    state.extended.each_array(visit);
    visit(state.log_metrics);
    state.back_nodes.each_array(visit);
    visit(state.slides);
    visit(state.offsets);
    visit(state.nodes);
}

/// A column of each state, to be brought.
template <int D, class T>
[[nodiscard]] std::vector<std::span<T>> columns_of(std::vector<PartState<D>>& states, Buffer<T> PartState<D>::* of) {
    std::vector<std::span<T>> columns;
    for (PartState<D>& state : states) columns.emplace_back(state.*of);
    return columns;
}

}  // namespace camber
