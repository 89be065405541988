// Writes STL files: triangles of the boundary, text and binary.
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

constexpr double infinite = std::numeric_limits<double>::infinity();

/// Three vertices; for degree 2 also the nodes of edges 01, 12, 20.
template <std::size_t Nodes>
struct Face {
    std::array<std::size_t, Nodes> nodes{};
    Reference reference = 0;
};

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
    [[nodiscard]] Vec<3> point(std::size_t node) const {
        Vec<3> p{};
        for (int c = 0; c < D; ++c) p[c] = grid_.point(node)[c] + 0.0;  // turns −0 into 0
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

    /// Face i of element e, oriented outwards even if the element is inverted.
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
Triangles triangles_of(const Mesh& mesh) {
    const Surface<Mesh> surface(mesh);
    Triangles triangles;
    for (const auto& face : surface.faces()) {
        const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
            triangles.push_back(
                {{surface.point(face.nodes[a]), surface.point(face.nodes[b]), surface.point(face.nodes[c])},
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
    return triangles;
}

std::size_t round(Triangles& triangles) {
    std::size_t rounded = 0;
    for (Triangle& triangle : triangles)
        for (Vec<3>& corner : triangle.corners)
            for (int c = 0; c < 3; ++c) {
                constexpr double most = std::numeric_limits<float>::max();
                const double x = corner[c], inside = std::clamp(x, -most, most);
                corner[c] = x == inside ? static_cast<float>(x) : std::copysign(infinite, x);
                rounded += corner[c] == x ? 0 : 1;
            }
    return rounded;
}

}  // namespace

template <class Mesh>
Written written(const Mesh& mesh, const Column<Group>& groups, StlEncoding encoding) {
    Written result{.triangles = triangles_of(mesh)};
    if (encoding == StlEncoding::binary) {
        result.rounded = round(result.triangles);
        result.left_out = std::erase_if(result.triangles, has_equal_corners);
        for (Triangle& triangle : result.triangles) triangle.reference = 1;
        return result;
    }
    result.left_out = std::erase_if(result.triangles, has_equal_corners);
    Solids solids;
    std::map<Reference, Reference> numbers;
    for (const auto& [reference, name] : solid_names(result.triangles, groups, result.renamed))
        numbers[reference] = solids.of(name);
    for (Triangle& triangle : result.triangles) triangle.reference = numbers[triangle.reference];
    std::stable_sort(result.triangles.begin(), result.triangles.end(),
                     [](const Triangle& a, const Triangle& b) { return a.reference < b.reference; });
    result.groups = std::move(solids).groups();
    return result;
}

namespace {

Vec<3> normal_of(const Triangle& triangle) {
    const auto& [a, b, c] = triangle.corners;
    Vec<3> u{}, v{};
    double most = 0;  // largest component, by which all are divided to prevent overflow and underflow
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
    std::string header = "the boundary of a mesh of Camber";  // must not begin with "solid", like text files
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
    constexpr std::size_t room = 19;  // number of words of a triangle as text; 12 of them are numbers
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
Outcome<Chunks> encode_stl(const Mesh<D>& mesh, StlEncoding encoding, const Execution& execution) {
    return on_simplices(
        mesh, [&](const auto& simplices) { return stl::encode(simplices, mesh.groups, encoding, execution); });
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template stl::Written stl::written<LinearMesh<D>>(const LinearMesh<D>&, const Column<Group>&, StlEncoding);       \
    template stl::Written stl::written<QuadraticMesh<D>>(const QuadraticMesh<D>&, const Column<Group>&, StlEncoding); \
    template Outcome<Chunks> encode_stl<D>(const Mesh<D>&, StlEncoding, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
