module;
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
    std::span<const LagrangeNode<D>> nodes;
};

/// a, (4m − b)/3, (4m − a)/3, b: the edge through m at 1/2, of degree 2; exactly straight where m is the middle.
template <int D>
std::array<Vec<D>, 2> raised(const Vec<D>& a, const Vec<D>& m, const Vec<D>& b) {
    const Vec<D> third = (b - a) / 3;
    const Vec<D> bow = (m - midpoint(a, b)) * (4.0 / 3);
    return {a + third + bow, b - third + bow};
}

template <int D>
SurrogateEdge<D> cubic_edge_of(const Curves<D>& mesh, EdgeId e, std::uint32_t curve_number) {
    const auto& [low, high] = mesh.edges.vertices[e];
    const Vec<D>& a = mesh.linear.points[low];
    const Vec<D>& b = mesh.linear.points[high];
    const Vec<D>& m = mesh.nodes[e.index()].point;
    const auto inner = raised(a, m, b);
    return {{{a, inner[0], inner[1], b}}, m, curve_number};
}

template <int D>
CubicSimplex<D - 1, D> cubic_facet(const Curves<D>& mesh, std::size_t f) {
    const auto& vertices = mesh.linear.facets.vertices[f];
    CubicSimplex<D - 1, D> facet;
    for (std::size_t i = 0; i < D; ++i) {
        MultiIndex<D - 1> alpha{};
        alpha[i] = 3;
        facet.at(alpha) = mesh.linear.points[vertices[i]];
    }
    for (int k = 0; k < edges_per_simplex<D - 1>; ++k) {
        const auto i = static_cast<std::size_t>(local_edges<D - 1>[k][0]);
        const auto j = static_cast<std::size_t>(local_edges<D - 1>[k][1]);
        const auto inner = raised(mesh.linear.points[vertices[i]], mesh.nodes[mesh.edges.of_facets[f][k].index()].point,
                                  mesh.linear.points[vertices[j]]);
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

/// Patches whose nodes leave their plane are not flat.
template <int D>
Buffer<FlatPatch<D>> still_flat(const Curves<D>& mesh, const Surrogate<D>& surrogate) {
    Buffer<FlatPatch<D>> flats(surrogate.flats.begin(), surrogate.flats.end());
    for (std::size_t f = 0; f < mesh.linear.facets.size(); ++f) {
        FlatPatch<D>& flat = flats[surrogate.patches[f]];
        for (const EdgeId e : mesh.edges.of_facets[f])
            if (flat.is_flat() && flat.height(mesh.nodes[e.index()].point) != 0) flat = {};
    }
    return flats;
}

}  // namespace

template <int D>
Outcome<Surrogate<D>> with_curves(Surrogate<D> surrogate, const LinearMesh<D>& linear, const EdgeSet<D>& edges,
                                  std::span<const LagrangeNode<D>> nodes, const Execution& execution) {
    const Curves<D> mesh{linear, edges, nodes};
    if (surrogate.facets.size() != mesh.linear.facets.size() ||
        (!surrogate.edges.empty() && surrogate.edges[surrogate.edges.size() - 1].index() >= nodes.size()))
        return fail(ErrorKind::internal, "the surrogate is that of another mesh");
    const auto own = patches_with_curves(mesh, surrogate);
    std::vector<std::uint8_t> own_edges(nodes.size(), 0);
    for (std::size_t f = 0; f < linear.facets.size(); ++f)
        for (const EdgeId e : edges.of_facets[f]) own_edges[e.index()] |= own[surrogate.patches[f]];
    auto facets = map_each(part_of(execution, 0, 0.5), surrogate.facets.size(), [&](std::size_t f) {
        return own[surrogate.patches[f]] != 0 ? cubic_facet(mesh, f) : surrogate.facets[f];
    });
    if (!facets) return fail(facets.error());
    auto curves = map_each(part_of(execution, 0.5, 0.6), surrogate.edges.size(), [&](std::size_t row) {
        const EdgeId e = surrogate.edges[row];
        const SurrogateEdge<D>& smooth = surrogate.edge_curves[row];
        return own_edges[e.index()] != 0 ? cubic_edge_of(mesh, e, smooth.curve_number) : smooth;
    });
    if (!curves) return fail(curves.error());
    surrogate.flats = still_flat(mesh, surrogate);
    surrogate.facets = std::move(*facets);
    surrogate.edge_curves = std::move(*curves);
    if (auto done = plant_trees(surrogate, part_of(execution, 0.6, 1)); !done) return fail(done.error());
    return surrogate;
}

template Outcome<Surrogate<2>> with_curves<2>(Surrogate<2>, const LinearMesh<2>&, const EdgeSet<2>&,
                                              std::span<const LagrangeNode<2>>, const Execution&);
template Outcome<Surrogate<3>> with_curves<3>(Surrogate<3>, const LinearMesh<3>&, const EdgeSet<3>&,
                                              std::span<const LagrangeNode<3>>, const Execution&);

}  // namespace camber
