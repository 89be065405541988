module;
#include <cstddef>
#include <optional>
#include <string>
#include <vector>
/// The program's verbs. Each prints its result to standard output, notes to standard error, and returns the exit code
/// or an error, which the program prints. Codes: 0 done; 1 done, but the result misses what was asked; 2 bad usage or
/// config; 3 bad input or output file; 4 not enough memory, or internal; 130 interrupted.
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
    bool allow_commands = false;  ///< that the config names
    bool force = false;           ///< the output may replace the input
    std::optional<int> from;      ///< of its cycles: the one of an earlier run that is gone on from
};
[[nodiscard]] Outcome<int> run_command(const RunArguments& arguments);

/// The fields that are transferred; none: those of the input's own file.
struct SolutionChoice {
    std::string input_file, output;   ///< a file or an expression; empty: none
    std::vector<std::string> fields;  ///< names; empty: all
    std::optional<TransferMethod> method;
};

/// Arguments of the verbs that run a pipeline from one mesh to another: `pipeline_of` makes it.
struct PipelineArguments {
    std::string input, output, report, vtu, plots, page;
    std::string format;  ///< of the output, by its name; empty: that of its ending, or the input's own
    config::Flat flat = config::Flat::plane;
    SolutionChoice solution;
    std::vector<std::string> settings;  ///< path=value
    std::optional<int> threads;
    std::optional<double> min_scaled_jacobian;
    std::optional<int> partition;  ///< parts; none: those of the settings
    bool force = false;            ///< the output may replace the input
    bool print_config = false, histogram = false, dry_run = false;
};

/// The geometry; all none: that of the settings, or the surrogate.
struct GeometryArguments {
    std::optional<std::string> geometry;  ///< a word or JSON
    std::optional<std::string> cad;       ///< a CAD file instead
    std::optional<CadUnit> cad_unit;
    std::optional<CadVertices> cad_vertices;
    double cad_timeout = 0, cad_memory = 0;  ///< of reading the model (s, MB); 0: by the size of its file
    std::optional<double> tolerance;         ///< of boundary nodes (shares of their edge's length)
};

/// The metric; all none: that of the settings, or natural.
struct MetricChoice {
    std::optional<std::string> metric;            ///< a word, a size, a file or JSON
    std::vector<std::string> sizes;               ///< [KIND:]REFERENCE=SIZE, intersected with it
    std::optional<double> geometry_error;         ///< the same of chords; infinite: no bound, the default one neither
    std::optional<double> gradation, complexity;  ///< then done to it, in this order
};

struct CurveArguments : PipelineArguments {
    MetricChoice metric;
    GeometryArguments geometry;
    std::optional<Objective> objective;  ///< none: that of the settings, or the stage's default
    std::optional<int> blocks;           ///< likewise
    std::optional<std::size_t> memory;   ///< likewise; bytes
};
[[nodiscard]] Outcome<config::Pipeline> pipeline_of(const CurveArguments& arguments);
[[nodiscard]] Outcome<int> curve_command(const CurveArguments& arguments, Host host = {});

struct RepairArguments : PipelineArguments {
    GeometryArguments geometry;
    std::optional<double> boundary_tolerance;  ///< none: that of the settings, or 0
};
[[nodiscard]] Outcome<config::Pipeline> pipeline_of(const RepairArguments& arguments);
[[nodiscard]] Outcome<int> repair_command(const RepairArguments& arguments);

struct RemeshArguments : PipelineArguments {
    MetricChoice metric;
    GeometryArguments geometry;
    std::optional<int> rounds;                         ///< none: that of the settings, or the stage's default
    std::optional<int> blocks;                         ///< likewise
    std::optional<config::RemeshObjective> objective;  ///< likewise
    std::string output_metric;                         ///< the metric at the new vertices; empty: not written
};
[[nodiscard]] Outcome<config::Pipeline> pipeline_of(const RemeshArguments& arguments);
[[nodiscard]] Outcome<int> remesh_command(const RemeshArguments& arguments, Host host = {});

/// Arguments of adaptation in cycles.
struct AdaptArguments : PipelineArguments {
    MetricChoice metric;  ///< none: `of_solution`, with what stands beside it here
    GeometryArguments geometry;
    config::SolutionMetric of_solution = {};
    config::Adaptation adapt = {};  ///< but for the cycles
    std::optional<int> cycles;      ///< none: as many as usual
    int degree = 2;                 ///< of the meshes that are made
    std::optional<int> from;        ///< the cycle of an earlier run that is gone on from
};
[[nodiscard]] Outcome<config::Pipeline> pipeline_of(const AdaptArguments& arguments);
[[nodiscard]] Outcome<int> adapt_command(const AdaptArguments& arguments);

