module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>
export module camber.solution_metric:fixed_metrics;
import camber.core;
import camber.metric;

export namespace camber {

/// Metrics at some vertices of a mesh. If a vertex has several metrics, they are intersected.
template <int D>
struct MetricsAtVertices {
    Column<VertexId> vertices;
    Column<LogMetric<D>> log_metrics;
};

enum class ReferencedEntity : std::uint8_t { facets, edges, vertices, elements };
[[nodiscard]] constexpr auto words(ReferencedEntity) {
    return words_of(Word{ReferencedEntity::facets, "facets"}, Word{ReferencedEntity::edges, "edges"},
                    Word{ReferencedEntity::vertices, "vertices"}, Word{ReferencedEntity::elements, "elements"});
}

struct ReferenceSize {
    std::vector<Reference> references;
    double size = 0;  ///< model units
    ReferencedEntity of = ReferencedEntity::facets;

    [[nodiscard]] static constexpr auto options() {
        using S = ReferenceSize;
        return std::tuple(
            option("references", &S::references, "references of the entities with this size")
                .count(1, 100000)
                .required(),
            option("size", &S::size, "size in all directions at the vertices of these entities")
                .unit("model units")
                .above(0)
                .required(),
            option("entities", &S::of,
                   "kind of the entities with these references: facets of the boundary and of interfaces, feature "
                   "edges, vertices, or elements"));
    }
    friend bool operator==(const ReferenceSize&, const ReferenceSize&) = default;
};

/// Returns isotropic metrics with the sizes requested for references. Vertices with several sizes get the smallest one.
/// Errors (usage): a size that is not a positive length; a reference without simplices.
template <int D>
[[nodiscard]] Outcome<MetricsAtVertices<D>> sizes_by_reference(const LinearMesh<D>& mesh,
                                                               std::span<const ReferenceSize> sizes);

/// Patch number of facets that are ignored.
inline constexpr std::uint32_t no_patch = 0xffffffffU;

struct ChordOptions {
    double chord_error = 0;    ///< δ: largest distance of a chord's middle from the surface; 0: unlimited
    double angle = 0;          ///< α: largest angle between the surface normals along a chord, degrees; 0: unlimited
    double normal_ratio = 10;  ///< size along the normal, divided by the smallest tangential size

    [[nodiscard]] static constexpr auto options() {
        using S = ChordOptions;
        return std::tuple(option("chord_error", &S::chord_error,
                                 "largest distance of a chord from the surface; 0: no "
                                 "limit")
                              .unit("model units")
                              .at_least(0),
                          option("angle", &S::angle, "largest turn of the surface along a chord; 0: no limit")
                              .unit("degrees")
                              .at_least(0)
                              .at_most(180),
                          option("normal_ratio", &S::normal_ratio,
                                 "size along the normal, as a multiple of the smallest size along the surface")
                              .at_least(1));
    }
    friend bool operator==(const ChordOptions&, const ChordOptions&) = default;
};

/// Returns metrics that resolve the curvature of facets, at their vertices. For principal curvatures κ_i, the
/// tangential sizes are
///
///     h_i = min(sqrt(8 δ/|κ_i|), α/|κ_i|).
///
/// The normal size is `normal_ratio` times the smallest h_i. No size exceeds `largest`. `patches` is the number of each
/// facet's smooth patch (`Features::patches` of camber.surface); facets of `no_patch` are ignored. The metrics of all
/// patches at a vertex are intersected. Curvatures: docs/algorithms/metric-from-solution.md. Errors (usage): options
/// out of range; not one patch per facet; stopped.
template <int D>
[[nodiscard]] Outcome<MetricsAtVertices<D>> chord_metrics(const LinearMesh<D>& mesh,
                                                          const Column<std::uint32_t>& patches,
                                                          const ChordOptions& options, double largest,
                                                          const Execution& execution);
template <int D>
[[nodiscard]] Outcome<MetricsAtVertices<D>> chord_metrics(const QuadraticMesh<D>& mesh,
                                                          const Column<std::uint32_t>& patches,
                                                          const ChordOptions& options, double largest,
                                                          const Execution& execution);

struct GapOptions {
    double elements = 0;

