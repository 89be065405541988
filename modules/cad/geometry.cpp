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
import camber.surface;
import :parts;

namespace camber {

namespace {

std::size_t index(std::int64_t number) { return static_cast<std::size_t>(number); }

/// The corner that all facets have.
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
    explicit CadGeometryModel(CadGeometry<3> cad) : cad_(std::move(cad)) {
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
        const CadFoot foot = closest_on_face(cad_.model, *face, p);
        return {.point = foot.point,
                .normal = foot.normal,
                .distance = foot.distance,
                .entity = GeometryEntity::surface(static_cast<std::int64_t>(*face)),
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

    [[nodiscard]] std::array<double, 2> periods(const GeometryEntity& entity) const override {
        const occ::Kernel& kernel = *cad_.model.parts().kernel;
        if (is_number(entity, GeometryKind::surface, kernel.faces.size())) return kernel.faces[index(entity.id)].period;
        if (is_number(entity, GeometryKind::curve, kernel.edges.size()))
            return {kernel.edges[index(entity.id)].period, 0};
        return {0, 0};
    }

    [[nodiscard]] GeometryEntity entity_at_edge(const EdgeSite<3>& edge) const override {
        const auto faces = faces_of(edge.facets);
        if (faces.empty()) return {};
        const std::array points{edge.ends[0], edge.ends[1]};
        if (faces.size() > 1) return curve_of(faces, points);
        // A single facet is at the rim of an open model, or of the part of the boundary that is on it.
        return edge.facets.size() > 1 ? surface(faces[0]) : rim_of(faces, points);
    }

    [[nodiscard]] GeometryEntity entity_at_vertex(std::span<const FacetSite<3>> around) const override {
        const auto faces = faces_of(around);
        if (faces.empty()) return {};
        if (faces.size() == 1) return surface(faces[0]);
        const auto p = common_corner(around);
        if (!p) return {};
        if (faces.size() == 2) return curve_of(faces, std::span(&*p, 1));
        const auto vertex = vertex_between(cad_.model, faces, *p);
        if (!vertex) return {};
        return {GeometryKind::corner,
                static_cast<std::int64_t>(*vertex),
                {GeometryEntity::unnumbered, GeometryEntity::unnumbered}};
    }

    [[nodiscard]] std::optional<Plane<3>> plane_at(const FacetSite<3>& facet) const override {
        const std::size_t face = face_of(facet);
        if (!cad_.model.parts().kernel->faces[face].is_plane) return std::nullopt;
        const EntityPoint<3> origin = point_on_face(cad_.model, face, {0, 0});
        return Plane<3>{origin.point, origin.normal};
    }

    [[nodiscard]] SurfacePoint<3> on_edge(const EdgeSite<3>& edge, const Vec<3>& p) const override {
        const GeometryEntity entity = entity_at_edge(edge);
        if (entity.kind == GeometryKind::none) return {.point = p, .normal = {}};
        if (entity.kind == GeometryKind::surface)
            return project({.facet = {}, .reference = edge.facets.front().reference, .entity = entity}, p);
        const CadFoot foot = closest_on_edge(cad_.model, index(entity.id), p);
        return {.point = foot.point,
                .normal = {},
                .distance = foot.distance,
                .entity = entity,
                .parameters = GeometryParameters{foot.parameters}};
    }

    [[nodiscard]] double distance_where(std::span<const FacetSite<3>> meet, const Vec<3>& p) const override {
        double largest = 0;
        for (const std::size_t face : faces_of(meet))
            largest = std::max(largest, closest_on_face(cad_.model, face, p).distance);
        return largest;
    }

    [[nodiscard]] EntityName called(const GeometryEntity& entity) const override {
        EntityName name = GeometryModel<3>::called(entity);
        if (entity.kind == GeometryKind::surface) name.kind = "face";
        if (entity.kind == GeometryKind::curve) name.kind = "edge";
        return name;
    }

    /// Of a part of the boundary those of faces that it met, and of their edges.
    [[nodiscard]] Outcome<GeometrySamples<3>> own_samples(std::size_t wanted,
                                                          const Execution& execution) const override {
        auto whole = samples_of<3>(cad_.model, wanted, execution);
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

    /// The edge at which a face ends, where that is near; else the face.
    [[nodiscard]] GeometryEntity rim_of(const std::vector<std::size_t>& faces,
                                        const std::array<Vec<3>, 2>& ends) const {
        const GeometryEntity rim = curve_of(faces, ends);
        if (rim.kind != GeometryKind::curve) return rim;
        for (const Vec<3>& p : ends)
            if (closest_on_edge(cad_.model, index(rim.id), p).distance > near_enough * distance(ends[0], ends[1]))
                return surface(faces[0]);
        return rim;
    }

    /// The edge between faces; where they have none in common, the first face.
    [[nodiscard]] GeometryEntity curve_of(const std::vector<std::size_t>& faces, std::span<const Vec<3>> points) const {
        const auto edge = edge_between(cad_.model, faces, points);
        if (!edge) return surface(faces[0]);
        const auto side = [&](std::size_t i) {
            return i < faces.size() ? static_cast<std::int64_t>(faces[i]) : GeometryEntity::unnumbered;
        };
        return {GeometryKind::curve, static_cast<std::int64_t>(*edge), {side(0), side(1)}};
    }

    [[nodiscard]] std::span<const std::size_t> faces_of(Reference reference) const {
        return cad_.of_reference(reference);
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
    std::vector<std::size_t> all_;
};

}  // namespace

std::shared_ptr<const GeometryModel<3>> model_of(CadGeometry<3> cad) {
    return std::make_shared<const CadGeometryModel>(std::move(cad));
}

}  // namespace camber
