module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>
module camber.remesh;
import camber.core;
import camber.metric;
import camber.dynamic;

namespace camber {

namespace {

template <int D>
class Collapses final : public Pass<D> {
  public:
    Collapses(const RemeshingGoal<D>& goal, const CollapseOptions& options) : goal_(goal), options_(options) {}

    [[nodiscard]] double order_of(double length) const { return length < options_.shortest ? length : infinite_order; }

    [[nodiscard]] std::optional<LimitedWish<D>> wish(const Remeshing<D>& r, const Task& task) const override {
        const EdgeId edge(std::size_t{task.id});
        if (r.mesh.is_free(edge) || !(length_of(r, edge) < options_.shortest)) return {};
        const auto& [a, b] = r.mesh.edges[edge];
        // Into the end where the worst element is better, of those where no edge becomes too long.
        std::optional<LimitedWish<D>> best;
        double best_shape = 0;
        ConeShapes<D> cones(r);
        for (const auto& [v, w] : {std::pair{a, b}, std::pair{b, a}}) {
            LimitedWish<D> wished;
            cavity_around(r.mesh, v, wished.wish.cavity);
            if (!may_collapse(r.mesh, wished.wish.cavity, v, w)) continue;
            cones.clear();
            for (const ElementId e : wished.wish.cavity.elements)
                cones.add(e, local_vertex(r.mesh.elements.vertices[e], v));
            const bool is_long = makes_long_edge(r, wished.wish.cavity.elements, cones, v, w);
            if (is_long && best) continue;
            const double least = best && best->rejected == RejectionReason::none ? best_shape : 0;
            const double shape = is_long ? 0 : cones.worst(r.mesh.points[w], r.metrics[w].measure, least, w);
            if (best && best->rejected == RejectionReason::none && !(shape > best_shape)) continue;
            wished.wish.join_to(r, w);
            if (is_long)
                wished.rejected = RejectionReason::length;
            else if (!(shape > 0) && !r.mesh.is_curved())  // the curved ones may be valid
                wished.rejected = RejectionReason::volume;
            wished.limits.longest = options_.longest;
            wished.limits.least_shape = shape_of_quality(options_.least_quality, D);
            wished.limits.below_least = BelowLeast::not_if_no_worse;
            wished.limits.corrections = 0;
            best_shape = shape;
            best = std::move(wished);
        }
        return best;
    }
    [[nodiscard]] PatchVerdict judge(const Remeshing<D>& r, const TopologyPatch<D>& patch) const override {
        if (adds_wall_elements(r, goal_, patch)) return {RejectionReason::wall};
        const FacetDistance facets = distance_from_geometry(r, goal_, patch, options_.distance);
        return {facets.is_near ? RejectionReason::none : RejectionReason::geometry, facets.largest};
    }
    void follow(const Remeshing<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) override {
        add_edge_tasks(r, changes, [&](double length) { return order_of(length); }, tasks);
    }

  private:
    /// From w to a vertex around v that it has no edge to yet.
    [[nodiscard]] bool makes_long_edge(const Remeshing<D>& r, const std::vector<ElementId>& around,
                                       const ConeShapes<D>& cones, VertexId v, VertexId w) const {
        std::vector<VertexId> beside{w};
        for (const ElementId e : around)
            if (const auto& vertices = r.mesh.elements.vertices[e]; local_vertex(vertices, w) >= 0)
                for (const VertexId x : vertices)
                    if (x != v && x != w) beside.push_back(x);
        return std::ranges::any_of(cones.vertices(), [&](const auto& corner) {
            return !is_among(beside, corner.vertex) && edge_length(r.metrics[w].measure, *corner.metric,
                                                                   corner.place - r.mesh.points[w]) > options_.longest;
        });
    }

    const RemeshingGoal<D>& goal_;
    const CollapseOptions& options_;
};

}  // namespace

template <int D>
Outcome<Remeshed<D>> collapse(Remeshing<D> state, const RemeshingGoal<D>& goal, const CollapseOptions& options,
                              const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    Collapses<D> pass(goal, options);
    auto tasks = edge_tasks(state, [&](double length) { return pass.order_of(length); }, without_progress(execution));
    if (!tasks) return fail(tasks.error());
    auto statistics = run_pass<D>(state, goal, pass, std::move(*tasks), execution);
    if (!statistics) return fail(statistics.error());
    return Remeshed<D>{std::move(state), *statistics};
}

template Outcome<Remeshed<2>> collapse<2>(Remeshing<2>, const RemeshingGoal<2>&, const CollapseOptions&,
                                          const Execution&);
template Outcome<Remeshed<3>> collapse<3>(Remeshing<3>, const RemeshingGoal<3>&, const CollapseOptions&,
                                          const Execution&);

}  // namespace camber
