module;
#include <cstddef>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.config;
import camber.curving;
import camber.distributed;
import camber.metric;
import camber.operation;
import camber.adapt;
import camber.surface;
import camber.recipes;
import camber.validity;
import :histogram;
import :order;
import :parts;
import :report;
import :runner;
import :stages;
import :state;
import :steps;
import :unit_mesh;
import :unit_mesh_of_ranks;

namespace camber::run {

namespace {

/// What passes put nodes of inner edges for.
RemeshedNodesReport remeshed_nodes(CurvingAim aim) {
    const Objective objective = aim == CurvingAim::accuracy ? Objective::accuracy
                                : aim == CurvingAim::energy ? Objective::energy
                                                            : Objective::length;
    return {.objective = std::string(word_of(objective))};
}

/// Whether a stage after the last pass places inner edges' nodes anew.
bool places_nodes_anew(const config::Pipeline& pipeline) {
    bool anew = false;
    for (const config::Stage& stage : pipeline.stages)
        std::visit(
            [&]<class Options>(const Options&) {
                if (changes_topology<Options>()) anew = false;
                if (std::is_same_v<Options, config::Curve> || std::is_same_v<Options, config::Reinsert>) anew = true;
            },
            stage);
    return anew;
}

/// Beside the histograms before those after.
std::vector<Histogram> with_after(std::vector<Histogram> histograms, const std::vector<Histogram>& after) {
    for (std::size_t i = 0; i < histograms.size(); ++i) histograms[i].series.push_back(after[i].series.front());
    return histograms;
}

/// What ranks share in the end stays with them.
template <int D>
Outcome<Done> finish_rows(Runner<D>& run, Changing<D>& changing) {
    BroughtRows<D> brought = std::move(*changing.shared);
    std::optional<UnitMeshOfRanks> measured;
    auto made = run.step("finish", [&](const Execution& e) -> Outcome<FinishedRows<D>> {
        const auto own = measured_rows(brought.shared, *run.ranks, part_of(e, 0, 0.5));
        if (!own) return fail(own.error());
        auto all = unit_mesh_of_ranks(changing.metric.source, *own, *run.ranks);
        if (!all) return fail(all.error());
        measured = std::move(*all);
        return finished_rows(std::move(brought.shared), brought.given, *run.ranks);
    });
    if (!made) return fail(made.error());
    run.report(
        FinishedReport{std::move(measured->report), with_after(std::move(changing.histograms), measured->histograms)});
    run.state.rows = std::move(*made);
    run.state.mesh = LinearMesh<D>{};
    return Done{};
}

}  // namespace

template <int D>
Outcome<Done> finish(Runner<D>& run) {
    auto* const changing = std::get_if<Changing<D>>(&run.state.mesh);
    if (changing == nullptr) return Done{};
    if (changing->shared) return finish_rows(run, *changing);
    UnitMesh measured;
    std::optional<VerdictsReport> verdicts;  // of degree 2: what was told before is of the mesh before
    std::optional<RemeshedNodesReport> placed_for;
    auto made = run.step("finish", [&](const Execution& e) -> Outcome<FinishedMesh<D>> {
        auto mesh = finished(changing->mesh, part_of(e, 0, 0.6));
        if (!mesh) return mesh;
        changing->mesh = {};  // as large as what was made of it
        const auto& [linear, edges, nodes, maps] = mesh->compact;
        const Execution rest = part_of(e, 0.6, 1);
        const std::string& metric = changing->metric.source;
        if (!nodes.empty()) {
            auto validation = validate(QuadraticMesh<D>{linear, edges, nodes}, run.state.bound, without_progress(e));
            if (!validation) return fail(validation.error());
            verdicts = verdicts_report(*validation, run.state.bound.is_asked);
            if (!places_nodes_anew(run.config)) placed_for = remeshed_nodes(run.state.curving.aim);
        }
        auto in_metric =
            nodes.empty() ? measure_unit_mesh(linear, edges, mesh->log_metrics, metric, rest)
                          : measure_unit_mesh(QuadraticMesh<D>{linear, edges, nodes}, mesh->log_metrics, metric, rest);
        if (!in_metric) return fail(in_metric.error());
        measured = std::move(*in_metric);
        return mesh;
    });
    if (!made) return fail(made.error());
    auto histograms = with_after(std::move(changing->histograms), histograms_of(measured, "remeshed"));
    run.report(FinishedReport{std::move(measured.report), std::move(histograms)});
    if (verdicts) run.report(*verdicts);
    if (placed_for) run.report(FinishedNodesReport{std::move(*placed_for)});
    const bool has_mesh = file_with_mesh(run.config, run.files) != nullptr;
    run.state.inherited = Inherited<D>{
        std::move(*changing->goal.geometry), std::move(made->log_metrics), std::move(changing->metric),
        has_mesh ? std::optional(std::move(changing->goal.field)) : std::nullopt, std::move(changing->goal.curves)};
    run.state.given_points = made->compact.mesh.points;
    run.state.given_nodes = {};
    auto& [linear, edges, nodes, maps] = made->compact;
    if (nodes.empty())
        run.state.mesh = std::move(linear);
    else {
        run.state.given_nodes = Column<LagrangeNode<D>>(std::move(nodes));
        run.state.mesh = Quadratic<D>{{std::move(linear), std::move(edges), run.state.given_nodes}, NodesOf::input, {}};
    }
    return Done{};
}

#define CAMBER_INSTANTIATE(D) template Outcome<Done> finish<D>(Runner<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
