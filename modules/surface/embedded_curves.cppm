module;
#include <array>
#include <cstddef>
#include <optional>
#include <span>
export module camber.surface:embedded_curves;
import camber.core;
import camber.box_tree;
import :cubic;
import :features;
import :geometry;

export namespace camber {

/// The curves of a mesh at which nothing breaks (3D; in 2D facets are the curves, and the geometry knows them): edges
/// that its maker lists, or that part two entities of his, where the surface goes on smoothly, and listed edges inside
/// the volume. A geometry knows the surface around such a curve, not the curve, so it is kept as the mesh has it.
template <int D>
struct EmbeddedCurves {
    /// Of one edge.
    struct Piece {
        CubicSimplex<1, D> curve;
        Reference reference = 0;
    };
    Column<Piece> pieces;
    Column<EdgeId> edges;      ///< of the mesh that they were found in, one a piece
    BoxTree<D> tree;           ///< over their control points
    Column<VertexId> corners;  ///< of the mesh that they were found in, rising: where a curve turns
};

/// Curves in a mesh with these features. A piece is the edge's own curve where the mesh has `nodes` (one a unique edge;
/// none: an empty span); else, on a surface of the geometry, as smooth as a ridge curve of the surrogate; else
/// straight. Corners are where two edges of a curve turn by more than 40 degrees, beside a straight one by more than
/// rounding. Errors: of find_features and build_surrogate.
template <int D>
[[nodiscard]] Outcome<EmbeddedCurves<D>> find_embedded_curves(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                              const Features<D>& features, const Geometry<D>& geometry,
                                                              std::span<const LagrangeNode<D>> nodes,
                                                              const Execution& execution);

/// The closest point of all curves with that reference, if there are any.
template <int D>
[[nodiscard]] std::optional<Vec<D>> closest_on_curves(const EmbeddedCurves<D>& curves, Reference reference,
                                                      const Vec<D>& p);

/// `nodes` (one a unique edge of the mesh) with those of the curves' edges on the boundary in the middles of their
/// pieces, put onto the surface that the geometry has there. Edges that are required keep theirs, and edges inside the
/// volume. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LagrangeNode<D>>> nodes_on_curves(const QuadraticMesh<D>& mesh,
                                                               Buffer<LagrangeNode<D>> nodes,
                                                               const EmbeddedCurves<D>& curves,
                                                               const Geometry<D>& geometry, const Execution& execution);

/// `kinds` with the curves' edges as ridges: what moves nodes within a surface, or in the volume, leaves them.
template <int D>
[[nodiscard]] Column<EdgeKind> kinds_with_curves(const Column<EdgeKind>& kinds, const EmbeddedCurves<D>& curves);

}  // namespace camber
