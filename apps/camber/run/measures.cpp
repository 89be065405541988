module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.cavity;
import camber.validity;
import camber.curving;
import camber.config;
import :histogram;
import :measures;
import :pipeline;
import :report;
import :state;

namespace camber::run {

namespace {

/// The values of the volume edges, and of those whose lengths are known.
std::vector<double> of_volume(std::span<const double> values, const Column<EdgeKind>& kinds) {
    std::vector<double> kept;
    kept.reserve(values.size());
    for (std::size_t e = 0; e < values.size(); ++e)
        if (kinds[e] == EdgeKind::volume) kept.push_back(values[e]);
    return kept;
}
std::vector<double> of_measured(std::span<const double> values, const Column<double>& lengths) {
    std::vector<double> kept;
    for (std::size_t e = 0; e < values.size(); ++e)
        if (lengths[e] > 0) kept.push_back(values[e]);
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

MeasuredEdges told_lengths(const config::Output& output) {
    return shows_fields(output) ? MeasuredEdges::all : MeasuredEdges::some;
}

template <int D>
EdgeReport edge_report(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const Column<double>& straight,
                       const Column<double>& lengths) {
    const auto gains = length_gains(straight, lengths);
    const auto curved = curvatures<D>(mesh, proposal.mid_nodes.view());
    EdgeReport r;
    std::size_t n = 0;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        if (proposal.kinds[e] != EdgeKind::volume) continue;
        r.mean_curvature += curved[e];
        r.largest_curvature = std::max(r.largest_curvature, curved[e]);
        ++n;
        if (!(straight[e] > 0)) continue;
        r.mean_gain += gains[e];
        r.largest_gain = std::max(r.largest_gain, gains[e]);
        r.longer += gains[e] < 0;
        ++r.measured;
    }
    if (r.measured > 0) r.mean_gain /= static_cast<double>(r.measured);
    if (n > 0) r.mean_curvature /= static_cast<double>(n);
    return r;
}

namespace {

template <int D>
void count_edges(Counter& counter, const QuadraticMesh<D>& mesh, const Curved<D>& curved, const Proposal<D>& in_the_end,
                 const EdgeLengths& lengths) {
    const auto& [proposal, straight, before, statistics] = curved;
    const auto& [chords, after] = lengths;
    const auto count_measured = [&](Quantity quantity, const char* name, std::span<const double> values) {
        counter.count(quantity, name, of_measured(values, straight));
    };
    const auto count_all = [&](Quantity quantity, const char* name, const Proposal<D>& seen) {
        const auto values = curvatures<D>(apply_proposal(mesh, seen), seen.mid_nodes.view());
        counter.count(quantity, name, of_volume(values, in_the_end.kinds));
    };
    count_measured(Quantity::length_gain, "before", length_gains(straight, before));
    count_measured(Quantity::length_gain, "after", length_gains(chords, after));
    count_measured(Quantity::length, "straight", straight.view());
    count_measured(Quantity::length, "before", before.view());
    count_measured(Quantity::length, "after", after.view());
    count_all(Quantity::curvature, "before", proposal);
    count_all(Quantity::curvature, "after", in_the_end);
}

/// The verdicts before any correction; null when nothing was judged.
template <int D>
const Validation<D>* first_of(const History<D>& history) {
    if (const auto* corrected = std::get_if<Corrected<D>>(&history)) return &corrected->before;
    const auto& last = std::get<Uncorrected<D>>(history).last;
    return last ? &*last : nullptr;
}

}  // namespace

template <int D>
std::vector<Histogram> run_histograms(const Quadratic<D>& end, const std::optional<EdgeLengths>& lengths,
                                      const History<D>& history) {
    Counter counter;
    const Plan<D>* const plan = end.planned();
    if (plan && plan->wanted() && lengths)
        count_edges(counter, end.mesh, plan->wanted()->curved, plan->proposal(), *lengths);
    if (const Validation<D>* validation = end.validation()) {
        const Validation<D>* const first = first_of(history);
        if (plan && first) counter.count(Quantity::scaled_jacobian, "before", jacobians(*first));
        counter.count(Quantity::scaled_jacobian, plan ? "after" : "count", jacobians(*validation));
    }
    return std::move(counter).take();
}

#define CAMBER_INSTANTIATE(D)                                                                                 \
    template std::vector<double> curvatures<D>(const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>);    \
    template EdgeReport edge_report<D>(const QuadraticMesh<D>&, const Proposal<D>&, const Column<double>&,    \
                                       const Column<double>&);                                                \
    template std::vector<Histogram> run_histograms<D>(const Quadratic<D>&, const std::optional<EdgeLengths>&, \
                                                      const History<D>&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
