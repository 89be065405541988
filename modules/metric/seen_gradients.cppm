module;
#include <array>
module camber.metric:seen_gradients;
import camber.core;
import :back_mesh;
import :curved_back;

namespace camber {

/// F = I + 4 Σ_j u_vj ⊗ ∇ξ_j at the corner v of an element; `gradients`: barycentric_gradients.
template <int D>
[[nodiscard]] Mat<D> jacobian_at_corner(const CurvedBack<D>& back, ElementId e, VertexId v,
                                        const std::array<Vec<D>, D + 1>& gradients);

/// Relative gradients of a curved back mesh (see CurvedBack): of each vertex the mean over its ball, weighted by
/// volume, of the gradients of log(Fᵀ M F), linear in the elements, each brought into space by the map at its corner.
/// Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<LogGradient<D>>> relative_gradients(const CurvedBack<D>& back,
                                                                 const Incidence<ElementId>& balls,
                                                                 const Execution& execution);

}  // namespace camber
