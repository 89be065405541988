// Repair by the methods `extension`, `cavity` and `edge`, and the choice of the method.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <numeric>
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
import camber.optimisation;
import camber.curving;

namespace camber {

namespace {

/// Number of plans computed at once. Each may use an equal share of the remaining work.
constexpr std::size_t plans_at_once = 32;

// Type-erased so that `plan_in_rounds` is compiled once per item type and not once per pass.
template <class Item>
using ClaimOf = std::function<std::vector<ElementId>(Item)>;
template <int D, class Item>
using PlanOf = std::function<Planned<D>(Item, double max_work)>;

template <int D, class Item>
struct ItemPlanning {
    std::function<bool(Item)> is_needless;
    const ClaimOf<Item>& claim;  ///< elements that the plan reads
    const PlanOf<D, Item>& plan;
    std::function<void(Item, const Planned<D>&)> finished;
};

/// Computes and applies a plan for each item, in ascending order, until the work limit is reached. Items that read
/// different elements are planned in parallel (`run_in_rounds`). Progress counts processed items.
template <int D, class Item>
Outcome<Done> plan_in_rounds(RepairState<D>& state, std::vector<Item> items, const ItemPlanning<D, Item>& planning,
                             const Execution& execution) {
    const auto& [is_needless, claim, plan, finished] = planning;
    if (items.empty() || state.exhausted()) return Done{};
    const Execution quiet = without_progress(execution);
    std::ranges::sort(items);
    const auto claims = map_each(quiet, items.size(), [&](std::size_t i) { return claim(items[i]); }, 16);
    if (!claims) return fail(claims.error());
    std::vector<std::size_t> places(items.size());
    std::iota(places.begin(), places.end(), std::size_t{0});
    const auto round = [&](std::span<const std::size_t> now) -> Outcome<bool> {
        for (; !now.empty() && !state.exhausted(); now = now.subspan(std::min(plans_at_once, now.size()))) {
            const std::size_t n = std::min(plans_at_once, now.size());
            const double share = state.work_left / static_cast<double>(n);
            const auto plans = map_each(quiet, n, [&](std::size_t i) { return plan(items[now[i]], share); }, 1);
            if (!plans) return fail(plans.error());
            for (std::size_t i = 0; i < n; ++i) {
                const Planned<D>& planned = (*plans)[i];
                if (planned.plan) state.moved.apply(*planned.plan);
                state.work_left -= planned.work;
                state.work += planned.work;
                finished(items[now[i]], planned);
            }
        }
        return !state.exhausted();
    };
    return run_in_rounds(
        state.schedule, std::move(places), execution, [&](std::size_t i) { return is_needless(items[i]); },
        [&](std::size_t i) { return Claim(std::span((*claims)[i])); }, round);
}

constexpr int max_segment_sweeps = 2;
constexpr int max_edge_sweeps = 4;
constexpr int max_joint_sweeps = 12;
constexpr double max_of_work = 0.5;
constexpr double max_passes = 14;
/// Edges with a higher cost, as a share of the edge length, are moved jointly towards their targets.
constexpr double costly = 1e-3;
/// Scaled Jacobians that slides require in turn, as shares of the target. All are positive, because projection reduces
/// the value.
constexpr std::array slide_shares{1.0, 0.1, 0.001};
constexpr int nearest_rings = 2;
constexpr int farthest_rings = 8;

template <int D>
struct Passes {
    RepairState<D> state;
    std::vector<ElementId> queue;
    Execution execution;
    std::vector<ElementId> initial_queue = queue;
    std::size_t started_passes = 0;
    bool cut_short = false;  ///< a pass reached its work limit before the queue was empty

