module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
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

/// Series that are to be counted: each is a loop of its own, so that all of them go side by side.
class Counting {
  public:
    void add(Quantity quantity, std::string name, std::function<std::vector<double>()> values) {
        jobs_.push_back({quantity, std::move(name), std::move(values)});
    }
    [[nodiscard]] Outcome<std::vector<Histogram>> run(const Execution& execution) const {
        auto series = map_each(
            execution, jobs_.size(),
            [&](std::size_t i) {
                const auto& [quantity, name, values] = jobs_[i];
                return counted(name, limits_of(quantity), values());
            },
            1);
        if (!series) return fail(series.error());
        std::vector<Histogram> histograms;
        for (std::size_t i = 0; i < jobs_.size(); ++i) {
            if (histograms.empty() || histograms.back().quantity != jobs_[i].quantity)
                histograms.push_back({jobs_[i].quantity, limits_of(jobs_[i].quantity), {}});
            histograms.back().series.push_back(std::move((*series)[i]));
        }
        return histograms;
    }

  private:
    struct Job {
        Quantity quantity;
        std::string name;
        std::function<std::vector<double>()> values;
    };
    std::vector<Job> jobs_;
};

template <int D>
std::vector<double> jacobians(const Validation<D>& v) {
    return {v.min_scaled_jacobian.begin(), v.min_scaled_jacobian.end()};
}

}  // namespace

std::vector<double> length_reductions(const Column<double>& straight, const Column<double>& lengths) {
    std::vector<double> reductions(lengths.size());
    for (std::size_t e = 0; e < reductions.size(); ++e)
        reductions[e] = lengths[e] > 0 ? straight[e] / lengths[e] - 1 : 0;
    return reductions;
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

MeasuredEdges reported_lengths(const config::Output& output) {
    return shows_fields(output) ? MeasuredEdges::all : MeasuredEdges::some;
}

template <int D>
std::size_t bent_edges(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal) {
    std::size_t n = 0;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        const auto& [a, b] = mesh.edges.vertices[e];
        n += proposal.mid_nodes[e].point != midpoint(proposal.points[a], proposal.points[b]);
    }
    return n;
}

template <int D>
EdgeReport edge_report(const QuadraticMesh<D>& mesh, const Proposal<D>& proposal, const Column<double>& straight,
                       const Column<double>& lengths) {
    const auto reductions = length_reductions(straight, lengths);
    const auto curved = curvatures<D>(mesh, proposal.mid_nodes.view());
    const bool is_alone = is_surface_alone(mesh.linear);
    EdgeReport r;
    std::size_t n = 0;
    for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
        if (proposal.kinds[e] != EdgeKind::volume && !is_alone) continue;
        r.mean_curvature += curved[e];
        r.largest_curvature = std::max(r.largest_curvature, curved[e]);
        ++n;
        if (!(straight[e] > 0)) continue;
        r.mean_length_reduction += reductions[e];
        r.largest_length_reduction = std::max(r.largest_length_reduction, reductions[e]);
        r.longer += reductions[e] < 0;
        ++r.measured;
    }
    if (r.measured > 0) r.mean_length_reduction /= static_cast<double>(r.measured);
    if (n > 0) r.mean_curvature /= static_cast<double>(n);
    return r;
}

namespace {

/// Of a surface alone: all edges, which become no shorter, since they follow the surface.
template <int D>
void count_surface_edges(Counting& counting, const QuadraticMesh<D>& mesh, const Curved<D>& curved,
                         const Proposal<D>& in_the_end, const EdgeLengths& lengths) {
    const auto known = [&counting, &lengths](const char* name, const Column<double>& values) {
        counting.add(Quantity::length, name, [&] { return of_measured(values.view(), lengths.straight); });
    };
    const auto bent = [&counting, &mesh](const char* name, const Proposal<D>& seen) {
        counting.add(Quantity::curvature, name,
                     [&] { return curvatures<D>(apply_proposal(mesh, seen), seen.mid_nodes.view()); });
    };
    known("straight", lengths.straight);
    known("after", lengths.curved);
    bent("before", curved.proposal);
    bent("after", in_the_end);
}

/// What is counted is referred to until it is.
template <int D>
void count_edges(Counting& counting, const QuadraticMesh<D>& mesh, const Curved<D>& curved,
                 const Proposal<D>& in_the_end, const EdgeLengths& lengths) {
    const auto reductions = [&counting, &curved](const char* name, const Column<double>& chords,
                                                 const Column<double>& now) {
        counting.add(Quantity::length_reduction, name,
                     [&] { return of_measured(length_reductions(chords, now), curved.straight_lengths); });
    };
    const auto known = [&counting, &curved](const char* name, const Column<double>& values) {
        counting.add(Quantity::length, name, [&] { return of_measured(values.view(), curved.straight_lengths); });
    };
    const auto bent = [&counting, &mesh, &in_the_end](const char* name, const Proposal<D>& seen) {
        counting.add(Quantity::curvature, name, [&] {
            return of_volume(curvatures<D>(apply_proposal(mesh, seen), seen.mid_nodes.view()), in_the_end.kinds);
        });
    };
    reductions("before", curved.straight_lengths, curved.lengths);
    reductions("after", lengths.straight, lengths.curved);
    known("straight", curved.straight_lengths);
    known("before", curved.lengths);
    known("after", lengths.curved);
    bent("before", curved.proposal);
    bent("after", in_the_end);
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
Outcome<std::vector<Histogram>> run_histograms(const Quadratic<D>& end, const std::optional<EdgeLengths>& lengths,
                                               const History<D>& history, const Execution& execution) {
    Counting counting;
    const Plan<D>* const plan = end.planned();
    if (plan && plan->wanted() && lengths && is_surface_alone(end.mesh.linear))
        count_surface_edges(counting, end.mesh, plan->wanted()->curved, plan->proposal(), *lengths);
    else if (plan && plan->wanted() && lengths)
        count_edges(counting, end.mesh, plan->wanted()->curved, plan->proposal(), *lengths);
    if (const Validation<D>* validation = end.validation()) {
        const Validation<D>* const first = first_of(history);
        if (plan && first) counting.add(Quantity::scaled_jacobian, "before", [first] { return jacobians(*first); });
        counting.add(Quantity::scaled_jacobian, plan ? "after" : "count",
                     [validation] { return jacobians(*validation); });
    }
    return counting.run(execution);
}

#define CAMBER_INSTANTIATE(D)                                                                                          \
    template std::vector<double> curvatures<D>(const QuadraticMesh<D>&, std::span<const LagrangeNode<D>>);             \
    template std::size_t bent_edges<D>(const QuadraticMesh<D>&, const Proposal<D>&);                                   \
    template EdgeReport edge_report<D>(const QuadraticMesh<D>&, const Proposal<D>&, const Column<double>&,             \
                                       const Column<double>&);                                                         \
    template Outcome<std::vector<Histogram>> run_histograms<D>(const Quadratic<D>&, const std::optional<EdgeLengths>&, \
                                                               const History<D>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
