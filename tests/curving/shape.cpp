// The shape of elements as an aim: the linear extension of the boundary's displacement, and what programmes add.
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stop_token>
#include <utility>

#include "block.hpp"
#include "dice.hpp"
#include "property.hpp"

import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.programmes;
import camber.curving;

using namespace camber;
using namespace camber::testing;

namespace {

/// Σ over elements of (mean |det| / |det|)^stiffening ∫ |∇u|² dx for displacements u of the mid nodes, by the rule of
/// degree 2 on vertices and centre.
template <int D>
double energy(const QuadraticMesh<D>& mesh, const Buffer<LagrangeNode<D>>& nodes, double stiffening) {
    const auto& linear = mesh.linear;
    const auto edges_of = [&](std::size_t e) {
        Mat<D> m;
        for (int a = 0; a < D; ++a)
            m.column[a] =
                linear.points[linear.elements.vertices[e][a + 1]] - linear.points[linear.elements.vertices[e][0]];
        return m;
    };
    double mean = 0;
    for (std::size_t e = 0; e < linear.elements.size(); ++e)
        mean += std::abs(det(edges_of(e))) / static_cast<double>(linear.elements.size());
    double total = 0;
    for (std::size_t e = 0; e < linear.elements.size(); ++e) {
        const Mat<D> m = edges_of(e);
        const double volume = std::abs(det(m));
        const Mat<D> rows = transposed(inverse(m));
        std::array<Vec<D>, D + 1> gradient{};
        for (int a = 0; a < D; ++a) gradient[a + 1] = rows.column[a], gradient[0] -= rows.column[a];
        const auto density = [&](const Barycentric<D>& xi) {
            double sum = 0;
            for (int c = 0; c < D; ++c) {
                Vec<D> slope;
                for (int k = 0; k < edges_per_simplex<D>; ++k) {
                    const auto [i, j] = local_edges<D>[k];
                    const EdgeId edge = mesh.edges.of_elements[e][k];
                    const auto& [a, b] = mesh.edges.vertices[edge];
                    const double u = nodes[edge.index()].point[c] - midpoint(linear.points[a], linear.points[b])[c];
                    slope += (4 * u) * (xi[i] * gradient[j] + xi[j] * gradient[i]);
                }
                sum += norm_squared(slope);
            }
            return sum;
        };
        Barycentric<D> centre{};
        centre.fill(1.0 / (D + 1));
        double mean_density = (D + 1.0) / (D + 2) * density(centre);
        for (int i = 0; i <= D; ++i) {
            Barycentric<D> corner{};
            corner[i] = 1;
            mean_density += density(corner) / ((D + 1) * (D + 2));
        }
        total += std::pow(mean / volume, stiffening) * volume * mean_density;
    }
    return total;
}

template <int D>
void extension_laws(const std::array<int, D>& cells) {
    property("extend_boundary: the least energy with the boundary's nodes",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells, seed + 1);
                 const ExtensionOptions options{.tolerance = 1e-12, .stiffening = dice.uniform(0, 3)};
                 auto e = must(extend_boundary(b.mesh, b.kinds, b.boundary_nodes, b.shells, options, alone));
                 const double least = energy<D>(b.mesh, e.nodes, options.stiffening);
                 Buffer<LagrangeNode<D>> there = e.nodes;
                 Buffer<LagrangeNode<D>> opposite = e.nodes;
                 for (std::size_t k = 0; k < e.nodes.size(); ++k) {
                     if (b.kinds[k] != EdgeKind::volume) {
                         RC_ASSERT(e.nodes[k] == b.boundary_nodes[k]);
                         continue;
                     }
                     const Vec<D> v = dice.vector<D>(-0.01, 0.01);
                     there[k].point += v;
                     opposite[k].point -= v;
                 }
                 const double more = energy<D>(b.mesh, there, options.stiffening);
                 const double other = energy<D>(b.mesh, opposite, options.stiffening);
                 RC_ASSERT(more > least && other > least);
                 // Stationary: the energy is quadratic, so both sides rise alike.
                 RC_ASSERT(std::abs(more - other) <= 1e-7 * (more - least));
             },
             {10});
    property(
        "extend_boundary: straight where the boundary is, in scale with it, whatever the threads",
        [&](std::uint64_t seed) {
            Dice dice(seed);
            const auto b = shell_block<D>(cells, seed + 1);
            const auto extended = [&](const Column<LagrangeNode<D>>& nodes, const Execution& execution) {
                return must(extend_boundary(b.mesh, b.kinds, nodes, b.shells, ExtensionOptions{}, execution)).nodes;
            };
            RC_ASSERT(Column<LagrangeNode<D>>(extended(b.mesh.mid_nodes, alone)) == b.mesh.mid_nodes);
            const auto once = extended(b.boundary_nodes, alone);
            RC_ASSERT(once == extended(b.boundary_nodes, Execution{.threads = 3}));
            Buffer<LagrangeNode<D>> half(b.boundary_nodes.begin(), b.boundary_nodes.end());
            for (std::size_t k = 0; k < half.size(); ++k)
                half[k].point = midpoint(half[k].point, b.mesh.mid_nodes[k].point);
            const auto less = extended(Column<LagrangeNode<D>>(std::move(half)), alone);
            for (std::size_t k = 0; k < less.size(); ++k)
                RC_ASSERT(distance(less[k].point, midpoint(once[k].point, b.mesh.mid_nodes[k].point)) < 1e-9);
        },
        {10});
}

