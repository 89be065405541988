module;
#include <cstddef>
#include <filesystem>
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
import :formats;
import :named_files;

namespace camber::app {

namespace {

namespace fs = std::filesystem;

bool is_read(Role role) { return role == Role::input || role == Role::input_mesh; }

/// Where the path leads, with symbolic links followed as far as there is something.
fs::path resolved(const std::string& path) {
    std::error_code error;
    const fs::path whole = fs::absolute(path, error);
    fs::path target = fs::weakly_canonical(whole, error);
    return error ? whole.lexically_normal() : target;
}

bool is_standard(const std::string& path) { return path == standard_stream; }

/// Hard links too.
bool same_file(const std::string& a, const std::string& b) {
    std::error_code neither_exists;
    return resolved(a) == resolved(b) || fs::equivalent(a, b, neither_exists);
}

/// Pipes and devices: what is written there takes nothing away.
bool is_special(const std::string& path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

bool may_be_one(const NamedFile& a, const NamedFile& b) {
    if (is_standard(a.path) && is_standard(b.path)) return is_read(a.role) != is_read(b.role);
    if (is_read(a.role) && is_read(b.role)) return true;
    if (a.role == Role::input_mesh && b.role == Role::output_mesh) return true;
    return is_read(a.role) && is_special(a.path);
}

Outcome<Done> check_pair(const NamedFile& earlier, const NamedFile& later) {
    if (may_be_one(earlier, later) || !same_file(earlier.path, later.path)) return Done{};
    if (is_standard(later.path) && is_read(later.role))
        return fail(ErrorKind::usage, later.word + " and " + earlier.word + " are both read from it", "standard input",
                    {}, "give one of them as a file");
    const std::string other = earlier.word + (earlier.path == later.path ? "" : " " + earlier.path);
    return fail(ErrorKind::usage, later.word + " is the same file as " + other, called_output(later.path), {},
                (is_read(earlier.role) ? "what is read is not overwritten: give " : "give ") + later.word +
                    " a file of its own");
}

Outcome<Done> check_path(const NamedFile& file) {
    const auto end = file.path.find('\0');
    if (end == std::string::npos) return Done{};
    return fail(ErrorKind::usage, "the path has a NUL character after " + in_quotes(file.path.substr(0, end)),
                file.word, {}, "no file's name can hold it: take \\u0000 out");
}

}  // namespace

Outcome<Done> check_named_files(const std::vector<NamedFile>& files) {
    for (std::size_t j = 0; j < files.size(); ++j) {
        if (auto path = check_path(files[j]); !path) return path;
        for (std::size_t i = 0; i < j; ++i)
            if (auto distinct = check_pair(files[i], files[j]); !distinct) return distinct;
    }
    return Done{};
}

std::vector<NamedFile> files_of(const config::Pipeline& pipeline, const PipelineWords& words) {
    std::vector<NamedFile> files;
    const auto add = [&](const std::string& path, std::string word, Role role) {
        if (!path.empty()) files.push_back({path, std::move(word), role});
    };
    const auto add_intersected = [&](const config::Metric& metric, const std::string& path) {
        if (const auto* made = std::get_if<config::SolutionMetric>(&metric))
            for (std::size_t i = 0; i < made->intersect.size(); ++i)
                add(made->intersect[i].path, path + "/solution/intersect/" + std::to_string(i), Role::input);
    };
    if (const auto* file = std::get_if<config::FilePath>(&pipeline.input.source))
        add(file->path, words.input, Role::input_mesh);
    add(pipeline.solution.file, words.solution, Role::input);
    if (const auto* file = std::get_if<config::FilePath>(&pipeline.metric)) add(file->path, words.metric, Role::input);
    add_intersected(pipeline.metric, "/metric");
    if (const auto* cad = std::get_if<config::Cad>(&pipeline.geometry)) add(cad->file.path, words.cad, Role::input);
    if (const auto* other = std::get_if<config::FilePath>(&pipeline.geometry))
        add(other->path, words.geometry, Role::input);
    add(pipeline.metric_mesh, "/metric_mesh", Role::input);
    for (std::size_t k = 0; k < pipeline.metric_operations.size(); ++k) {
        const auto* intersect = std::get_if<config::Intersect>(&pipeline.metric_operations[k]);
        const auto* file = intersect != nullptr ? std::get_if<config::FilePath>(&intersect->metric) : nullptr;
        if (file != nullptr)
            add(file->path, "/metric_operations/" + std::to_string(k) + "/intersect/file", Role::input);
    }
    for (std::size_t k = 0; k < pipeline.metric_operations.size(); ++k)
        if (const auto* intersect = std::get_if<config::Intersect>(&pipeline.metric_operations[k]))
            add_intersected(intersect->metric, "/metric_operations/" + std::to_string(k) + "/intersect");
    const config::Output& output = pipeline.output;
    add(output.mesh, words.mesh, Role::output_mesh);
    add(output.vtu, words.vtu, Role::output);
    add(output.metric, "/output/metric", Role::output);
    add(output.solution, "/output/solution", Role::output);
    if (!output.plots.empty())
        for (const std::string& path : plot_files(output.plots)) add(path, words.plots, Role::output);
    add(output.report, words.report, Role::output);
    add(output.page, words.page, Role::output);
    return files;
}

}  // namespace camber::app
