module;
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>
/// Reports as tables for a terminal and as JSON.
export module camber.reports:texts;
import camber.core;
import camber.io;
import camber.recipes;

export namespace camber::run {

/// Draws bars for a terminal, with the series side by side, in about 100 columns. Bins that are empty in all series are
/// omitted at both ends. Consecutive empty bins on one side of zero share a row.
[[nodiscard]] std::string bars(const Histogram& histogram);

/// Format version of a report.json, see report_format; none: missing.
[[nodiscard]] std::optional<int> format_of_report(std::string_view text);

/// Reads the histograms of a report.json, also of old ones without extremes. None: the text is not a JSON object with
/// Camber's histograms.
[[nodiscard]] std::optional<std::vector<Histogram>> histograms_of_report(std::string_view json);

[[nodiscard]] std::vector<const EntityReport*> farthest_first(const DistancesReport& report);
/// `distance_rows` returns two rows, one for each direction, with the worst entity. `entity_rows` returns one row for
/// each of the `most` worst entities.
[[nodiscard]] std::string distance_rows(const DistancesReport& report);
[[nodiscard]] std::string entity_rows(const DistancesReport& report, std::size_t most);

/// Rows of the verbs `metric` and `transfer`.
[[nodiscard]] std::string solution_metric_rows(const SolutionMetricReport& report);
[[nodiscard]] std::string transfer_rows(const TransferReport& report);
/// Row of a run's summary about transferred fields.
[[nodiscard]] std::string carried_rows(const TransferReport& report);

/// One row of a terminal table.
[[nodiscard]] std::string table_row(std::string_view name, const std::string& value);
[[nodiscard]] std::string table_row(std::string_view name, std::size_t n);
/// One row with a narrow column of names, for plans and contents of files.
[[nodiscard]] std::string short_row(std::string_view name, std::string_view value);

/// Lower bound of a scaled Jacobian; "> 0" if the sign is certain but no positive bound is known.
[[nodiscard]] std::string scaled_jacobian_text(double least, bool is_positive);

/// Result of a run in at most ten lines: validity, smallest scaled Jacobian and its element, distance from the geometry
/// and its location, transferred fields, mesh size, time and memory.
[[nodiscard]] std::string summary(const Report& report);
/// All fields of the report, one per line, and the times of the steps.
[[nodiscard]] std::string full_table(const Report& report);

/// Tables of `camber check` and `camber geometry` without colours.
[[nodiscard]] std::string check_table(const CheckReport& report);
[[nodiscard]] std::string inspect_table(const GeometryReport& report);

/// Writes report.json. Keys: docs/report.md.
[[nodiscard]] std::string to_json(const Report& report);
/// JSON objects of `camber check --json` and `camber geometry --json`. `name`: name of the mesh file; `version`:
/// version of the program. The object of a check has no closing brace, so that the caller can add members.
[[nodiscard]] std::string check_json_head(const CheckReport& report, std::string_view name, std::string_view version);
[[nodiscard]] std::string inspect_json(const GeometryReport& report, std::string_view name, std::string_view version);

/// Object of `camber info --json`, and its terminal rows.
[[nodiscard]] std::string info_json(const FileInfo& info);
[[nodiscard]] std::string info_table(const FileInfo& info);

/// Names of the element columns, and items [begin, end) of each as JSON without brackets.
[[nodiscard]] std::vector<std::string> column_names(const CheckReport& report);
[[nodiscard]] std::string column_items(const CheckReport& report, std::string_view column, std::size_t begin,
                                       std::size_t end);
/// Element columns as CSV: title line, and lines of elements [begin, end).
[[nodiscard]] std::string csv_titles(const CheckReport& report);
[[nodiscard]] std::string csv_lines(const CheckReport& report, std::size_t begin, std::size_t end);

/// JSON Schema of report.json (`of`: report), `check --json` (check) or `geometry --json` (geometry): type, meaning and
/// unit of each key; none for other names.
[[nodiscard]] std::optional<std::string> report_schema(std::string_view of);

/// A key of report.json with its parent keys: "boundary.cad.faces".
struct ReportKey {
    std::string path;
    std::string_view meaning, unit;
};
[[nodiscard]] std::vector<ReportKey> report_keys();

/// Rows about a CAD model in both tables.
[[nodiscard]] std::string cad_rows(const CadReport& cad);

/// Lines for a terminal. Meshes of degree 1 have no rows about curvature.
[[nodiscard]] std::string field_table(const FieldErrors& field, const MeshReport& mesh);

/// Returns the pipeline with a small fraction of its repair work. A run of this probe predicts the time of the full
/// run. Returns none if no stage repairs by optimisation, if passes change the mesh, or if even the probe would take
/// long.
[[nodiscard]] std::optional<config::Pipeline> probe_of(const config::Pipeline& pipeline, const PlanSize& size,
                                                       int threads);

/// Expected time of a run (s). `seconds`, `probe`: time and report of the probe's run. If a repair used all its work in
/// the probe, it is expected to use all its work in the full run too.
[[nodiscard]] double expected_seconds(const config::Pipeline& pipeline, const Report& probe, double seconds,
                                      int threads);

/// Parts of a pipeline as one-line JSON. Stages list options that differ from the defaults.
struct PipelineTexts {
    std::string input, metric, geometry;
    std::vector<std::string> metric_operations, stages;
};

/// Plan of a run for `--dry-run`. It lists input, sizes, metric, geometry, stages with changed options, and the
/// expected memory and time. `growth`: expected result of passes, if known. `seconds`: predicted time, if there was a
/// probe.
[[nodiscard]] std::string plan_text(const config::Pipeline& pipeline, const PipelineTexts& parts, const PlanSize& size,
                                    const std::optional<Growth>& growth, std::optional<double> seconds, int threads);

/// Functions for the table of cycles: its head and one line for a terminal, and the whole table written to and read
/// from JSON. Errors of reading: input, with the path.
[[nodiscard]] std::string cycles_head(const config::Adaptation& adapt);
[[nodiscard]] std::string cycles_line(const CycleRow& row, const config::Adaptation& adapt);
[[nodiscard]] std::string cycles_json(std::span<const CycleRow> rows);
[[nodiscard]] Outcome<std::vector<CycleRow>> read_cycles(const std::string& text, const std::string& path);

/// Writes and reads names of references as JSON, since files of cycles may not store them. Errors of reading: input,
/// with the path.
[[nodiscard]] std::string groups_json(const Groups& groups);
[[nodiscard]] Outcome<Groups> read_groups(const std::string& text, const std::string& path);

/// ParaView series (.pvd) with one file per cycle. The time is the cycle.
[[nodiscard]] std::string series_of(std::span<const CycleRow> rows, const std::string& view);

}  // namespace camber::run
