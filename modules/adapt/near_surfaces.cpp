// Moves vertices to the geometry, and refines the boundary to distance bounds.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>
module camber.adapt;
import camber.core;
import camber.cavity;
import camber.metric;
import camber.surface;
import camber.operation;

namespace camber {

namespace {

template <int D>
class Snaps final : public Pass<D> {
  public:
    explicit Snaps(const AdaptationGoal<D>& goal) : goal_(goal) {}

    [[nodiscard]] std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const override {
        return candidate_at(r, task, 1);
    }
    [[nodiscard]] std::optional<Candidate<D>> shortened(const Adaptation<D>& r, const Task& task,
                                                        double share) const override {
        return share > 0 ? candidate_at(r, task, share) : std::nullopt;
    }
    void follow(Adaptation<D>&, const TopologyChanges&, std::vector<Task>&) override {}

  private:
    [[nodiscard]] std::optional<Candidate<D>> candidate_at(const Adaptation<D>& r, const Task& task,
                                                           double share) const {
        const VertexId v(std::size_t{task.id});
        if (v.index() >= r.mesh.points.size() || r.mesh.is_free(v)) return {};
        const VertexState& state = r.mesh.states[v];
        if (state.place != VertexPlace::surface && state.place != VertexPlace::line) return {};
        if (state.marks.has(Mark::required) || state.marks.has(Mark::frozen)) return {};
        Candidate<D> candidate;
        CavityRequest<D>& request = candidate.request;
        cavity_of_vertex(r.mesh, v, request.cavity);
        const Vec<D> here = r.mesh.points[v];
        const std::optional<SurfacePoint<D>> foot =
            foot_of(goal_, r.mesh, request.cavity, v, r.vertices.place(v).entity);
        if (!foot || is_at_foot(r.mesh, request.cavity, here, foot->point)) return {};
        request.point = v;
        request.place = here + share * (foot->point - here);
        request.geometry_position = place_after(share, *foot);
        request.share = share;
        sample_field(r, goal_, r.vertices.metrics[v].back, request);
        candidate.limits.min_shape = shape_of_quality(min_quality, D);
        candidate.limits.below_minimum = BelowMinimum::accepted_if_no_worse;
        candidate.limits.facet_cosine = 0.2;  // existing facets may approximate the surface badly
        candidate.limits.corrections = 16;
        return candidate;
    }

    static constexpr double min_quality = 0.05;
    const AdaptationGoal<D>& goal_;
};

}  // namespace

template <int D>
Outcome<PassStatistics> snap_to_geometry(Adaptation<D>& r, const AdaptationGoal<D>& goal, const Execution& execution) {
    PassStatistics all;
    if (!goal.geometry) return all;
    constexpr int max_turns = 8;  // after a move, neighbours may be able to move farther
    Snaps<D> pass(goal);
    for (int turn = 0; turn < max_turns && !r.off_geometry.empty(); ++turn) {
        const Buffer<VertexId> off_geometry = take(std::exchange(r.off_geometry, {}));
        std::vector<Task> tasks;
        tasks.reserve(off_geometry.size());
        for (const VertexId v : off_geometry) tasks.push_back(task(0, v));
        auto statistics = run_pass<D>(r, goal, pass, std::move(tasks), execution);
        if (!statistics) return statistics;
        all += *statistics;
        Buffer<VertexId> left;
        for (const VertexId v : off_geometry)
            if (pass.candidate(r, task(0, v))) left.push_back(v);
        r.off_geometry = std::move(left);
        if (statistics->accepted == 0) break;
    }
    return all;
}

namespace {

/// Operations that bring a facet nearer to the geometry:
/// - `snap`: moves a corner onto the geometry.
/// - `remove`: collapses a corner that is off the geometry.
/// - `clear`: collapses any corner.
/// - `split`, `swap`: splits or swaps an edge.
enum class Approach { snap, remove, clear, split, swap };

/// Limits of operations on facets beyond their bounds. They are relaxed if a round makes no progress.
struct Concessions {
    TwoFacetElements walls = TwoFacetElements::refused;
    double min_quality = 0;      ///< minimum quality of new elements, unless removed ones are worse
    double shortest_part = 0.3;  ///< minimum length of new edges relative to the split edge
    bool is_last = false;        ///< the limits cannot be relaxed further
    double shortest = 0;
};

struct FarFacetsSum {
    std::size_t count = 0;
    double excess = 0;
};

/// A pass with one operation for each facet beyond its distance bound. The farthest facet is first.
template <int D>
class FarFacets final : public Pass<D> {
  public:
    FarFacets(const AdaptationGoal<D>& goal, const SplitOptions& options, Approach approach, const Concessions& may)
        : goal_(goal), options_(options), approach_(approach), may_(may) {}

