module;
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>
export module camber.recipes:measurements;
import camber.core;
import camber.transfer;
import camber.io;
import camber.surface;
import :fields;
import :values;

export namespace camber::run {

/// Quantity of a histogram. Its bins never change, so that runs can be compared.
enum class Quantity : std::uint8_t {
    length_reduction,
    length,
    curvature,
    scaled_jacobian,
    quality,
    edge_length,
    metric_quality,
    curved_edge_length,
    curved_metric_quality
};
inline constexpr std::size_t quantity_count = 9;
inline constexpr std::size_t run_quantity_count = 4;  ///< the first quantities are of runs, the others of checks

struct QuantityInfo {
    Quantity quantity;
    std::string_view key;     ///< in report.json
    std::string_view title;   ///< of a plot
    std::string_view axis;    ///< meaning and unit of the values
    std::string_view things;  ///< counted entities
    int base;                 ///< an axis numbers limits at integer powers of it first
};
[[nodiscard]] const QuantityInfo& info(Quantity quantity);

/// Limits of a quantity's bins, ascending and finer towards the tails:
/// - length_reduction: −0.1, −0.01, −0.001, 0, 1e-5, 1e-4, then 1, 1.5, 2, 3, 5, 7 per decade from 0.001 to 100;
/// - length in the metric: 2^-10 … 2^10 by octaves, by quarters of them from 2^-3 to 2^3;
/// - curvature: 0, then 1, 1.5, 2, 3, 5, 7 per decade from 0.001 to 10;
/// - scaled Jacobian and quality: −10, −1, −0.1, −0.01, −0.001, −1e-6, −1e-9, 0, then 1e-9 … 0.001 by decades,
///   0.005, 0.02, and 0.05, 0.1 … 1.
[[nodiscard]] std::vector<double> limits_of(Quantity quantity);

struct Extremes {
    double least = 0, greatest = 0;
    friend bool operator==(const Extremes&, const Extremes&) = default;
};

/// Counts for one state of the mesh: below the first limit, from each limit (included) to the next, and from the last
/// limit up. −∞ is in the first bin and ∞ in the last. NaN is only in `not_numbers`, so that all counts sum to the
/// number of values.
struct Series {
    std::string name;  ///< "straight", "before", "after" (correction), "count"
    std::vector<std::size_t> counts;
    double mean = 0;  ///< of the finite values; 0: none
    std::optional<Extremes> extremes;
    std::size_t not_numbers = 0;
    friend bool operator==(const Series&, const Series&) = default;
};

struct Histogram {
    Quantity quantity = Quantity::length_reduction;
    std::vector<double> limits;
    std::vector<Series> series;
    friend bool operator==(const Histogram&, const Histogram&) = default;
};

[[nodiscard]] Series counted(std::string name, std::span<const double> limits, std::span<const double> values);

[[nodiscard]] const Series* find_series(const Histogram& histogram, std::string_view name);

struct OneWayReport {
    std::size_t samples = 0;
    double largest = 0, mean = 0;
    std::vector<double> from, to;
    std::size_t facet = 0;  ///< from 1; 0: none

    static void fields(auto& s, auto& f) {
        f("samples", s.samples, "number of sampled points; 0: not measured, without other keys");
        f("largest", s.largest, "largest distance", unit("length"), shown_if(s.samples > 0));
        f("mean", s.mean, "mean distance", unit("length"), shown_if(s.samples > 0));
        f("from", s.from, "point with the largest distance", unit("length"), shown_if(s.samples > 0));
        f("to", s.to, "nearest point on the other side", unit("length"), shown_if(s.samples > 0));
        f("facet", s.facet, "facet at that point, from 1; 0: none", shown_if(s.samples > 0));
    }
};

struct EntityReport {
    std::string kind;
    std::size_t number = 0;
    std::string name;  ///< for messages
    std::vector<std::size_t> sides;
    std::vector<std::string> beside;
    bool is_flat = false;
    std::vector<Reference> references;
    std::size_t pieces = 0;
    double measure = 0;
    OneWayReport to_geometry, to_boundary;

