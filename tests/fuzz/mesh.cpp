#include "targets.hpp"

#include <cstddef>
#include <variant>
#include <vector>

import camber.core;
import camber.bezier;
import camber.io;
import camber.validity;
import camber.soundness;

namespace fuzz {

namespace {

using namespace camber;

const Execution one_thread{.threads = 1};

template <int D>
void expect_consistent(const LinearMesh<D>& mesh) {
    const std::size_t n = mesh.points.size();
    expect(mesh.point_references.size() == n, "a reference for each vertex");
    for (const auto& p : mesh.points) expect(is_finite(p), "coordinates are finite");
    const auto check = [&](const auto& kind) {
        expect(kind.references.size() == kind.size(), "a reference for each simplex");
        for (const auto& simplex : kind.vertices)
            for (std::size_t i = 0; i < simplex.size(); ++i) {
                expect(simplex[i].index() < n, "vertices of simplices exist");
                for (std::size_t j = 0; j < i; ++j) expect(simplex[i] != simplex[j], "vertices of a simplex differ");
            }
        for (const auto i : kind.required) expect(i < kind.size(), "required simplices exist");
    };
    check(mesh.elements);
    check(mesh.facets);
    check(mesh.edges);
    for (const auto i : mesh.ridges) expect(i < (D == 2 ? mesh.facets.size() : mesh.edges.size()), "ridges exist");
    for (const VertexId v : mesh.corners) expect(v.index() < n, "corners exist");
    for (const VertexId v : mesh.required_vertices) expect(v.index() < n, "required vertices exist");
}

std::vector<std::byte> joined(const Chunks& chunks) {
    std::vector<std::byte> bytes;
    for (const auto& chunk : chunks) bytes.insert(bytes.end(), chunk.begin(), chunk.end());
    return bytes;
}

template <int D>
void expect_survival(const Mesh<D>& mesh, GmfOptions options) {
    const auto written = encode_gmf_mesh(mesh, options, one_thread);
    expect(written.has_value(), "decoded input can be encoded");
    const auto bytes = joined(*written);
    const auto again = decode_gmf_mesh(bytes, "again", one_thread);
    expect(again.has_value(), "encoded output can be decoded");
    const auto* const same = std::get_if<Mesh<D>>(&again->mesh);
    expect(same != nullptr, "the dimension is the same");
    // A file without quadratic simplices does not store the degree 2. Its mesh then has no edge either.
    if (same->degree != mesh.degree) {
        const auto linear = straight_simplices(mesh);
        expect(linear.elements.size() + linear.facets.size() + linear.edges.size() == 0, "the degree is the same");
        return;
    }
    expect(*same == mesh, "the mesh is the same");
}

/// Writing and reading a mesh a second time changes nothing.
void expect_stable(const MeshFormat& format, const DecodedMesh& decoded) {
    const auto again = [&](const DecodedMesh& from) {
        const auto written = format.encode(from.mesh, from.fields, {}, one_thread);
        expect(written.has_value(), "decoded input can be encoded");
        auto read = format.decode(joined(*written), "again", {}, one_thread);
        expect(read.has_value(), "encoded output can be decoded");
        return *read;
    };
    const DecodedMesh second = again(decoded), third = again(second);
    expect(second.mesh == third.mesh, "the mesh is the same");
}

template <int D>
void check_validity(const Mesh<D>& mesh) {
    expect(examine(mesh, one_thread).has_value(), "a mesh can be examined");
    if (mesh.degree == 1) return;
    expect(mesh.edge_nodes.size() == mesh.entities.edges.size(), "a node for each edge");
    const auto quadratic = as_quadratic(mesh);
    expect(quadratic.has_value(), "a mesh of degree 2 is a quadratic one");
    const auto validation = validate(*quadratic, 0, one_thread);
    expect(validation.has_value(), "elements can be validated");
    expect(validation->verdicts.size() == judged_count(quadratic->linear), "a verdict for each element");
}

}  // namespace

void mesh(Bytes bytes) {
    // CGNS is read by an external library that does not guard against damaged files.
    if (is_cgns(bytes)) return;
    const auto decoded = decode_mesh(bytes, "file", one_thread);
    if (!decoded) {
        expect(!decoded.error().what.empty(), "an error has a description");
        expect(decoded.error().where.starts_with("file"), "an error states its place");
        return;
    }
    const MeshFormat* const format = format_with_content(mesh_formats(), bytes);
    expect(format != nullptr, "the content of decoded input identifies its format");
    std::visit(
        [&](const auto& mesh) {
            expect_consistent(straight_simplices(mesh));
            if (is_gmf_ascii(bytes) || is_gmf_binary(bytes)) {
                expect_survival(mesh, {GmfEncoding::binary, 0});
                expect_survival(mesh, {GmfEncoding::ascii, 0});
            }
            check_validity(mesh);
        },
        decoded->mesh);
    if (format->encode != nullptr) expect_stable(*format, *decoded);
    const auto flat = with_flat_in_2d(*decoded, one_thread);
    expect(flat.has_value(), "the test for flat meshes accepts every mesh");
    const auto raised_again = flat->lift ? raised(flat->mesh, *flat->lift, one_thread) : flat->mesh;
    expect(raised_again.has_value() && *raised_again == decoded->mesh, "a flat mesh raised is the same");
    if (flat->lift) std::visit([](const auto& mesh) { check_validity(mesh); }, flat->mesh);
    const std::size_t numbers = decoded->node_numbers.size();
    std::visit(
        [&](const auto& mesh) {
            expect(numbers == 0 || (mesh.degree == 2 && numbers == count_nodes(mesh)), "a number for each node");
        },
        decoded->mesh);
}

}  // namespace fuzz
