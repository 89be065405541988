module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.recipes;
import camber.core;
import camber.adapt;
import camber.bezier;
import camber.cavity;
import camber.operation;
import camber.surface;
import :geometry_error;
import :remesh_mesh;

namespace camber {

namespace {

std::size_t samples_for(std::size_t facets) {
    constexpr std::size_t a_facet = 16, least = 4096, most = 4000000;
    return std::clamp(a_facet * facets, least, most);
}

/// Surfaces and numbered curves that there are points of.
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

/// A mesh between two passes as it would be finished.
template <int D>
struct Seen {
    QuadraticMesh<D> mesh;
    Features<D> features;
};
template <int D>
Outcome<Seen<D>> seen(const Adaptation<D>& state, const Execution& execution) {
    auto end = finished(state, part_of(execution, 0, 0.5));
    if (!end) return fail(end.error());
    auto& [linear, edges, nodes, maps] = end->compact;
    Seen<D> out{{std::move(linear), std::move(edges), std::move(nodes)}, {}};
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
    for (DistanceBound& bound : out) bound.largest *= scale;
    return out;
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
    auto own = geometry->own_samples(samples_for(mesh.linear.facets.size()), part_of(execution, 0, 0.5));
    if (!own) return own;
    if (own->entities.empty()) return samples_over(mesh, features, geometry, part_of(execution, 0.5, 1));
    const Sampled sampled(*own);
    const auto elsewhere = reduce_each(
        part_of(execution, 0.5, 0.6), mesh.linear.facets.size(), std::size_t{0},
        [&](std::size_t& count, std::size_t f) {
            count += sampled.has(geometry->surface_at(facet_site(mesh.linear, FacetId(f)))) ? 0 : 1;
        },
        [](std::size_t a, std::size_t b) { return a + b; });
    if (!elsewhere) return fail(elsewhere.error());
    if (*elsewhere == 0) return own;
    const auto over = samples_over(mesh, features, geometry, part_of(execution, 0.6, 1));
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
Outcome<ReachedDistance<D>> reached_distance(const QuadraticMesh<D>& mesh, const Features<D>& features,
                                             const Geometry<D>& geometry, std::span<const DistanceBound> bounds,
                                             const Execution& execution) {
    const auto samples = samples_of_geometry(mesh, features, geometry, part_of(execution, 0, 0.3));
    if (!samples) return fail(samples.error());
    const auto found =
        distances_both_ways<D>(mesh, mesh.mid_nodes.view(), features, geometry, *samples, part_of(execution, 0.3, 1));
    if (!found) return fail(found.error());
    ReachedDistance<D> worst;
    double largest_share = -1;
    for (std::size_t f = 0; f < mesh.linear.facets.size(); ++f) {
        const double bound = distance_bound(bounds, mesh.linear.facets.references[FacetId(f)]);
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
    for (const OneWay<D>* way : {&found->to_geometry, &found->to_boundary})
        if (way->facet == worst.facet && way->largest == worst.reached) worst.at = way->from;
    return worst;
}

template <int D>
Outcome<WithinBounds<D>> bring_within(BroughtToMetric<D> brought, const AdaptationGoal<D>& goal,
                                      std::span<const DistanceBound> bounds, const ToMetricOptions& options,
                                      BoundaryEffort effort, const Around& around) {
    // Passes check few points of a facet: with a margin all points that are measured keep the bounds.
    constexpr int max_rounds = 4;
    constexpr double little_more = 1.5, margin = 0.92;
    AdaptationGoal<D> bounded = goal;
    WithinBounds<D> out{std::move(brought.state), brought.statistics, {}};
    double scale = 1;
    for (int round = 0; round < max_rounds; ++round) {
        bounded.distance_bounds = scaled(bounds, scale);
        const auto far =
            run_step(around, "distances", [&](const Execution& e) { return count_far_facets(out.state, bounded, e); });
        if (!far) return fail(far.error());
        if (*far == 0 && effort == BoundaryEffort::near_metric) break;
        if (*far > 0) {
            if (scale == 1) bounded.distance_bounds = scaled(bounds, scale = margin);
            auto refined = bring_within_bounds(std::move(out.state), bounded, options, effort, around);
            if (!refined) return fail(refined.error());
            out.state = std::move(refined->state);
            add_passes(out.statistics, refined->statistics);
        }
        auto reached = run_step(around, "distances", [&](const Execution& e) -> Outcome<ReachedDistance<D>> {
            const auto now = seen(out.state, part_of(e, 0, 0.2));
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

#define CAMBER_INSTANTIATE(D)                                                                                    \
    template Outcome<GeometrySamples<D>> samples_of_geometry<D>(const QuadraticMesh<D>&, const Features<D>&,     \
                                                                const Geometry<D>&, const Execution&);           \
    template Outcome<ReachedDistance<D>> reached_distance<D>(const QuadraticMesh<D>&, const Features<D>&,        \
                                                             const Geometry<D>&, std::span<const DistanceBound>, \
                                                             const Execution&);                                  \
    template Outcome<WithinBounds<D>> bring_within<D>(BroughtToMetric<D>, const AdaptationGoal<D>&,              \
                                                      std::span<const DistanceBound>, const ToMetricOptions&,    \
                                                      BoundaryEffort, const Around&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
