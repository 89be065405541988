// Checks patches and replaces their cavities in a mesh.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.cavity;
import camber.core;

namespace camber {

namespace {

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

auto refused(std::string what) { return fail(ErrorKind::internal, std::move(what)); }

template <int D>
bool preserves_outer_nodes(const DynamicMesh<D>& mesh, const Patch<D>& patch) {
    const auto& boundary = patch.star.boundary;
    for (const ElementFace& face : patch.star.preserved) {
        const auto& vertices = mesh.elements.vertices[face.element];
        const int point_index = local_vertex(vertices, patch.point.vertex);
        for (int i = 0; i <= D; ++i) {
            if (i == point_index || i == static_cast<int>(face.opposite)) continue;
            const auto at = std::find(boundary.begin(), boundary.end(), vertices[i]) - boundary.begin();
            if (at == std::ssize(boundary)) continue;  // no new element has the edge to this vertex
            if (mesh.nodes[mesh.edges_of[face.element][edge_between<D>[i][point_index]]] != patch.nodes[at])
                return false;
        }
    }
    return true;
}

/// Checks that this patch removes or reshapes all elements of the nodes that it moves around the cavity. Marks reshaped
/// elements as taken.
template <int D>
Outcome<Done> check_following(const DynamicMesh<D>& mesh, const Patch<D>& patch, std::vector<bool>& is_taken) {
    for (const ElementId e : patch.reshaped) {
        if (is_taken[e.index()])
            return fail(ErrorKind::internal, "two patches change the same element", {},
                        Entity{simplex_name<D>, e.index() + 1});
        is_taken[e.index()] = true;
    }
    const auto is_of_patch = [&](ElementId e) {
        return std::ranges::find(patch.reshaped, e) != patch.reshaped.end() ||
               std::ranges::find(patch.removed.elements, e) != patch.removed.elements.end();
    };
    std::vector<ElementId> around;
    for (const auto& following : patch.following) {
        const auto has_edge = [&](ElementId e) {
            return std::ranges::find(mesh.edges_of[e], following.edge) != mesh.edges_of[e].end();
        };
        const auto first = std::ranges::find_if(patch.reshaped, has_edge);
        if (first == patch.reshaped.end()) return refused("a node follows a patch that does not reshape its elements");
        const auto& edges = mesh.edges_of[*first];
        shell(mesh, *first, static_cast<int>(std::ranges::find(edges, following.edge) - edges.begin()), around);
        if (!std::ranges::all_of(around, is_of_patch))
            return refused("a patch moves a node of elements that it neither removes nor reshapes");
    }
    return Done{};
}

/// Errors: those of `replace_cavities`.
template <int D>
Outcome<Done> check_patches(const DynamicMesh<D>& mesh, std::span<const Patch<D>> patches) {
    std::vector<bool> is_removed(mesh.elements.size(), false);
    std::vector<VertexId> vanishing;
    std::vector<std::array<VertexId, 2>> edges;
    std::size_t result = 0;
    constexpr std::size_t max_places = 0x7fffffffU;  // see FaceNeighbour
    for (const Patch<D>& patch : patches) {
        if (patch.planned_for != mesh.stamp) return refused("a patch was planned for another mesh");
        for (const ElementId e : patch.removed.elements) {
            if (is_removed[e.index()])
                return fail(ErrorKind::internal, "two patches remove the same element", {},
                            Entity{simplex_name<D>, e.index() + 1});
            is_removed[e.index()] = true;
        }
        if (auto checked = check_following(mesh, patch, is_removed); !checked) return checked;
        append(vanishing, patch.star.vanishing);
        result += patch.star.joined.size();
        if (patch.point.vertex.valid() && patch.point.place && !patch.star.preserved.empty() &&
            *patch.point.place != mesh.points[patch.point.vertex])
            return refused("a patch moves a vertex of elements outside its cavity");
        if (patch.nodes.size() != (mesh.is_curved() ? patch.star.boundary.size() : 0))
            return refused("a patch must have one node for each edge at its point");
        if (mesh.is_curved() && !preserves_outer_nodes(mesh, patch))
            return refused("a patch moves a node of elements or facets outside its cavity");
        if (const VertexId p = patch.point.vertex;
            p.valid() && !preserves_topology<D>(mesh.elements.vertices.view(), patch))
            for (const VertexId v : patch.star.boundary) edges.push_back({std::min(p, v), std::max(p, v)});
    }
    if (mesh.elements.size() + result >= max_places || mesh.facets.size() + result >= max_places ||
        mesh.edges.size() + 3 * result >= max_entities)
        return fail(ErrorKind::unsupported, "the mesh would have more entities than 32 bits can number");
    std::sort(edges.begin(), edges.end());
    if (std::adjacent_find(edges.begin(), edges.end()) != edges.end())
        return refused("two patches create the same edge");
    std::sort(vanishing.begin(), vanishing.end());
    for (const Patch<D>& patch : patches)
        if (std::binary_search(vanishing.begin(), vanishing.end(), patch.point.vertex))
            return refused("a patch removes the point of another patch");
    return Done{};
}

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
    InputGeometry<D> geometry;
    Column<Group> groups;
    Column<VertexId> at_infinity;
};

/// Assigns slots to new entities of one kind: first removed slots in ascending order, then free slots, then new ones.
/// `release` frees the removed slots that were not reused.
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

template <int D>
struct NewElement {
    SimplexVertices<D> vertices;
    std::array<EdgeId, edges_per_simplex<D>> edges;
    std::array<FaceNeighbour, D + 1> face_neighbours;
    Reference reference = 0, entity = 0;
};
template <int D>
struct NewFacet {
    SimplexVertices<D - 1> vertices;
    Reference reference = 0, entity = 0;
    Marks marks;
};
struct NewLine {
    VertexId end;
    Reference reference = 0, entity = 0;
    Marks marks;
};
/// The neighbour `outside` across an open face of a removed element. `place`: local index of the face (facet: of its
/// side) at which `outside` stores the removed element.
struct Beyond {
    FaceNeighbour outside;
    int place = 0;
};

template <int D>
class PatchCommit {
  public:
    explicit PatchCommit(DynamicMesh<D> mesh) : d_(std::move(mesh)) {}

