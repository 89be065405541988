// Small test meshes: lattices of cells cut into simplices, with optional omission of cells and random displacement and
// numbering of vertices.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

import camber.core;

namespace camber::testing {

template <int D>
using Cell = std::array<int, D>;

template <int D>
struct LatticeOptions {
    std::array<int, D> cells{};
    std::function<bool(const Cell<D>&)> keep = [](const Cell<D>&) { return true; };
    std::function<Vec<D>(const Vec<D>&)> place = [](const Vec<D>& p) { return p; };  ///< maps lattice coordinates to
                                                                                     ///< points
    double jitter = 0;       ///< displacement of inner and boundary vertices, in cells
    std::uint64_t seed = 0;  ///< seed of displacement and numbering; 0: numbering in lattice order
};

inline double orientation(const std::array<Vec<2>, 3>& p) { return det(p[1] - p[0], p[2] - p[0]); }
inline double orientation(const std::array<Vec<3>, 4>& p) { return det(p[1] - p[0], p[2] - p[0], p[3] - p[0]); }

template <int D>
std::array<Vec<D>, D + 1> corners(const LinearMesh<D>& mesh, std::size_t e) {
    std::array<Vec<D>, D + 1> p;
    for (int i = 0; i <= D; ++i) p[i] = mesh.points[mesh.elements.vertices[e][i]];
    return p;
}

/// Builds a mesh of simplices and points without references; elements are oriented positively.
template <int D>
LinearMesh<D> mesh_of(Buffer<Vec<D>> points, Buffer<SimplexVertices<D>> elements) {
    LinearMesh<D> mesh;
    mesh.point_references = Buffer<Reference>(points.size(), 0);
    mesh.elements.references = Buffer<Reference>(elements.size(), 1);
    for (auto& s : elements) {
        std::array<Vec<D>, D + 1> p;
        for (int i = 0; i <= D; ++i) p[i] = points[s[i].index()];
        if (orientation(p) < 0) std::swap(s[0], s[1]);
    }
    mesh.points = std::move(points);
    mesh.elements.vertices = std::move(elements);
    return mesh;
}

template <int D>
SimplexVertices<D - 1> face_of(const LinearMesh<D>& mesh, ElementFace face) {
    SimplexVertices<D - 1> v;
    const auto local = face_opposite<D>(static_cast<int>(face.opposite));
    for (int i = 0; i < D; ++i) v[i] = mesh.elements.vertices[face.element][local[i]];
    return v;
}

/// Keeps all cells of a lattice except about one in `many`; the first cell is always kept.
template <int D>
auto all_but_one_in(std::uint64_t many, std::uint64_t seed) {
    return [many, seed](const Cell<D>& c) {
        std::uint64_t key = seed;
        for (const int i : c) key = key * 6364136223846793005U + static_cast<std::uint64_t>(i) + 1442695040888963407U;
        return (key >> 33U) % many != 0 || std::all_of(c.begin(), c.end(), [](int i) { return i == 0; });
    };
}

/// Kuhn subdivision: a cell is the union of the D! simplices along the monotone paths between two opposite corners.
template <int D>
LinearMesh<D> lattice_mesh(const LatticeOptions<D>& o) {
    std::mt19937_64 engine(o.seed);
    std::array<std::size_t, D> stride{};
    std::size_t total = 1;
    for (int i = 0; i < D; ++i) {
        stride[i] = total;
        total *= static_cast<std::size_t>(o.cells[i]) + 1;
    }
    std::vector<std::array<std::size_t, D + 1>> paths;
    const auto each_cell = [&](auto&& visit) {
        Cell<D> c{};
        for (;;) {
            if (o.keep(c)) visit(c);
            int i = 0;
            while (i < D && ++c[i] == o.cells[i]) c[i++] = 0;
            if (i == D) return;
        }
    };
    each_cell([&](const Cell<D>& c) {
        std::array<int, D> axes{};
        std::iota(axes.begin(), axes.end(), 0);
        do {
            std::array<std::size_t, D + 1> path{};
            for (int i = 0; i < D; ++i) path[0] += static_cast<std::size_t>(c[i]) * stride[i];
            for (int i = 0; i < D; ++i) path[i + 1] = path[i] + stride[axes[i]];
            paths.push_back(path);
        } while (std::next_permutation(axes.begin(), axes.end()));
    });
    std::vector<std::size_t> used;
    for (const auto& path : paths) used.insert(used.end(), path.begin(), path.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    if (o.seed != 0) {
        std::shuffle(used.begin(), used.end(), engine);
        std::shuffle(paths.begin(), paths.end(), engine);
    }
    std::vector<VertexId> number(total);
    Buffer<Vec<D>> points(used.size());
    std::uniform_real_distribution<double> move(-o.jitter, o.jitter);
    for (std::size_t v = 0; v < used.size(); ++v) {
        number[used[v]] = VertexId(v);
        Vec<D> p;
        for (int i = 0; i < D; ++i)
            p[i] = static_cast<double>(used[v] / stride[i] % (static_cast<std::size_t>(o.cells[i]) + 1)) + move(engine);
        points[v] = o.place(p);
    }
    Buffer<SimplexVertices<D>> elements(paths.size());
    for (std::size_t e = 0; e < paths.size(); ++e)
        for (int i = 0; i <= D; ++i) elements[e][i] = number[paths[e][i]];
    return mesh_of<D>(std::move(points), std::move(elements));
}

/// Returns the value of an outcome; throws if it is an error, which fails the test or program.
template <class T>
T must(Outcome<T> outcome) {
    if (!outcome.has_value()) throw std::runtime_error(describe(outcome.error()));
    return std::move(*outcome);
}

inline const Execution one_thread{.threads = 1};

}  // namespace camber::testing
