// Samples of a model; a geometry of 3D meshes from a model and its association.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>
#include "occ/kernel.hpp"
module camber.cad;
import camber.core;
import camber.bezier;
import camber.surface;
import :parts;

namespace camber {

namespace {

struct Samples {
    std::vector<Vec<3>> points;
    std::vector<double> weights;
};

double middle_of(double low, double high, std::size_t i, std::size_t n) {
    return low + (high - low) * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
}

Samples grid_on_face(const CadModel& model, std::size_t face, std::size_t n, std::size_t m) {
    const occ::Kernel& kernel = *model.parts().kernel;
    const occ::FaceFacts& facts = kernel.faces[face];
    const double cell = (facts.high[0] - facts.low[0]) / static_cast<double>(n) * (facts.high[1] - facts.low[1]) /
                        static_cast<double>(m);
    Samples out;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < m; ++j) {
            const double u = middle_of(facts.low[0], facts.high[0], i, n);
            const double v = middle_of(facts.low[1], facts.high[1], j, m);
            if (!kernel.has(face, u, v)) continue;
            const occ::SurfaceJet jet = kernel.on_surface(face, u, v);
            out.points.push_back(vec(jet.point));
            out.weights.push_back(norm(cross(vec(jet.u), vec(jet.v))) * cell);
        }
    return out;
}

double area_of(const Samples& samples) {
    double area = 0;
    for (const double weight : samples.weights) area += weight;
    return area;
}

std::array<double, 2> extents_of(const CadModel& model, std::size_t face) {
    constexpr std::size_t lines = 3, pieces = 16;
    const occ::Kernel& kernel = *model.parts().kernel;
    const occ::FaceFacts& facts = kernel.faces[face];
    std::array<double, 2> longest{};
    for (std::size_t k = 0; k < 2; ++k)
        for (std::size_t line = 0; line < lines; ++line) {
            double length = 0;
            for (std::size_t i = 0; i < pieces; ++i) {
                std::array<double, 2> uv{};
                uv[k] = middle_of(facts.low[k], facts.high[k], i, pieces);
                uv[1 - k] = middle_of(facts.low[1 - k], facts.high[1 - k], line, lines);
                const occ::SurfaceJet jet = kernel.on_surface(face, uv[0], uv[1]);
                length += norm(vec(k == 0 ? jet.u : jet.v)) * (facts.high[k] - facts.low[k]) / pieces;
            }
            longest[k] = std::max(longest[k], length);
        }
    return longest;
}

std::size_t parts_of(double length, double step, std::size_t least, std::size_t most) {
    if (!(step > 0) || !(length > 0)) return least;
    return static_cast<std::size_t>(
        std::clamp(std::ceil(length / step), static_cast<double>(least), static_cast<double>(most)));
}

Samples of_face(const CadModel& model, std::size_t face, double step) {
    constexpr std::size_t least = 6, most = 1024, finer = 8, finest = 512;
    const auto extents = extents_of(model, face);
    const std::size_t n = parts_of(extents[0], step, least, most), m = parts_of(extents[1], step, least, most);
    Samples samples = grid_on_face(model, face, n, m);
    if (!samples.points.empty()) return samples;
    // A narrow or broken face may contain no grid point. Its grid is refined, up to about the cost of other faces'
    // grids.
    return grid_on_face(model, face, std::min(finer * n, finest), std::min(finer * m, finest));
}

Samples of_edge(const CadModel& model, std::size_t edge, double step) {
    constexpr std::size_t least = 16, most = 65536;
    const occ::Kernel& kernel = *model.parts().kernel;
    const occ::EdgeFacts& facts = kernel.edges[edge];
    const auto at = [&](std::size_t n, std::size_t i, Samples& out) {
        const occ::CurveJet jet = kernel.on_curve(edge, middle_of(facts.first, facts.last, i, n));
        out.points.push_back(vec(jet.point));
        out.weights.push_back(norm(vec(jet.first)) * (facts.last - facts.first) / static_cast<double>(n));
    };
    Samples few;
    for (std::size_t i = 0; i < least; ++i) at(least, i, few);
    const std::size_t n = parts_of(area_of(few), step, least, most);
    Samples out;
    for (std::size_t i = 0; i < n; ++i) at(n, i, out);
    return out;
}

void append(GeometrySamples<3>& to, const GeometryEntity& entity, const Samples& samples) {
    if (samples.points.empty()) return;
    to.begin(entity);
    for (std::size_t i = 0; i < samples.points.size(); ++i) to.add(samples.points[i], samples.weights[i]);
}

GeometryEntity curve(const occ::EdgeFacts& facts, std::size_t edge) {
    std::array<std::int64_t, 2> sides{GeometryEntity::unnumbered, GeometryEntity::unnumbered};
    for (std::size_t i = 0; i < 2 && i < facts.faces.size(); ++i) sides[i] = static_cast<std::int64_t>(facts.faces[i]);
    if (sides[1] != GeometryEntity::unnumbered && sides[1] < sides[0]) std::swap(sides[0], sides[1]);
    return {GeometryKind::curve, static_cast<std::int64_t>(edge), sides};
}

}  // namespace

