module;
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <climits>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>
#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
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
        case EROFS: return "change the permissions, or choose another path";
        case EISDIR: return "specify a file";
        case ENOTDIR: return "choose another path";
        case ENOSPC:
        case EDQUOT: return "free disk space, or choose another path";
        case EFBIG: return "raise the limit (ulimit -f)";
        default: return "";
    }
}

/// `path: cannot be VERB: the system's reason (the remedy)`.
auto fail_by_system(ErrorKind kind, const std::string& path, const char* verb, int error = errno) {
    return fail(kind, std::string("cannot be ") + verb + ": " + std::generic_category().message(error), path, {},
                remedy_of(error));
}

/// Resolves symbolic links, so that a write preserves the link.
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

/// A path in the same folder. It does not extend the file name, which can have the maximum length.
std::string beside(const std::string& path, const std::string& name) {
    const auto slash = path.rfind('/');
    return slash == std::string::npos ? name : path.substr(0, slash + 1) + name;
}

constexpr std::size_t largest_transfer = std::size_t{1} << 24;
constexpr int poll_interval_ms = 50;

/// Waits until the descriptor is readable or writable. False on a request to stop. Regular files never wait.
bool wait_for(int fd, short events, const std::stop_token& stop) {
    while (!stop.stop_requested()) {
        struct pollfd one{fd, events, 0};
        if (::poll(&one, 1, poll_interval_ms) != 0) return !stop.stop_requested();
    }
    return false;
}

/// False with errno, ECANCELED on a request to stop. `wrote(n)` is called after each transfer of n bytes.
template <class Wrote>
bool write_all(int fd, std::span<const std::byte> bytes, const std::stop_token& stop, const Wrote& wrote) {
    while (!bytes.empty()) {
        if (!wait_for(fd, POLLOUT, stop)) return errno = ECANCELED, false;
        const ssize_t n = ::write(fd, bytes.data(), std::min(bytes.size(), largest_transfer));
        if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
        if (n < 0) return false;
        bytes = bytes.subspan(static_cast<std::size_t>(n));
        wrote(static_cast<std::size_t>(n));
    }
    return true;
}

/// Opens a special file for writing. It waits for the reader of a pipe.
Descriptor open_special(const std::string& path, const std::stop_token& stop) {
    while (true) {
        Descriptor file(::open(path.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC));
        if (file || errno != ENXIO) return file;
        if (stop.stop_requested()) return errno = ECANCELED, Descriptor(-1);
        std::this_thread::sleep_for(std::chrono::milliseconds(poll_interval_ms));
    }
}

/// Copies the permissions of the replaced file. False with errno on failure.
bool take_permissions(int fd, const std::string& replaced) {
    struct stat old{};
    return ::stat(replaced.c_str(), &old) != 0 || ::fchmod(fd, old.st_mode & 07777U) == 0;
}

void sync_folder_of(const std::string& target) {
    if (const Descriptor folder(::open(folder_of(target).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)); folder)
        ::fsync(folder.get());
}

/// A file without a name (O_TMPFILE), or with a temporary name next to its target, until it is complete.
class Draft {
  public:
    explicit Draft(std::string target)
        : target_(std::move(target)), file_(::open(folder_of(target_).c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666)) {
        if (file_ || (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL)) return;
        take_name([&](const char* name) {
            file_ = Descriptor(::open(name, O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0666));
            return static_cast<bool>(file_);
        });
    }
    Draft(const Draft&) = delete;
    Draft& operator=(const Draft&) = delete;
    Draft(Draft&&) = delete;
    Draft& operator=(Draft&&) = delete;
    ~Draft() {
        if (!name_.empty()) ::unlink(name_.c_str());
    }
    [[nodiscard]] int fd() const { return file_.get(); }

    [[nodiscard]] bool publish() {
        if (!take_permissions(fd(), target_) || ::fsync(fd()) != 0) return false;
        const std::string self = "/proc/self/fd/" + std::to_string(fd());
        if (name_.empty() && !take_name([&](const char* name) {
                return ::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0;
            }))
            return false;
        if (!file_.close() || ::rename(name_.c_str(), target_.c_str()) != 0) return false;
        name_.clear();
        sync_folder_of(target_);
        return true;
    }

  private:
    template <class Make>
    bool take_name(Make&& make) {
        for (int k = 0; k < 1000; ++k) {
            const std::string name = beside(target_, ".camber" + std::to_string(::getpid()) + "." + std::to_string(k));
            if (make(name.c_str())) return name_ = name, true;
            if (errno != EEXIST) return false;
        }
        return false;
    }

    std::string target_, name_;
    Descriptor file_;
};

/// Duplicates a standard stream, so that closing the descriptor leaves the stream open.
Descriptor standard(int fd) { return Descriptor(::fcntl(fd, F_DUPFD_CLOEXEC, STDERR_FILENO + 1)); }

