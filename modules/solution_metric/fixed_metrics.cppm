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

/// Metrics at some vertices; a vertex may have several, which are intersected.
template <int D>
struct MetricsAtVertices {
    Column<VertexId> vertices;
    Column<LogMetric<D>> log_metrics;  ///< one each
};

/// Which simplices of a mesh have a reference.
enum class ReferencesOf : std::uint8_t { facets, edges, vertices, elements };
[[nodiscard]] constexpr auto words(ReferencesOf) {
    return words_of(Word{ReferencesOf::facets, "facets"}, Word{ReferencesOf::edges, "edges"},
                    Word{ReferencesOf::vertices, "vertices"}, Word{ReferencesOf::elements, "elements"});
}

/// A size for all simplices of a kind that have one of the references.
struct ReferenceSize {
    std::vector<Reference> references;
    double size = 0;  ///< model units
    ReferencesOf of = ReferencesOf::facets;

    [[nodiscard]] static constexpr auto options() {
        using S = ReferenceSize;
        return std::tuple(
            option("references", &S::references, "of what has the size").count(1, 100000).required(),
            option("size", &S::size, "in all directions, at its vertices").unit("model units").above(0).required(),
            option("entities", &S::of,
                   "what has these references: facets of the boundary and of interfaces, feature edges, "
                   "vertices, or elements"));
    }
    friend bool operator==(const ReferenceSize&, const ReferenceSize&) = default;
};

/// The isotropic metrics of such sizes at the vertices of the simplices, the least of several. Errors (usage): a size
/// that is not a positive length, a reference that nothing of the kind has.
template <int D>
[[nodiscard]] Outcome<MetricsAtVertices<D>> sizes_by_reference(const LinearMesh<D>& mesh,
                                                               std::span<const ReferenceSize> sizes);

/// Of a facet that is on no patch: it has no say.
inline constexpr std::uint32_t no_patch = 0xffffffffU;

/// How far chords may be from the geometry that they stand for.
struct ChordOptions {
    double chord_error = 0;    ///< δ: of a chord's middle from the surface; 0: not asked
    double angle = 0;          ///< α: by which the surface turns along a chord (degrees); 0: not asked
    double normal_ratio = 10;  ///< of the size along the normal to the least size along the surface

    [[nodiscard]] static constexpr auto options() {
        using S = ChordOptions;
        return std::tuple(option("chord_error", &S::chord_error, "largest distance of a chord from the surface; 0: any")
                              .unit("model units")
                              .at_least(0),
                          option("angle", &S::angle, "largest turn of the surface along a chord; 0: any")
                              .unit("degrees")
                              .at_least(0)
                              .at_most(180),
                          option("normal_ratio", &S::normal_ratio,
                                 "size along the normal, at most so many times the least along the surface")
                              .at_least(1));
    }
    friend bool operator==(const ChordOptions&, const ChordOptions&) = default;
};

/// The geometry's own metric at the vertices of facets. A chord of length h of a circle of curvature κ is h²κ/8 from
/// it, so along a surface of principal curvatures κ_i
///
///     h_i = min(sqrt(8 δ/|κ_i|), α/|κ_i|),    along the normal `normal_ratio` times the least of these,
///
/// and no size is above `largest`. Curvatures are one-sided: `patches` says of each facet on which smooth piece of the
/// boundary it is (Features::patches of camber.surface), facets of `no_patch` have no say, and the metrics of the
/// patches that meet at a vertex are intersected. Of a mesh of degree 2 they are those of its facets at the vertex,
/// averaged by area; of a straight mesh those of the quadratic through the patch's vertices around, two rings of them,
/// by least squares weighted by 1/r²; where these are too few, of one ring or none. What faces it across a gap is
/// another matter (`gap_metrics`). Errors (usage): limits of options, patches that are not one a facet; stopped.
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

/// How finely thin parts of the domain are to be resolved.
struct GapOptions {
    double elements = 0;  ///< across a gap; need not be whole

