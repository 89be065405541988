// Planar models as geometries of 2D meshes.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.surface;
import :parts;

namespace camber {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

Vec<3> raised(const CadParts& parts, const Vec<2>& p) { return {{p[0], p[1], parts.of_edges.low[2]}}; }

/// Normal to the right of a tangent: outwards on a counterclockwise boundary.
Vec<2> normal_to(const Vec<2>& tangent) {
    return norm(tangent) > 0 ? normalised(Vec<2>{{tangent[1], -tangent[0]}}) : Vec<2>{};
}

bool coincide(const CadModel& model, std::size_t a, std::size_t b) {
    constexpr double same = 1e-5;
    constexpr int samples = 8;
    const CadParts& parts = model.parts();
    const double within = same * parts.edges[a].bounds.diagonal();
    if (distance(parts.edges[a].bounds.low, parts.edges[b].bounds.low) > within ||
        distance(parts.edges[a].bounds.high, parts.edges[b].bounds.high) > within)
        return false;
    const occ::EdgeFacts& facts = parts.kernel->edges[b];
    for (int i = 0; i <= samples; ++i) {
        const double t = facts.first + (facts.last - facts.first) * i / samples;
        if (closest_on_edge(model, a, vec(parts.kernel->on_curve(b, t).point)).distance > within) return false;
    }
    return true;
}

/// Returns max d(end) + d(middle) + length · sin θ, with the distance d from the edge and the angle θ between the
/// tangents of facet and edge.
double fit_error(const CadModel& model, std::size_t edge, const std::array<Vec<2>, 2>& ends) {
    const Vec<2> chord = ends[1] - ends[0];
    const CadCurveFoot foot = closest_on_curve(model, edge, midpoint(ends[0], ends[1]));
    return foot.distance + std::abs(dot(chord, foot.normal)) +
           std::max(closest_on_curve(model, edge, ends[0]).distance, closest_on_curve(model, edge, ends[1]).distance);
}

bool has_kink(const occ::Kernel& kernel, std::size_t edge) {
    constexpr double min_sine = 1e-3;
    const occ::EdgeFacts& facts = kernel.edges[edge];
    if (facts.vertices.size() != 1) return false;
    const Vec<3> first = vec(kernel.on_curve(edge, facts.first).first);
    const Vec<3> last = vec(kernel.on_curve(edge, facts.last).first);
    return dot(first, last) < 0 || norm(cross(first, last)) > min_sine * norm(first) * norm(last);
}

}  // namespace

Outcome<Done> check_flatness(const CadModel& model) {
    constexpr double flat = 1e-7;  // relative to the model's size, like OpenCASCADE's tolerance
    const CadParts& parts = model.parts();
    if (parts.edges.empty())
        return fail(ErrorKind::input, "the model has no edges for the boundary of a mesh in 2D", {}, {},
                    "export its curves, or the plane faces that they bound");
    Box<3> box = parts.bounds;
    box.include(parts.of_edges);
    if (box.high[2] - box.low[2] <= flat * box.diagonal()) return Done{};
    std::array<char, 128> heights{};
    std::snprintf(heights.data(), heights.size(), "from z = %.5g to %.5g", box.low[2], box.high[2]);
    return fail(ErrorKind::input,
                "the CAD model reaches " + std::string(heights.data()) +
                    ", but the mesh is in 2D. Its curves must lie in one plane z = constant",
                {}, {}, "export the plane faces or the curves of the section that was meshed, in the plane x, y");
}

std::vector<std::size_t> curves_of(const CadModel& model) {
    std::vector<std::size_t> curves;
    curves.reserve(model.edges());
    for (std::size_t e = 0; e < model.edges(); ++e)
        if (std::none_of(curves.begin(), curves.end(), [&](std::size_t known) { return coincide(model, known, e); }))
            curves.push_back(e);
    return curves;
}

CadCurveFoot closest_on_curve(const CadModel& model, std::size_t edge, const Vec<2>& p) {
    const CadParts& parts = model.parts();
    const Vec<3> at = raised(parts, p);
    const CadFoot foot = closest_on_edge(model, edge, at);
    const double t = foot.parameters[0];
    const Vec<2> point = in_plane(foot.point), normal = point_on_curve(model, edge, t).normal;
    // Only the distance in the plane counts. Heights within the tolerance of a plane model count as zero.
    const double away = distance(point, p);
    if (away <= 4 * rounding(parts, at)) return {p, normal, t, 0};
    return {point, normal, t, away};
}

EntityPoint<2> point_on_curve(const CadModel& model, std::size_t edge, double t) {
    const occ::CurveJet jet = model.parts().kernel->on_curve(edge, t);
    const Vec<2> tangent = in_plane(vec(jet.first));
    return {in_plane(vec(jet.point)), {tangent, {}}, normal_to(tangent)};
}

