module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>
export module camber.operation:request;
import camber.core;
import camber.metric;
import camber.cavity;
import camber.surface;
import camber.validity;
import :state;
import :vertex_data;

export namespace camber {

/// An edge to a point of a mesh of degree 2 as the closed form of accuracy bends it (bent_edges): its node from the
/// middle of the chord, its length.
template <int D>
struct BentSpoke {
    VertexId vertex;
    Vec<D> offset;
    double length = 0;
};

/// An operation as it is candidate for.
template <int D>
struct CavityRequest {
    Cavity<D> cavity;
    VertexId point;          ///< of the mesh; invalid: a new one
    Vec<D> place;            ///< of a new one, or where it moves
    VertexMetric<D> metric;  ///< there
    /// The first so many of the cavity's elements hold the point; the others may leave it again to make it fit.
    std::size_t holders = 0;
    Reference reference = 0;
    GeometryPlace lies = {};  ///< where `place` is on the geometry

    // In a mesh of degree 2:
    LogGradient<D> gradient{};  ///< of the field at `place`
    std::optional<Vec<D>> origin =
        {};            ///< of what straight place of the cavity `place` is the curved one; none: itself
    double share = 1;  ///< how far points of the boundary go to the geometry
    std::array<VertexId, 2> halves = {};  ///< of an edge that is split: the edges to its ends keep its curve
    std::vector<BentSpoke<D>> bent = {};  ///< edges inside to `place` that have been bent already, by what is here

    /// To a vertex as it is.
    void join_to(const Adaptation<D>& r, VertexId v) {
        point = v;
        place = r.mesh.points[v];
        const VertexRow<D> known = r.vertices.row(v);
        metric = known.metric;
        lies = known.place;
        gradient = known.gradient;
    }
};

/// What becomes of a new element below the least shape: refused, or not where it is no worse than the worst element
/// that is replaced.
enum class BelowLeast : std::uint8_t { refused, accepted_if_no_worse };

/// What becomes of a new element that is not valid, as the one with its vertices was not before.
enum class InvalidBefore : std::uint8_t { refused, may_stay };

/// What becomes of a patch with more elements that have two facets on one smooth, curved surface.
enum class WallElements : std::uint8_t { accepted, refused };

/// What becomes of a patch that brings no node noticeably nearer to where it is wanted (see gains).
enum class NodeGain : std::uint8_t { not_asked, asked };

/// The least cosine between a new facet's normal and those of the facets that it replaces, if nothing else is asked.
inline constexpr double least_facet_cosine = 0.8;

/// What is asked of the new simplices.
struct PatchLimits {
    double min_shape = 0;                          ///< shape_of each new element: above this
    BelowLeast below_least = BelowLeast::refused;  ///< see QualityBar, which asks for more
    double bad_quality = 0.05;  ///< whatever min_shape is, no new element is below this and below the worst replaced
    double shortest = 0, longest = std::numeric_limits<double>::infinity();  ///< edges at the point, in the metric
    /// Of degree 2: of new elements the scaled Jacobian, unless one that is replaced is worse.
    double min_jacobian = default_bound;
    /// And this, if one that is replaced is worse.
    double lowest_jacobian = 0;
    /// Where every new element has the vertices of one that it replaces: what was not valid may stay so.
    InvalidBefore invalid_before = InvalidBefore::refused;
    /// Linear programmes, each for one inner edge, that may be spent where the old curves do not make a star valid.
    int programmes = 8;
    /// Where that is not enough, all inner nodes of the star may go together, and with them those of so many inner
    /// edges of its outer faces; 0: neither.
    int bend_around = 0;
    /// Inner nodes that were drawn back and then come nearer together to where they are wanted, at most.
    int approaching = 0;
    double facet_cosine = least_facet_cosine;
    /// New facets from the geometry, as a share of their longest edges (see distance_from_geometry).
    double facet_distance = std::numeric_limits<double>::infinity();
    WallElements wall_elements = WallElements::accepted;
    NodeGain node_gain = NodeGain::not_asked;
    /// How often elements may join the cavity, or leave it, to make it fit.
    int corrections = 8;
};

/// Why a request was not granted. The first are those of StarFailure.
enum class RejectionReason : std::uint8_t {
    none,
    empty,
    required,  ///< also: a corner, or a vertex without all of its elements, would move
    surface,
    line,
    ball,
    exists,
    volume,    ///< an element would be inverted, or have no volume; of degree 2: not be valid to the bound
    quality,   ///< an element below min_shape
    length,    ///< an edge at the point out of bounds
    geometry,  ///< facets would turn too far, or be too far from the geometry
    waits,     ///< another patch was in the way: in a later round
    wall,      ///< an element would have two facets on one smooth, curved surface
    crossing,  ///< facets that cross; of degree 2: that are not proved to be disjoint
    gain,      ///< nothing noticeable would change
    height,    ///< an element so flat that the rounding of coordinates could invert it
};
[[nodiscard]] constexpr auto words(RejectionReason) {
    using R = RejectionReason;
    return words_of(
        Word{R::none, "none"}, Word{R::empty, "empty"}, Word{R::required, "required"}, Word{R::surface, "surface"},
        Word{R::line, "line"}, Word{R::ball, "ball"}, Word{R::exists, "exists"}, Word{R::volume, "volume"},
        Word{R::quality, "quality"}, Word{R::length, "length"}, Word{R::wall, "wall"}, Word{R::crossing, "crossing"},
        Word{R::height, "height"}, Word{R::gain, "gain"}, Word{R::geometry, "geometry"}, Word{R::waits, "waits"});
}
inline constexpr std::size_t rejection_reasons = words(RejectionReason{}).size();

/// A request and what is asked of it.
template <int D>
struct Candidate {
    CavityRequest<D> request;
    PatchLimits limits;
    RejectionReason rejected = RejectionReason::none;  ///< known already: nothing is planned
};

}  // namespace camber

export namespace camber {

/// Asks the field at a request's place; the search begins at an element of the back mesh.
template <int D>
void ask_field(const Adaptation<D>& r, const AdaptationGoal<D>& goal, ElementId hint, CavityRequest<D>& request) {
    const FieldSample<D> sample = r.mesh.is_curved() ? sample_with_recovered_gradient(goal.field, request.place, hint)
                                                     : sample_value(goal.field, request.place, hint);
    request.metric = VertexMetric<D>(sample.log_metric, sample.location.element);
    if (r.mesh.is_curved()) request.gradient = sample.gradient;
}

}  // namespace camber
