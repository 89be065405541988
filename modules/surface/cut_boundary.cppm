module;
#include <array>
#include <cstddef>
#include <span>
module camber.surface:cut_boundary;
import camber.core;
import camber.bezier;
import :features;

namespace camber {

/// A facet of degree 2 cut at its nodes: each piece by its corners, as places of the facet; the one in the middle last.
template <int K>
inline constexpr std::array<std::array<Barycentric<K>, 2>, 2> pieces_of_facet{
    {{{{1, 0}, {0.5, 0.5}}}, {{{0.5, 0.5}, {0, 1}}}}};
template <>
inline constexpr std::array<std::array<Barycentric<2>, 3>, 4> pieces_of_facet<2>{
    {{{{1, 0, 0}, {0.5, 0.5, 0}, {0.5, 0, 0.5}}},
     {{{0.5, 0.5, 0}, {0, 1, 0}, {0, 0.5, 0.5}}},
     {{{0.5, 0, 0.5}, {0, 0.5, 0.5}, {0, 0, 1}}},
     {{{0, 0.5, 0.5}, {0.5, 0, 0.5}, {0.5, 0.5, 0}}}}};

/// The boundary of a mesh of degree 2 as a straight one of half the size: vertices keep their numbers, nodes of
/// boundary edges follow them by rising edge, and the pieces of facet f are those from f × pieces on. What a vertex, an
/// edge or a facet is (`features`, notes and listed breaks of the file) its pieces are; where facets turn is not asked
/// again.
template <int D>
struct CutBoundary {
    static constexpr std::size_t pieces = pieces_of_facet<D - 1>.size();

    LinearMesh<D> mesh;
    EdgeSet<D> edges;
    Features<D> features;
};

/// Errors: of `unique_edges`, stopped.
template <int D>
[[nodiscard]] Outcome<CutBoundary<D>> cut_at_nodes(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                   const Features<D>& features, std::span<const LagrangeNode<D>> nodes,
                                                   const Execution& execution);

}  // namespace camber