template <>
Outcome<GeometrySamples<2>> samples_of<2>(const CadModel& model, std::size_t target_count, const Execution& execution) {
    constexpr double coarse = 0;  // step 0 gives the minimum number of points per curve, enough to estimate its length
    return guarded([&]() -> Outcome<GeometrySamples<2>> {
        const std::vector<std::size_t> curves = curves_of(model);
        double length = 0;
        for (const std::size_t e : curves) length += area_of(of_edge(model, e, coarse));
        const double step = length / static_cast<double>(std::max<std::size_t>(target_count, 1));
        const auto found = map_each(
            without_progress(execution), curves.size(), [&](std::size_t i) { return of_edge(model, curves[i], step); },
            1);
        if (!found) return fail(found.error());
        GeometrySamples<2> samples;
        for (std::size_t i = 0; i < curves.size(); ++i) {
            samples.begin(GeometryEntity::surface(static_cast<std::int64_t>(curves[i])));
            const auto& [points, weights] = (*found)[i];
            for (std::size_t k = 0; k < points.size(); ++k) samples.add(in_plane(points[k]), weights[k]);
        }
        return samples;
    });
}

template <>
Outcome<GeometrySamples<3>> samples_of<3>(const CadModel& model, std::size_t target_count, const Execution& execution) {
    constexpr std::size_t coarse = 16, closer_on_edges = 2;
    const occ::Kernel& kernel = *model.parts().kernel;
    return guarded([&]() -> Outcome<GeometrySamples<3>> {
        const auto areas = map_each(
            without_progress(execution), kernel.faces.size(),
            [&](std::size_t f) { return area_of(grid_on_face(model, f, coarse, coarse)); }, 1);
        if (!areas) return fail(areas.error());
        double area = 0;
        for (const double a : *areas) area += a;
        const double step = std::sqrt(area / static_cast<double>(std::max<std::size_t>(target_count, 1)));
        std::vector<Samples> faces(kernel.faces.size()), edges(kernel.edges.size());
        auto done = each(
            without_progress(execution), faces.size(), [&](std::size_t f) { faces[f] = of_face(model, f, step); }, 1);
        if (!done) return fail(done.error());
        done = each(
            without_progress(execution), edges.size(),
            [&](std::size_t e) { edges[e] = of_edge(model, e, step / closer_on_edges); }, 1);
        if (!done) return fail(done.error());
        GeometrySamples<3> samples;
        for (std::size_t f = 0; f < faces.size(); ++f)
            append(samples, GeometryEntity::surface(static_cast<std::int64_t>(f)), faces[f]);
        for (std::size_t e = 0; e < edges.size(); ++e) append(samples, curve(kernel.edges[e], e), edges[e]);
        return samples;
    });
}

namespace {

std::size_t index(std::int64_t number) { return static_cast<std::size_t>(number); }

std::optional<Vec<3>> common_corner(std::span<const FacetSite<3>> facets) {
    for (const Vec<3>& p : facets.front().corners) {
        const auto has = [&](const FacetSite<3>& f) {
            return std::find(f.corners.begin(), f.corners.end(), p) != f.corners.end();
        };
        if (facets.size() > 1 && std::all_of(facets.begin(), facets.end(), has)) return p;
    }
    return std::nullopt;
}

class CadGeometryModel final : public GeometryModel<3> {
  public:
    explicit CadGeometryModel(CadGeometry<3> cad)
        : cad_(std::move(cad)), joined_(joined_lists(cad_.association, cad_.model.faces())) {
        if (cad_.is_whole()) {
            all_.resize(cad_.model.faces());
            std::iota(all_.begin(), all_.end(), std::size_t{0});
        } else {
            all_ = cad_.met();
        }
    }

