// Commands on meshes in memory
module;
#include <algorithm>
#include <cstddef>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
#include "viewer.hpp"
module camber.commands;
import camber.core;
import camber.transfer;
import camber.validity;
import camber.io;
import camber.app_shell;
import camber.config;
import camber.recipes;
import camber.reports;
import :execution;

namespace camber::app {

namespace {

/// A run returns the metric and the fields that its outputs ask for.
void keep_all(config::Output& output) {
    if (output.metric.empty()) output.metric = std::string(config::in_memory) + "metric";
    if (output.solution.empty()) output.solution = std::string(config::in_memory) + "solution";
}

/// Of the input, as far as a run keeps it: where it lies in space, and its format.
DecodedMesh with_place_of(AnyMesh made, const DecodedMesh& input) {
    DecodedMesh mesh{std::move(made), {}};
    mesh.lift = input.lift;
    mesh.always_in_space = input.always_in_space;
    mesh.format = input.format;
    return mesh;
}

}  // namespace

MadeInMemory made_of(run::Run run, const DecodedMesh& input) {
    std::vector<std::string> notices = run.report.notices;
    const bool holds = run.report.holds_what_was_asked();
    const bool is_valid = run.report.has_valid_elements();
    std::string report = run::to_json(run.report);
    return {with_place_of(std::move(run.mesh), input),
            std::move(report),
            std::move(run.metric),
            std::move(run.solution),
            std::move(notices),
            holds,
            is_valid};
}

Outcome<MadeInMemory> run_in_memory(config::Pipeline pipeline, Host host) {
    keep_all(pipeline.output);
    DecodedMesh input;
    if (const auto* const file = std::get_if<config::FilePath>(&pipeline.input.source))
        if (const auto found = host.given.meshes.find(file->path); found != host.given.meshes.end()) {
            input.lift = found->second.lift;
            input.always_in_space = found->second.always_in_space;
            input.format = found->second.format;
        }
    Written written;
    const Fit fit = [](config::Pipeline asked, const AnyMesh& mesh) -> Outcome<config::Pipeline> {
        return run::fitted_to(mesh, std::move(asked), 1);
    };
    auto run = execute(pipeline, written, fit, std::move(host));
    if (!run) return fail(run.error());
    return made_of(std::move(*run), input);
}

Outcome<MetricInMemory> metric_in_memory(const config::Pipeline& pipeline, Host host) {
    Progress progress(host.told);
    const Around around = steps_for(progress, host, pipeline.threads);
    auto inputs = run_step(around, "read", [&](const Execution& e) { return read_inputs(pipeline, host.given, e); });
    if (!inputs) return fail(inputs.error());
    auto made = run::made_metric(pipeline, std::move(*inputs), around);
    if (!made) return fail(made.error());
    return MetricInMemory{std::move(made->metric), made->report.complexity, made->report.largest_anisotropy,
                          std::move(made->notices)};
}

Outcome<Solution> hessians_in_memory(const DecodedMesh& mesh, const run::NamedField& field, Host host) {
    Progress progress(host.told);
    return run_step(steps_for(progress, host, 0), "recover",
                    [&](const Execution& e) { return run::hessians_of(mesh.mesh, field, e); });
}

Outcome<std::vector<run::NamedField>> transfer_in_memory(const DecodedMesh& old_mesh, const DecodedMesh& new_mesh,
                                                         std::vector<run::NamedField> fields,
                                                         const TransferOptions& options, Host host) {
    Progress progress(host.told);
    const Around around = steps_for(progress, host, 0);
    return run::fields_brought_to(new_mesh.mesh, old_mesh.mesh, std::move(fields), options, around)
        .map([](run::TransferredFields made) { return std::move(made.fields); });
}

Outcome<DecodedMesh> read_into_memory(const std::string& path, config::Flat flat, const DecodeOptions& options,
                                      Host host) {
    Progress progress(host.told);
    return run_step(steps_for(progress, host, 0), "read",
                    [&](const Execution& e) { return read_mesh(path, flat, options, e); });
}

Outcome<std::vector<std::string>> write_from_memory(const DecodedMesh& mesh, const std::vector<run::NamedField>& fields,
                                                    const std::string& path, const std::string& name, Host host) {
    const auto format = format_of_mesh(path, name, mesh.format);
    if (!format) return fail(format.error());
    std::vector<std::string> losses;
    std::vector<run::NamedField> held;
    for (const run::NamedField& field : fields)
        if ((*format)->holds_fields && check_place_for(path, name, field.kind))
            held.push_back(field);
        else
            losses.push_back("the format has no place for the field " + field.name);
    Progress progress(host.told);
    auto done = run_step(steps_for(progress, host, 0), "write",
                         [&](const Execution& e) { return write_with_mesh(mesh, held, **format, path, e); });
    if (!done) return fail(done.error());
    for (Notice& notice : (*format)->losses(mesh.mesh)) losses.push_back(std::move(notice.what));
    return losses;
}

std::vector<run::NamedField> nodal_fields_of(const DecodedMesh& mesh) {
    std::vector<Notice> ignored;
    return fields_at_nodes(mesh, ignored);
}

namespace {

/// A config's cycles whose meshes and solutions stay in memory, by the names that files of theirs would have.
class CyclesInMemory {
  public:
    CyclesInMemory(const config::Pipeline& pipeline, int degree, const Solver& solver, const Host& host)
        : pipeline_(pipeline), degree_(degree), solver_(solver), host_(host) {}

