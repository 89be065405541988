module;
#include <span>
#include <utility>
#include <vector>
export module camber.operation:judged_patch;
import camber.core;
import camber.cavity;
import :state;

export namespace camber {

/// A patch that was judged, and found good enough: only `operate` makes one, and `commit` takes no other. It speaks of
/// the state that it was planned for.
template <int D>
class JudgedPatch {
  public:
    [[nodiscard]] const Patch<D>& patch() const { return patch_; }
    /// What becomes known of its point.
    [[nodiscard]] const VertexRow<D>& vertex() const { return vertex_; }
    /// Whether its point went a part of its way to the geometry only.
    [[nodiscard]] bool is_short_of_geometry() const { return is_short_; }
    /// Of the elements that it reshapes, then of its own in the order of the star's `joined`: shape_of, below 0 where
    /// that is not known.
    [[nodiscard]] std::span<const double> shapes() const { return shapes_; }
    /// Of degree 2: of its edges at the point, in the order of the star's `boundary`, length_of.
    [[nodiscard]] std::span<const double> lengths() const { return lengths_; }
    /// Its patch, out of it.
    [[nodiscard]] Patch<D> take_patch() && { return std::move(patch_); }

  private:
    template <int, class>
    friend class Operating;

    Patch<D> patch_;
    VertexRow<D> vertex_;
    std::vector<double> shapes_, lengths_;
    bool is_short_ = false;
};

/// A node of an inner edge, elsewhere than it was, that was judged: only `NodeShell` makes one.
template <int D>
class JudgedNode {
  public:
    [[nodiscard]] EdgeId edge() const { return edge_; }
    [[nodiscard]] const LagrangeNode<D>& node() const { return node_; }

  private:
    template <int>
    friend class NodeShell;

    EdgeId edge_;
    LagrangeNode<D> node_;
};

}  // namespace camber
