// Reads meshes from SU2 files.
module;
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>
module camber.io;
import camber.core;
import camber.bezier;

namespace camber {

namespace su2 {

namespace {

struct Shape {
    std::int64_t type;
    std::size_t nodes;
    const char* plural;
};
constexpr std::array shapes{Shape{1, 1, "points"},         Shape{3, 2, "lines"},       Shape{5, 3, "triangles"},
                            Shape{9, 4, "quadrilaterals"}, Shape{10, 4, "tetrahedra"}, Shape{12, 8, "hexahedra"},
                            Shape{13, 6, "prisms"},        Shape{14, 5, "pyramids"}};

template <int K>
constexpr std::int64_t type_of = K == 1   ? 3
                                 : K == 2 ? 5
                                          : 10;

std::string row_place(const Zone& zone, Lines lines, std::size_t row) {
    std::optional<std::string_view> line;
    for (std::size_t i = 0; i <= row; ++i) line = lines.next();
    return line ? zone.place(*line) : zone.name;
}

struct PointRange {
    std::size_t first = 0, count = 0;
};

template <int K>
Outcome<Done> read_simplices(const Zone& zone, const Block& block, PointRange points, Reference reference,
                             listing::Rows<K + 1>& into, UnsupportedItems& refused) {
    Lines lines = block.rows;
    for (std::size_t i = 0; i < block.count; ++i) {
        const std::string_view line = *lines.next();
        const auto bad_row = [&](const std::string& what) {
            return fail(ErrorKind::input, what, zone.place(line), Entity{into.origin.noun, i + 1}, damaged);
        };
        Words words{line.data(), line.data() + line.size()};
        std::int64_t type = 0;
        if (!read_number(words, type)) return bad_row("its type is missing or malformed");
        const Shape* shape = nullptr;
        for (const Shape& known : shapes)
            if (known.type == type) shape = &known;
        if (!shape) {
            refused.count("elements of type " + std::to_string(type));
            continue;
        }
        std::array<std::int64_t, 9> nodes{};
        std::size_t read = 0;
        for (; words.find() && read <= shape->nodes; ++read)
            if (!read_number(words, nodes[read])) return bad_row("a number is malformed");
        if (read < shape->nodes || words.find()) return bad_row("its row does not have the numbers of its type");
        if (type != type_of<K>) {
            refused.count(shape->plural);
            continue;
        }
        std::array<VertexId, K + 1> simplex;
        for (std::size_t n = 0; n <= K; ++n)
            if (nodes[n] >= 0 && std::cmp_less(nodes[n], points.count))
                simplex[n] = VertexId(points.first + static_cast<std::size_t>(nodes[n]));
        into.nodes.push_back(simplex);
        into.references.push_back(reference);
    }
    return Done{};
}

/// Reads D coordinates of each point. Up to three more numbers in a row are ignored, as in SU2: a third coordinate in
/// 2D, an index, a global index of a partitioned mesh. `heights` counts ignored numbers that are neither whole nor
/// zero.
template <int D>
Outcome<Done> read_points(const Zone& zone, const Block& block, Buffer<Vec<D>>& points, std::size_t& heights) {
    constexpr std::size_t most = 3;
    Lines lines = block.rows;
    for (std::size_t i = 0; i < block.count; ++i) {
        const std::string_view line = *lines.next();
        Words words{line.data(), line.data() + line.size()};
        Vec<D> point;
        bool sound = true;
        for (int c = 0; c < D && sound; ++c) sound = read_number(words, point[c]);
        for (std::size_t n = 0; sound && words.find(); ++n) {
            const char* const begin = words.at;
            double more = 0;
            sound = n < most && read_number(words, more);
            const bool whole = std::all_of(begin, words.at, [](char c) { return c >= '0' && c <= '9'; });
            heights += !whole && more != 0 ? 1 : 0;
        }
        if (!sound)
            return fail(ErrorKind::input,
                        "its row does not have " + std::to_string(D) + " coordinates and optional indices",
                        zone.place(line), Entity{"vertex", i + 1}, damaged);
        points.push_back(point);
    }
    return Done{};
}

template <int D>
struct MarkerReferences {
    Buffer<Group>& groups;
    std::map<std::string, Reference> known = {};

