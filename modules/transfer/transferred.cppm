module;
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <tuple>
#include <vector>
export module camber.transfer:transferred;
import camber.core;

export namespace camber {

/// A continuous field on a quadratic mesh, given by nodal values u_α: u∘F_K = Σ φ_α(ξ) u_α in the curved element K with
/// the map F_K.
struct TransferField {
    int components = 1;  ///< 1 for scalars, D for vectors, or the number of independent functions
    /// 1: values at vertices, linear in ξ. 2: values at vertices, then at edges in the order of the mesh's EdgeSet.
    int degree = 2;
    Column<double> values;  ///< node by node, with components side by side

    friend bool operator==(const TransferField&, const TransferField&) = default;
};

template <int D>
[[nodiscard]] std::size_t node_count_of(const QuadraticMesh<D>& mesh, int degree) {
    return mesh.linear.points.size() + (degree == 2 ? mesh.edges.size() : 0);
}

enum class TransferMethod : std::uint8_t {
    interpolate,  ///< value of the old field at each new node
    conserve,     ///< nearest field in L2 where elements changed; integrals by material are preserved
};
[[nodiscard]] constexpr auto words(TransferMethod) {
    return words_of(Word{TransferMethod::interpolate, "interpolate"}, Word{TransferMethod::conserve, "conserve"});
}

/// Limits of projected values.
enum class TransferBounds : std::uint8_t {
    none,   ///< no limits: projected values over- and undershoot at jumps
    local,  ///< range of the old values in the old elements around a node; integrals are preserved as far as this
            ///< permits
};
[[nodiscard]] constexpr auto words(TransferBounds) {
    return words_of(Word{TransferBounds::none, "none"}, Word{TransferBounds::local, "local"});
}

struct TransferOptions {
    TransferMethod method = TransferMethod::interpolate;
    TransferBounds bounds = TransferBounds::none;
    int points = 4;

    [[nodiscard]] static constexpr auto options() {
        using S = TransferOptions;
        return std::tuple(
            option("method", &S::method,
                   "interpolate: the old field at the new nodes; conserve: where elements changed, the nearest field "
                   "in L2 with the same integral over each material"),
            option("bounds", &S::bounds,
                   "conserve only. none: values have no bounds; local: values stay within the range of the old "
                   "elements around, and integrals are preserved as far as this allows"),
            option("points", &S::points,
                   "conserve only: number of quadrature points along each direction of an "
                   "element")
                .at_least(3)
                .at_most(10));
    }
    friend bool operator==(const TransferOptions&, const TransferOptions&) = default;
};

struct MaterialIntegrals {
    /// Element reference of the material. No value: all elements if materials are not distinguished, else all elements
    /// whose reference is missing in the other mesh.
    std::optional<Reference> reference;
    std::vector<double> before, after;
};

struct TransferStatistics {
    std::size_t preserved = 0;         ///< nodes bitwise at an old node, with its exact value
    std::size_t interpolated = 0;      ///< nodes inside an old element (of their material)
    std::size_t outside = 0;           ///< nodes outside the old mesh, with the value at the nearest boundary point
    std::size_t lost = 0;              ///< nodes counted in `outside` that are not proven to be outside
    double largest_distance = 0;       ///< largest distance of an outside node from its boundary point (model units)
    std::size_t projected = 0;         ///< nodes changed by the projection; they are also counted above
    std::size_t changed_elements = 0;  ///< new elements that the old mesh does not have
    std::size_t patches = 0;           ///< connected sets of changed elements
    std::size_t turned = 0;            ///< new elements with det J <= 0 at a quadrature point
    /// Groups (elements of one patch and material) whose free nodes cannot preserve the integral. The difference is
    /// spread over the material's other patches.
    std::size_t spread = 0;
    /// Materials that have no free nodes to preserve the integral. Their error is `after − before`.
    std::size_t unconserved_materials = 0;
    std::vector<std::vector<MaterialIntegrals>> integrals;
};

struct Transferred {
    std::vector<TransferField> fields;
    TransferStatistics statistics;
};

/// Transfers fields to a new mesh. Nodes exactly at old nodes keep their values bitwise. Other nodes get the old
/// field's value at their position or, outside the old mesh, at the nearest point of its curved boundary. If both
/// meshes have several element references, nodes of reference r use old elements of reference r only.
///
/// `conserve` then finds the changed elements: new elements that are not bitwise old elements. Nodes all of whose
/// elements changed get the values that minimise ∫ (u − u_old)² over the changed elements, by quadrature. The smallest
/// L2 change then restores ∫ u over each connected patch and material. If a patch has no such nodes, the material's
/// integral is preserved over all patches (`spread`). Materials without such nodes are reported
/// (`unconserved_materials`). Docs: docs/algorithms/transfer.md.
///
/// Errors: usage (a column without `components` values for each node; a degree other than 1 and 2; limits of options);
/// input (a value or coordinate that is not finite, with its node; an old mesh without elements); those of
/// `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<Transferred> transfer(const QuadraticMesh<D>& old_mesh, std::span<const TransferField> fields,
                                            const QuadraticMesh<D>& new_mesh, const TransferOptions& options,
                                            const Execution& execution);

}  // namespace camber
