module;
#include <string>
#include <string_view>
#include <vector>
module camber.commands:nodal_fields;
import camber.core;
import camber.config;
import camber.io;
import camber.run;

/// Fields of a solution on a mesh, from and to files.
namespace camber::app {

using run::NamedField;

/// The fields of numbers at the nodes of a mesh that was read with them. Notices of those that are left out.
[[nodiscard]] std::vector<NamedField> fields_at_nodes(const DecodedMesh& mesh, std::vector<Notice>& notices);

/// The fields of a solution file, or of a mesh file at its nodes, on that mesh: at its vertices, or at all nodes that
/// it has in degree 2. On a straight mesh the rows of the edges' nodes come after those of the vertices, in the order
/// of (lower vertex, higher vertex). Fields of a solution file are called field_1 and so on. `only`: the names of those
/// that are wanted; empty: all. Errors (input): rows that are not those of the mesh, a mesh that is another one, no
/// field at nodes; (usage): a name that it does not have.
[[nodiscard]] Outcome<std::vector<NamedField>> read_nodal_fields(const DecodedMesh& mesh, const std::string& path,
                                                                 const std::vector<std::string>& only,
                                                                 std::vector<Notice>& notices,
                                                                 const Execution& execution);

/// A metric of that mesh, by its vertices or all nodes: a solution file's rows, or of a mesh file with the same nodes
/// the field `metric`, or else its only tensor, or else its only number, a size. Errors: those of reading; (input) a
/// mesh file without such a field.
[[nodiscard]] Outcome<run::RowsByNodes> read_metric_rows(const DecodedMesh& mesh, const std::string& path,
                                                         std::vector<Notice>& notices, const Execution& execution);

/// Metric files of that mesh, rows at its vertices. Errors: those of reading.
[[nodiscard]] Outcome<std::vector<Solution>> read_metrics_at_vertices(const DecodedMesh& mesh,
                                                                      const std::vector<config::FilePath>& files,
                                                                      std::vector<Notice>& notices,
                                                                      const Execution& execution);

/// Writes fields to a solution file, with rows as the mesh's file counts its nodes, or with the mesh to a format that
/// has fields: the format of that name, else that of the ending, where the mesh's own goes by it that one. Errors: an
/// ending that is none of these (usage); those of writing.
[[nodiscard]] Outcome<Done> write_nodal_fields(const DecodedMesh& mesh, const std::vector<NamedField>& fields,
                                               const std::string& path, std::string_view format,
                                               const Execution& execution);
/// The same with the mesh, in this format; fields only where it has a place for them.
[[nodiscard]] Outcome<Done> write_with_mesh(const DecodedMesh& mesh, const std::vector<NamedField>& fields,
                                            const MeshFormat& format, const std::string& path,
                                            const Execution& execution);
/// Whether that can be, and whether the format has a place for such fields: asked before the work. Errors: usage.
[[nodiscard]] Outcome<Done> check_fields_output(const std::string& path, std::string_view format);
[[nodiscard]] Outcome<Done> check_place_for(const std::string& path, std::string_view format, FieldKind kind);

}  // namespace camber::app
