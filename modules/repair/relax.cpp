module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import :moved_mesh;
import :trial;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.soundness;

namespace camber {

namespace {

/// Turns over all elements that are not valid, and over all moved edges.
constexpr int max_rounds = 20;
constexpr int put_back_rounds = 2;

template <int D>
Outcome<Done> check(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const RepairOptions& options) {
    const std::size_t edges = mesh.edges.size();
    if (proposal.mid_nodes.size() != edges || proposal.kinds.size() != edges || proposal.changes.size() != edges)
        return fail(ErrorKind::internal, "the proposal has another number of edges than the mesh");
    return check_limits(options);
}

/// A piece of work: an element or an edge, and the elements that it reads and writes; none: not known before.
template <class Id>
struct Piece {
    Id id;
    std::optional<std::vector<ElementId>> elements = {};

    [[nodiscard]] Claim claim() const { return elements ? Claim(std::span(*elements)) : Claim(); }
};

/// What a piece came to.
template <int D>
struct Step {
    Moves<D> moves;
    bool moved = false;
    std::vector<EdgeId> corrected;  ///< once more
    std::vector<ElementId> broken;
};

/// Relaxation, piece by piece as if one after the other: what is done to one decides what the next one needs.
template <int D>
struct Relaxing {
    SegmentState<D> state;
    const Execution& execution;
    Schedule schedule{state.moved.mesh.linear.elements.size()};

