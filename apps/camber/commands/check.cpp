module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.io;
import camber.run;
import :ending;
import :execute;
import :formats;
import :named_files;
import :nodal_fields;
import :page_file;

namespace camber::app {

namespace {

constexpr std::size_t elements_at_once = 65536;

/// f(begin, end) for all elements, some at a time: their text is never in memory as a whole.
template <class F>
void in_pieces(std::size_t elements, F&& f) {
    for (std::size_t begin = 0; begin < elements; begin += elements_at_once)
        f(begin, std::min(begin + elements_at_once, elements));
}

void print_json(const run::CheckReport& report, const CheckArguments& arguments, StandardOutput& out) {
    out.print(run::check_json_head(report, arguments.input, CAMBER_VERSION));
    if (arguments.elements) {
        out.print(",\n  \"element_verdicts\": {");
        const char* before = "\n";
        for (const std::string& column : run::column_names(report)) {
            out.print(fmt::format("{}    \"{}\": [", before, column));
            in_pieces(report.mesh.judged(), [&](std::size_t begin, std::size_t end) {
                out.print(run::column_items(report, column, begin, end));
            });
            out.print("]");
            before = ",\n";
        }
        out.print("\n  }");
    }
    out.print("\n}\n");
}

void print_elements(const run::CheckReport& report, StandardOutput& out) {
    out.print(run::csv_titles(report));
    in_pieces(report.mesh.judged(),
              [&](std::size_t begin, std::size_t end) { out.print(run::csv_lines(report, begin, end)); });
}

void print_report(const run::CheckReport& report, const CheckArguments& arguments, StandardOutput& out) {
    out.print(run::check_answer(report) + "\n" + called_input(arguments.input) + "\n" + run::check_table(report));
    if (arguments.histogram)
        for (const run::Histogram& histogram : report.histograms) out.print(run::bars(histogram));
}

/// The mesh as the file has it, with what was found of its elements.
Outcome<Done> write_verdicts(const DecodedMesh& mesh, const run::CheckReport& report, const std::string& path,
                             const Execution& execution) {
    auto fields = run::check_fields(mesh.mesh, report, execution);
    if (!fields) return fail(fields.error());
    return write_for_viewers(mesh.mesh, std::move(*fields), mesh.lift, path, execution);
}

/// `page`: what a page takes of the mesh, where one is asked for.
Outcome<run::CheckReport> checked(const CheckArguments& arguments, run::PageSource& page) {
    Progress progress;
    const std::stop_token stop = stop_on_signals();
    const Around around = steps_shown(progress, {.threads = arguments.threads, .stop = stop});
    std::optional<DecodedMesh> mesh;
    auto read = around("read", [&](const Execution& execution) -> Outcome<Done> {
        auto decoded = read_mesh(arguments.input, arguments.flat, execution);
        if (!decoded) return fail(decoded.error());
        mesh = std::move(*decoded);
        if (arguments.page.empty()) return Done{};
        page.mesh = mesh->mesh;
        page.fields = fields_at_nodes(*mesh, mesh->notices);
        return Done{};
    });
    if (!read) return fail(read.error());
    std::optional<run::MetricFile> metric;
    read = around("read", [&](const Execution& execution) -> Outcome<Done> {
        if (arguments.metric.empty()) return Done{};
        auto sorted = read_metric_rows(*mesh, arguments.metric, mesh->notices, execution);
        if (!sorted) return fail(sorted.error());
        if (sorted->is_at_nodes)
            mesh->notices.push_back({arguments.metric +
                                     " has a metric at all nodes: lengths and qualities are told by what it has at the "
                                     "vertices, logarithms linear between them"});
        metric = run::MetricFile{arguments.metric, run::rows_at_vertices(std::move(*sorted), mesh->mesh)};
        return Done{};
    });
    if (!read) return fail(read.error());
    std::optional<DecodedMesh> given;
    if (!arguments.vtu.empty()) given = *mesh;
    auto report = run::check_mesh(std::move(*mesh), metric, arguments.options, around);
    if (!report) return fail(of_file(report.error(), arguments.input));
    if (given) {
        auto written = around("write", [&](const Execution& execution) {
            return write_verdicts(*given, *report, arguments.vtu, execution);
        });
        if (!written) return fail(written.error());
    }
    progress.wipe();
    return report;
}

Outcome<Done> write_page_of(const run::CheckReport& report, run::PageSource page, const CheckArguments& arguments) {
    if (arguments.page.empty()) return Done{};
    page.report = report;
    page.histograms = report.histograms;
    page.numbers = run::check_table(report);
    return write_page(std::move(page), arguments.input, arguments.page, {}, {.threads = arguments.threads});
}

/// Before any work is done.
Outcome<Done> check_names(const CheckArguments& a) {
    std::vector<NamedFile> files{{a.input, "the input", Role::input}};
    if (!a.metric.empty()) files.push_back({a.metric, "--metric", Role::input});
    if (!a.vtu.empty()) files.push_back({a.vtu, "--vtu", Role::output});
    if (!a.page.empty()) files.push_back({a.page, "--page", Role::output});
    if (a.vtu.empty() && a.page.empty()) return Done{};
    return check_named_files(files)
        .and_then([&](Done) { return a.vtu.empty() ? Outcome<Done>(Done{}) : check_viewer_output(a.vtu); })
        .and_then([&](Done) { return a.page.empty() ? Outcome<Done>(Done{}) : check_page(a.page); });
}

}  // namespace

int check_command(const CheckArguments& arguments) {
    if (auto possible = check_names(arguments); !possible) return report_error(possible.error());
    run::PageSource page;
    const auto report = checked(arguments, page);
    if (!report) return report_error(report.error());
    if (auto done = write_page_of(*report, std::move(page), arguments); !done) return report_error(done.error());
    const int code = report->all_good() ? 0 : 1;
    if (!arguments.json)
        for (const std::string& notice : report->notices) tell_note(notice);
    if (voice() == Voice::quiet && !arguments.json && !arguments.elements) return code;
    StandardOutput out;
    if (arguments.json)
        print_json(*report, arguments, out);
    else if (arguments.elements)
        print_elements(*report, out);
    else
        print_report(*report, arguments, out);
    if (auto done = out.finish(); !done) return report_error(done.error());
    return code;
}

}  // namespace camber::app