    [[nodiscard]] Outcome<Done> by_edges() {
        return over_queue([&](ElementId e) { return repair_cavity(state, e, CavityExtent{}).elements; },
                          [&](ElementId e, double) { return plan_edge_repair(state, e); });
    }
    [[nodiscard]] Outcome<Done> by_cavities(CavityExtent extent, double requested) {
        return over_queue([&](ElementId e) { return repair_cavity(state, e, extent).elements; },
                          [&](ElementId e, double max_work) {
                              return plan_cavity_repair(state, repair_cavity(state, e, extent), e, requested, max_work);
                          });
    }
    [[nodiscard]] Outcome<Done> by_slides(CavityExtent extent, double requested) {
        return over_queue([&](ElementId e) { return repair_cavity(state, e, extent).elements; },
                          [&](ElementId e, double max_work) {
                              return plan_slide_repair(state, repair_cavity(state, e, extent), e, requested, max_work);
                          });
    }
    /// Moves the nodes of queued elements to the extension positions. Elements that degrade are repaired; otherwise
    /// their nodes do not move.
    [[nodiscard]] Outcome<Done> by_restored_nodes(const RestoredPosition<D>& extended_nodes) {
        const Execution quiet = without_progress(execution);
        Passes trial{state, {}, quiet};
        if (auto done = restore_nodes(trial.state, queue, extended_nodes, quiet); !done) return done;
        bool any_degraded = false;
        for (const ElementId e : trial.state.moved.verdicts.set_rows()) {
            if (trial.state.good(e)) continue;
            trial.queue.push_back(e);
            any_degraded = any_degraded || is_degraded(state, e, trial.state.element(e), trial.state.moved.verdicts[e]);
        }
        if (!any_degraded) {
            state.moved.apply(trial.state.moved.moves());
            return finish(Done{});
        }
        auto done = trial.by_cavities({CavityExtent::Moves::volume_nodes, 0}, state.options.target);
        if (done) done = trial.by_edges();
        if (!done) return done;
        state.work_left = trial.state.work_left;
        state.work = trial.state.work;
        cut_short = cut_short || trial.cut_short;
        const auto plan = plan_towards(state, trial.state.moved.nodes);
        const auto repaired = [&](const auto& v) { return v.second == Verdict::valid && !state.good(v.first); };
        if (std::ranges::any_of(plan.verdicts, repaired)) state.moved.apply(plan);
        return finish(Done{});
    }
    [[nodiscard]] Outcome<Done> by_global_extension(const Column<LagrangeNode<D>>& extended_nodes) {
        // The extension was computed for the original vertices, some of which may have moved.
        return by_restored_nodes([&](EdgeId edge) {
            return std::optional(LagrangeNode<D>{extended_nodes[edge].point + state.moved.shift(edge)});
        });
    }
    [[nodiscard]] Outcome<Done> by_extension(int rings) {
        if (state.exhausted()) return Done{};
        const auto extended_nodes =
            extend_around(state.moved, state.kinds, state.shells, queue, rings, without_progress(execution));
        if (!extended_nodes) return fail(extended_nodes.error());
        state.work_left -= extended_nodes->work;
        state.work += extended_nodes->work;
        return by_restored_nodes([&](EdgeId edge) {
            const LagrangeNode<D>* there = extended_nodes->nodes.find(edge);
            return there ? std::optional(*there) : std::nullopt;
        });
    }
    [[nodiscard]] Outcome<Done> returns_on_segments() {
        return returning(edges_off_target(), max_segment_sweeps,
                         [&](EdgeId e, double) { return plan_return_on_segment(state, e); });
    }
    [[nodiscard]] Outcome<Done> returns() {
        return returning(edges_off_target(), max_edge_sweeps, [&](EdgeId e, double) { return plan_return(state, e); });
    }
    [[nodiscard]] Outcome<Done> returns_of_costliest(double max_work) {
        const double reserved = std::max(0.0, state.work_left - max_work);
        state.work_left -= reserved;
        std::vector<EdgeId> all = edges_off_target();
        // `work_left` may be negative, because earlier passes may have exceeded their limit.
        const double most = std::clamp(state.work_left / edge_work, 0.0, static_cast<double>(all.size()));
        auto edges = costliest(std::move(all), static_cast<std::size_t>(most));
        if (!edges) return fail(edges.error());
        auto done =
            returning(std::move(*edges), max_edge_sweeps, [&](EdgeId e, double) { return plan_return(state, e); });
        state.work_left += reserved;
        return done;
    }
    [[nodiscard]] Outcome<Done> joint_returns() {
        std::vector<ElementId> elements;
        for (const EdgeId edge : affected_edges())
            if (is_costly(edge)) elements.insert(elements.end(), state.shells[edge].begin(), state.shells[edge].end());
        elements |= ranges::actions::sort | ranges::actions::unique;
        const auto claim = [&](ElementId e) { return repair_cavity(state, e, CavityExtent{}).elements; };
        return while_moving<ElementId>(std::move(elements), max_joint_sweeps, claim, [&](ElementId e, double max_work) {
            return plan_joint_return(state, repair_cavity(state, e, CavityExtent{}), max_work);
        });
    }

