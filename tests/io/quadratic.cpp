// Variants of degree-2 GMF files: node orders, control points, mixed degrees and Gmsh's rows.
#include "any_mesh.hpp"
#include "generated.hpp"
#include "property.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numeric>
#include <string>
#include <variant>
#include <vector>

using namespace camber;

namespace {

std::string words(const auto& numbers) {
    std::string text;
    for (const auto n : numbers) text += std::to_string(n) + " ";
    return text;
}

/// Degree-2 rows of the mesh in the encoder's numbering, from 1, without references.
template <int K, class EdgesOf>
std::vector<std::array<std::size_t, quadratic_nodes<K>>> rows(const Simplices<K>& kind, const EdgesOf& edges_of,
                                                              std::size_t vertices) {
    std::vector<std::array<std::size_t, quadratic_nodes<K>>> all(kind.size());
    for (std::size_t i = 0; i < kind.size(); ++i) {
        for (std::size_t n = 0; n <= K; ++n) all[i][n] = kind.vertices[i][n].index() + 1;
        for (std::size_t e = 0; e < edges_per_simplex<K>; ++e) {
            if constexpr (K == 1)
                all[i][K + 1 + e] = vertices + edges_of[i].index() + 1;
            else
                all[i][K + 1 + e] = vertices + edges_of[i][e].index() + 1;
        }
    }
    return all;
}

/// Barycentric exponents of the local nodes in Vizir's default order.
template <int K>
std::vector<std::vector<int>> exponents() {
    std::vector<std::vector<int>> all;
    for (int v = 0; v <= K; ++v) {
        all.emplace_back(K + 1);
        all.back()[static_cast<std::size_t>(v)] = 2;
    }
    for (const auto& [a, b] : local_edges<K>) {
        all.emplace_back(K + 1);
        all.back()[static_cast<std::size_t>(a)] = all.back()[static_cast<std::size_t>(b)] = 1;
    }
    return all;
}

/// The rows and the Ordering block of one kind of simplices in a random order of nodes.
template <int K>
std::string permuted(const std::string& name, const Simplices<K>& kind, const auto& edges_of, std::size_t vertices,
                     generated::Random& random) {
    std::array<std::size_t, quadratic_nodes<K>> order;
    std::iota(order.begin(), order.end(), std::size_t{0});
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
    std::string text = name + "Ordering " + std::to_string(order.size()) + "\n";
    for (const std::size_t node : order) {
        auto row = exponents<K>()[node];
        if (K == 1) row.resize(1);
        text += words(row) + "\n";
    }
    text += name + " " + std::to_string(kind.size()) + "\n";
    const auto all = rows<K>(kind, edges_of, vertices);
    for (std::size_t i = 0; i < all.size(); ++i) {
        for (const std::size_t node : order) text += std::to_string(all[i][node]) + " ";
        text += std::to_string(kind.references[i]) + "\n";
    }
    return text;
}

std::string points_text(const QuadraticMesh<3>& mesh, bool control_points) {
    const auto& points = mesh.linear.points;
    std::string text =
        "MeshVersionFormatted 2 Dimension 3 Vertices " + std::to_string(points.size() + mesh.mid_nodes.size()) + "\n";
    const auto put = [&](const Vec<3>& p) {
        char line[120];
        std::snprintf(line, sizeof line, "%.17g %.17g %.17g 0\n", p[0], p[1], p[2]);
        text += line;
    };
    for (const auto& p : points) put(p);
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        put(control_points ? control_point(points[a], mesh.mid_nodes[e], points[b]).point : mesh.mid_nodes[e].point);
    }
    return text;
}

/// A mesh with valid geometry: a strip along a screw, nodes slightly off the chords.
QuadraticMesh<3> screw(std::uint64_t seed, std::size_t cells) {
    auto linear = generated::mesh<3>(seed, cells);
    generated::Random random(seed);
    Buffer<Vec<3>> points;
    for (std::size_t v = 0; v < linear.points.size(); ++v) {
        const double t = static_cast<double>(v);
        points.push_back({{std::cos(2 * t), std::sin(2 * t), 0.7 * t}});
    }
    Buffer<Reference> references(points.size());
    std::fill(references.begin(), references.end(), 0);
    linear.points = std::move(points);
    linear.point_references = std::move(references);
    linear.corners = linear.required_vertices = {};
    linear.ridges = linear.elements.required = linear.facets.required = linear.edges.required = {};
    linear.geometry = {};
    auto mesh = *elevate(linear, {});
    Buffer<LagrangeNode<3>> nodes = take(mesh.mid_nodes);
    for (auto& node : nodes)
        for (int c = 0; c < 3; ++c) node.point[c] += 0.001 * static_cast<double>(random.below(100));
    mesh.mid_nodes = std::move(nodes);
    return mesh;
}

