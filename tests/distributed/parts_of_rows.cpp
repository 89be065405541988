// The parts that ranks have of a mesh equal those computed by one process.
#include "../io/generated.hpp"
#include "property.hpp"
#include "thread_ranks.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

import camber.distributed;
import camber.partition;

using namespace camber;
using camber::testing::on_ranks;

namespace {

/// Parts are scattered over the mesh, so that each has many neighbours.
std::int32_t part_of(std::uint64_t row, std::size_t parts) {
    return static_cast<std::int32_t>((row * 2654435761U >> 7U) % parts);
}
Outcome<Buffer<std::int32_t>> scattered(Ranks& ranks, const GraphRun& run, std::size_t parts) {
    const auto sizes = gather_all(ranks, Outcome<std::vector<std::size_t>>({run.size()}));
    if (!sizes) return fail(sizes.error());
    const auto own = sizes->begin() + static_cast<std::ptrdiff_t>(ranks.rank());
    const std::size_t first = std::accumulate(sizes->begin(), own, std::size_t{0});
    Buffer<std::int32_t> of;
    for (std::size_t i = 0; i < run.size(); ++i) of.push_back(part_of(first + i, parts));
    return of;
}

const auto& linear_of(const auto& mesh) {
    if constexpr (requires { mesh.linear; })
        return mesh.linear;
    else
        return mesh;
}

void expect_numbers(const Column<std::uint32_t>& here, const std::vector<std::uint64_t>& numbers,
                    const Column<std::uint32_t>& in_whole) {
    RC_ASSERT(here.size() == in_whole.size());
    for (std::size_t i = 0; i < here.size(); ++i) RC_ASSERT(numbers[here[i]] == in_whole[i]);
}

/// `of_ranks`: the pieces of each rank.
template <class Mesh>
void expect_pieces(const Mesh& whole, std::size_t parts, const std::vector<Outcome<PartsOfRank<Mesh>>>& of_ranks) {
    const auto& linear = linear_of(whole);
    Buffer<std::int32_t> of_elements;
    for (std::size_t e = 0; e < linear.elements.size(); ++e) of_elements.push_back(part_of(e, parts));
    const CellParts cells = *parts_of_cells(linear, std::move(of_elements), {});
    std::size_t next = 0;
    for (const auto& result : of_ranks) {
        if (!result) RC_FAIL(describe(result.error()));
        const PartsOfRank<Mesh>& own = *result;
        RC_ASSERT(own.first == next);
        next = own.last;
        for (std::size_t p = own.first; p < own.last; ++p) {
            const auto part = static_cast<std::int32_t>(p);
            const auto here = *piece_of(own.mesh, {own.part_of_element, own.part_of_facet, own.part_of_edge}, part, {});
            const auto expected = *piece_of(whole, cells, part, {});
            RC_ASSERT(here.mesh == expected.mesh);
            RC_ASSERT(generated::same_bits(linear_of(here.mesh).points, linear_of(expected.mesh).points));
            if constexpr (requires { here.mesh.mid_nodes; })
                RC_ASSERT(generated::same_bits(here.mesh.mid_nodes, expected.mesh.mid_nodes));
            expect_numbers(here.vertices, own.vertices, expected.vertices);
            expect_numbers(here.elements, own.elements, expected.elements);
            expect_numbers(here.facets, own.facets, expected.facets);
            expect_numbers(here.edges, own.edges, expected.edges);
            expect_numbers(here.mid_nodes, own.mid_nodes, expected.mid_nodes);
        }
    }
    RC_ASSERT(next == parts);
}

/// Removes the geometry, which parts do not contain.
template <class Mesh>
Mesh without_geometry(Mesh mesh) {
    if constexpr (requires { mesh.linear; })
        mesh.linear.geometry = {};
    else
        mesh.geometry = {};
    return mesh;
}
struct Draw {
    std::size_t parts, ranks;
};
Draw draw(std::size_t elements) {
    return {*rc::gen::inRange<std::size_t>(1, std::min<std::size_t>(elements, 9) + 1),
            *rc::gen::inRange<std::size_t>(1, 5)};
}

template <int D>
void check_linear(std::uint64_t seed) {
    const auto mesh = without_geometry(generated::mesh<D>(seed, *rc::gen::inRange<std::size_t>(1, 30)));
    RC_PRE(mesh.elements.size() > 0);
    const auto [parts, count] = draw(mesh.elements.size());
    const auto rows = rows_of(mesh);
    expect_pieces(mesh, parts,
                  on_ranks(count, [&](Ranks& among) { return parts_of_rows<D>(*rows, parts, scattered, among); }));
}

template <class T>
void put(generated::Bytes& bytes, T value) {
    bytes.resize(bytes.size() + sizeof value);
    std::memcpy(bytes.data() + bytes.size() - sizeof value, &value, sizeof value);
}

constexpr std::int32_t tetrahedra_p2_ordering = 133, triangles_p2_ordering = 129, end_of_file = 54;

/// The file of the mesh with the nodes of its elements in another order, which the file declares.
template <int D>
Column<std::byte> reordered_file(const QuadraticMesh<D>& mesh, const std::vector<std::size_t>& order) {
    QuadraticMesh<D> other = mesh;
    Buffer<std::array<EdgeId, edges_per_simplex<D>>> of_elements;
    for (const auto& edges : mesh.edges.of_elements) {
        auto& result = of_elements.emplace_back();
        for (std::size_t e = 0; e < result.size(); ++e) result[e] = edges[order[e]];
    }
    other.edges.of_elements = std::move(of_elements);
    auto bytes = generated::joined(*encode_gmf_mesh(as_mesh(other), {.version = 2}, {}));
    bytes.resize(bytes.size() - 8);  // the end record is written again below
    put(bytes, D == 3 ? tetrahedra_p2_ordering : triangles_p2_ordering);
    put(bytes, static_cast<std::int32_t>(bytes.size() + 8 + quadratic_nodes<D> * (D + 1) * 4));
    put(bytes, std::int32_t{quadratic_nodes<D>});
    for (int v = 0; v <= D; ++v)
        for (int i = 0; i <= D; ++i) put(bytes, std::int32_t{i == v ? 2 : 0});
    for (const std::size_t e : order)
        for (int i = 0; i <= D; ++i)
            put(bytes, std::int32_t{i == local_edges<D>[e][0] || i == local_edges<D>[e][1] ? 1 : 0});
    put(bytes, end_of_file);
    put(bytes, std::int32_t{0});
    return Buffer<std::byte>(bytes.begin(), bytes.end());
}

template <int D>
void check_quadratic(std::uint64_t seed) {
    const auto mesh = without_geometry(generated::quadratic<D>(seed, *rc::gen::inRange<std::size_t>(1, 30)));
    RC_PRE(mesh.linear.elements.size() > 0);
    const auto [parts, count] = draw(mesh.linear.elements.size());
    std::vector<std::size_t> order(edges_per_simplex<D>);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::rotate(order.begin(), order.begin() + *rc::gen::inRange(0, edges_per_simplex<D>), order.end());
    const auto file = reordered_file(mesh, order);
    expect_pieces(mesh, parts, on_ranks(count, [&](Ranks& among) -> Outcome<PartsOfRank<QuadraticMesh<D>>> {
                      const auto rows = QuadraticRows<D>::make(file, "file", {}, among);
                      if (!rows) return fail(rows.error());
                      return parts_of_quadratic_rows<D>(**rows, parts, scattered, among, {.threads = 1});
                  }));
}

template <int K>
SimplexRun<K, 1> run_of(const Simplices<K>& kind, std::size_t begin, std::size_t end) {
    SimplexRun<K, 1> run{begin, {}, {}};
    for (std::size_t i = begin; i < end; ++i) {
        auto& nodes = run.nodes.emplace_back();
        for (std::size_t v = 0; v < nodes.size(); ++v) nodes[v] = kind.vertices[i][v].index();
        run.references.push_back(kind.references[i]);
    }
    return run;
}

/// The rows of a rank after remeshing. Ranks have unequal shares, by the squares of their numbers.
template <int D>
FinishedRows<D> finished(const LinearMesh<D>& mesh, const Ranks& ranks) {
    const auto cut = [&](std::size_t n, std::size_t r) { return n * r * r / (ranks.size() * ranks.size()); };
    const auto first = [&](std::size_t n) { return cut(n, ranks.rank()); };
    const auto last = [&](std::size_t n) { return cut(n, ranks.rank() + 1); };
    const std::size_t points = mesh.points.size();
    FinishedRows<D> rows;
    rows.totals = {points, 0, mesh.elements.size(), mesh.facets.size(), mesh.edges.size()};
    rows.lists = *rows_of(mesh)->lists();
    rows.part.vertices = {
        first(points),
        {mesh.points.begin() + first(points), mesh.points.begin() + last(points)},
        {mesh.point_references.begin() + first(points), mesh.point_references.begin() + last(points)}};
    rows.part.elements = run_of(mesh.elements, first(mesh.elements.size()), last(mesh.elements.size()));
    rows.part.facets = run_of(mesh.facets, first(mesh.facets.size()), last(mesh.facets.size()));
    rows.part.edges = run_of(mesh.edges, first(mesh.edges.size()), last(mesh.edges.size()));
    return rows;
}

template <int D>
void check_remeshed(std::uint64_t seed) {
    const auto mesh = without_geometry(generated::mesh<D>(seed, *rc::gen::inRange<std::size_t>(1, 30)));
    RC_PRE(mesh.elements.size() > 0);
    const auto [parts, count] = draw(mesh.elements.size());
    expect_pieces(mesh, parts, on_ranks(count, [&](Ranks& among) {
                      return parts_of_finished<D>(finished(mesh, among), parts, scattered, among);
                  }));
}

constexpr testing::Trials few{.count = 40};

}  // namespace

