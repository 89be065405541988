export module camber.cavity:edge_models;
import camber.core;
import camber.metric;
import camber.validity;

export namespace camber {

/// What it costs the edges to have their nodes elsewhere than `wanted`, as shares of their lengths, to second order:
/// from the energy in the field `back`, whose mesh is the straight form of `mesh`. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<QuadraticModel<D>>> edge_models(const QuadraticMesh<D>& mesh,
                                                             const Column<LagrangeNode<D>>& wanted,
                                                             const Incidence<ElementId>& shells,
                                                             const BackMesh<D>& back, const Execution& execution);

/// The same without a field: in the mean natural metric of the edge's elements.
template <int D>
[[nodiscard]] Outcome<Buffer<QuadraticModel<D>>> implied_edge_models(const QuadraticMesh<D>& mesh,
                                                                     const Column<LagrangeNode<D>>& wanted,
                                                                     const Incidence<ElementId>& shells,
                                                                     const Execution& execution);

}  // namespace camber
