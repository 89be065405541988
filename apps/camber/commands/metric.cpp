module;
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

module camber.commands;
import camber.core;
import camber.app_shell;
import camber.config;
import camber.io;
import camber.run;
import :ending;
import :execute;
import :formats;
import :named_files;
import :nodal_fields;

namespace camber::app {

namespace {

std::vector<NamedFile> files_of(const MetricArguments& a) {
    std::vector<NamedFile> files{
        {a.input, "the input", Role::input}, {a.solution, "--solution", Role::input}, {a.output, "-o", Role::output}};
    for (const config::FilePath& file : a.metric.intersect) files.push_back({file.path, "--intersect", Role::input});
    return files;
}

Outcome<std::string> metric_text(const MetricArguments& a, Written& written) {
    if (auto distinct = check_named_files(files_of(a)); !distinct) return fail(distinct.error());
    if (auto output = check_fields_output(a.output, a.format); !output) return fail(output.error());
    if (auto place = check_place_for(a.output, a.format, FieldKind::symmetric_tensor); !place)
        return fail(place.error());
    if (auto writable = check_writable(a.output); !writable) return fail(writable.error());
    auto sizes = read_sizes(a.sizes);
    if (!sizes) return fail(sizes.error());
    config::SolutionMetric asked = a.metric;
    asked.sizes = std::move(sizes->sizes);
    Progress progress;
    const std::stop_token stop = stop_on_signals();
    const Around around = steps_shown(progress, {.threads = a.threads, .stop = stop});
    auto decoded = run_step(around, "read", [&](const Execution& e) { return read_mesh(a.input, a.flat, e); });
    if (!decoded) return fail(decoded.error());
    std::vector<Notice> notices = decoded->notices;
    const auto fields = run_step(around, "read solution", [&](const Execution& e) {
        return read_nodal_fields(*decoded, a.solution, a.metric.fields, notices, e);
    });
    if (!fields) return fail(fields.error());
    const auto given = run_step(around, "read metrics", [&](const Execution& e) {
        return read_metrics_at_vertices(*decoded, a.metric.intersect, notices, e);
    });
    if (!given) return fail(given.error());
    for (const Notice& notice : notices) tell_note(notice.what);
    const double ridge_angle = config::Features{}.ridge_angle;
    const auto made = run::metric_of_fields(decoded->mesh, *fields, asked, *given, ridge_angle, around);
    if (!made) return fail(of_file(made.error(), a.solution));
    auto done = written.add(a.output, run_step(around, "write", [&](const Execution& e) {
                                return write_nodal_fields(*decoded, {made->metric}, a.output, a.format, e);
                            }));
    if (!done) return fail(done.error());
    progress.wipe();
    for (const std::string& notice : run::solution_metric_notices(made->report)) tell_note(notice);
    return called_input(a.input) + "\n" + run::solution_metric_rows(made->report) + wrote_rows({a.output});
}

}  // namespace

int metric_command(const MetricArguments& arguments) {
    Written written;
    const auto text = metric_text(arguments, written);
    if (!text) return report_error(text.error());
    return end_with(*text, written);
}

}  // namespace camber::app
