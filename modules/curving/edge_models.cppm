module;
#include <cstdint>
#include <span>
export module camber.curving:edge_models;
import camber.core;
import camber.metric;
import camber.validity;
import camber.programmes;
import :edge_target;

export namespace camber {

/// What the model of an edge agrees with: the error of interpolation; the Hessian of its energy; or the length that is
/// lost at a small offset, since near what is to be repaired the field's kinks tell more than its curvature.
enum class ModelFit : std::uint8_t { accuracy, energy, length };

/// What it costs an edge to have its node elsewhere than `wanted`, quadratic, in the field `back`, whose mesh is the
/// straight form of `mesh`. Energy and length: as a share of the edge's length; slides along the edge are cheap, as
/// they change no length. Accuracy: the offset's metric length squared by the chord's, in all directions alike (the
/// third derivatives that an offset o leaves in an element are Σ (cᵀ H o)² over its edges c, and these are one unit
/// long in the metric). `shell`: the elements around the edge.
template <int D>
[[nodiscard]] QuadraticModel<D> edge_model(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& wanted,
                                           std::span<const ElementId> shell, const BackMesh<D>& back, ModelFit fit);

/// The models of all edges for nodes of this aim; those of energy and length are fitted to lengths near elements that
/// are not valid. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<QuadraticModel<D>>> edge_models(CurvingAim aim, const QuadraticMesh<D>& mesh,
                                                             const Column<LagrangeNode<D>>& wanted,
                                                             const Validation<D>& validation,
                                                             const Incidence<ElementId>& shells,
                                                             const BackMesh<D>& back, const Execution& execution);

/// The same without a field: in the mean natural metric of the edge's elements.
template <int D>
[[nodiscard]] Outcome<Buffer<QuadraticModel<D>>> implied_edge_models(const QuadraticMesh<D>& mesh,
                                                                     const Column<LagrangeNode<D>>& wanted,
                                                                     const Incidence<ElementId>& shells,
                                                                     const Execution& execution);

}  // namespace camber
