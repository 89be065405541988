// Round trips, node order and errors of MFEM meshes. An independent reader is in tests/pipelines/mfem_reader.py.
#include "any_mesh.hpp"
#include "generated.hpp"
#include "property.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

using namespace camber;

namespace {

Outcome<DecodedMesh> read(const std::string& text) { return decode_mfem(generated::bytes_of(text), "in.mfem", {}); }

std::string message(const std::string& text) {
    const auto decoded = read(text);
    return decoded ? "no error" : describe(decoded.error());
}

template <class Mesh>
std::string written(const Mesh& mesh) {
    const auto chunks = encode_mfem(as_mesh(mesh), {});
    return chunks ? generated::text_of(generated::joined(*chunks)) : describe(chunks.error());
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    REQUIRE(at < text.size());
    return text.replace(at, what.size(), by);
}

template <int K>
bool is_face(const SimplexVertices<K - 1>& face, const Simplices<K>& elements) {
    return std::any_of(elements.vertices.begin(), elements.vertices.end(), [&](const SimplexVertices<K>& element) {
        return std::all_of(face.begin(), face.end(),
                           [&](VertexId v) { return std::find(element.begin(), element.end(), v) != element.end(); });
    });
}

/// Returns the boundary simplices that are faces of elements.
template <int K>
Simplices<K - 1> faces_among(const Simplices<K - 1>& boundary, const Simplices<K>& elements) {
    Buffer<SimplexVertices<K - 1>> vertices;
    Buffer<Reference> references;
    for (std::size_t i = 0; i < boundary.size(); ++i)
        if (is_face<K>(boundary.vertices[i], elements)) {
            vertices.push_back(boundary.vertices[i]);
            references.push_back(boundary.references[i]);
        }
    return {std::move(vertices), std::move(references), {}};
}

template <int D>
LinearMesh<D> with_faces_alone(LinearMesh<D> mesh) {
    if constexpr (D == 3)
        if (mesh.elements.size() == 0) mesh.edges = faces_among<2>(mesh.edges, mesh.facets);
    if (D == 2 || mesh.elements.size() > 0) mesh.facets = faces_among<D>(mesh.facets, mesh.elements);
    return mesh;
}

/// The mesh with the data that MFEM stores and positive references; boundary simplices need not be faces of elements.
template <int D>
LinearMesh<D> with_any_boundary(LinearMesh<D> mesh) {
    const auto simplices = [](auto kind) {
        auto references = take(std::move(kind.references));
        for (Reference& r : references) r = r < 0 ? ~r + 1 - (r == -2147483647 - 1 ? 1 : 0) : r == 0 ? 1 : r;
        kind.references = std::move(references);
        kind.required = {};
        return kind;
    };
    LinearMesh<D> result;
    result.points = mesh.points;
    result.point_references = Buffer<Reference>(mesh.points.size(), 0);
    result.elements = simplices(mesh.elements);
    result.facets = simplices(mesh.facets);
    if (mesh.elements.size() == 0) result.edges = simplices(mesh.edges);
    return result;
}

template <int D>
LinearMesh<D> storable(const LinearMesh<D>& mesh) {
    return with_faces_alone(with_any_boundary(mesh));
}

/// Replaces the vertices of some boundary simplices.
template <int D>
LinearMesh<D> with_noise_in_boundary(LinearMesh<D> mesh, std::uint64_t seed) {
    generated::Random random(seed);
    const auto noise = [&]<int K>(const Simplices<K>& simplices) {
        auto vertices = take(simplices.vertices);
        for (auto& simplex : vertices)
            if (random.below(2) == 0) {
                const std::size_t first = random.below(mesh.points.size() - K);
                for (std::size_t i = 0; i <= K; ++i) simplex[i] = VertexId(first + i);
                std::swap(simplex[0], simplex[random.below(K + 1)]);
                if (random.below(2) == 0)
                    simplex[0] = VertexId(first + K == mesh.points.size() - 1 ? 0 : first + K + 1);
                if (simplex[0] == simplex[1] || (K == 2 && simplex[0] == simplex[K])) simplex = simplices.vertices[0];
            }
        return Simplices<K>{std::move(vertices), simplices.references, {}};
    };
    if (mesh.elements.size() > 0)
        mesh.facets = noise(mesh.facets);
    else if (D == 3)
        mesh.edges = noise(mesh.edges);
    return mesh;
}

/// Returns the degree-2 mesh with random mid nodes.
template <int D>
QuadraticMesh<D> curved(const LinearMesh<D>& mesh, std::uint64_t seed) {
    auto result = *elevate(mesh, {});
    generated::Random random(seed);
    Buffer<LagrangeNode<D>> nodes;
    for (std::size_t e = 0; e < result.edges.size(); ++e) nodes.push_back({random.vector<D>()});
    result.mid_nodes = std::move(nodes);
    return result;
}

template <class Mesh>
void check_round_trip(const Mesh& mesh) {
    RC_ASSERT(not_in_mfem(as_mesh(mesh)).empty());
    const auto bytes = generated::joined(*encode_mfem(as_mesh(mesh), {.threads = 1}));
    RC_ASSERT(bytes == generated::joined(*encode_mfem(as_mesh(mesh), {.threads = 3})));
    const auto back = decode_mfem(bytes, "in.mfem", {});
    if (!back) RC_FAIL(describe(back.error()));
    RC_ASSERT(testing::holds<Mesh>(back->mesh));
    RC_ASSERT(testing::mesh_in<Mesh>(back->mesh) == mesh);
    RC_ASSERT(back->notices.empty());
}

template <int D>
void check_properties() {
    testing::property("an MFEM file restores a straight mesh", [](std::uint64_t seed) {
        const auto mesh = storable(generated::mesh<D>(seed, seed % 9));
        RC_PRE(generated::holds_simplices(mesh));
        check_round_trip(mesh);
    });
    testing::property("an MFEM file restores a curved mesh", [](std::uint64_t seed) {
        const auto mesh = storable(generated::mesh<D>(seed, 1 + seed % 9));
        RC_PRE(generated::holds_simplices(mesh));
        check_round_trip(curved(mesh, seed));
    });
    testing::property("facets that are not faces of elements are omitted and counted", [](std::uint64_t seed) {
        const auto mesh = with_noise_in_boundary(with_any_boundary(generated::mesh<D>(seed, 1 + seed % 9)), seed);
        RC_PRE(mesh.elements.size() > 0 || (D == 3 && mesh.facets.size() > 0));
        const auto faces_only = with_faces_alone(mesh);
        const std::size_t dropped =
            mesh.facets.size() - faces_only.facets.size() + mesh.edges.size() - faces_only.edges.size();
        const auto losses = not_in_mfem(as_mesh(mesh));
        RC_ASSERT(losses.size() == (dropped > 0 ? 1 : 0));
        if (dropped > 0)
            RC_ASSERT(losses[0].what ==
                      "MFEM has no place for " + std::to_string(dropped) + " facets that are not faces of elements");
        RC_ASSERT(written(mesh) == written(faces_only));
        const auto nodes = curved(mesh, seed);
        const auto back = decode_mfem(generated::joined(*encode_mfem(as_mesh(nodes), {})), "in.mfem", {});
        if (!back) RC_FAIL(describe(back.error()));
        if (!testing::holds<QuadraticMesh<D>>(back->mesh)) return;  // the file has no mesh
        RC_ASSERT(testing::mesh_in<QuadraticMesh<D>>(back->mesh).linear == faces_only);
    });
}

/// Two triangles of a square with all their edges and their mid nodes.
const std::string square =
    "MFEM mesh v1.0\n\n# a comment\ndimension\n2\n\nelements\n2\n1 2 0 1 2\n2 2 0 2 3\n\nboundary\n1\n7 1 2 3\n\n"
    "vertices\n4\n\nnodes\nFiniteElementSpace\nFiniteElementCollection: H1_2D_P2\nVDim: 2\nOrdering: 1\n\n"
    "0 0\n1 0\n1 1\n0 1\n.5 -.1\n1.1 .5\n.4 .6\n.5 1.1\n-.1 .5\n";

}  // namespace

