module;
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.operation;
import camber.adapt;
import :adaptation_rows;
import :cut_parts;
import :remesh_blocks;

namespace camber {

namespace {

void add(ToMetricStatistics& all, const ToMetricStatistics& s) {
    all.collapse += s.collapse;
    all.split += s.split;
    all.swap += s.swap;
    all.smooth += s.smooth;
    all.mend += s.mend;
}

ToMetricOptions options_of(const BlockTurn& turn, ToMetricOptions options) {
    options.rounds = turn.rounds;
    if (turn.lengths == BlockTurn::Lengths::loose) {
        options.collapse.longest = std::max(options.collapse.longest, options.loose_longest);
        options.split.longest = std::max(options.split.longest, options.loose_split);
    }
    return options;
}

/// A block brought to the metric; its rows take the place of those that it had.
template <int D>
Outcome<ToMetricStatistics> bring_block(AdaptationRows<D>& rows, const AdaptationGoal<D>& goal,
                                        const ToMetricOptions& options, const Around& around) {
    auto part = run_step(around, "blocks", [&](const Execution& e) { return assembled(rows, e); });
    if (!part) return fail(part.error());
    auto brought = bring_to_metric(std::move(part->state), goal, options, around);
    if (!brought) return fail(brought.error());
    part->state = std::move(brought->state);
    auto made = run_step(around, "blocks", [&](const Execution&) { return rows_of_part(*part, rows); });
    if (!made) return fail(made.error());
    rows = std::move(*made);
    return brought->statistics;
}

/// Directions and associations of the mesh that was cut, of the vertices that they are still of.
template <int D>
void give_back(const DynamicMesh<D>& before, const AdaptationRows<D>& rows, DynamicMesh<D>& after) {
    Buffer<VertexId> now(before.points.size(), VertexId{});
    for (std::size_t v = 0; v < rows.vertices.size(); ++v)
        if (const VertexId origin = rows.vertices[v].origin; origin.valid()) now[origin.index()] = VertexId(v);
    const auto directions = [&](const DirectionsAtVertices<D>& given) {
        Buffer<DirectionRow> at;
        for (const DirectionRow& row : given.at)
            if (const VertexId v = now[row.vertex.index()]; v.valid()) at.push_back({v, row.row});
        return DirectionsAtVertices<D>{given.table, std::move(at)};
    };
    const auto associations = [&]<int G>(const Column<Association<G>>& given) {
        Buffer<Association<G>> on;
        for (Association<G> a : given)
            if (const VertexId v = now[a.item.index()]; v.valid()) {
                a.item = v;
                on.push_back(a);
            }
        return Column<Association<G>>(std::move(on));
    };
    const GivenGeometry<D>& given = before.geometry;
    after.geometry = {directions(given.normals), directions(given.tangents), associations(given.on_points),
                      associations(given.on_curves), associations(given.on_surfaces)};
    after.groups = before.groups;
}

template <int D>
Outcome<Done> check_kind(const Adaptation<D>& state) {
    if (state.mesh.is_curved())
        return fail(ErrorKind::unsupported, "a curved mesh is not remeshed by blocks", {}, {},
                    "straighten it first (camber convert --straighten), or remesh it as a whole: blocks 0");
    if (state.mesh.is_surface())
        return fail(ErrorKind::unsupported, "a surface alone is not remeshed by blocks", {}, {},
                    "remesh it as a whole: blocks 0");
    return Done{};
}

}  // namespace

template <int D>
std::vector<BlockTurn> block_turns(const ToMetricOptions& options) {
    using enum BlockTurn::Lengths;
    constexpr double step = D == 2 ? 1.0 / 3 : 1.0 / 5;
    const int few = std::min(options.rounds, 2);
    return {{0, options.rounds, loose}, {2 * step, few, loose}, {step, few, strict}, {3 * step, few, strict}};
}

template <int D>
Outcome<JoinedMesh<D>> turn_by_blocks(const AdaptationRows<D>& whole, const AdaptationGoal<D>& goal,
                                      const ToMetricOptions& options, std::size_t elements, const BlockTurn& turn,
                                      ToMetricStatistics& statistics, const Around& around) {
    auto cut = run_step(around, "blocks",
                        [&](const Execution& e) { return cut_into_parts(whole, elements, turn.shift, e); });
    if (!cut) return fail(cut.error());
    int rounds = 0;
    for (AdaptationRows<D>& rows : cut->parts) {
        const auto done = bring_block(rows, goal, options_of(turn, options), around);
        if (!done) return fail(done.error());
        add(statistics, *done);
        rounds = std::max(rounds, done->rounds);
    }
    statistics.rounds += rounds;
    return run_step(around, "blocks", [&](const Execution&) { return joined(*cut); });
}

template <int D>
Outcome<BroughtToMetric<D>> bring_to_metric_by_blocks(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                      const ToMetricOptions& options, std::size_t elements,
                                                      const std::vector<BlockTurn>& turns, const Around& around) {
    if (auto checked = check_kind(state); !checked) return fail(checked.error());
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    ToMetricStatistics statistics;
    const auto measured = run_step(around, "lengths", [&](const Execution& e) { return unit_mesh_statistics(state, e); });
    if (!measured) return fail(measured.error());
    auto rows = run_step(around, "blocks", [&](const Execution&) { return rows_of(state); });
    if (!rows) return fail(rows.error());
    // What the passes do not need waits, and not with all that changes.
    DynamicMesh<D> before;
    before.points = state.mesh.points;
    before.geometry = state.mesh.geometry;
    before.groups = state.mesh.groups;
    state = {};
    for (const BlockTurn& turn : turns) {
        auto made = turn_by_blocks(*rows, goal, options, elements, turn, statistics, around);
        if (!made) return fail(made.error());
        rows = std::move(made->rows);
    }
    auto whole = run_step(around, "blocks", [&](const Execution& e) { return assembled(*rows, e); });
    if (!whole) return fail(whole.error());
    give_back(before, *rows, whole->state.mesh);
    const auto after = run_step(around, "lengths",
                                [&](const Execution& e) { return unit_mesh_statistics(whole->state, e); });
    if (!after) return fail(after.error());
    statistics.before = *measured;
    statistics.after = *after;
    return BroughtToMetric<D>{std::move(whole->state), std::move(statistics)};
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<JoinedMesh<D>> turn_by_blocks<D>(const AdaptationRows<D>&, const AdaptationGoal<D>&,              \
                                                      const ToMetricOptions&, std::size_t, const BlockTurn&,           \
                                                      ToMetricStatistics&, const Around&);                             \
    template std::vector<BlockTurn> block_turns<D>(const ToMetricOptions&);                                            \
    template Outcome<BroughtToMetric<D>> bring_to_metric_by_blocks<D>(Adaptation<D>, const AdaptationGoal<D>&,         \
                                                                      const ToMetricOptions&, std::size_t,             \
                                                                      const std::vector<BlockTurn>&, const Around&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
