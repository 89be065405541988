// Surrogates of curved meshes: cuts facets at their nodes, measures kinks, selects a method by patch.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

template <int K>
constexpr std::array<std::array<Barycentric<K>, 2>, 2> pieces_of_facet{
    {{{{1, 0}, {0.5, 0.5}}}, {{{0.5, 0.5}, {0, 1}}}}};
template <>
constexpr std::array<std::array<Barycentric<2>, 3>, 4> pieces_of_facet<2>{
    {{{{1, 0, 0}, {0.5, 0.5, 0}, {0.5, 0, 0.5}}},
     {{{0.5, 0.5, 0}, {0, 1, 0}, {0, 0.5, 0.5}}},
     {{{0.5, 0, 0.5}, {0, 0.5, 0.5}, {0, 0, 1}}},
     {{{0, 0.5, 0.5}, {0.5, 0, 0.5}, {0.5, 0.5, 0}}}}};

/// The boundary of a quadratic mesh as a straight mesh: facets are cut at their nodes. Vertices keep their numbers.
/// They are followed by the nodes of boundary edges, in the order of edges. The first piece of facet f has the number f
/// × `pieces`. Pieces inherit the facet's features, and the directions and breaks listed in the file.
template <int D>
struct CutBoundary {
    static constexpr std::size_t pieces = pieces_of_facet<D - 1>.size();

    LinearMesh<D> mesh;
    EdgeSet<D> edges;
    Features<D> features;
};

template <int D>
struct UncutBoundary {
    const LinearMesh<D>& mesh;
    const EdgeSet<D>& edges;
    const Features<D>& features;
    std::vector<EdgeId> rows;           ///< boundary edges, ascending
    std::vector<VertexId> middle_of{};  ///< vertex at the node of each edge

    [[nodiscard]] VertexId vertex_at(FacetId f, const Barycentric<D - 1>& place) const {
        const auto at = [&](int i) { return place[static_cast<std::size_t>(i)]; };
        for (int i = 0; i < D; ++i)
            if (at(i) == 1) return mesh.facets.vertices[f][i];
        for (std::size_t k = 0; k < local_edges<D - 1>.size(); ++k)
            if (at(local_edges<D - 1>[k][0]) != 0 && at(local_edges<D - 1>[k][1]) != 0)
                return middle_of[edges.of_facets[f][k].index()];
        return {};
    }
};

template <int D>
UncutBoundary<D> uncut_boundary(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Features<D>& features) {
    UncutBoundary<D> out{mesh, edges, features, {}, std::vector<VertexId>(edges.size())};
    for (std::size_t e = 0; e < edges.size(); ++e) {
        if (features.edge_kinds[e] == EdgeKind::volume) continue;
        out.middle_of[e] = VertexId(mesh.points.size() + out.rows.size());
        out.rows.emplace_back(e);
    }
    return out;
}

void list_breaks(const UncutBoundary<2>& uncut_boundary, LinearMesh<2>& pieces) {
    Buffer<VertexId> corners(uncut_boundary.mesh.corners.begin(), uncut_boundary.mesh.corners.end());
    for (const std::uint32_t f : uncut_boundary.mesh.ridges)
        for (const VertexId v : uncut_boundary.mesh.facets.vertices[f]) corners.push_back(v);
    pieces.corners = std::move(corners);
}
void list_breaks(const UncutBoundary<3>& uncut_boundary, LinearMesh<3>& pieces) {
    pieces.corners = uncut_boundary.mesh.corners;
    Buffer<SimplexVertices<1>> halves;
    for (const std::uint32_t ridge : uncut_boundary.mesh.ridges) {
        const VertexId middle = uncut_boundary.middle_of[uncut_boundary.edges.of_edges[ridge].index()];
        if (!middle.valid()) continue;
        for (const VertexId end : uncut_boundary.mesh.edges.vertices[ridge]) halves.push_back({end, middle});
    }
    Buffer<Reference> references(halves.size());
    std::ranges::fill(references, 0);
    Buffer<std::uint32_t> ridges(halves.size());
    std::iota(ridges.begin(), ridges.end(), 0U);
    pieces.edges.vertices = std::move(halves);
    pieces.edges.references = std::move(references);
    pieces.ridges = std::move(ridges);
}