QuadraticMesh<3> decoded(const std::string& text) {
    const auto back = decode_gmf_mesh(generated::bytes_of(text), "file", {});
    if (!back) RC_FAIL(describe(back.error()) + "\n" + text);
    RC_ASSERT(testing::holds<QuadraticMesh<3>>(back->mesh));
    return testing::mesh_in<QuadraticMesh<3>>(back->mesh);
}

}  // namespace

TEST_CASE("GMF Ordering blocks define the node order") {
    testing::property("a mesh with any node order and its Ordering block is restored", [](std::uint64_t seed) {
        const auto mesh = screw(seed, 6);
        RC_PRE(generated::holds_simplices(mesh.linear));
        generated::Random random(seed);
        const std::size_t n = mesh.linear.points.size();
        const std::string text = points_text(mesh, false) +
                                 permuted<3>("TetrahedraP2", mesh.linear.elements, mesh.edges.of_elements, n, random) +
                                 permuted<2>("TrianglesP2", mesh.linear.facets, mesh.edges.of_facets, n, random) +
                                 permuted<1>("EdgesP2", mesh.linear.edges, mesh.edges.of_edges, n, random) + "End";
        RC_ASSERT(decoded(text) == mesh);
    });
}

TEST_CASE("GMF control points are converted to nodes on the curve") {
    testing::property("BezierBasis 1 converts control points, BezierBasis 0 does not", [](std::uint64_t seed) {
        const auto mesh = screw(seed, 6);
        RC_PRE(generated::holds_simplices(mesh.linear));
        generated::Random random(seed);
        const std::size_t n = mesh.linear.points.size();
        const auto body = permuted<3>("TetrahedraP2", mesh.linear.elements, mesh.edges.of_elements, n, random) +
                          permuted<2>("TrianglesP2", mesh.linear.facets, mesh.edges.of_facets, n, random) +
                          permuted<1>("EdgesP2", mesh.linear.edges, mesh.edges.of_edges, n, random) + "End";
        const auto back = decoded(points_text(mesh, true) + "BezierBasis 1\n" + body);
        RC_ASSERT(back.linear == mesh.linear);
        for (std::size_t e = 0; e < mesh.edges.size(); ++e)
            RC_ASSERT(distance(back.mid_nodes[e].point, mesh.mid_nodes[e].point) <= 1e-13);
        RC_ASSERT(decoded(points_text(mesh, false) + "BezierBasis 0\n" + body) == mesh);
    });
}

TEST_CASE("GMF mid nodes are found anywhere in the vertex list") {
    testing::property("a degree-2 mesh is read with its vertices in any order", [](std::uint64_t seed) {
        // With the file's vertices in random order, the corners of the mesh keep the order of the file.
        const auto mesh = screw(seed, 5);
        RC_PRE(mesh.linear.elements.size() > 0);
        generated::Random random(seed);
        const std::size_t corners = mesh.linear.points.size(), all = corners + mesh.mid_nodes.size();
        std::vector<std::size_t> place(all), at(all);
        std::iota(place.begin(), place.end(), std::size_t{0});
        for (std::size_t i = all; i > 1; --i) std::swap(place[i - 1], place[random.below(i)]);
        for (std::size_t v = 0; v < all; ++v) at[place[v]] = v;
        std::string text = "MeshVersionFormatted 2 Dimension 3 Vertices " + std::to_string(all) + "\n";
        for (const std::size_t v : at) {
            const Vec<3>& p = v < corners ? mesh.linear.points[v] : mesh.mid_nodes[v - corners].point;
            char line[120];
            std::snprintf(line, sizeof line, "%.17g %.17g %.17g 0\n", p[0], p[1], p[2]);
            text += line;
        }
        text += "TetrahedraP2 " + std::to_string(mesh.linear.elements.size()) + "\n";
        for (const auto& row : rows<3>(mesh.linear.elements, mesh.edges.of_elements, corners)) {
            for (const std::size_t node : row) text += std::to_string(place[node - 1] + 1) + " ";
            text += "0\n";
        }
        // In these strips each edge of a facet is an edge of an element.
        const auto back = decoded(text + "End");
        RC_ASSERT(back.linear.elements.size() == mesh.linear.elements.size());
        for (std::size_t e = 0; e < back.linear.elements.size(); ++e) {
            const auto a = element_of(back, ElementId(e)), b = element_of(mesh, ElementId(e));
            for (std::size_t i = 0; i < a.control.size(); ++i) RC_ASSERT(distance(a.control[i], b.control[i]) <= 1e-13);
        }
        for (std::size_t v = 1, previous = 0; v < back.linear.points.size(); ++v) {
            const auto number = [&](std::size_t w) {
                return std::find(at.begin(), at.end(),
                                 static_cast<std::size_t>(std::find(mesh.linear.points.begin(),
                                                                    mesh.linear.points.end(), back.linear.points[w]) -
                                                          mesh.linear.points.begin())) -
                       at.begin();
            };
            RC_ASSERT(number(previous) < number(v));
            previous = v;
        }
    });
}

