module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>
#include <vector>
/// Checks of input meshes (`examine`), and unambiguous corrections (`prepare`).
export module camber.soundness;
import camber.core;
import camber.validity;

export namespace camber {

/// Defects of a straight mesh, or of the straight part of a quadratic one.
enum class Defect : std::uint8_t {
    repeated_element,       ///< has the same vertices and reference as an earlier element
    contradicting_element,  ///< has the same vertices as an earlier element, but another reference
    crowded_face,           ///< has a face with more than two elements
    isolated_facet,         ///< not a face of any element
    repeated_facet,         ///< like `repeated_element`, for facets
    contradicting_facet,
    distant_vertex,     ///< a coordinate is beyond `max_length`: products would overflow
    distant_node,       ///< like `distant_vertex`, for a mid node (degree 2)
    tiny_element,       ///< smaller than `min_length` in each coordinate: products would underflow
    tiny_facet,         ///< like `tiny_element`, for a facet
    hanging_vertex,     ///< lies inside an unlisted boundary face
    duplicate_vertex,   ///< coincides with an earlier vertex, not across a slit
    reversed_element,   ///< the order of its vertices has the wrong orientation
    tangled_element,    ///< has negative volume if oriented like its neighbours: inverted or overlapping
    flat_element,       ///< its straight volume is zero up to rounding
    missing_facet,      ///< element with a boundary face that is not listed, although other boundary faces are
    no_facets,          ///< element with a boundary face, in a mesh that lists no facets
    missing_interface,  ///< element with an unlisted face to an element of another reference
    unused_vertex,      ///< not a vertex of any element, facet or feature edge
    slit_vertex,        ///< coincides with an earlier vertex across a slit whose two sides are listed as boundary
    coincident_node,    ///< mid node that coincides with a vertex, or with the mid node of an edge with other ends
                        ///< (degree 2)
    inner_facet,        ///< between two elements of the same reference
    open_edge,          ///< edge (2D: vertex) of only one boundary face, so the boundary is not closed
    crowded_edge,       ///< edge of more than two boundary faces (3D)
    pinched_vertex,     ///< the boundary faces at the vertex form several fans
    isolated_edge,      ///< feature edge without element and facet (3D)
    wall_element,       ///< element with two faces on one smooth wall: invalid if the wall is curved
};
inline constexpr std::size_t defect_count = 27;

enum class Severity : std::uint8_t {
    fatal,     ///< neither Camber nor a solver can use the mesh
    blocking,  ///< only the elements with the defect are invalid
    mended,    ///< an error that `prepare` corrects
    harmless,  ///< no problem for solvers; `prepare` corrects it if necessary
};

/// Number of entities with a defect. `first`: number of the first such entity in the file, from 1.
struct Finding {
    std::size_t count = 0;
    std::size_t first = 0;  ///< 0: none
    std::size_t other = 0;  ///< number of another entity: the earlier twin, the second end of the edge, or the element
                            ///< with the face
    friend bool operator==(const Finding&, const Finding&) = default;
};

/// An element with two faces on one smooth wall (boundary or interface). On a curved wall, the faces meet at 180
/// degrees, so det J is 0 there for all node positions. Only an edge swap corrects this.
struct WallElement {
    ElementId element;
    std::array<VertexId, 2> hinge;  ///< shared edge; in 2D a vertex and an invalid id
    friend bool operator==(const WallElement&, const WallElement&) = default;
};

struct ExamineOptions {
    /// Maximum angle in degrees between faces of one smooth wall. Walls also end at listed ridges (2D: listed corners,
    /// and ends of listed ridges) and where the reference changes.
    double ridge_angle_degrees = 40;
};

struct Soundness {
    int dimension = 3;
    bool empty = false;  ///< the mesh has neither elements nor facets
    std::array<Finding, defect_count> findings{};
    std::vector<WallElement> wall_elements = {};  ///< ascending by element

