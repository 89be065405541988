module;
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

constexpr const char* damaged = "the file is cut off or damaged";

std::string_view text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The lines of a text that say something, without comments (% to the end of the line) and blanks at their ends.
class Lines {
  public:
    explicit Lines(std::string_view text) : rest_(text) {}

    /// The next; none at the end.
    std::optional<std::string_view> next() {
        while (!rest_.empty()) {
            const std::size_t end = rest_.find('\n');
            std::string_view line = rest_.substr(0, end);
            ended_ = end != std::string_view::npos;
            rest_.remove_prefix(ended_ ? end + 1 : rest_.size());
            line = line.substr(0, line.find('%'));
            while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
            while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
            if (!line.empty()) return line;
        }
        return std::nullopt;
    }
    [[nodiscard]] std::size_t left() const { return rest_.size(); }
    [[nodiscard]] bool ended() const { return ended_; }  ///< the last line by a line break

  private:
    std::string_view rest_;
    bool ended_ = true;
};

/// `KEY= value`; no key: a row.
struct Entry {
    std::string_view key = {}, value = {};
};
Entry entry_of(std::string_view line) {
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) return {};
    Words key{line.data(), line.data() + equals}, value{line.data() + equals + 1, line.data() + line.size()};
    const std::string_view name = key.next();
    if (name != "MARKER_TAG") return {name, value.next()};
    // A name is the rest of the line, whatever is in it.
    std::string_view rest = line.substr(equals + 1);
    while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
    return {name, rest};
}

/// Rows that follow a keyword. Nothing of them has been looked at.
struct Block {
    std::size_t count = 0;
    Lines rows{{}};
    std::string tag = {};  ///< of a marker
};

/// What a file holds, block by block.
struct File {
    std::string name;
    std::string_view text;
    std::optional<std::int64_t> dimension = {}, markers_announced = {};
    std::optional<Block> elements = {}, points = {};
    std::vector<Block> markers = {};
    std::size_t parallel_markers = 0, foreign_blocks = 0;
    std::string first_foreign = {};

    [[nodiscard]] std::string place(std::string_view at) const { return line_place(name, text, at.data()); }
    [[nodiscard]] std::string end() const { return line_place(name, text, text.data() + text.size()); }
};

auto fail_at(const std::string& place, std::string what, std::string remedy = damaged) {
    return fail(ErrorKind::input, std::move(what), place, {}, std::move(remedy));
}

// ---------------------------------------------------------------- blocks

std::optional<std::int64_t> number_of(std::string_view word) {
    Words words{word.data(), word.data() + word.size()};
    std::int64_t value = 0;
    if (!read_number(words, value)) return std::nullopt;
    return value;
}

/// Walks through a file and notes where its blocks are.
class Index {
  public:
    Index(std::string_view text, std::string_view name) : lines_(text) {
        file_.name = std::string(name);
        file_.text = text;
    }

    Outcome<File> make() && {
        while (const auto line = lines_.next())
            if (auto done = take(*line); !done) return fail(std::move(done.error()));
        if (!lines_.ended())
            return fail_at(file_.end(), "the file ends within a line",
                           "it seems to be cut off; if it is whole, end its last line");
        if (!file_.dimension || !file_.elements || !file_.points)
            return fail_at(file_.end(), "the file has not all of NDIME, NELEM and NPOIN", damaged);
        const std::size_t markers = file_.markers.size() + file_.parallel_markers;
        if (!std::cmp_equal(file_.markers_announced.value_or(0), markers))
            return fail_at(file_.end(), "NMARK announces " + std::to_string(file_.markers_announced.value_or(0)) +
                                            " markers, but " + std::to_string(markers) + " follow");
        return std::move(file_);
    }

  private:
    Outcome<Done> take(std::string_view line) {
        const auto [key, value] = entry_of(line);
        if (key.empty()) return row_of_nothing(line);
        if (key == "MARKER_TAG") return marker(value);
        if (key == "NDIME") return single(line, value, file_.dimension);
        if (key == "NMARK") return single(line, value, file_.markers_announced);
        if (key == "NELEM") return block(line, value, file_.elements);
        if (key == "NPOIN") return block(line, value, file_.points);
        if (key == "NZONE") return zones(line, value);
        if (key == "IZONE") return Done{};
        if (file_.foreign_blocks++ == 0) file_.first_foreign = std::string(key.substr(0, 40));
        in_foreign_ = true;
        return Done{};
    }

