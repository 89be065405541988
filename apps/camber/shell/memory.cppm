module;
#include <cstddef>
#include <limits>
#include <string>
export module camber.app_shell:memory;

export namespace camber::app {

/// The memory that this process may have, and what says so.
struct MemoryLimit {
    std::size_t bytes = std::numeric_limits<std::size_t>::max();
    std::string source;  ///< "this machine", "the control group", "ulimit -v"; empty: no limit known
};

/// The least of the machine's memory, the limits of the control groups that hold the process (versions 1 and 2), and
/// RLIMIT_AS.
[[nodiscard]] MemoryLimit memory_limit();

/// The limit that a hierarchy of control groups sets: the least number in the files FOLDER/…/NAME from the group up to
/// the root of the hierarchy; none is the largest number.
[[nodiscard]] std::size_t cgroup_limit(const std::string& root, const std::string& group, const std::string& name);

/// Memory that the process has now; 0 where the system does not say.
[[nodiscard]] std::size_t resident_bytes();

/// From now on large arrays that are let go of leave the process at once, however large those before were (glibc learns
/// to keep them): a tenth to a seventh of a run's peak, for a few hundredths of its time.
void give_freed_arrays_back();

/// "3.2 GiB", "17.0 MiB".
[[nodiscard]] std::string readable(std::size_t bytes);

}  // namespace camber::app
