module;
#include <algorithm>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

namespace vtk {

namespace {

constexpr const char* damaged = "the file is cut off or damaged";
using Failure = decltype(fail(std::declval<Error>()));
constexpr std::string_view magic = "# vtk DataFile Version";

std::string lower(std::string_view word) {
    std::string text(word);
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

/// A name as it was before VTK made blanks and signs %20 and so on.
std::string decoded(std::string_view word) {
    std::string text;
    for (std::size_t i = 0; i < word.size(); ++i) {
        int code = 0;
        const char* const digits = word.data() + i + 1;
        if (word[i] == '%' && i + 2 < word.size() && std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2) {
            text += static_cast<char>(code);
            i += 2;
        } else {
            text += word[i];
        }
    }
    return text;
}

/// Reads a file from its begin to its end into what a VTU file has: arrays of points and cells.
class Parser {
  public:
    Parser(std::span<const std::byte> bytes, std::string_view name)
        : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {
        file_.bytes = bytes;
        file_.name = std::string(name);
    }

    Outcome<vtu::File> parse() && {
        if (auto head = read_head(); !head) return fail(std::move(head.error()));
        while (true) {
            skip_blanks();
            if (at_ == text_.size()) break;
            keyword_ = at_;
            if (auto read = read_section(lower(word())); !read) return fail(std::move(read.error()));
        }
        if (!has_grid_) return wrong("the file has no DATASET", "give a .vtk file");
        file_.pieces = {{file_.points, file_.cells}};
        return std::move(file_);
    }

  private:
    enum class Owner : std::uint8_t { whole, points, cells };

    // ------------------------------------------------------------ words

    void skip_blanks() {
        while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    }
    std::string_view word() {
        skip_blanks();
        const std::size_t begin = at_;
        while (at_ < text_.size() && !is_blank(text_[at_])) ++at_;
        return text_.substr(begin, at_ - begin);
    }
    std::string_view line() {
        const std::size_t end = std::min(text_.find('\n', at_), text_.size());
        std::string_view found = text_.substr(at_, end - at_);
        at_ = std::min(end + 1, text_.size());
        if (found.ends_with('\r')) found.remove_suffix(1);
        return found;
    }
    std::optional<std::uint64_t> count() {
        const std::string_view text = word();
        std::uint64_t value = 0;
        const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (error != std::errc{} || stop != text.data() + text.size() || value > text_.size() * 8 + 8)
            return std::nullopt;
        return value;
    }
    [[nodiscard]] Failure wrong(std::string what, std::string remedy = damaged) const {
        return fail(ErrorKind::input, std::move(what), vtu::place(file_, keyword_), {}, std::move(remedy));
    }
    [[nodiscard]] Failure refused(std::string what, std::string remedy) const {
        return fail(ErrorKind::unsupported, std::move(what), vtu::place(file_, keyword_), {}, std::move(remedy));
    }

    // ------------------------------------------------------------ numbers

    template <class T>
    Outcome<vtu::Numbers> text_numbers(std::uint64_t n) {
        if (n > (text_.size() - at_ + 1) / 2)
            return wrong("announces " + std::to_string(n) + " numbers, more than follow");
        Buffer<T> numbers;
        numbers.reserve(n);
        Words words{text_.data() + at_, text_.data() + text_.size()};
        for (std::uint64_t i = 0; i < n; ++i) {
            bool sound = false;
            if constexpr (std::is_floating_point_v<T>) {
                double value = 0;
                sound = read_number(words, value);
                numbers.push_back(static_cast<T>(value));
            } else {
                T value{};
                if (words.find()) {
                    const auto [stop, error] = std::from_chars(words.at, words.end, value);
                    words.at = stop;
                    sound = error == std::errc{} && words.at_word_end();
                }
                numbers.push_back(value);
            }
            if (!sound) {
                at_ = static_cast<std::size_t>(words.at - text_.data());
                return wrong("number " + std::to_string(i + 1) + " of " + std::to_string(n) +
                             " is missing, malformed or too large for its kind");
            }
        }
        at_ = static_cast<std::size_t>(words.at - text_.data());
        return numbers;
    }

    /// They follow the end of this line, the most significant byte first.
    template <class T>
    Outcome<vtu::Numbers> binary_numbers(std::uint64_t n) {
        line();
        if (n > (text_.size() - at_) / sizeof(T))
            return wrong("announces " + std::to_string(n) + " numbers, more than follow");
        Buffer<T> numbers(n);
        if (n > 0) std::memcpy(numbers.data(), text_.data() + at_, n * sizeof(T));
        at_ += n * sizeof(T);
        if constexpr (sizeof(T) > 1 && std::endian::native == std::endian::little)
            for (T& number : numbers) {
                auto* const begin = reinterpret_cast<std::byte*>(&number);
                std::reverse(begin, begin + sizeof(T));
            }
        return numbers;
    }
    template <class T>
    Outcome<vtu::Numbers> numbers_of(std::uint64_t n) {
        return binary_ ? binary_numbers<T>(n) : text_numbers<T>(n);
    }
    /// Eight in a byte.
    Outcome<vtu::Numbers> bits(std::uint64_t n) {
        if (!binary_) return text_numbers<std::uint8_t>(n);
        return binary_numbers<std::uint8_t>((n + 7) / 8).map([&](const vtu::Numbers& packed) -> vtu::Numbers {
            const auto& bytes = std::get<Buffer<std::uint8_t>>(packed);
            Buffer<std::uint8_t> numbers(n);
            for (std::uint64_t i = 0; i < n; ++i)
                numbers[i] = static_cast<std::uint8_t>(bytes[i / 8] >> (7U - i % 8U) & 1U);
            return numbers;
        });
    }

    Outcome<vtu::Numbers> numbers(const std::string& type, std::uint64_t rows, std::uint64_t components) {
        if (components != 0 && rows > std::numeric_limits<std::uint64_t>::max() / components)
            return wrong("has more numbers than can be counted");
        const std::uint64_t n = rows * components;
        if (type == "double") return numbers_of<double>(n);
        if (type == "float") return numbers_of<float>(n);
        if (type == "int" || type == "vtkidtype") return numbers_of<std::int32_t>(n);
        if (type == "unsigned_int") return numbers_of<std::uint32_t>(n);
        if (type == "vtktypeint64" || type == "long" || type == "vtktypeint64_t") return numbers_of<std::int64_t>(n);
        if (type == "vtktypeuint64" || type == "unsigned_long") return numbers_of<std::uint64_t>(n);
        if (type == "short") return numbers_of<std::int16_t>(n);
        if (type == "unsigned_short") return numbers_of<std::uint16_t>(n);
        if (type == "unsigned_char") return numbers_of<std::uint8_t>(n);
        if (type == "char" || type == "signed_char") return numbers_of<std::int8_t>(n);
        if (type == "bit") return bits(n);
        return refused("has an array of the type \"" + vtu::printable(type) + "\", which is none of numbers",
                       "write it as .vtu");
    }

    // ------------------------------------------------------------ sections

    Outcome<Done> read_head() {
        if (!text_.starts_with(magic))
            return wrong("does not begin with \"# vtk DataFile Version\"", "give a .vtk file");
        at_ = magic.size();
        const std::string version(word());
        has_offsets_ = version.starts_with("5");
        line();
        line();  // a title of any kind
        const std::string kind = lower(word());
        if (kind != "ascii" && kind != "binary") return wrong("the third line is neither ASCII nor BINARY");
        binary_ = kind == "binary";
        return Done{};
    }

    Outcome<Done> read_section(const std::string& key) {
        if (key == "dataset") return data_set(lower(word()));
        if (key == "points") return points();
        if (key == "cells") return has_offsets_ ? cells_by_offsets() : cells_by_counts();
        if (key == "cell_types") return cell_types();
        if (key == "point_data") return begin_data(Owner::points, file_.points);
        if (key == "cell_data") return begin_data(Owner::cells, file_.cells);
        if (key == "metadata") return skip_metadata();
        if (key == "field") return field_data();
        return attribute(key);
    }

    Outcome<Done> data_set(const std::string& kind) {
        if (kind != "unstructured_grid")
            return refused("is a data set of the kind " + vtu::printable(kind) + ", not UNSTRUCTURED_GRID",
                           "write it as one: in ParaView the filter Append Datasets, then Save Data");
        has_grid_ = true;
        return Done{};
    }

    Outcome<Done> points() {
        const auto n = count();
        const std::string type = lower(word());
        if (!n) return wrong("the number of points is missing or malformed");
        file_.points = *n;
        return numbers(type, *n, 3).map([&](vtu::Numbers made) {
            file_.point_arrays = {array("Points", 3, std::move(made))};
            return Done{};
        });
    }

    /// Each cell with the number of its points before them.
    Outcome<Done> cells_by_counts() {
        const auto n = count(), size = count();
        if (!n || !size || *n > *size) return wrong("the numbers of CELLS are missing or malformed");
        const auto read = numbers("int", *size, 1);
        if (!read) return fail(read.error());
        const auto& rows = std::get<Buffer<std::int32_t>>(*read);
        Buffer<std::int64_t> offsets;
        Buffer<std::int32_t> connectivity;
        offsets.reserve(*n);
        connectivity.reserve(*size - *n);
        std::size_t at = 0;
        for (std::uint64_t c = 0; c < *n; ++c) {
            if (at >= rows.size() || rows[at] < 0 || std::cmp_greater(rows[at], rows.size() - at - 1))
                return wrong("CELLS: the number of points of cell " + std::to_string(c + 1) + " is wrong");
            const auto nodes = static_cast<std::size_t>(rows[at++]);
            const auto first = rows.begin() + static_cast<std::ptrdiff_t>(at);
            connectivity.insert(connectivity.end(), first, first + static_cast<std::ptrdiff_t>(nodes));
            at += nodes;
            offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
        }
        if (at != rows.size()) return wrong("CELLS has more numbers than its cells");
        file_.cells = *n;
        file_.cell_arrays.push_back(array("connectivity", 1, std::move(connectivity)));
        file_.cell_arrays.push_back(array("offsets", 1, std::move(offsets)));
        return Done{};
    }

    /// Where each cell begins and the last ends, and the points of all; since version 5.
    Outcome<Done> cells_by_offsets() {
        const auto n = count(), size = count();
        if (!n || !size) return wrong("the numbers of CELLS are missing or malformed");
        if (*n == 0) return Done{};
        if (lower(word()) != "offsets") return wrong("CELLS is not followed by OFFSETS");
        auto offsets = numbers(lower(word()), *n, 1);
        if (!offsets) return fail(std::move(offsets.error()));
        if (lower(word()) != "connectivity") return wrong("OFFSETS is not followed by CONNECTIVITY");
        auto connectivity = numbers(lower(word()), *size, 1);
        if (!connectivity) return fail(std::move(connectivity.error()));
        std::visit([](auto& begins) { begins.erase(begins.begin()); }, *offsets);
        file_.cells = *n - 1;
        file_.cell_arrays.push_back(array("connectivity", 1, std::move(*connectivity)));
        file_.cell_arrays.push_back(array("offsets", 1, std::move(*offsets)));
        return Done{};
    }

    Outcome<Done> cell_types() {
        const auto n = count();
        if (!n) return wrong("the number of CELL_TYPES is missing or malformed");
        return numbers("int", *n, 1).map([&](vtu::Numbers made) {
            file_.cell_arrays.push_back(array("types", 1, std::move(made)));
            return Done{};
        });
    }

    Outcome<Done> begin_data(Owner owner, std::uint64_t rows) {
        const auto n = count();
        if (!n || *n != rows)
            return wrong("the number of rows is not that of the points or cells, " + std::to_string(rows));
        owner_ = owner;
        rows_ = rows;
        return Done{};
    }

    /// Names of components and the like, to the next empty line.
    Outcome<Done> skip_metadata() {
        line();
        while (at_ < text_.size() && !line().empty()) {
        }
        return Done{};
    }

    Outcome<Done> field_data() {
        word();
        const auto n = count();
        if (!n) return wrong("the number of the arrays of FIELD is missing or malformed");
        for (std::uint64_t i = 0; i < *n; ++i) {
            keyword_ = at_;
            std::string name = decoded(word());
            if (name == "METADATA") {
                if (auto skipped = skip_metadata(); !skipped) return skipped;
                name = decoded(word());
            }
            const auto components = count(), rows = count();
            if (!components || !rows)
                return wrong("FIELD: array " + std::to_string(i + 1) + " has no numbers of its size");
            auto made = numbers(lower(word()), *rows, *components);
            if (!made) return fail(std::move(made.error()));
            add(name, *components, std::move(*made));
        }
        return Done{};
    }

    /// An array by its kind; the tables of colours that some have are passed by.
    Outcome<Done> attribute(const std::string& key) {
        const std::string name = decoded(word());
        if (key == "lookup_table") {
            const auto n = count();
            if (!n) return wrong("LOOKUP_TABLE has no size");
            return discard(binary_ ? numbers("unsigned_char", *n, 4) : numbers("float", *n, 4));
        }
        if (key == "color_scalars") {
            const auto components = count();
            if (!components) return wrong("COLOR_SCALARS has no number of components");
            return keep(name, *components, binary_ ? "unsigned_char" : "float");
        }
        if (key == "scalars") return scalars(name);
        if (key == "texture_coordinates") {
            const auto components = count();
            if (!components) return wrong("TEXTURE_COORDINATES has no number of components");
            return keep(name, *components, lower(word()));
        }
        if (key == "vectors" || key == "normals") return keep(name, 3, lower(word()));
        if (key == "tensors") return keep(name, 9, lower(word()));
        if (key == "tensors6") return keep(name, 6, lower(word()));
        if (key == "global_ids" || key == "pedigree_ids" || key == "edge_flags") return keep(name, 1, lower(word()));
        return wrong("\"" + vtu::printable(key) + "\" is no keyword of VTK");
    }

    Outcome<Done> scalars(const std::string& name) {
        const std::string type = lower(word());
        std::uint64_t components = 1;
        std::size_t before = at_;
        if (const auto given = count())
            components = *given;
        else
            at_ = before;
        before = at_;
        if (lower(word()) == "lookup_table")
            word();
        else
            at_ = before;
        return keep(name, components, type);
    }

    Outcome<Done> keep(const std::string& name, std::uint64_t components, const std::string& type) {
        auto made = numbers(type, rows_, components);
        if (!made) return fail(std::move(made.error()));
        add(name, components, std::move(*made));
        return Done{};
    }
    static Outcome<Done> discard(const Outcome<vtu::Numbers>& numbers) {
        if (!numbers) return fail(numbers.error());
        return Done{};
    }

    vtu::DataArray array(std::string name, std::size_t components, vtu::Numbers numbers) const {
        vtu::DataArray made;
        made.name = std::move(name);
        made.components = components;
        made.at = keyword_;
        made.numbers = std::make_shared<const vtu::Numbers>(std::move(numbers));
        return made;
    }
    void add(const std::string& name, std::size_t components, vtu::Numbers numbers) {
        if (owner_ == Owner::whole) {
            ++file_.arrays_of_the_whole;
            return;
        }
        auto& arrays = owner_ == Owner::points ? file_.point_data : file_.cell_data;
        arrays.push_back(array(name, components, std::move(numbers)));
    }

    std::string_view text_;
    std::size_t at_ = 0, keyword_ = 0;
    vtu::File file_;
    bool binary_ = false, has_offsets_ = false, has_grid_ = false;
    Owner owner_ = Owner::whole;
    std::uint64_t rows_ = 0;
};

}  // namespace

}  // namespace vtk

Outcome<DecodedMesh> decode_vtk(std::span<const std::byte> bytes, std::string_view name, const DecodeOptions& options,
                                const Execution& execution) {
    return guarded([&]() -> Outcome<DecodedMesh> {
        const auto file = vtk::Parser(bytes, name).parse();
        if (!file) return fail(file.error());
        return vtu::mesh_of(*file, options, execution);
    });
}

bool is_vtk(std::span<const std::byte> bytes, VtkEncoding encoding) {
    constexpr std::size_t soon = 1024;
    std::string_view text(reinterpret_cast<const char*>(bytes.data()), std::min(bytes.size(), soon));
    if (!text.starts_with(vtk::magic)) return false;
    for (int lines = 0; lines < 2; ++lines) {
        const std::size_t end = text.find('\n');
        if (end == std::string_view::npos) return encoding == VtkEncoding::ascii;
        text.remove_prefix(end + 1);
    }
    return vtk::lower(text.substr(0, 6)).starts_with("binary") == (encoding == VtkEncoding::binary);
}

}  // namespace camber
