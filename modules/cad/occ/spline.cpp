// B-splines with two derivatives by the recurrence of Cox and de Boor (Piegl and Tiller, The NURBS Book, 1997,
// algorithms 2.2 and 4.4).
#include "spline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_BezierCurve.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <gp_Dir.hxx>
#include <gp_Pnt.hxx>

namespace camber::occ {

namespace {

using Row = std::array<double, SplineBasis::max_degree + 1>;
using Weighted = std::array<double, 4>;

void add(Weighted& sum, double factor, const Weighted& term) {
    for (std::size_t i = 0; i < 4; ++i) sum[i] += factor * term[i];
}

Weighted pole_of(const gp_Pnt& pole, double weight, double scale) {
    return {pole.X() * scale, pole.Y() * scale, pole.Z() * scale, weight};
}

/// Weighted pole relative to `origin`. Near coincident poles, as on spheres, sums of such terms keep all digits.
Weighted relative(const Weighted& pole, const Weighted& origin) {
    const double w = pole[3];
    return {w * (pole[0] - origin[0]), w * (pole[1] - origin[1]), w * (pole[2] - origin[2]), w};
}

std::size_t largest_of(const SplineBasis::Values& at, std::size_t degree) {
    const auto begin = at.functions[0].begin();
    return static_cast<std::size_t>(std::max_element(begin, begin + static_cast<std::ptrdiff_t>(degree) + 1) - begin);
}

/// Computes the derivatives of the basis functions of degree `to` from the basis functions of degree `to` − 1, in the
/// span that begins at knot i.
void differentiate(const std::vector<double>& knots, std::size_t i, std::size_t to, const Row& from, Row& out) {
    const auto factor = static_cast<double>(to);
    double before = 0;
    for (std::size_t r = 0; r < to; ++r) {
        const double slope = factor * from[r] / (knots[i + r + 1] - knots[i + r + 1 - to]);
        out[r] = before - slope;
        before = slope;
    }
    out[to] = before;
}

SplineBasis bezier_basis(int degree) {
    const auto order = static_cast<std::size_t>(degree) + 1;
    std::vector<double> knots(2 * order, 0.0);
    std::fill(knots.begin() + static_cast<std::ptrdiff_t>(order), knots.end(), 1.0);
    return {order - 1, std::move(knots), 0};
}

SplineBasis basis_of(int degree, const TColStd_Array1OfReal& flat, double period) {
    std::vector<double> knots;
    knots.reserve(static_cast<std::size_t>(flat.Length()));
    for (int i = flat.Lower(); i <= flat.Upper(); ++i) knots.push_back(flat.Value(i));
    return {static_cast<std::size_t>(degree), std::move(knots), period};
}

template <class Spline>
std::vector<Weighted> poles_of_surface(const Spline& spline, double scale) {
    std::vector<Weighted> poles;
    poles.reserve(static_cast<std::size_t>(spline.NbUPoles()) * static_cast<std::size_t>(spline.NbVPoles()));
    for (int i = 1; i <= spline.NbUPoles(); ++i)
        for (int j = 1; j <= spline.NbVPoles(); ++j)
            poles.push_back(pole_of(spline.Pole(i, j), spline.Weight(i, j), scale));
    return poles;
}

template <class Spline>
std::vector<Weighted> poles_of_curve(const Spline& spline, double scale) {
    std::vector<Weighted> poles;
    poles.reserve(static_cast<std::size_t>(spline.NbPoles()));
    for (int i = 1; i <= spline.NbPoles(); ++i) poles.push_back(pole_of(spline.Pole(i), spline.Weight(i), scale));
    return poles;
}

Point point_of(const Weighted& x) { return {x[0], x[1], x[2]}; }
Point sum_of(const Weighted& a, const Weighted& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

}  // namespace

SplineBasis::SplineBasis(std::size_t degree, std::vector<double> knots, double period)
    : degree_(degree), knots_(std::move(knots)), period_(period) {}

void SplineBasis::evaluate(double t, Values& out) const {
    const std::size_t p = degree_;
    if (period_ > 0) t -= period_ * std::floor((t - knots_[p]) / period_);
    const auto inner = knots_.begin() + static_cast<std::ptrdiff_t>(p);
    const auto end = knots_.end() - static_cast<std::ptrdiff_t>(p) - 1;
    auto after = std::upper_bound(inner, end, t);
    if (after == inner) after = std::upper_bound(inner, end, *inner);
    if (after == end) after = std::lower_bound(inner, end, *end);  // the last span that is not empty
    const auto i = static_cast<std::size_t>(after - knots_.begin()) - 1;
    out.first = i - p;
    auto& [values, first, second] = out.functions;
    Row left, right, lower, lowest, slope;  // `lower`, `lowest`: basis functions of degrees lower by one and by two
    values[0] = 1;
    for (std::size_t q = 1; q <= p; ++q) {
        if (q == p) std::copy_n(values.begin(), q, lower.begin());
        if (q + 1 == p) std::copy_n(values.begin(), q, lowest.begin());
        left[q] = t - knots_[i + 1 - q];
        right[q] = knots_[i + q] - t;
        double saved = 0;
        for (std::size_t r = 0; r < q; ++r) {
            const double share = values[r] / (right[r + 1] + left[q - r]);
            values[r] = saved + right[r + 1] * share;
            saved = left[q - r] * share;
        }
        values[q] = saved;
    }
    differentiate(knots_, i, p, lower, first);
    if (p < 2) {
        std::fill_n(second.begin(), p + 1, 0.0);
        return;
    }
    differentiate(knots_, i, p - 1, lowest, slope);
    differentiate(knots_, i, p, slope, second);
}

std::optional<SplineSurface> SplineSurface::of(const Handle(Geom_Surface) & surface, double scale) {
    if (const auto bezier = Handle(Geom_BezierSurface)::DownCast(surface); !bezier.IsNull()) {
        SplineSurface out(bezier_basis(bezier->UDegree()), bezier_basis(bezier->VDegree()));
        out.poles_ = poles_of_surface(*bezier, scale);
        out.is_rational_ = bezier->IsURational() || bezier->IsVRational();
        return out;
    }
    const auto input = Handle(Geom_BSplineSurface)::DownCast(surface);
    if (input.IsNull()) return std::nullopt;
    const double u_period = input->IsUPeriodic() ? input->UPeriod() : 0;
    const double v_period = input->IsVPeriodic() ? input->VPeriod() : 0;
    const auto spline = Handle(Geom_BSplineSurface)::DownCast(input->Copy());
    if (u_period > 0) spline->SetUNotPeriodic();
    if (v_period > 0) spline->SetVNotPeriodic();
    SplineSurface out(basis_of(spline->UDegree(), spline->UKnotSequence(), u_period),
                      basis_of(spline->VDegree(), spline->VKnotSequence(), v_period));
    out.poles_ = poles_of_surface(*spline, scale);
    out.is_rational_ = spline->IsURational() || spline->IsVRational();
    if (out.poles_.size() != out.u_.size() * out.v_.size()) return std::nullopt;
    return out;
}

SurfaceJet SplineSurface::evaluate(double u, double v) const {
    SplineBasis::Values in_u{}, in_v{};
    u_.evaluate(u, in_u);
    v_.evaluate(v, in_v);
    const Weighted& origin =
        poles_[(in_u.first + largest_of(in_u, u_.degree())) * v_.size() + in_v.first + largest_of(in_v, v_.degree())];
    Weighted s{}, su{}, sv{}, suu{}, suv{}, svv{};
    for (std::size_t a = 0; a <= u_.degree(); ++a) {
        const Weighted* const row = poles_.data() + (in_u.first + a) * v_.size() + in_v.first;
        Weighted value{}, first{}, second{};
        for (std::size_t b = 0; b <= v_.degree(); ++b) {
            const Weighted pole = relative(row[b], origin);
            add(value, in_v.functions[0][b], pole);
            add(first, in_v.functions[1][b], pole);
            add(second, in_v.functions[2][b], pole);
        }
        add(s, in_u.functions[0][a], value);
        add(su, in_u.functions[1][a], value);
        add(suu, in_u.functions[2][a], value);
        add(sv, in_u.functions[0][a], first);
        add(suv, in_u.functions[1][a], first);
        add(svv, in_u.functions[0][a], second);
    }
    if (!is_rational_)
        return {sum_of(origin, s), point_of(su), point_of(sv), point_of(suu), point_of(suv), point_of(svv)};
    SurfaceJet jet{};
    const double w = s[3];
    for (std::size_t k = 0; k < 3; ++k) {
        const double x = s[k] / w;
        jet.point[k] = origin[k] + x;
        const double xu = jet.u[k] = (su[k] - su[3] * x) / w, xv = jet.v[k] = (sv[k] - sv[3] * x) / w;
        jet.uu[k] = (suu[k] - 2 * su[3] * xu - suu[3] * x) / w;
        jet.uv[k] = (suv[k] - su[3] * xv - sv[3] * xu - suv[3] * x) / w;
        jet.vv[k] = (svv[k] - 2 * sv[3] * xv - svv[3] * x) / w;
    }
    return jet;
}

std::optional<SplineCurve> SplineCurve::of(const Handle(Geom_Curve) & curve, double scale) {
    if (const auto bezier = Handle(Geom_BezierCurve)::DownCast(curve); !bezier.IsNull()) {
        SplineCurve out(bezier_basis(bezier->Degree()));
        out.poles_ = poles_of_curve(*bezier, scale);
        out.is_rational_ = bezier->IsRational();
        return out;
    }
    const auto input = Handle(Geom_BSplineCurve)::DownCast(curve);
    if (input.IsNull()) return std::nullopt;
    const double period = input->IsPeriodic() ? input->Period() : 0;
    const auto spline = Handle(Geom_BSplineCurve)::DownCast(input->Copy());
    if (period > 0) spline->SetNotPeriodic();
    SplineCurve out(basis_of(spline->Degree(), spline->KnotSequence(), period));
    out.poles_ = poles_of_curve(*spline, scale);
    out.is_rational_ = spline->IsRational();
    if (out.poles_.size() != out.t_.size()) return std::nullopt;
    return out;
}

CurveJet SplineCurve::evaluate(double t) const {
    SplineBasis::Values at{};
    t_.evaluate(t, at);
    const Weighted& origin = poles_[at.first + largest_of(at, t_.degree())];
    Weighted c{}, first{}, second{};
    for (std::size_t a = 0; a <= t_.degree(); ++a) {
        const Weighted pole = relative(poles_[at.first + a], origin);
        add(c, at.functions[0][a], pole);
        add(first, at.functions[1][a], pole);
        add(second, at.functions[2][a], pole);
    }
    if (!is_rational_) return {sum_of(origin, c), point_of(first), point_of(second)};
    CurveJet jet{};
    for (std::size_t k = 0; k < 3; ++k) {
        const double x = c[k] / c[3];
        jet.point[k] = origin[k] + x;
        const double slope = jet.first[k] = (first[k] - first[3] * x) / c[3];
        jet.second[k] = (second[k] - 2 * first[3] * slope - second[3] * x) / c[3];
    }
    return jet;
}

std::optional<RevolvedSpline> RevolvedSpline::of(const Handle(Geom_Surface) & surface, double scale) {
    const auto revolved = Handle(Geom_SurfaceOfRevolution)::DownCast(surface);
    if (revolved.IsNull()) return std::nullopt;
    auto curve = SplineCurve::of(revolved->BasisCurve(), scale);
    if (!curve) return std::nullopt;
    RevolvedSpline out(std::move(*curve));
    const gp_Pnt& origin = revolved->Axis().Location();
    const gp_Dir& axis = revolved->Axis().Direction();
    out.origin_ = {scale * origin.X(), scale * origin.Y(), scale * origin.Z()};
    out.axis_ = {axis.X(), axis.Y(), axis.Z()};
    return out;
}

SurfaceJet RevolvedSpline::evaluate(double u, double v) const {
    const double c = std::cos(u), s = std::sin(u);
    // Rotates a vector by the angle; computes two derivatives of the result with respect to the angle.
    const auto turned = [&](const Point& x, Point& value, Point& first, Point* second) {
        const double along = x[0] * axis_[0] + x[1] * axis_[1] + x[2] * axis_[2];
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
            const double across = x[k] - along * axis_[k], aside = axis_[i] * x[j] - axis_[j] * x[i];
            value[k] = along * axis_[k] + c * across + s * aside;
            first[k] = c * aside - s * across;
            if (second) (*second)[k] = -(c * across + s * aside);
        }
    };
    const CurveJet curve = curve_.evaluate(v);
    SurfaceJet jet{};
    Point from_origin{}, unused{};
    for (std::size_t k = 0; k < 3; ++k) from_origin[k] = curve.point[k] - origin_[k];
    turned(from_origin, jet.point, jet.u, &jet.uu);
    for (std::size_t k = 0; k < 3; ++k) jet.point[k] += origin_[k];
    turned(curve.first, jet.v, jet.uv, nullptr);
    turned(curve.second, jet.vv, unused, nullptr);
    return jet;
}

}  // namespace camber::occ
