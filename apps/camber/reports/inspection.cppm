module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>
export module camber.reports:inspection;
import camber.core;
import camber.recipes;
import camber.drawing;
import camber.validity;
import camber.crossing;
import camber.soundness;
import camber.io;
import camber.surface;
import camber.cad;
import camber.config;

/// What is right and wrong with a mesh, as it is: `camber check`.
export namespace camber::run {

/// What is asked of a mesh that may be anyone's: the bound is 0, not that of the meshes which a run makes.
struct CheckOptions {
    double min_scaled_jacobian = 0;
    double ridge_angle = ExamineOptions{}.ridge_angle_degrees;
    std::size_t worst = 10;
    std::vector<std::string> fields = {};  ///< expressions whose interpolants' errors are asked for

    [[nodiscard]] static constexpr auto options() {
        using S = CheckOptions;
        return std::tuple(
            option("min_scaled_jacobian", &S::min_scaled_jacobian,
                   "what an element's scaled Jacobian must reach to be valid, from 0 and below 1")
                .at_least(0)
                .below(1),
            option("ridge_angle", &S::ridge_angle,
                   "faces of the boundary that turn by less than this (degrees) are one smooth wall")
                .at_least(0)
                .at_most(180),
            option("worst", &S::worst, "how many of the worst elements to show").at_least(0).at_most(1000000));
    }
};

struct ReferenceCount {
    Reference reference = 0;
    std::size_t count = 0;
};

/// Where det J of an element is lowest.
struct Witness {
    std::vector<double> barycentric, point;  ///< of the reference element; in space (model units)
    double scaled_jacobian = 0;              ///< det J / |det straight|; det J where the straight element is flat
};

/// One of the worst elements, looked at closely.
struct ElementReport {
    std::size_t number = 0;  ///< from 1, as in the file
    std::uint64_t tag = 0;   ///< the file's own number, where that is another; 0: none
    Reference reference = 0;
    std::vector<std::size_t> vertices;  ///< as the file numbers them
    Verdict verdict = Verdict::undecided;
    bool straight_inverted = false;
    double min_scaled_jacobian = 0;       ///< see ElementValidity; of degree 2
    double quality = 0, volume = 0;       ///< see ElementColumns; of degree 1
    std::optional<Witness> witness = {};  ///< of degree 2
    std::string reason;
};

/// One entry an element. Of degree 2 the scaled Jacobians, of degree 1 quality and volume.
struct ElementColumns {
    Column<Reference> references;
    Column<Verdict> verdicts;
    Column<std::uint8_t> straight_inverted;
    Column<float> min_scaled_jacobian;
    Column<float>
        quality;  ///< mean ratio: 1 for an equilateral element, 0 for a flat one, negative for an inverted one
    Column<double> volume;  ///< with sign; area in 2D
};

/// What the defects are about, in the order in which they are told.
enum class Concern : std::uint8_t { conformity, orientation, nodes, boundary, closure, walls };
inline constexpr std::size_t concern_count = 6;
[[nodiscard]] Concern concern_of(Defect defect);
/// "conformity" …, and what was looked at, as one says it when all is well.
struct ConcernText {
    std::string_view name, good;
};
[[nodiscard]] ConcernText text_of(Concern concern);

/// What the mesh was found to be: one entry a defect, also of those not found.
struct SoundnessReport {
    struct Entry {
        std::string key;
        Concern concern = Concern::conformity;
        std::size_t count = 0;
        std::size_t first = 0, other = 0;  ///< numbers from 1, as in the file; 0: none
        bool harms = false;                ///< not sound if there is one
        std::string sentence;              ///< of what was found; empty otherwise
    };
    bool sound = true, empty = false;
    std::vector<Entry> findings;
};

/// A facet of the boundary or of an interface.
struct FacetReport {
    std::size_t number = 0;  ///< from 1, as in the file; 0: the file does not list its boundary
    std::uint64_t tag = 0;   ///< the file's own number, where that is another; 0: none
    Reference reference = 0;
    std::vector<std::size_t> vertices = {};  ///< as the file numbers them
};

/// Two facets that are not disjoint; the same one twice: of itself.
struct CrossingReport {
    Crossing verdict = Crossing::undecided;
    std::array<FacetReport, 2> facets;
    bool straight_too = false;  ///< the straight facets of their vertices are not disjoint either
};

/// Walls that pass through each other.
struct CrossingsReport {
    bool looked_at = true;  ///< false: the mesh has fatal defects
    std::size_t facets = 0, pairs = 0, crossing = 0, touching = 0, undecided = 0;
    std::size_t cut_short = 0;               ///< of the undecided: for want of work
    std::size_t steps = 0;                   ///< the work
    std::vector<CrossingReport> found = {};  ///< by rising facets
};

/// Two elements that overlap.
struct OverlapReport {
    std::array<std::size_t, 2> elements{};  ///< from 1, as in the file, the lower one first
    std::array<std::uint64_t, 2> tags{};    ///< the file's own numbers, where those are others; 0: none
    std::array<Reference, 2> references{};
    std::vector<double> point;  ///< a point of both, to rounding (model units)
};

/// Elements that overlap.
struct OverlapsReport {
    bool looked_at = false;  ///< false: the mesh has no elements, fatal defects, or elements that it lists twice
    std::size_t walls = 0, overlapping = 0, undecided = 0;  ///< see `Overlaps`
    std::vector<OverlapReport> found = {};                  ///< by rising elements
};

struct CheckReport {
    MeshReport mesh;
    std::vector<ReferenceCount> elements_by_reference, facets_by_reference, feature_edges_by_reference;
    SoundnessReport soundness;
    ValidityReport validity;
    CrossingsReport crossings;
    OverlapsReport overlaps;
    /// Elements, from 1; all of them.
    std::vector<std::size_t> invalid_elements, undecided_elements, straight_inverted_elements, wall_elements;
    std::vector<ElementReport> worst;   ///< the worst first
    std::vector<Histogram> histograms;  ///< of the elements; none without elements
    ElementColumns elements;
    std::optional<UnitMeshReport> unit_mesh;  ///< in the metric that was given, edges and elements straight
    std::optional<CurvedUnitMeshReport> curved_unit_mesh;  ///< the same along the curves; of degree 2
    std::vector<FieldErrors> fields;                       ///< of the fields that were asked for
    Groups groups;                                         ///< names of references
    FileNumbers numbers;
    std::vector<std::string> notices;
    bool is_only_reversed = false;  ///< all invalid elements are valid once they are numbered the other way round