    static void fields(auto& s, auto& f) {
        f("kind", s.kind,
          "`face` and `edge`: of a CAD model; `patch` and `ridge`: of a surrogate; `surface` and `curve`: of analytic "
          "surfaces (2D: `curve`); `none`: facets without a surface");
        f("number", s.number, "its number in its geometry, from 1; 0: none");
        f("sides", s.sides, "curve: numbers of the adjacent surfaces", unless_empty);
        f("side_geometries", s.beside, "curve between surfaces of two geometries: their names", unless_empty);
        f("flat", s.is_flat, "true: a plane (2D: a line) that has facets");
        f("references", s.references, "references of the facets on it (curve: next to it)");
        f("pieces", s.pieces, "number of these facets (curve: of edges)");
        f("measure", s.measure, "area of these facets (curve: length) with straight edges", unit("length^(D−1)"));
        f("to_geometry", s.to_geometry, "distances of its facets from the geometry");
        f("to_boundary", s.to_boundary, "distances of this entity from the boundary");
    }
};

/// Name of an entity for messages: "face 12", "edge between 3 and 7".
[[nodiscard]] std::string name_of(const EntityReport& entity);

struct DistancesReport {
    std::string geometry;  ///< for messages: "CAD model wing.step, analytic surfaces, surrogate"
    OneWayReport to_geometry, to_boundary;
    std::vector<EntityReport> entities;

    static void fields(auto& s, auto& f) {
        f("to_geometry", s.to_geometry,
          "distances of points of the curved boundary from the geometry "
          "([distances.md](algorithms/distances.md))");
        f("to_boundary", s.to_boundary, "distances of points of the geometry from the boundary");
        f("entities", s.entities, "one entry for each entity of the geometry");
    }
};

template <int D>
[[nodiscard]] DistancesReport distances_report(const GeometryDistances<D>& distances, const Geometry<D>& geometry,
                                               const config::Geometry& config);

struct SolutionMetricReport {
    int degree = 1;
    double requested = 0, complexity = 0;
    double elements = 0;
    double fixed_complexity = 0;
    bool is_fixed_sufficient = false;
    bool is_reached = true;
    bool is_graded = true;
    int evaluations = 0, gradations = 0;
    double largest_anisotropy = 1;
    double at_min = 0, at_max = 0;
    std::size_t rows = 0, from_inner_fits = 0, lower_degree = 0;
    std::size_t zero_models = 0, floored_models = 0;
    double models_max_anisotropy = 0;
    std::vector<std::string> unordered_fields = {};  ///< fields whose values are as unrelated as in a random order

    static void fields(auto& s, auto& f) {
        f("degree", s.degree, "degree of the elements that interpolate the solution");
        f("requested_complexity", s.requested, "requested complexity", unit("1"));
        f("complexity", s.complexity, "complexity of the metric", unit("1"));
        f("elements_expected", s.elements, "expected number of elements");
        f("fixed_complexity", s.fixed_complexity,
          "complexity that sizes, geometry, other metrics and bounds require "
          "without the solution",
          unit("1"));
        f("is_fixed_sufficient", s.is_fixed_sufficient,
          "true: `fixed_complexity` reaches the requested complexity, and the solution has no influence");
        f("is_reached", s.is_reached, "true: the requested complexity is reached to 10⁻³");
        f("is_graded", s.is_graded, "true: the gradation converged");
        f("evaluations", s.evaluations, "number of evaluated complexities");
        f("gradations", s.gradations, "number of gradations");
        f("largest_anisotropy", s.largest_anisotropy, "largest ratio of the longest to the shortest size", unit("1"));
        f("at_min_size", s.at_min, "share of the vertices with a size at the lower bound", unit("1"));
        f("at_max_size", s.at_max, "share of the vertices with a size at the upper bound", unit("1"));
        f("rows", s.rows, "number of recovered derivatives: one for each vertex and material");
        f("from_inner_fits", s.from_inner_fits, "number of these on the boundary that were taken from the interior");
        f("lower_degree", s.lower_degree, "number of these with a lower degree, for lack of nodes");
        f("zero_models", s.zero_models, "number of places without derivatives");
        f("bounded_models", s.floored_models, "number of error models whose anisotropy was bounded");
    }
};

struct IntegralReport {
    double largest = 0, largest_change = 0;

    static void fields(auto& s, auto& f) {
        f("largest", s.largest, "largest integral of a material and component before the transfer");
        f("largest_change", s.largest_change, "largest change of such an integral");
    }
};

struct TransferReport {
    TransferMethod method = TransferMethod::interpolate;
    std::vector<std::string> names;
    TransferStatistics statistics;

