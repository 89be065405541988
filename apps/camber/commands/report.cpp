module;
#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>
#include <fmt/format.h>
#include "viewer.hpp"
module camber.commands;
import camber.core;
import camber.drawing;
import camber.transfer;
import camber.io;
import camber.app_shell;
import camber.config;
import camber.recipes;
import camber.reports;
import :execution;

namespace camber::app {

namespace {

struct Subject {
    std::string mesh, before_and_after;
    std::vector<run::Histogram> histograms;
    std::optional<run::DistancesReport> distances = {};
};

/// Finds the mesh of a run, at its path or next to the report if both were moved.
Outcome<std::string> found_mesh(const std::string& path, const std::string& report) {
    const std::filesystem::path specified(path),
        beside = std::filesystem::path(report).parent_path() / specified.filename();
    std::error_code ignored;
    for (const std::filesystem::path& place : {specified, beside})
        if (!path.empty() && std::filesystem::exists(place, ignored)) return place.string();
    return fail(ErrorKind::input,
                path.empty() ? "names no mesh file of its run" : "its mesh, " + path + ", does not exist", report, {},
                "give the mesh itself, or the report.json of a run with its mesh next to it");
}

Outcome<Done> check_format(std::string_view text, const std::string& path) {
    const auto format = run::format_of_report(text);
    if (!format || *format == run::report_format) return Done{};
    return fail(ErrorKind::input,
                fmt::format("has the report format {}; this version reads format {}", *format, run::report_format),
                path, {},
                *format < run::report_format
                    ? "write it again with this version: camber curve … --report report.json; CHANGELOG.md lists the "
                      "renamed keys"
                    : "read it with the version of Camber that wrote it");
}

Outcome<Subject> subject_of(const std::string& input) {
    if (!input.ends_with(".json")) return Subject{input, {}, {}};
    const auto text = read_file(input);
    if (!text) return fail(text.error());
    if (auto current = check_format(as_text(*text), input); !current) return fail(current.error());
    auto histograms = run::histograms_of_report(as_text(*text));
    if (!histograms)
        return fail(ErrorKind::input, "is not a report.json of Camber", input, {},
                    "give a mesh, or the report.json of a run: camber curve … --report report.json");
    auto mesh = found_mesh(run::mesh_of_report(as_text(*text)), input);
    if (!mesh) return fail(mesh.error());
    return Subject{std::move(*mesh), run::before_and_after(as_text(*text)), std::move(*histograms),
                   run::distances_of_report(as_text(*text))};
}

run::NamedField field_of(const run::RowsByNodes& rows) {
    const Solution& s = rows.solution;
    const bool is_size = s.fields[0] == FieldKind::scalar;
    return {is_size ? "size" : "metric", s.fields[0],
            TransferField{values_per_vertex(s.fields[0], s.dimension), rows.is_at_nodes ? 2 : 1, s.values}};
}

Outcome<DecodedMesh> read_shown(const std::string& path, const ReportArguments& a, run::PageSource& source,
                                std::optional<run::MetricFile>& metric, const Execution& execution) {
    auto mesh = read_mesh(path, a.flat, execution);
    if (!mesh) return mesh;
    auto fields = a.solution.empty() ? fields_at_nodes(*mesh, mesh->notices)
                                     : read_nodal_fields(*mesh, a.solution, {}, mesh->notices, execution);
    if (!fields) return fail(fields.error());
    source.fields = std::move(*fields);
    if (a.metric.empty()) return mesh;
    auto rows = read_metric_rows(*mesh, a.metric, mesh->notices, execution);
    if (!rows) return fail(rows.error());
    source.fields.insert(source.fields.begin(), field_of(*rows));
    metric = run::MetricFile{a.metric, run::rows_at_vertices(std::move(*rows), mesh->mesh)};
    return mesh;
}

Outcome<std::string> write_report_page(const ReportArguments& a, Written& written) {
    auto subject = subject_of(a.input);
    if (!subject) return fail(subject.error());
    ShownSteps steps(a.threads);
    run::PageSource source;
    std::optional<run::MetricFile> metric;
    auto mesh = steps.run("read", [&](const Execution& e) { return read_shown(subject->mesh, a, source, metric, e); });
    if (!mesh) return fail(mesh.error());
    source.mesh = mesh->mesh;
    auto report = run::check_mesh(std::move(*mesh), metric, a.options, steps.around);
    if (!report) return fail(of_file(report.error(), subject->mesh));
    source.histograms = subject->histograms.empty() ? report->histograms : std::move(subject->histograms);
    source.distances = std::move(subject->distances);
    source.numbers = run::check_table(*report);
    if (!subject->before_and_after.empty())
        source.numbers = "  before -> after correction\n" + subject->before_and_after + "\n" + source.numbers;
    for (const std::string& notice : report->notices) print_note(notice);
    std::string answer = report->answer();
    source.report = std::move(*report);
    return steps
        .run("page",
             [&](const Execution& e) {
                 return written.add(a.output, write_page(std::move(source), subject->mesh, a.output, a.page, e));
             })
        .map([&](Done) { return std::move(answer); });
}

}  // namespace

Outcome<int> report_command(const ReportArguments& a) {
    const auto possible = check_named_files({{a.input, "the input", Role::input},
                                             {a.output, "-o", Role::output},
                                             {a.metric, "--metric", Role::input},
                                             {a.solution, "--solution", Role::input}})
                              .and_then([&](Done) { return check_page(a.output); });
    if (!possible) return fail(possible.error());
    Written written;
    const auto answer = write_report_page(a, written);
    if (!answer) return fail(of_file(answer.error(), a.input));
    return end_with(*answer + "\n" + wrote_rows({a.output}), written);
}

namespace {

bool is_one_file(const PlotArguments& a) { return a.output.ends_with(".svg"); }

Outcome<Done> check_names(const PlotArguments& a) {
    std::vector<NamedFile> files{{a.report, "the report", Role::input}};
    for (const std::string& path : is_one_file(a) ? std::vector{a.output} : plot_files(a.output))
        files.push_back({path, "-o", Role::output});
    return check_named_files(files);
}

std::string plot_file(const std::string& folder, run::Quantity quantity) {
    return folder + "/" + std::string(run::info(quantity).key) + ".svg";
}

}  // namespace

std::vector<std::string> plot_files(const std::string& folder) {
    std::vector<std::string> files;
    files.reserve(run::run_quantity_count);
    for (std::size_t q = 0; q < run::run_quantity_count; ++q)
        files.push_back(plot_file(folder, static_cast<run::Quantity>(q)));
    return files;
}

Outcome<Done> write_plots(const std::vector<run::Histogram>& histograms, const std::string& folder, Written& written) {
    if (histograms.empty()) return Done{};
    if (auto result = make_folder(folder); !result) return result;
    for (const run::Histogram& h : histograms) {
        const std::string file = plot_file(folder, h.quantity);
        if (auto done = written.add(file, write_text(file, run::svg(h))); !done) return done;
    }
    return Done{};
}

Outcome<int> plot_command(const PlotArguments& a) {
    if (auto distinct = check_names(a); !distinct) return fail(distinct.error());
    auto text = read_file(a.report);
    if (!text) return fail(std::move(text.error()));
    if (auto current = check_format(as_text(*text), a.report); !current) return fail(current.error());
    const auto histograms = run::histograms_of_report(as_text(*text));
    if (!histograms)
        return fail(ErrorKind::input, "has no histograms of Camber", a.report, {},
                    "give the report.json of a run: camber curve … --report report.json");
    Written written;
    const auto done = is_one_file(a) ? written.add(a.output, write_text(a.output, run::svg(*histograms)))
                                     : write_plots(*histograms, a.output, written);
    if (!done) return fail(done.error());
    return end_with("wrote " + called_output(a.output) + "\n", written);
}

namespace {

bool is_svg(const std::string& path) { return path.ends_with(".svg"); }

Outcome<Done> check_files(const PictureArguments& a) {
    auto distinct = check_named_files({{a.input, "the input", Role::input},
                                       {a.output, "-o", Role::output},
                                       {a.metric, "--metric", Role::input},
                                       {a.solution, "--solution", Role::input}});
    if (!distinct) return distinct;
    if (!a.field.empty() && a.solution.empty())
        return fail(ErrorKind::usage, "names a field of a solution, but no solution is specified", "--field", {},
                    "give --solution FILE, which may be the mesh file");
    if (!is_svg(a.output) && !a.output.ends_with(".png"))
        return fail(ErrorKind::usage, "does not end in .png or .svg", a.output, {}, "name a .png or a .svg file");
    return check_writable(a.output);
}

Outcome<run::NamedField> field_of(const DecodedMesh& mesh, const PictureArguments& a, std::vector<Notice>& notices,
                                  const Execution& execution) {
    std::vector<std::string> only;
    if (!a.field.empty()) only.push_back(a.field);
    auto fields = read_nodal_fields(mesh, a.solution, only, notices, execution);
    if (!fields) return fail(fields.error());
    return std::move(fields->front());
}

Outcome<run::PictureInputs> inputs_of(const PictureArguments& a, const Execution& execution) {
    auto mesh = read_mesh(a.input, a.flat, execution);
    if (!mesh) return fail(mesh.error());
    run::PictureInputs inputs{std::move(*mesh)};
    std::vector<Notice> notices = inputs.mesh.notices;
    if (!a.metric.empty()) {
        auto rows = read_metric_rows(inputs.mesh, a.metric, notices, execution);
        if (!rows) return fail(rows.error());
        inputs.metric = run::MetricFile{a.metric, run::rows_at_vertices(std::move(*rows), inputs.mesh.mesh)};
    }
    if (!a.solution.empty()) {
        auto field = field_of(inputs.mesh, a, notices, execution);
        if (!field) return fail(field.error());
        inputs.solution = std::move(*field);
    }
    for (const Notice& notice : notices) print_note(notice.what);
    return inputs;
}

Outcome<Done> write_picture(const Scene& scene, const std::string& path, const Execution& execution) {
    if (is_svg(path)) {
        const auto text = svg_of(scene, execution);
        if (!text) return fail(text.error());
        return write_text(path, *text);
    }
    auto image = rasterised(scene, execution);
    if (!image) return fail(image.error());
    const auto bytes = png(with_marks(std::move(*image), marks_of(scene)));
    if (!bytes) return fail(bytes.error());
    const std::span<const std::byte> chunk(*bytes);
    return write_file(path, std::span(&chunk, 1), execution);
}

}  // namespace

Outcome<int> picture_command(const PictureArguments& a) {
    auto choice = choice_of(a);
    if (!choice) return fail(choice.error());
    if (auto files = check_files(a); !files) return fail(files.error());
    ShownSteps steps(a.threads);
    auto inputs = steps.run("read", [&](const Execution& e) { return inputs_of(a, e); });
    if (!inputs) return fail(inputs.error());
    const auto picture = steps.run("prepare", [&](const Execution& e) { return run::picture_of(*inputs, *choice, e); });
    if (!picture) return fail(of_file(picture.error(), a.input));
    for (const std::string& notice : picture->notices) print_note(notice);
    Written written;
    auto done = steps.run("draw", [&](const Execution& e) { return write_picture(picture->scene, a.output, e); });
    steps.progress.wipe();
    if (done = written.add(a.output, std::move(done)); !done) return fail(done.error());
    return end_with(wrote_rows({a.output}), written);
}

namespace {

constexpr std::size_t most_pixels = 16384;  // of the width and of the height

std::optional<std::vector<double>> numbers_in(std::string_view text) {
    std::vector<double> numbers;
    for (;;) {
        const std::size_t comma = text.find(',');
        const auto x = number_in<double>(text.substr(0, comma));
        if (!x) return {};
        numbers.push_back(*x);
        if (comma == std::string_view::npos) return numbers;
        text.remove_prefix(comma + 1);
    }
}

std::vector<std::string> parts_of(std::string_view text) {
    std::vector<std::string> parts;
    while (!text.empty()) {
        const std::size_t comma = text.find(',');
        parts.emplace_back(text.substr(0, comma));
        text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
    }
    return parts;
}

auto no_such(std::string_view option, const std::string& text, std::string remedy) {
    return fail(ErrorKind::usage, in_quotes(text) + " is not understood", std::string(option), {}, std::move(remedy));
}

Outcome<Done> read_size(const std::string& text, run::PictureChoice& choice) {
    const std::size_t x = text.find('x');
    if (text.empty()) return Done{};
    const auto wide = numbers_in(std::string_view(text).substr(0, x));
    const auto high = x == std::string::npos ? std::nullopt : numbers_in(std::string_view(text).substr(x + 1));
    const auto is_sound = [](const std::optional<std::vector<double>>& n) {
        return n && n->size() == 1 && n->front() >= 16 && n->front() <= most_pixels;
    };
    if (!is_sound(wide) || !is_sound(high))
        return no_such("--size", text, "write WIDTHxHEIGHT in pixels, from 16 to 16384: 1200x900");
    choice.width = static_cast<std::size_t>(wide->front());
    choice.height = static_cast<std::size_t>(high->front());
    return Done{};
}

/// "x=0.5" and "x<0.5" keep the part below, "x>0.5" the part above. "a,b,c,d" keeps a x + b y + c z ≤ d.
Outcome<Done> read_cut(const std::string& text, run::PictureChoice& choice) {
    if (text.empty()) return Done{};
    const std::size_t axis = std::string_view("xyz").find(text[0]);
    if (axis != std::string_view::npos && text.size() > 2 &&
        std::string_view("=<>").find(text[1]) != std::string_view::npos) {
        const auto at = numbers_in(std::string_view(text).substr(2));
        if (at && at->size() == 1) {
            const double sign = text[1] == '>' ? -1 : 1;
            Cut<3> cut{{}, sign * at->front()};
            cut.normal[axis] = sign;
            choice.cut = cut;
            return Done{};
        }
    } else if (const auto n = numbers_in(text); n && n->size() == 4) {
        const Cut<3> cut{{{(*n)[0], (*n)[1], (*n)[2]}}, (*n)[3]};
        if (norm(cut.normal) > 0) {
            choice.cut = cut;
            return Done{};
        }
    }
    return no_such("--cut", text, "write x=0.5, or x>0.5 for the other side, or A,B,C,D to keep A x + B y + C z <= D");
}

Outcome<Done> read_view(const std::string& text, run::PictureChoice& choice) {
    if (text.empty()) return Done{};
    constexpr auto named = std::to_array<std::pair<std::string_view, Vec<3>>>({{"front", {{0, -1, 0}}},
                                                                               {"back", {{0, 1, 0}}},
                                                                               {"left", {{-1, 0, 0}}},
                                                                               {"right", {{1, 0, 0}}},
                                                                               {"top", {{0, 0, 1}}},
                                                                               {"bottom", {{0, 0, -1}}}});
    for (const auto& [name, from] : named)
        if (text == name) return choice.from = from, Done{};
    if (const auto n = numbers_in(text); n && n->size() == 3) {
        const Vec<3> from{{(*n)[0], (*n)[1], (*n)[2]}};
        if (norm(from) > 0) return choice.from = from, Done{};
    }
    return no_such("--view", text,
                   "write front, back, left, right, top, bottom, or the direction towards the viewer: "
                   "1,-1.6,0.9");
}

Outcome<Done> read_zoom(const std::string& text, run::PictureChoice& choice) {
    if (text.empty()) return Done{};
    if (auto n = numbers_in(text); n && (n->size() == 3 || n->size() == 4) && n->back() > 0) {
        const double radius = n->back();
        n->pop_back();
        n->resize(3);
        choice.zoom = PictureOptions::Zoom{{{(*n)[0], (*n)[1], (*n)[2]}}, radius};
        return Done{};
    }
    return no_such("--zoom", text, "write X,Y,Z,RADIUS, in 2D X,Y,RADIUS");
}

}  // namespace

Outcome<run::PictureChoice> choice_of(const PictureArguments& a) {
    run::PictureChoice choice;
    choice.colour = a.colour;
    choice.background = a.background;
    choice.edges = a.no_edges ? Edges::hidden : Edges::shown;
    choice.worst = static_cast<std::size_t>(a.worst);
    choice.show = parts_of(a.show);
    choice.hide = parts_of(a.hide);
    auto read = read_size(a.size, choice)
                    .and_then([&](Done) { return read_cut(a.cut, choice); })
                    .and_then([&](Done) { return read_view(a.view, choice); })
                    .and_then([&](Done) { return read_zoom(a.zoom, choice); });
    if (!read) return fail(read.error());
    return choice;
}

Outcome<Done> check_page(const std::string& path) {
    if (path != standard_stream && !path.ends_with(".html") && !path.ends_with(".htm"))
        return fail(ErrorKind::usage, "is not a page: it does not end in .html", path, {}, "use this ending");
    return Done{};
}

Outcome<Done> write_page(run::PageSource source, const std::string& mesh, const std::string& path,
                         const run::PageOptions& options, const Execution& execution) {
    Viewer parts = viewer();
    source.title = mesh == standard_stream ? called_input(mesh) : std::filesystem::path(mesh).filename().string();
    source.version = CAMBER_VERSION;
    source.command = command_line();
    const auto text = run::page(source, {std::move(parts.frame), std::move(parts.style), std::move(parts.script)},
                                options, execution);
    return text ? write_text(path, *text) : Outcome<Done>(fail(text.error()));
}

}  // namespace camber::app
