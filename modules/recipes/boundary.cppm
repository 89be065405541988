module;
#include <optional>
#include <span>
export module camber.recipes:boundary;
import camber.core;
import camber.bezier;
import camber.surface;

export namespace camber {

/// The boundary of a mesh as recipes take it: its ridges and corners, the shape that its nodes go onto, and whether
/// required nodes go along.
template <int D>
struct Boundary {
    Features<D> features;
    RequiredBoundary required = RequiredBoundary::keep;
    Geometry<D> geometry;
};

template <int D>
struct BoundaryOptions {
    FeatureOptions<D> features = {};
    RequiredBoundary required = RequiredBoundary::keep;
};

/// With the geometry that is given, or without one smooth surfaces through the mesh's own vertices (the surrogate):
/// with the boundary's own curves where `nodes` of the mesh's edges tell them, one an edge. Errors: those of
/// find_features and build_surrogate.
template <int D>
[[nodiscard]] Outcome<Boundary<D>> find_boundary(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                 const std::optional<Geometry<D>>& given,
                                                 const BoundaryOptions<D>& options, const Execution& execution,
                                                 std::span<const LagrangeNode<D>> nodes = {});

}  // namespace camber
