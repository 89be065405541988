// Runs all checks. Contains the checks of scale, nodes and vertices.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
#include <range/v3/action/sort.hpp>
#include <range/v3/action/unique.hpp>
module camber.soundness;
import camber.core;
import camber.box_tree;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

template <int D>
Outcome<Examination<D>> examine_with(const LinearMesh<D>& mesh, const Buffer<double>& volumes,
                                     const ExamineOptions& options, const Execution& execution) {
    Examination<D> x;
    x.soundness.dimension = D;
    x.soundness.empty = mesh.elements.vertices.empty() && mesh.facets.vertices.empty();
    const Execution quiet = without_progress(execution);
    auto elements_of = balls(mesh, part_of(execution, 0, 0.13));
    if (!elements_of) return fail(elements_of.error());
    x.elements_of = std::move(*elements_of);
    auto facets_of = facet_balls(mesh, quiet);
    if (!facets_of) return fail(facets_of.error());
    x.facets_of = std::move(*facets_of);
    auto done =
        examine_faces(mesh, x, part_of(execution, 0.13, 0.73))
            .and_then([&](Done) { return examine_orientation(mesh, volumes, x, part_of(execution, 0.73, 0.83)); })
            .and_then([&](Done) { return examine_scale(mesh, x, part_of(execution, 0.83, 0.89)); })
            .and_then([&](Done) { return examine_vertices(mesh, x, part_of(execution, 0.89, 0.94)); })
            .and_then([&](Done) { return examine_boundary(mesh, x, quiet); })
            .and_then([&](Done) { return examine_walls(mesh, options, x, part_of(execution, 0.96, 1)); });
    if (!done) return fail(done.error());
    return x;
}

template <int D>
Outcome<Examination<D>> examine_simplices(const LinearMesh<D>& mesh, const ExamineOptions& options,
                                          const Execution& execution) {
    auto volumes = map_each(part_of(execution, 0, 0.14), mesh.elements.size(), [&](std::size_t e) {
        std::array<Vec<D>, D + 1> p;
        for (int i = 0; i <= D; ++i) p[i] = mesh.points[mesh.elements.vertices[e][i]];
        return signed_volume<D>(p);
    });
    if (!volumes) return fail(volumes.error());
    return examine_with(mesh, *volumes, options, part_of(execution, 0.14, 1));
}
template <int D>
Outcome<Examination<D>> examine_simplices(const QuadraticMesh<D>& mesh, const ExamineOptions& options,
                                          const Execution& execution) {
    auto volumes = map_each(part_of(execution, 0, 0.21), mesh.linear.elements.size(), [&](std::size_t e) {
        return signed_volume(nodal_element<D>(mesh, mesh.mid_nodes.view(), ElementId(e)));
    });
    if (!volumes) return fail(volumes.error());
    auto x = examine_with(mesh.linear, *volumes, options, part_of(execution, 0.21, 0.72));
    if (!x) return x;
    if (auto done = examine_nodes(mesh, *x, part_of(execution, 0.72, 1)); !done) return fail(done.error());
    return x;
}

}  // namespace

template <int D>
Outcome<Examination<D>> examine_all(const Mesh<D>& mesh, const Execution& execution, const ExamineOptions& options) {
    return on_simplices(mesh, [&](const auto& of) { return examine_simplices(of, options, execution); });
}

template <int D>
Outcome<Soundness> examine(const Mesh<D>& mesh, const ExamineOptions& options, const Execution& execution) {
    return guarded([&]() -> Outcome<Soundness> {
        return examine_all(mesh, execution, options).map([](const Examination<D>& x) { return x.soundness; });
    });
}

namespace {

template <int D>
bool is_distant(const Vec<D>& p) {
    return std::any_of(p.c.begin(), p.c.end(), [](double x) { return std::abs(x) > max_length; });
}

/// True if the largest extent of the simplex in a coordinate is below `min_length`, but not 0. Coincident vertices are
/// a different defect.
template <int D, std::size_t N>
bool is_tiny(const Column<Vec<D>>& points, const std::array<VertexId, N>& simplex) {
    double extent = 0;
    for (int c = 0; c < D; ++c) {
        const auto [low, high] = std::minmax_element(
            simplex.begin(), simplex.end(), [&](VertexId a, VertexId b) { return points[a][c] < points[b][c]; });
        extent = std::max(extent, points[*high][c] - points[*low][c]);
    }
    return extent > 0 && extent < min_length;
}

}  // namespace

