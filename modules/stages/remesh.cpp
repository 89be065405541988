// Remeshing, and refinement to a distance from the geometry.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.stages;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.edge_optimisation;
import camber.validity;
import camber.soundness;
import camber.surface;
import camber.operation;
import camber.adapt;
import camber.curving;
import camber.repair;

namespace camber {

namespace {

std::size_t samples_for(std::size_t facets) {
    constexpr std::size_t a_facet = 16, least = 4096, most = 4000000;
    return std::clamp(a_facet * facets, least, most);
}

class Sampled {
  public:
    template <int D>
    explicit Sampled(const GeometrySamples<D>& samples) {
        keys_.reserve(samples.entities.size());
        for (const auto& [entity, begin, end] : samples.entities) keys_.emplace_back(entity.kind, entity.id);
        std::sort(keys_.begin(), keys_.end());
    }
    [[nodiscard]] bool has(const GeometryEntity& entity) const {
        return entity.id != GeometryEntity::unnumbered &&
               std::binary_search(keys_.begin(), keys_.end(), std::pair(entity.kind, entity.id));
    }

  private:
    std::vector<std::pair<GeometryKind, std::int64_t>> keys_;
};

template <int D>
struct MeshSnapshot {
    QuadraticMesh<D> mesh;
    Features<D> features;
};
template <int D>
Outcome<MeshSnapshot<D>> snapshot(const Adaptation<D>& state, const Execution& execution) {
    auto end = finished(state, part_of(execution, 0, 0.5));
    if (!end) return fail(end.error());
    auto& [linear, edges, nodes, maps] = end->compact;
    MeshSnapshot<D> out{{std::move(linear), std::move(edges), std::move(nodes)}, {}};
    if (out.mesh.mid_nodes.empty()) {
        auto middles = map_each(without_progress(execution), out.mesh.edges.size(), [&](std::size_t e) {
            const auto& [a, b] = out.mesh.edges.vertices[e];
            return LagrangeNode<D>{midpoint(out.mesh.linear.points[a], out.mesh.linear.points[b])};
        });
        if (!middles) return fail(middles.error());
        out.mesh.mid_nodes = std::move(*middles);
    }
    auto features = find_features(out.mesh.linear, out.mesh.edges, listed_breaks<D>, part_of(execution, 0.5, 1));
    if (!features) return fail(features.error());
    out.features = std::move(*features);
    return out;
}

std::vector<DistanceBound> scaled(std::span<const DistanceBound> bounds, double scale) {
    std::vector<DistanceBound> out(bounds.begin(), bounds.end());
    for (DistanceBound& bound : out) {
        bound.largest *= scale;
        bound.share *= scale;
    }
    return out;
}

template <int D>
double longest_edge(const LinearMesh<D>& mesh, FacetId f) {
    const FacetSite<D> facet = facet_site(mesh, f);
    double longest = 0;
    for (const auto& [a, b] : local_edges<D - 1>)
        longest = std::max(longest, distance(facet.corners[a], facet.corners[b]));
    return longest;
}

void add_passes(ToMetricStatistics& sum, const ToMetricStatistics& part) {
    sum.collapse += part.collapse;
    sum.split += part.split;
    sum.swap += part.swap;
    sum.smooth += part.smooth;
    sum.mend += part.mend;
}

}  // namespace

template <int D>
Outcome<GeometrySamples<D>> samples_of_geometry(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                                const Geometry<D>& geometry, const Execution& execution) {
    auto own = geometry->sample_all(samples_for(mesh.linear.facets.size()), part_of(execution, 0, 0.5));
    if (!own) return own;
    if (own->entities.empty()) return sample_over_mesh(mesh, features, geometry, part_of(execution, 0.5, 1));
    const Sampled sampled(*own);
    const auto other_materials = reduce_each(
        part_of(execution, 0.5, 0.6), mesh.linear.facets.size(), std::size_t{0},
        [&](std::size_t& count, std::size_t f) {
            count += sampled.has(geometry->surface_at(facet_site(mesh.linear, FacetId(f)))) ? 0 : 1;
        },
        [](std::size_t a, std::size_t b) { return a + b; });
    if (!other_materials) return fail(other_materials.error());
    if (*other_materials == 0) return own;
    const auto over = sample_over_mesh(mesh, features, geometry, part_of(execution, 0.6, 1));
    if (!over) return fail(over.error());
    return guarded([&]() -> Outcome<GeometrySamples<D>> {
        for (const auto& [entity, begin, end] : over->entities) {
            if (sampled.has(entity)) continue;
            own->begin(entity);
            for (std::size_t i = begin; i < end; ++i) own->add(over->points[i], over->weights[i], over->near[i]);
        }
        return std::move(*own);
    });
}

template <int D>
std::vector<DistanceBound> default_distance_bounds(const LinearMesh<D>& mesh, int degree,
                                                   std::span<const DistanceBound> required) {
    constexpr double share_of_size = 0.01;
    // Largest distance from a circle relative to the chord: tan(α/4)/2 for a chord of turn α; 0.0067 for a parabola of
    // 90 degrees.
    constexpr double straight = 0.0658, curved = 0.0067;
    std::map<Reference, Box<D>> boxes;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        Box<D>& box = boxes[mesh.facets.references[FacetId(f)]];
        for (const Vec<D>& corner : facet_site(mesh, FacetId(f)).corners) box.include(corner);
    }
    const DistanceBounds of_required(required);
    std::vector<DistanceBound> bounds;
    for (const auto& [reference, box] : boxes)
        if (!of_required.of(reference).is_finite())
            bounds.push_back({share_of_size * box.diagonal(), {reference}, degree == 1 ? straight : curved});
    return bounds;
}

