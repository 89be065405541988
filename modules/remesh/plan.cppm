module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>
export module camber.remesh:plan;
import camber.core;
import camber.metric;
import camber.dynamic;
import camber.surface;
import :state;

export namespace camber {

/// The P1 cavity operator (paper §1.3): a cavity and a point, joined, judged, corrected where that helps.

/// An operation as it is wished for.
template <int D>
struct CavityWish {
    CavityParts<D> cavity;
    VertexId point;          ///< of the mesh; invalid: a new one
    Vec<D> place;            ///< of a new one, or where it moves
    VertexMetric<D> metric;  ///< there
    /// The first so many of the cavity's elements hold the point; the others may leave it again to make it fit.
    std::size_t holders = 0;
    Reference reference = 0;
    GeometryPlace lies = {};  ///< where `place` is on the geometry

    /// To a vertex as it is.
    void join_to(const Remeshing<D>& r, VertexId v) {
        point = v;
        place = r.mesh.points[v];
        metric = r.metrics[v];
        if (!r.places.empty()) lies = r.places[v];
    }
};

/// What is asked of the new simplices.
struct PatchLimits {
    double least_shape = 0;  ///< metric_shape of each new element: above this
    /// Where it is given, above this share of the worst element that is replaced is enough.
    std::optional<double> share_of_replaced = {};
    double shortest = 0, longest = std::numeric_limits<double>::infinity();  ///< edges at the point, in the metric
    double least_height = 0;                                                 ///< of new elements, in the point's metric
    /// The least cosine between a new facet's normal and those of the facets that it replaces.
    double facet_cosine = 0.8;
    /// Elements that may join the cavity, or leave it, to make it fit.
    int corrections = 8;
};

/// Why a wish was not granted. The first are those of StarFailure.
enum class RejectionReason : std::uint8_t {
    none,
    empty,
    required,  ///< also: a corner, or a vertex without all of its elements, would move
    surface,
    line,
    ball,
    exists,
    volume,    ///< an element would be inverted, or have no volume
    quality,   ///< an element below least_shape
    length,    ///< an edge at the point out of bounds
    geometry,  ///< facets would turn too far, or be too far from the geometry
    waits,     ///< another patch was in the way: in a later round
    wall,      ///< an element would have two facets on one smooth, curved surface
    height,    ///< an element below least_height, or so flat that the rounding of coordinates could invert it
};
[[nodiscard]] constexpr auto words(RejectionReason) {
    using R = RejectionReason;
    return words_of(Word{R::none, "none"}, Word{R::empty, "empty"}, Word{R::required, "required"},
                    Word{R::surface, "surface"}, Word{R::line, "line"}, Word{R::ball, "ball"},
                    Word{R::exists, "exists"}, Word{R::volume, "volume"}, Word{R::quality, "quality"},
                    Word{R::length, "length"}, Word{R::wall, "wall"}, Word{R::height, "height"},
                    Word{R::geometry, "geometry"}, Word{R::waits, "waits"});
}
inline constexpr std::size_t rejection_reasons = words(RejectionReason{}).size();

template <int D>
struct PlanWorkspace {
    StarWorkspace<D> star;
    CavityParts<D> cavity;
    std::vector<std::size_t> pieces;  ///< of the cavity's facets
};

/// What came of a wish.
struct PlanResult {
    RejectionReason rejected = RejectionReason::none;
    double worst_shape = 0;  ///< of the new elements, where nothing is rejected
    int corrections = 0;
};

/// Joins and judges: the signs of volumes are exact. `out` means something only where nothing is rejected; the mesh is
/// as it was in any case. Where an element would be inverted or bad, the one that it comes of leaves the cavity if it
/// may (see `holders`), otherwise the one across its outer face joins it: up to `corrections` times.
template <int D>
[[nodiscard]] PlanResult plan(const Remeshing<D>& r, const CavityWish<D>& wish, const PatchLimits& limits,
                              PlanWorkspace<D>& workspace, TopologyPatch<D>& out);

}  // namespace camber
