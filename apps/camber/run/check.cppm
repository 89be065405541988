module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>
export module camber.run:check;
import camber.core;
import camber.crossing;
import camber.io;
import camber.validity;
import camber.soundness;
import :curved_unit_mesh;
import :field_errors;
import :file_numbers;
import :histogram;
import :pipeline;
import :report;
import :stages;
import :unit_mesh;

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
