// Passes of the optimisation methods, and the choice of the method.
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

/// Plans that share what work is left: so many of a round at once.
constexpr std::size_t plans_at_once = 32;

// Claims and plans of all passes have one type: the rounds are compiled once and not for each pass.
template <class Item>
using ClaimOf = std::function<std::vector<ElementId>(Item)>;
template <int D, class Item>
using PlanOf = std::function<Planned<D>(Item, double max_work)>;

/// The functions that plan the items of a pass.
template <int D, class Item>
struct ItemPlanning {
    std::function<bool(Item)> is_needless;  ///< true if the item is left out when its round comes
    const ClaimOf<Item>& claim;             ///< the elements that the plan of an item looks at
    const PlanOf<D, Item>& plan;            ///< plans an item for no more work than that
    std::function<void(Item, const Planned<D>&)> finished;
};

/// Plans one after the other in the order of their numbers, what does not overlap in parallel (`in_rounds` of
/// camber.core), until the state's work is spent. Progress tells of the items that are done with.
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
    return in_rounds(
        state.schedule, std::move(places), execution, [&](std::size_t i) { return is_needless(items[i]); },
        [&](std::size_t i) { return Claim(std::span((*claims)[i])); }, round);
}

/// Turns over what may return, while any of it does.
constexpr int segment_turns = 2;
constexpr int max_edge_turns = 4;
constexpr int max_joint_turns = 12;
/// What one pass may take of the work that is left.
constexpr double max_of_work = 0.5;
/// Passes in a repair that needs all of them.
constexpr double max_passes = 14;
/// Elements with an edge that costs less of its length return by single edges only.
constexpr double costly = 1e-3;
/// What slides ask for, as shares of the target: more than nothing, since bringing nodes back costs a little.
constexpr std::array slide_shares{1.0, 0.1, 0.001};
/// How many rings of elements around what is left the boundary's displacement is extended over.
constexpr int nearest_rings = 2;
constexpr int farthest_rings = 8;

/// The passes of a repair over the elements that are not good enough yet, the queue.
template <int D>
struct Passes {
    RepairState<D> state;
    std::vector<ElementId> queue;
    Execution execution;
    std::vector<ElementId> first_queue = queue;  ///< as it began
    std::size_t begun = 0;                       ///< passes so far
    bool cut_short = false;                      ///< some pass spent the work that it had and left elements

