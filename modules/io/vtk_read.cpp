module;
#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

namespace vtk {

namespace {

constexpr std::string_view magic = "# vtk DataFile Version";

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

class Parser {
  public:
    Parser(std::span<const std::byte> bytes, std::string_view name)
        : source_{std::string(name), {reinterpret_cast<const char*>(bytes.data()), bytes.size()}} {
        file_.bytes = bytes;
        file_.name = std::string(name);
    }

    Outcome<vtu::File> parse() && {
        if (auto head = read_head(); !head) return fail(std::move(head.error()));
        while (true) {
            source_.skip_blanks();
            if (source_.at_end()) break;
            source_.keyword = source_.at;
            if (auto read = read_section(lower(source_.word())); !read) return fail(std::move(read.error()));
        }
        if (!has_grid_) return source_.wrong("the file has no DATASET", "give a .vtk file");
        file_.pieces = {{file_.points, file_.cells}};
        return std::move(file_);
    }

  private:
    enum class Owner : std::uint8_t { whole, points, cells };

    Outcome<Done> read_head() {
        if (!source_.text.starts_with(magic))
            return source_.wrong("does not begin with \"# vtk DataFile Version\"", "give a .vtk file");
        source_.at = magic.size();
        const std::string version(source_.word());
        has_offsets_ = version.starts_with("5");
        source_.line();
        source_.line();  // title line
        const std::string kind = lower(source_.word());
        if (kind != "ascii" && kind != "binary") return source_.wrong("the third line is neither ASCII nor BINARY");
        source_.binary = kind == "binary";
        return Done{};
    }

    Outcome<Done> read_section(const std::string& key) {
        if (key == "dataset") return data_set(lower(source_.word()));
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
            return source_.refused("is a data set of the kind " + vtu::printable(kind) + ", not UNSTRUCTURED_GRID",
                                   "convert it in ParaView: filter Append Datasets, then Save Data");
        has_grid_ = true;
        return Done{};
    }

    Outcome<Done> points() {
        const auto n = source_.count();
        const std::string type = lower(source_.word());
        if (!n) return source_.wrong("the number of points is missing or malformed");
        file_.points = *n;
        return source_.numbers(type, *n, 3).map([&](vtu::Numbers result) {
            file_.point_arrays = {array("Points", 3, std::move(result))};
            return Done{};
        });
    }

    Outcome<Done> cells_by_counts() {
        const auto n = source_.count(), size = source_.count();
        if (!n || !size || *n > *size) return source_.wrong("the numbers of CELLS are missing or malformed");
        const auto read = source_.numbers("int", *size, 1);
        if (!read) return fail(read.error());
        const auto& rows = std::get<Buffer<std::int32_t>>(*read);
        Buffer<std::int64_t> offsets;
        Buffer<std::int32_t> connectivity;
        offsets.reserve(*n);
        connectivity.reserve(*size - *n);
        std::size_t at = 0;
        for (std::uint64_t c = 0; c < *n; ++c) {
            if (at >= rows.size() || rows[at] < 0 || std::cmp_greater(rows[at], rows.size() - at - 1))
                return source_.wrong("CELLS: the number of points of cell " + std::to_string(c + 1) + " is wrong");
            const auto nodes = static_cast<std::size_t>(rows[at++]);
            const auto first = rows.begin() + static_cast<std::ptrdiff_t>(at);
            connectivity.insert(connectivity.end(), first, first + static_cast<std::ptrdiff_t>(nodes));
            at += nodes;
            offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
        }
        if (at != rows.size()) return source_.wrong("CELLS has more numbers than its cells");
        file_.cells = *n;
        file_.cell_arrays.push_back(array("connectivity", 1, std::move(connectivity)));
        file_.cell_arrays.push_back(array("offsets", 1, std::move(offsets)));
        return Done{};
    }

    /// Reads cells of version 5: the begin of each cell and the end of the last one, then the points of all cells.
    Outcome<Done> cells_by_offsets() {
        const auto n = source_.count(), size = source_.count();
        if (!n || !size) return source_.wrong("the numbers of CELLS are missing or malformed");
        if (*n == 0) return Done{};
        if (lower(source_.word()) != "offsets") return source_.wrong("CELLS is not followed by OFFSETS");
        auto offsets = source_.numbers(lower(source_.word()), *n, 1);
        if (!offsets) return fail(std::move(offsets.error()));
        if (lower(source_.word()) != "connectivity") return source_.wrong("OFFSETS is not followed by CONNECTIVITY");
        auto connectivity = source_.numbers(lower(source_.word()), *size, 1);
        if (!connectivity) return fail(std::move(connectivity.error()));
        std::visit([](auto& begins) { begins.erase(begins.begin()); }, *offsets);
        file_.cells = *n - 1;
        file_.cell_arrays.push_back(array("connectivity", 1, std::move(*connectivity)));
        file_.cell_arrays.push_back(array("offsets", 1, std::move(*offsets)));
        return Done{};
    }

