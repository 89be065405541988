// Checks of faces, facets, the orientation of elements, and smooth walls.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.soundness;
import camber.core;
import camber.validity;

namespace camber {

namespace {

/// Boundary faces of the elements; without elements, the facets.
template <int D>
Column<SimplexVertices<D - 1>> boundary_of(const LinearMesh<D>& mesh, const Examination<D>& x) {
    Buffer<SimplexVertices<D - 1>> faces;
    faces.reserve(mesh.facets.size());
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        if (!x.element_counts(e)) continue;
        for (int i = 0; i <= D; ++i)
            if (x.neighbours[e][i] == no_element) faces.push_back(face_of<D>(mesh.elements.vertices[e], i));
    }
    if (mesh.elements.vertices.empty())
        for (std::size_t f = 0; f < mesh.facets.size(); ++f)
            if (x.facet_counts(f)) faces.push_back(mesh.facets.vertices[f]);
    return faces;
}

/// Number of defective edges from a vertex to vertices with higher numbers. `first_end`: the other end of the first
/// such edge.
struct DefectiveEdges {
    std::uint32_t count = 0;
    VertexId first_end;

    void add(VertexId end) {
        if (count++ == 0) first_end = end;
    }
};

/// Defects at a vertex. `crowded`: edges with more than two boundary faces; `open`: edges with only one. `pinched`: the
/// boundary faces at the vertex form several fans, and no edge is crowded.
struct Link {
    DefectiveEdges crowded, open;
    bool pinched = false;
};

Link link_of(const Column<SimplexVertices<1>>&, std::span<const FacetId> around, VertexId v) {
    Link link;
    link.pinched = around.size() > 2;
    if (around.size() == 1) link.open.add(v);
    return link;
}

/// 3D: the sides opposite the vertex, one of each face, must form one path or ring.
Link link_of(const Column<SimplexVertices<2>>& faces, std::span<const FacetId> around, VertexId v) {
    std::vector<std::array<VertexId, 2>> sides;
    std::vector<VertexId> ends;
    sides.reserve(around.size());
    ends.reserve(2 * around.size());
    for (const FacetId f : around) {
        std::array<VertexId, 2> side;
        int n = 0;
        for (const VertexId w : faces[f])
            if (w != v && n < 2) ends.push_back(side[static_cast<std::size_t>(n++)] = w);
        sides.push_back(side);
    }
    std::sort(ends.begin(), ends.end());
    Link link;
    bool any_crowded = false;
    for (auto run = ends.begin(); run != ends.end();) {
        const auto next = std::upper_bound(run, ends.end(), *run);
        if (next - run > 2) {
            any_crowded = true;
            if (*run > v) link.crowded.add(*run);
        }
        if (next - run == 1 && *run > v) link.open.add(*run);
        run = next;
    }
    if (any_crowded || around.empty()) return link;
    // Each end belongs to at most two sides, so this walk reaches a whole path or ring from its first side.
    std::vector<std::size_t> reached{0};
    std::vector<bool> visited(sides.size(), false);
    visited[0] = true;
    for (std::size_t at = 0; at < reached.size(); ++at)
        for (std::size_t s = 0; s < sides.size(); ++s)
            if (!visited[s] && (has(sides[reached[at]], sides[s][0]) || has(sides[reached[at]], sides[s][1]))) {
                visited[s] = true;
                reached.push_back(s);
            }
    link.pinched = reached.size() < sides.size();
    return link;
}

Finding edges_to_blame(const Buffer<Link>& links, DefectiveEdges Link::* member) {
    Finding found;
    for (std::size_t v = 0; v < links.size(); ++v) {
        const DefectiveEdges& blamed = links[v].*member;
        if (blamed.count == 0) continue;
        if (found.count == 0) found = {0, v + 1, blamed.first_end.index() + 1};
        found.count += blamed.count;
    }
    return found;
}

}  // namespace

template <int D>
Outcome<Done> examine_boundary(const LinearMesh<D>& mesh, Examination<D>& x, const Execution& execution) {
    LinearMesh<D> surface;
    surface.points = mesh.points;
    surface.facets.vertices = boundary_of(mesh, x);
    auto around = facet_balls(surface, execution);
    if (!around) return fail(around.error());
    auto links = map_each(execution, mesh.points.size(),
                          [&](std::size_t v) { return link_of(surface.facets.vertices, (*around)[v], VertexId(v)); });
    if (!links) return fail(links.error());
    auto pinched = count(execution, links->size(), [&](std::size_t v) { return (*links)[v].pinched; });
    if (!pinched) return fail(pinched.error());
    x[Defect::pinched_vertex] = *pinched;
    x[Defect::crowded_edge] = edges_to_blame(*links, &Link::crowded);
    x[Defect::open_edge] = edges_to_blame(*links, &Link::open);
    return Done{};
}

