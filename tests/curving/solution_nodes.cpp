// Nodes for a known solution: the expected error equals the interpolation error, never increases, and is summed over
// several fields.
#include <doctest/doctest.h>

#include <algorithm>
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
import camber.validity;

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

/// Barycentric coordinates of the lattice of an element.
template <int D>
constexpr auto lattice = [] {
    std::array<std::array<double, D + 1>, node_count<known_degree, D>> all{};
    for (std::size_t q = 0; q < all.size(); ++q)
        for (std::size_t v = 0; v <= D; ++v)
            all[q][v] = static_cast<double>(multi_indices<known_degree, D>[q][v]) / known_degree;
    return all;
}();

/// The position of barycentric coordinates in a curved element.
template <int D>
Vec<D> place_of(const QuadraticMesh<D>& mesh, ElementId e, const std::array<double, D + 1>& at) {
    Vec<D> x;
    for (std::size_t v = 0; v <= D; ++v) x += at[v] * mesh.linear.points[mesh.linear.elements.vertices[e][v]];
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        x += edge_shape<D>(at, k) * edge_of(mesh, mesh.edges.of_elements[e][k]).offset();
    return x;
}

/// Samples the fields. They are of degree 3, hence exact on straight elements.
template <int D>
KnownSolution<D> known(const QuadraticMesh<D>& mesh, std::span<const Cubic<D>> fields) {
    KnownSolution<D> out;
    for (const Cubic<D>& u : fields) {
        Buffer<std::array<float, node_count<known_degree, D>>> values(mesh.linear.elements.size());
        for (std::size_t e = 0; e < values.size(); ++e) {
            const double first = u(place_of(mesh, ElementId(e), lattice<D>[0]));
            for (std::size_t q = 0; q < values[e].size(); ++q)
                values[e][q] = static_cast<float>(u(place_of(mesh, ElementId(e), lattice<D>[q])) - first);
        }
        out.push_back({.values = std::move(values)});
    }
    return out;
}

template <int D>
SolutionInElements<D> in_elements(std::span<const Cubic<D>> fields) {
    return [fields](const QuadraticMesh<D>& mesh, const Execution&) -> Outcome<KnownSolution<D>> {
        return known(mesh, fields);
    };
}

template <int D>
SolutionNodes<D> moved(const Block<D>& b, const Column<LagrangeNode<D>>& start, std::span<const Cubic<D>> fields,
                       const SolutionNodesOptions& options = {}, const Execution& execution = one_thread) {
    return must(
        solution_nodes<D>({b.mesh, b.kinds, b.shells}, {&start, 1}, in_elements<D>(fields), options, execution));
}

/// The expected error of all fields with these nodes.
template <int D>
double expected(const Block<D>& b, const Column<LagrangeNode<D>>& nodes, std::span<const Cubic<D>> fields) {
    return moved<D>(b, nodes, fields, {.frames = 0}).before;
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
    return must(interpolation_error<D>(as_mesh(mesh), field, {}, one_thread)).curved.l2.value;
}

/// The block with nodes on its boundary surfaces and randomly displaced inner nodes.
template <int D>
Block<D> bent_block(std::uint64_t seed) {
    Dice dice(seed);
    Block<D> b = shell_block<D>(cells<D>, seed + 1);
    Buffer<LagrangeNode<D>> nodes(b.boundary_nodes.begin(), b.boundary_nodes.end());
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [p, q] = b.mesh.edges.vertices[e];
        if (b.kinds[EdgeId(e)] == EdgeKind::volume)
            nodes[e].point += 0.015 * norm(b.mesh.linear.points[q] - b.mesh.linear.points[p]) * dice.vector<D>(-1, 1);
    }
    b.mesh.mid_nodes = std::move(nodes);
    return b;
}

/// Random element-wise polynomials of degree 2 in reference coordinates.
template <int D>
KnownSolution<D> quadratic_within(const QuadraticMesh<D>& mesh, Dice& dice) {
    Buffer<std::array<float, node_count<known_degree, D>>> values(mesh.linear.elements.size());
    for (auto& of : values) {
        std::array<double, D + 1> vertices{};
        std::array<double, edges_per_simplex<D>> edges{};
        for (double& x : vertices) x = dice.uniform(-1, 1);
        for (double& x : edges) x = dice.uniform(-1, 1);
        for (std::size_t q = 0; q < of.size(); ++q) {
            double u = -vertices[0];
            for (std::size_t v = 0; v <= D; ++v) u += lattice<D>[q][v] * vertices[v];
            for (int k = 0; k < edges_per_simplex<D>; ++k) u += edge_shape<D>(lattice<D>[q], k) * edges[k];
            of[q] = static_cast<float>(u);
        }
    }
    return {{.values = std::move(values)}};
}

