module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <optional>
#include <utility>
#include <vector>
#include <boost/multiprecision/cpp_int.hpp>
module camber.validity;
import camber.core;
import camber.bezier;

// Decides validity without rounding. Doubles are integer multiples of a power of two. The power of each axis is
// factored out, because it multiplies det J and det of the straight element alike. All values are then integers, and
// bisection needs no division.
namespace camber {

/// 512 bits in place suffice for a typical tetrahedron; larger values use the heap.
using Integer =
    boost::multiprecision::number<boost::multiprecision::cpp_int_backend<512>, boost::multiprecision::et_off>;

namespace {

constexpr int longest_path = exact_depth;

/// det J on a part (Bernstein coefficients of degree D) and det of the straight element, in one unit. `path`: the
/// bisections that lead to the part, each as 2 · local edge + side.
template <int D>
struct ExactJacobian {
    std::array<Integer, jacobian_coefficients<D>> values{};
    Integer straight{};
    std::array<std::uint8_t, longest_path> path{};
    int depth = 0;
};

/// Halving is deferred: after m of n bisections, a sum is 2^m times too large. Doubles are multiplied by 2⁻ᵐ (exact
/// except for underflow), integers by 2^(n−m), so that all integers grow by 2ⁿ.
double halved(double x, int m, int) { return x * (1.0 / (1 << m)); }
Integer halved(const Integer& x, int m, int n) { return x << (n - m); }

template <int D>
ExactJacobian<D> half(ExactJacobian<D> part, int edge, int side) {
    part.path[part.depth++] = static_cast<std::uint8_t>(2 * edge + side);
    const int from = local_edges<D>[edge][side];
    for (const auto [target, source] : bisections<D>[edge][side]) part.values[target] += part.values[source];
    for (int p = 0; p < jacobian_coefficients<D>; ++p)
        part.values[p] = halved(part.values[p], jacobian_indices<D>[p][from], D);
    part.straight = halved(part.straight, 0, D);
    return part;
}

template <int D>
int most_bent_edge(const ExactJacobian<D>& part) {
    int most = 0;
    Integer largest{};
    const auto& c = part.values;
    for (int e = 0; e < edges_per_simplex<D>; ++e)
        for (const auto& [i, m, j] : second_differences<D>[e]) {
            Integer size = (c[i] - c[m]) + (c[j] - c[m]);
            if (size < 0) size = -size;
            if (size > largest) {
                most = e;
                largest = std::move(size);
            }
        }
    return most;
}

template <int D>
int lowest_corner(const ExactJacobian<D>& part) {
    int lowest = 0;
    for (int i = 1; i <= D; ++i)
        if (part.values[corner_coefficients<D>[i]] < part.values[corner_coefficients<D>[lowest]]) lowest = i;
    return lowest;
}

enum class PartVerdict : std::uint8_t { good, bad, split };

struct SearchLimits {
    int depth, parts;
};

/// Searches parts depth first; the half with the lower corner value is next. `bad(part)` receives the part that ends
/// the search. Undecided if a limit was reached.
template <int D, class Look, class Bad>
Verdict search(ExactJacobian<D> whole, const SearchLimits& limits, Look&& look, Bad&& bad) {
    std::vector<ExactJacobian<D>> stack;
    stack.push_back(std::move(whole));
    bool ambiguous = false;
    for (int parts = 0; !stack.empty(); ++parts) {
        if (parts >= limits.parts) return Verdict::undecided;
        const ExactJacobian<D> part = std::move(stack.back());
        stack.pop_back();
        const PartVerdict verdict = look(part);
        if (verdict == PartVerdict::good) continue;
        if (verdict == PartVerdict::bad) {
            bad(part);
            return Verdict::invalid;
        }
        if (part.depth >= limits.depth) {
            ambiguous = true;
            continue;
        }
        const int edge = most_bent_edge(part);
        auto first = half(part, edge, 0);
        auto second = half(part, edge, 1);
        if (first.values[corner_coefficients<D>[lowest_corner(first)]] <
            second.values[corner_coefficients<D>[lowest_corner(second)]])
            std::swap(first, second);
        stack.push_back(std::move(first));
        stack.push_back(std::move(second));
    }
    return ambiguous ? Verdict::undecided : Verdict::valid;
}

/// Barycentric weights of the corners of a part. Integers are exact up to a power of two, doubles up to 52 bisections.
template <class Weight, int D>
std::array<std::array<Weight, D + 1>, D + 1> place_of(const ExactJacobian<D>& part) {
    std::array<std::array<Weight, D + 1>, D + 1> corners{};
    for (int i = 0; i <= D; ++i) corners[i][i] = 1;
    for (int n = 0; n < part.depth; ++n) {
        const int edge = part.path[n] / 2;
        const int side = part.path[n] % 2;
        const int from = local_edges<D>[edge][side];
        const int to = local_edges<D>[edge][1 - side];
        for (int v = 0; v <= D; ++v) corners[from][v] += corners[to][v];
        for (int i = 0; i <= D; ++i)
            for (int v = 0; v <= D; ++v) corners[i][v] = halved(corners[i][v], i == from, 1);
    }
    return corners;
}

/// mantissa · 2^exponent; the mantissa is odd or 0.
struct Dyadic {
    std::int64_t mantissa = 0;
    int exponent = 0;
};
Dyadic dyadic(double x) {
    if (x == 0) return {};
    int exponent = 0;
    const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));
    const int zeros = std::countr_zero(static_cast<std::uint64_t>(mantissa));
    return {mantissa >> zeros, exponent - 53 + zeros};
}