TEST_CASE("MFEM files restore 2D meshes") { check_properties<2>(); }
TEST_CASE("MFEM files restore 3D meshes") { check_properties<3>(); }

TEST_CASE("MFEM nodes after the vertices follow the edge order of the elements") {
    const auto decoded = read(square);
    REQUIRE_MESSAGE(decoded.has_value(), message(square));
    const auto& mesh = testing::mesh_in<QuadraticMesh<2>>(decoded->mesh);
    CHECK(mesh.linear.elements.references == Column<Reference>(Buffer<Reference>{1, 2}));
    CHECK(mesh.linear.facets.references == Column<Reference>(Buffer<Reference>{7}));
    // In triangle 0 2 3 edge 02 is the third edge of the first triangle, edges 23 and 30 are new.
    const auto node = [&](std::size_t element, int edge) {
        return mesh.mid_nodes[mesh.edges.of_elements[element][edge]].point;
    };
    CHECK(node(0, 0) == Vec<2>{{.5, -.1}});
    CHECK(node(0, 1) == Vec<2>{{1.1, .5}});
    CHECK(node(0, 2) == Vec<2>{{.4, .6}});
    CHECK(node(1, 0) == Vec<2>{{.4, .6}});
    CHECK(node(1, 1) == Vec<2>{{.5, 1.1}});
    CHECK(node(1, 2) == Vec<2>{{-.1, .5}});

    std::string by_nodes =
        replaced(square, "Ordering: 1\n\n0 0\n1 0\n1 1\n0 1\n.5 -.1\n1.1 .5\n.4 .6\n.5 1.1\n-.1 .5\n",
                 "Ordering: 0\n0 1 1 0 .5 1.1 .4 .5 -.1\n0 0 1 1 -.1 .5 .6 1.1 .5\n");
    CHECK(read(by_nodes)->mesh == decoded->mesh);
    CHECK(read(replaced(square, "H1_2D_P2", "Quadratic"))->mesh == decoded->mesh);

    // MFEM's edges of a tetrahedron: 01 02 03 12 13 23.
    const auto solid = read(
        "MFEM mesh v1.0\ndimension\n3\nelements\n1\n1 4 0 1 2 3\nboundary\n0\nvertices\n4\nnodes\nFiniteElementSpace\n"
        "FiniteElementCollection: H1_3D_P2\nVDim: 3\nOrdering: 1\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 1 9\n0 2 9\n0 3 9\n"
        "1 2 9\n1 3 9\n2 3 9\n");
    REQUIRE(solid.has_value());
    const auto& tetrahedron = testing::mesh_in<QuadraticMesh<3>>(solid->mesh);
    for (int k = 0; k < 6; ++k) {
        const auto& [a, b] = local_edges<3>[static_cast<std::size_t>(k)];
        const auto& p = tetrahedron.mid_nodes[tetrahedron.edges.of_elements[0][static_cast<std::size_t>(k)]].point;
        CHECK(p == Vec<3>{{static_cast<double>(a < b ? a : b), static_cast<double>(a < b ? b : a), 9}});
    }
}