    [[nodiscard]] bool all_good() const {
        return soundness.sound && validity.invalid == 0 && validity.undecided == 0 && crossings.crossing == 0 &&
               overlaps.overlapping == 0;
    }
};

/// The mesh as it is, nothing mended: its soundness, and verdicts of its elements; with a metric file how near to unit
/// it is.
[[nodiscard]] Outcome<CheckReport> check_mesh(DecodedMesh mesh, const std::optional<MetricFile>& metric,
                                              const CheckOptions& options, const Around& around);

/// For viewers, of each element (of a surface alone each facet), on other cells NaN and −1: `verdict`, 0 valid, 1
/// invalid, 2 undecided; `quality`; of degree 2 `scaled_jacobian`. Errors: stopped.
[[nodiscard]] Outcome<MeshFields> check_fields(const AnyMesh& mesh, const CheckReport& report,
                                               const Execution& execution);

/// "yes: all 252 elements are certified valid, and the mesh is sound", or "NO: 42 of 252 elements are invalid; camber
/// repair mends such": the answer, and what to do about it.
[[nodiscard]] std::string check_answer(const CheckReport& report);

/// Lines for a terminal, without colours.
[[nodiscard]] std::string check_table(const CheckReport& report);

/// The object of `camber check --json`; `name` is the file's, `version` the program's. It ends before its last brace,
/// so that members may follow. What each key means: docs/report.md.
[[nodiscard]] std::string check_json_head(const CheckReport& report, std::string_view name, std::string_view version);

/// The columns of the elements by name, each in pieces: items [begin, end) as JSON without brackets.
[[nodiscard]] std::vector<std::string> column_names(const CheckReport& report);
[[nodiscard]] std::string column_items(const CheckReport& report, std::string_view column, std::size_t begin,
                                       std::size_t end);

/// The same as CSV: the line of titles, and the lines of elements [begin, end).
[[nodiscard]] std::string csv_titles(const CheckReport& report);
[[nodiscard]] std::string csv_lines(const CheckReport& report, std::size_t begin, std::size_t end);

}  // namespace camber::run

