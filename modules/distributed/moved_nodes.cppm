module;
#include <algorithm>
#include <cstddef>
module camber.distributed:moved_nodes;
import camber.core;
import camber.bezier;

namespace camber {

/// Nodes of a mesh's edges of which most are in the middles of their chords, where a straight mesh has them: the others.
template <int D>
class MovedNodes {
  public:
    MovedNodes() = default;  ///< none are known
    MovedNodes(const QuadraticMesh<D>& straight, const Buffer<LagrangeNode<D>>& nodes) : is_known_(true) {
        for (std::size_t e = 0; e < nodes.size(); ++e)
            if (nodes[e] != straight.mid_nodes[e]) edges_.emplace_back(e), nodes_.push_back(nodes[e]);
        edges_.shrink_to_fit();
        nodes_.shrink_to_fit();
    }

    [[nodiscard]] bool is_known() const { return is_known_; }
    [[nodiscard]] LagrangeNode<D> at(const QuadraticMesh<D>& straight, EdgeId e) const {
        const auto found = std::ranges::lower_bound(edges_, e);
        return found != edges_.end() && *found == e ? nodes_[static_cast<std::size_t>(found - edges_.begin())]
                                                    : straight.mid_nodes[e];
    }
    /// One an edge.
    [[nodiscard]] Buffer<LagrangeNode<D>> all(const QuadraticMesh<D>& straight) const {
        Buffer<LagrangeNode<D>> nodes(straight.mid_nodes.begin(), straight.mid_nodes.end());
        for (std::size_t i = 0; i < edges_.size(); ++i) nodes[edges_[i].index()] = nodes_[i];
        return nodes;
    }

  private:
    bool is_known_ = false;
    Buffer<EdgeId> edges_;  ///< rising
    Buffer<LagrangeNode<D>> nodes_;
};

}  // namespace camber
