module;
#include <optional>
#include <utility>
#include <variant>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.curving;
import camber.metric;
import :curve_input;
import :field;
import :metric_source;

namespace camber {

template <int D>
Outcome<BackMesh<D>> make_field(const LinearMesh<D>& mesh, const MetricSource<D>& metric, const Execution& execution) {
    if (const auto* field = std::get_if<MetricField<D>>(&metric)) return field->make(execution);
    const auto& source = std::get<MetricAtVertices<D>>(metric);
    const auto around = balls(mesh, part_of(execution, 0, 0.1));
    if (!around) return fail(around.error());
    Column<LogMetric<D>> natural;
    if (source.of_natural) {
        auto made = natural_log_metrics(mesh, *around, part_of(execution, 0.1, 0.5));
        if (!made) return fail(made.error());
        natural = std::move(*made);
    }
    auto logs = source.make(natural, part_of(execution, 0.5, 0.65));
    if (!logs) return fail(logs.error());
    return make_back_mesh(mesh, *around, std::move(*logs), part_of(execution, 0.65, 1));
}

template <int D>
Outcome<BackMesh<D>> make_field(const QuadraticMesh<D>& mesh, const MetricSource<D>& metric,
                                const Execution& execution) {
    if (const auto* field = std::get_if<MetricField<D>>(&metric)) return field->make(execution);
    const auto& source = std::get<MetricAtVertices<D>>(metric);
    const auto around = balls(mesh.linear, part_of(execution, 0, 0.1));
    if (!around) return fail(around.error());
    Column<LogMetric<D>> natural;
    if (source.of_natural) {
        auto made = curved_natural_log_metrics(mesh, *around, part_of(execution, 0.1, 0.5));
        if (!made) return fail(made.error());
        natural = std::move(made->curved);
    }
    auto logs = source.make(natural, part_of(execution, 0.5, 0.65));
    if (!logs) return fail(logs.error());
    auto nodal = framed_logs(mesh.edges, std::move(*logs), part_of(execution, 0.65, 0.7));
    if (!nodal) return fail(nodal.error());
    return make_nodal_back_mesh(mesh, *around, std::move(*nodal), part_of(execution, 0.7, 1));
}

namespace {

/// The metric of the mesh with its curves, and of the one with straight edges.
template <int D>
struct BothMetrics {
    Column<LogMetric<D>> curved, straight;
};
template <int D>
Outcome<BothMetrics<D>> both_metrics(const MetricAtVertices<D>& source, const QuadraticMesh<D>& bent,
                                     const Incidence<ElementId>& around, const Execution& execution) {
    Column<LogMetric<D>> of_curved, of_straight;
    if (source.of_natural) {
        auto made = curved_natural_log_metrics(bent, around, part_of(execution, 0, 0.85));
        if (!made) return fail(made.error());
        of_curved = std::move(made->curved);
        of_straight = std::move(made->straight);
    }
    auto curved = source.make(of_curved, part_of(execution, source.of_natural ? 0.85 : 0, 1));
    if (!curved) return fail(curved.error());
    if (!source.of_natural) return BothMetrics<D>{*curved, *curved};
    auto straight = source.make(of_straight, without_progress(execution));
    if (!straight) return fail(straight.error());
    return BothMetrics<D>{std::move(*curved), std::move(*straight)};
}

template <int D>
Outcome<CurvingField<D>> curved_field(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                      const MetricAtVertices<D>& source, CurvingAim aim, const Execution& execution) {
    // Shares of the time with the natural metric, of shells with layers, 1 and 5 million elements.
    const auto around = balls(mesh.linear, part_of(execution, 0, 0.05));
    if (!around) return fail(around.error());
    QuadraticMesh<D> bent = mesh;
    bent.mid_nodes = input.extended;
    auto metrics = both_metrics<D>(source, bent, *around, part_of(execution, 0.05, 0.37));
    if (!metrics) return fail(metrics.error());
    auto starts = noticeable_nodes(mesh, input.extended.view(), metrics->curved, part_of(execution, 0.37, 0.44));
    if (!starts) return fail(starts.error());
    Column<LagrangeNode<D>> nodes(std::move(*starts));
    auto of_back_mesh = back_mesh_nodes(mesh, nodes.view(), input.shells, part_of(execution, 0.44, 0.64));
    if (!of_back_mesh) return fail(of_back_mesh.error());
    bent.mid_nodes = std::move(*of_back_mesh);
    auto back = make_curved_back_mesh(std::move(bent), *around, std::move(metrics->curved), part_of(execution, 0.64, 1),
                                      aim == CurvingAim::accuracy ? KeptGradients::seen : KeptGradients::recovered);
    if (!back) return fail(back.error());
    // Searches begin where the back mesh has their edges; nodes for accuracy, whose offsets are asked for there, follow
    // walls that hardly sag, too: functions that are smooth mind them.
    if (aim == CurvingAim::accuracy) nodes = input.extended;
    return CurvingField<D>{std::move(*back), std::move(metrics->straight), std::move(nodes)};
}

}  // namespace

template <int D>
Outcome<CurvingField<D>> make_curving_field(const QuadraticMesh<D>& mesh, const CurveInput<D>& input,
                                            const MetricSource<D>& metric, CurvingAim aim, const Execution& execution) {
    const auto* const at_vertices = std::get_if<MetricAtVertices<D>>(&metric);
    if (at_vertices != nullptr && !input.extended.empty())
        return curved_field(mesh, input, *at_vertices, aim, execution);
    auto back = make_field(mesh.linear, metric, execution);
    if (!back) return fail(back.error());
    return CurvingField<D>{std::move(*back), {}, {}};
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template Outcome<BackMesh<D>> make_field<D>(const LinearMesh<D>&, const MetricSource<D>&, const Execution&);    \
    template Outcome<BackMesh<D>> make_field<D>(const QuadraticMesh<D>&, const MetricSource<D>&, const Execution&); \
    template Outcome<CurvingField<D>> make_curving_field<D>(const QuadraticMesh<D>&, const CurveInput<D>&,          \
                                                            const MetricSource<D>&, CurvingAim, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
