module;
#include <compare>
#include <cstddef>
#include <cstdint>
export module camber.core:ids;

export namespace camber {

/// A strong index into a column, from 0. Ids of different entities do not mix; `none` is no entity.
template <class Tag>
struct Id {
    std::uint32_t value = 0xffffffffU;

    constexpr Id() = default;
    explicit constexpr Id(std::size_t i) : value(static_cast<std::uint32_t>(i)) {}
    [[nodiscard]] constexpr std::size_t index() const { return value; }
    [[nodiscard]] constexpr bool valid() const { return value != 0xffffffffU; }
    friend constexpr auto operator<=>(const Id&, const Id&) = default;
};

struct VertexTag;
struct EdgeTag;
struct FacetTag;
struct ElementTag;

using VertexId = Id<VertexTag>;    ///< a corner of elements
using EdgeId = Id<EdgeTag>;        ///< a unique edge (EdgeSet)
using FacetId = Id<FacetTag>;      ///< a boundary or interface facet: triangle in 3D, edge in 2D
using ElementId = Id<ElementTag>;  ///< tetrahedron in 3D, triangle in 2D

/// A colour: which material, surface or curve an entity belongs to.
using Reference = std::int32_t;

/// Ids are stored in 32 bits, the last value meaning none.
inline constexpr std::size_t max_entities = 0xfffffffeU;

}  // namespace camber
