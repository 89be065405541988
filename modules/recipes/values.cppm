module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <variant>
#include <vector>
export module camber.recipes:values;
import camber.core;
import camber.metric;
import camber.edge_optimisation;
import camber.transfer;
import camber.solution_metric;
import camber.validity;
import camber.io;
import camber.shapes;
import camber.fields;
import camber.surface;
import camber.cad;
import camber.operation;
import camber.adapt;
import camber.curving;
import camber.repair;
import camber.stages;
import camber.distributed;

/// Values of a config with descriptions of their options; some are options of other modules.
export namespace camber::config {

enum class ResultOfCycles : std::uint8_t { automatic, best, last };
[[nodiscard]] constexpr auto words(ResultOfCycles) {
    return words_of(Word{ResultOfCycles::automatic, "auto"}, Word{ResultOfCycles::best, "best"},
                    Word{ResultOfCycles::last, "last"});
}

/// Cycles of the pipeline's stages, each on the mesh of the previous cycle, with an optional solver after each.
struct Adaptation {
    int cycles = 0;  ///< 0: the stages run once
    std::vector<double> complexity = {};
    std::vector<std::string> solve = {};
    double timeout = 0;
    std::string folder = {};
    std::string mesh = "mesh.meshb", solution = "solution.sol";
    std::string exact = {};
    double convergence_tolerance = 0.1;
    ResultOfCycles result = ResultOfCycles::automatic;

    [[nodiscard]] bool is_requested() const { return cycles > 0; }

    [[nodiscard]] static constexpr auto options() {
        using S = Adaptation;
        return std::tuple(
            option("cycles", &S::cycles,
                   "maximum number of cycles; each cycle runs the stages on the mesh of the previous one. 0: the "
                   "stages run once, and all other options here are ignored")
                .at_least(0)
                .at_most(1000),
            option("complexity", &S::complexity,
                   "complexity of the metric by cycle; the last value is for all later cycles. Empty: as the metric "
                   "defines")
                .above(0)
                .count(0, 1000),
            option("solve", &S::solve,
                   "command and its arguments, run without a shell, for the solution on the first mesh and on each new "
                   "one. Placeholders: {mesh}, the file to read; {solution}, the file to write; {guess}, the previous "
                   "solution on the mesh; {cycle}, the cycle's number; {folder}, its folder. Empty: none. camber run "
                   "requires --allow-commands")
                .count(0, 1000),
            option("timeout", &S::timeout, "time limit of the command; 0: none").unit("s").at_least(0),
            option("folder", &S::folder,
                   "folder of the cycles, with one subfolder for each. Empty: if there is a command, next to the "
                   "output's mesh, with its name and .cycles; otherwise nothing is stored"),
            option("mesh", &S::mesh, "name of a cycle's mesh file; its extension selects the format"),
            option("solution", &S::solution,
                   "name of the file that the command writes: rows at the mesh's vertices or nodes, in its file's "
                   "order, or a mesh file with fields at its nodes"),
            option("exact", &S::exact,
                   "exact solution as an expression of x, y and z, for the errors of each cycle; empty: not known"),
            option("convergence_tolerance", &S::convergence_tolerance,
                   "condition to end: the minimum error of the last complexity has fallen by no more than this share "
                   "over two cycles. Without an error: in one cycle, the share of unit edges in the metric of the "
                   "mesh's own solution has risen by no more than a fifth of this. 0: all cycles are run")
                .at_least(0)
                .at_most(1),
            option("result", &S::result,
                   "best: the mesh with the smallest error among those of the last complexity; last: the mesh of the "
                   "last cycle; auto: last if the solver's command has {cycle}, with which each cycle may solve "
                   "another problem, otherwise best"));
    }
    friend bool operator==(const Adaptation&, const Adaptation&) = default;
};

struct FilePath {
    std::string path;
    bool is_of_cycle = false;  ///< true if an earlier cycle of the same run wrote the file
    friend bool operator==(const FilePath&, const FilePath&) = default;
};

/// Prefix of names of values in the caller's memory, which replace files.
inline constexpr std::string_view in_memory = "memory:";
[[nodiscard]] inline bool is_in_memory(std::string_view name) { return name.starts_with(in_memory); }

struct NaturalMetric {
    friend bool operator==(const NaturalMetric&, const NaturalMetric&) = default;
};
struct ConstantMetric {
    std::vector<double> sizes;
    std::vector<double> tensor;

