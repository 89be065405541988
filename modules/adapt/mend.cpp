module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.adapt;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;

namespace camber {

namespace {

/// Vertices of bad elements go into a neighbour where that makes the worst element around them better, and those that
/// cannot come foot to the geometry, where it makes none worse: a vertex too many is what swaps and moves cannot mend.
template <int D>
class Removals final : public Pass<D> {
  public:
    Removals(const AdaptationGoal<D>& goal, const MendOptions& options, const Column<VertexId>& off_geometry)
        : goal_(goal),
          wanted_(shape_of_quality(options.wanted, D)),
          off_geometry_(off_geometry.begin(), off_geometry.end()) {
        std::ranges::sort(off_geometry_);
    }

    /// A vertex of several bad elements is asked once, in the order of the worst; one whose refusal stands is not.
    [[nodiscard]] std::vector<Task> tasks(const Adaptation<D>& r) const {
        std::vector<double> orders(r.mesh.points.size(), infinite_order);
        for (std::size_t e = 0; e < r.mesh.elements.size(); ++e) {
            if (r.mesh.is_free(ElementId(e))) continue;
            const double shape = known_shape_of(r, ElementId(e));
            if (!(shape < wanted_)) continue;
            for (const VertexId v : r.mesh.elements.vertices[e]) orders[v.index()] = std::min(orders[v.index()], shape);
        }
        for (const VertexId v : off_geometry_) orders[v.index()] = std::min(orders[v.index()], 0.0);
        std::vector<Task> tasks;
        for (std::size_t i = 0; i < orders.size(); ++i) {
            const VertexId v(i);
            if (orders[i] < infinite_order && !r.mesh.is_at_infinity(v) && !stands(r, v))
                tasks.push_back(task(orders[i], v));
        }
        return tasks;
    }
    [[nodiscard]] std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const override {
        const VertexId v(std::size_t{task.id});
        if (r.mesh.is_free(v) || stands(r, v)) return {};
        Candidate<D> candidate;
        auto& [request, limits, rejected] = candidate;
        cavity_around(r.mesh, v, request.cavity);
        const double before = worst_shape_of(r, request.cavity.elements);
        const bool is_off_geometry = std::ranges::binary_search(off_geometry_, v) && is_off(r, request.cavity, v);
        if (!(before < wanted_) && !is_off_geometry) return {};
        limits.min_shape = gain * before;
        if (is_off_geometry) {
            limits.min_shape = shape_of_quality(min_quality, D);
            limits.below_least = BelowLeast::accepted_if_no_worse;
            limits.facet_cosine = 0.2;  // the facets around it are what is wrong
        }
        limits.longest = 2 * longest_unit_edge;
        limits.corrections = 0;
        limits.wall_elements = WallElements::refused;
        limits.facet_distance = 0.2;  // as of a collapse
        // What is looked at of straight elements is what is judged, and of curved ones near to it: nothing worse is
        // planned.
        const double nearly = r.mesh.is_curved() ? 0.7 : 1;
        const double least = is_off_geometry ? 0 : nearly * std::max(limits.min_shape, 0.0);
        const VertexId into = best_neighbour(r, goal_, request.cavity, v, least);
        if (!into.valid()) return {};
        request.join_to(r, into);
        return candidate;
    }
    void follow(Adaptation<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) override {
        for (const ElementId e : changes.elements.created) add_tasks(r, e, tasks);
    }
    void refused(Adaptation<D>& r, std::span<const Task> tasks) const override {
        refuse<VertexTag>(r, AskingPass::remove, tasks, r.mesh.points.size());
    }

  private:
    static constexpr double gain = 1.02, min_quality = 0.1;

    [[nodiscard]] static bool stands(const Adaptation<D>& r, VertexId v) {
        return r.refusals.stands(AskingPass::remove, v, std::span(&v, 1));
    }
    void add_tasks(const Adaptation<D>& r, ElementId e, std::vector<Task>& tasks) const {
        if (r.mesh.is_free(e)) return;
        const double shape = known_shape_of(r, e);
        if (!(shape < wanted_)) return;
        for (const VertexId v : r.mesh.elements.vertices[e])
            if (!r.mesh.is_at_infinity(v)) tasks.push_back(task(shape, v));
    }
    [[nodiscard]] bool is_off(const Adaptation<D>& r, const Cavity<D>& around, VertexId v) const {
        const VertexPlace place = r.mesh.states[v].place;
        if (place != VertexPlace::surface && place != VertexPlace::line) return false;
        const auto foot = foot_of(goal_, r.mesh, around, v, r.vertices.place(v).entity);
        return foot && !is_at_foot(r.mesh, around, r.mesh.points[v], foot->point);
    }

    const AdaptationGoal<D>& goal_;
    double wanted_;
    std::vector<VertexId> off_geometry_;  ///< rising
};

template <int D>
Outcome<Adapted<D>> remove_vertices(Adaptation<D> state, const AdaptationGoal<D>& goal, const MendOptions& options,
                                    const Execution& execution) {
    state.refusals.begin(AskingPass::remove, {options.wanted});
    Removals<D> pass(goal, options, state.off_geometry);
    auto statistics = run_pass<D>(state, goal, pass, pass.tasks(state), execution);
    if (!statistics) return fail(statistics.error());
    return Adapted<D>{std::move(state), *statistics};
}

}  // namespace

template <int D>
Outcome<Adapted<D>> mend(Adaptation<D> state, const AdaptationGoal<D>& goal, const MendOptions& options,
                         const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    Adapted<D> out{std::move(state), {}};
    for (int sweep = 0; sweep < options.sweeps; ++sweep) {
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

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Adapted<D>> mend<D>(Adaptation<D>, const AdaptationGoal<D>&, const MendOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
