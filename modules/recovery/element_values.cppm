module;
#include <array>
#include <functional>
#include <span>
#include <vector>
export module camber.recovery:element_values;
import camber.bezier;
import camber.core;

export namespace camber {

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

}  // namespace camber
