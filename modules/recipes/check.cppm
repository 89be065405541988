module;
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>
export module camber.recipes:check;
import camber.core;
import camber.interpolation;
import camber.validity;
import camber.crossing;
import camber.soundness;
import camber.io;
import camber.stages;
import :fields;
import :measurements;
import :report;
import :state;

/// Checks of a mesh, and errors of interpolants on it (`camber check`).
export namespace camber::run {

struct ErrorBin {
    std::string range;
    std::size_t elements = 0;
    double straight = 0, same_boundary = 0, curved = 0;

    static void fields(auto& s, auto& f) {
        f("range", s.range, "range of the bin");
        f("elements", s.elements, "number of elements in the bin");
        f("straight", s.straight, "share of these elements in the squared L2 error of `straight`", unit("1"));
        f("same_boundary", s.same_boundary, "share of these elements in the squared L2 error of `same_boundary`",
          unit("1"));
        f("curved", s.curved, "share of these elements in the squared L2 error of `curved`", unit("1"));
    }
};

/// Empty bins are included.
struct FieldErrors {
    std::string expression;
    InterpolationError errors;
    std::vector<ErrorBin> by_curvature, by_scaled_jacobian, by_boundary;

    static void fields(auto& s, auto& f) {
        f("field", s.expression, "expression of the field");
        f.merged(s.errors);
        f("by_curvature", s.by_curvature, "elements by the |node − middle|/|chord| of their most curved edge");
        f("by_scaled_jacobian", s.by_scaled_jacobian, "elements by their minimum scaled Jacobian");
        f("by_boundary", s.by_boundary, "elements by the number of edges between them and the boundary");
    }
};

/// The default bound is 0, not the recommended bound of runs.
struct CheckOptions {
    double min_scaled_jacobian = 0;
    double ridge_angle = ExamineOptions{}.ridge_angle_degrees;
    std::size_t worst = 10;
    std::vector<std::string> fields = {};

    [[nodiscard]] static constexpr auto options() {
        using S = CheckOptions;
        return std::tuple(
            option("min_scaled_jacobian", &S::min_scaled_jacobian,
                   "minimum scaled Jacobian of a valid element, from 0 and below 1")
                .at_least(0)
                .below(1),
            option("ridge_angle", &S::ridge_angle,
                   "boundary faces that meet at a smaller angle than this (degrees) belong to one smooth wall")
                .at_least(0)
                .at_most(180),
            option("worst", &S::worst, "number of worst elements to show").at_least(0).at_most(1000000));
    }
};

[[nodiscard]] constexpr std::string_view word(Verdict verdict) {
    return verdict == Verdict::valid ? "valid" : verdict == Verdict::invalid ? "invalid" : "undecided";
}

struct Witness {
    std::vector<double> barycentric, point;
    double scaled_jacobian = 0;

    static void fields(auto& s, auto& f) {
        f("barycentric", s.barycentric,
          "weights w of the vertices; the point is w/Σw. They are exact if the element is invalid there", unit("1"));
        f("point", s.point, "coordinates of the point", unit("length"));
        f("scaled_jacobian", s.scaled_jacobian, "scaled Jacobian at the point; det J if the straight element is flat",
          unit("1"));
    }
};

struct ElementReport {
    std::size_t number = 0;
    std::uint64_t tag = 0;  ///< 0: none
    Reference reference = 0;
    std::string name = {};
    Verdict verdict = Verdict::undecided;
    std::vector<std::size_t> vertices = {};
    std::optional<double> min_scaled_jacobian = {};   ///< degree 2, see `ElementValidity`
    std::optional<bool> straight_inverted = {};       ///< degree 2 only
    std::optional<Witness> witness = {};              ///< degree 2 only
    std::optional<double> quality = {}, volume = {};  ///< degree 1, see `ElementColumns`
    std::string reason = {};

