module;
#include <string>
#include <vector>
export module camber.run:plot;
import :histogram;

export namespace camber::run {

/// A histogram as an SVG picture: a panel for the mesh before correction and one for after (or one alone), on the same
/// axes, the mean marked; lengths of the straight edges as an outline behind. Bins beyond the first and the last limit
/// are paler. Empty bins at the ends are left out.
[[nodiscard]] std::string svg(const Histogram& histogram);

/// All of them below each other in one picture.
[[nodiscard]] std::string svg(const std::vector<Histogram>& histograms);

}  // namespace camber::run
