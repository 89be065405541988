// Random metrics.
#pragma once

#include <cmath>

#include "dice.hpp"

import camber.core;
import camber.metric;

namespace camber::testing {

/// Sizes over `decades` powers of ten along random axes.
template <int D>
LogMetric<D> random_metric(Dice& dice, double decades) {
    Vec<D> sizes;
    for (double& h : sizes.c) h = std::pow(10.0, dice.uniform(-decades, 0));
    return log_metric_of_sizes<D>(sizes, dice.rotation<D>());
}

}  // namespace camber::testing
