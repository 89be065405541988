// Measures the loss of a metric field that is transferred between curved meshes 20 times, and the cost of point
// location:
//     build/bin/restarts [cells in 2D [cells in 3D]]
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>
#include <vector>

#include "dice.hpp"
#include "restarts.hpp"

import camber.core;
import camber.bezier;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

/// Returns the unit field with smaller sizes across the middle of the box, by a factor that depends on the distance
/// from it.
template <int D, class Factor>
FieldInBox<D> thinner(const GrowingBox<D>& box, Factor&& factor) {
    return [&box, factor](const Vec<D>& t) {
        const LogMetric<D> unit = box.metric(t);
        auto system = eigen_system(unit.l);
        const auto thin = std::ranges::max_element(system.values.c);
        *thin -= 2 * std::log(factor(2 * t[D - 1] - 1));
        return LogMetric<D>{composed(system)};
    };
}

template <int D>
void restarts(int n) {
    const GrowingBox<D> box{.growth = 5, .cells = static_cast<double>(n)};
    struct Case {
        const char* name;
        FieldInBox<D> field;
    };
    const std::vector<Case> cases{
        {"unit for the mesh", [&](const Vec<D>& t) { return box.metric(t); }},
        {"a kink in the middle", thinner<D>(box, [](double s) { return 0.2 + std::abs(s); })},
        {"a jump of 10 in two cells", thinner<D>(box, [n](double s) { return 5.5 + 4.5 * std::tanh(s * n / 2); })},
        {"a jump of 10 within one cell", thinner<D>(box, [](double s) { return s < 0 ? 1.0 : 10.0; })},
    };
    for (const auto& [name, field] : cases) {
        for (const Form form : {Form::quadratic, Form::linear}) {
            const Figures once = drift(box, field, n, 2, form), all = drift(box, field, n, 20, form);
            std::printf(
                "%dD, %d cells per side, %s, %s: complexity %+.4f %% after 2, %+.4f %% after 20; "
                "largest anisotropy %+.4f %%, %+.4f %%\n",
                D, n, name, form == Form::quadratic ? "quadratic" : "linear", 100 * once.complexity,
                100 * all.complexity, 100 * once.anisotropy, 100 * all.anisotropy);
        }
    }
}

/// Returns the time in microseconds per sample.
template <int D>
double time_of(const BackMesh<D>& back, const std::vector<Vec<D>>& points) {
    double best = 1e300;
    for (int round = 0; round < 3; ++round) {
        const auto begin = std::chrono::steady_clock::now();
        ElementId hint;
        for (const Vec<D>& p : points) hint = sample_value(back, p, hint).location.element;
        const std::chrono::duration<double, std::micro> passed = std::chrono::steady_clock::now() - begin;
        best = std::min(best, passed.count() / static_cast<double>(points.size()));
    }
    return best;
}

/// Measures points of the mesh in the order of the elements, points outside the mesh, and random points.
template <int D>
void costs(int n) {
    const GrowingBox<D> box{.growth = 5, .cells = static_cast<double>(n)};
    const auto cells = cells_of(box, n, 0.2);
    const auto& mesh = cells.mesh;
    const auto around = must(balls(mesh.linear, one_thread));
    const auto logs = metrics_of<D>([&](const Vec<D>& t) { return box.metric(t); }, cells);
    const auto nodal = must(make_nodal_back_mesh(mesh, around, logs, one_thread));
    const auto straight = must(make_back_mesh(mesh.linear, around, logs.vertices, one_thread));
    const auto curved =
        must(make_curved_back_mesh(mesh, around, logs.vertices, one_thread, StoredGradients::recovered));
    std::vector<Vec<D>> near, far, beyond;
    Dice dice(1);
    for (int k = 0; k < 200000; ++k) {
        near.push_back(mesh.mid_nodes[static_cast<std::size_t>(k) % mesh.edges.size()].point);
        Vec<D> t = dice.vector<D>(0.01, 0.99);
        if (k < 20000) far.push_back(box(t));
        t[dice.below(D)] = dice.uniform(0, 1) < 0.5 ? -0.02 : 1.02;
        if (k < 20000) beyond.push_back(box(t));
    }
    for (const auto& [name, points] :
         {std::pair("in element order", &near), std::pair("anywhere", &far), std::pair("outside the mesh", &beyond)})
        std::printf("%dD, %zu elements, %s: %.2f us per sample; straight %.2f, curved %.2f\n", D,
                    mesh.linear.elements.size(), name, time_of(nodal, *points), time_of(straight, *points),
                    time_of(curved, *points));
}

}  // namespace

int main(int argc, char** argv) {
    const int plane = argc > 1 ? std::stoi(argv[1]) : 32, space = argc > 2 ? std::stoi(argv[2]) : 10;
    restarts<2>(plane);
    restarts<3>(space);
    costs<2>(plane);
    costs<3>(space);
    return 0;
}