    [[nodiscard]] static constexpr auto options() {
        using S = ConstantMetric;
        return std::tuple(
            option("sizes", &S::sizes, "one edge length, or one along each axis; empty if there is a tensor")
                .unit("model units")
                .above(0)
                .count(0, 3),
            option("tensor", &S::tensor,
                   "lower triangle by rows: xx, xy, yy (2D) or xx, xy, yy, xz, yz, zz; empty if there are sizes")
                .unit("1 / length²")
                .count(0, 6));
    }
    friend bool operator==(const ConstantMetric&, const ConstantMetric&) = default;
};
/// `SurfaceMetricOptions` with numbers for all values.
struct SurfaceMetric {
    double tangent_size = SurfaceMetricOptions{}.tangent_size, normal_size = SurfaceMetricOptions{}.normal_size;
    double volume_size = 0;

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
            option("normal", &S::normal, "vector perpendicular to the plane, of any length").count(2, 3).required(),
            option("min_size", &S::min_size, "size along the normal, at the plane").unit("model units").above(0),
            option("size", &S::size, "size along the plane, and everywhere away from it").unit("model units").above(0),
            option("width", &S::width, "width of the jump").unit("model units").above(0));
    }
    friend bool operator==(const PlanarShock&, const PlanarShock&) = default;
};
struct SphericalShock {
    std::vector<double> centre;
    double radius = 0.5, min_size = 0.01, size = 0.1, width = 0.1;

    [[nodiscard]] static constexpr auto options() {
        using S = SphericalShock;
        return std::tuple(
            option("centre", &S::centre, "centre of the sphere").unit("model units").count(2, 3).required(),
            option("radius", &S::radius, "radius of the sphere").unit("model units").above(0),
            option("min_size", &S::min_size, "size along the radius, at the sphere").unit("model units").above(0),
            option("size", &S::size, "size along the sphere, and everywhere away from it").unit("model units").above(0),
            option("width", &S::width, "width of the jump").unit("model units").above(0));
    }
    friend bool operator==(const SphericalShock&, const SphericalShock&) = default;
};
using FieldMetric = std::variant<LinearField, PolarOneField, PolarTwoField, PlanarShock, SphericalShock, RotatingField>;
/// Sizes by reference; elsewhere the size is the domain's diameter.
struct SizesMetric {
    std::vector<ReferenceSize> sizes;
    friend bool operator==(const SizesMetric&, const SizesMetric&) = default;
};
using GeometryMetric = GeometrySizes;
/// Metric for the run's solution, as `camber metric` makes it: `MetricOfSolutionOptions` with 0 for none.
struct SolutionMetric {
    std::vector<std::string> fields = {};
    int degree = 0;
    double norm = NormOptions{}.p;
    ErrorQuantity error_of = NormOptions{}.error_of;
    double complexity = 0, vertices = 0, elements = 0;
    double gradation = 2.5;
    double min_size = 0, max_size = 0, max_anisotropy = 0;
    std::vector<ReferenceSize> sizes = {};
    GeometryMetric geometry = {};
    std::vector<FilePath> intersect = {};
    ExpectedError expected = {};  ///< of the previous cycle of an adaptation; not part of a config

