module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
export module camber.surface:edge_sheet;
import camber.core;
import :geometry;
import :geometry_places;
import :plane;

/// What the node of a boundary edge may move on, by what every geometry answers: unknowns are displacements in the
/// tangent plane of a place, followed by projection, which walks across a surrogate's facets.
export namespace camber {

/// The plane on which all facets at an edge lie, where they lie on one.
template <int D>
[[nodiscard]] std::optional<Plane<D>> common_plane(const GeometryModel<D>& geometry, const EdgeSite<D>& edge);

/// p moved by the part of `shift` that lies in the plane. A coordinate in which the plane is constant stays as it is.
template <int D>
[[nodiscard]] Vec<D> slid_within(const Plane<D>& plane, const Vec<D>& p, const Vec<D>& shift);

/// A place on a sheet: orthonormal tangents, the first along the edge (a curve has that alone), and the unit normal,
/// zero on a curve. `facet` is a surrogate's.
template <int D>
struct SheetPlace {
    Vec<D> point;
    std::array<Vec<D>, static_cast<std::size_t>(D - 1)> tangents{};
    Vec<D> normal;
    FacetId facet = {};
};

/// The one surface, plane or curve of a geometry that an edge lies on. `straight`: there is none, or a line, on which a
/// node that moves makes the same curve. It refers to the geometry and to the edge, which must outlive it. A node
/// stays on it: places beyond its rim, on another entity or on another leaf of it are no answer.
template <int D>
class EdgeSheet {
  public:
    enum class Kind : std::uint8_t { straight, plane, surface, curve };

    EdgeSheet(const GeometryModel<D>& geometry, const EdgeSite<D>& edge);

    [[nodiscard]] Kind kind() const { return kind_; }
    [[nodiscard]] int unknowns() const { return kind_ == Kind::curve ? 1 : D - 1; }

    /// Where the edge's node is; nothing where that is not on the sheet (to 1e-4 of the chord), or the sheet stands
    /// across the edge.
    [[nodiscard]] std::optional<SheetPlace<D>> place_of(const Vec<D>& node) const;
    /// The place near from.point + step, whose tangents are those of `from`, turned as little as may be. Nothing where
    /// the step is too long for the sheet: the foot is on another entity, farther away than half of the step or beyond
    /// the rim, the normal turns by more than 60°.
    [[nodiscard]] std::optional<SheetPlace<D>> moved(const SheetPlace<D>& from, const Vec<D>& step) const;
    /// The sheet's point nearest to p, searched from a place near it.
    [[nodiscard]] SurfaceFoot<D> foot(const SheetPlace<D>& near, const Vec<D>& p) const;
    /// Whether a node that began at `from` has left the facets of the surrogate that were at its edge.
    [[nodiscard]] bool has_walked(const SheetPlace<D>& from, const SheetPlace<D>& to) const;

  private:
    struct Found;
    [[nodiscard]] Found nearest(const FacetId& facet, const Vec<D>& p) const;
    [[nodiscard]] Vec<D> direction_at(const Found& found) const;
    [[nodiscard]] std::optional<SheetPlace<D>> framed(
        const Found& found, const std::array<Vec<D>, static_cast<std::size_t>(D - 1)>& near) const;

    const GeometryModel<D>* geometry_;
    const EdgeSite<D>* edge_;
    Kind kind_ = Kind::straight;
    GeometryEntity entity_;
    std::optional<Plane<D>> plane_;
};

}  // namespace camber
