// Meshes and models of layers for the tests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "dice.hpp"
#include "meshes.hpp"

import camber.core;
import camber.metric;
import camber.solution_metric;

namespace camber::testing {

/// The unit box with the given cells. Boundary facets have the reference 1 + the axis of their normal.
template <int D>
LinearMesh<D> box_with_facets(const std::array<int, D>& cells, std::uint64_t seed, double jitter) {
    LatticeOptions<D> options;
    options.cells = cells;
    options.seed = seed;
    options.jitter = jitter;
    options.place = [&](Vec<D> p) {
        for (int i = 0; i < D; ++i) p[i] /= cells[i];
        return p;
    };
    auto mesh = lattice_mesh(options);
    const auto around = must(neighbours(mesh, must(balls(mesh, one_thread)), one_thread));
    Buffer<SimplexVertices<D - 1>> facets;
    Buffer<Reference> references;
    for (const ElementFace& face : boundary_faces<D>(around)) {
        const auto v = face_of(mesh, face);
        int across = 0;
        double least = 2;
        for (int i = 0; i < D; ++i) {
            double low = 2, high = -2;
            for (const VertexId w : v) low = std::min(low, mesh.points[w][i]), high = std::max(high, mesh.points[w][i]);
            if (high - low < least) least = high - low, across = i;
        }
        facets.push_back(v);
        references.push_back(1 + across);
    }
    mesh.facets.vertices = std::move(facets);
    mesh.facets.references = std::move(references);
    return mesh;
}

/// The unit box with n cells a side.
template <int D>
LinearMesh<D> box_with_facets(int n, std::uint64_t seed, double jitter) {
    std::array<int, D> cells;
    cells.fill(n);
    return box_with_facets<D>(cells, seed, jitter);
}

/// Patches of a mapped box, one for each side.
template <int D>
Column<std::uint32_t> patches_of(const LinearMesh<D>& parameters) {
    Buffer<std::uint32_t> out;
    for (std::size_t f = 0; f < parameters.facets.size(); ++f) {
        Vec<D> sum;
        for (const VertexId v : parameters.facets.vertices[f]) sum += parameters.points[v];
        const int axis = parameters.facets.references[f] - 1;
        out.push_back(2 * axis + (sum[axis] / D > 0.5 ? 1 : 0));
    }
    return out;
}

/// Sizes of a metric in increasing order.
template <int D>
std::array<double, D> sorted_sizes(const LogMetric<D>& log_metric) {
    std::array<double, D> out{};
    const auto e = eigen_system(log_metric.l);
    for (int i = 0; i < D; ++i) out[i] = std::exp(-e.values[i] / 2);
    std::sort(out.begin(), out.end());
    return out;
}

/// A model given by its eigenvalues and axes.
template <int D>
LocalModel<D> model_of(const Vec<D>& values, const Mat<D>& axes = Mat<D>::identity()) {
    LocalModel<D> out{{{}, axes}};
    for (int i = 0; i < D; ++i) out.logs.values[i] = std::log(values[i]);
    return out;
}

template <int D, class F>
Column<LocalModel<D>> models_on(const LinearMesh<D>& mesh, F&& model) {
    Buffer<LocalModel<D>> rows;
    for (const Vec<D>& p : mesh.points) rows.push_back(model(p));
    return rows;
}

template <int D>
LocalModel<D> random_model(Dice& dice, double decades) {
    Vec<D> values;
    for (double& x : values.c) x = std::pow(10.0, dice.uniform(-decades, decades));
    return model_of(values, dice.rotation<D>());
}

template <int D>
double log_det(const EigenSystem<D>& logs) {
    double sum = 0;
    for (const double x : logs.values.c) sum += x;
    return sum;
}

/// v = F y with Q = F⁻ᵀF⁻¹.
template <int D>
Mat<D> frame_of(const EigenSystem<D>& logs) {
    Mat<D> f = logs.vectors;
    for (int i = 0; i < D; ++i) f.column[i] *= std::exp(-logs.values[i] / 2);
    return f;
}

}  // namespace camber::testing
