// Smoothing of vertices and inner nodes.
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
module camber.adapt;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.metric;
import camber.validity;
import camber.surface;
import camber.operation;

namespace camber {

namespace {

// New positions of boundary vertices.

template <int D>
bool stays_in_planes(const DynamicMesh<D>& mesh, const std::vector<FacetId>& facets, const Vec<D>& step) {
    constexpr double parallel = 1e-10;  // allows for rounding of coordinates in thin facets
    return std::ranges::all_of(facets, [&](FacetId f) {
        if (mesh.is_at_infinity(f)) return true;
        const Vec<D> n = facet_normal(corners_of(mesh, f));
        return std::abs(dot(n, step)) <= parallel * norm(n) * norm(step);
    });
}

bool stays_on_lines(const DynamicMesh<3>& mesh, const std::vector<LineId>& lines, const Vec<3>& step) {
    constexpr double parallel = 1e-9;
    return std::ranges::all_of(lines, [&](LineId line) {
        const auto& [a, b] = mesh.edges[mesh.lines[line]];
        const Vec<3> along = mesh.points[b] - mesh.points[a];
        return norm(cross(along, step)) <= parallel * norm(along) * norm(step);
    });
}

template <int D>
struct BoundaryPlace {
    Vec<D> point;
    GeometryPosition geometry_position = {};
};
template <int D>
BoundaryPlace<D> boundary_place(const SurfacePoint<D>& on) {
    return {on.point, place_of(on)};
}

template <int D>
std::optional<BoundaryPlace<D>> place_on_surface(const AdaptationGoal<D>& goal, const DynamicMesh<D>& mesh,
                                                 const Cavity<D>& around, const Vec<D>& here,
                                                 const GeometryEntity& known, const Vec<D>& target) {
    const FacetId f = around.facets.front();
    if (goal.geometry && (*goal.geometry)->has_surface_at(site_of(mesh, f)))
        return boundary_place(on_geometry_at_facet(goal, mesh, f, known, target));
    const Plane<D> plane{here, normalised(facet_normal(corners_of(mesh, f)))};
    const Vec<D> place = slid_within(plane, here, target - here);
    if (!stays_in_planes(mesh, around.facets, place - here)) return {};
    return BoundaryPlace<D>{place};
}

/// Returns a position near `target` on a line edge at `v`, projected to the geometry. The line edge is that along which
/// the step is longer. If there is nothing to project to, `v` moves only along straight lines and planes.
std::optional<BoundaryPlace<3>> place_on_line(const AdaptationGoal<3>& goal, const DynamicMesh<3>& mesh,
                                              const Cavity<3>& around, VertexId v, const Vec<3>& target) {
    if (around.lines.size() != 2) return {};
    const Vec<3> here = mesh.points[v];
    const Vec<3> step = target - here;
    constexpr double most = 0.5;  // largest step as a share of the edge
    std::optional<BoundaryPlace<3>> place;
    double farthest = 0;
    for (const LineId line : around.lines) {
        const EdgeId edge = mesh.lines[line];
        const auto& [a, b] = mesh.edges[edge];
        const Vec<3> along = mesh.points[a == v ? b : a] - here;
        const double share = std::min(dot(step, along) / norm_squared(along), most);
        if (!(share * norm(along) > farthest)) continue;
        farthest = share * norm(along);
        const Vec<3> on_chord = here + share * along;
        std::vector<FacetId> facets;
        facets_with(mesh, around.elements, edge, facets);
        place = boundary_place(on_geometry_at_edge(goal, mesh, edge, facets, on_chord));
        constexpr double rounding = 1e-12;
        const bool is_straight = distance(place->point, on_chord) <= rounding * norm(along);
        if (is_straight && !(stays_in_planes(mesh, around.facets, on_chord - here) &&
                             stays_on_lines(mesh, around.lines, on_chord - here)))
            place.reset();
    }
    return place;
}

/// New position of a vertex that should move to `target`. Empty if it may not move or its surface is unknown.
template <int D>
std::optional<BoundaryPlace<D>> place_for(const AdaptationGoal<D>& goal, const DynamicMesh<D>& mesh,
                                          const Cavity<D>& around, VertexId v, const GeometryEntity& known,
                                          const Vec<D>& target) {
    switch (mesh.states[v].place) {
        case VertexPlace::inside: return BoundaryPlace<D>{target};
        case VertexPlace::surface: return place_on_surface(goal, mesh, around, mesh.points[v], known, target);
        case VertexPlace::line:
            if constexpr (D == 3) return place_on_line(goal, mesh, around, v, target);
            return {};
        case VertexPlace::corner:
        case VertexPlace::infinity: return {};
    }
    return {};
}

template <int D>
class Moves final : public Pass<D> {
  public:
    Moves(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const SmoothOptions& options)
        : goal_(goal),
          target_shape_(target_shape(r, options.target_quality)),
          gain_(shape_of_quality(options.gain, D)),
          poor_(shape_of_quality(0.3, D)),
          worst_(shape_of_quality(0.2, D)) {}

