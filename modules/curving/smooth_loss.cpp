module;
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.extension;
import camber.validity;

namespace camber {

namespace {

/// Weight of the H1 error relative to the L2 error. With 0.1 both grow equally for cubic functions on layered shells.
constexpr double h1_share = 0.1;

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
[[nodiscard]] Outcome<std::vector<Sums<D>>> sums_of(const LinearMesh<D>& mesh, const OwnVertices& own,
                                                    const Vec<D>& origin, const Execution& execution) {
    return reduce_own(
        execution, OwnSimplices<D + 1>{mesh.elements.vertices.view(), mesh.points.size(), own}, Sums<D>{},
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

[[nodiscard]] float as_cost(double x) { return static_cast<float>(x < 1e38 ? x : 1e38); }

/// Returns |K| (1/Σ|K|h⁶ + 0.1/(a_K² Σ|K|h⁴)) for each element K; 0 if it is flat. h² is the mean squared edge length,
/// a_K the smallest height.
template <int D>
[[nodiscard]] Outcome<Buffer<float>> weights_of(const LinearMesh<D>& mesh, const Sums<D>& sums,
                                                const Execution& execution) {
    return map_each(execution, mesh.elements.size(), [&](std::size_t e) {
        const auto [volume, square, height] = size_of<D>(corners_of(mesh, ElementId(e)));
        if (!(volume > 0)) return 0.0F;
        return as_cost(volume * (1 / sums.sixth + h1_share / (height * height * sums.fourth)));
    });
}

class Histogram {
  public:
    void add(std::span<const float> numbers) {
        for (const float x : numbers) ++counts_[std::bit_cast<std::uint32_t>(x) >> shift];
    }
    [[nodiscard]] std::vector<double> counts() const { return counts_; }
    explicit Histogram(std::span<const double> counts = {}) {
        for (std::size_t i = 0; i < counts.size(); ++i) counts_[i % counts_.size()] += counts[i];
    }
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
    static constexpr int shift = 19;  // drops 19 of 23 mantissa bits
    std::vector<double> counts_ = std::vector<double>(std::size_t{1} << (31 - shift), 0);  // counts of offsets, as
                                                                                           // whole numbers
};

[[nodiscard]] double limit_for(const Histogram& histogram, double budget) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (histogram.sum(infinity) <= budget) return infinity;
    double low = -160, high = 128;  // bounds of log2 c
    for (int i = 0; i < 40; ++i) {
        const double middle = (low + high) / 2;
        (histogram.sum(exp2(middle)) <= budget ? low : high) = middle;
    }
    return exp2(low);
}

template <int D>
Outcome<std::vector<double>> gather_from_parts(std::span<const PartLosses<D>> parts, PartCommunication<D>& between,
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

template <int D>
Outcome<Sums<D>> sums_of(std::span<const PartLosses<D>> parts, PartCommunication<D>& between,
                         const Execution& execution) {
    const auto firsts = gather_from_parts(parts, between, [](const PartLosses<D>& of) -> Outcome<std::vector<double>> {
        std::vector<double> point(D, 0.0);
        if (of.owned.first < of.owned.last)
            for (int i = 0; i < D; ++i) point[static_cast<std::size_t>(i)] = of.mesh.linear.points[of.owned.first][i];
        return point;
    });
    if (!firsts) return fail(firsts.error());
    Vec<D> origin;
    for (int i = 0; i < D; ++i) origin[i] = (*firsts)[static_cast<std::size_t>(i)];
    const auto all = gather_from_parts(parts, between, [&](const PartLosses<D>& of) {
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

template <int D>
Outcome<std::size_t> relax_offsets(const PartLosses<D>& of, const Buffer<float>& costs, double limit,
                                   const Execution& execution) {
    return reduce_each(
        execution, of.offsets.size(), std::size_t{0},
        [&](std::size_t& halved, std::size_t e) {
            const double over = costs[e] / limit;
            const double factor = 1 / (1 + over * over);
            of.offsets[e] *= factor;
            halved += factor < 0.5;
        },
        [](std::size_t a, std::size_t b) { return a + b; });
}

}  // namespace

template <int D>
Outcome<std::size_t> limit_smooth_loss(std::span<const PartLosses<D>> parts, double loss, PartCommunication<D>& between,
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
        const auto of_part = relax_offsets(parts[p], costs[p], limit, part_of(execution, 0.9, 1));
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

namespace {

/// Maximum number of iterations, more than layers in any stack of elements. Repair handles the remaining elements.
constexpr int max_rounds = 1000;

/// Elements (K = D), or triangles of a standalone surface (K = 2, D = 3).
template <int D, int K>
class Elements {
  public:
    using Form = std::conditional_t<D == K, NodalSimplex<D>, SurfaceTriangle>;

    Elements(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> base, std::span<const Vec<D>> offsets)
        : mesh_(mesh), base_(base), offsets_(offsets) {}

    [[nodiscard]] Form at(std::size_t e, double share) const {
        const auto& vertices = simplices().vertices[e];
        const auto& edges = edges_of(e);
        Form element;
        for (int i = 0; i <= K; ++i) element.nodes[i] = mesh_.linear.points[vertices[i]];
        for (int k = 0; k < edges_per_simplex<K>; ++k)
            element.nodes[K + 1 + k] = base_of(edges[k]) + share * offsets_[edges[k].index()];
        return element;
    }

    [[nodiscard]] const Simplices<K>& simplices() const {
        if constexpr (D == K)
            return mesh_.linear.elements;
        else
            return mesh_.linear.facets;
    }
    [[nodiscard]] const std::array<EdgeId, edges_per_simplex<K>>& edges_of(std::size_t e) const {
        if constexpr (D == K)
            return mesh_.edges.of_elements[e];
        else
            return mesh_.edges.of_facets[e];
    }

    [[nodiscard]] static bool bears(const JacobianSummary& jacobian, double least) {
        return jacobian.is_finite() && scaled(jacobian.lowest, jacobian.straight) >= least;
    }

    [[nodiscard]] double share(std::size_t e, double least) const {
        double best = 1;
        if (stays(e)) return best;
        double highest = scaled_jacobian(e, 1);
        if (highest >= least) return best;
        for (const double share : {0.75, 0.5, 0.25, 0.0}) {
            const double lowest = scaled_jacobian(e, share);
            if (lowest >= least) return share;
            if (lowest > highest) best = share, highest = lowest;
        }
        return best;
    }

  private:
    [[nodiscard]] Vec<D> base_of(EdgeId edge) const {
        if (!base_.empty()) return base_[edge.index()].point;
        const auto& [a, b] = mesh_.edges.vertices[edge];
        return midpoint(mesh_.linear.points[a], mesh_.linear.points[b]);
    }
    [[nodiscard]] bool stays(std::size_t e) const {
        return std::ranges::all_of(edges_of(e), [&](EdgeId edge) { return offsets_[edge.index()] == Vec<D>{}; });
    }
    /// Divides by |straight|, the absolute Jacobian of the straight element. Thin elements along curves may be inverted
    /// when straight, but valid when curved.
    [[nodiscard]] static double scaled(double lowest, double straight) {
        constexpr double infinity = std::numeric_limits<double>::infinity();
        if (straight == 0) return lowest >= 0 ? infinity : -infinity;
        return lowest / std::abs(straight);
    }
    [[nodiscard]] double scaled_jacobian(std::size_t e, double share) const {
        const auto jacobian = bounded_jacobian(at(e, share));
        return scaled(*std::min_element(jacobian.coefficients.begin(), jacobian.coefficients.end()), jacobian.straight);
    }

    const QuadraticMesh<D>& mesh_;
    std::span<const LagrangeNode<D>> base_;
    std::span<const Vec<D>> offsets_;
};

template <int D>
void each_looked_at(const Elements<D, D>& elements, std::span<const ElementId> looked_at, std::size_t begin,
                    std::size_t end, const auto& visit) {
    each_jacobian_summary<D>(begin, end, [&](std::size_t i) { return elements.at(looked_at[i].index(), 1); }, visit);
}
void each_looked_at(const Elements<3, 2>& triangles, std::span<const ElementId> looked_at, std::size_t begin,
                    std::size_t end, const auto& visit) {
    for (std::size_t i = begin; i < end; ++i)
        visit(i, jacobian_summary(bounded_jacobian(triangles.at(looked_at[i].index(), 1))));
}

struct Share {
    ElementId element;
    double share = 1;
};
template <int D, int K>
Outcome<std::vector<Share>> shares_of(const Elements<D, K>& elements, std::span<const ElementId> looked_at,
                                      double least, const Execution& execution) {
    constexpr std::size_t grain = 4096;
    std::vector<std::vector<Share>> of_chunks((looked_at.size() + grain - 1) / grain);
    auto looked = each_chunk(
        execution, looked_at.size(),
        [&](std::size_t begin, std::size_t end) {
            each_looked_at(elements, looked_at, begin, end, [&](std::size_t i, const JacobianSummary& jacobian) {
                if (Elements<D, K>::bears(jacobian, least)) return;
                const double share = elements.share(looked_at[i].index(), least);
                if (share != 1) of_chunks[begin / grain].push_back({looked_at[i], share});
            });
        },
        grain);
    if (!looked) return fail(looked.error());
    std::vector<Share> shares;
    for (const auto& some : of_chunks) shares.insert(shares.end(), some.begin(), some.end());
    return shares;
}

template <int D, int K>
class PartLimit {
  public:
    PartLimit(const PartOffsets<D>& input, double least)
        : input_(input), elements_(input.mesh, input.base, input.offsets), least_(least) {
        for (std::size_t e = 0; e < elements_.simplices().size(); ++e)
            if (has_own_edge(e)) looked_at_.emplace_back(e);
    }

    Outcome<std::vector<EdgeId>> limit(const Execution& execution) {
        const auto shares = shares_of(elements_, looked_at_, least_, execution);
        if (!shares) return fail(shares.error());
        SparseMap<EdgeId, double> requested;
        for (const auto& [element, share] : *shares)
            for (const EdgeId edge : elements_.edges_of(element.index())) {
                if (!owns(edge)) continue;
                const double* before = requested.find(edge);
                requested.at(edge) = std::min(before ? *before : 1.0, share);
            }
        std::vector<EdgeId> limited;
        for (const EdgeId edge : requested.keys()) {
            Vec<D>& offset = input_.offsets[edge.index()];
            if (offset == Vec<D>{}) continue;
            offset *= *requested.find(edge);
            limited.push_back(edge);
        }
        limited_.insert(limited_.end(), limited.begin(), limited.end());
        return limited;
    }
    void look_around(std::span<const EdgeId> own, std::span<const EdgeId> of_others) {
        looked_at_.clear();
        for (const auto edges : {own, of_others})
            for (const EdgeId edge : edges)
                for (const ElementId e : input_.shells[edge])
                    if (has_own_edge(e.index())) looked_at_.push_back(e);
        std::ranges::sort(looked_at_);
        looked_at_.erase(std::ranges::unique(looked_at_).begin(), looked_at_.end());
    }
    [[nodiscard]] std::size_t limited() && {
        std::ranges::sort(limited_);
        return static_cast<std::size_t>(std::ranges::unique(limited_).begin() - limited_.begin());
    }

  private:
    [[nodiscard]] bool owns(EdgeId edge) const { return input_.owned.owns(input_.mesh.edges.vertices[edge]); }
    [[nodiscard]] bool has_own_edge(std::size_t e) const {
        return std::ranges::any_of(elements_.edges_of(e), [&](EdgeId edge) { return owns(edge); });
    }

    PartOffsets<D> input_;
    Elements<D, K> elements_;
    double least_;
    std::vector<ElementId> looked_at_;
    std::vector<EdgeId> limited_;
};

template <int D, int K>
Outcome<std::size_t> limit(std::span<const PartOffsets<D>> input, double least, PartCommunication<D>& between,
                           const Execution& execution) {
    std::vector<PartLimit<D, K>> parts;
    std::vector<std::span<Vec<D>>> offsets;
    for (const PartOffsets<D>& part : input) {
        parts.emplace_back(part, least);
        offsets.push_back(part.offsets);
    }
    for (int round = 0; round < max_rounds; ++round) {
        EdgesOfParts limited;
        // Later iterations check only few elements.
        const Execution of_round = round == 0 && input.size() == 1 ? execution : without_progress(execution);
        const auto limit_all = [&]() -> Outcome<std::vector<double>> {
            std::vector<double> counts;
            for (PartLimit<D, K>& part : parts) {
                auto edges = part.limit(of_round);
                if (!edges) return fail(edges.error());
                counts.push_back(static_cast<double>(edges->size()));
                limited.push_back(std::move(*edges));
            }
            return counts;
        };
        const auto counts = between.gather(limit_all());
        if (!counts) return fail(counts.error());
        if (std::ranges::all_of(*counts, [](double n) { return n == 0; })) break;
        EdgesOfParts shared;
        for (std::size_t p = 0; p < parts.size(); ++p) shared.push_back(between.shared(p, limited[p]));
        const auto exchanged = between.exchange_rows(offsets, shared);
        if (!exchanged) return fail(exchanged.error());
        for (std::size_t p = 0; p < parts.size(); ++p) parts[p].look_around(limited[p], (*exchanged)[p]);
    }
    std::size_t count = 0;
    for (PartLimit<D, K>& part : parts) count += std::move(part).limited();
    return count;
}

}  // namespace

template <int D>
Outcome<std::size_t> limit_by_jacobian(std::span<const PartOffsets<D>> parts, double least,
                                       PartCommunication<D>& between, const Execution& execution) {
    return guarded([&] { return limit<D, D>(parts, least, between, execution); });
}

template <int D>
Outcome<std::size_t> limit_by_jacobian(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> base,
                                       const Incidence<ElementId>& shells, double least, std::span<Vec<D>> offsets,
                                       const Execution& execution) {
    OnePart<D> alone;
    const PartOffsets<D> all{mesh, base, shells, whole(mesh.linear), offsets};
    if constexpr (D == 3)
        if (is_standalone_surface(mesh.linear))
            return guarded([&] { return limit<3, 2>(std::span(&all, 1), least, alone, execution); });
    return limit_by_jacobian<D>(std::span(&all, 1), least, alone, execution);
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template Outcome<std::size_t> limit_smooth_loss<D>(std::span<const PartLosses<D>>, double, PartCommunication<D>&,  \
                                                       const Execution&);                                              \
    template Outcome<std::size_t> limit_smooth_loss<D>(const QuadraticMesh<D>&, const Incidence<ElementId>&, double,   \
                                                       std::span<Vec<D>>, const Execution&);                           \
    template Outcome<std::size_t> limit_by_jacobian<D>(std::span<const PartOffsets<D>>, double, PartCommunication<D>&, \
                                                       const Execution&);                                              \
    template Outcome<std::size_t> limit_by_jacobian<D>(const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>,      \
                                                       const Incidence<ElementId>&, double, std::span<Vec<D>>,         \
                                                       const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
