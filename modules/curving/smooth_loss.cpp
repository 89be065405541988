module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import :parts;
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

/// Sums over the elements, |K| each. Places are relative to an origin near them.
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
/// Of each run.
template <int D>
[[nodiscard]] Outcome<std::vector<Sums<D>>> sums_of(const LinearMesh<D>& mesh, const OwnVertices& own,
                                                    const Vec<D>& origin, const Execution& execution) {
    return reduce_own(
        execution, mesh, own, Sums<D>{},
        [&](Sums<D>& sums, ElementId e) {
            const auto corners = corners_of(mesh, e);
            const auto [volume, square, height] = size_of<D>(corners);
            Vec<D> centre{};
            for (const Vec<D>& p : corners) centre += (1.0 / (D + 1)) * (p - origin);
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
    void add(std::span<const float> numbers) {
        for (const float x : numbers) ++counts_[std::bit_cast<std::uint32_t>(x) >> shift];
    }
    /// As numbers for others, and those of several, one after the other.
    [[nodiscard]] std::vector<double> counts() const { return counts_; }
    explicit Histogram(std::span<const double> counts = {}) {
        for (std::size_t i = 0; i < counts.size(); ++i) counts_[i % counts_.size()] += counts[i];
    }
    /// Σ g k², k = 1/(1 + (g/c)²).
    [[nodiscard]] double sum(double c) const {
        double sum = 0;
        for (std::uint32_t i = 0; i < counts_.size(); ++i) {
            if (counts_[i] == 0) continue;
            const double g = std::bit_cast<float>((i << shift) + (1U << (shift - 1)));
            const double k = 1 / (1 + (g / c) * (g / c));
            sum += counts_[i] * g * k * k;
        }
        return sum;
    }

  private:
    static constexpr int shift = 19;  // of 23 bits behind the point
    std::vector<double> counts_ = std::vector<double>(std::size_t{1} << (31 - shift), 0);  // whole numbers
};

/// The largest c for which the sum is within the budget; infinity where all are.
[[nodiscard]] double limit_for(const Histogram& histogram, double budget) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (histogram.sum(infinity) <= budget) return infinity;
    double low = -160, high = 128;  // of log2 c
    for (int i = 0; i < 40; ++i) {
        const double middle = (low + high) / 2;
        (histogram.sum(exp2(middle)) <= budget ? low : high) = middle;
    }
    return exp2(low);
}

/// Numbers of all parts, always as many a part or a run, one's after the other's: of_part(part) → Outcome of a vector.
template <int D>
Outcome<std::vector<double>> gathered(std::span<const PartLosses<D>> parts, BetweenParts<D>& between,
                                      const auto& of_part) {
    const auto here = [&]() -> Outcome<std::vector<double>> {
        std::vector<double> all;
        for (const PartLosses<D>& part : parts) {
            const auto numbers = of_part(part);
            if (!numbers) return fail(numbers.error());
            all.insert(all.end(), numbers->begin(), numbers->end());
        }
        return all;
    };
    return between.gather(here());
}

/// About the first vertex of all.
template <int D>
Outcome<Sums<D>> sums_of(std::span<const PartLosses<D>> parts, BetweenParts<D>& between, const Execution& execution) {
    const auto firsts = gathered(parts, between, [](const PartLosses<D>& of) -> Outcome<std::vector<double>> {
        std::vector<double> point(D, 0.0);
        if (of.owned.first < of.owned.last)
            for (int i = 0; i < D; ++i) point[static_cast<std::size_t>(i)] = of.mesh.linear.points[of.owned.first][i];
        return point;
    });
    if (!firsts) return fail(firsts.error());
    Vec<D> origin;
    for (int i = 0; i < D; ++i) origin[i] = (*firsts)[static_cast<std::size_t>(i)];
    const auto all = gathered(parts, between, [&](const PartLosses<D>& of) {
        return sums_of(of.mesh.linear, of.owned, origin, execution).map([](const std::vector<Sums<D>>& runs) {
            std::vector<double> numbers;
            for (const Sums<D>& s : runs) {
                numbers.insert(numbers.end(), {s.volume, s.fourth, s.sixth, s.second_moment});
                for (int i = 0; i < D; ++i) numbers.push_back(s.moment[i]);
            }
            return numbers;
        });
    });
    if (!all) return fail(all.error());
    Sums<D> sums;
    for (std::size_t at = 0; at < all->size(); at += 4 + D) {
        Sums<D> of{(*all)[at], (*all)[at + 1], (*all)[at + 2], (*all)[at + 3]};
        for (int i = 0; i < D; ++i) of.moment[i] = (*all)[at + 4 + static_cast<std::size_t>(i)];
        sums = sums + of;
    }
    return sums;
}

/// g_e of a part's own edges, in their order.
template <int D>
Outcome<Buffer<float>> costs_of(const PartLosses<D>& of, const Sums<D>& sums, const Execution& execution) {
    const auto weights = weights_of(of.mesh.linear, sums, part_of(execution, 0, 0.5));
    if (!weights) return fail(weights.error());
    const double per_product = 24 * 24 * sums.squared_radius_of_gyration() / edges_per_simplex<D>;
    return map_each(part_of(execution, 0.5, 1), of.offsets.size(), [&](std::size_t e) {
        const Vec<D>& d = of.offsets[e];
        if (d == Vec<D>{} || !of.owned.owns(of.mesh.edges.vertices[e])) return 0.0F;
        const auto& [a, b] = of.mesh.edges.vertices[EdgeId(e)];
        double around = 0;
        for (const ElementId k : of.shells[EdgeId(e)]) around += static_cast<double>((*weights)[k.index()]);
        const double square = norm_squared(of.mesh.linear.points[b] - of.mesh.linear.points[a]);
        return as_cost(per_product * norm_squared(d) * square * around);
    });
}

/// A part's own offsets multiplied by k_e; how many were more than halved.
template <int D>
Outcome<std::size_t> draw_back(const PartLosses<D>& of, const Buffer<float>& costs, double limit,
                               const Execution& execution) {
    return reduce_each(
        execution, of.offsets.size(), std::size_t{0},
        [&](std::size_t& halved, std::size_t e) {
            const double over = costs[e] / limit;
            const double kept = 1 / (1 + over * over);
            of.offsets[e] *= kept;
            halved += kept < 0.5;
        },
        [](std::size_t a, std::size_t b) { return a + b; });
}

}  // namespace

