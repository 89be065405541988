module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>
module camber.adapt;
import camber.core;
import camber.cavity;
import camber.metric;
import camber.operation;

namespace camber {

namespace {

template <int D>
struct BestSwap {
    Cavity<D> cavity;
    VertexId point;
    double gain = 0;  ///< ratio of the worst shape after the swap to that before
};

template <int D>
class Swaps final : public Pass<D> {
  public:
    Swaps(const Adaptation<D>& r, const AdaptationGoal<D>& goal, const SwapOptions& options)
        : goal_(goal),
          distance_(options.distance),
          target_shape_(target_shape(r, options.target_quality)),
          gain_(shape_of_quality(options.gain, D)) {}

    [[nodiscard]] double order_of(double shape) const { return shape < target_shape_ ? shape : infinite_order; }

    [[nodiscard]] std::optional<Candidate<D>> candidate(const Adaptation<D>& r, const Task& task) const override {
        const ElementId e(std::size_t{task.id});
        if (r.mesh.is_free(e)) return {};
        const double shape = r.shapes[e.index()];
        if (!(shape < target_shape_)) return {};
        BestSwap<D> best;
        best.gain = gain_;
        ConeShapes<D> cones(r, goal_);
        const auto beside = shapes_beside(r, e);
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            if (is_worst_beside(beside, k, shape)) look_at_edge(r, e, k, cones, best);
        if constexpr (D == 3)
            if (!r.mesh.is_surface()) look_at_faces(r, e, beside, best);
        if (!best.point.valid()) return {};
        Candidate<D> candidate;
        candidate.request.cavity = std::move(best.cavity);
        candidate.request.join_to(r, best.point);
        candidate.limits.min_shape = gain_ * shape;
        candidate.limits.corrections = 0;
        candidate.limits.two_facet_elements = TwoFacetElements::refused;
        candidate.limits.facet_distance = distance_;
        return candidate;
    }
    void refused(Adaptation<D>& r, std::span<const Task> tasks) const override {
        refuse<ElementTag>(r, CachedPass::swap, tasks, r.mesh.elements.size());
    }
    void follow(Adaptation<D>& r, const TopologyChanges& changes, std::vector<Task>& tasks) override {
        compute_shapes<D>(r, changes.elements.created);
        for (const ElementId e : changes.elements.created)
            if (!r.mesh.is_free(e))
                if (const double order = order_of(r.shapes[e.index()]); order < infinite_order)
                    tasks.push_back(task(order, e));
    }

