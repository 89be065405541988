// Pieces in VTU files, joined by numbers or positions, give the original mesh.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "any_mesh.hpp"
#include "cut_meshes.hpp"
#include "property.hpp"

import camber.core;
import camber.io;
import camber.partition;

using namespace camber;
using cut::one_thread, cut::must;

namespace {

using Files = std::map<std::string, Buffer<std::byte>>;

Buffer<std::byte> joined(const Chunks& chunks) {
    Buffer<std::byte> bytes;
    for (const auto& chunk : chunks) bytes.insert(bytes.end(), chunk.begin(), chunk.end());
    return bytes;
}

Buffer<std::byte> bytes_of(const std::string& text) {
    Buffer<std::byte> bytes;
    for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
    return bytes;
}

MeshField numbers(const std::string& name, Centring centring, std::vector<std::int32_t> values) {
    return {name, centring, FieldKind::scalar,
            Column<std::int32_t>(Buffer<std::int32_t>(values.begin(), values.end()))};
}

template <int D>
MeshFields numbers_of(const MeshPiece<QuadraticMesh<D>>& piece, std::size_t vertices, std::size_t elements) {
    std::vector<std::int32_t> nodes, cells;
    for (const std::uint32_t v : piece.vertices) nodes.push_back(static_cast<std::int32_t>(v + 1));
    for (const std::uint32_t e : piece.mid_nodes) nodes.push_back(static_cast<std::int32_t>(vertices + e + 1));
    for (const std::uint32_t e : piece.elements) cells.push_back(static_cast<std::int32_t>(e + 1));
    for (const std::uint32_t f : piece.facets) cells.push_back(static_cast<std::int32_t>(elements + f + 1));
    return MeshFields({numbers(std::string(global_nodes), Centring::node, nodes),
                       numbers(std::string(global_cells), Centring::cell, cells)});
}

/// The files of the mesh in random parts; "mesh.pvtu" lists the others.
Files files_of(const QuadraticMesh<3>& mesh, std::size_t count, std::uint64_t seed, bool numbered) {
    const CellParts parts = cut::any_parts(mesh.linear, count, seed);
    Files files;
    std::vector<std::string> names;
    for (std::size_t p = 0; p < count; ++p) {
        const auto piece = must(piece_of(mesh, parts, static_cast<std::int32_t>(p), one_thread));
        const MeshFields fields =
            numbered ? numbers_of(piece, mesh.linear.points.size(), mesh.linear.elements.size()) : MeshFields();
        names.push_back("mesh." + std::to_string(p) + ".vtu");
        files[names.back()] = joined(must(encode_vtu(as_mesh(piece.mesh), fields, {}, one_thread)));
    }
    files["mesh.pvtu"] = bytes_of(must(encode_pvtu(files[names.front()], names)));
    return files;
}

Outcome<DecodedMesh> decoded(const Files& files) {
    DecodeOptions options;
    options.beside = [&](const std::string& name) -> Outcome<Buffer<std::byte>> {
        const auto file = files.find(name);
        if (file == files.end()) return fail(ErrorKind::input, "is not there", name);
        return file->second;
    };
    return decode_mesh(files.at("mesh.pvtu"), "mesh.pvtu", options, one_thread);
}

/// Position of each reference; references are the numbers from 1.
std::vector<std::size_t> order_of(const Column<Reference>& references) {
    std::vector<std::size_t> order(references.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[static_cast<std::size_t>(references[i] - 1)] = i;
    return order;
}

void check_joined_pieces(std::uint64_t seed) {
    const auto mesh = cut::mesh<3>(seed, 2);
    const auto back = decoded(files_of(mesh, *rc::gen::inRange<std::size_t>(1, 5), seed, true));
    if (!back) RC_FAIL(describe(back.error()));
    const auto& result = testing::mesh_in<QuadraticMesh<3>>(back->mesh);
    RC_ASSERT(result.linear.points == mesh.linear.points);
    RC_ASSERT(result.linear.point_references == mesh.linear.point_references);
    RC_ASSERT(result.edges.vertices == mesh.edges.vertices);
    RC_ASSERT(result.mid_nodes == mesh.mid_nodes);
    const auto order = order_of(result.linear.elements.references);
    for (std::size_t e = 0; e < order.size(); ++e)
        RC_ASSERT(result.linear.elements.vertices[order[e]] == mesh.linear.elements.vertices[e]);
    const MeshField* const cells = back->fields.find(global_cells, Centring::cell);
    RC_ASSERT(cells != nullptr);
    const auto& values = std::get<Column<std::int32_t>>(cells->values);
    for (std::size_t e = 0; e < order.size(); ++e) RC_ASSERT(values[e] == result.linear.elements.references[e]);
}

}  // namespace

TEST_CASE("pieces with node numbers are joined to the original mesh") { testing::property("3D", check_joined_pieces); }

TEST_CASE("pieces without numbers are joined by position with a notice") {
    const auto mesh = cut::mesh<3>(7, 2);
    const auto back = decoded(files_of(mesh, 3, 7, false));
    REQUIRE(back.has_value());
    const auto& result = testing::mesh_in<QuadraticMesh<3>>(back->mesh);
    CHECK(result.linear.points.size() == mesh.linear.points.size());
    CHECK(result.edges.size() == mesh.edges.size());
    CHECK(result.linear.facets.size() == mesh.linear.facets.size());
    CHECK(back->notices.back().what.find("3 pieces were joined into one mesh") == 0);
    CHECK(back->notices.back().what.find("at the same places") != std::string::npos);
}

TEST_CASE("a missing or damaged piece is reported by name") {
    Files files = files_of(cut::mesh<3>(5, 2), 2, 5, true);
    Files cut_off = files;
    cut_off["mesh.1.vtu"].resize(200);
    CHECK(describe(decoded(cut_off).error()).starts_with("mesh.1.vtu: line "));
    files.erase("mesh.1.vtu");
    CHECK(describe(decoded(files).error()).starts_with("mesh.1.vtu: is not there"));
    CHECK(decode_mesh(files.at("mesh.pvtu"), "mesh.pvtu", one_thread).error().kind == ErrorKind::unsupported);
    files["mesh.pvtu"] = bytes_of("<VTKFile type=\"PUnstructuredGrid\"><PUnstructuredGrid/></VTKFile>");
    CHECK(describe(decoded(files).error()).starts_with("mesh.pvtu: lists no pieces"));
    files["mesh.pvtu"].resize(50);
    CHECK(describe(decoded(files).error()).starts_with("mesh.pvtu: the XML is damaged"));
}
