module;
#include <cstddef>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.config;
import camber.io;
import camber.run;
import camber.transfer;
import :ending;
import :execute;
import :named_files;
import :nodal_fields;
import :page_file;

namespace camber::app {

namespace {

/// The mesh that a page is of, and what a report.json says beside it.
struct Subject {
    std::string mesh, before_and_after;
    std::vector<run::Histogram> histograms;
};

/// Where the mesh of a run is: at its path, or beside the report, if both were moved.
Outcome<std::string> found_mesh(const std::string& path, const std::string& report) {
    const std::filesystem::path given(path), beside = std::filesystem::path(report).parent_path() / given.filename();
    std::error_code ignored;
    for (const std::filesystem::path& place : {given, beside})
        if (!path.empty() && std::filesystem::exists(place, ignored)) return place.string();
    return fail(ErrorKind::input,
                path.empty() ? "names no mesh that its run wrote" : "its mesh, " + path + ", is not there", report, {},
                "give the mesh itself, or the report.json of a run with its mesh beside it");
}

Outcome<Subject> subject_of(const std::string& input) {
    if (!input.ends_with(".json")) return Subject{input, {}, {}};
    const auto text = read_file(input);
    if (!text) return fail(text.error());
    auto histograms = run::histograms_of_report(as_text(*text));
    if (!histograms)
        return fail(ErrorKind::input, "is no report.json as Camber writes them", input, {},
                    "give a mesh, or the report.json of a run: camber curve … --report report.json");
    auto mesh = found_mesh(run::mesh_of_report(as_text(*text)), input);
    if (!mesh) return fail(mesh.error());
    return Subject{std::move(*mesh), run::before_and_after(as_text(*text)), std::move(*histograms)};
}

/// A metric's rows as a field.
run::NamedField field_of(const run::RowsByNodes& rows) {
    const Solution& s = rows.solution;
    const bool is_size = s.fields[0] == FieldKind::scalar;
    return {is_size ? "size" : "metric", s.fields[0],
            TransferField{values_per_vertex(s.fields[0], s.dimension), rows.is_at_nodes ? 2 : 1, s.values}};
}

class Reporter {
  public:
    Reporter(const ReportArguments& arguments, const Around& around) : arguments_(arguments), around_(around) {}

    Outcome<Done> write(Written& written) {
        auto subject = subject_of(arguments_.input);
        if (!subject) return fail(subject.error());
        return around_("read", [&](const Execution& e) { return read(subject->mesh, e); })
            .and_then([&](Done) { return check(*subject); })
            .and_then([&](Done) {
                return around_("page", [&](const Execution& e) {
                    return written.add(arguments_.output, write_page(std::move(source_), subject->mesh,
                                                                     arguments_.output, arguments_.page, e));
                });
            });
    }

    [[nodiscard]] const std::string& answer() const { return answer_; }

  private:
    Outcome<Done> read(const std::string& path, const Execution& execution) {
        auto mesh = read_mesh(path, arguments_.flat, execution);
        if (!mesh) return fail(mesh.error());
        decoded_ = std::move(*mesh);
        std::vector<Notice>& notices = decoded_->notices;
        auto fields = arguments_.solution.empty()
                          ? fields_at_nodes(*decoded_, notices)
                          : read_nodal_fields(*decoded_, arguments_.solution, {}, notices, execution);
        if (!fields) return fail(fields.error());
        source_.fields = std::move(*fields);
        if (arguments_.metric.empty()) return Done{};
        auto rows = read_metric_rows(*decoded_, arguments_.metric, notices, execution);
        if (!rows) return fail(rows.error());
        source_.fields.insert(source_.fields.begin(), field_of(*rows));
        metric_ = run::MetricFile{arguments_.metric, run::rows_at_vertices(std::move(*rows), decoded_->mesh)};
        return Done{};
    }

    Outcome<Done> check(const Subject& subject) {
        source_.mesh = decoded_->mesh;
        auto report = run::check_mesh(std::move(*decoded_), metric_, arguments_.options, around_);
        if (!report) return fail(of_file(report.error(), subject.mesh));
        source_.histograms = subject.histograms.empty() ? report->histograms : subject.histograms;
        answer_ = run::check_answer(*report);
        source_.numbers = run::check_table(*report);
        if (!subject.before_and_after.empty())
            source_.numbers = "  before -> after correction\n" + subject.before_and_after + "\n" + source_.numbers;
        for (const std::string& notice : report->notices) tell_note(notice);
        source_.report = std::move(*report);
        return Done{};
    }

    const ReportArguments& arguments_;
    const Around& around_;
    std::optional<DecodedMesh> decoded_;
    std::optional<run::MetricFile> metric_;
    run::PageSource source_;
    std::string answer_;
};

Outcome<Done> check_names(const ReportArguments& a) {
    std::vector<NamedFile> files{{a.input, "the input", Role::input}, {a.output, "-o", Role::output}};
    if (!a.metric.empty()) files.push_back({a.metric, "--metric", Role::input});
    if (!a.solution.empty()) files.push_back({a.solution, "--solution", Role::input});
    return check_named_files(files).and_then([&](Done) { return check_page(a.output); });
}

}  // namespace

int report_command(const ReportArguments& arguments) {
    if (auto possible = check_names(arguments); !possible) return report_error(possible.error());
    Progress progress;
    const std::stop_token stop = stop_on_signals();
    const Around around = steps_shown(progress, {.threads = arguments.threads, .stop = stop});
    Written written;
    Reporter reporter(arguments, around);
    const auto done = reporter.write(written);
    progress.wipe();
    if (!done) return report_error(of_file(done.error(), arguments.input));
    return end_with(reporter.answer() + "\n" + wrote_rows({arguments.output}), written);
}

}  // namespace camber::app
