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

/// Returns the volume of a simplex, times D!.
double scaled_volume(const std::array<Vec<2>, 3>& p) {
    const Vec<2> a = p[1] - p[0], b = p[2] - p[0];
    return a[0] * b[1] - a[1] * b[0];
}
double scaled_volume(const std::array<Vec<3>, 4>& p) { return dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]); }

/// Value of scaled_volume for a simplex with edges of length 1.
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
    ElementWeights result{std::move(*weights), 0};
    for (const std::uint64_t w : result.weights) result.sum += w;
    return result;
}

namespace {

void add(ToMetricStatistics& all, const ToMetricStatistics& s) {
    all.collapse += s.collapse;
    all.split += s.split;
    all.swap += s.swap;
    all.smooth += s.smooth;
    all.mend += s.mend;
}

ToMetricOptions options_of(const BlockIteration& turn, ToMetricOptions options) {
    options.rounds = turn.rounds;
    if (turn.lengths == BlockIteration::Lengths::loose) {
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
Outcome<ToMetricStatistics> remesh_block(AdaptationRows<D>& rows, const AdaptationGoal<D>& goal,
                                         const ToMetricOptions& options, const StepWrapper& around) {
    auto part = run_step(around, "blocks", [&](const Execution& e) { return assembled(rows, e); });
    if (!part) return fail(part.error());
    auto remeshed = remesh_to_metric(std::move(part->state), goal, options, around);
    if (!remeshed) return fail(remeshed.error());
    part->state = std::move(remeshed->state);
    auto result = run_step(around, "blocks", [&](const Execution&) { return rows_of_part(*part, rows); });
    if (!result) return fail(result.error());
    rows = std::move(*result);
    return remeshed->statistics;
}

template <int D>
Outcome<std::vector<ToMetricStatistics>> remesh_blocks(std::vector<AdaptationRows<D>>& parts,
                                                       const AdaptationGoal<D>& goal, const ToMetricOptions& options,
                                                       const StepWrapper& around) {
    std::vector<ToMetricStatistics> statistics;
    for (AdaptationRows<D>& rows : parts) {
        const auto remeshed = remesh_block(rows, goal, options, around);
        if (!remeshed) return fail(remeshed.error());
        statistics.push_back(*remeshed);
    }
    return statistics;
}

template <int D>
void restore_input(const InitialGeometry<D>& before, const AdaptationRows<D>& rows, DynamicMesh<D>& after) {
    Buffer<VertexId> now(before.vertices, VertexId{});
    for (std::size_t v = 0; v < rows.vertices.size(); ++v)
        if (const VertexId origin = rows.vertices[v].origin; origin.valid()) now[origin.index()] = VertexId(v);
    const auto directions = [&](const DirectionsAtVertices<D>& original) {
        Buffer<DirectionRow> at;
        for (const DirectionRow& row : original.at)
            if (const VertexId v = now[row.vertex.index()]; v.valid()) at.push_back({v, row.row});
        return DirectionsAtVertices<D>{original.table, std::move(at)};
    };
    const auto associations = [&]<int G>(const Column<Association<G>>& original) {
        Buffer<Association<G>> on;
        for (Association<G> a : original)
            if (const VertexId v = now[a.item.index()]; v.valid()) {
                a.item = v;
                on.push_back(a);
            }
        return Column<Association<G>>(std::move(on));
    };
    const InputGeometry<D>& original = before.geometry;
    after.geometry = {directions(original.normals), directions(original.tangents), associations(original.on_points),
                      associations(original.on_curves), associations(original.on_surfaces)};
    after.groups = before.groups;
}

template <int D>
double shift_of(int turn) {
    if constexpr (D == 2)
        return std::array{0.0, 2.0 / 3, 1.0 / 3}[static_cast<std::size_t>(turn) % 3];
    else
        return std::array{0.0, 0.4, 0.2, 0.6, 0.8}[static_cast<std::size_t>(turn) % 5];
}

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

/// Runs preliminary iterations in which the mesh grows by a limited factor, so that blocks stay within the block size.
template <int D>
Outcome<RemeshedRows<D>> grow_gradually(RemeshedRows<D> rows, const AdaptationGoal<D>& goal,
                                        const ToMetricOptions& options, const BlockRemeshing& by,
                                        const StepWrapper& around) {
    constexpr double target_growth = 2.5, too_much = 4;
    constexpr int turns = 24;
    double before = 0;
    for (int k = 0; options.rounds > 0 && k < turns; ++k) {
        const auto now =
            run_step(around, "blocks", [&](const Execution& e) { return growing(rows.shared.rows, by.ranks, e); });
        if (!now) return fail(now.error());
        if (!(now->growth() > too_much)) break;
        if (!(now->elements > 1.5 * before)) break;  // stop: the last iteration hardly refined the mesh
        before = now->elements;
        const BlockIteration turn{.shift = shift_of<D>(k),
                                  .rounds = 1,
                                  .lengths = BlockIteration::Lengths::loose,
                                  .coarser = pow(now->growth() / target_growth, 1.0 / D)};
        auto turned = run_block_iteration(std::move(rows), goal, options, by, turn, around);
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
Outcome<RemeshedRows<D>> begin(Adaptation<D> state, const ToMetricOptions& options, const Ranks& ranks,
                               const StepWrapper& around) {
    if (auto checked = check_kind(state); !checked) return fail(checked.error());
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    const auto measured =
        run_step(around, "lengths", [&](const Execution& e) { return unit_mesh_statistics(state, e); });
    if (!measured) return fail(measured.error());
    RemeshedRows<D> shared_rows;
    shared_rows.statistics.before = *measured;
    shared_rows.original = {state.mesh.points.size(), state.mesh.geometry, state.mesh.groups};
    auto shared = run_step(around, "blocks", [&](const Execution&) -> Outcome<SharedRows<D>> {
        const auto rows = rows_of(state);
        if (!rows) return fail(rows.error());
        state = {};
        return share_of(*rows, ranks);
    });
    if (!shared) return fail(shared.error());
    shared_rows.shared = std::move(*shared);
    return shared_rows;
}
template <int D>
Outcome<RemeshResult<D>> end(const AdaptationRows<D>& rows, const InitialGeometry<D>& original,
                             const ToMetricStatistics& statistics, const StepWrapper& around) {
    auto whole = run_step(around, "blocks", [&](const Execution& e) { return assembled(rows, e); });
    if (!whole) return fail(whole.error());
    restore_input(original, rows, whole->state.mesh);
    const auto after =
        run_step(around, "lengths", [&](const Execution& e) { return unit_mesh_statistics(whole->state, e); });
    if (!after) return fail(after.error());
    RemeshResult<D> remeshed{std::move(whole->state), statistics};
    remeshed.statistics.after = *after;
    return remeshed;
}

}  // namespace

template <int D>
Outcome<RemeshedRows<D>> run_block_iteration(RemeshedRows<D> rows, const AdaptationGoal<D>& goal,
                                             const ToMetricOptions& options, const BlockRemeshing& by,
                                             const BlockIteration& turn, const StepWrapper& around) {
    return together(by.ranks, [&]() -> Outcome<RemeshedRows<D>> {
        auto cut = run_step(around, "blocks", [&](const Execution& e) {
            return expected_elements(rows.shared.rows, turn.coarser, e).and_then([&](const ElementWeights& weights) {
                return cut_into_parts(std::move(rows.shared), weights, by.elements, turn.shift, by.ranks, e);
            });
        });
        if (!cut) return fail(cut.error());
        const auto all = gather_all(by.ranks, remesh_blocks(cut->parts, goal, options_of(turn, options), around));
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
std::vector<BlockIteration> block_iterations(const ToMetricOptions& options) {
    using enum BlockIteration::Lengths;
    const int few = std::min(options.rounds, 2), one = std::min(options.rounds, 1);
    return {{.shift = shift_of<D>(0), .rounds = std::min(options.rounds, options.rounds / 2 + 1), .lengths = loose},
            {.shift = shift_of<D>(1), .rounds = few, .lengths = loose},
            {.shift = shift_of<D>(2), .rounds = few, .lengths = strict},
            {.shift = shift_of<D>(3), .rounds = one, .lengths = strict},
            {.shift = shift_of<D>(4), .rounds = 0, .lengths = strict}};
}

template <int D>
Outcome<RemeshedRows<D>> remesh_shared_rows(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                            const ToMetricOptions& options, const BlockRemeshing& by,
                                            const std::vector<BlockIteration>& turns, const StepWrapper& around) {
    return together(by.ranks, [&]() -> Outcome<RemeshedRows<D>> {
        auto remeshed = begin(std::move(state), options, by.ranks, around);
        if (!remeshed) return fail(remeshed.error());
        remeshed = grow_gradually(std::move(*remeshed), goal, options, by, around);
        for (const BlockIteration& turn : turns) {
            if (!remeshed) return remeshed;
            remeshed = run_block_iteration(std::move(*remeshed), goal, options, by, turn, around);
        }
        return remeshed;
    });
}

template <int D>
Outcome<RemeshResult<D>> remesh_by_blocks(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                          const ToMetricOptions& options, const BlockRemeshing& by,
                                          const std::vector<BlockIteration>& turns, const StepWrapper& around) {
    return together(by.ranks, [&]() -> Outcome<RemeshResult<D>> {
        auto remeshed = remesh_shared_rows(std::move(state), goal, options, by, turns, around);
        if (!remeshed) return fail(remeshed.error());
        const auto rows = run_step(around, "blocks",
                                   [&](const Execution&) { return gathered(std::move(remeshed->shared), by.ranks); });
        if (!rows) return fail(rows.error());
        return end(*rows, remeshed->original, remeshed->statistics, around);
    });
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Outcome<ElementWeights> expected_elements<D>(const AdaptationRows<D>&, double, const Execution&);       \
    template Outcome<RemeshedRows<D>> run_block_iteration<D>(RemeshedRows<D>, const AdaptationGoal<D>&,              \
                                                             const ToMetricOptions&, const BlockRemeshing&,          \
                                                             const BlockIteration&, const StepWrapper&);             \
    template std::vector<BlockIteration> block_iterations<D>(const ToMetricOptions&);                                \
    template Outcome<RemeshedRows<D>> remesh_shared_rows<D>(Adaptation<D>, const AdaptationGoal<D>&,                 \
                                                            const ToMetricOptions&, const BlockRemeshing&,           \
                                                            const std::vector<BlockIteration>&, const StepWrapper&); \
    template Outcome<RemeshResult<D>> remesh_by_blocks<D>(Adaptation<D>, const AdaptationGoal<D>&,                   \
                                                          const ToMetricOptions&, const BlockRemeshing&,             \
                                                          const std::vector<BlockIteration>&, const StepWrapper&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
