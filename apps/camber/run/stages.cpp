module;
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include <fmt/format.h>
module camber.run;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.config;
import camber.metric;
import camber.surface;
import camber.validity;
import camber.programmes;
import camber.curving;
import camber.repair;
import :measures;
import :report;
import :stages;
import :state;

namespace camber::run {

namespace {

Outcome<Done> need(bool there, const char* stage, const char* before) {
    if (there) return Done{};
    return fail(ErrorKind::usage, std::string("stage \"") + stage + "\" needs \"" + before + "\" before it");
}

template <int D>
Outcome<Done> need_curves(const State<D>& state, const char* stage) {
    if (state.quadratic()) return Done{};
    return fail(ErrorKind::input,
                std::string("the mesh is of degree 1, and stage \"") + stage + "\" needs one of degree 2", {}, {},
                "camber curve makes it curved; in a config, put \"elevate\" before");
}

/// The mid nodes of the straight mesh.
template <int D>
Outcome<Buffer<LagrangeNode<D>>> chord_middles(const QuadraticMesh<D>& mesh, const Execution& execution) {
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        return LagrangeNode<D>{midpoint(mesh.linear.points[a], mesh.linear.points[b])};
    });
}

/// Gains and curvatures of the volume edges with the given lengths.
template <int D>
EdgeReport edge_report(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const Column<double>& straight,
                       const Column<double>& lengths) {
    const auto gains = length_gains(straight, lengths);
    const auto curved = curvatures<D>(mesh, proposal.mid_nodes.view());
    EdgeReport r;
    std::size_t n = 0;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        if (proposal.kinds[e] != EdgeKind::volume) continue;
        r.mean_gain += gains[e];
        r.largest_gain = std::max(r.largest_gain, gains[e]);
        r.mean_curvature += curved[e];
        r.largest_curvature = std::max(r.largest_curvature, curved[e]);
        r.longer += gains[e] < 0;
        ++n;
    }
    if (n > 0) {
        r.mean_gain /= static_cast<double>(n);
        r.mean_curvature /= static_cast<double>(n);
    }
    return r;
}

EdgeMinimiserOptions edge_options(const config::Curve& options) {
    EdgeMinimiserOptions edge = options;
    edge.objective =
        options.objective == config::Objective::energy ? EdgeObjectiveKind::energy : EdgeObjectiveKind::length;
    return edge;
}

/// Models of what a node off its wanted place costs: in the field, or in the mesh's own metric where there is none.
template <int D>
Outcome<Column<QuadraticModel<D>>> models_of(const State<D>& state, const Execution& execution) {
    auto around =
        state.shells ? Outcome<Incidence<ElementId>>(*state.shells) : shells(state.quadratic()->edges, execution);
    if (!around) return fail(around.error());
    if (state.adopted && !state.back) return own_models(*state.judged, *around, execution);
    const Column<LagrangeNode<D>>& wanted = state.curved ? state.curved->proposal.mid_nodes : state.proposal->mid_nodes;
    auto models = state.back
                      ? edge_models(*state.quadratic(), wanted, *state.validation, *around, *state.back, execution)
                      : implied_edge_models(*state.quadratic(), wanted, *around, execution);
    if (!models) return fail(models.error());
    return Column<QuadraticModel<D>>(std::move(*models));
}

constexpr const char* starts_from_file =
    "volume edges: the search begins at the node that the mesh was read with, where that is the better start";

