module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
module camber.metric;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

/// A_i − A_D: how the node moves with u_i.
template <int D>
Mat<D> sides_from_last(const StraightBack<D>& back, ElementId e) {
    const auto& v = back.mesh.elements.vertices[e];
    Mat<D> sides;
    for (int i = 0; i < D; ++i) sides.column[i] = back.mesh.points[v[i]] - back.mesh.points[v[D]];
    return sides;
}

/// log M(A_i) − log M(A_D): how log M(P^l) does.
template <int D>
LogGradient<D> log_differences(const StraightBack<D>& back, ElementId e) {
    const auto& v = back.mesh.elements.vertices[e];
    LogGradient<D> out;
    for (int i = 0; i < D; ++i) out[i] = back.log_metrics[v[i]].l - back.log_metrics[v[D]].l;
    return out;
}

/// The search's place: an element, the node in the unit frame, and what is known there.
template <int D>
struct InElement {
    ElementId element;
    std::array<double, D + 1> u{};
    Vec<D> y;
    double value = 0;
    Vec<D> gradient;                       ///< in the frame
    Sym<D> inverse_hessian;                ///< in the frame
    std::array<Vec<D>, D + 1> coordinate;  ///< ∂u_i/∂y
    bool fresh = true;                     ///< inverse_hessian is the model's, not BFGS's
};

template <int D>
class ElementSearch {
  public:
    ElementSearch(const StraightBack<D>& back, const EdgeObjective<D>& objective, const UnitFrame<D>& frame)
        : back_(back), objective_(objective), frame_(frame) {}

    [[nodiscard]] InElement<D> at(const Vec<D>& y, ElementId hint) const {
        const Location<D> location = back_.locate(frame_.node(y), hint);
        InElement<D> place;
        place.y = y;
        if (location.placement != Placement::inside) {
            // The nearest point of the back mesh stands for it: these coordinates cannot leave it.
            Vec<D> p;
            for (int i = 0; i <= D; ++i) p += location.xi[i] * corner(location.element, i);
            place.y = frame_.coordinates(p);
        }
        enter(place, location.element);
        return place;
    }

    /// EdgeSearch::exhausted after max_iterations steps that no face cut short, or far too many that one did.
    [[nodiscard]] EdgeSearch descend(InElement<D>& place, int max_iterations, double tolerance) const {
        int steps = 0;
        for (int move = 0; move < 20 * max_iterations + 50 && steps < max_iterations; ++move) {
            const Vec<D> direction = feasible_direction(place);
            if (!(-dot(place.gradient, direction) > tolerance * place.value)) return settled(place);
            InElement<D> next;
            bool whole = false;
            if (!line_search(place, direction, next, whole)) {
                polish_from(place);
                return EdgeSearch::polished;
            }
            const double gained = place.value - next.value;
            if (next.element == place.element) {
                next.inverse_hessian = place.inverse_hessian;
                update_inverse_hessian(next.inverse_hessian, next.y - place.y, next.gradient - place.gradient);
                next.fresh = false;
            }
            place = next;
            steps += whole;
            if (whole && gained < 0.1 * tolerance * place.value) return EdgeSearch::converged;
        }
        return EdgeSearch::exhausted;
    }

  private:
    [[nodiscard]] Vec<D> corner(ElementId e, int i) const {
        return back_.mesh.points[back_.mesh.elements.vertices[e][i]];
    }

    /// The place seen from an element that holds it: its coordinates there, value, gradient and model.
    void enter(InElement<D>& place, ElementId e) const {
        place.element = e;
        const auto gradients = barycentric_gradients(back_.mesh, e);
        const Vec<D> from_last = frame_.node(place.y) - corner(e, D);
        place.u[D] = 1;
        for (int i = 0; i < D; ++i) {
            place.u[i] = dot(gradients[i], from_last);
            place.u[D] -= place.u[i];
        }
        for (int i = 0; i <= D; ++i) place.coordinate[i] = frame_.gradient(gradients[i]);
        const auto sample = evaluate_in_element(objective_, e, place.u);
        // ∂f/∂y_k = Σ ∂f/∂u_i ∂u_i/∂y_k.
        place.value = sample.value;
        place.gradient = {};
        for (int i = 0; i < D; ++i) place.gradient += sample.gradient[i] * place.coordinate[i];
        Mat<D> change;
        for (int i = 0; i < D; ++i) change.column[i] = place.coordinate[i];
        place.inverse_hessian = inverse_of(congruence(change, sample.hessian));
        place.fresh = true;
    }

