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

/// Random generator in which a number depends only on the seed and its index. Standard distributions are not used
/// because they are not portable.
struct Noise {
    std::uint64_t seed = 1;

    /// 64 random bits for (seed, a, b), from two SplitMix64 finalisers.
    [[nodiscard]] constexpr std::uint64_t bits(std::uint64_t a, std::uint64_t b = 0) const {
        return mixed_bits(mixed_bits(seed + 0x9e3779b97f4a7c15ULL * (a + 1)) + 0xd1b54a32d192ed03ULL * (b + 1));
    }
    /// Random number in [−1, 1) with 53 bits.
    [[nodiscard]] constexpr double symmetric(std::uint64_t a, std::uint64_t b = 0) const {
        return static_cast<double>(bits(a, b) >> 11U) * 0x1p-52 - 1.0;
    }
    /// Random vector with coordinates in [−1, 1).
    template <int D>
    [[nodiscard]] constexpr Vec<D> vector(std::uint64_t a, std::uint64_t b = 0) const {
        Vec<D> v;
        for (int i = 0; i < D; ++i) v[i] = symmetric(a, b * D + i);
        return v;
    }
    /// Generator number i, independent of the others.
    [[nodiscard]] constexpr Noise stream(std::uint64_t i) const { return {bits(i, 0x5eedULL)}; }
};

/// Moves points to `moved`. If the volume of an element would fall below `least` times its old volume, the moves of its
/// vertices are halved, several times and at last to zero. Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Done> move_points(Buffer<Vec<D>>& points, std::span<const Vec<D>> moved,
                                        std::span<const SimplexVertices<D>> elements, double least,
                                        const Execution& execution = {});

/// Minimum ratio of new to old volume of an element in random moves.
inline constexpr double min_jittered_volume_ratio = 0.2;

/// Maximum number of halvings. So an element affects only points within this number of rings of elements.
inline constexpr int rings_of_move = 12;

/// Function that returns the target of a point. It is called again at each halving.
template <int D>
using Moved = std::function<Vec<D>(std::size_t)>;
/// Function f(just_moved, look) that passes all elements to `look`, in parts. It may omit elements without a vertex in
/// `just_moved`.
template <int D>
using ElementRuns =
    std::function<Outcome<Done>(std::span<const std::uint8_t> just_moved,
                                const std::function<Outcome<Done>(std::span<const SimplexVertices<D>>)>& look)>;

/// Moves points as the function above does, for elements that are not all in memory.
template <int D>
[[nodiscard]] Outcome<Done> move_points(Buffer<Vec<D>>& points, const Moved<D>& moved, const ElementRuns<D>& runs,
                                        double least, const Execution& execution = {});

/// Cuts a row of prisms over (D − 1)-simplices into D elements each. Copies of base vertex v are bottom(v) and top(v).
/// The edges of a base simplex and the direction to the top must be positively oriented.
///
/// The diagonal of a quadrilateral goes from the bottom copy of the vertex with the lower rank to the top copy of the
/// other vertex. So neighbouring prisms conform, and the cyclic cut, which has no tetrahedra, does not occur. Random
/// ranks avoid patterns. Errors: stopped.
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
        for (int step = 0; step < D; ++step) {  // the element has the bottom and the top copy of vertex number `step`
            SimplexVertices<D> element;
            for (int i = 0; i <= step; ++i) element[i] = bottom(s[i]);
            for (int i = step; i < D; ++i) element[i + 1] = top(s[i]);
            if (odd != ((D - 1 - step) % 2 == 1)) std::swap(element[0], element[1]);
            elements[D * k + step] = element;
        }
    });
}

/// Prisms between `rows` + 1 copies of `count` base vertices. Copy k of vertex v has the number v + k count.
template <int D>
struct PrismStack {
    std::span<const SimplexVertices<D - 1>> base;
    std::size_t count = 0, rows = 0;
};

