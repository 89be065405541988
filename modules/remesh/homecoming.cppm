module;
#include <cstddef>
export module camber.remesh:homecoming;
import camber.core;
import :rounds;
import :state;

namespace camber {

/// Vertices of surfaces and lines that are off the geometry go onto it, as far as elements around them bear it: their
/// cavities grow where that helps. Those that cannot go all of the way yet stay `astray`. Errors: of run_pass.
template <int D>
[[nodiscard]] Outcome<PassStatistics> bring_home(Remeshing<D>& r, const RemeshingGoal<D>& goal,
                                                 const Execution& execution);

}  // namespace camber
