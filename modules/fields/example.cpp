// Example of camber.fields: evaluates metrics that are functions of position, from a named field and from a user's
// expressions.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

import camber.core;
import camber.metric;
import camber.fields;

using namespace camber;

/// The metric's size along a unit vector: 1/sqrt(vᵀ M v).
static double size_along(const LogMetric<2>& log_metric, const Vec<2>& direction) {
    return 1 / std::sqrt(SpectralMetric<2>(log_metric).length_squared(direction));
}

static Outcome<bool> example(const Execution& execution) {
    const std::vector<Vec<2>> points{{{0.1, 0}}, {{0.5, 0}}, {{0.9, 0}}};  // along the x axis: x is the radius
    const Vec<2> radial{{1, 0}}, tangential{{0, 1}};

    // A named field: a curved layer on the circle of radius 0.5.
    const PolarOneField layer{.min_size = 0.001, .size = 0.1, .radius = 0.5};
    const auto polar = log_metrics_of<2>(AnalyticField<2>(layer), points, execution);
    if (!polar) return fail(polar.error());
    // A field from expressions: one size for each axis.
    const SizesExpression text{{"0.001 + 0.2*abs(x - 0.5)", "0.1"}};
    const auto written = log_metrics_of<2>(MetricExpression(text), points, execution);
    if (!written) return fail(written.error());

    double difference = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::printf("x = %.1f: sizes %.4f and %.4f, anisotropy %.1f\n", points[i][0], size_along((*polar)[i], radial),
                    size_along((*polar)[i], tangential), anisotropy((*polar)[i]));
        // On the x axis the fields are equal except for a factor: 0.2 in the expression, 2 (size − min_size) = 0.198 in
        // the named field.
        difference =
            std::max(difference, std::abs(size_along((*polar)[i], radial) - size_along((*written)[i], radial)));
    }
    std::printf("the written field is the named one to %.4f\n", difference);

    // The error contains the expression and the position of the fault.
    const auto wrong = log_metrics_of<2>(MetricExpression(SizeExpression{"0.1 + 0.2*r"}), points, execution);
    if (!wrong) std::printf("refused: %s\n", describe(wrong.error()).c_str());
    const bool thin = std::abs(anisotropy((*polar)[1]) - 100) < 1e-9;
    return thin && difference < 1e-3 && !wrong && wrong.error().kind == ErrorKind::usage;
}

int main() {
    const auto right = example(Execution{});
    if (!right) std::fprintf(stderr, "%s\n", describe(right.error()).c_str());
    return right && *right ? 0 : 1;
}
