// Remeshes a straight mesh to a metric with the passes of module adapt. Prints the operations and the time of each
// pass, and the share of unit edges. The program takes arguments and is not a timed test:
//
//     remesh MESH SOLUTION [--finer 2] [--rounds 4] [--threads 0] [--curved] [--check]
//
// finer: divisor of the sizes of the metric.
// curved: remesh as a mesh of degree 2 on the surrogate of its boundary. A curved input mesh is always remeshed so and
// keeps its nodes.
// check: check the whole topology and the certificates after each pass.
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

import camber.core;
import camber.bezier;
import camber.metric;
import camber.io;
import camber.cavity;
import camber.surface;
import camber.validity;
import camber.operation;
import camber.adapt;

#include "mesh_files.hpp"

using namespace camber;
using namespace camber::bench;

namespace {

struct Arguments {
    std::string mesh, solution;
    double finer = 1;
    int rounds = 4;
    int threads = 0;
    bool curved = false, check = false;
};

Column<LogMetric<3>> metrics_of(const Arguments& a, const Execution& execution) {
    const auto solution = must(decode_solution(bytes_of(a.solution), a.solution, execution)).solution;
    const auto precision = solution.single_precision ? TensorPrecision::four_bytes : TensorPrecision::eight_bytes;
    auto logs = must(log_metrics_of_tensors<3>(solution.values.view(), precision, execution)).log_metrics;
    for (LogMetric<3>& m : logs)
        for (int i = 0; i < 3; ++i) m.l(i, i) += 2 * std::log(a.finer);
    return Column<LogMetric<3>>(std::move(logs));
}

Arguments arguments(std::span<char*> words) {
    Arguments a;
    for (std::size_t i = 1; i < words.size(); ++i) {
        const std::string_view word = words[i];
        const auto number = [&] { return i + 1 < words.size() ? std::strtod(words[++i], nullptr) : 0.0; };
        if (word == "--finer")
            a.finer = number();
        else if (word == "--rounds")
            a.rounds = static_cast<int>(number());
        else if (word == "--threads")
            a.threads = static_cast<int>(number());
        else if (word == "--curved")
            a.curved = true;
        else if (word == "--check")
            a.check = true;
        else
            (a.mesh.empty() ? a.mesh : a.solution) = word;
    }
    return a;
}

void print_quality(const Adaptation<3>& r, const Execution& execution) {
    const auto s = must(unit_mesh_statistics(r, execution));
    std::printf(
        "    %zu vertices, %zu elements; unit edges %.2f %%, lengths %.3f to %.3f, mean %.3f; quality %.2e, mean "
        "%.3f\n",
        r.mesh.vertex_count(), s.elements, 100 * s.unit_share(), s.shortest, s.longest, s.mean_length, s.worst_quality,
        s.mean_quality);
}

/// Checks the topology and the certificate of each curved element.
void check(const DynamicMesh<3>& mesh, const Execution& execution) {
    must(check_consistency(mesh, execution));
    if (!mesh.is_curved()) return;
    const auto compact = must(compacted(mesh, execution));
    const auto validity = must(validate(QuadraticMesh<3>{compact.mesh, compact.edges, compact.nodes}, 0, execution));
    std::printf("    %zu invalid, %zu undecided; smallest scaled Jacobian %.4f\n", validity.invalid, validity.undecided,
                validity.smallest);
}

template <class Pass>
Adaptation<3> step(const char* name, Adaptation<3> r, const Arguments& a, const Execution& execution, Pass&& pass) {
    const auto begin = std::chrono::steady_clock::now();
    const std::clock_t processor = std::clock();
    auto done = must(pass(std::move(r)));
    const double used = static_cast<double>(std::clock() - processor) / CLOCKS_PER_SEC;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const auto& s = done.statistics;
    std::printf(
        "%-9s %6.2f s, %6.2f CPU s, %8zu proposals %8zu accepted (%.0f, %.0f a second), %zu rounds; "
        "rejected:",
        name, seconds, used, s.proposals, s.accepted, static_cast<double>(s.accepted) / seconds,
        static_cast<double>(s.accepted) / used, s.rounds);
    for (const auto& reason : words(RejectionReason{}))
        if (const std::size_t n = s.of(reason.value); n > 0 && reason.value != RejectionReason::none)
            std::printf(" %s %zu", std::string(reason.word).c_str(), n);
    if (done.state.mesh.is_curved())
        std::printf("; straight test would reject %zu, accept %zu more; relaxed %zu, optimisation problems %zu",
                    s.straight_inverted, s.straight_positive, s.relaxed, s.optimisation_problems);
    std::printf("\n");
    print_quality(done.state, execution);
    if (a.check) check(done.state.mesh, execution);
    return std::move(done.state);
}

}  // namespace

int main(int argc, char** argv) {
    const Arguments a = arguments({argv, static_cast<std::size_t>(argc)});
    const Execution execution{.threads = a.threads};
    const auto decoded = read_mesh(a.mesh, execution);
    QuadraticMesh<3> curved;
    const auto& input = std::get<Mesh<3>>(decoded);
    const LinearMesh<3> mesh = straight_simplices(input);
    if (input.degree == 2) curved = must(as_quadratic(input));
    const auto edges = must(unique_edges(mesh, execution));
    const auto features = must(find_features(mesh, edges, FeatureOptions<3>{}, execution));
    std::vector<VertexId> corners;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
        if (features.vertex_kinds[v] == VertexKind::corner) corners.emplace_back(v);
    const BreaksOfMesh breaks{features.edge_kinds.view(), corners};
    const auto around = must(balls(mesh, execution));
    AdaptationGoal<3> goal{must(make_back_mesh(mesh, around, metrics_of(a, execution), execution)), {}};
    const bool is_curved = a.curved || curved.edges.size() > 0;
    if (is_curved)
        goal.geometry = Geometry<3>(must(build_surrogate(mesh, edges, features, SurrogateOptions{}, execution)));
    if (a.curved && curved.edges.size() == 0) curved = must(elevate(mesh, execution));
    Adaptation<3> r = is_curved ? must(begin_adaptation(curved, breaks, goal, execution))
                                : must(begin_adaptation(mesh, edges, breaks, goal, execution));
    print_quality(r, execution);
    for (int round = 0; round < a.rounds; ++round) {
        r = step("collapse", std::move(r), a, execution,
                 [&](Adaptation<3> state) { return collapse<3>(std::move(state), goal, {}, execution); });
        r = step("split", std::move(r), a, execution,
                 [&](Adaptation<3> state) { return split<3>(std::move(state), goal, {}, execution); });
        r = step("swap", std::move(r), a, execution,
                 [&](Adaptation<3> state) { return swap<3>(std::move(state), goal, {}, execution); });
        r = step("smooth", std::move(r), a, execution,
                 [&](Adaptation<3> state) { return smooth<3>(std::move(state), goal, {}, execution); });
    }
    r = step("mend", std::move(r), a, execution,
             [&](Adaptation<3> state) { return mend<3>(std::move(state), goal, {}, execution); });
    return 0;
}