namespace {

template <class Id, std::size_t N>
Outcome<Buffer<std::uint32_t>> twins(const Column<std::array<VertexId, N>>& simplices, const Incidence<Id>& around,
                                     const Execution& execution) {
    return map_each(execution, simplices.size(), [&](std::size_t i) {
        for (const Id other : around[least_connected(simplices[i], around)]) {
            if (other.index() >= i) break;
            if (has_all(simplices[other], simplices[i])) return other.value;
        }
        return no_element;
    });
}

template <int D>
Outcome<Buffer<std::array<std::uint32_t, D + 1>>> across(const LinearMesh<D>& mesh, const Examination<D>& x,
                                                         const Execution& execution) {
    auto links = map_each(part_of(execution, 0, 0.26), mesh.elements.size(), [](std::size_t) {
        std::array<std::uint32_t, D + 1> none{};
        none.fill(no_element);
        return none;
    });
    if (!links) return links;
    auto done = each_face(mesh, x.elements_of, part_of(execution, 0.26, 1), [&](std::span<const FaceAround<D>> on) {
        for (const auto& [others, face] : on) {
            std::uint32_t& link = (*links)[face.element.index()][face.opposite];
            for (const FaceAround<D>& other : on) {
                const ElementId beside = other.face.element;
                if (beside == face.element || !x.element_counts(beside.index())) continue;
                link = link == no_element ? beside.value : several;
            }
        }
    });
    if (!done) return fail(done.error());
    return links;
}

template <int D>
bool is_listed(const LinearMesh<D>& mesh, const Examination<D>& x, const SimplexVertices<D - 1>& face) {
    const auto around = x.facets_of[least_connected(face, x.facets_of)];
    return std::any_of(around.begin(), around.end(), [&](FacetId f) { return has_all(mesh.facets.vertices[f], face); });
}

template <int D, class Predicate>
std::uint8_t unlisted_faces(const LinearMesh<D>& mesh, const Examination<D>& x, std::size_t e, Predicate&& predicate) {
    std::uint8_t bits = 0;
    for (int i = 0; i <= D; ++i)
        if (predicate(x.neighbours[e][i]) && !is_listed(mesh, x, face_of<D>(mesh.elements.vertices[e], i)))
            bits = static_cast<std::uint8_t>(bits | (1U << i));
    return bits;
}

template <int D>
std::array<std::uint32_t, 2> elements_beside(const LinearMesh<D>& mesh, const Examination<D>& x, std::size_t f) {
    std::array<std::uint32_t, 2> sides{no_element, no_element};
    const auto& facet = mesh.facets.vertices[f];
    for (const ElementId e : x.elements_of[least_connected(facet, x.elements_of)]) {
        if (!x.element_counts(e.index()) || !has_all(mesh.elements.vertices[e], facet)) continue;
        if (sides[0] == no_element)
            sides[0] = e.value;
        else if (sides[1] == no_element)
            sides[1] = e.value;
    }
    return sides;
}

template <int K>
Outcome<std::array<Finding, 2>> repeats(const Simplices<K>& simplices, const Buffer<std::uint32_t>& twin,
                                        const Execution& execution) {
    std::array<Finding, 2> found;
    for (const bool same : {true, false}) {
        auto counted = count(execution, simplices.size(), [&](std::size_t i) {
            return twin[i] != no_element && (simplices.references[i] == simplices.references[twin[i]]) == same;
        });
        if (!counted) return fail(counted.error());
        if (counted->count > 0) counted->other = twin[counted->first - 1] + std::size_t{1};
        found[same ? 0 : 1] = *counted;
    }
    return found;
}

template <int D>
Outcome<Done> count_faces(const LinearMesh<D>& mesh, Examination<D>& x, const Execution& execution) {
    const auto enter = [&](Defect defect, std::size_t n, auto&& chosen) -> Outcome<Done> {
        auto found = count(execution, n, chosen);
        if (!found) return fail(found.error());
        x[defect] = *found;
        return Done{};
    };
    const std::size_t elements = mesh.elements.size(), facets = elements == 0 ? 0 : mesh.facets.size();
    const bool any_listed = !mesh.facets.vertices.empty();
    return enter(Defect::crowded_face, elements,
                 [&](std::size_t e) {
                     const auto& of = x.neighbours[e];
                     return x.element_counts(e) && std::find(of.begin(), of.end(), several) != of.end();
                 })
        .and_then([&](Done) {
            return enter(any_listed ? Defect::missing_facet : Defect::no_facets, elements,
                         [&](std::size_t e) { return x.unlisted[e] != 0; });
        })
        .and_then([&](Done) {
            return enter(Defect::missing_interface, elements, [&](std::size_t e) { return x.interfaces[e] != 0; });
        })
        .and_then([&](Done) {
            return enter(Defect::isolated_facet, facets,
                         [&](std::size_t f) { return x.facet_counts(f) && x.sides[f][0] == no_element; });
        })
        .and_then([&](Done) {
            return enter(Defect::inner_facet, facets, [&](std::size_t f) {
                const auto& [a, b] = x.sides[f];
                return x.facet_counts(f) && b != no_element &&
                       mesh.elements.references[a] == mesh.elements.references[b];
            });
        });
}

}  // namespace

