// The objective shape: linear extension of the boundary displacement, and optimisation of the minimum Jacobian.
#include <algorithm>
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
import camber.extension;
import camber.metric;
import camber.validity;
import camber.optimisation;
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

/// The minimum distance of a vertex from the opposite face.
template <int D>
double smallest_height(const LinearMesh<D>& mesh, ElementId e) {
    Mat<D> m;
    for (int a = 0; a < D; ++a)
        m.column[a] = mesh.points[mesh.elements.vertices[e][a + 1]] - mesh.points[mesh.elements.vertices[e][0]];
    const Mat<D> gradients = transposed(inverse(m));
    Vec<D> last;
    double steepest = 0;
    for (int a = 0; a < D; ++a) {
        last -= gradients.column[a];
        steepest = std::max(steepest, norm(gradients.column[a]));
    }
    return 1 / std::max(steepest, norm(last));
}

template <int D>
void check_extension(const std::array<int, D>& cells) {
    property("extend_boundary minimises the energy for the nodes of the boundary",
             [&](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells, seed + 1);
                 const ExtensionOptions options{.tolerance = 1e-12, .stiffening = dice.uniform(0, 3)};
                 auto e = must(extend_boundary(b.mesh, b.kinds, b.boundary_nodes, b.shells, options, one_thread));
                 const double least = energy<D>(b.mesh, e.nodes, options.stiffening);
                 Buffer<LagrangeNode<D>> forward = e.nodes;
                 Buffer<LagrangeNode<D>> backward = e.nodes;
                 for (std::size_t k = 0; k < e.nodes.size(); ++k) {
                     if (b.kinds[k] != EdgeKind::volume) {
                         RC_ASSERT(e.nodes[k] == b.boundary_nodes[k]);
                         continue;
                     }
                     const Vec<D> v = dice.vector<D>(-0.01, 0.01);
                     forward[k].point += v;
                     backward[k].point -= v;
                 }
                 const double more = energy<D>(b.mesh, forward, options.stiffening);
                 const double other = energy<D>(b.mesh, backward, options.stiffening);
                 RC_ASSERT(more > least && other > least);
                 // Stationary point: the energy is quadratic, so it increases equally on both sides.
                 RC_ASSERT(std::abs(more - other) <= 1e-7 * (more - least));
             },
             {10});
    property(
        "extend_boundary meets its tolerance and solves no more of the mesh than needed",
        [&](std::uint64_t seed) {
            Dice dice(seed);
            const auto b = shell_block<D>(cells, seed + 1);
            // Moves the whole boundary or a single edge.
            Buffer<LagrangeNode<D>> boundary(b.boundary_nodes.begin(), b.boundary_nodes.end());
            if (dice.below(2) == 0) {
                std::size_t edge = dice.below(boundary.size());
                while (b.kinds[edge] == EdgeKind::volume) edge = (edge + 1) % boundary.size();
                boundary.assign(b.mesh.mid_nodes.begin(), b.mesh.mid_nodes.end());
                boundary[edge].point += dice.vector<D>(-0.05, 0.05);
            }
            const Column<LagrangeNode<D>> nodes(std::move(boundary));
            const auto extended = [&](double tolerance) {
                return must(extend_boundary(b.mesh, b.kinds, nodes, b.shells, {.tolerance = tolerance}, one_thread));
            };
            const double tolerance = std::pow(10.0, dice.uniform(-6, -2));
            const auto some = extended(tolerance);
            const auto all = extended(1e-12);
            RC_ASSERT(some.correction <= tolerance);
            RC_ASSERT(some.iterations <= all.iterations && some.solved <= all.solved);
            for (std::size_t e = 0; e < b.mesh.linear.elements.size(); ++e) {
                const double height = smallest_height(b.mesh.linear, ElementId(e));
                for (const EdgeId edge : b.mesh.edges.of_elements[e])
                    RC_ASSERT(distance(some.nodes[edge.index()].point, all.nodes[edge.index()].point) <=
                              20 * tolerance * height);
            }
        },
        {10});
    property(
        "extend_boundary is linear in the boundary and independent of threads",
        [&](std::uint64_t seed) {
            Dice dice(seed);
            const auto b = shell_block<D>(cells, seed + 1);
            const auto extended = [&](const Column<LagrangeNode<D>>& nodes, const Execution& execution) {
                return must(extend_boundary(b.mesh, b.kinds, nodes, b.shells, {.tolerance = 1e-12}, execution)).nodes;
            };
            const auto straight = must(extend_boundary(b.mesh, b.kinds, b.mesh.mid_nodes, b.shells, {}, one_thread));
            RC_ASSERT(Column<LagrangeNode<D>>(straight.nodes) == b.mesh.mid_nodes);
            RC_ASSERT(straight.iterations == 0 && straight.solved == 0);
            const auto once = extended(b.boundary_nodes, one_thread);
            for (const int threads : {2, 3})
                RC_ASSERT(once == extended(b.boundary_nodes, Execution{.threads = threads}));
            Buffer<LagrangeNode<D>> half(b.boundary_nodes.begin(), b.boundary_nodes.end());
            for (std::size_t k = 0; k < half.size(); ++k)
                half[k].point = midpoint(half[k].point, b.mesh.mid_nodes[k].point);
            const auto less = extended(Column<LagrangeNode<D>>(std::move(half)), one_thread);
            for (std::size_t k = 0; k < less.size(); ++k)
                RC_ASSERT(distance(less[k].point, midpoint(once[k].point, b.mesh.mid_nodes[k].point)) < 1e-9);
        },
        {10});
}

