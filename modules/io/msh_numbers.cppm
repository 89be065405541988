module;
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <type_traits>
#include <vector>
module camber.io:msh_numbers;
import camber.core;

/// Which physical tags and entities the simplices and vertices of a mesh get in an MSH file.
namespace camber::msh {

/// Simplices of one dimension that share entity and reference.
struct Class {
    Reference entity = 0, reference = 0;  ///< the mesh's
    std::size_t count = 0;
    Reference tag = 0, physical = 0;  ///< the file's: positive; physical 0: in no group
};

/// The simplices of one dimension.
struct Classes {
    std::vector<Class> list;
    Buffer<std::uint32_t> of;  ///< one a simplex
    /// What references, entities that are 0 or negative become.
    std::map<Reference, Reference> physical_of, tag_of;
    std::set<Reference> tags;  ///< of this dimension that are in use

    [[nodiscard]] Reference physical(Reference reference) const {
        return reference > 0 ? reference : physical_of.at(reference);
    }
    [[nodiscard]] Reference tag(Reference entity) const { return entity > 0 ? entity : tag_of.at(entity); }
};

/// What becomes of simplices with reference 0.
enum class Unnumbered : std::uint8_t {
    grouped,     ///< they get a free number, as all that are not positive do
    in_no_group  ///< they stay out of groups, if no name speaks of 0
};

/// Columns of simplices: entities as many as references, or none. `named`: references of groups; `places`: entities
/// that vertices lie on.
[[nodiscard]] Classes classes_of(std::span<const Reference> references, std::span<const Reference> entities,
                                 std::span<const Reference> named, std::span<const Reference> places,
                                 Unnumbered unnumbered = Unnumbered::grouped);

/// A vertex on an entity of the geometry, as the file can say it once for each.
struct Place {
    int dimension = 3;      ///< 3: on none
    std::uint32_t row = 0;  ///< of the associations with entities of that dimension
};

/// The place of each vertex: on the lowest entity that it has an association with, of those the first; empty where the
/// mesh has no associations.
template <int D>
[[nodiscard]] Buffer<Place> places_of(const LinearMesh<D>& mesh);

/// The numbers of all dimensions.
struct Numbers {
    Buffer<Place> places;
    std::vector<Classes> of_dimension;  ///< 0 to 3; of dimension 0 the point elements
    Buffer<std::uint32_t> points;       ///< vertices that are point elements, in turn
};
template <int D>
[[nodiscard]] Numbers numbers_of(const LinearMesh<D>& mesh);

/// The entity that a vertex's place is on, as the mesh has it.
template <int D>
[[nodiscard]] Reference entity_at(const LinearMesh<D>& mesh, Place place) {
    if (place.dimension == 0) return mesh.geometry.on_points[place.row].entity;
    if (place.dimension == 1) return mesh.geometry.on_curves[place.row].entity;
    return mesh.geometry.on_surfaces[place.row].entity;
}

/// f(dimension, simplices) for those of each dimension, the lowest first.
template <int D, class F>
void with_each_dimension(const LinearMesh<D>& mesh, F&& f) {
    if constexpr (D == 3) f(std::integral_constant<int, 1>{}, mesh.edges);
    f(std::integral_constant<int, D - 1>{}, mesh.facets);
    f(std::integral_constant<int, D>{}, mesh.elements);
}

}  // namespace camber::msh
