module;
#include <string>
#include <vector>
module camber.commands:nodal_fields;
import camber.core;
import camber.io;
import camber.transfer;

/// Fields of a solution on a mesh, from and to files: `metric` and `transfer`.
namespace camber::app {

/// A field at the nodes of a mesh of degree 2.
struct NamedField {
    std::string name;
    FieldKind kind = FieldKind::scalar;
    TransferField field;
};

/// The mesh as one of degree 2: a straight one elevated.
template <int D>
[[nodiscard]] Outcome<QuadraticMesh<D>> of_degree_2(const DecodedMesh& mesh, const Execution& execution);

/// The fields of a solution file, or of a mesh file at its nodes, on the mesh that was read from `mesh_path`: at the
/// vertices, or at all nodes of a mesh of degree 2. Fields of a solution file are called field_1 and so on. `only`: the
/// names of those that are wanted; empty: all. Errors (input): rows that are not those of the mesh, a mesh that is
/// another one, no field at nodes; (usage): a name that it does not have.
[[nodiscard]] Outcome<std::vector<NamedField>> read_nodal_fields(const DecodedMesh& mesh, const std::string& path,
                                                                 const std::vector<std::string>& only,
                                                                 std::vector<Notice>& notices,
                                                                 const Execution& execution);

/// Writes fields to a solution file, with rows as the mesh's file counts its nodes, or with the mesh to a format that
/// has fields. Errors: an ending that is none of these (usage); those of writing.
[[nodiscard]] Outcome<Done> write_nodal_fields(const DecodedMesh& mesh, const std::vector<NamedField>& fields,
                                               const std::string& path, const Execution& execution);
/// Whether that can be: asked before the work. Errors: usage.
[[nodiscard]] Outcome<Done> check_fields_ending(const std::string& path);

}  // namespace camber::app