template <int D>
Outcome<Done> examine_faces(const LinearMesh<D>& mesh, Examination<D>& x, const Execution& execution) {
    const std::size_t n = mesh.elements.size();
    const Execution quiet = without_progress(execution);
    auto element_twins = twins(mesh.elements.vertices, x.elements_of, part_of(execution, 0, 0.25));
    if (!element_twins) return fail(element_twins.error());
    x.element_twins = std::move(*element_twins);
    auto facet_twins = twins(mesh.facets.vertices, x.facets_of, quiet);
    if (!facet_twins) return fail(facet_twins.error());
    x.facet_twins = std::move(*facet_twins);

    auto neighbours = across(mesh, x, part_of(execution, 0.25, 0.91));
    if (!neighbours) return fail(neighbours.error());
    x.neighbours = std::move(*neighbours);
    auto sides = map_each(quiet, mesh.facets.size(), [&](std::size_t f) { return elements_beside(mesh, x, f); });
    if (!sides) return fail(sides.error());
    x.sides = std::move(*sides);
    auto unlisted = map_each(part_of(execution, 0.91, 0.95), n, [&](std::size_t e) {
        if (!x.element_counts(e)) return std::uint8_t{0};
        return unlisted_faces(mesh, x, e, [](std::uint32_t other) { return other == no_element; });
    });
    if (!unlisted) return fail(unlisted.error());
    x.unlisted = std::move(*unlisted);
    auto interfaces = map_each(part_of(execution, 0.95, 1), n, [&](std::size_t e) {
        if (!x.element_counts(e)) return std::uint8_t{0};
        return unlisted_faces(mesh, x, e, [&](std::uint32_t other) {
            return other < several && other > e && mesh.elements.references[other] != mesh.elements.references[e];
        });
    });
    if (!interfaces) return fail(interfaces.error());
    x.interfaces = std::move(*interfaces);

    auto elements = repeats(mesh.elements, x.element_twins, quiet);
    if (!elements) return fail(elements.error());
    auto facets = repeats(mesh.facets, x.facet_twins, quiet);
    if (!facets) return fail(facets.error());
    x[Defect::repeated_element] = (*elements)[0];
    x[Defect::contradicting_element] = (*elements)[1];
    x[Defect::repeated_facet] = (*facets)[0];
    x[Defect::contradicting_facet] = (*facets)[1];
    return count_faces(mesh, x, quiet);
}