    [[nodiscard]] Outcome<std::vector<Task>> tasks(const Adaptation<D>& r, const Execution& execution) const {
        return reduce_each(
            execution, r.mesh.facets.size(), std::vector<Task>{},
            [&](std::vector<Task>& tasks, std::size_t f) { add_task(r, FacetId(f), tasks); },
            [](std::vector<Task> a, std::vector<Task> b) {
                a.insert(a.end(), b.begin(), b.end());
                return a;
            });
    }
    [[nodiscard]] std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const override {
        const FacetId f(std::size_t{task.id});
        if (!is_judged(r, f)) return {};
        const BoundShares<D> shares = bound_shares(r, goal_, f);
        if (!(shares.largest() > 1)) return {};
        if (approach_ == Approach::snap || approach_ == Approach::remove) return vertex_of(r, f);
        if (approach_ == Approach::clear) return corner_of(r, f);
        std::optional<Candidate<D>> refused;
        for (const EdgeId edge : edges_to_try(r, f, shares)) {
            auto candidate = approach_ == Approach::split ? split_of(r, edge) : swap_of(r, edge);
            if (!candidate) continue;
            if (candidate->rejected == RejectionReason::none) return candidate;
            if (!refused) refused = std::move(candidate);
        }
        return refused;
    }
    void follow(Adaptation<D>&, const TopologyChanges&, std::vector<Task>&) override {}
    /// Number of facets beyond their bounds, and the sum of distance divided by bound (`bound_shares`) over them,
    /// weighted by area (2D: length). Errors: stopped.
    [[nodiscard]] Outcome<FarFacetsSum> sum(const Adaptation<D>& r, const Execution& execution) const {
        return reduce_each(
            execution, r.mesh.facets.size(), FarFacetsSum{},
            [&](FarFacetsSum& sum, std::size_t i) {
                const FacetId f(i);
                if (!is_judged(r, f)) return;
                const double share = bound_shares(r, goal_, f).largest();
                if (!(share > 1)) return;
                ++sum.count;
                sum.excess += share * norm(facet_normal(corners_of(r.mesh, f)));
            },
            [](const FarFacetsSum& a, const FarFacetsSum& b) {
                return FarFacetsSum{a.count + b.count, a.excess + b.excess};
            });
    }