/// Where boundary nodes are wanted: on the geometry; in a mesh that was read with its curves where they are, but for
/// edges on prescribed surfaces.
template <int D>
Outcome<Buffer<LagrangeNode<D>>> wanted_boundary(const State<D>& state, Report& report, const Execution& execution) {
    const bool keeps = state.required == RequiredBoundary::keep;
    const QuadraticMesh<D>& mesh = *state.quadratic();
    auto nodes = boundary_nodes(keeps ? mesh : without_required(mesh), *state.features, *state.geometry, execution);
    if (!nodes || !state.read_curved) return nodes;
    const auto around = facet_shells(mesh.edges, execution);
    if (!around) return fail(around.error());
    std::size_t kept = 0;
    for (std::size_t e = 0; e < nodes->size(); ++e) {
        if (state.features->edge_kinds[e] == EdgeKind::volume) continue;
        const bool is_prescribed = std::ranges::any_of(
            (*around)[e], [&](FacetId f) { return (*state.geometry)->prescribes(mesh.linear.facets.references[f]); });
        if (is_prescribed) continue;
        (*nodes)[e] = mesh.mid_nodes[e];
        ++kept;
    }
    report.notices.push_back(fmt::format("{} edges of the boundary keep the nodes that the mesh was read with", kept));
    return nodes;
}

/// The proposal of `shape` as one of `curve`, without lengths: there is no field to measure them in.
template <int D>
Outcome<Curved<D>> shaped(const QuadraticMesh<D>& mesh, const Column<EdgeKind>& kinds,
                          const Column<LagrangeNode<D>>& boundary_nodes, const Incidence<ElementId>& shells,
                          const Execution& execution) {
    auto done = shape(mesh, kinds, boundary_nodes, shells, ShapeOptions{}, execution);
    if (!done) return fail(done.error());
    const std::size_t n = mesh.edges.size();
    Curved<D> curved{std::move(done->proposal), Buffer<double>(n, 0.0), Buffer<double>(n, 0.0), {}};
    for (std::size_t e = 0; e < n; ++e) {
        if (kinds[e] != EdgeKind::volume) continue;
        ++curved.statistics.volume_edges;
        curved.statistics.curved_edges += curved.proposal.mid_nodes[e] != mesh.mid_nodes[e];
    }
    return curved;
}

template <int D>
CurveReport curve_report(const QuadraticMesh<D>& mesh, const Curved<D>& curved, double seconds) {
    const CurveStatistics& s = curved.statistics;
    return {mesh.edges.size(),
            s.volume_edges,
            s.curved_edges,
            s.polished,
            s.exhausted,
            s.shortened,
            s.outside,
            s.lost,
            edge_report(mesh, curved.proposal, curved.straight_lengths, curved.lengths),
            {},
            static_cast<double>(s.volume_edges) / std::max(seconds, 1e-9)};
}

template <int D>
ValidityReport validity_report(const Validation<D>& v) {
    return {
        v.bound, v.invalid, v.undecided, v.straight_inverted, v.smallest, v.worst.valid() ? v.worst.index() + 1 : 0};
}

void add(const RepairStatistics& s, RepairMethod method, RelaxReport& sum) {
    sum.repair = word_of(method);
    sum.corrected_elements += s.corrected_elements;
    sum.relaxed_volume_edges += s.moved_volume_nodes;
    sum.relaxed_surface_edges += s.moved_surface_nodes;
    sum.moved_vertices += s.moved_vertices;
    sum.work += s.work;
}

template <int D>
void list_failures(const Validation<D>& v, Report& report) {
    report.invalid_elements.clear();
    report.undecided_elements.clear();
    for (std::size_t e = 0; e < v.verdicts.size(); ++e) {
        if (v.verdicts[e] == Verdict::invalid) report.invalid_elements.push_back(e + 1);
        if (v.verdicts[e] == Verdict::undecided) report.undecided_elements.push_back(e + 1);
    }
}

template <int D>
void enter(Validation<D> validation, State<D>& state, Report& report) {
    report.validity = validity_report(validation);
    list_failures(validation, report);
    state.validation = std::move(validation);
}

template <int D>
void enter(JudgedProposal<D> judged, State<D>& state, Report& report) {
    enter(judged.validation(), state, report);
    state.proposal = judged.proposal();
    state.judged = std::move(judged);
}

/// The state's proposal judged, as the last stage left it or anew.
template <int D>
Outcome<JudgedProposal<D>> judged_proposal(const State<D>& state, double bound, const Execution& execution) {
    if (state.judged && state.judged->validation().bound == bound) return *state.judged;
    return validate(*state.quadratic(), *state.proposal, bound, execution);
}

}  // namespace

