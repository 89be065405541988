module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>
module camber.remesh;
import camber.core;
import camber.metric;
import camber.dynamic;

namespace camber {

namespace {

/// Vertices of bad elements go into a neighbour where that makes the worst element around them better, and those that
/// cannot come home to the geometry, where it makes none worse: a vertex too many is what swaps and moves cannot mend.
template <int D>
class Removals final : public Pass<D> {
  public:
    Removals(const RemeshingGoal<D>& goal, const MendOptions& options, const Column<VertexId>& astray)
        : goal_(goal), wanted_(shape_of_quality(options.wanted, D)), astray_(astray.begin(), astray.end()) {
        std::ranges::sort(astray_);
    }

    [[nodiscard]] std::vector<Task> tasks(const Remeshing<D>& r) const {
        std::vector<Task> tasks;
        tasks.reserve(astray_.size());
        for (const VertexId v : astray_) tasks.push_back(task(0, v));
        for (std::size_t e = 0; e < r.mesh.elements.size(); ++e) add_tasks(r, ElementId(e), tasks);
        return tasks;
    }
    [[nodiscard]] std::optional<LimitedWish<D>> wish(const Remeshing<D>& r, const Task& task) const override {
        const VertexId v(std::size_t{task.id});
        if (r.mesh.is_free(v)) return {};
        LimitedWish<D> wished;
        auto& [wish, limits, rejected] = wished;
        cavity_around(r.mesh, v, wish.cavity);
        const double before = worst_shape_of(r, wish.cavity.elements);
        const bool is_astray = std::ranges::binary_search(astray_, v) && is_off(r, wish.cavity, v);
        if (!(before < wanted_) && !is_astray) return {};
        limits.least_shape = gain * before;
        if (is_astray) {
            limits.least_shape = shape_of_quality(least_quality, D);
            limits.below_least = BelowLeast::not_if_no_worse;
            limits.facet_cosine = 0.2;  // the facets around it are what is wrong
        }
        limits.longest = 2 * longest_unit_edge;
        limits.corrections = 0;
        const VertexId into = best_neighbour(r, wish.cavity, v);
        if (!into.valid()) return {};
        wish.join_to(r, into);
        return wished;
    }
    [[nodiscard]] PatchVerdict judge(const Remeshing<D>& r, const TopologyPatch<D>& patch) const override {
        constexpr double most = 0.2;  // as of a collapse
        if (adds_wall_elements(r, goal_, patch)) return {RejectionReason::wall};
        const FacetDistance facets = distance_from_geometry(r, goal_, patch, most);
        return {facets.is_near ? RejectionReason::none : RejectionReason::geometry, facets.largest};
    }
    void follow(const Remeshing<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) override {
        for (const ElementId e : changes.elements.created) add_tasks(r, e, tasks);
    }

  private:
    static constexpr double gain = 1.02, least_quality = 0.1;

    void add_tasks(const Remeshing<D>& r, ElementId e, std::vector<Task>& tasks) const {
        if (r.mesh.is_free(e)) return;
        const double shape = shape_of(r, e);
        if (!(shape < wanted_)) return;
        for (const VertexId v : r.mesh.elements.vertices[e]) tasks.push_back(task(shape, v));
    }
    [[nodiscard]] bool is_off(const Remeshing<D>& r, const CavityParts<D>& around, VertexId v) const {
        const VertexPlace place = r.mesh.states[v].place;
        if (place != VertexPlace::surface && place != VertexPlace::line) return false;
        const auto home = home_of(goal_, r.mesh, around, v, r.places.empty() ? GeometryEntity{} : r.places[v].entity);
        return home && !is_home(r.mesh, around, r.mesh.points[v], home->point);
    }
    /// Where the worst straight element is best.
    [[nodiscard]] static VertexId best_neighbour(const Remeshing<D>& r, const CavityParts<D>& around, VertexId v) {
        ConeShapes<D> cones(r);
        for (const ElementId e : around.elements) cones.add(e, local_vertex(r.mesh.elements.vertices[e], v));
        VertexId best;
        double best_shape = 0;
        for (const auto& corner : cones.vertices()) {
            if (!may_collapse(r.mesh, around, v, corner.vertex)) continue;
            const double shape = cones.worst(corner.place, *corner.metric, best_shape, corner.vertex);
            if (!(shape > best_shape)) continue;
            best = corner.vertex;
            best_shape = shape;
        }
        return best;
    }

    const RemeshingGoal<D>& goal_;
    double wanted_;
    std::vector<VertexId> astray_;  ///< rising
};

template <int D>
Outcome<Remeshed<D>> remove_vertices(Remeshing<D> state, const RemeshingGoal<D>& goal, const MendOptions& options,
                                     const Execution& execution) {
    Removals<D> pass(goal, options, state.astray);
    auto statistics = run_pass<D>(state, goal, pass, pass.tasks(state), execution);
    if (!statistics) return fail(statistics.error());
    return Remeshed<D>{std::move(state), *statistics};
}

}  // namespace

template <int D>
Outcome<Remeshed<D>> mend(Remeshing<D> state, const RemeshingGoal<D>& goal, const MendOptions& options,
                          const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    Remeshed<D> out{std::move(state), {}};
    for (int turn = 0; turn < options.turns; ++turn) {
        const std::size_t before = out.statistics.accepted;
        auto swapped = swap<D>(std::move(out.state), goal, {.wanted = options.wanted}, execution);
        if (!swapped) return fail(swapped.error());
        out.statistics += swapped->statistics;
        auto moved = smooth<D>(std::move(swapped->state), goal, {.wanted = options.wanted}, execution);
        if (!moved) return fail(moved.error());
        out.statistics += moved->statistics;
        auto removed = remove_vertices<D>(std::move(moved->state), goal, options, execution);
        if (!removed) return fail(removed.error());
        out.statistics += removed->statistics;
        out.state = std::move(removed->state);
        if (out.statistics.accepted == before) break;
    }
    return out;
}

template Outcome<Remeshed<2>> mend<2>(Remeshing<2>, const RemeshingGoal<2>&, const MendOptions&, const Execution&);
template Outcome<Remeshed<3>> mend<3>(Remeshing<3>, const RemeshingGoal<3>&, const MendOptions&, const Execution&);

}  // namespace camber
