module;
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
module camber.transfer:patches;
import camber.core;
import camber.bezier;
import :key_table;
import :materials;
import :same;
import :simplex;

namespace camber {

/// What changed from one mesh to the other: the elements that the other does not have.
struct Changed {
    std::vector<std::uint32_t> new_elements, old_elements;  ///< rising
    Buffer<std::uint32_t> old_slot;                         ///< of each old element: its place there, or `none`
    /// Of the new nodes: whether it is of changed elements alone. All others keep their values.
    Buffer<std::uint8_t> is_free;
};
template <int D>
[[nodiscard]] Changed find_changed(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                                   const Same& same);

/// Sets that are joined pair by pair.
class JoinedSets {
  public:
    explicit JoinedSets(std::size_t n) : above_(n) { std::iota(above_.begin(), above_.end(), std::uint32_t{0}); }
    void join(std::size_t a, std::size_t b) {
        const std::uint32_t p = lowest(static_cast<std::uint32_t>(a)), q = lowest(static_cast<std::uint32_t>(b));
        above_[p < q ? q : p] = p < q ? p : q;
    }
    /// The lowest of its set.
    [[nodiscard]] std::uint32_t lowest(std::uint32_t i) {
        for (; above_[i] != i; i = above_[i]) above_[i] = above_[above_[i]];
        return i;
    }

  private:
    Buffer<std::uint32_t> above_;
};

/// Connected patches of changed elements, the new ones and the old ones that were there. Elements are connected by an
/// edge, by a node that is of changed elements alone, and where a point of one lies in the other.
template <int D>
class PatchSearch {
  public:
    PatchSearch(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh, const Same& same,
                const Changed& changed);
    /// A point of new element `new_slot` lies in an old element.
    void found(std::size_t new_slot, std::uint32_t old_element) {
        if (const std::uint32_t slot = changed_.old_slot[old_element]; slot != none)
            sets_.join(new_slot, changed_.new_elements.size() + slot);
    }

    /// Patches by their first new element; and groups: the elements of a patch and a material.
    struct Patches {
        std::size_t patches = 0;
        struct Group {
            std::uint32_t patch, material;
            friend auto operator<=>(const Group&, const Group&) = default;
        };
        std::vector<Group> groups;                              ///< rising; of new elements
        std::vector<std::uint32_t> group_of_new, group_of_old;  ///< of each slot; `no_group`: no new element is there
        std::vector<std::uint32_t> first_group;                 ///< of each patch, and the end
    };
    [[nodiscard]] Patches patches(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                                  const Materials<D>& materials);

  private:
    const Changed& changed_;
    JoinedSets sets_;
};

}  // namespace camber
