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
/// Whether a straight mesh is fit to work on: what may be wrong with it (`examine`), and what of it can be
/// mended without a doubt (`prepare`).
export module camber.soundness;
import camber.core;
import camber.validity;

export namespace camber {

/// What may be wrong with a straight mesh (or the straight part of a quadratic one), or be worth a word.
enum class Defect : std::uint8_t {
    repeated_element,       ///< has the vertices and the reference of an earlier one
    contradicting_element,  ///< has the vertices of an earlier one and another reference
    crowded_face,           ///< an element with a face that more than two elements have
    stray_facet,            ///< a facet that is a face of no element
    repeated_facet,         ///< as for elements
    contradicting_facet,
    distant_vertex,     ///< has a coordinate beyond `max_length`: products of such overflow
    distant_node,       ///< a mid node of which the same holds (P2)
    tiny_element,       ///< its vertices differ by less than `min_length` in each coordinate: products vanish
    tiny_facet,         ///< as for elements
    hanging_vertex,     ///< lies inside a face of the boundary that the file does not list as such
    duplicate_vertex,   ///< is at the very place of an earlier one, and not on two sides of a slit
    reversed_element,   ///< its vertices are numbered the wrong way round
    tangled_element,    ///< lies on the same side of its faces as most of its neighbours: inverted, or overlapping
    flat_element,       ///< its straight volume is zero to rounding
    missing_facet,      ///< an element whose face on the boundary is not listed, though others are
    no_facets,          ///< an element whose face on the boundary is not listed, as none is
    missing_interface,  ///< an element whose face to an element of another reference is not listed
    unused_vertex,      ///< belongs to no element and no facet
    slit_vertex,        ///< at the place of an earlier one, across a slit: the boundary is listed on both sides
    coincident_node,    ///< a mid node at the very place of a vertex, or of the node of an edge with other ends (P2)
    inner_facet,        ///< lies between two elements of the same reference
    open_edge,          ///< of one boundary face alone, where the boundary is not closed (2D: such a vertex)
    crowded_edge,       ///< of more than two boundary faces (3D)
    pinched_vertex,     ///< where the boundary meets itself: its faces there are not one fan
    lone_edge,          ///< a feature edge of no element and no facet (3D)
    wall_element,       ///< has two faces on one smooth wall: straight it may be good, curved it cannot be
};
/// The number of defects in `Defect`.
inline constexpr std::size_t defect_count = 27;

/// What is to be thought of a defect.
enum class Gravity : std::uint8_t {
    fatal,     ///< not a mesh that Camber could curve, and none that a solver could use
    spoils,    ///< the elements concerned are not valid; the others are not affected
    mended,    ///< `prepare` mends it, and it is wrong as long as it is not mended
    harmless,  ///< `prepare` mends it where it must; no solver stumbles over it
};

/// How many entities have a defect, and the first of them: `kind` as its file calls it, numbers from 1.
struct Finding {
    std::size_t count = 0;
    std::size_t first = 0;  ///< 0: none
    std::size_t other =
        0;  ///< the other party: the earlier twin, the second end of the edge, the element with the face
    friend bool operator==(const Finding&, const Finding&) = default;
};

/// An element with two faces on one smooth wall: where the wall is curved they meet at 180 degrees, so that det J
/// vanishes there wherever the element's nodes are (it needs a swap).
struct WallElement {
    ElementId element;
    std::array<VertexId, 2> hinge;  ///< what its two faces share: an edge; 2D: a vertex, and an invalid id
    friend bool operator==(const WallElement&, const WallElement&) = default;
};

struct ExamineOptions {
    /// Two faces that turn by less than this (degrees) across an edge are one smooth wall, unless their references
    /// differ or the edge is a listed ridge (2D: the vertex is a listed corner, or an end of a listed ridge).
    double ridge_angle_degrees = 40;
};

/// What was found in a mesh, an immutable value.
struct Soundness {
    int dimension = 3;
    bool empty = false;  ///< neither elements nor facets
    std::array<Finding, defect_count> findings{};
    std::vector<WallElement> wall_elements = {};  ///< all of them, by rising element

