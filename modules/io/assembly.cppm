module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>
module camber.io:assembly;
import camber.core;
import camber.bezier;
import :listing;
import :notice;

/// The parts of which `assembled` makes a mesh of degree 2 from what a file lists.
namespace camber::listing {

inline constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
inline constexpr std::size_t row_grain = 4096;

/// A simplex of the file, for messages.
struct Simplex {
    const Origin* origin = nullptr;
    std::size_t row = 0;
    [[nodiscard]] std::string text() const {
        return origin ? origin->noun + " " + std::to_string(origin->number_of(row)) : "another simplex";
    }
    [[nodiscard]] std::string where(const std::string& name) const {
        return origin && origin->place ? origin->place(row) : name;
    }
};

/// The first simplex for which `accepts(simplex's vertices, its nodes or fewer)` holds.
template <int D, class Accepts>
Simplex find_simplex(const Mesh<D>& raw, Accepts&& accepts) {
    Simplex found;
    const auto look = [&]<int K>(const Simplices<K>& kind) -> Outcome<Done> {
        for (std::size_t i = 0; i < kind.curved.size() && !found.origin; ++i)
            if (accepts.template operator()<K>(kind.curved.nodes[i])) found = {&kind.curved.origin, i};
        for (std::size_t i = 0; i < kind.straight.size() && !found.origin; ++i)
            if (accepts.template operator()<K>(kind.straight.nodes[i])) found = {&kind.straight.origin, i};
        return Done{};
    };
    static_cast<void>(for_each_dimension(raw, look));
    return found;
}

/// Vertices in the file's order without the mid nodes.
struct Renumbering {
    Buffer<std::uint32_t> to_mesh;  ///< of each vertex of the file; none: a mid node
    Buffer<std::uint32_t> to_file;  ///< of each vertex of the mesh
};

/// Which points of the file are mid nodes. Errors: input (a mid node that is a corner too), stopped.
template <int D>
[[nodiscard]] Outcome<Renumbering> without_mid_nodes(const Mesh<D>& raw, const Execution& execution);

/// The straight mesh on the corners: simplices of degree 2 first, as indices of required simplices and ridges have it.
/// Takes what it needs of `raw`; what is listed of mid nodes falls out and is told of. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> corner_mesh(Mesh<D>& raw, const Renumbering& numbers, const Execution& execution,
                                                 std::vector<Notice>& notices);

/// The mid node of each edge and the edge of each mid node: the lowest candidate, or none.
struct MidNodes {
    Buffer<std::uint32_t> of_edge;  ///< vertices of the file
    Buffer<std::uint32_t> edge_of;  ///< by vertices of the file
};

/// The mid nodes that all simplices agree on. Errors: input (they do not agree), stopped.
template <int D>
[[nodiscard]] Outcome<MidNodes> mid_nodes_of(const Mesh<D>& raw, const EdgeSet<D>& edges, const Renumbering& numbers,
                                             const Execution& execution);

}  // namespace camber::listing
