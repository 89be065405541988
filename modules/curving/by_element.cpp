module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.validity;
import :by_element;
import :parts;

namespace camber {

namespace {

/// More than any stack has layers; what is left is for repair.
constexpr int max_rounds = 1000;

/// Elements, or the triangles of a surface alone (K = 2 in space).
template <int D, int K>
class Elements {
  public:
    using Form = std::conditional_t<D == K, NodalSimplex<D>, SurfaceTriangle>;

    Elements(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> base, std::span<const Vec<D>> offsets)
        : mesh_(mesh), base_(base), offsets_(offsets) {}

    /// The element with a share of the present offsets.
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

    /// True if all of the present offsets keep the element above `least`. \p jacobian: of the element with them.
    [[nodiscard]] static bool bears(const LowJacobian& jacobian, double least) {
        return jacobian.is_finite() && scaled(jacobian.lowest, jacobian.straight) >= least;
    }

    /// The largest share of the present offsets that keeps the element above `least`.
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
    /// The smallest coefficient of det J over |det| of the straight element, a lower bound of the scaled Jacobian. A
    /// thin element along a curve may be inverted when it is straight, and valid as it is bent.
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

/// visit(i, jacobian) of the elements looked at, with all of their offsets.
template <int D>
void each_looked_at(const Elements<D, D>& elements, std::span<const ElementId> looked_at, std::size_t begin,
                    std::size_t end, const auto& visit) {
    each_low_jacobian<D>(begin, end, [&](std::size_t i) { return elements.at(looked_at[i].index(), 1); }, visit);
}
void each_looked_at(const Elements<3, 2>& triangles, std::span<const ElementId> looked_at, std::size_t begin,
                    std::size_t end, const auto& visit) {
    for (std::size_t i = begin; i < end; ++i)
        visit(i, low_jacobian(bounded_jacobian(triangles.at(looked_at[i].index(), 1))));
}

/// An element that does not bear its offsets, and the share of them that it bears.
struct Share {
    ElementId element;
    double share = 1;
};
/// Of the elements looked at, in their order.
template <int D, int K>
Outcome<std::vector<Share>> shares_of(const Elements<D, K>& elements, std::span<const ElementId> looked_at,
                                      double least, const Execution& execution) {
    constexpr std::size_t grain = 4096;
    std::vector<std::vector<Share>> of_chunks((looked_at.size() + grain - 1) / grain);
    auto looked = each_chunk(
        execution, looked_at.size(),
        [&](std::size_t begin, std::size_t end) {
            each_looked_at(elements, looked_at, begin, end, [&](std::size_t i, const LowJacobian& jacobian) {
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

/// A part's offsets, and what is to be looked at of it.
template <int D, int K>
class PartLimit {
  public:
    PartLimit(const PartOffsets<D>& given, double least)
        : given_(given), elements_(given.mesh, given.base, given.offsets), least_(least) {
        for (std::size_t e = 0; e < elements_.simplices().size(); ++e)
            if (has_own_edge(e)) looked_at_.emplace_back(e);
    }

    /// A round: its own edges that were limited.
    Outcome<std::vector<EdgeId>> limit(const Execution& execution) {
        const auto shares = shares_of(elements_, looked_at_, least_, execution);
        if (!shares) return fail(shares.error());
        SparseMap<EdgeId, double> asked;
        for (const auto& [element, share] : *shares)
            for (const EdgeId edge : elements_.edges_of(element.index())) {
                if (!owns(edge)) continue;
                const double* before = asked.find(edge);
                asked.at(edge) = std::min(before ? *before : 1.0, share);
            }
        std::vector<EdgeId> limited;
        for (const EdgeId edge : asked.keys()) {
            Vec<D>& offset = given_.offsets[edge.index()];
            if (offset == Vec<D>{}) continue;
            offset *= *asked.find(edge);
            limited.push_back(edge);
        }
        limited_.insert(limited_.end(), limited.begin(), limited.end());
        return limited;
    }
    /// Elements around what was limited are looked at next.
    void look_around(std::span<const EdgeId> own, std::span<const EdgeId> of_others) {
        looked_at_.clear();
        for (const auto edges : {own, of_others})
            for (const EdgeId edge : edges)
                for (const ElementId e : given_.shells[edge])
                    if (has_own_edge(e.index())) looked_at_.push_back(e);
        std::ranges::sort(looked_at_);
        looked_at_.erase(std::ranges::unique(looked_at_).begin(), looked_at_.end());
    }
    [[nodiscard]] std::size_t limited() && {
        std::ranges::sort(limited_);
        return static_cast<std::size_t>(std::ranges::unique(limited_).begin() - limited_.begin());
    }

  private:
    [[nodiscard]] bool owns(EdgeId edge) const { return given_.owned.owns(given_.mesh.edges.vertices[edge]); }
    [[nodiscard]] bool has_own_edge(std::size_t e) const {
        return std::ranges::any_of(elements_.edges_of(e), [&](EdgeId edge) { return owns(edge); });
    }

    PartOffsets<D> given_;
    Elements<D, K> elements_;
    double least_;
    std::vector<ElementId> looked_at_;
    std::vector<EdgeId> limited_;
};

template <int D, int K>
Outcome<std::size_t> limit(std::span<const PartOffsets<D>> given, double least, BetweenParts<D>& between,
                           const Execution& execution) {
    std::vector<PartLimit<D, K>> parts;
    std::vector<std::span<Vec<D>>> offsets;
    for (const PartOffsets<D>& part : given) {
        parts.emplace_back(part, least);
        offsets.push_back(part.offsets);
    }
    for (int round = 0; round < max_rounds; ++round) {
        EdgesOfParts limited;
        // After the first round few are left.
        const Execution of_round = round == 0 && given.size() == 1 ? execution : without_progress(execution);
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
        const auto brought = between.bring(offsets, shared);
        if (!brought) return fail(brought.error());
        for (std::size_t p = 0; p < parts.size(); ++p) parts[p].look_around(limited[p], (*brought)[p]);
    }
    std::size_t count = 0;
    for (PartLimit<D, K>& part : parts) count += std::move(part).limited();
    return count;
}

}  // namespace

template <int D>
Outcome<std::size_t> limit_by_jacobian(std::span<const PartOffsets<D>> parts, double least, BetweenParts<D>& between,
                                       const Execution& execution) {
    return guarded([&] { return limit<D, D>(parts, least, between, execution); });
}

template <int D>
Outcome<std::size_t> limit_by_jacobian(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> base,
                                       const Incidence<ElementId>& shells, double least, std::span<Vec<D>> offsets,
                                       const Execution& execution) {
    OnePart<D> alone;
    const PartOffsets<D> all{mesh, base, shells, whole(mesh.linear), offsets};
    if constexpr (D == 3)
        if (is_surface_alone(mesh.linear))
            return guarded([&] { return limit<3, 2>(std::span(&all, 1), least, alone, execution); });
    return limit_by_jacobian<D>(std::span(&all, 1), least, alone, execution);
}

#define CAMBER_INSTANTIATE(D)                                                                                     \
    template Outcome<std::size_t> limit_by_jacobian<D>(std::span<const PartOffsets<D>>, double, BetweenParts<D>&, \
                                                       const Execution&);                                         \
    template Outcome<std::size_t> limit_by_jacobian<D>(const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>, \
                                                       const Incidence<ElementId>&, double, std::span<Vec<D>>,    \
                                                       const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
