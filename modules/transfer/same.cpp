module;
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
module camber.transfer;
import :key_table;
import :materials;
import :same;
import :simplex;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// The bits of a place; −0 is 0.
template <int D>
std::array<std::uint64_t, D> bits_of(const Vec<D>& p) {
    std::array<std::uint64_t, D> bits{};
    for (int i = 0; i < D; ++i) bits[i] = std::bit_cast<std::uint64_t>(p[i] + 0.0);
    return bits;
}

/// An element by the first old nodes at the places of its vertices, which rise.
template <int D>
using Corners = std::array<std::uint64_t, D + 1>;

template <int D>
class Matching {
  public:
    Matching(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh, const Materials<D>& materials)
        : old_(old_mesh),
          new_(new_mesh),
          materials_(materials),
          nodes_(old_mesh.linear.points.size() + old_mesh.edges.size(), place()),
          first_(first_nodes()),
          elements_(old_mesh.linear.elements.size(), old_corners()) {}

    /// The first old node at the place of a new one.
    [[nodiscard]] std::uint32_t node(std::size_t n) const { return nodes_.find(bits_of(place_of(new_, n)), place()); }

    /// The old element with the nodes and the material of a new one, by the old nodes of the latter.
    [[nodiscard]] std::uint32_t element(std::size_t e, const Buffer<std::uint32_t>& old_node) const {
        Corners<D> corners{};
        for (int i = 0; i <= D; ++i) {
            const std::uint32_t node = old_node[new_.linear.elements.vertices[e][i].index()];
            if (node == none) return none;
            corners[i] = node;
        }
        std::ranges::sort(corners);
        const std::uint32_t found = elements_.find(corners, old_corners());
        if (found == none || materials_.of(old_.linear, found) != materials_.of(new_.linear, e)) return none;
        for (const std::uint32_t node : counterparts(e, found))
            if (node == none) return none;
        return found;
    }

    /// Of the nodes of a new element those of an old one with the same vertices that are at their places; none: none.
    [[nodiscard]] auto counterparts(std::size_t e, std::size_t found) const {
        const auto mine = nodes_of<D, 2>(new_, e), theirs = nodes_of<D, 2>(old_, found);
        std::array<std::uint32_t, quadratic_nodes<D>> out{};
        for (std::size_t i = 0; i < mine.size(); ++i) {
            out[i] = none;
            const std::size_t begin = i <= D ? 0 : D + 1, end = i <= D ? D + 1 : mine.size();
            for (std::size_t j = begin; j < end; ++j)
                if (place_of(new_, mine[i]) == place_of(old_, theirs[j]))
                    out[i] = static_cast<std::uint32_t>(theirs[j]);
        }
        return out;
    }

  private:
    [[nodiscard]] auto place() const {
        return [this](std::size_t n) { return bits_of(place_of(old_, n)); };
    }
    [[nodiscard]] Buffer<std::uint32_t> first_nodes() const {
        Buffer<std::uint32_t> first(old_.linear.points.size());
        for (std::size_t v = 0; v < first.size(); ++v) first[v] = nodes_.find(bits_of(old_.linear.points[v]), place());
        return first;
    }
    [[nodiscard]] auto old_corners() const {
        return [this](std::size_t e) {
            Corners<D> corners{};
            for (int i = 0; i <= D; ++i) corners[i] = first_[old_.linear.elements.vertices[e][i].index()];
            std::ranges::sort(corners);
            return corners;
        };
    }

    const QuadraticMesh<D>& old_;
    const QuadraticMesh<D>& new_;
    const Materials<D>& materials_;
    KeyTable<D> nodes_;
    Buffer<std::uint32_t> first_;  ///< of each old vertex: the first old node at its place
    KeyTable<D + 1> elements_;
};

}  // namespace

template <int D>
Outcome<Same> find_same(const QuadraticMesh<D>& old_mesh, const QuadraticMesh<D>& new_mesh,
                        const Materials<D>& materials, const Execution& execution) {
    return guarded([&]() -> Outcome<Same> {
        const Matching<D> matching(old_mesh, new_mesh, materials);
        auto nodes = map_each(part_of(execution, 0.2, 0.6), node_count_of(new_mesh, 2),
                              [&](std::size_t n) { return matching.node(n); });
        if (!nodes) return fail(nodes.error());
        auto elements = map_each(part_of(execution, 0.6, 1), new_mesh.linear.elements.size(),
                                 [&](std::size_t e) { return matching.element(e, *nodes); });
        if (!elements) return fail(elements.error());
        Same same{std::move(*nodes), std::move(*elements), {}};
        same.is_kept.assign(old_mesh.linear.elements.size(), 0);
        for (std::size_t e = 0; e < same.old_element.size(); ++e) {
            const std::uint32_t found = same.old_element[e];
            if (found == none) continue;
            same.is_kept[found] = 1;
            const auto mine = nodes_of<D, 2>(new_mesh, e);
            const auto theirs = matching.counterparts(e, found);
            for (std::size_t i = 0; i < mine.size(); ++i) same.old_node[mine[i]] = theirs[i];
        }
        return same;
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template Outcome<Same> find_same<D>(const QuadraticMesh<D>&, const QuadraticMesh<D>&, const Materials<D>&, \
                                        const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
