// Split, collapse, mending of bad elements, and the adaptation loop.
module;
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>
module camber.adapt;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.surface;
import camber.operation;

namespace camber {

namespace {

/// Returns the parameter t in [0, 1] that halves the metric length of an edge: ∫_0^t a^(1−s) b^s ds = ½ ∫_0^1 a^(1−s)
/// b^s ds. `a`, `b`: lengths of the edge in the metrics of its ends.
double half_of_length(double a, double b) {
    const double log_ratio = log(b / a);
    if (!std::isfinite(log_ratio) || std::abs(log_ratio) < 1e-6) return 0.5;
    return std::clamp(log((1 + b / a) / 2) / log_ratio, 0.2, 0.8);
}

template <int D>
class Splits final : public Pass<D> {
  public:
    Splits(const AdaptationGoal<D>& goal, const SplitOptions& options) : goal_(goal), options_(options) {}

    [[nodiscard]] double order_of(double length) const { return length > options_.longest ? -length : infinite_order; }

    [[nodiscard]] std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const override {
        return candidate_at(r, task, 1);
    }
    [[nodiscard]] std::optional<Candidate<D>> shortened(const Adaptation<D>& r, const Task& task,
                                                        double share) const override {
        auto candidate = goal_.geometry ? candidate_at(r, task, share) : std::nullopt;
        if (candidate && candidate->request.cavity.facets.empty()) candidate.reset();
        return candidate;
    }
    [[nodiscard]] static bool is_cached_rejection(const Adaptation<D>&, EdgeId) {
        return false;
    }  // no cache, because the cavity of a split may contain distant elements
    void follow(Adaptation<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) override {
        add_edge_tasks(r, changes, [&](double length) { return order_of(length); }, tasks);
    }

  private:
    /// The split of an edge longer than 2 may create short edges. If the edge is longer than 4 and the new point
    /// reaches the geometry, it may also create flat elements.
    [[nodiscard]] SplitLimits limits_of(double length, double share) const {
        constexpr double max_overlength = 2;
        SplitLimits limits{options_.shortest, options_.min_quality};
        if (!(length > max_overlength)) return limits;
        limits.shortest *= max_overlength / length * (max_overlength / length);
        if (share == 1 && length > 2 * max_overlength)
            limits.bad_quality = limits.min_quality = std::min(0.02, options_.min_quality);
        return limits;
    }

    [[nodiscard]] std::optional<Candidate<D>> candidate_at(const Adaptation<D>& r, const Task& task,
                                                           double share) const {
        const EdgeId edge(std::size_t{task.id});
        if (r.mesh.is_free(edge)) return {};
        const double length = length_of(r, edge);
        if (!(length > options_.longest)) return {};
        return split_candidate(r, goal_, edge, share, limits_of(length, share));
    }
    const AdaptationGoal<D>& goal_;
    const SplitOptions& options_;
};

}  // namespace

template <int D>
std::optional<Candidate<D>> split_candidate(const Adaptation<D>& r, const AdaptationGoal<D>& goal, EdgeId edge,
                                            double share, const SplitLimits& limits) {
    constexpr std::size_t max_elements = 64;
    const auto [element, local] = element_with_edge(r.mesh, edge);
    if (!element.valid()) return {};
    Candidate<D> candidate;
    auto& request = candidate.request;
    cavity_of_edge(r.mesh, element, local, request.cavity);
    const auto& [a, b] = r.mesh.edges[edge];
    const Vec<D> chord = r.mesh.points[b] - r.mesh.points[a];
    const double t = half_of_length(std::sqrt(r.vertices.metrics[a].measure.length_squared(chord)),
                                    std::sqrt(r.vertices.metrics[b].measure.length_squared(chord)));
    request.place = r.mesh.points[a] + t * chord;
    if (r.mesh.is_curved()) {
        request.origin = request.place;
        request.halves = {a, b};
        request.place = QuadraticEdge<D>{r.mesh.points[a], r.mesh.nodes[edge], r.mesh.points[b]}.point(t);
    }
    request.share = share;
    const SurfacePoint<D> foot = on_geometry_at_edge(goal, r.mesh, edge, request.cavity.facets, request.place);
    if (share < 1 && foot.point == request.place)
        return {};  // a shorter way changes nothing: the point is on the
                    // geometry
    request.place += share * (foot.point - request.place);
    request.geometry_position = place_after(share, foot);
    if (r.mesh.point_references[a] == r.mesh.point_references[b]) request.reference = r.mesh.point_references[a];
    sample_field(r, goal, r.vertices.metrics[a].back, request);
    request.fixed_element_count = request.cavity.elements.size();
    // Every cavity of this split contains the elements at the edge. If one of their vertices is too near to the new
    // point, the split is rejected at once.
    const ConePoint<D> point{request.place, &request.metric, &request.gradient,
                             request.cavity.facets.empty() ? VertexPlace::inside : VertexPlace::surface};
    BentSpokes<D> spokes(r, goal);
    if (nearest_fixed_vertex(r, request, point, spokes) < limits.shortest) {
        candidate.rejected = RejectionReason::length;
        return candidate;
    }
    grow_delaunay(r, spokes, max_elements, limits.shortest, request.cavity);
    spokes.set_edges(request);
    candidate.limits.corrections = 16;
    candidate.limits.two_facet_elements = TwoFacetElements::refused;
    candidate.limits.shortest = limits.shortest;
    candidate.limits.min_shape = shape_of_quality(limits.min_quality, D);
    candidate.limits.below_minimum = BelowMinimum::accepted_if_no_worse;
    candidate.limits.bad_quality = limits.bad_quality;
    return candidate;
}

template <int D>
Outcome<Adapted<D>> split(Adaptation<D> state, const AdaptationGoal<D>& goal, const SplitOptions& options,
                          const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    return run_on_edges<D>(std::move(state), goal, Splits<D>(goal, options), execution);
}

namespace {

template <int D>
class Collapses final : public Pass<D> {
  public:
    Collapses(const AdaptationGoal<D>& goal, const CollapseOptions& options) : goal_(goal), options_(options) {}