namespace camber::run {

/// "valid", "invalid", "undecided".
[[nodiscard]] constexpr std::string_view word(Verdict verdict) {
    return verdict == Verdict::valid ? "valid" : verdict == Verdict::invalid ? "invalid" : "undecided";
}

/// As the file numbers what was found.
[[nodiscard]] SoundnessReport soundness_report(Soundness soundness, const FileNumbers& numbers);

/// Facets that cross, as the file numbers them; those of the `given` mesh, where it lists any.
template <int D>
[[nodiscard]] CrossingsReport crossings_report(const LinearMesh<D>& given, const CheckedWalls<D>& walls,
                                               const FileNumbers& numbers);

/// Elements that overlap, as the file numbers them.
template <int D>
[[nodiscard]] OverlapsReport overlaps_report(const LinearMesh<D>& given, const Overlaps<D>& overlaps,
                                             const FileNumbers& numbers);

/// "triangles 3 and 14 overlap at (0.25, 0.5)".
[[nodiscard]] std::string overlap_text(const OverlapReport& overlap, const MeshReport& mesh);

/// A mesh and what is known of its elements.
template <int D>
struct Judged {
    const QuadraticMesh<D>& mesh;
    const Validation<D>& validation;
    const ElementColumns& columns;
    const Soundness& soundness;
    const FileNumbers& numbers;
    int degree = 2;
};

/// The n worst elements: those not valid first, then by their smallest scaled Jacobian (degree 2) or their quality.
template <int D>
[[nodiscard]] Outcome<std::vector<ElementReport>> find_worst_elements(const Judged<D>& judged, std::size_t n,
                                                                      const Execution& execution);

template <int D>
[[nodiscard]] std::array<Vec<D>, D + 1> corners_of(const LinearMesh<D>& mesh, std::size_t e) {
    std::array<Vec<D>, D + 1> corners;
    for (int i = 0; i <= D; ++i) corners[i] = mesh.points[mesh.elements.vertices[e][i]];
    return corners;
}

/// Of a triangle of a surface alone.
[[nodiscard]] inline std::array<Vec<3>, 3> triangle_corners(const LinearMesh<3>& mesh, std::size_t t) {
    const auto& v = mesh.facets.vertices[t];
    return {mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]]};
}

/// Of a straight element, or a triangle of a surface alone: the mean ratio.
template <int D>
[[nodiscard]] inline double quality_of(const LinearMesh<D>& mesh, std::size_t e) {
    if constexpr (D == 3)
        if (is_surface_alone(mesh)) {
            const auto p = triangle_corners(mesh, e);
            const double l1 = distance(p[0], p[1]), l2 = distance(p[1], p[2]), l3 = distance(p[2], p[0]);
            const double unit = std::max({l1, l2, l3});
            if (!(unit > 0) || !std::isfinite(unit)) return 0;
            const double twice = norm(cross((p[1] - p[0]) / unit, (p[2] - p[0]) / unit));
            return 2 * std::sqrt(3.0) * twice / ((l1 * l1 + l2 * l2 + l3 * l3) / (unit * unit));
        }
    return mean_ratio<D>(corners_of(mesh, e));
}
/// Its volume or area, with sign but for a surface.
template <int D>
[[nodiscard]] inline double measure_of(const LinearMesh<D>& mesh, std::size_t e) {
    if constexpr (D == 3)
        if (is_surface_alone(mesh)) {
            const auto p = triangle_corners(mesh, e);
            return norm(cross(p[1] - p[0], p[2] - p[0])) / 2;
        }
    return signed_measure<D>(corners_of(mesh, e));
}

}  // namespace camber::run

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

