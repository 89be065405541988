module;
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
module camber.io;
import camber.core;
import camber.bezier;
import :stl_file;

namespace camber {

namespace stl {

namespace {

/// Of length 1; zero where the triangle has no area.
Vec<3> normal_of(const Triangle& triangle) {
    const auto& [a, b, c] = triangle.corners;
    Vec<3> u{}, v{};
    double most = 0;  // no product overflows, nor vanishes, of lengths by it
    for (int i = 0; i < 3; ++i) {
        u[i] = b[i] / 2 - a[i] / 2;
        v[i] = c[i] / 2 - a[i] / 2;
        most = std::max({most, std::abs(u[i]), std::abs(v[i])});
    }
    if (most < std::numeric_limits<double>::min()) return {};
    for (int i = 0; i < 3; ++i) {
        u[i] /= most;
        v[i] /= most;
    }
    const Vec<3> n = cross(u, v);
    const double length = norm(n);
    Vec<3> normal{};
    for (int i = 0; i < 3 && length > 0; ++i) normal[i] = n[i] / length;
    return normal;
}

/// Numbers of 4 bytes, the least significant first.
void put_number(std::byte*& to, std::uint32_t bits) {
    for (unsigned shift = 0; shift < 32; shift += 8) *to++ = static_cast<std::byte>(bits >> shift & 0xffU);
}
void put_point(std::byte*& to, const Vec<3>& p) {
    for (int c = 0; c < 3; ++c) put_number(to, std::bit_cast<std::uint32_t>(static_cast<float>(p[c])));
}

Outcome<Chunks> binary(const Triangles& triangles) {
    if (triangles.size() > std::numeric_limits<std::uint32_t>::max())
        return fail(ErrorKind::unsupported, "has more triangles than STL can number", {}, {}, "give a smaller mesh");
    for (const Triangle& triangle : triangles)
        if (!std::all_of(triangle.corners.begin(), triangle.corners.end(), [](const auto& p) { return is_finite(p); }))
            return fail(ErrorKind::unsupported, "has coordinates that are too large for the 32 bits of STL in binary",
                        {}, {}, "write it as text: --format stl-ascii");
    Buffer<std::byte> bytes(header_bytes + count_bytes + row_bytes * triangles.size());
    std::byte* to = bytes.data();
    std::string header = "the boundary of a mesh of Camber";  // not "solid", which is how text begins
    header.resize(header_bytes, ' ');
    std::memcpy(to, header.data(), header.size());
    to += header.size();
    put_number(to, static_cast<std::uint32_t>(triangles.size()));
    for (const Triangle& triangle : triangles) {
        put_point(to, normal_of(triangle));
        for (const Vec<3>& corner : triangle.corners) put_point(to, corner);
        *to++ = std::byte{0};
        *to++ = std::byte{0};
    }
    Chunks chunks;
    chunks.push_back(std::move(bytes));
    return chunks;
}

Outcome<Chunks> text(const Written& all, const Execution& execution) {
    constexpr std::size_t room = 19;  // words, of which 12 are numbers
    const Triangles& triangles = all.triangles;
    const auto write = [](char* to, std::string_view words) { return std::copy(words.begin(), words.end(), to); };
    const auto write_point = [](char* to, const Vec<3>& p) {
        return write_word(write_word(write_word(to, p[0], ' '), p[1], ' '), p[2], '\n');
    };
    TextWriter writer(execution);
    if (triangles.empty()) writer.put("solid empty\nendsolid empty\n");
    std::size_t begin = 0;
    for (const Group& solid : all.groups) {
        std::size_t end = begin;
        while (end < triangles.size() && triangles[end].reference == solid.reference) ++end;
        writer.put("solid " + solid.name + "\n");
        auto done = writer.lines(end - begin, room, [&](std::size_t i, char* to) {
            const Triangle& triangle = triangles[begin + i];
            to = write_point(write(to, "facet normal "), normal_of(triangle));
            to = write(to, "outer loop\n");
            for (const Vec<3>& corner : triangle.corners) to = write_point(write(to, "vertex "), corner);
            return write(to, "endloop\nendfacet\n");
        });
        if (!done) return fail(std::move(done.error()));
        writer.put("endsolid " + solid.name + "\n");
        begin = end;
    }
    return std::move(writer).finish();
}

template <class Mesh>
Outcome<Chunks> encode(const Mesh& mesh, const Column<Group>& groups, StlEncoding encoding,
                       const Execution& execution) {
    return guarded([&]() -> Outcome<Chunks> {
        const Written all = written(mesh, groups, encoding);
        return encoding == StlEncoding::binary ? binary(all.triangles) : text(all, execution);
    });
}

}  // namespace

}  // namespace stl

template <int D>
Outcome<Chunks> encode_stl(const LinearMesh<D>& mesh, StlEncoding encoding, const Execution& execution) {
    return stl::encode(mesh, mesh.groups, encoding, execution);
}
template <int D>
Outcome<Chunks> encode_stl(const QuadraticMesh<D>& mesh, StlEncoding encoding, const Execution& execution) {
    return stl::encode(mesh, mesh.linear.groups, encoding, execution);
}

#define CAMBER_INSTANTIATE(D)                                                                    \
    template Outcome<Chunks> encode_stl<D>(const LinearMesh<D>&, StlEncoding, const Execution&); \
    template Outcome<Chunks> encode_stl<D>(const QuadraticMesh<D>&, StlEncoding, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
