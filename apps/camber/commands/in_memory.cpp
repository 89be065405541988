module;
#include <cstddef>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.config;
import camber.io;
import camber.run;
import camber.transfer;
import :ending;
import :execute;
import :formats;
import :given;
import :in_memory;
import :inputs;
import :nodal_fields;
import :steps_for;

namespace camber::app {

namespace {

/// A run returns the metric and the fields that its outputs ask for.
void keep_all(config::Output& output) {
    if (output.metric.empty()) output.metric = std::string(config::in_memory) + "metric";
    if (output.solution.empty()) output.solution = std::string(config::in_memory) + "solution";
}

/// Of the input, as far as a run keeps it: where it lies in space, and its format.
DecodedMesh with_place_of(AnyMesh made, const DecodedMesh& input) {
    DecodedMesh mesh{std::move(made), {}};
    mesh.lift = input.lift;
    mesh.always_in_space = input.always_in_space;
    mesh.format = input.format;
    return mesh;
}

}  // namespace

MadeInMemory made_of(run::Run run, const DecodedMesh& input) {
    std::vector<std::string> notices = run.report.notices;
    const bool holds = run.report.holds_what_was_asked();
    const bool is_valid = run.report.has_valid_elements();
    std::string report = run::to_json(run.report);
    return {with_place_of(std::move(run.mesh), input),
            std::move(report),
            std::move(run.metric),
            std::move(run.solution),
            std::move(notices),
            holds,
            is_valid};
}

Outcome<MadeInMemory> run_in_memory(config::Pipeline pipeline, Host host) {
    keep_all(pipeline.output);
    DecodedMesh input;
    if (const auto* const file = std::get_if<config::FilePath>(&pipeline.input.source))
        if (const auto found = host.given.meshes.find(file->path); found != host.given.meshes.end()) {
            input.lift = found->second.lift;
            input.always_in_space = found->second.always_in_space;
            input.format = found->second.format;
        }
    Written written;
    const Fit fit = [](config::Pipeline asked, const AnyMesh& mesh) -> Outcome<config::Pipeline> {
        return run::fitted_to(mesh, std::move(asked), 1);
    };
    auto run = execute(pipeline, written, fit, std::move(host));
    if (!run) return fail(run.error());
    return made_of(std::move(*run), input);
}

Outcome<MetricInMemory> metric_in_memory(const config::Pipeline& pipeline, Host host) {
    Progress progress(host.told);
    const Around around = steps_for(progress, host, pipeline.threads);
    auto inputs = run_step(around, "read", [&](const Execution& e) { return read_inputs(pipeline, host.given, e); });
    if (!inputs) return fail(inputs.error());
    auto made = run::made_metric(pipeline, std::move(*inputs), around);
    if (!made) return fail(made.error());
    return MetricInMemory{std::move(made->metric), made->report.complexity, made->report.largest_anisotropy,
                          std::move(made->notices)};
}

Outcome<Solution> hessians_in_memory(const DecodedMesh& mesh, const run::NamedField& field, Host host) {
    Progress progress(host.told);
    return run_step(steps_for(progress, host, 0), "recover",
                    [&](const Execution& e) { return run::hessians_of(mesh.mesh, field, e); });
}

Outcome<std::vector<run::NamedField>> transfer_in_memory(const DecodedMesh& old_mesh, const DecodedMesh& new_mesh,
                                                         std::vector<run::NamedField> fields,
                                                         const TransferOptions& options, Host host) {
    Progress progress(host.told);
    const Around around = steps_for(progress, host, 0);
    return run::fields_brought_to(new_mesh.mesh, old_mesh.mesh, std::move(fields), options, around)
        .map([](run::TransferredFields made) { return std::move(made.fields); });
}

Outcome<DecodedMesh> read_into_memory(const std::string& path, config::Flat flat, const DecodeOptions& options,
                                      Host host) {
    Progress progress(host.told);
    return run_step(steps_for(progress, host, 0), "read",
                    [&](const Execution& e) { return read_mesh(path, flat, options, e); });
}

Outcome<std::vector<std::string>> write_from_memory(const DecodedMesh& mesh, const std::vector<run::NamedField>& fields,
                                                    const std::string& path, const std::string& name, Host host) {
    const auto format = format_of_mesh(path, name, mesh.format);
    if (!format) return fail(format.error());
    std::vector<std::string> losses;
    std::vector<run::NamedField> held;
    for (const run::NamedField& field : fields)
        if ((*format)->holds_fields && check_place_for(path, name, field.kind))
            held.push_back(field);
        else
            losses.push_back("the format has no place for the field " + field.name);
    Progress progress(host.told);
    auto done = run_step(steps_for(progress, host, 0), "write",
                         [&](const Execution& e) { return write_with_mesh(mesh, held, **format, path, e); });
    if (!done) return fail(done.error());
    for (Notice& notice : (*format)->losses(mesh.mesh)) losses.push_back(std::move(notice.what));
    return losses;
}

std::vector<run::NamedField> nodal_fields_of(const DecodedMesh& mesh) {
    std::vector<Notice> ignored;
    return fields_at_nodes(mesh, ignored);
}

}  // namespace camber::app
