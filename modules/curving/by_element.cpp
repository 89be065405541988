module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>
module camber.curving;
import camber.core;
import camber.bezier;
import camber.validity;

namespace camber {

namespace {

/// Neighbours of what was lessened are looked at again so often; what is left is for repair.
constexpr int most_rounds = 16;

template <int D>
class Elements {
  public:
    Elements(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> base, std::span<const Vec<D>> offsets)
        : mesh_(mesh), base_(base), offsets_(offsets) {}

    /// The largest share of the present offsets that keeps the element above `least`.
    [[nodiscard]] double share(std::size_t e, double least) const {
        double best = 1;
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
    /// The smallest coefficient of det J over det of the straight element, a lower bound of the scaled Jacobian; as
    /// good as any where the straight element has none.
    [[nodiscard]] double scaled_jacobian(std::size_t e, double share) const {
        const auto& vertices = mesh_.linear.elements.vertices[e];
        const auto& edges = mesh_.edges.of_elements[e];
        NodalSimplex<D> element;
        for (int i = 0; i <= D; ++i) element.nodes[i] = mesh_.linear.points[vertices[i]];
        for (int k = 0; k < edges_per_simplex<D>; ++k)
            element.nodes[D + 1 + k] = base_[edges[k].index()].point + share * offsets_[edges[k].index()];
        const auto jacobian = bounded_jacobian(element);
        if (!(jacobian.straight > 0)) return std::numeric_limits<double>::infinity();
        return *std::min_element(jacobian.coefficients.begin(), jacobian.coefficients.end()) / jacobian.straight;
    }

    const QuadraticMesh<D>& mesh_;
    std::span<const LagrangeNode<D>> base_;
    std::span<const Vec<D>> offsets_;
};

}  // namespace

template <int D>
Outcome<Done> lessen_by_element(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> base,
                                const Incidence<ElementId>& shells, double least, std::span<Vec<D>> offsets,
                                const Execution& execution) {
    for (int round = 0; round < most_rounds; ++round) {
        const Elements<D> elements(mesh, base, offsets);
        const auto shares =
            map_each(execution, mesh.linear.elements.size(), [&](std::size_t e) { return elements.share(e, least); });
        if (!shares) return fail(shares.error());
        if (std::all_of(shares->begin(), shares->end(), [](double s) { return s == 1; })) break;
        auto lessened = each(execution, mesh.edges.size(), [&](std::size_t e) {
            double share = 1;
            for (const ElementId element : shells[e]) share = std::min(share, (*shares)[element.index()]);
            if (share < 1) offsets[e] *= share;
        });
        if (!lessened) return lessened;
    }
    return Done{};
}

template Outcome<Done> lessen_by_element<2>(const QuadraticMesh<2>&, std::span<const LagrangeNode<2>>,
                                            const Incidence<ElementId>&, double, std::span<Vec<2>>, const Execution&);
template Outcome<Done> lessen_by_element<3>(const QuadraticMesh<3>&, std::span<const LagrangeNode<3>>,
                                            const Incidence<ElementId>&, double, std::span<Vec<3>>, const Execution&);

}  // namespace camber