    static void fields(auto& s, auto& f) {
        f("element", s.number, "its number, from 1");
        f("tag", s.tag, "its number in the file, if it differs", unless_empty);
        f("reference", s.reference, "its reference");
        f("name", s.name, "name of its reference", unless_empty);
        f("verdict", word(s.verdict), "`valid`, `invalid` or `undecided`");
        f("vertices", s.vertices, "its vertices, with the numbers of the file");
        f("min_scaled_jacobian", s.min_scaled_jacobian, "degree 2: its minimum scaled Jacobian", unit("1"));
        f("straight_inverted", s.straight_inverted, "degree 2: true if it is inverted or flat when straight");
        f("witness", s.witness, "degree 2: the point where det J is lowest");
        f("quality", s.quality, "degree 1: its mean ratio", unit("1"));
        f("volume", s.volume, "degree 1: its signed volume (2D: area)", unit("length^D"));
        f("reason", s.reason, "reason, in words");
    }
};

/// Columns with one entry per element (standalone surface mesh: per triangle).
struct ElementColumns {
    int degree = 1;
    Column<Reference> references;
    Column<Verdict> verdicts;
    Column<float> min_scaled_jacobian;
    Column<std::uint8_t> straight_inverted;
    Column<float> quality;
    Column<double> volume;

    [[nodiscard]] bool is_curved() const { return degree == 2; }
    static void fields(auto& s, auto& f) {
        f("reference", s.references, "references of the elements");
        f("verdict", s.verdicts, "`valid`, `invalid` or `undecided`");
        f("min_scaled_jacobian", s.min_scaled_jacobian,
          "degree 2: certified lower bounds of the scaled Jacobians; null: not finite", unit("1"),
          shown_if(s.is_curved()));
        f("straight_inverted", s.straight_inverted, "degree 2: true if inverted or flat when straight",
          shown_if(s.is_curved()));
        f("quality", s.quality,
          "degree 1: mean ratios, 1 for an equilateral element, 0 for a flat one, negative for an inverted one",
          unit("1"), shown_if(!s.is_curved()));
        f("volume", s.volume, "degree 1: signed volumes (2D: areas)", unit("length^D"), shown_if(!s.is_curved()));
    }
};

struct FindingReport {
    std::size_t count = 0;
    std::vector<std::size_t> first;  ///< numbers of one or two entities, from 1, as in the file
    std::string_view concern;
    bool is_harmful = false;
    std::string sentence;

    static void fields(auto& s, auto& f) {
        f("count", s.count, "number of entities with the defect");
        f("first", s.first, "first of these entities, with a second number if two belong together");
        f("category", s.concern,
          "subject of the defect: `conformity`, `orientation`, `nodes`, `boundary`, `closure` or `walls`");
        f("is_harmful", s.is_harmful, "true: the mesh is not sound because of the defect");
        f("text", s.sentence, "description, in one sentence");
    }
};

struct SoundnessReport {
    template <class T>
    using ByDefect = std::vector<std::pair<std::string, T>>;

    bool sound = true, empty = false;
    ByDefect<std::size_t> counts = {};
    ByDefect<FindingReport> findings = {};

    [[nodiscard]] ByDefect<std::vector<std::size_t>> first() const;
    static void fields(auto& s, auto& f) {
        f("sound", s.sound, "true: no harmful defect was found");
        f("empty", s.empty, "true: the mesh has no elements and no facets");
        f({}, s.counts, "number of entities with a defect, by kind ([soundness.md](algorithms/soundness.md))");
        f("first", s.first(), "first entities of each kind that was found, as in `findings.NAME.first`");
        f("findings", s.findings, "kinds of defects that were found");
    }
};

/// Two facets that are not certified disjoint. A facet that is listed twice crosses itself.
struct CrossingReport {
    Crossing verdict = Crossing::undecided;
    std::array<std::size_t, 2> facets{};
    std::array<std::uint64_t, 2> tags{};  ///< numbers in the file, if they differ; 0: none
    std::array<Reference, 2> references{};
    std::array<std::vector<std::size_t>, 2> vertices{};
    bool straight_too = false;

    static void fields(auto& s, auto& f) {
        f("verdict", word(s.verdict), "`crossing`, `touching` or `undecided`");
        f("facets", s.facets,
          "numbers of both facets, from 1; 0: the file lists no boundary. A facet that is listed twice crosses itself");
        f("references", s.references, "their references");
        f("vertices", s.vertices, "their vertices, with the numbers of the file");
        f("also_when_straight", s.straight_too, "true: the facets are not disjoint with straight edges either");
    }
};

struct CrossingsReport {
    bool looked_at = true;
    std::size_t facets = 0;
    Crossings counts = {};
    std::vector<CrossingReport> found = {};