    void apply(const Patch<D>& patch) {
        for (const auto& [edge, node] : patch.following) d_.nodes[edge.index()] = node;
        append(changes_.elements.removed, patch.reshaped);
        append(changes_.elements.created, patch.reshaped);
        const Star<D>& star = patch.star;
        const VertexId point = put_point(patch);
        if (preserves_topology<D>(d_.elements, patch)) {
            for (const ElementId e : patch.removed.elements) d_.element_marks[e.index()] = {};
            if (!patch.nodes.empty()) {
                find_edges_at(patch, point);
                put_nodes(patch);
            }
            append(changes_.elements.removed, patch.removed.elements);
            append(changes_.elements.created, patch.removed.elements);
            changes_.points.push_back(point);
            return;
        }
        gather(patch, point);
        number_edges(patch, point);
        const std::vector<FacetId> facets = put_facets(patch, point);
        put_elements(patch, facets);
        put_lines(patch);
        for (const VertexId v : star.vanishing) {
            d_.element_of[v.index()] = {};
            d_.states[v.index()] = {};
            d_.free_vertices.push_back(v.value);
        }
        append(changes_.vertices.removed, star.vanishing);
        changes_.points.push_back(point);
    }
    [[nodiscard]] ChangedMesh<D> changed() && { return {std::move(d_).mesh(), std::move(changes_)}; }

  private:
    VertexId put_point(const Patch<D>& patch) {
        const auto& [vertex, place, reference] = patch.point;
        if (vertex.valid()) {
            if (place && *place != d_.points[vertex.index()]) {
                d_.points[vertex.index()] = *place;
                d_.states[vertex.index()].marks |= Mark::moved;
            }
            return vertex;
        }
        VertexId v(d_.points.size());
        if (!d_.free_vertices.empty()) {
            v = VertexId(std::size_t{d_.free_vertices.back()});
            d_.free_vertices.pop_back();
        } else {
            d_.points.push_back({});
            d_.point_references.push_back(0);
            d_.states.push_back({});
            d_.element_of.push_back({});
        }
        d_.points[v.index()] = place.value_or(Vec<D>{});
        d_.point_references[v.index()] = reference;
        d_.states[v.index()] = {patch.star.place, Mark::moved};
        changes_.vertices.created.push_back(v);
        return v;
    }