    [[nodiscard]] double order_of(double length) const { return length < options_.shortest ? length : infinite_order; }

    [[nodiscard]] std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const override {
        const EdgeId edge(std::size_t{task.id});
        if (r.mesh.is_free(edge) || !(length_of(r, edge) < options_.shortest)) return {};
        const auto& [a, b] = r.mesh.edges[edge];
        // The edge collapses to the end for which the worst new shape is better. An end with too long new edges is only
        // tried second.
        std::optional<Candidate<D>> best;
        double best_shape = 0;
        ConeShapes<D> cones(r, goal_);
        for (const auto& [v, w] : {std::pair{a, b}, std::pair{b, a}}) {
            Candidate<D> candidate;
            cavity_around(r.mesh, v, candidate.request.cavity);
            if (!may_collapse(r.mesh, candidate.request.cavity, v, w)) continue;
            cones.clear();
            for (const ElementId e : candidate.request.cavity.elements)
                cones.add(e, local_vertex(r.mesh.elements.vertices[e], v));
            cones.place(cone_point(r, w));
            const bool is_long = creates_long_edge(r, candidate.request.cavity.elements, cones, v, w);
            if (is_long && best) continue;
            const double least = best && best->rejected == RejectionReason::none ? best_shape : 0;
            const double shape = is_long ? 0 : cones.worst(least, w);
            if (best && best->rejected == RejectionReason::none && !(shape > best_shape)) continue;
            candidate.request.join_to(r, w);
            if (is_long)
                candidate.rejected = RejectionReason::length;
            else if (!(shape > 0))
                candidate.rejected = RejectionReason::volume;
            candidate.limits.longest = options_.longest;
            candidate.limits.min_shape = shape_of_quality(options_.min_quality, D);
            candidate.limits.below_minimum = BelowMinimum::accepted_if_no_worse;
            candidate.limits.corrections = 0;
            candidate.limits.bend_around = options_.bend_around;
            candidate.limits.two_facet_elements = TwoFacetElements::refused;
            candidate.limits.facet_distance = options_.distance;
            best_shape = shape;
            best = std::move(candidate);
        }
        return best;
    }
    [[nodiscard]] static bool is_cached_rejection(const Adaptation<D>& r, EdgeId e) {
        return r.rejection_cache.is_rejected(CachedPass::collapse, e, std::span(r.mesh.edges[e]));
    }
    void refused(Adaptation<D>& r, std::span<const Task> tasks) const override {
        refuse<EdgeTag>(r, CachedPass::collapse, tasks, r.mesh.edges.size());
    }
    void follow(Adaptation<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) override {
        add_edge_tasks(r, changes, [&](double length) { return order_of(length); }, tasks);
    }

