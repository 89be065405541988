module;
#include <cstddef>
#include <utility>
export module camber.solution_metric:models;
import camber.core;
import :local_model;

export namespace camber {

/// Local models, one a vertex or one an element.
template <int D>
struct LocalModels {
    Column<LocalModel<D>> rows;
    std::size_t zero = 0, floored = 0;  ///< rows of these kinds
};

/// Models of degree k = 1 and 2 from rows of second and third derivatives, of vertices or of elements, in any unit.
/// Errors: a row that is not finite (input, entity "derivatives, row N"); a limit of the options (usage); memory;
/// stopped.
template <int D>
[[nodiscard]] Outcome<LocalModels<D>> hessian_models(const Column<Sym<D>>& hessians, const ModelOptions& options,
                                                     const Execution& execution);
template <int D>
[[nodiscard]] Outcome<LocalModels<D>> cubic_models(const Column<CubicForm<D>>& thirds, const ModelOptions& options,
                                                   const Execution& execution);

/// Of each element the mean of its vertices' rows (vectors, Hessians or third derivatives): what linear interpolation
/// has at its centroid. row_of(e, i): the row that element e sees at its local vertex i. Errors: memory; stopped.
template <class Row, int D, class RowOf>
[[nodiscard]] Outcome<Column<Row>> element_means(const LinearMesh<D>& mesh, const Column<Row>& rows, RowOf&& row_of,
                                                 const Execution& execution) {
    auto means = map_each(execution, mesh.elements.size(), [&](std::size_t e) {
        Row sum{};
        for (int i = 0; i <= D; ++i) sum += rows[row_of(ElementId(e), i)];
        sum *= 1.0 / (D + 1);
        return sum;
    });
    if (!means) return fail(means.error());
    return Column<Row>(std::move(*means));
}

/// Of rows of the vertices. Errors: rows that are not one a vertex (usage); those above.
template <class Row, int D>
[[nodiscard]] Outcome<Column<Row>> element_means(const LinearMesh<D>& mesh, const Column<Row>& at_vertices,
                                                 const Execution& execution) {
    if (at_vertices.size() != mesh.points.size())
        return fail(ErrorKind::usage, "the derivatives are of another mesh: there must be one row a vertex");
    const auto row_of = [&](ElementId e, int i) { return mesh.elements.vertices[e][i].index(); };
    return element_means(mesh, at_vertices, row_of, execution);
}

/// Models of the elements of a curved mesh, from an element's own derivatives (those at its centroid, `element_means`).
/// What an element interpolates is u∘F on the reference element, F its map, whose Jacobian at the centroid is J and
/// whose second derivatives F_ab are constant:
///
///     k = 1:  Ĥ_ab  = H[J_a, J_b] + ∇u·F_ab
///     k = 2:  T̂_abc = T[J_a, J_b, J_c] + H[F_ab, J_c] + H[F_bc, J_a] + H[F_ca, J_b]
///
/// The model Q̂ is made there and brought to space: Q = J⁻ᵀ Q̂ J⁻¹. It sees what the element's curves take away of the
/// error. On straight elements it is the model of H or T. An element that is flat at its centroid has the zero model.
/// Errors: those above, by element; rows that are not one an element (usage).
template <int D>
[[nodiscard]] Outcome<LocalModels<D>> curved_hessian_models(const QuadraticMesh<D>& mesh,
                                                            const Column<Vec<D>>& gradients,
                                                            const Column<Sym<D>>& hessians, const ModelOptions& options,
                                                            const Execution& execution);
template <int D>
[[nodiscard]] Outcome<LocalModels<D>> curved_cubic_models(const QuadraticMesh<D>& mesh, const Column<Sym<D>>& hessians,
                                                          const Column<CubicForm<D>>& thirds,
                                                          const ModelOptions& options, const Execution& execution);

}  // namespace camber
