// Nodes for a known solution: the expected error is the interpolant's, it never rises, and of several fields the sum
// counts.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
#include <rapidcheck.h>

#include "block.hpp"
#include "dice.hpp"
#include "meshes.hpp"
#include "property.hpp"

import camber.bezier;
import camber.core;
import camber.curving;
import camber.interpolation;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
constexpr std::array<int, D> cells = [] {
    if constexpr (D == 2)
        return std::array<int, 2>{5, 6};
    else
        return std::array<int, 3>{3, 3, 4};
}();

/// u = xᵀ H x/2 + T[x, x, x]/6.
template <int D>
struct Cubic {
    Sym<D> hessian;
    CubicForm<D> third;

    Cubic(Dice& dice, double of_third) : hessian(dice.symmetric<D>(1)) {
        for (double& t : third.c) t = of_third * dice.uniform(-1, 1);
    }
    [[nodiscard]] double operator()(const Vec<D>& x) const {
        return dot(x, hessian * x) / 2 + trilinear(third, x, x, x) / 6;
    }
};

/// Exactly, as these are of degree 3: at the lattices of the straight elements.
template <int D>
KnownSolution<D> known(const QuadraticMesh<D>& mesh, std::span<const Cubic<D>> fields) {
    KnownSolution<D> out;
    const LinearMesh<D>& linear = mesh.linear;
    for (const Cubic<D>& u : fields) {
        Buffer<std::array<float, node_count<known_degree, D>>> values(linear.elements.size());
        for (std::size_t e = 0; e < values.size(); ++e)
            for (std::size_t q = 0; q < values[e].size(); ++q) {
                Vec<D> x;
                for (std::size_t v = 0; v <= D; ++v)
                    x += (multi_indices<known_degree, D>[q][v] * (1.0 / known_degree)) *
                         linear.points[linear.elements.vertices[e][v]];
                values[e][q] = static_cast<float>(u(x) - u(linear.points[linear.elements.vertices[e][0]]));
            }
        out.push_back({.values = std::move(values)});
    }
    return out;
}

template <int D>
SolutionNodes<D> moved(const Block<D>& b, const Column<LagrangeNode<D>>& base, std::span<const Cubic<D>> fields,
                       const SolutionNodesOptions& options = {}, const Execution& execution = alone) {
    return must(solution_nodes<D>(b.mesh, b.kinds, base, b.shells, known(b.mesh, fields), options, execution));
}

template <int D>
Column<LagrangeNode<D>> after(const Column<LagrangeNode<D>>& base, const SolutionNodes<D>& made) {
    Buffer<LagrangeNode<D>> nodes(base.begin(), base.end());
    for (std::size_t e = 0; e < nodes.size(); ++e) nodes[e].point += made.moves[e];
    return nodes;
}

/// The error with these nodes, of all fields together.
template <int D>
double expected(const Block<D>& b, const Column<LagrangeNode<D>>& nodes, std::span<const Cubic<D>> fields) {
    return moved<D>(b, nodes, fields, {.rounds = 0}).before;
}

template <int D>
double interpolated(const Block<D>& b, const Column<LagrangeNode<D>>& nodes, const Cubic<D>& u) {
    QuadraticMesh<D> mesh = b.mesh;
    mesh.mid_nodes = nodes;
    const ScalarField<D> field = [&] {
        return PointFunction<D>([&](std::span<const Vec<D>> points, std::span<double> values) {
            for (std::size_t i = 0; i < points.size(); ++i) values[i] = u(points[i]);
        });
    };
    return must(interpolation_error<D>(mesh, field, {}, alone)).curved.l2.value;
}

template <int D>
void laws() {
    property(
        "the expected error is the interpolant's: on straight elements exactly, on moved ones nearly; it never rises, "
        "and boundary nodes stay",
        [](std::uint64_t seed) {
            Dice dice(seed);
            const auto b = shell_block<D>(cells<D>, seed + 1);
            const std::array fields{Cubic<D>(dice, 1)};
            const Column<LagrangeNode<D>> straight = b.mesh.mid_nodes;
            const auto made = moved<D>(b, straight, fields);
            RC_ASSERT(std::abs(made.before / interpolated(b, straight, fields[0]) - 1) < 2e-3);
            RC_ASSERT(std::abs(made.after / interpolated(b, after(straight, made), fields[0]) - 1) < 0.1);
            RC_ASSERT(made.after <= made.before);
            for (std::size_t e = 0; e < made.moves.size(); ++e)
                RC_ASSERT(b.kinds[EdgeId(e)] == EdgeKind::volume || made.moves[e] == Vec<D>{});
        },
        {.count = 5});
    property("from curved walls too, for a field that curves pay for",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells<D>, seed + 1);
                 const std::array fields{Cubic<D>(dice, 0.3)};
                 const auto made = moved<D>(b, b.boundary_nodes, fields);
                 RC_ASSERT(made.rounds > 0);
                 RC_ASSERT(made.after < 0.9 * made.before);
             },
             {.count = 5});
    property("of two fields the sum counts: it is less than with the nodes of either alone",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells<D>, seed + 1);
                 const std::array both{Cubic<D>(dice, 0.5), Cubic<D>(dice, 0.5)};
                 const std::span<const Cubic<D>> all(both);
                 const auto made = moved<D>(b, b.boundary_nodes, all);
                 for (std::size_t i = 0; i < both.size(); ++i) {
                     const auto nodes = after(b.boundary_nodes, moved<D>(b, b.boundary_nodes, all.subspan(i, 1)));
                     RC_ASSERT(made.after <= 1.02 * expected<D>(b, nodes, all));
                 }
             },
             {.count = 5});
    property("the same bytes for any number of threads",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells<D>, seed + 1);
                 const std::array fields{Cubic<D>(dice, 0.5)};
                 const auto one = moved<D>(b, b.boundary_nodes, fields);
                 for (const int threads : {2, 7}) {
                     const auto other = moved<D>(b, b.boundary_nodes, fields, {}, Execution{.threads = threads});
                     RC_ASSERT(other.moves == one.moves);
                     RC_ASSERT(other.after == one.after);
                 }
             },
             {.count = 2});
}

}  // namespace

TEST_CASE("nodes for a known solution: triangles") { laws<2>(); }
TEST_CASE("nodes for a known solution: tetrahedra") { laws<3>(); }
