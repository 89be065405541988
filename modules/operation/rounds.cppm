module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <tuple>
#include <vector>
export module camber.operation:rounds;
import camber.core;
import camber.metric;
import camber.cavity;
import :measures;
import :operate;
import :state;
import :request;

export namespace camber {

/// What a pass did.
struct PassStatistics {
    std::size_t rounds = 0;     ///< commits
    std::size_t proposals = 0;  ///< requests; one that waits is made again, and counted again
    std::size_t planned = 0;    ///< those of them that a pass's own measures let through, of which a star was made
    std::size_t accepted = 0;
    std::size_t corrections = 0;  ///< how often elements joined or left cavities of accepted ones
    std::size_t shortened = 0;    ///< accepted points that went a part of their way to the geometry only
    /// Of degree 2: accepted that the straight test would refuse, refused as `volume` that it would accept, and
    /// accepted whose nodes are not where the metric has them.
    std::size_t straight_inverted = 0, straight_positive = 0, drawn_back = 0;
    std::size_t bent_around = 0;  ///< accepted that take nodes around their cavity along
    std::size_t programmes = 0;   ///< spent on inner edges, accepted or not
    /// Of facets that swaps and collapses made: how far one is from the geometry at most, as a share of its longest
    /// edge.
    double farthest_facet = 0;
    std::size_t moved_nodes = 0;  ///< of inner edges, by distortion; they are no proposals
    std::array<std::size_t, rejection_reasons> rejected{};

    [[nodiscard]] std::size_t of(RejectionReason reason) const { return rejected[static_cast<std::size_t>(reason)]; }
    PassStatistics& operator+=(const PassStatistics& other) {
        rounds += other.rounds;
        proposals += other.proposals;
        planned += other.planned;
        accepted += other.accepted;
        corrections += other.corrections;
        shortened += other.shortened;
        straight_inverted += other.straight_inverted;
        straight_positive += other.straight_positive;
        drawn_back += other.drawn_back;
        bent_around += other.bent_around;
        programmes += other.programmes;
        farthest_facet = std::max(farthest_facet, other.farthest_facet);
        moved_nodes += other.moved_nodes;
        for (std::size_t i = 0; i < rejected.size(); ++i) rejected[i] += other.rejected[i];
        return *this;
    }
    friend bool operator==(const PassStatistics&, const PassStatistics&) = default;
};

}  // namespace camber

export namespace camber {

/// A thing to be done at an entity: the least `order` first. Numbers of entities are taken again, so a task may come to
/// speak of another one: whoever makes a request of it looks whether there is reason for one.
struct Task {
    double order = 0;
    std::uint64_t rank = 0;  ///< where orders are equal
    std::uint32_t id = 0;
    friend bool operator<(const Task& a, const Task& b) {
        return std::tie(a.order, a.rank, a.id) < std::tie(b.order, b.rank, b.id);
    }
};
template <class Tag>
[[nodiscard]] Task task(double order, Id<Tag> id) {
    return {order, spread_rank(id), id.value};
}

/// One pass: how a task becomes a request, and what tasks a commit brings.
template <int D>
class Pass {
  public:
    virtual ~Pass() = default;
    /// Nothing where there is no reason for one. Asked by several threads.
    [[nodiscard]] virtual std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const = 0;
    /// The same request for a point that goes this share of its way to the geometry; nothing where it has no such way.
    [[nodiscard]] virtual std::optional<Candidate<D>> shortened(const Adaptation<D>&, const Task&, double) const {
        return {};
    }
    /// Told of requests that were refused, or for which there was no reason, in the mesh as it is.
    virtual void refused(Adaptation<D>&, std::span<const Task>) const {}
    virtual void follow(Adaptation<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) = 0;

  protected:
    Pass() = default;
    Pass(const Pass&) = default;
    Pass(Pass&&) = default;
    Pass& operator=(const Pass&) = default;
    Pass& operator=(Pass&&) = default;
};

/// Does the tasks, and those that come of them, in rounds: the first are planned together against one mesh; of those
/// patches the first is taken, then each that removes no element and makes no edge of one before; one commit. Threads
/// have no say in it. Errors: of commit; stopped, memory.
template <int D>
[[nodiscard]] Outcome<PassStatistics> run_pass(Adaptation<D>& r, const AdaptationGoal<D>& goal, Pass<D>& pass,
                                               std::vector<Task> tasks, const Execution& execution);

}  // namespace camber
