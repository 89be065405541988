module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>
export module camber.recovery:derivatives;
import camber.core;
import camber.bezier;

export namespace camber {

/// Rows for values at vertices that may break where materials meet: a vertex has one for each reference among its
/// elements. One inside of a material has one row, one of no element none; rows count on from vertex to vertex.
struct MaterialRows {
    Incidence<Reference> materials;  ///< around each vertex, rising: those of its rows

    [[nodiscard]] std::size_t size() const { return materials.items.size(); }
    [[nodiscard]] std::size_t vertices() const { return materials.size(); }
    /// The first row of a vertex; the others follow.
    [[nodiscard]] std::size_t first(VertexId v) const { return materials.offsets[v.index()]; }
    /// The row of a vertex on the side of a material; none where it has no element there.
    [[nodiscard]] std::optional<std::size_t> row(VertexId v, Reference material) const {
        const auto around = materials[v];
        for (std::size_t i = 0; i < around.size(); ++i)
            if (around[i] == material) return first(v) + i;
        return {};
    }
    friend bool operator==(const MaterialRows& a, const MaterialRows& b) {
        return a.materials.offsets == b.materials.offsets && a.materials.items == b.materials.items;
    }
};

/// The row that element e sees at its local vertex i: that of its own material. For rows of the same mesh.
template <int D>
[[nodiscard]] std::size_t row_of(const MaterialRows& rows, const LinearMesh<D>& mesh, ElementId e, int i) {
    return *rows.row(mesh.elements.vertices[e][i], mesh.elements.references[e]);
}

/// The rows of a mesh with its balls. Errors: input (not one reference an element; more rows than 32 bits count);
/// memory; stopped.
template <int D>
[[nodiscard]] Outcome<MaterialRows> material_rows(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  const Execution& execution);

/// 1 for the rows on the boundary of their material: at a face of an element of it that no other element of it shares,
/// where the mesh ends or another material begins. Errors: those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<std::uint8_t>> boundary_rows(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                          const MaterialRows& rows, const Execution& execution);

}  // namespace camber

namespace camber {

/// Errors: input (not one reference an element).
[[nodiscard]] Outcome<Done> check_materials(std::size_t references, std::size_t elements);

}  // namespace camber

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

/// A function within an element by a polynomial of that degree in its reference coordinates, given by its values at the
/// regular lattice α/5 of the element as the mesh has it, curved or not; α in the order of `multi_indices`, less that
/// at the first.
inline constexpr int lattice_degree = 5;
template <int D>
using LatticeValues = std::array<float, node_count<lattice_degree, D>>;

/// What is known within elements of fields that are known by their values at the nodes, as for `recover_derivatives`:
/// the polynomial of degree k + 3 that is nearest to the values at the nodes around the element, those nearer counting
/// more, through elements of its material; of a lower degree where nodes are too few. A layer that is no wider than an
/// element is told by these, where derivatives at vertices tell it too late. Values are those in the elements of
/// \p curved: the same mesh, with mid nodes of its own. docs/algorithms/solution-nodes.md.
///
/// Errors: as for `recover_derivatives`.
template <int D>
[[nodiscard]] Outcome<std::vector<Column<LatticeValues<D>>>> element_values(const QuadraticMesh<D>& mesh,
                                                                            std::span<const Column<double>> fields,
                                                                            const QuadraticMesh<D>& curved,
                                                                            const Execution& execution);

/// A function of the place: what makes its evaluators, one for each thread, which write its values at points into a
/// span of the same size.
template <int D>
using FunctionOfPlace = std::function<std::function<void(std::span<const Vec<D>>, std::span<double>)>()>;