    void gather(const Patch<D>& patch, VertexId point) {
        const Star<D>& star = patch.star;
        static_cast<void>(find_faces<D>(d_.elements, d_.edges_of, star, patch.point.vertex, names_, faces_));
        elements_.clear();
        beyond_.clear();
        for (const ElementFace& open : star.joined) {
            const std::size_t from = open.element.index();
            const int opposite = static_cast<int>(open.opposite);
            NewElement<D> result{d_.elements[from],
                                 d_.edges_of[from],
                                 {},
                                 d_.element_references[from],
                                 d_.element_entities.empty() ? 0 : d_.element_entities[from]};
            result.vertices[opposite] = point;
            result.face_neighbours[opposite] = d_.face_neighbours[from][opposite];
            elements_.push_back(result);
            beyond_.push_back(beyond(open));
        }
        preserved_beyond_.clear();
        for (const ElementFace& open : star.preserved) preserved_beyond_.push_back(beyond(open));
        lines_.clear();
        for (const auto& [line, opposite] : star.lines) {
            const std::size_t l = line.index();
            lines_.push_back({d_.edges[d_.lines[l].index()][1 - opposite], d_.line_references[l], d_.line_entities[l],
                              d_.line_marks[l]});
        }
    }

    [[nodiscard]] Beyond beyond(const ElementFace& open) const {
        const FaceNeighbour across = d_.face_neighbours[open.element.index()][static_cast<int>(open.opposite)];
        if (!across.valid()) return {};
        if (across.is_facet()) return {across, d_.sides[across.facet().index()][0] == open.element ? 0 : 1};
        const auto& faces = d_.face_neighbours[across.element().index()];
        return {across,
                static_cast<int>(std::find(faces.begin(), faces.end(), FaceNeighbour(open.element)) - faces.begin())};
    }
    void turn_to(const Beyond& there, ElementId element) {
        if (there.outside.is_facet())
            d_.sides[there.outside.facet().index()][there.place] = element;
        else if (there.outside.valid())
            d_.face_neighbours[there.outside.element().index()][there.place] = FaceNeighbour(element);
    }

    void find_edges_at(const Patch<D>& patch, VertexId point) {
        vertices_.clear();
        for (std::uint32_t i = 0; i < patch.star.boundary.size(); ++i) vertices_.put(patch.star.boundary[i], i);
        to_point_.assign(patch.star.boundary.size(), EdgeId{});
        for (const ElementId e : patch.removed.elements) {
            const auto& v = d_.elements[e.index()];
            const int point_index = patch.point.vertex.valid() ? local_vertex(v, point) : -1;
            for (int i = 0; point_index >= 0 && i <= D; ++i)
                if (const std::uint32_t at = i == point_index ? FlatMap<VertexId>::none : vertices_.find(v[i]);
                    at != FlatMap<VertexId>::none)
                    to_point_[at] = d_.edges_of[e.index()][edge_between<D>[i][point_index]];
        }
    }
    void put_nodes(const Patch<D>& patch) {
        for (std::size_t i = 0; i < patch.nodes.size(); ++i) d_.nodes[to_point_[i].index()] = patch.nodes[i];
        if (!patch.nodes.empty()) append(changes_.spokes, to_point_);
    }
    void number_edges(const Patch<D>& patch, VertexId point) {
        const Star<D>& star = patch.star;
        find_edges_at(patch, point);
        std::vector<EdgeId> old = removed_edges(patch);
        append(changes_.edges.removed, old);
        Places places(old, d_.free_edges, [&] {
            d_.edges.push_back({});
            if (D == 3) d_.line_of.push_back({});
            if (!d_.nodes.empty()) d_.nodes.push_back({});
            return EdgeId(d_.edges.size() - 1);
        });
        for (std::size_t i = 0; i < to_point_.size(); ++i) {
            if (to_point_[i].valid()) continue;
            const EdgeId e = to_point_[i] = places.next();
            d_.edges[e.index()] = {std::min(point, star.boundary[i]), std::max(point, star.boundary[i])};
            if (D == 3) d_.line_of[e.index()] = {};
            changes_.edges.created.push_back(e);
        }
        places.release([&](EdgeId e) {
            d_.edges[e.index()] = {};
            if (D == 3) d_.line_of[e.index()] = {};
        });
        put_nodes(patch);
        for (std::size_t j = 0; j < elements_.size(); ++j) {
            const int opposite = static_cast<int>(star.joined[j].opposite);
            for (int i = 0; i <= D; ++i)
                if (i != opposite)
                    elements_[j].edges[edge_between<D>[i][opposite]] =
                        to_point_[vertices_.find(elements_[j].vertices[i])];
        }
    }