template <int D>
using Points = std::array<Vec<D>, quadratic_nodes<D>>;
template <int D>
using IntegerPoints = std::array<std::array<Integer, D>, quadratic_nodes<D>>;

template <int D>
int common_exponent(const Points<D>& points, int c) {
    int lowest = 2000;
    for (const Vec<D>& p : points)
        if (p[c] != 0) lowest = std::min(lowest, dyadic(p[c]).exponent);
    return lowest;
}

template <int D>
IntegerPoints<D> integers(const Points<D>& points) {
    IntegerPoints<D> out;
    for (int c = 0; c < D; ++c) {
        const int lowest = common_exponent<D>(points, c);
        for (int i = 0; i < quadratic_nodes<D>; ++i) {
            const Dyadic x = dyadic(points[i][c]);
            if (x.mantissa != 0) out[i][c] = Integer(x.mantissa) << (x.exponent - lowest);
        }
    }
    return out;
}

enum class Form : std::uint8_t { nodes, control_points };

template <int D>
ColumnPoints<D, Integer> doubled_columns(const IntegerPoints<D>& n, Form form) {
    ColumnPoints<D, Integer> d;
    for (int a = 1; a <= D; ++a)
        for (int i = 0; i <= D; ++i)
            for (int c = 0; c < D; ++c) {
                const Integer chord = n[node_between<D>[i][a]][c] - n[node_between<D>[i][0]][c];
                d[a - 1][i][c] = form == Form::nodes ? Integer(4 * chord - (n[a][c] - n[0][c])) : Integer(2 * chord);
            }
    return d;
}

/// For each α: the sum of the determinants of the column vectors over all ordered D-tuples of vertices with sum α. It
/// is multinomial(α) / 2^D times the coefficient.
template <int D>
std::array<Integer, jacobian_coefficients<D>> ordered_sums(const ColumnPoints<D, Integer>& d) {
    const auto pairs = [&]<std::size_t... B>(std::index_sequence<B...>) {
        return std::array{pair_product<D, B>(d)...};
    }(std::make_index_sequence<node_count<2, D>>{});
    std::array<Integer, jacobian_coefficients<D>> sums;
    for (int b = 0; b < node_count<2, D>; ++b)
        if constexpr (D == 2) {
            sums[b] = pairs[b][0];
        } else {
            for (int i = 0; i <= D; ++i) {
                auto alpha = multi_indices<2, D>[b];
                ++alpha[i];
                Integer& sum = sums[position<D, D>(alpha)];
                for (int c = 0; c < D; ++c) sum += d[0][i][c] * pairs[b][c];
            }
        }
    return sums;
}

template <int D>
std::array<std::array<Integer, D>, D> straight_edges(const IntegerPoints<D>& n) {
    std::array<std::array<Integer, D>, D> edges;
    for (int a = 1; a <= D; ++a)
        for (int c = 0; c < D; ++c) edges[a - 1][c] = n[a][c] - n[0][c];
    return edges;
}

