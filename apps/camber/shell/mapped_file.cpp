module;
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
module camber.app_shell;
import camber.core;
import :descriptor;

namespace camber::app {

namespace {

struct Mapping {
    explicit Mapping(const Descriptor& file, std::size_t bytes)
        : begin(::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, file.get(), 0)), size(bytes) {}
    Mapping(const Mapping&) = delete;
    Mapping(Mapping&&) = delete;
    Mapping& operator=(const Mapping&) = delete;
    Mapping& operator=(Mapping&&) = delete;
    ~Mapping() {
        if (is_there()) ::munmap(begin, size);
    }
    [[nodiscard]] bool is_there() const { return begin != MAP_FAILED; }

    void* begin;
    std::size_t size;
};

}  // namespace

Outcome<Column<std::byte>> map_file(const std::string& path) {
    return guarded([&]() -> Outcome<Column<std::byte>> {
        const auto unreadable = [&](int error) { return fail(system_error(ErrorKind::input, path, "read", error)); };
        const Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
        if (!file) return unreadable(errno);
        struct stat status{};
        if (::fstat(file.get(), &status) != 0) return unreadable(errno);
        if (S_ISDIR(status.st_mode)) return unreadable(EISDIR);
        if (!S_ISREG(status.st_mode))
            return fail(ErrorKind::input, "is no plain file, which is read by several at any place", path, {},
                        "copy it into one");
        if (status.st_size == 0) return Column<std::byte>();
        const auto size = static_cast<std::size_t>(status.st_size);
        const auto mapping = std::make_shared<const Mapping>(file, size);
        if (!mapping->is_there()) return unreadable(errno);
        return Column<std::byte>({static_cast<const std::byte*>(mapping->begin), size}, mapping);
    });
}

void give_back(std::span<const std::byte> of_mapped_file) {
    if (of_mapped_file.empty()) return;
    ::madvise(const_cast<std::byte*>(of_mapped_file.data()), of_mapped_file.size(), MADV_DONTNEED);
}

}  // namespace camber::app
