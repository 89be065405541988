module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.io;
import camber.transfer;
import :solution;
import :solution_report;

namespace camber::run {

std::vector<Column<double>> scalars_of(std::span<const NamedField> fields) {
    std::vector<Column<double>> scalars;
    for (const NamedField& field : fields) {
        const auto width = static_cast<std::size_t>(field.field.components);
        for (std::size_t c = 0; c < width; ++c) {
            if (width == 1) {
                scalars.push_back(field.field.values);
                continue;
            }
            Buffer<double> values(field.field.values.size() / width, 0.0);
            for (std::size_t n = 0; n < values.size(); ++n) values[n] = field.field.values[n * width + c];
            scalars.emplace_back(std::move(values));
        }
    }
    return scalars;
}

Outcome<std::vector<NamedField>> named(std::vector<NamedField> fields, const std::vector<std::string>& names,
                                       const std::string& where) {
    if (names.empty()) return fields;
    std::vector<NamedField> wanted;
    for (const std::string& name : names) {
        const auto found = std::ranges::find(fields, name, &NamedField::name);
        if (found == fields.end()) {
            std::string there;
            for (const NamedField& field : fields) there += (there.empty() ? "" : ", ") + field.name;
            return fail(ErrorKind::usage, "there is no field of the name " + name, where, {}, "there is " + there);
        }
        if (std::ranges::find(wanted, name, &NamedField::name) == wanted.end()) wanted.push_back(*found);
    }
    return wanted;
}

template <int D>
Outcome<QuadraticMesh<D>> of_degree_2(const AnyMesh& mesh, const Execution& execution) {
    if (const auto* linear = std::get_if<LinearMesh<D>>(&mesh)) return elevate(*linear, execution);
    if (const auto* quadratic = std::get_if<QuadraticMesh<D>>(&mesh)) return *quadratic;
    return fail(ErrorKind::internal, "the mesh is of another dimension");
}
template Outcome<QuadraticMesh<2>> of_degree_2<2>(const AnyMesh&, const Execution&);
template Outcome<QuadraticMesh<3>> of_degree_2<3>(const AnyMesh&, const Execution&);

Outcome<std::size_t> nodes_in_degree_2(const AnyMesh& mesh, const Execution& execution) {
    return std::visit(
        [&](const auto& m) -> Outcome<std::size_t> {
            if constexpr (requires { m.linear; })
                return m.linear.points.size() + m.edges.size();
            else
                return unique_edges(m, execution).map([&](const auto& edges) {
                    return m.points.size() + edges.size();
                });
        },
        mesh);
}

namespace {

template <int D>
Outcome<TransferredFields> brought(const AnyMesh& to, const AnyMesh& from, std::vector<NamedField> fields,
                                   const TransferOptions& options, const Execution& execution) {
    const auto old_mesh = of_degree_2<D>(from, without_progress(execution));
    if (!old_mesh) return fail(old_mesh.error());
    const auto new_mesh = of_degree_2<D>(to, without_progress(execution));
    if (!new_mesh) return fail(new_mesh.error());
    std::vector<TransferField> given;
    std::vector<std::string> names;
    for (const NamedField& field : fields) {
        given.push_back(field.field);
        names.push_back(field.name);
    }
    auto made = transfer<D>(*old_mesh, given, *new_mesh, options, execution);
    if (!made) return fail(made.error());
    for (std::size_t f = 0; f < fields.size(); ++f) fields[f].field = std::move(made->fields[f]);
    return TransferredFields{std::move(fields), {options.method, std::move(names), std::move(made->statistics)}};
}

/// Of the nodes of a mesh: how many are vertices, and the ends of the edges that have others; none of a straight one.
struct NodesOfMesh {
    std::size_t vertices = 0;
    Column<std::array<VertexId, 2>> edges;
};
NodesOfMesh nodes_of(const AnyMesh& mesh) {
    return std::visit(
        [](const auto& m) -> NodesOfMesh {
            if constexpr (requires { m.linear; })
                return {m.linear.points.size(), m.edges.vertices};
            else
                return {m.points.size(), {}};
        },
        mesh);
}

Column<double> at_all_nodes(const NodesOfMesh& nodes, const TransferField& field) {
    const auto width = static_cast<std::size_t>(field.components);
    Buffer<double> values(field.values.begin(), field.values.end());
    values.resize((nodes.vertices + nodes.edges.size()) * width, 0.0);  // a straight mesh has no nodes on its edges
    if (field.degree == 2) return Column<double>(std::move(values));
    for (std::size_t e = 0; e < nodes.edges.size(); ++e) {
        const auto& [a, b] = nodes.edges[e];
        for (std::size_t c = 0; c < width; ++c)
            values[(nodes.vertices + e) * width + c] =
                0.5 * (values[a.index() * width + c] + values[b.index() * width + c]);
    }
    return Column<double>(std::move(values));
}

}  // namespace

Outcome<TransferredFields> fields_brought_to(const AnyMesh& new_mesh, const AnyMesh& old_mesh,
                                             std::vector<NamedField> fields, const TransferOptions& options,
                                             const Around& around) {
    return std::visit(
        [&]<class New, class Old>(const New&, const Old&) -> Outcome<TransferredFields> {
            constexpr int D = New::dimension;
            if constexpr (D != Old::dimension)
                return fail(ErrorKind::input, "is not of the dimension of the old mesh", {}, {},
                            "give two meshes of one domain");
            else
                return run_step(around, "transfer", [&](const Execution& e) {
                    return brought<D>(new_mesh, old_mesh, std::move(fields), options, e);
                });
        },
        new_mesh, old_mesh);
}

std::vector<NamedField> at_vertices(const AnyMesh& mesh, std::vector<NamedField> fields) {
    const std::size_t vertices = nodes_of(mesh).vertices;
    for (NamedField& field : fields) {
        TransferField& given = field.field;
        if (given.degree == 1) continue;
        const auto count = static_cast<std::ptrdiff_t>(vertices * static_cast<std::size_t>(given.components));
        given.values = Column<double>(Buffer<double>(given.values.begin(), given.values.begin() + count));
        given.degree = 1;
    }
    return fields;
}

MeshFields as_mesh_fields(const AnyMesh& mesh, std::span<const NamedField> fields) {
    const NodesOfMesh nodes = nodes_of(mesh);
    MeshFields all;
    for (const NamedField& field : fields)
        all = std::move(all).with({field.name, Centring::node, field.kind, at_all_nodes(nodes, field.field)});
    return all;
}

}  // namespace camber::run