    [[nodiscard]] const Finding& operator[](Defect defect) const { return findings[static_cast<std::size_t>(defect)]; }
    /// True if the mesh is not empty and all defects are harmless.
    [[nodiscard]] bool sound() const;
    friend bool operator==(const Soundness&, const Soundness&) = default;
};

[[nodiscard]] Severity severity(Defect defect);
/// Name of a defect in JSON, for example "stray_facets".
[[nodiscard]] const char* key(Defect defect);
/// Returns a sentence without a full stop, for example "2 triangles are a face of no tetrahedron (the first: triangle
/// 7)".
[[nodiscard]] std::string sentence(const Soundness& soundness, Defect defect);
/// Returns the error for the first fatal defect, if any.
[[nodiscard]] std::optional<Error> refusal(const Soundness& soundness);

/// Checks a mesh for all defects, in linear time and memory except for hanging vertices.
/// - Preconditions, which decoders guarantee: vertex ids are in range and distinct within a simplex; coordinates are
///   finite.
/// - Without elements, the facets are checked as a surface.
/// - Repeated elements and facets are not checked for other defects.
/// - Quadratic elements count as reversed if their curved volume is negative. `validate` checks their validity.
/// - Numbers in findings count vertices first, then the nodes of edges.
///
/// Errors: unsupported (not simplices of degree 1 or 2), memory, stopped.
template <int D>
[[nodiscard]] Outcome<Soundness> examine(const Mesh<D>& mesh, const ExamineOptions& options,
                                         const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Soundness> examine(const Mesh<D>& mesh, const Execution& execution) {
    return examine(mesh, ExamineOptions{}, execution);
}

template <int D>
[[nodiscard]] double signed_measure(const std::array<Vec<D>, D + 1>& p) {
    if constexpr (D == 2)
        return det(p[1] - p[0], p[2] - p[0]) / 2;
    else
        return det(p[1] - p[0], p[2] - p[0], p[3] - p[0]) / 6;
}

/// Signed mean ratio of a simplex with volume V (2D: area A) and edge lengths l: 12 (3V)^(2/3) / Σ l², in 2D 4 √3 A / Σ
/// l². It is 1 for regular simplices and 0 for flat ones.
template <int D>
[[nodiscard]] double mean_ratio(const std::array<Vec<D>, D + 1>& corners) {
    double longest = 0;
    for (const auto& [a, b] : local_edges<D>)
        longest =
            std::max(longest, distance(corners[static_cast<std::size_t>(a)], corners[static_cast<std::size_t>(b)]));
    if (!(longest > 0) || !std::isfinite(longest)) return 0;
    // Lengths are divided by the longest edge, to avoid overflow.
    std::array<Vec<D>, D + 1> p;
    for (int i = 0; i <= D; ++i) p[i] = (corners[i] - corners[0]) / longest;
    double squares = 0;
    for (const auto& [a, b] : local_edges<D>)
        squares += norm_squared(p[static_cast<std::size_t>(a)] - p[static_cast<std::size_t>(b)]);
    const double measure = signed_measure<D>(p);
    if constexpr (D == 2) return 4 * std::sqrt(3.0) * measure / squares;
    return std::copysign(12 * pow(3 * std::abs(measure), 2.0 / 3) / squares, measure);
}

/// A corrected mesh. Each notice is a sentence without a full stop.
template <int D>
struct Prepared {
    Mesh<D> mesh;
    std::vector<std::string> notices;
};

/// Makes unambiguous corrections, and rejects unusable meshes:
/// - Removes repeated elements and facets.
/// - Removes stray facets, if the mesh has elements.
/// - Exchanges the first two vertices of reversed elements. Tangled elements get the orientation of their neighbours.
///   No order of their vertices is right, but all later checks then see a negative volume.
/// - Adds facets for unlisted faces of the boundary and of interfaces. Each of these two kinds gets a new reference,
///   after those of facets and named facet groups.
///
/// Vertices, their order, and nodes of curved edges do not change. Sound meshes are returned unchanged. Errors: input
/// (the fatal defects of `Soundness`, an empty mesh), unsupported (not simplices of degree 1 or 2), memory, stopped.
template <int D>
[[nodiscard]] Outcome<Prepared<D>> prepare(Mesh<D> mesh, const Execution& execution);

}  // namespace camber

namespace camber {

/// Values of `neighbours` that are no element numbers: no element, and several elements.
inline constexpr std::uint32_t no_element = 0xffffffffU;
inline constexpr std::uint32_t several = 0xfffffffeU;

template <int D>
struct Examination {
    Soundness soundness;
    Incidence<ElementId> elements_of;  ///< elements around each vertex
    Incidence<FacetId> facets_of;
    Buffer<std::uint32_t> element_twins;  ///< number of the first earlier element with the same vertices, otherwise
                                          ///< `no_element`
    Buffer<std::uint32_t> facet_twins;
    Buffer<std::array<std::uint32_t, D + 1>> neighbours;  ///< element across each face, `no_element` or `several`
    Buffer<std::array<std::uint32_t, 2>> sides;
    Buffer<std::uint8_t> unlisted;    ///< bit i: face i is on the boundary, and not listed
    Buffer<std::uint8_t> interfaces;  ///< bit i: face i is an interface that is not listed; only set in the element
                                      ///< with the lower number
    Buffer<std::uint8_t> turned;      ///< 1: the element must be reversed

