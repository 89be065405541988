module;
#include <cstdint>
#include <span>
export module camber.curving:edge_models;
import camber.core;
import camber.metric;
import camber.validity;
import camber.programmes;

export namespace camber {

/// What the model of an edge agrees with: the Hessian of its energy; or the length that is lost at a small offset,
/// since near what is to be repaired the field's kinks tell more than its curvature.
enum class ModelFit : std::uint8_t { energy, length };

/// What it costs an edge to have its node elsewhere than `wanted`, as a share of its length, quadratic, in the field
/// `back`, whose mesh is the straight form of `mesh`; slides along the edge are cheap, as they change no length.
/// `shell`: the elements around the edge.
template <int D>
[[nodiscard]] QuadraticModel<D> edge_model(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& wanted,
                                           std::span<const ElementId> shell, const BackMesh<D>& back, ModelFit fit);

/// The models of all edges, fitted to lengths near elements that are not valid. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<QuadraticModel<D>>> edge_models(const QuadraticMesh<D>& mesh,
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
