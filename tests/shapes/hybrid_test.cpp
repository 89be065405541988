// Meshes of several shapes and degrees: nodes, edges, faces, and conversion from and to simplices.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "dice.hpp"
#include "meshes.hpp"

import camber.core;
import camber.bezier;
import camber.shapes;

using namespace camber;
using namespace camber::testing;

namespace {

ShellOptions<3> prisms() {
    ShellOptions<3> options;
    options.outer_radius = 2;
    options.inner_size = options.outer_size = 0.7;
    options.inner_layer = {.count = 2, .first_height = 0.1, .growth = 1.5};
    return options;
}

/// Returns the mesh with its vertices in random order, so that edges and faces have all orientations in their elements.
template <int D>
Mesh<D> renumbered(Mesh<D> mesh, std::uint64_t seed) {
    Dice dice(seed);
    std::vector<std::size_t> to(mesh.points.size());
    std::iota(to.begin(), to.end(), std::size_t{0});
    for (std::size_t i = to.size(); i > 1; --i) std::swap(to[i - 1], to[dice.below(i)]);
    Buffer<Vec<D>> points(mesh.points.size());
    for (std::size_t v = 0; v < to.size(); ++v) points[to[v]] = mesh.points[v];
    const auto renumber = [&]<Shape shape>(Cells<shape>& cells) {
        Buffer<ShapeVertices<shape>> rows(cells.vertices.begin(), cells.vertices.end());
        for (auto& row : rows)
            for (VertexId& v : row) v = VertexId(to[v.index()]);
        cells.vertices = std::move(rows);
    };
    each_shape<D>([&]<Shape shape>() { renumber.template operator()<shape>(mesh.elements.template of<shape>()); });
    each_shape<D - 1>([&]<Shape shape>() { renumber.template operator()<shape>(mesh.facets.template of<shape>()); });
    renumber.template operator()<Shape::line>(mesh.edges);
    mesh.points = std::move(points);
    return mesh;
}

/// Position of a reference point in a straight cell, by the linear functions of its corners.
template <Shape shape, int D>
Vec<D> straight_point(const std::array<Vec<D>, shape_table<shape>.corner_count>& corners, ReferencePoint x) {
    Vec<D> p;
    if constexpr (shape == Shape::pyramid) {
        const double rest = 1 - x[2];
        if (rest < 1e-9) return corners[4];
        const auto base = lagrange_functions<Shape::quadrilateral, 1>({x[0] / rest, x[1] / rest, 0}).values;
        for (std::size_t c = 0; c < 4; ++c) p += rest * base[c] * corners[c];
        return p + x[2] * corners[4];
    } else {
        const auto values = lagrange_functions<shape, 1>(x).values;
        for (std::size_t c = 0; c < corners.size(); ++c) p += values[c] * corners[c];
        return p;
    }
}

/// Checks the nodes of each straight cell and of its bent image; returns the latter.
template <int K, int D>
std::set<std::array<double, D>> checked_nodes(const Mesh<D>& straight) {
    const auto bent = [](const Vec<D>& p) {
        Vec<D> q = 2.0 * p;
        q[0] += 0.1 * p[1] * p[1];
        return q;
    };
    const Mesh<D> mesh = map_nodes(straight, bent);
    std::set<std::array<double, D>> all;
    std::size_t cells = 0;
    double worst = 0;
    each_block_of<K>(straight, [&]<Shape shape, int degree>(const CellBlock<shape, degree, D>& block) {
        CHECK(block.first() == cells);
        cells += block.size();
        for (std::size_t i = 0; i < block.size(); ++i) {
            const auto nodes = block[i].nodes;
            std::array<Vec<D>, shape_table<shape>.corner_count> corners;
            for (std::size_t c = 0; c < corners.size(); ++c) {
                corners[c] = straight.points[block.cells().vertices[i][c]];
                CHECK(nodes[c] == corners[c]);
            }
            for (std::size_t n = 0; n < nodes.size(); ++n) {
                ReferencePoint x{};
                for (std::size_t d = 0; d < 3; ++d) x[d] = double(lagrange_nodes<shape, degree>[n][d]) / degree;
                worst = std::max(worst, distance(nodes[n], straight_point<shape, D>(corners, x)));
            }
        }
    });
    CHECK(worst < 1e-14);
    std::vector<Vec<D>> expected;
    each_block_of<K>(straight, [&](const auto& block) {
        for (std::size_t i = 0; i < block.size(); ++i)
            for (const Vec<D>& p : block[i].nodes) expected.push_back(bent(p));
    });
    std::size_t next = 0;
    each_block_of<K>(mesh, [&](const auto& block) {
        for (std::size_t i = 0; i < block.size(); ++i)
            for (const Vec<D>& p : block[i].nodes) {
                CHECK(p == expected[next++]);
                all.insert(p.c);
            }
    });
    return all;
}

/// Checks the order of the rows of `MeshEntities`.
template <int D>
void check_order(const MeshEntities<D>& of) {
    CHECK(std::ranges::is_sorted(of.edges));
    CHECK(std::ranges::is_sorted(of.triangles));
    CHECK(std::ranges::is_sorted(of.quadrilaterals));
    for (const auto& [a, b] : of.edges) CHECK(a < b);
    for (const auto& v : of.triangles) CHECK(std::ranges::is_sorted(v));
    for (const auto& v : of.quadrilaterals) {
        CHECK(v[0] == *std::ranges::min_element(v));
        CHECK(v[1] < v[3]);
    }
}

template <int D>
void check_mesh(const Mesh<D>& linear) {
    for (int degree = 1; degree <= max_degree; ++degree) {
        CAPTURE(degree);
        const Mesh<D> mesh = must(elevate(renumbered(linear, std::uint64_t(degree)), degree, one_thread));
        CHECK(mesh == must(elevate(renumbered(linear, std::uint64_t(degree)), degree, Execution{.threads = 3})));
        check_order(mesh.entities);
        const auto of_facets = checked_nodes<D - 1>(mesh);
        if constexpr (D == 3) CHECK(std::ranges::includes(of_facets, checked_nodes<1>(mesh)));
        if (count_elements(mesh) == 0) {
            CHECK(of_facets.size() == count_nodes(mesh));
            continue;
        }
        const auto of_elements = checked_nodes<D>(mesh);
        CHECK(of_elements.size() == count_nodes(mesh));  // all nodes, once each
        CHECK(std::ranges::includes(of_elements, of_facets));
        if (D == 3 && degree > 2) {
            const auto& of = mesh.entities;
            const auto faces = of.triangles.size() + of.quadrilaterals.size();
            const auto euler = std::ptrdiff_t(mesh.points.size() - of.edges.size() + faces - count_elements(mesh));
            CHECK((euler == 1 || euler == 2));  // 1 for a ball, 2 for a shell
        }
        Mesh<D> again = mesh;  // reset to degree 1, which discards the nodes of the other degree
        again.degree = 1;
        for (const int next : {1, 2})
            CHECK(must(elevate(again, next, one_thread)) ==
                  must(elevate(renumbered(linear, std::uint64_t(degree)), next, one_thread)));
    }
}

/// Adds a feature edge along a side of each facet.
Mesh<3> with_feature_edges(Mesh<3> mesh) {
    Buffer<ShapeVertices<Shape::line>> rows;
    each_shape<2>([&]<Shape shape>() {
        for (const auto& v : mesh.facets.of<shape>().vertices) rows.push_back({v[1], v[0]});
    });
    mesh.edges.references = Buffer<Reference>(rows.size(), 3);
    mesh.edges.vertices = std::move(rows);
    return mesh;
}

/// The smallest det J at the nodes of elements; for pyramids the smallest determinant of the edges at the corners of
/// the base.
template <int D>
double smallest_jacobian(const Mesh<D>& mesh) {
    double smallest = 1;
    each_block(mesh, [&]<Shape shape, int degree>(const CellBlock<shape, degree, D>& block) {
        if constexpr (shape == Shape::pyramid)
            for (std::size_t i = 0; i < block.size(); ++i) {
                const auto p = block[i].nodes;
                for (std::size_t c = 0; c < 4; ++c)
                    smallest = std::min(smallest, det(p[(c + 1) % 4] - p[c], p[(c + 3) % 4] - p[c], p[4] - p[c]));
            }
        else
            for (std::size_t i = 0; i < block.size(); ++i) {
                const auto element = block[i];
                for (const auto& at : lagrange_nodes<shape, degree>) {
                    ReferencePoint x{};
                    for (std::size_t d = 0; d < 3; ++d) x[d] = double(at[d]) / degree;
                    const auto functions = lagrange_functions<shape, degree>(x);
                    Mat<D> j;
                    for (std::size_t n = 0; n < element.nodes.size(); ++n)
                        for (int r = 0; r < D; ++r)
                            for (int c = 0; c < D; ++c)
                                j.column[c][r] += functions.gradients[n][c] * element.nodes[n][r];
                    smallest = std::min(smallest, det(j));
                }
            }
    });
    return smallest;
}

template <int D>
LinearMesh<D> box_of_simplices(std::uint64_t seed) {
    BoxOptions<D> options;
    options.cells.fill(3);
    options.seed = seed;
    LinearMesh<D> mesh = must(generate(options));
    mesh.required_vertices = Buffer<VertexId>{VertexId(std::size_t{1})};
    mesh.facets.required = Buffer<std::uint32_t>{0};
    mesh.groups = Buffer<Group>{{D, 1, "air"}};
    mesh.elements.entities = Buffer<Reference>(mesh.elements.size(), 4);
    mesh.facets.entities = Buffer<Reference>(mesh.facets.size(), 5);
    mesh.geometry.on_points = Buffer<Association<0>>{{VertexId(std::size_t{0}), 7, {}, {}}};
    return mesh;
}

template <int D>
QuadraticMesh<D> quadratic_box(std::uint64_t seed) {
    Dice dice(seed);
    QuadraticMesh<D> mesh = must(elevate(box_of_simplices<D>(seed), one_thread));
    Buffer<LagrangeNode<D>> nodes(mesh.mid_nodes.begin(), mesh.mid_nodes.end());
    for (auto& [p] : nodes) p += 0.01 * dice.template vector<D>();
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

template <int D>
void check_conversions() {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        const LinearMesh<D> linear = box_of_simplices<D>(seed);
        CHECK(must(as_linear(as_mesh(linear))) == linear);
        CHECK(as_mesh(linear).points.data() == linear.points.data());
        CHECK(must(elevate(as_mesh(linear), 2, one_thread)) == as_mesh(must(elevate(linear, one_thread))));
        const QuadraticMesh<D> quadratic = quadratic_box<D>(seed);
        const Mesh<D> mesh = as_mesh(quadratic);
        CHECK(mesh.degree == 2);
        const QuadraticMesh<D> back = must(as_quadratic(mesh));
        CHECK(back == quadratic);
        CHECK(back.mid_nodes.data() == quadratic.mid_nodes.data());
        CHECK(back.edges.of_elements.data() == quadratic.edges.of_elements.data());
        CHECK(as_mesh(back) == mesh);
        CHECK_FALSE(as_linear(mesh).has_value());
        CHECK_FALSE(as_quadratic(as_mesh(linear)).has_value());
        std::size_t elements = 0;
        each_block(mesh, [&]<Shape shape, int degree>(const CellBlock<shape, degree, D>& block) {
            CHECK(shape == simplex<D>);
            CHECK(degree == 2);
            for (std::size_t i = 0; i < block.size(); ++i, ++elements)
                if constexpr (degree == 2)
                    for (int e = 0; e < edges_per_simplex<D>; ++e)
                        CHECK(block[i].nodes[std::size_t(D + 1 + e)] ==
                              quadratic.mid_nodes[quadratic.edges.of_elements[i][e]].point);
        });
        CHECK(elements == quadratic.linear.elements.size());
    }
}

}  // namespace

