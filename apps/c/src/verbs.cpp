// Verbs for meshes in memory, and the text of each thread's last error.
#include <algorithm>
#include <cstddef>
#include <exception>
#include <functional>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "camber.h"
#include "handles.hpp"
#include "program.hpp"
import camber.core;
import camber.app_shell;
import camber.commands;
import camber.config;
import camber.io;
import camber.recipes;
import camber.reports;

namespace camber::c {

namespace {

std::string& last_error() {
    static thread_local std::string text;
    return text;
}

int status_of(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::usage: return CAMBER_USAGE;
        case ErrorKind::input:
        case ErrorKind::unsupported:
        case ErrorKind::write: return CAMBER_INPUT;
        case ErrorKind::stopped: return CAMBER_STOPPED;
        case ErrorKind::memory:
        case ErrorKind::internal: return CAMBER_INTERNAL;
    }
    return CAMBER_INTERNAL;
}

}  // namespace

int status_of(const Error& error) {
    last_error() = describe(error);
    return status_of(error.kind);
}

int guarded_status(const std::function<int()>& f) {
    try {
        return f();
    } catch (const std::bad_alloc& failure) {
        return status_of(out_of_memory(failure));
    } catch (const std::length_error&) {  // thrown for a length that no memory can hold
        return status_of(out_of_memory(std::bad_alloc()));
    } catch (const std::exception& error) {
        return status_of(Error{ErrorKind::internal, error.what(), {}, {}, {}});
    }
}

Error wrong_argument(const std::string& function, const std::string& argument, std::string what, std::string remedy) {
    return {ErrorKind::usage, std::move(what), function + ": " + argument, {}, std::move(remedy)};
}

int missing(const char* function, std::initializer_list<Pointer> arguments) {
    for (const Pointer& argument : arguments)
        if (argument.value == nullptr) return status_of(wrong_argument(function, argument.name, "is NULL"));
    return CAMBER_OK;
}

int wrong_first(const char* function, int first) {
    if (first == 0 || first == 1) return CAMBER_OK;
    return status_of(wrong_argument(function, "first", "is " + std::to_string(first),
                                    "give 0, or 1 if node numbers start at 1, as in Fortran and Julia"));
}

}  // namespace camber::c

const char* camber_version(void) { return CAMBER_VERSION; }
const char* camber_error(void) { return camber::c::last_error().c_str(); }

// ---------------------------------------------------------------- verbs

using namespace camber;

