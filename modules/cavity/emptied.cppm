module;
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
export module camber.cavity:emptied;
import camber.core;
import :mesh;

export namespace camber {

/// What an operation takes out of a mesh (paper §1.3): elements, and of what lies on their faces and edges the facets
/// and lines that are to be replaced with them.
template <int D>
struct Cavity {
    std::vector<ElementId> elements;
    std::vector<FacetId> facets;
    std::vector<LineId> lines;

    void clear() {
        elements.clear();
        facets.clear();
        lines.clear();
    }
    friend bool operator==(const Cavity&, const Cavity&) = default;
};

/// A facet of the cavity, by the local vertex in whose place the point comes; the same of a line.
struct JoinedFacet {
    FacetId facet;
    std::uint32_t opposite = 0;
    friend bool operator==(const JoinedFacet&, const JoinedFacet&) = default;
};
struct JoinedLine {
    LineId line;
    std::uint32_t opposite = 0;
    friend bool operator==(const JoinedLine&, const JoinedLine&) = default;
};

/// What is left open around an emptied cavity, and so is to be joined to the point. The new simplices take reference
/// and orientation from those that they are named by, with the point in the place of the local vertex `opposite`.
template <int D>
struct Star {
    std::vector<ElementFace> joined;          ///< faces of removed elements: each makes an element
    std::vector<ElementFace> kept;            ///< such faces that hold the point already: they make none
    std::vector<JoinedFacet> facets;          ///< (3D: edges of removed facets; 2D: their vertices): each makes a facet
    std::vector<JoinedLine> lines;            ///< ends of removed lines: each makes a line
    std::vector<VertexId> boundary;           ///< the vertices of `joined`, as met there: the point has an edge to each
    std::vector<VertexId> vanishing;          ///< vertices of the cavity that are not on its boundary, rising
    VertexPlace place = VertexPlace::inside;  ///< of the point, by what is joined to it

    void clear() {
        joined.clear();
        kept.clear();
        facets.clear();
        lines.clear();
        boundary.clear();
        vanishing.clear();
        place = VertexPlace::inside;
    }
    friend bool operator==(const Star&, const Star&) = default;
};

/// Why a cavity cannot be joined to a point, whatever their places.
enum class StarFailure : std::uint8_t {
    none,
    empty,     ///< nothing is left open that does not hold the point
    required,  ///< a required, frozen or corner entity would go
    surface,   ///< facets would be lost, doubled, come to lie on no face, or make the point what it is not
    line,      ///< the same of lines
    ball,      ///< what is left open is not a sphere around the point, or a disc beside it
    exists,    ///< an edge or face that the star would make is in the mesh already, outside of the cavity
};

}  // namespace camber
