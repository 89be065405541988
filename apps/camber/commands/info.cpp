module;
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
module camber.commands;
import camber.core;
import camber.config;
import camber.io;
import :ending;
import :execute;

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

}  // namespace

int info_command(const InfoArguments& arguments) {
    auto decoded = read_mesh(arguments.input, config::Flat::plane, Execution{});
    if (!decoded) return report_error(decoded.error());
    Json j = std::visit([](const auto& mesh) { return described(mesh); }, decoded->mesh);
    if (decoded->lift) {
        j["written_in_dimension"] = 3;
        j["z"] = decoded->lift->z;
    }
    Json notices = Json::array();
    for (const Notice& notice : decoded->notices) notices.push_back(notice.what);
    j["notices"] = std::move(notices);
    if (arguments.json) return end_with(j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
    std::string text = arguments.input + "\n";
    for (const auto& [key, value] : j.items())
        if (!(value.is_number() && value == 0) && !(value.is_structured() && value.empty()) && value != false)
            text += fmt::format("  {:<26}{}\n", key, value.dump(-1, ' ', false, Json::error_handler_t::replace));
    return end_with(text);
}

}  // namespace camber::app