template <int D>
Outcome<BoundedFacets> bounded_facets(const Adaptation<D>& state, const AdaptationGoal<D>& goal,
                                      const Execution& execution) {
    if (goal.distance_bounds.empty()) return BoundedFacets{};
    const double collapsed = CollapseOptions{}.shortest;
    // A facet twice as large is four times as far from the geometry, for degree 2 at least eight times.
    const double near = state.mesh.is_curved() ? 1.0 / 8 : 1.0 / 4;
    return reduce_each(
        execution, state.mesh.facets.size(), BoundedFacets{},
        [&](BoundedFacets& count, std::size_t i) {
            const FacetId f(i);
            if (state.mesh.is_free(f) || state.mesh.is_at_infinity(f) || !state.mesh.sides[f][0].valid()) return;
            const double share = bound_shares(state, goal, f).largest();
            double longest = 0;
            for (int e = 0; e < edges_per_simplex<D - 1>; ++e)
                longest = std::max(longest, length_of(state, local_facet_edge(state.mesh, f, e)));
            count.far += share > 1 ? 1 : 0;
            count.limited += share > near && longest < collapsed ? 1 : 0;
        },
        [](const BoundedFacets& a, const BoundedFacets& b) {
            return BoundedFacets{a.limited + b.limited, a.far + b.far};
        });
}

template <int D>
Outcome<ReachedDistance<D>> reached_distance(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                             const Geometry<D>& geometry, std::span<const DistanceBound> bounds,
                                             const Execution& execution) {
    const auto samples = samples_of_geometry(mesh, features, geometry, part_of(execution, 0, 0.3));
    if (!samples) return fail(samples.error());
    const auto found =
        two_sided_distances<D>(mesh, mesh.mid_nodes.view(), features, geometry, *samples, part_of(execution, 0.3, 1));
    if (!found) return fail(found.error());
    ReachedDistance<D> worst;
    double largest_share = -1;
    const DistanceBounds limits(bounds);
    for (std::size_t f = 0; f < mesh.linear.facets.size(); ++f) {
        const double bound =
            limits.of(mesh.linear.facets.references[FacetId(f)]).at(longest_edge(mesh.linear, FacetId(f)));
        if (bound == std::numeric_limits<double>::infinity()) continue;
        const double distance = std::max(found->of_facets[f], found->to_facets[f]);
        worst.far_facets += distance > bound ? 1 : 0;
        if (!(distance / bound > largest_share)) continue;
        largest_share = distance / bound;
        worst.required = bound;
        worst.reached = distance;
        worst.facet = FacetId(f);
    }
    if (!worst.facet.valid()) return worst;
    for (const Vec<D>& corner : facet_site(mesh.linear, worst.facet).corners) worst.at += (1.0 / D) * corner;
    for (const DirectedDistance<D>* way : {&found->to_geometry, &found->to_boundary})
        if (way->facet == worst.facet && way->largest == worst.reached) worst.at = way->from;
    return worst;
}

