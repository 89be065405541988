module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>
#include <Eigen/Dense>
module camber.surface;
import camber.core;

namespace camber {

namespace {

constexpr int highest_degree = 4;
constexpr int max_terms = 15;
constexpr int max_rows = 128;
using Design = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, max_rows, max_terms>;
using Column1 = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, max_rows, 1>;
using Coefficients = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, max_terms, 1>;

/// Terms of a polynomial in two variables, the constant included.
constexpr int terms_of(int degree) { return (degree + 1) * (degree + 2) / 2; }

/// The exponents of 1, x, y, xx, xy, … by rising degree.
constexpr auto exponents = [] {
    std::array<std::array<std::size_t, 2>, max_terms> out{};
    std::size_t k = 0;
    for (std::size_t degree = 0; degree <= highest_degree; ++degree)
        for (std::size_t j = 0; j <= degree; ++j) out[k++] = {degree - j, j};
    return out;
}();

/// Directions of a height field: x and y along the principal axes of the points' shadows on the plane, z along its
/// normal; and the points' root mean squares along x and y.
struct PlaneFrame {
    Mat<3> axes;
    std::array<double, 2> scale{};

    [[nodiscard]] bool spans_plane() const { return scale[0] > 0 && scale[1] > 0; }
    /// A vector in the frame, x and y in units of their scales.
    [[nodiscard]] Vec<3> scaled(const Vec<3>& d) const {
        const Vec<3> v = transposed_times(axes, d);
        return {{v[0] / scale[0], v[1] / scale[1], v[2]}};
    }
};

PlaneFrame principal_frame(const Vec<3>& normal, std::span<const Vec<3>> offsets) {
    const Vec<3> seed = std::fabs(normal[0]) < 0.6 ? Vec<3>{{1, 0, 0}} : Vec<3>{{0, 1, 0}};
    const Vec<3> u = normalised(cross(normal, seed));
    const Vec<3> v = cross(normal, u);
    double uu = 0, uv = 0, vv = 0;
    for (const Vec<3>& d : offsets) {
        const double x = dot(d, u), y = dot(d, v);
        uu += x * x;
        uv += x * y;
        vv += y * y;
    }
    const double angle = 0.5 * atan2(2 * uv, uu - vv);
    const Vec<3> first = cos(angle) * u + sin(angle) * v;
    const Vec<3> second = cross(normal, first);
    double xx = 0, yy = 0;
    for (const Vec<3>& d : offsets) {
        xx += dot(d, first) * dot(d, first);
        yy += dot(d, second) * dot(d, second);
    }
    const double n = static_cast<double>(offsets.size());
    return {{{first, second, normal}}, {std::sqrt(xx / n), std::sqrt(yy / n)}};
}

std::array<double, highest_degree + 1> powers_of(double x) { return {1, x, x * x, x * x * x, x * x * x * x}; }

/// The least-squares solution; nothing when the columns are dependent or nearly so.
std::optional<Coefficients> solved(Design columns, const Column1& right) {
    constexpr double min_pivot_ratio = 1e-3;
    const Eigen::Index terms = columns.cols();
    if (columns.rows() < terms) return std::nullopt;
    const Coefficients lengths = columns.colwise().norm().transpose();
    if (!(lengths.minCoeff() > 0)) return std::nullopt;
    for (Eigen::Index k = 0; k < terms; ++k) columns.col(k) /= lengths(k);
    const Eigen::ColPivHouseholderQR<Design> qr(columns);
    const auto pivots = qr.matrixQR().diagonal().cwiseAbs();
    if (!(pivots(terms - 1) > min_pivot_ratio * pivots(0))) return std::nullopt;
    const Coefficients solution = qr.solve(right);
    if (!solution.allFinite()) return std::nullopt;
    return solution.cwiseQuotient(lengths);
}

FittedNormal jet_over(const Vec<3>& normal, std::span<const Vec<3>> offsets) {
    constexpr std::array<Eigen::Index, highest_degree + 1> enough{0, 0, 5, 12, 18};
    const PlaneFrame frame = principal_frame(normal, offsets);
    if (!frame.spans_plane()) return {};
    const auto rows = static_cast<Eigen::Index>(offsets.size());
    Design design(rows, max_terms - 1);  // no constant: the height is 0 at the origin
    Column1 heights(rows);
    for (Eigen::Index r = 0; r < rows; ++r) {
        const Vec<3> at = frame.scaled(offsets[static_cast<std::size_t>(r)]);
        const double weight = pow(0.3 + at[0] * at[0] + at[1] * at[1], -1.5);
        const auto x = powers_of(at[0]), y = powers_of(at[1]);
        for (std::size_t k = 1; k < max_terms; ++k)
            design(r, static_cast<Eigen::Index>(k) - 1) = weight * x[exponents[k][0]] * y[exponents[k][1]];
        heights(r) = weight * at[2];
    }
    for (int degree = highest_degree; degree >= 2; --degree) {
        if (rows < enough[static_cast<std::size_t>(degree)]) continue;
        const auto c = solved(design.leftCols(terms_of(degree) - 1), heights);
        if (!c) continue;
        const auto& [x, y, z] = frame.axes.column;
        return {normalised(z - ((*c)(0) / frame.scale[0]) * x - ((*c)(1) / frame.scale[1]) * y), degree};
    }
    return {};
}

}  // namespace

FittedNormal fitted_normal(const Vec<3>& origin, const Vec<3>& normal, std::span<const Vec<3>> points) {
    std::vector<Vec<3>> offsets(std::min<std::size_t>(points.size(), max_rows));
    for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = points[i] - origin;
    if (offsets.empty()) return {};
    const FittedNormal first = jet_over(normal, offsets);
    return first.degree == 0 ? first : jet_over(first.normal, offsets);
}

FittedHeight fitted_height(const Vec<3>& origin, const Vec<3>& normal, std::span<const PointAndNormal> samples) {
    constexpr int rows_per_sample = 3;
    constexpr double min_cosine = 0.2, slope_weight = 0.5, nearness = 0.05;
    const std::size_t count = std::min<std::size_t>(samples.size(), max_rows / rows_per_sample);
    std::vector<Vec<3>> offsets(count);
    for (std::size_t s = 0; s < count; ++s) offsets[s] = samples[s].point - origin;
    if (count == 0) return {};
    const PlaneFrame frame = principal_frame(normal, offsets);
    if (!frame.spans_plane()) return {};

    Design design(rows_per_sample * static_cast<Eigen::Index>(count), max_terms);
    Column1 right(design.rows());
    for (std::size_t s = 0; s < count; ++s) {
        const Vec<3> at = frame.scaled(offsets[s]), n = transposed_times(frame.axes, samples[s].normal);
        if (!(n[2] > min_cosine)) return {};
        const double weight = 1 / (nearness + at[0] * at[0] + at[1] * at[1]);
        const auto x = powers_of(at[0]), y = powers_of(at[1]);
        const Eigen::Index row = rows_per_sample * static_cast<Eigen::Index>(s);
        for (std::size_t k = 0; k < max_terms; ++k) {
            const auto [i, j] = exponents[k];
            const auto column = static_cast<Eigen::Index>(k);
            const double di = static_cast<double>(i), dj = static_cast<double>(j);
            design(row, column) = weight * x[i] * y[j];
            design(row + 1, column) = i == 0 ? 0 : slope_weight * weight * di * x[i - 1] * y[j];
            design(row + 2, column) = j == 0 ? 0 : slope_weight * weight * dj * x[i] * y[j - 1];
        }
        // z = p(x, y) and p_x = −n_x/n_z, p_y = −n_y/n_z, by x and y in units of their scales.
        right(row) = weight * at[2];
        right(row + 1) = -slope_weight * weight * frame.scale[0] * n[0] / n[2];
        right(row + 2) = -slope_weight * weight * frame.scale[1] * n[1] / n[2];
    }
    for (int degree = highest_degree; degree >= 3; --degree)
        if (const auto c = solved(design.leftCols(terms_of(degree)), right)) return {(*c)(0), degree};
    return {};
}

}  // namespace camber
