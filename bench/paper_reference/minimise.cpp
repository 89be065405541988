#include "minimise.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "back_field.hpp"
#include "edge.hpp"
#include "matrix.hpp"

namespace paper {

namespace {

/// Updates the inverse Hessian with BFGS from a step and the change of the gradient, if the curvature is positive.
void update(Symmetric& h, const Vector& step, const Vector& change) {
    const double product = dot(step, change);
    const Vector hc = h * change;
    const double size = dot(change, hc);
    if (!(product > 1e-8 * size) || !(product > 0)) return;  // equal if h already is the inverse Hessian
    const double factor = (1 + size / product) / product;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j <= i; ++j)
            h(i, j) += factor * step[i] * step[j] - (hc[i] * step[j] + step[i] * hc[j]) / product;
}

constexpr double armijo = 1e-4;
constexpr int max_steps = 8;
constexpr double longest_step = 0.25;  ///< in chords

/// Returns the step length along `direction` by Armijo's rule with quadratic interpolation, or 0 if no step lowers the
/// value. `value` is updated.
double line_search(Edge& edge, const Vector& node, const Vector& direction, double slope, double& value) {
    double step = 1;
    for (int attempt = 0; attempt < max_steps; ++attempt) {
        const double trial = edge.value(node + step * direction);
        if (trial < value + armijo * step * slope) {
            value = trial;
            return step;
        }
        const double lowest = -slope * step * step / (2 * (trial - value - slope * step));
        step = std::isfinite(trial) ? std::clamp(lowest, 0.1 * step, 0.5 * step) : 0.5 * step;
    }
    return 0;
}

}  // namespace

Minimum minimise(const BackField& field, std::uint32_t a, std::uint32_t b, std::uint32_t hint, const Options& options) {
    Edge edge(field, options.along, a, b, hint);
    Minimum at;
    at.node = edge.middle();
    Length length = edge.value_and_gradient(at.node);
    at.straight_length = length.value;
    const Vector chord = field.vertices[b].point - field.vertices[a].point;
    const double longest = longest_step * std::sqrt(dot(chord, chord));
    Symmetric h = 3 * length.value / 16 * edge.inverse_metric(at.node);
    for (; edge.work().iterations < options.max_iterations; ++edge.work().iterations) {
        Vector direction = -1.0 * (h * length.gradient);
        const double promise = -dot(length.gradient, direction);
        if (const double size = std::sqrt(dot(direction, direction)); size > longest)
            direction = longest / size * direction;
        const double slope = dot(length.gradient, direction);
        if (!(promise > options.tolerance * length.value)) break;
        double value = length.value;
        const double step = line_search(edge, at.node, direction, slope, value);
        if (step == 0) break;
        const Vector moved = step * direction;
        at.node = at.node + moved;
        if (length.value - value < options.tolerance * length.value) {
            length.value = value;
            break;
        }
        const Length next = edge.value_and_gradient(at.node);
        update(h, moved, next.gradient - length.gradient);
        length = next;
    }
    at.length = length.value;
    at.work = edge.work();
    return at;
}

}  // namespace paper