  private:
    [[nodiscard]] std::vector<EdgeId> affected_edges() const {
        std::vector<EdgeId> edges = state.moved.nodes.set_rows();
        for (const ElementId e : initial_queue)
            edges.insert(edges.end(), state.mesh().edges.of_elements[e].begin(),
                         state.mesh().edges.of_elements[e].end());
        std::erase_if(edges, [&](EdgeId e) { return state.kinds[e] != EdgeKind::volume; });
        edges |= ranges::actions::sort | ranges::actions::unique;
        return edges;
    }
    [[nodiscard]] std::vector<EdgeId> edges_off_target() const {
        std::vector<EdgeId> edges = affected_edges();
        std::erase_if(edges, [&](EdgeId e) { return state.moved.nodes[e].point == state.target_position(e); });
        return edges;
    }
    [[nodiscard]] Outcome<std::vector<EdgeId>> costliest(std::vector<EdgeId> edges, std::size_t most) const {
        if (edges.size() <= most) return edges;
        const auto costs = map_each(without_progress(execution), edges.size(), [&](std::size_t i) {
            const EdgeId e = edges[i];
            const auto model = implied_edge_model(state.mesh(), e, {state.target_position(e)}, state.shells[e]);
            return std::pair(-model(state.moved.nodes[e].point), e);
        });
        if (!costs) return fail(costs.error());
        std::vector<std::pair<double, EdgeId>> ranked(costs->begin(), costs->end());
        std::ranges::nth_element(ranked, ranked.begin() + static_cast<std::ptrdiff_t>(most));
        for (std::size_t i = 0; i < most; ++i) edges[i] = ranked[i].second;
        edges.resize(most);
        return edges;
    }
    Outcome<Done> returning(std::vector<EdgeId> edges, int max_sweeps, const PlanOf<D, EdgeId>& plan) {
        const auto claim = [&](EdgeId e) {
            return std::vector<ElementId>(state.shells[e].begin(), state.shells[e].end());
        };
        return while_moving<EdgeId>(std::move(edges), max_sweeps, claim, plan);
    }
    [[nodiscard]] bool is_costly(EdgeId edge) const {
        return state.model(edge)(state.moved.nodes[edge].point) > costly;
    }
    Outcome<Done> finish(Outcome<Done> done) {
        std::erase_if(queue, [&](ElementId e) { return state.good(e); });
        return done;
    }
    [[nodiscard]] Execution next_pass(std::size_t turn = 0, std::size_t turns = 1) {
        if (turn == 0) ++started_passes;
        const auto share = [turns = static_cast<double>(turns), before = static_cast<double>(started_passes - 1)](
                               double done) { return (before + done / turns) / max_passes; };
        return part_of(execution, share(static_cast<double>(turn)), share(static_cast<double>(turn + 1)));
    }
    Outcome<Done> over_queue(const ClaimOf<ElementId>& claim, const PlanOf<D, ElementId>& plan) {
        // Part of the remaining work is reserved for later passes.
        const double reserved = state.work_left * (1 - max_of_work);
        state.work_left -= reserved;
        const ItemPlanning<D, ElementId> planning{[&](ElementId e) { return state.good(e); }, claim, plan,
                                                  [](ElementId, const Planned<D>&) {}};
        auto done = finish(plan_in_rounds(state, queue, planning, next_pass()));
        cut_short = cut_short || (state.exhausted() && !queue.empty());
        state.work_left += reserved;
        return done;
    }
    /// Later sweeps contain only items near those that moved before.
    template <class Item>
    Outcome<Done> while_moving(std::vector<Item> items, int max_sweeps, const ClaimOf<Item>& claim,
                               const PlanOf<D, Item>& plan) {
        for (int turn = 0; turn < max_sweeps && !items.empty(); ++turn) {
            SparseSet<ElementId> near;
            const auto mark = [&](const Item& item, const Planned<D>& planned) {
                if (!planned.plan) return;
                for (const ElementId e : claim(item)) near.insert(e);
            };
            const Execution share = next_pass(static_cast<std::size_t>(turn), static_cast<std::size_t>(max_sweeps));
            const ItemPlanning<D, Item> planning{[](const Item&) { return false; }, claim, plan, mark};
            auto done = plan_in_rounds(state, items, planning, share);
            if (!done) return done;
            std::erase_if(items, [&](const Item& item) {
                return std::ranges::none_of(claim(item), [&](ElementId e) { return near.contains(e); });
            });
        }
        return Done{};
    }
};

template <int D>
Outcome<Done> prepare_vertex_moves(RepairState<D>& state, const Execution& execution) {
    auto around = balls(state.mesh().linear, without_progress(execution));
    if (!around) return fail(around.error());
    const VertexFreedom of_boundary = state.vertices_onto ? VertexFreedom::sliding : VertexFreedom::fixed;
    state.around_vertices = {std::move(*around),
                             vertex_freedoms(state.mesh(), state.kinds, state.options.vertices, of_boundary)};
    return Done{};
}

template <int D>
Outcome<Done> run(Passes<D>& passes, const RepairGuide<D>& guide, RepairStatistics& s) {
    using Moves = CavityExtent::Moves;
    const RepairOptions& options = passes.state.options;
    const bool restores_first = options.method == RepairMethod::extension;
    const bool with_cavities = has_cavities(options.method);
    // Large cavities and moves of vertices or surface nodes are used only for an explicit bound, not for a recommended
    // one.
    const bool is_explicit = options.min_scaled_jacobian.is_explicit;
    Outcome<Done> done = Done{};
    const auto counted = [&](std::size_t& counter, auto&& pass) {
        if (!done || passes.queue.empty()) return;
        const std::size_t before = passes.queue.size();
        done = pass();
        counter += before - passes.queue.size();
    };
    const auto cavities = [&](std::size_t& counter, CavityExtent extent, double requested) {
        if (with_cavities) counted(counter, [&] { return passes.by_cavities(extent, requested); });
    };
    const auto extension = [&](int rings) {
        if (with_cavities) counted(s.by_extension, [&] { return passes.by_extension(rings); });
    };
    const auto by_volume_nodes = [&] {
        if (restores_first) extension(nearest_rings);
        cavities(s.by_cavities, {Moves::volume_nodes, 0}, options.target);
        counted(s.by_edges, [&] { return passes.by_edges(); });
        for (int rings = nearest_rings; rings <= farthest_rings; rings *= 2) extension(rings);
        if (!is_explicit) return;
        cavities(s.by_cavities, {Moves::volume_nodes, 1}, options.target);
        cavities(s.by_cavities, {Moves::volume_nodes, 1}, 0);
        cavities(s.by_cavities, {Moves::volume_nodes, 2}, 0);
    };
    if (restores_first && !guide.global_extension.empty())
        counted(s.by_extension, [&] { return passes.by_global_extension(guide.global_extension); });
    by_volume_nodes();
    if (with_cavities && is_explicit && !passes.queue.empty())
        if (auto result = prepare_vertex_moves(passes.state, passes.execution); !result) return result;
    if (is_explicit) cavities(s.by_vertices, {Moves::vertices, 1}, 0);
    if (s.by_vertices > 0) by_volume_nodes();
    if (is_explicit && with_cavities && passes.state.onto)
        for (const double share : slide_shares)
            counted(s.by_slides, [&] { return passes.by_slides({Moves::surface_nodes, 0}, share * options.target); });
    if (is_explicit && with_cavities && passes.state.vertices_onto)
        for (const int closures : {0, 1, 2})
            counted(s.by_slides, [&] { return passes.by_slides({Moves::slides, closures}, 0); });
    if (is_explicit && guide.surface == SurfaceMoves::off_geometry)
        cavities(s.by_surface, {Moves::surface_nodes, 1}, 0);
    if (!done) return done;
    if (restores_first) {
        done = passes.returns_on_segments();
        if (done) done = passes.returns_of_costliest(allowed_return_work(passes.initial_queue.size(), options));
        return done;
    }
    done = passes.returns();
    if (done && with_cavities) done = passes.joint_returns();
    return done;
}

template <int D>
Outcome<Repaired<D>> judge_all(const RepairState<D>& state, bool cut_short, const JudgedProposal<D>& input,
                               const RepairStatistics& passes, const Execution& execution) {
    auto judged = judge_moved(state.moved, state.shells, input, without_progress(execution));
    if (!judged) return fail(judged.error());
    RepairStatistics statistics = changes_between(input, *judged);
    statistics.work = state.work;
    statistics.by_edges = passes.by_edges;
    statistics.by_cavities = passes.by_cavities;
    statistics.by_extension = passes.by_extension;
    statistics.by_vertices = passes.by_vertices;
    statistics.by_slides = passes.by_slides;
    statistics.by_surface = passes.by_surface;
    std::vector<ElementId> unresolved;
    if (cut_short) unresolved = elements_not_valid(judged->validation());
    return Repaired<D>{std::move(*judged), statistics, std::move(unresolved)};
}

/// Repairs invalid elements by `extension`, `cavity` or `edge`:
///
/// 1. `extension`: nodes move towards the extension of the boundary displacement, only as far as required.
/// 2. The volume nodes of an element's cavity move jointly (joint_problem) at minimum cost.
/// 3. Single volume nodes move.
/// 4. The boundary displacement is extended locally.
/// 5. The nodes of larger cavities move, then vertices in the volume, then surface nodes.
/// 6. Nodes move back towards their targets, singly and jointly.
///
/// No valid element becomes invalid. If a vertex moves, det J must also exceed bound · |det of the original straight
/// element|. The mean ratio of the straight element must exceed min(its previous value, 0.05). Errors: stopped.
template <int D>
Outcome<Repaired<D>> repair_by_optimisation(const JudgedProposal<D>& input, const RepairGuide<D>& guide,
                                            const RepairOptions& options, const Execution& execution) {
    const QuadraticMesh<D>& mesh = input.mesh();
    const double max_work = std::min(allowed_work(input.validation().not_valid(), options.effort), options.max_work);
    Schedule schedule(mesh.linear.elements.size());
    Passes<D> passes{{MovedMesh<D>(input), guide.shells, guide.target_node, Memo(guide.models), options,
                      input.proposal().kinds, schedule, max_work, 0},
                     elements_not_valid(input.validation()),
                     execution};
    if (guide.onto) passes.state.onto = &guide.onto;
    if (guide.vertices_onto) passes.state.vertices_onto = &guide.vertices_onto;
    // Elements whose vertices have already moved are judged with the data that this call prepares.
    if (input.proposal().points != mesh.linear.points)
        if (auto result = prepare_vertex_moves(passes.state, execution); !result) return fail(result.error());
    RepairStatistics statistics;
    if (auto done = run(passes, guide, statistics); !done) return fail(done.error());
    return judge_all(passes.state, passes.cut_short, input, statistics, execution);
}

template <int D>
Outcome<Done> check(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const RepairGuide<D>& guide) {
    const std::size_t edges = mesh.edges.size();
    if (proposal.mid_nodes.size() != edges || proposal.kinds.size() != edges || proposal.changes.size() != edges ||
        guide.shells.size() != edges || (!guide.global_extension.empty() && guide.global_extension.size() != edges))
        return fail(ErrorKind::internal,
                    "the number of edges of the proposal or the guide differs from that of the "
                    "mesh");
    if (!guide.models || !guide.target_node)
        return fail(ErrorKind::internal, "the guide has no models, which this repair method needs");
    return Done{};
}

constexpr double share_of_retries = 0.25;

/// Nodes leave a prescribed geometry only for validity, not for a higher bound.
template <int D>
bool stays_on_geometry(const RepairGuide<D>& guide, double bound) {
    return guide.onto && bound > min_bound;
}

}  // namespace

template <int D>
Outcome<Repaired<D>> repair(const JudgedProposal<D>& input, const RepairGuide<D>& guide, const RepairOptions& options,
                            const Execution& execution) {
    if constexpr (D == 3)
        if (is_standalone_surface(input.mesh().linear))
            return repair_surface(input, guide, options, {guide.surface == SurfaceMoves::off_geometry}, execution);
    if (!needs_models(options.method)) return relax(input, options, execution);
    if (auto fits = check_limits(options); !fits) return fail(fits.error());
    if (input.validation().bound != options.min_scaled_jacobian.value) {
        const auto again =
            validate(input.mesh(), input.proposal(), options.min_scaled_jacobian, without_progress(execution));
        if (!again) return fail(again.error());
        return repair(*again, guide, options, execution);
    }
    if (input.validation().all_valid()) return Repaired<D>{input};
    if (auto fits = check(input.mesh(), input.proposal(), guide); !fits) return fail(fits.error());
    return guarded([&] { return repair_by_optimisation(input, guide, options, execution); });
}

template <int D>
Outcome<Repaired<D>> repair_or_straighten(const JudgedProposal<D>& input, const RepairGuide<D>& guide,
                                          const RepairOptions& options, const Execution& execution) {
    if (raises(options))
        return repair_then_raise(input, guide, options, execution, [&](const RepairOptions& by, const Execution& e) {
            return repair_or_straighten(input, guide, by, e);
        });
    const auto to = [&](const JudgedProposal<D>& judged, const RepairOptions& of) {
        RepairGuide<D> by = guide;
        if (stays_on_geometry(guide, of.min_scaled_jacobian)) by.surface = SurfaceMoves::on_geometry;
        return repair(judged, by, of, execution);
    };
    const auto again = [&](const JudgedProposal<D>& judged, RepairOptions of) {
        of.effort *= share_of_retries;
        return to(judged, of);
    };
    auto corrected = min_invalid(input, to(input, options), options, execution, again);
    if (is_standalone_surface(input.mesh().linear)) return corrected;  // `repair` has already straightened triangles
    if (!corrected || corrected->judged.validation().all_valid()) return corrected;
    // Nodes do not leave the surface for a bound that is only recommended.
    RepairOptions demanded = options;
    if (!options.min_scaled_jacobian.is_explicit || stays_on_geometry(guide, options.min_scaled_jacobian))
        demanded.min_scaled_jacobian = min_bound;
    const Execution quiet = without_progress(execution);
    const auto restored = [&] { return restore_input(input, std::move(*corrected), demanded, quiet); };
    if (!has_cavities(options.method)) return restored();
    const auto judged_for = [&](const JudgedProposal<D>& judged, double bound) {
        return validate(judged.mesh(), judged.proposal(), bound, quiet);
    };
    const auto before = judged_for(corrected->judged, demanded.min_scaled_jacobian);
    if (!before) return fail(before.error());
    auto done = relax(*before, demanded, quiet);
    if (!done) return fail(done.error());
    if (done->judged.validation().not_valid() >= before->validation().not_valid()) return restored();
    auto judged = judged_for(done->judged, options.min_scaled_jacobian);
    if (!judged) return fail(judged.error());
    corrected->judged = std::move(*judged);
    std::erase_if(corrected->unresolved,
                  [&](ElementId e) { return corrected->judged.validation().verdicts[e] == Verdict::valid; });
    corrected = with_all_changes(input, std::move(*corrected));
    return restored();
}

template <int D>
Outcome<Incidence<ElementId>> elements_of_edges(const QuadraticMesh<D>& mesh, const Execution& execution) {
    if (!is_standalone_surface(mesh.linear)) return shells(mesh.edges, execution);
    auto triangles = facet_shells(mesh.edges, execution);
    if (!triangles) return fail(triangles.error());
    return guarded([&]() -> Outcome<Incidence<ElementId>> {
        Buffer<ElementId> items;
        items.reserve(triangles->items.size());
        for (const FacetId f : triangles->items) items.emplace_back(f.index());
        return Incidence<ElementId>{triangles->offsets, std::move(items)};
    });
}

template <int D>
Outcome<RepairGuide<D>> guide_from_mesh(const JudgedProposal<D>& judged, const Incidence<ElementId>& shells,
                                        const Execution& execution) {
    const MovedMesh<D> moved(judged);
    const auto broken = elements_not_valid(judged.validation());
    auto extended = extend_around(moved, judged.proposal().kinds, shells, broken, 1, execution);
    if (!extended) return fail(extended.error());
    SparseMap<EdgeId, LagrangeNode<D>> targets;
    for (const ElementId e : broken)
        for (const EdgeId edge : judged.mesh().edges.of_elements[e])
            if (const auto* node = extended->nodes.find(edge)) targets.at(edge) = *node;
    // Models refer to the original vertex positions.
    const auto centre = [moved, targets = std::move(targets)](EdgeId edge) {
        const LagrangeNode<D>* node = targets.find(edge);
        return LagrangeNode<D>{(node ? *node : moved.nodes[edge]).point - moved.shift(edge)};
    };
    return RepairGuide<D>{shells, centre, [mesh = judged.mesh(), shells, centre](EdgeId edge) {
                              return implied_edge_model(mesh, edge, centre(edge), shells[edge]);
                          }};
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template Outcome<Repaired<D>> repair<D>(const JudgedProposal<D>&, const RepairGuide<D>&, const RepairOptions&, \
                                            const Execution&);                                                     \
    template Outcome<Repaired<D>> repair_or_straighten<D>(const JudgedProposal<D>&, const RepairGuide<D>&,         \
                                                          const RepairOptions&, const Execution&);                 \
    template Outcome<Incidence<ElementId>> elements_of_edges<D>(const QuadraticMesh<D>&, const Execution&);        \
    template Outcome<RepairGuide<D>> guide_from_mesh<D>(const JudgedProposal<D>&, const Incidence<ElementId>&,     \
                                                        const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
