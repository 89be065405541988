// JSON reports of checks and of meshes
module;
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
#include <nlohmann/json.hpp>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.validity;
import camber.crossing;
import camber.soundness;
import camber.surface;
import :json;

namespace camber::run {

namespace {

Json json(const std::vector<ReferenceCount>& counts) {
    Json j = Json::object();
    for (const auto& [reference, count] : counts) j[std::to_string(reference)] = count;
    return j;
}

/// The counts under their keys; `first` and the sentences of what was found.
Json json(const SoundnessReport& s) {
    Json j{{"sound", s.sound}, {"empty", s.empty}};
    for (const SoundnessReport::Entry& found : s.findings) j[found.key] = found.count;
    Json first = Json::object(), findings = Json::object();
    for (const SoundnessReport::Entry& found : s.findings) {
        if (found.count == 0) continue;
        first[found.key] = found.other > 0 ? Json{found.first, found.other} : Json{found.first};
        findings[found.key] = {{"count", found.count},
                               {"first", first[found.key]},
                               {"category", text_of(found.concern).name},
                               {"is_harmful", found.harms},
                               {"text", found.sentence}};
    }
    j["first"] = std::move(first);
    j["findings"] = std::move(findings);
    return j;
}

Json json(const CrossingsReport& c) {
    Json j{{"examined", c.looked_at},  {"facets", c.facets},     {"pairs", c.pairs},
           {"crossing", c.crossing},   {"touching", c.touching}, {"undecided", c.undecided},
           {"truncated", c.cut_short}, {"steps", c.steps},       {"found", Json::array()}};
    for (const CrossingReport& found : c.found) {
        const auto& [a, b] = found.facets;
        j["found"].push_back({{"verdict", word(found.verdict)},
                              {"facets", {a.number, b.number}},
                              {"references", {a.reference, b.reference}},
                              {"vertices", {a.vertices, b.vertices}},
                              {"also_when_straight", found.straight_too}});
    }
    return j;
}

Json json(const OverlapsReport& o) {
    Json j{{"examined", o.looked_at},
           {"walls", o.walls},
           {"overlapping", o.overlapping},
           {"undecided", o.undecided},
           {"found", Json::array()}};
    for (const OverlapReport& pair : o.found) {
        Json found{{"elements", pair.elements}};
        if (pair.tags[0] != 0) found["tags"] = pair.tags;
        found["references"] = pair.references;
        found["point"] = pair.point;
        j["found"].push_back(std::move(found));
    }
    return j;
}

Json json(const ElementReport& e, int degree, const Groups& groups, int dimension) {
    Json j{{"element", e.number}};
    if (e.tag != 0) j["tag"] = e.tag;
    j["reference"] = e.reference;
    if (const std::string name = name_in(groups, dimension, e.reference); !name.empty()) j["name"] = name;
    j.update({{"verdict", word(e.verdict)}, {"vertices", e.vertices}});
    if (degree == 2) {
        j["min_scaled_jacobian"] = e.min_scaled_jacobian;
        j["straight_inverted"] = e.straight_inverted;
        if (e.witness)
            j["witness"] = {{"barycentric", e.witness->barycentric},
                            {"point", e.witness->point},
                            {"scaled_jacobian", e.witness->scaled_jacobian}};
    } else {
        j["quality"] = e.quality;
        j["volume"] = e.volume;
    }
    j["reason"] = e.reason;
    return j;
}

/// The dimension of what is judged.
int judged_dimension(const MeshReport& m) { return m.is_surface_alone() ? 2 : m.dimension; }

/// The file's own numbers of elements; none where they have none.
Json tags_of(const std::vector<std::size_t>& elements, const CheckReport& report) {
    Json tags = Json::array();
    for (const std::size_t e : elements)
        if (const auto tag = report.numbers.tag(judged_dimension(report.mesh), e); tag != 0) tags.push_back(tag);
    return tags;
}

Json json(const MeshReport& m) {
    return {{"dimension", m.dimension}, {"degree", m.degree}, {"vertices", m.vertices},          {"nodes", m.nodes},
            {"elements", m.elements},   {"facets", m.facets}, {"feature_edges", m.feature_edges}};
}

}  // namespace

std::string check_json_head(const CheckReport& report, std::string_view name, std::string_view version) {
    Json j{{"format", report_format}, {"program", {{"name", "camber"}, {"version", version}}}, {"file", name}};
    j.update(json(report.mesh));
    j["elements_by_reference"] = json(report.elements_by_reference);
    j["facets_by_reference"] = json(report.facets_by_reference);
    j["feature_edges_by_reference"] = json(report.feature_edges_by_reference);
    Json groups = Json::array();
    for (const Group& group : report.groups)
        groups.push_back({{"dimension", group.dimension}, {"reference", group.reference}, {"name", group.name}});
    j["groups"] = std::move(groups);
    const ValidityReport& v = report.validity;
    j["all_good"] = report.all_good();
    j["answer"] = check_answer(report);
    j["bound"] = v.bound;
    j["valid"] = report.mesh.judged() - v.invalid - v.undecided;
    j["invalid"] = v.invalid;
    j["undecided"] = v.undecided;
    j["straight_inverted"] = v.straight_inverted;
    // Of no element there is no such number.
    j["min_scaled_jacobian"] =
        report.mesh.judged() > 0 && (v.worst > 0 || !report.mesh.is_surface_alone()) ? Json(v.smallest) : Json(nullptr);
    j["worst_element"] = v.worst;
    Json worst = Json::array();
    for (const ElementReport& element : report.worst)
        worst.push_back(json(element, report.mesh.degree, report.groups, judged_dimension(report.mesh)));
    j["worst"] = std::move(worst);
    if (!report.histograms.empty()) j["histograms"] = json_of(report.histograms);
    for (const auto& [key, elements] :
         {std::pair("invalid", &report.invalid_elements), std::pair("undecided", &report.undecided_elements),
          std::pair("straight_inverted", &report.straight_inverted_elements),
          std::pair("wall", &report.wall_elements)}) {
        j[std::string(key) + "_elements"] = *elements;
        if (const Json tags = tags_of(*elements, report); !tags.empty()) j[std::string(key) + "_element_tags"] = tags;
    }
    j["soundness"] = json(report.soundness);
    j["crossings"] = json(report.crossings);
    j["overlaps"] = json(report.overlaps);
    if (report.unit_mesh) j["unit_mesh"] = json_of(*report.unit_mesh);
    if (report.curved_unit_mesh) j["curved_unit_mesh"] = json_of(*report.curved_unit_mesh);
    if (!report.fields.empty()) {
        j["interpolation"] = Json::array();
        for (const FieldErrors& field : report.fields) j["interpolation"].push_back(Json::parse(field_json(field)));
    }
    j["notices"] = report.notices;
    std::string text = j.dump(2, ' ', false, Json::error_handler_t::replace);
    text.resize(text.size() - 2);  // "\n}"
    return text;
}

namespace {

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
    j["isolated_facets"] = report.lone_facets;
    j["open_edges"] = json(report.open);
    j["non_manifold_edges"] = json(report.crowded);
    j["misoriented_facets"] = json(report.turned);
    Json suspicious = Json::object();
    for (const PlacesReport& places : report.suspicious) suspicious[places.kind] = json(places);
    j["suspicious"] = std::move(suspicious);
    if (report.cad) j["cad"] = json_of(*report.cad);
    if (report.distances) {
        j["geometry"] = report.distances->geometry;
        j["distances"] = json_of(*report.distances);
    }
    j["notices"] = report.notices;
    return j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace camber::run
