// Searches for the nodes of many edges in packs of eight.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <span>
#include <vector>
module camber.edge_optimisation;
import camber.core;
import camber.bezier;
import camber.metric;
import :edge_pack_lanes;
import :edge_pack_location;
import :edge_pack_objective;
import :edge_pack_step;

namespace camber {

namespace {

template <int D>
[[gnu::always_inline]] inline VecPack<D> offsets_of(const ChordFrame<D>& f, const VecPack<D>& y) {
    VecPack<D> o;
    for (int i = 0; i < D; ++i) o[i] = f.scale[i] * y[i];
    return times(f.axes, o);
}

/// Adds the offset to the stored node, which must be the chord midpoint (one call per edge).
template <int D>
[[gnu::always_inline]] inline void put_node(const PackedEdges<D>& all, std::uint32_t edge, const VecPack<D>& offset,
                                            int lane) {
    for (int i = 0; i < D; ++i) all.minima[edge].node.point[i] += offset[i][lane];
}

/// Halves the offset until the edge is shorter than its chord. length_of(lanes, marks) returns lengths by the finer
/// rule, and `chord` is the chord's length by that rule. `beside`: marks of the chord. Edges that cross the boundary
/// are passed to `judge`, which projects onto the boundary.
template <int D, class Length>
[[gnu::always_inline]] inline void judged(const PackedEdges<D>& all, SearchLanes<D>& lanes, int count, Pack chord,
                                          const WalkMarks& beside, const Length& length_of) {
    SearchPack<D>& s = lanes.pack;
    const Quadrature& rule = all.rules.report;
    Mask open{};
    for (int lane = 0; lane < count; ++lane) open[lane] = -1;
    Mask shortened{};
    Mask located_outside = open & (beside.outside | beside.lost);
    open &= ~located_outside;
    for (int halving = 0; halving < 7 && any(open); ++halving) {
        if (halving == 6)
            for (int i = 0; i < D; ++i) s.y[i] = select(open, packed(0), s.y[i]);
        WalkMarks marks{.lost = ~open};
        const Pack length = length_of(lanes, marks);
        for (int lane = 0; lane < count; ++lane) all.work.decompositions += open[lane] != 0 ? rule.size() : 0;
        located_outside |= open & (marks.outside | marks.lost);
        open &= ~located_outside & ~(length < (1 - length_rounding) * chord);
        shortened |= open;
        for (int i = 0; i < D; ++i) s.y[i] = select(open, 0.5 * s.y[i], s.y[i]);
    }
    const VecPack<D> offset = offsets_of(s.frame, s.y);
    for (int lane = 0; lane < count; ++lane) {
        put_node(all, lanes.edge[lane], offset, lane);
        all.minima[lanes.edge[lane]].shortened = shortened[lane] != 0;
        if (located_outside[lane] != 0) all.alone[lanes.edge[lane]] = 2;
    }
    all.work.decompositions += rule.size() * static_cast<std::size_t>(count);
    all.work.judged += static_cast<std::size_t>(count);
}

template <int D>
[[gnu::always_inline]] inline void judge_within(const PackedEdges<D>& all, SearchLanes<D>& open, int count) {
    const Pack chord = length_along(open.pack.frame, ParabolaPack<D>{}, all.rules.report);
    judged(all, open, count, chord, {}, [&](const SearchLanes<D>& lanes, WalkMarks&) __attribute__((always_inline)) {
        const SearchPack<D>& s = lanes.pack;
        return length_along(s.frame, parabola(s.frame, s.wedge, s.y), all.rules.report);
    });
}
template <int D>
[[gnu::always_inline]] inline void judge_through(const PackedEdges<D>& all, SearchLanes<D>& open, int count) {
    WalkMarks chord_marks{};
    const Pack chord = chord_length(all, open, chord_marks);
    judged(all, open, count, chord, chord_marks,
           [&](const SearchLanes<D>& lanes, WalkMarks& marks) __attribute__((always_inline)) {
               ElementsPack<D> elements = entered<D>(all.back, lanes.element);
               return located_lengths(all.back, {lanes.pack.frame, lanes.pack.y}, all.rules.report, elements, marks)
                   .length;
           });
}

template <int D>
struct SearchQueue {
    std::array<SearchLanes<D>, 4> lanes{};
    int count = 0;