/// A histogram as an SVG picture: a panel for the mesh before correction and one for after (or one alone), on the same
/// axes, the mean marked; lengths of the straight edges as an outline behind. Bins beyond the first and the last limit
/// are paler. Empty bins at the ends are left out.
[[nodiscard]] std::string svg(const Histogram& histogram);

/// All of them below each other in one picture.
[[nodiscard]] std::string svg(const std::vector<Histogram>& histograms);

}  // namespace camber::run

/// A mesh as a picture: `camber picture`.
export namespace camber::run {

/// What the colours of a picture stand for.
enum class PictureColour : std::uint8_t { scaled_jacobian, quality, reference, anisotropy, solution, none };
constexpr auto words(PictureColour) {
    return words_of(Word{PictureColour::scaled_jacobian, "scaled-jacobian"}, Word{PictureColour::quality, "quality"},
                    Word{PictureColour::reference, "reference"}, Word{PictureColour::anisotropy, "anisotropy"},
                    Word{PictureColour::solution, "solution"}, Word{PictureColour::none, "none"});
}

struct PictureChoice {
    std::size_t width = 1200, height = 900;  ///< pixels
    std::optional<Cut<3>> cut = {};          ///< of a 2D mesh the normal's z is 0
    std::optional<Vec<3>> from = {};         ///< where the viewer is, as a direction; none: obliquely, onto the cut
    std::optional<PictureOptions::Zoom> zoom = {};
    /// None: the solution, else the metric's anisotropy, where they are given; else scaled Jacobians, of degree 1
    /// qualities.
    std::optional<PictureColour> colour = {};
    Background background = Background::light;
    Edges edges = Edges::shown;
    std::size_t worst = 0;  ///< how many of the worst elements to point at
    /// Names of groups or reference numbers of boundary facets and of elements; of a 2D mesh of elements, of a
    /// standalone surface mesh of its facets. Only groups of `show` are drawn (empty: all), and none of `hide`.
    std::vector<std::string> show = {}, hide = {};
};

/// What a picture is made from; the metric has rows at the vertices.
struct PictureInputs {
    DecodedMesh mesh;
    std::optional<MetricFile> metric = {};
    std::optional<NamedField> solution = {};
};

/// A picture before it is drawn, and notes on it for the user.
struct Picture {
    Scene scene;
    std::vector<std::string> notices = {};
};

/// Errors: nothing to draw; a group that the mesh does not have (usage); colours by a metric or a solution that is not
/// given (usage); those of metric files.
[[nodiscard]] Outcome<Picture> picture_of(const PictureInputs& inputs, const PictureChoice& choice,
                                          const Execution& execution);

}  // namespace camber::run

/// The numbers that a picture's colours stand for.
namespace camber::run {

struct PictureValues {
    FaceValues of_face;
    Colouring colouring = OneColour{};
    std::string title = {};
};

/// Of each element, or triangle of a surface alone: scaled Jacobians of degree 2, qualities of degree 1. By these it is
/// told which are the worst.
template <int D>
[[nodiscard]] Outcome<Column<float>> element_goodness(const QuadraticMesh<D>& mesh, int degree,
                                                      const Execution& execution);

template <int D>
[[nodiscard]] Outcome<PictureValues> picture_values(const QuadraticMesh<D>& mesh, PictureColour colour,
                                                    const PictureInputs& inputs, const Execution& execution);

}  // namespace camber::run
