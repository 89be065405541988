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

// ---------------------------------------------------------------- is it flat?

/// The z of all that triangles and edges use, if it is one.
std::optional<double> common_height(const LinearMesh<3>& mesh) {
    if (mesh.elements.size() > 0 || mesh.facets.size() == 0) return std::nullopt;
    const double z = mesh.points[mesh.facets.vertices[0][0]][2] + 0.0;  // −0 becomes 0
    const auto at_height = [&](const auto& simplex) {
        return std::all_of(simplex.begin(), simplex.end(), [&](VertexId v) { return mesh.points[v][2] == z; });
    };
    const bool flat = std::all_of(mesh.facets.vertices.begin(), mesh.facets.vertices.end(), at_height) &&
                      std::all_of(mesh.edges.vertices.begin(), mesh.edges.vertices.end(), at_height);
    return flat ? std::optional(z) : std::nullopt;
}

std::optional<double> common_height(const QuadraticMesh<3>& mesh) {
    const auto z = common_height(mesh.linear);
    const bool flat = z && std::all_of(mesh.mid_nodes.begin(), mesh.mid_nodes.end(),
                                       [&](const LagrangeNode<3>& node) { return node.point[2] == *z; });
    return flat ? z : std::nullopt;
}

/// Where all lies that triangles and edges use.
Box<3> box_of(const LinearMesh<3>& mesh) {
    Box<3> box;
    const auto include = [&](const auto& simplex) {
        for (const VertexId v : simplex) box.include(mesh.points[v]);
    };
    for (const auto& triangle : mesh.facets.vertices) include(triangle);
    for (const auto& edge : mesh.edges.vertices) include(edge);
    return box;
}
Box<3> box_of(const QuadraticMesh<3>& mesh) {
    Box<3> box = box_of(mesh.linear);
    for (const LagrangeNode<3>& node : mesh.mid_nodes) box.include(node.point);
    return box;
}

const LinearMesh<3>& linear_part(const LinearMesh<3>& mesh) { return mesh; }
const LinearMesh<3>& linear_part(const QuadraticMesh<3>& mesh) { return mesh.linear; }

/// Triangles alone whose z differ by rounding only.
bool is_nearly_flat(const auto& mesh) {
    constexpr double rounding = 1e-9;
    if (linear_part(mesh).elements.size() > 0 || linear_part(mesh).facets.size() == 0) return false;
    const Box<3> box = box_of(mesh);
    const Vec<3> size = box.high - box.low;
    return size[2] <= rounding * std::max(size[0], size[1]);
}

// ---------------------------------------------------------------- points and directions

Vec<2> without_z(const Vec<3>& p) { return {{p[0], p[1]}}; }
Vec<3> with_z(const Vec<2>& p, double z) { return {{p[0], p[1], z}}; }

/// The column of f(item).
template <class To, class From, class F>
Outcome<Column<To>> mapped(const Column<From>& items, const Execution& execution, F&& f) {
    return map_each(
               execution, items.size(), [&](std::size_t i) -> To { return f(items[i]); }, row_grain)
        .map([](Buffer<To> made) { return Column<To>(std::move(made)); });
}

bool leaves_plane(const Column<Vec<3>>& directions) {
    return std::any_of(directions.begin(), directions.end(), [](const Vec<3>& d) { return d[2] != 0; });
}

/// Directions that leave the plane go with the lift.
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

/// Associations do not speak of coordinates: they are the same in 2D and in space.
template <int From, int To>
void keep_associations(const GivenGeometry<From>& from, GivenGeometry<To>& to) {
    to.on_points = from.on_points;
    to.on_curves = from.on_curves;
    to.on_surfaces = from.on_surfaces;
}

Outcome<Done> lower_geometry(const GivenGeometry<3>& from, GivenGeometry<2>& to, Lift& lift,
                             const Execution& execution) {
    keep_associations(from, to);
    return lower_directions(from.normals, to.normals, lift.normals, execution).and_then([&](Done) {
        return lower_directions(from.tangents, to.tangents, lift.tangents, execution);
    });
}