template <int D>
Outcome<State<D>> elevate_stage(State<D> state, Report& report, const Execution& execution) {
    if (state.quadratic())
        return fail(
            ErrorKind::input, "the mesh is quadratic already", {}, {},
            "give the straight one, or leave the stage \"elevate\" out: stages=[\"curve\", \"validate\", \"relax\", "
            "\"commit\"]");
    auto mesh = elevate(state.linear(), execution);
    if (!mesh) return fail(mesh.error());
    state.mesh = std::move(*mesh);
    report.mesh.degree = 2;
    report.mesh.nodes = state.linear().points.size() + state.quadratic()->edges.size();
    return state;
}

template <int D>
Outcome<State<D>> surface_stage(State<D> state, const config::Features& options, const config::Geometry& geometry,
                                Report& report, const Execution& execution) {
    if (!state.quadratic())
        return fail(ErrorKind::usage, "stages \"curve\" and \"reinsert\" need \"elevate\" before them");
    FeatureOptions<D> feature_options;
    feature_options.ridge_angle_degrees = options.ridge_angle;
    auto features = find_features(state.linear(), state.quadratic()->edges, feature_options, execution);
    if (!features) return fail(features.error());
    report.boundary = BoundaryReport{
        features->surface_edges, features->ridge_edges, features->corners, features->patch_count, {}, {}};
    state.features = std::move(*features);
    state.required = options.required_boundary;
    auto made = make_geometry(geometry, state, execution);
    if (!made) return fail(made.error());
    state.geometry = std::move(*made);
    return state;
}

template <int D>
Outcome<State<D>> metric_stage(State<D> state, const config::Metric& metric, const std::optional<MetricFile>& file,
                               std::span<const config::MetricOperation> operations,
                               std::span<const MetricFile> operands, Report& report, const Execution& execution) {
    auto around = balls(state.linear(), execution);
    if (!around) return fail(around.error());
    report.metric = MetricReport{};
    auto log_metrics = make_log_metrics(metric, file, state, report, execution);
    if (!log_metrics) {
        Error error = log_metrics.error();
        if (error.kind == ErrorKind::usage && error.where.empty()) error.where = "/metric";
        return fail(std::move(error));
    }
    log_metrics = operated(std::move(*log_metrics), operations, operands, state, report, execution);
    if (!log_metrics) return fail(log_metrics.error());
    auto volume = complexity(state.linear(), *log_metrics, execution);
    if (!volume) return fail(volume.error());
    report.metric->complexity = *volume;
    auto largest = reduce_each(
        execution, log_metrics->size(), 1.0,
        [&](double& most, std::size_t v) { most = std::max(most, anisotropy((*log_metrics)[v])); },
        [](double a, double b) { return std::max(a, b); });
    if (!largest) return fail(largest.error());
    report.metric->largest_anisotropy = *largest;
    auto back = make_back_mesh(state.linear(), *around, std::move(*log_metrics), execution);
    if (!back) return fail(back.error());
    state.back = std::move(*back);
    return state;
}

template <int D>
Outcome<State<D>> curve_stage(State<D> state, const config::Curve& options, Report& report,
                              const Execution& execution) {
    const QuadraticMesh<D>& mesh = *state.quadratic();
    auto around = shells(mesh.edges, execution);
    if (!around) return fail(around.error());
    state.shells = std::move(*around);
    auto boundary = wanted_boundary(state, report, execution);
    if (!boundary) return fail(boundary.error());
    const auto kinds = held_kinds(mesh, state.features->edge_kinds, state.required);

    if (state.read_curved && options.objective != config::Objective::shape)
        report.notices.emplace_back(starts_from_file);
    const auto begin = std::chrono::steady_clock::now();
    const Column<LagrangeNode<D>> nodes(std::move(*boundary));
    auto curved = options.objective == config::Objective::shape
                      ? shaped(mesh, kinds, nodes, *state.shells, execution)
                      : curve(mesh, kinds, nodes, *state.shells, *state.back, edge_options(options), execution);
    if (!curved) return fail(curved.error());
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;

    report.curve = curve_report(mesh, *curved, seconds.count());
    state.propose(curved->proposal);
    state.adopted = false;
    state.curved = std::move(*curved);
    return state;
}

