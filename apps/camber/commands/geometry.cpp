module;
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <variant>
#include <vector>
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
    if (!a.surface.empty()) files.push_back({a.surface, "--surface", Role::output});
    return check_named_files(files).and_then([&](Done) { return check_viewer_output(a.output); }).and_then([&](Done) {
        return check_viewer_output(a.surface);
    });
}

/// The geometry of the arguments, its file read.
Outcome<run::ComparedGeometry> compared(const GeometryArguments& arguments, const Execution& execution) {
    config::Pipeline pipeline;
    if (auto set = set_geometry(arguments, pipeline); !set) return fail(set.error());
    auto source = read_geometry(pipeline.geometry, execution);
    if (!source) return fail(source.error());
    return run::ComparedGeometry{pipeline.geometry, std::move(*source)};
}

/// What was found, and what the file calls its references.
struct Told {
    run::GeometryReport report;
    run::Groups groups;
};

/// The names behind the references of the table's patches and ridges.
std::string names_row(const Told& told) {
    std::string text;
    for (const Group& group : told.groups)
        if (group.dimension < told.report.mesh.dimension && group.dimension > 0)
            text += (text.empty() ? "" : ", ") + run::called(told.groups, group.dimension, group.reference);
    return text.empty() ? text : result_row("names of references", text);
}

Outcome<Told> inspected(const GeometryCommandArguments& arguments, Written& written) {
    if (auto files = check_files(arguments); !files) return fail(files.error());
    Progress progress;
    const std::stop_token stop = stop_on_signals();
    const Around around = steps_shown(progress, {.threads = arguments.threads, .stop = stop});
    auto geometry = compared(arguments.geometry, {.threads = arguments.threads, .stop = stop});
    if (!geometry) return fail(geometry.error());
    if (!arguments.surface.empty()) geometry->surface = run::InspectedSurface::lattice;
    std::optional<DecodedMesh> mesh;
    auto done = around("read", [&](const Execution& execution) -> Outcome<Done> {
        auto decoded = read_mesh(arguments.input, arguments.flat, execution);
        if (!decoded) return fail(decoded.error());
        mesh = std::move(*decoded);
        return Done{};
    });
    if (!done) return fail(done.error());
    const std::optional<Lift> lift = mesh->lift;
    run::Groups groups = run::groups_of(mesh->mesh);
    auto found = run::inspect_geometry(std::move(*mesh), *geometry, arguments.options, around);
    if (!found) {
        progress.wipe();
        return fail(of_file(found.error(), arguments.input));
    }
    if (!arguments.output.empty())
        done = written.add(arguments.output, around("write", [&](const Execution& execution) {
                               return write_for_viewers(found->mesh, found->fields, lift, arguments.output, execution);
                           }));
    if (done && found->surface)
        done =
            written.add(arguments.surface, around("write", [&](const Execution& execution) {
                            return write_for_viewers(std::move(found->surface->mesh), std::move(found->surface->fields),
                                                     lift, arguments.surface, execution);
                        }));
    progress.wipe();
    if (!done) return fail(done.error());
    return Told{std::move(found->report), std::move(groups)};
}

}  // namespace

int geometry_command(const GeometryCommandArguments& arguments) {
    Written written;
    const auto told = inspected(arguments, written);
    if (!told) return report_error(told.error());
    const run::GeometryReport* const report = &told->report;
    if (arguments.json) return end_with(run::inspect_json(*report, arguments.input, CAMBER_VERSION), written);
    for (const std::string& notice : report->notices) tell_note(notice);
    return end_with(called_input(arguments.input) + "\n" + run::inspect_table(*report) + names_row(*told) +
                        wrote_rows({arguments.output, arguments.surface}),
                    written);
}

}  // namespace camber::app