namespace {

template <int D>
bool is_consistently_oriented(const SimplexVertices<D>& element, int opposite, const SimplexVertices<D>& other) {
    const auto own_face = face_of<D>(element, opposite);
    int there = 0;
    while (has(own_face, other[there])) ++there;
    const auto other_face = face_of<D>(other, there);
    int inversions = 0;
    std::array<int, D> at{};
    for (int i = 0; i < D; ++i)
        at[i] = static_cast<int>(std::find(other_face.begin(), other_face.end(), own_face[i]) - other_face.begin());
    for (int i = 0; i < D; ++i)
        for (int j = 0; j < i; ++j) inversions += at[j] > at[i];
    return inversions % 2 == 1;
}

/// Determines the elements to reverse so that each connected piece is oriented consistently and has positive total
/// volume; returns 1 for these. Such an orientation exists, because elements of dimension D in D dimensions form no
/// Möbius strips.
template <int D>
Buffer<std::uint8_t> turns(const LinearMesh<D>& mesh, const Buffer<double>& volumes, const Examination<D>& x) {
    constexpr std::uint8_t unvisited = 2;
    Buffer<std::uint8_t> turned(volumes.size());
    std::fill(turned.begin(), turned.end(), unvisited);
    std::vector<std::uint32_t> piece;
    for (std::size_t seed = 0; seed < volumes.size(); ++seed) {
        if (turned[seed] != unvisited) continue;
        turned[seed] = 0;
        piece.assign(1, static_cast<std::uint32_t>(seed));
        double volume = 0;
        for (std::size_t next = 0; next < piece.size(); ++next) {
            const std::size_t e = piece[next];
            volume += turned[e] == 1 ? -volumes[e] : volumes[e];
            if (!x.element_counts(e)) continue;
            for (int i = 0; i <= D; ++i) {
                const std::uint32_t other = x.neighbours[e][i];
                if (other >= several || turned[other] != unvisited) continue;
                const bool alike =
                    is_consistently_oriented<D>(mesh.elements.vertices[e], i, mesh.elements.vertices[other]);
                turned[other] = static_cast<std::uint8_t>(alike ? turned[e] : 1 - turned[e]);
                piece.push_back(other);
            }
        }
        if (volume < 0)
            for (const std::uint32_t e : piece) turned[e] = static_cast<std::uint8_t>(1 - turned[e]);
    }
    return turned;
}

template <int D>
bool is_candidate(const LinearMesh<D>& mesh, const Buffer<double>& volumes, const Examination<D>& x, std::size_t e) {
    if (!x.element_counts(e)) return false;
    if (volumes[e] < 0) return true;
    for (int i = 0; i <= D; ++i) {
        const std::uint32_t other = x.neighbours[e][i];
        if (other < several &&
            !is_consistently_oriented<D>(mesh.elements.vertices[e], i, mesh.elements.vertices[other]))
            return true;
    }
    return false;
}

}  // namespace

template <int D>
Outcome<Done> examine_orientation(const LinearMesh<D>& mesh, const Buffer<double>& volumes, Examination<D>& x,
                                  const Execution& execution) {
    const std::size_t n = volumes.size();
    auto candidates = count(execution, n, [&](std::size_t e) { return is_candidate(mesh, volumes, x, e); });
    if (!candidates) return fail(candidates.error());
    if (candidates->count > 0) {
        x.turned = turns(mesh, volumes, x);
    } else {
        x.turned.resize(n);
        std::fill(x.turned.begin(), x.turned.end(), std::uint8_t{0});
    }
    const auto is_tangled = [&](std::size_t e) { return x.turned[e] == 1 ? volumes[e] > 0 : volumes[e] < 0; };
    const Execution quiet = without_progress(execution);
    auto reversed =
        count(quiet, n, [&](std::size_t e) { return x.element_counts(e) && x.turned[e] == 1 && !is_tangled(e); });
    if (!reversed) return fail(reversed.error());
    auto tangled = count(quiet, n, [&](std::size_t e) { return x.element_counts(e) && is_tangled(e); });
    if (!tangled) return fail(tangled.error());
    auto flat = count(quiet, n, [&](std::size_t e) { return x.element_counts(e) && volumes[e] == 0; });
    if (!flat) return fail(flat.error());
    x[Defect::reversed_element] = *reversed;
    x[Defect::tangled_element] = *tangled;
    x[Defect::flat_element] = *flat;
    return Done{};
}

namespace {

/// Intersection of two faces of an element: the ends of an edge, or in 2D a vertex and an invalid id.
using Hinge = std::array<VertexId, 2>;

template <int D>
Hinge hinge_between(const SimplexVertices<D>& element, int i, int j) {
    Hinge hinge;
    std::size_t n = 0;
    for (int k = 0; k <= D; ++k)
        if (k != i && k != j) hinge[n++] = element[k];
    return hinge;
}

/// Returns the sorted list of listed ridges, each with its lower vertex first. In 2D: listed corners, and ends of
/// listed ridges. Other listed edges are smooth.
template <int D>
std::vector<Hinge> listed_features(const LinearMesh<D>& mesh) {
    std::vector<Hinge> features;
    features.reserve(mesh.corners.size() + 2 * mesh.ridges.size());
    if constexpr (D == 3) {
        for (const std::uint32_t ridge : mesh.ridges) {
            const auto& [a, b] = mesh.edges.vertices[ridge];
            features.push_back({std::min(a, b), std::max(a, b)});
        }
    } else {
        for (const VertexId v : mesh.corners) features.push_back({v, {}});
        for (const std::uint32_t f : mesh.ridges)
            for (const VertexId v : mesh.facets.vertices[f]) features.push_back({v, {}});
    }
    std::sort(features.begin(), features.end());
    return features;
}

Vec<2> normal_of(const Column<Vec<2>>& points, const SimplexVertices<1>& face) {
    const Vec<2> along = points[face[1]] - points[face[0]];
    return {{along[1], -along[0]}};
}
Vec<3> normal_of(const Column<Vec<3>>& points, const SimplexVertices<2>& face) {
    return cross(points[face[1]] - points[face[0]], points[face[2]] - points[face[0]]);
}

template <int D>
bool turns_less(const Vec<D>& a, const Vec<D>& b, double cosine) {
    const double size = norm(a) * norm(b);
    return size > 0 && dot(a, b) > cosine * size;
}

template <int D>
class Walls {
  public:
    Walls(const LinearMesh<D>& mesh, const ExamineOptions& options, const Examination<D>& x)
        : mesh_(mesh),
          x_(x),
          cosine_(cos(options.ridge_angle_degrees * std::numbers::pi / 180)),
          features_(listed_features(mesh)) {}

