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
    int cycles = 0;                       ///< 0: the stages run once
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
                   "how often the stages run at most, each time on the mesh that they made before; 0: once, and "
                   "nothing else of this counts")
                .at_least(0)
                .at_most(1000),
            option("complexity", &S::complexity,
                   "the metric's complexity by cycle, the last one for all after it; empty: as the metric says")
                .above(0)
                .count(0, 1000),
            option("solve", &S::solve,
                   "a command and its arguments, run without a shell for the solution on the first mesh and on every "
                   "one that is made; in them {mesh} and {solution} are the files that it reads and is to write, "
                   "{guess} the solution before, brought to the mesh, {cycle} the cycle's number, {folder} its folder. "
                   "Empty: none. camber run takes it with --allow-commands alone")
                .count(0, 1000),
            option("timeout", &S::timeout, "how long the command may take; 0: any time").unit("s").at_least(0),
            option("folder", &S::folder,
                   "where the cycles are kept, each in a folder of its own; empty: beside the output's mesh, with its "
                   "name and .cycles, where there is a command; else nothing is kept"),
            option("mesh", &S::mesh, "the name of a cycle's mesh file, whose ending is its format"),
            option("solution", &S::solution,
                   "the name of the file that the command writes: rows at the mesh's vertices or nodes, in its file's "
                   "order, or a mesh file with fields at its nodes"),
            option("exact", &S::exact,
                   "the exact solution as an expression of x, y and z, whose errors are told by cycle; empty: not "
                   "known"),
            option("convergence_tolerance", &S::convergence_tolerance,
                   "cycles end once the least error of the last complexity has fallen by no more than this share over "
                   "two cycles; without an error, once the unit edges in the metric of the mesh's own solution rise by "
                   "no more than a fifth of it in one; 0: never before their number")
                .at_least(0)
                .at_most(1),
            option("result", &S::result,
                   "best: the mesh with the least error among those of the last complexity; last: the mesh of the last "
                   "cycle; auto: last if the solver's command has {cycle}, with which each cycle may solve another "
                   "problem, otherwise best"));
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

// ---------------------------------------------------------------- the metric

struct NaturalMetric {
    friend bool operator==(const NaturalMetric&, const NaturalMetric&) = default;
};
struct ConstantMetric {
    std::vector<double> sizes;
    std::vector<double> tensor;

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

/// Operations on the metric, applied in order before stages use it.
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

// ---------------------------------------------------------------- the input mesh

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
            "what a file's triangles are that have no tetrahedra and one z: a plane mesh in 2D, written with its z "
            "again; or a surface in space"));
    }
    friend bool operator==(const Input&, const Input&) = default;
};

// ---------------------------------------------------------------- the solution

/// Fields at the nodes of the input mesh; they are transferred to the result.
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
                       "nodes; empty: the fields of the input's own file, if any"),
                option(
                    "expression", &S::expression,
                    "in place of a file: a function of x, y and z as check --field takes it, evaluated at the nodes"),
                option("fields", &S::fields,
                       "names of those that are taken, field_1 and so on in a file of rows; empty: all")
                    .count(0, 1000),
                option("weights", &S::weights,
                       "objective solution: what each field's error counts beside the others', in units in which their "
                       "ranges are alike, in the order of the fields; empty: 1 each")
                    .count(0, 1000)),
            TransferOptions::options());
    }
    friend bool operator==(const SolutionInput&, const SolutionInput&) = default;
};

// ---------------------------------------------------------------- the geometry

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
        return std::tuple(option("point", &S::point, "any point of it").unit("model units").count(2, 3).required(),
                          option("normal", &S::normal, "perpendicular to it, of any length").count(2, 3).required());
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
            option("major_radius", &S::major_radius, "from the centre to the middle of the tube")
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
            option("file", &S::file, "the model: .step, .stp, .iges, .igs or .brep").required(),
            option_of(&CadOptions::unit).as(&S::unit),
            option("references", &S::references,
                   "references of the boundary facets that lie on the model; the rest takes the surrogate. Empty: all "
                   "but those of \"analytic\"")
                .count(0, 100000),
            option("analytic", &S::analytic, "surfaces by their equations beside it, as in \"analytic\""),
            option("vertices", &S::vertices,
                   "vertices that are off the model: keep, where they are; move, onto it, as far as elements allow"),
            option("timeout", &S::timeout,
                   "how long reading the model may take; 0: 10, and 1 for each megabyte of its file")
                .unit("s")
                .at_least(0),
            option("memory", &S::memory, "how much memory reading the model may take; 0: 1000, and 50 times its file")
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
                   "nodes of required edges and facets on the boundary: keep, where they are; geometry, onto it as all "
                   "others. In the volume they always stay, and so do required vertices"));
    }
    friend bool operator==(const Features&, const Features&) = default;
};

