module;
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>
export module camber.recipes:boundary_report;
import camber.core;
import camber.curving;
import :fields;
import :measurements;

/// Reports on the boundary of a mesh and its geometry.
export namespace camber::run {

/// Position on the boundary; empty: none.
using ReportedPlace = std::vector<double>;

struct RelaxedWallsReport {
    std::size_t nodes = 0;
    double largest = 0;
    ReportedPlace largest_at = {};

    static void fields(auto& s, auto& f) {
        f("nodes", s.nodes,
          "number of boundary nodes that `curve` moved back towards their chords so that no boundary facets cross");
        f("largest_distance", s.largest, "largest distance of such a node from its target", unit("length"));
        f("point", s.largest_at, "position of that node", unit("length"));
    }
};

struct FirstCrossing {
    std::array<std::size_t, 2> facets{};
    ReportedPlace near;

    static void fields(auto& s, auto& f) {
        f("facets", s.facets, "first pair of facets that cross, from 1; any such pair makes the exit code 1");
        f("point", s.near, "centre of the overlap of the bounding boxes of the two facets", unit("length"));
    }
};

/// Pairs of facets that cross in the result (crossing:crossings).
struct WallsReport {
    std::size_t crossing = 0, touching = 0, undecided = 0;
    std::size_t first = 0, other = 0;  ///< facets of the first crossing pair, from 1; 0: none
    ReportedPlace first_at = {};
    std::size_t crossing_before = 0;
    std::optional<RelaxedWallsReport> relaxed = {};

    static void fields(auto& s, auto& f) {
        f("crossing_pairs", s.crossing,
          "number of pairs of facets that pass through each other in the result "
          "([crossing.md](algorithms/crossing.md))");
        f("touching_pairs", s.touching, "number of pairs of facets that touch");
        f("undecided_pairs", s.undecided, "number of pairs of facets that are too close for a certified answer");
        f("first_crossing", only_if(s.crossing > 0, FirstCrossing{{s.first, s.other}, s.first_at}),
          "first pair that crosses");
        f("crossing_pairs_of_input", s.crossing_before, "number of pairs that already crossed in the input",
          unless_empty);
        f("relaxed_for_crossing", s.relaxed, "boundary nodes that were moved back so that no boundary facets cross");
    }
};

struct OverlappingReport {
    std::size_t overlapping = 0;
    std::vector<double> point;

    static void fields(auto& s, auto& f) {
        f("overlapping", s.overlapping,
          "number of places where elements of the result overlap; the exit code is then 1 "
          "([crossing.md](algorithms/crossing.md#elements-that-overlap))");
        f("point", s.point, "one of these places", unit("length"));
    }
};

struct CadMovesReport {
    std::size_t moved = 0, constrained = 0;
    double largest = 0;

    static void fields(auto& s, auto& f) {
        f("moved_vertices", s.moved,
          "with `geometry/cad/vertices` = `move`: number of vertices that were moved onto the model before the first "
          "stage");
        f("partly_moved_vertices", s.constrained,
          "number of vertices that were moved only a part of the way, since an element would have become flat");
        f("largest_vertex_move", s.largest, "largest of these moves", unit("length"));
    }
};

struct JoinedFacesReport {
    bool are_edges = false;
    std::vector<std::vector<std::size_t>> lists = {};

    static void fields(auto& s, auto& f) {
        f("virtual_faces", s.lists,
          "groups of faces (2D: edges) of the model that meet smoothly and that the mesh treats as one, by numbers "
          "from 1 ([cad.md](algorithms/cad.md#virtual-faces))",
          unless_empty);
    }
};

struct AcrossRidgesReport {
    std::size_t count = 0;
    std::size_t first = 0;
    std::vector<double> place = {};

    static void fields(auto& s, auto& f) {
        f("facets_across_ridges", s.count, "number of facets that span a ridge of the model", unless_empty);
        f("first_facet_across_ridges", s.first, "first of these facets, from 1", unless_empty);
        f("first_ridge_point", s.place, "point of the ridge that this facet spans", unit("length"), unless_empty);
    }
};

struct CadReport {
    std::string mesh_unit, file_unit;
    bool is_in_file_unit = true;
    bool is_unit_found = false;
    std::size_t faces = 0, edges = 0, vertices = 0;
    std::size_t faces_met = 0, edges_met = 0, vertices_met = 0;
    std::size_t facets = 0, analytic_facets = 0, surrogate_facets = 0;
    std::vector<Reference> within_materials = {};
    std::size_t coincident_facets = 0;
    std::size_t ambiguous_facets = 0, settled_facets = 0, ambiguous_edges = 0, ambiguous_vertices = 0;
    double largest_vertex_distance = 0;
    std::optional<double> largest_node_distance;
    std::optional<CadMovesReport> moves = {};
    std::size_t lost_faces = 0, failed_entities = 0, open_shells = 0;
    JoinedFacesReport joined = {};
    AcrossRidgesReport across = {};

