// The nodes of all volume edges of a mesh, one thread: edge/METHOD/FIELD.
//
//   paper_reference  the paper's method, edge by edge (paper_reference/): metric along the edge from its three nodes
//   paper_points     the same with the metric located and interpolated at each quadrature point
//   camber           volume_target by the energy, as `curve` calls it, with the acceptance by 12 points
//   camber_length    the same by the length
//   default          offsets for accuracy, over the column of edges
//
//   natural   a shell with layers as rows of prisms in its natural metric
//   polar     polar-1 (anisotropy 100) on a mesh made for it; CAMBER_BENCH_POLAR=MESH,SOLUTION: another one, of files
//   rotating  sizes of anisotropy 10^6 whose axes turn, on a box that does not resolve them
//
// edges_per_second by one core. true_length: the mean over the edges of the curved edge's Riemannian length over the
// straight one's, both in the field of the back mesh by 16 pieces of 4 Gauss points; true_length_p99: the percentile 99
// of that; longer: the share of edges that are longer than their chords by more than 1e-9. Of an edge, in the mean:
// evaluations and exponentials (the paper's), its walks and the elements that they looked at; samples: points at which
// a back mesh was asked (each is a location and, but for a few, a decomposition).
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
    static const EdgeCase made = natural_case();
    return made;
}
const EdgeCase& polar() {
    static const EdgeCase made = polar_case(std::getenv("CAMBER_BENCH_POLAR"));
    return made;
}
const EdgeCase& rotating() {
    static const EdgeCase made = rotating_case();
    return made;
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

/// A back mesh that counts at how many points it is asked, by one thread.
class CountingBack final : public BackModel<3> {
  public:
    CountingBack(BackMesh<3> back, std::size_t& samples) : back_(std::move(back)), samples_(&samples) {}

    [[nodiscard]] Location<3> locate(const Vec<3>& p, ElementId hint) const override { return back_->locate(p, hint); }
    void sample_values(std::span<const Vec<3>> points, ElementId hint, std::span<FieldSample<3>> out) const override {
        *samples_ += points.size();
        back_->sample_values(points, hint, out);
    }
    void sample_with_gradients(std::span<const Vec<3>> points, ElementId hint,
                               std::span<FieldSample<3>> out) const override {
        *samples_ += points.size();
        back_->sample_with_gradients(points, hint, out);
    }
    void sample_with_recovered_gradients(std::span<const Vec<3>> points, ElementId hint,
                                         std::span<FieldSample<3>> out) const override {
        *samples_ += points.size();
        back_->sample_with_recovered_gradients(points, hint, out);
    }
    void see(std::span<const BackEdge> edges, std::span<EdgeEnds<3>> out) const override { back_->see(edges, out); }
    [[nodiscard]] std::size_t vertex_count() const override { return back_->vertex_count(); }
    [[nodiscard]] BackVertex<3> vertex(VertexId v) const override { return back_->vertex(v); }
    [[nodiscard]] BackSector<3> sector(ElementId e, VertexId a, VertexId b) const override {
        return back_->sector(e, a, b);
    }

  private:
    BackMesh<3> back_;
    std::size_t* samples_;
};

void find_targets(const EdgeCase& c, const BackMesh<3>& back, const CurveOptions& options, const EdgeRules& rules,
                  std::span<Vec<3>> nodes) {
    for (std::size_t i = 0; i < c.edges.size(); ++i) {
        const EdgeId e = c.edges[i];
        nodes[i] = volume_target(c.mesh, e, c.mesh.mid_nodes[e], c.shell[e], back, rules, options).node.point;
    }
}

void by_camber(benchmark::State& state, const EdgeCase& c, CurvingAim aim) {
    CurveOptions options;
    options.aim = aim;
    const EdgeRules rules = edge_rules(options);
    std::vector<Vec<3>> nodes(c.edges.size());
    for (auto _ : state) {
        find_targets(c, c.back, options, rules, nodes);
        benchmark::DoNotOptimize(nodes.data());
    }
    std::size_t samples = 0;
    find_targets(c, BackMesh<3>(CountingBack(c.back, samples)), options, rules, nodes);
    count_lengths(state, c, nodes);
    state.counters["samples"] = static_cast<double>(samples) / static_cast<double>(c.edges.size());
}

void by_default(benchmark::State& state, const EdgeCase& c) {
    const CurveOptions options;
    Buffer<Vec<3>> offsets;
    for (auto _ : state) {
        offsets = accurate_offsets(c.mesh, c.kinds, EdgeKind::volume, c.shell, c.back, options, {.threads = 1}).value();
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
    using Made = const EdgeCase& (*)();
    for (const auto& [field, made] :
         {std::pair<std::string, Made>{"natural", natural}, {"polar", polar}, {"rotating", rotating}}) {
        const Made get = made;
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
