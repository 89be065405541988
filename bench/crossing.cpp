// Cost of the crossing check: pairs of facets by number of common vertices, a whole sphere, and a grid of facets.
//
//     build/bin/bench_crossing
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

import camber.core;
import camber.bezier;
import camber.shapes;
import camber.crossing;

using namespace camber;

namespace {

/// Returns the unit sphere in 20 n² curved triangles.
QuadraticMesh<3> sphere(int n) {
    UnitSphere<3> unit = icosphere<3>(n);
    LinearMesh<3> mesh;
    mesh.point_references = Buffer<Reference>(unit.points.size(), 0);
    mesh.facets.references = Buffer<Reference>(unit.facets.size(), 1);
    mesh.points = std::move(unit.points);
    mesh.facets.vertices = std::move(unit.facets);
    auto curved = elevate(std::move(mesh), Execution{});
    if (!curved) std::abort();
    Buffer<LagrangeNode<3>> nodes = take(std::move(curved->mid_nodes));
    for (auto& node : nodes) node.point = normalised(node.point);
    curved->mid_nodes = std::move(nodes);
    return std::move(*curved);
}

/// Measures pairs of facets with the given number of common vertices. Pairs without common vertices have boxes that
/// meet.
void pairs(benchmark::State& state) {
    const auto mesh = sphere(20);
    std::vector<NodalFacet<3>> facets;
    std::vector<Box<3>> boxes;
    facets.reserve(mesh.linear.facets.size());
    boxes.reserve(mesh.linear.facets.size());
    for (std::size_t f = 0; f < mesh.linear.facets.size(); ++f) {
        facets.push_back(nodal_facet(mesh, FacetId(f)));
        boxes.push_back(box_of(facets.back()));
    }
    std::vector<std::pair<std::size_t, std::size_t>> list;
    for (std::size_t f = 0; f < 400; ++f)
        for (std::size_t g = f + 1; g < facets.size(); ++g) {
            int shared = 0;
            for (const VertexId v : mesh.linear.facets.vertices[f])
                for (const VertexId w : mesh.linear.facets.vertices[g]) shared += v == w ? 1 : 0;
            if (shared == state.range(0) && boxes[f].meets(boxes[g])) list.emplace_back(f, g);
        }
    for (auto _ : state)
        for (const auto& [f, g] : list) benchmark::DoNotOptimize(crossing_of(facets[f], facets[g]));
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * list.size()));
}
BENCHMARK(pairs)->ArgName("shared")->Arg(0)->Arg(1)->Arg(2);

void whole_sphere(benchmark::State& state) {
    const auto mesh = sphere(static_cast<int>(state.range(0)));
    Crossings found;
    for (auto _ : state) found = find_crossings(mesh, Execution{.threads = 1}).value();
    state.counters["pairs"] = static_cast<double>(found.pairs);
    state.counters["not disjoint"] = static_cast<double>(found.found.size());
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * mesh.linear.facets.size()));
}
BENCHMARK(whole_sphere)->Arg(11)->Arg(45)->Arg(142)->Unit(benchmark::kMillisecond);

void grid_insert_and_remove(benchmark::State& state) {
    const auto mesh = sphere(45);
    std::vector<Box<3>> boxes(mesh.linear.facets.size());
    for (std::size_t f = 0; f < boxes.size(); ++f) boxes[f] = box_of(nodal_facet(mesh, FacetId(f)));
    FacetGrid<3> grid;
    for (std::size_t f = 0; f < boxes.size(); ++f) grid.insert(FacetId(f), boxes[f]);
    for (auto _ : state)
        for (std::size_t f = 0; f < boxes.size(); ++f) {
            grid.remove(FacetId(f));
            grid.insert(FacetId(f), boxes[f]);
        }
    state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * boxes.size()));
}
BENCHMARK(grid_insert_and_remove);

void grid_query(benchmark::State& state) {
    const auto mesh = sphere(45);
    std::vector<Box<3>> boxes(mesh.linear.facets.size());
    FacetGrid<3> grid;
    for (std::size_t f = 0; f < boxes.size(); ++f) {
        boxes[f] = box_of(nodal_facet(mesh, FacetId(f)));
        grid.insert(FacetId(f), boxes[f]);
    }
    std::vector<FacetId> found;
    std::size_t total = 0;
    for (auto _ : state)
        for (const Box<3>& box : boxes) {
            grid.meeting(box, found);
            total += found.size();
        }
    const auto queries = static_cast<double>(state.iterations() * boxes.size());
    state.SetItemsProcessed(static_cast<std::int64_t>(queries));
    state.counters["found"] = static_cast<double>(total) / queries;
}
BENCHMARK(grid_query);

}  // namespace