    [[nodiscard]] std::vector<std::pair<std::string, IntegralReport>> integrals() const;
    static void fields(auto& s, auto& f) {
        f("method", s.method, "`interpolate` or `conserve`");
        f("fields", s.names, "names of the fields");
        f("unchanged", s.statistics.preserved, "number of nodes with identical values, to the last bit");
        f("interpolated", s.statistics.interpolated, "number of nodes inside the old mesh");
        f("outside", s.statistics.outside, "number of nodes outside the old mesh");
        f("largest_distance", s.statistics.largest_distance, "largest distance of such a node from the old mesh",
          unit("length"));
        f("projected", s.statistics.projected, "`conserve`: number of nodes with projected values");
        f("changed_elements", s.statistics.changed_elements,
          "`conserve`: number of elements that the old mesh does not have");
        f("patches", s.statistics.patches, "`conserve`: number of connected patches of these elements");
        f("redistributed", s.statistics.spread,
          "`conserve`: number of parts of patches whose integral is preserved by other nodes");
        f("unconserved_materials", s.statistics.unconserved_materials,
          "`conserve`: number of materials without a node that preserves their integral");
        f("integrals", s.integrals(), "integrals of each field");
    }
};

[[nodiscard]] std::vector<std::string> solution_metric_notices(const SolutionMetricReport& report);

/// Estimated peak resident memory (bytes) of elevate, curve, validate, relax and commit. It is fitted to runs with
/// curved walls and a field that moves with them: shells with layers of 2.7·10⁵, 10⁶ and 5·10⁶ tetrahedra, annuli of
/// 3·10⁵ and 3·10⁶ triangles. Errors are −7 % to +7 %. The objective `shape` needs 10 to 20 % less, a run without
/// moving walls 20 % less. The result saturates. Mesh generation, and fields in a VTU file, need additional memory.
[[nodiscard]] constexpr std::size_t estimated_peak_bytes(std::size_t vertices, std::size_t elements, int dimension) {
    const double program = 10.5e6;
    const double a_vertex = dimension == 2 ? 300 : 1000;
    const double an_element = dimension == 2 ? 200 : 210;
    const double bytes =
        program + a_vertex * static_cast<double>(vertices) + an_element * static_cast<double>(elements);
    constexpr double most = 9.2e18;
    return static_cast<std::size_t>(bytes < most ? bytes : most);
}

struct AvailableMemory {
    std::size_t bytes = std::numeric_limits<std::size_t>::max();
    std::string source;
};

struct Growth {
    double elements = 0;  ///< by the metric
    std::size_t peak_bytes = 0;
};

inline constexpr double bytes_of_program = 13e6;
/// Holds while a changed mesh is compacted.
[[nodiscard]] constexpr double bytes_of_element(int dimension, int degree) {
    return (dimension == 2 ? 347 : 263) * (degree == 2 ? 1.7 : 1);
}

/// `complexity`: ∫ sqrt(det M). Meshes with edges up to √2 had about 11.5 tetrahedra or 2.5 triangles per unit of it;
/// shorter edges give proportionally more. Memory peaks while the changed mesh is compacted: 256 and 263 bytes per
/// tetrahedron (10^5 and 3·10^5, one thread), 347 per triangle (1.2·10^5), 450 per quadratic tetrahedron (7·10^4).
[[nodiscard]] inline Growth expected_growth(double complexity, double longest_edge, std::size_t elements_before,
                                            int dimension, int degree) {
    const double refined = pow(std::sqrt(2.0) / longest_edge, dimension);
    const double elements = (dimension == 2 ? 2.5 : 11.5) * complexity * refined;
    const double bytes =
        bytes_of_program + bytes_of_element(dimension, degree) * (elements + static_cast<double>(elements_before));
    constexpr double most = 9.2e18;
    return {elements, static_cast<std::size_t>(bytes < most ? bytes : most)};
}

[[nodiscard]] inline std::size_t max_elements_within(std::size_t bytes, int dimension, int degree) {
    const double room = static_cast<double>(bytes) - bytes_of_program;
    return room > 0 ? static_cast<std::size_t>(room / bytes_of_element(dimension, degree)) : 0;
}

// Reports number a vertex as the file does (Gmsh: by its tag), and an element by its position in the file, from 1. A
// different tag is reported, too.

struct FileNumbers {
    Column<std::uint32_t> nodes = {};  ///< DecodedMesh::node_numbers
    FileTags tags = {};