TEST_CASE("MFEM reads meshes of order 1 and surface meshes") {
    const std::string triangle =
        "MFEM mesh v1.0\ndimension\n2\nelements\n1\n3 2 0 1 2\nboundary\n1\n4 1 0 1\nvertices\n3\n";
    const auto flat = read(triangle + "2\n0 0\n1 0\n0 1\n");
    REQUIRE(flat.has_value());
    CHECK(testing::mesh_in<LinearMesh<2>>(flat->mesh).elements.references[0] == 3);
    for (const std::string name : {"H1_2D_P1", "Linear"})
        CHECK(read(triangle + "nodes\nFiniteElementSpace\nFiniteElementCollection: " + name +
                   "\nVDim: 2\nOrdering: 0\n0 1 0\n0 0 1\n")
                  ->mesh == flat->mesh);
    const auto surface = read(triangle + "3\n0 0 0\n1 0 0\n0 1 5\nmore\n");
    REQUIRE(surface.has_value());
    const auto& mesh = testing::mesh_in<LinearMesh<3>>(surface->mesh);
    CHECK(mesh.elements.size() == 0);
    CHECK(mesh.facets.size() == 1);
    CHECK(mesh.edges.size() == 1);
    REQUIRE(surface->notices.size() == 1);
    CHECK(surface->notices[0].what == "all data after the vertices was left out");
}

