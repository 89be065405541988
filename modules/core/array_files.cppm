module;
#include <cstddef>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
export module camber.core:array_files;

export namespace camber {

/// From now on large arrays (of a Buffer, or a Column made of one) lie in files of that folder which have no name and
/// go with the process, so that the system can take their memory and bring back what is looked at. Whoever begins a
/// program decides it, once, as he does which allocator it has. Returns 0, or the system's error number where no such
/// file can be made there. An empty folder: from now on they are made in memory again.
[[nodiscard]] int keep_arrays_in_files(const std::string& folder);

/// Bytes into an array, or a part of one, that nobody has looked at yet: one in a file is written as a file is, which
/// costs a tenth of touching its pages one after the other.
void fill_bytes(void* array, const void* from, std::size_t bytes);
template <class T>
    requires std::is_trivially_copyable_v<T>
void fill_array(std::span<T> array, std::span<const std::type_identity_t<T>> from) {
    fill_bytes(array.data(), from.data(), from.size_bytes());
}

/// Lets the system have the memory of all arrays in files: what they hold stays.
void give_back_arrays();

/// Thrown for an array whose file cannot be made or cannot have its size, on a full disk for example.
class NoFileForArray : public std::bad_alloc {
  public:
    NoFileForArray(std::string folder, int error) : folder_(std::move(folder)), error_(error) {}
    [[nodiscard]] const std::string& folder() const { return folder_; }
    [[nodiscard]] int error() const { return error_; }  ///< the system's error number

  private:
    std::string folder_;
    int error_;
};

/// Bytes of arrays in files, whether in memory or not.
[[nodiscard]] std::size_t bytes_in_files();

}  // namespace camber

namespace camber {

/// Memory in such a file; null where arrays do not lie in files, or this one is small. Throws NoFileForArray.
[[nodiscard]] void* allocate_in_file(std::size_t bytes);
/// Whether it was one of these.
[[nodiscard]] bool release_in_file(void* array);

}  // namespace camber