std::optional<std::size_t> nearest_curve(const CadModel& model, std::span<const std::size_t> edges, const Vec<2>& p) {
    std::optional<std::size_t> best;
    double least = infinite;
    const Vec<3> at = raised(model.parts(), p);
    for (const std::size_t edge : edges) {
        if (model.parts().edges[edge].reach.distance_squared(at) >= least * least) continue;
        const double here = closest_on_curve(model, edge, p).distance;
        if (here >= least) continue;
        least = here;
        best = edge;
    }
    return best;
}

CadFit best_curve(const CadModel& model, std::span<const std::size_t> edges, const std::array<Vec<2>, 2>& ends) {
    const Vec<3> middle = raised(model.parts(), midpoint(ends[0], ends[1]));
    CadFit best{edges.front(), infinite, infinite, infinite};
    const VirtualFaces& joined = model.parts().virtual_curves;
    for (const std::size_t edge : edges) {
        // Fit errors above twice the best one need not be exact.
        const double enough = ambiguity_ratio * best.fit_error;
        if (model.parts().edges[edge].reach.distance_squared(middle) > enough * enough) continue;
        const double here = fit_error(model, edge, ends);
        if (here < best.fit_error) {
            best.second = best.fit_error;
            if (!joined.are_joined(best.face, edge)) best.other = best.fit_error;
            best.fit_error = here;
            best.face = edge;
        } else {
            best.second = std::min(best.second, here);
            if (!joined.are_joined(best.face, edge)) best.other = std::min(best.other, here);
        }
    }
    return best;
}

std::optional<std::size_t> end_between(const CadModel& model, std::span<const std::size_t> edges, const Vec<2>& p) {
    std::optional<std::size_t> best;
    double least = infinite;
    const occ::Kernel& kernel = *model.parts().kernel;
    if (edges.size() == 1 && !has_kink(kernel, edges[0])) return best;
    for (const std::size_t edge : edges)
        for (const std::size_t vertex : kernel.edges[edge].vertices)
            if (const double d = distance(vertex_in_plane(model, vertex), p); d < least) {
                least = d;
                best = vertex;
            }
    return best;
}

Vec<2> vertex_in_plane(const CadModel& model, std::size_t vertex) { return in_plane(model.vertex(vertex)); }

namespace {

class CurvesModel final : public GeometryModel<2> {
  public:
    explicit CurvesModel(CadGeometry<2> cad)
        : cad_(std::move(cad)),
          joined_(joined_lists(cad_.association, cad_.model.edges())),
          all_(cad_.is_whole() ? curves_of(cad_.model) : cad_.met()) {}

    [[nodiscard]] SurfacePoint<2> project(const SurfaceHint& hint, const Vec<2>& p) const override {
        const auto curve = curve_of(hint, p);
        if (!curve) return {.point = p, .normal = {}};
        const auto& [there, foot, through] = closest_from(*curve, p);
        return {.point = foot.point,
                .normal = foot.normal,
                .distance = foot.distance,
                .entity = entity(there),
                .reference = hint.reference,
                .parameters = GeometryParameters{{foot.t, 0}}};
    }

    [[nodiscard]] GeometryEntity surface_at(const FacetSite<2>& facet) const override {
        return entity(curve_of(facet));
    }

    [[nodiscard]] std::optional<EntityPoint<2>> evaluate(const GeometryEntity& entity,
                                                         const GeometryParameters& parameters) const override {
        const auto curve = curve_of(entity);
        if (!curve) return std::nullopt;
        return point_on_curve(cad_.model, *curve, parameters.u[0]);
    }

    [[nodiscard]] GeometryEntity entity_at_vertex(std::span<const FacetSite<2>> around) const override {
        std::vector<std::size_t> curves;
        curves.reserve(around.size());
        for (const FacetSite<2>& facet : around) curves.push_back(curve_of(facet));
        std::sort(curves.begin(), curves.end());
        curves.erase(std::unique(curves.begin(), curves.end()), curves.end());
        if (curves.empty()) return {};
        if (curves.size() == 1) return entity(curves[0]);
        const auto& [a, b] = around.front().corners;
        const auto is_end_of = [&](const FacetSite<2>& f) { return f.corners[0] == a || f.corners[1] == a; };
        const Vec<2>& p = std::all_of(around.begin(), around.end(), is_end_of) ? a : b;
        const auto vertex = end_between(cad_.model, curves, p);
        if (!vertex) return {};
        const double reach = smooth_reach * distance(a, b);
        const bool is_joined = std::all_of(curves.begin(), curves.end(), [&](std::size_t curve) {
            return joined_[curve] != no_face && joined_[curve] == joined_[curves[0]];
        });
        if (is_joined && distance(vertex_in_plane(cad_.model, *vertex), p) > reach)
            return entity(*nearest_curve(cad_.model, curves, p));
        return {GeometryKind::corner,
                static_cast<std::int64_t>(*vertex),
                {static_cast<std::int64_t>(curves[0]), static_cast<std::int64_t>(curves[1])}};
    }

