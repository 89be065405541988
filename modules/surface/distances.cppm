module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <tuple>
#include <vector>
export module camber.surface:distances;
import camber.core;
import camber.box_tree;
import camber.bezier;
import :cubic;
import :features;
import :geometry;
import :geometry_places;

/// How far a curved boundary and its geometry are from each other, both ways and by the geometry's entities.
export namespace camber {

/// What is measured: from the boundary to the geometry; or both ways, by entity.
enum class DistanceWays : std::uint8_t { boundary, both };
[[nodiscard]] constexpr auto words(DistanceWays) {
    return words_of(Word{DistanceWays::boundary, "boundary"}, Word{DistanceWays::both, "both"});
}

/// The curved facets of a mesh to be searched for nearest points: each raised to degree 3, which is exact.
template <int D>
struct CurvedBoundary {
    Column<CubicSimplex<D - 1, D>> facets;
    BoxTree<D> tree;  ///< over the facets' control points
};
template <int D>
[[nodiscard]] Outcome<CurvedBoundary<D>> curved_boundary(const QuadraticMesh<D>& mesh,
                                                         std::span<const LagrangeNode<D>> mid_nodes,
                                                         const Execution& execution);

/// A place on it.
template <int D>
struct BoundaryFoot {
    FacetId facet;
    Barycentric<D - 1> xi{};
    Vec<D> point;
    double distance_squared = std::numeric_limits<double>::infinity();
};
/// The nearest point of all facets, the lowest facet of equally near ones; `near`: one that is not far, if one is
/// known. An invalid facet when there are none.
template <int D>
[[nodiscard]] BoundaryFoot<D> closest_on(const CurvedBoundary<D>& boundary, const Vec<D>& p, FacetId near = {});

/// What of a geometry stands over the facets of a mesh, and over its edges where two surfaces meet: the points at a
/// lattice of each facet, and of each edge, that GeometryModel::points_over and on_edge have there. For makers whose
/// surfaces have no end (a plane, a cylinder), or end where the mesh does (a surrogate): parts of a geometry that no
/// facet stands for are not seen. Errors: `features` is not of this mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<GeometrySamples<D>> samples_over(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                       const Geometry<D>& geometry, const Execution& execution);

/// One way: from points of one side to the nearest of the other (model units).
template <int D>
struct OneWay {
    std::size_t samples = 0;
    double largest = 0, mean = 0;  ///< the mean by area or length
    Vec<D> from, to;               ///< where it is largest
    FacetId facet = {};            ///< there; of a curve one beside it
};

/// Of one surface or curve. A facet without a surface (`GeometryKind::none`) is measured from its own plane.
template <int D>
struct EntityDistances {
    GeometryEntity entity;
    std::size_t pieces = 0;             ///< facets that lie on it; of a curve edges
    std::vector<Reference> references;  ///< of those facets, rising; of a curve those of facets beside it
    double measure = 0;                 ///< area or length of those pieces, straight
    bool is_flat = false;               ///< a plane, 2D a line, where a facet lies on it
    OneWay<D> to_geometry, to_boundary;
};

template <int D>
struct GeometryDistances {
    std::vector<EntityDistances<D>> entities;  ///< surfaces, then curves, by rising number
    OneWay<D> to_geometry, to_boundary;        ///< of all surfaces
    /// One a facet: the largest of its points from the geometry; and of the points of the geometry that it is nearest
    /// to (0: it is to none).
    Column<double> of_facets, to_facets;
};

/// From the boundary: each curved facet is sampled as by boundary_distance, and each edge on a curve at tenths. From
/// the geometry: each of its points to the nearest of all curved facets; of a curve to the nearest of the edges that
/// lie on it, where there are any. Errors: `features` or `mid_nodes` are not of this mesh (internal), stopped.
template <int D>
[[nodiscard]] Outcome<GeometryDistances<D>> distances_both_ways(
    const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes, const Features<D>& features,
    const Geometry<D>& geometry, const GeometrySamples<D>& samples, const Execution& execution);

}  // namespace camber

namespace camber {

/// The order in a list: surfaces, then curves, then what is on neither. A curve with a number is the same from
/// whichever sides it is seen.
[[nodiscard]] inline auto place_in_list(const GeometryEntity& entity) {
    const int rank = entity.kind == GeometryKind::surface ? 0 : entity.kind == GeometryKind::curve ? 1 : 2;
    const bool by_sides = entity.id == GeometryEntity::unnumbered;
    return std::tuple<int, std::int64_t, std::array<std::int64_t, 2>>(
        rank, entity.id, by_sides ? entity.sides : std::array<std::int64_t, 2>{});
}

/// α/N for all α: a lattice on a facet.
template <int N, int D>
inline constexpr auto facet_lattice = [] {
    std::array<Barycentric<D - 1>, node_count<N, D - 1>> all{};
    for (std::size_t n = 0; n < all.size(); ++n)
        for (std::size_t i = 0; i < D; ++i) all[n][i] = static_cast<double>(multi_indices<N, D - 1>[n][i]) / N;
    return all;
}();

/// Of the facet when straight: its area, 2D its length.
template <int D>
[[nodiscard]] double straight_measure(const FacetSite<D>& facet) {
    const auto& c = facet.corners;
    if constexpr (D == 2)
        return distance(c[0], c[1]);
    else
        return 0.5 * norm(cross(c[1] - c[0], c[2] - c[0]));
}

/// What a mesh has on each entity: facets on surfaces, edges on curves.
template <int D>
struct OnEntities {
    struct Entity {
        GeometryEntity entity;
        std::vector<std::uint32_t> pieces;  ///< rising
    };
    std::vector<Entity> surfaces, curves;
    Incidence<FacetId> shells;

    [[nodiscard]] EdgeSite<D> site(const QuadraticMesh<D>& mesh, const Features<D>& features, std::size_t e) const {
        const auto& [low, high] = mesh.edges.vertices[e];
        return {EdgeId(e),
                features.edge_kinds[e],
                {mesh.linear.points[low], mesh.linear.points[high]},
                facet_sites<D>(mesh.linear, shells[e])};
    }
};
/// Errors: stopped.
template <int D>
[[nodiscard]] Outcome<OnEntities<D>> find_on_entities(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                      const Geometry<D>& geometry, const Execution& execution);

}  // namespace camber
