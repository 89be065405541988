module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>
export module camber.recipes:report;
import camber.core;
import camber.metric;
import camber.validity;
import camber.operation;
import camber.curving;
import camber.repair;
import camber.stages;
import camber.distributed;
import :fields;
import :measurements;

/// What a run tells: plain numbers, printed as a table and written as report.json.
export namespace camber::run {

/// Format number of report.json, check --json and geometry --json. It rises when a key is removed, renamed or
/// redefined.
inline constexpr int report_format = 5;

/// Input of a run, as the shell read it.
struct OriginReport {
    std::string version;            ///< of the program
    std::string mesh, metric;       ///< files; empty: generated, and no file
    int dimension = 3, degree = 1;  ///< of the mesh as it was read or generated, before `prepare`
    std::size_t vertices = 0, elements = 0, facets = 0;
    std::string config;    ///< the pipeline with every default, as JSON
    std::string geometry;  ///< "surrogate", "straight", "mesh", "analytic" or "cad"

    static void fields(auto& s, auto& f) {
        f("mesh", only_if(!s.mesh.empty(), s.mesh), "file that was read; null: the mesh was generated", or_null);
        f("metric", only_if(!s.metric.empty(), s.metric), "file of the metric; null: none", or_null);
        f("dimension", s.dimension, "dimension of that mesh: 2 or 3");
        f("degree", s.degree, "degree of that mesh: 1 straight, 2 curved");
        f("vertices", s.vertices, "number of vertices of that mesh, before `prepare`");
        f("elements", s.elements, "number of its elements, before `prepare`");
        f("facets", s.facets, "number of its facets, before `prepare`");
    }
};

/// Volume edges on the true field, by a 12-point rule: length reduction L_straight/L − 1 (paper eq. 8) and curvature
/// |P^l − M_11|/|P_20 − P_02|.
struct EdgeReport {
    double mean_length_reduction = 0, largest_length_reduction = 0;
    double mean_curvature = 0, largest_curvature = 0;
    std::size_t measured = 0, longer = 0;

    static void fields(auto& s, auto& f) {
        f("mean_length_reduction", s.mean_length_reduction, "mean of L_straight/L − 1 over volume edges", unit("1"),
          of_volume);
        f("largest_length_reduction", s.largest_length_reduction, "largest L_straight/L − 1 of a volume edge",
          unit("1"), of_volume);
        f("mean_curvature", s.mean_curvature,
          "mean distance of an edge's node from the middle of its chord, by the chord's length", unit("1"));
        f("largest_curvature", s.largest_curvature, "largest such distance", unit("1"));
        f("measured_edges", s.measured,
          "number of edges whose lengths were measured: all volume edges, or about 131 072 of a larger mesh, or all "
          "where the output shows fields",
          of_volume);
        f("longer_edges", s.longer,
          "number of edges that are longer than their chords in the metric; with the criterion accuracy this is no "
          "defect",
          of_volume);
    }
};

/// Order of the mesh where stages worked in another one (ordering).
struct ReorderedReport {
    double scatter = 0;

    static void fields(auto& s, auto& f) {
        f("scatter", s.scatter,
          "scatter of the input's order in memory; output and report are in the order of the input "
          "([space-filling-order.md](algorithms/space-filling-order.md))",
          unit("1"));
    }
};

struct MeshReport {
    int dimension = 3, degree = 1;
    std::size_t vertices = 0, nodes = 0, elements = 0, facets = 0, feature_edges = 0;

    /// A surface in space without elements: its triangles are judged.
    [[nodiscard]] bool is_surface_alone() const { return dimension == 3 && elements == 0 && facets > 0; }
    [[nodiscard]] std::size_t judged() const { return is_surface_alone() ? facets : elements; }
    [[nodiscard]] int judged_dimension() const { return is_surface_alone() ? 2 : dimension; }

    static void fields(auto& s, auto& f) {
        f("dimension", s.dimension, "2 or 3");
        f("degree", s.degree, "degree of the elements: 1 or 2");
        f("vertices", s.vertices, "number of vertices");
        f("nodes", s.nodes, "number of nodes: vertices and, in degree 2, one node an edge");
        f("elements", s.elements, "number of elements: triangles in 2D, tetrahedra in 3D");
        f("facets", s.facets, "number of edges (2D) or triangles (3D) of the boundary and of interfaces");
        f("feature_edges", s.feature_edges, "number of edges that the file lists in 3D");
        f("standalone_surface", s.is_surface_alone(), "true: a surface in space without elements", unless_empty);
    }
};

struct GradationReport {
    int sweeps = 0;
    std::size_t changed = 0;
    bool converged = true;

    static void fields(auto& s, auto& f) {
        f("sweeps", s.sweeps, "sweeps over all edges of an operation `gradation`");
        f("changed_vertices", s.changed, "number of vertices whose metric it refined");
        f("converged", s.converged, "false: the limit of sweeps was reached before the gradation was satisfied");
    }
};

struct MetricReport {
    std::string source;
    double largest_anisotropy = 1;
    double complexity = 0;                    ///< after the operations
    std::vector<GradationReport> gradations;  ///< in the order of the config
    std::size_t floored = 0;

    static void fields(auto& s, auto& f) {
        f("source", s.source, "`natural` (mesh-implied), or the source that the config names");
        f("largest_anisotropy", s.largest_anisotropy, "largest ratio of the longest to the shortest size at a vertex",
          unit("1"));
        f("complexity", s.complexity, "∫ √det M: proportional to the number of elements of unit size", unit("1"));
        f("corrected_tensors", s.floored,
          "number of tensors of the file that rounding had made indefinite, and that were corrected");
        f("gradations", s.gradations, "one entry for each operation `gradation`", unless_empty);
    }
};

/// A position on the boundary; an invalid one has no coordinates.
using ReportedPlace = std::vector<double>;

/// Number of boundary nodes that `curve` moved back towards their chords until no walls crossed (repair:method).
struct RelaxedWallsReport {
    std::size_t nodes = 0;
    double largest = 0;             ///< distance of a node from its target (model units)
    ReportedPlace largest_at = {};  ///< position of that node

