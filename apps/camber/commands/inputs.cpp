module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.io;
import camber.surface;
import camber.cad;
import camber.config;
import camber.recipes;
import camber.reports;
import camber.app_shell;
import :execution;

namespace camber::app {

namespace {

/// First argument of the process that reads a CAD file. The file, seconds and bytes follow.
constexpr std::string_view reader = "--read-cad-file-for-parent";

ChildLimits limits_of(const config::Cad& cad) {
    constexpr double seconds = 10, seconds_a_megabyte = 1, megabyte = 1e6, gigabyte = 1e9, memory_a_byte = 50;
    std::error_code missing;
    const auto found = std::filesystem::file_size(cad.file.path, missing);
    const double size = missing ? 0 : static_cast<double>(found);
    const double memory = cad.memory > 0 ? cad.memory * megabyte : gigabyte + memory_a_byte * size;
    return {cad.timeout > 0 ? cad.timeout : seconds + seconds_a_megabyte * size / megabyte,
            static_cast<std::size_t>(memory)};
}

/// Rejects pipes and devices, which may have no end. The reader reports a missing file.
Outcome<Done> check_plain(const std::string& path) {
    std::error_code ignored;
    const auto status = std::filesystem::status(path, ignored);
    if (!std::filesystem::is_other(status)) return Done{};
    return fail(ErrorKind::input, "is not a regular file, which a CAD model must be", path, {},
                "copy it to a regular file");
}

/// Encodes an error: 'E', its kind, and its parts, each with a final zero byte. A model's encoding begins with 'M'.
std::string as_bytes_of(const Error& error) {
    std::string bytes = "E" + std::to_string(static_cast<int>(error.kind));
    const std::string kind = error.entity ? error.entity->kind : std::string();
    const std::string number = error.entity ? std::to_string(error.entity->number) : "0";
    for (const std::string& part : {std::string(), error.what, error.where, error.remedy, kind, number})
        bytes += part + '\0';
    return bytes;
}
Error error_of(std::string_view bytes) {
    std::array<std::string, 6> parts;
    bytes.remove_prefix(1);
    for (std::string& part : parts) {
        const std::size_t end = std::min(bytes.find('\0'), bytes.size());
        part = bytes.substr(0, end);
        bytes.remove_prefix(std::min(end + 1, bytes.size()));
    }
    const auto& [kind, what, where, remedy, entity, number] = parts;
    Error error{static_cast<ErrorKind>(std::stoi(kind)), what, where, {}, remedy};
    if (!entity.empty()) error.entity = Entity{entity, std::stoull(number)};
    return error;
}

/// Reads the model and evaluates its faces and edges, so that a failure occurs in this process and not in the parent.
Outcome<std::string> read_and_tried(const std::string& path) {
    constexpr std::size_t tries = 1000;
    const auto model = read_cad(path, {});
    if (!model) return fail(model.error());
    if (const auto samples = samples_of<3>(*model, tries, {.threads = 1}); !samples) return fail(samples.error());
    return packed_cad(*model);
}

Error of_end(const ChildResult& result, const config::Cad& cad, const ChildLimits& limits) {
    if (result.end == ChildEnd::out_of_time)
        return {ErrorKind::input,
                fmt::format("reading it takes more than {:.3g} s", limits.seconds),
                cad.file.path,
                {},
                "export the model again; if it is correct, increase --cad-timeout or geometry/cad/timeout"};
    return {ErrorKind::input,
            fmt::format("OpenCASCADE crashes on it ({}): the file is damaged", result.how),
            cad.file.path,
            {},
            "export the model again"};
}

Error out_of_memory(const config::Cad& cad, const ChildLimits& limits) {
    return {ErrorKind::input,
            fmt::format("reading it takes more than {:.3g} MB of memory", static_cast<double>(limits.bytes) / 1e6),
            cad.file.path,
            {},
            "export the model again; if it is correct, increase --cad-memory or geometry/cad/memory"};
}

/// Reads the model of a config's file in a child process. A damaged file that crashes the reader, never ends or takes
/// all memory causes an error (input). Errors: also those of read_cad.
Outcome<CadModel> read_cad_in_child(const config::Cad& cad, const Execution& execution) {
    return guarded([&]() -> Outcome<CadModel> {
        if (auto plain = check_plain(cad.file.path); !plain) return fail(plain.error());
        if (!can_start_itself()) return read_cad(cad.file.path, {cad.unit});
        const ChildLimits limits = limits_of(cad);
        const auto result = run_self(
            {std::string(reader), cad.file.path, fmt::format("{}", limits.seconds), fmt::format("{}", limits.bytes)},
            limits, execution);
        if (!result) return fail(result.error());
        if (result->end != ChildEnd::done || result->bytes.empty()) return fail(of_end(*result, cad, limits));
        if (result->bytes.front() == 'E') {
            Error error = error_of(result->bytes);
            return fail(error.kind == ErrorKind::memory ? out_of_memory(cad, limits) : std::move(error));
        }
        auto model = unpacked_cad(result->bytes.substr(1), {cad.unit});
        if (!model && model.error().where.empty()) {
            Error error = model.error();
            error.where = cad.file.path;
            return fail(std::move(error));
        }
        return model;
    });
}

std::string operations_at_vertices(const std::string& file) {
    return file +
           " has a metric at all nodes: metric_operations use only its values at the vertices. A run without "
           "metric_operations uses all values";
}

template <class Values>
const typename Values::mapped_type* found(const Values& values, const std::string& name) {
    const auto at = config::is_in_memory(name) ? values.find(name) : values.end();
    return at != values.end() ? &at->second : nullptr;
}

Outcome<DecodedMesh> mesh_named(const std::string& name, config::Flat flat, const MemoryInputs& specified,
                                const Execution& execution) {
    if (const DecodedMesh* const mesh = found(specified.meshes, name)) return *mesh;
    return read_mesh(name, flat, execution);
}

Outcome<run::RowsByNodes> metric_named(const DecodedMesh& mesh, const std::string& name, const MemoryInputs& specified,
                                       std::vector<Notice>& notices, const Execution& execution) {
    if (const Solution* const rows = found(specified.metrics, name))
        return run::rows_by_nodes(*rows, mesh, without_progress(execution));
    return read_metric_rows(mesh, name, notices, execution);
}

/// Reads the metric file, and its mesh if that is another one, or a curved one with rows at its nodes.
Outcome<Solution> read_metric_of(const config::Pipeline& pipeline, const config::FilePath& metric, run::Inputs& inputs,
                                 const MemoryInputs& specified, const Execution& execution) {
    std::vector<Notice>& notices = inputs.mesh.notices;
    if (pipeline.metric_mesh.empty()) {
        auto rows = metric_named(inputs.mesh, metric.path, specified, notices, execution);
        if (!rows) return fail(rows.error());
        if (rows->is_at_nodes) {
            inputs.metric_mesh = {inputs.mesh.mesh, run::MetricMesh::Of::input};
            if (!pipeline.metric_operations.empty()) notices.push_back({operations_at_vertices(metric.path)});
        }
        return std::move(rows->solution);
    }
    auto mesh = mesh_named(pipeline.metric_mesh, pipeline.input.flat, specified, part_of(execution, 0, 0.6));
    if (!mesh) return fail(mesh.error());
    auto rows = metric_named(*mesh, metric.path, specified, notices, part_of(execution, 0.6, 1));
    if (!rows) return fail(rows.error());
    inputs.metric_mesh = {std::move(mesh->mesh), run::MetricMesh::Of::another};
    return std::move(rows->solution);
}

void select_finite(std::vector<run::NamedField>& fields, std::vector<Notice>& notices) {
    std::erase_if(fields, [&](const run::NamedField& field) {
        const bool is_finite = std::ranges::all_of(field.field.values, [](double x) { return std::isfinite(x); });
        if (!is_finite)
            notices.push_back({fmt::format("the field {} is omitted: some of its values are not finite", field.name)});
        return !is_finite;
    });
}

Outcome<Done> read_solution_of(const config::Pipeline& pipeline, run::Inputs& inputs, const MemoryInputs& values,
                               const Execution& execution) {
    const config::SolutionInput& specified = pipeline.solution;
    std::vector<Notice>& notices = inputs.mesh.notices;
    if (const auto* const known = found(values.solutions, specified.file)) {
        auto fields = run::named(*known, specified.fields, "/solution/fields");
        if (!fields) return fail(fields.error());
        inputs.fields = std::move(*fields);
    } else if (!specified.file.empty()) {
        auto fields = read_nodal_fields(inputs.mesh, specified.file, specified.fields, notices, execution);
        if (!fields) return fail(fields.error());
        inputs.fields = std::move(*fields);
    } else if (!specified.expression.empty()) {
        auto field = run::field_of_expression(inputs.mesh.mesh, specified.expression, execution);
        if (!field) return fail(field.error());
        inputs.fields = {std::move(*field)};
    } else if (!inputs.mesh.fields.empty() && run::plan_size(inputs.mesh.mesh).elements == 0) {
        notices.push_back(
            {fmt::format("{} fields of the file were omitted: fields can only be transferred on volume meshes",
                         inputs.mesh.fields.size())});
    } else if (!inputs.mesh.fields.empty()) {
        auto fields = run::named(fields_at_nodes(inputs.mesh, notices), specified.fields, "/solution/fields");
        if (!fields) return fail(fields.error());
        select_finite(*fields, notices);
        inputs.fields = std::move(*fields);
    } else if (!specified.fields.empty()) {
        return fail(ErrorKind::usage, "the input has no fields", "/solution/fields", {}, "give the file that has them");
    }
    if (!inputs.fields.empty() && specified.expression.empty() && !run::places_by_solution(pipeline) &&
        !run::carries_fields(pipeline.output))
        notices.push_back(
            {fmt::format("{} of the input {} not written: {} cannot store {} (use \"output\": {{\"solution\": …}}, "
                         "--output-solution, or a .vtu)",
                         inputs.fields.size() == 1 ? "the field " + inputs.fields.front().name
                                                   : fmt::format("{} fields", inputs.fields.size()),
                         inputs.fields.size() == 1 ? "is" : "are",
                         pipeline.output.mesh.empty() ? "the output" : pipeline.output.mesh,
                         inputs.fields.size() == 1 ? "it" : "them")});
    for (const run::NamedField& field : inputs.fields)
        if (auto place = check_place_for(pipeline.output.solution, {}, field.kind); !place) return place;
    const auto add = [&](const config::Metric& metric, const std::string& path) -> Outcome<Done> {
        const auto* const requested = std::get_if<config::SolutionMetric>(&metric);
        if (requested == nullptr) return Done{};
        std::vector<Solution> metrics;
        for (const config::FilePath& file : requested->intersect) {
            auto rows = metric_named(inputs.mesh, file.path, values, notices, execution);
            if (!rows) return fail(rows.error());
            metrics.push_back(run::rows_at_vertices(std::move(*rows), inputs.mesh.mesh));
        }
        inputs.solution_metrics.push_back({*requested, std::move(metrics), path + "/solution"});
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

std::optional<int> cad_reader(std::span<const char* const> arguments) {
    if (arguments.size() != 5 || arguments[1] != reader) return std::nullopt;
    set_limits({std::stod(arguments[3]), static_cast<std::size_t>(std::stod(arguments[4]))});
    const auto bytes = read_and_tried(arguments[2]);
    return hand_over(bytes ? "M" + *bytes : as_bytes_of(bytes.error())) ? 0 : 1;
}

Outcome<run::GeometrySource> read_geometry(const config::Geometry& geometry, const Execution& execution,
                                           const MemoryInputs& specified) {
    run::GeometrySource source;
    if (const auto* cad = std::get_if<config::Cad>(&geometry)) {
        auto model = read_cad_in_child(*cad, execution);
        if (!model) return fail(model.error());
        source.cad = std::move(*model);
    }
    if (const auto* file = std::get_if<config::FilePath>(&geometry)) {
        auto mesh = mesh_named(file->path, config::Flat::plane, specified, execution);
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

namespace {

bool differ_by_one_edit(std::string_view a, std::string_view b) {
    while (!a.empty() && !b.empty() && a.front() == b.front()) a.remove_prefix(1), b.remove_prefix(1);
    while (!a.empty() && !b.empty() && a.back() == b.back()) a.remove_suffix(1), b.remove_suffix(1);
    if (a.size() == 2 && b.size() == 2) return a[0] == b[1] && a[1] == b[0];
    return a.size() <= 1 && b.size() <= 1;
}

bool is_beginning(std::string_view word, std::string_view whole) { return word.size() >= 4 && whole.starts_with(word); }

/// Returns `did you mean "wing.mesh"?` if the file's folder has a similar name or another ending; otherwise empty.
std::string suggested_file(const std::string& path) {
    namespace fs = std::filesystem;
    constexpr std::size_t most = 10000;  // files of a folder to examine
    const fs::path specified(path);
    std::vector<std::string> same_stem, near;
    std::error_code error;
    if (fs::exists(specified, error)) return {};
    std::size_t n = 0;
    const fs::path folder = specified.parent_path().empty() ? fs::path(".") : specified.parent_path();
    for (auto at = fs::directory_iterator(folder, error); !error && at != fs::directory_iterator() && n < most;
         at.increment(error), ++n) {
        const fs::path name = at->path().filename();
        if (name.stem() == specified.stem()) same_stem.push_back(name.string());
        if (differ_by_one_edit(name.string(), specified.filename().string())) near.push_back(name.string());
    }
    auto& found = near.empty() ? same_stem : near;
    if (found.empty()) return {};
    const std::string best = *std::ranges::min_element(found);
    return fmt::format("did you mean \"{}\"?", (specified.parent_path() / best).string());
}

DecodeOptions with_file_reader(const std::string& path, DecodeOptions options, const Execution& execution) {
    const auto folder = std::filesystem::path(path == standard_stream ? std::string() : path).parent_path();
    options.beside = [folder, quiet = without_progress(execution)](const std::string& name) {
        return read_file((folder / name).string(), quiet);
    };
    return options;
}

}  // namespace

Outcome<DecodedMesh> read_mesh(const std::string& path, config::Flat flat, const DecodeOptions& options,
                               const Execution& execution) {
    constexpr double of_reading = 0.4;  // fraction of the time; 0.5 for a straight mesh, 0.3 for a curved one
    auto bytes = read_file(path, part_of(execution, 0, of_reading), bound_of_mesh(path));
    if (!bytes) {
        Error error = bytes.error();
        if (const std::string near = suggested_file(path); !near.empty()) error.remedy = near;
        return fail(std::move(error));
    }
    auto decoded = decode_mesh(*bytes, called_input(path), with_file_reader(path, options, execution),
                               part_of(execution, of_reading, 1));
    if (!decoded || flat == config::Flat::surface || !decoded->unsupported_cells.empty()) return decoded;
    decoded = with_flat_in_2d(std::move(*decoded), without_progress(execution));
    if (decoded && decoded->lift)
        decoded->notices.push_back(
            {fmt::format("the mesh is flat (z = {}): read as 2D{} (for a surface in space: --flat surface, or "
                         "input/flat=surface of a config)",
                         decoded->lift->z, decoded->is_always_3d ? "" : ", and written with its z")});
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

Outcome<run::Inputs> read_inputs(const config::Pipeline& pipeline, const MemoryInputs& specified,
                                 const Execution& execution) {
    const config::Input& input = pipeline.input;
    const auto* file = std::get_if<config::FilePath>(&input.source);
    const auto* const metric = std::get_if<config::FilePath>(&pipeline.metric);
    const double of_mesh = metric != nullptr ? 0.7 : 1;
    const Execution of_first = part_of(execution, 0, of_mesh);
    auto mesh = file != nullptr ? mesh_named(file->path, input.flat, specified, of_first)
                                : run::generate_shape(std::get<config::Shape>(input.source), of_first);
    if (!mesh) return fail(mesh.error());
    name_references(mesh->mesh, specified.groups);
    run::Inputs inputs{std::move(*mesh)};
    inputs.memory = available_memory();
    if (auto read = read_solution_of(pipeline, inputs, specified, without_progress(execution)); !read)
        return fail(read.error());
    if (metric == nullptr && !pipeline.metric_mesh.empty())
        return fail(ErrorKind::usage, "is the mesh of a metric file, but the metric is not a file", "/metric_mesh", {},
                    "give \"metric\": {\"file\": …}, or leave it out");
    if (metric != nullptr) {
        auto solution = read_metric_of(pipeline, *metric, inputs, specified, part_of(execution, of_mesh, 1));
        if (!solution) return fail(solution.error());
        inputs.metric = std::move(*solution);
    }
    auto geometry = read_geometry(pipeline.geometry, without_progress(execution), specified);
    if (!geometry) return fail(geometry.error());
    inputs.geometry = std::move(*geometry);
    for (const config::MetricOperation& operation : pipeline.metric_operations) {
        const auto* intersect = std::get_if<config::Intersect>(&operation);
        const auto* operand = intersect != nullptr ? std::get_if<config::FilePath>(&intersect->metric) : nullptr;
        if (operand == nullptr) continue;
        auto read =
            metric_named(inputs.mesh, operand->path, specified, inputs.mesh.notices, without_progress(execution));
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

std::string suggestion(std::string_view word, const std::vector<std::string>& known) {
    const auto near = std::find_if(known.begin(), known.end(), [&](const std::string& candidate) {
        return differ_by_one_edit(word, candidate) || is_beginning(word, candidate);
    });
    if (near != known.end()) return fmt::format("did you mean \"{}\"?", *near);
    return fmt::format("known: {}", fmt::join(known, ", "));
}

}  // namespace camber::app
