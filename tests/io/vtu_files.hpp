// VTU files as other programs write them, and the results of reading them.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "generated.hpp"

import camber.core;
import camber.io;

namespace vtu_files {

inline camber::Outcome<camber::DecodedMesh> read(const std::string& text) {
    return camber::decode_vtu(generated::bytes_of(text), "in.vtu", {});
}

inline std::string message(const std::string& text) {
    const auto decoded = read(text);
    return decoded ? "no error" : camber::describe(decoded.error());
}

enum class Form { ascii, binary, split_binary, appended_raw, appended_base64 };

inline std::string base64(const std::string& bytes) {
    constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k)
            bits = bits << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : letters[bits >> (18 - 6 * k) & 63U];
    }
    return text;
}

/// An independent writer: writes arrays in the given encoding, word size and byte order.
class File {
  public:
    File(Form form, bool big, bool wide) : form_(form), big_(big), wide_(wide) {}

    template <class T>
    std::string array(const std::string& type, const std::string& name, const std::vector<T>& values,
                      int components = 1) {
        const std::string tag = "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
                                std::to_string(components) + "\" format=\"";
        if (form_ == Form::ascii) {
            std::string text;
            for (const T value : values)
                text +=
                    (std::is_integral_v<T> ? std::to_string(static_cast<long long>(value)) : std::to_string(value)) +
                    " ";
            return tag + "ascii\">\n" + text + "\n</DataArray>\n";
        }
        std::string data;
        for (const T value : values) data += bytes(value);
        const std::string header =
            wide_ ? bytes(std::uint64_t{data.size()}) : bytes(static_cast<std::uint32_t>(data.size()));
        if (form_ == Form::binary) return tag + "binary\">\n  " + base64(header + data) + "\n</DataArray>\n";
        if (form_ == Form::split_binary)
            return tag + "binary\">" + base64(header) + "\n" + base64(data) + "</DataArray>\n";
        const std::string offset = std::to_string(appended_.size());
        appended_ += form_ == Form::appended_raw ? header + data : base64(header + data);
        return tag + "appended\" offset=\"" + offset + "\"/>\n";
    }

    [[nodiscard]] std::string whole(const std::string& piece) const {
        const std::string header = wide_ ? " header_type=\"UInt64\"" : "";
        std::string text = "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"" +
                           std::string(big_ ? "BigEndian" : "LittleEndian") + "\"" + header +
                           ">\n<UnstructuredGrid>\n" + piece + "</UnstructuredGrid>\n";
        if (form_ == Form::appended_raw || form_ == Form::appended_base64)
            text += "<AppendedData encoding=\"" + std::string(form_ == Form::appended_raw ? "raw" : "base64") +
                    "\">\n   _" + appended_ + "\n</AppendedData>\n";
        return text + "</VTKFile>\n";
    }

  private:
    template <class T>
    [[nodiscard]] std::string bytes(T value) const {
        std::string out(sizeof value, '\0');
        std::memcpy(out.data(), &value, sizeof value);
        if (big_ != (std::endian::native == std::endian::big)) std::reverse(out.begin(), out.end());
        return out;
    }

    Form form_;
    bool big_, wide_;
    std::string appended_;
};

/// A tetrahedron, two of its faces, an edge and, first, a vertex. Id and Real are the number types.
template <class Id, class Real>
std::string four_cells(File file, const std::string& ids, const std::string& reals) {
    std::string piece = "<Piece NumberOfPoints=\"4\" NumberOfCells=\"5\">\n<PointData>\n";
    piece += file.array<Real>(reals, "speed", {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, 3);
    piece += file.array<Id>(ids, "reference", {5, 6, 7, 8});
    piece += "</PointData>\n<CellData>\n" + file.array<Id>(ids, "medit:ref", {9, 1, 2, 3, 4});
    piece += file.array<Real>(reals, "level", {0.5, 1.5, 2.5, 3.5, 4.5});
    piece += "</CellData>\n<Points>\n" + file.array<Real>(reals, "Points", {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, 3);
    piece += "</Points>\n<Cells>\n" + file.array<Id>(ids, "connectivity", {0, 0, 1, 0, 1, 2, 0, 1, 2, 3, 3, 2, 1});
    piece += file.array<Id>(ids, "offsets", {1, 3, 6, 10, 13});
    piece += file.array<std::uint8_t>("UInt8", "types", {1, 3, 5, 10, 5}) + "</Cells>\n</Piece>\n";
    return file.whole(piece);
}

/// A text file with these types, connectivity, offsets, and cell and point data.
inline std::string plain(const std::string& types, const std::string& connectivity, const std::string& offsets,
                         const std::string& cell_data = "", const std::string& point_data = "") {
    const auto count = [](const std::string& text) {
        std::size_t words = 0;
        for (std::size_t i = 0; i < text.size(); ++i)
            words += text[i] != ' ' && (i == 0 || text[i - 1] == ' ') ? 1U : 0U;
        return std::to_string(words);
    };
    const auto array = [](const std::string& type, const std::string& name, const std::string& text) {
        return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" format=\"ascii\">" + text + "</DataArray>\n";
    };
    return "<VTKFile type=\"UnstructuredGrid\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"5\" NumberOfCells=\"" +
           count(types) + "\">\n<PointData>" + point_data + "</PointData>\n<CellData>" + cell_data +
           "</CellData>\n<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0  1 0 0  "
           "0 1 0  0 0 1  1 1 1</DataArray></Points>\n<Cells>\n" +
           array("Int64", "connectivity", connectivity) + array("Int64", "offsets", offsets) +
           array("UInt8", "types", types) + "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

inline std::string cell_array(const std::string& type, const std::string& name, const std::string& text,
                              const std::string& components = "1") {
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" + components +
           "\" format=\"ascii\">" + text + "</DataArray>";
}

}  // namespace vtu_files
