module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.solution_metric;
import camber.core;
import camber.metric;

namespace camber {

namespace {

/// All but the fields' scale.
template <int D>
class Composition {
  public:
    Composition(const LinearMesh<D>& mesh, const EdgeSet<D>& edges, std::span<const SolutionField<D>> fields,
                const SolutionMetricOptions& options, const Execution& execution)
        : mesh_(mesh),
          edges_(edges),
          fields_(fields),
          options_(options),
          execution_(without_progress(execution)),
          telling_(execution) {
        if (options.max_size == 0) options_.max_size = diameter(mesh);
        bounds_.min_size = options.min_size;
        bounds_.max_size = options_.max_size;
        if (options.max_anisotropy > 0) bounds_.max_anisotropy = options.max_anisotropy;
    }

    [[nodiscard]] Outcome<SolutionMetric<D>> made(const Column<LogMetric<D>>& fixed) {
        out_.asked = complexity_of<D>(options_.amount, options_.of);
        if (auto done = set_fixed(fixed); !done) return fail(done.error());
        if (out_.of_fixed >= out_.asked) return fixed_alone();
        if (auto done = set_scales(); !done) return fail(done.error());
        auto found = searched(0, options_.gradation ? 1e-2 : options_.tolerance, Graded::no);
        if (found && options_.gradation) found = searched(found->at, options_.tolerance, Graded::yes);
        if (!found) return fail(found.error());
        // The last that was tried is not always the best.
        if (last_ != found->at) {
            const auto again = evaluated(found->at, options_.gradation ? Graded::yes : Graded::no);
            if (!again) return fail(again.error());
        }
        out_.is_reached = found->reached;
        return finished();
    }

  private:
    enum class Graded : std::uint8_t { no, yes };

    [[nodiscard]] Outcome<Column<LogMetric<D>>> graded(const Column<LogMetric<D>>& field) {
        auto result = apply_gradation(mesh_, edges_, field, *options_.gradation, execution_);
        if (!result) return fail(result.error());
        ++out_.gradations;
        out_.is_graded = result->converged;
        return std::move(result->log_metrics);
    }
    /// The complexity of what is put out.
    [[nodiscard]] Outcome<double> put(Outcome<Column<LogMetric<D>>> field) {
        if (!field) return fail(field.error());
        out_.log_metrics = std::move(*field);
        const auto now = complexity(mesh_, out_.log_metrics, execution_);
        if (now) out_.reached = *now;
        ++out_.evaluations;
        ++told_;
        report_progress(telling_, told_, told_ + 1);  // nobody knows how many there will be
        return now;
    }

    [[nodiscard]] Outcome<Done> set_fixed(const Column<LogMetric<D>>& fixed) {
        const LogMetric<D> largest{-2 * log(bounds_.max_size) * Sym<D>::identity()};
        Outcome<Column<LogMetric<D>>> whole = Column<LogMetric<D>>(Buffer<LogMetric<D>>(mesh_.points.size(), largest));
        if (!fixed.empty()) {
            whole = intersection(*whole, fixed, execution_);
            if (whole) whole = apply_bounds(*whole, bounds_, execution_);
            if (!whole) return fail(whole.error());
            auto systems = map_each(execution_, fixed.size(), [&](std::size_t v) { return eigen_system(fixed[v].l); });
            if (!systems) return fail(systems.error());
            fixed_ = std::move(*systems);
            if (options_.gradation) whole = graded(*whole);
        }
        const auto alone = put(std::move(whole));
        if (!alone) return fail(alone.error());
        out_.of_fixed = *alone;
        return Done{};
    }

    /// Each field's scale with its share of the complexity.
    [[nodiscard]] Outcome<Done> set_scales() {
        for (const SolutionField<D>& field : fields_) {
            auto metric =
                optimal_metric(mesh_, field.models, field.norm, field.share * out_.asked, bounds_.max_size, execution_);
            if (!metric) {
                Error error = metric.error();
                if (fields_.size() > 1) error.entity = Entity{"field", scales_.size() + 1};
                return fail(std::move(error));
            }
            out_.evaluations += metric->evaluations;
            scales_.push_back(metric->scale);
        }
        return Done{};
    }

    [[nodiscard]] LogMetric<D> metric_at(std::size_t v, double t) const {
        EigenSystem<D> whole;
        for (std::size_t f = 0; f < fields_.size(); ++f) {
            const LocalModel<D>& model = fields_[f].models[v];
            const auto sizes =
                optimal_sizes<D>(model.logs.values, scales_[f] - t, power_of(fields_[f].norm), bounds_.max_size);
            const EigenSystem<D> own{sizes.metric_logs, model.logs.vectors};
            whole = f == 0 ? own : intersection(whole, own);
        }
        if (!fixed_.empty()) whole = intersection(whole, fixed_[v]);
        return apply_bounds(LogMetric<D>{composed(whole)}, bounds_);
    }

