// Example of camber.io: encodes a quadratic mesh as GMF, decodes it, and tries to decode a damaged file. The module
// takes and returns bytes; the caller reads and writes the files.
#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <span>
#include <string>
#include <variant>

import camber.core;
import camber.bezier;
import camber.io;

using namespace camber;

static LinearMesh<2> two_triangles() {
    const auto v = [](std::size_t i) { return VertexId(i); };
    LinearMesh<2> mesh;
    mesh.points = Buffer<Vec<2>>{{{0, 0}}, {{1, 0}}, {{1, 1}}, {{0, 1}}};
    mesh.point_references = Buffer<Reference>(4, 0);
    mesh.elements.vertices = Buffer<SimplexVertices<2>>{{v(0), v(1), v(2)}, {v(0), v(2), v(3)}};
    mesh.elements.references = Buffer<Reference>{7, 8};
    return mesh;
}

static Outcome<bool> example(const Execution& execution) {
    const auto mesh = elevate(as_mesh(two_triangles()), 2, execution);
    if (!mesh) return fail(mesh.error());
    const auto chunks = encode_gmf_mesh(*mesh, GmfOptions{.encoding = GmfEncoding::ascii}, execution);
    if (!chunks) return fail(chunks.error());
    std::string text;  // a file is the concatenation of the chunks
    for (const auto& chunk : *chunks) text.append(reinterpret_cast<const char*>(chunk.data()), chunk.size());
    std::printf("%zu bytes of ASCII GMF, %zu lines of them\n", text.size(),
                static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')));

    const auto bytes_of = [](const std::string& s) { return std::as_bytes(std::span(s.data(), s.size())); };
    const auto decoded = decode_gmf_mesh(bytes_of(text), "square.mesh", execution);
    if (!decoded) return fail(decoded.error());
    const auto* same = std::get_if<Mesh<2>>(&decoded->mesh);  // dimension and degree are known only after decoding
    const bool round_trip = same != nullptr && *same == *mesh;
    std::printf("read again: %s\n", round_trip ? "the same mesh, to the bit" : "another mesh");

    text.resize(text.size() / 2);
    const auto damaged = decode_gmf_mesh(bytes_of(text), "square.mesh", execution);
    if (!damaged) std::printf("cut in half: %s\n", describe(damaged.error()).c_str());
    return round_trip && !damaged && damaged.error().kind == ErrorKind::input;
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
