module;
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>
module camber.adapt;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;
import camber.surface;

namespace camber {

namespace {

template <int D>
class Snaps final : public Pass<D> {
  public:
    explicit Snaps(const AdaptationGoal<D>& goal) : goal_(goal) {}

    [[nodiscard]] std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const override {
        return candidate_at(r, task, 1);
    }
    [[nodiscard]] std::optional<Candidate<D>> shortened(const Adaptation<D>& r, const Task& task,
                                                        double share) const override {
        return share > 0 ? candidate_at(r, task, share) : std::nullopt;
    }
    void follow(Adaptation<D>&, const TopologyChanges&, std::vector<Task>&) override {}

  private:
    /// `share`: how far the vertex goes.
    [[nodiscard]] std::optional<Candidate<D>> candidate_at(const Adaptation<D>& r, const Task& task,
                                                           double share) const {
        const VertexId v(std::size_t{task.id});
        if (v.index() >= r.mesh.points.size() || r.mesh.is_free(v)) return {};
        const VertexState& state = r.mesh.states[v];
        if (state.place != VertexPlace::surface && state.place != VertexPlace::line) return {};
        if (state.marks.has(Mark::required) || state.marks.has(Mark::frozen)) return {};
        Candidate<D> candidate;
        CavityRequest<D>& request = candidate.request;
        cavity_of_vertex(r.mesh, v, request.cavity);
        const Vec<D> here = r.mesh.points[v];
        const std::optional<SurfacePoint<D>> foot =
            foot_of(goal_, r.mesh, request.cavity, v, r.vertices.place(v).entity);
        if (!foot || is_at_foot(r.mesh, request.cavity, here, foot->point)) return {};
        request.point = v;
        request.place = here + share * (foot->point - here);
        request.lies = place_after(share, *foot);
        request.share = share;
        ask_field(r, goal_, r.vertices.metrics[v].back, request);
        candidate.limits.min_shape = shape_of_quality(min_quality, D);
        candidate.limits.below_least = BelowLeast::accepted_if_no_worse;
        candidate.limits.facet_cosine = 0.2;  // the facets around it are what is wrong
        candidate.limits.corrections = 16;
        return candidate;
    }

    static constexpr double min_quality = 0.05;
    const AdaptationGoal<D>& goal_;
};

}  // namespace

template <int D>
Outcome<PassStatistics> snap_to_geometry(Adaptation<D>& r, const AdaptationGoal<D>& goal, const Execution& execution) {
    PassStatistics all;
    if (!goal.geometry) return all;
    constexpr int max_turns = 8;  // where one goes, the next one may get farther
    Snaps<D> pass(goal);
    for (int turn = 0; turn < max_turns && !r.off_geometry.empty(); ++turn) {
        const Buffer<VertexId> off_geometry = take(std::exchange(r.off_geometry, {}));
        std::vector<Task> tasks;
        tasks.reserve(off_geometry.size());
        for (const VertexId v : off_geometry) tasks.push_back(task(0, v));
        auto statistics = run_pass<D>(r, goal, pass, std::move(tasks), execution);
        if (!statistics) return statistics;
        all += *statistics;
        Buffer<VertexId> left;
        for (const VertexId v : off_geometry)
            if (pass.candidate(r, task(0, v))) left.push_back(v);
        r.off_geometry = std::move(left);
        if (statistics->accepted == 0) break;
    }
    return all;
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<PassStatistics> snap_to_geometry<D>(Adaptation<D>&, const AdaptationGoal<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
