module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>
export module camber.operation:node_shell;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import :judged_patch;

/// The node of one inner edge, and how its place distorts the elements around it.
export namespace camber {

/// An element around the edge with all that does not depend on the node.
template <int D>
struct DistortedElement {
    QuadraticNodes<D> nodes{};
    ElementMetric<D> metric;
    int node = 0;      ///< which of its nodes is the edge's
    double bound = 0;  ///< what its scaled Jacobian is to keep
};

/// What a place of the node comes to. The sum is that of η̄², η̄ the mean distortion of an element: the squares make the
/// worst element count most, and the sum has the same gradient for any scale of the metric.
template <int D>
struct NodePlace {
    Vec<D> y;          ///< in the frame
    Vec<D> point;      ///< its node
    double sum = 0;    ///< infinite where an element folds
    double worst = 0;  ///< the least quality, 1/η̄
    Vec<D> gradient;   ///< of the sum, in the frame
};

/// Finds the place by BFGS in the frame in which the metric at the edge's middle is the identity, where elements are
/// about as large as 1 at any anisotropy.
template <int D>
class NodeShell {
  public:
    std::vector<DistortedElement<D>> elements;

    /// The node's frame: where it is now, and the metric at the edge's middle.
    void begin(const Vec<D>& node, const LogMetric<D>& log_metric) {
        origin_ = node;
        const MeasuringMetric<D> metric(log_metric);
        for (int k = 0; k < D; ++k) axes_[k] = metric.rows[k] / norm_squared(metric.rows[k]);
    }
    [[nodiscard]] NodePlace<D> at(const Vec<D>& y) const {
        NodePlace<D> place{y, origin_, 0, std::numeric_limits<double>::infinity(), {}};
        for (int k = 0; k < D; ++k) place.point += y[k] * axes_[k];
        Vec<D> gradient;
        for (const DistortedElement<D>& e : elements) {
            const CurvedQualityGradient<D> q = curved_quality_gradient<D>(with_node(e, place.point), e.metric);
            place.worst = std::min(place.worst, q.mean);
            if (!(q.mean > 0)) {
                place.sum = std::numeric_limits<double>::infinity();
                return place;
            }
            place.sum += 1 / (q.mean * q.mean);
            gradient += (-2 / (q.mean * q.mean * q.mean)) * q.by_node[e.node];
        }
        for (int k = 0; k < D; ++k) place.gradient[k] = dot(axes_[k], gradient);
        return place;
    }
    /// A place of a lower sum, whose worst element is no worse; `here` where there is none.
    [[nodiscard]] NodePlace<D> better(const NodePlace<D>& here) const {
        constexpr int max_steps = 12;
        constexpr double worthwhile = 1e-4;  // of the sum, promised by a step
        NodePlace<D> now = here;
        // About the inverse of the second derivative in an element that is regular.
        Sym<D> inverse_hessian = (0.05 / static_cast<double>(elements.size())) * Sym<D>::identity();
        for (int step = 0; step < max_steps; ++step) {
            Vec<D> way = -1.0 * (inverse_hessian * now.gradient);
            if (!(-dot(way, now.gradient) > worthwhile * now.sum)) break;
            if (const double length = norm(way); length > longest_way) way *= longest_way / length;
            const NodePlace<D> next = along(now, way, here.worst);
            if (!(next.sum < now.sum)) break;
            update(inverse_hessian, next.y - now.y, next.gradient - now.gradient);
            now = next;
        }
        return now;
    }
    /// The edge's node there, if every element keeps its bound by the certificate: with it at both ends, and det J
    /// affine in the node (see certify_motion), all of the way is certified.
    [[nodiscard]] std::optional<JudgedNode<D>> judged(EdgeId edge, const Vec<D>& node) const {
        const bool is_valid = std::ranges::all_of(elements, [&](const DistortedElement<D>& e) {
            return decide(NodalSimplex<D>{with_node(e, node)}, e.bound) == Verdict::valid;
        });
        if (!is_valid) return {};
        JudgedNode<D> out;
        out.edge_ = edge;
        out.node_ = {node};
        return out;
    }

  private:
    static constexpr double longest_way = 0.25;  ///< of a unit edge

    [[nodiscard]] static QuadraticNodes<D> with_node(const DistortedElement<D>& e, const Vec<D>& node) {
        QuadraticNodes<D> nodes = e.nodes;
        nodes[e.node] = node;
        return nodes;
    }
    /// By Armijo's rule, and as the worst element may be; `from` where nothing serves.
    [[nodiscard]] NodePlace<D> along(const NodePlace<D>& from, const Vec<D>& way, double worst) const {
        const double slope = dot(from.gradient, way);
        for (double share = 1; share > 0.01; share /= 2) {
            const NodePlace<D> there = at(from.y + share * way);
            if (there.worst >= worst && there.sum < from.sum + 1e-3 * share * slope) return there;
        }
        return from;
    }
    /// BFGS, where the curvature is positive.
    static void update(Sym<D>& h, const Vec<D>& s, const Vec<D>& d) {
        const double sd = dot(s, d);
        if (!(sd > 1e-10 * norm(s) * norm(d))) return;
        const Vec<D> hd = h * d;
        const double factor = (1 + dot(d, hd) / sd) / sd;
        for (int i = 0; i < D; ++i)
            for (int j = 0; j <= i; ++j) h(i, j) += factor * s[i] * s[j] - (hd[i] * s[j] + s[i] * hd[j]) / sd;
    }

    Vec<D> origin_;
    std::array<Vec<D>, D> axes_{};
};

}  // namespace camber