template <int D>
void check_curved_elements() {
    property("functions of degree 2 in the reference element have no expected error",
             [](std::uint64_t seed) {
                 Dice dice(seed + 2);
                 const auto b = bent_block<D>(seed);
                 const auto solution = quadratic_within(b.mesh, dice);
                 const SolutionInElements<D> known = [&](const QuadraticMesh<D>&, const Execution&) {
                     return Outcome<KnownSolution<D>>(solution);
                 };
                 const Column<LagrangeNode<D>> start = b.mesh.mid_nodes;
                 const auto result =
                     must(solution_nodes<D>({b.mesh, b.kinds, b.shells}, {&start, 1}, known, {}, one_thread));
                 RC_ASSERT(result.before < 1e-5);
             },
             {.count = 5});
    property("the search continues from its best start for any nodes of the mesh",
             [](std::uint64_t seed) {
                 Dice dice(seed + 2);
                 const auto bent = bent_block<D>(seed);
                 auto straight = bent;
                 straight.mesh = must(elevate(bent.mesh.linear, one_thread));
                 const std::array fields{Cubic<D>(dice, 0.5)};
                 const Column<LagrangeNode<D>> own = bent.mesh.mid_nodes;
                 const auto result = moved<D>(bent, own, fields);
                 RC_ASSERT(result.nodes == moved<D>(straight, own, fields).nodes);
                 const std::array starts{straight.mesh.mid_nodes, own};
                 const auto best = must(solution_nodes<D>({bent.mesh, bent.kinds, bent.shells}, starts,
                                                          in_elements<D>(fields), {}, one_thread));
                 RC_ASSERT(best.before == expected<D>(bent, starts[0], fields));
                 const std::size_t lower = best.before <= expected<D>(bent, own, fields) ? 0 : 1;
                 RC_ASSERT(best.nodes == moved<D>(bent, starts[lower], fields).nodes);
             },
             {.count = 5});
    property("a solution that is wrong away from its frame does not raise the expected error",
             [](std::uint64_t seed) {
                 Dice dice(seed + 2);
                 const auto b = bent_block<D>(seed);
                 const Cubic<D> u(dice, 0.5);
                 const Column<LagrangeNode<D>> start = b.mesh.mid_nodes;
                 // Adds a bubble next to the nodes, which interpolation does not sample and a search would follow.
                 const SolutionInElements<D> wrong = [&](const QuadraticMesh<D>& mesh, const Execution&) {
                     auto solution = known<D>(mesh, std::array{u});
                     Buffer<std::array<float, node_count<known_degree, D>>> values(solution[0].values.begin(),
                                                                                   solution[0].values.end());
                     for (std::size_t e = 0; e < values.size(); e += 3)
                         for (std::size_t q = 0; q < values[e].size(); ++q) {
                             double bubble =
                                 30 * std::sin(1e4 * mesh.mid_nodes[mesh.edges.of_elements[ElementId(e)][0]].point[0]);
                             for (const double x : lattice<D>[q]) bubble *= x;
                             values[e][q] += static_cast<float>(bubble);
                         }
                     solution[0].values = std::move(values);
                     return Outcome<KnownSolution<D>>(std::move(solution));
                 };
                 const auto result =
                     must(solution_nodes<D>({b.mesh, b.kinds, b.shells}, {&start, 1}, wrong, {}, one_thread));
                 RC_ASSERT(result.after <= result.before);
             },
             {.count = 3});
}