template <int D>
ExactJacobian<D> exact_jacobian(const Points<D>& points, Form form, double bound) {
    const IntegerPoints<D> n = integers<D>(points);
    // Common unit: D!, times the power of two that makes the bound an integer.
    constexpr int unit = D == 2 ? 2 : 6;
    const Dyadic requested = bound > 0 ? dyadic(bound) : Dyadic{};
    ExactJacobian<D> t;
    t.values = ordered_sums<D>(doubled_columns<D>(n, form));
    for (int p = 0; p < jacobian_coefficients<D>; ++p) {
        t.values[p] *= unit / static_cast<int>(multinomial<D>(jacobian_indices<D>[p]));
        t.values[p] <<= std::max(0, -requested.exponent);
    }
    t.straight = determinant<D, Integer>(straight_edges<D>(n));
    t.straight *= Integer(requested.mantissa) * unit;
    t.straight <<= std::max(0, requested.exponent);
    return t;
}

Integer magnitude_of(const Integer& x) { return x < 0 ? Integer(-x) : x; }

bool holds(const Integer& value, const Integer& least) { return value > 0 && value >= least; }

template <int D>
PartVerdict judge(const ExactJacobian<D>& part) {
    const Integer least = magnitude_of(part.straight);
    for (const int i : corner_coefficients<D>)
        if (!holds(part.values[i], least)) return PartVerdict::bad;
    const bool good = std::ranges::all_of(part.values, [&](const Integer& c) { return holds(c, least); });
    return good ? PartVerdict::good : PartVerdict::split;
}

template <int D>
using Weights = std::array<Integer, D + 1>;

/// Returns Σ multinomial(α) w^α c_α, which is (Σw)^D det J at w/Σw.
template <int D>
Integer value_at(const ExactJacobian<D>& t, const Weights<D>& w) {
    Integer value;
    for (int p = 0; p < jacobian_coefficients<D>; ++p) {
        Integer term = t.values[p] * static_cast<int>(multinomial<D>(jacobian_indices<D>[p]));
        for (int i = 0; i <= D; ++i)
            for (int m = 0; m < jacobian_indices<D>[p][i]; ++m) term *= w[i];
        value += term;
    }
    return value;
}

template <int D>
Integer size_of(const Weights<D>& w) {
    Integer sum, size = 1;
    for (const Integer& x : w) sum += x;
    for (int i = 0; i < D; ++i) size *= sum;
    return size;
}

template <int D>
bool fails_at(const ExactJacobian<D>& t, const Weights<D>& w) {
    return !holds(value_at<D>(t, w), Integer(magnitude_of(t.straight) * size_of<D>(w)));
}

template <int D>
Weights<D> whole_weights(const Barycentric<D>& point) {
    int lowest = 2000;
    for (const double x : point)
        if (x != 0) lowest = std::min(lowest, dyadic(x).exponent);
    Weights<D> w;
    for (int i = 0; i <= D; ++i) {
        const Dyadic x = dyadic(point[i]);
        if (x.mantissa != 0) w[i] = Integer(x.mantissa) << (x.exponent - lowest);
    }
    return w;
}

template <int D, class Still>
std::optional<Barycentric<D>> in_doubles(Weights<D> w, Still&& still) {
    Integer common = 0;
    Integer sum;
    for (const Integer& x : w) {
        common = boost::multiprecision::gcd(common, x);
        sum += x;
    }
    sum /= common;
    unsigned longest = 0;
    for (Integer& x : w) {
        x /= common;
        if (x != 0) longest = std::max<unsigned>(longest, static_cast<unsigned>(msb(x)));
    }
    if (longest > 1000)
        for (Integer& x : w) x >>= longest - 1000;
    Barycentric<D> point;
    for (int i = 0; i <= D; ++i) point[i] = w[i].template convert_to<double>();
    const bool power_of_two = (sum & (sum - 1)) == 0;
    if (longest <= 1000 && power_of_two)
        for (double& x : point) x = std::ldexp(x, -static_cast<int>(msb(sum)));
    if (!still(whole_weights<D>(point))) return {};
    return point;
}

template <int D>
Certificate<D> refuted(const ExactJacobian<D>& whole, const Weights<D>& w) {
    return {Verdict::invalid, Level::exact,
            in_doubles<D>(w, [&](const Weights<D>& taken) { return fails_at<D>(whole, taken); })};
}