template <int D>
Outcome<State<D>> validate_stage(State<D> state, const config::Validate& options, Report& report,
                                 const Execution& execution) {
    if (auto ok = need_curves(state, "validate"); !ok) return fail(ok.error());
    if (state.proposal) {
        auto judged = judged_proposal(state, options.min_scaled_jacobian, execution);
        if (!judged) return fail(judged.error());
        enter(std::move(*judged), state, report);
    } else {
        auto validation = validate(*state.quadratic(), options.min_scaled_jacobian, execution);
        if (!validation) return fail(validation.error());
        enter(std::move(*validation), state, report);
    }
    if (!report.relax) {
        report.validity_before = report.validity;
        state.first_validation = state.validation;
    }
    return state;
}

template <int D>
Outcome<State<D>> relax_stage(State<D> state, const config::Relax& options, Report& report,
                              const Execution& execution) {
    if (auto ok = need_curves(state, "relax"); !ok) return fail(ok.error());
    if (auto ok = need(state.proposal.has_value(), "relax", "curve"); !ok) return fail(ok.error());
    if (!state.judged || state.judged->validation().bound != options.min_scaled_jacobian) {
        const config::Validate bound{.min_scaled_jacobian = options.min_scaled_jacobian};
        auto validated = validate_stage(std::move(state), bound, report, execution);
        if (!validated) return fail(validated.error());
        state = std::move(*validated);
    }
    Column<QuadraticModel<D>> models;
    if (needs_models(options.method)) {
        auto made = models_of(state, execution);
        if (!made) return fail(made.error());
        models = std::move(*made);
    }
    const bool keeps_boundary = state.boundary_is_given();
    auto repaired =
        (keeps_boundary ? repair_within<D> : repair_or_straighten<D>)(*state.judged, models, options, execution);
    if (!repaired) return fail(repaired.error());
    // After the cavities' own relaxation: what both did.
    RelaxReport& sum = report.relax ? *report.relax : report.relax.emplace();
    add(repaired->statistics, options.method, sum);
    sum.given_up += repaired->given_up.size();
    if (keeps_boundary) {
        const auto shift = boundary_shift(*state.quadratic(), repaired->judged.proposal());
        report.kept_boundary = KeptBoundaryReport{options.boundary_tolerance, shift.moved_nodes, shift.largest,
                                                  shift.largest_relative};
    }
    report.remaining.clear();
    for (auto& [element, reason] : keeps_boundary ? remaining(*repaired) : remaining_but_for_shape(*repaired))
        report.remaining.push_back({element.index() + 1, std::move(reason)});
    enter(std::move(repaired->judged), state, report);
    return state;
}

template <int D>
Outcome<State<D>> commit_stage(State<D> state, Report& report, const Execution& execution) {
    if (auto ok = need(state.proposal.has_value(), "commit", "curve"); !ok) return fail(ok.error());
    if (!state.judged) {
        auto validated = validate_stage(std::move(state), config::Validate{}, report, execution);
        if (!validated) return fail(validated.error());
        state = std::move(*validated);
    }
    const JudgedProposal<D> judged = std::move(*std::exchange(state.judged, std::nullopt));
    auto committed =
        judged.validation().certified() ? commit(judged) : Outcome<Committed<D>>(commit_uncertified(judged));
    if (!committed) return fail(committed.error());
    state.mesh = std::move(committed->mesh);
    report.committed = true;
    return state;
}