template <int D>
void check_solution_nodes() {
    property("the expected error equals the interpolation error and never rises",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells<D>, seed + 1);
                 const std::array fields{Cubic<D>(dice, 1)};
                 const Column<LagrangeNode<D>> straight = b.mesh.mid_nodes;
                 const auto result = moved<D>(b, straight, fields);
                 RC_ASSERT(std::abs(result.before / interpolated(b, straight, fields[0]) - 1) < 2e-3);
                 RC_ASSERT(std::abs(result.after / interpolated(b, result.nodes, fields[0]) - 1) < 5e-2);
                 RC_ASSERT(result.after <= result.before);
                 for (std::size_t e = 0; e < result.nodes.size(); ++e)
                     RC_ASSERT(b.kinds[EdgeId(e)] == EdgeKind::volume || result.nodes[e] == straight[e]);
             },
             {.count = 5});
    property("nodes from curved walls reduce the expected error by a tenth",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells<D>, seed + 1);
                 const std::array fields{Cubic<D>(dice, 0.3)};
                 const auto result = moved<D>(b, b.boundary_nodes, fields);
                 RC_ASSERT(result.frames > 0);
                 RC_ASSERT(result.after < 0.9 * result.before);
             },
             {.count = 5});
    property("nodes for two fields give at most the error of nodes for one of them",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells<D>, seed + 1);
                 const std::array both{Cubic<D>(dice, 0.5), Cubic<D>(dice, 0.5)};
                 const std::span<const Cubic<D>> all(both);
                 const auto result = moved<D>(b, b.boundary_nodes, all);
                 for (std::size_t i = 0; i < both.size(); ++i) {
                     const auto nodes = moved<D>(b, b.boundary_nodes, all.subspan(i, 1)).nodes;
                     RC_ASSERT(result.after <= 1.02 * expected<D>(b, nodes, all));
                 }
             },
             {.count = 5});
    property("nodes for a known solution do not depend on the number of threads",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells<D>, seed + 1);
                 const std::array fields{Cubic<D>(dice, 0.5)};
                 const auto one = moved<D>(b, b.boundary_nodes, fields);
                 for (const int threads : {2, 7}) {
                     const auto other = moved<D>(b, b.boundary_nodes, fields, {}, Execution{.threads = threads});
                     RC_ASSERT(other.nodes == one.nodes);
                     RC_ASSERT(other.after == one.after);
                 }
             },
             {.count = 2});
}

/// Rows of thin triangles along a circle, each row shifted by half a triangle. With straight edges some triangles are
/// inverted; with nodes on the arcs all are valid.
struct ThinRows {
    static constexpr double angle = 0.2, height = 0.0015;
    QuadraticMesh<2> mesh;
    Column<EdgeKind> kinds;
    Incidence<ElementId> shells;

    explicit ThinRows(std::uint64_t seed) {
        LatticeOptions<2> options;
        options.cells = {6, 5};
        options.seed = seed;
        options.place = [](const Vec<2>& p) { return p; };
        auto linear = lattice_mesh(options);
        linear.points = Column<Vec<2>>(must(map_each(one_thread, linear.points.size(), [&](std::size_t i) {
            const Vec<2>& p = linear.points[i];
            const double a = angle * (p[0] - p[1] / 2), r = 1 + height * p[1];
            return Vec<2>{{-r * std::cos(a), r * std::sin(a)}};
        })));
        mesh = must(elevate(std::move(linear), one_thread));
        shells = must(camber::shells(mesh.edges, one_thread));
        kinds = boundary_kinds(mesh.linear, mesh.edges);
        mesh.mid_nodes = nodes([](std::size_t) { return 0.0; });
    }

    /// Nodes in the middle in polar coordinates. Inner edges are moved outwards by a share of the row height.
    [[nodiscard]] Column<LagrangeNode<2>> nodes(const auto& share) const {
        Buffer<LagrangeNode<2>> all(mesh.edges.size());
        for (std::size_t e = 0; e < all.size(); ++e) {
            const Vec<2>&p = mesh.linear.points[mesh.edges.vertices[e][0]],
                  &q = mesh.linear.points[mesh.edges.vertices[e][1]];
            const double out = kinds[EdgeId(e)] == EdgeKind::volume ? share(e) * height : 0;
            all[e].point = ((norm(p) + norm(q)) / 2 + out) * normalised(normalised(p) + normalised(q));
        }
        return Column<LagrangeNode<2>>(std::move(all));
    }

    /// The smallest coefficient of det J of each element, relative to |det| of the straight element.
    [[nodiscard]] std::vector<double> jacobians(const Column<LagrangeNode<2>>& at) const {
        std::vector<double> all(mesh.linear.elements.size());
        for (std::size_t e = 0; e < all.size(); ++e) {
            const auto j = bounded_jacobian(nodal_form<2>(mesh.linear.points, at.view(),
                                                          mesh.linear.elements.vertices[e], mesh.edges.of_elements[e]));
            all[e] = *std::min_element(j.coefficients.begin(), j.coefficients.end()) / std::abs(j.straight);
        }
        return all;
    }
};

