module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>
module camber.io:msh_layout;
import camber.core;
import camber.bezier;
import :grid;
import :msh_groups;
import :msh_numbers;

namespace camber::msh {

/// An entity of the file, with what is on it.
struct FileEntity {
    int dimension = 0;
    Reference tag = 0;
    std::vector<Reference> physicals = {};  ///< of its simplices; none: in no group, or no simplices
    Box<3> box = {};
};

/// The items of each group, group after group, each group's in their order.
struct Grouped {
    Buffer<std::uint32_t> items;
    std::vector<std::size_t> starts;  ///< one more than there are groups
};

/// What version 4 says of where nodes and simplices lie.
struct Layout {
    std::vector<FileEntity> entities;  ///< in ascending order of dimension and tag
    /// Of each dimension 1 to 3, and of the point elements (0): the entity of each class.
    std::array<std::vector<std::uint32_t>, 4> entity_of_class;
    /// Of nodes by 2 × entity, and 1 more for nodes that have parameters.
    Grouped nodes;
};

/// Items 0 to n − 1 by group_of(item), which is below `groups`.
[[nodiscard]] Grouped grouped(std::size_t n, std::size_t groups, const auto& group_of) {
    Grouped made{Buffer<std::uint32_t>(n), std::vector<std::size_t>(groups + 1, 0)};
    for (std::size_t i = 0; i < n; ++i) ++made.starts[group_of(i) + 1];
    for (std::size_t g = 0; g < groups; ++g) made.starts[g + 1] += made.starts[g];
    std::vector<std::size_t> next(made.starts.begin(), made.starts.end() - 1);
    for (std::size_t i = 0; i < n; ++i) made.items[next[group_of(i)]++] = static_cast<std::uint32_t>(i);
    return made;
}

/// Errors: stopped, memory.
template <class Mesh>
[[nodiscard]] Outcome<Layout> layout_of(const Grid<Mesh>& grid, const Numbers& numbers, const GroupTags& groups,
                                        const Execution& execution);

}  // namespace camber::msh
