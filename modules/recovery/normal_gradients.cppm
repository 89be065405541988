module;
#include <span>
#include <vector>
export module camber.recovery:normal_gradients;
import camber.core;
import camber.bezier;
import :derivatives;

export namespace camber {

/// Derivatives of a solution along the normals of the facets that have a reference, integrated over these (2D: along
/// them).
struct NormalGradients {
    Reference reference = 0;
    double area = 0;      ///< of the straight facets
    double integral = 0;  ///< ∫ |∂u/∂n|
    double squares = 0;   ///< ∫ (∂u/∂n)²
};

/// The normal derivatives of fields on facets of the boundary and of interfaces, by rising reference. Of several fields
/// the derivative at a corner of a facet is
///
///     sqrt(Σ_f (weight_f ∂u_f/∂n)²),
///
/// with the normal of the curved facet there and the derivatives in an element at the facet; at an interface it is the
/// larger one of both sides. Integrals are sums over corners. `balls` are those of the elements, \p derivatives those
/// of `recover_derivatives` on \p mesh, with one weight for each field. Errors: not one weight for each field (usage);
/// memory; stopped.
template <int D>
[[nodiscard]] Outcome<std::vector<NormalGradients>> normal_gradients(const QuadraticMesh<D>& mesh,
                                                                     const Incidence<ElementId>& balls,
                                                                     const RecoveredDerivatives<D>& derivatives,
                                                                     std::span<const double> weights,
                                                                     const Execution& execution);

}  // namespace camber