  private:
    [[nodiscard]] static bool is_judged(const Adaptation<D>& r, FacetId f) {
        return !r.mesh.is_free(f) && !r.mesh.is_at_infinity(f) && r.mesh.sides[f][0].valid();
    }
    void add_task(const Adaptation<D>& r, FacetId f, std::vector<Task>& tasks) const {
        if (!is_judged(r, f)) return;
        if (const double share = bound_shares(r, goal_, f).largest(); share > 1) tasks.push_back(task(-share, f));
    }
    /// Edges in the order in which they are tried: those beyond the bound, the farthest first, then the others, the
    /// longest first.
    [[nodiscard]] static std::array<EdgeId, edges_per_simplex<D - 1>> edges_to_try(const Adaptation<D>& r, FacetId f,
                                                                                   const BoundShares<D>& shares) {
        struct Choice {
            double excess = 0, length = 0;
            EdgeId edge;
        };
        std::array<Choice, edges_per_simplex<D - 1>> choices;
        for (std::size_t e = 0; e < choices.size(); ++e) {
            const EdgeId edge = local_facet_edge(r.mesh, f, static_cast<int>(e));
            choices[e] = {std::max(shares.edges[e], 1.0), length_of(r, edge), edge};
        }
        std::ranges::stable_sort(choices, [](const Choice& a, const Choice& b) {
            return a.excess != b.excess ? a.excess > b.excess : a.length > b.length;
        });
        std::array<EdgeId, edges_per_simplex<D - 1>> edges;
        for (std::size_t e = 0; e < edges.size(); ++e) edges[e] = choices[e].edge;
        return edges;
    }
    [[nodiscard]] std::optional<Candidate<D>> vertex_of(const Adaptation<D>& r, FacetId f) const {
        for (const VertexId v : r.mesh.facets.vertices[f]) {
            const VertexState& state = r.mesh.states[v];
            if (state.place != VertexPlace::surface && state.place != VertexPlace::line) continue;
            if (state.marks.has(Mark::required) || state.marks.has(Mark::frozen)) continue;
            Candidate<D> candidate;
            CavityRequest<D>& request = candidate.request;
            cavity_of_vertex(r.mesh, v, request.cavity);
            const auto foot = foot_of(goal_, r.mesh, request.cavity, v, r.vertices.place(v).entity);
            if (!foot || is_at_foot(r.mesh, request.cavity, r.mesh.points[v], foot->point)) continue;
            candidate.limits.min_shape = shape_of_quality(may_.min_quality, D);
            candidate.limits.below_minimum = BelowMinimum::accepted_if_no_worse;
            candidate.limits.facet_cosine = any_cosine;
            candidate.limits.corrections = 16;
            if (approach_ == Approach::snap) {
                request.point = v;
                request.place = foot->point;
                request.geometry_position = place_of(*foot);
                sample_field(r, goal_, r.vertices.metrics[v].back, request);
                return candidate;
            }
            if (const VertexId into = best_neighbour(r, goal_, request.cavity, v, 0); into.valid()) {
                request.join_to(r, into);
                return candidate;
            }
        }
        return {};
    }
    [[nodiscard]] std::optional<Candidate<D>> corner_of(const Adaptation<D>& r, FacetId f) const {
        for (const VertexId v : r.mesh.facets.vertices[f]) {
            const VertexState& state = r.mesh.states[v];
            if (state.place != VertexPlace::surface || state.marks.has(Mark::required) || state.marks.has(Mark::frozen))
                continue;
            Candidate<D> candidate;
            cavity_of_vertex(r.mesh, v, candidate.request.cavity);
            const VertexId into = best_neighbour(r, goal_, candidate.request.cavity, v, 0);
            if (!into.valid()) continue;
            candidate.request.join_to(r, into);
            candidate.limits.min_shape = shape_of_quality(may_.min_quality, D);
            candidate.limits.below_minimum = BelowMinimum::accepted_if_no_worse;
            candidate.limits.facet_cosine = least_cosine;
            candidate.limits.two_facet_elements = may_.walls;
            candidate.limits.corrections = 16;
            return candidate;
        }
        return {};
    }
    [[nodiscard]] std::optional<Candidate<D>> split_of(const Adaptation<D>& r, EdgeId edge) const {
        const double shortest =
            std::max(may_.shortest, std::min(options_.shortest, may_.shortest_part * length_of(r, edge)));
        auto candidate = split_candidate(r, goal_, edge, 1, {shortest, may_.min_quality});
        if (!candidate) return candidate;
        candidate->limits.facet_cosine = least_cosine;
        candidate->limits.two_facet_elements = may_.walls;
        return candidate;
    }
    [[nodiscard]] std::optional<Candidate<D>> swap_of(const Adaptation<D>& r, EdgeId edge) const {
        if constexpr (D == 2) {
            return {};
        } else {
            if (r.mesh.line_at(edge).valid()) return {};
            const auto [element, local] = element_with_edge(r.mesh, edge);
            if (!element.valid()) return {};
            Candidate<D> candidate;
            Cavity<D>& cavity = candidate.request.cavity;
            cavity_of_edge(r.mesh, element, local, cavity);
            const auto& [a, b] = r.mesh.edges[edge];
            ConeShapes<D> cones(r, goal_);
            for (const ElementId s : cavity.elements)
                for (const VertexId v : {a, b}) cones.add(s, local_vertex(r.mesh.elements.vertices[s], v));
            VertexId best;
            double best_shape = 0;
            for (const FacetId f : cavity.facets)
                for (const VertexId p : r.mesh.facets.vertices[f]) {
                    if (p == a || p == b || r.mesh.is_at_infinity(p)) continue;
                    if (const double shape = cones.worst_at(cone_point(r, p), best_shape, p); shape > best_shape) {
                        best_shape = shape;
                        best = p;
                    }
                }
            if (!best.valid()) return {};
            candidate.request.join_to(r, best);
            candidate.limits.facet_cosine = follows_surface(r, cavity, {a, b}) ? any_cosine : least_cosine;
            candidate.limits.min_shape = shape_of_quality(may_.min_quality, D);
            candidate.limits.below_minimum = BelowMinimum::accepted_if_no_worse;
            candidate.limits.corrections = 16;
            candidate.limits.two_facet_elements = may_.walls;
            return candidate;
        }
    }

