module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

template <int D>
struct Curves {
    const LinearMesh<D>& linear;
    const EdgeSet<D>& edges;
    const Features<D>& features;
    std::span<const LagrangeNode<D>> nodes;
};

/// a, (4m − b)/3, (4m − a)/3, b: the edge through m at 1/2, of degree 2; exactly straight where m is the middle.
template <int D>
std::array<Vec<D>, 2> raised(const Vec<D>& a, const Vec<D>& m, const Vec<D>& b) {
    const Vec<D> third = (b - a) / 3;
    const Vec<D> bow = (m - midpoint(a, b)) * (4.0 / 3);
    return {a + third + bow, b - third + bow};
}

/// The facet of degree 2 with these corners, and nodes in the order of local_edges.
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
CubicSimplex<D - 1, D> own_facet(const Curves<D>& mesh, FacetId f) {
    std::array<Vec<D>, D> corners;
    for (std::size_t i = 0; i < D; ++i) corners[i] = mesh.linear.points[mesh.linear.facets.vertices[f][i]];
    std::array<Vec<D>, edges_per_simplex<D - 1>> nodes;
    for (std::size_t k = 0; k < nodes.size(); ++k) nodes[k] = mesh.nodes[mesh.edges.of_facets[f][k].index()].point;
    return raised_facet<D>(corners, nodes);
}

/// The node of each edge of a piece of a facet of degree 2.
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

/// Of each patch, whether it has curves of its own: a node that is not where the surrogate has its edge's middle, and
/// one that is not in the middle of its chord.
template <int D>
std::vector<std::uint8_t> patches_with_curves(const Curves<D>& mesh, const Surrogate<D>& surrogate) {
    constexpr double same = 1e-6;  // of the chord
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

/// The file's nodes at edges of patches that have curves, elsewhere the middles that the straight mesh's surrogate has.
template <int D>
Buffer<LagrangeNode<D>> nodes_to_go_through(const Curves<D>& mesh, const Surrogate<D>& straight,
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

/// Of each patch that has curves, whether they are no smooth surface's.
template <int D>
Outcome<std::vector<std::uint8_t>> kinked_patches(const Curves<D>& mesh, std::span<const std::uint8_t> own,
                                                  const Execution& execution) {
    constexpr double most = 0.25;  // of the turns of straight facets
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

/// Pieces of these patches become parts of the mesh's own facets.
template <int D>
Outcome<Done> put_as_read(const Curves<D>& mesh, const CutBoundary<D>& cut, std::span<const std::uint8_t> kinked,
                          Surrogate<D>& surrogate, const Execution& execution) {
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
    return plant_trees(surrogate, part_of(execution, 0.5, 1));
}

/// Counts of patches, and how far the smooth ones are from it.
template <int D>
Outcome<CurvedPatches> told(const CutBoundary<D>& cut, const Surrogate<D>& surrogate, std::span<const std::uint8_t> own,
                            std::span<const std::uint8_t> kinked, const Execution& execution) {
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
Outcome<CurvedSurrogate<D>> with_curves(Surrogate<D> straight, const LinearMesh<D>& linear, const EdgeSet<D>& edges,
                                        const Features<D>& features, std::span<const LagrangeNode<D>> nodes,
                                        const GeometryModel<D>& prescribed, const SurrogateOptions& options,
                                        const Execution& execution) {
    const Curves<D> mesh{linear, edges, features, nodes};
    if (straight.facets.size() != linear.facets.size() || nodes.size() != edges.size() ||
        features.patches.size() != linear.facets.size())
        return fail(ErrorKind::internal, "the surrogate is that of another mesh");
    const auto own = patches_with_curves(mesh, straight);
    if (std::ranges::none_of(own, [](std::uint8_t has) { return has != 0; }))
        return CurvedSurrogate<D>{std::move(straight), {}};
    const auto kinked = kinked_patches<D>(mesh, own, part_of(execution, 0, 0.1));
    if (!kinked) return fail(kinked.error());
    const auto cut = cut_at_nodes<D>(linear, edges, features, nodes_to_go_through<D>(mesh, straight, own),
                                     part_of(execution, 0.1, 0.2));
    if (!cut) return fail(cut.error());
    auto smooth =
        build_surrogate(cut->mesh, cut->edges, cut->features, prescribed, options, part_of(execution, 0.2, 0.9));
    if (!smooth) return fail(smooth.error());
    if (auto done = put_as_read<D>(mesh, *cut, *kinked, *smooth, part_of(execution, 0.9, 0.95)); !done)
        return fail(done.error());
    auto patches = told<D>(*cut, *smooth, own, *kinked, part_of(execution, 0.95, 1));
    if (!patches) return fail(patches.error());
    return CurvedSurrogate<D>{std::move(*smooth), *patches};
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Outcome<CurvedSurrogate<D>> with_curves<D>(                                                             \
        Surrogate<D>, const LinearMesh<D>&, const EdgeSet<D>&, const Features<D>&, std::span<const LagrangeNode<D>>, \
        const GeometryModel<D>&, const SurrogateOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
