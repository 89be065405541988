module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.edge_optimisation;
import camber.surface;

namespace camber {

namespace {

constexpr double min_gain = 1e-6;      // smaller relative decreases of length are ignored
constexpr double min_relief = 0.01;    // smaller relative decreases of distance are ignored
constexpr double no_distance = 1e-10;  // fraction of the chord below which distances count as 0
constexpr double distance_growth = 2;  // aim `length`: the edge may be this many times as far from the geometry as with
                                       // the projected middle
constexpr int max_halvings = 6;

template <int D>
struct InMetric {
    static constexpr double damping = 0;
    EdgeObjective<D> objective;

    [[nodiscard]] double value(const Vec<D>& node) const { return objective.value(node); }
    [[nodiscard]] ObjectiveSample<D> evaluate(const Vec<D>& node) const { return objective.evaluate(node); }
};

/// Objective for `SheetSearch`: ∫ |r|² dt, with the vector r from the nearest surface point to the point l(t) of the
/// edge. Nearest points move perpendicular to r, so |r|² has the derivative 2 · 4t(1−t) r by the node. The Gauss–Newton
/// Hessian is ∫ 2 (4t(1−t))² n nᵀ dt with the surface normal n (on a curve: with the projector normal to it). The node
/// moves only along its edge: sideways motion hardly changes its distance, and increases that of adjacent facets.
template <int D>
struct FromSheet {
    static constexpr double damping = 0.01;
    const EdgeSheet<D>* sheet;
    const SheetPosition<D>* near;
    const Quadrature* rule;
    Vec<D> p20, p02;

    [[nodiscard]] double value(const Vec<D>& node) const {
        const QuadraticEdge<D> edge{p20, {node}, p02};
        double sum = 0;
        for (std::size_t i = 0; i < rule->size(); ++i) {
            const Vec<D> p = edge.point(rule->t[i]);
            sum += rule->w[i] * norm_squared(p - sheet->foot(*near, p).point);
        }
        return sum;
    }
    [[nodiscard]] ObjectiveSample<D> evaluate(const Vec<D>& node) const {
        const QuadraticEdge<D> edge{p20, {node}, p02};
        const bool is_curve = sheet->kind() == EdgeSheet<D>::Kind::curve;
        const Vec<D>& along = near->tangents[0];
        ObjectiveSample<D> sum;
        for (std::size_t i = 0; i < rule->size(); ++i) {
            const double t = rule->t[i], c = 4 * t * (1 - t), w = rule->w[i];
            const Vec<D> p = edge.point(t);
            const SurfaceFoot<D> foot = sheet->foot(*near, p);
            const Vec<D> r = p - foot.point;
            const Vec<D> direction = is_curve ? normalised(edge.derivative(t)) : foot.normal;
            sum.value += w * norm_squared(r);
            sum.gradient += 2 * w * c * r;
            for (int k = 0; k < D; ++k)
                for (int l = 0; l <= k; ++l) {
                    const double square = direction[k] * direction[l];
                    sum.hessian(k, l) += 2 * w * c * c * (is_curve ? (k == l ? 1 : 0) - square : square);
                }
        }
        sum.gradient = dot(sum.gradient, along) * along;
        return sum;
    }
};

template <int D>
class NodeSearch {
  public:
    NodeSearch(const EdgeSheet<D>& sheet, const SheetPosition<D>& start, const EdgeToPlace<D>& edge,
               const BackMesh<D>& back, const PlacementSearch& parameters)
        : sheet_(sheet),
          start_(start),
          p20_(edge.site.ends[0]),
          p02_(edge.site.ends[1]),
          reach_{start.point, edge.site.middle(), p02_ - p20_, parameters.search.max_tangential_shift, edge.thin},
          search_(sheet, reach_),
          back_(back),
          element_at_(edge.element_at),
          rules_(parameters.rules),
          options_(parameters.search),
          placing_(parameters.placement) {}