    Outcome<AdaptedInMemory> run() {
        for (int cycle = 0; cycle <= pipeline_.adapt.cycles; ++cycle) {
            auto made = make(cycle);
            if (!made) return fail(made.error());
            const bool is_valid = made->has_valid_elements;
            if (run::row_of_result(rows_, pipeline_.adapt) + 1 == rows_.size()) result_ = std::move(*made);
            if (!is_valid) {
                result_->holds_what_was_asked = false;
                reason_ = fmt::format("the mesh of cycle {} has elements that are not certified valid", cycle);
                break;
            }
            reason_ = run::reason_to_end(rows_, pipeline_.adapt);
            if (!reason_.empty()) break;
        }
        for (std::string& note : run::notes_on_result(rows_, pipeline_.adapt))
            result_->notices.push_back(std::move(note));
        return AdaptedInMemory{std::move(*result_), run::cycles_json(rows_), std::move(reason_)};
    }

  private:
    [[nodiscard]] run::CycleFiles names(int cycle) const {
        return run::files_of_cycle(pipeline_, std::string(config::in_memory) + run::name_of_cycle(cycle));
    }

    Outcome<MadeInMemory> make(int cycle) {
        const run::CycleFiles into = names(cycle);
        auto made = mesh_of(cycle, into);
        if (!made) return fail(made.error());
        run::CycleRow row = run::row_of(cycle, pipeline_, *made);
        MadeInMemory now = made_of(std::move(made->run), input_);
        if (!made->miss.empty()) {
            now.holds_what_was_asked = false;
            now.notices.push_back(made->miss);
        }
        const bool is_solved = solver_ && now.has_valid_elements;
        if (is_solved) {
            auto solved = solver_(now.mesh, now.solution, cycle);
            if (!solved) return fail(solved.error());
            now.solution = std::move(*solved);
        }
        const auto fields =
            is_solved ? std::span<const run::NamedField>(now.solution) : std::span<const run::NamedField>();
        const auto done =
            run::add_errors(row, now.mesh.mesh, fields, pipeline_, {.threads = pipeline_.threads, .stop = host_.stop});
        if (!done) return fail(done.error());
        keep(cycle, into, now);
        rows_.push_back(row);
        return now;
    }

    /// Cycles go on from the one before, and from the first mesh as the geometry.
    void keep(int cycle, const run::CycleFiles& into, const MadeInMemory& now) {
        if (cycle > 1) {
            values_.meshes.erase(names(cycle - 1).mesh);
            values_.solutions.erase(names(cycle - 1).solution);
        }
        values_.meshes[into.mesh] = now.mesh;
        if (solver_) values_.solutions[into.solution] = now.solution;
    }

    Outcome<run::CycleRun> mesh_of(int cycle, const run::CycleFiles& into) {
        const config::Pipeline pipeline = cycle == 0
                                              ? run::first_pipeline(pipeline_, into)
                                              : run::cycle_pipeline(pipeline_, cycle, names(0), names(cycle - 1), into);
        Host host = host_;
        for (const auto& [name, mesh] : values_.meshes) host.given.meshes.insert_or_assign(name, mesh);
        for (const auto& [name, solution] : values_.solutions) host.given.solutions.insert_or_assign(name, solution);
        if (const auto* const file = std::get_if<config::FilePath>(&pipeline.input.source))
            if (const auto found = host.given.meshes.find(file->path); found != host.given.meshes.end())
                input_ = found->second;
        const bool is_input = cycle == 0 || pipeline.input == pipeline_.input;
        const Fit fit = [this, cycle](config::Pipeline asked, const AnyMesh& mesh) -> Outcome<config::Pipeline> {
            if (degree_ == 1 && run::plan_size(mesh).degree == 2)
                return fail(ErrorKind::input, "the mesh is of degree 2, and one of degree 1 is asked for", {}, {},
                            "give the straight one, or leave the degree out");
            return run::fitted_to(mesh, std::move(asked), cycle);
        };
        return run::run_cycle(pipeline, rows_, [&](const config::Pipeline& tried) {
            Written none;
            return execute(tried, none, is_input ? fit : Fit{}, host);
        });
    }

