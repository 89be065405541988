module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>
module camber.cavity:draft;
import camber.core;
import :mesh;

/// A mesh while it changes.
namespace camber {

/// The columns of a mesh as buffers, while it changes.
template <int D>
struct Draft {
    explicit Draft(DynamicMesh<D> mesh)
        : points(take(std::move(mesh.points))),
          point_references(take(std::move(mesh.point_references))),
          states(take(std::move(mesh.states))),
          element_of(take(std::move(mesh.element_of))),
          elements(take(std::move(mesh.elements.vertices))),
          element_references(take(std::move(mesh.elements.references))),
          element_entities(take(std::move(mesh.elements.entities))),
          element_marks(take(std::move(mesh.elements.marks))),
          face_neighbours(take(std::move(mesh.face_neighbours))),
          edges_of(take(std::move(mesh.edges_of))),
          edges(take(std::move(mesh.edges))),
          line_of(take(std::move(mesh.line_of))),
          nodes(take(std::move(mesh.nodes))),
          facets(take(std::move(mesh.facets.vertices))),
          facet_references(take(std::move(mesh.facets.references))),
          facet_entities(take(std::move(mesh.facets.entities))),
          facet_marks(take(std::move(mesh.facets.marks))),
          sides(take(std::move(mesh.sides))),
          lines(take(std::move(mesh.lines))),
          line_references(take(std::move(mesh.line_references))),
          line_entities(take(std::move(mesh.line_entities))),
          line_marks(take(std::move(mesh.line_marks))),
          free_vertices(take(std::move(mesh.free.vertices))),
          free_edges(take(std::move(mesh.free.edges))),
          free_lines(take(std::move(mesh.free.lines))),
          free_facets(take(std::move(mesh.free.facets))),
          free_elements(take(std::move(mesh.free.elements))),
          geometry(std::move(mesh.geometry)),
          groups(std::move(mesh.groups)),
          at_infinity(std::move(mesh.at_infinity)) {}

    [[nodiscard]] DynamicMesh<D> mesh() && {
        DynamicMesh<D> out;
        out.points = std::move(points);
        out.point_references = std::move(point_references);
        out.states = std::move(states);
        out.element_of = std::move(element_of);
        out.elements = {std::move(elements), std::move(element_references), std::move(element_entities),
                        std::move(element_marks)};
        out.face_neighbours = std::move(face_neighbours);
        out.edges_of = std::move(edges_of);
        out.edges = std::move(edges);
        out.line_of = std::move(line_of);
        out.nodes = std::move(nodes);
        out.facets = {std::move(facets), std::move(facet_references), std::move(facet_entities),
                      std::move(facet_marks)};
        out.sides = std::move(sides);
        out.lines = std::move(lines);
        out.line_references = std::move(line_references);
        out.line_entities = std::move(line_entities);
        out.line_marks = std::move(line_marks);
        out.free = {std::move(free_vertices), std::move(free_edges), std::move(free_lines), std::move(free_facets),
                    std::move(free_elements)};
        out.geometry = std::move(geometry);
        out.groups = std::move(groups);
        out.at_infinity = std::move(at_infinity);
        out.stamp = new_stamp();
        return out;
    }

    Buffer<Vec<D>> points;
    Buffer<Reference> point_references;
    Buffer<VertexState> states;
    Buffer<ElementId> element_of;
    Buffer<SimplexVertices<D>> elements;
    Buffer<Reference> element_references, element_entities;
    Buffer<Marks> element_marks;
    Buffer<std::array<FaceNeighbour, D + 1>> face_neighbours;
    Buffer<std::array<EdgeId, edges_per_simplex<D>>> edges_of;
    Buffer<std::array<VertexId, 2>> edges;
    Buffer<LineId> line_of;
    Buffer<LagrangeNode<D>> nodes;
    Buffer<SimplexVertices<D - 1>> facets;
    Buffer<Reference> facet_references, facet_entities;
    Buffer<Marks> facet_marks;
    Buffer<FacetSides> sides;
    Buffer<EdgeId> lines;
    Buffer<Reference> line_references, line_entities;
    Buffer<Marks> line_marks;
    Buffer<std::uint32_t> free_vertices, free_edges, free_lines, free_facets, free_elements;
    GivenGeometry<D> geometry;
    Column<Group> groups;
    Column<VertexId> at_infinity;
};

/// Places for new entities of one kind in one patch: those of the removed ones, rising, then free ones, then new ones
/// by `grow`. What is left over of the removed ones becomes free.
template <class Id, class Grow>
class Places {
  public:
    Places(std::vector<Id>& own, Buffer<std::uint32_t>& free, Grow grow) : own_(own), free_(free), grow_(grow) {}
    Id next() {
        if (used_ < own_.size()) return own_[used_++];
        if (free_.empty()) return grow_();
        const Id id(std::size_t{free_.back()});
        free_.pop_back();
        return id;
    }
    template <class Clear>
    void release(Clear clear) {
        for (; used_ < own_.size(); ++used_) {
            clear(own_[used_]);
            free_.push_back(own_[used_].value);
        }
    }

  private:
    std::vector<Id>& own_;
    Buffer<std::uint32_t>& free_;
    Grow grow_;
    std::size_t used_ = 0;
};

template <class Id, class Ids>
void append(std::vector<Id>& to, const Ids& ids) {
    to.insert(to.end(), ids.begin(), ids.end());
}
template <class Id>
std::vector<Id> rising(std::vector<Id> ids) {
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    return ids;
}

}  // namespace camber