template <int D>
LinearMesh<D> mesh_of_pieces(const UncutBoundary<D>& uncut_boundary, std::span<const LagrangeNode<D>> nodes) {
    constexpr std::size_t pieces = CutBoundary<D>::pieces;
    Buffer<Vec<D>> points(uncut_boundary.mesh.points.begin(), uncut_boundary.mesh.points.end());
    points.reserve(points.size() + uncut_boundary.rows.size());
    for (const EdgeId e : uncut_boundary.rows) points.push_back(nodes[e.index()].point);
    Buffer<Reference> point_references(points.size());
    std::ranges::fill(point_references, 0);
    Buffer<SimplexVertices<D - 1>> vertices(pieces * uncut_boundary.mesh.facets.size());
    Buffer<Reference> references(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        const FacetId f(i / pieces);
        references[i] = uncut_boundary.mesh.facets.references[f];
        for (std::size_t c = 0; c < D; ++c)
            vertices[i][c] = uncut_boundary.vertex_at(f, pieces_of_facet<D - 1>[i % pieces][c]);
    }
    LinearMesh<D> out;
    out.points = std::move(points);
    out.point_references = std::move(point_references);
    out.facets.vertices = std::move(vertices);
    out.facets.references = std::move(references);
    out.geometry = uncut_boundary.mesh.geometry;
    list_breaks(uncut_boundary, out);
    return out;
}

template <int D>
Features<D> features_of_pieces(const UncutBoundary<D>& uncut_boundary, const LinearMesh<D>& mesh,
                               const EdgeSet<D>& edges) {
    constexpr std::size_t pieces = CutBoundary<D>::pieces;
    const Features<D>& of = uncut_boundary.features;
    Features<D> out = of;
    Buffer<EdgeKind> edge_kinds(edges.size());
    std::ranges::fill(edge_kinds, EdgeKind::surface);  // edges between pieces of a facet
    Buffer<std::uint32_t> curves(edges.size());
    std::ranges::fill(curves, no_feature);
    Buffer<VertexKind> vertex_kinds(of.vertex_kinds.begin(), of.vertex_kinds.end());
    for (const EdgeId e : uncut_boundary.rows) {
        const bool is_ridge = of.edge_kinds[e] == EdgeKind::ridge;
        vertex_kinds.push_back(is_ridge ? VertexKind::ridge : VertexKind::surface);
        for (const VertexId end : uncut_boundary.edges.vertices[e]) {
            const EdgeId half = find_edge(edges, end, uncut_boundary.middle_of[e.index()]);
            if (!half.valid()) continue;
            edge_kinds[half.index()] = of.edge_kinds[e];
            curves[half.index()] = of.curves[e];
            out.ridge_edges += is_ridge ? 1 : 0;
        }
    }
    Buffer<std::uint32_t> patches(mesh.facets.size());
    for (std::size_t i = 0; i < patches.size(); ++i) patches[i] = of.patches[i / pieces];
    out.edge_kinds = std::move(edge_kinds);
    out.vertex_kinds = std::move(vertex_kinds);
    out.patches = std::move(patches);
    out.curves = std::move(curves);
    out.ridge_edges -= of.ridge_edges;
    out.surface_edges = edges.size() - out.ridge_edges;
    return out;
}

template <int D>
Outcome<CutBoundary<D>> cut_at_nodes(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Features<D>& features,
                                     std::span<const LagrangeNode<D>> nodes, const Execution& execution) {
    return guarded([&]() -> Outcome<CutBoundary<D>> {
        const UncutBoundary<D> of = uncut_boundary(mesh, edges, features);
        CutBoundary<D> cut{mesh_of_pieces(of, nodes), {}, {}};
        auto halves = unique_edges(cut.mesh, execution);
        if (!halves) return fail(halves.error());
        cut.edges = std::move(*halves);
        cut.features = features_of_pieces(of, cut.mesh, cut.edges);
        return cut;
    });
}