template <int D>
Outcome<WithinBounds<D>> refine_within(RemeshResult<D> adapted, const AdaptationGoal<D>& goal,
                                       std::span<const DistanceBound> bounds, const ToMetricOptions& options,
                                       BoundaryEffort effort, const StepWrapper& around) {
    // Passes check only a few points of a facet. The bounds are therefore scaled by `margin`, so that all points
    // measured later are within the original bounds.
    constexpr int max_rounds = 4;
    constexpr double little_more = 1.5, margin = 0.92;
    AdaptationGoal<D> bounded = goal;
    WithinBounds<D> out{std::move(adapted.state), adapted.statistics, {}};
    double scale = 1;
    for (int round = 0; round < max_rounds; ++round) {
        bounded.distance_bounds = DistanceBounds(scaled(bounds, scale));
        const auto far =
            run_step(around, "distances", [&](const Execution& e) { return count_far_facets(out.state, bounded, e); });
        if (!far) return fail(far.error());
        if (*far == 0 && effort == BoundaryEffort::near_metric) break;
        if (*far > 0) {
            if (scale == 1) bounded.distance_bounds = DistanceBounds(scaled(bounds, scale = margin));
            auto refined = refine_to_bounds(std::move(out.state), bounded, options, effort, around);
            if (!refined) return fail(refined.error());
            out.state = std::move(refined->state);
            add_passes(out.statistics, refined->statistics);
        }
        auto reached = run_step(around, "distances", [&](const Execution& e) -> Outcome<ReachedDistance<D>> {
            const auto now = snapshot(out.state, part_of(e, 0, 0.2));
            if (!now) return fail(now.error());
            return reached_distance(now->mesh, now->features, *goal.geometry, bounds, part_of(e, 0.2, 1));
        });
        if (!reached) return fail(reached.error());
        const bool progresses = round == 0 || reached->far_facets < out.reached->far_facets;
        out.reached = *reached;
        const double excess = reached->required > 0 ? reached->reached / reached->required : 0;
        if (!(excess > 1) || !progresses) break;
        if (excess < little_more) scale *= margin / excess;
    }
    return out;
}

namespace {

template <int D>
std::vector<VertexId> corners_with(const Features<D>& features, const Column<VertexId>& of_curves) {
    std::vector<VertexId> corners(of_curves.begin(), of_curves.end());
    const auto of_features = corners_of(features);
    corners.insert(corners.end(), of_features.begin(), of_features.end());
    return corners;
}

template <int D>
AdaptationGoal<D> goal_of(const Boundary<D>& boundary, RemeshingBy<D> by) {
    AdaptationGoal<D> goal{std::move(by.field), boundary.geometry};
    goal.max_elements = by.max_elements;
    goal.distance_bounds = DistanceBounds(by.distance_bounds);
    goal.accuracy = static_cast<const EdgeAccuracyOptions&>(by.curving);
    if (by.curving.aim != CurvingAim::accuracy) goal.search.emplace(search_options(by.curving));
    return goal;
}

/// Starts remeshing by `begin(breaks, goal)`, which returns Outcome<Adaptation>. Uses the curves `found`, or those of
/// the mesh before remeshing.
template <int D>
Outcome<Remeshing<D>> begin(const Boundary<D>& boundary, RemeshingBy<D> by, Outcome<EmbeddedCurves<D>> found,
                            const auto& begin) {
    if (!found) return fail(found.error());
    const auto corners = corners_with(boundary.features, found->corners);
    const auto* const before = by.curves;
    AdaptationGoal<D> goal = goal_of(boundary, std::move(by));
    goal.curves = before != nullptr ? *before : std::move(*found);
    auto result = begin(BreaksOfMesh{boundary.features.edge_kinds.view(), corners}, goal);
    if (!result) return fail(result.error());
    return Remeshing<D>{std::move(*result), std::move(goal)};
}

}  // namespace

