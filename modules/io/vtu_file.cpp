// Opens VTU files: XML and compressors.
module;
#include <lz4.h>
#include <lzma.h>
#include <pugixml.hpp>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>
module camber.io;
import camber.core;

namespace camber::vtu {

namespace {

constexpr const char* cut_off = "it seems to be cut off";
constexpr std::string_view blanks = " \t\r\n";
constexpr std::size_t no_position = std::numeric_limits<std::size_t>::max();

auto fail_at(const File& file, std::size_t at, std::string what, std::string remedy = {}) {
    return fail(ErrorKind::input, std::move(what), place(file, at), {}, std::move(remedy));
}
auto refuse_at(const File& file, std::size_t at, std::string what, std::string remedy) {
    return fail(ErrorKind::unsupported, std::move(what), place(file, at), {}, std::move(remedy));
}

/// Returns the XML of the file without the raw data, which is not legal in XML.
Outcome<std::string> cut(File& file) {
    const std::string_view text(reinterpret_cast<const char*>(file.bytes.data()), file.bytes.size());
    const std::size_t element = text.find("<AppendedData");
    if (element == std::string_view::npos) return std::string(text);
    const std::size_t tag_end = text.find('>', element);
    const std::size_t close = text.rfind("</AppendedData>");
    if (tag_end == std::string_view::npos || close == std::string_view::npos || close < tag_end ||
        text.find("</VTKFile>", close) == std::string_view::npos)
        return fail_at(file, element, "the file ends within its AppendedData", cut_off);
    const std::size_t mark = text.find_first_not_of(blanks, tag_end + 1);
    if (mark >= close || text[mark] != '_')
        return fail_at(file, element, "AppendedData do not begin with an underscore");
    file.appended = text.substr(mark + 1, close - mark - 1);
    return std::string(text.substr(0, tag_end + 1)) + "</AppendedData></VTKFile>";
}

/// Limits memory, because a parsed XML node needs twenty times the bytes of its text.
constexpr std::ptrdiff_t max_tags = 200'000;

Outcome<std::shared_ptr<pugi::xml_document>> parsed(const File& file, const std::string& xml) {
    if (std::count(xml.begin(), xml.end(), '<') > max_tags)
        return fail_at(file, 0, "has more than " + std::to_string(max_tags) + " XML tags", "give a .vtu file");
    auto document = std::make_shared<pugi::xml_document>();
    const auto result = document->load_buffer(xml.data(), xml.size(), pugi::parse_default, pugi::encoding_utf8);
    if (result.status == pugi::status_out_of_memory) throw std::bad_alloc();
    if (result) return document;
    return fail_at(file, static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0)),
                   std::string("the XML is damaged: ") + result.description(), "it is cut off, or is not a VTU file");
}

std::size_t at(const pugi::xml_node& node) {
    return static_cast<std::size_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0));
}

std::optional<std::uint64_t> number(const pugi::xml_node& node, const char* name) {
    const std::string_view text = node.attribute(name).as_string();
    std::uint64_t value = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || stop != text.data() + text.size()) return std::nullopt;
    return value;
}

std::optional<Compressor> compressor_of(std::string_view name) {
    if (name.empty()) return Compressor::none;
    if (name == "vtkZLibDataCompressor") return Compressor::zlib;
    if (name == "vtkLZ4DataCompressor") return Compressor::lz4;
    if (name == "vtkLZMADataCompressor") return Compressor::lzma;
    return std::nullopt;
}

Outcome<Done> read_head(File& file, const pugi::xml_node& root) {
    const auto word = [&](const char* name, const char* otherwise) {
        return std::string(root.attribute(name).as_string(otherwise));
    };
    if (word("type", "") != "UnstructuredGrid")
        return refuse_at(file, at(root), "is not an UnstructuredGrid",
                         "give the .vtu file of an unstructured grid. If several files belong together, give one of "
                         "them");
    const std::string order = word("byte_order", "LittleEndian"), header = word("header_type", "UInt32"),
                      compressor = word("compressor", "");
    if (order != "LittleEndian" && order != "BigEndian")
        return fail_at(file, at(root), "byte_order is neither LittleEndian nor BigEndian");
    if (header != "UInt32" && header != "UInt64")
        return fail_at(file, at(root), "header_type is neither UInt32 nor UInt64");
    const auto known = compressor_of(compressor);
    if (!known)
        return refuse_at(file, at(root), "its data are compressed by none of VTK's compressors (ZLib, LZ4, LZMA)",
                         "write it with one of these compressors or without (Compressor Type in ParaView)");
    file.swapped = (order == "LittleEndian") != (std::endian::native == std::endian::little);
    file.word = header == "UInt32" ? 4 : 8;
    file.compressor = *known;
    const std::string encoding = root.child("AppendedData").attribute("encoding").as_string("base64");
    if (encoding != "raw" && encoding != "base64")
        return fail_at(file, at(root.child("AppendedData")), "the encoding of AppendedData is neither raw nor base64");
    file.encoding = encoding == "raw" ? Encoding::raw : Encoding::base64;
    return Done{};
}