namespace {

/// Lets this process read CAD models, since a library cannot start its host program a second time.
void prepare() {
    static std::once_flag once;
    std::call_once(once, [] { app::start_itself_by({}); });
}

app::Host host_of(const camber_options* options, std::stop_source stop) {
    app::Host host{.stop = stop.get_token(), .progress = [](const std::string&, double) {}};
    if (options == nullptr || options->progress == nullptr) return host;
    host.progress = [progress = options->progress, context = options->context, stop](const std::string& stage,
                                                                                     double share) mutable {
        if (progress(stage.c_str(), share, context) != 0) stop.request_stop();
    };
    return host;
}

/// A call of an interface function. The mesh and the options may be NULL.
struct Call {
    const char* function;
    const camber_mesh* mesh;
    const camber_options* options;
};

Outcome<std::optional<Solution>> metric_of(const Call& call) {
    const auto& [function, mesh, options] = call;
    if (options == nullptr || options->metric == nullptr) return std::nullopt;
    if (mesh == nullptr)
        return fail(c::wrong_argument(function, "options.metric", "does not belong to a mesh", "give the mesh too"));
    const int dimension = camber_dimension(mesh), width = options->metric_width;
    const int tensor = values_per_vertex(FieldKind::symmetric_tensor, dimension);
    if (width != 1 && width != tensor)
        return fail(c::wrong_argument(function, "options.metric_width", "is " + std::to_string(width),
                                      "give 1, a size, or " + std::to_string(tensor) + ", a tensor"));
    const auto rows = static_cast<std::size_t>(camber_vertices(mesh));
    Buffer<double> values(options->metric, options->metric + rows * static_cast<std::size_t>(width));
    return std::optional(Solution{dimension,
                                  {width == 1 ? FieldKind::scalar : FieldKind::symmetric_tensor},
                                  rows,
                                  Column<double>(std::move(values))});
}

constexpr const char *mesh_name = "memory:mesh", *metric_name = "memory:metric.sol";

/// Stores an error and returns its status. In the error's text, names of arguments replace internal names of meshes and
/// metrics.
int status_in(const char* function, Error error) {
    constexpr std::string_view metric = "memory:metric", mesh = mesh_name;
    if (error.where.starts_with(metric)) error.where = std::string(function) + ": options.metric";
    if (error.where.starts_with(mesh)) error.where = std::string(function) + ": mesh" + error.where.substr(mesh.size());
    return c::status_of(error);
}

/// True if the word is the option, with or without `=value`.
bool is_option(std::string_view word, std::string_view option) {
    return word.starts_with(option) && (word.size() == option.size() || word[option.size()] == '=');
}

/// Checks the words of camber_run, of which the first is the verb. Errors: usage (a NULL word, a verb that does not
/// work on a mesh in memory, an option for which the function has an argument or result).
Outcome<std::vector<std::string>> words_of(int count, const char* const* word, bool has_metric) {
    const auto wrong = [](int w, const std::string& what, const std::string& remedy) {
        return fail(c::wrong_argument("camber_run", "word[" + std::to_string(w) + "]", what, remedy));
    };
    if (count < 1)
        return fail(c::wrong_argument("camber_run", "words", "is " + std::to_string(count), "give at least the verb"));
    for (int w = 0; w < count; ++w)
        if (word[w] == nullptr) return wrong(w, "is NULL", "words is the number of words");
    const std::vector<std::string> words(word, word + count);
    const std::string& verb = words.front();
    if (verb != "curve" && verb != "remesh" && verb != "repair" && verb != "adapt" && verb != "check")
        return wrong(0, in_quotes(verb) + " is not a verb for meshes in memory",
                     "give curve, remesh, repair, adapt or check");
    if (has_metric && verb == "repair")
        return fail(c::wrong_argument("camber_run", "options.metric", "cannot be combined with repair", "give none"));
    for (int w = 1; w < count; ++w) {
        const std::string_view at = words[static_cast<std::size_t>(w)];
        if (has_metric && is_option(at, "--metric"))
            return wrong(w, "--metric cannot be combined with options.metric", "give one of them");
        if (verb == "check" && is_option(at, "--metric"))
            return wrong(w, "--metric cannot be combined with a check in memory", "give options.metric");
        if (at.starts_with("-o") || is_option(at, "--output"))
            return wrong(w, "the result is returned, no file is written", "use camber_write");
        if (verb == "check" && (is_option(at, "--vtu") || is_option(at, "--page")))
            return wrong(w, "a check in memory writes no file", "use the program");
    }
    return words;
}

Outcome<config::Pipeline> pipeline_of(const app::Call& call) {
    auto pipeline = call.work.pipeline();
    if (!pipeline || !pipeline->adapt.is_requested()) return pipeline;
    if (!pipeline->adapt.solve.empty())
        return fail(ErrorKind::usage, "is a command, which only the program can run", "--solve", {},
                    "use camber adapt");
    return config::with_values(*pipeline, {}, "words");
}

int finish(app::MemoryResult outcome, camber_result** result) {
    outcome.mesh.fields = run::as_mesh_fields(outcome.mesh.mesh, outcome.solution);
    *result =
        new camber_result{camber_mesh{std::move(outcome.mesh)}, std::move(outcome.report), std::move(outcome.metric)};
    return outcome.meets_requirements ? CAMBER_OK : CAMBER_NOT_CERTIFIED;
}

int run_pipeline(config::Pipeline pipeline, int degree, const Call& call, std::optional<Solution> metric,
                 camber_result** result) {
    const auto& [function, mesh, options] = call;
    app::Host host = host_of(options, {});
    if (mesh != nullptr) host.memory_inputs.meshes[mesh_name] = mesh->value;
    if (metric) host.memory_inputs.metrics[metric_name] = std::move(*metric);
    if (pipeline.adapt.is_requested()) {
        auto outcome = app::adapt_in_memory(std::move(pipeline), degree, {}, std::move(host));
        return outcome ? finish(std::move(outcome->result), result) : status_in(function, outcome.error());
    }
    auto outcome = app::run_in_memory(std::move(pipeline), std::move(host));
    return outcome ? finish(std::move(*outcome), result) : status_in(function, outcome.error());
}

int check(const app::CheckArguments& arguments, const Call& call, const std::optional<Solution>& metric,
          camber_result** result) {
    auto found = app::check_in_memory(call.mesh->value, metric, arguments.options, host_of(call.options, {}));
    if (!found) return status_in(call.function, found.error());
    *result = new camber_result{{}, std::move(found->report), {}};
    return found->all_good ? CAMBER_OK : CAMBER_NOT_CERTIFIED;
}

}  // namespace