    /// Blocks that Camber does not know have rows of their own; elsewhere a row that nothing announces is damage.
    Outcome<Done> row_of_nothing(std::string_view line) {
        if (in_foreign_) return Done{};
        return fail_at(file_.place(line), "is no keyword with =, and no row that was announced");
    }

    Outcome<Done> single(std::string_view line, std::string_view value, std::optional<std::int64_t>& into) {
        in_foreign_ = false;
        const auto number = number_of(value);
        if (!number) return fail_at(file_.place(line), "the number behind = is missing or malformed");
        if (into) return fail_at(file_.place(line), "comes a second time", "remove one, or give one zone");
        into = number;
        return Done{};
    }

    Outcome<Done> zones(std::string_view line, std::string_view value) {
        in_foreign_ = false;
        const auto number = number_of(value);
        if (number && *number == 1) return Done{};
        return fail(ErrorKind::unsupported, "holds several zones", file_.place(line), {}, "write a file for each zone");
    }

    /// Passes by so many rows.
    Outcome<Block> rows(std::string_view line, std::string_view value) {
        in_foreign_ = false;
        const auto number = number_of(value);
        if (!number || *number < 0) return fail_at(file_.place(line), "the number behind = is missing or malformed");
        const auto count = static_cast<std::uint64_t>(*number);
        if (count > lines_.left() / 2 + 1)
            return fail_at(file_.place(line), "announces " + std::to_string(count) + " rows, more than follow");
        if (count > max_entities)
            return fail(ErrorKind::unsupported, "has more rows than 32 bits can number", file_.place(line));
        Lines ahead = lines_;  // a marker SEND_RECEIVE has a line between its count and its rows
        if (const auto row = ahead.next(); row && entry_of(*row).key == "SEND_TO") lines_ = ahead;
        Block made{static_cast<std::size_t>(count), lines_};
        for (std::size_t i = 0; i < made.count; ++i) {
            const auto row = lines_.next();
            if (!row || row->find('=') != std::string_view::npos)
                return fail_at(row ? file_.place(*row) : file_.end(),
                               "row " + std::to_string(i + 1) + " of " + std::to_string(count) + " is missing");
        }
        return made;
    }

    Outcome<Done> block(std::string_view line, std::string_view value, std::optional<Block>& into) {
        if (into) return fail_at(file_.place(line), "comes a second time", "remove one, or give one zone");
        return rows(line, value).map([&](Block made) {
            into = std::move(made);
            return Done{};
        });
    }

    Outcome<Done> marker(std::string_view tag) {
        const auto line = lines_.next();
        if (!line || entry_of(*line).key != "MARKER_ELEMS")
            return fail_at(line ? file_.place(*line) : file_.end(), "MARKER_TAG is not followed by MARKER_ELEMS");
        return rows(*line, entry_of(*line).value).map([&](Block made) {
            made.tag = std::string(tag);
            if (tag == "SEND_RECEIVE")
                ++file_.parallel_markers;
            else
                file_.markers.push_back(std::move(made));
            return Done{};
        });
    }

    Lines lines_;
    File file_;
    bool in_foreign_ = false;
};

// ---------------------------------------------------------------- rows

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

std::string row_place(const File& file, Lines lines, std::size_t row) {
    std::optional<std::string_view> line;
    for (std::size_t i = 0; i <= row; ++i) line = lines.next();
    return line ? file.place(*line) : file.name;
}

