#include "targets.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

import camber.core;
import camber.fields;
import camber.metric;

namespace fuzz {

namespace {

using namespace camber;

template <int D>
void expect_metrics(const MetricExpression& expression) {
    std::array<Vec<D>, 3> points{};
    for (int c = 0; c < D; ++c)
        points[1][static_cast<std::size_t>(c)] = 1.5, points[2][static_cast<std::size_t>(c)] = -2;
    const auto metrics = log_metrics_of<D>(expression, std::span<const Vec<D>>(points), {.threads = 1});
    if (metrics) {
        expect(metrics->size() == points.size(), "a metric at each point");
        return;
    }
    expect(metrics.error().kind == ErrorKind::usage, "a bad expression is a usage error");
    expect(!metrics.error().what.empty(), "an error has a description");
}

}  // namespace

void expression(Bytes bytes) {
    std::vector<std::string> lines(1);
    for (const std::byte b : bytes) {
        const char letter = static_cast<char>(b);
        if (letter == '\n')
            lines.emplace_back();
        else
            lines.back() += letter;
    }
    expect_metrics<2>(SizeExpression{lines[0]});
    expect_metrics<3>(SizeExpression{lines[0]});
    expect_metrics<2>(SizesExpression{lines});
    expect_metrics<3>(SizesExpression{lines});
    expect_metrics<2>(TensorExpression{lines});
    expect_metrics<3>(TensorExpression{lines});
}

}  // namespace fuzz
