module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>
module camber.solution_metric;
import camber.core;
import camber.metric;

namespace camber {

namespace {

struct LogSum {
    double top = -std::numeric_limits<double>::infinity(), sum = 0;

    void add(double x, double weight = 1) {
        if (!(x > -std::numeric_limits<double>::infinity()) || !(weight > 0)) return;
        if (x > top) {
            sum = sum * exp(top - x) + weight;
            top = x;
        } else {
            sum += weight * exp(x - top);
        }
    }
    [[nodiscard]] double value() const { return top + log(sum); }
};
LogSum joined(LogSum a, const LogSum& b) {
    a.add(b.top, b.sum);
    return a;
}

template <int D>
double volume_of(const LinearMesh<D>& mesh, std::size_t e) {
    Mat<D> sides;
    const auto& v = mesh.elements.vertices[e];
    for (int i = 0; i < D; ++i) sides.column[i] = mesh.points[v[i + 1]] - mesh.points[v[0]];
    return std::abs(det(sides)) / (D == 2 ? 2 : 6);
}

template <int D>
Outcome<double> volume_of(const LinearMesh<D>& mesh, const Execution& execution) {
    return reduce_each(
        without_progress(execution), mesh.elements.size(), 0.0,
        [&](double& sum, std::size_t e) { sum += volume_of(mesh, e); }, [](double a, double b) { return a + b; });
}

template <int D>
Outcome<Done> check_request(const LinearMesh<D>& mesh, const Column<LocalModel<D>>& models, std::size_t rows,
                            const MetricTarget& target, const Execution& execution) {
    const auto& [norm, complexity, largest] = target;
    if (auto sound = check_limits(norm); !sound) return sound;
    if (norm.p != 0 && norm.p < 1) return fail(ErrorKind::usage, "p must be at least 1, or 0 for the largest error");
    if (models.size() != rows) return fail(ErrorKind::usage, "the models belong to another mesh");
    if (!(complexity > 0) || !std::isfinite(complexity))
        return fail(ErrorKind::usage, "the target complexity must be positive and finite");
    if (!(largest > 0) || !std::isfinite(largest))
        return fail(ErrorKind::usage, "the largest size must be positive and finite");
    if (std::all_of(models.begin(), models.end(), [](const auto& m) { return m.kind == ModelKind::zero; }))
        return fail(ErrorKind::usage,
                    "the field is constant, or the elements interpolate it exactly, so it determines no size", {}, {},
                    "use another field, or a metric of given sizes");
    const auto volume = volume_of(mesh, execution);
    if (!volume) return fail(volume.error());
    const double least = *volume / pow(largest, D);
    if (complexity <= least)
        return fail(ErrorKind::usage,
                    "a complexity of " + std::to_string(complexity) +
                        " is requested, but the largest size alone gives " + std::to_string(least),
                    {}, {}, "request a larger complexity, or allow larger sizes");
    return Done{};
}

template <int D>
Outcome<double> log_of_sum(std::size_t n, const Execution& execution, const auto& term) {
    const auto sum = reduce_each(without_progress(execution), n, LogSum{}, term, joined);
    if (!sum) return fail(sum.error());
    return sum->value();
}

/// First guess of −s for the scale s of `optimal_sizes`, if no size reaches the bound `largest`.
template <int D>
Outcome<double> first_guess(const Column<LocalModel<D>>& models, double power, double log_target,
                            const Execution& execution, const auto& weight) {
    const double share = std::isinf(power) ? 0.5 : 0.5 * power / (power + D);
    const auto sum = log_of_sum<D>(models.size(), execution, [&](LogSum& s, std::size_t i) {
        // Eigenvalues are raised to e^−28 times the largest, so that the log is finite if derivatives vanish along an
        // axis. Along this axis the largest size applies.
        constexpr double deepest = 28;
        const auto& values = models[i].logs.values.c;
        const double top = *std::max_element(values.begin(), values.end());
        double logs = 0;
        for (const double x : values) logs += std::max(x, top - deepest);
        s.add(share * logs, weight(i));
    });
    if (!sum) return fail(sum.error());
    return 2.0 / D * (log_target - *sum);
}

template <int D>
Outcome<double> scale_of_elements(const LinearMesh<D>& mesh, const Column<LocalModel<D>>& models, double power,
                                  double log_target, double largest, const Execution& execution) {
    const auto guess =
        first_guess(models, power, log_target, execution, [&](std::size_t e) { return volume_of(mesh, e); });
    if (!guess) return fail(guess.error());
    const auto found = search_scale(*guess, log_target, 0.5 * D, 1e-3, 60, [&](double t) {
        return log_of_sum<D>(models.size(), execution, [&](LogSum& sum, std::size_t e) {
            const auto sizes = optimal_sizes<D>(models[e].logs.values, -t, power, largest);
            double logs = 0;
            for (const double x : sizes.metric_logs.c) logs += x;
            sum.add(logs / 2, volume_of(mesh, e));
        });
    });
    if (!found) return fail(found.error());
    return -found->at;
}

template <int D>
double anisotropy_spread(const Vec<D>& logs) {
    double mean = 0, sum = 0;
    for (const double x : logs.c) mean += x / D;
    for (const double x : logs.c) sum += (x - mean) * (x - mean);
    return std::sqrt(sum);
}

template <int D>
class BallMean {
  public:
    BallMean(const Column<LocalModel<D>>& raised, const auto& weight, auto ball) {
        double all = 0, unlike = 0;
        for (const ElementId e : ball) {
            const double w = weight(e);
            plain_ += w * composed(raised[e].logs);
            unlike += w * anisotropy_spread<D>(raised[e].logs.values);
            all += w;
        }
        plain_ *= 1 / all;
        // A mean of logs with different axes loses anisotropy. If the loss is small, the axes are not rotated.
        constexpr double lost = 0.01;
        if (anisotropy_spread<D>(eigen_system(plain_).values) >= (1 - lost) * unlike / all) return;
        Sym<D> carried;
        for (const ElementId e : ball) {
            const auto turn = turn_between<D>(composed(raised[e].logs), plain_);
            carried += weight(e) / all * composed(turned(raised[e].logs, turn));
        }
        plain_ = carried;
    }
    [[nodiscard]] LocalModel<D> model() const { return {eigen_system(plain_)}; }

