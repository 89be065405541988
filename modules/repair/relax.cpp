module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>
#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.repair;
import camber.core;
import camber.bezier;
import camber.validity;
import camber.soundness;

namespace camber {

template <int D>
LagrangeNode<D> Trial<D>::towards_middle(EdgeId edge, double theta) const {
    const LagrangeNode<D> m = middle(edge);
    if (!(theta > 0)) return m;
    return {m.point + theta * (node(edge).point - m.point)};
}

template <int D>
double Trial<D>::length(EdgeId edge) const {
    const auto& [a, b] = mesh().edges.vertices[edge];
    return distance(state.moved.points[a], state.moved.points[b]);
}

template <int D>
Moves<D> Trial<D>::moves() const {
    Moves<D> moves;
    for (const EdgeId edge : nodes.keys()) moves.nodes.emplace_back(edge, *nodes.find(edge));
    for (const ElementId e : verdicts.keys()) moves.verdicts.emplace_back(e, *verdicts.find(e));
    return moves;
}

bool contains(EdgeGroup group, EdgeKind kind) {
    if (kind == EdgeKind::fixed) return false;
    return group == EdgeGroup::all || (group == EdgeGroup::volume) == (kind == EdgeKind::volume);
}

template <int D>
std::vector<EdgeId> movable_edges(const Trial<D>& trial, ElementId e, EdgeGroup group) {
    std::vector<EdgeId> movable;
    for (const EdgeId edge : trial.mesh().edges.of_elements[e])
        if (contains(group, trial.state.kinds[edge]) && !trial.straight(edge)) movable.push_back(edge);
    return movable;
}

template <int D>
void move_node(Trial<D>& trial, EdgeId edge, const LagrangeNode<D>& node, Changes<D>& changes) {
    changes.nodes.emplace_back(edge, trial.node(edge));
    trial.nodes.at(edge) = node;
}

template <int D>
void check_shells(Trial<D>& trial, std::span<const EdgeId> edges, Changes<D>& changes) {
    std::vector<ElementId> around;
    for (const EdgeId edge : edges)
        around.insert(around.end(), trial.state.shells[edge].begin(), trial.state.shells[edge].end());
    around |= ranges::actions::sort | ranges::actions::unique;
    for (const ElementId e : around) {
        const Verdict verdict = trial.verdict(e);
        const Verdict now = decide(trial.element(e), trial.state.options.min_scaled_jacobian);
        if (now == verdict) continue;
        changes.verdicts.emplace_back(e, verdict);
        if (verdict == Verdict::valid) changes.broken.push_back(e);
        trial.verdicts.at(e) = now;
    }
}

template <int D>
void undo(Trial<D>& trial, const Changes<D>& changes) {
    for (auto it = changes.nodes.rbegin(); it != changes.nodes.rend(); ++it) trial.nodes.at(it->first) = it->second;
    for (auto it = changes.verdicts.rbegin(); it != changes.verdicts.rend(); ++it)
        trial.verdicts.at(it->first) = it->second;
}

template <int D>
BoundedJacobian<D> jacobian_with(const Trial<D>& trial, ElementId e, EdgeId edge, const LagrangeNode<D>& node) {
    const auto& edges = trial.mesh().edges.of_elements[e];
    NodalSimplex<D> element = trial.element(e);
    for (int i = 0; i < edges_per_simplex<D>; ++i)
        if (edges[i] == edge) element.nodes[D + 1 + i] = node.point;
    return bounded_jacobian(element);
}

/// Maximum number of elements that `repair_with_neighbours` relaxes, repeats included.
constexpr std::size_t max_relaxed_elements = 200;

template <int D>
bool repair_with_neighbours(Trial<D>& trial, ElementId e, EdgeGroup group, double scaled_jacobian) {
    Changes<D> changes;
    std::map<EdgeId, int> corrections;
    std::vector<ElementId> queue{e};
    const auto reaches = [&](ElementId element) {
        return trial.valid(element) && decide(trial.element(element), scaled_jacobian) == Verdict::valid;
    };
    for (std::size_t next = 0; next < queue.size(); ++next) {
        const ElementId element = queue[next];
        if (reaches(element)) continue;
        const std::vector<EdgeId> movable = movable_edges(trial, element, group);
        if (movable.empty() || next >= max_relaxed_elements) {
            undo(trial, changes);
            return false;
        }
        for (const EdgeId edge : movable) {
            const bool last = ++corrections[edge] > trial.state.options.max_corrections;
            move_node(trial, edge, trial.towards_middle(edge, last ? 0 : trial.state.options.theta), changes);
        }
        changes.broken.clear();
        check_shells(trial, movable, changes);
        queue.insert(queue.end(), changes.broken.begin(), changes.broken.end());
        if (!reaches(element)) queue.push_back(element);
    }
    return true;
}

namespace {

constexpr int max_rounds = 20;
constexpr int put_back_sweeps = 2;

template <int D>
Outcome<Done> check(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const RepairOptions& options) {
    const std::size_t edges = mesh.edges.size();
    if (proposal.mid_nodes.size() != edges || proposal.kinds.size() != edges || proposal.changes.size() != edges)
        return fail(ErrorKind::internal, "the number of edges of the proposal differs from that of the mesh");
    return check_limits(options);
}

template <class Id>
struct Piece {
    Id id;
    std::optional<std::vector<ElementId>> elements = {};

