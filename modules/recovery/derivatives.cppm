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

/// Numbering of vertex values that may jump between materials. A vertex has one row for each reference of its elements.
/// Rows are ordered by vertex.
struct MaterialRows {
    Incidence<Reference> materials;  ///< references of the elements around each vertex, ascending; each is one row

    [[nodiscard]] std::size_t size() const { return materials.items.size(); }
    [[nodiscard]] std::size_t vertices() const { return materials.size(); }
    [[nodiscard]] std::size_t first(VertexId v) const { return materials.offsets[v.index()]; }
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

/// Precondition: `rows` belong to this mesh.
template <int D>
[[nodiscard]] std::size_t row_of(const MaterialRows& rows, const LinearMesh<D>& mesh, ElementId e, int i) {
    return *rows.row(mesh.elements.vertices[e][i], mesh.elements.references[e]);
}

/// Errors: input (not one reference per element; more rows than 32 bits count); memory; stopped.
template <int D>
[[nodiscard]] Outcome<MaterialRows> material_rows(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  const Execution& execution);

/// Marks rows on the boundary of their material with 1. The vertex of such a row is on a face with only one element of
/// the material. Errors: those of `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<Buffer<std::uint8_t>> boundary_rows(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                          const MaterialRows& rows, const Execution& execution);

}  // namespace camber

namespace camber {

/// Errors: input (not one reference per element).
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
            option("rings", &S::rings,
                   "smallest number of rings of nodes around a vertex to which a polynomial is "
                   "fitted")
                .at_least(1)
                .at_most(6),
            option("max_rings", &S::max_rings,
                   "largest number of rings, used if the nodes are too few or do not determine the polynomial well")
                .at_least(1)
                .at_most(8),
            option("core", &S::core,
                   "the weight of a node is 1/(core + y), with y its distance relative to the stencil, at most 1")
                .at_least(1e-3)
                .at_most(1e3),
            option("boundary_rings", &S::boundary_rings,
                   "number of rings in which a boundary vertex searches for inner vertices whose polynomials it uses")
                .at_least(0)
                .at_most(8));
    }
    friend bool operator==(const RecoveryOptions&, const RecoveryOptions&) = default;
};

enum class RowSource : std::uint8_t {
    own_fit,     ///< from a polynomial fitted to the nodes around the vertex
    inner_fits,  ///< row on the material's boundary: mean of the polynomials of inner vertices nearby
};

/// Derivatives of a field for each row of `MaterialRows`, in field units per length.
template <int D>
struct FieldDerivatives {
    Column<Vec<D>> gradients;
    Column<Sym<D>> hessians;
    Column<CubicForm<D>> thirds;  ///< third derivatives, only for fields of degree 2
};

/// Derivatives of fields at vertices. A vertex between materials has one row for each material.
template <int D>
struct RecoveredDerivatives {
    MaterialRows rows;
    int degree = 1;
    std::vector<FieldDerivatives<D>> fields;
    Column<RowSource> sources;
    /// Polynomial degree of each row, at most k + 3 for fields of degree k; higher derivatives are 0.
    Column<std::uint8_t> polynomial_degrees;
    std::size_t from_inner_fits = 0;  ///< number of rows with source `inner_fits`
    std::size_t lower_degree = 0;     ///< number of rows of degree below k + 2 (fields of degree k)
    std::size_t missing = 0;  ///< number of rows of degree below k + 1 (fields of degree k): highest derivatives are 0
};

/// Recovers derivatives of fields at the vertices. A field of degree k = 1 has one value for each vertex. A field of
/// degree k = 2 also has one for each edge, after those of the vertices, in the order of `mesh.edges`. The number of
/// values determines k. For k = 1, `edges` and `mid_nodes` of the mesh are ignored. Results are bitwise independent of
/// the other fields in the call, which share stencils.
///
/// At a vertex inside a material, a polynomial of degree k + 3 is fitted to rings of nodes, in coordinates whitened by
/// the covariance of the nodes. A boundary vertex gets the mean of the polynomials of inner vertices nearby.
/// Polynomials of degree k + 2 are recovered exactly, except in the rows that `lower_degree` counts. Method:
/// docs/algorithms/recovery.md (after Zhang and Naga, SIAM J. Sci. Comput. 26, 2005).
///
/// Errors: usage (numbers of values that differ or do not match the mesh; a value that is not finite; options or
/// derivatives out of range), input (not one reference per element; a node without finite coordinates; more than two
/// elements on a face); memory; stopped.
template <int D>
[[nodiscard]] Outcome<RecoveredDerivatives<D>> recover_derivatives(const QuadraticMesh<D>& mesh,
                                                                   std::span<const Column<double>> fields,
                                                                   const RecoveryOptions& options,
                                                                   const Execution& execution);

template <int D>
[[nodiscard]] Outcome<RecoveredDerivatives<D>> recover_derivatives(const LinearMesh<D>& mesh,
                                                                   std::span<const Column<double>> fields,
                                                                   const RecoveryOptions& options,
                                                                   const Execution& execution) {
    return recover_derivatives<D>(QuadraticMesh<D>{mesh, {}, {}}, fields, options, execution);
}

