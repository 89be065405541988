#include "edge.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "back_field.hpp"
#include "exponential.hpp"
#include "matrix.hpp"

namespace paper {

namespace {

/// Gauss points ½ (1 ∓ √(3/5)), ½ and their weights.
constexpr std::array<double, 3> gauss_points{0.1127016653792583, 0.5, 0.8872983346207417};
constexpr std::array<double, 3> gauss_weights{5.0 / 18, 8.0 / 18, 5.0 / 18};

}  // namespace

Edge::Edge(const BackField& field, Along along, std::uint32_t a, std::uint32_t b, std::uint32_t hint)
    : field_(&field),
      along_(along),
      at_(hint),
      p20_(field.vertices[a].point),
      p02_(field.vertices[b].point),
      log20_(field.vertices[a].log_metric),
      log02_(field.vertices[b].log_metric) {}

template <std::size_t N>
bool Edge::find(const Vector& p, Jet<N>& log_metric) {
    const auto place = locate(*field_, p, at_);
    ++work_.walks;
    if (!place) return false;
    work_.steps += place->steps;
    at_ = place->element;
    log_metric = log_metric_at<N>(*field_, *place);
    return true;
}

template <std::size_t N>
bool Edge::log_metrics(const Vector& node, AtPoints<N>& logs) {
    if (along_ == Along::nodes) {
        Jet<N> mid;
        if (!find(node, mid)) return false;
        for (std::size_t q = 0; q < 3; ++q) {
            const double t = gauss_points[q];
            logs[q] = mid;
            scale(logs[q], 4 * t * (1 - t));
            add(logs[q].value, (1 - t) * (1 - 2 * t), log20_);
            add(logs[q].value, t * (2 * t - 1), log02_);
        }
        return true;
    }
    const Vector offset = node - middle();
    for (std::size_t q = 0; q < 3; ++q) {
        const double t = gauss_points[q];
        const double share = 4 * t * (1 - t);
        if (!find((1 - t) * p20_ + t * p02_ + share * offset, logs[q])) return false;
        for (Symmetric& slope : logs[q].slope) slope = share * slope;
    }
    return true;
}

double Edge::value(const Vector& node) {
    ++work_.values;
    AtPoints<0> logs;
    if (!log_metrics(node, logs)) return std::numeric_limits<double>::infinity();
    const Vector offset = node - middle();
    double sum = 0;
    for (std::size_t q = 0; q < 3; ++q) {
        const Vector derivative = (p02_ - p20_) + 4 * (1 - 2 * gauss_points[q]) * offset;
        sum += gauss_weights[q] * std::sqrt(quadratic_form(exponential(logs[q]).value, derivative));
    }
    return sum;
}

Length Edge::value_and_gradient(const Vector& node) {
    ++work_.gradients;
    AtPoints<3> logs;
    if (!log_metrics(node, logs)) return {std::numeric_limits<double>::infinity(), {}};
    const Vector offset = node - middle();
    Length sum;
    for (std::size_t q = 0; q < 3; ++q) {
        const double c = 4 * (1 - 2 * gauss_points[q]);
        const Vector derivative = (p02_ - p20_) + c * offset;
        const Jet<3> metric = exponential(logs[q]);
        const Vector covector = metric.value * derivative;
        const double root = std::sqrt(dot(derivative, covector));
        sum.value += gauss_weights[q] * root;
        const double slope = root > 0 ? gauss_weights[q] * 0.5 / root : 0;
        for (std::size_t i = 0; i < 3; ++i)
            sum.gradient[i] += slope * (2 * c * covector[i] + quadratic_form(metric.slope[i], derivative));
    }
    return sum;
}

Symmetric Edge::inverse_metric(const Vector& point) {
    Jet<0> log;
    if (!find(point, log)) return {{1, 0, 1, 0, 0, 1}};
    scale(log, -1);
    return exponential(log).value;
}

}  // namespace paper
