// Verdicts and certificates of elements in doubles, by bisection and in double-double arithmetic.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
module camber.validity;
import camber.core;
import camber.bezier;

namespace camber {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Limits of bisection depth and parts. Up to this depth, corners are integer multiples of 2⁻⁵² and therefore exact.
constexpr int max_depth = 52;
constexpr int max_parts = 4000;

template <int D>
double smallest_coefficient(const std::array<double, jacobian_coefficients<D>>& c) {
    double low = c[0];
    for (const double x : c) low = x < low ? x : low;
    return low;
}

template <int D>
int lowest_corner(const std::array<double, jacobian_coefficients<D>>& c) {
    int lowest = 0;
    for (int i = 1; i <= D; ++i)
        if (c[corner_coefficients<D>[i]] < c[corner_coefficients<D>[lowest]]) lowest = i;
    return lowest;
}

template <int D>
double lowest_corner_value(const std::array<double, jacobian_coefficients<D>>& c) {
    return c[corner_coefficients<D>[lowest_corner<D>(c)]];
}

/// Rounding error of a coefficient; `error` is its value before bisection. A bisection averages up to D times in a row.
/// Averages do not add errors, but each sum is rounded by u, and halving may underflow. Averages never exceed the
/// largest coefficient. A bisection therefore adds D u · largest; 4 u also covers growth by rounding.
struct RoundingError {
    double error, step;
    [[nodiscard]] double after(int depth) const { return error + step * depth; }
};

template <int D>
RoundingError rounding_error_of(const BoundedJacobian<D>& jacobian) {
    double largest = 0;
    for (const double x : jacobian.coefficients) largest = std::max(largest, std::abs(x));
    return {jacobian.error, 0x1p-51 * largest + 0x1p-1070};
}

/// Values of det J above `above` are certainly sufficient, and values below `below` are certainly not.
struct Threshold {
    double value;
    RoundingError blur;
    [[nodiscard]] double above(int depth) const { return value + blur.after(depth); }
    [[nodiscard]] double below(int depth) const { return value - blur.after(depth); }
};

/// The error of bound · |straight| is the bound times that of `straight`, plus roundings u of the product, of `after`
/// and `above`, and of the comparison.
template <class Jacobian>
Threshold threshold_of(const Jacobian& jacobian, double bound) {
    const double requested = std::max(bound, 0.0);
    const double value = requested * std::abs(jacobian.straight);
    return {value, {jacobian.error * (1 + requested) * 1.0001 + value * 0x1p-50, 0}};
}

template <int D>
Threshold threshold_of_parts(const BoundedJacobian<D>& jacobian, double bound) {
    Threshold threshold = threshold_of(jacobian, bound);
    threshold.blur.step = rounding_error_of(jacobian).step;
    return threshold;
}

template <int D>
bool finite(const BoundedJacobian<D>& jacobian) {
    double sum = jacobian.error + jacobian.straight;
    for (const double x : jacobian.coefficients) sum += std::abs(x);
    return std::isfinite(sum);
}

/// Bisects depth first, in constant memory. `visit(part)` returns true to bisect; the half with the smaller coefficient
/// is next. False if a limit was reached.
template <int D, class Visit>
bool search(const BoundedJacobian<D>& jacobian, Visit&& visit) {
    std::array<JacobianPart<D>, max_depth + 2> stack;
    stack[0] = whole(jacobian);
    int top = 1;
    for (int parts = 0; top > 0; ++parts) {
        const JacobianPart<D> part = stack[--top];
        if (!visit(part)) continue;
        if (part.depth == max_depth || parts >= max_parts) return false;
        const int edge = largest_bend(part).edge;
        const JacobianPart<D> first = half(part, edge, 0);
        const JacobianPart<D> second = half(part, edge, 1);
        const bool first_is_lower =
            smallest_coefficient<D>(first.coefficients) < smallest_coefficient<D>(second.coefficients);
        stack[top++] = first_is_lower ? second : first;
        stack[top++] = first_is_lower ? first : second;
    }
    return true;
}

template <int D, class Found>
Verdict decide_by_bisection(const BoundedJacobian<D>& jacobian, const Threshold& threshold, Found&& found) {
    bool invalid = false;
    bool ambiguous = false;
    const bool complete = search(jacobian, [&](const JacobianPart<D>& part) {
        if (invalid) return false;
        const double low = smallest_coefficient<D>(part.coefficients);
        if (low > threshold.above(part.depth)) return false;
        const double corner = lowest_corner_value<D>(part.coefficients);
        if (corner < threshold.below(part.depth)) {
            invalid = true;
            found(part);
            return false;
        }
        // A corner value between the limits stays a corner of smaller parts, and a part that is affine within rounding
        // gives no further information.
        if (corner <= threshold.above(part.depth) || largest_bend(part).size < 0.125 * threshold.blur.error) {
            ambiguous = true;
            return false;
        }
        return true;
    });
    if (invalid) return Verdict::invalid;
    return complete && !ambiguous ? Verdict::valid : Verdict::undecided;
}

/// Lower bound of the minimum of det J without rounding error, to within `slack` · max(scale, |minimum|). `depth`:
/// deepest bisection.
struct LowerBound {
    double value;
    int depth;
};
template <int D>
LowerBound smallest_value(const BoundedJacobian<D>& jacobian, double slack, double scale) {
    double upper = infinity;
    double finished = infinity;
    double open = infinity;
    int depth = 0;
    const bool complete = search(jacobian, [&](const JacobianPart<D>& part) {
        depth = std::max(depth, part.depth);
        upper = std::min(upper, lowest_corner_value<D>(part.coefficients));
        const double low = smallest_coefficient<D>(part.coefficients);
        const bool close = low >= upper - slack * std::max(scale, std::abs(upper));
        if (close)
            finished = std::min(finished, low);
        else if (part.depth == 0)
            open = low;
        return !close;
    });
    // After an incomplete search only the bound before bisection is certain.
    return {complete ? finished : std::min(open, finished), depth};
}

template <class Jacobian>
bool straight_is_flat(const Jacobian& jacobian) {
    return !(std::abs(jacobian.straight) > 2 * jacobian.error);
}

template <class Jacobian>
double scaled_down(const Jacobian& jacobian, double low, double blur) {
    const double number = low - blur;
    const double scale = std::abs(jacobian.straight);
    const double ratio = number / (number > 0 ? scale + jacobian.error : scale - jacobian.error);
    return ratio - std::abs(ratio) * 0x1p-50;
}

/// Returns a lower bound that is at least half of the minimum, or 0 if rounding hides the minimum.
template <int D>
double positive_bound(const BoundedJacobian<D>& jacobian) {
    const auto low = smallest_value(jacobian, 0.5, 0);
    return std::max(scaled_down(jacobian, low.value, rounding_error_of(jacobian).after(low.depth)), 0.0);
}

}  // namespace

