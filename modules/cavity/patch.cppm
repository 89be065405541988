module;
#include <optional>
#include <span>
#include <vector>
export module camber.cavity:patch;
import camber.core;
import :mesh;
import :star;

export namespace camber {

/// A new vertex, or one of the mesh, which may move.
template <int D>
struct PatchPoint {
    VertexId vertex;                   ///< invalid: a new vertex
    std::optional<Vec<D>> place = {};  ///< of a new or moved vertex
    Reference reference = 0;           ///< of a new vertex
    friend bool operator==(const PatchPoint&, const PatchPoint&) = default;
};

/// A moved node around a cavity.
template <int D>
struct FollowingNode {
    EdgeId edge;
    LagrangeNode<D> node;
    friend bool operator==(const FollowingNode&, const FollowingNode&) = default;
};

/// The replacement of a cavity, valid only for the mesh that it was planned for.
template <int D>
struct Patch {
    Stamp planned_for;  ///< stamp of the mesh
    PatchPoint<D> point;
    Cavity<D> removed;
    Star<D> star;  ///< by `star` for `removed` and `point`
    /// Degree 2: nodes of edges from the point to `star.boundary`. Edges shared with elements or facets outside keep
    /// theirs.
    std::vector<LagrangeNode<D>> nodes = {};
    /// Degree 2: nodes of remaining edges whose elements are all removed or `reshaped`.
    std::vector<FollowingNode<D>> following = {};
    std::vector<ElementId> reshaped = {};
};

/// True if the topology stays: the patch replaces all elements around an inner vertex, which may move.
template <int D, class Elements>
[[nodiscard]] bool keeps_topology(const Elements& elements, const Patch<D>& patch) {
    const auto& [joined, kept, facets, lines, boundary, vanishing, place] = patch.star;
    const auto& removed = patch.removed;
    if (!patch.point.vertex.valid() || !kept.empty() || !removed.facets.empty() || !removed.lines.empty()) return false;
    if (joined.size() != removed.elements.size()) return false;
    for (const ElementFace& open : joined)
        if (elements[open.element.index()][open.opposite] != patch.point.vertex) return false;
    return true;
}

/// Entities of one kind. Reused slots and reshaped elements are in both lists.
template <class Id>
struct IdChanges {
    std::vector<Id> removed, created;
    friend bool operator==(const IdChanges&, const IdChanges&) = default;
};

/// Changes of a commit; other entities keep their ids.
struct TopologyChanges {
    IdChanges<VertexId> vertices;
    IdChanges<EdgeId> edges;
    IdChanges<LineId> lines;
    IdChanges<FacetId> facets;
    IdChanges<ElementId> elements;
    std::vector<VertexId> points;  ///< the point of each patch
    /// Degree 2: edges from points to boundaries, patch by patch.
    std::vector<EdgeId> spokes;
    friend bool operator==(const TopologyChanges&, const TopologyChanges&) = default;
};

template <int D>
struct ChangedMesh {
    DynamicMesh<D> mesh;
    TopologyChanges changes;
};

/// Applies patches at the cost of their size. Another order gives the same mesh up to numbering. New entities except
/// vertices take slots that their patch removes, in rising order; then, like vertices, free slots (last freed first),
/// then new ones. With `keeps_topology`, elements stay in their slots. Pass the mesh by `std::move` to avoid a copy; an
/// error destroys it then.
///
/// Errors (internal): patches of another mesh; overlapping patches, or two that create one edge; a moved vertex or node
/// with elements neither in the cavity nor reshaped; a point that another patch removes; in degree 2, other than one
/// node for each edge at the point. More entities than 32 bits count (unsupported); memory.
template <int D>
[[nodiscard]] Outcome<ChangedMesh<D>> replace_cavities(DynamicMesh<D> mesh, std::span<const Patch<D>> patches);

}  // namespace camber