// ---------------------------------------------------------------- the stages

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
/// Options of the stages `curve` and `relax`, applied to cavities.
struct Reinsert {
    Curve curve;
    Relax relax;
    int max_sweeps = ReinsertionOptions{}.max_sweeps;

    [[nodiscard]] static constexpr auto options() {
        using S = Reinsert;
        return std::tuple(
            option("curve", &S::curve, "how a cavity's edges find their nodes: the options of the stage curve"),
            option("relax", &S::relax,
                   "what a cavity does about elements that are not valid: the options of the stage relax"),
            option_of(&ReinsertionOptions::max_sweeps).as(&S::max_sweeps));
    }
    friend bool operator==(const Reinsert&, const Reinsert&) = default;
};
/// Remeshing passes, and iterations of them.
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
                              "degree 2: what inner edges are curved for, as in the stage curve: accuracy, energy or "
                              "length; auto: that of a stage curve before, else accuracy")),
            RemeshBlocksOptions::options(), ToMetricOptions::options());
    }
    friend bool operator==(const Remesh&, const Remesh&) = default;
};
using Stage =
    std::variant<Elevate, Curve, Validate, Relax, Commit, Reinsert, Collapse, Split, Swap, Smooth, Mend, Remesh>;

// ---------------------------------------------------------------- the pipeline

struct Output {
    std::string mesh, report, vtu, metric, solution, plots, page;
    std::string format;
    VtuCells vtu_cells = VtuOptions{}.cells;
    DistanceDirections distances = DistanceDirections::boundary;
    int partition = 0;

    [[nodiscard]] static constexpr auto options() {
        using S = Output;
        return std::tuple(
            option("mesh", &S::mesh, "the mesh, in the format of its ending; empty: none"),
            option("format", &S::format,
                   "the mesh's format by its name, whatever its ending; empty: that of the ending, and where the input "
                   "is of a format with the same ending, that one: text stays text"),
            option("report", &S::report, "the figures of the run, as JSON; empty: none"),
            option("vtu", &S::vtu,
                   "the mesh with the run's fields (Jacobians, curvatures, length reductions, metric …) for ParaView "
                   "(.vtu), "
                   "beside the mesh; empty: none"),
            option_of(&VtuOptions::cells).as(&S::vtu_cells),
            option(
                "metric", &S::metric,
                "the metric that edges followed, after its operations, at the vertices: a solution (.sol, .solb), or "
                "on the mesh in a format that has fields (.vtu); empty: none"),
            option("solution", &S::solution,
                   "the solution's fields on the mesh that was made: rows in its file's order (.sol, .solb), or with "
                   "the mesh in a format that has fields; empty: in the mesh's own file, if its format has fields"),
            option("plots", &S::plots, "a folder for histograms of the run as SVG files; empty: none"),
            option("page", &S::page,
                   "the mesh and the figures of the run as a page for a browser (.html); empty: none"),
            option(
                "distances", &S::distances,
                "which distances the report has: boundary, the largest from the curved boundary to the geometry; both, "
                "also from the geometry to the boundary, largest and mean of each surface and curve"),
            option("partition", &S::partition,
                   "the mesh in so many parts for a solver, as files with numbers in their names beside it, or of a "
                   ".pvtu, which names them; 0: as one file")
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
            option("input", &S::input, "where the mesh comes from").required(),
            option("solution", &S::solution, "fields that are known on it, which go along"),
            option("metric", &S::metric, "the field of sizes and directions that edges follow"),
            option(
                "metric_mesh", &S::metric_mesh,
                "the mesh whose vertices or, of a curved one, nodes the metric file's rows are at; empty: the input"),
            option("metric_operations", &S::metric_operations, "what is done to the metric first, in this order")
                .count(0, 1000),
            option("geometry", &S::geometry, "the shape that boundary nodes are put onto"),
            option("features", &S::features, "ridges of the boundary"),
            option("geometry_tolerance", &S::geometry_tolerance,
                   "how far nodes and vertices of the boundary may be from the geometry in the end: beyond it the exit "
                   "code is 1"),
            option("geometry_bound", &S::geometry_bound,
                   "limit of the distance between the boundary and the geometry while passes change the mesh, where "
                   "the metric has no chord_error: default is a hundredth of the size of each surface, and along an "
                   "edge a turn of 30 degrees, with degree 2 of 90"),
            option("stages", &S::stages, "what is done, in this order").count(0, 1000),
            option("adapt", &S::adapt, "cycles of them, and the solver that is asked in between"),
            option("threads", &S::threads, "threads to use; 0: all that the machine has").at_least(0).at_most(4096),
            option("output", &S::output, "files to write"));
    }
    friend bool operator==(const Pipeline&, const Pipeline&) = default;
};

}  // namespace camber::config