    [[nodiscard]] std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const override {
        const VertexId v(std::size_t{task.id});
        const VertexState& state = r.mesh.states[v];
        if (r.mesh.is_free(v) || !may_move(state)) return {};
        Candidate<D> candidate;
        CavityRequest<D>& request = candidate.request;
        PatchLimits& limits = candidate.limits;
        cavity_around(r.mesh, v, request.cavity);
        const double before = worst_cached_shape_of(r, request.cavity.elements);
        if (!(before < target_shape_)) return {};
        ConeShapes<D> cones(r, goal_);
        fetch_edges_ahead(r, request.cavity.elements);
        for (const ElementId e : request.cavity.elements) cones.add(e, local_vertex(r.mesh.elements.vertices[e], v));
        const std::size_t worst = worst_of(r, request.cavity.elements);
        cones.begin_with(worst);
        cones.place_at(v);
        const Vec<D> centre = centre_of_unit_edges(r, request.cavity, cones, v);  // computed now, while the cones are
                                                                                  // at `v`
        const double here = r.mesh.is_curved() ? cones.worst_shape(v) : std::max(before, 0.0);
        BestPlace best{{}, {}, gain_ * here};
        const double least = best.shape;
        const auto look = [&](const Vec<D>& target, double share) {
            look_at(r, request.cavity, cones, v, r.mesh.points[v] + share * (target - r.mesh.points[v]), best);
            return best.shape > least;
        };
        // The first improvement suffices. Only for bad elements, all positions are tried.
        const bool is_poor = before < poor_;
        for (const double share : {1.0, 0.5, 0.25})
            if (look(centre, share) && !is_poor) break;
        if (is_poor) {
            const Vec<D> apex = apex_over(r, request.cavity.elements[worst], v);
            for (const double share : {1.0, 0.5, 0.25, 0.1}) look(apex, share);
            if (before < worst_) look_around(r, request.cavity, cones, v, best);
        }
        if (!(best.shape > least)) return {};
        request.point = v;
        request.place = best.place.point;
        request.geometry_position = best.place.geometry_position;
        request.metric = best.metric;
        if (r.mesh.is_curved()) sample_field(r, goal_, best.metric.back, request);
        limits.min_shape = gain_ * before;
        limits.corrections = 0;
        return candidate;
    }
    void follow(Adaptation<D>& r, const TopologyChanges& changes, std::vector<Task>&) override {
        compute_shapes<D>(r, changes.elements.created);
    }
    void refused(Adaptation<D>& r, std::span<const Task> tasks) const override {
        refuse<VertexTag>(r, CachedPass::smooth, tasks, r.mesh.points.size());
    }
    [[nodiscard]] std::vector<Task> tasks(const Adaptation<D>& r) const {
        std::vector<std::uint8_t> is_requested(r.mesh.points.size(), 0);
        for (std::size_t e = 0; e < r.mesh.elements.size(); ++e)
            if (!r.mesh.is_free(ElementId(e)) && r.shapes[e] < target_shape_)
                for (const VertexId v : r.mesh.elements.vertices[e]) is_requested[v.index()] = 1;
        std::vector<Task> tasks;
        for (std::size_t i = 0; i < is_requested.size(); ++i) {
            const VertexId v(i);
            if (is_requested[i] != 0 && !r.rejection_cache.is_rejected(CachedPass::smooth, v, std::span(&v, 1)))
                tasks.push_back(task(0, v));
        }
        return tasks;
    }

