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

const Execution alone{.threads = 1};

template <int D>
const LinearMesh<D>& linear_part(const LinearMesh<D>& mesh) {
    return mesh;
}
template <int D>
const LinearMesh<D>& linear_part(const QuadraticMesh<D>& mesh) {
    return mesh.linear;
}

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

template <class Mesh>
void expect_survival(const Mesh& mesh, GmfOptions options) {
    const auto written = encode_gmf_mesh(mesh, options, alone);
    expect(written.has_value(), "what was read can be written");
    const auto bytes = joined(*written);
    const auto again = decode_gmf_mesh(bytes, "again", alone);
    expect(again.has_value(), "what was written can be read");
    // Without simplices of degree 2 a file does not tell that its mesh is of degree 2; there is then no edge either.
    if (!std::holds_alternative<Mesh>(again->mesh)) {
        expect(
            linear_part(mesh).elements.size() + linear_part(mesh).facets.size() + linear_part(mesh).edges.size() == 0,
            "the degree is the same");
        return;
    }
    expect(std::get<Mesh>(again->mesh) == mesh, "the mesh is the same");
}

/// What a format makes of a mesh of its own, it makes again: nothing more is lost.
void expect_settled(const MeshFormat& format, const DecodedMesh& decoded) {
    const auto again = [&](const DecodedMesh& from) {
        const auto written = format.encode(from.mesh, from.fields, {}, alone);
        expect(written.has_value(), "what was read can be written");
        auto read = format.decode(joined(*written), "again", {}, alone);
        expect(read.has_value(), "what was written can be read");
        return *read;
    };
    const DecodedMesh second = again(decoded), third = again(second);
    expect(second.mesh == third.mesh, "the mesh is the same");
}

template <int D>
void judge(const LinearMesh<D>& mesh) {
    const auto found = examine(mesh, alone);
    expect(found.has_value(), "a mesh can be examined");
}
template <int D>
void judge(const QuadraticMesh<D>& mesh) {
    expect(mesh.mid_nodes.size() == mesh.edges.size(), "a node for each edge");
    expect(examine(mesh, alone).has_value(), "a mesh can be examined");
    const auto validation = validate(mesh, 0, alone);
    expect(validation.has_value(), "elements can be judged");
    expect(validation->verdicts.size() == judged_count(mesh.linear), "a verdict for each element");
}

}  // namespace

void mesh(Bytes bytes) {
    // CGNS is read by a library that promises nothing of damaged files.
    if (is_cgns(bytes)) return;
    const auto decoded = decode_mesh(bytes, "file", alone);
    if (!decoded) {
        expect(!decoded.error().what.empty(), "an error says what is wrong");
        expect(decoded.error().where.starts_with("file"), "an error says where");
        return;
    }
    const MeshFormat* const format = format_with_content(mesh_formats(), bytes);
    expect(format != nullptr, "what can be read is known by its content");
    std::visit(
        [&](const auto& mesh) {
            expect_consistent(linear_part(mesh));
            if (is_gmf_ascii(bytes) || is_gmf_binary(bytes)) {
                expect_survival(mesh, {GmfEncoding::binary, 0});
                expect_survival(mesh, {GmfEncoding::ascii, 0});
            }
            judge(mesh);
        },
        decoded->mesh);
    if (format->encode != nullptr) expect_settled(*format, *decoded);
    const auto flat = with_flat_in_2d(*decoded, alone);
    expect(flat.has_value(), "any mesh can be asked whether it is flat");
    const auto raised_again = flat->lift ? raised(flat->mesh, *flat->lift, alone) : flat->mesh;
    expect(raised_again.has_value() && *raised_again == decoded->mesh, "a flat mesh raised is the same");
    if (flat->lift) std::visit([](const auto& mesh) { judge(mesh); }, flat->mesh);
    const std::size_t numbers = decoded->node_numbers.size();
    std::visit(
        [&]<class Mesh>(const Mesh& mesh) {
            if constexpr (requires { mesh.edges.of_elements; })
                expect(numbers == 0 || numbers == mesh.linear.points.size() + mesh.edges.size(),
                       "a number for each node");
            else
                expect(numbers == 0, "no numbers of nodes");
        },
        decoded->mesh);
}

}  // namespace fuzz
