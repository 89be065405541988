module;
#include <cstddef>
#include <map>
#include <mutex>
#include <new>
#include <string>
#ifdef __linux__
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#endif
module camber.core;
import :array_files;

namespace camber {

#ifdef __linux__

namespace {

/// Smaller arrays are not worth a file.
constexpr std::size_t smallest = std::size_t{1} << 18U;

struct ArrayFiles {
    std::mutex mutex;
    std::string folder;  ///< empty: none lie in files
    std::map<void*, std::size_t> arrays;
};
ArrayFiles& files() {
    static ArrayFiles all;
    return all;
}

/// -1: errno says why.
int open_nameless(const std::string& folder) { return ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600); }

}  // namespace

int keep_arrays_in_files(const std::string& folder) {
    const int file = open_nameless(folder);
    if (file < 0) return errno;
    ::close(file);
    const std::scoped_lock lock(files().mutex);
    files().folder = folder;
    return 0;
}

void* allocate_in_file(std::size_t bytes) {
    if (bytes < smallest || files().folder.empty()) return nullptr;
    const int file = open_nameless(files().folder);
    if (file < 0) throw std::bad_alloc();
    void* array = MAP_FAILED;
    if (::ftruncate(file, static_cast<off_t>(bytes)) == 0)
        array = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    ::close(file);
    if (array == MAP_FAILED) throw std::bad_alloc();
    const std::scoped_lock lock(files().mutex);
    files().arrays.emplace(array, bytes);
    return array;
}

bool release_in_file(void* array) {
    if (files().folder.empty()) return false;
    std::size_t bytes = 0;
    {
        const std::scoped_lock lock(files().mutex);
        const auto at = files().arrays.find(array);
        if (at == files().arrays.end()) return false;
        bytes = at->second;
        files().arrays.erase(at);
    }
    ::munmap(array, bytes);
    return true;
}

void give_back_arrays() {
    const std::scoped_lock lock(files().mutex);
    for (const auto& [array, bytes] : files().arrays) ::madvise(array, bytes, MADV_PAGEOUT);
}

std::size_t bytes_in_files() {
    const std::scoped_lock lock(files().mutex);
    std::size_t sum = 0;
    for (const auto& [array, bytes] : files().arrays) sum += bytes;
    return sum;
}

#else

int keep_arrays_in_files(const std::string&) { return 95; }  // no system but Linux has files without a name
void* allocate_in_file(std::size_t) { return nullptr; }
bool release_in_file(void*) { return false; }
void give_back_arrays() {}
std::size_t bytes_in_files() { return 0; }

#endif

}  // namespace camber
