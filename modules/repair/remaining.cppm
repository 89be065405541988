module;
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>
export module camber.repair:remaining;
import camber.core;
import camber.validity;
import :repaired;

export namespace camber {

/// An element that could not be repaired, and why, as far as that can be told.
struct RemainingElement {
    ElementId element;
    std::string reason;
    VertexId at = {};          ///< where the reason is; not valid: nowhere in particular
    bool is_given_up = false;  ///< the work that may be spent was spent
};

/// "the boundary alone makes its scaled Jacobian -1.24 at vertex 64": `vertex` is what that vertex is called.
[[nodiscard]] std::string sentence_of(const RemainingElement& element, std::string_view vertex);

/// The elements that are not certified valid, in the mesh's order, and why, as far as that can be told: a straight
/// element without volume; a determinant at a vertex that boundary nodes alone decide (there the columns are
/// 4 P_ij − 3 P_i − P_j); required edges and vertices; a facet of the boundary that is folded, seen from its straight
/// form; nodes that are all on the boundary; else nothing that forbids it is known.
template <int D>
[[nodiscard]] std::vector<RemainingElement> remaining(const Repaired<D>& repaired);

/// Those of them that hold something required, or on which the work was spent, with that reason: for a mesh whose
/// boundary may leave the geometry, where the others had all the freedom there is.
template <int D>
[[nodiscard]] std::vector<RemainingElement> remaining_but_for_shape(const Repaired<D>& repaired);

/// How far boundary nodes are from where the mesh has them.
struct BoundaryShift {
    std::size_t moved_nodes = 0;
    double largest = 0;           ///< of a node (model units)
    double largest_relative = 0;  ///< the same by the length of its edge's chord
};
template <int D>
[[nodiscard]] BoundaryShift boundary_shift(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal);

}  // namespace camber
