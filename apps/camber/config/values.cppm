module;
#include <array>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>
export module camber.config:values;
import camber.core;
import camber.fields;
import camber.shapes;

/// What a config says, as plain values. Each struct's fields are described (unit, range, meaning) in describe_*.cpp.
export namespace camber::config {

struct FilePath {
    std::string path;
    friend bool operator==(const FilePath&, const FilePath&) = default;
};

// ---------------------------------------------------------------- where the mesh comes from

using Shape = std::variant<ShellOptions<3>, ShellOptions<2>, BoxOptions<3>, BoxOptions<2>, BumpOptions>;

/// A file, or a shape to generate.
using MeshSource = std::variant<FilePath, Shape>;

/// What triangles alone in one plane z = constant are taken for.
enum class Flat : std::uint8_t { plane, surface };

struct Input {
    MeshSource source = FilePath{};
    Flat flat = Flat::plane;  ///< of a file
    friend bool operator==(const Input&, const Input&) = default;
};

// ---------------------------------------------------------------- the metric

struct NaturalMetric {
    friend bool operator==(const NaturalMetric&, const NaturalMetric&) = default;
};
struct ConstantMetric {
    std::vector<double> sizes;   ///< 1 or D edge lengths, along the axes
    std::vector<double> tensor;  ///< or D (D + 1)/2 entries, lower triangle by rows
    friend bool operator==(const ConstantMetric&, const ConstantMetric&) = default;
};
struct SurfaceMetric {
    double tangent_size = 1, normal_size = 0.1;
    double volume_size = 0;  ///< 0: as tangent_size
    friend bool operator==(const SurfaceMetric&, const SurfaceMetric&) = default;
};
struct PlanarShock {
    std::vector<double> point, normal;
    double least_size = 0.01, size = 0.1, width = 0.1;
    friend bool operator==(const PlanarShock&, const PlanarShock&) = default;
};
struct SphericalShock {
    std::vector<double> centre;
    double radius = 0.5, least_size = 0.01, size = 0.1, width = 0.1;
    friend bool operator==(const SphericalShock&, const SphericalShock&) = default;
};
using FieldMetric = std::variant<LinearField, PolarOneField, PolarTwoField, PlanarShock, SphericalShock, RotatingField>;
using Metric = std::variant<NaturalMetric, FilePath, ConstantMetric, SurfaceMetric, FieldMetric, MetricExpression>;

/// What is done to the metric, in this order, before edges follow it.
struct Intersect {
    Metric metric;
    friend bool operator==(const Intersect&, const Intersect&) = default;
};
enum class GradationSpace : std::uint8_t { metric, physical, mixed };
struct Gradation {
    double ratio = 1.5;
    GradationSpace space = GradationSpace::mixed;
    double physical_share = 0.125;
    int max_sweeps = 1000;
    friend bool operator==(const Gradation&, const Gradation&) = default;
};
struct Bound {
    double min_size = 0, max_size = 0, max_anisotropy = 0;  ///< 0: none
    friend bool operator==(const Bound&, const Bound&) = default;
};
struct Complexity {
    double target = 10000;
    friend bool operator==(const Complexity&, const Complexity&) = default;
};
using MetricOperation = std::variant<Intersect, Gradation, Bound, Complexity>;

// ---------------------------------------------------------------- the geometry

struct Surrogate {
    friend bool operator==(const Surrogate&, const Surrogate&) = default;
};
struct Straight {
    friend bool operator==(const Straight&, const Straight&) = default;
};
struct Plane {
    std::vector<double> point, normal;
    friend bool operator==(const Plane&, const Plane&) = default;
};
struct Sphere {
    std::vector<double> centre;
    double radius = 1;
    friend bool operator==(const Sphere&, const Sphere&) = default;
};
struct Cylinder {
    std::vector<double> point, axis;
    double radius = 1;
    friend bool operator==(const Cylinder&, const Cylinder&) = default;
};
struct Torus {
    std::vector<double> centre, axis;
    double major_radius = 2, minor_radius = 1;
    friend bool operator==(const Torus&, const Torus&) = default;
};
using Surface = std::variant<Plane, Sphere, Cylinder, Torus>;
struct AnalyticSurface {
    std::vector<Reference> references;
    Surface surface;
    friend bool operator==(const AnalyticSurface&, const AnalyticSurface&) = default;
};
struct Analytic {
    std::vector<AnalyticSurface> surfaces;
    friend bool operator==(const Analytic&, const Analytic&) = default;
};
using Geometry = std::variant<Surrogate, Straight, Analytic>;

enum class Required : std::uint8_t { keep, geometry };

struct Features {
    double ridge_angle = 40;
    Required required_boundary = Required::keep;
    friend bool operator==(const Features&, const Features&) = default;
};

// ---------------------------------------------------------------- the stages

enum class Objective : std::uint8_t { energy, length, shape };
enum class FieldOfEdge : std::uint8_t { back, edge };
enum class Repair : std::uint8_t { cavity, edge, segment, relax };
enum class Vertices : std::uint8_t { move, keep };

struct Elevate {
    friend bool operator==(const Elevate&, const Elevate&) = default;
};
struct Curve {
    Objective objective = Objective::energy;
    FieldOfEdge field = FieldOfEdge::back;
    int quadrature_points = 4;
    int iterations = 30;
    double length_tolerance = 1e-3;
    double max_tangential_shift = 0.2;
    double max_offset = 4;
    friend bool operator==(const Curve&, const Curve&) = default;
};
struct Validate {
    double min_scaled_jacobian = 1e-9;
    friend bool operator==(const Validate&, const Validate&) = default;
};
struct Relax {
    Repair repair = Repair::cavity;
    double target = 1e-2;
    double boundary_tolerance = 0;
    Vertices vertices = Vertices::move;
    double effort = 500;
    double theta = 0.75;
    int max_corrections = 40;
    double min_scaled_jacobian = 1e-9;
    friend bool operator==(const Relax&, const Relax&) = default;
};
struct Commit {
    friend bool operator==(const Commit&, const Commit&) = default;
};
struct Reinsert {
    Curve curve;
    Relax relax;
    int max_turns = 20;
    friend bool operator==(const Reinsert&, const Reinsert&) = default;
};
using Stage = std::variant<Elevate, Curve, Validate, Relax, Commit, Reinsert>;

// ---------------------------------------------------------------- the whole

enum class VtuCells : std::uint8_t { quadratic, lagrange };

struct Output {
    std::string mesh, report, vtu, plots;  ///< empty: not written
    VtuCells vtu_cells = VtuCells::quadratic;
    friend bool operator==(const Output&, const Output&) = default;
};

struct Pipeline {
    Input input;
    Metric metric;
    std::vector<MetricOperation> metric_operations;
    Geometry geometry;
    Features features;
    std::vector<Stage> stages{Elevate{}, Curve{}, Validate{}, Relax{}, Commit{}};
    int threads = 0;
    Output output;
    friend bool operator==(const Pipeline&, const Pipeline&) = default;
};

}  // namespace camber::config
