module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>
#include <unordered_set>
#include <utility>
#include <vector>
module camber.operation;
import camber.core;
import camber.metric;
import camber.crossing;
import camber.cavity;
import camber.surface;

namespace camber {

namespace {

/// So many tasks are planned in a round: few against the mesh, so that few are in one another's way and are planned
/// again, and enough for the threads.
std::size_t window_of(std::size_t elements) { return std::clamp<std::size_t>(elements / 256, 32, 8192); }

/// Elements that patches of a round remove, and edges that they make.
class Claims {
  public:
    void begin(std::size_t elements) {
        claimed_.resize(std::max(elements, claimed_.size()), 0);
        ++round_;
        edges_.clear();
    }
    template <int D>
    [[nodiscard]] bool take(const DynamicMesh<D>& mesh, const Patch<D>& patch) {
        for (const ElementId e : patch.removed.elements)
            if (claimed_[e.index()] == round_) return false;
        if (const VertexId p = patch.point.vertex;
            p.valid() && !keeps_topology<D>(mesh.elements.vertices.view(), patch)) {
            for (const VertexId v : patch.star.boundary)
                if (edges_.contains(key(p, v))) return false;
            for (const VertexId v : patch.star.boundary) edges_.insert(key(p, v));
        }
        for (const ElementId e : patch.removed.elements) claimed_[e.index()] = round_;
        return true;
    }

  private:
    [[nodiscard]] static std::uint64_t key(VertexId a, VertexId b) {
        return std::uint64_t{std::min(a, b).value} << 32U | std::max(a, b).value;
    }
    std::vector<std::uint32_t> claimed_;
    std::unordered_set<std::uint64_t> edges_;
    std::uint32_t round_ = 0;
};

/// What a mesh keeps of the point of a patch.
template <int D>
struct OfPoint {
    VertexMetric<D> metric;
    GeometryPlace lies;
    LogGradient<D> gradient{};
    bool shortened = false;
};

/// What came of a task.
template <int D>
struct Planned {
    bool is_asked = false;
    OperationResult result;
    Patch<D> patch;
    OfPoint<D> of_point;
    double farthest_facet = 0;
};

template <int D>
class Rounds {
  public:
    Rounds(Adaptation<D>& r, const AdaptationGoal<D>& goal, Pass<D>& pass, std::vector<Task> tasks,
           const Execution& execution)
        : r_(r), goal_(goal), pass_(pass), tasks_(std::move(tasks)), execution_(execution) {
        std::make_heap(tasks_.begin(), tasks_.end(), later);
    }

    [[nodiscard]] Outcome<PassStatistics> run() {
        const Execution quiet = without_progress(execution_);
        while (!tasks_.empty()) {
            take_front();
            auto planned = plan_front(quiet);
            if (!planned) return fail(planned.error());
            auto committed = choose_and_commit(*planned);
            if (!committed) return fail(committed.error());
            done_ += front_.size();
            if (execution_.progress) execution_.progress(done_, done_ + tasks_.size());
        }
        return statistics_;
    }

