// Nodes of boundary edges: on the geometry, moved within planes, on embedded curves.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;
import camber.box_tree;
import camber.bezier;

namespace camber {

template <int D>
Vec<D> node_without_cusp(const GeometryModel<D>& geometry, const EdgeSite<D>& edge) {
    constexpr double right_angle = 0.25;  // distance of node and chord's middle, divided by the chord, at which a
                                          // quadratic edge turns by 90 degrees
    constexpr double forwards = 0.2;      // limit of the node's shift along the chord, divided by the chord; a shift of
                                          // 0.25 makes an end tangent zero
    const Vec<D> node = geometry.middle_of(edge), middle = edge.middle();
    const Vec<D> chord = edge.ends[1] - edge.ends[0];
    const double length = norm(chord), limit = off_limit * length;
    if (!(distance(node, middle) > limit)) return node;
    Vec<D> off;
    for (const Vec<D>& end : edge.ends) off += 0.5 * (end - geometry.on_edge(edge, end).point);
    Vec<D> bow = node - middle;
    if (norm(off) > limit) {
        bow += (1 - limit / norm(off)) * off;
        if (norm(bow) > right_angle * length) bow = (right_angle * length / norm(bow)) * bow;
    }
    const auto slide = [&](const Vec<D>& from_middle) { return dot(from_middle, chord) / length; };
    if (const double along = slide(bow); std::abs(along) > right_angle * length) {
        bow -= ((along - std::copysign(forwards * length, along)) / length) * chord;
        const Vec<D> foot = geometry.on_edge(edge, middle + bow).point - middle;
        if (norm(off) <= limit && std::abs(slide(foot)) <= right_angle * length) bow = foot;
    }
    return bow == node - middle ? node : middle + bow;
}

template <int D>
Outcome<Buffer<LagrangeNode<D>>> boundary_nodes(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                const Geometry<D>& geometry, const Execution& execution) {
    if (features.edge_kinds.size() != mesh.edges.size() || mesh.mid_nodes.size() != mesh.edges.size())
        return fail(ErrorKind::internal, "the features belong to another mesh");
    const auto shells = facet_shells(mesh.edges, without_progress(execution));
    if (!shells) return fail(shells.error());
    const auto required = required_edges(mesh);
    return map_each(execution, mesh.edges.size(), [&](std::size_t e) -> LagrangeNode<D> {
        if (features.edge_kinds[e] == EdgeKind::volume) return mesh.mid_nodes[e];
        if (required[e] != 0) return mesh.mid_nodes[e];
        const auto& [low, high] = mesh.edges.vertices[e];
        return {node_without_cusp<D>(*geometry, {EdgeId(e),
                                                 features.edge_kinds[e],
                                                 {mesh.linear.points[low], mesh.linear.points[high]},
                                                 facet_sites<D>(mesh.linear, (*shells)[e])})};
    });
}

namespace {

template <int D>
std::optional<Plane<D>> plane_of(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Incidence<FacetId>& shells,
                                 const Features<D>& features, const Geometry<D>& geometry, std::size_t e) {
    if (D == 2 || features.edge_kinds[e] != EdgeKind::surface || shells[e].empty()) return {};
    // Fast path: most edges are on no plane, so test the first facet before the site is built.
    if (!geometry->plane_at(facet_site(mesh, shells[e].front()))) return {};
    const auto& [low, high] = edges.vertices[e];
    const EdgeSite<D> site{
        EdgeId(e), EdgeKind::surface, {mesh.points[low], mesh.points[high]}, facet_sites<D>(mesh, shells[e])};
    return common_plane(*geometry, site);
}

}  // namespace

template <int D>
Outcome<Buffer<LagrangeNode<D>>> slid_nodes(const QuadraticMesh<D>& mesh, const Column<LagrangeNode<D>>& nodes,
                                            std::span<const Vec<D>> shifts, const Features<D>& features,
                                            const Geometry<D>& geometry, const Execution& execution) {
    const std::size_t n = mesh.edges.size();
    if (nodes.size() != n || shifts.size() != n || features.edge_kinds.size() != n)
        return fail(ErrorKind::internal, "the nodes or shifts belong to another mesh");
    const auto shells = facet_shells(mesh.edges, without_progress(execution));
    if (!shells) return fail(shells.error());
    const auto required = required_edges(mesh);
    return map_each(execution, n, [&](std::size_t e) -> LagrangeNode<D> {
        if (required[e] != 0 || shifts[e] == Vec<D>{}) return nodes[e];
        const auto plane = plane_of(mesh.linear, mesh.edges, *shells, features, geometry, e);
        return plane ? LagrangeNode<D>{slid_within(*plane, nodes[e].point, shifts[e])} : nodes[e];
    });
}

std::vector<EmbeddedEdge> embedded_edges(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                         const Features<3>& features, const Incidence<FacetId>& shells) {
    std::vector<EmbeddedEdge> found;
    std::vector<std::uint8_t> is_known(edges.size(), 0);
    const auto add = [&](EdgeId e, Reference reference) {
        if (is_known[e.index()] != 0) return;
        is_known[e.index()] = 1;
        if (features.edge_kinds[e] != EdgeKind::ridge) found.push_back({e, reference});
    };
    for (std::size_t i = 0; i < mesh.edges.size(); ++i)
        add(edges.of_edges[i], mesh.edges.references.empty() ? 0 : mesh.edges.references[i]);
    const auto& entities = mesh.facets.entities;
    if (entities.empty()) return found;
    for (std::size_t e = 0; e < edges.size(); ++e)
        if (const auto facets = shells[e];
            facets.size() == 2 && entities[facets[0].index()] != entities[facets[1].index()])
            add(EdgeId(e), 0);
    return found;
}

namespace {

Outcome<Surrogate<3>> surrogate_with_curves(LinearMesh<3> mesh, EdgeSet<3> edges, const Features<3>& features,
                                            std::span<const EmbeddedEdge> embedded, const Execution& execution) {
    Buffer<EdgeId> sharp;
    for (std::size_t e = 0; e < edges.size(); ++e)
        if (features.edge_kinds[e] == EdgeKind::ridge) sharp.push_back(EdgeId(e));
    for (const EmbeddedEdge& at : embedded) sharp.push_back(at.edge);
    Buffer<SimplexVertices<1>> ends(sharp.size());
    for (std::size_t i = 0; i < sharp.size(); ++i) ends[i] = edges.vertices[sharp[i]];
    Buffer<std::uint32_t> rows(sharp.size());
    std::iota(rows.begin(), rows.end(), 0U);
    Buffer<VertexId> corners;
    for (std::size_t v = 0; v < features.vertex_kinds.size(); ++v)
        if (features.vertex_kinds[v] == VertexKind::corner) corners.emplace_back(v);
    mesh.edges = {std::move(ends), Buffer<Reference>(sharp.size(), 0), {}};
    mesh.ridges = std::move(rows);
    mesh.corners = std::move(corners);
    edges.of_edges = std::move(sharp);
    auto broken = find_features(mesh, edges, FeatureOptions<3>{.ridge_angle_degrees = 180}, execution);
    if (!broken) return fail(broken.error());
    return build_surrogate(mesh, edges, *broken, SurrogateOptions{}, execution);
}

CubicSimplex<1, 3> straight_piece(const Vec<3>& a, const Vec<3>& b) {
    const Vec<3> third = (b - a) / 3;
    return {{a, a + third, b - third, b}};
}
CubicSimplex<1, 3> bent_piece(const Vec<3>& a, const Vec<3>& node, const Vec<3>& b) {
    if (node == midpoint(a, b)) return straight_piece(a, b);
    const Vec<3> control = 2.0 * node - midpoint(a, b);
    constexpr double share = 2.0 / 3;
    return {{a, a + share * (control - a), b + share * (control - b), b}};
}

Buffer<VertexId> corners_of_curves(const LinearMesh<3>& mesh, const EdgeSet<3>& edges,
                                   std::span<const EmbeddedEdge> embedded, std::span<const std::uint8_t> is_straight) {
    struct End {
        VertexId vertex;
        Vec<3> along;
        bool straight = false;
    };
    std::vector<End> at;
    for (std::size_t i = 0; i < embedded.size(); ++i) {
        const auto& [a, b] = edges.vertices[embedded[i].edge];
        const Vec<3> along = mesh.points[b] - mesh.points[a];
        at.push_back({a, along, is_straight[i] != 0});
        at.push_back({b, -along, is_straight[i] != 0});
    }
    std::ranges::stable_sort(at, {}, &End::vertex);
    const double cosine = cos(FeatureOptions<3>{}.corner_angle_degrees * std::numbers::pi / 180);
    constexpr double rounding = 1e-9;
    Buffer<VertexId> corners;
    for (std::size_t i = 0; i + 1 < at.size(); ++i) {
        const auto& [v, one, of_straight] = at[i];
        const auto& [w, other, beside_straight] = at[i + 1];
        // Successive entries of one vertex are compared; a vertex of more than two curve edges is a corner anyway.
        if (v != w) continue;
        const double lengths = norm(one) * norm(other);
        const bool turns = -dot(one, other) < cosine * lengths;
        if (turns || ((of_straight || beside_straight) && norm(cross(one, other)) > rounding * lengths))
            if (corners.empty() || corners.back() != v) corners.push_back(v);
    }
    return corners;
}

Outcome<EmbeddedCurves<3>> found_curves(const LinearMesh<3>& mesh, const EdgeSet<3>& edges, const Features<3>& features,
                                        const Geometry<3>& geometry, std::span<const LagrangeNode<3>> nodes,
                                        const Execution& execution) {
    if (mesh.edges.size() == 0 && mesh.facets.entities.empty()) return EmbeddedCurves<3>{};
    const auto shells = facet_shells(edges, execution);
    if (!shells) return fail(shells.error());
    const auto embedded = embedded_edges(mesh, edges, features, *shells);
    if (embedded.empty()) return EmbeddedCurves<3>{};
    std::vector<std::uint8_t> is_straight(embedded.size(), 0);
    std::vector<EmbeddedEdge> on_surfaces;
    for (std::size_t i = 0; i < embedded.size() && nodes.empty(); ++i) {
        const auto sites = facet_sites(mesh, (*shells)[embedded[i].edge]);
        if (std::ranges::any_of(sites, [&](const FacetSite<3>& f) { return geometry->has_surface_at(f); }))
            on_surfaces.push_back(embedded[i]);
        else
            is_straight[i] = 1;
    }
    Surrogate<3> smooth;
    if (!on_surfaces.empty()) {
        auto result = surrogate_with_curves(mesh, edges, features, on_surfaces, execution);
        if (!result) return fail(result.error());
        smooth = std::move(*result);
    }
    Buffer<EmbeddedCurves<3>::Piece> pieces(embedded.size());
    Buffer<Box<3>> boxes(embedded.size(), Box<3>{});
    for (std::size_t i = 0; i < embedded.size(); ++i) {
        const auto& [edge, reference] = embedded[i];
        const auto& [a, b] = edges.vertices[edge];
        pieces[i].reference = reference;
        pieces[i].curve = !nodes.empty()        ? bent_piece(mesh.points[a], nodes[edge.index()].point, mesh.points[b])
                          : is_straight[i] != 0 ? straight_piece(mesh.points[a], mesh.points[b])
                                                : smooth.edge_curves[smooth.row(edge)].curve;
        for (const Vec<3>& p : pieces[i].curve.control) boxes[i].include(p);
    }
    Buffer<EdgeId> of_pieces(embedded.size());
    std::ranges::transform(embedded, of_pieces.begin(), &EmbeddedEdge::edge);
    return EmbeddedCurves<3>{std::move(pieces), std::move(of_pieces), BoxTree<3>(boxes),
                             corners_of_curves(mesh, edges, embedded, is_straight)};
}

}  // namespace

template <int D>
Outcome<EmbeddedCurves<D>> find_embedded_curves(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                const Features<D>& features, const Geometry<D>& geometry,
                                                std::span<const LagrangeNode<D>> nodes, const Execution& execution) {
    if constexpr (D == 2) {
        return EmbeddedCurves<D>{};
    } else {
        return guarded([&] { return found_curves(mesh, edges, features, geometry, nodes, execution); });
    }
}

template <int D>
std::optional<Vec<D>> closest_on_curves(const EmbeddedCurves<D>& curves, Reference reference, const Vec<D>& p) {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    const auto nearest = curves.tree.nearest(p, [&](std::size_t i) {
        const auto& piece = curves.pieces[i];
        return piece.reference == reference ? closest_on(piece.curve, p).distance_squared : infinite;
    });
    if (!(nearest.distance_squared < infinite)) return std::nullopt;
    return closest_on(curves.pieces[nearest.item].curve, p).point;
}

template <int D>
Outcome<Buffer<LagrangeNode<D>>> nodes_on_curves(const QuadraticMesh<D>& mesh, Buffer<LagrangeNode<D>> nodes,
                                                 const EmbeddedCurves<D>& curves, const Geometry<D>& geometry,
                                                 const Execution& execution) {
    if (curves.edges.empty()) return nodes;
    const auto shells = facet_shells(mesh.edges, without_progress(execution));
    if (!shells) return fail(shells.error());
    const auto required = required_edges(mesh);
    const auto placed = [&](std::size_t i) -> Vec<D> {
        const EdgeId e = curves.edges[i];
        const auto facets = facet_sites<D>(mesh.linear, (*shells)[e]);
        if (facets.empty() || required[e.index()] != 0) return nodes[e.index()].point;
        const Vec<D> middle = point_at(curves.pieces[i].curve, Barycentric<1>{0.5, 0.5});
        const GeometryEntity surface = geometry->surface_at(facets[0]);
        if (surface.kind != GeometryKind::surface) return middle;
        return geometry->project(geometry->hint_at(facets[0], surface), middle).point;
    };
    const auto points = map_each(execution, curves.edges.size(), placed);
    if (!points) return fail(points.error());
    for (std::size_t i = 0; i < points->size(); ++i) nodes[curves.edges[i].index()] = {(*points)[i]};
    return nodes;
}

template <int D>
Column<EdgeKind> kinds_with_curves(const Column<EdgeKind>& kinds, const EmbeddedCurves<D>& curves) {
    if (curves.edges.empty()) return kinds;
    Buffer<EdgeKind> with(kinds.begin(), kinds.end());
    for (const EdgeId e : curves.edges) with[e.index()] = EdgeKind::ridge;
    return Column<EdgeKind>(std::move(with));
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Vec<D> node_without_cusp<D>(const GeometryModel<D>&, const EdgeSite<D>&);                               \
    template Outcome<Buffer<LagrangeNode<D>>> boundary_nodes(const QuadraticMesh<D>&, const Features<D>&,            \
                                                             const Geometry<D>&, const Execution&);                  \
    template Outcome<Buffer<LagrangeNode<D>>> slid_nodes(const QuadraticMesh<D>&, const Column<LagrangeNode<D>>&,    \
                                                         std::span<const Vec<D>>, const Features<D>&,                \
                                                         const Geometry<D>&, const Execution&);                      \
    template Outcome<EmbeddedCurves<D>> find_embedded_curves<D>(const LinearMesh<D>&, const EdgeSet<D>&,             \
                                                                const Features<D>&, const Geometry<D>&,              \
                                                                std::span<const LagrangeNode<D>>, const Execution&); \
    template std::optional<Vec<D>> closest_on_curves<D>(const EmbeddedCurves<D>&, Reference, const Vec<D>&);         \
    template Outcome<Buffer<LagrangeNode<D>>> nodes_on_curves<D>(const QuadraticMesh<D>&, Buffer<LagrangeNode<D>>,   \
                                                                 const EmbeddedCurves<D>&, const Geometry<D>&,       \
                                                                 const Execution&);                                  \
    template Column<EdgeKind> kinds_with_curves<D>(const Column<EdgeKind>&, const EmbeddedCurves<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