    /// The quasi-Newton step within the faces that are held.
    [[nodiscard]] Vec<D> step(const InElement<D>& place, const std::array<bool, D + 1>& held) const {
        Sym<D> h = place.inverse_hessian;
        for (int i = 0; i <= D; ++i) {
            if (!held[i]) continue;
            const Vec<D> v = h * place.coordinate[i];
            const double along = dot(place.coordinate[i], v);
            if (!(along > 1e-14 * norm_squared(place.coordinate[i]))) continue;
            for (int a = 0; a < D; ++a)
                for (int b = 0; b <= a; ++b) h(a, b) -= v[a] * v[b] / along;
        }
        return -(h * place.gradient);
    }

    /// The face on which the place lies and which the step would cross, that with the steepest crossing; −1 for none.
    [[nodiscard]] int crossed_face(const InElement<D>& place, const Vec<D>& direction,
                                   const std::array<bool, D + 1>& held) const {
        int face = -1;
        double steepest = 0;
        for (int i = 0; i <= D; ++i) {
            if (held[i] || place.u[i] > 1e-10) continue;
            const double rate = dot(place.coordinate[i], direction) / norm(place.coordinate[i]);
            if (rate < -1e-14 * norm(direction) && rate < steepest) {
                steepest = rate;
                face = i;
            }
        }
        return face;
    }

    /// A step that the place's element allows. On a face that the step would cross, the search starts again in the
    /// element beyond; where that one has been tried at this place, the field has a kink, and the face is held.
    [[nodiscard]] Vec<D> feasible_direction(InElement<D>& place) const {
        std::array<bool, D + 1> held{};
        std::array<ElementId, 9> tried{place.element};
        std::size_t tries = 1;
        for (;;) {
            const Vec<D> direction = step(place, held);
            const int face = crossed_face(place, direction, held);
            if (face < 0) return direction;
            const ElementId beyond = back_.neighbours[place.element][face];
            const bool known = std::find(tried.begin(), tried.begin() + tries, beyond) != tried.begin() + tries;
            if (beyond.valid() && !known && tries < tried.size()) {
                tried[tries++] = beyond;
                enter(place, beyond);
                held = {};
            } else if (!place.fresh) {
                enter(place, place.element);
            } else {
                held[face] = true;
            }
        }
    }

    /// Armijo's rule, from the longest step that stays in the element. `whole`: no face cut it.
    [[nodiscard]] bool line_search(const InElement<D>& from, const Vec<D>& direction, InElement<D>& next,
                                   bool& whole) const {
        double longest = 1;
        for (int i = 0; i <= D; ++i)
            if (const double rate = dot(from.coordinate[i], direction); rate < 0 && from.u[i] > 1e-10)
                longest = std::min(longest, -from.u[i] / rate);
        const double slope = dot(from.gradient, direction);
        double t = longest;
        for (int attempt = 0; attempt < 8; ++attempt) {
            const Vec<D> wanted = from.y + t * direction;
            const Vec<D> y = frame_.bounded(wanted);
            InElement<D> trial;
            trial.y = y;
            if (y == wanted)
                enter(trial, from.element);
            else
                trial = at(y, from.element);
            if (trial.value < from.value + 1e-4 * t * slope || (!(y == wanted) && trial.value < from.value)) {
                next = trial;
                whole = t < longest || longest == 1;
                return true;
            }
            const double curved = -slope * t * t / (2 * (trial.value - from.value - slope * t));
            t = std::clamp(curved, 0.1 * t, 0.5 * t);
        }
        return false;
    }

    void polish_from(InElement<D>& place) const {
        Iterate<D> best{place.y, place.value, place.gradient, {}};
        polish(objective_, frame_, best);
        if (!(best.value < place.value)) return;
        const InElement<D> polished = at(best.y, place.element);
        if (polished.value < place.value) place = polished;
    }

    /// No step is promised: a smooth minimum, or a kink, which a pattern search may leave.
    [[nodiscard]] EdgeSearch settled(InElement<D>& place) const {
        const Vec<D> free = step(place, {});
        if (crossed_face(place, free, {}) < 0) return EdgeSearch::converged;
        polish_from(place);
        return EdgeSearch::polished;
    }

    const StraightBack<D>& back_;
    const EdgeObjective<D>& objective_;
    const UnitFrame<D>& frame_;
};

}  // namespace

