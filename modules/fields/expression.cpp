// Evaluates scalar expressions with muParser, and metrics from expressions.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <numbers>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
#include <muParser.h>
module camber.fields;
import camber.core;
import camber.metric;

namespace camber {

namespace {

constexpr const char* remedy =
    "it may use x, y, z (3D), pi, numbers, + - * / ^, comparisons, c ? a : b and functions such as sqrt, exp, log, "
    "sin, tanh, atan2, abs, min, max";

/// A character that muParser accepts although it is not legal here: an assignment sign, or a byte that ends the text.
struct IllegalCharacter {
    std::size_t position;
    const char* what;
    const char* remedy;
};
std::optional<IllegalCharacter> intruder_of(std::string_view text) {
    constexpr std::string_view compared = "=<>!";  // characters that form a comparison with a following =
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '\0') return IllegalCharacter{i, "has a NUL character", "end it there"};
        const bool is_comparison =
            i + 1 < text.size() && text[i + 1] == '=' && compared.find(text[i]) != std::string_view::npos;
        if (is_comparison)
            ++i;
        else if (text[i] == '=')
            return IllegalCharacter{i, "assigns with \"=\"", "write == to compare; a formula cannot assign variables"};
    }
    return std::nullopt;
}

/// Defines functions in place of those of the C library, so that results are equal on all processors (see
/// `core:tensors`).
void define_functions(mu::Parser& parser) {
    struct Function {
        const char* name;
        double (*of)(double);
    };
    constexpr std::array functions{
        Function{"exp", exp},     Function{"ln", log},    Function{"log", log},     Function{"log2", log2},
        Function{"log10", log10}, Function{"sin", sin},   Function{"cos", cos},     Function{"tan", tan},
        Function{"asin", asin},   Function{"acos", acos}, Function{"atan", atan},   Function{"sinh", sinh},
        Function{"cosh", cosh},   Function{"tanh", tanh}, Function{"asinh", asinh}, Function{"acosh", acosh},
        Function{"atanh", atanh},
    };
    for (const Function& f : functions) parser.DefineFun(f.name, f.of);
    parser.DefineFun("atan2", static_cast<double (*)(double, double)>(atan2));
}

/// Operator that replaces ^ in expressions. muParser's own ^ calls the C library and cannot be redefined.
constexpr char power_sign = '\x7f';

void define_power(mu::Parser& parser) {
    parser.DefineOprtChars((std::string(parser.ValidOprtChars()) + power_sign).c_str());
    parser.DefineOprt(std::string(1, power_sign), pow, mu::prPOW, mu::oaRIGHT, true);
}

std::string with_replaced(std::string text, char from, char to) {
    std::ranges::replace(text, from, to);
    return text;
}

/// Evaluates an expression. It cannot be moved, because the parser holds addresses of its members.
template <int D>
class Evaluator {
  public:
    explicit Evaluator(const std::string& expression) {
        define_functions(parser_);
        define_power(parser_);
        constexpr std::array names{"x", "y", "z"};
        for (std::size_t i = 0; i < D; ++i) parser_.DefineVar(names[i], &place_[i]);
        parser_.DefineConst("pi", std::numbers::pi);
        parser_.SetExpr(with_replaced(expression, '^', power_sign));
    }
    [[nodiscard]] double operator()(const Vec<D>& x) {
        place_ = x.c;
        return parser_.Eval();
    }
    [[nodiscard]] int results() const { return parser_.GetNumResults(); }

  private:
    mu::Parser parser_;
    std::array<double, D> place_{};
};

template <int D>
void evaluate(Evaluator<D>& evaluator, std::span<const Vec<D>> points, std::span<double> values) {
    const auto none = [&] {
        for (double& value : values) value = std::numeric_limits<double>::quiet_NaN();
    };
    try {
        for (std::size_t i = 0; i < points.size(); ++i) values[i] = evaluator(points[i]);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception&) {
        none();
    } catch (const mu::Parser::exception_type&) {
        none();
    }
}

}  // namespace

