module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>
module camber.metric:edge_pack_begin;
import :back_mesh;
import :curved_back;
import :edge_minimiser;
import :edge_objective;
import :quadrature;
import :straight_back;
import :packs;
import :edge_wedge;
import :edge_pack_objective;
import :edge_pack_location;
import :edge_pack_search;
import :edge_pack_lanes;
import :edge_pack_curvature;
import camber.core;
import camber.bezier;

/// How eight searches begin: in the best of the sectors around their chords.
namespace camber {

/// The best of the sectors for each lane's chord, by what its model promises.
template <int D>
struct BestSector {
    ShellElementPack<D> element;
    VecPack<D> step;
    Pack slope{};
    Pack slot{};
    Pack change{};  ///< the most that log M changes to a vertex of the shell off the edge
};

template <int D>
[[nodiscard, gnu::always_inline]] inline BestSector<D> best_sector(const StraightBack<D>& back,
                                                                   std::span<const BackEdge> edges,
                                                                   const std::array<std::uint32_t, pack_size>& lanes,
                                                                   const ChordPack<D>& chords, const ChordFrame<D>& f,
                                                                   const ObjectiveSums<D>& sums, Pack curvature) {
    // R A Rᵀ.
    MatPack<D> transposed;
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < D; ++j) transposed(i, j) = f.axes(j, i);
    const SymPack<D> adjoint = congruence_transposed(transposed, sums.adjoint);
    const Pack by_b = inner(adjoint, chords.change);
    VecPack<D> common;
    for (int i = 0; i < D; ++i) common[i] = f.scale[i] * sums.common[i] + f.shift[i] * by_b;
    std::size_t most = 0;
    for (const std::uint32_t e : lanes) most = std::max(most, edges[e].shell.size());
    const SymPack<D> inverse_hessian = multiple_of_identity<D>(curvature);
    BestSector<D> best{};
    for (std::size_t slot = 0; slot < most; ++slot) {
        std::array<ElementId, pack_size> elements;
        for (int lane = 0; lane < pack_size; ++lane) {
            const auto& shell = edges[lanes[lane]].shell;
            elements[lane] = shell[std::min(slot, shell.size() - 1)];
        }
        const ShellElementPack<D> element = shell_elements(back, chords, elements);
        std::array<VecPack<D>, D - 1> rise;
        VecPack<D> gradient = common;
        for (int n = 0; n < D - 1; ++n) {
            rise[n] = in_frame(f, element.rise[n]);
            best.change = max(best.change, inner(element.change[n], element.change[n]));
            const Pack by_n = inner(adjoint, element.change[n]) - element.along[n] * by_b;
            for (int i = 0; i < D; ++i) gradient[i] += by_n * rise[n][i];
        }
        const WallStep<D> step = step_within<D>(rise, inverse_hessian, gradient, {});
        const Mask better = (step.slope < best.slope) | ((step.slope == best.slope) & after(step.step, best.step));
        choose(better, best.element, element);
        choose(better, best.step, step.step);
        best.slope = select(better, step.slope, best.slope);
        best.slot = select(better, packed(static_cast<double>(slot)), best.slot);
    }
    best.change = sqrt(best.change);
    return best;
}

template <int D>
[[gnu::always_inline]] inline void choose(Mask mask, BestSector<D>& to, const BestSector<D>& from) {
    choose(mask, to.element, from.element);
    choose(mask, to.step, from.step);
    to.slope = select(mask, from.slope, to.slope);
    to.slot = select(mask, from.slot, to.slot);
    to.change = select(mask, from.change, to.change);
}

template <int D>
struct PackedEdges {
    const StraightBack<D>& back;
    std::span<const BackEdge> edges;  ///< of the back mesh; none where they are free
    std::span<const FreeEdge<D>> free;
    const CurvedBack<D>* curved;           ///< the field, where it goes along with curves
    std::span<const std::uint32_t> order;  ///< in which they begin
    const EdgeRules& rules;
    const EdgeMinimiserOptions& options;
    std::span<EdgeMinimum<D>> minima;
    std::span<std::uint8_t> alone;  ///< 1: not for packs, or it turned out so; 2: its node is to be judged
    EdgeSearchWork& work;
};

/// How log M changes from end to end of an edge.
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack change_of(const SearchPack<D>& s) {
    return sqrt(inner(s.frame.change, s.frame.change));
}

/// Those of edges that do not resolve their field are not busy: they look at other places first.
template <int D>
[[gnu::always_inline]] inline void begin(const PackedEdges<D>& all, const std::array<std::uint32_t, pack_size>& lanes,
                                         int count, SearchLanes<D>& out) {
    SearchPack<D>& s = out.pack;
    s.y = {};
    s.attempts = s.steps = s.crossings = s.by_length = s.probed = packed(0);
    out.edge = lanes;
    std::array<VertexId, pack_size> a;
    std::array<VertexId, pack_size> b;
    for (int lane = 0; lane < pack_size; ++lane) {
        a[lane] = all.edges[lanes[lane]].a;
        b[lane] = all.edges[lanes[lane]].b;
    }
    const ChordPack<D> chords = chords_of(all.back, a, b);
    s.frame = chord_frame(chords);
    s.sums = sums_along(s.frame, ParabolaPack<D>{}, all.rules.objective);
    s.chord_length = s.sums.length.value;
    s.chord_unsure = unsure_share(s.sums) * s.chord_length;
    s.along = change_of(s);
    s.inverse_hessian = multiple_of_identity<D>(packed(1));
    BestSector<D> best = best_sector(all.back, all.edges, lanes, chords, s.frame, s.sums.energy, packed(1));
    s.change = max(s.along, best.change);
    const Mask unresolved = ~(s.change < max_change);
    if (all.options.objective == EdgeObjectiveKind::length && any(unresolved)) {
        // These begin by the length.
        const Pack curvature = 2 * s.chord_length;
        choose(unresolved, best, best_sector(all.back, all.edges, lanes, chords, s.frame, s.sums.length, curvature));
        choose(unresolved, s.inverse_hessian, multiple_of_identity<D>(curvature));
        s.by_length = select(unresolved, packed(1), packed(0));
    }
    s.wedge = wedge_of(s.frame, best.element);
    s.at = s.on_chord = values_in(s.frame, s.wedge, s.sums);
    s.direction = best.step;
    s.slope = best.slope;
    // Which sector is best the identity tells; what the first step is, the curvature there.
    choose(~unresolved, s.inverse_hessian, inverse_hessian_at_chord(s.frame, s.wedge));
    const WallStep<D> first = step_within<D>(s.wedge.rise, s.inverse_hessian, s.at.energy_gradient, s.y);
    choose(~unresolved, s.direction, first.step);
    s.slope = select(~unresolved, first.slope, s.slope);
    s.step = reach(s, all.options);
    const Mask promising = -s.slope > all.options.tolerance * value_of(s.at, s.by_length != 0);
    for (int lane = 0; lane < pack_size; ++lane) {
        out.element[lane] = all.edges[lanes[lane]].shell[static_cast<std::size_t>(best.slot[lane])];
        const bool regular = s.chord_length[lane] > 0 && s.chord_length[lane] < 1e300 && s.change[lane] < 1e300;
        if (!regular) all.alone[lanes[lane]] = 1;
        if (!regular || lane >= count) s.change[lane] = 0;
        const bool resolved = s.change[lane] < max_change;
        s.busy[lane] = promising[lane] != 0 && regular && resolved && lane < count ? 1 : 0;
    }
    all.work.decompositions += static_cast<std::size_t>(count) * (1 + all.rules.objective.size());
}

}  // namespace camber
