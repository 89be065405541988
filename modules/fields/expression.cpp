module;
#include <cmath>
#include <cstddef>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.fields;
import camber.core;
import camber.metric;

namespace camber {

namespace {

/// The values of expressions at points, row after row; what an evaluation cannot give is NaN.
template <int D>
Outcome<Buffer<double>> values_of(const std::vector<std::string>& expressions, std::span<const Vec<D>> points,
                                  const Execution& execution) {
    std::vector<ScalarExpression<D>> parsed;
    for (const std::string& expression : expressions) {
        auto one = ScalarExpression<D>::parsed(expression);
        if (!one) return fail(one.error());
        parsed.push_back(std::move(*one));
    }
    const std::size_t columns = expressions.size();
    Buffer<double> values(columns * points.size());
    auto done = each_chunk(
        execution, points.size(),
        [&](std::size_t begin, std::size_t end) {
            std::vector<double> column(end - begin);
            for (std::size_t c = 0; c < columns; ++c) {
                parsed[c].evaluator()(points.subspan(begin, end - begin), column);
                for (std::size_t v = begin; v < end; ++v) values[v * columns + c] = column[v - begin];
            }
        },
        4096);
    if (!done) return fail(done.error());
    return values;
}

template <int D>
std::string coordinates(const Vec<D>& x) {
    std::ostringstream text;
    text.precision(10);
    for (int i = 0; i < D; ++i) text << (i > 0 ? ", " : "(") << x[i];
    text << ')';
    return text.str();
}

/// The first value that is not allowed, as an error.
template <int D>
Outcome<Done> check_values(const std::vector<std::string>& expressions, const Buffer<double>& values,
                           std::span<const Vec<D>> points, bool (*allowed)(double), const char* wanted) {
    for (std::size_t k = 0; k < values.size(); ++k) {
        if (allowed(values[k])) continue;
        const std::size_t v = k / expressions.size();
        std::ostringstream what;
        what << quoted_expression(expressions[k % expressions.size()]) << " is " << values[k] << " at "
             << coordinates(points[v]);
        return fail(ErrorKind::usage, what.str(), {}, Entity{"vertex", v + 1}, wanted);
    }
    return Done{};
}

Outcome<Done> check_count(std::size_t given, std::size_t wanted, const char* what) {
    if (given == wanted) return Done{};
    return fail(ErrorKind::usage,
                "expected " + std::to_string(wanted) + " expressions of " + what + ", got " + std::to_string(given));
}

/// Sizes along the axes; a single expression stands for all.
template <int D>
Outcome<Column<LogMetric<D>>> by_sizes(const std::vector<std::string>& expressions, std::span<const Vec<D>> points,
                                       const Execution& execution) {
    auto values = values_of<D>(expressions, points, execution);
    if (!values) return fail(values.error());
    const auto allowed = [](double h) { return h > 0 && std::isfinite(h); };
    if (auto sound = check_values<D>(expressions, *values, points, allowed, "a size must be positive and finite");
        !sound)
        return fail(sound.error());
    const std::size_t columns = expressions.size();
    auto logs = map_each(execution, points.size(), [&](std::size_t v) {
        Vec<D> sizes;
        for (std::size_t i = 0; i < D; ++i) sizes[i] = (*values)[v * columns + (columns == 1 ? 0 : i)];
        return log_metric_of_sizes(sizes);
    });
    if (!logs) return fail(logs.error());
    return Column<LogMetric<D>>(std::move(*logs));
}

template <int D>
Outcome<Column<LogMetric<D>>> made(const SizeExpression& e, std::span<const Vec<D>> points,
                                   const Execution& execution) {
    return by_sizes<D>({e.size}, points, execution);
}
template <int D>
Outcome<Column<LogMetric<D>>> made(const SizesExpression& e, std::span<const Vec<D>> points,
                                   const Execution& execution) {
    if (auto count = check_count(e.sizes.size(), D, "sizes"); !count) return fail(count.error());
    return by_sizes<D>(e.sizes, points, execution);
}
template <int D>
Outcome<Column<LogMetric<D>>> made(const TensorExpression& e, std::span<const Vec<D>> points,
                                   const Execution& execution) {
    if (auto count = check_count(e.tensor.size(), sym_size<D>, "the tensor's entries"); !count)
        return fail(count.error());
    auto values = values_of<D>(e.tensor, points, execution);
    if (!values) return fail(values.error());
    const auto allowed = [](double x) { return std::isfinite(x); };
    if (auto sound = check_values<D>(e.tensor, *values, points, allowed, "an entry must be finite"); !sound)
        return fail(sound.error());
    auto logs = log_metrics_of_tensors<D>(*values, TensorPrecision::eight_bytes, execution);
    if (!logs) {
        Error error = logs.error();
        if (error.entity && error.entity->number <= points.size()) {
            error.kind = ErrorKind::usage;
            error.entity->kind = "vertex";
            error.what =
                "the expressions' tensor " + error.what + " at " + coordinates(points[error.entity->number - 1]);
            error.remedy = "its eigenvalues must be positive, between 1e-120 and 1e120";
        }
        return fail(std::move(error));
    }
    return Column<LogMetric<D>>(std::move(logs->log_metrics));
}

}  // namespace

template <int D>
Outcome<Column<LogMetric<D>>> log_metrics_of(const MetricExpression& expression, std::span<const Vec<D>> points,
                                             const Execution& execution) {
    return std::visit([&](const auto& e) { return made<D>(e, points, execution); }, expression);
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template Outcome<Column<LogMetric<D>>> log_metrics_of<D>(const MetricExpression&, std::span<const Vec<D>>, \
                                                             const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