template <int D>
Verdict decide_by_coefficients(const BoundedJacobian<D>& jacobian, double bound) {
    const Threshold threshold = threshold_of(jacobian, bound);
    // NaN is neither valid nor invalid in these comparisons.
    bool all_above = true;
    for (const double x : jacobian.coefficients) all_above &= x > threshold.above(0);
    bool corner_below = false;
    for (const int i : corner_coefficients<D>) corner_below |= jacobian.coefficients[i] < threshold.below(0);
    return corner_below ? Verdict::invalid : all_above ? Verdict::valid : Verdict::undecided;
}

template <int D>
Certificate<D> certify_in_doubles(const BoundedJacobian<D>& jacobian, double bound) {
    Certificate<D> certificate{decide_by_coefficients(jacobian, bound), Level::filter, {}};
    if (certificate.verdict == Verdict::invalid)
        certificate.witness.emplace()[lowest_corner<D>(jacobian.coefficients)] = 1;
    if (certificate.verdict != Verdict::undecided || !finite(jacobian)) return certificate;
    certificate.level = Level::bisection;
    certificate.verdict = decide_by_bisection(
        jacobian, threshold_of_parts(jacobian, bound),
        [&](const JacobianPart<D>& part) { certificate.witness = part.corners[lowest_corner<D>(part.coefficients)]; });
    return certificate;
}