    static void fields(auto& s, auto& f) {
        f("examined", s.looked_at, "false: crossings were not examined, since the mesh has a fatal defect");
        f("facets", s.facets, "number of facets of the boundary and of interfaces");
        f.merged(s.counts);
        f("found", s.found, "pairs that are not certified disjoint, by ascending facets");
    }
};

struct OverlapReport {
    std::array<std::size_t, 2> elements{};
    std::array<std::uint64_t, 2> tags{};  ///< 0: none
    std::array<Reference, 2> references{};
    std::vector<double> point;

    static void fields(auto& s, auto& f) {
        f("elements", s.elements, "their numbers, from 1");
        f("tags", s.tags, "their numbers in the file, if they differ", shown_if(s.tags[0] != 0));
        f("references", s.references, "their references");
        f("point", s.point, "point inside both elements, up to rounding", unit("length"));
    }
};

struct OverlapsReport {
    bool looked_at = false;
    std::size_t walls = 0, overlapping = 0, undecided = 0;
    std::vector<OverlapReport> found = {};

    static void fields(auto& s, auto& f) {
        f("examined", s.looked_at,
          "false: overlaps were not examined, since the mesh has no elements, a fatal defect, or elements that it "
          "lists twice");
        f("walls", s.walls, "number of connected parts of the boundary that were examined");
        f("overlapping", s.overlapping,
          "number of pairs of touching facets, and of parts of the boundary, that lie inside other elements "
          "([crossing.md](algorithms/crossing.md#elements-that-overlap))");
        f("undecided", s.undecided, "number of parts without a certified answer");
        f("found", s.found, "pairs of elements that overlap, by ascending elements");
    }
};

using ReferenceCounts = std::map<Reference, std::size_t>;

struct CheckReport {
    MeshReport mesh;
    ReferenceCounts elements_by_reference, facets_by_reference, feature_edges_by_reference;
    Groups groups;
    double bound = 0;
    std::size_t invalid = 0, undecided = 0, straight_inverted = 0;
    double smallest = 1;  ///< minimum scaled Jacobian; 1: no elements
    std::size_t worst_element = 0;
    std::vector<ElementReport> worst;
    std::vector<Histogram> histograms;
    std::vector<std::size_t> invalid_elements, undecided_elements, straight_inverted_elements, wall_elements;
    SoundnessReport soundness;
    CrossingsReport crossings;
    OverlapsReport overlaps;
    std::optional<UnitMeshReport> unit_mesh;
    std::optional<CurvedUnitMeshReport> curved_unit_mesh;
    std::vector<FieldErrors> interpolation;
    std::vector<std::string> notices;
    ElementColumns elements;
    FileNumbers numbers;
    bool is_only_reversed = false;  ///< true: every invalid element is valid with reversed orientation

    [[nodiscard]] bool all_good() const {
        return soundness.sound && invalid == 0 && undecided == 0 && crossings.counts.crossing == 0 &&
               overlaps.overlapping == 0;
    }
    [[nodiscard]] std::size_t valid() const { return mesh.judged() - invalid - undecided; }
    [[nodiscard]] std::optional<double> min_scaled_jacobian() const {
        const bool has_one = mesh.judged() > 0 && (worst_element > 0 || !mesh.is_standalone_surface());
        return has_one ? std::optional(smallest) : std::nullopt;
    }
    [[nodiscard]] std::string answer() const;
    /// Number in the file, if it differs from the position (from 1); 0: none.
    [[nodiscard]] std::uint64_t tag_of(std::size_t element) const {
        return numbers.tag(mesh.judged_dimension(), element);
    }
    [[nodiscard]] std::vector<std::uint64_t> tags(const std::vector<std::size_t>& list) const {
        std::vector<std::uint64_t> all;
        for (const std::size_t e : list)
            if (const std::uint64_t tag = tag_of(e); tag != 0) all.push_back(tag);
        return all;
    }

