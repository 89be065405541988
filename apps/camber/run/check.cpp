module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>
module camber.run;
import camber.core;
import camber.bezier;
import camber.fields;
import camber.io;
import camber.validity;
import camber.soundness;
import camber.recipes;
import :check;
import :check_parts;
import :curved_unit_mesh;
import :element_measures;
import :field_errors;
import :file_numbers;
import :histogram;
import :pipeline;
import :report;
import :stages;
import :unit_mesh;

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
    Checker(std::optional<QuadraticMesh<D>> mesh, LinearMesh<D> linear, FileNumbers numbers,
            const std::optional<MetricFile>& metric, const CheckOptions& options, const Around& around)
        : mesh_(std::move(mesh)),
          linear_(std::move(linear)),
          numbers_(std::move(numbers)),
          metric_(metric),
          options_(options),
          around_(around),
          degree_(mesh_ ? 2 : 1) {}

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
                        degree_,
                        linear_.points.size(),
                        linear_.points.size() + (mesh_ ? mesh_->edges.size() : 0),
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
        auto made =
            mesh_ ? camber::check_mesh(*mesh_, options, around_) : camber::check_mesh(linear_, options, around_);
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
            const auto turned = prepare(*mesh_, part_of(e, 0, 0.5));
            if (!turned) return Done{};  // a mesh with other defects
            const auto validation = validate(turned->mesh, options_.min_scaled_jacobian, part_of(e, 0.5, 1));
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
        auto inverted = map_each(part_of(execution, 0, degree_ == 2 ? 1 : 0.5), n, [&](std::size_t e) {
            if constexpr (D == 3)
                if (is_surface_alone(linear_))
                    return static_cast<std::uint8_t>(
                        straight_inverted(surface_triangle(*mesh_, mesh_->mid_nodes.view(), e)));
            const auto element = nodal_element<D>(*mesh_, mesh_->mid_nodes.view(), ElementId(e));
            return static_cast<std::uint8_t>(straight_inverted(element));
        });
        if (!inverted) return fail(inverted.error());
        columns.straight_inverted = std::move(*inverted);
        report_.straight_inverted_elements =
            numbers_of(n, [&](std::size_t e) { return columns.straight_inverted[e] == 1; });
        if (degree_ == 2) {
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
        const Judged<D> judged{*mesh_, validation_, columns, soundness_, numbers_, degree_};
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
                measure_unit_mesh(linear_, mesh_->edges, metric->log_metrics, metric_->name, part_of(e, 0.2, 0.3));
            if (!measured) return fail(measured.error());
            for (Histogram& histogram : histograms_of(*measured, "count"))
                report_.histograms.push_back(std::move(histogram));
            report_.unit_mesh = std::move(measured->report);
            return degree_ == 2 ? measure_curves(metric->log_metrics, part_of(e, 0.3, 1)) : Done{};
        });
    }

    Outcome<Done> measure_curves(const Column<LogMetric<D>>& log_metrics, const Execution& execution) {
        auto measured = measure_curved_unit_mesh(*mesh_, log_metrics, metric_->name, options_.worst, execution);
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
            auto found = element_kinds(*mesh_, validation_.min_scaled_jacobian, e);
            if (!found) return fail(found.error());
            kinds = std::move(*found);
            return Done{};
        });
        for (const std::string& field : options_.fields)
            done = done.and_then([&](Done) {
                return step("interpolate", [&](const Execution& e) -> Outcome<Done> {
                    auto errors = field_errors(*mesh_, field, kinds, e);
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

    std::optional<QuadraticMesh<D>> mesh_;
    LinearMesh<D> linear_;
    FileNumbers numbers_;
    const std::optional<MetricFile>& metric_;
    CheckOptions options_;
    const Around& around_;
    int degree_;
    Soundness soundness_;
    Validation<D> validation_;
    CheckReport report_;
};

template <int D>
Outcome<CheckReport> check(LinearMesh<D> mesh, FileNumbers numbers, const std::optional<MetricFile>& metric,
                           const CheckOptions& options, const Around& around) {
    return Checker<D>(std::nullopt, std::move(mesh), std::move(numbers), metric, options, around).check();
}
template <int D>
Outcome<CheckReport> check(QuadraticMesh<D> mesh, FileNumbers numbers, const std::optional<MetricFile>& metric,
                           const CheckOptions& options, const Around& around) {
    LinearMesh<D> linear = mesh.linear;
    return Checker<D>(std::move(mesh), std::move(linear), std::move(numbers), metric, options, around).check();
}

}  // namespace

Outcome<CheckReport> check_mesh(DecodedMesh mesh, const std::optional<MetricFile>& metric, const CheckOptions& options,
                                const Around& around) {
    const FileNumbers numbers = numbers_of(mesh);
    Groups groups = groups_of(mesh.mesh);
    auto report =
        std::visit([&](auto m) { return check(std::move(m), numbers, metric, options, around); }, std::move(mesh.mesh));
    if (!report) return report;
    report->groups = std::move(groups);
    report->numbers = numbers;
    report->notices.reserve(mesh.notices.size());
    for (Notice& notice : mesh.notices) report->notices.push_back(std::move(notice.what));
    return report;
}

}  // namespace camber::run
