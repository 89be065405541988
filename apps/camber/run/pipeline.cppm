module;
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>
export module camber.run:pipeline;
import camber.core;
import camber.cad;
import camber.config;
import camber.distributed;
import camber.io;
import camber.ordering;
import :geometry_source;
import :memory;
import :report;
import :runner;
import :solution;
import :stages;

export namespace camber::run {

/// A metric that is made for the run's solution.
struct SolutionMetricInput {
    config::SolutionMetric asked;
    std::vector<Solution> intersect;  ///< rows of its files, at the input's vertices
    std::string path;                 ///< in the config, for errors
};

/// What the shell hands to a run beside the config: files already read.
struct Inputs {
    DecodedMesh mesh;
    std::optional<Solution> metric = {};         ///< of the metric file, when the config names one
    std::optional<MetricMesh> metric_mesh = {};  ///< that it speaks of, where its rows are not at the input's vertices
    std::vector<MetricFile> operands = {};       ///< metric files that the operations intersect with
    OrderingOptions ordering = {};               ///< when the stages work in an order of their own
    GeometrySource geometry = {};
    AvailableMemory memory = {};
    std::vector<NamedField> fields = {};                     ///< of the solution, on that mesh
    std::vector<SolutionMetricInput> solution_metrics = {};  ///< those of the config that are made for these
    std::shared_ptr<Ranks> ranks = one_rank();               ///< who share what goes by blocks
    RunEnd end = RunEnd::whole;
};

struct Run {
    AnyMesh mesh;  ///< committed, or the last state when nothing was
    Report report;
    MeshFields fields;                    ///< empty unless the config's output shows them
    std::optional<Solution> metric = {};  ///< at the vertices, if the config's output wants it and the stages made one
    std::vector<NamedField> solution = {};  ///< the input's fields, if the config's output has a place for them
    /// Of a run that ends in rows, those of this rank: the mesh is empty then.
    std::variant<std::monostate, FinishedRows<2>, FinishedRows<3>> rows = {};
};

/// Whether several ranks may end a run of it with a share of the mesh each: nothing but the mesh is asked for, and
/// blocks are the last that changes it.
[[nodiscard]] bool may_end_in_rows(const config::Pipeline& pipeline);

/// Whether an output shows fields of the run: a VTU file, a page.
[[nodiscard]] bool shows_fields(const config::Output& output);
/// Whether it has a place for fields of a solution: a file of their own, or with the mesh.
[[nodiscard]] bool carries_fields(const config::Output& output);
/// Whether a stage places nodes by the solution.
[[nodiscard]] bool places_by_solution(const config::Pipeline& pipeline);
/// Whether no stage is a pass that changes the topology.
[[nodiscard]] bool keeps_elements(const config::Pipeline& pipeline);

/// Whether the mesh is of degree 2 and not straight: no stage `elevate` takes it.
[[nodiscard]] bool is_curved(const AnyMesh& mesh);

/// The mesh prepared, then the stages of a config, one after the other. Errors name the stage's JSON path.
[[nodiscard]] Outcome<Run> run_pipeline(const config::Pipeline& pipeline, Inputs inputs, const Around& around);

/// What passes will make of the mesh, by the metric that they go by, where no stage but `elevate` comes before them;
/// none: no stage splits, or the metric is not known before others are done. Errors: those of the run so far, and
/// memory: the same as where the run comes there.
[[nodiscard]] Outcome<std::optional<Growth>> planned_growth(const config::Pipeline& pipeline, Inputs inputs,
                                                            const Around& around);

/// The metric of a config, its operations done, at the vertices of the input's mesh; no stage is run. Errors: those of
/// the run so far.
struct MadeMetric {
    Solution metric;
    MetricReport report;
    std::vector<std::string> notices;
};
[[nodiscard]] Outcome<MadeMetric> made_metric(const config::Pipeline& pipeline, Inputs inputs, const Around& around);

/// The mesh of a config's shape.
[[nodiscard]] Outcome<DecodedMesh> generate_shape(const config::Shape& shape, const Execution& execution = {});

}  // namespace camber::run
