module;
#include <stdlib.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include <fmt/format.h>
module camber.commands;
import camber.core;
import camber.app_shell;
import camber.run;
import :cycle_folders;
import :formats;

namespace camber::app {

namespace {

namespace fs = std::filesystem;

constexpr const char* table_name = "/cycles.json";
constexpr const char* series_name = "/series.pvd";
constexpr const char* groups_name = "/groups.json";

auto cannot(const std::string& path, const std::error_code& error) {
    return fail(ErrorKind::write, "cannot be changed: " + error.message(), path, {}, "take another folder");
}

/// "cycle-007" and "cycle-007.part".
bool is_of_cycle(std::string_view name) {
    constexpr std::string_view before = "cycle-";
    if (!name.starts_with(before)) return false;
    name.remove_prefix(before.size());
    if (name.ends_with(".part")) name.remove_suffix(5);
    return name.size() >= 3 && name.find_first_not_of("0123456789") == std::string_view::npos;
}

/// Folders of cycles from one on, whole and in part.
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
    auto text = read_file(folder + table_name);
    if (!text) return fail(text.error());
    return run::read_cycles(std::string(as_text(*text)), folder + table_name);
}

}  // namespace

Outcome<CycleFolders> CycleFolders::anew(const std::string& folder) {
    std::error_code none;
    if (fs::exists(folder + table_name, none)) {
        const auto rows = table_of(folder);
        const int last = rows && !rows->empty() ? rows->back().cycle : 0;
        return fail(ErrorKind::usage, fmt::format("has cycles 0 to {} of an earlier run", last), folder, {},
                    fmt::format("--from {} goes on from there; or take another --folder, or remove it", last));
    }
    if (auto made = check_folder(folder).and_then([&](Done) { return make_folder(folder); }); !made)
        return fail(made.error());
    if (auto gone = remove_from(folder, run::name_of_cycle(0)); !gone) return fail(gone.error());
    return CycleFolders(folder, true);
}

Outcome<CycleFolders> CycleFolders::going_on(const std::string& folder, int last) {
    auto rows = table_of(folder);
    if (!rows) {
        Error error = rows.error();
        error.what = "there are no cycles to go on from: " + error.what;
        error.remedy = "leave --from out";
        return fail(std::move(error));
    }
    const auto kept = static_cast<std::size_t>(last) + 1;
    std::error_code none;
    if (rows->size() < kept || !fs::exists(folder + "/" + run::name_of_cycle(last), none))
        return fail(ErrorKind::usage, fmt::format("cycle {} is not there to go on from", last), folder, {},
                    rows->empty() ? "leave --from out" : fmt::format("give --from 0 to {}", rows->back().cycle));
    if (auto gone = remove_from(folder, run::name_of_cycle(last + 1)); !gone) return fail(gone.error());
    CycleFolders folders(folder, true);
    rows->resize(kept);
    folders.rows_ = std::move(*rows);
    return folders;
}

Outcome<CycleFolders> CycleFolders::passing(const std::string& beside) {
    const fs::path parent = fs::path(beside).parent_path();
    std::string name = (parent.empty() ? fs::path(".") : parent).string() + "/.camber-cycles-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr)
        return fail(ErrorKind::write, "no folder can be made beside it", beside, {}, "give --folder");
    return CycleFolders(name, false);
}

CycleFolders::CycleFolders(CycleFolders&& other) noexcept
    : path_(std::exchange(other.path_, {})), is_kept_(other.is_kept_), rows_(std::move(other.rows_)) {}

CycleFolders::~CycleFolders() {
    std::error_code nobody_to_tell;
    if (!is_kept_ && !path_.empty()) fs::remove_all(path_, nobody_to_tell);
}

std::string CycleFolders::of_cycle(int cycle) const { return path_ + "/" + run::name_of_cycle(cycle); }

Outcome<std::string> CycleFolders::part_of_cycle(int cycle) const {
    const std::string part = of_cycle(cycle) + ".part";
    std::error_code error;
    fs::remove_all(part, error);
    if (error) return cannot(part, error);
    if (auto made = make_folder(part); !made) return fail(made.error());
    return part;
}

Outcome<Done> CycleFolders::add(const run::CycleRow& row, const std::string& view) {
    const std::string whole = of_cycle(row.cycle);
    std::error_code error;
    fs::rename(whole + ".part", whole, error);
    if (error) return cannot(whole, error);
    rows_.push_back(row);
    if (auto written = write_text(path_ + table_name, run::cycles_json(rows_)); !written) return written;
    return write_text(path_ + series_name, run::series_of(rows_, view));
}

Outcome<Done> CycleFolders::store_groups(const run::Groups& groups) const {
    return groups.empty() ? Done{} : write_text(path_ + groups_name, run::groups_json(groups));
}

Outcome<run::Groups> CycleFolders::groups() const {
    std::error_code none;
    if (!fs::exists(path_ + groups_name, none)) return run::Groups();
    const auto text = read_file(path_ + groups_name);
    if (!text) return fail(text.error());
    return run::read_groups(std::string(as_text(*text)), path_ + groups_name);
}

}  // namespace camber::app
