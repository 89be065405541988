module;
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>
module camber.commands;
import camber.core;
import camber.partition;
import camber.io;
import camber.distributed;
import camber.app_shell;
import :execution;

namespace camber::app {

namespace {

constexpr std::string_view with_pieces = ".pvtu";

/// Example: "wing.3.vtu" for "wing.vtu".
std::string part_name(const std::string& path, std::size_t part, std::string_view ending) {
    return std::filesystem::path(path).replace_extension().string() + "." + std::to_string(part) + std::string(ending);
}

MeshField numbers(std::string_view name, Centring centring, const std::vector<std::uint64_t>& values) {
    MeshField field{std::string(name), centring, FieldKind::scalar, {}};
    const bool fits = std::ranges::all_of(values, [](auto v) { return v < std::numeric_limits<std::int32_t>::max(); });
    const auto from_1 = [&]<class T>(T) {
        Buffer<T> result;
        result.reserve(values.size());
        for (const std::uint64_t v : values) result.push_back(static_cast<T>(v + 1));
        return Column<T>(std::move(result));
    };
    if (fits)
        field.values = from_1(std::int32_t{});
    else
        field.values = from_1(double{});
    return field;
}

struct PieceRows {
    std::vector<std::uint64_t> nodes, cells;
};
/// `own`: global numbers of the rows that the piece refers to; null: they are global already.
template <class Mesh>
PieceRows rows_of(const RowCounts& whole, const MeshPiece<Mesh>& piece, const PartsOfRank<Mesh>* own = nullptr) {
    PieceRows rows;
    const auto add = [&](std::vector<std::uint64_t>& to, const Column<std::uint32_t>& from, auto numbers,
                         std::size_t before) {
        for (const std::uint32_t row : from) to.push_back(before + (own != nullptr ? (own->*numbers)[row] : row));
    };
    using Own = PartsOfRank<Mesh>;
    add(rows.nodes, piece.vertices, &Own::vertices, 0);
    add(rows.nodes, piece.mid_nodes, &Own::mid_nodes, whole.points);
    add(rows.cells, piece.elements, &Own::elements, 0);
    add(rows.cells, piece.facets, &Own::facets, whole.elements);
    add(rows.cells, piece.edges, &Own::edges, whole.elements + whole.facets);
    return rows;
}

template <class T>
Column<T> chosen(const Column<T>& values, const std::vector<std::uint64_t>& rows, std::size_t width) {
    Buffer<T> some;
    some.reserve(rows.size() * width);
    for (const std::uint64_t row : rows)
        for (std::size_t c = 0; c < width; ++c) some.push_back(values[row * width + c]);
    return some;
}

MeshFields fields_of(const MeshFields& whole, const PieceRows& rows, int dimension) {
    std::vector<MeshField> all;
    for (const MeshField& field : whole) {
        const auto width = static_cast<std::size_t>(values_per_vertex(field.kind, dimension));
        const auto& own = field.centring == Centring::node ? rows.nodes : rows.cells;
        all.push_back(
            {field.name, field.centring, field.kind,
             std::visit([&](const auto& values) { return FieldValues(chosen(values, own, width)); }, field.values)});
    }
    all.push_back(numbers(global_nodes, Centring::node, rows.nodes));
    all.push_back(numbers(global_cells, Centring::cell, rows.cells));
    return MeshFields(std::move(all));
}

MeshField partition_field(const CellParts& parts) {
    std::vector<std::uint64_t> of_cells;
    for (const auto* const kind : {&parts.elements, &parts.facets, &parts.edges})
        for (const std::int32_t part : *kind) of_cells.push_back(static_cast<std::uint64_t>(part));
    return numbers("partition", Centring::cell, of_cells);
}

struct Writer {
    const MeshFormat& format;
    EncodeOptions options;
    const std::string& path;
    Written& written;
    const Execution& execution;

    Outcome<Done> write(const AnyMesh& mesh, const MeshFields& fields, const std::string& to) const {
        MeshFields supported;
        for (const MeshField& field : fields)
            if (format.has_fields && (!format.can_store || format.can_store(field)))
                supported = std::move(supported).with(field);
        return written.add(to, write_mesh(format, mesh, supported, options, to, execution));
    }

    Outcome<Done> write_list(const std::vector<std::string>& pieces) const {
        const auto first = read_file(pieces.front());
        if (!first) return fail(first.error());
        std::vector<std::string> names;
        names.reserve(pieces.size());
        for (const std::string& piece : pieces) names.push_back(std::filesystem::path(piece).filename().string());
        const auto text = encode_pvtu(*first, names);
        if (!text) return fail(text.error());
        return written.add(path, write_text(path, *text));
    }

