module;
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>
/// Texts of reports: tables for a terminal, JSON both ways.
export module camber.reports:texts;
import camber.core;
import camber.io;
import camber.recipes;

export namespace camber::run {

/// Bars for a terminal, the series side by side, without colours: about 100 columns at most. Bins that are empty in all
/// series are left out at either end, and are one row where several follow each other on one side of zero.
[[nodiscard]] std::string bars(const Histogram& histogram);

/// The number of the layout of a report.json, see report_format; none: the text has no such number.
[[nodiscard]] std::optional<int> format_of_report(std::string_view text);

/// The histograms of a report.json, also of one without extremes (written before there were). Nothing when the text is
/// no JSON object with histograms as Camber writes them.
[[nodiscard]] std::optional<std::vector<Histogram>> histograms_of_report(std::string_view json);

/// The entities, the farthest first.
[[nodiscard]] std::vector<const EntityReport*> farthest_first(const DistancesReport& report);
/// Two lines, the worst entity named; and one for each of the worst entities.
[[nodiscard]] std::string distance_rows(const DistancesReport& report);
[[nodiscard]] std::string entity_rows(const DistancesReport& report, std::size_t most);

/// The rows of the verbs `metric` and `transfer`.
[[nodiscard]] std::string solution_metric_rows(const SolutionMetricReport& report);
[[nodiscard]] std::string transfer_rows(const TransferReport& report);
/// A row of a run's summary.
[[nodiscard]] std::string carried_rows(const TransferReport& report);

/// One line of a table for a terminal.
[[nodiscard]] std::string table_row(std::string_view name, const std::string& value);
[[nodiscard]] std::string table_row(std::string_view name, std::size_t n);
/// The same with a narrow column of names: plans, contents of files.
[[nodiscard]] std::string short_row(std::string_view name, std::string_view value);

/// The lower bound of a scaled Jacobian; "> 0" where its sign is certain and no number above 0 is.
[[nodiscard]] std::string scaled_jacobian_text(double least, bool is_positive);

/// The result of a run for its user, in at most ten lines: validity first, then the smallest scaled Jacobian and its
/// element, the distance from the geometry and where it is largest, transferred fields, the size of the mesh, time and
/// memory.
[[nodiscard]] std::string summary(const Report& report);
/// All fields of the report, one a line, and the times of the steps.
[[nodiscard]] std::string full_table(const Report& report);

/// Tables of `camber check` and `camber geometry` for a terminal, without colours.
[[nodiscard]] std::string check_table(const CheckReport& report);
[[nodiscard]] std::string inspect_table(const GeometryReport& report);

/// report.json: the same numbers. The keys: docs/report.md.
[[nodiscard]] std::string to_json(const Report& report);
/// The objects of `camber check --json` and `camber geometry --json`; `name` is the file's, `version` the program's.
/// That of a check ends before its last brace, so that members may follow.
[[nodiscard]] std::string check_json_head(const CheckReport& report, std::string_view name, std::string_view version);
[[nodiscard]] std::string inspect_json(const GeometryReport& report, std::string_view name, std::string_view version);

/// The object of `camber info --json`, and its rows for a terminal.
[[nodiscard]] std::string info_json(const FileInfo& info);
[[nodiscard]] std::string info_table(const FileInfo& info);

/// The columns of the elements by name, each in pieces: items [begin, end) as JSON without brackets.
[[nodiscard]] std::vector<std::string> column_names(const CheckReport& report);
[[nodiscard]] std::string column_items(const CheckReport& report, std::string_view column, std::size_t begin,
                                       std::size_t end);
/// The same as CSV: the line of titles, and the lines of elements [begin, end).
[[nodiscard]] std::string csv_titles(const CheckReport& report);
[[nodiscard]] std::string csv_lines(const CheckReport& report, std::size_t begin, std::size_t end);

/// The JSON Schema of report.json, `check --json` or `geometry --json` (report, check, geometry): the type, the meaning
/// and the unit of each key; none for other names.
[[nodiscard]] std::optional<std::string> report_schema(std::string_view of);

/// A key of report.json with the keys that lead to it: "boundary.cad.faces".
struct ReportKey {
    std::string path;
    std::string_view meaning, unit;
};
[[nodiscard]] std::vector<ReportKey> report_keys();

/// Rows of both tables about a CAD model.
[[nodiscard]] std::string cad_rows(const CadReport& cad);

/// Lines for a terminal; of degree 1 nothing is curved.
[[nodiscard]] std::string field_table(const FieldErrors& field, const MeshReport& mesh);

/// The pipeline with a small share of the work of its repair, which is run to see how long the whole one takes. Nothing
/// where no stage repairs by optimisation, where passes change the mesh, and for meshes on which even that takes long.
[[nodiscard]] std::optional<config::Pipeline> probe_of(const config::Pipeline& pipeline, const PlanSize& size,
                                                       int threads);

/// The expected time of a run, in seconds. `seconds`: time of its probe; `probe`: what that reports. Repair that spent
/// its share of work in the probe is expected to spend all of it.
[[nodiscard]] double expected_seconds(const config::Pipeline& pipeline, const Report& probe, double seconds,
                                      int threads);

/// The parts of a pipeline as JSON in one line. Stages contain the options that differ from the defaults.
struct PipelineTexts {
    std::string input, metric, geometry;
    std::vector<std::string> metric_operations, stages;
};

/// The plan of a run, for `--dry-run`: input and sizes, metric, geometry, each stage with the options that are not
/// the defaults, memory and time expected. `growth`: what passes will make, where that is known. `seconds`: the time
/// that a probe predicts, if there was one.
[[nodiscard]] std::string plan_text(const config::Pipeline& pipeline, const PipelineTexts& parts, const PlanSize& size,
                                    const std::optional<Growth>& growth, std::optional<double> seconds, int threads);

/// The table for a terminal, whole or line by line, and as JSON, both ways. Errors of reading: input, with its path.
[[nodiscard]] std::string cycles_head(const config::Adaptation& adapt);
[[nodiscard]] std::string cycles_line(const CycleRow& row, const config::Adaptation& adapt);
[[nodiscard]] std::string cycles_json(std::span<const CycleRow> rows);
[[nodiscard]] Outcome<std::vector<CycleRow>> read_cycles(const std::string& text, const std::string& path);

/// Names of references as JSON, both ways: files of cycles may have no place for them. Errors of reading: input, with
/// its path.
[[nodiscard]] std::string groups_json(const Groups& groups);
[[nodiscard]] Outcome<Groups> read_groups(const std::string& text, const std::string& path);

/// A series for ParaView (.pvd): one file a cycle, the cycle as the time.
[[nodiscard]] std::string series_of(std::span<const CycleRow> rows, const std::string& view);

}  // namespace camber::run
