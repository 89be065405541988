module;
#include <cstddef>
#include <cstdint>
#include <optional>
export module camber.recipes:curve_input;
import camber.core;
import camber.bezier;
import camber.curving;
import camber.metric;
import camber.surface;
import :boundary;

export namespace camber {

/// Whence a mesh has the nodes that curving begins with: straight ones of `elevate`, or curves of its own, which it was
/// read with or got by passes that changed it.
enum class NodesOf : std::uint8_t { elevation, input };

/// What the edges of a mesh are curved from: where boundary nodes are wanted, and from where those of the volume start,
/// one row an edge; and which nodes stay.
template <int D>
struct CurveInput {
    Column<EdgeKind> kinds;
    Column<LagrangeNode<D>> base;
    Incidence<ElementId> shells;
    std::size_t kept = 0;  ///< edges of the boundary that keep the nodes of a mesh with curves of its own
    /// The boundary's displacement extended into the volume; empty where the field is read in the straight mesh, or
    /// nothing is displaced. Of a mesh with curves of its own too: curved again it comes out the same.
    Column<LagrangeNode<D>> extended = {};
    std::optional<PlacementStatistics> placed = {};  ///< where `base` has them elsewhere than projected
    std::size_t drawn_back = 0;                      ///< slides that go a part of their way, for their elements
    std::size_t held_back = 0;                       ///< that go less than half of it, for smooth functions
};

/// A mesh of degree 2 that is to be curved.
template <int D>
struct CurvedFrom {
    const QuadraticMesh<D>& mesh;
    NodesOf nodes;
    const Boundary<D>& boundary;
};

/// Boundary nodes on the geometry; of a mesh with curves of its own only those on prescribed surfaces. Volume edges
/// start at the mesh's nodes.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> curve_input(const CurvedFrom<D>& from, const Execution& execution);

}  // namespace camber

namespace camber {

/// The same with the nodes of edges within plane walls where the displacement of all others extends to: layers that end
/// at a plane wall go on it as they go inside.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> extended_in_planes(const CurvedFrom<D>& from, CurveInput<D> input,
                                                        const Execution& execution);

/// The same with what a curved back mesh is curved by, if the boundary is displaced at all.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> extended_input(const CurvedFrom<D>& from, CurveInput<D> input,
                                                    const Execution& execution);

/// The same with nodes in planes slid within them to where the options want them in the field; those of a mesh with
/// curves of its own stay.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> slid_input(const CurvedFrom<D>& from, CurveInput<D> input,
                                                const BackMesh<D>& field, const CurveOptions& options,
                                                const Execution& execution);

/// The same with nodes of boundary edges where the options place them, by length in the field; of a mesh with curves of
/// its own those alone that `curve_input` puts onto prescribed surfaces.
template <int D>
[[nodiscard]] Outcome<CurveInput<D>> placed_input(const CurvedFrom<D>& from, CurveInput<D> input,
                                                  const BackMesh<D>& field, const CurveOptions& edges,
                                                  const PlacementOptions& options, const Execution& execution);

}  // namespace camber
