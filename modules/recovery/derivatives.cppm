module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>
export module camber.recovery:derivatives;
import camber.core;
import :material_rows;

export namespace camber {

struct RecoveryOptions {
    int rings = 2;
    int max_rings = 5;
    double core = 0.3;
    int boundary_rings = 3;

    [[nodiscard]] static constexpr auto options() {
        using S = RecoveryOptions;
        return std::tuple(
            option("rings", &S::rings, "rings of nodes around a vertex that a polynomial is fitted to, at least")
                .at_least(1)
                .at_most(6),
            option("max_rings", &S::max_rings,
                   "rings up to which it grows while nodes are few, or do not determine it well")
                .at_least(1)
                .at_most(8),
            option("core", &S::core,
                   "weights of nodes are 1/(core + y), y their distance in the stencil's own measure, at most 1")
                .at_least(1e-3)
                .at_most(1e3),
            option("boundary_rings", &S::boundary_rings,
                   "rings within which a vertex of the boundary looks for inner ones whose polynomials it takes")
                .at_least(0)
                .at_most(8));
    }
    friend bool operator==(const RecoveryOptions&, const RecoveryOptions&) = default;
};

/// What derivatives of a row come from.
enum class RowSource : std::uint8_t {
    own_fit,     ///< a polynomial over the nodes around
    inner_fits,  ///< on the boundary of its material: the mean of the polynomials of inner vertices nearby
};

/// Derivatives of one field, a row each of `MaterialRows`; in units of the field by those of length.
template <int D>
struct FieldDerivatives {
    Column<Vec<D>> gradients;
    Column<Sym<D>> hessians;
    Column<CubicForm<D>> thirds;  ///< of fields of degree 2; else none
};

/// Derivatives of fields at the vertices, one-sided where materials meet.
template <int D>
struct RecoveredDerivatives {
    MaterialRows rows;
    int degree = 1;                           ///< of the fields
    std::vector<FieldDerivatives<D>> fields;  ///< in the order given
    Column<RowSource> sources;                ///< a row
    /// The degree of the polynomial of each row, at most that of the fields + 3; derivatives of a higher order are 0.
    Column<std::uint8_t> polynomial_degrees;
    std::size_t from_inner_fits = 0;  ///< rows
    std::size_t lower_degree = 0;     ///< rows whose polynomial is of a degree below that of the fields + 2
    std::size_t missing = 0;          ///< among them: of one that leaves derivatives of the highest order 0
};

/// Derivatives at the vertices of fields that are known by their values at the nodes: of degree k = 1 at the vertices,
/// of degree 2 then at the edges' nodes, in the order of `mesh.edges`. The number of values tells the degree; for
/// degree 1 `edges` and `mid_nodes` are not looked at (see the overload). Fields of one call, or components of a
/// vector, share stencils and factors; their derivatives are those of one call each, to the last bit.
///
/// At an inner vertex (of its material) a polynomial of degree k + 3 is fitted to the values at rings of nodes, in
/// coordinates whitened by their covariance; at one of the boundary the polynomials of inner vertices nearby are taken
/// there and averaged. Polynomials of degree k + 2 are exact wherever `lower_degree` does not count. Method and
/// figures: docs/algorithms/recovery.md (after Zhang and Naga, SIAM J. Sci. Comput. 26, 2005).
///
/// Errors: usage (a number of values that is neither, or not that of the first field; a value that is not finite; a
/// limit of the options; derivatives beyond the range of numbers), input (not one reference an element; a node that is
/// not at a finite place; more than two elements on a face); memory; stopped.
template <int D>
[[nodiscard]] Outcome<RecoveredDerivatives<D>> recover_derivatives(const QuadraticMesh<D>& mesh,
                                                                   std::span<const Column<double>> fields,
                                                                   const RecoveryOptions& options,
                                                                   const Execution& execution);

/// The same of fields of degree 1 on a mesh of degree 1.
template <int D>
[[nodiscard]] Outcome<RecoveredDerivatives<D>> recover_derivatives(const LinearMesh<D>& mesh,
                                                                   std::span<const Column<double>> fields,
                                                                   const RecoveryOptions& options,
                                                                   const Execution& execution) {
    return recover_derivatives<D>(QuadraticMesh<D>{mesh, {}, {}}, fields, options, execution);
}

}  // namespace camber