template <int D>
Verdict decide(const BoundedJacobian<D>& jacobian, double bound) {
    return certify_in_doubles(jacobian, bound).verdict;
}

namespace {

template <class Jacobian>
double scaled_coefficient(const Jacobian& jacobian, double low) {
    if (straight_is_flat(jacobian)) return low > jacobian.error ? infinity : -infinity;
    return scaled_down(jacobian, low, jacobian.error);
}

}  // namespace

template <int D>
double smallest_scaled_coefficient(const BoundedJacobian<D>& jacobian) {
    if (!finite(jacobian)) return -infinity;
    return scaled_coefficient(jacobian, smallest_coefficient<D>(jacobian.coefficients));
}

double smallest_scaled_coefficient(const JacobianSummary& jacobian) {
    return jacobian.is_finite() ? scaled_coefficient(jacobian, jacobian.lowest) : -infinity;
}

bool is_clear(const JacobianSummary& jacobian, double bound) {
    return jacobian.is_finite() && jacobian.lowest > threshold_of(jacobian, bound).above(0) && !blurred(jacobian);
}

template <int D>
std::optional<Barycentric<D>> witness(const BoundedJacobian<D>& jacobian, double bound) {
    if (!finite(jacobian)) return {};
    std::optional<Barycentric<D>> point;
    decide_by_bisection(jacobian, threshold_of_parts(jacobian, bound), [&](const JacobianPart<D>& part) {
        point = part.corners[lowest_corner<D>(part.coefficients)];
    });
    return point;
}

template <int D>
ElementValidity check_element(const BoundedJacobian<D>& jacobian, double bound) {
    ElementValidity validity;
    validity.verdict = decide(jacobian, bound);
    validity.straight_inverted = !(jacobian.straight > jacobian.error);
    if (!finite(jacobian)) {
        validity.min_scaled_jacobian = -infinity;
    } else if (straight_is_flat(jacobian)) {
        validity.min_scaled_jacobian = decide(jacobian, 0) == Verdict::valid ? infinity : -infinity;
    } else {
        const auto low = smallest_value(jacobian, 0.5 * scaled_jacobian_tolerance, std::abs(jacobian.straight));
        validity.min_scaled_jacobian = scaled_down(jacobian, low.value, rounding_error_of(jacobian).after(low.depth));
        // If the minimum is near the bound, the verdict proves more than the computed value does.
        if (validity.verdict == Verdict::valid)
            validity.min_scaled_jacobian = std::max(validity.min_scaled_jacobian, bound);
        if (!(validity.min_scaled_jacobian > 0) &&
            (validity.verdict == Verdict::valid || (bound > 0 && decide(jacobian, 0) == Verdict::valid)))
            validity.min_scaled_jacobian = positive_bound(jacobian);
    }
    return validity;
}

namespace {

template <int D, int K = D>
bool all_finite(const std::array<Vec<D>, quadratic_nodes<K>>& points) {
    for (const Vec<D>& p : points)
        if (!is_finite(p)) return false;
    return true;
}

template <int D, class Element>
ElementValidity check_by_levels(const Element& element, bool element_is_finite, double bound) {
    const BoundedJacobian<D> plain = bounded_jacobian(element);
    if (!blurred(plain)) {
        const ElementValidity validity = check_element(plain, bound);
        if (validity.verdict != Verdict::undecided) return validity;
    }
    const BoundedJacobian<D> sharp = double_double_jacobian(element);
    ElementValidity validity = check_element(finite(sharp) ? sharp : plain, bound);
    if (!element_is_finite) {
        validity.verdict = Verdict::invalid;
    } else if (validity.verdict == Verdict::undecided) {
        validity.verdict = certify_exactly(element, bound).verdict;
        if (validity.verdict == Verdict::valid)
            validity.min_scaled_jacobian = std::max({validity.min_scaled_jacobian, bound, 0.0});
    }
    return validity;
}

template <int D, class Element>
ElementValidity check(const Element& element, bool element_is_finite, double bound) {
    ElementValidity validity = check_by_levels<D>(element, element_is_finite, bound);
    double& least = validity.min_scaled_jacobian;
    if (least > 0 || !std::isfinite(least)) return validity;
    if (validity.verdict != Verdict::valid && (!(bound > 0) || certify(element, 0).verdict != Verdict::valid))
        return validity;
    const BoundedJacobian<D> sharp = double_double_jacobian(element);
    least = finite(sharp) && !straight_is_flat(sharp) ? positive_bound(sharp) : 0;
    return validity;
}

}  // namespace

