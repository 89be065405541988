module;
#include <cstddef>
#include <vector>
export module camber.crossing:overlaps;
import camber.core;
import camber.bezier;
import :crossings;

export namespace camber {

/// Two elements with interior points in common.
template <int D>
struct ElementOverlap {
    ElementId first, second;  ///< the lower one first; equal if one of them alone certainly contains the point
    Vec<D> point;             ///< a point inside both, where they are straight (model units)
    friend bool operator==(const ElementOverlap&, const ElementOverlap&) = default;
};

/// The places where elements of a mesh overlap.
template <int D>
struct Overlaps {
    bool looked_at = false;       ///< false: no elements, or a boundary that is not closed
    std::size_t walls = 0;        ///< connected parts of the boundary along which nothing else touches it
    std::size_t undecided = 0;    ///< parts for which no certified answer was found
    std::size_t overlapping = 0;  ///< pairs of facets that touch, and parts of the boundary, inside other elements
    /// One pair of elements for each of the `overlapping`, without repetitions, by rising elements.
    std::vector<ElementOverlap<D>> found = {};

    friend bool operator==(const Overlaps&, const Overlaps&) = default;
};

/// Finds elements that overlap although no walls cross: bodies with sides in common planes, one body inside the
/// elements of another, a mesh that covers a region twice. Every answer is certified, rounding included. Method and
/// completeness: docs/algorithms/crossing.md.
///
/// `mesh` lists all boundary faces, its elements are numbered with positive orientation, and no element or facet occurs
/// twice; `crossings` is the result of `find_crossings` for the same mesh. Time: linear in elements, n log n in
/// boundary facets. Errors: memory, stopped.
template <int D>
[[nodiscard]] Outcome<Overlaps<D>> find_overlaps(const QuadraticMesh<D>& mesh, const Crossings& crossings,
                                                 const Execution& execution);

template <int D>
[[nodiscard]] Outcome<Overlaps<D>> find_overlaps(const LinearMesh<D>& mesh, const Crossings& crossings,
                                                 const Execution& execution);

/// The same with the search for crossings.
template <int D>
[[nodiscard]] Outcome<Overlaps<D>> find_overlaps(const QuadraticMesh<D>& mesh, const Execution& execution);

}  // namespace camber
