module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>
export module camber.soundness:defects;
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
/// looked at as a surface. Elements and facets that repeat earlier ones count once: nothing else is said of them.
/// Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Soundness> examine(const LinearMesh<D>& mesh, const ExamineOptions& options,
                                         const Execution& execution);

/// The same of a quadratic mesh: an element is reversed if its curved volume is negative. That it is valid is not
/// asked here (`validate`). Nodes are numbered vertices first, then by edges.
template <int D>
[[nodiscard]] Outcome<Soundness> examine(const QuadraticMesh<D>& mesh, const ExamineOptions& options,
                                         const Execution& execution);

/// With the default options.
template <class Mesh>
[[nodiscard]] Outcome<Soundness> examine(const Mesh& mesh, const Execution& execution) {
    return examine(mesh, ExamineOptions{}, execution);
}

}  // namespace camber
