// The verbs over handles.
#include <algorithm>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "camber.h"
#include "handles.hpp"
#include "words.hpp"
import camber.core;
import camber.app_shell;
import camber.commands;
import camber.config;
import camber.io;
import camber.run;

using namespace camber;

namespace {

/// CAD models are read in this process: the program that we are a library of cannot be started once more.
void prepare() {
    static std::once_flag once;
    std::call_once(once, [] { app::start_itself_by({}); });
}

/// Who is told of the work, and stops it.
app::Host host_of(const camber_options* options, std::stop_source stop) {
    app::Host host{.stop = stop.get_token(), .told = [](const std::string&, double) {}};
    if (options == nullptr || options->progress == nullptr) return host;
    host.told = [told = options->progress, context = options->context, stop](const std::string& stage,
                                                                             double share) mutable {
        if (told(stage.c_str(), share, context) != 0) stop.request_stop();
    };
    return host;
}

Outcome<std::optional<Solution>> metric_of(const camber_mesh* mesh, const camber_options* options) {
    if (options == nullptr || options->metric == nullptr) return std::nullopt;
    if (mesh == nullptr) return fail(ErrorKind::usage, "is of no mesh", "metric", {}, "give the mesh too");
    const int dimension = camber_dimension(mesh), width = options->metric_width;
    const int tensor = values_per_vertex(FieldKind::symmetric_tensor, dimension);
    if (width != 1 && width != tensor)
        return fail(ErrorKind::usage, "is " + std::to_string(width), "metric_width", {},
                    "give 1, a size, or " + std::to_string(tensor) + ", a tensor");
    const auto rows = static_cast<std::size_t>(camber_vertices(mesh));
    Buffer<double> values(options->metric, options->metric + rows * static_cast<std::size_t>(width));
    return std::optional(Solution{dimension,
                                  {width == 1 ? FieldKind::scalar : FieldKind::symmetric_tensor},
                                  rows,
                                  Column<double>(std::move(values))});
}

constexpr const char *mesh_name = "memory:mesh", *metric_name = "memory:metric.sol";

/// What arguments gave is as sound as what a config says; nobody is there who could run a solver.
Outcome<config::Pipeline> adapting(const app::Verb& verb) {
    auto pipeline = app::pipeline_of(verb.adapt);
    if (!pipeline) return pipeline;
    if (!pipeline->adapt.solve.empty())
        return fail(ErrorKind::usage, "is a command, which the program runs", "--solve", {}, "use camber adapt");
    if (auto read = config::read_pipeline(config::write_pipeline(*pipeline), "words"); !read) return read;
    return pipeline;
}

Outcome<config::Pipeline> pipeline_of(const app::Verb& verb, const std::string& name) {
    if (name == "curve") return app::pipeline_of(verb.curve);
    if (name == "remesh") return app::pipeline_of(verb.remesh);
    if (name == "repair") return app::pipeline_of(verb.repair);
    if (name == "adapt") return adapting(verb);
    return fail(ErrorKind::usage, "is no verb over a mesh in memory", name, {},
                "give curve, remesh, repair, adapt or check");
}

int finish(app::MadeInMemory made, camber_result** result) {
    made.mesh.fields = run::as_mesh_fields(made.mesh.mesh, made.solution);
    *result = new camber_result{camber_mesh{std::move(made.mesh)}, std::move(made.report), std::move(made.metric)};
    return made.holds_what_was_asked ? CAMBER_OK : CAMBER_NOT_CERTIFIED;
}

int run_pipeline(config::Pipeline pipeline, int degree, const camber_mesh* mesh, std::optional<Solution> metric,
                 const camber_options* options, camber_result** result) {
    app::Host host = host_of(options, {});
    if (mesh != nullptr) host.given.meshes[mesh_name] = mesh->value;
    if (metric) host.given.metrics[metric_name] = std::move(*metric);
    if (pipeline.adapt.is_asked()) {
        auto made = app::adapt_in_memory(std::move(pipeline), degree, {}, std::move(host));
        return made ? finish(std::move(made->last), result) : c::status_of(made.error());
    }
    auto made = app::run_in_memory(std::move(pipeline), std::move(host));
    return made ? finish(std::move(*made), result) : c::status_of(made.error());
}

int check(const camber_mesh* mesh, const app::Verb& verb, std::optional<Solution> metric, const camber_options* options,
          camber_result** result) {
    auto found = app::check_in_memory(mesh->value, metric, verb.check.options, host_of(options, {}));
    if (!found) return c::status_of(found.error());
    *result = new camber_result{{}, std::move(found->report), {}};
    return found->all_good ? CAMBER_OK : CAMBER_NOT_CERTIFIED;
}

}  // namespace

int camber_run(const camber_mesh* mesh, int count, const char* const* word, const camber_options* options,
               camber_result** result) {
    if (mesh == nullptr) return c::missing("mesh");
    if (word == nullptr || count < 1) return c::missing("word");
    if (result == nullptr) return c::missing("result");
    prepare();
    return c::guarded_status([&] {
        auto metric = metric_of(mesh, options);
        if (!metric) return c::status_of(metric.error());
        std::vector<std::string> words(word, word + count);
        const std::string name = words.front();
        words.insert(words.begin() + 1, mesh_name);
        if (name != "check") words.insert(words.end(), {"-o", mesh_name});
        if (*metric && name != "check") words.push_back(std::string("--metric=") + metric_name);
        const auto verb = app::verb_of(std::move(words));
        if (!verb) return c::status_of(verb.error());
        if (name == "check") return check(mesh, **verb, std::move(*metric), options, result);
        auto pipeline = pipeline_of(**verb, name);
        if (!pipeline) return c::status_of(pipeline.error());
        const int degree = name == "adapt" && (*verb)->adapt.degree == 1 ? 1 : 0;
        return run_pipeline(std::move(*pipeline), degree, mesh, std::move(*metric), options, result);
    });
}

int camber_run_config(const camber_mesh* mesh, const char* json, const camber_options* options,
                      camber_result** result) {
    if (json == nullptr) return c::missing("json");
    if (result == nullptr) return c::missing("result");
    prepare();
    return c::guarded_status([&] {
        auto metric = metric_of(mesh, options);
        if (!metric) return c::status_of(metric.error());
        const std::vector<std::string> input =
            mesh != nullptr ? std::vector<std::string>{std::string("input={\"mesh\": \"") + mesh_name + "\"}"}
                            : std::vector<std::string>{};
        auto pipeline = config::read_pipeline(json, "config", input);
        if (!pipeline) return c::status_of(pipeline.error());
        if (*metric) pipeline->metric = config::FilePath{metric_name};
        return run_pipeline(std::move(*pipeline), 0, mesh, std::move(*metric), options, result);
    });
}

const camber_mesh* camber_result_mesh(const camber_result* result) { return result->mesh ? &*result->mesh : nullptr; }
const char* camber_result_report(const camber_result* result) { return result->report.c_str(); }
int64_t camber_result_metric_size(const camber_result* result, int* width) {
    if (width != nullptr) *width = result->metric ? static_cast<int>(row_width(*result->metric)) : 0;
    return result->metric ? static_cast<int64_t>(result->metric->rows) : 0;
}
int camber_result_metric(const camber_result* result, double* values) {
    if (result == nullptr) return c::missing("result");
    if (values == nullptr) return c::missing("values");
    if (!result->metric) return c::status_of(Error{ErrorKind::usage, "no metric was made", "result", {}, {}});
    std::copy(result->metric->values.begin(), result->metric->values.end(), values);
    return CAMBER_OK;
}
void camber_free_result(camber_result* result) { delete result; }