template <int D>
std::size_t local(const LinearMesh<D>& mesh, FacetId f, VertexId v) {
    const auto& vertices = mesh.facets.vertices[f];
    return static_cast<std::size_t>(std::find(vertices.begin(), vertices.end(), v) - vertices.begin());
}

template <int D>
double angle_between(const Vec<D>& a, const Vec<D>& b) {
    return atan2(norm(a - b), norm(a + b)) * 2;
}

template <int D>
bool sides_agree(const LinearMesh<D>& mesh, const std::array<FacetId, 2>& facets, VertexId a, VertexId b) {
    const auto is_forward = [&](FacetId f) {
        return D == 2 ? local(mesh, f, a) == 0 : (local(mesh, f, a) + 1) % D == local(mesh, f, b);
    };
    return is_forward(facets[0]) != is_forward(facets[1]);
}

/// Angles (radians) between adjacent facets of a patch, at three points of each inner edge (2D: at each vertex).
struct Kinks {
    double squares = 0, largest = 0;
    std::size_t count = 0;

    void add(double angle) {
        squares += angle * angle;
        largest = std::fmax(largest, angle);
        ++count;
    }
    void add(const Kinks& other) {
        squares += other.squares;
        largest = std::fmax(largest, other.largest);
        count += other.count;
    }
    [[nodiscard]] double root_mean_square() const {
        return count == 0 ? 0 : std::sqrt(squares / static_cast<double>(count));
    }
};

template <int D>
using NormalOfFacet = std::function<Vec<D>(FacetId, const Barycentric<D - 1>&)>;

struct AdjacentFacets {
    std::array<FacetId, 2> facets;
    VertexId a, b;
};

Outcome<std::vector<AdjacentFacets>> adjacent_facets_of(const LinearMesh<3>&, const EdgeSet<3>& edges,
                                                        const Features<3>& features, const Execution& execution) {
    const auto shells = facet_shells(edges, execution);
    if (!shells) return fail(shells.error());
    std::vector<AdjacentFacets> out;
    for (std::size_t e = 0; e < edges.size(); ++e)
        if (features.edge_kinds[e] == EdgeKind::surface && (*shells)[EdgeId(e)].size() == 2) {
            const auto shell = (*shells)[EdgeId(e)];
            out.push_back({{shell[0], shell[1]}, edges.vertices[e][0], edges.vertices[e][1]});
        }
    return out;
}
Outcome<std::vector<AdjacentFacets>> adjacent_facets_of(const LinearMesh<2>& mesh, const EdgeSet<2>&,
                                                        const Features<2>& features, const Execution&) {
    std::vector<AdjacentFacets> out;
    std::vector<FacetId> first(mesh.points.size());
    for (std::size_t f = 0; f < mesh.facets.size(); ++f)
        for (const VertexId v : mesh.facets.vertices[f]) {
            if (features.vertex_kinds[v] == VertexKind::corner) continue;
            FacetId& other = first[v.index()];
            if (other.valid())
                out.push_back({{other, FacetId(f)}, v, v});
            else
                other = FacetId(f);
        }
    return out;
}

template <int D>
Outcome<std::vector<Kinks>> kinks_of(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Features<D>& features,
                                     const NormalOfFacet<D>& normal, const Execution& execution) {
    const auto passages = adjacent_facets_of(mesh, edges, features, without_progress(execution));
    if (!passages) return fail(passages.error());
    const auto at = map_each(execution, passages->size(), [&](std::size_t i) {
        const auto& [facets, a, b] = (*passages)[i];
        const double side = sides_agree(mesh, facets, a, b) ? 1 : -1;
        Kinks here;
        for (const double t : {0.0, 0.5, 1.0}) {
            if (D == 2 && t != 0) continue;
            const auto normal_in = [&, from = a, to = b](FacetId f) {
                Barycentric<D - 1> xi{};
                xi[local(mesh, f, from)] = 1 - t;
                if (D == 3) xi[local(mesh, f, to)] = t;
                return normal(f, xi);
            };
            here.add(angle_between(normal_in(facets[0]), side * normal_in(facets[1])));
        }
        return here;
    });
    if (!at) return fail(at.error());
    std::vector<Kinks> of_patches(features.patch_count);
    for (std::size_t i = 0; i < passages->size(); ++i)
        of_patches[features.patches[(*passages)[i].facets[0]]].add((*at)[i]);
    return of_patches;
}