template <int D>
Outcome<Done> examine_scale(const LinearMesh<D>& mesh, Examination<D>& x, const Execution& execution) {
    const Execution quiet = without_progress(execution);
    auto distant = count(quiet, mesh.points.size(), [&](std::size_t v) { return is_distant(mesh.points[v]); });
    if (!distant) return fail(distant.error());
    auto elements = count(execution, mesh.elements.size(), [&](std::size_t e) {
        return x.element_counts(e) && is_tiny(mesh.points, mesh.elements.vertices[e]);
    });
    if (!elements) return fail(elements.error());
    auto facets = count(quiet, mesh.facets.size(), [&](std::size_t f) {
        return x.facet_counts(f) && is_tiny(mesh.points, mesh.facets.vertices[f]);
    });
    if (!facets) return fail(facets.error());
    x[Defect::distant_vertex] = *distant;
    x[Defect::tiny_element] = *elements;
    x[Defect::tiny_facet] = *facets;
    return Done{};
}

namespace {

/// True if the edges have ends at the same positions: they are on a slit, or have duplicate vertices, which are other
/// defects.
template <int D>
bool same_ends(const QuadraticMesh<D>& mesh, std::size_t e, std::size_t f) {
    const auto& points = mesh.linear.points;
    const auto& [a, b] = mesh.edges.vertices[e];
    const auto& [c, d] = mesh.edges.vertices[f];
    return (points[a] == points[c] && points[b] == points[d]) || (points[a] == points[d] && points[b] == points[c]);
}

}  // namespace

template <int D>
Outcome<Done> examine_nodes(const QuadraticMesh<D>& mesh, Examination<D>& x, const Execution& execution) {
    const std::size_t vertices = mesh.linear.points.size(), n = vertices + mesh.mid_nodes.size();
    auto distant = count(without_progress(execution), mesh.mid_nodes.size(),
                         [&](std::size_t i) { return is_distant(mesh.mid_nodes[i].point); });
    if (!distant) return fail(distant.error());
    if (distant->count > 0) distant->first += vertices;
    x[Defect::distant_node] = *distant;
    const auto point = [&](std::size_t i) -> const Vec<D>& {
        return i < vertices ? mesh.linear.points[i] : mesh.mid_nodes[i - vertices].point;
    };
    const auto used = [&](std::size_t i) {
        return i >= vertices || !x.elements_of[i].empty() || !x.facets_of[i].empty();
    };
    const auto meets = [&](std::size_t i, std::size_t earlier) {
        return i >= vertices && (earlier < vertices || !same_ends(mesh, i - vertices, earlier - vertices));
    };
    auto twin = coincident(n, point, used, meets, execution);
    if (!twin) return fail(twin.error());
    auto found = count(without_progress(execution), n, [&](std::size_t i) { return (*twin)[i] != no_element; });
    if (!found) return fail(found.error());
    if (found->count > 0) found->other = (*twin)[found->first - 1] + std::size_t{1};
    x[Defect::coincident_node] = *found;
    return Done{};
}