    [[nodiscard]] SurfacePoint<3> project(const SurfaceHint& hint, const Vec<3>& p) const override {
        const auto face = face_of(hint, p);
        if (!face) return {.point = p, .normal = {}};
        const auto& [there, foot, through] = closest_from(*face, p);
        return {.point = foot.point,
                .normal = foot.normal,
                .distance = foot.distance,
                .entity = surface(there),
                .reference = hint.reference,
                .parameters = GeometryParameters{foot.parameters}};
    }

    [[nodiscard]] GeometryEntity surface_at(const FacetSite<3>& facet) const override {
        return GeometryEntity::surface(static_cast<std::int64_t>(face_of(facet)));
    }

    [[nodiscard]] std::optional<EntityPoint<3>> evaluate(const GeometryEntity& entity,
                                                         const GeometryParameters& parameters) const override {
        if (is_number(entity, GeometryKind::surface, cad_.model.faces()))
            return point_on_face(cad_.model, index(entity.id), parameters.u);
        if (is_number(entity, GeometryKind::curve, cad_.model.edges()))
            return point_on_edge(cad_.model, index(entity.id), parameters.u[0]);
        return std::nullopt;
    }

    [[nodiscard]] GeometryEntity entity_at_edge(const EdgeSite<3>& edge) const override {
        return place_of_edge(edge).entity;
    }

    [[nodiscard]] GeometryEntity entity_at_vertex(std::span<const FacetSite<3>> around) const override {
        const auto faces = faces_of(around);
        if (faces.empty()) return {};
        if (faces.size() == 1) return surface(faces[0]);
        const auto p = common_corner(around);
        if (!p) return {};
        const Junction at = junction_at_vertex(cad_.model, faces, *p, reach_at(around));
        if (at.on == Junction::On::vertex)
            return {GeometryKind::corner,
                    static_cast<std::int64_t>(at.number),
                    {GeometryEntity::unnumbered, GeometryEntity::unnumbered}};
        return faces.size() > 2 && at.on == Junction::On::nothing ? GeometryEntity{} : entity_of(at, faces);
    }

    [[nodiscard]] std::optional<Plane<3>> plane_at(const FacetSite<3>& facet) const override {
        const std::size_t face = face_of(facet);
        if (!cad_.model.parts().kernel->faces[face].is_plane) return std::nullopt;
        // A facet that spans several faces is not planar, even if its associated face is.
        const auto is_off = [&](const Vec<3>& p) {
            return closest_on_face(cad_.model, face, p).distance > coincidence_tolerance(cad_.model.parts());
        };
        if (joined_[face] != no_face && std::any_of(facet.corners.begin(), facet.corners.end(), is_off))
            return std::nullopt;
        const EntityPoint<3> origin = point_on_face(cad_.model, face, {0, 0});
        return Plane<3>{origin.point, origin.normal};
    }

    [[nodiscard]] SurfacePoint<3> on_edge(const EdgeSite<3>& edge, const Vec<3>& p) const override {
        const auto& [entity, chain] = place_of_edge(edge);
        if (entity.kind == GeometryKind::none) return {.point = p, .normal = {}};
        if (entity.kind == GeometryKind::surface)
            return project({.facet = {}, .reference = edge.facets.front().reference, .entity = entity}, p);
        GeometryEntity there = entity;
        if (!chain.empty())
            there.id = static_cast<std::int64_t>(chain_edge(cad_.model, chain, p).value_or(index(entity.id)));
        const CadFoot foot = closest_on_edge(cad_.model, index(there.id), p);
        return {.point = foot.point,
                .normal = {},
                .distance = foot.distance,
                .entity = there,
                .parameters = GeometryParameters{foot.parameters}};
    }

    [[nodiscard]] bool distances(const FacetSite<3>& facet, std::span<const Barycentric<2>>,
                                 std::span<const Vec<3>> points, std::span<double> out) const override {
        if (const std::size_t face = face_of(facet); joined_[face] != no_face) {
            for (std::size_t i = 0; i < points.size(); ++i) out[i] = closest_from(face, points[i]).foot.distance;
            return true;
        }
        FaceDistances walk = walk_from(facet);
        for (std::size_t i = 0; i < points.size(); ++i) out[i] = walk.distance(points[i]);
        return true;
    }

