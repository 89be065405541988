// Random numbers, jitter, extrusion, boundary facets, Delaunay triangulation, spheres.
module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
export module camber.shapes:delaunay;
import camber.core;

export namespace camber {

/// A counter-based generator: the n-th number depends on the seed and on n alone, not on what was drawn before. (The
/// distributions of the standard library differ between libraries.)
struct Noise {
    std::uint64_t seed = 1;

    /// 64 well-mixed bits of (seed, a, b): two rounds of the finaliser of SplitMix64.
    [[nodiscard]] constexpr std::uint64_t bits(std::uint64_t a, std::uint64_t b = 0) const {
        return mixed_bits(mixed_bits(seed + 0x9e3779b97f4a7c15ULL * (a + 1)) + 0xd1b54a32d192ed03ULL * (b + 1));
    }
    /// Uniform in [−1, 1), 53 bits.
    [[nodiscard]] constexpr double symmetric(std::uint64_t a, std::uint64_t b = 0) const {
        return static_cast<double>(bits(a, b) >> 11U) * 0x1p-52 - 1.0;
    }
    /// Each coordinate uniform in [−1, 1).
    template <int D>
    [[nodiscard]] constexpr Vec<D> vector(std::uint64_t a, std::uint64_t b = 0) const {
        Vec<D> v;
        for (int i = 0; i < D; ++i) v[i] = symmetric(a, b * D + i);
        return v;
    }
    /// Another independent generator.
    [[nodiscard]] constexpr Noise stream(std::uint64_t i) const { return {bits(i, 0x5eedULL)}; }
};

/// Moves the points to `moved`, but where that would leave an element less than `least` of its volume, only a half, a
/// quarter … of the way (its vertices, again and again until no element complains). Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Done> move_points(Buffer<Vec<D>>& points, std::span<const Vec<D>> moved,
                                        std::span<const SimplexVertices<D>> elements, double least,
                                        const Execution& execution = {});

/// The part of its volume that random moves leave an element.
inline constexpr double least_jittered = 0.2;

/// So many times a move is halved at most, and so many rings of elements around a point decide where it comes to lie.
inline constexpr int rings_of_move = 12;

/// Where a point is to go. It is asked for again where the way is halved.
template <int D>
using Moved = std::function<Vec<D>(std::size_t)>;
/// Elements that are made run by run: f(those that just moved, look) calls look(elements) for all runs, or all that
/// have a vertex which has just moved.
template <int D>
using ElementRuns =
    std::function<Outcome<Done>(std::span<const std::uint8_t> just_moved,
                                const std::function<Outcome<Done>(std::span<const SimplexVertices<D>>)>& look)>;

/// The same of elements that are not there all at once.
template <int D>
[[nodiscard]] Outcome<Done> move_points(Buffer<Vec<D>>& points, const Moved<D>& moved, const ElementRuns<D>& runs,
                                        double least, const Execution& execution = {});

/// One row of prisms over simplices of dimension D − 1, cut to the D-simplices `elements`, D for each. Base vertex v
/// becomes bottom(v) below and top(v) above; a base simplex is oriented such that (its edges, the way from bottom to
/// top) is a positive frame.
///
/// Vertices have a random order by `ranks`, drawn for the row, and each quadrilateral is cut from its lesser vertex
/// below to its greater one above: neighbours agree, no prism gets the cyclic cut that has no tetrahedra, and no
/// pattern shows. Errors: stopped.
template <int D, class Bottom, class Top>
[[nodiscard]] Outcome<Done> extrude(std::span<const SimplexVertices<D - 1>> base, std::span<const std::uint64_t> ranks,
                                    Bottom&& bottom, Top&& top, std::span<SimplexVertices<D>> elements,
                                    const Execution& execution) {
    const auto precedes = [&](VertexId a, VertexId b) {
        return std::pair(ranks[a.index()], a) < std::pair(ranks[b.index()], b);
    };
    return each(execution, base.size(), [&](std::size_t k) {
        SimplexVertices<D - 1> s = base[k];
        bool odd = false;
        for (int i = 1; i < D; ++i)
            for (int j = i; j > 0 && precedes(s[j], s[j - 1]); --j) {
                std::swap(s[j], s[j - 1]);
                odd = !odd;
            }
        for (int step = 0; step < D; ++step) {  // goes up at vertex `step`
            SimplexVertices<D> element;
            for (int i = 0; i <= step; ++i) element[i] = bottom(s[i]);
            for (int i = step; i < D; ++i) element[i + 1] = top(s[i]);
            if (odd != ((D - 1 - step) % 2 == 1)) std::swap(element[0], element[1]);
            elements[D * k + step] = element;
        }
    });
}

