// Optimises the nodes of all volume edges of a mesh on one thread: edge/METHOD/FIELD.
//
//   paper_reference  method of the paper, edge by edge (paper_reference/): metric along the edge from its three nodes
//   paper_points     the same with the metric located and interpolated at each quadrature point
//   camber           searched_targets by the energy, as called by `curve`: in packs, with the acceptance check
//   camber_length    the same by the length
//   default          offsets for accuracy, for all edges at once
//
//   natural   a shell with layers as rows of prisms in its natural metric
//   polar     polar-1 (anisotropy 100) on a mesh adapted to it, or the files in CAMBER_BENCH_POLAR=MESH,SOLUTION
//   rotating  sizes of anisotropy 10^6 with rotating axes, on a box that does not resolve them
//
// edges_per_second: on one core.
// true_length: mean ratio of the Riemannian lengths of curved and straight edges in the field of the back mesh, by 16
// pieces of 4 Gauss points.
// true_length_p99: 99th percentile of that ratio.
// longer: share of edges that are longer than their chords by more than 1e-9.
// Mean numbers per edge: evaluations and exponentials (method of the paper), walks and elements visited by them;
// decompositions of M (searches in packs).
// Shares of edges: single (searched outside packs), judged (accepted by a rule of twelve points).
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "paper_reference/minimise.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.io;
import camber.shapes;
import camber.fields;
import camber.surface;
import camber.curving;

#include "edge_cases.hpp"

using namespace camber;
using namespace edge_cases;

namespace {

const EdgeCase& natural() {
    static const EdgeCase edge_case = natural_case();
    return edge_case;
}
const EdgeCase& polar() {
    static const EdgeCase edge_case = polar_case(std::getenv("CAMBER_BENCH_POLAR"));
    return edge_case;
}
const EdgeCase& rotating() {
    static const EdgeCase edge_case = rotating_case();
    return edge_case;
}

void count_lengths(benchmark::State& state, const EdgeCase& c, std::span<const Vec<3>> nodes) {
    std::vector<double> ratios;
    double sum = 0;
    std::size_t longer = 0;
    for (std::size_t i = 0; i < c.edges.size(); ++i) {
        ratios.push_back(true_length(c, c.edges[i], nodes[i]) / c.straight_lengths[i]);
        sum += ratios.back();
        longer += ratios.back() > 1 + 1e-9;
    }
    const auto n = static_cast<double>(ratios.size());
    const auto percentile = ratios.begin() + static_cast<std::ptrdiff_t>(0.99 * n);
    std::ranges::nth_element(ratios, percentile);
    state.counters["edges"] = n;
    state.counters["edges_per_second"] =
        benchmark::Counter(static_cast<double>(state.iterations()) * n, benchmark::Counter::kIsRate);
    state.counters["true_length"] = sum / n;
    state.counters["true_length_p99"] = *percentile;
    state.counters["longer"] = static_cast<double>(longer) / n;
}

void by_the_paper(benchmark::State& state, const EdgeCase& c, paper::Along along) {
    const paper::Options options{.along = along};
    std::vector<Vec<3>> nodes(c.edges.size());
    paper::Work work;
    for (auto _ : state) {
        work = {};
        for (std::size_t i = 0; i < c.edges.size(); ++i) {
            const auto& [a, b] = c.mesh.edges.vertices[c.edges[i]];
            const paper::Minimum m =
                paper::minimise(c.field, a.value, b.value, c.shell[c.edges[i]].front().value, options);
            nodes[i].c = m.node.c;
            work.iterations += m.work.iterations;
            work.values += m.work.values;
            work.gradients += m.work.gradients;
            work.walks += m.work.walks;
            work.steps += m.work.steps;
        }
        benchmark::DoNotOptimize(nodes.data());
    }
    count_lengths(state, c, nodes);
    const auto an_edge = [&](double count) { return count / static_cast<double>(c.edges.size()); };
    state.counters["bfgs_iterations"] = an_edge(work.iterations);
    state.counters["exponentials"] = an_edge(3.0 * work.values);
    state.counters["exponentials_with_derivatives"] = an_edge(3.0 * work.gradients);
    state.counters["walks"] = an_edge(work.walks);
    state.counters["walked_elements"] = an_edge(work.steps);
}

EdgeSearchWork find_targets(const EdgeCase& c, const CurveOptions& options, const EdgeRules& rules,
                            std::span<EdgeTarget<3>> targets) {
    EdgeSearchWork work;
    const MeshEdges<3> all{c.mesh, c.kinds, c.shell};
    for (std::size_t begin = 0; begin < c.edges.size(); begin += searched_together) {
        const std::size_t n = std::min(searched_together, c.edges.size() - begin);
        work += searched_targets<3>({all, std::span(c.edges).subspan(begin, n), c.mesh.mid_nodes}, c.back, rules,
                                    options, targets.subspan(begin, n));
    }
    return work;
}

void by_camber(benchmark::State& state, const EdgeCase& c, CurvingAim aim) {
    CurveOptions options;
    options.aim = aim;
    const EdgeRules rules = edge_rules(options);
    std::vector<EdgeTarget<3>> targets(c.edges.size());
    EdgeSearchWork work;
    for (auto _ : state) {
        work = find_targets(c, options, rules, targets);
        benchmark::DoNotOptimize(targets.data());
    }
    std::vector<Vec<3>> nodes;
    nodes.reserve(targets.size());
    for (const EdgeTarget<3>& target : targets) nodes.push_back(target.node.point);
    count_lengths(state, c, nodes);
    const auto an_edge = [&](std::size_t count) {
        return static_cast<double>(count) / static_cast<double>(c.edges.size());
    };
    state.counters["single"] = an_edge(work.single);
    state.counters["judged"] = an_edge(work.judged);
    state.counters["decompositions"] = an_edge(work.decompositions);
}

void by_default(benchmark::State& state, const EdgeCase& c) {
    const CurveOptions options;
    Buffer<Vec<3>> offsets;
    for (auto _ : state) {
        offsets =
            accurate_offsets({c.mesh, c.kinds, c.shell}, EdgeKind::volume, c.back, options, {.threads = 1}).value();
        benchmark::DoNotOptimize(offsets.data());
    }
    std::vector<Vec<3>> nodes;
    nodes.reserve(c.edges.size());
    for (const EdgeId e : c.edges) nodes.push_back(c.mesh.mid_nodes[e].point + offsets[e.index()]);
    count_lengths(state, c, nodes);
}

void add(const std::string& name, std::function<void(benchmark::State&)> run) {
    benchmark::RegisterBenchmark(name.c_str(), std::move(run))->Unit(benchmark::kMillisecond);
}

bool registered() {
    using CaseFunction = const EdgeCase& (*)();
    for (const auto& [field, make_case] :
         {std::pair<std::string, CaseFunction>{"natural", natural}, {"polar", polar}, {"rotating", rotating}}) {
        const CaseFunction get = make_case;
        add("edge/paper_reference/" + field, [=](auto& state) { by_the_paper(state, get(), paper::Along::nodes); });
        add("edge/paper_points/" + field, [=](auto& state) { by_the_paper(state, get(), paper::Along::points); });
        add("edge/camber/" + field, [=](auto& state) { by_camber(state, get(), CurvingAim::energy); });
        add("edge/camber_length/" + field, [=](auto& state) { by_camber(state, get(), CurvingAim::length); });
        add("edge/default/" + field, [=](auto& state) { by_default(state, get()); });
    }
    return true;
}

const bool all_registered = registered();

}  // namespace