/// Inner control points (4m − b)/3 and (4m − a)/3 of the quadratic edge from a to b through m. They are exactly on the
/// chord if m is its midpoint.
template <int D>
std::array<Vec<D>, 2> raised(const Vec<D>& a, const Vec<D>& m, const Vec<D>& b) {
    const Vec<D> third = (b - a) / 3;
    const Vec<D> bow = (m - midpoint(a, b)) * (4.0 / 3);
    return {a + third + bow, b - third + bow};
}

template <int D>
CubicSimplex<D - 1, D> raised_facet(const std::array<Vec<D>, D>& corners,
                                    const std::array<Vec<D>, edges_per_simplex<D - 1>>& nodes) {
    CubicSimplex<D - 1, D> facet;
    for (std::size_t i = 0; i < D; ++i) {
        MultiIndex<D - 1> alpha{};
        alpha[i] = 3;
        facet.at(alpha) = corners[i];
    }
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        const auto i = static_cast<std::size_t>(local_edges<D - 1>[k][0]);
        const auto j = static_cast<std::size_t>(local_edges<D - 1>[k][1]);
        const auto inner = raised(corners[i], nodes[k], corners[j]);
        MultiIndex<D - 1> alpha{};
        alpha[i] = 2;
        alpha[j] = 1;
        facet.at(alpha) = inner[0];
        std::swap(alpha[i], alpha[j]);
        facet.at(alpha) = inner[1];
    }
    if constexpr (D == 3) facet.at({1, 1, 1}) = classical_centre(facet);
    return facet;
}

template <int D>
CubicSimplex<D - 1, D> own_facet(const BoundaryCurves<D>& mesh, FacetId f) {
    std::array<Vec<D>, D> corners;
    for (std::size_t i = 0; i < D; ++i) corners[i] = mesh.linear.points[mesh.linear.facets.vertices[f][i]];
    std::array<Vec<D>, edges_per_simplex<D - 1>> nodes;
    for (std::size_t k = 0; k < nodes.size(); ++k) nodes[k] = mesh.nodes[mesh.edges.of_facets[f][k].index()].point;
    return raised_facet<D>(corners, nodes);
}

template <int D>
std::array<Vec<D>, edges_per_simplex<D - 1>> nodes_of_piece(const CubicSimplex<D - 1, D>& facet, std::size_t piece) {
    std::array<Vec<D>, edges_per_simplex<D - 1>> nodes;
    for (std::size_t k = 0; k < nodes.size(); ++k) {
        const auto& corners = pieces_of_facet<D - 1>[piece];
        const auto [i, j] = local_edges<D - 1>[k];
        Barycentric<D - 1> middle;
        for (std::size_t c = 0; c < D; ++c)
            middle[c] = (corners[static_cast<std::size_t>(i)][c] + corners[static_cast<std::size_t>(j)][c]) / 2;
        nodes[k] = point_at(facet, middle);
    }
    return nodes;
}

