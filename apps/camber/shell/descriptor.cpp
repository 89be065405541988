module;
#include <cerrno>
#include <filesystem>
#include <string>
#include <system_error>
module camber.app_shell;
import camber.core;
import :descriptor;

namespace camber::app {

namespace {

const char* remedy_of(int error) {
    switch (error) {
        case ENOENT: return "check the path";
        case EACCES:
        case EPERM:
        case EROFS: return "ask for the permission, or take another place";
        case EISDIR: return "name a file";
        case ENOTDIR: return "take another place";
        case ENOSPC:
        case EDQUOT: return "make room, or take another place";
        case EFBIG: return "raise the limit (ulimit -f)";
        default: return "";
    }
}

}  // namespace

Error system_error(ErrorKind kind, const std::string& path, const char* verb, int error) {
    return {kind,
            std::string("cannot be ") + verb + ": " + std::generic_category().message(error),
            path,
            {},
            remedy_of(error)};
}

std::string target_of(const std::string& path) {
    std::error_code ignored;
    const auto resolved = std::filesystem::weakly_canonical(path, ignored);
    return ignored ? path : resolved.string();
}

std::string folder_of(const std::string& path) {
    const auto slash = path.rfind('/');
    if (slash == std::string::npos) return ".";
    return slash == 0 ? "/" : path.substr(0, slash);
}

std::string beside(const std::string& path, const std::string& name) {
    const auto slash = path.rfind('/');
    return slash == std::string::npos ? name : path.substr(0, slash + 1) + name;
}

}  // namespace camber::app