    Reference of(const std::string& tag) {
        const auto next = static_cast<Reference>(groups.size() + 1);
        const auto [place, is_new] = known.try_emplace(tag, next);
        if (is_new) groups.push_back({D - 1, next, tag});
        return place->second;
    }
};

using Zones = std::vector<const Zone*>;

/// These functions return a function that finds, for error messages, the line of an element or facet. Elements are
/// numbered by zone, facets by zone and then by marker.
auto place_of_elements(const Zones& zones) {
    return [zones](std::size_t row) {
        for (const Zone* const zone : zones) {
            if (row < zone->elements->count) return row_place(*zone, zone->elements->rows, row);
            row -= zone->elements->count;
        }
        return zones.front()->name;
    };
}
auto place_of_facets(const Zones& zones) {
    return [zones](std::size_t row) {
        for (const Zone* const zone : zones)
            for (const Block& marker : zone->markers) {
                if (row < marker.count) return row_place(*zone, marker.rows, row);
                row -= marker.count;
            }
        return zones.front()->name;
    };
}

template <int D>
Outcome<DecodedMesh> read_mesh(const Zones& zones, std::vector<Notice> notices, UnsupportedCells unsupported_cells,
                               const Execution& execution) {
    listing::Mesh<D> mesh;
    mesh.name = zones.front()->name;
    mesh.elements.straight.origin = {simplex_name<D>, {}, place_of_elements(zones)};
    mesh.facets.straight.origin = {simplex_name<D - 1>, {}, place_of_facets(zones)};
    UnsupportedItems refused;
    MarkerReferences<D> references{mesh.groups};
    std::size_t heights = 0;
    for (const Zone* const zone : zones) {
        const PointRange range{mesh.points.size(), zone->points->count};
        const auto reference = static_cast<Reference>(zones.size() > 1 ? zone->number : 0);
        auto done = read_simplices<D>(*zone, *zone->elements, range, reference, mesh.elements.straight, refused);
        for (const Block& marker : zone->markers)
            if (done)
                done = read_simplices<D - 1>(*zone, marker, range, references.of(marker.tag), mesh.facets.straight,
                                             refused);
        if (done) done = read_points<D>(*zone, *zone->points, mesh.points, heights);
        if (!done) return fail(std::move(done.error()));
    }
    if (auto supported = refused.verdict(mesh.name, unsupported_cells); !supported)
        return fail(std::move(supported.error()));
    if (heights > 0)
        notices.push_back(
            {std::to_string(heights) + " third coordinates were left out: NDIME is " + std::to_string(D)});
    mesh.point_references = Buffer<Reference>(mesh.points.size(), 0);
    if (auto checked = listing::check(mesh, execution); !checked) return fail(std::move(checked.error()));
    auto decoded = listing::assembled(std::move(mesh), listing::MidNodeKind::on_curve, std::move(notices), execution);
    if (decoded) decoded->unsupported_cells = refused.counts();
    return decoded;
}

void note_losses(const Zone& zone, std::vector<Notice>& notices) {
    if (!zone.markers_announced)  // Gmsh omits NMARK if there are no groups, but the file may also be truncated
        notices.push_back({"the file has no NMARK, so it has no markers of the boundary"});
    if (zone.parallel_markers > 0)
        notices.push_back({std::to_string(zone.parallel_markers) + " markers SEND_RECEIVE were left out"});
    if (zone.foreign_blocks == 0) return;
    std::string first = zone.first_foreign;
    for (char& c : first)  // damaged files must not send control characters to a terminal
        if (c < ' ' || c > '~') c = '?';
    notices.push_back(
        {std::to_string(zone.foreign_blocks) + " other keywords were left out, the first of them " + first});
}

Outcome<Zones> chosen(const File& file, const std::string& requested) {
    Zones zones;
    std::string numbers;
    for (const Zone& zone : file.zones) {
        const std::string number = std::to_string(zone.number);
        numbers += (numbers.empty() ? "" : ", ") + number;
        if (requested.empty() || requested == number) zones.push_back(&zone);
    }
    if (!zones.empty()) return zones;
    return fail(ErrorKind::input, "has no zone " + in_quotes(requested), file.zones.front().name, {},
                "its zones are " + numbers);
}

Outcome<DecodedMesh> read(std::string_view text, std::string_view name, const DecodeOptions& options,
                          const Execution& execution) {
    const auto file = find_blocks(text, name);
    if (!file) return fail(file.error());
    const auto zones = chosen(*file, options.zone);
    if (!zones) return fail(zones.error());
    std::vector<Notice> notices;
    if (!file->ended) notices.push_back({"the last line has no line end, so it may be incomplete"});
    if (zones->size() > 1)
        notices.push_back({std::to_string(zones->size()) +
                           " zones were joined into one mesh: the references of its elements are their numbers"});
    for (const Zone* const zone : *zones) note_losses(*zone, notices);
    const std::int64_t dimension = *zones->front()->dimension;
    for (const Zone* const zone : *zones)
        if (*zone->dimension != dimension)
            return fail(ErrorKind::unsupported, "its zones are of different dimensions", std::string(name), {},
                        "choose one: camber convert FILE -o OUT --zone 1");
    if (dimension == 2) return read_mesh<2>(*zones, std::move(notices), options.unsupported_cells, execution);
    if (dimension == 3) return read_mesh<3>(*zones, std::move(notices), options.unsupported_cells, execution);
    return fail(ErrorKind::input, "NDIME is " + std::to_string(dimension) + ", not 2 or 3", std::string(name), {},
                damaged);
}

}  // namespace

}  // namespace su2

Outcome<DecodedMesh> decode_su2(std::span<const std::byte> bytes, std::string_view name, const DecodeOptions& options,
                                const Execution& execution) {
    return guarded([&] { return su2::read(su2::text_of(bytes), name, options, execution); });
}

bool is_su2(std::span<const std::byte> bytes) {
    constexpr std::size_t soon = 65536;  // number of bytes, because comments may precede the first keyword
    const auto line = su2::Lines(su2::text_of(bytes.first(bytes.size() < soon ? bytes.size() : soon))).next();
    if (!line) return false;
    const std::string_view key = su2::entry_of(*line).key;
    for (const std::string_view first : {"NDIME", "NZONE", "NELEM", "NPOIN", "NMARK"})
        if (key == first) return true;
    return false;
}

}  // namespace camber
