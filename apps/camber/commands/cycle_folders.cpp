module;
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>
#include <fmt/format.h>
#include <stdlib.h>
module camber.commands;
import camber.core;
import camber.ordering;
import camber.soundness;
import camber.io;
import camber.distributed;
import camber.app_shell;
import camber.recipes;
import camber.reports;
import camber.config;
import :execution;

namespace camber::app {

namespace {

namespace fs = std::filesystem;

constexpr const char* table_name = "/cycles.json";
constexpr const char* series_name = "/series.pvd";
constexpr const char* groups_name = "/groups.json";

auto cannot(const std::string& path, const std::error_code& error) {
    return fail(ErrorKind::write, "cannot be changed: " + error.message(), path, {}, "use another folder");
}

/// True for "cycle-007" and "cycle-007.part".
bool is_of_cycle(std::string_view name) {
    constexpr std::string_view before = "cycle-";
    if (!name.starts_with(before)) return false;
    name.remove_prefix(before.size());
    if (name.ends_with(".part")) name.remove_suffix(5);
    return name.size() >= 3 && name.find_first_not_of("0123456789") == std::string_view::npos;
}

Outcome<Done> remove_from(const std::string& folder, std::string_view first) {
    std::error_code error;
    std::vector<fs::path> later;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        const std::string name = entry.path().filename().string();
        if (is_of_cycle(name) && entry.is_directory() && name >= first) later.push_back(entry.path());
    }
    if (error) return cannot(folder, error);
    for (const fs::path& path : later) {
        fs::remove_all(path, error);
        if (error) return cannot(path.string(), error);
    }
    return Done{};
}

Outcome<std::vector<run::CycleRow>> table_of(const std::string& folder) {
    return read_file(folder + table_name).and_then([&](const auto& text) {
        return run::read_cycles(std::string(as_text(text)), folder + table_name);
    });
}

Outcome<run::Groups> groups_in(const std::string& folder) {
    std::error_code none;
    if (!fs::exists(folder + groups_name, none)) return run::Groups();
    return read_file(folder + groups_name).and_then([&](const auto& text) {
        return run::read_groups(std::string(as_text(text)), folder + groups_name);
    });
}

}  // namespace

Outcome<CycleFolders> CycleFolders::anew(const std::string& folder) {
    std::error_code none;
    if (fs::exists(folder + table_name, none)) {
        const auto rows = table_of(folder);
        const int last = rows && !rows->empty() ? rows->back().cycle : 0;
        return fail(ErrorKind::usage, fmt::format("has cycles 0 to {} of an earlier run", last), folder, {},
                    fmt::format("continue with --from {}, use another --folder, or remove this one", last));
    }
    if (auto result = make_folder(folder); !result) return fail(result.error());
    if (auto removed = remove_from(folder, run::name_of_cycle(0)); !removed) return fail(removed.error());
    return CycleFolders(folder, true);
}

Outcome<CycleFolders> CycleFolders::continued(const std::string& folder, int last) {
    auto rows = table_of(folder);
    if (!rows) {
        Error error = rows.error();
        error.what = "there are no cycles to continue: " + error.what;
        error.remedy = "leave --from out";
        return fail(std::move(error));
    }
    const auto row_count = static_cast<std::size_t>(last) + 1;
    std::error_code none;
    if (rows->size() < row_count || !fs::exists(folder + "/" + run::name_of_cycle(last), none))
        return fail(ErrorKind::usage, fmt::format("cycle {} to continue after does not exist", last), folder, {},
                    rows->empty() ? "leave --from out" : fmt::format("give --from 0 to {}", rows->back().cycle));
    if (auto removed = remove_from(folder, run::name_of_cycle(last + 1)); !removed) return fail(removed.error());
    CycleFolders folders(folder, true);
    rows->resize(row_count);
    folders.rows_ = std::move(*rows);
    auto groups = groups_in(folder);
    if (!groups) return fail(groups.error());
    folders.groups_ = std::move(*groups);
    return folders;
}