    [[nodiscard]] std::optional<LargestDistance> largest_distance(const FacetSite<3>& facet,
                                                                  std::span<const Barycentric<2>>,
                                                                  std::span<const Vec<3>> points,
                                                                  double bound) const override {
        double largest = bound;
        if (const std::size_t face = face_of(facet); joined_[face] != no_face) {
            for (const Vec<3>& p : points) largest = std::max(largest, closest_from(face, p).foot.distance);
            return LargestDistance{largest, points.size()};
        }
        FaceDistances walk = walk_from(facet);
        for (const Vec<3>& p : points)
            if (const auto beyond = walk.distance_beyond(largest, p)) largest = *beyond;
        return LargestDistance{largest, walk.searches()};
    }

    [[nodiscard]] bool are_within(const FacetSite<3>& facet, std::span<const Vec<3>> points,
                                  std::span<const double> bounds) const override {
        const std::size_t face = face_of(facet);
        FaceDistances walk(cad_.model, face, nullptr);
        for (std::size_t i = 0; i < points.size(); ++i)
            if (joined_[face] != no_face ? closest_from(face, points[i]).foot.distance > bounds[i]
                                         : walk.distance_beyond(bounds[i], points[i]).has_value())
                return false;
        return true;
    }

    [[nodiscard]] bool is_one_surface(Reference reference) const override { return faces_of(reference).size() == 1; }

    [[nodiscard]] double distance_at_facets(std::span<const FacetSite<3>> meet, const Vec<3>& p) const override {
        double largest = 0;
        for (const std::size_t face : faces_of(meet)) largest = std::max(largest, closest_from(face, p).foot.distance);
        return largest;
    }

    [[nodiscard]] EntityName name_of_entity(const GeometryEntity& entity) const override {
        EntityName name = GeometryModel<3>::name_of_entity(entity);
        if (entity.kind == GeometryKind::surface) name.kind = "face";
        if (entity.kind == GeometryKind::curve) name.kind = "edge";
        return name;
    }

    [[nodiscard]] Outcome<GeometrySamples<3>> sample_all(std::size_t target_count,
                                                         const Execution& execution) const override {
        auto whole = samples_of<3>(cad_.model, target_count, execution);
        if (!whole || cad_.is_whole()) return whole;
        return part_of_samples(*whole, [&](const GeometryEntity& entity) { return is_met(entity); });
    }

    [[nodiscard]] bool prescribes(Reference reference) const override { return !faces_of(reference).empty(); }
    [[nodiscard]] bool prescribes_any() const override { return true; }

  private:
    [[nodiscard]] static GeometryEntity surface(std::size_t face) {
        return GeometryEntity::surface(static_cast<std::int64_t>(face));
    }
    [[nodiscard]] static bool is_number(const GeometryEntity& entity, GeometryKind kind, std::size_t count) {
        return entity.kind == kind && entity.id >= 0 && index(entity.id) < count;
    }

    [[nodiscard]] bool is_met(const GeometryEntity& entity) const {
        const auto is_face_met = [&](std::size_t face) { return std::binary_search(all_.begin(), all_.end(), face); };
        if (entity.kind == GeometryKind::surface) return is_face_met(index(entity.id));
        const auto& faces = cad_.model.parts().kernel->edges[index(entity.id)].faces;
        return std::any_of(faces.begin(), faces.end(), is_face_met);
    }

    [[nodiscard]] static Reach reach_at(std::span<const FacetSite<3>> around) {
        const auto& first = around.front().corners;
        double shortest = distance(first[0], first[1]);
        for (const FacetSite<3>& facet : around)
            for (std::size_t i = 0; i < 3; ++i)
                shortest = std::min(shortest, distance(facet.corners[i], facet.corners[(i + 1) % 3]));
        return {match_tolerance * distance(first[0], first[1]), smooth_reach * shortest};
    }

    /// Model entity of a mesh edge. `chain`: the faces at the edge if it is on a chain of model edges.
    struct EdgePlace {
        GeometryEntity entity;
        std::vector<std::size_t> chain = {};
    };
    [[nodiscard]] EdgePlace place_of_edge(const EdgeSite<3>& edge) const {
        const auto faces = faces_of(edge.facets);
        if (faces.empty()) return {};
        const std::array points{edge.ends[0], edge.ends[1]};
        if (faces.size() > 1) {
            const Reach reach = reach_along(points);
            const Junction at = junction_at(cad_.model, faces, points, reach);
            if (at.on == Junction::On::edge && at.distance <= reach.ridge)
                return {curve(at.number, faces), at.is_chain ? faces : std::vector<std::size_t>{}};
            // A mesh edge that follows no edge of the model is on the closest face.
            return {surface(at.on == Junction::On::face ? at.number : *nearest_face(cad_.model, faces, edge.middle()))};
        }
        // A mesh edge with a single facet is at the rim of an open model, or of the part of the boundary on the model.
        return {edge.facets.size() > 1 ? surface(faces[0]) : rim_of(faces, points)};
    }

