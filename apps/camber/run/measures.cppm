module;
#include <cstddef>
#include <optional>
#include <span>
#include <vector>
module camber.run:measures;
import camber.config;
import camber.core;
import camber.curving;
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

}  // namespace camber::run
