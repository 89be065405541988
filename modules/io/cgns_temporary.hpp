// A temporary folder for one file; the destructor removes both. It is needed because the CGNS library reads and writes
// only files. Like cgns_library.hpp, this header is independent of all modules.
#pragma once

#include <stdlib.h>  // NOLINT(*-deprecated-headers): mkdtemp is POSIX's

#include <filesystem>
#include <string>
#include <system_error>

namespace camber::cgns {

class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::error_code error;
        root_ = std::filesystem::temp_directory_path(error).string();
        std::string pattern = root_ + "/camber-XXXXXX";
        if (error || mkdtemp(pattern.data()) == nullptr) return;
        folder_ = pattern;
        file_ = folder_ + "/mesh.cgns";
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    TemporaryFolder(TemporaryFolder&&) = delete;
    TemporaryFolder& operator=(TemporaryFolder&&) = delete;
    ~TemporaryFolder() {
        std::error_code ignored;
        if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
    }
    /// Path of the file; empty if the folder could not be created in `root`.
    [[nodiscard]] const std::string& file() const { return file_; }
    [[nodiscard]] const std::string& root() const { return root_; }

  private:
    std::string root_, folder_, file_;
};

}  // namespace camber::cgns
