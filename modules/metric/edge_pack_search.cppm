module;
#include <cstddef>
#include <span>
export module camber.metric:edge_pack_search;
import camber.core;
import camber.bezier;
import :back_mesh;
import :edge_minimiser;

export namespace camber {

/// What the searches of some edges took.
struct EdgeSearchWork {
    std::size_t single = 0;          ///< edges that were searched alone
    std::size_t judged = 0;          ///< edges of which the finer rule had to say whether they are shorter
    std::size_t decompositions = 0;  ///< of M, of the others
    EdgeSearchWork& operator+=(const EdgeSearchWork& o) {
        single += o.single;
        judged += o.judged;
        decompositions += o.decompositions;
        return *this;
    }
};

/// minimise_back_edge of each edge, in packs, without the lengths, which stay 0: minima[i] of edges[i] with present[i].
/// An edge has the same bytes in any company and with any instructions.
template <int D>
EdgeSearchWork minimise_back_edges(const BackMesh<D>& back, std::span<const BackEdge> edges,
                                   std::span<const LagrangeNode<D>> present, const EdgeRules& rules,
                                   const EdgeMinimiserOptions& options, std::span<EdgeMinimum<D>> minima,
                                   Instructions set = widest_instructions());

/// An edge anywhere in a back mesh: its ends, with the field there.
template <int D>
struct FreeEdge {
    BackVertex<D> a, b;
    ElementId hint;  ///< an element near a
};

/// minimise_edge of each edge, likewise. From the chord, whose energy has its gradient from the elements that it
/// passes; by the search alone where the field goes along with curves there, or the chord leaves the mesh.
template <int D>
EdgeSearchWork minimise_edges(const BackMesh<D>& back, std::span<const FreeEdge<D>> edges, const EdgeRules& rules,
                              const EdgeMinimiserOptions& options, std::span<EdgeMinimum<D>> minima,
                              Instructions set = widest_instructions());

}  // namespace camber