  private:
    Sym<D> plain_;
};

/// Returns the intersection of the mean models of each material around a vertex, so that at interfaces the finer one
/// applies.
template <int D>
LocalModel<D> model_at_vertex(const LinearMesh<D>& mesh, std::span<const ElementId> ball,
                              const Column<LocalModel<D>>& raised) {
    std::vector<ElementId> elements(ball.begin(), ball.end());
    std::erase_if(elements, [&](ElementId e) { return !(volume_of(mesh, e.index()) > 0); });
    const auto material = [&](ElementId e) { return mesh.elements.references[e]; };
    std::ranges::stable_sort(elements, {}, material);
    std::optional<EigenSystem<D>> all;
    for (auto first = elements.begin(); first != elements.end();) {
        const auto last =
            std::find_if(first, elements.end(), [&](ElementId e) { return material(e) != material(*first); });
        const auto mean = BallMean<D>(
                              raised, [&](ElementId e) { return volume_of(mesh, e.index()); }, std::span(first, last))
                              .model();
        all = all ? intersection(*all, mean.logs) : mean.logs;
        first = last;
    }
    return all ? LocalModel<D>{*all} : zero_model<D>();
}

}  // namespace

template <int D>
Outcome<OptimalMetric<D>> optimal_metric(const LinearMesh<D>& mesh, const Column<LocalModel<D>>& models,
                                         const MetricTarget& target, const Execution& execution) {
    if (auto sound = check_request(mesh, models, mesh.points.size(), target, execution); !sound)
        return fail(sound.error());
    const double power = power_of(target.norm), log_target = log(target.complexity);
    const auto volume = volume_of(mesh, execution);
    if (!volume) return fail(volume.error());
    const double share = *volume / static_cast<double>(models.size());
    const auto guess = first_guess(models, power, log_target, execution, [&](std::size_t) { return share; });
    if (!guess) return fail(guess.error());
    OptimalMetric<D> out;
    const Execution quiet = without_progress(execution);
    const auto found = search_scale(*guess, log_target, 0.5 * D, 1e-6, 60, [&](double t) -> Outcome<double> {
        auto logs = map_each(quiet, models.size(), [&](std::size_t v) {
            const auto sizes = optimal_sizes<D>(models[v].logs.values, -t, power, target.largest);
            return LogMetric<D>{composed(EigenSystem<D>{sizes.metric_logs, models[v].logs.vectors})};
        });
        if (!logs) return fail(logs.error());
        out.log_metrics = std::move(*logs);
        out.scale = -t;
        const auto now = camber::complexity(mesh, out.log_metrics, quiet);
        if (!now) return fail(now.error());
        out.complexity = *now;
        return log(*now);
    });
    if (!found) return fail(found.error());
    out.evaluations = found->evaluations;
    return out;
}

template <int D>
Outcome<Column<LocalModel<D>>> models_at_vertices(const LinearMesh<D>& mesh, const Incidence<ElementId>& balls,
                                                  const Column<LocalModel<D>>& of_elements, const MetricTarget& target,
                                                  const Execution& execution) {
    if (auto sound = check_request(mesh, of_elements, mesh.elements.size(), target, execution); !sound)
        return fail(sound.error());
    const double power = power_of(target.norm);
    const auto scale = scale_of_elements(mesh, of_elements, power, log(target.complexity), target.largest, execution);
    if (!scale) return fail(scale.error());
    auto raised = map_each(without_progress(execution), of_elements.size(), [&](std::size_t e) {
        LocalModel<D> model{of_elements[e].logs};
        const auto sizes = optimal_sizes<D>(model.logs.values, *scale, power, target.largest);
        for (int i = 0; i < D; ++i) model.logs.values[i] = sizes.metric_logs[i] + sizes.log_epsilon;
        return model;
    });
    if (!raised) return fail(raised.error());
    const Column<LocalModel<D>> column(std::move(*raised));
    auto models = map_each(execution, mesh.points.size(),
                           [&](std::size_t v) { return model_at_vertex<D>(mesh, balls[v], column); });
    if (!models) return fail(models.error());
    return Column<LocalModel<D>>(std::move(*models));
}

namespace {

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
          progress_execution_(execution) {
        if (options.max_size == 0) options_.max_size = diameter(mesh);
        bounds_.min_size = options.min_size;
        bounds_.max_size = options_.max_size;
        if (options.max_anisotropy > 0) bounds_.max_anisotropy = options.max_anisotropy;
    }