/// Decides in closed form, by the minimum over the weights w of the quadratic form wᵀ M w = det J − bound |det
/// straight| (docs/algorithms/validity.md). 1ᵀ adj(M) 1 is the determinant of the form on Σw = 0.
Certificate<2> decide_triangle(const ExactJacobian<2>& t) {
    const Integer least = magnitude_of(t.straight);
    const bool touching_fails = least == 0;  // the condition is det J > 0 if `least` is 0, else det J ≥ least
    const auto fails = [&](const Integer& x) { return x < 0 || (touching_fails && x == 0); };
    std::array<std::array<Integer, 3>, 3> m;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            MultiIndex<2> alpha{};
            ++alpha[i], ++alpha[j];
            m[i][j] = t.values[position<2, 2>(alpha)] - least;
        }
    for (int i = 0; i < 3; ++i)
        if (fails(m[i][i])) {
            Weights<2> w;
            w[i] = 1;
            return refuted<2>(t, w);
        }
    for (const auto& [i, j] : local_edges<2>)
        if (m[i][j] < 0 && fails(m[i][i] * m[j][j] - m[i][j] * m[i][j])) {
            Weights<2> w;
            w[i] = m[j][j] - m[i][j];
            w[j] = m[i][i] - m[i][j];
            return refuted<2>(t, w);
        }
    Weights<2> w;  // adj(M) 1
    Integer determinant_of_m;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            const Integer cofactor = m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1];
            w[i] += cofactor;
            if (i == 0) determinant_of_m += m[i][j] * cofactor;
        }
    const bool inside = w[0] > 0 && w[1] > 0 && w[2] > 0 && m[0][0] - 2 * m[0][1] + m[1][1] > 0;
    if (inside && fails(determinant_of_m)) return refuted<2>(t, w);
    return {Verdict::valid, Level::exact, {}};
}

/// Returns small integer weights near a point where the condition fails, if there are any. Bisection never reaches
/// rational points such as 1/3, where a cubic may touch 0 (docs/algorithms/validity.md).
std::optional<Weights<3>> rational_failure(const ExactJacobian<3>& whole, const ExactJacobian<3>& part) {
    const auto corners = place_of<double>(part);
    const auto& near = corners[lowest_corner(part)];
    const double blur = std::ldexp(1.0, 3 - part.depth / 3);
    for (int q = 1; q <= (part.depth < 48 ? 64 : 1024); ++q) {
        std::array<int, 4> w{};
        int left = q;
        bool close = true;
        for (int i = 0; i < 4; ++i) {
            w[i] = static_cast<int>(std::lround(q * near[i]));
            left -= w[i];
            close = close && std::abs(q * near[i] - w[i]) < std::min(0.25, q * blur + 1e-9);
        }
        if (!close || left != 0) continue;
        const Weights<3> weights{Integer(w[0]), Integer(w[1]), Integer(w[2]), Integer(w[3])};
        if (fails_at<3>(whole, weights)) return weights;
    }
    return {};
}

Certificate<3> decide_tetrahedron(const ExactJacobian<3>& whole) {
    Certificate<3> certificate{Verdict::undecided, Level::exact, {}};
    Weights<3> failure;
    bool found = false;
    int tries = 0;
    certificate.verdict = search<3>(
        whole, {exact_depth, exact_parts},
        [&](const ExactJacobian<3>& part) {
            const PartVerdict verdict = judge(part);
            if (verdict != PartVerdict::split || part.depth == 0 || part.depth % 24 != 0 || tries >= 10) return verdict;
            ++tries;
            if (const auto w = rational_failure(whole, part)) {
                failure = *w;
                found = true;
                return PartVerdict::bad;
            }
            return verdict;
        },
        [&](const ExactJacobian<3>& part) {
            if (!found) failure = place_of<Integer>(part)[lowest_corner(part)];
        });
    if (certificate.verdict == Verdict::invalid) return refuted<3>(whole, failure);
    return certificate;
}

int common_exponent(const SurfaceTriangle& t) {
    int lowest = 2000;
    for (const Vec<3>& p : t.nodes)
        for (const double x : p.c)
            if (x != 0) lowest = std::min(lowest, dyadic(x).exponent);
    return lowest;
}

/// Returns the node coordinates as integers times a power of two. All axes have the same power, because products are
/// summed over the axes.
std::array<std::array<Integer, 3>, quadratic_nodes<2>> integers_of(const SurfaceTriangle& t) {
    const int lowest = common_exponent(t);
    std::array<std::array<Integer, 3>, quadratic_nodes<2>> out;
    for (int i = 0; i < quadratic_nodes<2>; ++i)
        for (int c = 0; c < 3; ++c) {
            const Dyadic x = dyadic(t.nodes[i][c]);
            if (x.mantissa != 0) out[i][c] = Integer(x.mantissa) << (x.exponent - lowest);
        }
    return out;
}