Outcome<Done> raise_geometry(const GivenGeometry<2>& from, const Lift& lift, GivenGeometry<3>& to,
                             const Execution& execution) {
    keep_associations(from, to);
    return raise_directions(from.normals, lift.normals, to.normals, execution).and_then([&](Done) {
        return raise_directions(from.tangents, lift.tangents, to.tangents, execution);
    });
}

/// The z of each vertex; none where all have the lift's.
Outcome<Column<double>> heights(const LinearMesh<3>& mesh, double z, const Execution& execution) {
    if (std::all_of(mesh.points.begin(), mesh.points.end(), [&](const Vec<3>& p) { return p[2] == z; }))
        return Column<double>{};
    return mapped<double>(mesh.points, execution, [](const Vec<3>& p) { return p[2]; });
}

// ---------------------------------------------------------------- straight meshes

Outcome<Flattened<LinearMesh<2>>> lowered(const LinearMesh<3>& mesh, double z, const Execution& execution) {
    auto points = mapped<Vec<2>>(mesh.points, execution, without_z);
    if (!points) return fail(std::move(points.error()));
    auto each_height = heights(mesh, z, execution);
    if (!each_height) return fail(std::move(each_height.error()));
    Flattened<LinearMesh<2>> flat;
    flat.lift.z = z;
    flat.lift.heights = std::move(*each_height);
    flat.mesh.points = std::move(*points);
    flat.mesh.point_references = mesh.point_references;
    flat.mesh.corners = mesh.corners;
    flat.mesh.required_vertices = mesh.required_vertices;
    flat.mesh.elements = mesh.facets;
    flat.mesh.facets = mesh.edges;
    flat.mesh.ridges = mesh.ridges;
    flat.mesh.groups = mesh.groups;
    return lower_geometry(mesh.geometry, flat.mesh.geometry, flat.lift, execution).map([&](Done) {
        return std::move(flat);
    });
}

// ---------------------------------------------------------------- edges of quadratic meshes

/// Edges of one set by the simplices of another: the same edges, a triangle's three and an edge's one.
Outcome<EdgeSet<2>> lowered(const EdgeSet<3>& edges, const Execution& execution) {
    return mapped<std::array<EdgeId, 1>>(edges.of_edges, execution, [](EdgeId e) { return std::array{e}; })
        .map([&](Column<std::array<EdgeId, 1>> of_facets) {
            return EdgeSet<2>{edges.vertices, edges.of_facets, std::move(of_facets), {}};
        });
}

Outcome<EdgeSet<3>> raised(const EdgeSet<2>& edges, const Execution& execution) {
    return mapped<EdgeId>(edges.of_facets, execution, [](const std::array<EdgeId, 1>& of) { return of[0]; })
        .map([&](Column<EdgeId> of_edges) {
            return EdgeSet<3>{edges.vertices, {}, edges.of_elements, std::move(of_edges)};
        });
}

}  // namespace

Outcome<std::optional<Flattened<LinearMesh<2>>>> flattened(const LinearMesh<3>& mesh, const Execution& execution) {
    return guarded([&]() -> Outcome<std::optional<Flattened<LinearMesh<2>>>> {
        const auto z = common_height(mesh);
        if (!z) return std::nullopt;
        auto flat = lowered(mesh, *z, execution);
        if (!flat) return fail(std::move(flat.error()));
        return std::move(*flat);
    });
}

