// Nodes for a known solution: the expected error is the interpolant's, it never rises, and of several fields the sum
// counts.
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

/// λ at the lattice of an element.
template <int D>
constexpr auto lattice = [] {
    std::array<std::array<double, D + 1>, node_count<known_degree, D>> all{};
    for (std::size_t q = 0; q < all.size(); ++q)
        for (std::size_t v = 0; v <= D; ++v)
            all[q][v] = static_cast<double>(multi_indices<known_degree, D>[q][v]) / known_degree;
    return all;
}();

/// Where that is in an element as the mesh has it.
template <int D>
Vec<D> place_of(const QuadraticMesh<D>& mesh, ElementId e, const std::array<double, D + 1>& at) {
    Vec<D> x;
    for (std::size_t v = 0; v <= D; ++v) x += at[v] * mesh.linear.points[mesh.linear.elements.vertices[e][v]];
    for (int k = 0; k < edges_per_simplex<D>; ++k)
        x += edge_shape<D>(at, k) * edge_of(mesh, mesh.edges.of_elements[e][k]).offset();
    return x;
}

/// On straight elements exactly, as these are of degree 3.
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
                       const SolutionNodesOptions& options = {}, const Execution& execution = alone) {
    return must(
        solution_nodes<D>({b.mesh, b.kinds, b.shells}, {&start, 1}, in_elements<D>(fields), options, execution));
}

/// The error with these nodes, of all fields together.
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
    return must(interpolation_error<D>(as_mesh(mesh), field, {}, alone)).curved.l2.value;
}

/// The block with nodes of its own: on the boundary where they belong, in the volume anywhere near.
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

/// Values in elements of polynomials of degree 2 in their own coordinates.
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
void laws_of_frames() {
    property("what is of degree 2 in the coordinates of curved elements is interpolated there",
             [](std::uint64_t seed) {
                 Dice dice(seed + 2);
                 const auto b = bent_block<D>(seed);
                 const auto solution = quadratic_within(b.mesh, dice);
                 const SolutionInElements<D> known = [&](const QuadraticMesh<D>&, const Execution&) {
                     return Outcome<KnownSolution<D>>(solution);
                 };
                 const Column<LagrangeNode<D>> start = b.mesh.mid_nodes;
                 const auto made = must(solution_nodes<D>({b.mesh, b.kinds, b.shells}, {&start, 1}, known, {}, alone));
                 RC_ASSERT(made.before < 1e-5);
             },
             {.count = 5});
    property("the search goes on from the best of its starts, whatever the nodes of the mesh",
             [](std::uint64_t seed) {
                 Dice dice(seed + 2);
                 const auto bent = bent_block<D>(seed);
                 auto straight = bent;
                 straight.mesh = must(elevate(bent.mesh.linear, alone));
                 const std::array fields{Cubic<D>(dice, 0.5)};
                 const Column<LagrangeNode<D>> own = bent.mesh.mid_nodes;
                 const auto made = moved<D>(bent, own, fields);
                 RC_ASSERT(made.nodes == moved<D>(straight, own, fields).nodes);
                 const std::array starts{straight.mesh.mid_nodes, own};
                 const auto best = must(solution_nodes<D>({bent.mesh, bent.kinds, bent.shells}, starts,
                                                          in_elements<D>(fields), {}, alone));
                 RC_ASSERT(best.before == expected<D>(bent, starts[0], fields));
                 const std::size_t lower = best.before <= expected<D>(bent, own, fields) ? 0 : 1;
                 RC_ASSERT(best.nodes == moved<D>(bent, starts[lower], fields).nodes);
             },
             {.count = 5});
    property("a solution that is told wrong away from its frame costs no accuracy",
             [](std::uint64_t seed) {
                 Dice dice(seed + 2);
                 const auto b = bent_block<D>(seed);
                 const Cubic<D> u(dice, 0.5);
                 const Column<LagrangeNode<D>> start = b.mesh.mid_nodes;
                 // Beside nodes a bubble, which interpolation does not see and a search would follow.
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
                 const auto made = must(solution_nodes<D>({b.mesh, b.kinds, b.shells}, {&start, 1}, wrong, {}, alone));
                 RC_ASSERT(made.after <= made.before);
             },
             {.count = 3});
}

