module;
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <iterator>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import :legal_names;
import :vtu_cells;

namespace camber::vtu {

namespace {

/// Large enough to compress well, small enough to keep all threads busy; a multiple of every number's size.
constexpr std::size_t block_bytes = std::size_t{1} << 17U;
/// Mantissas hardly compress: on curved meshes with fields the default level is half as fast and saves 1 % more.
constexpr int compression_level = 1;

Buffer<std::byte> compressed(std::span<const std::byte> bytes) {
    uLongf size = compressBound(static_cast<uLong>(bytes.size()));
    Buffer<std::byte> out(size);
    // The one way to fail with a buffer of that size.
    if (compress2(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                  static_cast<uLong>(bytes.size()), compression_level) != Z_OK)
        throw std::bad_alloc();
    return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)};
}

Buffer<std::byte> bytes_of(std::string_view text) {
    Buffer<std::byte> bytes(text.size());
    std::memcpy(bytes.data(), text.data(), text.size());
    return bytes;
}

std::string data_array(std::string_view type, const ArrayName& name, std::size_t offset) {
    std::string xml = "<DataArray type=\"" + std::string(type) + "\" Name=\"" + escaped(name.name) + "\"";
    if (!name.components.empty()) xml += " NumberOfComponents=\"" + std::to_string(name.components.size()) + "\"";
    for (std::size_t i = 0; i < name.components.size(); ++i)
        xml += " ComponentName" + std::to_string(i) + "=\"" + escaped(name.components[i]) + "\"";
    return xml + " format=\"appended\" offset=\"" + std::to_string(offset) + "\"/>\n";
}

}  // namespace

FieldNames field_names() {
    const std::string ghosts(ghost_array);
    return {{readable_name, std::string::npos, {"reference", ghosts}},
            {readable_name, std::string::npos, {"reference", "dimension", "entity", ghosts}}};
}

std::string escaped(std::string_view text) {
    std::string out;
    for (const char letter : text) {
        switch (letter) {
            case '&': out += "&amp;"; break;
            case '<': out += "&lt;"; break;
            case '>': out += "&gt;"; break;
            case '"': out += "&quot;"; break;
            default: out += static_cast<unsigned char>(letter) < ' ' ? ' ' : letter;
        }
    }
    return out;
}

Outcome<std::string> AppendedArrays::append(std::string_view type, const ArrayName& name, std::size_t n,
                                            std::size_t size,
                                            const std::function<void(std::size_t, std::size_t, std::byte*)>& fill) {
    const std::size_t in_block = block_bytes / size;
    const std::size_t blocks = (n + in_block - 1) / in_block;
    auto made = map_each(
        execution_, blocks,
        [&](std::size_t b) {
            const std::size_t first = b * in_block, last = std::min(n, first + in_block);
            Buffer<std::byte> raw((last - first) * size);
            fill(first, last, raw.data());
            return compressed(raw);
        },
        1);
    if (!made) return fail(std::move(made.error()));

    std::vector<std::uint64_t> header{blocks, block_bytes, n * size % block_bytes};
    header.reserve(3 + blocks);
    std::transform(made->begin(), made->end(), std::back_inserter(header),
                   [](const Buffer<std::byte>& block) { return std::uint64_t{block.size()}; });
    Buffer<std::byte> head(header.size() * sizeof(std::uint64_t));
    std::memcpy(head.data(), header.data(), head.size());

    std::string xml = data_array(type, name, bytes_);
    chunks_.reserve(chunks_.size() + blocks + 1);
    bytes_ += head.size();
    chunks_.push_back(std::move(head));
    for (Buffer<std::byte>& block : *made) {
        bytes_ += block.size();
        chunks_.push_back(std::move(block));
    }
    return xml;
}

Chunks AppendedArrays::finish(std::string_view xml) && {
    Chunks file;
    file.reserve(chunks_.size() + 2);
    file.push_back(bytes_of(std::string(xml) + "<AppendedData encoding=\"raw\">\n_"));
    std::move(chunks_.begin(), chunks_.end(), std::back_inserter(file));
    file.push_back(bytes_of("\n</AppendedData>\n</VTKFile>\n"));
    return file;
}

}  // namespace camber::vtu