    static void fields(auto& s, auto& f) {
        f("nodes", s.nodes,
          "number of boundary nodes that `curve` moved back towards their chords until no walls crossed");
        f("largest_distance", s.largest, "largest distance of such a node from its target", unit("length"));
        f("point", s.largest_at, "position of that node", unit("length"));
    }
};

/// The first pair of facets that crosses.
struct FirstCrossing {
    std::array<std::size_t, 2> facets{};
    ReportedPlace near;

    static void fields(auto& s, auto& f) {
        f("facets", s.facets, "the first pair of facets that crosses, from 1; any pair makes the exit code 1");
        f("point", s.near, "centre of the overlap of their boxes", unit("length"));
    }
};

/// Pairs of facets that cross, curved as they are in the end (crossing:crossings).
struct WallsReport {
    std::size_t crossing = 0, touching = 0, undecided = 0;
    std::size_t first = 0, other = 0;                ///< the first pair that crosses, from 1; 0: none
    ReportedPlace first_at = {};                     ///< centre of the overlap of their boxes
    std::size_t crossing_before = 0;                 ///< pairs that crossed in the input already
    std::optional<RelaxedWallsReport> relaxed = {};  ///< where nodes were moved back

    static void fields(auto& s, auto& f) {
        f("crossing_pairs", s.crossing,
          "pairs of facets that pass through each other in the end ([crossing.md](algorithms/crossing.md))");
        f("touching_pairs", s.touching, "pairs of facets that touch");
        f("undecided_pairs", s.undecided, "pairs of facets that are too near to each other for a decision");
        f("first_crossing", only_if(s.crossing > 0, FirstCrossing{{s.first, s.other}, s.first_at}),
          "the first pair that crosses");
        f("crossing_pairs_of_input", s.crossing_before, "pairs that crossed in the input already", unless_empty);
        f("relaxed_for_crossing", s.relaxed, "boundary nodes that were moved back");
    }
};

/// Elements that overlap in the end (crossing:crossings).
struct OverlappingReport {
    std::size_t overlapping = 0;  ///< places where they do; 0: none
    std::vector<double> point;    ///< one of them (model units)

    static void fields(auto& s, auto& f) {
        f("overlapping", s.overlapping,
          "number of places where elements of the result overlap; the exit code is then 1 "
          "([crossing.md](algorithms/crossing.md#elements-that-overlap))");
        f("point", s.point, "one of these places", unit("length"));
    }
};

/// Vertices that were moved onto a CAD model before all stages.
struct CadMovesReport {
    std::size_t moved = 0, held = 0;
    double largest = 0;  ///< (model units)

    static void fields(auto& s, auto& f) {
        f("moved_vertices", s.moved,
          "with `geometry/cad/vertices` = `move`: number of vertices that were moved onto the model before all stages");
        f("partly_moved_vertices", s.held,
          "number of vertices that stopped short of the model, since an element would have been flat");
        f("largest_vertex_move", s.largest, "largest of these moves", unit("length"));
    }
};

/// Faces of a CAD model (in 2D edges) that meet smoothly and that a mesh treats as one, by their numbers from 1.
struct JoinedFacesReport {
    bool are_edges = false;
    std::vector<std::vector<std::size_t>> lists = {};

    static void fields(auto& s, auto& f) {
        f("virtual_faces", s.lists,
          "lists of faces (in 2D edges) of the model that meet smoothly and that the mesh treats as one, by numbers "
          "from 1 ([cad.md](algorithms/cad.md#virtual-faces))",
          unless_empty);
    }
};

/// Facets of a mesh that span ridges of a CAD model.
struct AcrossRidgesReport {
    std::size_t count = 0;
    std::size_t first = 0;           ///< from 1; 0: none
    std::vector<double> place = {};  ///< of the ridge that this one spans

    static void fields(auto& s, auto& f) {
        f("facets_across_ridges", s.count, "number of facets that span a ridge of the model", unless_empty);
        f("first_facet_across_ridges", s.first, "the first of them, from 1", unless_empty);
        f("first_ridge_point", s.place, "a point of the ridge that it spans", unit("length"), unless_empty);
    }
};

/// Relation of a mesh's boundary to a CAD model.
struct CadReport {
    std::string mesh_unit, file_unit;
    bool is_in_file_unit = true;
    bool is_unit_found = false;
    std::size_t faces = 0, edges = 0, vertices = 0;
    std::size_t faces_met = 0, edges_met = 0, vertices_met = 0;
    std::size_t facets = 0, analytic_facets = 0, surrogate_facets = 0;
    std::vector<Reference> within_materials = {};
    std::size_t coincident_facets = 0;
    std::size_t doubtful_facets = 0, settled_facets = 0, doubtful_edges = 0, doubtful_vertices = 0;
    double largest_vertex_distance = 0;
    std::optional<double> largest_node_distance;
    std::optional<CadMovesReport> moves = {};
    std::size_t lost_faces = 0, failed_entities = 0, open_shells = 0;
    JoinedFacesReport joined = {};
    AcrossRidgesReport across = {};

