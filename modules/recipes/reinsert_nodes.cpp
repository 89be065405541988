module;
#include <string>
#include <utility>
module camber.recipes;
import camber.core;
import camber.adapt;
import camber.bezier;
import camber.cavity;
import camber.curving;
import camber.metric;
import camber.operation;
import camber.surface;
import camber.validity;
import :boundary;
import :curve_input;
import :metric_source;
import :propose;
import :reinsert_nodes;

namespace camber {

template <int D>
Outcome<ReinsertedNodes<D>> reinsert_nodes(const CurvedFrom<D>& from, const MetricSource<D>& metric,
                                           const ReinsertNodesOptions& options, const Around& around) {
    if (!has_field(options.curve.objective))
        return fail(ErrorKind::usage,
                    "reinsert: the objective " + std::string(word_of(options.curve.objective)) +
                        " is of whole meshes, not of cavities",
                    {}, {}, "take the stage curve, or another objective");
    auto start = begin_curving(from, metric, options.curve, around);
    if (!start) return fail(start.error());
    return run_step(around, "reinsert", [&](const Execution& e) -> Outcome<ReinsertedNodes<D>> {
        const BackMesh<D>& field = *start->field;
        auto moved =
            moved_input(from, std::move(start->input), field, start->edges, options.curve, without_progress(e));
        if (!moved) return fail(moved.error());
        auto wanted =
            curve(from.mesh, moved->kinds, moved->base, moved->shells, field, start->edges, part_of(e, 0, 0.2));
        if (!wanted) return fail(wanted.error());
        const Features<D>& features = from.boundary.features;
        const auto corners = corners_of(features);
        auto made = reinsert(from.mesh, wanted->proposal, {features.edge_kinds.view(), corners}, field,
                             options.cavities, part_of(e, 0.2, 1));
        if (!made) return fail(made.error());
        return ReinsertedNodes<D>{ProposedCurves<D>{std::move(*wanted), std::move(*moved), std::move(start->field),
                                                    std::move(start->straight_log_metrics), start->edges},
                                  std::move(*made)};
    });
}

#define CAMBER_INSTANTIATE(D)                                                                            \
    template Outcome<ReinsertedNodes<D>> reinsert_nodes<D>(const CurvedFrom<D>&, const MetricSource<D>&, \
                                                           const ReinsertNodesOptions&, const Around&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