    /// Edges of removed elements that no new element has, ascending.
    [[nodiscard]] std::vector<EdgeId> removed_edges(const Patch<D>& patch) {
        stay_.clear();
        for (const ElementFace& open : patch.star.joined)
            for (int k = 0; k < edges_per_simplex<D>; ++k)
                if (const auto [i, j] = local_edges<D>[k];
                    i != static_cast<int>(open.opposite) && j != static_cast<int>(open.opposite))
                    stay_.put(d_.edges_of[open.element.index()][k], 0);
        for (const EdgeId e : to_point_)
            if (e.valid()) stay_.put(e, 0);
        std::vector<EdgeId> old;
        for (const ElementId e : patch.removed.elements)
            for (const EdgeId edge : d_.edges_of[e.index()])
                if (!stay_.contains(edge)) {
                    stay_.put(edge, 0);
                    old.push_back(edge);
                }
        std::sort(old.begin(), old.end());
        return old;
    }

    std::vector<FacetId> put_facets(const Patch<D>& patch, VertexId point) {
        const Star<D>& star = patch.star;
        std::vector<NewFacet<D>> result;
        result.reserve(star.facets.size());
        for (const auto& [facet, opposite] : star.facets) {
            const std::size_t from = facet.index();
            result.push_back({d_.facets[from], d_.facet_references[from],
                              d_.facet_entities.empty() ? 0 : d_.facet_entities[from], d_.facet_marks[from]});
            result.back().vertices[opposite] = point;
        }
        // A new facet is found by its side opposite the point: the new face with the same side has this facet.
        for (StarFace& face : faces_) face.facet = FlatMap<VertexId>::none;
        for (std::uint32_t f = 0; f < star.facets.size(); ++f)
            faces_[names_.find(preserved_side(star.facets[f]))].facet = f;
        std::vector<FacetId> own = rising(patch.removed.facets);
        append(changes_.facets.removed, own);
        Places places(own, d_.free_facets, [&] {
            d_.facets.push_back({});
            d_.facet_references.push_back(0);
            if (!d_.facet_entities.empty()) d_.facet_entities.push_back(0);
            d_.facet_marks.push_back({});
            d_.sides.push_back({});
            return FacetId(d_.facets.size() - 1);
        });
        std::vector<FacetId> ids;
        ids.reserve(result.size());
        for (const NewFacet<D>& facet : result) {
            const FacetId f = places.next();
            d_.facets[f.index()] = facet.vertices;
            d_.facet_references[f.index()] = facet.reference;
            if (!d_.facet_entities.empty()) d_.facet_entities[f.index()] = facet.entity;
            d_.facet_marks[f.index()] = facet.marks;
            d_.sides[f.index()] = {};
            ids.push_back(f);
        }
        append(changes_.facets.created, ids);
        places.release([&](FacetId f) {
            d_.facets[f.index()].fill(VertexId{});
            d_.sides[f.index()] = {};
            d_.facet_marks[f.index()] = {};
        });
        return ids;
    }
    [[nodiscard]] SideId<D> preserved_side(const JoinedFacet& joined) const {
        const auto& facet = d_.facets[joined.facet.index()];
        const int k = static_cast<int>(joined.opposite);
        if constexpr (D == 2) {
            return facet[1 - k];
        } else {
            const std::size_t e = d_.sides[joined.facet.index()][0].index();
            const int a = local_vertex(d_.elements[e], facet[(k + 1) % 3]);
            const int b = local_vertex(d_.elements[e], facet[(k + 2) % 3]);
            return d_.edges_of[e][edge_between<3>[a][b]];
        }
    }

