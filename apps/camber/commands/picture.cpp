module;
#include <cstddef>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.config;
import camber.drawing;
import camber.io;
import camber.run;
import :ending;
import :execute;
import :formats;
import :named_files;
import :nodal_fields;
import :picture_words;

namespace camber::app {

namespace {

bool is_svg(const std::string& path) { return path.ends_with(".svg"); }

Outcome<Done> check_files(const PictureArguments& a) {
    std::vector<NamedFile> files{{a.input, "the input", Role::input}, {a.output, "-o", Role::output}};
    if (!a.metric.empty()) files.push_back({a.metric, "--metric", Role::input});
    if (!a.solution.empty() && a.solution != a.input) files.push_back({a.solution, "--solution", Role::input});
    if (auto distinct = check_named_files(files); !distinct) return distinct;
    if (!a.field.empty() && a.solution.empty())
        return fail(ErrorKind::usage, "is of a solution, and there is none", "--field", {},
                    "give --solution FILE; the mesh's own file may be it");
    if (!is_svg(a.output) && !a.output.ends_with(".png"))
        return fail(ErrorKind::usage, "is no ending of a picture", a.output, {}, "name a .png or a .svg file");
    return check_writable(a.output);
}

/// The field that is asked for, or the first that there is.
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
    for (const Notice& notice : notices) tell_note(notice.what);
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

Outcome<Done> draw(const PictureArguments& a, Written& written) {
    auto choice = choice_of(a);
    if (!choice) return fail(choice.error());
    if (auto files = check_files(a); !files) return files;
    Progress progress;
    const std::stop_token stop = stop_on_signals();
    const Around around = steps_shown(progress, {.threads = a.threads, .stop = stop});
    auto inputs = run_step(around, "read", [&](const Execution& e) { return inputs_of(a, e); });
    if (!inputs) return fail(inputs.error());
    const auto scene =
        run_step(around, "prepare", [&](const Execution& e) { return run::picture_of(*inputs, *choice, e); });
    if (!scene) return fail(of_file(scene.error(), a.input));
    auto done = run_step(around, "draw", [&](const Execution& e) { return write_picture(*scene, a.output, e); });
    progress.wipe();
    return written.add(a.output, std::move(done));
}

}  // namespace

int picture_command(const PictureArguments& arguments) {
    Written written;
    if (auto done = draw(arguments, written); !done) return report_error(done.error());
    return end_with(wrote_rows({arguments.output}), written);
}

}  // namespace camber::app
