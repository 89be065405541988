export module camber.curving:edge_models;
import camber.core;
import camber.metric;
import camber.validity;
import camber.programmes;

export namespace camber {

/// What it costs the edges to have their nodes elsewhere than `wanted`, as shares of their lengths, quadratic: the
/// Hessian of the energy in the field `back`, whose mesh is the straight form of `mesh`, with slides along the edge
/// made cheap, as they change no length; near elements that are not valid each direction's weight is fitted to the
/// length that is lost at a small offset, since the field's kinks tell more there than its curvature. Errors: stopped.
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
