module;
#include <cstddef>
#include <cstdint>
module camber.transfer:same;
import camber.core;
import :key_table;
import :materials;

namespace camber {

/// What two meshes have in common, to the bit. Nodes are numbered as those of a field of degree 2.
struct Same {
    Buffer<std::uint32_t> old_node;     ///< of each new node: the old one at its place, or `none`
    Buffer<std::uint32_t> old_element;  ///< of each new element: the old one with its nodes and material, or `none`
    Buffer<std::uint8_t> is_kept;       ///< of each old element: whether it is one of these
};

/// Of several old nodes at a place (the two sides of a crack) a new one gets that of an element that it keeps, or else
/// the first. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Same> find_same(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                                      const Materials<D>& materials, const Execution& execution);

}  // namespace camber