/// An element's polynomial is stored as its values at the lattice points with barycentric coordinates α/5. α: integers
/// with sum 5, in the order of `multi_indices`. The first value is subtracted from all.
inline constexpr int lattice_degree = 5;
template <int D>
using LatticeValues = std::array<float, node_count<lattice_degree, D>>;

/// Fits a least-squares polynomial to each field in each element, from nodal values as in `recover_derivatives`. For
/// fields of degree k, the degree is k + 3, or lower if nodes are few. Uses only nodes of the element's material; near
/// nodes have more weight. Unlike derivatives at vertices, these polynomials resolve layers as thin as an element.
/// Returns their values in the elements of \p curved, which is the same mesh with other mid nodes. Method:
/// docs/algorithms/solution-nodes.md.
template <int D>
[[nodiscard]] Outcome<std::vector<Column<LatticeValues<D>>>> element_values(const QuadraticMesh<D>& mesh,
                                                                            std::span<const Column<double>> fields,
                                                                            const QuadraticMesh<D>& curved,
                                                                            const Execution& execution);

/// Creates an evaluator; each thread needs its own. An evaluator stores the function's values at points in a span of
/// the same size.
template <int D>
using FunctionOfPosition = std::function<std::function<void(std::span<const Vec<D>>, std::span<double>)>()>;

/// Lattice values of a function in the unit 2^`exponent`.
template <int D>
struct FunctionValues {
    Column<LatticeValues<D>> rows;
    int exponent = 0;
};
/// Samples a function at the lattice points of each element. Errors: usage (a function without finite values in an
/// element); memory; stopped.
template <int D>
[[nodiscard]] Outcome<FunctionValues<D>> element_values(const QuadraticMesh<D>& mesh,
                                                        const FunctionOfPosition<D>& function,
                                                        const Execution& execution);

/// Exponent of a power of two near the range of the values. 0 for constant, empty or non-finite values.
[[nodiscard]] inline int range_exponent(std::span<const double> values) {
    if (values.empty()) return 0;
    const auto [least, largest] = std::minmax_element(values.begin(), values.end());
    const double half_range = *largest / 2 - *least / 2;
    return half_range > 0 && std::isfinite(half_range) ? std::ilogb(half_range) : 0;
}

/// Divides a field by a power of two, so that its range is about 1. Products of derivatives then do not overflow, and
/// results are bitwise independent of the user's unit.
[[nodiscard]] inline Column<double> in_unit_range(const Column<double>& values) {
    const int exponent = range_exponent(values);
    if (exponent == 0) return values;
    Buffer<double> scaled(values.begin(), values.end());
    for (double& x : scaled) x = std::scalbn(x, -exponent);
    return Column<double>(std::move(scaled));
}

enum class NodeOrder : std::uint8_t {
    plausible,            ///< no evidence against the order, or too few different values
    by_first_element,     ///< certain: edge values are ordered by the first element that contains the edge
    unrelated_mid_nodes,  ///< certain: neighbouring vertex values are related, but edge values are not related to the
                          ///< values at the edges' ends
    unrelated,            ///< neighbouring values are as different as in a random order
};

/// Verdict and correlations: between neighbouring vertices, and (degree 2) between edge values and the mean of the
/// ends' values.
struct NodeOrderCheck {
    NodeOrder order = NodeOrder::plausible;
    double between_vertices = 1, between_ends_and_middle = 1;
};

/// Checks that the order of vertex and edge values matches the mesh. First compresses the values u by asinh((u −
/// median)/(10⁻³ range)), which limits the weight of a few large values. Noise of 10⁻⁶ then has little weight, too.
/// Method: docs/algorithms/recovery.md. Errors: usage (numbers of values that do not match the mesh); stopped, memory.
template <int D>
[[nodiscard]] Outcome<NodeOrderCheck> check_node_order(const QuadraticMesh<D>& mesh, const Column<double>& values,
                                                       const Execution& execution);

struct NormalGradients {
    Reference reference = 0;
    double area = 0;      ///< area of the straight facets
    double integral = 0;  ///< ∫ |g|, where g is the combined normal derivative
    double squares = 0;   ///< ∫ g²
};

/// Integrates normal derivatives over the facets of each reference, on boundary and interfaces. References are
/// ascending. At a facet's corner, the fields f together give
///
///     g = sqrt(Σ_f (weight_f ∂u_f/∂n)²).
///
/// n is the normal of the curved facet, and ∂u_f/∂n comes from an adjacent element; on interfaces, from the side with
/// the larger g. Integrals are sums over corners. `balls`: elements around each vertex; \p derivatives: result of
/// `recover_derivatives` for \p mesh. Errors: usage (not one weight per field); memory; stopped.
template <int D>
[[nodiscard]] Outcome<std::vector<NormalGradients>> normal_gradients(const QuadraticMesh<D>& mesh,
                                                                     const Incidence<ElementId>& balls,
                                                                     const RecoveredDerivatives<D>& derivatives,
                                                                     std::span<const double> weights,
                                                                     const Execution& execution);

}  // namespace camber
