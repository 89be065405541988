module;
#include <functional>
#include <span>
#include <string>
#include <tuple>
#include <variant>
#include <vector>
/// Metrics and scalar fields as functions of position.
export module camber.fields;
import camber.core;
import camber.metric;

/// Analytic metric fields with sizes in model units. Defaults are those of the Unstructured Grid Adaptation Working
/// Group (UGAWG: github.com/UGAWG/adapt-benchmarks). In 2D, `linear` uses the y axis in place of z, and polar fields
/// have no z.
export namespace camber {

/// UGAWG `linear`: small sizes near the plane z = position. Sizes along the axes: h_x = h_y = size, h_z = min_size + 2
/// (size − min_size) |z − position|.
struct LinearField {
    double min_size = 0.001, size = 0.1, position = 0.5;
    double scale = 1;  ///< factor for all sizes

    [[nodiscard]] static constexpr auto options() {
        using S = LinearField;
        return std::tuple(
            option("min_size", &S::min_size, "size normal to the plane, on the plane").unit("model units").above(0),
            option("size", &S::size, "size along the plane, and normal to it at a distance of 1/2")
                .unit("model units")
                .above(0),
            option("position", &S::position, "z (2D: y) of the plane").unit("model units"),
            option("scale", &S::scale, "factor of all sizes").above(0));
    }
    friend bool operator==(const LinearField&, const LinearField&) = default;
};

/// UGAWG `polar-1`: a layer on a cylinder about the z axis. Sizes: h_t = h_z = size, h_r = min_size + 2 (size −
/// min_size) |r − radius|, in tangential (t), axial (z) and radial (r) direction; r: distance from the axis.
struct PolarOneField {
    double min_size = 0.001, size = 0.1, radius = 0.5;
    double scale = 1;  ///< factor for all sizes

    [[nodiscard]] static constexpr auto options() {
        using S = PolarOneField;
        return std::tuple(
            option("min_size", &S::min_size, "size along the radius, in the layer").unit("model units").above(0),
            option("size", &S::size, "size along the layer").unit("model units").above(0),
            option("radius", &S::radius, "radius of the layer").unit("model units").above(0),
            option("scale", &S::scale, "factor of all sizes").above(0));
    }
    friend bool operator==(const PolarOneField&, const PolarOneField&) = default;
};

/// UGAWG `polar-2`: as polar-1, but h_t = size d + tangential_size (1 − d) with d = min(|r − radius|/layer_width, 1),
/// so that sizes in the layer resolve the curvature.
struct PolarTwoField {
    double min_size = 0.001, tangential_size = 0.025, size = 0.1, radius = 0.5, layer_width = 0.1;
    double scale = 1;  ///< factor for all sizes

    [[nodiscard]] static constexpr auto options() {
        using S = PolarTwoField;
        return std::tuple(
            option("min_size", &S::min_size, "size along the radius, in the layer").unit("model units").above(0),
            option("tangential_size", &S::tangential_size, "size around the circle, in the layer")
                .unit("model units")
                .above(0),
            option("size", &S::size, "size along z, and around the circle away from the layer")
                .unit("model units")
                .above(0),
            option("radius", &S::radius, "radius of the layer").unit("model units").above(0),
            option("layer_width", &S::layer_width, "distance from which the size around the circle is `size`")
                .unit("model units")
                .above(0),
            option("scale", &S::scale, "factor of all sizes").above(0));
    }
    friend bool operator==(const PolarTwoField&, const PolarTwoField&) = default;
};

/// Metric for a solution tanh(s/width), where s is the distance from a plane. The size normal to the plane is h_n with
/// log h_n = log min_size + tanh²(s/width) (log size − log min_size). Along the plane it is `size`.
template <int D>
struct PlanarShock {
    Vec<D> point{}, normal{};  ///< a point of the plane; its normal, of any length
    double min_size = 0.01, size = 0.1, width = 0.1;
    friend bool operator==(const PlanarShock&, const PlanarShock&) = default;
};

/// Metric for a solution tanh(s/width) with s = |x − centre| − radius: a shock on a sphere (2D: circle). Sizes are as
/// in `PlanarShock`, normal to and along the sphere.
template <int D>
struct SphericalShock {
    Vec<D> centre{};
    double radius = 0.5;
    double min_size = 0.01, size = 0.1, width = 0.1;
    friend bool operator==(const SphericalShock&, const SphericalShock&) = default;
};

/// Metric with size `min_size` along the vector (cos a, sin a, 0) and `size` perpendicular to it, where a = 2π
/// x/period. The metric M does not commute with ∂M/∂x, so this field tests the derivative of the matrix exponential.
struct RotatingField {
    double min_size = 0.01, size = 0.1, period = 1;

