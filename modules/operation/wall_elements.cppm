module;
#include <cstddef>
export module camber.operation:wall_elements;
import camber.core;
import camber.cavity;
import :state;

/// Elements with two facets on one smooth surface: flat where the surface is smooth and the facets small, and folded
/// once they are curved, wherever the nodes of their edges are put.
export namespace camber {

/// Whether an element has two facets of one reference that meet where the surface does not break.
template <int D>
[[nodiscard]] bool is_wall_element(const DynamicMesh<D>& mesh, ElementId e);

/// Whether a patch makes more of them than it removes. Not so where there is no geometry, nor of a plane.
template <int D>
[[nodiscard]] bool adds_wall_elements(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const Patch<D>& patch);

}  // namespace camber