TEST_CASE("simplex meshes are converted to general meshes and back with the same columns") {
    check_conversions<2>();
    check_conversions<3>();
}

TEST_CASE("each cell of a plate has its own nodes in order at every degree") {
    check_mesh(must(generate_plate({4, 3})));
    check_mesh(must(generate_plate_in_space({4, 3})));
}

TEST_CASE("each cell of a hybrid mesh has its own nodes in order at every degree") {
    check_mesh(with_feature_edges(must(generate_hexahedra({2, 3, 2}))));
    check_mesh(with_feature_edges(must(generate_pyramids({2, 2, 3}))));
    check_mesh(with_feature_edges(must(generate_prisms(prisms()))));
}

TEST_CASE("edges that all meet in one vertex do not depend on the number of threads") {
    const std::size_t n = 20000;  // triangles around vertex 0
    Mesh<2> fan;
    Buffer<Vec<2>> points(n + 1);
    Buffer<ShapeVertices<Shape::triangle>> rows(n);
    for (std::size_t i = 0; i < n; ++i) {
        const double angle = 6.283185307179586 * double(i) / double(n);
        points[i + 1] = {{camber::cos(angle), camber::sin(angle)}};
        rows[i] = {VertexId(std::size_t{0}), VertexId(i + 1), VertexId((i + 1) % n + 1)};
    }
    fan.points = std::move(points);
    fan.elements.of<Shape::triangle>().vertices = std::move(rows);
    const Mesh<2> one = must(elevate(fan, 3, one_thread));
    CHECK(one.entities.edges.size() == 2 * n);
    for (int run = 0; run < 3; ++run) CHECK(must(elevate(fan, 3, Execution{.threads = 4})) == one);
}