  private:
    static constexpr double min_length = 0.1, nearly = 0.9;
    [[nodiscard]] static std::size_t worst_of(const Adaptation<D>& r, const std::vector<ElementId>& elements) {
        return static_cast<std::size_t>(
            std::ranges::min_element(elements, {}, [&](ElementId e) { return r.shapes[e.index()]; }) -
            elements.begin());
    }
    struct BestPlace {
        BoundaryPlace<D> place;
        VertexMetric<D> metric;
        double shape = 0;
    };
    [[nodiscard]] static bool may_move(const VertexState& state) {
        return !state.marks.has(Mark::required) && !state.marks.has(Mark::frozen) && state.place != VertexPlace::corner;
    }
    void look_at(const Adaptation<D>& r, const Cavity<D>& around, ConeShapes<D>& cones, VertexId v,
                 const Vec<D>& target, BestPlace& best) const {
        const std::optional<BoundaryPlace<D>> place =
            place_for(goal_, r.mesh, around, v, r.vertices.place(v).entity, target);
        if (!place) return;
        ConePoint<D> point = cone_point(r, v);  // the gradient is not extrapolated: that at `v` is accurate enough
        point.place = place->point;
        // An estimate with the metric at `v` excludes bad positions, for which the field is then not sampled.
        if (!r.mesh.is_surface() && cones.first_shape_near(point) < nearly * best.shape) return;
        const VertexMetric<D> metric = metric_near(r, v, place->point);
        point.metric = &metric;
        cones.place_near(point);
        const double shape = cones.worst(best.shape);
        if (shape > best.shape) best = {*place, metric, shape};
    }
    /// Metric at a position near `v`, in degree 2 extrapolated with the gradient. The final position gets a sample of
    /// the field (`sample_field`).
    [[nodiscard]] VertexMetric<D> metric_near(const Adaptation<D>& r, VertexId v, const Vec<D>& place) const {
        const VertexMetric<D>& here = r.vertices.metrics[v];
        if (r.mesh.is_curved()) {
            LogMetric<D> log_metric = here.log_metric;
            const Vec<D> step = place - r.mesh.points[v];
            for (int c = 0; c < D; ++c) log_metric.l += step[c] * r.vertices.gradients[v][c];
            return VertexMetric<D>(log_metric, here.back);
        }
        const FieldSample<D> sample = sample_value(goal_.field, place, here.back);
        return VertexMetric<D>(sample.log_metric, sample.location.element);
    }
    /// Tries steps in both directions along each axis of v's metric, because the neighbours and the worst element may
    /// not show where to move.
    void look_around(const Adaptation<D>& r, const Cavity<D>& around, ConeShapes<D>& cones, VertexId v,
                     BestPlace& best) const {
        for (const Vec<D>& row : r.vertices.metrics[v].measure.rows) {
            const Vec<D> unit = row / norm_squared(row);  // of unit length in the metric, because the rows are
                                                          // orthogonal
            for (const double length : {0.5, 0.25, 0.1, -0.1, -0.25, -0.5})
                look_at(r, around, cones, v, r.mesh.points[v] + length * unit, best);
        }
    }
    /// The position of `v` for which the element is regular in v's metric.
    [[nodiscard]] static Vec<D> apex_over(const Adaptation<D>& r, ElementId e, VertexId v) {
        const auto& vertices = r.mesh.elements.vertices[e];
        if constexpr (D == 3)
            if (r.mesh.is_surface()) return apex_over_edge(r, triangle_of(vertices), v);
        const auto& rows = r.vertices.metrics[v].measure.rows;
        std::array<Vec<D>, D> face;
        Vec<D> centre{};
        const auto outward = face_opposite<D>(local_vertex(vertices, v));
        for (int i = 0; i < D; ++i) {
            const Vec<D>& p = r.mesh.points[vertices[outward[i]]];
            centre += p / D;
            for (int k = 0; k < D; ++k) face[i][k] = dot(rows[k], p - r.mesh.points[v]);
        }
        // The origin is v, which is on the inner side of the face.
        Vec<D> n = facet_normal(face);
        if (dot(n, face[0]) > 0) n *= -1.0;
        const double height = std::sqrt((D + 1.0) / (2.0 * D)) / norm(n);
        // The rows are orthogonal, so the inverse of the coordinate map divides by their squared norms.
        for (int k = 0; k < D; ++k) centre += (height * n[k] / norm_squared(rows[k])) * rows[k];
        return centre;
    }
    [[nodiscard]] static Vec<3> apex_over_edge(const Adaptation<3>& r, const std::array<VertexId, 3>& triangle,
                                               VertexId v) {
        const int local = local_vertex(triangle, v);
        const Vec<3>& a = r.mesh.points[triangle[(local + 1) % 3]];
        const Vec<3>& b = r.mesh.points[triangle[(local + 2) % 3]];
        const Vec<3>& here = r.mesh.points[v];
        const auto& rows = r.vertices.metrics[v].measure.rows;
        const auto in_metric = [&](const Vec<3>& x) {
            return Vec<3>{{dot(rows[0], x), dot(rows[1], x), dot(rows[2], x)}};
        };
        // The direction is that of the triangle's existing height, the length that of a regular triangle's height.
        const Vec<3> edge = in_metric(b - a);
        const double share = dot(edge, in_metric(here - a)) / norm_squared(edge);
        const Vec<3> height = here - (a + share * (b - a));
        return midpoint(a, b) + (std::sqrt(3.0) / 2 * norm(edge) / norm(in_metric(height))) * height;
    }
    /// Mean over the edges at `v` of the position of `v` that would give the edge unit length. The weight is the number
    /// of elements (surface: facets) at the edge. A boundary vertex uses only edges of its facets, a line vertex only
    /// its lines.
    [[nodiscard]] static Vec<D> centre_of_unit_edges(const Adaptation<D>& r, const Cavity<D>& around,
                                                     ConeShapes<D>& cones, VertexId v) {
        const Vec<D> here = r.mesh.points[v];
        Vec<D> sum{};
        double weights = 0;
        const auto corners = cones.vertices();
        const auto add = [&](std::size_t i, double weight) {
            const double length = cones.length_to(i);
            if (!(length > min_length)) return;  // short edges would give positions far from all others
            // The end of the tangent replaces the other end of a curved edge.
            const Vec<D> end = r.mesh.is_curved() ? here + cones.tangent_to(i) : corners[i].place;
            sum += weight * (end + (1 / length) * (here - end));
            weights += weight;
        };
        const auto add_others = [&](const auto& simplex) {
            for (const VertexId w : simplex)
                if (w != v)
                    add(static_cast<std::size_t>(std::ranges::find(corners, w, &ConeShapes<D>::Corner::vertex) -
                                                 corners.begin()),
                        1);
        };
        switch (r.mesh.states[v].place) {
            case VertexPlace::inside:
                for (std::size_t i = 0; i < corners.size(); ++i) add(i, corners[i].faces);
                break;
            case VertexPlace::surface:
                for (const FacetId f : around.facets) add_others(r.mesh.facets.vertices[f]);
                break;
            case VertexPlace::line:
                for (const LineId l : around.lines) add_others(r.mesh.edges[r.mesh.lines[l]]);
                break;
            case VertexPlace::corner:
            case VertexPlace::infinity: break;
        }
        return weights > 0 ? sum / weights : here;
    }

