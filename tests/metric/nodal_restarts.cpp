// What is left of a metric field that goes from one curved mesh to another, again and again.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include "back.hpp"
#include "bent.hpp"
#include "meshes.hpp"

import camber.core;
import camber.bezier;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

/// A wavy box whose cells grow away from a wall, and the metric for which a lattice of n cells in it is unit.
template <int D>
struct GrowingBox {
    double growth = 6;  ///< log of the last cell's height over the first's
    double cells = 8;

    [[nodiscard]] Vec<D> operator()(Vec<D> t) const {
        t[D - 1] = std::expm1(growth * t[D - 1]) / std::expm1(growth);
        return wave<D>(t);
    }
    [[nodiscard]] LogMetric<D> metric(const Vec<D>& t) const {
        // The columns of the map's Jacobian, a cell long; M = J⁻ᵀ J⁻¹.
        Mat<D> cell;
        constexpr double step = 1e-6;
        for (int i = 0; i < D; ++i) {
            Vec<D> ahead = t, behind = t;
            ahead[i] += step;
            behind[i] -= step;
            cell.column[i] = (0.5 / (step * cells)) * ((*this)(ahead) - (*this)(behind));
        }
        auto system = left_singular(transposed(inverse(cell)));
        for (int i = 0; i < D; ++i) system.values[i] = 2 * std::log(system.values[i]);
        return {composed(system)};
    }
};

/// A lattice of n cells a side, its inner vertices shifted, in a box: the mesh, and where its nodes are in the box.
template <int D>
struct Cells {
    QuadraticMesh<D> parameters, mesh;
};
template <int D>
Cells<D> cells_of(const GrowingBox<D>& box, int n, double shift) {
    LatticeOptions<D> options;
    options.cells.fill(n);
    options.place = [n](const Vec<D>& p) { return p / n; };
    const auto shifted = [n, shift](const Vec<D>& t) {
        double bubble = shift / n;
        for (const double x : t.c) bubble *= std::sin(std::numbers::pi * x);
        Vec<D> out = t;
        for (int i = 0; i < D; ++i) out[i] += bubble * std::sin(5 * t[(i + 1) % D] + i);
        return out;
    };
    const auto lattice = lattice_mesh(options);
    return {mapped(lattice, shifted), mapped(lattice, [&](const Vec<D>& t) { return box(shifted(t)); })};
}

template <int D>
NodalLogs<D> metrics_of(const GrowingBox<D>& box, const Cells<D>& cells) {
    Buffer<LogMetric<D>> vertices, nodes;
    vertices.reserve(cells.mesh.linear.points.size());
    nodes.reserve(cells.mesh.edges.size());
    for (const Vec<D>& t : cells.parameters.linear.points) vertices.push_back(box.metric(t));
    for (const LagrangeNode<D>& t : cells.parameters.mid_nodes) nodes.push_back(box.metric(t.point));
    return {Column(std::move(vertices)), Column(std::move(nodes))};
}

enum class Form { quadratic, linear };

template <int D>
NodalLogs<D> handed_on(const QuadraticMesh<D>& from, const NodalLogs<D>& logs, const QuadraticMesh<D>& to, Form form) {
    const auto back = must(make_nodal_back_mesh(from, must(balls(from.linear, alone)), logs, alone));
    ElementId hint;
    const auto sampled = [&](const Vec<D>& p) {
        const auto sample = sample_value(back, p, hint);
        CHECK(sample.location.placement != Placement::lost);
        hint = sample.location.element;
        return sample.log_metric;
    };
    Buffer<LogMetric<D>> vertices, nodes;
    vertices.reserve(to.linear.points.size());
    nodes.reserve(to.edges.size());
    for (const Vec<D>& p : to.linear.points) vertices.push_back(sampled(p));
    if (form == Form::linear) return must(nodal_logs(to.edges, Column(std::move(vertices)), alone));
    for (const LagrangeNode<D>& node : to.mid_nodes) nodes.push_back(sampled(node.point));
    return {Column(std::move(vertices)), Column(std::move(nodes))};
}

struct Figures {
    double complexity = 0, anisotropy = 0;
};
template <int D>
Figures figures_of(const QuadraticMesh<D>& mesh, const NodalLogs<D>& logs) {
    return {must(complexity(mesh, logs, alone)), std::max(must(largest_anisotropy(logs.vertices, alone)),
                                                          must(largest_anisotropy(logs.mid_nodes, alone)))};
}

/// By how much both figures differ after so many restarts, each from the output of the one before.
template <int D>
Figures drift(const GrowingBox<D>& box, int n, int restarts, Form form) {
    const auto a = cells_of(box, n, 0.2), b = cells_of(box, n + 1, -0.3);
    auto logs = metrics_of(box, a);
    if (form == Form::linear) logs = must(nodal_logs(a.mesh.edges, logs.vertices, alone));
    const Figures before = figures_of(a.mesh, logs);
    for (int k = 0; k < restarts; k += 2)
        logs = handed_on(b.mesh, handed_on(a.mesh, logs, b.mesh, form), a.mesh, form);
    const Figures after = figures_of(a.mesh, logs);
    return {after.complexity / before.complexity - 1, after.anisotropy / before.anisotropy - 1};
}

template <int D>
void restart_law(int n) {
    const GrowingBox<D> box{.growth = 5, .cells = static_cast<double>(n)};
    const Figures quadratic = drift(box, n, 20, Form::quadratic);
    const Figures linear = drift(box, n, 20, Form::linear);
    MESSAGE("quadratic: complexity " << quadratic.complexity << ", anisotropy " << quadratic.anisotropy);
    MESSAGE("linear: complexity " << linear.complexity << ", anisotropy " << linear.anisotropy);
    CHECK(std::abs(quadratic.complexity) < 0.01);
    CHECK(std::abs(quadratic.anisotropy) < 0.01);
    CHECK(std::abs(linear.anisotropy) > std::abs(quadratic.anisotropy));
}

}  // namespace

TEST_CASE("2D: twenty restarts keep complexity and the largest anisotropy") { restart_law<2>(16); }
TEST_CASE("3D: twenty restarts keep complexity and the largest anisotropy") { restart_law<3>(6); }
