// Converts meshes from and to arrays.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "camber.h"
#include "handles.hpp"
import camber.core;
import camber.bezier;
import camber.commands;
import camber.config;
import camber.io;
import camber.recipes;
import camber.reports;
import camber.transfer;

namespace camber::c {

namespace {

using app::curved_names;
using app::straight_names;

template <int Nodes>
CellArray<Nodes> cell_array(const camber_cells& cells, int first) {
    Buffer<std::array<VertexId, Nodes>> nodes(static_cast<std::size_t>(cells.count));
    for (std::size_t c = 0; c < nodes.size(); ++c)
        for (std::size_t i = 0; i < Nodes; ++i) {
            const std::int64_t node = std::int64_t{cells.nodes[c * Nodes + i]} - first;
            nodes[c][i] = node < 0 ? VertexId() : VertexId(static_cast<std::size_t>(node));
        }
    CellArray<Nodes> out{Column<std::array<VertexId, Nodes>>(std::move(nodes))};
    if (cells.references != nullptr)
        out.references = Column<Reference>(Buffer<Reference>(cells.references, cells.references + cells.count));
    return out;
}

/// Checks cells[t]. Errors: usage (NULL pointers, a negative count, a type that an earlier entry has).
Outcome<Done> check_cells(const camber_cells* cells, int t) {
    const camber_cells& block = cells[t];
    const std::string place = "cells[" + std::to_string(t) + "].";
    const auto wrong = [&](const char* member, const std::string& what, const std::string& remedy = {}) {
        return fail(wrong_argument("camber_make", place + member, what, remedy));
    };
    if (block.type == nullptr) return wrong("type", "is NULL");
    if (block.count < 0) return wrong("count", "is " + std::to_string(block.count));
    if (block.count > 0 && block.nodes == nullptr) return wrong("nodes", "is NULL");
    for (int before = 0; before < t; ++before)
        if (std::string_view(cells[before].type) == block.type)
            return wrong("type", std::string(block.type) + " comes twice", "give all cells of a type together");
    return Done{};
}

template <int K>
bool put(const camber_cells& cells, int first, CellArrays<K>& into) {
    if (straight_names[K - 1] == std::string_view(cells.type))
        into.straight = cell_array<K + 1>(cells, first);
    else if (curved_names[K - 1] == std::string_view(cells.type))
        into.curved = cell_array<quadratic_nodes<K>>(cells, first);
    else
        return false;
    return true;
}

template <int D>
Outcome<DecodedMesh> mesh_from_arrays(std::int64_t points, const double* coordinates, int types,
                                      const camber_cells* cells, int first) {
    Buffer<Vec<D>> all(static_cast<std::size_t>(points));
    for (std::size_t p = 0; p < all.size(); ++p)
        for (std::size_t d = 0; d < D; ++d) all[p][d] = coordinates[p * D + d];
    MeshArrays<D> arrays{.points = Column<Vec<D>>(std::move(all))};
    for (int t = 0; t < types; ++t) {
        if (auto sound = check_cells(cells, t); !sound) return fail(sound.error());
        bool is_known = put(cells[t], first, arrays.elements) || put(cells[t], first, arrays.facets);
        if constexpr (D == 3) is_known = is_known || put(cells[t], first, arrays.edges);
        if (!is_known)
            return fail(ErrorKind::input, "is not a type of cells of a mesh in " + std::to_string(D) + "D",
                        "camber_make: " + std::string(cells[t].type), {},
                        "they are line, triangle, tetra, line3, triangle6 and tetra10");
    }
    auto mesh = mesh_of_arrays<D>(std::move(arrays), {});
    if (!mesh)
        mesh.error().where = "camber_make: " + (mesh.error().where == "points" ? "coordinates" : mesh.error().where);
    return mesh;
}

template <class F>
auto on(const camber_mesh& mesh, F&& f) {
    return std::visit(std::forward<F>(f), mesh.value.mesh);
}

template <class F>
bool on_type(const camber_mesh& mesh, std::string_view type, F&& f) {
    bool found = false;
    const auto look = [&]<int K>() {
        app::on_cells<K>(mesh.value.mesh, [&](const auto& simplices, const auto* edges) {
            if (type != (edges ? curved_names : straight_names)[K - 1]) return;
            f(simplices, edges);
            found = true;
        });
    };
    look.template operator()<1>();
    look.template operator()<2>();
    look.template operator()<3>();
    return found;
}

template <Shape shape>
void copy_cells(const Cells<shape>& simplices, const auto* edges, std::size_t vertices, int first,
                std::int32_t* nodes) {
    const auto put_row = [&](const auto& row) {
        for (const VertexId v : row) *nodes++ = static_cast<std::int32_t>(v.index()) + first;
    };
    if (edges == nullptr)
        for (const auto& row : simplices.vertices) put_row(row);
    else
        for (const auto& row : nodes_of_cells<shape_table<shape>.dimension>(simplices.vertices, *edges, vertices))
            put_row(row);
}

Outcome<Done> check_counts(int dimension, std::int64_t points, int types) {
    const auto wrong = [](const char* argument, std::int64_t value, const char* remedy) {
        return fail(wrong_argument("camber_make", argument, "is " + std::to_string(value), remedy));
    };
    if (dimension != 2 && dimension != 3) return wrong("dimension", dimension, "give 2 or 3");
    if (points < 0) return wrong("points", points, "give the number of points");
    if (types < 0) return wrong("types", types, "give the number of types of cells");
    return Done{};
}

Outcome<Done> check_field(const camber_mesh& mesh, int components, std::int64_t rows, const double* values) {
    const auto wrong = [](const char* argument, const std::string& what, const std::string& remedy) {
        Error error = wrong_argument("camber_with_field", argument, what, remedy);
        error.kind = ErrorKind::input;
        return fail(std::move(error));
    };
    const std::int64_t vertices = camber_vertices(&mesh), points = camber_points(&mesh);
    const int dimension = camber_dimension(&mesh);
    if (rows != vertices && rows != points)
        return wrong("rows", "is " + std::to_string(rows),
                     "give one a vertex, " + std::to_string(vertices) + ", or one a point, " + std::to_string(points));
    if (components != 1 && components != dimension)
        return wrong("components", "is " + std::to_string(components), "give 1 or " + std::to_string(dimension));
    const double* const end = values + rows * components;
    const double* const bad = std::find_if(values, end, [](double x) { return !std::isfinite(x); });
    if (bad != end)
        return wrong("values", "row " + std::to_string((bad - values) / components) + " is not finite",
                     "give numbers other than NaN and infinity");
    return Done{};
}

}  // namespace

}  // namespace camber::c

