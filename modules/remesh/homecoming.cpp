module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
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
        const Vec<D> home = home_of(r.mesh, wish.cavity, v);
        if (!(norm(home - here) > tolerance * size_at(r.mesh, wish.cavity) + rounding * largest_coordinate(here)))
            return {};
        wish.point = v;
        wish.place = here + share * (home - here);
        const FieldSample<D> sample = sample_value(goal_.field, wish.place, r.metrics[v].back);
        wish.metric = VertexMetric<D>(sample.log_metric, sample.location.element);
        wished.limits.least_shape = shape_of_quality(least_quality, D);
        wished.limits.share_of_replaced = 0.5;
        wished.limits.facet_cosine = 0.2;  // the facets around it are what is wrong
        wished.limits.corrections = 16;
        return wished;
    }
    [[nodiscard]] Vec<D> home_of(const DynamicMesh<D>& mesh, const CavityParts<D>& around, VertexId v) const {
        const Vec<D> here = mesh.points[v];
        if constexpr (D == 3)
            if (mesh.states[v].place == VertexPlace::line) {
                if (around.lines.empty()) return here;
                const EdgeId edge = mesh.lines[around.lines.front()];
                std::vector<FacetId> facets;
                facets_with(mesh, around.elements, edge, facets);
                return on_geometry_at_edge(goal_, mesh, edge, facets, here);
            }
        if (around.facets.empty()) return here;
        const FacetId f = around.facets.front();
        if ((*goal_.geometry)->surface_at(site_of(mesh, f)).kind == GeometryKind::none) return here;
        return on_geometry_at_facet(goal_, mesh, f, here);
    }
    [[nodiscard]] static double size_at(const DynamicMesh<D>& mesh, const CavityParts<D>& around) {
        if (around.facets.empty()) return 0;
        const auto p = corners_of(mesh, around.facets.front());
        return norm(p[1] - p[0]);
    }

    [[nodiscard]] static double largest_coordinate(const Vec<D>& p) {
        double largest = 0;
        for (const double x : p.c) largest = std::max(largest, std::abs(x));
        return largest;
    }

    static constexpr double rounding = 32 * std::numeric_limits<double>::epsilon();
    static constexpr double tolerance = 1e-9;  // of the size of facets: projections are so to rounding
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
        auto statistics = run_pass<D>(r, pass, std::move(tasks), execution);
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