    Outcome<Done> cell_types() {
        const auto n = source_.count();
        if (!n) return source_.wrong("the number of CELL_TYPES is missing or malformed");
        return source_.numbers("int", *n, 1).map([&](vtu::Numbers result) {
            file_.cell_arrays.push_back(array("types", 1, std::move(result)));
            return Done{};
        });
    }

    Outcome<Done> begin_data(Owner owner, std::uint64_t rows) {
        const auto n = source_.count();
        if (!n || *n != rows)
            return source_.wrong("the number of rows differs from the number of points or cells, " +
                                 std::to_string(rows));
        owner_ = owner;
        rows_ = rows;
        return Done{};
    }

    Outcome<Done> skip_metadata() {
        source_.line();
        while (source_.at < source_.text.size() && !source_.line().empty()) {
        }
        return Done{};
    }

    Outcome<Done> field_data() {
        source_.word();
        const auto n = source_.count();
        if (!n) return source_.wrong("the number of the arrays of FIELD is missing or malformed");
        for (std::uint64_t i = 0; i < *n; ++i) {
            source_.keyword = source_.at;
            std::string name = decoded(source_.word());
            if (name == "METADATA") {
                if (auto skipped = skip_metadata(); !skipped) return skipped;
                name = decoded(source_.word());
            }
            const auto components = source_.count(), rows = source_.count();
            if (!components || !rows)
                return source_.wrong("FIELD: array " + std::to_string(i + 1) + " has no valid size");
            auto result = source_.numbers(lower(source_.word()), *rows, *components);
            if (!result) return fail(std::move(result.error()));
            add(name, *components, std::move(*result));
        }
        return Done{};
    }

    Outcome<Done> attribute(const std::string& key) {
        const std::string name = decoded(source_.word());
        if (key == "lookup_table") {
            const auto n = source_.count();
            if (!n) return source_.wrong("LOOKUP_TABLE has no size");
            return discard(source_.binary ? source_.numbers("unsigned_char", *n, 4) : source_.numbers("float", *n, 4));
        }
        if (key == "color_scalars") {
            const auto components = source_.count();
            if (!components) return source_.wrong("COLOR_SCALARS has no number of components");
            return store_array(name, *components, source_.binary ? "unsigned_char" : "float");
        }
        if (key == "scalars") return scalars(name);
        if (key == "texture_coordinates") {
            const auto components = source_.count();
            if (!components) return source_.wrong("TEXTURE_COORDINATES has no number of components");
            return store_array(name, *components, lower(source_.word()));
        }
        if (key == "vectors" || key == "normals") return store_array(name, 3, lower(source_.word()));
        if (key == "tensors") return store_array(name, 9, lower(source_.word()));
        if (key == "tensors6") return store_array(name, 6, lower(source_.word()));
        if (key == "global_ids" || key == "pedigree_ids" || key == "edge_flags")
            return store_array(name, 1, lower(source_.word()));
        return source_.wrong(in_quotes(key) + " is not a keyword of VTK");
    }

    Outcome<Done> scalars(const std::string& name) {
        const std::string type = lower(source_.word());
        std::uint64_t components = 1;
        std::size_t before = source_.at;
        if (const auto input = source_.count())
            components = *input;
        else
            source_.at = before;
        before = source_.at;
        if (lower(source_.word()) == "lookup_table")
            source_.word();
        else
            source_.at = before;
        return store_array(name, components, type);
    }

    Outcome<Done> store_array(const std::string& name, std::uint64_t components, const std::string& type) {
        auto result = source_.numbers(type, rows_, components);
        if (!result) return fail(std::move(result.error()));
        add(name, components, std::move(*result));
        return Done{};
    }
    static Outcome<Done> discard(const Outcome<vtu::Numbers>& numbers) {
        if (!numbers) return fail(numbers.error());
        return Done{};
    }

    vtu::DataArray array(std::string name, std::size_t components, vtu::Numbers numbers) const {
        vtu::DataArray result;
        result.name = std::move(name);
        result.components = components;
        result.at = source_.keyword;
        result.numbers = std::make_shared<const vtu::Numbers>(std::move(numbers));
        return result;
    }
    void add(const std::string& name, std::size_t components, vtu::Numbers numbers) {
        if (owner_ == Owner::whole) {
            ++file_.field_data_arrays;
            return;
        }
        auto& arrays = owner_ == Owner::points ? file_.point_data : file_.cell_data;
        arrays.push_back(array(name, components, std::move(numbers)));
    }

    Source source_;
    vtu::File file_;
    bool has_offsets_ = false, has_grid_ = false;
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