/// exp(-(r - 1)/δ) in the elements.
SolutionInElements<2> layer(double thickness) {
    return [thickness](const QuadraticMesh<2>& mesh, const Execution&) -> Outcome<KnownSolution<2>> {
        Buffer<std::array<float, node_count<known_degree, 2>>> values(mesh.linear.elements.size());
        const auto u = [&](std::size_t e, std::size_t q) {
            return std::exp(-(norm(place_of(mesh, ElementId(e), lattice<2>[q])) - 1) / thickness);
        };
        for (std::size_t e = 0; e < values.size(); ++e)
            for (std::size_t q = 0; q < values[e].size(); ++q) values[e][q] = static_cast<float>(u(e, q) - u(e, 0));
        return KnownSolution<2>{{.values = std::move(values)}};
    };
}

void check_thin_rows() {
    property("elements that are inverted when straight keep their Jacobian bound",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const ThinRows rows(seed + 1);
                 RC_ASSERT(std::ranges::any_of(rows.mesh.linear.elements.vertices, [&](const auto& v) {
                     const auto& x = rows.mesh.linear.points;
                     return cross(x[v[1]] - x[v[0]], x[v[2]] - x[v[0]]) < 0;
                 }));
                 Buffer<Vec<2>> offsets(rows.mesh.edges.size(), Vec<2>{});
                 for (std::size_t e = 0; e < offsets.size(); ++e)
                     if (rows.kinds[EdgeId(e)] == EdgeKind::volume)
                         offsets[e] = 2 * ThinRows::height * dice.vector<2>(-1, 1);
                 auto at = Buffer<LagrangeNode<2>>(rows.mesh.mid_nodes.begin(), rows.mesh.mid_nodes.end());
                 const double least = 0.1;
                 RC_ASSERT(std::ranges::min(rows.jacobians(rows.mesh.mid_nodes)) > least);
                 RC_ASSERT(must(limit_by_jacobian<2>(rows.mesh, rows.mesh.mid_nodes.view(), rows.shells, least, offsets,
                                                     one_thread)) > 0);
                 for (std::size_t e = 0; e < at.size(); ++e) at[e].point += offsets[e];
                 RC_ASSERT(std::ranges::min(rows.jacobians(Column<LagrangeNode<2>>(std::move(at)))) >= least);
             },
             {.count = 10});
    property("displaced nodes in a stack of thin elements return together",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const ThinRows rows(seed + 1);
                 const auto solution = layer(1.5 * ThinRows::height);
                 const auto start = rows.nodes([&](std::size_t) { return dice.uniform(0.1, 0.2); });
                 const auto search = [&](const Column<LagrangeNode<2>>& from, int frames) {
                     return must(solution_nodes<2>({rows.mesh, rows.kinds, rows.shells}, {&from, 1}, solution,
                                                   {.frames = frames}, one_thread));
                 };
                 const auto result = search(start, 4);
                 const double least = search(rows.mesh.mid_nodes, 0).before;
                 RC_ASSERT(result.before > 3 * least);
                 RC_ASSERT(result.after < least);
                 RC_ASSERT(std::ranges::min(rows.jacobians(result.nodes)) > 0);
             },
             {.count = 10});
}

}  // namespace

TEST_CASE("nodes for a known solution do not raise the expected interpolation error, 2D") { check_solution_nodes<2>(); }
TEST_CASE("nodes for a known solution do not raise the expected interpolation error, 3D") { check_solution_nodes<3>(); }
TEST_CASE("nodes for a solution sampled in curved elements do not raise the expected error, 2D") {
    check_curved_elements<2>();
}
TEST_CASE("nodes for a solution sampled in curved elements do not raise the expected error, 3D") {
    check_curved_elements<3>();
}
TEST_CASE("nodes for a known solution keep thin rows along a circle valid") { check_thin_rows(); }