    [[nodiscard]] static constexpr auto options() {
        using S = SolutionMetric;
        return std::tuple(
            option("fields", &S::fields, "names of the solution's fields for the metric; empty: all").count(0, 1000),
            option("degree", &S::degree, "degree of the interpolating elements; 0: that of the solution")
                .at_least(0)
                .at_most(2),
            option("norm", &S::norm, "exponent p of the L^p norm of the error; 0: the maximum of the error")
                .at_least(0),
            option("error_of", &S::error_of, "quantity in the norm: values of the error, or its gradients"),
            option("complexity", &S::complexity,
                   "target complexity of the metric, the integral of sqrt(det M); 0: none")
                .at_least(0),
            option("vertices", &S::vertices, "approximate target number of vertices; 0: none").at_least(0),
            option("elements", &S::elements,
                   "approximate target number of elements; 0: none. Without a complexity, vertices or elements, the "
                   "target is the number of elements of the mesh")
                .at_least(0),
            option(
                "gradation", &S::gradation,
                "largest ratio of the sizes of adjacent edges; 0: no limit. Without a limit, an element at the end of "
                "a layer may span sizes of very different magnitude, and errors jump from cycle to cycle")
                .at_least(0),
            option("min_size", &S::min_size, "smallest size; 0: none").unit("model units").at_least(0),
            option("max_size", &S::max_size, "largest size; 0: the domain's diameter").unit("model units").at_least(0),
            option("max_anisotropy", &S::max_anisotropy,
                   "largest ratio of sizes; 0: only derivatives are limited, to 1e5. A larger value raises that limit")
                .at_least(0),
            option("sizes", &S::sizes,
                   "sizes by reference; they are fixed, and only the solution's part of the metric "
                   "is scaled")
                .count(0, 100000),
            option("geometry", &S::geometry, "metric of the boundary's geometry, also fixed; empty: none"),
            option("intersect", &S::intersect, "metric files of the same mesh, also fixed").count(0, 1000));
    }
    friend bool operator==(const SolutionMetric&, const SolutionMetric&) = default;
};
using Metric = std::variant<NaturalMetric, FilePath, ConstantMetric, SurfaceMetric, FieldMetric, MetricExpression,
                            SizesMetric, GeometryMetric, SolutionMetric>;

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
        return std::tuple(option("target", &S::target, "requested complexity").above(0).required());
    }
    friend bool operator==(const Complexity&, const Complexity&) = default;
};
using MetricOperation = std::variant<Intersect, Gradation, Bound, Complexity>;

using Shape = std::variant<ShellOptions<3>, ShellOptions<2>, BoxOptions<3>, BoxOptions<2>, BumpOptions>;

using MeshSource = std::variant<FilePath, Shape>;

/// Interpretation of a file with only triangles in one plane z = constant.
enum class Flat : std::uint8_t { plane, surface };
[[nodiscard]] constexpr auto words(Flat) {
    return words_of(Word{Flat::plane, "plane"}, Word{Flat::surface, "surface"});
}

struct Input {
    MeshSource source = FilePath{};
    Flat flat = Flat::plane;

    [[nodiscard]] static constexpr auto options() {
        using S = Input;
        return std::tuple(option(
            "flat", &S::flat,
            "interpretation of a file with triangles in one plane z = constant and no tetrahedra. plane: a mesh in 2D, "
            "written with its z; surface: a surface in space"));
    }
    friend bool operator==(const Input&, const Input&) = default;
};

struct SolutionInput : TransferOptions {
    std::string file = {};
    std::string expression = {};
    std::vector<std::string> fields = {};
    std::vector<double> weights = {};

    [[nodiscard]] static constexpr auto options() {
        using S = SolutionInput;
        return std::tuple_cat(
            std::tuple(
                option("file", &S::file,
                       "rows at the vertices or nodes of the input, or a file of the same mesh with fields at its "
                       "nodes; empty: the fields of the input's file, if any"),
                option("expression", &S::expression,
                       "function of x, y and z in place of a file, with the syntax of check --field, evaluated at the "
                       "nodes"),
                option("fields", &S::fields,
                       "names of the fields to use, field_1 and so on in a file of rows; empty: all")
                    .count(0, 1000),
                option("weights", &S::weights,
                       "objective solution: weights of the fields' errors, in the order of the fields and in units in "
                       "which their ranges are alike; empty: 1 each")
                    .count(0, 1000)),
            TransferOptions::options());
    }
    friend bool operator==(const SolutionInput&, const SolutionInput&) = default;
};

struct Surrogate {
    friend bool operator==(const Surrogate&, const Surrogate&) = default;
};
struct Straight {
    friend bool operator==(const Straight&, const Straight&) = default;
};
struct Plane {
    std::vector<double> point, normal;

