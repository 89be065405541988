module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>
export module camber.validity:examination;
import camber.core;
import :soundness;

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

/// Twins, neighbours and facets' sides; unlisted faces and interfaces.
template <int D>
[[nodiscard]] Outcome<Done> examine_faces(const LinearMesh<D>& mesh, Examination<D>& examination,
                                          const Execution& execution);

/// Which elements are turned, tangled or flat, by their signed volumes (exact in sign; 0: flat to rounding).
template <int D>
[[nodiscard]] Outcome<Done> examine_orientation(const LinearMesh<D>& mesh, const Buffer<double>& volumes,
                                                Examination<D>& examination, const Execution& execution);

/// Unused, coincident and hanging vertices.
template <int D>
[[nodiscard]] Outcome<Done> examine_vertices(const LinearMesh<D>& mesh, Examination<D>& examination,
                                             const Execution& execution);

/// Where the boundary, or a surface alone, meets itself.
template <int D>
[[nodiscard]] Outcome<Done> examine_boundary(const LinearMesh<D>& mesh, Examination<D>& examination,
                                             const Execution& execution);

/// All of it.
template <int D>
[[nodiscard]] Outcome<Examination<D>> examine_all(const LinearMesh<D>& mesh, const Execution& execution);
template <int D>
[[nodiscard]] Outcome<Examination<D>> examine_all(const QuadraticMesh<D>& mesh, const Execution& execution);

}  // namespace camber
