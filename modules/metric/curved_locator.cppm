module;
#include <cstddef>
export module camber.metric:curved_locator;
import camber.core;
import camber.box_tree;
import :back_mesh;

/// Where a point lies in a curved mesh of degree 2, for whatever field lives on it.
export namespace camber {

/// A mesh of degree 2 with what location in it needs: an immutable value, asked by many threads at once. In an element
/// a point is x = F_K(ξ) = Σ ξ_i P_i + Σ_e 4 ξ_i ξ_j u_e; the straight mesh of the same vertices is never asked.
template <int D>
class CurvedLocator {
  public:
    QuadraticMesh<D> mesh;
    Neighbours<D> neighbours;
    Column<ElementFace> boundary;
    BoxTree<D> boundary_tree;  ///< boxes of the Bézier points of `boundary`
    BoxTree<D> element_tree;   ///< the same of the elements

    /// The element that holds p, `inside` only with a proof (`root_radius`); else the nearest point of the curved
    /// boundary stands for it. The search begins at `hint`, on which the answer does not depend up to rounding. The
    /// mesh has elements.
    [[nodiscard]] Location<D> locate(const Vec<D>& p, ElementId hint) const;
    /// A hint for a point of which nothing is known: an element whose box holds p, or no element.
    [[nodiscard]] ElementId hint_for(const Vec<D>& p) const;
};

/// Linear but for the trees. Errors: those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<CurvedLocator<D>> make_curved_locator(QuadraticMesh<D> mesh, const Incidence<ElementId>& balls,
                                                            const Execution& execution);

}  // namespace camber
