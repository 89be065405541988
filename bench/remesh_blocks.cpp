// Remeshes a straight mesh to a uniform size, or to the metric of a file divided by `finer`, as a whole and by blocks.
// Compares the quality within two rings of the vertices shared by the last blocks with that of the whole mesh. The
// program takes arguments and is not a timed test:
//
//     remesh_blocks MESH SIZE|SOLUTION BLOCK [--finer 1] [--threads 0] [--turns
//     0:6:loose,0.4:2:loose,0.2:2:strict,0.6:2:strict]
//
// BLOCK: number of elements of a block; 0: the mesh as a whole. A turn: the shift of its grid, its rounds and its
// length limits.
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

import camber.core;
import camber.metric;
import camber.io;
import camber.cavity;
import camber.surface;
import camber.operation;
import camber.adapt;
import camber.recipes;
import camber.distributed;

#include "mesh_files.hpp"

using namespace camber;
using namespace camber::bench;

namespace {

struct Arguments {
    std::string mesh, solution;
    double size = 0, finer = 1;
    std::size_t block = 0;
    int threads = 0;
    std::vector<BlockIteration> turns = block_iterations<3>({});
};

std::vector<BlockIteration> turns_of(std::string_view text) {
    std::vector<BlockIteration> turns;
    while (!text.empty()) {
        const std::string one(text.substr(0, text.find(',')));
        const std::size_t colon = one.find(':');
        turns.push_back({std::strtod(one.c_str(), nullptr),
                         static_cast<int>(std::strtod(one.c_str() + colon + 1, nullptr)),
                         one.ends_with("loose") ? BlockIteration::Lengths::loose : BlockIteration::Lengths::strict});
        text.remove_prefix(std::min(text.size(), one.size() + 1));
    }
    return turns;
}

Arguments arguments(std::span<char*> words) {
    Arguments a;
    std::vector<std::string> positional;
    for (std::size_t i = 1; i < words.size(); ++i) {
        const std::string_view word = words[i];
        if (word == "--threads" && i + 1 < words.size())
            a.threads = static_cast<int>(std::strtod(words[++i], nullptr));
        else if (word == "--finer" && i + 1 < words.size())
            a.finer = std::strtod(words[++i], nullptr);
        else if (word == "--turns" && i + 1 < words.size())
            a.turns = turns_of(words[++i]);
        else
            positional.emplace_back(word);
    }
    positional.resize(3);
    a.mesh = positional[0];
    a.size = std::strtod(positional[1].c_str(), nullptr);
    if (positional[1].find(".sol") != std::string::npos) a.solution = positional[1];
    a.block = static_cast<std::size_t>(std::strtod(positional[2].c_str(), nullptr));
    return a;
}

/// Extends the marks to vertices within the given number of rings of elements.
Buffer<std::uint8_t> grown(const DynamicMesh<3>& mesh, Buffer<std::uint8_t> marked, int rings) {
    for (int ring = 0; ring < rings; ++ring) {
        const Buffer<std::uint8_t> before = marked;
        for (const auto& element : mesh.elements.vertices)
            if (std::ranges::any_of(element, [&](VertexId v) { return v.valid() && before[v.index()] != 0; }))
                for (const VertexId v : element) marked[v.index()] = 1;
    }
    return marked;
}

struct Measured {
    std::size_t edges = 0, unit = 0, elements = 0;
    double quality = 0, worst = 1;
};
/// Measures edges and elements whose vertices are all marked.
Measured measured(const Adaptation<3>& r, const Buffer<std::uint8_t>& marked) {
    Measured m;
    const auto is_marked = [&](VertexId v) { return marked[v.index()] != 0; };
    for (std::size_t e = 0; e < r.mesh.edges.size(); ++e) {
        if (r.mesh.is_free(EdgeId(e)) || !std::ranges::all_of(r.mesh.edges[e], is_marked)) continue;
        const double length = length_of(r, EdgeId(e));
        ++m.edges;
        m.unit += length >= shortest_unit_edge && length <= longest_unit_edge ? 1 : 0;
    }
    for (std::size_t e = 0; e < r.mesh.elements.size(); ++e) {
        if (r.mesh.is_free(ElementId(e)) || !std::ranges::all_of(r.mesh.elements.vertices[e], is_marked)) continue;
        const double quality = quality_of_shape(shape_of(r, ElementId(e)), 3);
        ++m.elements;
        m.quality += quality;
        m.worst = std::min(m.worst, quality);
    }
    return m;
}
void print_quality(const char* where, const Measured& m) {
    std::printf("  %-14s %9zu elements, %9zu edges, unit %.2f %%, quality mean %.4f, minimum %.4f\n", where, m.elements,
                m.edges, 100.0 * static_cast<double>(m.unit) / static_cast<double>(std::max<std::size_t>(m.edges, 1)),
                m.quality / static_cast<double>(std::max<std::size_t>(m.elements, 1)), m.worst);
}

struct Clock {
    std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
    std::clock_t processor = std::clock();
    void print_times(const char* what) const {
        std::printf("%s: %.1f s, %.1f CPU s\n", what,
                    std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
                    static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC);
    }
};

Column<LogMetric<3>> metrics_of(const Arguments& a, std::size_t vertices, const Execution& execution) {
    if (a.solution.empty()) return Buffer<LogMetric<3>>(vertices, log_metric_of_sizes<3>({{a.size, a.size, a.size}}));
    const auto solution = must(decode_solution(bytes_of(a.solution), a.solution, execution)).solution;
    const auto precision = solution.single_precision ? TensorPrecision::four_bytes : TensorPrecision::eight_bytes;
    auto logs = must(log_metrics_of_tensors<3>(solution.values.view(), precision, execution)).log_metrics;
    for (LogMetric<3>& m : logs)
        for (int i = 0; i < 3; ++i) m.l(i, i) += 2 * std::log(a.finer);
    return Column<LogMetric<3>>(std::move(logs));
}

Remeshing<3> start_remeshing(const Arguments& a, const Execution& execution) {
    const LinearMesh<3> mesh = mesh_as<LinearMesh<3>>(read_mesh(a.mesh, execution)).value();
    const auto edges = must(unique_edges(mesh, execution));
    const auto boundary = must(find_boundary<3>(mesh, edges, {}, {}, execution));
    auto field =
        must(make_field<3>(mesh, metric_at_vertices<3>(metrics_of(a, mesh.points.size(), execution)), execution));
    return must(begin_remeshing<3>(mesh, edges, boundary, {std::move(field)}, execution));
}

void by_blocks(const Arguments& a, Remeshing<3> r, const Execution& execution) {
    const auto ranks = one_rank();
    RemeshedRows<3> remeshed{must(share_of(must(rows_of(r.mesh)), *ranks))};
    r.mesh = {};
    for (const BlockIteration& turn : a.turns) {
        const Clock clock;
        const BlockRemeshing by{a.block, *ranks};
        remeshed = must(run_block_iteration(std::move(remeshed), r.goal, {}, by, turn, without_wrapper(execution)));
        std::printf("shift %.3f, %d rounds, ", turn.shift, turn.rounds);
        clock.print_times(turn.lengths == BlockIteration::Lengths::loose ? "loose" : "strict");
        const auto whole = must(assembled(remeshed.shared.rows, execution));
        const auto near = grown(whole.state.mesh, remeshed.shared.on_rim, 2);
        print_quality("near rims", measured(whole.state, near));
        print_quality("all", measured(whole.state, Buffer<std::uint8_t>(remeshed.shared.on_rim.size(), 1)));
    }
}

}  // namespace

int main(int argc, char** argv) {
    const Arguments a = arguments({argv, static_cast<std::size_t>(argc)});
    const Execution execution{.threads = a.threads};
    Remeshing<3> r = start_remeshing(a, execution);
    const Clock clock;
    if (a.block > 0) {
        by_blocks(a, std::move(r), execution);
    } else {
        const auto result = must(remesh_to_metric(std::move(r.mesh), r.goal, ToMetricOptions{}, execution));
        print_quality("all", measured(result.state, Buffer<std::uint8_t>(result.state.mesh.points.size(), 1)));
    }
    clock.print_times("all");
    return 0;
}