    [[nodiscard]] static constexpr auto options() {
        using S = Plane;
        return std::tuple(
            option("point", &S::point, "any point of the plane").unit("model units").count(2, 3).required(),
            option("normal", &S::normal, "vector perpendicular to the plane, of any length").count(2, 3).required());
    }
    friend bool operator==(const Plane&, const Plane&) = default;
};
struct Sphere {
    std::vector<double> centre;
    double radius = 1;

    [[nodiscard]] static constexpr auto options() {
        using S = Sphere;
        return std::tuple(option("centre", &S::centre, "its centre; empty: the origin").unit("model units").count(0, 3),
                          option("radius", &S::radius, "its radius").unit("model units").above(0).required());
    }
    friend bool operator==(const Sphere&, const Sphere&) = default;
};
struct Cylinder {
    std::vector<double> point, axis;
    double radius = 1;

    [[nodiscard]] static constexpr auto options() {
        using S = Cylinder;
        return std::tuple(
            option("point", &S::point, "any point of its axis").unit("model units").count(3, 3).required(),
            option("axis", &S::axis, "direction of its axis, of any length").count(3, 3).required(),
            option("radius", &S::radius, "its radius").unit("model units").above(0).required());
    }
    friend bool operator==(const Cylinder&, const Cylinder&) = default;
};
struct Torus {
    std::vector<double> centre, axis;
    double major_radius = camber::Torus{}.major_radius, minor_radius = camber::Torus{}.minor_radius;

    [[nodiscard]] static constexpr auto options() {
        using S = Torus;
        return std::tuple(
            option("centre", &S::centre, "its centre").unit("model units").count(3, 3).required(),
            option("axis", &S::axis, "direction of its axis of rotation, of any length").count(3, 3).required(),
            option("major_radius", &S::major_radius, "distance from the centre to the middle of the tube")
                .unit("model units")
                .above(0)
                .required(),
            option("minor_radius", &S::minor_radius, "radius of the tube").unit("model units").above(0).required());
    }
    friend bool operator==(const Torus&, const Torus&) = default;
};
using Surface = std::variant<Plane, Sphere, Cylinder, Torus>;
struct AnalyticSurface {
    std::vector<Reference> references;
    Surface surface;

    [[nodiscard]] static constexpr auto options() {
        using S = AnalyticSurface;
        return std::tuple(option("references", &S::references, "references of the boundary facets on this surface")
                              .count(1, 100000)
                              .required());
    }
    friend bool operator==(const AnalyticSurface&, const AnalyticSurface&) = default;
};
struct Analytic {
    std::vector<AnalyticSurface> surfaces;
    friend bool operator==(const Analytic&, const Analytic&) = default;
};
struct Cad {
    FilePath file;
    CadUnit unit = CadOptions{}.unit;
    std::vector<Reference> references = {};
    std::vector<AnalyticSurface> analytic = {};
    CadVertices vertices = CadVertices::keep;
    double timeout = 0, memory = 0;

    [[nodiscard]] static constexpr auto options() {
        using S = Cad;
        return std::tuple(
            option("file", &S::file, "file of the model: .step, .stp, .iges, .igs or .brep").required(),
            option_of(&CadOptions::unit).as(&S::unit),
            option("references", &S::references,
                   "references of the boundary facets on the model; the others have the surrogate as geometry. Empty: "
                   "all except those of \"analytic\"")
                .count(0, 100000),
            option("analytic", &S::analytic, "analytic surfaces next to the model, as in \"analytic\""),
            option("vertices", &S::vertices,
                   "vertices that are off the model. keep: they are not moved; move: they are moved onto it, as far as "
                   "elements allow"),
            option("timeout", &S::timeout,
                   "time limit for reading the model; 0: 10, plus 1 for each megabyte of its file")
                .unit("s")
                .at_least(0),
            option("memory", &S::memory, "memory limit for reading the model; 0: 1000, plus 50 times its file")
                .unit("MB")
                .at_least(0));
    }
    friend bool operator==(const Cad&, const Cad&) = default;
};
using Geometry = std::variant<Surrogate, Straight, FilePath, Analytic, Cad>;