/// Rows of prisms, one on the other, over `rows` + 1 copies of the `count` vertices of a base: copy k of vertex v is
/// v + k count.
template <int D>
struct PrismStack {
    std::span<const SimplexVertices<D - 1>> base;
    std::size_t count = 0, rows = 0;
};

/// The elements of a stack. Row k is cut by noise.stream(first_stream + k). Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Done> extrude_rows(const PrismStack<D>& stack, const Noise& noise, std::uint64_t first_stream,
                                         std::span<SimplexVertices<D>> elements, const Execution& execution) {
    const auto& [base, count, rows] = stack;
    const Execution quiet = without_progress(execution);  // each row is a loop of its own
    Buffer<std::uint64_t> ranks(count);
    for (std::size_t k = 0; k < rows; ++k) {
        const Noise of_row = noise.stream(first_stream + k);
        auto drawn = each(quiet, count, [&](std::size_t v) { ranks[v] = of_row.bits(v); });
        if (!drawn) return drawn;
        auto done = extrude<D>(
            base, ranks, [&](VertexId v) { return VertexId(k * count + v.index()); },
            [&](VertexId v) { return VertexId((k + 1) * count + v.index()); },
            elements.subspan(k * D * base.size(), D * base.size()), quiet);
        if (!done) return done;
    }
    return Done{};
}

/// The reference of a boundary facet, from its vertices.
template <int D>
using FacetReference = std::function<Reference(const SimplexVertices<D - 1>&)>;

/// Whether a vertex may have facets: true at all that have, asked from any thread. Where it is false nothing is looked
/// for, which makes large meshes fast. None: nothing is known.
using MayHaveFacets = std::function<bool(VertexId)>;

/// A whole mesh from its points and elements: facets on the boundary, outwards oriented, and between elements of
/// different materials, out of the one of lower number; vertices with the least reference of their facets, inner ones
/// with 0; where references meet, corners (2D) or ridges and corners (3D: where ridges end or more than two meet).
/// Errors: an element without positive volume (usage: the sizes do not fit together); stopped.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> bounded_mesh(Buffer<Vec<D>> points, Buffer<SimplexVertices<D>> elements,
                                                  Buffer<Reference> materials, const FacetReference<D>& facet_reference,
                                                  const MayHaveFacets& may_have_facets = {},
                                                  const Execution& execution = {});

/// The same of one material: reference 1.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> bounded_mesh(Buffer<Vec<D>> points, Buffer<SimplexVertices<D>> elements,
                                                  const FacetReference<D>& facet_reference,
                                                  const MayHaveFacets& may_have_facets = {},
                                                  const Execution& execution = {}) {
    Buffer<Reference> materials(elements.size(), Reference{1});
    return bounded_mesh<D>(std::move(points), std::move(elements), std::move(materials), facet_reference,
                           may_have_facets, execution);
}

/// The error of the element of that number.
template <int D>
[[nodiscard]] auto no_positive_volume(std::size_t element) {
    return fail(ErrorKind::usage, "the generator made an element without positive volume", {},
                Entity{simplex_name<D>, element + 1}, "the sizes do not fit together");
}

/// D! times the volume (area in 2D) of an element.
[[nodiscard]] inline double determinant(const Column<Vec<2>>& p, const SimplexVertices<2>& s) {
    return det(p[s[1]] - p[s[0]], p[s[2]] - p[s[0]]);
}
[[nodiscard]] inline double determinant(const Column<Vec<3>>& p, const SimplexVertices<3>& s) {
    return det(p[s[1]] - p[s[0]], p[s[2]] - p[s[0]], p[s[3]] - p[s[0]]);
}

/// The Delaunay triangulation of points (of their convex hull), positively oriented, in a fixed order.
///
/// Points are compared on a grid of 2^23 steps across their box, where the predicates are exact in 128-bit integers:
/// the result is sound on the grid; an element flatter than the grid's step may be inverted in the points themselves.
/// Errors: usage (fewer than D + 1 points, all in one plane, two in the same place on the grid).
template <int D>
[[nodiscard]] Outcome<Buffer<SimplexVertices<D>>> delaunay(std::span<const Vec<D>> points, const Noise& noise);

/// n points spread evenly over the unit sphere along a golden-angle spiral (over the unit circle in 2D: equal angles),
/// turned at random.
template <int D>
[[nodiscard]] Buffer<Vec<D>> spread_points(std::size_t n, const Noise& noise);

/// Triangles (edges of a circle in 2D) with vertices on the unit sphere, counter-clockwise seen from outside.
template <int D>
struct UnitSphere {
    Buffer<Vec<D>> points;
    Buffer<SimplexVertices<D - 1>> facets;
};

/// An icosahedron whose edges are cut into n, put on the unit sphere: 10 n² + 2 vertices (2D: 5 n edges).
template <int D>
[[nodiscard]] UnitSphere<D> icosphere(int n);

}  // namespace camber
