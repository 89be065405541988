// Cubic forms for the tests.
#pragma once

#include <cmath>

#include "dice.hpp"

import camber.core;

namespace camber::testing {

/// A form with random entries in a frame whose axes differ by up to the anisotropy.
template <int D>
CubicForm<D> random_form(Dice& dice, double anisotropy) {
    CubicForm<D> t;
    for (double& x : t.c) x = dice.uniform(-1, 1);
    Mat<D> to_frame = Mat<D>::identity();
    for (int i = 1; i < D; ++i)
        to_frame(i, i) = i == D - 1 ? 1 / anisotropy : std::pow(anisotropy, -dice.uniform(0, 1));
    return pulled_back(t, to_frame);
}

/// (n·v)³ + 3c (n·v) |v across n|², the form of a front.
template <int D>
CubicForm<D> front_form(const Vec<D>& n, double c) {
    CubicForm<D> t;
    for (int j = 0; j < D; ++j)
        for (int k = 0; k <= j; ++k)
            for (int l = 0; l <= k; ++l) {
                const double mixed = (j == k ? n[l] : 0) + (k == l ? n[j] : 0) + (l == j ? n[k] : 0);
                t(j, k, l) = n[j] * n[k] * n[l] + c * (mixed - 3 * n[j] * n[k] * n[l]);
            }
    return t;
}

/// A frame from the diagonal entries of the form.
template <int D>
Mat<D> frame_by_entries(const CubicForm<D>& t) {
    Mat<D> f = Mat<D>::identity();
    for (int j = 0; j < D; ++j) f(j, j) = std::exp(-2.0 / 3 * std::log(std::abs(t(j, j, j))) / 2);
    return f;
}

}  // namespace camber::testing