TEST_CASE("pieces computed by ranks equal those of one process") {
    testing::property("2D, degree 1", check_linear<2>, few);
    testing::property("3D, degree 1", check_linear<3>, few);
    testing::property("2D, degree 2, in any order of nodes", check_quadratic<2>, few);
    testing::property("3D, degree 2, in any order of nodes", check_quadratic<3>, few);
    testing::property("2D, remeshed", check_remeshed<2>, few);
    testing::property("3D, remeshed", check_remeshed<3>, few);
}

TEST_CASE("meshes that cannot be partitioned are rejected on all ranks") {
    LinearMesh<2> fan;  // three triangles at one edge
    fan.points = Buffer<Vec<2>>{{{0, 0}}, {{1, 0}}, {{0, 1}}, {{1, 1}}, {{0, -1}}};
    fan.point_references = Buffer<Reference>(5);
    const auto triangle = [](std::size_t v) { return SimplexVertices<2>{VertexId(0), VertexId(1), VertexId(v)}; };
    fan.elements = {Buffer<SimplexVertices<2>>{triangle(2), triangle(3), triangle(4)}, Buffer<Reference>(3), {}};
    const auto rows = rows_of(fan);
    for (const std::size_t parts : {2U, 4U})
        for (const auto& result :
             on_ranks(3, [&](Ranks& among) { return parts_of_rows<2>(*rows, parts, scattered, among); })) {
            REQUIRE(!result);
            CHECK(result.error().kind == (parts == 2 ? ErrorKind::input : ErrorKind::usage));
        }
}

TEST_CASE("files with edge nodes before vertices are rejected") {
    FilePart<2, 2> part;
    part.vertices.points = Buffer<Vec<2>>(6);
    part.vertices.references = Buffer<Reference>(6);
    part.elements.nodes = {{3, 4, 5, 0, 1, 2}};
    part.elements.references = Buffer<Reference>(1);
    const GmfFrame frame = *gmf_frame<2, 2>({.vertices = 6, .elements = 1}, {});
    Buffer<std::byte> bytes(frame.bytes);
    for (const auto& pieces : {*encode_gmf_frame<2, 2>(frame, {}, {}), *encode_gmf_part<2, 2>(frame, part, {})})
        for (const FilePiece& piece : pieces)
            std::copy(piece.bytes.begin(), piece.bytes.end(),
                      bytes.begin() + static_cast<std::ptrdiff_t>(piece.offset));
    const Column<std::byte> file = std::move(bytes);
    for (const auto& result :
         on_ranks(2, [&](Ranks& among) { return QuadraticRows<2>::make(file, "file", {}, among); })) {
        REQUIRE(!result);
        CHECK(result.error().kind == ErrorKind::unsupported);
    }
}