  private:
    [[nodiscard]] bool creates_long_edge(const Adaptation<D>& r, const std::vector<ElementId>& around,
                                         ConeShapes<D>& cones, VertexId v, VertexId w) const {
        std::vector<VertexId> beside{w};
        for (const ElementId e : around)
            if (const auto& vertices = r.mesh.elements.vertices[e]; local_vertex(vertices, w) >= 0)
                for (const VertexId x : vertices)
                    if (x != v && x != w) beside.push_back(x);
        const auto corners = cones.vertices();
        for (std::size_t i = 0; i < corners.size(); ++i)
            if (!is_among(beside, corners[i].vertex) && cones.length_to(i) > options_.longest) return true;
        return false;
    }

    const AdaptationGoal<D>& goal_;
    const CollapseOptions& options_;
};

}  // namespace

template <int D>
Outcome<Adapted<D>> collapse(Adaptation<D> state, const AdaptationGoal<D>& goal, const CollapseOptions& options,
                             const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    state.rejection_cache.begin(CachedPass::collapse, {options.shortest, options.longest, options.min_quality,
                                                       options.distance, static_cast<double>(options.bend_around)});
    return run_on_edges<D>(std::move(state), goal, Collapses<D>(goal, options), execution);
}

namespace {

/// A pass that collapses superfluous vertices, which swaps and moves cannot remove:
/// - vertices of bad elements, if the worst element improves;
/// - vertices that cannot reach the geometry, if no element gets worse.
template <int D>
class Removals final : public Pass<D> {
  public:
    Removals(const AdaptationGoal<D>& goal, const MendOptions& options, const Column<VertexId>& off_geometry)
        : goal_(goal),
          target_shape_(shape_of_quality(options.target_quality, D)),
          off_geometry_(off_geometry.begin(), off_geometry.end()) {
        std::ranges::sort(off_geometry_);
    }

    [[nodiscard]] std::vector<Task> tasks(const Adaptation<D>& r) const {
        std::vector<double> orders(r.mesh.points.size(), infinite_order);
        for (std::size_t e = 0; e < r.mesh.elements.size(); ++e) {
            if (r.mesh.is_free(ElementId(e))) continue;
            const double shape = cached_shape_of(r, ElementId(e));
            if (!(shape < target_shape_)) continue;
            for (const VertexId v : r.mesh.elements.vertices[e]) orders[v.index()] = std::min(orders[v.index()], shape);
        }
        for (const VertexId v : off_geometry_) orders[v.index()] = std::min(orders[v.index()], 0.0);
        std::vector<Task> tasks;
        for (std::size_t i = 0; i < orders.size(); ++i) {
            const VertexId v(i);
            if (orders[i] < infinite_order && !r.mesh.is_at_infinity(v) && !is_rejected(r, v))
                tasks.push_back(task(orders[i], v));
        }
        return tasks;
    }
    [[nodiscard]] std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const override {
        const VertexId v(std::size_t{task.id});
        if (r.mesh.is_free(v) || is_rejected(r, v)) return {};
        Candidate<D> candidate;
        auto& [request, limits, rejected] = candidate;
        cavity_around(r.mesh, v, request.cavity);
        const double before = worst_shape_of(r, request.cavity.elements);
        const bool is_off_geometry = std::ranges::binary_search(off_geometry_, v) && is_off(r, request.cavity, v);
        if (!(before < target_shape_) && !is_off_geometry) return {};
        limits.min_shape = gain * before;
        if (is_off_geometry) {
            limits.min_shape = shape_of_quality(min_quality, D);
            limits.below_minimum = BelowMinimum::accepted_if_no_worse;
            limits.facet_cosine = 0.2;  // existing facets may approximate the surface badly
        }
        limits.longest = 2 * longest_unit_edge;
        limits.corrections = 0;
        limits.two_facet_elements = TwoFacetElements::refused;
        limits.facet_distance = 0.2;  // as in `CollapseOptions`
        // Shapes are exact for straight elements, and estimates for curved ones. Candidates below `nearly` times the
        // required shape are not planned.
        const double nearly = r.mesh.is_curved() ? 0.7 : 1;
        const double least = is_off_geometry ? 0 : nearly * std::max(limits.min_shape, 0.0);
        const VertexId into = best_neighbour(r, goal_, request.cavity, v, least);
        if (!into.valid()) return {};
        request.join_to(r, into);
        return candidate;
    }
    void follow(Adaptation<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) override {
        for (const ElementId e : changes.elements.created) add_tasks(r, e, tasks);
    }
    void refused(Adaptation<D>& r, std::span<const Task> tasks) const override {
        refuse<VertexTag>(r, CachedPass::remove, tasks, r.mesh.points.size());
    }

