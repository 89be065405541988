module;
#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.bezier;
import camber.transfer;
import camber.io;
import camber.distributed;
import camber.app_shell;
import camber.config;
import camber.recipes;
import camber.reports;
import :execution;

namespace camber::app {

namespace {

void say(const std::vector<Notice>& notices) {
    for (const Notice& notice : notices) print_note(notice.what);
}

Outcome<Done> check_names(const ConvertArguments& a, bool solution) {
    return check_named_files({{a.input, "the input", solution ? Role::input : Role::input_mesh},
                              {a.metric, "--metric", Role::input},
                              {a.output, "-o", solution ? Role::output : Role::output_mesh}},
                             a.force);
}

std::size_t fields_with_z(const MeshFields& fields) {
    std::size_t count = 0;
    for (const MeshField& field : fields) {
        const std::vector<bool> has_z = involves_z(field.kind);
        const bool any = std::visit(
            [&](const auto& values) {
                for (std::size_t i = 0; i < values.size(); ++i)
                    if (has_z[i % has_z.size()] && values[i] != 0) return true;
                return false;
            },
            field.values);
        count += any ? 1 : 0;
    }
    return count;
}

/// Reads a mesh: a flat one always in 2D, even in a format with 3 coordinates, with notices of the omitted data.
Outcome<DecodedMesh> read_in_own_dimension(const std::string& path, const DecodeOptions& options,
                                           const Execution& execution) {
    auto decoded = read_mesh(path, config::Flat::surface, options, execution);
    if (!decoded || !decoded->is_always_3d) return decoded;
    const MeshFields in_space = decoded->fields;
    decoded = with_flat_in_2d(std::move(*decoded), execution);
    if (!decoded || !decoded->lift) return decoded;
    if (!decoded->lift->heights.empty()) decoded->notices.push_back({"z of unused vertices was omitted"});
    if (const std::size_t lost = fields_with_z(in_space); lost > 0)
        decoded->notices.push_back({fmt::format("z components of {} fields were omitted: the mesh is flat", lost)});
    return decoded;
}

Outcome<DecodedSolution> solution_of_mesh(const std::string& path, const DecodeOptions& options,
                                          const Execution& execution) {
    auto decoded = read_in_own_dimension(path, options, execution);
    if (!decoded) return fail(std::move(decoded.error()));
    const run::PlanSize size = run::plan_size(decoded->mesh);
    auto solution = solution_of(decoded->fields, size.dimension, size.vertices, execution);
    if (!solution) {
        solution.error().where = path;
        return fail(std::move(solution.error()));
    }
    std::size_t at_cells = 0;
    for (const MeshField& field : decoded->fields) at_cells += field.centring == Centring::cell ? 1 : 0;
    if (at_cells > 0)
        decoded->notices.push_back({fmt::format("a solution file cannot store {} fields at cells", at_cells)});
    if (size.degree == 2) decoded->notices.push_back({"a solution file cannot store the values at the nodes of edges"});
    std::vector<std::string_view> names;
    for (const MeshField& field : decoded->fields)
        if (field.centring == Centring::node) names.push_back(field.name);
    decoded->notices.push_back(
        {"a solution file cannot store names; its fields are, in this order: " + listed(names, ", ")});
    return DecodedSolution{std::move(*solution), std::move(decoded->notices)};
}

Outcome<Done> convert_solution(const ConvertArguments& a, const Execution& execution) {
    if (a.format.empty() && a.output != standard_stream && !is_solution_file(a.output))
        return fail(ErrorKind::usage, "a solution cannot be written in the format of this ending", a.output, {},
                    "use " + listed(writable_extensions(solution_formats())) +
                        "; with its mesh: camber convert MESH -o FILE.vtu --metric " + a.input);
    const auto format = format_of_solution(a.output, a.format);
    if (!format) return fail(format.error());
    if (a.elevate || a.straighten || !a.metric.empty() || a.cells)
        return fail(ErrorKind::usage, "--elevate, --straighten, --metric and --cells require a mesh");
    if (auto writable = check_writable(a.output); !writable) return writable;
    auto decoded =
        is_solution_file(a.input) ? read_solution(a.input, execution) : solution_of_mesh(a.input, a.read, execution);
    if (!decoded) return fail(std::move(decoded.error()));
    say(decoded->notices);
    return write_solution(**format, decoded->solution, a.output, execution);
}

Outcome<AnyMesh> elevated(AnyMesh mesh, const std::string& name, const Execution& execution) {
    return std::visit(
        [&](auto m) -> Outcome<AnyMesh> {
            if (m.degree > 1)
                return fail(ErrorKind::usage, "the mesh is quadratic already", name, {}, "leave --elevate out");
            return elevate(std::move(m), 2, execution).map([](auto result) { return AnyMesh(std::move(result)); });
        },
        std::move(mesh));
}

Outcome<AnyMesh> straightened(AnyMesh mesh, const std::string& name) {
    return std::visit(
        [&](auto m) -> Outcome<AnyMesh> {
            if (m.degree == 1)
                return fail(ErrorKind::usage, "the mesh is straight already", name, {}, "leave --straighten out");
            return AnyMesh(as_mesh(straight_simplices(std::move(m))));
        },
        std::move(mesh));
}

/// Changes the degree of the mesh if requested. Fields are lost.
Outcome<Done> change_degree(const ConvertArguments& a, DecodedMesh& decoded, const Execution& execution) {
    if (!a.elevate && !a.straighten) return Done{};
    const int degree = a.elevate ? 1 : 2;
    auto result = a.elevate ? elevated(std::move(decoded.mesh), a.input, execution)
                            : straightened(std::move(decoded.mesh), a.input);
    if (!result) return fail(std::move(result.error()));
    decoded.mesh = std::move(*result);
    if (!decoded.fields.empty())
        decoded.notices.push_back(
            {fmt::format("{} fields were omitted in the mesh of degree {}", decoded.fields.size(), degree)});
    decoded.fields = {};
    return Done{};
}

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

void note_lost_fields(const MeshFields& fields, const MeshFormat& format) {
    std::vector<std::string_view> lost;
    for (const MeshField& field : fields)
        if (!format.has_fields || (format.can_store != nullptr && !format.can_store(field))) lost.push_back(field.name);
    if (!lost.empty())
        print_note(fmt::format("{} cannot store {} fields: {}{}", format.what, lost.size(), listed(lost, " and "),
                               format.has_fields ? "" : " (to store fields at nodes, convert to a .sol)"));
    report_renames(format, fields);
}

Outcome<DecodedMesh> mesh_to_convert(const ConvertArguments& a, const MeshFormat& format, const Execution& execution) {
    auto decoded = format.is_always_3d ? read_mesh(a.input, config::Flat::surface, a.read, execution)
                                       : read_in_own_dimension(a.input, a.read, execution);
    if (!decoded) return decoded;
    if (decoded->lift && decoded->lift->z != 0)
        decoded->notices.push_back(
            {fmt::format("the mesh is flat: written in 2D, without its z = {}", decoded->lift->z)});
    if (auto done = change_degree(a, *decoded, execution); !done) return fail(std::move(done.error()));
    if (a.metric.empty()) return decoded;
    auto solution = read_solution_for(*decoded, a.metric, execution);
    if (!solution) return fail(std::move(solution.error()));
    decoded->notices.insert(decoded->notices.end(), solution->notices.begin(), solution->notices.end());
    auto result = fields_of(solution->solution, a.metric, decoded->mesh, execution);
    if (!result) return fail(std::move(result.error()));
    for (const MeshField& field : *result) decoded->fields = std::move(decoded->fields).with(field);
    return decoded;
}

Outcome<Done> check_choices(const ConvertArguments& a, const MeshFormat& format) {
    if (!format.chooses_cells && a.cells)
        return fail(ErrorKind::usage, "--cells is for .vtu", a.output, {}, "leave --cells out");
    if (format.has_fields || a.metric.empty()) return Done{};
    const auto endings = writable_extensions(mesh_formats(), [](const MeshFormat& f) { return f.has_fields; });
    return fail(ErrorKind::usage, "--metric is for " + listed(endings), a.output, {},
                "the format cannot store fields; convert the .sol separately");
}

Outcome<Done> convert_mesh(const ConvertArguments& a, Written& written, const Execution& execution) {
    const bool in_parts = a.partition > 0;
    if (!in_parts && names_its_pieces(a.output)) return missing_partition_error(a.output);
    auto format = in_parts ? format_of_parts(a.output, a.format) : format_of_mesh(a.output, a.format);
    if (!format) return fail(format.error());
    if (auto writable = check_writable(a.output); !writable) return writable;
    if (auto requested = check_choices(a, **format); !requested) return requested;
    const auto decoded = mesh_to_convert(a, **format, execution);
    if (!decoded) return fail(decoded.error());
    // Formats that share an ending support the same options.
    if (!in_parts) format = format_of_mesh(a.output, a.format, decoded->format);
    if (!format) return fail(format.error());
    say(decoded->notices);
    say((*format)->losses(decoded->mesh));
    note_lost_fields(decoded->fields, **format);
    const EncodeOptions options{a.cells.value_or(EncodeOptions{}.cells)};
    if (in_parts) return write_in_parts(**format, *decoded, {a.output, a.partition, options}, written, execution);
    return written.add(a.output, write_mesh(**format, decoded->mesh, decoded->fields, options, a.output, execution));
}

Outcome<Done> check_on_ranks(const ConvertArguments& a) {
    if (a.partition == 0 || !names_its_pieces(a.output))
        return fail(ErrorKind::usage, "several ranks can only convert a mesh to a .pvtu in parts", a.output, {},
                    "camber, or mpirun -n 1");
    if (!a.input.ends_with(".meshb") || !a.metric.empty() || a.elevate || a.straighten || !a.format.empty())
        return fail(ErrorKind::usage,
                    "several ranks require a .meshb, without --metric, --elevate, --straighten and "
                    "--format",
                    a.input, {}, "convert it on one rank first");
    return Done{};
}

Outcome<int> convert_on_ranks(const ConvertArguments& a, const Host& host) {
    if (auto distinct = check_names(a, false); !distinct) return fail(distinct.error());
    if (auto possible = check_on_ranks(a); !possible) return fail(possible.error());
    const bool writes_first = host.ranks->rank() == 0;
    auto writable = agreed(*host.ranks, writes_first ? check_writable(a.output) : Outcome<Done>(Done{}));
    if (!writable) return fail(writable.error());
    const Execution execution{.threads = a.threads, .stop = host.stop};
    auto files = write_in_parts_on_ranks(host, a.input,
                                         {a.output, a.partition, {a.cells.value_or(EncodeOptions{}.cells)}}, execution);
    if (!files) return fail(files.error());
    files->push_back(a.output);
    return end_with(wrote_rows(*files));
}

}  // namespace

Outcome<int> convert_command(const ConvertArguments& arguments, const Host& host) {
    if (host.ranks->size() > 1) return convert_on_ranks(arguments, host);
    const bool solution = is_solution_file(arguments.input) || is_solution_file(arguments.output);
    if (auto distinct = check_names(arguments, solution); !distinct) return fail(distinct.error());
    const Execution execution{.threads = arguments.threads, .stop = stop_on_signals()};
    Written written;
    if (solution && arguments.partition > 0)
        return fail(ErrorKind::usage, "requires meshes", "--partition", {}, "leave it out");
    const auto done = solution ? written.add(arguments.output, convert_solution(arguments, execution))
                               : convert_mesh(arguments, written, execution);
    if (!done) return fail(done.error());
    return end_with(wrote_rows(written.paths()), written);
}

Outcome<int> transfer_command(const TransferArguments& a) {
    const auto distinct = check_named_files({{a.old_mesh, "the old mesh", Role::input},
                                             {a.new_mesh, "the new mesh", Role::input},
                                             {a.solution, "--solution", Role::input},
                                             {a.output, "-o", Role::output}});
    if (!distinct) return fail(distinct.error());
    if (auto output = check_fields_output(a.output, a.format); !output) return fail(output.error());
    if (auto writable = check_writable(a.output); !writable) return fail(writable.error());
    Written written;
    ShownSteps steps(a.threads);
    auto from = steps.run("read", [&](const Execution& e) { return read_mesh(a.old_mesh, a.flat, e); });
    if (!from) return fail(from.error());
    auto to = steps.run("read", [&](const Execution& e) { return read_mesh(a.new_mesh, a.flat, e); });
    if (!to) return fail(to.error());
    const int dimension = run::plan_size(from->mesh).dimension;
    if (run::plan_size(to->mesh).dimension != dimension)
        return fail(ErrorKind::input, fmt::format("is not in {}D like the old mesh", dimension), a.new_mesh, {},
                    "give two meshes of the same domain");
    std::vector<Notice> notices = from->notices;
    notices.insert(notices.end(), to->notices.begin(), to->notices.end());
    auto fields = steps.run("read solution", [&](const Execution& e) {
        return read_nodal_fields(*from, a.solution, a.fields, notices, e);
    });
    if (!fields) return fail(fields.error());
    for (const Notice& notice : notices) print_note(notice.what);
    if (run::plan_size(to->mesh).degree == 1 &&
        std::ranges::any_of(*fields, [](const NamedField& f) { return f.field.degree == 2; }))
        print_note("the new mesh has degree 1: field values are only written at its vertices");
    auto result = run::transfer_fields(to->mesh, from->mesh, std::move(*fields), a.options, steps.around);
    if (!result) return fail(of_file(result.error(), a.solution));
    if (run::plan_size(to->mesh).degree == 1) result->fields = run::at_vertices(to->mesh, std::move(result->fields));
    const auto done = written.add(a.output, steps.run("write", [&](const Execution& e) {
        return write_nodal_fields(*to, result->fields, a.output, a.format, e);
    }));
    if (!done) return fail(done.error());
    steps.progress.wipe();
    return end_with(called_input(a.new_mesh) + "\n" + run::transfer_rows(result->report) + wrote_rows({a.output}),
                    written);
}

namespace {

std::vector<NamedFile> files_of(const MetricArguments& a) {
    std::vector<NamedFile> files{
        {a.input, "the input", Role::input}, {a.solution, "--solution", Role::input}, {a.output, "-o", Role::output}};
    for (const config::FilePath& file : a.metric.intersect) files.push_back({file.path, "--intersect", Role::input});
    return files;
}

}  // namespace

Outcome<int> metric_command(const MetricArguments& a) {
    if (auto distinct = check_named_files(files_of(a)); !distinct) return fail(distinct.error());
    if (auto output = check_fields_output(a.output, a.format); !output) return fail(output.error());
    if (auto place = check_place_for(a.output, a.format, FieldKind::symmetric_tensor); !place)
        return fail(place.error());
    if (auto writable = check_writable(a.output); !writable) return fail(writable.error());
    auto sizes = read_sizes(a.sizes);
    if (!sizes) return fail(sizes.error());
    config::SolutionMetric requested = a.metric;
    requested.sizes = std::move(sizes->sizes);
    Written written;
    ShownSteps steps(a.threads);
    auto decoded = steps.run("read", [&](const Execution& e) { return read_mesh(a.input, a.flat, e); });
    if (!decoded) return fail(decoded.error());
    std::vector<Notice> notices = decoded->notices;
    const auto fields = steps.run("read solution", [&](const Execution& e) {
        return read_nodal_fields(*decoded, a.solution, a.metric.fields, notices, e);
    });
    if (!fields) return fail(fields.error());
    const auto specified = steps.run("read metrics", [&](const Execution& e) {
        return read_metrics_at_vertices(*decoded, a.metric.intersect, notices, e);
    });
    if (!specified) return fail(specified.error());
    for (const Notice& notice : notices) print_note(notice.what);
    const double ridge_angle = config::Features{}.ridge_angle;
    const auto result = run::metric_of_fields(decoded->mesh, *fields, requested, *specified, ridge_angle, steps.around);
    if (!result) return fail(of_file(result.error(), a.solution));
    const auto done = written.add(a.output, steps.run("write", [&](const Execution& e) {
        return write_nodal_fields(*decoded, {result->metric}, a.output, a.format, e);
    }));
    if (!done) return fail(done.error());
    steps.progress.wipe();
    for (const std::string& notice : run::solution_metric_notices(result->report)) print_note(notice);
    return end_with(called_input(a.input) + "\n" + run::solution_metric_rows(result->report) + wrote_rows({a.output}),
                    written);
}

}  // namespace camber::app