    /// log C with the fields scaled by t.
    [[nodiscard]] Outcome<double> evaluated(double t, Graded grade) {
        last_ = t;
        auto field = map_each(execution_, mesh_.points.size(), [&](std::size_t v) { return metric_at(v, t); });
        if (!field) return fail(field.error());
        Column<LogMetric<D>> column(std::move(*field));
        const auto now = put(grade == Graded::yes ? graded(column) : Outcome<Column<LogMetric<D>>>(std::move(column)));
        if (!now) return fail(now.error());
        return log(*now);
    }
    [[nodiscard]] Outcome<ScaleFound> searched(double from, double tolerance, Graded grade) {
        return search_scale(from, log(out_.asked), 0.5 * D, tolerance, options_.max_evaluations,
                            [&](double t) { return evaluated(t, grade); });
    }

    [[nodiscard]] Outcome<SolutionMetric<D>> fixed_alone() {
        out_.is_fixed_alone = true;
        out_.is_reached = std::abs(out_.reached / out_.asked - 1) <= options_.tolerance;
        return finished();
    }
    [[nodiscard]] Outcome<SolutionMetric<D>> finished() {
        constexpr double near = 1e-6;
        const double least = -2 * log(bounds_.max_size) + near, most = -2 * log(bounds_.min_size) - near;
        const auto counts = reduce_each(
            execution_, out_.log_metrics.size(), std::array<std::size_t, 2>{},
            [&](auto& count, std::size_t v) {
                const auto values = eigen_system(out_.log_metrics[v].l).values.c;
                const auto [low, high] = std::minmax_element(values.begin(), values.end());
                count[0] += *high >= most ? 1 : 0;
                count[1] += *low <= least ? 1 : 0;
            },
            [](auto a, const auto& b) { return std::array{a[0] + b[0], a[1] + b[1]}; });
        if (!counts) return fail(counts.error());
        const double all = static_cast<double>(std::max<std::size_t>(out_.log_metrics.size(), 1));
        out_.at_min = static_cast<double>((*counts)[0]) / all;
        out_.at_max = static_cast<double>((*counts)[1]) / all;
        return std::move(out_);
    }

    const LinearMesh<D>& mesh_;
    const EdgeSet<D>& edges_;
    std::span<const SolutionField<D>> fields_;
    SolutionMetricOptions options_;
    Execution execution_, telling_;
    std::size_t told_ = 0;
    MetricBounds bounds_;
    Buffer<EigenSystem<D>> fixed_;
    std::vector<double> scales_;
    double last_ = 0;
    SolutionMetric<D> out_;
};

template <int D>
Outcome<Done> check_composition(const LinearMesh<D>& mesh, std::span<const SolutionField<D>> fields,
                                const Column<LogMetric<D>>& fixed, const SolutionMetricOptions& options,
                                const Execution& execution) {
    if (auto sound = check_limits(options); !sound) return sound;
    if (mesh.elements.vertices.empty())
        return fail(ErrorKind::usage, "the mesh has no elements: there is nothing that a solution is resolved by");
    if (fields.empty()) return fail(ErrorKind::usage, "there is no field to make a metric of");
    if (options.max_size != 0 && options.max_size < options.min_size)
        return fail(ErrorKind::usage, "max_size must be at least min_size");
    if (options.max_anisotropy != 0 && options.max_anisotropy < 1)
        return fail(ErrorKind::usage, "max_anisotropy must be at least 1, or 0 for none");
    for (const SolutionField<D>& field : fields) {
        if (field.models.size() != mesh.points.size())
            return fail(ErrorKind::usage, "a field's models are of another mesh: there must be one a vertex");
        if (!(field.share > 0) || field.share > 1)
            return fail(ErrorKind::usage, "a field's share of the complexity must be above 0 and at most 1");
    }
    if (!fixed.empty() && fixed.size() != mesh.points.size())
        return fail(ErrorKind::usage, "the fixed metric is of another mesh");
    return check_sizes(fixed, execution);
}

}  // namespace

template <int D>
Outcome<SolutionMetric<D>> make_solution_metric(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                std::span<const SolutionField<D>> fields,
                                                const Column<LogMetric<D>>& fixed, const SolutionMetricOptions& options,
                                                const Execution& execution) {
    const Execution quiet = without_progress(execution);
    if (auto sound = check_composition(mesh, fields, fixed, options, quiet); !sound) return fail(sound.error());
    return guarded([&] { return Composition<D>(mesh, edges, fields, options, execution).made(fixed); });
}

#define CAMBER_INSTANTIATE(D)                                                                                    \
    template Outcome<SolutionMetric<D>> make_solution_metric<D>(                                                 \
        const LinearMesh<D>&, const EdgeSet<D>&, std::span<const SolutionField<D>>, const Column<LogMetric<D>>&, \
        const SolutionMetricOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
