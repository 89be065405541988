module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
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
import camber.transfer;
import camber.io;
import camber.app_shell;
import camber.config;
import camber.recipes;
import camber.reports;
import :execution;

namespace camber::app {

namespace {

/// Fractions of the time for encoding and decoding; the rest is the disk's.
constexpr double of_encoding = 0.3, of_decoding = 0.5;

Outcome<Done> write_chunks(const Outcome<Chunks>& chunks, const std::string& path, const Execution& execution) {
    if (!chunks) {
        Error error = chunks.error();
        if (error.where.empty()) error.where = called_output(path);
        return fail(std::move(error));
    }
    const std::vector<std::span<const std::byte>> parts(chunks->begin(), chunks->end());
    return write_file(path, parts, part_of(execution, of_encoding, 1));
}

/// `refuse(beginning)`: the decoder. Its error for an unknown beginning names that beginning.
template <class Format, class Refuse>
StreamBound bound_by(std::span<const Format> formats, const std::string& path, Refuse refuse) {
    return [=](std::span<const std::byte> beginning) -> Outcome<std::size_t> {
        if (format_with_content(formats, beginning)) return memory_limit().bytes / 4;
        if (format_with_extension(formats, path)) return bound_of_text(beginning);
        if (const auto decoded = refuse(beginning); !decoded) return fail(decoded.error());
        return bound_of_text(beginning);
    };
}

/// Standard output has no ending that determines a format.
template <class Format>
Outcome<Done> check_has_format(std::span<const Format> formats, const std::string& path, std::string_view name) {
    if (path != standard_stream || !name.empty()) return Done{};
    return fail(ErrorKind::usage, "has no ending that determines the format", called_output(path), {},
                "give --format, one of " + listed(writable_formats(formats)));
}

}  // namespace

bool names_a_file(const std::string& text) {
    std::error_code none;
    return is_solution_file(text) || format_with_extension(mesh_formats(), text) != nullptr ||
           std::filesystem::exists(text, none);
}

bool is_solution_file(std::string_view path) { return format_with_extension(solution_formats(), path) != nullptr; }

Outcome<Done> write_mesh(const MeshFormat& format, const AnyMesh& mesh, const MeshFields& fields, EncodeOptions options,
                         const std::string& path, const Execution& execution) {
    return write_chunks(format.encode(mesh, fields, options, part_of(execution, 0, of_encoding)), path, execution);
}

void report_renames(const MeshFormat& format, const MeshFields& fields) {
    if (!format.renames) return;
    for (const Notice& notice : format.renames(fields)) print_note(notice.what);
}

void name_references(AnyMesh& mesh, const run::Groups& groups) {
    std::visit(
        [&](auto& m) {
            if (m.groups.empty()) m.groups = Buffer<Group>(groups.begin(), groups.end());
        },
        mesh);
}

Outcome<Done> write_solution(const SolutionFormat& format, const Solution& solution, const std::string& path,
                             const Execution& execution) {
    return write_chunks(format.encode(solution, part_of(execution, 0, of_encoding)), path, execution);
}

StreamBound bound_of_mesh(const std::string& path) {
    return bound_by(mesh_formats(), path, [path](std::span<const std::byte> beginning) {
        return decode_mesh(beginning, called_input(path), {}, {});
    });
}

Outcome<DecodedSolution> read_solution(const std::string& path, const Execution& execution) {
    const StreamBound bound = bound_by(solution_formats(), path, [&](std::span<const std::byte> beginning) {
        return decode_solution(beginning, called_input(path), {});
    });
    auto bytes = read_file(path, part_of(execution, 0, 1 - of_decoding), bound);
    if (!bytes) return fail(bytes.error());
    return decode_solution(*bytes, called_input(path), part_of(execution, 1 - of_decoding, 1));
}

Outcome<Done> write_text(const std::string& path, std::string_view text) {
    const std::span<const std::byte> bytes = as_bytes(text);
    return write_file(path, {&bytes, 1});
}

Outcome<const MeshFormat*> format_of_mesh(const std::string& path, std::string_view name, std::string_view source) {
    if (auto known = check_has_format(mesh_formats(), path, name); !known) return fail(known.error());
    return format_to_rewrite(mesh_formats(), path, name, source);
}

Outcome<const SolutionFormat*> format_of_solution(const std::string& path, std::string_view name) {
    if (auto known = check_has_format(solution_formats(), path, name); !known) return fail(known.error());
    return format_to_write(solution_formats(), path, name);
}

Outcome<Done> check_viewer_output(const std::string& path) {
    if (path.empty()) return Done{};
    const auto format = format_to_write(mesh_formats(), path);
    if (!format) return fail(format.error());
    if (!(*format)->for_viewers)
        return fail(ErrorKind::usage, "is not in a format for viewers", path, {}, "name a .vtu file");
    return check_writable(path);
}

Outcome<Done> write_for_viewers(AnyMesh mesh, MeshFields fields, const std::optional<Lift>& lift,
                                const std::string& path, const Execution& execution) {
    const auto format = format_to_write(mesh_formats(), path);
    if (!format) return fail(format.error());
    if (lift && (*format)->is_always_3d) {
        auto in_space = camber::raised(mesh, *lift, execution);
        if (!in_space) return fail(in_space.error());
        auto of_space = camber::raised(fields, execution);
        if (!of_space) return fail(of_space.error());
        mesh = std::move(*in_space);
        fields = std::move(*of_space);
    }
    report_renames(**format, fields);
    return write_mesh(**format, mesh, fields, EncodeOptions{}, path, execution);
}

namespace {

bool is_solution_output(const std::string& path, std::string_view name) {
    return name.empty() ? is_solution_file(path) : format_with_name(solution_formats(), name) != nullptr;
}

struct Nodes {
    std::size_t vertices = 0, edges = 0;  ///< edges: 0 for a straight mesh
    int dimension = 3;
};
Nodes nodes_of(const AnyMesh& mesh) {
    return std::visit([]<int D>(const Mesh<D>& m) { return Nodes{m.points.size(), m.edge_nodes.size(), D}; }, mesh);
}

/// Returns true if both meshes have the same vertices, and the same edges if the second has nodes on them.
Outcome<bool> have_same_nodes(const AnyMesh& a, const AnyMesh& b, const Execution& execution) {
    return std::visit(
        [&]<int A, int B>(const Mesh<A>& x, const Mesh<B>& y) -> Outcome<bool> {
            if constexpr (A != B) {
                return false;
            } else {
                if (x.points != y.points) return false;
                if (y.degree == 1) return true;
                if (x.degree == 2) return x.entities.edges == y.entities.edges;
                return unique_edges(straight_simplices(x), execution).map([&](const auto& edges) {
                    return edges.vertices == y.entities.edges;
                });
            }
        },
        a, b);
}

TransferField columns_of(const Column<double>& rows, std::size_t stride, std::size_t begin, std::size_t width,
                         int degree) {
    Buffer<double> values(rows.size() / stride * width, 0.0);
    for (std::size_t r = 0; r < rows.size() / stride; ++r)
        std::copy_n(rows.data() + r * stride + begin, width, values.data() + r * width);
    return {static_cast<int>(width), degree, Column<double>(std::move(values))};
}

Outcome<std::vector<NamedField>> of_solution(const DecodedMesh& mesh, const std::string& path,
                                             std::vector<Notice>& notices, const Execution& execution) {
    auto decoded = read_solution_for(mesh, path, execution);
    if (!decoded) return fail(decoded.error());
    notices.insert(notices.end(), decoded->notices.begin(), decoded->notices.end());
    auto sorted = run::rows_by_nodes(std::move(decoded->solution), mesh, without_progress(execution));
    if (!sorted) return fail(sorted.error());
    const Solution& solution = sorted->solution;
    const Nodes nodes = nodes_of(mesh.mesh);
    if (solution.dimension != nodes.dimension)
        return fail(ErrorKind::input,
                    fmt::format("is in {}D, but the mesh is in {}D", solution.dimension, nodes.dimension), path, {},
                    "give the solution of this mesh");
    bool is_at_nodes = sorted->is_at_nodes;
    if (!is_at_nodes && solution.rows != nodes.vertices) {
        const auto all = run::nodes_in_degree_2(mesh.mesh, without_progress(execution));
        if (!all) return fail(all.error());
        is_at_nodes = nodes.edges == 0 && solution.rows == *all;
        if (!is_at_nodes)
            return fail(ErrorKind::input,
                        fmt::format("has {} rows, but the mesh has {} vertices, or {} nodes in degree 2", solution.rows,
                                    nodes.vertices, *all),
                        path, {}, "give the solution of this mesh");
    }
    std::vector<NamedField> fields;
    std::size_t begin = 0;
    for (const FieldKind kind : solution.fields) {
        const auto width = static_cast<std::size_t>(values_per_vertex(kind, solution.dimension));
        fields.push_back({fmt::format("field_{}", fields.size() + 1), kind,
                          columns_of(solution.values, row_width(solution), begin, width, is_at_nodes ? 2 : 1)});
        begin += width;
    }
    return fields;
}

Outcome<std::vector<NamedField>> of_mesh_file(const DecodedMesh& mesh, const std::string& path,
                                              std::vector<Notice>& notices, const Execution& execution) {
    auto other = read_mesh(path, mesh.lift ? config::Flat::plane : config::Flat::surface, execution);
    if (other && mesh.lift == std::nullopt && other->is_always_3d && nodes_of(mesh.mesh).dimension == 2)
        other = with_flat_in_2d(std::move(*other), without_progress(execution));
    if (!other) return fail(other.error());
    const auto is_same = have_same_nodes(mesh.mesh, other->mesh, without_progress(execution));
    if (!is_same) return fail(is_same.error());
    if (!*is_same)
        return fail(ErrorKind::input, "is a solution on another mesh", path, {},
                    "give its mesh as the input, or use camber transfer");
    return fields_at_nodes(*other, notices);
}

bool is_tensor(const NamedField& field) {
    return field.kind == FieldKind::symmetric_tensor || field.kind == FieldKind::full_tensor;
}

/// Returns the field to use as a metric; null: none, or several candidates.
const NamedField* metric_among(const std::vector<NamedField>& fields) {
    const auto only = [&](const auto& could_be) -> const NamedField* {
        const auto first = std::ranges::find_if(fields, could_be);
        return first != fields.end() && std::ranges::count_if(fields, could_be) == 1 ? &*first : nullptr;
    };
    const auto is_size = [](const NamedField& field) { return field.kind == FieldKind::scalar; };
    if (const auto* named = only([](const NamedField& f) { return f.name == "metric" && is_tensor(f); })) return named;
    if (const auto* tensor = only(is_tensor)) return tensor;
    if (const auto* named = only([&](const NamedField& f) { return f.name == "size" && is_size(f); })) return named;
    return only(is_size);
}

/// Returns rows as a solution file stores them. A full tensor is reduced to its symmetric part.
run::RowsByNodes as_rows(const NamedField& field, int dimension) {
    const auto width = static_cast<std::size_t>(field.field.components);
    const auto n = static_cast<std::size_t>(dimension);
    Solution out{dimension, {field.kind}, field.field.values.size() / width, field.field.values};
    if (field.kind == FieldKind::full_tensor) {
        Buffer<double> lower;
        lower.reserve(out.rows * n * (n + 1) / 2);
        for (std::size_t r = 0; r < out.rows; ++r) {
            const double* const full = field.field.values.data() + r * width;
            for (std::size_t i = 0; i < n; ++i)
                for (std::size_t j = 0; j <= i; ++j) lower.push_back(0.5 * (full[i * n + j] + full[j * n + i]));
        }
        out.fields = {FieldKind::symmetric_tensor};
        out.values = Column<double>(std::move(lower));
    }
    return {std::move(out), field.field.degree == 2};
}

struct ColumnsAtNodes {
    std::vector<Column<double>> columns = {};
    std::size_t nodes = 0;
    bool at_all_nodes = false;
};
/// Uses all nodes if a field of a quadratic mesh has degree 2, or all fields of a straight one; otherwise the vertices.
ColumnsAtNodes columns_at_nodes(const AnyMesh& mesh, const std::vector<NamedField>& fields) {
    const Nodes nodes = nodes_of(mesh);
    const auto is_quadratic = [](const NamedField& f) { return f.field.degree == 2; };
    const bool is_straight = nodes.edges == 0;
    const bool at_all = !fields.empty() && (is_straight ? std::ranges::all_of(fields, is_quadratic)
                                                        : std::ranges::any_of(fields, is_quadratic));
    ColumnsAtNodes out{.nodes = nodes.vertices + (at_all ? nodes.edges : 0), .at_all_nodes = at_all};
    if (at_all && !is_straight) {
        for (const MeshField& field : run::as_mesh_fields(mesh, fields))
            out.columns.push_back(std::get<Column<double>>(field.values));
        return out;
    }
    for (const NamedField& field : at_all ? fields : run::at_vertices(mesh, fields))
        out.columns.push_back(field.field.values);
    if (at_all)
        out.nodes = fields.front().field.values.size() / static_cast<std::size_t>(fields.front().field.components);
    return out;
}

/// Returns one row for each node of the mesh file, or for each vertex if all fields have degree 1. On a straight mesh,
/// fields of degree 2 have rows of the vertices, then of the edges.
Solution solution_in_order(const DecodedMesh& mesh, const std::vector<NamedField>& fields) {
    const ColumnsAtNodes at = columns_at_nodes(mesh.mesh, fields);
    Solution out{.dimension = nodes_of(mesh.mesh).dimension};
    for (const NamedField& field : fields) out.fields.push_back(field.kind);
    const auto number = [&](std::size_t n) {
        return !at.at_all_nodes || mesh.node_numbers.empty() ? n + 1 : std::size_t{mesh.node_numbers[n]};
    };
    for (std::size_t n = 0; n < at.nodes; ++n) out.rows = std::max(out.rows, number(n));
    const std::size_t width = row_width(out);
    Buffer<double> values(out.rows * width, 0.0);
    for (std::size_t n = 0; n < at.nodes; ++n) {
        if (number(n) == 0) continue;  // the edge has no node in the file
        double* to = values.data() + (number(n) - 1) * width;
        for (std::size_t f = 0; f < fields.size(); ++f) {
            const auto w = static_cast<std::size_t>(fields[f].field.components);
            to = std::copy_n(at.columns[f].data() + n * w, w, to);
        }
    }
    out.values = Column<double>(std::move(values));
    return out;
}

}  // namespace

std::vector<NamedField> fields_at_nodes(const DecodedMesh& mesh, std::vector<Notice>& notices) {
    const Nodes nodes = nodes_of(mesh.mesh);
    std::vector<NamedField> fields;
    const auto leave_out = [&](const MeshField& field, const char* reason) {
        notices.push_back({fmt::format("the field {} is omitted: {}", field.name, reason)});
    };
    for (const MeshField& field : mesh.fields) {
        const auto* const values = std::get_if<Column<double>>(&field.values);
        const auto width = static_cast<std::size_t>(values_per_vertex(field.kind, nodes.dimension));
        if (field.centring != Centring::node)
            leave_out(field, "its values are at cells");
        else if (values == nullptr)
            leave_out(field, "its values are integers, not a solution");
        else
            fields.push_back({field.name, field.kind,
                              columns_of(*values, width, 0, width, values->size() / width > nodes.vertices ? 2 : 1)});
    }
    return fields;
}

Outcome<std::vector<NamedField>> read_nodal_fields(const DecodedMesh& mesh, const std::string& path,
                                                   const std::vector<std::string>& only, std::vector<Notice>& notices,
                                                   const Execution& execution) {
    auto fields = is_solution_file(path) ? of_solution(mesh, path, notices, execution)
                                         : of_mesh_file(mesh, path, notices, execution);
    if (!fields) return fields;
    if (fields->empty())
        return fail(ErrorKind::input, "has no field at nodes", path, {}, "list the fields of a file with camber info");
    return run::named(std::move(*fields), only, path);
}

Outcome<run::RowsByNodes> read_metric_rows(const DecodedMesh& mesh, const std::string& path,
                                           std::vector<Notice>& notices, const Execution& execution) {
    const MeshFormat* const format = is_solution_file(path) ? nullptr : format_with_extension(mesh_formats(), path);
    if (format == nullptr) {
        auto decoded = read_solution_for(mesh, path, execution);
        if (!decoded) return fail(decoded.error());
        notices.insert(notices.end(), decoded->notices.begin(), decoded->notices.end());
        return run::rows_by_nodes(std::move(decoded->solution), mesh, without_progress(execution));
    }
    std::vector<Notice> of_others;  // about fields that are not the metric
    const auto fields = of_mesh_file(mesh, path, of_others, execution);
    if (!fields) return fail(fields.error());
    const NamedField* const field = metric_among(*fields);
    if (field == nullptr)
        return fail(
            ErrorKind::input, "has no metric at its nodes", path, {},
            "give a file with a field named metric, or with only one tensor or size; list its fields with camber info");
    return as_rows(*field, nodes_of(mesh.mesh).dimension);
}

Outcome<std::vector<Solution>> read_metrics_at_vertices(const DecodedMesh& mesh,
                                                        const std::vector<config::FilePath>& files,
                                                        std::vector<Notice>& notices, const Execution& execution) {
    std::vector<Solution> out;
    for (const config::FilePath& file : files) {
        auto rows = read_metric_rows(mesh, file.path, notices, execution);
        if (!rows) return fail(rows.error());
        out.push_back(run::rows_at_vertices(std::move(*rows), mesh.mesh));
    }
    return out;
}

Outcome<Done> check_fields_output(const std::string& path, std::string_view name) {
    if (is_solution_output(path, name)) return format_of_solution(path, name).map([](auto) { return Done{}; });
    const auto format = format_of_mesh(path, name);
    if (!format) return fail(format.error());
    if ((*format)->has_fields) return Done{};
    return fail(ErrorKind::usage, "the format cannot store fields", path, {},
                "give a file that ends in " + listed(writable_extensions(solution_formats())) + " or .vtu");
}

Outcome<Done> check_place_for(const std::string& path, std::string_view name, FieldKind kind) {
    if (path.empty() || is_solution_output(path, name)) return Done{};
    const auto found = format_of_mesh(path, name);
    const MeshFormat* const format = found ? *found : nullptr;
    if (format == nullptr || !format->can_store || format->can_store({"field", Centring::node, kind, {}}))
        return Done{};
    return fail(ErrorKind::usage, "the format cannot store tensors at nodes", path, {},
                "give a file that ends in " + listed(writable_extensions(solution_formats())) + " or .vtu");
}

Outcome<Done> write_nodal_fields(const DecodedMesh& mesh, const std::vector<NamedField>& fields,
                                 const std::string& path, std::string_view name, const Execution& execution) {
    if (is_solution_output(path, name)) {
        const auto format = format_of_solution(path, name);
        if (!format) return fail(format.error());
        return write_solution(**format, solution_in_order(mesh, fields), path, execution);
    }
    const auto format = format_of_mesh(path, name, mesh.format);
    if (!format) return fail(format.error());
    for (const NamedField& field : fields)
        if (auto place = check_place_for(path, name, field.kind); !place) return place;
    return write_with_mesh(mesh, fields, **format, path, execution);
}

Outcome<Done> write_with_mesh(const DecodedMesh& mesh, const std::vector<NamedField>& fields, const MeshFormat& format,
                              const std::string& path, const Execution& execution) {
    const MeshFields all = run::as_mesh_fields(mesh.mesh, fields);
    report_renames(format, all);
    if (!mesh.lift || !(format.is_always_3d || !mesh.is_always_3d))
        return write_mesh(format, mesh.mesh, all, {}, path, execution);
    const auto in_space = raised(mesh.mesh, *mesh.lift, without_progress(execution));
    if (!in_space) return fail(in_space.error());
    const auto raised_fields = raised(all, without_progress(execution));
    if (!raised_fields) return fail(raised_fields.error());
    return write_mesh(format, *in_space, *raised_fields, {}, path, execution);
}

}  // namespace camber::app