/// Cuts all rows; the ranks of row k are those of noise.stream(first_stream + k). Errors: stopped.
template <int D>
[[nodiscard]] Outcome<Done> extrude_rows(const PrismStack<D>& stack, const Noise& noise, std::uint64_t first_stream,
                                         std::span<SimplexVertices<D>> elements, const Execution& execution) {
    const auto& [base, count, rows] = stack;
    const Execution quiet = without_progress(execution);  // otherwise the progress would restart in each row
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

template <int D>
using FacetReference = std::function<Reference(const SimplexVertices<D - 1>&)>;

/// Thread-safe function that is true for all vertices on facets, and possibly for others. Null: all vertices.
using MayHaveFacets = std::function<bool(VertexId)>;

/// Completes a generated mesh.
/// - Facets are the boundary, oriented outwards, and material interfaces, oriented out of the lower material.
/// - Vertices get the lowest reference of their facets (interior: 0).
/// - Corners are vertices with facets of at least D references; ridges (3D) are edges between facets of different
///   references.
///
/// Errors: usage (an element without positive volume: incompatible sizes); stopped.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> bounded_mesh(Buffer<Vec<D>> points, Buffer<SimplexVertices<D>> elements,
                                                  Buffer<Reference> materials, const FacetReference<D>& facet_reference,
                                                  const MayHaveFacets& may_have_facets = {},
                                                  const Execution& execution = {});

/// Completes a mesh whose elements all have material 1.
template <int D>
[[nodiscard]] Outcome<LinearMesh<D>> bounded_mesh(Buffer<Vec<D>> points, Buffer<SimplexVertices<D>> elements,
                                                  const FacetReference<D>& facet_reference,
                                                  const MayHaveFacets& may_have_facets = {},
                                                  const Execution& execution = {}) {
    Buffer<Reference> materials(elements.size(), Reference{1});
    return bounded_mesh<D>(std::move(points), std::move(elements), std::move(materials), facet_reference,
                           may_have_facets, execution);
}

template <int D>
[[nodiscard]] auto no_positive_volume(std::size_t element) {
    return fail(ErrorKind::usage, "the generator created an element without positive volume", {},
                Entity{simplex_name<D>, element + 1}, "use sizes that fit together");
}

/// Volume (2D: area) multiplied by D!.
[[nodiscard]] inline double determinant(const Column<Vec<2>>& p, const SimplexVertices<2>& s) {
    return det(p[s[1]] - p[s[0]], p[s[2]] - p[s[0]]);
}
[[nodiscard]] inline double determinant(const Column<Vec<3>>& p, const SimplexVertices<3>& s) {
    return det(p[s[1]] - p[s[0]], p[s[2]] - p[s[0]], p[s[3]] - p[s[0]]);
}

/// Delaunay triangulation of the points' convex hull. Elements are positively oriented and in a reproducible order.
///
/// Predicates are exact in 128 bits for points on a grid of 2^23 steps across the bounding box. Elements flatter than a
/// grid step may be inverted for the original points. Errors: usage (fewer than D + 1 points, all coplanar, two equal
/// on the grid).
template <int D>
[[nodiscard]] Outcome<Buffer<SimplexVertices<D>>> delaunay(std::span<const Vec<D>> points, const Noise& noise);

/// Unit vectors on a spiral with the golden angle (2D: at equal angles), randomly rotated.
template <int D>
[[nodiscard]] Buffer<Vec<D>> spread_points(std::size_t n, const Noise& noise);

/// Unit vectors and facets between them, counter-clockwise seen from outside.
template <int D>
struct UnitSphere {
    Buffer<Vec<D>> points;
    Buffer<SimplexVertices<D - 1>> facets;
};

/// Icosahedron with edges divided into n parts, projected onto the sphere: 10 n² + 2 vertices. 2D: 5 n edges.
template <int D>
[[nodiscard]] UnitSphere<D> icosphere(int n);

}  // namespace camber