    template <class Simplices>
    Outcome<Done> write_parts(const Simplices& mesh, const MeshFields& of_mesh, std::size_t count) const {
        const Mesh<Simplices::dimension> whole = as_mesh(mesh);
        const auto linear = straight_simplices(whole);
        const auto parts = partition(linear, count, execution);
        if (!parts) return fail(parts.error());
        const MeshFields fields = of_mesh.with(partition_field(*parts));
        const RowCounts counts{linear.points.size(), linear.elements.size(), linear.facets.size(), linear.edges.size()};
        const bool listed = names_its_pieces(path);
        if (!listed)
            if (auto done = write(whole, fields, path); !done) return done;
        const std::string ending = listed ? ".vtu" : std::filesystem::path(path).extension().string();
        std::vector<std::string> pieces;
        for (std::size_t p = 0; p < count; ++p) {
            const auto piece = piece_of(mesh, *parts, static_cast<std::int32_t>(p), execution);
            if (!piece) return fail(piece.error());
            pieces.push_back(part_name(path, p + 1, ending));
            auto done = write(as_mesh(piece->mesh), fields_of(fields, rows_of(counts, *piece), Simplices::dimension),
                              pieces.back());
            if (!done) return done;
        }
        return listed ? write_list(pieces) : Outcome<Done>(Done{});
    }
};

template <class Mesh>
Outcome<Done> write_own_parts(const Writer& writer, const RowCounts& whole, const PartsOfRank<Mesh>& own,
                              const std::vector<std::string>& names) {
    const CellParts parts{own.part_of_element, own.part_of_facet, own.part_of_edge};
    for (std::size_t p = own.first; p < own.last; ++p) {
        const auto piece = piece_of(own.mesh, parts, static_cast<std::int32_t>(p), writer.execution);
        if (!piece) return fail(piece.error());
        const PieceRows part_rows = rows_of(whole, *piece, &own);
        MeshFields fields = MeshFields().with(
            numbers("partition", Centring::cell, std::vector<std::uint64_t>(part_rows.cells.size(), p)));
        fields = std::move(fields).with(numbers(global_nodes, Centring::node, part_rows.nodes));
        fields = std::move(fields).with(numbers(global_cells, Centring::cell, part_rows.cells));
        if (auto done = writer.write(as_mesh(piece->mesh), fields, names[p]); !done) return done;
    }
    return Done{};
}

template <int D>
Outcome<std::vector<std::string>> convert_on_ranks(const Host& host, const std::string& input, int degree,
                                                   const PartedOutput& output, const Execution& execution) {
    Ranks& ranks = *host.ranks;
    const std::size_t parts = output.parts;
    if (degree == 1) {
        const auto opened = agreed(ranks, mapped<D>(input));
        if (!opened) return fail(opened.error());
        const auto own = parts_of_rows<D>(*opened->rows, parts, host.partition, ranks);
        if (!own) return fail(own.error());
        return write_parts_of_ranks(ranks, opened->rows->counts(), *own, output, execution);
    }
    const auto rows = mapped_quadratic<D>(input, ranks);
    if (!rows) return fail(rows.error());
    const auto own = parts_of_quadratic_rows<D>(**rows, parts, host.partition, ranks, execution);
    if (!own) return fail(own.error());
    return write_parts_of_ranks(ranks, (*rows)->counts(), *own, output, execution);
}

}  // namespace

bool names_its_pieces(const std::string& path) { return path.ends_with(with_pieces); }

Outcome<Done> missing_partition_error(const std::string& path) {
    return fail(ErrorKind::usage, "lists pieces in other files, but the number of pieces is missing", path, {},
                "give the number: --partition N");
}

Outcome<const MeshFormat*> format_of_parts(const std::string& path, const std::string& name) {
    if (path == standard_stream)
        return fail(ErrorKind::usage, "is one stream, but parts are several files", called_output(path), {},
                    "name a file");
    return names_its_pieces(path) ? format_of_mesh(path, name.empty() ? "vtu" : name) : format_of_mesh(path, name);
}

Outcome<Done> write_in_parts(const MeshFormat& format, const DecodedMesh& mesh, const PartedOutput& output,
                             Written& written, const Execution& execution) {
    const Writer writer{format, output.options, output.path, written, execution};
    return std::visit(
        [&](const auto& m) {
            return on_simplices(m, [&](const auto& of) { return writer.write_parts(of, mesh.fields, output.parts); });
        },
        mesh.mesh);
}

template <class Mesh>
Outcome<std::vector<std::string>> write_parts_of_ranks(Ranks& ranks, const RowCounts& whole,
                                                       const PartsOfRank<Mesh>& own, const PartedOutput& output,
                                                       const Execution& execution) {
    const auto& [path, parts, options] = output;
    const auto format = format_of_parts(path, {});
    if (!format) return fail(format.error());
    Written written;
    const Writer writer{**format, options, path, written, execution};
    std::vector<std::string> names;
    names.reserve(parts);
    for (std::size_t p = 0; p < parts; ++p) names.push_back(part_name(path, p + 1, ".vtu"));
    if (auto all = agreed(ranks, write_own_parts(writer, whole, own, names)); !all) return fail(all.error());
    const bool has_first = own.first == 0 && own.last > 0;
    auto listed = agreed(ranks, has_first ? writer.write_list(names) : Outcome<Done>(Done{}));
    if (!listed) return fail(listed.error());
    return names;
}

Outcome<std::vector<std::string>> write_in_parts_on_ranks(const Host& host, const std::string& input,
                                                          const PartedOutput& output, const Execution& execution) {
    if (!host.partition) return fail(ErrorKind::internal, "no graph partitioner for several ranks");
    return together(*host.ranks, [&]() -> Outcome<std::vector<std::string>> {
        const auto shape = agreed(*host.ranks, shape_of_file(input));
        if (!shape) return fail(shape.error());
        return shape->dimension == 3 ? convert_on_ranks<3>(host, input, shape->degree, output, execution)
                                     : convert_on_ranks<2>(host, input, shape->degree, output, execution);
    });
}

#define CAMBER_INSTANTIATE(MESH)                                           \
    template Outcome<std::vector<std::string>> write_parts_of_ranks<MESH>( \
        Ranks&, const RowCounts&, const PartsOfRank<MESH>&, const PartedOutput&, const Execution&);

CAMBER_INSTANTIATE(LinearMesh<2>)
CAMBER_INSTANTIATE(LinearMesh<3>)
CAMBER_INSTANTIATE(QuadraticMesh<2>)
CAMBER_INSTANTIATE(QuadraticMesh<3>)
#undef CAMBER_INSTANTIATE

namespace {

Outcome<SharedFile> opened(Ranks& ranks, const std::string& path, std::uint64_t bytes, const Outcome<Done>& can_begin) {
    std::optional<Outcome<SharedFile>> first;
    Outcome<std::string> draft = std::string();
    if (!can_begin) draft = fail(can_begin.error());
    if (can_begin && ranks.rank() == 0) {
        first = SharedFile::make(path, bytes);
        draft = *first ? Outcome<std::string>((*first)->draft()) : fail(first->error());
    }
    draft = broadcast_from_first(ranks, draft);
    if (!draft) return fail(std::move(draft.error()));
    return first ? std::move(*first) : SharedFile::join(path, *draft);
}

Outcome<Done> put(const Outcome<SharedFile>& file, std::span<const FilePiece> pieces, const Execution& execution) {
    if (!file) return fail(file.error());
    for (const FilePiece& piece : pieces)
        if (auto written = file->write(piece.offset, piece.bytes, execution); !written) return written;
    return Done{};
}

Outcome<Done> finished(Ranks& ranks, Outcome<SharedFile>& file, const Outcome<Done>& written) {
    if (auto all = agreed(ranks, written ? file->flush() : written); !all) return all;
    return agreed(ranks, ranks.rank() == 0 ? file->publish() : Outcome<Done>(Done{}));
}

}  // namespace

Outcome<Done> write_together(Ranks& ranks, const std::string& path, std::uint64_t bytes,
                             const Outcome<std::span<const FilePiece>>& pieces, const Execution& execution) {
    auto file = opened(ranks, path, bytes, pieces ? Outcome<Done>(Done{}) : fail(pieces.error()));
    if (!file) return fail(file.error());
    return finished(ranks, file, put(file, *pieces, execution));
}

Outcome<Done> write_together(Ranks& ranks, const std::string& path, std::uint64_t bytes, std::size_t turns,
                             const std::function<Outcome<std::vector<FilePiece>>(std::size_t)>& pieces_of,
                             const Execution& execution) {
    auto file = opened(ranks, path, bytes, Done{});
    if (!file) return fail(file.error());
    Outcome<Done> written{Done{}};
    for (std::size_t turn = 0; turn < turns && written; ++turn) {
        const auto pieces = pieces_of(turn);
        written = pieces ? put(file, *pieces, execution) : fail(pieces.error());
        report_progress(execution, turn + 1, turns);
    }
    return finished(ranks, file, written);
}

}  // namespace camber::app
