// Checks of a mesh
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.reports;
import camber.core;
import camber.recipes;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.crossing;
import camber.soundness;
import camber.io;
import camber.fields;

namespace camber::run {

namespace {

std::vector<ReferenceCount> by_reference(const Column<Reference>& references) {
    std::map<Reference, std::size_t> counts;
    for (const Reference r : references) ++counts[r];
    std::vector<ReferenceCount> list;
    list.reserve(counts.size());
    for (const auto& [reference, count] : counts) list.push_back({reference, count});
    return list;
}

/// Numbers, from 1, of the elements that are chosen.
template <class Chosen>
std::vector<std::size_t> numbers_of(std::size_t elements, Chosen&& chosen) {
    std::vector<std::size_t> numbers;
    for (std::size_t e = 0; e < elements; ++e)
        if (chosen(e)) numbers.push_back(e + 1);
    return numbers;
}

/// As `check_element` has it.
bool straight_inverted(const auto& element) {
    const auto plain = bounded_jacobian(element);
    const auto jacobian = blurred(plain) ? sharp_jacobian(element) : plain;
    return !(jacobian.straight > jacobian.error);
}

/// One check in D dimensions, step by step.
template <int D>
class Checker {
  public:
    Checker(Mesh<D> mesh, FileNumbers numbers, const std::optional<MetricFile>& metric, const CheckOptions& options,
            const Around& around)
        : given_(std::move(mesh)),
          linear_(straight_simplices(given_)),
          numbers_(std::move(numbers)),
          metric_(metric),
          options_(options),
          around_(around) {}

    Outcome<CheckReport> check() {
        for (const std::string& field : options_.fields)
            if (const auto parsed = ScalarExpression<D>::parsed(field); !parsed) return fail(parsed.error());
        count();
        auto done = judge()
                        .and_then([&](Done) { return judge_turned(); })
                        .and_then([&](Done) { return step("measure", [&](const Execution& e) { return measure(e); }); })
                        .and_then([&](Done) { return measure_in_metric(); })
                        .and_then([&](Done) { return interpolate(); });
        if (!done) return fail(done.error());
        return std::move(report_);
    }

  private:
    template <class F>
    Outcome<Done> step(const char* name, F&& f) {
        return around_(name, [&](const Execution& execution) { return guarded([&] { return f(execution); }); });
    }

    void count() {
        report_.mesh = {D,
                        given_.degree,
                        linear_.points.size(),
                        count_nodes(given_),
                        linear_.elements.size(),
                        linear_.facets.size(),
                        linear_.edges.size()};
        report_.elements_by_reference = by_reference(linear_.elements.references);
        report_.facets_by_reference = by_reference(linear_.facets.references);
        report_.feature_edges_by_reference = by_reference(linear_.edges.references);
        report_.elements.references =
            is_surface_alone(linear_) ? linear_.facets.references : linear_.elements.references;
    }

    Outcome<Done> judge() {
        const MeshCheckOptions options{options_.min_scaled_jacobian, {.ridge_angle_degrees = options_.ridge_angle}};
        auto made = camber::check_mesh(given_, options, around_);
        if (!made) return fail(made.error());
        soundness_ = std::move(made->soundness);
        validation_ = std::move(made->validation);
        mesh_ = std::move(made->mesh);
        if (made->walls) {
            report_.crossings = crossings_report(linear_, *made->walls, numbers_);
            report_.overlaps = overlaps_report(linear_, made->walls->overlaps, numbers_);
        } else {
            report_.crossings.looked_at = false;
        }
        tell_of_soundness();
        tell_of_validity();
        return Done{};
    }

