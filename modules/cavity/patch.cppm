module;
#include <optional>
#include <span>
#include <vector>
export module camber.cavity:patch;
import camber.core;
import :mesh;
import :star;

export namespace camber {

/// A new vertex, or a vertex of the mesh, which may move.
template <int D>
struct PatchPoint {
    VertexId vertex;                   ///< invalid for a new vertex
    std::optional<Vec<D>> place = {};
    Reference reference = 0;           ///< of a new vertex
    friend bool operator==(const PatchPoint&, const PatchPoint&) = default;
};

/// A new node of an edge around a cavity.
template <int D>
struct FollowingNode {
    EdgeId edge;
    LagrangeNode<D> node;
    friend bool operator==(const FollowingNode&, const FollowingNode&) = default;
};

/// The replacement of a cavity, valid only for the mesh for which it was planned.
template <int D>
struct Patch {
    Stamp planned_for;  ///< stamp of the mesh
    PatchPoint<D> point;
    Cavity<D> removed;
    Star<D> star;
    /// Degree 2: nodes of edges from the point to `star.boundary`. Edges shared with elements or facets outside keep
    /// their nodes.
    std::vector<LagrangeNode<D>> nodes = {};
    /// Degree 2: new nodes of remaining edges. All elements of these edges are removed or `reshaped`.
    std::vector<FollowingNode<D>> following = {};
    std::vector<ElementId> reshaped = {};
};

/// True if the topology does not change: the patch replaces all elements around an inner vertex, which may move.
template <int D, class Elements>
[[nodiscard]] bool preserves_topology(const Elements& elements, const Patch<D>& patch) {
    const auto& [joined, preserved, facets, lines, boundary, vanishing, place] = patch.star;
    const auto& removed = patch.removed;
    if (!patch.point.vertex.valid() || !preserved.empty() || !removed.facets.empty() || !removed.lines.empty())
        return false;
    if (joined.size() != removed.elements.size()) return false;
    for (const ElementFace& open : joined)
        if (elements[open.element.index()][open.opposite] != patch.point.vertex) return false;
    return true;
}

/// Changed entities of one kind. Reused slots and reshaped elements are in both lists.
template <class Id>
struct IdChanges {
    std::vector<Id> removed, created;
    friend bool operator==(const IdChanges&, const IdChanges&) = default;
};

struct TopologyChanges {
    IdChanges<VertexId> vertices;
    IdChanges<EdgeId> edges;
    IdChanges<LineId> lines;
    IdChanges<FacetId> facets;
    IdChanges<ElementId> elements;
    std::vector<VertexId> points;
    /// Degree 2: edges from each patch's point to its star's boundary.
    std::vector<EdgeId> spokes;
    friend bool operator==(const TopologyChanges&, const TopologyChanges&) = default;
};

template <int D>
struct ChangedMesh {
    DynamicMesh<D> mesh;
    TopologyChanges changes;
};

/// Applies patches at the cost of their size. Another order gives the same mesh up to numbering. New entities except
/// vertices first take slots that their patch removes, in ascending order. Then they, like vertices, take free slots
/// (the last freed first), then new ones. With `preserves_topology`, elements stay in their slots. Pass the mesh by
/// `std::move` to avoid a copy; an error then destroys it.
///
/// Errors: internal (patches of another mesh; patches that overlap or create the same edge; a moved vertex or node of
/// elements neither in the cavity nor reshaped; a point that another patch removes; in degree 2, not one node for each
/// edge at the point); unsupported (more entities than 32 bits count); memory.
template <int D>
[[nodiscard]] Outcome<ChangedMesh<D>> replace_cavities(DynamicMesh<D> mesh, std::span<const Patch<D>> patches);

}  // namespace camber