  private:
    static constexpr double gain = 1.02, min_quality = 0.1;

    [[nodiscard]] static bool is_rejected(const Adaptation<D>& r, VertexId v) {
        return r.rejection_cache.is_rejected(CachedPass::remove, v, std::span(&v, 1));
    }
    void add_tasks(const Adaptation<D>& r, ElementId e, std::vector<Task>& tasks) const {
        if (r.mesh.is_free(e)) return;
        const double shape = cached_shape_of(r, e);
        if (!(shape < target_shape_)) return;
        for (const VertexId v : r.mesh.elements.vertices[e])
            if (!r.mesh.is_at_infinity(v)) tasks.push_back(task(shape, v));
    }
    [[nodiscard]] bool is_off(const Adaptation<D>& r, const Cavity<D>& around, VertexId v) const {
        const VertexPlace place = r.mesh.states[v].place;
        if (place != VertexPlace::surface && place != VertexPlace::line) return false;
        const auto foot = foot_of(goal_, r.mesh, around, v, r.vertices.place(v).entity);
        return foot && !is_at_foot(r.mesh, around, r.mesh.points[v], foot->point);
    }

    const AdaptationGoal<D>& goal_;
    double target_shape_;
    std::vector<VertexId> off_geometry_;
};

template <int D>
Outcome<Adapted<D>> remove_vertices(Adaptation<D> state, const AdaptationGoal<D>& goal, const MendOptions& options,
                                    const Execution& execution) {
    state.rejection_cache.begin(CachedPass::remove, {options.target_quality});
    Removals<D> pass(goal, options, state.off_geometry);
    auto statistics = run_pass<D>(state, goal, pass, pass.tasks(state), execution);
    if (!statistics) return fail(statistics.error());
    return Adapted<D>{std::move(state), *statistics};
}

}  // namespace

template <int D>
Outcome<Adapted<D>> mend(Adaptation<D> state, const AdaptationGoal<D>& goal, const MendOptions& options,
                         const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    Adapted<D> out{std::move(state), {}};
    for (int sweep = 0; sweep < options.sweeps; ++sweep) {
        const std::size_t before = out.statistics.accepted;
        auto swapped = swap<D>(std::move(out.state), goal, {.target_quality = options.target_quality}, execution);
        if (!swapped) return fail(swapped.error());
        out.statistics += swapped->statistics;
        auto moved = smooth<D>(std::move(swapped->state), goal, {.target_quality = options.target_quality}, execution);
        if (!moved) return fail(moved.error());
        out.statistics += moved->statistics;
        auto removed = remove_vertices<D>(std::move(moved->state), goal, options, execution);
        if (!removed) return fail(removed.error());
        out.statistics += removed->statistics;
        out.state = std::move(removed->state);
        if (out.statistics.accepted == before) break;
    }
    return out;
}

namespace {

template <int D>
class PassSequence {
  public:
    PassSequence(Adaptation<D> state, const AdaptationGoal<D>& goal, const StepWrapper& around)
        : state_(std::move(state)), goal_(goal), around_(around) {}

    template <class Options>
    using Verb = Outcome<Adapted<D>> (*)(Adaptation<D>, const AdaptationGoal<D>&, const Options&, const Execution&);