template <int D>
Outcome<Remeshing<D>> begin_remeshing(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, const Boundary<D>& boundary,
                                      RemeshingBy<D> by, const Execution& execution) {
    auto curves =
        find_embedded_curves(mesh, edges, boundary.features, boundary.geometry, {}, without_progress(execution));
    return begin(boundary, std::move(by), std::move(curves), [&](const BreaksOfMesh& breaks, const auto& goal) {
        return begin_adaptation(mesh, edges, breaks, goal, execution);
    });
}
template <int D>
Outcome<Remeshing<D>> begin_remeshing(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> nodes,
                                      const Boundary<D>& boundary, RemeshingBy<D> by, const Execution& execution) {
    auto curves = find_embedded_curves(mesh.linear, mesh.edges, boundary.features, boundary.geometry, nodes,
                                       without_progress(execution));
    return begin(boundary, std::move(by), std::move(curves), [&](const BreaksOfMesh& breaks, const auto& goal) {
        return begin_adaptation(mesh, breaks, goal, execution);
    });
}

template <int D>
Outcome<OntoGeometry<D>> put_nodes_onto_geometry(QuadraticMesh<D> mesh, const Boundary<D>& boundary,
                                                 const Execution& execution) {
    OntoGeometry<D> out{std::move(mesh)};
    if (!boundary.geometry->prescribes_any()) return out;
    const Column<EdgeKind>& kinds = boundary.features.edge_kinds;
    const auto feet = mesh_nodes_on(boundary.geometry, kinds, out.mesh, boundary.required, part_of(execution, 0, 0.3));
    if (!feet) return fail(feet.error());
    Proposal<D> proposal = proposal_from_mesh(out.mesh, kinds, boundary.required);
    Buffer<LagrangeNode<D>> nodes = take(std::move(proposal.mid_nodes));
    for (std::size_t e = 0; e < nodes.size(); ++e) {
        const auto& [a, b] = out.mesh.edges.vertices[e];
        const double way = distance((*feet)[e].point, nodes[e].point);
        if (!(way > BoundaryTolerance{}.nodes * distance(out.mesh.linear.points[a], out.mesh.linear.points[b])))
            continue;
        nodes[e] = (*feet)[e];
        ++out.nodes;
        out.largest = std::max(out.largest, way);
    }
    if (out.nodes == 0) return out;
    proposal.mid_nodes = std::move(nodes);
    auto judged = validate(out.mesh, std::move(proposal), default_bound, part_of(execution, 0.3, 0.5));
    if (!judged) return fail(judged.error());
    if (judged->validation().certified()) {
        out.mesh = commit_uncertified(*judged).mesh;
        return out;
    }
    const RepairOptions options{.vertices = VertexMoves::never};
    const auto guide = make_guide<D>(*judged, std::nullopt, &boundary, options, part_of(execution, 0.5, 0.6));
    if (!guide) return fail(guide.error());
    const auto repaired = repair_or_straighten(*judged, *guide, options, part_of(execution, 0.6, 1));
    if (!repaired) return fail(repaired.error());
    out.mesh = commit_uncertified(repaired->judged).mesh;
    return out;
}

#define CAMBER_INSTANTIATE(D)                                                                                      \
    template std::vector<DistanceBound> default_distance_bounds<D>(const LinearMesh<D>&, int,                      \
                                                                   std::span<const DistanceBound>);                \
    template Outcome<BoundedFacets> bounded_facets<D>(const Adaptation<D>&, const AdaptationGoal<D>&,              \
                                                      const Execution&);                                           \
    template Outcome<GeometrySamples<D>> samples_of_geometry<D>(const QuadraticMesh<D>&, const Features<D>&,       \
                                                                const Geometry<D>&, const Execution&);             \
    template Outcome<ReachedDistance<D>> reached_distance<D>(const QuadraticMesh<D>&, const Features<D>&,          \
                                                             const Geometry<D>&, std::span<const DistanceBound>,   \
                                                             const Execution&);                                    \
    template Outcome<WithinBounds<D>> refine_within<D>(RemeshResult<D>, const AdaptationGoal<D>&,                  \
                                                       std::span<const DistanceBound>, const ToMetricOptions&,     \
                                                       BoundaryEffort, const StepWrapper&);                        \
    template Outcome<Remeshing<D>> begin_remeshing<D>(const LinearMesh<D>&, const EdgeSet<D>&, const Boundary<D>&, \
                                                      RemeshingBy<D>, const Execution&);                           \
    template Outcome<Remeshing<D>> begin_remeshing<D>(const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>,   \
                                                      const Boundary<D>&, RemeshingBy<D>, const Execution&);       \
    template Outcome<OntoGeometry<D>> put_nodes_onto_geometry<D>(QuadraticMesh<D>, const Boundary<D>&,             \
                                                                 const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
