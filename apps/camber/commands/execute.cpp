module;
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.config;
import camber.io;
import camber.run;
import :execute;

namespace camber::app {

namespace {

int exit_code(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::usage: return 2;
        case ErrorKind::input:
        case ErrorKind::unsupported:
        case ErrorKind::write: return 3;
        case ErrorKind::stopped: return 130;
        case ErrorKind::memory:
        case ErrorKind::internal: return 4;
    }
    return 4;
}

Outcome<GmfOptions> encoding_of(const std::string& path) {
    if (path.ends_with(".meshb")) return GmfOptions{.encoding = GmfEncoding::binary};
    if (path.ends_with(".mesh")) return GmfOptions{.encoding = GmfEncoding::ascii};
    return fail(ErrorKind::usage, "no format known for this ending", path, {}, "use .mesh or .meshb");
}

Outcome<Solution> read_solution(const std::string& path, const Execution& execution) {
    auto bytes = read_file(path, execution.stop);
    if (!bytes) return fail(bytes.error());
    auto decoded = decode_gmf_solution(*bytes, path, execution);
    if (!decoded) return fail(decoded.error());
    return std::move(decoded->solution);
}

Outcome<run::Inputs> read_inputs(const config::Pipeline& pipeline, const Execution& execution) {
    const auto* file = std::get_if<config::FilePath>(&pipeline.input);
    auto mesh = file != nullptr ? read_mesh(file->path, execution)
                                : run::generate_shape(std::get<config::Shape>(pipeline.input));
    if (!mesh) return fail(mesh.error());
    run::Inputs inputs{std::move(*mesh), {}};
    if (const auto* metric = std::get_if<config::FilePath>(&pipeline.metric)) {
        auto solution = read_solution(metric->path, execution);
        if (!solution) return fail(solution.error());
        inputs.metric = std::move(*solution);
    }
    return inputs;
}

Outcome<Done> write_mesh(const AnyMesh& mesh, const std::string& path, const Execution& execution) {
    auto options = encoding_of(path);
    if (!options) return fail(options.error());
    auto chunks = std::visit([&](const auto& m) { return encode_gmf_mesh(m, *options, execution); }, mesh);
    if (!chunks) return fail(chunks.error());
    std::vector<std::span<const std::byte>> parts(chunks->begin(), chunks->end());
    return write_file(path, parts, execution.stop);
}

/// Runs that cannot end well are refused before they begin.
Outcome<Done> check_memory(const AnyMesh& mesh) {
    const std::size_t needed = std::visit(
        []<class Mesh>(const Mesh& m) {
            const auto& linear = [&]() -> const LinearMesh<Mesh::dimension>& {
                if constexpr (requires { m.linear; })
                    return m.linear;
                else
                    return m;
            }();
            return run::estimated_peak_bytes(linear.points.size(), linear.elements.size(), Mesh::dimension);
        },
        mesh);
    const MemoryLimit limit = memory_limit();
    if (needed <= limit.bytes) return Done{};
    return fail(ErrorKind::memory,
                "the run needs about " + readable(needed) + " of memory, and " + limit.source + " gives " +
                    readable(limit.bytes),
                {}, {}, "give it more, or a smaller mesh");
}

/// The folder of an output, made if it is not there.
Outcome<Done> make_folder_of(const std::string& path) {
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    std::error_code error;
    if (!folder.empty()) std::filesystem::create_directories(folder, error);
    if (error)
        return fail(ErrorKind::write, "the folder cannot be made: " + error.message(), folder.string(), {},
                    "take another place");
    return Done{};
}

Outcome<Done> check_outputs(const config::Output& output) {
    for (const std::string& path : {output.mesh, output.report})
        if (auto made = make_folder_of(path); !made) return made;
    if (!output.mesh.empty()) {
        if (auto known = encoding_of(output.mesh); !known) return fail(known.error());
        if (auto writable = check_writable(output.mesh); !writable) return writable;
    }
    if (!output.report.empty()) return check_writable(output.report);
    return Done{};
}

}  // namespace

int report_error(const Error& error) {
    std::fprintf(stderr, "camber: %s\n", describe(error).c_str());
    return exit_code(error.kind);
}

Error of_file(Error error, const std::string& path) {
    const bool about_file = error.kind == ErrorKind::input || error.kind == ErrorKind::unsupported;
    if (about_file && error.where.empty()) error.where = path;
    return error;
}

Outcome<DecodedMesh> read_mesh(const std::string& path, const Execution& execution) {
    auto bytes = read_file(path, execution.stop);
    if (!bytes) return fail(bytes.error());
    return decode_gmf_mesh(*bytes, path, execution);
}

Outcome<run::Run> execute(const config::Pipeline& pipeline) {
    if (auto outputs = check_outputs(pipeline.output); !outputs) return fail(outputs.error());
    Progress progress;
    std::vector<run::StageTime> times;
    const std::stop_token stop = stop_on_signals();
    const run::Around around = [&](std::string_view stage,
                                   const std::function<Outcome<Done>(const Execution&)>& body) -> Outcome<Done> {
        progress.begin(std::string(stage));
        const Meter meter;
        auto done = guarded(
            [&] { return body(Execution{.threads = pipeline.threads, .stop = stop, .progress = progress.ticks()}); });
        if (!done && done.error().kind == ErrorKind::memory && done.error().where.empty()) done.error().where = stage;
        const Usage usage = meter.read();
        times.push_back({std::string(stage), usage.seconds, usage.peak_bytes});
        return done;
    };

    std::optional<run::Inputs> inputs;
    auto read = around(std::holds_alternative<config::FilePath>(pipeline.input) ? "read" : "generate",
                       [&](const Execution& execution) -> Outcome<Done> {
                           auto got = read_inputs(pipeline, execution);
                           if (!got) return fail(got.error());
                           inputs = std::move(*got);
                           return check_memory(inputs->mesh.mesh);
                       });
    if (!read) return fail(read.error());
    auto run = run::run_pipeline(pipeline, std::move(*inputs), around);
    if (!run) {
        const auto* file = std::get_if<config::FilePath>(&pipeline.input);
        return fail(of_file(run.error(), file != nullptr ? file->path : "the generated mesh"));
    }
    if (!pipeline.output.mesh.empty()) {
        auto written = around("write", [&](const Execution& execution) {
            return write_mesh(run->mesh, pipeline.output.mesh, execution);
        });
        if (!written) return fail(written.error());
    }
    progress.wipe();
    run->report.times = std::move(times);
    run->report.threads = pipeline.threads;
    if (!pipeline.output.report.empty()) {
        const std::string text = run::to_json(run->report);
        const std::span<const std::byte> bytes = as_bytes(text);
        if (auto written = write_file(pipeline.output.report, {&bytes, 1}); !written) return fail(written.error());
    }
    return run;
}

}  // namespace camber::app
