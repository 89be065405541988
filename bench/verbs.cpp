// Times of the five verbs on the shell with layers of configs/layers.json, by number of threads. items_per_second
// counts edges or elements.
#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <utility>

import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.shapes;
import camber.surface;
import camber.curving;
import camber.repair;

using namespace camber;

namespace {

/// Options that make elements invalid, for the benchmarks of repair.
CurveOptions by_energy() {
    CurveOptions options;
    options.aim = CurvingAim::energy;
    return options;
}

/// All inputs of `curve` and `validate`, built once.
struct Case {
    LinearMesh<3> linear;
    QuadraticMesh<3> mesh;
    Features<3> features;
    Column<LagrangeNode<3>> boundary;
    Incidence<ElementId> shell;
    BackMesh<3> back;
    Curved<3> curved;
};

const Case& layers() {
    static const Case prepared = [] {
        const Execution all;
        ShellOptions<3> options;
        options.inner_size = 0.3;
        options.outer_size = 1.6;
        options.inner_layer = {.count = 8, .first_height = 0.02, .growth = 1.25};
        Case c;
        c.linear = *generate(options);
        c.mesh = *elevate(c.linear, all);
        c.features = *find_features(c.linear, c.mesh.edges, FeatureOptions<3>{}, all);
        const Geometry<3> geometry = *build_surrogate(c.linear, c.mesh.edges, c.features, SurrogateOptions{}, all);
        c.boundary = *boundary_nodes(c.mesh, c.features, geometry, all);
        c.shell = *shells(c.mesh.edges, all);
        const auto ball = *balls(c.linear, all);
        c.back = *make_back_mesh(c.linear, ball, Column<LogMetric<3>>(*natural_log_metrics(c.linear, ball, all)), all);
        c.curved = *curve({c.mesh, c.features.edge_kinds, c.shell}, c.boundary, c.back, by_energy(), all);
        return c;
    }();
    return prepared;
}

Execution threads(const benchmark::State& state) { return {.threads = static_cast<int>(state.range(0))}; }

void elevate_mesh(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(elevate(layers().linear, threads(state)));
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * layers().mesh.edges.size()));
}

void surrogate(benchmark::State& state) {
    const Case& c = layers();
    for (auto _ : state)
        benchmark::DoNotOptimize(
            build_surrogate(c.linear, c.mesh.edges, c.features, SurrogateOptions{}, threads(state)));
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * c.linear.facets.size()));
}

template <CurvingAim aim>
void curve_edges(benchmark::State& state) {
    const Case& c = layers();
    CurveOptions options;
    options.aim = aim;
    for (auto _ : state)
        benchmark::DoNotOptimize(
            curve({c.mesh, c.features.edge_kinds, c.shell}, c.boundary, c.back, options, threads(state)));
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * c.curved.statistics.volume_edges));
}

void validate_elements(benchmark::State& state) {
    const Case& c = layers();
    for (auto _ : state) benchmark::DoNotOptimize(validate(c.mesh, c.curved.proposal, 1e-9, threads(state)));
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * c.linear.elements.size()));
}

void relax_elements(benchmark::State& state) {
    const Case& c = layers();
    const auto judged = *validate(c.mesh, c.curved.proposal, 1e-9, threads(state));
    for (auto _ : state) benchmark::DoNotOptimize(relax(judged, RepairOptions{}, threads(state)));
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * judged.validation().invalid));
}

#define CAMBER_BENCH(f) BENCHMARK(f)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime()
CAMBER_BENCH(elevate_mesh);
CAMBER_BENCH(surrogate);
CAMBER_BENCH(curve_edges<CurvingAim::energy>);
CAMBER_BENCH(curve_edges<CurvingAim::length>);
CAMBER_BENCH(validate_elements);
CAMBER_BENCH(relax_elements);

}  // namespace
