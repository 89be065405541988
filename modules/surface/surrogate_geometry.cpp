// The surrogate as a geometry model.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.surface;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

template <int D>
bool is_own_edge(const Surrogate<D>& surrogate, std::size_t row, const EdgeSite<D>& edge) {
    if (row == surrogate.edges.size()) return false;
    const auto& c = surrogate.edge_curves[row].curve.control;
    return c.front() == edge.ends[0] && c.back() == edge.ends[1];
}

template <int D>
bool is_own_facet(const Surrogate<D>& surrogate, const FacetSite<D>& facet) {
    if (facet.id.index() >= surrogate.facets.size()) return false;
    const auto& cubic = surrogate.facets[facet.id];
    for (std::size_t i = 0; i < D; ++i) {
        MultiIndex<D - 1> alpha{};
        alpha[i] = 3;
        if (cubic.at(alpha) != facet.corners[i]) return false;
    }
    return true;
}

template <int D>
Vec<D> centroid_of(const FacetSite<D>& facet) {
    Vec<D> sum = facet.corners[0];
    for (std::size_t i = 1; i < D; ++i) sum += facet.corners[i];
    return sum / D;
}

template <int D>
GeometryParameters parameters_at(const SurrogateFoot<D>& foot) {
    GeometryParameters parameters{{foot.xi[1], 0}, static_cast<std::uint32_t>(foot.facet.index())};
    if constexpr (D == 3) parameters.u[1] = foot.xi[2];
    return parameters;
}

template <int D>
class SurrogateModel : public GeometryModel<D> {
  public:
    explicit SurrogateModel(Surrogate<D> surrogate) : surrogate_(std::move(surrogate)) {
        references_.assign(surrogate_.references.begin(), surrogate_.references.end());
        std::ranges::sort(references_);
        references_.erase(std::ranges::unique(references_).begin(), references_.end());
    }

    [[nodiscard]] SurfacePoint<D> project(const SurfaceHint& hint, const Vec<D>& p) const override {
        const auto admitted = [&](FacetId f) {
            if (hint.entity.kind == GeometryKind::surface) return surrogate_.patches[f] == hint.entity.id;
            return !hint.reference || surrogate_.references[f] == *hint.reference;
        };
        const auto foot = hint.facet.index() < surrogate_.facets.size() ? closest_near(surrogate_, hint.facet, p)
                                                                        : closest_among(surrogate_, p, admitted);
        if (!foot.facet.valid()) return {.point = p, .normal = {}};
        return {.point = foot.point,
                .normal = normal_at<D>(surrogate_.facets[foot.facet], foot.xi),
                .distance = std::sqrt(foot.distance_squared),
                .facet = foot.facet,
                .entity = patch_of(foot.facet),
                .reference = surrogate_.references[foot.facet],
                .parameters = parameters_at(foot)};
    }

    [[nodiscard]] GeometryEntity surface_at(const FacetSite<D>& facet) const override {
        if (is_own_facet(surrogate_, facet)) return patch_of(facet.id);
        const auto foot = closest_of_reference(facet.reference, centroid_of(facet));
        return foot.facet.valid() ? patch_of(foot.facet) : GeometryEntity{};
    }

    [[nodiscard]] bool has_surface_at(const FacetSite<D>& facet) const override {
        return is_own_facet(surrogate_, facet) || has_reference(facet.reference);
    }

    [[nodiscard]] std::optional<EntityPoint<D>> evaluate(const GeometryEntity& entity,
                                                         const GeometryParameters& parameters) const override {
        const auto& [u, piece] = parameters;
        if (entity.kind == GeometryKind::curve) {
            if (piece >= surrogate_.edges.size()) return std::nullopt;
            const auto here = expand(surrogate_.edge_curves[piece].curve, Barycentric<1>{1 - u[0], u[0]});
            return EntityPoint<D>{here.point, {here.first[0]}, {}};
        }
        if (entity.kind != GeometryKind::surface || piece >= surrogate_.facets.size()) return std::nullopt;
        const FacetId f(std::size_t{piece});
        Barycentric<D - 1> xi{1 - u[0], u[0]};
        if constexpr (D == 3) xi = {1 - u[0] - u[1], u[0], u[1]};
        const auto here = expand(surrogate_.facets[f], xi);
        EntityPoint<D> out{here.point, {here.first[0]}, normal_at<D>(surrogate_.facets[f], xi)};
        if constexpr (D == 3) out.tangents[1] = here.first[1];
        return out;
    }

