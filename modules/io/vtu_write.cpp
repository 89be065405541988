// Writes VTU files: appended arrays and their XML.
module;
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <iterator>
#include <limits>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber::vtu {

namespace {

/// Size of a block before compression. Blocks of this size compress well, and there are enough of them for all threads.
/// It is a multiple of the size of each number type.
constexpr std::size_t block_bytes = std::size_t{1} << 17U;
/// Level 1 of zlib, because mantissas hardly compress: on curved meshes with fields the default level takes twice the
/// time and saves 1 %.
constexpr int compression_level = 1;

Buffer<std::byte> compressed(std::span<const std::byte> bytes) {
    uLongf size = compressBound(static_cast<uLong>(bytes.size()));
    Buffer<std::byte> out(size);
    // `out` has the maximum size, so the only possible failure is lack of memory.
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
    auto result = map_each(
        execution_, blocks,
        [&](std::size_t b) {
            const std::size_t first = b * in_block, last = std::min(n, first + in_block);
            Buffer<std::byte> raw((last - first) * size);
            fill(first, last, raw.data());
            return compressed(raw);
        },
        1);
    if (!result) return fail(std::move(result.error()));

    std::vector<std::uint64_t> header{blocks, block_bytes, n * size % block_bytes};
    header.reserve(3 + blocks);
    std::transform(result->begin(), result->end(), std::back_inserter(header),
                   [](const Buffer<std::byte>& block) { return std::uint64_t{block.size()}; });
    Buffer<std::byte> head(header.size() * sizeof(std::uint64_t));
    std::memcpy(head.data(), header.data(), head.size());

    std::string xml = data_array(type, name, bytes_);
    chunks_.reserve(chunks_.size() + blocks + 1);
    bytes_ += head.size();
    chunks_.push_back(std::move(head));
    for (Buffer<std::byte>& block : *result) {
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

namespace camber {

namespace vtu {

Components components_of(FieldKind kind, int dimension) {
    const bool plane = dimension == 2;
    const std::vector<std::string> axes{"X", "Y", "Z"};
    switch (kind) {
        case FieldKind::scalar: return {{}, {0}};
        case FieldKind::vector: return {axes, plane ? std::vector{0, 1, -1} : std::vector{0, 1, 2}};
        case FieldKind::symmetric_tensor:
            return {{"XX", "YY", "ZZ", "XY", "YZ", "XZ"},
                    plane ? std::vector{0, 2, -1, 1, -1, -1} : std::vector{0, 2, 5, 1, 4, 3}};
        case FieldKind::full_tensor:
            return {{"XX", "XY", "XZ", "YX", "YY", "YZ", "ZX", "ZY", "ZZ"},
                    plane ? std::vector{0, 1, -1, 2, 3, -1, -1, -1, -1} : std::vector{0, 1, 2, 3, 4, 5, 6, 7, 8}};
    }
    return {};
}

namespace {

template <int K>
constexpr int dimension_of(const Simplices<K>&) {
    return K;
}

template <int K>
constexpr std::uint8_t cell_type(int degree, VtuCells cells) {
    constexpr std::array<std::uint8_t, 3> linear{3, 5, 10}, quadratic{21, 22, 24}, lagrange{68, 69, 71};
    if (degree == 1) return linear[K - 1];
    return cells == VtuCells::quadratic ? quadratic[K - 1] : lagrange[K - 1];
}

template <class Mesh>
class Writer {
  public:
    static constexpr int D = Mesh::dimension;

    Writer(const Mesh& mesh, const MeshFields& fields, VtuOptions options, const Execution& execution)
        : grid_{mesh}, linear_(grid_.linear()), fields_(fields), options_(options), arrays_(execution) {}

    Outcome<Chunks> write() && {
        if (!columns_fit(linear_) || !grid_.is_sound())
            return fail(ErrorKind::internal, "the columns of the mesh have inconsistent lengths");
        if (auto fits = check_rows<D>(fields_, grid_.nodes(), cells_of(linear_)); !fits)
            return fail(std::move(fits.error()));
        std::string xml = begin();
        for (auto part : {&Writer::point_data, &Writer::cell_data, &Writer::points, &Writer::cells}) {
            auto result = (this->*part)();
            if (!result) return fail(std::move(result.error()));
            xml += *result;
        }
        return std::move(arrays_).finish(xml + "</Piece>\n</UnstructuredGrid>\n");
    }

  private:
    [[nodiscard]] std::size_t rows(Centring centring) const {
        return centring == Centring::node ? grid_.nodes() : cells_of(linear_);
    }

    [[nodiscard]] std::string begin() const {
        return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"" +
               std::string(own_byte_order) +
               "\" header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n"
               "<Piece NumberOfPoints=\"" +
               std::to_string(grid_.nodes()) + "\" NumberOfCells=\"" + std::to_string(cells_of(linear_)) + "\">\n";
    }

    Outcome<std::string> point_data() {
        return arrays_
            .add<std::int32_t>({"reference"}, grid_.nodes(), [&](std::size_t n) { return grid_.reference(n); })
            .and_then([&](const std::string& xml) { return data("PointData", xml, Centring::node); });
    }

    Outcome<std::string> cell_data() {
        const std::size_t n = cells_of(linear_);
        auto references = arrays_.add<std::int32_t>({"reference"}, n, [&](std::size_t c) {
            return at_cell(linear_, c, [](const auto& simplices, std::size_t s) { return simplices.references[s]; });
        });
        if (!references) return references;
        auto dimensions = arrays_.add<std::uint8_t>({"dimension"}, n, [&](std::size_t c) {
            return at_cell(linear_, c, [](const auto& simplices, std::size_t) {
                return static_cast<std::uint8_t>(dimension_of(simplices));
            });
        });
        if (!dimensions) return dimensions;
        auto entities = this->entities();
        if (!entities) return entities;
        return data("CellData", *references + *dimensions + *entities, Centring::cell);
    }

    Outcome<std::string> entities() {
        const auto known = [](const auto& simplices) {
            return std::any_of(simplices.entities.begin(), simplices.entities.end(),
                               [](Reference e) { return e != 0; });
        };
        if (!known(linear_.elements) && !known(linear_.facets) && !known(linear_.edges)) return std::string();
        return arrays_.add<std::int32_t>({"entity"}, cells_of(linear_), [&](std::size_t c) {
            return at_cell(linear_, c, [](const auto& simplices, std::size_t s) {
                return simplices.entities.empty() ? 0 : simplices.entities[s];
            });
        });
    }

    Outcome<std::string> data(const std::string& tag, std::string xml, Centring centring) {
        for (const MeshField& field : fields_) {
            if (field.centring != centring) continue;
            auto result = std::visit([&](const auto& values) { return array_of(field, values); }, field.values);
            if (!result) return result;
            xml += *result;
        }
        const bool numbered = centring == Centring::node && fields_.find(global_nodes, centring) != nullptr;
        const std::string ids = numbered ? " GlobalIds=\"" + std::string(global_nodes) + "\"" : std::string();
        return "<" + tag + " Scalars=\"reference\"" + ids + ">\n" + xml + "</" + tag + ">\n";
    }

    template <class T>
    Outcome<std::string> array_of(const MeshField& field, const Column<T>& values) {
        if (field.kind == FieldKind::scalar && (field.name == global_nodes || field.name == global_cells))
            return arrays_.add<std::int64_t>({field.name}, rows(field.centring),
                                             [&](std::size_t i) { return static_cast<std::int64_t>(values[i]); });
        const Components components = components_of(field.kind, D);
        const auto width = static_cast<std::size_t>(values_per_vertex(field.kind, D));
        const std::size_t wide = components.sources.size();
        return arrays_.add<T>({field.name, components.names}, rows(field.centring) * wide, [&](std::size_t i) {
            const int source = components.sources[i % wide];
            return source < 0 ? T{} : values[i / wide * width + static_cast<std::size_t>(source)];
        });
    }

    Outcome<std::string> points() {
        return arrays_
            .add<double>({"Points", {"X", "Y", "Z"}}, 3 * grid_.nodes(),
                         [&](std::size_t i) { return i % 3 < D ? grid_.point(i / 3)[i % 3] : 0.0; })
            .map([](const std::string& xml) { return "<Points>\n" + xml + "</Points>\n"; });
    }

    Outcome<std::string> cells() {
        const std::size_t most = std::numeric_limits<std::int32_t>::max();
        return grid_.nodes() <= most && connectivity_size() <= most ? cells<std::int32_t>() : cells<std::int64_t>();
    }

    /// Positions in the array `connectivity` at which elements, facets and feature edges begin, and the size of the
    /// array.
    [[nodiscard]] std::array<std::size_t, 4> starts() const {
        using G = Grid<Mesh>;
        const std::size_t facets = linear_.elements.size() * G::template width<D>;
        const std::size_t edges = facets + linear_.facets.size() * G::template width<D - 1>;
        return {0, facets, edges, edges + linear_.edges.size() * G::template width<1>};
    }
    [[nodiscard]] std::size_t connectivity_size() const { return starts()[3]; }

    template <class T>
    Outcome<std::string> cells() {
        using G = Grid<Mesh>;
        const auto start = starts();
        const auto entry = [&]<int K>(const Simplices<K>& simplices, std::size_t i) {
            constexpr std::size_t wide = G::template width<K>;
            return static_cast<T>(grid_.template node<K>(simplices, i / wide, i % wide));
        };
        auto connectivity = arrays_.add<T>({"connectivity"}, start[3], [&](std::size_t i) {
            if (i < start[1]) return entry(linear_.elements, i);
            if constexpr (D == 3)
                if (i >= start[2]) return entry(linear_.edges, i - start[2]);
            return entry(linear_.facets, i - start[1]);
        });
        if (!connectivity) return connectivity;
        const std::size_t elements = linear_.elements.size(), facets = linear_.facets.size();
        auto offsets = arrays_.add<T>({"offsets"}, cells_of(linear_), [&](std::size_t c) {
            if (c < elements) return static_cast<T>((c + 1) * G::template width<D>);
            if (c < elements + facets) return static_cast<T>(start[1] + (c + 1 - elements) * G::template width<D - 1>);
            return static_cast<T>(start[2] + (c + 1 - elements - facets) * G::template width<1>);
        });
        if (!offsets) return offsets;
        auto types = arrays_.add<std::uint8_t>({"types"}, cells_of(linear_), [&](std::size_t c) {
            return at_cell(linear_, c, [&]<int K>(const Simplices<K>&, std::size_t) {
                return cell_type<K>(G::degree, options_.cells);
            });
        });
        if (!types) return types;
        return "<Cells>\n" + *connectivity + *offsets + *types + "</Cells>\n";
    }

    Grid<Mesh> grid_;
    const LinearMesh<D>& linear_;
    const MeshFields& fields_;
    VtuOptions options_;
    AppendedArrays arrays_;
};

}  // namespace

}  // namespace vtu

template <int D>
Outcome<Chunks> encode_vtu(const Mesh<D>& mesh, const MeshFields& fields, VtuOptions options,
                           const Execution& execution) {
    return on_simplices(mesh, [&](const auto& simplices) {
        return gmf::guarded([&] {
            return vtu::Writer(simplices, with_legal_names(fields, vtu::field_names()), options, execution).write();
        });
    });
}

#define CAMBER_INSTANTIATE(D) \
    template Outcome<Chunks> encode_vtu<D>(const Mesh<D>&, const MeshFields&, VtuOptions, const Execution&);

CAMBER_INSTANTIATE(2)
CAMBER_INSTANTIATE(3)
#undef CAMBER_INSTANTIATE

}  // namespace camber
