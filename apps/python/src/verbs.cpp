// Verbs of the Python module. Their arguments are the words of a command line.
#include "python.hpp"

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "program.hpp"
import camber.core;
import camber.app_shell;
import camber.commands;
import camber.config;
import camber.io;
import camber.recipes;
import camber.reports;
import camber.transfer;

namespace camber::python {

namespace {

using Words = std::vector<std::string>;

std::vector<run::NamedField> solution_on(const MeshHandle& mesh, const py::dict& fields) {
    bool is_at_vertices = true;
    for (const auto& [name, values] : fields) {
        const auto array = py::array::ensure(values);
        const bool has_rows = array && array.ndim() > 0;
        if (has_rows && static_cast<std::size_t>(array.shape(0)) != mesh.vertices()) is_at_vertices = false;
    }
    const std::size_t nodes = is_at_vertices ? mesh.nodes() : value_of(run::nodes_in_degree_2(mesh.value.mesh, {}));
    return fields_of(fields, mesh.dimension(), mesh.vertices(), nodes);
}

/// Objects in memory by the name that a config uses for them, for example {"memory:mesh": Mesh}. All metrics and
/// solutions belong to one mesh.
struct InMemory {
    py::dict meshes, metrics, solutions;
};

app::MemoryInputs memory_inputs_of(const InMemory& values, const MeshHandle* of) {
    app::MemoryInputs specified;
    for (const auto& [name, mesh] : values.meshes)
        specified.meshes[name.cast<std::string>()] = mesh.cast<const MeshHandle&>().value;
    for (const auto& [name, rows] : values.metrics)
        specified.metrics[name.cast<std::string>()] =
            metric_of(rows.cast<py::array>(), of ? of->dimension() : 3, name.cast<std::string>());
    for (const auto& [name, fields] : values.solutions)
        specified.solutions[name.cast<std::string>()] =
            of ? solution_on(*of, fields.cast<py::dict>()) : fields_of(fields.cast<py::dict>(), 3, 0, 0);
    return specified;
}

py::dict dict_of(app::MemoryResult outcome) {
    py::dict out;
    outcome.mesh.fields = run::as_mesh_fields(outcome.mesh.mesh, outcome.solution);
    const MeshHandle mesh = handle_of(std::move(outcome.mesh));
    out["solution"] = arrays_of(outcome.solution, mesh.dimension());
    out["metric"] = outcome.metric ? py::object(array_of(*outcome.metric)) : py::object(py::none());
    out["report"] = outcome.report;
    out["notices"] = outcome.notices;
    out["success"] = outcome.meets_requirements;
    out["mesh"] = mesh;
    return out;
}

Outcome<config::Pipeline> pipeline_of(const app::Call& call) {
    auto pipeline = call.work.pipeline();
    if (!pipeline || !pipeline->adapt.is_requested()) return pipeline;
    // Arguments are validated like a config file.
    return config::with_values(*pipeline, {}, "arguments");
}

py::dict run_pipeline(config::Pipeline pipeline, app::MemoryInputs specified, const py::object& progress) {
    return dict_of(BackgroundTask(progress).run([&](app::Host host) {
        host.memory_inputs = std::move(specified);
        return app::run_in_memory(std::move(pipeline), std::move(host));
    }));
}

py::dict run_words(const Words& words, const InMemory& values, const MeshHandle& mesh, const py::object& progress) {
    auto pipeline = value_of(pipeline_of(*value_of(app::call_of(words))));
    return run_pipeline(std::move(pipeline), memory_inputs_of(values, &mesh), progress);
}

/// `solver`: None, or a function with three arguments: a mesh, the solution transferred to it, and the cycle number.
py::dict adapt_pipeline(config::Pipeline pipeline, int degree, app::MemoryInputs specified, const py::object& solver,
                        const py::object& progress) {
    if (solver.is_none() && !pipeline.adapt.solve.empty())
        raise({ErrorKind::usage,
               "is a command, which only the program can run",
               "/adapt/solve",
               {},
               "give a function for solve, or use camber run"});
    BackgroundTask watched(progress);
    const app::Solver solve = [&](const DecodedMesh& on, const std::vector<run::NamedField>& guess,
                                  int cycle) -> Outcome<std::vector<run::NamedField>> {
        std::vector<run::NamedField> fields;
        const bool succeeded = watched.call([&] {
            const MeshHandle handle = handle_of(on);
            const py::dict outcome = solver(handle, arrays_of(guess, handle.dimension()), cycle);
            fields = solution_on(handle, outcome);
        });
        if (!succeeded) return fail(ErrorKind::stopped, "the solver raised");
        return fields;
    };
    auto outcome = watched.run([&](app::Host host) {
        host.memory_inputs = std::move(specified);
        return app::adapt_in_memory(std::move(pipeline), degree, solver.is_none() ? app::Solver() : solve,
                                    std::move(host));
    });
    py::dict out = dict_of(std::move(outcome.result));
    out["cycles"] = outcome.cycles;
    out["reason"] = outcome.reason;
    return out;
}

py::dict adapt_words(const Words& words, const InMemory& values, const MeshHandle& mesh, const py::object& solver,
                     const py::object& progress) {
    const auto call = value_of(app::call_of(words));
    auto pipeline = value_of(pipeline_of(*call));
    const int degree = call->arguments.adapt.degree == 1 ? 1 : 0;
    if (!solver.is_none()) pipeline.adapt.solve = {"memory:solver"};
    return adapt_pipeline(std::move(pipeline), degree, memory_inputs_of(values, &mesh), solver, progress);
}

py::dict run_config(const std::string& json, const InMemory& values, const MeshHandle* mesh, const py::object& solver,
                    const py::object& progress) {
    auto pipeline = value_of(config::read_pipeline(json, "config"));
    app::MemoryInputs specified = memory_inputs_of(values, mesh);
    if (pipeline.adapt.is_requested())
        return adapt_pipeline(std::move(pipeline), 0, std::move(specified), solver, progress);
    return run_pipeline(std::move(pipeline), std::move(specified), progress);
}

py::dict check(const Words& words, const MeshHandle& mesh, const std::optional<py::array>& metric,
               const py::object& progress) {
    const auto call = value_of(app::call_of(words));
    std::optional<Solution> rows;
    if (metric) rows = metric_of(*metric, mesh.dimension(), "metric");
    const auto found = BackgroundTask(progress).run([&](app::Host host) {
        return app::check_in_memory(mesh.value, rows, call->arguments.check.options, std::move(host));
    });
    py::dict out, elements;
    for (const app::ElementColumn& column : found.elements)
        elements[py::str(column.name)] =
            py::array_t<double>(static_cast<py::ssize_t>(column.values.size()), column.values.data());
    out["report"] = found.report;
    out["table"] = found.table;
    out["elements"] = elements;
    out["success"] = found.all_good;
    return out;
}

std::string page(const MeshHandle& mesh, const py::dict& fields, const std::string& title, const py::object& progress) {
    const auto known = fields_of(fields, mesh.dimension(), mesh.vertices(), mesh.nodes());
    return BackgroundTask(progress).run(
        [&](app::Host host) { return app::page_in_memory(mesh.value, known, title, {}, std::move(host)); });
}

std::string geometry(const Words& words, const MeshHandle& mesh, const py::dict& meshes, const py::object& progress) {
    const auto call = value_of(app::call_of(words));
    config::Pipeline pipeline;
    value_of(app::set_geometry(call->arguments.geometry.geometry, pipeline));
    app::MemoryInputs specified = memory_inputs_of({meshes, {}, {}}, nullptr);
    return BackgroundTask(progress).run([&](app::Host host) {
        host.memory_inputs = std::move(specified);
        return app::geometry_in_memory(mesh.value, pipeline.geometry, call->arguments.geometry.options,
                                       std::move(host));
    });
}

py::dict metric_of_config(config::Pipeline pipeline, app::MemoryInputs specified, const py::object& progress) {
    auto outcome = BackgroundTask(progress).run([&](app::Host host) {
        host.memory_inputs = std::move(specified);
        return app::metric_in_memory(pipeline, std::move(host));
    });
    py::dict out;
    out["metric"] = array_of(outcome.metric);
    out["complexity"] = outcome.complexity;
    out["largest_anisotropy"] = outcome.largest_anisotropy;
    out["notices"] = outcome.notices;
    return out;
}

py::dict metric_json(const std::string& json, const InMemory& values, const MeshHandle& mesh,
                     const py::object& progress) {
    auto pipeline = value_of(config::read_pipeline(json, "config"));
    return metric_of_config(std::move(pipeline), memory_inputs_of(values, &mesh), progress);
}

py::dict metric_words(const Words& words, const InMemory& values, const MeshHandle& mesh, const py::object& progress) {
    const auto call = value_of(app::call_of(words));
    const app::MetricArguments& a = call->arguments.metric;
    config::Pipeline pipeline;
    pipeline.input.source = config::FilePath{a.input};
    pipeline.solution.file = a.solution;
    pipeline.solution.fields = a.metric.fields;
    pipeline.threads = a.threads;
    config::SolutionMetric requested = a.metric;
    requested.sizes = value_of(app::read_sizes(a.sizes)).sizes;
    pipeline.metric = std::move(requested);
    return metric_of_config(std::move(pipeline), memory_inputs_of(values, &mesh), progress);
}

py::array hessian(const MeshHandle& mesh, const py::dict& fields) {
    const auto known = solution_on(mesh, fields);
    return array_of(BackgroundTask(py::none()).run([&](app::Host host) {
        return app::hessians_in_memory(mesh.value, known.front(), std::move(host));
    }));
}

py::dict transfer(const Words& words, const MeshHandle& old_mesh, const MeshHandle& new_mesh, const py::dict& fields,
                  const py::object& progress) {
    const auto call = value_of(app::call_of(words));
    auto known = solution_on(old_mesh, fields);
    const auto outcome = BackgroundTask(progress).run([&](app::Host host) {
        return app::transfer_in_memory(old_mesh.value, new_mesh.value, std::move(known),
                                       call->arguments.transfer.options, std::move(host));
    });
    return arrays_of(outcome, new_mesh.dimension());
}

MeshHandle read(const std::string& path, const std::string& flat, const Words& words, const py::object& progress) {
    const auto call = value_of(app::call_of(words));
    auto mesh = BackgroundTask(progress).run([&](app::Host host) {
        return app::read_into_memory(path, flat == "surface" ? config::Flat::surface : config::Flat::plane,
                                     call->arguments.info.read, std::move(host));
    });
    return handle_of(std::move(mesh));
}

Words write(const MeshHandle& mesh, const py::dict& fields, const std::string& path, const std::string& format,
            const py::object& progress) {
    const auto known = fields_of(fields, mesh.dimension(), mesh.vertices(), mesh.nodes());
    return BackgroundTask(progress).run(
        [&](app::Host host) { return app::write_from_memory(mesh.value, known, path, format, std::move(host)); });
}

MeshHandle generate(const Words& words, const py::object& progress) {
    const auto call = value_of(app::call_of(words));
    return handle_of(BackgroundTask(progress).run(
        [&](const app::Host& host) { return app::generate_in_memory(call->arguments.generate, host); }));
}

}  // namespace

void bind_verbs(py::module_& module) {
    py::class_<InMemory>(module, "InMemory").def(py::init<py::dict, py::dict, py::dict>());
    module.def("run_words", &run_words);
    module.def("run_config", &run_config);
    module.def("adapt_words", &adapt_words);
    module.def("check", &check);
    module.def("page", &page);
    module.def("geometry", &geometry);
    module.def("metric_json", &metric_json);
    module.def("metric_words", &metric_words);
    module.def("hessian", &hessian);
    module.def("transfer", &transfer);
    module.def("read", &read);
    module.def("write", &write);
    module.def("generate", &generate);
    module.def("arguments", &app::arguments_json);
    module.def("schema", &config::pipeline_schema);
}

}  // namespace camber::python