    static void fields(auto& s, auto& f) {
        f("unit", s.mesh_unit,
          "unit of the mesh's coordinates, to which the model is converted ([cad.md](algorithms/cad.md))");
        f("file_unit", s.file_unit, "unit as the CAD file names it; empty: the file names none (mm)");
        f("unit_found", s.is_unit_found, "true: `auto` took another unit than that of the file");
        f("faces", s.faces, "number of faces of the CAD model");
        f("edges", s.edges, "number of edges of the CAD model");
        f("vertices", s.vertices, "number of vertices of the CAD model");
        f("failed_faces", s.lost_faces, "number of faces of the CAD file for which no surface could be made");
        f("failed_entities", s.failed_entities, "number of entities of the CAD file whose transfer failed");
        f("open_shells", s.open_shells, "number of shells of solids that are not closed");
        f("matched_faces", s.faces_met, "number of faces of the model with facets of the mesh on them");
        f("matched_edges", s.edges_met, "number of edges of the model with edges of the mesh on them");
        f("matched_vertices", s.vertices_met, "number of vertices of the model with a vertex of the mesh on them");
        f("facets", s.facets, "number of facets of the mesh on the model, by `geometry/cad`");
        f("analytic_facets", s.analytic_facets, "number of facets on analytic surfaces");
        f("surrogate_facets", s.surrogate_facets, "number of facets on the surrogate");
        f("coincident_facets", s.coincident_facets,
          "number of facets where two faces of the model coincide (solids that touch); they are on the first of them");
        f("ambiguous_facets", s.doubtful_facets,
          "number of facets that two faces, which do not meet smoothly, fit almost equally well");
        f("resolved_facets", s.settled_facets, "number of these that the other facets of their reference decided");
        f("ambiguous_edges", s.doubtful_edges,
          "number of edges between facets of two faces that have no common edge nearby");
        f("ambiguous_vertices", s.doubtful_vertices,
          "number of vertices where three or more faces meet, without a vertex of the model nearby");
        f("largest_vertex_distance", s.largest_vertex_distance,
          "largest distance of a boundary vertex from its CAD entity: of the final mesh where passes changed it, else "
          "of the input",
          unit("length"));
        f("references_within_materials", s.within_materials,
          "references of facets that lie within one material and not on the model; they have no CAD geometry and are "
          "counted in `surrogate_facets`",
          unless_empty);
        f("largest_node_distance", s.largest_node_distance,
          "largest distance of a node of a boundary edge on the model from its CAD entity, in the end", unit("length"));
        f.merged(s.joined);
        f.merged(s.across);
        f.merged(s.moves);
    }
};

/// Vertices that are not on the analytic surface of their facets' reference, and stay where they are.
struct OffSurfacesReport {
    std::size_t vertices = 0;
    double largest = 0;  ///< distance (model units)

    static void fields(auto& s, auto& f) {
        f("vertices_off_surfaces", s.vertices,
          "number of vertices that are farther from the analytic surface of a facet's reference than 10⁻⁵ of the "
          "facet; they stay ([cad.md](algorithms/cad.md#agreement))");
        f("largest_vertex_distance", s.largest, "largest of their distances", unit("length"));
    }
};

/// Deviation of the boundary's nodes, or of its vertices, from the geometry (surface:boundary_deviation).
struct DeviationReport {
    std::size_t measured = 0, off = 0;  ///< off: farther than the tolerance
    double largest = 0;                 ///< largest distance (model units)
    double share = 0;                   ///< largest distance as a share of the local edge length
    double tolerance = 0;               ///< limit of that share
    /// Place of the largest share: the vertex or the ends of the edge, from 1 (0: none), and its coordinates.
    std::array<std::size_t, 2> vertices{};
    ReportedPlace at = {};

    [[nodiscard]] std::vector<std::size_t> named_vertices() const {
        std::vector<std::size_t> named;
        for (const std::size_t v : vertices)
            if (v != 0) named.push_back(v);
        return named;
    }
    static void fields(auto& s, auto& f) {
        f("measured", s.measured,
          "number of nodes of boundary edges, or of boundary vertices, that have a geometry; required ones stay and "
          "are not counted");
        f("beyond_tolerance", s.off, "number of those farther from it than the tolerance; the exit code is then 1");
        f("largest", s.largest, "largest distance from the geometry", unit("length"));
        f("largest_share", s.share,
          "largest distance as a share of the edge's length, of a vertex of its longest boundary edge", unit("1"));
        f("tolerance", s.tolerance, "limit of that share (`geometry_tolerance`)", unit("1"));
        f("vertices", s.named_vertices(),
          "place of the largest share: the vertex or the ends of the edge, as the file numbers them", unless_empty);
        f("point", s.at, "its coordinates", unit("length"), shown_if(s.vertices[0] != 0));
    }
};

/// Nodes of boundary edges with a target other than the projected middle.
struct BoundaryNodesReport : PlacementStatistics {
    std::string by = {};

    static void fields(auto& s, auto& f) {
        f("criterion", s.by,
          "criterion of nodes of boundary edges: `length` or `accuracy` "
          "([surface.md](algorithms/surface.md#nodes-by-length))");
        f("edges", s.edges,
          "number of boundary edges with a target: not required, and not on a line (`accuracy`: nor in a plane)");
        f("moved", s.placed, "number of edges whose node moved");
        f("no_improvement", s.best, "number of edges for which nothing better than the projected middle was found");
        f("off_geometry", s.off,
          "number of edges that keep the projected middle, since it is not on the geometry of the edge");
        f("too_far", s.far, "number of edges that keep it, since a shorter curve leaves the geometry");
        f("limited_by_elements", s.elements, "number of edges that keep it, since the elements around allow no move");
        f("on_other_facets", s.walked, "number of placed nodes on a facet of the surrogate that is not at their edge");
        f("limited", s.limited, "number of placed nodes that went a part of their way only");
        f("mean_reduction", s.mean_reduction,
          "length (`accuracy`: root mean square distance) with the projected middle by that with the node, minus 1, of "
          "the sums",
          unit("1"));
        f("largest_reduction", s.largest_reduction, "the same of one edge, at most", unit("1"));
    }
};

/// Of a mesh that was read with curves, the patches that have curves of their own.
struct CurvedPatchesReport {
    std::size_t smooth = 0, as_read = 0;
    double mean_angle = 0, largest_angle = 0;

    static void fields(auto& s, auto& f) {
        f("smooth", s.smooth,
          "number of curved patches of the input whose geometry is one smooth surface through vertices and nodes");
        f("as_read", s.as_read, "number of curved patches whose facets stay as they are in the file, with their kinks");
        f("mean_angle", s.mean_angle, "root mean square of the angle between pieces of the smooth surfaces",
          unit("degrees"));
        f("largest_angle", s.largest_angle, "largest such angle", unit("degrees"));
    }
};

/// Largest distance between the boundary in the end and its geometry, by the bound that the run requires
/// (recipes:remesh_mesh).
struct GeometryErrorReport {
    double required = 0, reached = 0;  ///< of the facet that is farthest by its bound (model units)
    std::size_t far_facets = 0;        ///< number of facets that exceed their bounds
    std::size_t facet = 0;             ///< that facet, from 1; 0: no facet has a bound
    std::vector<double> at;            ///< where it is
    bool is_required = true;           ///< by the config; else the bound is that of the expected error