    [[nodiscard]] GeometryEntity entity_at_edge(const EdgeSite<D>& edge) const override {
        if (edge.kind != EdgeKind::ridge) return GeometryModel<D>::entity_at_edge(edge);
        const CurveFoot<D> foot = on_ridge(edge, edge.middle());
        return foot.row < surrogate_.edges.size() ? curve_at(foot.row, edge) : GeometryModel<D>::entity_at_edge(edge);
    }

    [[nodiscard]] std::optional<Plane<D>> plane_at(const FacetSite<D>& facet) const override {
        const auto foot = closest_of_reference(facet.reference, centroid_of(facet));
        if (!foot.facet.valid()) return plane_through(facet.corners);
        const auto& flat = surrogate_.flats[surrogate_.patches[foot.facet]];
        if (!flat.is_flat()) return std::nullopt;
        return Plane<D>{flat.point, flat.normal};
    }

    /// Closest point at an edge. A ridge of the surrogate's mesh uses its own curve, a ridge of another mesh the
    /// closest ridge curve. Other edges use the patches of their reference; on a flat patch, the result is in the
    /// plane.
    [[nodiscard]] SurfacePoint<D> on_edge(const EdgeSite<D>& edge, const Vec<D>& p) const override {
        if (edge.kind == EdgeKind::ridge) {
            const CurveFoot<D> foot = on_ridge(edge, p);
            if (foot.row < surrogate_.edges.size())
                return {.point = foot.point,
                        .normal = {},
                        .distance = camber::distance(foot.point, p),
                        .entity = curve_at(foot.row, edge),
                        .parameters = GeometryParameters{{foot.t, 0}, static_cast<std::uint32_t>(foot.row)}};
        }
        const auto foot = edge.facets.empty() ? SurrogateFoot<D>{} : closest_of_reference(edge.facets[0].reference, p);
        if (!foot.facet.valid()) return {.point = p, .normal = {}};
        const Vec<D> point = in_plane(foot, p);
        return {.point = point,
                .normal = normal_at<D>(surrogate_.facets[foot.facet], foot.xi),
                .distance = camber::distance(point, p),
                .facet = foot.facet,
                .entity = patch_of(foot.facet),
                .reference = surrogate_.references[foot.facet],
                .parameters = parameters_at(foot)};
    }

    [[nodiscard]] Vec<D> middle_of(const EdgeSite<D>& edge) const override {
        const std::size_t row = surrogate_.row(edge.id);
        if (is_own_edge(surrogate_, row, edge)) return surrogate_.edge_curves[row].middle;
        const Vec<D> middle = edge.middle();
        if (edge.kind == EdgeKind::ridge) {
            const auto foot = closest_on_ridges(surrogate_, middle);
            if (foot.row < surrogate_.edges.size()) return foot.point;
        }
        if (edge.facets.empty()) return middle;
        const auto foot = closest_of_reference(edge.facets[0].reference, middle);
        return foot.facet.valid() ? in_plane(foot, middle) : middle;
    }

    /// On facets of the surrogate's mesh, searches start at the coordinates `at`. Distances within the tolerance of a
    /// flat patch count as 0.
    [[nodiscard]] bool distances(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>> at,
                                 std::span<const Vec<D>> points, std::span<double> out) const override {
        if (is_own_facet(surrogate_, facet)) {
            const auto& flat = surrogate_.flats[surrogate_.patches[facet.id]];
            if (flat.is_flat())
                for (std::size_t i = 0; i < points.size(); ++i) out[i] = std::fabs(flat.height(points[i]));
            else
                own_distances(facet.id, at, points, out);
            return true;
        }
        if (!has_reference(facet.reference)) return false;
        SurrogateFoot<D> foot;
        for (std::size_t i = 0; i < points.size(); ++i) {
            foot = closest_of_reference(facet.reference, points[i], foot);
            const auto& flat = surrogate_.flats[surrogate_.patches[foot.facet]];
            out[i] = flat.is_flat() && flat.height(points[i]) == 0 ? 0 : std::sqrt(foot.distance_squared);
        }
        return true;
    }

