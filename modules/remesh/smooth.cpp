module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>
module camber.remesh;
import camber.core;
import camber.metric;
import camber.dynamic;
import camber.surface;

namespace camber {

namespace {

template <int D>
class Moves final : public Pass<D> {
  public:
    Moves(const RemeshingGoal<D>& goal, const SmoothOptions& options, KeptShapes<D> shapes)
        : goal_(goal),
          wanted_(shape_of_quality(options.wanted, D)),
          gain_(shape_of_quality(options.gain, D)),
          shapes_(std::move(shapes)) {}

    [[nodiscard]] std::optional<LimitedWish<D>> wish(const Remeshing<D>& r, const Task& task) const override {
        const VertexId v(std::size_t{task.id});
        const VertexState& state = r.mesh.states[v];
        if (r.mesh.is_free(v) || !may_move(state)) return {};
        LimitedWish<D> wished;
        auto& [wish, limits] = wished;
        if (state.place == VertexPlace::inside)
            ball(r.mesh, v, wish.cavity.elements);  // no facets, no lines
        else
            cavity_of_vertex(r.mesh, v, wish.cavity);
        const double before = shapes_.worst(wish.cavity.elements);
        if (!(before < wanted_)) return {};
        ConeShapes<D> cones(r);
        for (const ElementId e : wish.cavity.elements) cones.add(e, local_vertex(r.mesh.elements.vertices[e], v));
        const Vec<D> here = r.mesh.points[v];
        const Vec<D> step = centre_of_unit_edges(r, wish.cavity, cones, v) - here;
        const double least = gain_ * before;
        for (double share = 1; share > 0.2; share /= 2) {
            const Vec<D> place = on_geometry(r.mesh, wish.cavity, state.place, here + share * step);
            const FieldSample<D> sample = sample_value(goal_.field, place, r.metrics[v].back);
            const VertexMetric<D> metric(sample.log_metric, sample.location.element);
            if (!(cones.worst(place, metric.measure, least) > least)) continue;
            wish.point = v;
            wish.place = place;
            wish.metric = metric;
            limits.least_shape = least;
            limits.corrections = 0;
            return wished;
        }
        return {};
    }
    void follow(const Remeshing<D>& r, const TopologyChanges& changes, std::vector<Task>&) override {
        shapes_.follow(r, changes);
    }

  private:
    static constexpr double least_length = 0.1;
    /// Vertices of surfaces move on a geometry only: without one nobody knows where else they may be.
    [[nodiscard]] bool may_move(const VertexState& state) const {
        if (state.marks.has(Mark::required) || state.marks.has(Mark::held)) return false;
        return state.place == VertexPlace::inside ||
               (state.place == VertexPlace::surface && goal_.geometry.has_value());
    }
    [[nodiscard]] Vec<D> on_geometry(const DynamicMesh<D>& mesh, const CavityParts<D>& around, VertexPlace place,
                                     const Vec<D>& p) const {
        return place == VertexPlace::inside ? p : on_geometry_at_facet(goal_, mesh, around.facets.front(), p);
    }
    /// The mean of where v would be for each of its edges (on a surface those of its facets) to have length 1 at its
    /// other end, by how many elements (facets) have the edge.
    [[nodiscard]] static Vec<D> centre_of_unit_edges(const Remeshing<D>& r, const CavityParts<D>& around,
                                                     const ConeShapes<D>& cones, VertexId v) {
        const Vec<D> here = r.mesh.points[v];
        Vec<D> sum{};
        double weights = 0;
        const auto add = [&](VertexId w, double weight) {
            const Vec<D> edge = here - r.mesh.points[w];
            const double length = edge_length(r.metrics[v].measure, r.metrics[w].measure, edge);
            if (!(length > least_length)) return;  // it asks for a place far beyond all others
            sum += weight * (r.mesh.points[w] + (1 / length) * edge);
            weights += weight;
        };
        if (around.facets.empty())
            for (const auto& corner : cones.vertices()) add(corner.vertex, corner.faces);
        else
            for (const FacetId f : around.facets)
                for (const VertexId w : r.mesh.facets.vertices[f])
                    if (w != v) add(w, 1);
        return weights > 0 ? sum / weights : here;
    }

    const RemeshingGoal<D>& goal_;
    double wanted_, gain_;  ///< of shapes
    KeptShapes<D> shapes_;
};

}  // namespace

template <int D>
Outcome<Remeshed<D>> smooth(Remeshing<D> state, const RemeshingGoal<D>& goal, const SmoothOptions& options,
                            const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    return guarded([&]() -> Outcome<Remeshed<D>> {
        auto shapes = KeptShapes<D>::of(state, without_progress(execution));
        if (!shapes) return fail(shapes.error());
        Moves<D> pass(goal, options, std::move(*shapes));
        Remeshed<D> out{std::move(state), {}};
        for (int sweep = 0; sweep < options.sweeps; ++sweep) {
            std::vector<Task> tasks;
            tasks.reserve(out.state.mesh.points.size());
            for (std::size_t v = 0; v < out.state.mesh.points.size(); ++v)
                if (!out.state.mesh.is_free(VertexId(v))) tasks.push_back(task(0, VertexId(v)));
            auto statistics = run_pass<D>(out.state, pass, std::move(tasks), execution);
            if (!statistics) return fail(statistics.error());
            out.statistics += *statistics;
            if (statistics->accepted == 0) break;
        }
        return out;
    });
}

template Outcome<Remeshed<2>> smooth<2>(Remeshing<2>, const RemeshingGoal<2>&, const SmoothOptions&, const Execution&);
template Outcome<Remeshed<3>> smooth<3>(Remeshing<3>, const RemeshingGoal<3>&, const SmoothOptions&, const Execution&);

}  // namespace camber