    [[nodiscard]] bool element_counts(std::size_t e) const { return element_twins[e] == no_element; }
    [[nodiscard]] bool facet_counts(std::size_t f) const { return facet_twins[f] == no_element; }
    [[nodiscard]] Finding& operator[](Defect defect) { return soundness.findings[static_cast<std::size_t>(defect)]; }
};

/// Face opposite a local vertex. Its normal points outward if the element is positive.
template <int D>
[[nodiscard]] inline SimplexVertices<D - 1> face_of(const SimplexVertices<D>& element, int opposite) {
    SimplexVertices<D - 1> face;
    const auto local = face_opposite<D>(opposite);
    for (int i = 0; i < D; ++i) face[i] = element[local[i]];
    return face;
}

template <std::size_t N>
[[nodiscard]] constexpr bool has(const std::array<VertexId, N>& simplex, VertexId v) {
    return std::find(simplex.begin(), simplex.end(), v) != simplex.end();
}

template <std::size_t N, std::size_t M>
[[nodiscard]] constexpr bool has_all(const std::array<VertexId, M>& whole, const std::array<VertexId, N>& part) {
    return std::all_of(part.begin(), part.end(), [&](VertexId v) { return has(whole, v); });
}

template <std::size_t N, class Item>
[[nodiscard]] inline VertexId least_connected(const std::array<VertexId, N>& simplex, const Incidence<Item>& around) {
    return *std::min_element(simplex.begin(), simplex.end(),
                             [&](VertexId a, VertexId b) { return around[a].size() < around[b].size(); });
}

/// Counts the numbers i in [0, n) for which `chosen(i)` is true, and stores the first one.
template <class Chosen>
[[nodiscard]] Outcome<Finding> count(const Execution& execution, std::size_t n, Chosen&& chosen) {
    return reduce_each(
        execution, n, Finding{},
        [&](Finding& found, std::size_t i) {
            if (!chosen(i)) return;
            if (found.count == 0) found.first = i + 1;
            ++found.count;
        },
        [](const Finding& a, const Finding& b) {
            return a.count == 0 ? b : Finding{a.count + b.count, a.first, a.other};
        });
}

template <int D>
[[nodiscard]] inline std::size_t bucket_of(const Vec<D>& p, std::size_t buckets) {
    std::uint64_t h = 0;
    for (int c = 0; c < D; ++c) {
        h = (h ^ std::bit_cast<std::uint64_t>(p[c] + 0.0)) * 0x9e3779b97f4a7c15U;  // the sum with 0.0 turns −0 into 0
        h ^= h >> 29U;
    }
    return static_cast<std::size_t>(h % buckets);
}

/// For each i in [0, n) with `counts(i)`, returns the first earlier item at the same position for which `meets(i,
/// earlier)` is true, or `no_element`. For each i, a limited number of items is tested, so that the time is linear.
template <class Point, class Counts, class Meets>
[[nodiscard]] Outcome<Buffer<std::uint32_t>> coincident(std::size_t n, Point&& point, Counts&& counts, Meets&& meets,
                                                        const Execution& execution) {
    constexpr int max_requested = 32;
    auto bucket = map_each(part_of(execution, 0, 0.2), n, [&](std::size_t i) {
        return counts(i) ? static_cast<std::uint32_t>(bucket_of(point(i), n)) : no_element;
    });
    if (!bucket) return fail(bucket.error());
    Buffer<std::uint32_t> offsets(n + 1);
    std::fill(offsets.begin(), offsets.end(), 0U);
    for (const std::uint32_t b : *bucket)
        if (b != no_element) ++offsets[b + 1];
    std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
    Buffer<std::uint32_t> items(offsets.back());
    Buffer<std::uint32_t> cursor(offsets.begin(), offsets.end());
    for (std::size_t i = 0; i < n; ++i)
        if ((*bucket)[i] != no_element) items[cursor[(*bucket)[i]]++] = static_cast<std::uint32_t>(i);
    return map_each(part_of(execution, 0.5, 1), n, [&](std::size_t i) {
        const std::uint32_t b = (*bucket)[i];
        if (b == no_element) return no_element;
        const auto p = point(i);
        int requested = 0;
        for (std::size_t k = offsets[b]; k < offsets[b + 1] && items[k] < i && requested < max_requested; ++k) {
            if (point(items[k]).c != p.c) continue;
            if (meets(i, items[k])) return items[k];
            ++requested;
        }
        return no_element;
    });
}

template <int D>
[[nodiscard]] Outcome<Done> examine_faces(const LinearMesh<D>& mesh, Examination<D>& examination,
                                          const Execution& execution);

/// Finds reversed, tangled and flat elements. `volumes`: signed volumes with exact signs; 0 if flat up to rounding.
template <int D>
[[nodiscard]] Outcome<Done> examine_orientation(const LinearMesh<D>& mesh, const Buffer<double>& volumes,
                                                Examination<D>& examination, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Done> examine_scale(const LinearMesh<D>& mesh, Examination<D>& examination,
                                          const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Done> examine_vertices(const LinearMesh<D>& mesh, Examination<D>& examination,
                                             const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Done> examine_boundary(const LinearMesh<D>& mesh, Examination<D>& examination,
                                             const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Done> examine_walls(const LinearMesh<D>& mesh, const ExamineOptions& options,
                                          Examination<D>& examination, const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Done> examine_nodes(const QuadraticMesh<D>& mesh, Examination<D>& examination,
                                          const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Examination<D>> examine_all(const Mesh<D>& mesh, const Execution& execution,
                                                  const ExamineOptions& options = {});

}  // namespace camber