struct ConvertArguments {
    std::string input, output;
    std::string format;             ///< a format's name; empty: that of the output's ending
    std::optional<VtuCells> cells;  ///< of a .vtu; none: the default
    std::string metric;             ///< a solution file whose fields go into the .vtu; empty: none
    bool elevate = false;           ///< degree 1 to 2
    bool straighten = false;        ///< degree 2 to 1
    std::size_t partition = 0;      ///< parts that it is written in; 0: it is not
    DecodeOptions read = {};        ///< how the input is read
    int threads = 0;
    bool force = false;  ///< the output may replace the input
};
[[nodiscard]] Outcome<int> convert_command(const ConvertArguments& arguments, const Host& host = {});

struct GenerateArguments {
    std::string shape;                        ///< its name, its JSON, or a file of that or of a pipeline
    std::string output, format;               ///< a format's name; empty: that of the output's ending
    std::vector<std::string> settings;        ///< path=value among the shape's options
    std::optional<ShellStructure> structure;  ///< of a shell or annulus; none: that of the options
    std::optional<double> elements;           ///< about so many; none: as the options say
    int threads = 0;
    bool print_config = false;
};
/// The shape that they ask for. Errors: usage.
[[nodiscard]] Outcome<config::Shape> shape_of(const GenerateArguments& arguments);
/// The mesh of that shape, not written. Errors: usage, memory, stopped.
[[nodiscard]] Outcome<DecodedMesh> generate_in_memory(const GenerateArguments& arguments, const Host& host);
[[nodiscard]] Outcome<int> generate_command(const GenerateArguments& arguments, const Host& host = {});

struct PlotArguments {
    std::string report, output;  ///< report.json; a folder, or one file .svg
};
[[nodiscard]] Outcome<int> plot_command(const PlotArguments& arguments);

/// A page of a mesh, or of a run and its mesh.
struct ReportArguments {
    std::string input, output;     ///< a mesh or a report.json; the page
    std::string metric, solution;  ///< files; empty: none
    config::Flat flat = config::Flat::plane;
    run::CheckOptions options = {};
    run::PageOptions page = {};
    int threads = 0;
};
[[nodiscard]] Outcome<int> report_command(const ReportArguments& arguments);

struct CheckArguments {
    std::string input, metric;  ///< metric: a solution file; empty: none
    std::string vtu, page;      ///< the mesh with its verdicts; an .html; empty: none
    config::Flat flat = config::Flat::plane;
    run::CheckOptions options = {};
    int threads = 0;
    bool json = false, elements = false, histogram = true;
};
[[nodiscard]] Outcome<int> check_command(const CheckArguments& arguments);

struct GeometryCommandArguments {
    std::string input;
    std::string output, surface;  ///< the mesh with fields of its boundary; the geometry over it; empty: none
    config::Flat flat = config::Flat::plane;
    GeometryArguments geometry;
    run::InspectOptions options = {};
    int threads = 0;
    bool json = false;
};
[[nodiscard]] Outcome<int> geometry_command(const GeometryCommandArguments& arguments);

/// The metric that a solution asks for.
struct MetricArguments {
    std::string input, solution, output;
    std::string format;  ///< of the output, by its name; empty: that of its ending
    config::Flat flat = config::Flat::plane;
    config::SolutionMetric metric = {};
    std::vector<std::string> sizes;  ///< [KIND:]REFERENCE=SIZE
    int threads = 0;
};
[[nodiscard]] Outcome<int> metric_command(const MetricArguments& arguments);

/// A solution brought from a mesh to another one.
struct TransferArguments {
    std::string old_mesh, new_mesh, solution, output;
    std::string format;               ///< of the output, by its name; empty: that of its ending
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

/// Sizes by reference, as arguments give them: [KIND:]REFERENCE,…=SIZE. Errors: usage.
[[nodiscard]] Outcome<config::SizesMetric> read_sizes(const std::vector<std::string>& texts);
/// Puts a verb's geometry, where there is one, into a pipeline.
[[nodiscard]] Outcome<Done> set_geometry(const GeometryArguments& arguments, config::Pipeline& pipeline);

}  // namespace camber::app

namespace camber::app {

/// Returns `base`, the pipeline of a verb, with the arguments, but for metric and geometry.
[[nodiscard]] Outcome<config::Pipeline> pipeline_of(config::Pipeline base, const PipelineArguments& arguments);

/// Puts a verb's metric, where there is one, into its pipeline.
[[nodiscard]] Outcome<Done> set_metric(const MetricChoice& choice, config::Pipeline& pipeline);

}  // namespace camber::app