    template <class Options>
    [[nodiscard]] Outcome<Done> pass(std::string_view name, Verb<Options> verb, const Options& options,
                                     PassStatistics& statistics) {
        return run_step(around_, name, [&](const Execution& execution) -> Outcome<Done> {
            auto done = verb(std::move(state_), goal_, options, execution);
            if (!done) return fail(done.error());
            state_ = std::move(done->state);
            statistics += done->statistics;
            return Done{};
        });
    }
    [[nodiscard]] Outcome<Done> measure(UnitMeshStatistics& out) const {
        return run_step(around_, "lengths", [&](const Execution& execution) -> Outcome<Done> {
            auto measured = unit_mesh_statistics(state_, execution);
            if (!measured) return fail(measured.error());
            out = *measured;
            return Done{};
        });
    }
    [[nodiscard]] Adaptation<D> state() && { return std::move(state_); }

  private:
    Adaptation<D> state_;
    const AdaptationGoal<D>& goal_;
    const StepWrapper& around_;
};

bool has_converged(const UnitMeshStatistics& before, const UnitMeshStatistics& after, std::size_t changed_vertices,
                   double min_change) {
    const auto vertices = static_cast<double>(after.edges) / 7;  // about 7 edges per vertex in tetrahedra, and fewer in
                                                                 // triangles
    return after.unit_share() - before.unit_share() < min_change &&
           static_cast<double>(changed_vertices) < min_change * vertices;
}

template <int D>
Outcome<RemeshResult<D>> driven(Adaptation<D> state, const AdaptationGoal<D>& goal, const ToMetricOptions& options,
                                const StepWrapper& around) {
    PassSequence<D> driving(std::move(state), goal, around);
    ToMetricStatistics s;
    if (auto begin = driving.measure(s.before); !begin) return fail(begin.error());
    s.after = s.before;
    bool is_converged = false;
    CollapseOptions relaxed_options = options.collapse;
    relaxed_options.longest = std::max(relaxed_options.longest, options.early_collapse_longest);
    SplitOptions early_split = options.split;
    early_split.longest = std::max(early_split.longest, options.early_split_longest);
    early_split.shortest = std::max(early_split.shortest, options.early_split_shortest);
    bool is_last = false;
    while (!is_last && s.rounds < options.rounds) {
        is_last = is_converged || s.rounds + 1 == options.rounds;
        const UnitMeshStatistics before = s.after;
        const std::size_t changes = s.collapse.accepted + s.split.accepted;
        const auto done =
            driving.pass("collapse", &collapse<D>, is_last ? options.collapse : relaxed_options, s.collapse)
                .and_then([&](Done) {
                    return driving.pass("split", &split<D>, is_last ? options.split : early_split, s.split);
                })
                .and_then([&](Done) { return driving.pass("swap", &swap<D>, options.swap, s.swap); })
                .and_then([&](Done) { return driving.pass("smooth", &smooth<D>, options.smooth, s.smooth); })
                .and_then([&](Done) { return driving.measure(s.after); });
        if (!done) return fail(done.error());
        ++s.rounds;
        is_converged =
            has_converged(before, s.after, s.collapse.accepted + s.split.accepted - changes, options.min_change);
    }
    const auto mended = driving.pass("improve", &mend<D>, options.mend, s.mend).and_then([&](Done) {
        return driving.measure(s.after);
    });
    if (!mended) return fail(mended.error());
    return RemeshResult<D>{std::move(driving).state(), s};
}

}  // namespace

template <int D>
Outcome<RemeshResult<D>> remesh_to_metric(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                          const ToMetricOptions& options, const StepWrapper& around) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    return guarded([&] { return driven(std::move(state), goal, options, around); });
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template std::optional<Candidate<D>> split_candidate<D>(const Adaptation<D>&, const AdaptationGoal<D>&, EdgeId, \
                                                            double, const SplitLimits&);                            \
    template Outcome<Adapted<D>> split<D>(Adaptation<D>, const AdaptationGoal<D>&, const SplitOptions&,             \
                                          const Execution&);                                                        \
    template Outcome<Adapted<D>> collapse<D>(Adaptation<D>, const AdaptationGoal<D>&, const CollapseOptions&,       \
                                             const Execution&);                                                     \
    template Outcome<Adapted<D>> mend<D>(Adaptation<D>, const AdaptationGoal<D>&, const MendOptions&,               \
                                         const Execution&);                                                         \
    template Outcome<RemeshResult<D>> remesh_to_metric<D>(Adaptation<D>, const AdaptationGoal<D>&,                  \
                                                          const ToMetricOptions&, const StepWrapper&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
