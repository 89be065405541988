module;
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>
module camber.surface;
import camber.core;

namespace camber {

namespace {

constexpr int cubic_terms = 9, quadratic_terms = 5;
constexpr std::size_t most_rows = 256;
using Design = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, most_rows, cubic_terms>;
using Heights = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, most_rows, 1>;

std::array<double, cubic_terms> monomials(double x, double y) {
    return {x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y};
}

/// Columns: the principal axes of the points' shadows on the plane of `normal`, then `normal`.
struct Frame {
    Mat<3> axes;
    std::array<double, 2> scale{};
};

Frame principal_frame(const Vec<3>& normal, std::span<const Vec<3>> offsets) {
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
    const double angle = 0.5 * std::atan2(2 * uv, uu - vv);
    const Vec<3> first = std::cos(angle) * u + std::sin(angle) * v;
    const Vec<3> second = cross(normal, first);
    const double n = static_cast<double>(offsets.size());
    double xx = 0, yy = 0;
    for (const Vec<3>& d : offsets) {
        xx += dot(d, first) * dot(d, first);
        yy += dot(d, second) * dot(d, second);
    }
    return {{{first, second, normal}}, {std::sqrt(xx / n), std::sqrt(yy / n)}};
}

/// The fit with so many terms; false when the points do not determine them.
bool solve(const Design& design, const Heights& heights, int terms, std::array<double, 9>& c) {
    constexpr double least_pivot_ratio = 2e-3;
    Design columns = design.leftCols(terms);
    Eigen::Array<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, cubic_terms> lengths = columns.colwise().norm();
    if (!(lengths.minCoeff() > 0)) return false;
    for (int k = 0; k < terms; ++k) columns.col(k) /= lengths(k);
    const Eigen::ColPivHouseholderQR<Design> qr(columns);
    const auto pivots = qr.matrixQR().diagonal().cwiseAbs();
    if (!(pivots(terms - 1) > least_pivot_ratio * pivots(0))) return false;
    const Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, cubic_terms, 1> solution = qr.solve(heights);
    c.fill(0);
    for (int k = 0; k < terms; ++k) c[static_cast<std::size_t>(k)] = solution(k) / lengths(k);
    return true;
}

Jet fit_over(const Vec<3>& origin, const Vec<3>& normal, std::span<const Vec<3>> offsets) {
    constexpr Eigen::Index enough_for_cubic = 12, enough_for_quadratic = 5;
    const Frame frame = principal_frame(normal, offsets);
    Jet jet{.origin = origin, .frame = frame.axes, .scale = frame.scale};
    if (!(frame.scale[0] > 0 && frame.scale[1] > 0)) return jet;
    const auto rows = static_cast<Eigen::Index>(offsets.size());
    Design design(rows, cubic_terms);
    Heights heights(rows);
    for (Eigen::Index r = 0; r < rows; ++r) {
        const Vec<3>& d = offsets[static_cast<std::size_t>(r)];
        const double x = dot(d, frame.axes.column[0]) / frame.scale[0];
        const double y = dot(d, frame.axes.column[1]) / frame.scale[1];
        const double weight = 1 / (0.1 + x * x + y * y);
        const auto terms = monomials(x, y);
        for (int k = 0; k < cubic_terms; ++k) design(r, k) = weight * terms[static_cast<std::size_t>(k)];
        heights(r) = weight * dot(d, normal);
    }
    if (rows >= enough_for_cubic && solve(design, heights, cubic_terms, jet.c)) jet.degree = 3;
    else if (rows >= enough_for_quadratic && solve(design, heights, quadratic_terms, jet.c)) jet.degree = 2;
    return jet;
}

}  // namespace

Vec<3> Jet::normal() const {
    return normalised(frame.column[2] - (c[0] / scale[0]) * frame.column[0] - (c[1] / scale[1]) * frame.column[1]);
}

JetMeeting meet(const Jet& jet, const Vec<3>& q, const Vec<3>& direction) {
    constexpr int most_steps = 4;
    if (jet.degree == 0) return {};
    double s = 0;
    const Vec<3> along = transposed_times(jet.frame, direction);
    const Vec<3> from = transposed_times(jet.frame, q - jet.origin);
    const double rate_x = along[0] / jet.scale[0], rate_y = along[1] / jet.scale[1];
    for (int step = 0; step < most_steps; ++step) {
        const Vec<3> at = from + s * along;
        const double x = at[0] / jet.scale[0], y = at[1] / jet.scale[1];
        const auto& c = jet.c;
        double height = 0;
        const auto terms = monomials(x, y);
        for (std::size_t k = 0; k < terms.size(); ++k) height += c[k] * terms[k];
        const double by_x = c[0] + 2 * c[2] * x + c[3] * y + 3 * c[5] * x * x + 2 * c[6] * x * y + c[7] * y * y;
        const double by_y = c[1] + c[3] * x + 2 * c[4] * y + c[6] * x * x + 2 * c[7] * x * y + 3 * c[8] * y * y;
        const double slope = along[2] - by_x * rate_x - by_y * rate_y;
        if (!(std::fabs(slope) > 0.1)) return {};
        s -= (at[2] - height) / slope;
    }
    return {s, std::isfinite(s)};
}

Jet fit_jet(const Vec<3>& origin, const Vec<3>& normal, std::span<const Vec<3>> points) {
    std::vector<Vec<3>> offsets(std::min(points.size(), most_rows));
    for (std::size_t i = 0; i < offsets.size(); ++i) offsets[i] = points[i] - origin;
    if (offsets.empty()) return {};
    const Jet first = fit_over(origin, normal, offsets);
    if (first.degree == 0) return first;
    return fit_over(origin, first.normal(), offsets);
}

}  // namespace camber
