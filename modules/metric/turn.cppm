module;
#include <array>
#include <cmath>
#include <cstddef>
export module camber.metric:turn;
import camber.core;
import :eigen;

export namespace camber {

/// A rotation: in 3D about the vector by its length, in 2D by the first entry; in radians.
template <int D>
struct AxesTurn {
    Vec<3> about;

    [[nodiscard]] Vec<D> operator()(const Vec<D>& v) const {
        if constexpr (D == 2) {
            const double c = cos(about[0]), s = sin(about[0]);
            return {{c * v[0] - s * v[1], s * v[0] + c * v[1]}};
        } else {
            // Rodrigues.
            const double angle = norm(about);
            if (!(angle > 0)) return v;
            const Vec<3> axis = about / angle;
            return cos(angle) * v + sin(angle) * cross(axis, v) + ((1 - cos(angle)) * dot(axis, v)) * axis;
        }
    }
    [[nodiscard]] AxesTurn by(double share) const { return {share * about}; }
    [[nodiscard]] bool is_none() const { return about == Vec<3>{}; }
};

/// By how much the axes of a metric turn from one place to another: in the frame of the mean of both logs, from the
/// change ΔL and the difference of log sizes x_ij = λ_i − λ_j, in the plane of axes i and j by
///
///   θ_ij = atan(ΔL_ij / x_ij) (1 − e^{−|x_ij|})² / (1 + (θ/0.9)^8),
///
/// exact where axes turn in one plane. Nothing where both sizes are alike, since what turns there are no axes, and
/// beyond about 0.8 radians, where nobody knows which axis became which.
template <int D>
[[nodiscard]] AxesTurn<D> turn_between(const Sym<D>& from, const Sym<D>& to) {
    const Sym<D> change = to - from;
    const EigenSystem<D> mean = eigen_system(0.5 * (from + to));
    AxesTurn<D> turn{};
    const auto angle = [&](int i, int j) {
        double off = 0;
        for (int a = 0; a < D; ++a)
            for (int b = 0; b < D; ++b) off += mean.vectors(a, i) * change(a, b) * mean.vectors(b, j);
        const double x = mean.values[i] - mean.values[j];
        if (off == 0 || x == 0) return 0.0;
        const double theta = atan(off / x), unlike = 1 - exp(-std::abs(x));
        return theta * unlike * unlike / (1 + pow(theta / 0.9, 8));
    };
    if constexpr (D == 2) {
        // The frame may be a reflection, in which axis 0 turns the other way.
        const double sign = det(mean.vectors.column[0], mean.vectors.column[1]) > 0 ? 1 : -1;
        turn.about[0] = sign * angle(0, 1);
    } else {
        const double sign = det(mean.vectors.column[0], mean.vectors.column[1], mean.vectors.column[2]) > 0 ? 1 : -1;
        for (int k = 0; k < 3; ++k) turn.about += (sign * angle((k + 1) % 3, (k + 2) % 3)) * mean.vectors.column[k];
    }
    return turn;
}

/// A metric with its axes turned.
template <int D>
[[nodiscard]] EigenSystem<D> turned(const EigenSystem<D>& metric, const AxesTurn<D>& turn) {
    if (turn.is_none()) return metric;
    EigenSystem<D> out = metric;
    for (Vec<D>& column : out.vectors.column) column = turn(column);
    return out;
}

}  // namespace camber