    static void fields(auto& s, auto& f) {
        f("unit", s.mesh_unit,
          "unit of the mesh's coordinates, to which the model is converted ([cad.md](algorithms/cad.md))");
        f("file_unit", s.file_unit, "unit in the CAD file; empty: the file names none (mm)");
        f("unit_found", s.is_unit_found, "true: `auto` selected another unit than that of the file");
        f("faces", s.faces, "number of faces of the CAD model");
        f("edges", s.edges, "number of edges of the CAD model");
        f("vertices", s.vertices, "number of vertices of the CAD model");
        f("failed_faces", s.lost_faces, "number of faces of the CAD file for which no surface could be made");
        f("failed_entities", s.failed_entities, "number of entities of the CAD file whose transfer failed");
        f("open_shells", s.open_shells, "number of open shells of solids");
        f("matched_faces", s.faces_met, "number of faces of the model with facets of the mesh on them");
        f("matched_edges", s.edges_met, "number of edges of the model with edges of the mesh on them");
        f("matched_vertices", s.vertices_met, "number of vertices of the model with a vertex of the mesh on them");
        f("facets", s.facets, "number of facets of the mesh on the model, by `geometry/cad`");
        f("analytic_facets", s.analytic_facets, "number of facets on analytic surfaces");
        f("surrogate_facets", s.surrogate_facets, "number of facets on the surrogate");
        f("coincident_facets", s.coincident_facets,
          "number of facets where two faces of the model coincide (solids that touch); they are assigned to the first "
          "of them");
        f("ambiguous_facets", s.ambiguous_facets,
          "number of facets for which two faces that do not meet smoothly fit almost equally well");
        f("resolved_facets", s.settled_facets,
          "number of these facets that were assigned by the other facets of their "
          "reference");
        f("ambiguous_edges", s.ambiguous_edges,
          "number of edges between facets of two faces that have no common edge nearby");
        f("ambiguous_vertices", s.ambiguous_vertices,
          "number of vertices where three or more faces meet, without a vertex of the model nearby");
        f("largest_vertex_distance", s.largest_vertex_distance,
          "largest distance of a boundary vertex from its CAD entity: in the final mesh if passes changed it, else in "
          "the input",
          unit("length"));
        f("references_within_materials", s.within_materials,
          "references of facets that lie within one material and not on the model. These facets have no CAD geometry "
          "and are counted in `surrogate_facets`",
          unless_empty);
        f("largest_node_distance", s.largest_node_distance,
          "largest distance of a node of a boundary edge on the model from its CAD entity, in the result",
          unit("length"));
        f.merged(s.joined);
        f.merged(s.across);
        f.merged(s.moves);
    }
};

struct OffSurfacesReport {
    std::size_t vertices = 0;
    double largest = 0;

    static void fields(auto& s, auto& f) {
        f("vertices_off_surfaces", s.vertices,
          "number of vertices whose distance from the analytic surface of a facet's reference exceeds 10⁻⁵ of the "
          "facet; they are not moved ([cad.md](algorithms/cad.md#agreement))");
        f("largest_vertex_distance", s.largest, "largest of these distances", unit("length"));
    }
};

/// Distances of boundary nodes, or of boundary vertices, from the geometry (surface:boundary_deviation).
struct DeviationReport {
    std::size_t measured = 0, off = 0;
    double largest = 0;
    double share = 0;
    double tolerance = 0;
    /// Vertex, or ends of the edge, with the largest share, from 1 (0: none), and its coordinates.
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
          "number of nodes of boundary edges, or of boundary vertices, that have a geometry. Required ones are fixed "
          "and not counted");
        f("beyond_tolerance", s.off,
          "number of these that are farther from the geometry than the tolerance; if there "
          "are any, the exit code is 1");
        f("largest", s.largest, "largest distance from the geometry", unit("length"));
        f("largest_share", s.share,
          "largest distance relative to the edge's length (vertex: to its longest boundary edge)", unit("1"));
        f("tolerance", s.tolerance, "limit of `largest_share` (`geometry_tolerance`)", unit("1"));
        f("vertices", s.named_vertices(),
          "place of the largest share: the vertex, or the ends of the edge, with the numbers of the file",
          unless_empty);
        f("point", s.at, "its coordinates", unit("length"), shown_if(s.vertices[0] != 0));
    }
};

struct BoundaryNodesReport : PlacementStatistics {
    std::string by = {};