    const AdaptationGoal<D>& goal_;
    double target_shape_, gain_, poor_, worst_;  ///< on the scale of `shape_of`
};

}  // namespace

template <int D>
Outcome<Adapted<D>> smooth(Adaptation<D> state, const AdaptationGoal<D>& goal, const SmoothOptions& options,
                           const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    return guarded([&]() -> Outcome<Adapted<D>> {
        const auto snap = snap_to_geometry(state, goal, without_progress(execution));
        if (!snap) return fail(snap.error());
        if (auto known = compute_shapes(state, without_progress(execution)); !known) return fail(known.error());
        state.rejection_cache.begin(CachedPass::smooth, {options.target_quality, options.gain});
        Moves<D> pass(state, goal, options);
        Adapted<D> out{std::move(state), *snap};
        for (int sweep = 0; sweep < options.sweeps; ++sweep) {
            auto statistics = run_pass<D>(out.state, goal, pass, pass.tasks(out.state), execution);
            if (!statistics) return fail(statistics.error());
            out.statistics += *statistics;
            if (statistics->accepted == 0) break;
        }
        if (options.nodes == SmoothedNodes::distortion) {
            const auto moves = smooth_nodes(out.state, options, execution);
            if (!moves) return fail(moves.error());
            out.statistics.moved_nodes += moves->moved;
        }
        return out;
    });
}

namespace {

template <int D>
std::vector<std::uint8_t> fixed_edges(const DynamicMesh<D>& mesh) {
    std::vector<std::uint8_t> fixed(mesh.edges.size(), 0);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
        if (mesh.is_free(ElementId(e))) continue;
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            if (is_node_fixed(mesh, ElementId(e), k)) fixed[mesh.edges_of[ElementId(e)][k].index()] = 1;
    }
    return fixed;
}

template <int D>
Incidence<ElementId> free_shells(const DynamicMesh<D>& mesh) {
    const std::vector<std::uint8_t> fixed = fixed_edges(mesh);
    Buffer<std::uint32_t> offsets(mesh.edges.size() + 1, 0);
    const auto each_free = [&](const auto& visit) {
        for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
            if (mesh.is_free(ElementId(e))) continue;
            for (const EdgeId edge : mesh.edges_of[e])
                if (fixed[edge.index()] == 0) visit(edge, ElementId(e));
        }
    };
    each_free([&](EdgeId edge, ElementId) { ++offsets[edge.index() + 1]; });
    for (std::size_t i = 1; i < offsets.size(); ++i) offsets[i] += offsets[i - 1];
    Buffer<ElementId> items(offsets.back());
    std::vector<std::uint32_t> next(offsets.begin(), offsets.end() - 1);
    each_free([&](EdgeId edge, ElementId e) { items[next[edge.index()]++] = e; });
    return {std::move(offsets), std::move(items)};
}

