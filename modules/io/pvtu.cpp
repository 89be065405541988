module;
#include <pugixml.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>
module camber.io;
import camber.core;

namespace camber {

namespace vtu {

namespace {

Outcome<std::vector<std::string>> sources_of(std::span<const std::byte> bytes, const std::string& name) {
    constexpr const char* damaged = "it is cut off, or is not a PVTU file";
    pugi::xml_document document;
    const auto result = document.load_buffer(bytes.data(), bytes.size(), pugi::parse_default, pugi::encoding_utf8);
    if (result.status == pugi::status_out_of_memory) throw std::bad_alloc();
    if (!result)
        return fail(ErrorKind::input, std::string("the XML is damaged: ") + result.description(), name, {}, damaged);
    std::vector<std::string> sources;
    for (const pugi::xml_node& piece : document.child("VTKFile").child("PUnstructuredGrid").children("Piece"))
        sources.emplace_back(piece.attribute("Source").as_string());
    if (sources.empty() || std::ranges::find(sources, "") != sources.end())
        return fail(ErrorKind::input, "lists no pieces, or a piece without its Source", name, {}, damaged);
    return sources;
}

template <class T>
void append(Buffer<T>& to, const Buffer<T>& from) {
    to.insert(to.end(), from.begin(), from.end());
}

template <int N>
void append(listing::Rows<N>& to, const listing::Rows<N>& from, std::size_t before) {
    if (!from.entities.empty() || !to.entities.empty()) {
        to.entities.resize(to.size(), 0);
        append(to.entities, from.entities);
        to.entities.resize(to.size() + from.size(), 0);
    }
    for (auto nodes : from.nodes) {
        for (VertexId& v : nodes) v = VertexId(v.index() + before);
        to.nodes.push_back(nodes);
    }
    append(to.references, from.references);
}

std::vector<std::size_t> cell_ends(const listing::Mesh<3>& mesh) {
    std::vector<std::size_t> ends;
    const auto add = [&](const auto& kind) {
        for (const std::size_t size : {kind.curved.size(), kind.straight.size()})
            ends.push_back((ends.empty() ? 0 : ends.back()) + size);
    };
    add(mesh.elements);
    add(mesh.facets);
    add(mesh.edges);
    return ends;
}

using Pieces = std::vector<listing::Mesh<3>>;

template <class T>
Column<T> joined_rows(const Pieces& pieces, const std::vector<const MeshField*>& fields, std::size_t width) {
    Buffer<T> rows;
    const auto add = [&](const MeshField& field, std::size_t begin, std::size_t end) {
        std::visit(
            [&](const auto& values) {
                for (std::size_t i = begin * width; i < end * width; ++i) rows.push_back(static_cast<T>(values[i]));
            },
            field.values);
    };
    if (fields.front()->centring == Centring::node) {
        for (std::size_t p = 0; p < pieces.size(); ++p) add(*fields[p], 0, pieces[p].points.size());
        return rows;
    }
    for (std::size_t kind = 0; kind < Cells::kinds; ++kind)
        for (std::size_t p = 0; p < pieces.size(); ++p) {
            const auto ends = cell_ends(pieces[p]);
            add(*fields[p], kind == 0 ? 0 : ends[kind - 1], ends[kind]);
        }
    return rows;
}

MeshFields joined_fields(const Pieces& pieces) {
    std::vector<MeshField> all_fields;
    for (const MeshField& field : pieces.front().fields) {
        std::vector<const MeshField*> all;
        for (const auto& piece : pieces) {
            const MeshField* const same = piece.fields.find(field.name, field.centring);
            if (same && same->kind == field.kind) all.push_back(same);
        }
        if (all.size() < pieces.size()) continue;
        const bool whole = std::ranges::all_of(
            all, [](const MeshField* f) { return std::holds_alternative<Column<std::int32_t>>(f->values); });
        const auto width = static_cast<std::size_t>(values_per_vertex(field.kind, 3));
        MeshField joined{field.name, field.centring, field.kind, {}};
        if (whole)
            joined.values = joined_rows<std::int32_t>(pieces, all, width);
        else
            joined.values = joined_rows<double>(pieces, all, width);
        all_fields.push_back(std::move(joined));
    }
    return MeshFields(std::move(all_fields));
}

listing::Mesh<3> concatenated(const Pieces& pieces, const std::string& name) {
    listing::Mesh<3> mesh;
    mesh.name = name;
    const auto add = [](auto& to, const auto& from, std::size_t before) {
        append(to.curved, from.curved, before);
        append(to.straight, from.straight, before);
    };
    for (const auto& piece : pieces) {
        const std::size_t before = mesh.points.size();
        append(mesh.points, piece.points);
        append(mesh.point_references, piece.point_references);
        add(mesh.elements, piece.elements, before);
        add(mesh.facets, piece.facets, before);
        add(mesh.edges, piece.edges, before);
    }
    mesh.fields = joined_fields(pieces);
    return mesh;
}

std::optional<std::vector<double>> numbers_of_nodes(const MeshFields& fields) {
    const MeshField* const field = fields.find(global_nodes, Centring::node);
    if (!field || field->kind != FieldKind::scalar) return std::nullopt;
    return std::visit([](const auto& values) { return std::vector<double>(values.begin(), values.end()); },
                      field->values);
}

Outcome<Done> read_pieces(const std::vector<std::string>& sources, const DecodeOptions& options, Pieces& pieces,
                          std::vector<Notice>& notices, std::vector<CellCount>& unsupported_cells,
                          const Execution& execution) {
    for (const std::string& source : sources) {
        const auto bytes = options.beside(source);
        if (!bytes) return fail(bytes.error());
        const auto file = open_file(*bytes, source);
        if (!file) return fail(file.error());
        auto listed = check_sizes(*file).and_then([&](Done) { return listing_of(*file, options, execution); });
        if (!listed) return fail(std::move(listed.error()));
        pieces.push_back(std::move(listed->mesh));
        for (const CellCount& kind : listed->unsupported_cells) {
            const auto same = std::ranges::find(unsupported_cells, kind.kind, &CellCount::kind);
            if (same == unsupported_cells.end())
                unsupported_cells.push_back(kind);
            else
                same->count += kind.count;
        }
        for (Notice& notice : listed->notices)  // most pieces have the same notices
            if (std::ranges::find(notices, notice.what, &Notice::what) == notices.end())
                notices.push_back(std::move(notice));
    }
    return Done{};
}

Outcome<DecodedMesh> joined(const Pieces& pieces, const std::string& name, std::vector<Notice> notices,
                            const Execution& execution) {
    listing::Mesh<3> mesh = concatenated(pieces, name);
    std::vector<std::size_t> ends;
    for (const auto& piece : pieces) ends.push_back((ends.empty() ? 0 : ends.back()) + piece.points.size());
    if (ends.back() > max_entities)
        return fail(ErrorKind::unsupported, "has more points than 32 bits can number", name);
    const auto numbers = numbers_of_nodes(mesh.fields);
    const std::size_t removed =
        numbers ? listing::join_numbered(mesh, *numbers) : listing::join_coincident(mesh, std::span(ends));
    notices.push_back({std::to_string(pieces.size()) + " pieces were joined into one mesh, at " +
                       std::to_string(removed) + " points" + (numbers ? "" : " at the same places")});
    if (auto sound = listing::check(mesh, execution); !sound) return fail(std::move(sound.error()));
    return listing::assembled(std::move(mesh), listing::MidNodeKind::on_curve, std::move(notices), execution);
}

std::string described(const std::vector<DataArray>& arrays) {
    std::string xml;
    for (const DataArray& array : arrays)
        if (array.name != "entity")  // `entity` may be missing in some pieces
            xml += "<PDataArray type=\"" + array.type + "\" Name=\"" + escaped(array.name) +
                   "\" NumberOfComponents=\"" + std::to_string(array.components) + "\"/>\n";
    return xml;
}

}  // namespace

}  // namespace vtu

Outcome<DecodedMesh> decode_pvtu(std::span<const std::byte> bytes, std::string_view name, const DecodeOptions& options,
                                 const Execution& execution) {
    return guarded([&]() -> Outcome<DecodedMesh> {
        const std::string file(name);
        if (!options.beside)
            return fail(ErrorKind::unsupported, "its pieces are in other files, which cannot be read here", file, {},
                        "join the pieces into one file with camber convert");
        const auto sources = vtu::sources_of(bytes, file);
        if (!sources) return fail(sources.error());
        vtu::Pieces pieces;
        std::vector<Notice> notices;
        std::vector<CellCount> unsupported_cells;
        if (auto read = vtu::read_pieces(*sources, options, pieces, notices, unsupported_cells, execution); !read)
            return fail(std::move(read.error()));
        auto decoded = vtu::joined(pieces, file, std::move(notices), execution);
        if (decoded) decoded->unsupported_cells = std::move(unsupported_cells);
        return decoded;
    });
}

bool is_pvtu(std::span<const std::byte> bytes) { return vtu::type_of_file(bytes) == "PUnstructuredGrid"; }

Outcome<std::string> encode_pvtu(std::span<const std::byte> first, std::span<const std::string> names) {
    return guarded([&]() -> Outcome<std::string> {
        const auto file = vtu::open_file(first, "the piece");
        if (!file) return fail(file.error());
        const bool numbered =
            std::ranges::find(file->point_data, global_nodes, &vtu::DataArray::name) != file->point_data.end();
        std::string xml = "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"" +
                          std::string(vtu::own_byte_order) + "\" header_type=\"UInt64\">\n" +
                          "<PUnstructuredGrid GhostLevel=\"0\">\n<PPointData Scalars=\"reference\"" +
                          (numbered ? " GlobalIds=\"" + std::string(global_nodes) + "\"" : std::string()) + ">\n" +
                          vtu::described(file->point_data) + "</PPointData>\n<PCellData Scalars=\"reference\">\n" +
                          vtu::described(file->cell_data) + "</PCellData>\n<PPoints>\n" +
                          vtu::described(file->point_arrays) + "</PPoints>\n";
        for (const std::string& name : names) xml += "<Piece Source=\"" + vtu::escaped(name) + "\"/>\n";
        return xml + "</PUnstructuredGrid>\n</VTKFile>\n";
    });
}

}  // namespace camber
