module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.cad;
import camber.config;
import camber.io;
import camber.run;
import camber.app_shell;
import :cad_reader;
import :execute;
import :formats;
import :inputs;
import :nodal_fields;
import :suggestion;

namespace camber::app {

namespace {

std::string operations_at_vertices(const std::string& file) {
    return file +
           " has a metric at all nodes: metric_operations are done at the vertices, with what it has there; a run "
           "without them takes all of it";
}

/// The metric file, and the mesh that it speaks of where that is another, or curved with rows at its nodes.
Outcome<Solution> read_metric_of(const config::Pipeline& pipeline, const config::FilePath& metric, run::Inputs& inputs,
                                 const Execution& execution) {
    std::vector<Notice>& notices = inputs.mesh.notices;
    if (pipeline.metric_mesh.empty()) {
        auto rows = read_metric_rows(inputs.mesh, metric.path, notices, execution);
        if (!rows) return fail(rows.error());
        if (rows->is_at_nodes) {
            inputs.metric_mesh = {inputs.mesh.mesh, run::MetricMesh::Of::input};
            if (!pipeline.metric_operations.empty()) notices.push_back({operations_at_vertices(metric.path)});
        }
        return std::move(rows->solution);
    }
    auto mesh = read_mesh(pipeline.metric_mesh, pipeline.input.flat, part_of(execution, 0, 0.6));
    if (!mesh) return fail(mesh.error());
    auto rows = read_metric_rows(*mesh, metric.path, notices, part_of(execution, 0.6, 1));
    if (!rows) return fail(rows.error());
    inputs.metric_mesh = {std::move(mesh->mesh), run::MetricMesh::Of::another};
    return std::move(rows->solution);
}

/// Fields that cannot be brought along are told, where nobody asked for them by their file.
void keep_finite(std::vector<run::NamedField>& fields, std::vector<Notice>& notices) {
    std::erase_if(fields, [&](const run::NamedField& field) {
        const bool is_finite = std::ranges::all_of(field.field.values, [](double x) { return std::isfinite(x); });
        if (!is_finite)
            notices.push_back({fmt::format("the field {} is left out: not all of it is a number", field.name)});
        return !is_finite;
    });
}

/// The fields that go along, and what the config's metrics that are made for them take.
Outcome<Done> read_solution_of(const config::Pipeline& pipeline, run::Inputs& inputs, const Execution& execution) {
    const config::GivenSolution& given = pipeline.solution;
    std::vector<Notice>& notices = inputs.mesh.notices;
    if (!given.file.empty()) {
        auto fields = read_nodal_fields(inputs.mesh, given.file, given.fields, notices, execution);
        if (!fields) return fail(fields.error());
        inputs.fields = std::move(*fields);
    } else if (!given.expression.empty()) {
        auto field = run::field_of_expression(inputs.mesh.mesh, given.expression, execution);
        if (!field) return fail(field.error());
        inputs.fields = {std::move(*field)};
    } else if (!inputs.mesh.fields.empty() && run::plan_size(inputs.mesh.mesh).elements == 0) {
        notices.push_back(
            {fmt::format("{} fields of the file were not kept: they go along in meshes of the volume alone",
                         inputs.mesh.fields.size())});
    } else if (!inputs.mesh.fields.empty()) {
        auto fields = run::named(fields_at_nodes(inputs.mesh, notices), given.fields, "/solution/fields");
        if (!fields) return fail(fields.error());
        keep_finite(*fields, notices);
        inputs.fields = std::move(*fields);
    } else if (!given.fields.empty()) {
        return fail(ErrorKind::usage, "the input has no fields", "/solution/fields", {}, "give the file that has them");
    }
    if (!inputs.fields.empty() && given.expression.empty() && !run::places_by_solution(pipeline) &&
        !run::carries_fields(pipeline.output))
        notices.push_back(
            {fmt::format("{} of the input {} not kept: {} has no place for {} (\"output\": "
                         "{{\"solution\": …}}, --output-solution, or a .vtu has)",
                         inputs.fields.size() == 1 ? "the field " + inputs.fields.front().name
                                                   : fmt::format("{} fields", inputs.fields.size()),
                         inputs.fields.size() == 1 ? "is" : "are",
                         pipeline.output.mesh.empty() ? "the output" : pipeline.output.mesh,
                         inputs.fields.size() == 1 ? "it" : "them")});
    for (const run::NamedField& field : inputs.fields)
        if (auto place = check_place_for(pipeline.output.solution, {}, field.kind); !place) return place;
    const auto add = [&](const config::Metric& metric, const std::string& path) -> Outcome<Done> {
        const auto* const asked = std::get_if<config::SolutionMetric>(&metric);
        if (asked == nullptr) return Done{};
        auto metrics = read_metrics_at_vertices(inputs.mesh, asked->intersect, notices, execution);
        if (!metrics) return fail(metrics.error());
        inputs.solution_metrics.push_back({*asked, std::move(*metrics), path + "/solution"});
        return Done{};
    };
    if (auto done = add(pipeline.metric, "/metric"); !done) return done;
    for (std::size_t k = 0; k < pipeline.metric_operations.size(); ++k)
        if (const auto* intersect = std::get_if<config::Intersect>(&pipeline.metric_operations[k]))
            if (auto done = add(intersect->metric, fmt::format("/metric_operations/{}/intersect", k)); !done)
                return done;
    return Done{};
}

run::AvailableMemory available_memory() {
    const MemoryLimit limit = memory_limit();
    return {limit.bytes, limit.source};
}

}  // namespace

Outcome<run::GeometrySource> read_geometry(const config::Geometry& geometry, const Execution& execution) {
    run::GeometrySource source;
    if (const auto* cad = std::get_if<config::Cad>(&geometry)) {
        auto model = read_cad_apart(*cad, execution);
        if (!model) return fail(model.error());
        source.cad = std::move(*model);
    }
    if (const auto* file = std::get_if<config::FilePath>(&geometry)) {
        auto mesh = read_mesh(file->path, config::Flat::plane, execution);
        if (!mesh) return fail(mesh.error());
        source.mesh = std::make_shared<const AnyMesh>(std::move(mesh->mesh));
    }
    return source;
}

Error of_file(Error error, const std::string& path) {
    const bool about_file = error.kind == ErrorKind::input || error.kind == ErrorKind::unsupported;
    if (about_file && error.where.empty()) error.where = path;
    return error;
}

Outcome<DecodedMesh> read_mesh(const std::string& path, config::Flat flat, const DecodeOptions& options,
                               const Execution& execution) {
    constexpr double of_reading = 0.4;  // of the time; 0.5 of a straight mesh, 0.3 of a curved one
    auto bytes = read_file(path, part_of(execution, 0, of_reading));
    if (!bytes) {
        Error error = bytes.error();
        if (const std::string near = suggested_file(path); !near.empty()) error.remedy = near;
        return fail(std::move(error));
    }
    auto decoded = decode_mesh(*bytes, called_input(path), options, part_of(execution, of_reading, 1));
    if (!decoded || flat == config::Flat::surface || !decoded->unheld.empty()) return decoded;
    decoded = with_flat_in_2d(std::move(*decoded), without_progress(execution));
    if (decoded && decoded->lift)
        decoded->notices.push_back(
            {fmt::format("the mesh is flat (z = {}): taken as 2D{} (a surface in space: --flat surface, or "
                         "input/flat=surface of a config)",
                         decoded->lift->z, decoded->always_in_space ? "" : ", and written with its z again")});
    return decoded;
}

Outcome<DecodedSolution> read_solution_for(const DecodedMesh& mesh, const std::string& path,
                                           const Execution& execution) {
    auto decoded = read_solution(path, execution);
    if (!decoded || !mesh.lift) return decoded;
    auto flat = flattened(std::move(decoded->solution), without_progress(execution));
    if (!flat) return fail(std::move(flat.error()));
    decoded->solution = std::move(*flat);
    return decoded;
}

Outcome<run::Inputs> read_inputs(const config::Pipeline& pipeline, const Execution& execution) {
    const config::Input& input = pipeline.input;
    const auto* file = std::get_if<config::FilePath>(&input.source);
    const auto* const metric = std::get_if<config::FilePath>(&pipeline.metric);
    const double of_mesh = metric != nullptr ? 0.7 : 1;
    const Execution of_first = part_of(execution, 0, of_mesh);
    auto mesh = file != nullptr ? read_mesh(file->path, input.flat, of_first)
                                : run::generate_shape(std::get<config::Shape>(input.source), of_first);
    if (!mesh) return fail(mesh.error());
    run::Inputs inputs{std::move(*mesh)};
    inputs.memory = available_memory();
    if (auto read = read_solution_of(pipeline, inputs, without_progress(execution)); !read) return fail(read.error());
    if (metric == nullptr && !pipeline.metric_mesh.empty())
        return fail(ErrorKind::usage, "is the mesh of a metric file, and the metric is none", "/metric_mesh", {},
                    "give \"metric\": {\"file\": …}, or leave it out");
    if (metric != nullptr) {
        auto solution = read_metric_of(pipeline, *metric, inputs, part_of(execution, of_mesh, 1));
        if (!solution) return fail(solution.error());
        inputs.metric = std::move(*solution);
    }
    auto geometry = read_geometry(pipeline.geometry, without_progress(execution));
    if (!geometry) return fail(geometry.error());
    inputs.geometry = std::move(*geometry);
    for (const config::MetricOperation& operation : pipeline.metric_operations) {
        const auto* intersect = std::get_if<config::Intersect>(&operation);
        const auto* operand = intersect != nullptr ? std::get_if<config::FilePath>(&intersect->metric) : nullptr;
        if (operand == nullptr) continue;
        auto read = read_metric_rows(inputs.mesh, operand->path, inputs.mesh.notices, without_progress(execution));
        if (!read) return fail(read.error());
        run::MetricFile rows{operand->path, std::move(read->solution)};
        if (read->is_at_nodes) {
            rows.mesh = {inputs.mesh.mesh, run::MetricMesh::Of::input};
            inputs.mesh.notices.push_back({operations_at_vertices(operand->path)});
        }
        inputs.operands.push_back(std::move(rows));
    }
    return inputs;
}

}  // namespace camber::app