    [[nodiscard]] Outcome<Done> by_edges() {
        return over_queue([&](ElementId e) { return repair_cavity(state, e, CavityExtent{}).elements; },
                          [&](ElementId e, double) { return plan_edge_repair(state, e); });
    }
    [[nodiscard]] Outcome<Done> by_cavities(CavityExtent extent, double asked) {
        return over_queue([&](ElementId e) { return repair_cavity(state, e, extent).elements; },
                          [&](ElementId e, double max_work) {
                              return plan_cavity_repair(state, repair_cavity(state, e, extent), e, asked, max_work);
                          });
    }
    /// Nodes of boundary edges slide on the geometry, together with those of the volume.
    [[nodiscard]] Outcome<Done> by_slides(CavityExtent extent, double asked) {
        return over_queue([&](ElementId e) { return repair_cavity(state, e, extent).elements; },
                          [&](ElementId e, double max_work) {
                              return plan_slide_repair(state, repair_cavity(state, e, extent), e, asked, max_work);
                          });
    }
    /// What is left goes home; what this spoils is repaired as before, or stays as it was.
    [[nodiscard]] Outcome<Done> by_homes(const HomeOf<D>& home) {
        const Execution quiet = without_progress(execution);
        Passes trial{state, {}, quiet};
        if (auto done = go_home(trial.state, queue, home, quiet); !done) return done;
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
    /// Home is where the extension of the boundary's displacement has the nodes, that of all the mesh.
    [[nodiscard]] Outcome<Done> by_home(const Column<LagrangeNode<D>>& home) {
        // It is of the mesh's own vertices, some of which may have moved.
        return by_homes(
            [&](EdgeId edge) { return std::optional(LagrangeNode<D>{home[edge].point + state.moved.shift(edge)}); });
    }
    /// The same of so many rings of elements around what is left.
    [[nodiscard]] Outcome<Done> by_extension(int rings) {
        if (state.exhausted()) return Done{};
        const auto home =
            extend_around(state.moved, state.kinds, state.shells, queue, rings, without_progress(execution));
        if (!home) return fail(home.error());
        state.work_left -= home->work;
        state.work += home->work;
        return by_homes([&](EdgeId edge) {
            const LagrangeNode<D>* there = home->nodes.find(edge);
            return there ? std::optional(*there) : std::nullopt;
        });
    }
    /// Nodes that are off their places come as near as they may, one at a time, on segments.
    [[nodiscard]] Outcome<Done> returns_on_segments() {
        return returning(off_their_places(), segment_turns,
                         [&](EdgeId e, double) { return plan_return_on_segment(state, e); });
    }
    /// The same by programmes.
    [[nodiscard]] Outcome<Done> returns() {
        return returning(off_their_places(), max_edge_turns, [&](EdgeId e, double) { return plan_return(state, e); });
    }
    /// The same of those that cost most, for no more work than this.
    [[nodiscard]] Outcome<Done> returns_of_costliest(double max_work) {
        const double kept = std::max(0.0, state.work_left - max_work);
        state.work_left -= kept;
        std::vector<EdgeId> all = off_their_places();
        // The passes before may have spent more than there was.
        const double most = std::clamp(state.work_left / edge_work, 0.0, static_cast<double>(all.size()));
        auto edges = costliest(std::move(all), static_cast<std::size_t>(most));
        if (!edges) return fail(edges.error());
        auto done =
            returning(std::move(*edges), max_edge_turns, [&](EdgeId e, double) { return plan_return(state, e); });
        state.work_left += kept;
        return done;
    }
    /// And those of an element together, where one of them costs much.
    [[nodiscard]] Outcome<Done> joint_returns() {
        std::vector<ElementId> elements;
        for (const EdgeId edge : edges_concerned())
            if (is_costly(edge)) elements.insert(elements.end(), state.shells[edge].begin(), state.shells[edge].end());
        elements |= ranges::actions::sort | ranges::actions::unique;
        const auto claim = [&](ElementId e) { return repair_cavity(state, e, CavityExtent{}).elements; };
        return while_moving<ElementId>(std::move(elements), max_joint_turns, claim, [&](ElementId e, double max_work) {
            return plan_joint_return(state, repair_cavity(state, e, CavityExtent{}), max_work);
        });
    }

  private:
    /// Volume edges whose node may be off its place: those that moved, and those of what was not good enough.
    [[nodiscard]] std::vector<EdgeId> edges_concerned() const {
        std::vector<EdgeId> edges = state.moved.nodes.set_rows();
        for (const ElementId e : first_queue)
            edges.insert(edges.end(), state.mesh().edges.of_elements[e].begin(),
                         state.mesh().edges.of_elements[e].end());
        std::erase_if(edges, [&](EdgeId e) { return state.kinds[e] != EdgeKind::volume; });
        edges |= ranges::actions::sort | ranges::actions::unique;
        return edges;
    }
    [[nodiscard]] std::vector<EdgeId> off_their_places() const {
        std::vector<EdgeId> edges = edges_concerned();
        std::erase_if(edges, [&](EdgeId e) { return state.moved.nodes[e].point == state.wanted(e); });
        return edges;
    }
    /// So many of them whose nodes cost most where they are, by what is quick to tell: the mesh's own metric.
    [[nodiscard]] Outcome<std::vector<EdgeId>> costliest(std::vector<EdgeId> edges, std::size_t most) const {
        if (edges.size() <= most) return edges;
        const auto costs = map_each(without_progress(execution), edges.size(), [&](std::size_t i) {
            const EdgeId e = edges[i];
            const auto model = implied_edge_model(state.mesh(), e, {state.wanted(e)}, state.shells[e]);
            return std::pair(-model(state.moved.nodes[e].point), e);
        });
        if (!costs) return fail(costs.error());
        std::vector<std::pair<double, EdgeId>> ranked(costs->begin(), costs->end());
        std::ranges::nth_element(ranked, ranked.begin() + static_cast<std::ptrdiff_t>(most));
        for (std::size_t i = 0; i < most; ++i) edges[i] = ranked[i].second;
        edges.resize(most);
        return edges;
    }
    Outcome<Done> returning(std::vector<EdgeId> edges, int max_turns, const PlanOf<D, EdgeId>& plan) {
        const auto claim = [&](EdgeId e) {
            return std::vector<ElementId>(state.shells[e].begin(), state.shells[e].end());
        };
        return while_moving<EdgeId>(std::move(edges), max_turns, claim, plan);
    }
    [[nodiscard]] bool is_costly(EdgeId edge) const {
        return state.model(edge)(state.moved.nodes[edge].point) > costly;
    }
    Outcome<Done> finish(Outcome<Done> done) {
        std::erase_if(queue, [&](ElementId e) { return state.good(e); });
        return done;
    }
    /// The next pass's share of the progress of them all.
    [[nodiscard]] Execution next_pass(std::size_t turn = 0, std::size_t turns = 1) {
        if (turn == 0) ++begun;
        const auto share = [turns = static_cast<double>(turns), before = static_cast<double>(begun - 1)](double done) {
            return (before + done / turns) / max_passes;
        };
        return part_of(execution, share(static_cast<double>(turn)), share(static_cast<double>(turn + 1)));
    }
    Outcome<Done> over_queue(const ClaimOf<ElementId>& claim, const PlanOf<D, ElementId>& plan) {
        // A pass that repairs nothing leaves something to those that come after it.
        const double kept = state.work_left * (1 - max_of_work);
        state.work_left -= kept;
        const ItemPlanning<D, ElementId> planning{[&](ElementId e) { return state.good(e); }, claim, plan,
                                                  [](ElementId, const Planned<D>&) {}};
        auto done = finish(plan_in_rounds(state, queue, planning, next_pass()));
        cut_short = cut_short || (state.exhausted() && !queue.empty());
        state.work_left += kept;
        return done;
    }
    /// Turns over the items, each next one over those with an element that the last one claimed and moved: there may be
    /// room now.
    template <class Item>
    Outcome<Done> while_moving(std::vector<Item> items, int max_turns, const ClaimOf<Item>& claim,
                               const PlanOf<D, Item>& plan) {
        for (int turn = 0; turn < max_turns && !items.empty(); ++turn) {
            SparseSet<ElementId> near;
            const auto mark = [&](const Item& item, const Planned<D>& planned) {
                if (!planned.plan) return;
                for (const ElementId e : claim(item)) near.insert(e);
            };
            const Execution share = next_pass(static_cast<std::size_t>(turn), static_cast<std::size_t>(max_turns));
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

/// What passes that move vertices look at.
template <int D>
Outcome<Done> look_around_vertices(RepairState<D>& state, const Execution& execution) {
    auto around = balls(state.mesh().linear, without_progress(execution));
    if (!around) return fail(around.error());
    const VertexFreedom of_boundary = state.vertices_onto ? VertexFreedom::sliding : VertexFreedom::held;
    state.around_vertices = {std::move(*around),
                             vertex_freedoms(state.mesh(), state.kinds, state.options.vertices, of_boundary)};
    return Done{};
}

template <int D>
Outcome<Done> run(Passes<D>& passes, const RepairGuide<D>& guide, RepairStatistics& s) {
    using Moves = CavityExtent::Moves;
    const RepairOptions& options = passes.state.options;
    const bool homes_first = options.method == RepairMethod::extension;
    const bool with_cavities = has_cavities(options.method);
    // What is only recommended is not worth large cavities, nor vertices and surface nodes that leave their places.
    const bool is_asked = options.min_scaled_jacobian.is_asked;
    Outcome<Done> done = Done{};
    const auto counted = [&](std::size_t& counter, auto&& pass) {
        if (!done || passes.queue.empty()) return;
        const std::size_t before = passes.queue.size();
        done = pass();
        counter += before - passes.queue.size();
    };
    const auto cavities = [&](std::size_t& counter, CavityExtent extent, double asked) {
        if (with_cavities) counted(counter, [&] { return passes.by_cavities(extent, asked); });
    };
    const auto extension = [&](int rings) {
        if (with_cavities) counted(s.by_extension, [&] { return passes.by_extension(rings); });
    };
    const auto by_volume_nodes = [&] {
        if (homes_first) extension(nearest_rings);
        cavities(s.by_cavities, {Moves::volume_nodes, 0}, options.target);
        counted(s.by_edges, [&] { return passes.by_edges(); });
        for (int rings = nearest_rings; rings <= farthest_rings; rings *= 2) extension(rings);
        if (!is_asked) return;
        cavities(s.by_cavities, {Moves::volume_nodes, 1}, options.target);
        cavities(s.by_cavities, {Moves::volume_nodes, 1}, 0);
        cavities(s.by_cavities, {Moves::volume_nodes, 2}, 0);
    };
    if (homes_first && !guide.home.empty()) counted(s.by_extension, [&] { return passes.by_home(guide.home); });
    by_volume_nodes();
    if (with_cavities && is_asked && !passes.queue.empty())
        if (auto made = look_around_vertices(passes.state, passes.execution); !made) return made;
    if (is_asked) cavities(s.by_vertices, {Moves::vertices, 1}, 0);
    if (s.by_vertices > 0) by_volume_nodes();
    if (is_asked && with_cavities && passes.state.onto)
        for (const double share : slide_shares)
            counted(s.by_slides, [&] { return passes.by_slides({Moves::surface_nodes, 0}, share * options.target); });
    if (is_asked && with_cavities && passes.state.vertices_onto)
        for (const int closures : {0, 1, 2})
            counted(s.by_slides, [&] { return passes.by_slides({Moves::slides, closures}, 0); });
    if (is_asked && guide.surface == SurfaceMoves::off_geometry) cavities(s.by_surface, {Moves::surface_nodes, 1}, 0);
    if (!done) return done;
    if (homes_first) {
        done = passes.returns_on_segments();
        if (done) done = passes.returns_of_costliest(allowed_return_work(passes.first_queue.size(), options));
        return done;
    }
    done = passes.returns();
    if (done && with_cavities) done = passes.joint_returns();
    return done;
}

/// The state as a proposal with its verdicts, and what it took.
template <int D>
Outcome<Repaired<D>> judge_all(const RepairState<D>& state, bool cut_short, const JudgedProposal<D>& wanted,
                               const RepairStatistics& passes, const Execution& execution) {
    auto judged = judge_moved(state.moved, state.shells, wanted, without_progress(execution));
    if (!judged) return fail(judged.error());
    RepairStatistics statistics = changes_between(wanted, *judged);
    statistics.work = state.work;
    statistics.by_edges = passes.by_edges;
    statistics.by_cavities = passes.by_cavities;
    statistics.by_extension = passes.by_extension;
    statistics.by_vertices = passes.by_vertices;
    statistics.by_slides = passes.by_slides;
    statistics.by_surface = passes.by_surface;
    std::vector<ElementId> given_up;
    if (cut_short) given_up = elements_not_valid(judged->validation());
    return Repaired<D>{std::move(*judged), statistics, std::move(given_up)};
}

/// The methods `extension`, `cavity` and `edge`. Repairs what is not valid in a mesh with the places of `wanted`. By
/// `extension` nodes first go home, to the boundary's displacement extended, by as few steps as their elements need.
/// What is left, and by `cavity` all, is repaired at the least cost by the models: for each such element a cavity, its
/// volume nodes, which move together (joint_programme) while its surroundings and the boundary stay; then one volume
/// node; then the nodes around it extend the boundary's displacement; then larger cavities, and the vertices of the
/// volume; last, surface nodes, which are counted. Then nodes return as near to their places as they may, one at a time
/// and together. No element that is valid ever stops being so. Cavities that do not overlap are planned in parallel;
/// the result is the same for any number of threads. Where a vertex moves, det J is to be above bound · |det of the
/// mesh's straight element| too, and the mean ratio at least min(before, 0.05), or the vertex stays. Errors: stopped.
template <int D>
Outcome<Repaired<D>> repair_by_optimisation(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide,
                                            const RepairOptions& options, const Execution& execution) {
    const QuadraticMesh<D>& mesh = wanted.mesh();
    const double max_work = std::min(allowed_work(wanted.validation().not_valid(), options.effort), options.max_work);
    Schedule schedule(mesh.linear.elements.size());
    Passes<D> passes{{MovedMesh<D>(wanted), guide.shells, guide.wanted, Memo(guide.models), options,
                      wanted.proposal().kinds, schedule, max_work, 0},
                     elements_not_valid(wanted.validation()),
                     execution};
    if (guide.onto) passes.state.onto = &guide.onto;
    if (guide.vertices_onto) passes.state.vertices_onto = &guide.vertices_onto;
    // Where vertices are elsewhere already, their elements are judged by what is around them.
    if (wanted.proposal().points != mesh.linear.points)
        if (auto made = look_around_vertices(passes.state, execution); !made) return fail(made.error());
    RepairStatistics statistics;
    if (auto done = run(passes, guide, statistics); !done) return fail(done.error());
    return judge_all(passes.state, passes.cut_short, wanted, statistics, execution);
}

template <int D>
Outcome<Done> check(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const RepairGuide<D>& guide) {
    const std::size_t edges = mesh.edges.size();
    if (proposal.mid_nodes.size() != edges || proposal.kinds.size() != edges || proposal.changes.size() != edges ||
        guide.shells.size() != edges || (!guide.home.empty() && guide.home.size() != edges))
        return fail(ErrorKind::internal, "the proposal or the guide has another number of edges than the mesh");
    if (!guide.models || !guide.wanted)
        return fail(ErrorKind::internal, "the guide has no models, which this method of repair needs");
    return Done{};
}

/// Effort of each repair after the first, as a share.
constexpr double share_of_retries = 0.25;

/// What is prescribed is left that elements be valid, for no higher bound.
template <int D>
bool stays_on_geometry(const RepairGuide<D>& guide, double bound) {
    return guide.onto && bound > min_bound;
}

}  // namespace

template <int D>
Outcome<Repaired<D>> repair(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide, const RepairOptions& options,
                            const Execution& execution) {
    if constexpr (D == 3)
        if (is_surface_alone(wanted.mesh().linear))
            return repair_surface(wanted, guide, options, {guide.surface == SurfaceMoves::off_geometry}, execution);
    if (!needs_models(options.method)) return relax(wanted, options, execution);
    if (auto fits = check_limits(options); !fits) return fail(fits.error());
    if (wanted.validation().bound != options.min_scaled_jacobian.value) {
        const auto again =
            validate(wanted.mesh(), wanted.proposal(), options.min_scaled_jacobian, without_progress(execution));
        if (!again) return fail(again.error());
        return repair(*again, guide, options, execution);
    }
    if (wanted.validation().all_valid()) return Repaired<D>{wanted};
    if (auto fits = check(wanted.mesh(), wanted.proposal(), guide); !fits) return fail(fits.error());
    return guarded([&] { return repair_by_optimisation(wanted, guide, options, execution); });
}

template <int D>
Outcome<Repaired<D>> repair_or_straighten(const JudgedProposal<D>& wanted, const RepairGuide<D>& guide,
                                          const RepairOptions& options, const Execution& execution) {
    if (raises(options))
        return repair_then_raise(wanted, guide, options, execution, [&](const RepairOptions& by, const Execution& e) {
            return repair_or_straighten(wanted, guide, by, e);
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
    auto kept = min_invalid(wanted, to(wanted, options), options, execution, again);
    if (is_surface_alone(wanted.mesh().linear)) return kept;  // chords were tried
    if (!kept || kept->judged.validation().all_valid()) return kept;
    // The surface is not left for a bound that is only recommended.
    RepairOptions demanded = options;
    if (!options.min_scaled_jacobian.is_asked || stays_on_geometry(guide, options.min_scaled_jacobian))
        demanded.min_scaled_jacobian = min_bound;
    const Execution quiet = without_progress(execution);
    const auto restored = [&] { return restore_input(wanted, std::move(*kept), demanded, quiet); };
    if (!has_cavities(options.method)) return restored();
    const auto judged_for = [&](const JudgedProposal<D>& judged, double bound) {
        return validate(judged.mesh(), judged.proposal(), bound, quiet);
    };
    const auto before = judged_for(kept->judged, demanded.min_scaled_jacobian);
    if (!before) return fail(before.error());
    auto done = relax(*before, demanded, quiet);
    if (!done) return fail(done.error());
    if (done->judged.validation().not_valid() >= before->validation().not_valid()) return restored();
    auto judged = judged_for(done->judged, options.min_scaled_jacobian);
    if (!judged) return fail(judged.error());
    kept->judged = std::move(*judged);
    std::erase_if(kept->given_up, [&](ElementId e) { return kept->judged.validation().verdicts[e] == Verdict::valid; });
    kept = with_all_changes(wanted, std::move(*kept));
    return restored();
}

template <int D>
Outcome<Incidence<ElementId>> holders_of_edges(const QuadraticMesh<D>& mesh, const Execution& execution) {
    if (!is_surface_alone(mesh.linear)) return shells(mesh.edges, execution);
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
Outcome<RepairGuide<D>> own_guide(const JudgedProposal<D>& judged, const Incidence<ElementId>& shells,
                                  const Execution& execution) {
    const MovedMesh<D> moved(judged);
    const auto broken = elements_not_valid(judged.validation());
    auto extended = extend_around(moved, judged.proposal().kinds, shells, broken, 1, execution);
    if (!extended) return fail(extended.error());
    SparseMap<EdgeId, LagrangeNode<D>> wanted;
    for (const ElementId e : broken)
        for (const EdgeId edge : judged.mesh().edges.of_elements[e])
            if (const auto* node = extended->nodes.find(edge)) wanted.at(edge) = *node;
    // Models are about places of the mesh's own vertices.
    const auto centre = [moved, wanted = std::move(wanted)](EdgeId edge) {
        const LagrangeNode<D>* node = wanted.find(edge);
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
    template Outcome<Incidence<ElementId>> holders_of_edges<D>(const QuadraticMesh<D>&, const Execution&);         \
    template Outcome<RepairGuide<D>> own_guide<D>(const JudgedProposal<D>&, const Incidence<ElementId>&,           \
                                                  const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