template <int D>
class NodeSweeps {
  public:
    NodeSweeps(Adaptation<D>& r, double target)
        : r_(r), target_shape_(target), shells_(free_shells(r.mesh)), schedule_(r.mesh.elements.size()) {
        for (std::size_t e = 0; e < r.mesh.edges.size(); ++e)
            if (!shells_[e].empty()) edges_.emplace_back(e);
        std::ranges::sort(edges_, {}, [](EdgeId e) { return spread_rank(e); });
        touched_.assign(r.mesh.elements.size(), 1);
    }
    [[nodiscard]] Outcome<NodeMoves> sweep(const Execution& execution) {
        std::vector<EdgeId> now;
        now.reserve(edges_.size());
        for (const EdgeId e : edges_)
            if (std::ranges::any_of(shells_[e], [&](ElementId s) { return touched_[s.index()] != 0; }))
                now.push_back(e);
        touched_.assign(touched_.size(), 0);
        NodeMoves moves;
        auto done = run_in_rounds(
            schedule_, std::move(now), execution, [](EdgeId) { return false; },
            [&](EdgeId e) { return Claim(shells_[e]); },
            [&](std::span<const EdgeId> edges) { return move_all(edges, execution, moves); });
        if (!done) return fail(done.error());
        return moves;
    }

  private:
    struct Tried {
        bool has_reason = false;
        std::optional<JudgedNode<D>> moved;
    };