/// `FeatureOptions` for either dimension, and the policy for required boundary entities.
struct Features {
    double ridge_angle = FeatureOptions<3>{}.ridge_angle_degrees;
    RequiredBoundary required_boundary = RequiredBoundary::keep;

    [[nodiscard]] static constexpr auto options() {
        return std::tuple(
            option_of(&FeatureOptions<3>::ridge_angle_degrees).as(&Features::ridge_angle),
            option("required_boundary", &Features::required_boundary,
                   "nodes of required edges and facets on the boundary. keep: they are fixed; geometry: they are "
                   "placed on the geometry like all others. Required vertices, and required nodes in the volume, are "
                   "always fixed"));
    }
    friend bool operator==(const Features&, const Features&) = default;
};

struct Elevate {
    friend bool operator==(const Elevate&, const Elevate&) = default;
};
struct Curve : ProposeOptions, CurveByBlocks {
    [[nodiscard]] static constexpr auto options() {
        return std::tuple_cat(ProposeOptions::options(), CurveByBlocks::options());
    }
    friend bool operator==(const Curve&, const Curve&) = default;
};
struct Validate {
    JacobianBound min_scaled_jacobian = {};

    [[nodiscard]] static constexpr auto options() { return std::tuple(bound_option<Validate>()); }
    friend bool operator==(const Validate&, const Validate&) = default;
};
using Relax = RepairOptions;
struct Commit {
    friend bool operator==(const Commit&, const Commit&) = default;
};
struct Reinsert {
    Curve curve;
    Relax relax;
    int max_sweeps = ReinsertionOptions{}.max_sweeps;

    [[nodiscard]] static constexpr auto options() {
        using S = Reinsert;
        return std::tuple(
            option("curve", &S::curve, "options of the stage curve, for the edges of a cavity"),
            option("relax", &S::relax, "options of the stage relax, for the invalid elements of a cavity"),
            option_of(&ReinsertionOptions::max_sweeps).as(&S::max_sweeps));
    }
    friend bool operator==(const Reinsert&, const Reinsert&) = default;
};
using Collapse = CollapseOptions;
using Split = SplitOptions;
using Swap = SwapOptions;
using Smooth = SmoothOptions;
using Mend = MendOptions;
/// Objective for nodes of inner edges in passes on a quadratic mesh.
enum class RemeshObjective : std::uint8_t {
    automatic,  ///< that of an earlier stage `curve`, else accuracy
    accuracy,
    energy,
    length,
};
[[nodiscard]] constexpr auto words(RemeshObjective) {
    return words_of(Word{RemeshObjective::automatic, "auto"}, Word{RemeshObjective::accuracy, "accuracy"},
                    Word{RemeshObjective::energy, "energy"}, Word{RemeshObjective::length, "length"});
}
struct Remesh : ToMetricOptions, RemeshBlocksOptions {
    RemeshObjective objective = RemeshObjective::automatic;

    [[nodiscard]] static constexpr auto options() {
        using S = Remesh;
        return std::tuple_cat(
            std::tuple(option("objective", &S::objective,
                              "degree 2: objective for nodes of inner edges, as in the stage curve: accuracy, energy "
                              "or length; auto: that of an earlier stage curve, else accuracy")),
            RemeshBlocksOptions::options(), ToMetricOptions::options());
    }
    friend bool operator==(const Remesh&, const Remesh&) = default;
};
using Stage =
    std::variant<Elevate, Curve, Validate, Relax, Commit, Reinsert, Collapse, Split, Swap, Smooth, Mend, Remesh>;

struct Output {
    std::string mesh, report, vtu, metric, solution, plots, page;
    std::string format;
    VtuCells vtu_cells = VtuOptions{}.cells;
    DistanceDirections distances = DistanceDirections::boundary;
    int partition = 0;