template <int D>
Verdict decide(const NodalSimplex<D>& element, double bound) {
    // Most of the very many calls are decided by the filter alone.
    const Verdict first = decide_by_coefficients(bounded_jacobian(element), bound);
    return first != Verdict::undecided ? first : certify(element, bound).verdict;
}

template <int D>
ElementValidity check_element(const QuadraticSimplex<D, D>& element, double bound) {
    return check<D>(element, all_finite<D>(element.control), bound);
}

template <int D>
ElementValidity check_element(const NodalSimplex<D>& element, double bound) {
    return check<D>(element, all_finite<D>(element.nodes), bound);
}

Verdict decide(const SurfaceTriangle& triangle, double bound) {
    const Verdict first = decide_by_coefficients(bounded_jacobian(triangle), bound);
    return first != Verdict::undecided ? first : certify(triangle, bound).verdict;
}

ElementValidity check_element(const SurfaceTriangle& triangle, double bound) {
    return check<2>(triangle, all_finite<3, 2>(triangle.nodes), bound);
}

namespace {

template <int D, class Element, class Points>
Certificate<D> by_levels(const Element& element, const Points& points, double bound) {
    Certificate<D> certificate = certify_in_doubles<D>(bounded_jacobian(element), bound);
    if (certificate.verdict != Verdict::undecided) return certificate;
    if (!std::all_of(points.begin(), points.end(), [](const auto& p) { return is_finite(p); }))
        return {Verdict::invalid, Level::filter, {}};
    certificate = certify_in_doubles<D>(double_double_jacobian(element), bound);
    certificate.level = Level::twice;
    if (certificate.verdict != Verdict::undecided) return certificate;
    return certify_exactly(element, bound);
}

}  // namespace

template <int D>
Certificate<D> certify(const NodalSimplex<D>& element, double bound) {
    return by_levels<D>(element, element.nodes, bound);
}

template <int D>
Certificate<D> certify(const QuadraticSimplex<D, D>& element, double bound) {
    return by_levels<D>(element, element.control, bound);
}

Certificate<2> certify(const SurfaceTriangle& triangle, double bound) {
    return by_levels<2>(triangle, triangle.nodes, bound);
}

#define CAMBER_INSTANTIATE(D)                                                             \
    template Certificate<D> certify_in_doubles<D>(const BoundedJacobian<D>&, double);     \
    template Verdict decide<D>(const BoundedJacobian<D>&, double);                        \
    template Verdict decide<D>(const NodalSimplex<D>&, double);                           \
    template Verdict decide_by_coefficients<D>(const BoundedJacobian<D>&, double);        \
    template double smallest_scaled_coefficient<D>(const BoundedJacobian<D>&);            \
    template std::optional<Barycentric<D>> witness<D>(const BoundedJacobian<D>&, double); \
    template ElementValidity check_element<D>(const BoundedJacobian<D>&, double);         \
    template ElementValidity check_element<D>(const QuadraticSimplex<D, D>&, double);     \
    template ElementValidity check_element<D>(const NodalSimplex<D>&, double);            \
    template Certificate<D> certify<D>(const NodalSimplex<D>&, double);                   \
    template Certificate<D> certify<D>(const QuadraticSimplex<D, D>&, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
