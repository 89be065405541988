module;
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <limits>
#include <string>
#include <utility>

#include <fmt/format.h>
module camber.app_shell;

namespace camber::app {

namespace {

constexpr std::size_t unlimited = std::numeric_limits<std::size_t>::max();

/// A file of one number; "max", and what is not there or no number, is no limit.
std::size_t number_in(const std::string& path) {
    std::ifstream file(path);
    std::size_t number = 0;
    return file >> number ? number : unlimited;
}

/// The group of this process: in version 2 the line "0::/a/b", in version 1 "7:memory:/a/b" (cgroups(7)).
std::string group_of_process(bool version_2) {
    std::ifstream groups("/proc/self/cgroup");
    for (std::string line; std::getline(groups, line);) {
        const auto first = line.find(':');
        const auto second = first == std::string::npos ? first : line.find(':', first + 1);
        if (second == std::string::npos) continue;
        const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
        if (version_2 ? controllers == ",," : controllers.find(",memory,") != std::string::npos)
            return line.substr(second + 1);
    }
    return "/";
}

std::size_t of_machine() {
    const long pages = ::sysconf(_SC_PHYS_PAGES), size = ::sysconf(_SC_PAGESIZE);
    if (pages <= 0 || size <= 0) return unlimited;
    return static_cast<std::size_t>(pages) * static_cast<std::size_t>(size);
}

std::size_t of_process() {
    struct rlimit limit{};
    if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
    return limit.rlim_cur;
}

}  // namespace

std::size_t cgroup_limit(const std::string& root, const std::string& group, const std::string& name) {
    std::size_t least = unlimited;
    for (std::string at = group == "/" ? "" : group;; at.erase(at.rfind('/'))) {
        least = std::min(least, number_in(root + at + "/" + name));
        if (at.rfind('/') == std::string::npos) return least;
    }
}

MemoryLimit memory_limit() {
    const std::size_t group =
        std::min(cgroup_limit("/sys/fs/cgroup", group_of_process(true), "memory.max"),
                 cgroup_limit("/sys/fs/cgroup/memory", group_of_process(false), "memory.limit_in_bytes"));
    MemoryLimit least;
    for (const auto& [bytes, source] : {std::pair{of_process(), "ulimit -v"}, std::pair{group, "the control group"},
                                        std::pair{of_machine(), "this machine"}})
        if (bytes < least.bytes) least = {bytes, source};
    return least;
}

std::size_t resident_bytes() {
    std::ifstream file("/proc/self/statm");
    std::size_t pages = 0, resident = 0;
    if (!(file >> pages >> resident)) return 0;
    return resident * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

void give_freed_arrays_back() {
#ifdef __GLIBC__
    constexpr int large = 1 << 22;
    ::mallopt(M_MMAP_THRESHOLD, large);
#endif
}

std::string readable(std::size_t bytes) {
    constexpr double mebi = 1024 * 1024;
    const double mib = static_cast<double>(bytes) / mebi;
    return mib < 1024 ? fmt::format("{:.1f} MiB", mib) : fmt::format("{:.1f} GiB", mib / 1024);
}

}  // namespace camber::app