    [[nodiscard]] static constexpr auto options() {
        using S = Output;
        return std::tuple(
            option("mesh", &S::mesh, "file of the mesh; its extension selects the format. Empty: none"),
            option("format", &S::format,
                   "name of the mesh's format. Empty: by the extension; if the input has the same extension, the "
                   "format of the input, so that text stays text"),
            option("report", &S::report, "file of the run's report, as JSON; empty: none"),
            option("vtu", &S::vtu,
                   "VTU file for ParaView: the mesh with the run's fields (Jacobians, curvatures, length reductions, "
                   "metric …); empty: none"),
            option_of(&VtuOptions::cells).as(&S::vtu_cells),
            option(
                "metric", &S::metric,
                "file of the metric after its operations, at the vertices: a solution (.sol, .solb), or with the mesh "
                "in a format that has fields (.vtu); empty: none"),
            option("solution", &S::solution,
                   "file of the solution's fields on the new mesh: rows in the order of its file (.sol, .solb), or "
                   "fields with the mesh (.vtu, for example). Empty: in the mesh's file, if its format has fields"),
            option("plots", &S::plots, "folder for histograms of the run as SVG files; empty: none"),
            option("page", &S::page, "page for a browser (.html) with the mesh and the report of the run; empty: none"),
            option(
                "distances", &S::distances,
                "distances in the report. boundary: the largest from the curved boundary to the geometry; both: also "
                "from the geometry to the boundary, largest and mean of each surface and curve"),
            option("partition", &S::partition,
                   "number of parts of the mesh for a solver; 0: one file. The parts are files with numbers in their "
                   "names, next to the mesh file or to a .pvtu that names them")
                .at_least(0)
                .at_most(1 << 20)
                .unit("parts"));
    }
    friend bool operator==(const Output&, const Output&) = default;
};

/// Bound on the boundary's distance from its geometry during passes, if the metric has none.
enum class GeometryBound : std::uint8_t { by_default, none };
[[nodiscard]] constexpr auto words(GeometryBound) {
    return words_of(Word{GeometryBound::by_default, "default"}, Word{GeometryBound::none, "none"});
}

struct Pipeline {
    Input input;
    SolutionInput solution;
    Metric metric;
    std::string metric_mesh = {};
    std::vector<MetricOperation> metric_operations;
    Geometry geometry;
    Features features;
    BoundaryTolerance geometry_tolerance = {};
    GeometryBound geometry_bound = GeometryBound::by_default;
    std::vector<Stage> stages{Elevate{}, Curve{}, Validate{}, Relax{}, Commit{}};
    Adaptation adapt = {};
    int threads = 0;
    Output output;

    [[nodiscard]] static constexpr auto options() {
        using S = Pipeline;
        return std::tuple(
            option("input", &S::input, "mesh file, or shape to generate").required(),
            option("solution", &S::solution, "fields on the input mesh, which are transferred to the result"),
            option("metric", &S::metric, "field of sizes and directions for the edges"),
            option("metric_mesh", &S::metric_mesh,
                   "mesh whose vertices (or nodes, if it is curved) the rows of the metric file belong to; empty: the "
                   "input"),
            option("metric_operations", &S::metric_operations, "operations on the metric, applied in this order")
                .count(0, 1000),
            option("geometry", &S::geometry, "geometry onto which boundary nodes are placed"),
            option("features", &S::features, "ridges of the boundary"),
            option("geometry_tolerance", &S::geometry_tolerance,
                   "limits for the distance of boundary nodes and vertices from the geometry in the result; beyond "
                   "them the exit code is 1"),
            option("geometry_bound", &S::geometry_bound,
                   "limit of the distance between the boundary and the geometry while passes change the mesh, if the "
                   "metric has no chord_error. default: a hundredth of the size of each surface, and along an edge a "
                   "turn of 30 degrees (degree 2: 90); none: no limit"),
            option("stages", &S::stages, "stages to run, in this order").count(0, 1000),
            option("adapt", &S::adapt, "cycles of the stages, with a solver between them"),
            option("threads", &S::threads, "number of threads; 0: all of the machine").at_least(0).at_most(4096),
            option("output", &S::output, "files to write"));
    }
    friend bool operator==(const Pipeline&, const Pipeline&) = default;
};

}  // namespace camber::config