    /// Each search starts from the last closest point, whose distance is an upper bound. All facets are searched only
    /// if this bound is too large.
    [[nodiscard]] bool are_within(const FacetSite<D>& facet, std::span<const Vec<D>> points,
                                  std::span<const double> bounds) const override {
        if (!has_reference(facet.reference)) return true;
        SurrogateFoot<D> foot;
        const auto is_within = [&](std::size_t i) {
            return surrogate_.references[foot.facet] == facet.reference &&
                   foot.distance_squared <= bounds[i] * bounds[i];
        };
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (foot.facet.valid()) foot = closest_near(surrogate_, foot.facet, foot.xi, points[i]);
            if (foot.facet.valid() && is_within(i)) continue;
            foot = closest_of_reference(facet.reference, points[i], foot);
            if (!is_within(i)) return false;
        }
        return true;
    }

    [[nodiscard]] bool is_one_surface(Reference) const override { return true; }

    [[nodiscard]] bool surface_points(const FacetSite<D>& facet, std::span<const Barycentric<D - 1>> at,
                                      std::span<Vec<D>> out) const override {
        if (!is_own_facet(surrogate_, facet)) return GeometryModel<D>::surface_points(facet, at, out);
        for (std::size_t n = 0; n < at.size(); ++n) out[n] = point_at(surrogate_.facets[facet.id], at[n]);
        return true;
    }

    [[nodiscard]] bool is_built_from(const FacetSite<D>& facet) const override {
        return is_own_facet(surrogate_, facet) && !surrogate_.flats[surrogate_.patches[facet.id]].is_flat();
    }

    /// The surrogate is one surface, so the first facet represents all.
    [[nodiscard]] double distance_at_facets(std::span<const FacetSite<D>> meet, const Vec<D>& p) const override {
        const FacetSite<D>& first = meet.front();
        const auto foot = is_own_facet(surrogate_, first) ? closest_near(surrogate_, first.id, p)
                                                          : closest_of_reference(first.reference, p);
        return foot.facet.valid() ? std::sqrt(foot.distance_squared) : 0;
    }

    [[nodiscard]] std::optional<std::array<Vec<D>, D>> normals_at(const FacetSite<D>& facet) const override {
        if (!is_own_facet(surrogate_, facet)) return GeometryModel<D>::normals_at(facet);
        std::array<Vec<D>, D> normals;
        for (std::size_t i = 0; i < D; ++i) {
            Barycentric<D - 1> corner{};
            corner[i] = 1;
            normals[i] = normal_at<D>(surrogate_.facets[facet.id], corner);
        }
        return normals;
    }

    [[nodiscard]] EntityName name_of_entity(const GeometryEntity& entity) const override {
        EntityName name = GeometryModel<D>::name_of_entity(entity);
        if (D == 3 && entity.kind == GeometryKind::surface) name.kind = "patch";
        if (D == 3 && entity.kind == GeometryKind::curve) name.kind = "ridge";
        return name;
    }

  protected:
    [[nodiscard]] bool has_reference(Reference reference) const {
        return std::ranges::binary_search(references_, reference);
    }
    /// True for an edge of the surrogate's mesh, or if both ends are near a ridge.
    [[nodiscard]] bool is_at_ridge(const EdgeSite<D>& edge) const {
        if (is_own_edge(surrogate_, surrogate_.row(edge.id), edge)) return true;
        constexpr double near = 0.1;  // relative to the chord
        const double most = near * camber::distance(edge.ends[0], edge.ends[1]);
        return std::ranges::all_of(edge.ends, [&](const Vec<D>& end) {
            const auto foot = closest_on_ridges(surrogate_, end);
            return foot.row < surrogate_.edges.size() && foot.distance_squared <= most * most;
        });
    }

  private:
    [[nodiscard]] GeometryEntity patch_of(FacetId f) const { return GeometryEntity::surface(surrogate_.patches[f]); }

    [[nodiscard]] SurrogateFoot<D> closest_of_reference(Reference reference, const Vec<D>& p,
                                                        const SurrogateFoot<D>& near = {}) const {
        const auto admits = [&](FacetId f) { return surrogate_.references[f] == reference; };
        if (!near.facet.valid()) return closest_among(surrogate_, p, admits);
        const SurrogateFoot<D> walked = closest_near(surrogate_, near.facet, near.xi, p);
        return closest_among(surrogate_, p, admits, admits(walked.facet) ? walked : SurrogateFoot<D>{});
    }

    /// Most points have their closest point inside the facet. For the others, the search crosses to adjacent facets.
    void own_distances(FacetId facet, std::span<const Barycentric<D - 1>> at, std::span<const Vec<D>> points,
                       std::span<double> out) const {
        if constexpr (D == 3)
            distances_inside(surrogate_.facets[facet], at, points, out);
        else
            std::ranges::fill(out, std::numeric_limits<double>::quiet_NaN());
        for (std::size_t i = 0; i < points.size(); ++i)
            if (std::isnan(out[i]))
                out[i] = std::sqrt(closest_near(surrogate_, facet, at[i], points[i]).distance_squared);
    }

    [[nodiscard]] Vec<D> in_plane(const SurrogateFoot<D>& foot, const Vec<D>& p) const {
        const auto& flat = surrogate_.flats[surrogate_.patches[foot.facet]];
        return flat.is_flat() ? flat.snapped(p) : foot.point;
    }

    [[nodiscard]] CurveFoot<D> on_ridge(const EdgeSite<D>& edge, const Vec<D>& p) const {
        const std::size_t row = surrogate_.row(edge.id);
        if (!is_own_edge(surrogate_, row, edge)) return closest_on_ridges(surrogate_, p);
        const auto foot = closest_on(surrogate_.edge_curves[row].curve, p);
        return {row, foot.xi[1], foot.point, foot.distance_squared};
    }

    [[nodiscard]] GeometryEntity curve_at(std::size_t row, const EdgeSite<D>& edge) const {
        const GeometryEntity sides = GeometryModel<D>::entity_at_edge(edge);
        const std::int64_t number = surrogate_.edge_curves[row].curve_number;
        // At an open rim, or at a ridge inside a patch, both sides are the same patch.
        if (sides.kind != GeometryKind::curve) return {GeometryKind::curve, number, {sides.id, sides.id}};
        return {GeometryKind::curve, number, sides.sides};
    }

    Surrogate<D> surrogate_;
    std::vector<Reference> references_;  ///< sorted, distinct
};

