module;
#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.validity;
import :histogram;
import :measures;
import :state;

namespace camber::run {

namespace {

/// The values of the volume edges.
std::vector<double> of_volume(std::span<const double> values, const Column<EdgeKind>& kinds) {
    std::vector<double> kept;
    kept.reserve(values.size());
    for (std::size_t e = 0; e < values.size(); ++e)
        if (kinds[e] == EdgeKind::volume) kept.push_back(values[e]);
    return kept;
}

class Counter {
  public:
    void count(Quantity quantity, std::string name, std::span<const double> values) {
        if (histograms_.empty() || histograms_.back().quantity != quantity)
            histograms_.push_back({quantity, limits_of(quantity), {}});
        Histogram& h = histograms_.back();
        h.series.push_back(counted(std::move(name), h.limits, values));
    }
    [[nodiscard]] std::vector<Histogram> take() && { return std::move(histograms_); }

  private:
    std::vector<Histogram> histograms_;
};

template <int D>
std::vector<double> jacobians(const Validation<D>& v) {
    return {v.min_scaled_jacobian.begin(), v.min_scaled_jacobian.end()};
}

}  // namespace

std::vector<double> length_gains(const Column<double>& straight, const Column<double>& lengths) {
    std::vector<double> gains(lengths.size());
    for (std::size_t e = 0; e < gains.size(); ++e) gains[e] = lengths[e] > 0 ? straight[e] / lengths[e] - 1 : 0;
    return gains;
}

template <int D>
std::vector<double> curvatures(const QuadraticMesh<D>& mesh, std::span<const LagrangeNode<D>> mid_nodes) {
    std::vector<double> values(mid_nodes.size());
    for (std::size_t e = 0; e < values.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        const QuadraticEdge<D> edge{mesh.linear.points[a], mid_nodes[e], mesh.linear.points[b]};
        values[e] = norm_squared(edge.chord()) > 0 ? curvature(edge) : 0;
    }
    return values;
}

template <int D>
std::vector<Histogram> run_histograms(const State<D>& state) {
    Counter counter;
    // A stage that changed the edges themselves leaves nothing to compare with.
    const bool curved = state.curved && state.proposal && state.lengths &&
                        state.curved->lengths.size() == state.lengths->curved.size() &&
                        state.proposal->mid_nodes.size() == state.lengths->curved.size();
    if (curved) {
        const Column<EdgeKind>& kinds = state.proposal->kinds;
        const auto count = [&](Quantity quantity, const char* name, std::span<const double> values) {
            counter.count(quantity, name, of_volume(values, kinds));
        };
        const auto& [proposal, straight, before, statistics] = *state.curved;
        const auto& [chords, after] = *state.lengths;
        count(Quantity::length_gain, "before", length_gains(straight, before));
        count(Quantity::length_gain, "after", length_gains(chords, after));
        count(Quantity::length, "straight", straight.view());
        count(Quantity::length, "before", before.view());
        count(Quantity::length, "after", after.view());
        count(Quantity::curvature, "before",
              curvatures<D>(proposed(*state.quadratic(), proposal), proposal.mid_nodes.view()));
        count(Quantity::curvature, "after",
              curvatures<D>(proposed(*state.quadratic(), *state.proposal), state.proposal->mid_nodes.view()));
    }
    if (state.validation) {
        if (state.proposal && state.first_validation)
            counter.count(Quantity::normalised_jacobian, "before", jacobians(*state.first_validation));
        counter.count(Quantity::normalised_jacobian, state.proposal ? "after" : "count", jacobians(*state.validation));
    }
    return std::move(counter).take();
}

#define CAMBER_INSTANTIATE(D)                                                                              \
    template std::vector<double> curvatures<D>(const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>); \
    template std::vector<Histogram> run_histograms<D>(const State<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