    [[nodiscard]] bool is_met() const { return !(reached > required); }
    static void fields(auto& s, auto& f) {
        f("required", s.required,
          "bound on the distance between the boundary and its geometry (`--geometry-error`; with bounds by reference, "
          "of the facet whose distance is the largest share of its bound)",
          unit("length"));
        f("reached", s.reached,
          "largest such distance in the end, both ways; above `required` the exit code is 1, unless the bound is that "
          "of the expected error ([distances.md](algorithms/distances.md))",
          unit("length"));
        f("facets_beyond_bound", s.far_facets, "number of facets that exceed their bounds");
        f("facet", s.facet, "the facet of that distance, from 1; 0: no facet has a bound");
        f("point", s.at, "its position", unit("length"));
        f("origin", std::string(s.is_required ? "config" : "expected_error"),
          "`config`: the bound is that of `--geometry-error`; `expected_error`: in a cycle of `camber adapt`, the "
          "bound of the [expected error](algorithms/adaptation.md#the-geometry-and-the-error)");
    }
};

struct BoundaryReport {
    std::size_t surface_edges = 0, ridge_edges = 0, corners = 0, patches = 0;
    std::optional<double> straight_distance = {}, curved_distance = {};
    ReportedPlace curved_distance_near = {};
    std::optional<WallsReport> walls = {};
    std::optional<CadReport> cad = {};
    std::optional<DistancesReport> distances = {};
    std::optional<BoundaryNodesReport> nodes = {};
    std::optional<CurvedPatchesReport> curved_patches = {};
    std::optional<OffSurfacesReport> off_surfaces = {};
    std::optional<GeometryErrorReport> geometry_error = {};
    std::optional<DeviationReport> node_deviation = {}, vertex_deviation = {};
    std::string geometry = {};

    static void fields(auto& s, auto& f) {
        f("surface_edges", s.surface_edges,
          "number of edges on smooth pieces of the boundary (of the mesh before where a run remeshes and does not "
          "curve)");
        f("ridge_edges", s.ridge_edges, "number of edges on ridges");
        f("corners", s.corners, "number of corners");
        f("patches", s.patches, "number of smooth pieces");
        f("largest_distance_straight", s.straight_distance,
          "largest distance of the boundary of the input from the geometry (of a straight mesh: of its facets)",
          unit("length"));
        f("largest_distance", s.curved_distance,
          "largest distance of the boundary from the geometry in the end (of `cad`: from the model's faces and the "
          "other surfaces of its facets)",
          unit("length"));
        f("largest_distance_point", s.curved_distance_near, "centre of the facet with that distance", unit("length"),
          unless_empty);
        f("cad", s.cad, "relation to the CAD model");
        f.merged(s.off_surfaces);
        f("node_deviation", s.node_deviation, "nodes of boundary edges off their geometry");
        f("vertex_deviation", s.vertex_deviation, "boundary vertices off their geometry");
        f("geometry_error", s.geometry_error, "distance bound of the run");
        f("distances", s.distances, "distances both ways, by entity, with `output/distances=both`");
        f("nodes", s.nodes, "nodes of boundary edges with a target other than the projected middle");
        f("curved_patches", s.curved_patches, "curved patches of the input that passes took");
        f.merged(s.walls);
        f("geometry", s.geometry,
          "geometry of the boundary: `surrogate` (made from the mesh), `straight` (its facets), `mesh` (the boundary "
          "of another mesh), `analytic` or `cad`",
          unless_empty);
    }
};

/// Inner nodes for accuracy.
struct NodesByReport {
    std::string metric_kind;
    double size_share = 0;
    std::size_t walls = 0, metric = 0, held_back = 0;

    static void fields(auto& s, auto& f) {
        f("metric_kind", s.metric_kind, "kind of the metric that places nodes");
        f("size_share", s.size_share, "share σ of the metric’s sizes by which nodes may move", unit("1"));
        f("moved_by_walls", s.walls, "number of inner nodes that curved walls move by more than 1/1000 of the chord");
        f("moved_by_metric", s.metric, "number of inner nodes that the metric moves by more than that");
        f("limited", s.held_back,
          "number of inner nodes that move by less than half of the way to their targets, since smooth functions would "
          "lose more than `max_smooth_error_increase`");
    }
};

/// Expected errors of the solution before and after nodes were placed for it (curving).
struct ExpectedErrorsReport {
    double before = 0, after = 0;
    int rounds = 0;

    static void fields(auto& s, auto& f) {
        f("by_shape", s.before,
          "expected L2 error of the interpolated solution with nodes by the objective `shape`; all fields in units in "
          "which their ranges are about 1");
        f("by_solution", s.after, "expected error with nodes by the objective `solution`");
        f("rounds", s.rounds, "number of rounds");
    }
};

struct CurveReport : CurveStatistics {
    std::size_t edges = 0;
    EdgeReport before = {};                             ///< correction
    std::optional<NodesByReport> by = {};               ///< for accuracy
    std::optional<ExpectedErrorsReport> expected = {};  ///< of the objective solution
    std::optional<EdgeReport> after = {};
    std::optional<EdgeReport> in_straight_field = {};  ///< after correction, where the back mesh is curved
    double edges_per_second = 0;
    std::string objective = {};  ///< word of the configuration