    [[nodiscard]] static constexpr auto options() {
        return std::tuple(
            option("elements", &GapOptions::elements, "number of elements across a gap").above(0).required());
    }
    friend bool operator==(const GapOptions&, const GapOptions&) = default;
};

/// Returns metrics for thin parts of the domain, at vertices of facets. From each vertex, rays enter the domain along
/// the mean normal of the facets of each patch (`patches` as in `chord_metrics`), on both sides if both have elements.
/// Facets of `no_patch` send no ray but can be hit. The first facet hit, at distance t, bounds a gap if its normal is
/// within 45 degrees of the ray; otherwise the facets form a corner, and the ray yields no metric. In a gap, the size
/// is t/`elements` along the ray and `largest` in other directions. The metrics of all rays from a vertex are
/// intersected. Vertices with t/`elements` ≥ `largest` have no metric.
///
/// Facets at the vertex, or within 1 degree of the ray, are never hit. Towards sharp edges sizes fall to 0 (see
/// `min_size`). Facets count as straight and should bound the whole domain: a ray that leaves it elsewhere hits
/// nothing. Errors (usage): options out of range; `largest` is not a length; not one patch per facet; memory; stopped.
template <int D>
[[nodiscard]] Outcome<MetricsAtVertices<D>> gap_metrics(const LinearMesh<D>& mesh, const Column<std::uint32_t>& patches,
                                                        const GapOptions& options, double largest,
                                                        const Execution& execution);

/// Intersects all metrics at each vertex with the isotropic metric of size `largest`. Errors (usage): columns of
/// another mesh; vertices or sizes out of range; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> fixed_metric(const LinearMesh<D>& mesh,
                                                         std::span<const MetricsAtVertices<D>> at_some,
                                                         std::span<const Column<LogMetric<D>>> at_all, double largest,
                                                         const Execution& execution);

}  // namespace camber

namespace camber {

/// Facets of one patch around a vertex.
using Side = std::span<const FacetId>;

/// Returns the normal of a facet times its length (2D) or twice its area (3D); `columns` are its edge vectors at a
/// corner.
[[nodiscard]] inline Vec<2> area_normal(const std::array<Vec<2>, 1>& columns) {
    return {{columns[0][1], -columns[0][0]}};
}
[[nodiscard]] inline Vec<3> area_normal(const std::array<Vec<3>, 2>& columns) { return cross(columns[0], columns[1]); }

[[nodiscard]] inline std::array<Vec<2>, 1> tangents_of(const Vec<2>& n) { return {Vec<2>{{-n[1], n[0]}}}; }
[[nodiscard]] inline std::array<Vec<3>, 2> tangents_of(const Vec<3>& n) {
    int least = 0;
    for (int i = 1; i < 3; ++i)
        if (std::abs(n[i]) < std::abs(n[least])) least = i;
    Vec<3> axis;
    axis[least] = 1;
    const Vec<3> a = normalised(cross(n, axis));
    return {a, cross(n, a)};
}

template <int D>
[[nodiscard]] Vec<D> area_normal(const LinearMesh<D>& mesh, FacetId f) {
    const auto& v = mesh.facets.vertices[f];
    std::array<Vec<D>, D - 1> columns;
    for (int i = 0; i < D - 1; ++i) columns[i] = mesh.points[v[i + 1]] - mesh.points[v[0]];
    return area_normal(columns);
}

template <int D>
[[nodiscard]] Vec<D> to_side_of(const Vec<D>& n, const Vec<D>& side) {
    return dot(n, side) < 0 ? -n : n;
}

/// Calls `visit(side)` for the facets of each patch in `ball`, by ascending patch number. `facets` is a work array.
template <class Visit>
void each_side(std::span<const FacetId> ball, const Column<std::uint32_t>& patches, std::vector<FacetId>& facets,
               Visit&& visit) {
    facets.assign(ball.begin(), ball.end());
    std::erase_if(facets, [&](FacetId f) { return patches[f] == no_patch; });
    std::stable_sort(facets.begin(), facets.end(), [&](FacetId a, FacetId b) { return patches[a] < patches[b]; });
    for (std::size_t first = 0, last = 0; first < facets.size(); first = last) {
        while (last < facets.size() && patches[facets[last]] == patches[facets[first]]) ++last;
        visit(Side(facets.data() + first, last - first));
    }
}

/// Errors (usage): `largest` is not a length; not one patch per facet.
template <int D>
[[nodiscard]] Outcome<Done> check_sides(const LinearMesh<D>& mesh, const Column<std::uint32_t>& patches,
                                        double largest) {
    if (!(largest >= min_length) || !(largest <= max_length))
        return fail(ErrorKind::usage, "the largest size must be positive and finite");
    if (patches.size() != mesh.facets.size())
        return fail(ErrorKind::usage, "the patches belong to another mesh; there must be one per facet");
    return Done{};
}

}  // namespace camber
