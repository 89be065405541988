module;
#include <string>
#include <tuple>
#include <variant>
#include <vector>
export module camber.config:metric_values;
import camber.core;
import camber.fields;
import camber.metric;
import camber.recipes;
import camber.solution_metric;
import :paths;

/// What a config says of the metric, as plain values.
export namespace camber::config {

struct NaturalMetric {
    friend bool operator==(const NaturalMetric&, const NaturalMetric&) = default;
};
struct ConstantMetric {
    std::vector<double> sizes;   ///< 1 or D edge lengths, along the axes
    std::vector<double> tensor;  ///< or D (D + 1)/2 entries, lower triangle by rows

    [[nodiscard]] static constexpr auto options() {
        using S = ConstantMetric;
        return std::tuple(
            option("sizes", &S::sizes, "one edge length, or one along each axis; empty when a tensor is given")
                .unit("model units")
                .above(0)
                .count(0, 3),
            option("tensor", &S::tensor,
                   "lower triangle by rows: xx, xy, yy (2D) or xx, xy, yy, xz, yz, zz; empty when sizes are given")
                .unit("1 / length²")
                .count(0, 6));
    }
    friend bool operator==(const ConstantMetric&, const ConstantMetric&) = default;
};
/// `SurfaceMetricOptions` with a number where those have one or none.
struct SurfaceMetric {
    double tangent_size = SurfaceMetricOptions{}.tangent_size, normal_size = SurfaceMetricOptions{}.normal_size;
    double volume_size = 0;  ///< 0: as tangent_size

    [[nodiscard]] static constexpr auto options() {
        using S = SurfaceMetric;
        return std::tuple(option_of(&SurfaceMetricOptions::tangent_size).as(&S::tangent_size),
                          option_of(&SurfaceMetricOptions::normal_size).as(&S::normal_size),
                          option("volume_size", &S::volume_size, "size in the volume; 0: tangent_size")
                              .unit("model units")
                              .at_least(0));
    }
    friend bool operator==(const SurfaceMetric&, const SurfaceMetric&) = default;
};
struct PlanarShock {
    std::vector<double> point, normal;
    double min_size = 0.01, size = 0.1, width = 0.1;

    [[nodiscard]] static constexpr auto options() {
        using S = PlanarShock;
        return std::tuple(
            option("point", &S::point, "any point of the plane").unit("model units").count(2, 3).required(),
            option("normal", &S::normal, "perpendicular to it, of any length").count(2, 3).required(),
            option("min_size", &S::min_size, "size along the normal, at the plane").unit("model units").above(0),
            option("size", &S::size, "size along the plane, and everywhere away from it").unit("model units").above(0),
            option("width", &S::width, "of the jump").unit("model units").above(0));
    }
    friend bool operator==(const PlanarShock&, const PlanarShock&) = default;
};
struct SphericalShock {
    std::vector<double> centre;
    double radius = 0.5, min_size = 0.01, size = 0.1, width = 0.1;

    [[nodiscard]] static constexpr auto options() {
        using S = SphericalShock;
        return std::tuple(
            option("centre", &S::centre, "of the sphere").unit("model units").count(2, 3).required(),
            option("radius", &S::radius, "of the sphere").unit("model units").above(0),
            option("min_size", &S::min_size, "size along the radius, at the sphere").unit("model units").above(0),
            option("size", &S::size, "size along the sphere, and everywhere away from it").unit("model units").above(0),
            option("width", &S::width, "of the jump").unit("model units").above(0));
    }
    friend bool operator==(const SphericalShock&, const SphericalShock&) = default;
};
using FieldMetric = std::variant<LinearField, PolarOneField, PolarTwoField, PlanarShock, SphericalShock, RotatingField>;
/// Sizes at what has a reference; elsewhere the domain's diameter.
struct SizesMetric {
    std::vector<ReferenceSize> sizes;
    friend bool operator==(const SizesMetric&, const SizesMetric&) = default;
};
using GeometryMetric = GeometrySizes;
/// The metric that the run's solution asks for, as the verb `metric` makes it: `MetricOfSolutionOptions` with 0 for
/// none.
struct SolutionMetric {
    std::vector<std::string> fields = {};  ///< names; empty: all
    int degree = 0;                        ///< of the elements; 0: the solution's
    double norm = NormOptions{}.p;
    ErrorOf error_of = NormOptions{}.error_of;
    double complexity = 0, vertices = 0, elements = 0;  ///< one of them at most; none: as many elements as the mesh has
    double gradation = 2.5;
    double min_size = 0, max_size = 0, max_anisotropy = 0;
    std::vector<ReferenceSize> sizes = {};
    GeometryMetric geometry = {};
    std::vector<FilePath> intersect = {};
    ExpectedError expected = {};  ///< of an adaptation's cycle before; not part of a config

