module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber {

namespace stl {

namespace {

using Point = std::array<float, 3>;

/// A triangle of the file.
struct Flat {
    std::array<Point, 3> corners;
    Reference reference = 0;
};

constexpr std::size_t header_bytes = 80, row_bytes = 50;

/// The nodes of a triangle of the mesh: three, of degree 2 also those of its edges 01 12 20.
template <std::size_t Nodes>
struct Face {
    std::array<std::size_t, Nodes> nodes{};
    Reference reference = 0;
};

/// By rising nodes, to find faces again whichever way they are turned.
using FaceKey = std::array<std::size_t, 3>;
FaceKey key_of(std::size_t a, std::size_t b, std::size_t c) {
    FaceKey key{a, b, c};
    std::sort(key.begin(), key.end());
    return key;
}

template <class Mesh>
class Surface {
  public:
    static constexpr int D = Mesh::dimension;
    using G = Grid<Mesh>;
    static constexpr std::size_t width = G::template width<2>;
    using Faces = std::vector<Face<width>>;

    explicit Surface(const Mesh& mesh) : grid_{mesh}, linear_(grid_.linear()) {}

    [[nodiscard]] Faces faces() const {
        if constexpr (D == 2)
            return listed(linear_.elements);
        else
            return linear_.elements.size() == 0 ? listed(linear_.facets) : boundary();
    }
    [[nodiscard]] Point point(std::size_t node) const {
        Point p{};
        for (int c = 0; c < D; ++c) p[static_cast<std::size_t>(c)] = static_cast<float>(grid_.point(node)[c]);
        return p;
    }

  private:
    [[nodiscard]] Faces listed(const Simplices<2>& triangles) const {
        Faces faces(triangles.size());
        for (std::size_t t = 0; t < faces.size(); ++t) {
            for (std::size_t n = 0; n < width; ++n) faces[t].nodes[n] = grid_.template node<2>(triangles, t, n);
            faces[t].reference = triangles.references[t];
        }
        return faces;
    }

    /// Faces that one element alone has, with the references of the facets that are listed there.
    [[nodiscard]] Faces boundary() const {
        std::vector<std::pair<FaceKey, std::size_t>> all;
        all.reserve(linear_.elements.size() * 4);
        for (std::size_t e = 0; e < linear_.elements.size(); ++e)
            for (int i = 0; i < 4; ++i) {
                const auto local = face_opposite<3>(i);
                const auto& v = linear_.elements.vertices[e];
                all.emplace_back(key_of(v[local[0]].index(), v[local[1]].index(), v[local[2]].index()),
                                 4 * e + static_cast<std::size_t>(i));
            }
        std::sort(all.begin(), all.end());
        std::map<FaceKey, Reference> references;
        for (std::size_t f = 0; f < linear_.facets.size(); ++f) {
            const auto& v = linear_.facets.vertices[f];
            references.try_emplace(key_of(v[0].index(), v[1].index(), v[2].index()), linear_.facets.references[f]);
        }
        std::vector<std::size_t> alone;
        for (std::size_t i = 0; i < all.size(); ++i) {
            const bool before = i > 0 && all[i - 1].first == all[i].first;
            const bool behind = i + 1 < all.size() && all[i + 1].first == all[i].first;
            if (!before && !behind) alone.push_back(all[i].second);
        }
        std::sort(alone.begin(), alone.end());
        Faces faces;
        faces.reserve(alone.size());
        for (const std::size_t face : alone) {
            faces.push_back(outward(face / 4, static_cast<int>(face % 4)));
            const auto& nodes = faces.back().nodes;
            if (const auto found = references.find(key_of(nodes[0], nodes[1], nodes[2])); found != references.end())
                faces.back().reference = found->second;
        }
        return faces;
    }

    /// Face i of an element, also of one that is numbered the wrong way round.
    [[nodiscard]] Face<width> outward(std::size_t e, int i) const {
        auto local = face_opposite<3>(i);
        const auto& v = linear_.elements.vertices[e];
        const auto& p = linear_.points;
        const Vec<3> a = p[v[local[0]]], normal = cross(p[v[local[1]]] - a, p[v[local[2]]] - a);
        if (dot(normal, p[v[i]] - a) > 0) std::swap(local[1], local[2]);
        Face<width> face{};
        for (std::size_t n = 0; n < 3; ++n)
            face.nodes[n] = grid_.template node<3>(linear_.elements, e, static_cast<std::size_t>(local[n]));
        if constexpr (width == 6)
            for (std::size_t k = 0; k < 3; ++k)
                face.nodes[3 + k] =
                    grid_.template node<3>(linear_.elements, e, 4 + edge_of(local[k], local[(k + 1) % 3]));
        return face;
    }
    static std::size_t edge_of(int a, int b) {
        for (std::size_t k = 0; k < local_edges<3>.size(); ++k)
            if ((local_edges<3>[k][0] == a && local_edges<3>[k][1] == b) ||
                (local_edges<3>[k][0] == b && local_edges<3>[k][1] == a))
                return k;
        return 0;
    }

    G grid_;
    const LinearMesh<D>& linear_;
};

template <class Mesh>
std::vector<Flat> triangles_of(const Mesh& mesh) {
    const Surface<Mesh> surface(mesh);
    std::vector<Flat> flat;
    for (const auto& face : surface.faces()) {
        const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
            flat.push_back({{surface.point(face.nodes[a]), surface.point(face.nodes[b]), surface.point(face.nodes[c])},
                            face.reference});
        };
        if constexpr (Surface<Mesh>::width == 3) {
            add(0, 1, 2);
        } else {
            add(0, 3, 5);
            add(3, 1, 4);
            add(5, 4, 2);
            add(3, 4, 5);
        }
    }
    return flat;
}

/// Of length 1; zero where the triangle has no area.
Point normal_of(const Flat& triangle) {
    const auto& [a, b, c] = triangle.corners;
    std::array<double, 3> u{}, v{};
    for (std::size_t i = 0; i < 3; ++i) {
        u[i] = static_cast<double>(b[i]) - a[i];
        v[i] = static_cast<double>(c[i]) - a[i];
    }
    const std::array<double, 3> n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double length = std::hypot(n[0], n[1], n[2]);
    Point normal{};
    for (std::size_t i = 0; i < 3 && length > 0; ++i) normal[i] = static_cast<float>(n[i] / length);
    return normal;
}

void put(std::byte*& to, const void* from, std::size_t bytes) {
    std::memcpy(to, from, bytes);
    to += bytes;
}

/// Numbers of 4 bytes, the least significant first.
void put_number(std::byte*& to, std::uint32_t bits) {
    for (unsigned shift = 0; shift < 32; shift += 8) *to++ = static_cast<std::byte>(bits >> shift & 0xffU);
}
void put_point(std::byte*& to, const Point& p) {
    for (const float x : p) put_number(to, std::bit_cast<std::uint32_t>(x));
}

Outcome<Chunks> binary(const std::vector<Flat>& triangles) {
    if (triangles.size() > std::numeric_limits<std::uint32_t>::max())
        return fail(ErrorKind::unsupported, "has more triangles than STL can number", {}, {}, "give a smaller mesh");
    Buffer<std::byte> bytes(header_bytes + 4 + row_bytes * triangles.size());
    std::byte* to = bytes.data();
    std::string header = "the boundary of a mesh of Camber";  // not "solid", which is how text begins
    header.resize(header_bytes, ' ');
    put(to, header.data(), header.size());
    put_number(to, static_cast<std::uint32_t>(triangles.size()));
    for (const Flat& triangle : triangles) {
        put_point(to, normal_of(triangle));
        for (const Point& corner : triangle.corners) put_point(to, corner);
        *to++ = std::byte{0};
        *to++ = std::byte{0};
    }
    Chunks chunks;
    chunks.push_back(std::move(bytes));
    return chunks;
}

/// The name of a solid: its group's, in one line.
std::string solid_name(const Column<Group>& groups, int dimension, Reference reference) {
    for (const Group& group : groups)
        if (group.dimension == dimension && group.reference == reference && !group.name.empty()) {
            std::string name = group.name;
            for (char& c : name)
                if (c >= 0 && c < ' ') c = ' ';
            return name;
        }
    return "reference_" + std::to_string(reference);
}

Outcome<Chunks> text(std::vector<Flat> triangles, const Column<Group>& groups, const Execution& execution) {
    std::stable_sort(triangles.begin(), triangles.end(),
                     [](const Flat& a, const Flat& b) { return a.reference < b.reference; });
    constexpr std::size_t room = 19;  // words, of which 12 are numbers
    const auto write = [](char* to, std::string_view words) { return std::copy(words.begin(), words.end(), to); };
    const auto write_point = [](char* to, const Point& p) {
        to = write_word(write_word(write_word(to, p[0], ' '), p[1], ' '), p[2], '\n');
        return to;
    };
    TextWriter writer(execution);
    if (triangles.empty()) writer.put("solid empty\nendsolid empty\n");
    for (std::size_t begin = 0, end = 0; begin < triangles.size(); begin = end) {
        while (end < triangles.size() && triangles[end].reference == triangles[begin].reference) ++end;
        const std::string name = solid_name(groups, 2, triangles[begin].reference);
        writer.put("solid " + name + "\n");
        auto written = writer.lines(end - begin, room, [&](std::size_t i, char* to) {
            const Flat& triangle = triangles[begin + i];
            to = write_point(write(to, "facet normal "), normal_of(triangle));
            to = write(to, "outer loop\n");
            for (const Point& corner : triangle.corners) to = write_point(write(to, "vertex "), corner);
            return write(to, "endloop\nendfacet\n");
        });
        if (!written) return fail(std::move(written.error()));
        writer.put("endsolid " + name + "\n");
    }
    return std::move(writer).finish();
}

template <class Mesh>
Outcome<Chunks> encode(const Mesh& mesh, const Column<Group>& groups, StlEncoding encoding,
                       const Execution& execution) {
    return guarded([&]() -> Outcome<Chunks> {
        std::vector<Flat> triangles = triangles_of(mesh);
        return encoding == StlEncoding::binary ? binary(triangles) : text(std::move(triangles), groups, execution);
    });
}

template <int D>
std::vector<Notice> losses(const LinearMesh<D>& mesh, int degree, StlEncoding encoding) {
    std::vector<Notice> notices;
    if (D == 3 && mesh.elements.size() > 0)
        notices.push_back({"STL has no place for " + std::to_string(mesh.elements.size()) +
                           " tetrahedra: the boundary is written, in coordinates of 32 bits"});
    else
        notices.push_back({"STL has coordinates of 32 bits"});
    if (degree == 2) notices.push_back({"STL is flat: each curved triangle becomes four between its nodes"});
    if (encoding == StlEncoding::binary) notices.push_back({"STL in binary has no place for references"});
    return notices;
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

bool is_stl(std::span<const std::byte> bytes, StlEncoding encoding) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min<std::size_t>(bytes.size(), 6));
    const bool solid = text.starts_with("solid") && (text.size() < 6 || is_blank(text[5]));
    if (encoding == StlEncoding::ascii && !solid) return false;
    const std::size_t head = stl::header_bytes + 4;
    if (bytes.size() < head) return encoding == StlEncoding::ascii;
    // A header of 80 letters, that is none of those that other formats begin with.
    if (text[0] < ' ' || std::string_view("$#<@").find(text[0]) != std::string_view::npos) return false;
    std::uint64_t count = 0;
    for (unsigned i = 0; i < 4; ++i) count |= static_cast<std::uint64_t>(bytes[stl::header_bytes + i]) << (8U * i);
    const bool is_binary = bytes.size() == head + stl::row_bytes * count;
    return is_binary == (encoding == StlEncoding::binary);
}

template <int D>
std::vector<Notice> not_in_stl(const LinearMesh<D>& mesh, StlEncoding encoding) {
    return stl::losses(mesh, 1, encoding);
}
template <int D>
std::vector<Notice> not_in_stl(const QuadraticMesh<D>& mesh, StlEncoding encoding) {
    return stl::losses(mesh.linear, 2, encoding);
}

#define CAMBER_INSTANTIATE(D)                                                                       \
    template Outcome<Chunks> encode_stl<D>(const LinearMesh<D>&, StlEncoding, const Execution&);    \
    template Outcome<Chunks> encode_stl<D>(const QuadraticMesh<D>&, StlEncoding, const Execution&); \
    template std::vector<Notice> not_in_stl<D>(const LinearMesh<D>&, StlEncoding);                  \
    template std::vector<Notice> not_in_stl<D>(const QuadraticMesh<D>&, StlEncoding);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