/// Geometrically growing layers on a wall with edges of length 0.4. The whole boundary is bent to spheres about the
/// centre.
template <int D>
void check_layers(const std::array<int, D>& cells) {
    for (const double growth : {2.0, 3.0, 4.0}) {
        const double last = std::pow(growth, cells[D - 1]) - 1;
        const auto radius = [&](double s) { return 1 + (std::pow(growth, s * cells[D - 1]) - 1) / last; };
        const auto b = shell_block<D>(cells, 1, radius);
        const auto& points = b.mesh.linear.points;
        Buffer<LagrangeNode<D>> nodes(b.mesh.mid_nodes.begin(), b.mesh.mid_nodes.end());
        for (std::size_t e = 0; e < nodes.size(); ++e) {
            const auto& [v, w] = b.mesh.edges.vertices[e];
            if (b.kinds[e] != EdgeKind::volume)
                nodes[e].point = (0.5 * (norm(points[v]) + norm(points[w]))) * normalised(nodes[e].point);
        }
        const Column<LagrangeNode<D>> boundary(std::move(nodes));
        auto extension = must(extend_boundary(b.mesh, b.kinds, boundary, b.shells, {}, one_thread));
        INFO("first layer of ", (growth - 1) / last, ", ", extension.iterations, " iterations");
        CHECK(extension.correction <= ExtensionOptions{}.tolerance);
        auto straight = must(curve_boundary(b.mesh, b.kinds, boundary, one_thread)).proposal;
        CHECK(must(validate(b.mesh, straight, 0, one_thread)).validation().smallest < 0);
        auto extended = straight;
        extended.mid_nodes = std::move(extension.nodes);
        CHECK(must(validate(b.mesh, extended, 0, one_thread)).validation().smallest > 0.5);
    }
}

template <int D>
void check_shape(const std::array<int, D>& cells) {
    property("shape keeps boundary nodes and lowers no minimum scaled Jacobian",
             [&](std::uint64_t seed) {
                 const auto b = shell_block<D>(cells, seed + 1);
                 const auto shaped =
                     must(shape(b.mesh, b.kinds, b.boundary_nodes, b.shells, ShapeOptions{}, one_thread));
                 for (std::size_t e = 0; e < b.mesh.edges.size(); ++e)
                     if (b.kinds[e] != EdgeKind::volume) RC_ASSERT(shaped.proposal.mid_nodes[e] == b.boundary_nodes[e]);
                 RC_ASSERT(shaped.smallest >= shaped.after_extension);
                 const auto validation = must(validate(b.mesh, shaped.proposal, 0, one_thread)).validation();
                 RC_ASSERT(validation.smallest >= shaped.smallest - 1e-6);
                 const auto straight = must(curve_boundary(b.mesh, b.kinds, b.boundary_nodes, one_thread));
                 RC_ASSERT(validation.smallest >=
                           must(validate(b.mesh, straight.proposal, 0, one_thread)).validation().smallest - 1e-3);
                 for (const int threads : {2, 3}) {
                     const auto again = must(shape(b.mesh, b.kinds, b.boundary_nodes, b.shells, ShapeOptions{},
                                                   Execution{.threads = threads}));
                     RC_ASSERT(again.proposal == shaped.proposal);
                     RC_ASSERT(again.steps == shaped.steps);
                 }
             },
             {6});
}

}  // namespace

TEST_CASE("extension minimises the stiffened energy within its tolerance, 2D") { check_extension<2>({6, 5}); }
TEST_CASE("extension minimises the stiffened energy within its tolerance, 3D") { check_extension<3>({3, 3, 3}); }
TEST_CASE("extension keeps layers of any anisotropy valid, 2D") { check_layers<2>({6, 12}); }
TEST_CASE("extension keeps layers of any anisotropy valid, 3D") { check_layers<3>({3, 3, 12}); }
TEST_CASE("the shape objective keeps boundary nodes and lowers no minimum Jacobian, 2D") { check_shape<2>({6, 5}); }
TEST_CASE("the shape objective keeps boundary nodes and lowers no minimum Jacobian, 3D") { check_shape<3>({3, 3, 3}); }

TEST_CASE("shape rejects columns whose length does not fit the mesh") {
    const auto b = shell_block<2>({3, 3}, 1);
    const auto wrong = shape(b.mesh, b.kinds, {}, b.shells, ShapeOptions{}, one_thread);
    REQUIRE_FALSE(wrong.has_value());
    CHECK(wrong.error().kind == ErrorKind::internal);
}

TEST_CASE("shape stops on request") {
    const auto b = shell_block<2>({3, 3}, 1);
    std::stop_source source;
    source.request_stop();
    const auto stopped_early = shape(b.mesh, b.kinds, b.boundary_nodes, b.shells, ShapeOptions{},
                                     Execution{.threads = 1, .stop = source.get_token()});
    REQUIRE_FALSE(stopped_early.has_value());
    CHECK(stopped_early.error().kind == ErrorKind::stopped);
}
