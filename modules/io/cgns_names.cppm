module;
#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <utility>
module camber.io:cgns_names;
import camber.core;
import :legal_names;
import :mesh_fields;

/// MED files, and names of fields, sections and boundary conditions in CGNS files.
namespace camber {

/// Whether the bytes begin as a MED file of Salome does: HDF5, as CGNS, with other nodes.
[[nodiscard]] bool is_med(std::span<const std::byte> bytes);

}  // namespace camber

namespace camber::cgns {

/// The fields that a file has a place for, and their names there.
[[nodiscard]] MeshFields fields_in_file(const MeshFields& fields);
[[nodiscard]] FieldNames field_names();

/// Names of references, by the dimension of their simplices.
using ReferenceNames = std::map<std::pair<int, Reference>, std::string>;
/// The names of sections, each of another reference, and of boundary conditions (of references of facets, none in a
/// surface alone).
struct GroupNames {
    ReferenceNames sections, conditions;
};
template <int D>
[[nodiscard]] GroupNames group_names(const LinearMesh<D>& mesh);

}  // namespace camber::cgns