template <int D>
Outcome<std::size_t> limit_smooth_loss(std::span<const PartLosses<D>> parts, double loss, BetweenParts<D>& between,
                                       const Execution& execution) {
    const auto sums = sums_of(parts, between, part_of(execution, 0, 0.3));
    if (!sums) return fail(sums.error());
    if (!(sums->volume > 0)) return std::size_t{0};
    std::vector<Buffer<float>> costs;
    const auto count = [&]() -> Outcome<std::vector<double>> {
        Histogram histogram;
        for (const PartLosses<D>& part : parts) {
            auto of_part = costs_of(part, *sums, part_of(execution, 0.3, 0.9));
            if (!of_part) return fail(of_part.error());
            histogram.add({of_part->data(), of_part->size()});
            costs.push_back(std::move(*of_part));
        }
        return histogram.counts();
    };
    const auto counts = between.gather(count());
    if (!counts) return fail(counts.error());
    const double limit = limit_for(Histogram(*counts), (1 + loss) * (1 + loss) - 1);
    if (std::isinf(limit)) return std::size_t{0};
    std::size_t halved = 0;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        const auto of_part = draw_back(parts[p], costs[p], limit, part_of(execution, 0.9, 1));
        if (!of_part) return of_part;
        halved += *of_part;
    }
    return halved;
}

template <int D>
Outcome<std::size_t> limit_smooth_loss(const QuadraticMesh<D>& mesh, const Incidence<ElementId>& shells, double loss,
                                       std::span<Vec<D>> offsets, const Execution& execution) {
    OnePart<D> alone;
    const PartLosses<D> all{mesh, shells, whole(mesh.linear), offsets};
    return guarded([&] { return limit_smooth_loss<D>(std::span(&all, 1), loss, alone, execution); });
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Outcome<std::size_t> limit_smooth_loss<D>(std::span<const PartLosses<D>>, double, BetweenParts<D>&,     \
                                                       const Execution&);                                            \
    template Outcome<std::size_t> limit_smooth_loss<D>(const QuadraticMesh<D>&, const Incidence<ElementId>&, double, \
                                                       std::span<Vec<D>>, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
