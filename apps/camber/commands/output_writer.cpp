module;
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.commands;
import camber.core;
import camber.io;
import camber.distributed;
import camber.config;
import camber.recipes;
import camber.reports;
import :execution;

namespace camber::app {

namespace {

struct Placed {
    AnyMesh mesh;
    MeshFields fields, carried;
};
Outcome<Placed> raised(const run::Run& run, const MeshFields& carried, const Lift& lift, const StepWrapper& around) {
    return run_step(around, "raise", [&](const Execution& execution) -> Outcome<Placed> {
        const Execution quiet = without_progress(execution);
        auto mesh = camber::raised(run.mesh, lift, quiet);
        if (!mesh) return fail(std::move(mesh.error()));
        auto fields = camber::raised(run.fields, quiet);
        if (!fields) return fail(std::move(fields.error()));
        auto solution = camber::raised(carried, quiet);
        if (!solution) return fail(std::move(solution.error()));
        return Placed{std::move(*mesh), std::move(*fields), std::move(*solution)};
    });
}

std::vector<Notice> losses_in(const MeshFormat& format, AnyMesh mesh, NamesOfGroups names) {
    if (names == NamesOfGroups::by_the_caller) std::visit([](auto& m) { m.groups = {}; }, mesh);
    return format.losses(mesh);
}

struct OutputWriter {
    run::Run& run;
    const config::Output& output;
    const StepWrapper& around;
    Written& written;
    const InputForm& input;
    NamesOfGroups names = {};
    MeshFields carried_fields;  ///< fields of the solution on the run's mesh
    /// Result in space if the input mesh was flat: for formats without 2D meshes, and for all others if the input's
    /// format has 2D meshes.
    std::optional<Placed> in_space = {};

    [[nodiscard]] const AnyMesh& mesh_for(const MeshFormat& format) const {
        return writes_3d(format) ? in_space->mesh : run.mesh;
    }
    [[nodiscard]] bool writes_3d(const MeshFormat& format) const {
        return in_space && (format.is_always_3d || !input.is_always_3d);
    }

    /// All fields for viewers. For other formats, the fields of the solution that the format stores.
    [[nodiscard]] MeshFields fields_for(const MeshFormat& format) const {
        const bool is_raised = writes_3d(format);
        const MeshFields& carried = is_raised ? in_space->carried : carried_fields;
        MeshFields all;
        for (const MeshField& field : carried)
            if (format.has_fields && (!format.can_store || format.can_store(field))) all = std::move(all).with(field);
        if (!format.for_viewers) return all;
        for (const MeshField& field : is_raised ? in_space->fields : run.fields) all = std::move(all).with(field);
        return all;
    }

    [[nodiscard]] Outcome<Done> write() {
        for (const std::string& path : {output.mesh, output.vtu}) {
            if (path.empty()) continue;
            const auto format = format_of(path);
            if (!format) return fail(format.error());
            if (path == output.mesh && output.partition > 0) {
                if (auto done = write_parts_with(**format); !done) return done;
                continue;
            }
            if (auto done = write_with(**format, path, fields_for(**format)); !done) return done;
        }
        if (!output.mesh.empty())
            if (const auto format = format_of(output.mesh))
                for (Notice& notice : losses_in(**format, mesh_for(**format), names)) {
                    if (notice.is_detail) run.details.push_back(notice.what);
                    run.report.notices.push_back(std::move(notice.what));
                }
        if (run.metric && !output.metric.empty())
            if (auto done = write_metric(*run.metric, output.metric); !done) return done;
        if (!run.solution.empty() && !output.solution.empty())
            if (auto done = write_solution_of_run(); !done) return done;
        if (!output.plots.empty())
            if (auto done = write_plots(run.report.histograms, output.plots, written); !done) return done;
        return output.page.empty() ? Done{} : write_page_of_run();
    }

    Outcome<Done> write_page_of_run() {
        DecodedMesh result{run.mesh, {}};
        result.fields = run.fields;
        std::vector<Notice> reported_notices;
        run::PageSource source;
        source.mesh = run.mesh;
        source.fields = fields_at_nodes(result, reported_notices);
        source.histograms = run.report.histograms;
        if (run.report.boundary) source.distances = run.report.boundary->distances;
        return written.add(output.page, around("write page", [&](const Execution& execution) -> Outcome<Done> {
                               auto checked =
                                   run::check_mesh(std::move(result), {}, {}, [&](std::string_view, const auto& body) {
                                       return body(without_progress(execution));
                                   });
                               if (!checked) return fail(checked.error());
                               source.report = std::move(*checked);
                               source.numbers = run::full_table(run.report) + "\n" + run::check_table(source.report);
                               return write_page(std::move(source), output.mesh.empty() ? output.page : output.mesh,
                                                 output.page, {}, execution);
                           }));
    }

