module;
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "viewer.hpp"
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.config;
import camber.io;
import camber.run;
import camber.validity;
import :execute;
import :given;
import :in_memory;
import :nodal_fields;
import :steps_for;

namespace camber::app {

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
    if (parts.script.empty())
        return fail(ErrorKind::unsupported, "this Camber was built without the viewer of pages", {}, {},
                    "install npm and esbuild and build it anew where npm reaches its registry");
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
