module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.distributed;
import camber.core;
import camber.cavity;
import camber.metric;
import camber.operation;
import camber.adapt;

namespace camber {

namespace {

/// Volume of a simplex times D!.
double scaled_volume(const std::array<Vec<2>, 3>& p) {
    const Vec<2> a = p[1] - p[0], b = p[2] - p[0];
    return a[0] * b[1] - a[1] * b[0];
}
double scaled_volume(const std::array<Vec<3>, 4>& p) { return dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]); }

/// The same for edges of length 1.
template <int D>
constexpr double scaled_unit_volume = D == 2 ? 0.8660254037844386 : 0.7071067811865476;

template <int D>
std::uint64_t weight_of(const AdaptationRows<D>& rows, const AdaptedSimplex<D>& element, double coarser) {
    std::array<Vec<D>, D + 1> points;
    double density = 1;
    for (int i = 0; i <= D; ++i) {
        const AdaptedVertex<D>& v = rows.vertices[element.vertices[i].index()];
        points[i] = v.point;
        density *= v.metric.measure.density_root;
    }
    const double elements = std::abs(scaled_volume(points)) * density / (scaled_unit_volume<D> * pow(coarser, D));
    constexpr double most = 1ULL << 32U;
    constexpr auto one = static_cast<double>(ElementWeights::one);
    // NaN counts as one element.
    return elements > 1 ? static_cast<std::uint64_t>(one * std::min(elements, most)) : ElementWeights::one;
}

}  // namespace

template <int D>
Outcome<ElementWeights> expected_elements(const AdaptationRows<D>& rows, double coarser, const Execution& execution) {
    auto weights = map_each(execution, rows.elements.size(),
                            [&](std::size_t e) { return weight_of(rows, rows.elements[e], coarser); });
    if (!weights) return fail(weights.error());
    ElementWeights made{std::move(*weights), 0};
    for (const std::uint64_t w : made.weights) made.sum += w;
    return made;
}

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
        options.collapse.longest = std::max(options.collapse.longest, options.early_collapse_longest);
        options.split.longest = std::max(options.split.longest, options.early_split_longest);
        options.split.shortest = std::max(options.split.shortest, options.early_split_shortest);
        options.mend.sweeps = 0;  // later iterations change these elements anyway
    }
    options.split.longest *= turn.coarser;
    options.early_split_longest *= turn.coarser;
    return options;
}

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

template <int D>
Outcome<std::vector<ToMetricStatistics>> bring_blocks(std::vector<AdaptationRows<D>>& parts,
                                                      const AdaptationGoal<D>& goal, const ToMetricOptions& options,
                                                      const Around& around) {
    std::vector<ToMetricStatistics> statistics;
    for (AdaptationRows<D>& rows : parts) {
        const auto brought = bring_block(rows, goal, options, around);
        if (!brought) return fail(brought.error());
        statistics.push_back(*brought);
    }
    return statistics;
}