Outcome<CycleFolders> CycleFolders::passing(const std::string& beside) {
    const fs::path parent = fs::path(beside).parent_path();
    std::string name = (parent.empty() ? fs::path(".") : parent).string() + "/.camber-cycles-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr)
        return fail(ErrorKind::write, "no folder can be created next to it", beside, {}, "give --folder");
    return CycleFolders(name, false);
}

CycleFolders::CycleFolders(CycleFolders&& other) noexcept
    : path_(std::exchange(other.path_, {})),
      is_permanent_(other.is_permanent_),
      rows_(std::move(other.rows_)),
      groups_(std::move(other.groups_)) {}

CycleFolders::~CycleFolders() {
    std::error_code ignored_error;
    if (!is_permanent_ && !path_.empty()) fs::remove_all(path_, ignored_error);
}

std::string CycleFolders::of_cycle(int cycle) const { return path_ + "/" + run::name_of_cycle(cycle); }

Outcome<std::string> CycleFolders::part_of_cycle(int cycle) const {
    const std::string part = of_cycle(cycle) + ".part";
    std::error_code error;
    fs::remove_all(part, error);
    if (error) return cannot(part, error);
    if (auto result = make_folder(part); !result) return fail(result.error());
    return part;
}

Outcome<Done> CycleFolders::add(std::span<const run::CycleRow> rows, const std::string& view) {
    const std::string whole = of_cycle(rows.back().cycle);
    std::error_code error;
    fs::rename(whole + ".part", whole, error);
    if (error) return cannot(whole, error);
    if (auto written = write_text(path_ + table_name, run::cycles_json(rows)); !written) return written;
    rows_.assign(rows.begin(), rows.end());
    return write_text(path_ + series_name, run::series_of(rows, view));
}

Outcome<Done> CycleFolders::store_groups(run::Groups groups) {
    groups_ = std::move(groups);
    return groups_.empty() ? Done{} : write_text(path_ + groups_name, run::groups_json(groups_));
}

