module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>
module camber.adapt;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.cavity;
import camber.operation;
import camber.surface;

namespace camber {

namespace {

/// Where along an edge half of its length is: ∫_0^t a^(1−s) b^s ds is half of ∫_0^1.
double half_of_length(double a, double b) {
    const double log_ratio = log(b / a);
    if (!std::isfinite(log_ratio) || std::abs(log_ratio) < 1e-6) return 0.5;
    return std::clamp(log((1 + b / a) / 2) / log_ratio, 0.2, 0.8);
}

template <int D>
class Splits final : public Pass<D> {
  public:
    Splits(const AdaptationGoal<D>& goal, const SplitOptions& options) : goal_(goal), options_(options) {}

    [[nodiscard]] double order_of(double length) const { return length > options_.longest ? -length : infinite_order; }

    [[nodiscard]] std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const override {
        return candidate_at(r, task, 1);
    }
    [[nodiscard]] std::optional<Candidate<D>> shortened(const Adaptation<D>& r, const Task& task,
                                                        double share) const override {
        auto candidate = goal_.geometry ? candidate_at(r, task, share) : std::nullopt;
        if (candidate && candidate->request.cavity.facets.empty()) candidate.reset();
        return candidate;
    }
    [[nodiscard]] static bool has_stood(const Adaptation<D>&, EdgeId) { return false; }  // cavities grow far
    void follow(Adaptation<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) override {
        add_edge_tasks(r, changes, [&](double length) { return order_of(length); }, tasks);
    }

  private:
    /// Edges that are much too long go before those that become short, and edges twice as long before elements that
    /// become flat: collapses and swaps mend these, and nothing else a long edge. A point that stays off the geometry
    /// is worth no bad element.
    [[nodiscard]] SplitLimits limits_of(double length, double share) const {
        constexpr double much_too_long = 2;
        SplitLimits limits{options_.shortest, options_.min_quality};
        if (!(length > much_too_long)) return limits;
        limits.shortest *= much_too_long / length * (much_too_long / length);
        if (share == 1 && length > 2 * much_too_long)
            limits.bad_quality = limits.min_quality = std::min(0.02, options_.min_quality);
        return limits;
    }

    /// `share`: how far the point goes to the geometry.
    [[nodiscard]] std::optional<Candidate<D>> candidate_at(const Adaptation<D>& r, const Task& task,
                                                           double share) const {
        const EdgeId edge(std::size_t{task.id});
        if (r.mesh.is_free(edge)) return {};
        const double length = length_of(r, edge);
        if (!(length > options_.longest)) return {};
        return split_candidate(r, goal_, edge, share, limits_of(length, share));
    }
    const AdaptationGoal<D>& goal_;
    const SplitOptions& options_;
};

}  // namespace

template <int D>
std::optional<Candidate<D>> split_candidate(const Adaptation<D>& r, const AdaptationGoal<D>& goal, EdgeId edge,
                                            double share, const SplitLimits& limits) {
    constexpr std::size_t max_elements = 64;
    const auto [element, local] = element_with_edge(r.mesh, edge);
    if (!element.valid()) return {};
    Candidate<D> candidate;
    auto& request = candidate.request;
    cavity_of_edge(r.mesh, element, local, request.cavity);
    const auto& [a, b] = r.mesh.edges[edge];
    const Vec<D> chord = r.mesh.points[b] - r.mesh.points[a];
    const double t = half_of_length(std::sqrt(r.vertices.metrics[a].measure.length_squared(chord)),
                                    std::sqrt(r.vertices.metrics[b].measure.length_squared(chord)));
    request.place = r.mesh.points[a] + t * chord;
    if (r.mesh.is_curved()) {
        request.origin = request.place;
        request.halves = {a, b};
        request.place = QuadraticEdge<D>{r.mesh.points[a], r.mesh.nodes[edge], r.mesh.points[b]}.point(t);
    }
    request.share = share;
    const SurfacePoint<D> foot = on_geometry_at_edge(goal, r.mesh, edge, request.cavity.facets, request.place);
    if (share < 1 && foot.point == request.place) return {};  // the geometry is where it is already
    request.place += share * (foot.point - request.place);
    request.lies = place_after(share, foot);
    if (r.mesh.point_references[a] == r.mesh.point_references[b]) request.reference = r.mesh.point_references[a];
    ask_field(r, goal, r.vertices.metrics[a].back, request);
    request.holders = request.cavity.elements.size();
    // Too near to a vertex that no growing takes away: rejected as it is.
    const ConePoint<D> point{request.place, &request.metric, &request.gradient,
                             request.cavity.facets.empty() ? VertexPlace::inside : VertexPlace::surface};
    BentSpokes<D> spokes(r, goal);
    if (nearest_of_holders(r, request, point, spokes) < limits.shortest) {
        candidate.rejected = RejectionReason::length;
        return candidate;
    }
    grow_delaunay(r, spokes, max_elements, limits.shortest, request.cavity);
    spokes.give(request);
    candidate.limits.corrections = 16;
    candidate.limits.wall_elements = WallElements::refused;
    candidate.limits.shortest = limits.shortest;
    candidate.limits.min_shape = shape_of_quality(limits.min_quality, D);
    candidate.limits.below_least = BelowLeast::accepted_if_no_worse;
    candidate.limits.bad_quality = limits.bad_quality;
    return candidate;
}

template <int D>
Outcome<Adapted<D>> split(Adaptation<D> state, const AdaptationGoal<D>& goal, const SplitOptions& options,
                          const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    return run_on_edges<D>(std::move(state), goal, Splits<D>(goal, options), execution);
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template std::optional<Candidate<D>> split_candidate<D>(const Adaptation<D>&, const AdaptationGoal<D>&, EdgeId, \
                                                            double, const SplitLimits&);                            \
    template Outcome<Adapted<D>> split<D>(Adaptation<D>, const AdaptationGoal<D>&, const SplitOptions&,             \
                                          const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