    static void fields(auto& s, auto& f) {
        f.merged(s.mesh, without({"standalone_surface"}));
        f("elements_by_reference", s.elements_by_reference, "number of elements of each reference");
        f("facets_by_reference", s.facets_by_reference, "number of facets of each reference");
        f("feature_edges_by_reference", s.feature_edges_by_reference, "number of feature edges of each reference");
        f("groups", s.groups, "names of references in the file");
        f("all_good", s.all_good(), "true: the mesh is sound, and all elements are valid; the exit code is 0");
        f("answer", s.answer(), "answer in words, with a remedy");
        f("bound", s.bound, "minimum scaled Jacobian of a valid element", unit("1"));
        f("valid", s.valid(), "number of valid elements");
        f("invalid", s.invalid, "number of invalid elements");
        f("undecided", s.undecided, "number of elements without a certified answer");
        f("straight_inverted", s.straight_inverted, "number of elements that are inverted or flat with straight edges");
        f("min_scaled_jacobian", s.min_scaled_jacobian(),
          "lower bound of the scaled Jacobian over all elements, to 10⁻³; null: the mesh has no element", unit("1"),
          or_null);
        f("worst_element", s.worst_element, "element with this bound, from 1; 0: no element");
        f("worst", s.worst, "worst elements, the worst first, at most `--worst`");
        f("histograms", s.histograms, "see below", unless_empty);
        f("invalid_elements", s.invalid_elements, "invalid elements, from 1");
        f("invalid_element_tags", s.tags(s.invalid_elements), "their numbers in the file, if they differ",
          unless_empty);
        f("undecided_elements", s.undecided_elements, "elements without a certified answer, from 1");
        f("undecided_element_tags", s.tags(s.undecided_elements), "their numbers in the file, if they differ",
          unless_empty);
        f("straight_inverted_elements", s.straight_inverted_elements,
          "elements that are inverted or flat with straight edges, from 1");
        f("straight_inverted_element_tags", s.tags(s.straight_inverted_elements),
          "their numbers in the file, if they "
          "differ",
          unless_empty);
        f("wall_elements", s.wall_elements, "elements with two faces on one smooth wall, from 1");
        f("wall_element_tags", s.tags(s.wall_elements), "their numbers in the file, if they differ", unless_empty);
        f("soundness", s.soundness, "defects of the mesh");
        f("crossings", s.crossings, "facets that pass through each other or touch");
        f("overlaps", s.overlaps, "elements that overlap");
        f("unit_mesh", s.unit_mesh, "with `--metric`: straight edges and elements, measured in the metric");
        f("curved_unit_mesh", s.curved_unit_mesh,
          "with `--metric`, degree 2: edges and elements, measured along the curves "
          "([distortion.md](algorithms/distortion.md))");
        f("interpolation", s.interpolation,
          "with `--field`: errors of interpolants ([interpolation-error.md](algorithms/interpolation-error.md))",
          unless_empty);
        f("notices", s.notices, "notes on the input, one sentence each");
    }
};

/// Checks soundness, verdicts of elements, crossings and overlaps, and with a metric file closeness to a unit mesh.
/// Errors: expressions that cannot be parsed (usage); those of camber::check_mesh and of the file.
[[nodiscard]] Outcome<CheckReport> check_mesh(DecodedMesh mesh, const std::optional<MetricFile>& metric,
                                              const CheckOptions& options, const StepWrapper& around);

/// Fields on elements (standalone surface mesh: on facets) for viewers: `verdict` (0 valid, 1 invalid, 2 undecided),
/// `quality`, and for degree 2 `scaled_jacobian`. Other cells have −1 and NaN. Errors: stopped.
[[nodiscard]] Outcome<MeshFields> check_fields(const AnyMesh& mesh, const CheckReport& report,
                                               const Execution& execution);

[[nodiscard]] std::string overlap_text(const OverlapReport& overlap, const MeshReport& mesh);

/// Mean ratio of a straight element, or of a triangle of a standalone surface mesh.
template <int D>
[[nodiscard]] double quality_of(const LinearMesh<D>& mesh, std::size_t e);

}  // namespace camber::run

namespace camber::run {

/// Steps: classify, then interpolate for each expression. Errors: of the expressions and of `interpolation_error`.
template <int D>
[[nodiscard]] Outcome<std::vector<FieldErrors>> field_errors(const QuadraticMesh<D>& mesh,
                                                             const Column<float>& min_scaled_jacobian,
                                                             const std::vector<std::string>& expressions,
                                                             const StepWrapper& around);

[[nodiscard]] ReferenceCounts counted_by_reference(const Column<Reference>& references);

template <int D>
struct Judged {
    const QuadraticMesh<D>& mesh;
    const Validation<D>& validation;
    const Soundness& soundness;
    const CheckReport& report;
};

/// Elements that are not valid come first, then by ascending scaled Jacobian (degree 2) or quality.
template <int D>
[[nodiscard]] Outcome<std::vector<ElementReport>> find_worst_elements(const Judged<D>& judged, std::size_t n,
                                                                      const Execution& execution);

}  // namespace camber::run
