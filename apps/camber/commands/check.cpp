module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.io;
import camber.app_shell;
import camber.recipes;
import camber.reports;
import camber.config;
import :execution;

namespace camber::app {

namespace {

constexpr std::size_t elements_at_once = 65536;

/// Calls f(begin, end) for successive ranges of elements, so that the whole text is never in memory.
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
    out.print(report.answer() + "\n" + called_input(arguments.input) + "\n" + run::check_table(report));
    if (arguments.histogram)
        for (const run::Histogram& histogram : report.histograms) out.print(run::bars(histogram));
}

Outcome<Done> write_verdicts(const DecodedMesh& mesh, const run::CheckReport& report, const std::string& path,
                             const Execution& execution) {
    auto fields = run::check_fields(mesh.mesh, report, execution);
    if (!fields) return fail(fields.error());
    return write_for_viewers(mesh.mesh, std::move(*fields), mesh.lift, path, execution);
}

Outcome<run::MetricFile> read_metric(const CheckArguments& a, DecodedMesh& mesh, const Execution& execution) {
    auto sorted = read_metric_rows(mesh, a.metric, mesh.notices, execution);
    if (!sorted) return fail(sorted.error());
    if (sorted->is_at_nodes)
        mesh.notices.push_back({a.metric +
                                " has a metric at all nodes: lengths and qualities use its values at the vertices, "
                                "with linear interpolation of their logarithms"});
    return run::MetricFile{a.metric, run::rows_at_vertices(std::move(*sorted), mesh.mesh)};
}

Outcome<run::CheckReport> checked(const CheckArguments& a, run::PageSource& page) {
    ShownSteps steps(a.threads);
    auto mesh = steps.run("read", [&](const Execution& e) { return read_mesh(a.input, a.flat, e); });
    if (!mesh) return fail(mesh.error());
    if (!a.page.empty()) {
        page.mesh = mesh->mesh;
        page.fields = fields_at_nodes(*mesh, mesh->notices);
    }
    std::optional<run::MetricFile> metric;
    if (!a.metric.empty()) {
        auto rows = steps.run("read", [&](const Execution& e) { return read_metric(a, *mesh, e); });
        if (!rows) return fail(rows.error());
        metric = std::move(*rows);
    }
    const DecodedMesh original = a.vtu.empty() ? DecodedMesh() : *mesh;
    auto report = run::check_mesh(std::move(*mesh), metric, a.options, steps.around);
    if (!report) return fail(of_file(report.error(), a.input));
    if (a.vtu.empty()) return report;
    auto written = steps.run("write", [&](const Execution& e) { return write_verdicts(original, *report, a.vtu, e); });
    if (!written) return fail(written.error());
    return report;
}

Outcome<Done> write_page_of(const run::CheckReport& report, run::PageSource page, const CheckArguments& arguments) {
    if (arguments.page.empty()) return Done{};
    page.report = report;
    page.histograms = report.histograms;
    page.numbers = run::check_table(report);
    return write_page(std::move(page), arguments.input, arguments.page, {}, {.threads = arguments.threads});
}

Outcome<Done> check_names(const CheckArguments& a) {
    if (a.vtu.empty() && a.page.empty()) return Done{};
    return check_named_files({{a.input, "the input", Role::input},
                              {a.metric, "--metric", Role::input},
                              {a.vtu, "--vtu", Role::output},
                              {a.page, "--page", Role::output}})
        .and_then([&](Done) { return check_viewer_output(a.vtu); })
        .and_then([&](Done) { return a.page.empty() ? Outcome<Done>(Done{}) : check_page(a.page); });
}

}  // namespace

Outcome<int> check_command(const CheckArguments& arguments) {
    if (auto possible = check_names(arguments); !possible) return fail(possible.error());
    run::PageSource page;
    const auto report = checked(arguments, page);
    if (!report) return fail(report.error());
    if (auto done = write_page_of(*report, std::move(page), arguments); !done) return fail(done.error());
    const int code = report->all_good() ? 0 : 1;
    if (!arguments.json)
        for (const std::string& notice : report->notices) print_note(notice);
    if (voice() == Voice::quiet && !arguments.json && !arguments.elements) return code;
    StandardOutput out;
    if (arguments.json)
        print_json(*report, arguments, out);
    else if (arguments.elements)
        print_elements(*report, out);
    else
        print_report(*report, arguments, out);
    if (auto done = out.finish(); !done) return fail(done.error());
    return code;
}

