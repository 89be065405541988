module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
#include <fmt/ranges.h>
module camber.recipes;
import camber.core;
import camber.bezier;
import camber.metric;
import camber.validity;
import camber.crossing;
import camber.soundness;
import camber.io;
import camber.fields;

namespace camber::run {

ReferenceCounts counted_by_reference(const Column<Reference>& references) {
    ReferenceCounts counts;
    for (const Reference r : references) ++counts[r];
    return counts;
}

namespace {

template <int D, std::size_t N>
std::array<Vec<D>, N> corners_of(const LinearMesh<D>& mesh, const std::array<VertexId, N>& vertices) {
    std::array<Vec<D>, N> corners;
    std::ranges::transform(vertices, corners.begin(), [&](VertexId v) { return mesh.points[v]; });
    return corners;
}

}  // namespace

template <int D>
double quality_of(const LinearMesh<D>& mesh, std::size_t e) {
    if constexpr (D == 3)
        if (is_standalone_surface(mesh)) {
            const auto [a, b, c] = corners_of(mesh, mesh.facets.vertices[e]);
            const double l1 = distance(a, b), l2 = distance(b, c), l3 = distance(c, a);
            const double unit = std::max({l1, l2, l3});
            if (!(unit > 0) || !std::isfinite(unit)) return 0;
            const double twice = norm(cross((b - a) / unit, (c - a) / unit));
            return 2 * std::sqrt(3.0) * twice / ((l1 * l1 + l2 * l2 + l3 * l3) / (unit * unit));
        }
    return mean_ratio<D>(corners_of(mesh, mesh.elements.vertices[e]));
}

namespace {

/// Signed volume (2D: area) of an element, or area of a triangle of a standalone surface mesh.
template <int D>
double measure_of(const LinearMesh<D>& mesh, std::size_t e) {
    if constexpr (D == 3)
        if (is_standalone_surface(mesh)) {
            const auto [a, b, c] = corners_of(mesh, mesh.facets.vertices[e]);
            return norm(cross(b - a, c - a)) / 2;
        }
    return signed_measure<D>(corners_of(mesh, mesh.elements.vertices[e]));
}

std::vector<std::size_t> numbers_where(std::size_t elements, auto&& chosen) {
    std::vector<std::size_t> numbers;
    for (std::size_t e = 0; e < elements; ++e)
        if (chosen(e)) numbers.push_back(e + 1);
    return numbers;
}

bool straight_inverted(const auto& element) {
    const auto plain = bounded_jacobian(element);
    const auto jacobian = blurred(plain) ? double_double_jacobian(element) : plain;
    return !(jacobian.straight > jacobian.error);
}

constexpr std::string_view conformity = "conformity", orientation = "orientation", nodes = "nodes",
                           boundary = "boundary", closure = "closure", walls = "walls";
constexpr std::array<std::string_view, defect_count> concerns{
    conformity, conformity, conformity, boundary,    boundary,    boundary,    nodes,    nodes,    orientation,
    boundary,   conformity, nodes,      orientation, orientation, orientation, boundary, boundary, boundary,
    nodes,      nodes,      nodes,      boundary,    closure,     closure,     closure,  boundary, walls};

/// True for those of `first` and `other` of a defect that are vertices or nodes. The file may number these differently.
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

SoundnessReport soundness_report(Soundness soundness, const FileNumbers& numbers) {
    SoundnessReport report{.sound = soundness.sound(), .empty = soundness.empty};
    for (std::size_t i = 0; i < defect_count; ++i) {
        const Defect defect{static_cast<std::uint8_t>(i)};
        Finding& found = soundness.findings[i];
        report.counts.emplace_back(key(defect), found.count);
        if (found.count == 0) continue;
        const auto [first, other] = vertices_of(defect);
        if (first && found.first > 0) found.first = numbers(found.first - 1);
        if (other && found.other > 0) found.other = numbers(found.other - 1);
        FindingReport finding{found.count,
                              {found.first},
                              concerns[i],
                              severity(defect) != Severity::harmless,
                              sentence(soundness, defect)};
        if (found.other > 0) finding.first.push_back(found.other);
        report.findings.emplace_back(key(defect), std::move(finding));
    }
    return report;
}

template <int D>
NodalFacet<D> straightened(const NodalFacet<D>& facet) {
    std::array<Vec<D>, D> vertices;
    for (int i = 0; i < D; ++i) vertices[i] = facet.nodes[i];
    return straight_facet<D>(vertices);
}

/// `original`: the mesh as read; it may list no facets, and crossing facets then have the number 0.
template <int D>
CrossingsReport crossings_report(const LinearMesh<D>& original, CheckedWalls<D> checked, const FileNumbers& numbers) {
    const bool listed = original.facets.size() > 0 || original.elements.size() == 0;
    const QuadraticMesh<D>& mesh = checked.mesh;
    CrossingsReport report{.facets = mesh.linear.facets.size(), .counts = std::move(checked.crossings)};
    report.found.reserve(report.counts.found.size());
    for (const auto& [first, second, verdict] : report.counts.found) {
        CrossingReport pair{.verdict = verdict};
        for (const auto& [i, facet] : {std::pair(0, first), std::pair(1, second)}) {
            pair.facets[i] = listed ? facet.index() + 1 : 0;
            pair.tags[i] = numbers.tag(D - 1, pair.facets[i]);
            pair.references[i] = mesh.linear.facets.references[facet];
            for (const VertexId v : mesh.linear.facets.vertices[facet]) pair.vertices[i].push_back(numbers(v.index()));
        }
        pair.straight_too =
            first != second && crossing_of(straightened(nodal_facet(mesh, first)),
                                           straightened(nodal_facet(mesh, second))) != Crossing::disjoint;
        report.found.push_back(std::move(pair));
    }
    return report;
}

template <int D>
OverlapsReport overlaps_report(const LinearMesh<D>& original, const Overlaps<D>& overlaps, const FileNumbers& numbers) {
    OverlapsReport report{overlaps.looked_at, overlaps.walls, overlaps.overlapping, overlaps.undecided};
    report.found.reserve(overlaps.found.size());
    for (const ElementOverlap<D>& overlap : overlaps.found) {
        OverlapReport pair{.point = {overlap.point.c.begin(), overlap.point.c.end()}};
        for (const auto& [i, element] : {std::pair(0, overlap.first), std::pair(1, overlap.second)}) {
            pair.elements[i] = element.index() + 1;
            pair.tags[i] = numbers.tag(D, pair.elements[i]);
            pair.references[i] = original.elements.references[element];
        }
        report.found.push_back(std::move(pair));
    }
    return report;
}

template <int D>
class Checker {
  public:
    Checker(Mesh<D> mesh, const FileNumbers& numbers, const std::optional<MetricFile>& metric,
            const CheckOptions& options, const StepWrapper& around)
        : input_(std::move(mesh)),
          linear_(straight_simplices(input_)),
          metric_(metric),
          options_(options),
          around_(around) {
        report_.mesh = mesh_report(linear_, input_.degree, count_nodes(input_));
        report_.elements_by_reference = counted_by_reference(linear_.elements.references);
        report_.facets_by_reference = counted_by_reference(linear_.facets.references);
        report_.feature_edges_by_reference = counted_by_reference(linear_.edges.references);
        report_.groups = {input_.groups.begin(), input_.groups.end()};
        report_.numbers = numbers;
        report_.elements.degree = input_.degree;
        report_.elements.references =
            is_standalone_surface(linear_) ? linear_.facets.references : linear_.elements.references;
    }

