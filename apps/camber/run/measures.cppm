module;
#include <cstddef>
#include <span>
#include <vector>
export module camber.run:measures;
import camber.core;
import :histogram;
import :state;

namespace camber::run {

/// L_straight/L − 1 (paper eq. 8) of each edge; 0 where there are no lengths (boundary edges).
[[nodiscard]] std::vector<double> length_gains(const Column<double>& straight, const Column<double>& lengths);

/// |P^l − M_11|/|P_20 − P_02| of each edge with these nodes; 0 for an edge of no length.
template <int D>
[[nodiscard]] std::vector<double> curvatures(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes);

/// Of the state at a run's end: gains, lengths and curvatures of the volume edges, normalised Jacobians of the
/// elements, "before" (as `curve` left them) and "after" (in the end); lengths also "straight". Without `curve` the
/// Jacobians alone, as "count". Only what is known: no entry for a quantity that was not measured.
template <int D>
[[nodiscard]] std::vector<Histogram> run_histograms(const State<D>& state);

}  // namespace camber::run