TEST_CASE("MFEM replaces non-positive references by free numbers with a notice") {
    LinearMesh<2> mesh = storable(generated::mesh<2>(4, 5));
    REQUIRE(mesh.elements.size() == 5);
    mesh.elements.references = Buffer<Reference>{1, 0, -4, 3, 0};
    const auto losses = not_in_mfem(as_mesh(mesh));
    REQUIRE(losses.size() == 1);
    CHECK(losses[0].what ==
          "MFEM's attributes are positive: of the elements reference 0 becomes 2 (2), -4 becomes 4 (1)");
    const auto back = read(written(mesh));
    REQUIRE(back.has_value());
    CHECK(testing::mesh_in<LinearMesh<2>>(back->mesh).elements.references ==
          Column<Reference>(Buffer<Reference>{1, 2, 4, 3, 2}));
    mesh.elements.references = Buffer<Reference>{0, -1, -2, -3, -2147483647 - 1};
    CHECK(not_in_mfem(as_mesh(mesh))[0].what.ends_with("-3 becomes 4 (1), -2147483648 becomes 5 (1)"));
}

TEST_CASE("replaced references do not take the number of a named attribute") {
    testing::property("replaced references of elements and boundary avoid named attributes", [](std::uint64_t seed) {
        auto mesh = storable(generated::mesh<3>(seed, 1 + seed % 5));
        RC_PRE(mesh.elements.size() > 0);
        generated::Random random(seed);
        const auto some_references = [&](std::size_t n) {
            Buffer<Reference> references;
            for (std::size_t i = 0; i < n; ++i) references.push_back(static_cast<Reference>(random.below(6)) - 2);
            return references;
        };
        mesh.elements.references = some_references(mesh.elements.size());
        mesh.facets.references = some_references(mesh.facets.size());
        mesh.groups = Buffer<Group>{{3, 1, "named"}, {3, 3, "named"}, {2, 2, "named"}};
        const auto named = [](const LinearMesh<3>& m, int dimension, Reference reference) {
            return std::any_of(m.groups.begin(), m.groups.end(),
                               [&](const Group& g) { return g.dimension == dimension && g.reference == reference; });
        };
        const auto decoded = read(written(mesh));
        if (!decoded) RC_FAIL(describe(decoded.error()));
        const auto& back = testing::mesh_in<LinearMesh<3>>(decoded->mesh);
        for (std::size_t i = 0; i < mesh.elements.size(); ++i)
            RC_ASSERT(named(back, 3, back.elements.references[i]) == named(mesh, 3, mesh.elements.references[i]));
        for (std::size_t i = 0; i < mesh.facets.size(); ++i)
            RC_ASSERT(named(back, 2, back.facets.references[i]) == named(mesh, 2, mesh.facets.references[i]));
    });
}

TEST_CASE("MFEM reports edges and names that it cannot store") {
    std::uint64_t seed = 1;
    while (generated::mesh<3>(seed, 4).elements.size() == 0) ++seed;  // some are surface meshes
    auto mesh = storable(generated::mesh<3>(seed, 4));
    mesh.edges.vertices = Buffer<SimplexVertices<1>>{{VertexId(0), VertexId(1)}};
    mesh.edges.references = Buffer<Reference>{0};
    mesh.groups = Buffer<Group>{{1, 1, "iron"}, {2, 1, "two \"signs\""}};
    const auto losses = not_in_mfem(as_mesh(mesh));
    REQUIRE(losses.size() == 3);
    CHECK(losses[0].what == "MFEM has no place for 1 edges");
    CHECK(losses[1].what == "MFEM has no place for 1 names of references");
    CHECK(losses[2].what == "MFEM cannot hold 1 names of references: \"two \"signs\"\" becomes \"two 'signs'\"");
    const auto back = read(written(mesh));
    REQUIRE(back.has_value());
    CHECK(testing::mesh_in<LinearMesh<3>>(back->mesh).elements == mesh.elements);
    CHECK(testing::mesh_in<LinearMesh<3>>(back->mesh).edges.size() == 0);
}

