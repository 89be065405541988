module;
#include <array>
#include <cstdint>
#include <string>
#include <tuple>
#include <variant>
#include <vector>
export module camber.config:values;
export import :adaptation_values;
export import :metric_values;
export import :paths;
import camber.core;
import camber.fields;
import camber.shapes;
import camber.metric;
import camber.validity;
import camber.io;
import camber.surface;
import camber.cad;
import camber.curving;
import camber.operation;
import camber.adapt;
import camber.repair;
import camber.recipes;
import camber.solution_metric;
import camber.transfer;
import camber.distributed;

/// What a config says, as plain values, which describe their options themselves; some are options of a module.
export namespace camber::config {

// ---------------------------------------------------------------- where the mesh comes from

using Shape = std::variant<ShellOptions<3>, ShellOptions<2>, BoxOptions<3>, BoxOptions<2>, BumpOptions>;

/// A file, or a shape to generate.
using MeshSource = std::variant<FilePath, Shape>;

/// What triangles alone in one plane z = constant are taken for.
enum class Flat : std::uint8_t { plane, surface };
[[nodiscard]] constexpr auto words(Flat) {
    return words_of(Word{Flat::plane, "plane"}, Word{Flat::surface, "surface"});
}

struct Input {
    MeshSource source = FilePath{};
    Flat flat = Flat::plane;  ///< of a file

    [[nodiscard]] static constexpr auto options() {
        using S = Input;
        return std::tuple(option(
            "flat", &S::flat,
            "what a file's triangles are that have no tetrahedra and one z: a plane mesh in 2D, written with its z "
            "again; or a surface in space"));
    }
    friend bool operator==(const Input&, const Input&) = default;
};

// ---------------------------------------------------------------- what is known on it

/// Fields at the nodes of the input's mesh: they go along to the mesh that is made.
struct GivenSolution : TransferOptions {
    std::string file = {};                 ///< empty: the fields of the input's own file
    std::string expression = {};           ///< in place of a file; empty: none
    std::vector<std::string> fields = {};  ///< names; empty: all
    std::vector<double> weights = {};      ///< of their errors, one each; empty: 1

    [[nodiscard]] static constexpr auto options() {
        using S = GivenSolution;
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
    friend bool operator==(const GivenSolution&, const GivenSolution&) = default;
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
    std::vector<Reference> references = {};  ///< empty: all that are not among the analytic ones
    std::vector<AnalyticSurface> analytic = {};
    CadVertices vertices = CadVertices::keep;
    double seconds = 0, memory = 0;

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
            option("seconds", &S::seconds,
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

/// What `FeatureOptions` have for either dimension, and what required entities of the boundary hold.
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
/// With the stages' own options for the cavities.
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
/// Passes of remeshing, and rounds of them.
using Collapse = CollapseOptions;
using Split = SplitOptions;
using Swap = SwapOptions;
using Smooth = SmoothOptions;
using Mend = MendOptions;
/// Where passes that change a mesh of degree 2 put the nodes of inner edges.
enum class RemeshObjective : std::uint8_t {
    as_curved,  ///< that of a stage curve before; accuracy
    accuracy,
    energy,
    length,
};
[[nodiscard]] constexpr auto words(RemeshObjective) {
    return words_of(Word{RemeshObjective::as_curved, "as_curved"}, Word{RemeshObjective::accuracy, "accuracy"},
                    Word{RemeshObjective::energy, "energy"}, Word{RemeshObjective::length, "length"});
}
struct Remesh : ToMetricOptions, RemeshBlocksOptions {
    RemeshObjective objective = RemeshObjective::as_curved;

    [[nodiscard]] static constexpr auto options() {
        using S = Remesh;
        return std::tuple_cat(
            std::tuple(option("objective", &S::objective,
                              "degree 2: what inner edges are curved for, as in the stage curve: accuracy, energy or "
                              "length; as_curved: that of a stage curve before, else accuracy")),
            RemeshBlocksOptions::options(), ToMetricOptions::options());
    }
    friend bool operator==(const Remesh&, const Remesh&) = default;
};
using Stage =
    std::variant<Elevate, Curve, Validate, Relax, Commit, Reinsert, Collapse, Split, Swap, Smooth, Mend, Remesh>;

// ---------------------------------------------------------------- the whole

struct Output {
    std::string mesh, report, vtu, metric, solution, plots, page;  ///< empty: not written
    std::string format;  ///< of the mesh, by its name; empty: that of its ending
    VtuCells vtu_cells = VtuOptions{}.cells;
    DistanceWays distances = DistanceWays::boundary;
    int partition = 0;  ///< parts of the mesh; 0: it is not in parts

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

struct Pipeline {
    Input input;
    GivenSolution solution;
    Metric metric;
    std::string metric_mesh = {};
    std::vector<MetricOperation> metric_operations;
    Geometry geometry;
    Features features;
    BoundaryTolerance geometry_tolerance = {};
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
            option("stages", &S::stages, "what is done, in this order").count(0, 1000),
            option("adapt", &S::adapt, "cycles of them, and the solver that is asked in between"),
            option("threads", &S::threads, "threads to use; 0: all that the machine has").at_least(0).at_most(4096),
            option("output", &S::output, "files to write"));
    }
    friend bool operator==(const Pipeline&, const Pipeline&) = default;
};

}  // namespace camber::config
