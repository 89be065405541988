module;
#include <cstddef>
module camber.adapt:snap;
import camber.core;
import camber.operation;

namespace camber {

/// Vertices of surfaces and lines that are off the geometry go onto it, as far as elements around them bear it: their
/// cavities grow where that helps. Those that cannot go all of the way yet stay `off_geometry`. Errors: of run_pass.
template <int D>
[[nodiscard]] Outcome<PassStatistics> snap_to_geometry(Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                                       const Execution& execution);

}  // namespace camber