    void put_elements(const Patch<D>& patch, const std::vector<FacetId>& facets) {
        std::vector<ElementId> own = rising(patch.removed.elements);
        append(changes_.elements.removed, own);
        Places places(own, d_.free_elements, [&] {
            d_.elements.push_back({});
            d_.element_references.push_back(0);
            if (!d_.element_entities.empty()) d_.element_entities.push_back(0);
            d_.element_marks.push_back({});
            d_.face_neighbours.push_back({});
            d_.edges_of.push_back({});
            return ElementId(d_.elements.size() - 1);
        });
        ids_.clear();
        for (std::size_t j = 0; j < elements_.size(); ++j) ids_.push_back(places.next());
        places.release([&](ElementId e) {
            d_.elements[e.index()].fill(VertexId{});
            d_.face_neighbours[e.index()] = {};
            d_.edges_of[e.index()] = {};
            d_.element_marks[e.index()] = {};
        });
        append(changes_.elements.created, ids_);
        join_faces(facets);
        for (std::size_t j = 0; j < elements_.size(); ++j) {
            const std::size_t e = ids_[j].index();
            d_.elements[e] = elements_[j].vertices;
            d_.element_references[e] = elements_[j].reference;
            if (!d_.element_entities.empty()) d_.element_entities[e] = elements_[j].entity;
            d_.element_marks[e] = {};
            d_.face_neighbours[e] = elements_[j].face_neighbours;
            d_.edges_of[e] = elements_[j].edges;
            for (const VertexId v : elements_[j].vertices) d_.element_of[v.index()] = ids_[j];
            turn_to(beyond_[j], ids_[j]);
        }
    }
    void join_faces(const std::vector<FacetId>& facets) {
        for (const StarFace& face : faces_) {
            const auto& [first, second] = face.sides;
            if (face.facet != FlatMap<VertexId>::none) {
                const FacetId f = facets[face.facet];
                for (std::uint32_t s = 0; s < face.count; ++s) {
                    elements_[face.sides[s].of].face_neighbours[face.sides[s].local] = FaceNeighbour(f);
                    d_.sides[f.index()][s] = ids_[face.sides[s].of];
                }
            } else if (second.preserved) {  // the first side is never preserved: `find_faces` adds joined faces first
                elements_[first.of].face_neighbours[first.local] = preserved_beyond_[second.of].outside;
                turn_to(preserved_beyond_[second.of], ids_[first.of]);
            } else {
                elements_[first.of].face_neighbours[first.local] = FaceNeighbour(ids_[second.of]);
                elements_[second.of].face_neighbours[second.local] = FaceNeighbour(ids_[first.of]);
            }
        }
    }

    void put_lines(const Patch<D>& patch) {
        if (patch.removed.lines.empty()) return;
        std::vector<LineId> own = rising(patch.removed.lines);
        append(changes_.lines.removed, own);
        for (const LineId l : own)
            if (LineId& at = d_.line_of[d_.lines[l.index()].index()]; at == l) at = {};
        Places places(own, d_.free_lines, [&] {
            d_.lines.push_back({});
            d_.line_references.push_back(0);
            d_.line_entities.push_back(0);
            d_.line_marks.push_back({});
            return LineId(d_.lines.size() - 1);
        });
        for (const NewLine& line : lines_) {
            const LineId l = places.next();
            const EdgeId edge = to_point_[vertices_.find(line.end)];
            d_.lines[l.index()] = edge;
            d_.line_references[l.index()] = line.reference;
            d_.line_entities[l.index()] = line.entity;
            d_.line_marks[l.index()] = line.marks;
            d_.line_of[edge.index()] = l;
            changes_.lines.created.push_back(l);
        }
        places.release([&](LineId l) {
            d_.lines[l.index()] = {};
            d_.line_marks[l.index()] = {};
        });
    }

    Draft<D> d_;
    TopologyChanges changes_;
    FlatMap<SideId<D>> names_;
    FlatMap<VertexId> vertices_;
    FlatMap<EdgeId> stay_;
    std::vector<StarFace> faces_;
    std::vector<NewElement<D>> elements_;
    std::vector<NewLine> lines_;
    std::vector<Beyond> beyond_, preserved_beyond_;
    std::vector<EdgeId> to_point_;
    std::vector<ElementId> ids_;
};

}  // namespace

template <int D>
Outcome<ChangedMesh<D>> replace_cavities(DynamicMesh<D> mesh, std::span<const Patch<D>> patches) {
    return guarded([&]() -> Outcome<ChangedMesh<D>> {
        if (auto checked = check_patches(mesh, patches); !checked) return fail(checked.error());
        if (patches.empty()) return ChangedMesh<D>{std::move(mesh), {}};
        PatchCommit<D> committing(std::move(mesh));
        for (const Patch<D>& patch : patches) committing.apply(patch);
        return std::move(committing).changed();
    });
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<ChangedMesh<D>> replace_cavities<D>(DynamicMesh<D>, std::span<const Patch<D>>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
