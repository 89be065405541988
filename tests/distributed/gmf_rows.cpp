// A mesh read in runs of rows equals the whole mesh, from memory and from a file.
#include "../io/generated.hpp"
#include "property.hpp"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>

import camber.distributed;

using namespace camber;

namespace {

template <int D>
Column<std::byte> file_of(const LinearMesh<D>& mesh, int version) {
    const auto bytes = generated::joined(*encode_gmf_mesh(as_mesh(mesh), {.version = version}, {}));
    return Buffer<std::byte>(bytes.begin(), bytes.end());
}

template <class T>
void append(Buffer<T>& to, const Buffer<T>& from) {
    to.insert(to.end(), from.begin(), from.end());
}

/// Reads all rows in runs of the given size; the last run may be shorter.
template <class Read>
auto in_runs(std::size_t count, std::size_t size, const Read& read) {
    auto all = *read(0, 0);
    for (std::size_t begin = 0; begin < count; begin += size) {
        const auto run = read(begin, std::min(begin + size, count));
        if (!run) RC_FAIL(describe(run.error()));
        if constexpr (requires { all.points; })
            append(all.points, run->points);
        else
            append(all.vertices, run->vertices);
        append(all.references, run->references);
    }
    return all;
}

template <int K>
void put(Simplices<K>& kind, SimplexRows<K> rows) {
    kind.vertices = std::move(rows.vertices);
    kind.references = std::move(rows.references);
}

/// The mesh of all runs and lists.
template <int D>
LinearMesh<D> joined(const MeshRows<D>& rows, std::size_t run) {
    LinearMesh<D> mesh = *rows.lists();
    const RowCounts counts = rows.counts();
    auto points = in_runs(counts.points, run, [&](std::size_t a, std::size_t b) { return rows.points(a, b); });
    mesh.points = std::move(points.points);
    mesh.point_references = std::move(points.references);
    put(mesh.elements,
        in_runs(counts.elements, run, [&](std::size_t a, std::size_t b) { return rows.elements(a, b); }));
    put(mesh.facets, in_runs(counts.facets, run, [&](std::size_t a, std::size_t b) { return rows.facets(a, b); }));
    put(mesh.edges, in_runs(counts.edges, run, [&](std::size_t a, std::size_t b) { return rows.edges(a, b); }));
    return mesh;
}

template <int D>
void check_runs(std::uint64_t seed) {
    const auto mesh = generated::mesh<D>(seed, *rc::gen::inRange<std::size_t>(0, 40));
    const auto run = *rc::gen::inRange<std::size_t>(1, 30);
    const auto rows = rows_of_gmf<D>(file_of(mesh, *rc::gen::inRange(2, 5)), "file");
    if (!rows) RC_FAIL(describe(rows.error()));
    const auto from_file = joined(**rows, run), from_memory = joined(*rows_of(mesh), run);
    RC_ASSERT(from_file == mesh);
    RC_ASSERT(generated::same_bits(from_file.points, mesh.points));
    RC_ASSERT(from_memory == mesh);
}

template <int D>
std::string refusal(const Chunks& chunks) {
    const auto bytes = generated::joined(chunks);
    const auto rows = rows_of_gmf<D>(Buffer<std::byte>(bytes.begin(), bytes.end()), "file");
    return rows ? "none" : describe(rows.error());
}

}  // namespace

TEST_CASE("runs of rows from a file or from memory form the mesh") {
    testing::property("2D", check_runs<2>);
    testing::property("3D", check_runs<3>);
}

TEST_CASE("rows_of_gmf rejects unsupported files before it reads rows") {
    const auto mesh = generated::mesh<3>(5, 20);
    CHECK(refusal<3>(*encode_gmf_mesh(as_mesh(mesh), {GmfEncoding::ascii}, {}))
              .starts_with("file: text cannot be read in parts"));
    CHECK(refusal<2>(*encode_gmf_mesh(as_mesh(mesh), {}, {})).starts_with("file: the mesh does not have dimension 2"));
    CHECK(refusal<3>(*encode_gmf_mesh(as_mesh(generated::quadratic<3>(5, 20)), {}, {})).find("of degree 2") !=
          std::string::npos);
    CHECK(refusal<3>({}).starts_with("file: byte 0: the file is empty"));
}

TEST_CASE("an error in a run has the message of reading the whole file") {
    auto mesh = generated::mesh<2>(3, 20);
    auto points = take(mesh.points);
    points[17][1] = std::numeric_limits<double>::infinity();
    mesh.points = std::move(points);
    const auto file = file_of(mesh, 2);
    const auto rows = rows_of_gmf<2>(file, "file");
    CHECK((*rows)->points(0, 17).has_value());
    const auto whole = decode_gmf_mesh(file.view(), "file", {});
    for (const std::size_t begin : {std::size_t{0}, std::size_t{10}, std::size_t{17}}) {
        const auto run = (*rows)->points(begin, 20);
        REQUIRE(!run);
        CHECK(describe(run.error()) == describe(whole.error()));
    }
}
