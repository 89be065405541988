// Loss of a metric field that is transferred repeatedly between curved meshes.
#include <doctest/doctest.h>

#include <cmath>

#include "restarts.hpp"

import camber.core;
import camber.bezier;
import camber.metric;

using namespace camber;
using namespace camber::testing;

namespace {

template <int D>
void check_restarts(int n, double growth) {
    const GrowingBox<D> box{.growth = growth, .cells = static_cast<double>(n)};
    const FieldInBox<D> unit = [&](const Vec<D>& t) { return box.metric(t); };
    const Figures quadratic = drift(box, unit, n, 20, Form::quadratic);
    const Figures linear = drift(box, unit, n, 20, Form::linear);
    MESSAGE("quadratic: complexity " << quadratic.complexity << ", anisotropy " << quadratic.anisotropy);
    MESSAGE("linear: complexity " << linear.complexity << ", anisotropy " << linear.anisotropy);
    CHECK(std::abs(quadratic.complexity) < 0.01);
    CHECK(std::abs(quadratic.anisotropy) < 0.01);
    CHECK(std::abs(linear.anisotropy) > std::abs(quadratic.anisotropy));
}

}  // namespace

TEST_CASE("twenty restarts keep complexity and the maximum anisotropy in 2D") { check_restarts<2>(16, 5); }
TEST_CASE("twenty restarts keep complexity and the maximum anisotropy in 3D") { check_restarts<3>(7, 3); }
