module;
#include <string>
#include <string_view>
export module camber.config:paths;

export namespace camber::config {

/// A file that a config names.
struct FilePath {
    std::string path;
    bool is_of_cycle = false;  ///< true if an earlier cycle of the same run wrote the file
    friend bool operator==(const FilePath&, const FilePath&) = default;
};

/// Names of what the caller of a run has in memory, and not in a file, begin so.
inline constexpr std::string_view in_memory = "memory:";
[[nodiscard]] inline bool is_in_memory(std::string_view name) { return name.starts_with(in_memory); }

}  // namespace camber::config
