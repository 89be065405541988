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
import camber.cavity;
import camber.metric;
import camber.crossing;
import camber.surface;

namespace camber {

namespace {

/// Initial tasks are sorted once, which is cheaper than a heap; later tasks are in a heap.
class TaskQueue {
  public:
    explicit TaskQueue(std::vector<Task> tasks) : sorted_(std::move(tasks)) { std::ranges::sort(sorted_, later); }

    [[nodiscard]] std::size_t size() const { return sorted_.size() + heap_.size(); }
    [[nodiscard]] bool empty() const { return size() == 0; }
    void put(const Task& task) {
        heap_.push_back(task);
        std::ranges::push_heap(heap_, later);
    }
    [[nodiscard]] Task take_first() {
        const bool from_heap = sorted_.empty() || (!heap_.empty() && heap_.front() < sorted_.back());
        if (from_heap) std::ranges::pop_heap(heap_, later);
        std::vector<Task>& from = from_heap ? heap_ : sorted_;
        const Task first = from.back();
        from.pop_back();
        return first;
    }

  private:
    static bool later(const Task& a, const Task& b) { return b < a; }

    std::vector<Task> sorted_;  ///< the first task is at the end
    std::vector<Task> heap_;
};

/// Number of tasks in a round: small relative to the mesh, to avoid conflicts, and large enough for the threads.
std::size_t window_of(std::size_t elements) { return std::clamp<std::size_t>(elements / 256, 32, 8192); }

/// Elements that the patches of a round remove or reshape, and edges that the patches create.
class Claims {
  public:
    void begin(std::size_t elements) {
        claimed_.resize(std::max(elements, claimed_.size()), 0);
        ++round_;
        edges_.clear();
    }
    template <int D>
    [[nodiscard]] bool take(const DynamicMesh<D>& mesh, const Patch<D>& patch) {
        const auto is_claimed = [&](ElementId e) { return claimed_[e.index()] == round_; };
        if (std::ranges::any_of(patch.removed.elements, is_claimed)) return false;
        if (std::ranges::any_of(patch.reshaped, is_claimed)) return false;
        if (const VertexId p = patch.point.vertex;
            p.valid() && !preserves_topology<D>(mesh.elements.vertices.view(), patch)) {
            for (const VertexId v : patch.star.boundary)
                if (edges_.contains(key(p, v))) return false;
            for (const VertexId v : patch.star.boundary) edges_.insert(key(p, v));
        }
        for (const ElementId e : patch.removed.elements) claimed_[e.index()] = round_;
        for (const ElementId e : patch.reshaped) claimed_[e.index()] = round_;
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

template <int D>
struct Planned {
    bool is_requested = false;
    OperationResult result;
    JudgedPatch<D> patch;
};

template <int D>
class PassRunner {
  public:
    PassRunner(Adaptation<D>& r, const AdaptationGoal<D>& goal, Pass<D>& pass, std::vector<Task> tasks,
               const Execution& execution)
        : r_(r), goal_(goal), pass_(pass), tasks_(std::move(tasks)), execution_(execution) {}

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
    void take_front() {
        front_.clear();
        for (std::size_t n = std::min(window_of(r_.mesh.element_count()), tasks_.size()); n > 0; --n)
            front_.push_back(tasks_.take_first());
        by_id_.resize(front_.size());
        std::iota(by_id_.begin(), by_id_.end(), std::size_t{0});
        std::ranges::sort(by_id_, {}, [&](std::size_t i) { return front_[i].id; });
    }
    [[nodiscard]] Outcome<std::vector<Planned<D>>> plan_front(const Execution& execution) {
        std::vector<Planned<D>> planned(front_.size());
        constexpr std::size_t grain = 16;  // a task takes tens of microseconds
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
        out.is_requested = candidate.has_value();
        for (double share = 1; candidate;) {
            out.result = candidate->rejected == RejectionReason::none
                             ? operate(r_, goal_, candidate->request, candidate->limits, workspace, out.patch)
                             : OperationResult{.rejected = candidate->rejected, .is_planned = false};
            if (!depends_on_position(out.result.rejected) || share == 0) return;
            share = share > 0.2 ? share / 2 : 0;
            const Vec<D> before = candidate->request.place;
            candidate = pass_.shortened(r_, task, share);
            if (candidate && !candidate->request.point.valid() && candidate->request.place == before)
                return;  // the position does not change, because the geometry coincides with the chord
        }
    }
    [[nodiscard]] static bool depends_on_position(RejectionReason reason) {
        return reason == RejectionReason::volume || reason == RejectionReason::height ||
               reason == RejectionReason::quality || reason == RejectionReason::geometry ||
               reason == RejectionReason::crossing;
    }
    [[nodiscard]] Outcome<Done> choose_and_commit(std::vector<Planned<D>>& planned) {
        claims_.begin(r_.mesh.elements.size());
        new_facets_.clear();
        std::vector<JudgedPatch<D>> patches;
        refused_.clear();
        for (std::size_t i = 0; i < planned.size(); ++i) {
            auto& [is_requested, result, patch] = planned[i];
            if (!is_requested) {
                refused_.push_back(front_[i]);
                continue;
            }
            if (result.rejected == RejectionReason::none &&
                !(claims_.take(r_.mesh, patch.patch()) && new_facets_.take(r_.mesh, patch.patch()))) {
                result.rejected = RejectionReason::waits;
                tasks_.put(front_[i]);
            }
            count(result, patch.is_short_of_geometry());
            if (result.rejected == RejectionReason::none)
                patches.push_back(std::move(patch));
            else if (result.rejected != RejectionReason::waits)
                refused_.push_back(front_[i]);
        }
        pass_.refused(r_, refused_);
        if (patches.empty()) return Done{};
        auto committed = commit<D>(std::move(r_), std::move(patches));
        if (!committed) return fail(committed.error());
        r_ = std::move(committed->state);
        ++statistics_.rounds;
        if (r_.mesh.element_count() > goal_.max_elements) return fail(too_many_elements());
        std::vector<Task> followers;
        pass_.follow(r_, committed->changes, followers);
        for (const Task& task : followers) tasks_.put(task);
        return Done{};
    }

    void count(const OperationResult& result, bool is_short_of_geometry) {
        PassStatistics& s = statistics_;
        ++s.proposals;
        s.planned += result.is_planned ? 1 : 0;
        s.optimisation_problems += static_cast<std::size_t>(result.optimisation_problems);
        if (result.rejected != RejectionReason::none) {
            s.straight_positive += result.straight_positive ? 1 : 0;
            ++s.rejected[static_cast<std::size_t>(result.rejected)];
            return;
        }
        ++s.accepted;
        s.straight_inverted += result.straight_inverted ? 1 : 0;
        s.relaxed += result.relaxed ? 1 : 0;
        s.bent_around += result.bends_around ? 1 : 0;
        s.farthest_facet = std::max(s.farthest_facet, result.farthest_facet);
        s.shortened += is_short_of_geometry ? 1 : 0;
        s.corrections += static_cast<std::size_t>(result.corrections);
    }

    [[nodiscard]] Error too_many_elements() const {
        return {ErrorKind::memory,
                "the metric requires more than " + std::to_string(goal_.max_elements) +
                    " elements, the largest number that fits into memory",
                {},
                {},
                "make it coarser: metric_operations bound, gradation or complexity, or a larger split/longest"};
    }

    Adaptation<D>& r_;
    const AdaptationGoal<D>& goal_;
    Pass<D>& pass_;
    TaskQueue tasks_;
    std::vector<Task> front_, refused_;
    std::vector<std::size_t> by_id_;  ///< indices of the round's tasks (`front_`), sorted by entity number for locality
    const Execution& execution_;
    Claims claims_;
    NewFacets<D> new_facets_;
    PassStatistics statistics_;
    std::size_t done_ = 0;
};

}  // namespace

template <int D>
Outcome<PassStatistics> run_pass(Adaptation<D>& r, const AdaptationGoal<D>& goal, Pass<D>& pass,
                                 std::vector<Task> tasks, const Execution& execution) {
    return guarded([&] { return PassRunner<D>(r, goal, pass, std::move(tasks), execution).run(); });
}

#define CAMBER_INSTANTIATE(D)                                                                        \
    template Outcome<PassStatistics> run_pass<D>(Adaptation<D>&, const AdaptationGoal<D>&, Pass<D>&, \
                                                 std::vector<Task>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
