module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
export module camber.box_tree;
import camber.core;

export namespace camber {

/// Immutable balanced tree of boxes, to find nearest and overlapping items.
template <int D>
class BoxTree {
  public:
    BoxTree() = default;

    explicit BoxTree(std::span<const Box<D>> boxes) {
        Buffer<std::uint32_t> order(boxes.size());
        std::iota(order.begin(), order.end(), 0U);
        Buffer<Node> nodes;
        if (!boxes.empty()) {
            nodes.reserve(2 * boxes.size() / leaf_size + 2);
            split(boxes, order, nodes, 0, order.size());
        }
        order_ = std::move(order);
        nodes_ = std::move(nodes);
    }

    [[nodiscard]] std::size_t size() const { return order_.size(); }
    [[nodiscard]] Box<D> bounds() const { return nodes_.empty() ? Box<D>{} : nodes_[0].box; }

    struct Nearest {
        std::size_t item = std::numeric_limits<std::size_t>::max();
        double distance_squared = std::numeric_limits<double>::infinity();
    };

    /// Returns the item nearest to p, of several the one with the lowest number. distance_squared(item) must not be
    /// less than the squared distance of p from the item's box. Only items with a squared distance below `within` are
    /// considered.
    template <class DistanceSquared>
    [[nodiscard]] Nearest nearest(const Vec<D>& p, DistanceSquared&& distance_squared,
                                  double within = std::numeric_limits<double>::infinity()) const {
        Nearest best;
        best.distance_squared = within;
        if (!nodes_.empty()) descend(0, p, distance_squared, best);
        return best;
    }

    struct RayHit {
        std::size_t item = std::numeric_limits<std::size_t>::max();
        double distance = std::numeric_limits<double>::infinity();  ///< parameter s of the point p + s·d on the ray
    };

    /// Returns the first item on the ray p + s·d, s >= 0, of several the one with the lowest number. meets(item):
    /// smallest s at which the ray meets the item, infinity if it does not. Items whose boxes the ray misses are
    /// skipped, so boxes need a margin for rounding. Only s below `within` count.
    template <class Meets>
    [[nodiscard]] RayHit first_hit(const Vec<D>& p, const Vec<D>& d, Meets&& meets,
                                   double within = std::numeric_limits<double>::infinity()) const {
        RayHit first;
        first.distance = within;
        if (!nodes_.empty() && entry(nodes_[0].box, p, d) < within) walk_along(0, p, d, meets, first);
        return first;
    }

    /// Calls visit(item) for each item whose box contains p, and for some other items. The order is fixed.
    template <class Visit>
    void containing(const Vec<D>& p, Visit&& visit) const {
        if (!nodes_.empty()) visit_containing(0, p, visit);
    }

    /// Same as `containing`, for each item whose box overlaps or touches `box`.
    template <class Visit>
    void meeting(const Box<D>& box, Visit&& visit) const {
        if (!nodes_.empty()) visit_meeting(0, box, visit);
    }

  private:
    static constexpr std::size_t leaf_size = 4;
    struct Node {
        Box<D> box;
        std::uint32_t begin = 0, end = 0;   ///< range of items, in a leaf
        std::uint32_t left = 0, right = 0;  ///< numbers of the children; 0 in a leaf
    };

