module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>
module camber.run:measures;
import camber.config;
import camber.core;
import camber.crossing;
import camber.curving;
import camber.surface;
import camber.validity;
import :histogram;
import :report;
import :state;

namespace camber::run {

/// L_straight/L − 1 (paper eq. 8) of each edge; 0 where there are no lengths.
[[nodiscard]] std::vector<double> length_reductions(const Column<double>& straight, const Column<double>& lengths);

/// |P^l − M_11|/|P_20 − P_02| of each edge with these nodes; 0 for an edge of no length.
template <int D>
[[nodiscard]] std::vector<double> curvatures(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes);

/// Of which edges lengths are told: of all where the output shows them.
[[nodiscard]] MeasuredEdges reported_lengths(const config::Output& output);

/// Edges whose node is not in the middle of their chord.
template <int D>
[[nodiscard]] std::size_t bent_edges(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal);

/// Length reductions of the volume edges that have lengths, and curvatures of all.
template <int D>
[[nodiscard]] EdgeReport edge_report(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal,
                                     const Column<double>& straight, const Column<double>& lengths);

/// Of a run's end: length reductions, lengths and curvatures of the volume edges (where there are `lengths`, after
/// correction), scaled Jacobians of the elements, "before" (as `curve` left them) and "after" (in the end); lengths
/// also "straight". Without `curve` the Jacobians alone, as "count". Only what is known: no entry for a quantity that
/// was not measured. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<std::vector<Histogram>> run_histograms(const Quadratic<D>& end,
                                                             const std::optional<EdgeLengths>& lengths,
                                                             const History<D>& history, const Execution& execution);

/// Reports the deviation of entities of one kind from the geometry. `vertices`: the worst of them as a vertex or the
/// ends of an edge, from 1; 0: none. `at`: its position.
template <class Id, int D>
[[nodiscard]] DeviationReport deviation_report(const OffGeometry<Id>& of, double tolerance,
                                               const std::array<std::size_t, 2>& vertices, const Vec<D>& at) {
    DeviationReport report{
        .measured = of.measured, .off = of.off, .largest = of.largest, .share = of.share, .tolerance = tolerance};
    if (!of.worst.valid()) return report;
    report.vertices = vertices;
    report.at.assign(at.c.begin(), at.c.end());
    return report;
}

/// Reports pairs of facets; `box_of(facet)` locates the first one that crosses.
template <int D, class BoxOf>
[[nodiscard]] WallsReport walls_report(const Crossings& found, const BoxOf& box_of) {
    WallsReport report{.crossing = found.crossing, .touching = found.touching, .undecided = found.undecided};
    const auto first = std::ranges::find(found.found, Crossing::crossing, &FacetCrossing::verdict);
    if (first == found.found.end()) return report;
    report.first = first->first.index() + 1;
    report.other = first->second.index() + 1;
    const Box<D> a = box_of(first->first), b = box_of(first->second);
    for (int c = 0; c < D; ++c)
        report.first_at.push_back((std::max(a.low[c], b.low[c]) + std::min(a.high[c], b.high[c])) / 2);
    return report;
}

}  // namespace camber::run
