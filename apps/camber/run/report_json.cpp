module;
#include <cstddef>
#include <string>
#include <utility>
#include <vector>
#include <nlohmann/json.hpp>
module camber.run;
import camber.core;

namespace camber::run {

namespace {

using Json = nlohmann::ordered_json;

Json text_or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

/// The keys that stand first, and of the run's beginning.
Json head(const OriginReport& o) {
    Json input{{"mesh", text_or_null(o.mesh)},
               {"metric", text_or_null(o.metric)},
               {"dimension", o.dimension},
               {"degree", o.degree},
               {"vertices", o.vertices},
               {"elements", o.elements},
               {"facets", o.facets}};
    return {{"format", report_format},
            {"program", {{"name", "camber"}, {"version", o.version}}},
            {"input", std::move(input)},
            {"config", Json::parse(o.config)},
            {"units",
             {{"lengths", "those of the input mesh"},
              {"metric", "1/length^2"},
              {"angles", "degrees"},
              {"times", "seconds"},
              {"memory", "bytes"}}}};
}

Json json(const MeshReport& m) {
    Json j{{"dimension", m.dimension}, {"degree", m.degree}, {"vertices", m.vertices},          {"nodes", m.nodes},
           {"elements", m.elements},   {"facets", m.facets}, {"feature_edges", m.feature_edges}};
    if (m.is_surface_alone()) j["surface_alone"] = true;
    return j;
}
Json json(const MetricReport& m) {
    Json j{{"source", m.source},
           {"largest_anisotropy", m.largest_anisotropy},
           {"complexity", m.complexity},
           {"floored_tensors", m.floored}};
    for (const GradationReport& g : m.gradations)
        j["gradations"].push_back({{"sweeps", g.sweeps}, {"changed_vertices", g.changed}, {"converged", g.converged}});
    return j;
}
Json json(const PassReport& p) {
    Json rejected = Json::object();
    for (const auto& [reason, count] : p.rejected) rejected[reason] = count;
    return {{"pass", p.pass},
            {"rounds", p.rounds},
            {"proposals", p.proposals},
            {"planned", p.planned},
            {"accepted", p.accepted},
            {"rejected", std::move(rejected)},
            {"corrections", p.corrections},
            {"shortened", p.shortened},
            {"drawn_back", p.drawn_back},
            {"bent_around", p.bent_around},
            {"programmes", p.programmes},
            {"moved_nodes", p.moved_nodes},
            {"straight_inverted", p.straight_inverted},
            {"straight_positive", p.straight_positive},
            {"farthest_facet", p.farthest_facet},
            {"seconds", p.seconds}};
}
Json json(const RemeshReport& r) {
    Json passes = Json::array();
    for (const PassReport& p : r.passes) passes.push_back(json(p));
    Json j{{"before", Json::parse(unit_mesh_json(r.before))},
           {"after", Json::parse(unit_mesh_json(r.after))},
           {"passes", std::move(passes)}};
    if (r.nodes) j["nodes"] = {{"objective", r.nodes->objective}};
    if (const auto& b = r.bounded_facets)
        j["geometry_bound"] = {{"limited_facets", b->limited}, {"far_facets", b->far}};
    return j;
}
Json json(const CadReport& c) {
    Json j{{"unit", c.unit},
           {"file_unit", c.file_unit},
           {"unit_found", c.is_unit_found},
           {"faces", c.faces},
           {"edges", c.edges},
           {"vertices", c.vertices},
           {"lost_faces", c.lost_faces},
           {"failed_entities", c.failed_entities},
           {"open_shells", c.open_shells},
           {"faces_met", c.faces_met},
           {"edges_met", c.edges_met},
           {"vertices_met", c.vertices_met},
           {"facets", c.facets},
           {"analytic_facets", c.analytic_facets},
           {"surrogate_facets", c.surrogate_facets},
           {"coincident_facets", c.coincident_facets},
           {"doubtful_facets", c.doubtful_facets},
           {"settled_facets", c.settled_facets},
           {"doubtful_edges", c.doubtful_edges},
           {"doubtful_vertices", c.doubtful_vertices},
           {"largest_vertex_distance", c.largest_vertex_distance}};
    if (!c.within_materials.empty()) j["references_within_materials"] = c.within_materials;
    if (c.largest_node_distance) j["largest_node_distance"] = *c.largest_node_distance;
    if (!c.joined.lists.empty()) j["joined"] = c.joined.lists;
    if (c.across.count > 0) {
        j["facets_across_ridges"] = c.across.count;
        j["first_facet_across_ridges"] = c.across.first;
        j["place_of_first_ridge"] = c.across.place;
    }
    if (c.moves) {
        j["moved_vertices"] = c.moves->moved;
        j["held_vertices"] = c.moves->held;
        j["largest_vertex_move"] = c.moves->largest;
    }
    return j;
}
Json json(const BoundaryNodesReport& n) {
    return {{"by", n.by},
            {"edges", n.edges},
            {"placed", n.placed},
            {"best", n.best},
            {"off", n.off},
            {"far", n.far},
            {"elements", n.elements},
            {"walked", n.walked},
            {"limited", n.limited},
            {"mean_reduction", n.mean_reduction},
            {"largest_reduction", n.largest_reduction}};
}
Json json(const GeometryErrorReport& g) {
    return {{"required", g.required}, {"reached", g.reached}, {"far_facets", g.far_facets},
            {"facet", g.facet},       {"at", g.at},           {"by", g.is_required ? "config" : "expected_error"}};
}
Json json(const BoundaryReport& b) {
    Json j{{"surface_edges", b.surface_edges},
           {"ridge_edges", b.ridge_edges},
           {"corners", b.corners},
           {"patches", b.patches}};
    if (b.straight_distance) j["largest_distance_straight"] = *b.straight_distance;
    if (b.curved_distance) j["largest_distance"] = *b.curved_distance;
    if (b.cad) j["cad"] = json(*b.cad);
    if (b.off_surfaces) {
        j["vertices_off_surfaces"] = b.off_surfaces->vertices;
        j["largest_vertex_distance"] = b.off_surfaces->largest;
    }
    if (b.node_deviation) j["node_deviation"] = Json::parse(deviation_json(*b.node_deviation));
    if (b.vertex_deviation) j["vertex_deviation"] = Json::parse(deviation_json(*b.vertex_deviation));
    if (b.geometry_error) j["geometry_error"] = json(*b.geometry_error);
    if (b.distances) j["distances"] = Json::parse(distances_json(*b.distances));
    if (b.nodes) j["nodes"] = json(*b.nodes);
    if (b.curved_patches)
        j["curved_patches"] = {{"smooth", b.curved_patches->smooth},
                               {"as_read", b.curved_patches->as_read},
                               {"mean_angle", b.curved_patches->mean_angle},
                               {"largest_angle", b.curved_patches->largest_angle}};
    if (b.walls) j.update(Json::parse(walls_json(*b.walls)));
    return j;
}
Json json(const EdgeReport& e) {
    return {{"mean_length_reduction", e.mean_length_reduction},
            {"largest_length_reduction", e.largest_length_reduction},
            {"mean_curvature", e.mean_curvature},
            {"largest_curvature", e.largest_curvature},
            {"measured_edges", e.measured},
            {"longer_edges", e.longer}};
}
Json surface_json(const EdgeReport& e) {
    return {{"mean_curvature", e.mean_curvature}, {"largest_curvature", e.largest_curvature}};
}
/// Of a surface alone: nothing of volume edges, which it has none of, nor of lengths, which they do not reduce.
Json surface_json(const CurveReport& c) {
    Json j{{"edges", c.edges}, {"curved_edges", c.curved_edges}, {"before_correction", surface_json(c.before)}};
    if (c.after) j["after_correction"] = surface_json(*c.after);
    return j;
}
Json json(const CurveReport& c) {
    Json j{{"edges", c.edges},
           {"volume_edges", c.volume_edges},
           {"curved_edges", c.curved_edges},
           {"polished", c.polished},
           {"exhausted", c.exhausted},
           {"shortened", c.shortened},
           {"outside", c.outside},
           {"lost", c.lost},
           {"drawn_back", c.drawn_back},
           {"edges_per_second", c.edges_per_second},
           {"before_correction", json(c.before)}};
    if (c.by)
        j["by"] = {{"metric_kind", c.by->metric_kind},
                   {"size_share", c.by->size_share},
                   {"walls", c.by->walls},
                   {"metric", c.by->metric},
                   {"held_back", c.by->held_back}};
    if (c.expected)
        j["expected_error"] = {
            {"by_shape", c.expected->before}, {"by_solution", c.expected->after}, {"rounds", c.expected->rounds}};
    if (c.after) j["after_correction"] = json(*c.after);
    if (c.in_straight_field) j["in_straight_field"] = json(*c.in_straight_field);
    return j;
}
Json json(const ValidityReport& v) {
    return {{"bound", v.bound},
            {"bound_is_asked", v.is_asked},
            {"invalid", v.invalid},
            {"undecided", v.undecided},
            {"below_bound", v.below_bound},
            {"straight_inverted", v.straight_inverted},
            {"min_scaled_jacobian", v.smallest},
            {"worst_element", v.worst}};
}
Json json(const RelaxReport& r) {
    return {{"repair", r.repair},
            {"corrected_elements", r.corrected_elements},
            {"raised_elements", r.raised_elements},
            {"relaxed_volume_edges", r.relaxed_volume_edges},
            {"relaxed_surface_edges", r.relaxed_surface_edges},
            {"slid_surface_edges", r.slid_surface_edges},
            {"moved_vertices", r.moved_vertices},
            {"slid_vertices", r.slid_vertices},
            {"work", r.work},
            {"given_up", r.given_up}};
}
Json json(const KeptBoundaryReport& k) {
    return {{"tolerance", k.tolerance},
            {"would_do", k.would_do ? Json(*k.would_do) : Json(nullptr)},
            {"moved_nodes", k.moved_nodes},
            {"largest_shift", k.largest_shift},
            {"largest_relative_shift", k.largest_relative_shift}};
}
Json json(const std::vector<RemainingReport>& remaining) {
    Json all = Json::array();
    for (const RemainingReport& r : remaining) {
        Json left{{"element", r.element}};
        if (r.tag != 0) left["tag"] = r.tag;
        left["reason"] = r.reason;
        all.push_back(std::move(left));
    }
    return all;
}
Json json(const ReinsertReport& r) {
    return {{"sweeps", r.sweeps},
            {"rounds", r.rounds},
            {"patches", r.patches},
            {"rejected_not_valid", r.rejected_not_valid},
            {"rejected_no_gain", r.rejected_no_gain}};
}

}  // namespace

std::string deviation_json(const DeviationReport& d) {
    Json j{{"measured", d.measured},
           {"off", d.off},
           {"largest", d.largest},
           {"largest_share", d.share},
           {"tolerance", d.tolerance}};
    if (d.vertices[0] != 0) {
        j["vertices"] = Json::array();
        for (const std::size_t v : d.vertices)
            if (v != 0) j["vertices"].push_back(v);
        j["at"] = d.at;
    }
    return j.dump();
}

std::string walls_json(const WallsReport& walls) {
    Json j{
        {"crossing_pairs", walls.crossing}, {"touching_pairs", walls.touching}, {"undecided_pairs", walls.undecided}};
    if (walls.crossing > 0) j["first_crossing"] = {{"facets", {walls.first, walls.other}}, {"near", walls.first_at}};
    if (walls.crossing_before > 0) j["crossing_pairs_of_input"] = walls.crossing_before;
    if (walls.relaxed)
        j["relaxed_for_crossing"] = {{"nodes", walls.relaxed->nodes},
                                     {"largest_distance", walls.relaxed->largest},
                                     {"near", walls.relaxed->largest_at}};
    return j.dump();
}
std::string cad_json(const CadReport& cad) { return json(cad).dump(); }

std::string to_json(const Report& report) {
    Json j = report.origin ? head(*report.origin) : Json::object();
    if (report.reordered) j["reordered"] = {{"scatter", report.reordered->scatter}};
    j["mesh"] = json(report.mesh);
    if (report.solution_metric) j["solution_metric"] = Json::parse(solution_metric_json(*report.solution_metric));
    if (report.metric) j["metric"] = json(*report.metric);
    if (report.remesh) j["remesh"] = json(*report.remesh);
    if (report.boundary) j["boundary"] = json(*report.boundary);
    if (report.boundary && report.origin) j["boundary"]["geometry"] = report.origin->geometry;
    if (report.curve) j["curve"] = report.mesh.is_surface_alone() ? surface_json(*report.curve) : json(*report.curve);
    if (report.validity_before) j["validity_before_correction"] = json(*report.validity_before);
    if (report.relax) j["relax"] = json(*report.relax);
    if (report.kept_boundary) j["kept_boundary"] = json(*report.kept_boundary);
    if (report.kept_boundary || !report.remaining.empty()) j["remaining_elements"] = json(report.remaining);
    if (report.reinsert) j["reinsert"] = json(*report.reinsert);
    if (report.validity) j["validity"] = json(*report.validity);
    if (report.overlaps.overlapping > 0)
        j["overlaps"] = {{"overlapping", report.overlaps.overlapping}, {"point", report.overlaps.point}};
    if (report.transfer) j["transfer"] = Json::parse(transfer_json(*report.transfer));
    if (!report.histograms.empty()) j["histograms"] = Json::parse(histograms_json(report.histograms));
    j["invalid_elements"] = report.invalid_elements;
    j["undecided_elements"] = report.undecided_elements;
    j["elements_below_bound"] = report.elements_below_bound;
    j["committed"] = report.committed;
    j["notices"] = report.notices;
    j["misses"] = misses(report);
    j["threads"] = report.threads;
    Json stages = Json::array();
    for (const StageTime& t : report.times)
        stages.push_back({{"stage", t.stage}, {"seconds", t.seconds}, {"peak_bytes", t.peak_bytes}});
    j["stages"] = std::move(stages);
    return j.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace camber::run