    [[nodiscard]] std::optional<Plane<2>> plane_at(const FacetSite<2>& facet) const override {
        const std::size_t curve = curve_of(facet);
        if (!facts(curve).is_line) return std::nullopt;
        const auto is_off = [&](const Vec<2>& p) {
            return closest_on_curve(cad_.model, curve, p).distance > coincidence_tolerance(cad_.model.parts());
        };
        if (joined_[curve] != no_face && std::any_of(facet.corners.begin(), facet.corners.end(), is_off))
            return std::nullopt;
        const EntityPoint<2> begin = point_on_curve(cad_.model, curve, facts(curve).first);
        return Plane<2>{begin.point, begin.normal};
    }

    [[nodiscard]] SurfacePoint<2> on_edge(const EdgeSite<2>& edge, const Vec<2>& p) const override {
        if (edge.facets.empty()) return {.point = p, .normal = {}};
        const FacetSite<2>& facet = edge.facets.front();
        return project({.facet = {}, .reference = facet.reference, .entity = surface_at(facet)}, p);
    }

    [[nodiscard]] double distance_at_facets(std::span<const FacetSite<2>> meet, const Vec<2>& p) const override {
        double largest = 0;
        for (const FacetSite<2>& facet : meet)
            largest = std::max(largest, closest_from(curve_of(facet), p).foot.distance);
        return largest;
    }

    [[nodiscard]] EntityName name_of_entity(const GeometryEntity& entity) const override {
        EntityName name = GeometryModel<2>::name_of_entity(entity);
        if (entity.kind == GeometryKind::surface) name.kind = "edge";
        return name;
    }

    [[nodiscard]] Outcome<GeometrySamples<2>> sample_all(std::size_t target_count,
                                                         const Execution& execution) const override {
        auto whole = samples_of<2>(cad_.model, target_count, execution);
        if (!whole || cad_.is_whole()) return whole;
        return part_of_samples(*whole, [&](const GeometryEntity& entity) {
            return std::binary_search(all_.begin(), all_.end(), static_cast<std::size_t>(entity.id));
        });
    }

    [[nodiscard]] bool prescribes(Reference reference) const override { return !cad_.of_reference(reference).empty(); }
    [[nodiscard]] bool prescribes_any() const override { return true; }

  private:
    [[nodiscard]] static GeometryEntity entity(std::size_t curve) {
        return GeometryEntity::surface(static_cast<std::int64_t>(curve));
    }
    [[nodiscard]] const occ::EdgeFacts& facts(std::size_t curve) const {
        return cad_.model.parts().kernel->edges[curve];
    }

    [[nodiscard]] VirtualCurveFoot closest_from(std::size_t curve, const Vec<2>& p) const {
        if (joined_[curve] == no_face) return {curve, closest_on_curve(cad_.model, curve, p)};
        return closest_on_virtual_face(cad_.model, curve, p,
                                       [&](std::size_t other) { return joined_[other] == joined_[curve]; });
    }

    [[nodiscard]] std::optional<std::size_t> curve_of(const GeometryEntity& entity) const {
        const auto number = static_cast<std::size_t>(entity.id);
        if (entity.kind != GeometryKind::surface || entity.id < 0 || number >= cad_.model.edges()) return std::nullopt;
        return number;
    }

    [[nodiscard]] std::size_t curve_of(const FacetSite<2>& facet) const {
        if (cad_.has(facet)) return cad_.association.faces[facet.id];
        const auto candidates = cad_.of_reference(facet.reference);
        if (candidates.size() == 1) return candidates.front();
        return best_curve(cad_.model, candidates.empty() ? std::span<const std::size_t>(all_) : candidates,
                          facet.corners)
            .face;
    }

    [[nodiscard]] std::optional<std::size_t> curve_of(const SurfaceHint& hint, const Vec<2>& p) const {
        if (hint.entity.kind == GeometryKind::surface) return curve_of(hint.entity);
        return nearest_curve(cad_.model, hint.reference ? cad_.of_reference(*hint.reference) : all_, p);
    }

    CadGeometry<2> cad_;
    std::vector<std::uint32_t> joined_;
    std::vector<std::size_t> all_;
};

}  // namespace

std::shared_ptr<const GeometryModel<2>> model_of(CadGeometry<2> cad) {
    return std::make_shared<const CurvesModel>(std::move(cad));
}

}  // namespace camber