    /// Judges the mesh with its reversed elements turned, where these are all that is invalid when straight.
    Outcome<Done> judge_turned() {
        const std::size_t reversed = soundness_[Defect::reversed_element].count;
        if (reversed == 0 || reversed != validation_.straight_inverted) return Done{};
        return step("validate", [&](const Execution& e) -> Outcome<Done> {
            const auto turned = prepare(as_mesh(mesh_), part_of(e, 0, 0.5));
            if (!turned) return Done{};  // a mesh with other defects
            const auto quadratic = as_quadratic(turned->mesh);
            if (!quadratic) return fail(quadratic.error());
            const auto validation = validate(*quadratic, options_.min_scaled_jacobian, part_of(e, 0.5, 1));
            if (!validation) return fail(validation.error());
            report_.is_only_reversed = validation->invalid + validation->undecided == 0;
            return Done{};
        });
    }

    void tell_of_soundness() {
        report_.soundness = soundness_report(soundness_, numbers_);
        report_.wall_elements.reserve(soundness_.wall_elements.size());
        for (const WallElement& wall : soundness_.wall_elements)
            report_.wall_elements.push_back(wall.element.index() + 1);
    }

    void tell_of_validity() {
        const Validation<D>& v = validation_;
        report_.validity = {.bound = v.bound,
                            .is_asked = true,
                            .invalid = v.invalid,
                            .undecided = v.undecided,
                            .straight_inverted = v.straight_inverted,
                            .smallest = v.smallest,
                            .worst = v.worst.valid() ? v.worst.index() + 1 : 0};
        report_.elements.verdicts = v.verdicts;
        const auto listed = [&](Verdict verdict) {
            return numbers_of(v.verdicts.size(), [&](std::size_t e) { return v.verdicts[e] == verdict; });
        };
        report_.invalid_elements = listed(Verdict::invalid);
        report_.undecided_elements = listed(Verdict::undecided);
    }

    Outcome<Done> measure(const Execution& execution) {
        const std::size_t n = judged_count(linear_);
        ElementColumns& columns = report_.elements;
        auto inverted = map_each(part_of(execution, 0, given_.degree == 2 ? 1 : 0.5), n, [&](std::size_t e) {
            if constexpr (D == 3)
                if (is_surface_alone(linear_))
                    return static_cast<std::uint8_t>(
                        straight_inverted(surface_triangle(mesh_, mesh_.mid_nodes.view(), e)));
            const auto element = nodal_element<D>(mesh_, mesh_.mid_nodes.view(), ElementId(e));
            return static_cast<std::uint8_t>(straight_inverted(element));
        });
        if (!inverted) return fail(inverted.error());
        columns.straight_inverted = std::move(*inverted);
        report_.straight_inverted_elements =
            numbers_of(n, [&](std::size_t e) { return columns.straight_inverted[e] == 1; });
        if (given_.degree == 2) {
            columns.min_scaled_jacobian = validation_.min_scaled_jacobian;
            add_histogram<float>(Quantity::scaled_jacobian, columns.min_scaled_jacobian.view());
        } else {
            auto quality = map_each(part_of(execution, 0.5, 0.7), n,
                                    [&](std::size_t e) { return static_cast<float>(quality_of(linear_, e)); });
            if (!quality) return fail(quality.error());
            auto volume =
                map_each(part_of(execution, 0.7, 0.8), n, [&](std::size_t e) { return measure_of(linear_, e); });
            if (!volume) return fail(volume.error());
            columns.quality = std::move(*quality);
            columns.volume = std::move(*volume);
            add_histogram<float>(Quantity::quality, columns.quality.view());
        }
        const Judged<D> judged{mesh_, validation_, columns, soundness_, numbers_, given_.degree};
        auto worst = find_worst_elements(judged, options_.worst, without_progress(execution));
        if (!worst) return fail(worst.error());
        report_.worst = std::move(*worst);
        return Done{};
    }

