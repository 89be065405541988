// Boxes and fields for the tests of transfer.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "dice.hpp"
#include "meshes.hpp"

import camber.core;
import camber.bezier;
import camber.transfer;

namespace camber::testing {

/// The unit box with n cells a side. Inner vertices are displaced by up to a fifth of a cell and numbered at random.
template <int D>
LinearMesh<D> rough_box(int n, std::uint64_t seed) {
    LatticeOptions<D> options;
    options.cells.fill(n);
    options.seed = seed;
    const auto dice = std::make_shared<Dice>(seed);
    options.place = [n, dice](const Vec<D>& p) {
        Vec<D> x = p / n;
        for (int i = 0; i < D; ++i)
            if (p[i] > 0.5 && p[i] < n - 0.5) x[i] += dice->uniform(-0.2, 0.2) / n;
        return x;
    };
    return lattice_mesh(options);
}

template <int D>
QuadraticMesh<D> quadratic(LinearMesh<D> mesh) {
    return must(elevate(std::move(mesh), one_thread));
}

/// Displaces the edge nodes inside the unit box by up to a share of their chords.
template <int D>
QuadraticMesh<D> bent_inside(QuadraticMesh<D> mesh, double share, Dice& dice) {
    auto nodes = take(std::move(mesh.mid_nodes));
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const double length = distance(mesh.linear.points[a], mesh.linear.points[b]);
        const Vec<D> off = dice.vector<D>(-share * length, share * length);
        for (int i = 0; i < D; ++i)
            if (nodes[e].point[i] > 0 && nodes[e].point[i] < 1) nodes[e].point[i] += off[i];
    }
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

template <int D>
Vec<D> node_place(const QuadraticMesh<D>& mesh, std::size_t n) {
    const std::size_t vertices = mesh.linear.points.size();
    return n < vertices ? mesh.linear.points[n] : mesh.mid_nodes[n - vertices].point;
}

/// A scalar function of position.
template <int D>
using Function = std::function<double(const Vec<D>&)>;
template <int D>
TransferField field_of(const QuadraticMesh<D>& mesh, int degree, const std::vector<Function<D>>& functions) {
    TransferField field{static_cast<int>(functions.size()), degree, {}};
    Buffer<double> values;
    for (std::size_t n = 0; n < node_count_of(mesh, degree); ++n)
        for (const auto& f : functions) values.push_back(f(node_place(mesh, n)));
    field.values = std::move(values);
    return field;
}

/// A polynomial of degree 1 or 2 with coefficients in (-1, 1).
template <int D>
Function<D> polynomial(int degree, Dice& dice) {
    const double constant = dice.uniform(-1, 1);
    const Vec<D> slope = dice.vector<D>();
    const Sym<D> bend = degree == 2 ? dice.symmetric<D>() : Sym<D>{};
    return [=](const Vec<D>& x) {
        double u = constant + dot(slope, x);
        for (int i = 0; i < D; ++i)
            for (int j = 0; j < D; ++j) u += bend(i, j) * x[i] * x[j];
        return u;
    };
}

/// The lattice of n cells a side in the unit box. That of 2n cells is a refinement.
template <int D>
LinearMesh<D> lattice_in_box(int n) {
    LatticeOptions<D> options;
    options.cells.fill(n);
    options.place = [n](const Vec<D>& p) { return p / n; };
    return lattice_mesh(options);
}

/// A quadratic map of space near the identity. It maps straight elements to exact quadratic ones.
template <int D>
class QuadraticMap {
  public:
    explicit QuadraticMap(Dice& dice) {
        for (auto& bend : bends_) bend = dice.symmetric<D>(0.05);
    }
    [[nodiscard]] Vec<D> operator()(const Vec<D>& x) const {
        Vec<D> y = x;
        for (int k = 0; k < D; ++k)
            for (int i = 0; i < D; ++i)
                for (int j = 0; j < D; ++j) y[k] += bends_[k](i, j) * x[i] * x[j];
        return y;
    }
    [[nodiscard]] QuadraticMesh<D> operator()(QuadraticMesh<D> mesh) const {
        auto points = take(std::move(mesh.linear.points));
        auto nodes = take(std::move(mesh.mid_nodes));
        for (Vec<D>& p : points) p = (*this)(p);
        for (auto& node : nodes) node.point = (*this)(node.point);
        mesh.linear.points = std::move(points);
        mesh.mid_nodes = std::move(nodes);
        return mesh;
    }