ExactJacobian<2> exact_jacobian(const SurfaceTriangle& triangle, double bound) {
    const auto n = integers_of(triangle);
    SurfaceColumns<Integer> d;  // the columns, multiplied by 2
    std::array<std::array<Integer, 3>, 2> edges;
    for (int a = 1; a <= 2; ++a)
        for (int c = 0; c < 3; ++c) {
            edges[a - 1][c] = n[a][c] - n[0][c];
            for (int i = 0; i <= 2; ++i)
                d[a - 1][i][c] = 4 * (n[node_between<2>[i][a]][c] - n[node_between<2>[i][0]][c]) - edges[a - 1][c];
        }
    const auto normal = product(edges[0], edges[1]);
    const auto along = [&](const std::array<Integer, 3>& v) {
        return Integer(v[0] * normal[0] + v[1] * normal[1] + v[2] * normal[2]);
    };
    constexpr int unit = 2;
    const Dyadic requested = bound > 0 ? dyadic(bound) : Dyadic{};
    const auto sums = normal_sums<Integer>(d);
    ExactJacobian<2> t;
    for (int p = 0; p < jacobian_coefficients<2>; ++p) {
        t.values[p] = along(sums[p]) * (unit / static_cast<int>(multinomial<2>(jacobian_indices<2>[p])));
        t.values[p] <<= std::max(0, -requested.exponent);
    }
    t.straight = along(normal) * (Integer(requested.mantissa) * unit);
    t.straight <<= std::max(0, requested.exponent);
    return t;
}

bool usable(double bound) { return std::isfinite(bound); }

template <int D>
bool all_finite(const Points<D>& points) {
    return std::all_of(points.begin(), points.end(), [](const Vec<D>& p) { return is_finite(p); });
}

template <int D>
Certificate<D> decide_exactly(const Points<D>& points, Form form, double bound) {
    if (!all_finite<D>(points)) return {Verdict::invalid, Level::filter, {}};
    if (!usable(bound)) return {Verdict::undecided, Level::filter, {}};
    try {
        const auto whole = exact_jacobian<D>(points, form, bound);
        if constexpr (D == 2)
            return decide_triangle(whole);
        else
            return decide_tetrahedron(whole);
    } catch (const std::bad_alloc&) {
        return {Verdict::undecided, Level::exact, {}};  // out of memory must not give `valid`
    }
}

/// Returns n/d · 2^exponent, exact or rounded up, with the sign of n.
double rounded_up(const Integer& n, const Integer& d, int exponent) {
    if (n == 0) return 0;
    const Integer size = magnitude_of(n);
    const int shift = 64 - (static_cast<int>(msb(size)) - static_cast<int>(msb(d)));
    const Integer above = shift > 0 ? Integer(size << shift) : size;
    const Integer below = shift < 0 ? Integer(d << -shift) : d;
    const Integer quotient = above / below;
    const auto nearest = quotient.template convert_to<double>();
    const double x = std::ldexp(n < 0 ? -nearest : nearest, exponent - shift);
    const bool is_exact = std::abs(x) >= std::numeric_limits<double>::min() && std::isfinite(x) &&
                          quotient * below == above && Integer(nearest) == quotient;
    const double up = is_exact ? x : std::nextafter(x, std::numeric_limits<double>::infinity());
    return n < 0 ? std::min(up, -std::numeric_limits<double>::denorm_min()) : up;
}

template <int D>
Weights<D> in_digits(const Barycentric<D>& point, int digits) {
    double sum = 0;
    for (const double x : point) sum += x;
    Weights<D> w;
    Integer left = Integer(1) << digits;
    for (int i = 0; i <= D; ++i) {
        w[i] = Integer(std::llround(std::ldexp(point[i] / sum, digits)));
        left -= w[i];
    }
    *std::max_element(w.begin(), w.end()) += left;
    return w;
}

template <int D>
class FailureSearch {
  public:
    /// `full`: Jacobian for the bound 1, with det J in units of 2^exponent.
    FailureSearch(ExactJacobian<D> requested, ExactJacobian<D> full, int exponent)
        : requested_(std::move(requested)), full_(std::move(full)), exponent_(exponent) {}