TEST_CASE("facets of generated meshes face outwards and have the references of their sides") {
    const auto check = [](const Mesh<3>& mesh, auto outwards, auto reference) {
        each_block_of<2>(mesh, [&](const auto& facets) {
            for (std::size_t i = 0; i < facets.size(); ++i) {
                const auto p = facets[i].nodes;
                const std::size_t corners = facets.cells().vertices[i].size();
                Vec<3> mean;
                for (std::size_t c = 0; c < corners; ++c) mean += p[c] / double(corners);
                CHECK(dot(cross(p[1] - p[0], p[2] - p[0]), outwards(mean)) > 0);
                CHECK(facets.cells().references[i] == reference(mean));
            }
        });
    };
    const auto side = [](const Vec<3>& p) {
        for (int d = 0; d < 3; ++d)
            for (const int end : {0, 1})
                if (std::abs(p[d] - end) < 1e-9) return std::pair(d, end);
        return std::pair(3, 0);
    };
    const auto from_centre = [&](const Vec<3>& p) {
        Vec<3> n;
        n[side(p).first] = side(p).second == 0 ? -1 : 1;
        return n;
    };
    const auto of_side = [&](const Vec<3>& p) { return Reference(2 * side(p).first + 1 + side(p).second); };
    check(must(generate_hexahedra({2, 3, 2})), from_centre, of_side);
    check(must(generate_pyramids({2, 2, 3})), from_centre, of_side);
    check(
        must(generate_prisms(prisms())), [](const Vec<3>& p) { return norm(p) < 1.5 ? -p : p; },
        [](const Vec<3>& p) { return Reference(norm(p) < 1.5 ? 2 : 1); });
}