std::vector<DataArray> arrays_in(const pugi::xml_node& section) {
    std::vector<DataArray> arrays;
    for (const pugi::xml_node& node : section.children()) {
        const std::string_view tag = node.name();
        if (tag != "DataArray" && tag != "Array") continue;
        arrays.push_back({.name = node.attribute("Name").as_string(),
                          .type = node.attribute("type").as_string(),
                          .components = number(node, "NumberOfComponents").value_or(1),
                          .format = node.attribute("format").as_string(),
                          .offset = number(node, "offset").value_or(no_position),
                          .text = node.text().get(),
                          .at = at(node)});
    }
    return arrays;
}

/// Adds the arrays of the next piece to those with the same name, type and components. Removes arrays that the next
/// piece lacks.
void join_arrays(std::vector<DataArray>& arrays, std::vector<DataArray> more) {
    std::erase_if(arrays, [&](DataArray& array) {
        const auto same = std::find_if(more.begin(), more.end(), [&](const DataArray& a) {
            return a.name == array.name && a.type == array.type && a.components == array.components;
        });
        if (same == more.end()) return true;
        array.other_pieces.push_back(std::move(*same));
        same->name = std::string(1, '\0');  // this array must not be found again
        return false;
    });
}

Outcome<Done> read_piece(File& file, const pugi::xml_node& piece) {
    const auto points = number(piece, "NumberOfPoints"), cells = number(piece, "NumberOfCells");
    if (!points || !cells) return fail_at(file, at(piece), "the Piece has no NumberOfPoints or no NumberOfCells");
    file.field_data_arrays += arrays_in(piece.child("FieldData")).size();
    const bool first = file.pieces.empty();
    const std::uint64_t room = std::numeric_limits<std::uint64_t>::max();
    if (*points > room - file.points || *cells > room - file.cells)
        return fail_at(file, at(piece), "the pieces have more points and cells than can be counted");
    file.points += *points;
    file.cells += *cells;
    file.pieces.push_back({*points, *cells});
    for (const auto& [section, name] :
         {std::pair{&file.point_data, "PointData"}, std::pair{&file.cell_data, "CellData"},
          std::pair{&file.point_arrays, "Points"}, std::pair{&file.cell_arrays, "Cells"}}) {
        auto arrays = arrays_in(piece.child(name));
        if (first)
            *section = std::move(arrays);
        else
            join_arrays(*section, std::move(arrays));
    }
    return Done{};
}

Outcome<Done> read_pieces(File& file, const pugi::xml_node& root) {
    const pugi::xml_node grid = root.child("UnstructuredGrid");
    file.field_data_arrays = arrays_in(grid.child("FieldData")).size();
    const auto pieces = grid.children("Piece");
    if (pieces.begin() == pieces.end()) return fail_at(file, at(root), "has no Piece", "the file is damaged");
    const auto is_empty = [](const pugi::xml_node& piece) {
        return number(piece, "NumberOfPoints") == 0 && number(piece, "NumberOfCells") == 0;
    };
    const bool all_empty = std::all_of(pieces.begin(), pieces.end(), is_empty);
    for (const pugi::xml_node& piece : pieces)
        if (all_empty || !is_empty(piece))
            if (auto read = read_piece(file, piece); !read) return read;
    return Done{};
}

}  // namespace

std::string printable(std::string_view name) {
    std::string text(name.substr(0, 80));
    for (char& c : text)
        if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
    return text;
}

std::string place(const File& file, std::size_t at) {
    const auto text = file.bytes.first(std::min(at, file.bytes.size()));
    return file.name + ": line " + std::to_string(std::count(text.begin(), text.end(), std::byte{'\n'}) + 1);
}

std::string_view type_of_file(std::span<const std::byte> bytes) {
    constexpr std::size_t soon = 4096;  // number of bytes, because a declaration and comments may come first
    constexpr std::string_view name = "type=";
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), soon));
    const std::size_t first = text.find_first_not_of("\xEF\xBB\xBF \t\r\n");
    if (first == std::string_view::npos || text[first] != '<') return {};
    const std::size_t tag = text.find("<VTKFile");
    if (tag == std::string_view::npos) return {};
    const std::string_view head = text.substr(tag, text.find('>', tag) - tag);
    for (std::size_t at = head.find(name); at != std::string_view::npos; at = head.find(name, at + 1)) {
        const std::size_t begin = at + name.size() + 1;
        if (blanks.find(head[at - 1]) == std::string_view::npos || begin >= head.size())
            continue;  // the text found is a part of another attribute such as header_type
        return head.substr(begin, head.find(head[begin - 1], begin) - begin);
    }
    return {};
}

Outcome<File> open_file(std::span<const std::byte> bytes, std::string_view name) {
    File file{.bytes = bytes, .name = std::string(name)};
    const auto xml = cut(file);
    if (!xml) return fail(xml.error());
    const auto document = parsed(file, *xml);
    if (!document) return fail(document.error());
    const pugi::xml_node root = (*document)->child("VTKFile");
    if (!root) return fail_at(file, 0, "has no VTKFile element", "give a .vtu file");
    file.document = *document;
    return read_head(file, root).and_then([&](Done) { return read_pieces(file, root); }).map([&](Done) {
        return std::move(file);
    });
}

// VTK's compressors. VTK compresses each block of an array separately.

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
    // Maximum memory of the LZMA dictionary, because a damaged header may request any size.
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

namespace camber {

bool is_vtu(std::span<const std::byte> bytes) { return vtu::type_of_file(bytes) == "UnstructuredGrid"; }

}  // namespace camber
