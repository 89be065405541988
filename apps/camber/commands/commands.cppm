module;
#include <cstddef>
#include <optional>
#include <string>
#include <vector>
/// Verbs of the program. Each prints its result to standard output and notes to standard error. It returns the exit
/// code, or an error, which the program prints. Codes: 0 success; 1 the result misses a requirement; 2 wrong usage or
/// config; 3 wrong input or output file; 4 not enough memory, or internal error; 130 interrupted.
export module camber.commands;
import camber.core;
import camber.transfer;
import camber.io;
import camber.shapes;
import camber.cad;
import camber.recipes;
import camber.config;
import camber.reports;
export import :requests;

export namespace camber::app {

struct RunArguments {
    std::string config;
    std::vector<std::string> settings;  ///< path=value
    std::optional<int> threads;
    bool print_config = false, histogram = false, dry_run = false;
    bool allow_commands = false;  ///< run commands that the config names
    bool force = false;           ///< the output may replace the input
    std::optional<int> from;      ///< continues cycles of an earlier run after this one
};
[[nodiscard]] Outcome<int> run_command(const RunArguments& arguments);

/// Fields to transfer; empty: those of the input mesh file.
struct SolutionChoice {
    std::string input_file, output;   ///< file or expression; empty: none
    std::vector<std::string> fields;  ///< names; empty: all
    std::optional<TransferMethod> method;
};

/// Arguments of the verbs that run a pipeline from one mesh to another; see `pipeline_of`.
struct PipelineArguments {
    std::string input, output, report, vtu, plots, page;
    std::string format;  ///< name of the output format; empty: by the ending, or the input's
    config::Flat flat = config::Flat::plane;
    SolutionChoice solution;
    std::vector<std::string> settings;  ///< path=value
    std::optional<int> threads;
    std::optional<double> min_scaled_jacobian;
    std::optional<int> partition;  ///< number of parts; none: by the settings
    bool force = false;
    bool print_config = false, histogram = false, dry_run = false;
};

/// Geometry; no member set: the one of the settings, or the surrogate.
struct GeometryArguments {
    std::optional<std::string> geometry;  ///< word or JSON
    std::optional<std::string> cad;       ///< CAD file
    std::optional<CadUnit> cad_unit;
    std::optional<CadVertices> cad_vertices;
    double cad_timeout = 0, cad_memory = 0;  ///< limits for reading the model (s, MB); 0: by the file size
    std::optional<double> tolerance;         ///< for boundary nodes (fractions of the edge length)
};

/// Metric; no member set: the one of the settings, or natural.
struct MetricChoice {
    std::optional<std::string> metric;            ///< word, size, file or JSON
    std::vector<std::string> sizes;               ///< [KIND:]REFERENCE=SIZE, intersected with the metric
    std::optional<double> geometry_error;         ///< bound on the distance of chords; infinite: no bound, also not the
                                                  ///< default
    std::optional<double> gradation, complexity;  ///< applied to the metric in this order
};

struct CurveArguments : PipelineArguments {
    MetricChoice metric;
    GeometryArguments geometry;
    std::optional<Objective> objective;  ///< none: by the settings, or the stage's default
    std::optional<int> blocks;           ///< none: as above
    std::optional<std::size_t> memory;   ///< bytes; none: as above
};
[[nodiscard]] Outcome<config::Pipeline> pipeline_of(const CurveArguments& arguments);
[[nodiscard]] Outcome<int> curve_command(const CurveArguments& arguments, Host host = {});

struct RepairArguments : PipelineArguments {
    GeometryArguments geometry;
    std::optional<double> boundary_tolerance;  ///< none: by the settings, or 0
};
[[nodiscard]] Outcome<config::Pipeline> pipeline_of(const RepairArguments& arguments);
[[nodiscard]] Outcome<int> repair_command(const RepairArguments& arguments);

struct RemeshArguments : PipelineArguments {
    MetricChoice metric;
    GeometryArguments geometry;
    std::optional<int> rounds;                         ///< none: by the settings, or the stage's default
    std::optional<int> blocks;                         ///< none: as above
    std::optional<config::RemeshObjective> objective;  ///< none: as above
    std::string output_metric;                         ///< file of the metric at the new vertices; empty: not written
};
[[nodiscard]] Outcome<config::Pipeline> pipeline_of(const RemeshArguments& arguments);
[[nodiscard]] Outcome<int> remesh_command(const RemeshArguments& arguments, Host host = {});

struct AdaptArguments : PipelineArguments {
    MetricChoice metric;  ///< none: `of_solution`, with sizes and operations of this member
    GeometryArguments geometry;
    config::SolutionMetric of_solution = {};
    config::Adaptation adapt = {};  ///< its number of cycles is not used
    std::optional<int> cycles;      ///< none: the usual number
    int degree = 2;                 ///< of the new meshes
    std::optional<int> from;        ///< continues cycles of an earlier run after this one
};
[[nodiscard]] Outcome<config::Pipeline> pipeline_of(const AdaptArguments& arguments);
[[nodiscard]] Outcome<int> adapt_command(const AdaptArguments& arguments);

struct ConvertArguments {
    std::string input, output;
    std::string format;             ///< name; empty: by the ending
    std::optional<VtuCells> cells;  ///< of a .vtu; none: the default
    std::string metric;             ///< solution file whose fields are written to the .vtu; empty: none
    bool elevate = false;           ///< from degree 1 to 2
    bool straighten = false;        ///< from degree 2 to 1
    std::size_t partition = 0;      ///< number of parts to write; 0: one file
    DecodeOptions read = {};
    int threads = 0;
    bool force = false;
};
[[nodiscard]] Outcome<int> convert_command(const ConvertArguments& arguments, const Host& host = {});

struct GenerateArguments {
    std::string shape;                        ///< name, JSON, or file of a shape or pipeline
    std::string output, format;               ///< format: name; empty: by the ending
    std::vector<std::string> settings;        ///< path=value in the shape's options
    std::optional<ShellStructure> structure;  ///< of a shell or annulus; none: by the options
    std::optional<double> elements;           ///< approximate number; none: by the options
    int threads = 0;
    bool print_config = false;
};
/// Errors: usage.
[[nodiscard]] Outcome<config::Shape> shape_of(const GenerateArguments& arguments);
/// Generates the mesh without writing it. Errors: usage, memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> generate_in_memory(const GenerateArguments& arguments, const Host& host);
[[nodiscard]] Outcome<int> generate_command(const GenerateArguments& arguments, const Host& host = {});

struct PlotArguments {
    std::string report, output;  ///< report.json; a folder, or one .svg file
};
[[nodiscard]] Outcome<int> plot_command(const PlotArguments& arguments);

struct ReportArguments {
    std::string input, output;     ///< mesh or report.json; page
    std::string metric, solution;  ///< files; empty: none
    config::Flat flat = config::Flat::plane;
    run::CheckOptions options = {};
    run::PageOptions page = {};
    int threads = 0;
};
[[nodiscard]] Outcome<int> report_command(const ReportArguments& arguments);

struct CheckArguments {
    std::string input, metric;  ///< metric: solution file; empty: none
    std::string vtu, page;      ///< mesh with its verdicts; .html; empty: none
    config::Flat flat = config::Flat::plane;
    run::CheckOptions options = {};
    int threads = 0;
    bool json = false, elements = false, histogram = true;
};
[[nodiscard]] Outcome<int> check_command(const CheckArguments& arguments);

struct GeometryCommandArguments {
    std::string input;
    std::string output, surface;  ///< mesh with fields of its boundary; geometry over it; empty: none
    config::Flat flat = config::Flat::plane;
    GeometryArguments geometry;
    run::InspectOptions options = {};
    int threads = 0;
    bool json = false;
};
[[nodiscard]] Outcome<int> geometry_command(const GeometryCommandArguments& arguments);

struct MetricArguments {
    std::string input, solution, output;
    std::string format;  ///< name of the output format; empty: by the ending
    config::Flat flat = config::Flat::plane;
    config::SolutionMetric metric = {};
    std::vector<std::string> sizes;  ///< [KIND:]REFERENCE=SIZE
    int threads = 0;
};
[[nodiscard]] Outcome<int> metric_command(const MetricArguments& arguments);

struct TransferArguments {
    std::string old_mesh, new_mesh, solution, output;
    std::string format;               ///< name of the output format; empty: by the ending
    std::vector<std::string> fields;  ///< names; empty: all
    config::Flat flat = config::Flat::plane;
    TransferOptions options = {};
    int threads = 0;
};
[[nodiscard]] Outcome<int> transfer_command(const TransferArguments& arguments);

struct InfoArguments {
    std::string input;
    DecodeOptions read = {};
    bool json = false;
};
[[nodiscard]] Outcome<int> info_command(const InfoArguments& arguments);

[[nodiscard]] Outcome<int> schema_command(const std::string& of);

/// Reads sizes by reference, [KIND:]REFERENCE,…=SIZE. Errors: usage.
[[nodiscard]] Outcome<config::SizesMetric> read_sizes(const std::vector<std::string>& texts);
[[nodiscard]] Outcome<Done> set_geometry(const GeometryArguments& arguments, config::Pipeline& pipeline);

}  // namespace camber::app

namespace camber::app {

/// Returns `base`, the pipeline of a verb, with the arguments except metric and geometry.
[[nodiscard]] Outcome<config::Pipeline> pipeline_of(config::Pipeline base, const PipelineArguments& arguments);

[[nodiscard]] Outcome<Done> set_metric(const MetricChoice& choice, config::Pipeline& pipeline);

}  // namespace camber::app
