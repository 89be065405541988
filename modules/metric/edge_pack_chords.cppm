module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
module camber.metric:edge_pack_chords;
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
import :edge_pack_begin;
import camber.core;
import camber.bezier;

/// How eight searches for edges that are not the back mesh's begin: at their chords, of which each point is located.
/// The energy's Hessian with the metric frozen is the identity, so that the first step is minus the gradient: the first
/// of the geodesic equation, with the slopes of the elements that the chord passes.
namespace camber {

template <int D>
[[nodiscard, gnu::always_inline]] inline ChordPack<D> chords_of(const PackedEdges<D>& all,
                                                                const std::array<std::uint32_t, pack_size>& lanes) {
    ChordPack<D> c{};
    for (int lane = 0; lane < pack_size; ++lane) {
        const FreeEdge<D>& edge = all.free[lanes[lane]];
        put(c.origin, lane, edge.a.point);
        put(c.chord, lane, edge.b.point - edge.a.point);
        put(c.log_metric, lane, edge.a.log_metric.l);
        put(c.change, lane, edge.b.log_metric.l - edge.a.log_metric.l);
    }
    return c;
}

/// Where the field goes along with curves its places are not those of the straight mesh.
template <int D>
[[nodiscard]] bool is_bent(const PackedEdges<D>& all, const PointElements<D>& points, int lane) {
    return all.curved != nullptr &&
           std::ranges::any_of(points, [&](const auto& at) { return all.curved->is_bent(at.element[lane]); });
}

/// Those of edges that do not resolve their field are not busy, as in `begun`. What log M changes by is that of the
/// elements where the chord's points are: between these it may be more.
template <int D>
[[nodiscard, gnu::always_inline]] inline SearchLanes<D> begun_at_chords(
    const PackedEdges<D>& all, const std::array<std::uint32_t, pack_size>& lanes, int count) {
    SearchLanes<D> out{};
    SearchPack<D>& s = out.pack;
    out.edge = lanes;
    for (int lane = 0; lane < pack_size; ++lane) out.element[lane] = all.free[lanes[lane]].hint;
    s.frame = chord_frame(chords_of(all, lanes));
    const std::size_t n_points = all.rules.objective.size();
    const ElementsPack<D> at = entered<D>(all.back, out.element);
    PointElements<D> points{};
    for (std::size_t q = 0; q < max_points; ++q) points[q] = at;
    WalkMarks marks{};
    s.at = located_values(all.back, s.frame, s.y, all.rules.objective, points, marks);
    s.chord_length = s.at.length;
    s.change = change_of(s) + sqrt(s.at.bulge);
    for (std::size_t q = 0; q < n_points; ++q)
        for (const SymPack<D>& change : points[q].change) s.change = max(s.change, sqrt(inner(change, change)));
    s.along = s.change;
    // Those that do not resolve their field begin by the length, where that is asked for.
    const Mask by_length = ~(s.change < max_change) & Mask(all.options.objective == EdgeObjectiveKind::length ? -1 : 0);
    s.by_length = select(by_length, packed(1), packed(0));
    s.inverse_hessian = multiple_of_identity<D>(select(by_length, 2 * s.chord_length, packed(1)));
    const VecPack<D> gradient = gradient_of(s.at, by_length);
    s.direction = times(s.inverse_hessian, gradient);
    for (int i = 0; i < D; ++i) s.direction[i] = -s.direction[i];
    s.slope = dot(gradient, s.direction);
    s.step = reach(s, all.options);
    const Mask promising = -s.slope > all.options.tolerance * value_of(s.at, by_length);
    const Mask found =
        ~(marks.lost | marks.outside) & (s.chord_length > 0) & (s.chord_length < 1e300) & (s.change < 1e300);
    for (int lane = 0; lane < pack_size; ++lane) {
        const bool regular = found[lane] != 0 && !is_bent(all, points, lane);
        if (!regular) all.alone[lanes[lane]] = 1;
        if (!regular || lane >= count) s.change[lane] = 0;
        s.busy[lane] = promising[lane] != 0 && regular && s.change[lane] < max_change && lane < count ? 1 : 0;
    }
    all.work.decompositions += static_cast<std::size_t>(count) * (1 + n_points);
    return out;
}

/// Chords by the finer rule, where what stands for them leaves its elements.
template <int D>
[[nodiscard, gnu::always_inline]] inline Pack chord_length(const PackedEdges<D>& all, const SearchLanes<D>& lanes,
                                                           WalkMarks& marks) {
    const ChordFrame<D>& f = lanes.pack.frame;
    if (all.free.empty()) return length_along(f, ParabolaPack<D>{}, all.rules.report);
    ElementsPack<D> elements = entered<D>(all.back, lanes.element);
    return located_lengths(all.back, f, VecPack<D>{}, all.rules.report, elements, marks).length;
}

}  // namespace camber