    [[nodiscard]] Claim claim() const { return elements ? Claim(std::span(*elements)) : Claim(); }
};

template <int D>
struct Step {
    Moves<D> moves;
    bool moved = false;
    std::vector<EdgeId> corrected;
    std::vector<ElementId> broken;
};

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
        return run_in_rounds(schedule, std::move(pieces), execution, needless, claim, round);
    }
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
Outcome<Done> repair_in_sweeps(Relaxing<D>& relaxing, std::vector<ElementId>& queue, EdgeGroup group, Steps steps) {
    for (int turn = 0; turn < max_rounds && !queue.empty(); ++turn) {
        const auto any = relaxing.turn(
            queue, [&](ElementId e) { return relaxing.with_claim(e); },
            [&](Trial<D>& trial, ElementId e) { return repair_element(trial, e, group, steps); });
        if (!any) return fail(any.error());
        if (!*any) break;
    }
    return Done{};
}

/// Correction of the paper (§3.2). The loop ends, because every edge is straight after max_corrections + 1 steps.
template <int D>
Outcome<Done> relax_by_theta(Relaxing<D>& relaxing, std::vector<ElementId> queue) {
    const RepairOptions& options = relaxing.state.options;
    SparseMap<EdgeId, int> corrections;
    const auto correct = [&](Trial<D>& trial, ElementId e, Step<D>& step) {
        std::vector<EdgeId> movable = movable_edges(trial, e, EdgeGroup::volume);
        if (movable.empty()) movable = movable_edges(trial, e, EdgeGroup::surface);
        if (movable.empty()) return;  // the element is straight but still invalid
        Changes<D> changes;
        for (const EdgeId edge : movable) {
            const int* before = corrections.find(edge);
            const bool last = (before ? *before : 0) >= options.max_corrections;
            move_node(trial, edge, trial.towards_middle(edge, last ? 0 : options.theta), changes);
        }
        check_shells(trial, movable, changes);
        step.corrected = std::move(movable);
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

/// Moves nodes towards their initial positions as far as the elements around them allow; surface and ridge nodes first,
/// because they define the geometry.
template <int D>
Outcome<Done> restore_all(Relaxing<D>& relaxing, std::vector<EdgeId> moved) {
    const SegmentState<D>& state = relaxing.state;
    std::ranges::sort(moved, {}, [&](EdgeId e) { return std::pair(state.kinds[e] == EdgeKind::volume, e); });
    std::vector<Piece<EdgeId>> pieces;
    pieces.reserve(moved.size());
    for (const EdgeId e : moved)
        pieces.push_back({e, std::vector<ElementId>(state.shells[e].begin(), state.shells[e].end())});
    for (int round = 0; round < put_back_sweeps; ++round) {
        auto done = relaxing.each_piece(
            pieces, [](const auto&) { return false; }, [](Trial<D>& trial, EdgeId e, Step<D>&) { put_back(trial, e); },
            [](const Step<D>&) {});
        if (!done) return done;
    }
    return Done{};
}

template <int D>
Outcome<Done> relax_by_segments(Relaxing<D>& relaxing, std::vector<ElementId> queue) {
    const auto in_turns = [&](EdgeGroup group, Steps steps) { return repair_in_sweeps(relaxing, queue, group, steps); };
    // The set of affected elements is not known in advance.
    const auto with_neighbours = [&](EdgeGroup group, double scaled_jacobian) -> Outcome<Done> {
        return relaxing
            .turn(
                queue, [](ElementId e) { return Piece<ElementId>{e}; },
                [&](Trial<D>& trial, ElementId e) { return repair_with_neighbours(trial, e, group, scaled_jacobian); })
            .map([](bool) { return Done{}; });
    };
    const double bound = relaxing.state.options.min_scaled_jacobian;
    const double target = relaxing.state.options.effective_target();
    for (const EdgeGroup group : {EdgeGroup::volume, EdgeGroup::surface, EdgeGroup::all}) {
        auto done = in_turns(group, Steps::to_target);
        if (done) done = with_neighbours(group, target);
        if (done) done = in_turns(group, group == EdgeGroup::surface ? Steps::to_bound : Steps::helping);
        if (done) done = with_neighbours(group, bound);
        if (!done) return fail(done.error());
    }
    if (auto done = relax_by_theta(relaxing, queue); !done) return fail(done.error());
    return restore_all(relaxing, relaxing.state.moved.nodes.set_rows());
}

/// Number of steps of a node; all but the last cover half of the remaining distance.
constexpr int restoring_steps = 4;

template <int D>
struct Restoring {
    MovedMesh<D> moved;
    const Incidence<ElementId>& shells;
    const Column<EdgeKind>& kinds;
    double bound = 0;
    Incidence<ElementId> balls = {};
    SparseMap<EdgeId, int> steps = {};

    [[nodiscard]] const QuadraticMesh<D>& mesh() const { return moved.mesh; }
    [[nodiscard]] NodalSimplex<D> input_element(ElementId e) const {
        return nodal_element<D>(mesh(), mesh().mid_nodes.view(), e);
    }
    [[nodiscard]] LagrangeNode<D> input_node(EdgeId edge) const {
        return {mesh().mid_nodes[edge].point + moved.shift(edge)};
    }
    [[nodiscard]] std::optional<LagrangeNode<D>> next_place(EdgeId edge) {
        const LagrangeNode<D> there = input_node(edge);
        const LagrangeNode<D>& now = moved.nodes[edge];
        if (now == there) return std::nullopt;
        const bool is_last = ++steps.at(edge) >= restoring_steps;
        return is_last ? there : LagrangeNode<D>{midpoint(now.point, there.point)};
    }

    struct Wave {
        std::vector<EdgeId> edges;
        std::vector<VertexId> vertices;
    };
    [[nodiscard]] Wave next_wave(const std::vector<ElementId>& elements) const {
        Wave wave;
        for (const ElementId e : elements) {
            const auto& edges = mesh().edges.of_elements[e];
            const auto add = [&](EdgeGroup group) {
                bool any = false;
                for (const EdgeId edge : edges) {
                    if (!contains(group, kinds[edge]) || moved.nodes[edge] == input_node(edge)) continue;
                    wave.edges.push_back(edge);
                    any = true;
                }
                return any;
            };
            if (add(EdgeGroup::volume) || add(EdgeGroup::surface)) continue;
            for (const VertexId v : mesh().linear.elements.vertices[e])
                if (moved.points[v] != mesh().linear.points[v]) wave.vertices.push_back(v);
        }
        wave.edges |= ranges::actions::sort | ranges::actions::unique;
        wave.vertices |= ranges::actions::sort | ranges::actions::unique;
        return wave;
    }

    void restore_vertices(const std::vector<VertexId>& vertices, std::vector<ElementId>& touched) {
        std::vector<EdgeId> edges;
        for (const VertexId v : vertices)
            for (const ElementId e : balls[v]) {
                touched.push_back(e);
                edges.insert(edges.end(), mesh().edges.of_elements[e].begin(), mesh().edges.of_elements[e].end());
            }
        edges |= ranges::actions::sort | ranges::actions::unique;
        std::vector<Vec<D>> offsets;
        offsets.reserve(edges.size());
        for (const EdgeId edge : edges) offsets.push_back(moved.nodes[edge].point - input_node(edge).point);
        for (const VertexId v : vertices) moved.points.set(v, mesh().linear.points[v]);
        for (std::size_t i = 0; i < edges.size(); ++i)
            moved.nodes.set(edges[i], {input_node(edges[i]).point + offsets[i]});
    }

    Outcome<Done> run(std::vector<ElementId> queue, const Execution& execution) {
        while (!queue.empty()) {
            const Wave wave = next_wave(queue);
            std::vector<ElementId> touched;
            if (!wave.vertices.empty()) {
                if (balls.size() == 0) {
                    auto result = camber::balls(mesh().linear, execution);
                    if (!result) return fail(result.error());
                    balls = std::move(*result);
                }
                restore_vertices(wave.vertices, touched);
            }
            for (const EdgeId edge : wave.edges)
                if (const auto place = next_place(edge)) {
                    moved.nodes.set(edge, *place);
                    touched.insert(touched.end(), shells[edge].begin(), shells[edge].end());
                }
            touched |= ranges::actions::sort | ranges::actions::unique;
            const auto verdicts = map_each(execution, touched.size(),
                                           [&](std::size_t i) { return decide(moved.element(touched[i]), bound); });
            if (!verdicts) return fail(verdicts.error());
            queue.clear();
            for (std::size_t i = 0; i < touched.size(); ++i) {
                moved.verdicts.set(touched[i], (*verdicts)[i]);
                if ((*verdicts)[i] != Verdict::valid) queue.push_back(touched[i]);
            }
        }
        return Done{};
    }

    [[nodiscard]] std::size_t not_valid() const {
        std::size_t count = 0;
        for (std::size_t e = 0; e < moved.verdicts.size(); ++e) count += !moved.is_valid(ElementId(e));
        return count;
    }
};

template <int D>
std::vector<EdgeId> restored_edges(const MovedMesh<D>& moved, const Proposal<D>& before, const Proposal<D>& input) {
    std::vector<EdgeId> edges = moved.nodes.set_rows();
    std::erase_if(edges, [&](EdgeId e) {
        const auto& [a, b] = moved.mesh.edges.vertices[e];
        return moved.nodes[e] == before.mid_nodes[e] || moved.points[a] != input.points[a] ||
               moved.points[b] != input.points[b];
    });
    return edges;
}

template <int D>
bool is_straight(const QuadraticMesh<D>& mesh) {
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        if (mesh.mid_nodes[e].point != midpoint(mesh.linear.points[a], mesh.linear.points[b])) return false;
    }
    return true;
}

}  // namespace

template <int D>
Outcome<Repaired<D>> restore_input(const JudgedProposal<D>& input, Repaired<D> repaired, const RepairOptions& options,
                                   const Execution& execution) {
    const QuadraticMesh<D>& mesh = input.mesh();
    const Validation<D>& after = repaired.judged.validation();
    const double judged_for = after.bound;
    const JacobianBound& bound = options.min_scaled_jacobian;
    const bool is_done = bound.is_explicit && bound > min_bound ? after.all_valid() : after.certified();
    if (is_done || is_standalone_surface(mesh.linear) || is_straight(mesh)) return repaired;
    return guarded([&]() -> Outcome<Repaired<D>> {
        const Execution quiet = without_progress(execution);
        RepairOptions to = options;
        // A recommended bound does not justify moving nodes off their target positions.
        if (!bound.is_explicit) to.min_scaled_jacobian = min_bound;
        const auto before = validate(mesh, repaired.judged.proposal(), to.min_scaled_jacobian, quiet);
        if (!before) return fail(before.error());
        const auto around = shells(mesh.edges, quiet);
        if (!around) return fail(around.error());
        const Column<EdgeKind>& kinds = input.proposal().kinds;
        Restoring<D> restoring{MovedMesh<D>(*before), *around, kinds, to.min_scaled_jacobian};
        auto queue = elements_not_valid(before->validation());
        std::erase_if(queue, [&](ElementId e) {
            return decide(restoring.input_element(e), to.min_scaled_jacobian) != Verdict::valid;
        });
        if (queue.empty()) return repaired;
        if (auto done = restoring.run(std::move(queue), quiet); !done) return fail(done.error());
        if (restoring.not_valid() >= before->validation().not_valid()) return repaired;
        const auto edges = restored_edges(restoring.moved, before->proposal(), input.proposal());
        Relaxing<D> relaxing{{std::move(restoring.moved), *around, kinds, to}, quiet};
        // `restore_all` moves nodes towards the base of the overlay, which must be the target positions and not the
        // repaired ones.
        auto& nodes = relaxing.state.moved.nodes;
        const Column<LagrangeNode<D>> restored = nodes.column();
        nodes = Overlay<EdgeId, LagrangeNode<D>>(input.proposal().mid_nodes);
        for (std::size_t e = 0; e < restored.size(); ++e)
            if (restored[e] != nodes.base()[e]) nodes.set(EdgeId(e), restored[e]);
        if (auto done = restore_all(relaxing, edges); !done) return fail(done.error());
        auto judged = validate(mesh, relaxing.state.moved.proposal(input.proposal()), judged_for, quiet);
        if (!judged) return fail(judged.error());
        repaired.judged = std::move(*judged);
        const auto& verdicts = repaired.judged.validation().verdicts;
        std::erase_if(repaired.unresolved, [&](ElementId e) { return verdicts[e] == Verdict::valid; });
        return with_all_changes(input, std::move(repaired));
    });
}

template <int D>
Outcome<Repaired<D>> relax(const JudgedProposal<D>& input, const RepairOptions& options, const Execution& execution) {
    const Proposal<D>& proposal = input.proposal();
    if (auto checked = check(input.mesh(), proposal, options); !checked) return fail(checked.error());
    if (input.validation().bound != options.min_scaled_jacobian.value) {
        const auto again = validate(input.mesh(), proposal, options.min_scaled_jacobian, without_progress(execution));
        if (!again) return fail(again.error());
        return relax(*again, options, execution);
    }
    if (input.validation().all_valid()) return Repaired<D>{input};
    return guarded([&]() -> Outcome<Repaired<D>> {
        const Execution quiet = without_progress(execution);
        const auto around = shells(input.mesh().edges, quiet);
        if (!around) return fail(around.error());
        Relaxing<D> relaxing{{MovedMesh<D>(input), *around, proposal.kinds, options}, execution};
        auto queue = elements_not_valid(input.validation());
        auto done = options.method == RepairMethod::backtracking ? relax_by_theta(relaxing, std::move(queue))
                                                                 : relax_by_segments(relaxing, std::move(queue));
        if (!done) return fail(done.error());
        auto judged = judge_moved(relaxing.state.moved, *around, input, quiet);
        if (!judged) return fail(judged.error());
        const RepairStatistics statistics = changes_between(input, *judged);
        return restore_input(input, Repaired<D>{std::move(*judged), statistics}, options, quiet);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template struct Trial<D>;                                                                                   \
    template std::vector<EdgeId> movable_edges<D>(const Trial<D>&, ElementId, EdgeGroup);                       \
    template void move_node<D>(Trial<D>&, EdgeId, const LagrangeNode<D>&, Changes<D>&);                         \
    template void check_shells<D>(Trial<D>&, std::span<const EdgeId>, Changes<D>&);                             \
    template void undo<D>(Trial<D>&, const Changes<D>&);                                                        \
    template BoundedJacobian<D> jacobian_with<D>(const Trial<D>&, ElementId, EdgeId, const LagrangeNode<D>&);   \
    template bool repair_with_neighbours<D>(Trial<D>&, ElementId, EdgeGroup, double);                           \
    template Outcome<Repaired<D>> relax<D>(const JudgedProposal<D>&, const RepairOptions&, const Execution&);   \
    template Outcome<Repaired<D>> restore_input<D>(const JudgedProposal<D>&, Repaired<D>, const RepairOptions&, \
                                                   const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