template <int D>
void shape_laws(const std::array<int, D>& cells) {
    property("shape: boundary nodes stay, and no step lowers the smallest scaled Jacobian",
             [&](std::uint64_t seed) {
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto shaped = must(shape(b.mesh, b.kinds, b.boundary_nodes, b.shells, ShapeOptions{}, alone));
                 for (std::size_t e = 0; e < b.mesh.edges.size(); ++e)
                     if (b.kinds[e] != EdgeKind::volume) RC_ASSERT(shaped.proposal.mid_nodes[e] == b.boundary_nodes[e]);
                 RC_ASSERT(shaped.smallest >= shaped.after_extension);
                 const auto validation = must(validate(b.mesh, shaped.proposal, 0, alone)).validation();
                 RC_ASSERT(validation.smallest >= shaped.smallest - 1e-6);
                 const auto straight = must(curve_boundary(b.mesh, b.kinds, b.boundary_nodes, alone));
                 RC_ASSERT(validation.smallest >=
                           must(validate(b.mesh, straight.proposal, 0, alone)).validation().smallest - 1e-3);
                 // The extension itself is made by threads; steps are taken one after the other.
                 const auto again =
                     must(shape(b.mesh, b.kinds, b.boundary_nodes, b.shells, ShapeOptions{}, Execution{.threads = 2}));
                 RC_ASSERT(again.proposal == shaped.proposal);
             },
             {6});
}

}  // namespace

TEST_CASE("extension: triangles") { extension_laws<2>({6, 5}); }
TEST_CASE("extension: tetrahedra") { extension_laws<3>({3, 3, 3}); }
TEST_CASE("shape: triangles") { shape_laws<2>({6, 5}); }
TEST_CASE("shape: tetrahedra") { shape_laws<3>({3, 3, 3}); }

TEST_CASE("shape: columns that do not fit, and stopping") {
    const auto b = shell_block<2>({3, 3}, 1);
    const auto wrong = shape(b.mesh, b.kinds, {}, b.shells, ShapeOptions{}, alone);
    REQUIRE_FALSE(wrong.has_value());
    CHECK(wrong.error().kind == ErrorKind::internal);
    std::stop_source source;
    source.request_stop();
    const auto stopped_early = shape(b.mesh, b.kinds, b.boundary_nodes, b.shells, ShapeOptions{},
                                     Execution{.threads = 1, .stop = source.get_token()});
    REQUIRE_FALSE(stopped_early.has_value());
    CHECK(stopped_early.error().kind == ErrorKind::stopped);
}