    /// True if the normals of both new facets are near those of the surface. The sign is that of the old facet that
    /// follows the surface better.
    [[nodiscard]] bool follows_surface(const Adaptation<D>& r, const Cavity<D>& cavity,
                                       const std::array<VertexId, 2>& ends) const
        requires(D == 3)
    {
        constexpr double least_along = 0.5;
        if (cavity.facets.size() != 2) return false;
        const auto apart = [&](FacetId f) {
            const auto& vertices = r.mesh.facets.vertices[f];
            return *std::ranges::find_if(vertices, [&](VertexId v) { return v != ends[0] && v != ends[1]; });
        };
        const auto along = [&](const std::array<Vec<3>, 3>& corners) {
            const FacetSite<3> site{{}, r.mesh.facets.references[cavity.facets[0]], corners};
            const auto normals = (*goal_.geometry)->normals_at(site);
            const Vec<3> n = facet_normal(corners);
            double least = 1;
            double sign = 0;
            if (!normals || !(norm(n) > 0)) return 0.0;
            for (const Vec<3>& normal : *normals) {
                const double cosine = dot(n, normal) / norm(n);
                least = std::min(least, std::abs(cosine));
                sign += cosine;
            }
            return std::copysign(least, sign);
        };
        const Vec<3>&a = r.mesh.points[ends[0]], &b = r.mesh.points[ends[1]];
        const Vec<3>&c = r.mesh.points[apart(cavity.facets[0])], &d = r.mesh.points[apart(cavity.facets[1])];
        const double of_c = along({a, b, c}), of_d = along({b, a, d});
        const double side = std::abs(of_c) > std::abs(of_d) ? of_c : of_d;
        return along({a, d, c}) * std::copysign(1.0, side) > least_along &&
               along({b, c, d}) * std::copysign(1.0, side) > least_along;
    }