    static void fields(auto& s, auto& f) {
        f("edges", s.edges, "number of edges");
        f("volume_edges", s.volume_edges, "number of edges inside the volume", of_volume);
        f("curved_edges", s.curved_edges, "number of edges whose node is not in the middle of the chord");
        f("pattern_searches", s.polished,
          "criteria energy and length: number of searches that stopped at a kink of the field and were completed by a "
          "pattern search",
          of_volume);
        f("not_converged", s.exhausted,
          "criteria energy and length: number of searches that reached the limit of iterations", of_volume);
        f("shortened", s.shortened,
          "criteria energy and length: number of edges that the finer rule found longer than their chords, and whose "
          "offset was reduced",
          of_volume);
        f("outside", s.outside, "number of edges with samples outside the back mesh", of_volume);
        f("not_located", s.lost, "number of edges with samples that were not located in the back mesh", of_volume);
        f("limited_nodes", s.drawn_back,
          "criterion accuracy: number of nodes in the volume, or sliding within planes, that move a part of their way "
          "or none of it, since an element would fall below `min_jacobian`",
          of_volume);
        f("edges_per_second", s.edges_per_second, "edges curved per second", unit("1/s"), of_volume);
        f("before_correction", s.before, "lengths and curvatures as `curve` proposed them");
        f("inner_nodes", s.by, "inner nodes for accuracy", of_volume);
        f("expected_error", s.expected, "expected error of the solution (objective `solution`)", of_volume);
        f("after_correction", s.after, "lengths and curvatures that `relax` left");
        f("in_straight_field", s.in_straight_field,
          "the same in the field of the straight back mesh, where the back mesh is curved", of_volume);
    }
};

struct ValidityReport {
    double bound = 0;
    bool is_asked = false;
    std::size_t invalid = 0, undecided = 0, below_bound = 0, straight_inverted = 0;
    double smallest = 1;
    std::size_t worst = 0;
    std::uint64_t worst_tag = 0;

    static void fields(auto& s, auto& f) {
        f("bound", s.bound, "lower bound of the scaled Jacobian that is required or recommended", unit("1"));
        f("bound_is_required", s.is_asked, "true: the bound is required; false: it is recommended");
        f("invalid", s.invalid, "number of elements where det J ≤ 0 at a point");
        f("undecided", s.undecided, "number of elements without a certified answer");
        f("below_bound", s.below_bound,
          "number of elements that are valid, and whose scaled Jacobian is not certified to reach the bound");
        f("straight_inverted", s.straight_inverted, "number of elements that are inverted or flat with straight edges");
        f("min_scaled_jacobian", s.smallest, "lower bound of the scaled Jacobian over all elements, to 10⁻³",
          unit("1"));
        f("worst_element", s.worst, "its element, from 1; 0: no element");
        f("worst_element_tag", s.worst_tag, "its number in the input's file, where that is another one", unless_empty);
    }
};

struct RelaxReport {
    std::string method;
    std::size_t corrected_elements = 0, raised_elements = 0;
    std::size_t relaxed_volume_edges = 0, relaxed_surface_edges = 0, slid_surface_edges = 0;
    std::size_t moved_vertices = 0, slid_vertices = 0;
    double work = 0;
    std::size_t given_up = 0;

    static void fields(auto& s, auto& f) {
        f("method", s.method,
          "method of the correction: `extension`, `cavity`, `edge`, `segment` or `backtracking` "
          "([repair.md](algorithms/repair.md))");
        f("corrected_elements", s.corrected_elements, "number of elements that the correction made valid");
        f("raised_elements", s.raised_elements,
          "number of elements, valid before, whose scaled Jacobian was raised to the target");
        f("relaxed_volume_edges", s.relaxed_volume_edges, "number of edges inside the volume whose node was moved");
        f("relaxed_surface_edges", s.relaxed_surface_edges,
          "number of boundary edges whose node was moved towards the chord");
        f("slid_surface_edges", s.slid_surface_edges,
          "number of other boundary edges whose node slid on the geometry ([cad.md](algorithms/cad.md))");
        f("moved_vertices", s.moved_vertices, "number of vertices that were moved");
        f("slid_vertices", s.slid_vertices, "number of these on the boundary, which slid on a prescribed geometry");
        f("work", s.work, "optimisation problems solved, in the unit of the option `effort`");
        f("unrepaired_elements", s.given_up, "number of elements left when that work was spent");
    }
};

/// The boundary of a mesh that was read with its curves.
struct InputBoundaryReport {
    double tolerance = 0;
    std::optional<double> sufficient_tolerance = {};
    std::size_t moved_nodes = 0;
    double largest_shift = 0, largest_relative_shift = 0;

    static void fields(auto& s, auto& f) {
        f("tolerance", s.tolerance, "of a mesh that was read with its curves: limit of the moves of boundary nodes",
          unit("length"));
        f("sufficient_tolerance", s.sufficient_tolerance,
          "where elements remain and no geometry is given: a tolerance by which all of them become valid, tried; null: "
          "none is known",
          unit("length"), or_null);
        f("moved_nodes", s.moved_nodes, "number of boundary nodes that moved");
        f("largest_shift", s.largest_shift, "largest move of a node", unit("length"));
        f("largest_relative_shift", s.largest_relative_shift, "the same by the length of the edge's chord", unit("1"));
    }
};

/// An element of such a mesh that could not be repaired.
struct RemainingReport {
    std::size_t element = 0;
    std::string reason;
    std::size_t at = 0;        ///< the vertex where it is, from 1; 0: nowhere in particular, or the reason has its name
    bool is_given_up = false;  ///< the work was spent; likewise
    std::uint64_t tag = 0;

    static void fields(auto& s, auto& f) {
        f("element", s.element, "an element that could not be repaired, from 1");
        f("tag", s.tag, "its number in the input's file, where that is another one", unless_empty);
        f("reason", s.reason, "the reason, in words; vertices as the input's file numbers them");
    }
};

struct ReinsertReport {
    std::size_t sweeps = 0, rounds = 0, patches = 0;
    std::size_t rejected_not_valid = 0, rejected_no_gain = 0;

