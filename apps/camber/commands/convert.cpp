module;
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.bezier;
import camber.config;
import camber.io;
import camber.run;
import :ending;
import :execute;
import :formats;
import :named_files;

namespace camber::app {

namespace {

void say(const std::vector<Notice>& notices) {
    for (const Notice& notice : notices) tell("note: " + notice.what);
}

Outcome<Done> check_names(const ConvertArguments& a, bool solution) {
    std::vector<NamedFile> files{{a.input, "the input", solution ? Role::input : Role::input_mesh}};
    if (!a.metric.empty()) files.push_back({a.metric, "--metric", Role::input});
    files.push_back({a.output, "-o", solution ? Role::output : Role::output_mesh});
    return check_named_files(files);
}

Outcome<Done> convert_solution(const ConvertArguments& a, const Execution& execution) {
    if (a.format.empty() && !is_solution_file(a.output))
        return fail(ErrorKind::usage, "a solution cannot be written in the format of this ending", a.output, {},
                    "use " + listed(endings_written(solution_formats())) +
                        "; with its mesh: camber convert MESH -o FILE.vtu --metric " + a.input);
    const auto format = format_to_write(solution_formats(), a.output, a.format);
    if (!format) return fail(format.error());
    if (a.elevate || !a.metric.empty() || a.cells)
        return fail(ErrorKind::usage, "--elevate, --metric and --cells are for meshes");
    auto decoded = read_solution(a.input, execution);
    if (!decoded) return fail(std::move(decoded.error()));
    say(decoded->notices);
    if (auto made = make_folder_of(a.output); !made) return made;
    return write_solution(**format, decoded->solution, a.output, execution);
}

Outcome<AnyMesh> elevated(AnyMesh mesh, const std::string& name, const Execution& execution) {
    return std::visit(
        [&]<class Mesh>(Mesh m) -> Outcome<AnyMesh> {
            if constexpr (requires { elevate(m, execution); })
                return elevate(std::move(m), execution).map([](auto made) { return AnyMesh(std::move(made)); });
            else
                return fail(ErrorKind::usage, "the mesh is quadratic already", name, {}, "leave --elevate out");
        },
        std::move(mesh));
}

/// A solution's fields on the mesh; beside a flat mesh it may be one in 2D.
Outcome<MeshFields> fields_of(const Solution& solution, const std::string& name, const AnyMesh& mesh,
                              const Execution& execution) {
    if (solution.dimension == 2) {
        auto flat = with_flat_in_2d({mesh, {}}, execution);
        if (!flat) return fail(std::move(flat.error()));
        if (flat->lift)
            return run::solution_fields(solution, name, flat->mesh, execution).and_then([&](const MeshFields& fields) {
                return raised(fields, execution);
            });
    }
    return run::solution_fields(solution, name, mesh, execution);
}

std::vector<std::string_view> endings_with_fields() {
    std::vector<std::string_view> endings;
    for (const MeshFormat& format : mesh_formats())
        if (format.encode && format.holds_fields)
            endings.insert(endings.end(), format.endings.begin(), format.endings.end());
    return endings;
}

Outcome<Done> convert_mesh(const ConvertArguments& a, const Execution& execution) {
    const auto found = format_to_write(mesh_formats(), a.output, a.format);
    if (!found) return fail(found.error());
    const MeshFormat& format = **found;
    if ((!format.holds_fields && !a.metric.empty()) || (!format.chooses_cells && a.cells))
        return fail(ErrorKind::usage, "--metric and --cells are for " + listed(endings_with_fields()), a.output, {},
                    format.holds_fields ? "leave --cells out"
                                        : "a GMF mesh has no place for fields: convert the .sol beside it");
    auto decoded = read_mesh(a.input, config::Flat::surface, execution);
    if (!decoded) return fail(std::move(decoded.error()));
    say(decoded->notices);
    AnyMesh mesh = std::move(decoded->mesh);
    if (a.elevate) {
        auto made = elevated(std::move(mesh), a.input, execution);
        if (!made) return fail(std::move(made.error()));
        mesh = std::move(*made);
    }
    MeshFields fields;
    if (!a.metric.empty()) {
        auto solution = read_solution(a.metric, execution);
        if (!solution) return fail(std::move(solution.error()));
        say(solution->notices);
        auto made = fields_of(solution->solution, a.metric, mesh, execution);
        if (!made) return fail(std::move(made.error()));
        fields = std::move(*made);
    }
    say(format.losses(mesh));
    if (auto made = make_folder_of(a.output); !made) return made;
    return write_mesh(format, mesh, fields, EncodeOptions{a.cells.value_or(EncodeOptions{}.cells)}, a.output,
                      execution);
}

}  // namespace

int convert_command(const ConvertArguments& arguments) {
    const bool solution = is_solution_file(arguments.input) || is_solution_file(arguments.output);
    if (auto distinct = check_names(arguments, solution); !distinct) return report_error(distinct.error());
    const Execution execution{.threads = arguments.threads, .stop = stop_on_signals()};
    auto done = solution ? convert_solution(arguments, execution) : convert_mesh(arguments, execution);
    Written written;
    if (done = written.add(arguments.output, std::move(done)); !done) return report_error(done.error());
    return end_with(fmt::format("wrote {}\n", arguments.output), written);
}

}  // namespace camber::app
