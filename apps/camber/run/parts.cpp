module;
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
module camber.run;
import camber.core;
import camber.repair;
import camber.validity;
import :parts;
import :report;

namespace camber::run {

namespace {

void add_up(std::optional<RelaxReport>& sum, const RelaxReport& part) {
    if (!sum) sum.emplace();
    sum->repair = part.repair;
    sum->corrected_elements += part.corrected_elements;
    sum->relaxed_volume_edges += part.relaxed_volume_edges;
    sum->relaxed_surface_edges += part.relaxed_surface_edges;
    sum->slid_surface_edges += part.slid_surface_edges;
    sum->slid_vertices += part.slid_vertices;
    sum->moved_vertices += part.moved_vertices;
    sum->work += part.work;
    sum->given_up += part.given_up;
}

void add_up(PassReport& sum, const PassReport& part) {
    sum.rounds += part.rounds;
    sum.proposals += part.proposals;
    sum.planned += part.planned;
    sum.accepted += part.accepted;
    sum.corrections += part.corrections;
    sum.shortened += part.shortened;
    sum.drawn_back += part.drawn_back;
    sum.programmes += part.programmes;
    sum.moved_nodes += part.moved_nodes;
    sum.straight_inverted += part.straight_inverted;
    sum.straight_positive += part.straight_positive;
    sum.farthest_facet = std::max(sum.farthest_facet, part.farthest_facet);
    sum.seconds += part.seconds;
    for (const auto& [reason, count] : part.rejected) {
        const auto there = std::ranges::find_if(sum.rejected, [&](const auto& r) { return r.first == reason; });
        if (there == sum.rejected.end())
            sum.rejected.emplace_back(reason, count);
        else
            there->second += count;
    }
}

}  // namespace

RelaxReport relax_report(const RepairStatistics& s, std::size_t given_up, RepairMethod method) {
    return {std::string(word_of(method)),
            s.corrected_elements,
            s.moved_volume_nodes,
            s.moved_surface_nodes,
            s.moved_vertices,
            0,
            0,
            s.work,
            given_up};
}

template <int D>
VerdictsReport verdicts_report(const Validation<D>& v, bool is_asked) {
    VerdictsReport part;
    auto next = v.not_positive.begin();
    for (std::size_t e = 0; e < v.verdicts.size(); ++e) {
        if (next != v.not_positive.end() && next->first == ElementId(e))
            (next++->second == Verdict::invalid ? part.invalid : part.undecided).push_back(e + 1);
        else if (v.verdicts[e] != Verdict::valid)
            part.below_bound.push_back(e + 1);
    }
    part.summary = {v.bound,
                    is_asked,
                    part.invalid.size(),
                    part.undecided.size(),
                    part.below_bound.size(),
                    v.straight_inverted,
                    v.smallest,
                    v.worst.valid() ? v.worst.index() + 1 : 0};
    return part;
}
#define CAMBER_INSTANTIATE(D) template VerdictsReport verdicts_report<D>(const Validation<D>&, bool);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

void add(Report& report, const Notices& notices) {
    report.notices.insert(report.notices.end(), notices.begin(), notices.end());
}

void add(Report& report, const OverlappingReport& part) { report.overlaps = part; }

void add(Report& report, const MetricReport& part) { report.metric = part; }
void add(Report& report, const BoundaryNodesReport& part) { report.boundary->nodes = part; }
void add(Report& report, const CurveReport& part) { report.curve = part; }
void add(Report& report, const MeshReport& part) { report.mesh = part; }
void add(Report& report, const BeforeReport& part) { report.validity_before = part.summary; }
void add(Report& report, const CommitReport&) { report.committed = true; }

void add(Report& report, const BoundaryReport& part) {
    report.boundary = part;
    if (part.cad && !part.cad->within_materials.empty())
        report.notices.push_back(fmt::format(
            "reference{} {}: the facets lie within one material and not on the CAD model; they have no CAD "
            "geometry",
            part.cad->within_materials.size() == 1 ? "" : "s", fmt::join(part.cad->within_materials, ", ")));
    if (!part.off_surfaces || part.off_surfaces->vertices == 0) return;
    const OffSurfacesReport& off = *part.off_surfaces;
    report.notices.push_back(fmt::format(
        "{} {} not on the analytic surface of their reference, by up to {:.4g}: kept there, while the nodes "
        "beside them go onto the surface",
        off.vertices, off.vertices == 1 ? "vertex is" : "vertices are", off.largest));
}

void add(Report& report, const PlanReport& part) {
    if (report.committed && part.is_mesh) return;
    report.notices.emplace_back("planned nodes were not committed: no stage \"commit\" after them");
}

void add(Report& report, const VerdictsReport& part) {
    report.validity = part.summary;
    report.invalid_elements = part.invalid;
    report.undecided_elements = part.undecided;
    report.elements_below_bound = part.below_bound;
}

void add(Report& report, const CorrectionReport& part) {
    add_up(report.relax, part.relax);
    if (part.kept_boundary) report.kept_boundary = part.kept_boundary;
    report.remaining = part.remaining;
}

void add(Report& report, const CavitiesReport& part) {
    report.validity_before = part.wanted;
    report.relax = part.relax;
    report.reinsert = part.reinsert;
}

void add(Report& report, const BeginsChangingReport& part) { report.remesh = RemeshReport{part.unit_mesh, {}, {}, {}}; }

void add(Report& report, const PassReport& part) {
    auto& passes = report.remesh->passes;
    const auto same = std::ranges::find(passes, part.pass, &PassReport::pass);
    if (same == passes.end())
        passes.push_back(part);
    else
        add_up(*same, part);
}

void add(Report& report, const FinishedNodesReport& part) { report.remesh->nodes = part.nodes; }

void add(Report& report, const FinishedReport& part) {
    report.remesh->after = part.unit_mesh;
    report.histograms.insert(report.histograms.end(), part.histograms.begin(), part.histograms.end());
}

void add(Report& report, const MeasuresReport& part) {
    if (report.curve) {
        report.curve->after = part.edges;
        report.curve->in_straight_field = part.edges_in_straight_field;
    }
    if (report.boundary) {
        report.boundary->straight_distance = part.straight_distance;
        report.boundary->curved_distance = part.curved_distance;
        report.boundary->node_deviation = part.node_deviation;
        report.boundary->vertex_deviation = part.vertex_deviation;
        report.boundary->walls = part.walls;
        report.boundary->distances = part.distances;
        report.boundary->geometry_error = part.geometry_error;
        if (auto& cad = report.boundary->cad) {
            cad->largest_node_distance =
                part.node_deviation ? std::optional(part.node_deviation->largest) : std::nullopt;
            if (part.is_remeshed && part.vertex_deviation)
                cad->largest_vertex_distance = part.vertex_deviation->largest;
        }
    }
    report.histograms.insert(report.histograms.end(), part.histograms.begin(), part.histograms.end());
}

}  // namespace camber::run
