module;
#include <functional>
#include <optional>
#include <string>
#include <vector>
export module camber.commands:in_memory;
import camber.core;
import camber.config;
import camber.io;
import camber.run;
import camber.transfer;
import :given;

/// The verbs over meshes in memory, for other languages (apps/python, apps/c): the same work as the program's, and the
/// same bytes. Errors: those of the verbs.
export namespace camber::app {

/// What came of a run.
struct MadeInMemory {
    DecodedMesh mesh;
    std::string report = {};                     ///< JSON: docs/report.md
    std::optional<Solution> metric = {};         ///< at the vertices, where a stage made one
    std::vector<run::NamedField> solution = {};  ///< the input's fields on this mesh
    std::vector<std::string> notices = {};       ///< worth knowing, and no error
    bool holds_what_was_asked = true;            ///< false: the report lists what it misses
    bool has_valid_elements = true;              ///< false: elements remain that are not certified valid
};

/// A config's stages, once; a mesh that begins with curves has no need of `elevate`. Its outputs that are files are
/// written.
[[nodiscard]] Outcome<MadeInMemory> run_in_memory(config::Pipeline pipeline, Host host);

/// The solution on a mesh; `guess`: that of the cycle before, brought to it.
using Solver = std::function<Outcome<std::vector<run::NamedField>>(
    const DecodedMesh& mesh, const std::vector<run::NamedField>& guess, int cycle)>;

struct AdaptedInMemory {
    MadeInMemory result;  ///< see run::row_of_result; with the solver's solution, where there is one
    std::string cycles;   ///< JSON: a row a cycle
    std::string reason;   ///< why they ended before their number; empty: they did not
};
/// A config's cycles; `solver`: empty, the config's metric or expression says what the mesh is adapted to. `degree`:
/// that meshes must have; 0: any.
[[nodiscard]] Outcome<AdaptedInMemory> adapt_in_memory(config::Pipeline pipeline, int degree, const Solver& solver,
                                                       Host host);

/// The report of `camber check`, as JSON (docs/report.md), and of each element its verdict and figures by name.
struct ElementColumn {
    std::string name;
    std::vector<double> values;
};
struct CheckedInMemory {
    std::string report, table;
    std::vector<ElementColumn> elements;
    bool all_good = false;
};
[[nodiscard]] Outcome<CheckedInMemory> check_in_memory(const DecodedMesh& mesh, const std::optional<Solution>& metric,
                                                       const run::CheckOptions& options, Host host);

/// The page of `camber report`, as HTML.
[[nodiscard]] Outcome<std::string> page_in_memory(const DecodedMesh& mesh, const std::vector<run::NamedField>& fields,
                                                  const std::string& title, const run::PageOptions& options, Host host);

/// The report of `camber geometry`, as JSON.
[[nodiscard]] Outcome<std::string> geometry_in_memory(const DecodedMesh& mesh, const config::Geometry& geometry,
                                                      const run::InspectOptions& options, Host host);

/// The metric that a config's source and operations make on its input, at the vertices; its stages are not run.
struct MetricInMemory {
    Solution metric;
    double complexity = 0, largest_anisotropy = 0;
    std::vector<std::string> notices;
};
[[nodiscard]] Outcome<MetricInMemory> metric_in_memory(const config::Pipeline& pipeline, Host host);

/// Second derivatives of a field at the vertices.
[[nodiscard]] Outcome<Solution> hessians_in_memory(const DecodedMesh& mesh, const run::NamedField& field, Host host);

/// Fields of a mesh on another one.
[[nodiscard]] Outcome<std::vector<run::NamedField>> transfer_in_memory(const DecodedMesh& old_mesh,
                                                                       const DecodedMesh& new_mesh,
                                                                       std::vector<run::NamedField> fields,
                                                                       const TransferOptions& options, Host host);

/// A file's mesh with its fields, and a mesh to a file, as `camber convert` does both.
[[nodiscard]] Outcome<DecodedMesh> read_into_memory(const std::string& path, config::Flat flat,
                                                    const DecodeOptions& options, Host host);
[[nodiscard]] Outcome<std::vector<std::string>> write_from_memory(const DecodedMesh& mesh,
                                                                  const std::vector<run::NamedField>& fields,
                                                                  const std::string& path, const std::string& format,
                                                                  Host host);
/// The nodal fields that a mesh was read with.
[[nodiscard]] std::vector<run::NamedField> nodal_fields_of(const DecodedMesh& mesh);

}  // namespace camber::app