    [[nodiscard]] double measure(const SheetPosition<D>& place) const {
        if (placing_.boundary_nodes == BoundaryNodeAim::length)
            return riemannian_length(back_, QuadraticEdge<D>{p20_, {place.point}, p02_}, rules_.report, element_at_)
                .length;
        return std::sqrt(FromSheet<D>{&sheet_, &start_, &rules_.report, p20_, p02_}.value(place.point));
    }

    [[nodiscard]] PlacedNode<D> placed() const {
        PlacedNode<D> out{{start_.point}, PlacementStatus::best, false, false, measure(start_), 0};
        out.after = out.before;
        if (!by_length() && out.before <= no_distance * norm(reach_.chord)) return out;
        const SheetPosition<D> target = by_length() ? shortest() : nearest();
        if (target.point == start_.point) return out;
        const double allowed = largest_allowed();
        const Vec<2> way = search_.coordinates(start_, target.point - start_.point);
        double share = 1;
        for (int halving = 0; halving <= max_halvings; ++halving, share *= 0.5) {
            const auto place = halving == 0 ? std::optional(target) : search_.at(start_, share * way);
            if (!place) continue;
            const double after = measure(*place);
            if (!(after < (1 - (by_length() ? min_gain : min_relief)) * out.before)) continue;
            if (farthest(*place) > allowed) {
                out.status = PlacementStatus::far;
                continue;
            }
            return {{place->point},
                    PlacementStatus::placed,
                    sheet_.has_left_facets(start_, *place),
                    halving > 0,
                    out.before,
                    after};
        }
        return out;
    }

    /// Moves the start by `offset` and projects it onto the surface. No value if the edge is then too far from the
    /// geometry or not improved.
    [[nodiscard]] std::optional<PlacedNode<D>> seated(const Vec<D>& offset, PlacedNode<D> whole) const {
        const auto place = search_.at(start_, search_.coordinates(start_, offset));
        if (!place || farthest(*place) > largest_allowed()) return std::nullopt;
        whole.after = measure(*place);
        if (!(whole.after < whole.before)) return std::nullopt;
        whole.node.point = place->point;
        whole.has_left_facets = sheet_.has_left_facets(start_, *place);
        whole.is_limited = true;
        return whole;
    }

  private:
    [[nodiscard]] bool by_length() const { return placing_.boundary_nodes == BoundaryNodeAim::length; }

    /// Minimises first the energy, then the length. The start is the current node, or the first step of a geodesic if
    /// its energy is lower.
    [[nodiscard]] SheetPosition<D> shortest() const {
        InMetric<D> in_metric{edge_objective(back_, rules_.objective, EdgeObjectiveKind::energy, options_.field,
                                             {p20_, p02_, element_at_})};
        SheetIterate<D> at = search_.evaluated(in_metric, start_);
        Vec<2> way = search_.coordinates(start_, geodesic_start(back_, p20_, p02_, element_at_) - reach_.middle);
        const double longest = 0.25 * norm(reach_.chord);
        if (norm(way) > longest) way *= longest / norm(way);
        for (int halving = 0; halving < 4 && norm(way) > 1e-6 * longest; ++halving, way *= 0.5) {
            const auto place = search_.at(start_, way);
            if (!place || !(in_metric.value(place->point) < at.value)) continue;
            at = search_.evaluated(in_metric, *place);
            break;
        }
        using End = typename SheetSearch<D>::End;
        if (search_.descend(in_metric, options_.max_iterations, options_.tolerance, at) == End::stopped)
            search_.polish(in_metric, at);
        in_metric.objective.kind = EdgeObjectiveKind::length;
        at = search_.evaluated(in_metric, at.place);
        search_.descend(in_metric, 5, options_.length_tolerance, at);
        return at.place;
    }

    [[nodiscard]] SheetPosition<D> nearest() const {
        const FromSheet<D> objective{&sheet_, &start_, &rules_.objective, p20_, p02_};
        SheetIterate<D> at = search_.evaluated(objective, start_);
        search_.descend(objective, 10, 1e-4, at);
        return at.place;
    }

    [[nodiscard]] double farthest(const SheetPosition<D>& place) const {
        const QuadraticEdge<D> edge{p20_, {place.point}, p02_};
        double largest = 0;
        for (const int i : {1, 2, 3, 5, 6, 7}) {
            const Vec<D> p = edge.point(i / 8.0);
            largest = std::max(largest, distance(p, sheet_.foot(place, p).point));
        }
        return largest;
    }