  private:
    static bool later(const Task& a, const Task& b) { return b < a; }
    void put(const Task& task) {
        tasks_.push_back(task);
        std::push_heap(tasks_.begin(), tasks_.end(), later);
    }
    void take_front() {
        front_.clear();
        for (std::size_t n = std::min(window_of(r_.mesh.element_count()), tasks_.size()); n > 0; --n) {
            std::pop_heap(tasks_.begin(), tasks_.end(), later);
            front_.push_back(tasks_.back());
            tasks_.pop_back();
        }
        by_id_.resize(front_.size());
        std::iota(by_id_.begin(), by_id_.end(), std::size_t{0});
        std::ranges::sort(by_id_, {}, [&](std::size_t i) { return front_[i].id; });
    }
    [[nodiscard]] Outcome<std::vector<Planned<D>>> plan_front(const Execution& execution) {
        std::vector<Planned<D>> planned(front_.size());
        constexpr std::size_t grain = 16;  // tens of microseconds each
        auto done = each_chunk(
            execution, front_.size(),
            [&](std::size_t begin, std::size_t end) {
                OperationWorkspace<D> workspace;
                for (std::size_t i = begin; i < end; ++i) plan_task(front_[by_id_[i]], workspace, planned[by_id_[i]]);
            },
            grain);
        if (!done) return fail(done.error());
        return planned;
    }
    void plan_task(const Task& task, OperationWorkspace<D>& workspace, Planned<D>& out) const {
        std::optional<Candidate<D>> candidate = pass_.candidate(r_, task);
        out.is_asked = candidate.has_value();
        for (double share = 1; candidate;) {
            out.of_point = {candidate->request.metric, candidate->request.lies, candidate->request.gradient, share < 1};
            out.result = candidate->rejected == RejectionReason::none
                             ? operate(r_, goal_, candidate->request, candidate->limits, workspace, out.patch)
                             : OperationResult{.rejected = candidate->rejected};
            if (out.result.rejected == RejectionReason::none) {
                const PatchVerdict verdict = pass_.judge(r_, out.patch);
                out.result.rejected = verdict.rejected;
                out.farthest_facet = verdict.farthest_facet;
            }
            if (out.result.rejected == RejectionReason::none && r_.mesh.is_curved() && !are_walls_clear(r_, out.patch))
                out.result.rejected = RejectionReason::crossing;
            if (!lies_badly(out.result.rejected) || share == 0) return;
            share = share > 0.2 ? share / 2 : 0;
            const Vec<D> before = candidate->request.place;
            candidate = pass_.shortened(r_, task, share);
            if (candidate && !candidate->request.point.valid() && candidate->request.place == before) return;  // the geometry is the chord
        }
    }
    [[nodiscard]] static bool lies_badly(RejectionReason reason) {
        return reason == RejectionReason::volume || reason == RejectionReason::height ||
               reason == RejectionReason::quality || reason == RejectionReason::geometry ||
               reason == RejectionReason::crossing;
    }
    [[nodiscard]] Outcome<Done> choose_and_commit(std::vector<Planned<D>>& planned) {
        claims_.begin(r_.mesh.elements.size());
        new_walls_.clear();
        std::vector<Patch<D>> patches;
        std::vector<OfPoint<D>> of_points;
        for (std::size_t i = 0; i < planned.size(); ++i) {
            auto& [is_asked, result, patch, of_point, farthest_facet] = planned[i];
            if (!is_asked) continue;
            ++statistics_.proposals;
            statistics_.programmes += static_cast<std::size_t>(result.programmes);
            if (result.rejected == RejectionReason::none &&
                !(claims_.take(r_.mesh, patch) && new_walls_.take(r_.mesh, patch))) {
                result.rejected = RejectionReason::waits;
                put(front_[i]);
            }
            if (result.rejected != RejectionReason::none) {
                statistics_.straight_positive += result.straight_positive ? 1 : 0;
                ++statistics_.rejected[static_cast<std::size_t>(result.rejected)];
                continue;
            }
            ++statistics_.accepted;
            statistics_.straight_inverted += result.straight_inverted ? 1 : 0;
            statistics_.drawn_back += result.drawn_back ? 1 : 0;
            statistics_.farthest_facet = std::max(statistics_.farthest_facet, farthest_facet);
            statistics_.shortened += of_point.shortened ? 1 : 0;
            statistics_.corrections += static_cast<std::size_t>(result.corrections);
            patches.push_back(std::move(patch));
            of_points.push_back(of_point);
        }
        if (patches.empty()) return Done{};
        auto changed = commit<D>(std::move(r_.mesh), patches);
        if (!changed) return fail(changed.error());
        r_.mesh = std::move(changed->mesh);
        auto of_vertices = take(std::move(r_.metrics));
        of_vertices.resize(r_.mesh.points.size());
        auto places = take(std::move(r_.places));
        if (!places.empty()) places.resize(r_.mesh.points.size());
        auto gradients = take(std::move(r_.gradients));
        if (!gradients.empty()) gradients.resize(r_.mesh.points.size());
        auto off_geometry = take(std::move(r_.off_geometry));
        for (std::size_t i = 0; i < of_points.size(); ++i) {
            const VertexId point = changed->changes.points[i];
            of_vertices[point.index()] = of_points[i].metric;
            if (!gradients.empty()) gradients[point.index()] = of_points[i].gradient;
            if (!places.empty()) places[point.index()] = of_points[i].lies;
            if (of_points[i].shortened) off_geometry.push_back(point);
        }
        r_.metrics = std::move(of_vertices);
        r_.places = std::move(places);
        r_.gradients = std::move(gradients);
        r_.off_geometry = std::move(off_geometry);
        if (r_.mesh.is_curved()) follow_walls(r_.walls, r_.mesh, changed->changes.facets);
        ++statistics_.rounds;
        if (r_.mesh.element_count() > goal_.max_elements) return fail(too_many_elements());
        std::vector<Task> followers;
        pass_.follow(r_, changed->changes, followers);
        for (const Task& task : followers) put(task);
        return Done{};
    }

    [[nodiscard]] Error too_many_elements() const {
        return {ErrorKind::memory,
                "the metric asks for more than " + std::to_string(goal_.max_elements) +
                    " elements, which is what there is room for",
                {},
                {},
                "make it coarser: metric_operations bound, gradation or complexity, or a larger split/longest"};
    }

    Adaptation<D>& r_;
    const AdaptationGoal<D>& goal_;
    Pass<D>& pass_;
    std::vector<Task> tasks_, front_;
    std::vector<std::size_t> by_id_;  ///< of the front: neighbours in memory are planned one after the other
    const Execution& execution_;
    Claims claims_;
    NewWalls<D> new_walls_;
    PassStatistics statistics_;
    std::size_t done_ = 0;
};

}  // namespace

template <int D>
Outcome<PassStatistics> run_pass(Adaptation<D>& r, const AdaptationGoal<D>& goal, Pass<D>& pass, std::vector<Task> tasks,
                                 const Execution& execution) {
    return guarded([&] { return Rounds<D>(r, goal, pass, std::move(tasks), execution).run(); });
}

template Outcome<PassStatistics> run_pass<2>(Adaptation<2>&, const AdaptationGoal<2>&, Pass<2>&, std::vector<Task>,
                                             const Execution&);
template Outcome<PassStatistics> run_pass<3>(Adaptation<3>&, const AdaptationGoal<3>&, Pass<3>&, std::vector<Task>,
                                             const Execution&);

}  // namespace camber