    [[nodiscard]] Outcome<SolutionMetric<D>> compute_metric(const Column<LogMetric<D>>& fixed) {
        out_.requested = complexity_of<D>(options_.amount, options_.of);
        if (auto done = set_fixed(fixed); !done) return fail(done.error());
        if (out_.fixed_complexity >= out_.requested) return fixed_part_only();
        if (auto done = set_scales(); !done) return fail(done.error());
        auto found = searched(0, options_.gradation ? 1e-2 : options_.tolerance, Graded::no);
        if (found && options_.gradation) found = searched(found->at, options_.tolerance, Graded::yes);
        if (!found) return fail(found.error());
        // If the best evaluation is not the last one, it is repeated.
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
    [[nodiscard]] Outcome<double> put(Outcome<Column<LogMetric<D>>> field) {
        if (!field) return fail(field.error());
        out_.log_metrics = std::move(*field);
        const auto now = complexity(mesh_, out_.log_metrics, execution_);
        if (now) out_.reached = *now;
        ++out_.evaluations;
        ++reported_evaluations_;
        report_progress(progress_execution_, reported_evaluations_, reported_evaluations_ + 1);  // the total is unknown
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
        out_.fixed_complexity = *alone;
        return Done{};
    }

    [[nodiscard]] Outcome<Done> set_scales() {
        for (const SolutionField<D>& field : fields_) {
            auto metric = optimal_metric(mesh_, field.models,
                                         {field.norm, field.share * out_.requested, bounds_.max_size}, execution_);
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
        return search_scale(from, log(out_.requested), 0.5 * D, tolerance, options_.max_evaluations,
                            [&](double t) { return evaluated(t, grade); });
    }

    [[nodiscard]] Outcome<SolutionMetric<D>> fixed_part_only() {
        out_.is_fixed_sufficient = true;
        out_.is_reached = std::abs(out_.reached / out_.requested - 1) <= options_.tolerance;
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
    Execution execution_, progress_execution_;
    std::size_t reported_evaluations_ = 0;
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
        return fail(ErrorKind::usage, "the mesh has no elements that could resolve a solution");
    if (fields.empty()) return fail(ErrorKind::usage, "there is no field from which to compute a metric");
    if (options.max_size != 0 && options.max_size < options.min_size)
        return fail(ErrorKind::usage, "max_size must be at least min_size");
    if (options.max_anisotropy != 0 && options.max_anisotropy < 1)
        return fail(ErrorKind::usage, "max_anisotropy must be at least 1, or 0 for none");
    for (const SolutionField<D>& field : fields) {
        if (field.models.size() != mesh.points.size())
            return fail(ErrorKind::usage, "the models of a field belong to another mesh; there must be one per vertex");
        if (!(field.share > 0) || field.share > 1)
            return fail(ErrorKind::usage, "a field's share of the complexity must be above 0 and at most 1");
    }
    if (!fixed.empty() && fixed.size() != mesh.points.size())
        return fail(ErrorKind::usage, "the fixed metric belongs to another mesh");
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
    return guarded([&] { return Composition<D>(mesh, edges, fields, options, execution).compute_metric(fixed); });
}

#define CAMBER_INSTANTIATE(D)                                                                                        \
    template Outcome<OptimalMetric<D>> optimal_metric<D>(const LinearMesh<D>&, const Column<LocalModel<D>>&,         \
                                                         const MetricTarget&, const Execution&);                     \
    template Outcome<Column<LocalModel<D>>> models_at_vertices<D>(const LinearMesh<D>&, const Incidence<ElementId>&, \
                                                                  const Column<LocalModel<D>>&, const MetricTarget&, \
                                                                  const Execution&);                                 \
    template Outcome<SolutionMetric<D>> make_solution_metric<D>(                                                     \
        const LinearMesh<D>&, const EdgeSet<D>&, std::span<const SolutionField<D>>, const Column<LogMetric<D>>&,     \
        const SolutionMetricOptions&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