    /// Precondition: no two edges share an element.
    [[nodiscard]] Outcome<bool> move_all(std::span<const EdgeId> edges, const Execution& execution, NodeMoves& moves) {
        constexpr std::size_t grain = 16;  // an edge takes tens of microseconds
        std::vector<Tried> tried(edges.size());
        const auto done = each_chunk(
            without_progress(execution), edges.size(),
            [&](std::size_t begin, std::size_t end) {
                NodeShell<D> shell;
                for (std::size_t i = begin; i < end; ++i) tried[i] = move(edges[i], shell);
            },
            grain);
        if (!done) return fail(done.error());
        std::vector<JudgedNode<D>> moved;
        for (std::size_t i = 0; i < edges.size(); ++i) {
            moves.tried += tried[i].has_reason ? 1 : 0;
            if (!tried[i].moved) continue;
            moved.push_back(*tried[i].moved);
            for (const ElementId e : shells_[edges[i]]) touched_[e.index()] = 1;
        }
        moves.moved += moved.size();
        r_ = commit<D>(std::move(r_), moved);
        return true;
    }
    [[nodiscard]] Tried move(EdgeId edge, NodeShell<D>& shell) const {
        gather(edge, shell);
        const auto& [a, b] = r_.mesh.edges[edge];
        shell.begin(r_.mesh.nodes[edge].point,
                    LogMetric<D>{0.5 * (r_.vertices.metrics[a].log_metric.l + r_.vertices.metrics[b].log_metric.l)});
        const NodePlace<D> here = shell.at({});
        if (!(here.worst > 0 && here.worst < target_shape_) || !bound(shell)) return {};
        NodePlace<D> there = shell.better(here);
        for (int halving = 0; halving < 6 && is_gain(here, there); ++halving) {
            if (auto moved = shell.judged(edge, there.point)) return {true, moved};
            there = shell.at(0.5 * there.y);
        }
        return {true, {}};
    }
    [[nodiscard]] static bool is_gain(const NodePlace<D>& here, const NodePlace<D>& there) {
        constexpr double least = 1e-3;
        return there.worst >= here.worst && there.sum < (1 - least) * here.sum;
    }
    void gather(EdgeId edge, NodeShell<D>& shell) const {
        shell.elements.clear();
        for (const ElementId e : shells_[edge]) {
            DistortedElement<D>& element = shell.elements.emplace_back();
            VertexLogMetrics<D> logs;
            const auto& vertices = r_.mesh.elements.vertices[e];
            for (int i = 0; i <= D; ++i) {
                element.nodes[i] = r_.mesh.points[vertices[i]];
                logs[i] = r_.vertices.metrics[vertices[i]].log_metric;
            }
            for (int k = 0; k < edges_per_simplex<D>; ++k) {
                const EdgeId of_element = r_.mesh.edges_of[e][k];
                element.nodes[D + 1 + k] = r_.mesh.nodes[of_element].point;
                if (of_element == edge) element.node = D + 1 + k;
            }
            element.metric = element_metric<D>(logs);
        }
    }
    [[nodiscard]] static bool bound(NodeShell<D>& shell) {
        return std::ranges::all_of(shell.elements, [](DistortedElement<D>& e) {
            for (const double bound : {PatchLimits{}.min_jacobian, 0.0}) {
                e.bound = bound;
                if (decide(NodalSimplex<D>{e.nodes}, bound) == Verdict::valid) return true;
            }
            return false;
        });
    }

    Adaptation<D>& r_;
    double target_shape_;
    Incidence<ElementId> shells_;
    Schedule schedule_;
    std::vector<EdgeId> edges_;
    std::vector<std::uint8_t> touched_;
};

}  // namespace

template <int D>
Outcome<NodeMoves> smooth_nodes(Adaptation<D>& r, const SmoothOptions& options, const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    if (!r.mesh.is_curved()) return NodeMoves{};
    return guarded([&]() -> Outcome<NodeMoves> {
        NodeSweeps<D> sweeps(r, options.target_quality);
        NodeMoves all;
        for (int sweep = 0; sweep < options.sweeps; ++sweep) {
            const auto moves = sweeps.sweep(execution);
            if (!moves) return moves;
            all.tried += moves->tried;
            all.moved += moves->moved;
            if (moves->moved == 0) break;
        }
        return all;
    });
}

#define CAMBER_INSTANTIATE(D)                                                                             \
    template Outcome<Adapted<D>> smooth<D>(Adaptation<D>, const AdaptationGoal<D>&, const SmoothOptions&, \
                                           const Execution&);                                             \
    template Outcome<NodeMoves> smooth_nodes<D>(Adaptation<D>&, const SmoothOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