    static void fields(auto& s, auto& f) {
        f("sweeps", s.sweeps, "sweeps of the stage `reinsert` over the vertices");
        f("rounds", s.rounds, "rounds of cavities that do not overlap");
        f("patches", s.patches, "number of cavities that were committed");
        f("rejected_not_valid", s.rejected_not_valid, "number of cavities rejected for invalid elements");
        f("rejected_no_gain", s.rejected_no_gain, "number of cavities rejected since nothing improves");
    }
};

/// Closeness of the straight form of a mesh to a unit mesh in a metric (metric:unit_mesh).
struct UnitMeshReport {
    std::string metric;
    std::size_t edges = 0;
    std::size_t unit_edges = 0, short_edges = 0, long_edges = 0;
    double shortest = 0, longest = 0, mean_length = 0;
    double worst_quality = 0, mean_quality = 0;
    std::size_t worst_element = 0;

    static void fields(auto& s, auto& f) {
        f("metric", s.metric, "the metric: a file, or its source");
        f("edges", s.edges, "number of edges");
        f("unit_edges", s.unit_edges, "number of edges of a length from 1/√2 to √2 in the metric");
        f("short_edges", s.short_edges, "number of shorter edges");
        f("long_edges", s.long_edges, "number of longer edges");
        f("shortest", s.shortest,
          "length of the shortest edge in the metric, (a − b)/ln(a/b) of its lengths a, b by the metrics of both ends; "
          "of degree 2 along the curves",
          unit("1"));
        f("longest", s.longest, "length of the longest edge in the metric", unit("1"));
        f("mean_length", s.mean_length, "mean length of edges in the metric", unit("1"));
        f("min_quality", s.worst_quality,
          "smallest mean ratio of an element in the metric: 1 unit, 0 flat; of degree 2 by the [mean "
          "distortion](algorithms/distortion.md), 0: not valid",
          unit("1"));
        f("mean_quality", s.mean_quality, "mean of these", unit("1"));
        f("worst_element", s.worst_element, "element of the smallest, from 1; 0: no element");
    }
};

/// All passes of one kind.
struct PassReport : PassStatistics {
    std::string pass = {};
    double seconds = 0;

    [[nodiscard]] std::vector<std::pair<std::string, std::size_t>> rejected_by_reason() const;
    static void fields(auto& s, auto& f) {
        f("pass", s.pass, "`collapse`, `split`, `swap`, `smooth` or `improve`: all passes of the kind together");
        f("rounds", s.rounds, "number of commits");
        f("proposals", s.proposals, "number of operations with a reason");
        f("planned", s.planned, "number of operations that satisfy the pass's own criteria of length and shape");
        f("accepted", s.accepted, "number of operations that were done");
        f("rejected", s.rejected_by_reason(),
          "number of operations that were not done, by reason: `empty`, `required`, `surface`, `line`, `ball` and "
          "`exists` (topology), `volume`, `quality`, `length`, `height`, `geometry`, `wall`, `crossing`, `gain` (no "
          "noticeable change), `deferred` (counted again later) ([cavity-operator.md](algorithms/cavity-operator.md))");
        f("corrections", s.corrections, "number of times that elements joined or left a cavity");
        f("shortened", s.shortened, "number of trials in which a point moved a part of the way to the geometry");
        f("off_target", s.drawn_back, "degree 2: number of operations with nodes off the target of the metric");
        f("neighbour_moves", s.bent_around, "degree 2: number of operations that move nodes around their cavity");
        f("optimisation_problems", s.programmes, "degree 2: number of optimisation problems solved for nodes");
        f("moved_nodes", s.moved_nodes, "degree 2: number of nodes of inner edges that `smooth` moved by distortion");
        f("straight_inverted", s.straight_inverted,
          "degree 2: number of accepted operations that a test of straight elements would reject");
        f("straight_positive", s.straight_positive,
          "degree 2: number of operations rejected as `volume` that this test would accept");
        f("farthest_facet", s.farthest_facet,
          "largest distance of a facet made by a swap or a collapse from the geometry, by its longest edge", unit("1"));
        f("seconds", s.seconds, "elapsed time", unit("s"));
    }
};

/// Objective of the nodes of inner edges of a remeshed mesh of degree 2.
struct RemeshedNodesReport {
    std::string objective;

    static void fields(auto& s, auto& f) {
        f("objective", s.objective, "degree 2: objective of the nodes of inner edges");
    }
};

/// Boundary facets where the default bound on the distance from the geometry acts.
struct BoundedFacetsReport {
    std::size_t limited = 0, far = 0;

    static void fields(auto& s, auto& f) {
        f("limited_facets", s.limited,
          "number of facets that the [default bound](algorithms/cavity-operator.md#the-default-bound) keeps finer than "
          "the metric requests (mesh whole on one process): edges below 0.73, and a distance that exceeds the bound in "
          "a facet of twice the size");
        f("facets_beyond_bound", s.far, "number of facets that exceed the bound, as facets of the mesh before did");
    }
};

struct RemeshReport {
    UnitMeshReport before, after;
    std::vector<PassReport> passes;
    std::optional<RemeshedNodesReport> nodes = {};
    std::optional<BoundedFacetsReport> bounded_facets = {};

    static void fields(auto& s, auto& f) {
        f("before", s.before, "the mesh before the passes, in the metric");
        f("after", s.after, "the mesh after the passes, in the metric");
        f("passes", s.passes, "one entry for each kind of pass");
        f("nodes", s.nodes, "nodes of inner edges");
        f("geometry_bound", s.bounded_facets, "facets where the default distance bound acts");
    }
};

struct StageTime {
    std::string stage;
    double seconds = 0;
    std::size_t peak_bytes = 0;

    static void fields(auto& s, auto& f) {
        f("stage", s.stage, "each step in order, reading and writing included");
        f("seconds", s.seconds, "elapsed time", unit("s"));
        f("peak_bytes", s.peak_bytes, "peak memory of the process until the end of this step", unit("bytes"));
    }
};

/// Blocks of a mesh that was curved by blocks.
struct BlocksReport {
    std::size_t number = 0, elements = 0, extension_iterations = 0;