  private:
    std::array<Sym<D>, D> bends_{};
};

/// True near the corner (1, 1, …) of the unit box with three cells a side.
template <int D>
bool is_at_corner(const Vec<D>& p) {
    for (const double x : p.c)
        if (!(x > 0.4)) return false;
    return true;
}

/// Moves the inner vertices near that corner. Edge nodes move with them.
template <int D>
QuadraticMesh<D> moved_at_corner(QuadraticMesh<D> mesh, Dice& dice) {
    auto points = take(std::move(mesh.linear.points));
    auto nodes = take(std::move(mesh.mid_nodes));
    const auto move = [&](Vec<D>& p, const Vec<D>& by) {
        for (int i = 0; i < D; ++i)
            if (p[i] > 0 && p[i] < 1) p[i] += by[i];
    };
    std::vector<Vec<D>> by(points.size());
    for (std::size_t v = 0; v < points.size(); ++v) {
        if (is_at_corner<D>(points[v])) by[v] = dice.vector<D>(-0.02, 0.02);
        move(points[v], by[v]);
    }
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        move(nodes[e].point, midpoint(by[a.index()], by[b.index()]));
    }
    mesh.linear.points = std::move(points);
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

/// The same mesh with its vertices and edges in another order.
template <int D>
QuadraticMesh<D> renumbered(const QuadraticMesh<D>& mesh, Dice& dice) {
    std::vector<std::size_t> order(mesh.linear.points.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::shuffle(order.begin(), order.end(), dice.engine());
    LinearMesh<D> linear = mesh.linear;
    Buffer<Vec<D>> points(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) points[order[i]] = mesh.linear.points[i];
    auto elements = take(std::move(linear.elements.vertices));
    for (auto& element : elements)
        for (VertexId& v : element) v = VertexId(order[v.index()]);
    linear.points = std::move(points);
    linear.elements.vertices = std::move(elements);
    auto out = quadratic(std::move(linear));
    auto nodes = take(std::move(out.mid_nodes));
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        nodes[find_edge(out.edges, VertexId(order[a.index()]), VertexId(order[b.index()])).index()] = mesh.mid_nodes[e];
    }
    out.mid_nodes = std::move(nodes);
    return out;
}

/// The number of the node at a position, or the number of nodes if there is none.
template <int D>
std::size_t node_at(const QuadraticMesh<D>& mesh, const Vec<D>& p) {
    std::size_t n = 0;
    while (n < node_count_of(mesh, 2) && node_place(mesh, n) != p) ++n;
    return n;
}

/// True if an element of the node has a vertex near the corner.
template <int D>
bool touches_corner(const QuadraticMesh<D>& mesh, std::size_t n) {
    for (std::size_t e = 0; e < mesh.linear.elements.size(); ++e) {
        bool has_node = false, is_present = false;
        for (const VertexId v : mesh.linear.elements.vertices[e]) {
            has_node = has_node || v.index() == n;
            is_present = is_present || is_at_corner<D>(mesh.linear.points[v]);
        }
        for (const EdgeId edge : mesh.edges.of_elements[e])
            has_node = has_node || mesh.linear.points.size() + edge.index() == n;
        if (has_node && is_present) return true;
    }
    return false;
}

inline TransferField rough_field(std::size_t nodes, int degree, int components, Dice& dice) {
    Buffer<double> values(nodes * static_cast<std::size_t>(components));
    for (double& u : values) u = dice.uniform(-1, 1);
    return {components, degree, std::move(values)};
}

inline double largest_difference(const TransferField& a, const TransferField& b) {
    double most = a.values.size() == b.values.size() ? 0 : 1e300;
    for (std::size_t i = 0; i < a.values.size() && i < b.values.size(); ++i)
        most = std::max(most, std::abs(a.values[i] - b.values[i]));
    return most;
}

template <int D>
Transferred transferred(const QuadraticMesh<D>& from, const std::vector<TransferField>& fields,
                        const QuadraticMesh<D>& to, const TransferOptions& options = {}, int threads = 1) {
    return must(transfer<D>(from, fields, to, options, Execution{.threads = threads}));
}

}  // namespace camber::testing
