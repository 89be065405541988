// Ownership of columns, and memory of large arrays in files or on large pages.
module;
#include <atomic>
#include <cstddef>
#include <cstring>
#include <map>
#include <mutex>
#include <new>
#include <string>
#include <utility>
#ifdef __linux__
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#endif
module camber.core;

namespace camber {

SharedOwner::SharedOwner(const SharedOwner& other) noexcept : value_(other.value_) {
    if (value_ != nullptr) value_->owners_.fetch_add(1, std::memory_order_relaxed);
}
SharedOwner::SharedOwner(SharedOwner&& other) noexcept : value_(std::exchange(other.value_, nullptr)) {}
SharedOwner& SharedOwner::operator=(const SharedOwner& other) noexcept { return *this = SharedOwner(other); }
SharedOwner& SharedOwner::operator=(SharedOwner&& other) noexcept {
    SharedOwner taken(std::move(other));  // its destructor releases the former value
    std::swap(value_, taken.value_);
    return *this;
}
SharedOwner::~SharedOwner() {
    if (value_ != nullptr && value_->owners_.fetch_sub(1, std::memory_order_acq_rel) == 1) delete value_;
}

bool SharedOwner::is_only() const { return value_ != nullptr && value_->owners_.load(std::memory_order_acquire) == 1; }

#ifdef __linux__

namespace {

/// Minimum size of an array in a file (bytes).
constexpr std::size_t smallest = std::size_t{1} << 18U;

struct ArrayFiles {
    std::mutex mutex;
    std::string folder;  ///< empty: new arrays are in memory
    std::atomic<bool> is_used = false;
    struct Array {
        std::size_t bytes = 0;
        int file = -1;
    };
    std::map<void*, Array> arrays;
};
ArrayFiles& files() {
    static ArrayFiles all;
    return all;
}

int open_nameless(const std::string& folder) { return ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600); }

/// Reserves the blocks of a file, because on a full disk a write to a page without a block ends the process (SIGBUS).
/// Returns 0 or the system's error number.
int reserve(int file, std::size_t bytes) {
    int error = EINTR;
    while (error == EINTR) error = ::posix_fallocate(file, 0, static_cast<off_t>(bytes));
    return error;
}

void allow_many_files() {
    rlimit limit{};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
    limit.rlim_cur = limit.rlim_max;
    ::setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace

int store_arrays_in_files(const std::string& folder) {
    if (!folder.empty()) {
        const int file = open_nameless(folder);
        if (file < 0) return errno;
        ::close(file);
        allow_many_files();
        files().is_used = true;
    }
    const std::scoped_lock lock(files().mutex);
    files().folder = folder;
    return 0;
}

void* allocate_in_file(std::size_t bytes) {
    if (bytes < smallest || !files().is_used) return nullptr;
    std::string folder;
    {
        const std::scoped_lock lock(files().mutex);
        folder = files().folder;
    }
    if (folder.empty()) return nullptr;
    const int file = open_nameless(folder);
    if (file < 0) throw NoFileForArray(folder, errno);
    if (const int error = reserve(file, bytes); error != 0) {
        ::close(file);
        throw NoFileForArray(folder, error);
    }
    void* const array = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (array == MAP_FAILED) {
        ::close(file);
        throw std::bad_alloc();
    }
    const std::scoped_lock lock(files().mutex);
    files().arrays.emplace(array, ArrayFiles::Array{bytes, file});
    return array;
}

bool release_in_file(void* array) {
    if (!files().is_used) return false;
    ArrayFiles::Array removed;
    {
        const std::scoped_lock lock(files().mutex);
        const auto at = files().arrays.find(array);
        if (at == files().arrays.end()) return false;
        removed = at->second;
        files().arrays.erase(at);
    }
    ::munmap(array, removed.bytes);
    ::close(removed.file);
    return true;
}

void fill_bytes(void* array, const void* from, std::size_t bytes) {
    const auto write_file = [&]() -> bool {
        if (!files().is_used || bytes < smallest) return false;
        const std::scoped_lock lock(files().mutex);
        auto of = files().arrays.upper_bound(array);
        if (of == files().arrays.begin()) return false;
        --of;
        const auto at = static_cast<std::size_t>(static_cast<char*>(array) - static_cast<char*>(of->first));
        if (at + bytes > of->second.bytes) return false;
        std::size_t done = 0;
        while (done < bytes) {
            const ssize_t n = ::pwrite(of->second.file, static_cast<const char*>(from) + done, bytes - done,
                                       static_cast<off_t>(at + done));
            if (n <= 0) return false;
            done += static_cast<std::size_t>(n);
        }
        return true;
    };
    if (bytes > 0 && !write_file()) std::memcpy(array, from, bytes);
}

void release_array_memory() {
    const std::scoped_lock lock(files().mutex);
    for (const auto& [array, of] : files().arrays) {
        ::madvise(array, of.bytes, MADV_DONTNEED);  // releases the pages only: the file keeps the data
        ::sync_file_range(of.file, 0, 0, SYNC_FILE_RANGE_WRITE);
    }
}

std::size_t bytes_in_files() {
    const std::scoped_lock lock(files().mutex);
    std::size_t sum = 0;
    for (const auto& [array, of] : files().arrays) sum += of.bytes;
    return sum;
}

#else

int store_arrays_in_files(const std::string&) { return 95; }  // EOPNOTSUPP: only Linux has anonymous files
void* allocate_in_file(std::size_t) { return nullptr; }
bool release_in_file(void*) { return false; }
void fill_bytes(void* array, const void* from, std::size_t bytes) {
    if (bytes > 0) std::memcpy(array, from, bytes);
}
void release_array_memory() {}
std::size_t bytes_in_files() { return 0; }

#endif

namespace {

/// Size of a large page on x86 and most ARM processors. With another size, the advice has no effect.
constexpr std::size_t large_page = std::size_t{1} << 21U;
constexpr std::size_t large_array = 4 * large_page;

}  // namespace

void* allocate_array(std::size_t bytes) {
    if (void* const in_file = allocate_in_file(bytes)) return in_file;
    if (bytes < large_array) return ::operator new(bytes);
    void* array = ::operator new(bytes, std::align_val_t{large_page});
#ifdef __linux__
    ::madvise(array, bytes, MADV_HUGEPAGE);
#endif
    return array;
}

void release_array(void* array, std::size_t bytes) {
    if (release_in_file(array)) return;
    if (bytes < large_array)
        ::operator delete(array);
    else
        ::operator delete(array, std::align_val_t{large_page});
}

}  // namespace camber
