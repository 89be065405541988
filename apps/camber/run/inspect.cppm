module;
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>
export module camber.run:inspect;
import camber.core;
import camber.cad;
import camber.config;
import camber.io;
import camber.surface;
import :geometry_source;
import :distances_report;
import :pipeline;
import :report;
import :runner;
import :surface_mesh;

/// What the boundary of a mesh is, and how far it is from a geometry: `camber geometry`.
export namespace camber::run {

struct InspectOptions {
    double ridge_angle = FeatureOptions<3>{}.ridge_angle_degrees;
    std::size_t worst = 10;

    [[nodiscard]] static constexpr auto options() {
        using S = InspectOptions;
        return std::tuple(
            option("ridge_angle", &S::ridge_angle, "facets that meet at more than this angle (degrees) make a ridge")
                .above(0)
                .at_most(180),
            option("worst", &S::worst, "how many patches, ridges and suspicious places of a kind to show")
                .at_least(0)
                .at_most(1000000));
    }
};

/// An edge or vertex of the boundary, as the file numbers vertices.
struct HingeReport {
    std::vector<std::size_t> vertices;
    std::vector<double> point;
    std::vector<std::size_t> facets;  ///< from 1
};

/// A place where something may be wrong. Of angles in degrees, of a doubtful facet by how much its best face misses
/// (model units).
struct PlaceReport {
    HingeReport at;
    double value = 0;
    std::string text;
};
/// All places of a kind: how many, and the worst.
struct PlacesReport {
    std::string kind, text;
    std::size_t count = 0;
    std::vector<PlaceReport> worst;
};
/// Edges of the boundary that are wrong or rare: how many, and the first.
struct HingesReport {
    std::size_t count = 0;
    std::vector<HingeReport> first;
};

struct PatchReport {
    PatchFacts facts;
    std::vector<std::size_t> cad_faces;  ///< that its facets lie on, in 2D edges, from 1
};

struct CornerReport {
    std::size_t vertex = 0;
    std::vector<double> point;
};

struct GeometryReport {
    MeshReport mesh;
    bool is_listed = true;  ///< false: the file has no boundary, and it was made
    double ridge_angle = 0;
    std::vector<PatchReport> patches;
    std::vector<CurveFacts> ridges;
    std::vector<CornerReport> corners;
    std::size_t smooth_listed_edges = 0, interface_facets = 0, lone_facets = 0;
    HingesReport open, crowded, turned;
    std::vector<PlacesReport> suspicious;
    std::optional<CadReport> cad;
    std::optional<DistancesReport> distances;
    std::size_t worst = 0;  ///< how many are shown
    std::vector<std::string> notices;
};

/// What is made beside the report.
enum class InspectedSurface { none, lattice };

/// What the boundary is compared with.
struct ComparedGeometry {
    config::Geometry geometry = config::Surrogate{};
    GeometrySource source = {};
    InspectedSurface surface = InspectedSurface::none;
};

/// The report, and the mesh with the fields that show it: `patch`, `distance_to_geometry` and `distance_to_boundary`
/// of facets, `node_kind` of nodes.
struct Inspected {
    GeometryReport report;
    AnyMesh mesh;
    MeshFields fields;
    std::optional<SurfaceMesh> surface = {};  ///< where it is asked for
};
[[nodiscard]] Outcome<Inspected> inspect_geometry(DecodedMesh mesh, const ComparedGeometry& geometry,
                                                  const InspectOptions& options, const Around& around);

/// Lines for a terminal, without colours.
[[nodiscard]] std::string inspect_table(const GeometryReport& report);
/// The object of `camber geometry --json`. What each key means: docs/report.md.
[[nodiscard]] std::string inspect_json(const GeometryReport& report, std::string_view name, std::string_view version);

}  // namespace camber::run
