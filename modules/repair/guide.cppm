module;
#include <functional>
#include <span>
export module camber.repair:guide;
import camber.core;
import camber.bezier;
import camber.curving;

export namespace camber {

/// What repair goes by, beside the places and the options.
template <int D>
struct RepairGuide {
    Incidence<ElementId> shells;  ///< elements around each edge
    /// Where an edge's node is wanted while its vertices are where the mesh has them, and what it costs to have it
    /// elsewhere; asked of edges near elements that are not valid. Null for methods that need none (`needs_models`).
    std::function<LagrangeNode<D>(EdgeId)> wanted = {};
    EdgeModels<D> models = {};
    /// Where nodes go back to in elements that are not valid, one an edge: the extension of the boundary's displacement
    /// (`extend_boundary`). Empty: one is made around these elements alone.
    Column<LagrangeNode<D>> home = {};
};

}  // namespace camber