    [[gnu::always_inline]] inline void push(const SearchLanes<D>& from, int lane) {
        copy_lane(lanes[count / pack_size], count % pack_size, from, lane);
        ++count;
    }
    [[gnu::always_inline]] inline void pop(SearchLanes<D>& to, int lane) {
        --count;
        copy_lane(to, lane, lanes[count / pack_size], count % pack_size);
    }
    [[gnu::always_inline]] inline void push_leaving(const SearchLanes<D>& from, int lane) {
        copy_leaving(lanes[count / pack_size], count % pack_size, from, lane);
        ++count;
    }
    [[gnu::always_inline]] inline void pop_leaving(SearchLanes<D>& to, int lane) {
        --count;
        copy_leaving(to, lane, lanes[count / pack_size], count % pack_size);
    }
};

template <int D>
struct SearchQueues {
    SearchQueue<D>& to_judge;
    SearchQueue<D>& leaving;
    SearchQueue<D>& to_probe;
    SearchQueue<D>& to_judge_through;
};

template <int D, class Where>
[[gnu::always_inline]] inline void resolve(const PackedEdges<D>& all, SearchLanes<D>& lanes, const Ended& ended,
                                           const Where& where, const SearchQueues<D>& queues) {
    const auto& [to_judge, leaving, to_probe, to_judge_through] = queues;
    const Mask out = ended.ended | ended.leaves;
    if (!any(out)) return;
    const VecPack<D> offset = offsets_of(lanes.pack.frame, lanes.pack.y);
    const Pack gain = lanes.pack.chord_length - lanes.pack.at.length;
    const Pack sure = where.sure_gain(all, lanes);
    const Mask unresolved = ~(max(lanes.pack.change, change_of(lanes.pack) + where.bulge(lanes)) < max_change);
    for (int lane = 0; lane < pack_size; ++lane) {
        if (out[lane] == 0) continue;
        const std::uint32_t edge = lanes.edge[lane];
        if (ended.leaves[lane] != 0) {
            leaving.push_leaving(lanes, lane);
        } else {
            EdgeMinimum<D>& minimum = all.minima[edge];
            if (ended.exhausted[lane] != 0) minimum.search = EdgeSearch::exhausted;
            if (ended.kinked[lane] != 0) minimum.search = EdgeSearch::polished;
            if (unresolved[lane] != 0)
                (lanes.pack.probed[lane] != 0 ? to_judge_through : to_probe).push_leaving(lanes, lane);
            else if (gain[lane] > sure[lane])
                put_node(all, edge, offset, lane);
            else if (gain[lane] > min_gain * lanes.pack.chord_length[lane])
                to_judge.push(lanes, lane);
        }
        lanes.pack.running[lane] = 0;
    }
}

template <int D>
[[gnu::always_inline]] inline void probe(const PackedEdges<D>& all, SearchLanes<D>& lanes, int count,
                                         PointElements<D>& points, SearchQueue<D>& leaving, SearchQueue<D>& to_judge) {
    SearchPack<D>& s = lanes.pack;
    Mask open{};
    for (int lane = 0; lane < count; ++lane) open[lane] = -1;
    // Probed positions are far apart, so no valley of the energy is searched first.
    const bool shortens = all.options.objective == EdgeObjectiveKind::length || all.options.length_tolerance > 0;
    s.by_length = packed(shortens ? 1 : 0);
    s.probed = packed(1);
    const ElementsPack<D> at = entered<D>(all.back, lanes.element);
    for (std::size_t q = 0; q < all.rules.objective.size(); ++q) points[q] = at;
    const Mask near = open & (s.change < max_change_for_slopes);
    const Probing<D> best = probed(all, s, open, near, points);
    const Mask continues = best.found & near;
    choose(best.found, s.y, best.y);
    const Mask judged = ~continues & (best.found | (s.at.length < (1 - min_gain) * s.chord_length));
    if (any(continues)) start_search(all, s, continues, points);
    s.running = packed(1);
    for (int lane = 0; lane < count; ++lane) {
        if (continues[lane] != 0) leaving.push_leaving(lanes, lane);
        if (judged[lane] != 0) to_judge.push_leaving(lanes, lane);
        all.minima[lanes.edge[lane]].search = EdgeSearch::polished;
    }
}

template <int D>
[[nodiscard, gnu::always_inline]] inline int running_lanes(const SearchLanes<D>& lanes) {
    int n = 0;
    for (int lane = 0; lane < pack_size; ++lane) n += lanes.pack.running[lane] != 0;
    return n;
}

template <int D>
[[nodiscard, gnu::always_inline]] inline int take_edges(const PackedEdges<D>& all, std::size_t& next,
                                                        std::array<std::uint32_t, pack_size>& taken) {
    int count = 0;
    for (; next < all.order.size() && count < pack_size; ++next)
        if (all.alone[all.order[next]] == 0) taken[count++] = all.order[next];
    for (int k = count; k < pack_size; ++k) taken[k] = taken[0];
    return count;
}

/// Prefetches the next edges. Half of an element's vertices suffice, because each vertex off the edge is in two
/// elements of the shell.
template <int D>
void prefetch_edges(const PackedEdges<D>& all, std::size_t next) {
    const auto& elements = all.back.mesh.elements.vertices;
    const std::size_t soon = std::min(next + pack_size, all.order.size());
    const std::size_t later = std::min(soon + pack_size, all.order.size());
    for (std::size_t i = next; i < soon; ++i)
        for (const ElementId e : all.edges[all.order[i]].shell)
            for (int n = 0; n < 2; ++n) {
                const VertexId v = elements[e][n];
                __builtin_prefetch(&all.back.mesh.points[v]);
                __builtin_prefetch(&all.back.log_metrics[v]);
            }
    for (std::size_t i = soon; i < later; ++i)
        for (const ElementId e : all.edges[all.order[i]].shell) __builtin_prefetch(&elements[e]);
}

template <int D, class Where>
[[gnu::always_inline]] inline void step(const PackedEdges<D>& all, SearchLanes<D>& lanes, const Where& where,
                                        const SearchQueues<D>& queues) {
    resolve(all, lanes, stepped(all, lanes, where), where, queues);
}

/// Kernels are compiled separately for the instruction set; one common function takes five times as long to compile.
template <int D>
void search(Instructions set, const PackedEdges<D>& all) {
    const bool are_free = !all.free.empty();
    SearchLanes<D> next_lanes{};
    SearchLanes<D> within{};
    SearchLanes<D> through{};
    within.set_default_elements();
    through.set_default_elements();
    PointElements<D> points{};
    SearchQueue<D> leaving;
    SearchQueue<D> to_probe;
    PointElements<D> points_probed{};
    SearchQueue<D> to_judge;
    SearchQueue<D> to_judge_through;
    const SearchQueues<D> from_within{to_judge, leaving, to_probe, to_judge_through};
    const SearchQueues<D> from_through{to_judge_through, leaving, to_probe, to_judge_through};
    ElementsPack<D> entering{};
    const auto enter = [&](Mask come) {
        with_instructions(set, [&]() __attribute__((always_inline)) {
            enter_lanes(all.back, entering, through.element, come);
            for (std::size_t q = 0; q < all.rules.objective.size(); ++q) choose(come, points[q], entering);
        });
    };
    const auto step_within = [&](SearchLanes<D>& lanes, int running) {
        all.work.decompositions += static_cast<std::size_t>(running) * all.rules.objective.size();
        with_instructions(set,
                          [&]() __attribute__((always_inline)) { step(all, lanes, WithinWedge<D>{}, from_within); });
    };
    enter(Mask(-1));
    int next_lane = pack_size;
    std::size_t next = 0;
    for (;;) {
        bool more = true;
        // Finished lanes take new edges.
        for (int lane = 0; lane < pack_size && more; ++lane) {
            while (within.pack.running[lane] == 0 && leaving.count < pack_size && to_probe.count < pack_size &&
                   to_judge.count < pack_size) {
                if (next_lane == pack_size) {
                    std::array<std::uint32_t, pack_size> taken{};
                    const int count = take_edges(all, next, taken);
                    more = count > 0;
                    if (!more) break;
                    if (!are_free) prefetch_edges(all, next);
                    Mask away{};
                    if (are_free) {
                        with_instructions(set, [&]() __attribute__((always_inline)) {
                            next_lanes = started_at_chords(all, taken, count);
                            away = next_lanes.pack.running != 0;
                        });
                    } else {
                        with_instructions(set, [&]() __attribute__((always_inline)) {
                            begin(all, taken, count, next_lanes);
                            away = (next_lanes.pack.running != 0) & leaves(next_lanes.pack, all.options);
                        });
                    }
                    next_lane = 0;
                    for (int k = 0; k < pack_size; ++k) {
                        if (!(next_lanes.pack.change[k] < max_change)) to_probe.push_leaving(next_lanes, k);
                        if (away[k] == 0) continue;
                        leaving.push_leaving(next_lanes, k);
                        next_lanes.pack.running[k] = 0;
                    }
                    // Many searches finish with their first step.
                    if (const int running = running_lanes(next_lanes); running > 0) step_within(next_lanes, running);
                }
                if (next_lanes.pack.running[next_lane] != 0) copy_lane(within, lane, next_lanes, next_lane);
                ++next_lane;
            }
        }
        const int running = running_lanes(within);
        Mask come{};
        bool any_taken = false;
        for (int lane = 0; lane < pack_size && leaving.count > 0; ++lane) {
            if (through.pack.running[lane] != 0) continue;
            leaving.pop_leaving(through, lane);
            come[lane] = -1;
            any_taken = true;
        }
        if (any_taken) enter(come);
        const int running_through = running_lanes(through);
        if (running_through == pack_size || (running == 0 && running_through > 0)) {
            all.work.decompositions += static_cast<std::size_t>(running_through) * all.rules.objective.size();
            with_instructions(set, [&]() __attribute__((always_inline)) {
                step(all, through, ThroughElements<D>{points}, from_through);
            });
        } else if (running > 0) {
            step_within(within, running);
        }
        const bool drained = !more && running == 0 && running_through == 0;
        const bool last = drained && to_probe.count == 0;
        if (leaving.count <= pack_size && (to_probe.count >= pack_size || (drained && !last))) {
            SearchLanes<D> open{};
            open.set_default_elements();
            int count = 0;
            while (count < pack_size && to_probe.count > 0) to_probe.pop_leaving(open, count++);
            with_instructions(set, [&]() __attribute__((always_inline)) {
                probe(all, open, count, points_probed, leaving, to_judge_through);
            });
        }
        while (to_judge.count >= pack_size || (last && to_judge.count > 0)) {
            SearchLanes<D> open{};
            open.set_default_elements();
            int count = 0;
            while (count < pack_size && to_judge.count > 0) to_judge.pop(open, count++);
            with_instructions(set, [&]() __attribute__((always_inline)) { judge_within(all, open, count); });
        }
        while (to_judge_through.count >= pack_size || (last && to_judge_through.count > 0)) {
            SearchLanes<D> open{};
            open.set_default_elements();
            int count = 0;
            while (count < pack_size && to_judge_through.count > 0) to_judge_through.pop(open, count++);
            with_instructions(set, [&]() __attribute__((always_inline)) { judge_through(all, open, count); });
        }
        if (last) break;
    }
}

std::vector<std::uint32_t> by_shell_size(std::span<const BackEdge> edges) {
    std::array<std::uint32_t, 32> begin{};
    const auto size_class = [&](std::size_t e) { return std::min(edges[e].shell.size(), begin.size() - 1); };
    for (std::size_t e = 0; e < edges.size(); ++e)
        for (std::size_t larger = size_class(e) + 1; larger < begin.size(); ++larger) ++begin[larger];
    std::vector<std::uint32_t> order(edges.size());
    for (std::size_t e = 0; e < edges.size(); ++e) order[begin[size_class(e)]++] = static_cast<std::uint32_t>(e);
    return order;
}

}  // namespace

template <int D>
EdgeSearchWork minimise_back_edges(const BackMesh<D>& back, const BackEdges<D>& input, const EdgeRules& rules,
                                   const EdgeMinimiserOptions& options, std::span<EdgeMinimum<D>> minima,
                                   Instructions set) {
    const auto& [edges, present] = input;
    EdgeSearchWork work;
    const auto [straight, curved] = back->packed();
    std::vector<std::uint8_t> alone(edges.size(), straight && options.field == EdgeFieldKind::back ? 0 : 1);
    if (straight)
        for (std::size_t i = 0; i < edges.size(); ++i) {
            const auto& [a, b, shell] = edges[i];
            const Vec<D> middle = midpoint(straight->mesh.points[a], straight->mesh.points[b]);
            if (present[i].point != middle) alone[i] = 1;
            if (curved && std::ranges::any_of(shell, [&](ElementId e) { return curved->is_curved(e); })) alone[i] = 1;
            minima[i] = {};
            minima[i].node.point = middle;
        }
    if (straight) {
        const std::vector<std::uint32_t> order = by_shell_size(edges);
        const PackedEdges<D> all{*straight, edges, {}, curved, order, rules, options, minima, alone, work};
        search(set, all);
    }
    for (std::size_t i = 0; i < edges.size(); ++i) {
        if (alone[i] == 0) continue;
        const auto& [a, b, shell] = edges[i];
        if (alone[i] == 2) {
            judge(back,
                  edge_objective(
                      back, rules.objective, options.objective, options.field,
                      {back->vertex(a).point, back->vertex(b).point, *std::min_element(shell.begin(), shell.end())}),
                  rules.report, minima[i]);
            minima[i].straight_length = minima[i].length = 0;
            continue;
        }
        ++work.single;
        minima[i] = minimise_back_edge(back, edges[i], present[i], rules, options);
        minima[i].straight_length = minima[i].length = 0;
    }
    return work;
}

template <int D>
EdgeSearchWork minimise_edges(const BackMesh<D>& back, std::span<const FreeEdge<D>> edges, const EdgeRules& rules,
                              const EdgeMinimiserOptions& options, std::span<EdgeMinimum<D>> minima, Instructions set) {
    EdgeSearchWork work;
    const auto [straight, curved] = back->packed();
    std::vector<std::uint8_t> alone(edges.size(), straight && options.field == EdgeFieldKind::back ? 0 : 1);
    for (std::size_t i = 0; i < edges.size(); ++i) {
        minima[i] = {};
        minima[i].node.point = midpoint(edges[i].a.point, edges[i].b.point);
    }
    if (straight) {
        std::vector<std::uint32_t> order(edges.size());
        std::iota(order.begin(), order.end(), std::uint32_t{0});
        const PackedEdges<D> all{*straight, {}, edges, curved, order, rules, options, minima, alone, work};
        search(set, all);
    }
    for (std::size_t i = 0; i < edges.size(); ++i) {
        if (alone[i] == 0) continue;
        const auto& [a, b, hint] = edges[i];
        if (alone[i] == 2) {
            judge(back,
                  edge_objective(back, rules.objective, options.objective, options.field, {a.point, b.point, hint}),
                  rules.report, minima[i]);
        } else {
            ++work.single;
            minima[i] = minimise_edge(back, a.point, b.point, hint, rules, options);
        }
        minima[i].straight_length = minima[i].length = 0;
    }
    return work;
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template EdgeSearchWork minimise_edges<D>(const BackMesh<D>&, std::span<const FreeEdge<D>>, const EdgeRules&,    \
                                              const EdgeMinimiserOptions&, std::span<EdgeMinimum<D>>, Instructions); \
    template EdgeSearchWork minimise_back_edges<D>(const BackMesh<D>&, const BackEdges<D>&, const EdgeRules&,        \
                                                   const EdgeMinimiserOptions&, std::span<EdgeMinimum<D>>,           \
                                                   Instructions);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
