module;
#include <optional>
#include <span>
#include <vector>
export module camber.cavity:patch;
import camber.core;
import :mesh;
import :star;

export namespace camber {

/// The point of a patch: a vertex of the mesh, which may move with it, or a new one.
template <int D>
struct PatchPoint {
    VertexId vertex;                   ///< invalid: a new one
    std::optional<Vec<D>> place = {};  ///< of a new one, or where the vertex moves
    Reference reference = 0;           ///< of a new one
    friend bool operator==(const PatchPoint&, const PatchPoint&) = default;
};

/// A node of an edge around a cavity, that follows it.
template <int D>
struct FollowingNode {
    EdgeId edge;
    LagrangeNode<D> node;
    friend bool operator==(const FollowingNode&, const FollowingNode&) = default;
};

/// What replaces a cavity, the whole change of topology: planned against one value of a mesh, and put in place by
/// `commit` in that one only.
template <int D>
struct Patch {
    Stamp planned_for;  ///< the mesh's
    PatchPoint<D> point;
    Cavity<D> removed;
    Star<D> star;  ///< of `removed` and the point, as the function `star` gave it
    /// In a mesh of degree 2: of the edges from the point to star.boundary. Those that elements or facets outside of
    /// the cavity have too keep their nodes.
    std::vector<LagrangeNode<D>> nodes = {};
    /// In a mesh of degree 2: nodes of edges that stay, all of whose elements are removed or `reshaped` by them.
    std::vector<FollowingNode<D>> following = {};
    std::vector<ElementId> reshaped = {};
};

/// Whether a patch leaves everything joined as it is: a vertex inside with all of its elements, which moves at most.
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

/// What became of the entities of one kind. A place may be of one that is removed and of one that is created: also of
/// an element that a patch reshapes.
template <class Id>
struct IdChanges {
    std::vector<Id> removed, created;
    friend bool operator==(const IdChanges&, const IdChanges&) = default;
};

/// The map of a commit, old → new: who is not removed keeps its id. Fields and metrics follow by it.
struct TopologyChanges {
    IdChanges<VertexId> vertices;
    IdChanges<EdgeId> edges;
    IdChanges<LineId> lines;
    IdChanges<FacetId> facets;
    IdChanges<ElementId> elements;
    std::vector<VertexId> points;  ///< the point of each patch
    /// Of degree 2: the edges from each patch's point to its star's boundary, one patch after the other.
    std::vector<EdgeId> spokes;
    friend bool operator==(const TopologyChanges&, const TopologyChanges&) = default;
};

template <int D>
struct ChangedMesh {
    DynamicMesh<D> mesh;
    TopologyChanges changes;
};

/// The last verb for topology: the patches' simplices in the place of their cavities, at the cost of the patches. New
/// edges, lines, facets and elements take the places of those that their patch removes, rising; then free ones, the
/// last that became free first, as new vertices do; then new ones at the end. Elements of a patch that keeps_topology
/// stay in their own places. As if one patch after the other; what
/// they give is the same up to the numbers of entities in any order. Give the mesh away (std::move), or all of it is
/// copied; with an error it is lost then. Errors (internal): patches planned for another mesh, that overlap, that make
/// the same edge, that move a vertex or a node which elements have that are neither in their cavity nor reshaped, or
/// one whose point another removes; nodes that are not one for each edge at the point of a mesh of degree 2; more
/// entities than 32 bits count (unsupported); memory.
template <int D>
[[nodiscard]] Outcome<ChangedMesh<D>> replace_cavities(DynamicMesh<D> mesh, std::span<const Patch<D>> patches);

}  // namespace camber