TEST_CASE("hybrid meshes are valid before and after bending") {
    for (const double share : {0.0, 0.02, 0.05})
        for (const int degree : {1, 2, 3, 5}) {
            CHECK(smallest_jacobian(bend(must(elevate(must(generate_plate({4, 3})), degree, one_thread)), share)) > 0);
            CHECK(smallest_jacobian(
                      bend(must(elevate(must(generate_hexahedra({2, 2, 2})), degree, one_thread)), share)) > 0);
            CHECK(smallest_jacobian(
                      bend(must(elevate(must(generate_pyramids({2, 2, 3})), degree, one_thread)), share)) > 0);
            CHECK(smallest_jacobian(bend(must(elevate(must(generate_prisms(prisms())), degree, one_thread)), share)) >
                  0);
        }
}

TEST_CASE("hybrid meshes have the expected shapes of cells and facets") {
    const Mesh<3> prism_shell = must(generate_prisms(prisms()));
    CHECK(bend(prism_shell, 0.02).points != prism_shell.points);
    CHECK(prism_shell.elements.of<Shape::prism>().size() > 50);
    CHECK(prism_shell.elements.of<Shape::tetrahedron>().size() > 50);
    for (const Reference reference : prism_shell.facets.of<Shape::triangle>().references)
        CHECK((reference == 1 || reference == 2));
    const Mesh<3> pyramids = must(generate_pyramids({2, 2, 3}));
    CHECK(pyramids.elements.of<Shape::pyramid>().size() == 4);
    CHECK(pyramids.elements.of<Shape::hexahedron>().size() == 4);
    CHECK(pyramids.facets.of<Shape::quadrilateral>().size() == 4 + 8);
}

TEST_CASE("invalid conversions are rejected with the reason") {
    const auto message = [](const auto& outcome) { return outcome.has_value() ? std::string() : outcome.error().what; };
    const Mesh<3> hybrid = must(generate_pyramids({1, 1, 3}));
    CHECK(message(as_linear(hybrid)) ==
          "has 5 quadrilaterals, 1 pyramid, 1 hexahedron, but this operation needs a mesh of simplices only");
    CHECK(message(as_quadratic(hybrid)) == "is of degree 1, but this operation needs a mesh of degree 2");
    CHECK(message(elevate(hybrid, 6, one_thread)) == "the degree must be from 1 to 5, got 6");
    CHECK(message(elevate(hybrid, 0, one_thread)) == "the degree must be from 1 to 5, got 0");
    CHECK(message(elevate(must(elevate(hybrid, 3, one_thread)), 4, one_thread)) ==
          "is of degree 3, but the degree can be raised only from 1");
    Mesh<3> twice = hybrid;
    ShapeVertices<Shape::hexahedron> same;
    same.fill(VertexId(std::size_t{0}));
    twice.elements.of<Shape::hexahedron>().vertices = Buffer<ShapeVertices<Shape::hexahedron>>{same};
    CHECK(message(elevate(twice, 2, one_thread)) == "names vertex 1 twice");
    Mesh<3> beyond = hybrid;
    beyond.points = Buffer<Vec<3>>(5);
    CHECK(message(elevate(beyond, 2, one_thread)).find("of 5") != std::string::npos);
    CHECK(must(elevate(Mesh<3>{}, 4, one_thread)).points.size() == 0);
    CHECK_FALSE(generate_hexahedra({0, 1, 1}).has_value());
    CHECK_FALSE(generate_pyramids({1, 1, 2}).has_value());
    CHECK_FALSE(generate_prisms(ShellOptions<3>{}).has_value());
    ShellOptions<3> wrong = prisms();
    wrong.inner_layer.first_height = -0.1;
    CHECK_FALSE(generate_prisms(wrong).has_value());
    CHECK_FALSE(generate_plate({100000, 100000}).has_value());
}