    [[nodiscard]] const Finding& operator[](Defect defect) const { return findings[static_cast<std::size_t>(defect)]; }
    /// Nothing that a solver would stumble over: not empty, and all that there is is harmless.
    [[nodiscard]] bool sound() const;
    friend bool operator==(const Soundness&, const Soundness&) = default;
};

/// What is to be thought of a defect.
[[nodiscard]] Gravity gravity(Defect defect);
/// "stray_facets": its name in JSON.
[[nodiscard]] const char* key(Defect defect);
/// One sentence without a full stop on a defect that was found: how many, what, the first: "2 triangles are a face of
/// no tetrahedron (the first: triangle 7)".
[[nodiscard]] std::string sentence(const Soundness& soundness, Defect defect);
/// The error that a fatal defect is for whoever needs a mesh; none if there is none.
[[nodiscard]] std::optional<Error> refusal(const Soundness& soundness);

/// Looks for every defect; time and memory are linear in the mesh but for vertices that hang. Vertex ids must be in
/// range and distinct within a simplex, points finite (decoders see to it). Of a mesh without elements the facets are
/// looked at as a surface. Elements and facets that repeat earlier ones count once: nothing else is said of them. An
/// element of degree 2 is reversed if its curved volume is negative; that it is valid is not asked here (`validate`).
/// Nodes are numbered vertices first, then by edges. Errors: unsupported (no simplices of degree 1 or 2), memory,
/// stopped.
template <int D>
[[nodiscard]] Outcome<Soundness> examine(const Mesh<D>& mesh, const ExamineOptions& options,
                                         const Execution& execution);

/// With the default options.
template <int D>
[[nodiscard]] Outcome<Soundness> examine(const Mesh<D>& mesh, const Execution& execution) {
    return examine(mesh, ExamineOptions{}, execution);
}

/// Volume of a straight simplex with its sign, area in 2D.
template <int D>
[[nodiscard]] double signed_measure(const std::array<Vec<D>, D + 1>& p) {
    if constexpr (D == 2)
        return det(p[1] - p[0], p[2] - p[0]) / 2;
    else
        return det(p[1] - p[0], p[2] - p[0], p[3] - p[0]) / 6;
}

/// Mean ratio of a straight simplex with the sign of its volume: 12 (3V)^(2/3) / Σ l², in 2D 4 √3 A / Σ l². 1 for the
/// regular one, 0 for a flat one.
template <int D>
[[nodiscard]] double mean_ratio(const std::array<Vec<D>, D + 1>& corners) {
    double longest = 0;
    for (const auto& [a, b] : local_edges<D>)
        longest =
            std::max(longest, distance(corners[static_cast<std::size_t>(a)], corners[static_cast<std::size_t>(b)]));
    if (!(longest > 0) || !std::isfinite(longest)) return 0;
    // In units of the longest edge, so that nothing overflows.
    std::array<Vec<D>, D + 1> p;
    for (int i = 0; i <= D; ++i) p[i] = (corners[i] - corners[0]) / longest;
    double squares = 0;
    for (const auto& [a, b] : local_edges<D>)
        squares += norm_squared(p[static_cast<std::size_t>(a)] - p[static_cast<std::size_t>(b)]);
    const double measure = signed_measure<D>(p);
    if constexpr (D == 2) return 4 * std::sqrt(3.0) * measure / squares;
    return std::copysign(12 * pow(3 * std::abs(measure), 2.0 / 3) / squares, measure);
}

/// A mesh to work on, and what was done or is worth knowing: sentences without a full stop.
template <int D>
struct Prepared {
    Mesh<D> mesh;
    std::vector<std::string> notices;
};

/// Mends what can be mended without a doubt, and refuses what is no mesh:
/// - elements and facets that repeat earlier ones are dropped;
/// - facets that are a face of no element are dropped, in a mesh that has elements;
/// - reversed elements are turned by swapping their first two vertices. Tangled ones are numbered as their neighbours
///   are, so that their volume is negative and every check sees it; no order of their vertices would make them right;
/// - faces of the boundary, and between elements of different references, that are not listed become facets with fresh
///   references, one for each kind, after those in use by facets and by names of groups of facets.
/// Vertices, and their order, stay, and curved edges keep their nodes. A sound mesh is given back as it is. Errors:
/// input (the fatal defects of `Soundness`, an empty mesh), unsupported (no simplices of degree 1 or 2), memory,
/// stopped.
template <int D>
[[nodiscard]] Outcome<Prepared<D>> prepare(Mesh<D> mesh, const Execution& execution);

}  // namespace camber

namespace camber {

/// Marks in place of an element or a facet.
inline constexpr std::uint32_t nobody = 0xffffffffU;
inline constexpr std::uint32_t several = 0xfffffffeU;

/// What `examine` finds out of each entity, for `prepare` to act on.
template <int D>
struct Examination {
    Soundness soundness;
    Incidence<ElementId> elements_of;  ///< of each vertex
    Incidence<FacetId> facets_of;
    Buffer<std::uint32_t> element_twins;                  ///< the first earlier element of the same vertices, or nobody
    Buffer<std::uint32_t> facet_twins;                    ///< the same of facets
    Buffer<std::array<std::uint32_t, D + 1>> neighbours;  ///< across each face: an element, nobody or several
    Buffer<std::array<std::uint32_t, 2>> sides;           ///< the elements that have the facet as a face
    Buffer<std::uint8_t> unlisted;                        ///< bit i: face i is on the boundary, and no facet
    Buffer<std::uint8_t> interfaces;                      ///< bit i: face i is between references, no facet, and mine
    Buffer<std::uint8_t> turned;                          ///< 1: numbered the wrong way round