    static void fields(auto& s, auto& f) {
        f("number", s.number, "number of blocks");
        f("elements", s.elements, "requested number of elements in a block");
        f("extension_iterations", s.extension_iterations,
          "number of iterations that extended the displacement of the boundary");
    }
};

/// Costs of a run on several ranks; lists have one entry per rank.
struct RanksReport {
    std::size_t number = 1, rounds = 0;
    std::vector<std::size_t> peak_bytes;
    std::vector<double> processor_seconds;
    std::vector<std::size_t> sent_bytes;

    static void fields(auto& s, auto& f) {
        f("number", s.number, "number of ranks");
        f("rounds", s.rounds, "number of exchanges between ranks");
        f("peak_bytes", s.peak_bytes, "peak memory of each rank", unit("bytes"));
        f("cpu_seconds", s.processor_seconds, "CPU time of each rank", unit("s"));
        f("sent_bytes", s.sent_bytes, "data that each rank sent", unit("bytes"));
    }
};

struct Report {
    std::optional<OriginReport> origin;
    std::optional<ReorderedReport> reordered;
    MeshReport mesh;
    std::optional<SolutionMetricReport> solution_metric;
    std::optional<MetricReport> metric;
    std::optional<RemeshReport> remesh;
    std::optional<BoundaryReport> boundary;
    std::optional<CurveReport> curve;
    std::optional<ValidityReport> validity_before, validity;
    std::optional<RelaxReport> relax;
    std::optional<InputBoundaryReport> input_boundary;
    std::vector<RemainingReport> remaining;
    std::optional<ReinsertReport> reinsert;
    std::optional<TransferReport> transfer;
    std::optional<BlocksReport> blocks;
    std::optional<RanksReport> ranks;
    OverlappingReport overlaps;
    bool committed = false;
    /// Elements, from 1, that are not certified valid in the end (all of them).
    std::vector<std::size_t> invalid_elements, undecided_elements, elements_below_bound;
    std::vector<Histogram> histograms;
    std::vector<std::string> notices;
    std::vector<StageTime> times;
    int threads = 0;  ///< that were really used

    static void fields(auto& s, auto& f) {
        f("reordered", s.reordered, "order of the mesh, where stages worked in another one");
        f("mesh", s.mesh, "the mesh in the end");
        f("solution_metric", s.solution_metric, "the metric that was made for the solution");
        f("metric", s.metric, "the metric");
        f("remesh", s.remesh, "passes that changed the mesh");
        f("boundary", s.boundary, "the boundary and its geometry");
        f("curve", s.curve, "the stage `curve`");
        f("validity_before_correction", s.validity_before, "verdicts of the elements that `curve` proposed");
        f("relax", s.relax, "the stage `relax`");
        f("input_boundary", s.input_boundary, "boundary of a mesh that was read with its curves");
        f("remaining_elements", only_if(s.input_boundary || !s.remaining.empty(), s.remaining),
          "elements that could not be repaired");
        f("reinsert", s.reinsert, "the stage `reinsert`");
        f("validity", s.validity, "verdicts of the elements in the end");
        f("overlaps", only_if(s.overlaps.overlapping > 0, s.overlaps), "elements of the result that overlap");
        f("transfer", s.transfer, "fields of the solution on the new mesh ([transfer.md](algorithms/transfer.md))");
        f("blocks", s.blocks, "blocks of a mesh that was curved by blocks");
        f("ranks", s.ranks, "costs of each rank");
        f("histograms", s.histograms, "see below", unless_empty);
        f("invalid_elements", s.invalid_elements, "elements that are not valid in the end, from 1");
        f("undecided_elements", s.undecided_elements, "elements without a certified answer, from 1");
        f("elements_below_bound", s.elements_below_bound, "valid elements below the bound, from 1");
        f("committed", s.committed, "true: `commit` made the proposed positions the mesh's");
        f("notices", s.notices, "notes on what was corrected, left out or lost, a sentence each");
        f("misses", misses(s),
          "reasons for which the result is not the requested one, a sentence each with its place; empty: the exit code "
          "is "
          "0");
        f("threads", s.threads, "number of threads that were used");
        f("stages", s.times, "steps with their times");
    }

    /// True if every element is certified valid, above the bound where one is requested.
    [[nodiscard]] bool has_valid_elements() const {
        return !validity || (validity->invalid == 0 && validity->undecided == 0 &&
                             (validity->below_bound == 0 || !validity->is_asked));
    }
    /// Number of elements that are not certified valid, above the bound where one is requested.
    [[nodiscard]] std::size_t not_valid() const {
        if (!validity) return 0;
        return validity->invalid + validity->undecided + (validity->is_asked ? validity->below_bound : 0);
    }
    /// True if no boundary node or vertex is off its geometry by more than the tolerance.
    [[nodiscard]] bool boundary_holds() const {
        const auto holds = [](const std::optional<DeviationReport>& d) { return !d || d->off == 0; };
        return !boundary || (holds(boundary->node_deviation) && holds(boundary->vertex_deviation));
    }
    /// True if no walls pass through each other.
    [[nodiscard]] bool walls_hold() const { return !boundary || !boundary->walls || boundary->walls->crossing == 0; }
    /// True if the boundary is as near to its geometry as `--geometry-error` requires.
    [[nodiscard]] bool keeps_geometry_error() const {
        return !boundary || !boundary->geometry_error || !boundary->geometry_error->is_required ||
               boundary->geometry_error->is_met();
    }
    /// True if the result is the requested one: the exit code is 0.
    [[nodiscard]] bool holds_what_was_asked() const {
        return has_valid_elements() && boundary_holds() && keeps_geometry_error() && walls_hold() &&
               overlaps.overlapping == 0;
    }
};

/// A number with a space between groups of three digits: "1 234 567".
[[nodiscard]] std::string grouped(std::size_t n);
/// A position in four digits: "(0.5, 1.25)".
[[nodiscard]] std::string place_text(const ReportedPlace& place);
/// A lower bound in four digits, and an upper one: the text is not above the former, not below the latter.
[[nodiscard]] std::string lower_bound_text(double x);
[[nodiscard]] std::string upper_bound_text(double x);

/// One sentence for each cause for which a result is not the requested one, with its place; empty if it is.
[[nodiscard]] std::vector<std::string> misses(const Report& report);

/// Elements that are valid, but below the recommended bound; empty if there are none or the bound is requested.
[[nodiscard]] std::string recommended_bound_note(const Report& report);
/// "16 pairs of boundary triangles pass through each other …"; empty where no walls cross.
[[nodiscard]] std::string crossing_message(const WallsReport& walls, int dimension);
/// "elements overlap in 3 places …"; empty where none do.
[[nodiscard]] std::string overlap_message(const Report& report);

}  // namespace camber::run

