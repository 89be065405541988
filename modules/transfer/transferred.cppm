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

/// A continuous field on a mesh of degree 2, by its values at the nodes: u∘F_K = Σ φ_α(ξ) u_α in the curved element K.
struct TransferField {
    int components = 1;  ///< of a node: 1 of a scalar, D of a vector; each is a function by itself
    /// 1: a node a vertex, the field linear in ξ; 2: the nodes are the vertices, then the edges' nodes in the order of
    /// the mesh's EdgeSet.
    int degree = 2;
    Column<double> values;  ///< components of a node side by side, node after node

    friend bool operator==(const TransferField&, const TransferField&) = default;
};

/// How many nodes a field of that degree has on a mesh.
template <int D>
[[nodiscard]] std::size_t node_count_of(const QuadraticMesh<D>& mesh, int degree) {
    return mesh.linear.points.size() + (degree == 2 ? mesh.edges.size() : 0);
}

/// What a field's new values are.
enum class TransferMethod : std::uint8_t {
    interpolate,  ///< the old field at the new nodes
    conserve,     ///< where elements changed the nearest field in L2, with the integrals of the old one by material
};
[[nodiscard]] constexpr auto words(TransferMethod) {
    return words_of(Word{TransferMethod::interpolate, "interpolate"}, Word{TransferMethod::conserve, "conserve"});
}

/// Which values projected nodes may have.
enum class TransferBounds : std::uint8_t {
    none,   ///< whatever is nearest: beside a jump it over- and undershoots
    local,  ///< between the least and the largest old value of the old elements around; integrals are kept within that
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
                   "interpolate: the old field at the new nodes; conserve: where elements changed the nearest field in "
                   "L2 that keeps the integrals by material"),
            option("bounds", &S::bounds,
                   "conserve only: none; local: values stay between those of the old elements around, integrals are "
                   "kept as far as that allows"),
            option("points", &S::points, "conserve only: points of the quadrature along each direction of an element")
                .at_least(3)
                .at_most(10));
    }
    friend bool operator==(const TransferOptions&, const TransferOptions&) = default;
};

/// The integrals of a field's components over the elements of one material, in the old mesh and in the new one.
struct MaterialIntegrals {
    /// Of the elements; none: all elements where materials are not told apart, else those whose reference the other
    /// mesh does not have.
    std::optional<Reference> reference;
    std::vector<double> before, after;  ///< one a component
};

/// What became of the nodes and of the fields' integrals.
struct TransferStatistics {
    std::size_t kept = 0;          ///< nodes at the place of an old one, to the bit: they have its value, to the bit
    std::size_t interpolated = 0;  ///< nodes found in an old element (of their material)
    std::size_t outside = 0;       ///< nodes in none: the nearest point of the old elements' boundary stands for them
    std::size_t lost = 0;          ///< of these: location found no proof that they are in none
    double largest_distance = 0;   ///< of a node that is outside from that point (model units)
    std::size_t projected = 0;     ///< nodes whose value was moved by the projection; each is among the others, too
    std::size_t changed_elements = 0;  ///< new elements that the old mesh does not have, to the bit
    std::size_t patches = 0;           ///< connected ones of them
    std::size_t turned = 0;            ///< of the new ones with det J <= 0 at a point of the quadrature
    /// Parts of patches, each of one material, whose nodes that are free, if any, cannot keep the part's integral: what
    /// is missing goes to that material's other patches.
    std::size_t spread = 0;
    /// Materials that have no node for that: what they miss is `after − before` of their integrals.
    std::size_t unkept = 0;
    std::vector<std::vector<MaterialIntegrals>> integrals;  ///< of each field
};

/// The fields on the new mesh, in their order.
struct Transferred {
    std::vector<TransferField> fields;
    TransferStatistics statistics;
};

/// The fields of the old mesh on the new one. A node whose coordinates are those of an old node keeps its value to the
/// bit; any other has the value of the old field where it lies in the curved old mesh, or, outside of it, at the
/// nearest point of its boundary. Where both meshes have more than one reference of elements, a node of elements of
/// reference r takes the value of the old elements of reference r.
///
/// `conserve` then finds the new elements that are not elements of the old mesh, node by node to the bit; of the nodes
/// of these that touch no other element it takes the values with the least ∫ (u − u_old)² over these elements, by
/// quadrature, and then the least change in L2 by which ∫ u over each connected patch and material is that of the old
/// field over the old elements there. Where a patch has no node for that, the least change over all patches keeps the
/// material's integral (`spread`); a material without any such node is told (`unkept`). Docs:
/// docs/algorithms/transfer.md.
///
/// Errors: usage (a field whose column has not `components` values a node, a degree other than 1 and 2, a limit of the
/// options); input (a value or coordinate that is not finite, with its node; an old mesh without elements); those of
/// `neighbours`; memory; stopped.
template <int D>
[[nodiscard]] Outcome<Transferred> transfer(const QuadraticMesh<D>& old_mesh, std::span<const TransferField> fields,
                                            const QuadraticMesh<D>& new_mesh, const TransferOptions& options,
                                            const Execution& execution);

}  // namespace camber
