module;
#include <cstddef>
#include <span>
export module camber.validity:validate;
import camber.core;
import camber.bezier;
import :jacobian;
import :verdict;

export namespace camber {

/// Verdicts of a whole mesh.
template <int D>
struct Validation {
    double bound = 0;          ///< what the verdicts were asked for
    Column<Verdict> verdicts;  ///< one an element
    /// Certified lower bounds of det J / |det straight|, one an element: within 1e-3 of the minimum (as
    /// ElementValidity says) where the coefficients alone did not decide and where the smallest of the mesh might be;
    /// the smallest coefficient elsewhere. ±∞ where the straight element is flat.
    Column<float> min_scaled_jacobian;
    std::size_t invalid = 0, undecided = 0;
    std::size_t straight_inverted = 0;  ///< elements whose straight counterpart is flat or inverted
    double smallest = 1;                ///< of min_scaled_jacobian, flat ones left out; within 1e-3 of the true minimum
    ElementId worst;                    ///< where it is; invalid when there is no element to speak of

    [[nodiscard]] bool all_valid() const { return invalid == 0 && undecided == 0; }
    friend bool operator==(const Validation&, const Validation&) = default;
};

/// The third verb: verdicts of all elements with the proposed nodes. Speaks of the stored Lagrange nodes. Errors: a
/// proposal of another mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<Validation<D>> validate(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, double bound,
                                              const Execution& execution);

/// The same with the mesh's own nodes.
template <int D>
[[nodiscard]] Outcome<Validation<D>> validate(const QuadraticMesh<D>& mesh, double bound, const Execution& execution);

/// A validation of the mesh brought up to date after nodes of `touched` elements changed; the others are not looked at
/// again.
template <int D>
[[nodiscard]] Outcome<Validation<D>> revalidate(const QuadraticMesh<D>& mesh,
                                                std::span<const LagrangeNode<D>> mid_nodes, Validation<D> before,
                                                std::span<const ElementId> touched, const Execution& execution);

/// An element of the mesh with other mid nodes.
template <int D>
[[nodiscard]] inline NodalSimplex<D> nodal_element(const QuadraticMesh<D>& mesh,
                                                   std::span<const LagrangeNode<D>> mid_nodes, ElementId e) {
    return nodal_form<D>(mesh.linear.points, mid_nodes, mesh.linear.elements.vertices[e], mesh.edges.of_elements[e]);
}

}  // namespace camber