namespace {

struct AtBoundary {
    bool any = false, unlisted = false;
};
template <int D>
AtBoundary at_boundary(const LinearMesh<D>& mesh, const Examination<D>& x, std::size_t v) {
    AtBoundary at;
    for (const ElementId e : x.elements_of[v]) {
        if (!x.element_counts(e.index())) continue;
        for (int i = 0; i <= D; ++i) {
            if (mesh.elements.vertices[e][i].index() == v || x.neighbours[e.index()][i] != no_element) continue;
            at.any = true;
            at.unlisted = at.unlisted || ((x.unlisted[e.index()] >> static_cast<unsigned>(i)) & 1U) != 0;
        }
    }
    return at;
}

/// True if vertices at the same position are on two sides of a slit: all their boundary faces are listed, and no entity
/// contains both vertices.
template <int D>
bool is_slit(const LinearMesh<D>& mesh, const Examination<D>& x, std::size_t v, std::size_t twin) {
    for (const ElementId e : x.elements_of[v])
        if (has(mesh.elements.vertices[e], VertexId(twin))) return false;
    for (const FacetId f : x.facets_of[v])
        if (has(mesh.facets.vertices[f], VertexId(twin))) return false;
    const AtBoundary here = at_boundary(mesh, x, v), there = at_boundary(mesh, x, twin);
    return here.any && there.any && !here.unlisted && !there.unlisted;
}

/// True if p is on the simplex `s`, but not at a corner. `slack`: tolerance.
bool is_inside(const Vec<2>& p, const std::array<Vec<2>, 2>& s, double slack) {
    const Vec<2> edge = s[1] - s[0], to = p - s[0];
    const double length = norm(edge), along = dot(to, edge) / length;
    return along > slack && along < length - slack && norm(to - along / length * edge) <= slack;
}
bool is_inside(const Vec<3>& p, const std::array<Vec<3>, 3>& s, double slack) {
    const Vec<3> normal = cross(s[1] - s[0], s[2] - s[0]);
    const double area = norm(normal);
    if (!(area > 0) || std::abs(dot(p - s[0], normal)) > slack * area) return false;
    for (int i = 0; i < 3; ++i) {
        const Vec<3>&a = s[i], &b = s[(i + 1) % 3];
        if (distance(p, a) <= slack) return false;
        if (dot(cross(b - a, p - a), normal) < -slack * area * distance(a, b)) return false;
    }
    return true;
}

template <int D>
struct OpenFace {
    SimplexVertices<D - 1> vertices;
    std::size_t element = 0;
    double slack = 0;  ///< tolerance for contact, far below the width of any intended gap
};

/// True if p is inside the face within the face's tolerance. Coordinates are scaled by a power of two so that the
/// tolerance is about 1, which avoids overflow without rounding.
template <int D>
bool is_inside(const LinearMesh<D>& mesh, const Vec<D>& p, const OpenFace<D>& face) {
    if (!(face.slack > 0)) return false;
    const int exponent = -std::ilogb(face.slack);
    const auto scaled = [&](Vec<D> x) {
        for (double& c : x.c) c = std::ldexp(c, exponent);
        return x;
    };
    std::array<Vec<D>, D> corners;
    for (int c = 0; c < D; ++c) corners[c] = scaled(mesh.points[face.vertices[c]]);
    return is_inside(scaled(p), corners, std::ldexp(face.slack, exponent));
}

template <int D>
std::vector<OpenFace<D>> open_faces(const LinearMesh<D>& mesh, const Examination<D>& x) {
    std::vector<OpenFace<D>> faces;
    for (std::size_t e = 0; e < x.unlisted.size(); ++e)
        for (int i = 0; i <= D; ++i) {
            if (((x.unlisted[e] >> static_cast<unsigned>(i)) & 1U) == 0) continue;
            Box<D> box;
            const auto face = face_of<D>(mesh.elements.vertices[e], i);
            double largest = 0;
            for (const VertexId v : face) {
                box.include(mesh.points[v]);
                for (int c = 0; c < D; ++c) largest = std::max(largest, std::abs(mesh.points[v][c]));
            }
            faces.push_back({face, e, 1e-10 * box.diagonal() + 1e-15 * largest});
        }
    return faces;
}

/// Finds vertices of unlisted boundary faces that lie inside other unlisted boundary faces. The mesh is not conforming
/// there.
template <int D>
Outcome<Finding> find_hanging(const LinearMesh<D>& mesh, const Examination<D>& x, const Execution& execution) {
    const std::vector<OpenFace<D>> faces = open_faces(mesh, x);
    std::vector<VertexId> vertices;
    vertices.reserve(D * faces.size());
    std::vector<Box<D>> boxes(faces.size());
    for (std::size_t f = 0; f < faces.size(); ++f) {
        for (const VertexId v : faces[f].vertices) {
            vertices.push_back(v);
            boxes[f].include(mesh.points[v]);
        }
        for (int c = 0; c < D; ++c) {
            boxes[f].low[c] -= faces[f].slack;
            boxes[f].high[c] += faces[f].slack;
        }
    }
    vertices |= ranges::actions::sort | ranges::actions::unique;
    const BoxTree<D> tree{std::span<const Box<D>>(boxes)};
    auto on = map_each(execution, vertices.size(), [&](std::size_t i) {
        const Vec<D> p = mesh.points[vertices[i]];
        std::uint32_t element = no_element;
        tree.containing(p, [&](std::size_t f) {
            if (!has(faces[f].vertices, vertices[i]) && is_inside(mesh, p, faces[f]))
                element = std::min(element, static_cast<std::uint32_t>(faces[f].element));
        });
        return element;
    });
    if (!on) return fail(on.error());
    auto found = count(execution, on->size(), [&](std::size_t i) { return (*on)[i] != no_element; });
    if (!found || found->count == 0) return found;
    return Finding{found->count, vertices[found->first - 1].index() + 1, (*on)[found->first - 1] + std::size_t{1}};
}

}  // namespace