    /// The mesh's format may be named. Other files have that of their ending.
    [[nodiscard]] Outcome<const MeshFormat*> format_of(const std::string& path) const {
        const bool is_mesh = &path == &output.mesh || path == output.mesh;
        if (is_mesh && output.partition > 0) return format_of_parts(path, output.format);
        return format_of_mesh(path, is_mesh ? output.format : std::string(), input.format);
    }

    /// Rows are in the order of the mesh file.
    Outcome<Done> write_solution_of_run() {
        DecodedMesh result{run.mesh, {}};
        result.lift = input.lift;
        result.is_always_3d = input.is_always_3d;
        result.format = input.format;
        return written.add(output.solution, around("write fields", [&](const Execution& execution) {
                               return write_nodal_fields(result, run.solution, output.solution, {}, execution);
                           }));
    }

    Outcome<Done> write_with(const MeshFormat& format, const std::string& path, const MeshFields& fields) {
        if (format.renames)
            for (Notice& notice : format.renames(fields)) run.report.notices.push_back(std::move(notice.what));
        const std::string stage = format.for_viewers ? "write " + std::string(format.name) : "write";
        auto done = around(stage, [&](const Execution& execution) {
            return write_mesh(format, mesh_for(format), fields, EncodeOptions{output.vtu_cells}, path, execution);
        });
        return written.add(path, std::move(done));
    }

    Outcome<Done> write_parts_with(const MeshFormat& format) {
        DecodedMesh whole{mesh_for(format), {}};
        whole.fields = fields_for(format);
        return around("write", [&](const Execution& execution) {
            return write_in_parts(format, whole,
                                  {output.mesh, static_cast<std::size_t>(output.partition), {output.vtu_cells}},
                                  written, execution);
        });
    }

    Outcome<Done> write_metric(const Solution& metric, const std::string& path) {
        if (is_solution_file(path)) {
            const auto format = format_to_write(solution_formats(), path);
            if (!format) return fail(format.error());
            return written.add(path, around("write metric", [&](const Execution& execution) {
                                   return write_solution(**format, metric, path, execution);
                               }));
        }
        const auto format = format_of_mesh(path, {}, input.format);
        if (!format) return fail(format.error());
        const auto fields = run_step(around, "fields", [&](const Execution& execution) {
            const Execution quiet = without_progress(execution);
            auto of_metric = run::solution_fields(metric, path, run.mesh, quiet);
            return of_metric && writes_3d(**format) ? camber::raised(*of_metric, quiet) : of_metric;
        });
        if (!fields) return fail(fields.error());
        return write_with(**format, path, *fields);
    }
};

/// Writes the rows that a run stores on its ranks, and frees them.
template <int D>
Outcome<Done> write_rows(FinishedRows<D>& rows, const Host& host, const config::Output& output,
                         const Execution& execution) {
    Ranks& ranks = *host.ranks;
    if (output.partition == 0)
        return write_meshb_together<D, 1>(
            ranks, output.mesh, {rows.totals, rows.lists}, 1, [&](std::size_t) { return std::exchange(rows.part, {}); },
            execution);
    const auto parts = static_cast<std::size_t>(output.partition);
    const RowCounts whole{rows.totals.vertices, rows.totals.elements, rows.totals.facets, rows.totals.edges};
    const auto own = parts_of_finished<D>(std::exchange(rows, {}), parts, host.partition, ranks);
    if (!own) return fail(own.error());
    return write_parts_of_ranks(ranks, whole, *own, {output.mesh, parts, {output.vtu_cells}}, execution)
        .map([](const auto&) { return Done{}; });
}
Outcome<Done> write_rows(run::Run& run, const Host& host, const config::Output& output, const Execution& execution) {
    return std::visit(
        [&]<class Rows>(Rows& rows) -> Outcome<Done> {
            if constexpr (std::is_same_v<Rows, std::monostate>)
                return Done{};
            else
                return write_rows(rows, host, output, execution);
        },
        run.rows);
}

}  // namespace

Outcome<Done> write_outputs(run::Run& run, const config::Output& files, const InputForm& input,
                            const StepWrapper& around, Written& written, const Host& host) {
    if (!std::holds_alternative<std::monostate>(run.rows))
        return written.add(files.mesh, around("write", [&](const Execution& execution) {
                               return write_rows(run, host, files, execution);
                           }));
    OutputWriter writer{run, files, around, written, input, host.names, run::as_mesh_fields(run.mesh, run.solution)};
    if (input.lift) {
        auto placed = raised(run, writer.carried_fields, *input.lift, around);
        if (!placed) return fail(placed.error());
        writer.in_space = std::move(*placed);
    }
    return host.ranks->rank() == 0 ? writer.write() : Done{};  // all ranks have the same data
}

}  // namespace camber::app