/// Restores directions and associations at preserved vertices.
template <int D>
void give_back(const GivenOfMesh<D>& before, const AdaptationRows<D>& rows, DynamicMesh<D>& after) {
    Buffer<VertexId> now(before.vertices, VertexId{});
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

/// Consecutive grids have no common walls.
template <int D>
double shift_of(int turn) {
    if constexpr (D == 2)
        return std::array{0.0, 2.0 / 3, 1.0 / 3}[static_cast<std::size_t>(turn) % 3];
    else
        return std::array{0.0, 0.4, 0.2, 0.6, 0.8}[static_cast<std::size_t>(turn) % 5];
}

/// Current and expected number of elements of all ranks.
struct Growing {
    double elements = 0, expected = 0;
    [[nodiscard]] double growth() const { return expected / elements; }
};
template <int D>
Outcome<Growing> growing(const AdaptationRows<D>& rows, Ranks& ranks, const Execution& execution) {
    const auto weights = expected_elements(rows, 1, execution);
    if (!weights) return fail(weights.error());
    const auto elements = counted(ranks, rows.elements.size());
    if (!elements) return fail(elements.error());
    return counted(ranks, weights->sum).map([&](const Counted& sum) {
        return Growing{static_cast<double>(elements->all),
                       static_cast<double>(sum.all) / static_cast<double>(ElementWeights::one)};
    });
}

/// Preliminary iterations with limited growth, while the mesh is to grow by a large factor. Blocks, which are cut by
/// expected elements, then have enough elements and do not exceed their size.
template <int D>
Outcome<BroughtRows<D>> grown(BroughtRows<D> rows, const AdaptationGoal<D>& goal, const ToMetricOptions& options,
                              const InBlocks& by, const Around& around) {
    constexpr double wanted = 2.5, too_much = 4;
    constexpr int turns = 24;
    double before = 0;
    for (int k = 0; options.rounds > 0 && k < turns; ++k) {
        const auto now =
            run_step(around, "blocks", [&](const Execution& e) { return growing(rows.shared.rows, by.ranks, e); });
        if (!now) return fail(now.error());
        if (!(now->growth() > too_much)) break;
        if (!(now->elements > 1.5 * before)) break;  // the mesh does not grow
        before = now->elements;
        const BlockTurn turn{.shift = shift_of<D>(k),
                             .rounds = 1,
                             .lengths = BlockTurn::Lengths::loose,
                             .coarser = pow(now->growth() / wanted, 1.0 / D)};
        auto turned = turn_by_blocks(std::move(rows), goal, options, by, turn, around);
        if (!turned) return turned;
        rows = std::move(*turned);
    }
    return rows;
}

template <int D>
Outcome<Done> check_kind(const Adaptation<D>& state) {
    if (state.mesh.is_curved())
        return fail(ErrorKind::unsupported, "a curved mesh cannot be remeshed by blocks", {}, {},
                    "straighten it first (camber convert --straighten), or remesh it as a whole: blocks 0");
    if (state.mesh.is_surface())
        return fail(ErrorKind::unsupported, "a standalone surface mesh cannot be remeshed by blocks", {}, {},
                    "remesh it as a whole: blocks 0");
    return Done{};
}

template <int D>
Outcome<BroughtRows<D>> begin(Adaptation<D> state, const ToMetricOptions& options, const Ranks& ranks,
                              const Around& around) {
    if (auto checked = check_kind(state); !checked) return fail(checked.error());
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    const auto measured =
        run_step(around, "lengths", [&](const Execution& e) { return unit_mesh_statistics(state, e); });
    if (!measured) return fail(measured.error());
    BroughtRows<D> begun;
    begun.statistics.before = *measured;
    begun.given = {state.mesh.points.size(), state.mesh.geometry, state.mesh.groups};
    auto shared = run_step(around, "blocks", [&](const Execution&) -> Outcome<SharedRows<D>> {
        const auto rows = rows_of(state);
        if (!rows) return fail(rows.error());
        state = {};
        return share_of(*rows, ranks);
    });
    if (!shared) return fail(shared.error());
    begun.shared = std::move(*shared);
    return begun;
}
template <int D>
Outcome<BroughtToMetric<D>> end(const AdaptationRows<D>& rows, const GivenOfMesh<D>& given,
                                const ToMetricStatistics& statistics, const Around& around) {
    auto whole = run_step(around, "blocks", [&](const Execution& e) { return assembled(rows, e); });
    if (!whole) return fail(whole.error());
    give_back(given, rows, whole->state.mesh);
    const auto after =
        run_step(around, "lengths", [&](const Execution& e) { return unit_mesh_statistics(whole->state, e); });
    if (!after) return fail(after.error());
    BroughtToMetric<D> brought{std::move(whole->state), statistics};
    brought.statistics.after = *after;
    return brought;
}

}  // namespace