int camber_run(const camber_mesh* mesh, int count, const char* const* word, const camber_options* options,
               camber_result** result) {
    if (const int wrong = c::missing("camber_run", {{"mesh", mesh}, {"word", word}, {"result", result}})) return wrong;
    prepare();
    return c::guarded_status([&] {
        const Call call{"camber_run", mesh, options};
        auto metric = metric_of(call);
        if (!metric) return c::status_of(metric.error());
        auto checked = words_of(count, word, metric->has_value());
        if (!checked) return c::status_of(checked.error());
        std::vector<std::string> words = std::move(*checked);
        const std::string name = words.front();
        words.insert(words.begin() + 1, mesh_name);
        if (name != "check") words.insert(words.end(), {"-o", mesh_name});
        if (*metric && name != "check") words.push_back(std::string("--metric=") + metric_name);
        const auto parsed = app::call_of(std::move(words));
        if (!parsed) return c::status_of(parsed.error());
        const app::Call& verb = **parsed;
        if (name == "check") return check(verb.arguments.check, call, *metric, result);
        auto pipeline = pipeline_of(verb);
        if (!pipeline) return c::status_of(pipeline.error());
        const int degree = verb.arguments.adapt.degree == 1 ? 1 : 0;
        return run_pipeline(std::move(*pipeline), degree, call, std::move(*metric), result);
    });
}

int camber_run_config(const camber_mesh* mesh, const char* json, const camber_options* options,
                      camber_result** result) {
    if (const int wrong = c::missing("camber_run_config", {{"json", json}, {"result", result}})) return wrong;
    prepare();
    return c::guarded_status([&] {
        const Call call{"camber_run_config", mesh, options};
        auto metric = metric_of(call);
        if (!metric) return c::status_of(metric.error());
        const std::vector<std::string> input =
            mesh != nullptr ? std::vector<std::string>{std::string("input={\"mesh\": \"") + mesh_name + "\"}"}
                            : std::vector<std::string>{};
        auto pipeline = config::read_pipeline(json, "config", input);
        if (!pipeline) return c::status_of(pipeline.error());
        if (*metric && pipeline->metric != config::Pipeline{}.metric)
            return c::status_of(c::wrong_argument(
                "camber_run_config", "json", "\"metric\" cannot be combined with options.metric", "give one of them"));
        if (*metric) pipeline->metric = config::FilePath{metric_name};
        return run_pipeline(std::move(*pipeline), 0, call, std::move(*metric), result);
    });
}

const camber_mesh* camber_result_mesh(const camber_result* result) {
    if (c::missing("camber_result_mesh", {{"result", result}})) return nullptr;
    return result->mesh ? &*result->mesh : nullptr;
}
const char* camber_result_report(const camber_result* result) {
    if (c::missing("camber_result_report", {{"result", result}})) return nullptr;
    return result->report.c_str();
}
int64_t camber_result_metric_size(const camber_result* result, int* width) {
    const bool has_metric =
        c::missing("camber_result_metric_size", {{"result", result}}) == CAMBER_OK && result->metric;
    if (width != nullptr) *width = has_metric ? static_cast<int>(row_width(*result->metric)) : 0;
    return has_metric ? static_cast<int64_t>(result->metric->rows) : 0;
}
int camber_result_metric(const camber_result* result, double* values) {
    if (const int wrong = c::missing("camber_result_metric", {{"result", result}, {"values", values}})) return wrong;
    if (!result->metric)
        return c::status_of(
            c::wrong_argument("camber_result_metric", "result", "has no metric", "see camber_result_metric_size"));
    std::copy(result->metric->values.begin(), result->metric->values.end(), values);
    return CAMBER_OK;
}
void camber_free_result(camber_result* result) { delete result; }
