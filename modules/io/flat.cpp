module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <variant>
module camber.io;
import camber.core;

namespace camber {

namespace {

constexpr std::size_t row_grain = 4096;

// ---------------------------------------------------------------- flatness

bool all_used(const Mesh<3>& mesh, auto&& f) {
    const auto all_of_cells = [&](const auto& cells) {
        return std::all_of(cells.vertices.begin(), cells.vertices.end(), [&](const auto& vertices) {
            return std::all_of(vertices.begin(), vertices.end(), [&](VertexId v) { return f(mesh.points[v]); });
        });
    };
    return all_of_cells(mesh.facets.of<Shape::triangle>()) && all_of_cells(mesh.facets.of<Shape::quadrilateral>()) &&
           all_of_cells(mesh.edges) &&
           std::all_of(mesh.edge_nodes.begin(), mesh.edge_nodes.end(),
                       [&](const LagrangeNode<3>& node) { return f(node.point); }) &&
           std::all_of(mesh.face_nodes.begin(), mesh.face_nodes.end(), f);
}

std::optional<double> common_height(const Mesh<3>& mesh) {
    if (!is_standalone_surface(mesh)) return std::nullopt;
    std::optional<double> z;
    const bool flat = all_used(mesh, [&](const Vec<3>& p) {
        if (!z) z = p[2] + 0.0;  // −0 becomes 0
        return p[2] == *z;
    });
    return flat ? z : std::nullopt;
}

bool is_nearly_flat(const Mesh<3>& mesh) {
    constexpr double rounding = 1e-9;
    if (!is_standalone_surface(mesh)) return false;
    Box<3> box;
    static_cast<void>(all_used(mesh, [&](const Vec<3>& p) {
        box.include(p);
        return true;
    }));
    const Vec<3> size = box.high - box.low;
    return size[2] <= rounding * std::max(size[0], size[1]);
}

// ---------------------------------------------------------------- points and directions

Vec<2> without_z(const Vec<3>& p) { return {{p[0], p[1]}}; }
Vec<3> with_z(const Vec<2>& p, double z) { return {{p[0], p[1], z}}; }

template <class To, class From, class F>
Outcome<Column<To>> mapped(const Column<From>& items, const Execution& execution, F&& f) {
    return map_each(
               execution, items.size(), [&](std::size_t i) -> To { return f(items[i]); }, row_grain)
        .map([](Buffer<To> result) { return Column<To>(std::move(result)); });
}

bool leaves_plane(const Column<Vec<3>>& directions) {
    return std::any_of(directions.begin(), directions.end(), [](const Vec<3>& d) { return d[2] != 0; });
}

/// Projects directions to the plane into `to`. If a direction has a z component, all are stored in `lifted` instead.
Outcome<Done> lower_directions(const DirectionsAtVertices<3>& from, DirectionsAtVertices<2>& to,
                               DirectionsAtVertices<3>& lifted, const Execution& execution) {
    if (leaves_plane(from.table)) {
        lifted = from;
        return Done{};
    }
    return mapped<Vec<2>>(from.table, execution, without_z).map([&](Column<Vec<2>> table) {
        to = {std::move(table), from.at};
        return Done{};
    });
}

Outcome<Done> raise_directions(const DirectionsAtVertices<2>& from, const DirectionsAtVertices<3>& lifted,
                               DirectionsAtVertices<3>& to, const Execution& execution) {
    if (!lifted.table.empty()) {
        to = lifted;
        return Done{};
    }
    return mapped<Vec<3>>(from.table, execution, [](const Vec<2>& d) { return with_z(d, 0); })
        .map([&](Column<Vec<3>> table) {
            to = {std::move(table), from.at};
            return Done{};
        });
}

template <int From, int To>
void copy_associations(const InputGeometry<From>& from, InputGeometry<To>& to) {
    to.on_points = from.on_points;
    to.on_curves = from.on_curves;
    to.on_surfaces = from.on_surfaces;
}

Outcome<Done> lower_geometry(const InputGeometry<3>& from, InputGeometry<2>& to, Lift& lift,
                             const Execution& execution) {
    copy_associations(from, to);
    return lower_directions(from.normals, to.normals, lift.normals, execution).and_then([&](Done) {
        return lower_directions(from.tangents, to.tangents, lift.tangents, execution);
    });
}

Outcome<Done> raise_geometry(const InputGeometry<2>& from, const Lift& lift, InputGeometry<3>& to,
                             const Execution& execution) {
    copy_associations(from, to);
    return raise_directions(from.normals, lift.normals, to.normals, execution).and_then([&](Done) {
        return raise_directions(from.tangents, lift.tangents, to.tangents, execution);
    });
}

Outcome<Column<double>> heights(const Mesh<3>& mesh, double z, const Execution& execution) {
    if (std::all_of(mesh.points.begin(), mesh.points.end(), [&](const Vec<3>& p) { return p[2] == z; }))
        return Column<double>{};
    return mapped<double>(mesh.points, execution, [](const Vec<3>& p) { return p[2]; });
}

// ---------------------------------------------------------------- edges and their nodes

Outcome<MeshEntities<2>> lowered(const MeshEntities<3>& entities, const Execution& execution) {
    return mapped<std::array<EdgeId, 1>>(entities.edges_of_edges, execution, [](EdgeId e) { return std::array{e}; })
        .map([&](Column<std::array<EdgeId, 1>> of_facets) {
            MeshEntities<2> flat;
            flat.edges = entities.edges;
            flat.edges_of_elements = entities.edges_of_facets;
            flat.edges_of_facets.of<Shape::line>().ids = std::move(of_facets);
            return flat;
        });
}

Outcome<MeshEntities<3>> raised(const MeshEntities<2>& entities, const Execution& execution) {
    const auto& of_facets = entities.edges_of_facets.of<Shape::line>().ids;
    return mapped<EdgeId>(of_facets, execution, [](const std::array<EdgeId, 1>& of) { return of[0]; })
        .map([&](Column<EdgeId> of_edges) {
            MeshEntities<3> space;
            space.edges = entities.edges;
            space.edges_of_facets = entities.edges_of_elements;
            space.edges_of_edges = std::move(of_edges);
            return space;
        });
}

auto no_inner_nodes() {
    return fail(ErrorKind::unsupported, "has nodes inside its faces, which flat meshes in space do not support");
}

}  // namespace

Outcome<std::optional<Flattened>> flattened(const Mesh<3>& mesh, const Execution& execution) {
    return guarded([&]() -> Outcome<std::optional<Flattened>> {
        const auto z = common_height(mesh);
        if (!z) return std::nullopt;
        if (!mesh.face_nodes.empty()) return no_inner_nodes();
        auto points = mapped<Vec<2>>(mesh.points, execution, without_z);
        if (!points) return fail(std::move(points.error()));
        auto each_height = heights(mesh, *z, execution);
        if (!each_height) return fail(std::move(each_height.error()));
        auto entities = lowered(mesh.entities, execution);
        if (!entities) return fail(std::move(entities.error()));
        auto nodes = mapped<LagrangeNode<2>>(mesh.edge_nodes, execution, [](const LagrangeNode<3>& node) {
            return LagrangeNode<2>{without_z(node.point)};
        });
        if (!nodes) return fail(std::move(nodes.error()));
        Flattened flat{.mesh = {.degree = mesh.degree,
                                .points = std::move(*points),
                                .edge_nodes = std::move(*nodes),
                                .face_nodes = {},
                                .inner_nodes = {},
                                .point_references = mesh.point_references,
                                .corners = mesh.corners,
                                .required_vertices = mesh.required_vertices,
                                .elements = mesh.facets,
                                .facets = {},
                                .edges = {},
                                .ridges = mesh.ridges,
                                .geometry = {},
                                .groups = mesh.groups,
                                .entities = std::move(*entities)},
                       .lift = {.z = *z, .heights = std::move(*each_height)}};
        flat.mesh.facets.of<Shape::line>() = mesh.edges;
        return lower_geometry(mesh.geometry, flat.mesh.geometry, flat.lift, execution).map([&](Done) {
            return std::optional(std::move(flat));
        });
    });
}

Outcome<Mesh<3>> raised(const Mesh<2>& mesh, const Lift& lift, const Execution& execution) {
    return guarded([&]() -> Outcome<Mesh<3>> {
        if (!lift.heights.empty() && lift.heights.size() != mesh.points.size())
            return fail(ErrorKind::internal, "the lift belongs to a mesh with a different number of vertices");
        if (!mesh.inner_nodes.empty()) return no_inner_nodes();
        auto points = map_each(
            execution, mesh.points.size(),
            [&](std::size_t v) { return with_z(mesh.points[v], lift.heights.empty() ? lift.z : lift.heights[v]); },
            row_grain);
        if (!points) return fail(std::move(points.error()));
        auto entities = raised(mesh.entities, execution);
        if (!entities) return fail(std::move(entities.error()));
        auto nodes = mapped<LagrangeNode<3>>(mesh.edge_nodes, execution, [&](const LagrangeNode<2>& node) {
            return LagrangeNode<3>{with_z(node.point, lift.z)};
        });
        if (!nodes) return fail(std::move(nodes.error()));
        Mesh<3> space{.degree = mesh.degree,
                      .points = std::move(*points),
                      .edge_nodes = std::move(*nodes),
                      .face_nodes = {},
                      .inner_nodes = {},
                      .point_references = mesh.point_references,
                      .corners = mesh.corners,
                      .required_vertices = mesh.required_vertices,
                      .elements = {},
                      .facets = mesh.elements,
                      .edges = mesh.facets.of<Shape::line>(),
                      .ridges = mesh.ridges,
                      .geometry = {},
                      .groups = mesh.groups,
                      .entities = std::move(*entities)};
        return raise_geometry(mesh.geometry, lift, space.geometry, execution).map([&](Done) {
            return std::move(space);
        });
    });
}

Outcome<AnyMesh> raised(const AnyMesh& mesh, const Lift& lift, const Execution& execution) {
    if (const auto* const in_2d = std::get_if<Mesh<2>>(&mesh))
        return raised(*in_2d, lift, execution).map([](Mesh<3> result) { return AnyMesh(std::move(result)); });
    return mesh;
}

Outcome<DecodedMesh> with_flat_in_2d(DecodedMesh decoded, const Execution& execution) {
    return guarded([&]() -> Outcome<DecodedMesh> {
        const auto* const mesh = std::get_if<Mesh<3>>(&decoded.mesh);
        if (!mesh) return std::move(decoded);
        auto flat = flattened(*mesh, execution);
        if (!flat) return fail(std::move(flat.error()));
        if (*flat) {
            auto fields = flattened(decoded.fields, execution);
            if (!fields) return fail(std::move(fields.error()));
            decoded.fields = std::move(*fields);
            decoded.lift = std::move((*flat)->lift);
            decoded.mesh = std::move((*flat)->mesh);
        } else if (is_nearly_flat(*mesh)) {
            decoded.notices.push_back(
                {"the mesh is nearly flat: its z values differ only by rounding. It is read as a surface in space; "
                 "with equal z values it would be a mesh in 2D"});
        }
        return std::move(decoded);
    });
}

}  // namespace camber