    [[nodiscard]] static constexpr auto options() {
        using S = RotatingField;
        return std::tuple(
            option("min_size", &S::min_size, "size along the rotating axis").unit("model units").above(0),
            option("size", &S::size, "size normal to the rotating axis").unit("model units").above(0),
            option("period", &S::period, "distance along x in which the axes turn once").unit("model units").above(0));
    }
    friend bool operator==(const RotatingField&, const RotatingField&) = default;
};

template <int D>
using AnalyticField =
    std::variant<LinearField, PolarOneField, PolarTwoField, PlanarShock<D>, SphericalShock<D>, RotatingField>;

/// Returns log M for the metric M at x. On the polar axis or in the centre of a shock, the x direction is the radial
/// direction.
template <int D>
[[nodiscard]] LogMetric<D> evaluate(const AnalyticField<D>& field, const Vec<D>& x);

/// Returns log M for the metric M at each point. Errors: usage (size, width, period or scale not positive, normal
/// zero), stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> log_metrics_of(const AnalyticField<D>& field,
                                                           std::span<const Vec<D>> points, const Execution& execution);

// Expressions in muParser's notation. Variables are the coordinates x, y and (3D) z. Supported: numbers, + − * / ^,
// comparisons, && and ||, c ? a : b, pi, and functions such as sqrt, exp, log (natural), sin, tanh, atan2, abs, min,
// max.

/// Expression of a size that is equal in all directions (model units).
struct SizeExpression {
    std::string size;
    friend bool operator==(const SizeExpression&, const SizeExpression&) = default;
};
struct SizesExpression {
    std::vector<std::string> sizes;
    friend bool operator==(const SizesExpression&, const SizesExpression&) = default;
};
/// Expressions of the entries of the metric tensor M (1/length²): its lower triangle by rows, xx, xy, yy (3D also xz,
/// yz, zz).
struct TensorExpression {
    std::vector<std::string> tensor;
    friend bool operator==(const TensorExpression&, const TensorExpression&) = default;
};
using MetricExpression = std::variant<SizeExpression, SizesExpression, TensorExpression>;

/// Returns log M for the metric M at each point. Errors, all of kind usage except stopped:
/// - a wrong number of expressions;
/// - a syntax error, with expression and position;
/// - a value that is not finite, a size that is not positive, or a tensor that is not positive definite, with vertex
///   and coordinates.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> log_metrics_of(const MetricExpression& expression,
                                                           std::span<const Vec<D>> points, const Execution& execution);

// Scalar expressions, in the same notation.

template <int D>
class ScalarExpression {
  public:
    /// Parses an expression. Errors: usage (syntax error, with expression and position).
    [[nodiscard]] static Outcome<ScalarExpression> parsed(std::string text);

    /// Returns a function that writes the value at each point, or NaN if it is undefined. Each thread needs its own
    /// function.
    [[nodiscard]] std::function<void(std::span<const Vec<D>>, std::span<double>)> evaluator() const;

    [[nodiscard]] const std::string& text() const { return text_; }

  private:
    explicit ScalarExpression(std::string text);
    std::string text_;
};

[[nodiscard]] std::string quoted_expression(const std::string& text);

}  // namespace camber
