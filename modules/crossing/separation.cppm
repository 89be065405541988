module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
module camber.crossing:separation;
import camber.core;
import camber.bezier;
import :net;

/// Planes between Bézier nets. A direction is looked for without care (Gilbert, Johnson, Keerthi 1988); what it proves
/// is looked at with it.
namespace camber {

/// What n · (P − Q) must exceed in units of |n|_1: both coordinates err by `coordinate_blur`, and the sums round.
inline constexpr double separation_margin = 4 * coordinate_blur;

template <int D>
[[nodiscard]] inline double sum_of_sizes(const Vec<D>& n) {
    double sum = 0;
    for (const double x : n.c) sum += std::abs(x);
    return sum;
}

/// Points whose hull's place nearest to the origin is looked for.
template <int D>
struct Corral {
    std::array<Vec<D>, D + 1> points{};
    std::size_t size = 0;
};

/// The weights of `others` in the point nearest to the origin of the plane through `last` and them; none where they do
/// not span one.
template <int D>
[[nodiscard]] inline std::optional<std::array<double, D>> nearest_weights(const Vec<D>& last,
                                                                          std::span<const Vec<D>> others) {
    const std::size_t m = others.size();
    std::array<std::array<double, D + 1>, D> rows{};
    for (std::size_t i = 0; i < m; ++i) {
        for (std::size_t j = 0; j < m; ++j) rows[i][j] = dot(others[i] - last, others[j] - last);
        rows[i][D] = -dot(others[i] - last, last);
    }
    for (std::size_t p = 0; p < m; ++p) {
        if (!(rows[p][p] > 0)) return {};
        for (std::size_t r = 0; r < m; ++r) {
            if (r == p) continue;
            const double factor = rows[r][p] / rows[p][p];
            for (std::size_t c = p; c < m; ++c) rows[r][c] -= factor * rows[p][c];
            rows[r][D] -= factor * rows[p][D];
        }
    }
    std::array<double, D> weights{};
    for (std::size_t i = 0; i < m; ++i) weights[i] = rows[i][D] / rows[i][i];
    return weights;
}

/// The place nearest to the origin in the hull of the points, of which the last came in last; keeps those that it is
/// made of. None: the hull holds the origin.
template <int D>
[[nodiscard]] inline std::optional<Vec<D>> nearest_place(Corral<D>& corral) {
    const Vec<D> last = corral.points[corral.size - 1];
    const std::size_t others = corral.size - 1;
    Corral<D> best;
    Vec<D> nearest;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t mask = 0; mask < (std::size_t{1} << others); ++mask) {
        Corral<D> chosen;
        for (std::size_t i = 0; i < others; ++i)
            if ((mask >> i & 1U) != 0) chosen.points[chosen.size++] = corral.points[i];
        const auto weights = nearest_weights<D>(last, {chosen.points.data(), chosen.size});
        if (!weights) continue;
        double sum = 0;
        bool inside = true;
        Vec<D> place = last;
        for (std::size_t i = 0; i < chosen.size; ++i) {
            inside = inside && (*weights)[i] >= 0;
            sum += (*weights)[i];
            place += (chosen.points[i] - last) * (*weights)[i];
        }
        if (!inside || sum > 1) continue;
        if (chosen.size == D) return {};
        if (norm_squared(place) >= least) continue;
        least = norm_squared(place);
        nearest = place;
        chosen.points[chosen.size++] = last;
        best = chosen;
    }
    corral = best;
    return nearest;
}

/// A direction that has a positive product with every point of a set, tried from `start`: `lowest(n)` is the point of
/// the least product with n, and `proves(n)` looks whether the direction does.
template <int D, class Lowest, class Proves>
[[nodiscard]] inline bool finds_direction(Vec<D> start, Lowest&& lowest, Proves&& proves) {
    constexpr int max_tries = 12;
    Corral<D> corral;
    Vec<D> n = start;
    for (int i = 0; i < max_tries; ++i) {
        // So products with n do not vanish.
        if (!(norm_squared(n) > 0)) return false;
        if (proves(n)) return true;
        const Vec<D> point = lowest(n);
        // Not nearer than before: the hull touches the origin as far as these numbers can tell.
        if (i > 0 && dot(n, point) >= (1 - 0x1p-30) * norm_squared(n)) return false;
        corral.points[corral.size++] = point;
        const auto nearest = nearest_place(corral);
        if (!nearest || corral.size == 0) return false;
        n = *nearest;
    }
    return false;
}