/// Rows `type nodes… [index]`, behind those that are there; those that are no K-simplices are counted in `refused`.
template <int K>
Outcome<Done> read_simplices(const File& file, const Block& block, Reference reference, listing::Rows<K + 1>& into,
                             Refused& refused) {
    Lines lines = block.rows;
    for (std::size_t i = 0; i < block.count; ++i) {
        const std::string_view line = *lines.next();
        const auto bad_row = [&](const std::string& what) {
            return fail(ErrorKind::input, what, file.place(line), Entity{into.origin.noun, i + 1}, damaged);
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
        if (read < shape->nodes || words.find()) return bad_row("its row has not the numbers of its type");
        if (type != type_of<K>) {
            refused.count(shape->plural);
            continue;
        }
        std::array<VertexId, K + 1> simplex;
        for (std::size_t n = 0; n <= K; ++n)
            if (nodes[n] >= 0 && static_cast<std::uint64_t>(nodes[n]) <= max_entities)
                simplex[n] = VertexId(static_cast<std::size_t>(nodes[n]));
        into.nodes.push_back(simplex);
        into.references.push_back(reference);
    }
    return Done{};
}

template <int D>
Outcome<Buffer<Vec<D>>> read_points(const File& file, const Block& block) {
    Buffer<Vec<D>> points(block.count);
    Lines lines = block.rows;
    for (std::size_t i = 0; i < block.count; ++i) {
        const std::string_view line = *lines.next();
        Words words{line.data(), line.data() + line.size()};
        bool sound = true;
        for (int c = 0; c < D && sound; ++c) sound = read_number(words, points[i][c]);
        std::int64_t index = 0;
        if (sound && words.find()) sound = read_number(words, index) && !words.find();
        if (!sound)
            return fail(ErrorKind::input, "its row is not " + std::to_string(D) + " coordinates and perhaps an index",
                        file.place(line), Entity{"vertex", i + 1}, damaged);
    }
    return points;
}

/// References of markers: of the same name the same, else the next.
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

/// Facets are those of all markers behind one another: the place of each.
auto place_of_facets(const File& file) {
    return [&file](std::size_t row) {
        for (const Block& marker : file.markers) {
            if (row < marker.count) return row_place(file, marker.rows, row);
            row -= marker.count;
        }
        return file.name;
    };
}

template <int D>
Outcome<DecodedMesh> read_mesh(const File& file, std::vector<Notice> notices, const Execution& execution) {
    listing::Mesh<D> mesh;
    mesh.name = file.name;
    mesh.elements.straight.origin = {
        simplex_name<D>, {}, [&file](std::size_t row) { return row_place(file, file.elements->rows, row); }};
    mesh.facets.straight.origin = {simplex_name<D - 1>, {}, place_of_facets(file)};
    Refused refused;
    MarkerReferences<D> references{mesh.groups};
    auto done = read_simplices<D>(file, *file.elements, 0, mesh.elements.straight, refused);
    for (const Block& marker : file.markers)
        if (done) done = read_simplices<D - 1>(file, marker, references.of(marker.tag), mesh.facets.straight, refused);
    if (!done) return fail(std::move(done.error()));
    if (auto held = refused.verdict(file.name); !held) return fail(std::move(held.error()));
    auto points = read_points<D>(file, *file.points);
    if (!points) return fail(std::move(points.error()));
    mesh.points = std::move(*points);
    mesh.point_references = Buffer<Reference>(mesh.points.size(), 0);
    if (auto checked = listing::check(mesh, execution); !checked) return fail(std::move(checked.error()));
    return listing::assembled(std::move(mesh), listing::MidNodeKind::on_curve, std::move(notices), execution);
}

std::vector<Notice> notices_of(const File& file) {
    std::vector<Notice> notices;
    if (!file.markers_announced)  // Gmsh writes none where it has no groups; a file cut off there looks the same
        notices.push_back({"the file has no NMARK, and so no markers of the boundary"});
    if (file.parallel_markers > 0)
        notices.push_back({std::to_string(file.parallel_markers) + " markers SEND_RECEIVE were left out"});
    if (file.foreign_blocks > 0) {
        std::string first = file.first_foreign;
        for (char& c : first)  // noise must not reach a terminal as it is
            if (c < ' ' || c > '~') c = '?';
        notices.push_back(
            {std::to_string(file.foreign_blocks) + " other keywords were left out, the first of them " + first});
    }
    return notices;
}

Outcome<DecodedMesh> read(std::string_view text, std::string_view name, const Execution& execution) {
    const auto file = Index(text, name).make();
    if (!file) return fail(file.error());
    if (*file->dimension == 2) return read_mesh<2>(*file, notices_of(*file), execution);
    if (*file->dimension == 3) return read_mesh<3>(*file, notices_of(*file), execution);
    return fail(ErrorKind::input, "NDIME is " + std::to_string(*file->dimension) + ", not 2 or 3", file->name, {},
                damaged);
}

}  // namespace

}  // namespace su2

Outcome<DecodedMesh> decode_su2(std::span<const std::byte> bytes, std::string_view name, const Execution& execution) {
    return guarded([&] { return su2::read(su2::text_of(bytes), name, execution); });
}

bool is_su2(std::span<const std::byte> bytes) {
    constexpr std::size_t soon = 65536;  // after comments
    const auto line = su2::Lines(su2::text_of(bytes.first(bytes.size() < soon ? bytes.size() : soon))).next();
    if (!line) return false;
    const std::string_view key = su2::entry_of(*line).key;
    for (const std::string_view first : {"NDIME", "NZONE", "NELEM", "NPOIN", "NMARK"})
        if (key == first) return true;
    return false;
}

}  // namespace camber
