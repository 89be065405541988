export module camber.cavity:edge_models;
import camber.core;
import camber.metric;

export namespace camber {

/// What it costs an edge to have its node at P, near `centre`, where it would best be: ½ (P − centre)ᵀ H (P − centre),
/// as a share of the edge's length, to second order.
template <int D>
struct EdgeModel {
    Vec<D> centre;
    Sym<D> hessian;
    friend bool operator==(const EdgeModel&, const EdgeModel&) = default;
};

/// Models of all edges about the nodes `wanted`, from the energy in the field `back`, whose mesh is the straight form
/// of `mesh`. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<EdgeModel<D>>> edge_models(const QuadraticMesh<D>& mesh,
                                                        const Column<LagrangeNode<D>>& wanted,
                                                        const Incidence<ElementId>& shells, const BackMesh<D>& back,
                                                        const Execution& execution);

/// The same without a field: in the mean natural metric of the edge's elements.
template <int D>
[[nodiscard]] Outcome<Buffer<EdgeModel<D>>> implied_edge_models(const QuadraticMesh<D>& mesh,
                                                                const Column<LagrangeNode<D>>& wanted,
                                                                const Incidence<ElementId>& shells,
                                                                const Execution& execution);

}  // namespace camber