    Outcome<Done> measure_in_metric() {
        if (!metric_) return Done{};
        return step("metric", [&](const Execution& e) -> Outcome<Done> {
            const auto metric = log_metrics_of_file<D>(*metric_, linear_.points.size(), part_of(e, 0, 0.2));
            if (!metric) return fail(metric.error());
            report_.notices.insert(report_.notices.end(), metric->notices.begin(), metric->notices.end());
            auto measured =
                measure_unit_mesh(linear_, mesh_.edges, metric->log_metrics, metric_->name, part_of(e, 0.2, 0.3));
            if (!measured) return fail(measured.error());
            for (Histogram& histogram : histograms_of(*measured, "count"))
                report_.histograms.push_back(std::move(histogram));
            report_.unit_mesh = std::move(measured->report);
            return given_.degree == 2 ? measure_curves(metric->log_metrics, part_of(e, 0.3, 1)) : Done{};
        });
    }

    Outcome<Done> measure_curves(const Column<LogMetric<D>>& log_metrics, const Execution& execution) {
        auto measured = measure_curved_unit_mesh(mesh_, log_metrics, metric_->name, options_.worst, execution);
        if (!measured) return fail(measured.error());
        for (Histogram& histogram : histograms_of(*measured, "count"))
            report_.histograms.push_back(std::move(histogram));
        report_.curved_unit_mesh = std::move(measured->report);
        return Done{};
    }

    /// The errors of the interpolants of fields, one after the other.
    Outcome<Done> interpolate() {
        if (options_.fields.empty()) return Done{};
        ElementKinds kinds;
        auto done = step("classify", [&](const Execution& e) -> Outcome<Done> {
            auto found = element_kinds(mesh_, validation_.min_scaled_jacobian, e);
            if (!found) return fail(found.error());
            kinds = std::move(*found);
            return Done{};
        });
        for (const std::string& field : options_.fields)
            done = done.and_then([&](Done) {
                return step("interpolate", [&](const Execution& e) -> Outcome<Done> {
                    auto errors = field_errors(mesh_, field, kinds, e);
                    if (!errors) return fail(errors.error());
                    report_.fields.push_back(std::move(*errors));
                    return Done{};
                });
            });
        return done;
    }

    template <class Number>
    void add_histogram(Quantity quantity, std::span<const Number> values) {
        if (values.empty()) return;
        const std::vector<double> all(values.begin(), values.end());
        Histogram h{quantity, limits_of(quantity), {}};
        h.series.push_back(counted("count", h.limits, all));
        report_.histograms.push_back(std::move(h));
    }

