module;
#include <cstdint>
#include <functional>
#include <span>
export module camber.repair:guide;
import camber.core;
import camber.bezier;
import camber.curving;

export namespace camber {

/// A place of the geometry for a point of the boundary, and the projector onto the directions that lead off it there:
/// n nᵀ on a surface, I − t tᵀ on a curve, I where the point is not to slide.
template <int D>
struct GeometryFoot {
    Vec<D> point;
    Sym<D> across;
};
/// The foot near a point on what an edge of the boundary lies on: a pure function, asked from several threads.
template <int D>
using FootOnGeometry = std::function<GeometryFoot<D>(EdgeId, const Vec<D>&)>;
/// The same for a vertex of the boundary.
template <int D>
using VertexOnGeometry = std::function<GeometryFoot<D>(VertexId, const Vec<D>&)>;

/// Where nodes of boundary edges that may move end in the worst case.
enum class SurfaceMoves : std::uint8_t { off_geometry, on_geometry };

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
    /// Where nodes of boundary edges slide before any of them leaves the geometry; null: they do not slide.
    FootOnGeometry<D> onto = {};
    /// Where vertices of the boundary slide, with the nodes of their edges; null: they stay.
    VertexOnGeometry<D> vertices_onto = {};
    SurfaceMoves surface = SurfaceMoves::off_geometry;
};

}  // namespace camber
