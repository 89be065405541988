module;
#include <cstdint>
#include <functional>
#include <span>
export module camber.curving:edge_models;
import camber.core;
import camber.metric;
import camber.validity;
import camber.optimisation;
import :edge_target;

export namespace camber {

/// What the model of an edge agrees with: the error of interpolation; or the length that is lost at a small offset,
/// since the field's kinks tell more than the curvature of an energy.
enum class ModelFit : std::uint8_t { accuracy, length };

/// What it costs an edge to have its node elsewhere than `wanted`, quadratic, in the field `back`, whose mesh is the
/// straight form of `mesh`. Length: as a share of the edge's length; slides along the edge are cheap, as
/// they change no length. Accuracy: the offset's metric length squared by the chord's, in all directions alike (the
/// third derivatives that an offset o leaves in an element are Σ (cᵀ H o)² over its edges c, and these are one unit
/// long in the metric). `shell`: the elements around the edge.
template <int D>
[[nodiscard]] QuadraticModel<D> edge_model(const QuadraticMesh<D>& mesh, EdgeId edge, const LagrangeNode<D>& wanted,
                                           std::span<const ElementId> shell, const BackMesh<D>& back, ModelFit fit);

/// What it costs an edge to have its node off its wanted place: a pure function, asked from several threads.
template <int D>
using EdgeModels = std::function<QuadraticModel<D>(EdgeId)>;

/// Those of nodes that were found by this aim; of energy and length they are fitted to lengths.
template <int D>
[[nodiscard]] EdgeModels<D> edge_models(CurvingAim aim, const QuadraticMesh<D>& mesh,
                                        const Column<LagrangeNode<D>>& wanted, const Incidence<ElementId>& shells,
                                        const BackMesh<D>& back);

/// The same of one edge without a field: in the mean natural metric of the edge's elements.
template <int D>
[[nodiscard]] QuadraticModel<D> implied_edge_model(const QuadraticMesh<D>& mesh, EdgeId edge,
                                                   const LagrangeNode<D>& wanted, std::span<const ElementId> shell);

/// Those of all edges.
template <int D>
[[nodiscard]] EdgeModels<D> implied_edge_models(const QuadraticMesh<D>& mesh, const Column<LagrangeNode<D>>& wanted,
                                                const Incidence<ElementId>& shells);

}  // namespace camber
