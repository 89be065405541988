module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>
export module camber.operation:curved_workspace;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.validity;
import :request;

/// What curving a star fills anew each time.
export namespace camber {

/// An edge from the point to a vertex of the star's boundary.
template <int D>
struct Spoke {
    EdgeKind kind = EdgeKind::volume;  ///< fixed: of elements or facets outside of the cavity too
    /// Where the metric (the geometry) has its node, and the cavity's old curves.
    Vec<D> wanted, extended;
    Vec<D> node;
    bool is_extended = false;  ///< whether `extended` is known
    double share = 1;          ///< of the way from `extended` to `wanted`
    LineId line;               ///< of a ridge: one that it continues
    /// The last that was measured, with which node.
    double length = -1;
    Vec<D> measured;
};

/// A new element: its face outside, and which spokes lead from there to the point.
template <int D>
struct Cone {
    QuadraticNodes<D> nodes{};
    std::array<const LogMetric<D>*, D + 1> metrics{};  ///< of each local vertex
    std::array<std::uint32_t, D + 1> spokes{};         ///< of each local vertex but `point`
    int point = 0;                                     ///< local vertex
    bool is_stale = true, is_flat = false;
    bool is_surely_straight_positive = false;  ///< its straight element, beyond rounding
    Verdict verdict = Verdict::undecided;
    double shape = -1;  ///< of a valid one, once it was asked for
};

/// An inner edge of the star's outer faces, whose node may follow.
template <int D>
struct RimEdge {
    EdgeId edge;
    Vec<D> before, wanted, node;
};

/// An element outside of the cavity that has such an edge.
template <int D>
struct OutsideElement {
    ElementId element;
    QuadraticNodes<D> nodes{};
    double bound = 0;  ///< what its scaled Jacobian is to keep
};

/// A removed element as a map from its straight shape to its curved one.
template <int D>
struct OldElement {
    ElementId element;
    double size = 0;  ///< of the straight one, whichever way round
    Vec<D> origin;
    std::array<Vec<D>, D> gradients{};                 ///< of the barycentric coordinates 1 … D
    std::array<Vec<D>, edges_per_simplex<D>> offsets;  ///< of the nodes from the middles of chords
};

template <int D>
struct CurvedWorkspace {
    std::vector<Spoke<D>> spokes;
    std::vector<Cone<D>> cones;
    std::vector<std::size_t> stale;  ///< of them
    std::vector<RimEdge<D>> rim;
    std::vector<OutsideElement<D>> outside;
    std::vector<ElementId> around;
    std::vector<OldElement<D>> old_elements;
    std::vector<FacetSite<D>> facets;                     ///< new ones
    std::vector<std::array<std::uint32_t, 2>> of_facets;  ///< spoke, and the new facet with it
    std::vector<Vec<D>> chords, offsets;
    std::vector<EndSights<D>> ends;
    std::vector<double> lengths;
    std::vector<BentSpoke<D>> bent;  ///< of this operation, but for those that its request has
    std::vector<FreeEdge<D>> searched;
    std::vector<EdgeMinimum<D>> found;
    std::vector<std::uint32_t> free;            ///< spokes that are to be bent
    std::vector<std::uint32_t> short_of_place;  ///< spokes that approach where they are wanted
    int programmes = 0;                         ///< spent
};

}  // namespace camber