TEST_CASE("degree-2 rows under the linear GMF keywords are read") {
    testing::property("degree-2 rows are read with either order of the last two nodes", [](std::uint64_t seed) {
        const bool swapped = *rc::gen::arbitrary<bool>();
        const auto mesh = screw(seed, 6);
        RC_PRE(mesh.linear.elements.size() > 0);
        const std::size_t n = mesh.linear.points.size();
        std::string text = points_text(mesh, false);
        const auto put = [&](const std::string& name, auto all, const auto& kind) {
            text += name + " " + std::to_string(all.size()) + "\n";
            for (std::size_t i = 0; i < all.size(); ++i)
                text += words(all[i]) + std::to_string(kind.references[i]) + "\n";
        };
        auto tetrahedra = rows<3>(mesh.linear.elements, mesh.edges.of_elements, n);
        if (swapped)
            for (auto& row : tetrahedra) std::swap(row[8], row[9]);
        put("Edges", rows<1>(mesh.linear.edges, mesh.edges.of_edges, n), mesh.linear.edges);
        put("Triangles", rows<2>(mesh.linear.facets, mesh.edges.of_facets, n), mesh.linear.facets);
        put("Tetrahedra", tetrahedra, mesh.linear.elements);
        RC_ASSERT(decoded(text + "End") == mesh);
    });
}

TEST_CASE("linear and quadratic simplices of one GMF file are merged") {
    const auto text = [](const std::string& more) {
        return "MeshVersionFormatted 2 Dimension 2 Vertices 7  0 0 1  1 0 1  0 1 1  .5 .1 1  .6 .6 1  0 .5 1  1 1 1\n"
               "TrianglesP2 1  1 2 3 4 5 6 9\n" +
               more + " End";
    };
    const auto back = decode_gmf_mesh(generated::bytes_of(text("Edges 2  2 1 5  2 7 6")), "file", {});
    REQUIRE(back);
    const auto& mesh = testing::mesh_in<QuadraticMesh<2>>(back->mesh);
    CHECK(mesh.linear.points.size() == 4);
    CHECK(back->node_numbers == Column<std::uint32_t>(Buffer<std::uint32_t>{1, 2, 3, 7, 4, 6, 5, 0}));
    REQUIRE(mesh.linear.facets.size() == 2);
    CHECK(mesh.linear.facets.references[0] == 5);
    const EdgeId curved = mesh.edges.of_facets[0][0], straight = mesh.edges.of_facets[1][0];
    CHECK(mesh.mid_nodes[curved].point == Vec<2>{{0.5, 0.1}});
    CHECK(mesh.mid_nodes[straight].point == Vec<2>{{1, 0.5}});
    REQUIRE(back->notices.size() == 1);
    CHECK(back->notices[0].what == "1 edges have no mid node in the file and are straight");

    SUBCASE("quadratic simplices precede linear ones in the numbering") {
        const auto both = decode_gmf_mesh(
            generated::bytes_of(text("Triangles 1 2 7 3 8 RequiredTriangles 1 1 RequiredVertices 2 5 7")), "file", {});
        REQUIRE(both);
        const auto& mixed = testing::mesh_in<QuadraticMesh<2>>(both->mesh);
        CHECK(mixed.linear.elements.references == Column<Reference>(Buffer<Reference>{9, 8}));
        CHECK(mixed.linear.elements.required == Column<std::uint32_t>(Buffer<std::uint32_t>{0}));
        CHECK(mixed.linear.required_vertices == Column<VertexId>(Buffer<VertexId>{VertexId(std::size_t{3})}));
        REQUIRE(both->notices.size() == 2);
        CHECK(both->notices[0].what.starts_with("1 entries of corners, required vertices"));
    }
}

TEST_CASE("references of mid nodes that differ from those of the edge are reported") {
    const auto decode = [](const std::string& mid) {
        return decode_gmf_mesh(
            generated::bytes_of("MeshVersionFormatted 2 Dimension 2 Vertices 3  0 0 4  1 0 4  .5 .1 " + mid +
                                " EdgesP2 1  1 2 3 9 End"),
            "file", {});
    };
    CHECK(decode("4")->notices.empty());
    REQUIRE(decode("5")->notices.size() == 1);
    CHECK(decode("5")->notices[0].what == "references of 1 mid nodes were left out");
}