namespace {

template <int D>
void check_expected_on_straight(std::uint64_t seed) {
    Dice dice(seed);
    const Block<D> b = shell_block<D>(cells<D>, seed + 1);
    const QuadraticMesh<D> mesh = must(elevate(b.mesh.linear, one_thread));
    const std::vector<Cubic<D>> fields{Cubic<D>(dice, 1), Cubic<D>(dice, 2)};
    const ScalarField<D> field = [&] {
        return PointFunction<D>([&](std::span<const Vec<D>> points, std::span<double> values) {
            for (std::size_t i = 0; i < points.size(); ++i) values[i] = fields[0](points[i]);
        });
    };
    const auto found = must(interpolation_error<D>(as_mesh(mesh), field, {}, one_thread));
    const auto known_one = known<D>(mesh, {fields.data(), 1});
    CHECK(must(expected_error(mesh.linear, known_one, 1, one_thread)) ==
          doctest::Approx(found.linear.l2.value).epsilon(2e-3));
    CHECK(must(expected_error(mesh.linear, known_one, 2, one_thread)) ==
          doctest::Approx(found.straight.l2.value).epsilon(2e-3));
    // Several fields: the root of the sum of squares with weights.
    auto both = known<D>(mesh, fields);
    both[1].weight = 3;
    const double first = must(expected_error(mesh.linear, known<D>(mesh, {fields.data(), 1}), 2, one_thread));
    const double second = must(expected_error(mesh.linear, known<D>(mesh, {fields.data() + 1, 1}), 2, one_thread));
    CHECK(must(expected_error(mesh.linear, both, 2, one_thread)) ==
          doctest::Approx(std::hypot(first, 3 * second)).epsilon(1e-9));
    // The error of one field in the unit of the user.
    auto scaled = known_one;
    scaled[0].exponent = -20;
    CHECK(must(expected_error(mesh.linear, scaled, 2, one_thread)) == std::ldexp(first, -20));
    CHECK(!expected_error(mesh.linear, known_one, 3, one_thread));
}

/// The field λ_v^5 on a straight mesh, with another vertex v in each element. The reference error is integrated with a
/// rule that is exact for it.
template <int D>
void check_degree_of_rule(std::uint64_t seed) {
    const Block<D> b = shell_block<D>(cells<D>, seed);
    const QuadraticMesh<D> mesh = must(elevate(b.mesh.linear, one_thread));
    const auto rule = conical_rule<D>(8);
    Buffer<std::array<float, node_count<known_degree, D>>> values(mesh.linear.elements.size());
    double square = 0;
    for (std::size_t e = 0; e < values.size(); ++e) {
        const std::size_t v = e % (D + 1);
        for (std::size_t q = 0; q < values[e].size(); ++q)
            values[e][q] = static_cast<float>(std::pow(lattice<D>[q][v], 5));
        std::array<Vec<D>, D + 1> corners;
        for (std::size_t k = 0; k <= D; ++k)
            corners[k] = mesh.linear.points[mesh.linear.elements.vertices[ElementId(e)][k]];
        const double det = std::abs(signed_volume<D>(corners));
        for (const auto& point : rule) {
            // The interpolant is 1 at the vertex and 1/32 at the middles of its edges: 4 λ (1 − λ)/32 for all edges
            // together.
            const double x = point.xi[v];
            const double residual = std::pow(x, 5) - x * (2 * x - 1) - x * (1 - x) / 8;
            square += point.weight * det * residual * residual;
        }
    }
    const KnownSolution<D> solution{{.values = std::move(values)}};
    CHECK(must(expected_error(mesh.linear, solution, 2, one_thread)) ==
          doctest::Approx(std::sqrt(square)).epsilon(1e-5));
    const SolutionInElements<D> known_solution = [&](const QuadraticMesh<D>&, const Execution&) {
        return Outcome<KnownSolution<D>>(solution);
    };
    const Column<LagrangeNode<D>> start = mesh.mid_nodes;
    const auto nodes =
        must(solution_nodes<D>({mesh, b.kinds, b.shells}, {&start, 1}, known_solution, {.frames = 0}, one_thread));
    CHECK(nodes.before == doctest::Approx(std::sqrt(square)).epsilon(1e-5));
    CHECK(nodes.after == nodes.before);
}

}  // namespace

TEST_CASE("the expected error is exact for polynomials of the known degree") {
    check_degree_of_rule<2>(1);
    check_degree_of_rule<3>(1);
}

TEST_CASE("the expected error on straight elements equals the interpolation error") {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        check_expected_on_straight<2>(seed);
        check_expected_on_straight<3>(seed);
    }
}