/// Directions across the straight simplices of the corners: those of their normals, and of what is across an edge of
/// each. Where the gap is thin they tell what the search above is too coarse for.
template <class Try>
[[nodiscard]] inline bool some_normal(const Net<2>& first, const Net<2>& second, Try&& works) {
    const auto normal = [](const Net<2>& net) {
        const Vec<2> along = net.control[1] - net.control[0];
        return Vec<2>{{-along[1], along[0]}};
    };
    return works(normal(first)) || works(normal(second));
}
template <class Try>
[[nodiscard]] inline bool some_normal(const Net<3>& first, const Net<3>& second, Try&& works) {
    const auto edge = [](const Net<3>& net, int i) { return net.control[(i + 1) % 3] - net.control[i]; };
    if (works(cross(edge(first, 0), edge(first, 1))) || works(cross(edge(second, 0), edge(second, 1)))) return true;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (works(cross(edge(first, i), edge(second, j)))) return true;
    return false;
}

/// A plane lies between two nets: then the pieces have no point in common.
template <int D>
[[nodiscard]] inline bool separated(const Net<D>& first, const Net<D>& second) {
    const auto lowest_of = [](const Net<D>& net, const Vec<D>& n) {
        const auto less = [&](const Vec<D>& a, const Vec<D>& b) { return dot(a, n) < dot(b, n); };
        return *std::min_element(net.control.begin(), net.control.end(), less);
    };
    const auto difference = [&](const Vec<D>& n) { return lowest_of(first, n) - lowest_of(second, -n); };
    const auto proves = [&](const Vec<D>& n) {
        return dot(lowest_of(first, n), n) - dot(lowest_of(second, -n), n) > separation_margin * sum_of_sizes(n);
    };
    Vec<D> start;
    for (std::size_t i = 0; i < first.control.size(); ++i) start += first.control[i] - second.control[i];
    return finds_direction<D>(start, difference, proves) || some_normal(first, second, [&](const Vec<D>& n) {
               return norm_squared(n) > 0 && (proves(n) || proves(-n));
           });
}

/// A plane through the only point that the nets share, their corners i and j, has all other Bézier points of the one
/// net on its one side and those of the other on the other: n · F has Bernstein coefficients 0 at the point and
/// positive ones elsewhere, and is positive off the point. So they meet there alone.
template <int D>
[[nodiscard]] inline bool separated_at(const Net<D>& first, int i, const Net<D>& second, int j) {
    constexpr std::size_t n_vectors = 2 * (quadratic_nodes<D - 1> - 1);
    std::array<Vec<D>, n_vectors> vectors{}, units{};
    std::size_t count = 0;
    for (std::size_t k = 0; k < first.control.size(); ++k)
        if (k != static_cast<std::size_t>(i)) vectors[count++] = first.control[k] - first.control[i];
    for (std::size_t k = 0; k < second.control.size(); ++k)
        if (k != static_cast<std::size_t>(j)) vectors[count++] = second.control[j] - second.control[k];
    Vec<D> start;
    for (std::size_t k = 0; k < n_vectors; ++k) {
        units[k] = normalised(vectors[k]);
        start += units[k];
    }
    const auto lowest = [&](const Vec<D>& n) {
        const auto less = [&](const Vec<D>& a, const Vec<D>& b) { return dot(a, n) < dot(b, n); };
        return *std::min_element(units.begin(), units.end(), less);
    };
    return finds_direction<D>(start, lowest, [&](const Vec<D>& n) {
        const double margin = separation_margin * sum_of_sizes(n);
        return std::all_of(vectors.begin(), vectors.end(), [&](const Vec<D>& v) { return dot(v, n) > margin; });
    });
}

}  // namespace camber