template <int D>
BarycentricSample<D> evaluate_in_element(const EdgeObjective<D>& objective, ElementId element,
                                         const std::array<double, D + 1>& u) {
    const StraightBack<D>& back = *straight_part(*objective.back);
    const Mat<D> sides = sides_from_last(back, element);
    const LogGradient<D> differences = log_differences(back, element);
    const auto& v = back.mesh.elements.vertices[element];
    Vec<D> node = back.mesh.points[v[D]];
    LogMetric<D> mid = back.log_metrics[v[D]];
    for (int i = 0; i < D; ++i) {
        node += u[i] * sides.column[i];
        mid.l += u[i] * differences[i];
    }
    const QuadraticEdge<D> edge{objective.p20, {node}, objective.p02};
    const bool energy = objective.kind == EdgeObjectiveKind::energy;
    BarycentricSample<D> sum;
    ElementId at = element;
    for (std::size_t k = 0; k < objective.rule->size(); ++k) {
        const double t = objective.rule->t[k];
        LogMetric<D> log_metric;
        LogGradient<D> slopes = differences;
        if (objective.field == EdgeFieldKind::edge) {
            log_metric = EdgeField<D>{objective.l20, mid, objective.l02}.at(t);
        } else {
            const FieldSample<D> sample = sample_with_gradient(*objective.back, edge.point(t), at);
            at = sample.location.element;
            log_metric = sample.log_metric;
            // In another element than the node's, log M changes with the point's place: ∂_i l = 4t(1−t)(A_i − A_D).
            if (at != element || sample.location.placement != Placement::inside)
                for (int i = 0; i < D; ++i) {
                    slopes[i] = {};
                    for (int a = 0; a < D; ++a) slopes[i] += sides(a, i) * sample.gradient[a];
                }
        }
        const SpectralMetric<D> metric(log_metric);
        const Vec<D> tangent = edge.derivative(t);
        const double q = metric.length_squared(tangent);
        const double root = std::sqrt(q);
        const double c = 4 * (1 - 2 * t);
        const double s = 4 * t * (1 - t);
        const double slope = objective.rule->w[k] * (energy ? 1.0 : root > 0 ? 0.5 / root : 0.0);
        const Vec<D> force = metric.times(tangent);
        const Sym<D> adjoint = length_squared_adjoint(metric, tangent);
        sum.value += objective.rule->w[k] * (energy ? q : root);
        for (int i = 0; i < D; ++i) {
            sum.gradient[i] += slope * (2 * c * dot(force, sides.column[i]) + s * inner(adjoint, slopes[i]));
            const Vec<D> pushed = metric.times(sides.column[i]);
            for (int j = 0; j <= i; ++j) sum.hessian(i, j) += slope * 2 * c * c * dot(pushed, sides.column[j]);
        }
    }
    return sum;
}

template <int D>
EdgeMinimum<D> minimise_edge_barycentric(const BackMesh<D>& back, const Vec<D>& p20, const Vec<D>& p02, ElementId hint,
                                         const EdgeRules& rules, const EdgeMinimiserOptions& options) {
    const StraightBack<D>* straight = straight_part(back);
    if (!straight) return minimise_edge(back, p20, p02, hint, rules, options);
    EdgeObjective<D> objective =
        edge_objective(back, rules.objective, options.objective, options.field, p20, p02, hint);
    const UnitFrame<D> frame = unit_frame(back, objective, options.max_tangential_shift, options.max_offset);
    const Iterate<D> first = start(objective, frame, frame.coordinates(geodesic_start(back, p20, p02, hint)));
    EdgeMinimum<D> minimum;
    const ElementSearch<D> search(*straight, objective, frame);
    InElement<D> place = search.at(first.y, hint);
    minimum.search = search.descend(place, options.max_iterations, options.tolerance);
    minimum.node.point = frame.node(place.y);
    if (options.objective == EdgeObjectiveKind::energy && options.length_tolerance > 0) {
        EdgeObjective<D> length = objective;
        length.kind = EdgeObjectiveKind::length;
        const UnitFrame<D> length_frame = unit_frame(back, length, options.max_tangential_shift, options.max_offset);
        const ElementSearch<D> shortening(*straight, length, length_frame);
        InElement<D> shorter = shortening.at(length_frame.coordinates(minimum.node.point), place.element);
        static_cast<void>(shortening.descend(shorter, 5, options.length_tolerance));
        minimum.node.point = length_frame.node(shorter.y);
    }
    judge(back, objective, rules.report, minimum);
    return minimum;
}

#define CAMBER_INSTANTIATE(D)                                                                                         \
    template BarycentricSample<D> evaluate_in_element<D>(const EdgeObjective<D>&, ElementId,                          \
                                                         const std::array<double, D + 1>&);                           \
    template EdgeMinimum<D> minimise_edge_barycentric<D>(const BackMesh<D>&, const Vec<D>&, const Vec<D>&, ElementId, \
                                                         const EdgeRules&, const EdgeMinimiserOptions&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