std::string quoted_expression(const std::string& text) { return "the expression " + in_quotes(text); }

template <int D>
ScalarExpression<D>::ScalarExpression(std::string text) : text_(std::move(text)) {}

template <int D>
Outcome<ScalarExpression<D>> ScalarExpression<D>::parsed(std::string text) {
    if (const auto intruder = intruder_of(text))
        return fail(
            ErrorKind::usage,
            quoted_expression(text) + " " + intruder->what + " at position " + std::to_string(intruder->position + 1),
            {}, {}, intruder->remedy);
    try {
        Evaluator<D> evaluator(text);
        static_cast<void>(evaluator(Vec<D>{}));
        if (evaluator.results() != 1)
            return fail(
                ErrorKind::usage,
                quoted_expression(text) + " gives " + std::to_string(evaluator.results()) + " values instead of one",
                {}, {}, remedy);
        return ScalarExpression(std::move(text));
    } catch (const mu::Parser::exception_type& error) {
        const auto position = static_cast<long>(error.GetPos());
        std::string what = quoted_expression(text) + " cannot be read";
        if (position >= 0) what += " at position " + std::to_string(position + 1);
        if (!error.GetToken().empty()) what += ", at " + in_quotes(with_replaced(error.GetToken(), power_sign, '^'));
        return fail(ErrorKind::usage, std::move(what), {}, {}, remedy);
    } catch (const std::bad_alloc&) {
        throw;  // `guarded` reports lack of memory
    } catch (const std::exception&) {
        return fail(ErrorKind::usage, quoted_expression(text) + " cannot be read", {}, {}, remedy);
    }
}

template <int D>
std::function<void(std::span<const Vec<D>>, std::span<double>)> ScalarExpression<D>::evaluator() const {
    auto own = std::make_shared<Evaluator<D>>(text_);
    return [own](std::span<const Vec<D>> points, std::span<double> values) { evaluate<D>(*own, points, values); };
}

namespace {

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

template <int D>
Outcome<Done> check_values(const std::vector<std::string>& expressions, const Buffer<double>& values,
                           std::span<const Vec<D>> points, bool (*allowed)(double), const char* expected) {
    for (std::size_t k = 0; k < values.size(); ++k) {
        if (allowed(values[k])) continue;
        const std::size_t v = k / expressions.size();
        std::ostringstream what;
        what << quoted_expression(expressions[k % expressions.size()]) << " is " << values[k] << " at "
             << coordinates(points[v]);
        return fail(ErrorKind::usage, what.str(), {}, Entity{"vertex", v + 1}, expected);
    }
    return Done{};
}

Outcome<Done> check_count(std::size_t input, std::size_t expected, const char* what) {
    if (input == expected) return Done{};
    return fail(ErrorKind::usage,
                "expected " + std::to_string(expected) + " expressions of " + what + ", got " + std::to_string(input));
}

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
Outcome<Column<LogMetric<D>>> evaluate_metric(const SizeExpression& e, std::span<const Vec<D>> points,
                                              const Execution& execution) {
    return by_sizes<D>({e.size}, points, execution);
}
template <int D>
Outcome<Column<LogMetric<D>>> evaluate_metric(const SizesExpression& e, std::span<const Vec<D>> points,
                                              const Execution& execution) {
    if (auto count = check_count(e.sizes.size(), D, "sizes"); !count) return fail(count.error());
    return by_sizes<D>(e.sizes, points, execution);
}
template <int D>
Outcome<Column<LogMetric<D>>> evaluate_metric(const TensorExpression& e, std::span<const Vec<D>> points,
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
    return std::visit([&](const auto& e) { return evaluate_metric<D>(e, points, execution); }, expression);
}

#define CAMBER_INSTANTIATE(D)                                                                                  \
    template class ScalarExpression<D>;                                                                        \
    template Outcome<Column<LogMetric<D>>> log_metrics_of<D>(const MetricExpression&, std::span<const Vec<D>>, \
                                                             const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
