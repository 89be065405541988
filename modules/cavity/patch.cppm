module;
#include <optional>
#include <span>
#include <vector>
export module camber.cavity:patch;
import camber.core;
import :mesh;
import :star;

export namespace camber {

/// The point of a patch: a new vertex, or a vertex of the mesh, which may move.
template <int D>
struct PatchPoint {
    VertexId vertex;  ///< invalid for a new vertex
    std::optional<Vec<D>> place = {};
    Reference reference = 0;  ///< reference of a new vertex
    friend bool operator==(const PatchPoint&, const PatchPoint&) = default;
};

/// New node of an edge that stays in the mesh.
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
    /// Degree 2: nodes of the edges from the point to `star.boundary`. Edges that also belong to elements or facets
    /// outside keep their nodes.
    std::vector<LagrangeNode<D>> nodes = {};
    /// Degree 2: new nodes of edges that stay in the mesh. All elements of such an edge are removed or `reshaped`.
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

/// Changed entities of one kind. A reused slot or a reshaped element is in both lists.
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

/// Applies patches in time proportional to their size. Another order of patches gives the same mesh up to numbering.
/// New vertices take free slots (the last freed first), then new slots. Other new entities first take the slots of
/// entities that their patch removes, in ascending order. With `preserves_topology`, elements stay in their slots. Pass
/// the mesh by `std::move` to avoid a copy; an error then destroys it.
///
/// Errors: internal (a patch of another mesh; patches that overlap or create the same edge; an element of a moved
/// vertex or node that its patch neither removes nor reshapes; a point that another patch removes; in degree 2, an edge
/// at the point without exactly one node); unsupported (more entities than 32 bits count); memory.
template <int D>
[[nodiscard]] Outcome<ChangedMesh<D>> replace_cavities(DynamicMesh<D> mesh, std::span<const Patch<D>> patches);

}  // namespace camber
