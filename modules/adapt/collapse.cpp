module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
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

template <int D>
class Collapses final : public Pass<D> {
  public:
    Collapses(const AdaptationGoal<D>& goal, const CollapseOptions& options) : goal_(goal), options_(options) {}

    [[nodiscard]] double order_of(double length) const { return length < options_.shortest ? length : infinite_order; }

    [[nodiscard]] std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const override {
        const EdgeId edge(std::size_t{task.id});
        if (r.mesh.is_free(edge) || !(length_of(r, edge) < options_.shortest)) return {};
        const auto& [a, b] = r.mesh.edges[edge];
        // Into the end where the worst element is better, of those where no edge becomes too long.
        std::optional<Candidate<D>> best;
        double best_shape = 0;
        ConeShapes<D> cones(r, goal_);
        for (const auto& [v, w] : {std::pair{a, b}, std::pair{b, a}}) {
            Candidate<D> candidate;
            cavity_around(r.mesh, v, candidate.request.cavity);
            if (!may_collapse(r.mesh, candidate.request.cavity, v, w)) continue;
            cones.clear();
            for (const ElementId e : candidate.request.cavity.elements)
                cones.add(e, local_vertex(r.mesh.elements.vertices[e], v));
            cones.place(cone_point(r, w));
            const bool is_long = makes_long_edge(r, candidate.request.cavity.elements, cones, v, w);
            if (is_long && best) continue;
            const double least = best && best->rejected == RejectionReason::none ? best_shape : 0;
            const double shape = is_long ? 0 : cones.worst(least, w);
            if (best && best->rejected == RejectionReason::none && !(shape > best_shape)) continue;
            candidate.request.join_to(r, w);
            if (is_long)
                candidate.rejected = RejectionReason::length;
            else if (!(shape > 0))
                candidate.rejected = RejectionReason::volume;
            candidate.limits.longest = options_.longest;
            candidate.limits.min_shape = shape_of_quality(options_.min_quality, D);
            candidate.limits.below_least = BelowLeast::accepted_if_no_worse;
            candidate.limits.corrections = 0;
            candidate.limits.bend_around = options_.bend_around;
            candidate.limits.wall_elements = WallElements::refused;
            candidate.limits.facet_distance = options_.distance;
            best_shape = shape;
            best = std::move(candidate);
        }
        return best;
    }
    [[nodiscard]] static bool has_stood(const Adaptation<D>& r, EdgeId e) {
        return r.refusals.stands(AskingPass::collapse, e, std::span(r.mesh.edges[e]));
    }
    void refused(Adaptation<D>& r, std::span<const Task> tasks) const override {
        refuse<EdgeTag>(r, AskingPass::collapse, tasks, r.mesh.edges.size());
    }
    void follow(Adaptation<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) override {
        add_edge_tasks(r, changes, [&](double length) { return order_of(length); }, tasks);
    }

  private:
    /// From w to a vertex around v that it has no edge to yet.
    [[nodiscard]] bool makes_long_edge(const Adaptation<D>& r, const std::vector<ElementId>& around,
                                       ConeShapes<D>& cones, VertexId v, VertexId w) const {
        std::vector<VertexId> beside{w};
        for (const ElementId e : around)
            if (const auto& vertices = r.mesh.elements.vertices[e]; local_vertex(vertices, w) >= 0)
                for (const VertexId x : vertices)
                    if (x != v && x != w) beside.push_back(x);
        const auto corners = cones.vertices();
        for (std::size_t i = 0; i < corners.size(); ++i)
            if (!is_among(beside, corners[i].vertex) && cones.length_to(i) > options_.longest) return true;
        return false;
    }

    const AdaptationGoal<D>& goal_;
    const CollapseOptions& options_;
};

}  // namespace

template <int D>
Outcome<Adapted<D>> collapse(Adaptation<D> state, const AdaptationGoal<D>& goal, const CollapseOptions& options,
                             const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    state.refusals.begin(AskingPass::collapse, {options.shortest, options.longest, options.min_quality,
                                                options.distance, static_cast<double>(options.bend_around)});
    return run_on_edges<D>(std::move(state), goal, Collapses<D>(goal, options), execution);
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template Outcome<Adapted<D>> collapse<D>(Adaptation<D>, const AdaptationGoal<D>&, const CollapseOptions&, \
                                             const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
