module;
#include <array>
export module camber.curving:solution_error;
import camber.core;
import :lattice_polynomial;

/// The error of interpolating a function on eight curved elements at once, and how it answers to their edges' nodes.
namespace camber {

/// Eight elements: their chords, and where their edges' nodes are off the middles of these, in the frame in which the
/// function is known and now.
template <int D>
struct ElementPacks {
    std::array<PackVec<D>, D> axes;  ///< axes[a]: vertex a + 1 less vertex 0
    std::array<PackVec<D>, edges_per_simplex<D>> frame_offsets, offsets;
};
template <int D>
using LatticePacks = std::array<Pack, lattice_size<D>>;

/// The sum of squares Σ r² = ∫ w² (u − u_h)² of an element, over a rule in the frame's volume, about the nodes as they
/// are: with d the changes of its edges' offsets, node by node, |r + R d|² = error + 2 slope·d + d·curvature·d.
template <int D>
struct ErrorPacks {
    static constexpr int unknowns = D * edges_per_simplex<D>;
    static constexpr int entries = unknowns * (unknowns + 1) / 2;
    [[nodiscard]] static constexpr int entry(int i, int j) { return i >= j ? i * (i + 1) / 2 + j : entry(j, i); }

    Pack error{};
    std::array<Pack, unknowns> slope{};
    std::array<Pack, entries> curvature{};
};

/// Adds those of a field with its weight.
template <int D>
void add_error(const ElementPacks<D>& elements, const LatticePacks<D>& field, double weight, Instructions set,
               ErrorPacks<D>& sum);

}  // namespace camber