template <int D>
Outcome<BroughtRows<D>> turn_by_blocks(BroughtRows<D> rows, const AdaptationGoal<D>& goal,
                                       const ToMetricOptions& options, const InBlocks& by, const BlockTurn& turn,
                                       const Around& around) {
    return together(by.ranks, [&]() -> Outcome<BroughtRows<D>> {
        auto cut = run_step(around, "blocks", [&](const Execution& e) {
            return expected_elements(rows.shared.rows, turn.coarser, e).and_then([&](const ElementWeights& weights) {
                return cut_into_parts(std::move(rows.shared), weights, by.elements, turn.shift, by.ranks, e);
            });
        });
        if (!cut) return fail(cut.error());
        const auto all = gather_all(by.ranks, bring_blocks(cut->parts, goal, options_of(turn, options), around));
        if (!all) return fail(all.error());
        int rounds = 0;
        for (const ToMetricStatistics& of_block : *all) {
            add(rows.statistics, of_block);
            rounds = std::max(rounds, of_block.rounds);
        }
        rows.statistics.rounds += rounds;
        auto shared = run_step(around, "blocks", [&](const Execution&) { return joined(std::move(*cut), by.ranks); });
        if (!shared) return fail(shared.error());
        rows.shared = std::move(*shared);
        return std::move(rows);
    });
}

template <int D>
std::vector<BlockTurn> block_turns(const ToMetricOptions& options) {
    using enum BlockTurn::Lengths;
    const int few = std::min(options.rounds, 2), one = std::min(options.rounds, 1);
    return {{.shift = shift_of<D>(0), .rounds = std::min(options.rounds, options.rounds / 2 + 1), .lengths = loose},
            {.shift = shift_of<D>(1), .rounds = few, .lengths = loose},
            {.shift = shift_of<D>(2), .rounds = few, .lengths = strict},
            {.shift = shift_of<D>(3), .rounds = one, .lengths = strict},
            {.shift = shift_of<D>(4), .rounds = 0, .lengths = strict}};
}

template <int D>
Outcome<BroughtRows<D>> bring_rows_to_metric(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                             const ToMetricOptions& options, const InBlocks& by,
                                             const std::vector<BlockTurn>& turns, const Around& around) {
    return together(by.ranks, [&]() -> Outcome<BroughtRows<D>> {
        auto brought = begin(std::move(state), options, by.ranks, around);
        if (!brought) return fail(brought.error());
        brought = grown(std::move(*brought), goal, options, by, around);
        for (const BlockTurn& turn : turns) {
            if (!brought) return brought;
            brought = turn_by_blocks(std::move(*brought), goal, options, by, turn, around);
        }
        return brought;
    });
}

template <int D>
Outcome<BroughtToMetric<D>> bring_to_metric_by_blocks(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                                      const ToMetricOptions& options, const InBlocks& by,
                                                      const std::vector<BlockTurn>& turns, const Around& around) {
    return together(by.ranks, [&]() -> Outcome<BroughtToMetric<D>> {
        auto brought = bring_rows_to_metric(std::move(state), goal, options, by, turns, around);
        if (!brought) return fail(brought.error());
        const auto rows = run_step(around, "blocks",
                                   [&](const Execution&) { return gathered(std::move(brought->shared), by.ranks); });
        if (!rows) return fail(rows.error());
        return end(*rows, brought->given, brought->statistics, around);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template Outcome<ElementWeights> expected_elements<D>(const AdaptationRows<D>&, double, const Execution&);    \
    template Outcome<BroughtRows<D>> turn_by_blocks<D>(BroughtRows<D>, const AdaptationGoal<D>&,                  \
                                                       const ToMetricOptions&, const InBlocks&, const BlockTurn&, \
                                                       const Around&);                                            \
    template std::vector<BlockTurn> block_turns<D>(const ToMetricOptions&);                                       \
    template Outcome<BroughtRows<D>> bring_rows_to_metric<D>(Adaptation<D>, const AdaptationGoal<D>&,             \
                                                             const ToMetricOptions&, const InBlocks&,             \
                                                             const std::vector<BlockTurn>&, const Around&);       \
    template Outcome<BroughtToMetric<D>> bring_to_metric_by_blocks<D>(Adaptation<D>, const AdaptationGoal<D>&,    \
                                                                      const ToMetricOptions&, const InBlocks&,    \
                                                                      const std::vector<BlockTurn>&, const Around&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
