module;
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>
export module camber.recipes:inspection;
import camber.core;
import camber.io;
import camber.surface;
import :check;
import :fields;
import :measurements;
import :report;
import :state;
import :values;

/// The boundary of a mesh, and its distance from a geometry: `camber geometry`.
export namespace camber::run {

struct InspectOptions {
    double ridge_angle = FeatureOptions<3>{}.ridge_angle_degrees;
    std::size_t worst = 10;

    [[nodiscard]] static constexpr auto options() {
        using S = InspectOptions;
        return std::tuple(
            option("ridge_angle", &S::ridge_angle, "angle (degrees) above which two facets form a ridge")
                .above(0)
                .at_most(180),
            option("worst", &S::worst, "number of patches, ridges and suspicious places of each kind to show")
                .at_least(0)
                .at_most(1000000));
    }
};

struct HingeReport {
    std::vector<std::size_t> vertices;
    std::vector<double> point;
    std::vector<std::size_t> facets;

    static void fields(auto& s, auto& f) {
        f("vertices", s.vertices, "its vertices, with the numbers of the file");
        f("point", s.point, "its centre", unit("length"));
        f("facets", s.facets, "facets there, from 1");
    }
};

struct HingesReport {
    std::size_t count = 0;
    std::vector<HingeReport> first;

    static void fields(auto& s, auto& f) {
        f("count", s.count, "number of them");
        f("first", s.first, "first of them, at most `--worst`");
    }
};

/// A suspicious place.
struct PlaceReport {
    HingeReport at;
    double value = 0;
    std::string text;

    static void fields(auto& s, auto& f) {
        f.merged(s.at);
        f("value", s.value, "angle; for `ambiguous_facet` the misfit of the best face", unit("degrees; length"));
        f("text", s.text, "place and value in words");
    }
};

struct PlacesReport {
    std::string text;
    std::size_t count = 0;
    std::vector<PlaceReport> worst;

    static void fields(auto& s, auto& f) {
        f("count", s.count, "number of them");
        f("text", s.text, "description of the kind");
        f("worst", s.worst, "worst of them, at most `--worst`");
    }
};

struct PatchReport : PatchFacts {
    std::size_t number = 0;
    std::optional<std::vector<std::size_t>> cad_faces, cad_edges;

    static void fields(auto& s, auto& f) {
        f("patch", s.number, "its number, from 1");
        f("references", s.references, "references of its facets");
        f("facets", s.facets, "number of its facets");
        f("interface_facets", s.interface_facets, "number of its facets with elements on both sides");
        f("area", s.area, "area (2D: length) of its straight facets", unit("length^(D−1)"));
        f("size", s.size, "diagonal of the bounding box of its facets", unit("length"));
        f("flat", s.is_flat, "true: it lies in one plane (2D: on one line) up to 1e-12 of its size");
        f("cad_faces", s.cad_faces, "with a CAD model: faces of the model on which its facets lie, from 1");
        f("cad_edges", s.cad_edges, "with a CAD model in 2D: edges of the model on which its facets lie, from 1");
    }
};

struct RidgeReport : CurveFacts {
    std::size_t number = 0;

    static void fields(auto& s, auto& f) {
        f("ridge", s.number, "its number, from 1");
        f("references", s.references, "references of the adjacent facets");
        f("edges", s.edges, "number of its edges");
        f("length", s.length, "length of its straight edges", unit("length"));
        f("min_turn", s.min_turn, "smallest angle between its facets", unit("degrees"));
        f("largest_turn", s.largest_turn, "largest such angle", unit("degrees"));
    }
};

struct CornerReport {
    std::size_t vertex = 0;
    std::vector<double> point;

    static void fields(auto& s, auto& f) {
        f("vertex", s.vertex, "its vertex, with the number of the file");
        f("point", s.point, "its position", unit("length"));
    }
};

struct GeometryReport {
    MeshReport mesh;
    bool is_listed = true;
    double ridge_angle = 0;
    std::vector<PatchReport> patches;
    std::vector<RidgeReport> ridges;
    std::vector<CornerReport> corners;
    std::size_t smooth_listed_edges = 0, interface_facets = 0, isolated_facets = 0;
    HingesReport open, crowded, turned;
    std::vector<std::pair<std::string, PlacesReport>> warnings;
    std::optional<CadReport> cad;
    std::optional<DistancesReport> distances;
    std::size_t worst = 0;
    std::vector<std::string> notices;