template <int D>
class PrescribedModel final : public SurrogateModel<D> {
    using Base = SurrogateModel<D>;

  public:
    using Base::Base;

    [[nodiscard]] GeometryEntity entity_at_edge(const EdgeSite<D>& edge) const override {
        return Base::entity_at_edge(site_of(edge));
    }
    [[nodiscard]] SurfacePoint<D> on_edge(const EdgeSite<D>& edge, const Vec<D>& p) const override {
        return Base::on_edge(site_of(edge), p);
    }
    [[nodiscard]] Vec<D> middle_of(const EdgeSite<D>& edge) const override { return Base::middle_of(site_of(edge)); }

    [[nodiscard]] bool prescribes(Reference reference) const override { return this->has_reference(reference); }
    [[nodiscard]] bool prescribes_any() const override { return true; }

  private:
    /// Ridges that only the current mesh has count as surface edges.
    [[nodiscard]] EdgeSite<D> site_of(EdgeSite<D> edge) const {
        if (edge.kind == EdgeKind::ridge && !this->is_at_ridge(edge)) edge.kind = EdgeKind::surface;
        return edge;
    }
};

}  // namespace

template <int D>
std::shared_ptr<const GeometryModel<D>> model_of(Surrogate<D> surrogate) {
    return std::make_shared<const SurrogateModel<D>>(std::move(surrogate));
}

template <int D>
std::shared_ptr<const GeometryModel<D>> model_of(PrescribedSurrogate<D> prescribed) {
    return std::make_shared<const PrescribedModel<D>>(std::move(prescribed.surrogate));
}

#define CAMBER_INSTANTIATE(D)                                                \
    template std::shared_ptr<const GeometryModel<D>> model_of(Surrogate<D>); \
    template std::shared_ptr<const GeometryModel<D>> model_of(PrescribedSurrogate<D>);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
