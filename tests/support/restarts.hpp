// Repeated transfer of metric fields between curved meshes, for tests and bench/restarts.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "meshes.hpp"

import camber.core;
import camber.bezier;
import camber.metric;

namespace camber::testing {

/// Elevates a straight mesh and maps its vertices and nodes.
template <int D, class Map>
QuadraticMesh<D> mapped(const LinearMesh<D>& mesh, Map&& map) {
    auto out = must(elevate(LinearMesh<D>(mesh), one_thread));
    auto points = take(std::move(out.linear.points));
    auto nodes = take(std::move(out.mid_nodes));
    for (Vec<D>& p : points) p = map(p);
    for (LagrangeNode<D>& node : nodes) node.point = map(node.point);
    out.linear.points = std::move(points);
    out.mid_nodes = std::move(nodes);
    return out;
}

/// x_i + A sin 2π x_{i+1}. Edges of a lattice of four cells per side are bowed by 6 % of their chords, some by 10 %.
template <int D>
Vec<D> wave(const Vec<D>& p, double height = 0.05) {
    Vec<D> x = p;
    for (int i = 0; i < D; ++i) x[i] += height * std::sin(2 * std::numbers::pi * p[(i + 1) % D]);
    return x;
}

/// A wavy box whose cells are thin in the middle, and the metric for which a lattice of n cells in it is unit.
template <int D>
struct GrowingBox {
    double growth = 5;  ///< cosh(growth) is the ratio of cell heights at the ends and in the middle
    double cells = 8;

    [[nodiscard]] Vec<D> operator()(Vec<D> t) const {
        t[D - 1] = 0.5 + 0.5 * std::sinh(growth * (2 * t[D - 1] - 1)) / std::sinh(growth);
        return wave<D>(t);
    }
    [[nodiscard]] LogMetric<D> metric(const Vec<D>& t) const {
        // The columns of the map's Jacobian times the cell length; M = J⁻ᵀ J⁻¹.
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

/// A lattice of n cells per side with shifted inner vertices: the parameters of its nodes, and its image in the box.
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

/// A field as a function of box parameters.
template <int D>
using FieldInBox = std::function<LogMetric<D>(const Vec<D>&)>;

template <int D>
NodalLogs<D> metrics_of(const FieldInBox<D>& field, const Cells<D>& cells) {
    Buffer<LogMetric<D>> vertices, nodes;
    vertices.reserve(cells.mesh.linear.points.size());
    nodes.reserve(cells.mesh.edges.size());
    for (const Vec<D>& t : cells.parameters.linear.points) vertices.push_back(field(t));
    for (const LagrangeNode<D>& t : cells.parameters.mid_nodes) nodes.push_back(field(t.point));
    return {Column(std::move(vertices)), Column(std::move(nodes))};
}

enum class Form { quadratic, linear };

template <int D>
inline NodalLogs<D> handed_on(const QuadraticMesh<D>& from, const NodalLogs<D>& logs, const QuadraticMesh<D>& to,
                              Form form) {
    const auto back = must(make_nodal_back_mesh(from, must(balls(from.linear, one_thread)), logs, one_thread));
    ElementId hint;
    const auto sampled = [&](const Vec<D>& p) {
        const auto sample = sample_value(back, p, hint);
        if (sample.location.placement == Placement::lost) throw std::runtime_error("a point was lost");
        hint = sample.location.element;
        return sample.log_metric;
    };
    Buffer<LogMetric<D>> vertices, nodes;
    vertices.reserve(to.linear.points.size());
    nodes.reserve(to.edges.size());
    for (const Vec<D>& p : to.linear.points) vertices.push_back(sampled(p));
    if (form == Form::linear) return must(nodal_logs(to.edges, Column(std::move(vertices)), one_thread));
    for (const LagrangeNode<D>& node : to.mid_nodes) nodes.push_back(sampled(node.point));
    return {Column(std::move(vertices)), Column(std::move(nodes))};
}

struct Figures {
    double complexity = 0, anisotropy = 0;
};
template <int D>
Figures figures_of(const QuadraticMesh<D>& mesh, const NodalLogs<D>& logs) {
    return {must(complexity(mesh, logs, one_thread)), std::max(must(largest_anisotropy(logs.vertices, one_thread)),
                                                               must(largest_anisotropy(logs.mid_nodes, one_thread)))};
}

/// Relative changes of both figures after `restarts` transfers, each from the output of the previous one.
template <int D>
Figures drift(const GrowingBox<D>& box, const FieldInBox<D>& field, int n, int restarts, Form form) {
    const auto a = cells_of(box, n, 0.2), b = cells_of(box, n + 1, -0.3);
    auto logs = metrics_of(field, a);
    if (form == Form::linear) logs = must(nodal_logs(a.mesh.edges, logs.vertices, one_thread));
    const Figures before = figures_of(a.mesh, logs);
    for (int k = 0; k < restarts; k += 2) logs = handed_on(b.mesh, handed_on(a.mesh, logs, b.mesh, form), a.mesh, form);
    const Figures after = figures_of(a.mesh, logs);
    return {after.complexity / before.complexity - 1, after.anisotropy / before.anisotropy - 1};
}

}  // namespace camber::testing
