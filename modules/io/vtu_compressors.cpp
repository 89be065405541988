module;
#include <lz4.h>
#include <lzma.h>
#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
module camber.io;
import camber.core;

/// VTK's compressors: each block by itself.
namespace camber::vtu {

namespace {

bool by_zlib(std::span<const std::byte> packed, std::span<std::byte> to) {
    auto size = static_cast<uLongf>(to.size());
    const int status = uncompress(reinterpret_cast<Bytef*>(to.data()), &size,
                                  reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size()));
    return status == Z_OK && size == to.size();
}

bool by_lz4(std::span<const std::byte> packed, std::span<std::byte> to) {
    if (!std::in_range<int>(packed.size()) || !std::in_range<int>(to.size())) return false;
    const int size =
        LZ4_decompress_safe(reinterpret_cast<const char*>(packed.data()), reinterpret_cast<char*>(to.data()),
                            static_cast<int>(packed.size()), static_cast<int>(to.size()));
    return std::cmp_equal(size, to.size());
}

bool by_lzma(std::span<const std::byte> packed, std::span<std::byte> to) {
    // A dictionary of what is written at most: a damaged header asks for any memory.
    std::uint64_t memory = std::uint64_t{256} << 20U;
    std::size_t read = 0, written = 0;
    const lzma_ret status =
        lzma_stream_buffer_decode(&memory, 0, nullptr, reinterpret_cast<const std::uint8_t*>(packed.data()), &read,
                                  packed.size(), reinterpret_cast<std::uint8_t*>(to.data()), &written, to.size());
    return status == LZMA_OK && written == to.size();
}

}  // namespace

bool uncompress_block(Compressor compressor, std::span<const std::byte> packed, std::span<std::byte> to) {
    switch (compressor) {
        case Compressor::none: break;
        case Compressor::zlib: return by_zlib(packed, to);
        case Compressor::lz4: return by_lz4(packed, to);
        case Compressor::lzma: return by_lzma(packed, to);
    }
    return false;
}

}  // namespace camber::vtu