    [[nodiscard]] static constexpr auto options() {
        return std::tuple(option("elements", &GapOptions::elements, "how many elements there shall be across a gap")
                              .above(0)
                              .required());
    }
    friend bool operator==(const GapOptions&, const GapOptions&) = default;
};

/// Metrics where the domain is thin, at the vertices of facets. From such a vertex a ray goes into the domain, along
/// the mean normal of the facets of one patch (`patches` as in `chord_metrics`; facets of `no_patch` are met, but send
/// none); where facets have elements on both sides each side has its own ray. The first facet that it meets after a way
/// t is across a gap if it faces: its own normal turned against the ray's by less than 45 degrees. Walls that meet at a
/// wider angle are a corner: they are nearer to each other's end than to each other. The size is t/`elements` along the
/// normal, `largest` along the wall, and a vertex where t/`elements` is not below `largest` has no metric; those of the
/// sides that meet at one are intersected.
///
/// Facets that touch the vertex are not met, nor those that the ray runs along (by a degree): the walls beside a rim.
/// Of two walls that meet at a sharp angle sizes fall to 0 towards the edge in which they do, which has no metric
/// itself: `min_size` ends that. Facets are taken as straight, and all that bounds the domain should be among them: a
/// ray that leaves it elsewhere finds nothing. Errors (usage): limits of options, a largest size that is no length,
/// patches that are not one a facet; memory; stopped.
template <int D>
[[nodiscard]] Outcome<MetricsAtVertices<D>> gap_metrics(const LinearMesh<D>& mesh, const Column<std::uint32_t>& patches,
                                                        const GapOptions& options, double largest,
                                                        const Execution& execution);

/// One metric a vertex: the largest size, intersected with all that is given at some and at all vertices. Errors
/// (usage): columns that are not of this mesh, vertices out of range, sizes out of range; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> fixed_metric(const LinearMesh<D>& mesh,
                                                         std::span<const MetricsAtVertices<D>> at_some,
                                                         std::span<const Column<LogMetric<D>>> at_all, double largest,
                                                         const Execution& execution);

}  // namespace camber

namespace camber {

/// The facets of one patch around a vertex: one smooth side of the boundary.
using Side = std::span<const FacetId>;

/// n times the measure of a facet whose edges at a corner are `columns`.
[[nodiscard]] inline Vec<2> area_normal(const std::array<Vec<2>, 1>& columns) {
    return {{columns[0][1], -columns[0][0]}};
}
[[nodiscard]] inline Vec<3> area_normal(const std::array<Vec<3>, 2>& columns) { return cross(columns[0], columns[1]); }

/// Unit vectors, orthonormal with n.
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

/// Of a straight facet.
template <int D>
[[nodiscard]] Vec<D> area_normal(const LinearMesh<D>& mesh, FacetId f) {
    const auto& v = mesh.facets.vertices[f];
    std::array<Vec<D>, D - 1> columns;
    for (int i = 0; i < D - 1; ++i) columns[i] = mesh.points[v[i + 1]] - mesh.points[v[0]];
    return area_normal(columns);
}

/// A vector turned to the side of another.
template <int D>
[[nodiscard]] Vec<D> to_side_of(const Vec<D>& n, const Vec<D>& side) {
    return dot(n, side) < 0 ? -n : n;
}

/// visit(side) for each side at a vertex with the facets `ball`, by rising patch; they are put into `facets`.
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

/// Errors (usage): a largest size that is no length, patches that are not one a facet.
template <int D>
[[nodiscard]] Outcome<Done> check_sides(const LinearMesh<D>& mesh, const Column<std::uint32_t>& patches,
                                        double largest) {
    if (!(largest >= min_length) || !(largest <= max_length))
        return fail(ErrorKind::usage, "the largest size must be positive and finite");
    if (patches.size() != mesh.facets.size())
        return fail(ErrorKind::usage, "the patches are of another mesh: there must be one a facet");
    return Done{};
}

}  // namespace camber
