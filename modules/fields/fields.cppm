module;
#include <functional>
#include <span>
#include <string>
#include <tuple>
#include <variant>
#include <vector>
/// Fields as functions of position: metrics by name and by expressions of the coordinates, and scalar expressions.
export module camber.fields;
import camber.core;
import camber.metric;

/// Analytic metric fields: pure functions of position, with sizes in model units. Those of the Unstructured Grid
/// Adaptation Working Group (UGAWG: github.com/UGAWG/adapt-benchmarks) have its values as defaults; in 2D the last axis
/// plays the part of z in `linear`, and the polar ones lose z.
export namespace camber {

/// UGAWG `linear`: thin across the plane z = position. h_x = h_y = size, h_z = min_size + 2 (size − min_size)
/// |z − position|.
struct LinearField {
    double min_size = 0.001, size = 0.1, position = 0.5;
    double scale = 1;  ///< all sizes times this

    [[nodiscard]] static constexpr auto options() {
        using S = LinearField;
        return std::tuple(
            option("min_size", &S::min_size, "size across, at the plane").unit("model units").above(0),
            option("size", &S::size, "size along, and across at a distance of 1/2").unit("model units").above(0),
            option("position", &S::position, "z (2D: y) of the plane").unit("model units"),
            option("scale", &S::scale, "all sizes times this").above(0));
    }
    friend bool operator==(const LinearField&, const LinearField&) = default;
};

/// UGAWG `polar-1`: a curved layer on the cylinder of this radius about the z axis. h_t = h_z = size,
/// h_r = min_size + 2 (size − min_size) |r − radius|.
struct PolarOneField {
    double min_size = 0.001, size = 0.1, radius = 0.5;
    double scale = 1;  ///< all sizes times this

    [[nodiscard]] static constexpr auto options() {
        using S = PolarOneField;
        return std::tuple(
            option("min_size", &S::min_size, "size along the radius, in the layer").unit("model units").above(0),
            option("size", &S::size, "size along the layer").unit("model units").above(0),
            option("radius", &S::radius, "of the layer").unit("model units").above(0),
            option("scale", &S::scale, "all sizes times this").above(0));
    }
    friend bool operator==(const PolarOneField&, const PolarOneField&) = default;
};

/// UGAWG `polar-2`: as polar-1, with shorter edges along the circle near the layer: h_t = size d + tangential_size
/// (1 − d), d = min(|r − radius|/layer_width, 1). Curvature then asks for no more than h_t.
struct PolarTwoField {
    double min_size = 0.001, tangential_size = 0.025, size = 0.1, radius = 0.5, layer_width = 0.1;
    double scale = 1;  ///< all sizes times this

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
            option("radius", &S::radius, "of the layer").unit("model units").above(0),
            option("layer_width", &S::layer_width, "distance from which the size around the circle is `size`")
                .unit("model units")
                .above(0),
            option("scale", &S::scale, "all sizes times this").above(0));
    }
    friend bool operator==(const PolarTwoField&, const PolarTwoField&) = default;
};

/// Thin across a plane, where a solution tanh(s/width) of the distance s jumps: log of the size along the normal goes
/// from log size to log min_size with the solution's slope 1 − tanh²(s/width); `size` along the plane.
template <int D>
struct PlanarShock {
    Vec<D> point{}, normal{};  ///< of the plane; the normal of any length
    double min_size = 0.01, size = 0.1, width = 0.1;
    friend bool operator==(const PlanarShock&, const PlanarShock&) = default;
};

/// The same across a sphere (2D: a circle): s = |x − centre| − radius.
template <int D>
struct SphericalShock {
    Vec<D> centre{};
    double radius = 0.5;
    double min_size = 0.01, size = 0.1, width = 0.1;
    friend bool operator==(const SphericalShock&, const SphericalShock&) = default;
};

/// Constant sizes whose axes turn with x: min_size along (cos a, sin a, 0), size across it, a = 2π x/period. The
/// metric's derivative commutes with it nowhere, which is the case that a wrong D exp gets wrong.
struct RotatingField {
    double min_size = 0.01, size = 0.1, period = 1;

    [[nodiscard]] static constexpr auto options() {
        using S = RotatingField;
        return std::tuple(option("min_size", &S::min_size, "size along the turning axis").unit("model units").above(0),
                          option("size", &S::size, "size across it").unit("model units").above(0),
                          option("period", &S::period, "of a whole turn").unit("model units").above(0));
    }
    friend bool operator==(const RotatingField&, const RotatingField&) = default;
};

/// Any of the fields above.
template <int D>
using AnalyticField =
    std::variant<LinearField, PolarOneField, PolarTwoField, PlanarShock<D>, SphericalShock<D>, RotatingField>;

/// log M at x. On the axis of a polar field, or at a shock's centre, where no direction is the radius, that of x is.
template <int D>
[[nodiscard]] LogMetric<D> evaluate(const AnalyticField<D>& field, const Vec<D>& x);

/// log M at points. Errors (usage): a size, width, period or scale that is not positive, a zero normal; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> log_metrics_of(const AnalyticField<D>& field,
                                                           std::span<const Vec<D>> points, const Execution& execution);

// Metric fields written as expressions of the coordinates x, y and (3D) z, in muparser's notation: numbers,
// + − * / ^, comparisons, && and ||, c ? a : b, pi, and functions as sqrt, exp, log (natural), sin, tanh, atan2, abs,
// min, max.

/// One size everywhere in all directions (model units).
struct SizeExpression {
    std::string size;
    friend bool operator==(const SizeExpression&, const SizeExpression&) = default;
};
/// A size along each axis.
struct SizesExpression {
    std::vector<std::string> sizes;
    friend bool operator==(const SizesExpression&, const SizesExpression&) = default;
};
/// The entries of M, lower triangle by rows: xx, xy, yy (xz, yz, zz); 1/length².
struct TensorExpression {
    std::vector<std::string> tensor;
    friend bool operator==(const TensorExpression&, const TensorExpression&) = default;
};
/// A metric by one size, by a size along each axis, or by its entries.
using MetricExpression = std::variant<SizeExpression, SizesExpression, TensorExpression>;

/// log M at points. Errors (usage): another number of expressions than the dimension asks for; one that cannot be read,
/// with the expression and the position in it; a value that is not finite, a size that is not positive, a tensor that
/// is not positive definite, with the vertex and its coordinates; stopped.
template <int D>
[[nodiscard]] Outcome<Column<LogMetric<D>>> log_metrics_of(const MetricExpression& expression,
                                                           std::span<const Vec<D>> points, const Execution& execution);

// Scalar fields written as expressions of the coordinates x, y and (3D) z, in muparser's notation: numbers,
// + − * / ^, comparisons, && and ||, c ? a : b, pi, and functions as sqrt, exp, log (natural), sin, tanh, atan2, abs,
// min, max.

/// An expression that can be read.
template <int D>
class ScalarExpression {
  public:
    /// Errors (usage): one that cannot be read, with the expression and the position in it.
    [[nodiscard]] static Outcome<ScalarExpression> parsed(std::string text);

    /// Its values at points, written into a span of the same size; NaN where there is none. With a state: each thread
    /// takes one of its own.
    [[nodiscard]] std::function<void(std::span<const Vec<D>>, std::span<double>)> evaluator() const;

    [[nodiscard]] const std::string& text() const { return text_; }

  private:
    explicit ScalarExpression(std::string text);
    std::string text_;
};

/// The expression "…", no longer than a message has place for.
[[nodiscard]] std::string quoted_expression(const std::string& text);

}  // namespace camber
