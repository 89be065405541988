module;
#include <cstddef>
#include <new>
#ifdef __linux__
#include <sys/mman.h>
#endif
module camber.core;
import :array_files;

namespace camber {

namespace {

/// The large page of x86 and of most of ARM; where it is another, the advice is in vain and harmless.
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