    static constexpr double any_cosine = -2;
    static constexpr double least_cosine = 0;
    const AdaptationGoal<D>& goal_;
    const SplitOptions& options_;
    Approach approach_;
    Concessions may_;
};

template <int D>
Outcome<PassStatistics> approach(Adaptation<D>& r, const AdaptationGoal<D>& goal, const SplitOptions& options,
                                 Approach by, const Concessions& may, const Execution& execution) {
    FarFacets<D> pass(goal, options, by, may);
    auto tasks = pass.tasks(r, without_progress(execution));
    if (!tasks) return fail(tasks.error());
    return run_pass<D>(r, goal, pass, std::move(*tasks), execution);
}

Concessions first_concessions(const SplitOptions& options, BoundaryEffort effort) {
    constexpr double least_quality = 0.2, shortest = 0.35;
    if (effort == BoundaryEffort::any) return {.min_quality = options.min_quality};
    return {.min_quality = std::max(options.min_quality, least_quality), .is_last = true, .shortest = shortest};
}

template <int D>
Outcome<RemeshResult<D>> refine_within_bounds(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                              const ToMetricOptions& options, BoundaryEffort effort,
                                              const StepWrapper& around) {
    RemeshResult<D> out{std::move(state), {}};
    ToMetricStatistics& s = out.statistics;
    Concessions may = first_concessions(options.split, effort);
    const auto far = [&](std::string_view name, Approach by, PassStatistics& statistics) {
        return run_step(around, name, [&](const Execution& execution) -> Outcome<Done> {
            auto done = approach(out.state, goal, options.split, by, may, execution);
            if (!done) return fail(done.error());
            statistics += *done;
            return Done{};
        });
    };
    const auto pass = [&](std::string_view name, auto verb, const auto& by, PassStatistics& statistics) {
        return run_step(around, name, [&](const Execution& execution) -> Outcome<Done> {
            auto done = verb(std::move(out.state), goal, by, execution);
            if (!done) return fail(done.error());
            out.state = std::move(done->state);
            statistics += done->statistics;
            return Done{};
        });
    };
    double excess = std::numeric_limits<double>::infinity();
    for (; s.rounds < max_bound_rounds; ++s.rounds) {
        const auto sum = run_step(around, "distances", [&](const Execution& execution) {
            return FarFacets<D>(goal, options.split, Approach::split, may).sum(out.state, execution);
        });
        if (!sum) return fail(sum.error());
        // Each round should halve edges. If the excess does not decrease, limits are relaxed. First, straight meshes
        // may get two-facet elements; then, elements need only be valid. If it still does not decrease, the loop ends,
        // because smaller facets do not help.
        constexpr double least_progress = 0.9, shortest_part = 0.1;
        const bool stays = sum->excess > least_progress * excess;
        if (sum->count == 0 || (stays && may.is_last)) break;
        if (stays && may.walls == TwoFacetElements::refused && !out.state.mesh.is_curved())
            may.walls = TwoFacetElements::accepted;
        else if (stays)
            may = {may.walls, 0, shortest_part, true};
        excess = sum->excess;
        if (s.rounds > 1)
            if (auto cleared = far("improve", Approach::clear, s.mend); !cleared) return fail(cleared.error());
        const auto done = far("smooth", Approach::snap, s.smooth)
                              .and_then([&](Done) { return far("improve", Approach::remove, s.mend); })
                              .and_then([&](Done) { return far("split", Approach::split, s.split); })
                              .and_then([&](Done) { return far("swap", Approach::swap, s.swap); })
                              .and_then([&](Done) { return pass("swap", &swap<D>, options.swap, s.swap); })
                              .and_then([&](Done) { return pass("smooth", &smooth<D>, options.smooth, s.smooth); })
                              .and_then([&](Done) { return pass("improve", &mend<D>, options.mend, s.mend); });
        if (!done) return fail(done.error());
    }
    return out;
}

}  // namespace

template <int D>
Outcome<std::size_t> count_far_facets(const Adaptation<D>& r, const AdaptationGoal<D>& goal,
                                      const Execution& execution) {
    const SplitOptions options;
    return FarFacets<D>(goal, options, Approach::split, {}).tasks(r, execution).map([](const std::vector<Task>& tasks) {
        return tasks.size();
    });
}

template <int D>
Outcome<RemeshResult<D>> refine_to_bounds(Adaptation<D> state, const AdaptationGoal<D>& goal,
                                          const ToMetricOptions& options, BoundaryEffort effort,
                                          const StepWrapper& around) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    return guarded([&] { return refine_within_bounds(std::move(state), goal, options, effort, around); });
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template Outcome<PassStatistics> snap_to_geometry<D>(Adaptation<D>&, const AdaptationGoal<D>&, const Execution&); \
    template Outcome<std::size_t> count_far_facets<D>(const Adaptation<D>&, const AdaptationGoal<D>&,                 \
                                                      const Execution&);                                              \
    template Outcome<RemeshResult<D>> refine_to_bounds<D>(Adaptation<D>, const AdaptationGoal<D>&,                    \
                                                          const ToMetricOptions&, BoundaryEffort, const StepWrapper&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