    /// Hinge of two faces of the element on one smooth wall; empty if there are no such faces.
    [[nodiscard]] std::optional<Hinge> hinge(std::size_t e) const {
        if (!x_.element_counts(e)) return {};
        for (int i = 0; i < D; ++i)
            for (int j = i + 1; j <= D; ++j)
                if (is_one_wall(e, i, j)) return hinge_between<D>(mesh_.elements.vertices[e], i, j);
        return {};
    }

  private:
    [[nodiscard]] bool is_one_wall(std::size_t e, int i, int j) const {
        const std::uint32_t a = x_.neighbours[e][i], b = x_.neighbours[e][j];
        const bool both_outer = a == no_element && b == no_element;
        const auto is_interface = [&](std::uint32_t other) {
            return other < several && mesh_.elements.references[other] != mesh_.elements.references[e];
        };
        if (!both_outer && !(is_interface(a) && is_interface(b))) return false;
        const auto& element = mesh_.elements.vertices[e];
        const auto first = face_of<D>(element, i), second = face_of<D>(element, j);
        if (!turns_less(normal_of(mesh_.points, first), normal_of(mesh_.points, second), cosine_)) return false;
        const Hinge at = hinge_between<D>(element, i, j);
        return reference(first) == reference(second) && !is_feature(at) && facets_at(at) <= 2;
    }

    [[nodiscard]] std::optional<Reference> reference(const SimplexVertices<D - 1>& face) const {
        for (const FacetId f : x_.facets_of[least_connected(face, x_.facets_of)])
            if (has_all(mesh_.facets.vertices[f], face)) return mesh_.facets.references[f];
        return {};
    }

    [[nodiscard]] bool is_feature(Hinge at) const {
        if (D == 3 && at[1] < at[0]) std::swap(at[0], at[1]);
        return std::binary_search(features_.begin(), features_.end(), at);
    }

    /// Number of facets at the hinge. If it exceeds two, the wall ends there.
    [[nodiscard]] std::size_t facets_at(const Hinge& at) const {
        const auto around = x_.facets_of[at[0]];
        return static_cast<std::size_t>(std::count_if(around.begin(), around.end(), [&](FacetId f) {
            return x_.facet_counts(f.index()) && (D == 2 || has(mesh_.facets.vertices[f], at[1]));
        }));
    }

    const LinearMesh<D>& mesh_;
    const Examination<D>& x_;
    double cosine_;
    std::vector<Hinge> features_;
};

}  // namespace

template <int D>
Outcome<Done> examine_walls(const LinearMesh<D>& mesh, const ExamineOptions& options, Examination<D>& x,
                            const Execution& execution) {
    const Walls<D> walls(mesh, options, x);
    auto on_wall = map_each(execution, mesh.elements.size(),
                            [&](std::size_t e) { return static_cast<std::uint8_t>(walls.hinge(e).has_value()); });
    if (!on_wall) return fail(on_wall.error());
    std::vector<WallElement>& found = x.soundness.wall_elements;
    found.clear();
    for (std::size_t e = 0; e < on_wall->size(); ++e)
        if ((*on_wall)[e] == 1) found.push_back({ElementId(e), *walls.hinge(e)});
    if (!found.empty()) x[Defect::wall_element] = {found.size(), found.front().element.index() + 1, 0};
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                                   \
    template Outcome<Done> examine_boundary<D>(const LinearMesh<D>&, Examination<D>&, const Execution&);        \
    template Outcome<Done> examine_faces<D>(const LinearMesh<D>&, Examination<D>&, const Execution&);           \
    template Outcome<Done> examine_orientation<D>(const LinearMesh<D>&, const Buffer<double>&, Examination<D>&, \
                                                  const Execution&);                                            \
    template Outcome<Done> examine_walls<D>(const LinearMesh<D>&, const ExamineOptions&, Examination<D>&,       \
                                            const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