/// Values in a unit that is 2^exponent of the user's.
template <int D>
struct FunctionValues {
    Column<LatticeValues<D>> rows;
    int exponent = 0;
};
/// The same of a function that is known everywhere, in a unit of its own: its values at the lattice. Errors: usage (a
/// function that has no finite value in an element); memory; stopped.
template <int D>
[[nodiscard]] Outcome<FunctionValues<D>> element_values(const QuadraticMesh<D>& mesh,
                                                        const FunctionOfPlace<D>& function, const Execution& execution);

/// The exponent of the power of two in which the range of these values is about 1; 0 of a constant, of none, and of
/// values that are not finite.
[[nodiscard]] inline int own_exponent(std::span<const double> values) {
    if (values.empty()) return 0;
    const auto [least, largest] = std::minmax_element(values.begin(), values.end());
    const double half_range = *largest / 2 - *least / 2;
    return half_range > 0 && std::isfinite(half_range) ? std::ilogb(half_range) : 0;
}

/// A field in a unit of its own, a power of two, in which its range is about 1: products of derivatives neither vanish
/// nor overflow, whatever the user's unit, and not a bit of what is made of it depends on that.
[[nodiscard]] inline Column<double> in_own_unit(const Column<double>& values) {
    const int exponent = own_exponent(values);
    if (exponent == 0) return values;
    Buffer<double> scaled(values.begin(), values.end());
    for (double& x : scaled) x = std::scalbn(x, -exponent);
    return Column<double>(std::move(scaled));
}

/// Relation of the values of a field to the nodes of a mesh.
enum class NodeOrder : std::uint8_t {
    plausible,            ///< nothing speaks against the order, or there are too few different values to tell
    by_first_element,     ///< certain: edges' values fit the order in which elements, one after the other, name their
                          ///< edges
    unrelated_mid_nodes,  ///< certain: vertices' values are related, edges' values are not related to those of their
                          ///< ends
    unrelated,            ///< values at neighbouring nodes are no more alike than those of a random order
};

/// The verdict, and the correlations that it was found by: of neighbouring vertices, and of edges' nodes with the mean
/// of the ends (fields of degree 2).
struct NodeOrderCheck {
    NodeOrder order = NodeOrder::plausible;
    double between_vertices = 1, between_ends_and_middle = 1;
};

/// Compares the order of a field's values with the mesh: at the vertices, or then at the edges' nodes in the order of
/// `mesh.edges`. The values are compressed, asinh((u − median)/(10⁻³ range)), so that neither a few large values nor
/// noise of 10⁻⁶ decides. Method and measured values: docs/algorithms/recovery.md. Errors: numbers of values that are
/// not of this mesh (usage); stopped, memory.
template <int D>
[[nodiscard]] Outcome<NodeOrderCheck> check_node_order(const QuadraticMesh<D>& mesh, const Column<double>& values,
                                                       const Execution& execution);

/// Derivatives of a solution along the normals of the facets that have a reference, integrated over these (2D: along
/// them).
struct NormalGradients {
    Reference reference = 0;
    double area = 0;      ///< of the straight facets
    double integral = 0;  ///< ∫ |∂u/∂n|
    double squares = 0;   ///< ∫ (∂u/∂n)²
};

/// The normal derivatives of fields on facets of the boundary and of interfaces, by rising reference. Of several fields
/// the derivative at a corner of a facet is
///
///     sqrt(Σ_f (weight_f ∂u_f/∂n)²),
///
/// with the normal of the curved facet there and the derivatives in an element at the facet; at an interface it is the
/// larger one of both sides. Integrals are sums over corners. `balls` are those of the elements, \p derivatives those
/// of `recover_derivatives` on \p mesh, with one weight for each field. Errors: not one weight for each field (usage);
/// memory; stopped.
template <int D>
[[nodiscard]] Outcome<std::vector<NormalGradients>> normal_gradients(const QuadraticMesh<D>& mesh,
                                                                     const Incidence<ElementId>& balls,
                                                                     const RecoveredDerivatives<D>& derivatives,
                                                                     std::span<const double> weights,
                                                                     const Execution& execution);

}  // namespace camber
