module;
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>
module camber.remesh;
import camber.core;
import camber.metric;
import camber.dynamic;
import camber.surface;

namespace camber {

namespace {

template <int D>
class Homecomings final : public Pass<D> {
  public:
    explicit Homecomings(const RemeshingGoal<D>& goal) : goal_(goal) {}

    [[nodiscard]] std::optional<LimitedWish<D>> wish(const Remeshing<D>& r, const Task& task) const override {
        return wish_at(r, task, 1);
    }
    [[nodiscard]] std::optional<LimitedWish<D>> shortened(const Remeshing<D>& r, const Task& task,
                                                          double share) const override {
        return share > 0 ? wish_at(r, task, share) : std::nullopt;
    }
    void follow(const Remeshing<D>&, const TopologyChanges&, std::vector<Task>&) override {}

  private:
    /// `share`: how far the vertex goes.
    [[nodiscard]] std::optional<LimitedWish<D>> wish_at(const Remeshing<D>& r, const Task& task, double share) const {
        const VertexId v(std::size_t{task.id});
        if (v.index() >= r.mesh.points.size() || r.mesh.is_free(v)) return {};
        const VertexState& state = r.mesh.states[v];
        if (state.place != VertexPlace::surface && state.place != VertexPlace::line) return {};
        if (state.marks.has(Mark::required) || state.marks.has(Mark::held)) return {};
        LimitedWish<D> wished;
        CavityWish<D>& wish = wished.wish;
        cavity_of_vertex(r.mesh, v, wish.cavity);
        const Vec<D> here = r.mesh.points[v];
        const std::optional<SurfacePoint<D>> home =
            home_of(goal_, r.mesh, wish.cavity, v, r.places.empty() ? GeometryEntity{} : r.places[v].entity);
        if (!home || is_home(r.mesh, wish.cavity, here, home->point)) return {};
        wish.point = v;
        wish.place = here + share * (home->point - here);
        wish.lies = place_after(share, *home);
        wish.share = share;
        ask_field(r, goal_, r.metrics[v].back, wish);
        wished.limits.least_shape = shape_of_quality(least_quality, D);
        wished.limits.below_least = BelowLeast::not_if_no_worse;
        wished.limits.facet_cosine = 0.2;  // the facets around it are what is wrong
        wished.limits.corrections = 16;
        return wished;
    }

    static constexpr double least_quality = 0.05;
    const RemeshingGoal<D>& goal_;
};

}  // namespace

template <int D>
Outcome<PassStatistics> bring_home(Remeshing<D>& r, const RemeshingGoal<D>& goal, const Execution& execution) {
    PassStatistics all;
    if (!goal.geometry) return all;
    constexpr int most_turns = 8;  // where one goes, the next one may get farther
    Homecomings<D> pass(goal);
    for (int turn = 0; turn < most_turns && !r.astray.empty(); ++turn) {
        const Buffer<VertexId> astray = take(std::exchange(r.astray, {}));
        std::vector<Task> tasks;
        tasks.reserve(astray.size());
        for (const VertexId v : astray) tasks.push_back(task(0, v));
        auto statistics = run_pass<D>(r, goal, pass, std::move(tasks), execution);
        if (!statistics) return statistics;
        all += *statistics;
        Buffer<VertexId> left;
        for (const VertexId v : astray)
            if (pass.wish(r, task(0, v))) left.push_back(v);
        r.astray = std::move(left);
        if (statistics->accepted == 0) break;
    }
    return all;
}

template Outcome<PassStatistics> bring_home<2>(Remeshing<2>&, const RemeshingGoal<2>&, const Execution&);
template Outcome<PassStatistics> bring_home<3>(Remeshing<3>&, const RemeshingGoal<3>&, const Execution&);

}  // namespace camber