template <int D>
void laws() {
    property(
        "the expected error is the interpolant's, with the nodes given and with those found; it never rises, and "
        "boundary nodes stay",
        [](std::uint64_t seed) {
            Dice dice(seed);
            const auto b = shell_block<D>(cells<D>, seed + 1);
            const std::array fields{Cubic<D>(dice, 1)};
            const Column<LagrangeNode<D>> straight = b.mesh.mid_nodes;
            const auto made = moved<D>(b, straight, fields);
            RC_ASSERT(std::abs(made.before / interpolated(b, straight, fields[0]) - 1) < 2e-3);
            RC_ASSERT(std::abs(made.after / interpolated(b, made.nodes, fields[0]) - 1) < 5e-2);
            RC_ASSERT(made.after <= made.before);
            for (std::size_t e = 0; e < made.nodes.size(); ++e)
                RC_ASSERT(b.kinds[EdgeId(e)] == EdgeKind::volume || made.nodes[e] == straight[e]);
        },
        {.count = 5});
    property("from curved walls too, for a field that curves pay for",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const auto b = shell_block<D>(cells<D>, seed + 1);
                 const std::array fields{Cubic<D>(dice, 0.3)};
                 const auto made = moved<D>(b, b.boundary_nodes, fields);
                 RC_ASSERT(made.frames > 0);
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
                     const auto nodes = moved<D>(b, b.boundary_nodes, all.subspan(i, 1)).nodes;
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
                     RC_ASSERT(other.nodes == one.nodes);
                     RC_ASSERT(other.after == one.after);
                 }
             },
             {.count = 2});
}

/// Rows of thin triangles along a circle, each row shifted by half a triangle: with straight edges a part of them is
/// inverted, with nodes in the middle in polar coordinates all are valid.
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
        linear.points = Column<Vec<2>>(must(map_each(alone, linear.points.size(), [&](std::size_t i) {
            const Vec<2>& p = linear.points[i];
            const double a = angle * (p[0] - p[1] / 2), r = 1 + height * p[1];
            return Vec<2>{{-r * std::cos(a), r * std::sin(a)}};
        })));
        mesh = must(elevate(std::move(linear), alone));
        shells = must(camber::shells(mesh.edges, alone));
        kinds = boundary_kinds(mesh.linear, mesh.edges);
        mesh.mid_nodes = nodes([](std::size_t) { return 0.0; });
    }

    /// Nodes in the middle in polar coordinates, those of inner edges farther out by a share of the rows' height.
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

    /// The smallest coefficient of det J of each element, as a share of the absolute value of the straight element's.
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

void laws_of_thin_rows() {
    property("elements that are inverted when straight keep the bound that they have",
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
                                                     alone)) > 0);
                 for (std::size_t e = 0; e < at.size(); ++e) at[e].point += offsets[e];
                 RC_ASSERT(std::ranges::min(rows.jacobians(Column<LagrangeNode<2>>(std::move(at)))) >= least);
             },
             {.count = 10});
    property("nodes that lie too far out in a stack of thin elements come back together",
             [](std::uint64_t seed) {
                 Dice dice(seed);
                 const ThinRows rows(seed + 1);
                 const auto solution = layer(1.5 * ThinRows::height);
                 const auto start = rows.nodes([&](std::size_t) { return dice.uniform(0.1, 0.2); });
                 const auto search = [&](const Column<LagrangeNode<2>>& from, int frames) {
                     return must(solution_nodes<2>({rows.mesh, rows.kinds, rows.shells}, {&from, 1}, solution,
                                                   {.frames = frames}, alone));
                 };
                 const auto made = search(start, 4);
                 const double least = search(rows.mesh.mid_nodes, 0).before;
                 RC_ASSERT(made.before > 3 * least);
                 RC_ASSERT(made.after < least);
                 RC_ASSERT(std::ranges::min(rows.jacobians(made.nodes)) > 0);
             },
             {.count = 10});
}

}  // namespace

