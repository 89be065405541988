// Cost of a commit per patch, for several mesh sizes. 64 splits of distant edges are planned beforehand and committed
// together. The mesh is moved into the commit, as in a run, so the cost should not depend on the mesh size.
// bytes_an_element: memory of a DynamicMesh besides points, elements and references.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

import camber.core;
import camber.shapes;
import camber.cavity;

using namespace camber;

namespace {

DynamicMesh<3> box_of(std::size_t elements) {
    BoxOptions<3> options;
    const int n = static_cast<int>(std::lround(std::cbrt(static_cast<double>(elements) / 6)));
    options.cells = {n, n, n};
    const LinearMesh<3> mesh = generate(options).value();
    return make_dynamic(mesh, unique_edges(mesh, Execution{}).value(), {}, Execution{}).value();
}

template <class T>
double bytes(const Column<T>& column) {
    return static_cast<double>(column.size() * sizeof(T));
}
double topology_bytes(const DynamicMesh<3>& m) {
    return bytes(m.states) + bytes(m.element_of) + bytes(m.elements.marks) + bytes(m.face_neighbours) +
           bytes(m.edges_of) + bytes(m.edges) + bytes(m.line_of) + bytes(m.facets.marks) + bytes(m.sides) +
           bytes(m.lines) + bytes(m.line_references) + bytes(m.line_entities) + bytes(m.line_marks);
}

std::vector<Patch<3>> splits(const DynamicMesh<3>& mesh, std::size_t count, std::size_t shift) {
    StarWorkspace<3> workspace;
    std::vector<Patch<3>> patches;
    std::vector<ElementId> taken;
    const std::size_t stride = mesh.elements.size() / (2 * count);
    for (std::size_t i = 0; i < count; ++i) {
        const ElementId e((2 * i + 1) * stride + shift % (stride / 2));
        Patch<3> patch{mesh.stamp, {}, {}, {}};
        if (mesh.is_free(e)) continue;
        cavity_of_edge(mesh, e, 0, patch.removed);
        const auto& [a, b] = mesh.edges[mesh.edges_of[e][0]];
        patch.point.place = midpoint(mesh.points[a], mesh.points[b]);
        const bool is_apart = std::ranges::none_of(
            patch.removed.elements, [&](ElementId r) { return std::ranges::find(taken, r) != taken.end(); });
        if (!is_apart || star(mesh, patch.removed, {}, workspace, patch.star) != StarFailure::none) continue;
        taken.insert(taken.end(), patch.removed.elements.begin(), patch.removed.elements.end());
        patches.push_back(std::move(patch));
    }
    return patches;
}

void commit_splits(benchmark::State& state) {
    DynamicMesh<3> mesh = box_of(static_cast<std::size_t>(state.range(0)));
    state.counters["bytes_an_element"] = topology_bytes(mesh) / static_cast<double>(mesh.element_count());
    // Full columns grow once, by half.
    mesh = [&] {
        const auto first = splits(mesh, 64, 1);
        return replace_cavities<3>(std::move(mesh), first).value().mesh;
    }();
    std::size_t done = 0;
    std::size_t shift = 0;
    for (auto _ : state) {
        state.PauseTiming();
        const auto patches = splits(mesh, 64, shift += 17);
        state.ResumeTiming();
        auto changed = replace_cavities<3>(std::move(mesh), patches);
        if (!changed) return state.SkipWithError(changed.error().what.c_str());
        mesh = std::move(changed->mesh);
        done += patches.size();
    }
    state.counters["microseconds_a_patch"] =
        benchmark::Counter(static_cast<double>(done) * 1e-6, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(commit_splits)
    ->Arg(10000)
    ->Arg(100000)
    ->Arg(1000000)
    ->Arg(10000000)
    ->Iterations(200)
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

}  // namespace