template <int D>
std::vector<std::uint8_t> patches_with_curves(const BoundaryCurves<D>& mesh, const Surrogate<D>& surrogate) {
    constexpr double same = 1e-6;  // positions are equal if they differ by at most this share of the chord
    constexpr std::uint8_t off_surface = 1, off_chord = 2;
    std::vector<std::uint8_t> found(surrogate.flats.size(), 0);
    for (std::size_t f = 0; f < mesh.linear.facets.size(); ++f)
        for (const EdgeId e : mesh.edges.of_facets[f]) {
            const Vec<D>& a = mesh.linear.points[mesh.edges.vertices[e][0]];
            const Vec<D>& b = mesh.linear.points[mesh.edges.vertices[e][1]];
            const Vec<D>& node = mesh.nodes[e.index()].point;
            const double least = same * distance(a, b);
            std::uint8_t& of_patch = found[surrogate.patches[f]];
            if (distance(node, surrogate.edge_curves[surrogate.row(e)].middle) > least) of_patch |= off_surface;
            if (distance(node, midpoint(a, b)) > least) of_patch |= off_chord;
        }
    for (std::uint8_t& of_patch : found) of_patch = of_patch == (off_surface | off_chord) ? 1 : 0;
    return found;
}

template <int D>
Buffer<LagrangeNode<D>> interpolated_nodes(const BoundaryCurves<D>& mesh, const Surrogate<D>& straight,
                                           std::span<const std::uint8_t> own) {
    Buffer<LagrangeNode<D>> nodes(mesh.nodes.begin(), mesh.nodes.end());
    for (std::size_t row = 0; row < straight.edges.size(); ++row)
        nodes[straight.edges[row].index()].point = straight.edge_curves[row].middle;
    for (std::size_t f = 0; f < mesh.linear.facets.size(); ++f)
        if (own[straight.patches[f]] != 0)
            for (const EdgeId e : mesh.edges.of_facets[f]) nodes[e.index()] = mesh.nodes[e.index()];
    return nodes;
}

Vec<2> straight_normal(const std::array<Vec<2>, 2>& c) {
    return normalised(Vec<2>{{c[1][1] - c[0][1], c[0][0] - c[1][0]}});
}
Vec<3> straight_normal(const std::array<Vec<3>, 3>& c) { return normalised(cross(c[1] - c[0], c[2] - c[0])); }

template <int D>
Outcome<std::vector<std::uint8_t>> kinked_patches(const BoundaryCurves<D>& mesh, std::span<const std::uint8_t> own,
                                                  const Execution& execution) {
    constexpr double most = 0.25;  // largest turns between quadratic facets, relative to the turns between straight
                                   // facets
    const auto of_curves = kinks_of<D>(
        mesh.linear, mesh.edges, mesh.features,
        [&](FacetId f, const Barycentric<D - 1>& xi) { return normal_at<D>(own_facet(mesh, f), xi); },
        part_of(execution, 0, 0.7));
    if (!of_curves) return fail(of_curves.error());
    const auto of_chords = kinks_of<D>(
        mesh.linear, mesh.edges, mesh.features,
        [&](FacetId f, const Barycentric<D - 1>&) { return straight_normal(facet_site(mesh.linear, f).corners); },
        part_of(execution, 0.7, 1));
    if (!of_chords) return fail(of_chords.error());
    std::vector<std::uint8_t> kinked(own.begin(), own.end());
    for (std::size_t p = 0; p < kinked.size(); ++p)
        if ((*of_curves)[p].count > 0 &&
            (*of_curves)[p].root_mean_square() <= most * (*of_chords)[p].root_mean_square())
            kinked[p] = 0;
    return kinked;
}

