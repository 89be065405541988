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

class SplineBasis {
  public:
    /// Maximum degree in OpenCASCADE.
    static constexpr std::size_t max_degree = 25;

    /// Basis functions that are nonzero at a parameter.
    struct Values {
        std::size_t first;                                            ///< index of the first nonzero function
        std::array<std::array<double, max_degree + 1>, 3> functions;  ///< values, first and second derivatives
    };

    /// `knots`: repeated by multiplicity. `period`: 0 if not periodic.
    SplineBasis(std::size_t degree, std::vector<double> knots, double period);

    [[nodiscard]] std::size_t degree() const { return degree_; }
    [[nodiscard]] std::size_t size() const { return knots_.size() - degree_ - 1; }
    /// Computes the nonzero functions at t. Beyond the knots, the first and last polynomials continue.
    void evaluate(double t, Values& out) const;

  private:
    std::size_t degree_;
    std::vector<double> knots_;
    double period_;
};

/// B-spline or Bezier surface, possibly rational. Evaluation is several times faster than in OpenCASCADE, and equal up
/// to rounding.
class SplineSurface {
  public:
    /// Empty for surfaces that are not splines.
    [[nodiscard]] static std::optional<SplineSurface> of(const Handle(Geom_Surface) & surface, double scale);
    [[nodiscard]] SurfaceJet evaluate(double u, double v) const;

  private:
    SplineSurface(SplineBasis u, SplineBasis v) : u_(std::move(u)), v_(std::move(v)) {}

    SplineBasis u_, v_;
    std::vector<std::array<double, 4>> poles_;  ///< poles with weights; v varies fastest
    bool is_rational_ = false;
};

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

/// Spline curve revolved about an axis: u is the angle, v the curve's parameter.
class RevolvedSpline {
  public:
    /// Empty for surfaces that are not revolved splines.
    [[nodiscard]] static std::optional<RevolvedSpline> of(const Handle(Geom_Surface) & surface, double scale);
    [[nodiscard]] SurfaceJet evaluate(double u, double v) const;

  private:
    explicit RevolvedSpline(SplineCurve curve) : curve_(std::move(curve)) {}

    SplineCurve curve_;
    Point origin_{}, axis_{};  ///< point and unit direction of the axis
};

}  // namespace camber::occ