    Outcome<CheckReport> check() {
        for (const std::string& field : options_.fields)
            if (const auto parsed = ScalarExpression<D>::parsed(field); !parsed) return fail(parsed.error());
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
    auto step(const char* name, F&& f) {
        return run_step(around_, name, std::forward<F>(f));
    }

    Outcome<Done> judge() {
        const MeshCheckOptions options{options_.min_scaled_jacobian, {.ridge_angle_degrees = options_.ridge_angle}};
        auto result = camber::check_mesh(input_, options, around_);
        if (!result) return fail(result.error());
        soundness_ = std::move(result->soundness);
        mesh_ = std::move(result->mesh);
        validation_ = std::move(result->validation);
        report_.crossings.looked_at = result->walls.has_value();
        if (result->walls) {
            report_.overlaps = overlaps_report(linear_, result->walls->overlaps, report_.numbers);
            report_.crossings = crossings_report(linear_, std::move(*result->walls), report_.numbers);
        }
        report_.soundness = soundness_report(soundness_, report_.numbers);
        for (const WallElement& wall : soundness_.wall_elements)
            report_.wall_elements.push_back(wall.element.index() + 1);
        report_verdicts(validation_);
        return Done{};
    }

    void report_verdicts(const Validation<D>& v) {
        report_.bound = v.bound;
        report_.invalid = v.invalid;
        report_.undecided = v.undecided;
        report_.straight_inverted = v.straight_inverted;
        report_.smallest = v.smallest;
        report_.worst_element = v.worst.valid() ? v.worst.index() + 1 : 0;
        report_.elements.verdicts = v.verdicts;
        const auto listed = [&](Verdict verdict) {
            return numbers_where(v.verdicts.size(), [&](std::size_t e) { return v.verdicts[e] == verdict; });
        };
        report_.invalid_elements = listed(Verdict::invalid);
        report_.undecided_elements = listed(Verdict::undecided);
    }

    /// Validates the mesh with its reversed elements turned, if no other element is inverted when straight.
    Outcome<Done> judge_turned() {
        const std::size_t reversed = soundness_[Defect::reversed_element].count;
        if (reversed == 0 || reversed != validation_.straight_inverted) return Done{};
        return step("validate", [&](const Execution& e) -> Outcome<Done> {
            const auto turned = prepare(as_mesh(mesh_), part_of(e, 0, 0.5));
            if (!turned) return Done{};  // the mesh has other defects
            const auto quadratic = as_quadratic(turned->mesh);
            if (!quadratic) return fail(quadratic.error());
            const auto validation = validate(*quadratic, options_.min_scaled_jacobian, part_of(e, 0.5, 1));
            if (!validation) return fail(validation.error());
            report_.is_only_reversed = validation->invalid + validation->undecided == 0;
            return Done{};
        });
    }

    template <class T>
    Outcome<Done> fill(Column<T>& column, const Execution& execution, auto&& value) {
        return map_each(execution, judged_count(linear_), [&](std::size_t e) { return static_cast<T>(value(e)); })
            .map([&](Buffer<T> values) {
                column = std::move(values);
                return Done{};
            });
    }

    Outcome<Done> measure(const Execution& execution) {
        ElementColumns& columns = report_.elements;
        auto done =
            fill(columns.straight_inverted, part_of(execution, 0, columns.is_curved() ? 1 : 0.5), [&](std::size_t e) {
                if constexpr (D == 3)
                    if (is_standalone_surface(linear_))
                        return straight_inverted(surface_triangle(mesh_, mesh_.mid_nodes.view(), e));
                return straight_inverted(nodal_element<D>(mesh_, mesh_.mid_nodes.view(), ElementId(e)));
            });
        if (!done) return done;
        report_.straight_inverted_elements =
            numbers_where(judged_count(linear_), [&](std::size_t e) { return columns.straight_inverted[e] == 1; });
        if (columns.is_curved()) {
            columns.min_scaled_jacobian = validation_.min_scaled_jacobian;
            add_histogram(Quantity::scaled_jacobian, columns.min_scaled_jacobian);
        } else {
            done = fill(columns.quality, part_of(execution, 0.5, 0.7), [&](std::size_t e) {
                       return quality_of(linear_, e);
                   }).and_then([&](Done) {
                return fill(columns.volume, part_of(execution, 0.7, 0.8),
                            [&](std::size_t e) { return measure_of(linear_, e); });
            });
            if (!done) return done;
            add_histogram(Quantity::quality, columns.quality);
        }
        auto worst = find_worst_elements(Judged<D>{mesh_, validation_, soundness_, report_}, options_.worst,
                                         without_progress(execution));
        if (!worst) return fail(worst.error());
        report_.worst = std::move(*worst);
        return Done{};
    }

    Outcome<Done> measure_in_metric() {
        if (!metric_) return Done{};
        return step("metric", [&](const Execution& e) -> Outcome<Done> {
            const auto metric = log_metrics_of_file<D>(*metric_, linear_.points.size(), part_of(e, 0, 0.2));
            if (!metric) return fail(metric.error());
            append(report_.notices, metric->notices);
            auto measured =
                measure_unit_mesh(linear_, mesh_.edges, metric->log_metrics, metric_->name, part_of(e, 0.2, 0.3));
            if (!measured) return fail(measured.error());
            append(report_.histograms, histograms_of(*measured, "count"));
            report_.unit_mesh = std::move(measured->report);
            if (input_.degree == 1) return Done{};
            auto curved =
                measure_curved_unit_mesh(mesh_, metric->log_metrics, metric_->name, options_.worst, part_of(e, 0.3, 1));
            if (!curved) return fail(curved.error());
            append(report_.histograms, histograms_of(*curved, "count"));
            report_.curved_unit_mesh = std::move(curved->report);
            return Done{};
        });
    }

    Outcome<Done> interpolate() {
        if (options_.fields.empty()) return Done{};
        return field_errors(mesh_, validation_.min_scaled_jacobian, options_.fields, around_)
            .map([&](std::vector<FieldErrors> errors) {
                report_.interpolation = std::move(errors);
                return Done{};
            });
    }

    static void append(auto& list, const auto& items) { list.insert(list.end(), items.begin(), items.end()); }

    void add_histogram(Quantity quantity, const Column<float>& values) {
        if (values.empty()) return;
        Histogram h{quantity, limits_of(quantity), {}};
        h.series.push_back(counted("count", h.limits, std::vector<double>(values.begin(), values.end())));
        report_.histograms.push_back(std::move(h));
    }

    Mesh<D> input_;
    LinearMesh<D> linear_;
    QuadraticMesh<D> mesh_;  ///< a straight mesh is elevated
    const std::optional<MetricFile>& metric_;
    const CheckOptions& options_;
    const StepWrapper& around_;
    Soundness soundness_;
    Validation<D> validation_;
    CheckReport report_;
};

}  // namespace

Outcome<CheckReport> check_mesh(DecodedMesh mesh, const std::optional<MetricFile>& metric, const CheckOptions& options,
                                const StepWrapper& around) {
    const FileNumbers numbers = numbers_of(mesh);
    auto report =
        std::visit([&]<int D>(Mesh<D> m) { return Checker<D>(std::move(m), numbers, metric, options, around).check(); },
                   std::move(mesh.mesh));
    if (report)
        for (Notice& notice : mesh.notices) report->notices.push_back(std::move(notice.what));
    return report;
}

SoundnessReport::ByDefect<std::vector<std::size_t>> SoundnessReport::first() const {
    ByDefect<std::vector<std::size_t>> all;
    for (const auto& [name, found] : findings) all.emplace_back(name, found.first);
    return all;
}

namespace {

template <int D>
Outcome<MeshFields> fields_of(const LinearMesh<D>& mesh, const CheckReport& report, const Execution& execution) {
    const ElementColumns& columns = report.elements;
    const auto qualities = map_each(execution, judged_count(mesh), [&](std::size_t e) { return quality_of(mesh, e); });
    if (!qualities) return fail(qualities.error());
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<MeshField> fields{cell_field(mesh, "verdict", 0, columns.verdicts, std::int32_t{-1}),
                                  cell_field(mesh, "quality", 0, *qualities, nan)};
    if (!columns.min_scaled_jacobian.empty())
        fields.push_back(cell_field(mesh, "scaled_jacobian", 0, columns.min_scaled_jacobian, nan));
    return MeshFields(std::move(fields));
}

}  // namespace

Outcome<MeshFields> check_fields(const AnyMesh& mesh, const CheckReport& report, const Execution& execution) {
    return std::visit([&](const auto& m) { return fields_of(straight_simplices(m), report, execution); }, mesh);
}

template double quality_of<2>(const LinearMesh<2>&, std::size_t);
template double quality_of<3>(const LinearMesh<3>&, std::size_t);

}  // namespace camber::run