/// Parts of the report that several steps add.
export namespace camber::run {

using Notices = std::vector<std::string>;

/// Of all elements, at the bound asked for.
struct VerdictsReport {
    ValidityReport summary;
    std::vector<std::size_t> invalid, undecided, below_bound;  ///< elements, from 1
};
/// `is_asked`: whether somebody did for the bound.
template <int D>
[[nodiscard]] VerdictsReport verdicts_report(const Validation<D>& validation, bool is_asked);

/// What a repair came to; `given_up`: elements on which the work was spent in vain.
[[nodiscard]] RelaxReport relax_report(const RepairStatistics& statistics, std::size_t given_up, RepairMethod method);

/// Reports nodes that were moved back because walls crossed.
template <int D>
[[nodiscard]] RelaxedWallsReport relaxed_walls_report(const MovedBack<D>& moved) {
    return {moved.nodes, moved.largest, {moved.largest_at.c.begin(), moved.largest_at.c.end()}};
}

/// Of a correction.
struct CorrectionReport {
    RelaxReport relax;
    std::optional<InputBoundaryReport> input_boundary;
    std::vector<RemainingReport> remaining;
};

/// Adds a description of the boundary, with notices.
void add(Report& report, const BoundaryReport& part);
void add(Report& report, VerdictsReport part);
/// Adds a correction; counts of several corrections are summed.
void add(Report& report, const CorrectionReport& part);
/// Adds a pass; counts of passes of one kind are summed.
void add(Report& report, const PassReport& part);
void add(std::vector<Histogram>& all, std::vector<Histogram> part);

}  // namespace camber::run

/// How near to unit a straight mesh is in a metric: `camber check --metric`, and before and after passes that change
/// it.
export namespace camber::run {

/// The report, and what it counts, one a unique edge and one an element.
struct UnitMesh {
    UnitMeshReport report;
    std::vector<double> lengths, qualities;
};

/// Of lengths, one an edge, and qualities, one an element.
[[nodiscard]] UnitMeshReport unit_mesh_report(std::string metric, const std::vector<double>& lengths,
                                              const std::vector<double>& qualities);

/// `metric`: the name of what the logs, one a vertex, are.
template <int D>
[[nodiscard]] Outcome<UnitMesh> measure_unit_mesh(const LinearMesh<D>& mesh, const EdgeSet<D>& edges,
                                                  const Column<LogMetric<D>>& log_metrics, std::string metric,
                                                  const Execution& execution);

/// Of a mesh of degree 2: along its curves, and by the mean distortion of its elements.
template <int D>
[[nodiscard]] Outcome<UnitMesh> measure_unit_mesh(const QuadraticMesh<D>& mesh, const Column<LogMetric<D>>& log_metrics,
                                                  std::string metric, const Execution& execution);

/// Its histograms, by one series of that name each.
[[nodiscard]] std::vector<Histogram> histograms_of(const UnitMesh& measured, const std::string& series);

}  // namespace camber::run

/// How near to unit a mesh of degree 2 is in a metric, along its curves: `camber check --metric`.
export namespace camber::run {

struct CurvedUnitMeshReport {
    /// Quality of an element.
    struct Element {
        std::size_t number = 0;
        double quality = 0, least = 0, bound = 0;

        static void fields(auto& s, auto& f) {
            f("element", s.number, "element, from 1");
            f("quality", s.quality, "its quality by the mean distortion", unit("1"));
            f("least", s.least, "lowest quality that was found at a point", unit("1"));
            f("bound", s.bound, "certified lower bound of its quality at all points", unit("1"));
        }
    };
    UnitMeshReport unit_mesh;  ///< lengths along the curves, mean qualities
    Element lowest;            ///< of the lowest quality at a point; its number 0: no element
    double bound = 0;
    std::vector<Element> worst;  ///< of the lowest mean qualities, the worst first

    static void fields(auto& s, auto& f) {
        f.merged(s.unit_mesh);
        f("bound", only_if(s.lowest.number > 0, s.bound),
          "certified lower bound of the quality (with the sign of det J) at all points of the mesh; −1: no bound above "
          "0 was found",
          unit("1"));
        f("lowest", only_if(s.lowest.number > 0, s.lowest), "element of the lowest quality at a point");
        f("worst", s.worst, "elements of the lowest mean qualities, the worst first, as many as `worst`");
    }
};

/// The report, and what it counts, one a unique edge and one an element.
struct CurvedUnitMesh {
    CurvedUnitMeshReport report;
    std::vector<double> lengths, qualities;
};

/// `metric`: the name of what the logs, one a vertex, are; `worst`: how many elements to name.
template <int D>
[[nodiscard]] Outcome<CurvedUnitMesh> measure_curved_unit_mesh(const QuadraticMesh<D>& mesh,
                                                               const Column<LogMetric<D>>& log_metrics,
                                                               std::string metric, std::size_t worst,
                                                               const Execution& execution);

[[nodiscard]] std::vector<Histogram> histograms_of(const CurvedUnitMesh& measured, const std::string& series);

/// Of a mesh that ranks share: as of one as a whole, but for the last digits of means, which are summed rank by rank.
struct UnitMeshOfRanks {
    UnitMeshReport report;
    std::vector<Histogram> histograms;
};
/// Errors: of any rank.
[[nodiscard]] Outcome<UnitMeshOfRanks> unit_mesh_of_ranks(std::string metric, const MeasuredRows& own, Ranks& ranks);

}  // namespace camber::run