namespace {

namespace fs = std::filesystem;

bool is_read(Role role) { return role == Role::input || role == Role::input_mesh; }

fs::path resolved(const std::string& path) {
    std::error_code error;
    const fs::path whole = fs::absolute(path, error);
    fs::path target = fs::weakly_canonical(whole, error);
    return error ? whole.lexically_normal() : target;
}

bool is_standard(const std::string& path) { return path == standard_stream; }

/// True for hard links too.
bool same_file(const std::string& a, const std::string& b) {
    std::error_code ignored_error;
    return resolved(a) == resolved(b) || fs::equivalent(a, b, ignored_error);
}

/// True for pipes and devices. Writing to them overwrites nothing.
bool is_special(const std::string& path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

bool replaces_input(const NamedFile& a, const NamedFile& b) {
    return a.role == Role::input_mesh && b.role == Role::output_mesh;
}

bool may_be_one(const NamedFile& a, const NamedFile& b, bool force) {
    if (is_standard(a.path) && is_standard(b.path)) return is_read(a.role) != is_read(b.role);
    if (is_read(a.role) && is_read(b.role)) return true;
    if (force && replaces_input(a, b)) return true;
    return is_read(a.role) && is_special(a.path);
}

Outcome<Done> check_pair(const NamedFile& earlier, const NamedFile& later, bool force) {
    if (earlier.path.empty() || may_be_one(earlier, later, force) || !same_file(earlier.path, later.path))
        return Done{};
    if (is_standard(later.path) && is_read(later.role))
        return fail(ErrorKind::usage, later.word + " and " + earlier.word + " are both read from it", "standard input",
                    {}, "give one of them as a file");
    const std::string other = earlier.word + (earlier.path == later.path ? "" : " " + earlier.path);
    if (replaces_input(earlier, later))
        return fail(ErrorKind::usage, later.word + " is the same file as " + other, called_output(later.path), {},
                    "name another output, or replace the input with --force");
    return fail(
        ErrorKind::usage, later.word + " is the same file as " + other, called_output(later.path), {},
        (is_read(earlier.role) ? "inputs are not overwritten; give " : "give ") + later.word + " a separate file");
}

Outcome<Done> check_path(const NamedFile& file) {
    const auto end = file.path.find('\0');
    if (end == std::string::npos) return Done{};
    return fail(ErrorKind::usage, "the path has a NUL character after " + in_quotes(file.path.substr(0, end)),
                file.word, {}, "file names cannot contain it; remove \\u0000");
}

}  // namespace

Outcome<Done> check_named_files(const std::vector<NamedFile>& files, bool force) {
    for (std::size_t j = 0; j < files.size(); ++j) {
        if (auto path = check_path(files[j]); !path) return path;
        for (std::size_t i = 0; i < j && !files[j].path.empty(); ++i)
            if (auto distinct = check_pair(files[i], files[j], force); !distinct) return distinct;
    }
    return Done{};
}

std::vector<NamedFile> files_of(const config::Pipeline& pipeline, const PipelineWords& words) {
    std::vector<NamedFile> files;
    const auto add = [&](const std::string& path, std::string word, Role role) {
        files.push_back({path, std::move(word), role});
    };
    const auto add_intersected = [&](const config::Metric& metric, const std::string& path) {
        if (const auto* result = std::get_if<config::SolutionMetric>(&metric))
            for (std::size_t i = 0; i < result->intersect.size(); ++i)
                add(result->intersect[i].path, path + "/solution/intersect/" + std::to_string(i), Role::input);
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

template <int D>
Outcome<Opened<D>> mapped(const std::string& path) {
    auto bytes = map_file(path);
    if (!bytes) return fail(bytes.error());
    const std::span<const std::byte> mapping = bytes->view();
    auto rows = rows_of_gmf<D>(std::move(*bytes), path, [mapping] { release_mapping(mapping); });
    if (!rows) return fail(of_file(rows.error(), path));
    return Opened<D>{std::move(*rows)};
}

template <int D>
Outcome<std::unique_ptr<QuadraticRows<D>>> mapped_quadratic(const std::string& path, Ranks& ranks) {
    auto bytes = agreed(ranks, map_file(path));
    if (!bytes) return fail(bytes.error());
    const std::span<const std::byte> mapping = bytes->view();
    auto rows = QuadraticRows<D>::make(std::move(*bytes), path, [mapping] { release_mapping(mapping); }, ranks);
    if (!rows) return fail(of_file(rows.error(), path));
    return rows;
}

Outcome<GmfShape> shape_of_file(const std::string& path) {
    const auto bytes = map_file(path);
    if (!bytes) return fail(bytes.error());
    const auto shape = gmf_shape(bytes->view(), path);
    if (!shape) return fail(of_file(shape.error(), path));
    return shape;
}

template <int D>
Outcome<Opened<D>> prepared(Mesh<D> original, std::vector<std::string>& notices, const Execution& execution) {
    auto sound = prepare(std::move(original), execution);
    if (!sound) return fail(sound.error());
    notices.insert(notices.end(), sound->notices.begin(), sound->notices.end());
    auto linear = as_linear(std::move(sound->mesh));
    if (!linear) return fail(linear.error());
    Opened<D> opened{nullptr, std::move(*linear)};
    auto order = better_order(*opened.mesh, {}, execution);
    if (!order) return fail(order.error());
    if (*order) {
        auto better = renumbered(std::move(*opened.mesh), (*order)->renumbering, execution);
        if (!better) return fail(better.error());
        opened.mesh = std::move(*better);
        opened.order = std::move(*order);
    }
    opened.rows = rows_of(*opened.mesh);
    return opened;
}

#define CAMBER_INSTANTIATE(D)                                                                            \
    template Outcome<Opened<D>> mapped<D>(const std::string&);                                           \
    template Outcome<std::unique_ptr<QuadraticRows<D>>> mapped_quadratic<D>(const std::string&, Ranks&); \
    template Outcome<Opened<D>> prepared<D>(Mesh<D>, std::vector<std::string>&, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber::app
