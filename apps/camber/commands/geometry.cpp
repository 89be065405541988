module;
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.cad;
import camber.config;
import camber.io;
import camber.run;
import :ending;
import :execute;
import :formats;
import :named_files;

namespace camber::app {

namespace {

Outcome<Done> check_files(const GeometryCommandArguments& a) {
    std::vector<NamedFile> files{{a.input, "the input", Role::input}};
    if (a.geometry.cad) files.push_back({*a.geometry.cad, "--cad", Role::input});
    if (!a.output.empty()) files.push_back({a.output, "-o", Role::output});
    if (auto distinct = check_named_files(files); !distinct || a.output.empty()) return distinct;
    const auto format = format_to_write(mesh_formats(), a.output);
    if (!format) return fail(format.error());
    if (!(*format)->for_viewers)
        return fail(ErrorKind::usage, "the mesh with its fields goes into a format for viewers", a.output, {},
                    "name a .vtu file");
    return make_folder_of(a.output).and_then([&](Done) { return check_writable(a.output); });
}

/// The geometry of the arguments, a CAD model read.
Outcome<run::ComparedGeometry> compared(const GeometryArguments& arguments) {
    config::Pipeline pipeline;
    if (auto set = set_geometry(arguments, pipeline); !set) return fail(set.error());
    run::ComparedGeometry geometry{pipeline.geometry};
    if (const auto* cad = std::get_if<config::Cad>(&pipeline.geometry)) {
        auto model = read_cad(cad->file.path, {cad->unit});
        if (!model) return fail(model.error());
        geometry.cad = std::move(*model);
    }
    return geometry;
}

/// The mesh with its fields; a flat one of a format with three coordinates where it was.
Outcome<Done> write_fields(run::Inspected found, const std::optional<Lift>& lift, const std::string& path,
                           const Execution& execution) {
    const auto format = format_to_write(mesh_formats(), path);
    if (!format) return fail(format.error());
    if (lift && (*format)->always_in_space) {
        auto mesh = camber::raised(found.mesh, *lift, execution);
        if (!mesh) return fail(mesh.error());
        auto fields = camber::raised(found.fields, execution);
        if (!fields) return fail(fields.error());
        found.mesh = std::move(*mesh);
        found.fields = std::move(*fields);
    }
    return write_mesh(**format, found.mesh, found.fields, EncodeOptions{}, path, execution);
}

Outcome<run::GeometryReport> inspected(const GeometryCommandArguments& arguments, Written& written) {
    if (auto files = check_files(arguments); !files) return fail(files.error());
    Progress progress;
    const std::stop_token stop = stop_on_signals();
    const run::Around around = [&](std::string_view stage, const std::function<Outcome<Done>(const Execution&)>& body) {
        progress.begin(std::string(stage));
        return body(Execution{.threads = arguments.threads, .stop = stop, .progress = progress.ticks()});
    };
    auto geometry = compared(arguments.geometry);
    if (!geometry) return fail(geometry.error());
    std::optional<DecodedMesh> mesh;
    auto done = around("read", [&](const Execution& execution) -> Outcome<Done> {
        auto decoded = read_mesh(arguments.input, arguments.flat, execution);
        if (!decoded) return fail(decoded.error());
        mesh = std::move(*decoded);
        return Done{};
    });
    if (!done) return fail(done.error());
    const std::optional<Lift> lift = mesh->lift;
    auto found = run::inspect_geometry(std::move(*mesh), *geometry, arguments.options, around);
    if (!found) {
        progress.wipe();
        return fail(of_file(found.error(), arguments.input));
    }
    run::GeometryReport report = found->report;
    if (!arguments.output.empty())
        done = written.add(arguments.output, around("write", [&](const Execution& execution) {
                               return write_fields(std::move(*found), lift, arguments.output, execution);
                           }));
    progress.wipe();
    if (!done) return fail(done.error());
    return report;
}

}  // namespace

int geometry_command(const GeometryCommandArguments& arguments) {
    Written written;
    const auto report = inspected(arguments, written);
    if (!report) return report_error(report.error());
    if (arguments.json) return end_with(run::inspect_json(*report, arguments.input, CAMBER_VERSION), written);
    for (const std::string& notice : report->notices) tell("note: " + notice);
    std::string text = arguments.input + "\n" + run::inspect_table(*report);
    if (!arguments.output.empty()) text += fmt::format("wrote {}\n", arguments.output);
    return end_with(text, written);
}

}  // namespace camber::app