namespace {

Outcome<Done> check_files(const GeometryCommandArguments& a) {
    return check_named_files({{a.input, "the input", Role::input},
                              {a.geometry.cad.value_or(""), "--cad", Role::input},
                              {a.output, "-o", Role::output},
                              {a.surface, "--surface", Role::output}})
        .and_then([&](Done) { return check_viewer_output(a.output); })
        .and_then([&](Done) { return check_viewer_output(a.surface); });
}

Outcome<run::ComparedGeometry> compared(const GeometryArguments& arguments, const Execution& execution) {
    config::Pipeline pipeline;
    if (auto set = set_geometry(arguments, pipeline); !set) return fail(set.error());
    auto source = read_geometry(pipeline.geometry, execution);
    if (!source) return fail(source.error());
    return run::ComparedGeometry{pipeline.geometry, std::move(*source)};
}

std::string names_row(const run::Groups& groups, int dimension) {
    std::string text;
    for (const Group& group : groups)
        if (group.dimension < dimension && group.dimension > 0)
            text += (text.empty() ? "" : ", ") + run::called(groups, group.dimension, group.reference);
    return text.empty() ? text : run::short_row("names of references", text);
}

}  // namespace

Outcome<int> geometry_command(const GeometryCommandArguments& a) {
    if (auto files = check_files(a); !files) return fail(files.error());
    ShownSteps steps(a.threads);
    auto geometry = compared(a.geometry, {.threads = a.threads, .stop = stop_on_signals()});
    if (!geometry) return fail(geometry.error());
    if (!a.surface.empty()) geometry->surface = run::InspectedSurface::lattice;
    auto mesh = steps.run("read", [&](const Execution& e) { return read_mesh(a.input, a.flat, e); });
    if (!mesh) return fail(mesh.error());
    const std::optional<Lift> lift = mesh->lift;
    const run::Groups groups = run::groups_of(mesh->mesh);
    auto found = run::inspect_geometry(std::move(*mesh), *geometry, a.options, steps.around);
    if (!found) return fail(of_file(found.error(), a.input));
    Written written;
    const auto write = [&](AnyMesh result, MeshFields fields, const std::string& path) {
        return written.add(path, steps.run("write", [&](const Execution& e) {
            return write_for_viewers(std::move(result), std::move(fields), lift, path, e);
        }));
    };
    if (!a.output.empty())
        if (auto done = write(found->mesh, found->fields, a.output); !done) return fail(done.error());
    if (auto& surface = found->surface)
        if (auto done = write(std::move(surface->mesh), std::move(surface->fields), a.surface); !done)
            return fail(done.error());
    steps.progress.wipe();
    const run::GeometryReport& report = found->report;
    if (a.json) return end_with(run::inspect_json(report, a.input, CAMBER_VERSION), written);
    for (const std::string& notice : report.notices) print_note(notice);
    return end_with(called_input(a.input) + "\n" + run::inspect_table(report) +
                        names_row(groups, report.mesh.dimension) + wrote_rows({a.output, a.surface}),
                    written);
}

namespace {

std::string splitting_note(const std::vector<CellCount>& unsupported_cells, const std::string& path) {
    const auto is_of_degree = [](const CellCount& cells) {
        for (const std::string_view simplices : {"riangles", "etrahedra", "dges", "ines", "egments"})
            if (cells.kind.find(simplices) != std::string::npos &&
                cells.kind.find_first_of("3456") != std::string::npos)
                return true;
        return cells.kind.starts_with("Lagrange cells");
    };
    const bool any_degree = std::any_of(unsupported_cells.begin(), unsupported_cells.end(), is_of_degree),
               any_shape = !std::all_of(unsupported_cells.begin(), unsupported_cells.end(), is_of_degree);
    std::string text;
    if (any_shape)
        text =
            "into triangles and tetrahedra: in ParaView the filter Tetrahedralize, then Save Data as .vtu (if ParaView "
            "cannot read the file: meshio convert " +
            path + " FILE.vtu)";
    if (any_degree)
        text += std::string(any_shape ? "; " : "") + "to degree 2: gmsh, with a file of the lines Merge \"" + path +
                "\"; SetOrder 2; Save \"FILE.msh\";";
    return text;
}

Outcome<run::FileInfo> mesh_info(const std::string& path, DecodeOptions options) {
    options.unsupported_cells = UnsupportedCells::count;
    const auto decoded = read_mesh(path, config::Flat::plane, options, Execution{});
    if (!decoded) return fail(decoded.error());
    run::MeshInfo info = run::mesh_info(*decoded);
    if (!decoded->unsupported_cells.empty()) info.split = splitting_note(decoded->unsupported_cells, path);
    return run::FileInfo(std::move(info));
}

Outcome<run::FileInfo> solution_info(const std::string& path) {
    const auto decoded = read_solution(path, Execution{});
    if (!decoded) return fail(decoded.error());
    return run::FileInfo(run::solution_info(*decoded));
}

}  // namespace

Outcome<int> info_command(const InfoArguments& arguments) {
    const auto found =
        is_solution_file(arguments.input) ? solution_info(arguments.input) : mesh_info(arguments.input, arguments.read);
    if (!found) return fail(found.error());
    if (arguments.json) return end_with(run::info_json(*found));
    return end_with(called_input(arguments.input) + "\n" + run::info_table(*found));
}

}  // namespace camber::app