    static void fields(auto& s, auto& f) {
        f("criterion", s.by,
          "criterion for nodes of boundary edges: `length` or `accuracy` "
          "([surface.md](algorithms/surface.md#nodes-by-length))");
        f("edges", s.edges,
          "number of boundary edges with a target: neither required nor on a line (`accuracy`: nor in a plane)");
        f("moved", s.placed, "number of edges whose node was moved");
        f("no_improvement", s.best, "number of edges for which no position better than the projected middle was found");
        f("off_geometry", s.off,
          "number of edges that have the projected middle, since their node was off the geometry of the edge");
        f("too_far", s.far,
          "number of edges that have the projected middle, since a shorter curve would leave the "
          "geometry");
        f("limited_by_elements", s.elements,
          "number of edges that have the projected middle, since the adjacent "
          "elements allow no move");
        f("on_other_facets", s.walked,
          "number of moved nodes on a facet of the surrogate that is not adjacent to "
          "their edge");
        f("limited", s.limited, "number of moved nodes that went only a part of the way to their target");
        f("mean_reduction", s.mean_reduction,
          "summed length (`accuracy`: root mean square distance) with the projected middles, divided by that with the "
          "final nodes, minus 1",
          unit("1"));
        f("largest_reduction", s.largest_reduction, "largest such value of a single edge", unit("1"));
    }
};

struct CurvedPatchesReport {
    std::size_t smooth = 0, as_read = 0;
    double mean_angle = 0, largest_angle = 0;

    static void fields(auto& s, auto& f) {
        f("smooth", s.smooth,
          "number of curved patches of the input whose geometry is one smooth surface through vertices and nodes");
        f("as_read", s.as_read, "number of curved patches that are used as in the file, with kinks between facets");
        f("mean_angle", s.mean_angle, "root mean square of the angle between pieces of the smooth surfaces",
          unit("degrees"));
        f("largest_angle", s.largest_angle, "largest such angle", unit("degrees"));
    }
};

struct GeometryErrorReport {
    double required = 0, reached = 0;
    std::size_t far_facets = 0;
    std::size_t facet = 0;
    std::vector<double> at;
    bool is_required = true;  ///< true: the config sets the bound; false: the expected error does

    [[nodiscard]] bool is_met() const { return !(reached > required); }
    static void fields(auto& s, auto& f) {
        f("required", s.required,
          "bound on the distance between the boundary and its geometry (`--geometry-error`). With bounds by reference: "
          "the bound of the facet with the largest ratio of distance to bound",
          unit("length"));
        f("reached", s.reached,
          "largest distance in the result, in both directions. Above `required` the exit code is 1, unless the bound "
          "is that of the expected error ([distances.md](algorithms/distances.md))",
          unit("length"));
        f("facets_beyond_bound", s.far_facets, "number of facets that exceed their bounds");
        f("facet", s.facet, "facet with that distance, from 1; 0: no facet has a bound");
        f("point", s.at, "its position", unit("length"));
        f("origin", std::string(s.is_required ? "config" : "expected_error"),
          "`config`: the bound is that of `--geometry-error`; `expected_error`: in a cycle of `camber adapt`, the "
          "bound is that of the [expected error](algorithms/adaptation.md#the-geometry-and-the-error)");
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
          "number of edges on smooth pieces of the boundary. If a run remeshes and does not curve, the mesh before is "
          "counted");
        f("ridge_edges", s.ridge_edges, "number of edges on ridges");
        f("corners", s.corners, "number of corners");
        f("patches", s.patches, "number of smooth pieces");
        f("largest_distance_straight", s.straight_distance,
          "largest distance of the input's boundary from the geometry (straight mesh: of its facets)", unit("length"));
        f("largest_distance", s.curved_distance,
          "largest distance of the result's boundary from the geometry (`cad`: from the model's faces and the other "
          "surfaces of its facets)",
          unit("length"));
        f("largest_distance_point", s.curved_distance_near, "centre of the facet with that distance", unit("length"),
          unless_empty);
        f("cad", s.cad, "relation of the boundary to the CAD model");
        f.merged(s.off_surfaces);
        f("node_deviation", s.node_deviation, "distances of nodes of boundary edges from their geometry");
        f("vertex_deviation", s.vertex_deviation, "distances of boundary vertices from their geometry");
        f("geometry_error", s.geometry_error, "bound on the distance of the boundary from its geometry");
        f("distances", s.distances, "distances in both directions and by entity, with `output/distances=both`");
        f("nodes", s.nodes, "nodes of boundary edges with a target other than the projected middle");
        f("curved_patches", s.curved_patches, "curved patches of the input, if passes change the mesh");
        f.merged(s.walls);
        f("geometry", s.geometry,
          "geometry of the boundary: `surrogate` (made from the mesh), `straight` (its facets), `mesh` (the boundary "
          "of another mesh), `analytic` or `cad`",
          unless_empty);
    }
};

}  // namespace camber::run