    /// Mid nodes follow the vertices.
    [[nodiscard]] std::size_t operator()(std::size_t node) const {
        if (!nodes.empty()) return nodes[node];
        return node < tags.vertices.size() ? tags.vertices[node] : node + 1;
    }
    /// Tag of a simplex at a position from 1; 0: it has none, or it is the position.
    [[nodiscard]] std::uint64_t tag(int dimension, std::size_t place) const {
        const auto& all = tags.simplices[static_cast<std::size_t>(dimension)];
        return place > 0 && place <= all.size() ? all[place - 1] : 0;
    }
};

/// "71", "71 (tag 323)".
[[nodiscard]] std::string called(std::size_t place, std::uint64_t tag);

using Groups = std::vector<Group>;
/// Empty: no name.
[[nodiscard]] std::string name_in(const Groups& groups, int dimension, Reference reference);
/// "3", "3 wall".
[[nodiscard]] std::string called(const Groups& groups, int dimension, Reference reference);

[[nodiscard]] FileNumbers numbers_of(const DecodedMesh& mesh);
[[nodiscard]] Groups groups_of(const AnyMesh& mesh);

/// Each value includes the one before.
enum class RunContent : std::uint8_t {
    straight_mesh,
    curved_mesh,    ///< of degree 2
    planned_nodes,  ///< with a plan for its nodes; a curved input starts with its own nodes as plan
};

/// Effect of a stage on planned positions that are not committed.
enum class Places : std::uint8_t {
    preserves,
    plans,  ///< makes or changes them
    commits,
    refuses  ///< changes the mesh; no plan may exist
};

/// Runs on states from `least` to `most`.
template <class Options>
struct Step {
    std::string_view name;
    RunContent least = RunContent::straight_mesh, most = RunContent::planned_nodes;
    std::optional<RunContent> result_content = {};  ///< none: no change
    Places places = Places::preserves;
};

/// One row for each alternative of config::Stage; a missing row does not compile.
inline constexpr std::tuple step_table{
    Step<config::Elevate>{"elevate", RunContent::straight_mesh, RunContent::straight_mesh, RunContent::curved_mesh},
    Step<config::Curve>{"curve", RunContent::curved_mesh, RunContent::planned_nodes, RunContent::planned_nodes,
                        Places::plans},
    Step<config::Validate>{"validate", RunContent::curved_mesh, RunContent::planned_nodes},
    Step<config::Relax>{"relax", RunContent::planned_nodes, RunContent::planned_nodes, {}, Places::plans},
    Step<config::Commit>{"commit", RunContent::planned_nodes, RunContent::planned_nodes, {}, Places::commits},
    Step<config::Reinsert>{"reinsert", RunContent::curved_mesh, RunContent::planned_nodes, RunContent::planned_nodes,
                           Places::commits},
    Step<config::Collapse>{"collapse", RunContent::straight_mesh, RunContent::planned_nodes, {}, Places::refuses},
    Step<config::Split>{"split", RunContent::straight_mesh, RunContent::planned_nodes, {}, Places::refuses},
    Step<config::Swap>{"swap", RunContent::straight_mesh, RunContent::planned_nodes, {}, Places::refuses},
    Step<config::Smooth>{"smooth", RunContent::straight_mesh, RunContent::planned_nodes, {}, Places::refuses},
    Step<config::Mend>{"improve", RunContent::straight_mesh, RunContent::planned_nodes, {}, Places::refuses},
    Step<config::Remesh>{"remesh", RunContent::straight_mesh, RunContent::planned_nodes, {}, Places::refuses},
};

template <class Options>
[[nodiscard]] constexpr bool changes_topology() {
    return std::get<Step<Options>>(step_table).places == Places::refuses;
}

/// Errors: usage with the stage's JSON path (an earlier stage is missing or not allowed), or input without a path (the
/// stages do not accept the degree of the mesh).
[[nodiscard]] Outcome<Done> check_order(std::span<const config::Stage> stages, int degree);

}  // namespace camber::run