bool is_special(const std::string& path) {
    struct stat status{};
    return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

class Watch {
  public:
    Watch(std::string name, const StreamBound* bound) : name_(std::move(name)), bound_(bound) {}

    Outcome<Done> allows(std::span<const std::byte> bytes, bool has_ended) {
        if (bound_ == nullptr) return Done{};
        if (!most_ && (has_ended || bytes.size() >= beginning_of_stream)) {
            const auto most = (*bound_)(bytes.first(std::min(bytes.size(), beginning_of_stream)));
            if (!most) return fail(most.error());
            most_ = *most;
        }
        if (!most_ || bytes.size() <= *most_) return Done{};
        return fail(ErrorKind::input, "is a stream of more than " + readable(*most_) + ", the limit for streams", name_,
                    {}, "use a regular file");
    }

  private:
    std::string name_;
    const StreamBound* bound_;
    std::optional<std::size_t> most_;
};

/// Messages show the folder without resolved links.
Outcome<Done> check_folder_of(const std::string& path) {
    const std::string target = target_of(path);
    struct stat status{};
    const bool is_present = ::stat(folder_of(target).c_str(), &status) == 0;
    if (is_present && S_ISDIR(status.st_mode)) return Done{};
    if (!is_present && errno == EACCES) return fail_by_system(ErrorKind::write, path, "written", EACCES);
    const std::string folder = folder_of(path);
    if (is_present || errno == ENOTDIR)
        return fail(ErrorKind::write, "its folder " + folder + (is_present ? " is a file" : " is below a file"), path,
                    {}, "choose another path");
    return fail(ErrorKind::write, "its folder " + folder + " does not exist", path, {},
                "create it: mkdir -p " + shell_word(folder));
}

}  // namespace

std::string called_input(const std::string& path) { return path == standard_stream ? "standard input" : path; }
std::string called_output(const std::string& path) { return path == standard_stream ? "standard output" : path; }

Outcome<Done> check_folder(const std::string& folder) {
    std::error_code none;
    if (std::filesystem::is_directory(folder, none)) return Done{};
    return check_writable(folder);
}

Outcome<Done> make_folder(const std::string& folder) {
    if (auto sound = check_folder(folder); !sound) return sound;
    std::error_code error;
    std::filesystem::create_directory(folder, error);
    if (!error) return Done{};
    return fail(ErrorKind::write, "the folder cannot be created: " + error.message(), folder, {},
                "choose another path");
}

Outcome<std::size_t> bound_of_text(std::span<const std::byte>) { return std::size_t{64} << 20U; }

Outcome<Buffer<std::byte>> read_file(const std::string& path, const Execution& execution,
                                     const StreamBound& bound) try {
    const auto unreadable = [&](int error = errno) {
        return fail_by_system(ErrorKind::input, called_input(path), "read", error);
    };
    // `open` would block on a pipe without a writer. With O_NONBLOCK the wait below also checks the request to stop.
    const Descriptor file = path == standard_stream
                                ? standard(STDIN_FILENO)
                                : Descriptor(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    if (!file) return unreadable();
    struct stat status{};
    if (::fstat(file.get(), &status) != 0) return unreadable();
    if (S_ISDIR(status.st_mode)) return unreadable(EISDIR);
    // One byte more than expected, to detect the end. Pipes have no size, so the buffer grows.
    Buffer<std::byte> bytes(static_cast<std::size_t>(std::max<off_t>(status.st_size, 65535)) + 1);
    Watch watch(called_input(path), S_ISREG(status.st_mode) ? nullptr : &bound);
    std::size_t size = 0;
    while (true) {
        if (auto allowed = watch.allows(std::span(bytes).first(size), false); !allowed) return fail(allowed.error());
        if (size == bytes.size()) bytes.resize(2 * size);
        if (!wait_for(file.get(), POLLIN, execution.stop))
            return fail(ErrorKind::stopped, "stopped on request", called_input(path));
        const ssize_t n = ::read(file.get(), bytes.data() + size, std::min(bytes.size() - size, largest_transfer));
        if (n < 0 && (errno == EINTR || errno == EAGAIN)) continue;
        if (n < 0) return unreadable();
        if (n == 0) break;
        size += static_cast<std::size_t>(n);
        camber::report_progress(execution, size, std::max(size, bytes.size() - 1));
    }
    bytes.resize(size);
    if (auto allowed = watch.allows(bytes, true); !allowed) return fail(allowed.error());
    return bytes;
} catch (const std::bad_alloc&) {
    return fail(ErrorKind::memory, "not enough memory to read the file", called_input(path), {},
                "use a machine with more memory");
} catch (const std::length_error&) {
    return fail(ErrorKind::memory, "not enough memory to read the file", called_input(path), {},
                "use a machine with more memory");
}

Outcome<Done> write_file(const std::string& path, std::span<const std::span<const std::byte>> chunks,
                         const Execution& execution) {
    const auto unwritable = [&] {
        if (errno == ECANCELED) return fail(ErrorKind::stopped, "stopped on request", called_output(path));
        return fail_by_system(ErrorKind::write, called_output(path), "written");
    };
    std::size_t all = 0, written = 0;
    for (const auto& chunk : chunks) all += chunk.size();
    const auto wrote = [&](std::size_t bytes) { camber::report_progress(execution, written += bytes, all); };
    const auto write_chunks = [&](int fd) {
        return std::all_of(chunks.begin(), chunks.end(),
                           [&](const auto& chunk) { return write_all(fd, chunk, execution.stop, wrote); });
    };
    if (path == standard_stream || is_special(path)) {
        Descriptor file = path == standard_stream ? standard(STDOUT_FILENO) : open_special(path, execution.stop);
        if (!file || !write_chunks(file.get()) || !file.close()) return unwritable();
        return Done{};
    }
    if (auto writable = check_writable(path); !writable) return writable;
    Draft draft(target_of(path));
    if (draft.fd() < 0 || !write_chunks(draft.fd()) || !draft.publish()) return unwritable();
    return Done{};
}

Outcome<Done> check_writable(const std::string& path) {
    if (path == standard_stream) return Done{};
    if (auto folder = check_folder_of(path); !folder) return folder;
    if (is_special(path)) {
        if (::access(path.c_str(), W_OK) != 0) return fail_by_system(ErrorKind::write, path, "written");
        return Done{};
    }
    const std::string target = target_of(path);
    struct stat status{};
    if (::stat(target.c_str(), &status) == 0) {
        if (S_ISDIR(status.st_mode)) return fail_by_system(ErrorKind::write, path, "written", EISDIR);
        if (::access(target.c_str(), W_OK) != 0) return fail_by_system(ErrorKind::write, path, "written");
    }
    if (::access(folder_of(target).c_str(), W_OK | X_OK) != 0) return fail_by_system(ErrorKind::write, path, "written");
    return Done{};
}

namespace {

struct Mapping {
    explicit Mapping(const Descriptor& file, std::size_t bytes)
        : begin(::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, file.get(), 0)), size(bytes) {}
    Mapping(const Mapping&) = delete;
    Mapping(Mapping&&) = delete;
    Mapping& operator=(const Mapping&) = delete;
    Mapping& operator=(Mapping&&) = delete;
    ~Mapping() {
        if (is_present()) ::munmap(begin, size);
    }
    [[nodiscard]] bool is_present() const { return begin != MAP_FAILED; }

    void* begin;
    std::size_t size;
};

}  // namespace

