module;
#include <string>
export module camber.config:paths;

export namespace camber::config {

/// A file that a config names.
struct FilePath {
    std::string path;
    friend bool operator==(const FilePath&, const FilePath&) = default;
};

}  // namespace camber::config