using namespace camber;

int camber_read(const char* path, camber_mesh** mesh) {
    if (const int wrong = c::missing("camber_read", {{"path", path}, {"mesh", mesh}})) return wrong;
    return c::guarded_status([&] {
        auto read = app::read_into_memory(path, config::Flat::plane, {}, c::silent_host());
        if (!read) return c::status_of(read.error());
        auto input_numbers = std::exchange(read->node_numbers, {});
        *mesh = new camber_mesh{std::move(*read), std::move(input_numbers)};
        return int{CAMBER_OK};
    });
}

int camber_write(const camber_mesh* mesh, const char* path, const char* format) {
    if (const int wrong = c::missing("camber_write", {{"mesh", mesh}, {"path", path}})) return wrong;
    return c::guarded_status([&] {
        const auto done = app::write_from_memory(mesh->value, app::nodal_fields_of(mesh->value), path,
                                                 format == nullptr ? "" : format, c::silent_host());
        return done ? int{CAMBER_OK} : c::status_of(done.error());
    });
}

int camber_make(int dimension, int64_t points, const double* coordinates, int types, const camber_cells* cells,
                int first, camber_mesh** mesh) {
    if (const int wrong = c::missing("camber_make", {{"mesh", mesh}})) return wrong;
    if (const auto sound = c::check_counts(dimension, points, types); !sound) return c::status_of(sound.error());
    if (points > 0)
        if (const int wrong = c::missing("camber_make", {{"coordinates", coordinates}})) return wrong;
    if (types > 0)
        if (const int wrong = c::missing("camber_make", {{"cells", cells}})) return wrong;
    if (const int wrong = c::wrong_first("camber_make", first)) return wrong;
    return c::guarded_status([&] {
        auto result = dimension == 2 ? c::mesh_from_arrays<2>(points, coordinates, types, cells, first)
                                     : c::mesh_from_arrays<3>(points, coordinates, types, cells, first);
        if (!result) return c::status_of(result.error());
        auto input_numbers = std::exchange(result->node_numbers, {});
        *mesh = new camber_mesh{std::move(*result), std::move(input_numbers)};
        return int{CAMBER_OK};
    });
}

void camber_free_mesh(camber_mesh* mesh) { delete mesh; }

int camber_dimension(const camber_mesh* mesh) {
    if (c::missing("camber_dimension", {{"mesh", mesh}})) return 0;
    return c::on(*mesh, []<int D>(const Mesh<D>&) { return D; });
}
int camber_degree(const camber_mesh* mesh) {
    if (c::missing("camber_degree", {{"mesh", mesh}})) return 0;
    return c::on(*mesh, [](const auto& m) { return m.degree; });
}
int64_t camber_vertices(const camber_mesh* mesh) {
    if (c::missing("camber_vertices", {{"mesh", mesh}})) return 0;
    return c::on(*mesh, [](const auto& m) { return static_cast<int64_t>(m.points.size()); });
}
int64_t camber_points(const camber_mesh* mesh) {
    if (c::missing("camber_points", {{"mesh", mesh}})) return 0;
    return c::on(*mesh, [](const auto& m) { return static_cast<int64_t>(count_nodes(m)); });
}
int64_t camber_count(const camber_mesh* mesh, const char* type) {
    if (c::missing("camber_count", {{"mesh", mesh}, {"type", type}})) return 0;
    int64_t count = 0;
    c::on_type(*mesh, type,
               [&](const auto& simplices, const auto*) { count = static_cast<int64_t>(simplices.size()); });
    return count;
}

