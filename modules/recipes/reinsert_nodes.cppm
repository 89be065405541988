module;
#include <tuple>
export module camber.recipes:reinsert_nodes;
import camber.core;
import camber.adapt;
import camber.bezier;
import camber.curving;
import camber.validity;
import :curve_input;
import :metric_source;
import :propose;

export namespace camber {

/// With the stages' own options for the cavities.
struct ReinsertNodesOptions {
    ProposeOptions curve = {};
    ReinsertionOptions cavities = {};
};

/// Nodes that cavities brought to where they were wanted, as far as elements allow.
template <int D>
struct ReinsertedNodes {
    ProposedCurves<D> wanted;
    Reinserted<D> made;
};

/// The paper's global algorithm (§4) on a mesh of degree 2: its nodes are wanted as `propose_curves` has them, and
/// every vertex is put in again. Steps: extension, metric, reinsert. Errors: the objective shape (usage); those of
/// propose_curves and reinsert.
template <int D>
[[nodiscard]] Outcome<ReinsertedNodes<D>> reinsert_nodes(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                                         const ReinsertNodesOptions& options, const Around& around);

}  // namespace camber