Outcome<Column<std::byte>> map_file(const std::string& path) {
    return guarded([&]() -> Outcome<Column<std::byte>> {
        const auto unreadable = [&](int error) { return fail_by_system(ErrorKind::input, path, "read", error); };
        const Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
        if (!file) return unreadable(errno);
        struct stat status{};
        if (::fstat(file.get(), &status) != 0) return unreadable(errno);
        if (S_ISDIR(status.st_mode)) return unreadable(EISDIR);
        if (!S_ISREG(status.st_mode))
            return fail(ErrorKind::input, "is not a regular file; several processes read it at different positions",
                        path, {}, "copy it into a regular file");
        if (status.st_size == 0) return Column<std::byte>();
        const auto size = static_cast<std::size_t>(status.st_size);
        const auto mapping = std::make_shared<const Mapping>(file, size);
        if (!mapping->is_present()) return unreadable(errno);
        return Column<std::byte>({static_cast<const std::byte*>(mapping->begin), size}, mapping);
    });
}

void release_mapping(std::span<const std::byte> of_mapped_file) {
    if (of_mapped_file.empty()) return;
    ::madvise(const_cast<std::byte*>(of_mapped_file.data()), of_mapped_file.size(), MADV_DONTNEED);
}

struct SharedFile::Open {
    std::string path, target, draft;
    Descriptor file;
    bool is_draft_owner = false;
    RemovedOnSignals removed;
};

namespace {

/// FNV-1a hash: a name of fixed length, equal for equal names.
std::string mark_of(std::string_view name) {
    std::uint64_t hash = 14695981039346656037U;
    for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211U;
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text;
    for (int shift = 60; shift >= 0; shift -= 4) text += digits[(hash >> static_cast<unsigned>(shift)) & 15U];
    return text;
}

auto unwritable(const std::string& path, int error = errno) {
    return fail_by_system(ErrorKind::write, path, "written", error);
}

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
    if (open_ && open_->is_draft_owner && is_of(open_->file, open_->draft)) ::unlink(open_->draft.c_str());
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
    constexpr std::size_t largest = std::size_t{1} << 24U;  // bytes between two checks of the request to stop
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
        return fail(ErrorKind::write, "the temporary file was removed by another process", open_->path, {},
                    "do not write this file in several runs at the same time");
    if (!take_permissions(open_->file.get(), open_->target) ||
        ::rename(open_->draft.c_str(), open_->target.c_str()) != 0)
        return unwritable(open_->path);
    open_->is_draft_owner = false;
    open_->removed = {};
    sync_folder_of(open_->target);
    return Done{};
}

}  // namespace camber::app