template <int D>
Outcome<Done> examine_vertices(const LinearMesh<D>& mesh, Examination<D>& x, const Execution& execution) {
    const std::size_t n = mesh.points.size();
    const Execution quiet = without_progress(execution);
    const auto used = [&](std::size_t v) { return !x.elements_of[v].empty() || !x.facets_of[v].empty(); };
    Buffer<std::uint8_t> on_edge(n);
    std::fill(on_edge.begin(), on_edge.end(), std::uint8_t{0});
    for (const auto& edge : mesh.edges.vertices)
        for (const VertexId v : edge) on_edge[v.index()] = 1;
    auto unused = count(quiet, n, [&](std::size_t v) { return !used(v) && on_edge[v] == 0; });
    if (!unused) return fail(unused.error());
    x[Defect::unused_vertex] = *unused;

    auto isolated = count(quiet, mesh.edges.size(), [&](std::size_t i) {
        const auto& edge = mesh.edges.vertices[i];
        for (const ElementId e : x.elements_of[least_connected(edge, x.elements_of)])
            if (has_all(mesh.elements.vertices[e], edge)) return false;
        for (const FacetId f : x.facets_of[least_connected(edge, x.facets_of)])
            if (has_all(mesh.facets.vertices[f], edge)) return false;
        return true;
    });
    if (!isolated) return fail(isolated.error());
    x[Defect::isolated_edge] = *isolated;

    auto twin = coincident(
        n, [&](std::size_t v) -> const Vec<D>& { return mesh.points[v]; }, used,
        [](std::size_t, std::size_t) { return true; }, execution);
    if (!twin) return fail(twin.error());
    for (const bool slit : {true, false}) {
        auto found = count(quiet, n, [&](std::size_t v) {
            return (*twin)[v] != no_element && is_slit(mesh, x, v, (*twin)[v]) == slit;
        });
        if (!found) return fail(found.error());
        if (found->count > 0) found->other = (*twin)[found->first - 1] + std::size_t{1};
        x[slit ? Defect::slit_vertex : Defect::duplicate_vertex] = *found;
    }
    auto hanging = find_hanging(mesh, x, quiet);
    if (!hanging) return fail(hanging.error());
    x[Defect::hanging_vertex] = *hanging;
    return Done{};
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template Outcome<Examination<D>> examine_all<D>(const Mesh<D>&, const Execution&, const ExamineOptions&); \
    template Outcome<Soundness> examine<D>(const Mesh<D>&, const ExamineOptions&, const Execution&);          \
    template Outcome<Done> examine_scale<D>(const LinearMesh<D>&, Examination<D>&, const Execution&);         \
    template Outcome<Done> examine_nodes<D>(const QuadraticMesh<D>&, Examination<D>&, const Execution&);      \
    template Outcome<Done> examine_vertices<D>(const LinearMesh<D>&, Examination<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
