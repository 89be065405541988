module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>
module camber.remesh;
import camber.core;
import camber.metric;
import camber.dynamic;

namespace camber {

namespace {

/// Every vertex put in again where it is: its cavity's inner nodes are wanted at their targets, and what would break an
/// element for it stays, or goes half of the way (see curve_star).
template <int D>
class Reinsertions final : public Pass<D> {
  public:
    Reinsertions(const ReinsertionOptions& options, std::size_t vertices) : options_(options), touched_(vertices, 1) {}

    [[nodiscard]] std::optional<LimitedWish<D>> wish(const Remeshing<D>& r, const Task& task) const override {
        const VertexId v(std::size_t{task.id});
        if (r.mesh.is_free(v) || r.mesh.states[v].marks.has(Mark::held)) return {};
        LimitedWish<D> wished;
        cavity_of_vertex(r.mesh, v, wished.wish.cavity);
        wished.wish.join_to(r, v);
        wished.limits.least_shape = shape_of_quality(options_.least_quality, D);
        wished.limits.below_least = BelowLeast::not_if_no_worse;
        wished.limits.least_jacobian = options_.least_jacobian;
        wished.limits.programmes = 0;
        wished.limits.corrections = 0;
        return wished;
    }
    /// A patch that moves no node noticeably is not worth a commit.
    [[nodiscard]] PatchVerdict judge(const Remeshing<D>& r, const TopologyPatch<D>& patch) const override {
        constexpr double noticeable = 1e-3;  // lengths in the metric
        const VertexId point = patch.point.vertex;
        for (const ElementId e : patch.removed.elements) {
            const auto& vertices = r.mesh.elements.vertices[e];
            const int at = local_vertex(vertices, point);
            for (int i = 0; i <= D; ++i) {
                if (i == at) continue;
                const auto spoke = std::ranges::find(patch.star.boundary, vertices[i]) - patch.star.boundary.begin();
                const Vec<D> shift = patch.nodes[static_cast<std::size_t>(spoke)].point -
                                     r.mesh.nodes[r.mesh.edges_of[e][edge_between<D>[i][at]]].point;
                if (r.metrics[point].measure.length_squared(shift) > noticeable * noticeable ||
                    r.metrics[vertices[i]].measure.length_squared(shift) > noticeable * noticeable)
                    return {RejectionReason::none};
            }
        }
        return {RejectionReason::gain};
    }
    void follow(const Remeshing<D>& r, const TopologyChanges& changes, std::vector<Task>&) override {
        for (const ElementId e : changes.elements.created)
            for (const VertexId v : r.mesh.elements.vertices[e]) touched_[v.index()] = 1;
    }
    /// All vertices at first, then those whose elements have changed since the last call.
    [[nodiscard]] std::vector<Task> tasks(const DynamicMesh<D>& mesh) {
        std::vector<Task> tasks;
        tasks.reserve(mesh.points.size());
        for (std::size_t v = 0; v < mesh.points.size(); ++v)
            if (touched_[v] != 0 && !mesh.is_free(VertexId(v))) tasks.push_back(task(0, VertexId(v)));
        touched_.assign(mesh.points.size(), 0);
        return tasks;
    }

  private:
    ReinsertionOptions options_;
    std::vector<std::uint8_t> touched_;  ///< of each vertex: an element of it has changed
};

}  // namespace

template <int D>
Outcome<Remeshed<D>> reinsert_vertices(Remeshing<D> state, const RemeshingGoal<D>& goal,
                                       const ReinsertionOptions& options, const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    Remeshed<D> out{std::move(state), {}};
    if (!out.state.mesh.is_curved()) return out;
    return guarded([&]() -> Outcome<Remeshed<D>> {
        Reinsertions<D> pass(options, out.state.mesh.points.size());
        for (int turn = 0; turn < options.turns; ++turn) {
            auto statistics = run_pass<D>(out.state, goal, pass, pass.tasks(out.state.mesh), execution);
            if (!statistics) return fail(statistics.error());
            out.statistics += *statistics;
            if (statistics->accepted == 0) break;
        }
        return std::move(out);
    });
}

template Outcome<Remeshed<2>> reinsert_vertices<2>(Remeshing<2>, const RemeshingGoal<2>&, const ReinsertionOptions&,
                                                   const Execution&);
template Outcome<Remeshed<3>> reinsert_vertices<3>(Remeshing<3>, const RemeshingGoal<3>&, const ReinsertionOptions&,
                                                   const Execution&);

}  // namespace camber