TEST_CASE("nodes for a known solution: triangles") { laws<2>(); }
TEST_CASE("nodes for a known solution: tetrahedra") { laws<3>(); }
TEST_CASE("nodes for a solution known in curved elements: triangles") { laws_of_frames<2>(); }
TEST_CASE("nodes for a solution known in curved elements: tetrahedra") { laws_of_frames<3>(); }
TEST_CASE("nodes for a known solution: thin rows of triangles along a circle") { laws_of_thin_rows(); }

namespace {

template <int D>
void check_expected_on_straight(std::uint64_t seed) {
    Dice dice(seed);
    const Block<D> b = shell_block<D>(cells<D>, seed + 1);
    const QuadraticMesh<D> mesh = must(elevate(b.mesh.linear, alone));
    const std::vector<Cubic<D>> fields{Cubic<D>(dice, 1), Cubic<D>(dice, 2)};
    const ScalarField<D> field = [&] {
        return PointFunction<D>([&](std::span<const Vec<D>> points, std::span<double> values) {
            for (std::size_t i = 0; i < points.size(); ++i) values[i] = fields[0](points[i]);
        });
    };
    const auto found = must(interpolation_error<D>(as_mesh(mesh), field, {}, alone));
    const auto known_one = known<D>(mesh, {fields.data(), 1});
    CHECK(must(expected_error(mesh.linear, known_one, 1, alone)) ==
          doctest::Approx(found.linear.l2.value).epsilon(2e-3));
    CHECK(must(expected_error(mesh.linear, known_one, 2, alone)) ==
          doctest::Approx(found.straight.l2.value).epsilon(2e-3));
    // Several fields: the root of the sum of squares, each with its weight.
    auto both = known<D>(mesh, fields);
    both[1].weight = 3;
    const double first = must(expected_error(mesh.linear, known<D>(mesh, {fields.data(), 1}), 2, alone));
    const double second = must(expected_error(mesh.linear, known<D>(mesh, {fields.data() + 1, 1}), 2, alone));
    CHECK(must(expected_error(mesh.linear, both, 2, alone)) ==
          doctest::Approx(std::hypot(first, 3 * second)).epsilon(1e-9));
    // In the user's unit, of one field.
    auto scaled = known_one;
    scaled[0].exponent = -20;
    CHECK(must(expected_error(mesh.linear, scaled, 2, alone)) == std::ldexp(first, -20));
    CHECK(!expected_error(mesh.linear, known_one, 3, alone));
}

/// λ_v^5 in the elements, v another vertex from element to element, on a straight mesh, with its error by a rule that
/// is exact for it.
template <int D>
void check_degree_of_rule(std::uint64_t seed) {
    const Block<D> b = shell_block<D>(cells<D>, seed);
    const QuadraticMesh<D> mesh = must(elevate(b.mesh.linear, alone));
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
            // 1 at the vertex and 1/32 in the middles of its edges: 4 λ (1 − λ)/32 of all of them.
            const double x = point.xi[v];
            const double residual = std::pow(x, 5) - x * (2 * x - 1) - x * (1 - x) / 8;
            square += point.weight * det * residual * residual;
        }
    }
    const KnownSolution<D> solution{{.values = std::move(values)}};
    CHECK(must(expected_error(mesh.linear, solution, 2, alone)) == doctest::Approx(std::sqrt(square)).epsilon(1e-5));
    const SolutionInElements<D> known_solution = [&](const QuadraticMesh<D>&, const Execution&) {
        return Outcome<KnownSolution<D>>(solution);
    };
    const Column<LagrangeNode<D>> start = mesh.mid_nodes;
    const auto nodes =
        must(solution_nodes<D>({mesh, b.kinds, b.shells}, {&start, 1}, known_solution, {.frames = 0}, alone));
    CHECK(nodes.before == doctest::Approx(std::sqrt(square)).epsilon(1e-5));
    CHECK(nodes.after == nodes.before);
}

}  // namespace

TEST_CASE("the expected error is exact for polynomials of the known degree") {
    check_degree_of_rule<2>(1);
    check_degree_of_rule<3>(1);
}

TEST_CASE("the expected error on straight elements is that of the interpolant") {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
        check_expected_on_straight<2>(seed);
        check_expected_on_straight<3>(seed);
    }
}
