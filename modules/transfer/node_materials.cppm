module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.transfer:node_materials;
import camber.core;
import camber.bezier;
import :key_table;
import :materials;
import :simplex;

namespace camber {

/// The materials of the elements around each node.
class NodeMaterials {
  public:
    template <int D>
    NodeMaterials(const QuadraticMesh<D>& mesh, const Materials<D>& materials)
        : first_(mesh.linear.points.size() + mesh.edges.size(), none), rest_(materials.rest()) {
        for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e) {
            const auto material = static_cast<std::uint32_t>(materials.of(mesh.linear, e));
            for (const std::size_t n : nodes_of<D, 2>(mesh, e))
                if (first_[n] == none)
                    first_[n] = material;
                else if (first_[n] != material)
                    others_.emplace_back(static_cast<std::uint32_t>(n), material);
        }
        std::ranges::sort(others_);
        const auto twice = std::ranges::unique(others_);
        others_.erase(twice.begin(), twice.end());
    }

    /// visit(material) of each until it says that this will do; a node of no element is of the rest.
    template <class Visit>
    void visit(std::size_t n, Visit&& visit) const {
        if (visit(first_[n] == none ? rest_ : first_[n])) return;
        const auto begin = std::ranges::lower_bound(others_, std::pair(static_cast<std::uint32_t>(n), 0U));
        for (auto at = begin; at != others_.end() && at->first == n; ++at)
            if (visit(std::size_t{at->second})) return;
    }

  private:
    Buffer<std::uint32_t> first_;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> others_;  ///< nodes of interfaces: (node, material), rising
    std::size_t rest_;
};

}  // namespace camber