template <int D>
Outcome<Done> restore_own_facets(const BoundaryCurves<D>& mesh, const CutBoundary<D>& cut,
                                 std::span<const std::uint8_t> kinked, Surrogate<D>& surrogate,
                                 const Execution& execution) {
    constexpr std::size_t pieces = CutBoundary<D>::pieces;
    const auto is_kinked = [&](std::size_t i) {
        const std::uint32_t patch = surrogate.patches[i];
        return kinked[patch] != 0 && !surrogate.flats[patch].is_flat();
    };
    auto facets = map_each(part_of(execution, 0, 0.5), surrogate.facets.size(), [&](std::size_t i) {
        if (!is_kinked(i)) return surrogate.facets[i];
        const auto nodes = nodes_of_piece<D>(own_facet(mesh, FacetId(i / pieces)), i % pieces);
        return raised_facet<D>(facet_site(cut.mesh, FacetId(i)).corners, nodes);
    });
    if (!facets) return fail(facets.error());
    Buffer<SurrogateEdge<D>> curves(surrogate.edge_curves.begin(), surrogate.edge_curves.end());
    for (std::size_t i = 0; i < facets->size(); ++i) {
        if (!is_kinked(i)) continue;
        const auto nodes = nodes_of_piece<D>(own_facet(mesh, FacetId(i / pieces)), i % pieces);
        for (std::size_t k = 0; k < nodes.size(); ++k) {
            const EdgeId e = cut.edges.of_facets[i][k];
            SurrogateEdge<D>& edge = curves[surrogate.row(e)];
            const auto& a = cut.mesh.points[cut.edges.vertices[e][0]];
            const auto& b = cut.mesh.points[cut.edges.vertices[e][1]];
            const auto inner = raised(a, nodes[k], b);
            edge = {{{a, inner[0], inner[1], b}}, nodes[k], edge.curve_number};
        }
    }
    surrogate.facets = std::move(*facets);
    surrogate.edge_curves = std::move(curves);
    return build_trees(surrogate, part_of(execution, 0.5, 1));
}

template <int D>
Outcome<CurvedPatches> count_patches(const CutBoundary<D>& cut, const Surrogate<D>& surrogate,
                                     std::span<const std::uint8_t> own, std::span<const std::uint8_t> kinked,
                                     const Execution& execution) {
    const auto kinks = kinks_of<D>(
        cut.mesh, cut.edges, cut.features,
        [&](FacetId f, const Barycentric<D - 1>& xi) { return normal_at<D>(surrogate.facets[f], xi); }, execution);
    if (!kinks) return fail(kinks.error());
    CurvedPatches patches;
    Kinks all;
    for (std::size_t p = 0; p < own.size(); ++p) {
        if (own[p] == 0) continue;
        ++(kinked[p] != 0 ? patches.as_read : patches.smooth);
        if (kinked[p] == 0) all.add((*kinks)[p]);
    }
    patches.largest_angle = all.largest;
    patches.mean_angle = all.root_mean_square();
    return patches;
}

}  // namespace

template <int D>
Outcome<CurvedSurrogate<D>> build_curved_surrogate(Surrogate<D> straight, const BoundaryCurves<D>& mesh,
                                                   const GeometryModel<D>& prescribed, const SurrogateOptions& options,
                                                   const Execution& execution) {
    const auto& [linear, edges, features, nodes] = mesh;
    if (straight.facets.size() != linear.facets.size() || nodes.size() != edges.size() ||
        features.patches.size() != linear.facets.size())
        return fail(ErrorKind::internal, "the surrogate belongs to another mesh");
    const auto own = patches_with_curves(mesh, straight);
    if (std::ranges::none_of(own, [](std::uint8_t has) { return has != 0; }))
        return CurvedSurrogate<D>{std::move(straight), {}};
    const auto kinked = kinked_patches<D>(mesh, own, part_of(execution, 0, 0.1));
    if (!kinked) return fail(kinked.error());
    const auto cut = cut_at_nodes<D>(linear, edges, features, interpolated_nodes<D>(mesh, straight, own),
                                     part_of(execution, 0.1, 0.2));
    if (!cut) return fail(cut.error());
    auto smooth =
        build_surrogate(cut->mesh, cut->edges, cut->features, prescribed, options, part_of(execution, 0.2, 0.9));
    if (!smooth) return fail(smooth.error());
    if (auto done = restore_own_facets<D>(mesh, *cut, *kinked, *smooth, part_of(execution, 0.9, 0.95)); !done)
        return fail(done.error());
    auto patches = count_patches<D>(*cut, *smooth, own, *kinked, part_of(execution, 0.95, 1));
    if (!patches) return fail(patches.error());
    return CurvedSurrogate<D>{std::move(*smooth), *patches};
}

#define CAMBER_INSTANTIATE(D)                                       \
    template Outcome<CurvedSurrogate<D>> build_curved_surrogate<D>( \
        Surrogate<D>, const BoundaryCurves<D>&, const GeometryModel<D>&, const SurrogateOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
