module;
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>
module camber.soundness:examination;
import camber.core;
import camber.validity;
import :defects;

namespace camber {

/// Marks in place of an element or a facet.
inline constexpr std::uint32_t nobody = 0xffffffffU;
inline constexpr std::uint32_t several = 0xfffffffeU;

/// What `examine` finds out of each entity, for `prepare` to act on.
template <int D>
struct Examination {
    Soundness soundness;
    Incidence<ElementId> elements_of;  ///< of each vertex
    Incidence<FacetId> facets_of;
    Buffer<std::uint32_t> element_twins;                  ///< the first earlier element of the same vertices, or nobody
    Buffer<std::uint32_t> facet_twins;                    ///< the same of facets
    Buffer<std::array<std::uint32_t, D + 1>> neighbours;  ///< across each face: an element, nobody or several
    Buffer<std::array<std::uint32_t, 2>> sides;           ///< the elements that have the facet as a face
    Buffer<std::uint8_t> unlisted;                        ///< bit i: face i is on the boundary, and no facet
    Buffer<std::uint8_t> interfaces;                      ///< bit i: face i is between references, no facet, and mine
    Buffer<std::uint8_t> turned;                          ///< 1: numbered the wrong way round

    [[nodiscard]] bool element_counts(std::size_t e) const { return element_twins[e] == nobody; }
    [[nodiscard]] bool facet_counts(std::size_t f) const { return facet_twins[f] == nobody; }
    [[nodiscard]] Finding& operator[](Defect defect) { return soundness.findings[static_cast<std::size_t>(defect)]; }
};

/// The vertices of the face opposite local vertex i, its normal outwards if the element is positive.
template <int D>
[[nodiscard]] inline SimplexVertices<D - 1> face_of(const SimplexVertices<D>& element, int opposite) {
    SimplexVertices<D - 1> face;
    const auto local = face_opposite<D>(opposite);
    for (int i = 0; i < D; ++i) face[i] = element[local[i]];
    return face;
}

template <std::size_t N>
[[nodiscard]] constexpr bool has(const std::array<VertexId, N>& simplex, VertexId v) {
    return std::find(simplex.begin(), simplex.end(), v) != simplex.end();
}

/// Every vertex of `part` is one of `whole`.
template <std::size_t N, std::size_t M>
[[nodiscard]] constexpr bool has_all(const std::array<VertexId, M>& whole, const std::array<VertexId, N>& part) {
    return std::all_of(part.begin(), part.end(), [&](VertexId v) { return has(whole, v); });
}

/// The vertex of the simplex with the fewest items around it.
template <std::size_t N, class Item>
[[nodiscard]] inline VertexId loneliest(const std::array<VertexId, N>& simplex, const Incidence<Item>& around) {
    return *std::min_element(simplex.begin(), simplex.end(),
                             [&](VertexId a, VertexId b) { return around[a].size() < around[b].size(); });
}

/// How many i in [0, n) are chosen, and the first.
template <class Chosen>
[[nodiscard]] Outcome<Finding> count(const Execution& execution, std::size_t n, Chosen&& chosen) {
    return reduce_each(
        execution, n, Finding{},
        [&](Finding& found, std::size_t i) {
            if (!chosen(i)) return;
            if (found.count == 0) found.first = i + 1;
            ++found.count;
        },
        [](const Finding& a, const Finding& b) {
            return a.count == 0 ? b : Finding{a.count + b.count, a.first, a.other};
        });
}

/// Points by a hash of their coordinates: those at one place share a bucket.
template <int D>
[[nodiscard]] inline std::size_t bucket_of(const Vec<D>& p, std::size_t buckets) {
    std::uint64_t h = 0;
    for (int c = 0; c < D; ++c) {
        h = (h ^ std::bit_cast<std::uint64_t>(p[c] + 0.0)) * 0x9e3779b97f4a7c15U;  // + 0.0: −0 is 0
        h ^= h >> 29U;
    }
    return static_cast<std::size_t>(h % buckets);
}

/// For each i in [0, n) the first earlier one at the same place, point(i), of those that counts(i) says and that
/// meets(i, earlier) accepts; or nobody. Of a crowd at one place only the first few are asked: no more than linear.
template <class Point, class Counts, class Meets>
[[nodiscard]] Outcome<Buffer<std::uint32_t>> coincident(std::size_t n, Point&& point, Counts&& counts, Meets&& meets,
                                                        const Execution& execution) {
    constexpr int max_asked = 32;
    auto bucket = map_each(part_of(execution, 0, 0.2), n, [&](std::size_t i) {
        return counts(i) ? static_cast<std::uint32_t>(bucket_of(point(i), n)) : nobody;
    });
    if (!bucket) return fail(bucket.error());
    Buffer<std::uint32_t> offsets(n + 1);
    std::fill(offsets.begin(), offsets.end(), 0U);
    for (const std::uint32_t b : *bucket)
        if (b != nobody) ++offsets[b + 1];
    std::partial_sum(offsets.begin(), offsets.end(), offsets.begin());
    Buffer<std::uint32_t> items(offsets.back());
    Buffer<std::uint32_t> cursor(offsets.begin(), offsets.end());
    for (std::size_t i = 0; i < n; ++i)
        if ((*bucket)[i] != nobody) items[cursor[(*bucket)[i]]++] = static_cast<std::uint32_t>(i);
    return map_each(part_of(execution, 0.5, 1), n, [&](std::size_t i) {
        const std::uint32_t b = (*bucket)[i];
        if (b == nobody) return nobody;
        const auto p = point(i);
        int asked = 0;
        for (std::size_t k = offsets[b]; k < offsets[b + 1] && items[k] < i && asked < max_asked; ++k) {
            if (point(items[k]).c != p.c) continue;
            if (meets(i, items[k])) return items[k];
            ++asked;
        }
        return nobody;
    });
}

/// Twins, neighbours and facets' sides; unlisted faces and interfaces.
template <int D>
[[nodiscard]] Outcome<Done> examine_faces(const LinearMesh<D>& mesh, Examination<D>& examination,
                                          const Execution& execution);

/// Which elements are turned, tangled or flat, by their signed volumes (exact in sign; 0: flat to rounding).
template <int D>
[[nodiscard]] Outcome<Done> examine_orientation(const LinearMesh<D>& mesh, const Buffer<double>& volumes,
                                                Examination<D>& examination, const Execution& execution);

/// What is beyond the range of lengths: vertices, elements, facets; of a quadratic mesh its mid nodes (only those).
template <int D>
[[nodiscard]] Outcome<Done> examine_scale(const LinearMesh<D>& mesh, Examination<D>& examination,
                                          const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Done> examine_scale(const QuadraticMesh<D>& mesh, Examination<D>& examination,
                                          const Execution& execution);

/// Unused, coincident and hanging vertices.
template <int D>
[[nodiscard]] Outcome<Done> examine_vertices(const LinearMesh<D>& mesh, Examination<D>& examination,
                                             const Execution& execution);

/// Where the boundary, or a surface alone, meets itself.
template <int D>
[[nodiscard]] Outcome<Done> examine_boundary(const LinearMesh<D>& mesh, Examination<D>& examination,
                                             const Execution& execution);

/// Elements with two faces on one smooth wall.
template <int D>
[[nodiscard]] Outcome<Done> examine_walls(const LinearMesh<D>& mesh, const ExamineOptions& options,
                                          Examination<D>& examination, const Execution& execution);

/// Mid nodes at the place of vertices or of other mid nodes.
template <int D>
[[nodiscard]] Outcome<Done> examine_nodes(const QuadraticMesh<D>& mesh, Examination<D>& examination,
                                          const Execution& execution);

/// All of it.
template <int D>
[[nodiscard]] Outcome<Examination<D>> examine_all(const LinearMesh<D>& mesh, const Execution& execution,
                                                  const ExamineOptions& options = {});
template <int D>
[[nodiscard]] Outcome<Examination<D>> examine_all(const QuadraticMesh<D>& mesh, const Execution& execution,
                                                  const ExamineOptions& options = {});

}  // namespace camber