    static void fields(auto& s, auto& f) {
        f.merged(s.mesh, without({"nodes", "feature_edges", "standalone_surface"}));
        f("boundary_is_listed", s.is_listed, "false: the file lists no facets; they were computed and have no numbers");
        f("ridge_angle", s.ridge_angle, "angle above which two facets form a ridge", unit("degrees"));
        f("patches", s.patches, "smooth pieces of the boundary (2D: curves)");
        f("ridges", s.ridges, "chains of ridge edges between corners (3D)");
        f("corners", s.corners, "corners of the boundary");
        f("smooth_listed_edges", s.smooth_listed_edges, "number of edges that the file lists and that are no ridges");
        f("interface_facets", s.interface_facets, "number of facets with elements on both sides");
        f("isolated_facets", s.isolated_facets,
          "number of facets without elements on either side, if the mesh has elements");
        f("open_edges", s.open, "edges (2D: vertices) with only one facet");
        f("non_manifold_edges", s.crowded, "edges (2D: vertices) with more than two facets");
        f("misoriented_facets", s.turned, "edges between two facets of opposite orientation");
        f("suspicious", s.warnings,
          "suspicious places by kind: `near_ridge`, `mild_ridge`, `knife_edge`, `tip`, `spread_normals`, "
          "`turned_facet`; with a CAD model `ambiguous_facet`");
        f("cad", s.cad, "with a CAD model: relation to it");
        f("geometry", (s.distances ? std::optional(s.distances->geometry) : std::nullopt),
          "geometry of the distances, in words");
        f("distances", s.distances, "distances in both directions, by entity");
        f("notices", s.notices, "notes on the input, one sentence each");
    }
};

enum class InspectedSurface { none, lattice };

struct ComparedGeometry {
    config::Geometry geometry = config::Surrogate{};
    GeometrySource source = {};
    InspectedSurface surface = InspectedSurface::none;
};

/// The report, and the mesh with fields: `patch`, `distance_to_geometry` and `distance_to_boundary` on facets,
/// `node_kind` on nodes.
struct Inspected {
    GeometryReport report;
    AnyMesh mesh;
    MeshFields fields;
    std::optional<SurfaceMesh> surface = {};  ///< if it is requested
};
[[nodiscard]] Outcome<Inspected> inspect_geometry(DecodedMesh mesh, const ComparedGeometry& geometry,
                                                  const InspectOptions& options, const StepWrapper& around);

struct FieldInfo {
    std::string name;
    std::string_view at, kind;

    static void fields(auto& s, auto& f) {
        f("name", s.name, "name of the field");
        f("at", s.at, "`nodes` or `cells`");
        f("kind", s.kind, "`scalar`, `vector`, `symmetric tensor` or `full tensor`");
    }
};

struct MeshInfo {
    int dimension = 3, degree = 1;
    std::size_t vertices = 0;
    std::optional<std::array<std::vector<double>, 2>> box = {};
    std::size_t tetrahedra = 0, triangles = 0, edges = 0;
    ReferenceCounts tetrahedra_by_reference, triangles_by_reference, edges_by_reference;
    std::size_t ridges = 0, corners = 0, required_vertices = 0, required_edges = 0, required_triangles = 0;
    Groups groups;
    std::size_t normals = 0, tangents = 0;
    bool is_empty = false;
    std::size_t mid_nodes = 0;
    std::vector<std::pair<std::string, std::size_t>> unsupported_cells;
    std::string split;  ///< advice for converting these cells
    std::vector<FieldInfo> mesh_fields;
    std::optional<int> written_in_dimension;
    std::optional<double> z;
    std::vector<std::string> notices;

    static void fields(auto& s, auto& f) {
        f("dimension", s.dimension, "2 or 3");
        f("degree", s.degree, "degree of the elements");
        f("vertices", s.vertices, "number of vertices");
        f("box", s.box, "minimum and maximum coordinates of the vertices", unit("length"));
        f("tetrahedra", s.tetrahedra, "3D: number of tetrahedra", shown_if(s.dimension == 3));
        f("tetrahedra_by_reference", s.tetrahedra_by_reference, "their numbers by reference",
          shown_if(s.dimension == 3));
        f("triangles", s.triangles, "number of triangles");
        f("triangles_by_reference", s.triangles_by_reference, "their numbers by reference");
        f("edges", s.edges, "number of listed edges");
        f("edges_by_reference", s.edges_by_reference, "their numbers by reference");
        f("ridges", s.ridges, "number of ridges");
        f("corners", s.corners, "number of corners");
        f("required_vertices", s.required_vertices, "number of required vertices");
        f("required_edges", s.required_edges, "number of required edges");
        f("required_triangles", s.required_triangles, "3D: number of required triangles", shown_if(s.dimension == 3));
        f("groups", s.groups, "names of references", unless_empty);
        f("normals", s.normals, "number of normals");
        f("tangents", s.tangents, "number of tangents");
        f("empty", s.is_empty, "true: the mesh has neither elements nor facets");
        f("mid_nodes", s.mid_nodes, "degree 2: number of nodes of edges", shown_if(s.degree == 2));
        f("not_held", s.unsupported_cells, "number of cells of unsupported kinds", unless_empty);
        f("split", s.split, "advice for converting these cells", unless_empty);
        f("fields", s.mesh_fields, "fields of the file", unless_empty);
        f("written_in_dimension", s.written_in_dimension, "flat mesh in space: 3");
        f("z", s.z, "flat mesh in space: its third coordinate", unit("length"));
        f("notices", s.notices, "notes on the input, one sentence each");
    }
};
[[nodiscard]] MeshInfo mesh_info(const DecodedMesh& mesh);

struct SolutionInfo {
    int dimension = 3;
    std::size_t vertices = 0;
    std::vector<std::string_view> kinds;
    std::vector<std::string> notices;

    static void fields(auto& s, auto& f) {
        f("dimension", s.dimension, "2 or 3");
        f("vertices", s.vertices, "number of rows");
        f("fields", s.kinds, "kinds of the fields");
        f("notices", s.notices, "notes on the input, one sentence each");
    }
};
[[nodiscard]] SolutionInfo solution_info(const DecodedSolution& solution);

using FileInfo = std::variant<MeshInfo, SolutionInfo>;

}  // namespace camber::run
