module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>
module camber.curving;
import camber.core;
import :smooth_loss;

namespace camber {

namespace {

/// What the H1 error counts beside that in L2: with 0.1 both of cubics rise alike on shells with layers.
constexpr double h1_share = 0.1;

/// |K|, the mean of the squared edges, and the smallest height of a straight element.
template <int D>
struct ElementSize {
    double volume = 0, square = 0, height = 0;
};
template <int D>
[[nodiscard]] ElementSize<D> size_of(const std::array<Vec<D>, D + 1>& p) {
    double square = 0;
    for (int i = 0; i <= D; ++i)
        for (int j = 0; j < i; ++j) square += norm_squared(p[i] - p[j]);
    std::array<Vec<D>, D> c;
    for (int i = 0; i < D; ++i) c[i] = p[i + 1] - p[0];
    square /= edges_per_simplex<D>;
    if constexpr (D == 2) {
        const double area = std::abs(c[0][0] * c[1][1] - c[0][1] * c[1][0]) / 2;
        const double longest = std::max({norm(c[0]), norm(c[1]), norm(c[1] - c[0])});
        return {area, square, 2 * area / longest};
    } else {
        const double volume = std::abs(dot(cross(c[0], c[1]), c[2])) / 6;
        const double largest = std::max({norm(cross(c[0], c[1])), norm(cross(c[1], c[2])), norm(cross(c[2], c[0])),
                                         norm(cross(c[1] - c[0], c[2] - c[0]))});
        return {volume, square, 6 * volume / largest};
    }
}

template <int D>
[[nodiscard]] std::array<Vec<D>, D + 1> corners_of(const LinearMesh<D>& mesh, ElementId e) {
    std::array<Vec<D>, D + 1> corners;
    for (int i = 0; i <= D; ++i) corners[i] = mesh.points[mesh.elements.vertices[e][i]];
    return corners;
}

/// Sums over the elements, |K| each. Places are relative to the first vertex.
template <int D>
struct Sums {
    double volume = 0, fourth = 0, sixth = 0, second_moment = 0;
    Vec<D> moment{};

    friend Sums operator+(const Sums& a, const Sums& b) {
        return {a.volume + b.volume, a.fourth + b.fourth, a.sixth + b.sixth, a.second_moment + b.second_moment,
                a.moment + b.moment};
    }
    [[nodiscard]] double squared_radius_of_gyration() const {
        return std::max(second_moment / volume - norm_squared((1 / volume) * moment), 0.0);
    }
};
template <int D>
[[nodiscard]] Outcome<Sums<D>> sums_of(const LinearMesh<D>& mesh, const Execution& execution) {
    return reduce_each(
        execution, mesh.elements.size(), Sums<D>{},
        [&](Sums<D>& sums, std::size_t e) {
            const auto corners = corners_of(mesh, ElementId(e));
            const auto [volume, square, height] = size_of<D>(corners);
            Vec<D> centre{};
            for (const Vec<D>& p : corners) centre += (1.0 / (D + 1)) * (p - mesh.points[VertexId(0)]);
            sums = sums + Sums<D>{volume, volume * square * square, volume * square * square * square,
                                  volume * norm_squared(centre), volume * centre};
        },
        [](const Sums<D>& a, const Sums<D>& b) { return a + b; });
}

/// No number, and what is beyond a float, counts as the largest.
[[nodiscard]] float as_cost(double x) { return static_cast<float>(x < 1e38 ? x : 1e38); }

/// Of each element |K| (1/Σ|K|h⁶ + 0.1/(a_K² Σ|K|h⁴)); 0 of flat ones.
template <int D>
[[nodiscard]] Outcome<Buffer<float>> weights_of(const LinearMesh<D>& mesh, const Sums<D>& sums,
                                                const Execution& execution) {
    return map_each(execution, mesh.elements.size(), [&](std::size_t e) {
        const auto [volume, square, height] = size_of<D>(corners_of(mesh, ElementId(e)));
        if (!(volume > 0)) return 0.0F;
        return as_cost(volume * (1 / sums.sixth + h1_share / (height * height * sums.fourth)));
    });
}

/// How many numbers of about one size there are, sixteen sizes to a factor of two.
class Histogram {
  public:
    explicit Histogram(std::span<const float> numbers) {
        for (const float x : numbers) ++counts_[std::bit_cast<std::uint32_t>(x) >> shift];
    }
    /// Σ g k², k = 1/(1 + (g/c)²).
    [[nodiscard]] double sum(double c) const {
        double sum = 0;
        for (std::uint32_t i = 0; i < counts_.size(); ++i) {
            if (counts_[i] == 0) continue;
            const double g = std::bit_cast<float>((i << shift) + (1U << (shift - 1)));
            const double k = 1 / (1 + (g / c) * (g / c));
            sum += static_cast<double>(counts_[i]) * g * k * k;
        }
        return sum;
    }

  private:
    static constexpr int shift = 19;  // of 23 bits behind the point
    std::vector<std::size_t> counts_ = std::vector<std::size_t>(std::size_t{1} << (31 - shift), 0);
};

/// The largest c for which the sum is within the budget; infinity where all are.
[[nodiscard]] double limit_for(const Histogram& histogram, double budget) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (histogram.sum(infinity) <= budget) return infinity;
    double low = -160, high = 128;  // of log2 c
    for (int i = 0; i < 40; ++i) {
        const double middle = (low + high) / 2;
        (histogram.sum(std::exp2(middle)) <= budget ? low : high) = middle;
    }
    return std::exp2(low);
}

}  // namespace

template <int D>
Outcome<std::size_t> limit_smooth_loss(const QuadraticMesh<D>& mesh, const Incidence<ElementId>& shells, double loss,
                                       std::span<Vec<D>> offsets, const Execution& execution) {
    const auto sums = sums_of(mesh.linear, part_of(execution, 0, 0.3));
    if (!sums) return fail(sums.error());
    if (!(sums->volume > 0)) return std::size_t{0};
    const auto weights = weights_of(mesh.linear, *sums, part_of(execution, 0.3, 0.6));
    if (!weights) return fail(weights.error());
    const double per_product = 24 * 24 * sums->squared_radius_of_gyration() / edges_per_simplex<D>;
    const auto cost_of = [&](std::size_t e) {
        const Vec<D>& d = offsets[e];
        if (d == Vec<D>{}) return 0.0F;
        const auto& [a, b] = mesh.edges.vertices[EdgeId(e)];
        double around = 0;
        for (const ElementId k : shells[EdgeId(e)]) around += static_cast<double>((*weights)[k.index()]);
        const double square = norm_squared(mesh.linear.points[b] - mesh.linear.points[a]);
        return as_cost(per_product * norm_squared(d) * square * around);
    };
    const auto costs = map_each(part_of(execution, 0.6, 0.9), offsets.size(), cost_of);
    if (!costs) return fail(costs.error());
    const double limit = limit_for(Histogram({costs->data(), costs->size()}), (1 + loss) * (1 + loss) - 1);
    if (std::isinf(limit)) return std::size_t{0};
    return reduce_each(
        part_of(execution, 0.9, 1), offsets.size(), std::size_t{0},
        [&](std::size_t& halved, std::size_t e) {
            const double over = (*costs)[e] / limit;
            const double kept = 1 / (1 + over * over);
            offsets[e] *= kept;
            halved += kept < 0.5;
        },
        [](std::size_t a, std::size_t b) { return a + b; });
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Outcome<std::size_t> limit_smooth_loss<D>(const QuadraticMesh<D>&, const Incidence<ElementId>&, double, \
                                                       std::span<Vec<D>>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
