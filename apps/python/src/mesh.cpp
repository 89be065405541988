#include "python.hpp"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

import camber.core;
import camber.bezier;
import camber.commands;
import camber.config;
import camber.io;
import camber.recipes;
import camber.reports;

namespace camber::python {

namespace {

template <class T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

template <class F>
auto on(const MeshHandle& mesh, F&& f) {
    return std::visit(std::forward<F>(f), mesh.value.mesh);
}

template <class F>
py::dict by_cell_type(const MeshHandle& mesh, F&& f) {
    py::dict out;
    const auto add = [&]<int K>() {
        app::on_cells<K>(mesh.value.mesh, [&](const auto& simplices, const auto* edges) {
            if (simplices.size() > 0)
                out[(edges ? app::curved_names : app::straight_names)[K - 1]] = f(simplices, edges);
        });
    };
    add.template operator()<3>();
    add.template operator()<2>();
    add.template operator()<1>();
    return out;
}

py::dict cells(const MeshHandle& mesh) {
    return by_cell_type(mesh, [&]<Shape shape>(const Cells<shape>& simplices, const auto* edges) -> py::array {
        constexpr int K = shape_table<shape>.dimension;
        if (!edges) return view_of<std::uint32_t>(simplices.vertices, K + 1);
        return view_of<std::uint32_t>(Column<std::array<VertexId, quadratic_nodes<K>>>(
                                          nodes_of_cells<K>(simplices.vertices, *edges, mesh.vertices())),
                                      quadratic_nodes<K>);
    });
}

py::dict corners(const MeshHandle& mesh) {
    return by_cell_type(mesh, []<Shape shape>(const Cells<shape>& simplices, const auto*) {
        return view_of<std::uint32_t>(simplices.vertices, shape_table<shape>.corner_count);
    });
}

py::dict references(const MeshHandle& mesh) {
    py::dict out = by_cell_type(
        mesh, [](const auto& simplices, const auto*) { return view_of<std::int32_t>(simplices.references, 0); });
    out["vertex"] = on(mesh, [](const auto& m) { return view_of<std::int32_t>(m.point_references, 0); });
    return out;
}

py::array vertices(const MeshHandle& mesh) {
    return on(mesh, []<int D>(const Mesh<D>& m) { return view_of<double>(m.points, D); });
}

py::object mid_nodes(const MeshHandle& mesh) {
    return on(mesh, []<int D>(const Mesh<D>& m) -> py::object {
        return m.degree == 2 ? py::object(view_of<double>(m.edge_nodes, D)) : py::object(py::none());
    });
}

py::array points(const MeshHandle& mesh) {
    return on(mesh, [&]<int D>(const Mesh<D>& m) -> py::array {
        if (m.degree == 1) return view_of<double>(m.points, D);
        py::array_t<double> all({mesh.nodes(), std::size_t{D}});
        double* to = all.mutable_data();
        for (const Vec<D>& p : m.points) to = std::copy(p.c.begin(), p.c.end(), to);
        for (const LagrangeNode<D>& node : m.edge_nodes) to = std::copy(node.point.c.begin(), node.point.c.end(), to);
        return read_only(std::move(all));
    });
}

py::object edge_vertices(const MeshHandle& mesh) {
    return on(mesh, [](const auto& m) -> py::object {
        return m.degree == 2 ? py::object(view_of<std::uint32_t>(m.entities.edges, 2)) : py::object(py::none());
    });
}

std::vector<std::tuple<int, Reference, std::string>> groups(const MeshHandle& mesh) {
    return on(mesh, [](const auto& m) {
        std::vector<std::tuple<int, Reference, std::string>> all;
        for (const Group& group : m.groups) all.emplace_back(group.dimension, group.reference, group.name);
        return all;
    });
}

std::vector<std::string> notices(const MeshHandle& mesh) {
    std::vector<std::string> all;
    all.reserve(mesh.value.notices.size());
    for (const Notice& notice : mesh.value.notices) all.push_back(notice.what);
    return all;
}

// ---------------------------------------------------------------- from arrays

template <int Nodes>
CellArray<Nodes> cell_array(const py::dict& cells, const py::dict& references, const char* name) {
    CellArray<Nodes> out;
    if (!cells.contains(name)) return out;
    const auto nodes = cells[name].cast<Array<std::uint32_t>>();
    out.nodes = column_of<std::array<VertexId, Nodes>>(nodes);
    if (references.contains(name)) out.references = column_of<Reference>(references[name].cast<Array<Reference>>());
    return out;
}
template <int K>
CellArrays<K> cell_arrays(const py::dict& cells, const py::dict& references) {
    return {cell_array<K + 1>(cells, references, app::straight_names[K - 1]),
            cell_array<quadratic_nodes<K>>(cells, references, app::curved_names[K - 1])};
}

template <int D>
MeshArrays<D> arrays_in(const Array<double>& points, const py::dict& cells, const py::dict& references,
                        const std::vector<std::tuple<int, Reference, std::string>>& names) {
    const std::span<const double> coordinates(points.data(), static_cast<std::size_t>(points.size()));
    MeshArrays<D> arrays{.points = points_of<D>(coordinates, owner_of(points))};
    if (references.contains("vertex"))
        arrays.point_references = column_of<Reference>(references["vertex"].cast<Array<Reference>>());
    arrays.elements = cell_arrays<D>(cells, references);
    arrays.facets = cell_arrays<D - 1>(cells, references);
    if constexpr (D == 3) arrays.edges = cell_arrays<1>(cells, references);
    for (const auto& [dimension, reference, name] : names) arrays.groups.push_back({dimension, reference, name});
    return arrays;
}

/// Builds a mesh from arrays whose shapes are checked. With `flat`, triangles in one plane become a 2D mesh.
MeshHandle from_arrays(const Array<double>& points, const py::dict& cells, const py::dict& references,
                       const std::vector<std::tuple<int, Reference, std::string>>& names, bool flat) {
    const auto result = [&]() -> Outcome<DecodedMesh> {
        if (points.shape(1) == 2) {
            auto arrays = arrays_in<2>(points, cells, references, names);
            const py::gil_scoped_release without_lock;
            return mesh_of_arrays<2>(std::move(arrays), {});
        }
        auto arrays = arrays_in<3>(points, cells, references, names);
        const py::gil_scoped_release without_lock;
        auto in_space = mesh_of_arrays<3>(std::move(arrays), {});
        return in_space && flat ? with_flat_in_2d(std::move(*in_space), {}) : std::move(in_space);
    }();
    return handle_of(value_of(result));
}

py::array given_rows(const MeshHandle& mesh) {
    py::array_t<std::int64_t> rows(static_cast<py::ssize_t>(mesh.nodes()));
    std::int64_t* const to = rows.mutable_data();
    for (std::size_t n = 0; n < mesh.nodes(); ++n)
        to[n] = mesh.input_numbers.empty() ? static_cast<std::int64_t>(n) : std::int64_t{mesh.input_numbers[n]} - 1;
    return std::move(rows);
}

MeshHandle with_fields(const MeshHandle& mesh, const py::dict& fields) {
    MeshHandle with = mesh;
    with.value.fields =
        run::as_mesh_fields(mesh.value.mesh, fields_of(fields, mesh.dimension(), mesh.vertices(), mesh.nodes()));
    return with;
}

// ---------------------------------------------------------------- pickling

/// State for pickling: a binary GMF file, and the data that GMF cannot hold.
py::tuple state_of(const MeshHandle& mesh) {
    const MeshFormat* const format = format_with_name(mesh_formats(), "gmf-binary");
    const auto chunks = value_of(format->encode(mesh.value.mesh, {}, {}, {}));
    std::string bytes;
    for (const auto& chunk : chunks) bytes.append(reinterpret_cast<const char*>(chunk.data()), chunk.size());
    return py::make_tuple(py::bytes(bytes), arrays_of(app::nodal_fields_of(mesh.value), mesh.dimension()), groups(mesh),
                          mesh.value.lift ? std::optional(mesh.value.lift->z) : std::nullopt);
}

Column<Group> named_groups(const std::vector<std::tuple<int, Reference, std::string>>& names) {
    Buffer<Group> groups;
    for (const auto& [dimension, reference, name] : names) groups.push_back({dimension, reference, name});
    return Column<Group>(std::move(groups));
}

MeshHandle of_state(const py::tuple& state) {
    const auto bytes = state[0].cast<std::string>();
    auto mesh = value_of(decode_mesh(std::as_bytes(std::span(bytes)), "a pickled mesh", {}, {}));
    const Column<Group> names = named_groups(state[2].cast<std::vector<std::tuple<int, Reference, std::string>>>());
    std::visit([&](auto& m) { m.groups = names; }, mesh.mesh);
    if (const auto z = state[3].cast<std::optional<double>>()) {
        mesh.lift.emplace();
        mesh.lift->z = *z;
    }
    return with_fields(handle_of(std::move(mesh)), state[1].cast<py::dict>());
}

}  // namespace

int MeshHandle::dimension() const {
    return on(*this, []<int D>(const Mesh<D>&) { return D; });
}
int MeshHandle::degree() const {
    return on(*this, [](const auto& m) { return m.degree; });
}
std::size_t MeshHandle::vertices() const {
    return on(*this, [](const auto& m) { return m.points.size(); });
}
std::size_t MeshHandle::nodes() const {
    return on(*this, [](const auto& m) { return count_nodes(m); });
}

MeshHandle handle_of(DecodedMesh mesh) {
    auto input_numbers = std::exchange(mesh.node_numbers, {});
    return {std::move(mesh), std::move(input_numbers)};
}

void bind_mesh(py::module_& module) {
    py::class_<MeshHandle>(module, "Mesh")
        .def_static("from_arrays", &from_arrays)
        .def_property_readonly("dimension", &MeshHandle::dimension)
        .def_property_readonly("degree", &MeshHandle::degree)
        .def_property_readonly("vertices", &vertices)
        .def_property_readonly("mid_nodes", &mid_nodes)
        .def_property_readonly("edges", &edge_vertices)
        .def_property_readonly("points", &points)
        .def_property_readonly("cells", &cells)
        .def_property_readonly("corners", &corners)
        .def_property_readonly("references", &references)
        .def_property_readonly("groups", &groups)
        .def_property_readonly("notices", &notices)
        .def_property_readonly("z",
                               [](const MeshHandle& m) -> std::optional<double> {
                                   return m.value.lift ? std::optional(m.value.lift->z) : std::nullopt;
                               })
        .def_property_readonly("given_rows", &given_rows)
        .def(py::pickle(&state_of, &of_state))
        .def("with_fields", &with_fields)
        .def("fields", [](const MeshHandle& m) { return arrays_of(app::nodal_fields_of(m.value), m.dimension()); })
        .def("__eq__", [](const MeshHandle& a, const MeshHandle& b) {
            return a.value.mesh == b.value.mesh && a.value.fields == b.value.fields && a.value.lift == b.value.lift;
        });
}

}  // namespace camber::python
