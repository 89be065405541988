module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>
export module camber.cavity:star;
import camber.core;
import :around;
import :emptied;
import :flat_map;
import :mesh;

namespace camber {

/// What the faces of a star at its point are named by: their sides opposite the point. 3D: edges; 2D: vertices.
template <int D>
struct SideName;
template <>
struct SideName<2> {
    using Id = VertexId;
};
template <>
struct SideName<3> {
    using Id = EdgeId;
};
template <int D>
using SideId = typename SideName<D>::Id;

/// A face of the star at the point: of which joined faces' elements, or kept faces, and the facet on it.
struct StarFace {
    struct Side {
        std::uint32_t of = 0;  ///< index in `joined` or `kept`
        bool kept = false;
        std::uint8_t local = 0;  ///< joined: the local vertex of the new element that is opposite
    };
    std::array<Side, 2> sides{};
    std::uint32_t count = 0;            ///< of sides; more than two is a failure
    std::uint32_t facet = 0xffffffffU;  ///< index in `facets`
};

/// The name of the face of the new element of `joined` that is opposite its local vertex `local`, which holds the
/// point; and that of a kept face, where the point is its local vertex `point`.
template <int D, class Elements, class EdgesOf>
[[nodiscard]] SideId<D> side_without(const Elements& elements, const EdgesOf& edges_of, const ElementFace& face,
                                     int other) {
    if constexpr (D == 2) {
        const int rest = 3 - static_cast<int>(face.opposite) - other;
        return elements[face.element.index()][rest];
    } else {
        std::array<int, 2> rest{};
        int n = 0;
        for (int i = 0; i <= D; ++i)
            if (i != static_cast<int>(face.opposite) && i != other) rest[n++] = i;
        return edges_of[face.element.index()][edge_between<D>[rest[0]][rest[1]]];
    }
}

/// The faces of the new elements at the point, and of the kept ones, by their names; false where one would have more
/// than two sides.
template <int D, class Elements, class EdgesOf>
[[nodiscard]] bool find_faces(const Elements& elements, const EdgesOf& edges_of, const Star<D>& star, VertexId point,
                              FlatMap<SideId<D>>& names, std::vector<StarFace>& faces) {
    names.clear();
    faces.clear();
    const auto add = [&](SideId<D> name, StarFace::Side side) {
        const auto next = static_cast<std::uint32_t>(faces.size());
        const std::uint32_t at = names.put(name, next);
        if (at == next) faces.push_back({});
        StarFace& face = faces[at];
        if (face.count == 2) return false;
        face.sides[face.count++] = side;
        return true;
    };
    for (std::uint32_t j = 0; j < star.joined.size(); ++j)
        for (int i = 0; i <= D; ++i)
            if (i != static_cast<int>(star.joined[j].opposite) &&
                !add(side_without<D>(elements, edges_of, star.joined[j], i), {j, false, static_cast<std::uint8_t>(i)}))
                return false;
    for (std::uint32_t k = 0; k < star.kept.size(); ++k) {
        const int held = local_vertex(elements[star.kept[k].element.index()], point);
        if (!add(side_without<D>(elements, edges_of, star.kept[k], held), {k, true, 0})) return false;
    }
    return true;
}

}  // namespace camber

export namespace camber {

/// Tables that `star` fills anew each time; one for each thread.
template <int D>
class StarWorkspace {
  public:
    FlatMap<ElementId> elements;
    FlatMap<FacetId> facets;
    FlatMap<LineId> lines;
    FlatMap<VertexId> vertices;  ///< of the boundary: index in `at`
    FlatMap<SideId<D>> names;    ///< index in `faces`
    std::vector<StarFace> faces;
    /// What is known of the edge from the point to a vertex of the boundary.
    struct ToPoint {
        bool is_there = false;     ///< in the cavity already
        bool is_line = false;      ///< it has a line, or gets one
        bool lost_facet = false;   ///< of the vertex: one of its facets is removed
        bool keeps_facet = false;  ///< of the vertex: a side of a removed facet that stays open holds it
        std::uint8_t facets = 0;   ///< on the edge, afterwards
        std::uint8_t before = 0;   ///< a line's: on the edge, or on the line that it comes of, before
        Reference reference = 0;   ///< of these
    };
    std::vector<ToPoint> to_point;
    struct OpenSide {
        SideId<D> name;
        Reference reference = 0;
        JoinedFacet facet;
        bool is_line = false;
    };
    std::vector<OpenSide> open_sides;
    std::vector<ElementId> outside;  ///< all elements at the point
    std::vector<LineId> lines_at_point;
    std::vector<std::uint32_t> groups;
};

/// Empties the cavity and joins what is left open to the point: a vertex of the mesh, or an invalid id for one that is
/// not in it. Ridges, then facets, by reference, then elements (paper §1.3), of any number of materials. Says of the
/// topology all that there is to say: whatever the places of the vertices, the result is a mesh again, with the
/// features that it had. `out` means something only where the result is `none`.
template <int D>
[[nodiscard]] StarFailure star(const DynamicMesh<D>& mesh, const Cavity<D>& cavity, VertexId point,
                               StarWorkspace<D>& workspace, Star<D>& out);

}  // namespace camber
