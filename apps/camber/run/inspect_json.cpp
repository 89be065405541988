module;
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>
module camber.run;
import camber.core;
import camber.surface;
import :distances_report;
import :inspect;
import :report;

namespace camber::run {

namespace {

using Json = nlohmann::ordered_json;

Json json(const HingeReport& at) { return {{"vertices", at.vertices}, {"point", at.point}, {"facets", at.facets}}; }

Json json(const HingesReport& hinges) {
    Json j{{"count", hinges.count}, {"first", Json::array()}};
    for (const HingeReport& at : hinges.first) j["first"].push_back(json(at));
    return j;
}

Json json(const PlacesReport& places) {
    Json j{{"count", places.count}, {"text", places.text}, {"worst", Json::array()}};
    for (const PlaceReport& place : places.worst) {
        Json one = json(place.at);
        one["value"] = place.value;
        one["text"] = place.text;
        j["worst"].push_back(std::move(one));
    }
    return j;
}

Json patches(const GeometryReport& report) {
    Json all = Json::array();
    for (std::size_t i = 0; i < report.patches.size(); ++i) {
        const auto& [facts, cad_faces] = report.patches[i];
        Json patch{{"patch", i + 1},         {"references", facts.references},
                   {"facets", facts.facets}, {"interface_facets", facts.interface_facets},
                   {"area", facts.area},     {"size", facts.size},
                   {"flat", facts.is_flat}};
        if (report.cad) patch[report.mesh.dimension == 2 ? "cad_edges" : "cad_faces"] = cad_faces;
        all.push_back(std::move(patch));
    }
    return all;
}

Json ridges(const GeometryReport& report) {
    Json all = Json::array();
    for (std::size_t i = 0; i < report.ridges.size(); ++i) {
        const CurveFacts& ridge = report.ridges[i];
        all.push_back({{"ridge", i + 1},
                       {"references", ridge.references},
                       {"edges", ridge.edges},
                       {"length", ridge.length},
                       {"min_turn", ridge.min_turn},
                       {"largest_turn", ridge.largest_turn}});
    }
    return all;
}

Json corners(const GeometryReport& report) {
    Json all = Json::array();
    for (const CornerReport& corner : report.corners)
        all.push_back({{"vertex", corner.vertex}, {"point", corner.point}});
    return all;
}

}  // namespace

std::string inspect_json(const GeometryReport& report, std::string_view name, std::string_view version) {
    const MeshReport& m = report.mesh;
    Json j{{"format", report_format}, {"program", {{"name", "camber"}, {"version", version}}}, {"file", name}};
    j.update({{"dimension", m.dimension},
              {"degree", m.degree},
              {"vertices", m.vertices},
              {"elements", m.elements},
              {"facets", m.facets},
              {"boundary_is_listed", report.is_listed},
              {"ridge_angle", report.ridge_angle}});
    j["patches"] = patches(report);
    j["ridges"] = ridges(report);
    j["corners"] = corners(report);
    j["smooth_listed_edges"] = report.smooth_listed_edges;
    j["interface_facets"] = report.interface_facets;
    j["lone_facets"] = report.lone_facets;
    j["open_edges"] = json(report.open);
    j["crowded_edges"] = json(report.crowded);
    j["turned_facets"] = json(report.turned);
    Json suspicious = Json::object();
    for (const PlacesReport& places : report.suspicious) suspicious[places.kind] = json(places);
    j["suspicious"] = std::move(suspicious);
    if (report.cad) j["cad"] = Json::parse(cad_json(*report.cad));
    if (report.distances) {
        j["geometry"] = report.distances->geometry;
        j["distances"] = Json::parse(distances_json(*report.distances));
    }
    j["notices"] = report.notices;
    return j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace camber::run