    [[nodiscard]] GeometryEntity rim_of(const std::vector<std::size_t>& faces,
                                        const std::array<Vec<3>, 2>& ends) const {
        const GeometryEntity rim = curve_of(faces, ends);
        if (rim.kind != GeometryKind::curve) return rim;
        for (const Vec<3>& p : ends)
            if (closest_on_edge(cad_.model, index(rim.id), p).distance > match_tolerance * distance(ends[0], ends[1]))
                return surface(faces[0]);
        return rim;
    }

    [[nodiscard]] GeometryEntity curve_of(const std::vector<std::size_t>& faces, std::span<const Vec<3>> points) const {
        const auto edge = edge_between(cad_.model, faces, points);
        return edge ? curve(*edge, faces) : surface(faces[0]);
    }
    [[nodiscard]] static GeometryEntity curve(std::size_t edge, const std::vector<std::size_t>& faces) {
        const auto side = [&](std::size_t i) {
            return i < faces.size() ? static_cast<std::int64_t>(faces[i]) : GeometryEntity::unnumbered;
        };
        return {GeometryKind::curve, static_cast<std::int64_t>(edge), {side(0), side(1)}};
    }
    [[nodiscard]] static GeometryEntity entity_of(const Junction& at, const std::vector<std::size_t>& faces) {
        if (at.on == Junction::On::edge) return curve(at.number, faces);
        return surface(at.on == Junction::On::face ? at.number : faces[0]);
    }

    [[nodiscard]] VirtualFoot closest_from(std::size_t face, const Vec<3>& p) const {
        if (joined_[face] == no_face) return {face, closest_on_face(cad_.model, face, p)};
        return closest_on_virtual_face(cad_.model, face, p,
                                       [&](std::size_t other) { return joined_[other] == joined_[face]; });
    }

    [[nodiscard]] std::span<const std::size_t> faces_of(Reference reference) const {
        return cad_.of_reference(reference);
    }

    [[nodiscard]] FaceDistances walk_from(const FacetSite<3>& facet) const {
        const bool is_known = cad_.has(facet) && facet.id.index() < cad_.association.middles.size();
        return {cad_.model, face_of(facet), is_known ? &cad_.association.middles[facet.id.index()] : nullptr};
    }

    [[nodiscard]] std::size_t face_of(const FacetSite<3>& facet) const {
        if (cad_.has(facet)) return cad_.association.faces[facet.id];
        const auto candidates = faces_of(facet.reference);
        if (candidates.size() == 1) return candidates.front();
        return best_face(cad_.model, candidates.empty() ? std::span<const std::size_t>(all_) : candidates,
                         facet.corners)
            .face;
    }

    [[nodiscard]] std::optional<std::size_t> face_of(const SurfaceHint& hint, const Vec<3>& p) const {
        if (hint.entity.kind == GeometryKind::surface)
            return is_number(hint.entity, GeometryKind::surface, cad_.model.faces())
                       ? std::optional(index(hint.entity.id))
                       : std::nullopt;
        if (!hint.reference) return nearest_face(cad_.model, all_, p);
        return nearest_face(cad_.model, faces_of(*hint.reference), p);
    }

    [[nodiscard]] std::vector<std::size_t> faces_of(std::span<const FacetSite<3>> facets) const {
        std::vector<std::size_t> faces;
        faces.reserve(facets.size());
        for (const FacetSite<3>& facet : facets) faces.push_back(face_of(facet));
        std::sort(faces.begin(), faces.end());
        faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
        return faces;
    }

    CadGeometry<3> cad_;
    std::vector<std::uint32_t> joined_;
    std::vector<std::size_t> all_;
};

}  // namespace

std::shared_ptr<const GeometryModel<3>> model_of(CadGeometry<3> cad) {
    return std::make_shared<const CadGeometryModel>(std::move(cad));
}

}  // namespace camber