Outcome<std::optional<Flattened<QuadraticMesh<2>>>> flattened(const QuadraticMesh<3>& mesh,
                                                              const Execution& execution) {
    return guarded([&]() -> Outcome<std::optional<Flattened<QuadraticMesh<2>>>> {
        const auto z = common_height(mesh);
        if (!z) return std::nullopt;
        auto linear = lowered(mesh.linear, *z, execution);
        if (!linear) return fail(std::move(linear.error()));
        auto edges = lowered(mesh.edges, execution);
        if (!edges) return fail(std::move(edges.error()));
        auto nodes = mapped<LagrangeNode<2>>(mesh.mid_nodes, execution, [](const LagrangeNode<3>& node) {
            return LagrangeNode<2>{without_z(node.point)};
        });
        if (!nodes) return fail(std::move(nodes.error()));
        return Flattened<QuadraticMesh<2>>{{std::move(linear->mesh), std::move(*edges), std::move(*nodes)},
                                           std::move(linear->lift)};
    });
}

Outcome<LinearMesh<3>> raised(const LinearMesh<2>& mesh, const Lift& lift, const Execution& execution) {
    return guarded([&]() -> Outcome<LinearMesh<3>> {
        if (!lift.heights.empty() && lift.heights.size() != mesh.points.size())
            return fail(ErrorKind::internal, "the lift is of a mesh with another number of vertices");
        LinearMesh<3> space;
        auto points = map_each(
            execution, mesh.points.size(),
            [&](std::size_t v) { return with_z(mesh.points[v], lift.heights.empty() ? lift.z : lift.heights[v]); },
            row_grain);
        if (!points) return fail(std::move(points.error()));
        space.points = std::move(*points);
        space.point_references = mesh.point_references;
        space.corners = mesh.corners;
        space.required_vertices = mesh.required_vertices;
        space.facets = mesh.elements;
        space.edges = mesh.facets;
        space.ridges = mesh.ridges;
        space.groups = mesh.groups;
        return raise_geometry(mesh.geometry, lift, space.geometry, execution).map([&](Done) {
            return std::move(space);
        });
    });
}

Outcome<QuadraticMesh<3>> raised(const QuadraticMesh<2>& mesh, const Lift& lift, const Execution& execution) {
    return guarded([&]() -> Outcome<QuadraticMesh<3>> {
        auto linear = raised(mesh.linear, lift, execution);
        if (!linear) return fail(std::move(linear.error()));
        auto edges = raised(mesh.edges, execution);
        if (!edges) return fail(std::move(edges.error()));
        auto nodes = mapped<LagrangeNode<3>>(mesh.mid_nodes, execution, [&](const LagrangeNode<2>& node) {
            return LagrangeNode<3>{with_z(node.point, lift.z)};
        });
        if (!nodes) return fail(std::move(nodes.error()));
        return QuadraticMesh<3>{std::move(*linear), std::move(*edges), std::move(*nodes)};
    });
}

Outcome<AnyMesh> raised(const AnyMesh& mesh, const Lift& lift, const Execution& execution) {
    return std::visit(
        [&]<class Mesh>(const Mesh& m) -> Outcome<AnyMesh> {
            if constexpr (Mesh::dimension == 3)
                return AnyMesh(m);
            else
                return raised(m, lift, execution).map([](auto made) { return AnyMesh(std::move(made)); });
        },
        mesh);
}

Outcome<DecodedMesh> with_flat_in_2d(DecodedMesh decoded, const Execution& execution) {
    const auto put_down = [&]<class Mesh>(const Mesh& mesh) -> Outcome<DecodedMesh> {
        if constexpr (Mesh::dimension == 3) {
            auto flat = flattened(mesh, execution);
            if (!flat) return fail(std::move(flat.error()));
            if (*flat) {
                auto fields = flattened(decoded.fields, execution);
                if (!fields) return fail(std::move(fields.error()));
                decoded.fields = std::move(*fields);
                decoded.lift = std::move((*flat)->lift);
                decoded.mesh = std::move((*flat)->mesh);
                return std::move(decoded);
            }
            if (is_nearly_flat(mesh))
                decoded.notices.push_back(
                    {"the mesh is nearly flat, its z differ by rounding: taken as a surface in space (with one and the "
                     "same z it would be a mesh in 2D)"});
        }
        return std::move(decoded);
    };
    return guarded([&] { return std::visit(put_down, decoded.mesh); });
}

}  // namespace camber