    static std::uint32_t split(std::span<const Box<D>> boxes, Buffer<std::uint32_t>& order, Buffer<Node>& nodes,
                               std::size_t begin, std::size_t end) {
        const auto at = static_cast<std::uint32_t>(nodes.size());
        Node node;
        node.begin = static_cast<std::uint32_t>(begin);
        node.end = static_cast<std::uint32_t>(end);
        for (std::size_t i = begin; i < end; ++i) node.box.include(boxes[order[i]]);
        nodes.push_back(node);
        if (end - begin > leaf_size) {
            int axis = 0;
            for (int i = 1; i < D; ++i)
                if (node.box.high[i] - node.box.low[i] > node.box.high[axis] - node.box.low[axis]) axis = i;
            const std::size_t middle = begin + (end - begin) / 2;
            const auto key = [&](std::uint32_t item) {
                return std::pair(boxes[item].low[axis] + boxes[item].high[axis], item);
            };
            std::nth_element(order.begin() + begin, order.begin() + middle, order.begin() + end,
                             [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
            const std::uint32_t left = split(boxes, order, nodes, begin, middle);
            const std::uint32_t right = split(boxes, order, nodes, middle, end);
            nodes[at].left = left;
            nodes[at].right = right;
        }
        return at;
    }

    template <class DistanceSquared>
    void descend(std::uint32_t at, const Vec<D>& p, DistanceSquared& distance_squared, Nearest& best) const {
        const Node& node = nodes_[at];
        if (node.right == 0) {
            for (std::uint32_t i = node.begin; i < node.end; ++i) {
                const std::size_t item = order_[i];
                const double d = distance_squared(item);
                if (d < best.distance_squared || (d == best.distance_squared && item < best.item)) best = {item, d};
            }
            return;
        }
        std::array<std::pair<double, std::uint32_t>, 2> children{
            {{nodes_[node.left].box.distance_squared(p), node.left},
             {nodes_[node.right].box.distance_squared(p), node.right}}};
        if (children[1].first < children[0].first) std::swap(children[0], children[1]);
        for (const auto& [d, child] : children)
            if (d <= best.distance_squared) descend(child, p, distance_squared, best);
    }

    /// Ray parameter s at which the ray enters the box; infinity if it misses the box.
    [[nodiscard]] static double entry(const Box<D>& box, const Vec<D>& p, const Vec<D>& d) {
        constexpr double never = std::numeric_limits<double>::infinity();
        double in = 0, out = never;
        for (int i = 0; i < D; ++i) {
            const double low = box.low[i] - p[i], high = box.high[i] - p[i];
            if (d[i] == 0) {
                if (low > 0 || high < 0) return never;
                continue;
            }
            const double to_low = low / d[i], to_high = high / d[i];
            in = std::max(in, std::min(to_low, to_high));
            out = std::min(out, std::max(to_low, to_high));
        }
        return in <= out ? in : never;
    }

    template <class Meets>
    void walk_along(std::uint32_t at, const Vec<D>& p, const Vec<D>& d, Meets& meets, RayHit& first) const {
        const Node& node = nodes_[at];
        if (node.right == 0) {
            for (std::uint32_t i = node.begin; i < node.end; ++i) {
                const std::size_t item = order_[i];
                const double s = meets(item);
                const bool is_tie = s == first.distance && first.item < size();
                if (s < first.distance || (is_tie && item < first.item)) first = {item, s};
            }
            return;
        }
        std::array<std::pair<double, std::uint32_t>, 2> children{
            {{entry(nodes_[node.left].box, p, d), node.left}, {entry(nodes_[node.right].box, p, d), node.right}}};
        if (children[1].first < children[0].first) std::swap(children[0], children[1]);
        for (const auto& [s, child] : children)
            if (s <= first.distance && s < std::numeric_limits<double>::infinity())
                walk_along(child, p, d, meets, first);
    }

    template <class Visit>
    void visit_containing(std::uint32_t at, const Vec<D>& p, Visit& visit) const {
        const Node& node = nodes_[at];
        if (!node.box.contains(p)) return;
        if (node.right == 0) {
            for (std::uint32_t i = node.begin; i < node.end; ++i) visit(std::size_t{order_[i]});
            return;
        }
        visit_containing(node.left, p, visit);
        visit_containing(node.right, p, visit);
    }

    template <class Visit>
    void visit_meeting(std::uint32_t at, const Box<D>& box, Visit& visit) const {
        const Node& node = nodes_[at];
        if (!node.box.meets(box)) return;
        if (node.right == 0) {
            for (std::uint32_t i = node.begin; i < node.end; ++i) visit(std::size_t{order_[i]});
            return;
        }
        visit_meeting(node.left, box, visit);
        visit_meeting(node.right, box, visit);
    }

    Column<std::uint32_t> order_;
    Column<Node> nodes_;
};

}  // namespace camber
