module;
#include <algorithm>
#include <array>
#include <cstddef>
export module camber.cavity:locate;
import camber.core;
import :mesh;

export namespace camber {

/// Where a point lies in a mesh: in the inside of the simplex that some vertices of an element make. All of them: the
/// element itself; D: a face; one: at that vertex.
template <int D>
struct PointSite {
    ElementId element;
    std::array<bool, D + 1> spans{};  ///< whether that local vertex is one of them

    /// Of the simplex.
    [[nodiscard]] int dimension() const { return static_cast<int>(std::ranges::count(spans, true)) - 1; }
    friend bool operator==(const PointSite&, const PointSite&) = default;
};

/// A point counts as on a face of an element from which it is no farther than this share of the height over it: nearer
/// ones are rounding, such as that of the middle of an edge, and would make elements as flat.
inline constexpr double near_share = 1e-9;

/// The site of a point. Walks from element to element, from `hint` on (any element where it is none of the mesh's),
/// across faces that the point lies beyond; where that ends at the boundary, as beside a hole, all elements are looked
/// at. The signs that decide are exact: with `near` 0 the point lies there without any rounding. Points that are as
/// near to the boundary from the outside lie on it. Nothing lies in inverted elements. Errors (input): the point is not
/// in the mesh; a coordinate is no number.
template <int D>
[[nodiscard]] Outcome<PointSite<D>> locate(const DynamicMesh<D>& mesh, const Vec<D>& point, ElementId hint = {},
                                           double near = near_share);

}  // namespace camber