    [[nodiscard]] double largest_allowed() const {
        if (sheet_.kind() == EdgeSheet<D>::Kind::plane) return 1e-12 * norm(reach_.chord);
        if (!by_length()) return farthest(start_);
        const double sagitta = distance(start_.point, reach_.middle);
        return std::max(distance_growth * farthest(start_), placing_.distance_share * sagitta);
    }

    const EdgeSheet<D>& sheet_;
    const SheetPosition<D>& start_;
    Vec<D> p20_, p02_;
    NodeReach<D> reach_;
    SheetSearch<D> search_;
    const BackMesh<D>& back_;
    ElementId element_at_;
    const EdgeRules& rules_;
    const CurveOptions& options_;
    const PlacementOptions& placing_;
};

template <int D, class Use>
PlacedNode<D> with_placement(const Geometry<D>& geometry, const EdgeToPlace<D>& edge, const BackMesh<D>& back,
                             const PlacementSearch& parameters, Use&& use) {
    PlacedNode<D> out{.node = edge.present};
    const EdgeSheet<D> sheet(*geometry, edge.site);
    using Kind = typename EdgeSheet<D>::Kind;
    const bool is_near_anyway =
        sheet.kind() == Kind::plane && parameters.placement.boundary_nodes == BoundaryNodeAim::accuracy;
    if (sheet.kind() == Kind::straight || is_near_anyway) return out;
    out.status = PlacementStatus::off;
    const auto start = sheet.place_of(edge.present.point);
    if (!start) return out;
    return use(NodeSearch<D>(sheet, *start, edge, back, parameters));
}

template <int D>
class Boundary {
  public:
    Boundary(const QuadraticMesh<D>& mesh, const Features<D>& features, Incidence<FacetId> facets)
        : mesh_(mesh),
          kinds_(features.edge_kinds),
          facets_(std::move(facets)),
          on_ridge_(mesh.linear.points.size(), 0) {
        if constexpr (D == 3)
            for (std::size_t e = 0; e < kinds_.size(); ++e)
                if (kinds_[e] == EdgeKind::ridge)
                    for (const VertexId v : mesh.edges.vertices[e]) on_ridge_[v.index()] = 1;
    }

    [[nodiscard]] EdgeSite<D> site(std::size_t e) const {
        const auto& [low, high] = mesh_.edges.vertices[e];
        return {EdgeId(e),
                kinds_[e],
                {mesh_.linear.points[low], mesh_.linear.points[high]},
                facet_sites<D>(mesh_.linear, facets_[e])};
    }
    [[nodiscard]] std::vector<Vec<D>> thin(std::size_t e) const {
        std::vector<Vec<D>> corners;
        const auto& [low, high] = mesh_.edges.vertices[e];
        for (const FacetId f : facets_[e])
            for (const VertexId v : mesh_.linear.facets.vertices[f])
                if (v != low && v != high && on_ridge_[v.index()] != 0) corners.push_back(mesh_.linear.points[v]);
        return corners;
    }

