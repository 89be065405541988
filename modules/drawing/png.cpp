// Why not libpng: what is written is one kind of picture, whole and in memory, which is four chunks around what zlib
// makes, and zlib is needed for meshes anyway.
module;
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <zlib.h>
module camber.drawing;
import camber.core;

namespace camber {

namespace {

using Bytes = std::vector<std::uint8_t>;

void put_number(Bytes& out, std::uint32_t value) {
    for (const unsigned shift : {24U, 16U, 8U, 0U}) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

/// Length, name, data and the check sum of the last two.
void put_chunk(Bytes& out, std::string_view name, std::span<const std::uint8_t> data) {
    put_number(out, static_cast<std::uint32_t>(data.size()));
    const std::size_t begin = out.size();
    out.insert(out.end(), name.begin(), name.end());
    out.insert(out.end(), data.begin(), data.end());
    put_number(out, static_cast<std::uint32_t>(crc32(0, out.data() + begin, static_cast<uInt>(out.size() - begin))));
}

/// What a byte is told from: none, left, above, their mean, or the one of three that a gradient points to.
std::uint8_t predicted(int filter, int left, int above, int corner) {
    switch (filter) {
        case 1: return static_cast<std::uint8_t>(left);
        case 2: return static_cast<std::uint8_t>(above);
        case 3: return static_cast<std::uint8_t>((left + above) / 2);
        case 4: {
            const int a = std::abs(above - corner), b = std::abs(left - corner),
                      c = std::abs(left + above - 2 * corner);
            return static_cast<std::uint8_t>(a <= b && a <= c ? left : b <= c ? above : corner);
        }
        default: return 0;
    }
}

/// A row by that filter, the filter's number before it.
Bytes filtered(int filter, std::span<const std::uint8_t> row, std::span<const std::uint8_t> above, std::size_t pixel) {
    Bytes out(row.size() + 1);
    out[0] = static_cast<std::uint8_t>(filter);
    for (std::size_t i = 0; i < row.size(); ++i) {
        const int left = i < pixel ? 0 : row[i - pixel], up = above.empty() ? 0 : above[i];
        const int corner = i < pixel || above.empty() ? 0 : above[i - pixel];
        out[i + 1] = static_cast<std::uint8_t>(row[i] - predicted(filter, left, up, corner));
    }
    return out;
}

/// How far bytes are from 0: what is small packs well.
std::size_t weight(const Bytes& row) {
    std::size_t sum = 0;
    for (std::size_t i = 1; i < row.size(); ++i) sum += std::min<std::size_t>(row[i], 256U - row[i]);
    return sum;
}

/// The rows, each by the filter that leaves least; pixels of 3 bytes where all are opaque.
Bytes filtered_rows(const Image& image, std::size_t pixel) {
    Bytes out;
    Bytes row(image.width * pixel), above;
    for (std::size_t y = 0; y < image.height; ++y) {
        for (std::size_t x = 0; x < image.width; ++x)
            std::copy_n(image.bytes.data() + (y * image.width + x) * 4, pixel,
                        row.begin() + static_cast<std::ptrdiff_t>(x * pixel));
        Bytes best;
        for (int filter = 0; filter < 5; ++filter) {
            Bytes tried = filtered(filter, row, above, pixel);
            if (best.empty() || weight(tried) < weight(best)) best = std::move(tried);
        }
        out.insert(out.end(), best.begin(), best.end());
        above = row;
    }
    return out;
}

}  // namespace

Outcome<Buffer<std::byte>> png(const Image& image) {
    return guarded([&]() -> Outcome<Buffer<std::byte>> {
        bool is_opaque = true;
        for (std::size_t i = 3; i < image.bytes.size(); i += 4) is_opaque = is_opaque && image.bytes[i] == 255;
        const Bytes rows = filtered_rows(image, is_opaque ? 3 : 4);
        uLongf size = compressBound(static_cast<uLong>(rows.size()));
        Bytes packed(size);
        if (compress2(packed.data(), &size, rows.data(), static_cast<uLong>(rows.size()), Z_BEST_COMPRESSION) != Z_OK)
            return fail(ErrorKind::memory, "zlib could not pack the picture");
        packed.resize(size);
        Bytes out{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, head;
        put_number(head, static_cast<std::uint32_t>(image.width));
        put_number(head, static_cast<std::uint32_t>(image.height));
        const std::array<std::uint8_t, 5> kind{8, static_cast<std::uint8_t>(is_opaque ? 2 : 6), 0, 0, 0};
        head.insert(head.end(), kind.begin(), kind.end());
        put_chunk(out, "IHDR", head);
        put_chunk(out, "IDAT", packed);
        put_chunk(out, "IEND", {});
        Buffer<std::byte> bytes(out.size());
        std::memcpy(bytes.data(), out.data(), out.size());
        return bytes;
    });
}

}  // namespace camber
