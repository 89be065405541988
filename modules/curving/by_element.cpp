module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

/// More than any stack has layers; what is left is for repair.
constexpr int most_rounds = 1000;

template <int D>
class Elements {
  public:
    Elements(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> base, std::span<const Vec<D>> offsets)
        : mesh_(mesh), base_(base), offsets_(offsets) {}

    /// The element with a share of the present offsets.
    [[nodiscard]] NodalSimplex<D> at(std::size_t e, double share) const {
        const auto& vertices = mesh_.linear.elements.vertices[e];
        const auto& edges = mesh_.edges.of_elements[e];
        NodalSimplex<D> element;
        for (int i = 0; i <= D; ++i) element.nodes[i] = mesh_.linear.points[vertices[i]];
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            element.nodes[D + 1 + k] = base_[edges[k].index()].point + share * offsets_[edges[k].index()];
        return element;
    }

    /// Whether all of the present offsets keep the element above `least`, `jacobian` being of that.
    [[nodiscard]] static bool bears(const LowJacobian& jacobian, double least) {
        return jacobian.is_finite() && (!(jacobian.straight > 0) || jacobian.lowest / jacobian.straight >= least);
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
    [[nodiscard]] bool stays(std::size_t e) const {
        return std::ranges::all_of(mesh_.edges.of_elements[e],
                                   [&](EdgeId edge) { return offsets_[edge.index()] == Vec<D>{}; });
    }
    /// The smallest coefficient of det J over det of the straight element, a lower bound of the scaled Jacobian; as
    /// good as any where the straight element has none.
    [[nodiscard]] double scaled_jacobian(std::size_t e, double share) const {
        const auto jacobian = bounded_jacobian(at(e, share));
        if (!(jacobian.straight > 0)) return std::numeric_limits<double>::infinity();
        return *std::min_element(jacobian.coefficients.begin(), jacobian.coefficients.end()) / jacobian.straight;
    }

    const QuadraticMesh<D>& mesh_;
    std::span<const LagrangeNode<D>> base_;
    std::span<const Vec<D>> offsets_;
};

/// Of the elements looked at.
template <int D>
Outcome<Buffer<double>> shares_of(const Elements<D>& elements, std::span<const ElementId> looked_at, double least,
                                  const Execution& execution) {
    return guarded([&]() -> Outcome<Buffer<double>> {
        Buffer<double> shares(looked_at.size());
        return each_chunk(execution, looked_at.size(),
                          [&](std::size_t begin, std::size_t end) {
                              each_low_jacobian<D>(
                                  begin, end, [&](std::size_t i) { return elements.at(looked_at[i].index(), 1); },
                                  [&](std::size_t i, const LowJacobian& jacobian) {
                                      shares[i] = Elements<D>::bears(jacobian, least)
                                                      ? 1
                                                      : elements.share(looked_at[i].index(), least);
                                  });
                          })
            .map([&](Done) { return std::move(shares); });
    });
}

}  // namespace

template <int D>
Outcome<Done> lessen_by_element(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> base,
                                const Incidence<ElementId>& shells, double least, std::span<Vec<D>> offsets,
                                const Execution& execution) {
    const Elements<D> elements(mesh, base, offsets);
    std::vector<ElementId> looked_at(mesh.linear.elements.size());
    for (std::size_t e = 0; e < looked_at.size(); ++e) looked_at[e] = ElementId(e);
    for (int round = 0; round < most_rounds && !looked_at.empty(); ++round) {
        // After the first round few are left.
        const auto shares =
            shares_of<D>(elements, looked_at, least, round == 0 ? execution : without_progress(execution));
        if (!shares) return fail(shares.error());
        SparseMap<EdgeId, double> asked;
        for (std::size_t i = 0; i < looked_at.size(); ++i) {
            if ((*shares)[i] == 1) continue;
            for (const EdgeId edge : mesh.edges.of_elements[looked_at[i]]) {
                const double* before = asked.find(edge);
                asked.at(edge) = std::min(before ? *before : 1.0, (*shares)[i]);
            }
        }
        looked_at.clear();
        for (const EdgeId edge : asked.keys()) {
            Vec<D>& offset = offsets[edge.index()];
            if (offset == Vec<D>{}) continue;
            offset *= *asked.find(edge);
            looked_at.insert(looked_at.end(), shells[edge].begin(), shells[edge].end());
        }
        std::ranges::sort(looked_at);
        looked_at.erase(std::ranges::unique(looked_at).begin(), looked_at.end());
    }
    return Done{};
}

template Outcome<Done> lessen_by_element<2>(const QuadraticMesh<2>&, std::span<const LagrangeNode<2>>,
                                            const Incidence<ElementId>&, double, std::span<Vec<2>>, const Execution&);
template Outcome<Done> lessen_by_element<3>(const QuadraticMesh<3>&, std::span<const LagrangeNode<3>>,
                                            const Incidence<ElementId>&, double, std::span<Vec<3>>, const Execution&);

}  // namespace camber
