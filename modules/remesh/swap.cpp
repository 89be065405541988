module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>
module camber.remesh;
import camber.core;
import camber.metric;
import camber.dynamic;

namespace camber {

namespace {

/// The best of the swaps that were looked at.
template <int D>
struct BestSwap {
    CavityParts<D> cavity;
    VertexId point;
    double before = 0;  ///< the worst shape that is removed
    double gain = 0;    ///< worst shape after by before
};

template <int D>
class Swaps final : public Pass<D> {
  public:
    explicit Swaps(const SwapOptions& options)
        : wanted_(shape_of_quality(options.wanted, D)), gain_(shape_of_quality(options.gain, D)) {}

    [[nodiscard]] double order_of(double shape) const { return shape < wanted_ ? shape : infinite_order; }

    [[nodiscard]] std::optional<LimitedWish<D>> wish(const Remeshing<D>& r, const Task& task) const override {
        const ElementId e(std::size_t{task.id});
        if (r.mesh.is_free(e)) return {};
        const double shape = shape_of(r, e);
        if (!(shape < wanted_)) return {};
        BestSwap<D> best;
        best.before = shape;
        best.gain = gain_;
        const auto beside = shapes_beside(r, e);
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            if (is_worst_beside(beside, k, shape)) look_at_edge(r, e, k, best);
        if constexpr (D == 3)
            for (int face = 0; face <= D; ++face)
                if (beside[face] >= shape) look_at_face(r, e, face, best);
        if (!best.point.valid()) return {};
        LimitedWish<D> wished;
        wished.wish.cavity = std::move(best.cavity);
        wished.wish.join_to(r, best.point);
        wished.limits.least_shape = gain_ * std::max(best.before, 0.0);
        wished.limits.corrections = 0;
        return wished;
    }
    void follow(const Remeshing<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) const override {
        for (const ElementId e : changes.elements.created)
            if (!r.mesh.is_free(e))
                if (const double order = order_of(shape_of(r, e)); order < infinite_order)
                    tasks.push_back(task(order, e));
    }

  private:
    /// The shapes of the elements across an element's faces.
    [[nodiscard]] static std::array<double, D + 1> shapes_beside(const Remeshing<D>& r, ElementId e) {
        std::array<double, D + 1> shapes{};
        for (int face = 0; face <= D; ++face) {
            const ElementId next = element_across(r.mesh, e, face);
            shapes[face] = next.valid() ? shape_of(r, next) : infinite_order;
        }
        return shapes;
    }
    /// An operation is looked at from the worst element that it removes: what it would be worth for another one, it is
    /// worth less.
    [[nodiscard]] static bool is_worst_beside(const std::array<double, D + 1>& beside, int k, double shape) {
        for (int face = 0; face <= D; ++face)
            if (face != local_edges<D>[k][0] && face != local_edges<D>[k][1] && !(beside[face] >= shape)) return false;
        return true;
    }
    /// The elements around an edge without it, joined to each vertex around it; on the boundary to those of its facets.
    void look_at_edge(const Remeshing<D>& r, ElementId e, int k, BestSwap<D>& best) const {
        if (r.mesh.line_at(r.mesh.edges_of[e][k]).valid()) return;
        CavityParts<D> cavity;
        cavity_of_edge(r.mesh, e, k, cavity);
        if (D == 2 && !cavity.facets.empty()) return;
        for (const ElementId s : cavity.elements)
            if (shape_of(r, s) < best.before) return;
        const VertexId a = r.mesh.elements.vertices[e][local_edges<D>[k][0]];
        const VertexId b = r.mesh.elements.vertices[e][local_edges<D>[k][1]];
        std::vector<VertexId> ring;
        const auto add = [&](const auto& simplex) {
            for (const VertexId v : simplex)
                if (v != a && v != b && !is_among(ring, v)) ring.push_back(v);
        };
        if (cavity.facets.empty())
            for (const ElementId s : cavity.elements) add(r.mesh.elements.vertices[s]);
        else
            for (const FacetId f : cavity.facets) add(r.mesh.facets.vertices[f]);
        for (const VertexId p : ring) {
            const double least = best.gain * std::max(best.before, 0.0);
            const double after = worst_without(r, cavity.elements, {a, b}, p, least);
            if (after > least) take(best, cavity, p, after);
        }
    }
    static void take(BestSwap<D>& best, const CavityParts<D>& cavity, VertexId p, double after) {
        best.cavity = cavity;
        best.point = p;
        best.gain = best.before > 0 ? after / best.before : infinite_order;
    }
    /// Stops where an element is no better than `least`.
    [[nodiscard]] static double worst_without(const Remeshing<D>& r, const std::vector<ElementId>& elements,
                                              const std::array<VertexId, 2>& edge, VertexId p, double least) {
        double worst = std::numeric_limits<double>::infinity();
        for (const ElementId s : elements) {
            const auto& vertices = r.mesh.elements.vertices[s];
            if (local_vertex(vertices, p) >= 0) continue;
            for (const VertexId v : edge) {
                worst = std::min(worst,
                                 shape_with(r, s, local_vertex(vertices, v), r.mesh.points[p], r.metrics[p].measure));
                if (!(worst > least)) return worst;
            }
        }
        return worst;
    }
    /// Two elements without their face, joined to one of the two vertices opposite it: three elements.
    void look_at_face(const Remeshing<D>& r, ElementId e, int face, BestSwap<D>& best) const {
        CavityParts<D> cavity;
        cavity_of_face(r.mesh, e, face, cavity);
        if (cavity.elements.size() != 2 || !cavity.facets.empty()) return;
        const VertexId p = r.mesh.elements.vertices[e][face];
        const ElementId other = cavity.elements[1];
        const auto& vertices = r.mesh.elements.vertices[other];
        const double least = best.gain * std::max(best.before, 0.0);
        double after = std::numeric_limits<double>::infinity();
        for (int i = 0; i <= D && after > least; ++i)
            if (local_vertex(r.mesh.elements.vertices[e], vertices[i]) >= 0)
                after = std::min(after, shape_with(r, other, i, r.mesh.points[p], r.metrics[p].measure));
        if (after > least) take(best, cavity, p, after);
    }

    double wanted_, gain_;  ///< of shapes
};

}  // namespace

template <int D>
Outcome<Remeshed<D>> swap(Remeshing<D> state, const RemeshingGoal<D>&, const SwapOptions& options,
                          const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    const Swaps<D> pass(options);
    auto tasks = element_tasks(state, [&](double shape) { return pass.order_of(shape); }, without_progress(execution));
    if (!tasks) return fail(tasks.error());
    auto statistics = run_pass<D>(state, pass, std::move(*tasks), execution);
    if (!statistics) return fail(statistics.error());
    return Remeshed<D>{std::move(state), *statistics};
}

template Outcome<Remeshed<2>> swap<2>(Remeshing<2>, const RemeshingGoal<2>&, const SwapOptions&, const Execution&);
template Outcome<Remeshed<3>> swap<3>(Remeshing<3>, const RemeshingGoal<3>&, const SwapOptions&, const Execution&);

}  // namespace camber
