module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>
module camber.remesh;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.dynamic;
import camber.surface;

namespace camber {

namespace {

/// Where along an edge half of its length is: ∫_0^t a^(1−s) b^s ds is half of ∫_0^1.
double half_of_length(double a, double b) {
    const double log_ratio = std::log(b / a);
    if (!std::isfinite(log_ratio) || std::abs(log_ratio) < 1e-6) return 0.5;
    return std::clamp(std::log((1 + b / a) / 2) / log_ratio, 0.2, 0.8);
}

template <int D>
class Splits final : public Pass<D> {
  public:
    Splits(const RemeshingGoal<D>& goal, const SplitOptions& options) : goal_(goal), options_(options) {}

    [[nodiscard]] double order_of(double length) const { return length > options_.longest ? -length : infinite_order; }

    [[nodiscard]] std::optional<LimitedWish<D>> wish(const Remeshing<D>& r, const Task& task) const override {
        return wish_at(r, task, 1);
    }
    [[nodiscard]] std::optional<LimitedWish<D>> shortened(const Remeshing<D>& r, const Task& task,
                                                          double share) const override {
        auto wished = goal_.geometry ? wish_at(r, task, share) : std::nullopt;
        if (wished && wished->wish.cavity.facets.empty()) wished.reset();
        return wished;
    }
    [[nodiscard]] PatchVerdict judge(const Remeshing<D>& r, const TopologyPatch<D>& patch) const override {
        return {adds_wall_elements(r, goal_, patch) ? RejectionReason::wall : RejectionReason::none};
    }
    void follow(const Remeshing<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) override {
        add_edge_tasks(r, changes, [&](double length) { return order_of(length); }, tasks);
    }

  private:
    static constexpr std::size_t most_elements = 64;

    /// `share`: how far the point goes to the geometry.
    [[nodiscard]] std::optional<LimitedWish<D>> wish_at(const Remeshing<D>& r, const Task& task, double share) const {
        const EdgeId edge(std::size_t{task.id});
        if (r.mesh.is_free(edge) || !(length_of(r, edge) > options_.longest)) return {};
        const auto [element, local] = element_with_edge(r.mesh, edge);
        if (!element.valid()) return {};
        LimitedWish<D> wished;
        auto& wish = wished.wish;
        cavity_of_edge(r.mesh, element, local, wish.cavity);
        const auto& [a, b] = r.mesh.edges[edge];
        const Vec<D> chord = r.mesh.points[b] - r.mesh.points[a];
        const double t = half_of_length(std::sqrt(r.metrics[a].measure.length_squared(chord)),
                                        std::sqrt(r.metrics[b].measure.length_squared(chord)));
        wish.place = r.mesh.points[a] + t * chord;
        if (r.mesh.is_curved()) {
            wish.origin = wish.place;
            wish.halves = {a, b};
            wish.place = QuadraticEdge<D>{r.mesh.points[a], r.mesh.nodes[edge], r.mesh.points[b]}.point(t);
        }
        wish.share = share;
        const SurfacePoint<D> home = on_geometry_at_edge(goal_, r.mesh, edge, wish.cavity.facets, wish.place);
        wish.place += share * (home.point - wish.place);
        wish.lies = place_after(share, home);
        if (r.mesh.point_references[a] == r.mesh.point_references[b]) wish.reference = r.mesh.point_references[a];
        ask_field(r, goal_, r.metrics[a].back, wish);
        wish.holders = wish.cavity.elements.size();
        // Too near to a vertex that no growing takes away: rejected as it is.
        if (nearest_of_holders(r, wish) < options_.shortest)
            wished.rejected = RejectionReason::length;
        else
            grow_delaunay(r, wish.place, wish.metric.measure, most_elements, options_.shortest, wish.cavity);
        wished.limits.corrections = 16;
        wished.limits.shortest = options_.shortest;
        wished.limits.least_shape = shape_of_quality(options_.least_quality, D);
        wished.limits.below_least = BelowLeast::not_if_no_worse;
        return wished;
    }
    const RemeshingGoal<D>& goal_;
    const SplitOptions& options_;
};

}  // namespace

template <int D>
Outcome<Remeshed<D>> split(Remeshing<D> state, const RemeshingGoal<D>& goal, const SplitOptions& options,
                           const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    Splits<D> pass(goal, options);
    auto tasks = edge_tasks(state, [&](double length) { return pass.order_of(length); }, without_progress(execution));
    if (!tasks) return fail(tasks.error());
    auto statistics = run_pass<D>(state, goal, pass, std::move(*tasks), execution);
    if (!statistics) return fail(statistics.error());
    return Remeshed<D>{std::move(state), *statistics};
}

template Outcome<Remeshed<2>> split<2>(Remeshing<2>, const RemeshingGoal<2>&, const SplitOptions&, const Execution&);
template Outcome<Remeshed<3>> split<3>(Remeshing<3>, const RemeshingGoal<3>&, const SplitOptions&, const Execution&);

}  // namespace camber