    const config::Pipeline& pipeline_;
    int degree_;
    const Solver& solver_;
    const Host& host_;
    Given values_;  ///< meshes and solutions of cycles
    DecodedMesh input_;
    std::vector<run::CycleRow> rows_;
    std::optional<MadeInMemory> result_;
    std::string reason_;
};

}  // namespace

namespace {

/// The outputs that are files: of cycles in memory the last mesh and its report. Errors: usage.
Outcome<Done> check_files(const config::Output& files) {
    for (const std::string& path : {files.vtu, files.metric, files.solution, files.plots, files.page})
        if (!path.empty())
            return fail(ErrorKind::usage, "is an output of cycles whose meshes are files", path, {},
                        "leave it out, or use camber run");
    return check_outputs(files);
}

Outcome<Done> write_files(const config::Output& files, const MadeInMemory& made, const Host& host) {
    if (!files.report.empty())
        if (auto done = write_text(files.report, made.report); !done) return done;
    if (files.mesh.empty()) return Done{};
    return write_from_memory(made.mesh, made.solution, files.mesh, files.format, host).map([](const auto&) {
        return Done{};
    });
}

}  // namespace

Outcome<AdaptedInMemory> adapt_in_memory(config::Pipeline pipeline, int degree, const Solver& solver, Host host) {
    const config::Output files = files_of(pipeline.output);
    if (auto possible = check_files(files); !possible) return fail(possible.error());
    if (solver) pipeline.adapt.solve = {std::string(config::in_memory) + "solver"};
    pipeline.output.metric = std::string(config::in_memory) + "metric.sol";
    pipeline.output.solution = std::string(config::in_memory) + "carried.sol";
    if (auto possible = run::check_cycles(pipeline); !possible) return fail(possible.error());
    auto made = CyclesInMemory(pipeline, degree, solver, host).run();
    if (made)
        if (auto done = write_files(files, made->result, host); !done) return fail(done.error());
    return made;
}

namespace {

ElementColumn column(std::string name, const auto& values) {
    ElementColumn out{std::move(name), {}};
    out.values.reserve(values.size());
    std::ranges::transform(values, std::back_inserter(out.values), [](auto x) { return static_cast<double>(x); });
    return out;
}

std::vector<ElementColumn> columns_of(const run::CheckReport& report) {
    const run::ElementColumns& e = report.elements;
    std::vector<ElementColumn> all{column("reference", e.references), column("verdict", e.verdicts)};
    if (report.mesh.degree == 2) {
        all.push_back(column("min_scaled_jacobian", e.min_scaled_jacobian));
        all.push_back(column("straight_inverted", e.straight_inverted));
    } else {
        all.push_back(column("quality", e.quality));
        all.push_back(column("volume", e.volume));
    }
    return all;
}

}  // namespace

Outcome<CheckedInMemory> check_in_memory(const DecodedMesh& mesh, const std::optional<Solution>& metric,
                                         const run::CheckOptions& options, Host host) {
    Progress progress(host.told);
    const Around around = steps_for(progress, host, 0);
    std::optional<run::MetricFile> rows;
    if (metric) {
        auto sorted = run::rows_by_nodes(*metric, mesh, {.stop = host.stop});
        if (!sorted) return fail(sorted.error());
        rows = run::MetricFile{std::string(config::in_memory) + "metric",
                               run::rows_at_vertices(std::move(*sorted), mesh.mesh)};
    }
    const auto report = run::check_mesh(mesh, rows, options, around);
    if (!report) return fail(report.error());
    return CheckedInMemory{
        run::check_json_head(*report, std::string(config::in_memory) + "mesh", CAMBER_VERSION) + "\n}\n",
        run::check_answer(*report) + "\n" + run::check_table(*report), columns_of(*report), report->all_good()};
}

Outcome<std::string> page_in_memory(const DecodedMesh& mesh, const std::vector<run::NamedField>& fields,
                                    const std::string& title, const run::PageOptions& options, Host host) {
    Viewer parts = viewer();
    Progress progress(host.told);
    const Around around = steps_for(progress, host, 0);
    auto report = run::check_mesh(mesh, std::nullopt, {}, around);
    if (!report) return fail(report.error());
    run::PageSource source;
    source.mesh = mesh.mesh;
    source.fields = fields;
    source.title = title;
    source.version = CAMBER_VERSION;
    source.histograms = report->histograms;
    source.numbers = run::check_table(*report);
    source.report = std::move(*report);
    return run_step(around, "page", [&](const Execution& e) {
        return run::page(source, {std::move(parts.frame), std::move(parts.style), std::move(parts.script)}, options, e);
    });
}

Outcome<std::string> geometry_in_memory(const DecodedMesh& mesh, const config::Geometry& geometry,
                                        const run::InspectOptions& options, Host host) {
    Progress progress(host.told);
    const Around around = steps_for(progress, host, 0);
    auto source = run_step(around, "read", [&](const Execution& e) { return read_geometry(geometry, e, host.given); });
    if (!source) return fail(source.error());
    auto found = run::inspect_geometry(mesh, {geometry, std::move(*source)}, options, around);
    if (!found) return fail(found.error());
    return run::inspect_json(found->report, std::string(config::in_memory) + "mesh", CAMBER_VERSION);
}

}  // namespace camber::app
