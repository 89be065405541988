module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
module camber.io:unpacked;

namespace camber {

/// What a file with compressed data may still be unpacked to, in bytes of memory. Deflate makes a thousand bytes out of
/// one where all are alike; meshes come to about seven (a grid of a box, as regular as they get, with types and
/// references that are all the same), so a hundred times the file is no mesh. Small files have 64 MiB: they cost nobody
/// anything.
class UnpackedBudget {
  public:
    explicit constexpr UnpackedBudget(std::size_t file_bytes) : left_(most(file_bytes)) {}

    /// So many numbers of so many bytes each; false: more than is left.
    [[nodiscard]] constexpr bool take(std::uint64_t count, std::uint64_t bytes_each = sizeof(double)) {
        if (bytes_each > 0 && count > left_ / bytes_each) return false;
        left_ -= count * bytes_each;
        return true;
    }

    [[nodiscard]] static constexpr std::uint64_t most(std::size_t file_bytes) {
        constexpr std::uint64_t ratio = 100, of_small_files = std::uint64_t{64} << 20U;
        return std::max(of_small_files, ratio * file_bytes);
    }

  private:
    std::uint64_t left_;
};

}  // namespace camber