    [[nodiscard]] Piece<ElementId> with_claim(ElementId e) const {
        std::vector<ElementId> elements;
        for (const EdgeId edge : state.moved.mesh.edges.of_elements[e])
            elements.insert(elements.end(), state.shells[edge].begin(), state.shells[edge].end());
        elements |= ranges::actions::sort | ranges::actions::unique;
        return {e, std::move(elements)};
    }
    /// f(trial, id, step) for each piece, when its turn comes; `finished(step)` in their order.
    template <class Id, class Needless, class F, class Finished>
    Outcome<Done> each_piece(std::vector<Piece<Id>> pieces, Needless&& needless, F&& f, Finished&& finished) {
        const auto round = [&](std::span<const Piece<Id>> now) -> Outcome<bool> {
            const Execution quiet{execution.threads, execution.stop, {}};
            auto steps = map_each(
                quiet, now.size(),
                [&](std::size_t i) {
                    Trial<D> trial{state};
                    Step<D> step;
                    f(trial, now[i].id, step);
                    step.moves = trial.moves();
                    return step;
                },
                1);
            if (!steps) return fail(steps.error());
            for (const Step<D>& step : *steps) {
                state.moved.apply(step.moves);
                finished(step);
            }
            return true;
        };
        const auto claim = [](const Piece<Id>& piece) { return piece.claim(); };
        return in_rounds(schedule, std::move(pieces), execution, needless, claim, round);
    }
    /// The same for the elements of the queue that are not valid; keeps these in the queue. True if any of them moved
    /// something.
    template <class PieceOf, class F>
    Outcome<bool> turn(std::vector<ElementId>& queue, PieceOf&& piece, F&& f) {
        std::vector<Piece<ElementId>> pieces;
        pieces.reserve(queue.size());
        for (const ElementId e : queue) pieces.push_back(piece(e));
        bool any = false;
        auto done = each_piece(
            std::move(pieces), [&](const Piece<ElementId>& p) { return state.moved.is_valid(p.id); },
            [&](Trial<D>& trial, ElementId e, Step<D>& step) { step.moved = f(trial, e); },
            [&](const Step<D>& step) { any = any || step.moved; });
        if (!done) return fail(done.error());
        std::erase_if(queue, [&](ElementId e) { return state.moved.is_valid(e); });
        return any;
    }
};

template <int D>
Outcome<Done> repair_in_turns(Relaxing<D>& relaxing, std::vector<ElementId>& queue, EdgeGroup group, Steps steps) {
    for (int turn = 0; turn < max_rounds && !queue.empty(); ++turn) {
        const auto any = relaxing.turn(
            queue, [&](ElementId e) { return relaxing.with_claim(e); },
            [&](Trial<D>& trial, ElementId e) { return repair_element(trial, e, group, steps); });
        if (!any) return fail(any.error());
        if (!*any) break;
    }
    return Done{};
}

/// The paper's correction (§3.2) over a queue: all volume edges of an element that is not valid by θ, surface edges
/// once its volume edges are straight; what breaks joins the next round. Ends: every edge is straight after
/// max_corrections + 1 steps.
template <int D>
Outcome<Done> relax_by_theta(Relaxing<D>& relaxing, std::vector<ElementId> queue) {
    const RepairOptions& options = relaxing.state.options;
    SparseMap<EdgeId, int> corrections;
    const auto correct = [&](Trial<D>& trial, ElementId e, Step<D>& step) {
        std::vector<EdgeId> loose = loose_edges(trial, e, EdgeGroup::volume);
        if (loose.empty()) loose = loose_edges(trial, e, EdgeGroup::surface);
        if (loose.empty()) return;  // straight, and still not valid
        Changes<D> changes;
        for (const EdgeId edge : loose) {
            const int* before = corrections.find(edge);
            const bool last = (before ? *before : 0) >= options.max_corrections;
            move_node(trial, edge, trial.towards_middle(edge, last ? 0 : options.theta), changes);
        }
        check_shells(trial, loose, changes);
        step.corrected = std::move(loose);
        step.broken = std::move(changes.broken);
        if (!trial.valid(e)) step.broken.push_back(e);
    };
    while (!queue.empty()) {
        std::vector<Piece<ElementId>> pieces;
        pieces.reserve(queue.size());
        for (const ElementId e : queue) pieces.push_back(relaxing.with_claim(e));
        std::vector<ElementId> next;
        auto done = relaxing.each_piece(
            std::move(pieces), [&](const auto& p) { return relaxing.state.moved.is_valid(p.id); }, correct,
            [&](const Step<D>& step) {
                for (const EdgeId edge : step.corrected) ++corrections.at(edge);
                next.insert(next.end(), step.broken.begin(), step.broken.end());
            });
        if (!done) return done;
        next |= ranges::actions::sort | ranges::actions::unique;
        queue = std::move(next);
    }
    return Done{};
}

/// Surface and ridge nodes first: they make the geometry.
template <int D>
Outcome<Done> put_all_back(Relaxing<D>& relaxing) {
    const SegmentState<D>& state = relaxing.state;
    std::vector<EdgeId> moved = state.moved.nodes.set_rows();
    std::ranges::sort(moved, {}, [&](EdgeId e) { return std::pair(state.kinds[e] == EdgeKind::volume, e); });
    std::vector<Piece<EdgeId>> pieces;
    pieces.reserve(moved.size());
    for (const EdgeId e : moved)
        pieces.push_back({e, std::vector<ElementId>(state.shells[e].begin(), state.shells[e].end())});
    for (int round = 0; round < put_back_rounds; ++round) {
        auto done = relaxing.each_piece(
            pieces, [](const auto&) { return false; }, [](Trial<D>& trial, EdgeId e, Step<D>&) { put_back(trial, e); },
            [](const Step<D>&) {});
        if (!done) return done;
    }
    return Done{};
}

template <int D>
Outcome<Done> relax_by_segments(Relaxing<D>& relaxing, std::vector<ElementId> queue) {
    const auto in_turns = [&](EdgeGroup group, Steps steps) { return repair_in_turns(relaxing, queue, group, steps); };
    // What it draws in is not known before.
    const auto with_neighbours = [&](EdgeGroup group, double scaled_jacobian) -> Outcome<Done> {
        return relaxing
            .turn(
                queue, [](ElementId e) { return Piece<ElementId>{e}; },
                [&](Trial<D>& trial, ElementId e) { return repair_with_neighbours(trial, e, group, scaled_jacobian); })
            .map([](bool) { return Done{}; });
    };
    const double bound = relaxing.state.options.min_scaled_jacobian;
    const double target = relaxing.state.options.aim();
    for (const EdgeGroup group : {EdgeGroup::volume, EdgeGroup::surface, EdgeGroup::all}) {
        auto done = in_turns(group, Steps::to_target);
        if (done) done = with_neighbours(group, target);
        if (done) done = in_turns(group, group == EdgeGroup::surface ? Steps::to_bound : Steps::helping);
        if (done) done = with_neighbours(group, bound);
        if (!done) return fail(done.error());
    }
    if (auto done = relax_by_theta(relaxing, queue); !done) return fail(done.error());
    return put_all_back(relaxing);
}

}  // namespace

template <int D>
Outcome<Repaired<D>> relax(const JudgedProposal<D>& wanted, const RepairOptions& options, const Execution& execution) {
    const Proposal<D>& proposal = wanted.proposal();
    if (auto checked = check(wanted.mesh(), proposal, options); !checked) return fail(checked.error());
    if (wanted.validation().bound != options.min_scaled_jacobian.value) {
        const auto again = validate(wanted.mesh(), proposal, options.min_scaled_jacobian, without_progress(execution));
        if (!again) return fail(again.error());
        return relax(*again, options, execution);
    }
    if (wanted.validation().all_valid()) return Repaired<D>{wanted};
    return guarded([&]() -> Outcome<Repaired<D>> {
        const Execution quiet = without_progress(execution);
        const auto around = shells(wanted.mesh().edges, quiet);
        if (!around) return fail(around.error());
        Relaxing<D> relaxing{{MovedMesh<D>(wanted), *around, proposal.kinds, options}, execution};
        auto queue = elements_not_valid(wanted.validation());
        auto done = options.method == RepairMethod::theta ? relax_by_theta(relaxing, std::move(queue))
                                                          : relax_by_segments(relaxing, std::move(queue));
        if (!done) return fail(done.error());
        auto judged = judge_moved(relaxing.state.moved, *around, wanted, quiet);
        if (!judged) return fail(judged.error());
        const RepairStatistics statistics = changes_between(wanted, *judged);
        return Repaired<D>{std::move(*judged), statistics};
    });
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Repaired<D>> relax<D>(const JudgedProposal<D>&, const RepairOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