  private:
    [[nodiscard]] static std::array<double, D + 1> shapes_beside(const Adaptation<D>& r, ElementId e) {
        std::array<double, D + 1> shapes{};
        for (int face = 0; face <= D; ++face) {
            const ElementId next = element_across(r.mesh, e, face);
            shapes[face] = next.valid() ? r.shapes[next.index()] : infinite_order;
        }
        return shapes;
    }
    /// True if no neighbour at the edge has a worse shape than this element. A swap is tried only from the worst
    /// element at its edge, where the gain is largest.
    [[nodiscard]] static bool is_worst_beside(const std::array<double, D + 1>& beside, int k, double shape) {
        for (int face = 0; face <= D; ++face)
            if (face != local_edges<D>[k][0] && face != local_edges<D>[k][1] && !(beside[face] >= shape)) return false;
        return true;
    }
    [[nodiscard]] static bool has_end_inside(const Adaptation<D>& r, ElementId e, int k) {
        return std::ranges::any_of(local_edges<D>[k], [&](int i) {
            return r.mesh.states[r.mesh.elements.vertices[e][i]].place == VertexPlace::inside;
        });
    }
    void look_at_edge(const Adaptation<D>& r, ElementId e, int k, ConeShapes<D>& cones, BestSwap<D>& best) const {
        if constexpr (D == 3)
            if (!r.mesh.is_surface() && has_end_inside(r, e, k)) {
                EdgeRing ring;
                const EdgeRing::Walk walk = ring.walk(r.mesh, r.shapes.view(), e, k);
                if (walk == EdgeRing::Walk::closed) look_at_ring(r, e, ring, best);
                if (walk != EdgeRing::Walk::open) return;
            }
        look_at_any_edge(r, e, k, cones, best);
    }
    void look_at_ring(const Adaptation<3>& r, ElementId e, const EdgeRing& ring, BestSwap<3>& best) const {
        if (r.mesh.is_curved()) {
            const BentSwap found = best_around_edge(r, goal_, ring, best.gain);
            if (found.point.valid()) take(best, ring.elements(), found.point, found.after / found.before);
            return;
        }
        const double before = r.shapes[e.index()];
        const EdgeRing::Best found = ring.best(r, best.gain * before);
        if (found.point.valid()) take(best, ring.elements(), found.point, found.worst / before);
    }
    /// Tries to join the elements around an edge to each vertex around it; on the boundary, only to vertices of the
    /// edge's facets.
    void look_at_any_edge(const Adaptation<D>& r, ElementId e, int k, ConeShapes<D>& cones, BestSwap<D>& best) const {
        const EdgeId edge = r.mesh.edges_of[e][k];
        if (r.mesh.line_at(edge).valid() || r.mesh.is_at_infinity(edge)) return;
        Cavity<D> cavity;
        cavity_of_edge(r.mesh, e, k, cavity);
        if (D == 2 && !cavity.facets.empty()) return;
        if (worst_cached_shape_of(r, cavity.elements) < r.shapes[e.index()]) return;
        const double before = worst_bent(r, cavity.elements, e);
        const VertexId a = r.mesh.elements.vertices[e][local_edges<D>[k][0]];
        const VertexId b = r.mesh.elements.vertices[e][local_edges<D>[k][1]];
        cones.clear();
        for (const ElementId s : cavity.elements)
            for (const VertexId v : {a, b}) cones.add(s, local_vertex(r.mesh.elements.vertices[s], v));
        for (const auto& corner : cones.vertices()) {
            const VertexId p = corner.vertex;
            const auto has_p = [&](FacetId f) { return local_vertex(r.mesh.facets.vertices[f], p) >= 0; };
            if (p == a || p == b || (!cavity.facets.empty() && !std::ranges::any_of(cavity.facets, has_p))) continue;
            const double least = best.gain * before;
            const double after = cones.worst_at(cone_point(r, p), least, p);
            if (after > least) take(best, cavity, p, after / before);
        }
    }
    static void take(BestSwap<D>& best, std::span<const ElementId> elements, VertexId p, double gain) {
        best.cavity.clear();
        best.cavity.elements.assign(elements.begin(), elements.end());
        best.point = p;
        best.gain = gain;
    }
    static void take(BestSwap<D>& best, const Cavity<D>& cavity, VertexId p, double gain) {
        best.cavity = cavity;
        best.point = p;
        best.gain = gain;
    }
    [[nodiscard]] double worst_bent(const Adaptation<D>& r, const std::vector<ElementId>& elements, ElementId e) const {
        if (!r.mesh.is_curved()) return r.shapes[e.index()];
        double worst = std::numeric_limits<double>::infinity();
        for (const ElementId s : elements) worst = std::min(worst, bent_shape_of(r, s));
        return std::max(worst, least_bent_shape);
    }
    void look_at_faces(const Adaptation<3>& r, ElementId e, const std::array<double, 4>& beside,
                       BestSwap<3>& best) const {
        const double shape = r.shapes[e.index()];
        std::array<int, 4> faces{};
        std::size_t count = 0;
        for (int face = 0; face < 4; ++face)
            if (beside[face] >= shape && r.mesh.face_neighbours[e][face].is_element()) faces[count++] = face;
        if (count == 0) return;
        if (r.mesh.is_curved()) {
            const BentSwap found = best_without_face(r, goal_, e, std::span(faces).first(count), best.gain);
            if (found.point.valid()) take(best, std::array{e, found.beside}, found.point, found.after / found.before);
            return;
        }
        for (const int face : std::span(faces).first(count)) look_at_straight_face(r, e, face, best);
    }
    void look_at_straight_face(const Adaptation<3>& r, ElementId e, int face, BestSwap<3>& best) const {
        const ElementId other = r.mesh.face_neighbours[e][face].element();
        const double before = r.shapes[e.index()];
        const double least = best.gain * before;
        const double after = worst_without_face(r, e, face, other, least);
        if (after > least) take(best, std::array{e, other}, r.mesh.elements.vertices[e][face], after / before);
    }

    const AdaptationGoal<D>& goal_;
    double distance_;
    double target_shape_, gain_;  ///< on the scale of `shape_of`
};

}  // namespace

template <int D>
Outcome<Adapted<D>> swap(Adaptation<D> state, const AdaptationGoal<D>& goal, const SwapOptions& options,
                         const Execution& execution) {
    if (auto checked = check_limits(options); !checked) return fail(checked.error());
    state.rejection_cache.begin(CachedPass::swap, {options.target_quality, options.gain, options.distance});
    if (auto known = compute_shapes(state, without_progress(execution)); !known) return fail(known.error());
    Swaps<D> pass(state, goal, options);
    auto tasks = element_tasks(
        state, CachedPass::swap, [&](double shape) { return pass.order_of(shape); }, without_progress(execution));
    if (!tasks) return fail(tasks.error());
    auto statistics = run_pass<D>(state, goal, pass, std::move(*tasks), execution);
    if (!statistics) return fail(statistics.error());
    return Adapted<D>{std::move(state), *statistics};
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Adapted<D>> swap<D>(Adaptation<D>, const AdaptationGoal<D>&, const SwapOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
