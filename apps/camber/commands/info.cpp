module;
#include <algorithm>
#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.config;
import camber.io;
import :ending;
import :execute;
import :formats;

namespace camber::app {

namespace {

using Json = nlohmann::ordered_json;

Json by_reference(const Column<Reference>& references) {
    std::map<Reference, std::size_t> counts;
    for (const Reference r : references) ++counts[r];
    Json json = Json::object();
    for (const auto& [reference, count] : counts) json[std::to_string(reference)] = count;
    return json;
}

Json texts(const std::vector<Notice>& notices) {
    Json texts = Json::array();
    for (const Notice& notice : notices) texts.push_back(notice.what);
    return texts;
}

template <int D>
Json linear_part(const LinearMesh<D>& mesh, int degree) {
    Box<D> box;
    for (const Vec<D>& p : mesh.points) box.include(p);
    Json j{{"dimension", D}, {"degree", degree}, {"vertices", mesh.points.size()}};
    if (!mesh.points.empty()) j["box"] = {box.low.c, box.high.c};
    j[D == 2 ? "triangles" : "tetrahedra"] = mesh.elements.size();
    j[D == 2 ? "triangles_by_reference" : "tetrahedra_by_reference"] = by_reference(mesh.elements.references);
    j[D == 2 ? "edges" : "triangles"] = mesh.facets.size();
    j[D == 2 ? "edges_by_reference" : "triangles_by_reference"] = by_reference(mesh.facets.references);
    if constexpr (D == 3) {
        j["edges"] = mesh.edges.size();
        j["edges_by_reference"] = by_reference(mesh.edges.references);
    }
    j["ridges"] = mesh.ridges.size();
    j["corners"] = mesh.corners.size();
    j["required_vertices"] = mesh.required_vertices.size();
    j["required_edges"] = D == 2 ? mesh.facets.required.size() : mesh.edges.required.size();
    if constexpr (D == 3) j["required_triangles"] = mesh.facets.required.size();
    if (!mesh.groups.empty()) {
        Json groups = Json::array();
        for (const Group& group : mesh.groups)
            groups.push_back({{"dimension", group.dimension}, {"reference", group.reference}, {"name", group.name}});
        j["groups"] = std::move(groups);
    }
    j["normals"] = mesh.geometry.normals.at.size();
    j["tangents"] = mesh.geometry.tangents.at.size();
    j["empty"] = mesh.elements.vertices.empty() && mesh.facets.vertices.empty();
    return j;
}

template <int D>
Json described(const LinearMesh<D>& mesh) {
    return linear_part(mesh, 1);
}
template <int D>
Json described(const QuadraticMesh<D>& mesh) {
    Json j = linear_part(mesh.linear, 2);
    j["mid_nodes"] = mesh.mid_nodes.size();
    return j;
}

std::string_view name_of(FieldKind kind) {
    switch (kind) {
        case FieldKind::scalar: return "scalar";
        case FieldKind::vector: return "vector";
        case FieldKind::symmetric_tensor: return "symmetric tensor";
        case FieldKind::full_tensor: return "full tensor";
    }
    return {};
}

Json described(const Solution& solution) {
    Json fields = Json::array();
    for (const FieldKind kind : solution.fields) fields.push_back(name_of(kind));
    return {{"dimension", solution.dimension}, {"vertices", solution.rows}, {"fields", std::move(fields)}};
}

Json described(const MeshFields& fields) {
    Json all = Json::array();
    for (const MeshField& field : fields)
        all.push_back({{"name", field.name},
                       {"at", field.centring == Centring::node ? "nodes" : "cells"},
                       {"kind", name_of(field.kind)}});
    return all;
}

/// How cells that no mesh here holds become such as it does, where some are of a higher degree, or no simplices.
std::string what_splits(const std::vector<CellCount>& unheld, const std::string& path) {
    const auto is_of_degree = [](const CellCount& cells) {
        for (const std::string_view simplices : {"riangles", "etrahedra", "dges", "ines", "egments"})
            if (cells.kind.find(simplices) != std::string::npos &&
                cells.kind.find_first_of("3456") != std::string::npos)
                return true;
        return cells.kind.starts_with("Lagrange cells");
    };
    const bool any_degree = std::any_of(unheld.begin(), unheld.end(), is_of_degree),
               any_shape = !std::all_of(unheld.begin(), unheld.end(), is_of_degree);
    std::string text;
    if (any_shape)
        text =
            "into triangles and tetrahedra: in ParaView the filter Tetrahedralize, then Save Data as .vtu (ParaView "
            "does not read it? meshio convert " +
            path + " FILE.vtu)";
    if (any_degree)
        text += std::string(any_shape ? "; " : "") + "to degree 2: gmsh, with a file of the lines Merge \"" + path +
                "\"; SetOrder 2; Save \"FILE.msh\";";
    return text;
}

std::string text_of(const Json& value) {
    return value.is_string() ? value.get<std::string>() : value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// "1 inlet: 170, 2 wall: 734": counts by reference, with the names that groups give them.
std::string counts_text(std::string_view key, const Json& counts, const Json& info) {
    const int dimension = key.starts_with("edges") ? 1 : key.starts_with("triangles") ? 2 : 3;
    std::string text;
    for (const auto& [reference, count] : counts.items()) {
        std::string name;
        for (const Json& group : info.value("groups", Json::array()))
            if (name.empty() && group["dimension"] == dimension && text_of(group["reference"]) == reference)
                name = " " + text_of(group["name"]);  // the first is the main one
        text += (text.empty() ? "" : ", ") + reference + name + ": " + text_of(count);
    }
    return text;
}

/// The lines of one fact for people.
std::string rows_of(const std::string& key, const Json& value, const Json& info) {
    if (key.ends_with("_by_reference")) return result_row(key, counts_text(key, value, info));
    if (key != "notices" && key != "groups") return result_row(key, text_of(value));
    std::string text;
    for (const Json& item : value)
        text += result_row(text.empty() ? key : "",
                           key == "notices" ? text_of(item)
                                            : fmt::format("{}D {} {}", text_of(item["dimension"]),
                                                          text_of(item["reference"]), text_of(item["name"])));
    return text;
}

Outcome<Json> mesh_info(const std::string& path, DecodeOptions options) {
    options.unheld = Unheld::count;
    auto decoded = read_mesh(path, config::Flat::plane, options, Execution{});
    if (!decoded) return fail(std::move(decoded.error()));
    Json j = std::visit([](const auto& mesh) { return described(mesh); }, decoded->mesh);
    if (!decoded->unheld.empty()) {
        Json counts = Json::object();
        for (const CellCount& cells : decoded->unheld) counts[cells.kind] = cells.count;
        j["empty"] = false;
        j["not_held"] = std::move(counts);
        j["split"] = what_splits(decoded->unheld, path);
    }
    if (!decoded->fields.empty()) j["fields"] = described(decoded->fields);
    if (decoded->lift) {
        j["written_in_dimension"] = 3;
        j["z"] = decoded->lift->z;
    }
    j["notices"] = texts(decoded->notices);
    return j;
}

Outcome<Json> solution_info(const std::string& path) {
    const auto decoded = read_solution(path, Execution{});
    if (!decoded) return fail(decoded.error());
    Json j = described(decoded->solution);
    j["notices"] = texts(decoded->notices);
    return j;
}

}  // namespace

int info_command(const InfoArguments& arguments) {
    const auto found =
        is_solution_file(arguments.input) ? solution_info(arguments.input) : mesh_info(arguments.input, arguments.read);
    if (!found) return report_error(found.error());
    const Json& j = *found;
    if (arguments.json) return end_with(j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
    std::string text = called_input(arguments.input) + "\n";
    for (const auto& [key, value] : j.items())
        if (!(value.is_number() && value == 0) && !(value.is_structured() && value.empty()) && value != false)
            text += rows_of(key, value, j);
    return end_with(text);
}

}  // namespace camber::app
