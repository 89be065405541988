module;
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
module camber.app_shell;
import camber.core;
import :descriptor;
import :interrupt;
import :shared_file;

namespace camber::app {

struct SharedFile::Open {
    std::string path, target, draft;
    Descriptor file;
    bool is_makers = false;
    RemovedOnSignals removed;
};

namespace {

/// The same for the same name, of whatever length: FNV-1a.
std::string mark_of(std::string_view name) {
    std::uint64_t hash = 14695981039346656037U;
    for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211U;
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text;
    for (int shift = 60; shift >= 0; shift -= 4) text += digits[(hash >> static_cast<unsigned>(shift)) & 15U];
    return text;
}

auto unwritable(const std::string& path, int error = errno) {
    return fail(system_error(ErrorKind::write, path, "written", error));
}

/// Whether the name is still that of the open file.
bool is_of(const Descriptor& file, const std::string& name) {
    struct stat open{}, named{};
    return ::fstat(file.get(), &open) == 0 && ::stat(name.c_str(), &named) == 0 && open.st_dev == named.st_dev &&
           open.st_ino == named.st_ino;
}

}  // namespace

SharedFile::SharedFile(std::unique_ptr<Open> open) : open_(std::move(open)) {}
SharedFile::SharedFile(SharedFile&&) noexcept = default;
SharedFile& SharedFile::operator=(SharedFile&&) noexcept = default;
SharedFile::~SharedFile() {
    if (open_ && open_->is_makers && is_of(open_->file, open_->draft)) ::unlink(open_->draft.c_str());
}

const std::string& SharedFile::draft() const { return open_->draft; }

Outcome<SharedFile> SharedFile::make(const std::string& path, std::uint64_t bytes) {
    if (auto writable = check_writable(path); !writable) return fail(std::move(writable.error()));
    const std::string target = target_of(path);
    const std::string draft = beside(target, ".camber-" + mark_of(target) + ".part");
    ::unlink(draft.c_str());
    Descriptor file(::open(draft.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0666));
    if (!file) return unwritable(path);
    auto open = std::make_unique<Open>(Open{path, target, draft, std::move(file), true, RemovedOnSignals(draft)});
    if (::ftruncate(open->file.get(), static_cast<off_t>(bytes)) != 0) {
        const int error = errno;
        ::unlink(draft.c_str());
        return unwritable(path, error);
    }
    return SharedFile(std::move(open));
}

Outcome<SharedFile> SharedFile::join(const std::string& path, const std::string& draft) {
    Descriptor file(::open(draft.c_str(), O_RDWR | O_CLOEXEC));
    if (!file) return unwritable(path);
    return SharedFile(
        std::make_unique<Open>(Open{path, target_of(path), draft, std::move(file), false, RemovedOnSignals(draft)}));
}

Outcome<Done> SharedFile::write(std::uint64_t offset, std::span<const std::byte> bytes,
                                const Execution& execution) const {
    constexpr std::size_t largest = std::size_t{1} << 24U;  // the request to stop is looked for between two of these
    while (!bytes.empty()) {
        if (execution.stop.stop_requested()) return fail(ErrorKind::stopped, "stopped on request", open_->path);
        const ssize_t n =
            ::pwrite(open_->file.get(), bytes.data(), std::min(bytes.size(), largest), static_cast<off_t>(offset));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return unwritable(open_->path);
        bytes = bytes.subspan(static_cast<std::size_t>(n));
        offset += static_cast<std::uint64_t>(n);
    }
    return Done{};
}

Outcome<Done> SharedFile::flush() const {
    if (::fsync(open_->file.get()) != 0) return unwritable(open_->path);
    return Done{};
}

Outcome<Done> SharedFile::publish() {
    if (!is_of(open_->file, open_->draft))
        return fail(ErrorKind::write, "its draft was taken away meanwhile", open_->path, {},
                    "let one run at a time write it");
    struct stat old{};
    if (::stat(open_->target.c_str(), &old) == 0 && ::fchmod(open_->file.get(), old.st_mode & 07777U) != 0)
        return unwritable(open_->path);
    if (::rename(open_->draft.c_str(), open_->target.c_str()) != 0) return unwritable(open_->path);
    open_->is_makers = false;
    open_->removed = {};
    if (const Descriptor folder(::open(folder_of(open_->target).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)); folder)
        ::fsync(folder.get());
    return Done{};
}

}  // namespace camber::app
