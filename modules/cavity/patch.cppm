module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>
export module camber.cavity:patch;
import camber.core;
import camber.validity;
import camber.curving;
import camber.repair;

export namespace camber {

/// A node that a patch puts in place; the edge is named by its end vertices, lower first, so that it may be a new one.
template <int D>
struct PatchNode {
    std::array<VertexId, 2> vertices;
    EdgeId edge;  ///< in the mesh; invalid when the edge is new
    LagrangeNode<D> node;
    EdgeChange change = EdgeChange::straight;
};

/// What replaces a cavity: planned against a mesh that stays as it is, applied by `commit`.
template <int D>
struct Patch {
    VertexId point;
    std::vector<ElementId> removed;
    std::vector<SimplexVertices<D>> elements;  ///< in their place, one for each removed one when the point was there
    std::vector<PatchNode<D>> nodes;
    std::size_t relaxed_edges = 0;  ///< nodes that validity keeps from their targets
};

/// What kept a cavity from giving a patch.
enum class ReinsertionFailure : std::uint8_t {
    no_element,  ///< the vertex has no element: there is nothing to curve
    not_valid,   ///< out of tries, an element would not be valid that is so now (paper §3.2)
    no_gain,     ///< no node would come nearer to its target
};

/// Why the mesh stays as it is.
struct Rejection {
    ReinsertionFailure reason = ReinsertionFailure::no_element;
    ElementId element;  ///< not_valid: the first that would not be
};

/// The outcome of one cavity: a patch or a rejection, and the targets that were found on the way.
template <int D>
struct Reinsertion {
    VertexId vertex;
    std::variant<Patch<D>, Rejection> result;
    struct Target {
        EdgeId edge;
        EdgeTarget<D> target;
    };
    std::vector<Target> found;
};

}  // namespace camber