    Mesh<D> given_;
    LinearMesh<D> linear_;
    QuadraticMesh<D> mesh_;  ///< of degree 1 elevated
    FileNumbers numbers_;
    const std::optional<MetricFile>& metric_;
    CheckOptions options_;
    const Around& around_;
    Soundness soundness_;
    Validation<D> validation_;
    CheckReport report_;
};

}  // namespace

Outcome<CheckReport> check_mesh(DecodedMesh mesh, const std::optional<MetricFile>& metric, const CheckOptions& options,
                                const Around& around) {
    const FileNumbers numbers = numbers_of(mesh);
    Groups groups = groups_of(mesh.mesh);
    auto report =
        std::visit([&]<int D>(Mesh<D> m) { return Checker<D>(std::move(m), numbers, metric, options, around).check(); },
                   std::move(mesh.mesh));
    if (!report) return report;
    report->groups = std::move(groups);
    report->numbers = numbers;
    report->notices.reserve(mesh.notices.size());
    for (Notice& notice : mesh.notices) report->notices.push_back(std::move(notice.what));
    return report;
}

namespace {

constexpr std::array<ConcernText, concern_count> texts{{
    {"conformity", "no element twice, no face of more than two, no vertex inside a face"},
    {"orientation", "no element reversed, inverted or flat"},
    {"nodes", "none unused, none at the place of another"},
    {"boundary", "all of it listed, once, and nothing else"},
    {"closure", "the boundary is closed, and meets itself at no vertex or edge"},
    {"walls", "no element has two faces on one smooth wall"},
}};

/// Whether `first` and `other` of a defect are vertices or nodes, which the file may number in another way.
struct Vertices {
    bool first = false, other = false;
};
Vertices vertices_of(Defect defect) {
    switch (defect) {
        case Defect::distant_vertex:
        case Defect::distant_node:
        case Defect::hanging_vertex:
        case Defect::unused_vertex:
        case Defect::pinched_vertex: return {.first = true};
        case Defect::duplicate_vertex:
        case Defect::slit_vertex:
        case Defect::coincident_node:
        case Defect::open_edge:
        case Defect::crowded_edge: return {.first = true, .other = true};
        default: return {};
    }
}

}  // namespace

Concern concern_of(Defect defect) {
    switch (defect) {
        case Defect::repeated_element:
        case Defect::contradicting_element:
        case Defect::crowded_face:
        case Defect::hanging_vertex: return Concern::conformity;
        case Defect::reversed_element:
        case Defect::tangled_element:
        case Defect::flat_element:
        case Defect::tiny_element: return Concern::orientation;
        case Defect::distant_vertex:
        case Defect::distant_node:
        case Defect::duplicate_vertex:
        case Defect::unused_vertex:
        case Defect::slit_vertex:
        case Defect::coincident_node: return Concern::nodes;
        case Defect::stray_facet:
        case Defect::tiny_facet:
        case Defect::repeated_facet:
        case Defect::contradicting_facet:
        case Defect::missing_facet:
        case Defect::no_facets:
        case Defect::missing_interface:
        case Defect::inner_facet:
        case Defect::lone_edge: return Concern::boundary;
        case Defect::open_edge:
        case Defect::crowded_edge:
        case Defect::pinched_vertex: return Concern::closure;
        case Defect::wall_element: return Concern::walls;
    }
    return Concern::conformity;
}

ConcernText text_of(Concern concern) { return texts[static_cast<std::size_t>(concern)]; }

SoundnessReport soundness_report(Soundness soundness, const FileNumbers& numbers) {
    SoundnessReport report{.sound = soundness.sound(), .empty = soundness.empty, .findings = {}};
    report.findings.reserve(defect_count);
    for (std::size_t i = 0; i < defect_count; ++i) {
        const Defect defect{static_cast<std::uint8_t>(i)};
        Finding& found = soundness.findings[i];
        const auto [first, other] = vertices_of(defect);
        if (first && found.first > 0) found.first = numbers(found.first - 1);
        if (other && found.other > 0) found.other = numbers(found.other - 1);
        report.findings.push_back({key(defect), concern_of(defect), found.count, found.first, found.other,
                                   gravity(defect) != Gravity::harmless,
                                   found.count > 0 ? sentence(soundness, defect) : std::string()});
    }
    return report;
}

namespace {

/// Cells that are judged, and all of them.
struct CellCounts {
    std::size_t judged = 0, cells = 0;
};

/// What elements have, and `none` on the other cells. Elements come first, of a surface alone facets do.
template <class T>
MeshField at_cells(std::string name, const CellCounts& size, T none, auto&& value) {
    Buffer<T> values(size.cells);
    std::fill(values.begin(), values.end(), none);
    for (std::size_t e = 0; e < size.judged; ++e) values[e] = static_cast<T>(value(e));
    return {std::move(name), Centring::cell, FieldKind::scalar, Column<T>(std::move(values))};
}

template <int D>
Outcome<MeshFields> fields_of(const LinearMesh<D>& mesh, const CheckReport& report, const Execution& execution) {
    const CellCounts size{judged_count(mesh), mesh.elements.size() + mesh.facets.size() + mesh.edges.size()};
    const ElementColumns& columns = report.elements;
    auto qualities = map_each(execution, size.judged, [&](std::size_t e) { return quality_of(mesh, e); });
    if (!qualities) return fail(qualities.error());
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<MeshField> fields{
        at_cells<std::int32_t>("verdict", size, -1, [&](std::size_t e) { return columns.verdicts[e]; }),
        at_cells<double>("quality", size, nan, [&](std::size_t e) { return (*qualities)[e]; })};
    if (!columns.min_scaled_jacobian.empty())
        fields.push_back(at_cells<double>("scaled_jacobian", size, nan,
                                          [&](std::size_t e) { return columns.min_scaled_jacobian[e]; }));
    return MeshFields(std::move(fields));
}

}  // namespace

Outcome<MeshFields> check_fields(const AnyMesh& mesh, const CheckReport& report, const Execution& execution) {
    return std::visit([&](const auto& m) { return fields_of(straight_simplices(m), report, execution); }, mesh);
}

namespace {

template <int D>
FacetReport facet_report(const QuadraticMesh<D>& mesh, FacetId f, bool listed, const FileNumbers& numbers) {
    const std::size_t number = listed ? f.index() + 1 : 0;
    FacetReport report{
        .number = number, .tag = numbers.tag(D - 1, number), .reference = mesh.linear.facets.references[f]};
    report.vertices.reserve(D);
    for (const VertexId v : mesh.linear.facets.vertices[f]) report.vertices.push_back(numbers(v.index()));
    return report;
}

template <int D>
NodalFacet<D> straightened(const NodalFacet<D>& facet) {
    std::array<Vec<D>, D> vertices;
    for (int i = 0; i < D; ++i) vertices[i] = facet.nodes[i];
    return straight_facet<D>(vertices);
}

template <int D>
bool cross_straight(const QuadraticMesh<D>& mesh, const FacetCrossing& found) {
    return found.first != found.second &&
           crossing_of(straightened(nodal_facet(mesh, found.first)), straightened(nodal_facet(mesh, found.second))) !=
               Crossing::disjoint;
}

}  // namespace

template <int D>
CrossingsReport crossings_report(const LinearMesh<D>& given, const CheckedWalls<D>& walls, const FileNumbers& numbers) {
    const bool listed = given.facets.size() > 0 || given.elements.size() == 0;
    const auto& [mesh, found, overlaps] = walls;
    CrossingsReport report{.facets = mesh.linear.facets.size(),
                           .pairs = found.pairs,
                           .crossing = found.crossing,
                           .touching = found.touching,
                           .undecided = found.undecided,
                           .cut_short = found.cut_short,
                           .steps = found.steps};
    report.found.reserve(found.found.size());
    for (const FacetCrossing& pair : found.found)
        report.found.push_back(
            {pair.verdict,
             {facet_report(mesh, pair.first, listed, numbers), facet_report(mesh, pair.second, listed, numbers)},
             cross_straight(mesh, pair)});
    return report;
}

template <int D>
OverlapsReport overlaps_report(const LinearMesh<D>& given, const Overlaps<D>& overlaps, const FileNumbers& numbers) {
    OverlapsReport report{.looked_at = overlaps.looked_at,
                          .walls = overlaps.walls,
                          .overlapping = overlaps.overlapping,
                          .undecided = overlaps.undecided};
    report.found.reserve(overlaps.found.size());
    for (const ElementOverlap<D>& overlap : overlaps.found) {
        OverlapReport pair{.point = {overlap.point.c.begin(), overlap.point.c.end()}};
        for (const auto& [i, element] : {std::pair(0, overlap.first), std::pair(1, overlap.second)}) {
            pair.elements[i] = element.index() + 1;
            pair.tags[i] = numbers.tag(D, pair.elements[i]);
            pair.references[i] = given.elements.references[element];
        }
        report.found.push_back(std::move(pair));
    }
    return report;
}

#define CAMBER_INSTANTIATE(D)                                                                                       \
    template CrossingsReport crossings_report<D>(const LinearMesh<D>&, const CheckedWalls<D>&, const FileNumbers&); \
    template OverlapsReport overlaps_report<D>(const LinearMesh<D>&, const Overlaps<D>&, const FileNumbers&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::run
