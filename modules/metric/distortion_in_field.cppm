module;
#include <array>
#include <cstddef>
export module camber.metric:distortion_in_field;
import camber.core;
import :back_mesh;
import :distortion;
import :spd;

export namespace camber {

/// The derivative of a curved element's mean quality (see :distortion) by the logarithms of the metrics at its vertices
/// while the nodes stay: the change is Σ_i ⟨Z_i, dL_i⟩. At a point, with P = (J W⁻¹)(J W⁻¹)ᵀ and M = exp(S) of det 1,
///     dη = ⟨D exp(S)[P], dS⟩ / (D |det J W⁻¹|^{2/D}),   dS = Σ ξ_i dL_i less its trace,
/// since D exp(S) is its own adjoint. Each Z_i has no trace: scaling a metric changes nothing. Zero where the mean is
/// 0.
template <int D>
[[nodiscard]] std::array<Sym<D>, D + 1> curved_quality_by_metrics(const QuadraticNodes<D>& nodes,
                                                                  const VertexLogMetrics<D>& vertices);

/// curved_quality_gradient of an element whose vertices take their metrics from a field along as they move: of each
/// vertex the field's gradient there, ∂_k log M. Mid nodes stay.
template <int D>
[[nodiscard]] CurvedQualityGradient<D> curved_quality_gradient_in_field(
    const QuadraticNodes<D>& nodes, const VertexLogMetrics<D>& vertices,
    const std::array<LogGradient<D>, D + 1>& gradients);

}  // namespace camber