    [[nodiscard]] static constexpr auto options() {
        using S = SolutionMetric;
        return std::tuple(
            option("fields", &S::fields, "names of the solution's fields that it is for; empty: all").count(0, 1000),
            option("degree", &S::degree, "degree of the elements that are to interpolate; 0: the solution's")
                .at_least(0)
                .at_most(2),
            option("norm", &S::norm, "exponent p of the L^p norm of the error; 0: the largest error anywhere")
                .at_least(0),
            option("error_of", &S::error_of, "what the norm is of: the error's values, or its gradients"),
            option("complexity", &S::complexity, "complexity of the metric, the integral of sqrt(det M); 0: not asked")
                .at_least(0),
            option("vertices", &S::vertices, "or about so many vertices of the mesh; 0: not asked").at_least(0),
            option("elements", &S::elements,
                   "or about so many elements; 0: not asked. Where none of the three is, as many elements as "
                   "the mesh has")
                .at_least(0),
            option(
                "gradation", &S::gradation,
                "largest ratio of the sizes of adjacent edges; 0: not limited. Without a limit an element at the end "
                "of a layer may reach from its sizes to those many times larger, and errors jump from cycle to cycle")
                .at_least(0),
            option("min_size", &S::min_size, "smallest size; 0: none").unit("model units").at_least(0),
            option("max_size", &S::max_size, "largest size; 0: the domain's diameter").unit("model units").at_least(0),
            option("max_anisotropy", &S::max_anisotropy,
                   "largest ratio of sizes; 0: none, but for the 1e5 that derivatives alone may ask for; a larger one "
                   "raises that")
                .at_least(0),
            option("sizes", &S::sizes, "sizes by reference; they are fixed, the solution's part is scaled beside them")
                .count(0, 100000),
            option("geometry", &S::geometry, "what the boundary's own surface asks for, fixed too; empty: nothing"),
            option("intersect", &S::intersect, "files of metrics of the same mesh, fixed too").count(0, 1000));
    }
    friend bool operator==(const SolutionMetric&, const SolutionMetric&) = default;
};
using Metric = std::variant<NaturalMetric, FilePath, ConstantMetric, SurfaceMetric, FieldMetric, MetricExpression,
                            SizesMetric, GeometryMetric, SolutionMetric>;

/// What is done to the metric, in this order, before edges follow it.
struct Intersect {
    Metric metric;
    friend bool operator==(const Intersect&, const Intersect&) = default;
};
using Gradation = GradationOptions;
/// `MetricBounds` with 0 for none, since JSON has no infinity.
struct Bound {
    double min_size = 0, max_size = 0, max_anisotropy = 0;  ///< 0: none

    [[nodiscard]] static constexpr auto options() {
        using S = Bound;
        return std::tuple(option("min_size", &S::min_size, "smallest size; 0: none").unit("model units").at_least(0),
                          option("max_size", &S::max_size, "largest size; 0: none").unit("model units").at_least(0),
                          option("max_anisotropy", &S::max_anisotropy, "largest ratio of sizes; 0: none").at_least(0));
    }
    friend bool operator==(const Bound&, const Bound&) = default;
};
struct Complexity {
    double target = 10000;

    [[nodiscard]] static constexpr auto options() {
        using S = Complexity;
        return std::tuple(option("target", &S::target, "the wanted complexity").above(0).required());
    }
    friend bool operator==(const Complexity&, const Complexity&) = default;
};
using MetricOperation = std::variant<Intersect, Gradation, Bound, Complexity>;

}  // namespace camber::config