    [[nodiscard]] bool element_counts(std::size_t e) const { return element_twins[e] == nobody; }
    [[nodiscard]] bool facet_counts(std::size_t f) const { return facet_twins[f] == nobody; }
    [[nodiscard]] Finding& operator[](Defect defect) { return soundness.findings[static_cast<std::size_t>(defect)]; }
};

/// The vertices of the face opposite local vertex i, its normal outwards if the element is positive.
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

/// Every vertex of `part` is one of `whole`.
template <std::size_t N, std::size_t M>
[[nodiscard]] constexpr bool has_all(const std::array<VertexId, M>& whole, const std::array<VertexId, N>& part) {
    return std::all_of(part.begin(), part.end(), [&](VertexId v) { return has(whole, v); });
}

/// The vertex of the simplex with the fewest items around it.
template <std::size_t N, class Item>
[[nodiscard]] inline VertexId loneliest(const std::array<VertexId, N>& simplex, const Incidence<Item>& around) {
    return *std::min_element(simplex.begin(), simplex.end(),
                             [&](VertexId a, VertexId b) { return around[a].size() < around[b].size(); });
}

/// How many i in [0, n) are chosen, and the first.
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

/// Points by a hash of their coordinates: those at one place share a bucket.
template <int D>
[[nodiscard]] inline std::size_t bucket_of(const Vec<D>& p, std::size_t buckets) {
    std::uint64_t h = 0;
    for (int c = 0; c < D; ++c) {
        h = (h ^ std::bit_cast<std::uint64_t>(p[c] + 0.0)) * 0x9e3779b97f4a7c15U;  // + 0.0: −0 is 0
        h ^= h >> 29U;
    }
    return static_cast<std::size_t>(h % buckets);
}

/// For each i in [0, n) the first earlier one at the same place, point(i), of those that counts(i) says and that
/// meets(i, earlier) accepts; or nobody. Of a crowd at one place only the first few are asked: no more than linear.
template <class Point, class Counts, class Meets>
[[nodiscard]] Outcome<Buffer<std::uint32_t>> coincident(std::size_t n, Point&& point, Counts&& counts, Meets&& meets,
                                                        const Execution& execution) {
    constexpr int max_asked = 32;
    auto bucket = map_each(part_of(execution, 0, 0.2), n, [&](std::size_t i) {
        return counts(i) ? static_cast<std::uint32_t>(bucket_of(point(i), n)) : nobody;
    });
    if (!bucket) return fail(bucket.error());
    Buffer<std::uint32_t> offsets(n + 1);
    std::fill(offsets.begin(), offsets.end(), 0U);
    for (const std::uint32_t b : *bucket)
        if (b != nobody) ++offsets[b + 1];
    std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
    Buffer<std::uint32_t> items(offsets.back());
    Buffer<std::uint32_t> cursor(offsets.begin(), offsets.end());
    for (std::size_t i = 0; i < n; ++i)
        if ((*bucket)[i] != nobody) items[cursor[(*bucket)[i]]++] = static_cast<std::uint32_t>(i);
    return map_each(part_of(execution, 0.5, 1), n, [&](std::size_t i) {
        const std::uint32_t b = (*bucket)[i];
        if (b == nobody) return nobody;
        const auto p = point(i);
        int asked = 0;
        for (std::size_t k = offsets[b]; k < offsets[b + 1] && items[k] < i && asked < max_asked; ++k) {
            if (point(items[k]).c != p.c) continue;
            if (meets(i, items[k])) return items[k];
            ++asked;
        }
        return nobody;
    });
}

/// Twins, neighbours and facets' sides; unlisted faces and interfaces.
template <int D>
[[nodiscard]] Outcome<Done> examine_faces(const LinearMesh<D>& mesh, Examination<D>& examination,
                                          const Execution& execution);

/// Which elements are turned, tangled or flat, by their signed volumes (exact in sign; 0: flat to rounding).
template <int D>
[[nodiscard]] Outcome<Done> examine_orientation(const LinearMesh<D>& mesh, const Buffer<double>& volumes,
                                                Examination<D>& examination, const Execution& execution);

/// What is beyond the range of lengths: vertices, elements, facets.
template <int D>
[[nodiscard]] Outcome<Done> examine_scale(const LinearMesh<D>& mesh, Examination<D>& examination,
                                          const Execution& execution);

/// Unused, coincident and hanging vertices.
template <int D>
[[nodiscard]] Outcome<Done> examine_vertices(const LinearMesh<D>& mesh, Examination<D>& examination,
                                             const Execution& execution);

/// Where the boundary, or a surface alone, meets itself.
template <int D>
[[nodiscard]] Outcome<Done> examine_boundary(const LinearMesh<D>& mesh, Examination<D>& examination,
                                             const Execution& execution);

/// Elements with two faces on one smooth wall.
template <int D>
[[nodiscard]] Outcome<Done> examine_walls(const LinearMesh<D>& mesh, const ExamineOptions& options,
                                          Examination<D>& examination, const Execution& execution);

/// Mid nodes beyond the range of lengths, and those at the place of vertices or of other mid nodes.
template <int D>
[[nodiscard]] Outcome<Done> examine_nodes(const QuadraticMesh<D>& mesh, Examination<D>& examination,
                                          const Execution& execution);

/// All of it.
template <int D>
[[nodiscard]] Outcome<Examination<D>> examine_all(const Mesh<D>& mesh, const Execution& execution,
                                                  const ExamineOptions& options = {});

}  // namespace camber
