module;
#include <algorithm>
#include <array>
#include <cstddef>
module camber.distributed:moved_nodes;
import camber.core;
import camber.bezier;

namespace camber {

/// The middle of a chord; a straight mesh need not keep them.
template <int D>
[[nodiscard]] LagrangeNode<D> straight_node(const QuadraticMesh<D>& mesh, EdgeId e) {
    const auto& [a, b] = mesh.edges.vertices[e];
    return {midpoint(mesh.linear.points[a], mesh.linear.points[b])};
}
template <int D>
[[nodiscard]] Buffer<LagrangeNode<D>> straight_nodes(const QuadraticMesh<D>& mesh) {
    Buffer<LagrangeNode<D>> nodes(mesh.edges.size());
    for (std::size_t e = 0; e < nodes.size(); ++e) nodes[e] = straight_node(mesh, EdgeId(e));
    return nodes;
}

/// Nodes of a mesh's edges of which most are in the middles of their chords: the others.
template <int D>
class MovedNodes {
  public:
    MovedNodes() = default;  ///< none are known
    MovedNodes(const QuadraticMesh<D>& mesh, const Buffer<LagrangeNode<D>>& nodes) : is_known_(true) {
        for (std::size_t e = 0; e < nodes.size(); ++e)
            if (nodes[e] != straight_node(mesh, EdgeId(e))) edges_.emplace_back(e), nodes_.push_back(nodes[e]);
        edges_.shrink_to_fit();
        nodes_.shrink_to_fit();
    }

    [[nodiscard]] bool is_known() const { return is_known_; }
    [[nodiscard]] LagrangeNode<D> at(const QuadraticMesh<D>& mesh, EdgeId e) const {
        const auto found = std::ranges::lower_bound(edges_, e);
        return found != edges_.end() && *found == e ? nodes_[static_cast<std::size_t>(found - edges_.begin())]
                                                    : straight_node(mesh, e);
    }
    /// One an edge.
    [[nodiscard]] Buffer<LagrangeNode<D>> all(const QuadraticMesh<D>& mesh) const {
        Buffer<LagrangeNode<D>> nodes = straight_nodes(mesh);
        for (std::size_t i = 0; i < edges_.size(); ++i) nodes[edges_[i].index()] = nodes_[i];
        return nodes;
    }

    void each_array(const auto& visit) {
        visit(edges_);
        visit(nodes_);
    }

  private:
    bool is_known_ = false;
    Buffer<EdgeId> edges_;  ///< rising
    Buffer<LagrangeNode<D>> nodes_;
};

}  // namespace camber
