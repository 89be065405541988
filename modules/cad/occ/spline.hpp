#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>
#include <Geom_Curve.hxx>
#include <Geom_Surface.hxx>

#include "kernel.hpp"

namespace camber::occ {

/// The B-spline functions of one parameter.
class SplineBasis {
  public:
    /// Highest degree of a spline of OpenCASCADE.
    static constexpr std::size_t max_degree = 25;

    /// The functions that do not vanish at a parameter.
    struct Values {
        std::size_t first;                                            ///< index of the first of them
        std::array<std::array<double, max_degree + 1>, 3> functions;  ///< values, first and second derivatives
    };

    /// `knots`: flat, each as often as its multiplicity says. `period`: 0 where the spline is not periodic.
    SplineBasis(std::size_t degree, std::vector<double> knots, double period);

    [[nodiscard]] std::size_t degree() const { return degree_; }
    /// Number of functions.
    [[nodiscard]] std::size_t size() const { return knots_.size() - degree_ - 1; }
    /// Beyond the knots the polynomials of the first and of the last span continue.
    void evaluate(double t, Values& out) const;

  private:
    std::size_t degree_;
    std::vector<double> knots_;
    double period_;
};

/// A B-spline or Bezier surface, rational or not. Evaluates points and two derivatives several times as fast as
/// OpenCASCADE, and equal to it up to rounding.
class SplineSurface {
  public:
    /// Nothing where the surface is of another kind.
    [[nodiscard]] static std::optional<SplineSurface> of(const Handle(Geom_Surface) & surface, double scale);
    [[nodiscard]] SurfaceJet evaluate(double u, double v) const;

  private:
    SplineSurface(SplineBasis u, SplineBasis v) : u_(std::move(u)), v_(std::move(v)) {}

    SplineBasis u_, v_;
    std::vector<std::array<double, 4>> poles_;  ///< and their weights; rows of v
    bool is_rational_ = false;
};

/// The same of a curve.
class SplineCurve {
  public:
    [[nodiscard]] static std::optional<SplineCurve> of(const Handle(Geom_Curve) & curve, double scale);
    [[nodiscard]] CurveJet evaluate(double t) const;

  private:
    explicit SplineCurve(SplineBasis t) : t_(std::move(t)) {}

    SplineBasis t_;
    std::vector<std::array<double, 4>> poles_;
    bool is_rational_ = false;
};

/// A spline curve turned about an axis: u is the angle, v the curve's parameter.
class RevolvedSpline {
  public:
    /// Nothing where the surface is of another kind, or its curve is no spline.
    [[nodiscard]] static std::optional<RevolvedSpline> of(const Handle(Geom_Surface) & surface, double scale);
    [[nodiscard]] SurfaceJet evaluate(double u, double v) const;

  private:
    explicit RevolvedSpline(SplineCurve curve) : curve_(std::move(curve)) {}

    SplineCurve curve_;
    Point origin_{}, axis_{};  ///< a point of the axis, and its direction of length 1
};

}  // namespace camber::occ