int camber_get_points(const camber_mesh* mesh, double* coordinates) {
    if (const int wrong = c::missing("camber_get_points", {{"mesh", mesh}, {"coordinates", coordinates}})) return wrong;
    c::on(*mesh, [&](const auto& m) {
        for (const auto& p : m.points) coordinates = std::copy(p.c.begin(), p.c.end(), coordinates);
        for (const auto& node : m.edge_nodes)
            coordinates = std::copy(node.point.c.begin(), node.point.c.end(), coordinates);
    });
    return CAMBER_OK;
}

int camber_get_input_points(const camber_mesh* mesh, int first, int64_t* input) {
    if (const int wrong = c::missing("camber_get_input_points", {{"mesh", mesh}, {"input", input}})) return wrong;
    if (const int wrong = c::wrong_first("camber_get_input_points", first)) return wrong;
    const auto points = static_cast<std::size_t>(camber_points(mesh));
    for (std::size_t p = 0; p < points; ++p)
        input[p] =
            first + (mesh->input_numbers.empty() ? static_cast<int64_t>(p) : int64_t{mesh->input_numbers[p]} - 1);
    return CAMBER_OK;
}

int camber_get_cells(const camber_mesh* mesh, const char* type, int first, int32_t* nodes, int32_t* references) {
    if (const int wrong = c::missing("camber_get_cells", {{"mesh", mesh}, {"type", type}})) return wrong;
    if (const int wrong = c::wrong_first("camber_get_cells", first)) return wrong;
    const auto vertices = static_cast<std::size_t>(camber_vertices(mesh));
    return c::guarded_status([&] {
        const bool found = c::on_type(*mesh, type, [&](const auto& simplices, const auto* edges) {
            if (nodes != nullptr) c::copy_cells(simplices, edges, vertices, first, nodes);
            if (references != nullptr) std::copy(simplices.references.begin(), simplices.references.end(), references);
        });
        return found ? int{CAMBER_OK}
                     : c::status_of(c::wrong_argument("camber_get_cells", "type",
                                                      in_quotes(type) + " is not a type of cells of this mesh"));
    });
}

namespace {

const MeshField* field_of(const camber_mesh* mesh, const char* name) {
    const MeshField* const field = mesh->value.fields.find(name, Centring::node);
    return field != nullptr && std::holds_alternative<Column<double>>(field->values) ? field : nullptr;
}

}  // namespace

int camber_with_field(const camber_mesh* mesh, const char* name, int components, int64_t rows, const double* values,
                      camber_mesh** with) {
    const std::initializer_list<c::Pointer> pointers{
        {"mesh", mesh}, {"name", name}, {"values", values}, {"with", with}};
    if (const int wrong = c::missing("camber_with_field", pointers)) return wrong;
    return c::guarded_status([&] {
        if (auto sound = c::check_field(*mesh, components, rows, values); !sound) return c::status_of(sound.error());
        const bool at_vertices = rows == camber_vertices(mesh);
        const run::NamedField field{name, components == 1 ? FieldKind::scalar : FieldKind::vector,
                                    TransferField{components, at_vertices ? 1 : 2,
                                                  Column<double>(Buffer<double>(values, values + rows * components))}};
        auto fields = app::nodal_fields_of(mesh->value);
        std::erase_if(fields, [&](const run::NamedField& f) { return f.name == name; });
        fields.push_back(field);
        auto copy = std::make_unique<camber_mesh>(*mesh);
        copy->value.fields = run::as_mesh_fields(mesh->value.mesh, fields);
        *with = copy.release();
        return int{CAMBER_OK};
    });
}

int64_t camber_field_size(const camber_mesh* mesh, const char* name, int* components) {
    const bool is_complete = c::missing("camber_field_size", {{"mesh", mesh}, {"name", name}}) == CAMBER_OK;
    const MeshField* const field = is_complete ? field_of(mesh, name) : nullptr;
    const int width = field == nullptr ? 0 : values_per_vertex(field->kind, camber_dimension(mesh));
    if (components != nullptr) *components = width;
    return field == nullptr ? 0 : static_cast<int64_t>(field->size()) / width;
}

int camber_get_field(const camber_mesh* mesh, const char* name, double* values) {
    if (const int wrong = c::missing("camber_get_field", {{"mesh", mesh}, {"name", name}, {"values", values}}))
        return wrong;
    return c::guarded_status([&] {
        const MeshField* const field = field_of(mesh, name);
        if (field == nullptr)
            return c::status_of(
                c::wrong_argument("camber_get_field", "name", in_quotes(name) + " is not a field of this mesh"));
        const auto& column = std::get<Column<double>>(field->values);
        std::copy(column.begin(), column.end(), values);
        return int{CAMBER_OK};
    });
}