TEST_CASE("MFEM leaves out facets that bound no element") {
    LinearMesh<2> mesh;
    mesh.points = Buffer<Vec<2>>{{{0, 0}}, {{1, 0}}, {{0, 1}}, {{2, 2}}};
    mesh.point_references = Buffer<Reference>(4, 0);
    mesh.elements.vertices = Buffer<SimplexVertices<2>>{{VertexId(0), VertexId(1), VertexId(2)}};
    mesh.elements.references = Buffer<Reference>{1};
    mesh.facets.vertices = Buffer<SimplexVertices<1>>{{VertexId(0), VertexId(3)}};
    mesh.facets.references = Buffer<Reference>{1};
    CHECK(written(mesh).find("boundary\n0\n") < written(mesh).size());
    CHECK(written(*elevate(mesh, {})).find("boundary\n0\n") < written(*elevate(mesh, {})).size());
    REQUIRE(not_in_mfem(as_mesh(mesh)).size() == 1);
    CHECK(not_in_mfem(as_mesh(mesh))[0].what == "MFEM has no place for 1 facets that are not faces of elements");
    LinearMesh<2> boundary = mesh;
    boundary.elements = {};
    CHECK(written(boundary) ==
          "has no elements, and MFEM does not support a boundary without elements (write another "
          "format)");
    // The reference of this facet is not reported.
    mesh.facets.references = Buffer<Reference>{-5};
    CHECK(not_in_mfem(as_mesh(mesh)).size() == 1);
    const auto without_facet = read(replaced(square, "7 1 2 3", "7 1 1 3"));
    REQUIRE(without_facet.has_value());
    CHECK(testing::mesh_in<QuadraticMesh<2>>(without_facet->mesh).linear.facets.size() == 0);
    REQUIRE(without_facet->notices.size() == 1);
    CHECK(
        without_facet->notices[0].what ==
        "1 boundary elements with an edge that belongs to no element were left out: MFEM has no nodes for such edges");
}

TEST_CASE("MFEM rejects unsupported versions, spaces and shapes, and invalid data") {
    const auto kind = [](const std::string& text) {
        const auto decoded = read(text);
        return decoded ? ErrorKind::internal : decoded.error().kind;
    };
    for (const std::string first :
         {"MFEM mesh v1.1", "MFEM NC mesh v1.0", "MFEM NURBS mesh v1.0", "MFEM INLINE mesh v1.0"}) {
        const std::string text = replaced(square, "MFEM mesh v1.0", first);
        CHECK(message(text) ==
              "in.mfem: line 1: has a version or kind other than \"MFEM mesh v1.0\", 1.2 and 1.3 (write the "
              "conforming mesh by Mesh::Print)");
        CHECK(kind(text) == ErrorKind::unsupported);
        CHECK(is_mfem(generated::bytes_of(text)));
    }
    for (const std::string space : {"L2_2D_P2", "H1_2D_P3", "L2_T1_2D_P1", "H1Pos_2D_P2", "Cubic"})
        CHECK(message(replaced(square, "H1_2D_P2", space)).ends_with("(project them with Mesh::SetCurvature(2))"));
    const std::string mixed =
        "MFEM mesh v1.0\ndimension\n2\nelements\n3\n1 3 0 1 2 3\n1 2 0 1 2\n1 3 0 1 2 3\nboundary\n1\n1 0 2\n"
        "vertices\n4\n2\n0 0 1 0 1 1 0 1\n";
    CHECK(message(mixed).find("holds 2 quadrilaterals, 1 points, which Camber does not support") < 30);
    CHECK(kind(mixed) == ErrorKind::unsupported);
    CHECK(kind(replaced(square, "dimension\n2", "dimension\n1")) == ErrorKind::unsupported);
    CHECK(message(replaced(square, "1 2 0 1 2", "1 9 0 1 2")).find("element 1: its geometry 9 is not one of MFEM") <
          30);
    CHECK(message(replaced(square, "2 2 0 2 3", "2 2 0 2 4")) ==
          "in.mfem: line 10: element 2: a node is not one of those that the file lists (the file is damaged, or was "
          "joined from two files)");
    CHECK(message(replaced(square, "2 2 0 2 3", "2 2 0 2 2")).find("line 10: element 2: a node occurs twice") < 30);
    CHECK(message(replaced(square, "2 2 0 2 3", "3000000000 2 0 2 3")).find("does not fit 32 bits") < 60);
    CHECK(message(replaced(square, "-.1 .5\n", "nan .5\n")).find("a coordinate is infinite or not a number") < 60);
    CHECK(message(replaced(square, "VDim: 2", "VDim: 4")).find("VDim is not 2 or 3") < 30);
    CHECK(message("").find("the file is empty") < 30);
}