  private:
    const QuadraticMesh<D>& mesh_;
    const Column<EdgeKind>& kinds_;
    Incidence<FacetId> facets_;
    Buffer<std::uint8_t> on_ridge_;
};

}  // namespace

template <int D>
PlacedNode<D> placed_node(const Geometry<D>& geometry, const EdgeToPlace<D>& edge, const BackMesh<D>& back,
                          const PlacementSearch& parameters) {
    return with_placement(geometry, edge, back, parameters,
                          [](const NodeSearch<D>& placement) { return placement.placed(); });
}

template <int D>
Outcome<Buffer<PlacedNode<D>>> placed_nodes(const MeshEdges<D>& edges, const Column<LagrangeNode<D>>& nodes,
                                            const GeometricBoundary<D>& surface, const BackMesh<D>& back,
                                            const PlacementSearch& parameters, const Execution& execution) {
    const auto& [mesh, kinds, shells] = edges;
    const Features<D>& features = surface.features;
    const std::size_t n = mesh.edges.size();
    if (kinds.size() != n || nodes.size() != n || features.edge_kinds.size() != n)
        return fail(ErrorKind::internal, "the kinds, the nodes or the features belong to another mesh");
    auto around = facet_shells(mesh.edges, without_progress(execution));
    if (!around) return fail(around.error());
    return guarded([&]() -> Outcome<Buffer<PlacedNode<D>>> {
        const Boundary<D> boundary(mesh, features, std::move(*around));
        const auto is_requested = [&](std::size_t e) {
            return parameters.placement.boundary_nodes != BoundaryNodeAim::projection && !shells[e].empty() &&
                   kinds[e] == features.edge_kinds[e] && kinds[e] != EdgeKind::volume;
        };
        const auto placement_of = [&](std::size_t e, auto&& use) {
            const EdgeSite<D> site = boundary.site(e);
            const std::vector<Vec<D>> thin = boundary.thin(e);
            return with_placement<D>(surface.geometry, {site, nodes[e], thin, *std::ranges::min_element(shells[e])},
                                     back, parameters, use);
        };
        auto placed = map_each(
            part_of(execution, 0, 0.8), n,
            [&](std::size_t e) -> PlacedNode<D> {
                if (!is_requested(e)) return {.node = nodes[e]};
                return placement_of(e, [](const NodeSearch<D>& placement) { return placement.placed(); });
            },
            64);
        if (!placed) return placed;
        Buffer<Vec<D>> offsets(n);
        for (std::size_t e = 0; e < n; ++e) offsets[e] = (*placed)[e].node.point - nodes[e].point;
        auto limited_count = limit_by_jacobian<D>(mesh, nodes.view(), shells, parameters.search.min_jacobian, offsets,
                                                  part_of(execution, 0.8, 0.95));
        if (!limited_count) return fail(limited_count.error());
        return map_each(
            part_of(execution, 0.95, 1), n,
            [&](std::size_t e) -> PlacedNode<D> {
                const PlacedNode<D>& whole = (*placed)[e];
                if (whole.status != PlacementStatus::placed || offsets[e] == whole.node.point - nodes[e].point)
                    return whole;
                const PlacedNode<D> none{nodes[e], PlacementStatus::elements, false, false, whole.before, whole.before};
                if (offsets[e] == Vec<D>{}) return none;
                return placement_of(e, [&](const NodeSearch<D>& placement) {
                    return placement.seated(offsets[e], whole).value_or(none);
                });
            },
            64);
    });
}

template <int D>
PlacementStatistics placement_statistics(std::span<const PlacedNode<D>> nodes) {
    PlacementStatistics s;
    double before = 0, after = 0;
    for (const PlacedNode<D>& node : nodes) {
        if (node.status == PlacementStatus::fixed) continue;
        ++s.edges;
        s.placed += node.status == PlacementStatus::placed;
        s.best += node.status == PlacementStatus::best;
        s.off += node.status == PlacementStatus::off;
        s.far += node.status == PlacementStatus::far;
        s.elements += node.status == PlacementStatus::elements;
        s.walked += node.has_left_facets;
        s.limited += node.is_limited;
        const double gain = node.status == PlacementStatus::placed && node.after > 0 ? node.before / node.after - 1 : 0;
        before += node.before;
        after += node.after;
        s.largest_reduction = std::max(s.largest_reduction, gain);
    }
    if (after > 0) s.mean_reduction = before / after - 1;
    return s;
}

#define CAMBER_INSTANTIATE(D)                                                                                    \
    template PlacementStatistics placement_statistics<D>(std::span<const PlacedNode<D>>);                        \
    template PlacedNode<D> placed_node<D>(const Geometry<D>&, const EdgeToPlace<D>&, const BackMesh<D>&,         \
                                          const PlacementSearch&);                                               \
    template Outcome<Buffer<PlacedNode<D>>> placed_nodes<D>(const MeshEdges<D>&, const Column<LagrangeNode<D>>&, \
                                                            const GeometricBoundary<D>&, const BackMesh<D>&,     \
                                                            const PlacementSearch&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