    [[nodiscard]] std::optional<Failure<D>> near(const Barycentric<D>& place) const {
        const Weights<D> exactly = whole_weights<D>(place);
        if (!fails_at<D>(requested_, exactly)) return {};
        const double low = scaled(exactly);
        const double enough = low + scaled_jacobian_tolerance * std::max(1.0, std::abs(low));
        for (const int digits : {6, 8, 10, 12, 14, 16, 20, 24, 32, 40, 52}) {
            const Weights<D> w = in_digits<D>(place, digits);
            if (!fails_at<D>(requested_, w) || scaled(w) > enough) continue;
            Barycentric<D> at{};
            for (int i = 0; i <= D; ++i) at[i] = std::ldexp(w[i].template convert_to<double>(), -digits);
            return Failure<D>{at, value(w), scaled(w)};
        }
        return Failure<D>{place, value(exactly), low};
    }

  private:
    [[nodiscard]] double value(const Weights<D>& w) const {
        constexpr int unit = D == 2 ? 2 : 6;
        return rounded_up(value_at<D>(full_, w), size_of<D>(w) * unit, exponent_);
    }
    [[nodiscard]] double scaled(const Weights<D>& w) const {
        const Integer v = value_at<D>(full_, w), straight = magnitude_of(full_.straight);
        if (straight != 0) return rounded_up(v, straight * size_of<D>(w), 0);
        constexpr double infinity = std::numeric_limits<double>::infinity();
        return v > 0 ? infinity : v < 0 ? -infinity : 0;
    }

    ExactJacobian<D> requested_, full_;
    int exponent_;
};

template <int D, class Element>
std::optional<Failure<D>> failure_of(const FailureSearch<D>& search, const Element& element, double bound,
                                     const Barycentric<D>& near) {
    if (const auto found = search.near(near)) return found;
    const Certificate<D> certificate = certify(element, bound);
    return certificate.verdict == Verdict::invalid && certificate.witness ? search.near(*certificate.witness)
                                                                          : std::nullopt;
}

}  // namespace

template <int D>
std::optional<Failure<D>> find_failure(const NodalSimplex<D>& element, double bound, const Barycentric<D>& near) {
    if (!all_finite<D>(element.nodes) || !usable(bound)) return {};
    try {
        const Points<D>& nodes = element.nodes;
        int exponent = 0;
        for (int c = 0; c < D; ++c) exponent += common_exponent<D>(nodes, c);
        return failure_of<D>(FailureSearch<D>(exact_jacobian<D>(nodes, Form::nodes, bound),
                                              exact_jacobian<D>(nodes, Form::nodes, 1), exponent),
                             element, bound, near);
    } catch (const std::bad_alloc&) {
        return {};
    }
}

std::optional<Failure<2>> find_failure(const SurfaceTriangle& triangle, double bound, const Barycentric<2>& near) {
    if (!std::all_of(triangle.nodes.begin(), triangle.nodes.end(), [](const Vec<3>& p) { return is_finite(p); }) ||
        !usable(bound))
        return {};
    try {
        return failure_of<2>(FailureSearch<2>(exact_jacobian(triangle, bound), exact_jacobian(triangle, 1),
                                              4 * common_exponent(triangle)),
                             triangle, bound, near);
    } catch (const std::bad_alloc&) {
        return {};
    }
}

template <int D>
Certificate<D> certify_exactly(const NodalSimplex<D>& element, double bound) {
    return decide_exactly<D>(element.nodes, Form::nodes, bound);
}

template <int D>
Certificate<D> certify_exactly(const QuadraticSimplex<D, D>& element, double bound) {
    return decide_exactly<D>(element.control, Form::control_points, bound);
}

Certificate<2> certify_exactly(const SurfaceTriangle& triangle, double bound) {
    if (!std::all_of(triangle.nodes.begin(), triangle.nodes.end(), [](const Vec<3>& p) { return is_finite(p); }))
        return {Verdict::invalid, Level::filter, {}};
    if (!usable(bound)) return {Verdict::undecided, Level::filter, {}};
    try {
        return decide_triangle(exact_jacobian(triangle, bound));
    } catch (const std::bad_alloc&) {
        return {Verdict::undecided, Level::exact, {}};
    }
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template std::optional<Failure<D>> find_failure<D>(const NodalSimplex<D>&, double, const Barycentric<D>&); \
    template Certificate<D> certify_exactly<D>(const NodalSimplex<D>&, double);                                \
    template Certificate<D> certify_exactly<D>(const QuadraticSimplex<D, D>&, double);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