TEST_CASE("MFEM 1.3 attribute sets become groups") {
    const std::string named = replaced(replaced(replaced(square, "MFEM mesh v1.0", "MFEM mesh v1.3"), "boundary\n",
                                                "attribute_sets\n2\n\"Left side\" 1 1\nboth 2 1 2\n\nboundary\n"),
                                       "vertices\n", "bdr_attribute_sets\n1\n\"Wall\" 2 7 9\n\nvertices\n");
    CHECK(message(named).find("\"mfem_mesh_end\" is missing here") < 40);
    const auto decoded = read(named + "\nmfem_mesh_end\n");
    REQUIRE_MESSAGE(decoded.has_value(), message(named + "\nmfem_mesh_end\n"));
    CHECK(testing::mesh_in<QuadraticMesh<2>>(decoded->mesh).linear.groups ==
          Column<Group>(
              Buffer<Group>{{2, 1, "Left side"}, {2, 1, "both"}, {2, 2, "both"}, {1, 7, "Wall"}, {1, 9, "Wall"}}));
    CHECK(decoded->notices.empty());
    const auto older = read(replaced(square, "v1.0", "v1.2") + "\nmfem_mesh_end\n");
    REQUIRE(older.has_value());
    CHECK(older->mesh == read(square)->mesh);
    CHECK(message(replaced(named, "\"Wall\" 2", "\"Wall 2")).find("the name of a set does not end on its line") < 40);
    CHECK(message(replaced(named, "\"Wall\" 2", "\"Wall\" 9000000")).find("but fewer follow") < 90);
}

TEST_CASE("MFEM files restore named groups") {
    testing::property("references with names are restored", [](std::uint64_t seed) {
        auto mesh = storable(generated::mesh<3>(seed, 1 + seed % 5));
        RC_PRE(mesh.elements.size() > 0);
        Buffer<Group> groups{{3, mesh.elements.references[0], "a solid"}, {3, 4, "a solid"}, {2, 5, "%wall"}};
        mesh.groups = std::move(groups);
        RC_PRE(not_in_mfem(as_mesh(mesh)).empty());
        const std::string text = written(mesh);
        RC_ASSERT(text.starts_with("MFEM mesh v1.3\n"));
        const auto back = read(text);
        if (!back) RC_FAIL(describe(back.error()));
        RC_ASSERT(testing::mesh_in<LinearMesh<3>>(back->mesh) == mesh);
    });
}

TEST_CASE("truncated MFEM files are rejected, or reported if cut in the last number") {
    const std::string straight = written(storable(generated::mesh<3>(2, 2)));
    REQUIRE(message(straight) == "no error");
    for (const std::string& text : {square, straight})
        for (std::size_t n = 0; n < text.size(); ++n) {
            CAPTURE(n);
            const auto decoded = read(text.substr(0, n));
            if (decoded && n > text.find_last_of(" \n", text.size() - 2)) {
                REQUIRE(decoded->notices.size() == 1);
                CHECK(decoded->notices[0].what ==
                      "the last line has no end: the file may be cut off within its last number");
                continue;
            }
            REQUIRE(!decoded.has_value());
            REQUIRE(!decoded.error().what.empty());
            REQUIRE(decoded.error().where.starts_with("in.mfem: line "));
        }
}

TEST_CASE("MFEM files with invalid counts are rejected") {
    for (const std::string count : {"4000000000", "9000000000000000000", "99999999999999999999", "-1", "x"}) {
        CHECK(message(replaced(square, "elements\n2", "elements\n" + count)) != "no error");
        CHECK(message(replaced(square, "boundary\n1", "boundary\n" + count)) != "no error");
        CHECK(message(replaced(square, "vertices\n4", "vertices\n" + count)) != "no error");
    }
}

TEST_CASE("an MFEM file with noise gives an error or a mesh") {
    testing::property("random characters of an MFEM file are replaced",
                      [](std::uint64_t seed) {
                          generated::Random random(seed);
                          std::string text = square;
                          for (std::size_t i = 0, n = 1 + random.below(4); i < n; ++i)
                              text[random.below(text.size())] = "0123456789 \n-.x#"[random.below(16)];
                          const auto decoded = read(text);
                          RC_ASSERT(decoded.has_value() || !decoded.error().what.empty());
                      },
                      {.count = 2000});
}
