// A file written in pieces by several writers equals the file of the whole mesh.
#include "../io/generated.hpp"
#include "property.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

import camber.distributed;

using namespace camber;

namespace {

/// Random cuts of [0, n) into a run for each writer; runs may be empty.
std::vector<std::size_t> cuts(std::size_t n, std::size_t holders) {
    std::vector<std::size_t> at{0, n};
    while (at.size() <= holders) at.push_back(*rc::gen::inRange<std::size_t>(0, n + 1));
    std::ranges::sort(at);
    return at;
}

template <class T, class Item>
Buffer<T> run_of(const Column<Item>& column, std::size_t begin, std::size_t end, const auto& value) {
    Buffer<T> run;
    for (std::size_t i = begin; i < end; ++i) run.push_back(value(column[i], i));
    return run;
}

constexpr auto unchanged = [](const auto& item, std::size_t) { return item; };

/// The node numbers of a simplex in the file.
template <int K, int Degree>
auto numbers(const SimplexVertices<K>& vertices, std::size_t before, const auto& edges) {
    std::array<std::uint64_t, nodes_of_degree<K, Degree>> nodes{};
    for (int n = 0; n <= K; ++n) nodes[n] = vertices[n].value;
    if constexpr (Degree == 2 && requires { edges.value; })
        nodes[2] = before + edges.value;
    else if constexpr (Degree == 2)
        for (int e = 0; e < edges_per_simplex<K>; ++e) nodes[K + 1 + e] = before + edges[e].value;
    return nodes;
}

template <int Degree, int K>
SimplexRun<K, Degree> simplex_run(const Simplices<K>& kind, std::size_t vertices, const auto& edges_of,
                                  std::size_t begin, std::size_t end) {
    using Nodes = std::array<std::uint64_t, nodes_of_degree<K, Degree>>;
    return {begin,
            run_of<Nodes>(kind.vertices, begin, end,
                          [&](const auto& simplex, std::size_t i) {
                              if constexpr (Degree == 2)
                                  return numbers<K, 2>(simplex, vertices, edges_of[i]);
                              else
                                  return numbers<K, 1>(simplex, vertices, 0);
                          }),
            run_of<Reference>(kind.references, begin, end, unchanged)};
}

/// The parts of the mesh, one for each writer.
template <int D, int Degree>
std::vector<FilePart<D, Degree>> parts_of(const QuadraticMesh<D>& mesh, std::size_t holders) {
    const LinearMesh<D>& linear = mesh.linear;
    const std::size_t vertices = linear.points.size();
    const auto v = cuts(vertices, holders), m = cuts(mesh.edges.size(), holders),
               e = cuts(linear.elements.size(), holders), f = cuts(linear.facets.size(), holders),
               l = cuts(linear.edges.size(), holders);
    std::vector<FilePart<D, Degree>> parts(holders);
    for (std::size_t h = 0; h < holders; ++h) {
        FilePart<D, Degree>& part = parts[h];
        part.vertices = {v[h], run_of<Vec<D>>(linear.points, v[h], v[h + 1], unchanged),
                         run_of<Reference>(linear.point_references, v[h], v[h + 1], unchanged)};
        if (Degree == 2)
            part.mid_nodes = {
                m[h],
                run_of<Vec<D>>(mesh.mid_nodes, m[h], m[h + 1],
                               [](const LagrangeNode<D>& node, std::size_t) { return node.point; }),
                run_of<Reference>(mesh.edges.vertices, m[h], m[h + 1], [&](const auto& ends, std::size_t) {
                    return mid_node_reference(linear.point_references[ends[0]], linear.point_references[ends[1]]);
                })};
        part.elements = simplex_run<Degree>(linear.elements, vertices, mesh.edges.of_elements, e[h], e[h + 1]);
        part.facets = simplex_run<Degree>(linear.facets, vertices, mesh.edges.of_facets, f[h], f[h + 1]);
        part.edges = simplex_run<Degree>(linear.edges, vertices, mesh.edges.of_edges, l[h], l[h + 1]);
    }
    return parts;
}

void put(generated::Bytes& file, std::vector<bool>& written, const std::vector<FilePiece>& pieces) {
    for (const FilePiece& piece : pieces) {
        RC_ASSERT(piece.offset + piece.bytes.size() <= file.size());
        std::memcpy(file.data() + piece.offset, piece.bytes.data(), piece.bytes.size());
        for (std::size_t i = 0; i < piece.bytes.size(); ++i) {
            RC_ASSERT(!written[piece.offset + i]);
            written[piece.offset + i] = true;
        }
    }
}

template <int D, int Degree>
void check_parts(std::uint64_t seed) {
    const auto mesh = generated::quadratic<D>(seed, *rc::gen::inRange<std::size_t>(0, 30));
    const int version = *rc::gen::element(0, 2, 3, 4);
    const PartTotals totals{mesh.linear.points.size(), Degree == 2 ? mesh.edges.size() : 0, mesh.linear.elements.size(),
                            mesh.linear.facets.size(), mesh.linear.edges.size()};
    const LinearMesh<D> lists = *rows_of(mesh.linear)->lists();
    const GmfFrame frame = *gmf_frame<D, Degree>(totals, lists, version);
    generated::Bytes file(frame.bytes);
    std::vector<bool> written(frame.bytes);
    put(file, written, *encode_gmf_frame<D, Degree>(frame, lists, {}));
    for (const auto& part : parts_of<D, Degree>(mesh, *rc::gen::inRange<std::size_t>(1, 6)))
        put(file, written, *encode_gmf_part(frame, part, {}));
    RC_ASSERT(std::ranges::find(written, false) == written.end());
    if constexpr (Degree == 2)
        RC_ASSERT(file == generated::joined(*encode_gmf_mesh(as_mesh(mesh), {.version = version}, {})));
    else
        RC_ASSERT(file == generated::joined(*encode_gmf_mesh(as_mesh(mesh.linear), {.version = version}, {})));
}

}  // namespace

TEST_CASE("pieces of a GMF file written by any number of writers form the whole file once") {
    testing::property("2D, degree 1", check_parts<2, 1>);
    testing::property("2D, degree 2", check_parts<2, 2>);
    testing::property("3D, degree 1", check_parts<3, 1>);
    testing::property("3D, degree 2", check_parts<3, 2>);
}

TEST_CASE("a GMF frame uses the version and offsets that its sizes require") {
    const std::uint64_t many = 200'000'000;  // tetrahedra of degree 2 with 44 bytes each
    const auto wide = *gmf_frame<3, 2>({.vertices = 40'000'000, .mid_nodes = 240'000'000, .elements = many}, {});
    CHECK(wide.version == 3);
    CHECK(wide.elements > 280'000'000 * std::uint64_t{28});  // 28 bytes for each vertex and mid node
    CHECK(wide.bytes > wide.elements + many * 44);
    const auto wider =
        *gmf_frame<3, 2>({.vertices = 1'000'000'000, .mid_nodes = 7'000'000'000, .elements = 6 * many}, {});
    CHECK(wider.version == 4);
    const auto last =
        *encode_gmf_part<3, 2>(wider, {.mid_nodes = {6'999'999'999, Buffer<Vec<3>>(1), Buffer<Reference>(1)}}, {});
    // 32 bytes for each vertex and mid node: numbers have 8 bytes in version 4
    CHECK(last.front().offset + last.front().bytes.size() == wider.points + 8'000'000'000 * std::uint64_t{32});
    CHECK(gmf_frame<3, 2>({.vertices = 8'000'000'000}, {}, 3).error().kind == ErrorKind::usage);
}