template <int D>
Outcome<State<D>> reinsert_stage(State<D> state, const config::Reinsert& options, Report& report,
                                 const Execution& execution) {
    auto around = shells(state.quadratic()->edges, execution);
    if (!around) return fail(around.error());
    state.shells = std::move(*around);
    auto boundary = wanted_boundary(state, report, execution);
    if (!boundary) return fail(boundary.error());
    const auto kinds = held_kinds(*state.quadratic(), state.features->edge_kinds, state.required);
    const ReinsertAllOptions all{{edge_options(options.curve), options.relax}, options.max_turns};
    const auto begin = std::chrono::steady_clock::now();
    auto done = reinsert_all(*state.quadratic(), kinds, Column<LagrangeNode<D>>(std::move(*boundary)), *state.back, all,
                             execution);
    if (!done) return fail(done.error());
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    const double bound = options.relax.min_scaled_jacobian;
    const auto judged = validate(*state.quadratic(), done->wanted.proposal, bound, execution);
    if (!judged) return fail(judged.error());
    const Validation<D>& wanted = judged->validation();
    const auto now = validate(*state.quadratic(), done->proposal, bound, execution);
    if (!now) return fail(now.error());

    report.curve = curve_report(*state.quadratic(), done->wanted, seconds.count());
    report.validity_before = validity_report(wanted);
    state.first_validation = wanted;
    const bool by_theta = options.relax.method == RepairMethod::theta;
    add(changes_between(*judged, *now), by_theta ? RepairMethod::theta : RepairMethod::segment,
        report.relax.emplace());
    const ReinsertStatistics& s = done->statistics;
    report.reinsert = ReinsertReport{s.turns, s.rounds, s.patches, s.not_valid, s.no_gain};
    if (s.left > 0)
        report.notices.push_back(std::to_string(s.left) + " vertices could have another turn: max_turns ended it");
    state.mesh = std::move(done->mesh);
    state.propose(std::move(done->proposal));
    enter(now->validation(), state, report);
    report.committed = true;
    state.curved = std::move(done->wanted);
    return state;
}

template <int D>
Outcome<State<D>> measure_stage(State<D> state, Report& report, const Execution& execution) {
    if (state.curved && state.proposal && state.back) {
        auto lengths = updated_lengths(state.quadratic()->edges, *state.curved, *state.proposal, *state.shells,
                                       *state.back, execution);
        if (!lengths) return fail(lengths.error());
        state.lengths = std::move(*lengths);
        const auto seen = proposed(*state.quadratic(), *state.proposal);
        report.curve->after = edge_report(seen, *state.proposal, state.lengths->straight, state.lengths->curved);
    }
    if (state.features && state.geometry && state.proposal) {
        const auto seen = proposed(*state.quadratic(), *state.proposal);
        auto chords = chord_middles(seen, execution);
        if (!chords) return fail(chords.error());
        const Column<LagrangeNode<D>> straight(std::move(*chords));
        auto before = boundary_distance(seen, straight.view(), *state.features, *state.geometry, execution);
        if (!before) return fail(before.error());
        auto after = boundary_distance(seen, seen.mid_nodes.view(), *state.features, *state.geometry, execution);
        if (!after) return fail(after.error());
        report.boundary->straight_distance = before->largest;
        report.boundary->curved_distance = after->largest;
    }
    report.histograms = run_histograms(state);
    return state;
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<State<D>> elevate_stage<D>(State<D>, Report&, const Execution&);                                 \
    template Outcome<State<D>> surface_stage<D>(State<D>, const config::Features&, const config::Geometry&, Report&,  \
                                                const Execution&);                                                    \
    template Outcome<State<D>> metric_stage<D>(State<D>, const config::Metric&, const std::optional<MetricFile>&,     \
                                               std::span<const config::MetricOperation>, std::span<const MetricFile>, \
                                               Report&, const Execution&);                                            \
    template Outcome<State<D>> curve_stage<D>(State<D>, const config::Curve&, Report&, const Execution&);             \
    template Outcome<State<D>> validate_stage<D>(State<D>, const config::Validate&, Report&, const Execution&);       \
    template Outcome<State<D>> relax_stage<D>(State<D>, const config::Relax&, Report&, const Execution&);             \
    template Outcome<State<D>> commit_stage<D>(State<D>, Report&, const Execution&);                                  \
    template Outcome<State<D>> reinsert_stage<D>(State<D>, const config::Reinsert&, Report&, const Execution&);       \
    template Outcome<State<D>> measure_stage<D>(State<D>, Report&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
